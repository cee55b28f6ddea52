/* The error record, checked allocation, and byte strings that grow. */
#include "base/base.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* ---- The error record ---- */

/* Names of files and words from a pipe's head get into messages, and messages onto terminals: no control byte may. */
static void make_printable(char *message) {
    for (char *c = message; *c; c++)
        if (((unsigned char)*c < 0x20 && *c != '\n') || *c == 0x7f) *c = '?';
    size_t length = strlen(message);
    while (length > 0 && message[length - 1] == '\n')
        message[--length] = '\0';
}

/* A message that was cut off must not end within a UTF-8 sequence. */
static void drop_partial_character(char *message, size_t length) {
    size_t start = length;
    while (start > 0 && length - start < 4) {
        unsigned char c = (unsigned char)message[--start];
        if ((c & 0xc0) == 0x80) continue; /* a continuation byte: the sequence began further left */
        size_t wanted = c >= 0xf0 ? 4 : c >= 0xe0 ? 3 : c >= 0xc0 ? 2 : 1;
        if (length - start < wanted) message[start] = '\0';
        return;
    }
}

hdr_status hdr_fail(hdr_error *err, hdr_status status, const char *format, ...) {
    if (!err || err->status != HDR_OK) return status;
    err->status = status;
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(err->message, sizeof err->message, format, arguments);
    va_end(arguments);
    if (length < 0)
        err->message[0] = '\0';
    else if ((size_t)length >= sizeof err->message)
        drop_partial_character(err->message, sizeof err->message - 1);
    make_printable(err->message);
    return status;
}

hdr_status hdr_fail_in(hdr_error *err, const char *prefix) {
    if (!err) return HDR_INTERNAL;
    if (err->status == HDR_OK) return HDR_OK;
    char old[sizeof err->message];
    memcpy(old, err->message, sizeof old);
    int length = snprintf(err->message, sizeof err->message, "%s: %s", prefix, old);
    if (length < 0)
        memcpy(err->message, old, sizeof old);
    else if ((size_t)length >= sizeof err->message)
        drop_partial_character(err->message, sizeof err->message - 1);
    make_printable(err->message);
    return err->status;
}

/* ---- Memory ---- */

/* No object is larger than pointers into it can be apart. */
static bool too_large(size_t count, size_t size) {
    return size != 0 && count > (size_t)PTRDIFF_MAX / size;
}

void *hdr_alloc(size_t count, size_t size) {
    if (too_large(count, size)) return NULL;
    size_t bytes = count * size;
    return calloc(bytes ? bytes : 1, 1);
}

void *hdr_grow(void *old, size_t count, size_t size) {
    if (too_large(count, size)) return NULL;
    size_t bytes = count * size;
    return realloc(old, bytes ? bytes : 1);
}

#define HUGE_PAGE ((size_t)1 << 21)

/* The size that is mapped for a request: whole pages, and whole huge pages where there is at least one. 0: too much. */
static size_t mapped_size(size_t bytes) {
    size_t unit = bytes >= HUGE_PAGE ? HUGE_PAGE : (size_t)1 << 16;
    if (bytes > SIZE_MAX / 2) return 0;
    return bytes ? (bytes + unit - 1) / unit * unit : unit;
}

void *hdr_alloc_pages(size_t bytes) {
    size_t size = mapped_size(bytes);
    if (size == 0) return NULL;
    /* The kernel uses huge pages only for aligned ranges: map one more than needed, and give back what stands over. */
    size_t spare = size >= HUGE_PAGE ? HUGE_PAGE : 0;
    unsigned char *start = mmap(NULL, size + spare, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (start == MAP_FAILED) return NULL;
    if (spare == 0) return start;
    size_t before = (HUGE_PAGE - (size_t)((uintptr_t)start % HUGE_PAGE)) % HUGE_PAGE;
    if (before > 0) munmap(start, before);
    if (spare > before) munmap(start + before + size, spare - before);
#ifdef MADV_HUGEPAGE
    /* Only a wish: a kernel without huge pages gives small ones. */
    (void)madvise(start + before, size, MADV_HUGEPAGE);
#endif
    return start + before;
}

void hdr_free_pages(void *pages, size_t bytes) {
    if (pages) munmap(pages, mapped_size(bytes));
}

/* The number in a control group's memory.max; no file, or "max": no limit. */
static uint64_t group_limit(const char *group) {
    char path[4200], text[32];
    int length = snprintf(path, sizeof path, "/sys/fs/cgroup%s/memory.max", group);
    if (length < 0 || (size_t)length >= sizeof path) return UINT64_MAX;
    FILE *file = fopen(path, "re");
    if (!file) return UINT64_MAX;
    uint64_t limit = UINT64_MAX;
    if (fgets(text, sizeof text, file) && text[0] >= '0' && text[0] <= '9') limit = strtoull(text, NULL, 10);
    fclose(file);
    return limit;
}

/* The smallest limit of the control group (version 2) that this process runs in and of those around it. */
static uint64_t control_group_memory(void) {
    char line[4100];
    uint64_t least = group_limit("");
    FILE *file = fopen("/proc/self/cgroup", "re");
    if (!file) return least;
    while (fgets(line, sizeof line, file)) {
        if (strncmp(line, "0::/", 4) != 0) continue;
        char *group = line + 3;
        group[strcspn(group, "\n")] = '\0';
        for (char *slash; (slash = strrchr(group, '/')) != NULL; *slash = '\0') {
            uint64_t limit = group_limit(group);
            least = limit < least ? limit : least;
        }
        break;
    }
    fclose(file);
    return least;
}

uint64_t hdr_memory_default(void) {
    long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    uint64_t physical = pages > 0 && page > 0 ? (uint64_t)pages * (uint64_t)page : (uint64_t)1 << 30;
    uint64_t group = control_group_memory();
    return (group < physical ? group : physical) / 2;
}

/* ---- Byte strings ---- */

hdr_status hdr_bytes_reserve(hdr_bytes *bytes, size_t room, hdr_error *err) {
    if (room <= bytes->room) return HDR_OK;
    /* Half as much again, so that a long series of small additions costs little. */
    size_t wanted = bytes->room <= SIZE_MAX / 3 * 2 ? bytes->room + bytes->room / 2 : room;
    if (wanted < room) wanted = room;
    if (wanted < 64) wanted = 64;
    unsigned char *data = hdr_grow(bytes->data, wanted, 1);
    if (!data) return hdr_fail(err, HDR_INTERNAL, "out of memory (%zu bytes)", wanted);
    bytes->data = data;
    bytes->room = wanted;
    return HDR_OK;
}

hdr_status hdr_bytes_add(hdr_bytes *bytes, const void *data, size_t size, hdr_error *err) {
    if (size == 0) return HDR_OK;
    if (size > SIZE_MAX - bytes->size) return hdr_fail(err, HDR_INTERNAL, "out of memory (%zu bytes more)", size);
    hdr_status status = hdr_bytes_reserve(bytes, bytes->size + size, err);
    if (status != HDR_OK) return status;
    memcpy(bytes->data + bytes->size, data, size);
    bytes->size += size;
    return HDR_OK;
}

hdr_status hdr_bytes_printf(hdr_bytes *bytes, hdr_error *err, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    if (length < 0) return hdr_fail(err, HDR_INTERNAL, "text could not be formatted (%s)", strerror(errno));
    /* One byte more than the text: vsnprintf ends it with NUL, which does not count. */
    if ((size_t)length >= SIZE_MAX - bytes->size)
        return hdr_fail(err, HDR_INTERNAL, "out of memory (%d bytes more)", length);
    hdr_status status = hdr_bytes_reserve(bytes, bytes->size + (size_t)length + 1, err);
    if (status != HDR_OK) return status;
    va_start(arguments, format);
    vsnprintf((char *)bytes->data + bytes->size, (size_t)length + 1, format, arguments);
    va_end(arguments);
    bytes->size += (size_t)length;
    return HDR_OK;
}

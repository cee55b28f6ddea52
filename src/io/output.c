/* Outputs: a temporary file that takes its name at commit, or memory that is held until then. */
#include "io/output.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    SYMLINKS_MAX = 40, /* as the kernel's own limit */
    TEMPORARY_TRIES = 100,
    TEMPORARY_BASE_MAX =
        200, /* bytes of the target's name that go into the temporary's, below NAME_MAX with the rest */
    TEMPORARY_NAMES = 64
};

/* Address space that is reserved at first; pages come into being as they are written to. */
static const size_t reserve_first = (size_t)1 << 30, huge_page = (size_t)2 << 20;

/* Bytes held until commit. All that lies beyond size and below dirty may be other than zero. */
typedef struct held_bytes {
    unsigned char *data;
    size_t size, room, dirty;
    bool huge;
} held_bytes;

struct hdr_output {
    char *name;      /* for messages */
    char *target;    /* the file's name, symbolic links followed; NULL: the bytes are held */
    char *temporary; /* what it is called until commit; NULL: there is none (any more) */
    int slot;        /* where temporary stands in temporary_names, or -1 */
    int descriptor;  /* of the temporary file, or where held bytes go at commit; -1: memory only */
    bool owns_descriptor;
    bool committed;
    held_bytes held;
    bool takes_pixels, has_alpha;
    hdr_planes pixels; /* planes: 0 until the sink has told; what it points to is found at commit */
};

/* ---- Names that a signal handler removes ----------------------------------------------------------------------------
 */

/* Who exchanges an entry for NULL owns the string: either its output, or the handler (which cannot free it). */
static _Atomic(char *) temporary_names[TEMPORARY_NAMES];

void hdr_output_remove_temporary(void) {
    int saved = errno;
    for (int i = 0; i < TEMPORARY_NAMES; i++) {
        char *name = atomic_exchange(&temporary_names[i], NULL);
        if (name) (void)unlink(name); /* nothing more can be done about it in a handler */
    }
    errno = saved;
}

/* Returns the slot, or -1 when all are taken: then a signal leaves the (hidden) file behind. */
static int announce_temporary(char *name) {
    for (int i = 0; i < TEMPORARY_NAMES; i++) {
        char *nobody = NULL;
        if (atomic_compare_exchange_strong(&temporary_names[i], &nobody, name)) return i;
    }
    return -1;
}

/* Takes the name out of the table and frees it, unless the handler has it. */
static void withdraw_temporary(hdr_output *output) {
    char *name = output->temporary;
    if (output->slot < 0 || atomic_compare_exchange_strong(&temporary_names[output->slot], &name, NULL))
        free(output->temporary);
    output->temporary = NULL;
    output->slot = -1;
}

/* ---- Held bytes -----------------------------------------------------------------------------------------------------
 */

/* Only once a picture has outgrown one huge page: a small one should not pay for clearing it. All of the space, since
 * what is split cannot be extended. Nothing but speed depends on it. */
static void ask_for_huge_pages(held_bytes *held) {
    (void)madvise(held->data, held->room, MADV_HUGEPAGE);
    held->huge = true;
}

/* Reserves address space for at least size bytes, and generously where the process may have that much. */
static bool held_reserve(held_bytes *held, size_t size) {
    size_t room = size > reserve_first ? size : reserve_first;
    for (;;) {
        void *data = mmap(NULL, room, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
        if (data != MAP_FAILED) {
            *held = (held_bytes){.data = data, .room = room};
            return true;
        }
        if (room == size) return false;
        room = room / 2 > size ? room / 2 : size;
    }
}

/* Growing moves page tables, not bytes. */
static bool held_extend(held_bytes *held, size_t size) {
    size_t room = held->room <= SIZE_MAX / 2 && held->room * 2 > size ? held->room * 2 : size;
    void *data = mremap(held->data, held->room, room, MREMAP_MAYMOVE);
    if (data == MAP_FAILED && room != size) {
        room = size;
        data = mremap(held->data, held->room, room, MREMAP_MAYMOVE);
    }
    if (data == MAP_FAILED) return false;
    held->data = data;
    held->room = room;
    return true;
}

static hdr_status held_write(hdr_output *output, const void *data, size_t size, size_t offset, hdr_error *err) {
    held_bytes *held = &output->held;
    size_t end = offset + size;
    if (end > held->room && !(held->data ? held_extend(held, end) : held_reserve(held, end)))
        return hdr_fail(err, HDR_INTERNAL, "%s: out of memory: %zu bytes would have to be held", output->name, end);
    if (offset > held->size && held->dirty > held->size) {
        size_t stale = offset < held->dirty ? offset : held->dirty;
        memset(held->data + held->size, 0, stale - held->size);
    }
    if (end > huge_page && !held->huge) ask_for_huge_pages(held);
    memcpy(held->data + offset, data, size);
    if (end > held->size) held->size = end;
    if (end > held->dirty) held->dirty = end;
    return HDR_OK;
}

/* ---- Descriptors ----------------------------------------------------------------------------------------------------
 */

static hdr_status io_failed(const hdr_output *output, hdr_error *err) {
    return hdr_fail(err, HDR_IO, "%s: %s", output->name, strerror(errno));
}

static hdr_status cannot_create(const char *name, hdr_error *err) {
    return hdr_fail(err, HDR_CANT_CREATE, "%s: cannot create: %s", name, strerror(errno));
}

/* Writes all held bytes in sequence. A descriptor that does not block (a pipe that its maker set up so) is waited for.
 */
static hdr_status write_held(const hdr_output *output, hdr_error *err) {
    const unsigned char *data = output->held.data;
    size_t left = output->held.size;
    while (left > 0) {
        ssize_t count = write(output->descriptor, data, left);
        if (count >= 0) {
            data += count;
            left -= (size_t)count;
        } else if (errno == EAGAIN) {
            struct pollfd writable = {.fd = output->descriptor, .events = POLLOUT};
            if (poll(&writable, 1, -1) < 0 && errno != EINTR) return io_failed(output, err);
        } else if (errno != EINTR) {
            return io_failed(output, err);
        }
    }
    return HDR_OK;
}

static hdr_status write_at(const hdr_output *output, const void *bytes, size_t size, uint64_t offset, hdr_error *err) {
    const unsigned char *data = bytes;
    while (size > 0) {
        ssize_t count = pwrite(output->descriptor, data, size, (off_t)offset);
        if (count < 0 && errno != EINTR) return io_failed(output, err);
        if (count > 0) {
            data += count;
            offset += (uint64_t)count;
            size -= (size_t)count;
        }
    }
    return HDR_OK;
}

/* The descriptor is gone in any case, so that an interrupted close is not repeated. */
static hdr_status close_descriptor(hdr_output *output, hdr_error *err) {
    int descriptor = output->descriptor;
    output->descriptor = -1;
    if (output->owns_descriptor && close(descriptor) != 0 && errno != EINTR) return io_failed(output, err);
    return HDR_OK;
}

/* ---- Files by name --------------------------------------------------------------------------------------------------
 */

/* The length of path up to and including its last slash. */
static size_t directory_length(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

/* Replaces a symbolic link's path by the path that it holds, which counts from the link's directory. False: no memory.
 */
static bool replace_by_link(char **path, const char *link) {
    size_t directory = link[0] == '/' ? 0 : directory_length(*path);
    size_t length = strlen(link);
    char *joined = hdr_alloc(directory + length + 1, 1);
    if (!joined) return false;
    memcpy(joined, *path, directory);
    memcpy(joined + directory, link, length + 1);
    free(*path);
    *path = joined;
    return true;
}

/* Follows symbolic links in the last component, also to a file that is not there yet. NULL with errno set on failure.
 */
static char *follow_links(const char *path) {
    char *followed = strdup(path);
    for (int links = 0; followed; links++) {
        char link[PATH_MAX + 1];
        ssize_t length = readlink(followed, link, PATH_MAX);
        if (length < 0 && (errno == EINVAL || errno == ENOENT)) return followed;
        if (length >= 0 && links < SYMLINKS_MAX) {
            link[length] = '\0';
            if (replace_by_link(&followed, link)) continue;
            errno = ENOMEM;
        } else if (length >= 0) {
            errno = ELOOP;
        }
        int saved = errno;
        free(followed);
        errno = saved;
        return NULL;
    }
    return NULL;
}

/* The target's name between a dot and a random number, in the same directory. NULL with errno set. */
static char *temporary_name(const char *target) {
    uint64_t random;
    if (getrandom(&random, sizeof random, 0) != (ssize_t)sizeof random) return NULL;
    size_t directory = directory_length(target);
    char *name = NULL;
    if (asprintf(&name, "%.*s.%.*s.%016llx", (int)directory, target, TEMPORARY_BASE_MAX, target + directory,
                 (unsigned long long)random) < 0)
        return NULL;
    return name;
}

/* Opened with 0666, so that the kernel applies the umask, or the directory's default access list. The name is announced
 * before the file exists, so that no signal comes in between. */
static hdr_status create_temporary(hdr_output *output, hdr_error *err) {
    for (int i = 0; i < TEMPORARY_TRIES; i++) {
        output->temporary = temporary_name(output->target);
        if (!output->temporary) return cannot_create(output->name, err);
        output->slot = announce_temporary(output->temporary);
        output->descriptor = open(output->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOCTTY, 0666);
        if (output->descriptor >= 0) {
            output->owns_descriptor = true;
            return HDR_OK;
        }
        int saved = errno;
        withdraw_temporary(output);
        errno = saved;
        if (errno != EEXIST) break;
    }
    return cannot_create(output->name, err);
}

/* The new file gets the permissions of the one that it replaces. */
static hdr_status keep_mode(hdr_output *output, const struct stat *old, hdr_error *err) {
    struct stat now;
    if (fstat(output->descriptor, &now) != 0) return cannot_create(output->name, err);
    mode_t mode = old->st_mode & 0777;
    if ((now.st_mode & 0777) != mode && fchmod(output->descriptor, mode) != 0) return cannot_create(output->name, err);
    return HDR_OK;
}

/* For a device or FIFO, or a file that has no name any more (/dev/stdout of a deleted file): what cannot be replaced.
 */
static hdr_status open_directly(hdr_output *output, const char *path, hdr_error *err) {
    output->descriptor = open(path, O_WRONLY | O_TRUNC | O_CLOEXEC | O_NOCTTY);
    if (output->descriptor < 0) return cannot_create(output->name, err);
    output->owns_descriptor = true;
    if (isatty(output->descriptor))
        return hdr_fail(err, HDR_USAGE, "%s is a terminal: give -o FILE, or redirect", output->name);
    return HDR_OK;
}

static hdr_status open_path(hdr_output *output, const char *path, hdr_error *err) {
    struct stat old, same;
    bool exists = stat(path, &old) == 0;
    if (path[0] == '\0' || (!exists && errno != ENOENT)) return cannot_create(output->name, err);
    if (exists && !S_ISREG(old.st_mode)) return open_directly(output, path, err);
    output->target = follow_links(path);
    if (!output->target) return cannot_create(output->name, err);
    if (exists && stat(output->target, &same) != 0) {
        free(output->target);
        output->target = NULL;
        return open_directly(output, path, err);
    }
    /* Renaming over it would not ask; a file that is write-protected is meant to stay. */
    if (exists && faccessat(AT_FDCWD, output->target, W_OK, AT_EACCESS) != 0) return cannot_create(output->name, err);
    hdr_status status = create_temporary(output, err);
    if (status == HDR_OK && exists) status = keep_mode(output, &old, err);
    return status;
}

/* ---- The interface --------------------------------------------------------------------------------------------------
 */

static hdr_output *output_new(const char *name, hdr_error *err) {
    hdr_output *output = hdr_alloc(1, sizeof *output);
    if (output) {
        output->slot = output->descriptor = -1;
        output->name = strdup(name);
    }
    if (!output || !output->name) {
        hdr_fail(err, HDR_INTERNAL, "%s: out of memory", name);
        hdr_output_free(output);
        return NULL;
    }
    return output;
}

hdr_output *hdr_output_open(const char *path, hdr_error *err) {
    hdr_output *output = output_new(path, err);
    if (output && open_path(output, path, err) != HDR_OK) {
        hdr_output_free(output);
        return NULL;
    }
    return output;
}

hdr_output *hdr_output_descriptor(int descriptor, const char *name, hdr_error *err) {
    int flags = fcntl(descriptor, F_GETFL);
    if (flags >= 0 && (flags & O_ACCMODE) == O_RDONLY) {
        flags = -1;
        errno = EBADF;
    }
    if (flags < 0) {
        cannot_create(name, err);
        return NULL;
    }
    if (isatty(descriptor)) {
        hdr_fail(err, HDR_USAGE, "%s is a terminal: give -o FILE, or redirect", name);
        return NULL;
    }
    hdr_output *output = output_new(name, err);
    if (output) output->descriptor = descriptor;
    return output;
}

hdr_output *hdr_output_memory(hdr_error *err) {
    return output_new("memory", err);
}

hdr_output *hdr_output_planes(hdr_error *err) {
    hdr_output *output = output_new("memory", err);
    if (output) output->takes_pixels = true;
    return output;
}

bool hdr_output_takes_pixels(const hdr_output *output) {
    return output->takes_pixels;
}

void hdr_output_describe(hdr_output *output, int width, int height, int planes, bool alpha) {
    output->pixels = (hdr_planes){.width = width, .height = height, .planes = planes};
    output->has_alpha = alpha;
}

const hdr_planes *hdr_output_pixels(const hdr_output *output) {
    return output->committed && output->pixels.planes > 0 ? &output->pixels : NULL;
}

const char *hdr_output_name(const hdr_output *output) {
    return output->name;
}

const void *hdr_output_bytes(const hdr_output *output, size_t *size) {
    bool whole = output->committed && !output->target;
    *size = whole ? output->held.size : 0;
    return whole ? output->held.data : NULL;
}

hdr_status hdr_output_write(hdr_output *output, const void *data, size_t size, uint64_t offset, hdr_error *err) {
    if (output->committed) return hdr_fail(err, HDR_INTERNAL, "%s: written to after it was finished", output->name);
    if (offset > INT64_MAX || size > INT64_MAX - offset)
        return hdr_fail(err, HDR_IO, "%s: %s", output->name, strerror(EFBIG));
    if (size == 0) return HDR_OK;
    if (output->target) return write_at(output, data, size, offset, err);
    return held_write(output, data, size, (size_t)offset, err);
}

hdr_status hdr_output_restart(hdr_output *output, hdr_error *err) {
    output->held.size = 0;
    if (output->target && ftruncate(output->descriptor, 0) != 0) return io_failed(output, err);
    return HDR_OK;
}

hdr_status hdr_output_fill(hdr_output *output, const void *bytes, size_t size, hdr_error *err) {
    hdr_status status = hdr_output_write(output, bytes, size, 0, err);
    return status == HDR_OK ? hdr_output_commit(output, err) : status;
}

static hdr_status commit_file(hdr_output *output, hdr_error *err) {
    hdr_status status = close_descriptor(output, err);
    if (status != HDR_OK) return status;
    if (rename(output->temporary, output->target) != 0) return cannot_create(output->name, err);
    withdraw_temporary(output);
    return HDR_OK;
}

/* Held bytes do not move any more. */
static void find_pixels(hdr_output *output) {
    hdr_planes *pixels = &output->pixels;
    const float *at = (const float *)(const void *)output->held.data;
    size_t count = (size_t)pixels->width * (size_t)pixels->height;
    for (int p = 0; p < pixels->planes; p++, at += count)
        pixels->plane[p] = at;
    if (output->has_alpha) pixels->alpha = at;
}

static hdr_status commit_held(hdr_output *output, hdr_error *err) {
    find_pixels(output);
    if (output->descriptor < 0) return HDR_OK;
    hdr_status status = write_held(output, err);
    return status == HDR_OK ? close_descriptor(output, err) : status;
}

hdr_status hdr_output_commit(hdr_output *output, hdr_error *err) {
    if (output->committed) return HDR_OK;
    hdr_status status = output->target ? commit_file(output, err) : commit_held(output, err);
    output->committed = status == HDR_OK;
    return status;
}

void hdr_output_free(hdr_output *output) {
    if (!output) return;
    if (output->owns_descriptor && output->descriptor >= 0)
        (void)close(output->descriptor); /* only what was not committed: its content does not matter any more */
    if (output->temporary) {
        (void)unlink(output->temporary); /* gone already if a signal handler was faster */
        withdraw_temporary(output);
    }
    if (output->held.data) (void)munmap(output->held.data, output->held.room);
    free(output->target);
    free(output->name);
    free(output);
}

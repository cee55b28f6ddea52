/* Opens, forwards and closes inputs of every kind. */
#include "check.h"
#include "io/source.h"
#include "pipes.h"

#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <time.h>

#define MEMORY ((uint64_t)1 << 20)

enum { PATH_BYTES = 32 };

/* A file that is gone when it is closed; while it is open it can be opened again by path. */
static int new_file(char path[PATH_BYTES]) {
    int descriptor = memfd_create("test_input", 0);
    snprintf(path, PATH_BYTES, "/proc/self/fd/%d", descriptor);
    return descriptor;
}

/* Takes what arrives at a descriptor until its end, in a thread. */
typedef struct drain {
    int from;
    file_bytes got;
} drain;

static void *take_all(void *argument) {
    drain *d = argument;
    unsigned char buffer[4096];
    ssize_t count;
    while ((count = read(d->from, buffer, sizeof buffer)) > 0)
        write_memory(NULL, &d->got, buffer, (uint64_t)count, d->got.size, NULL);
    close(d->from);
    return NULL;
}

static void check_forwarded(hdr_input *input, const file_bytes *file, size_t skip, const char *name) {
    hdr_error error = {.status = HDR_OK};
    int ends[2];
    pthread_t thread;
    unsigned char start[100];
    if (pipe(ends) != 0) abort();
    drain d = {.from = ends[0]};
    CHECK(hdr_input_read(input, start, sizeof start, 0, &error) == sizeof start, "%s", error.message);
    hdr_input_skip(input, skip);
    if (pthread_create(&thread, NULL, take_all, &d) != 0) abort();
    CHECK(hdr_input_forward(input, ends[1], &error) == HDR_OK, "%s: %s", name, error.message);
    close(ends[1]);
    pthread_join(thread, NULL);
    CHECK(d.got.size == file->size - skip && memcmp(d.got.data, file->data + skip, d.got.size) == 0,
          "%s: other bytes arrived: %zu of %zu", name, d.got.size, file->size - skip);
    free(d.got.data);
}

static void check_forwarding(const file_bytes *file, const char *path) {
    hdr_error error = {.status = HDR_OK};
    int from;
    hdr_input *input = hdr_input_open(path, &error);
    check_forwarded(input, file, 11, "file to pipe");
    hdr_input_free(input);
    input = hdr_input_memory(file->data, file->size, "memory", &error);
    check_forwarded(input, file, 5, "memory to pipe");
    hdr_input_free(input);
    pid_t writer = start_writer(file, false, &from);
    input = open_descriptor(from, &error);
    check_forwarded(input, file, 33, "pipe to pipe");
    hdr_input_free(input);
    end_writer(writer);

    int ends[2];
    signal(SIGPIPE, SIG_IGN);
    if (pipe(ends) != 0) abort();
    close(ends[0]);
    input = hdr_input_open(path, &error);
    CHECK(hdr_input_forward(input, ends[1], &error) == HDR_IO && strcmp(error.message, "broken pipe") == 0,
          "a closed pipe: %d %s", error.status, error.message);
    signal(SIGPIPE, SIG_DFL);
    close(ends[1]);
    hdr_input_free(input);
}

/* To a regular file; appending is what sendfile refuses, so that bytes go by way of memory. */
static void check_to_file(hdr_input *input, const file_bytes *file, int flags, const char *name) {
    hdr_error error = {.status = HDR_OK};
    char path[PATH_BYTES];
    int made = new_file(path), to = open(path, O_WRONLY | flags);
    unsigned char *got = malloc(file->size + 1);
    CHECK(made >= 0 && to >= 0 && got != NULL, "%s: no file to write to", path);
    CHECK(hdr_input_forward(input, to, &error) == HDR_OK, "%s: %s", name, error.message);
    CHECK(read(made, got, file->size + 1) == (ssize_t)file->size && memcmp(got, file->data, file->size) == 0,
          "%s: other bytes arrived", name);
    close(to);
    close(made);
    free(got);
    hdr_input_free(input);
}

static void check_forwarding_to_files(const file_bytes *file, const char *path) {
    hdr_error error = {.status = HDR_OK};
    int from;
    check_to_file(hdr_input_open(path, &error), file, 0, "file to file");
    check_to_file(hdr_input_open(path, &error), file, O_APPEND, "file appended to file");
    pid_t writer = start_writer(file, false, &from);
    check_to_file(open_descriptor(from, &error), file, 0, "pipe to file");
    end_writer(writer);
    writer = start_writer(file, false, &from);
    check_to_file(open_descriptor(from, &error), file, O_APPEND, "pipe appended to file");
    end_writer(writer);
}

/* A file as standard input, of which another program has read the beginning. */
static void check_standard_input(const file_bytes *file, const char *path) {
    enum { READ_BEFORE = 7, SKIPPED = 3 };
    hdr_error error = {.status = HDR_OK};
    unsigned char bytes[20];
    int kept = dup(STDIN_FILENO), descriptor = open(path, O_RDONLY);
    if (dup2(descriptor, STDIN_FILENO) < 0) abort();
    lseek(STDIN_FILENO, READ_BEFORE, SEEK_SET);
    hdr_input *input = hdr_input_open("-", &error);
    CHECK(input && hdr_input_size(input) == (int64_t)file->size - READ_BEFORE, "%s", error.message);
    if (input) {
        hdr_input_skip(input, SKIPPED);
        CHECK(hdr_input_read(input, bytes, sizeof bytes, 2, &error) == sizeof bytes &&
                  memcmp(bytes, file->data + READ_BEFORE + SKIPPED + 2, sizeof bytes) == 0,
              "standard input: other bytes: %s", error.message);
        CHECK(hdr_input_read(input, bytes, sizeof bytes, file->size - READ_BEFORE - SKIPPED - 4, &error) == 4,
              "standard input: another end");
        CHECK(lseek(STDIN_FILENO, 0, SEEK_CUR) == READ_BEFORE, "standard input was moved");
        CHECK(strcmp(hdr_input_name(input), "standard input") == 0, "named %s", hdr_input_name(input));
    }
    hdr_input_free(input);
    if (kept >= 0) dup2(kept, STDIN_FILENO);
    close(kept);
    close(descriptor);
}

/* Freed while the reading thread waits for a writer that has nothing more to say. */
static void check_end_while_waiting(const file_bytes *file) {
    hdr_error error = {.status = HDR_OK};
    int from;
    unsigned char byte;
    pid_t writer = start_writer(file, true, &from);
    hdr_input *input = open_descriptor(from, &error);
    CHECK(input && hdr_input_read(input, &byte, 1, file->size - 1, &error) == 1 && byte == file->data[file->size - 1],
          "the last byte: %s", error.message);
    struct timespec before, after;
    clock_gettime(CLOCK_MONOTONIC, &before);
    hdr_input_free(input);
    clock_gettime(CLOCK_MONOTONIC, &after);
    CHECK(after.tv_sec - before.tv_sec < 5, "closing waited for the writer");
    end_writer(writer);
}

static void check_refused_bytes(const char *bytes, size_t size, const char *words) {
    hdr_error error = {.status = HDR_OK};
    hdr_input *input = hdr_input_memory(bytes, size, "strange", &error);
    CHECK(!hdr_source_open(input, &(hdr_reading){.memory = MEMORY}, &error) && error.status == HDR_BAD_DATA &&
              strstr(error.message, words) && strncmp(error.message, "strange: ", 9) == 0,
          "%s: %s", words, error.message);
    hdr_input_free(input);
}

static void check_refusals(void) {
    check_refused_bytes("", 0, "no data");
    check_refused_bytes("\x76\x2f", 2, "ends within");
    check_refused_bytes("\x89PNG\r\n\x1a\n1234", 12, "PNG");
    check_refused_bytes("\xff\xd8\xff\xe0", 4, "JPEG");
    check_refused_bytes("#?RADIANCE\n", 11, "ends within");
    check_refused_bytes("what\n is this", 13, "begins with \"what\\x0a is\"");
    hdr_error error = {.status = HDR_OK};
    CHECK(!hdr_input_open("no such file", &error) && error.status == HDR_NO_INPUT, "missing: %s", error.message);
    error.status = HDR_OK;
    CHECK(!hdr_input_open(".", &error) && error.status == HDR_NO_INPUT, "directory: %s", error.message);
}

int main(void) {
    enum { SIZE = 700001 };
    char path[PATH_BYTES];
    uint64_t random_state = 1;
    file_bytes file = {malloc(SIZE), SIZE};
    int descriptor = new_file(path);
    if (!file.data || descriptor < 0) abort();
    alarm(120); /* a pipe that is waited for in vain */
    for (size_t i = 0; i < SIZE; i++)
        file.data[i] = (unsigned char)random_bits(&random_state);
    CHECK(write(descriptor, file.data, SIZE) == SIZE, "%s: cannot be written", path);
    check_refusals();
    check_forwarding(&file, path);
    check_forwarding_to_files(&file, path);
    check_standard_input(&file, path);
    check_end_while_waiting(&file);
    close(descriptor);
    free(file.data);
    return check_done("test_input");
}

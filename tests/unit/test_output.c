/* What outputs promise: a file appears whole or not at all, under the right name, with the right permissions; faults
 * are told apart; nothing is left behind. */
#include "check.h"
#include "io/output.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* ---- Files ---- */

/* The number of entries of the working directory whose name begins with prefix ("": all). */
static int count_entries(const char *prefix) {
    DIR *directory = opendir(".");
    int count = 0;
    for (struct dirent *entry; (entry = readdir(directory)) != NULL;)
        count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0 &&
                 strncmp(entry->d_name, prefix, strlen(prefix)) == 0;
    closedir(directory);
    return count;
}

static bool file_is(const char *path, const char *text) {
    char content[256] = "";
    FILE *file = fopen(path, "rb");
    if (!file) return false;
    size_t size = fread(content, 1, sizeof content - 1, file);
    fclose(file);
    return size == strlen(text) && memcmp(content, text, size) == 0;
}

static void make_file(const char *path, const char *text, mode_t mode) {
    FILE *file = fopen(path, "wb");
    bool good = file && fputs(text, file) >= 0;
    good = file && fclose(file) == 0 && good && chmod(path, mode) == 0;
    CHECK(good, "cannot make %s", path);
}

static mode_t mode_of(const char *path) {
    struct stat about;
    return stat(path, &about) == 0 ? about.st_mode & 07777 : 0;
}

static hdr_status write_text(hdr_output *output, const char *text, hdr_error *err) {
    return hdr_output_write(output, text, strlen(text), 0, err);
}

/* Opens, writes, commits and frees. */
static hdr_status put_text(const char *path, const char *text) {
    hdr_error err = {0};
    hdr_output *output = hdr_output_open(path, &err);
    if (output && write_text(output, text, &err) == HDR_OK) (void)hdr_output_commit(output, &err);
    hdr_output_free(output);
    return err.status;
}

/* ---- Names ---- */

static void test_whole_or_nothing(void) {
    hdr_error err = {0};
    hdr_output *output = hdr_output_open("a.png", &err);
    CHECK(output && strcmp(hdr_output_name(output), "a.png") == 0, "open: %s", err.message);
    CHECK(write_text(output, "new", &err) == HDR_OK, "write: %s", err.message);
    CHECK(access("a.png", F_OK) != 0 && count_entries(".a.png.") == 1, "the name before commit");
    hdr_output_free(output);
    CHECK(count_entries("") == 0, "something is left behind");

    make_file("a.png", "old", 0640);
    output = hdr_output_open("a.png", &err);
    CHECK(output && write_text(output, "new", &err) == HDR_OK && file_is("a.png", "old"), "the old file before commit");
    hdr_output_free(output);
    CHECK(file_is("a.png", "old") && count_entries("") == 1, "the old file without commit");

    CHECK(put_text("a.png", "new") == HDR_OK && file_is("a.png", "new"), "the new file");
    CHECK(mode_of("a.png") == 0640, "mode of the file replaced: %o", mode_of("a.png"));
    CHECK(count_entries("") == 1, "temporary file after commit");
    unlink("a.png");
}

static void test_permissions(void) {
    mode_t old = umask(027);
    CHECK(put_text("m", "x") == HDR_OK && mode_of("m") == 0640, "mode %o with umask 027", mode_of("m"));
    umask(0);
    unlink("m");
    CHECK(put_text("m", "x") == HDR_OK && mode_of("m") == 0666, "mode %o with umask 0", mode_of("m"));
    umask(old);
    chmod("m", 0444);
    hdr_status status = put_text("m", "y");
    if (geteuid() != 0) /* who may write anything, may write this */
        CHECK(status == HDR_CANT_CREATE && file_is("m", "x"), "a write-protected file: %d", status);
    unlink("m");
}

static void test_links(void) {
    CHECK(mkdir("d", 0777) == 0 && symlink("d/real", "one") == 0 && symlink("one", "two") == 0, "cannot make links");
    struct stat about;
    CHECK(put_text("two", "first") == HDR_OK && file_is("d/real", "first"), "a dangling link");
    CHECK(put_text("two", "second") == HDR_OK && file_is("d/real", "second"), "a link");
    CHECK(lstat("two", &about) == 0 && S_ISLNK(about.st_mode) && lstat("one", &about) == 0 && S_ISLNK(about.st_mode),
          "a link was replaced");
    unlink("d/real");
    rmdir("d");
    CHECK(put_text("two", "third") == HDR_CANT_CREATE, "a link into no directory");
    unlink("one");
    unlink("two");
    CHECK(symlink("loop", "loop") == 0 && put_text("loop", "x") == HDR_CANT_CREATE, "a link to itself");
    unlink("loop");
    CHECK(count_entries("") == 0, "something is left behind");
}

static void test_cannot_create(void) {
    hdr_error err = {0};
    CHECK(!hdr_output_open("missing/a.png", &err) && err.status == HDR_CANT_CREATE, "missing directory: %d",
          err.status);
    CHECK(strcmp(err.message, "missing/a.png: cannot create: No such file or directory") == 0, "message: %s",
          err.message);
    CHECK(put_text("", "x") == HDR_CANT_CREATE, "no name");
    CHECK(put_text(".", "x") == HDR_CANT_CREATE, "a directory");
    CHECK(put_text("missing/", "x") == HDR_CANT_CREATE, "a directory that is not there");
    char longest[256];
    memset(longest, 'n', 255);
    longest[255] = '\0';
    CHECK(put_text(longest, "x") == HDR_OK && file_is(longest, "x"), "the longest name");
    unlink(longest);
    CHECK(count_entries("") == 0, "something is left behind");
}

/* ---- What is written ---- */

/* Positions in any order, gaps, and a restart, which must forget the rest of what was there. */
static void check_positions(hdr_output *output) {
    hdr_error err = {0};
    hdr_output_write(output, "garbage garbage", 15, 3, &err);
    hdr_output_restart(output, &err);
    hdr_output_write(output, "end", 3, 9, &err);
    hdr_output_write(output, "front", 5, 0, &err);
    hdr_output_commit(output, &err);
    CHECK(err.status == HDR_OK, "%s: %s", hdr_output_name(output), err.message);
}

static void test_positions(void) {
    static const char expected[] = "front\0\0\0\0end";
    hdr_output *memory = hdr_output_memory(NULL);
    size_t size = 1;
    CHECK(!hdr_output_bytes(memory, &size) && size == 0, "bytes before commit");
    check_positions(memory);
    const void *bytes = hdr_output_bytes(memory, &size);
    CHECK(bytes && size == 12 && memcmp(bytes, expected, 12) == 0, "memory: %zu bytes", size);
    CHECK(hdr_output_write(memory, "x", 1, 0, NULL) == HDR_INTERNAL, "written to after commit");
    hdr_output_free(memory);

    hdr_output *file = hdr_output_open("p", NULL);
    check_positions(file);
    hdr_output_free(file);
    char content[20] = "";
    FILE *stream = fopen("p", "rb");
    CHECK(stream && fread(content, 1, sizeof content, stream) == 12 && memcmp(content, expected, 12) == 0, "the file");
    if (stream) fclose(stream);
    unlink("p");
}

/* Beyond what is reserved at first. Only the pages that are written to exist. */
static void test_large_memory(void) {
    const uint64_t far = ((uint64_t)3 << 30) + 12345;
    hdr_error err = {0};
    hdr_output *output = hdr_output_memory(&err);
    hdr_output_write(output, "near", 4, 4096, &err);
    hdr_output_write(output, "far", 3, far, &err);
    hdr_output_commit(output, &err);
    size_t size;
    const char *bytes = hdr_output_bytes(output, &size);
    CHECK(err.status == HDR_OK && size == far + 3 && memcmp(bytes + 4096, "near", 4) == 0 &&
              memcmp(bytes + far, "far", 3) == 0,
          "3 GiB: %s", err.message);
    CHECK(hdr_output_write(output, "x", 1, UINT64_MAX, NULL) != HDR_OK, "a position beyond all files");
    hdr_output_free(output);
}

static void test_full_disk(void) {
    hdr_error err = {0};
    if (access("/dev/full", W_OK) != 0) return;
    CHECK(put_text("/dev/full", "x") == HDR_IO, "/dev/full by name");
    int full = open("/dev/full", O_WRONLY);
    hdr_output *output = hdr_output_descriptor(full, "standard output", &err);
    CHECK(write_text(output, "x", &err) == HDR_OK && hdr_output_commit(output, &err) == HDR_IO, "/dev/full");
    CHECK(strcmp(err.message, "standard output: No space left on device") == 0, "message: %s", err.message);
    hdr_output_free(output);
    CHECK(close(full) == 0, "the descriptor was closed");
}

/* ---- Descriptors ---- */

static void test_descriptor(void) {
    hdr_error err = {0};
    int both[2];
    char content[8] = "";
    CHECK(pipe(both) == 0, "pipe");
    hdr_output *output = hdr_output_descriptor(both[1], "standard output", &err);
    write_text(output, "piped", &err);
    CHECK(fcntl(both[0], F_SETFL, O_NONBLOCK) == 0 && read(both[0], content, sizeof content) < 0,
          "written before commit");
    CHECK(hdr_output_commit(output, &err) == HDR_OK && read(both[0], content, sizeof content) == 5, "commit: %s",
          err.message);
    hdr_output_free(output);
    CHECK(!hdr_output_descriptor(both[0], "in", &err) && err.status == HDR_CANT_CREATE, "a descriptor for reading");
    close(both[0]);

    signal(SIGPIPE, SIG_IGN);
    err = (hdr_error){0};
    output = hdr_output_descriptor(both[1], "standard output", &err);
    write_text(output, "x", &err);
    CHECK(hdr_output_commit(output, &err) == HDR_IO, "a closed pipe");
    hdr_output_free(output);
    signal(SIGPIPE, SIG_DFL);
    close(both[1]);
    err = (hdr_error){0};
    CHECK(!hdr_output_descriptor(both[1], "closed", &err) && err.status == HDR_CANT_CREATE, "a closed descriptor");
}

/* More than a pipe holds, into one that does not block. */
static void test_slow_reader(void) {
    enum { BYTES = 1 << 20 };
    int both[2];
    hdr_error err = {0};
    CHECK(pipe(both) == 0 && fcntl(both[1], F_SETFL, O_NONBLOCK) == 0, "pipe");
    pid_t reader = fork();
    if (reader == 0) {
        char buffer[4096];
        size_t total = 0;
        close(both[1]);
        for (ssize_t count; (count = read(both[0], buffer, sizeof buffer)) > 0;)
            total += (size_t)count;
        _exit(total == BYTES ? 0 : 1);
    }
    close(both[0]);
    hdr_output *output = hdr_output_descriptor(both[1], "standard output", &err);
    char *bytes = calloc(BYTES, 1);
    hdr_output_write(output, bytes, BYTES, 0, &err);
    CHECK(hdr_output_commit(output, &err) == HDR_OK, "commit: %s", err.message);
    hdr_output_free(output);
    free(bytes);
    close(both[1]);
    int status = 1;
    CHECK(waitpid(reader, &status, 0) == reader && status == 0, "the reader did not get all");
}

static void test_terminal(void) {
    int master = posix_openpt(O_RDWR | O_NOCTTY);
    if (master < 0 || grantpt(master) != 0 || unlockpt(master) != 0) return;
    hdr_error err = {0};
    const char *name = ptsname(master);
    int terminal = open(name, O_RDWR | O_NOCTTY);
    CHECK(terminal >= 0 && !hdr_output_descriptor(terminal, "standard output", &err) && err.status == HDR_USAGE,
          "a terminal: %d", err.status);
    CHECK(strcmp(err.message, "standard output is a terminal: give -o FILE, or redirect") == 0, "message: %s",
          err.message);
    CHECK(put_text(name, "x") == HDR_USAGE, "a terminal by name");
    if (terminal >= 0) close(terminal);
    close(master);
}

/* ---- Signals ---- */

static void end_by_signal(int number) {
    hdr_output_remove_temporary();
    _exit(number);
}

static void test_signal(void) {
    pid_t child = fork();
    if (child == 0) {
        signal(SIGTERM, end_by_signal);
        hdr_output *one = hdr_output_open("s1", NULL), *two = hdr_output_open("s2", NULL),
                   *done = hdr_output_open("s3", NULL);
        write_text(one, "x", NULL);
        write_text(two, "x", NULL);
        write_text(done, "x", NULL);
        hdr_output_commit(done, NULL);
        raise(SIGTERM);
        _exit(1);
    }
    int status = 0;
    CHECK(waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == SIGTERM, "status %d",
          status);
    CHECK(count_entries("") == 1 && file_is("s3", "x"), "%d entries after the signal", count_entries(""));
    unlink("s3");

    if ((child = fork()) == 0) {
        hdr_output *output = hdr_output_open("s4", NULL);
        hdr_output_remove_temporary();
        status = hdr_output_commit(output, NULL);
        hdr_output_free(output);
        _exit(status);
    }
    CHECK(waitpid(child, &status, 0) == child && WEXITSTATUS(status) == HDR_CANT_CREATE, "committed what was removed");
    CHECK(count_entries("") == 0, "something is left behind");
}

/* More outputs at a time than the table of names has room for. */
static void test_many(void) {
    enum { MANY = 100 };
    hdr_output *outputs[MANY];
    char name[16];
    for (int i = 0; i < MANY; i++) {
        snprintf(name, sizeof name, "many%d", i);
        outputs[i] = hdr_output_open(name, NULL);
        CHECK(outputs[i], "output %d", i);
    }
    for (int i = 0; i < MANY; i++) {
        if (i % 2 == 0) CHECK(hdr_output_commit(outputs[i], NULL) == HDR_OK, "commit %d", i);
        hdr_output_free(outputs[i]);
        snprintf(name, sizeof name, "many%d", i);
        CHECK((unlink(name) == 0) == (i % 2 == 0), "file %d", i);
    }
    CHECK(count_entries("") == 0, "something is left behind");
}

int main(void) {
    const char *base = getenv("TMPDIR");
    char directory[4096];
    snprintf(directory, sizeof directory, "%s/test_output.XXXXXX", base && *base ? base : "/tmp");
    if (!mkdtemp(directory) || chdir(directory) != 0) {
        perror(directory);
        return 1;
    }
    test_whole_or_nothing();
    test_permissions();
    test_links();
    test_cannot_create();
    test_positions();
    test_large_memory();
    test_full_disk();
    test_descriptor();
    test_slow_reader();
    test_terminal();
    test_signal();
    test_many();
    CHECK(chdir("/") == 0 && rmdir(directory) == 0, "%s is not empty", directory);
    return check_done("test_output");
}

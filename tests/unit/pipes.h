/* For tests: a process at the other end of a pipe. */
#ifndef HDR_TESTS_PIPES_H
#define HDR_TESTS_PIPES_H

#include "exr_make.h"
#include "io/input.h"

#include <signal.h>
#include <stdio.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

/* A process that writes bytes to a pipe in pieces of odd sizes, and then waits to be killed where it is to linger. */
static inline pid_t start_writer(const file_bytes *file, bool linger, int *from) {
    int ends[2];
    if (pipe(ends) != 0) abort();
    pid_t writer = fork();
    if (writer == 0) {
        uint64_t random = 7;
        close(ends[0]);
        for (size_t done = 0; done < file->size;) {
            size_t piece = 1 + random_bits(&random) % (done < 3000 ? 100 : 30011);
            if (piece > file->size - done) piece = file->size - done;
            ssize_t count = write(ends[1], file->data + done, piece);
            if (count < 0) _exit(1);
            done += (size_t)count;
        }
        if (linger) pause();
        _exit(0);
    }
    close(ends[1]);
    *from = ends[0];
    return writer;
}

static inline void end_writer(pid_t writer) {
    kill(writer, SIGKILL);
    waitpid(writer, NULL, 0);
}

static inline hdr_input *open_descriptor(int descriptor, hdr_error *error) {
    char path[32];
    snprintf(path, sizeof path, "/proc/self/fd/%d", descriptor);
    hdr_input *input = hdr_input_open(path, error);
    close(descriptor);
    return input;
}

#endif

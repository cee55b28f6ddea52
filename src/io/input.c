/* Bytes by position from a file, a pipe or memory.
 *
 * A pipe's first bytes are read by whoever asks for them, so that a head can be recognised and the rest be forwarded to
 * another process untouched. As soon as more is asked for, a thread reads ahead into memory that grows in place:
 * address space for far more than will come is reserved, and made usable step by step. */
#include "io/input.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <unistd.h>

#define KIB ((uint64_t)1024)
#define MIB (KIB * KIB)

#define HEAD_BYTES (64 * KIB)   /* read without the thread */
#define HEAD_STEP (4 * KIB)     /* at a time, so that small requests are few system calls */
#define READ_BYTES MIB          /* asked of the system at once; also the size of the kernel's pipe buffer */
#define COMMIT_BYTES (64 * MIB) /* address space made usable at once */
#define HUGE_PAGE (2 * MIB)     /* a short picture does not pay for one: they begin behind the first */
#define AHEAD_BYTES                                                                                                    \
    (256 * MIB) /* how far the thread reads beyond what was asked for, lest an endless pipe eat all memory */
#define MOST_RESERVED (MIB * MIB) /* 1 TiB */
#define NAME_BYTES 240            /* of a name in messages, so that the sentence behind it is not cut off */

enum input_kind { INPUT_FILE, INPUT_PIPE, INPUT_MEMORY, INPUT_PLANES, INPUT_JOINED };

/* What has come from a pipe. have is written by the reader only, with the lock held; ended and error are guarded by the
 * lock. */
struct pipe_memory {
    void *mapping; /* the whole reservation */
    size_t mapped;
    unsigned char *bytes;         /* in it, at a huge page's border */
    uint64_t reserved, committed; /* counted from bytes */
    _Atomic uint64_t have;
    uint64_t wanted; /* the furthest end of any request */
    pthread_mutex_t lock;
    pthread_cond_t arrived;  /* bytes, or the end */
    pthread_cond_t released; /* the reader may go on */
    pthread_t thread;
    bool running, stop, ended;
    int error; /* of errno, where reading failed */
    int wake;  /* an event that ends the thread's waiting; -1 before there is a thread */
};

struct hdr_input {
    enum input_kind kind;
    char name[NAME_BYTES + 8];
    int descriptor;
    bool close_descriptor;
    uint64_t start; /* where the file's first byte is, for a standard input that was read before */
    uint64_t size;  /* of a file or memory, counted from start */
    uint64_t skip;  /* length of the head */
    const unsigned char *bytes;
    hdr_planes planes;
    hdr_joined joined;
    struct pipe_memory pipe;
};

/* ---- Opening ---- */

/* Keeps the end of a long name, without line breaks and not from within a UTF-8 sequence. */
static void set_name(hdr_input *input, const char *name) {
    size_t length = strlen(name);
    char *to = input->name;
    if (length > NAME_BYTES) {
        name += length - NAME_BYTES;
        while (((unsigned char)*name & 0xc0) == 0x80)
            name++;
        memcpy(to, "...", 3);
        to += 3;
    }
    for (; *name; name++)
        *to++ = *name == '\n' || *name == '\r' ? '?' : *name;
    *to = '\0';
}

static hdr_input *new_input(enum input_kind kind, const char *name, hdr_error *err) {
    hdr_input *input = hdr_alloc(1, sizeof *input);
    if (!input) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        return NULL;
    }
    input->kind = kind;
    input->descriptor = -1;
    input->pipe.wake = -1;
    set_name(input, name);
    return input;
}

static hdr_status prepare_pipe(hdr_input *input, hdr_error *err) {
    struct pipe_memory *pipe = &input->pipe;
    int fault = pthread_mutex_init(&pipe->lock, NULL);
    if (fault == 0 && (fault = pthread_cond_init(&pipe->arrived, NULL)) != 0) pthread_mutex_destroy(&pipe->lock);
    if (fault == 0 && (fault = pthread_cond_init(&pipe->released, NULL)) != 0) {
        pthread_cond_destroy(&pipe->arrived);
        pthread_mutex_destroy(&pipe->lock);
    }
    if (fault != 0) return hdr_fail(err, HDR_INTERNAL, "%s: %s", input->name, strerror(fault));
    input->kind = INPUT_PIPE;
    /* Fewer changes between writer and reader; where it is refused, the usual size does. */
    (void)fcntl(input->descriptor, F_SETPIPE_SZ, (int)READ_BYTES);
    return HDR_OK;
}

/* Finds out what the descriptor is: a file that can be read at any place, or something that only flows. */
static hdr_status classify(hdr_input *input, hdr_error *err) {
    struct stat about;
    if (fstat(input->descriptor, &about) != 0)
        return hdr_fail(err, HDR_NO_INPUT, "%s: %s", input->name, strerror(errno));
    if (S_ISDIR(about.st_mode)) return hdr_fail(err, HDR_NO_INPUT, "%s: %s", input->name, strerror(EISDIR));
    if (!S_ISREG(about.st_mode)) {
        if (isatty(input->descriptor))
            return hdr_fail(err, HDR_USAGE, "%s is a terminal: name a file, or pipe a picture in", input->name);
        return prepare_pipe(input, err);
    }
    off_t at = lseek(input->descriptor, 0, SEEK_CUR);
    input->start = at > 0 ? (uint64_t)at : 0;
    input->size = (uint64_t)about.st_size > input->start ? (uint64_t)about.st_size - input->start : 0;
    return HDR_OK;
}

hdr_input *hdr_input_open(const char *path, hdr_error *err) {
    bool standard = !path || strcmp(path, "-") == 0;
    hdr_input *input = new_input(INPUT_FILE, standard ? "standard input" : path, err);
    if (!input) return NULL;
    if (standard) {
        input->descriptor = STDIN_FILENO;
    } else {
        do
            input->descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY);
        while (input->descriptor < 0 && errno == EINTR);
        if (input->descriptor < 0) {
            hdr_fail(err, HDR_NO_INPUT, "%s: %s", input->name, strerror(errno));
            hdr_input_free(input);
            return NULL;
        }
        input->close_descriptor = true;
    }
    if (classify(input, err) != HDR_OK) {
        hdr_input_free(input);
        return NULL;
    }
    return input;
}

hdr_input *hdr_input_memory(const void *bytes, size_t size, const char *name, hdr_error *err) {
    hdr_input *input = new_input(INPUT_MEMORY, name ? name : "memory", err);
    if (!input) return NULL;
    input->bytes = bytes;
    input->size = size;
    return input;
}

hdr_input *hdr_input_planes(int width, int height, int planes, const float *const plane[3], const float *alpha,
                            hdr_error *err) {
    bool sound = width > 0 && height > 0 && (planes == 1 || planes == 3) && plane != NULL;
    for (int i = 0; sound && i < planes; i++)
        sound = plane[i] != NULL;
    if (!sound) {
        hdr_fail(err, HDR_BAD_DATA, "a picture in memory needs a width, a height, and 1 or 3 planes");
        return NULL;
    }
    hdr_input *input = new_input(INPUT_PLANES, "the picture in memory", err);
    if (!input) return NULL;
    input->planes = (hdr_planes){.width = width, .height = height, .planes = planes, .alpha = alpha};
    for (int i = 0; i < planes; i++)
        input->planes.plane[i] = plane[i];
    return input;
}

hdr_input *hdr_input_join(int count, hdr_input *const inputs[], hdr_error *err) {
    hdr_input **members = hdr_alloc((size_t)count, sizeof(hdr_input *));
    char name[2 * NAME_BYTES];
    snprintf(name, sizeof name, count > 1 ? "%s and %d more" : "%s", inputs[0]->name, count - 1);
    hdr_input *input = members ? new_input(INPUT_JOINED, name, err) : NULL;
    if (!input) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        free(members);
        return NULL;
    }
    for (int i = 0; i < count; i++)
        members[i] = inputs[i];
    input->joined = (hdr_joined){members, count};
    return input;
}

/* ---- Growing memory ---- */

/* Takes as much address space as there is to have; it costs nothing until it is used. */
static bool reserve(struct pipe_memory *pipe) {
    for (uint64_t size = MOST_RESERVED; size >= COMMIT_BYTES; size /= 2) {
        size_t with_border = (size_t)(size + HUGE_PAGE);
        void *mapping = mmap(NULL, with_border, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
        if (mapping == MAP_FAILED) continue;
        uintptr_t border = ((uintptr_t)mapping + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE;
        pipe->mapping = mapping;
        pipe->mapped = with_border;
        pipe->bytes = (unsigned char *)mapping + (border - (uintptr_t)mapping);
        pipe->reserved = size;
        return true;
    }
    return false;
}

/* Makes sure that there is room for some bytes at have. Returns how many, or 0 with errno set. */
static uint64_t room_at(struct pipe_memory *pipe, uint64_t have) {
    if (!pipe->bytes && !reserve(pipe)) return 0;
    if (have == pipe->reserved) {
        errno = EFBIG;
        return 0;
    }
    if (have == pipe->committed) {
        unsigned char *from = pipe->bytes + pipe->committed;
        if (mprotect(from, (size_t)COMMIT_BYTES, PROT_READ | PROT_WRITE) != 0) return 0;
        size_t small = pipe->committed == 0 ? (size_t)HUGE_PAGE : 0;
        (void)madvise(from + small, (size_t)COMMIT_BYTES - small, MADV_HUGEPAGE);
        pipe->committed += COMMIT_BYTES;
    }
    return pipe->committed - have;
}

/* ---- Reading a pipe ---- */

/* Waits until a descriptor is ready. False: the wake event came. */
static bool wait_for(int descriptor, short events, int wake) {
    struct pollfd polled[2] = {{.fd = descriptor, .events = events}, {.fd = wake, .events = POLLIN}};
    for (;;) {
        int ready = poll(polled, wake >= 0 ? 2 : 1, -1);
        if (ready < 0 && errno != EINTR) return true; /* what is wrong with it, reading will tell */
        if (ready > 0) return !(wake >= 0 && polled[1].revents);
    }
}

/* Reads at most most bytes to the place where those are wanted that come next. Returns the count, 0 at the end or when
 * woken to stop, -1 with errno set. Only one thread does this at a time. */
static ssize_t take(hdr_input *input, uint64_t have, uint64_t most) {
    struct pipe_memory *pipe = &input->pipe;
    uint64_t room = room_at(pipe, have);
    if (room == 0) return -1;
    if (most > room) most = room;
    for (;;) {
        /* Never blocked in read itself, where the wake event would not be seen. */
        if (pipe->wake >= 0 && !wait_for(input->descriptor, POLLIN, pipe->wake)) return 0;
        ssize_t count = read(input->descriptor, pipe->bytes + have, (size_t)most);
        if (count >= 0) return count;
        if (errno == EAGAIN || errno == EWOULDBLOCK)
            wait_for(input->descriptor, POLLIN, pipe->wake);
        else if (errno != EINTR)
            return -1;
    }
}

/* Records what take returned. With the lock held. */
static void account(struct pipe_memory *pipe, uint64_t have, ssize_t count, int error) {
    if (count > 0) {
        atomic_store_explicit(&pipe->have, have + (uint64_t)count, memory_order_release);
    } else {
        pipe->ended = true;
        pipe->error = count < 0 ? error : 0;
    }
    pthread_cond_broadcast(&pipe->arrived);
}

static void *read_ahead(void *argument) {
    hdr_input *input = argument;
    struct pipe_memory *pipe = &input->pipe;
    uint64_t have = atomic_load(&pipe->have);
    pthread_mutex_lock(&pipe->lock);
    while (!pipe->stop && !pipe->ended) {
        if (have > pipe->wanted && have - pipe->wanted >= AHEAD_BYTES) {
            pthread_cond_wait(&pipe->released, &pipe->lock);
            continue;
        }
        pthread_mutex_unlock(&pipe->lock);
        ssize_t count = take(input, have, READ_BYTES);
        int error = errno;
        pthread_mutex_lock(&pipe->lock);
        account(pipe, have, count, error);
        have = atomic_load(&pipe->have);
    }
    pthread_mutex_unlock(&pipe->lock);
    return NULL;
}

/* With the lock held. */
static hdr_status start_reading_ahead(hdr_input *input, hdr_error *err) {
    struct pipe_memory *pipe = &input->pipe;
    if (pipe->running || pipe->ended) return HDR_OK;
    if (pipe->wake < 0) pipe->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (pipe->wake < 0) return hdr_fail(err, HDR_INTERNAL, "%s: %s", input->name, strerror(errno));
    int fault = pthread_create(&pipe->thread, NULL, read_ahead, input);
    if (fault != 0)
        return hdr_fail(err, HDR_INTERNAL, "%s: no thread to read it with: %s", input->name, strerror(fault));
    pipe->running = true;
    return HDR_OK;
}

/* Waits until the pipe's first end bytes are in memory, or it has ended before that. */
static hdr_status await(hdr_input *input, uint64_t end, hdr_error *err) {
    struct pipe_memory *pipe = &input->pipe;
    hdr_status status = HDR_OK;
    if (atomic_load_explicit(&pipe->have, memory_order_acquire) >= end) return HDR_OK;
    pthread_mutex_lock(&pipe->lock);
    uint64_t have = atomic_load(&pipe->have);
    if (end > pipe->wanted) {
        pipe->wanted = end;
        pthread_cond_signal(&pipe->released);
    }
    if (end > HEAD_BYTES) status = start_reading_ahead(input, err);
    while (status == HDR_OK && have < end && !pipe->ended) {
        if (pipe->running) {
            pthread_cond_wait(&pipe->arrived, &pipe->lock);
        } else {
            uint64_t goal = (end + HEAD_STEP - 1) / HEAD_STEP * HEAD_STEP;
            ssize_t count = take(input, have, goal - have);
            account(pipe, have, count, errno);
        }
        have = atomic_load(&pipe->have);
    }
    if (status == HDR_OK && have < end && pipe->error)
        status = hdr_fail(err, HDR_IO, "%s: reading failed: %s", input->name, strerror(pipe->error));
    pthread_mutex_unlock(&pipe->lock);
    return status;
}

/* ---- Reading ---- */

/* Copies from what is in memory; at counts from the start of all. */
static int64_t copy_out(const unsigned char *bytes, uint64_t have, void *buffer, uint64_t size, uint64_t at) {
    if (at >= have) return 0;
    if (size > have - at) size = have - at;
    memcpy(buffer, bytes + at, (size_t)size);
    return (int64_t)size;
}

static int64_t read_file(hdr_input *input, void *buffer, uint64_t size, uint64_t at, hdr_error *err) {
    uint64_t done = 0;
    while (done < size) {
        uint64_t place = input->start + at + done;
        if (place < at || place > INT64_MAX) break;
        ssize_t count = pread(input->descriptor, (unsigned char *)buffer + done, (size_t)(size - done), (off_t)place);
        if (count == 0) break;
        if (count > 0)
            done += (uint64_t)count;
        else if (errno != EINTR)
            return hdr_fail(err, HDR_IO, "%s: reading failed: %s", input->name, strerror(errno)), -1;
    }
    return (int64_t)done;
}

int64_t hdr_input_read(hdr_input *input, void *buffer, uint64_t size, uint64_t offset, hdr_error *err) {
    /* No picture reaches as far as these bounds do. */
    if (size > INT64_MAX / 4) size = INT64_MAX / 4;
    if (offset > INT64_MAX / 4) return 0;
    uint64_t at = offset + input->skip;
    switch (input->kind) {
    case INPUT_FILE:
        return read_file(input, buffer, size, at, err);
    case INPUT_PIPE:
        if (await(input, at + size, err) != HDR_OK) return -1;
        return copy_out(input->pipe.bytes, atomic_load_explicit(&input->pipe.have, memory_order_acquire), buffer, size,
                        at);
    case INPUT_MEMORY:
        return copy_out(input->bytes, input->size, buffer, size, at);
    case INPUT_PLANES:
    case INPUT_JOINED:
        break;
    }
    return 0;
}

int64_t hdr_input_size(hdr_input *input) {
    uint64_t size = input->size;
    if (input->kind == INPUT_PIPE) {
        pthread_mutex_lock(&input->pipe.lock);
        bool known = input->pipe.ended && input->pipe.error == 0;
        size = atomic_load(&input->pipe.have);
        pthread_mutex_unlock(&input->pipe.lock);
        if (!known) return -1;
    }
    return size > input->skip ? (int64_t)(size - input->skip) : 0;
}

bool hdr_input_has(hdr_input *input, uint64_t offset) {
    uint64_t size = input->size;
    if (input->kind == INPUT_PIPE) size = atomic_load_explicit(&input->pipe.have, memory_order_acquire);
    return offset < size && input->skip < size - offset;
}

bool hdr_input_flows(const hdr_input *input) {
    return input->kind == INPUT_PIPE;
}

void hdr_input_skip(hdr_input *input, uint64_t length) {
    input->skip = length < INT64_MAX / 4 ? length : INT64_MAX / 4;
}

const char *hdr_input_name(const hdr_input *input) {
    return input->name;
}

const hdr_planes *hdr_input_get_planes(const hdr_input *input) {
    return input->kind == INPUT_PLANES ? &input->planes : NULL;
}

const hdr_joined *hdr_input_get_joined(const hdr_input *input) {
    return input->kind == INPUT_JOINED ? &input->joined : NULL;
}

bool hdr_input_has_bytes(const hdr_input *input) {
    return input->kind != INPUT_PLANES && input->kind != INPUT_JOINED;
}

bool hdr_input_same_file(const hdr_input *a, const hdr_input *b) {
    struct stat about_a, about_b;
    return a->kind == INPUT_FILE && b->kind == INPUT_FILE && fstat(a->descriptor, &about_a) == 0 &&
           fstat(b->descriptor, &about_b) == 0 && about_a.st_dev == about_b.st_dev && about_a.st_ino == about_b.st_ino;
}

/* ---- Forwarding ---- */

/* What to do about a failed call of a copying loop. */
enum verdict { TRY_AGAIN, CALL_UNFIT, GIVE_UP };

static enum verdict judge_fault(hdr_input *input, int descriptor, bool input_may_block, hdr_error *err) {
    switch (errno) {
    case EINTR:
        return TRY_AGAIN;
    case EAGAIN:
        if (input_may_block) wait_for(input->descriptor, POLLIN, -1);
        wait_for(descriptor, POLLOUT, -1);
        return TRY_AGAIN;
    case EINVAL:
    case ENOSYS:
        return CALL_UNFIT;
    case EPIPE:
        hdr_fail(err, HDR_IO, "broken pipe");
        return GIVE_UP;
    default:
        hdr_fail(err, HDR_IO, "%s: passing it on failed: %s", input->name, strerror(errno));
        return GIVE_UP;
    }
}

static hdr_status write_all(hdr_input *input, int descriptor, const unsigned char *bytes, uint64_t size,
                            hdr_error *err) {
    while (size > 0) {
        ssize_t count = write(descriptor, bytes, size < READ_BYTES ? (size_t)size : (size_t)READ_BYTES);
        if (count >= 0) {
            bytes += count;
            size -= (uint64_t)count;
            continue;
        }
        enum verdict verdict = judge_fault(input, descriptor, false, err);
        if (verdict == CALL_UNFIT)
            return hdr_fail(err, HDR_IO, "%s: passing it on failed: %s", input->name, strerror(errno));
        if (verdict == GIVE_UP) return HDR_IO;
    }
    return HDR_OK;
}

/* Moves bytes within the kernel from at (a file) or from where the pipe stands. Stops at the end, or with CALL_UNFIT
 * where these two kinds of descriptor cannot be joined so; *at counts what was moved. */
static enum verdict move_in_kernel(hdr_input *input, int descriptor, uint64_t *at, hdr_error *err) {
    for (;;) {
        ssize_t count;
        if (input->kind == INPUT_FILE) {
            off_t place = (off_t)*at;
            count = sendfile(descriptor, input->descriptor, &place, (size_t)(1024 * MIB));
        } else {
            count =
                splice(input->descriptor, NULL, descriptor, NULL, (size_t)READ_BYTES, SPLICE_F_MOVE | SPLICE_F_MORE);
        }
        if (count == 0) return TRY_AGAIN;
        if (count > 0) {
            *at += (uint64_t)count;
            continue;
        }
        enum verdict verdict = judge_fault(input, descriptor, input->kind == INPUT_PIPE, err);
        if (verdict != TRY_AGAIN) return verdict;
    }
}

/* The same by way of memory. */
static hdr_status move_by_copy(hdr_input *input, int descriptor, uint64_t at, hdr_error *err) {
    unsigned char *buffer = hdr_alloc(1, (size_t)READ_BYTES);
    hdr_status status = buffer ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
    while (status == HDR_OK) {
        ssize_t count = input->kind == INPUT_FILE ? pread(input->descriptor, buffer, (size_t)READ_BYTES, (off_t)at)
                                                  : read(input->descriptor, buffer, (size_t)READ_BYTES);
        if (count == 0) break;
        if (count > 0) {
            at += (uint64_t)count;
            status = write_all(input, descriptor, buffer, (uint64_t)count, err);
        } else if (errno == EAGAIN) {
            wait_for(input->descriptor, POLLIN, -1);
        } else if (errno != EINTR) {
            status = hdr_fail(err, HDR_IO, "%s: reading failed: %s", input->name, strerror(errno));
        }
    }
    free(buffer);
    return status;
}

static hdr_status move_rest(hdr_input *input, int descriptor, uint64_t at, hdr_error *err) {
    (void)fcntl(descriptor, F_SETPIPE_SZ, (int)READ_BYTES); /* only a pipe has a size; bigger is faster */
    switch (move_in_kernel(input, descriptor, &at, err)) {
    case TRY_AGAIN:
        return HDR_OK;
    case CALL_UNFIT:
        return move_by_copy(input, descriptor, at, err);
    case GIVE_UP:
        break;
    }
    return HDR_IO;
}

static hdr_status forward_pipe(hdr_input *input, int descriptor, hdr_error *err) {
    struct pipe_memory *pipe = &input->pipe;
    if (pipe->running) return hdr_fail(err, HDR_INTERNAL, "%s: cannot be passed on: it is being decoded", input->name);
    uint64_t have = atomic_load(&pipe->have);
    if (have > input->skip) {
        hdr_status status = write_all(input, descriptor, pipe->bytes + input->skip, have - input->skip, err);
        if (status != HDR_OK) return status;
    }
    if (pipe->error) return hdr_fail(err, HDR_IO, "%s: reading failed: %s", input->name, strerror(pipe->error));
    if (pipe->ended) return HDR_OK;
    pipe->ended = true; /* what flows past is not kept */
    return move_rest(input, descriptor, 0, err);
}

hdr_status hdr_input_forward(hdr_input *input, int descriptor, hdr_error *err) {
    switch (input->kind) {
    case INPUT_FILE:
        return move_rest(input, descriptor, input->start + input->skip, err);
    case INPUT_PIPE:
        return forward_pipe(input, descriptor, err);
    case INPUT_MEMORY:
        if (input->size <= input->skip) return HDR_OK;
        return write_all(input, descriptor, input->bytes + input->skip, input->size - input->skip, err);
    case INPUT_PLANES:
    case INPUT_JOINED:
        break;
    }
    return hdr_fail(err, HDR_INTERNAL, "%s: it is no file that could be passed on", input->name);
}

/* ---- Closing ---- */

/* Ends the thread wherever it waits: on the condition, or in poll on a pipe whose writer is still busy. */
static void stop_reading_ahead(struct pipe_memory *pipe) {
    pthread_mutex_lock(&pipe->lock);
    pipe->stop = true;
    pthread_cond_broadcast(&pipe->released);
    pthread_mutex_unlock(&pipe->lock);
    uint64_t one = 1;
    while (write(pipe->wake, &one, sizeof one) < 0 && errno == EINTR)
        ;
    pthread_join(pipe->thread, NULL);
}

void hdr_input_free(hdr_input *input) {
    if (!input) return;
    if (input->kind == INPUT_PIPE) {
        struct pipe_memory *pipe = &input->pipe;
        if (pipe->running) stop_reading_ahead(pipe);
        if (pipe->wake >= 0) close(pipe->wake);
        if (pipe->mapping) munmap(pipe->mapping, pipe->mapped);
        pthread_cond_destroy(&pipe->released);
        pthread_cond_destroy(&pipe->arrived);
        pthread_mutex_destroy(&pipe->lock);
    }
    if (input->close_descriptor) close(input->descriptor);
    free(input->joined.members);
    free(input);
}

/* Bytes by position: from a file (pread: no mapping, since a file that shrinks meanwhile would be a SIGBUS), from a
 * pipe (a thread reads ahead into memory, while the chunks that have come are decoded), or from memory. */
#ifndef HDR_INPUT_H
#define HDR_INPUT_H

#include "base/base.h"

/* Reads size bytes at offset, counted from the start of the picture file: behind the head, once hdr_input_skip was told
 * its length. From a pipe it waits for them. Fewer than size only at the end of the data. Returns the count, or -1 with
 * err filled (HDR_IO). Threads may call it at the same time. */
int64_t hdr_input_read(hdr_input *input, void *buffer, uint64_t size, uint64_t offset, hdr_error *err);

/* Bytes behind the head, or -1 while a pipe's end has not come. */
int64_t hdr_input_size(hdr_input *input);

/* Whether there is a byte at offset, as far as has been read of a pipe: it does not wait. */
bool hdr_input_has(hdr_input *input, uint64_t offset);

/* True of a pipe, whose size is known at its end and not before. */
bool hdr_input_flows(const hdr_input *input);

/* Says that the picture begins length bytes after the start of all. */
void hdr_input_skip(hdr_input *input, uint64_t length);

/* Copies all bytes from the picture's beginning to descriptor, without touching them where the kernel can do it
 * (splice, sendfile, else read and write). Of a pipe only what has been read so far is in memory: it must not have been
 * given to the reading thread (hdr_input_read for offsets beyond the first 64 KiB) before. A closed pipe is SIGPIPE's
 * matter: EPIPE is HDR_IO. */
hdr_status hdr_input_forward(hdr_input *input, int descriptor, hdr_error *err);

/* The pixels of hdr_input_planes, or NULL for a file. */
const hdr_planes *hdr_input_get_planes(const hdr_input *input);

/* The inputs of hdr_input_join, or NULL for any other. */
typedef struct hdr_joined {
    hdr_input **members;
    int count;
} hdr_joined;
const hdr_joined *hdr_input_get_joined(const hdr_input *input);

/* Whether both read the same regular file. */
bool hdr_input_same_file(const hdr_input *a, const hdr_input *b);

/* Whether it consists of bytes, which a head may stand in front of. */
bool hdr_input_has_bytes(const hdr_input *input);

#endif

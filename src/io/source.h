/* A source: a picture's pixels as numbered blocks of rows, which any thread may read in any order. */
#ifndef HDR_SOURCE_H
#define HDR_SOURCE_H

#include "io/input.h"
#include "picture/picture.h"

typedef struct hdr_source hdr_source;

/* What one format provides. */
struct hdr_source {
    hdr_picture picture;
    int block_rows; /* rows of every block but the last: a multiple of the file's chunk height */
    int blocks;
    /* One worker per thread holds the buffers: new, read as often as wanted, free. */
    hdr_status (*worker_new)(hdr_source *source, void **worker, hdr_error *err);
    /* Decodes a block. What it points to stays valid until the worker's next read. */
    hdr_status (*read)(hdr_source *source, void *worker, int block, hdr_block *out, hdr_error *err);
    void (*worker_free)(hdr_source *source, void *worker);
    void (*close)(hdr_source *source);
};

/* How a file is read. */
typedef struct hdr_reading {
    uint64_t memory; /* no more bytes than that are allocated on the word of a header */
} hdr_reading;

/* Recognises the format by the first bytes and opens it. An input that is empty, of unknown form or damaged:
 * HDR_BAD_DATA, the message begins with the input's name. */
hdr_source *hdr_source_open(hdr_input *input, const hdr_reading *reading, hdr_error *err);
void hdr_source_close(hdr_source *source);

/* The formats. */
hdr_source *hdr_exr_open(hdr_input *input, const hdr_reading *reading, hdr_error *err);
hdr_source *hdr_pfm_open(hdr_input *input, const hdr_reading *reading, hdr_error *err);
hdr_source *hdr_rgbe_open(hdr_input *input, const hdr_reading *reading, hdr_error *err);
hdr_source *hdr_pfs_open(hdr_input *input, const hdr_reading *reading, hdr_error *err);
hdr_source *hdr_planes_open(hdr_input *input, hdr_error *err);

#endif

/* A source: a picture's pixels as numbered blocks of rows, which any thread may read in any order. */
#ifndef HDR_SOURCE_H
#define HDR_SOURCE_H

#include "io/exr_attributes.h"
#include "picture/picture.h"

typedef struct hdr_source hdr_source;

/* What one format provides. */
struct hdr_source {
    hdr_picture picture; /* its data window may be empty where the file is cropped: then there are no blocks */
    int block_rows;      /* rows of every block but the first and the last: a multiple of the file's chunk height */
    int rows_cut;        /* how many rows fewer the first has; less than block_rows */
    int blocks;
    uint64_t end; /* where another picture may stand, behind this one's bytes; 0: the format has one only */
    /* Who reads the source may say that only columns first ... end-1 of the data window are looked at: then the others
     * need not be decoded, and hold anything. end = 0: all are. */
    int64_t first_column, end_column;
    int tile_columns; /* tiles: how many columns each has; 0: all that a row of the data window has are decoded together
                       */
    /* One worker per thread holds the buffers: new, read as often as wanted, free. */
    hdr_status (*worker_new)(hdr_source *source, void **worker, hdr_error *err);
    /* Decodes a block. What it points to stays valid until the worker's next read. */
    hdr_status (*read)(hdr_source *source, void *worker, int block, hdr_block *out, hdr_error *err);
    void (*worker_free)(hdr_source *source, void *worker);
    /* The same of one worker, where there are tiles: what it reads from now on. NULL: there are none. */
    void (*worker_columns)(void *worker, int64_t first, int64_t end);
    void (*close)(hdr_source *source);
};

/* The block that holds a row of the data window, and the row at which a block begins; that of a block behind the last
 * is the data window's height. */
static inline int hdr_source_block_of(const hdr_source *source, int row) {
    return (int)(((int64_t)row + source->rows_cut) / source->block_rows);
}
static inline int hdr_source_first_row(const hdr_source *source, int block) {
    int64_t first = (int64_t)block * source->block_rows - source->rows_cut;
    int64_t height = hdr_window_height(&source->picture.data);
    return (int)(first < 0 ? 0 : first < height ? first : height);
}

/* How a file is read, and what of it. The strings belong to who fills it; NULL: not asked for. */
typedef struct hdr_reading {
    uint64_t memory;     /* no more bytes than that are allocated on the word of a header */
    const char *part;    /* number or name; otherwise the first that has what is wanted */
    const char *layer;   /* layer or view; otherwise the unnamed one */
    const char *channel; /* this one alone, as grey */
    bool no_alpha;       /* alpha will be dropped */
    bool proxy;          /* level is a number of pixels: of the levels whose larger side has as many, the smallest */
    int64_t level;       /* of a mip map; 0 is full resolution */
    bool cropped;
    hdr_window crop; /* where cropped: the picture is this rectangle of the display window's coordinates */
} hdr_reading;

/* Recognises the format by the first bytes and opens it. An input that is empty, of unknown form or damaged:
 * HDR_BAD_DATA, the message begins with the input's name. */
hdr_source *hdr_source_open(hdr_input *input, const hdr_reading *reading, hdr_error *err);
void hdr_source_close(hdr_source *source);

/* All that a file holds, for hdr_input_contents. Of the reading only the memory matters. */
hdr_contents *hdr_source_contents(hdr_input *input, const hdr_reading *reading, hdr_error *err);

/* The attributes of the picture's file that go along into a file written of it, see io/exr_attributes.h. */
hdr_status hdr_source_attributes(hdr_input *input, const hdr_picture *picture, hdr_exr_fate fate, hdr_bytes *out,
                                 int *left_out, hdr_error *err);

/* The number that an attribute of the same file is; NaN: it is none. HDR_BAD_DATA: there is no such attribute. */
hdr_status hdr_source_number(hdr_input *input, const hdr_picture *picture, const char *name, double *number,
                             hdr_error *err);

/* The formats. */
hdr_source *hdr_exr_open(hdr_input *input, const hdr_reading *reading, hdr_error *err);
hdr_source *hdr_pfm_open(hdr_input *input, const hdr_reading *reading, hdr_error *err);
hdr_source *hdr_rgbe_open(hdr_input *input, const hdr_reading *reading, hdr_error *err);
hdr_source *hdr_pfs_open(hdr_input *input, const hdr_reading *reading, hdr_error *err);
hdr_source *hdr_planes_open(hdr_input *input, hdr_error *err);
hdr_contents *hdr_exr_contents(hdr_input *input, hdr_error *err);

/* A source of which only a rectangle is left, in the display window's coordinates: data window, display window and all.
 * It takes the other source over, in any case. NULL: out of memory. */
hdr_source *hdr_crop_open(hdr_source *whole, const hdr_window *rectangle, hdr_error *err);

#endif

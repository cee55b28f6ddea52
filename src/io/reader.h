/* A source that one thread reads row by row, from above. */
#ifndef HDR_READER_H
#define HDR_READER_H

#include "io/source.h"

typedef struct hdr_reader {
    hdr_source *source;
    void *worker;
    hdr_block block; /* that has the row which was asked for last */
    int current;     /* its number; -1: there is none */
} hdr_reader;

/* Of a source whose tile_columns is above 0, only columns first ... end-1 of the data window are looked at; end = 0:
 * all are. Close it in any case. */
hdr_status hdr_reader_open(hdr_reader *reader, hdr_source *source, int64_t first_column, int64_t end_column,
                           hdr_error *err);
void hdr_reader_close(hdr_reader *reader);

/* Decodes the block that has a row of the data window, unless that is at hand. */
hdr_status hdr_reader_seek(hdr_reader *reader, int row, hdr_error *err);

/* count <= HDR_STRIP numbers from x on of a block's row, counted from the block's first, as they are stored. How many
 * of them are not finite. */
uint64_t hdr_block_load(const hdr_block *block, int channel, int row, size_t x, double *out, size_t count);

#endif

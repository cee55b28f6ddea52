/* What sources have in common whose files are a header of text and rows of plain pixels behind it: PFM, Radiance HDR,
 * PFS. Their planes are float and the data window is the frame. */
#ifndef HDR_RASTER_H
#define HDR_RASTER_H

#include "io/source.h"

/* ---- The header ---- */

/* Text of an input, line by line. Zero-initialise all but the input. */
typedef struct hdr_lines {
    hdr_input *input;
    uint64_t offset; /* of the byte behind the last line */
    char text[2048]; /* the last line, without its end */
} hdr_lines;

/* Reads the next line into lines->text. HDR_BAD_DATA: it is longer than that, or, where long ones are cut, than 64 KiB;
 * it begins behind the file's first MiB; the file ends within it. A pipe may send what has no end. */
hdr_status hdr_lines_next(hdr_lines *lines, bool cut, hdr_error *err);

/* A whole number from 0 to INT32_MAX at *text, behind any spaces; *text moves behind it. False: there is none. */
bool hdr_text_integer(const char **text, int *value);

/* Spaces and the end of text. */
bool hdr_text_ends(const char *text);

/* "NAME: the header is damaged: WHAT" */
hdr_status hdr_header_fault(const hdr_input *input, const char *what, hdr_error *err);

/* ---- The source ---- */

typedef struct hdr_raster {
    hdr_source base; /* first, so that the one pointer is the other */
    hdr_input *input;
    int width, height;
} hdr_raster;

/* Fills all of it but read and close: blocks of 16 rows; a linear picture of Rec.709 whose channels have these names
 * (R G B or Y in front, alpha in [3]; NULL where there is none). A picture of which one block does not fit the memory
 * allowed: HDR_BAD_DATA. */
hdr_status hdr_raster_open(hdr_raster *raster, hdr_input *input, int width, int height, const char *format,
                           const char *const names[4], uint64_t memory, hdr_error *err);

/* Makes sure that the input reaches as far as end: waits for a pipe's bytes, and allocates nothing. False: it does not,
 * and then hdr_input_size tells how far it does; or err is filled (HDR_IO). */
bool hdr_raster_reaches(const hdr_raster *raster, uint64_t end, hdr_error *err);

/* One thread's buffers. */
typedef struct hdr_raster_worker {
    unsigned char *bytes; /* of the file */
    float *samples;
    size_t bytes_room, samples_room;
} hdr_raster_worker;

/* At least size bytes in worker->bytes. */
hdr_status hdr_raster_bytes(hdr_raster_worker *worker, size_t size, hdr_error *err);

/* Describes block index and gives its planes room in worker->samples, row behind row; plane[p] is where plane p of it
 * begins, NULL where the picture has none. */
hdr_status hdr_raster_block(const hdr_raster *raster, hdr_raster_worker *worker, int index, hdr_block *block,
                            float *plane[4], hdr_error *err);

/* Reads size bytes. Fewer are left: HDR_BAD_DATA, naming the rows from first to last. */
hdr_status hdr_raster_read(const hdr_raster *raster, void *to, size_t size, uint64_t offset, int first, int last,
                           hdr_error *err);

#endif

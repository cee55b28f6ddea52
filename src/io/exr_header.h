/* The header of an EXR file: read, checked, and reduced to what decoding needs. */
#ifndef HDR_EXR_HEADER_H
#define HDR_EXR_HEADER_H

#include "io/input.h"
#include "picture/picture.h"

#include <openexr.h>

/* A single-part file of flat pixels at full resolution; everything else has been refused. */
typedef struct hdr_exr_header {
    hdr_picture picture;
    exr_compression_t compression;
    bool tiled;
    int64_t width, height; /* of the data window */
    int tile_width;        /* no more than width */
    int chunk_rows;        /* rows of a chunk: a tile's height (no more than height), or as many lines as are compressed
                              together */
    size_t pixel_bytes;    /* of one pixel over all channels of the file */
    size_t before[4];      /* of one pixel over the channels that stand in front of the picture's channel 0 ... 3 */
    int index[4];          /* of the picture's channels in list; -1: there is none */
    bool sampled;          /* some channel of the file is subsampled: lines differ in length, `before` is of no use */
    int chroma;            /* luminance-chroma: the picture's channels 0 ... 2 are Y, RY, BY as they are stored, chroma
                              with a sample in each chroma-th column of each chroma-th row (1 or 2); else 0 */
    const exr_attr_chlist_t *list; /* all channels of the file; it belongs to context */
    uint64_t table_offset;         /* where the chunk table begins: right behind the header */
    exr_context_t context;         /* the library's view of it, which its decoders want to see */
    struct hdr_exr_text *text;
} hdr_exr_header;

/* HDR_BAD_DATA: damaged, or a kind of EXR that is not read; the message says which. header is cleared first. */
hdr_status hdr_exr_header_read(hdr_input *input, hdr_exr_header *header, hdr_error *err);
void hdr_exr_header_free(hdr_exr_header *header);

#endif

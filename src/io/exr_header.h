/* The header of an EXR file: read, checked, and reduced to what decoding needs. */
#ifndef HDR_EXR_HEADER_H
#define HDR_EXR_HEADER_H

#include "io/source.h"

#include <openexr.h>

/* One part of flat pixels at one level; what is not read has been refused. */
typedef struct hdr_exr_header {
    hdr_picture picture;
    exr_compression_t compression;
    bool tiled;
    bool multi_part;       /* then the part's number stands in front of each chunk */
    int64_t width, height; /* of the data window, at the level that is read */
    int tile_width;        /* no more than width */
    int chunk_rows;        /* rows of a chunk: a tile's height (no more than height), or as many lines as are compressed
                              together */
    size_t pixel_bytes;    /* of one pixel over all channels of the file */
    size_t before[4];      /* of one pixel over the channels that stand in front of the picture's channel 0 ... 3 */
    uint64_t first_chunk;  /* number of the level's first chunk among all of the part */
    uint64_t all_chunks;   /* of the part, over all levels */
    uint64_t table_offset; /* where the level's entries of the chunk table begin */
    uint64_t tables;       /* where the tables of all parts begin */
    uint64_t tables_end;   /* and where they end: chunks stand behind it */
    exr_context_t context; /* the library's view of it, which its decoders want to see */
    int index[4];          /* of the picture's channels in list; -1: there is none */
    bool sampled;          /* some channel of the file is subsampled: lines differ in length, `before` is of no use */
    int chroma;            /* luminance-chroma: the picture's channels 0 ... 2 are Y, RY, BY as they are stored, chroma
                              with a sample in each chroma-th column of each chroma-th row (1 or 2); else 0 */
    const exr_attr_chlist_t *list; /* all channels of the file; it belongs to context */
    struct hdr_exr_headers *headers;
} hdr_exr_header;

/* HDR_BAD_DATA: damaged, or a kind of EXR that is not read; the message says which. header is cleared first. */
hdr_status hdr_exr_header_read(hdr_input *input, const hdr_reading *reading, hdr_exr_header *header, hdr_error *err);
void hdr_exr_header_free(hdr_exr_header *header);

#endif

/* From the packed bytes of an EXR chunk to its pixels. */
#ifndef HDR_EXR_UNPACK_H
#define HDR_EXR_UNPACK_H

#include "io/exr_header.h"

/* A chunk's place: a band of lines, or a tile of the level that is read. */
typedef struct hdr_exr_chunk {
    int64_t index; /* in the chunk table, among those of its level */
    int x, y;      /* as in its own leader: a tile's number across and down, or (data window's left edge, first line) */
    int width, height;  /* pixels; the last ones of the picture may be smaller */
    size_t packed_size; /* bytes in the file */
    size_t size;        /* bytes of the pixels, over all channels */
} hdr_exr_chunk;

/* One thread's means of unpacking. */
typedef struct hdr_exr_unpacker hdr_exr_unpacker;

/* NULL: memory is out, or a plug-in that the compression needs is not there (HDR_BAD_DATA); the message does not name
 * the file. */
hdr_exr_unpacker *hdr_exr_unpacker_new(const hdr_exr_header *header, hdr_error *err);
void hdr_exr_unpacker_free(hdr_exr_unpacker *unpacker);

/* Fills out[0 ... chunk->size-1]: line after line, in each the channels in the file's order. Not for a chunk whose
 * packed size is its size: that one is stored as it is. False: the packed bytes are damaged, or memory is out. */
bool hdr_exr_unpack(hdr_exr_unpacker *unpacker, const hdr_exr_chunk *chunk, const unsigned char *packed,
                    unsigned char *out);

/* Whether that many packed bytes can hold that many bytes of pixels, so that a claim is doubted before memory is spent
 * on it. */
bool hdr_exr_plausible(const hdr_exr_header *header, const hdr_exr_chunk *chunk);

#endif

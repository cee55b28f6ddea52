/* Radiance HDR files: what their header says, and their scanlines.
 *
 * G. Ward, "Real Pixels", Graphics Gems II, 1991: a pixel is three mantissas of 8 bits and one exponent for all three.
 * The file around them is described in "Radiance File Formats", section "Picture File Format". */
#ifndef HDR_RGBE_H
#define HDR_RGBE_H

#include "io/raster.h"

enum {
    HDR_RGBE_SHORTEST = 8,     /* scanlines of fewer pixels, */
    HDR_RGBE_LONGEST = 0x7fff, /* or of more, are never packed component by component */
    HDR_RGBE_BIAS = 128 + 8    /* component = mantissa * 2^(exponent - bias) */
};

typedef struct hdr_rgbe_header {
    int width, height;
    bool columns;             /* a scanline is a column of the picture, not a row */
    bool scanlines_backwards; /* the first is the bottom row, or the rightmost column */
    bool pixels_backwards;    /* a scanline's first pixel is its rightmost, or its bottommost */
    bool xyz;                 /* X, Y and Z instead of R, G and B */
    double exposure[3];       /* product of what each component has been multiplied by */
    double pixel_height;      /* of a pixel, over its width */
    bool has_primaries;
    hdr_chromaticities primaries;
    uint64_t data; /* where the scanlines begin */
} hdr_rgbe_header;

hdr_status hdr_rgbe_header_read(hdr_input *input, hdr_rgbe_header *header, hdr_error *err);

/* Bytes of the input one after the other. */
typedef struct hdr_rgbe_stream {
    hdr_input *input;
    uint64_t offset; /* behind what is in the buffer */
    uint64_t least;  /* so many more bytes can be waited for */
    hdr_error *err;  /* filled (HDR_IO) when reading fails, which looks like the end otherwise */
    size_t have, at;
    unsigned char buffer[16384];
} hdr_rgbe_stream;

/* Starts at offset. Bytes behind offset + least are asked for one by one: a pipe may not have them. */
void hdr_rgbe_start(hdr_rgbe_stream *stream, hdr_input *input, uint64_t offset, uint64_t least, hdr_error *err);

/* Where the next byte stands. */
static inline uint64_t hdr_rgbe_place(const hdr_rgbe_stream *stream) {
    return stream->offset - (stream->have - stream->at);
}

/* Reads a scanline of length pixels, whichever way it is packed, into the bytes of each component; NULL: only finds its
 * end. Returns NULL, or what is wrong with it. */
const char *hdr_rgbe_scanline(hdr_rgbe_stream *stream, int length, unsigned char *const component[4]);

#endif

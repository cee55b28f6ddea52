/* From luminance and subsampled chroma to R, G, B, as OpenEXR's RgbaInputFile computes it, to the last bit.
 *
 * That class holds every intermediate result as a half. Here such values are floats that a half can hold: rounding to
 * half is to nearest, ties to even, to infinity beyond the largest half; arithmetic in between is in float, in the
 * order that is written down. All take counts, none allocates. */
#ifndef HDR_CHROMA_H
#define HDR_CHROMA_H

#include "base/base.h"

enum {
    HDR_CHROMA_TAPS = 14,  /* of the filter that makes a sample between two others */
    HDR_CHROMA_BEFORE = 6, /* samples that it takes in front of the one in front of the gap */
    HDR_CHROMA_BEHIND = 7  /* and behind that one */
};

/* Half to float, infinities and NaN included. */
void hdr_half_to_float(const uint16_t *half, float *out, size_t count);

/* Rounds each to a half, held as float, as the library does on reading: what is beyond the largest half at all becomes
 * infinite. */
void hdr_float_to_half_grid(const float *in, float *out, size_t count);

/* From values that a half can hold to halves. */
void hdr_half_grid_to_half(const float *in, uint16_t *out, size_t count);

/* Along a row: out[2i] = samples[i], out[2i+1] lies between samples i and i+1; i = 0 ... count-1.
 * samples[-HDR_CHROMA_BEFORE ... count-1+HDR_CHROMA_BEHIND] are read. */
void hdr_chroma_across(const float *samples, float *out, size_t count);

/* Across rows: out lies between rows HDR_CHROMA_BEFORE and HDR_CHROMA_BEFORE + 1. */
void hdr_chroma_down(const float *const row[HDR_CHROMA_TAPS], float *out, size_t count);

/* RGB of luminance Y and chroma RY = (R - Y) / Y, BY = (B - Y) / Y; w: Y = w[0] R + w[1] G + w[2] B. */
void hdr_chroma_to_rgb(const float *y, const float *ry, const float *by, const float w[3], float *const rgb[3],
                       size_t count);

/* 1 - min / max of R, G, B; 0 where max <= 0. */
void hdr_rgb_saturation(const float *const rgb[3], float *out, size_t count);

/* Takes colour from pixels that are much more saturated than their four diagonal neighbours, which is what filtering
 * chroma does at edges, and writes halves. above and below: saturation of the rows around; of them [-1 ... count] are
 * read. */
void hdr_fix_saturation(const float *const rgb[3], const float *above, const float *at, const float *below,
                        const float w[3], uint16_t *const out[3], size_t count);

#endif

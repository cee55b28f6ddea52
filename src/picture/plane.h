/* One number for each pixel of the data window: what spatial algorithms work on. */
#ifndef HDR_PLANE_H
#define HDR_PLANE_H

#include "kernel/convolve.h"

/* Rows are a whole number of HDR_PIECEs, so that loops over pieces have no ends to see to; what stands behind the width
 * does not matter. */

typedef struct hdr_plane {
    int width, height;
    size_t stride; /* numbers from one row to the next */
    float *narrow; /* either these */
    double *wide;  /* or these, for the reference */
} hdr_plane;

/* NULL: out of memory. */
hdr_plane *hdr_plane_new(int width, int height, bool wide, hdr_error *err);
void hdr_plane_free(hdr_plane *plane);

/* The index that stands at i in 0 ... size-1 when these are mirrored at both ends, the last number standing twice:
 * half-sample symmetric. */
static inline int hdr_mirrored(int64_t i, int size) {
    int64_t period = 2 * (int64_t)size;
    i %= period;
    if (i < 0) i += period;
    return (int)(i < size ? i : period - 1 - i);
}

/* ---- Masks: a bit for each pixel of a plane, rows beginning at whole bytes ---- */

static inline size_t hdr_mask_row(int width) {
    return ((size_t)width + 7) / 8;
}

/* Whether pixel x of a mask's row is in it. */
static inline bool hdr_mask_has(const unsigned char *row, int x) {
    return row[x / 8] >> x % 8 & 1;
}

#endif

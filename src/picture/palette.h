/* Palettes of false colour, and the legend that tells what their colours stand for. */
#ifndef HDR_PALETTE_H
#define HDR_PALETTE_H

#include "base/base.h"

/* In this order; all names of them, for tables of options. */
enum {
    HDR_PALETTE_VIRIDIS,
    HDR_PALETTE_MAGMA,
    HDR_PALETTE_INFERNO,
    HDR_PALETTE_PLASMA,
    HDR_PALETTE_COOLWARM, /* it parts in the middle: for what may lie on either side of 0 */
    HDR_PALETTES
};
#define HDR_PALETTE_NAMES "viridis", "magma", "inferno", "plasma", "coolwarm"

/* 256 colours, 0xRRGGBB in sRGB's codes, of the smallest value first. */
enum { HDR_PALETTE_SIZE = 256 };
const uint32_t *hdr_palette(int which);

/* What a legend tells: the values that the first colour begins with and the last one ends with. */
typedef struct hdr_legend {
    const uint32_t *palette; /* NULL: there is none */
    double from, to;
    bool logarithmic; /* even steps are even ratios; from > 0 */
} hdr_legend;

/* A legend below a picture, drawn: a bar of all colours with numbers below it, as many as fit. */
typedef struct hdr_drawing {
    int width, height;
    uint32_t *pixels; /* 0xRRGGBB, by rows from above */
} hdr_drawing;

/* Height of the legend below a picture of that size. */
int hdr_legend_height(int width, int height);

/* Free with hdr_drawing_free in any case. */
hdr_status hdr_legend_draw(const hdr_legend *legend, int width, int height, hdr_drawing *drawing, hdr_error *err);
void hdr_drawing_free(hdr_drawing *drawing);

#endif

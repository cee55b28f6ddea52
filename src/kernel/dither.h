/* Dither: thresholds that take the place of the 1/2 in rounding, by where a pixel stands. A tile of 64 x 64 holds each
 * of the ranks 0 ... 4095 once; the threshold is (rank + 1/2) / 4096. So a value of f codes above a whole one is
 * rounded up at as many of the tile's pixels as is right, within half a pixel; whole codes, black and white among them,
 * stay as they are. */
#ifndef HDR_DITHER_H
#define HDR_DITHER_H

#include <stddef.h>
#include <stdint.h>

enum { HDR_DITHER_SIDE = 64, HDR_DITHER_RANKS = HDR_DITHER_SIDE * HDR_DITHER_SIDE };

typedef enum hdr_dither_kind { HDR_DITHER_NONE, HDR_DITHER_ORDERED, HDR_DITHER_BLUE } hdr_dither_kind;

typedef struct hdr_dither {
    hdr_dither_kind kind; /* not none */
    unsigned x, y;        /* how far the tile is moved */
} hdr_dither;

/* Other seeds move the tile; 0 leaves it where it is. */
hdr_dither hdr_dither_seeded(hdr_dither_kind kind, uint32_t seed);

/* The threshold of a pixel, and those of a row's pixels from x on. */
double hdr_dither_threshold(const hdr_dither *dither, int x, int y);
void hdr_dither_thresholds(const hdr_dither *dither, int x, int y, double *thresholds, size_t count);

/* Blue noise by rows: what tests/oracle/derive_blue.py prints. */
extern const uint16_t hdr_blue_ranks[HDR_DITHER_RANKS];

#endif

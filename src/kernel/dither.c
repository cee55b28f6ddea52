#include "kernel/dither.h"

#include <string.h>

/* Any seed's bits, mixed; 0 stays 0. The finaliser of Austin Appleby's MurmurHash3. */
static uint32_t mixed(uint32_t bits) {
    bits ^= bits >> 16;
    bits *= 0x85ebca6bu;
    bits ^= bits >> 13;
    bits *= 0xc2b2ae35u;
    return bits ^ bits >> 16;
}

hdr_dither hdr_dither_seeded(hdr_dither_kind kind, uint32_t seed) {
    uint32_t place = mixed(seed) % HDR_DITHER_RANKS;
    return (hdr_dither){.kind = kind, .x = place % HDR_DITHER_SIDE, .y = place / HDR_DITHER_SIDE};
}

/* Bayer, "An optimum method for two-level rendition of continuous-tone pictures", ICC 1973: the matrix of side 2n is 4
 * times that of side n, repeated, plus [0 2; 3 1] by quarters. So the bits of x ^ y and y, interleaved, the lowest of
 * them first, are the rank. */
static unsigned ordered_rank(unsigned x, unsigned y) {
    unsigned rank = 0;
    for (unsigned bit = 1; bit < HDR_DITHER_SIDE; bit *= 2)
        rank = rank << 2 | ((x ^ y) & bit ? 2u : 0u) | (y & bit ? 1u : 0u);
    return rank;
}

double hdr_dither_threshold(const hdr_dither *dither, int x, int y) {
    unsigned column = ((unsigned)x + dither->x) % HDR_DITHER_SIDE, row = ((unsigned)y + dither->y) % HDR_DITHER_SIDE;
    unsigned rank =
        dither->kind == HDR_DITHER_ORDERED ? ordered_rank(column, row) : hdr_blue_ranks[row * HDR_DITHER_SIDE + column];
    return (rank + 0.5) / HDR_DITHER_RANKS;
}

void hdr_dither_thresholds(const hdr_dither *dither, int x, int y, double *thresholds, size_t count) {
    size_t first = count < HDR_DITHER_SIDE ? count : HDR_DITHER_SIDE;
    for (size_t i = 0; i < first; i++)
        thresholds[i] = hdr_dither_threshold(dither, x + (int)i, y);
    for (size_t i = first; i < count; i++)
        thresholds[i] = thresholds[i - HDR_DITHER_SIDE];
}

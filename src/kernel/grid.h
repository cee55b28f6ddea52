/* Inner loops of a grid of cells that pixels are sown into and read from by cubic B-splines. A column of cells holds
 * pairs, W and N, one pair for each of its levels. */
#ifndef HDR_GRID_H
#define HDR_GRID_H

#include "base/base.h"

/* Where a number stands among nodes: between node first + 1 and the next; and the weights of nodes first ... first + 3.
 */
typedef struct hdr_spline {
    int first;
    float weight[4];
} hdr_spline;

/* Of `place` nodes, at least 0: its nodes begin at floor(place). Node n stands at place n - 1. */
hdr_spline hdr_spline_at(double place);

/* The same of (numbers[i] - low) / step. */
void hdr_splines_of(const float *numbers, double low, double step, hdr_spline *out, size_t count);

/* For each pixel, a row's numbers less `middle`: adds its weight to W and its weight times the number to N of 4 x 4
 * nodes. across: of the pixel's column. deep: of the number; stored[deep.first] is where its four levels begin, each
 * level being a pair. slab: columns of `stride` floats. */
void hdr_grid_sow(const float *numbers, float middle, const hdr_spline *across, const hdr_spline *deep,
                  const int *stored, size_t count, float *slab, size_t stride);

/* out[i] = middle + N / W, read at each pixel's place. */
void hdr_grid_read(float middle, const hdr_spline *across, const hdr_spline *deep, const int *stored, size_t count,
                   const float *slab, size_t stride, float *out);

/* out[i] = sum of weight[k] row[k][i], k = 0 ... 3; and row[k][i] += weight[k] in[i]. */
void hdr_grid_gather(const float *const row[4], const float weight[4], float *out, size_t count);
void hdr_grid_spread(const float *in, const float weight[4], float *const row[4], size_t count);

#endif

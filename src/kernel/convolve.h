/* Inner loops of spatial algorithms, in float. What becomes of a pixel is computed in one order, whatever the
 * instruction set. */
#ifndef HDR_CONVOLVE_H
#define HDR_CONVOLVE_H

#include "base/base.h"

/* Numbers that are computed together: loops are over a piece or a multiple of it. */
#define HDR_PIECE 64

/* out[x] = weight[0] row[0][x] + sum of weight[k] (row[k][x] + row[-k][x]), k = 1 ... reach, for a piece from x on. */
void hdr_convolve_down(const float *const *row, size_t x, const float *weight, int reach, float *out);

/* out[i] = weight[0] in[i] + sum of weight[k] (in[i + k] + in[i - k]), k = 1 ... reach, i = 0 ... count - 1. count is a
 * multiple of HDR_PIECE. */
void hdr_convolve_across(const float *in, const float *weight, int reach, float *out, size_t count);

/* The sum of weight[i] in[i], in double. */
double hdr_weighted_sum(const float *in, const double *weight, size_t count);

/* A test of |v - next| > epsilon (offset + v), evaluated in double, where v and next may both be wrong by `error` of
 * themselves and by `slack`. */
typedef struct hdr_uneven {
    double epsilon, offset, error, slack;
    unsigned char mark;
} hdr_uneven;

/* For each number of a piece that is marked as open: where the test succeeds for sure it is marked with test->mark, and
 * v goes to out; where the error leaves that open, it is marked as doubtful. Returns how many are open, those included.
 */
enum { HDR_OPEN = 255, HDR_DOUBTFUL = 254 };
typedef struct hdr_open {
    int open, doubtful;
} hdr_open;
hdr_open hdr_close_uneven(const float *v, const float *next, const hdr_uneven *test, unsigned char *marks, float *out);

/* The least and the largest number of a piece, with those before. */
void hdr_range_of_piece(const float *numbers, float *least, float *largest);

#endif

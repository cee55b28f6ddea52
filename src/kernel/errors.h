/* Sums over the differences of two rows of numbers. */
#ifndef HDR_KERNEL_ERRORS_H
#define HDR_KERNEL_ERRORS_H

#include "base/base.h"

/* x: test, r: reference, d = x - r, e = epsilon. */
enum {
    HDR_SUM_COUNT,           /* 1 */
    HDR_SUM_SIGNED,          /* d */
    HDR_SUM_ABSOLUTE,        /* |d| */
    HDR_SUM_SQUARED,         /* d^2 */
    HDR_SUM_RELATIVE_SQUARE, /* d^2 / (r^2 + e) */
    HDR_SUM_RELATIVE,        /* |d| / (|r| + e) */
    HDR_SUM_SYMMETRIC,       /* |d| / (|x| + |r| + e) */
    HDR_ERROR_SUMS
};

/* Adds those of `count` pairs to sums; number i goes to lane i mod 8, the lanes are added in a fixed order. A pair of
 * which one is NaN or infinite counts for nothing. */
void hdr_error_sums(const double *x, const double *r, size_t count, double epsilon, double sums[HDR_ERROR_SUMS]);

/* The first of the pairs that are farthest apart, if they are farther than *worst, which becomes their |d|; `count`
 * where none is. */
size_t hdr_error_worst(const double *x, const double *r, size_t count, double *worst);

#endif

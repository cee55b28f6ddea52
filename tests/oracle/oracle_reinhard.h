/* For the oracle: the surround of SPEC's `reinhard --local`, summed term by term in two dimensions, with no regard to
 * cost.
 *
 * Weights are the Gaussian's integrals over pixels, as differences of erfc, so that those far out are as accurate in
 * proportion as those in the middle. They reach 16 standard deviations: what is beyond weighs 1e-57. All terms are
 * positive and no sum has more than some hundred parts, so a result is within 1e-13 of the real one, in proportion. */
#ifndef HDR_TESTS_ORACLE_REINHARD_H
#define HDR_TESTS_ORACLE_REINHARD_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>

enum {
    ORACLE_SCALES = 9,
    ORACLE_DEVIATIONS = 16, /* that a kernel reaches */
    ORACLE_REACH = 172      /* 16 standard deviations of the widest, in pixels */
};

/* s_i = 1.6^i. */
static long double oracle_scale(int i) {
    long double s = 1;
    while (i-- > 0)
        s *= 1.6L;
    return s;
}

typedef struct oracle_kernel {
    int reach;
    double weight[ORACLE_REACH + 1]; /* of the pixel that many pixels off */
} oracle_kernel;

static oracle_kernel oracle_gaussian(int scale) {
    const long double deviation = oracle_scale(scale) / 4, unit = deviation * sqrtl(2);
    oracle_kernel kernel = {.reach = (int)ceill(ORACLE_DEVIATIONS * deviation)};
    long double weight[ORACLE_REACH + 1] = {0}, sum = 0;
    for (int d = kernel.reach; d >= 0; d--) {
        weight[d] = d ? (erfcl((d - 0.5L) / unit) - erfcl((d + 0.5L) / unit)) / 2 : erfl(0.5L / unit);
        sum += d ? 2 * weight[d] : weight[d];
    }
    for (int d = 0; d <= kernel.reach; d++)
        kernel.weight[d] = (double)(weight[d] / sum);
    return kernel;
}

/* Half-sample symmetric: ... 1 0 | 0 1 ... n-1 | n-1 n-2 ..., as often as need be. */
static int oracle_reflect(int place, int size) {
    int period = place % (2 * size);
    if (period < 0) period += 2 * size;
    return period < size ? period : 2 * size - 1 - period;
}

/* The weights, along one axis, of the pixels that a pixel's kernel meets, those that it meets by reflection included.
 */
typedef struct oracle_fold {
    int first, count;
    double weight[2 * ORACLE_REACH + 1];
} oracle_fold;

static void oracle_fold_at(const oracle_kernel *kernel, int place, int size, oracle_fold *fold) {
    int first = place - kernel->reach > 0 ? place - kernel->reach : 0;
    int last = place + kernel->reach < size - 1 ? place + kernel->reach : size - 1;
    fold->first = first;
    fold->count = last - first + 1;
    for (int i = 0; i < fold->count; i++)
        fold->weight[i] = 0;
    for (int d = -kernel->reach; d <= kernel->reach; d++)
        fold->weight[oracle_reflect(place + d, size) - first] += kernel->weight[abs(d)];
}

/* V_scale of the plane. */
typedef void oracle_blur(const double *plane, int width, int height, int scale, double *blurred);

/* The sum over all pixels of the kernel, each with the product of its two weights. */
static void oracle_blur_directly(const double *plane, int width, int height, int scale, double *blurred) {
    const oracle_kernel kernel = oracle_gaussian(scale);
    oracle_fold across, down;
    for (int y = 0; y < height; y++) {
        oracle_fold_at(&kernel, y, height, &down);
        for (int x = 0; x < width; x++) {
            double sum = 0;
            oracle_fold_at(&kernel, x, width, &across);
            for (int j = 0; j < down.count; j++) {
                const double *row = plane + (size_t)(down.first + j) * (size_t)width + across.first;
                double part = 0;
                for (int i = 0; i < across.count; i++)
                    part += down.weight[j] * across.weight[i] * row[i];
                sum += part;
            }
            *blurred++ = sum;
        }
    }
}

/* The same along columns and then along rows, for pictures that are too big for that; oracle_blur_directly vouches for
 * it where both are tried. */
static inline void oracle_blur_by_axes(const double *plane, int width, int height, int scale, double *blurred) {
    const oracle_kernel kernel = oracle_gaussian(scale);
    oracle_fold fold;
    double *columns = calloc((size_t)width * (size_t)height, sizeof *columns);
    if (!columns) abort();
    for (int y = 0; y < height; y++) {
        double *to = columns + (size_t)y * (size_t)width;
        oracle_fold_at(&kernel, y, height, &fold);
        for (int j = 0; j < fold.count; j++)
            for (int x = 0; x < width; x++)
                to[x] += fold.weight[j] * plane[(size_t)(fold.first + j) * (size_t)width + (size_t)x];
    }
    for (int x = 0; x < width; x++) {
        oracle_fold_at(&kernel, x, width, &fold);
        for (int y = 0; y < height; y++) {
            const double *from = columns + (size_t)y * (size_t)width + fold.first;
            double sum = 0;
            for (int i = 0; i < fold.count; i++)
                sum += fold.weight[i] * from[i];
            blurred[(size_t)y * (size_t)width + (size_t)x] = sum;
        }
    }
    free(columns);
}

/* m = the first i of 0 ... 7 with |A_i| > epsilon, else 7. v: V_0 ... V_8 of one pixel, in units of the plane.
 * margin: the least | |A_i| - epsilon | over i <= m. */
static int oracle_choose(const double v[ORACLE_SCALES], double scale, double key, double phi, double epsilon,
                         double *margin) {
    *margin = INFINITY;
    for (int i = 0;; i++) {
        long double s = oracle_scale(i), centre = (long double)scale * v[i];
        long double activity =
            (long double)scale * ((long double)v[i] - v[i + 1]) / (exp2l(phi) * key / (s * s) + centre);
        double distance = (double)fabsl(fabsl(activity) - epsilon);
        if (distance < *margin) *margin = distance;
        if (fabsl(activity) > epsilon || i == ORACLE_SCALES - 2) return i;
    }
}

static inline void oracle_surround_by(oracle_blur *blur, const double *plane, int width, int height, double scale,
                                      double key, double phi, double epsilon, double *surround, unsigned char *chosen,
                                      double *margin) {
    const size_t pixels = (size_t)width * (size_t)height;
    double *stack = calloc(pixels * ORACLE_SCALES, sizeof *stack);
    if (!stack) abort();
    for (int i = 0; i < ORACLE_SCALES; i++)
        blur(plane, width, height, i, stack + (size_t)i * pixels);
    for (size_t p = 0; p < pixels; p++) {
        double v[ORACLE_SCALES];
        for (int i = 0; i < ORACLE_SCALES; i++)
            v[i] = stack[(size_t)i * pixels + p];
        chosen[p] = (unsigned char)oracle_choose(v, scale, key, phi, epsilon, &margin[p]);
        surround[p] = v[chosen[p]];
    }
    free(stack);
}

/* For each pixel of a plane, whose values times scale are L: V_m in units of the plane, m, and the margin of the
 * choice.
 */
static inline void oracle_surround(const double *plane, int width, int height, double scale, double key, double phi,
                                   double epsilon, double *surround, unsigned char *chosen, double *margin) {
    oracle_surround_by(oracle_blur_directly, plane, width, height, scale, key, phi, epsilon, surround, chosen, margin);
}

#endif

#include "kernel/convolve.h"

#include "base/cpu.h"

#include <math.h>

/* Sixteen numbers that may stand anywhere. Four of them at a time are few enough for the registers, and enough to hide
 * the latency of the additions. */
typedef float lanes __attribute__((vector_size(64), aligned(4), may_alias));
enum { LANES = 16 };

#define AT(pointer, i) (((const lanes *)(const void *)(pointer))[i])

HDR_INLINE void hdr_convolve_down_body(const float *const *row, size_t x, const float *weight, int reach, float *out) {
    const float *centre = row[0] + x;
    lanes sum0 = weight[0] * AT(centre, 0), sum1 = weight[0] * AT(centre, 1);
    lanes sum2 = weight[0] * AT(centre, 2), sum3 = weight[0] * AT(centre, 3);
    for (int k = 1; k <= reach; k++) {
        const float *a = row[k] + x, *b = row[-k] + x;
        sum0 += weight[k] * (AT(a, 0) + AT(b, 0));
        sum1 += weight[k] * (AT(a, 1) + AT(b, 1));
        sum2 += weight[k] * (AT(a, 2) + AT(b, 2));
        sum3 += weight[k] * (AT(a, 3) + AT(b, 3));
    }
    lanes *to = (lanes *)(void *)out;
    to[0] = sum0, to[1] = sum1, to[2] = sum2, to[3] = sum3;
}
HDR_VERSIONS(hdr_convolve_down, (const float *const *row, size_t x, const float *weight, int reach, float *out),
             (row, x, weight, reach, out))

HDR_INLINE void hdr_convolve_across_body(const float *in, const float *weight, int reach, float *out, size_t count) {
    for (size_t x = 0; x < count; x += HDR_PIECE) {
        const float *centre = in + x;
        lanes sum0 = weight[0] * AT(centre, 0), sum1 = weight[0] * AT(centre, 1);
        lanes sum2 = weight[0] * AT(centre, 2), sum3 = weight[0] * AT(centre, 3);
        for (int k = 1; k <= reach; k++) {
            const float *a = centre + k, *b = centre - k;
            sum0 += weight[k] * (AT(a, 0) + AT(b, 0));
            sum1 += weight[k] * (AT(a, 1) + AT(b, 1));
            sum2 += weight[k] * (AT(a, 2) + AT(b, 2));
            sum3 += weight[k] * (AT(a, 3) + AT(b, 3));
        }
        lanes *to = (lanes *)(void *)(out + x);
        to[0] = sum0, to[1] = sum1, to[2] = sum2, to[3] = sum3;
    }
}
HDR_VERSIONS(hdr_convolve_across, (const float *in, const float *weight, int reach, float *out, size_t count),
             (in, weight, reach, out, count))

enum { SUMS = 16 };

/* Number i goes to sum i mod 16; the sums are added in a fixed order. */
HDR_INLINE void weighted_sum_body(const float *in, const double *weight, size_t count, double *result) {
    double sum[SUMS] = {0};
    size_t whole = count / SUMS * SUMS;
    for (size_t i = 0; i < whole; i += SUMS)
        for (size_t l = 0; l < SUMS; l++)
            sum[l] += weight[i + l] * (double)in[i + l];
    for (size_t i = whole; i < count; i++)
        sum[i - whole] += weight[i] * (double)in[i];
    for (size_t half = SUMS / 2; half > 0; half /= 2)
        for (size_t l = 0; l < half; l++)
            sum[l] += sum[l + half];
    *result = sum[0];
}
HDR_VERSIONS_IN(static, weighted_sum, (const float *in, const double *weight, size_t count, double *result),
                (in, weight, count, result))

double hdr_weighted_sum(const float *in, const double *weight, size_t count) {
    double result = 0;
    weighted_sum(in, weight, count, &result);
    return result;
}

HDR_INLINE void close_uneven_body(const float *v, const float *next, const hdr_uneven *test, unsigned char *marks,
                                  float *out, hdr_open *left) {
    const double epsilon = test->epsilon, offset = test->offset, error = test->error, slack = test->slack;
    const unsigned char mark = test->mark;
    int open = 0, doubtful = 0;
    for (int i = 0; i < HDR_PIECE; i++) {
        double here = (double)v[i], there = (double)next[i];
        double over = fabs(here - there) - epsilon * (offset + here);
        double doubt = error * (here + there + epsilon * here) + (2 + epsilon) * slack;
        bool is_open = marks[i] == HDR_OPEN;
        bool closes = is_open & (over > doubt);
        bool is_doubtful = is_open & !closes & (over >= -doubt) & (doubt > 0);
        out[i] = closes ? v[i] : out[i];
        marks[i] = closes ? mark : is_doubtful ? HDR_DOUBTFUL : marks[i];
        open += is_open & !closes;
        doubtful += is_doubtful;
    }
    *left = (hdr_open){open, doubtful};
}
HDR_VERSIONS_IN(static, close_uneven,
                (const float *v, const float *next, const hdr_uneven *test, unsigned char *marks, float *out,
                 hdr_open *left),
                (v, next, test, marks, out, left))

hdr_open hdr_close_uneven(const float *v, const float *next, const hdr_uneven *test, unsigned char *marks, float *out) {
    hdr_open left;
    close_uneven(v, next, test, marks, out, &left);
    return left;
}

HDR_INLINE void hdr_range_of_piece_body(const float *numbers, float *least, float *largest) {
    float low = *least, high = *largest;
    for (int i = 0; i < HDR_PIECE; i++) {
        low = numbers[i] < low ? numbers[i] : low;
        high = numbers[i] > high ? numbers[i] : high;
    }
    *least = low;
    *largest = high;
}
HDR_VERSIONS(hdr_range_of_piece, (const float *numbers, float *least, float *largest), (numbers, least, largest))

#include "kernel/strip.h"

#include "base/cpu.h"
#include "kernel/real.h"

#include <float.h>
#include <math.h>
#include <string.h>

HDR_INLINE double held(double c) {
    double below = c < (double)FLT_MAX ? c : (double)FLT_MAX;
    double within = below > -(double)FLT_MAX ? below : -(double)FLT_MAX;
    return fabs(within) < HDR_LEAST ? within * 0 : within;
}

double hdr_held(double c) {
    return held(c);
}

/* ---- From the stored type ---- */

HDR_INLINE void half_finite_body(const uint16_t *half, size_t count, unsigned *largest) {
    uint16_t most = 0;
    for (size_t i = 0; i < count; i++) {
        uint16_t magnitude = half[i] & 0x7fffu;
        most = magnitude > most ? magnitude : most;
    }
    *largest = most;
}
HDR_VERSIONS_IN(static, half_finite, (const uint16_t *half, size_t count, unsigned *largest), (half, count, largest))

bool hdr_half_all_finite(const uint16_t *half, size_t count) {
    unsigned largest;
    half_finite(half, count, &largest);
    return largest < 0x7c00u;
}

HDR_INLINE void float_finite_body(const float *values, size_t count, uint32_t *largest) {
    uint32_t most = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, values + i, 4);
        bits &= 0x7fffffffu;
        most = bits > most ? bits : most;
    }
    *largest = most;
}
HDR_VERSIONS_IN(static, float_finite, (const float *values, size_t count, uint32_t *largest), (values, count, largest))

bool hdr_float_all_finite(const float *values, size_t count) {
    uint32_t largest;
    float_finite(values, count, &largest);
    return largest < 0x7f800000u;
}

/* Positive numbers order as their bits do, and those of what is negative are, as whole numbers, below 0. */
HDR_INLINE void half_largest_body(const uint16_t *half, size_t count, uint16_t *largest) {
    int16_t most = 0;
    for (size_t i = 0; i < count; i++) {
        int16_t bits = (int16_t)half[i];
        most = bits > most ? bits : most;
    }
    *largest = (uint16_t)most;
}
HDR_VERSIONS_IN(static, half_largest, (const uint16_t *half, size_t count, uint16_t *largest), (half, count, largest))

uint16_t hdr_half_largest(const uint16_t *half, size_t count) {
    uint16_t largest;
    half_largest(half, count, &largest);
    return largest;
}

HDR_INLINE void real_largest_body(const double *values, size_t count, int64_t *largest) {
    int64_t most = 0;
    for (size_t i = 0; i < count; i++) {
        int64_t bits = (int64_t)hdr_real_bits(values[i]);
        most = bits > most ? bits : most;
    }
    *largest = most;
}
HDR_VERSIONS_IN(static, real_largest, (const double *values, size_t count, int64_t *largest), (values, count, largest))

double hdr_largest(const double *values, size_t count) {
    int64_t largest;
    real_largest(values, count, &largest);
    return hdr_real_from_bits((uint64_t)largest);
}

/* A half's exponent and fraction, moved to float's place, are the value times 2^-112. Subnormal halves would be
 * subnormal floats there, which are slow to work with: they get 2^-14 added (as 1.f 2^-14) and taken off again, which
 * is exact. */
HDR_INLINE double finite_half(uint16_t half) {
    uint32_t magnitude = (uint32_t)(half & 0x7fffu) << 13;
    bool subnormal = magnitude < (1u << 23);
    uint32_t bits = magnitude + ((subnormal ? 113u : 112u) << 23);
    float value;
    memcpy(&value, &bits, 4);
    value -= subnormal ? 0x1p-14f : 0;
    uint32_t sign = (uint32_t)(half & 0x8000u) << 16, signed_bits;
    memcpy(&signed_bits, &value, 4);
    signed_bits |= sign;
    memcpy(&value, &signed_bits, 4);
    return (double)value;
}

HDR_INLINE void hdr_half_to_real_body(const uint16_t *half, double *out, size_t count) {
    for (size_t i = 0; i < count; i++)
        out[i] = finite_half(half[i]);
}
HDR_VERSIONS(hdr_half_to_real, (const uint16_t *half, double *out, size_t count), (half, out, count))

HDR_INLINE void hdr_float_to_real_body(const float *values, double *out, size_t count) {
    for (size_t i = 0; i < count; i++)
        out[i] = (double)values[i];
}
HDR_VERSIONS(hdr_float_to_real, (const float *values, double *out, size_t count), (values, out, count))

double hdr_half_value(uint16_t half) {
    if ((half & 0x7c00u) != 0x7c00u) return finite_half(half);
    if (half & 0x03ffu) return (double)NAN;
    return half & 0x8000u ? -(double)INFINITY : (double)INFINITY;
}

/* ---- To the stored type ---- */

HDR_INLINE void hdr_real_to_float_body(const double *in, float *out, size_t count) {
    for (size_t i = 0; i < count; i++)
        out[i] = (float)held(in[i]);
}
HDR_VERSIONS(hdr_real_to_float, (const double *in, float *out, size_t count), (in, out, count))

/* Rounding is done by the addition of a number so large that its last place is the half's: in double, where the sum of
 * a value and such a number is rounded once, to nearest even. */
HDR_INLINE uint16_t nearest_half(double value) {
    uint64_t bits;
    memcpy(&bits, &value, 8);
    uint16_t sign = (uint16_t)(bits >> 48) & 0x8000u;
    double magnitude = fabs(value);
    magnitude = magnitude < 65504 ? magnitude : 65504;
    double floor_of_exponent = magnitude > 0x1p-14 ? magnitude : 0x1p-14;
    uint64_t exponent;
    memcpy(&exponent, &floor_of_exponent, 8);
    exponent = (exponent & 0x7ff0000000000000u) +
               ((uint64_t)42 << 52); /* 2^e becomes 2^(e + 42): its last place is 2^(e-10) */
    double anchor;
    memcpy(&anchor, &exponent, 8);
    double rounded = (magnitude + anchor) - anchor;
    /* now exact in half: shift the fraction into place; subnormals are multiples of 2^-24 */
    float exact = (float)rounded;
    uint32_t single;
    memcpy(&single, &exact, 4);
    uint32_t normal = (single >> 13) - (112u << 10);
    float steps = exact * 0x1p24f;
    uint32_t subnormal = (uint32_t)(int32_t)(steps < 1024 ? steps : 0);
    uint32_t result = rounded < 0x1p-14 ? subnormal : normal;
    return (uint16_t)(sign | result);
}

HDR_INLINE void hdr_real_to_half_body(const double *in, uint16_t *out, size_t count) {
    for (size_t i = 0; i < count; i++)
        out[i] = nearest_half(in[i]);
}
HDR_VERSIONS(hdr_real_to_half, (const double *in, uint16_t *out, size_t count), (in, out, count))

uint16_t hdr_half_nearest(double value) {
    return nearest_half(value);
}

/* ---- Colour ---- */

HDR_INLINE void hdr_luminance_body(const double *r, const double *g, const double *b, const double w[3], double *y,
                                   size_t count) {
    const double wr = w[0], wg = w[1], wb = w[2];
    for (size_t i = 0; i < count; i++) {
        double sum = (wr * r[i] + wg * g[i]) + wb * b[i];
        y[i] = ((r[i] == g[i]) & (g[i] == b[i])) ? r[i] : sum;
    }
}
HDR_VERSIONS(hdr_luminance,
             (const double *r, const double *g, const double *b, const double w[3], double *y, size_t count),
             (r, g, b, w, y, count))

HDR_INLINE void hdr_luminance_ratio_body(const double *y, double *ld, size_t count) {
    for (size_t i = 0; i < count; i++) {
        double lit = y[i] > 0 ? y[i] : 1;
        double ratio = ld[i] / lit;
        ld[i] = y[i] > 0 ? ratio : 0;
    }
}
HDR_VERSIONS(hdr_luminance_ratio, (const double *y, double *ld, size_t count), (y, ld, count))

HDR_INLINE void hdr_multiply_body(double *c, const double *factor, size_t count) {
    for (size_t i = 0; i < count; i++) {
        double product = held(c[i] * factor[i]);
        c[i] = factor[i] == 0 ? 0 : product;
    }
}
HDR_VERSIONS(hdr_multiply, (double *c, const double *factor, size_t count), (c, factor, count))

HDR_INLINE void hdr_saturate_body(double *c, const double *y, const double *ld, double s, size_t count) {
    for (size_t i = 0; i < count; i++) {
        double lit = y[i] > 0 ? y[i] : 1;
        double chroma = c[i] / lit;
        double positive = chroma > 0 ? chroma : 0;
        double out = held(hdr_pow(positive, s) * ld[i]);
        c[i] = y[i] > 0 ? out : 0;
    }
}
HDR_VERSIONS(hdr_saturate, (double *c, const double *y, const double *ld, double s, size_t count), (c, y, ld, s, count))

HDR_INLINE void hdr_matrix_rows_body(double *r, double *g, double *b, const double m[9], size_t count) {
    const double m0 = m[0], m1 = m[1], m2 = m[2], m3 = m[3], m4 = m[4], m5 = m[5], m6 = m[6], m7 = m[7], m8 = m[8];
    for (size_t i = 0; i < count; i++) {
        double x = r[i], y = g[i], z = b[i];
        r[i] = held((m0 * x + m1 * y) + m2 * z);
        g[i] = held((m3 * x + m4 * y) + m5 * z);
        b[i] = held((m6 * x + m7 * y) + m8 * z);
    }
}
HDR_VERSIONS(hdr_matrix_rows, (double *r, double *g, double *b, const double m[9], size_t count), (r, g, b, m, count))

HDR_INLINE void hdr_unassociate_body(double *c, const double *alpha, size_t count) {
    for (size_t i = 0; i < count; i++) {
        double divisor = alpha[i] > 0 ? alpha[i] : 1;
        c[i] = held(c[i] / divisor);
    }
}
HDR_VERSIONS(hdr_unassociate, (double *c, const double *alpha, size_t count), (c, alpha, count))

HDR_INLINE void hdr_associate_body(double *c, const double *alpha, size_t count) {
    for (size_t i = 0; i < count; i++) {
        double factor = alpha[i] > 0 ? alpha[i] : 1;
        c[i] = held(c[i] * factor);
    }
}
HDR_VERSIONS(hdr_associate, (double *c, const double *alpha, size_t count), (c, alpha, count))

/* Porter and Duff 1984, "over", onto something that covers all. */
HDR_INLINE void hdr_lay_over_body(double *c, const double *alpha, double colour, size_t count) {
    for (size_t i = 0; i < count; i++)
        c[i] = held(c[i] + (1 - alpha[i]) * colour);
}
HDR_VERSIONS(hdr_lay_over, (double *c, const double *alpha, double colour, size_t count), (c, alpha, colour, count))

HDR_INLINE void hdr_hold_body(double *c, size_t count) {
    for (size_t i = 0; i < count; i++)
        c[i] = held(c[i]);
}
HDR_VERSIONS(hdr_hold, (double *c, size_t count), (c, count))

/* ---- Codes ---- */

/* Rounds half up: truncation of a non-negative number is its floor. */
HDR_INLINE int32_t code_of(double c, double top) {
    double raised = c > 0 ? c : 0;
    double below = raised < 1 ? raised : 1;
    return (int32_t)(below * top + 0.5);
}

HDR_INLINE void hdr_codes_u8_body(const double *c, double top, uint8_t *out, size_t stride, size_t count) {
    for (size_t i = 0; i < count; i++)
        out[i * stride] = (uint8_t)code_of(c[i], top);
}
HDR_VERSIONS(hdr_codes_u8, (const double *c, double top, uint8_t *out, size_t stride, size_t count),
             (c, top, out, stride, count))

HDR_INLINE void hdr_codes_u16_body(const double *c, double top, uint16_t *out, size_t stride, size_t count) {
    for (size_t i = 0; i < count; i++)
        out[i * stride] = (uint16_t)code_of(c[i], top);
}
HDR_VERSIONS(hdr_codes_u16, (const double *c, double top, uint16_t *out, size_t stride, size_t count),
             (c, top, out, stride, count))

/* ---- Facts ---- */

/* Extremes do not depend on the order: eight lanes let every instruction set keep them in its registers. */
HDR_INLINE void hdr_range_add_body(hdr_range *range, const double *values, size_t count) {
    double min[8], max[8], positive[8];
    for (int l = 0; l < 8; l++)
        min[l] = range->min, max[l] = range->max, positive[l] = range->min_positive;
    size_t whole = count / 8 * 8;
    for (size_t i = 0; i < whole; i += 8)
        for (int l = 0; l < 8; l++) {
            double v = values[i + (size_t)l];
            double p = v > 0 ? v : (double)INFINITY;
            min[l] = v < min[l] ? v : min[l];
            max[l] = v > max[l] ? v : max[l];
            positive[l] = p < positive[l] ? p : positive[l];
        }
    for (size_t i = whole; i < count; i++) {
        double v = values[i];
        min[0] = v < min[0] ? v : min[0];
        max[0] = v > max[0] ? v : max[0];
        if (v > 0 && v < positive[0]) positive[0] = v;
    }
    for (int l = 0; l < 8; l++) {
        range->min = min[l] < range->min ? min[l] : range->min;
        range->max = max[l] > range->max ? max[l] : range->max;
        range->min_positive = positive[l] < range->min_positive ? positive[l] : range->min_positive;
    }
}
HDR_VERSIONS(hdr_range_add, (hdr_range * range, const double *values, size_t count), (range, values, count))

double hdr_sum_lanes(const double lanes[8]) {
    return ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) + ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]));
}

HDR_INLINE void hdr_sum_logs_body(const double *y, double lanes[8], uint64_t *lit, size_t count) {
    double logs[HDR_STRIP] = {0}, number[8] = {0};
    while (count > 0) {
        size_t n = count < HDR_STRIP ? count : HDR_STRIP, whole = n / 8 * 8;
        for (size_t i = 0; i < n; i++)
            logs[i] = hdr_log(y[i] > 0 ? y[i] : 1); /* ln 1 = 0 adds nothing */
        for (size_t i = 0; i < whole; i += 8)
            for (int l = 0; l < 8; l++) {
                lanes[l] += logs[i + (size_t)l];
                number[l] += y[i + (size_t)l] > 0 ? 1.0 : 0.0; /* whole numbers: exact in any order */
            }
        for (size_t i = whole; i < n; i++) {
            lanes[i - whole] += logs[i];
            number[i - whole] += y[i] > 0 ? 1.0 : 0.0;
        }
        y += n;
        count -= n;
    }
    *lit += (uint64_t)hdr_sum_lanes(number);
}
HDR_VERSIONS(hdr_sum_logs, (const double *y, double lanes[8], uint64_t *lit, size_t count), (y, lanes, lit, count))

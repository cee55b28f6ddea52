/* Inner loops over a strip: a piece of a row that stays in the first-level cache, planar, in double. All take counts,
 * none allocates; none knows what a verb is. Each has one plain C source that is compiled for every instruction set
 * (base/cpu.h). */
#ifndef HDR_STRIP_H
#define HDR_STRIP_H

#include "base/base.h"

/* Pixels of a strip: a multiple of 8, so that the lanes of a row's sums do not depend on where strips begin. */
#define HDR_STRIP 512

/* ---- From the stored type, and back ---- */

/* True if none of the values is NaN or infinite. */
bool hdr_half_all_finite(const uint16_t *half, size_t count);
bool hdr_float_all_finite(const float *values, size_t count);

/* The largest of finite values, at least 0. */
uint16_t hdr_half_largest(const uint16_t *half, size_t count);
double hdr_largest(const double *values, size_t count);

/* Exact conversion of finite values. */
void hdr_half_to_real(const uint16_t *half, double *out, size_t count);
void hdr_float_to_real(const float *values, double *out, size_t count);

/* One value of any kind, NaN and infinities included. */
double hdr_half_value(uint16_t half);

/* Rounds to nearest, ties to even, held at the largest finite value. */
void hdr_real_to_float(const double *in, float *out, size_t count);
void hdr_real_to_half(const double *in, uint16_t *out, size_t count);
uint16_t hdr_half_nearest(double value);

/* ---- Colour ---- */

/* Y = w[0] r + w[1] g + w[2] b, summed in this order; r itself where r = g = b, since the weights add up to 1: so a
 * grey picture has the same Y whether it is stored in one plane or in three. */
void hdr_luminance(const double *r, const double *g, const double *b, const double w[3], double *y, size_t count);

/* ld becomes the factor on the colour: ld / y, and 0 where y <= 0. */
void hdr_luminance_ratio(const double *y, double *ld, size_t count);

/* c *= factor; exactly 0 where factor is 0. Held to float's range. */
void hdr_multiply(double *c, const double *factor, size_t count);

/* C' = max(C/Y, 0)^s Ld, 0 where Y <= 0. Held to float's range. */
void hdr_saturate(double *c, const double *y, const double *ld, double s, size_t count);

/* (r,g,b) = m (r,g,b), m by rows. Held to float's range. */
void hdr_matrix_rows(double *r, double *g, double *b, const double m[9], size_t count);

/* C / alpha and C * alpha where alpha > 0. Held to float's range: what is between verbs always is, so that a verb that
 * changes nothing may be left out. */
void hdr_unassociate(double *c, const double *alpha, size_t count);
void hdr_associate(double *c, const double *alpha, size_t count);

/* C + (1 - alpha) colour: associated C over a colour. Held to float's range. */
void hdr_lay_over(double *c, const double *alpha, double colour, size_t count);

/* What lies between verbs is held: to [-FLT_MAX, FLT_MAX], and what is smaller than 1e-200, 150 orders of magnitude
 * below the smallest float, is 0, so that the reciprocal of what is not 0 stays far within double's range. */
#define HDR_LEAST 1e-200
double hdr_held(double c);
void hdr_hold(double *c, size_t count);

/* ---- Codes ---- */

/* floor(min(max(c,0),1) top + 1/2). stride: samples from one pixel to the next. */
void hdr_codes_u8(const double *c, double top, uint8_t *out, size_t stride, size_t count);
void hdr_codes_u16(const double *c, double top, uint16_t *out, size_t stride, size_t count);

/* ---- Facts ---- */

typedef struct hdr_range {
    double min, max, min_positive; /* +inf, -inf, +inf where nothing has been seen */
} hdr_range;
#define HDR_RANGE_EMPTY                                                                                                \
    { INFINITY, -INFINITY, INFINITY }
void hdr_range_add(hdr_range *range, const double *values, size_t count);

/* Adds ln y of the lit (y > 0) to the 8 lanes, value i to lane i mod 8, and their number to lit. */
void hdr_sum_logs(const double *y, double lanes[8], uint64_t *lit, size_t count);

/* The lanes' sum, in a fixed order. */
double hdr_sum_lanes(const double lanes[8]);

/* float32 bits in an order that is that of the values: unsigned, negative below positive. */
static inline uint32_t hdr_float_key(float value) {
    union {
        float f;
        uint32_t u;
    } bits = {.f = value};
    return bits.u & 0x80000000u ? ~bits.u : bits.u | 0x80000000u;
}
static inline float hdr_float_of_key(uint32_t key) {
    union {
        uint32_t u;
        float f;
    } bits = {.u = key & 0x80000000u ? key & 0x7fffffffu : ~key};
    return bits.f;
}

#endif

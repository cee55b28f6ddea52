/* Elementary functions in float, for inner loops whose results are a few parts in ten million wrong anyway. The same
 * bits on every compiler and CPU, as those of real.h, and by the same means. */
#ifndef HDR_KERNEL_REAL_FLOAT_H
#define HDR_KERNEL_REAL_FLOAT_H

#include <stdint.h>
#include <string.h>

/* From here on exp(-x) is 0 to hdr_exp_of_minus: it is below 2^-125. */
#define HDR_EXP_FLOAT_END 87.0f

/* exp(-x), x >= 0; 0 from HDR_EXP_FLOAT_END on, of infinity too.
 *
 * -x = n ln 2 + r, |r| <= 0.3466, ln 2 in two parts of which the first has 9 bits (Cody and Waite, Software Manual for
 * the Elementary Functions, 1980), so that n times it is exact; exp(r) by its series up to r^7, which leaves
 * 0.3466^8 / 8! = 5.2e-9 of a number above 0.7. r rounds by 2^-26 twice, the last of the sums by half an ulp and the
 * one before it by 0.18: below 1.5 ulp in all. */
static inline float hdr_exp_of_minus(float x) {
    const float rounder = 0x1.8p23f; /* adding it rounds to an integer, which stands in the sum's low bits */
    float limited = x < HDR_EXP_FLOAT_END ? x : HDR_EXP_FLOAT_END;
    float rounder_plus_n = rounder - limited * 0x1.715476p+0f;
    float n = rounder_plus_n - rounder;
    float r = (-limited - n * 0.693359375f) + n * 2.12194440e-4f;
    float series = 1.0f / 5040;
    series = 1.0f / 720 + r * series;
    series = 1.0f / 120 + r * series;
    series = 1.0f / 24 + r * series;
    series = 1.0f / 6 + r * series;
    series = 0.5f + r * series;
    series = 1.0f + r * series;
    series = 1.0f + r * series;
    uint32_t bits, exponent;
    memcpy(&bits, &series, sizeof bits);
    memcpy(&exponent, &rounder_plus_n, sizeof exponent);
    bits += exponent << 23;
    memcpy(&series, &bits, sizeof series);
    return x < HDR_EXP_FLOAT_END ? series : 0.0f;
}

#endif

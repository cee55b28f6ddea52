/* Elementary functions in double which give the same bits on every compiler and CPU, in scalar and in vector code.
 *
 * The C library's change their last bit with the CPU it runs on, and do not vectorise. These use only + - * /, bit
 * moves and selects between finished values: every operation is correctly rounded by IEEE 754, so the result depends
 * neither on the vector width nor on the compiler, as long as it neither contracts a * b + c (-ffp-contract=off) nor
 * reassociates (no -ffast-math). The rounding mode must be to nearest. There is no branch, no table, no conversion
 * between integer and floating point and no arithmetic right shift, all of which SSE2 or AVX2 lack in vector form.
 *
 * Every constant is printed by tests/oracle/derive_real.py, with the approximation error of each polynomial.
 * "ulp" below is the distance of neighbouring doubles in the binade of the exact result. Each bound is asserted against
 * MPFR by tests/unit/test_real.c; "measured" is the largest error seen there over some 10^7 points.
 *
 * Outside the stated domain (negative numbers, NaN, infinities) the result is some value, NaN included, never a fault.
 */
#ifndef HDR_KERNEL_REAL_H
#define HDR_KERNEL_REAL_H

#include <float.h>
#include <stdint.h>
#include <string.h>

#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16
#error "real.h needs doubles that are computed as doubles (on 32-bit x86: -msse2 -mfpmath=sse)"
#endif

static inline uint64_t hdr_real_bits(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static inline double hdr_real_from_bits(uint64_t bits) {
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Keeps the 26 leading bits of the significand, so that the product of two such numbers is exact. */
static inline double hdr_real_head(double value) {
    return hdr_real_from_bits(hdr_real_bits(value) & 0xfffffffff8000000u);
}

/* ln 2 in two parts: the first has 40 bits, so its product with an exponent (11 bits) is exact; both add up to ln 2
 * with an error below 2^-94. */
#define HDR_REAL_LN2_HIGH 0x1.62e42fefa2000p-1
#define HDR_REAL_LN2_LOW 0x1.9ef35793c7673p-41

/* 1.5 * 2^52: its last bit counts 1, so adding it rounds a number below 2^51 to an integer, which then stands in the
 * low bits of the sum in two's complement. Shifted left by 52 they are what a double's exponent field needs added. */
#define HDR_REAL_ROUNDER 0x1.8p52

/* x = 2^exponent * mantissa, mantissa in [sqrt(1/2), sqrt(2)). Exact for normal x. What is below 2^-1022 counts as
 * about 2^-1023. */
typedef struct hdr_real_parts {
    double exponent, mantissa;
    uint64_t exponent_field; /* 1023 + exponent, in the place it has in a double */
} hdr_real_parts;

static inline hdr_real_parts hdr_real_split(double x) {
    const uint64_t sqrt_half = 0x3fe6a09e667f3bcdu, one = 0x3ff0000000000000u, mantissa_field = 0x000fffffffffffffu;
    /* Adding one - sqrt_half makes the exponent field count up where the mantissa passes sqrt(2) instead of 2. */
    uint64_t moved = hdr_real_bits(x) + (one - sqrt_half);
    hdr_real_parts parts;
    parts.exponent_field = moved & ~mantissa_field;
    parts.mantissa = hdr_real_from_bits((moved & mantissa_field) + sqrt_half);
    /* An integer below 2^52 in the low bits of 2^52 is 2^52 plus that integer. */
    parts.exponent = hdr_real_from_bits((moved >> 52) | 0x4330000000000000u) - (0x1p52 + 1023.0);
    return parts;
}

/* exponent * ln 2 + ln(1 + fraction) + rest, given s = fraction / (2 + fraction) and a rest below half an ulp of the
 * result's larger part; 1 + fraction in [sqrt(1/2), sqrt(2)].
 *
 * With z = s^2: ln(1 + f) = ln((1 + s) / (1 - s)) = 2 s + s z P(z), and 2 s = f - s f = f - (f^2/2 - s f^2/2), so
 * ln(1 + f) = f - t with t = f^2/2 - s (f^2/2 + z P). Approximation: 2^-59.49 of ln(1 + f), 0.02 ulp. t rounds by at
 * most 0.19 * 2^-53 (at f = 0.41: f^2/2 = 0.086 once, s (..) = 0.018 four times, t itself), 0.38 ulp of the result
 * there, and less at smaller |f|, where it shrinks with f^2. exponent = 0: t - f is the result, 0.5 + 0.4 ulp. Else the
 * result is above 0.34; below 0.5 the last subtraction is exact and t - f rounds by half an ulp; above, the last
 * rounds by 0.5 and t - f by 0.25 ulp or less while t's share halves. In all below 0.95 ulp. */
static inline double hdr_real_log_sum(double exponent, double fraction, double s, double rest) {
    double z = s * s;
    double z2 = z * z;
    double low =
        (0x1.5555555555592p-1 + 0x1.999999997ff1ap-2 * z) + z2 * (0x1.24924941e13eap-2 + 0x1.c71c52146ab8dp-3 * z);
    double high = (0x1.74663ce666d77p-3 + 0x1.39a1e9b0c1a21p-3 * z) + z2 * 0x1.2f03af03991eap-3;
    double tail = z * (low + (z2 * z2) * high);
    double half_square = 0.5 * (fraction * fraction);
    return exponent * HDR_REAL_LN2_HIGH - ((half_square - (s * (half_square + tail) + rest)) - fraction);
}

/* Natural logarithm, x > 0; 0 at 1. Below 0.95 ulp (measured 0.83). What is below 2^-1022, 0 too, gives about -709. */
static inline double hdr_log(double x) {
    hdr_real_parts parts = hdr_real_split(x);
    double fraction = parts.mantissa - 1.0;
    return hdr_real_log_sum(parts.exponent, fraction, fraction / (2.0 + fraction), parts.exponent * HDR_REAL_LN2_LOW);
}

/* ln(1 + x), x > -1 (finite).
 *
 * 1 + x = sum + lost exactly (Knuth's two-sum), and scaled by 2^-exponent: 1 + x = 2^exponent (1 + fraction + rest),
 * the fraction taking as much of lost as it can hold. For exponent 0 the fraction is x itself and nothing is left, so
 * tiny x are as accurate as large ones. Else ln(1 + fraction + rest) - ln(1 + fraction) = rest / (1 + fraction), where
 * 1 / (1 + fraction) = (1 - s) / (1 + s) is taken as 1 - 2 s: the error 2 s^2 < 0.06 of a rest below 2^-54 is nothing.
 * Besides hdr_log's 0.95 ulp this costs 2^-58, 0.06 ulp: below 1.01 ulp (measured 0.85). */
static inline double hdr_log1p(double x) {
    double sum = 1.0 + x;
    double x_part = sum - 1.0;
    double lost = (1.0 - (sum - x_part)) + (x - x_part);
    hdr_real_parts parts = hdr_real_split(sum);
    /* 2^(1 - exponent): one more than needed, so that the field cannot fall below 0 for the largest x. */
    double scale = hdr_real_from_bits(0x7ff0000000000000u - parts.exponent_field);
    double scaled_lost = 0.5 * (lost * scale);
    double leading = parts.mantissa - 1.0;
    double fraction = leading + scaled_lost;
    double rest = scaled_lost - (fraction - leading);
    double s = fraction / (2.0 + fraction);
    return hdr_real_log_sum(parts.exponent, fraction, s, parts.exponent * HDR_REAL_LN2_LOW + (rest - 2.0 * (s * rest)));
}

typedef struct hdr_real_pair {
    double high, low;
} hdr_real_pair;

/* log2(x) = high + low, high having 26 bits and low being what is missing.
 *
 * log2(m) = 2/ln2 (s + s z P(z)), s = (m - 1) / (m + 1), z = s^2. s is found as s_head + s_low, where s_head has 26
 * bits and s_low is the rest of the division, so s_head * (2/ln2's head) is exact, and the exponent is added to it
 * without loss (fast two-sum: it is 0 or the larger one). Errors relative to log2(m): P's approximation 2^-59.49; the
 * rounding of s z P, which is at most 0.0099 = 2^-6.66 of it and carries less than 13.4 units of 2^-53 (those of the
 * quotient s, 3, three times; z, s z, P 1.4 and the product): 2^-55.9; all else is below 2^-75. Together below 2^-55.8
 * of log2(m), hence of log2(x) (|log2(m)| <= 1/2 <= |log2(x)| if exponent <> 0). Taking s_head + s_low for s in s z P
 * would halve that, but lengthens the chain of dependent operations: a tenth of the time of hdr_pow. */
static inline hdr_real_pair hdr_real_log2(double x) {
    hdr_real_parts parts = hdr_real_split(x);
    double numerator = parts.mantissa - 1.0;
    double denominator = parts.mantissa + 1.0;
    double reciprocal = 1.0 / denominator;
    double denominator_head = hdr_real_head(denominator);
    double denominator_low = (1.0 - denominator_head) + parts.mantissa;
    double s = numerator * reciprocal;
    double s_head = hdr_real_head(s);
    double s_low = reciprocal * ((numerator - s_head * denominator_head) - s_head * denominator_low);
    double z = s * s;
    double z2 = z * z;
    double low =
        (0x1.ec709dc3a0455p-1 + 0x1.2776c50ee73d7p-1 * z) + z2 * (0x1.a61762d1f7675p-2 + 0x1.484afcf9e1062p-2 * z);
    double high = (0x1.0ca11dcb29d57p-2 + 0x1.c479d89385158p-3 * z) + z2 * 0x1.b528697535dd0p-3;
    double tail = (s * z) * (low + (z2 * z2) * high);
    double head_product = 0x1.7154760000000p+1 * s_head;
    double rest = (0x1.7154760000000p+1 * s_low + 0x1.4ae0bf85ddf44p-25 * s) + tail;
    double sum = parts.exponent + head_product;
    rest = ((parts.exponent - sum) + head_product) + rest;
    hdr_real_pair result;
    result.high = hdr_real_head(sum + rest);
    result.low = (sum - result.high) + rest;
    return result;
}

/* Logarithm to base 2, x > 0; exact for powers of two. The pair's error, 2^-55.8, is at most 0.15 ulp; with the
 * rounding of the sum below 0.65 ulp (measured 0.57). What is below 2^-1022, 0 too, gives about -1023. */
static inline double hdr_log2(double x) {
    hdr_real_pair log2_x = hdr_real_log2(x);
    return log2_x.high + log2_x.low;
}

/* Logarithm to base 10, x > 0: log2(x) * log10(2), where the product of the heads (26 bits each) is exact and the
 * others, below 2^-24 of it, round at 2^-77. So below 0.65 ulp as well (measured 0.55), and exact for powers of ten,
 * whose logarithm is a double. */
static inline double hdr_log10(double x) {
    hdr_real_pair log2_x = hdr_real_log2(x);
    return 0x1.3441350000000p-2 * log2_x.high +
           (0x1.3ef3fde623e25p-31 * log2_x.high + 0x1.34413509f79ffp-2 * log2_x.low);
}

/* exp(high + low) - 1 for |high| <= 0.34658 and a low below an ulp of high: high + (low + high^2 Q(high)).
 * Approximation: 2^-61.68 of high. high^2 Q is below 0.19 of the result and rounds by at most 3 units of 2^-53. */
static inline double hdr_real_expm1_near_0(double high, double low) {
    double r2 = high * high;
    double r4 = r2 * r2;
    double first = (0.5 + 0x1.5555555555559p-3 * high) + r2 * (0x1.5555555555556p-5 + 0x1.111111110f626p-7 * high);
    double second = (0x1.6c16c16c1628cp-10 + 0x1.a01a01b0231c8p-13 * high) +
                    r2 * (0x1.a01a01a6567f9p-16 + 0x1.71ddf7a627469p-19 * high);
    double third = (0x1.27e4de044ef5ep-22 + 0x1.af6008bc2d5cdp-26 * high) + r2 * 0x1.1f6c5ad4093e9p-29;
    return high + (low + r2 * (first + r4 * (second + r4 * third)));
}

/* Multiplies a number in [1/2, 2) by 2^n, where n stands in the low bits of the rounder's sum. */
static inline double hdr_real_scale(double value, double rounder_plus_n) {
    return hdr_real_from_bits(hdr_real_bits(value) + (hdr_real_bits(rounder_plus_n) << 52));
}

/* Exponential function, any finite x. Saturates: above ln(DBL_MAX) = 709.78.. the result is DBL_MAX; a result below
 * 2^-1022 is 0.
 *
 * x = n ln 2 + r; x - n HIGH is exact, n LOW has a relative error of 2^-53. In ulps of the result, for exp(r) < 1 where
 * they are smallest (2^-53): the last sum 0.5, that of expm1(r), which is below 0.3, 0.25, high^2 Q < 0.054 with three
 * roundings 0.17. Below 0.95 ulp (measured 0.89). */
static inline double hdr_exp(double x) {
    double rounder_plus_n = x * 0x1.71547652b82fep+0 + HDR_REAL_ROUNDER;
    double n = rounder_plus_n - HDR_REAL_ROUNDER;
    double high = x - n * HDR_REAL_LN2_HIGH;
    double low = n * HDR_REAL_LN2_LOW;
    double r = high - low;
    double result = hdr_real_scale(1.0 + hdr_real_expm1_near_0(r, (high - r) - low), rounder_plus_n);
    result = x <= 0x1.62e42fefa39efp+9 ? result : DBL_MAX;
    return x >= -0x1.6232bdd7abcd2p+9 ? result : 0.0;
}

/* 1 - exp(-x), x >= 0: (1 - 2^n) - 2^n expm1(r) with -x = n ln 2 + r.
 *
 * For n = 0, r is -x itself, so tiny x keep their relative accuracy; the last sum of expm1(r) rounds by 0.5 ulp, the
 * rest by 0.19 * 3 = 0.57 units of 2^-53 of the result. For n < 0, 1 - 2^n is exact (n >= -53) or 1, the result is at
 * least 0.29 and expm1(r), below 0.42, wrong by less than 2^-54 before it is halved: 0.5 + 0.5 ulp. Together below
 * 1.08 ulp (measured 1.00). */
static inline double hdr_one_minus_exp_neg(double x) {
    /* From 37.5 on the result is 1; stopping at 64 keeps 2^n a normal number. */
    double clamped = x < 64.0 ? x : 64.0;
    double rounder_plus_n = HDR_REAL_ROUNDER - clamped * 0x1.71547652b82fep+0;
    double n = rounder_plus_n - HDR_REAL_ROUNDER;
    double high = -clamped - n * HDR_REAL_LN2_HIGH;
    double low = n * HDR_REAL_LN2_LOW;
    double r = high - low;
    double power_of_two = hdr_real_scale(1.0, rounder_plus_n);
    return (1.0 - power_of_two) - power_of_two * hdr_real_expm1_near_0(r, (high - r) - low);
}

/* 2^(high + low), low being small against 1; saturates as hdr_exp: DBL_MAX from 1024 on, 0 below -1022.
 *
 * 2^r = 1 + (r ln2 + r (ln2's rest + r Q(r))), |r| <= 1/2. In ulps of the result, for 2^r < 1 where they are smallest
 * (2^-53): approximation 2^-59, 0.02; r ln2 < 0.35 and the sum with it, 0.25 each; the other term, below 0.06, 0.1; the
 * last sum 0.5. Together below 1.12 ulp; r itself rounds (only if low <> 0) by 2^-55 ln 2, another 0.18. */
static inline double hdr_real_exp2(double high, double low) {
    double sum = high + low;
    double rounder_plus_n = sum + HDR_REAL_ROUNDER;
    double n = rounder_plus_n - HDR_REAL_ROUNDER;
    double r = (high - n) + low;
    double r2 = r * r;
    double r4 = r2 * r2;
    double first =
        (0x1.abc9e3b39803fp-56 + 0x1.ebfbdff82c5a5p-3 * r) + r2 * (0x1.c6b08d704a0c5p-5 + 0x1.3b2ab6fb9ffa8p-7 * r);
    double second =
        (0x1.5d87fe78a3782p-10 + 0x1.4309130f19f6ap-13 * r) + r2 * (0x1.ffcbfc729d806p-17 + 0x1.62bfc70611f7bp-20 * r);
    double third = (0x1.b524de0cba9afp-24 + 0x1.e61c45c6be136p-28 * r) + r2 * 0x1.ea04415100c75p-32;
    double power = 1.0 + (r * 0x1.62e42fefa39efp-1 + r * (first + r4 * (second + r4 * third)));
    double result = hdr_real_scale(power, rounder_plus_n);
    result = sum < 1024.0 ? result : DBL_MAX;
    return sum >= -1022.0 ? result : 0.0;
}

/* 2^x, any finite x; exact for integers; saturates as hdr_exp. Below 1.12 ulp (measured 1.09). */
static inline double hdr_exp2(double x) {
    return hdr_real_exp2(x, 0.0);
}

/* x^p, x >= 0, p finite. 0^p is 0 for p > 0, 1 for p = 0 and DBL_MAX for p < 0; x^0 = 1 and 1^p = 1 exactly; x below
 * 2^-1022 counts as 0. Saturates as hdr_exp.
 *
 * p log2(x) = high + low, the product of the heads being exact and low rounding at 2^-77 of it. The error of the
 * logarithm, 2^-55.8 of |p log2(x)|, makes ln 2 times that much of the result: at most 1.65e-15 with a result in
 * float's range (|p log2(x)| <= 149), 1.14e-14 with any normal result. That of 2^y comes to it, 1.3 ulp of a number
 * below 1, 2.1e-16. Together below 1.9e-15 in float's range (measured 9e-16) and 1.2e-14 elsewhere. */
static inline double hdr_pow(double x, double p) {
    /* |log2(x)| >= 2^-53 for x <> 1, so a larger |p| saturates anyway; the limit keeps all products finite. */
    double limited = p < 0x1p70 ? p : 0x1p70;
    limited = limited > -0x1p70 ? limited : -0x1p70;
    double p_head = hdr_real_head(limited);
    double p_low = limited - p_head;
    double at_zero = p > 0.0 ? 0.0 : DBL_MAX;
    at_zero = p == 0.0 ? 1.0 : at_zero;
    hdr_real_pair log2_x = hdr_real_log2(x);
    double power = hdr_real_exp2(p_head * log2_x.high, p_low * log2_x.high + limited * log2_x.low);
    return x >= DBL_MIN ? power : at_zero;
}

#endif

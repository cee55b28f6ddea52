/* Checks src/kernel/real.h against MPFR: accuracy, exact cases, monotonicity, and the same bits in scalar and vector
 * code, with every compiler and on every CPU.
 *
 * Usage: test_real [points per function [seed]]     (more points: a longer search for the largest error, printed to
 *                                                    stderr for each function when arguments are given) */
#include "check.h"
#include "kernel/real.h"

#include <math.h>
#include <mpfr.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

enum { REFERENCE_BITS = 128, LANES_CHECKED = 1024 };

/* Pow is held to what float pictures need; the wide bound is for any normal result. */
static const double pow_bound_in_float_range = 1.9e-15, pow_bound_wide = 1.2e-14;

static const double pow_exponents[] = {1 / 2.4, 1 / 2.2, 2.4, 2.2, 0.1, 10.0, 78.84375, 0.1593017578125};
enum { POW_EXPONENTS = sizeof pow_exponents / sizeof pow_exponents[0] };

/* ---- points ---- */

static uint64_t random_state;

/* SplitMix64. */
static uint64_t random_bits(void) {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* The helpers take their randomness as arguments and each point function draws it in a fixed order, because the order
 * in which a compiler evaluates the operands of an expression is its own choice. */
static double between(uint64_t random, double low, double high) {
    return low + (high - low) * ((double)(random >> 11) * 0x1p-53);
}

/* Any exponent of [low, high), any significand. */
static double log_spaced(uint64_t random, int low, int high) {
    int exponent = low + (int)((random & 0xfff) % (uint64_t)(high - low));
    return ldexp(1.0 + (double)(random >> 12) * 0x1p-52, exponent);
}

static int integer_between(uint64_t random, int low, int high) {
    return low + (int)(random % (uint64_t)(high - low + 1));
}

static double neighbour(double x, int steps) {
    return hdr_real_from_bits(hdr_real_bits(x) + (uint64_t)(int64_t)steps);
}

static double positive_point(unsigned index) {
    const uint64_t a = random_bits(), b = random_bits();
    switch (index % 8) {
    case 0: /* all normal doubles */
        return log_spaced(a, -1022, 1024);
    case 1: /* all normal floats, exactly */
        return (double)(float)log_spaced(a, -126, 127);
    case 2: /* the denormal floats */
        return ldexp((double)(1 + (a & 0x7fffff)), -149);
    case 3: /* near 1, at all distances */
        return 1.0 + (a & 1 ? -0.25 : 0.5) * log_spaced(b, -52, 0);
    case 4: /* next to a power of two */
        return neighbour(ldexp(1.0, integer_between(a, -1020, 1020)), integer_between(b, -4, 4));
    case 5: /* next to where the mantissa wraps */
        return neighbour(ldexp(0x1.6a09e667f3bcdp-1, integer_between(a, -150, 150)), integer_between(b, -40, 40));
    default: /* picture values */
        return between(a, 0.0, index % 8 == 6 ? 2.0 : 16.0) + 0x1p-60;
    }
}

static double log1p_point(unsigned index) {
    const uint64_t a = random_bits(), b = random_bits();
    switch (index % 8) {
    case 0:
        return log_spaced(a, -1022, 1024);
    case 1:
        return log_spaced(a, -60, 0);
    case 2: /* where 1 + x wraps to the next exponent */
        return neighbour(ldexp(0x1.6a09e667f3bcdp-1, integer_between(a, 1, 60)) - 1.0, integer_between(b, -40, 40));
    case 3: /* the same, further around the first of them */
        return 0x1.a827999fcef32p-2 * (1.0 + (a & 1 ? -1.0 : 1.0) * log_spaced(b, -50, -3));
    case 4: /* where 1 + x loses bits of x or of 1 */
        return log_spaced(a, 48, 58);
    case 5:
        return -between(a, 0.0, 0.999);
    case 6: /* floats */
        return (double)(float)log_spaced(a, -149, 127);
    default:
        return between(a, 0.0, 8.0);
    }
}

static double exp_point(unsigned index) {
    const uint64_t a = random_bits(), b = random_bits();
    switch (index % 6) {
    case 0: /* the whole range of normal results */
        return between(a, -708.39, 709.78);
    case 1: /* next to a change of n */
        return neighbour((integer_between(a, -1000, 1000) + 0.5) * 0x1.62e42fefa39efp-1, integer_between(b, -40, 40));
    case 2: /* next to a multiple of ln 2 */
        return neighbour((integer_between(a, -1000, 1000) + 0x1p-30) * 0x1.62e42fefa39efp-1,
                         integer_between(b, -40, 40));
    case 3:
        return (a & 1 ? -1.0 : 1.0) * log_spaced(b, -60, 9);
    default:
        return between(a, -2.0, 2.0);
    }
}

static double one_minus_exp_neg_point(unsigned index) {
    const uint64_t a = random_bits(), b = random_bits();
    switch (index % 6) {
    case 0:
        return log_spaced(a, -1022, 10);
    case 1: /* next to a change of n */
        return neighbour((integer_between(a, 0, 50) + 0.5) * 0x1.62e42fefa39efp-1, integer_between(b, -40, 40));
    case 2:
        return log_spaced(a, -60, 0);
    case 3:
        return between(a, 0.0, 70.0);
    default:
        return between(a, 0.0, 3.0);
    }
}

static double exp2_point(unsigned index) {
    const uint64_t a = random_bits(), b = random_bits();
    switch (index % 6) {
    case 0:
        return between(a, -1022.0, 1023.999);
    case 1:
        return neighbour(integer_between(a, -1000, 1000) + 0.5, integer_between(b, -40, 40));
    case 2:
        return neighbour(integer_between(a, -1000, 1000) + 0x1p-30, integer_between(b, -40, 40));
    case 3:
        return (a & 1 ? -1.0 : 1.0) * log_spaced(b, -60, 9);
    default:
        return between(a, -2.0, 2.0);
    }
}

/* ---- references ---- */

static mpfr_t logarithm, ln2, ln10;

static void reference_log(mpfr_t result, mpfr_t x) {
    mpfr_log(logarithm, x, MPFR_RNDN);
    mpfr_set(result, logarithm, MPFR_RNDN);
}
/* These two take the logarithm which reference_log has just left. */
static void reference_log2(mpfr_t result, mpfr_t x) {
    (void)x;
    mpfr_div(result, logarithm, ln2, MPFR_RNDN);
}
static void reference_log10(mpfr_t result, mpfr_t x) {
    (void)x;
    mpfr_div(result, logarithm, ln10, MPFR_RNDN);
}
static void reference_log1p(mpfr_t result, mpfr_t x) {
    mpfr_log1p(result, x, MPFR_RNDN);
}
static void reference_exp(mpfr_t result, mpfr_t x) {
    mpfr_exp(result, x, MPFR_RNDN);
}
static void reference_exp2(mpfr_t result, mpfr_t x) {
    mpfr_exp2(result, x, MPFR_RNDN);
}
static void reference_one_minus_exp_neg(mpfr_t result, mpfr_t x) {
    mpfr_neg(x, x, MPFR_RNDN);
    mpfr_expm1(result, x, MPFR_RNDN);
    mpfr_neg(result, result, MPFR_RNDN);
}

/* ---- the functions as scalar calls and as loops ---- */

typedef double scalar_function(double x);
typedef void loop_function(const double *in, double *out, size_t count);

#define LOOP(name, suffix, attribute, expression)                                                                      \
    attribute __attribute__((noinline)) static void loop_##name##_##suffix(const double *restrict in,                  \
                                                                           double *restrict out, size_t count) {       \
        for (size_t i = 0; i < count; i++) {                                                                           \
            double x = in[i];                                                                                          \
            out[i] = (expression);                                                                                     \
        }                                                                                                              \
    }

/* With fused multiply-add enabled, so that a build which lets the compiler contract is found out. */
#if defined(__x86_64__) && defined(__GNUC__)
#define LOOPS_OF_CPU(name, expression)                                                                                 \
    LOOP(name, avx2, __attribute__((target("avx2,fma"))), expression)                                                  \
    LOOP(name, avx512, __attribute__((target("avx512f,avx512dq,avx512vl,avx512bw,fma"))), expression)
#define CPU_LOOPS(name) loop_##name##_avx2, loop_##name##_avx512
static bool cpu_has_avx2(void) {
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
}
static bool cpu_has_avx512(void) {
    return cpu_has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw");
}
#else
#define LOOPS_OF_CPU(name, expression)
#define CPU_LOOPS(name) NULL, NULL
static bool cpu_has_avx2(void) {
    return false;
}
static bool cpu_has_avx512(void) {
    return false;
}
#endif

#define FORMS(name, expression)                                                                                        \
    __attribute__((noinline)) static double scalar_##name(double x) {                                                  \
        return (expression);                                                                                           \
    }                                                                                                                  \
    LOOP(name, base, , expression)                                                                                     \
    LOOPS_OF_CPU(name, expression)

FORMS(log, hdr_log(x))
FORMS(log2, hdr_log2(x))
FORMS(log10, hdr_log10(x))
FORMS(log1p, hdr_log1p(x))
FORMS(exp, hdr_exp(x))
FORMS(one_minus_exp_neg, hdr_one_minus_exp_neg(x))
FORMS(exp2, hdr_exp2(x))
FORMS(pow_gamma, hdr_pow(x, 1 / 2.4))
FORMS(pow_pq, hdr_pow(x, 78.84375))

typedef struct function {
    const char *name;
    scalar_function *scalar;
    loop_function *loops[3]; /* as compiled, AVX2, AVX-512 */
    double (*point)(unsigned index);
    void (*reference)(mpfr_t result, mpfr_t x);
    double bound;          /* ulp */
    bool shares_logarithm; /* takes the points of the function before it */
    double worst, worst_x;
} function;

/* clang-format off */
#define ROW(name) #name, scalar_##name, {loop_##name##_base, CPU_LOOPS(name)}
/* clang-format on */

static function functions[] = {
    {ROW(log), positive_point, reference_log, 0.95, false, 0, 0},
    {ROW(log2), positive_point, reference_log2, 0.65, true, 0, 0},
    {ROW(log10), positive_point, reference_log10, 0.65, true, 0, 0},
    {ROW(log1p), log1p_point, reference_log1p, 1.01, false, 0, 0},
    {ROW(exp), exp_point, reference_exp, 0.95, false, 0, 0},
    {ROW(one_minus_exp_neg), one_minus_exp_neg_point, reference_one_minus_exp_neg, 1.08, false, 0, 0},
    {ROW(exp2), exp2_point, reference_exp2, 1.12, false, 0, 0},
    {ROW(pow_gamma), positive_point, NULL, 0, false, 0, 0}, /* accuracy: see check_pow */
    {ROW(pow_pq), positive_point, NULL, 0, false, 0, 0},
};
enum { FUNCTIONS = sizeof functions / sizeof functions[0] };

/* ---- accuracy ---- */

/* Distance of value from exact, in ulps of exact. */
static double error_in_ulps(double value, mpfr_t exact, mpfr_t scratch) {
    if (mpfr_zero_p(exact)) {
        return value == 0.0 ? 0.0 : HUGE_VAL;
    }
    mpfr_exp_t exponent = mpfr_get_exp(exact);
    mpfr_sub_d(scratch, exact, value, MPFR_RNDN);
    mpfr_mul_2si(scratch, scratch, 53 - (exponent < -1021 ? -1021 : exponent), MPFR_RNDN);
    return fabs(mpfr_get_d(scratch, MPFR_RNDN));
}

static void check_accuracy(unsigned points) {
    mpfr_t x_exact, exact, scratch;
    mpfr_inits2(REFERENCE_BITS, x_exact, exact, scratch, (mpfr_ptr)0);
    for (unsigned first = 0; first < FUNCTIONS && functions[first].reference; first++) {
        if (functions[first].shares_logarithm) {
            continue;
        }
        for (unsigned index = 0; index < points; index++) {
            double x = functions[first].point(index);
            unsigned i = first;
            do {
                function *f = &functions[i];
                mpfr_set_d(x_exact, x, MPFR_RNDN);
                f->reference(exact, x_exact);
                double value = f->scalar(x);
                double error = error_in_ulps(value, exact, scratch);
                CHECK(error <= f->bound, "%s(%a) = %a is off by %g ulp", f->name, x, value, error);
                if (!(error <= f->worst)) {
                    f->worst = error;
                    f->worst_x = x;
                }
            } while (++i < FUNCTIONS && functions[i].shares_logarithm);
        }
    }
    mpfr_clears(x_exact, exact, scratch, (mpfr_ptr)0);
}

static double pow_worst, pow_worst_x, pow_worst_p, pow_worst_wide;

static void check_pow_value(double x, double p, mpfr_t exact, mpfr_t scratch) {
    double value = hdr_pow(x, p);
    double rounded = mpfr_get_d(exact, MPFR_RNDN);
    if (rounded < DBL_MIN) {
        CHECK(value <= 0x1.0000000000010p-1022, "pow(%a, %a) = %a, but the result underflows", x, p, value);
        return;
    }
    if (rounded > 0x1.fffffffffff00p1023) {
        CHECK(value >= 0x1.ffffffffffe00p1023 && value <= DBL_MAX, "pow(%a, %a) = %a, not saturated", x, p, value);
        return;
    }
    bool in_float_range = x >= 0x1p-149 && x < 0x1p128 && rounded >= 0x1p-149 && rounded < 0x1p128;
    mpfr_d_sub(scratch, value, exact, MPFR_RNDN);
    mpfr_div(scratch, scratch, exact, MPFR_RNDN);
    double error = fabs(mpfr_get_d(scratch, MPFR_RNDN));
    /* A result just above 2^-1022 may be flushed. */
    bool flushed = value == 0.0 && rounded < 0x1.0000000000010p-1022;
    CHECK(flushed || error <= (in_float_range ? pow_bound_in_float_range : pow_bound_wide),
          "pow(%a, %a) = %a is off by %g of it", x, p, value, error);
    if (in_float_range && !(error <= pow_worst)) {
        pow_worst = error;
        pow_worst_x = x;
        pow_worst_p = p;
    }
    if (!flushed && error > pow_worst_wide) {
        pow_worst_wide = error;
    }
}

/* x^p = exp(p ln x): at 192 bits the reference keeps more than 170 for every normal result. */
static void check_pow(unsigned points) {
    mpfr_t log_x, exponent, exact, scratch;
    mpfr_inits2(192, log_x, exponent, exact, scratch, (mpfr_ptr)0);
    for (unsigned index = 0; index < points / POW_EXPONENTS; index++) {
        double x = positive_point(index);
        if (index % 4 == 0) {
            x = between(random_bits(), 0.8, 1.2); /* the base of PQ's outer power is in [0.83, 1] */
        }
        mpfr_set_d(log_x, x, MPFR_RNDN);
        mpfr_log(log_x, log_x, MPFR_RNDN);
        for (unsigned i = 0; i <= POW_EXPONENTS; i++) {
            double p = i < POW_EXPONENTS ? pow_exponents[i] : between(random_bits(), -4.0, 4.0);
            if (i == POW_EXPONENTS && x > 0.5 && x < 1.5 && x != 1.0) {
                /* Near 1 only a large exponent moves the result through float's or double's range. */
                double reach = index & 8 ? 1.0 : 7.9;
                p = reach * between(random_bits(), -100.0, 88.0) / hdr_log(x);
            }
            mpfr_mul_d(exponent, log_x, p, MPFR_RNDN);
            mpfr_exp(exact, exponent, MPFR_RNDN);
            check_pow_value(x, p, exact, scratch);
        }
    }
    mpfr_clears(log_x, exponent, exact, scratch, (mpfr_ptr)0);
}

/* ---- monotonicity ---- */

/* All are growing functions. Neighbouring doubles may swap by the last bit, neighbouring floats may not swap at all. */
static void check_monotone(unsigned runs) {
    for (unsigned i = 0; i < FUNCTIONS; i++) {
        const function *f = &functions[i];
        for (unsigned run = 0; run < runs; run++) {
            double x = f->point(run);
            double direction = x < 0.0 ? -1.0 : 1.0;
            double before = f->scalar(x);
            for (int step = 1; step <= 24; step++) {
                double next = neighbour(x, step);
                double value = f->scalar(next);
                double drop = (before - value) * direction;
                double ulp = fabs(before) * 0x1p-52;
                CHECK(drop <= ulp, "%s falls by %g ulp at %a", f->name, drop / ulp, next);
                before = value;
            }
            float single = (float)x;
            if (!(fabsf(single) >= 0x1p-126f && fabsf(single) < 0x1p126f)) {
                continue;
            }
            before = f->scalar((double)single);
            for (int step = 1; step <= 12; step++) {
                single = nextafterf(single, HUGE_VALF);
                double value = f->scalar((double)single);
                CHECK(value >= before, "%s falls from %a to %a at the float %a", f->name, before, value,
                      (double)single);
                before = value;
            }
        }
    }
}

/* ---- exact cases and the ends of the ranges ---- */

static void check_equal(const char *what, double value, double expected) {
    CHECK(hdr_real_bits(value) == hdr_real_bits(expected), "%s is %a, not %a", what, value, expected);
}

static void check_exact_cases(void) {
    check_equal("log(1)", hdr_log(1.0), 0.0);
    check_equal("log2(1)", hdr_log2(1.0), 0.0);
    check_equal("log10(1)", hdr_log10(1.0), 0.0);
    check_equal("log1p(0)", hdr_log1p(0.0), 0.0);
    check_equal("exp(0)", hdr_exp(0.0), 1.0);
    check_equal("exp2(0)", hdr_exp2(0.0), 1.0);
    check_equal("1-exp(-0)", hdr_one_minus_exp_neg(0.0), 0.0);
    for (int k = -1022; k <= 1023; k++) {
        double power = ldexp(1.0, k);
        CHECK(hdr_log2(power) == k, "log2(2^%d) = %a", k, hdr_log2(power));
        CHECK(hdr_exp2(k) == power, "exp2(%d) = %a", k, hdr_exp2(k));
    }
    double power_of_ten = 1.0;
    for (int k = 0; k <= 22; k++, power_of_ten *= 10.0) {
        CHECK(hdr_log10(power_of_ten) == k, "log10(10^%d) = %a", k, hdr_log10(power_of_ten));
    }
    for (int k = 1; k < 60; k++) { /* tiny arguments come back */
        double tiny = ldexp(1.0, -60 - 16 * k);
        check_equal("log1p(tiny)", hdr_log1p(tiny), tiny);
        check_equal("1-exp(-tiny)", hdr_one_minus_exp_neg(tiny), tiny);
    }
    check_equal("1-exp(-denormal)", hdr_one_minus_exp_neg(0x1p-1074), 0x1p-1074);
    CHECK(fabs(hdr_log1p(1e300) / log(1e300) - 1.0) < 1e-15, "log1p(1e300) = %a", hdr_log1p(1e300));
    CHECK(fabs(hdr_log1p(DBL_MAX) / log(DBL_MAX) - 1.0) < 1e-15, "log1p(DBL_MAX) = %a", hdr_log1p(DBL_MAX));
    CHECK(hdr_log(0.0) < -708.0 && hdr_log(0.0) > -710.0, "log(0) = %a", hdr_log(0.0));

    static const double large[] = {709.79, 1024.0, 1e4, 1e10, 1e19, 1e100, DBL_MAX, HUGE_VAL};
    for (unsigned i = 0; i < sizeof large / sizeof large[0]; i++) {
        check_equal("exp(large)", hdr_exp(large[i]), DBL_MAX);
        check_equal("exp(-large)", hdr_exp(-large[i]), 0.0);
        check_equal("1-exp(-large)", hdr_one_minus_exp_neg(large[i]), 1.0);
        check_equal("exp2(large)", hdr_exp2(large[i] + 315.0), DBL_MAX);
        check_equal("exp2(-large)", hdr_exp2(-large[i] - 315.0), 0.0);
        check_equal("2^large", hdr_pow(2.0, large[i] + 315.0), DBL_MAX);
        check_equal("2^-large", hdr_pow(2.0, -large[i] - 315.0), 0.0);
        check_equal("1^large", hdr_pow(1.0, large[i]), 1.0);
        check_equal("1^-large", hdr_pow(1.0, -large[i]), 1.0);
        check_equal("large^0", hdr_pow(large[i], 0.0), 1.0);
        check_equal("0^large", hdr_pow(0.0, large[i]), 0.0);
    }
    /* The last arguments before saturation give ordinary numbers. */
    double last = 0x1.62e42fefa39efp+9, first = -0x1.6232bdd7abcd2p+9;
    CHECK(hdr_exp(last) < DBL_MAX && hdr_exp(last) > DBL_MAX * (1 - 1e-12), "exp(%a) = %a", last, hdr_exp(last));
    check_equal("exp(beyond the last)", hdr_exp(neighbour(last, 1)), DBL_MAX);
    CHECK(hdr_exp(first) >= DBL_MIN && hdr_exp(first) < DBL_MIN * (1 + 1e-12), "exp(%a) = %a", first, hdr_exp(first));
    check_equal("exp(before the first)", hdr_exp(neighbour(first, 1)), 0.0);
    last = neighbour(1024.0, -1);
    CHECK(hdr_exp2(last) < DBL_MAX && hdr_exp2(last) > DBL_MAX * (1 - 1e-12), "exp2(%a) = %a", last, hdr_exp2(last));
    check_equal("exp2(1024)", hdr_exp2(1024.0), DBL_MAX);
    check_equal("exp2(-1022)", hdr_exp2(-1022.0), DBL_MIN);
    check_equal("exp2(before -1022)", hdr_exp2(neighbour(-1022.0, 1)), 0.0);
    check_equal("(1+eps)^1e300", hdr_pow(1.0 + DBL_EPSILON, 1e300), DBL_MAX);
    check_equal("(1-eps)^1e300", hdr_pow(1.0 - DBL_EPSILON, 1e300), 0.0);
    check_equal("0^0", hdr_pow(0.0, 0.0), 1.0);
    check_equal("0^-0", hdr_pow(0.0, -0.0), 1.0);
    check_equal("(-0)^2", hdr_pow(-0.0, 2.0), 0.0);
    check_equal("0^1e-300", hdr_pow(0.0, 1e-300), 0.0);
    check_equal("0^-1", hdr_pow(0.0, -1.0), DBL_MAX);
    for (unsigned i = 0; i < POW_EXPONENTS; i++) {
        check_equal("0^p", hdr_pow(0.0, pow_exponents[i]), 0.0);
        check_equal("1^p", hdr_pow(1.0, pow_exponents[i]), 1.0);
    }
    for (int k = -40; k <= 40; k++) {
        CHECK(hdr_pow(4.0, 0.5 * k) == ldexp(1.0, k), "4^%g = %a", 0.5 * k, hdr_pow(4.0, 0.5 * k));
    }
}

/* ---- the same bits ---- */

static void check_same_bits(void) {
    static double in[LANES_CHECKED], out[LANES_CHECKED];
    bool usable[3] = {true, cpu_has_avx2(), cpu_has_avx512()};
    random_state = 2024;
    uint64_t digest = 0xcbf29ce484222325u;
    for (unsigned i = 0; i < FUNCTIONS; i++) {
        const function *f = &functions[i];
        for (unsigned round = 0; round < 24; round++) {
            for (unsigned k = 0; k < LANES_CHECKED; k++) {
                in[k] = f->point(k + round);
            }
            for (unsigned form = 0; form < 3; form++) {
                if (!usable[form] || !f->loops[form]) {
                    continue;
                }
                f->loops[form](in, out, LANES_CHECKED - round); /* all lengths of the loop's tail */
                for (volatile unsigned k = 0; k < LANES_CHECKED - round; k++) {
                    double value = f->scalar(in[k]);
                    CHECK(hdr_real_bits(value) == hdr_real_bits(out[k]), "%s(%a) is %a alone, but %a in loop %u",
                          f->name, in[k], value, out[k], form);
                }
            }
            for (unsigned k = 0; k < LANES_CHECKED; k++) {
                digest = (digest ^ hdr_real_bits(f->scalar(in[k]))) * 0x100000001b3u;
            }
        }
    }
    /* One number for all results: the same wherever the test is built. */
    const uint64_t expected = 0x6aaa0404d0ffe2a2u;
    CHECK(digest == expected, "the digest of all results is 0x%016llx", (unsigned long long)digest);
}

int main(int argc, char **argv) {
    unsigned points = argc > 1 ? (unsigned)strtoul(argv[1], NULL, 10) : 200000;
    random_state = argc > 2 ? strtoull(argv[2], NULL, 10) : 1;
    mpfr_inits2(REFERENCE_BITS, logarithm, ln2, ln10, (mpfr_ptr)0);
    mpfr_const_log2(ln2, MPFR_RNDN);
    mpfr_set_ui(ln10, 10, MPFR_RNDN);
    mpfr_log(ln10, ln10, MPFR_RNDN);

    check_accuracy(points);
    check_pow(points);
    check_monotone(2000);
    check_exact_cases();
    check_same_bits();

    mpfr_clears(logarithm, ln2, ln10, (mpfr_ptr)0);
    mpfr_free_cache();
    if (argc > 1) {
        for (unsigned i = 0; i < FUNCTIONS && functions[i].reference; i++) {
            fprintf(stderr, "%-18s %.4f ulp at %a\n", functions[i].name, functions[i].worst, functions[i].worst_x);
        }
        fprintf(stderr, "pow                %.3g at (%a, %a) in float's range, %.3g elsewhere\n", pow_worst,
                pow_worst_x, pow_worst_p, pow_worst_wide);
    }
    return check_done("test_real");
}

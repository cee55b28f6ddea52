/* For the oracle: two kinds of real numbers, so that each formula is written once (oracle_curve.h) and evaluated in
 * both.
 *
 *   wide   long double: 64 bits of mantissa on x86-64, 113 on aarch64; powers are double, ten times faster, and good to
 *          1e-10 of a 16-bit code. Decides nearly every code.
 *   exact  MPFR with 192 bits. Decides where the wide value lies near a rounding boundary.
 *
 * An exact number is the index of a slot in an arena that is emptied before each evaluation, because a plain value can
 * be passed and returned, which an mpfr_t cannot. */
#ifndef HDR_TESTS_ORACLE_REAL_H
#define HDR_TESTS_ORACLE_REAL_H

#include <math.h>
#include <mpfr.h>
#include <stdio.h>
#include <stdlib.h>

/* A decimal as SPEC or a user wrote it: the exact kind takes the decimal itself, not a binary neighbour of it. */
typedef struct oracle_number {
    const char *text;
    long double value;
} oracle_number;

#define NUMBER(literal) ((oracle_number){#literal, literal##L})

/* ---- wide ---- */

static inline long double wide_number(oracle_number number) {
    return number.value;
}

static inline long double wide_from(long double value) {
    return value;
}

static inline long double wide_to(long double value) {
    return value;
}

static inline int wide_compare(long double a, long double b) {
    return (a > b) - (a < b);
}

static inline long double wide_add(long double a, long double b) {
    return a + b;
}

static inline long double wide_subtract(long double a, long double b) {
    return a - b;
}

static inline long double wide_multiply(long double a, long double b) {
    return a * b;
}

static inline long double wide_divide(long double a, long double b) {
    return a / b;
}

static inline long double wide_floor(long double a) {
    return floorl(a);
}

static inline long double wide_power(long double a, long double b) {
    return pow((double)a, (double)b);
}

static inline long double wide_ln(long double a) {
    return logl(a);
}

static inline long double wide_ln_one_plus(long double a) {
    return log1pl(a);
}

static inline long double wide_log10(long double a) {
    return log10l(a);
}

static inline long double wide_exp_minus_one(long double a) {
    return expm1l(a);
}

static inline long double wide_exp2(long double a) {
    return exp2l(a);
}

/* ---- exact ---- */

enum { EXACT_BITS = 192, EXACT_SLOTS = 4096 };

typedef struct exact {
    int slot;
} exact;

static mpfr_t exact_arena[EXACT_SLOTS];
static int exact_ready, exact_used;

/* Forgets all exact numbers. */
static inline void exact_empty(void) {
    exact_used = 0;
}

static inline exact exact_new(void) {
    if (exact_used == EXACT_SLOTS) {
        fprintf(stderr, "oracle: more than %d exact numbers in one evaluation\n", EXACT_SLOTS);
        abort();
    }
    if (exact_used == exact_ready) mpfr_init2(exact_arena[exact_ready++], EXACT_BITS);
    return (exact){exact_used++};
}

static inline exact exact_number(oracle_number number) {
    exact result = exact_new();
    mpfr_set_str(exact_arena[result.slot], number.text, 10, MPFR_RNDN);
    return result;
}

static inline exact exact_from(long double value) {
    exact result = exact_new();
    mpfr_set_ld(exact_arena[result.slot], value, MPFR_RNDN);
    return result;
}

static inline long double exact_to(exact value) {
    return mpfr_get_ld(exact_arena[value.slot], MPFR_RNDN);
}

static inline int exact_compare(exact a, exact b) {
    return mpfr_cmp(exact_arena[a.slot], exact_arena[b.slot]);
}

typedef int exact_unary(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);
typedef int exact_binary(mpfr_ptr, mpfr_srcptr, mpfr_srcptr, mpfr_rnd_t);

static inline exact exact_one(exact_unary *operation, exact a) {
    exact result = exact_new();
    operation(exact_arena[result.slot], exact_arena[a.slot], MPFR_RNDN);
    return result;
}

static inline exact exact_two(exact_binary *operation, exact a, exact b) {
    exact result = exact_new();
    operation(exact_arena[result.slot], exact_arena[a.slot], exact_arena[b.slot], MPFR_RNDN);
    return result;
}

static inline exact exact_add(exact a, exact b) {
    return exact_two(mpfr_add, a, b);
}

static inline exact exact_subtract(exact a, exact b) {
    return exact_two(mpfr_sub, a, b);
}

static inline exact exact_multiply(exact a, exact b) {
    return exact_two(mpfr_mul, a, b);
}

static inline exact exact_divide(exact a, exact b) {
    return exact_two(mpfr_div, a, b);
}

static inline exact exact_floor(exact a) {
    exact result = exact_new();
    mpfr_floor(exact_arena[result.slot], exact_arena[a.slot]);
    return result;
}

static inline exact exact_power(exact a, exact b) {
    return exact_two(mpfr_pow, a, b);
}

static inline exact exact_ln(exact a) {
    return exact_one(mpfr_log, a);
}

static inline exact exact_ln_one_plus(exact a) {
    return exact_one(mpfr_log1p, a);
}

static inline exact exact_log10(exact a) {
    return exact_one(mpfr_log10, a);
}

static inline exact exact_exp_minus_one(exact a) {
    return exact_one(mpfr_expm1, a);
}

static inline exact exact_exp2(exact a) {
    return exact_one(mpfr_exp2, a);
}

#endif

/* What tests of kernels share: numbers at random, lengths that meet every remainder of a vector loop, and rooms whose
 * guards tell when something was written beside the output. */
#ifndef HDR_TESTS_KERNELS_H
#define HDR_TESTS_KERNELS_H

#include <float.h>
#include <math.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { LONGEST = 1300, GUARD = 64, OFFSETS = 8 };

/* ---- Random numbers: splitmix64 ---- */

static uint64_t random_state;

static inline uint64_t random_bits(void) {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static inline double random_unit(void) {
    return (double)(random_bits() >> 11) * 0x1p-53;
}

/* Magnitudes from 2^low to 2^high, now and then 0, of either sign. */
static inline double random_signed(int low, int high) {
    double magnitude = ldexp(1 + random_unit(), low + (int)(random_bits() % (uint64_t)(high - low)));
    uint64_t kind = random_bits() % 16;
    return kind == 0 ? 0 : kind == 1 ? -0.0 : kind < 6 ? -magnitude : magnitude;
}

static inline void fill(double *values, size_t count, int low, int high) {
    for (size_t i = 0; i < count; i++)
        values[i] = random_signed(low, high);
}

static inline bool same_bits(const void *a, const void *b, size_t bytes) {
    return bytes == 0 || memcmp(a, b, bytes) == 0;
}

/* ---- Lengths, places and guards ---- */

/* 0 to 70, a whole strip, and more than one. */
static const size_t long_lengths[] = {127, 511, 512, 513, LONGEST};
enum { LENGTHS = 71 + sizeof long_lengths / sizeof *long_lengths };

static inline size_t length_number(int i) {
    return i <= 70 ? (size_t)i : long_lengths[i - 71];
}

/* Room for an output between two guards. */
typedef struct guarded {
    _Alignas(64) unsigned char bytes[GUARD + (LONGEST * 4 + OFFSETS) * sizeof(double) + GUARD];
    unsigned char *start;
} guarded;

static inline void *guard(guarded *room, size_t offset_bytes) {
    memset(room->bytes, 0xa5, sizeof room->bytes);
    room->start = room->bytes + GUARD + offset_bytes;
    return room->start;
}

static inline bool untouched(const unsigned char *from, const unsigned char *to) {
    while (from < to)
        if (*from++ != 0xa5) return false;
    return true;
}

static inline bool guards_stand(const guarded *room, size_t used_bytes) {
    return untouched(room->bytes, room->start) && untouched(room->start + used_bytes, room->bytes + sizeof room->bytes);
}

static guarded room __attribute__((unused)), other_room __attribute__((unused)), third_room __attribute__((unused));

/* What is kept of a value between verbs. */
static inline double plain_hold(double value) {
    if (value > (double)FLT_MAX) return (double)FLT_MAX;
    if (value < -(double)FLT_MAX) return -(double)FLT_MAX;
    if (fabs(value) < 1e-200) return value * 0;
    return value;
}

#endif

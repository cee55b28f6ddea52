#include "kernel/codes.h"

#include "kernel/real.h"
#include "base/cpu.h"

#include <math.h>
#include <string.h>

/* The most thresholds that share a bucket when the buckets are 2^-fraction_bits of an octave, or INT32_MAX if the table
 * is too small for so many buckets. */
static int crowding(const hdr_code_table *table, int top, int lowest, int shift) {
    int64_t first = (int64_t)hdr_real_bits(table->threshold[lowest]) >> shift;
    int most = 0, here = 0;
    int64_t bucket = -1;
    for (int k = lowest; k <= top && isfinite(table->threshold[k]); k++) {
        int64_t b = ((int64_t)hdr_real_bits(table->threshold[k]) >> shift) - first;
        if (b >= HDR_CODE_BUCKETS) return INT32_MAX;
        here = b == bucket ? here + 1 : 1;
        bucket = b;
        most = here > most ? here : most;
    }
    return most;
}

void hdr_code_table_index(hdr_code_table *table, int top) {
    for (int k = top + 1; k < 256 + 8; k++)
        table->threshold[k] = (double)INFINITY;
    int lowest = 1;
    while (lowest <= top && table->threshold[lowest] <= 0)
        lowest++;
    memset(table->base, lowest - 1, sizeof table->base);
    table->first = table->last = 0;
    table->shift = 52;
    table->compares = 0;
    if (lowest > top || !isfinite(table->threshold[lowest])) return; /* one code for all */
    int best = INT32_MAX;
    for (int shift = 52; shift >= 40; shift--) {
        int most = crowding(table, top, lowest, shift);
        if (most >= best) continue;
        best = most;
        table->shift = shift;
    }
    table->compares = best;
    table->first = (int64_t)hdr_real_bits(table->threshold[lowest]) >> table->shift << table->shift;
    int code = lowest - 1;
    int64_t bucket = 0;
    for (; bucket < HDR_CODE_BUCKETS; bucket++) {
        double start = hdr_real_from_bits((uint64_t)(table->first + (bucket << table->shift)));
        /* values below the first bucket are looked up in it: there, all thresholds are left to the comparisons */
        while (bucket > 0 && code < top && table->threshold[code + 1] <= start)
            code++;
        table->base[bucket] = (uint8_t)code;
        table->last = table->first + (bucket << table->shift);
        if (code == top || !isfinite(table->threshold[code + 1])) break; /* all above has this code */
    }
}

/* The first bucket may begin below the first threshold, and values below it are raised to its lowest: same code, since
 * the comparison is with the value itself. */
HDR_INLINE void lookup(const hdr_code_table *table, const double *c, uint8_t *out, size_t stride, size_t count,
                       int compares) {
    const int64_t first = table->first, last = table->last;
    const int shift = table->shift;
    for (size_t i = 0; i < count; i++) {
        int64_t bits = (int64_t)hdr_real_bits(c[i]); /* below 0 for what is below 0, -0 too */
        bits = bits > first ? bits : first;
        bits = bits < last ? bits : last;
        unsigned code = table->base[(bits - first) >> shift];
        for (int k = 0; k < compares; k++)
            code += c[i] >= table->threshold[code + 1];
        out[i * stride] = (uint8_t)code;
    }
}

void hdr_code_lookup(const hdr_code_table *table, const double *c, uint8_t *out, size_t stride, size_t count) {
    if (table->compares == 1)
        lookup(table, c, out, stride, count, 1);
    else
        lookup(table, c, out, stride, count, table->compares);
}

void hdr_code_half(const uint8_t codes[65536], const uint16_t *const plane[3], int planes, uint8_t *out, size_t count) {
    if (planes == 1) {
        for (size_t i = 0; i < count; i++)
            out[i] = codes[plane[0][i]];
        return;
    }
    const uint16_t *r = plane[0], *g = plane[1], *b = plane[2];
    for (size_t i = 0; i < count; i++) {
        out[3 * i] = codes[r[i]];
        out[3 * i + 1] = codes[g[i]];
        out[3 * i + 2] = codes[b[i]];
    }
}

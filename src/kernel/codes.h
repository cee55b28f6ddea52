/* 8-bit codes by comparison with thresholds: exact, whatever the curve costs. */
#ifndef HDR_CODES_H
#define HDR_CODES_H

#include "base/base.h"

/* A monotone function from doubles to the codes 0 ... top <= 255, held as its thresholds. threshold[k] is the smallest
 * double, 0 or above, whose code is k or more; +inf where there is none. All values below 0 have the code of 0.
 *
 * A value finds its code in two steps. Positive doubles order as their bits do, so bits >> shift number buckets, of
 * which base tells the code of the lowest value; as many comparisons with the next thresholds follow as one bucket may
 * hold thresholds
 * (`compares`), nearly always one. */
#define HDR_CODE_BUCKETS 16384
typedef struct hdr_code_table {
    double threshold[256 + 8]; /* [top+1 ...] are +inf */
    int64_t first, last;       /* bits of the first and last bucket's lowest value */
    int shift, compares;
    uint8_t base[HDR_CODE_BUCKETS];
} hdr_code_table;

/* Fills the rest from threshold[0 ... top], which ascend. */
void hdr_code_table_index(hdr_code_table *table, int top);

/* out[i * stride] = code of c[i]; c is finite. */
void hdr_code_lookup(const hdr_code_table *table, const double *c, uint8_t *out, size_t stride, size_t count);

/* Codes of half values by a table of all 65536; the planes' codes interleaved. */
void hdr_code_half(const uint8_t codes[65536], const uint16_t *const plane[3], int planes, uint8_t *out, size_t count);

#endif

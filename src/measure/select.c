#include "measure/select.h"

#include <stdlib.h>
#include <string.h>

enum { DIGIT = 16, DIGITS = 1 << DIGIT };

static uint64_t bits_of(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/* The bits of such numbers have their order. They are found from the highest on, 16 at a time: of all values that begin
 * like the one that is sought, how much there is of each next digit. */
hdr_status hdr_select(const double *values, size_t count, bool weighted, double goal, double *selected,
                      hdr_error *err) {
    double *heap = hdr_alloc(DIGITS, sizeof *heap), below = 0;
    bool *is_there = hdr_alloc(DIGITS, sizeof *is_there);
    uint64_t found = 0;
    for (int shift = 64 - DIGIT; heap && is_there && shift >= 0; shift -= DIGIT) {
        memset(heap, 0, DIGITS * sizeof *heap);
        memset(is_there, 0, DIGITS * sizeof *is_there);
        for (size_t i = 0; i < count; i++) {
            uint64_t bits = bits_of(values[i]);
            bool begins_so = shift == 64 - DIGIT || bits >> (shift + DIGIT) == found;
            if (!begins_so) continue;
            heap[bits >> shift & (DIGITS - 1)] += weighted ? values[i] : 1;
            is_there[bits >> shift & (DIGITS - 1)] = true;
        }
        uint64_t digit = 0;
        for (uint64_t d = 0; d < DIGITS; d++) {
            if (!is_there[d]) continue;
            digit = d;
            if (below + heap[d] > goal) break;
            below += heap[d];
        }
        found = found << DIGIT | digit;
    }
    memcpy(selected, &found, sizeof found);
    bool full = heap && is_there;
    free(heap);
    free(is_there);
    return full ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
}

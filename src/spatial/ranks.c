#include "spatial/ranks.h"

#include "kernel/real.h"
#include "kernel/strip.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DIGIT = 16, BUCKETS = 1 << DIGIT, BAND = 64 };

/* Numbers become keys that order as they do, of which each pass over the plane counts one digit, the highest first,
 * among the keys whose higher digits are those of the number that is looked for. */
typedef struct search {
    const hdr_plane *plane;
    const unsigned char *mask;
    int count;
    const uint64_t *prefix; /* the digits that are known of each number */
    int shift;              /* of the digit that is counted */
    uint64_t *tables;       /* of each thread, of each number */
} search;

static uint64_t key_at(const hdr_plane *plane, size_t at) {
    if (!plane->wide) return hdr_float_key(plane->narrow[at] + 0.0f); /* -0 is 0 */
    uint64_t bits = hdr_real_bits(plane->wide[at] + 0.0);
    return bits >> 63 ? ~bits : bits | (uint64_t)1 << 63;
}

static double number_of_key(const hdr_plane *plane, uint64_t key) {
    if (!plane->wide) return (double)hdr_float_of_key((uint32_t)key);
    return hdr_real_from_bits(key >> 63 ? key & ~((uint64_t)1 << 63) : ~key);
}

/* Of which all numbers share the first table. */
static bool is_first_digit(const search *s) {
    return s->shift + DIGIT == (s->plane->wide ? 64 : 32);
}

static hdr_status count_band(void *context, int band, int thread, hdr_error *err) {
    (void)err;
    const search *s = context;
    const hdr_plane *plane = s->plane;
    uint64_t *tables = s->tables + (size_t)thread * (size_t)s->count * BUCKETS;
    int end = (band + 1) * BAND < plane->height ? (band + 1) * BAND : plane->height;
    bool first = is_first_digit(s);
    for (int y = band * BAND; y < end; y++) {
        const unsigned char *mask = s->mask + (size_t)y * hdr_mask_row(plane->width);
        for (int x = 0; x < plane->width; x++) {
            if (!hdr_mask_has(mask, x)) continue;
            uint64_t key = key_at(plane, (size_t)y * plane->stride + (size_t)x) >> s->shift;
            if (first) tables[key]++;
            for (int i = 0; !first && i < s->count; i++)
                if (key >> DIGIT == s->prefix[i]) tables[(size_t)i * BUCKETS + (key & (BUCKETS - 1))]++;
        }
    }
    return HDR_OK;
}

/* The digit in which a rank lies, which becomes the rank among the keys that have it. */
static uint64_t digit_of_rank(const search *s, int threads, int i, uint64_t *rank) {
    uint64_t below = 0;
    size_t table = is_first_digit(s) ? 0 : (size_t)i;
    for (uint64_t digit = 0; digit < BUCKETS; digit++) {
        uint64_t here = 0;
        for (int t = 0; t < threads; t++)
            here += s->tables[((size_t)t * (size_t)s->count + table) * BUCKETS + digit];
        if (below + here >= *rank) {
            *rank -= below;
            return digit;
        }
        below += here;
    }
    return BUCKETS - 1;
}

hdr_status hdr_plane_ranks(const hdr_plane *plane, const unsigned char *mask, int count, const uint64_t *rank,
                           double *values, hdr_pool *pool, hdr_error *err) {
    int threads = hdr_pool_threads(pool), bands = (plane->height + BAND - 1) / BAND;
    size_t tables = (size_t)threads * (size_t)count * BUCKETS;
    uint64_t *prefix = hdr_alloc((size_t)count, sizeof *prefix), *left = hdr_alloc((size_t)count, sizeof *left);
    search s = {.plane = plane, .mask = mask, .count = count, .prefix = prefix};
    s.tables = hdr_alloc(tables, sizeof *s.tables);
    hdr_status status = prefix && left && s.tables ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
    if (status == HDR_OK) memcpy(left, rank, (size_t)count * sizeof *left);
    for (s.shift = (plane->wide ? 64 : 32) - DIGIT; status == HDR_OK && s.shift >= 0; s.shift -= DIGIT) {
        memset(s.tables, 0, tables * sizeof *s.tables);
        status = hdr_pool_run(pool, bands, count_band, &s, err);
        for (int i = 0; status == HDR_OK && i < count; i++)
            prefix[i] = prefix[i] << DIGIT | digit_of_rank(&s, threads, i, &left[i]);
    }
    for (int i = 0; status == HDR_OK && i < count; i++)
        values[i] = number_of_key(plane, prefix[i]);
    free(prefix);
    free(left);
    free(s.tables);
    return status;
}

/* ---- Ranges ---- */

typedef struct range {
    const hdr_plane *plane;
    double *low, *high; /* of each thread */
} range;

static hdr_status range_of_band(void *context, int band, int thread, hdr_error *err) {
    (void)err;
    const range *r = context;
    const hdr_plane *plane = r->plane;
    int end = (band + 1) * BAND < plane->height ? (band + 1) * BAND : plane->height;
    double low = r->low[thread], high = r->high[thread];
    for (int y = band * BAND; y < end; y++)
        for (int x = 0; x < plane->width; x++) {
            size_t at = (size_t)y * plane->stride + (size_t)x;
            double number = plane->wide ? plane->wide[at] : (double)plane->narrow[at];
            low = number < low ? number : low;
            high = number > high ? number : high;
        }
    r->low[thread] = low;
    r->high[thread] = high;
    return HDR_OK;
}

hdr_status hdr_plane_range(const hdr_plane *plane, double *low, double *high, hdr_pool *pool, hdr_error *err) {
    int threads = hdr_pool_threads(pool);
    range r = {plane, hdr_alloc((size_t)threads, sizeof(double)), hdr_alloc((size_t)threads, sizeof(double))};
    hdr_status status = r.low && r.high ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (int t = 0; status == HDR_OK && t < threads; t++) {
        r.low[t] = (double)INFINITY;
        r.high[t] = -(double)INFINITY;
    }
    if (status == HDR_OK) status = hdr_pool_run(pool, (plane->height + BAND - 1) / BAND, range_of_band, &r, err);
    for (int t = 0; status == HDR_OK && t < threads; t++) {
        *low = t == 0 || r.low[t] < *low ? r.low[t] : *low;
        *high = t == 0 || r.high[t] > *high ? r.high[t] : *high;
    }
    free(r.low);
    free(r.high);
    return status;
}

#include "picture/facts.h"

#include "kernel/real.h"
#include "kernel/strip.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define BUCKETS 65536

/* What one thread has seen. All of it is merged without regard to order: extremes and whole numbers. */
typedef struct tally {
    hdr_range components, luminance, channel[4];
    uint64_t pixels, lit, negative, unlit_colour, coloured;
    double lanes[8], shifted_lanes[8]; /* of the row under way */
} tally;

/* Counters of buckets. A few threads have a table each; many share them, so that memory does not grow with their
 * number. */
typedef _Atomic uint64_t counter;
enum { MOST_TABLES = 8 };

/* Percentiles are found digit by digit: values become 64-bit keys that order as they do, of which each sweep counts one
 * digit of 16 bits, the highest first, among the values whose higher digits are those of the percentile. A slot is one
 * such count; percentiles with the same higher digits share it. */
typedef struct slot {
    hdr_population of;
    uint64_t prefix; /* the higher digits */
} slot;

/* A sum with the low parts that were lost carried along (Neumaier 1974). */
typedef struct long_sum {
    double sum, lost;
} long_sum;

struct hdr_taking {
    hdr_request request;
    int threads, sweep;
    int digits[HDR_POPULATIONS]; /* of its keys that can differ */
    /* of the picture at hand */
    int height, rows;
    double *row_logs;         /* sum of ln Y of each row's lit pixels; room for `rows` */
    double *row_shifted_logs; /* sum of ln(Y + shift) of each row's pixels; the same */
    tally *tallies;
    counter *tables; /* for each table: for each percentile of the request, as many as there can be slots: BUCKETS */
    int table_count;
    /* of all pictures that have been taken in this sweep */
    tally all;
    long_sum logs, shifted_logs;
    uint64_t *counted; /* a table */
    bool contradicted; /* a sweep met other pixels than the one before */
    slot slots[HDR_MAX_PERCENTILES];
    int slot_count;
    int percentile_slot[HDR_MAX_PERCENTILES]; /* in which slot a percentile of the request is looked for */
    uint64_t prefix[HDR_MAX_PERCENTILES];     /* the digits of each percentile that are known */
    uint64_t rank[HDR_MAX_PERCENTILES];       /* its rank among the values with these digits; 0: no values */
    hdr_facts facts;
};

static const tally empty_tally = {
    .components = HDR_RANGE_EMPTY,
    .luminance = HDR_RANGE_EMPTY,
    .channel = {HDR_RANGE_EMPTY, HDR_RANGE_EMPTY, HDR_RANGE_EMPTY, HDR_RANGE_EMPTY},
};

static counter *histogram_of(const hdr_taking *taking, int table, int slot) {
    return taking->tables + ((size_t)table * (size_t)taking->request.percentiles + (size_t)slot) * BUCKETS;
}

static uint64_t *counted_of(const hdr_taking *taking, int slot) {
    return taking->counted + (size_t)slot * BUCKETS;
}

/* Order does not matter to a count. Alone, a thread needs no locked addition. */
static void count_one(const hdr_taking *taking, counter *place) {
    if (taking->threads > taking->table_count)
        atomic_fetch_add_explicit(place, 1, memory_order_relaxed);
    else
        atomic_store_explicit(place, atomic_load_explicit(place, memory_order_relaxed) + 1, memory_order_relaxed);
}

static int slot_for(hdr_taking *taking, hdr_population of, uint64_t prefix) {
    for (int i = 0; i < taking->slot_count; i++)
        if (taking->slots[i].of == of && taking->slots[i].prefix == prefix) return i;
    taking->slots[taking->slot_count] = (slot){of, prefix};
    return taking->slot_count++;
}

/* Slots for the percentiles whose digits are not all known. False: there is none. */
static bool assign_slots(hdr_taking *taking) {
    taking->slot_count = 0;
    for (int i = 0; i < taking->request.percentiles; i++) {
        hdr_population of = taking->request.percentile[i].of;
        if (taking->sweep < taking->digits[of]) taking->percentile_slot[i] = slot_for(taking, of, taking->prefix[i]);
    }
    return taking->slot_count > 0;
}

/* A sweep begins: nothing is taken yet. */
static void clear_sweep(hdr_taking *taking) {
    taking->all = empty_tally;
    taking->logs = taking->shifted_logs = (long_sum){0, 0};
    for (int s = 0; s < taking->slot_count; s++)
        memset(counted_of(taking, s), 0, BUCKETS * sizeof *taking->counted);
}

hdr_taking *hdr_taking_new(const hdr_request *request, int threads, bool float_components, hdr_error *err) {
    hdr_taking *taking = hdr_alloc(1, sizeof *taking);
    if (!taking) goto out;
    taking->request = *request;
    taking->threads = threads;
    for (int p = 0; p < HDR_POPULATIONS; p++)
        taking->digits[p] = p == HDR_OF_COMPONENTS && !float_components ? 4 : 2;
    assign_slots(taking);
    taking->tallies = hdr_alloc((size_t)threads, sizeof *taking->tallies);
    taking->counted = hdr_alloc((size_t)request->percentiles * BUCKETS, sizeof *taking->counted);
    if (!taking->tallies || !taking->counted) goto out;
    taking->table_count = threads < MOST_TABLES ? threads : MOST_TABLES;
    taking->tables = hdr_alloc((size_t)taking->table_count * (size_t)request->percentiles * BUCKETS, sizeof(counter));
    if (!taking->tables) goto out;
    clear_sweep(taking);
    return taking;
out:
    hdr_taking_free(taking);
    hdr_fail(err, HDR_INTERNAL, "out of memory");
    return NULL;
}

void hdr_taking_free(hdr_taking *taking) {
    if (!taking) return;
    free(taking->tables);
    free(taking->counted);
    free(taking->tallies);
    free(taking->row_logs);
    free(taking->row_shifted_logs);
    free(taking);
}

hdr_status hdr_taking_begin(hdr_taking *taking, int height, hdr_error *err) {
    if (height > taking->rows) {
        /* cleared pages are not there until they are written: rows that a header only claims take no memory */
        free(taking->row_logs);
        free(taking->row_shifted_logs);
        taking->rows = 0;
        taking->row_logs = hdr_alloc((size_t)height, sizeof *taking->row_logs);
        taking->row_shifted_logs = hdr_alloc((size_t)height, sizeof *taking->row_shifted_logs);
        if (!taking->row_logs || !taking->row_shifted_logs) return hdr_fail(err, HDR_INTERNAL, "out of memory");
        taking->rows = height;
    }
    taking->height = height;
    for (int t = 0; t < taking->threads; t++)
        taking->tallies[t] = empty_tally;
    for (int t = 0; t < taking->table_count; t++)
        for (int s = 0; s < taking->slot_count; s++)
            memset(histogram_of(taking, t, s), 0, BUCKETS * sizeof(counter));
    return HDR_OK;
}

/* ---- A strip ---- */

/* The key of a value of this population. Where all are float32, or rounded to it, the lower two digits are 0. */
static uint64_t key_of(const hdr_taking *taking, hdr_population of, double value, float rounded) {
    if (taking->digits[of] == 4) {
        uint64_t bits = hdr_real_bits(value + 0.0); /* -0 is 0 */
        return bits >> 63 ? ~bits : bits | (uint64_t)1 << 63;
    }
    float held = rounded + 0.0f;
    if (of == HDR_OF_LIT) held = held > 0x1p-149f ? held : 0x1p-149f;
    return (uint64_t)hdr_float_key(held) << 32;
}

static double value_of_key(const hdr_taking *taking, hdr_population of, uint64_t key) {
    if (taking->digits[of] == 4) return hdr_real_from_bits(key >> 63 ? key & ~((uint64_t)1 << 63) : ~key);
    return (double)hdr_float_of_key((uint32_t)key);
}

static void count_keys(const hdr_taking *taking, int thread, hdr_population of, const double *values, size_t count) {
    float rounded[HDR_STRIP];
    int shift = 48 - 16 * taking->sweep;
    hdr_real_to_float(values, rounded, count);
    for (int s = 0; s < taking->slot_count; s++) {
        if (taking->slots[s].of != of) continue;
        counter *histogram = histogram_of(taking, thread % taking->table_count, s);
        for (size_t i = 0; i < count; i++) {
            if (of == HDR_OF_LIT && !(values[i] > 0)) continue;
            uint64_t key = key_of(taking, of, values[i], rounded[i]) >> shift;
            if (taking->sweep == 0 || key >> 16 == taking->slots[s].prefix) count_one(taking, &histogram[key & 0xffff]);
        }
    }
}

static void count_odd_pixels(tally *mine, const double *const c[3], int planes, const double *y, size_t count) {
    uint64_t negative = 0, unlit_colour = 0, coloured = 0;
    for (size_t i = 0; i < count; i++) {
        int positive = 0;
        for (int p = 0; p < planes; p++) {
            negative += c[p][i] < 0;
            positive |= c[p][i] > 0;
        }
        unlit_colour += positive && !(y[i] > 0);
        coloured += planes == 3 && (c[0][i] != c[1][i] || c[0][i] != c[2][i]);
    }
    mine->negative += negative;
    mine->unlit_colour += unlit_colour;
    mine->coloured += coloured;
}

static void add_shifted_logs(const hdr_taking *taking, tally *mine, const double *y, size_t count) {
    double shifted[HDR_STRIP];
    uint64_t pixels = 0;
    for (size_t i = 0; i < count; i++)
        shifted[i] = taking->request.shift + (y[i] > 0 ? y[i] : 0);
    hdr_sum_logs(shifted, mine->shifted_lanes, &pixels, count);
}

void hdr_taking_strip(hdr_taking *taking, int thread, const double *const c[3], int planes, const double *y,
                      const double *alpha, size_t count) {
    tally *mine = &taking->tallies[thread];
    unsigned facts = taking->sweep == 0 ? taking->request.facts : 0;
    mine->pixels += count;
    if (facts & HDR_FACT_COMPONENTS)
        for (int p = 0; p < planes; p++)
            hdr_range_add(&mine->components, c[p], count);
    if (facts & HDR_FACT_LUMINANCE) {
        hdr_range_add(&mine->luminance, y, count);
        hdr_sum_logs(y, mine->lanes, &mine->lit, count);
    }
    if (facts & HDR_FACT_SHIFTED) add_shifted_logs(taking, mine, y, count);
    if (facts & HDR_FACT_CHANNELS) {
        for (int p = 0; p < planes; p++)
            hdr_range_add(&mine->channel[p], c[p], count);
        if (alpha) hdr_range_add(&mine->channel[3], alpha, count);
        count_odd_pixels(mine, c, planes, y, count);
    }
    bool wanted[HDR_POPULATIONS] = {false};
    for (int s = 0; s < taking->slot_count; s++)
        wanted[taking->slots[s].of] = true;
    if (wanted[HDR_OF_COMPONENTS])
        for (int p = 0; p < planes; p++)
            count_keys(taking, thread, HDR_OF_COMPONENTS, c[p], count);
    if (wanted[HDR_OF_LUMINANCE]) count_keys(taking, thread, HDR_OF_LUMINANCE, y, count);
    if (wanted[HDR_OF_LIT]) count_keys(taking, thread, HDR_OF_LIT, y, count);
}

void hdr_taking_row_end(hdr_taking *taking, int thread, int row) {
    tally *mine = &taking->tallies[thread];
    if (taking->sweep > 0) return; /* the first has settled all but percentiles */
    taking->row_logs[row] = hdr_sum_lanes(mine->lanes);
    taking->row_shifted_logs[row] = hdr_sum_lanes(mine->shifted_lanes);
    memset(mine->lanes, 0, sizeof mine->lanes);
    memset(mine->shifted_lanes, 0, sizeof mine->shifted_lanes);
}

/* ---- After a picture ---- */

static void merge_range(hdr_range *into, const hdr_range *from) {
    into->min = fmin(into->min, from->min);
    into->max = fmax(into->max, from->max);
    into->min_positive = fmin(into->min_positive, from->min_positive);
}

static void merge_tally(tally *into, const tally *from) {
    merge_range(&into->components, &from->components);
    merge_range(&into->luminance, &from->luminance);
    for (int c = 0; c < 4; c++)
        merge_range(&into->channel[c], &from->channel[c]);
    into->pixels += from->pixels;
    into->lit += from->lit;
    into->negative += from->negative;
    into->unlit_colour += from->unlit_colour;
    into->coloured += from->coloured;
}

static void add_term(long_sum *to, double term) {
    double next = to->sum + term;
    to->lost += fabs(to->sum) >= fabs(term) ? (to->sum - next) + term : (term - next) + to->sum;
    to->sum = next;
}

static double total_of(const long_sum *sum) {
    return sum->sum + sum->lost;
}

void hdr_taking_end(hdr_taking *taking) {
    for (int t = 0; t < taking->threads; t++)
        merge_tally(&taking->all, &taking->tallies[t]);
    for (int t = 0; t < taking->table_count; t++)
        for (int s = 0; s < taking->slot_count; s++) {
            const counter *from = histogram_of(taking, t, s);
            uint64_t *into = counted_of(taking, s);
            for (int b = 0; b < BUCKETS; b++)
                into[b] += atomic_load_explicit(&from[b], memory_order_relaxed);
        }
    long_sum logs = {0, 0}, shifted_logs = {0, 0}; /* rows from top to bottom */
    for (int row = 0; taking->sweep == 0 && row < taking->height; row++) {
        add_term(&logs, taking->row_logs[row]);
        add_term(&shifted_logs, taking->row_shifted_logs[row]);
    }
    add_term(&taking->logs, total_of(&logs));
    add_term(&taking->shifted_logs, total_of(&shifted_logs));
}

void hdr_taking_join(hdr_taking *taking, const hdr_taking *other) {
    merge_tally(&taking->all, &other->all);
    add_term(&taking->logs, total_of(&other->logs));
    add_term(&taking->shifted_logs, total_of(&other->shifted_logs));
    for (int s = 0; s < taking->slot_count; s++)
        for (int b = 0; b < BUCKETS; b++)
            counted_of(taking, s)[b] += counted_of(other, s)[b];
}

/* ---- After a sweep ---- */

static double finite_or_0(double value) {
    return isfinite(value) ? value : 0;
}

static void fill_facts(hdr_taking *taking) {
    const tally *all = &taking->all;
    hdr_facts *facts = &taking->facts;
    facts->known = taking->request.facts;
    facts->pixels = all->pixels;
    facts->lit = all->lit;
    facts->min_component = finite_or_0(all->components.min);
    facts->max_component = finite_or_0(all->components.max);
    facts->min_positive_component = finite_or_0(all->components.min_positive);
    facts->min_luminance = finite_or_0(all->luminance.min);
    facts->max_luminance = finite_or_0(all->luminance.max);
    facts->min_lit = finite_or_0(all->luminance.min_positive);
    for (int c = 0; c < 4; c++) {
        facts->channel_min[c] = finite_or_0(all->channel[c].min);
        facts->channel_max[c] = finite_or_0(all->channel[c].max);
    }
    facts->negative = all->negative;
    facts->unlit_colour = all->unlit_colour;
    facts->coloured = all->coloured;
    facts->log_average = all->lit ? hdr_exp(total_of(&taking->logs) / (double)all->lit) : 0;
    facts->shift = taking->request.shift;
    facts->shifted_average = all->pixels ? hdr_exp(total_of(&taking->shifted_logs) / (double)all->pixels) : 0;
}

/* The bucket in which the value of a rank lies; `below` becomes the number of values in lower buckets. */
static uint32_t bucket_of_rank(const uint64_t *histogram, uint64_t rank, uint64_t *below) {
    uint64_t seen = 0;
    for (uint32_t b = 0; b < BUCKETS; b++) {
        if (seen + histogram[b] >= rank) {
            *below = seen;
            return b;
        }
        seen += histogram[b];
    }
    *below = seen;
    return BUCKETS - 1;
}

static uint64_t histogram_size(const uint64_t *histogram) {
    uint64_t size = 0;
    for (int b = 0; b < BUCKETS; b++)
        size += histogram[b];
    return size;
}

/* One more digit of each percentile. */
static void find_digits(hdr_taking *taking) {
    for (int i = 0; i < taking->request.percentiles; i++) {
        hdr_population of = taking->request.percentile[i].of;
        if (taking->sweep >= taking->digits[of]) continue;
        const uint64_t *histogram = counted_of(taking, taking->percentile_slot[i]);
        uint64_t size = histogram_size(histogram);
        if (taking->sweep == 0) {
            taking->rank[i] = size ? hdr_nearest_rank(taking->request.percentile[i].percent, size) : 0;
        } else if (taking->rank[i] > size) {
            taking->contradicted = true;
            continue;
        }
        uint64_t below = 0;
        taking->prefix[i] = taking->prefix[i] << 16 | bucket_of_rank(histogram, taking->rank[i], &below);
        taking->rank[i] -= below;
        bool known = taking->sweep == taking->digits[of] - 1 && taking->rank[i] > 0;
        if (known) taking->facts.percentile[i] = value_of_key(taking, of, taking->prefix[i]);
    }
}

bool hdr_taking_next(hdr_taking *taking, hdr_facts *facts) {
    if (taking->sweep == 0) fill_facts(taking);
    taking->contradicted |= taking->all.pixels != taking->facts.pixels;
    find_digits(taking);
    taking->sweep++;
    if (assign_slots(taking)) {
        clear_sweep(taking);
        return true;
    }
    *facts = taking->facts;
    return false;
}

bool hdr_taking_contradicted(const hdr_taking *taking) {
    return taking->contradicted;
}

/* ---- Facts of a shot ---- */

bool hdr_facts_of_shot(const hdr_shot *shot, const hdr_request *request, hdr_facts *facts) {
    if (request->facts & ~(unsigned)HDR_FACT_LUMINANCE) return false;
    for (int i = 0; i < request->percentiles; i++) {
        double percent = hdr_decimal_value(request->percentile[i].percent);
        if (request->percentile[i].of != HDR_OF_LIT || (percent != 1 && percent != 99)) return false;
        facts->percentile[i] = percent == 1 ? shot->low : shot->high;
    }
    facts->known |= HDR_FACT_LUMINANCE;
    facts->lit = shot->lit;
    facts->log_average = shot->log_average;
    facts->max_luminance = shot->max_luminance;
    facts->min_luminance = facts->min_lit = 0;
    return true;
}

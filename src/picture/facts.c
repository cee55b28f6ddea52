#include "picture/facts.h"

#include "kernel/real.h"
#include "kernel/strip.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define BUCKETS 65536

/* What one thread has seen. All of it is merged without regard to order: extremes and whole numbers. */
typedef struct tally {
    hdr_range components, luminance, channel[4];
    uint64_t pixels, lit, negative, unlit_colour;
    double lanes[8];                          /* of the row under way */
    uint64_t *histogram[HDR_MAX_PERCENTILES]; /* BUCKETS each; used by slot, see slots below */
} tally;

/* A histogram: in the first sweep one for each population asked for, of the keys' upper 16 bits; in the second one for
 * each (population, upper bits) in which a percentile lies, of the lower 16 bits. */
typedef struct slot {
    hdr_population of;
    uint32_t upper; /* second sweep */
} slot;

struct hdr_taking {
    hdr_request request;
    int height, threads, sweep; /* sweep: 0, 1 */
    double *row_logs;           /* sum of ln Y of each row's lit pixels */
    tally *tallies;
    slot slots[HDR_MAX_PERCENTILES];
    int slot_count;
    int percentile_slot[HDR_MAX_PERCENTILES]; /* in which slot a percentile of the request is looked for */
    uint64_t rank_below[HDR_MAX_PERCENTILES]; /* second sweep: values below the slot's */
    uint64_t population[HDR_POPULATIONS];
    hdr_facts facts;
};

static int slot_for(hdr_taking *taking, hdr_population of, uint32_t upper) {
    for (int i = 0; i < taking->slot_count; i++)
        if (taking->slots[i].of == of && taking->slots[i].upper == upper) return i;
    taking->slots[taking->slot_count] = (slot){of, upper};
    return taking->slot_count++;
}

hdr_taking *hdr_taking_new(const hdr_request *request, int height, int threads, hdr_error *err) {
    hdr_taking *taking = hdr_alloc(1, sizeof *taking);
    if (!taking) goto out;
    taking->request = *request;
    taking->height = height;
    taking->threads = threads;
    for (int i = 0; i < request->percentiles; i++)
        taking->percentile_slot[i] = slot_for(taking, request->percentile[i].of, 0);
    taking->row_logs = hdr_alloc((size_t)height, sizeof *taking->row_logs);
    taking->tallies = hdr_alloc((size_t)threads, sizeof *taking->tallies);
    if (!taking->row_logs || !taking->tallies) goto out;
    for (int t = 0; t < threads; t++)
        for (int i = 0; i < request->percentiles; i++)
            if (!(taking->tallies[t].histogram[i] = hdr_alloc(BUCKETS, sizeof(uint64_t)))) goto out;
    hdr_taking_restart(taking);
    return taking;
out:
    hdr_taking_free(taking);
    hdr_fail(err, HDR_INTERNAL, "out of memory");
    return NULL;
}

void hdr_taking_free(hdr_taking *taking) {
    if (!taking) return;
    for (int t = 0; taking->tallies && t < taking->threads; t++)
        for (int i = 0; i < HDR_MAX_PERCENTILES; i++)
            free(taking->tallies[t].histogram[i]);
    free(taking->tallies);
    free(taking->row_logs);
    free(taking);
}

void hdr_taking_restart(hdr_taking *taking) {
    for (int t = 0; t < taking->threads; t++) {
        tally *mine = &taking->tallies[t];
        tally empty = {.components = HDR_RANGE_EMPTY, .luminance = HDR_RANGE_EMPTY};
        for (int c = 0; c < 4; c++)
            empty.channel[c] = empty.components;
        memcpy(empty.histogram, mine->histogram, sizeof empty.histogram);
        *mine = empty;
        for (int i = 0; i < taking->request.percentiles; i++)
            memset(mine->histogram[i], 0, BUCKETS * sizeof(uint64_t));
    }
}

/* ---- A strip ---- */

static void count_keys(const hdr_taking *taking, tally *mine, hdr_population of, const double *values, size_t count) {
    float rounded[HDR_STRIP];
    hdr_real_to_float(values, rounded, count);
    for (int s = 0; s < taking->slot_count; s++) {
        if (taking->slots[s].of != of) continue;
        uint64_t *histogram = mine->histogram[s];
        for (size_t i = 0; i < count; i++) {
            float value = rounded[i] + 0.0f; /* -0 is 0 */
            if (of == HDR_OF_LIT) {
                if (!(values[i] > 0)) continue;
                value = value > 0x1p-149f ? value : 0x1p-149f;
            }
            uint32_t key = hdr_float_key(value);
            if (taking->sweep == 0)
                histogram[key >> 16]++;
            else if (key >> 16 == taking->slots[s].upper)
                histogram[key & 0xffff]++;
        }
    }
}

static void count_odd_pixels(tally *mine, const double *const c[3], int planes, const double *y, size_t count) {
    uint64_t negative = 0, unlit_colour = 0;
    for (size_t i = 0; i < count; i++) {
        int positive = 0;
        for (int p = 0; p < planes; p++) {
            negative += c[p][i] < 0;
            positive |= c[p][i] > 0;
        }
        unlit_colour += positive && !(y[i] > 0);
    }
    mine->negative += negative;
    mine->unlit_colour += unlit_colour;
}

void hdr_taking_strip(hdr_taking *taking, int thread, int row, const double *const c[3], int planes, const double *y,
                      const double *alpha, size_t count) {
    (void)row;
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
            count_keys(taking, mine, HDR_OF_COMPONENTS, c[p], count);
    if (wanted[HDR_OF_LUMINANCE]) count_keys(taking, mine, HDR_OF_LUMINANCE, y, count);
    if (wanted[HDR_OF_LIT]) count_keys(taking, mine, HDR_OF_LIT, y, count);
}

void hdr_taking_row_end(hdr_taking *taking, int thread, int row) {
    tally *mine = &taking->tallies[thread];
    if (taking->sweep > 0) return;
    taking->row_logs[row] = hdr_sum_lanes(mine->lanes);
    memset(mine->lanes, 0, sizeof mine->lanes);
}

/* ---- After a sweep ---- */

static void merge_range(hdr_range *into, const hdr_range *from) {
    into->min = fmin(into->min, from->min);
    into->max = fmax(into->max, from->max);
    into->min_positive = fmin(into->min_positive, from->min_positive);
}

/* All tallies into the first. */
static void merge_tallies(hdr_taking *taking) {
    tally *all = &taking->tallies[0];
    for (int t = 1; t < taking->threads; t++) {
        const tally *mine = &taking->tallies[t];
        merge_range(&all->components, &mine->components);
        merge_range(&all->luminance, &mine->luminance);
        for (int c = 0; c < 4; c++)
            merge_range(&all->channel[c], &mine->channel[c]);
        all->pixels += mine->pixels;
        all->lit += mine->lit;
        all->negative += mine->negative;
        all->unlit_colour += mine->unlit_colour;
        for (int s = 0; s < taking->slot_count; s++)
            for (int b = 0; b < BUCKETS; b++)
                all->histogram[s][b] += mine->histogram[s][b];
    }
}

static double finite_or_0(double value) {
    return isfinite(value) ? value : 0;
}

static void fill_facts(hdr_taking *taking) {
    const tally *all = &taking->tallies[0];
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
    /* rows from top to bottom, with the lost low parts carried along (Neumaier 1974) */
    double sum = 0, lost = 0;
    for (int row = 0; row < taking->height; row++) {
        double term = taking->row_logs[row], next = sum + term;
        lost += fabs(sum) >= fabs(term) ? (sum - next) + term : (term - next) + sum;
        sum = next;
    }
    facts->log_average = all->lit ? hdr_exp((sum + lost) / (double)all->lit) : 0;
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

/* From the upper halves of the keys to the slots of the second sweep. */
static void refine_slots(hdr_taking *taking) {
    uint32_t upper[HDR_MAX_PERCENTILES];
    for (int i = 0; i < taking->request.percentiles; i++) {
        const uint64_t *histogram = taking->tallies[0].histogram[taking->percentile_slot[i]];
        uint64_t size = histogram_size(histogram);
        taking->population[taking->request.percentile[i].of] = size;
        uint64_t rank = size ? hdr_nearest_rank(taking->request.percentile[i].percent, size) : 1;
        upper[i] = bucket_of_rank(histogram, rank, &taking->rank_below[i]);
    }
    taking->slot_count = 0;
    for (int i = 0; i < taking->request.percentiles; i++)
        taking->percentile_slot[i] = slot_for(taking, taking->request.percentile[i].of, upper[i]);
}

static void fill_percentiles(hdr_taking *taking) {
    for (int i = 0; i < taking->request.percentiles; i++) {
        const slot *in = &taking->slots[taking->percentile_slot[i]];
        uint64_t size = taking->population[in->of], below;
        if (!size) continue;
        uint64_t rank = hdr_nearest_rank(taking->request.percentile[i].percent, size) - taking->rank_below[i];
        uint32_t lower = bucket_of_rank(taking->tallies[0].histogram[taking->percentile_slot[i]], rank, &below);
        taking->facts.percentile[i] = (double)hdr_float_of_key(in->upper << 16 | lower);
    }
}

bool hdr_taking_next(hdr_taking *taking, hdr_facts *facts) {
    merge_tallies(taking);
    if (taking->sweep == 0) {
        fill_facts(taking);
        if (taking->request.percentiles > 0) {
            refine_slots(taking);
            taking->sweep = 1;
            hdr_taking_restart(taking);
            return true;
        }
    } else {
        fill_percentiles(taking);
    }
    *facts = taking->facts;
    return false;
}

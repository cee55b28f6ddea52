/* How noisy independent renders of one scene are, without a reference.
 *
 * Of n renders x_i of P numbers, with m their mean, D_i is the sum over numbers of (x_i - m)^2, S the sum of all D_i,
 * and the root mean variance
 *
 *     RMV = sqrt(S / ((n - 1) P))
 *
 * which for an unbiased renderer estimates the RMSE of one render (Celarek, Jakob, Wimmer and Lehtinen, Quantifying the
 * Error of Light Transport Algorithms, Computer Graphics Forum 38(4), 2019). Its standard error is the jackknife's over
 * renders, with RMV_(i) that without render i:
 *
 *     RMV_(i)^2 = (S - n / (n - 1) D_i) / ((n - 2) P)
 *     SE^2 = (n - 1) / n sum of (RMV_(i) - their mean)^2
 *
 * which asks nothing of the numbers, that are not independent of each other (Efron and Tibshirani, An Introduction to
 * the Bootstrap, 1993, chapter 11). The same of the means of 2, 4, 8, ... renders at a time tells whether noise falls
 * as it ought to.
 *
 * Rows of all renders are held together, as they are stored, so that each is decoded once: bands of rows, of tiles only
 * some columns at a time. Where the memory allowed is too small for a band, it is held in slices, and decoded for each.
 */
#include "base/cpu.h"
#include "base/pool.h"
#include "chain/chain.h"
#include "io/forms.h"
#include "io/reader.h"
#include "kernel/strip.h"
#include "measure/measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    COLUMNS = 1024, /* of tiles, that are held at a time: about so many */
    LANES = 8,
    ALIGNED = 8 /* bytes, to which a plane of what is held begins */
};

typedef struct level {
    int size, groups; /* groups of so many renders, one after the other */
    int first;        /* index of its first group among all */
} level;

typedef struct measuring {
    int renders, levels, groups; /* groups: of all levels */
    level level[HDR_NOISE_LEVELS];
    hdr_source **source;
    double epsilon;
    int width, height, planes, band_rows, bands;
    int columns, slice_rows; /* that are held at a time */
    int channels;            /* of the planes, those that the files have */
    double *sums; /* of each band: D of each group, then the same of relative differences for single renders, then P */
    float *share; /* of each pixel, or NULL */
    uint64_t *strange;
    struct worker *workers;
    int threads;
} measuring;

/* What is computed of the numbers of a strip, one for each of its pixels. */
typedef struct strip {
    double
        origin[HDR_STRIP]; /* the first render's: all others are taken from there, so that bright ones lose no digits */
    double mean[HDR_STRIP];  /* of all renders so far; then of all */
    double valid[HDR_STRIP]; /* 1, or 0 where some render has a number that is not finite: it counts for nothing */
    double level_mean[HDR_NOISE_LEVELS][HDR_STRIP]; /* of all groups of that size */
    double partial[HDR_NOISE_LEVELS][HDR_STRIP];    /* of the group under way: the sum */
    double variance[HDR_STRIP];                     /* of the pixel: its channels' sum */
} strip;

typedef struct worker {
    unsigned char *memory; /* what the rows of all renders are held in */
    hdr_block *held;       /* of each render: columns of a slice */
    strip *strip;
    double *sums;
} worker;

/* ---- Kernels ---- */

HDR_INLINE void add_to_mean_body(const double *values, const double *origin, double *mean, double n, size_t count) {
    for (size_t i = 0; i < count; i++)
        mean[i] += (values[i] - origin[i] - mean[i]) / n;
}
HDR_VERSIONS_IN(static, add_to_mean, (const double *values, const double *origin, double *mean, double n, size_t count),
                (values, origin, mean, n, count))

HDR_INLINE void add_to_group_body(const double *values, const double *origin, double *partial, size_t count) {
    for (size_t i = 0; i < count; i++)
        partial[i] += values[i] - origin[i];
}
HDR_VERSIONS_IN(static, add_to_group, (const double *values, const double *origin, double *partial, size_t count),
                (values, origin, partial, count))

/* How far a group is from the mean, squared; the next one begins. */
HDR_INLINE void end_group_body(double *partial, double size, const double *mean, const double *valid, double *square,
                               size_t count) {
    for (size_t i = 0; i < count; i++) {
        double d = partial[i] / size - mean[i];
        square[i] = valid[i] > 0 ? d * d : 0;
        partial[i] = 0;
    }
}
HDR_VERSIONS_IN(static, end_group,
                (double *partial, double size, const double *mean, const double *valid, double *square, size_t count),
                (partial, size, mean, valid, square, count))

/* In place: squares become relative ones. */
HDR_INLINE void make_relative_body(double *square, const double *origin, const double *mean, double epsilon,
                                   size_t count) {
    for (size_t i = 0; i < count; i++) {
        double whole = origin[i] + mean[i], relative = square[i] / (whole * whole + epsilon);
        square[i] = square[i] > 0 ? relative : 0; /* the mean may be NaN where numbers are not valid */
    }
}
HDR_VERSIONS_IN(static, make_relative,
                (double *square, const double *origin, const double *mean, double epsilon, size_t count),
                (square, origin, mean, epsilon, count))

HDR_INLINE void add_parts_body(const double *square, double divisor, double *variance, size_t count) {
    for (size_t i = 0; i < count; i++)
        variance[i] += square[i] / divisor;
}
HDR_VERSIONS_IN(static, add_parts, (const double *square, double divisor, double *variance, size_t count),
                (square, divisor, variance, count))

/* Number i goes to lane i mod 8. */
HDR_INLINE void add_up_body(const double *values, double *sum, size_t count) {
    double lane[LANES] = {0};
    size_t whole = count / LANES * LANES;
    for (size_t i = 0; i < whole; i += LANES)
        for (size_t l = 0; l < LANES; l++)
            lane[l] += values[i + l];
    for (size_t i = whole; i < count; i++)
        lane[i - whole] += values[i];
    *sum += hdr_sum_lanes(lane);
}
HDR_VERSIONS_IN(static, add_up, (const double *values, double *sum, size_t count), (values, sum, count))

/* ---- A strip ---- */

/* Where the numbers of a strip stand in what is held of each render. */
typedef struct place {
    int row, channel;
    size_t x, count;
} place;

/* The means, and what numbers count for nothing, which are counted. */
static uint64_t find_means(const measuring *m, const worker *w, const place *at) {
    strip *s = w->strip;
    uint64_t strange = 0;
    double values[HDR_STRIP];
    memset(s->mean, 0, sizeof s->mean);
    for (size_t i = 0; i < at->count; i++)
        s->valid[i] = 1;
    for (int render = 0; render < m->renders; render++) {
        uint64_t here = hdr_block_load(&w->held[render], at->channel, at->row, at->x, values, at->count);
        for (size_t i = 0; here > 0 && i < at->count; i++)
            if (!isfinite(values[i])) s->valid[i] = 0;
        strange += here;
        if (render == 0) memcpy(s->origin, values, at->count * sizeof *values);
        add_to_mean(values, s->origin, s->mean, render + 1, at->count);
        for (int l = 0; l < m->levels; l++)
            if (render + 1 == m->level[l].size * m->level[l].groups)
                memcpy(s->level_mean[l], s->mean, at->count * sizeof *s->mean);
    }
    return strange;
}

/* How far single renders, and the means of several, are from the means of all. */
static void add_differences(const measuring *m, const worker *w, const place *at) {
    strip *s = w->strip;
    double values[HDR_STRIP], square[HDR_STRIP];
    for (int l = 0; l < m->levels; l++)
        memset(s->partial[l], 0, sizeof s->partial[l]);
    for (int render = 0; render < m->renders; render++) {
        hdr_block_load(&w->held[render], at->channel, at->row, at->x, values, at->count);
        for (int l = 0; l < m->levels; l++) {
            const level *level = &m->level[l];
            if (render >= level->size * level->groups) continue;
            add_to_group(values, s->origin, s->partial[l], at->count);
            if ((render + 1) % level->size != 0) continue;
            end_group(s->partial[l], level->size, s->level_mean[l], s->valid, square, at->count);
            add_up(square, &w->sums[level->first + render / level->size], at->count);
            if (l > 0) continue;
            add_parts(square, m->renders - 1, s->variance, at->count);
            make_relative(square, s->origin, s->mean, m->epsilon, at->count);
            add_up(square, &w->sums[m->groups + render], at->count);
        }
    }
    add_up(s->valid, &w->sums[m->groups + m->renders], at->count);
}

/* ---- A band ---- */

/* A part of a band whose rows of all renders are held at a time. */
typedef struct slice {
    int first, end, left, right; /* rows, columns */
} slice;

static size_t plane_bytes(const measuring *m, int render, int channel) {
    const hdr_picture *picture = &m->source[render]->picture;
    if (!picture->present[channel]) return 0;
    size_t size = hdr_type_size(picture->channels[channel].type) * (size_t)m->columns * (size_t)m->slice_rows;
    return (size + ALIGNED - 1) / ALIGNED * ALIGNED;
}

/* Of what is held of all renders. */
static size_t held_bytes(const measuring *m) {
    size_t size = 0;
    for (int render = 0; render < m->renders; render++)
        for (int channel = 0; channel < m->planes; channel++)
            size += plane_bytes(m, render, channel);
    return size;
}

/* Where the rows of each render are held. */
static void lay_out_held(const measuring *m, const worker *w) {
    unsigned char *at = w->memory;
    for (int render = 0; render < m->renders; render++)
        for (int channel = 0; channel < m->planes; channel++) {
            hdr_block *held = &w->held[render];
            held->type[channel] = m->source[render]->picture.channels[channel].type;
            held->stride[channel] = hdr_type_size(held->type[channel]) * (size_t)m->columns;
            held->plane[channel] = at;
            at += plane_bytes(m, render, channel);
        }
}

static hdr_status hold(const measuring *m, const worker *w, int render, const slice *part, hdr_error *err) {
    const hdr_source *source = m->source[render];
    const hdr_block *held = &w->held[render];
    hdr_reader reader;
    hdr_status status = hdr_reader_open(&reader, m->source[render], part->left, part->right, err);
    for (int row = part->first; row < part->end && status == HDR_OK; row++) {
        status = hdr_reader_seek(&reader, row, err);
        for (int c = 0; c < m->planes && status == HDR_OK; c++) {
            if (!source->picture.present[c]) continue;
            size_t size = hdr_type_size(held->type[c]);
            memcpy((unsigned char *)held->plane[c] + (size_t)(row - part->first) * held->stride[c],
                   reader.block.plane[c] + (size_t)(row - reader.block.first_row) * reader.block.stride[c] +
                       (size_t)part->left * size,
                   (size_t)(part->right - part->left) * size);
        }
    }
    hdr_reader_close(&reader);
    return status;
}

static uint64_t measure_strip(const measuring *m, const worker *w, const slice *part, int row, int x) {
    strip *s = w->strip;
    size_t left = (size_t)(part->right - x), count = left < HDR_STRIP ? left : HDR_STRIP;
    uint64_t strange = 0;
    memset(s->variance, 0, sizeof s->variance);
    for (int channel = 0; channel < m->planes; channel++) {
        if (!m->source[0]->picture.present[channel]) continue;
        place at = {row - part->first, channel, (size_t)(x - part->left), count};
        strange += find_means(m, w, &at);
        add_differences(m, w, &at);
    }
    /* the standard deviation of a pixel, all its colours together */
    for (size_t i = 0; m->share && i < count; i++)
        m->share[(size_t)row * (size_t)m->width + (size_t)x + i] = (float)sqrt(s->variance[i] / m->channels);
    return strange;
}

static hdr_status measure_slice(const measuring *m, int thread, const slice *part, hdr_error *err) {
    const worker *w = &m->workers[thread];
    for (int render = 0; render < m->renders; render++) {
        hdr_status status = hold(m, w, render, part, err);
        if (status != HDR_OK) return status;
    }
    for (int row = part->first; row < part->end; row++)
        for (int x = part->left; x < part->right; x += HDR_STRIP)
            m->strange[thread] += measure_strip(m, w, part, row, x);
    return HDR_OK;
}

static int smaller(int a, int b) {
    return a < b ? a : b;
}

static hdr_status measure_band(void *context, int band, int thread, hdr_error *err) {
    const measuring *m = context;
    int first = band * m->band_rows, end = smaller(first + m->band_rows, m->height);
    m->workers[thread].sums = m->sums + (size_t)band * (size_t)(m->groups + m->renders + 1);
    for (int left = 0; left < m->width; left += m->columns)
        for (int row = first; row < end; row += m->slice_rows) {
            slice part = {row, smaller(row + m->slice_rows, end), left, smaller(left + m->columns, m->width)};
            hdr_status status = measure_slice(m, thread, &part, err);
            if (status != HDR_OK) return status;
        }
    return HDR_OK;
}

/* ---- Figures ---- */

/* RMV and its jackknife. error: below 0 where there are fewer than 3. */
static void root_mean_variance(const double *d, int groups, double numbers, double *rmv, double *error) {
    double sum = 0, mean = 0, squares = 0;
    for (int i = 0; i < groups; i++)
        sum += d[i];
    *rmv = numbers > 0 ? sqrt(sum / ((groups - 1) * numbers)) : 0;
    *error = -1;
    if (groups < 3 || numbers == 0) return;
    for (int i = 0; i < groups; i++) {
        double left = (sum - d[i] * groups / (groups - 1)) / ((groups - 2) * numbers);
        double without = sqrt(left > 0 ? left : 0), off = without - mean;
        mean += off / (i + 1);
        squares += off * (without - mean);
    }
    *error = sqrt(squares * (groups - 1) / groups);
}

static hdr_status sum_up(measuring *m, hdr_noise *out, hdr_error *err) {
    size_t count = (size_t)(m->groups + m->renders + 1);
    double *total = hdr_alloc(count, sizeof *total);
    if (!total) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (int band = 0; band < m->bands; band++)
        for (size_t i = 0; i < count; i++)
            total[i] += m->sums[(size_t)band * count + i];
    double numbers = total[count - 1];
    out->picture = m->source[0]->picture;
    out->renders = m->renders;
    out->numbers = (uint64_t)numbers;
    out->epsilon = m->epsilon;
    for (int t = 0; t < m->threads; t++)
        out->left_out += m->strange[t];
    out->levels = m->levels;
    for (int l = 0; l < m->levels; l++) {
        out->level[l].size = m->level[l].size;
        root_mean_variance(total + m->level[l].first, m->level[l].groups, numbers, &out->level[l].rmv,
                           &out->level[l].error);
    }
    out->rmv = out->level[0].rmv;
    out->error = out->level[0].error;
    root_mean_variance(total + m->groups, m->renders, numbers, &out->relative, &out->relative_error);
    free(total);
    return HDR_OK;
}

/* To a mean of 1: of samples that are given out in proportion to the standard deviation, the mean has the least
 * variance. Neyman, On the Two Different Aspects of the Representative Method, JRSS 97(4), 1934. */
static void normalise_shares(const measuring *m) {
    size_t pixels = (size_t)m->width * (size_t)m->height;
    double sum = 0;
    for (size_t i = 0; i < pixels; i++)
        sum += (double)m->share[i];
    for (size_t i = 0; i < pixels; i++)
        m->share[i] = sum > 0 ? (float)((double)m->share[i] * (double)pixels / sum) : 1;
}

/* ---- In all ---- */

/* Sizes of groups, doubled as long as there are two. */
static void choose_levels(measuring *m) {
    for (int size = 1; m->levels < HDR_NOISE_LEVELS && m->renders / size >= 2; size *= 2) {
        m->level[m->levels++] = (level){size, m->renders / size, m->groups};
        m->groups += m->renders / size;
    }
}

/* Bands hold whole blocks of all renders, where these begin alike; of tiles whole ones are held. */
static void divide(measuring *m, uint64_t memory) {
    int tile = m->source[0]->tile_columns;
    for (int i = 0; i < m->renders; i++) {
        if (m->source[i]->block_rows > m->band_rows) m->band_rows = m->source[i]->block_rows;
        if (m->source[i]->tile_columns != tile) tile = 0;
    }
    m->bands = (m->height + m->band_rows - 1) / m->band_rows;
    m->columns = smaller(tile > 0 ? (COLUMNS + tile - 1) / tile * tile : m->width, m->width);
    m->threads = m->threads < m->bands ? m->threads : m->bands > 0 ? m->bands : 1;
    m->slice_rows = 1;
    uint64_t rows = memory / 2 / (uint64_t)m->threads / (held_bytes(m) + 1), band = (uint64_t)m->band_rows;
    m->slice_rows = rows < 1 ? 1 : rows < band ? (int)rows : (int)band;
    if (m->slice_rows > m->height && m->height > 0) m->slice_rows = m->height;
}

static hdr_status make_workers(measuring *m, hdr_error *err) {
    m->workers = hdr_alloc((size_t)m->threads, sizeof *m->workers);
    m->strange = hdr_alloc((size_t)m->threads, sizeof *m->strange);
    bool made = m->workers && m->strange;
    for (int t = 0; made && t < m->threads; t++) {
        worker *w = &m->workers[t];
        w->memory = hdr_alloc(held_bytes(m), 1);
        w->held = hdr_alloc((size_t)m->renders, sizeof *w->held);
        w->strip = hdr_alloc(1, sizeof *w->strip);
        made = w->memory && w->held && w->strip;
        if (made) lay_out_held(m, w);
    }
    return made ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
}

static hdr_status lay_out(measuring *m, const hdr_settings *settings, bool share, hdr_error *err) {
    const hdr_picture *picture = &m->source[0]->picture;
    m->width = (int)hdr_window_width(&picture->data);
    m->height = (int)hdr_window_height(&picture->data);
    m->planes = picture->planes;
    for (int channel = 0; channel < m->planes; channel++)
        m->channels += picture->present[channel];
    m->threads = settings->threads;
    divide(m, settings->memory);
    choose_levels(m);
    m->sums = hdr_alloc((size_t)m->bands, (size_t)(m->groups + m->renders + 1) * sizeof *m->sums);
    if (share) m->share = hdr_alloc((size_t)m->width * (size_t)m->height, sizeof *m->share);
    if (!m->sums || (share && !m->share)) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    return make_workers(m, err);
}

static void close_all(measuring *m) {
    for (int t = 0; m->workers && t < m->threads; t++) {
        free(m->workers[t].memory);
        free(m->workers[t].held);
        free(m->workers[t].strip);
    }
    free(m->workers);
    free(m->strange);
    free(m->sums);
    free(m->share);
    hdr_close_alike(m->renders, m->source);
}

hdr_status hdr_measure_noise(const hdr_chain *chain, int count, hdr_input *const inputs[], double epsilon, bool share,
                             hdr_noise *out, hdr_error *err) {
    hdr_error unheard = {0};
    if (!err) err = &unheard;
    measuring m = {.renders = count, .epsilon = epsilon};
    *out = (hdr_noise){.renders = count};
    if (count < 2) return hdr_fail(err, HDR_USAGE, "noise is what renders differ by: name two or more");
    hdr_reading reading = hdr_chain_reading(chain);
    m.source = hdr_open_alike(count, inputs, &reading, false, err);
    if (!m.source) return err->status;
    hdr_status status = lay_out(&m, hdr_chain_settings(chain), share, err);
    hdr_pool *pool = status == HDR_OK ? hdr_pool_new(m.threads, err) : NULL;
    if (status == HDR_OK && !pool) status = HDR_INTERNAL;
    if (status == HDR_OK) status = hdr_pool_run(pool, m.bands, measure_band, &m, err);
    if (status == HDR_OK) status = sum_up(&m, out, err);
    if (status == HDR_OK) status = hdr_check_left_out(chain, out->numbers, out->left_out, err);
    if (status == HDR_OK && share) {
        normalise_shares(&m);
        out->share = m.share;
        m.share = NULL;
    }
    hdr_pool_free(pool);
    close_all(&m);
    return status;
}

void hdr_noise_free(hdr_noise *noise) {
    if (!noise) return;
    free(noise->share);
    noise->share = NULL;
}

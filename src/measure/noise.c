/* How noisy independent renders of one scene are, without a reference.
 *
 * Of n renders x_i of P numbers, with m their mean: D_i = sum over numbers of (x_i - m)^2, S = sum of D_i, and the root
 * mean variance RMV = sqrt(S / ((n - 1) P)), which for an unbiased renderer estimates the RMSE of one render (Celarek,
 * Jakob, Wimmer and Lehtinen, Quantifying the Error of Light Transport Algorithms, Computer Graphics Forum 38(4),
 * 2019). Its standard error is the jackknife's over renders: without render i RMV_(i)^2 = (S - n / (n - 1) D_i) / ((n -
 * 2) P),    SE^2 = (n - 1) / n sum of (RMV_(i) - their mean)^2 which asks nothing of the numbers, that are not
 * independent of each other (Efron and Tibshirani, An Introduction to the Bootstrap, 1993, chapter 11). The same of the
 * means of 2, 4, 8, ... renders at a time tells whether noise falls as it ought to.
 *
 * Each band of rows is read twice: for the means, then for what differs from them. */
#include "base/pool.h"
#include "chain/chain.h"
#include "io/forms.h"
#include "kernel/strip.h"
#include "measure/measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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
    int channels; /* of the planes, those that the files have */
    double *sums; /* of each band: D of each group, then the same of relative differences for single renders, then P */
    float *share; /* of each pixel, or NULL */
    uint64_t *strange;
    struct worker *workers;
    int threads;
} measuring;

/* What a band is made in: rows of doubles, one for each number of the band. */
typedef struct worker {
    double *origin; /* the first render's number: all others are taken from there, so that bright ones lose no digits */
    double *mean;   /* of all renders so far; then of all */
    double *level_mean[HDR_NOISE_LEVELS]; /* of all groups of that size */
    double *partial[HDR_NOISE_LEVELS];    /* of the group under way: the sum */
    double *squares;                      /* of differences from the mean */
    unsigned char *strange;               /* a number that is not finite in some render: it counts for nothing */
    measuring *m;
    double *sums;
    int first, render;
} worker;

/* ---- A band ---- */

static size_t place(const worker *w, int channel, int row, size_t x) {
    const measuring *m = w->m;
    return ((size_t)channel * (size_t)m->band_rows + (size_t)(row - w->first)) * (size_t)m->width + x;
}

static void see_number(worker *w, size_t i, double value) {
    if (value - value != 0) {
        w->strange[i] = 1;
        return;
    }
    if (w->render == 0) w->origin[i] = value;
    w->mean[i] += (value - w->origin[i] - w->mean[i]) / (w->render + 1);
    for (int l = 0; l < w->m->levels; l++)
        if (w->render + 1 == w->m->level[l].size * w->m->level[l].groups) w->level_mean[l][i] = w->mean[i];
}

static void take_means(void *context, int channel, int row, size_t x, const double *values, size_t count) {
    worker *w = context;
    size_t at = place(w, channel, row, x);
    for (size_t i = 0; i < count; i++)
        see_number(w, at + i, values[i]);
}

/* A group is whole: how far its mean is from that of all groups of its size. */
static void end_group(worker *w, int l, size_t at, size_t count) {
    const level *level = &w->m->level[l];
    int group = w->render / level->size;
    double sum = 0, relative = 0, *mean = w->level_mean[l], *partial = w->partial[l];
    for (size_t i = at; i < at + count; i++) {
        double d = w->strange[i] ? 0 : partial[i] / level->size - mean[i];
        sum += d * d;
        partial[i] = 0;
        if (l > 0) continue;
        double whole = w->origin[i] + mean[i];
        relative += d * d / (whole * whole + w->m->epsilon);
        w->squares[i] += d * d;
    }
    w->sums[level->first + group] += sum;
    if (l == 0) w->sums[w->m->groups + group] += relative;
}

static void take_differences(void *context, int channel, int row, size_t x, const double *values, size_t count) {
    worker *w = context;
    const measuring *m = w->m;
    size_t at = place(w, channel, row, x);
    for (int l = 0; l < m->levels; l++) {
        const level *level = &m->level[l];
        if (w->render >= level->size * level->groups) continue;
        for (size_t i = 0; i < count; i++)
            w->partial[l][at + i] += w->strange[at + i] ? 0 : values[i] - w->origin[at + i];
        if ((w->render + 1) % level->size == 0) end_group(w, l, at, count);
    }
}

/* The standard deviation of a pixel, all its colours together. */
static void fill_shares(const worker *w, int rows) {
    const measuring *m = w->m;
    for (int row = 0; m->share && row < rows; row++)
        for (int x = 0; x < m->width; x++) {
            double variance = 0;
            for (int channel = 0; channel < m->planes; channel++) /* of a channel that is not there: 0 */
                variance += w->squares[place(w, channel, w->first + row, (size_t)x)] / (m->renders - 1);
            m->share[(size_t)(w->first + row) * (size_t)m->width + (size_t)x] = (float)sqrt(variance / m->channels);
        }
}

static hdr_status measure_band(void *context, int band, int thread, hdr_error *err) {
    measuring *m = context;
    worker *w = &m->workers[thread];
    size_t numbers = (size_t)m->planes * (size_t)m->band_rows * (size_t)m->width;
    int end = (band + 1) * m->band_rows < m->height ? (band + 1) * m->band_rows : m->height;
    w->first = band * m->band_rows;
    w->sums = m->sums + (size_t)band * (size_t)(m->groups + m->renders + 1);
    memset(w->origin, 0, numbers * sizeof *w->origin);
    memset(w->mean, 0, numbers * sizeof *w->mean);
    memset(w->squares, 0, numbers * sizeof *w->squares);
    memset(w->strange, 0, numbers);
    for (int l = 0; l < m->levels; l++)
        memset(w->partial[l], 0, numbers * sizeof *w->partial[l]);
    for (int pass = 0; pass < 2; pass++)
        for (w->render = 0; w->render < m->renders; w->render++) {
            uint64_t strange = 0;
            hdr_status status = hdr_source_visit(m->source[w->render], m->planes, w->first, end,
                                                 pass == 0 ? take_means : take_differences, w, &strange, err);
            if (status != HDR_OK) return status;
            if (pass == 0) m->strange[thread] += strange;
        }
    fill_shares(w, end - w->first);
    for (int channel = 0; channel < m->planes; channel++)
        for (size_t i = place(w, channel, w->first, 0);
             m->source[0]->picture.present[channel] && i < place(w, channel, end, 0); i++)
            w->sums[m->groups + m->renders] += !w->strange[i];
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

static hdr_status make_workers(measuring *m, hdr_error *err) {
    size_t numbers = (size_t)m->planes * (size_t)m->band_rows * (size_t)m->width;
    m->workers = hdr_alloc((size_t)m->threads, sizeof *m->workers);
    m->strange = hdr_alloc((size_t)m->threads, sizeof *m->strange);
    bool made = m->workers && m->strange;
    for (int t = 0; made && t < m->threads; t++) {
        worker *w = &m->workers[t];
        w->m = m;
        w->origin = hdr_alloc(numbers, sizeof *w->origin);
        w->mean = hdr_alloc(numbers, sizeof *w->mean);
        w->squares = hdr_alloc(numbers, sizeof *w->squares);
        w->strange = hdr_alloc(numbers, 1);
        made = w->origin && w->mean && w->squares && w->strange;
        for (int l = 0; made && l < m->levels; l++) {
            w->level_mean[l] = hdr_alloc(numbers, sizeof *w->mean);
            w->partial[l] = hdr_alloc(numbers, sizeof *w->mean);
            made = w->level_mean[l] && w->partial[l];
        }
    }
    return made ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
}

static hdr_status lay_out(measuring *m, int threads, bool share, hdr_error *err) {
    const hdr_picture *picture = &m->source[0]->picture;
    m->width = (int)hdr_window_width(&picture->data);
    m->height = (int)hdr_window_height(&picture->data);
    m->planes = picture->planes;
    for (int channel = 0; channel < m->planes; channel++)
        m->channels += picture->present[channel];
    for (int i = 0; i < m->renders; i++)
        if (m->source[i]->block_rows > m->band_rows) m->band_rows = m->source[i]->block_rows;
    m->bands = (m->height + m->band_rows - 1) / m->band_rows;
    m->threads = threads < m->bands ? threads : m->bands > 0 ? m->bands : 1;
    choose_levels(m);
    m->sums = hdr_alloc((size_t)m->bands, (size_t)(m->groups + m->renders + 1) * sizeof *m->sums);
    if (share) m->share = hdr_alloc((size_t)m->width * (size_t)m->height, sizeof *m->share);
    if (!m->sums || (share && !m->share)) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    return make_workers(m, err);
}

static void close_all(measuring *m) {
    for (int t = 0; m->workers && t < m->threads; t++) {
        free(m->workers[t].origin);
        free(m->workers[t].mean);
        free(m->workers[t].squares);
        free(m->workers[t].strange);
        for (int l = 0; l < m->levels; l++) {
            free(m->workers[t].level_mean[l]);
            free(m->workers[t].partial[l]);
        }
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
    hdr_status status = lay_out(&m, hdr_chain_settings(chain)->threads, share, err);
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

/* Errors of a picture against a reference: one sweep over both together, block by block. Sums are taken over squares of
 * TILE pixels, each by one thread in the order of its rows, and added in the order of the squares: threads change
 * nothing. */
#include "base/pool.h"
#include "chain/chain.h"
#include "io/forms.h"
#include "io/reader.h"
#include "kernel/errors.h"
#include "kernel/strip.h"
#include "measure/measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TILE = HDR_TILE_SIDE, TEST = 0, REFERENCE = 1 };
_Static_assert(HDR_STRIP % TILE == 0, "a strip is whole tiles");

/* The largest error that a band has. */
typedef struct worst {
    double error, test, reference;
    int x, y, channel;
} worst;

typedef struct comparing {
    hdr_source **source; /* two */
    double epsilon;
    int width, height, band_rows, bands, columns, rows; /* columns, rows: of tiles */
    double (*sums)[4][HDR_ERROR_SUMS];                  /* of each tile, of each channel */
    worst *worsts;                                      /* of each band */
    hdr_reader (*readers)[2];                           /* of each thread, of each picture */
    int threads;
} comparing;

/* ---- The sweep ---- */

static bool has_channel(const comparing *c, int channel) {
    return c->source[TEST]->picture.present[channel] && c->source[REFERENCE]->picture.present[channel];
}

/* A strip of a row: whole tiles, but for the row's end. */
static void compare_strip(comparing *c, const hdr_reader r[2], int channel, int row, int x, worst *largest) {
    double value[2][HDR_STRIP];
    size_t count = c->width - x < HDR_STRIP ? (size_t)(c->width - x) : HDR_STRIP;
    for (int which = TEST; which <= REFERENCE; which++)
        hdr_block_load(&r[which].block, channel, row - r[which].block.first_row, (size_t)x, value[which], count);
    double(*sums)[4][HDR_ERROR_SUMS] = c->sums + (size_t)(row / TILE) * (size_t)c->columns + (size_t)(x / TILE);
    for (size_t i = 0; i < count; i += TILE, sums++)
        hdr_error_sums(value[TEST] + i, value[REFERENCE] + i, count - i < TILE ? count - i : TILE, c->epsilon,
                       (*sums)[channel]);
    if (channel == 3) return;
    size_t at = hdr_error_worst(value[TEST], value[REFERENCE], count, &largest->error);
    if (at < count)
        *largest = (worst){largest->error, value[TEST][at], value[REFERENCE][at], x + (int)at, row, channel};
}

static hdr_status compare_band(void *context, int band, int thread, hdr_error *err) {
    comparing *c = context;
    hdr_reader *r = c->readers[thread];
    int first = band * c->band_rows, end = first + c->band_rows < c->height ? first + c->band_rows : c->height;
    c->worsts[band].channel = -1;
    for (int row = first; row < end; row++) {
        hdr_status status = hdr_reader_seek(&r[TEST], row, err);
        if (status == HDR_OK) status = hdr_reader_seek(&r[REFERENCE], row, err);
        if (status != HDR_OK) return status;
        for (int channel = 0; channel < 4; channel++)
            for (int x = 0; x < c->width && has_channel(c, channel); x += HDR_STRIP)
                compare_strip(c, r, channel, row, x, &c->worsts[band]);
    }
    return HDR_OK;
}

/* ---- Figures ---- */

static hdr_errors figures_of(const double sums[HDR_ERROR_SUMS]) {
    double n = sums[HDR_SUM_COUNT];
    hdr_errors e = {.numbers = (uint64_t)n};
    if (n == 0) return e;
    e.bias = sums[HDR_SUM_SIGNED] / n;
    e.mae = sums[HDR_SUM_ABSOLUTE] / n;
    e.mse = sums[HDR_SUM_SQUARED] / n;
    e.rmse = sqrt(e.mse);
    e.mrse = sums[HDR_SUM_RELATIVE_SQUARE] / n;
    e.mape = sums[HDR_SUM_RELATIVE] / n;
    e.smape = sums[HDR_SUM_SYMMETRIC] / n;
    return e;
}

/* Sums of the tiles, each with the part that rounding has lost. Neumaier, Rundungsfehleranalyse einiger Verfahren zur
 * Summation endlicher Summen, ZAMM 54, 1974. */
static void add_up(const comparing *c, int first, int end, double total[HDR_ERROR_SUMS]) {
    double lost[HDR_ERROR_SUMS] = {0};
    memset(total, 0, HDR_ERROR_SUMS * sizeof *total);
    for (int tile = 0; tile < c->columns * c->rows; tile++)
        for (int channel = first; channel < end; channel++)
            for (int s = 0; s < HDR_ERROR_SUMS; s++) {
                double value = c->sums[tile][channel][s], sum = total[s] + value;
                lost[s] += fabs(total[s]) >= fabs(value) ? (total[s] - sum) + value : (value - sum) + total[s];
                total[s] = sum;
            }
    for (int s = 0; s < HDR_ERROR_SUMS; s++)
        total[s] += lost[s];
}

/* Sums of each tile, all colours together. */
static hdr_status keep_tiles(const comparing *c, hdr_comparison *out, hdr_error *err) {
    out->tiles = c->columns * c->rows;
    out->tile = hdr_alloc((size_t)out->tiles, sizeof *out->tile);
    if (!out->tile) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (int tile = 0; tile < out->tiles; tile++)
        for (int channel = 0; channel < 3; channel++) {
            const double *sums = c->sums[tile][channel];
            hdr_tile *to = &out->tile[tile];
            to->numbers += sums[HDR_SUM_COUNT];
            to->signed_sum += sums[HDR_SUM_SIGNED];
            to->absolute += sums[HDR_SUM_ABSOLUTE];
            to->squared += sums[HDR_SUM_SQUARED];
            to->relative_square += sums[HDR_SUM_RELATIVE_SQUARE];
            to->relative += sums[HDR_SUM_RELATIVE];
            to->symmetric += sums[HDR_SUM_SYMMETRIC];
        }
    return HDR_OK;
}

static hdr_status sum_up(const comparing *c, hdr_comparison *out, hdr_error *err) {
    double total[HDR_ERROR_SUMS];
    uint64_t all = 0;
    out->picture = c->source[TEST]->picture;
    for (int channel = 0; channel < 4; channel++) {
        out->present[channel] = has_channel(c, channel);
        add_up(c, channel, channel + 1, total);
        out->channel[channel] = figures_of(total);
        if (out->present[channel] && channel < 3)
            all += (uint64_t)c->width * (uint64_t)c->height - out->channel[channel].numbers;
    }
    out->left_out = all;
    add_up(c, 0, 3, total);
    out->all = figures_of(total);
    out->worst_channel = -1;
    for (int band = 0; band < c->bands; band++) {
        const worst *w = &c->worsts[band];
        if (w->channel < 0 || !(w->error > out->worst)) continue;
        out->worst = w->error;
        out->worst_channel = w->channel;
        out->worst_x = out->picture.data.min_x + w->x;
        out->worst_y = out->picture.data.min_y + w->y;
        out->worst_test = w->test;
        out->worst_reference = w->reference;
    }
    return keep_tiles(c, out, err);
}

/* ---- In all ---- */

/* Bands hold whole blocks of both pictures, where these begin alike, and whole tiles. */
static hdr_status lay_out(comparing *c, int threads, hdr_error *err) {
    const hdr_window *data = &c->source[TEST]->picture.data;
    int most = c->source[TEST]->block_rows;
    if (c->source[REFERENCE]->block_rows > most) most = c->source[REFERENCE]->block_rows;
    c->width = (int)hdr_window_width(data);
    c->height = (int)hdr_window_height(data);
    c->band_rows = (most + TILE - 1) / TILE * TILE;
    c->bands = (c->height + c->band_rows - 1) / c->band_rows;
    c->columns = (c->width + TILE - 1) / TILE;
    c->rows = (c->height + TILE - 1) / TILE;
    c->threads = threads < c->bands ? threads : c->bands > 0 ? c->bands : 1;
    c->sums = hdr_alloc((size_t)c->columns * (size_t)c->rows, sizeof *c->sums);
    c->worsts = hdr_alloc((size_t)c->bands, sizeof *c->worsts);
    c->readers = hdr_alloc((size_t)c->threads, sizeof *c->readers);
    if (!c->sums || !c->worsts || !c->readers) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (int t = 0; t < c->threads; t++)
        for (int which = TEST; which <= REFERENCE; which++) {
            hdr_status status = hdr_reader_open(&c->readers[t][which], c->source[which], 0, 0, err);
            if (status != HDR_OK) return status;
        }
    return HDR_OK;
}

static void close_all(comparing *c) {
    for (int t = 0; c->readers && t < c->threads; t++)
        for (int which = TEST; which <= REFERENCE; which++)
            hdr_reader_close(&c->readers[t][which]);
    hdr_close_alike(2, c->source);
    free(c->sums);
    free(c->worsts);
    free(c->readers);
}

hdr_status hdr_check_left_out(const hdr_chain *chain, uint64_t numbers, uint64_t left_out, hdr_error *err) {
    if (numbers == 0 && left_out == 0)
        return hdr_fail(err, HDR_BAD_DATA,
                        "there is nothing to measure: there are no pixels, or --crop has none of them");
    if (numbers == 0)
        return hdr_fail(err, HDR_BAD_DATA, "there is nothing to measure: %llu components are NaN or infinite",
                        (unsigned long long)left_out);
    if (left_out > 0 && hdr_chain_settings(chain)->strict)
        return hdr_fail(err, HDR_BAD_DATA, "%llu components are NaN or infinite", (unsigned long long)left_out);
    return HDR_OK;
}

hdr_status hdr_compare(const hdr_chain *chain, hdr_input *test, hdr_input *reference, double epsilon,
                       hdr_comparison *out, hdr_error *err) {
    hdr_error unheard = {0};
    if (!err) err = &unheard;
    comparing c = {.epsilon = epsilon};
    *out = (hdr_comparison){.epsilon = epsilon};
    hdr_reading reading = hdr_chain_reading(chain);
    c.source = hdr_open_alike(2, (hdr_input *const[]){test, reference}, &reading, false, err);
    if (!c.source) return err->status;
    hdr_status status = lay_out(&c, hdr_chain_settings(chain)->threads, err);
    hdr_pool *pool = status == HDR_OK ? hdr_pool_new(c.threads, err) : NULL;
    if (status == HDR_OK && !pool) status = HDR_INTERNAL;
    if (status == HDR_OK) status = hdr_pool_run(pool, c.bands, compare_band, &c, err);
    if (status == HDR_OK) status = sum_up(&c, out, err);
    if (status == HDR_OK) status = hdr_check_left_out(chain, out->all.numbers, out->left_out, err);
    hdr_pool_free(pool);
    close_all(&c);
    return status;
}

void hdr_comparison_free(hdr_comparison *comparison) {
    if (!comparison) return;
    free(comparison->tile);
    comparison->tile = NULL;
}

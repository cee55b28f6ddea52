#include "io/smooth.h"

#include "io/forms.h"
#include "io/input.h"
#include "io/reader.h"
#include "kernel/strip.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* Rows of a block: many, since those around them are decoded once more for each, but not all of a file that is one
 * chunk; and whole tiles of the filter, however a file is cut, so that its result does not depend on that. */
enum { MOST_ROWS = 4 * HDR_NLMEANS_ROWS };

typedef struct smooth_source {
    hdr_source base;
    hdr_source *picture, *guide;
    const char *guide_name;
    hdr_nlmeans filter;
    int channels;       /* of colour: those that the picture has */
    int place[3];       /* of each colour channel among them */
    atomic_uchar *seen; /* of each block: whether it was read before */
    _Atomic uint64_t pixels, left_alone, unusable;
} smooth_source;

/* What a thread makes a block in. */
typedef struct smooth_worker {
    hdr_nlmeans_room *room;
    float *numbers;                  /* what the others point into */
    float *colour[3], *deviation[3]; /* of a block and what is around it */
    float *out[3], *alpha;           /* of a block */
} smooth_worker;

static size_t width_of(const smooth_source *source) {
    return (size_t)hdr_window_width(&source->base.picture.data);
}

static void worker_free(hdr_source *source, void *worker) {
    smooth_worker *w = worker;
    (void)source;
    if (!w) return;
    hdr_nlmeans_room_free(w->room);
    free(w->numbers);
    free(w);
}

static hdr_status worker_new(hdr_source *base, void **worker, hdr_error *err) {
    const smooth_source *source = (smooth_source *)base;
    int64_t height = hdr_window_height(&base->picture.data);
    int64_t wanted = base->block_rows < height ? base->block_rows : height;
    int64_t around = wanted + 2 * (int64_t)hdr_nlmeans_reach(&source->filter);
    if (around > height) around = height;
    size_t block = (size_t)wanted * width_of(source), read = (size_t)around * width_of(source);
    size_t channels = (size_t)source->channels;
    smooth_worker *w = hdr_alloc(1, sizeof *w);
    if (w) {
        w->room = hdr_nlmeans_room_new(&source->filter);
        /* rows of both pictures, then the result's and alpha */
        w->numbers = hdr_alloc((2 * channels * (size_t)around + (channels + 1) * (size_t)wanted),
                               width_of(source) * sizeof *w->numbers);
    }
    *worker = w;
    if (!w || !w->room || !w->numbers) {
        worker_free(base, w);
        *worker = NULL;
        return hdr_fail(err, HDR_INTERNAL, "out of memory");
    }
    float *at = w->numbers;
    for (size_t c = 0; c < channels; c++, at += 2 * read)
        w->colour[c] = at, w->deviation[c] = at + read;
    for (size_t c = 0; c < channels; c++, at += block)
        w->out[c] = at;
    w->alpha = at;
    return HDR_OK;
}

/* ---- A block ---- */

/* What rows are read into. */
typedef struct taking {
    const smooth_source *source;
    smooth_worker *worker;
    int first;                    /* the first row that is read */
    int wanted_first, wanted_end; /* the block's */
    uint64_t unusable;            /* in the block */
    uint64_t negative;
} taking;

static void take_colour(taking *t, int channel, int row, size_t x, const double *values, size_t count) {
    size_t width = width_of(t->source);
    float *to = NULL;
    if (channel == 3 && row >= t->wanted_first && row < t->wanted_end)
        to = t->worker->alpha + (size_t)(row - t->wanted_first) * width;
    if (channel < 3) to = t->worker->colour[t->source->place[channel]] + (size_t)(row - t->first) * width;
    for (size_t i = 0; to && i < count; i++)
        to[x + i] = (float)values[i]; /* they were float, or half: nothing is lost */
}

static void take_deviation(taking *t, int channel, int row, size_t x, const double *values, size_t count) {
    float *to = t->worker->deviation[t->source->place[channel]] + (size_t)(row - t->first) * width_of(t->source);
    bool counts = row >= t->wanted_first && row < t->wanted_end;
    for (size_t i = 0; i < count; i++) {
        bool finite = values[i] - values[i] == 0;
        t->unusable += counts && !finite;
        t->negative += counts && finite && values[i] < 0;
        to[x + i] = finite ? (float)values[i] : 0;
    }
}

/* What is done with a strip of numbers of a channel. */
typedef void (*taker)(taking *t, int channel, int row, size_t x, const double *values, size_t count);

/* Gives away all rows up to `end` of the first channels of a picture. The reader lives no longer than that: large
 * chunks are held for one block alone. */
static hdr_status read_rows(taking *t, hdr_source *from, int channels, int end, taker take, hdr_error *err) {
    size_t width = width_of(t->source);
    double values[HDR_STRIP];
    hdr_reader reader;
    hdr_status status = hdr_reader_open(&reader, from, 0, 0, err);
    for (int row = t->first; row < end && status == HDR_OK; row++) {
        status = hdr_reader_seek(&reader, row, err);
        for (int c = 0; c < channels && status == HDR_OK; c++)
            for (size_t x = 0; x < width && from->picture.present[c]; x += HDR_STRIP) {
                size_t count = width - x < HDR_STRIP ? width - x : HDR_STRIP;
                (void)hdr_block_load(&reader.block, c, row - reader.block.first_row, x, values, count);
                take(t, c, row, x, values, count);
            }
    }
    hdr_reader_close(&reader);
    return status;
}

/* What is not finite in the picture itself is repaired and told as in any. */
static hdr_status read_numbers(taking *t, int end, hdr_error *err) {
    const smooth_source *source = t->source;
    hdr_status status = read_rows(t, source->picture, 4, end, take_colour, err);
    if (status == HDR_OK) status = read_rows(t, source->guide, 3, end, take_deviation, err);
    if (status != HDR_OK || t->negative == 0) return status;
    return hdr_fail(err, HDR_BAD_DATA,
                    "%s: it holds negative numbers, and no standard deviation is one: hdr mean --show mean-deviation "
                    "makes the picture that is meant",
                    source->guide_name);
}

static void lay_out(const smooth_source *source, const smooth_worker *w, hdr_block *out) {
    for (int c = 0; c < 4; c++) {
        if (!source->picture->picture.present[c]) continue;
        out->plane[c] = (const unsigned char *)(c < 3 ? w->out[source->place[c]] : w->alpha);
        out->type[c] = HDR_FLOAT;
        out->stride[c] = width_of(source) * sizeof(float);
    }
}

static hdr_status read_block(hdr_source *base, void *worker, int index, hdr_block *out, hdr_error *err) {
    smooth_source *source = (smooth_source *)base;
    smooth_worker *w = worker;
    int height = (int)hdr_window_height(&base->picture.data), reach = hdr_nlmeans_reach(&source->filter);
    int first = hdr_source_first_row(base, index), end = hdr_source_first_row(base, index + 1);
    hdr_nlmeans_rows rows = {.channels = source->channels,
                             .width = (int)width_of(source),
                             .height = height,
                             .first = first < reach ? 0 : first - reach,
                             .end = height - end < reach ? height : end + reach,
                             .wanted_first = first,
                             .wanted_end = end};
    taking t = {.source = source, .worker = w, .first = rows.first, .wanted_first = first, .wanted_end = end};
    hdr_status status = read_numbers(&t, rows.end, err);
    if (status != HDR_OK) return status;
    for (int c = 0; c < source->channels; c++) {
        rows.colour[c] = w->colour[c];
        rows.deviation[c] = w->deviation[c];
        rows.out[c] = w->out[c];
    }
    uint64_t left_alone = hdr_nlmeans_filter(&source->filter, &rows, w->room);
    *out = (hdr_block){.first_row = first, .rows = end - first};
    lay_out(source, w, out);
    if (atomic_exchange(&source->seen[index], 1)) return HDR_OK;
    atomic_fetch_add(&source->pixels, (uint64_t)(end - first) * width_of(source));
    atomic_fetch_add(&source->left_alone, left_alone);
    atomic_fetch_add(&source->unusable, t.unusable);
    return HDR_OK;
}

hdr_smoothed hdr_smooth_counts(const hdr_source *base) {
    const smooth_source *source = (const smooth_source *)base;
    return (hdr_smoothed){atomic_load(&source->pixels), atomic_load(&source->left_alone),
                          atomic_load(&source->unusable)};
}

/* ---- Opening ---- */

static void close_source(hdr_source *base) {
    smooth_source *source = (smooth_source *)base;
    hdr_source_close(source->picture);
    hdr_source_close(source->guide);
    free(source->seen);
    free(source);
}

/* The result's own form. */
static hdr_status describe(smooth_source *source, hdr_error *err) {
    const hdr_source *picture = source->picture;
    hdr_source *base = &source->base;
    base->picture = picture->picture;
    for (int c = 0; c < 4; c++) {
        if (picture->picture.present[c] && picture->picture.channels[c].type == HDR_UINT)
            return hdr_fail(err, HDR_BAD_DATA,
                            "the channel %s holds whole numbers, such as names of objects: their "
                            "mean tells nothing",
                            picture->picture.channels[c].name);
        base->picture.channels[c].type = HDR_FLOAT;
        if (c == 3) continue;
        source->place[c] = source->channels;
        source->channels += picture->picture.present[c];
    }
    int chunk = picture->block_rows < MOST_ROWS ? picture->block_rows : MOST_ROWS;
    base->block_rows = (chunk + HDR_NLMEANS_ROWS - 1) / HDR_NLMEANS_ROWS * HDR_NLMEANS_ROWS;
    base->end = picture->end;
    int64_t height = hdr_window_height(&base->picture.data);
    if (height > 0 && hdr_window_width(&base->picture.data) > 0)
        base->blocks = hdr_source_block_of(base, (int)(height - 1)) + 1;
    source->seen = hdr_alloc((size_t)base->blocks, sizeof *source->seen);
    return source->seen ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
}

/* The files must be two: a picture is not its own noise. */
static hdr_status check_files(hdr_input *input, hdr_input *guide, hdr_error *err) {
    const hdr_joined *joined = hdr_input_get_joined(input);
    bool same = hdr_input_same_file(input, guide);
    for (int i = 0; joined && i < joined->count; i++)
        same |= hdr_input_same_file(joined->members[i], guide);
    if (!same) return HDR_OK;
    return hdr_fail(err, HDR_USAGE,
                    "%s is the picture itself: what is needed is a picture of its standard deviation, such as hdr mean "
                    "--show mean-deviation makes",
                    hdr_input_name(guide));
}

hdr_source *hdr_smooth_open(hdr_source *picture, hdr_input *input, hdr_input *guide, const hdr_reading *reading,
                            const hdr_nlmeans *filter, hdr_error *err) {
    smooth_source *source = hdr_alloc(1, sizeof *source);
    if (!source) {
        hdr_source_close(picture);
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        return NULL;
    }
    source->picture = picture;
    source->filter = *filter;
    source->guide_name = hdr_input_name(guide);
    source->base.worker_new = worker_new;
    source->base.worker_free = worker_free;
    source->base.read = read_block;
    source->base.close = close_source;
    hdr_status status = check_files(input, guide, err);
    if (status == HDR_OK) source->guide = hdr_source_open(guide, reading, err);
    if (source->guide &&
        hdr_compare_forms(guide, &source->guide->picture, input, &picture->picture, false, err) == HDR_OK &&
        describe(source, err) == HDR_OK)
        return &source->base;
    close_source(&source->base);
    return NULL;
}

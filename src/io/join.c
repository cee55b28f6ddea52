#include "io/join.h"

#include "io/forms.h"
#include "io/input.h"
#include "io/reader.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* Of tiles so many columns together have a state: it does not grow with the width of rows of them. */
enum { COLUMNS = 1024 };

typedef struct join_source {
    hdr_source base;
    hdr_joining joining;
    hdr_source **members;
    size_t width, columns, strips; /* columns: that have a state together; strips: in which they come */
    int channels, channel[4];      /* that are joined */
    atomic_uchar *seen;            /* of each block: whether it was read before */
    _Atomic uint64_t left_out;
} join_source;

/* What a thread makes a block in. */
typedef struct join_worker {
    double *state; /* of each row, channel and strip in turn */
    float *out;    /* channel after channel */
    uint64_t left_out;
} join_worker;

/* Numbers of doubles: of a strip's state, and of a row's. */
static size_t strip_state(const join_source *source) {
    return (size_t)source->joining.slots * HDR_STRIP;
}

static size_t row_state(const join_source *source) {
    return (size_t)source->channels * source->strips * strip_state(source);
}

static size_t most_rows(const join_source *source) {
    int64_t height = hdr_window_height(&source->base.picture.data);
    return (size_t)(height < source->base.block_rows ? height : source->base.block_rows);
}

static void worker_free(hdr_source *source, void *worker) {
    join_worker *w = worker;
    (void)source;
    if (!w) return;
    free(w->state);
    free(w->out);
    free(w);
}

static hdr_status worker_new(hdr_source *base, void **worker, hdr_error *err) {
    const join_source *source = (join_source *)base;
    join_worker *w = hdr_alloc(1, sizeof *w);
    if (w) {
        w->state = hdr_alloc(most_rows(source), row_state(source) * sizeof *w->state);
        w->out = hdr_alloc(most_rows(source), (size_t)source->channels * source->width * sizeof *w->out);
    }
    *worker = w;
    if (w && w->state && w->out) return HDR_OK;
    worker_free(base, w);
    *worker = NULL;
    return hdr_fail(err, HDR_INTERNAL, "out of memory");
}

/* ---- A block ---- */

/* Columns of a block, strip by strip. */
typedef struct piece {
    int first, end; /* rows */
    size_t left, right;
} piece;

static size_t strip_width(const piece *piece, size_t x) {
    return piece->right - x < HDR_STRIP ? piece->right - x : HDR_STRIP;
}

/* The reader lives no longer than that, since there may be hundreds of pictures. */
static hdr_status add_picture(const join_source *source, join_worker *w, int picture, const piece *piece,
                              hdr_error *err) {
    const hdr_joining *joining = &source->joining;
    double values[HDR_STRIP], *state = w->state;
    hdr_reader reader;
    hdr_status status =
        hdr_reader_open(&reader, source->members[picture], (int64_t)piece->left, (int64_t)piece->right, err);
    for (int row = piece->first; row < piece->end && status == HDR_OK; row++) {
        status = hdr_reader_seek(&reader, row, err);
        for (int c = 0; c < source->channels && status == HDR_OK; c++)
            for (size_t x = piece->left; x < piece->right; x += HDR_STRIP, state += strip_state(source)) {
                size_t count = strip_width(piece, x);
                w->left_out +=
                    hdr_block_load(&reader.block, source->channel[c], row - reader.block.first_row, x, values, count);
                joining->add(joining, picture, values, state, count);
            }
    }
    hdr_reader_close(&reader);
    return status;
}

static void end_piece(const join_source *source, const join_worker *w, const piece *piece) {
    size_t plane = (size_t)(piece->end - piece->first) * source->width;
    const double *state = w->state;
    double values[HDR_STRIP];
    for (size_t row = 0; row < (size_t)(piece->end - piece->first); row++)
        for (int c = 0; c < source->channels; c++)
            for (size_t x = piece->left; x < piece->right; x += HDR_STRIP, state += strip_state(source)) {
                size_t count = strip_width(piece, x);
                float *to = w->out + (size_t)c * plane + row * source->width + x;
                source->joining.end(&source->joining, state, values, count);
                hdr_real_to_float(values, to, count);
                for (size_t i = 0; i < count; i++)
                    if (isnan(values[i])) to[i] = NAN; /* which that holds at the largest float */
            }
}

static hdr_status read_block(hdr_source *base, void *worker, int index, hdr_block *out, hdr_error *err) {
    join_source *source = (join_source *)base;
    join_worker *w = worker;
    piece piece = {hdr_source_first_row(base, index), hdr_source_first_row(base, index + 1), 0, 0};
    size_t rows = (size_t)(piece.end - piece.first);
    w->left_out = 0;
    for (; piece.left < source->width; piece.left = piece.right) {
        piece.right = source->width - piece.left < source->columns ? source->width : piece.left + source->columns;
        memset(w->state, 0, rows * row_state(source) * sizeof *w->state);
        hdr_status status = HDR_OK;
        for (int picture = 0; picture < source->joining.pictures && status == HDR_OK; picture++)
            status = add_picture(source, w, picture, &piece, err);
        if (status != HDR_OK) return status;
        end_piece(source, w, &piece);
    }
    *out = (hdr_block){.first_row = piece.first, .rows = (int)rows};
    for (int c = 0; c < source->channels; c++) {
        out->plane[source->channel[c]] = (const unsigned char *)(w->out + (size_t)c * rows * source->width);
        out->type[source->channel[c]] = HDR_FLOAT;
        out->stride[source->channel[c]] = source->width * sizeof *w->out;
    }
    if (!atomic_exchange(&source->seen[index], 1)) atomic_fetch_add(&source->left_out, w->left_out);
    return HDR_OK;
}

uint64_t hdr_join_left_out(const hdr_source *source) {
    return atomic_load(&((const join_source *)source)->left_out);
}

/* ---- Opening ---- */

static void close_source(hdr_source *base) {
    join_source *source = (join_source *)base;
    hdr_close_alike(source->joining.pictures, source->members);
    free(source->seen);
    free(source->joining.weights);
    free(source);
}

/* What has a state together: whole tiles, where all members have them of one width; else whole rows. */
static void divide(join_source *source) {
    size_t tile = (size_t)source->members[0]->tile_columns;
    for (int i = 1; i < source->joining.pictures; i++)
        if ((size_t)source->members[i]->tile_columns != tile) tile = 0;
    source->width = (size_t)hdr_window_width(&source->base.picture.data);
    source->columns = tile ? (COLUMNS + tile - 1) / tile * tile : source->width;
    if (source->columns > source->width) source->columns = source->width;
    source->strips = (source->columns + HDR_STRIP - 1) / HDR_STRIP;
    for (int c = 0; c < 4; c++)
        if (source->base.picture.present[c]) source->channel[source->channels++] = c;
}

/* The result's own form. */
static void describe(join_source *source) {
    const hdr_source *first = source->members[0];
    hdr_source *base = &source->base;
    base->picture = first->picture;
    if (!source->joining.alpha) base->picture.has_alpha = base->picture.present[3] = false;
    for (int c = 0; c < 4; c++)
        base->picture.channels[c].type = HDR_FLOAT;
    base->block_rows = first->block_rows;
    base->rows_cut = first->rows_cut;
    for (int i = 1; i < source->joining.pictures; i++)
        if (source->members[i]->block_rows > base->block_rows) {
            base->block_rows = source->members[i]->block_rows;
            base->rows_cut = source->members[i]->rows_cut;
        }
    int64_t height = hdr_window_height(&base->picture.data);
    base->blocks =
        height > 0 && hdr_window_width(&base->picture.data) > 0 ? hdr_source_block_of(base, (int)(height - 1)) + 1 : 0;
}

/* Weights that the pictures' own headers tell. */
static hdr_status find_weights(join_source *source, const hdr_joined *joined, hdr_error *err) {
    hdr_joining *joining = &source->joining;
    if (!joining->weights_from) return HDR_OK;
    joining->weights = hdr_alloc((size_t)joining->pictures, sizeof *joining->weights);
    if (!joining->weights) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (int i = 0; i < joining->pictures; i++) {
        double *weight = &joining->weights[i];
        hdr_status status =
            hdr_source_number(joined->members[i], &source->members[i]->picture, joining->weights_from, weight, err);
        if (status != HDR_OK) return status;
        if (!(*weight > 0 && *weight <= HDR_MOST_WEIGHT))
            return hdr_fail(err, HDR_BAD_DATA, "%s: its attribute '%.200s' is no number above 0, up to %g",
                            hdr_input_name(joined->members[i]), joining->weights_from, HDR_MOST_WEIGHT);
    }
    return HDR_OK;
}

hdr_status hdr_join_attributes(const hdr_source *base, hdr_bytes *attributes, hdr_error *err) {
    const hdr_joining *joining = &((const join_source *)base)->joining;
    double sum = 0;
    for (int i = 0; joining->weights_from && i < joining->pictures; i++)
        sum += joining->weights[i];
    return joining->weights_from ? hdr_exr_set_number(attributes, joining->weights_from, sum, err) : HDR_OK;
}

const char *hdr_join_meaning(const hdr_source *source) {
    return ((const join_source *)source)->joining.meaning;
}

hdr_source *hdr_join_open(hdr_input *input, const hdr_reading *reading, const hdr_joining *joining, hdr_error *err) {
    join_source *source = hdr_alloc(1, sizeof *source);
    if (!source) {
        free(joining->weights);
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        return NULL;
    }
    source->joining = *joining;
    source->base.worker_new = worker_new;
    source->base.worker_free = worker_free;
    source->base.read = read_block;
    source->base.close = close_source;
    const hdr_joined *joined = hdr_input_get_joined(input);
    source->members = hdr_open_alike(joined->count, joined->members, reading, joining->alpha, err);
    if (source->members) {
        describe(source);
        divide(source);
        source->seen = hdr_alloc((size_t)source->base.blocks, sizeof *source->seen);
        if (!source->seen) hdr_fail(err, HDR_INTERNAL, "out of memory");
        if (source->seen && find_weights(source, joined, err) == HDR_OK) return &source->base;
    }
    close_source(&source->base);
    return NULL;
}

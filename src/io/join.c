#include "io/join.h"

#include "io/input.h"
#include "io/forms.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

typedef struct join_source {
    hdr_source base;
    hdr_joining joining;
    hdr_source **members;
    atomic_uchar *seen; /* of each block: whether it was read before */
    _Atomic uint64_t left_out;
} join_source;

/* What a thread makes a block in. */
typedef struct join_worker {
    double *state; /* of each channel, row and strip in turn */
    float *out;    /* channel after channel */
    uint64_t left_out;
} join_worker;

static size_t width_of(const join_source *source) {
    return (size_t)hdr_window_width(&source->base.picture.data);
}

static size_t strips_of(const join_source *source) {
    return (width_of(source) + HDR_STRIP - 1) / HDR_STRIP;
}

/* Of the channels that are joined. */
static size_t channels_of(const join_source *source) {
    size_t count = 0;
    for (int c = 0; c < 4; c++)
        count += source->base.picture.present[c];
    return count;
}

/* A channel's place among them. */
static size_t place_of(const join_source *source, int channel) {
    size_t place = 0;
    for (int c = 0; c < channel; c++)
        place += source->base.picture.present[c];
    return place;
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
    size_t rows = channels_of(source) * (size_t)base->block_rows;
    size_t state = strips_of(source) * HDR_STRIP * (size_t)source->joining.slots;
    join_worker *w = hdr_alloc(1, sizeof *w);
    if (w) {
        w->state = hdr_alloc(rows, state * sizeof *w->state);
        w->out = hdr_alloc(rows, width_of(source) * sizeof *w->out);
    }
    *worker = w;
    if (w && w->state && w->out) return HDR_OK;
    worker_free(base, w);
    *worker = NULL;
    return hdr_fail(err, HDR_INTERNAL, "out of memory");
}

/* ---- A block ---- */

static double *state_of(const join_source *source, const join_worker *w, int channel, int row, size_t strip) {
    size_t at = (place_of(source, channel) * (size_t)source->base.block_rows + (size_t)row) * strips_of(source) + strip;
    return w->state + at * HDR_STRIP * (size_t)source->joining.slots;
}

/* What numbers of one picture are added to. */
typedef struct adding {
    const join_source *source;
    join_worker *worker;
    int picture, first;
} adding;

static void add_numbers(void *context, int channel, int row, size_t x, const double *values, size_t count) {
    const adding *a = context;
    const hdr_joining *joining = &a->source->joining;
    if (!a->source->base.picture.present[channel]) return;
    joining->add(joining, a->picture, values, state_of(a->source, a->worker, channel, row - a->first, x / HDR_STRIP),
                 count);
}

static void end_block(const join_source *source, const join_worker *w, int rows, hdr_block *out) {
    size_t width = width_of(source);
    float *to = w->out;
    double values[HDR_STRIP];
    for (int c = 0; c < 4; c++) {
        if (!source->base.picture.present[c]) continue;
        out->plane[c] = (const unsigned char *)to;
        out->type[c] = HDR_FLOAT;
        out->stride[c] = width * sizeof *to;
        for (int row = 0; row < rows; row++, to += width)
            for (size_t x = 0; x < width; x += HDR_STRIP) {
                size_t count = width - x < HDR_STRIP ? width - x : HDR_STRIP;
                source->joining.end(&source->joining, state_of(source, w, c, row, x / HDR_STRIP), values, count);
                hdr_real_to_float(values, to + x, count);
                for (size_t i = 0; i < count; i++)
                    if (isnan(values[i])) to[x + i] = NAN; /* which that holds at the largest float */
            }
    }
}

static hdr_status read_block(hdr_source *base, void *worker, int index, hdr_block *out, hdr_error *err) {
    join_source *source = (join_source *)base;
    join_worker *w = worker;
    int first = hdr_source_first_row(base, index), end = hdr_source_first_row(base, index + 1);
    *out = (hdr_block){.first_row = first, .rows = end - first};
    w->left_out = 0;
    memset(w->state, 0,
           channels_of(source) * (size_t)base->block_rows * strips_of(source) * HDR_STRIP *
               (size_t)source->joining.slots * sizeof *w->state);
    hdr_status status = HDR_OK;
    for (int picture = 0; picture < source->joining.pictures && status == HDR_OK; picture++)
        status = hdr_source_visit(source->members[picture], source->joining.alpha ? 4 : 3, first, end, add_numbers,
                                  &(adding){source, w, picture, first}, &w->left_out, err);
    if (status != HDR_OK) return status;
    end_block(source, w, end - first, out);
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
        source->seen = hdr_alloc((size_t)source->base.blocks, sizeof *source->seen);
        if (source->seen) return &source->base;
        hdr_fail(err, HDR_INTERNAL, "out of memory");
    }
    close_source(&source->base);
    return NULL;
}

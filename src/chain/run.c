#include "chain/run.h"

#include "io/join.h"
#include "io/reader.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { KEPT_EMPTY, KEPT_FILLING, KEPT_WHOLE };
enum { KEPT_ALIGNED = 8, KEPT_SLACK = 5 * KEPT_ALIGNED /* a block's: of its beginning, and of each plane's end */ };

/* ---- Opening and closing ---- */

static hdr_status open_threads(hdr_run *run, hdr_error *err) {
    run->threads = hdr_alloc((size_t)run->thread_count, sizeof *run->threads);
    if (!run->threads) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (int t = 0; t < run->thread_count; t++) {
        run->threads[t].strip = aligned_alloc(64, (sizeof(hdr_strip) + 63) / 64 * 64);
        if (!run->threads[t].strip) return hdr_fail(err, HDR_INTERNAL, "out of memory");
        run->threads[t].strip->failed = false;
        hdr_status status = run->source->worker_new(run->source, &run->threads[t].worker, err);
        if (status) return status;
    }
    return HDR_OK;
}

/* The input's picture, or what the chain's first verb makes of its pictures. */
static hdr_source *open_source(const hdr_chain *chain, hdr_input *input, hdr_error *err) {
    hdr_reading reading = hdr_chain_reading(chain);
    const hdr_joined *joined = hdr_input_get_joined(input);
    if (!hdr_chain_joins(chain)) return hdr_source_open(input, &reading, err);
    if (!joined) {
        hdr_fail(err, HDR_USAGE, "%s makes one picture of several, which have to be joined",
                 chain->clauses[0].verb->about.name);
        return NULL;
    }
    const hdr_clause *first = &chain->clauses[0];
    hdr_joining joining = {.params = first->params, .pictures = joined->count};
    if (!first->verb->join(first->params, &joining, err)) return hdr_join_open(input, &reading, &joining, err);
    free(joining.weights);
    hdr_fail_in(err, first->verb->about.name);
    return NULL;
}

/* As many as can be of use: to decode blocks, and to compute what is around a picture's pixels, by rows. */
static int useful_threads(const hdr_run *run) {
    enum { ROWS = 16 };
    int64_t pieces = run->source->blocks, rows = hdr_window_height(&run->source->picture.data);
    for (int i = 0; i < run->chain->count; i++)
        if (run->chain->clauses[i].verb->surround && rows / ROWS > pieces) pieces = rows / ROWS;
    return run->settings.threads < pieces ? run->settings.threads : pieces > 1 ? (int)pieces : 1;
}

hdr_status hdr_run_open(hdr_run *run, const hdr_chain *chain, hdr_input *input, hdr_input *guide,
                        const hdr_listener *listener, hdr_error *err) {
    *run = (hdr_run){.chain = chain, .settings = *hdr_chain_settings(chain), .listener = listener};
    run->input = input;
    run->name = hdr_input_name(input);
    run->source = open_source(chain, input, err);
    if (hdr_chain_joins(chain)) run->joined = run->source;
    run->source = hdr_run_guide(run, run->source, guide, err);
    if (!run->source) return err->status;
    run->thread_count = useful_threads(run);
    run->pool = hdr_pool_new(run->thread_count, err);
    if (!run->pool) return err->status;
    hdr_status status = hdr_run_choose_alpha(run, err);
    if (status) return status;
    const hdr_picture *picture = &run->source->picture;
    run->raw.grey = picture->planes == 1;
    run->raw.opaque = !picture->has_alpha;
    for (int c = 0; c < 4; c++)
        if (picture->present[c])
            run->kept_row += hdr_type_size(picture->channels[c].type) * (size_t)hdr_window_width(&picture->data);
    hdr_say(listener, HDR_DETAIL, "%s: %lld x %lld, %s, %s; threads: %d; kernels: %s; memory: %.0f MB", run->name,
            (long long)hdr_window_width(&picture->data), (long long)hdr_window_height(&picture->data), picture->storage,
            picture->compression, run->thread_count, hdr_cpu_name(hdr_cpu()), (double)run->settings.memory * 1e-6);
    return open_threads(run, err);
}

void hdr_run_close(hdr_run *run) {
    hdr_pool_free(run->pool);
    for (int t = 0; run->threads && t < run->thread_count; t++) {
        if (run->threads[t].worker) run->source->worker_free(run->source, run->threads[t].worker);
        free(run->threads[t].strip);
    }
    free(run->threads);
    if (run->kept) hdr_free_pages(run->kept, run->kept_size);
    free(run->looked_at);
    free(run->kept_state);
    for (int i = 0; i < run->surround_count; i++)
        hdr_plane_free(run->surrounds[i]);
    free(run->surrounds);
    free(run->steps);
    hdr_source_close(run->source);
}

/* ---- Blocks ---- */

static uint64_t aligned(uint64_t size) {
    return (size + KEPT_ALIGNED - 1) / KEPT_ALIGNED * KEPT_ALIGNED;
}

/* Where a block begins among those that are kept. */
static uint64_t kept_place(const hdr_run *run, int block) {
    uint64_t rows = (uint64_t)hdr_source_first_row(run->source, block);
    return aligned(rows * run->kept_row) + (uint64_t)block * KEPT_SLACK;
}

void hdr_run_keep(hdr_run *run) {
    uint64_t size = kept_place(run, run->source->blocks);
    if (run->kept || size > run->settings.memory / 2 || size > SIZE_MAX) return;
    run->kept_state = hdr_alloc((size_t)run->source->blocks, sizeof *run->kept_state);
    run->kept = run->kept_state ? hdr_alloc_pages((size_t)size) : NULL;
    run->kept_size = (size_t)size;
    /* without the memory the blocks are decoded again: no fault */
}

/* A block whose channels lie one after the other from `at` on, each in whole rows and aligned to any type. */
static void lay_out_block(const hdr_run *run, int block, unsigned char *at, hdr_block *out) {
    const hdr_picture *picture = &run->source->picture;
    int first = hdr_source_first_row(run->source, block);
    *out = (hdr_block){.first_row = first, .rows = hdr_source_first_row(run->source, block + 1) - first};
    for (int c = 0; c < 4; c++) {
        if (!picture->present[c]) continue;
        out->type[c] = picture->channels[c].type;
        out->stride[c] = hdr_type_size(out->type[c]) * (size_t)hdr_window_width(&picture->data);
        out->plane[c] = at;
        at += aligned(out->stride[c] * (size_t)out->rows);
    }
}

static void copy_block(const hdr_block *from, const hdr_block *to) {
    for (int c = 0; c < 4; c++)
        for (int row = 0; to->plane[c] && row < to->rows; row++)
            memcpy((unsigned char *)to->plane[c] + (size_t)row * to->stride[c],
                   from->plane[c] + (size_t)row * from->stride[c], to->stride[c]);
}

hdr_status hdr_run_read(hdr_run *run, int thread, int block, hdr_block *out, hdr_error *err) {
    if (run->kept && atomic_load_explicit(&run->kept_state[block], memory_order_acquire) == KEPT_WHOLE) {
        lay_out_block(run, block, run->kept + kept_place(run, block), out);
        return HDR_OK;
    }
    if (run->looked_at && block == run->looked_at_block) {
        lay_out_block(run, block, run->looked_at, out);
        return HDR_OK;
    }
    hdr_status status = run->source->read(run->source, run->threads[thread].worker, block, out, err);
    if (!run->source->picture.present[3]) out->plane[3] = NULL; /* what is dropped is not looked at */
    if (status || !run->kept) return status;
    unsigned char empty = KEPT_EMPTY;
    if (!atomic_compare_exchange_strong(&run->kept_state[block], &empty, KEPT_FILLING)) return HDR_OK;
    hdr_block kept;
    lay_out_block(run, block, run->kept + kept_place(run, block), &kept);
    copy_block(out, &kept);
    atomic_store_explicit(&run->kept_state[block], KEPT_WHOLE, memory_order_release);
    *out = kept; /* warm, and valid beyond the worker's next read */
    return HDR_OK;
}

/* ---- Pixels ---- */

/* NaN -> 0, -Inf -> 0, +Inf -> the channel's largest finite value. */
static bool repair(hdr_run *run, hdr_watch *watch, int channel, double *value) {
    if (isfinite(*value)) return true;
    if (isnan(*value)) {
        watch->nan++;
        *value = 0;
    } else if (*value < 0) {
        watch->negative_infinity++;
        *value = 0;
    } else {
        watch->positive_infinity++;
        watch->infinity = true;
        *value = run->raw.replacement[channel];
        return run->raw.replacements_known;
    }
    return true;
}

/* One channel's pixels in double. False: an infinity for which no replacement is known. */
static bool load_plane(hdr_run *run, hdr_watch *watch, const hdr_block *block, int channel, int row, int x,
                       size_t count, double *out) {
    if (!block->plane[channel]) {
        memset(out, 0, count * sizeof *out);
        return true;
    }
    if (hdr_block_load(block, channel, row, (size_t)x, out, count) == 0) return true;
    bool known = true;
    for (size_t i = 0; i < count; i++)
        known &= repair(run, watch, channel, &out[i]);
    return known;
}

static bool all_one(const double *values, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (values[i] != 1) return false;
    return true;
}

/* True where two channels hold the same bits, so that they are the same after repair too. */
static bool same_bits(const hdr_block *block, int a, int b, int row, int x, size_t count) {
    if (!block->plane[a] || !block->plane[b] || block->type[a] != block->type[b]) return false;
    size_t size = hdr_type_size(block->type[a]);
    return !memcmp(block->plane[a] + (size_t)row * block->stride[a] + (size_t)x * size,
                   block->plane[b] + (size_t)row * block->stride[b] + (size_t)x * size, count * size);
}

bool hdr_run_load(hdr_run *run, int thread, const hdr_block *block, int row, int x, size_t count, bool reduce,
                  bool alpha) {
    hdr_strip *strip = run->threads[thread].strip;
    hdr_watch *watch = &run->threads[thread].watch;
    int planes = run->source->picture.planes;
    bool known = true, colour = false;
    strip->count = count;
    strip->row = block->first_row + row;
    strip->x = x;
    strip->place_x = run->source->picture.data.min_x + x;
    strip->place_y = run->source->picture.data.min_y + strip->row;
    /* G and B need not be converted where they repeat R; but repairs are counted in all channels */
    bool plain_grey = planes == 3 && run->raw.grey && reduce && same_bits(block, 0, 1, row, x, count) &&
                      same_bits(block, 0, 2, row, x, count);
    uint64_t nan = watch->nan, positive = watch->positive_infinity, negative = watch->negative_infinity;
    for (int p = 0; p < (plain_grey || run->spread ? 1 : planes); p++)
        known &= load_plane(run, watch, block, p, row, x, count, strip->c[p]);
    for (int p = 1; run->spread && p < planes; p++)
        memcpy(strip->c[p], strip->c[0], count * sizeof(double));
    if (plain_grey) {
        watch->nan += 2 * (watch->nan - nan);
        watch->positive_infinity += 2 * (watch->positive_infinity - positive);
        watch->negative_infinity += 2 * (watch->negative_infinity - negative);
    } else if (planes == 3 && known && (run->raw.grey || !watch->colour)) {
        colour = memcmp(strip->c[0], strip->c[1], count * sizeof(double)) != 0 ||
                 memcmp(strip->c[0], strip->c[2], count * sizeof(double)) != 0;
        watch->colour |= colour;
    }
    strip->planes = planes == 3 && run->raw.grey && reduce ? 1 : planes;
    bool translucent = false;
    if (run->over && block->plane[3]) {
        known &= load_plane(run, watch, block, 3, row, x, count, strip->alpha);
        for (int p = 0; p < strip->planes; p++)
            hdr_lay_over(strip->c[p], strip->alpha, run->over[p], count);
    }
    if (run->source->picture.has_alpha && (alpha || !run->raw.opaque || !run->raw.certain)) {
        known &= load_plane(run, watch, block, 3, row, x, count, strip->alpha);
        translucent = !all_one(strip->alpha, count);
        watch->translucent |= translucent;
        if (translucent)
            for (int p = 0; p < strip->planes; p++)
                hdr_unassociate(strip->c[p], strip->alpha, count);
    }
    bool contradicted = !known || (colour && run->raw.grey) || (translucent && run->raw.opaque);
    if (contradicted) hdr_pool_stop(run->pool);
    return !contradicted;
}

/* ---- Sweeps ---- */

/* A value as it is stored, finite or not. */
static double stored_value(hdr_type type, const unsigned char *row, int64_t x) {
    if (type == HDR_HALF) return hdr_half_value(((const uint16_t *)(const void *)row)[x]);
    if (type == HDR_UINT) return ((const uint32_t *)(const void *)row)[x];
    return (double)((const float *)(const void *)row)[x];
}

/* The sweep that finds what +Inf becomes. */
static hdr_status find_largest(void *context, int block, int thread, hdr_error *err) {
    hdr_run *run = context;
    hdr_block in;
    hdr_status status = hdr_run_read(run, thread, block, &in, err);
    if (status) return status;
    int64_t width = hdr_window_width(&run->source->picture.data);
    for (int c = 0; c < 4; c++)
        for (int row = 0; in.plane[c] && in.type[c] != HDR_UINT && row < in.rows; row++) {
            const unsigned char *at = in.plane[c] + (size_t)row * in.stride[c];
            for (int64_t x = 0; x < width; x++) {
                double value = stored_value(in.type[c], at, x);
                if (isfinite(value)) run->threads[thread].largest[c] = fmax(run->threads[thread].largest[c], value);
            }
        }
    return HDR_OK;
}

static hdr_status find_replacements(hdr_run *run, hdr_error *err) {
    for (int t = 0; t < run->thread_count; t++)
        memset(run->threads[t].largest, 0, sizeof run->threads[t].largest);
    hdr_status status = hdr_pool_run(run->pool, run->source->blocks, find_largest, run, err);
    if (status) return status;
    for (int t = 0; t < run->thread_count; t++)
        for (int c = 0; c < 4; c++)
            run->raw.replacement[c] = fmax(run->raw.replacement[c], run->threads[t].largest[c]);
    run->raw.replacements_known = true;
    run->sweeps++;
    hdr_say(run->listener, HDR_EXPLAIN, "sweep %d: the largest finite value of each channel, for the infinities",
            run->sweeps);
    return HDR_OK;
}

static hdr_watch merge_watches(const hdr_run *run) {
    hdr_watch all = {0};
    for (int t = 0; t < run->thread_count; t++) {
        const hdr_watch *watch = &run->threads[t].watch;
        all.colour |= watch->colour;
        all.translucent |= watch->translucent;
        all.infinity |= watch->infinity;
        all.nan += watch->nan;
        all.positive_infinity += watch->positive_infinity;
        all.negative_infinity += watch->negative_infinity;
    }
    return all;
}

static void count_of(char *text, size_t size, uint64_t count, const char *what) {
    size_t used = strlen(text);
    if (count) snprintf(text + used, size - used, "%s%llu %s", used ? ", " : "", (unsigned long long)count, what);
}

/* The components that are no finite numbers, said once. */
static hdr_status report_repairs(const hdr_run *run, hdr_error *err) {
    const hdr_raw *raw = &run->raw;
    bool strict = run->settings.strict;
    uint64_t left_out = run->joined ? hdr_join_left_out(run->joined) : 0;
    if (left_out && strict)
        return hdr_fail(err, HDR_BAD_DATA, "%llu components are NaN or infinite", (unsigned long long)left_out);
    if (left_out)
        hdr_say(run->listener, HDR_NOTE, "%s: components that are NaN or infinite: %llu", run->name,
                (unsigned long long)left_out);
    char text[300] = "";
    count_of(text, sizeof text, raw->nan, strict ? "NaN" : "NaN (now 0)");
    count_of(text, sizeof text, raw->negative_infinity, strict ? "-Inf" : "-Inf (now 0)");
    count_of(text, sizeof text, raw->positive_infinity,
             strict ? "+Inf" : "+Inf (now the channel's largest finite value)");
    if (!text[0]) return HDR_OK;
    if (strict) return hdr_fail(err, HDR_BAD_DATA, "components that are no finite numbers: %s", text);
    hdr_say(run->listener, HDR_NOTE, "%s: repaired components: %s", run->name, text);
    return HDR_OK;
}

/* Takes what a sweep has met for what the picture is. True: that is not what was assumed, and matters. */
static bool learn(hdr_run *run, const hdr_sweep *sweep, const hdr_watch *met) {
    hdr_raw *raw = &run->raw;
    hdr_raw before = *raw;
    raw->grey = !run->coloured && (run->source->picture.planes == 1 || !met->colour);
    raw->opaque = !met->translucent;
    return (sweep->grey_matters && raw->grey != before.grey) || (sweep->alpha_matters && raw->opaque != before.opaque);
}

double hdr_milliseconds(void) {
    struct timespec now = {0};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

/* Of mappers, which have no other way to tell. */
static hdr_status check_strips(const hdr_run *run, hdr_error *err) {
    for (int t = 0; t < run->thread_count; t++)
        if (run->threads[t].strip->failed)
            return hdr_fail(err, HDR_INTERNAL, "a colour transform has failed: memory may be out");
    return HDR_OK;
}

hdr_status hdr_run_sweep(hdr_run *run, const hdr_sweep *sweep, hdr_error *err) {
    hdr_raw *raw = &run->raw;
    for (;;) {
        double started = hdr_milliseconds();
        int items = 0;
        for (int t = 0; t < run->thread_count; t++)
            run->threads[t].watch = (hdr_watch){0};
        hdr_status status = sweep->before(sweep->context, &items, err);
        if (!status) status = hdr_pool_run(run->pool, items, sweep->job, sweep->context, err);
        if (!status) status = check_strips(run, err);
        if (status) return status;
        hdr_watch met = merge_watches(run);
        bool again = false;
        if (met.infinity && !raw->replacements_known) {
            status = find_replacements(run, err);
            if (status) return status;
            again = true;
        }
        /* an attempt that was broken off has met what contradicts, and perhaps not all there is */
        if (met.colour && raw->grey) raw->grey = false, again = true;
        if (met.translucent && raw->opaque) raw->opaque = false, again = true;
        if (again) {
            hdr_say(run->listener, HDR_EXPLAIN, "the sweep begins again: it has met %s",
                    met.infinity ? "an infinity"
                    : met.colour ? "a colour"
                                 : "an alpha below 1");
            continue;
        }
        run->sweeps++;
        hdr_say(run->listener, HDR_DETAIL, "sweep %d: %.1f ms", run->sweeps, hdr_milliseconds() - started);
        if (raw->certain) return HDR_OK;
        bool as_it_is = sweep->partial || !learn(run, sweep, &met);
        raw->certain = !sweep->partial;
        raw->nan = met.nan;
        raw->positive_infinity = met.positive_infinity;
        raw->negative_infinity = met.negative_infinity;
        status = hdr_run_report_guided(run, err);
        if (!status) status = report_repairs(run, err);
        if (status || as_it_is) return status;
        hdr_say(run->listener, HDR_EXPLAIN, "the sweep is made again: the picture is %s after all",
                raw->grey ? "grey" : "opaque");
    }
}

/* The block that a guess is made of need not be decoded again. Without memory it is: no fault. */
static void keep_looked_at(hdr_run *run, int block, const hdr_block *in) {
    hdr_block kept;
    if (run->kept || run->looked_at) return;
    run->looked_at = hdr_alloc(run->kept_row * (size_t)in->rows + KEPT_SLACK, 1);
    run->looked_at_block = block;
    if (!run->looked_at) return;
    lay_out_block(run, block, run->looked_at, &kept);
    copy_block(in, &kept);
}

/* Whether some pixel's value in a channel is another than in the first, or in alpha's than 1, both being finite: which
 * no repair can change. */
static bool differs(const hdr_block *block, int channel, int row, int x, size_t count) {
    const unsigned char *first = block->plane[0] ? block->plane[0] + (size_t)row * block->stride[0] : NULL;
    const unsigned char *other =
        block->plane[channel] ? block->plane[channel] + (size_t)row * block->stride[channel] : NULL;
    for (size_t i = 0; i < count; i++) {
        int64_t at = x + (int64_t)i;
        double a = channel == 3 ? 1 : first ? stored_value(block->type[0], first, at) : 0;
        double b = other ? stored_value(block->type[channel], other, at) : 0;
        if (isfinite(a) && isfinite(b) && a != b) return true;
    }
    return false;
}

static hdr_status guess_job(void *context, int item, int thread, hdr_error *err) {
    (void)item;
    hdr_run *run = context;
    hdr_block in;
    int block = run->source->blocks / 2;
    hdr_status status = hdr_run_read(run, thread, block, &in, err);
    if (status) return status;
    keep_looked_at(run, block, &in);
    int64_t width = hdr_window_width(&run->source->picture.data);
    size_t count = width < HDR_STRIP ? (size_t)width : HDR_STRIP;
    for (int row = 0; row < in.rows; row++) {
        int x = (int)((size_t)width - count) / 2;
        hdr_watch *watch = &run->threads[thread].watch;
        if (run->source->picture.planes == 3 &&
            !(same_bits(&in, 0, 1, row, x, count) && same_bits(&in, 0, 2, row, x, count)))
            watch->colour |= differs(&in, 1, row, x, count) || differs(&in, 2, row, x, count);
        if (in.plane[3] && !run->over) watch->translucent |= differs(&in, 3, row, x, count);
    }
    return HDR_OK;
}

hdr_status hdr_run_guess(hdr_run *run, bool grey_matters, hdr_error *err) {
    const hdr_picture *picture = &run->source->picture;
    bool of_colour = picture->planes == 3 && grey_matters;
    if (run->raw.certain || run->source->blocks == 0 || (!of_colour && !picture->has_alpha)) return HDR_OK;
    for (int t = 0; t < run->thread_count; t++)
        run->threads[t].watch = (hdr_watch){0};
    hdr_status status = hdr_pool_run(run->pool, 1, guess_job, run, err);
    hdr_watch met = merge_watches(run);
    run->raw.grey = !run->coloured && (picture->planes == 1 || (grey_matters && !met.colour));
    run->raw.opaque = !met.translucent;
    return status;
}

/* ---- Facts ---- */

typedef struct facts_sweep {
    hdr_run *run;
    hdr_taking *taking;
    hdr_plane *plane;        /* Y goes there; or NULL */
    const double *intensity; /* weights of what stands for Y; or NULL */
    bool whole;              /* all channels are wanted, even if they are equal */
    bool reduce; /* one plane stands for three equal ones: the same in all sweeps of a taking, whose counts go together
                  */
} facts_sweep;

static hdr_status facts_before(void *context, int *items, hdr_error *err) {
    facts_sweep *sweep = context;
    *items = sweep->run->source->blocks;
    return hdr_taking_begin(sweep->taking, (int)hdr_window_height(&sweep->run->source->picture.data), err);
}

/* A pixel that is not lit has 0 there. */
static void store_luminance(const hdr_strip *strip, hdr_plane *plane) {
    size_t at = (size_t)strip->row * plane->stride + (size_t)strip->x;
    double lit[HDR_STRIP];
    for (size_t i = 0; i < strip->count; i++)
        lit[i] = strip->y[i] > 0 ? strip->y[i] : 0;
    if (plane->wide)
        memcpy(plane->wide + at, lit, strip->count * sizeof *lit);
    else
        hdr_real_to_float(lit, plane->narrow + at, strip->count);
}

static hdr_status facts_job(void *context, int item, int thread, hdr_error *err) {
    facts_sweep *sweep = context;
    hdr_run *run = sweep->run;
    hdr_strip *strip = run->threads[thread].strip;
    hdr_block block;
    hdr_status status = hdr_run_read(run, thread, item, &block, err);
    if (status) return status;
    int64_t width = hdr_window_width(&run->source->picture.data);
    for (int row = 0; row < block.rows; row++) {
        for (int64_t x = 0; x < width; x += HDR_STRIP) {
            size_t count = width - x < HDR_STRIP ? (size_t)(width - x) : HDR_STRIP;
            if (!hdr_run_load(run, thread, &block, row, (int)x, count, sweep->reduce, sweep->whole)) return HDR_OK;
            hdr_strip_apply(strip, run->steps, 0, run->step_count, run->settings.reference);
            if (sweep->intensity)
                hdr_strip_intensity(strip, sweep->intensity, run->weights);
            else
                hdr_strip_luminance(strip, run->weights);
            if (sweep->plane) store_luminance(strip, sweep->plane);
            const double *planes[3] = {strip->c[0], strip->c[1], strip->c[2]};
            hdr_taking_strip(sweep->taking, thread, planes, strip->planes, strip->y,
                             run->source->picture.has_alpha ? strip->alpha : NULL, count);
        }
        hdr_taking_row_end(sweep->taking, thread, block.first_row + row);
    }
    return HDR_OK;
}

/* As they are stored: neither a step, nor alpha, nor a colour below has touched them; and whole numbers may have more
 * digits than a float. */
static bool are_float_components(const hdr_run *run) {
    const hdr_picture *picture = &run->source->picture;
    bool stored = run->step_count == 0 && !picture->has_alpha && !run->over;
    for (int c = 0; c < picture->planes; c++)
        stored &= picture->channels[c].type != HDR_UINT;
    return stored;
}

static hdr_status take_facts(facts_sweep *sweep, hdr_error *err) {
    hdr_status status =
        hdr_run_sweep(sweep->run, &(hdr_sweep){.before = facts_before, .job = facts_job, .context = sweep}, err);
    if (!status) hdr_taking_end(sweep->taking);
    return status;
}

hdr_status hdr_run_take(hdr_run *run, hdr_taking *taking, hdr_error *err) {
    return take_facts(&(facts_sweep){.run = run, .taking = taking, .whole = true}, err);
}

hdr_status hdr_run_facts(hdr_run *run, const hdr_request *request, hdr_taking *together, hdr_plane *plane,
                         hdr_facts *facts, hdr_error *err) {
    if (request->percentiles) hdr_run_keep(run);
    facts_sweep sweep = {
        .run = run, .plane = plane, .intensity = request->weights, .whole = request->facts & HDR_FACT_CHANNELS};
    sweep.reduce = run->raw.certain && !sweep.whole;
    sweep.taking = hdr_taking_new(request, run->thread_count, are_float_components(run), err);
    if (!sweep.taking) return err->status;
    hdr_status status;
    do {
        status = take_facts(&sweep, err);
        if (!status && together) hdr_taking_join(together, sweep.taking);
        together = NULL; /* the first sweep is what it is to have */
    } while (!status && hdr_taking_next(sweep.taking, facts));
    if (!status && hdr_taking_contradicted(sweep.taking))
        status = hdr_fail(err, HDR_BAD_DATA, "it has changed while it was read");
    hdr_taking_free(sweep.taking);
    return status;
}

/* The sweep that writes: from a block to packed bytes on one thread, while its lines are warm. */
#include "chain/run.h"

#include "io/join.h"
#include "picture/colour.h"

#include <stdlib.h>
#include <string.h>

/* What the sweep is made with; valid for the assumptions of one attempt. */
typedef struct writing {
    hdr_run *run;
    const hdr_verb *format;
    const void *params;
    hdr_output *output;
    hdr_frame frame;              /* planes and alpha are set by each attempt */
    bool may_be_grey;             /* the format stores one plane where the picture is grey */
    hdr_bytes attributes, record; /* what the frame points to */
    hdr_drawing legend;           /* the frame's last rows */
    hdr_sink *sink;
    int64_t first_end, step; /* bands: the frame's row behind the first; rows of those that follow, but the last */
    int bands;
    int tail; /* first of the steps that the table stands for; all steps before are done by rows */
    bool tabulated;
    int watched; /* the largest component in front of this step is of interest; -1: it is not */
    hdr_code_table *table;
    uint8_t *half_codes; /* codes of all half values, or NULL where that does not serve */
} writing;

/* ---- Bands ---- */

/* The frame's row at which a band begins; that of a band behind the last is the frame's height. */
static int first_of_band(const writing *w, int band) {
    int64_t row = band == 0 ? 0 : w->first_end + (band - 1) * w->step;
    return (int)(row < w->frame.height ? row : w->frame.height);
}

/* Bands follow the source's blocks where the format leaves it open, so that each block is decoded by one thread, once.
 * Rows without pixels, above and below, come in bands of the same height. No list of them is made: a header may claim
 * millions. */
static void cut_bands(writing *w) {
    const hdr_source *source = w->run->source;
    int multiple = w->sink->band_multiple, height = w->frame.height;
    int64_t step = source->block_rows;
    if (multiple > 1) step = (step + multiple - 1) / multiple * multiple;
    /* where the data window's first block begins in the frame */
    int64_t first_block = (int64_t)source->picture.data.min_y - source->rows_cut - w->frame.data.min_y;
    int64_t offset = multiple > 1 ? 0 : first_block % step;
    if (offset < 0) offset += step;
    w->step = step;
    w->first_end = offset ? offset : step;
    w->bands = w->first_end < height ? (int)((height - w->first_end - 1) / step) + 2 : 1;
}

/* ---- An attempt ---- */

static void close_sink(writing *w) {
    for (int t = 0; t < w->run->thread_count; t++) {
        hdr_thread *thread = &w->run->threads[t];
        if (w->sink && thread->packer) w->sink->packer_free(w->sink, thread->packer);
        thread->packer = NULL;
        free(thread->samples);
        thread->samples = NULL;
    }
    if (w->sink) w->sink->close(w->sink);
    w->sink = NULL;
}

/* Every channel by itself, from half, to 8 bits: all 65536 answers fit in a table. */
static bool serves_half_codes(const writing *w) {
    const hdr_picture *picture = &w->run->source->picture;
    bool half = true;
    for (int p = 0; p < picture->planes; p++)
        half &= picture->present[p] && picture->channels[p].type == HDR_HALF;
    return half && w->tabulated && w->tail == 0 && w->run->raw.opaque && !w->frame.alpha && !w->run->over;
}

/* NaN and -Inf are repaired to 0. +Inf is left to the other path, which knows its replacement. */
static void fill_half_codes(writing *w) {
    for (unsigned start = 0; start < 65536; start += HDR_STRIP) {
        double values[HDR_STRIP];
        for (unsigned i = 0; i < HDR_STRIP; i++) {
            double value = hdr_half_value((uint16_t)(start + i));
            values[i] = value - value == 0 ? value : 0;
        }
        hdr_code_lookup(w->table, values, w->half_codes + start, 1, HDR_STRIP);
    }
}

/* What else than pixels the file is to hold. */
static hdr_status add_attributes(writing *w, const char *state, bool converted, hdr_error *err) {
    const hdr_run *run = w->run;
    const hdr_chain *chain = run->chain;
    const hdr_format *format = w->format->format;
    if (!format->attributes) return HDR_OK;
    bool recorded = format->records && format->records(w->params);
    hdr_exr_fate fate = {.joined = run->joined != NULL,
                         .converted = converted || run->mapped,
                         .encoded = strcmp(state, "linear") != 0,
                         .cropped = chain->common.crop != NULL,
                         .recorded = recorded};
    for (int i = 0; i < chain->count; i++)
        fate.altered |= chain->clauses[i].verb->about.kind == HDR_FILTER || chain->clauses[i].verb->guide;
    int left_out = 0;
    char meaning[400];
    hdr_status status = hdr_source_attributes(run->input, &run->source->picture, fate, &w->attributes, &left_out, err);
    if (left_out)
        hdr_say(run->listener, HDR_NOTE, "%s: %d attribute%s of its header %s damaged or too large, and left out",
                run->name, left_out, left_out == 1 ? "" : "s", left_out == 1 ? "is" : "are");
    if (!status && run->joined) status = hdr_join_attributes(run->joined, &w->attributes, err);
    if (!status && hdr_run_meaning(run, meaning, sizeof meaning))
        status = hdr_exr_add_text(&w->attributes, HDR_EXR_MEANING, meaning, err);
    w->frame.attributes = &w->attributes;
    if (status || !recorded) return status;
    status = hdr_chain_print(chain, &w->record, err);
    if (!status) status = hdr_bytes_add(&w->record, "", 1, err);
    w->frame.record = (const char *)w->record.data;
    return status;
}

/* The rows of the legend come below those of the window. */
static hdr_status add_legend(writing *w, hdr_error *err) {
    const hdr_run *run = w->run;
    hdr_frame *frame = &w->frame;
    if (!run->legend.palette || !w->format->format->codes) return HDR_OK;
    if (frame->height > INT32_MAX - hdr_legend_height(frame->width, frame->height))
        return hdr_fail(err, HDR_BAD_DATA, "there is no room for a legend below it: see --no-legend");
    hdr_status status = hdr_legend_draw(&run->legend, frame->width, frame->height, &w->legend, err);
    frame->height += w->legend.height;
    return status;
}

static hdr_status begin_attempt(void *context, int *items, hdr_error *err) {
    writing *w = context;
    hdr_run *run = w->run;
    const hdr_picture *picture = &run->source->picture;
    close_sink(w);
    hdr_status status = hdr_output_restart(w->output, err);
    if (status) return status;
    w->frame.planes = picture->planes == 3 && run->raw.grey && w->may_be_grey ? 1 : picture->planes;
    w->frame.alpha = w->format->format->alpha && picture->has_alpha && (!run->raw.opaque || hdr_run_has_border(run));
    w->sink = w->format->format->create(w->params, w->output, &w->frame, err);
    if (!w->sink) return err->status;
    cut_bands(w);
    int64_t tallest = w->step < w->frame.height ? w->step : w->frame.height;
    for (int t = 0; t < run->thread_count; t++) {
        run->threads[t].samples = hdr_alloc((size_t)tallest, hdr_frame_row_bytes(&w->frame));
        if (!run->threads[t].samples) return hdr_fail(err, HDR_INTERNAL, "out of memory");
        status = w->sink->packer_new(w->sink, &run->threads[t].packer, err);
        if (status) return status;
    }
    free(w->half_codes);
    w->half_codes = serves_half_codes(w) ? hdr_alloc(65536, 1) : NULL;
    if (w->half_codes) fill_half_codes(w);
    *items = w->bands;
    return w->sink->begin(w->sink, err);
}

/* ---- A row ---- */

/* The strip's values as the frame's samples, at pixel x of the row. */
static void store_samples(const writing *w, hdr_strip *strip, unsigned char *row, int x) {
    const hdr_frame *frame = &w->frame;
    size_t channels = (size_t)hdr_frame_channels(frame), n = strip->count;
    const double *plane[4] = {strip->c[0], strip->c[1], strip->c[2]};
    plane[frame->planes] = strip->alpha; /* the last channel, where there is alpha */
    for (size_t c = 0; c < channels; c++) {
        bool is_alpha = c == (size_t)frame->planes;
        switch (frame->sample) {
        case HDR_SAMPLE_U8: {
            uint8_t *out = row + (size_t)x * channels + c;
            if (w->tabulated && !is_alpha)
                hdr_code_lookup(w->table, plane[c], out, channels, n);
            else
                hdr_codes_u8(plane[c], 255, out, channels, n);
            break;
        }
        case HDR_SAMPLE_U16:
            hdr_codes_u16(plane[c], 65535, (uint16_t *)(void *)row + (size_t)x * channels + c, channels, n);
            break;
        case HDR_SAMPLE_FLOAT:
            hdr_real_to_float(plane[c], (float *)(void *)row + c * (size_t)frame->width + x, n);
            break;
        case HDR_SAMPLE_HALF:
            hdr_real_to_half(plane[c], (uint16_t *)(void *)row + c * (size_t)frame->width + x, n);
            break;
        }
    }
}

static bool all_one_half(const uint16_t *half, size_t count) {
    uint16_t difference = 0;
    for (size_t i = 0; i < count; i++)
        difference |= half[i] ^ 0x3c00u;
    return difference == 0;
}

static void watch_halves(hdr_watch *watch, const uint16_t *const half[], int planes, size_t count) {
    for (int p = 0; p < planes; p++) {
        double largest = hdr_half_value(hdr_half_largest(half[p], count));
        if (largest > watch->largest) watch->largest = largest;
    }
}

static void watch_strip(hdr_watch *watch, const hdr_strip *strip) {
    for (int p = 0; p < strip->planes; p++) {
        double largest = hdr_largest(strip->c[p], strip->count);
        if (largest > watch->largest) watch->largest = largest;
    }
}

/* Half values of a row piece straight to codes. False: there is something to repair, or what is assumed does not hold;
 * the other path settles it. */
static bool store_half_codes(const writing *w, int thread, const hdr_block *block, int row, int x, size_t count,
                             unsigned char *out) {
    const hdr_run *run = w->run;
    const hdr_picture *picture = &run->source->picture;
    if (!w->half_codes) return false;
    const uint16_t *half[4] = {NULL};
    for (int c = 0; c < 4; c++) {
        if (!block->plane[c] || (c == 3 && !picture->has_alpha)) continue; /* alpha may have been dropped */
        if (block->type[c] != HDR_HALF) return false;                      /* or be float */
        half[c] = (const uint16_t *)(const void *)(block->plane[c] + (size_t)row * block->stride[c]) + x;
    }
    for (int p = 0; p < picture->planes; p++)
        if (!hdr_half_all_finite(half[p], count)) return false;
    if (!run->raw.certain && half[3] && !all_one_half(half[3], count)) return false;
    bool *colour = &run->threads[thread].watch.colour;
    if (picture->planes == 3 && (run->raw.grey || !*colour)) {
        bool grey = !memcmp(half[0], half[1], 2 * count) && !memcmp(half[0], half[2], 2 * count);
        if (!grey && run->raw.grey) return false;
        *colour |= !grey;
    }
    if (w->watched >= 0) watch_halves(&run->threads[thread].watch, half, w->frame.planes, count);
    hdr_code_half(w->half_codes, (const uint16_t *const *)half, w->frame.planes, out, count);
    return true;
}

/* Pixels of the strip that a viewer of the file will not show though they have a colour. */
static uint64_t count_hidden(const hdr_strip *strip) {
    uint64_t hidden = 0;
    for (size_t i = 0; i < strip->count; i++) {
        bool colour = false;
        for (int p = 0; p < strip->planes; p++)
            colour |= strip->c[p][i] != 0;
        hidden += strip->alpha[i] == 0 && colour;
    }
    return hidden;
}

/* The steps that no table stands for, on a strip of the picture. */
static void apply_steps(const writing *w, int thread) {
    const hdr_run *run = w->run;
    hdr_strip *strip = run->threads[thread].strip;
    int end = w->tabulated ? w->tail : run->step_count, from = 0;
    if (w->watched >= 0) {
        hdr_strip_apply(strip, run->steps, 0, w->watched, run->settings.reference);
        watch_strip(&run->threads[thread].watch, strip);
        from = w->watched;
    }
    hdr_strip_apply(strip, run->steps, from, end, run->settings.reference);
}

/* A row as it is outside the data window: black, or the colour that the picture is laid over, after all steps. */
static void make_border(const writing *w, int thread, int row, unsigned char *out) {
    const hdr_run *run = w->run;
    hdr_strip *strip = run->threads[thread].strip;
    memset(out, 0, hdr_frame_row_bytes(&w->frame));
    strip->row = -1;
    strip->place_y = w->frame.data.min_y + row;
    for (int x = 0; run->over && x < w->frame.width; x += HDR_STRIP) {
        strip->count = w->frame.width - x < HDR_STRIP ? (size_t)(w->frame.width - x) : HDR_STRIP;
        strip->planes = run->raw.grey && w->may_be_grey ? 1 : run->source->picture.planes;
        strip->place_x = w->frame.data.min_x + x;
        for (int p = 0; p < strip->planes; p++)
            for (size_t i = 0; i < strip->count; i++)
                strip->c[p][i] = run->over[p];
        hdr_strip_apply(strip, run->steps, 0, w->tabulated ? w->tail : run->step_count, run->settings.reference);
        store_samples(w, strip, out, x);
    }
}

/* A row of the frame that has pixels. False: the attempt is over. */
static bool make_row(const writing *w, int thread, const hdr_block *block, int frame_row, unsigned char *out) {
    hdr_run *run = w->run;
    const hdr_window *data = &run->source->picture.data, *window = &w->frame.data;
    hdr_strip *strip = run->threads[thread].strip;
    int row = (int)((int64_t)window->min_y + frame_row - data->min_y) - block->first_row;
    int64_t left = data->min_x > window->min_x ? data->min_x : window->min_x;
    int64_t right = data->max_x < window->max_x ? data->max_x : window->max_x;
    if (left > window->min_x || right < window->max_x) make_border(w, thread, frame_row, out);
    for (int64_t at = left; at <= right; at += HDR_STRIP) {
        size_t count = right - at + 1 < HDR_STRIP ? (size_t)(right - at + 1) : HDR_STRIP;
        int x = (int)(at - data->min_x), frame_x = (int)(at - window->min_x);
        if (store_half_codes(w, thread, block, row, x, count, out + (size_t)frame_x * (size_t)w->frame.planes))
            continue;
        if (!hdr_run_load(run, thread, block, row, x, count, w->may_be_grey, w->frame.alpha)) return false;
        if (w->frame.alpha && w->format->format->codes) run->threads[thread].watch.hidden += count_hidden(strip);
        apply_steps(w, thread);
        if (!w->format->format->codes && !run->raw.opaque)
            for (int p = 0; p < strip->planes; p++)
                hdr_associate(strip->c[p], strip->alpha, count);
        store_samples(w, strip, out, frame_x);
    }
    return true;
}

/* A row of the legend, as samples. */
static void copy_legend(const writing *w, int row, unsigned char *out) {
    const uint32_t *pixels = w->legend.pixels + (size_t)row * (size_t)w->legend.width;
    size_t channels = (size_t)hdr_frame_channels(&w->frame);
    for (size_t i = 0; i < (size_t)w->legend.width * channels; i++) {
        unsigned plane = (unsigned)(i % channels);
        unsigned code = plane < 3 ? pixels[i / channels] >> (16 - 8 * plane) & 0xff : 0xff;
        if (w->frame.sample == HDR_SAMPLE_U8)
            out[i] = (uint8_t)code;
        else
            ((uint16_t *)(void *)out)[i] = (uint16_t)(code * 257);
    }
}

/* The rows of a band. False: the attempt is over, or err is filled. */
static bool make_band(const writing *w, int thread, int first, int end, hdr_error *err) {
    hdr_run *run = w->run;
    const hdr_window *data = &run->source->picture.data, *window = &w->frame.data;
    size_t row_bytes = hdr_frame_row_bytes(&w->frame);
    unsigned char *out = run->threads[thread].samples;
    bool beside = data->max_x < window->min_x || data->min_x > window->max_x; /* no pixel of any row is in the frame */
    int current = -1;
    hdr_block block;
    for (int row = first; row < end; row++, out += row_bytes) {
        if (row >= w->frame.height - w->legend.height) {
            copy_legend(w, row - (w->frame.height - w->legend.height), out);
            continue;
        }
        int64_t data_row = (int64_t)window->min_y + row - data->min_y;
        if (beside || data_row < 0 || data_row >= hdr_window_height(data)) {
            make_border(w, thread, row, out);
            continue;
        }
        int wanted = hdr_source_block_of(run->source, (int)data_row);
        if (wanted != current && hdr_run_read(run, thread, wanted, &block, err)) return false;
        current = wanted;
        if (!make_row(w, thread, &block, row, out)) return false;
    }
    return true;
}

static hdr_status band_job(void *context, int band, int thread, hdr_error *err) {
    writing *w = context;
    hdr_thread *mine = &w->run->threads[thread];
    int first = first_of_band(w, band), end = first_of_band(w, band + 1);
    if (!make_band(w, thread, first, end, err)) return err->status;
    hdr_status status = w->sink->pack(w->sink, mine->packer, first, end - first, mine->samples, err);
    if (status || !hdr_pool_enter(w->run->pool, band)) return status;
    status = w->sink->deliver(w->sink, mine->packer, err);
    hdr_pool_leave(w->run->pool, band);
    return status;
}

/* ---- The sweep ---- */

/* The window that is written, and whether it is one that can be. */
static hdr_status choose_frame(writing *w, hdr_error *err) {
    const hdr_picture *picture = &w->run->source->picture;
    const hdr_window *window = w->run->chain->common.window == HDR_WINDOW_DATA ? &picture->data : &picture->display;
    int64_t width = hdr_window_width(window), height = hdr_window_height(window);
    double area = (double)width * (double)height;
    double data_area = (double)hdr_window_width(&picture->data) * (double)hdr_window_height(&picture->data);
    /* a display window that is mostly black is one thing, one of 10^18 pixels a damaged file */
    if (width < 1 && window == &picture->data)
        return hdr_fail(err, HDR_BAD_DATA,
                        "there are no pixels in the rectangle that --crop leaves: only --window "
                        "display can be written, black");
    bool unfit =
        width < 1 || height < 1 || width > INT32_MAX || height > INT32_MAX || (area > 0x1p27 && area > 64 * data_area);
    if (unfit && w->run->chain->common.crop)
        return hdr_fail(err, HDR_BAD_DATA,
                        "the rectangle of %lld x %lld pixels that --crop asks for cannot be written: the picture has "
                        "%.0f pixels in it",
                        (long long)width, (long long)height, data_area);
    if (unfit)
        return hdr_fail(err, HDR_BAD_DATA,
                        "the display window of %lld x %lld pixels cannot be written; try --window data",
                        (long long)width, (long long)height);
    w->frame.width = (int)width;
    w->frame.height = (int)height;
    w->frame.data = *window;
    w->frame.display = picture->display;
    w->frame.pixel_aspect = picture->pixel_aspect;
    return HDR_OK;
}

static bool sees_all(const writing *w) {
    const hdr_window *data = &w->run->source->picture.data, *window = &w->frame.data;
    return window->min_x <= data->min_x && window->max_x >= data->max_x && window->min_y <= data->min_y &&
           window->max_y >= data->max_y;
}

/* Whether the picture is known to be no less than what the frame has to hold, though no more of it has been seen than a
 * guess takes: a colour, and a translucent pixel, once seen cannot be taken back. */
static bool is_settled(const writing *w) {
    const hdr_run *run = w->run;
    const hdr_picture *picture = &run->source->picture;
    bool colour = !w->may_be_grey || picture->planes == 1 || !run->raw.grey;
    bool alpha = !w->format->format->alpha || !picture->has_alpha || !run->raw.opaque || hdr_run_has_border(run);
    return colour && alpha;
}

/* What the writing sweep is told of the picture beforehand. Greyness and opacity are those of the whole data window:
 * where the frame does not show all of it, and a look at the middle does not settle them, a sweep has to. Otherwise
 * blocks outside the frame are never decoded. *partial: so it is. */
static hdr_status look_ahead(writing *w, bool *partial, hdr_error *err) {
    hdr_run *run = w->run;
    hdr_status status = hdr_run_guess(run, w->may_be_grey, err);
    *partial = false;
    if (status || run->raw.certain || sees_all(w)) return status;
    *partial = is_settled(w) && !run->settings.strict && !run->settings.no_skip;
    if (*partial) {
        hdr_say(run->listener, HDR_EXPLAIN, "pixels outside the window that is written are not looked at");
        return HDR_OK;
    }
    hdr_run_keep(run);
    hdr_request nothing = {0};
    hdr_facts facts;
    return hdr_run_facts(run, &nothing, NULL, NULL, &facts, err);
}

/* Light without cover, such as a flame's, is what EXR can hold and PNG cannot: said once, with the way out. */
static void report_hidden(const hdr_run *run) {
    uint64_t hidden = 0;
    for (int t = 0; t < run->thread_count; t++)
        hidden += run->threads[t].watch.hidden;
    if (hidden)
        hdr_say(run->listener, HDR_NOTE,
                "%s: %llu pixel%s a colour but an alpha of 0, which no viewer will show; see --alpha drop and "
                "--alpha over:R,G,B",
                run->name, (unsigned long long)hidden, hidden == 1 ? " has" : "s have");
}

/* In front of which step the largest component is looked at: where the light is not encoded yet, and no later than in
 * front of the table. */
static int choose_watched(const writing *w) {
    const hdr_run *run = w->run;
    if (!run->scene_light || !w->format->format->codes) return -1;
    return run->light_steps >= 0 && run->light_steps < w->tail ? run->light_steps : w->tail;
}

/* What the steps from `watched` on make of a component, as long as they map each by itself. */
static double mapped(const writing *w, int end, double value) {
    const hdr_step *steps = w->run->steps;
    for (int s = w->watched; s < end && steps[s].form == HDR_FORM_CHANNEL; s++)
        value = hdr_held(steps[s].curve->exact(&steps[s].constants, value));
    return value;
}

/* A render as it is, straight to codes, loses what is above 1: noted, if a code shows it. */
static void note_cut(const writing *w) {
    hdr_run *run = w->run;
    double largest = 0, top = (double)((1 << w->frame.bits) - 1);
    if (w->watched < 0) return;
    for (int t = 0; t < run->thread_count; t++)
        if (run->threads[t].watch.largest > largest) largest = run->threads[t].watch.largest;
    if (mapped(w, run->step_count, largest) * top >= top + 0.5)
        run->cut = mapped(w, run->light_steps < 0 ? run->step_count : run->light_steps, largest);
}

static void explain_tail(const writing *w) {
    const hdr_run *run = w->run;
    if (w->half_codes)
        hdr_say(run->listener, HDR_EXPLAIN,
                "each channel by itself from half: a table of 65536 codes stands for the whole chain");
    else if (w->tabulated && w->tail < run->step_count)
        hdr_say(run->listener, HDR_EXPLAIN,
                "the last %d of %d: 255 thresholds stand for these steps, since only 256 codes can come out",
                run->step_count - w->tail, run->step_count);
    if (run->source->picture.planes == 3 && w->frame.planes == 1)
        hdr_say(run->listener, HDR_EXPLAIN, "R = G = B everywhere: one plane is computed and written");
    if (run->source->picture.has_alpha && run->raw.opaque)
        hdr_say(run->listener, HDR_EXPLAIN, "alpha is 1 everywhere: %s",
                w->frame.alpha ? "kept for the border" : "dropped");
}

hdr_status hdr_run_write(hdr_run *run, const hdr_verb *format, const void *params, hdr_output *output,
                         const char *state, int bits, bool converted, hdr_error *err) {
    const hdr_picture *picture = &run->source->picture;
    writing w = {.run = run, .format = format, .params = params, .output = output};
    int sample_bits = format->format->codes ? format->format->bits(params, bits) : 0;
    w.frame.sample = format->format->sample(params, sample_bits);
    w.frame.bits = bits ? bits : sample_bits;
    w.frame.state = state;
    if (!strncmp(state, "gamma ", 6)) w.frame.gamma = strtod(state + 6, NULL);
    /* codes of Rec.709's primaries, or of none, need no more than sRGB's or gamma's own chunks */
    bool foreign = picture->planes == 3 && hdr_chromaticities_differ(&picture->chromaticities, &hdr_rec709);
    w.frame.has_chromaticities = picture->has_chromaticities && !converted && (foreign || !format->format->codes);
    w.frame.chromaticities = picture->chromaticities;
    /* nor is one of ocio's, whether it comes from a file or not */
    w.may_be_grey = format->format->codes && !converted && !run->mapped && strcmp(state, "ocio") != 0;
    w.tail = hdr_steps_tail(run->steps, run->step_count);
    w.watched = choose_watched(&w);
    hdr_status status = choose_frame(&w, err);
    if (!status) status = add_legend(&w, err);
    if (!status) status = add_attributes(&w, state, converted, err);
    bool table = w.frame.sample == HDR_SAMPLE_U8 && !run->settings.reference && !run->settings.no_skip;
    if (!status && table) {
        w.table = hdr_alloc(1, sizeof *w.table);
        const hdr_step *tail =
            w.tail ? run->steps + w.tail : run->steps; /* none at all: NULL, to which 0 is not added */
        w.tabulated = w.table && hdr_steps_tabulate(tail, run->step_count - w.tail, w.table);
    }
    bool partial = false;
    if (!status) status = look_ahead(&w, &partial, err);
    if (!status)
        status = hdr_run_sweep(run,
                               &(hdr_sweep){.before = begin_attempt,
                                            .job = band_job,
                                            .context = &w,
                                            .grey_matters = w.may_be_grey,
                                            .alpha_matters = format->format->alpha,
                                            .partial = partial},
                               err);
    if (!status) status = w.sink->end(w.sink, err);
    if (!status) explain_tail(&w);
    if (!status) report_hidden(run);
    if (!status) note_cut(&w);
    close_sink(&w);
    free(w.table);
    free(w.half_codes);
    hdr_drawing_free(&w.legend);
    free(w.attributes.data);
    free(w.record.data);
    return status;
}

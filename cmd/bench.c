/* hdr bench: run time against error. A chain is computed in every way that there is, in turns, and each result is
 * compared with that of the most exact way. */
#include "bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* What is kept of a way while it is measured. */
typedef struct timing {
    hdr_chain *whole; /* from the file to a format */
    hdr_chain *part;  /* up to the varied clause; NULL: nothing is varied */
    double *whole_time, *own_time;
    double spent;
} timing;

typedef struct measuring {
    bench b;
    hdr_chain *chain; /* as it was given */
    hdr_input *input;
    bench_pixels pixels;
    float *exact;        /* what is right at these pixels */
    char automatic[240]; /* how it is done where no method is asked for */
    bool encode;         /* codes need an encoding in front */
    int samples;
    timing timing[BENCH_WAYS];
} measuring;

static double milliseconds(void) {
    struct timespec now = {0};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

/* ---- Chains ---- */

typedef enum chain_end {
    END_PART,    /* behind the varied clause */
    END_FILTERS, /* behind the last filter */
    END_FORMAT,  /* with a format: that of the chain, or png */
    END_FLOAT,   /* with numbers */
    END_CODES    /* with numbers that are quantised as a png would be */
} chain_end;

/* way: whose words no clause has got yet, or NULL. */
static hdr_status add_end(const measuring *m, hdr_chain *chain, chain_end end, const bench_way *way, hdr_error *error) {
    static const char *const png[] = {"png"}, *const srgb[] = {"srgb"}, *const quantise[] = {"quantise", "--bits", "8"};
    const char *pfm[1 + BENCH_WORDS] = {"pfm"};
    int words = way ? way->word_count : 0;
    for (int i = 0; i < words; i++)
        pfm[1 + i] = way->words[i];
    hdr_status status = HDR_OK;
    const hdr_verb_about *last = hdr_chain_last(chain);
    bool formatted = last && last->kind == HDR_FORMAT;
    if (end == END_FORMAT && !formatted) status = hdr_chain_add(chain, png, 1, error);
    if (end == END_CODES && m->encode) status = hdr_chain_add(chain, srgb, 1, error);
    if (end == END_CODES && status == HDR_OK) status = hdr_chain_add(chain, quantise, 3, error);
    if ((end == END_CODES || end == END_FLOAT) && status == HDR_OK)
        status = hdr_chain_add(chain, pfm, 1 + words, error);
    return status;
}

/* The chain as it is computed in one way, or as it was given: then way is NULL. */
static hdr_chain *make_chain(const measuring *m, const bench_way *way, chain_end end, hdr_error *error) {
    int varied = m->b.varied;
    hdr_chain *chain = hdr_chain_new_like(m->chain, error);
    hdr_status status = chain ? HDR_OK : error->status;
    const hdr_verb_about *verb;
    bool placed = false;
    for (int i = 1; status == HDR_OK && (verb = hdr_chain_clause(m->chain, i)) != NULL; i++) {
        if ((verb->kind == HDR_FORMAT && end != END_FORMAT) || (end == END_PART && i > varied)) break;
        bool here = way && i == (varied ? varied : 1);
        placed |= here;
        status = hdr_chain_add_again(chain, m->chain, i, here ? way->words : NULL, here ? way->word_count : 0, error);
    }
    if (status == HDR_OK) status = add_end(m, chain, end, placed ? NULL : way, error);
    if (status == HDR_OK) return chain;
    hdr_chain_free(chain);
    return NULL;
}

/* ---- The scene ---- */

/* Whether the result is to be encoded before it is quantised. It is the first time that the picture is read: here it
 * is told what there is to be told. */
static hdr_status find_state(measuring *m, hdr_error *error) {
    hdr_listener listener = cmd_listener(m->chain);
    hdr_stats stats;
    hdr_chain *chain = make_chain(m, NULL, END_FILTERS, error);
    hdr_status status = chain ? hdr_chain_stats(chain, m->input, &stats, &listener, error) : error->status;
    const hdr_verb_about *verb;
    m->encode = status == HDR_OK && strcmp(stats.picture.state, "linear") == 0;
    for (int i = 1; (verb = hdr_chain_clause(m->chain, i)) != NULL; i++)
        if (strcmp(verb->name, "quantise") == 0) m->encode = false; /* a png would leave it as it is, too */
    hdr_chain_free(chain);
    return status;
}

/* Pixels to compare at, by what the scene is like in front of the varied clause. Where nothing is computed around a
 * pixel, there is nothing to vary. */
static hdr_status look_at_scene(measuring *m, hdr_error *error) {
    hdr_chain *chain = make_chain(m, NULL, END_PART, error);
    hdr_surround *scene = chain ? hdr_chain_surround(chain, m->input, 0, NULL, NULL, error) : NULL;
    hdr_chain_free(chain);
    if (!scene) return error->status;
    if (!scene->values) {
        m->b.varied = 0;
    } else if (bench_choose_pixels(scene, m->samples, &m->pixels, error)) {
        m->b.all = m->pixels.all;
        m->b.random = m->pixels.random;
        m->b.extremes = m->pixels.count - m->pixels.random;
        memcpy(m->automatic, scene->method, sizeof m->automatic);
    }
    hdr_surround_free(scene);
    return error->status;
}

/* ---- Errors ---- */

/* The time that a way takes for all pixels, from that for those to compare at. */
static double time_of_all(const measuring *m, const bench_way *way, double time) {
    double times_as_many = (double)(bench_width(&m->b) * bench_height(&m->b)) / m->pixels.count;
    return way->fixed + fmax(0, time - way->fixed) * times_as_many;
}

/* What of a partial way's time is for the picture and not for its pixels: if it is f, and p for each pixel, n of them
 * take f + n p, and a quarter as many f + n p / 4. */
static hdr_status find_fixed_time(const measuring *m, bench_way *way, hdr_chain *part, double time, hdr_error *error) {
    int count = (m->pixels.count + 3) / 4;
    hdr_surround *seen = hdr_chain_surround(part, m->input, count, m->pixels.pixel, NULL, error);
    if (!seen) return error->status;
    double quarter = (double)count / m->pixels.count, fixed = (seen->milliseconds - quarter * time) / (1 - quarter);
    if (quarter < 1) way->fixed = fmin(fmax(fixed, 0), seen->milliseconds);
    hdr_surround_free(seen);
    return HDR_OK;
}

/* What the way gives at the pixels to compare at. The first that is looked at is the exact one. */
static hdr_status look_at_way(measuring *m, bench_way *way, hdr_chain *part, hdr_error *error) {
    hdr_surround *seen = hdr_chain_surround(part, m->input, m->pixels.count, m->pixels.pixel, NULL, error);
    if (!seen) return error->status;
    size_t size = (size_t)m->pixels.count * sizeof *m->exact;
    if (!m->exact) {
        m->exact = malloc(size);
        if (m->exact) memcpy(m->exact, seen->values, size);
    }
    if (m->exact) {
        bench_compare_values(seen->values, m->exact, &m->pixels, way);
        way->partial = seen->partial;
        if (way->partial) find_fixed_time(m, way, part, seen->milliseconds, error);
        way->own = way->partial ? time_of_all(m, way, seen->milliseconds) : seen->milliseconds;
        way->estimated = way->own > m->b.limit;
        way->bound = seen->bound;
        way->automatic = strcmp(seen->method, m->automatic) == 0;
    }
    hdr_surround_free(seen);
    return m->exact ? error->status : cmd_out_of_memory(error);
}

/* The same of a chain with nothing to vary: of the picture that it makes. */
static hdr_status compare_pictures(measuring *m, hdr_error *error) {
    bench_image image[2] = {{0}, {0}};
    hdr_status status = HDR_OK;
    for (int i = 0; i < 2 && status == HDR_OK; i++) {
        hdr_chain *chain = make_chain(m, &m->b.way[i], END_FLOAT, error);
        status = chain ? bench_make_image(chain, m->input, &image[i], error) : error->status;
        if (status == HDR_OK) status = bench_compare_images(&image[i], &image[0], &m->b.way[i], error);
        hdr_chain_free(chain);
    }
    bench_free_image(&image[0]);
    bench_free_image(&image[1]);
    return status;
}

static hdr_status compare_codes(measuring *m, hdr_error *error) {
    bench_image reference = {0};
    hdr_status status = HDR_OK;
    m->b.codes = !m->b.way[0].estimated;
    for (int i = 0; i < m->b.count && status == HDR_OK && m->b.codes; i++) {
        bench_way *way = &m->b.way[i];
        bench_image image = {0};
        if (way->estimated) continue;
        hdr_chain *chain = make_chain(m, way, END_CODES, error);
        status = chain ? bench_make_image(chain, m->input, &image, error) : error->status;
        if (status == HDR_OK) status = bench_compare_codes(&image, i ? &reference : &image, way, error);
        hdr_chain_free(chain);
        if (i == 0)
            reference = image;
        else
            bench_free_image(&image);
    }
    bench_free_image(&reference);
    return status;
}

/* ---- Ways ---- */

static void free_timing(timing *t) {
    hdr_chain_free(t->whole);
    hdr_chain_free(t->part);
    free(t->whole_time);
    free(t->own_time);
    *t = (timing){0};
}

static void leave_out(const measuring *m, const bench_way *way, const char *why) {
    if (hdr_chain_settings(m->chain)->quiet) return;
    fprintf(stderr, "hdr: bench: %s%s%s is left out: %s\n", way->method, way->value ? " " : "",
            way->value ? way->value : "", why);
}

/* Makes ready to measure a way. *fits: neither the verb refuses its words, nor is there too little memory for it. */
static hdr_status prepare_way(measuring *m, bench_way *way, timing *t, bool *fits, hdr_error *error) {
    hdr_error fault = {0};
    t->whole = make_chain(m, way, END_FORMAT, &fault);
    if (m->b.varied && t->whole) t->part = make_chain(m, way, END_PART, &fault);
    if (t->part) look_at_way(m, way, t->part, &fault);
    t->whole_time = calloc((size_t)m->b.repetitions, sizeof *t->whole_time);
    t->own_time = calloc((size_t)m->b.repetitions, sizeof *t->own_time);
    *fits = fault.status == HDR_OK;
    if (!t->whole_time || !t->own_time) return cmd_out_of_memory(error);
    if (*fits && way->estimated && !way->partial) {
        /* it has been run, and that was long enough */
        t->own_time[way->repetitions++] = t->spent = way->own;
    }
    if (*fits || (m->exact && fault.status == HDR_USAGE)) return HDR_OK;
    if (m->exact && fault.status == HDR_INTERNAL) {
        leave_out(m, way, fault.message);
        return HDR_OK;
    }
    *error = fault;
    return fault.status;
}

/* Settings of a method go from the cheapest on: what comes behind one that took too long would take longer. */
static bool takes_too_long(measuring *m, const bench_way *way) {
    for (int i = 0; i < m->b.count; i++)
        if (m->b.way[i].estimated && !m->b.way[i].partial && strcmp(m->b.way[i].method, way->method) == 0) {
            leave_out(m, way, "a cheaper one has taken longer than --limit");
            return true;
        }
    return false;
}

static hdr_status add_prepared(measuring *m, const bench_way *way, hdr_error *error) {
    bench *b = &m->b;
    bool fits;
    timing *t = &m->timing[b->count];
    b->way[b->count] = *way;
    hdr_status status = prepare_way(m, &b->way[b->count], t, &fits, error);
    if (status != HDR_OK) return status;
    if (fits)
        b->count++;
    else
        free_timing(t);
    return HDR_OK;
}

/* One way is what is done where no method is asked for: if none of the settings is, it is added; if several are, since
 * there is nothing to do, none is marked. */
static hdr_status mark_automatic(measuring *m, hdr_error *error) {
    bench *b = &m->b;
    int marked = 0;
    for (int i = 0; i < b->count; i++)
        marked += b->way[i].automatic;
    for (int i = 0; i < b->count && marked > 1; i++)
        b->way[i].automatic = false;
    bench_way way = bench_automatic_way();
    return marked == 0 && b->count < BENCH_WAYS ? add_prepared(m, &way, error) : HDR_OK;
}

static hdr_status prepare_ways(measuring *m, hdr_error *error) {
    bench *b = &m->b;
    int count = b->varied ? bench_ways_of(hdr_chain_clause(m->chain, b->varied), b->way) : bench_plain_ways(b->way);
    for (int i = 0; i < count; i++) {
        bench_way way = b->way[i];
        if (takes_too_long(m, &way)) continue;
        hdr_status status = add_prepared(m, &way, error);
        if (status != HDR_OK) return status;
    }
    return b->varied ? mark_automatic(m, error) : HDR_OK;
}

/* ---- Times ---- */

static hdr_status run_whole(hdr_chain *chain, hdr_input *input, double *time, hdr_error *error) {
    hdr_output *output = hdr_output_memory(error);
    double started = milliseconds();
    hdr_status status = output ? hdr_chain_run(chain, input, output, NULL, error) : error->status;
    *time = milliseconds() - started;
    hdr_output_free(output);
    return status;
}

/* Of all pixels; or of those to compare at, as if it were all. */
static hdr_status run_part(const measuring *m, const bench_way *way, hdr_chain *chain, double *time, hdr_error *error) {
    bool some = way->estimated;
    int count = some ? m->pixels.count : 0;
    hdr_surround *seen = hdr_chain_surround(chain, m->input, count, m->pixels.pixel, NULL, error);
    if (seen) *time = some ? time_of_all(m, way, seen->milliseconds) : seen->milliseconds;
    hdr_surround_free(seen);
    return seen ? HDR_OK : error->status;
}

static hdr_status run_way(measuring *m, bench_way *way, timing *t, hdr_error *error) {
    int at = way->repetitions;
    double started = milliseconds();
    hdr_status status = way->estimated ? HDR_OK : run_whole(t->whole, m->input, &t->whole_time[at], error);
    if (status == HDR_OK && t->part) status = run_part(m, way, t->part, &t->own_time[at], error);
    t->spent += milliseconds() - started;
    way->repetitions++;
    return status;
}

static int compare_times(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

/* Of count > 0 times, which are put in order. */
static double median(double *times, int count) {
    qsort(times, (size_t)count, sizeof *times, compare_times);
    return (times[(count - 1) / 2] + times[count / 2]) / 2;
}

/* What is not measured takes as long around the surround as what is. */
static void infer_whole_times(bench *b) {
    double around[BENCH_WAYS];
    int measured = 0;
    for (int i = 0; i < b->count; i++)
        if (!b->way[i].estimated) around[measured++] = b->way[i].whole - b->way[i].own;
    for (int i = 0; i < b->count; i++)
        if (b->way[i].estimated) b->way[i].whole = b->way[i].own + (measured ? median(around, measured) : 0);
}

/* All ways take turns. */
static hdr_status measure_times(measuring *m, hdr_error *error) {
    bench *b = &m->b;
    for (int r = 0; r < b->repetitions; r++)
        for (int i = 0; i < b->count; i++) {
            if (b->way[i].repetitions > 0 && m->timing[i].spent > b->limit) continue;
            hdr_status status = run_way(m, &b->way[i], &m->timing[i], error);
            if (status != HDR_OK) return status;
        }
    for (int i = 0; i < b->count; i++) {
        bench_way *way = &b->way[i];
        if (!way->estimated) way->whole = median(m->timing[i].whole_time, way->repetitions);
        if (m->timing[i].part) way->own = median(m->timing[i].own_time, way->repetitions);
    }
    infer_whole_times(b);
    return HDR_OK;
}

/* ---- In all ---- */

/* The one that the others are compared with comes last in what is shown. */
static void put_first_last(bench *b) {
    bench_way first = b->way[0];
    memmove(b->way, b->way + 1, (size_t)(b->count - 1) * sizeof *b->way);
    b->way[b->count - 1] = first;
}

static hdr_status measure(measuring *m, hdr_error *error) {
    bench *b = &m->b;
    hdr_status status = hdr_input_picture(m->input, m->chain, &b->picture, error);
    if (status == HDR_OK) status = find_state(m, error);
    if (status == HDR_OK && b->varied) status = look_at_scene(m, error);
    if (b->varied) {
        b->verb = hdr_chain_clause(m->chain, b->varied)->name;
        bench_describe_surround(b);
    }
    if (status == HDR_OK) status = prepare_ways(m, error);
    if (status == HDR_OK && !b->varied) status = compare_pictures(m, error);
    if (status == HDR_OK) status = measure_times(m, error);
    if (status == HDR_OK) status = compare_codes(m, error);
    if (status == HDR_OK) put_first_last(b);
    return status;
}

/* The plot is asked for first: a name that cannot be is a mistake that must not wait for the measurements' end. */
static hdr_status measure_and_tell(measuring *m, hdr_error *error) {
    const char *name = hdr_chain_given(m->chain, 0, "plot");
    hdr_output *plot = name ? hdr_output_open(name, error) : NULL;
    if (!name || plot) m->input = hdr_input_open(m->b.file, error);
    m->b.chain = m->input ? hdr_chain_text(m->chain, error) : NULL;
    hdr_status status = m->b.chain ? measure(m, error) : error->status;
    if (status == HDR_OK && hdr_chain_settings(m->chain)->json)
        bench_print_json(&m->b);
    else if (status == HDR_OK && hdr_chain_given(m->chain, 0, "csv"))
        bench_print_csv(&m->b);
    else if (status == HDR_OK)
        bench_print_table(&m->b);
    if (status == HDR_OK && plot) status = bench_plot(&m->b, plot, error);
    hdr_input_free(m->input);
    hdr_output_free(plot);
    return status;
}

/* ---- The command line ---- */

static hdr_status check(const hdr_chain *chain, hdr_error *error) {
    const hdr_settings *settings = hdr_chain_settings(chain);
    const hdr_verb_about *last = hdr_chain_last(chain);
    const char *const *files = hdr_chain_files(chain);
    if (last->kind == HDR_PROGRAM) return cmd_refuse(error, "bench: %s makes no picture", last->name);
    if (hdr_chain_joins(chain))
        return cmd_refuse(error, "bench: write what %s makes to a file first", hdr_chain_clause(chain, 1)->name);
    if (settings->reference) return cmd_refuse(error, "bench: it sets --reference itself: leave that out");
    if (settings->json && hdr_chain_given(chain, 0, "csv")) return cmd_refuse(error, "bench: either --csv or --json");
    if (files[0] && files[1])
        return cmd_refuse(error, "bench: one picture at a time: '%.200s' is one file too many", files[1]);
    int varied = bench_varied_clause(chain);
    return varied ? bench_check_given(chain, varied, error) : HDR_OK;
}

hdr_status cmd_bench(hdr_chain *chain, hdr_error *error) {
    hdr_status status = check(chain, error);
    measuring *m = status == HDR_OK ? calloc(1, sizeof *m) : NULL;
    if (!m) return status == HDR_OK ? cmd_out_of_memory(error) : status;
    const hdr_verb_about *last = hdr_chain_last(chain);
    const char *file = hdr_chain_files(chain)[0];
    m->chain = chain;
    m->samples = (int)cmd_number(chain, 0, "samples", 1e9);
    m->b = (bench){.file = file ? file : "-",
                   .threads = hdr_chain_settings(chain)->threads,
                   .repetitions = (int)cmd_number(chain, 0, "repetitions", 1),
                   .limit = cmd_number(chain, 0, "limit", 0) * 1e3,
                   .format = last->kind == HDR_FORMAT ? last->name : "png",
                   .varied = bench_varied_clause(chain)};
    status = measure_and_tell(m, error);
    for (int i = 0; i < BENCH_WAYS; i++)
        free_timing(&m->timing[i]);
    free(m->pixels.pixel);
    free(m->exact);
    free(m->b.chain);
    free(m);
    return status;
}

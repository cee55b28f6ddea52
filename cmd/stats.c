/* hdr stats: the facts of a scene, and of several together. */
#include "cmd.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- For people ---- */

static void print_count(const char *label, uint64_t count, uint64_t of) {
    printf("  %-18s %llu", label, (unsigned long long)count);
    if (of > 0) printf(" (%.4g %%)", 100.0 * (double)count / (double)of);
    putchar('\n');
}

static void print_value(const char *label, double value) {
    printf("  %-18s %.9g\n", label, value);
}

static void print_range(const char *label, double min, double max) {
    printf("  %-18s %.9g to %.9g\n", label, min, max);
}

static void print_counts(const hdr_stats *stats) {
    print_count("pixels", stats->pixels, 0);
    print_count("lit", stats->lit, stats->pixels);
    print_count("unlit but coloured", stats->unlit_colour, stats->pixels);
    print_count("negative values", stats->negative, 0);
    print_count("NaN repaired", stats->nan, 0);
    print_count("+Inf repaired", stats->positive_infinity, 0);
    print_count("-Inf repaired", stats->negative_infinity, 0);
}

static void print_planes(const hdr_stats *stats) {
    for (int plane = 0; plane < 4; plane++) {
        bool there = plane == 3 ? stats->picture.has_alpha : plane < stats->picture.planes;
        if (there) print_range(cmd_plane_name(&stats->picture, plane), stats->min[plane], stats->max[plane]);
    }
}

static void print_luminance(const hdr_stats *stats) {
    print_range("luminance", stats->min_luminance, stats->max_luminance);
    print_value("smallest lit", stats->min_lit);
    print_value("log-average", stats->log_average);
    for (int i = 0; i < HDR_PERCENTILES; i++) {
        char label[32];
        snprintf(label, sizeof label, "percentile %g", stats->percentile_percent[i]);
        print_value(label, stats->percentile[i]);
    }
    printf("  %-18s %s\n", "grey", stats->grey ? "yes" : "no");
    printf("  %-18s %s\n", "opaque", stats->opaque ? "yes" : "no");
}

static void print_text(const hdr_stats *stats, const char *name) {
    cmd_print_plain(stdout, name);
    putchar('\n');
    cmd_print_picture(&stats->picture);
    print_counts(stats);
    print_planes(stats);
    print_luminance(stats);
}

static void print_text_together(const hdr_stats *stats, int files) {
    printf("%d files together\n", files);
    print_counts(stats);
    print_luminance(stats);
}

/* ---- For programs ---- */

static void print_json_planes(const char *key, const hdr_picture *picture, const double value[4]) {
    cmd_json_open(key, '{');
    for (int plane = 0; plane < 4; plane++) {
        bool there = plane == 3 ? picture->has_alpha : plane < picture->planes;
        if (there) cmd_json_number(cmd_plane_name(picture, plane), value[plane]);
    }
    cmd_json_close('}');
}

static void print_json_percentiles(const hdr_stats *stats) {
    cmd_json_open("percentiles", '{');
    for (int i = 0; i < HDR_PERCENTILES; i++) {
        char percent[32];
        snprintf(percent, sizeof percent, "%g", stats->percentile_percent[i]);
        cmd_json_number(percent, stats->percentile[i]);
    }
    cmd_json_close('}');
}

static void print_json_counts(const hdr_stats *stats) {
    cmd_json_integer("pixels", (long long)stats->pixels);
    cmd_json_integer("lit", (long long)stats->lit);
    cmd_json_integer("nan", (long long)stats->nan);
    cmd_json_integer("positive_infinity", (long long)stats->positive_infinity);
    cmd_json_integer("negative_infinity", (long long)stats->negative_infinity);
    cmd_json_integer("negative", (long long)stats->negative);
    cmd_json_integer("unlit_colour", (long long)stats->unlit_colour);
}

static void print_json_luminance(const hdr_stats *stats) {
    cmd_json_number("min_luminance", stats->min_luminance);
    cmd_json_number("max_luminance", stats->max_luminance);
    cmd_json_number("min_lit", stats->min_lit);
    cmd_json_number("log_average", stats->log_average);
    print_json_percentiles(stats);
    cmd_json_flag("grey", stats->grey);
    cmd_json_flag("opaque", stats->opaque);
}

/* of: how many files there are. */
static void print_json(const hdr_stats *stats, const char *name, int of) {
    cmd_json_open(NULL, '{');
    cmd_json_text("file", name);
    if (of > 1) cmd_json_integer("of", of);
    cmd_json_picture(&stats->picture);
    print_json_counts(stats);
    print_json_planes("min", &stats->picture, stats->min);
    print_json_planes("max", &stats->picture, stats->max);
    print_json_luminance(stats);
    cmd_json_end();
}

static void print_json_together(const hdr_stats *stats, int files) {
    cmd_json_open(NULL, '{');
    cmd_json_integer("files", files);
    print_json_counts(stats);
    print_json_luminance(stats);
    cmd_json_end();
}

static void print_stats(const hdr_chain *chain, const hdr_stats *stats, const char *name, int of) {
    if (hdr_chain_settings(chain)->json)
        print_json(stats, name, of);
    else
        print_text(stats, name);
}

/* ---- One file ---- */

static hdr_status stats_of_file(hdr_chain *chain, hdr_input *input, const char *name, hdr_error *error) {
    hdr_listener listener = cmd_listener(chain);
    hdr_stats stats;
    hdr_status status = hdr_chain_stats(chain, input, &stats, &listener, error);
    if (status == HDR_OK) print_stats(chain, &stats, name, 1);
    return status;
}

/* ---- Several files ---- */

typedef struct shot {
    hdr_chain *chain;
    const char *const *files;
    int count;
    hdr_input **kept; /* of each file: what cannot be read a second time, a pipe; else NULL */
    hdr_survey *survey;
} shot;

static bool is_pipe(const char *file) {
    struct stat about;
    return strcmp(file, "-") == 0 || (stat(file, &about) == 0 && !S_ISREG(about.st_mode));
}

/* A file's part of a round. In the first its own facts are printed. */
static hdr_status survey_file(shot *s, int index, bool first, hdr_error *error) {
    hdr_listener listener = cmd_listener(s->chain);
    hdr_stats stats;
    const char *file = s->files[index];
    bool keep = s->kept[index] || is_pipe(file);
    hdr_input *input = s->kept[index] ? s->kept[index] : hdr_input_open(file, error);
    if (!input) return error->status;
    hdr_status status = hdr_survey_take(s->survey, input, &stats, &listener, error);
    if (status == HDR_OK && first) print_stats(s->chain, &stats, file, s->count);
    if (keep)
        s->kept[index] = input;
    else
        hdr_input_free(input);
    return status;
}

/* Faults of single files are reported, and the rest goes on. Returns how many there were. */
static int survey_files(shot *s, bool first) {
    int faults = 0;
    for (int i = 0; i < s->count; i++) {
        hdr_error fault = {0};
        if (survey_file(s, i, first, &fault) == HDR_OK) continue;
        cmd_report(&fault);
        faults++;
    }
    return faults;
}

static hdr_status no_total(const shot *s, int faults) {
    fprintf(stderr, "hdr: no facts of all files together: %d of %d failed\n", faults, s->count);
    return HDR_DIFFERENT;
}

static hdr_status run_survey(shot *s, hdr_error *error) {
    hdr_stats together;
    bool first = true, more = true;
    for (; more; first = false) {
        int faults = survey_files(s, first);
        if (faults > 0) return no_total(s, faults);
        more = hdr_survey_next(s->survey, &together, error);
    }
    if (error->status != HDR_OK) return error->status;
    if (hdr_chain_settings(s->chain)->json)
        print_json_together(&together, s->count);
    else
        print_text_together(&together, s->count);
    return HDR_OK;
}

static hdr_status stats_of_files(hdr_chain *chain, int count, hdr_error *error) {
    shot s = {.chain = chain, .files = hdr_chain_files(chain), .count = count};
    s.kept = calloc((size_t)count, sizeof *s.kept);
    s.survey = hdr_survey_new(chain, error);
    hdr_status status = s.kept && s.survey ? run_survey(&s, error) : HDR_INTERNAL;
    if (!s.kept && error->status == HDR_OK) cmd_out_of_memory(error);
    hdr_survey_free(s.survey);
    for (int i = 0; s.kept && i < count; i++)
        hdr_input_free(s.kept[i]);
    free(s.kept);
    return status;
}

/* ---- hdr stats ---- */

hdr_status cmd_stats(hdr_chain *chain, hdr_error *error) {
    int count = 0;
    while (hdr_chain_files(chain)[count])
        count++;
    return count > 1 && !hdr_chain_joins(chain) ? stats_of_files(chain, count, error)
                                                : cmd_each_file(chain, stats_of_file, error);
}

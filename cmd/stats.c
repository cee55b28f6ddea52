/* hdr stats: the facts of a scene. */
#include "cmd.h"

#include <string.h>

/* ---- For people ---- */

static void print_count(const char *label, uint64_t count, uint64_t of) {
    printf("  %-18s %llu", label, (unsigned long long)count);
    if (of > 0) printf(" (%.4g %%)", 100.0 * (double)count / (double)of);
    putchar('\n');
}

static void print_value(const char *label, double value) {
    printf("  %-18s %.9g\n", label, value);
}

static void print_ranges(const hdr_stats *stats) {
    for (int plane = 0; plane < 4; plane++) {
        bool there = plane == 3 ? stats->picture.has_alpha : plane < stats->picture.planes;
        if (there)
            printf("  %-18s %.9g to %.9g\n", cmd_plane_name(&stats->picture, plane), stats->min[plane],
                   stats->max[plane]);
    }
    printf("  %-18s %.9g to %.9g\n", "luminance", stats->min_luminance, stats->max_luminance);
}

static void print_text(const hdr_stats *stats) {
    cmd_print_picture(&stats->picture);
    print_count("pixels", stats->pixels, 0);
    print_count("lit", stats->lit, stats->pixels);
    print_count("unlit but coloured", stats->unlit_colour, stats->pixels);
    print_count("negative values", stats->negative, 0);
    print_count("NaN repaired", stats->nan, 0);
    print_count("+Inf repaired", stats->positive_infinity, 0);
    print_count("-Inf repaired", stats->negative_infinity, 0);
    print_ranges(stats);
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

/* ---- For programs ---- */

static void print_json_count(const char *key, uint64_t count) {
    printf(", \"%s\": %llu", key, (unsigned long long)count);
}

static void print_json_value(const char *key, double value) {
    printf(", \"%s\": ", key);
    cmd_print_json_number(value);
}

static void print_json_planes(const char *key, const hdr_picture *picture, const double value[4]) {
    const char *between = "";
    printf(", \"%s\": {", key);
    for (int plane = 0; plane < 4; plane++) {
        bool there = plane == 3 ? picture->has_alpha : plane < picture->planes;
        if (!there) continue;
        printf("%s\"%s\": ", between, cmd_plane_name(picture, plane));
        cmd_print_json_number(value[plane]);
        between = ", ";
    }
    putchar('}');
}

static void print_json_percentiles(const hdr_stats *stats) {
    printf(", \"percentiles\": {");
    for (int i = 0; i < HDR_PERCENTILES; i++) {
        printf("%s\"%g\": ", i ? ", " : "", stats->percentile_percent[i]);
        cmd_print_json_number(stats->percentile[i]);
    }
    putchar('}');
}

static void print_json(const hdr_stats *stats, const char *name) {
    printf("{\"file\": ");
    cmd_print_json_text(name);
    printf(", ");
    cmd_print_picture_json(&stats->picture);
    print_json_count("pixels", stats->pixels);
    print_json_count("lit", stats->lit);
    print_json_count("nan", stats->nan);
    print_json_count("positive_infinity", stats->positive_infinity);
    print_json_count("negative_infinity", stats->negative_infinity);
    print_json_count("negative", stats->negative);
    print_json_count("unlit_colour", stats->unlit_colour);
    print_json_planes("min", &stats->picture, stats->min);
    print_json_planes("max", &stats->picture, stats->max);
    print_json_value("min_luminance", stats->min_luminance);
    print_json_value("max_luminance", stats->max_luminance);
    print_json_value("min_lit", stats->min_lit);
    print_json_value("log_average", stats->log_average);
    print_json_percentiles(stats);
    printf(", \"grey\": %s, \"opaque\": %s}\n", stats->grey ? "true" : "false", stats->opaque ? "true" : "false");
}

/* ---- hdr stats ---- */

static hdr_status print_stats(hdr_chain *chain, hdr_input *input, const char *name, hdr_error *error) {
    hdr_listener listener = cmd_listener(chain);
    hdr_stats stats;
    hdr_status status = hdr_chain_stats(chain, input, &stats, &listener, error);
    if (status != HDR_OK) return status;
    if (hdr_chain_settings(chain)->json) {
        print_json(&stats, name);
        return HDR_OK;
    }
    cmd_print_plain(stdout, name);
    putchar('\n');
    print_text(&stats);
    return HDR_OK;
}

hdr_status cmd_stats(hdr_chain *chain, hdr_error *error) {
    return cmd_each_file(chain, print_stats, error);
}

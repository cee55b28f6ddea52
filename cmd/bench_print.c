/* hdr bench: results as a table, as comma-separated values and as JSON. */
#include "bench.h"

#include <math.h>
#include <string.h>

void bench_describe_error(const bench *b, char *text, size_t size) {
    if (!b->varied)
        snprintf(text, size, "of components, relative to --reference");
    else if (b->all)
        snprintf(text, size, "of %s, %s, against --method " bench_exact ", at all %d lit pixels", b->what, b->unit,
                 b->random);
    else
        snprintf(text, size, "of %s, %s, against --method " bench_exact ", at %d random pixels and %d local extremes",
                 b->what, b->unit, b->random, b->extremes);
}

void bench_describe_times(const bench *b, char *text, size_t size) {
    size_t used = (size_t)snprintf(text, size, "%d thread%s; ", b->threads, b->threads == 1 ? "" : "s");
    if (b->repetitions == 1)
        snprintf(text + used, size - used, "one run each");
    else
        snprintf(text + used, size - used, "medians of up to %d runs", b->repetitions);
}

/* ---- For people ---- */

enum { COLUMNS = 9, CELL = 40 };

static void put_time(char *cell, const bench_way *way, double time) {
    int digits = time < 9.995 ? 2 : time < 99.95 ? 1 : 0;
    if (time < 0)
        snprintf(cell, CELL, "-");
    else
        snprintf(cell, CELL, "%s%.*f", way->estimated ? "~" : "", digits, time);
}

static void put_error(char *cell, double error) {
    if (error < 0)
        snprintf(cell, CELL, "-");
    else if (error == 0)
        snprintf(cell, CELL, "0");
    else
        snprintf(cell, CELL, "%.1e", error);
}

static void put_codes(char *share, char *most, const bench_way *way) {
    snprintf(share, CELL, "-");
    snprintf(most, CELL, "-");
    if (way->pixels_off < 0) return;
    snprintf(share, CELL, way->pixels_off == 0 ? "0" : way->pixels_off < 0.001 ? "%.0e" : "%.3f", way->pixels_off);
    snprintf(most, CELL, "%d", way->most_off);
}

static void fill_line(const bench_way *way, char line[COLUMNS][CELL]) {
    snprintf(line[0], CELL, "%s%s", way->automatic ? "* " : "  ", way->method);
    snprintf(line[1], CELL, "%s%s%s", way->option ? way->option : "", way->option ? " " : "",
             way->option ? way->value : "");
    put_time(line[2], way, way->whole);
    put_time(line[3], way, way->own);
    put_error(line[4], way->max_error);
    put_error(line[5], way->rms_error);
    put_error(line[6], way->bound);
    put_codes(line[7], line[8], way);
}

/* The first two columns are words, which begin at the left; the others are numbers. Nothing is shown of a column that
 * has no use. */
static void print_line(char line[COLUMNS][CELL], const int width[COLUMNS]) {
    int shown = 0;
    for (int c = 0; c < COLUMNS; c++) {
        if (width[c] == 0) continue;
        printf("%s%*s", shown++ ? "  " : "", c < 2 ? -width[c] : width[c], line[c]);
    }
    putchar('\n');
}

static void print_lines(const bench *b) {
    static const char *const titles[COLUMNS] = {"  method",  "setting", "whole ms",     "own ms",    "max error",
                                                "rms error", "bound",   "% pixels off", "by at most"};
    char line[BENCH_WAYS + 1][COLUMNS][CELL];
    int width[COLUMNS] = {0};
    for (int i = 0; i < b->count; i++)
        fill_line(&b->way[i], line[i + 1]);
    for (int c = 0; c < COLUMNS; c++) {
        bool of_methods = c == 1 || c == 3 || c == 6;
        snprintf(line[0][c], CELL, "%s", titles[c]);
        for (int i = 0; i <= b->count && (b->varied || !of_methods); i++)
            if (width[c] < (int)strlen(line[i][c])) width[c] = (int)strlen(line[i][c]);
    }
    for (int i = 0; i <= b->count; i++)
        print_line(line[i], width);
}

void bench_print_table(const bench *b) {
    char text[300];
    bool automatic = false, estimated = false;
    cmd_print_plain(stdout, strcmp(b->file, "-") == 0 ? "standard input" : b->file);
    printf("\n  %lld x %lld; %s, to %s\n", bench_width(b), bench_height(b), b->chain, b->format);
    bench_describe_times(b, text, sizeof text);
    printf("  times: %s\n", text);
    bench_describe_error(b, text, sizeof text);
    printf("  error: %s\n\n", text);
    print_lines(b);
    for (int i = 0; i < b->count; i++) {
        automatic |= b->way[i].automatic;
        estimated |= b->way[i].estimated;
    }
    if (automatic || estimated) putchar('\n');
    if (automatic) printf("  * what --method auto takes\n");
    if (estimated) printf("  ~ inferred, since it would take longer than --limit %g\n", b->limit * 1e-3);
    if (!b->codes)
        printf("  codes are not compared: --method " bench_exact " would take %.0f s\n",
               b->way[b->count - 1].own * 1e-3);
}

/* ---- For programs ---- */

/* What is known of a way; below 0 is what is not. */
enum { NUMBERS = 7 };
static const char *const number_names[NUMBERS] = {
    "whole_ms", "own_ms", "max_error", "rms_error", "bound", "pixels_off_percent", "largest_code_difference"};

static void find_numbers(const bench_way *way, double numbers[NUMBERS]) {
    const double found[NUMBERS] = {way->whole,
                                   way->own,
                                   way->max_error,
                                   way->rms_error,
                                   way->bound,
                                   way->pixels_off,
                                   way->pixels_off < 0 ? -1 : way->most_off};
    memcpy(numbers, found, sizeof found);
}

void bench_print_csv(const bench *b) {
    printf("method,option,value,automatic,inferred,repetitions");
    for (int n = 0; n < NUMBERS; n++)
        printf(",%s", number_names[n]);
    putchar('\n');
    for (int i = 0; i < b->count; i++) {
        const bench_way *way = &b->way[i];
        double numbers[NUMBERS];
        find_numbers(way, numbers);
        printf("%s,%s,%s,%d,%d,%d", way->method, way->option ? way->option : "", way->value ? way->value : "",
               way->automatic, way->estimated, way->repetitions);
        for (int n = 0; n < NUMBERS; n++) {
            putchar(',');
            if (numbers[n] >= 0) cmd_print_number(numbers[n]);
        }
        putchar('\n');
    }
}

static void print_json_way(const bench_way *way) {
    double numbers[NUMBERS];
    find_numbers(way, numbers);
    cmd_json_open(NULL, '{');
    cmd_json_text("method", way->method);
    cmd_json_text("option", way->option);
    cmd_json_text("value", way->value);
    cmd_json_flag("automatic", way->automatic);
    cmd_json_flag("inferred", way->estimated);
    cmd_json_integer("repetitions", way->repetitions);
    for (int n = 0; n < NUMBERS; n++)
        cmd_json_known(number_names[n], numbers[n]);
    cmd_json_close('}');
}

void bench_print_json(const bench *b) {
    char error[300];
    bench_describe_error(b, error, sizeof error);
    cmd_json_open(NULL, '{');
    cmd_json_text("file", b->file);
    cmd_json_integer("width", bench_width(b));
    cmd_json_integer("height", bench_height(b));
    cmd_json_text("chain", b->chain);
    cmd_json_text("format", b->format);
    cmd_json_text("varied", b->verb);
    cmd_json_text("error", error);
    cmd_json_integer("random_pixels", b->random);
    cmd_json_integer("local_extremes", b->extremes);
    cmd_json_integer("threads", b->threads);
    cmd_json_open("ways", '[');
    for (int i = 0; i < b->count; i++)
        print_json_way(&b->way[i]);
    cmd_json_close(']');
    cmd_json_end();
}

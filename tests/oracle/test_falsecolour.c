/* False colour against SPEC's rule, pixel by pixel, in long double. What the colours are is test_palette's matter: here
 * they are taken from a picture that has all of them. */
#include "check.h"
#include "oracle_png.h"
#include "oracle_renders.h"
#include "oracle_run.h"

#include <string.h>

enum { COLOURS = 256 };

static oracle_png run_png(const char *chain, const pictures *p) {
    hdr_error error = {0};
    oracle_png png = {0};
    size_t size = 0;
    hdr_output *output = oracle_run(chain, open_picture(p, 0), &error);
    CHECK(output != NULL, "%s: %s", chain, error.message);
    const void *bytes = output ? hdr_output_bytes(output, &size) : NULL;
    CHECK(output && oracle_read_png(bytes, size, &png), "%s: libpng reads it", chain);
    hdr_output_free(output);
    return png;
}

/* ---- The rule ---- */

typedef struct rule {
    const char *options;
    bool largest, logarithmic, symmetric;
    double from, to; /* NaN: auto */
    double percent;
} rule;

/* Y of a pixel, or the component farthest from 0. */
static long double value_of(const pictures *p, const rule *r, size_t i) {
    long double c[3];
    for (int plane = 0; plane < 3; plane++)
        c[plane] = (long double)p->numbers[0][(size_t)(p->planes == 1 ? 0 : plane) * pixels_of(p) + i];
    if (!r->largest) return 0.2126L * c[0] + 0.7152L * c[1] + 0.0722L * c[2];
    long double farthest = c[0];
    for (int plane = 1; plane < 3; plane++)
        if (fabsl(c[plane]) > fabsl(farthest)) farthest = c[plane];
    return farthest;
}

static int compare_values(const void *a, const void *b) {
    long double x = *(const long double *)a, y = *(const long double *)b;
    return x < y ? -1 : x > y;
}

/* The numbers that the range is found among: all values, or all components; with a logarithm those above 0. */
static size_t collect(const pictures *p, const rule *r, long double *numbers) {
    size_t count = 0, all = pixels_of(p) * (r->largest ? (size_t)p->planes : 1);
    for (size_t i = 0; i < all; i++) {
        long double number = r->largest ? (long double)p->numbers[0][i] : value_of(p, r, i);
        if (!r->logarithmic || r->largest || number > 0) numbers[count++] = number;
    }
    qsort(numbers, count, sizeof *numbers, compare_values);
    return count;
}

static void find_range(const pictures *p, const rule *r, long double *from, long double *to) {
    long double *numbers = malloc(3 * pixels_of(p) * sizeof *numbers);
    if (!numbers) abort();
    size_t count = collect(p, r, numbers);
    size_t rank = (size_t)ceill((100 - (long double)r->percent) * (long double)count / 100);
    *from = numbers[rank > 0 ? rank - 1 : 0];
    *to = numbers[(size_t)ceill((long double)r->percent * (long double)count / 100) - 1];
    for (size_t i = 0; r->logarithmic && i < count && *from <= 0; i++)
        *from = numbers[i];
    /* percentiles of luminance are of numbers rounded to float */
    if (!r->largest && r->percent < 100) *from = (long double)(float)*from, *to = (long double)(float)*to;
    if (r->symmetric) *to = fmaxl(fabsl(*from), fabsl(*to));
    if (r->symmetric && !isnan(r->from)) *to = -(long double)r->from;
    if (r->symmetric && !isnan(r->to)) *to = (long double)r->to;
    if (r->symmetric) *from = -*to;
    if (!r->logarithmic && !r->symmetric && *from > 0) *from = 0;
    if (!isnan(r->from)) *from = (long double)r->from;
    if (!isnan(r->to)) *to = (long double)r->to;
    free(numbers);
}

/* 256 times the part of the range below the value. */
static long double place_of(const rule *r, long double value, long double from, long double to) {
    if (r->logarithmic) return value > 0 ? COLOURS * (logl(value / from) / logl(to / from)) : -1;
    return COLOURS * ((value - from) / (to - from));
}

static int number_at(long double place) {
    return place < 0 ? 0 : place >= COLOURS - 1 ? COLOURS - 1 : (int)place;
}

/* ---- Pictures ---- */

/* All colours in order, of a map, from a ramp. */
static void read_palette(const char *options, uint16_t colours[COLOURS][3]) {
    pictures ramp = {COLOURS, 1, 1, 1, {malloc(COLOURS * sizeof(float))}};
    char chain[200];
    const char *map = strstr(options, "--map");
    for (int i = 0; ramp.numbers[0] && i < COLOURS; i++)
        ramp.numbers[0][i] = ((float)i + 0.5f) / COLOURS;
    snprintf(chain, sizeof chain, "falsecolour --from 0 --to 1 --no-legend %.*s : png",
             map ? (int)strcspn(map + 6, " ") + 6 : 0, map ? map : "");
    oracle_png png = run_png(chain, &ramp);
    CHECK(png.width == COLOURS && png.height == 1 && png.colours == 3, "%s: a row of colours", chain);
    if (png.samples && png.colours == 3) memcpy(colours, png.samples, COLOURS * sizeof *colours);
    free(png.samples);
    free_pictures(&ramp);
}

/* A value within rounding of the next colour may have that. */
static void compare_picture(const pictures *p, const rule *r, int scale) {
    uint16_t colours[COLOURS][3] = {{0}};
    char chain[300];
    long double from, to;
    snprintf(chain, sizeof chain, "falsecolour %s : png%s", r->options, scale > 1 ? " --bits 16" : "");
    read_palette(r->options, colours);
    find_range(p, r, &from, &to);
    oracle_png png = run_png(chain, p);
    bool legend = !strstr(r->options, "--no-legend");
    CHECK(png.width == (unsigned)p->width &&
              (legend ? png.height > (unsigned)p->height : png.height == (unsigned)p->height),
          "%s: %u x %u", chain, png.width, png.height);
    size_t wrong = 0, seen = 0;
    bool used[COLOURS] = {false};
    for (size_t i = 0; png.samples && i < pixels_of(p); i++) {
        long double place = place_of(r, value_of(p, r, i), from, to), slack = 1e-11L * (1 + fabsl(place));
        int least = number_at(place - slack), most = number_at(place + slack);
        bool right = false;
        for (int number = least; number <= most; number++) {
            bool same = true;
            for (int c = 0; c < 3; c++)
                same &= png.samples[3 * i + (size_t)c] == colours[number][c] * scale;
            right |= same;
        }
        wrong += !right;
        seen += !used[least];
        used[least] = true;
    }
    CHECK(wrong == 0, "%s, %d x %d, %d planes: %zu pixels are wrong", chain, p->width, p->height, p->planes, wrong);
    CHECK(seen > 8 || pixels_of(p) < 100 || p->numbers[0][0] == p->numbers[0][1], "%s: %zu colours are met", chain,
          seen);
    free(png.samples);
}

static double rendered(int picture, size_t at) {
    (void)picture;
    return exp(8 * random_unit() - 4) * (at % 97 == 5 ? 1000 : 1);
}

static double signed_error(int picture, size_t at) {
    (void)picture, (void)at;
    double u = random_unit() - 0.4;
    return u * u * u;
}

static double constant(int picture, size_t at) {
    (void)picture, (void)at;
    return 0;
}

static void test_rule(void) {
    static const rule rules[] = {
        {"", .from = NAN, .to = NAN, .percent = 100},
        {"--map magma --of largest", .largest = true, .from = NAN, .to = NAN, .percent = 100},
        {"--map coolwarm --of largest", .largest = true, .symmetric = true, .from = NAN, .to = NAN, .percent = 100},
        {"--map coolwarm --percentile 95", .symmetric = true, .from = NAN, .to = NAN, .percent = 95},
        {"--map coolwarm --to 0.4", .symmetric = true, .from = NAN, .to = 0.4, .percent = 100},
        {"--map coolwarm --from -2", .symmetric = true, .from = -2, .to = NAN, .percent = 100},
        {"--percentile 99.5 --no-legend", .from = NAN, .to = NAN, .percent = 99.5},
        {"--percentile 90 --of largest", .largest = true, .from = NAN, .to = NAN, .percent = 90},
        {"--scale log --map inferno", .logarithmic = true, .from = NAN, .to = NAN, .percent = 100},
        {"--scale log --percentile 97", .logarithmic = true, .from = NAN, .to = NAN, .percent = 97},
        {"--scale log --of largest --map plasma", .logarithmic = true, .largest = true, .from = NAN, .to = NAN,
         .percent = 100},
        {"--from 0.1 --to 2.5", .from = 0.1, .to = 2.5, .percent = 100},
        {"--from -0.25", .from = -0.25, .to = NAN, .percent = 100},
        {"--scale log --to 3", .logarithmic = true, .from = NAN, .to = 3, .percent = 100},
    };
    static const int sizes[][3] = {{64, 41, 3}, {301, 7, 3}, {130, 40, 1}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        pictures render = make_pictures(sizes[s][0], sizes[s][1], sizes[s][2], 1, rendered);
        pictures error = make_pictures(sizes[s][0], sizes[s][1], sizes[s][2], 1, signed_error);
        for (size_t r = 0; r < sizeof rules / sizeof *rules; r++) {
            compare_picture(&render, &rules[r], 1);
            compare_picture(&error, &rules[r], r % 2 ? 257 : 1);
        }
        free_pictures(&render);
        free_pictures(&error);
    }
}

/* A picture of one value has the range that the manual tells, whatever the scale. */
static void test_constant(void) {
    static const struct {
        const char *options;
        float value;
        int number;
    } cases[] = {{"", 0, 0},
                 {"", 4, 255},
                 {"", -4, 0},
                 {"--map coolwarm", 0, COLOURS / 2},
                 {"--map coolwarm", 3, 255},
                 {"--scale log", 0, 0},
                 {"--scale log", 7, 0},
                 {"--from 2", 1, 0},
                 {"--to 2", 9, 255},
                 {"--scale log --from 5", 1, 0}};
    pictures p = make_pictures(12, 9, 3, 1, constant);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        uint16_t colours[COLOURS][3] = {{0}};
        char chain[200];
        for (size_t i = 0; i < 3 * pixels_of(&p); i++)
            p.numbers[0][i] = cases[k].value;
        snprintf(chain, sizeof chain, "falsecolour %s : png", cases[k].options);
        read_palette(cases[k].options, colours);
        oracle_png png = run_png(chain, &p);
        CHECK(png.samples && !memcmp(png.samples, colours[cases[k].number], sizeof colours[0]),
              "%s of %g: not colour %d", chain, (double)cases[k].value, cases[k].number);
        free(png.samples);
    }
    free_pictures(&p);
}

int main(void) {
    test_rule();
    test_constant();
    return check_done("test_falsecolour");
}

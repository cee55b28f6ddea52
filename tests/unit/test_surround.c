/* What others can see of a local verb's surround, against the sum as it is defined; and chains that are made of others.
 */
#include "check.h"
#include "hdrpipe.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDE = 23, HIGH = 17, PIXELS = WIDE * HIGH };
#define SIGMA_S 2.5
#define SIGMA_R 0.4

/* A ramp of four decades with an edge, a firefly and pixels that are not lit. */
static void make_scene(float *y) {
    for (int i = 0; i < PIXELS; i++)
        y[i] = powf(10, (float)(i % WIDE) * 4 / WIDE - 2) * (i / WIDE > 8 ? 30.0F : 1.0F);
    y[5 * WIDE + 7] = 60000;
    y[3] = 0;
    y[12 * WIDE + 20] = -1;
}

/* The base layer of a pixel as durand's page defines it, with a window that is the picture. */
static double base_of(const float *y, int x, int row) {
    double least = INFINITY, sum = 0, weights = 0;
    for (int i = 0; i < PIXELS; i++)
        if (y[i] > 0) least = fmin(least, (double)y[i]);
    double own = log10(fmax((double)y[row * WIDE + x], least));
    for (int v = 0; v < HIGH; v++)
        for (int u = 0; u < WIDE; u++) {
            double i = log10(fmax((double)y[v * WIDE + u], least)), far = (u - x) * (u - x) + (v - row) * (v - row);
            double weight = exp(-far / (2 * SIGMA_S * SIGMA_S)) * exp(-(i - own) * (i - own) / (2 * SIGMA_R * SIGMA_R));
            sum += weight * i;
            weights += weight;
        }
    return sum / weights;
}

static hdr_input *open_scene(const float *y) {
    const float *planes[3] = {y, NULL, NULL};
    hdr_error error = {0};
    hdr_input *input = hdr_input_planes(WIDE, HIGH, 1, planes, NULL, &error);
    if (!input) abort();
    return input;
}

/* A chain of one clause, in words up to a NULL. */
static hdr_chain *chain_of(const char *const words[]) {
    hdr_error error = {0};
    hdr_chain *chain = hdr_chain_new(&error);
    int count = 0;
    while (words[count])
        count++;
    if (!chain) abort();
    CHECK(hdr_chain_add(chain, words, count, &error) == HDR_OK, "%s: %s", words[0], error.message);
    return chain;
}

/* ---- Surrounds ---- */

static void check_method(const float *y, hdr_input *input, const char *const words[], bool partly) {
    hdr_error error = {0};
    const hdr_pixel some[] = {{0, 0}, {3, 0}, {7, 5}, {WIDE - 1, HIGH - 1}, {20, 12}, {7, 5}};
    enum { SOME = sizeof some / sizeof *some };
    hdr_chain *chain = chain_of(words);
    hdr_surround *all = hdr_chain_surround(chain, input, 0, NULL, NULL, &error);
    hdr_surround *part = hdr_chain_surround(chain, input, SOME, some, NULL, &error);
    CHECK(all && part, "%s: %s", words[2], error.message);
    if (!all || !part) abort();
    CHECK(all->width == WIDE && all->height == HIGH && part->width == WIDE, "its size");
    CHECK(!all->partial && part->partial == partly, "%s: partial", words[2]);
    CHECK(all->luminance && !part->luminance, "luminance");
    CHECK(all->method[0] && !strcmp(all->method, part->method), "how: %s, %s", all->method, part->method);
    CHECK(all->milliseconds >= 0 && part->milliseconds >= 0, "times");
    for (int i = 0; i < PIXELS; i++) {
        double off = fabs((double)all->values[i] - base_of(y, i % WIDE, i / WIDE));
        CHECK(!(y[i] > 0) || off <= all->bound + 1e-6, "%s: pixel %d is off by %g, beyond %g", words[2], i, off,
              all->bound);
        float lit = y[i] > 0 ? y[i] : 0;
        CHECK(memcmp(&all->luminance[i], &lit, sizeof lit) == 0, "luminance of pixel %d", i);
    }
    for (int i = 0; i < SOME; i++) {
        int at = some[i].y * WIDE + some[i].x;
        CHECK(!(y[at] > 0) || memcmp(&part->values[i], &all->values[at], sizeof(float)) == 0, "%s: pixel %d by itself",
              words[2], i);
    }
    hdr_surround_free(all);
    hdr_surround_free(part);
    hdr_chain_free(chain);
}

static void test_durand(const float *y, hdr_input *input) {
    check_method(y, input, (const char *const[]){"durand", "--method", "exact", "--sigma-s", "2.5px", NULL}, true);
    check_method(y, input, (const char *const[]){"durand", "--method", "direct", "--sigma-s", "2.5px", NULL}, true);
    check_method(y, input, (const char *const[]){"durand", "--method", "grid", "--sigma-s", "2.5px", NULL}, false);
    check_method(y, input,
                 (const char *const[]){"durand", "--method", "grid", "--cells", "2x2.5", "--sigma-s", "2.5px", NULL},
                 false);
}

/* Nothing is computed, or cannot be. */
static void test_without(const float *y, hdr_input *input) {
    static const float black[PIXELS];
    static const struct {
        const char *words[3];
        bool dark;
        hdr_pixel pixel;
        hdr_status status;
    } cases[] = {{{"reinhard", NULL}, false, {0, 0}, HDR_OK},
                 {{"durand", NULL}, true, {0, 0}, HDR_OK},
                 {{"log", NULL}, false, {0, 0}, HDR_USAGE},
                 {{"durand", NULL}, false, {WIDE, 0}, HDR_USAGE},
                 {{"durand", NULL}, false, {0, -1}, HDR_USAGE}};
    (void)y;
    hdr_input *night = open_scene(black);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        hdr_error error = {0};
        hdr_chain *chain = chain_of(cases[i].words);
        hdr_surround *seen = hdr_chain_surround(chain, cases[i].dark ? night : input, 1, &cases[i].pixel, NULL, &error);
        CHECK(error.status == cases[i].status && (seen != NULL) == (error.status == HDR_OK), "case %zu: %d: %s", i,
              (int)error.status, error.message);
        CHECK(!seen || (!seen->values && seen->width == 0), "case %zu: values", i);
        hdr_surround_free(seen);
        hdr_chain_free(chain);
    }
    hdr_error error = {0};
    hdr_chain *empty = hdr_chain_new(&error);
    CHECK(!hdr_chain_surround(empty, input, 0, NULL, NULL, &error) && error.status == HDR_USAGE, "an empty chain");
    hdr_chain_free(empty);
    hdr_input_free(night);
}

/* The last clause's, behind others; and of reinhard what it has: no bound. */
static void test_last(const float *y, hdr_input *input) {
    hdr_error error = {0};
    hdr_chain *chain = chain_of((const char *const[]){"expose", "--ev", "1", NULL});
    hdr_chain_add(chain, (const char *const[]){"reinhard", "--local"}, 2, &error);
    hdr_surround *seen = hdr_chain_surround(chain, input, 0, NULL, NULL, &error);
    CHECK(seen && seen->values && seen->bound < 0 && !seen->partial, "reinhard: %s", error.message);
    for (int i = 0; seen && i < PIXELS; i++)
        CHECK(fabsf(seen->luminance[i] - 2 * fmaxf(y[i], 0)) <= 1e-6F * fabsf(y[i]), "exposed luminance %d", i);
    hdr_surround_free(seen);
    hdr_chain_free(chain);
}

/* ---- Chains made of others ---- */

static void expect_text(const hdr_chain *chain, const char *wanted) {
    hdr_error error = {0};
    char *text = hdr_chain_text(chain, &error);
    CHECK(text && !strcmp(text, wanted), "'%s' instead of '%s'", text ? text : error.message, wanted);
    free(text);
}

static void test_variations(void) {
    static const char *const words[] = {"expose", "--ev",    "1.5",  "then", "log", "--crop", "0,0,4,4",
                                        "--mode", "shifted", "-qj1", ":",    "png", "--bits", "16"};
    hdr_error error = {0};
    hdr_chain *chain = hdr_chain_new(&error);
    CHECK(hdr_chain_parse(chain, sizeof words / sizeof *words, words, &error) == HDR_OK, "%s", error.message);
    CHECK(!strcmp(hdr_chain_clause(chain, 1)->name, "expose") && !strcmp(hdr_chain_clause(chain, 3)->name, "png") &&
              !hdr_chain_clause(chain, 0) && !hdr_chain_clause(chain, 4) && !hdr_chain_clause(chain, -1),
          "clauses by number");
    CHECK(!strcmp(hdr_chain_given(chain, 1, "ev"), "1.5") && !hdr_chain_given(chain, 2, "k") &&
              !hdr_chain_given(chain, 0, "ev") && !hdr_chain_given(chain, 4, "ev") && !hdr_chain_given(chain, -1, "ev"),
          "options as they were given");
    hdr_chain *other = hdr_chain_new_like(chain, &error);
    const hdr_settings *settings = hdr_chain_settings(other);
    CHECK(settings->threads == 1 && settings->quiet && !hdr_chain_last(other), "common options");
    CHECK(hdr_chain_add_again(other, chain, 2, (const char *const[]){"--k", "2", "--strict"}, 3, &error) == HDR_OK,
          "%s", error.message);
    CHECK(hdr_chain_settings(other)->strict, "a common option behind its own");
    CHECK(hdr_chain_add_again(other, chain, 3, NULL, 0, &error) == HDR_OK, "%s", error.message);
    expect_text(other, "log --mode shifted --k 2 --crop 0,0,4,4 then png --bits 16");
    hdr_chain_free(other);
    static const char *const twice[] = {"--mode", "range"};
    hdr_chain *refused = hdr_chain_new_like(chain, &error);
    CHECK(hdr_chain_add_again(refused, chain, 2, twice, 2, &error) == HDR_USAGE, "an option twice");
    error = (hdr_error){0};
    CHECK(hdr_chain_add_again(refused, chain, 4, NULL, 0, &error) == HDR_USAGE, "no such clause");
    hdr_chain_free(refused);
    hdr_chain_free(chain);
}

static hdr_status parse(hdr_chain **chain, const char *const words[], int count) {
    hdr_error error = {0};
    *chain = hdr_chain_new(&error);
    return hdr_chain_parse(*chain, count, words, &error);
}

/* A program that stands in front of a chain. */
static void test_leader(const float *y, hdr_input *input) {
    hdr_chain *chain;
    CHECK(parse(&chain, (const char *const[]){"bench", "--csv", "--limit=3", "log", "--k", "2", "a.exr"}, 7) == HDR_OK,
          "bench in front");
    CHECK(!strcmp(hdr_chain_leader(chain)->name, "bench") && !strcmp(hdr_chain_last(chain)->name, "log") &&
              !strcmp(hdr_chain_clause(chain, 1)->name, "log") && !strcmp(hdr_chain_files(chain)[0], "a.exr"),
          "leader, chain and file");
    CHECK(!strcmp(hdr_chain_given(chain, 0, "csv"), "") && !strcmp(hdr_chain_given(chain, 0, "limit"), "3") &&
              !hdr_chain_given(chain, 0, "plot"),
          "its options");
    expect_text(chain, "log --k 2");
    /* runs do not know of it */
    hdr_error error = {0};
    hdr_stats stats;
    CHECK(hdr_chain_stats(chain, input, &stats, NULL, &error) == HDR_OK, "%s", error.message);
    hdr_chain_free(chain);
    static const struct {
        const char *words[6];
        hdr_status status;
    } cases[] = {{{"bench"}, HDR_USAGE},
                 {{"bench", "a.exr"}, HDR_USAGE},
                 {{"bench", "--csv"}, HDR_USAGE},
                 {{"bench", "then", "log"}, HDR_USAGE},
                 {{"bench", "bench", "log"}, HDR_USAGE},
                 {{"log", "then", "bench"}, HDR_USAGE},
                 {{"log", "then", "bench", "log"}, HDR_USAGE},
                 {{"bench", "--", "log"}, HDR_USAGE},
                 {{"bench", "--k", "2", "log"}, HDR_USAGE},
                 {{"bench", "log", "--csv"}, HDR_USAGE},
                 {{"bench", "--help"}, HDR_OK},
                 {{"bench", "-V"}, HDR_OK},
                 {{"bench", "log", "--help"}, HDR_OK},
                 {{"bench", "log", "-", "then", "png"}, HDR_OK}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int count = 0;
        while (count < 6 && cases[i].words[count])
            count++;
        hdr_status status = parse(&chain, cases[i].words, count);
        CHECK(status == cases[i].status, "case %zu: %d", i, (int)status);
        CHECK(status != HDR_OK || hdr_chain_last(chain), "case %zu: a last verb", i);
        hdr_chain_free(chain);
    }
    (void)y;
}

/* ---- Bytes of one's own ---- */

static void test_fill(void) {
    hdr_error error = {0};
    hdr_output *output = hdr_output_memory(&error);
    size_t size = 0;
    CHECK(hdr_output_fill(output, "some text", 9, &error) == HDR_OK, "%s", error.message);
    const char *bytes = hdr_output_bytes(output, &size);
    CHECK(size == 9 && bytes && !memcmp(bytes, "some text", 9), "what was filled in");
    CHECK(hdr_output_fill(output, "more", 4, &error) == HDR_INTERNAL, "an output that is whole");
    hdr_output_free(output);
}

int main(void) {
    float y[PIXELS];
    make_scene(y);
    hdr_input *input = open_scene(y);
    test_durand(y, input);
    test_without(y, input);
    test_last(y, input);
    test_variations();
    test_leader(y, input);
    test_fill();
    hdr_input_free(input);
    return check_done("test_surround");
}

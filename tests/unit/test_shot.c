/* Facts of a whole shot: the survey that finds them, against sums and percentiles that are computed here by sorting. */
#include "check.h"
#include "hdrpipe.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static uint64_t random_state = 1;

/* SplitMix64. */
static uint64_t random_bits(void) {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static double random_unit(void) {
    return (double)(random_bits() >> 11) * 0x1p-53;
}

/* ---- A survey ---- */

enum { PICTURES = 3, WIDTH = 1100, HEIGHT = 70 }; /* strips and blocks, and no whole number of either */

typedef struct picture {
    int width, height, planes;
    float *plane[3], *repaired[3];
} picture;

/* What is wrong in a picture, beside ordinary values. */
static float value_for(int number, size_t i) {
    uint64_t kind = random_bits() % 50;
    if (number == 1 && i == WIDTH * HEIGHT / 2) return INFINITY; /* met late: the sweep begins again */
    if (number == 2 && kind < 3) return kind == 0 ? NAN : kind == 1 ? -INFINITY : INFINITY;
    if (kind == 3) return 0;
    if (kind == 4) return -(float)random_unit();
    return (float)pow(10, random_unit() * 6 - 3 - number); /* each darker than the one before */
}

static picture make_picture(int number) {
    picture made = {.width = WIDTH - 17 * number, .height = HEIGHT - number, .planes = number == 2 ? 3 : 1};
    size_t pixels = (size_t)made.width * (size_t)made.height;
    for (int p = 0; p < made.planes; p++) {
        float largest = 0;
        made.plane[p] = malloc(pixels * sizeof(float));
        made.repaired[p] = malloc(pixels * sizeof(float));
        for (size_t i = 0; i < pixels; i++) {
            made.plane[p][i] = value_for(number, i);
            if (isfinite(made.plane[p][i])) largest = fmaxf(largest, made.plane[p][i]);
        }
        for (size_t i = 0; i < pixels; i++) {
            float value = made.plane[p][i];
            made.repaired[p][i] = isfinite(value) ? value : value > 0 ? largest : 0;
        }
    }
    return made;
}

static void free_picture(picture *made) {
    for (int p = 0; p < 3; p++) {
        free(made->plane[p]);
        free(made->repaired[p]);
    }
}

static hdr_input *open_picture(const picture *from, hdr_error *error) {
    return hdr_input_planes(from->width, from->height, from->planes, (const float *const *)from->plane, NULL, error);
}

/* What all pictures are together, by SPEC's words. */
typedef struct expected {
    float *lit; /* luminances, sorted */
    uint64_t pixels, lit_count, nan, positive_infinity, negative_infinity;
    double min, max, min_lit;
    long double log_sum;
} expected;

static int compare_floats(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static void expect_pixel(expected *all, const picture *from, size_t i) {
    double y = (double)from->repaired[0][i];
    if (from->planes == 3)
        y = 0.2126 * y + 0.7152 * (double)from->repaired[1][i] + 0.0722 * (double)from->repaired[2][i];
    all->pixels++;
    all->min = fmin(all->min, y);
    all->max = fmax(all->max, y);
    if (y > 0) {
        all->min_lit = fmin(all->min_lit, y);
        all->log_sum += logl((long double)y);
        all->lit[all->lit_count++] = fmaxf((float)y, 0x1p-149f);
    }
    for (int p = 0; p < from->planes; p++) {
        float value = from->plane[p][i];
        all->nan += isnan(value);
        all->positive_infinity += isinf(value) && value > 0;
        all->negative_infinity += isinf(value) && value < 0;
    }
}

static expected expect(const picture pictures[], int count) {
    expected all = {.min = INFINITY, .max = -INFINITY, .min_lit = INFINITY};
    all.lit = malloc((size_t)count * WIDTH * HEIGHT * sizeof(float));
    for (int n = 0; n < count; n++)
        for (size_t i = 0; i < (size_t)pictures[n].width * (size_t)pictures[n].height; i++)
            expect_pixel(&all, &pictures[n], i);
    qsort(all.lit, all.lit_count, sizeof(float), compare_floats);
    return all;
}

static void check_stats(const char *name, const hdr_stats *stats, const expected *all) {
    static const unsigned per_mille[HDR_PERCENTILES] = {1, 10, 50, 250, 500, 750, 950, 990, 999};
    CHECK(stats->pixels == all->pixels && stats->lit == all->lit_count, "%s: %llu pixels, %llu lit", name,
          (unsigned long long)stats->pixels, (unsigned long long)stats->lit);
    CHECK(stats->nan == all->nan && stats->positive_infinity == all->positive_infinity &&
              stats->negative_infinity == all->negative_infinity,
          "%s: repairs are counted wrongly", name);
    CHECK(stats->min_luminance == all->min && stats->max_luminance == all->max && stats->min_lit == all->min_lit,
          "%s: Y from %.17g to %.17g, lit from %.17g", name, stats->min_luminance, stats->max_luminance,
          stats->min_lit);
    double average = (double)expl(all->log_sum / (long double)all->lit_count);
    CHECK(fabs(stats->log_average / average - 1) < 1e-14, "%s: log-average %.17g, not %.17g", name, stats->log_average,
          average);
    for (int i = 0; i < HDR_PERCENTILES; i++) {
        uint64_t rank = (all->lit_count * per_mille[i] + 999) / 1000;
        double wanted = (double)all->lit[(rank ? rank : 1) - 1];
        CHECK(stats->percentile[i] == wanted && stats->percentile_percent[i] == per_mille[i] / 10.0,
              "%s: percentile %g is %.9g, not %.9g", name, stats->percentile_percent[i], stats->percentile[i], wanted);
    }
}

static void count_notes(void *context, hdr_message kind, const char *line) {
    (void)line;
    *(int *)context += kind == HDR_NOTE;
}

/* The facts of pictures together, taken with these words. each: of every single one. */
static hdr_status survey(const picture pictures[], int count, const char *words, hdr_stats *each, hdr_stats *together,
                         int *notes) {
    const char *word[] = {"stats", words};
    hdr_error error = {0};
    hdr_listener listener = {count_notes, notes};
    hdr_chain *chain = hdr_chain_new(&error);
    hdr_chain_add(chain, word, 2, &error);
    hdr_survey *of = hdr_survey_new(chain, &error);
    bool first = true, more = true;
    *notes = 0;
    for (; !error.status && more; first = false) {
        for (int i = 0; i < count; i++) {
            int n = first ? i : count - 1 - i; /* the order of later rounds does not matter */
            hdr_input *input = open_picture(&pictures[n], &error);
            hdr_survey_take(of, input, first ? &each[n] : NULL, &listener, &error);
            hdr_input_free(input);
        }
        more = hdr_survey_next(of, together, &error);
    }
    CHECK(error.status == HDR_OK, "%s: %s", words, error.message);
    hdr_survey_free(of);
    hdr_chain_free(chain);
    return error.status;
}

static void test_survey(void) {
    static const char *const settings[] = {"-j1", "-j3", "-j16", "--memory=1M", "--reference", "--no-skip"};
    picture pictures[PICTURES];
    for (int n = 0; n < PICTURES; n++)
        pictures[n] = make_picture(n);
    expected all = expect(pictures, PICTURES);
    hdr_stats first = {.pixels = 0};
    for (size_t s = 0; s < sizeof settings / sizeof *settings; s++) {
        hdr_stats each[PICTURES], together;
        int notes;
        if (survey(pictures, PICTURES, settings[s], each, &together, &notes)) continue;
        check_stats(settings[s], &together, &all);
        CHECK(notes == 2, "%s: %d notes about two pictures to be repaired", settings[s], notes);
        CHECK(!together.grey && together.opaque, "%s: one picture has colour, none an alpha", settings[s]);
        if (s == 0) first = together;
        CHECK(together.log_average == first.log_average, "%s: another log-average", settings[s]);
        for (int n = 0; n < PICTURES; n++) {
            expected own = expect(&pictures[n], 1);
            check_stats("one of three", &each[n], &own);
            CHECK(each[n].grey == (n < 2), "picture %d: grey or not", n);
            free(own.lit);
        }
    }
    hdr_stats one, together;
    int notes;
    if (!survey(pictures, 1, "-j2", &one, &together, &notes))
        CHECK(one.log_average == together.log_average &&
                  !memcmp(one.percentile, together.percentile, sizeof one.percentile),
              "a survey of one picture has that picture's facts");
    free(all.lit);
    for (int n = 0; n < PICTURES; n++)
        free_picture(&pictures[n]);
}

/* No facts of all where one is missing, or is not what it was. */
static void test_failing_survey(void) {
    picture good = make_picture(0), other = make_picture(0);
    hdr_stats together = {.pixels = 12345};
    for (int changed = 0; changed < 2; changed++) {
        hdr_error error = {0}, fault = {0};
        hdr_chain *chain = hdr_chain_new(&error);
        hdr_survey *of = hdr_survey_new(chain, &error);
        hdr_input *input = open_picture(&good, &error);
        hdr_input *bad = changed ? open_picture(&other, &error) : hdr_input_memory("no picture", 10, "text", &error);
        hdr_status status = hdr_survey_take(of, input, NULL, NULL, &error);
        CHECK(status == HDR_OK, "%s", error.message);
        if (changed) {
            CHECK(hdr_survey_next(of, &together, &error), "a second round is needed");
            for (int i = 0; i < WIDTH; i++)
                other.plane[0][i] = -1;
        }
        status = hdr_survey_take(of, bad, NULL, NULL, &fault);
        CHECK(status == (changed ? HDR_OK : HDR_BAD_DATA), "status %d: %s", (int)status, fault.message);
        while (hdr_survey_next(of, &together, &error))
            ;
        CHECK(error.status == HDR_BAD_DATA && strstr(error.message, changed ? "changed" : "missing") &&
                  together.pixels == 12345,
              "a survey that failed: %s", error.message);
        hdr_input_free(input);
        hdr_input_free(bad);
        hdr_survey_free(of);
        hdr_chain_free(chain);
    }
    free_picture(&good);
    free_picture(&other);
}

int main(void) {
    test_survey();
    test_failing_survey();
    return check_done("test_shot");
}

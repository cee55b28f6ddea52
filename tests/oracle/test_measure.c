/* Mean, difference and errors of pictures, against evaluations in long double that know nothing of blocks, threads and
 * lanes; and that neither threads nor the order of files matter more than they may. */
#include "check.h"

#include "oracle_renders.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* ---- Pictures ---- */

/* Renders of a scene of six decades, noisy, with fireflies. */
static double render(int picture, size_t at) {
    (void)picture;
    double scene = pow(10, (double)(at % 601) / 100 - 4);
    return random_unit() < 0.002 ? 1e4 * random_unit() : scene * (0.5 + random_unit());
}

/* Bright, with deviations in the last bits, which sums of squares lose. */
static double bright(int picture, size_t at) {
    (void)at;
    return 1e6 + 0.0625 * (picture % 3);
}

static double signed_small(int picture, size_t at) {
    (void)picture, (void)at;
    return 2e-3 * (random_unit() - 0.5);
}

/* ---- What the library makes ---- */

/* Runs a chain, in words up to a NULL, on all pictures in that order. The floats of a PFM, whose rows begin with the
 * last, pixel by pixel. */
static float *joined(const pictures *p, const int *order, const char *const words[]) {
    hdr_error error = {0};
    hdr_input *members[MOST];
    int count = 0;
    while (words[count])
        count++;
    for (int i = 0; i < p->count; i++)
        members[i] = open_picture(p, order ? order[i] : i);
    hdr_chain *chain = hdr_chain_new(&error);
    hdr_input *input = hdr_input_join(p->count, members, &error);
    hdr_output *output = hdr_output_memory(&error);
    if (!chain || !input || !output) abort();
    hdr_chain_parse(chain, count, words, &error);
    if (!error.status) hdr_chain_run(chain, input, output, NULL, &error);
    CHECK(error.status == HDR_OK, "%s: %s", words[0], error.message);
    size_t size = 0, numbers = pixels_of(p) * (size_t)p->planes * sizeof(float);
    const char *bytes = error.status ? NULL : hdr_output_bytes(output, &size);
    float *values = calloc(numbers, 1);
    if (bytes && size > numbers) memcpy(values, bytes + size - numbers, numbers);
    hdr_output_free(output);
    hdr_input_free(input);
    for (int i = 0; i < p->count; i++)
        hdr_input_free(members[i]);
    hdr_chain_free(chain);
    return values;
}

static float at(const float *values, const pictures *p, int plane, size_t pixel) {
    size_t y = pixel / (size_t)p->width, x = pixel % (size_t)p->width, row = (size_t)p->height - 1 - y;
    return values[(row * (size_t)p->width + x) * (size_t)p->planes + (size_t)plane];
}

/* ---- Moments ---- */

typedef struct moments {
    long double mean, variance;
    int count;
} moments;

static moments moments_of(const pictures *p, size_t number) {
    moments m = {0, 0, 0};
    for (int i = 0; i < p->count; i++)
        if (isfinite(p->numbers[i][number])) {
            m.mean += (long double)p->numbers[i][number];
            m.count++;
        }
    if (m.count == 0) return m;
    m.mean /= m.count;
    for (int i = 0; i < p->count; i++)
        if (isfinite(p->numbers[i][number])) {
            long double d = (long double)p->numbers[i][number] - m.mean;
            m.variance += d * d;
        }
    if (m.count > 1) m.variance /= m.count - 1;
    return m;
}

static float ulp_of(float value) {
    return nextafterf(fabsf(value), INFINITY) - fabsf(value);
}

static void check_moments(const pictures *p, const char *show, const char *what) {
    const char *const words[] = {"mean", "--show", show, "then", "pfm", "-j", "2", NULL};
    float *values = joined(p, NULL, words);
    unsigned long wrong = 0;
    double farthest = 0;
    for (int plane = 0; plane < p->planes; plane++)
        for (size_t pixel = 0; pixel < pixels_of(p); pixel++) {
            moments m = moments_of(p, (size_t)plane * pixels_of(p) + pixel);
            long double expected = !strcmp(show, "mean")            ? m.mean
                                   : !strcmp(show, "variance")      ? m.variance
                                   : !strcmp(show, "deviation")     ? sqrtl(m.variance)
                                   : !strcmp(show, "mean-variance") ? m.variance / m.count
                                                                    : sqrtl(m.variance / m.count);
            float value = at(values, p, plane, pixel);
            long double off = fabsl((long double)value - expected);
            farthest = fmax(farthest, (double)(off / fmaxl(fabsl(expected), FLT_MIN)));
            wrong += off > (long double)ulp_of((float)expected);
        }
    CHECK(wrong == 0, "%s of %d pictures, %s: %lu numbers are off by more than an ulp, up to %.3g", show, p->count,
          what, wrong, farthest);
    free(values);
}

static void test_moments(void) {
    static const char *const shows[] = {"mean", "variance", "deviation", "mean-variance", "mean-deviation"};
    static const struct {
        int width, height, planes, count;
        maker make;
        const char *what;
    } cases[] = {{37, 21, 3, 2, render, "renders"},     {37, 21, 3, 3, render, "renders"},
                 {530, 40, 3, 64, render, "renders"},   {1, 1, 1, 5, render, "a pixel"},
                 {600, 3, 1, 17, bright, "bright"},     {64, 64, 1, 64, bright, "bright"},
                 {65, 9, 3, 8, signed_small, "signed"}, {1, 700, 1, 4, render, "a column"}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        pictures p = make_pictures(cases[c].width, cases[c].height, cases[c].planes, cases[c].count, cases[c].make);
        for (size_t s = 0; s < sizeof shows / sizeof *shows; s++)
            check_moments(&p, shows[s], cases[c].what);
        free_pictures(&p);
    }
}

/* Numbers that are none do not spoil those of other renders; where no render has one, it is repaired to 0. */
static void test_strange(void) {
    pictures p = make_pictures(40, 30, 3, 4, render);
    p.numbers[0][7] = NAN;
    p.numbers[1][7] = INFINITY;
    p.numbers[2][1200] = -INFINITY;
    for (int i = 0; i < 4; i++)
        p.numbers[i][99] = i % 2 ? NAN : INFINITY;
    check_moments(&p, "mean", "with NaN and infinities");
    free_pictures(&p);
}

/* Another order of the files changes no more than the last bit; other threads nothing. */
static void test_order(void) {
    enum { COUNT = 20 };
    pictures p = make_pictures(300, 50, 3, COUNT, render);
    int order[COUNT];
    for (int i = 0; i < COUNT; i++)
        order[i] = (i * 7 + 3) % COUNT;
    const char *const one[] = {"mean", "then", "pfm", "-j", "1", NULL}, *const three[] = {"mean", "then", "pfm",
                                                                                          "-j",   "3",    NULL};
    float *a = joined(&p, NULL, one), *b = joined(&p, NULL, three), *c = joined(&p, order, three);
    size_t numbers = pixels_of(&p) * 3;
    CHECK(memcmp(a, b, numbers * sizeof *a) == 0, "threads change a mean");
    unsigned long wrong = 0;
    for (size_t n = 0; n < numbers; n++)
        wrong += fabsf(a[n] - c[n]) > ulp_of(a[n]);
    CHECK(wrong == 0, "%lu means change by more than an ulp with the order", wrong);
    free(a);
    free(b);
    free(c);
    free_pictures(&p);
}

/* The median of the groups' means; fireflies that are rarer than groups are outvoted. */
static int compare_numbers(const void *a, const void *b) {
    long double x = *(const long double *)a, y = *(const long double *)b;
    return (x > y) - (x < y);
}

static void check_robust(int count, int groups) {
    pictures p = make_pictures(90, 20, 3, count, render);
    char text[8];
    snprintf(text, sizeof text, "%d", groups);
    const char *const words[] = {"mean", "--robust", "median-of-means", "--groups", text, "then", "pfm", NULL};
    float *values = joined(&p, NULL, words);
    int used = groups < count ? groups : count;
    unsigned long wrong = 0;
    for (int plane = 0; plane < 3; plane++)
        for (size_t pixel = 0; pixel < pixels_of(&p); pixel++) {
            long double mean[MOST] = {0};
            int members[MOST] = {0};
            for (int i = 0; i < count; i++) {
                mean[i % used] += (long double)p.numbers[i][(size_t)plane * pixels_of(&p) + pixel];
                members[i % used]++;
            }
            for (int g = 0; g < used; g++)
                mean[g] /= members[g];
            qsort(mean, (size_t)used, sizeof *mean, compare_numbers);
            long double expected = used % 2 ? mean[used / 2] : (mean[used / 2 - 1] + mean[used / 2]) / 2;
            wrong += fabsl((long double)at(values, &p, plane, pixel) - expected) > (long double)ulp_of((float)expected);
        }
    CHECK(wrong == 0, "median of the means of %d groups of %d: %lu numbers are off", groups, count, wrong);
    free(values);
    free_pictures(&p);
}

/* ---- Differences ---- */

enum { SIGNED, ABSOLUTE, RELATIVE, SQUARED, SMAPE };

static long double difference(int kind, long double x, long double r, long double e) {
    long double d = x - r;
    return kind == SIGNED     ? d
           : kind == ABSOLUTE ? fabsl(d)
           : kind == RELATIVE ? fabsl(d) / (fabsl(r) + e)
           : kind == SQUARED  ? d * d
                              : fabsl(d) / (fabsl(x) + fabsl(r) + e);
}

static void test_differences(void) {
    static const char *const kinds[] = {"signed", "absolute", "relative", "squared", "smape"};
    pictures p = make_pictures(133, 41, 3, 2, render);
    for (int kind = SIGNED; kind <= SMAPE; kind++) {
        bool divides = kind == RELATIVE || kind == SMAPE;
        const char *const words[] = {"diff",
                                     "--kind",
                                     kinds[kind],
                                     "--exaggerate",
                                     "3",
                                     divides ? "--epsilon" : "then",
                                     divides ? "0.5" : "pfm",
                                     divides ? "then" : NULL,
                                     "pfm",
                                     NULL};
        float *values = joined(&p, NULL, words);
        unsigned long wrong = 0;
        for (int plane = 0; plane < 3; plane++)
            for (size_t pixel = 0; pixel < pixels_of(&p); pixel++) {
                size_t n = (size_t)plane * pixels_of(&p) + pixel;
                long double expected =
                    3 * difference(kind, (long double)p.numbers[0][n], (long double)p.numbers[1][n], 0.5L);
                wrong +=
                    fabsl((long double)at(values, &p, plane, pixel) - expected) > (long double)ulp_of((float)expected);
            }
        CHECK(wrong == 0, "--kind %s: %lu numbers are off", kinds[kind], wrong);
        free(values);
    }
    free_pictures(&p);
}

/* ---- Errors ---- */

static void check_figure(const char *name, double value, long double expected, const char *what) {
    long double off = fabsl((long double)value - expected);
    CHECK(off <= 1e-12L * fabsl(expected) + 1e-300L, "%s, %s: %.17g, should be %.17Lg", what, name, value, expected);
}

/* Of the numbers of planes first ... end-1. */
static void check_errors(const pictures *p, const hdr_errors *errors, int first, int end, long double e,
                         long double scale, const char *what) {
    long double n = 0, bias = 0, mae = 0, mse = 0, mrse = 0, mape = 0, smape = 0;
    for (size_t i = (size_t)first * pixels_of(p); i < (size_t)end * pixels_of(p); i++) {
        long double x = (long double)p->numbers[0][i], r = (long double)p->numbers[1][i];
        if (!isfinite(p->numbers[0][i]) || !isfinite(p->numbers[1][i])) continue;
        n++;
        bias += x - r;
        mae += fabsl(x - r);
        mse += (x - r) * (x - r);
        mrse += (x - r) * (x - r) / (r * r + e);
        mape += fabsl(x - r) / (fabsl(r) + e);
        smape += fabsl(x - r) / (fabsl(x) + fabsl(r) + e);
    }
    CHECK(errors->numbers == (uint64_t)n, "%s: %llu numbers, should be %.0Lf", what,
          (unsigned long long)errors->numbers, n);
    if (n == 0) return;
    /* what cancels is as exact as what it is the difference of */
    CHECK(fabsl((long double)errors->bias - bias / n) <= 1e-12L * scale, "%s, bias: %.17g, should be %.17Lg", what,
          errors->bias, bias / n);
    check_figure("mae", errors->mae, mae / n, what);
    check_figure("mse", errors->mse, mse / n, what);
    check_figure("rmse", errors->rmse, sqrtl(mse / n), what);
    check_figure("mrse", errors->mrse, mrse / n, what);
    check_figure("mape", errors->mape, mape / n, what);
    check_figure("smape", errors->smape, smape / n, what);
}

static void check_worst(const pictures *p, const hdr_comparison *c, const char *what) {
    long double worst = 0;
    for (size_t i = 0; i < (size_t)p->planes * pixels_of(p); i++) {
        long double d = fabsl((long double)p->numbers[0][i] - (long double)p->numbers[1][i]);
        if (isfinite(p->numbers[0][i]) && isfinite(p->numbers[1][i])) worst = fmaxl(worst, d);
    }
    CHECK((long double)c->worst == worst, "%s: the largest is %.17g, should be %.17Lg", what, c->worst, worst);
    if (c->worst_channel < 0) return;
    size_t i = (size_t)c->worst_channel * pixels_of(p) + (size_t)c->worst_y * (size_t)p->width + (size_t)c->worst_x;
    CHECK(c->worst_test == (double)p->numbers[0][i] && c->worst_reference == (double)p->numbers[1][i] &&
              fabs(c->worst_test - c->worst_reference) == c->worst,
          "%s: the worst pixel is not at %d,%d", what, c->worst_x, c->worst_y);
}

static hdr_comparison compare(const pictures *p, double epsilon, const char *threads) {
    hdr_error error = {0};
    hdr_comparison c;
    hdr_chain *chain = hdr_chain_new(&error);
    const char *const words[] = {"stats", "-j", threads, NULL};
    hdr_input *test = open_picture(p, 0), *reference = open_picture(p, 1);
    hdr_chain_parse(chain, 3, words, &error);
    if (!error.status) hdr_compare(chain, test, reference, epsilon, &c, &error);
    CHECK(error.status == HDR_OK, "%s", error.message);
    hdr_input_free(test);
    hdr_input_free(reference);
    hdr_chain_free(chain);
    return c;
}

static void check_comparison(pictures *p, double epsilon, const char *what) {
    hdr_comparison c = compare(p, epsilon, "1"), again = compare(p, epsilon, "3");
    uint64_t numbers = 0;
    for (int plane = 0; plane < p->planes; plane++) {
        check_errors(p, &c.channel[plane], plane, plane + 1, (long double)epsilon, (long double)c.channel[plane].mae,
                     what);
        numbers += c.channel[plane].numbers;
    }
    check_errors(p, &c.all, 0, p->planes, (long double)epsilon, (long double)c.all.mae, what);
    check_worst(p, &c, what);
    CHECK(c.left_out == (uint64_t)p->planes * pixels_of(p) - numbers, "%s: %llu are left out", what,
          (unsigned long long)c.left_out);
    CHECK(memcmp(&c.all, &again.all, sizeof c.all) == 0 && memcmp(c.channel, again.channel, sizeof c.channel) == 0 &&
              c.worst_x == again.worst_x && c.worst_y == again.worst_y && c.worst_channel == again.worst_channel,
          "%s: threads change figures", what);
    hdr_comparison_free(&c);
    hdr_comparison_free(&again);
}

static void test_errors(void) {
    static const int sizes[][3] = {{1, 1, 1}, {64, 64, 3}, {65, 130, 3}, {700, 33, 3}, {3, 900, 1}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        pictures p = make_pictures(sizes[s][0], sizes[s][1], sizes[s][2], 2, s % 2 ? render : signed_small);
        check_comparison(&p, s % 2 ? 0.01 : 1e-6, "noise");
        if (pixels_of(&p) > 10) {
            p.numbers[0][3] = NAN;
            p.numbers[1][3] = INFINITY;
            p.numbers[1][5] = -INFINITY;
            check_comparison(&p, 0.01, "with NaN and infinities");
        }
        memcpy(p.numbers[1], p.numbers[0], pixels_of(&p) * (size_t)p.planes * sizeof(float));
        check_comparison(&p, 0.01, "a picture and itself");
        free_pictures(&p);
    }
}

/* ---- Noise ---- */

/* The root mean variance of the means of `size` renders that follow each other, leaving out group `without` (-1: none);
 * relative: of differences divided by the root of mean^2 + e. */
static long double naive_rmv(const pictures *p, int size, int without, long double e, bool relative) {
    int groups = p->count / size;
    long double sum = 0, numbers = 0;
    for (size_t n = 0; n < pixels_of(p) * (size_t)p->planes; n++) {
        long double group[MOST], mean = 0, squares = 0, all = 0;
        bool finite = true;
        int used = 0;
        for (int i = 0; i < p->count; i++)
            finite &= isfinite(p->numbers[i][n]) != 0;
        if (!finite) continue;
        for (int g = 0; g < groups; g++) {
            group[g] = 0;
            for (int i = 0; i < size; i++)
                group[g] += (long double)p->numbers[g * size + i][n] / size;
            all += group[g] / groups;
            if (g == without) continue;
            mean += group[g];
            used++;
        }
        mean /= used;
        for (int g = 0; g < groups; g++)
            if (g != without) squares += (group[g] - mean) * (group[g] - mean) / (used - 1);
        sum += relative ? squares / (all * all + e) : squares;
        numbers++;
    }
    return numbers > 0 ? sqrtl(sum / numbers) : 0;
}

static void check_rmv(const pictures *p, int size, double e, bool relative, double rmv, double error) {
    int groups = p->count / size;
    long double expected = naive_rmv(p, size, -1, (long double)e, relative), mean = 0, squares = 0, without[MOST];
    CHECK(fabsl((long double)rmv - expected) <= 1e-12L * expected, "RMV of means of %d: %.17g, should be %.17Lg", size,
          rmv, expected);
    CHECK((error < 0) == (groups < 3), "means of %d: a standard error of %d groups", size, groups);
    if (groups < 3) return;
    for (int g = 0; g < groups; g++)
        mean += (without[g] = naive_rmv(p, size, g, (long double)e, relative)) / groups;
    for (int g = 0; g < groups; g++)
        squares += (without[g] - mean) * (without[g] - mean);
    expected = sqrtl(squares * (groups - 1) / groups);
    CHECK(fabsl((long double)error - expected) <= 1e-9L * expected, "its error, of %d groups: %.17g, should be %.17Lg",
          groups, error, expected);
}

static hdr_noise measure_noise(const pictures *p, const char *threads) {
    hdr_error error = {0};
    hdr_noise noise;
    hdr_input *inputs[MOST];
    hdr_chain *chain = hdr_chain_new(&error);
    const char *const words[] = {"stats", "-j", threads};
    for (int i = 0; i < p->count; i++)
        inputs[i] = open_picture(p, i);
    hdr_chain_parse(chain, 3, words, &error);
    hdr_measure_noise(chain, p->count, inputs, 0.02, true, &noise, &error);
    CHECK(error.status == HDR_OK, "%s", error.message);
    for (int i = 0; i < p->count; i++)
        hdr_input_free(inputs[i]);
    hdr_chain_free(chain);
    return noise;
}

/* In proportion to the standard deviation of a pixel, its planes together, and 1 on average. */
static void check_shares(const pictures *p, const float *share) {
    long double sum = 0, total = 0;
    size_t pixels = pixels_of(p), wrong = 0;
    long double *deviation = calloc(pixels, sizeof *deviation);
    for (size_t i = 0; i < pixels; i++) {
        for (int plane = 0; plane < p->planes; plane++)
            deviation[i] += moments_of(p, (size_t)plane * pixels + i).variance / p->planes;
        deviation[i] = sqrtl(deviation[i]);
        sum += deviation[i];
        total += (long double)share[i];
    }
    for (size_t i = 0; i < pixels; i++)
        wrong +=
            fabsl((long double)share[i] - deviation[i] * (long double)pixels / sum) > 1e-6L * (long double)share[i];
    CHECK(wrong == 0, "%zu shares of %zu are off", wrong, pixels);
    CHECK(fabsl(total / (long double)pixels - 1) < 1e-6L, "shares are %.9Lg on average", total / (long double)pixels);
    free(deviation);
}

static void check_noise(pictures *p, bool strange) {
    if (strange) p->numbers[1][3] = NAN, p->numbers[0][8] = INFINITY, p->numbers[p->count - 1][8] = -INFINITY;
    hdr_noise noise = measure_noise(p, "1"), again = measure_noise(p, "3");
    size_t numbers = pixels_of(p) * (size_t)p->planes;
    CHECK(noise.numbers == numbers - (strange ? 2 : 0) && noise.left_out == (strange ? 3 : 0),
          "%llu numbers, %llu left out", (unsigned long long)noise.numbers, (unsigned long long)noise.left_out);
    int levels = 0;
    for (int size = 1; p->count / size >= 2; size *= 2, levels++)
        check_rmv(p, size, 0.02, false, noise.level[levels].rmv, noise.level[levels].error);
    CHECK(noise.levels == levels, "%d sizes of groups, should be %d", noise.levels, levels);
    CHECK(noise.rmv == noise.level[0].rmv && noise.error == noise.level[0].error, "the first is of single renders");
    check_rmv(p, 1, 0.02, true, noise.relative, noise.relative_error);
    if (!strange) check_shares(p, noise.share);
    CHECK(noise.rmv == again.rmv && noise.error == again.error && noise.relative == again.relative &&
              memcmp(noise.share, again.share, pixels_of(p) * sizeof(float)) == 0,
          "threads change the noise");
    hdr_noise_free(&noise);
    hdr_noise_free(&again);
}

static void test_noise(void) {
    static const int cases[][4] = {{37, 21, 3, 2}, {37, 41, 3, 3}, {600, 17, 1, 8}, {20, 50, 3, 19}, {1, 1, 1, 4}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        pictures p = make_pictures(cases[c][0], cases[c][1], cases[c][2], cases[c][3], c % 2 ? render : signed_small);
        check_noise(&p, false);
        if (pixels_of(&p) > 20) check_noise(&p, true);
        free_pictures(&p);
    }
    pictures p = make_pictures(64, 20, 1, 10, bright);
    check_noise(&p, false);
    free_pictures(&p);
}

int main(void) {
    test_moments();
    test_strange();
    test_order();
    check_robust(20, 5);
    check_robust(7, 4);
    check_robust(3, 10);
    test_differences();
    test_errors();
    test_noise();
    return check_done("test_measure");
}

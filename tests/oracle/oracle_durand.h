/* For the oracle: SPEC's `durand`, term by term. The bilateral filter is its definition: two loops over pixels, two
 * over the window, which the picture's border alone cuts unless a picture is too big for that.
 *
 * A term's weight is exp of a double, right to 1e-14 in proportion wherever it matters; sums are long doubles. So a
 * base is within 1e-13 of the real one. */
#ifndef HDR_TESTS_ORACLE_DURAND_H
#define HDR_TESTS_ORACLE_DURAND_H

#include "oracle_picture.h"

#include <float.h>

/* Pixels that a window reaches, where it is not to reach all. */
enum { ORACLE_WHOLE = 100000 };

static double oracle_bilateral_at(const double *plane, int width, int height, double sigma_s, double sigma_r, int reach,
                                  int x, int y) {
    const double here = plane[(size_t)y * (size_t)width + (size_t)x];
    const double space = -0.5 / (sigma_s * sigma_s), range = -0.5 / (sigma_r * sigma_r);
    const int top = y > reach ? y - reach : 0, bottom = y + reach < height ? y + reach : height - 1;
    const int left = x > reach ? x - reach : 0, right = x + reach < width ? x + reach : width - 1;
    long double sum = 0, weights = 0;
    for (int j = top; j <= bottom; j++)
        for (int i = left; i <= right; i++) {
            double there = plane[(size_t)j * (size_t)width + (size_t)i], dx = i - x, dy = j - y, d = there - here;
            long double weight = exp(space * (dx * dx + dy * dy) + range * d * d);
            sum += weight * there;
            weights += weight;
        }
    return (double)(sum / weights);
}

static inline void oracle_bilateral(const double *plane, int width, int height, double sigma_s, double sigma_r,
                                    int reach, double *base) {
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            *base++ = oracle_bilateral_at(plane, width, height, sigma_s, sigma_r, reach, x, y);
}

/* ---- Options ---- */

typedef enum oracle_show { ORACLE_SHOW_PICTURE, ORACLE_SHOW_BASE, ORACLE_SHOW_DETAIL } oracle_show;

typedef struct oracle_durand_options {
    long double sigma_s; /* pixels, or a fraction of the larger side */
    bool in_pixels, own_intensity;
    long double sigma_r, contrast, saturation;
    char percentile[16];
    oracle_show show;
} oracle_durand_options;

/* Of "durand --option value ..."; those that say how to compute are passed over. */
static inline bool oracle_durand_parse(const char *text, oracle_durand_options *o) {
    char name[32], value[32];
    int length = 0;
    *o =
        (oracle_durand_options){.sigma_s = 0.02L, .sigma_r = 0.4L, .contrast = 5, .saturation = 1, .percentile = "0.1"};
    if (sscanf(text, "durand%n", &length) < 0 || length == 0) return false;
    for (text += length; sscanf(text, " %31s %31s%n", name, value, &length) == 2; text += length) {
        if (!strcmp(name, "--sigma-s")) {
            o->sigma_s = strtold(value, NULL);
            o->in_pixels = strstr(value, "px");
        } else if (!strcmp(name, "--sigma-r")) {
            o->sigma_r = strtold(value, NULL);
        } else if (!strcmp(name, "--contrast")) {
            o->contrast = strtold(value, NULL);
        } else if (!strcmp(name, "--saturation")) {
            o->saturation = strtold(value, NULL);
        } else if (!strcmp(name, "--percentile")) {
            snprintf(o->percentile, sizeof o->percentile, "%.15s", value);
        } else if (!strcmp(name, "--intensity")) {
            o->own_intensity = !strcmp(value, "durand");
        } else if (!strcmp(name, "--show")) {
            o->show = !strcmp(value, "base")     ? ORACLE_SHOW_BASE
                      : !strcmp(value, "detail") ? ORACLE_SHOW_DETAIL
                                                 : ORACLE_SHOW_PICTURE;
        } else if (strcmp(name, "--method") != 0 && strcmp(name, "--tolerance") != 0) {
            return false;
        }
    }
    return text[strspn(text, " ")] == '\0';
}

static inline double oracle_sigma_s(const oracle_durand_options *o, int width, int height) {
    return (double)(o->in_pixels ? o->sigma_s : o->sigma_s * (width > height ? width : height));
}

/* ---- The operator ---- */

typedef struct oracle_durand {
    const oracle_picture *picture;
    oracle_durand_options options;
    long double *intensity; /* I */
    bool *lit;
    double *logarithm, *base; /* i, of a pixel that is not lit the least; and what the filter makes of it */
    size_t lit_count;
    long double c, hi;
} oracle_durand;

/* Straight colour. */
static void oracle_straight(const oracle_picture *picture, size_t pixel, long double c[3]) {
    long double alpha = picture->plane[3] ? picture->plane[3][pixel] : 1;
    for (int p = 0; p < picture->planes; p++) {
        c[p] = picture->plane[p][pixel];
        if (alpha > 0) c[p] /= alpha;
    }
    if (picture->planes == 1) c[1] = c[2] = c[0];
}

static long double oracle_dot(const long double weights[3], const long double c[3]) {
    return weights[0] * c[0] + weights[1] * c[1] + weights[2] * c[2];
}

/* I of each pixel, and which are lit: Y > 0 and I > 0. */
static void oracle_take_intensity(oracle_durand *d) {
    static const long double rec709[3] = {0.2126L, 0.7152L, 0.0722L}, own[3] = {20 / 61.0L, 40 / 61.0L, 1 / 61.0L};
    const oracle_picture *picture = d->picture;
    oracle_weights weights = oracle_weights_of(picture);
    for (size_t i = 0; i < picture->pixels; i++) {
        long double c[3] = {0};
        oracle_straight(picture, i, c);
        bool grey = c[0] == c[1] && c[0] == c[2]; /* all weights add up to 1 */
        long double y = grey ? c[0] : oracle_dot(weights.rec709 ? rec709 : weights.row, c);
        d->intensity[i] = grey || !d->options.own_intensity ? y : oracle_dot(own, c);
        d->lit[i] = y > 0 && d->intensity[i] > 0;
        d->lit_count += d->lit[i];
    }
}

static void oracle_take_logarithms(oracle_durand *d) {
    long double least = INFINITY;
    for (size_t i = 0; i < d->picture->pixels; i++)
        if (d->lit[i] && d->intensity[i] < least) least = d->intensity[i];
    for (size_t i = 0; i < d->picture->pixels; i++)
        d->logarithm[i] = d->lit_count ? (double)log10l(d->lit[i] ? d->intensity[i] : least) : 0;
}

static int oracle_order_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The number of rank max(1, ceil(P N / 100)), P or, from the top, 100 - P being a decimal of a few digits. */
static double oracle_rank(const double *ascending, size_t count, const char *decimal, bool from_top) {
    unsigned long long digits = 0, hundred = 100;
    bool fraction = false;
    for (const char *c = decimal; *c; c++) {
        if (*c != '.') digits = digits * 10 + (unsigned)(*c - '0');
        if (fraction) hundred *= 10;
        fraction = fraction || *c == '.';
    }
    if (from_top) digits = hundred - digits;
    unsigned long long rank = (digits * count + hundred - 1) / hundred;
    return ascending[rank ? rank - 1 : 0];
}

/* c and hi, from the base of what is lit. */
static void oracle_compress(oracle_durand *d) {
    double *lit = oracle_alloc(d->lit_count, sizeof *lit);
    size_t count = 0;
    for (size_t i = 0; i < d->picture->pixels; i++)
        if (d->lit[i]) lit[count++] = d->base[i];
    qsort(lit, count, sizeof *lit, oracle_order_doubles);
    double lo = oracle_rank(lit, count, d->options.percentile, false);
    double hi = oracle_rank(lit, count, d->options.percentile, true);
    d->hi = hi;
    d->c = hi > lo ? fminl(1, log10l(d->options.contrast) / ((long double)hi - lo)) : 1;
    free(lit);
}

/* narrow: i as float has it, and I too: what a filter that works in float starts from. */
static inline oracle_durand oracle_durand_of(const oracle_picture *picture, const oracle_durand_options *options,
                                             int reach, bool narrow) {
    oracle_durand d = {.picture = picture, .options = *options};
    d.intensity = oracle_alloc(picture->pixels, sizeof *d.intensity);
    d.lit = oracle_alloc(picture->pixels, sizeof *d.lit);
    d.logarithm = oracle_alloc(picture->pixels, sizeof *d.logarithm);
    d.base = oracle_alloc(picture->pixels, sizeof *d.base);
    oracle_take_intensity(&d);
    oracle_take_logarithms(&d);
    for (size_t i = 0; narrow && i < picture->pixels; i++)
        d.logarithm[i] = (double)(float)log10((double)(float)pow(10, d.logarithm[i]));
    oracle_bilateral(d.logarithm, picture->width, picture->height,
                     oracle_sigma_s(options, picture->width, picture->height), (double)options->sigma_r, reach, d.base);
    if (d.lit_count) oracle_compress(&d);
    return d;
}

static inline void oracle_durand_free(oracle_durand *d) {
    free(d->intensity);
    free(d->lit);
    free(d->logarithm);
    free(d->base);
}

static inline long double oracle_durand_light(const oracle_durand *d, size_t pixel) {
    if (!d->lit[pixel]) return 0;
    long double base = d->base[pixel], detail = log10l(d->intensity[pixel]) - base;
    if (d->options.show == ORACLE_SHOW_BASE) return powl(10, base - d->hi);
    if (d->options.show == ORACLE_SHOW_DETAIL) return 0.18L * powl(10, detail);
    return powl(10, d->c * (base - d->hi) + detail);
}

/* Straight colour that comes out: C' = C (Ld / I), or max(C / I, 0)^s Ld, with 0^0 = 1. */
static inline void oracle_durand_colour(const oracle_durand *d, size_t pixel, long double c[3]) {
    long double ld = oracle_durand_light(d, pixel), s = d->options.saturation;
    oracle_straight(d->picture, pixel, c);
    for (int p = 0; p < 3; p++) {
        if (!d->lit[pixel]) {
            c[p] = 0;
        } else if (s == 1) {
            c[p] *= ld / d->intensity[pixel];
        } else {
            c[p] = powl(fmaxl(c[p] / d->intensity[pixel], 0), s) * ld;
        }
        if (fabsl(c[p]) > FLT_MAX) c[p] = copysignl(FLT_MAX, c[p]);
    }
}

#endif

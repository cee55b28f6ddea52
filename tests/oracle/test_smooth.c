/* hdr smooth against its formula: each pixel by four nested loops over window and patch, in long double, on pictures
 * with fireflies, noise-free areas, numbers that are not finite, and borders everywhere. */
#include "check.h"
#include "oracle_renders.h"
#include "oracle_run.h"
#include "spatial/nlmeans.h"

#include <float.h>
#include <unistd.h>

static char folder[] = "/tmp/hdr-smooth-XXXXXX";
static char sigma_file[64];

typedef struct setting {
    double k, above;
    int radius, patch;
} setting;

/* A picture, and its standard deviation: pictures 0 and 1. */
enum { PICTURE, SIGMA };

static long double number(const pictures *p, int which, int plane, int x, int y) {
    return (long double)p->numbers[which][(size_t)plane * pixels_of(p) + (size_t)y * (size_t)p->width + (size_t)x];
}

/* ---- The formula ---- */

static bool there(const pictures *p, int x, int y) {
    return x >= 0 && y >= 0 && x < p->width && y < p->height;
}

static bool finite_pixel(const pictures *p, int x, int y) {
    for (int c = 0; c < p->planes; c++)
        if (!isfinite(number(p, PICTURE, c, x, y))) return false;
    return true;
}

static long double squared(long double value) {
    return value * value;
}

static long double distance(const pictures *p, const setting *s, int c, int px, int py, int qx, int qy) {
    long double vp = squared(number(p, SIGMA, c, px, py)), vq = squared(number(p, SIGMA, c, qx, qy));
    long double top = squared(number(p, PICTURE, c, px, py) - number(p, PICTURE, c, qx, qy)) - (vp + fminl(vp, vq));
    long double bottom = squared((long double)s->k) * (vp + vq);
    return bottom > 0 ? top / bottom : top > 0 ? 1e1000L : 0;
}

static long double weight_of(const pictures *p, const setting *s, int px, int py, int qx, int qy) {
    long double sum = 0;
    int count = 0;
    for (int ny = -s->patch; ny <= s->patch; ny++)
        for (int nx = -s->patch; nx <= s->patch; nx++) {
            if (!there(p, px + nx, py + ny) || !there(p, qx + nx, qy + ny)) continue;
            count += p->planes;
            if (!finite_pixel(p, px + nx, py + ny) || !finite_pixel(p, qx + nx, qy + ny)) continue;
            for (int c = 0; c < p->planes; c++)
                sum += distance(p, s, c, px + nx, py + ny, qx + nx, qy + ny);
        }
    return expl(-fmaxl(0, sum / count));
}

typedef struct expected {
    bool filtered;
    long double value[3];
    long double spread[3]; /* the largest difference from a pixel of the window */
} expected;

static expected smooth_pixel(const pictures *p, const setting *s, int x, int y) {
    expected e = {.filtered = finite_pixel(p, x, y)};
    long double size = 0, noise = 0, weights = 0, sums[3] = {0};
    for (int c = 0; c < p->planes; c++) {
        size += fabsl(number(p, PICTURE, c, x, y)) / p->planes;
        noise = fmaxl(noise, number(p, SIGMA, c, x, y));
    }
    e.filtered = e.filtered && noise > (long double)s->above * size;
    for (int qy = y - s->radius; e.filtered && qy <= y + s->radius; qy++)
        for (int qx = x - s->radius; qx <= x + s->radius; qx++) {
            if (!there(p, qx, qy) || !finite_pixel(p, qx, qy)) continue;
            long double w = weight_of(p, s, x, y, qx, qy);
            weights += w;
            for (int c = 0; c < p->planes; c++) {
                sums[c] += w * number(p, PICTURE, c, qx, qy);
                e.spread[c] = fmaxl(e.spread[c], fabsl(number(p, PICTURE, c, qx, qy) - number(p, PICTURE, c, x, y)));
            }
        }
    for (int c = 0; c < p->planes; c++)
        e.value[c] = e.filtered ? sums[c] / weights : number(p, PICTURE, c, x, y);
    return e;
}

/* ---- Pictures ---- */

static int made_width = 1;

/* Two halves of other brightness, with a slope each, and noise whose size varies. Every 97th number is a firefly. The
 * lower right is free of noise. */
static double sigma_at(size_t at, size_t pixels) {
    size_t x = at % pixels % (size_t)made_width, y = at % pixels / (size_t)made_width;
    if (x > (size_t)made_width / 2 && y % 40 > 20) return 0;
    return at % 97 == 5 ? 3000 : 0.02 + 0.3 * (double)(at % 13) / 13;
}

static size_t made_pixels = 1;

static double make_scene(int picture, size_t at) {
    double sigma = sigma_at(at, made_pixels);
    if (picture == SIGMA) return (double)(float)sigma;
    size_t x = at % made_pixels % (size_t)made_width;
    double clean = (x > (size_t)made_width / 3 ? 2 : 0.5) + 0.004 * (double)x;
    return clean + 1.7 * sigma * (random_unit() + random_unit() - 1 + (at % 97 == 5));
}

static double make_constant(int picture, size_t at) {
    return picture == SIGMA ? 0.01 * (double)(at % 7) : 0.1;
}

static double make_noiseless(int picture, size_t at) {
    return picture == SIGMA ? 0 : make_scene(PICTURE, at);
}

static pictures make_pair(int width, int height, int planes, maker make) {
    made_width = width;
    made_pixels = (size_t)width * (size_t)height;
    return make_pictures(width, height, planes, 2, make);
}

/* What no render should hold, here and there. */
static void spoil(pictures *p) {
    size_t numbers = pixels_of(p) * (size_t)p->planes;
    static const float odd[] = {NAN, INFINITY, -INFINITY, -3, 0};
    for (size_t i = 0; i < numbers; i++)
        if (random_unit() < 0.03) p->numbers[PICTURE][i] = odd[(size_t)(random_unit() * 5)];
}

static void scale(pictures *p, int exponent) {
    for (int i = 0; i < 2; i++)
        for (size_t n = 0; n < pixels_of(p) * (size_t)p->planes; n++)
            p->numbers[i][n] = ldexpf(p->numbers[i][n], exponent);
}

/* ---- What the library makes ---- */

/* A PFM has its rows from the last to the first. */
static void write_sigma(const pictures *p, const float *numbers) {
    FILE *file = fopen(sigma_file, "wb");
    if (!file) abort();
    fprintf(file, "%s\n%d %d\n-1\n", p->planes == 3 ? "PF" : "Pf", p->width, p->height);
    for (int y = p->height - 1; y >= 0; y--)
        for (int x = 0; x < p->width; x++)
            for (int c = 0; c < p->planes; c++)
                fwrite(&numbers[(size_t)c * pixels_of(p) + (size_t)y * (size_t)p->width + (size_t)x], sizeof(float), 1,
                       file);
    if (fclose(file) != 0) abort();
}

/* The floats of the chain's PFM, ordered as the pictures' are. NULL, and a check that fails: it does not run. */
static float *run(const pictures *p, const setting *s, const char *more) {
    char line[ORACLE_LINE];
    hdr_error error = {0};
    snprintf(line, sizeof line,
             "smooth --sigma-picture %s --strength %.17g --above %.17g --radius %d --patch %d %s then pfm", sigma_file,
             s->k, s->above, s->radius, s->patch, more);
    hdr_output *output = oracle_run(line, open_picture(p, PICTURE), &error);
    CHECK(output, "%s: %s", line, error.message);
    if (!output) return NULL;
    size_t size = 0, numbers = pixels_of(p) * (size_t)p->planes;
    const char *bytes = hdr_output_bytes(output, &size);
    float *stored = malloc(numbers * sizeof(float)), *values = malloc(numbers * sizeof(float));
    if (!stored || !values || size < numbers * sizeof(float)) abort();
    memcpy(stored, bytes + size - numbers * sizeof(float), numbers * sizeof(float));
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++)
            for (int c = 0; c < p->planes; c++) {
                size_t row = (size_t)(p->height - 1 - y);
                values[(size_t)c * pixels_of(p) + (size_t)y * (size_t)p->width + (size_t)x] =
                    stored[(row * (size_t)p->width + (size_t)x) * (size_t)p->planes + (size_t)c];
            }
    hdr_output_free(output);
    free(stored);
    return values;
}

static double worst_of_bound, worst_of_spread;

static void check_pixel(const pictures *p, const setting *s, const char *what, int x, int y, const float *fast,
                        const float *reference) {
    expected e = smooth_pixel(p, s, x, y);
    hdr_nlmeans filter = {.k = s->k, .radius = s->radius};
    double bound = hdr_nlmeans_bound(&filter);
    for (int c = 0; c < p->planes; c++) {
        size_t at = (size_t)c * pixels_of(p) + (size_t)y * (size_t)p->width + (size_t)x;
        long double room = fabsl(e.value[c]) * 0x1p-24L + 0x1p-149L; /* of rounding to float */
        long double off = fabsl((long double)fast[at] - e.value[c]),
                    exact = fabsl((long double)reference[at] - e.value[c]);
        if (!e.filtered) {
            CHECK(!memcmp(&fast[at], &p->numbers[PICTURE][at], 4) && !memcmp(&reference[at], &fast[at], 4),
                  "%s: %d,%d has to stay %a, and is %a and %a", what, x, y, (double)p->numbers[PICTURE][at],
                  (double)fast[at], (double)reference[at]);
            continue;
        }
        CHECK(exact <= room + 1e-11L * e.spread[c], "%s --reference: %d,%d of %d: %.9Lg, and is %.9g", what, x, y, c,
              e.value[c], (double)reference[at]);
        CHECK(off <= room + (long double)bound * e.spread[c], "%s: %d,%d of %d: %.9Lg, and is %.9g", what, x, y, c,
              e.value[c], (double)fast[at]);
        double part = off > room && e.spread[c] > 0 ? (double)((off - room) / e.spread[c]) : 0;
        worst_of_spread = fmax(worst_of_spread, part);
        worst_of_bound = fmax(worst_of_bound, part / bound);
    }
}

/* Where a number is not finite the picture is repaired behind the filter: that is for others to test. */
static void check_picture(const pictures *p, const setting *s, const char *what) {
    write_sigma(p, p->numbers[SIGMA]);
    float *fast = run(p, s, "-j 2"), *reference = run(p, s, "--reference"), *forced = run(p, s, "-j 1 --no-skip");
    if (fast && reference && forced) {
        for (int y = 0; y < p->height; y++)
            for (int x = 0; x < p->width; x++)
                if (finite_pixel(p, x, y)) check_pixel(p, s, what, x, y, fast, reference);
        CHECK(!memcmp(fast, forced, pixels_of(p) * (size_t)p->planes * sizeof(float)), "%s: --no-skip", what);
    }
    free(fast);
    free(reference);
    free(forced);
}

static void test_formula(void) {
    static const struct {
        int width, height, planes;
        setting s;
    } cases[] = {{1, 1, 3, {0.45, 0, 10, 3}},   {5, 3, 3, {0.45, 0, 10, 3}},    {32, 24, 3, {0.45, 0, 10, 3}},
                 {32, 24, 1, {0.45, 0, 10, 3}}, {150, 70, 3, {0.45, 0, 3, 2}},  {131, 66, 1, {0.7, 0, 4, 1}},
                 {30, 20, 3, {0.1, 0, 4, 3}},   {30, 20, 3, {10, 0, 4, 3}},     {30, 20, 3, {0.45, 0, 5, 0}},
                 {30, 22, 1, {0.45, 0, 2, 10}}, {33, 40, 3, {0.45, 0.1, 4, 2}}, {3, 200, 3, {1, 0, 6, 2}},
                 {300, 2, 3, {1, 0, 6, 2}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (int variant = 0; variant < 4; variant++) {
            static const char *const variants[] = {"plain", "spoilt", "at 2^-100", "at 2^90"};
            char what[100];
            pictures p = make_pair(cases[i].width, cases[i].height, cases[i].planes, make_scene);
            if (variant == 1) spoil(&p);
            if (variant > 1) scale(&p, variant == 2 ? -100 : 90);
            snprintf(what, sizeof what, "%d x %d x %d, radius %d, patch %d, k %g, %s", p.width, p.height, p.planes,
                     cases[i].s.radius, cases[i].s.patch, cases[i].s.k, variants[variant]);
            check_picture(&p, &cases[i].s, what);
            free_pictures(&p);
        }
    printf("farthest from the formula: %.2g of the window's largest difference, %.2g of the bound\n", worst_of_spread,
           worst_of_bound);
}

/* ---- What has to stay ---- */

static void test_unchanged(void) {
    const setting s = {0.45, 0, 10, 3}, high = {10, 1e6, 10, 3};
    static const char *const ways[] = {"", "--no-skip", "--reference"};
    for (int w = 0; w < 3; w++)
        for (int i = 0; i < 3; i++) {
            maker makers[] = {make_constant, make_noiseless, make_scene};
            pictures p = make_pair(70, i == 0 ? 66 : 20, 3, makers[i]);
            write_sigma(&p, p.numbers[SIGMA]);
            float *values = run(&p, i == 2 ? &high : &s, ways[w]);
            CHECK(values && !memcmp(values, p.numbers[PICTURE], pixels_of(&p) * 3 * sizeof(float)),
                  "%s %s does not stay as it is",
                  i == 0   ? "a constant"
                  : i == 1 ? "no noise"
                           : "--above",
                  ways[w]);
            free(values);
            free_pictures(&p);
        }
}

/* Standard deviations that are none count as 0, of one channel as of three. */
static void test_unusable(void) {
    const setting s = {0.45, 0, 4, 2};
    pictures p = make_pair(60, 40, 3, make_scene), zero = make_pair(60, 40, 3, make_scene);
    memcpy(zero.numbers[PICTURE], p.numbers[PICTURE], pixels_of(&p) * 3 * sizeof(float));
    memcpy(zero.numbers[SIGMA], p.numbers[SIGMA], pixels_of(&p) * 3 * sizeof(float));
    for (size_t i = 0; i < pixels_of(&p) * 3; i += 11) {
        p.numbers[SIGMA][i] = i % 2 ? NAN : INFINITY;
        zero.numbers[SIGMA][i] = 0;
    }
    write_sigma(&p, p.numbers[SIGMA]);
    float *values = run(&p, &s, "");
    write_sigma(&p, zero.numbers[SIGMA]);
    float *wanted = run(&zero, &s, "");
    CHECK(values && wanted && !memcmp(values, wanted, pixels_of(&p) * 3 * sizeof(float)), "NaN is no deviation of 0");
    free(values);
    free(wanted);
    free_pictures(&p);
    free_pictures(&zero);
}

int main(void) {
    if (!mkdtemp(folder)) abort();
    snprintf(sigma_file, sizeof sigma_file, "%s/sigma.pfm", folder);
    test_formula();
    test_unchanged();
    test_unusable();
    unlink(sigma_file);
    rmdir(folder);
    return check_done("test_smooth");
}

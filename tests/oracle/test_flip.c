/* FLIP against its definition, pixel by pixel, in long double: filters of two dimensions, colours step by step through
 * XYZ, and the C library's functions. */
#include "check.h"
#include "oracle_renders.h"

#include <string.h>

#define PI 3.14159265358979323846264338327950288L

typedef struct shown {
    int width, height;
    long double (*rgb)[3]; /* linear, on the display */
} shown;

/* ---- Colours ---- */

static long double decoded(long double code) {
    long double c = fminl(fmaxl(code, 0), 1);
    return c <= 0.04045L ? c / 12.92L : powl((c + 0.055L) / 1.055L, 2.4L);
}

static const long double to_xyz[3][3] = {
    {10135552 / 24577794.0L, 8788810 / 24577794.0L, 4435075 / 24577794.0L},
    {2613072 / 12288897.0L, 8788810 / 12288897.0L, 887015 / 12288897.0L},
    {1425312 / 73733382.0L, 8788810 / 73733382.0L, 70074185 / 73733382.0L},
};

/* XYZ / white's. */
static void xyz_of(const long double rgb[3], long double xyz[3]) {
    for (int i = 0; i < 3; i++)
        xyz[i] = (to_xyz[i][0] * rgb[0] + to_xyz[i][1] * rgb[1] + to_xyz[i][2] * rgb[2]) /
                 (to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2]);
}

/* The other way: Cramer's rule, column by column. */
static long double determinant(long double m[3][3]) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

static void rgb_of(const long double xyz[3], long double rgb[3]) {
    long double whole[3][3], part[3][3];
    memcpy(whole, to_xyz, sizeof whole);
    for (int c = 0; c < 3; c++) {
        memcpy(part, to_xyz, sizeof part);
        for (int i = 0; i < 3; i++)
            part[i][c] = xyz[i] * (to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2]);
        rgb[c] = fminl(fmaxl(determinant(part) / determinant(whole), 0), 1);
    }
}

static void opponent_of(const long double rgb[3], long double opponent[3]) {
    long double xyz[3];
    xyz_of(rgb, xyz);
    opponent[0] = 116 * xyz[1] - 16;
    opponent[1] = 500 * (xyz[0] - xyz[1]);
    opponent[2] = 200 * (xyz[1] - xyz[2]);
}

static long double lab_curve(long double t) {
    return t > 216 / 24389.0L ? cbrtl(t) : t * (841 / 108.0L) + 4 / 29.0L;
}

static void hunt_of(const long double rgb[3], long double lab[3]) {
    long double xyz[3], f[3];
    xyz_of(rgb, xyz);
    for (int i = 0; i < 3; i++)
        f[i] = lab_curve(xyz[i]);
    lab[0] = 116 * f[1] - 16;
    lab[1] = 0.01L * lab[0] * 500 * (f[0] - f[1]);
    lab[2] = 0.01L * lab[0] * 200 * (f[1] - f[2]);
}

static long double distance_of(const long double a[3], const long double b[3]) {
    return powl(fabsl(a[0] - b[0]) + hypotl(a[1] - b[1], a[2] - b[2]), 0.7L);
}

/* ---- Filters ---- */

enum { WIDEST = 61 };

typedef struct filter {
    int reach;
    long double weight[WIDEST][WIDEST];
} filter;

static filter sensitivities[3], edge, point; /* edge, point: along x */

static long double sensitivity(int channel, long double square) {
    static const long double a[3][2] = {{1, 0}, {1, 0}, {34.1L, 13.5L}};
    static const long double b[3][2] = {{0.0047L, 1e-5L}, {0.0053L, 1e-5L}, {0.04L, 0.025L}};
    long double sum = 0;
    for (int i = 0; i < 2; i++)
        sum += a[channel][i] * sqrtl(PI / b[channel][i]) * expl(-PI * PI * square / b[channel][i]);
    return sum;
}

static void make_sensitivity(filter *f, int channel, long double ppd) {
    long double sum = 0;
    f->reach = (int)ceill(3 * sqrtl(0.04L / (2 * PI * PI)) * ppd);
    for (int y = -f->reach; y <= f->reach; y++)
        for (int x = -f->reach; x <= f->reach; x++)
            sum += f->weight[y + f->reach][x + f->reach] = sensitivity(channel, (x * x + y * y) / (ppd * ppd));
    for (int y = 0; y <= 2 * f->reach; y++)
        for (int x = 0; x <= 2 * f->reach; x++)
            f->weight[y][x] /= sum;
}

static void make_detector(filter *f, bool is_point, long double ppd) {
    long double s = 0.5L * 0.082L * ppd, positive = 0, negative = 0;
    f->reach = (int)ceill(3 * s);
    for (int y = -f->reach; y <= f->reach; y++)
        for (int x = -f->reach; x <= f->reach; x++) {
            long double g = expl(-(x * x + y * y) / (2 * s * s)), w = is_point ? (x * x / (s * s) - 1) * g : -x * g;
            f->weight[y + f->reach][x + f->reach] = w;
            *(w > 0 ? &positive : &negative) += fabsl(w);
        }
    for (int y = 0; y <= 2 * f->reach; y++)
        for (int x = 0; x <= 2 * f->reach; x++)
            f->weight[y][x] /= f->weight[y][x] > 0 ? positive : negative;
}

static int held(int at, int size) {
    return at < 0 ? 0 : at < size ? at : size - 1;
}

typedef long double colour[3];

/* The weighted sum around a pixel of what its neighbours have more than itself, transposed or not: for weights that add
 * up to 0 it is the sum itself, without what rounding would leave of it where all are equal. */
static long double filtered(const filter *f, const colour *in, int channel, int width, int height, int x, int y,
                            bool transposed) {
    long double sum = 0, own = in[(size_t)y * (size_t)width + (size_t)x][channel];
    for (int j = -f->reach; j <= f->reach; j++)
        for (int i = -f->reach; i <= f->reach; i++) {
            size_t at = (size_t)held(y + j, height) * (size_t)width + (size_t)held(x + i, width);
            sum +=
                f->weight[(transposed ? i : j) + f->reach][(transposed ? j : i) + f->reach] * (in[at][channel] - own);
        }
    return sum;
}

/* ---- LDR-FLIP ---- */

typedef struct features {
    colour lab;
    long double edges, points;
} features;

static features features_at(const colour *opponent, int width, int height, int x, int y) {
    long double left[3], xyz[3], rgb[3];
    features f;
    for (int c = 0; c < 3; c++)
        left[c] = opponent[(size_t)y * (size_t)width + (size_t)x][c] +
                  filtered(&sensitivities[c], opponent, c, width, height, x, y, false);
    xyz[1] = (left[0] + 16) / 116;
    xyz[0] = xyz[1] + left[1] / 500;
    xyz[2] = xyz[1] - left[2] / 200;
    rgb_of(xyz, rgb);
    hunt_of(rgb, f.lab);
    f.edges = hypotl(filtered(&edge, opponent, 0, width, height, x, y, false),
                     filtered(&edge, opponent, 0, width, height, x, y, true)) /
              116;
    f.points = hypotl(filtered(&point, opponent, 0, width, height, x, y, false),
                      filtered(&point, opponent, 0, width, height, x, y, true)) /
               116;
    return f;
}

static colour *opponents(const shown *s) {
    size_t count = (size_t)s->width * (size_t)s->height;
    colour *out = malloc(count * sizeof *out);
    if (!out) abort();
    for (size_t i = 0; i < count; i++)
        opponent_of(s->rgb[i], out[i]);
    return out;
}

/* Raises map. */
static void naive_ldr(const shown *test, const shown *reference, long double *map) {
    const long double green[3] = {0, 1, 0}, blue[3] = {0, 0, 1};
    long double green_lab[3], blue_lab[3];
    hunt_of(green, green_lab);
    hunt_of(blue, blue_lab);
    long double most = distance_of(green_lab, blue_lab), knee = 0.4L * most;
    colour *t = opponents(test), *r = opponents(reference);
    for (int y = 0; y < test->height; y++)
        for (int x = 0; x < test->width; x++) {
            features a = features_at(t, test->width, test->height, x, y);
            features b = features_at(r, test->width, test->height, x, y);
            long double d = distance_of(a.lab, b.lab);
            d = d < knee ? 0.95L / knee * d : 0.95L + (d - knee) / (most - knee) * 0.05L;
            long double f = sqrtl(fmaxl(fabsl(a.edges - b.edges), fabsl(a.points - b.points)) / sqrtl(2));
            long double *to = &map[(size_t)y * (size_t)test->width + (size_t)x];
            *to = fmaxl(*to, powl(d, 1 - f));
        }
    free(t);
    free(r);
}

/* ---- HDR-FLIP ---- */

static long double aces(long double x) {
    long double y = 0.6L * x;
    return fminl(y * (2.51L * y + 0.03L) / (y * (2.43L * y + 0.59L) + 0.14L), 1);
}

static int compare_numbers(const void *a, const void *b) {
    long double x = *(const long double *)a, y = *(const long double *)b;
    return (x > y) - (x < y);
}

typedef struct exposures {
    long double start, stop;
    int count;
} exposures;

/* Where the curve is 0.85, by bisection. */
static long double full_light(void) {
    long double low = 0, high = 100;
    for (int i = 0; i < 200; i++)
        *(aces((low + high) / 2) < 0.85L ? &low : &high) = (low + high) / 2;
    return low;
}

static exposures naive_exposures(const colour *light, size_t count) {
    long double *y = malloc(count * sizeof *y);
    if (!y) abort();
    for (size_t i = 0; i < count; i++)
        y[i] = 0.2126L * light[i][0] + 0.7152L * light[i][1] + 0.0722L * light[i][2];
    qsort(y, count, sizeof *y, compare_numbers);
    size_t unlit = 0;
    while (unlit < count && y[unlit] == 0)
        unlit++;
    exposures e = {0, 0, 1};
    if (unlit < count) {
        long double median = unlit > count / 2 ? y[unlit + (count - unlit) / 2] : y[count / 2];
        e.start = log2l(full_light() / y[count - 1]);
        e.stop = log2l(full_light() / median);
        e.count = (int)fmaxl(2, ceill(e.stop - e.start));
    }
    free(y);
    return e;
}

/* ---- Comparing ---- */

static colour *light_of(const hdr_planes *p) {
    size_t count = (size_t)p->width * (size_t)p->height;
    colour *light = malloc(count * sizeof *light);
    if (!light) abort();
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < 3; c++)
            light[i][c] = fmaxl((long double)p->plane[p->planes == 3 ? c : 0][i], 0);
    return light;
}

static shown show(const hdr_planes *p, const colour *light, hdr_flip_kind kind, bool encoded, long double stops) {
    size_t count = (size_t)p->width * (size_t)p->height;
    shown s = {p->width, p->height, malloc(count * sizeof *s.rgb)};
    if (!s.rgb) abort();
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < 3; c++) {
            long double v = light[i][c];
            s.rgb[i][c] = kind == HDR_FLIP_HDR ? aces(v * exp2l(stops)) : encoded ? decoded(v) : fminl(v, 1);
        }
    return s;
}

static long double *naive_flip(const hdr_planes *test, const hdr_planes *reference, hdr_flip_kind kind, bool encoded,
                               long double ppd, exposures *e) {
    size_t count = (size_t)test->width * (size_t)test->height;
    long double *map = calloc(count, sizeof *map);
    if (!map) abort();
    for (int c = 0; c < 3; c++)
        make_sensitivity(&sensitivities[c], c, ppd);
    make_detector(&edge, false, ppd);
    make_detector(&point, true, ppd);
    colour *t = light_of(test), *r = light_of(reference);
    *e = kind == HDR_FLIP_HDR ? naive_exposures(r, count) : (exposures){0, 0, 1};
    for (int i = 0; i < e->count; i++) {
        long double stops = e->start + (e->count > 1 ? i * (e->stop - e->start) / (e->count - 1) : 0);
        shown a = show(test, t, kind, encoded, stops), b = show(reference, r, kind, encoded, stops);
        naive_ldr(&a, &b, map);
        free(a.rgb);
        free(b.rgb);
    }
    free(t);
    free(r);
    return map;
}

static bool near(double value, long double wanted) {
    return fabsl((long double)value - wanted) <= 1e-12L * fabsl(wanted);
}

/* The value at which a sum over sorted numbers passes a part of the whole. */
static long double weighted(const long double *map, size_t count, long double share) {
    long double *sorted = malloc(count * sizeof *sorted), sum = 0, passed = 0;
    if (!sorted) abort();
    memcpy(sorted, map, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, compare_numbers);
    for (size_t i = 0; i < count; i++)
        sum += sorted[i];
    size_t at = 0;
    while (at < count - 1 && (passed += sorted[at]) <= share * sum)
        at++;
    long double value = sorted[at];
    free(sorted);
    return value;
}

static void check_figures(const hdr_flip *flip, const long double *map, size_t count, const char *what) {
    long double sum = 0, least = map[0], most = map[0];
    double farthest = 0;
    for (size_t i = 0; i < count; i++) {
        sum += map[i];
        least = fminl(least, map[i]);
        most = fmaxl(most, map[i]);
        farthest = fmax(farthest, fabs((double)((long double)flip->map[i] - map[i])));
    }
    CHECK(near(flip->mean, sum / (long double)count), "%s: mean %.17g, should be %.17Lg", what, flip->mean,
          sum / (long double)count);
    CHECK(near(flip->max, most), "%s: max %.17g, should be %.17Lg", what, flip->max, most);
    CHECK(near(flip->min, least), "%s: min %.17g, should be %.17Lg", what, flip->min, least);
    CHECK(farthest < 6e-8, "%s: a pixel of the map is off by %g", what, farthest);
    for (int q = 0; q < 3; q++) {
        long double wanted = weighted(map, count, 0.25L * (q + 1));
        CHECK(near(flip->quartile[q], wanted), "%s: quartile %d is %.17g, should be %.17Lg", what, q + 1,
              flip->quartile[q], wanted);
    }
    double sums = 0, pixels = 0;
    for (int i = 0; i < flip->tiles; i++) {
        sums += flip->tile[i].sum;
        pixels += flip->tile[i].pixels;
    }
    CHECK(near(sums / pixels, flip->mean) && pixels == (double)count, "%s: squares", what);
}

static hdr_chain *plain_chain(const char *threads) {
    hdr_error error = {0};
    hdr_chain *chain = hdr_chain_new(&error);
    const char *const words[] = {"stats", "-j", threads};
    hdr_chain_parse(chain, 3, words, &error);
    if (error.status) abort();
    return chain;
}

static hdr_flip flip_of(hdr_input *test, hdr_input *reference, hdr_flip_kind kind, double ppd, const char *threads,
                        int tests) {
    hdr_error error = {0};
    hdr_flip flip = {0};
    hdr_chain *chain = plain_chain(threads);
    hdr_flip_reference *prepared = hdr_flip_prepare(chain, reference, kind, ppd, tests, &error);
    for (int i = 0; prepared && i < tests; i++) {
        hdr_flip_free(&flip);
        hdr_flip_compare(prepared, test, true, &flip, &error);
    }
    CHECK(error.status == HDR_OK, "flip: %s", error.message);
    hdr_flip_reference_free(prepared);
    hdr_chain_free(chain);
    return flip;
}

static const double usual = 0.7 / 0.7 * 3840 * (double)PI / 180;

/* An input's pixels. */
static hdr_output *pixels_in(hdr_input *input) {
    hdr_error error = {0};
    hdr_chain *chain = plain_chain("1"), *none = hdr_chain_new_like(chain, &error);
    hdr_output *output = hdr_output_planes(&error);
    if (hdr_chain_run(none, input, output, NULL, &error) != HDR_OK) abort();
    hdr_chain_free(none);
    hdr_chain_free(chain);
    return output;
}

static void check_pair(hdr_input *test, hdr_input *reference, hdr_flip_kind kind, bool encoded, double ppd,
                       const char *what) {
    hdr_output *a = pixels_in(test), *b = pixels_in(reference);
    const hdr_planes *t = hdr_output_pixels(a), *r = hdr_output_pixels(b);
    size_t count = (size_t)t->width * (size_t)t->height;
    exposures e;
    long double *map = naive_flip(t, r, kind, encoded, (long double)ppd, &e);
    hdr_flip flip = flip_of(test, reference, kind == HDR_FLIP_LDR && encoded ? HDR_FLIP_AUTO : kind, ppd, "1", 1);
    CHECK(flip.kind == kind, "%s: of another kind", what);
    CHECK(flip.exposures == e.count && fabsl((long double)flip.start - e.start) < 1e-12L &&
              fabsl((long double)flip.stop - e.stop) < 1e-12L,
          "%s: %d exposures from %.17g to %.17g, should be %d from %.17Lg to %.17Lg", what, flip.exposures, flip.start,
          flip.stop, e.count, e.start, e.stop);
    if (flip.map) check_figures(&flip, map, count, what);
    /* threads, and what is kept of the reference, change nothing */
    hdr_flip again = flip_of(test, reference, kind, ppd, "3", 2);
    CHECK(again.mean == flip.mean && again.map && flip.map && !memcmp(again.map, flip.map, count * sizeof(float)),
          "%s: threads, or a second test, change the result", what);
    hdr_flip_free(&again);
    hdr_flip_free(&flip);
    free(map);
    hdr_output_free(a);
    hdr_output_free(b);
}

/* ---- Pictures ---- */

static double noisy(int picture, size_t at) {
    return fabs(sin((double)at * 0.013)) * (picture ? 0.7 : 1) + 0.3 * random_unit();
}

/* Light with fireflies, and a test that has others. */
static double fiery(int picture, size_t at) {
    return 0.02 + 0.3 * fabs(sin((double)(at % 977) * 0.01)) + ((at + (size_t)picture * 37) % 1013 == 5 ? 3e4 : 0) +
           0.05 * random_unit() * picture;
}

/* One bright pixel on a black ground, and one on an even one. */
static double spark(int picture, size_t at) {
    return at == 500 && picture == 0 ? 900 : picture == 1 && at % 3 == 0 ? 0.25 : 0;
}

static double even(int picture, size_t at) {
    return at == 700 && picture == 0 ? 5 : 0.2;
}

/* Most of the reference is black; some of it is darker than that. */
static double mostly_black(int picture, size_t at) {
    return at % 5 == 0 ? 0.5 + random_unit() : at % 7 == 1 ? -0.3 : picture ? 0 : 0.01;
}

static double black(int picture, size_t at) {
    return picture ? 0 : 0.001 * (double)(at % 50);
}

typedef struct scene {
    const char *what;
    maker make;
    int width, height, planes;
    hdr_flip_kind kind;
    double ppd;
} scene;

static void test_scenes(void) {
    static const scene scenes[] = {
        {"noise", noisy, 70, 41, 3, HDR_FLIP_LDR, 0},
        {"noise, tall", noisy, 13, 90, 3, HDR_FLIP_LDR, 0},
        {"grey", noisy, 66, 65, 1, HDR_FLIP_LDR, 0},
        {"one pixel", noisy, 1, 1, 3, HDR_FLIP_LDR, 0},
        {"one row", noisy, 67, 1, 3, HDR_FLIP_LDR, 0},
        {"one column", noisy, 1, 5, 1, HDR_FLIP_HDR, 0},
        {"far away", noisy, 40, 30, 3, HDR_FLIP_LDR, 150},
        {"coarse", noisy, 40, 30, 3, HDR_FLIP_LDR, 5.5},
        {"even", even, 40, 40, 3, HDR_FLIP_LDR, 0},
        {"fireflies", fiery, 40, 30, 3, HDR_FLIP_HDR, 0},
        {"fireflies, grey", fiery, 40, 67, 1, HDR_FLIP_HDR, 0},
        {"a spark", spark, 40, 40, 1, HDR_FLIP_HDR, 0},
        {"mostly black", mostly_black, 30, 30, 3, HDR_FLIP_HDR, 0},
        {"a black reference", black, 30, 20, 3, HDR_FLIP_HDR, 0},
    };
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        const scene *s = &scenes[i];
        pictures p = make_pictures(s->width, s->height, s->planes, 2, s->make);
        hdr_input *test = open_picture(&p, 0), *reference = open_picture(&p, 1);
        check_pair(test, reference, s->kind, false, s->ppd > 0 ? s->ppd : usual, s->what);
        if (s->kind == HDR_FLIP_LDR) {
            hdr_flip one = flip_of(test, reference, s->kind, usual, "1", 1);
            hdr_flip other = flip_of(reference, test, s->kind, usual, "2", 1);
            CHECK(one.mean == other.mean && one.mean > 0, "%s: LDR-FLIP is the same both ways", s->what);
            hdr_flip_free(&one);
            hdr_flip_free(&other);
        }
        hdr_flip same = flip_of(reference, reference, s->kind, usual, "2", 1);
        CHECK(same.mean == 0 && same.max == 0 && same.quartile[2] == 0, "%s: a picture and itself", s->what);
        hdr_flip_free(&same);
        hdr_input_free(test);
        hdr_input_free(reference);
        free_pictures(&p);
    }
}

/* On both sides of where sRGB's curve begins: codes of 0.0401 and more. */
static double dim(int picture, size_t at) {
    return at % 3 ? noisy(picture, at) : 0.0031 + 0.0001 * random_unit();
}

/* A file whose state tells that it is encoded. */
static hdr_input *encode(hdr_input *input, hdr_output **file) {
    hdr_error error = {0};
    hdr_chain *chain = hdr_chain_new(&error);
    const char *const words[] = {"srgb", "then", "exr", "--type", "float"};
    size_t size = 0;
    *file = hdr_output_memory(&error);
    hdr_chain_parse(chain, 5, words, &error);
    if (error.status || hdr_chain_run(chain, input, *file, NULL, &error) != HDR_OK) abort();
    const void *bytes = hdr_output_bytes(*file, &size);
    hdr_chain_free(chain);
    return hdr_input_memory(bytes, size, "encoded", &error);
}

static void test_encoded(void) {
    pictures p = make_pictures(33, 40, 3, 2, dim);
    hdr_input *light[2] = {open_picture(&p, 0), open_picture(&p, 1)}, *codes[2];
    hdr_output *file[2];
    for (int i = 0; i < 2; i++)
        codes[i] = encode(light[i], &file[i]);
    check_pair(codes[0], codes[1], HDR_FLIP_LDR, true, usual, "encoded");
    hdr_flip of_light = flip_of(light[0], light[1], HDR_FLIP_LDR, usual, "1", 1);
    hdr_flip of_codes = flip_of(codes[0], codes[1], HDR_FLIP_LDR, usual, "1", 1);
    CHECK(fabs(of_light.mean - of_codes.mean) < 1e-6, "LDR-FLIP of light and of its codes: %g, %g", of_light.mean,
          of_codes.mean);
    hdr_flip_free(&of_light);
    hdr_flip_free(&of_codes);
    hdr_error error = {0};
    hdr_chain *chain = plain_chain("1");
    CHECK(!hdr_flip_prepare(chain, codes[0], HDR_FLIP_HDR, usual, 1, &error) && error.status == HDR_BAD_DATA,
          "HDR-FLIP of codes: %s", error.message);
    for (int i = 0; i < 2; i++) {
        hdr_input_free(codes[i]);
        hdr_input_free(light[i]);
        hdr_output_free(file[i]);
    }
    hdr_chain_free(chain);
    free_pictures(&p);
}

static double half_dark(int picture, size_t at) {
    (void)at;
    return picture ? 0.099975586 : 0.89990234;
}

/* What OpenImageIO's own test of FLIP states of two even pictures (testsuite/flip/ref/out.txt), to as many digits; HDR
 * to less, since it approximates the cube root. */
static void test_published(void) {
    pictures p = make_pictures(64, 64, 3, 2, half_dark);
    hdr_input *light = open_picture(&p, 0), *dark = open_picture(&p, 1);
    hdr_flip ldr = flip_of(light, dark, HDR_FLIP_LDR, 67.02, "1", 1);
    hdr_flip hdr = flip_of(light, dark, HDR_FLIP_HDR, 67.02, "1", 1);
    CHECK(fabs(ldr.mean - 0.9514) < 5e-5 && fabs(ldr.max - 0.9514) < 5e-5, "LDR-FLIP of 0.1 and 0.9: %g", ldr.mean);
    CHECK(fabs(hdr.mean - 0.2045) < 1.5e-4 && hdr.max == hdr.min, "HDR-FLIP of 0.1 and 0.9: %g", hdr.mean);
    CHECK(fabs(hdr.start - 4.41) < 5e-3 && hdr.stop == hdr.start && hdr.exposures == 2, "exposures: %g", hdr.start);
    hdr_flip_free(&ldr);
    hdr_flip_free(&hdr);
    hdr_input_free(light);
    hdr_input_free(dark);
    free_pictures(&p);
}

static void test_refusals(void) {
    static const double wrong[] = {0, -1, 1001, INFINITY, NAN};
    pictures p = make_pictures(8, 8, 3, 1, noisy), q = make_pictures(9, 8, 3, 1, noisy);
    hdr_input *one = open_picture(&p, 0), *other = open_picture(&q, 0);
    hdr_chain *chain = plain_chain("1");
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        hdr_error error = {0};
        CHECK(!hdr_flip_prepare(chain, one, HDR_FLIP_AUTO, wrong[i], 1, &error) && error.status == HDR_USAGE,
              "%g pixels per degree", wrong[i]);
    }
    hdr_error error = {0};
    hdr_flip flip = {0};
    hdr_flip_reference *reference = hdr_flip_prepare(chain, one, HDR_FLIP_AUTO, usual, 1, &error);
    hdr_flip_compare(reference, other, false, &flip, &error);
    CHECK(error.status == HDR_BAD_DATA, "another size");
    CHECK(flip.kind == HDR_FLIP_HDR && !flip.map, "light, and no map");
    hdr_flip_free(&flip);
    hdr_flip_reference_free(reference);
    hdr_chain_free(chain);
    hdr_input_free(one);
    hdr_input_free(other);
    free_pictures(&p);
    free_pictures(&q);
}

int main(void) {
    test_scenes();
    test_encoded();
    test_published();
    test_refusals();
    return check_done("test_flip");
}

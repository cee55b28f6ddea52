/* What has to hold for `reinhard`, whatever its implementation: no dependence on exposure, pictures at the edge of
 * sense, the brightest pixel at 1, a curve that never falls, and one bad pixel that spoils no other. Codes and floats
 * themselves are compared in tests/oracle. */
#include "laws_pictures.h"

#include "../oracle/oracle_reinhard.h"

static const char *const global_texts[] = {"reinhard",
                                           "reinhard --white inf",
                                           "reinhard --white 4",
                                           "reinhard --key 0.72 --white auto",
                                           "reinhard --key estimate",
                                           "reinhard --key estimate --white auto",
                                           "reinhard --key estimate --white 0.7",
                                           "reinhard --per-channel",
                                           "reinhard --per-channel --key estimate",
                                           "reinhard --saturation 0.6"};
static const char *const local_texts[] = {"reinhard --local", "reinhard --local --key estimate",
                                          "reinhard --local --phi 4 --epsilon 0.02",
                                          "reinhard --local --key 0.72 --saturation 0.6"};
enum {
    GLOBALS = sizeof global_texts / sizeof *global_texts,
    LOCALS = sizeof local_texts / sizeof *local_texts,
    TEXTS = GLOBALS + LOCALS
};

static const char *text_number(int i) {
    return i < GLOBALS ? global_texts[i] : local_texts[i - GLOBALS];
}

/* ---- Pictures and results ---- */

/* The floats of a PFM, in its order of rows. */
static float *floats_of(const law_picture *picture, const char *text, const char *rest, size_t *count) {
    law_result pfm = law_run(picture, "%s then pfm -j 1 %s", text, rest);
    CHECK(pfm.status == HDR_OK, "%s on %s: status %d, %s", text, picture->name, (int)pfm.status, pfm.message);
    float *values = pfm.bytes ? law_read_pfm(&pfm, count) : NULL;
    if (!values) *count = 0;
    free(pfm.bytes);
    return values;
}

/* ---- Exposure ---- */

/* What changes by 1, over all pictures: by global and by local forms. */
static unsigned long scaled_changed[2], scaled_compared[2];

static void check_scaled(const law_picture *picture, const char *text) {
    law_codes before = law_codes_of(picture, text, "");
    law_picture scaled = law_copy_of(picture);
    const bool local = strstr(text, "--local");
    for (int stops = -20; before.code && stops <= 20; stops++) {
        for (int p = 0; p < picture->planes; p++)
            for (size_t i = 0; i < law_pixels(picture); i++)
                scaled.plane[p][i] = ldexpf(picture->plane[p][i], stops);
        law_codes after = law_codes_of(&scaled, text, "");
        int farthest = after.count == before.count ? 0 : 65535;
        for (size_t i = 0; i < after.count && i < before.count; i++) {
            int distance = abs((int)after.code[i] - (int)before.code[i]);
            farthest = distance > farthest ? distance : farthest;
            scaled_changed[local] += distance != 0;
            scaled_compared[local]++;
        }
        CHECK(after.count && farthest <= 1, "%s on %s times 2^%d: a code changes by %d", text, picture->name, stops,
              farthest);
        free(after.code);
    }
    free(before.code);
    law_free_picture(&scaled);
}

static void test_exposure(const law_picture *render) {
    law_picture wide = law_new_picture("twelve decades", 45, 50, 3, false);
    law_picture grey = law_new_picture("hard, grey", 61, 37, 1, false);
    law_fill(&wide, law_ordinary);
    law_fill(&grey, law_hard);
    for (int t = 0; t < TEXTS; t++) {
        check_scaled(render, text_number(t));
        check_scaled(&wide, text_number(t));
        check_scaled(&grey, text_number(t));
    }
    for (int local = 0; local < 2; local++)
        printf("times 2^-20 to 2^20, %s: %lu of %lu codes change, by 1\n", local ? "local" : "global",
               scaled_changed[local], scaled_compared[local]);
    law_free_picture(&wide);
    law_free_picture(&grey);
}

/* ---- Pictures at the edge of sense ---- */

/* Floats of the local form's fast path are held to no more than codes need. */
static const double GLOBAL_BOUND = 0x1p-22, LOCAL_BOUND = 1e-5;

typedef enum expectation {
    FINITE,
    DARK,    /* 0 everywhere */
    UNIFORM, /* one colour */
    LONE     /* but for the pixel in the middle, 0 */
} expectation;

static bool is_expected(expectation expected, const float *values, size_t count, int components) {
    size_t middle = count / (size_t)components / 2;
    for (size_t i = 0; i < count; i++) {
        bool is_middle = i / (size_t)components == middle;
        if (expected == DARK && values[i] != 0) return false;
        if (expected == LONE && (values[i] > 0) != is_middle) return false;
        double first = values[i % (size_t)components];
        if (expected == UNIFORM && !(fabs(values[i] - first) <= LOCAL_BOUND * fabs(first))) return false;
    }
    return true;
}

static void check_sane(const law_picture *picture, const char *text, expectation expected) {
    size_t count = 0, bad = 0;
    law_result exr = law_run(picture, "%s then exr -j 1 --compression none", text);
    CHECK(exr.status == HDR_OK && law_count_exr(&exr, false, &count, &bad) && bad == 0,
          "%s on %s: status %d, %zu of %zu components are not finite; %s", text, picture->name, (int)exr.status, bad,
          count, exr.message);
    free(exr.bytes);
    float *values = floats_of(picture, text, "", &count);
    CHECK(values && is_expected(expected, values, count, picture->planes), "%s on %s: not what it should be", text,
          picture->name);
    free(values);
    law_codes codes = law_codes_of(picture, text, "");
    size_t above = 0;
    for (size_t i = 0; i < codes.count; i++)
        above += codes.code[i] != 0;
    CHECK(codes.count && (expected != DARK || !above), "%s on %s: %zu codes above 0", text, picture->name, above);
    free(codes.code);
}

static void try_sane(law_picture *picture, expectation expected) {
    const bool big = law_pixels(picture) > 10000;
    for (int t = 0; t < TEXTS; t += big ? 2 : 1) { /* a big one meets every other */
        char reference[100];
        snprintf(reference, sizeof reference, "%s --reference", text_number(t));
        check_sane(picture, text_number(t), expected);
        if (!big) check_sane(picture, reference, expected);
    }
    check_sane(picture, "reinhard --delta 0.01", expected);
    law_free_picture(picture);
}

static law_picture uniform(const char *name, int width, int height, int planes, float value) {
    law_picture picture = law_new_picture(name, width, height, planes, false);
    law_fill_constant(&picture, value);
    return picture;
}

/* value at the middle of black; odd sizes have the same middle upside down. */
static law_picture lone(const char *name, int width, int height, float value) {
    law_picture picture = law_new_picture(name, width, height, 3, false);
    for (int p = 0; p < 3; p++)
        picture.plane[p][law_pixels(&picture) / 2] = value;
    return picture;
}

static law_picture filled(const char *name, int width, int height, float (*value)(void)) {
    law_picture picture = law_new_picture(name, width, height, 3, false);
    law_fill(&picture, value);
    return picture;
}

/* Percentiles 1 and 99 next to each other, and an average far from both: the exponent of --key estimate is huge. */
static law_picture nearly_uniform(const char *name, float outlier) {
    law_picture picture = uniform(name, 30, 30, 1, 1);
    for (int i = 0; i < 30; i++)
        picture.plane[0][i * 29] = nextafterf(1, 2);
    for (int i = 0; i < 8; i++)
        picture.plane[0][i * 100 + 7] = outlier;
    return picture;
}

static void test_edges(void) {
    law_picture pictures[] = {uniform("uniform", 20, 33, 3, 0.18f),
                              uniform("uniform, grey", 9, 200, 1, 1e-3f),
                              uniform("one pixel", 1, 1, 3, 7),
                              uniform("one grey pixel", 1, 1, 1, 1e-30f),
                              uniform("least float", 12, 11, 1, FLT_TRUE_MIN),
                              uniform("largest float", 12, 11, 1, FLT_MAX),
                              uniform("largest colour", 12, 11, 3, FLT_MAX)};
    for (size_t i = 0; i < sizeof pictures / sizeof *pictures; i++)
        try_sane(&pictures[i], UNIFORM);
    law_picture dark[] = {uniform("black", 20, 33, 3, 0),        uniform("-0", 5, 4, 1, -0.0f),
                          uniform("negative", 5, 33, 3, -2),     uniform("all NaN", 5, 4, 3, NAN),
                          uniform("all Inf", 5, 4, 3, INFINITY), uniform("blue, Y < 0", 10, 10, 3, -1),
                          uniform("one black pixel", 1, 1, 3, 0)};
    for (size_t i = 0; i < law_pixels(&dark[5]); i++)
        dark[5].plane[2][i] = 3;
    for (size_t i = 0; i < sizeof dark / sizeof *dark; i++)
        try_sane(&dark[i], DARK);
    law_picture lonely[] = {lone("one lit pixel", 41, 31, 5), lone("one lit pixel of a row", 301, 1, 1e-6f),
                            lone("one lit pixel of a column", 1, 301, 6e4f), lone("one lit of three", 3, 1, 1)};
    for (size_t i = 0; i < sizeof lonely / sizeof *lonely; i++)
        try_sane(&lonely[i], LONE);
    law_picture others[] = {filled("one row", 700, 1, law_hard),
                            filled("one column", 1, 700, law_hard),
                            filled("longest row", 65535, 1, law_hard),
                            filled("longest column", 1, 65535, law_ordinary),
                            filled("two rows", 90, 2, law_hard),
                            filled("hard", 61, 37, law_hard),
                            filled("extreme", 40, 36, law_extreme),
                            nearly_uniform("nearly uniform, bright pixels", 1e30f),
                            nearly_uniform("nearly uniform, dim pixels", 1e-30f)};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        try_sane(&others[i], FINITE);
}

/* A picture of one grey has L = key: Ld = 1 with its own white, else key / (1 + key), or with white 4 key / (1 + key)
 * (1 + key / 16). */
static void test_uniform_values(void) {
    static const struct {
        const char *text;
        double value;
    } expected[] = {{"reinhard", 1},
                    {"reinhard --key estimate", 1},
                    {"reinhard --key 3 --white auto --per-channel", 1},
                    {"reinhard --white inf", 0.18 / 1.18},
                    {"reinhard --key 0.5 --white 4", 0.5 / 1.5 * (1 + 0.5 / 16)},
                    {"reinhard --key estimate --white 0.3", 0.18 / 1.18 * 3},
                    {"reinhard --local", 0.18 / 1.18},
                    {"reinhard --local --key estimate", 0.18 / 1.18},
                    {"reinhard --local --key 0.72 --white 0.1", 0.72 / 1.72},
                    {"reinhard --local --reference --phi 1", 0.18 / 1.18}};
    static const float greys[] = {0.18f, 1e-20f, 1, 3e5f};
    for (size_t e = 0; e < sizeof expected / sizeof *expected; e++)
        for (int g = 0; g < 4; g++)
            for (int size = 1; size <= 31; size += 10) {
                law_picture picture = uniform("uniform", size, size + g, 1, greys[g]);
                size_t count = 0, wrong = 0;
                double bound = strstr(expected[e].text, "--local") ? LOCAL_BOUND : GLOBAL_BOUND;
                float *values = floats_of(&picture, expected[e].text, "", &count);
                for (size_t i = 0; i < count; i++)
                    wrong += !(fabs(values[i] - expected[e].value) <= bound * expected[e].value);
                CHECK(values && wrong == 0, "%s on %g everywhere: %.9g, should be %.9g", expected[e].text,
                      (double)greys[g], values ? (double)values[0] : 0, expected[e].value);
                free(values);
                law_free_picture(&picture);
            }
}

/* ---- The brightest pixel ---- */

static void check_brightest(const law_picture *picture, const char *text) {
    size_t count = 0, ones = 0, brightest = 0, largest = 0;
    const float *plane = picture->plane[0];
    for (size_t i = 0; i < law_pixels(picture); i++)
        if (plane[i] > plane[largest]) largest = i;
    for (size_t i = 0; i < law_pixels(picture); i++)
        brightest += plane[i] == plane[largest];
    float *values = floats_of(picture, text, "", &count);
    float top = 0;
    for (size_t i = 0; i < count; i++) {
        ones += values[i] == 1;
        if (values[i] > top) top = values[i];
    }
    CHECK(top == 1 && ones >= brightest, "%s on %s: the brightest pixel becomes %.9g", text, picture->name,
          (double)top);
    free(values);
    for (int bits = 8; bits <= 16; bits += 8) {
        law_codes codes = law_codes_of(picture, text, bits == 8 ? "--bits 8" : "--bits 16");
        CHECK(codes.count == law_pixels(picture) && codes.code[largest] == (1 << bits) - 1,
              "%s on %s: the brightest pixel's code of %d bits is %d", text, picture->name, bits,
              codes.count ? codes.code[largest] : -1);
        free(codes.code);
    }
}

static void test_brightest(void) {
    static const char *const texts[] = {"reinhard",
                                        "reinhard --reference",
                                        "reinhard --key 0.045",
                                        "reinhard --key 0.7234 --white auto",
                                        "reinhard --key 1e-12",
                                        "reinhard --key 1e12",
                                        "reinhard --key estimate --white auto",
                                        "reinhard --delta 0.3 --key 0.36",
                                        "reinhard --per-channel"};
    for (int n = 0; n < 25; n++) {
        law_picture picture = law_new_picture("random", 17, 5 + n, 1, false);
        law_fill(&picture, law_ordinary);
        for (size_t t = 0; t < sizeof texts / sizeof *texts; t++)
            check_brightest(&picture, texts[t]);
        law_free_picture(&picture);
    }
}

/* ---- Monotony ---- */

static int compare_floats(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Sixteen decades, with runs of neighbouring floats at every power of ten. */
static law_picture make_ramp(void) {
    enum { SPREAD = 4000, RUN = 200, RUNS = 17 };
    law_picture ramp = law_new_picture("ramp", SPREAD + RUN * RUNS, 1, 1, false);
    float *at = ramp.plane[0];
    for (int i = 0; i < SPREAD; i++)
        *at++ = (float)law_random_log(1e-8, 1e8);
    for (int r = 0; r < RUNS; r++) {
        float value = (float)pow(10, r - 8);
        for (int i = 0; i < RUN; i++) {
            *at++ = value;
            value = nextafterf(value, INFINITY);
        }
    }
    ramp.plane[0][0] = -3;
    ramp.plane[0][1] = 0;
    qsort(ramp.plane[0], law_pixels(&ramp), sizeof(float), compare_floats);
    return ramp;
}

static void check_ascends(const law_picture *ramp, const char *text) {
    size_t count = 0, falls = 0;
    float *values = floats_of(ramp, text, "", &count);
    for (size_t i = 1; i < count; i++)
        falls += values[i] < values[i - 1];
    CHECK(count == law_pixels(ramp) && falls == 0, "%s falls %zu times among %zu floats", text, falls, count);
    free(values);
    for (int bits = 8; bits <= 16; bits += 8) {
        law_codes codes = law_codes_of(ramp, text, bits == 8 ? "" : "--bits 16");
        falls = 0;
        for (size_t i = 1; i < codes.count; i++)
            falls += codes.code[i] < codes.code[i - 1];
        CHECK(codes.count == law_pixels(ramp) && falls == 0, "%s falls %zu times among %zu codes of %d bits", text,
              falls, codes.count, bits);
        free(codes.code);
    }
}

static void test_monotone(void) {
    law_picture ramp = make_ramp();
    char text[100];
    for (int t = 0; t < GLOBALS; t++) {
        check_ascends(&ramp, global_texts[t]);
        snprintf(text, sizeof text, "%s --reference", global_texts[t]);
        check_ascends(&ramp, text);
    }
    check_ascends(&ramp, "reinhard --white 1e-3");
    check_ascends(&ramp, "reinhard --delta 2 --white 1e4");
    check_ascends(&ramp, "reinhard --key 1e-6");
    check_ascends(&ramp, "reinhard --key 1e6");
    law_free_picture(&ramp);
}

/* ---- One bad pixel ---- */

/* Beyond it a pixel has no part in another's surround: 8 standard deviations of the widest Gaussian, and a pixel. */
enum { FAR = 87, OUTLIERS = 3 };

/* The outliers move the log-average by up to 3 ln(60000 / 0.003) / 120000 = 4e-4, in proportion, and an activity near
 * epsilon by that times epsilon: choices that hang on less may go another way. */
static const double SHIFT = 3e-5;

static const int outlier_at[OUTLIERS][2] = {{200, 150}, {203, 150}, {200, 153}};

/* kinds: bit 0 a NaN, bit 1 an infinity, bit 2 a firefly. */
static law_picture with_outliers(const law_picture *picture, int kinds) {
    law_picture copy = law_copy_of(picture);
    for (int o = 0; o < OUTLIERS; o++) {
        size_t at = (size_t)outlier_at[o][1] * (size_t)picture->width + (size_t)outlier_at[o][0];
        if (!(kinds >> o & 1)) continue;
        for (int p = 0; o == 2 && p < 3; p++)
            copy.plane[p][at] = 60000;
        if (o < 2) copy.plane[o][at] = o ? INFINITY : NAN;
    }
    return copy;
}

/* Chessboard distance of the nearest outlier. */
static int distance_of_outlier(size_t pixel, int width, int kinds) {
    int x = (int)(pixel % (size_t)width), y = (int)(pixel / (size_t)width), nearest = width;
    for (int o = 0; o < OUTLIERS; o++) {
        int dx = abs(x - outlier_at[o][0]), dy = abs(y - outlier_at[o][1]), distance = dx > dy ? dx : dy;
        if (kinds >> o & 1 && distance < nearest) nearest = distance;
    }
    return nearest;
}

/* The margin of each pixel's choice of scale, by default options. */
static double *margins_of(const law_picture *picture) {
    size_t count = law_pixels(picture), lit = 0;
    double *plane = calloc(count, sizeof *plane), *margin = calloc(count, sizeof *margin);
    double *surround = calloc(count, sizeof *surround), sum = 0;
    unsigned char *chosen = calloc(count, 1);
    for (size_t i = 0; i < count; i++) {
        double y = 0.2126 * picture->plane[0][i] + 0.7152 * picture->plane[1][i] + 0.0722 * picture->plane[2][i];
        plane[i] = y > 0 ? y : 0;
        if (y > 0) sum += log(y), lit++;
    }
    oracle_surround_by(oracle_blur_by_axes, plane, picture->width, picture->height, 0.18 / exp(sum / (double)lit), 0.18,
                       8, 0.05, surround, chosen, margin);
    free(plane);
    free(surround);
    free(chosen);
    return margin;
}

/* What changed: by 1 elsewhere, at all within reach, and where the scale hung by a hair. */
static struct { size_t by_one, near, doubtful; } changed[2];

/* far: pixels nearer than that to an outlier are only counted. margin: where above SHIFT, or NULL. */
static void check_spoils_nothing(const law_picture *picture, const char *text, int kinds, int far,
                                 const double *margin) {
    law_picture spoilt = with_outliers(picture, kinds);
    law_codes before = law_codes_of(picture, text, ""), after = law_codes_of(&spoilt, text, "");
    size_t pixels = law_pixels(picture), farther = 0;
    const bool local = margin;
    bool comparable = before.count == 3 * pixels && after.count == 3 * pixels;
    CHECK(comparable, "%s: %zu codes, then %zu", text, before.count, after.count);
    for (size_t i = 0; comparable && i < 3 * pixels; i++) {
        int distance = abs((int)before.code[i] - (int)after.code[i]);
        int from_outlier = distance_of_outlier(i / 3, picture->width, kinds);
        if (!distance || !from_outlier) continue;
        if (from_outlier < far)
            changed[local].near++;
        else if (margin && margin[i / 3] < SHIFT)
            changed[local].doubtful++;
        else
            distance == 1 ? changed[local].by_one++ : farther++;
    }
    CHECK(farther == 0, "%s: outliers %d change %zu codes of other pixels by more than 1", text, kinds, farther);
    free(before.code);
    free(after.code);
    law_free_picture(&spoilt);
}

static void test_outliers(void) {
    law_picture interior = law_read_planes("testdata/interior.exr");
    CHECK(interior.width == 400 && interior.height == 300, "interior.exr is %d x %d", interior.width, interior.height);
    if (interior.width != 400 || interior.height != 300) return;
    double *margin = margins_of(&interior);
    size_t doubtful = 0;
    for (size_t i = 0; i < law_pixels(&interior); i++)
        doubtful += margin[i] < SHIFT;
    CHECK(doubtful * 100 < law_pixels(&interior), "%zu choices of scale hang by a hair: too many", doubtful);
    static const int kinds[] = {1, 2, 4, 7};
    for (int k = 0; k < 4; k++) {
        for (int t = 0; t < GLOBALS; t++)
            check_spoils_nothing(&interior, global_texts[t], kinds[k], 1, NULL);
        check_spoils_nothing(&interior, "reinhard --delta 0.001", kinds[k], 1, NULL);
        check_spoils_nothing(&interior, "reinhard --local", kinds[k], FAR + 1, margin);
    }
    for (int local = 0; local < 2; local++)
        printf("outliers, %s: %zu codes change by 1 elsewhere, %zu within reach, %zu where the scale hung by a hair\n",
               local ? "local" : "global", changed[local].by_one, changed[local].near, changed[local].doubtful);
    free(margin);
    law_free_picture(&interior);
}

/* ---- Options ---- */

static void test_refusals(void) {
    static const char *const refused[] = {"--phi 8",
                                          "--epsilon 0.05",
                                          "--phi 3 --epsilon 0.1 --key estimate",
                                          "--local --per-channel",
                                          "--per-channel --local --phi 8",
                                          "--key 0",
                                          "--key -0.18",
                                          "--key nan",
                                          "--key auto",
                                          "--white 0",
                                          "--white -1",
                                          "--white estimate",
                                          "--delta -0.1",
                                          "--saturation 2.1",
                                          "--saturation -1",
                                          "--local --saturation 3",
                                          "--scale 3"};
    law_picture picture = uniform("uniform", 4, 4, 3, 1);
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        law_result result = law_run(&picture, "reinhard %s then exr", refused[i]);
        CHECK(result.status == HDR_USAGE && !strstr(result.message, "unknown verb"),
              "reinhard %s: status %d, should be 64 for its options' sake; %s", refused[i], (int)result.status,
              result.message);
        free(result.bytes);
    }
    law_free_picture(&picture);
}

static void check_same(const law_picture *picture, const char *a, const char *b) {
    static const char *const formats[] = {"exr", "png"};
    for (int f = 0; f < 2; f++) {
        law_result one = law_run(picture, "%s then %s", a, formats[f]);
        law_result other = law_run(picture, "%s then %s", b, formats[f]);
        CHECK(one.status == HDR_OK && law_same(&one, &other), "%s and %s: other bytes of %s; %s%s", a, b, formats[f],
              one.message, other.message);
        free(one.bytes);
        free(other.bytes);
    }
}

/* Ways to say the same, and what must not matter. */
static void test_same(const law_picture *render) {
    check_same(render, "reinhard", "reinhard --key 0.18 --white auto --delta 0 --saturation 1");
    check_same(render, "reinhard", "reinhard --white by-key");
    check_same(render, "reinhard --key estimate", "reinhard --key estimate --white by-key");
    check_same(render, "reinhard --local", "reinhard --local --phi 8 --epsilon 0.05 --white 3");
    check_same(render, "reinhard --local", "reinhard --local --white inf");
    check_same(render, "reinhard --local", "reinhard --local --no-skip");
    check_same(render, "reinhard --local -j 1", "reinhard --local -j 3");
    check_same(render, "reinhard --local", "reinhard --local --memory 1M");
    check_same(render, "reinhard --local --reference -j 1", "reinhard --local --reference -j 3 --no-skip");
}

int main(void) {
    law_picture render = law_read_planes("testdata/interior_float.exr");
    test_refusals();
    test_same(&render);
    test_exposure(&render);
    test_edges();
    test_uniform_values();
    test_brightest();
    test_monotone();
    test_outliers();
    law_free_picture(&render);
    return check_done("test_reinhard");
}

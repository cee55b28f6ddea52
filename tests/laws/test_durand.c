/* What has to hold for `durand`, whatever its implementation: no dependence on exposure, on the way the work is done,
 * on the picture's size or orientation; layers that are what their names say; pictures at the edge of sense; and one
 * bad pixel that spoils no other. The numbers themselves are compared in tests/oracle, the bounds of the filter in
 * test_durand_bounds. */
#include "laws_pictures.h"

#include "levels.h"

static const char *const texts[] = {"durand",
                                    "durand --method grid --sigma-s 4px",
                                    "durand --method direct --sigma-s 2px",
                                    "durand --percentile 0 --contrast 50",
                                    "durand --intensity durand --saturation 0.6 --tolerance 0.01",
                                    "durand --show base --sigma-s 0.05",
                                    "durand --show detail --sigma-r 1 --sigma-s 3px"};
enum { TEXTS = sizeof texts / sizeof *texts };

/* ---- Pictures and results ---- */

/* The picture that a chain makes of another, or its planes alone: law_read_pfm has the rows upside down. */
static law_picture toned(const law_picture *picture, const char *text) {
    law_picture out = law_new_picture(text, picture->width, picture->height, picture->planes, false);
    law_result pfm = law_run(picture, "%s then pfm -j 2", text);
    size_t count = 0, row = (size_t)picture->width, planes = (size_t)picture->planes;
    float *values = pfm.status == HDR_OK ? law_read_pfm(&pfm, &count) : NULL;
    CHECK(values && count == law_pixels(picture) * planes, "%s on %s: status %d, %s", text, picture->name,
          (int)pfm.status, pfm.message);
    for (size_t i = 0; values && i < law_pixels(picture); i++)
        for (size_t p = 0; p < planes; p++)
            out.plane[p][i] = values[(((size_t)picture->height - 1 - i / row) * row + i % row) * planes + p];
    free(values);
    free(pfm.bytes);
    return out;
}

static law_picture filled(const char *name, int width, int height, int planes, float (*value)(void)) {
    law_picture picture = law_new_picture(name, width, height, planes, false);
    law_fill(&picture, value);
    return picture;
}

/* ---- The way the work is done ---- */

static uint64_t digest_at_level(void) {
    uint64_t digest = 1;
    law_random_state = 5;
    law_picture pictures[] = {filled("twelve decades", 45, 50, 3, law_ordinary),
                              filled("hard, grey", 161, 37, 1, law_hard),
                              {.path = "testdata/interior_float.exr", .name = "interior_float.exr"}};
    for (int p = 0; p < 3; p++)
        for (int t = 0; t <= TEXTS; t++) {
            const char *text = t < TEXTS ? texts[t] : "durand --reference --sigma-s 2px";
            law_result exr = law_run(&pictures[p], "%s then exr --compression none", text);
            CHECK(exr.status == HDR_OK, "%s on %s: %s", text, pictures[p].name, exr.message);
            digest = digest * 31 + law_digest(exr.bytes, exr.size);
            free(exr.bytes);
        }
    law_free_picture(&pictures[0]);
    law_free_picture(&pictures[1]);
    return digest;
}

static void check_same(const law_picture *picture, const char *a, const char *b) {
    static const char *const formats[] = {"exr", "png"};
    for (int f = 0; f < 2; f++) {
        law_result one = law_run(picture, "%s then %s", a, formats[f]);
        law_result other = law_run(picture, "%s then %s", b, formats[f]);
        CHECK(one.status == HDR_OK && law_same(&one, &other), "%s and %s on %s: other bytes of %s; %s%s", a, b,
              picture->name, formats[f], one.message, other.message);
        free(one.bytes);
        free(other.bytes);
    }
}

/* Ways to say the same, and what must not matter. */
static void test_same(const law_picture *render) {
    static const char *const ways[] = {"-j 2", "-j 5", "--memory 1M", "--no-skip", "-j 3 --memory 1M --no-skip"};
    law_picture sparse = filled("few lit", 300, 90, 3, law_hard), tall = filled("tall", 70, 400, 1, law_ordinary);
    for (size_t i = 0; i < law_pixels(&sparse); i++)
        for (int p = 0; i % 300 > 120 && p < 3; p++)
            sparse.plane[p][i] = 0;
    law_picture file = {.path = "testdata/interior.exr", .name = "interior.exr"};
    const law_picture *pictures[] = {render, &sparse, &tall, &file};
    for (int p = 0; p < 4; p++)
        for (int t = 0; t < 3; t++) {
            const char *format = (p + t) % 3 ? "exr" : "png";
            law_result one = law_run(pictures[p], "%s -j 1 then %s", texts[t], format);
            for (size_t w = 0; w < sizeof ways / sizeof *ways; w++) {
                law_result other = law_run(pictures[p], "%s %s then %s", texts[t], ways[w], format);
                CHECK(one.status == HDR_OK && law_same(&one, &other), "%s on %s: other bytes of %s with %s; %s%s",
                      texts[t], pictures[p]->name, format, ways[w], one.message, other.message);
                free(other.bytes);
            }
            free(one.bytes);
        }
    check_same(render, "durand --reference -j 1 --sigma-s 1px", "durand --reference -j 3 --no-skip --sigma-s 1px");
    check_same(render, "durand", "durand --sigma-s 0.02 --sigma-r 0.4 --contrast 5 --percentile 0.1 --saturation 1");
    check_same(render, "durand", "durand --intensity rec709 --method auto --tolerance 0.001 --show picture");
    check_same(&file, "durand", "durand --sigma-s 8px");
    check_same(&tall, "durand", "durand --intensity durand");
    law_free_picture(&sparse);
    law_free_picture(&tall);
}

/* ---- Exposure ---- */

static unsigned long scaled_changed, scaled_compared;

static void check_scaled(const law_picture *picture, const char *text, int step) {
    law_codes before = law_codes_of(picture, text, "");
    law_picture scaled = law_copy_of(picture);
    for (int stops = -20; before.code && stops <= 20; stops += step) {
        for (int p = 0; p < picture->planes; p++)
            for (size_t i = 0; i < law_pixels(picture); i++)
                scaled.plane[p][i] = ldexpf(picture->plane[p][i], stops);
        law_codes after = law_codes_of(&scaled, text, "");
        int farthest = after.count == before.count ? 0 : 65535;
        for (size_t i = 0; i < after.count && i < before.count; i++) {
            int distance = abs((int)after.code[i] - (int)before.code[i]);
            farthest = distance > farthest ? distance : farthest;
            scaled_changed += distance != 0;
            scaled_compared++;
        }
        CHECK(after.count && farthest <= 1, "%s on %s times 2^%d: a code changes by %d", text, picture->name, stops,
              farthest);
        free(after.code);
    }
    free(before.code);
    law_free_picture(&scaled);
}

static void test_exposure(const law_picture *render) {
    law_picture wide = filled("twelve decades", 45, 50, 3, law_ordinary), grey = filled("hard", 61, 37, 1, law_hard);
    for (int t = 0; t < TEXTS; t++) {
        check_scaled(render, texts[t], t ? 8 : 1);
        check_scaled(&wide, texts[t], 1);
        check_scaled(&grey, texts[t], 1);
    }
    check_scaled(&grey, "durand --reference --sigma-s 2px", 5);
    printf("times 2^-20 to 2^20: %lu of %lu codes change, by 1\n", scaled_changed, scaled_compared);
    law_free_picture(&wide);
    law_free_picture(&grey);
}

/* ---- Pictures at the edge of sense ---- */

typedef enum expectation {
    FINITE,
    DARK,    /* 0 everywhere */
    UNIFORM, /* one grey */
    LONE     /* but for the pixel in the middle, 0 */
} expectation;

/* What rounding a base of 38, in units of log10, to float does to the light. */
static const double FLOAT_BASE = 6e-6;

/* A picture of one grey has base and i alike: Ld = 1, and no detail. */
static double uniform_value(const char *text) {
    return strstr(text, "detail") ? 0.18 : 1;
}

static void check_sane(const law_picture *picture, const char *text, expectation expected) {
    size_t count = 0, bad = 0, wrong = 0, pixels = law_pixels(picture);
    law_result exr = law_run(picture, "%s then exr -j 1 --compression none", text);
    CHECK(exr.status == HDR_OK && law_count_exr(&exr, false, &count, &bad) && bad == 0,
          "%s on %s: status %d, %zu of %zu components are not finite; %s", text, picture->name, (int)exr.status, bad,
          count, exr.message);
    free(exr.bytes);
    law_picture out = toned(picture, text);
    for (size_t i = 0; i < pixels; i++)
        for (int p = 0; p < out.planes; p++) {
            float value = out.plane[p][i];
            bool is_lit = expected == UNIFORM || (expected == LONE && i == pixels / 2);
            if (expected == FINITE) continue;
            wrong += is_lit ? !(fabs((double)value / uniform_value(text) - 1) < FLOAT_BASE) : value != 0;
        }
    CHECK(wrong == 0, "%s on %s: %zu floats are not what they should be; the middle is %.9g", text, picture->name,
          wrong, (double)out.plane[0][pixels / 2]);
    law_free_picture(&out);
    law_codes codes = law_codes_of(picture, text, "");
    CHECK(codes.count >= pixels, "%s on %s: %zu codes", text, picture->name, codes.count);
    free(codes.code);
}

static void try_sane(law_picture picture, expectation expected) {
    const bool big = law_pixels(&picture) > 10000;
    for (int t = 0; t < TEXTS; t += big ? 2 : 1) {
        check_sane(&picture, texts[t], expected);
        char reference[100];
        snprintf(reference, sizeof reference, "%s --reference", texts[t]);
        if (!big && t % 3 == 0) check_sane(&picture, reference, expected);
    }
    law_free_picture(&picture);
}

static law_picture uniform(const char *name, int width, int height, int planes, float value) {
    law_picture picture = law_new_picture(name, width, height, planes, false);
    law_fill_constant(&picture, value);
    return picture;
}

/* value at the middle of black. */
static law_picture lone(const char *name, int width, int height, float value) {
    law_picture picture = law_new_picture(name, width, height, 3, false);
    for (int p = 0; p < 3; p++)
        picture.plane[p][law_pixels(&picture) / 2] = value;
    return picture;
}

static void test_edges(void) {
    try_sane(uniform("uniform", 20, 33, 3, 0.18f), UNIFORM);
    try_sane(uniform("uniform, grey", 9, 200, 1, 1e-3f), UNIFORM);
    try_sane(uniform("one pixel", 1, 1, 3, 7), UNIFORM);
    try_sane(uniform("one grey pixel", 1, 1, 1, 1e-30f), UNIFORM);
    try_sane(uniform("least float", 12, 11, 1, FLT_TRUE_MIN), UNIFORM);
    try_sane(uniform("largest float", 12, 11, 1, FLT_MAX), UNIFORM);
    try_sane(uniform("largest colour", 12, 11, 3, FLT_MAX), UNIFORM);
    try_sane(uniform("longest uniform row", 65535, 1, 1, 3e5f), UNIFORM);
    try_sane(uniform("black", 20, 33, 3, 0), DARK);
    try_sane(uniform("-0", 5, 4, 1, -0.0f), DARK);
    try_sane(uniform("negative", 5, 33, 3, -2), DARK);
    try_sane(uniform("all NaN", 5, 4, 3, NAN), DARK);
    try_sane(uniform("all Inf", 5, 4, 3, INFINITY), DARK);
    try_sane(uniform("one black pixel", 1, 1, 3, 0), DARK);
    law_picture blue = uniform("blue, Y < 0", 10, 10, 3, -1);
    for (size_t i = 0; i < law_pixels(&blue); i++)
        blue.plane[2][i] = 3;
    try_sane(blue, DARK);
    try_sane(lone("one lit pixel", 41, 31, 5), LONE);
    try_sane(lone("one lit pixel of a row", 301, 1, 1e-6f), LONE);
    try_sane(lone("one lit pixel of a column", 1, 301, 6e4f), LONE);
    try_sane(lone("one lit of three", 3, 1, 1), LONE);
    try_sane(filled("longest row", 65535, 1, 3, law_hard), FINITE);
    try_sane(filled("longest column", 1, 65535, 3, law_ordinary), FINITE);
    try_sane(filled("one row", 700, 1, 3, law_hard), FINITE);
    try_sane(filled("two columns", 2, 90, 3, law_hard), FINITE);
    try_sane(filled("hard", 61, 37, 3, law_hard), FINITE);
    try_sane(filled("extreme", 40, 36, 3, law_extreme), FINITE);
}

/* ---- Layers ---- */

/* Base times detail is the picture's light; the compressed base has the contrast that was asked for. */
static void check_layers(const law_picture *picture, const char *options, double contrast) {
    char text[3][100];
    snprintf(text[0], sizeof text[0], "durand %s", options);
    snprintf(text[1], sizeof text[1], "durand %s --show base", options);
    snprintf(text[2], sizeof text[2], "durand %s --show detail", options);
    law_picture whole = toned(picture, text[0]), base = toned(picture, text[1]), detail = toned(picture, text[2]);
    double least = INFINITY, largest = 0, least_base = INFINITY, largest_base = 0, least_light = INFINITY, light = 0;
    for (size_t i = 0; i < law_pixels(picture); i++) {
        if (!(picture->plane[0][i] > 0)) continue;
        double compressed = (double)whole.plane[0][i] / ((double)detail.plane[0][i] / 0.18);
        double share = (double)base.plane[0][i] * (double)detail.plane[0][i] / (double)picture->plane[0][i];
        least = fmin(least, compressed);
        largest = fmax(largest, compressed);
        least_base = fmin(least_base, (double)base.plane[0][i]);
        largest_base = fmax(largest_base, (double)base.plane[0][i]);
        least_light = fmin(least_light, share);
        light = fmax(light, share);
    }
    double wanted = fmin(contrast, largest_base / least_base);
    CHECK(fabs(largest - 1) < 1e-5 && fabs(largest / least / wanted - 1) < 1e-5,
          "%s on %s: the compressed base goes from %.9g to %.9g, its contrast should be %.9g", text[0], picture->name,
          least, largest, wanted);
    CHECK(fabs(largest_base - 1) < 1e-6, "%s on %s: the brightest base is %.9g", text[1], picture->name, largest_base);
    CHECK(light / least_light - 1 < 1e-5, "%s on %s: base times detail is from %.9g to %.9g of the light", text[0],
          picture->name, least_light, light);
    law_free_picture(&whole);
    law_free_picture(&base);
    law_free_picture(&detail);
}

static void test_layers(const law_picture *render) {
    law_picture grey = law_new_picture("a render's green", render->width, render->height, 1, false);
    law_picture hard = filled("hard", 61, 37, 1, law_hard), mild = uniform("mild", 30, 20, 1, 1);
    memcpy(grey.plane[0], render->plane[1], law_pixels(&grey) * sizeof(float));
    for (size_t i = 0; i < law_pixels(&mild); i++)
        mild.plane[0][i] = (float)law_random_log(0.5, 1);
    for (size_t i = 0; i < law_pixels(&hard); i++)
        if (!isfinite(hard.plane[0][i])) hard.plane[0][i] = 0;
    const law_picture *pictures[] = {&grey, &hard, &mild};
    for (int p = 0; p < 3; p++) {
        check_layers(pictures[p], "--percentile 0", 5);
        check_layers(pictures[p], "--percentile 0 --contrast 30 --sigma-s 4px --method grid", 30);
        check_layers(pictures[p], "--percentile 0 --contrast 1.01 --sigma-s 1px", 1.01);
        check_layers(pictures[p], "--percentile 0 --contrast 1e20 --sigma-s 0.1", 1e20);
        check_layers(pictures[p], "--percentile 0 --reference --sigma-s 1px", 5);
    }
    law_free_picture(&grey);
    law_free_picture(&hard);
    law_free_picture(&mild);
}

/* ---- Against --reference ---- */

/* The base within the default tolerance, at every pixel, and codes off by 1 at most, on 1 pixel in 100. */
static void check_reference(const char *path) {
    static const char *const tones[] = {"durand", "durand --method grid"};
    law_picture picture = law_read_planes(path);
    law_picture exact = toned(&picture, "durand --show detail --reference");
    law_codes right = law_codes_of(&picture, "durand --reference", "");
    for (int t = 0; t < 2; t++) {
        char text[100];
        snprintf(text, sizeof text, "%s --show detail", tones[t]);
        law_picture fast = toned(&picture, text);
        law_codes codes = law_codes_of(&picture, tones[t], "");
        size_t off = 0, farther = 0, pixels = law_pixels(&picture);
        double farthest = 0;
        for (size_t i = 0; i < pixels; i++) {
            int distance = 0;
            for (size_t p = 0; p < 3 && codes.count == 3 * pixels && right.count == 3 * pixels; p++) {
                int d = abs((int)codes.code[3 * i + p] - (int)right.code[3 * i + p]);
                distance = d > distance ? d : distance;
            }
            off += distance == 1;
            farther += distance > 1;
            if (exact.plane[1][i] > 0)
                farthest = fmax(farthest, fabs(log10((double)fast.plane[1][i] / (double)exact.plane[1][i])));
        }
        printf("%s on %s: base within %.2g, codes of %zu pixels of %zu off by 1\n", tones[t], path, farthest, off,
               pixels);
        CHECK(farthest <= 1e-3, "%s on %s: the base is off by %.3g", tones[t], path, farthest);
        CHECK(codes.count == 3 * pixels && farther == 0 && off * 100 <= pixels,
              "%s on %s: %zu codes are off by 1, %zu by more", tones[t], path, off, farther);
        free(codes.code);
        law_free_picture(&fast);
    }
    free(right.code);
    law_free_picture(&exact);
    law_free_picture(&picture);
}

/* ---- Size and orientation ---- */

static int code_of(double v) {
    v = v < 0 ? 0 : v > 1 ? 1 : v;
    return (int)(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055) + 0.5);
}

/* Each pixel the mean of four. */
static law_picture half_of(const law_picture *picture) {
    law_picture half = law_new_picture("half size", picture->width / 2, picture->height / 2, picture->planes, false);
    for (int p = 0; p < picture->planes; p++)
        for (size_t i = 0; i < law_pixels(&half); i++) {
            size_t w = (size_t)picture->width, at = i / (size_t)half.width * 2 * w + i % (size_t)half.width * 2;
            const float *from = picture->plane[p] + at;
            half.plane[p][i] = (from[0] + from[1] + from[w] + from[w + 1]) / 4;
        }
    return half;
}

/* Each pixel four times. */
static law_picture double_of(const law_picture *picture) {
    law_picture out = law_new_picture("double size", picture->width * 2, picture->height * 2, picture->planes, false);
    for (int p = 0; p < picture->planes; p++)
        for (size_t i = 0; i < law_pixels(&out); i++) {
            size_t x = i % (size_t)out.width / 2, y = i / (size_t)out.width / 2;
            out.plane[p][i] = picture->plane[p][y * (size_t)picture->width + x];
        }
    return out;
}

static void compare_looks(const char *what, const law_picture *a, const law_picture *b) {
    double sum = 0;
    size_t pixels = law_pixels(a);
    for (int p = 0; p < a->planes; p++)
        for (size_t i = 0; i < pixels; i++)
            sum += abs(code_of((double)a->plane[p][i]) - code_of((double)b->plane[p][i]));
    double mean = sum / (double)(pixels * (size_t)a->planes);
    printf("%s: codes differ by %.3f on average\n", what, mean);
    CHECK(mean < 2, "%s: codes differ by %.3f on average", what, mean);
}

static void test_sizes(const law_picture *picture) {
    law_picture smaller = half_of(picture), larger = double_of(picture);
    law_picture same_toned = toned(picture, "durand"), small_toned = toned(&smaller, "durand"),
                large_toned = toned(&larger, "durand");
    law_picture same_reduced = half_of(&same_toned), large_reduced = half_of(&large_toned);
    compare_looks("half size", &small_toned, &same_reduced);
    compare_looks("double size", &same_toned, &large_reduced);
    law_picture *all[] = {&smaller, &larger, &same_toned, &small_toned, &large_toned, &same_reduced, &large_reduced};
    for (int i = 0; i < 7; i++)
        law_free_picture(all[i]);
}

/* Columns become rows, and the last pixel the first. */
static law_picture turned(const law_picture *picture, bool transpose) {
    law_picture out = law_new_picture("turned", transpose ? picture->height : picture->width,
                                      transpose ? picture->width : picture->height, picture->planes, false);
    size_t last = law_pixels(picture) - 1, width = (size_t)picture->width, height = (size_t)picture->height;
    for (int p = 0; p < picture->planes; p++)
        for (size_t i = 0; i <= last; i++)
            out.plane[p][transpose ? i % width * height + i / width : last - i] = picture->plane[p][i];
    return out;
}

static void test_turns(const law_picture *picture) {
    for (int transpose = 0; transpose < 2; transpose++)
        for (int t = 0; t < TEXTS; t++) {
            law_picture other = turned(picture, transpose), out = toned(picture, texts[t]),
                        other_out = toned(&other, texts[t]), expected = turned(&out, transpose);
            size_t off = 0, farther = 0, count = law_pixels(picture) * 3;
            for (size_t i = 0; i < count; i++) {
                int at = (int)(i % 3), code = code_of((double)expected.plane[at][i / 3]);
                int distance = abs(code - code_of((double)other_out.plane[at][i / 3]));
                off += distance == 1;
                farther += distance > 1;
            }
            CHECK(farther == 0 && off * 50 <= count,
                  "%s on a picture that is turned: %zu codes change by 1, %zu by more", texts[t], off, farther);
            law_picture *all[] = {&other, &out, &other_out, &expected};
            for (int i = 0; i < 4; i++)
                law_free_picture(all[i]);
        }
}

/* ---- One bad pixel ---- */

enum { AT_X = 200, AT_Y = 150, OUTLIERS = 5 };

static const char *const outlier_names[OUTLIERS] = {"a NaN", "an infinity", "a firefly", "black", "a negative pixel"};

/* Fixed percentiles: those of 1 in 1000 move with a single pixel of a small picture, and with them all others. */
static void test_outliers(const law_picture *picture) {
    static const char *const tones[] = {"durand --percentile 5", "durand --percentile 5 --method grid --sigma-s 6px",
                                        "durand --percentile 5 --sigma-s 2.5px --intensity durand"};
    static const int far[] = {65, 49, 21}; /* 8 standard deviations, and a pixel */
    size_t changed = 0, near = 0;
    for (int t = 0; t < 3; t++) {
        law_codes before = law_codes_of(picture, tones[t], "");
        for (int o = 0; o < OUTLIERS; o++) {
            law_picture spoilt = law_copy_of(picture);
            size_t at = (size_t)AT_Y * (size_t)picture->width + AT_X, farther = 0;
            for (int p = 0; p < 3; p++)
                spoilt.plane[p][at] = o == 2 ? 60000 : o == 3 ? 0 : o == 4 ? -5 : spoilt.plane[p][at];
            if (o < 2) spoilt.plane[o][at] = o ? INFINITY : NAN;
            law_codes after = law_codes_of(&spoilt, tones[t], "");
            bool comparable = before.count == 3 * law_pixels(picture) && after.count == before.count;
            CHECK(comparable, "%s: %zu codes, then %zu", tones[t], before.count, after.count);
            for (size_t i = 0; comparable && i < before.count; i++) {
                int x = (int)(i / 3 % (size_t)picture->width), y = (int)(i / 3 / (size_t)picture->width);
                int distance = abs((int)before.code[i] - (int)after.code[i]);
                bool is_far = abs(x - AT_X) > far[t] || abs(y - AT_Y) > far[t];
                farther += is_far && distance > 1;
                changed += is_far && distance == 1;
                near += !is_far && distance;
            }
            CHECK(farther == 0, "%s: %s changes %zu codes far away by more than 1", tones[t], outlier_names[o],
                  farther);
            free(after.code);
            law_free_picture(&spoilt);
        }
        free(before.code);
    }
    printf("outliers: %zu codes change by 1 far away, %zu within reach\n", changed, near);
}

/* ---- Options ---- */

static void test_refusals(void) {
    static const char *const refused[] = {"--contrast 1",    "--contrast 0.5",   "--contrast nan",  "--sigma-r 0",
                                          "--sigma-r -1",    "--sigma-s 0",      "--sigma-s -0.1",  "--sigma-s 0px",
                                          "--sigma-s px",    "--sigma-s 3pt",    "--sigma-s nan",   "--sigma-s infpx",
                                          "--percentile -1", "--percentile 101", "--saturation -1", "--saturation 2.1",
                                          "--intensity y",   "--show all",       "--method fast",   "--tolerance -1",
                                          "--per-channel",   "--sigma-s"};
    law_picture picture = uniform("uniform", 4, 4, 3, 1);
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        law_result result = law_run(&picture, "durand %s then exr", refused[i]);
        CHECK(result.status == HDR_USAGE && !strstr(result.message, "unknown verb"),
              "durand %s: status %d, should be 64 for its options' sake; %s", refused[i], (int)result.status,
              result.message);
        free(result.bytes);
    }
    law_free_picture(&picture);
}

int main(void) {
    check_at_levels(digest_at_level);
    law_picture render = law_read_planes("testdata/interior_float.exr"),
                interior = law_read_planes("testdata/interior.exr");
    test_refusals();
    test_same(&render);
    test_exposure(&render);
    test_edges();
    test_layers(&render);
    check_reference("testdata/interior_float.exr");
    check_reference("testdata/glossy.exr");
    test_sizes(&interior);
    test_turns(&render);
    test_outliers(&interior);
    law_free_picture(&render);
    law_free_picture(&interior);
    return check_done("test_durand");
}

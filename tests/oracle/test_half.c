/* All 65,536 half values through each encoding and its inverse, at 8, 10, 12 and 16 bits: each code against the
 * oracle's, which MPFR decides wherever long double leaves a doubt. The values come as a luminance-only EXR, as an EXR
 * of three planes in three orders, and as float planes in memory. */
#include "check.h"
#include "oracle_check.h"
#include "oracle_run.h"
#include "oracle_scenes.h"

enum { SIDE = 256, HALVES = SIDE * SIDE };

/* Each encoding, both ways. */
static const char *const curves[] = {
    "gamma -g 2.2",  "gamma -g 1.8",    "gamma -g 2.222222222222222",
    "srgb",          "rec709",          "pq",
    "pq --nits 203", "pq --nits 10000", "pq --nits 0.5",
    "hlg",
};
/* What stands behind it for codes of 8, 10, 12 and 16 bits; a decoded picture would be encoded again by png alone. */
static const struct {
    const char *encoded, *decoded;
} ends[] = {{"png", "quantise --bits 8 then png"},
            {"quantise --bits 10 then png", "quantise --bits 10 then png"},
            {"quantise --bits 12 then png", "quantise --bits 12 then png"},
            {"png --bits 16", "quantise --bits 16 then png"}};

/* Others in which every verb sees one component at a time. */
static const char *const chains[] = {
    "srgb then quantise --bits 5 then png",
    "srgb --decode then gamma then png",
    "rec709 --decode then srgb then png",
    "rec709 --decode then png --bits 16",
    "pq --decode then srgb then png",
    "hlg --decode then rec709 then png",
    "quantise --bits 1 then png",
    "quantise --bits 5 then png",
    "quantise --bits 8 then png",
    "quantise --bits 10 then png",
    "quantise --bits 16 then png",
    "png",
    "png --bits 16",
};

/* Which half a plane has at a pixel: each plane has all of them, no two in the same order. */
static unsigned half_at(int plane, unsigned pixel) {
    return plane == 0 ? pixel : plane == 1 ? HALVES - 1 - pixel : pixel * 40503 % HALVES;
}

static float float_of_half(unsigned half) {
    int exponent = (int)(half >> 10 & 31), fraction = (int)(half & 1023);
    float size = exponent == 31  ? fraction ? NAN : INFINITY
                 : exponent == 0 ? ldexpf((float)fraction, -24)
                                 : ldexpf((float)(1024 + fraction), exponent - 25);
    return half & 0x8000 ? -size : size;
}

/* What a half becomes by repair. */
static float repaired(float value) {
    if (isnan(value)) return 0;
    if (isinf(value)) return value > 0 ? 65504 : 0;
    return value;
}

static bool make_half_exr(int planes, file_bytes *file) {
    static const oracle_scene colours = {.channels = "BGR",
                                         .type = EXR_PIXEL_HALF,
                                         .width = SIDE,
                                         .height = SIDE,
                                         .display = FRAME(0, 0, SIDE - 1, SIDE - 1)};
    static const oracle_scene luminance = {.channels = "Y",
                                           .type = EXR_PIXEL_HALF,
                                           .width = SIDE,
                                           .height = SIDE,
                                           .display = FRAME(0, 0, SIDE - 1, SIDE - 1)};
    const oracle_scene *scene = planes == 1 ? &luminance : &colours;
    recipe r = scene_recipe(scene);
    for (int c = 0; c < planes; c++) {
        r.channel[c].pixels = oracle_alloc(HALVES, 2);
        for (unsigned i = 0; i < HALVES; i++) {
            uint16_t half = (uint16_t)half_at(planes - 1 - c, i); /* blue is stored first */
            memcpy(r.channel[c].pixels + 2 * i, &half, 2);
        }
    }
    bool done = scene_write(&r, scene, file);
    free_recipe(&r);
    return done;
}

/* The oracle's codes of all halves, by their bits. Every verb of these chains sees one component at a time, so that a
 * picture of one plane tells them all. */
static void expect_codes(const oracle_chain *chain, oracle_codes expected[HALVES]) {
    for (unsigned half = 0; half < HALVES; half++)
        expected[half] = oracle_expect(chain, half);
}

static void check_run(const char *text, const char *from, int planes, hdr_input *input, hdr_error *error,
                      const oracle_codes expected[HALVES]) {
    size_t size = 0;
    oracle_png png = {0};
    hdr_output *output = oracle_run(text, input, error);
    const void *bytes = output ? hdr_output_bytes(output, &size) : NULL;
    bool fits = output && oracle_read_png(bytes, size, &png) && png.width == SIDE && png.height == SIDE &&
                png.colours == planes && !png.alpha;
    CHECK(fits, "%s from %s: %s", text, from, output ? "not the PNG that it should be" : error->message);
    for (unsigned i = 0; fits && i < HALVES; i++)
        for (int p = 0; p < planes; p++) {
            unsigned half = half_at(p, i);
            long code = png.samples[i * (unsigned)planes + (unsigned)p];
            const oracle_codes *right = &expected[half];
            CHECK(right->void_pixel || labs(code - right->code[0]) <= right->excused[0],
                  "%s from %s: half 0x%04x gives %ld, should be %ld", text, from, half, code, right->code[0]);
        }
    free(png.samples);
    hdr_output_free(output);
}

static void check_chain(const char *text, const oracle_picture *halves, const file_bytes exr[2],
                        const float *const planes[3]) {
    static oracle_codes expected[HALVES];
    oracle_chain chain;
    hdr_error error = {0};
    bool known = oracle_prepare(&chain, halves, text);
    CHECK(known, "the oracle does not know the chain: %s", text);
    if (!known) return;
    expect_codes(&chain, expected);
    check_run(text, "luminance", 1, hdr_input_memory(exr[0].data, exr[0].size, "Y", &error), &error, expected);
    check_run(text, "RGB", 3, hdr_input_memory(exr[1].data, exr[1].size, "RGB", &error), &error, expected);
    check_run(text, "planes", 3, hdr_input_planes(SIDE, SIDE, 3, planes, NULL, &error), &error, expected);
}

/* There and back. */
static void check_curve(const char *curve, const oracle_picture *halves, const file_bytes exr[2],
                        const float *const planes[3]) {
    char text[ORACLE_LINE];
    for (size_t e = 0; e < sizeof ends / sizeof ends[0]; e++) {
        snprintf(text, sizeof text, "%s then %s", curve, ends[e].encoded);
        check_chain(text, halves, exr, planes);
        snprintf(text, sizeof text, "%s --decode then %s", curve, ends[e].decoded);
        check_chain(text, halves, exr, planes);
    }
}

int main(void) {
    static float plane[3][HALVES], value[HALVES];
    const float *const planes[3] = {plane[0], plane[1], plane[2]};
    file_bytes exr[2];
    /* pixel i of this picture is the half with bits i, repaired */
    oracle_picture halves = {.data = FRAME(0, 0, SIDE - 1, SIDE - 1),
                             .display = FRAME(0, 0, SIDE - 1, SIDE - 1),
                             .width = SIDE,
                             .height = SIDE,
                             .pixels = HALVES,
                             .planes = 1,
                             .plane = {value},
                             .grey = true,
                             .opaque = true,
                             .primaries = oracle_rec709};
    for (unsigned i = 0; i < HALVES; i++)
        value[i] = repaired(float_of_half(i));
    for (int p = 0; p < 3; p++)
        for (unsigned i = 0; i < HALVES; i++)
            plane[p][i] = float_of_half(half_at(p, i));
    bool made = make_half_exr(1, &exr[0]) && make_half_exr(3, &exr[1]);
    CHECK(made, "the EXR files cannot be made");
    for (size_t c = 0; made && c < sizeof curves / sizeof curves[0]; c++)
        check_curve(curves[c], &halves, exr, planes);
    for (size_t c = 0; made && c < sizeof chains / sizeof chains[0]; c++)
        check_chain(chains[c], &halves, exr, planes);
    free(exr[0].data);
    free(exr[1].data);
    return check_done("test_half");
}

/* For the oracle's tests: compares what the library wrote with what the oracle expects, pixel by pixel. Each function
 * returns true where all agrees; otherwise why says what does not. */
#ifndef HDR_TESTS_ORACLE_CHECK_H
#define HDR_TESTS_ORACLE_CHECK_H

#include "oracle_chain.h"
#include "oracle_png.h"

#include "hdrpipe.h"

#include <stdarg.h>

typedef struct oracle_verdict {
    bool wrong;
    char why[200]; /* the first thing that is wrong */
    unsigned long compared, excused;
} oracle_verdict;

static bool oracle_agree(oracle_verdict *verdict, bool agree, const char *format, ...) {
    if (agree || verdict->wrong) return agree;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(verdict->why, sizeof verdict->why, format, arguments);
    va_end(arguments);
    verdict->wrong = true;
    return false;
}

static exr_attr_box2i_t oracle_frame(const oracle_chain *chain) {
    return chain->data_window ? chain->picture->data : chain->picture->display;
}

/* An alpha that is 1 everywhere is dropped, unless the windows leave a border. */
static bool oracle_alpha_written(const oracle_chain *chain) {
    const oracle_picture *picture = chain->picture;
    return picture->plane[3] && (!picture->opaque || (picture->border && !chain->data_window));
}

/* The index in the data window of a pixel in display coordinates; false: outside. */
static bool oracle_inside(const oracle_picture *picture, int x, int y, size_t *pixel) {
    if (x < picture->data.min.x || y < picture->data.min.y || x > picture->data.max.x || y > picture->data.max.y)
        return false;
    *pixel = (size_t)(y - picture->data.min.y) * (size_t)picture->width + (size_t)(x - picture->data.min.x);
    return true;
}

/* ---- PNG ---- */

/* ITU-T H.273's number of a curve that gAMA cannot tell; 0: none. */
static int oracle_transfer(const oracle_chain *chain) {
    if (!chain->encoded) return 0;
    return chain->encoding == ORACLE_REC709 ? 1
           : chain->encoding == ORACLE_PQ   ? 16
           : chain->encoding == ORACLE_HLG  ? 18
                                            : 0;
}

/* The same of primaries that a picture has kept: BT.2020's alone among the oracle's pictures have one. */
static int oracle_kept_primaries(const oracle_picture *picture) {
    static const double bt2020[4][2] = {{0.708, 0.292}, {0.17, 0.797}, {0.131, 0.046}, {0.3127, 0.329}};
    for (int i = 0; i < 8; i++)
        if (fabs((double)picture->primaries.at[i / 2][i % 2] - bt2020[i / 2][i % 2]) > 1e-5) return 0;
    return 9;
}

static void oracle_compare_coding_points(const oracle_chain *chain, bool kept, const uint8_t *bytes, size_t size,
                                         oracle_verdict *verdict) {
    int primaries = kept ? oracle_kept_primaries(chain->picture) : 1, transfer = oracle_transfer(chain);
    const uint8_t *points = oracle_chunk(bytes, size, "cICP", 4);
    oracle_agree(verdict, oracle_has_chunk(bytes, size, "cICP") == (primaries && transfer), "cICP: %d", points != NULL);
    oracle_agree(verdict,
                 !points || (points[0] == primaries && points[1] == transfer && points[2] == 0 && points[3] == 1),
                 "cICP is not %d %d 0 1", primaries, transfer);
}

static void oracle_compare_chunks(const oracle_chain *chain, const uint8_t *bytes, size_t size, const oracle_png *png,
                                  oracle_verdict *verdict) {
    static const uint32_t rec709[8] = {31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000};
    bool kept = chain->picture->foreign && !chain->converted && chain->picture->planes == 3;
    const uint8_t *gamma = oracle_chunk(bytes, size, "gAMA", 4), *cube = oracle_chunk(bytes, size, "cHRM", 32);
    const uint8_t *srgb = oracle_chunk(bytes, size, "sRGB", 1);
    bool is_srgb = chain->encoded && chain->encoding == ORACLE_SRGB && !kept;
    long double exponent = !chain->encoded                   ? 1
                           : chain->encoding == ORACLE_GAMMA ? 1 / chain->encoded_by.value
                                                             : 1 / 2.2L;
    oracle_agree(verdict, is_srgb == (srgb != NULL) && is_srgb == oracle_has_chunk(bytes, size, "sRGB"),
                 "sRGB chunk: %d, should be %d", srgb != NULL, is_srgb);
    uint32_t told = gamma ? oracle_be32(gamma) : 0;
    oracle_agree(verdict, told == (oracle_transfer(chain) ? 0 : (uint32_t)floorl(100000 * exponent + 0.5L)),
                 "gAMA is %u", told);
    oracle_agree(verdict, cube ? is_srgb || kept : !is_srgb, "cHRM: %d", cube != NULL);
    oracle_compare_coding_points(chain, kept, bytes, size, verdict);
    for (int i = 0; cube && i < 8; i++) {
        long double kept_value = chain->picture->primaries.at[(i / 2 + 3) % 4][i % 2];
        long double value = kept ? 100000 * kept_value : rec709[i];
        oracle_agree(verdict, fabsl(oracle_be32(cube + 4 * i) - value) <= 0.5L, "cHRM[%d] is %u", i,
                     oracle_be32(cube + 4 * i));
    }
    unsigned samples = (unsigned)(png->colours + png->alpha);
    const uint8_t *significant = oracle_chunk(bytes, size, "sBIT", samples);
    bool coarse = chain->bits && chain->bits < png->depth;
    oracle_agree(verdict, coarse == oracle_has_chunk(bytes, size, "sBIT"), "sBIT present: %d", !coarse);
    for (int i = 0; coarse && i < png->colours; i++)
        oracle_agree(verdict, significant && significant[i] == chain->bits, "sBIT is not %d", chain->bits);
}

static long oracle_alpha_code(const oracle_chain *chain, size_t pixel) {
    long double distance;
    return wide_code(chain->picture->plane[3][pixel], chain->png_bits, &distance);
}

static void oracle_compare_pixel(const oracle_chain *chain, const oracle_png *png, int x, int y,
                                 oracle_verdict *verdict) {
    const oracle_picture *picture = chain->picture;
    exr_attr_box2i_t frame = oracle_frame(chain);
    const uint16_t *got = png->samples + ((size_t)y * png->width + (size_t)x) * (size_t)(png->colours + png->alpha);
    size_t pixel = 0;
    bool inside = oracle_inside(picture, x + frame.min.x, y + frame.min.y, &pixel);
    oracle_codes codes = {0};
    long alpha = 0;
    if (inside) codes = oracle_expect(chain, pixel);
    if (inside && png->alpha) alpha = oracle_alpha_code(chain, pixel);
    if (codes.void_pixel) verdict->excused++;
    for (int c = 0; !codes.void_pixel && c < png->colours; c++) {
        long difference = labs((long)got[c] - codes.code[c]);
        verdict->compared++;
        verdict->excused += codes.excused[c];
        oracle_agree(verdict, difference <= codes.excused[c], "(%d,%d) sample %d is %d, should be %ld", x, y, c, got[c],
                     codes.code[c]);
    }
    if (png->alpha)
        oracle_agree(verdict, got[png->colours] == alpha, "(%d,%d) alpha is %d, should be %ld", x, y, got[png->colours],
                     alpha);
}

/* every: of how many pixels one is compared. */
static inline void oracle_compare_png(const oracle_chain *chain, const void *bytes, size_t size, int every,
                                      oracle_verdict *verdict) {
    exr_attr_box2i_t frame = oracle_frame(chain);
    oracle_png png;
    bool grey = chain->picture->grey && !chain->converted;
    if (oracle_agree(verdict, oracle_read_png(bytes, size, &png), "libpng does not read it") &&
        oracle_agree(verdict,
                     (int)png.width == frame.max.x - frame.min.x + 1 &&
                         (int)png.height == frame.max.y - frame.min.y + 1,
                     "size is %u x %u", png.width, png.height) &&
        oracle_agree(verdict, png.depth == chain->png_bits, "depth is %d", png.depth) &&
        oracle_agree(verdict, (png.colours == 1) == grey, "grey: %d, should be %d", png.colours == 1, grey) &&
        oracle_agree(verdict, png.alpha == oracle_alpha_written(chain), "alpha: %d", png.alpha)) {
        oracle_compare_chunks(chain, bytes, size, &png, verdict);
        for (int y = 0; y < (int)png.height; y++)
            for (int x = 0; x < (int)png.width; x++)
                if ((x + 3 * y) % every == 0) oracle_compare_pixel(chain, &png, x, y, verdict);
    }
    free(png.samples);
}

/* ---- Floats ---- */

/* Distance of neighbouring numbers of a format around a value. */
static long double oracle_spacing(long double value, int mantissa_bits, int least_exponent) {
    int exponent = 0;
    if (value != 0) frexpl(value, &exponent);
    int spacing = exponent - mantissa_bits;
    return ldexpl(1, value == 0 || spacing < least_exponent ? least_exponent : spacing);
}

static bool oracle_float_agrees(float got, long double real) {
    if (fabsl(real) > FLT_MAX) real = copysignl(FLT_MAX, real);
    return fabsl(got - real) <= 2 * oracle_spacing(real, FLT_MANT_DIG, -149);
}

/* The nearest half, held at the largest; where the real value is as good as half way between two, either. */
static bool oracle_half_agrees(float got, long double real) {
    const long double largest = 65504, spacing = oracle_spacing(real, 11, -24);
    long double scaled = real / spacing, nearest = rintl(scaled) * spacing;
    if (fabsl(nearest) > largest) nearest = copysignl(largest, nearest);
    if (got == nearest) return true;
    return fabsl(fabsl(scaled - floorl(scaled)) - 0.5L) < oracle_excuse && fabsl(got - real) <= 0.51L * spacing;
}

/* The real value of each component of a pixel as EXR and PFM have it: associated with alpha. Outside the data window 0.
 */
static void oracle_real_pixel(const oracle_chain *chain, bool inside, size_t pixel, long double c[4]) {
    c[0] = c[1] = c[2] = c[3] = 0;
    if (!inside) return;
    oracle_pixel(chain, chain->count, pixel, c);
    c[3] = chain->picture->plane[3] ? chain->picture->plane[3][pixel] : 1;
    for (int i = 0; c[3] > 0 && i < 3; i++)
        c[i] *= c[3];
    if (chain->picture->planes == 1) c[1] = c[2] = c[0];
}

static void oracle_compare_exr_pixel(const oracle_chain *chain, const oracle_picture *out, int x, int y,
                                     oracle_verdict *verdict) {
    long double real[4];
    size_t pixel = 0, place = 0;
    bool inside = oracle_inside(chain->picture, x, y, &pixel);
    if (!oracle_inside(out, x, y, &place)) {
        oracle_agree(verdict, !inside, "(%d,%d) is not in the file", x, y);
        return;
    }
    oracle_real_pixel(chain, inside, pixel, real);
    for (int c = 0; c < 4; c++) {
        if (!out->plane[c]) continue;
        float got = out->plane[c][place];
        verdict->compared++;
        oracle_agree(verdict, chain->half ? oracle_half_agrees(got, real[c]) : oracle_float_agrees(got, real[c]),
                     "(%d,%d) channel %d is %.9g, should be %.12Lg", x, y, c, (double)got, real[c]);
    }
}

static inline void oracle_compare_exr(const oracle_chain *chain, const void *bytes, size_t size, int every,
                                      oracle_verdict *verdict) {
    exr_attr_box2i_t frame = oracle_frame(chain);
    file_bytes file = {(unsigned char *)(uintptr_t)bytes, size};
    oracle_picture out;
    if (oracle_agree(verdict, oracle_read(&file, &out), "OpenEXRCore does not read it") &&
        oracle_agree(verdict, out.planes == chain->picture->planes, "%d planes", out.planes) &&
        oracle_agree(verdict, !out.nan && !out.positive_infinity && !out.negative_infinity, "NaN or infinity") &&
        oracle_agree(verdict, (out.plane[3] != NULL) == oracle_alpha_written(chain), "alpha: %d",
                     out.plane[3] != NULL)) {
        oracle_agree(verdict, !memcmp(&out.display, &chain->picture->display, sizeof out.display), "display window");
        oracle_agree(verdict, out.foreign == (chain->picture->foreign && !chain->converted), "chromaticities: %d",
                     out.foreign);
        for (int y = frame.min.y; y <= frame.max.y; y++)
            for (int x = frame.min.x; x <= frame.max.x; x++)
                if (((unsigned)x + 3 * (unsigned)y) % (unsigned)every == 0)
                    oracle_compare_exr_pixel(chain, &out, x, y, verdict);
    }
    oracle_picture_free(&out);
}

static inline void oracle_compare_pfm(const oracle_chain *chain, const void *bytes, size_t size, int every,
                                      oracle_verdict *verdict) {
    exr_attr_box2i_t frame = oracle_frame(chain);
    int width = 0, height = 0, colours = 0;
    float *pixels = oracle_read_pfm(bytes, size, &width, &height, &colours);
    if (oracle_agree(verdict, pixels != NULL, "malformed") &&
        oracle_agree(verdict, width == frame.max.x - frame.min.x + 1 && height == frame.max.y - frame.min.y + 1,
                     "size is %d x %d", width, height) &&
        oracle_agree(verdict, colours == chain->picture->planes, "%d colours", colours))
        for (int i = 0; i < width * height; i += every) {
            long double real[4];
            size_t pixel = 0;
            bool inside = oracle_inside(chain->picture, frame.min.x + i % width, frame.min.y + i / width, &pixel);
            oracle_real_pixel(chain, inside, pixel, real);
            for (int c = 0; c < colours; c++) {
                float got = pixels[i * colours + c];
                verdict->compared++;
                oracle_agree(verdict, oracle_float_agrees(got, real[c]), "(%d,%d) channel %d is %.9g, should be %.12Lg",
                             i % width, i / width, c, (double)got, real[c]);
            }
        }
    free(pixels);
}

/* ---- Facts ---- */

/* noise: what double precision may lose where the terms of Y cancel. */
static void oracle_near(oracle_verdict *verdict, const char *name, double got, long double real, long double noise) {
    verdict->compared++;
    oracle_agree(verdict, fabsl(got - real) <= 1e-12L * fabsl(real) + noise, "%s is %.17g, should be %.18Lg", name, got,
                 real);
}

static void oracle_equal(oracle_verdict *verdict, const char *name, uint64_t got, uint64_t real) {
    verdict->compared++;
    oracle_agree(verdict, got == real, "%s is %llu, should be %llu", name, (unsigned long long)got,
                 (unsigned long long)real);
}

static inline void oracle_compare_stats(const oracle_chain *chain, const hdr_stats *stats, oracle_verdict *verdict) {
    static const char *const percents[HDR_PERCENTILES] = {"0.1", "1", "5", "25", "50", "75", "95", "99", "99.9"};
    static const char *const minimum[4] = {"min R", "min G", "min B", "min A"};
    static const char *const maximum[4] = {"max R", "max G", "max B", "max A"};
    const oracle_picture *picture = chain->picture;
    oracle_facts facts = oracle_take_facts(chain);
    const long double noise = 0x1p-52L * fmaxl(fabsl(facts.max_component), fabsl(facts.min[0]));
    oracle_equal(verdict, "pixels", stats->pixels, picture->pixels);
    oracle_equal(verdict, "lit", stats->lit, facts.lit);
    oracle_equal(verdict, "nan", stats->nan, picture->nan);
    oracle_equal(verdict, "+inf", stats->positive_infinity, picture->positive_infinity);
    oracle_equal(verdict, "-inf", stats->negative_infinity, picture->negative_infinity);
    oracle_equal(verdict, "negative", stats->negative, facts.negative);
    oracle_equal(verdict, "unlit colour", stats->unlit_colour, facts.unlit_colour);
    if (!chain->converted) oracle_equal(verdict, "grey", stats->grey, picture->grey);
    oracle_equal(verdict, "opaque", stats->opaque, picture->opaque);
    for (int c = 0; c < 4; c++) {
        oracle_near(verdict, minimum[c], stats->min[c], facts.min[c], 0);
        oracle_near(verdict, maximum[c], stats->max[c], facts.max[c], 0);
    }
    oracle_near(verdict, "min luminance", stats->min_luminance, facts.min_luminance, noise);
    oracle_near(verdict, "max luminance", stats->max_luminance, facts.max_luminance, noise);
    oracle_near(verdict, "min lit", stats->min_lit, facts.min_lit, noise);
    oracle_near(verdict, "log average", stats->log_average, facts.log_average, 0);
    oracle_values lit = oracle_take_values(chain, ORACLE_LIT);
    for (int i = 0; i < HDR_PERCENTILES; i++)
        oracle_near(verdict, percents[i], stats->percentile[i], oracle_percentile(&lit, percents[i], false), 0);
    oracle_values_free(&lit);
}

#endif

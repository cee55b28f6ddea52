/* `reinhard --local` against a direct two-dimensional sum (oracle_reinhard.h): floats and codes of whole chains, and
 * the surround by itself where the library offers a call for planes (library_scales.h).
 *
 * Tolerances. The library's exact form may cut its kernels at 8 standard deviations: what it leaves out of both axes,
 * and gets back by normalising, weighs at most 5e-15 of the largest value. Beyond that the surround agrees to 1e-12,
 * and a float result to its rounding (2^-24, and as much again for a value near half way) besides. A pixel whose choice
 * of scale hangs on less than MARGIN is not counted with --reference, nor on less than FAST_MARGIN without, as SPEC's
 * law 4 has it. */
#include "check.h"
#include "library_scales.h"
#include "oracle_check.h"
#include "oracle_run.h"
#include "oracle_shades.h"

#include <time.h>

static const double MARGIN = 1e-9, FAST_MARGIN = 1e-5;
static const double SURROUND = 1e-12, CUT = 5e-15;
enum { PIXELS_A_CODE = 10000 }; /* of the fast path, one in so many may have a code that is off by 1 */

static unsigned long floats_compared, floats_doubtful;
static unsigned long codes_compared, codes_doubtful, codes_off;
static double farthest_fast; /* float of the fast path, in proportion */

/* ---- The oracle itself ---- */

/* No fold, no skipping: every tap of the kernel by itself. */
static double every_tap(const double *plane, int width, int height, int scale, int x, int y) {
    const oracle_kernel kernel = oracle_gaussian(scale);
    double sum = 0;
    for (int j = -kernel.reach; j <= kernel.reach; j++)
        for (int i = -kernel.reach; i <= kernel.reach; i++)
            sum += kernel.weight[abs(i)] * kernel.weight[abs(j)] *
                   plane[oracle_reflect(y + j, height) * width + oracle_reflect(x + i, width)];
    return sum;
}

static void test_kernels(void) {
    for (int scale = 0; scale < ORACLE_SCALES; scale++) {
        oracle_kernel kernel = oracle_gaussian(scale);
        long double deviation = oracle_scale(scale) / 4, sum = kernel.weight[0], variance = 0;
        for (int d = 1; d <= kernel.reach; d++) {
            sum += 2 * (long double)kernel.weight[d];
            variance += 2 * (long double)kernel.weight[d] * d * d;
            /* erfc's tail; far out a pixel's integral lies between this and that of all beyond it */
            long double beyond = erfcl((d - 0.5L) / (deviation * sqrtl(2))) / 2;
            CHECK(kernel.weight[d] > 0 && kernel.weight[d] <= beyond * 1.0000001L, "scale %d: weight %d is %g", scale,
                  d, kernel.weight[d]);
        }
        CHECK(fabsl(sum - 1) < 1e-15L, "scale %d: weights add up to 1 + %Lg", scale, sum - 1);
        /* integrating over pixels adds 1/12; below a pixel's width sampling shows */
        if (deviation > 1)
            CHECK(fabsl(variance - deviation * deviation - 1 / 12.0L) < 1e-7L, "scale %d: variance %.12Lg", scale,
                  variance);
    }
    oracle_kernel finest = oracle_gaussian(0);
    CHECK(fabs(finest.weight[0] * finest.weight[0] - 0.911) < 5e-4, "the finest centre weighs %g", finest.weight[0]);
}

static void test_sums(void) {
    static const int sizes[][2] = {{24, 24}, {7, 3}, {1, 30}, {64, 48}};
    for (int kind = 0; kind < SHADES; kind++)
        for (int s = 0; s < 4; s++) {
            int width = sizes[s][0], height = sizes[s][1];
            double *plane = shade_plane((shade)kind, width, height), farthest = 0;
            double *sums = oracle_alloc((size_t)(width * height), 2 * sizeof *sums), *others = sums + width * height;
            for (int scale = s == 3 ? 5 : 0; scale < (s == 3 ? 6 : ORACLE_SCALES); scale++) {
                oracle_blur_directly(plane, width, height, scale, sums);
                oracle_blur_by_axes(plane, width, height, scale, others);
                for (int i = 0; i < width * height; i++)
                    farthest = fmax(farthest, fabs(sums[i] - others[i]) / (sums[i] > 0 ? sums[i] : 1));
                if (s != 1) continue;
                double whole = every_tap(plane, width, height, scale, 5, 1);
                CHECK(fabs(sums[width + 5] - whole) <= 1e-12 * whole, "%s, scale %d: %.17g, every tap %.17g",
                      shade_names[kind], scale, sums[width + 5], whole);
            }
            CHECK(farthest < 1e-13, "%s %dx%d: directly and by axes differ by %g", shade_names[kind], width, height,
                  farthest);
            free(plane);
            free(sums);
        }
}

/* ---- Planes ---- */

typedef struct setting {
    double scale, key, phi, epsilon;
} setting;

typedef struct answer {
    double *surround, *margin;
    unsigned char *chosen;
} answer;

static answer ask(const double *plane, int width, int height, setting with) {
    size_t pixels = (size_t)width * (size_t)height;
    answer answer = {oracle_alloc(pixels, sizeof(double)), oracle_alloc(pixels, sizeof(double)),
                     oracle_alloc(pixels, 1)};
    oracle_surround(plane, width, height, with.scale, with.key, with.phi, with.epsilon, answer.surround, answer.chosen,
                    answer.margin);
    return answer;
}

static void forget(answer *answer) {
    free(answer->surround);
    free(answer->margin);
    free(answer->chosen);
}

/* key over the average of what is lit. */
static double scale_of(const double *plane, int count, double key) {
    double sum = 0, largest = 0;
    int lit = 0;
    for (int i = 0; i < count; i++) {
        largest = fmax(largest, plane[i]);
        if (plane[i] > 0) sum += log(plane[i]), lit++;
    }
    return largest > 0 ? key / exp(sum / lit) : 1;
}

static double largest_of(const double *plane, size_t count) {
    double largest = 0;
    for (size_t i = 0; i < count; i++)
        largest = fmax(largest, plane[i]);
    return largest;
}

/* How many pixels of the surround are not what the answer says, those in doubt left out. */
static size_t count_wrong(const answer *answer, const double *surround, size_t count, double largest, double margin,
                          double *farthest) {
    size_t wrong = 0;
    for (size_t i = 0; i < count; i++) {
        double real = answer->surround[i], distance = fabs(surround[i] - real);
        if (answer->margin[i] < margin) continue;
        if (real > 0) *farthest = fmax(*farthest, distance / real);
        wrong += !(distance <= SURROUND * real + CUT * largest);
    }
    return wrong;
}

static bool planes_offered = true;

static void check_plane(shade kind, int width, int height, double key, double phi, double epsilon) {
    size_t count = (size_t)width * (size_t)height;
    double *plane = shade_plane(kind, width, height), *got = oracle_alloc(count, sizeof *got), fast = 0, exact = 0;
    setting with = {scale_of(plane, (int)count, key), key, phi, epsilon};
    if (library_surround(true, plane, width, height, with.scale, key, phi, epsilon, got)) {
        answer answer = ask(plane, width, height, with);
        double largest = largest_of(plane, count);
        size_t wrong = count_wrong(&answer, got, count, largest, MARGIN, &exact);
        CHECK(wrong == 0, "%s %dx%d, key %g, phi %g, epsilon %g: %zu of %zu surrounds are off, by up to %g",
              shade_names[kind], width, height, key, phi, epsilon, wrong, count, exact);
        if (library_surround(false, plane, width, height, with.scale, key, phi, epsilon, got))
            count_wrong(&answer, got, count, largest, FAST_MARGIN, &fast);
        fprintf(stderr, "%s %dx%d: surround within %.2g, fast path %.2g\n", shade_names[kind], width, height, exact,
                fast);
        forget(&answer);
    } else {
        planes_offered = false;
    }
    free(plane);
    free(got);
}

static void test_planes(void) {
    for (int kind = 0; kind < SHADES && planes_offered; kind++) {
        check_plane((shade)kind, 24, 24, 0.18, 8, 0.05);
        check_plane((shade)kind, 24, 24, 0.72, 4, 0.01);
        check_plane((shade)kind, 64, 48, 0.18, 8, 0.05);
        check_plane((shade)kind, 1, 1, 0.18, 8, 0.05);
        check_plane((shade)kind, 37, 1, 0.18, 8, 0.05);
        check_plane((shade)kind, 2, 90, 0.18, 8, 0.05);
    }
    if (planes_offered) check_plane(SHADE_RAMP, 65535, 1, 0.18, 8, 0.05);
    if (!planes_offered) CHECK_SKIP("the library offers no call for the surround of a plane");
}

/* That the pictures tell a constant from one that is a little off: else they would not find it in the library. */
static void test_sensitivity(void) {
    static const struct {
        const char *what;
        double scale, key, phi, epsilon;
    } others[] = {
        {"key", 1, 1.01, 1, 1}, {"scale", 1.01, 1, 1, 1}, {"phi", 1, 1, 7.9 / 8, 1}, {"epsilon", 1, 1, 1, 1.01}};
    for (size_t o = 0; o < sizeof others / sizeof *others; o++) {
        size_t found = 0;
        for (int kind = 0; kind < SHADES; kind++) {
            double *plane = shade_plane((shade)kind, 24, 24), farthest = 0;
            setting right = {scale_of(plane, 576, 0.18), 0.18, 8, 0.05};
            setting wrong = {right.scale * others[o].scale, right.key * others[o].key, right.phi * others[o].phi,
                             right.epsilon * others[o].epsilon};
            answer answer = ask(plane, 24, 24, right), other = ask(plane, 24, 24, wrong);
            found += count_wrong(&answer, other.surround, 576, largest_of(plane, 576), FAST_MARGIN, &farthest);
            forget(&answer);
            forget(&other);
            free(plane);
        }
        CHECK(found >= 5, "%s: only %zu pixels would tell", others[o].what, found);
    }
}

/* ---- Chains ---- */

/* The local step of a chain. */
static const oracle_local *local_of(const oracle_chain *chain) {
    for (int i = 0; i < chain->count; i++)
        if (chain->steps[i].local) return chain->steps[i].local;
    return NULL;
}

/* NULL: nothing is lit, and all is 0. */
static bool in_doubt(const oracle_local *local, size_t pixel, double margin) {
    return local && local->margin[pixel] < margin;
}

/* One pixel of an EXR; returns the largest distance, in proportion. */
static double float_distance(const oracle_chain *chain, const oracle_picture *out, int x, int y, size_t pixel,
                             bool inside, double cut, bool *agrees) {
    long double real[4];
    size_t place = 0;
    double farthest = 0;
    *agrees = oracle_inside(out, x, y, &place);
    oracle_real_pixel(chain, inside, pixel, real);
    for (int c = 0; *agrees && c < 3; c++) {
        if (!out->plane[c]) continue;
        long double held = copysignl(fminl(fabsl(real[c]), FLT_MAX), real[c]);
        long double distance = fabsl(out->plane[c][place] - held);
        if (distance > fabsl(held) * (0x1p-23L + SURROUND + cut) + (held != 0 ? 0x1p-149L : 0)) *agrees = false;
        if (fabsl(held) > 0x1p-120L) farthest = fmax(farthest, (double)(distance / fabsl(held)));
    }
    return farthest;
}

/* Floats of an EXR: with --reference they have to agree, else they are measured. */
static void check_floats(const char *name, const char *text, const oracle_chain *chain, bool reference,
                         const hdr_output *output) {
    size_t size = 0, wrong = 0, first_x = 0, first_y = 0;
    const void *bytes = hdr_output_bytes(output, &size);
    file_bytes file = {(unsigned char *)(uintptr_t)bytes, size};
    oracle_picture out;
    const oracle_local *local = local_of(chain);
    double farthest = 0;
    bool readable = oracle_read(&file, &out);
    CHECK(readable && !out.nan && !out.positive_infinity && !out.negative_infinity, "%s: %s: NaN or infinity", name,
          text);
    exr_attr_box2i_t frame = oracle_frame(chain);
    for (int y = frame.min.y; readable && y <= frame.max.y; y++)
        for (int x = frame.min.x; x <= frame.max.x; x++) {
            size_t pixel = 0;
            bool agrees, inside = oracle_inside(chain->picture, x, y, &pixel);
            if (inside && in_doubt(local, pixel, reference ? MARGIN : FAST_MARGIN)) {
                floats_doubtful += reference;
                continue;
            }
            double distance =
                float_distance(chain, &out, x, y, pixel, inside, local ? CUT * local->largest : 0, &agrees);
            if (!agrees && wrong++ == 0) first_x = (size_t)x, first_y = (size_t)y;
            farthest = fmax(farthest, distance);
            floats_compared += reference;
        }
    CHECK(wrong == 0 || !reference, "%s: %s: %zu pixels are off, by up to %g, first at (%zu,%zu)", name, text, wrong,
          farthest, first_x, first_y);
    if (!reference) farthest_fast = fmax(farthest_fast, farthest);
    oracle_picture_free(&out);
}

/* How far the codes of a PNG's pixel are off; excused: SPEC allows either code. */
static long code_distance(const oracle_chain *chain, const oracle_png *png, int x, int y, size_t pixel, bool inside) {
    const uint16_t *got = png->samples + ((size_t)y * png->width + (size_t)x) * (size_t)(png->colours + png->alpha);
    oracle_codes codes = {0};
    long farthest = 0;
    if (inside) codes = oracle_expect(chain, pixel);
    for (int c = 0; c < png->colours; c++) {
        long distance = labs((long)got[c] - codes.code[c]);
        if (distance > farthest && !(distance == 1 && codes.excused[c])) farthest = distance;
    }
    return farthest;
}

/* 8-bit codes: with --reference the right ones, else off by 1 at most and rarely. */
static void check_codes(const char *name, const char *text, const oracle_chain *chain, bool reference,
                        const hdr_output *output) {
    size_t size = 0;
    const void *bytes = hdr_output_bytes(output, &size);
    const oracle_local *local = local_of(chain);
    exr_attr_box2i_t frame = oracle_frame(chain);
    oracle_png png;
    bool readable = oracle_read_png(bytes, size, &png);
    unsigned long off = 0, farther = 0;
    bool fits = readable && (int)png.width == frame.max.x - frame.min.x + 1 &&
                (int)png.height == frame.max.y - frame.min.y + 1 && png.depth == 8;
    CHECK(fits, "%s: %s: not the PNG that it should be", name, text);
    for (int y = 0; fits && y < (int)png.height; y++)
        for (int x = 0; x < (int)png.width; x++) {
            size_t pixel = 0;
            bool inside = oracle_inside(chain->picture, x + frame.min.x, y + frame.min.y, &pixel);
            codes_compared += !reference;
            if (inside && in_doubt(local, pixel, reference ? MARGIN : FAST_MARGIN)) {
                codes_doubtful += !reference;
                continue;
            }
            long distance = code_distance(chain, &png, x, y, pixel, inside);
            off += distance == 1;
            farther += distance > 1;
        }
    CHECK(farther == 0, "%s: %s: %lu pixels are off by more than 1", name, text, farther);
    if (reference) CHECK(off == 0, "%s: %s: %lu pixels are off by 1", name, text, off);
    if (!reference) codes_off += off;
    if (readable) free(png.samples);
}

typedef void check_output(const char *name, const char *text, const oracle_chain *chain, bool reference,
                          const hdr_output *output);

/* The chain up to the format, in both forms. */
static void check_chain(const char *name, const file_bytes *file, const oracle_picture *picture, const char *tone,
                        const char *format, check_output *check) {
    char text[ORACLE_LINE];
    oracle_chain chain;
    snprintf(text, sizeof text, "%s then %s", tone, format);
    bool known = oracle_prepare(&chain, picture, text);
    CHECK(known, "the oracle does not know the chain: %s", text);
    for (int reference = 0; known && reference < 2; reference++) {
        hdr_error error = {0};
        if (reference) snprintf(text, sizeof text, "%s --reference then %s", tone, format);
        hdr_output *output = oracle_run(text, hdr_input_memory(file->data, file->size, name, &error), &error);
        CHECK(output != NULL, "%s: %s: %s", name, text, error.message);
        if (output) check(name, text, &chain, reference, output);
        hdr_output_free(output);
    }
    oracle_release(&chain);
}

static void check_file(const char *name, file_bytes *file, const char *tone) {
    oracle_picture picture;
    bool readable = oracle_read(file, &picture);
    CHECK(readable, "%s: OpenEXRCore does not read it", name);
    if (readable) {
        check_chain(name, file, &picture, tone, "exr", check_floats);
        check_chain(name, file, &picture, tone, "png", check_codes);
    }
    oracle_picture_free(&picture);
}

static void test_chains(void) {
    static const char *const others[] = {"reinhard --local --key 0.72",
                                         "reinhard --local --key estimate",
                                         "reinhard --local --phi 4",
                                         "reinhard --local --phi 12.5 --epsilon 0.01",
                                         "reinhard --local --epsilon 0.4",
                                         "reinhard --local --delta 0.01",
                                         "reinhard --local --delta 3 --key estimate --saturation 0.6",
                                         "reinhard --local --saturation 0 --white 2",
                                         "expose --ev 7.5 then reinhard --local --key 0.045",
                                         "reinhard --white inf then reinhard --local"};
    for (int kind = 0; kind < SHADES; kind++) {
        shade_try((shade)kind, 24, 24, false, "reinhard --local", check_file);
        shade_try((shade)kind, 64, 48, false, "reinhard --local", check_file);
        for (size_t i = 0; i < sizeof others / sizeof *others; i++)
            shade_try((shade)kind, 24, 24, i % 2, others[i], check_file);
        shade_try_sizes((shade)kind, "reinhard --local", check_file);
    }
    shade_try(SHADE_FIREFLIES, 65535, 1, false, "reinhard --local", check_file);
}

/* Other primaries, alpha, windows; black; rendered pictures. */
static void test_pictures(void) {
    static const char *const paths[] = {"testdata/tiny/black.exr",    "testdata/tiny/one.exr",
                                        "testdata/tiny/constant.exr", "testdata/tiny/wide.exr",
                                        "testdata/tiny/specials.exr", "testdata/interior_float.exr",
                                        "testdata/glossy.exr"};
    scenes_try(5000, "reinhard --local", "reinhard --local", check_file);
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++)
        file_try(paths[i], "reinhard --local", check_file);
}

int main(void) {
    test_kernels();
    test_sums();
    test_sensitivity();
    test_planes();
    test_chains();
    test_pictures();
    fprintf(stderr, "%lu pixels' floats compared, %lu in doubt; %lu pixels' codes, %lu in doubt, %lu off by 1\n",
            floats_compared, floats_doubtful, codes_compared, codes_doubtful, codes_off);
    fprintf(stderr, "fast path: floats within %.2g\n", farthest_fast);
    CHECK(codes_off * PIXELS_A_CODE <= codes_compared, "%lu of %lu pixels' codes are off by 1", codes_off,
          codes_compared);
    /* else there would be little left to compare */
    CHECK(floats_doubtful * 1000 <= floats_compared && codes_doubtful * 100 <= codes_compared,
          "too many choices hang on too little");
    return check_done("test_reinhard_local");
}

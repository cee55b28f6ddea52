/* `durand` against its definition (oracle_durand.h): the exact filter on planes, then floats and codes of whole chains.
 *
 * Tolerances. The library's exact sum may be cut at 8 standard deviations: what it leaves out weighs at most e^-32 =
 * 1.3e-14 a pixel, where a pixel's own weight is 1, so that 1e-12 still holds. The fast path has the bound that
 * hdr_bilateral_choose states for numbers that float holds, and may round the base to float besides. */
#include "check.h"
#include "oracle_durand.h"
#include "oracle_png.h"
#include "oracle_run.h"
#include "oracle_shades.h"

#include "spatial/bilateral.h"
#include "spatial/ranks.h"

#include <float.h>

static const double EXACT = 1e-12;
static const long double PROPORTION = 0x1p-22L, EXCUSE = 1e-9L;
enum { OFTEN = 100 }; /* of the fast path, one pixel in so many may have a code that is off by 1 */

static hdr_pool *pool;
static double farthest_exact, farthest_cut, farthest_float, farthest_base, farthest_share, farthest_wide;
static unsigned long codes_compared, codes_off, codes_excused;

/* ---- Planes ---- */

/* i = log10 of a shade's light, what is dark being the least. */
static double *logarithms_of(shade kind, int width, int height) {
    size_t count = (size_t)width * (size_t)height;
    double *plane = shade_plane(kind, width, height), least = INFINITY;
    for (size_t i = 0; i < count; i++)
        if (plane[i] > 0 && plane[i] < least) least = plane[i];
    for (size_t i = 0; i < count; i++)
        plane[i] = isfinite(least) ? log10(plane[i] > 0 ? plane[i] : least) : 0;
    return plane;
}

static hdr_plane *library_plane(const double *numbers, int width, int height, bool wide) {
    hdr_error error = {0};
    hdr_plane *plane = hdr_plane_new(width, height, wide, &error);
    if (!plane) abort();
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            size_t at = (size_t)y * plane->stride + (size_t)x;
            double number = numbers[(size_t)y * (size_t)width + (size_t)x];
            if (wide)
                plane->wide[at] = number;
            else
                plane->narrow[at] = (float)number;
        }
    return plane;
}

static double number_at(const hdr_plane *plane, int x, int y) {
    size_t at = (size_t)y * plane->stride + (size_t)x;
    return plane->wide ? plane->wide[at] : (double)plane->narrow[at];
}

/* The farthest that a plane is from numbers, each less what rounding may do. */
static double distance_of(const hdr_plane *plane, const double *numbers, double rounding) {
    double farthest = 0;
    for (int y = 0; y < plane->height; y++)
        for (int x = 0; x < plane->width; x++, numbers++) {
            double distance = fabs(number_at(plane, x, y) - *numbers) - rounding * fabs(*numbers);
            if (!(distance <= farthest)) farthest = distance;
        }
    return farthest;
}

static void check_exact(const char *name, const double *numbers, const double *expected, hdr_bilateral filter,
                        int width, int height) {
    hdr_error error = {0};
    for (int kind = 0; kind < 4; kind++) { /* wide, narrow; into another plane, or the same */
        bool wide = kind % 2 == 0;
        hdr_plane *plane = library_plane(numbers, width, height, wide), *base = plane;
        if (kind < 2) base = hdr_plane_new(width, height, wide, &error);
        hdr_status status = hdr_bilateral_exact(&filter, HDR_EXACT_REACH, plane, base, pool, &error);
        double distance = distance_of(base, expected, wide ? 0 : 0x1p-23);
        /* a narrow plane starts from other numbers: check_chain sees to these */
        if (wide) farthest_exact = fmax(farthest_exact, distance);
        CHECK(status == HDR_OK && (!wide || distance <= EXACT), "%s %dx%d, sigma %g and %g: the exact sum is off by %g",
              name, width, height, filter.sigma_s, filter.sigma_r, distance);
        if (base != plane) hdr_plane_free(base);
        hdr_plane_free(plane);
    }
    hdr_plane *plane = library_plane(numbers, width, height, true);
    hdr_pixel pixels[3] = {{0, 0}, {width / 2, height / 3}, {width - 1, height - 1}};
    double values[3] = {0};
    hdr_status status = hdr_bilateral_exact_at(&filter, HDR_EXACT_REACH, plane, 3, pixels, values, pool, &error);
    for (int i = 0; i < 3; i++) {
        double real = expected[(size_t)pixels[i].y * (size_t)width + (size_t)pixels[i].x];
        CHECK(status == HDR_OK && fabs(values[i] - real) <= EXACT, "%s %dx%d: at (%d,%d) %.17g, should be %.17g", name,
              width, height, pixels[i].x, pixels[i].y, values[i], real);
    }
    hdr_plane_free(plane);
}

static void check_plane(const char *name, const double *numbers, int width, int height) {
    const size_t count = (size_t)width * (size_t)height;
    const int larger = width > height ? width : height;
    const double spatial[] = {0.5, 0.02 * larger, 1.7, 0.1 * larger, 0.5 * larger}, range[] = {0.1, 0.4, 1};
    double *base = oracle_alloc(count, 2 * sizeof *base), *cut = base + count, low = numbers[0], high = low;
    for (size_t i = 0; i < count; i++) {
        low = fmin(low, numbers[i]);
        high = fmax(high, numbers[i]);
    }
    for (int s = 0; s < 5; s++)
        for (int r = 0; r < 3; r++) {
            if (spatial[s] < 0.1 || (count > 700 && (s + r) % 3)) continue; /* a large plane meets every third pair */
            oracle_bilateral(numbers, width, height, spatial[s], range[r], ORACLE_WHOLE, base);
            if (count < 700)
                oracle_bilateral(numbers, width, height, spatial[s], range[r], (int)ceil(8 * spatial[s]), cut);
            for (size_t i = 0; count < 700 && i < count; i++)
                farthest_cut = fmax(farthest_cut, fabs(base[i] - cut[i]));
            hdr_bilateral filter = {.sigma_s = spatial[s], .sigma_r = range[r], .low = low, .high = high};
            check_exact(name, numbers, base, filter, width, height);
        }
    free(base);
}

static void test_planes(void) {
    static const int sizes[][2] = {{24, 24}, {48, 40}, {1, 1}, {2, 1}, {61, 1}, {1, 47}, {3, 29}};
    for (int kind = 0; kind < SHADES; kind++)
        for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
            double *numbers = logarithms_of((shade)kind, sizes[s][0], sizes[s][1]);
            check_plane(shade_names[kind], numbers, sizes[s][0], sizes[s][1]);
            free(numbers);
        }
}

/* Answers that are known without a sum. */
static void test_oracle(void) {
    double flat[30], two[2] = {0, 1}, base[30];
    for (int i = 0; i < 30; i++)
        flat[i] = -3.25;
    oracle_bilateral(flat, 6, 5, 2, 0.4, ORACLE_WHOLE, base);
    for (int i = 0; i < 30; i++)
        CHECK(fabs(base[i] + 3.25) < 1e-15, "a flat plane becomes %.17g", base[i]);
    /* w = exp(-1 / (2 3^2) - 1 / (2 0.5^2)) */
    oracle_bilateral(two, 2, 1, 3, 0.5, ORACLE_WHOLE, base);
    double weight = exp(-1 / 18.0 - 2);
    CHECK(fabs(base[0] - weight / (1 + weight)) < 1e-16 && fabs(base[1] - 1 / (1 + weight)) < 1e-15,
          "two pixels become %.17g and %.17g", base[0], base[1]);
    static const double ten[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
    CHECK(oracle_rank(ten, 10, "0", false) == 1 && oracle_rank(ten, 10, "0", true) == 10 &&
              oracle_rank(ten, 10, "10", false) == 1 && oracle_rank(ten, 10, "10.001", false) == 2 &&
              oracle_rank(ten, 10, "10", true) == 9 && oracle_rank(ten, 10, "0.1", true) == 10 &&
              oracle_rank(ten, 10, "50", false) == 5,
          "nearest ranks");
}

/* ---- Chains ---- */

/* What a chain is compared with. */
typedef struct expectation {
    const char *name, *tone; /* the picture, and "durand ..." */
    const oracle_picture *picture;
    oracle_durand wide, narrow; /* from exact numbers, and from those that float holds */
    double bound;               /* of the fast path, on the base */
} expectation;

/* The expected components in the file: associated; outside the data window 0. */
static bool expected_pixel(const oracle_durand *d, int x, int y, bool associate, long double c[3], size_t *pixel) {
    const oracle_picture *picture = d->picture;
    c[0] = c[1] = c[2] = 0;
    if (x < picture->data.min.x || y < picture->data.min.y || x > picture->data.max.x || y > picture->data.max.y)
        return false;
    *pixel = (size_t)(y - picture->data.min.y) * (size_t)picture->width + (size_t)(x - picture->data.min.x);
    oracle_durand_colour(d, *pixel, c);
    long double alpha = picture->plane[3] ? picture->plane[3][*pixel] : 1;
    for (int p = 0; associate && alpha > 0 && p < 3; p++)
        c[p] *= alpha;
    return true;
}

/* Floats of --reference. */
static void check_floats(const expectation *e, const void *bytes, size_t size) {
    file_bytes file = {(unsigned char *)(uintptr_t)bytes, size};
    oracle_picture out;
    size_t wrong = 0, pixel, place = 0;
    bool readable = oracle_read(&file, &out);
    CHECK(readable && !out.nan && !out.positive_infinity && !out.negative_infinity, "%s: %s: NaN or infinity", e->name,
          e->tone);
    for (int y = out.data.min.y; readable && y <= out.data.max.y; y++)
        for (int x = out.data.min.x; x <= out.data.max.x; x++, place++) {
            long double real[3];
            expected_pixel(&e->wide, x, y, true, real, &pixel);
            for (int p = 0; p < out.planes; p++) {
                long double distance = fabsl(out.plane[p][place] - real[p]);
                long double allowed = fabsl(real[p]) * PROPORTION + (real[p] != 0 ? 0x1p-149L : 0);
                if (!(distance <= allowed)) wrong++;
                if (fabsl(real[p]) > 0x1p-120L)
                    farthest_float = fmax(farthest_float, (double)(distance / fabsl(real[p])));
            }
        }
    CHECK(wrong == 0, "%s: %s --reference: %zu floats are off", e->name, e->tone, wrong);
    oracle_picture_free(&out);
}

/* The base of the fast path, from the picture of the detail: Ld = 0.18 10^(i - base). */
static void check_base(const expectation *e, const void *bytes, size_t size) {
    file_bytes file = {(unsigned char *)(uintptr_t)bytes, size};
    oracle_picture out;
    const oracle_picture *in = e->picture;
    bool readable = oracle_read(&file, &out) && out.pixels == in->pixels && out.planes == in->planes;
    CHECK(readable, "%s: %s: not the picture that it should be", e->name, e->tone);
    /* what works in double starts from unrounded numbers */
    const oracle_durand *d = strstr(e->tone, "--method exact") ? &e->wide : &e->narrow;
    double farthest = 0, rounding = 0, from_wide = 0;
    for (size_t i = 0; readable && i < in->pixels; i++) {
        if (!d->lit[i]) continue;
        int brightest = 0;
        for (int p = 1; p < in->planes; p++)
            if (in->plane[p][i] > in->plane[brightest][i]) brightest = p;
        long double ld = out.plane[brightest][i] * (d->intensity[i] / in->plane[brightest][i]);
        double base = (double)(log10l(d->intensity[i]) - log10l(ld / 0.18L));
        farthest = fmax(farthest, fabs(base - d->base[i]));
        from_wide = fmax(from_wide, fabs(base - e->wide.base[i]));
        rounding = fmax(rounding, 0x1p-22 * (1 + fabs(d->base[i])));
    }
    CHECK(farthest <= e->bound + rounding, "%s: %s: the base is off by %.3g, the stated bound is %.3g", e->name,
          e->tone, farthest, e->bound);
    farthest_base = fmax(farthest_base, farthest);
    farthest_wide = fmax(farthest_wide, from_wide);
    if (e->bound > 1e-5) farthest_share = fmax(farthest_share, farthest / e->bound);
    oracle_picture_free(&out);
}

static long code_of(long double v, long double *doubt) {
    v = fminl(fmaxl(v, 0), 1);
    long double code = 255 * (v <= 0.0031308L ? 12.92L * v : 1.055L * powl(v, 1 / 2.4L) - 0.055L) + 0.5L;
    *doubt = fabsl(code - rintl(code));
    return (long)floorl(code);
}

/* 8-bit codes: with --reference the right ones, else off by 1 at most, and rarely. */
static void check_codes(const expectation *e, bool reference, const void *bytes, size_t size) {
    oracle_png png;
    size_t pixel = 0, off = 0, farther = 0, count = 0;
    bool readable = oracle_read_png(bytes, size, &png) && png.depth == 8;
    CHECK(readable, "%s: %s: not the PNG that it should be", e->name, e->tone);
    for (int y = 0; readable && y < (int)png.height; y++)
        for (int x = 0; x < (int)png.width; x++, count++) {
            const uint16_t *got = png.samples + ((size_t)y * png.width + (size_t)x) * (size_t)(png.colours + png.alpha);
            long double real[3], doubt;
            long farthest = 0;
            expected_pixel(&e->wide, x + e->picture->display.min.x, y + e->picture->display.min.y, false, real, &pixel);
            for (int p = 0; p < png.colours; p++) {
                long distance = labs((long)got[p] - code_of(real[p], &doubt));
                bool excused = reference && distance == 1 && doubt < EXCUSE;
                codes_excused += excused;
                if (!excused && distance > farthest) farthest = distance;
            }
            off += farthest == 1;
            farther += farthest > 1;
        }
    CHECK(farther == 0 && (!reference || off == 0), "%s: %s%s: %zu codes are off by 1, %zu by more", e->name, e->tone,
          reference ? " --reference" : "", off, farther);
    CHECK(reference || count < 500 || off * OFTEN <= count, "%s: %s: the codes of %zu of %zu pixels are off", e->name,
          e->tone, off, count);
    if (!reference) codes_off += off, codes_compared += count;
    if (readable) free(png.samples);
}

typedef enum output { FLOATS, BASE, CODES, REFERENCE_CODES } output;

static void run_chain(const expectation *e, const file_bytes *file, output kind) {
    static const char *const rest[] = {"--reference then exr", "--show detail then exr", "then png",
                                       "--reference then png"};
    char text[ORACLE_LINE];
    hdr_error error = {0};
    snprintf(text, sizeof text, "%s %s", e->tone, rest[kind]);
    hdr_output *output = oracle_run(text, hdr_input_memory(file->data, file->size, e->name, &error), &error);
    CHECK(output != NULL, "%s: %s: %s", e->name, text, error.message);
    if (!output) return;
    size_t size = 0;
    const void *bytes = hdr_output_bytes(output, &size);
    if (kind == FLOATS)
        check_floats(e, bytes, size);
    else if (kind == BASE)
        check_base(e, bytes, size);
    else
        check_codes(e, kind == REFERENCE_CODES, bytes, size);
    hdr_output_free(output);
}

/* What is stated of the method that these options lead to. */
static double stated_bound(const expectation *e) {
    const oracle_picture *picture = e->picture;
    const char *typed = strstr(e->tone, "--tolerance ");
    if (strstr(e->tone, "--method exact")) return 0;
    hdr_error error = {0};
    hdr_plane *plane = library_plane(e->narrow.logarithm, picture->width, picture->height, false);
    hdr_bilateral filter = {.sigma_s = oracle_sigma_s(&e->narrow.options, picture->width, picture->height),
                            .sigma_r = (double)e->narrow.options.sigma_r};
    hdr_plane_range(plane, &filter.low, &filter.high, pool, &error);
    double tolerance = typed ? strtod(typed + 12, NULL) : 0.001;
    hdr_bilateral_choice choice = hdr_bilateral_choose(&filter, plane, tolerance, strstr(e->tone, "--method grid"),
                                                       strstr(e->tone, "--method direct"));
    hdr_plane_free(plane);
    CHECK(choice.bound <= tolerance || strstr(e->tone, "--method"), "%s: %s: a bound of %g for a tolerance of %g",
          e->name, e->tone, choice.bound, tolerance);
    return choice.bound;
}

/* Pictures that are large against the filter are summed over a part: what is beyond 10 deviations weighs 1e-22. */
static int reach_for(const oracle_picture *picture, const oracle_durand_options *options) {
    if (picture->pixels <= 2500) return ORACLE_WHOLE;
    return (int)ceil(10 * oracle_sigma_s(options, picture->width, picture->height));
}

static void check_chain(const char *name, file_bytes *file, const char *tone) {
    oracle_picture picture;
    oracle_durand_options options;
    bool known = oracle_durand_parse(tone, &options), readable = oracle_read(file, &picture);
    CHECK(known && readable, "%s: %s: not for the oracle", name, tone);
    if (known && readable) {
        expectation e = {.name = name, .tone = tone, .picture = &picture};
        int reach = reach_for(&picture, &options);
        e.wide = oracle_durand_of(&picture, &options, reach, false);
        e.narrow = oracle_durand_of(&picture, &options, reach, true);
        e.bound = stated_bound(&e);
        run_chain(&e, file, FLOATS);
        if (!picture.foreign) {
            run_chain(&e, file, CODES);
            run_chain(&e, file, REFERENCE_CODES);
        }
        bool plain = !picture.plane[3] && !picture.border && options.saturation == 1;
        if (plain && options.show == ORACLE_SHOW_PICTURE && e.wide.lit_count) run_chain(&e, file, BASE);
        oracle_durand_free(&e.wide);
        oracle_durand_free(&e.narrow);
    }
    oracle_picture_free(&picture);
}

static void test_chains(void) {
    static const char *const tones[] = {"durand --sigma-s 3px",
                                        "durand --sigma-s 0.5 --sigma-r 0.1",
                                        "durand --sigma-s 0.1 --sigma-r 1",
                                        "durand --sigma-s 2.5px --intensity durand",
                                        "durand --sigma-s 3px --percentile 0",
                                        "durand --sigma-s 3px --percentile 5 --contrast 1.5",
                                        "durand --sigma-s 3px --percentile 33.33 --contrast 1000",
                                        "durand --sigma-s 0.25 --contrast 1e9",
                                        "durand --sigma-s 3px --saturation 0.6 --intensity durand",
                                        "durand --sigma-s 3px --saturation 0",
                                        "durand --sigma-s 3px --show base",
                                        "durand --sigma-s 3px --show detail --intensity durand",
                                        "durand --sigma-s 5px --method grid",
                                        "durand --sigma-s 5px --method grid --tolerance 0.01",
                                        "durand --sigma-s 5px --method grid --tolerance 1e-5",
                                        "durand --sigma-s 3px --method direct --tolerance 0.01",
                                        "durand --sigma-s 0.1px --method exact",
                                        "durand --sigma-s 3px --method exact --sigma-r 0.1",
                                        "durand --sigma-s 4px --tolerance 1e-5"};
    for (int kind = 0; kind < SHADES; kind++) {
        shade_try((shade)kind, 48, 40, false, "durand", check_chain);
        shade_try((shade)kind, 48, 40, true, "durand --sigma-s 4px", check_chain);
        for (size_t i = 0; i < sizeof tones / sizeof *tones; i++)
            shade_try((shade)kind, 24, 24, i % 2, tones[i], check_chain);
        shade_try_sizes((shade)kind, "durand", check_chain);
    }
}

/* Other primaries, alpha, windows; black; a rendered picture. */
static void test_pictures(void) {
    static const char *const paths[] = {"testdata/tiny/black.exr", "testdata/tiny/one.exr",
                                        "testdata/tiny/constant.exr", "testdata/tiny/wide.exr",
                                        "testdata/tiny/specials.exr"};
    scenes_try(2500, "durand", "durand --sigma-s 3px --intensity durand", check_chain);
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++)
        file_try(paths[i], "durand", check_chain);
    file_try("testdata/interior_float.exr", "durand --sigma-s 2px", check_chain);
}

int main(void) {
    hdr_error error = {0};
    pool = hdr_pool_new(2, &error);
    if (!pool) abort();
    test_oracle();
    test_planes();
    test_chains();
    test_pictures();
    fprintf(stderr, "exact sum within %.2g; a cut at 8 deviations makes %.2g; --reference floats within %.2g\n",
            farthest_exact, farthest_cut, farthest_float);
    fprintf(stderr, "fast path: base within %.2g, at most %.2g of the bound; %.2g from the base of unrounded numbers\n",
            farthest_base, farthest_share, farthest_wide);
    fprintf(stderr, "%lu pixels' codes, %lu off by 1; %lu of --reference excused\n", codes_compared, codes_off,
            codes_excused);
    CHECK(codes_off * OFTEN <= codes_compared, "%lu of %lu pixels' codes are off by 1", codes_off, codes_compared);
    hdr_pool_free(pool);
    return check_done("test_durand");
}

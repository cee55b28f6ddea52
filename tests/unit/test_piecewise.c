/* The paper's fast algorithm: against its published pseudocode in double, evaluated plainly, and against the bilateral
 * filter itself, which it may miss by no more than its bound; the same bytes for any number of threads, any instruction
 * set, and with what nobody needs computed, too. */
#include "check.h"
#include "kernels.h"
#include "levels.h"
#include "base/cpu.h"
#include "spatial/bilateral.h"

#include <stdlib.h>

/* ---- Scenes ---- */

typedef enum kind { NOISE, RAMP, CONSTANT, STEPS, FIREFLIES, CROWDS, CELLS, ISLAND, KINDS } kind;
static const char *const kinds[] = {"noise", "ramp", "constant", "steps", "fireflies", "crowds", "cells", "island"};

/* In a scene of crowds a few pixels, at certain places, belong to neither: they are between them. */
static bool is_alone(int x, int y) {
    return x % 17 == 8 && y % 13 == 6;
}

static double of_crowds(int x, int y, double apart) {
    double noise = 0.02 * apart * (random_unit() - 0.5);
    return is_alone(x, y) ? apart * (0.3 + 0.4 * random_unit()) : apart * (random_bits() % 2) + noise;
}

/* A pixel by itself, in the middle of what is too far away in range to be seen, in what is too far away in either way
 * to matter but for being all there is. */
static double of_island(double across, double down, double sigma_s, double sigma_r) {
    double distance = hypot(across, down) / sigma_s;
    return distance == 0 ? 0 : sigma_r * (distance < 5.5 ? 20 : 12.2 + 0.7 * random_unit());
}

/* Two crowds are so far apart that a pixel halfway, with sigma_s, sees them about as much as itself. */
static hdr_plane *scene_of(kind kind, int width, int height, double decades, double sigma_s, double sigma_r) {
    hdr_error error = {0};
    hdr_plane *plane = hdr_plane_new(width, height, false, &error);
    if (!plane) abort();
    double base = random_signed(-3, 3), bottom = decades * random_unit();
    double apart = sigma_r * 2 * sqrt(2 * log(1 + 6.28 * sigma_s * sigma_s)) * (0.7 + 0.5 * random_unit());
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            double number = 0;
            if (kind == NOISE) number = decades * random_unit();
            if (kind == RAMP) number = decades * (x + y * 0.7 + 0.1 * random_unit()) / (width + height);
            if (kind == STEPS) number = decades * ((x / 7 + y / 5) % 3) / 2 + 0.1 * random_unit();
            if (kind == FIREFLIES) number = random_bits() % 60 ? 0.5 * random_unit() : decades * random_unit();
            if (kind == CROWDS) number = x + y ? of_crowds(x, y, apart) : -bottom;
            if (kind == CELLS) number = decades * ((x / 16 * 31 + y / 16 * 17) % 5) / 4 + of_crowds(x, y, apart);
            if (kind == ISLAND) number = of_island(x - width / 2, y - height / 2, sigma_s, sigma_r);
            plane->narrow[(size_t)y * plane->stride + (size_t)x] = (float)(base + number);
        }
    return plane;
}

static hdr_plane *copy_of(const hdr_plane *plane) {
    hdr_error error = {0};
    hdr_plane *copy = hdr_plane_new(plane->width, plane->height, false, &error);
    if (!copy) abort();
    for (int y = 0; y < plane->height; y++)
        memcpy(copy->narrow + (size_t)y * copy->stride, plane->narrow + (size_t)y * plane->stride,
               (size_t)plane->width * sizeof(float));
    return copy;
}

static double number_at(const hdr_plane *plane, int x, int y) {
    return (double)plane->narrow[(size_t)y * plane->stride + (size_t)x];
}

static hdr_bilateral filter_of(const hdr_plane *plane, double sigma_s, double sigma_r) {
    hdr_bilateral filter = {.sigma_s = sigma_s, .sigma_r = sigma_r, .low = INFINITY, .high = -INFINITY};
    for (int y = 0; y < plane->height; y++)
        for (int x = 0; x < plane->width; x++) {
            filter.low = fmin(filter.low, number_at(plane, x, y));
            filter.high = fmax(filter.high, number_at(plane, x, y));
        }
    return filter;
}

static hdr_plane *base_of(const hdr_bilateral *filter, int subsample, const hdr_plane *plane, int threads,
                          hdr_bilateral_report *report) {
    hdr_error error = {0};
    hdr_pool *pool = hdr_pool_new(threads, &error);
    hdr_plane *base = copy_of(plane);
    hdr_status status = hdr_bilateral_piecewise(filter, subsample, base, pool, report, &error);
    CHECK(status == HDR_OK, "%s", error.message);
    hdr_pool_free(pool);
    return base;
}

static bool same_plane(const hdr_plane *a, const hdr_plane *b) {
    for (int y = 0; y < a->height; y++)
        if (memcmp(a->narrow + (size_t)y * a->stride, b->narrow + (size_t)y * b->stride,
                   (size_t)a->width * sizeof(float)))
            return false;
    return true;
}

/* ---- The pseudocode ---- */

/* J_j at a sample: sums over all samples within f's reach. */
static double plain_j(const hdr_bilateral *f, const hdr_plane *plane, int subsample, const int first[2], double node,
                      int sx, int sy) {
    double sigma = f->sigma_s / subsample, k = 0, h = 0;
    int reach = (int)ceil(6.5 * sigma);
    for (int dy = -reach; dy <= reach; dy++)
        for (int dx = -reach; dx <= reach; dx++) {
            int x = first[0] + (sx + dx) * subsample, y = first[1] + (sy + dy) * subsample;
            if (x < 0 || y < 0 || x >= plane->width || y >= plane->height) continue;
            double i = number_at(plane, x, y), z = (i - node) / f->sigma_r;
            double g = fabs(z) <= 13 ? exp(-0.5 * z * z) : 0;
            double weight = g * exp(-0.5 * (dx * dx + dy * dy) / (sigma * sigma));
            k += weight;
            h += weight * i;
        }
    return k > 0 ? h / k : node;
}

static int sample_before(int distance, int subsample, int samples, double *share) {
    double place = fmin(fmax((double)distance / subsample, 0), samples - 1);
    int before = samples > 1 ? (int)fmin(floor(place), samples - 2) : 0;
    *share = place - before;
    return before;
}

/* J_j at a pixel: bilinear between four samples. */
static double plain_upsampled(const hdr_bilateral *f, const hdr_plane *plane, int subsample, double node, int x,
                              int y) {
    int first[2] = {(plane->width - 1) % subsample / 2, (plane->height - 1) % subsample / 2};
    double across, down, sum = 0;
    int sx = sample_before(x - first[0], subsample, (plane->width - 1) / subsample + 1, &across);
    int sy = sample_before(y - first[1], subsample, (plane->height - 1) / subsample + 1, &down);
    for (int n = 0; n < 4; n++) {
        double weight = (n % 2 ? across : 1 - across) * (n / 2 ? down : 1 - down);
        if (weight > 0) sum += weight * plain_j(f, plane, subsample, first, node, sx + n % 2, sy + n / 2);
    }
    return sum;
}

static double plain_base(const hdr_bilateral *f, const hdr_plane *plane, int subsample, int x, int y) {
    double range = f->high - f->low, i = number_at(plane, x, y);
    if (range == 0) return i;
    double segments = fmax(1, ceil(range / f->sigma_r - 1e-3)),
           j = fmin(floor((i - f->low) / range * segments), segments - 1);
    double t = (i - f->low) / range * segments - j;
    double before = t < 1 ? plain_upsampled(f, plane, subsample, f->low + j * range / segments, x, y) : 0;
    double behind = t > 0 ? plain_upsampled(f, plane, subsample, f->low + (j + 1) * range / segments, x, y) : 0;
    return (1 - t) * before + t * behind;
}

/* Rounding moves J_j by what it is of a crowd's weight times the squared distance of crowds, in sigma_r. */
static void check_pseudocode(const hdr_bilateral *filter, int subsample, const hdr_plane *plane, const char *name) {
    hdr_bilateral_report report;
    hdr_plane *base = base_of(filter, subsample, plane, 1, &report);
    double farthest = 0, apart = fmin(filter->high - filter->low, 26 * filter->sigma_r);
    for (int y = 0; y < plane->height; y++)
        for (int x = 0; x < plane->width; x++) {
            double distance = fabs(number_at(base, x, y) - plain_base(filter, plane, subsample, x, y));
            farthest = distance > farthest ? distance : farthest;
        }
    double room = 0x1p-22 * fmax(fabs(filter->low), fabs(filter->high)) + 0x1p-19 * apart;
    CHECK(farthest <= room, "%s, subsampled by %d: %g from the pseudocode, %g is float's", name, subsample, farthest,
          room);
    hdr_plane_free(base);
}

static void test_pseudocode(void) {
    static const int sizes[][2] = {{1, 1}, {1, 9}, {23, 1}, {4, 4}, {33, 17}, {40, 19}};
    static const int subsamples[] = {1, 4, 7};
    for (int n = 0; n < 3 * 6 * KINDS; n++) {
        const int *size = sizes[n / KINDS % 6];
        double sigma_r = n % 2 ? 0.4 : 0.1 + random_unit(), decades = sigma_r * (0.5 + 20 * random_unit());
        int subsample = subsamples[n / KINDS / 6];
        double sigma_s = (0.3 + random_unit()) * subsample;
        hdr_plane *plane = scene_of((kind)(n % KINDS), size[0], size[1], decades, sigma_s, sigma_r);
        hdr_bilateral filter = filter_of(plane, sigma_s, sigma_r);
        char name[100];
        snprintf(name, sizeof name, "%s, %d x %d, %.3g by %.3g", kinds[n % KINDS], size[0], size[1], sigma_s, sigma_r);
        check_pseudocode(&filter, subsample, plane, name);
        hdr_plane_free(plane);
    }
}

/* ---- The bound ---- */

static double farthest_in_all, nearest_to_bound; /* in sigma_r; as a part of the bound */

/* The farthest of pixels at random and of those between crowds. */
static double distance_from_exact(const hdr_bilateral *filter, const hdr_plane *plane, const hdr_plane *base) {
    enum { PIXELS = 200 };
    hdr_pixel pixels[PIXELS];
    double exact[PIXELS], farthest = 0;
    int count = 0;
    for (; count < PIXELS / 4; count++)
        pixels[count] =
            (hdr_pixel){(int)(random_bits() % (uint64_t)plane->width), (int)(random_bits() % (uint64_t)plane->height)};
    for (int y = 0; y < plane->height; y++)
        for (int x = 0; x < plane->width && count < PIXELS; x++)
            if (is_alone(x, y)) pixels[count++] = (hdr_pixel){x, y};
    hdr_error error = {0};
    hdr_pool *pool = hdr_pool_new(2, &error);
    hdr_bilateral_exact_at(filter, HDR_EXACT_REACH, plane, count, pixels, exact, pool, &error);
    hdr_pool_free(pool);
    for (int i = 0; i < count; i++)
        farthest = fmax(farthest, fabs(number_at(base, pixels[i].x, pixels[i].y) - exact[i]));
    return farthest;
}

static void test_bound(int scenes) {
    for (int n = 0; n < scenes; n++) {
        int width = 1 + (int)(random_bits() % 150), height = 1 + (int)(random_bits() % 150);
        double sigma_r = 0.05 + random_unit(), sigma_s = 0.5 * pow(100, random_unit());
        hdr_plane *plane = scene_of((kind)(n % KINDS), width, height, pow(12, random_unit()), sigma_s, sigma_r);
        hdr_bilateral filter = filter_of(plane, sigma_s, sigma_r);
        hdr_bilateral_report report;
        hdr_plane *base = base_of(&filter, 1, plane, 2, &report);
        double farthest = distance_from_exact(&filter, plane, base) / sigma_r;
        double bound = hdr_piecewise_bound(1, sigma_s);
        double rounding = 0x1p-21 * fmax(fabs(filter.low), fabs(filter.high)) / sigma_r;
        CHECK(farthest <= bound + rounding, "%s, %d x %d, sigma_s %g: %g sigma_r from the exact base, not %g",
              kinds[n % KINDS], width, height, sigma_s, farthest, bound);
        farthest_in_all = fmax(farthest_in_all, farthest);
        nearest_to_bound = fmax(nearest_to_bound, (farthest - rounding) / bound);
        hdr_plane_free(base);
        hdr_plane_free(plane);
    }
    CHECK(isinf(hdr_piecewise_bound(2, 40)), "what is not sampled is not seen, yet there is a bound");
}

/* ---- What holds for any picture ---- */

static void check_sameness(const hdr_bilateral *filter, int subsample, const hdr_plane *plane, const hdr_plane *base,
                           const char *name) {
    hdr_bilateral all = *filter;
    all.no_skip = true;
    hdr_bilateral_report report, whole_report;
    hdr_plane *threads = base_of(filter, subsample, plane, 3, &report);
    hdr_plane *whole = base_of(&all, subsample, plane, 2, &whole_report);
    CHECK(same_plane(base, threads), "%s, subsampled by %d: threads make a difference", name, subsample);
    CHECK(same_plane(base, whole), "%s, subsampled by %d: what was left out makes a difference", name, subsample);
    CHECK(report.cells == (uint64_t)report.segments + 1 && report.used <= report.cells && report.used >= 2 &&
              whole_report.used == whole_report.cells,
          "%s: %llu and %llu of %llu values", name, (unsigned long long)report.used,
          (unsigned long long)whole_report.used, (unsigned long long)report.cells);
    hdr_plane_free(threads);
    hdr_plane_free(whole);
}

/* No base is beyond the numbers. Returns a digest. */
static uint64_t check_bases(const hdr_bilateral *filter, int subsample, const hdr_plane *base, const char *name) {
    size_t beyond = 0;
    uint64_t digest = 0;
    double rounding = 0x1p-21 * fmax(fabs(filter->low), fabs(filter->high));
    for (int y = 0; y < base->height; y++)
        for (int x = 0; x < base->width; x++) {
            float value = base->narrow[(size_t)y * base->stride + (size_t)x];
            beyond += !((double)value >= filter->low - rounding && (double)value <= filter->high + rounding);
            uint32_t bits;
            memcpy(&bits, &value, sizeof bits);
            digest = (digest ^ bits) * 0x100000001b3u;
        }
    CHECK(beyond == 0, "%s, subsampled by %d: %zu bases are NaN or beyond the picture's numbers", name, subsample,
          beyond);
    return digest;
}

/* The same bytes however it is computed; only_digest: at this level. */
static uint64_t test_sameness(bool only_digest) {
    static const int sizes[][2] = {{1, 1}, {1, 200}, {300, 1}, {2, 2}, {64, 16}, {65, 33}, {150, 90}};
    static const int subsamples[] = {1, 2, 5, 25, 1000};
    uint64_t digest = 0;
    for (int s = 0; s < 7; s++)
        for (int k = 0; k < KINDS; k++)
            for (int n = 0; n < 5; n++) {
                double sigma_s = 0.1 * pow(1e3, random_unit()) * subsamples[n], sigma_r = k % 2 ? 0.4 : 0.1;
                hdr_plane *plane = scene_of((kind)k, sizes[s][0], sizes[s][1], 12, sigma_s, sigma_r);
                hdr_bilateral filter = filter_of(plane, sigma_s, sigma_r);
                char name[100];
                snprintf(name, sizeof name, "%s, %d x %d, sigma_s %g", kinds[k], sizes[s][0], sizes[s][1], sigma_s);
                hdr_bilateral_report report;
                hdr_plane *base = base_of(&filter, subsamples[n], plane, 1, &report);
                digest = digest * 31 + check_bases(&filter, subsamples[n], base, name);
                if (!only_digest) check_sameness(&filter, subsamples[n], plane, base, name);
                hdr_plane_free(base);
                hdr_plane_free(plane);
            }
    return digest;
}

/* What is constant stays what it is, and so does what stands by itself, sampled or not. */
static void test_by_itself(void) {
    static const int subsamples[] = {1, 2, 5, 25};
    for (int n = 0; n < 4; n++)
        for (int apart = 0; apart <= 40; apart += 20) {
            hdr_plane *plane = scene_of(CONSTANT, 90, 70, 0, 20, 0.4);
            float *firefly = &plane->narrow[(size_t)31 * plane->stride + 47], value = *firefly;
            *firefly = value + 0.4f * (float)apart;
            plane->narrow[(size_t)33 * plane->stride + 47] = value - 0.4f * (float)apart;
            hdr_bilateral filter = filter_of(plane, 20, 0.4);
            hdr_bilateral_report report;
            hdr_plane *base = base_of(&filter, subsamples[n], plane, 1, &report);
            size_t moved = 0;
            for (int y = 0; y < 70; y++)
                for (int x = 0; x < 90; x++)
                    moved += !(fabs(number_at(base, x, y) - number_at(plane, x, y)) <= (apart ? 1e-6 * apart : 0));
            CHECK(moved == 0, "fireflies %d sigma_r apart, subsampled by %d: %zu bases are moved", apart, subsamples[n],
                  moved);
            CHECK(apart == 0 || report.used < report.cells, "empty segments are computed");
            hdr_plane_free(base);
            hdr_plane_free(plane);
        }
}

static void test_subsample(void) {
    for (double sigma = 0.1; sigma < 1e6; sigma *= 1.01) {
        int subsample = hdr_piecewise_subsample(sigma);
        double samples = sigma / subsample;
        CHECK(subsample >= 1 && subsample <= 25 && (samples > 1.8 || subsample == 1) &&
                  (samples < 3.75 || subsample == 25),
              "sigma_s %g is subsampled by %d", sigma, subsample);
    }
}

/* ---- Levels ---- */

static uint64_t test_level(void) {
    random_state = 1;
    return test_sameness(true);
}

int main(int argc, char **argv) {
    random_state = 1;
    check_at_levels(test_level);
    test_sameness(false);
    test_pseudocode();
    test_bound(argc > 1 ? atoi(argv[1]) : 210);
    test_by_itself();
    test_subsample();
    printf("farthest from the exact base: %.3g sigma_r; nearest to the bound: %.3g of it\n", farthest_in_all,
           nearest_to_bound);
    return check_done("test_piecewise");
}

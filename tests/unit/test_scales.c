/* The Gaussians and the search among them, at every instruction set that this processor has: kernels against plain
 * loops, bit for bit; what is skipped against everything computed, bit for bit; float against double, within the bound
 * that is promised, and with the same scale everywhere. */
#include "check.h"
#include "kernels.h"
#include "levels.h"
#include "kernel/convolve.h"
#include "spatial/gaussian.h"
#include "spatial/scales.h"

#include <stdlib.h>

/* ---- Gaussians ---- */

static void test_weights(void) {
    for (int n = 0; n < 60; n++) {
        double sigma = 0.2 * pow(1.1, n), weight[1000];
        int reach = hdr_gaussian_reach(sigma, 8, 1e-30);
        hdr_gaussian(sigma, reach, weight);
        double sum = weight[0];
        for (int k = 0; k <= reach; k++) {
            long double root = sqrtl(2) * (long double)sigma, z = (k + 0.5L) / (long double)sigma;
            long double expected =
                k == 0 ? erfl(0.5L / root) : (erfcl((k - 0.5L) / root) - erfcl((k + 0.5L) / root)) / 2;
            CHECK(fabsl((long double)weight[k] - expected) <= (8 + 4 * z * z) * 0x1p-53L * expected,
                  "sigma %g: weight %d is %.17g", sigma, k, weight[k]);
            sum += k ? 2 * weight[k] : 0;
        }
        CHECK(fabs(sum - 1) < 1e-15, "sigma %g: the weights add up to %.17g", sigma, sum);
        for (double rest = 1e-3; rest > 1e-40; rest /= 100) {
            int far = hdr_gaussian_reach(sigma, 0, rest);
            long double outside = erfcl((far + 0.5L) / (sqrtl(2) * (long double)sigma));
            CHECK(outside <= (long double)rest, "sigma %g: more than %g lies beyond %d", sigma, rest, far);
            long double nearer = far ? erfcl((far - 1.5L) / (sqrtl(2) * (long double)sigma)) : 1;
            CHECK(far == 0 || nearer > (long double)rest, "sigma %g: a reach of %d is more than %g asks for", sigma,
                  far, rest);
        }
    }
}

/* ---- Inner loops ---- */

enum { REACH = 40, ROWS = 2 * REACH + 1, WIDTH = 4 * HDR_PIECE };

static void test_convolutions(void) {
    static float numbers[ROWS][WIDTH + 2 * REACH], out[WIDTH + 2];
    const float *row[ROWS];
    float weight[REACH + 1];
    for (int y = 0; y < ROWS; y++) {
        row[y] = numbers[y] + REACH;
        for (int x = 0; x < WIDTH + 2 * REACH; x++)
            numbers[y][x] = (float)ldexp(1 + random_unit(), (int)(random_bits() % 40) - 20);
    }
    for (int k = 0; k <= REACH; k++)
        weight[k] = (float)random_unit();
    for (int reach = 0; reach <= REACH; reach += reach < 4 ? 1 : 9)
        for (size_t x = 0; x < WIDTH; x += HDR_PIECE) {
            out[0] = out[HDR_PIECE + 1] = 7;
            hdr_convolve_down(row + REACH, x, weight, reach, out + 1);
            size_t wrong = 0;
            for (size_t i = 0; i < HDR_PIECE; i++) {
                float sum = weight[0] * row[REACH][x + i];
                for (int k = 1; k <= reach; k++)
                    sum += weight[k] * (row[REACH + k][x + i] + row[REACH - k][x + i]);
                wrong += sum != out[i + 1];
            }
            CHECK(wrong == 0, "down, reach %d: %zu differ", reach, wrong);
            CHECK(out[0] == 7 && out[HDR_PIECE + 1] == 7, "down writes beside its output");
            size_t count = WIDTH - x;
            out[0] = out[count + 1] = 7;
            hdr_convolve_across(row[3] + x, weight, reach, out + 1, count);
            for (size_t i = 0; i < count; i++) {
                float sum = weight[0] * row[3][x + i];
                for (int k = 1; k <= reach; k++)
                    sum += weight[k] * (row[3][x + i + (size_t)k] + row[3][(int)(x + i) - k]);
                wrong += sum != out[i + 1];
            }
            CHECK(wrong == 0, "across, reach %d: %zu differ", reach, wrong);
            CHECK(out[0] == 7 && out[count + 1] == 7, "across writes beside its output");
        }
}

static void test_sums(void) {
    float in[200];
    double weight[200];
    for (size_t count = 0; count < 200; count++) {
        long double expected = 0, size = 0;
        for (size_t i = 0; i < count; i++) {
            in[i] = (float)random_signed(-10, 10);
            weight[i] = random_unit();
            expected += (long double)in[i] * (long double)weight[i];
            size += fabsl((long double)in[i] * (long double)weight[i]);
        }
        double sum = hdr_weighted_sum(in, weight, count);
        CHECK(fabsl((long double)sum - expected) <= 200 * 0x1p-53L * size, "a weighted sum of %zu is %a", count, sum);
    }
}

static void test_close_uneven(void) {
    for (int n = 0; n < 300; n++) {
        float v[HDR_PIECE], next[HDR_PIECE], out[HDR_PIECE];
        unsigned char marks[HDR_PIECE], before[HDR_PIECE];
        const hdr_uneven test = {0.05, n % 3 ? 0.3 : 0, n % 5 ? 1e-3 : 0, n % 7 ? 1e-5 : 0, (unsigned char)(n % 8)};
        for (int i = 0; i < HDR_PIECE; i++) {
            v[i] = i % 5 ? (float)random_unit() : 0;
            next[i] = v[i] + (float)(0.05 * (test.offset + (double)v[i]) * (0.99 + 0.02 * random_unit()));
            before[i] = marks[i] = i % 3 ? HDR_OPEN : 5;
            out[i] = -1;
        }
        hdr_open left = hdr_close_uneven(v, next, &test, marks, out);
        int open = 0, doubtful = 0;
        for (int i = 0; i < HDR_PIECE; i++) {
            double over = fabs((double)v[i] - (double)next[i]) - test.epsilon * (test.offset + (double)v[i]);
            double doubt = test.error * ((double)v[i] + (double)next[i] + test.epsilon * (double)v[i]) +
                           (2 + test.epsilon) * test.slack;
            unsigned char expected = before[i];
            if (before[i] == HDR_OPEN && over > doubt) expected = test.mark;
            if (before[i] == HDR_OPEN && over <= doubt && doubt > 0 && over >= -doubt) expected = HDR_DOUBTFUL;
            bool closed = before[i] == HDR_OPEN && over > doubt;
            CHECK(marks[i] == expected && out[i] == (closed ? v[i] : -1), "mark %d instead of %d", marks[i], expected);
            open += expected == HDR_OPEN || expected == HDR_DOUBTFUL;
            doubtful += expected == HDR_DOUBTFUL;
        }
        CHECK(left.open == open && left.doubtful == doubtful, "%d open, %d doubtful", left.open, left.doubtful);
    }
}

static void test_ranges(void) {
    for (int n = 0; n < 100; n++) {
        float numbers[HDR_PIECE], low = n % 2 ? 3 : INFINITY, high = 0, least = low, largest = high;
        for (int i = 0; i < HDR_PIECE; i++) {
            numbers[i] = (float)ldexp(random_unit(), n % 9);
            least = numbers[i] < least ? numbers[i] : least;
            largest = numbers[i] > largest ? numbers[i] : largest;
        }
        hdr_range_of_piece(numbers, &low, &high);
        CHECK(low == least && high == largest, "a range from %g to %g", (double)low, (double)high);
    }
}

/* ---- The search ---- */

typedef enum kind { NOISE, SMOOTH, CONSTANT, STEPS, FIREFLIES, MARGINS, BLACK, DIM, KINDS } kind;

static float number_of(kind kind, int x, int y, int width, int height) {
    switch (kind) {
    case NOISE:
        return (float)exp(3 * (random_unit() + random_unit() + random_unit() - 1.5));
    case SMOOTH:
        return (float)(0.2 + 0.5 * (x + 1) / width + 0.3 * (y + 1) / height);
    case CONSTANT:
        return 0.18f;
    case STEPS:
        return x / 40 % 2 == y / 23 % 2 ? 0.01f : 5;
    case FIREFLIES:
        return random_bits() % 900 ? (float)(0.1 * (1 + random_unit())) : 60000;
    case MARGINS:
        return y < height / 3 || x < width / 4 ? 0 : (float)(1 + random_unit());
    case DIM:
        return (float)(0x1p-95 * (1 + random_unit()));
    default:
        return 0;
    }
}

static hdr_scales scales_of(double unit) {
    hdr_scales scales = {.epsilon = 0.05, .unit = unit};
    double s = 1;
    for (int i = 0; i <= HDR_SCALES; i++, s *= 1.6) {
        scales.sigma[i] = s / 4;
        if (i < HDR_SCALES) scales.offset[i] = 256 * 0.18 * unit / (s * s);
    }
    return scales;
}

typedef struct found {
    hdr_plane *surround;
    unsigned char *choice;
    hdr_scales_report report;
} found;

static found search(const hdr_scales *scales, const hdr_plane *plane, int threads) {
    hdr_error error = {0};
    found out = {.surround = hdr_plane_new(plane->width, plane->height, plane->wide != NULL, &error)};
    out.choice = malloc((size_t)plane->width * (size_t)plane->height);
    hdr_pool *pool = hdr_pool_new(threads, &error);
    bool too_wide = true;
    if (!out.surround || !out.choice || !pool) abort();
    hdr_status status =
        hdr_scales_surround(scales, plane, out.surround, out.choice, pool, &out.report, &too_wide, &error);
    CHECK(status == HDR_OK && !too_wide, "%s", error.message);
    hdr_pool_free(pool);
    return out;
}

static void free_found(found *found) {
    hdr_plane_free(found->surround);
    free(found->choice);
}

static bool same_found(const found *a, const found *b) {
    int width = a->surround->width, height = a->surround->height;
    for (int y = 0; y < height; y++)
        if (memcmp(a->surround->narrow + (size_t)y * a->surround->stride,
                   b->surround->narrow + (size_t)y * b->surround->stride, (size_t)width * sizeof(float)))
            return false;
    return !memcmp(a->choice, b->choice, (size_t)width * (size_t)height);
}

static uint64_t pixels_chosen(const hdr_scales_report *report) {
    uint64_t sum = 0;
    for (int i = 0; i < HDR_SCALES; i++)
        sum += report->chosen[i];
    return sum;
}

static uint64_t digest; /* of all surrounds, to compare levels by */

static void check_against_double(const hdr_scales *scales, const hdr_plane *plane, const found *fast,
                                 const char *name) {
    hdr_error error = {0};
    hdr_plane *wide = hdr_plane_new(plane->width, plane->height, true, &error);
    if (!wide) abort();
    for (int y = 0; y < plane->height; y++)
        for (int x = 0; x < plane->width; x++)
            wide->wide[(size_t)y * wide->stride + (size_t)x] =
                (double)plane->narrow[(size_t)y * plane->stride + (size_t)x];
    found exact = search(scales, wide, 1);
    size_t wrong = 0, other = 0;
    for (int y = 0; y < plane->height; y++)
        for (int x = 0; x < plane->width; x++) {
            double v = (double)fast->surround->narrow[(size_t)y * fast->surround->stride + (size_t)x];
            double expected = exact.surround->wide[(size_t)y * exact.surround->stride + (size_t)x];
            unsigned char m = exact.choice[(size_t)y * (size_t)plane->width + (size_t)x];
            other += m != fast->choice[(size_t)y * (size_t)plane->width + (size_t)x];
            double bound = 0x1p-23 * (fast->report.reach[m] + 4) * expected + 1e-8 * scales->unit;
            wrong += !(fabs(v - expected) <= bound);
            uint64_t bits = 0;
            memcpy(&bits, &fast->surround->narrow[(size_t)y * fast->surround->stride + (size_t)x], sizeof(float));
            digest = (digest ^ bits) * 0x100000001b3u;
        }
    CHECK(other == 0, "%s: %zu pixels have another scale than in double", name, other);
    CHECK(wrong == 0, "%s: %zu surrounds are farther from those in double than is promised", name, wrong);
    free_found(&exact);
    hdr_plane_free(wide);
}

static void test_search(void) {
    static const int sizes[][2] = {{1, 1},   {2, 1},   {1, 300},   {700, 1}, {64, 32},
                                   {65, 33}, {63, 31}, {200, 150}, {5, 90}};
    static const char *const names[] = {"noise", "smooth", "constant", "steps", "fireflies", "margins", "black", "dim"};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (int k = 0; k < KINDS; k++) {
            hdr_error error = {0};
            hdr_plane *plane = hdr_plane_new(sizes[s][0], sizes[s][1], false, &error);
            if (!plane) abort();
            for (int y = 0; y < plane->height; y++)
                for (int x = 0; x < plane->width; x++)
                    plane->narrow[(size_t)y * plane->stride + (size_t)x] =
                        number_of((kind)k, x, y, plane->width, plane->height);
            hdr_scales scales = scales_of(k == DIM ? 0x1p-95 : k % 2 ? 1 : 0.3), all = scales;
            if ((s + (size_t)k) % 3 == 0) scales.epsilon = all.epsilon = 1e-3; /* many tests that float leaves open */
            all.no_skip = true;
            found fast = search(&scales, plane, 1), threads = search(&scales, plane, 3), whole = search(&all, plane, 2);
            char name[100];
            snprintf(name, sizeof name, "%s, %d x %d", names[k], plane->width, plane->height);
            uint64_t pixels = (uint64_t)plane->width * (uint64_t)plane->height;
            CHECK(same_found(&fast, &threads), "%s: threads make a difference", name);
            CHECK(same_found(&fast, &whole), "%s: what was left out makes a difference", name);
            CHECK(pixels_chosen(&fast.report) == pixels && pixels_chosen(&whole.report) == pixels, "%s: counts", name);
            for (int i = 0; i <= HDR_SCALES; i++) {
                bool idle = k == BLACK || (k == CONSTANT && i != HDR_SCALES - 1) || i == HDR_SCALES;
                CHECK(fast.report.blurred[i] <= (idle ? 0 : pixels), "%s: Gaussian %d is computed for %llu pixels",
                      name, i, (unsigned long long)fast.report.blurred[i]);
            }
            check_against_double(&scales, plane, &fast, name);
            free_found(&fast);
            free_found(&threads);
            free_found(&whole);
            hdr_plane_free(plane);
        }
}

/* ---- Levels ---- */

static uint64_t test_level(void) {
    random_state = 1;
    test_convolutions();
    test_sums();
    test_close_uneven();
    test_ranges();
    test_search();
    return digest;
}

int main(void) {
    check_at_levels(test_level);
    test_weights();
    return check_done("test_scales");
}

/* What the bilateral filter is made of, at every instruction set that this processor has: the grid's kernels against
 * plain loops, bit for bit; numbers of given rank against a sorted list; and the grid itself, which threads and what is
 * left out must not change. How accurate it is, is for tests/laws and tests/oracle. */
#include "check.h"
#include "kernels.h"
#include "levels.h"
#include "kernel/grid.h"
#include "spatial/bilateral.h"
#include "spatial/ranks.h"

#include <stdlib.h>

static uint64_t digest; /* of what came out, to compare levels by */

static void digest_floats(const float *values, size_t count) {
    for (size_t i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        digest = (digest ^ bits) * 0x100000001b3u;
    }
}

/* ---- Splines ---- */

/* The cubic B-spline at a distance from its node. */
static long double spline(long double t) {
    t = fabsl(t);
    if (t >= 2) return 0;
    return t >= 1 ? (2 - t) * (2 - t) * (2 - t) / 6 : (4 - 6 * t * t + 3 * t * t * t) / 6;
}

static void test_splines(void) {
    static float numbers[LONGEST];
    static hdr_spline splines[LONGEST + 2];
    for (int n = 0; n < 3000; n++) {
        double place = n < 20 ? n : n < 40 ? nextafter(n, 0) : 1000 * random_unit();
        hdr_spline s = hdr_spline_at(place);
        float sum = (s.weight[0] + s.weight[1]) + (s.weight[2] + s.weight[3]);
        CHECK(s.first == (int)floor(place), "place %.17g: nodes from %d on", place, s.first);
        CHECK(fabs((double)sum - 1) < 2e-7, "place %.17g: weights add up to %.9g", place, (double)sum);
        for (int k = 0; k < 4; k++) { /* node n stands at n - 1 */
            long double expected = spline((long double)place - (s.first + k - 1));
            CHECK(fabsl((long double)s.weight[k] - expected) <= 0x1p-24L * expected + 0x1p-50L,
                  "place %.17g: weight %d is %.9g, should be %.9Lg", place, k, (double)s.weight[k], expected);
        }
    }
    for (int n = 0; n < LENGTHS; n++) {
        size_t count = length_number(n), wrong = 0;
        double low = -5 * random_unit(), step = 0.01 + random_unit();
        for (size_t i = 0; i < count; i++)
            numbers[i] = (float)(i % 7 ? low + 20 * random_unit() : low + step * (double)i) + 1e-6f;
        memset(splines, 0xa5, sizeof splines);
        hdr_splines_of(numbers, low, step, splines + 1, count);
        for (size_t i = 0; i < count; i++) {
            hdr_spline expected = hdr_spline_at(((double)numbers[i] - low) / step);
            wrong += !same_bits(&splines[i + 1], &expected, sizeof expected);
            digest_floats(splines[i + 1].weight, 4);
        }
        CHECK(wrong == 0, "%zu of %zu splines of numbers differ", wrong, count);
        CHECK(untouched((unsigned char *)splines, (unsigned char *)(splines + 1)) &&
                  untouched((unsigned char *)(splines + count + 1), (unsigned char *)(splines + count + 2)),
              "splines are written beside the output");
    }
}

/* ---- Sowing and reading ---- */

enum { COLUMNS = 40, LEVELS = 30, STRIDE = 2 * LEVELS, SLAB = COLUMNS * STRIDE };

typedef struct field {
    float numbers[LONGEST];
    hdr_spline across[LONGEST], deep[LONGEST];
    int stored[LEVELS]; /* where a level is; some are left out, never one of four that are needed together */
} field;

static void fill_field(field *f, size_t count) {
    int places[LEVELS] = {0}, place_count = 0, next = 0;
    for (int l = 0; l < LEVELS; l++) {
        bool left_out = l >= 8 && l < 11 + (int)(random_bits() % 6);
        f->stored[l] = left_out ? -1 : next++;
    }
    for (int l = 0; l + 3 < LEVELS; l++)
        if (f->stored[l] >= 0 && f->stored[l + 3] == f->stored[l] + 3) places[place_count++] = l;
    for (size_t i = 0; i < count; i++) {
        f->numbers[i] = (float)(20 * random_unit() - 10);
        f->across[i] = hdr_spline_at((double)(random_bits() % (COLUMNS - 3)) + random_unit());
        f->deep[i] = hdr_spline_at(places[random_bits() % (uint64_t)place_count] + random_unit());
    }
}

static void plain_sow(const field *f, float middle, size_t count, float *slab) {
    for (size_t i = 0; i < count; i++) {
        float number = f->numbers[i] - middle;
        for (int x = 0; x < 4; x++)
            for (int z = 0; z < 4; z++) {
                float *pair =
                    slab + (size_t)(f->across[i].first + x) * STRIDE + 2 * (size_t)(f->stored[f->deep[i].first] + z);
                pair[0] += f->across[i].weight[x] * f->deep[i].weight[z];
                pair[1] += f->across[i].weight[x] * (f->deep[i].weight[z] * number);
            }
    }
}

static float plain_read(const field *f, float middle, size_t i, const float *slab) {
    float sum[4][2];
    for (int z = 0; z < 4; z++)
        for (int n = 0; n < 2; n++) {
            const float *at =
                slab + (size_t)f->across[i].first * STRIDE + 2 * (size_t)(f->stored[f->deep[i].first] + z) + n;
            sum[z][n] = f->across[i].weight[0] * at[0];
            for (size_t x = 1; x < 4; x++)
                sum[z][n] += f->across[i].weight[x] * at[x * STRIDE];
        }
    const float *w = f->deep[i].weight;
    float weight = (w[0] * sum[0][0] + w[1] * sum[1][0]) + (w[2] * sum[2][0] + w[3] * sum[3][0]);
    float number = (w[0] * sum[0][1] + w[1] * sum[1][1]) + (w[2] * sum[2][1] + w[3] * sum[3][1]);
    return middle + number / weight;
}

static void test_fields(void) {
    static field f;
    static float slab[SLAB + 2], expected[SLAB + 2], out[LONGEST + 2];
    for (int n = 0; n < LENGTHS; n++) {
        size_t count = length_number(n), wrong = 0;
        float middle = (float)(6 * random_unit() - 3);
        fill_field(&f, count);
        for (int i = 0; i < SLAB + 2; i++)
            slab[i] = expected[i] = (float)random_unit();
        hdr_grid_sow(f.numbers, middle, f.across, f.deep, f.stored, count, slab + 1, STRIDE);
        plain_sow(&f, middle, count, expected + 1);
        CHECK(same_bits(slab, expected, sizeof slab), "%zu pixels are sown otherwise than by a plain loop", count);
        digest_floats(slab, SLAB + 2);
        out[0] = out[count + 1] = 7;
        hdr_grid_read(middle, f.across, f.deep, f.stored, count, slab + 1, STRIDE, out + 1);
        for (size_t i = 0; i < count; i++) {
            float value = plain_read(&f, middle, i, slab + 1);
            wrong += !same_bits(&value, &out[i + 1], sizeof value);
        }
        CHECK(wrong == 0, "%zu of %zu pixels are read otherwise than by a plain loop", wrong, count);
        CHECK(out[0] == 7 && out[count + 1] == 7, "pixels are read beside the output");
        digest_floats(out, count);
    }
}

/* A pixel that is alone is read as what it is, wherever it stands; and so is one among its like. */
static void test_homogeneous(void) {
    static field f;
    static float slab[SLAB];
    for (int n = 0; n < 500; n++) {
        size_t count = n % 2 ? 1 : 300;
        fill_field(&f, count);
        memset(slab, 0, sizeof slab);
        for (size_t i = 0; i < count; i++) {
            f.numbers[i] = f.numbers[0];
            f.deep[i] = f.deep[0];
        }
        float middle = (float)random_unit(), out[300];
        hdr_grid_sow(f.numbers, middle, f.across, f.deep, f.stored, count, slab, STRIDE);
        hdr_grid_read(middle, f.across, f.deep, f.stored, count, slab, STRIDE, out);
        float farthest = 0;
        for (size_t i = 0; i < count; i++)
            farthest = fmaxf(farthest, fabsf(out[i] - f.numbers[0]));
        CHECK(farthest < 2e-5f, "%zu pixels of %.9g are read as up to %.9g off", count, (double)f.numbers[0],
              (double)farthest);
    }
}

static void test_rows(void) {
    static float rows[4][LONGEST + 2], expected[4][LONGEST + 2], in[LONGEST], out[LONGEST + 2];
    for (int n = 0; n < LENGTHS; n++) {
        size_t count = length_number(n), wrong = 0;
        float weight[4], *into[4];
        const float *from[4];
        for (int k = 0; k < 4; k++) {
            weight[k] = (float)random_unit();
            into[k] = rows[k] + 1;
            from[k] = rows[k] + 1;
            for (size_t i = 0; i < LONGEST + 2; i++)
                expected[k][i] = rows[k][i] = (float)random_signed(-10, 10);
        }
        out[0] = out[count + 1] = 7;
        hdr_grid_gather(from, weight, out + 1, count);
        for (size_t i = 0; i < count; i++) {
            float sum =
                (weight[0] * from[0][i] + weight[1] * from[1][i]) + (weight[2] * from[2][i] + weight[3] * from[3][i]);
            wrong += !same_bits(&sum, &out[i + 1], sizeof sum);
            in[i] = (float)random_signed(-10, 10);
        }
        CHECK(wrong == 0 && out[0] == 7 && out[count + 1] == 7, "%zu of %zu numbers are gathered otherwise", wrong,
              count);
        digest_floats(out, count);
        hdr_grid_spread(in, weight, into, count);
        for (int k = 0; k < 4; k++)
            for (size_t i = 0; i < count; i++)
                expected[k][i + 1] += weight[k] * in[i];
        CHECK(same_bits(rows, expected, sizeof rows), "%zu numbers are spread otherwise than by a plain loop", count);
    }
}

/* ---- Ranks ---- */

static int compare_reals(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static hdr_plane *new_plane(int width, int height, bool wide) {
    hdr_error error = {0};
    hdr_plane *plane = hdr_plane_new(width, height, wide, &error);
    if (!plane) abort();
    return plane;
}

static double number_of(int kind) {
    switch (kind) {
    case 0: /* anything */
        return random_signed(-140, 120);
    case 1: /* a few, often */
        return (double)(random_bits() % 5) - 2;
    case 2: /* neighbours, that the last digits tell apart */
        return 1 + ldexp((double)(random_bits() % 3000), -23);
    case 3: /* neighbours as only doubles can be */
        return 1 + ldexp((double)(random_bits() % 3000), -52);
    default: /* the ends */
        return random_bits() % 2 ? (random_bits() % 2 ? -0.0 : 0.0) : (double)FLT_MAX * (random_bits() % 2 ? 1 : -1);
    }
}

static void check_ranks(int width, int height, bool wide, int kind, hdr_pool *pool) {
    hdr_error error = {0};
    hdr_plane *plane = new_plane(width, height, wide);
    size_t pixels = (size_t)width * (size_t)height, count = 0;
    double *sorted = calloc(pixels, sizeof *sorted), low = INFINITY, high = -INFINITY, values[4], ends[2];
    unsigned char *mask = calloc((size_t)height, hdr_mask_row(width));
    if (!sorted || !mask) abort();
    for (size_t i = 0; i < plane->stride * (size_t)height; i++) { /* what is behind the width does not count */
        if (wide)
            plane->wide[i] = -1e300;
        else
            plane->narrow[i] = -FLT_MAX;
    }
    for (size_t i = 0; i < pixels; i++) {
        size_t x = i % (size_t)width, y = i / (size_t)width, at = y * plane->stride + x;
        double number = wide ? number_of(kind) : (double)(float)number_of(kind);
        if (wide)
            plane->wide[at] = number;
        else
            plane->narrow[at] = (float)number;
        low = fmin(low, number);
        high = fmax(high, number);
        if (i > 0 && random_bits() % 3 == 0) continue;
        mask[y * hdr_mask_row(width) + x / 8] |= (unsigned char)(1 << x % 8);
        sorted[count++] = number;
    }
    qsort(sorted, count, sizeof *sorted, compare_reals);
    uint64_t rank[4] = {1, count, 1 + random_bits() % count, 1 + random_bits() % count};
    for (int some = 1; some <= 4; some++) {
        hdr_status status = hdr_plane_ranks(plane, mask, some, rank, values, pool, &error);
        for (int i = 0; i < some; i++)
            CHECK(status == HDR_OK && values[i] == sorted[rank[i] - 1],
                  "%d x %d, %s, kind %d: rank %llu of %zu is %.17g, should be %.17g", width, height,
                  wide ? "wide" : "narrow", kind, (unsigned long long)rank[i], count, values[i], sorted[rank[i] - 1]);
    }
    hdr_status status = hdr_plane_range(plane, &ends[0], &ends[1], pool, &error);
    CHECK(status == HDR_OK && ends[0] == low && ends[1] == high, "%d x %d, kind %d: from %.17g to %.17g", width, height,
          kind, ends[0], ends[1]);
    free(sorted);
    free(mask);
    hdr_plane_free(plane);
}

static void test_ranks(void) {
    static const int sizes[][2] = {{1, 1}, {2, 1}, {9, 1}, {1, 200}, {65, 70}, {300, 130}};
    hdr_error error = {0};
    for (int threads = 1; threads <= 3; threads += 2) {
        hdr_pool *pool = hdr_pool_new(threads, &error);
        for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
            for (int kind = 0; kind < 5; kind++) {
                check_ranks(sizes[s][0], sizes[s][1], false, kind, pool);
                check_ranks(sizes[s][0], sizes[s][1], true, kind, pool);
            }
        hdr_pool_free(pool);
    }
}

/* ---- The grid ---- */

/* With a margin above and another below, all of one number. */
static bool is_margin(int height, int y) {
    return y < height / 4 || y > height - height / 5;
}

static hdr_plane *two_populations(int width, int height) {
    hdr_plane *plane = new_plane(width, height, false);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            plane->narrow[(size_t)y * plane->stride + (size_t)x] =
                is_margin(height, y) ? -3.5f : (float)((x > width / 3 ? -3 : 3) + 0.2 * random_unit());
    return plane;
}

static hdr_plane *grid_of(const hdr_plane *plane, const hdr_bilateral *filter, const double cells[2], int threads,
                          hdr_bilateral_report *report) {
    hdr_error error = {0};
    hdr_plane *base = new_plane(plane->width, plane->height, false);
    memcpy(base->narrow, plane->narrow, plane->stride * (size_t)plane->height * sizeof(float));
    hdr_pool *pool = hdr_pool_new(threads, &error);
    hdr_status status = hdr_bilateral_grid(filter, cells[0], cells[1], base, pool, report, &error);
    CHECK(status == HDR_OK, "%s", error.message);
    hdr_pool_free(pool);
    return base;
}

static bool same_plane(const hdr_plane *a, const hdr_plane *b) {
    for (int y = 0; y < a->height; y++)
        if (!same_bits(a->narrow + (size_t)y * a->stride, b->narrow + (size_t)y * b->stride,
                       (size_t)a->width * sizeof(float)))
            return false;
    return true;
}

static hdr_plane *exact_of(const hdr_plane *plane, const hdr_bilateral *filter) {
    hdr_error error = {0};
    hdr_plane *base = new_plane(plane->width, plane->height, false);
    hdr_pool *pool = hdr_pool_new(2, &error);
    hdr_status status = hdr_bilateral_exact(filter, 2, plane, base, pool, &error);
    CHECK(status == HDR_OK, "%s", error.message);
    hdr_pool_free(pool);
    return base;
}

/* Where not all bases are wanted, those that are must not change. */
static void check_wanted(const hdr_plane *plane, hdr_bilateral filter, const double cells[2]) {
    int width = plane->width, height = plane->height;
    unsigned char *wanted = calloc((size_t)height, hdr_mask_row(width));
    if (!wanted) abort();
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width && !is_margin(height, y); x++)
            wanted[(size_t)y * hdr_mask_row(width) + (size_t)x / 8] |=
                (unsigned char)((random_bits() % 3 > 0) << x % 8);
    hdr_bilateral_report report;
    hdr_plane *all[2] = {grid_of(plane, &filter, cells, 2, &report), exact_of(plane, &filter)};
    filter.wanted = wanted;
    hdr_plane *some[2] = {grid_of(plane, &filter, cells, 2, &report), exact_of(plane, &filter)};
    for (int way = 0; way < 2; way++) {
        int wrong = 0;
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width; x++) {
                size_t at = (size_t)y * plane->stride + (size_t)x;
                wrong += hdr_mask_has(wanted + (size_t)y * hdr_mask_row(width), x) &&
                         !same_bits(&all[way]->narrow[at], &some[way]->narrow[at], sizeof(float));
            }
        CHECK(wrong == 0, "%d x %d: %d bases change where others are not wanted", width, height, wrong);
        hdr_plane_free(all[way]);
        hdr_plane_free(some[way]);
    }
    free(wanted);
}

static void test_grid(void) {
    static const int sizes[][2] = {{1, 1}, {1, 100}, {300, 1}, {33, 65}, {200, 150}};
    static const double cells[][2] = {{2, 2}, {3, 4}, {4, 6}};
    hdr_error error = {0};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (size_t c = 0; c < sizeof cells / sizeof *cells; c++) {
            hdr_plane *plane = two_populations(sizes[s][0], sizes[s][1]);
            hdr_bilateral filter = {.sigma_s = 1 + 0.05 * sizes[s][0], .sigma_r = 0.3};
            hdr_pool *pool = hdr_pool_new(1, &error);
            hdr_plane_range(plane, &filter.low, &filter.high, pool, &error);
            hdr_pool_free(pool);
            hdr_bilateral all = filter;
            all.no_skip = true;
            hdr_bilateral_report report[4];
            hdr_plane *one = grid_of(plane, &filter, cells[c], 1, &report[0]),
                      *two = grid_of(plane, &filter, cells[c], 2, &report[1]),
                      *five = grid_of(plane, &filter, cells[c], 5, &report[2]),
                      *whole = grid_of(plane, &all, cells[c], 2, &report[3]);
            CHECK(same_plane(one, two) && same_plane(one, five), "%d x %d: threads make a difference", sizes[s][0],
                  sizes[s][1]);
            CHECK(same_plane(one, whole), "%d x %d: what was left out makes a difference", sizes[s][0], sizes[s][1]);
            CHECK(report[3].used == report[3].cells && report[0].cells == report[3].cells, "cells are miscounted");
            CHECK(sizes[s][0] < 3 || report[0].used * 2 < report[0].cells,
                  "%llu of %llu cells are used, most hold nothing", (unsigned long long)report[0].used,
                  (unsigned long long)report[0].cells);
            for (int y = 0; y < one->height; y++)
                digest_floats(one->narrow + (size_t)y * one->stride, (size_t)one->width);
            check_wanted(plane, filter, cells[c]);
            hdr_plane *planes[] = {plane, one, two, five, whole};
            for (int i = 0; i < 5; i++)
                hdr_plane_free(planes[i]);
        }
}

/* ---- Levels ---- */

static uint64_t test_level(void) {
    random_state = 1;
    test_splines();
    test_fields();
    test_homogeneous();
    test_rows();
    test_grid();
    return digest;
}

int main(void) {
    check_at_levels(test_level);
    random_state = 2;
    test_ranks();
    return check_done("test_bilateral");
}

/* The thresholds of dither: each rank once, Bayer's matrix by its recursion, and of blue noise its spectrum, the whole
 * tile's and that of the pixels below a rank. */
#include "check.h"
#include "kernel/dither.h"

#include <complex.h>
#include <limits.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = HDR_DITHER_SIDE, RANKS = HDR_DITHER_RANKS };

static const double pi = 3.14159265358979323846;
static const hdr_dither_kind kinds[] = {HDR_DITHER_ORDERED, HDR_DITHER_BLUE};

static const char *name_of(hdr_dither_kind kind) {
    return kind == HDR_DITHER_ORDERED ? "ordered" : "blue";
}

/* The ranks by rows, from the thresholds. */
static void read_tile(const hdr_dither *dither, int left, int top, int rank[RANKS]) {
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            double scaled = hdr_dither_threshold(dither, left + x, top + y) * RANKS - 0.5;
            rank[y * SIDE + x] = scaled == floor(scaled) && scaled >= 0 && scaled < RANKS ? (int)scaled : -1;
        }
}

static void test_ranks(void) {
    for (int k = 0; k < 2; k++) {
        static int rank[RANKS];
        bool met[RANKS] = {false};
        int count = 0;
        hdr_dither dither = hdr_dither_seeded(kinds[k], 0);
        read_tile(&dither, 0, 0, rank);
        for (int i = 0; i < RANKS; i++) {
            if (rank[i] < 0 || met[rank[i]]) continue;
            met[rank[i]] = true;
            count++;
        }
        CHECK(count == RANKS, "%s: %d of %d ranks are there", name_of(kinds[k]), count, RANKS);
    }
}

/* M(2n) = [4 M(n), 4 M(n) + 2; 4 M(n) + 3, 4 M(n) + 1]. */
static void test_ordered(void) {
    static int matrix[RANKS], rank[RANKS];
    for (int n = 1; n < SIDE; n *= 2)
        for (int i = n * n - 1; i >= 0; i--) {
            int x = i % n, y = i / n, here = 4 * matrix[y * SIDE + x];
            matrix[y * SIDE + x] = here;
            matrix[y * SIDE + x + n] = here + 2;
            matrix[(y + n) * SIDE + x] = here + 3;
            matrix[(y + n) * SIDE + x + n] = here + 1;
        }
    hdr_dither dither = hdr_dither_seeded(HDR_DITHER_ORDERED, 0);
    read_tile(&dither, 0, 0, rank);
    CHECK(!memcmp(matrix, rank, sizeof rank), "ordered: not Bayer's matrix");
}

/* The tile repeats everywhere, and rows are what single pixels are. */
static void test_places(void) {
    static const int places[] = {0, 1, 63, 64, 1000003, -1, -64, -1001, INT_MIN, INT_MAX - 1000};
    enum { PLACES = sizeof places / sizeof *places };
    static int first[RANKS], rank[RANKS];
    double row[600];
    for (int k = 0; k < 2; k++)
        for (uint32_t seed = 0; seed < 3; seed++) {
            hdr_dither dither = hdr_dither_seeded(kinds[k], seed);
            read_tile(&dither, 0, 0, first);
            for (int p = 0; p < PLACES; p++) {
                int x = places[p], y = places[(p + 3) % PLACES];
                read_tile(&dither, x, y, rank);
                size_t wrong = 0;
                for (int i = 0; i < RANKS; i++)
                    wrong += rank[i] != first[((unsigned)y + (unsigned)i / SIDE) % SIDE * SIDE +
                                              ((unsigned)x + (unsigned)i % SIDE) % SIDE];
                CHECK(wrong == 0, "%s, seed %u: does not repeat at %d,%d", name_of(kinds[k]), seed, x, y);
                for (size_t count = 0; count <= 512; count += count < 70 ? 1 : 221) {
                    row[count] = -1;
                    hdr_dither_thresholds(&dither, x, y, row, count);
                    bool same = row[count] == -1;
                    for (size_t i = 0; i < count; i++)
                        same &= row[i] == hdr_dither_threshold(&dither, x + (int)i, y);
                    CHECK(same, "%s: a row of %zu at %d,%d", name_of(kinds[k]), count, x, y);
                }
            }
        }
}

static void test_seeds(void) {
    bool met[RANKS] = {false};
    int places = 0;
    hdr_dither unmoved = hdr_dither_seeded(HDR_DITHER_BLUE, 0);
    CHECK(unmoved.x == 0 && unmoved.y == 0, "seed 0 moves the tile");
    for (uint32_t seed = 1; seed <= 1000; seed++) {
        hdr_dither moved = hdr_dither_seeded(HDR_DITHER_BLUE, seed), again = hdr_dither_seeded(HDR_DITHER_BLUE, seed);
        CHECK(moved.x < SIDE && moved.y < SIDE && moved.x == again.x && moved.y == again.y, "seed %u", seed);
        CHECK(hdr_dither_threshold(&moved, 5, 9) == hdr_dither_threshold(&unmoved, 5 + (int)moved.x, 9 + (int)moved.y),
              "seed %u is no move of the tile", seed);
        places += !met[moved.y * SIDE + moved.x];
        met[moved.y * SIDE + moved.x] = true;
    }
    /* 1000 out of 4096 at random are 887 different ones, give or take 10 */
    CHECK(places > 830, "1000 seeds give %d places", places);
}

/* ---- Spectrum ---- */

/* Power by frequency, white noise of the same variance being 1 on the average. */
static void take_spectrum(const double values[RANKS], double power[RANKS]) {
    static double complex by_rows[RANKS];
    double mean = 0, variance = 0;
    for (int i = 0; i < RANKS; i++)
        mean += values[i] / RANKS;
    for (int i = 0; i < RANKS; i++)
        variance += (values[i] - mean) * (values[i] - mean) / RANKS;
    for (int y = 0; y < SIDE; y++)
        for (int u = 0; u < SIDE; u++) {
            by_rows[y * SIDE + u] = 0;
            for (int x = 0; x < SIDE; x++)
                by_rows[y * SIDE + u] += (values[y * SIDE + x] - mean) * cexp(-2 * pi * I * (u * x % SIDE) / SIDE);
        }
    for (int v = 0; v < SIDE; v++)
        for (int u = 0; u < SIDE; u++) {
            double complex sum = 0;
            for (int y = 0; y < SIDE; y++)
                sum += by_rows[y * SIDE + u] * cexp(-2 * pi * I * (v * y % SIDE) / SIDE);
            power[v * SIDE + u] = creal(sum * conj(sum)) / RANKS / variance;
        }
}

/* The mean of the power at frequencies up to a radius, in periods a tile, and its largest anywhere. */
static double low_power(const double power[RANKS], double radius, double *peak) {
    double sum = 0;
    int count = 0;
    *peak = 0;
    for (int i = 1; i < RANKS; i++) {
        int u = i % SIDE < SIDE / 2 ? i % SIDE : SIDE - i % SIDE, v = i / SIDE < SIDE / 2 ? i / SIDE : SIDE - i / SIDE;
        if (power[i] > *peak) *peak = power[i];
        if (hypot(u, v) > radius) continue;
        sum += power[i];
        count++;
    }
    return sum / count;
}

static void read_levels(const int rank[RANKS], int below, double values[RANKS]) {
    for (int i = 0; i < RANKS; i++)
        values[i] = below == RANKS ? rank[i] : rank[i] < below;
}

/* k pixels of a tile, evenly spread, are sqrt(k) of them across: up to a third of that frequency there is to be little,
 * and nowhere a peak, as a regular pattern has. */
static void test_spectrum(void) {
    static int blue[RANKS], ordered[RANKS];
    static double values[RANKS], power[RANKS];
    static const int limits[] = {64, 256, 512, 1024, 2048, 3072, 3840, RANKS};
    hdr_dither dither = hdr_dither_seeded(HDR_DITHER_BLUE, 0);
    read_tile(&dither, 0, 0, blue);
    dither = hdr_dither_seeded(HDR_DITHER_ORDERED, 0);
    read_tile(&dither, 0, 0, ordered);
    srand(1);
    for (int i = 0; i < RANKS; i++)
        values[i] = rand() / (double)RAND_MAX;
    double peak;
    take_spectrum(values, power);
    double white = low_power(power, 16, &peak);
    CHECK(white > 0.8 && white < 1.2 && peak < 25, "white noise has %g of low frequencies, peak %g", white, peak);
    for (size_t l = 0; l < sizeof limits / sizeof *limits; l++) {
        int minority = limits[l] == RANKS ? RANKS / 2 : limits[l] > RANKS / 2 ? RANKS - limits[l] : limits[l];
        double radius = sqrt(minority) / 3;
        read_levels(blue, limits[l], values);
        take_spectrum(values, power);
        double low = low_power(power, radius, &peak);
        fprintf(stderr, "blue, ranks below %d: %.4f of white noise up to %.0f periods a tile, peak %.1f\n", limits[l],
                low, radius, peak);
        CHECK(low < 0.1, "blue, ranks below %d: %g of white noise's low frequencies", limits[l], low);
        CHECK(peak < 25, "blue, ranks below %d: a peak of %g", limits[l], peak);
        read_levels(ordered, limits[l], values);
        take_spectrum(values, power);
        low_power(power, radius, &peak);
        CHECK(peak > 50, "ordered, ranks below %d: a peak of %g only: the measure is no good", limits[l], peak);
    }
}

int main(void) {
    test_ranks();
    test_ordered();
    test_places();
    test_seeds();
    test_spectrum();
    return check_done("test_dither");
}

/* Palettes against what is published of them, and the legend's drawing. */
#include "check.h"
#include "picture/palette.h"

#include <locale.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static double linear(unsigned code) {
    double c = code / 255.0;
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

/* CIE L* of a colour in sRGB's codes. */
static double lightness(uint32_t colour) {
    double y = 0.2126 * linear(colour >> 16) + 0.7152 * linear(colour >> 8 & 0xff) + 0.0722 * linear(colour & 0xff);
    return y > 0.008856 ? 116 * cbrt(y) - 16 : 903.3 * y;
}

/* First, middle and last colour, as the authors of the first four have published them, and Moreland's for his. */
static void test_published(void) {
    static const struct {
        uint32_t first, at_64, at_128, at_191, last;
    } published[HDR_PALETTES] = {
        [HDR_PALETTE_VIRIDIS] = {0x440154, 0x3b528b, 0x21918c, 0x5ec962, 0xfde725},
        [HDR_PALETTE_MAGMA] = {0x000004, 0x51127c, 0xb73779, 0xfc8961, 0xfcfdbf},
        [HDR_PALETTE_INFERNO] = {0x000004, 0x57106e, 0xbc3754, 0xf98e09, 0xfcffa4},
        [HDR_PALETTE_PLASMA] = {0x0d0887, 0x7e03a8, 0xcc4778, 0xf89540, 0xf0f921},
        [HDR_PALETTE_COOLWARM] = {0x3b4cc0, 0x8db0fe, 0xdddddd, 0xf4987a, 0xb40426},
    };
    for (int map = 0; map < HDR_PALETTES; map++) {
        const uint32_t *colour = hdr_palette(map);
        const uint32_t found[5] = {colour[0], colour[64], colour[128], colour[191], colour[255]};
        uint32_t expected[5];
        memcpy(expected, &published[map], sizeof expected);
        for (int i = 0; i < 5; i++) {
            int apart = 0;
            for (int shift = 0; shift <= 16; shift += 8) {
                int off = abs((int)(found[i] >> shift & 0xff) - (int)(expected[i] >> shift & 0xff));
                apart = off > apart ? off : apart;
            }
            /* what is published of the inside is rounded from other places, a neighbour's colour away */
            CHECK(apart <= (i % 4 ? 4 : 0), "map %d, %d: #%06x, should be #%06x", map, i, found[i], expected[i]);
        }
    }
}

/* The first four grow lighter from end to end, the last one up to its middle, where it is flat, and no further. */
static void test_lightness(void) {
    for (int map = 0; map < HDR_PALETTES; map++) {
        const uint32_t *colour = hdr_palette(map);
        for (int i = 1; i < HDR_PALETTE_SIZE; i++) {
            double step = lightness(colour[i]) - lightness(colour[i - 1]);
            if (map == HDR_PALETTE_COOLWARM && i > 128) step = -step;
            CHECK(step > -0.3 && step < 1, "map %d: lightness grows by %g at %d", map, step, i);
        }
        for (int i = 8; i < HDR_PALETTE_SIZE; i++) {
            double step = lightness(colour[i]) - lightness(colour[i - 8]);
            bool away = map == HDR_PALETTE_COOLWARM && (i >= 124 && i <= 136);
            if (map == HDR_PALETTE_COOLWARM && i > 128) step = -step;
            CHECK(away || step > (map == HDR_PALETTE_COOLWARM ? 0.5 : 1), "map %d: lightness grows by %g up to %d", map,
                  step, i);
        }
    }
}

/* ---- The legend ---- */

enum { BEHIND = 0x000000, INK = 0xe0e0e0 };

static hdr_drawing draw(int map, double from, double to, bool logarithmic, int width, int height) {
    hdr_legend legend = {hdr_palette(map), from, to, logarithmic};
    hdr_drawing drawing;
    hdr_error error = {0};
    CHECK(hdr_legend_draw(&legend, width, height, &drawing, &error) == HDR_OK, "legend: %s", error.message);
    CHECK(drawing.width == width && drawing.height == hdr_legend_height(width, height), "legend of %d x %d: its size",
          width, height);
    return drawing;
}

static uint32_t pixel(const hdr_drawing *d, int x, int y) {
    return d->pixels[(size_t)y * (size_t)d->width + (size_t)x];
}

/* The row in the middle of the bar. */
static int bar_row(const hdr_drawing *d) {
    return d->height * 10 / 31;
}

/* A wide bar has all colours, from left to right, each as wide as the others to a pixel. */
static void test_bar(int width, int height) {
    hdr_drawing d = draw(HDR_PALETTE_VIRIDIS, 0, 1, false, width, height);
    const uint32_t *palette = hdr_palette(HDR_PALETTE_VIRIDIS);
    int left = 0, right = width - 1, y = bar_row(&d), at = 0, least = width, most = 0;
    while (pixel(&d, left, y) == BEHIND)
        left++;
    while (pixel(&d, right, y) == BEHIND)
        right--;
    CHECK(left == width - 1 - right && left <= width / 8, "%d: the bar is in the middle", width);
    for (int colour = 0; colour < HDR_PALETTE_SIZE; colour++) {
        int count = 0;
        for (; left + at <= right && pixel(&d, left + at, y) == palette[colour]; at++)
            count++;
        least = count < least ? count : least;
        most = count > most ? count : most;
    }
    /* two neighbours of viridis are the same */
    CHECK(left + at == right + 1, "%d: all colours in order, %d of %d pixels", width, at, right + 1 - left);
    CHECK(most - least <= 1 || least == 0, "%d: colours %d to %d pixels wide", width, least, most);
    hdr_drawing_free(&d);
}

/* Columns of a row that have ink. */
static bool has_ink(const hdr_drawing *d, int x, int first, int end) {
    for (int y = first; y < end; y++)
        if (pixel(d, x, y) == INK) return true;
    return false;
}

/* Ticks stand where round numbers are, and each has a number of its own below, with room around it. step: of the round
 * numbers, or 0 for powers of ten. */
static void test_numbers(double from, double to, double step, int least, int width, int height) {
    hdr_drawing d = draw(HDR_PALETTE_MAGMA, from, to, step == 0, width, height);
    int unit = d.height / 31, ticks = 0, numbers = 0, empty = 100 * unit, left = 0, right = width - 1;
    while (pixel(&d, left, bar_row(&d)) == BEHIND && pixel(&d, left, 16 * unit) == BEHIND)
        left++;
    while (pixel(&d, right, bar_row(&d)) == BEHIND)
        right--;
    for (int x = 0; x < width; x++) {
        bool ends = has_ink(&d, x, 17 * unit, 18 * unit) && (x == 0 || !has_ink(&d, x - 1, 17 * unit, 18 * unit));
        empty = has_ink(&d, x, 20 * unit, 27 * unit) ? 0 : empty + 1;
        if (empty == 0 && x + 1 < width) {
            int gap = 1;
            while (x + gap < width && !has_ink(&d, x + gap, 20 * unit, 27 * unit))
                gap++;
            numbers += gap > 5 * unit || x + gap == width;
        } else if (empty == 0) {
            numbers++;
        }
        if (!ends) continue;
        ticks++;
        double part = (x + unit / 2 - left) / (double)(right - left), slack = 1.0 / (right - left);
        double value = step == 0 ? log10(from) + part * log10(to / from) : from + part * (to - from);
        double wide = (step == 0 ? log10(to / from) : to - from) * slack, unit_step = step == 0 ? 1 : step;
        bool end = part < 2 * slack || part > 1 - 2 * slack;
        CHECK(end || fabs(value - unit_step * round(value / unit_step)) <= 2 * wide,
              "%g to %g, %d wide: a tick at %g is no round number", from, to, width, value);
    }
    CHECK(ticks == numbers, "%g to %g, %d wide: %d ticks and %d numbers", from, to, width, ticks, numbers);
    CHECK(ticks >= least, "%g to %g, %d wide: %d numbers", from, to, width, ticks);
    hdr_drawing_free(&d);
}

/* Ends that differ by little have numbers that differ: there is not as much ink below both. */
static void test_close_ends(double from, double to, bool logarithmic) {
    enum { WIDTH = 300 };
    hdr_drawing d = draw(HDR_PALETTE_VIRIDIS, from, to, logarithmic, WIDTH, 100);
    int ink[2] = {0};
    for (int y = 20; y < 27; y++)
        for (int x = 0; x < 80; x++) {
            ink[0] += pixel(&d, x, y) == INK;
            ink[1] += pixel(&d, WIDTH - 1 - x, y) == INK;
        }
    CHECK(ink[0] > 0 && ink[0] != ink[1], "%.17g to %.17g: the numbers of both ends look the same", from, to);
    hdr_drawing_free(&d);
}

/* Of any size, however small, and any range. */
static void test_sizes(void) {
    static const double ranges[][2] = {{0, 1}, {-1, 1}, {1e-30, 1e30}, {1e10, 1e10 + 1e-5}, {-1e38, 1e38}, {5, 6}};
    for (int width = 1; width < 300; width += width < 40 ? 1 : 13)
        for (int height = 1; height < 2000; height *= 7)
            for (size_t r = 0; r < sizeof ranges / sizeof *ranges; r++)
                for (int logarithmic = 0; logarithmic <= (ranges[r][0] > 0); logarithmic++) {
                    hdr_drawing d = draw(HDR_PALETTE_COOLWARM, ranges[r][0], ranges[r][1], logarithmic, width, height);
                    const uint32_t *palette = hdr_palette(HDR_PALETTE_COOLWARM);
                    CHECK(pixel(&d, width / 2, bar_row(&d)) != BEHIND, "%d wide: there is a bar", width);
                    int strange = 0;
                    for (int i = 0; i < d.width * d.height; i++) {
                        bool known = d.pixels[i] == BEHIND || d.pixels[i] == INK;
                        for (int c = 0; !known && c < HDR_PALETTE_SIZE; c++)
                            known = d.pixels[i] == palette[c];
                        strange += !known;
                    }
                    CHECK(strange == 0, "%d wide: %d pixels of no colour", width, strange);
                    hdr_drawing_free(&d);
                }
}

/* Where the host program's locale has a decimal comma, a number has its point all the same. */
static void test_locale(void) {
    static const char *const names[] = {"de_DE.UTF-8", "de_DE", "fr_FR.UTF-8", "nl_NL.UTF-8"};
    hdr_drawing with_point = draw(HDR_PALETTE_MAGMA, 0, 1, false, 640, 480);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (!setlocale(LC_ALL, names[i])) continue;
        hdr_drawing d = draw(HDR_PALETTE_MAGMA, 0, 1, false, 640, 480);
        CHECK(!memcmp(d.pixels, with_point.pixels, (size_t)d.width * (size_t)d.height * sizeof *d.pixels),
              "%s: another legend", names[i]);
        hdr_drawing_free(&d);
        setlocale(LC_ALL, "C");
    }
    hdr_drawing_free(&with_point);
}

int main(void) {
    test_published();
    test_locale();
    test_lightness();
    test_bar(1280, 720);
    test_bar(4096, 4096);
    test_bar(100, 100);
    test_numbers(0, 1, 0.1, 7, 1280, 720);
    test_numbers(-0.175, 0.175, 0.05, 5, 1280, 720);
    test_numbers(0, 6064, 1000, 3, 640, 480);
    test_numbers(1e-3, 1e3, 0, 7, 1280, 720);
    test_numbers(4.2e-4, 157, 0, 5, 644, 874);
    test_numbers(0, 1, 0.5, 2, 100, 100);
    test_numbers(-1e30, 1e30, 1e29, 3, 2000, 2000);
    test_close_ends(1000, 1000.03, false);
    test_close_ends(1000, 1000.03, true);
    test_close_ends(-1e30, -0.99999e30, false);
    test_sizes();
    return check_done("test_palette");
}

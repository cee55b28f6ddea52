/*
 * tiny: writes the tiny test pictures, whose every value is known exactly.
 *
 *     tiny DIRECTORY
 *
 * Each picture is one function pixel(x, y) with its formula above it; x and y count from the top left corner of the
 * data window, y downwards. Every value is given as the real number before it is stored: a half file stores the
 * nearest half (ties to even), a float file the value itself, which is a float.
 *
 * SPDX-License-Identifier: BSD-3-Clause
 */
#include "write_exr.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { MOST_PIXELS = 96, MOST_CHANNELS = 4 };

typedef struct {
    const char *name;
    const char *channels;
    exr_attr_box2i_t display_window, data_window;
    exr_pixel_type_t type;
    exr_compression_t compression;
    void (*pixel)(int x, int y, float *value);
    const exr_attr_chromaticities_t *chromaticities;
} TinyPicture;

static void set_rgb(float *value, float red, float green, float blue) {
    value[0] = red;
    value[1] = green;
    value[2] = blue;
}

/* ramp: R = G = B = (16 y + x) / 64, but the last pixel (15,3) is 1 instead of 63/64: from 0 to 1. */
static void ramp(int x, int y, float *value) {
    int step = 16 * y + x;
    float grey = step == 63 ? 1.0f : (float)step / 64.0f;
    set_rgb(value, grey, grey, grey);
}

/*
 * primaries, each row from left to right:
 * y = 0: red, green, blue, white at 1; y = 1: cyan, magenta, yellow, white at 0.5;
 * y = 2: red, green, blue, white at 0.18 (the half 0.1800537109375);
 * y = 3: (1, 0.5, 0.18), (0.18, 1, 0.5), (0.5, 0.18, 1), (0, 0, 0).
 */
static void primaries(int x, int y, float *value) {
    static const float table[4][4][3] = {
        {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}},
        {{0, 0.5f, 0.5f}, {0.5f, 0, 0.5f}, {0.5f, 0.5f, 0}, {0.5f, 0.5f, 0.5f}},
        {{0.18f, 0, 0}, {0, 0.18f, 0}, {0, 0, 0.18f}, {0.18f, 0.18f, 0.18f}},
        {{1, 0.5f, 0.18f}, {0.18f, 1, 0.5f}, {0.5f, 0.18f, 1}, {0, 0, 0}},
    };
    set_rgb(value, table[y][x][0], table[y][x][1], table[y][x][2]);
}

/*
 * wide: with n = 8 y + x and e = min(2 n - 60, 60): R = 2^e, G = 2^(e-1) (2^-60 for n = 0), B = 2^-e;
 * where n is a multiple of 5, B is negated; where n is a multiple of 7, R is negated.
 * So the first pixel is (-2^-60, 2^-60, -2^60).
 */
static void wide(int x, int y, float *value) {
    int n = 8 * y + x;
    int exponent = 2 * n - 60 < 60 ? 2 * n - 60 : 60;
    float red = ldexpf(1, exponent);
    float green = n == 0 ? ldexpf(1, -60) : ldexpf(1, exponent - 1);
    float blue = ldexpf(1, -exponent);
    set_rgb(value, n % 7 == 0 ? -red : red, green, n % 5 == 0 ? -blue : blue);
}

/*
 * specials: where x + y is even 0.25, where it is odd 0.5, in all three channels, but for these:
 *   (0,0) R = NaN           (1,0) G = NaN           (2,0) B = NaN           (3,0) R = G = B = NaN
 *   (0,1) R = +Inf          (1,1) G = +Inf          (2,1) B = +Inf          (3,1) R = G = B = +Inf
 *   (4,1) R = -Inf          (5,1) G = -Inf          (6,1) B = -Inf          (7,1) R = G = B = -Inf
 *   (0,2) R = -0            (1,2) R = G = B = -0    (2,2) R = 2^-24         (3,2) G = 1023 * 2^-24
 *   (4,2) B = -(2^-24)      (5,2) R = G = B = 2^-24 (6,2) R = 65504         (7,2) R = G = B = 65504
 *   (7,3) (NaN, +Inf, -Inf)
 */
static void specials(int x, int y, float *value) {
    static const struct {
        int x, y;
        const char *channels;
        float value;
    } exceptions[] = {
        {0, 0, "R", NAN},       {1, 0, "G", NAN},        {2, 0, "B", NAN},       {3, 0, "RGB", NAN},
        {0, 1, "R", INFINITY},  {1, 1, "G", INFINITY},   {2, 1, "B", INFINITY},  {3, 1, "RGB", INFINITY},
        {4, 1, "R", -INFINITY}, {5, 1, "G", -INFINITY},  {6, 1, "B", -INFINITY}, {7, 1, "RGB", -INFINITY},
        {0, 2, "R", -0.0f},     {1, 2, "RGB", -0.0f},    {2, 2, "R", 0x1p-24f},  {3, 2, "G", 0x3ffp-24f},
        {4, 2, "B", -0x1p-24f}, {5, 2, "RGB", 0x1p-24f}, {6, 2, "R", 65504},     {7, 2, "RGB", 65504},
        {7, 3, "R", NAN},       {7, 3, "G", INFINITY},   {7, 3, "B", -INFINITY},
    };

    float ordinary = (x + y) % 2 == 0 ? 0.25f : 0.5f;
    set_rgb(value, ordinary, ordinary, ordinary);
    for (size_t i = 0; i < sizeof exceptions / sizeof *exceptions; i++) {
        if (exceptions[i].x != x || exceptions[i].y != y) continue;
        for (const char *channel = exceptions[i].channels; *channel; channel++)
            value[*channel == 'R' ? 0 : *channel == 'G' ? 1 : 2] = exceptions[i].value;
    }
}

/*
 * alpha: alpha = (0, 0.25, 0.5, 1)[y]. The straight colour is (x/8, 0.5, 1 - x/8); the stored colour is that times
 * alpha (associated). In row 0, where alpha is 0: (0, 0, 0) for x < 4, and (x/4, 0.5, 0.25), pure emission, for x >= 4.
 */
static void alpha(int x, int y, float *value) {
    static const float alphas[] = {0, 0.25f, 0.5f, 1};
    float step = (float)x / 8.0f;
    set_rgb(value, step * alphas[y], 0.5f * alphas[y], (1 - step) * alphas[y]);
    if (y == 0 && x >= 4) set_rgb(value, 2 * step, 0.5f, 0.25f);
    value[3] = alphas[y];
}

/* opaque: (x/8, y/4, 0.5), alpha 1. */
static void opaque(int x, int y, float *value) {
    set_rgb(value, (float)x / 8.0f, (float)y / 4.0f, 0.5f);
    value[3] = 1;
}

/* grey: Y = 2^(x-4) * (y+1): from 2^-4 to 32. */
static void grey(int x, int y, float *value) {
    value[0] = ldexpf((float)(y + 1), x - 4);
}

/* window: R = (x+1)/16, G = (y+1)/16, B = 0.25. In display coordinates the pixel is (x - 2, y + 1). */
static void window(int x, int y, float *value) {
    set_rgb(value, (float)(x + 1) / 16.0f, (float)(y + 1) / 16.0f, 0.25f);
}

/* black: 0. */
static void black(int x, int y, float *value) {
    (void)x;
    (void)y;
    set_rgb(value, 0, 0, 0);
}

/* one: R = G = B = 0.18, as the nearest float. */
static void one(int x, int y, float *value) {
    (void)x;
    (void)y;
    set_rgb(value, 0.18f, 0.18f, 0.18f);
}

/* constant: R = G = B = 0.5. */
static void constant(int x, int y, float *value) {
    (void)x;
    (void)y;
    set_rgb(value, 0.5f, 0.5f, 0.5f);
}

/* foreign: in the primaries of BT.2020, so that some colours lie outside of Rec.709. Top row: (1, 1/64, 1/64), (1/64,
 * 1, 1/64), (1/64, 1/64, 1), (1, 1, 1), nothing 0; the rows below: a quarter and a sixteenth of the one above. */
static void foreign(int x, int y, float *value) {
    float scale = y == 0 ? 1.0f : y == 1 ? 0.25f : 0.0625f, low = scale / 64;
    set_rgb(value, x == 0 || x == 3 ? scale : low, x == 1 || x == 3 ? scale : low, x >= 2 ? scale : low);
}

static const exr_attr_chromaticities_t bt2020 = {.red_x = 0.708f,
                                                 .red_y = 0.292f,
                                                 .green_x = 0.170f,
                                                 .green_y = 0.797f,
                                                 .blue_x = 0.131f,
                                                 .blue_y = 0.046f,
                                                 .white_x = 0.3127f,
                                                 .white_y = 0.3290f};

static bool write_tiny(const char *directory, const TinyPicture *tiny) {
    float pixels[MOST_PIXELS * MOST_CHANNELS];
    float *next = pixels;
    int width = tiny->data_window.max.x - tiny->data_window.min.x + 1;
    int height = tiny->data_window.max.y - tiny->data_window.min.y + 1;
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            float value[MOST_CHANNELS];
            tiny->pixel(x, y, value);
            for (int c = 0; tiny->channels[c]; c++)
                *next++ = value[c];
        }
    }
    char path[1024];
    int length = snprintf(path, sizeof path, "%s/%s.exr", directory, tiny->name);
    if (length < 0 || (size_t)length >= sizeof path) {
        fprintf(stderr, "%s: name too long\n", directory);
        return false;
    }
    Picture picture = {tiny->channels, tiny->display_window, tiny->data_window, pixels, tiny->chromaticities};
    return write_exr(path, &picture, tiny->type, tiny->compression);
}

/* clang-format off */
#define WINDOW(left, top, right, bottom) {{.x = (left), .y = (top)}, {.x = (right), .y = (bottom)}}
#define SIZE(width, height) WINDOW(0, 0, (width) - 1, (height) - 1), WINDOW(0, 0, (width) - 1, (height) - 1)
/* clang-format on */

int main(int argc, char **argv) {
    static const TinyPicture pictures[] = {
        {"ramp", "RGB", SIZE(16, 4), EXR_PIXEL_FLOAT, EXR_COMPRESSION_ZIP, ramp, NULL},
        {"primaries", "RGB", SIZE(4, 4), EXR_PIXEL_HALF, EXR_COMPRESSION_ZIP, primaries, NULL},
        {"wide", "RGB", SIZE(8, 8), EXR_PIXEL_FLOAT, EXR_COMPRESSION_PIZ, wide, NULL},
        {"specials", "RGB", SIZE(8, 4), EXR_PIXEL_HALF, EXR_COMPRESSION_ZIP, specials, NULL},
        {"alpha", "RGBA", SIZE(8, 4), EXR_PIXEL_HALF, EXR_COMPRESSION_ZIP, alpha, NULL},
        {"opaque", "RGBA", SIZE(8, 4), EXR_PIXEL_HALF, EXR_COMPRESSION_PIZ, opaque, NULL},
        {"grey", "Y", SIZE(8, 4), EXR_PIXEL_HALF, EXR_COMPRESSION_ZIP, grey, NULL},
        {"window", "RGB", WINDOW(0, 0, 11, 7), WINDOW(-2, 1, 8, 9), EXR_PIXEL_HALF, EXR_COMPRESSION_ZIP, window, NULL},
        {"black", "RGB", SIZE(8, 8), EXR_PIXEL_HALF, EXR_COMPRESSION_ZIP, black, NULL},
        {"one", "RGB", SIZE(1, 1), EXR_PIXEL_FLOAT, EXR_COMPRESSION_ZIP, one, NULL},
        {"constant", "RGB", SIZE(8, 8), EXR_PIXEL_HALF, EXR_COMPRESSION_PIZ, constant, NULL},
        {"foreign", "RGB", SIZE(4, 3), EXR_PIXEL_FLOAT, EXR_COMPRESSION_ZIP, foreign, &bt2020},
    };
    if (argc != 2) {
        fprintf(stderr, "usage: tiny DIRECTORY\n");
        return 64;
    }
    for (size_t i = 0; i < sizeof pictures / sizeof *pictures; i++)
        if (!write_tiny(argv[1], &pictures[i])) return EXIT_FAILURE;
    return EXIT_SUCCESS;
}

/* For test_reinhard_local: pictures on which the choice of scales has something to do, and something to go wrong with.
 */
#ifndef HDR_TESTS_ORACLE_SHADES_H
#define HDR_TESTS_ORACLE_SHADES_H

#include "oracle_scenes.h"

typedef enum shade {
    SHADE_STEPS,     /* blocks of 11 pixels, a power of two each */
    SHADE_FIREFLIES, /* dim noise, and now and then a pixel of 1e5 */
    SHADE_FLAT,
    SHADE_RAMP,    /* ten decades from side to side, a straight line from top to bottom */
    SHADE_MARGINS, /* black around a quiet texture */
    SHADE_UNLIT,   /* pixels that are negative, black or hold negative components, in patches */
    SHADE_LONE,    /* one pixel is lit */
    SHADE_EDGE,    /* a slanting edge between 0.02 and 50, with a little noise */
    SHADE_NOISE,   /* twelve stops, NaN and infinities */
    SHADE_LINES,   /* lines of one pixel */
    SHADES
} shade;

static const char *const shade_names[SHADES] = {"steps", "fireflies", "flat", "ramp",  "margins",
                                                "unlit", "lone",      "edge", "noise", "lines"};

/* In [0,1), from a place. */
static double shade_random(int x, int y, unsigned salt) {
    uint64_t state = (uint64_t)(unsigned)x << 40 ^ (uint64_t)(unsigned)y << 16 ^ salt;
    random_bits(&state);
    return (double)(random_bits(&state) >> 11) * 0x1p-53;
}

/* Light at a place, before colour. */
static double shade_light(shade kind, int x, int y, int width, int height) {
    const double noise = shade_random(x, y, 1), across = (x + 0.5) / width, down = (y + 0.5) / height;
    switch (kind) {
    case SHADE_STEPS:
        return exp2(floor(16 * shade_random(x / 11, y / 11, 2)) - 8);
    case SHADE_FIREFLIES:
        return shade_random(x, y, 3) < 0.004 || (x == width / 3 && y == height / 2) ? 1e5 : 0.05 + 0.02 * noise;
    case SHADE_FLAT:
        return 0.3;
    case SHADE_RAMP:
        return pow(10, 10 * across - 5) * (0.5 + down);
    case SHADE_MARGINS:
        return across > 0.25 && across < 0.8 && down > 0.2 && down < 0.7 ? 1 + sin(x * 0.9) * 0.6 + noise * 0.1 : 0;
    case SHADE_UNLIT:
        return shade_random(x / 3, y / 3, 4) < 0.3 ? -noise : shade_random(x, y, 5) < 0.1 ? 0 : exp2(6 * noise);
    case SHADE_LONE:
        return x == width / 2 && y == height / 2 ? 7 : 0;
    case SHADE_EDGE:
        return (3 * x + 2 * y > (3 * width + 2 * height) / 2 ? 50 : 0.02) * (1 + 0.05 * noise);
    case SHADE_LINES:
        return x % 8 == 0 || y % 13 == 0 ? 200 : 0.1;
    default:
        return exp2(12 * noise - 6);
    }
}

static float shade_component(shade kind, int x, int y, int width, int height, int channel) {
    double light = shade_light(kind, x, y, width, height);
    double tint = 0.4 + shade_random(x / 7, y / 5, 10 + (unsigned)channel);
    if (kind == SHADE_FLAT) tint = 1 + 0.2 * channel;
    if (kind == SHADE_UNLIT && channel == 1 && shade_random(x, y, 6) < 0.1) return -0.05f;
    if (kind == SHADE_NOISE && shade_random(x, y, 7 + (unsigned)channel) < 0.002) {
        const float odd[3] = {NAN, INFINITY, -INFINITY};
        return odd[channel];
    }
    return (float)(light * tint);
}

/* As an EXR file of floats: R, G, B, or Y alone. */
static inline bool shade_make(shade kind, int width, int height, bool grey, file_bytes *file) {
    const oracle_scene scene = {.name = shade_names[kind],
                                .channels = grey ? "Y" : "BGR",
                                .type = EXR_PIXEL_FLOAT,
                                .width = width,
                                .height = height,
                                .display = {{.x = 0, .y = 0}, {.x = width - 1, .y = height - 1}}};
    recipe r = scene_recipe(&scene);
    for (int c = 0; c < r.channels; c++) {
        r.channel[c].pixels = oracle_alloc((size_t)width * (size_t)height, sizeof(float));
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width; x++)
                scene_store(r.channel[c].pixels, EXR_PIXEL_FLOAT, (size_t)y * (size_t)width + (size_t)x,
                            shade_component(kind, x, y, width, height, c));
    }
    bool done = scene_write(&r, &scene, file);
    free_recipe(&r);
    return done;
}

/* As a plane of luminance, 0 where nothing is lit. */
static inline double *shade_plane(shade kind, int width, int height) {
    double *plane = oracle_alloc((size_t)width * (size_t)height, sizeof *plane);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            plane[(size_t)y * (size_t)width + (size_t)x] = fmax(shade_light(kind, x, y, width, height), 0);
    return plane;
}

/* What a test does with a file. */
typedef void shade_check(const char *name, file_bytes *file, const char *tone);

static inline void shade_try(shade kind, int width, int height, bool grey, const char *tone, shade_check *check) {
    char name[80];
    file_bytes file;
    snprintf(name, sizeof name, "%s %dx%d%s", shade_names[kind], width, height, grey ? " grey" : "");
    bool made = shade_make(kind, width, height, grey, &file);
    CHECK(made, "%s: cannot be made", name);
    if (made) check(name, &file, tone);
    free(file.data);
}

/* Thin ones, and colour and grey in turn. */
static inline void shade_try_sizes(shade kind, const char *tone, shade_check *check) {
    static const int sizes[][2] = {{1, 1}, {37, 1}, {1, 37}, {3, 2}, {2, 90}, {40, 5}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        shade_try(kind, sizes[i][0], sizes[i][1], i % 2, tone, check);
}

/* Scenes of the oracle of no more pixels than that: other primaries, alpha, windows. Every second has the other tone.
 */
static inline void scenes_try(int most_pixels, const char *tone, const char *other_tone, shade_check *check) {
    for (size_t i = 0; i < sizeof oracle_scenes / sizeof oracle_scenes[0]; i++) {
        const oracle_scene *scene = &oracle_scenes[i];
        file_bytes file;
        if (scene->width * scene->height > most_pixels) continue;
        bool made = scene_make(scene, &file);
        CHECK(made, "%s: cannot be made", scene->name);
        if (made) check(scene->name, &file, i % 2 ? tone : other_tone);
        free(file.data);
    }
}

static inline void file_try(const char *path, const char *tone, shade_check *check) {
    file_bytes file;
    bool loaded = oracle_load(path, &file);
    CHECK(loaded, "%s: cannot be read", path);
    if (loaded) check(path, &file, tone);
    free(file.data);
}

#endif

/* For test_durand_bounds: planes of log10 I on which a fast bilateral filter has something to go wrong with, each made
 * from a few numbers, so that a search can turn these. */
#ifndef HDR_TESTS_DURAND_SCENES_H
#define HDR_TESTS_DURAND_SCENES_H

#include "spatial/bilateral.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

typedef enum scene_kind {
    SCENE_FIREFLIES, /* quiet noise, single pixels 3 to 8 decades above it */
    SCENE_HALFWAY,   /* two populations, and pixels halfway between them */
    SCENE_RAMP,
    SCENE_NOISE,   /* over the whole range; most of it low, or evenly */
    SCENE_MARGINS, /* black around a texture */
    SCENE_LINES,   /* of one pixel */
    SCENE_STEPS,   /* blocks */
    SCENE_CHECKER,
    SCENE_CROWD,  /* lone pixels see a crowd that is far away in range, but many */
    SCENE_ISLAND, /* the same, the crowd being far away in space as well */
    SCENE_TUG,    /* a pixel between two crowds, each far away in range, in space, or in both */
    SCENE_FLAT,   /* one number everywhere, but for a pixel that makes the range */
    SCENES
} scene_kind;

static const char *const scene_names[SCENES] = {"fireflies", "halfway", "ramp",  "noise",  "margins", "lines",
                                                "steps",     "checker", "crowd", "island", "tug",     "flat"};

enum { SCENE_TURNS = 4, SCENE_MARKS = 64 };

typedef struct scene {
    scene_kind kind;
    int width, height;
    double sigma_s, sigma_r, range; /* range: in decades, where the kind has no range of its own */
    double turn[SCENE_TURNS];       /* in [0,1]: what the kind makes of them */
    uint64_t seed;
} scene;

/* Pixels that the kind thinks are hard. */
typedef struct scene_marks {
    int count;
    hdr_pixel pixel[SCENE_MARKS];
} scene_marks;

/* ---- Random numbers ---- */

static uint64_t scene_bits(uint64_t *state) {
    uint64_t z = *state += 0x9e3779b97f4a7c15u; /* SplitMix64 */
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static double scene_unit(uint64_t *state) {
    return (double)(scene_bits(state) >> 11) * 0x1p-53;
}

static double scene_log(uint64_t *state, double low, double high) {
    return low * pow(high / low, scene_unit(state));
}

/* To five digits, as it would be printed: what is printed is the scene, then. */
static inline double scene_round(double value) {
    char text[32];
    snprintf(text, sizeof text, "%.5g", value);
    return strtod(text, NULL);
}

/* In [0,1), from a place. */
static double scene_at(const scene *s, int x, int y, uint64_t salt) {
    uint64_t state = s->seed * 1000003 ^ (uint64_t)(unsigned)x << 40 ^ (uint64_t)(unsigned)y << 16 ^ salt;
    scene_bits(&state);
    return scene_unit(&state);
}

/* ---- Numbers of pixels ---- */

static void scene_mark(scene_marks *marks, int x, int y) {
    if (marks->count < SCENE_MARKS) marks->pixel[marks->count++] = (hdr_pixel){x, y};
}

static double scene_texture(const scene *s, int x, int y, double t) {
    return s->range * (t * scene_at(s, x, y, 1) + (1 - t) * (0.5 + 0.5 * sin(x * 0.2 + 0.1 * y * y / s->height)));
}

/* Lone pixels sit on a wide lattice, so that there are a few in pictures of all sizes. */
static bool scene_is_lone(const scene *s, int x, int y) {
    int column = s->width > 6 ? s->width / 3 : s->width, row = s->height > 6 ? s->height / 3 : s->height;
    int at_x = (int)(scene_at(s, x / column, y / row, 2) * column);
    int at_y = (int)(scene_at(s, x / column, y / row, 3) * row);
    return x % column == at_x && y % row == at_y;
}

static double scene_crowd(const scene *s, int x, int y, scene_marks *marks) {
    double noise = (scene_at(s, x, y, 1) - 0.5) * s->sigma_r * (s->turn[2] > 0.5 ? s->turn[2] - 0.5 : 0);
    if (!scene_is_lone(s, x, y)) return noise;
    scene_mark(marks, x, y);
    double far = 3 + 5 * s->turn[0] + 0.5 * (scene_at(s, x, y, 4) - 0.5) * s->turn[3];
    return far * s->sigma_r * (s->turn[1] > 0.5 ? -1 : 1);
}

static double scene_island(const scene *s, int x, int y, scene_marks *marks) {
    double at_x = floor(s->width * (0.3 + 0.4 * scene_at(s, 0, 0, 2)));
    double at_y = floor(s->height * (0.3 + 0.4 * scene_at(s, 0, 0, 3)));
    if (x == at_x && y == at_y) {
        scene_mark(marks, x, y);
        return 6 * s->sigma_r * s->turn[0];
    }
    double distance = s->turn[2] > 0.5 ? hypot(x - at_x, y - at_y) : fabs(x - at_x) + (y == at_y ? 0 : 1e-9);
    return distance < 5 * s->turn[1] * s->sigma_s ? -14 * s->sigma_r : 0;
}

static double scene_halfway(const scene *s, int x, int y, scene_marks *marks) {
    double apart = fmin(2 + 10 * s->turn[0], 12 / s->sigma_r) * s->sigma_r;
    double noise = (scene_at(s, x, y, 1) - 0.5) * s->sigma_r * 0.3 * s->turn[3];
    if (scene_is_lone(s, x, y)) {
        scene_mark(marks, x, y);
        return apart / 2 + (scene_at(s, x, y, 4) - 0.5) * 0.2 * s->turn[2] * s->sigma_r;
    }
    return (x + 0.5 < s->width * (0.2 + 0.6 * s->turn[1]) ? 0 : apart) + noise;
}

static double scene_tug(const scene *s, int x, int y, scene_marks *marks) {
    double at_x = floor(s->width * (0.3 + 0.4 * scene_at(s, 0, 0, 2))), sr = s->sigma_r;
    if (x == at_x && y % (s->height / 4 + 1) == (s->height / 9)) {
        scene_mark(marks, x, y);
        return (scene_at(s, x, y, 4) - 0.5) * 0.3 * sr;
    }
    if (x <= at_x - 5 * s->turn[1] * s->sigma_s) return 6.5 * sr * s->turn[0];
    if (x > at_x + 5 * s->turn[3] * s->sigma_s) return -6.5 * sr * s->turn[2];
    return -18 * sr;
}

static double scene_fireflies(const scene *s, int x, int y, scene_marks *marks) {
    double noise = scene_at(s, x, y, 1) * s->sigma_r * 4 * s->turn[0];
    if (scene_at(s, x, y, 5) > pow(10, -1 - 3 * s->turn[1]) && !scene_is_lone(s, x, y)) return noise;
    scene_mark(marks, x, y);
    return noise + 3 + 5 * s->turn[2] * scene_at(s, x, y, 6);
}

static double scene_ramp(const scene *s, int x, int y) {
    double angle = s->turn[0] * 1.5707963;
    double t = (cos(angle) * (x + 0.5) / s->width + sin(angle) * (y + 0.5) / s->height) / (cos(angle) + sin(angle));
    return s->range * pow(t, 1 + 3 * s->turn[1]);
}

static double scene_margins(const scene *s, int x, int y) {
    double margin = 0.45 * s->turn[0];
    bool inside = x >= s->width * margin && x < s->width * (1 - margin) && y >= s->height * margin;
    return inside ? scene_texture(s, x, y, s->turn[1]) : 0;
}

static double scene_lines(const scene *s, int x, int y) {
    int period = 2 + (int)(50 * s->turn[0] * s->turn[0]);
    bool on = x % period == 0 || (s->turn[2] > 0.5 && y % (period + 3) == 0);
    return (on ? s->range * (0.1 + 0.9 * s->turn[1]) : 0) + 0.1 * s->sigma_r * scene_at(s, x, y, 1);
}

static double scene_steps(const scene *s, int x, int y) {
    int side = 1 + (int)(4 * s->sigma_s * s->turn[0]);
    return s->range * pow(scene_at(s, x / side, y / side, 1), 1 + 2 * s->turn[1]);
}

static double scene_checker(const scene *s, int x, int y) {
    int side = 1 + (int)(2 * s->sigma_s * s->turn[0] * s->turn[0]);
    double apart = s->sigma_r * (0.5 + 8 * s->turn[1]), slope = s->turn[2] * s->sigma_r;
    return ((x / side + y / side) % 2 ? apart : 0) + slope * (x + 0.5) / s->width;
}

static double scene_flat(const scene *s, int x, int y, scene_marks *marks) {
    bool other = x == (int)(s->turn[1] * (s->width - 1)) && y == (int)(s->turn[2] * (s->height - 1));
    if (other || scene_is_lone(s, x, y)) scene_mark(marks, x, y);
    return other ? (s->turn[0] > 0.5 ? s->range : -s->range) : 0;
}

static double scene_number(const scene *s, int x, int y, scene_marks *marks) {
    switch (s->kind) {
    case SCENE_FIREFLIES:
        return scene_fireflies(s, x, y, marks);
    case SCENE_HALFWAY:
        return scene_halfway(s, x, y, marks);
    case SCENE_RAMP:
        return scene_ramp(s, x, y);
    case SCENE_NOISE:
        return s->range * pow(scene_at(s, x, y, 1), 1 + 8 * s->turn[0] * s->turn[0]);
    case SCENE_MARGINS:
        return scene_margins(s, x, y);
    case SCENE_LINES:
        return scene_lines(s, x, y);
    case SCENE_STEPS:
        return scene_steps(s, x, y);
    case SCENE_CHECKER:
        return scene_checker(s, x, y);
    case SCENE_CROWD:
        return scene_crowd(s, x, y, marks);
    case SCENE_ISLAND:
        return scene_island(s, x, y, marks);
    case SCENE_TUG:
        return scene_tug(s, x, y, marks);
    default:
        return scene_flat(s, x, y, marks);
    }
}

/* ---- Planes ---- */

/* Of every other seed the first pixel stands below all others, so that these are at any place between the levels of a
 * grid, which begin at the least number. */
static inline hdr_plane *scene_plane(const scene *s, scene_marks *marks) {
    hdr_error error = {0};
    hdr_plane *plane = hdr_plane_new(s->width, s->height, false, &error);
    if (!plane) abort();
    uint64_t state = s->seed;
    double offset = 8 * scene_unit(&state) - 4, least = INFINITY, below = s->sigma_r * (20 + scene_unit(&state));
    *marks = (scene_marks){0};
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++) {
            double number = offset + scene_number(s, x, y, marks);
            plane->narrow[(size_t)y * plane->stride + (size_t)x] = (float)number;
            least = number < least ? number : least;
        }
    if (s->seed % 2 && (size_t)s->width * (size_t)s->height > 1) plane->narrow[0] = (float)(least - below);
    return plane;
}

/* Any scene of up to that many pixels, and 2000 x 1000. */
static inline scene scene_random(scene_kind kind, uint64_t seed, double pixels) {
    uint64_t state = seed * 7919 + 17;
    scene s = {.kind = kind, .seed = seed};
    bool any_shape = scene_unit(&state) < 0.3;
    do {
        double area = scene_log(&state, 1, pixels),
               shape = any_shape ? scene_log(&state, 1e-3, 2e3) : 1 + scene_unit(&state);
        s.width = (int)ceil(sqrt(area * shape));
        s.height = (int)ceil(sqrt(area / shape));
    } while (s.width > 2000 || s.height > 1000);
    int larger = s.width > s.height ? s.width : s.height;
    s.sigma_s = scene_round(scene_log(&state, 0.5, fmax(0.5, 0.5 * larger)));
    bool narrow = scene_unit(&state) < 0.25; /* the whole range may be less than sigma_r */
    s.sigma_r = scene_round(scene_log(&state, 0.1, narrow ? 12 : 1));
    s.range = scene_round(scene_log(&state, narrow ? 0.5 : 1, 12));
    for (int i = 0; i < SCENE_TURNS; i++)
        s.turn[i] = scene_round(scene_unit(&state));
    return s;
}

#endif

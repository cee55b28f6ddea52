/*
 * scenes: the three scenes of the test pictures.
 *
 * SPDX-License-Identifier: BSD-3-Clause
 */
#include "scene.h"

#include <stdlib.h>
#include <string.h>

static Material diffuse(double red, double green, double blue) {
    return (Material){.kind = DIFFUSE, .colour = vec(red, green, blue)};
}

static Material tiles(double red, double green, double blue, double width, double depth) {
    return (Material){.kind = DIFFUSE, .colour = vec(red, green, blue), .tile = vec(width, 0, depth)};
}

static Material conductor(double red, double green, double blue, double roughness) {
    return (Material){.kind = CONDUCTOR, .colour = vec(red, green, blue), .parameter = roughness};
}

static Material mirror(double reflectance) {
    return (Material){.kind = MIRROR, .colour = vec(reflectance, reflectance, reflectance)};
}

static Material glass(void) {
    return (Material){.kind = GLASS, .parameter = 1.5};
}

static Material emitter(double red, double green, double blue, double factor) {
    return (Material){.kind = EMITTER, .colour = scale(vec(red, green, blue), factor)};
}

/* A scene too large for its arrays is a mistake in this file. */
static void place(Scene *scene, Primitive primitive) {
    bool is_light = primitive.material.kind == EMITTER || primitive.material.kind == PORTAL;
    if (scene->primitive_count == MOST_PRIMITIVES || (is_light && scene->light_count == MOST_LIGHTS)) abort();
    if (is_light) scene->lights[scene->light_count++] = scene->primitive_count;
    scene->primitives[scene->primitive_count++] = primitive;
}

static void sphere(Scene *scene, Vec centre, double radius, Material material) {
    place(scene, (Primitive){SPHERE, centre, vec(radius, 0, 0), vec(0, 0, 0), material});
}

static void box(Scene *scene, Vec low, Vec high, Material material) {
    place(scene, (Primitive){BOX, low, high, vec(0, 0, 0), material});
}

static void quad(Scene *scene, Vec corner, Vec edge1, Vec edge2, Material material) {
    place(scene, (Primitive){QUAD, corner, edge1, edge2, material});
}

/* ---- interior: a sunlit room in the evening, its lamp lit, and a dark passage behind the door ---- */

static void build_walls(Scene *scene) {
    Material plaster = diffuse(0.78, 0.74, 0.68), gloom = diffuse(0.35, 0.32, 0.30);
    box(scene, vec(-3.3, -0.2, -3.3), vec(3.3, 0, 3.5), tiles(0.55, 0.34, 0.19, 0.16, 1.4));
    box(scene, vec(-3.3, 2.8, -3.3), vec(3.3, 3, 3.5), diffuse(0.82, 0.81, 0.78));
    box(scene, vec(3, 0, -3.3), vec(3.3, 2.8, 3.5), plaster);
    box(scene, vec(-3.3, 0, 3.2), vec(3.3, 2.8, 3.5), plaster);
    /* the wall with the window */
    box(scene, vec(-3.3, 0, -3.3), vec(-3, 0.9, 3.5), plaster);
    box(scene, vec(-3.3, 2.3, -3.3), vec(-3, 2.8, 3.5), plaster);
    box(scene, vec(-3.3, 0.9, -3.3), vec(-3, 2.3, -2.1), plaster);
    box(scene, vec(-3.3, 0.9, 0.1), vec(-3, 2.3, 3.5), plaster);
    /* the wall with the door */
    Material blue = diffuse(0.22, 0.34, 0.42);
    box(scene, vec(-3, 0, -3.3), vec(1.5, 2.8, -3), blue);
    box(scene, vec(2.4, 0, -3.3), vec(3, 2.8, -3), blue);
    box(scene, vec(1.5, 2.1, -3.3), vec(2.4, 2.8, -3), blue);
    /* the passage */
    box(scene, vec(0.9, -0.2, -6.5), vec(3.3, 0, -3.3), gloom);
    box(scene, vec(0.9, 2.4, -6.5), vec(3.3, 3, -3.3), gloom);
    box(scene, vec(0.9, 0, -6.5), vec(1.2, 2.4, -3.3), gloom);
    box(scene, vec(2.7, 0, -6.5), vec(3.3, 2.4, -3.3), gloom);
    box(scene, vec(0.9, 0, -6.8), vec(3.3, 2.4, -6.5), gloom);
}

static void build_window(Scene *scene) {
    Material paint = diffuse(0.8, 0.8, 0.78);
    box(scene, vec(-3.18, 0.9, -1.03), vec(-3.12, 2.3, -0.97), paint);
    box(scene, vec(-3.18, 1.82, -2.1), vec(-3.12, 1.87, 0.1), paint);
    box(scene, vec(-3.05, 0.86, -2.2), vec(-2.86, 0.9, 0.2), paint);
    quad(scene, vec(-3.2, 0.9, -2.1), vec(0, 1.4, 0), vec(0, 0, 2.2), (Material){.kind = PORTAL});
    scene->zenith = vec(3, 6, 13);
    scene->horizon = vec(14, 11, 8);
    scene->ground = vec(1.6, 1.8, 1.2);
    /* the sun is wider than the real one, so that half floats can hold its radiance */
    Vec to_sun = normalise(vec(-1, 0.62, 0.12));
    sphere(scene, scale(to_sun, 1000), 25, emitter(1, 0.78, 0.52, 40000));
}

static void build_lamp(Scene *scene, double x, double z) {
    Material enamel = diffuse(0.06, 0.1, 0.08);
    double wide = 0.2, thin = 0.01, low = 1.82, high = 2.08;
    box(scene, vec(x - 0.008, 2.0, z - 0.008), vec(x + 0.008, 2.8, z + 0.008), diffuse(0.05, 0.05, 0.05));
    box(scene, vec(x - wide, low, z - wide), vec(x - wide + thin, high, z + wide), enamel);
    box(scene, vec(x + wide - thin, low, z - wide), vec(x + wide, high, z + wide), enamel);
    box(scene, vec(x - wide, low, z - wide), vec(x + wide, high, z - wide + thin), enamel);
    box(scene, vec(x - wide, low, z + wide - thin), vec(x + wide, high, z + wide), enamel);
    sphere(scene, vec(x, low, z), 0.04, emitter(1, 0.72, 0.42, 8000));
}

static void build_table(Scene *scene, double x, double z) {
    Material wood = diffuse(0.42, 0.24, 0.12);
    double half_width = 0.75, half_depth = 0.45, leg = 0.06, top = 0.74;
    box(scene, vec(x - half_width, top - 0.04, z - half_depth), vec(x + half_width, top, z + half_depth), wood);
    for (int corner = 0; corner < 4; corner++) {
        double leg_x = corner & 1 ? x + half_width - leg : x - half_width;
        double leg_z = corner & 2 ? z + half_depth - leg : z - half_depth;
        box(scene, vec(leg_x, 0, leg_z), vec(leg_x + leg, top - 0.04, leg_z + leg), wood);
    }
    sphere(scene, vec(x - 0.3, top + 0.14, z + 0.05), 0.14, conductor(1.0, 0.77, 0.34, 0.3));
    sphere(scene, vec(x + 0.08, top + 0.08, z + 0.22), 0.08, diffuse(0.75, 0.12, 0.08));
    sphere(scene, vec(x - 0.02, top + 0.07, z + 0.02), 0.07, diffuse(0.35, 0.5, 0.1));
    box(scene, vec(x + 0.25, top, z - 0.2), vec(x + 0.55, top + 0.04, z + 0.05), diffuse(0.1, 0.2, 0.5));
    box(scene, vec(x + 0.28, top + 0.04, z - 0.18), vec(x + 0.53, top + 0.07, z + 0.03), diffuse(0.6, 0.15, 0.12));
}

/* An open shelf against the wall of the door: its inside is where little light comes. */
static void build_shelf(Scene *scene) {
    Material wood = diffuse(0.2, 0.11, 0.06);
    double left = -2.6, right = -1.2, front = -2.62, back = -3, thick = 0.03, high = 1.75;
    box(scene, vec(left, 0, back), vec(left + thick, high, front), wood);
    box(scene, vec(right - thick, 0, back), vec(right, high, front), wood);
    box(scene, vec(left, 0, back), vec(right, high, back + 0.01), wood);
    for (int board = 0; board < 4; board++) {
        double y = board * (high - thick) / 3;
        box(scene, vec(left, y, back), vec(right, y + thick, front), wood);
    }
    static const double colours[][3] = {{0.5, 0.08, 0.06}, {0.08, 0.2, 0.4},  {0.6, 0.5, 0.3},
                                        {0.1, 0.3, 0.15},  {0.5, 0.25, 0.05}, {0.3, 0.3, 0.32}};
    for (int book = 0; book < 12; book++) {
        const double *colour = colours[(book * 5 + book / 6) % 6];
        double x = left + 0.1 + 0.09 * book, y = book < 7 ? 0.61 : 1.18, tall = 0.3 + 0.03 * (book * 7 % 4);
        box(scene, vec(x, y, back + 0.03), vec(x + 0.075, y + tall, front - 0.05 - 0.02 * (book * 3 % 4)),
            diffuse(colour[0], colour[1], colour[2]));
    }
}

static void build_interior(Scene *scene) {
    build_walls(scene);
    build_window(scene);
    build_lamp(scene, 0.25, -1.0);
    build_table(scene, 0.25, -1.0);
    build_shelf(scene);
    box(scene, vec(-1.9, 0, -1.3), vec(-0.75, 0.012, 1.2), tiles(0.5, 0.1, 0.08, 0.115, 0.25));
    /* a picture on the wall */
    box(scene, vec(-0.5, 1.25, -3), vec(0.6, 2.05, -2.97), diffuse(0.08, 0.05, 0.03));
    box(scene, vec(-0.44, 1.31, -3), vec(0.2, 1.99, -2.96), diffuse(0.8, 0.55, 0.12));
    box(scene, vec(0.22, 1.31, -3), vec(0.54, 1.6, -2.96), diffuse(0.6, 0.1, 0.06));
    box(scene, vec(0.22, 1.62, -3), vec(0.54, 1.99, -2.96), diffuse(0.8, 0.78, 0.7));
    scene->eye = vec(1.75, 1.5, 2.9);
    scene->target = vec(-0.25, 1.22, -1.5);
    scene->field_of_view = 48;
}

/* ---- glossy: metal and glass under small bright lamps; caustics that only chance finds make fireflies ---- */

static void build_glossy(Scene *scene) {
    box(scene, vec(-8, -0.5, -6.5), vec(8, 0, 8), tiles(0.5, 0.5, 0.52, 0.5, 0.5));
    box(scene, vec(-8, 0, -3.6), vec(8, 5, -3.4), diffuse(0.25, 0.27, 0.32));
    sphere(scene, vec(-1.25, 0.7, -0.9), 0.7, mirror(0.92));
    sphere(scene, vec(0.55, 0.55, 0.15), 0.55, glass());
    sphere(scene, vec(1.6, 0.6, -1.3), 0.6, conductor(1.0, 0.77, 0.34, 0.15));
    sphere(scene, vec(-0.55, 0.28, 0.75), 0.28, conductor(0.95, 0.64, 0.54, 0.05));
    sphere(scene, vec(-1.6, 0.22, 0.6), 0.22, diffuse(0.6, 0.08, 0.06));
    sphere(scene, vec(0.1, 0.25, -1.3), 0.25, diffuse(0.08, 0.25, 0.5));
    box(scene, vec(1.35, 0, 0.35), vec(1.85, 0.4, 0.85), glass());
    sphere(scene, vec(-2.2, 2.6, 1.0), 0.06, emitter(1, 0.8, 0.55, 5000));
    sphere(scene, vec(2.4, 2.2, 0.4), 0.05, emitter(0.55, 0.75, 1, 6000));
    sphere(scene, vec(0.3, 1.75, -1.9), 0.04, emitter(1, 0.35, 0.2, 2500));
    scene->zenith = vec(0.05, 0.08, 0.14);
    scene->horizon = vec(0.14, 0.13, 0.12);
    scene->eye = vec(0.2, 1.6, 4.8);
    scene->target = vec(0.05, 0.62, -0.4);
    scene->field_of_view = 38;
}

/* ---- object: one thing alone before nothing, with alpha; a glowing gas beside it has colour but no alpha ---- */

enum { RING_BEADS = 22 };

static void build_object(Scene *scene) {
    static const double ring_radius = 0.95, tilt = 0.45;
    box(scene, vec(-0.55, -1.25, -0.55), vec(0.55, -1.0, 0.55), diffuse(0.3, 0.3, 0.33));
    box(scene, vec(-0.35, -1.0, -0.35), vec(0.35, -0.85, 0.35), diffuse(0.55, 0.52, 0.5));
    box(scene, vec(-0.05, -0.85, -0.05), vec(0.05, -0.5, 0.05), conductor(0.8, 0.8, 0.8, 0.2));
    sphere(scene, vec(0, 0, 0), 0.55, conductor(1.0, 0.77, 0.34, 0.2));
    for (int bead = 0; bead < RING_BEADS; bead++) {
        double angle = 6.283185307179586 * bead / RING_BEADS, x = ring_radius * cos(angle),
               z = ring_radius * sin(angle);
        Material material = bead % 2 ? diffuse(0.1, 0.3, 0.6) : conductor(0.95, 0.64, 0.54, 0.1);
        sphere(scene, vec(x * cos(tilt), x * sin(tilt), z), bead % 2 ? 0.07 : 0.1, material);
    }
    /* the lamps are out of the picture */
    quad(scene, vec(-3, 2.5, 1), vec(1.5, 1, 0), vec(0, -0.5, 2), emitter(1, 0.9, 0.75, 18));
    quad(scene, vec(3, -0.5, 1), vec(0, 2, 0), vec(0.5, 0, 2), emitter(0.5, 0.7, 1, 6));
    scene->glow_centre = vec(0.62, 0.72, 0.1);
    scene->glow_radius = 0.62;
    scene->glow = vec(0.25, 1.1, 0.7);
    scene->has_alpha = true;
    scene->eye = vec(0, 0.9, 4.6);
    scene->target = vec(0, -0.09, 0);
    scene->field_of_view = 36;
}

bool build_scene(const char *name, Scene *scene) {
    static const struct {
        const char *name;
        void (*build)(Scene *);
    } scenes[] = {{"interior", build_interior}, {"glossy", build_glossy}, {"object", build_object}};

    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        if (strcmp(name, scenes[i].name) == 0) {
            scenes[i].build(scene);
            return true;
        }
    }
    return false;
}

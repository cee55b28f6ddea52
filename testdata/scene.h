/*
 * scene: vectors, and what a scene is made of.
 *
 * SPDX-License-Identifier: BSD-3-Clause
 */
#ifndef HDRPIPE_TESTDATA_SCENE_H
#define HDRPIPE_TESTDATA_SCENE_H

#include <math.h>
#include <stdbool.h>

/* ---- Vectors, which are points, directions and colours ---- */

typedef struct {
    double x, y, z;
} Vec;

static inline Vec vec(double x, double y, double z) {
    return (Vec){x, y, z};
}

static inline Vec add(Vec a, Vec b) {
    return vec(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline Vec sub(Vec a, Vec b) {
    return vec(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline Vec mul(Vec a, Vec b) {
    return vec(a.x * b.x, a.y * b.y, a.z * b.z);
}

static inline Vec scale(Vec a, double s) {
    return vec(a.x * s, a.y * s, a.z * s);
}

static inline Vec mix(Vec a, Vec b, double t) {
    return add(scale(a, 1 - t), scale(b, t));
}

static inline double dot(Vec a, Vec b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline Vec cross(Vec a, Vec b) {
    return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline double length(Vec a) {
    return sqrt(dot(a, a));
}

static inline Vec normalise(Vec a) {
    return scale(a, 1 / length(a));
}

static inline double largest(Vec a) {
    return fmax(a.x, fmax(a.y, a.z));
}

/* ---- Scenes. Lengths are metres, y is up, colours are linear Rec.709. ---- */

/* A PORTAL is an opening that shows the sky: nothing that stops a ray, but a place to aim at when sampling light. */
typedef enum { DIFFUSE, CONDUCTOR, MIRROR, GLASS, EMITTER, PORTAL } MaterialKind;

typedef struct {
    MaterialKind kind;
    Vec colour;       /* albedo, reflectance at normal incidence, or emitted radiance */
    double parameter; /* CONDUCTOR: GGX roughness alpha; GLASS: index of refraction */
    Vec tile;         /* DIFFUSE: where not 0, the size of tiles, each of its own shade */
} Material;

typedef enum { SPHERE, BOX, QUAD } Shape;

typedef struct {
    Shape shape;
    Vec a, b, c; /* SPHERE: centre a, radius b.x; BOX: from corner a to b; QUAD: corner a, edges b and c */
    Material material;
} Primitive;

enum { MOST_PRIMITIVES = 96, MOST_LIGHTS = 16 };

typedef struct {
    Primitive primitives[MOST_PRIMITIVES];
    int primitive_count;
    int lights[MOST_LIGHTS]; /* the emitters and portals among the primitives */
    int light_count;
    Vec zenith, horizon, ground; /* radiance of the sky, and of what lies below the horizon */
    Vec glow_centre, glow;       /* a ball of emissive gas that absorbs nothing; its radiance through the middle */
    double glow_radius;
    Vec eye, target;
    double field_of_view; /* of the picture's height, in degrees */
    bool has_alpha;
} Scene;

/* Builds the scene of this name: interior, glossy or object. False: there is none. */
bool build_scene(const char *name, Scene *scene);

#endif

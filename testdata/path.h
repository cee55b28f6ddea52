/*
 * path: the light that one random path from the eye finds.
 *
 * SPDX-License-Identifier: BSD-3-Clause
 */
#ifndef HDRPIPE_TESTDATA_PATH_H
#define HDRPIPE_TESTDATA_PATH_H

#include "scene.h"

#include <stdint.h>

typedef struct {
    uint64_t state, increment;
} Random;

/* The stream of random numbers with this name; streams of other names are independent. */
Random random_stream(uint64_t seed, uint64_t pixel, uint64_t sample);

/* The stream's next number, in [0,1). */
double uniform(Random *random);

typedef struct {
    Vec origin, direction;
    Vec inverse; /* of the direction, by component */
} Ray;

Ray ray_from(Vec origin, Vec direction);

/* The radiance that one path finds that begins with this ray, and whether this ray meets a surface at all. */
Vec trace_path(const Scene *scene, Ray ray, Random *random, bool *covered);

#endif

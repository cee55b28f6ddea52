/* For test_reinhard_local: the one place where the library's own surround is called. */
#ifndef HDR_TESTS_LIBRARY_SCALES_H
#define HDR_TESTS_LIBRARY_SCALES_H

#include "spatial/scales.h"

#include <math.h>

/* SPEC's numbers in the plane's units, in which L = 1 is 1 / scale. */
static inline hdr_scales library_scales(double scale, double key, double phi, double epsilon) {
    hdr_scales scales = {.epsilon = epsilon, .unit = 1 / scale};
    for (int i = 0; i <= HDR_SCALES; i++) {
        double s = pow(1.6, i);
        scales.sigma[i] = s / 4;
        if (i < HDR_SCALES) scales.offset[i] = exp2(phi) * key / (s * s) / scale;
    }
    return scales;
}

/* The library's V_m of each pixel, in units of the plane, as oracle_surround has it; reference: by its exact form.
 * False: it failed. */
static inline bool library_surround(bool reference, const double *plane, int width, int height, double scale,
                                    double key, double phi, double epsilon, double *surround) {
    hdr_error error = {0};
    hdr_plane *in = hdr_plane_new(width, height, reference, &error),
              *out = hdr_plane_new(width, height, reference, &error);
    hdr_pool *pool = hdr_pool_new(2, &error);
    for (int y = 0; in && y < height; y++)
        for (int x = 0; x < width; x++) {
            double number = plane[(size_t)y * (size_t)width + (size_t)x];
            size_t at = (size_t)y * in->stride + (size_t)x;
            if (reference)
                in->wide[at] = number;
            else
                in->narrow[at] = (float)number;
        }
    hdr_scales scales = library_scales(scale, key, phi, epsilon);
    hdr_scales_report report;
    bool too_wide = false;
    bool done =
        in && out && pool && hdr_scales_surround(&scales, in, out, NULL, pool, &report, &too_wide, &error) == HDR_OK;
    for (int y = 0; done && y < height; y++)
        for (int x = 0; x < width; x++) {
            size_t at = (size_t)y * out->stride + (size_t)x;
            surround[(size_t)y * (size_t)width + (size_t)x] = reference ? out->wide[at] : (double)out->narrow[at];
        }
    hdr_pool_free(pool);
    hdr_plane_free(in);
    hdr_plane_free(out);
    return done;
}

#endif

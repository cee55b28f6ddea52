/* How far the surround of a pixel reaches: for each pixel of a plane the largest of several Gaussian neighbourhoods
 * that is still even, or rather the first that is not. Reinhard, Stark, Shirley and Ferwerda, Photographic Tone
 * Reproduction for Digital Images, SIGGRAPH 2002, section 3.2, with the rule of the authors' own code. */
#ifndef HDR_SCALES_H
#define HDR_SCALES_H

#include "base/pool.h"
#include "picture/plane.h"

enum { HDR_SCALES = 8 }; /* that are tested: each against the next, so that there are nine Gaussians */

/* V_i is the plane, in which nothing is below 0, convolved with the Gaussian of sigma[i] (integrated over each pixel,
 * normalised, the border mirrored). The surround of a pixel is V_m there, m being the first i with |V_i - V_(i+1)| >
 * epsilon (offset[i] + V_i), or the last test's i where there is none: so that the last test, and the last Gaussian,
 * never matter. */
typedef struct hdr_scales {
    double sigma[HDR_SCALES + 1];
    double offset[HDR_SCALES]; /* >= 0, in the plane's unit */
    double epsilon;
    double unit;  /* a change of 1e-8 of it is of no account in a V close to 0 */
    bool no_skip; /* compute what cannot matter, too */
} hdr_scales;

typedef struct hdr_scales_report {
    uint64_t blurred[HDR_SCALES + 1]; /* pixels for which each Gaussian was computed */
    uint64_t chosen[HDR_SCALES];      /* pixels whose m this is */
    uint64_t settled;                 /* tests that float left open, made again in double */
    int reach[HDR_SCALES + 1];        /* of each Gaussian, in pixels */
} hdr_scales_report;

/* surround: of plane's size and type. A narrow plane is convolved in float: a V is wrong by no more than 2^-23 (reach +
 * 4) of itself (6e-6 for the widest that is used; in practice 1e-7) plus 1e-8 units, and no m is another than that of
 * the same numbers in double. Where the numbers are nothing for that, *too_wide is set and nothing else: make the plane
 * wide. A wide one in double, every Gaussian everywhere: the reference. choice: m of each pixel, width * height of
 * them, or NULL. */
hdr_status hdr_scales_surround(const hdr_scales *scales, const hdr_plane *plane, hdr_plane *surround,
                               unsigned char *choice, hdr_pool *pool, hdr_scales_report *report, bool *too_wide,
                               hdr_error *err);

#endif

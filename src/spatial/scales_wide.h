/* The same search in double, every Gaussian everywhere: what --reference computes. */
#ifndef HDR_SCALES_WIDE_H
#define HDR_SCALES_WIDE_H

#include "spatial/scales.h"

/* As hdr_scales_surround, of wide planes. */
hdr_status hdr_scales_surround_wide(const hdr_scales *scales, const hdr_plane *plane, hdr_plane *surround,
                                    unsigned char *choice, hdr_pool *pool, hdr_scales_report *report, hdr_error *err);

/* How far its Gaussians reach, where the plane's largest number is `ratio` units: at least 8 standard deviations, and
 * so far that the brightest pixel there is does not count. */
int hdr_scales_full_reach(double sigma, double ratio);

#endif

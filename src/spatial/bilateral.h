/* The bilateral filter of a plane, by several methods.
 *
 *     base(s) = sum over p of f(p - s) g(i_p - i_s) i_p, divided by the same sum without i_p
 *
 * with Gaussians f of standard deviation sigma_s in pixels and g of sigma_r in the plane's unit; p runs over the
 * picture, whose border cuts the window. Tomasi and Manduchi 1998; Durand and Dorsey, Fast Bilateral Filtering for the
 * Display of High-Dynamic-Range Images, SIGGRAPH 2002, section 4. */
#ifndef HDR_BILATERAL_H
#define HDR_BILATERAL_H

#include "base/pool.h"
#include "picture/plane.h"

typedef struct hdr_bilateral {
    double sigma_s, sigma_r; /* above 0 */
    double low, high;        /* of the plane: the least and the largest number */
    bool no_skip;            /* compute what cannot matter, too */
    /* Pixels whose base is wanted, rows of hdr_mask_row; that of others may be anything, though they count in sums as
     * any. NULL: all. */
    const unsigned char *wanted;
} hdr_bilateral;

/* What was computed, for --explain. */
typedef struct hdr_bilateral_report {
    uint64_t cells, used; /* of a grid, or of the piecewise method's i_j: as many as the range would take, and as many
                             as some number needs */
    int segments;         /* of the piecewise method */
} hdr_bilateral_report;

/* By the sum itself, in double, over all pixels no farther than `reach` standard deviations in x and in y; base may
 * take the plane's place: the plane is copied first. Wide or narrow planes. Slow; with HDR_EXACT_REACH it is the
 * oracle, with less the fastest way where sigma_s is a pixel or two. */
#define HDR_EXACT_REACH 8
hdr_status hdr_bilateral_exact(const hdr_bilateral *filter, double reach, const hdr_plane *plane, hdr_plane *base,
                               hdr_pool *pool, hdr_error *err);

/* The same of some pixels. */
hdr_status hdr_bilateral_exact_at(const hdr_bilateral *filter, double reach, const hdr_plane *plane, int count,
                                  const hdr_pixel *pixels, double *values, hdr_pool *pool, hdr_error *err);

/* By a bilateral grid of cells of sigma_s / across and sigma_r / deep, into which pixels are sown, and from which they
 * are read, by cubic B-splines; the Gaussians in it are narrower by what these add. Narrow planes; the base takes the
 * plane's place. No base is wrong by more than hdr_grid_bound. Chen, Paris and Durand, Real-time
 * Edge-Aware Image Processing with the Bilateral Grid, SIGGRAPH 2007; Paris and Durand, IJCV 81(1), 2009. */
hdr_status hdr_bilateral_grid(const hdr_bilateral *filter, double across, double deep, hdr_plane *plane, hdr_pool *pool,
                              hdr_bilateral_report *report, hdr_error *err);

/* Nodes of such a grid, and what it takes, were all of it stored, without what each thread works in. */
typedef struct hdr_grid_size {
    double columns, rows, levels, bytes;
} hdr_grid_size;
hdr_grid_size hdr_grid_size_of(const hdr_bilateral *filter, const hdr_plane *plane, double across, double deep);

double hdr_grid_bound(const hdr_bilateral *filter, double pixels, double across, double deep);

/* No grid that is chosen takes more bytes than that. */
#define HDR_GRID_BYTES 2e9

/* By the paper's own fast algorithm, PiecewiseBilateral: between values of intensity at most sigma_r apart, for which
 * the filter is computed at every pixel, on a picture of every `subsample`-th pixel. Narrow planes; the base takes the
 * plane's place. */
hdr_status hdr_bilateral_piecewise(const hdr_bilateral *filter, int subsample, hdr_plane *plane, hdr_pool *pool,
                                   hdr_bilateral_report *report, hdr_error *err);

/* No base of it is wrong by more than that many sigma_r; nor, of course, by more than the plane's range. */
double hdr_piecewise_bound(int subsample, double sigma_s);

/* 1 to 25, so that sigma_s becomes 2 to 3 samples, where that can be. */
int hdr_piecewise_subsample(double sigma_s);

/* The cheapest way to a tolerance, in the plane's unit, of grids of several sizes and of a sum that is cut where what
 * lies beyond does not matter; or of either kind, if only one may be taken. Where nothing keeps it, the most accurate.
 * across is 0 where only a grid may be taken, and none is small enough. */
typedef struct hdr_bilateral_choice {
    bool grid;
    double across, deep; /* of the grid */
    double reach;        /* of the sum */
    double bound;        /* no base is farther from the exact one */
} hdr_bilateral_choice;
hdr_bilateral_choice hdr_bilateral_choose(const hdr_bilateral *filter, const hdr_plane *plane, double tolerance,
                                          bool only_grid, bool only_direct);

#endif

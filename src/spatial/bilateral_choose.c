#include "spatial/bilateral.h"

#include "kernel/real.h"

#include <math.h>

/* Coarser ones would do for the bound where crowds are small, but their usual error would be felt in codes. */
enum { LEAST_ACROSS = 3, MOST_ACROSS = 16, LEAST_DEEP = 4, MOST_DEEP = 16 };

static double fourth(double x) {
    return x * x * x * x;
}

/* A pixel by itself weighs 1, a crowd of n pixels D sigma_r away from it in intensity n exp(-D^2 / 2), so that both
 * pull alike at D = sqrt(2 ln n), and there base moves by D / 4 for each part by which the crowd's weight is wrong.
 * Where pixels and nodes stand to each other makes that part up to (D / (2 pi deep))^4 times a few at each end, which
 * is cubic B-splines' error of interpolation, and D^5 / deep^4 in all; the same in space, where it pulls less. No two
 * pixels are farther apart than the range; but that part is no smaller where the whole range is, since the Gaussian's
 * fourth derivative does not vanish at its middle: hence at least 2 there. The factors are those of a search for the
 * worst among tens of thousands of scenes (fireflies, crowds, islands and pixels between crowds; sigma_s up to 500
 * pixels, D = 5.3), which came to 0.4 to 0.8 of this: tests/laws/test_durand_bounds.c starts from what it found. */
double hdr_grid_bound(const hdr_bilateral *filter, double pixels, double across, double deep) {
    double crowd = fmin(6.283185307179586 * filter->sigma_s * filter->sigma_s, pixels);
    double d = sqrt(2 * hdr_log(fmax(crowd, 90)));
    double apart = fmin(d, (filter->high - filter->low) / filter->sigma_r);
    return apart / 1440 * (fourth(fmax(apart, 2) / deep) + 0.15 * fourth(d / across)) * filter->sigma_r;
}

/* Without subsampling the error is that of linear interpolation between the J_j, and largest where a pixel stands
 * between two crowds, darker and brighter, so that one node sees the one and the next the other. With M the weight of
 * all other pixels, that of the pixel being 1, a search among up to three crowds of any weights and places finds
 *     M            0.1    1      6.3   25    160   630   3.7e4  1e6   1e8   2e9
 *     sigma_r      0.015  0.088  0.21  0.44  0.90  1.31  2.56   3.54  4.82  5.60
 * which is 0.10 to 0.26 of ln(1 + M); and f adds up to no more than 1 + sqrt(2 pi) sigma_s in x and in y. In 20000
 * scenes at random (tests/unit/test_piecewise.c: crowds, fireflies, ramps, steps and noise of 1 to 12 decades) the
 * farthest base is 1.1 sigma_r off, and none is off by more than 0.56 of the bound.
 *
 * With subsampling nothing is certain: a pixel is not seen unless it is sampled, and one that is not, between 3 and
 * 13 sigma_r from those that are, takes their base.
 *
 * Of pixels of photographs, half of them local extremes, sigma_s = 0.02 of the larger side, in sigma_r:
 *     picture       range  subsample         largest         1 in 1000         root mean square
 *     CandleGlass   9.3    1,  8 (auto), 25  0.38, 4.9, 8.2  0.11,  0.81, 3.7  0.011,  0.091, 0.22
 *     Carrots       3.0    1,  5 (auto), 25  0.07, 0.4, 1.3  0.064, 0.25, 1.1  0.011,  0.029, 0.23
 *     Desk          8.7    1,  7 (auto), 25  0.12, 2.1, 3.2  0.10,  1.0,  2.6  0.020,  0.088, 0.32
 *     GoldenGate    5.5    1, 10 (auto), 25  0.19, 1.9, 3.0  0.055, 0.26, 0.41 0.0068, 0.036, 0.073 */
double hdr_piecewise_bound(int subsample, double sigma_s) {
    return subsample > 1 ? INFINITY : 0.3 * 2 * hdr_log(1 + 2.5066282746310002 * sigma_s);
}

int hdr_piecewise_subsample(double sigma_s) {
    double subsample = floor(sigma_s / 2.5 + 0.5);
    return subsample < 1 ? 1 : subsample > 25 ? 25 : (int)subsample;
}

/* Nanoseconds on one core of a machine of 2020, roughly: only their proportions matter. */
static double grid_cost(const hdr_plane *plane, const hdr_grid_size *size, double across, double deep) {
    double blur = 6.5 * (2 * across + deep);
    return (double)plane->width * plane->height * 20 + plane->height * size->columns * size->levels * 1.5 +
           size->columns * size->rows * size->levels * blur * 0.25;
}

static double direct_cost(const hdr_bilateral *f, const hdr_plane *plane, double reach) {
    double side = 2 * ceil(reach * f->sigma_s) + 1;
    double taps = fmin(side, plane->width) * fmin(side, plane->height);
    return (double)plane->width * plane->height * (taps * 1.2 + side * 5);
}

/* What lies beyond a square of half the side r weighs less than 2 pi sigma^2 2 erfc(r / (sigma sqrt 2)), the pixel
 * itself 1, and each is at most the whole range away. */
static double direct_bound(const hdr_bilateral *f, double reach) {
    double around = 6.283185307179586 * f->sigma_s * f->sigma_s + 4 * f->sigma_s + 1;
    return (f->high - f->low) * around * 2 * hdr_exp(-0.5 * reach * reach);
}

/* The cheapest grid that keeps a tolerance, or the finest. across is 0 where none is small enough. */
static hdr_bilateral_choice choose_grid(const hdr_bilateral *filter, const hdr_plane *plane, double tolerance,
                                        double *cost) {
    hdr_bilateral_choice best = {.grid = true, .bound = INFINITY};
    *cost = INFINITY;
    for (int across = LEAST_ACROSS; across <= MOST_ACROSS; across++)
        for (int deep = LEAST_DEEP; deep <= MOST_DEEP; deep++) {
            hdr_grid_size size = hdr_grid_size_of(filter, plane, across, deep);
            if (size.bytes > HDR_GRID_BYTES) continue; /* memory that nobody meant to spend */
            double bound = hdr_grid_bound(filter, (double)plane->width * plane->height, across, deep);
            double own = grid_cost(plane, &size, across, deep);
            bool better = bound <= tolerance ? best.bound > tolerance || own < *cost : bound < best.bound;
            if (!better) continue;
            best = (hdr_bilateral_choice){true, across, deep, 0, bound};
            *cost = own;
        }
    return best;
}

/* The piecewise method is not among them: a tolerance that its bound keeps, some tenths of sigma_r, is kept tenfold by
 * a grid that costs less. */
hdr_bilateral_choice hdr_bilateral_choose(const hdr_bilateral *filter, const hdr_plane *plane, double tolerance,
                                          bool only_grid, bool only_direct) {
    hdr_bilateral_choice direct = {.reach = 1};
    while (direct.reach < HDR_EXACT_REACH && direct_bound(filter, direct.reach) > tolerance)
        direct.reach += 0.25;
    direct.bound = direct_bound(filter, direct.reach);
    double cost;
    hdr_bilateral_choice grid = choose_grid(filter, plane, tolerance, &cost);
    if (only_grid) return grid;
    if (only_direct || grid.across == 0) return direct;
    return grid.bound <= tolerance && cost < direct_cost(filter, plane, direct.reach) ? grid : direct;
}

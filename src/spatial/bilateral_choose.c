#include "spatial/bilateral.h"

#include "kernel/real.h"

#include <math.h>

/* Grids, the cheapest first, and how far a base may be from the exact one, in units of sigma_r. */
static const struct {
    double across, deep, bound;
} grids[] = {{2, 2, 0.025}, {2, 4, 0.01}, {3, 4, 0.0025}, {4, 6, 0.001}};
enum { GRIDS = sizeof grids / sizeof grids[0] };

double hdr_grid_bound(double across, double deep) {
    for (int i = 0; i < GRIDS; i++)
        if (across >= grids[i].across && deep >= grids[i].deep &&
            (i + 1 == GRIDS || across < grids[i + 1].across || deep < grids[i + 1].deep))
            return grids[i].bound;
    return 1;
}

/* Nanoseconds on one core of a machine of 2020, roughly: only their proportions matter. */
static double grid_cost(const hdr_bilateral *f, const hdr_plane *plane, int i) {
    double across = f->sigma_s / grids[i].across, deep = f->sigma_r / grids[i].deep;
    double columns = plane->width / across + 4, rows = plane->height / across + 4,
           levels = (f->high - f->low) / deep + 4;
    double pixels = (double)plane->width * plane->height;
    double blur = 6.5 * (4 * grids[i].across + 2 * grids[i].deep);
    return pixels * 15 + plane->height * columns * levels * 0.8 + columns * rows * levels * blur * 0.2;
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

hdr_bilateral_choice hdr_bilateral_choose(const hdr_bilateral *filter, const hdr_plane *plane, double tolerance,
                                          bool only_grid, bool only_direct) {
    hdr_bilateral_choice direct = {.reach = 1};
    while (direct.reach < HDR_EXACT_REACH && direct_bound(filter, direct.reach) > tolerance)
        direct.reach += 0.25;
    direct.bound = direct_bound(filter, direct.reach);
    hdr_bilateral_choice best = direct;
    double cost = only_grid ? INFINITY : direct_cost(filter, plane, direct.reach);
    for (int i = 0; i < GRIDS && !only_direct; i++) {
        double bound = grids[i].bound * filter->sigma_r, own = grid_cost(filter, plane, i);
        if ((bound <= tolerance || (only_grid && i + 1 == GRIDS && !best.grid)) && own < cost) {
            best = (hdr_bilateral_choice){true, grids[i].across, grids[i].deep, 0, bound};
            cost = own;
        }
    }
    return best;
}

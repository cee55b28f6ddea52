/* Non-local means of a picture whose noise is known at each pixel, with the noise's share taken off all differences.
 *
 *     out(p) = sum over q of w(p,q) u(q), divided by the sum of w(p,q)        q: no farther than `radius` in x and in y
 *     w(p,q) = exp(-max(0, mean over channels and patch offsets n of d2(p + n, q + n)))    n: no farther than `patch`
 *     d2(a,b) = ((u(a) - u(b))^2 - (Var(a) + min(Var(a), Var(b)))) / (k^2 (Var(a) + Var(b)))
 *
 * Rousselle, Knaus and Zwicker, Adaptive Rendering with Non-Local Means Filtering, ACM Transactions on Graphics 31(6),
 * 2012, section 4, with alpha = 1; after Buades, Coll and Morel, A Non-Local Algorithm for Image Denoising, CVPR 2005.
 * Their epsilon of 1e-10 beside the variances, against 0/0, is left out so that a picture's unit does not matter: 0/0
 * is 0 here, and all else over 0 infinity. Windows and patches are cut at the picture's border, patches for both pixels
 * alike. A pixel with a component that is not finite is no q, and counts as equal to any in a patch. */
#ifndef HDR_NLMEANS_H
#define HDR_NLMEANS_H

#include "base/base.h"

typedef struct hdr_nlmeans {
    double k;          /* at least HDR_NLMEANS_LEAST_K */
    double above;      /* of a pixel's brightness: a pixel is filtered if a channel's standard deviation is larger */
    int radius, patch; /* at most HDR_NLMEANS_MOST_RADIUS and HDR_NLMEANS_MOST_PATCH */
    bool reference;    /* by the sums themselves, in double */
    bool no_skip;      /* compute what is not wanted, too */
} hdr_nlmeans;

#define HDR_NLMEANS_LEAST_K 0.1
#define HDR_NLMEANS_MOST_RADIUS 50
#define HDR_NLMEANS_MOST_PATCH 10
#define HDR_NLMEANS_ROWS 64

/* Rows of a picture and of its noise, channel by channel, without gaps. The deviations are finite and not negative. */
typedef struct hdr_nlmeans_rows {
    int channels, width, height; /* of the picture; 1 to 3 channels */
    int first, end;              /* the rows that are there: those wanted and hdr_nlmeans_reach more on both sides */
    const float *colour[3], *deviation[3];
    int wanted_first, wanted_end; /* the rows that are wanted */
    float *out[3];                /* they; a pixel that is not filtered stays as it is, bit for bit */
} hdr_nlmeans_rows;

/* How many rows above and below one matter to it, within the picture. */
int hdr_nlmeans_reach(const hdr_nlmeans *filter);

/* What a thread works in. NULL: out of memory. */
typedef struct hdr_nlmeans_room hdr_nlmeans_room;
hdr_nlmeans_room *hdr_nlmeans_room_new(const hdr_nlmeans *filter);
void hdr_nlmeans_room_free(hdr_nlmeans_room *room);

/* Filters the rows that are wanted. How many of their pixels were left alone. The same bits whatever the rows are cut
 * into, as long as they begin at a multiple of HDR_NLMEANS_ROWS or are computed in double. */
uint64_t hdr_nlmeans_filter(const hdr_nlmeans *filter, const hdr_nlmeans_rows *rows, hdr_nlmeans_room *room);

/* No result is farther from that of the reference than this many times the largest difference of its channel within
 * its window. */
double hdr_nlmeans_bound(const hdr_nlmeans *filter);

/* ---- For the two ways of computing it ---- */

/* A number's place in the planes of rows. */
static inline size_t hdr_nlmeans_place(const hdr_nlmeans_rows *rows, int x, int y) {
    return (size_t)(y - rows->first) * (size_t)rows->width + (size_t)x;
}

/* Whether all components of a pixel are finite. */
static inline bool hdr_nlmeans_sound(const hdr_nlmeans_rows *rows, size_t at) {
    bool sound = true;
    for (int c = 0; c < rows->channels; c++)
        sound &= rows->colour[c][at] - rows->colour[c][at] == 0;
    return sound;
}

/* Whether a pixel is to be filtered. */
bool hdr_nlmeans_is_wanted(const hdr_nlmeans *filter, const hdr_nlmeans_rows *rows, size_t at);

/* The reference. */
uint64_t hdr_nlmeans_exact(const hdr_nlmeans *filter, const hdr_nlmeans_rows *rows);

#endif

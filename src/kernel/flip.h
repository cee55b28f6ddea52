/* Inner loops of FLIP, in double: see measure/flip.c for what they are part of. They go over a square of pixels and a
 * margin around it. */
#ifndef HDR_KERNEL_FLIP_H
#define HDR_KERNEL_FLIP_H

#include "base/base.h"

enum { HDR_FLIP_SIDE = 64, HDR_FLIP_PIXELS = HDR_FLIP_SIDE * HDR_FLIP_SIDE };

/* ---- Light on a display ---- */

/* In place, to [0,1]: light as it is; codes of sRGB; or a scene's light times scale under a tone curve. */
void hdr_flip_clamp(double *values, size_t count);
void hdr_flip_decode(double *values, size_t count);
void hdr_flip_tone_map(const double *light, double scale, double *values, size_t count);

/* a of a x^2 + b x + c = 0, and so on, whose larger root that curve maps to t. */
void hdr_flip_tone_equation(double t, double abc[3]);

/* ---- Filters ---- */

/* Opponent colours: y = Y/Yn, cx = X/Xn - y, cz = y - Z/Zn. */
typedef struct hdr_flip_colours {
    double to_opponent[9], to_rgb[9], to_xyz[9]; /* by rows; XYZ is divided by white's */
    double largest, knee;                        /* c_max^q_c and p_c of it */
} hdr_flip_colours;
void hdr_flip_colours_init(hdr_flip_colours *colours);

void hdr_flip_to_opponent(const hdr_flip_colours *colours, const double *const rgb[3], double *const opponent[3],
                          size_t count);

/* What a pixel k to the right is multiplied with, and one k to the left, too, but for `edge`, which changes sign.
 * `point` is summed over differences from the pixel itself. */
typedef struct hdr_flip_tap {
    double y, cx, cz[2], smooth, edge, point;
} hdr_flip_tap;

typedef struct hdr_flip_filters {
    int reach;
    double share[2];   /* of the two parts of cz */
    hdr_flip_tap *tap; /* reach + 1 */
} hdr_flip_filters;

/* A row that has been filtered across: each of these HDR_FLIP_SIDE numbers. */
enum {
    HDR_FLIP_Y,
    HDR_FLIP_SMOOTH,
    HDR_FLIP_EDGE,
    HDR_FLIP_POINT,
    HDR_FLIP_CX,
    HDR_FLIP_CZ0,
    HDR_FLIP_CZ1,
    HDR_FLIP_ROWS
};
typedef double hdr_flip_row[HDR_FLIP_ROWS][HDR_FLIP_SIDE];

/* opponent: at the row's first pixel, with filters->reach more to both sides. What is not coloured has 0 there. */
void hdr_flip_across(const hdr_flip_filters *filters, const double *const opponent[3], bool coloured,
                     hdr_flip_row *out);

/* What two pictures are compared by: L*, Hunt-adjusted a* and b* of what is left of the contrast, and how much of an
 * edge and of a point there is. */
enum { HDR_FLIP_L, HDR_FLIP_A, HDR_FLIP_B, HDR_FLIP_EDGES, HDR_FLIP_POINTS, HDR_FLIP_FEATURES };
typedef double hdr_flip_features[HDR_FLIP_FEATURES][HDR_FLIP_PIXELS];

/* rows: the square's first, with filters->reach more before it and behind its last. */
void hdr_flip_down(const hdr_flip_filters *filters, const hdr_flip_colours *colours, const hdr_flip_row *rows,
                   bool coloured, hdr_flip_features *out);

/* Raises numbers to what FLIP is of the two. */
void hdr_flip_raise(const hdr_flip_colours *colours, const hdr_flip_features *test, const hdr_flip_features *reference,
                    double flip[HDR_FLIP_PIXELS]);

#endif

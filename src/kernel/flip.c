#include "kernel/flip.h"

#include "base/cpu.h"
#include "kernel/real.h"

#include <math.h>
#include <string.h>

/* ---- Light on a display ---- */

HDR_INLINE double clamped(double value) {
    double raised = value > 0 ? value : 0;
    return raised < 1 ? raised : 1;
}

HDR_INLINE void hdr_flip_clamp_body(double *values, size_t count) {
    for (size_t i = 0; i < count; i++)
        values[i] = clamped(values[i]);
}
HDR_VERSIONS(hdr_flip_clamp, (double *values, size_t count), (values, count))

/* IEC 61966-2-1:1999. */
HDR_INLINE void hdr_flip_decode_body(double *values, size_t count) {
    for (size_t i = 0; i < count; i++) {
        double code = clamped(values[i]);
        double curved = hdr_pow((code + 0.055) / 1.055, 2.4);
        values[i] = code <= 0.04045 ? code / 12.92 : curved;
    }
}
HDR_VERSIONS(hdr_flip_decode, (double *values, size_t count), (values, count))

/* Narkowicz, ACES Filmic Tone Mapping Curve, 2016: (2.51 x^2 + 0.03 x) / (2.43 x^2 + 0.59 x + 0.14), with the factor
 * 0.6 that was left out there, as HDR-FLIP has it. */
static const double tone[] = {0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14};

HDR_INLINE void hdr_flip_tone_map_body(const double *light, double scale, double *values, size_t count) {
    const double a = tone[0], b = tone[1], c = tone[2], d = tone[3], e = tone[4];
    for (size_t i = 0; i < count; i++) {
        double x = light[i] * scale;
        values[i] = clamped((a * x + b) * x / ((c * x + d) * x + e));
    }
}
HDR_VERSIONS(hdr_flip_tone_map, (const double *light, double scale, double *values, size_t count),
             (light, scale, values, count))

void hdr_flip_tone_equation(double t, double abc[3]) {
    abc[0] = tone[0] - t * tone[2];
    abc[1] = tone[1] - t * tone[3];
    abc[2] = -t * tone[4];
}

/* ---- Colours ---- */

HDR_INLINE double product(const double *m, double a, double b, double c) {
    return m[0] * a + m[1] * b + m[2] * c;
}

/* CIE 15:2004, 8.2.1: f, and of it L, a and b; then Hunt's effect as FLIP takes it: a and b are multiplied by L, and
 * divided by 100. */
HDR_INLINE double lab_curve(double t) {
    const double delta = 6.0 / 29;
    double root = hdr_pow(t, 1.0 / 3);
    return t > delta * delta * delta ? root : t / (3 * delta * delta) + 4.0 / 29;
}

HDR_INLINE void hunt_of(const hdr_flip_colours *colours, double r, double g, double b, double lab[3]) {
    double x = lab_curve(product(colours->to_xyz, r, g, b));
    double y = lab_curve(product(colours->to_xyz + 3, r, g, b));
    double z = lab_curve(product(colours->to_xyz + 6, r, g, b));
    double l = 116 * y - 16;
    lab[0] = l;
    lab[1] = 0.01 * l * (500 * (x - y));
    lab[2] = 0.01 * l * (200 * (y - z));
}

/* HyAB: Abasi, Amani Tehran and Fairchild, Distance Metrics for Very Large Color Differences, Color Research and
 * Application 45(2), 2020; to the power q_c = 0.7. */
HDR_INLINE double distance_of(double l, double a, double b) {
    return hdr_pow(fabs(l) + sqrt(a * a + b * b), 0.7);
}

static void invert(const double m[9], double inverse[9]) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            inverse[3 * i + j] = m[3 * a + c] * m[3 * b + d] - m[3 * a + d] * m[3 * b + c];
        }
    double determinant = m[0] * inverse[0] + m[1] * inverse[3] + m[2] * inverse[6];
    for (int i = 0; i < 9; i++)
        inverse[i] /= determinant;
}

/* sRGB's primaries to XYZ, in the fractions of FLIP's authors; a row's sum is white's X, Y or Z in the same unit. */
void hdr_flip_colours_init(hdr_flip_colours *colours) {
    static const double rows[9] = {10135552, 8788810, 4435075, 2613072, 8788810, 887015, 1425312, 8788810, 70074185};
    *colours = (hdr_flip_colours){.largest = 0};
    double *xyz = colours->to_xyz, *opponent = colours->to_opponent;
    for (int i = 0; i < 9; i++)
        xyz[i] = rows[i] / (rows[i / 3 * 3] + rows[i / 3 * 3 + 1] + rows[i / 3 * 3 + 2]);
    for (int i = 0; i < 3; i++) {
        opponent[i] = xyz[3 + i];
        opponent[3 + i] = xyz[i] - xyz[3 + i];
        opponent[6 + i] = xyz[3 + i] - xyz[6 + i];
    }
    invert(opponent, colours->to_rgb);
    /* the largest distance that two colours have: green from blue */
    double green[3], blue[3];
    hunt_of(colours, 0, 1, 0, green);
    hunt_of(colours, 0, 0, 1, blue);
    colours->largest = distance_of(green[0] - blue[0], green[1] - blue[1], green[2] - blue[2]);
    colours->knee = 0.4 * colours->largest;
}

HDR_INLINE void hdr_flip_to_opponent_body(const hdr_flip_colours *colours, const double *const rgb[3],
                                          double *const opponent[3], size_t count) {
    const double *r = rgb[0], *g = rgb[1], *b = rgb[2];
    for (int c = 0; c < 3; c++) {
        const double m0 = colours->to_opponent[3 * c], m1 = colours->to_opponent[3 * c + 1],
                     m2 = colours->to_opponent[3 * c + 2];
        double *out = opponent[c];
        for (size_t i = 0; i < count; i++)
            out[i] = m0 * r[i] + m1 * g[i] + m2 * b[i];
    }
}
HDR_VERSIONS(hdr_flip_to_opponent,
             (const hdr_flip_colours *colours, const double *const rgb[3], double *const opponent[3], size_t count),
             (colours, rgb, opponent, count))

/* ---- Filters ---- */

/* Sums of a few pixels side by side, which are added to tap by tap: so the compiler takes as many at a time as the
 * processor does. */
enum { COLUMNS = 16, MOST_SUMS = 5 };
typedef double sums[MOST_SUMS][COLUMNS];

/* Where all pixels are equal, `edge` and `point` are 0 without rounding: FLIP takes a root of what they differ by. */
HDR_INLINE void luminance_across(const hdr_flip_filters *filters, const double *y, sums sum) {
    for (int x = 0; x < COLUMNS; x++) {
        sum[HDR_FLIP_Y][x] = filters->tap[0].y * y[x];
        sum[HDR_FLIP_SMOOTH][x] = filters->tap[0].smooth * y[x];
        sum[HDR_FLIP_EDGE][x] = sum[HDR_FLIP_POINT][x] = 0;
    }
    for (int k = 1; k <= filters->reach; k++) {
        const hdr_flip_tap tap = filters->tap[k];
        for (int x = 0; x < COLUMNS; x++) {
            double right = y[x + k], left = y[x - k], both = right + left;
            sum[HDR_FLIP_Y][x] += tap.y * both;
            sum[HDR_FLIP_SMOOTH][x] += tap.smooth * both;
            sum[HDR_FLIP_EDGE][x] += tap.edge * (right - left);
            sum[HDR_FLIP_POINT][x] += tap.point * (both - (y[x] + y[x]));
        }
    }
}

enum { CX, CZ0, CZ1, CHROMA_SUMS };

HDR_INLINE void chroma_across(const hdr_flip_filters *filters, const double *cx, const double *cz, sums sum) {
    for (int x = 0; x < COLUMNS; x++) {
        sum[CX][x] = filters->tap[0].cx * cx[x];
        sum[CZ0][x] = filters->tap[0].cz[0] * cz[x];
        sum[CZ1][x] = filters->tap[0].cz[1] * cz[x];
    }
    for (int k = 1; k <= filters->reach; k++) {
        const hdr_flip_tap tap = filters->tap[k];
        for (int x = 0; x < COLUMNS; x++) {
            double z = cz[x + k] + cz[x - k];
            sum[CX][x] += tap.cx * (cx[x + k] + cx[x - k]);
            sum[CZ0][x] += tap.cz[0] * z;
            sum[CZ1][x] += tap.cz[1] * z;
        }
    }
}

HDR_INLINE void hdr_flip_across_body(const hdr_flip_filters *filters, const double *const opponent[3], bool coloured,
                                     hdr_flip_row *out) {
    sums sum;
    for (int x = 0; x < HDR_FLIP_SIDE; x += COLUMNS) {
        luminance_across(filters, opponent[0] + x, sum);
        for (int s = HDR_FLIP_Y; s <= HDR_FLIP_POINT; s++)
            memcpy(&(*out)[s][x], sum[s], sizeof sum[s]);
        if (!coloured) continue;
        chroma_across(filters, opponent[1] + x, opponent[2] + x, sum);
        for (int s = 0; s < CHROMA_SUMS; s++)
            memcpy(&(*out)[HDR_FLIP_CX + s][x], sum[s], sizeof sum[s]);
    }
}
HDR_VERSIONS(hdr_flip_across,
             (const hdr_flip_filters *filters, const double *const opponent[3], bool coloured, hdr_flip_row *out),
             (filters, opponent, coloured, out))

/* Of a row k further on. */
#define ROW(k, which) (row[k][which] + from)

/* What is left of y, and how much there is of an edge, and of a point. */
HDR_INLINE void luminance_down(const hdr_flip_filters *filters, const hdr_flip_row *row, int from, double *y,
                               double *edges, double *points) {
    enum { BLURRED, EDGE, POINT, EDGE_DOWN, POINT_DOWN };
    sums sum;
    const double *here = ROW(0, HDR_FLIP_SMOOTH);
    for (int x = 0; x < COLUMNS; x++) {
        sum[BLURRED][x] = filters->tap[0].y * ROW(0, HDR_FLIP_Y)[x];
        sum[EDGE][x] = filters->tap[0].smooth * ROW(0, HDR_FLIP_EDGE)[x];
        sum[POINT][x] = filters->tap[0].smooth * ROW(0, HDR_FLIP_POINT)[x];
        sum[EDGE_DOWN][x] = sum[POINT_DOWN][x] = 0;
    }
    for (int k = 1; k <= filters->reach; k++) {
        const hdr_flip_tap tap = filters->tap[k];
        const double *down = ROW(k, HDR_FLIP_SMOOTH), *up = ROW(-k, HDR_FLIP_SMOOTH);
        for (int x = 0; x < COLUMNS; x++) {
            sum[BLURRED][x] += tap.y * (ROW(k, HDR_FLIP_Y)[x] + ROW(-k, HDR_FLIP_Y)[x]);
            sum[EDGE][x] += tap.smooth * (ROW(k, HDR_FLIP_EDGE)[x] + ROW(-k, HDR_FLIP_EDGE)[x]);
            sum[POINT][x] += tap.smooth * (ROW(k, HDR_FLIP_POINT)[x] + ROW(-k, HDR_FLIP_POINT)[x]);
            sum[EDGE_DOWN][x] += tap.edge * (down[x] - up[x]);
            sum[POINT_DOWN][x] += tap.point * ((down[x] + up[x]) - (here[x] + here[x]));
        }
    }
    for (int x = 0; x < COLUMNS; x++) {
        y[x] = sum[BLURRED][x];
        edges[x] = sqrt(sum[EDGE][x] * sum[EDGE][x] + sum[EDGE_DOWN][x] * sum[EDGE_DOWN][x]);
        points[x] = sqrt(sum[POINT][x] * sum[POINT][x] + sum[POINT_DOWN][x] * sum[POINT_DOWN][x]);
    }
}

HDR_INLINE void chroma_down(const hdr_flip_filters *filters, const hdr_flip_row *row, int from, double *cx,
                            double *cz) {
    sums sum;
    for (int x = 0; x < COLUMNS; x++) {
        sum[CX][x] = filters->tap[0].cx * ROW(0, HDR_FLIP_CX)[x];
        sum[CZ0][x] = filters->tap[0].cz[0] * ROW(0, HDR_FLIP_CZ0)[x];
        sum[CZ1][x] = filters->tap[0].cz[1] * ROW(0, HDR_FLIP_CZ1)[x];
    }
    for (int k = 1; k <= filters->reach; k++) {
        const hdr_flip_tap tap = filters->tap[k];
        for (int x = 0; x < COLUMNS; x++) {
            sum[CX][x] += tap.cx * (ROW(k, HDR_FLIP_CX)[x] + ROW(-k, HDR_FLIP_CX)[x]);
            sum[CZ0][x] += tap.cz[0] * (ROW(k, HDR_FLIP_CZ0)[x] + ROW(-k, HDR_FLIP_CZ0)[x]);
            sum[CZ1][x] += tap.cz[1] * (ROW(k, HDR_FLIP_CZ1)[x] + ROW(-k, HDR_FLIP_CZ1)[x]);
        }
    }
    for (int x = 0; x < COLUMNS; x++) {
        cx[x] = sum[CX][x];
        cz[x] = filters->share[0] * sum[CZ0][x] + filters->share[1] * sum[CZ1][x];
    }
}

/* In place: y, cx and cz to L, a and b, by way of what the display can show. */
HDR_INLINE void perceive(const hdr_flip_colours *colours, double *restrict l, double *restrict a, double *restrict b) {
    const hdr_flip_colours fixed = *colours; /* a copy: nothing that is stored can change it */
    for (size_t i = 0; i < HDR_FLIP_PIXELS; i++) {
        double lab[3];
        double red = clamped(product(fixed.to_rgb, l[i], a[i], b[i]));
        double green = clamped(product(fixed.to_rgb + 3, l[i], a[i], b[i]));
        double blue = clamped(product(fixed.to_rgb + 6, l[i], a[i], b[i]));
        hunt_of(&fixed, red, green, blue, lab);
        l[i] = lab[0];
        a[i] = lab[1];
        b[i] = lab[2];
    }
}

/* Down narrow columns, whose rows stay in the cache from one pixel to the next. */
HDR_INLINE void hdr_flip_down_body(const hdr_flip_filters *filters, const hdr_flip_colours *colours,
                                   const hdr_flip_row *rows, bool coloured, hdr_flip_features *out) {
    double(*to)[HDR_FLIP_PIXELS] = *out;
    for (int x = 0; x < HDR_FLIP_SIDE; x += COLUMNS)
        for (int j = 0; j < HDR_FLIP_SIDE; j++) {
            size_t at = (size_t)(j * HDR_FLIP_SIDE + x);
            luminance_down(filters, &rows[j], x, to[HDR_FLIP_L] + at, to[HDR_FLIP_EDGES] + at,
                           to[HDR_FLIP_POINTS] + at);
            if (coloured) chroma_down(filters, &rows[j], x, to[HDR_FLIP_A] + at, to[HDR_FLIP_B] + at);
        }
    if (!coloured) {
        memset(to[HDR_FLIP_A], 0, sizeof to[HDR_FLIP_A]);
        memset(to[HDR_FLIP_B], 0, sizeof to[HDR_FLIP_B]);
    }
    perceive(colours, to[HDR_FLIP_L], to[HDR_FLIP_A], to[HDR_FLIP_B]);
}
HDR_VERSIONS(hdr_flip_down,
             (const hdr_flip_filters *filters, const hdr_flip_colours *colours, const hdr_flip_row *rows, bool coloured,
              hdr_flip_features *out),
             (filters, colours, rows, coloured, out))

/* ---- The difference ---- */

/* Of FLIP's section 4.1.4: what is below p_c of the largest distance is stretched over [0, p_t], p_t = 0.95. */
HDR_INLINE double redistributed(double distance, double knee, double largest) {
    double above = 0.95 + (distance - knee) / (largest - knee) * (1 - 0.95);
    return distance < knee ? 0.95 / knee * distance : above;
}

/* Of FLIP's sections 4.2 and 4.3: the feature difference to the power q_f = 0.5; colour to the power of 1 less that. */
HDR_INLINE void hdr_flip_raise_body(const hdr_flip_colours *colours, const hdr_flip_features *test,
                                    const hdr_flip_features *reference, double flip[HDR_FLIP_PIXELS]) {
    const double knee = colours->knee, largest = colours->largest;
    const hdr_flip_features *t = test, *r = reference;
    for (int i = 0; i < HDR_FLIP_PIXELS; i++) {
        double distance =
            distance_of((*t)[HDR_FLIP_L][i] - (*r)[HDR_FLIP_L][i], (*t)[HDR_FLIP_A][i] - (*r)[HDR_FLIP_A][i],
                        (*t)[HDR_FLIP_B][i] - (*r)[HDR_FLIP_B][i]);
        double edge = fabs((*t)[HDR_FLIP_EDGES][i] - (*r)[HDR_FLIP_EDGES][i]);
        double point = fabs((*t)[HDR_FLIP_POINTS][i] - (*r)[HDR_FLIP_POINTS][i]);
        double feature = clamped(sqrt((edge > point ? edge : point) * sqrt(0.5)));
        double value = hdr_pow(redistributed(distance, knee, largest), 1 - feature);
        flip[i] = value > flip[i] ? value : flip[i];
    }
}
HDR_VERSIONS(hdr_flip_raise,
             (const hdr_flip_colours *colours, const hdr_flip_features *test, const hdr_flip_features *reference,
              double flip[HDR_FLIP_PIXELS]),
             (colours, test, reference, flip))

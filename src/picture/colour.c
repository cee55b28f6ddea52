#include "picture/colour.h"

#include <math.h>
#include <string.h>

const hdr_chromaticities hdr_rec709 = {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}};
const hdr_chromaticities hdr_aces_ap0 = {{0.7347, 0.2653}, {0, 1}, {0.0001, -0.077}, {0.32168, 0.33767}};
const hdr_chromaticities hdr_aces_ap1 = {{0.713, 0.293}, {0.165, 0.83}, {0.128, 0.044}, {0.32168, 0.33767}};
const hdr_chromaticities hdr_p3_d65 = {{0.68, 0.32}, {0.265, 0.69}, {0.15, 0.06}, {0.3127, 0.3290}};
const hdr_chromaticities hdr_rec2020 = {{0.708, 0.292}, {0.17, 0.797}, {0.131, 0.046}, {0.3127, 0.3290}};
const hdr_chromaticities hdr_cie_xyz = {{1, 0}, {0, 1}, {0, 0}, {1 / 3.0, 1 / 3.0}};

bool hdr_chromaticities_differ(const hdr_chromaticities *a, const hdr_chromaticities *b) {
    const double *p[4] = {a->red, a->green, a->blue, a->white}, *q[4] = {b->red, b->green, b->blue, b->white};
    for (int i = 0; i < 8; i++)
        if (!(fabs(p[i / 2][i % 2] - q[i / 2][i % 2]) <= 1e-5)) return true;
    return false;
}

/* The colour of chromaticity x, y and luminance 1, in XYZ. */
static void xyz_of(const double xy[2], double xyz[3]) {
    xyz[0] = xy[0] / xy[1];
    xyz[1] = 1;
    xyz[2] = (1 - xy[0] - xy[1]) / xy[1];
}

static void multiply(const double a[9], const double b[9], double out[9]) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
}

static void apply(const double m[9], const double v[3], double out[3]) {
    for (int i = 0; i < 3; i++)
        out[i] = m[3 * i] * v[0] + m[3 * i + 1] * v[1] + m[3 * i + 2] * v[2];
}

/* By cofactors. */
static bool invert(const double m[9], double out[9]) {
    double c[9];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int a = (i + 1) % 3, b = (i + 2) % 3, d = (j + 1) % 3, e = (j + 2) % 3;
            c[3 * j + i] = m[3 * a + d] * m[3 * b + e] - m[3 * a + e] * m[3 * b + d];
        }
    double determinant = m[0] * c[0] + m[1] * c[3] + m[2] * c[6];
    if (!isfinite(determinant) || fabs(determinant) < 1e-12) return false;
    for (int i = 0; i < 9; i++)
        out[i] = c[i] / determinant;
    return true;
}

/* SMPTE RP 177-1993: the columns are the primaries' x y z, scaled so that (1,1,1) is white with Y = 1. */
static bool rgb_to_xyz(const hdr_chromaticities *p, double m[9]) {
    const double *primary[3] = {p->red, p->green, p->blue};
    double columns[9], inverse[9], white[3], scale[3];
    for (int i = 0; i < 3; i++) {
        columns[i] = primary[i][0];
        columns[3 + i] = primary[i][1];
        columns[6 + i] = 1 - primary[i][0] - primary[i][1];
    }
    if (!(fabs(p->white[1]) > 1e-6) || !invert(columns, inverse)) return false;
    xyz_of(p->white, white);
    apply(inverse, white, scale);
    for (int i = 0; i < 9; i++)
        m[i] = columns[i] * scale[i % 3];
    for (int i = 0; i < 9; i++)
        if (!isfinite(m[i])) return false;
    return true;
}

bool hdr_luminance_weights(const hdr_chromaticities *primaries, double weights[3]) {
    if (!hdr_chromaticities_differ(primaries, &hdr_rec709)) {
        memcpy(weights, (const double[3]){0.2126, 0.7152, 0.0722}, 3 * sizeof(double));
        return true;
    }
    double m[9];
    if (!rgb_to_xyz(primaries, m)) return false;
    memcpy(weights, m + 3, 3 * sizeof(double));
    return true;
}

/* Lam 1985, as in the ICC specification, annex E: cone responses of both whites, in Bradford's space. */
static bool bradford(const double from[2], const double to[2], double m[9]) {
    static const double cone[9] = {0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296};
    double source[3], target[3], a[3], b[3], scaled[9], inverse[9];
    if (!(fabs(from[1]) > 1e-6)) return false;
    xyz_of(from, source);
    xyz_of(to, target);
    apply(cone, source, a);
    apply(cone, target, b);
    for (int i = 0; i < 9; i++) {
        if (!(fabs(a[i / 3]) > 1e-9)) return false;
        scaled[i] = cone[i] * (b[i / 3] / a[i / 3]);
    }
    if (!invert(cone, inverse)) return false;
    multiply(inverse, scaled, m);
    return true;
}

bool hdr_primaries_are_xyz(const hdr_chromaticities *primaries) {
    hdr_chromaticities without_white = *primaries;
    memcpy(without_white.white, hdr_cie_xyz.white, sizeof hdr_cie_xyz.white);
    return !hdr_chromaticities_differ(&without_white, &hdr_cie_xyz);
}

bool hdr_matrix_to_rec709(const hdr_chromaticities *primaries, const double neutral[2], bool adapt, double m[9]) {
    double to_xyz[9], rec709[9], from_xyz[9], adaptation[9], adapted[9];
    if (!rgb_to_xyz(primaries, to_xyz) || !rgb_to_xyz(&hdr_rec709, rec709) || !invert(rec709, from_xyz)) return false;
    if (adapt && !hdr_primaries_are_xyz(primaries)) {
        if (!bradford(neutral, hdr_rec709.white, adaptation)) return false;
        multiply(adaptation, to_xyz, adapted);
    } else {
        memcpy(adapted, to_xyz, sizeof adapted);
    }
    multiply(from_xyz, adapted, m);
    return true;
}

bool hdr_matrix_to_xyz(const hdr_chromaticities *primaries, double m[9]) {
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (hdr_chromaticities_differ(primaries, &hdr_cie_xyz)) return rgb_to_xyz(primaries, m);
    memcpy(m, identity, sizeof identity);
    return true;
}

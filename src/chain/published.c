#include "chain/published.h"

#include <math.h>

static long double at_least_0(long double value) {
    return value > 0 ? value : 0;
}

/* ---- As published ---- */

long double hdr_published_gamma(long double c) {
    return powl(at_least_0(c), 1 / 2.2L);
}

long double hdr_published_gamma_back(long double v) {
    return powl(at_least_0(v), 2.2L);
}

/* IEC 61966-2-1:1999, 5.2 */
long double hdr_published_srgb(long double c) {
    return c <= 0.0031308L ? 12.92L * c : 1.055L * powl(c, 1 / 2.4L) - 0.055L;
}

long double hdr_published_srgb_back(long double v) {
    return v <= 0.04045L ? v / 12.92L : powl((v + 0.055L) / 1.055L, 2.4L);
}

/* ITU-R BT.709-6, item 1.2 */
long double hdr_published_rec709(long double c) {
    return c < 0.018L ? 4.5L * c : 1.099L * powl(c, 0.45L) - 0.099L;
}

long double hdr_published_rec709_back(long double v) {
    return v < 0.081L ? v / 4.5L : powl((v + 0.099L) / 1.099L, 1 / 0.45L);
}

/* SMPTE ST 2084:2014, 5 */
static const long double m1 = 0.1593017578125L, m2 = 78.84375L, c1 = 0.8359375L, c2 = 18.8515625L, c3 = 18.6875L;

long double hdr_published_pq(long double c) {
    long double y = powl(at_least_0(c) / 100, m1);
    return powl((c1 + c2 * y) / (1 + c3 * y), m2);
}

long double hdr_published_pq_back(long double v) {
    long double held = at_least_0(v) < 1 ? at_least_0(v) : 1, raised = powl(held, 1 / m2);
    return 100 * powl(at_least_0(raised - c1) / (c2 - c3 * raised), 1 / m1);
}

/* ITU-R BT.2100-2, table 5: a, b = 1 - 4 a, and c = 0.5 - a ln(4 a) to the last digit of a long double */
static const long double hlg_a = 0.17883277L, hlg_b = 0.28466892L, hlg_c = 0.5599107295295620201571L;

long double hdr_published_hlg(long double c) {
    long double e = at_least_0(c);
    return e <= 1 / 12.0L ? sqrtl(3 * e) : hlg_a * logl(12 * e - hlg_b) + hlg_c;
}

long double hdr_published_hlg_back(long double v) {
    long double e = at_least_0(v);
    return e <= 0.5L ? e * e / 3 : (expl((e - hlg_c) / hlg_a) + hlg_b) / 12;
}

/* ---- As OpenColorIO has them ---- */

/* Exponents are kept in float32. */
long double hdr_ocio_gamma(long double c) {
    return powl(at_least_0(c), (long double)(float)(1 / 2.2));
}

long double hdr_ocio_gamma_back(long double v) {
    return powl(at_least_0(v), (long double)2.2f);
}

/* ExponentWithLinear puts the line where it is a tangent of the power, so that the break and the slope are those that
 * the exponent and the offset make, and not those that a standard prints. All its parameters are kept in float32. */
static long double tangent(double exponent, double offset, long double c) {
    double share = offset / (exponent - 1), joint = pow(share * exponent / (1 + offset), exponent);
    double slope = share / joint;
    float least = (float)joint;
    if (c <= (long double)least) return (long double)(float)slope * c;
    return (long double)(float)(1 + offset) * powl(c, (long double)(float)(1 / exponent)) - (long double)(float)offset;
}

static long double tangent_back(double exponent, double offset, long double v) {
    double share = offset / (exponent - 1), joint = pow(share * exponent / (1 + offset), exponent);
    double slope = joint / share;
    if (v <= (long double)(float)share) return (long double)(float)slope * v;
    return powl((long double)(float)(1 / (1 + offset)) * v + (long double)(float)(offset / (1 + offset)),
                (long double)(float)exponent);
}

long double hdr_ocio_srgb(long double c) {
    return tangent(2.4, 0.055, c);
}

long double hdr_ocio_srgb_back(long double v) {
    return tangent_back(2.4, 0.055, v);
}

long double hdr_ocio_rec709(long double c) {
    return tangent(1 / 0.45, 0.099, c);
}

long double hdr_ocio_rec709_back(long double v) {
    return tangent_back(1 / 0.45, 0.099, v);
}

/* A table of numbers rounded to float32, and straight lines between them. */
static long double between(long double low, long double high, long double share) {
    long double from = (long double)(float)low, to = (long double)(float)high;
    return from + (to - from) * share;
}

/* A table of all halves. */
long double hdr_ocio_pq(long double c) {
    int exponent;
    frexpl(at_least_0(c), &exponent);
    long double step = ldexpl(1, (exponent > -13 ? exponent : -13) - 11), low = floorl(at_least_0(c) / step) * step;
    return between(hdr_published_pq(low), hdr_published_pq(low + step), (at_least_0(c) - low) / step);
}

/* A table of 4096 numbers from 0 to 1. */
long double hdr_ocio_pq_back(long double v) {
    long double held = at_least_0(v) < 1 ? at_least_0(v) : 1, place = held * 4095, low = floorl(place);
    return between(hdr_published_pq_back(low / 4095), hdr_published_pq_back((low + 1) / 4095), place - low);
}

/* After ImfRgbaYca.cpp of OpenEXR 3.1 (BSD-3-Clause), whose results these are: the order of the operations, and where
 * they are rounded to half, is its own. */
#include "kernel/chroma.h"

#include "base/cpu.h"

#include <string.h>

/* Bits of a float without its sign, as a signed number: comparisons of those are what SSE2 has. */
enum {
    FLOAT_SIGN = INT32_MIN,
    FLOAT_INFINITY = 0x7f800000,
    FLOAT_NAN = 0x7fc00000,
    FLOAT_HALF = 0x3f000000,          /* of 1/2 */
    FLOAT_LARGEST_HALF = 0x477fe000,  /* of 65504 */
    FLOAT_SMALLEST_HALF = 0x38800000, /* of 2^-14, the smallest normal half */
    HALF_INFINITY = 0x7c00,
    HALF_NAN = 0x7e00,
    BIAS = 127 - 15 /* of float's exponents over half's */
};

static inline int32_t bits_of(float value) {
    int32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static inline float float_of(int32_t bits) {
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* ---- Halves held as floats ---- */

/* To nearest, ties to even. A normal half has 10 of float's 23 bits of fraction. A subnormal one is a multiple of
 * 2^-24, which is the distance of floats in [1/2, 1): the sum with 1/2 rounds as it should, and the difference is
 * exact. */
HDR_INLINE float nearest_half(float value) {
    int32_t bits = bits_of(value), size = bits & INT32_MAX;
    int32_t normal = (int32_t)((uint32_t)size + 0xfff + (((uint32_t)size >> 13) & 1)) & ~0x1fff;
    normal = normal > FLOAT_LARGEST_HALF ? FLOAT_INFINITY : normal;
    normal = size > FLOAT_INFINITY ? FLOAT_NAN : normal;
    int32_t subnormal = bits_of((float_of(size) + 0.5f) - 0.5f);
    return float_of((size < FLOAT_SMALLEST_HALF ? subnormal : normal) | (bits & FLOAT_SIGN));
}

HDR_INLINE void hdr_half_to_float_body(const uint16_t *half, float *out, size_t count) {
    for (size_t i = 0; i < count; i++) {
        int32_t size = half[i] & 0x7fff;
        int32_t normal = (size << 13) + (BIAS << 23);
        normal += size >= HALF_INFINITY ? BIAS << 23 : 0;
        int32_t subnormal = bits_of((float)size * 0x1p-24f);
        int32_t sign = half[i] & 0x8000 ? FLOAT_SIGN : 0;
        out[i] = float_of((size < 0x400 ? subnormal : normal) | sign);
    }
}
HDR_VERSIONS(hdr_half_to_float, (const uint16_t *half, float *out, size_t count), (half, out, count))

HDR_INLINE void hdr_float_to_half_grid_body(const float *in, float *out, size_t count) {
    for (size_t i = 0; i < count; i++)
        out[i] = in[i] > 65504    ? float_of(FLOAT_INFINITY)
                 : in[i] < -65504 ? float_of(FLOAT_INFINITY | FLOAT_SIGN)
                                  : nearest_half(in[i]);
}
HDR_VERSIONS(hdr_float_to_half_grid, (const float *in, float *out, size_t count), (in, out, count))

HDR_INLINE uint16_t half_of(float value) {
    int32_t bits = bits_of(value), size = bits & INT32_MAX;
    int32_t half = (size >> 13) - (BIAS << 10);
    half = size >= FLOAT_INFINITY ? HALF_INFINITY : half;
    half = size > FLOAT_INFINITY ? HALF_NAN : half;
    int32_t subnormal = bits_of(float_of(size) + 0.5f) - FLOAT_HALF;
    half = size < FLOAT_SMALLEST_HALF ? subnormal : half;
    return (uint16_t)(half | (bits < 0 ? 0x8000 : 0));
}

HDR_INLINE void hdr_half_grid_to_half_body(const float *in, uint16_t *out, size_t count) {
    for (size_t i = 0; i < count; i++)
        out[i] = half_of(in[i]);
}
HDR_VERSIONS(hdr_half_grid_to_half, (const float *in, uint16_t *out, size_t count), (in, out, count))

/* ---- The missing samples ---- */

/* One phase of OpenEXR's 27-tap reconstruction filter; the other taps are 0, and 1 in the middle. Symmetric. */
static const float filter[HDR_CHROMA_TAPS] = {0.002128f,  -0.007540f, 0.019597f,  -0.043159f, 0.087929f,
                                              -0.186077f, 0.627123f,  0.627123f,  -0.186077f, 0.087929f,
                                              -0.043159f, 0.019597f,  -0.007540f, 0.002128f};

HDR_INLINE void hdr_chroma_across_body(const float *samples, float *out, size_t count) {
    for (size_t i = 0; i < count; i++) {
        const float *from = samples + i - HDR_CHROMA_BEFORE;
        float sum = from[0] * filter[0];
        for (int t = 1; t < HDR_CHROMA_TAPS; t++)
            sum = sum + from[t] * filter[t];
        out[2 * i] = samples[i];
        out[2 * i + 1] = nearest_half(sum);
    }
}
HDR_VERSIONS(hdr_chroma_across, (const float *samples, float *out, size_t count), (samples, out, count))

HDR_INLINE void hdr_chroma_down_body(const float *const row[HDR_CHROMA_TAPS], float *out, size_t count) {
    for (size_t i = 0; i < count; i++) {
        float sum = row[0][i] * filter[0];
        for (int t = 1; t < HDR_CHROMA_TAPS; t++)
            sum = sum + row[t][i] * filter[t];
        out[i] = nearest_half(sum);
    }
}
HDR_VERSIONS(hdr_chroma_down, (const float *const row[HDR_CHROMA_TAPS], float *out, size_t count), (row, out, count))

/* ---- Colour ---- */

/* R = (RY + 1) Y, B = (BY + 1) Y, G = (Y - w[0] R - w[2] B) / w[1]; grey exactly where there is no chroma. */
HDR_INLINE void hdr_chroma_to_rgb_body(const float *y, const float *ry, const float *by, const float w[3],
                                       float *const rgb[3], size_t count) {
    float *red = rgb[0], *green = rgb[1], *blue = rgb[2];
    float wr = w[0], wg = w[1], wb = w[2];
    for (size_t i = 0; i < count; i++) {
        float r = (ry[i] + 1) * y[i];
        float b = (by[i] + 1) * y[i];
        float g = (y[i] - r * wr - b * wb) / wg;
        int grey = (ry[i] == 0) & (by[i] == 0);
        red[i] = grey ? y[i] : nearest_half(r);
        green[i] = grey ? y[i] : nearest_half(g);
        blue[i] = grey ? y[i] : nearest_half(b);
    }
}
HDR_VERSIONS(hdr_chroma_to_rgb,
             (const float *y, const float *ry, const float *by, const float w[3], float *const rgb[3], size_t count),
             (y, ry, by, w, rgb, count))

/* NaN: as std::max and std::min of the C++ library, which keep the first where the comparison fails. */
HDR_INLINE float larger(float a, float b) {
    return a < b ? b : a;
}

HDR_INLINE float smaller(float a, float b) {
    return b < a ? b : a;
}

HDR_INLINE void hdr_rgb_saturation_body(const float *const rgb[3], float *out, size_t count) {
    const float *red = rgb[0], *green = rgb[1], *blue = rgb[2];
    for (size_t i = 0; i < count; i++) {
        float most = larger(red[i], larger(green[i], blue[i]));
        float least = smaller(red[i], smaller(green[i], blue[i]));
        float saturation = 1 - least / most;
        out[i] = most > 0 ? saturation : 0;
    }
}
HDR_VERSIONS(hdr_rgb_saturation, (const float *const rgb[3], float *out, size_t count), (rgb, out, count))

/* The saturation that a pixel may have: the mean of its neighbours', and three quarters of the way from there to 1. */
HDR_INLINE float saturation_limit(const float *above, const float *below, size_t i) {
    float mean = smaller(1.0f, 0.25f * (above[i - 1] + above[i + 1] + below[i - 1] + below[i + 1]));
    return smaller(1.0f, 1 - (1 - mean) * 0.25f);
}

/* Moves the components towards the largest until they are factor as far from it, and keeps the pixel's luminance. */
static void desaturate(const float in[3], float factor, const float w[3], float out[3]) {
    float most = larger(in[0], larger(in[1], in[2]));
    for (int c = 0; c < 3; c++)
        out[c] = nearest_half(larger(most - (most - in[c]) * factor, 0.0f));
    float y_in = in[0] * w[0] + in[1] * w[1] + in[2] * w[2];
    float y_out = out[0] * w[0] + out[1] * w[1] + out[2] * w[2];
    for (int c = 0; c < 3 && y_out > 0; c++)
        out[c] = nearest_half(out[c] * (y_in / y_out));
}

enum { PIECE = 512 };

HDR_INLINE void hdr_fix_saturation_body(const float *const rgb[3], const float *above, const float *at,
                                        const float *below, const float w[3], uint16_t *const out[3], size_t count) {
    for (size_t start = 0; start < count; start += PIECE) {
        size_t end = count - start < PIECE ? count : start + PIECE;
        int32_t over = 0;
        for (size_t i = start; i < end; i++)
            over |= at[i] > saturation_limit(above, below, i);
        for (int c = 0; c < 3; c++)
            for (size_t i = start; i < end; i++)
                out[c][i] = half_of(rgb[c][i]);
        for (size_t i = start; over && i < end; i++) {
            float limit = saturation_limit(above, below, i), pixel[3];
            if (!(at[i] > limit)) continue;
            desaturate((const float[3]){rgb[0][i], rgb[1][i], rgb[2][i]}, limit / at[i], w, pixel);
            for (int c = 0; c < 3; c++)
                out[c][i] = half_of(pixel[c]);
        }
    }
}
HDR_VERSIONS(hdr_fix_saturation,
             (const float *const rgb[3], const float *above, const float *at, const float *below, const float w[3],
              uint16_t *const out[3], size_t count),
             (rgb, above, at, below, w, out, count))

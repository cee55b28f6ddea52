#include "kernel/grid.h"

#include "base/cpu.h"

#include <math.h>

/* Four levels of pairs. */
typedef float levels __attribute__((vector_size(32), aligned(4), may_alias));

/* Weights of the cubic B-spline, t from the second node towards the third. */
HDR_INLINE void spline_weights(double t, float weight[4]) {
    double u = 1 - t;
    weight[0] = (float)(u * u * u / 6);
    weight[1] = (float)((4 - 6 * t * t + 3 * t * t * t) / 6);
    weight[2] = (float)((4 - 6 * u * u + 3 * u * u * u) / 6);
    weight[3] = (float)(t * t * t / 6);
}

hdr_spline hdr_spline_at(double place) {
    hdr_spline spline = {.first = (int)floor(place)};
    spline_weights(place - spline.first, spline.weight);
    return spline;
}

HDR_INLINE void hdr_splines_of_body(const float *numbers, double low, double step, hdr_spline *out, size_t count) {
    for (size_t i = 0; i < count; i++) {
        double place = ((double)numbers[i] - low) / step;
        int first = (int)place;
        out[i].first = first;
        spline_weights(place - first, out[i].weight);
    }
}
HDR_VERSIONS(hdr_splines_of, (const float *numbers, double low, double step, hdr_spline *out, size_t count),
             (numbers, low, step, out, count))

HDR_INLINE void hdr_grid_sow_body(const float *numbers, float middle, const hdr_spline *across, const hdr_spline *deep,
                                  const int *stored, size_t count, float *slab, size_t stride) {
    for (size_t i = 0; i < count; i++) {
        const float *w = deep[i].weight, d = numbers[i] - middle;
        levels pairs = {w[0], w[0] * d, w[1], w[1] * d, w[2], w[2] * d, w[3], w[3] * d};
        float *column = slab + (size_t)across[i].first * stride + 2 * (size_t)stored[deep[i].first];
        for (int k = 0; k < 4; k++, column += stride)
            *(levels *)(void *)column += across[i].weight[k] * pairs;
    }
}
HDR_VERSIONS(hdr_grid_sow,
             (const float *numbers, float middle, const hdr_spline *across, const hdr_spline *deep, const int *stored,
              size_t count, float *slab, size_t stride),
             (numbers, middle, across, deep, stored, count, slab, stride))

HDR_INLINE void hdr_grid_read_body(float middle, const hdr_spline *across, const hdr_spline *deep, const int *stored,
                                   size_t count, const float *slab, size_t stride, float *out) {
    for (size_t i = 0; i < count; i++) {
        const float *column = slab + (size_t)across[i].first * stride + 2 * (size_t)stored[deep[i].first];
        const float *w = deep[i].weight;
        levels sum = across[i].weight[0] * *(const levels *)(const void *)column;
        for (int k = 1; k < 4; k++)
            sum += across[i].weight[k] * *(const levels *)(const void *)(column + (size_t)k * stride);
        float weight = (w[0] * sum[0] + w[1] * sum[2]) + (w[2] * sum[4] + w[3] * sum[6]);
        float number = (w[0] * sum[1] + w[1] * sum[3]) + (w[2] * sum[5] + w[3] * sum[7]);
        out[i] = middle + number / weight;
    }
}
HDR_VERSIONS(hdr_grid_read,
             (float middle, const hdr_spline *across, const hdr_spline *deep, const int *stored, size_t count,
              const float *slab, size_t stride, float *out),
             (middle, across, deep, stored, count, slab, stride, out))

HDR_INLINE void hdr_grid_gather_body(const float *const row[4], const float weight[4], float *out, size_t count) {
    const float *a = row[0], *b = row[1], *c = row[2], *d = row[3];
    for (size_t i = 0; i < count; i++)
        out[i] = (weight[0] * a[i] + weight[1] * b[i]) + (weight[2] * c[i] + weight[3] * d[i]);
}
HDR_VERSIONS(hdr_grid_gather, (const float *const row[4], const float weight[4], float *out, size_t count),
             (row, weight, out, count))

HDR_INLINE void hdr_grid_spread_body(const float *in, const float weight[4], float *const row[4], size_t count) {
    float *restrict a = row[0], *restrict b = row[1], *restrict c = row[2], *restrict d = row[3];
    for (size_t i = 0; i < count; i++) {
        a[i] += weight[0] * in[i];
        b[i] += weight[1] * in[i];
        c[i] += weight[2] * in[i];
        d[i] += weight[3] * in[i];
    }
}
HDR_VERSIONS(hdr_grid_spread, (const float *in, const float weight[4], float *const row[4], size_t count),
             (in, weight, row, count))

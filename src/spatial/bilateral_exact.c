#include "spatial/bilateral.h"

#include "base/cpu.h"
#include "kernel/real.h"

#include <math.h>
#include <stdlib.h>

enum { SUMS = 16 };

/* Adds sum of f g and of f g (i - centre) over a row; number n goes to sum n mod 16. factor is -1 / (2 sigma_r^2). */
HDR_INLINE void add_row_body(const double *numbers, const double *weight, size_t count, double centre, double factor,
                             double row_weight, double *sum) {
    size_t whole = count / SUMS * SUMS;
    for (size_t i = 0; i < whole; i += SUMS)
        for (size_t l = 0; l < SUMS; l++) {
            double difference = numbers[i + l] - centre;
            double w = row_weight * weight[i + l] * hdr_exp(difference * difference * factor);
            sum[l] += w;
            sum[SUMS + l] += w * difference;
        }
    for (size_t i = whole; i < count; i++) {
        double difference = numbers[i] - centre;
        double w = row_weight * weight[i] * hdr_exp(difference * difference * factor);
        sum[i - whole] += w;
        sum[SUMS + i - whole] += w * difference;
    }
}
HDR_VERSIONS_IN(static, add_row,
                (const double *numbers, const double *weight, size_t count, double centre, double factor,
                 double row_weight, double *sum),
                (numbers, weight, count, centre, factor, row_weight, sum))

typedef struct exact {
    const hdr_bilateral *filter;
    int width, height, reach;
    double *weight;          /* of -reach ... reach */
    double *numbers;         /* the plane in double, without gaps */
    hdr_plane *base;         /* either this */
    const hdr_pixel *pixels; /* or these */
    double *values;
} exact;

static double sum_of(const double *sums) {
    double sum[SUMS];
    for (size_t l = 0; l < SUMS; l++)
        sum[l] = sums[l];
    for (size_t half = SUMS / 2; half > 0; half /= 2)
        for (size_t l = 0; l < half; l++)
            sum[l] += sum[l + half];
    return sum[0];
}

static double exact_at(const exact *e, int x, int y) {
    double sum[2 * SUMS] = {0}, factor = -0.5 / (e->filter->sigma_r * e->filter->sigma_r);
    double centre = e->numbers[(size_t)y * (size_t)e->width + (size_t)x];
    int left = x > e->reach ? x - e->reach : 0, top = y > e->reach ? y - e->reach : 0;
    int right = e->width - 1 - x > e->reach ? x + e->reach : e->width - 1;
    int bottom = e->height - 1 - y > e->reach ? y + e->reach : e->height - 1;
    for (int row = top; row <= bottom; row++)
        add_row(e->numbers + (size_t)row * (size_t)e->width + (size_t)left, e->weight + e->reach + (left - x),
                (size_t)(right - left + 1), centre, factor, e->weight[e->reach + (row - y)], sum);
    return centre + sum_of(sum + SUMS) / sum_of(sum);
}

static hdr_status exact_row(void *context, int y, int thread, hdr_error *err) {
    (void)thread, (void)err;
    const exact *e = context;
    const unsigned char *wanted = e->filter->wanted;
    if (wanted) wanted += (size_t)y * hdr_mask_row(e->width);
    for (int x = 0; x < e->width; x++) {
        if (wanted && !hdr_mask_has(wanted, x)) continue;
        double value = exact_at(e, x, y);
        size_t at = (size_t)y * e->base->stride + (size_t)x;
        if (e->base->wide)
            e->base->wide[at] = value;
        else
            e->base->narrow[at] = (float)value;
    }
    return HDR_OK;
}

static hdr_status exact_pixel(void *context, int i, int thread, hdr_error *err) {
    (void)thread, (void)err;
    const exact *e = context;
    e->values[i] = exact_at(e, e->pixels[i].x, e->pixels[i].y);
    return HDR_OK;
}

static hdr_status begin(exact *e, const hdr_bilateral *filter, double reach, const hdr_plane *plane, hdr_error *err) {
    int larger = plane->width > plane->height ? plane->width : plane->height;
    double wanted = ceil(reach * filter->sigma_s);
    *e = (exact){.filter = filter, .width = plane->width, .height = plane->height};
    e->reach = wanted < larger ? (int)wanted : larger;
    e->weight = hdr_alloc(2 * (size_t)e->reach + 1, sizeof *e->weight);
    e->numbers = hdr_alloc((size_t)plane->width * (size_t)plane->height, sizeof *e->numbers);
    if (!e->weight || !e->numbers) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (int k = -e->reach; k <= e->reach; k++) {
        double z = k / filter->sigma_s;
        e->weight[e->reach + k] = hdr_exp(-0.5 * z * z);
    }
    for (int y = 0; y < plane->height; y++)
        for (int x = 0; x < plane->width; x++) {
            size_t at = (size_t)y * plane->stride + (size_t)x;
            e->numbers[(size_t)y * (size_t)plane->width + (size_t)x] =
                plane->wide ? plane->wide[at] : (double)plane->narrow[at];
        }
    return HDR_OK;
}

static void end(exact *e) {
    free(e->weight);
    free(e->numbers);
}

hdr_status hdr_bilateral_exact(const hdr_bilateral *filter, double reach, const hdr_plane *plane, hdr_plane *base,
                               hdr_pool *pool, hdr_error *err) {
    exact e;
    hdr_status status = begin(&e, filter, reach, plane, err);
    e.base = base;
    if (status == HDR_OK) status = hdr_pool_run(pool, plane->height, exact_row, &e, err);
    end(&e);
    return status;
}

hdr_status hdr_bilateral_exact_at(const hdr_bilateral *filter, double reach, const hdr_plane *plane, int count,
                                  const hdr_pixel *pixels, double *values, hdr_pool *pool, hdr_error *err) {
    exact e;
    hdr_status status = begin(&e, filter, reach, plane, err);
    e.pixels = pixels;
    e.values = values;
    if (status == HDR_OK) status = hdr_pool_run(pool, count, exact_pixel, &e, err);
    end(&e);
    return status;
}

#include "spatial/scales_wide.h"

#include "spatial/gaussian.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

enum { GAUSSIANS = HDR_SCALES + 1 };

typedef struct search {
    const hdr_scales *scales;
    const hdr_plane *in;
    hdr_plane *out;
    unsigned char *choice;
    int reach[GAUSSIANS];
    double *weight[GAUSSIANS];
    double *rows; /* of each thread: a row that is convolved down only, V_i and V_(i+1) */
    unsigned char *marks;
    atomic_ullong chosen[HDR_SCALES];
} search;

int hdr_scales_full_reach(double sigma, double ratio) {
    return hdr_gaussian_reach(sigma, 8, 1e-17 / (ratio > 1 ? ratio : 1));
}

/* One row of V_i. The far weights come first, the smallest. */
static void convolve(const search *s, int i, int y, double *down, double *v) {
    const hdr_plane *in = s->in;
    const double *weight = s->weight[i];
    memset(down, 0, (size_t)in->width * sizeof *down);
    for (int k = s->reach[i]; k >= 0; k--) {
        const double *above = in->wide + (size_t)hdr_mirrored((int64_t)y - k, in->height) * in->stride;
        const double *below = in->wide + (size_t)hdr_mirrored((int64_t)y + k, in->height) * in->stride;
        for (int x = 0; x < in->width; x++)
            down[x] += k ? weight[k] * (above[x] + below[x]) : weight[0] * above[x];
    }
    for (int x = 0; x < in->width; x++) {
        double sum = 0;
        for (int k = s->reach[i]; k > 0; k--)
            sum += weight[k] *
                   (down[hdr_mirrored((int64_t)x - k, in->width)] + down[hdr_mirrored((int64_t)x + k, in->width)]);
        v[x] = sum + weight[0] * down[x];
    }
}

static hdr_status search_row(void *context, int y, int thread, hdr_error *err) {
    (void)err;
    search *s = context;
    const hdr_scales *scales = s->scales;
    size_t width = (size_t)s->in->width;
    double *down = s->rows + 3 * width * (size_t)thread, *v = down + width, *next = v + width;
    double *out = s->out->wide + (size_t)y * s->out->stride;
    unsigned char *marks = s->marks + width * (size_t)thread;
    memset(marks, HDR_OPEN, width);
    convolve(s, 0, y, down, v);
    for (int i = 0; i < HDR_SCALES; i++) {
        convolve(s, i + 1, y, down, next);
        uint64_t closed = 0;
        for (size_t x = 0; x < width; x++) {
            bool uneven = fabs(v[x] - next[x]) > scales->epsilon * (scales->offset[i] + v[x]);
            if (marks[x] != HDR_OPEN || !(uneven || i == HDR_SCALES - 1)) continue;
            marks[x] = (unsigned char)i;
            out[x] = v[x];
            closed++;
        }
        atomic_fetch_add(&s->chosen[i], closed);
        double *swapped = v;
        v = next;
        next = swapped;
    }
    if (s->choice) memcpy(s->choice + width * (size_t)y, marks, width);
    return HDR_OK;
}

static double largest_of(const hdr_plane *plane) {
    double largest = 0;
    for (int y = 0; y < plane->height; y++)
        for (int x = 0; x < plane->width; x++)
            largest = fmax(largest, plane->wide[(size_t)y * plane->stride + (size_t)x]);
    return largest;
}

hdr_status hdr_scales_surround_wide(const hdr_scales *scales, const hdr_plane *plane, hdr_plane *surround,
                                    unsigned char *choice, hdr_pool *pool, hdr_scales_report *report, hdr_error *err) {
    search s = {.scales = scales, .in = plane, .out = surround, .choice = choice};
    size_t threads = (size_t)hdr_pool_threads(pool), width = (size_t)plane->width;
    double ratio = largest_of(plane) / scales->unit;
    s.rows = hdr_alloc(3 * threads, width * sizeof *s.rows);
    s.marks = hdr_alloc(threads, width);
    bool made = s.rows && s.marks;
    for (int i = 0; i < GAUSSIANS && made; i++) {
        s.reach[i] = hdr_scales_full_reach(scales->sigma[i], ratio);
        s.weight[i] = hdr_alloc((size_t)s.reach[i] + 1, sizeof *s.weight[i]);
        made = s.weight[i] != NULL;
        if (made) hdr_gaussian(scales->sigma[i], s.reach[i], s.weight[i]);
    }
    hdr_status status = made ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
    if (status == HDR_OK) status = hdr_pool_run(pool, plane->height, search_row, &s, err);
    *report = (hdr_scales_report){.settled = 0};
    for (int i = 0; i < GAUSSIANS; i++) {
        report->blurred[i] = (uint64_t)plane->width * (uint64_t)plane->height;
        report->reach[i] = s.reach[i];
        if (i < HDR_SCALES) report->chosen[i] = s.chosen[i];
        free(s.weight[i]);
    }
    free(s.rows);
    free(s.marks);
    return status;
}

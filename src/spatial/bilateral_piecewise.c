/* PiecewiseBilateral with its subsampling, FastBilateral: Durand and Dorsey 2002, section 5.
 *
 *     NB_SEGMENTS = range / sigma_r;  i_j = min + j range / NB_SEGMENTS, j = 0 ... NB_SEGMENTS
 *     G_j = g(I - i_j);  K_j = G_j (*) f;  H_j = (G_j I) (*) f;  J_j = H_j / K_j
 *     J(s) = linear interpolation between the J_j(s) of the two i_j around I(s)
 *
 * all but the last on a picture of every n-th pixel. What the paper leaves open, and what is done here:
 *   - range / sigma_r is rounded upwards, so that no segment is longer than sigma_r; what is above an integer by less
 *     than a thousandth is rounding of the logarithms, and counts as the integer.
 *   - Pixels are sampled where the least is left over at either side: as much on the left as on the right, or one less.
 *   - J_j is upsampled bilinearly; outside the outermost samples it stays what it is there.
 *   - f is a sum over pixels as far as it matters, and cut by the border, as the bilateral filter's window is, so that
 *     H_j and K_j lose the same. The paper takes a Fourier transform; after subsampling f is a few pixels wide.
 *   - Where no sample within f's reach is within 13 sigma_r of i_j, H_j / K_j is 0 / 0, and J_j is i_j: a pixel whose
 *     intensity is that is by itself.
 * J_j - i_j is what is convolved, stored and interpolated instead of J_j: the interpolation of the i_j themselves is I,
 * so what is constant, or stands by itself, comes out as it went in. */
#include "spatial/bilateral.h"

#include "base/cpu.h"
#include "kernel/real.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BAND = 16 };

/* f's reach in standard deviations: far enough for all that it cuts to weigh nothing beside a single pixel. */
#define REACH_DEVIATIONS 6.5

/* Weights are scaled up so that those of the far end of f and g, e^-84.5 = 2^-121.9 of g, 2^-40 of f in x and in y, are
 * still normal floats, while the sum over 2^31 pixels is none too large. Below these they are 0: denormal numbers are
 * slow, and wrong. */
#define SCALE 0x1p80
#define LEAST_OF_G (-84.5) /* the exponent: 13 sigma_r */
#define LEAST_OF_F 0x1p-40

typedef struct worker {
    float *weights, *sums;   /* a row of G_j and of G_j (I - i_j), with zeros around it */
    const float **row;       /* rows around a band, for the convolution */
    float *left, *right;     /* rows of J_j - i_j and of J_(j+1) - i_(j+1), at the height of a row of the picture */
    unsigned char *occupied; /* of each segment: whether some pixel is in it */
} worker;

typedef struct piecewise {
    const hdr_bilateral *filter;
    const hdr_plane *in;
    hdr_plane *out;
    int segments;
    double inverse;    /* segments / range */
    int node;          /* j, of what is computed at present */
    int step;          /* every step-th pixel */
    int left, top;     /* the first of them */
    hdr_plane sampled; /* I of these */
    float *samples;    /* where they are stored; NULL: they are all of `in` */
    int reach;         /* of f, among samples */
    float *f;          /* its weights */
    float *across;     /* G_j and G_j (I - i_j), convolved along rows: the one behind the other in each row */
    float *zeros;      /* a row of these */
    float *offset[2];  /* J_j - i_j, j even and odd */
    int *cell;         /* of each x: the sample at its left, */
    float *share;      /* and how far it is from that to the next */
    int pieces;        /* of a row of the picture */
    uint64_t *members; /* of each piece: bit j mod 64 is 1 if it has a pixel in segment j */
    worker *workers;
    int threads;
} piecewise;

/* ---- Segments ---- */

static double node_of(const piecewise *p, int j) {
    return p->filter->low + (p->inverse > 0 ? j / p->inverse : 0);
}

HDR_INLINE double place_of(float number, double low, double inverse) {
    return ((double)number - low) * inverse;
}

/* The segment between two nodes that a number is in; the largest is in the last. */
static int segment_of(const piecewise *p, float number) {
    int segment = (int)place_of(number, p->filter->low, p->inverse);
    return segment < p->segments ? segment : p->segments - 1;
}

static int band_end(const hdr_plane *plane, int band) {
    return plane->height - band * BAND < BAND ? plane->height : (band + 1) * BAND;
}

static hdr_status see_segments(void *context, int band, int thread, hdr_error *err) {
    (void)err;
    const piecewise *p = context;
    unsigned char *occupied = p->workers[thread].occupied;
    for (int y = band * BAND; y < band_end(p->in, band); y++) {
        const float *numbers = p->in->narrow + (size_t)y * p->in->stride;
        uint64_t *members = p->members + (size_t)y * (size_t)p->pieces;
        for (int x = 0; x < p->in->width; x++) {
            int segment = segment_of(p, numbers[x]);
            occupied[segment] = 1;
            members[x / HDR_PIECE] |= (uint64_t)1 << segment % 64;
        }
    }
    return HDR_OK;
}

static bool is_occupied(const piecewise *p, int segment) {
    bool occupied = p->filter->no_skip;
    for (int t = 0; t < p->threads && !occupied; t++)
        occupied = p->workers[t].occupied[segment];
    return occupied;
}

/* ---- J_j ---- */

/* G_j and G_j (I - i_j) of a row. factor is -1 / (2 sigma_r^2). */
HDR_INLINE void weigh_row_body(const float *numbers, double node, double factor, size_t count, float *weights,
                               float *sums) {
    for (size_t i = 0; i < count; i++) {
        double difference = (double)numbers[i] - node;
        double exponent = difference * difference * factor;
        double weight = exponent >= LEAST_OF_G ? SCALE * hdr_exp(exponent) : 0;
        weights[i] = (float)weight;
        sums[i] = (float)(weight * difference);
    }
}
HDR_VERSIONS_IN(static, weigh_row,
                (const float *numbers, double node, double factor, size_t count, float *weights, float *sums),
                (numbers, node, factor, count, weights, sums))

static hdr_status convolve_across(void *context, int band, int thread, hdr_error *err) {
    (void)err;
    const piecewise *p = context;
    const worker *w = &p->workers[thread];
    const hdr_plane *sampled = &p->sampled;
    double node = node_of(p, p->node), factor = -0.5 / (p->filter->sigma_r * p->filter->sigma_r);
    for (int y = band * BAND; y < band_end(sampled, band); y++) {
        float *across = p->across + 2 * (size_t)y * sampled->stride;
        weigh_row(sampled->narrow + (size_t)y * sampled->stride, node, factor, (size_t)sampled->width,
                  w->weights + p->reach, w->sums + p->reach);
        hdr_convolve_across(w->weights + p->reach, p->f, p->reach, across, sampled->stride);
        hdr_convolve_across(w->sums + p->reach, p->f, p->reach, across + sampled->stride, sampled->stride);
    }
    return HDR_OK;
}

/* J_j - i_j, from H_j - i_j K_j and K_j. */
HDR_INLINE void divide_piece_body(const float *sums, const float *weights, float *out) {
    for (int i = 0; i < HDR_PIECE; i++)
        out[i] = weights[i] > 0 ? sums[i] / weights[i] : 0;
}
HDR_VERSIONS_IN(static, divide_piece, (const float *sums, const float *weights, float *out), (sums, weights, out))

/* Column by column of pieces, so that the rows around the band stay in the cache. */
static hdr_status convolve_down(void *context, int band, int thread, hdr_error *err) {
    (void)err;
    const piecewise *p = context;
    const worker *w = &p->workers[thread];
    const hdr_plane *sampled = &p->sampled;
    int first = band * BAND, rows = band_end(sampled, band) - first;
    for (int k = -p->reach; k < rows + p->reach; k++) {
        int y = first + k;
        bool inside = y >= 0 && y < sampled->height;
        w->row[p->reach + k] = inside ? p->across + 2 * (size_t)y * sampled->stride : p->zeros;
    }
    for (size_t x = 0; x < (size_t)sampled->width; x += HDR_PIECE)
        for (int row = 0; row < rows; row++) {
            float weights[HDR_PIECE], sums[HDR_PIECE];
            hdr_convolve_down(w->row + p->reach + row, x, p->f, p->reach, weights);
            hdr_convolve_down(w->row + p->reach + row, sampled->stride + x, p->f, p->reach, sums);
            divide_piece(sums, weights, p->offset[p->node % 2] + (size_t)(first + row) * sampled->stride + x);
        }
    return HDR_OK;
}

/* ---- Interpolation ---- */

/* The sample at or before a pixel that is `distance` pixels behind the first sample, so that there is one behind it if
 * there is any; and how far it is from that to the next. */
static int cell_of(const piecewise *p, int distance, int samples, float *share) {
    double place = (double)distance / p->step;
    if (place < 0) place = 0;
    if (place > samples - 1) place = samples - 1;
    int cell = (int)place;
    if (cell > samples - 2) cell = samples > 1 ? samples - 2 : 0;
    *share = (float)(place - cell);
    return cell;
}

HDR_INLINE void mix_rows_body(const float *above, const float *below, float share, size_t count, float *out) {
    for (size_t i = 0; i < count; i++)
        out[i] = (1 - share) * above[i] + share * below[i];
}
HDR_VERSIONS_IN(static, mix_rows, (const float *above, const float *below, float share, size_t count, float *out),
                (above, below, share, count, out))

/* J = I + (1 - t) (J_j - i_j) + t (J_(j+1) - i_(j+1)) of the pixels of a piece that are in segment j or above: those
 * above, t > 1, are written again when their segment comes. */
HDR_INLINE void interpolate_piece_body(const float *numbers, const int *cell, const float *share, const float *left,
                                       const float *right, double low, double inverse, double segment, float *out) {
    float before[HDR_PIECE], behind[HDR_PIECE], value[HDR_PIECE];
    for (int i = 0; i < HDR_PIECE; i++) {
        int c = cell[i];
        before[i] = (1 - share[i]) * left[c] + share[i] * left[c + 1];
        behind[i] = (1 - share[i]) * right[c] + share[i] * right[c + 1];
    }
    for (int i = 0; i < HDR_PIECE; i++) {
        double t = place_of(numbers[i], low, inverse) - segment;
        float base = numbers[i] + ((1 - (float)t) * before[i] + (float)t * behind[i]);
        value[i] = t >= 0 ? base : out[i];
    }
    memcpy(out, value, sizeof value);
}
HDR_VERSIONS_IN(static, interpolate_piece,
                (const float *numbers, const int *cell, const float *share, const float *left, const float *right,
                 double low, double inverse, double segment, float *out),
                (numbers, cell, share, left, right, low, inverse, segment, out))

/* Of segment j, between J_j and J_(j+1). */
static hdr_status interpolate(void *context, int band, int thread, hdr_error *err) {
    (void)err;
    const piecewise *p = context;
    const worker *w = &p->workers[thread];
    int j = p->node, height = p->sampled.height;
    size_t stride = p->sampled.stride;
    for (int y = band * BAND; y < band_end(p->in, band); y++) {
        const uint64_t *members = p->members + (size_t)y * (size_t)p->pieces;
        bool mixed = false;
        for (int piece = 0; piece < p->pieces; piece++) {
            if (!(members[piece] >> j % 64 & 1)) continue;
            if (!mixed) {
                float share;
                size_t above = (size_t)cell_of(p, y - p->top, height, &share) * stride;
                size_t below = height > 1 ? above + stride : above;
                mix_rows(p->offset[j % 2] + above, p->offset[j % 2] + below, share, stride, w->left);
                mix_rows(p->offset[(j + 1) % 2] + above, p->offset[(j + 1) % 2] + below, share, stride, w->right);
                mixed = true;
            }
            size_t x = (size_t)piece * HDR_PIECE, at = (size_t)y * p->in->stride + x;
            interpolate_piece(p->in->narrow + at, p->cell + x, p->share + x, w->left, w->right, p->filter->low,
                              p->inverse, j, p->out->narrow + at);
        }
    }
    return HDR_OK;
}

/* ---- In all ---- */

static hdr_status sample_band(void *context, int band, int thread, hdr_error *err) {
    (void)thread, (void)err;
    const piecewise *p = context;
    for (int y = band * BAND; y < band_end(&p->sampled, band); y++) {
        const float *from = p->in->narrow + (size_t)(p->top + y * p->step) * p->in->stride + p->left;
        float *to = p->samples + (size_t)y * p->sampled.stride;
        for (int x = 0; x < p->sampled.width; x++)
            to[x] = from[(size_t)x * (size_t)p->step];
    }
    return HDR_OK;
}

static bool make_f(piecewise *p) {
    double sigma = p->filter->sigma_s / p->step, reach = ceil(REACH_DEVIATIONS * sigma);
    int larger = p->sampled.width > p->sampled.height ? p->sampled.width : p->sampled.height;
    p->reach = reach < larger ? (int)reach : larger;
    p->f = hdr_alloc((size_t)p->reach + 1, sizeof *p->f);
    for (int k = 0; p->f && k <= p->reach; k++) {
        double z = k / sigma, weight = hdr_exp(-0.5 * z * z);
        p->f[k] = weight >= LEAST_OF_F ? (float)weight : 0;
    }
    return p->f != NULL;
}

static bool make_workers(piecewise *p) {
    size_t stride = p->sampled.stride, reach = (size_t)p->reach;
    p->workers = hdr_alloc((size_t)p->threads, sizeof *p->workers);
    for (int t = 0; p->workers && t < p->threads; t++) {
        worker *w = &p->workers[t];
        w->weights = hdr_alloc(stride + 2 * reach, sizeof *w->weights);
        w->sums = hdr_alloc(stride + 2 * reach, sizeof *w->sums);
        w->row = hdr_alloc(BAND + 2 * reach, sizeof *w->row);
        w->left = hdr_alloc(stride, sizeof *w->left);
        w->right = hdr_alloc(stride, sizeof *w->right);
        w->occupied = hdr_alloc((size_t)p->segments, 1);
        if (!w->weights || !w->sums || !w->row || !w->left || !w->right || !w->occupied) return false;
    }
    return p->workers != NULL;
}

static bool make_samples(piecewise *p) {
    hdr_plane *s = &p->sampled;
    *s = *p->in;
    if (p->step > 1) {
        s->width = (p->in->width - 1) / p->step + 1;
        s->height = (p->in->height - 1) / p->step + 1;
        s->stride = (((size_t)s->width + HDR_PIECE - 1) / HDR_PIECE | 1) * HDR_PIECE;
        s->narrow = p->samples = hdr_alloc((size_t)s->height * s->stride, sizeof *p->samples);
    }
    p->left = (p->in->width - 1) % p->step / 2;
    p->top = (p->in->height - 1) % p->step / 2;
    p->cell = hdr_alloc(p->in->stride, sizeof *p->cell);
    p->share = hdr_alloc(p->in->stride, sizeof *p->share);
    for (int x = 0; p->cell && p->share && x < p->in->width; x++)
        p->cell[x] = cell_of(p, x - p->left, s->width, &p->share[x]);
    return s->narrow && p->cell && p->share;
}

static bool lay_out(piecewise *p) {
    if (!make_samples(p) || !make_f(p)) return false;
    size_t numbers = (size_t)p->sampled.height * p->sampled.stride;
    p->across = hdr_alloc(numbers, 2 * sizeof *p->across);
    p->offset[0] = hdr_alloc(numbers, sizeof *p->offset[0]);
    p->offset[1] = hdr_alloc(numbers, sizeof *p->offset[1]);
    p->zeros = hdr_alloc(p->sampled.stride, 2 * sizeof *p->zeros);
    p->pieces = (p->in->width + HDR_PIECE - 1) / HDR_PIECE;
    p->members = hdr_alloc((size_t)p->in->height, (size_t)p->pieces * sizeof *p->members);
    return p->across && p->offset[0] && p->offset[1] && p->zeros && p->members && make_workers(p);
}

static void free_piecewise(piecewise *p) {
    for (int t = 0; p->workers && t < p->threads; t++) {
        worker *w = &p->workers[t];
        free(w->weights);
        free(w->sums);
        free(w->row);
        free(w->left);
        free(w->right);
        free(w->occupied);
    }
    free(p->workers);
    free(p->samples);
    free(p->f);
    free(p->across);
    free(p->zeros);
    free(p->offset[0]);
    free(p->offset[1]);
    free(p->cell);
    free(p->share);
    free(p->members);
}

static hdr_status compute_node(piecewise *p, int j, hdr_pool *pool, hdr_error *err) {
    int bands = (p->sampled.height + BAND - 1) / BAND;
    p->node = j;
    hdr_status status = hdr_pool_run(pool, bands, convolve_across, p, err);
    return status == HDR_OK ? hdr_pool_run(pool, bands, convolve_down, p, err) : status;
}

/* Segment by segment, with the J_j of its two ends, of which the lower one is the upper one of the segment before. */
static hdr_status run(piecewise *p, hdr_pool *pool, hdr_bilateral_report *report, hdr_error *err) {
    int bands = (p->in->height + BAND - 1) / BAND, last = -1;
    hdr_status status = hdr_pool_run(pool, bands, see_segments, p, err);
    for (int j = 0; j < p->segments && status == HDR_OK; j++) {
        if (!is_occupied(p, j)) continue;
        for (int node = last < j ? j : j + 1; node <= j + 1 && status == HDR_OK; node++) {
            status = compute_node(p, node, pool, err);
            report->used++;
        }
        last = j + 1;
        p->node = j;
        if (status == HDR_OK) status = hdr_pool_run(pool, bands, interpolate, p, err);
    }
    return status;
}

hdr_status hdr_bilateral_piecewise(const hdr_bilateral *filter, int subsample, hdr_plane *plane, hdr_pool *pool,
                                   hdr_bilateral_report *report, hdr_error *err) {
    double range = filter->high - filter->low;
    double wanted = ceil(range / filter->sigma_r - 1e-3);
    piecewise p = {.filter = filter,
                   .in = plane,
                   .segments = wanted > 1 ? (int)wanted : 1,
                   .step = subsample,
                   .threads = hdr_pool_threads(pool)};
    p.inverse = range > 0 ? p.segments / range : 0;
    *report = (hdr_bilateral_report){.cells = (uint64_t)p.segments + 1, .segments = p.segments};
    p.out = hdr_plane_new(plane->width, plane->height, false, err);
    hdr_status status = p.out ? HDR_OK : HDR_INTERNAL;
    if (status == HDR_OK && !lay_out(&p)) status = hdr_fail(err, HDR_INTERNAL, "out of memory");
    if (status == HDR_OK && p.samples)
        status = hdr_pool_run(pool, (p.sampled.height + BAND - 1) / BAND, sample_band, &p, err);
    if (status == HDR_OK) status = run(&p, pool, report, err);
    free_piecewise(&p);
    if (status == HDR_OK) {
        float *base = p.out->narrow;
        p.out->narrow = plane->narrow;
        plane->narrow = base;
    }
    hdr_plane_free(p.out);
    return status;
}

/* The search in float. Bands of rows are worked on by themselves, each with as many rows around it as a Gaussian
 * reaches; a band's rows are cut into pieces, and a Gaussian is computed for those pieces only that still have a pixel
 * whose scale is open, and where by a bound the tests that need it could succeed. */
#include "spatial/scales.h"

#include "kernel/convolve.h"
#include "spatial/gaussian.h"
#include "spatial/scales_wide.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { GAUSSIANS = HDR_SCALES + 1, BAND = 32 };

typedef struct gaussian {
    int reach;
    float *weight;
    int full_reach;  /* of the reference */
    double *full;    /* weights of -full_reach ... full_reach */
    double distance; /* half of the sum of |weight - weight of the next|, over the plane */
} gaussian;

/* What one thread works with. Rows of the band, one behind the other. */
typedef struct worker {
    float *down;                         /* convolved down only; with a margin at both ends */
    float *v[2];                         /* V_i, at i mod 2 */
    unsigned char *marks;                /* each pixel's m, or HDR_OPEN */
    unsigned char *open;                 /* pieces: how many of its pixels are open */
    unsigned char *wanted, *wanted_down; /* pieces: whether V_i is wanted; what is wanted for it of `down` */
    uint16_t *possible;                  /* of a piece's column: bit i is set if test i could succeed */
    const float **row;                   /* the rows above, of and below the band */
    float *around;                       /* a row's numbers around a pixel, mirrored at the border */
    hdr_scales_report report;
} worker;

typedef struct search {
    const hdr_scales *scales;
    const hdr_plane *in;
    hdr_plane *out;
    unsigned char *choice;
    gaussian gaussian[GAUSSIANS];
    int margin; /* the longest reach, in whole pieces */
    int pieces, bands;
    float *low, *high; /* the range of each piece of each band */
    worker *workers;
    int threads;
} search;

/* ---- Gaussians ---- */

/* How far apart two kernels are, as factors in x and y: no convolved value differs by more than that times the range of
 * what is convolved, since what is added here is taken away there. */
static double distance_of(const double *a, int reach_a, const double *b, int reach_b) {
    int reach = reach_a > reach_b ? reach_a : reach_b;
    double sum = 0;
    for (int y = -reach; y <= reach; y++)
        for (int x = -reach; x <= reach; x++) {
            int i = abs(y), j = abs(x);
            double one = i <= reach_a && j <= reach_a ? a[i] * a[j] : 0;
            double other = i <= reach_b && j <= reach_b ? b[i] * b[j] : 0;
            sum += fabs(one - other);
        }
    return sum / 2;
}

/* In float, but so that they add up to 1: what rounding took from the others goes to the centre. */
static void round_weights(const double *weight, int reach, float *rounded) {
    double others = 0;
    for (int k = 1; k <= reach; k++) {
        rounded[k] = (float)weight[k];
        others += 2 * (double)rounded[k];
    }
    rounded[0] = (float)(1 - others);
}

/* Those that the reference has, for single pixels. */
static hdr_status make_full_weights(gaussian *g, double sigma, double ratio, hdr_error *err) {
    g->full_reach = hdr_scales_full_reach(sigma, ratio);
    size_t reach = (size_t)g->full_reach;
    g->full = hdr_alloc(2 * reach + 1, sizeof *g->full);
    if (!g->full) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    hdr_gaussian(sigma, g->full_reach, g->full + reach);
    for (size_t k = 1; k <= reach; k++)
        g->full[reach - k] = g->full[reach + k];
    return HDR_OK;
}

static double largest_of(const search *s) {
    double largest = 0;
    for (size_t i = 0; i < (size_t)s->bands * (size_t)s->pieces; i++)
        largest = fmax(largest, (double)s->high[i]);
    return largest;
}

/* What lies beyond a reach weighs, with the largest number there is, no more than this many units. */
#define REST 1e-8

static hdr_status make_gaussians(search *s, hdr_error *err) {
    const hdr_scales *scales = s->scales;
    double ratio = largest_of(s) / scales->unit, rest = REST / (2 * (ratio > 1 ? ratio : 1));
    double *before = NULL;
    hdr_status status = HDR_OK;
    for (int i = 0; i < GAUSSIANS && status == HDR_OK; i++) {
        gaussian *g = &s->gaussian[i];
        g->reach = hdr_gaussian_reach(scales->sigma[i], 0, rest);
        g->weight = hdr_alloc((size_t)g->reach + 1, sizeof *g->weight);
        double *weight = hdr_alloc((size_t)g->reach + 1, sizeof *weight);
        if (g->weight && weight) {
            hdr_gaussian(scales->sigma[i], g->reach, weight);
            round_weights(weight, g->reach, g->weight);
            if (i > 0) s->gaussian[i - 1].distance = distance_of(before, s->gaussian[i - 1].reach, weight, g->reach);
        } else {
            status = hdr_fail(err, HDR_INTERNAL, "out of memory");
        }
        free(before);
        before = weight;
        if (g->reach > s->margin) s->margin = g->reach;
        if (status == HDR_OK) status = make_full_weights(g, scales->sigma[i], ratio, err);
    }
    free(before);
    s->margin = (s->margin + HDR_PIECE - 1) / HDR_PIECE * HDR_PIECE;
    return status;
}

/* ---- What could be uneven ---- */

static int band_end(const search *s, int band) {
    int end = (band + 1) * BAND;
    return end < s->in->height ? end : s->in->height;
}

static hdr_status find_ranges(void *context, int band, int thread, hdr_error *err) {
    (void)thread, (void)err;
    search *s = context;
    int last = s->in->width - (s->pieces - 1) * HDR_PIECE; /* pixels of the last piece */
    for (int p = 0; p < s->pieces; p++) {
        float low = INFINITY, high = 0;
        for (int y = band * BAND; y < band_end(s, band); y++) {
            const float *numbers = s->in->narrow + (size_t)y * s->in->stride + (size_t)p * HDR_PIECE;
            if (p < s->pieces - 1 || last == HDR_PIECE) {
                hdr_range_of_piece(numbers, &low, &high);
                continue;
            }
            for (int x = 0; x < last; x++) {
                low = numbers[x] < low ? numbers[x] : low;
                high = numbers[x] > high ? numbers[x] : high;
            }
        }
        s->low[(size_t)band * (size_t)s->pieces + (size_t)p] = low;
        s->high[(size_t)band * (size_t)s->pieces + (size_t)p] = high;
    }
    return HDR_OK;
}

/* The range of all that a Gaussian can reach from a piece. What is mirrored at a border is nearer than its image. */
static void range_around(const search *s, int band, int piece, int reach, double *low, double *high) {
    int up = (reach + BAND - 1) / BAND, across = (reach + HDR_PIECE - 1) / HDR_PIECE;
    *low = (double)INFINITY;
    *high = 0;
    for (int b = band - up; b <= band + up; b++)
        for (int p = piece - across; p <= piece + across; p++) {
            if (b < 0 || b >= s->bands || p < 0 || p >= s->pieces) continue;
            size_t i = (size_t)b * (size_t)s->pieces + (size_t)p;
            *low = fmin(*low, (double)s->low[i]);
            *high = fmax(*high, (double)s->high[i]);
        }
}

/* A V in float is a sum of reach + 1 products of rounded weights and rounded sums of two, in both directions, all of
 * them positive; the centre's weight has the rounding of all others, too. None is wrong by more than this much of
 * itself, as long as no weight that matters and no product is denormal: suits_float sees to that. */
static double error_of(int reach) {
    return 2 * (reach + 6) * 0x1p-24;
}

/* And by so much that has no part in that: what lies beyond the reach, and 2^-149 of each denormal term. */
static double slack_of(const search *s, int reach) {
    return REST * s->scales->unit + 4 * (reach + 4) * 0x1p-149;
}

/* Whether test i could succeed in a piece of a band, for V as they are computed and for V as they ought to be. */
static bool could_be_uneven(const search *s, int band, int piece, int i) {
    int reach = s->gaussian[i + 1].reach;
    double low, high;
    range_around(s, band, piece, reach, &low, &high);
    double wrong = error_of(reach);
    double difference = s->gaussian[i].distance * (1 + wrong) * (high - low) + 2 * (wrong * high + slack_of(s, reach));
    double allowed = s->scales->epsilon * (s->scales->offset[i] + low * (1 - wrong));
    return !(difference <= allowed * (1 - wrong));
}

/* ---- A band ---- */

/* Nothing but 0 within the reach of all Gaussians: all V are 0, and no test succeeds. */
static bool is_black(const search *s, int band, int piece) {
    double low, high;
    range_around(s, band, piece, s->gaussian[GAUSSIANS - 1].reach, &low, &high);
    return high == 0;
}

static void begin_band(const search *s, worker *w, int band) {
    int rows = band_end(s, band) - band * BAND;
    size_t stride = s->in->stride;
    memset(w->marks, 0, (size_t)rows * stride);
    for (int p = 0; p < s->pieces; p++) {
        int pixels = s->in->width - p * HDR_PIECE < HDR_PIECE ? s->in->width - p * HDR_PIECE : HDR_PIECE;
        bool black = !s->scales->no_skip && is_black(s, band, p);
        w->possible[p] = 0;
        for (int i = 0; i < HDR_SCALES; i++) {
            /* the last test changes nothing */
            bool possible = s->scales->no_skip || (!black && i < HDR_SCALES - 1 && could_be_uneven(s, band, p, i));
            w->possible[p] |= (uint16_t)(possible << i);
        }
        for (int row = 0; row < rows; row++) {
            size_t at = (size_t)row * stride + (size_t)p * HDR_PIECE;
            w->open[(size_t)row * (size_t)s->pieces + (size_t)p] = black ? 0 : (unsigned char)pixels;
            memset(w->marks + at, black ? HDR_SCALES - 1 : HDR_OPEN, (size_t)pixels);
            if (black) memset(s->out->narrow + (size_t)band * BAND * stride + at, 0, (size_t)pixels * sizeof(float));
        }
        if (black) w->report.chosen[HDR_SCALES - 1] += (uint64_t)(pixels * rows);
    }
}

/* Which pieces V_i is computed for: those with open pixels where a test that takes it could succeed; and V of the last
 * test for all, as that is what stays where none does. And what that takes. */
static bool want(const search *s, worker *w, int rows, int i) {
    bool any = false;
    int across = (s->gaussian[i].reach + HDR_PIECE - 1) / HDR_PIECE;
    unsigned tests = (unsigned)(1 << i | (i > 0 ? 1 << (i - 1) : 0));
    memset(w->wanted_down, 0, (size_t)rows * (size_t)s->pieces);
    for (int row = 0; row < rows; row++) {
        size_t first = (size_t)row * (size_t)s->pieces;
        for (int p = 0; p < s->pieces; p++) {
            bool wanted = w->open[first + (size_t)p] && (w->possible[p] & tests || i == HDR_SCALES - 1);
            w->wanted[first + (size_t)p] = wanted;
            any |= wanted;
            for (int q = p - across; wanted && q <= p + across; q++)
                if (q >= 0 && q < s->pieces) w->wanted_down[first + (size_t)q] = 1;
        }
    }
    return any;
}

/* Column by column of pieces, so that the rows around the band stay in the cache. */
static void convolve_down(const search *s, const worker *w, int rows, int i) {
    const gaussian *g = &s->gaussian[i];
    size_t down_stride = s->in->stride + 2 * (size_t)s->margin;
    for (int p = 0; p < s->pieces; p++)
        for (int row = 0; row < rows; row++)
            if (w->wanted_down[(size_t)row * (size_t)s->pieces + (size_t)p])
                hdr_convolve_down(w->row + s->margin + row, (size_t)p * HDR_PIECE, g->weight, g->reach,
                                  w->down + (size_t)row * down_stride + (size_t)s->margin + (size_t)p * HDR_PIECE);
}

static void convolve_across(const search *s, worker *w, int rows, int i) {
    const gaussian *g = &s->gaussian[i];
    int width = s->in->width;
    for (int row = 0; row < rows; row++) {
        float *down = w->down + (size_t)row * (s->in->stride + 2 * (size_t)s->margin) + s->margin;
        float *v = w->v[i % 2] + (size_t)row * s->in->stride;
        const unsigned char *wanted = w->wanted + (size_t)row * (size_t)s->pieces;
        for (int k = 1; k <= g->reach; k++) {
            down[-k] = down[hdr_mirrored(-k, width)];
            down[width - 1 + k] = down[hdr_mirrored(width - 1 + k, width)];
        }
        for (int p = 0; p < s->pieces; p++) {
            if (!wanted[p]) continue;
            int first = p;
            while (p + 1 < s->pieces && wanted[p + 1])
                p++;
            size_t count = (size_t)(p + 1 - first) * HDR_PIECE;
            hdr_convolve_across(down + (size_t)first * HDR_PIECE, g->weight, g->reach, v + (size_t)first * HDR_PIECE,
                                count);
            w->report.blurred[i] +=
                count < (size_t)(width - first * HDR_PIECE) ? count : (size_t)(width - first * HDR_PIECE);
        }
    }
}

/* V_i of one pixel in double, with the reference's weights. */
static double exact_v(const search *s, const worker *w, int x, int y, int i) {
    const gaussian *g = &s->gaussian[i];
    const hdr_plane *in = s->in;
    size_t count = 2 * (size_t)g->full_reach + 1;
    double sum = 0;
    for (int k = -g->full_reach; k <= g->full_reach; k++) {
        const float *row = in->narrow + (size_t)hdr_mirrored((int64_t)y + k, in->height) * in->stride;
        const float *from = w->around;
        if (x >= g->full_reach && x < in->width - g->full_reach)
            from = row + x - g->full_reach;
        else
            for (size_t n = 0; n < count; n++)
                w->around[n] = row[hdr_mirrored((int64_t)x - g->full_reach + (int64_t)n, in->width)];
        sum += g->full[g->full_reach + k] * hdr_weighted_sum(from, g->full, count);
    }
    return sum;
}

/* Settles the doubtful pixels of a piece by exact values. Returns how many of them stay open. */
static int settle(const search *s, worker *w, int piece, int y, int i, const float *float_v, unsigned char *marks,
                  float *out) {
    int left = 0;
    for (int n = 0; n < HDR_PIECE; n++) {
        if (marks[n] != HDR_DOUBTFUL) continue;
        int x = piece * HDR_PIECE + n;
        double v = exact_v(s, w, x, y, i), next = exact_v(s, w, x, y, i + 1);
        bool uneven = fabs(v - next) > s->scales->epsilon * (s->scales->offset[i] + v);
        marks[n] = uneven ? (unsigned char)i : HDR_OPEN;
        if (uneven) out[n] = float_v[n]; /* as it would be without a doubt: what is skipped makes no difference */
        left += !uneven;
        w->report.settled++;
    }
    return left;
}

/* Test i, of V_i and V_(i+1), where both have been computed. */
static void test(const search *s, worker *w, int band, int rows, int i) {
    const float *v = w->v[i % 2], *next = w->v[(i + 1) % 2];
    const int reach = s->gaussian[i + 1].reach;
    const hdr_uneven uneven = {s->scales->epsilon, s->scales->offset[i], error_of(reach), slack_of(s, reach),
                               (unsigned char)i};
    for (int row = 0; row < rows; row++)
        for (int p = 0; p < s->pieces; p++) {
            unsigned char *open = &w->open[(size_t)row * (size_t)s->pieces + (size_t)p];
            if (!*open || !(w->possible[p] >> i & 1)) continue;
            size_t at = (size_t)row * s->in->stride + (size_t)p * HDR_PIECE;
            float *out = s->out->narrow + (size_t)band * BAND * s->in->stride + at;
            hdr_open left = hdr_close_uneven(v + at, next + at, &uneven, w->marks + at, out);
            if (left.doubtful)
                left.open += settle(s, w, p, band * BAND + row, i, v + at, w->marks + at, out) - left.doubtful;
            w->report.chosen[i] += (uint64_t)(*open - left.open);
            *open = (unsigned char)left.open;
        }
}

/* What no test has closed. */
static void close_the_rest(const search *s, worker *w, int band, int rows) {
    const float *v = w->v[(HDR_SCALES - 1) % 2];
    for (int row = 0; row < rows; row++)
        for (int p = 0; p < s->pieces; p++) {
            if (!w->open[(size_t)row * (size_t)s->pieces + (size_t)p]) continue;
            size_t at = (size_t)row * s->in->stride + (size_t)p * HDR_PIECE;
            float *out = s->out->narrow + (size_t)band * BAND * s->in->stride + at;
            for (int x = 0; x < HDR_PIECE; x++) {
                if (w->marks[at + (size_t)x] != HDR_OPEN) continue;
                out[x] = v[at + (size_t)x];
                w->marks[at + (size_t)x] = HDR_SCALES - 1;
                w->report.chosen[HDR_SCALES - 1]++;
            }
        }
}

static hdr_status search_band(void *context, int band, int thread, hdr_error *err) {
    (void)err;
    search *s = context;
    worker *w = &s->workers[thread];
    int first = band * BAND, rows = band_end(s, band) - first;
    for (int y = -s->margin; y < rows + s->margin; y++)
        w->row[s->margin + y] = s->in->narrow + (size_t)hdr_mirrored((int64_t)first + y, s->in->height) * s->in->stride;
    begin_band(s, w, band);
    for (int i = 0; i < GAUSSIANS; i++) {
        if (want(s, w, rows, i)) {
            convolve_down(s, w, rows, i);
            convolve_across(s, w, rows, i);
        }
        if (i > 0) test(s, w, band, rows, i - 1);
        /* V of the last test is overwritten by the next Gaussian but one only */
    }
    close_the_rest(s, w, band, rows);
    for (int row = 0; s->choice && row < rows; row++)
        memcpy(s->choice + (size_t)(first + row) * (size_t)s->in->width, w->marks + (size_t)row * s->in->stride,
               (size_t)s->in->width);
    return HDR_OK;
}

/* ---- In all ---- */

static bool make_workers(search *s) {
    size_t stride = s->in->stride, pieces = (size_t)s->pieces, margin = (size_t)s->margin;
    s->workers = hdr_alloc((size_t)s->threads, sizeof *s->workers);
    for (int t = 0; s->workers && t < s->threads; t++) {
        worker *w = &s->workers[t];
        w->down = hdr_alloc(BAND * (stride + 2 * margin), sizeof *w->down);
        for (int i = 0; i < 2; i++)
            w->v[i] = hdr_alloc(BAND * stride, sizeof *w->v[i]);
        w->marks = hdr_alloc(BAND, stride);
        w->open = hdr_alloc(BAND, pieces);
        w->wanted = hdr_alloc(BAND, pieces);
        w->wanted_down = hdr_alloc(BAND, pieces);
        w->possible = hdr_alloc(pieces, sizeof *w->possible);
        w->row = hdr_alloc(BAND + 2 * margin, sizeof *w->row);
        w->around = hdr_alloc(2 * (size_t)s->gaussian[GAUSSIANS - 1].full_reach + 1, sizeof *w->around);
        if (!w->down || !w->v[0] || !w->v[1] || !w->marks || !w->open || !w->wanted || !w->wanted_down ||
            !w->possible || !w->row || !w->around)
            return false;
    }
    return s->workers != NULL;
}

static void free_search(search *s) {
    for (int i = 0; i < GAUSSIANS; i++) {
        free(s->gaussian[i].weight);
        free(s->gaussian[i].full);
    }
    for (int t = 0; s->workers && t < s->threads; t++) {
        worker *w = &s->workers[t];
        free(w->down);
        free(w->v[0]);
        free(w->v[1]);
        free(w->marks);
        free(w->open);
        free(w->wanted);
        free(w->wanted_down);
        free(w->possible);
        free(w->row);
        free(w->around);
    }
    free(s->workers);
    free(s->low);
    free(s->high);
}

static void merge_reports(const search *s, hdr_scales_report *report) {
    *report = (hdr_scales_report){.settled = 0};
    for (int t = 0; t < s->threads; t++) {
        report->settled += s->workers[t].report.settled;
        for (int i = 0; i < GAUSSIANS; i++) {
            report->blurred[i] += s->workers[t].report.blurred[i];
            if (i < HDR_SCALES) report->chosen[i] += s->workers[t].report.chosen[i];
        }
    }
    for (int i = 0; i < GAUSSIANS; i++)
        report->reach[i] = s->gaussian[i].reach;
}

/* Sums must not overflow, units not be denormal, and the weight of the farthest pixel that counts has to be a normal
 * number still; and the test's own rounding has to be small against epsilon, or all is decided in double, pixel by
 * pixel. */
static bool suits_float(const search *s) {
    double largest = largest_of(s), unit = s->scales->unit;
    return largest <= 0x1p120 && unit >= 0x1p-100 && largest <= 0x1p100 * unit && s->scales->epsilon >= 1e-4;
}

hdr_status hdr_scales_surround(const hdr_scales *scales, const hdr_plane *plane, hdr_plane *surround,
                               unsigned char *choice, hdr_pool *pool, hdr_scales_report *report, bool *too_wide,
                               hdr_error *err) {
    *too_wide = false;
    if (plane->wide) return hdr_scales_surround_wide(scales, plane, surround, choice, pool, report, err);
    search s = {.scales = scales, .in = plane, .out = surround, .choice = choice, .threads = hdr_pool_threads(pool)};
    s.pieces = (plane->width + HDR_PIECE - 1) / HDR_PIECE;
    s.bands = (plane->height + BAND - 1) / BAND;
    s.low = hdr_alloc((size_t)s.bands * (size_t)s.pieces, sizeof *s.low);
    s.high = hdr_alloc((size_t)s.bands * (size_t)s.pieces, sizeof *s.high);
    hdr_status status = s.low && s.high ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
    if (status == HDR_OK) status = hdr_pool_run(pool, s.bands, find_ranges, &s, err);
    bool suits = status == HDR_OK && suits_float(&s);
    if (suits) status = make_gaussians(&s, err);
    if (suits && status == HDR_OK && !make_workers(&s)) status = hdr_fail(err, HDR_INTERNAL, "out of memory");
    if (suits && status == HDR_OK) status = hdr_pool_run(pool, s.bands, search_band, &s, err);
    if (suits && status == HDR_OK) merge_reports(&s, report);
    *too_wide = !suits;
    free_search(&s);
    return status;
}

/* FLIP. Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astroem and Fairchild, FLIP: A Difference Evaluator for
 * Alternating Images, Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020; and for scenes' light Andersson, Nilsson,
 * Shirley and Akenine-Moeller, Visualizing Errors in Rendered High Dynamic Range Images, Eurographics 2021 Short
 * Papers.
 *
 * The picture is cut into squares, each of which one thread compares from its pixels on, in all exposures, before it
 * takes the next: what is made on the way stays in the cache, and threads change nothing. All filters are separable:
 * Gaussians, sums of two, and derivatives of one. */
#include "base/pool.h"
#include "chain/chain.h"
#include "kernel/flip.h"
#include "kernel/real.h"
#include "measure/measure.h"
#include "measure/select.h"
#include "measure/view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

_Static_assert((int)HDR_FLIP_SIDE == (int)HDR_TILE_SIDE, "the squares are those of the other figures");

struct hdr_flip_reference {
    const hdr_chain *chain;
    hdr_input *input;
    hdr_output *output; /* holds its pixels */
    hdr_picture picture;
    hdr_flip_kind kind;
    bool encoded;
    double ppd, start, stop;
    int exposures, columns, rows; /* columns, rows: of squares */
    hdr_flip_filters filters;
    hdr_flip_colours colours;
    hdr_flip_features *kept; /* of each exposure of each square, once they are known, for tests to come; or NULL */
    bool known;
};

/* What a thread works with; side: of a square with its margins. */
typedef struct workshop {
    double *light[2][3], *display[3], *opponent[3]; /* of test and reference */
    hdr_flip_row *row;
    hdr_flip_features *features; /* two */
    double *flip;
} workshop;

typedef struct comparing {
    hdr_flip_reference *reference;
    const hdr_planes *pixels[2];
    workshop *shops;
    int threads;
    double *map;
} comparing;
enum { TEST, REFERENCE };

/* ---- Filters ---- */

enum { GAUSSIANS = 4 };

/* Contrast sensitivity, section 4.1.1: a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees; of y, cx, and the two of cz. */
static const struct gaussian {
    double a, b;
} sensitivity[GAUSSIANS] = {{1, 0.0047}, {1, 0.0053}, {34.1, 0.04}, {13.5, 0.025}};
static const double pi = 0x1.921fb54442d18p+1, widest = 0.04;

/* Weights of one Gaussian, which add up to 1 over both sides. Its share before: their sum squared, times its height. */
static double fill_gaussian(double *weights, size_t stride, int reach, double exponent, double height) {
    double sum = 0;
    for (int k = reach; k >= 0; k--)
        sum += (k ? 2 : 1) * (weights[(size_t)k * stride] = hdr_exp(-exponent * k * k));
    for (int k = 0; k <= reach; k++)
        weights[(size_t)k * stride] /= sum;
    return height * sum * sum;
}

/* Derivatives of a Gaussian, section 4.2: -x G and (x^2 / s^2 - 1) G, positive and negative weights scaled to add up to
 * 1 and -1. Their sign does not matter, since their magnitude counts. */
static void fill_derivatives(hdr_flip_tap *tap, int reach, double deviation) {
    double slope = 0, above = 0, below = 0;
    for (int k = reach; k >= 0; k--) {
        double bend = k * k / (deviation * deviation) - 1, both = k ? 2 : 1;
        tap[k].edge = k * tap[k].smooth;
        tap[k].point = bend * tap[k].smooth;
        slope += tap[k].edge;
        *(bend > 0 ? &above : &below) += both * fabs(tap[k].point);
    }
    for (int k = 0; k <= reach; k++) {
        if (slope > 0) tap[k].edge /= slope;
        tap[k].point /= tap[k].point > 0 ? above : below;
    }
}

static hdr_status make_filters(hdr_flip_filters *filters, double ppd, hdr_error *err) {
    double deviation = 0.5 * 0.082 * ppd;
    int reach = (int)ceil(3 * sqrt(widest / (2 * pi * pi)) * ppd), derived = (int)ceil(3 * deviation);
    size_t stride = sizeof(hdr_flip_tap) / sizeof(double);
    filters->reach = reach > derived ? reach : derived;
    filters->tap = hdr_alloc((size_t)filters->reach + 1, sizeof *filters->tap);
    if (!filters->tap) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    double *first[GAUSSIANS] = {&filters->tap->y, &filters->tap->cx, &filters->tap->cz[0], &filters->tap->cz[1]};
    double share[GAUSSIANS];
    for (int g = 0; g < GAUSSIANS; g++)
        share[g] = fill_gaussian(first[g], stride, reach, pi * pi / (ppd * ppd * sensitivity[g].b),
                                 sensitivity[g].a * sqrt(pi / sensitivity[g].b));
    filters->share[0] = share[2] / (share[2] + share[3]);
    filters->share[1] = share[3] / (share[2] + share[3]);
    fill_gaussian(&filters->tap->smooth, stride, derived, 0.5 / (deviation * deviation), 1);
    fill_derivatives(filters->tap, derived, deviation);
    return HDR_OK;
}

/* ---- A square ---- */

static int margin_side(const hdr_flip_filters *filters) {
    return HDR_FLIP_SIDE + 2 * filters->reach;
}

static int held(int at, int size) {
    return at < 0 ? 0 : at < size ? at : size - 1;
}

/* Light, or codes, of a square and its margins; beyond the picture its outermost pixels stand again. */
static void load_square(const hdr_planes *pixels, int x, int y, int reach, double *const to[3]) {
    int side = HDR_FLIP_SIDE + 2 * reach;
    for (int c = 0; c < pixels->planes; c++)
        for (int j = 0; j < side; j++) {
            const float *row = pixels->plane[c] + (size_t)held(y - reach + j, pixels->height) * (size_t)pixels->width;
            double *out = to[c] + (size_t)j * (size_t)side;
            for (int i = 0; i < side; i++) {
                double value = (double)row[held(x - reach + i, pixels->width)];
                out[i] = value > 0 ? value : 0;
            }
        }
}

/* What the display shows, in opponent colours. */
static void show_square(const hdr_flip_reference *f, const workshop *shop, int which, int planes, double scale) {
    size_t side = (size_t)margin_side(&f->filters), count = side * side;
    const double *rgb[3];
    for (int c = 0; c < 3; c++) {
        rgb[c] = shop->display[c < planes ? c : 0];
        if (c >= planes) continue;
        if (f->kind == HDR_FLIP_HDR) {
            hdr_flip_tone_map(shop->light[which][c], scale, shop->display[c], count);
            continue;
        }
        memcpy(shop->display[c], shop->light[which][c], count * sizeof(double));
        if (f->encoded)
            hdr_flip_decode(shop->display[c], count);
        else
            hdr_flip_clamp(shop->display[c], count);
    }
    hdr_flip_to_opponent(&f->colours, rgb, shop->opponent, count);
}

static void find_features(const hdr_flip_reference *f, const workshop *shop, bool coloured, hdr_flip_features *out) {
    size_t side = (size_t)margin_side(&f->filters), reach = (size_t)f->filters.reach;
    for (size_t j = 0; j < side; j++) {
        size_t at = j * side + reach;
        hdr_flip_across(&f->filters,
                        (const double *[]){shop->opponent[0] + at, shop->opponent[1] + at, shop->opponent[2] + at},
                        coloured, &shop->row[j]);
    }
    hdr_flip_down(&f->filters, &f->colours, &shop->row[reach], coloured, out);
}

static double exposure_at(const hdr_flip_reference *f, int i) {
    return f->start + i * ((f->stop - f->start) / (f->exposures > 1 ? f->exposures - 1 : 1));
}

static hdr_status compare_square(void *context, int square, int thread, hdr_error *err) {
    (void)err;
    comparing *c = context;
    hdr_flip_reference *f = c->reference;
    const workshop *shop = &c->shops[thread];
    int x = square % f->columns * HDR_FLIP_SIDE, y = square / f->columns * HDR_FLIP_SIDE;
    memset(shop->flip, 0, HDR_FLIP_PIXELS * sizeof(double));
    for (int which = TEST; which <= REFERENCE; which++)
        load_square(c->pixels[which], x, y, f->filters.reach, shop->light[which]);
    for (int i = 0; i < f->exposures; i++) {
        double scale = hdr_exp2(exposure_at(f, i));
        hdr_flip_features *features[2] = {&shop->features[TEST], &shop->features[REFERENCE]};
        if (f->kept) features[REFERENCE] = &f->kept[(size_t)square * (size_t)f->exposures + (size_t)i];
        for (int which = TEST; which <= REFERENCE; which++) {
            if (which == REFERENCE && f->known) continue;
            show_square(f, shop, which, c->pixels[which]->planes, scale);
            find_features(f, shop, c->pixels[which]->planes == 3, features[which]);
        }
        hdr_flip_raise(&f->colours, features[TEST], features[REFERENCE], shop->flip);
    }
    int width = c->pixels[TEST]->width, height = c->pixels[TEST]->height;
    for (int j = 0; j < HDR_FLIP_SIDE && y + j < height; j++)
        for (int i = 0; i < HDR_FLIP_SIDE && x + i < width; i++)
            c->map[(size_t)(y + j) * (size_t)width + (size_t)(x + i)] = shop->flip[j * HDR_FLIP_SIDE + i];
    return HDR_OK;
}

/* ---- Threads ---- */

static hdr_status open_shop(workshop *shop, const hdr_flip_filters *filters, hdr_error *err) {
    size_t side = (size_t)margin_side(filters), count = side * side;
    bool full = true;
    for (int c = 0; c < 3; c++) {
        full &= (shop->light[TEST][c] = hdr_alloc(count, sizeof(double))) != NULL;
        full &= (shop->light[REFERENCE][c] = hdr_alloc(count, sizeof(double))) != NULL;
        full &= (shop->display[c] = hdr_alloc(count, sizeof(double))) != NULL;
        full &= (shop->opponent[c] = hdr_alloc(count, sizeof(double))) != NULL;
    }
    full &= (shop->row = hdr_alloc(side, sizeof *shop->row)) != NULL;
    full &= (shop->features = hdr_alloc(2, sizeof *shop->features)) != NULL;
    full &= (shop->flip = hdr_alloc(HDR_FLIP_PIXELS, sizeof(double))) != NULL;
    return full ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
}

static void close_shop(workshop *shop) {
    for (int c = 0; c < 3; c++) {
        free(shop->light[TEST][c]);
        free(shop->light[REFERENCE][c]);
        free(shop->display[c]);
        free(shop->opponent[c]);
    }
    free(shop->row);
    free(shop->features);
    free(shop->flip);
}

/* Fills c->map. */
static hdr_status compare(comparing *c, hdr_error *err) {
    hdr_flip_reference *f = c->reference;
    int squares = f->columns * f->rows, wanted = hdr_chain_settings(f->chain)->threads;
    c->threads = wanted < squares ? wanted : squares;
    c->map = hdr_alloc((size_t)c->pixels[TEST]->width * (size_t)c->pixels[TEST]->height, sizeof *c->map);
    c->shops = hdr_alloc((size_t)c->threads, sizeof *c->shops);
    hdr_status status = c->map && c->shops ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (int t = 0; t < c->threads && status == HDR_OK; t++)
        status = open_shop(&c->shops[t], &f->filters, err);
    hdr_pool *pool = status == HDR_OK ? hdr_pool_new(c->threads, err) : NULL;
    if (status == HDR_OK) status = pool ? hdr_pool_run(pool, squares, compare_square, c, err) : HDR_INTERNAL;
    f->known |= status == HDR_OK && f->kept;
    hdr_pool_free(pool);
    for (int t = 0; c->shops && t < c->threads; t++)
        close_shop(&c->shops[t]);
    free(c->shops);
    return status;
}

/* ---- The reference ---- */

/* The luminance that HDR-FLIP's longest exposure is for: the median, of two in the middle the upper one, as FLIP's
 * authors compute it; where that is 0, the median of what is lit, which they do not define. 0: nothing is lit. */
static hdr_status find_median(const double *luminance, size_t count, double *median, hdr_error *err) {
    size_t lit = 0;
    hdr_status status = hdr_select(luminance, count, false, (double)(count / 2), median, err);
    for (size_t i = 0; i < count; i++)
        lit += luminance[i] > 0;
    if (status || *median > 0 || lit == 0) return status;
    return hdr_select(luminance, count, false, (double)(count - lit + lit / 2), median, err);
}

/* Section 3 of the paper of 2021: the shortest exposure takes the largest luminance to 0.85 on the display, the longest
 * the median; in between there is one each stop. */
static hdr_status choose_exposures(hdr_flip_reference *f, const hdr_planes *pixels, hdr_error *err) {
    size_t count = (size_t)pixels->width * (size_t)pixels->height;
    double *luminance = hdr_alloc(count, sizeof *luminance), largest = 0, median = 0, abc[3];
    if (!luminance) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (size_t i = 0; i < count; i++) {
        double rgb[3];
        for (int c = 0; c < 3; c++) {
            double value = (double)pixels->plane[c < pixels->planes ? c : 0][i];
            rgb[c] = value > 0 ? value : 0;
        }
        luminance[i] = pixels->planes == 1 ? rgb[0] : 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        if (luminance[i] > largest) largest = luminance[i];
    }
    hdr_status status = find_median(luminance, count, &median, err);
    free(luminance);
    if (status || largest == 0) return status;
    hdr_flip_tone_equation(0.85, abc);
    double half = -0.5 * abc[1] / abc[0], x = half + sqrt(half * half - abc[2] / abc[0]);
    f->start = hdr_log2(x / largest);
    f->stop = hdr_log2(x / median);
    f->exposures = (int)fmax(2, ceil(f->stop - f->start));
    return HDR_OK;
}

/* Room for what is found of the reference, if other tests are to come and memory allows. Without it that is found
 * again: no fault. */
static void keep_features(hdr_flip_reference *f, int tests) {
    double bytes = (double)f->columns * f->rows * f->exposures * (double)sizeof *f->kept;
    if (tests > 1 && bytes <= (double)hdr_chain_settings(f->chain)->memory / 2)
        f->kept = hdr_alloc((size_t)f->columns * (size_t)f->rows * (size_t)f->exposures, sizeof *f->kept);
}

static hdr_status prepare(hdr_flip_reference *f, hdr_flip_kind kind, int tests, hdr_error *err) {
    hdr_status status = hdr_input_picture(f->input, f->chain, &f->picture, err);
    if (status != HDR_OK) return status;
    f->encoded = strcmp(f->picture.state, "linear") != 0;
    f->kind = kind != HDR_FLIP_AUTO ? kind : f->encoded ? HDR_FLIP_LDR : HDR_FLIP_HDR;
    if (f->encoded && f->kind == HDR_FLIP_HDR)
        return hdr_fail(err, HDR_BAD_DATA, "HDR-FLIP is of light, and the pictures are encoded (%s)", f->picture.state);
    f->output = hdr_view_pixels(f->chain, f->input, HDR_VIEW_STORED, err);
    if (!f->output) return err->status;
    const hdr_planes *pixels = hdr_output_pixels(f->output);
    f->columns = (pixels->width + HDR_FLIP_SIDE - 1) / HDR_FLIP_SIDE;
    f->rows = (pixels->height + HDR_FLIP_SIDE - 1) / HDR_FLIP_SIDE;
    f->exposures = 1;
    if (f->kind == HDR_FLIP_HDR) status = choose_exposures(f, pixels, err);
    hdr_flip_colours_init(&f->colours);
    if (status == HDR_OK) status = make_filters(&f->filters, f->ppd, err);
    if (status == HDR_OK) keep_features(f, tests);
    return status;
}

hdr_flip_reference *hdr_flip_prepare(const hdr_chain *chain, hdr_input *reference, hdr_flip_kind kind,
                                     double pixels_per_degree, int tests, hdr_error *err) {
    hdr_error unheard = {0};
    if (!err) err = &unheard;
    if (!(pixels_per_degree > 0 && pixels_per_degree <= HDR_FLIP_MOST_PIXELS)) {
        hdr_fail(err, HDR_USAGE, "FLIP needs more than 0 and at most %d pixels per degree", HDR_FLIP_MOST_PIXELS);
        return NULL;
    }
    hdr_flip_reference *f = hdr_alloc(1, sizeof *f);
    if (!f) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        return NULL;
    }
    *f = (hdr_flip_reference){.chain = chain, .input = reference, .ppd = pixels_per_degree};
    if (prepare(f, kind, tests, err) == HDR_OK) return f;
    hdr_flip_reference_free(f);
    return NULL;
}

void hdr_flip_reference_free(hdr_flip_reference *reference) {
    if (!reference) return;
    hdr_output_free(reference->output);
    free(reference->filters.tap);
    free(reference->kept);
    free(reference);
}

/* ---- Figures ---- */

static hdr_status sum_squares(const hdr_flip_reference *f, const double *map, hdr_flip *out, hdr_error *err) {
    out->tiles = f->columns * f->rows;
    out->tile = hdr_alloc((size_t)out->tiles, sizeof *out->tile);
    if (!out->tile) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (int y = 0; y < out->height; y++)
        for (int x = 0; x < out->width; x++) {
            int square = y / HDR_FLIP_SIDE * f->columns + x / HDR_FLIP_SIDE;
            out->tile[square].pixels++;
            out->tile[square].sum += map[(size_t)y * (size_t)out->width + (size_t)x];
        }
    return HDR_OK;
}

static hdr_status sum_up(const hdr_flip_reference *f, const double *map, hdr_flip *out, hdr_error *err) {
    size_t count = (size_t)out->width * (size_t)out->height, largest = 0;
    hdr_status status = sum_squares(f, map, out, err);
    double sum = 0;
    for (int i = 0; i < out->tiles && status == HDR_OK; i++)
        sum += out->tile[i].sum;
    out->mean = sum / (double)count;
    out->min = map[0];
    for (size_t i = 0; i < count; i++) {
        if (map[i] < out->min) out->min = map[i];
        if (map[i] > map[largest]) largest = i;
    }
    out->max = map[largest];
    out->max_x = f->picture.data.min_x + (int)(largest % (size_t)out->width);
    out->max_y = f->picture.data.min_y + (int)(largest / (size_t)out->width);
    for (int q = 0; q < 3 && status == HDR_OK; q++)
        status = hdr_select(map, count, true, 0.25 * (q + 1) * sum, &out->quartile[q], err);
    return status;
}

static hdr_status copy_map(const double *map, hdr_flip *out, hdr_error *err) {
    size_t count = (size_t)out->width * (size_t)out->height;
    out->map = hdr_alloc(count, sizeof *out->map);
    if (!out->map) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (size_t i = 0; i < count; i++)
        out->map[i] = (float)map[i];
    return HDR_OK;
}

hdr_status hdr_flip_compare(hdr_flip_reference *reference, hdr_input *test, bool map, hdr_flip *out, hdr_error *err) {
    hdr_error unheard = {0};
    if (!err) err = &unheard;
    *out = (hdr_flip){.kind = reference->kind,
                      .pixels_per_degree = reference->ppd,
                      .start = reference->start,
                      .stop = reference->stop,
                      .exposures = reference->exposures};
    hdr_status status = hdr_check_alike(reference->chain, test, reference->input, err);
    hdr_output *output = status == HDR_OK ? hdr_view_pixels(reference->chain, test, HDR_VIEW_STORED, err) : NULL;
    if (!output) return err->status;
    comparing c = {.reference = reference, .pixels = {hdr_output_pixels(output), hdr_output_pixels(reference->output)}};
    out->width = c.pixels[TEST]->width;
    out->height = c.pixels[TEST]->height;
    status = compare(&c, err);
    if (status == HDR_OK) status = sum_up(reference, c.map, out, err);
    if (status == HDR_OK && map) status = copy_map(c.map, out, err);
    free(c.map);
    hdr_output_free(output);
    return status;
}

void hdr_flip_free(hdr_flip *flip) {
    if (!flip) return;
    free(flip->tile);
    free(flip->map);
    flip->tile = NULL;
    flip->map = NULL;
}

/* Durand and Dorsey, Fast Bilateral Filtering for the Display of High-Dynamic-Range Images, SIGGRAPH 2002. */
#include "kernel/real.h"
#include "kernel/strip.h"
#include "spatial/bilateral.h"
#include "spatial/ranks.h"

#include "verb/verb.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct durand_params {
    int intensity, method, show;
    const char *sigma_s, *cells; /* as typed: a fraction, or pixels; and AxD, or auto */
    hdr_number sigma_r, contrast, tolerance, subsample;
    hdr_decimal percentile;
    hdr_number saturation;
} durand_params;

enum { INTENSITY_REC709, INTENSITY_DURAND };
static const char *const intensities[] = {"rec709", "durand", NULL};
#define HDR_LOG2_10 3.3219280948873623
enum { SHOW_PICTURE, SHOW_BASE, SHOW_DETAIL };
static const char *const shows[] = {"picture", "base", "detail", NULL};
enum { METHOD_AUTO, METHOD_GRID, METHOD_EXACT, METHOD_DIRECT, METHOD_PIECEWISE };
static const char *const methods[] = {"auto", "grid", "exact", "direct", "piecewise", NULL};
static const char *const automatic[] = {"auto", NULL};

static const hdr_option options[] = {
    {.name = "sigma-s",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(durand_params, sigma_s),
     .metavar = "SIZE",
     .default_value = "0.02",
     .help = "standard deviation in space: a fraction of the picture's larger side, or with px (40px) pixels"},
    {.name = "sigma-r",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(durand_params, sigma_r),
     .metavar = "DECADES",
     .min = 0.01,
     .max = 100,
     .default_value = "0.4",
     .help = "standard deviation in intensity, in units of log10"},
    {.name = "contrast",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(durand_params, contrast),
     .metavar = "RATIO",
     .min = 1,
     .max = 1e30,
     .above_min = true,
     .default_value = "5",
     .help = "what the base layer's contrast is compressed to"},
    {.name = "percentile",
     .type = HDR_OPTION_DECIMAL,
     .offset = offsetof(durand_params, percentile),
     .metavar = "PERCENT",
     .min = 0,
     .max = 50,
     .default_value = "0.1",
     .help = "the base layer's contrast is from this percentile to its counterpart from above"},
    {.name = "intensity",
     .type = HDR_OPTION_CHOICE,
     .offset = offsetof(durand_params, intensity),
     .metavar = "WHICH",
     .words = intensities,
     .default_value = "rec709",
     .help = "luminance, or the paper's (20 R + 40 G + B) / 61"},
    {.name = "method",
     .type = HDR_OPTION_CHOICE,
     .offset = offsetof(durand_params, method),
     .metavar = "METHOD",
     .words = methods,
     .default_value = "auto",
     .help = "how the filter is computed; auto: the cheapest that keeps --tolerance"},
    {.name = "tolerance",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(durand_params, tolerance),
     .metavar = "E",
     .min = 0,
     .max = 10,
     .default_value = "0.001",
     .help = "how far the base layer may be from the exact one, in units of log10"},
    {.name = "subsample",
     .type = HDR_OPTION_INTEGER,
     .offset = offsetof(durand_params, subsample),
     .metavar = "K",
     .min = 1,
     .max = 1000,
     .words = automatic,
     .default_value = "auto",
     .help = "piecewise: on every K-th pixel; auto: 1 to 25, so that sigma-s becomes 2 to 3 of them"},
    {.name = "cells",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(durand_params, cells),
     .metavar = "AxD",
     .default_value = "auto",
     .help = "grid: cells of sigma-s / A by sigma-r / D, each from 2 to 16 (3x4); auto: by --tolerance"},
    {.name = "show",
     .type = HDR_OPTION_CHOICE,
     .offset = offsetof(durand_params, show),
     .metavar = "LAYER",
     .words = shows,
     .default_value = "picture",
     .help = "the picture, or one of its layers: base, its brightest being 1, or detail, around 0.18"},
    {.name = "saturation",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(durand_params, saturation),
     .metavar = "S",
     .min = 0,
     .max = 2,
     .default_value = "1",
     .help = "exponent of C/I: 0 gives grey, 1 keeps chromaticity"},
    {0}};

/* ---- Parameters ---- */

/* The standard deviation in pixels of a picture with that larger side. 0: the text is none. */
static double sigma_in_pixels(const char *text, double larger_side) {
    double number = 0;
    char digits[64];
    size_t length = strlen(text);
    bool pixels = length > 2 && !strcmp(text + length - 2, "px");
    if (pixels) length -= 2;
    if (length >= sizeof digits) return 0;
    memcpy(digits, text, length);
    digits[length] = '\0';
    const char *end = hdr_read_number(digits, &number);
    if (!end || *end || !(number >= (pixels ? 0.1 : 1e-6)) || number > (pixels ? 1e6 : 10)) return 0;
    double sigma = pixels ? number : number * larger_side;
    return sigma > 0.1 ? sigma : 0.1;
}

/* One of the two numbers; `end` must stand behind it. */
static const char *read_cell(const char *text, char end, double *number) {
    char digits[32];
    size_t length = strcspn(text, "x");
    if (length >= sizeof digits || text[length] != end) return NULL;
    memcpy(digits, text, length);
    digits[length] = '\0';
    const char *behind = hdr_read_number(digits, number);
    return behind && !*behind && *number >= 2 && *number <= 16 ? text + length : NULL;
}

/* AxD: the cells of a grid. False: the text is none. */
static bool read_cells(const char *text, double *across, double *deep) {
    const char *behind = read_cell(text, 'x', across);
    return behind && read_cell(behind + 1, '\0', deep);
}

/* Options that only some methods have. */
static const struct belongs {
    const char *option;
    unsigned methods; /* a bit for each */
} belongings[] = {{"tolerance", 1u << METHOD_AUTO | 1u << METHOD_GRID | 1u << METHOD_DIRECT},
                  {"cells", 1u << METHOD_GRID},
                  {"subsample", 1u << METHOD_PIECEWISE}};

static hdr_status check_belongings(const durand_params *p, const hdr_options *given, hdr_error *err) {
    for (int i = 0; i < given->count; i++)
        for (size_t b = 0; b < sizeof belongings / sizeof *belongings; b++)
            if (!strcmp(given->given[i].option->name, belongings[b].option) &&
                !(belongings[b].methods >> p->method & 1))
                return hdr_fail(err, HDR_USAGE, "--%s has no meaning with --method %s", belongings[b].option,
                                methods[p->method]);
    return HDR_OK;
}

/* Cells stand for a tolerance. */
static hdr_status check_cells(const durand_params *p, const hdr_options *given, hdr_error *err) {
    double across, deep;
    if (!strcmp(p->cells, "auto")) return HDR_OK;
    if (!read_cells(p->cells, &across, &deep))
        return hdr_refuse_text(options, "cells", p->cells, "is neither AxD with numbers from 2 to 16, nor auto", err);
    for (int i = 0; i < given->count; i++)
        if (!strcmp(given->given[i].option->name, "tolerance"))
            return hdr_fail(err, HDR_USAGE, "--tolerance has no meaning with --cells %.100s", p->cells);
    return HDR_OK;
}

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const durand_params *p = params;
    if (sigma_in_pixels(p->sigma_s, 1000) == 0)
        return hdr_refuse_text(options, "sigma-s", p->sigma_s,
                               "is neither a fraction (1e-06 to 10) nor pixels (0.1px to 1000000px)", err);
    if (check_cells(p, given, err) != HDR_OK) return HDR_USAGE;
    return check_belongings(p, given, err);
}

/* I = (20 R + 40 G + B) / 61: Durand's web page about the paper. */
static const double durand_weights[3] = {20 / 61.0, 40 / 61.0, 1 / 61.0};

static void needs(const void *params, hdr_request *request) {
    const durand_params *p = params;
    request->facts |= HDR_FACT_LUMINANCE;
    request->plane = true;
    if (p->intensity == INTENSITY_DURAND) request->weights = durand_weights;
}

/* ---- The curves ---- */

/* The filter leaves what is alike everywhere as it is. */
static double durand_alone(double intensity) {
    return hdr_log10(intensity);
}

/* Ld = 10^(c (base - hi) + (i - base)), i = log10 I; c = v[0], hi = v[1]. */
HDR_INLINE double durand_picture_of(const hdr_constants *k, double intensity, double base) {
    double i = hdr_log10(intensity > 0 ? intensity : 1);
    double ld = hdr_exp2((k->v[0] * (base - k->v[1]) + (i - base)) * HDR_LOG2_10);
    return intensity > 0 ? ld : 0;
}
HDR_LOCAL_CURVE(durand_picture, durand_alone)

/* The layers: Ld = 10^(base - hi), and Ld = 0.18 10^(i - base). */
HDR_INLINE double durand_base_of(const hdr_constants *k, double intensity, double base) {
    double ld = hdr_exp2((base - k->v[1]) * HDR_LOG2_10);
    return intensity > 0 ? ld : 0;
}
HDR_LOCAL_CURVE(durand_base, durand_alone)

HDR_INLINE double durand_detail_of(const hdr_constants *k, double intensity, double base) {
    (void)k;
    double i = hdr_log10(intensity > 0 ? intensity : 1);
    double ld = 0.18 * hdr_exp2((i - base) * HDR_LOG2_10);
    return intensity > 0 ? ld : 0;
}
HDR_LOCAL_CURVE(durand_detail, durand_alone)

/* A picture with nothing lit becomes 0. */
HDR_INLINE double durand_dark_of(const hdr_constants *k, double y) {
    (void)k;
    (void)y;
    return 0;
}
HDR_CURVE(durand_dark)

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    (void)err;
    static const hdr_local_curve *const curves[] = {&durand_picture, &durand_base, &durand_detail};
    const durand_params *p = params;
    const hdr_facts *facts = &scene->facts;
    step->saturation = p->saturation.value;
    step->of_light = step->for_display = true;
    if (facts->lit == 0) {
        step->form = HDR_FORM_LUMINANCE;
        step->curve = &durand_dark;
        snprintf(step->note, sizeof step->note, "nothing is lit: 0 everywhere");
        return HDR_RUN;
    }
    step->form = HDR_FORM_LOCAL;
    step->local = curves[p->show];
    step->own_weights = p->intensity == INTENSITY_DURAND;
    memcpy(step->luminance, durand_weights, sizeof durand_weights);
    snprintf(step->note, sizeof step->note, "I from %.9g to %.9g", facts->min_lit, facts->max_luminance);
    return HDR_RUN;
}

/* ---- The surround: the base layer ---- */

/* The plane as it is worked on: i = log10 I, that of a pixel that is not lit being the least; and which pixels are lit.
 */
typedef struct logarithms {
    const hdr_plane *from;
    hdr_plane *to; /* may be the same */
    double least;  /* I of the darkest lit pixel */
    unsigned char *mask;
} logarithms;

HDR_INLINE void log_rows_body(double *values, double least, size_t count) {
    for (size_t i = 0; i < count; i++)
        values[i] = hdr_log10(values[i] > least ? values[i] : least);
}
HDR_VERSIONS_IN(static, log_rows, (double *values, double least, size_t count), (values, least, count))

static hdr_status take_logarithms(void *context, int y, int thread, hdr_error *err) {
    (void)thread, (void)err;
    const logarithms *l = context;
    enum { AT_ONCE = 512 };
    size_t width = (size_t)l->from->width, from = (size_t)y * l->from->stride, to = (size_t)y * l->to->stride;
    unsigned char *mask = l->mask + (size_t)y * hdr_mask_row(l->from->width);
    for (size_t x = 0; x < width; x += AT_ONCE) {
        double values[AT_ONCE];
        size_t count = width - x < AT_ONCE ? width - x : AT_ONCE;
        if (l->from->wide)
            memcpy(values, l->from->wide + from + x, count * sizeof *values);
        else
            hdr_float_to_real(l->from->narrow + from + x, values, count);
        for (size_t i = 0; i < count; i++)
            mask[(x + i) / 8] |= (unsigned char)((values[i] > 0) << (x + i) % 8);
        log_rows(values, l->least, count);
        if (l->to->wide)
            memcpy(l->to->wide + to + x, values, count * sizeof *values);
        else
            hdr_real_to_float(values, l->to->narrow + to + x, count);
    }
    return HDR_OK;
}

static hdr_status filter_piecewise(const durand_params *p, const hdr_bilateral *bilateral, hdr_surroundings *with,
                                   hdr_plane *plane, hdr_error *err) {
    int subsample = p->subsample.word < 0 ? (int)p->subsample.value : hdr_piecewise_subsample(bilateral->sigma_s);
    with->bound =
        fmin(hdr_piecewise_bound(subsample, bilateral->sigma_s) * bilateral->sigma_r, bilateral->high - bilateral->low);
    hdr_bilateral_report report = {0};
    hdr_status status = hdr_bilateral_piecewise(bilateral, subsample, plane, with->pool, &report, err);
    snprintf(with->note, sizeof with->note,
             "piecewise linear in %d segments, subsampled by %d, within %.2g: %llu of %llu values", report.segments,
             subsample, with->bound, (unsigned long long)report.used, (unsigned long long)report.cells);
    return status;
}

/* The sum: of all pixels, or in their places of those alone that are wanted. */
static hdr_status sum_directly(const hdr_bilateral *bilateral, double reach, hdr_surroundings *with, hdr_plane *plane,
                               hdr_error *err) {
    if (!with->pixels) return hdr_bilateral_exact(bilateral, reach, plane, plane, with->pool, err);
    double *values = hdr_alloc((size_t)with->pixel_count, sizeof *values);
    if (!values) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    hdr_status status =
        hdr_bilateral_exact_at(bilateral, reach, plane, with->pixel_count, with->pixels, values, with->pool, err);
    for (int i = 0; i < with->pixel_count && status == HDR_OK; i++) {
        size_t at = (size_t)with->pixels[i].y * plane->stride + (size_t)with->pixels[i].x;
        if (plane->wide)
            plane->wide[at] = values[i];
        else
            plane->narrow[at] = (float)values[i];
    }
    with->partial = true;
    free(values);
    return status;
}

/* What rounding may add in a plane of floats: sums of N and W, their quotient, and the base itself. */
static double float_error(const hdr_bilateral *bilateral, const hdr_plane *plane) {
    return plane->narrow ? 0x1p-22 * fmax(fabs(bilateral->low), fabs(bilateral->high)) : 0;
}

/* What is done with a plane of logarithms. */
static hdr_status filter(const durand_params *p, const hdr_bilateral *bilateral, hdr_surroundings *with,
                         hdr_plane *plane, hdr_error *err) {
    if (with->reference || p->method == METHOD_EXACT) {
        snprintf(with->note, sizeof with->note, "the exact sum, %d standard deviations wide", HDR_EXACT_REACH);
        with->bound = 0;
        return sum_directly(bilateral, HDR_EXACT_REACH, with, plane, err);
    }
    if (p->method == METHOD_PIECEWISE) return filter_piecewise(p, bilateral, with, plane, err);
    hdr_bilateral_choice choice = {.grid = true};
    hdr_bilateral_report report = {0};
    if (read_cells(p->cells, &choice.across, &choice.deep))
        choice.bound = hdr_grid_bound(bilateral, (double)plane->width * plane->height, choice.across, choice.deep);
    else
        choice = hdr_bilateral_choose(bilateral, plane, p->tolerance.value, p->method == METHOD_GRID,
                                      p->method == METHOD_DIRECT);
    if (choice.grid && choice.across == 0)
        return hdr_fail(err, HDR_USAGE, "a grid for these sigmas would be too large: --method direct, or auto");
    with->bound = choice.bound + float_error(bilateral, plane);
    if (choice.grid) {
        hdr_status status = hdr_bilateral_grid(bilateral, choice.across, choice.deep, plane, with->pool, &report, err);
        snprintf(with->note, sizeof with->note,
                 "grid of sigma_s / %g and sigma_r / %g, within %.2g: %llu of %llu cells", choice.across, choice.deep,
                 with->bound, (unsigned long long)report.used, (unsigned long long)report.cells);
        return status;
    }
    snprintf(with->note, sizeof with->note, "direct sum, %.3g standard deviations wide, within %.2g", choice.reach,
             with->bound);
    return sum_directly(bilateral, choice.reach, with, plane, err);
}

/* c = min(1, log10(contrast) / (hi - lo)), with lo and hi the percentiles of the base over lit pixels. */
static hdr_status compress(const durand_params *p, const hdr_plane *base, const unsigned char *mask, uint64_t lit,
                           hdr_step *step, hdr_surroundings *with, hdr_error *err) {
    uint64_t rank[2] = {hdr_nearest_rank(p->percentile, lit),
                        hdr_nearest_rank(hdr_decimal_complement(p->percentile), lit)};
    double ends[2];
    hdr_status status = hdr_plane_ranks(base, mask, 2, rank, ends, with->pool, err);
    if (status != HDR_OK) return status;
    double wanted = hdr_log10(p->contrast.value), range = ends[1] - ends[0];
    step->constants.v[0] = range > wanted ? wanted / range : 1;
    step->constants.v[1] = ends[1];
    size_t used = strlen(with->note);
    snprintf(with->note + used, sizeof with->note - used, "; base from %.6g to %.6g, compressed by %.6g", ends[0],
             ends[1], step->constants.v[0]);
    return HDR_OK;
}

static hdr_status surround(hdr_step *step, hdr_surroundings *with, hdr_error *err) {
    const durand_params *p = with->params;
    const hdr_facts *facts = &with->scene->facts;
    hdr_plane *from = with->luminance;
    int width = from->width, height = from->height;
    bool wide = with->reference || p->method == METHOD_EXACT;
    /* logarithms are taken of what float holds: not of denormal numbers */
    with->too_wide = !from->wide && (wide || facts->min_lit < 0x1p-120 || facts->max_luminance > 0x1p126);
    if (with->too_wide) return HDR_OK;
    with->surround = (from->wide != NULL) == wide ? from : hdr_plane_new(width, height, wide, err);
    if (!with->surround) return HDR_INTERNAL;
    logarithms l = {.from = from, .to = with->surround, .least = facts->min_lit};
    l.mask = hdr_alloc((size_t)height, hdr_mask_row(width));
    hdr_status status = l.mask ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
    if (status == HDR_OK) status = hdr_pool_run(with->pool, height, take_logarithms, &l, err);
    hdr_bilateral bilateral = {.sigma_s = sigma_in_pixels(p->sigma_s, width > height ? width : height),
                               .sigma_r = p->sigma_r.value,
                               .no_skip = with->no_skip,
                               .wanted = with->no_skip ? NULL : l.mask};
    if (status == HDR_OK) status = hdr_plane_range(with->surround, &bilateral.low, &bilateral.high, with->pool, err);
    if (status == HDR_OK && bilateral.high == bilateral.low && !with->no_skip) {
        snprintf(with->note, sizeof with->note, "one intensity everywhere: the base is what it is");
        with->bound = 0;
    } else if (status == HDR_OK) {
        status = filter(p, &bilateral, with, with->surround, err);
    }
    memcpy(with->method, with->note, sizeof with->method);
    if (status == HDR_OK && !with->pixels) status = compress(p, with->surround, l.mask, facts->lit, step, with, err);
    free(l.mask);
    return status;
}

#define DETAILS                                                                                                        \
    "The operator of Durand and Dorsey (SIGGRAPH 2002). The logarithm of intensity is parted in a base layer, the "    \
    "large "                                                                                                           \
    "differences of light, and a detail layer, what is left; the base alone is compressed, so that detail keeps its "  \
    "full "                                                                                                            \
    "contrast. With i = log10 I:\n\n"                                                                                  \
    "base = sum of f(p - s) g(i_p - i_s) i_p, divided by the same sum without i_p, over all pixels p: the bilateral "  \
    "filter, "                                                                                                         \
    "with f and g the Gaussians of standard deviation --sigma-s and --sigma-r. It averages a pixel with those that "   \
    "are near "                                                                                                        \
    "it in the picture and near it in intensity, so that it blurs a wall, and not across its edge. The window is cut " \
    "at the "                                                                                                          \
    "picture's border.\n\n"                                                                                            \
    "c = min(1, log10(CONTRAST) / (hi - lo)), where lo and hi are the percentiles PERCENT and 100 - PERCENT of the "   \
    "base over "                                                                                                       \
    "lit pixels, by nearest rank (0: its minimum and maximum, as printed; then one firefly sets the contrast of the "  \
    "whole "                                                                                                           \
    "picture).\n\n"                                                                                                    \
    "Ld = 10^(c (base - hi) + (i - base)), and C' = C (Ld/I) for each component; with --saturation S, (C/I)^S Ld. hi " \
    "becomes "                                                                                                         \
    "1; what is brighter, and detail on bright ground, may exceed it and is clipped by what writes codes. A pixel "    \
    "that is not "                                                                                                     \
    "lit (I or luminance not above 0) becomes 0, and counts as the darkest lit one in the filter. The result is "      \
    "linear and "                                                                                                      \
    "does not depend on the exposure of the render.\n\n"                                                               \
    "I is luminance, or with --intensity durand the authors' (20 R + 40 G + B) / 61.\n\n"                              \
    "Units. --sigma-s 0.02 is 2 percent of the data window's larger side, so that half the resolution gives the same " \
    "picture; 40px is 40 pixels whatever the size. The larger it is, the larger the features that count as detail. "   \
    "--sigma-r is in powers of ten: edges of more than about twice as much stay in the base and get compressed. Too "  \
    "small "                                                                                                           \
    "(0.1), texture gets into the base and the picture goes flat and grainy; too large (1 and more), the filter "      \
    "becomes a "                                                                                                       \
    "plain blur, and halos stand around edges, as everybody's local contrast filters have them. --contrast 5 makes "   \
    "lit "                                                                                                             \
    "interiors and the view from their windows visible together; 20 to 50 keep more of the light's drama; c = 1 "      \
    "leaves the "                                                                                                      \
    "picture as it is but for the exposure.\n\n"                                                                       \
    "Methods. auto takes the cheapest whose stated error is within --tolerance: of bilateral grids of many cell "      \
    "sizes (Chen, Paris and Durand 2007; here with cubic splines, whose own blur is taken off the grid's), and of "    \
    "the direct sum cut where what lies beyond cannot matter, for a sigma-s of a pixel or two. grid and direct hold "  \
    "it to one kind. What a grid states follows from how splines interpolate and from the crowd that a single pixel "  \
    "may face; its factors are those of a search for the worst among tens of thousands of scenes. 0.001 is a quarter " \
    "of a percent in intensity, about half a code of 8 bits at its worst, usually a hundredth; below 1e-5 the time "   \
    "grows to seconds and more. --explain tells what was chosen, and its bound.\n\n"                                   \
    "exact is the sum itself, in double: a minute or two for a megapixel, and 16 times as much for four. piecewise "   \
    "is the fast algorithm of the paper, which computes the filter for a few intensities and interpolates between "    \
    "them. With --subsample, which it takes by itself, it is the fastest and states no bound: a pixel that is not "    \
    "sampled, a firefly's neighbour, may be off by decades.\n\n"                                                       \
    "--show base and --show detail give the layers as pictures: 10^(base - hi), and 0.18 x 10^(i - base)."

/* A base that is wrong by E makes Ld wrong by (1 - c) E, and where hi and lo are by c E more, in powers of ten. A grid
 * that is asked for is that of --cells, or the finest where none keeps the tolerance. */
static double bound(const void *params) {
    const durand_params *p = params;
    if (p->method == METHOD_PIECEWISE) return INFINITY; /* it may miss what is not sampled */
    double base = p->method == METHOD_EXACT ? 0 : p->tolerance.value > 1e-5 ? p->tolerance.value : 1e-5; /* in float */
    double across = 16, deep = 16;
    bool given = read_cells(p->cells, &across, &deep);
    hdr_bilateral largest = {.sigma_s = 1e6, .sigma_r = p->sigma_r.value, .low = -45, .high = 45};
    double grid = hdr_grid_bound(&largest, 1e12, across, deep);
    if (p->method == METHOD_GRID) base = given ? grid : fmax(base, grid);
    return hdr_pow(10, 2 * base) - 1;
}

static const char *const examples[] = {"hdr durand then png -o OUT.png IN.exr",
                                       "hdr durand --contrast 20 --sigma-s 40px then png -o OUT.png IN.exr",
                                       "hdr durand --show detail then png -o OUT.png IN.exr", NULL};

const hdr_verb hdr_verb_durand = {
    .about = {.name = "durand",
              .summary = "tone map by a bilateral filter that keeps detail",
              .details = DETAILS,
              .examples = examples,
              .options = options,
              .kind = HDR_FILTER},
    .params_size = sizeof(durand_params),
    .check = check,
    .needs = needs,
    .plan = plan,
    .surround = surround,
    .bound = bound,
};

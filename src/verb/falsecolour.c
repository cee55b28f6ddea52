/* False colour: a value's place in a range, as a colour. */
#include "kernel/real.h"
#include "picture/palette.h"
#include "verb/verb.h"

#include <math.h>
#include <stdio.h>

typedef struct falsecolour_params {
    int map, of, scale;
    hdr_number from, to;
    hdr_decimal percentile;
    bool no_legend;
} falsecolour_params;

static const char *const maps[] = {HDR_PALETTE_NAMES, NULL};
static const char *const values[] = {"luminance", "largest", NULL};
enum { OF_LUMINANCE, OF_LARGEST };
static const char *const scales[] = {"linear", "log", NULL};
enum { SCALE_LINEAR, SCALE_LOG };
static const char *const automatic[] = {"auto", NULL};

static const hdr_option options[] = {
    {.name = "map",
     .type = HDR_OPTION_CHOICE,
     .offset = offsetof(falsecolour_params, map),
     .metavar = "MAP",
     .words = maps,
     .default_value = "viridis",
     .help = "the colours, from the smallest value to the largest; coolwarm parts at 0"},
    {.name = "of",
     .type = HDR_OPTION_CHOICE,
     .offset = offsetof(falsecolour_params, of),
     .metavar = "VALUE",
     .words = values,
     .default_value = "luminance",
     .help = "a pixel's value: its luminance, or the component that is farthest from 0"},
    {.name = "scale",
     .type = HDR_OPTION_CHOICE,
     .offset = offsetof(falsecolour_params, scale),
     .metavar = "SCALE",
     .words = scales,
     .default_value = "linear",
     .help = "whether even steps of colour are even differences, or even ratios"},
    {.name = "from",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(falsecolour_params, from),
     .metavar = "V",
     .min = -1e38,
     .max = 1e38,
     .words = automatic,
     .default_value = "auto",
     .help = "the first colour's value"},
    {.name = "to",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(falsecolour_params, to),
     .metavar = "V",
     .min = -1e38,
     .max = 1e38,
     .words = automatic,
     .default_value = "auto",
     .help = "the last colour's value"},
    {.name = "percentile",
     .type = HDR_OPTION_DECIMAL,
     .offset = offsetof(falsecolour_params, percentile),
     .metavar = "PERCENT",
     .min = 50,
     .max = 100,
     .default_value = "100",
     .help = "auto: the range ends at this percentile, and at 100 minus it, so that fireflies do not stretch it"},
    {.name = "no-legend",
     .type = HDR_OPTION_FLAG,
     .offset = offsetof(falsecolour_params, no_legend),
     .help = "draw no legend below a picture of codes"},
    {0}};

/* Of --scale log, so that no ratio of a value and an end overflows. No float is as small. */
#define LEAST_OF_LOG 1e-100

static bool is_given(const hdr_number *number) {
    return number->word < 0;
}

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const falsecolour_params *p = params;
    (void)given;
    bool from = is_given(&p->from), to = is_given(&p->to);
    if (p->scale == SCALE_LOG && ((from && p->from.value < LEAST_OF_LOG) || (to && p->to.value < LEAST_OF_LOG)))
        return hdr_fail(err, HDR_USAGE, "--scale log is for values above 0: --from and --to must be 1e-100 or more");
    if (p->scale == SCALE_LOG && p->map == HDR_PALETTE_COOLWARM && !(from && to))
        return hdr_fail(err, HDR_USAGE, "--map coolwarm parts at 0, which --scale log has not: give --from and --to");
    if (from && to && !(p->from.value < p->to.value))
        return hdr_fail(err, HDR_USAGE, "--from %.17g is not below --to %.17g", p->from.value, p->to.value);
    if (from && to && hdr_decimal_value(p->percentile) != 100)
        return hdr_fail(err, HDR_USAGE, "--percentile has no meaning with both --from and --to");
    return HDR_OK;
}

/* ---- The range ---- */

static bool takes_percentiles(const falsecolour_params *p) {
    return hdr_decimal_value(p->percentile) != 100;
}

static void needs(const void *params, hdr_request *request) {
    const falsecolour_params *p = params;
    if (is_given(&p->from) && is_given(&p->to)) return;
    request->facts |= p->of == OF_LUMINANCE ? HDR_FACT_LUMINANCE : HDR_FACT_COMPONENTS;
    if (!takes_percentiles(p)) return;
    request->percentiles = 2;
    request->percentile[0].of = request->percentile[1].of = p->of == OF_LARGEST     ? HDR_OF_COMPONENTS
                                                            : p->scale == SCALE_LOG ? HDR_OF_LIT
                                                                                    : HDR_OF_LUMINANCE;
    request->percentile[0].percent = hdr_decimal_complement(p->percentile);
    request->percentile[1].percent = p->percentile;
}

/* The smallest value and the largest that are to have a colour of their own. */
static void find_extremes(const falsecolour_params *p, const hdr_facts *facts, double *low, double *high) {
    bool luminance = p->of == OF_LUMINANCE, logarithmic = p->scale == SCALE_LOG;
    double positive = luminance ? facts->min_lit : facts->min_positive_component;
    *low = logarithmic ? positive : luminance ? facts->min_luminance : facts->min_component;
    *high = luminance ? facts->max_luminance : facts->max_component;
    if (!takes_percentiles(p)) return;
    *low = logarithmic && facts->percentile[0] <= 0 ? positive : facts->percentile[0];
    *high = facts->percentile[1];
}

/* A range is never empty: where a picture has but one value it is made to have a width. */
static void choose_range(const falsecolour_params *p, const hdr_facts *facts, double *from, double *to) {
    double low, high;
    bool logarithmic = p->scale == SCALE_LOG;
    find_extremes(p, facts, &low, &high);
    if (p->map == HDR_PALETTE_COOLWARM) {
        high = fabs(low) > fabs(high) ? fabs(low) : fabs(high);
        if (is_given(&p->from) && p->from.value < 0) high = -p->from.value;
        if (is_given(&p->to) && p->to.value > 0) high = p->to.value;
        if (!(high > 0)) high = 1; /* nothing but 0 is neither cool nor warm */
        low = -high;
    } else if (!logarithmic && low > 0) {
        low = 0;
    }
    if (logarithmic && !(high > 0)) high = 1;
    if (logarithmic && !(low > 0)) low = high / 10;
    *from = is_given(&p->from) ? p->from.value : low;
    *to = is_given(&p->to) ? p->to.value : high;
    if (*from < *to) return;
    double fixed = is_given(&p->to) ? *to : *from, least = logarithmic ? 10 : fabs(fixed) > 1 ? fabs(fixed) : 1;
    if (is_given(&p->to))
        *from = logarithmic ? *to / least : *to - least;
    else
        *to = logarithmic ? *from * least : *from + least;
}

/* ---- Colours ---- */

/* The part of the range that lies below a value: (x - from) / (to - from); from = v[0], to - from = v[1]. */
HDR_INLINE double linear_place_of(const hdr_constants *k, double value) {
    return (value - k->v[0]) / k->v[1];
}
HDR_CURVE_MONOTONE(linear_place)

/* log(x / from) / log(to / from), and 0 where that is below 0; from = v[0], the denominator = v[1]. */
HDR_INLINE double log_place_of(const hdr_constants *k, double value) {
    double part = value > k->v[0] ? value / k->v[0] : 1;
    return hdr_log(part) / k->v[1];
}
HDR_CURVE(log_place)

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    (void)err;
    const falsecolour_params *p = params;
    double from = p->from.value, to = p->to.value;
    if (!is_given(&p->from) || !is_given(&p->to)) choose_range(p, &scene->facts, &from, &to);
    bool logarithmic = p->scale == SCALE_LOG;
    step->form = HDR_FORM_PALETTE;
    step->palette = hdr_palette(p->map);
    step->curve = logarithmic ? &log_place : &linear_place;
    step->constants.v[0] = from;
    step->constants.v[1] = logarithmic ? hdr_log(to / from) : to - from;
    step->of_largest = p->of == OF_LARGEST;
    step->for_display = true;
    if (!p->no_legend) step->legend = (hdr_legend){step->palette, from, to, logarithmic};
    snprintf(step->state, sizeof step->state, "srgb");
    snprintf(step->note, sizeof step->note, "%s of %s from %.9g to %.9g%s", maps[p->map],
             p->of == OF_LUMINANCE ? "luminance" : "the largest component", from, to,
             logarithmic ? ", by its logarithm" : "");
    return HDR_RUN;
}

static const char *const examples[] = {"hdr falsecolour -o OUT.png IN.exr",
                                       "hdr falsecolour --scale log --percentile 99.9 --map inferno -o OUT.png IN.exr",
                                       "hdr diff then falsecolour --of largest --map coolwarm -o OUT.png IN.exr IN.exr",
                                       NULL};

const hdr_verb hdr_verb_falsecolour = {
    .about =
        {.name = "falsecolour",
         .summary = "show how large values are by colours, with a legend",
         .details =
             "Every pixel becomes one of 256 colours, by its value x: the luminance, or with --of largest the colour "
             "component that is farthest from 0, with its sign. The colour's number is 256 (x - from) / (to - from), "
             "rounded down, and with --scale log 256 log(x / from) / log(to / from); what lies outside has the first "
             "or the last colour. Colours are sRGB's, and the picture counts as encoded from then on.\n\n"
             "--from and --to are, if auto, the smallest value and the largest, or their --percentile by nearest rank; "
             "linear, a smallest value above 0 becomes 0, and with coolwarm the range reaches as far to either side of "
             "0, as far as the one that is given, if one is. With --scale log they are of values above 0, and all "
             "others have the first colour. A picture "
             "of one value has a range all the same, which the legend tells.\n\n"
             "viridis, magma, inferno and plasma grow lighter in even steps, and are told apart without colour vision, "
             "too. coolwarm is for differences with a sign: blue below 0, red above, white between.\n\n"
             "Below a picture of codes (png) a legend is drawn: the colours with their values, as many as fit. Other "
             "formats and --no-legend have none; --explain tells the range in any case.",
         .examples = examples,
         .options = options,
         .kind = HDR_FILTER},
    .params_size = sizeof(falsecolour_params),
    .check = check,
    .needs = needs,
    .plan = plan,
};

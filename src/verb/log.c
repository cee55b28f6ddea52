/* Logarithmic curves. */
#include "kernel/real.h"
#include "verb/verb.h"

#include <stdio.h>
#include <string.h>

typedef struct log_params {
    int mode;
    hdr_number k;
    hdr_decimal percentile;
    hdr_luminance_params luminance;
    hdr_shot shot;
} log_params;

static const char *const modes[] = {"shifted", "range", "literal", NULL};
enum { MODE_SHIFTED, MODE_RANGE, MODE_LITERAL };
static const char *const automatic[] = {"auto", NULL};

static const hdr_option options[] = {{.name = "mode",
                                      .type = HDR_OPTION_CHOICE,
                                      .offset = offsetof(log_params, mode),
                                      .metavar = "MODE",
                                      .words = modes,
                                      .default_value = "shifted",
                                      .help = "which logarithm"},
                                     {.name = "k",
                                      .type = HDR_OPTION_NUMBER,
                                      .offset = offsetof(log_params, k),
                                      .metavar = "K",
                                      .min = 0,
                                      .max = 1e250,
                                      .above_min = true,
                                      .words = automatic,
                                      .default_value = "auto",
                                      .help = "shifted: factor on luminance; auto is 1 / log-average"},
                                     {.name = "percentile",
                                      .type = HDR_OPTION_DECIMAL,
                                      .offset = offsetof(log_params, percentile),
                                      .metavar = "PERCENT",
                                      .min = 0,
                                      .max = 50,
                                      .default_value = "0.1",
                                      .help = "range: the percentile that becomes 0; 100 minus it becomes 1"},
                                     HDR_LUMINANCE_OPTIONS(log_params),
                                     HDR_FACTS_OPTION(log_params),
                                     {0}};

/* Options of one mode that are given with another would be ignored in silence. */
static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const log_params *p = params;
    for (int i = 0; i < given->count; i++) {
        const char *name = given->given[i].option->name;
        bool fits = !strcmp(name, "mode")         ? true
                    : !strcmp(name, "k")          ? p->mode == MODE_SHIFTED
                    : !strcmp(name, "facts")      ? p->mode == MODE_SHIFTED
                    : !strcmp(name, "percentile") ? p->mode == MODE_RANGE
                                                  : p->mode != MODE_LITERAL;
        if (!fits) return hdr_fail(err, HDR_USAGE, "--%s has no meaning with --mode %s", name, modes[p->mode]);
    }
    return HDR_OK;
}

static void needs(const void *params, hdr_request *request) {
    const log_params *p = params;
    switch (p->mode) {
    case MODE_SHIFTED:
        request->facts |= HDR_FACT_LUMINANCE;
        break;
    case MODE_RANGE:
        request->percentiles = 2;
        request->percentile[0].of = request->percentile[1].of = HDR_OF_LIT;
        request->percentile[0].percent = p->percentile;
        request->percentile[1].percent = hdr_decimal_complement(p->percentile);
        break;
    case MODE_LITERAL:
        request->facts |= HDR_FACT_COMPONENTS;
        break;
    }
}

/* Ld = ln(1 + k Y) / ln(1 + k Ymax); k = v[0], the denominator = v[1]. Reinhard et al., High Dynamic Range Imaging, 2nd
 * ed. 2010, ch. 8: logarithmic mapping. */
HDR_INLINE double log_shifted_of(const hdr_constants *k, double y) {
    double lit = y > 0 ? y : 0;
    return hdr_log1p(k->v[0] * lit) / k->v[1];
}
HDR_CURVE(log_shifted)

/* Ld = (log10 Y - lo) / (hi - lo), held to [0,1]; 10^lo = v[0], ln(10^(hi - lo)) = v[1]. Y is divided before the
 * logarithm, since the difference of two rounded logarithms loses the digits of a Y close to 10^lo. */
HDR_INLINE double log_range_of(const hdr_constants *k, double y) {
    double lit = y > 0 ? y : k->v[0];
    double ld = hdr_log(lit / k->v[0]) / k->v[1];
    double raised = ld > 0 ? ld : 0;
    double held = raised < 1 ? raised : 1;
    return y > 0 ? held : 0;
}
HDR_CURVE(log_range)

/* The same where hi = lo: 1 where log10 Y >= lo, else 0; 10^lo = v[0] > 0. Percentiles are of Y
 * rounded to float32, and so is Y here: a picture of one colour is all lo, and not below it by what was rounded off. */
HDR_INLINE double log_step_of(const hdr_constants *k, double y) {
    return (double)(float)y >= k->v[0] ? 1 : 0;
}
HDR_CURVE(log_step)

/* C' = ln C, C floored at the smallest positive component = v[0]. */
HDR_INLINE double log_literal_of(const hdr_constants *k, double c) {
    double floored = c > k->v[0] ? c : k->v[0];
    return hdr_log(floored);
}
HDR_CURVE(log_literal)

/* A picture with nothing to take the logarithm of becomes 0. */
HDR_INLINE double log_dark_of(const hdr_constants *k, double y) {
    (void)k;
    (void)y;
    return 0;
}
HDR_CURVE(log_dark)

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    (void)err;
    const log_params *p = params;
    const hdr_facts *facts = &scene->facts;
    double *v = step->constants.v;
    hdr_luminance_form(&p->luminance, step);
    step->of_light = true;
    step->for_display = p->mode != MODE_LITERAL;
    bool dark = false;
    switch (p->mode) {
    case MODE_SHIFTED:
        dark = facts->lit == 0;
        if (dark) break;
        v[0] = p->k.word < 0 ? p->k.value : 1 / facts->log_average;
        /* far below, the curve is Y / Ymax to every digit, while k Ymax would underflow to 0 / 0 */
        if (v[0] < 1e-100) v[0] = 1e-100;
        v[1] = hdr_log1p(v[0] * facts->max_luminance);
        step->curve = &log_shifted;
        snprintf(step->note, sizeof step->note, "k = %.9g, Ymax = %.9g", v[0], facts->max_luminance);
        break;
    case MODE_RANGE:
        dark = facts->percentile[0] <= 0;
        if (dark) break;
        v[0] = facts->percentile[0];
        v[1] = hdr_log(facts->percentile[1] / facts->percentile[0]);
        step->curve = v[1] > 0 ? &log_range : &log_step;
        snprintf(step->note, sizeof step->note, "Y from %.9g to %.9g", facts->percentile[0], facts->percentile[1]);
        break;
    case MODE_LITERAL:
        step->form = HDR_FORM_CHANNEL;
        dark = facts->min_positive_component <= 0;
        if (dark) break;
        v[0] = facts->min_positive_component;
        step->curve = &log_literal;
        snprintf(step->note, sizeof step->note, "smallest positive component %.9g", v[0]);
        break;
    }
    if (dark) {
        step->curve = &log_dark;
        snprintf(step->note, sizeof step->note, "nothing is lit: 0 everywhere");
    }
    return HDR_RUN;
}

static const char *const examples[] = {"hdr log then png -o OUT.png IN.exr",
                                       "hdr log --mode range --percentile 1 then png -o OUT.png IN.exr",
                                       "hdr log --mode literal -o OUT.exr IN.exr", NULL};

const hdr_verb hdr_verb_log = {
    .about = {.name = "log",
              .summary = "tone map by a logarithmic curve",
              .details =
                  "--mode shifted: Ld = ln(1 + k Y) / ln(1 + k Ymax), where Y is luminance and Ymax its maximum. By "
                  "default k = 1/Yavg "
                  "with Yavg = exp(mean of ln Y) over the lit pixels, so that the result does not depend on the "
                  "exposure of the "
                  "render.\n\n"
                  "--mode range: Ld = (log10 Y - lo) / (hi - lo), held to [0,1]; lo and hi are the --percentile of "
                  "log10 Y over lit "
                  "pixels and its counterpart from above, by nearest rank. Where hi = lo, Ld is 1 for log10 Y >= lo, "
                  "else 0; Y is rounded to float32 for this as it is for percentiles, so that a picture of one colour "
                  "is not black by what was rounded off.\n\n"
                  "--mode literal: C' = ln C for each channel, with C raised to the smallest positive component of the "
                  "picture first. "
                  "The result is not held to any range; it is of use for looking at, or as input of other programs.\n\n"
                  "In the first two modes colours keep their chromaticity: C' = (C/Y)^S Ld, with S = --saturation, and "
                  "a pixel whose "
                  "luminance is not above 0 becomes 0. With --per-channel the curve is applied to each channel as if "
                  "it were Y." HDR_FACTS_DETAILS,
              .examples = examples,
              .options = options,
              .kind = HDR_FILTER},
    .params_size = sizeof(log_params),
    .check = check,
    .needs = needs,
    .plan = plan,
};

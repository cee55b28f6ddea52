/* Divide by the maximum: the brightest value of the picture becomes 1. */
#include "verb/verb.h"

#include <stdio.h>

typedef struct divmax_params {
    int of;
    hdr_decimal percentile;
} divmax_params;

static const char *const populations[] = {"channels", "luminance", NULL};
enum { OF_CHANNELS, OF_LUMINANCE };

static const hdr_option options[] = {{.name = "of",
                                      .type = HDR_OPTION_CHOICE,
                                      .offset = offsetof(divmax_params, of),
                                      .metavar = "WHAT",
                                      .words = populations,
                                      .default_value = "channels",
                                      .help = "take the maximum of all components, or of luminance"},
                                     {.name = "percentile",
                                      .type = HDR_OPTION_DECIMAL,
                                      .offset = offsetof(divmax_params, percentile),
                                      .metavar = "PERCENT",
                                      .min = 0,
                                      .max = 100,
                                      .default_value = "100",
                                      .help = "divide by this percentile instead of the maximum"},
                                     {0}};

static void needs(const void *params, hdr_request *request) {
    const divmax_params *p = params;
    request->percentiles = 1;
    request->percentile[0].of = p->of == OF_CHANNELS ? HDR_OF_COMPONENTS : HDR_OF_LUMINANCE;
    request->percentile[0].percent = p->percentile;
    /* the 100th percentile is the maximum, which is cheaper, and of luminance exact where the percentile is a float32
     */
    if (hdr_decimal_value(p->percentile) == 100) {
        request->percentiles = 0;
        request->facts = p->of == OF_CHANNELS ? HDR_FACT_COMPONENTS : HDR_FACT_LUMINANCE;
    }
}

/* C' = C / M; M = v[0] > 0. */
HDR_INLINE double divide_of(const hdr_constants *k, double c) {
    return c / k->v[0];
}
HDR_CURVE_MONOTONE(divide)

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    (void)err;
    const divmax_params *p = params;
    const hdr_facts *facts = &scene->facts;
    double maximum = hdr_decimal_value(p->percentile) != 100 ? facts->percentile[0]
                     : p->of == OF_CHANNELS                  ? facts->max_component
                                                             : facts->max_luminance;
    step->form = HDR_FORM_CHANNEL;
    step->curve = &divide;
    step->of_light = step->for_display = true;
    step->constants.v[0] = maximum > 0 ? maximum : 1;
    snprintf(step->note, sizeof step->note, maximum > 0 ? "M = %.9g" : "M = %.9g is not above 0: unchanged", maximum);
    return maximum > 0 && maximum != 1 ? HDR_RUN : HDR_SKIP;
}

static const char *const examples[] = {
    "hdr divmax then png -o OUT.png IN.exr",
    "hdr divmax --of luminance --percentile 99.9 then clamp then png -o OUT.png IN.exr", NULL};

const hdr_verb hdr_verb_divmax = {
    .about =
        {.name = "divmax",
         .summary = "divide a picture by its maximum",
         .details =
             "Divides every colour component C by M, the largest component of the picture: C' = C / M. With --of "
             "luminance, M is "
             "the largest luminance.\n\n"
             "With --percentile, M is that percentile by nearest rank of all components, or of the luminance of all "
             "pixels, so that a few fireflies do not darken the picture. Values above M then exceed 1.\n\n"
             "Where M is not above 0 the picture stays as it is.",
         .examples = examples,
         .options = options,
         .kind = HDR_FILTER},
    .params_size = sizeof(divmax_params),
    .needs = needs,
    .plan = plan,
};

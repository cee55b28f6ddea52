/* The exponential curve: exposure of film without a toe. */
#include "kernel/real.h"
#include "verb/verb.h"

#include <stdio.h>

typedef struct exp_params {
    hdr_number k;
    hdr_luminance_params luminance;
    hdr_shot shot;
} exp_params;

static const char *const automatic[] = {"auto", NULL};

static const hdr_option options[] = {{.name = "k",
                                      .type = HDR_OPTION_NUMBER,
                                      .offset = offsetof(exp_params, k),
                                      .metavar = "K",
                                      .min = 0,
                                      .max = 1e250,
                                      .above_min = true,
                                      .words = automatic,
                                      .default_value = "auto",
                                      .help = "factor on luminance; auto is 1 / log-average"},
                                     HDR_LUMINANCE_OPTIONS(exp_params),
                                     HDR_FACTS_OPTION(exp_params),
                                     {0}};

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    (void)given;
    const exp_params *p = params;
    if (!p->shot.given || p->k.word == 0) return HDR_OK;
    return hdr_fail(err, HDR_USAGE, "--facts has no meaning with a number for --k");
}

static void needs(const void *params, hdr_request *request) {
    const exp_params *p = params;
    /* with --per-channel a picture with nothing lit may have positive components, and becomes 0 all the same */
    if (p->k.word == 0 || p->luminance.per_channel) request->facts |= HDR_FACT_LUMINANCE;
}

/* Ld = 1 - exp(-k Y); k = v[0]. Reinhard et al., High Dynamic Range Imaging, 2nd ed. 2010, ch. 8: the exponential
 * operator. */
HDR_INLINE double exponential_of(const hdr_constants *k, double y) {
    double lit = y > 0 ? y : 0;
    return hdr_one_minus_exp_neg(k->v[0] * lit);
}
HDR_CURVE(exponential)

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    (void)err;
    const exp_params *p = params;
    bool dark = (scene->facts.known & HDR_FACT_LUMINANCE) && scene->facts.lit == 0;
    hdr_luminance_form(&p->luminance, step);
    step->of_light = step->for_display = true;
    step->curve = &exponential;
    step->constants.v[0] = dark ? 0 : p->k.word < 0 ? p->k.value : 1 / scene->facts.log_average;
    if (dark)
        snprintf(step->note, sizeof step->note, "nothing is lit: 0 everywhere");
    else
        snprintf(step->note, sizeof step->note, "k = %.9g", step->constants.v[0]);
    return HDR_RUN;
}

static const char *const examples[] = {"hdr exp then png -o OUT.png IN.exr",
                                       "hdr exp --k 2 --saturation 0.8 then png -o OUT.png IN.exr", NULL};

const hdr_verb hdr_verb_exp = {
    .about =
        {.name = "exp",
         .summary = "tone map by the exponential curve",
         .details =
             "Ld = 1 - exp(-k Y), where Y is luminance. By default k = 1/Yavg with Yavg = exp(mean of ln Y) over the "
             "lit "
             "pixels, so that the result does not depend on the exposure of the render.\n\n"
             "Colours keep their chromaticity: C' = (C/Y)^S Ld, with S = --saturation. A pixel whose luminance is not "
             "above 0 becomes 0. With --per-channel the curve is applied to each channel as if it were "
             "Y." HDR_FACTS_DETAILS,
         .examples = examples,
         .options = options,
         .kind = HDR_FILTER},
    .params_size = sizeof(exp_params),
    .check = check,
    .needs = needs,
    .plan = plan,
};

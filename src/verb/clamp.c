/* Clamp: hold every component between two values. */
#include "verb/verb.h"

#include <stdio.h>

typedef struct clamp_params {
    hdr_number min, max;
} clamp_params;

static const hdr_option options[] = {{.name = "min",
                                      .type = HDR_OPTION_NUMBER,
                                      .offset = offsetof(clamp_params, min),
                                      .metavar = "LO",
                                      .default_value = "0",
                                      .help = "the smallest value that may come out"},
                                     {.name = "max",
                                      .type = HDR_OPTION_NUMBER,
                                      .offset = offsetof(clamp_params, max),
                                      .metavar = "HI",
                                      .default_value = "1",
                                      .help = "the largest value that may come out"},
                                     {0}};

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    (void)given;
    const clamp_params *p = params;
    if (p->min.value <= p->max.value) return HDR_OK;
    return hdr_fail(err, HDR_USAGE, "--min %.9g is above --max %.9g", p->min.value, p->max.value);
}

/* C' = min(max(C, lo), hi); lo = v[0], hi = v[1]. */
HDR_INLINE double clamp_of(const hdr_constants *k, double c) {
    double raised = c > k->v[0] ? c : k->v[0];
    return raised < k->v[1] ? raised : k->v[1];
}
HDR_CURVE_MONOTONE(clamp)

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    (void)err;
    const clamp_params *p = params;
    step->form = HDR_FORM_CHANNEL;
    step->curve = &clamp;
    step->for_display = p->max.value <= 1;
    step->constants.v[0] = p->min.value;
    step->constants.v[1] = p->max.value;
    snprintf(step->note, sizeof step->note, "to [%.9g, %.9g]", p->min.value, p->max.value);
    const hdr_facts *facts = &scene->facts;
    /* strictly above a lower bound of 0: clamping turns -0 into 0 */
    if (!(facts->known & HDR_FACT_COMPONENTS) || facts->min_component <= p->min.value ||
        facts->max_component > p->max.value)
        return HDR_RUN;
    snprintf(step->note, sizeof step->note, "nothing is outside [%.9g, %.9g]", p->min.value, p->max.value);
    return HDR_SKIP;
}

static const char *const examples[] = {"hdr clamp then png -o OUT.png IN.exr",
                                       "hdr clamp --max 100 then log then png -o OUT.png IN.exr", NULL};

const hdr_verb hdr_verb_clamp = {
    .about = {.name = "clamp",
              .summary = "hold every component between two values",
              .details = "C' = min(max(C, LO), HI) for each colour component.",
              .examples = examples,
              .options = options,
              .kind = HDR_FILTER},
    .params_size = sizeof(clamp_params),
    .check = check,
    .plan = plan,
};

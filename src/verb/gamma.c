/* Power-law encoding. */
#include "kernel/real.h"
#include "verb/verb.h"

#include <stdio.h>

typedef struct gamma_params {
    hdr_number exponent;
    hdr_encoding_params encoding;
} gamma_params;

static const hdr_option options[] = {{.name = "exponent",
                                      .letter = 'g',
                                      .type = HDR_OPTION_NUMBER,
                                      .offset = offsetof(gamma_params, exponent),
                                      .metavar = "G",
                                      .min = 0,
                                      .max = 1e6,
                                      .above_min = true,
                                      .default_value = "2.2",
                                      .help = "the exponent: C^(1/G), or C^G with --decode"},
                                     HDR_ENCODING_OPTIONS(gamma_params),
                                     {0}};

/* C' = max(C, 0)^p; p = v[0]. */
HDR_INLINE double power_of(const hdr_constants *k, double c) {
    double positive = c > 0 ? c : 0;
    return hdr_pow(positive, k->v[0]);
}
HDR_CURVE(power)

/* p = 1: C' = max(C, 0), exactly. */
HDR_INLINE double positive_of(const hdr_constants *k, double c) {
    (void)k;
    return c > 0 ? c : 0;
}
HDR_CURVE_MONOTONE(positive)

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    const gamma_params *p = params;
    double g = p->exponent.value;
    char state[sizeof step->state];
    snprintf(state, sizeof state, "gamma %.15g", g);
    const hdr_curve *curve = g == 1 ? &positive : &power;
    if (hdr_encoding_step(&p->encoding, curve, curve, state, scene, step, err) == HDR_REFUSE) return HDR_REFUSE;
    step->constants.v[0] = p->encoding.decode ? g : 1 / g;
    snprintf(step->note, sizeof step->note, "C^%.9g", step->constants.v[0]);
    const hdr_facts *facts = &scene->facts;
    return g == 1 && (facts->known & HDR_FACT_COMPONENTS) && facts->min_component > 0 ? HDR_SKIP : HDR_RUN;
}

static const char *const examples[] = {"hdr exp then gamma -g 2.2 then png -o OUT.png IN.exr",
                                       "hdr clamp then gamma --exponent=1.8 then quantise then png -o OUT.png IN.exr",
                                       NULL};

const hdr_verb hdr_verb_gamma = {
    .about = {.name = "gamma",
              .summary = "encode by a power law",
              .details = "C' = max(C, 0)^(1/G) for each colour component; with --decode, C' = max(C, 0)^G.\n\n"
                         "Pure gamma 2.2 is not the sRGB curve: they differ by up to 8.5 codes of 255 in the shadows. "
                         "A PNG made of it "
                         "carries a gAMA chunk that says so." HDR_ENCODING_DETAILS,
              .examples = examples,
              .options = options,
              .kind = HDR_FILTER},
    .params_size = sizeof(gamma_params),
    .plan = plan,
};

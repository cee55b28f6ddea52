/* Quantisation to codes. */
#include "verb/verb.h"

#include <math.h>
#include <stdio.h>

typedef struct quantise_params {
    hdr_number bits;
} quantise_params;

static const hdr_option options[] = {{.name = "bits",
                                      .type = HDR_OPTION_INTEGER,
                                      .offset = offsetof(quantise_params, bits),
                                      .metavar = "BITS",
                                      .min = 1,
                                      .max = 16,
                                      .default_value = "8",
                                      .help = "bits of a code"},
                                     {0}};

/* code = floor(v (2^b - 1) + 1/2), v held to [0,1]; C' = code / (2^b - 1) = v[0]. The PNG specification, 3rd ed.
 * 2023, 13.12: sample depth rescaling rounds to nearest so. */
HDR_INLINE double quantise_of(const hdr_constants *k, double c) {
    double raised = c > 0 ? c : 0;
    double held = raised < 1 ? raised : 1;
    return floor(held * k->v[0] + 0.5) / k->v[0];
}
HDR_CURVE_MONOTONE(quantise)

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    (void)scene;
    (void)err;
    const quantise_params *p = params;
    step->form = HDR_FORM_CHANNEL;
    step->curve = &quantise;
    step->bits = (int)p->bits.value;
    step->constants.v[0] = (double)((1 << step->bits) - 1);
    snprintf(step->note, sizeof step->note, "%d bits", step->bits);
    return HDR_RUN;
}

static const char *const examples[] = {"hdr exp then srgb then quantise --bits 5 then png -o OUT.png IN.exr", NULL};

const hdr_verb hdr_verb_quantise = {
    .about = {.name = "quantise",
              .summary = "round to codes of a number of bits",
              .details =
                  "code = floor(C (2^b - 1) + 1/2), with C held to [0,1] and b = --bits; what stays in the chain is "
                  "code / (2^b - 1).\n\n"
                  "It is for encoded pictures (see hdr-srgb and hdr-gamma): linear values of 8 bits show steps in the "
                  "shadows, "
                  "which is said on standard error. A PNG quantises by itself; give this verb to have fewer bits.",
              .examples = examples,
              .options = options,
              .kind = HDR_FILTER},
    .params_size = sizeof(quantise_params),
    .plan = plan,
};

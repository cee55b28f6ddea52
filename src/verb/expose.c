/* Exposure: multiply by a power of two, in photographic stops. */
#include "kernel/real.h"
#include "verb/verb.h"

#include <stdio.h>
#include <string.h>

typedef struct expose_params {
    hdr_number ev;
    bool automatic;
    hdr_shot shot;
} expose_params;

static const hdr_option options[] = {{.name = "ev",
                                      .type = HDR_OPTION_NUMBER,
                                      .offset = offsetof(expose_params, ev),
                                      .metavar = "STOPS",
                                      .min = -300,
                                      .max = 300,
                                      .default_value = "0",
                                      .help = "multiply by 2 to this power"},
                                     {.name = "auto",
                                      .type = HDR_OPTION_FLAG,
                                      .offset = offsetof(expose_params, automatic),
                                      .help = "choose the stops that bring the log-average of luminance to 0.18"},
                                     HDR_FACTS_OPTION(expose_params),
                                     {0}};

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const expose_params *p = params;
    for (int i = 0; i < given->count; i++)
        if (p->automatic && !strcmp(given->given[i].option->name, "ev"))
            return hdr_fail(err, HDR_USAGE, "--auto chooses the stops itself: leave out --ev, or add a second expose");
    if (p->shot.given && !p->automatic) return hdr_fail(err, HDR_USAGE, "--facts has no meaning without --auto");
    return HDR_OK;
}

static void needs(const void *params, hdr_request *request) {
    const expose_params *p = params;
    if (p->automatic) request->facts |= HDR_FACT_LUMINANCE;
}

/* C' = C 2^ev; 2^ev = v[0]. */
HDR_INLINE double multiply_of(const hdr_constants *k, double c) {
    return c * k->v[0];
}
HDR_CURVE_MONOTONE(multiply)

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    (void)err;
    const expose_params *p = params;
    const hdr_facts *facts = &scene->facts;
    bool dark = p->automatic && facts->lit == 0;
    double factor = !p->automatic ? hdr_exp2(p->ev.value) : dark ? 1 : 0.18 / facts->log_average;
    step->form = HDR_FORM_CHANNEL;
    step->curve = &multiply;
    step->of_light = p->automatic; /* any factor may be meant, but not that an average of codes be a middle grey */
    step->constants.v[0] = factor;
    if (factor == 1) {
        snprintf(step->note, sizeof step->note, "%s", dark ? "nothing is lit" : "ev = 0");
        return HDR_SKIP;
    }
    if (p->automatic)
        snprintf(step->note, sizeof step->note, "ev = %.9g, from the log-average %.9g", hdr_log2(factor),
                 facts->log_average);
    else
        snprintf(step->note, sizeof step->note, "ev = %.9g", p->ev.value);
    return HDR_RUN;
}

static const char *const examples[] = {"hdr expose --ev -1.5 then png -o OUT.png IN.exr",
                                       "hdr expose --auto then clamp then png -o OUT.png IN.exr", NULL};

const hdr_verb hdr_verb_expose = {
    .about =
        {.name = "expose",
         .summary = "change the exposure by stops",
         .details =
             "Multiplies every colour component by 2 to the power of --ev: C' = C 2^ev.\n\n"
             "With --auto, ev = log2(0.18 / Yavg), where Yavg = exp(mean of ln Y) over the lit pixels: those whose "
             "luminance Y is above 0. A picture with nothing lit stays as it is." HDR_FACTS_DETAILS,
         .examples = examples,
         .options = options,
         .kind = HDR_FILTER},
    .params_size = sizeof(expose_params),
    .check = check,
    .needs = needs,
    .plan = plan,
};

/* Skeleton: a small verb that works, as a template for new ones. It fades every component towards one value.
 *
 * To make a verb of your own, say `mist`:
 *   1. Copy this file to src/verb/mist.c and replace `skeleton` by `mist` in it.
 *   2. Add the line HDR_VERB(mist) to src/verb/verbs.def, where it is to stand in the manual.
 *   3. make && build/hdr mist --help && make man
 * There is no fourth step: command line, help, manual page, pipes, threads, --explain, --reference and the tests over
 * the registry find the verb by that line. This file itself has no such line and is left out of the library; its test
 * (tests/cli/test_skeleton.sh) adds one in a copy of the list.
 *
 * A verb never sees a file, a thread or a pixel's neighbours. It declares its options, says which facts about the
 * picture it wants to know, and turns both into a formula on one number; the chain does the rest. */
#include "verb/verb.h"

#include <stdio.h>

/* ---- Options ------------------------------------------------------------------------------------------------------
 * What the options hold once they are parsed. Which C type belongs to which kind of option: base/options.h. */
typedef struct skeleton_params {
    hdr_number amount;
    hdr_number to;
} skeleton_params;

/* Words that --to takes beside numbers; hdr_number.word is the index into this list, or -1 for a number. */
static const char *const targets[] = {"max", NULL};
enum { TO_MAX };

/* The table is the only place where an option exists: parser, help and manual are made from it, and refuse what is out
 * of range before plan() is asked. The default is text, as somebody would type it. The help line has no full stop. No
 * option of every verb may have the same name or letter: `hdr skeleton --help` lists those at its end. */
static const hdr_option options[] = {{.name = "amount",
                                      .letter = 'a',
                                      .type = HDR_OPTION_NUMBER,
                                      .offset = offsetof(skeleton_params, amount),
                                      .metavar = "A",
                                      .min = 0,
                                      .max = 1,
                                      .default_value = "0.5",
                                      .help = "how far to go: 0 changes nothing, 1 leaves only the target"},
                                     {.name = "to",
                                      .type = HDR_OPTION_NUMBER,
                                      .offset = offsetof(skeleton_params, to),
                                      .metavar = "VALUE",
                                      .min = -65504,
                                      .max = 65504,
                                      .words = targets,
                                      .default_value = "1",
                                      .help = "the target; max is the picture's largest component"},
                                     {0}}; /* the table's end */

/* ---- Facts --------------------------------------------------------------------------------------------------------
 * Facts cost a sweep over the picture, so they are asked for only where the options make them necessary. They are those
 * of the picture as it reaches this verb, behind all verbs before it. picture/facts.h lists what there is. A verb that
 * needs none leaves this function out. */
static void needs(const void *params, hdr_request *request) {
    const skeleton_params *p = params;
    if (p->to.word == TO_MAX) request->facts |= HDR_FACT_COMPONENTS;
}

/* ---- The formula --------------------------------------------------------------------------------------------------
 * C' = (1 - A) C + A T; 1 - A = v[0], A T = v[1]. It has to give a number for every finite float, and to be monotone.
 * The function is called NAME_of, is inline, and knows nothing but its two arguments: from it HDR_CURVE(NAME) makes
 * both the exact evaluation and the loop over rows, for every processor. For powers, logarithms and exponentials use
 * those of kernel/real.h, which are the same on every machine. Name the paper and the equation here.
 *
 * HDR_CURVE_MONOTONE, because a product with a number that is not negative, and a sum, cannot fall when C rises, even
 * rounded; where that is not certain, HDR_CURVE. */
HDR_INLINE double fade_of(const hdr_constants *k, double c) {
    return k->v[0] * c + k->v[1];
}
HDR_CURVE_MONOTONE(fade)

/* ---- The plan -----------------------------------------------------------------------------------------------------
 * Options and facts become a step: the curve, its constants, and how it is applied. HDR_FORM_CHANNEL applies it to each
 * colour component; HDR_FORM_LUMINANCE to luminance, keeping chromaticity (exp.c shows its options). The note is what
 * --explain tells. A verb that brings a scene's light into [0,1] also sets step->of_light and for_display (exp.c), an
 * encoding fills step->state (srgb.c), a verb that cannot go on fills err and returns HDR_REFUSE. */
static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    (void)err;
    const skeleton_params *p = params;
    const hdr_facts *facts = &scene->facts;
    double target = p->to.word == TO_MAX ? facts->max_component : p->to.value;
    step->form = HDR_FORM_CHANNEL;
    step->curve = &fade;
    step->constants.v[0] = 1 - p->amount.value;
    step->constants.v[1] = p->amount.value * target;
    snprintf(step->note, sizeof step->note, "%.9g of the way to %.9g", p->amount.value, target);
    /* HDR_SKIP is a promise: computing it would not change a bit. -0 would become 0, so there must be none; only what
     * `known` says has been found out. The step is filled in all the same, for --no-skip. */
    bool all_positive = (facts->known & HDR_FACT_COMPONENTS) && facts->min_component > 0;
    return p->amount.value == 0 && all_positive ? HDR_SKIP : HDR_RUN;
}

/* ---- The manual ---------------------------------------------------------------------------------------------------
 * Each example is run by the tests: IN.exr is a picture, OUT.png or the like must come out. */
static const char *const examples[] = {"hdr skeleton --amount 0.2 then png -o OUT.png IN.exr",
                                       "hdr skeleton -a 0.1 --to max then log then png -o OUT.png IN.exr", NULL};

/* All of it together, under the name that verbs.def refers to. Options that exclude each other are told apart in a
 * function .check (clamp.c, expose.c); a verb that writes a file format has .format (png.c). */
const hdr_verb hdr_verb_skeleton = {
    .about = {.name = "skeleton",
              .summary = "fade every component towards one value", /* no capital, no full stop */
              .details = "C' = (1 - A) C + A T for each colour component, with A = --amount and T = --to.\n\n"
                         "It is a template for verbs, and of no other use.",
              .examples = examples,
              .options = options,
              .kind = HDR_FILTER},
    .params_size = sizeof(skeleton_params),
    .needs = needs,
    .plan = plan,
};

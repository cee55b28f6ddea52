/* A program: curves and matrices against OpenColorIO's. cmd/crosscheck.c prints it. */
#include "verb/verb.h"

#include <string.h>

typedef struct crosscheck_params {
    const char *only;
} crosscheck_params;

static const hdr_option options[] = {{.name = "only",
                                      .type = HDR_OPTION_TEXT,
                                      .offset = offsetof(crosscheck_params, only),
                                      .metavar = "VERB",
                                      .help = "compare the curves of this verb alone, or primaries"},
                                     {0}};

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const crosscheck_params *p = params;
    (void)given;
    if (!p->only || strcmp(p->only, "primaries") == 0 || hdr_verb_find(p->only)) return HDR_OK;
    return hdr_refuse_text(options, "only", p->only, "is no verb", err);
}

static const char *const examples[] = {"hdr crosscheck", "hdr crosscheck --only srgb --json", NULL};

const hdr_verb hdr_verb_crosscheck = {
    .about =
        {.name = "crosscheck",
         .summary = "compare the curves with OpenColorIO's",
         .details =
             "Computes every curve that encodes, both ways, of all half values and of a million floats from 1e-8 to "
             "1e4, and compares with what OpenColorIO makes of them in its lossless mode, and with the published "
             "formula in long double. So are compared the matrices between primaries, and the weights of luminance.\n\n"
             "Each line has the largest distances met, relative for results from 0.001 on and absolute below: of ours "
             "from what is published; of OpenColorIO's from ours, also in 8-bit codes; and, where OpenColorIO follows "
             "another formula by design, of its results from that formula, with the reason. A line agrees if ours is "
             "what is published, but for the roundings of double, and OpenColorIO's is ours (to 2e-7, or 1e-7 below "
             "0.001, which is rounding of float32), or else what it is said to be instead (to 1e-6, since some of its "
             "formulas round several times).\n\n"
             "The exit status is 1 if some line does not agree. It needs the plug-in hdrpipe-ocio.so, and takes some "
             "seconds.",
         .examples = examples,
         .options = options,
         .kind = HDR_PROGRAM,
         .alone = true},
    .params_size = sizeof(crosscheck_params),
    .check = check,
};

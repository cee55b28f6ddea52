/* The difference of two pictures, as a picture. */
#include "base/cpu.h"
#include "verb/verb.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct diff_params {
    int kind;
    hdr_number epsilon, exaggerate;
    int false_colour; /* another clause's business */
} diff_params;

enum { KIND_SIGNED, KIND_ABSOLUTE, KIND_RELATIVE, KIND_SQUARED, KIND_SMAPE };
static const char *const maps[] = {"none", HDR_PALETTE_NAMES, NULL};
static const char *const diff_kinds[] = {"signed", "absolute", "relative", "squared", "smape", NULL};

static const hdr_option options[] = {{.name = "kind",
                                      .type = HDR_OPTION_CHOICE,
                                      .offset = offsetof(diff_params, kind),
                                      .metavar = "KIND",
                                      .words = diff_kinds,
                                      .default_value = "signed",
                                      .help = "which error of a component"},
                                     {.name = "epsilon",
                                      .type = HDR_OPTION_NUMBER,
                                      .offset = offsetof(diff_params, epsilon),
                                      .metavar = "E",
                                      .min = 0,
                                      .max = 1e30,
                                      .above_min = true,
                                      .default_value = "0.01",
                                      .help = "of relative and smape: added to the divisor, so that black is no fault"},
                                     {.name = "exaggerate",
                                      .type = HDR_OPTION_NUMBER,
                                      .offset = offsetof(diff_params, exaggerate),
                                      .metavar = "K",
                                      .min = 0,
                                      .max = 1e30,
                                      .above_min = true,
                                      .default_value = "1",
                                      .help = "multiply by this"},
                                     {.name = "false-colour",
                                      .type = HDR_OPTION_CHOICE,
                                      .offset = offsetof(diff_params, false_colour),
                                      .metavar = "MAP",
                                      .words = maps,
                                      .default_value = "none",
                                      .clause = "falsecolour --of largest --map",
                                      .help = "short for: then falsecolour --of largest --map MAP"},
                                     {0}};

static bool divides(const diff_params *p) {
    return p->kind == KIND_RELATIVE || p->kind == KIND_SMAPE;
}

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const diff_params *p = params;
    for (int i = 0; i < given->count; i++)
        if (!strcmp(given->given[i].option->name, "epsilon") && !divides(p))
            return hdr_fail(err, HDR_USAGE, "--epsilon has no meaning with --kind %s", diff_kinds[p->kind]);
    return HDR_OK;
}

/* state: the number of the first picture, then the second's in a row of its own. */
static void add(const hdr_joining *joining, int picture, const double *values, double *state, size_t count) {
    (void)joining;
    memcpy(state + (size_t)picture * HDR_STRIP, values, count * sizeof *values);
}

/* x is the test, r the reference; what has no value is NaN, which reading repairs and counts. */
HDR_INLINE double error_of(int kind, double epsilon, double x, double r) {
    double difference = x - r;
    switch (kind) {
    case KIND_ABSOLUTE:
        return fabs(difference);
    case KIND_RELATIVE:
        return fabs(difference) / (fabs(r) + epsilon);
    case KIND_SQUARED:
        return difference * difference;
    case KIND_SMAPE:
        return fabs(difference) / (fabs(x) + fabs(r) + epsilon);
    default:
        return difference;
    }
}

static void end(const hdr_joining *joining, const double *state, double *out, size_t count) {
    const diff_params *p = joining->params;
    double epsilon = p->epsilon.value, factor = p->exaggerate.value;
    for (size_t i = 0; i < count; i++) {
        double x = state[i], r = state[HDR_STRIP + i];
        bool finite = x - x == 0 && r - r == 0;
        out[i] = finite ? factor * error_of(p->kind, epsilon, x, r) : NAN;
    }
}

/* The formula, and the numbers in it: it is told in the result. */
static void describe(const diff_params *p, char *text, size_t size) {
    static const char *const formulas[] = {"x - r", "|x - r|", "|x - r| / (|r| + E)", "(x - r)^2",
                                           "|x - r| / (|x| + |r| + E)"};
    char epsilon[40] = "", factor[40] = "";
    if (divides(p)) snprintf(epsilon, sizeof epsilon, ", E = %.9g", p->epsilon.value);
    if (p->exaggerate.value != 1) snprintf(factor, sizeof factor, ", times %.9g", p->exaggerate.value);
    snprintf(text, size, "%s%s%s", formulas[p->kind], epsilon, factor);
}

static hdr_status join(const void *params, hdr_joining *joining, hdr_error *err) {
    if (joining->pictures != 2) return hdr_fail(err, HDR_USAGE, "it takes two files: a test and its reference");
    describe(params, joining->meaning, sizeof joining->meaning);
    joining->slots = 2;
    joining->add = add;
    joining->end = end;
    return HDR_OK;
}

static const char *const examples[] = {"hdr diff -o OUT.exr IN.exr IN.exr",
                                       "hdr diff --kind relative then stats IN.exr IN.exr",
                                       "hdr diff --kind smape --false-colour magma -o OUT.png IN.exr IN.exr", NULL};

const hdr_verb hdr_verb_diff = {
    .about =
        {.name = "diff",
         .summary = "subtract a reference from a picture",
         .details =
             "Begins a chain: makes one float picture of two, x, the test, and r, the reference, which must agree in "
             "data window, channels and primaries. Components are taken as they are stored, colour associated with "
             "alpha; alpha itself is left out. Where either is NaN or infinite there is no difference: it is 0, and "
             "counted on standard error.\n\n"
             "--kind signed: x - r. absolute: |x - r|. relative: |x - r| / (|r| + E). squared: (x - r)^2. smape: |x - "
             "r| / (|x| + |r| + E). E is --epsilon. "
             "EXR that is written holds the formula, with E and --exaggerate, in its attribute hdrpipeMeaning.\n\n"
             "--false-colour shows the error of the worst component of each pixel by colours, with a legend below; see "
             "hdr-falsecolour(1), which takes more options behind a then. Signed errors are best seen in coolwarm, all "
             "others in one that grows lighter, such as viridis.",
         .examples = examples,
         .options = options,
         .kind = HDR_JOIN,
         .stays = true},
    .params_size = sizeof(diff_params),
    .check = check,
    .join = join,
};

/* A program: run time against error. cmd/bench.c runs it. */
#include "verb/verb.h"

typedef struct bench_params {
    hdr_number repetitions, samples, limit;
    bool csv;
    const char *plot;
} bench_params;

static const char *const all_pixels[] = {"all", NULL};

static const hdr_option options[] = {
    {.name = "repetitions",
     .type = HDR_OPTION_INTEGER,
     .offset = offsetof(bench_params, repetitions),
     .metavar = "N",
     .min = 1,
     .max = 1000,
     .default_value = "5",
     .help = "how often each way is timed; the median counts"},
    {.name = "samples",
     .type = HDR_OPTION_INTEGER,
     .offset = offsetof(bench_params, samples),
     .metavar = "N",
     .min = 1,
     .max = 100000000,
     .words = all_pixels,
     .default_value = "2000",
     .help = "compare with the exact method at N random pixels, and at as many local extremes of luminance"},
    {.name = "limit",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(bench_params, limit),
     .metavar = "SECONDS",
     .min = 0,
     .max = 1e6,
     .default_value = "2",
     .help = "a way that would take longer is inferred from part of the work; no repetition begins after as long"},
    {.name = "plot",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(bench_params, plot),
     .metavar = "FILE.svg",
     .help = "draw run time against error there"},
    {.name = "csv",
     .type = HDR_OPTION_FLAG,
     .offset = offsetof(bench_params, csv),
     .help = "print comma-separated values"},
    {0}};

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const bench_params *p = params;
    (void)given;
    return hdr_check_svg(options, "plot", p->plot, err);
}

static const char *const examples[] = {"hdr bench durand IN.exr",
                                       "hdr bench --plot OUT.svg durand --sigma-s 0.05 IN.exr",
                                       "hdr bench --csv --repetitions 3 expose --auto then log then srgb IN.exr", NULL};

const hdr_verb hdr_verb_bench = {
    .about = {.name = "bench",
              .summary = "time a chain against its error, method by method",
              .details = "Runs a chain on a picture in every way in which it can be computed, and tells how "
                         "long each takes and how wrong it is. The chain stands behind bench and its options, "
                         "and the picture behind the chain: hdr bench durand FILE.\n\n"
                         "Of a chain with a verb that has several methods (durand), the last of those verbs is "
                         "varied: each --method, with a number of settings: a grid by --cells, the direct sum "
                         "by --tolerance, and so on. Options that bench sets itself may not be given. Each way "
                         "is compared with --method exact. The error is that of what the verb computes around "
                         "each pixel, of durand the base layer in units of log10: the largest, and the root of "
                         "the mean square. It is taken at random pixels (always the same), and the largest also "
                         "at the local extremes of luminance that stand out most, such as fireflies; at all "
                         "pixels if the picture has no more than --samples. The bound is what the method "
                         "promises for every picture. The way that --method auto takes is marked by an "
                         "asterisk; where no setting that is tried is that way, it is added.\n\n"
                         "Of any other chain, the program's fast way is compared with --reference, in double "
                         "precision. The error is that of the components, relative to those of the reference.\n\n"
                         "Times are in milliseconds, by the clock on the wall: whole, from the file to the "
                         "codes of a PNG (or of the format that the chain ends in) in memory; and own, of what "
                         "the varied verb computes around the pixels. All ways take turns, so that what else "
                         "the machine does falls on all alike, and the medians are told. A way that would take "
                         "longer than --limit is not timed in full: a method that computes each pixel by "
                         "itself, as the exact one does, is run at the compared pixels alone, and its time for "
                         "all of them is inferred; of another method, no dearer settings are tried. What is "
                         "inferred is marked by ~.\n\n"
                         "The last columns tell which part of the pixels has another code of 8 bits in any "
                         "component, encoded as a PNG would be, and by how much at most. Where the exact method "
                         "would take longer than --limit, they are not told: there is nothing to compare with.\n\n"
                         "--csv and --json print the same for programs. There, what is not known is empty or "
                         "null, and errors and times have all digits. --plot draws own time (of chains with "
                         "nothing to vary: whole time) against the largest error, on logarithmic axes, as an "
                         "SVG. The line joins the ways that no other one beats in both. Thin lines go up to the "
                         "bounds; times that were inferred are hollow, and a ring is around what --method auto takes.",
              .examples = examples,
              .options = options,
              .kind = HDR_PROGRAM,
              .leads = true},
    .params_size = sizeof(bench_params),
    .check = check,
};

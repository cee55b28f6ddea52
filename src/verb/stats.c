/* A program: the facts of a scene. cmd/stats.c prints them. */
#include "verb/verb.h"

static const hdr_option options[] = {{0}};

static const char *const examples[] = {
    "hdr stats IN.exr", "hdr stats --json IN.exr", "hdr expose --auto then stats IN.exr",
    "hdr stats --json IN.exr > OUT.json && hdr exp --facts OUT.json -o OUT.png IN.exr", NULL};

const hdr_verb hdr_verb_stats = {
    .about = {.name = "stats",
              .summary = "tell the facts of a scene",
              .details = "Prints size and windows, range of each channel and of luminance, log-average, percentiles of "
                         "luminance over lit pixels (nearest "
                         "rank), and how many pixels are lit and how many components are NaN, infinite or negative. "
                         "Facts are over the "
                         "data window, after repair, and after the verbs that stand before stats.\n\n"
                         "Of several files, what comes last are the facts of all together, as exact as if they were "
                         "one picture: counts, range of luminance, log-average and percentiles. They are left out if a "
                         "file could not be read.\n\n"
                         "With --json, one object a file, each on a line of its own, with its name as the member file. "
                         "Of several files, one more has instead of that the member files, their number, and no "
                         "member that only a single picture has. The option --facts of other verbs takes the facts of "
                         "all from this output.",
              .examples = examples,
              .options = options,
              .kind = HDR_PROGRAM},
};

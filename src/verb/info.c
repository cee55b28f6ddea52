/* A program: what a file holds. cmd/info.c prints it. */
#include "verb/verb.h"

static const hdr_option options[] = {{0}};

static const char *const examples[] = {"hdr info IN.exr", "hdr info --json IN.exr", NULL};

const hdr_verb hdr_verb_info = {
    .about =
        {.name = "info",
         .summary = "tell what a picture file holds",
         .details =
             "Prints format, storage, compression, windows, channels and colour of each file, from its header alone.",
         .examples = examples,
         .options = options,
         .kind = HDR_PROGRAM},
};

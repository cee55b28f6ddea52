/* A program: what a file holds. cmd/info.c prints it. */
#include "verb/verb.h"

static const hdr_option options[] = {{0}};

static const char *const examples[] = {"hdr info IN.exr", "hdr info --json IN.exr", NULL};

const hdr_verb hdr_verb_info = {
    .about =
        {.name = "info",
         .summary = "tell what a picture file holds",
         .details =
             "Prints format, storage, compression, windows, channels and colour of the picture that would be read of "
             "each file, from its header alone. --part, --layer, --channel, --level and --crop choose another.\n\n"
             "Then all that the file holds is listed: its parts with their storage, windows, tiles, levels, views, "
             "layers, channels and attributes. A file of which nothing can be read is listed too, and what is in the "
             "way is said, with exit status 65.",
         .examples = examples,
         .options = options,
         .kind = HDR_PROGRAM},
};

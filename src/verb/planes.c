/* Pixels in memory: what a chain ends in whose output takes them. No chain names it. */
#include "verb/verb.h"

static const hdr_option options[] = {{0}};

static hdr_sink *create(const void *params, hdr_output *output, const hdr_frame *frame, hdr_error *err) {
    (void)params;
    return hdr_planes_create(output, frame, err);
}

static const hdr_format format = {.alpha = true,
                                  .primaries = HDR_PRIMARIES_CONVERTED,
                                  .states = HDR_STATES_TOLD,
                                  .sample = hdr_format_float,
                                  .create = create};

const hdr_verb hdr_verb_planes = {.about = {.name = "planes", .options = options, .kind = HDR_FORMAT},
                                  .format = &format};

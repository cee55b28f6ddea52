/* Ends a chain: a PFM file. */
#include "verb/verb.h"

static const hdr_option options[] = {{0}};

static hdr_sink *create(const void *params, hdr_output *output, const hdr_frame *frame, hdr_error *err) {
    (void)params;
    return hdr_pfm_create(output, frame, err);
}

static const hdr_format format = {.extension = ".pfm",
                                  .primaries = HDR_PRIMARIES_LOST,
                                  .states = HDR_STATES_LOST,
                                  .sample = hdr_format_float,
                                  .create = create};

static const char *const examples[] = {"hdr expose --ev -1 then pfm -o OUT.pfm IN.exr", NULL};

const hdr_verb hdr_verb_pfm = {
    .about =
        {.name = "pfm",
         .summary = "write a PFM file",
         .details =
             "Ends a chain: float32 in little-endian order, rows from bottom to top, grey (Pf) where the "
             "picture has one plane, else "
             "colour (PF). PFM has no alpha: colour is written as an EXR would hold it, over black. Nor can "
             "it tell primaries: if they are not Rec.709's, a note says so, and the values stay what they "
             "are. It is the same with values that are encoded.\n\n"
             "On reading, the sign of the scale is the byte order, and its size is ignored. The header's lines may "
             "end in CR LF.",
         .examples = examples,
         .options = options,
         .kind = HDR_FORMAT},
    .format = &format,
};

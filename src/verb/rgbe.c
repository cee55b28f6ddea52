/* Ends a chain: a Radiance HDR file. */
#include "verb/verb.h"

static const hdr_option options[] = {{0}};

static hdr_sink *create(const void *params, hdr_output *output, const hdr_frame *frame, hdr_error *err) {
    (void)params;
    return hdr_rgbe_create(output, frame, err);
}

static const hdr_format format = {.extension = ".hdr",
                                  .primaries = HDR_PRIMARIES_CONVERTED,
                                  .states = HDR_STATES_LOST,
                                  .sample = hdr_format_float,
                                  .create = create};

static const char *const examples[] = {"hdr expose --ev -1 then rgbe -o OUT.hdr IN.exr", NULL};

const hdr_verb hdr_verb_rgbe = {
    .about =
        {.name = "rgbe",
         .summary = "write a Radiance HDR file",
         .details =
             "Ends a chain: 8 bits for each of R, G and B and one exponent for all three, rows from top to bottom, "
             "each component packed by run lengths (rows of fewer than 8 or more than 32767 pixels are not). Mantissas "
             "are rounded to the nearest, so a component is off by at most half a step, and a step is between 1/256 "
             "and 1/128 of the largest component. Negative components become 0; so does a pixel below 2^-128, "
             "and what is above 255 * 2^119 is held there. There is no alpha: colour is written as an EXR would hold "
             "it, over black.\n\n"
             "Hardly a reader heeds what the file says of its primaries, so a linear picture of others is converted to "
             "Rec.709 first; --primaries keep does not. The file states them in any case, since Radiance's own are "
             "neither. It cannot tell that values are encoded: if they are, a note says so.\n\n"
             "On reading, a component is mantissa * 2^(exponent - 136), as in most programs (OpenImageIO and "
             "pfstools among them): 0 stays 0, and a file that is written again does not change. Radiance itself "
             "reads (mantissa + 1/2) * 2^(exponent - 136), because it cuts mantissas off when it writes; it sees half "
             "a step more in every component, 0.2 to 0.4 percent of the largest. Pixels are divided by the product "
             "of the header's EXPOSURE values, and each component by that of its COLORCORR values. Without PRIMARIES "
             "in the header they are taken for Rec.709's, as "
             "everywhere but in Radiance. All orientations, all three ways to store a row, and XYZ pixels "
             "(32-bit_rle_xyze, whose numbers are taken as they stand: Radiance's are 179 times those of RGB) are "
             "read.",
         .examples = examples,
         .options = options,
         .kind = HDR_FORMAT},
    .format = &format,
};

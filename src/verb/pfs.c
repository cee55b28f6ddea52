/* Ends a chain: a PFS stream. */
#include "verb/verb.h"

static const hdr_option options[] = {{0}};

static hdr_sink *create(const void *params, hdr_output *output, const hdr_frame *frame, hdr_error *err) {
    (void)params;
    return hdr_pfs_create(output, frame, err);
}

static const hdr_format format = {.extension = ".pfs",
                                  .alpha = true,
                                  .primaries = HDR_PRIMARIES_XYZ,
                                  .states = HDR_STATES_SRGB,
                                  .sample = hdr_format_float,
                                  .create = create};

static const char *const examples[] = {"hdr expose --ev -1 then pfs -o OUT.pfs IN.exr",
                                       "hdr log then pfs -o - IN.exr > OUT.pfs", NULL};

const hdr_verb hdr_verb_pfs = {
    .about =
        {.name = "pfs",
         .summary = "write a PFS stream, for pfstools",
         .details =
             "Ends a chain: one frame of float channels X, Y and Z, and ALPHA where the picture has it (colour is "
             "associated, as in an EXR), so that the programs of pfstools can stand behind it in a pipe. Programs "
             "of pfstools take white for D65, so a linear picture of other primaries than Rec.709's is converted to "
             "these first, and those to XYZ; --primaries keep goes to XYZ straight and leaves white as it is. A "
             "picture of "
             "XYZ primaries stays as it is. A grey picture is written as X, Y and Z of D65's grey, whatever white it "
             "had. The tag LUMINANCE is RELATIVE "
             "for a linear "
             "picture, and DISPLAY for an encoded one, whose encoded values go through the matrix as they are. Readers "
             "take these for sRGB's, this one among them: a note says so if they "
             "are not.\n\n"
             "On reading, the picture's primaries are X, Y and Z themselves, and white is not adapted when they are "
             "converted. LUMINANCE=DISPLAY makes it an sRGB picture: R, G and B are computed back, and nothing encodes "
             "it again. Y alone is a grey picture; R, G, B instead of X, Y, Z are read too. Alpha is the channel "
             "ALPHA or A. Of several frames the first is read, and it is said that there are more.",
         .examples = examples,
         .options = options,
         .kind = HDR_FORMAT},
    .format = &format,
};

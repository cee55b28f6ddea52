/* Ends a chain: a PNG file. The chain adds the encoding and the quantisation that are missing. */
#include "verb/verb.h"

typedef struct png_params {
    int depth; /* index into depths */
    hdr_dither_params dither;
} png_params;

static const char *const depths[] = {"8", "16", NULL};

static const hdr_option options[] = {{.name = "bits",
                                      .type = HDR_OPTION_CHOICE,
                                      .offset = offsetof(png_params, depth),
                                      .metavar = "BITS",
                                      .words = depths,
                                      .default_value = "8",
                                      .help = "bits of a sample"},
                                     HDR_DITHER_OPTIONS(png_params),
                                     {0}};

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const png_params *p = params;
    return hdr_dither_check(&p->dither, given, err);
}

static int bits(const void *params, int quantised) {
    const png_params *p = params;
    int depth = p->depth == 0 ? 8 : 16;
    return quantised == 0 ? depth : quantised <= 8 ? 8 : 16;
}

static hdr_sample sample(const void *params, int depth) {
    (void)params;
    return depth == 8 ? HDR_SAMPLE_U8 : HDR_SAMPLE_U16;
}

static const hdr_dither_params *dither(const void *params) {
    const png_params *p = params;
    return &p->dither;
}

static hdr_sink *create(const void *params, hdr_output *output, const hdr_frame *frame, hdr_error *err) {
    (void)params;
    return hdr_png_create(output, frame, err);
}

static const hdr_format format = {.extension = ".png",
                                  .codes = true,
                                  .alpha = true,
                                  .bits = bits,
                                  .sample = sample,
                                  .dither = dither,
                                  .create = create};

static const char *const examples[] = {"hdr exp then png -o OUT.png IN.exr",
                                       "hdr exp then png --dither blue -o OUT.png IN.exr",
                                       "hdr exp then png --bits 16 IN.exr > OUT.png", NULL};

const hdr_verb hdr_verb_png = {
    .about =
        {.name = "png",
         .summary = "write a PNG file",
         .details =
             "Ends a chain. If the picture is neither encoded nor quantised, the sRGB curve is applied first; if it is "
             "not quantised, it "
             "is rounded to --bits. After an explicit quantise of b bits the PNG has 8 bits where b <= 8, else 16, and "
             "an sBIT "
             "chunk tells b. --dither and --seed are for the quantisation that a PNG makes by itself, as hdr-quantise "
             "has "
             "them: against bands in skies and on walls. After an explicit quantise they are refused; give them "
             "there.\n\n"
             "The PNG is grey when the picture that was read is (one plane, or R = G = B in every pixel) and its "
             "primaries were not "
             "converted. Alpha is stored unassociated, as PNG wants it, and is left out where it is 1 everywhere.\n\n"
             "The colour chunks tell what was done: sRGB, gAMA and cHRM after the sRGB curve, gAMA after gamma, cICP "
             "after rec709, pq and hlg, gAMA 100000 for values that were left linear. With --primaries keep, cHRM "
             "tells the picture's own primaries, and cICP stands where it has a code for them. Where the file's pixels "
             "are not square (pixelAspectRatio, PIXASPECT), a pHYs "
             "chunk "
             "tells the ratio of their sides, and no row is stretched.\n\n"
             "What is above 1 is cut. Where no verb has brought the picture into range, and something was cut that a "
             "code can show, one line on standard error tells how large the largest component was.",
         .examples = examples,
         .options = options,
         .kind = HDR_FORMAT},
    .params_size = sizeof(png_params),
    .check = check,
    .format = &format,
};

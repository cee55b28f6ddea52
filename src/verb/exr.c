/* Ends a chain: an OpenEXR file. */
#include "verb/verb.h"

#include <string.h>

typedef struct exr_params {
    int type;        /* index into types: hdr_type */
    int compression; /* hdr_compression */
    hdr_number dwa_level;
    bool record;
} exr_params;

static const char *const types[] = {"half", "float", NULL};

static const hdr_option options[] = {{.name = "type",
                                      .type = HDR_OPTION_CHOICE,
                                      .offset = offsetof(exr_params, type),
                                      .metavar = "TYPE",
                                      .words = types,
                                      .default_value = "float",
                                      .help = "type of the channels"},
                                     {.name = "compression",
                                      .type = HDR_OPTION_CHOICE,
                                      .offset = offsetof(exr_params, compression),
                                      .metavar = "METHOD",
                                      .words = hdr_compression_names,
                                      .default_value = "zip",
                                      .help = "compression of the pixels"},
                                     {.name = "dwa-level",
                                      .type = HDR_OPTION_NUMBER,
                                      .offset = offsetof(exr_params, dwa_level),
                                      .metavar = "LEVEL",
                                      .min = 0,
                                      .max = 10000,
                                      .default_value = "45",
                                      .help = "how much dwaa and dwab may lose"},
                                     {.name = "record",
                                      .type = HDR_OPTION_FLAG,
                                      .offset = offsetof(exr_params, record),
                                      .help = "tell the chain in the header, as hdrpipeChain"},
                                     {0}};

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const exr_params *p = params;
    bool dwa = p->compression == HDR_COMPRESSION_DWAA || p->compression == HDR_COMPRESSION_DWAB;
    for (int i = 0; i < given->count; i++)
        if (!dwa && strcmp(given->given[i].option->name, "dwa-level") == 0)
            return hdr_fail(err, HDR_USAGE, "--dwa-level: only with --compression dwaa or dwab");
    return HDR_OK;
}

static hdr_sample sample(const void *params, int bits) {
    (void)bits;
    const exr_params *p = params;
    return p->type == HDR_HALF ? HDR_SAMPLE_HALF : HDR_SAMPLE_FLOAT;
}

static bool records(const void *params) {
    return ((const exr_params *)params)->record;
}

static hdr_sink *create(const void *params, hdr_output *output, const hdr_frame *frame, hdr_error *err) {
    const exr_params *p = params;
    return hdr_exr_create(output, frame, (hdr_compression)p->compression, (float)p->dwa_level.value, err);
}

static const hdr_format format = {
    .extension = ".exr", .alpha = true, .attributes = true, .sample = sample, .records = records, .create = create};

static const char *const examples[] = {"hdr expose --ev 2 then exr --type half --compression piz -o OUT.exr IN.exr",
                                       "hdr clamp then exr --compression dwab --dwa-level 100 -o OUT.exr IN.exr",
                                       "hdr exp then exr --record -o - IN.exr > OUT.exr", NULL};

const hdr_verb hdr_verb_exr = {
    .about =
        {.name = "exr",
         .summary = "write an OpenEXR file",
         .details =
             "Ends a chain: scan lines of R, G, B (or Y where the picture has one plane) and, where there is one, "
             "associated alpha. "
             "The attribute hdrpipeState tells whether the values are linear or encoded, so that reading the file "
             "back cannot "
             "encode it twice. Nothing about the machine is written, and nothing about the command line unless "
             "--record "
             "is given: then the attribute hdrpipeChain holds the chain and its reading options, a line for each time "
             "the picture was so written.\n\n"
             "The attributes of an EXR file that is read go along: camera, owner, comments, time code, matrices, "
             "whatever "
             "a renderer put there, of any type. Left out are those that say how its pixels were stored, the "
             "thumbnail, "
             "and what is not true any more: whiteLuminance behind a filter, adoptedNeutral where primaries were "
             "converted, the screen window and the kind of environment map where --crop cut the frame.\n\n"
             "pxr24, b44, b44a, dwaa and dwab lose precision; the others keep every bit. dwaa and dwab are by far the "
             "smallest: like JPEG they keep what the eye sees, at half precision. --dwa-level tells how much may "
             "go (OpenEXR's dwaCompressionLevel: 0 the least, 45 is hardly seen, some hundreds will do for a preview); "
             "dwab packs more rows together. Where the installed OpenEXR is older than 3.3 these two are read "
             "and written through the plug-in hdrpipe-exr.so.",
         .examples = examples,
         .options = options,
         .kind = HDR_FORMAT},
    .params_size = sizeof(exr_params),
    .check = check,
    .format = &format,
};

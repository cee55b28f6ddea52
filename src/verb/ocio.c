/* A colour transform of OpenColorIO: to another colour space, or through a view to a display. */
#include "kernel/strip.h"
#include "picture/colour.h"
#include "picture/ocio.h"
#include "verb/verb.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct ocio_params {
    const char *config, *from, *to, *display, *view, *look;
    bool list; /* programs print what there is instead of making a picture: cmd/ocio.c */
} ocio_params;

static const hdr_option options[] = {
    {.name = "config",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(ocio_params, config),
     .metavar = "FILE",
     .help = "the configuration; without it the one that $OCIO names, else ACES 1.x, which is built in"},
    {.name = "from",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(ocio_params, from),
     .metavar = "SPACE",
     .help = "the colour space that the picture is in; without it the role scene_linear"},
    {.name = "to",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(ocio_params, to),
     .metavar = "SPACE",
     .help = "map to this colour space, or role, and not for a display"},
    {.name = "display",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(ocio_params, display),
     .metavar = "DISPLAY",
     .help = "map for this display; without it the first of the configuration"},
    {.name = "ocio-view",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(ocio_params, view),
     .metavar = "VIEW",
     .help = "by this view of the display; without it its first"},
    {.name = "look",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(ocio_params, look),
     .metavar = "LOOKS",
     .help = "with these looks, such as A,-B, in place of those that the view has"},
    {.name = "list",
     .type = HDR_OPTION_FLAG,
     .offset = offsetof(ocio_params, list),
     .help = "print the names that the configuration has for all this, and make no picture"},
    {0}};

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const ocio_params *p = params;
    for (int i = 0; i < given->count; i++)
        if (given->given[i].text && !*given->given[i].text)
            return hdr_refuse_text(options, given->given[i].option->name, "", "is no name", err);
    if (p->to && (p->display || p->view))
        return hdr_fail(err, HDR_USAGE, "--to maps to a colour space, --%s for a display: only one of them can be done",
                        p->display ? "display" : "ocio-view");
    return HDR_OK;
}

/* ---- The mapper ---- */

typedef struct transform {
    hdr_mapper mapper; /* first, so that the one pointer is the other */
    hdr_ocio *ocio;
} transform;

/* OpenColorIO works in float32: its input is rounded to that, its output is one. */
static bool map(const hdr_mapper *mapper, double *const c[3], size_t count) {
    const transform *t = (const transform *)mapper;
    float plane[HDR_STRIP], pixels[4 * HDR_STRIP];
    for (int p = 0; p < 3; p++) {
        hdr_real_to_float(c[p], plane, count);
        for (size_t i = 0; i < count; i++)
            pixels[4 * i + (size_t)p] = plane[i];
    }
    for (size_t i = 0; i < count; i++)
        pixels[4 * i + 3] = 1;
    if (!hdr_ocio_apply(t->ocio, pixels, count)) return false;
    for (int p = 0; p < 3; p++)
        for (size_t i = 0; i < count; i++)
            c[p][i] = (double)pixels[4 * i + (size_t)p];
    return true;
}

static void close_transform(hdr_mapper *mapper) {
    transform *t = (transform *)mapper;
    hdr_ocio_free(t->ocio);
    free(t);
}

static hdr_mapper *open_transform(const void *params, hdr_error *err) {
    const ocio_params *p = params;
    transform *t = hdr_alloc(1, sizeof *t);
    if (!t) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        return NULL;
    }
    hdr_ocio_request request = {.from = p->from, .to = p->to, .display = p->display, .view = p->view, .looks = p->look};
    t->mapper = (hdr_mapper){map, close_transform};
    t->ocio = hdr_ocio_new(&(hdr_ocio_source){.file = p->config}, &request, err);
    if (t->ocio) return &t->mapper;
    free(t);
    return NULL;
}

/* ---- The plan ---- */

/* Linear colour spaces by the names that they have everywhere (ACES CG configuration, 2022). */
static const struct linear_space {
    const char *name;
    const hdr_chromaticities *primaries;
} linear_spaces[] = {{"ACES2065-1", &hdr_aces_ap0},          {"ACEScg", &hdr_aces_ap1},
                     {"Linear Rec.709 (sRGB)", &hdr_rec709}, {"Linear P3-D65", &hdr_p3_d65},
                     {"Linear Rec.2020", &hdr_rec2020},      {"CIE-XYZ-D65", &hdr_cie_xyz}};

/* NULL: nothing is known of them. */
static const hdr_chromaticities *primaries_of(const hdr_ocio_about *about) {
    for (size_t i = 0; i < sizeof linear_spaces / sizeof *linear_spaces; i++)
        if (!strcmp(about->to, linear_spaces[i].name)) return linear_spaces[i].primaries;
    return NULL;
}

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    const ocio_params *p = params;
    const transform *t = (const transform *)scene->mapper;
    if (!p->from && strcmp(scene->state, "linear") != 0) {
        hdr_fail(err, HDR_BAD_DATA,
                 "the picture is encoded already (%s): decode it first (--decode), or say with --from which colour "
                 "space that is",
                 scene->state);
        return HDR_REFUSE;
    }
    step->form = HDR_FORM_MAPPED;
    step->mapper = scene->mapper;
    if (!t) return HDR_RUN;
    const hdr_ocio_about *about = &t->ocio->about;
    step->wants_rec709 = t->ocio->built_in && !p->from;
    const char *config = p->config ? "--config" : t->ocio->built_in ? "the configuration that is built in" : "$OCIO";
    bool view = !about->to[0], data = about->values == HDR_OCIO_DATA;
    step->primaries = primaries_of(about);
    if (about->values == HDR_OCIO_LINEAR)
        snprintf(step->state, sizeof step->state, "linear");
    else if (view || !data) /* data that are not shown stay what they were */
        snprintf(step->state, sizeof step->state, "ocio");
    step->for_display = step->state[0] && about->values != HDR_OCIO_LINEAR;
    if (!view)
        snprintf(step->note, sizeof step->note, "from %.60s to %.60s, by %s", about->from, about->to, config);
    else
        snprintf(step->note, sizeof step->note, "from %.50s by %.50s for %.50s, by %s", about->from, about->view,
                 about->display, config);
    return HDR_RUN;
}

static const char *const examples[] = {
    "hdr ocio -o OUT.png IN.exr",
    "hdr ocio --display 'Rec.1886 Rec.709 - Display' --ocio-view Un-tone-mapped then png -o OUT.png IN.exr",
    "hdr ocio --from ACEScg --to ACES2065-1 -o OUT.exr IN.exr", NULL};

const hdr_verb hdr_verb_ocio = {
    .about =
        {.name = "ocio",
         .summary = "map colours as an OpenColorIO configuration says",
         .details =
             "Maps the picture for a display, by one of the display's views, or with --to to another colour space. "
             "What "
             "there is to choose from depends on the configuration, and --list prints it (with --json for "
             "programs).\n\n"
             "The configuration is the file of --config, or else that which the environment's OCIO names. Without "
             "either "
             "it is one that is made of the ACES 1.x transforms which OpenColorIO has built in: colour spaces, "
             "displays "
             "and views have the names of the ACES CG configuration.\n\n"
             "The picture is taken to be in the colour space --from, by default that of the role scene_linear. In the "
             "configuration that is built in this is linear Rec.709: a file with other chromaticities is converted to "
             "these first (see --primaries), unless --from is given. In other configurations it is for --from to say "
             "what the picture is in, whatever its chromaticities are. So it is for a picture that is encoded already, "
             "which is refused without --from.\n\n"
             "Behind this verb a picture counts as encoded ('ocio'), or as linear where the colour space is a linear "
             "one. A view of data counts as encoded; data that --to leaves alone stay what they were. A PNG of what is "
             "encoded has no colour chunk, since nothing is known of what its values are to a display. Linear colour "
             "spaces that have the names of the ACES CG configuration are known by their primaries, which an EXR then "
             "tells, and which a PNG is converted from. Of any other one that is not known: it counts as Rec.709's "
             "from there on, which is said on standard error.\n\n"
             "OpenColorIO works in float32, with --reference, too: here a result is as exact as that library makes it, "
             "in its lossless mode, and the last bits of a float may depend on the processor. What it makes infinite "
             "is held at the largest float, a NaN becomes 0. A picture of "
             "luminance alone becomes one of three channels.\n\n"
             "Since the configuration is a file of this machine, this verb does not travel through a pipe: its program "
             "computes the pixels, and sends EXR. The pixels are those that one program makes of the whole chain, to "
             "within the float32 of that EXR; the bytes of a PNG need not be the same, which depend on how its source "
             "was cut into pieces, nor whether it is a grey one. The verb needs the "
             "plug-in hdrpipe-ocio.so, which is loaded for it alone.",
         .examples = examples,
         .options = options,
         .kind = HDR_FILTER,
         .stays = true},
    .params_size = sizeof(ocio_params),
    .check = check,
    .open = open_transform,
    .plan = plan,
};

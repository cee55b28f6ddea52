/* Smoothing where the noise is, by non-local means. */
#include "verb/verb.h"

#include <stdio.h>
#include <string.h>

typedef struct smooth_params {
    const char *picture;
    hdr_number strength, radius, patch, above;
} smooth_params;

static const hdr_option options[] = {
    {.name = "sigma-picture",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(smooth_params, picture),
     .metavar = "FILE",
     .help = "the standard deviation of each component, such as mean --show mean-deviation makes; it has to be given"},
    {.name = "strength",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(smooth_params, strength),
     .metavar = "K",
     .min = HDR_NLMEANS_LEAST_K,
     .max = 10,
     .default_value = "0.45",
     .help = "how unlike patches may be, in units of their noise: more smooths more"},
    {.name = "radius",
     .type = HDR_OPTION_INTEGER,
     .offset = offsetof(smooth_params, radius),
     .metavar = "PIXELS",
     .min = 1,
     .max = HDR_NLMEANS_MOST_RADIUS,
     .default_value = "10",
     .help = "how far the window reaches to each side"},
    {.name = "patch",
     .type = HDR_OPTION_INTEGER,
     .offset = offsetof(smooth_params, patch),
     .metavar = "PIXELS",
     .min = 0,
     .max = HDR_NLMEANS_MOST_PATCH,
     .default_value = "3",
     .help = "how far the patches that are compared reach to each side"},
    {.name = "above",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(smooth_params, above),
     .metavar = "PART",
     .min = 0,
     .max = 1e6,
     .default_value = "0",
     .help = "leave pixels alone whose standard deviation is at most this part of their brightness"},
    {0}};

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const smooth_params *p = params;
    (void)given;
    if (p->picture && (!*p->picture || !strcmp(p->picture, "-")))
        return hdr_refuse_text(options, "sigma-picture", p->picture, "names no file", err);
    return HDR_OK;
}

static hdr_status guide(const void *params, hdr_guiding *guiding, hdr_error *err) {
    const smooth_params *p = params;
    if (!p->picture)
        return hdr_fail(err, HDR_USAGE,
                        "--sigma-picture is missing: the picture of the standard deviation, such as hdr mean --show "
                        "mean-deviation makes");
    guiding->picture = p->picture;
    guiding->filter = (hdr_nlmeans){
        .k = p->strength.value, .above = p->above.value, .radius = (int)p->radius.value, .patch = (int)p->patch.value};
    int window = 2 * guiding->filter.radius + 1, patch = 2 * guiding->filter.patch + 1;
    snprintf(guiding->note, sizeof guiding->note, "non-local means, k %g, window %d x %d, patches %d x %d; biased",
             guiding->filter.k, window, window, patch, patch);
    return HDR_OK;
}

static const char *const examples[] = {
    "hdr smooth --sigma-picture SIGMA.exr -o OUT.exr IN.exr",
    "hdr mean then smooth --sigma-picture SIGMA.exr then reinhard then png -o OUT.png IN.exr IN.exr", NULL};

const hdr_verb hdr_verb_smooth = {
    .about =
        {.name = "smooth",
         .summary = "smooth a render where its noise is known to be high; biased",
         .details =
             "Begins a chain, or stands behind mean or diff: replaces each pixel by a mean of pixels around it that "
             "differ from it by no more than the noise explains. How high the noise is, a second picture tells: the "
             "standard deviation of each component of the picture that is smoothed, in its units. Of the mean of "
             "several renders it is 'hdr mean --show mean-deviation' of the same files; of a single one, "
             "--show deviation of others like it.\n\n"
             "The result is biased, and no longer the mean of what was rendered: it has less noise, and an error of "
             "its own that more renders do not lessen, largest at weak edges and in fine texture. 'hdr error' "
             "measures it against a reference; EXR that is written tells in its attribute hdrpipeMeaning that it was "
             "smoothed, and how. Do not average smoothed pictures where the mean of the renders "
             "themselves can be had.\n\n"
             "The filter is non-local means for noise that varies from pixel to pixel (Rousselle, Knaus and Zwicker, "
             "Adaptive Rendering with Non-Local Means Filtering, 2012). Of pixels p and q, with variances Vp and Vq, "
             "the distance of a channel is d2 = ((p - q)^2 - (Vp + min(Vp, Vq))) / (K^2 (Vp + Vq)), K being "
             "--strength; q weighs exp(-max(0, D)), with D the mean of d2 over all channels and over the patches "
             "around p and q. All channels share one weight. The defaults are those of the authors' program: 0.45, a "
             "window of 21 x 21 pixels, patches of 7 x 7. Their second buffer, whose noise is independent of what "
             "is filtered, their smoothing of the variances and their adaptive sampling are left out. So is their "
             "epsilon of 1e-10 beside the variances: here 0/0 is 0 and all else over 0 infinite, so that the result "
             "follows the picture's unit. Windows and patches end at the picture's border, or that of --crop.\n\n"
             "A pixel whose standard deviation is 0 in all channels stays as it is, bit for bit; with --above T one "
             "whose largest is at most T times the mean of its components' sizes. --explain tells how many did. Alpha "
             "stays as it is; colours are taken as they are stored, associated with it. A pixel with a NaN or an "
             "infinity is not smoothed, has no part in the means of others, is no difference in a patch, and is "
             "repaired behind this verb as always. A standard deviation that is NaN or infinite counts as 0, "
             "and is counted on standard error; a negative one is no standard deviation, and refused.\n\n"
             "Both pictures must agree in data window, channels (but for alpha), primaries and encoding; --part, "
             "--layer, --channel, --level and --crop hold for both. Neither is held as a whole: blocks of rows are "
             "made of those around them. The result differs from that of --reference, which computes all sums in "
             "double, by no more than 1.2e-4 of the largest difference within the window (with the defaults; in "
             "renders "
             "some 1e-6).\n\n"
             "Nothing else can stand in front of this verb, since the noise was measured in the picture as it was "
             "read. It opens a file of this machine, so it does not travel through a pipe: its program computes the "
             "pixels, and sends EXR.",
         .examples = examples,
         .options = options,
         .kind = HDR_GUIDED,
         .stays = true},
    .params_size = sizeof(smooth_params),
    .check = check,
    .guide = guide,
};

/* A program: how noisy independent renders are. cmd/noise.c runs it. */
#include "verb/verb.h"

#include <string.h>

typedef struct noise_params {
    hdr_number epsilon, target;
    const char *sampling_map, *deviation_map, *plot;
} noise_params;

static const char *const none[] = {"none", NULL};

static const hdr_option options[] = {
    {.name = "epsilon",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(noise_params, epsilon),
     .metavar = "E",
     .min = 0,
     .max = 1e30,
     .above_min = true,
     .default_value = "0.01",
     .help = "of the relative noise: added to the square of the mean, so that black is no fault"},
    {.name = "target",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(noise_params, target),
     .metavar = "RMSE",
     .min = 0,
     .max = 1e30,
     .above_min = true,
     .words = none,
     .default_value = "none",
     .help = "tell how many renders bring the error of their mean down to this"},
    {.name = "sampling-map",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(noise_params, sampling_map),
     .metavar = "OUT",
     .help = "write each pixel's share of further samples there, as a picture whose mean is 1"},
    {.name = "deviation-map",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(noise_params, deviation_map),
     .metavar = "OUT",
     .help = "write the standard deviation of one render there, each component by itself"},
    {.name = "plot",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(noise_params, plot),
     .metavar = "FILE.svg",
     .help = "draw the noise of the means of 1, 2, 4, ... renders there"},
    {0}};

static hdr_status check_file(const char *option, const char *name, hdr_error *err) {
    bool none_named = name && (!*name || !strcmp(name, "-"));
    return none_named ? hdr_refuse_text(options, option, name, "names no file", err) : HDR_OK;
}

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const noise_params *p = params;
    (void)given;
    hdr_status status = check_file("sampling-map", p->sampling_map, err);
    if (status == HDR_OK) status = check_file("deviation-map", p->deviation_map, err);
    if (status == HDR_OK && p->sampling_map && p->deviation_map && !strcmp(p->sampling_map, p->deviation_map))
        status = hdr_refuse_text(options, "deviation-map", p->deviation_map, "is the sampling map, too", err);
    return status ? status : hdr_check_svg(options, "plot", p->plot, err);
}

static const char *const examples[] = {"hdr noise IN.exr IN.exr IN.exr",
                                       "hdr noise --target 0.01 --sampling-map OUT.exr IN.exr IN.exr IN.exr",
                                       "hdr noise --plot OUT.svg IN.exr IN.exr IN.exr IN.exr", NULL};

const hdr_verb hdr_verb_noise = {
    .about =
        {.name = "noise",
         .summary = "measure the noise of independent renders, without a reference",
         .details =
             "Tells how far independent renders of one scene differ: n runs of the same renderer with the same "
             "number of samples and other random numbers. With s^2 the variance of a number over the renders, divided "
             "by n - 1, rmv is the root of its mean over pixels and colour channels, the root mean variance. For an "
             "unbiased renderer it estimates the RMSE of one render against the truth, which nobody has; what is "
             "wrong in all renders alike, such as bias, it does not see. The noise of the mean of all n is rmv / "
             "sqrt(n). relative is the root of the mean of s^2 / (m^2 + E), m being the mean and E --epsilon.\n\n"
             "Behind +- stands the standard error, by the jackknife over renders: each is left out in turn (of "
             "relative, but for its part in m). It asks "
             "nothing of the pixels, which are not independent where a firefly is blurred over several; with "
             "fireflies it is large, and says so. It needs three renders.\n\n"
             "The table tells the same of the means of 2, 4, 8, ... renders that follow each other, and what "
             "independent ones would give, rmv / sqrt(2), and so on. If the noise falls more slowly, renders that "
             "follow each other are not independent. What all renders share does not show in any of these figures: a "
             "bias, or one noise in all. --plot draws the table, with its standard errors, on logarithmic axes: the "
             "means of "
             "independent renders lie along the line.\n\n"
             "--target tells from rmv how many renders of that kind have a mean with that RMSE. --sampling-map "
             "writes a picture of one channel: how much more often than the average a pixel should be sampled, in "
             "proportion to its standard deviation, which gives the mean its least variance (Neyman 1934). "
             "--deviation-map writes the picture of that standard deviation "
             "itself, component by component: that of one render, as 'hdr mean --show deviation' makes it.\n\n"
             "Components that are NaN or infinite in one render are left out of all, and counted; with --strict that "
             "is an error. The map begins at 0,0, wherever the data window does, and gives no samples to a pixel whose "
             "components are all left out.\n\n"
             "Rows of all renders are held together, as they are stored, a chunk's height at a time; of tiles, some "
             "columns. What does not fit --memory is decoded more than once.",
         .examples = examples,
         .options = options,
         .kind = HDR_PROGRAM},
    .params_size = sizeof(noise_params),
    .check = check,
};

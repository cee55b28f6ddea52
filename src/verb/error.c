/* A program: errors of pictures against a reference. cmd/error.c runs it. */
#include "verb/verb.h"

#include <stdlib.h>
#include <string.h>

typedef struct error_params {
    const char *against, *threshold, *flip_map;
    int rank, flip;
    hdr_number epsilon, peak, pixels_per_degree;
    bool csv, by_channel, ssim;
} error_params;

static const char *const figures[] = {"rmse", "mse", "mae", "mrse", "mape", "smape", "flip", NULL};
static const char *const flips[] = {"none", "auto", "ldr", "hdr", NULL};
static const char *const none[] = {"none", NULL};

static const hdr_option options[] = {
    {.name = "against",
     .letter = 'r',
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(error_params, against),
     .metavar = "FILE",
     .help = "the reference"},
    {.name = "epsilon",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(error_params, epsilon),
     .metavar = "E",
     .min = 0,
     .max = 1e30,
     .above_min = true,
     .default_value = "0.01",
     .help = "added to the divisors of relative figures, so that black is no fault"},
    {.name = "peak",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(error_params, peak),
     .metavar = "P",
     .min = 0,
     .max = 1e30,
     .above_min = true,
     .words = none,
     .default_value = "none",
     .help = "tell the PSNR for this peak; none: only of encoded pictures, whose peak is 1"},
    {.name = "rank",
     .type = HDR_OPTION_CHOICE,
     .offset = offsetof(error_params, rank),
     .metavar = "FIGURE",
     .words = figures,
     .default_value = "rmse",
     .help = "several tests are put in order by this figure"},
    {.name = "threshold",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(error_params, threshold),
     .metavar = "FIGURE=VALUE",
     .help = "end with status 1 if a test's figure is above the value"},
    {.name = "ssim",
     .type = HDR_OPTION_FLAG,
     .offset = offsetof(error_params, ssim),
     .help = "tell the structural similarity of the encoded pictures, too"},
    {.name = "flip",
     .type = HDR_OPTION_CHOICE,
     .offset = offsetof(error_params, flip),
     .metavar = "KIND",
     .words = flips,
     .default_value = "none",
     .help = "tell FLIP, too: of what a display shows, or of light; auto: of light where the pictures are linear"},
    {.name = "pixels-per-degree",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(error_params, pixels_per_degree),
     .metavar = "P",
     .min = 0,
     .max = HDR_FLIP_MOST_PIXELS,
     .above_min = true,
     .default_value = "67.0206",
     .help = "how many FLIP's viewer sees: 3840 on 0.7 m from 0.7 m by default"},
    {.name = "flip-map",
     .type = HDR_OPTION_TEXT,
     .offset = offsetof(error_params, flip_map),
     .metavar = "OUT",
     .help = "write each pixel's FLIP there, of one test"},
    {.name = "by-channel",
     .type = HDR_OPTION_FLAG,
     .offset = offsetof(error_params, by_channel),
     .help = "tell the figures of each channel, too"},
    {.name = "csv",
     .type = HDR_OPTION_FLAG,
     .offset = offsetof(error_params, csv),
     .help = "print comma-separated values"},
    {0}};

/* FIGURE=VALUE, the figure being one of the words. */
static bool is_threshold(const char *text) {
    size_t length = strcspn(text, "=");
    double value;
    for (int i = 0; figures[i]; i++)
        if (strlen(figures[i]) == length && !strncmp(text, figures[i], length) && text[length]) {
            const char *end = hdr_read_number(text + length + 1, &value);
            return end && !*end && value >= 0;
        }
    return false;
}

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const error_params *p = params;
    (void)given;
    if (p->against && !*p->against) return hdr_refuse_text(options, "against", "", "names no file", err);
    if (p->threshold && !is_threshold(p->threshold))
        return hdr_refuse_text(options, "threshold", p->threshold,
                               "is no figure (rmse, mse, mae, mrse, mape, smape or flip), = and a number, such as "
                               "rmse=0.01",
                               err);
    if (p->flip_map && (!*p->flip_map || !strcmp(p->flip_map, "-")))
        return hdr_refuse_text(options, "flip-map", p->flip_map, "names no file", err);
    return HDR_OK;
}

static const char *const examples[] = {"hdr error --against IN.exr IN.exr",
                                       "hdr error --against IN.exr --threshold rmse=0.01 --json IN.exr",
                                       "hdr error --against IN.exr --flip auto --flip-map OUT.exr IN.exr", NULL};

const hdr_verb hdr_verb_error = {
    .about =
        {.name = "error",
         .summary = "measure how far pictures are from a reference",
         .details =
             "Compares each file with the reference, which must agree with it in data window, channels and "
             "primaries. With x a number of the test, r the reference's and E --epsilon, the figures are means over "
             "pixels and colour channels:\n\n"
             "bias: of x - r. mae: of |x - r|. mse: of (x - r)^2; rmse is its root. mrse: of (x - r)^2 / (r^2 + E), "
             "which others define with (r + E)^2 or another E: compare only what was computed alike. mape: of |x - r| "
             "/ (|r| + E). smape: of |x - r| / (|x| + |r| + E), without the factor 2 that some have. psnr: 10 "
             "log10(P^2 / mse), in decibels, which says nothing about linear pictures unless their peak is named; "
             "of equal pictures it is infinite: inf, and in JSON null.\n\n"
             "Components are taken as they are stored, colour associated with alpha; where either is NaN or "
             "infinite, they are left out and counted. The pixel with the largest difference is told, in the file's "
             "coordinates.\n\n"
             "ssim is the structural similarity (Wang et al. 2004) of luma in [0,1], over black, of linear pictures "
             "encoded by sRGB first: the mean over all windows of 11 x 11 pixels that lie in the picture, weighted by "
             "a Gaussian of standard deviation 1.5, with K1 = 0.01, K2 = 0.03 and L = 1. Like flip it holds both "
             "pictures in memory, however little --memory allows.\n\n"
             "flip is how large a difference is seen when the two pictures are shown in turn at one place, in [0,1], "
             "the mean over pixels (FLIP, Andersson et al. 2020): an edge or a point that one of them lacks counts, "
             "noise that is too fine for the eye does not. It depends on --pixels-per-degree, which is the distance "
             "from the display, in its widths, times its pixels across, times pi / 180. LDR-FLIP is of what a display "
             "shows: encoded pictures as they are, taken for sRGB, linear ones clamped to [0,1]. HDR-FLIP (Andersson "
             "et "
             "al. 2021) is of light: in each pixel the largest over exposures, tone mapped by a fit of the ACES curve. "
             "The first exposure takes the reference's largest luminance to 0.85 on the display, the last its median, "
             "and those between are a stop or so apart. Where half of the reference is black, the median of the rest "
             "counts. What is good enough depends on the scene: compare FLIPs of one reference, one kind and one "
             "number of pixels per degree. The median and the quartiles are weighted, as its authors have them: half "
             "of all error is in pixels with no more than the median. FLIP and its map, which begins at 0,0, are of "
             "the data window, repaired, over black. A ranking by flip, a threshold of it and its map call for it, "
             "too.\n\n"
             "Several tests are ranked by --rank. Behind the figure stands its standard error, from how it differs "
             "between squares of 64 pixels, where there are two or more. A test is marked by = if it cannot be told "
             "from the one above it: they differ by no more than 1.96 standard errors of the difference, square by "
             "square, which equal ones would exceed in one of twenty comparisons.\n\n"
             "--threshold is for the regression tests of renderers: status 1 tells that a figure is above it, or that "
             "not all components are finite. Where none is, or with --strict where one is not, the file is refused.",
         .examples = examples,
         .options = options,
         .kind = HDR_PROGRAM},
    .params_size = sizeof(error_params),
    .check = check,
};

/* A program: errors of pictures against a reference. cmd/error.c runs it. */
#include "verb/verb.h"

#include <stdlib.h>
#include <string.h>

typedef struct error_params {
    const char *against, *threshold;
    int rank;
    hdr_number epsilon, peak;
    bool csv, by_channel, ssim;
} error_params;

static const char *const figures[] = {"rmse", "mse", "mae", "mrse", "mape", "smape", NULL};
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
                               "is no figure (rmse, mse, mae, mrse, mape or smape), = and a number, such as rmse=0.01",
                               err);
    return HDR_OK;
}

static const char *const examples[] = {"hdr error --against IN.exr IN.exr",
                                       "hdr error --against IN.exr --threshold rmse=0.01 --json IN.exr", NULL};

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
             "log10(P^2 / mse), in decibels, which says nothing about linear pictures unless their peak is named.\n\n"
             "Components are taken as they are stored, colour associated with alpha; where either is NaN or "
             "infinite, they are left out and counted. The pixel with the largest difference is told, in the file's "
             "coordinates.\n\n"
             "Several tests are ranked by --rank. Behind the figure stands its standard error, from how it differs "
             "between squares of 64 pixels, where there are two or more. A test is marked by = if it cannot be told "
             "from the one above it: they differ by no more than 1.96 standard errors of the difference, square by "
             "square, which equal ones would exceed in one of forty comparisons.\n\n"
             "--threshold is for the regression tests of renderers: status 1 tells that a figure is above it, or that "
             "not all components are finite. Where none is, or with --strict where one is not, the file is refused.",
         .examples = examples,
         .options = options,
         .kind = HDR_PROGRAM},
    .params_size = sizeof(error_params),
    .check = check,
};

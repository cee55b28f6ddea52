/* Quantisation to codes. */
#include "verb/verb.h"

#include <math.h>
#include <stdio.h>

typedef struct quantise_params {
    hdr_number bits;
    hdr_dither_params dither;
} quantise_params;

static const hdr_option options[] = {{.name = "bits",
                                      .type = HDR_OPTION_INTEGER,
                                      .offset = offsetof(quantise_params, bits),
                                      .metavar = "BITS",
                                      .min = 1,
                                      .max = 16,
                                      .default_value = "8",
                                      .help = "bits of a code"},
                                     HDR_DITHER_OPTIONS(quantise_params),
                                     {0}};

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const quantise_params *p = params;
    return hdr_dither_check(&p->dither, given, err);
}

/* code = floor(v (2^b - 1) + t), v held to [0,1]; C' = code / (2^b - 1) = v[0]. */
HDR_INLINE double rounded(const hdr_constants *k, double c, double t) {
    double raised = c > 0 ? c : 0;
    double held = raised < 1 ? raised : 1;
    return floor(held * k->v[0] + t) / k->v[0];
}

/* t = 1/2. The PNG specification, 3rd ed. 2023, 13.12: sample depth rescaling rounds to nearest so. */
HDR_INLINE double quantise_of(const hdr_constants *k, double c) {
    return rounded(k, c, 0.5);
}
HDR_CURVE_MONOTONE(quantise)

/* t in (0,1), by the pixel's place: 0 stays 0 and 1 stays 1, since no t lifts a whole number to the next. */
HDR_INLINE double dithered_of(const hdr_constants *k, double c, double t) {
    return rounded(k, c, t);
}
HDR_LOCAL_CURVE(dithered, NULL)

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    (void)scene;
    (void)err;
    const quantise_params *p = params;
    step->bits = (int)p->bits.value;
    step->for_display = true;
    step->constants.v[0] = (double)((1 << step->bits) - 1);
    if (p->dither.kind == HDR_DITHER_NONE) {
        step->form = HDR_FORM_CHANNEL;
        step->curve = &quantise;
        snprintf(step->note, sizeof step->note, "%d bits", step->bits);
    } else {
        step->form = HDR_FORM_PLACED;
        step->local = &dithered;
        step->dither = hdr_dither_seeded((hdr_dither_kind)p->dither.kind, (uint32_t)p->dither.seed.value);
        snprintf(step->note, sizeof step->note, "%d bits, dither %s, moved by %u,%u", step->bits,
                 hdr_dither_words[p->dither.kind], step->dither.x, step->dither.y);
    }
    return HDR_RUN;
}

static const char *const examples[] = {"hdr exp then srgb then quantise --bits 5 then png -o OUT.png IN.exr",
                                       "hdr exp then srgb then quantise --bits 5 --dither blue then png -o OUT.png "
                                       "IN.exr",
                                       NULL};

const hdr_verb hdr_verb_quantise = {
    .about = {.name = "quantise",
              .summary = "round to codes of a number of bits",
              .details =
                  "code = floor(C (2^b - 1) + 1/2), with C held to [0,1] and b = --bits; what stays in the chain is "
                  "code / (2^b - 1).\n\n"
                  "It is for encoded pictures (see hdr-srgb and hdr-gamma): linear values of 8 bits show steps in the "
                  "shadows, which is said on standard error. A PNG quantises by itself; give this verb to have fewer "
                  "bits.\n\n"
                  "Rounding makes bands of smooth gradients. With --dither the 1/2 becomes (rank + 1/2) / 4096, where "
                  "the ranks 0 to 4095 stand in a tile of 64 x 64 pixels that covers the plane: a value between two "
                  "codes gets the upper one at as many pixels as is right, and the mean over a tile is off by 1/8192 "
                  "of a code at most. Black, white, and any other value that is a whole code stay as they are, and no "
                  "code is as much as 1 from its value. The noise is greatest half way between two codes.\n\n"
                  "--dither blue has the ranks by the void-and-cluster method (Ulichney 1993): pixels that are rounded "
                  "up lie apart, in no order that the eye finds. --dither ordered has Bayer's matrix (1973): its "
                  "regular patterns show, but compress better, which counts for pictures of few bits.\n\n"
                  "The pattern depends on nothing but a pixel's place, in the file's own coordinates: a piece that "
                  "--crop takes shows the same as the whole. All colour channels have the same threshold, so that grey "
                  "stays grey, and a grey picture is the same in one channel as in three; alpha is never dithered. "
                  "Another --seed moves the pattern, so that, with the number of the frame, it does not stand still "
                  "before a sequence as dirt on a lens does.",
              .examples = examples,
              .options = options,
              .kind = HDR_FILTER},
    .params_size = sizeof(quantise_params),
    .check = check,
    .plan = plan,
};

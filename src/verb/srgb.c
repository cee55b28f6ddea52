/* The transfer curve of sRGB. */
#include "kernel/real.h"
#include "verb/verb.h"

#include <stdio.h>

typedef struct srgb_params {
    hdr_encoding_params encoding;
} srgb_params;

static const hdr_option options[] = {HDR_ENCODING_OPTIONS(srgb_params), {0}};

/* IEC 61966-2-1:1999, 5.2: C' = 12.92 C for C <= 0.0031308, else 1.055 C^(1/2.4) - 0.055. */
#define SRGB_JOINT 0.0031308 /* where the published branches meet they fall by 2.9e-8 */
HDR_INLINE double srgb_encode_of(const hdr_constants *k, double c) {
    (void)k;
    bool linear = c <= SRGB_JOINT;
    double above = linear ? 1 : c;
    double curved = 1.055 * hdr_pow(above, 1 / 2.4) - 0.055;
    return linear ? 12.92 * c : curved;
}
HDR_CURVE_JOINED(srgb_encode, SRGB_JOINT)

/* The inverse: C' = C / 12.92 for C <= 0.04045, else ((C + 0.055) / 1.055)^2.4. */
HDR_INLINE double srgb_decode_of(const hdr_constants *k, double c) {
    (void)k;
    bool linear = c <= 0.04045;
    double above = linear ? 1 : c;
    double curved = hdr_pow((above + 0.055) / 1.055, 2.4);
    return linear ? c / 12.92 : curved;
}
HDR_CURVE(srgb_decode)

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    const srgb_params *p = params;
    snprintf(step->note, sizeof step->note, "IEC 61966-2-1%s", p->encoding.decode ? ", inverse" : "");
    return hdr_encoding_step(&p->encoding, &srgb_encode, &srgb_decode, "srgb", scene, step, err);
}

static const char *const examples[] = {"hdr exp then srgb then png -o OUT.png IN.exr",
                                       "hdr srgb --decode -o OUT.exr IN.exr", NULL};

const hdr_verb hdr_verb_srgb = {
    .about = {.name = "srgb",
              .summary = "encode by the sRGB curve",
              .details =
                  "IEC 61966-2-1: C' = 12.92 C for C <= 0.0031308, else 1.055 C^(1/2.4) - 0.055. With --decode the "
                  "inverse: C' = C / 12.92 "
                  "for C <= 0.04045, else ((C + 0.055) / 1.055)^2.4. Negative components keep the linear "
                  "branch." HDR_ENCODING_DETAILS,
              .examples = examples,
              .options = options,
              .kind = HDR_FILTER},
    .params_size = sizeof(srgb_params),
    .plan = plan,
};

/* The transfer curve of ITU-R BT.2100, hybrid log-gamma. */
#include "kernel/real.h"
#include "verb/verb.h"

#include <math.h>
#include <stdio.h>

typedef struct hlg_params {
    hdr_encoding_params encoding;
} hlg_params;

static const hdr_option options[] = {HDR_ENCODING_OPTIONS(hlg_params), {0}};

/* ITU-R BT.2100-2, table 5: a, b = 1 - 4 a and c = 0.5 - a ln(4 a), with which the branches meet at 1/12 and 1/2. */
#define HLG_A 0.17883277
#define HLG_B 0.28466892
#define HLG_C 0.559910729529562

/* The same, OETF: C' = sqrt(3 C) for C <= 1/12, else a ln(12 C - b) + c; negative C counts as 0. The square root is
 * one of IEEE 754's own operations, the same to the last bit everywhere. */
HDR_INLINE double hlg_encode_of(const hdr_constants *k, double c) {
    (void)k;
    double positive = c > 0 ? c : 0;
    bool root = positive <= 1.0 / 12;
    double above = root ? 1 : positive;
    double curved = HLG_A * hdr_log(12 * above - HLG_B) + HLG_C;
    return root ? sqrt(3 * positive) : curved;
}
HDR_CURVE(hlg_encode)

/* The inverse: C' = C^2 / 3 for C <= 1/2, else (exp((C - c) / a) + b) / 12. */
HDR_INLINE double hlg_decode_of(const hdr_constants *k, double c) {
    (void)k;
    double positive = c > 0 ? c : 0;
    bool root = positive <= 0.5;
    double above = root ? 1 : positive;
    double curved = (hdr_exp((above - HLG_C) / HLG_A) + HLG_B) / 12;
    return root ? positive * positive / 3 : curved;
}
HDR_CURVE(hlg_decode)

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    const hlg_params *p = params;
    snprintf(step->note, sizeof step->note, "ITU-R BT.2100 HLG%s", p->encoding.decode ? ", inverse" : "");
    return hdr_encoding_step(&p->encoding, &hlg_encode, &hlg_decode, "hlg", scene, step, err);
}

static const char *const examples[] = {"hdr divmax then hlg then quantise --bits 10 then png -o OUT.png IN.exr",
                                       "hdr hlg --decode -o OUT.exr IN.exr", NULL};

const hdr_verb hdr_verb_hlg = {
    .about =
        {.name = "hlg",
         .summary = "encode by the hybrid log-gamma curve of HDR television",
         .details =
             "ITU-R BT.2100, the opto-electronic transfer function of HLG: C' = sqrt(3 C) for C <= 1/12, else a ln(12 "
             "C - b) + c, with a = 0.17883277, b = 1 - 4 a and c = 0.5 - a ln(4 a). With --decode the inverse: C' = "
             "C^2 / 3 for C <= 1/2, else (exp((C - c) / a) + b) / 12. Negative components become 0.\n\n"
             "The curve is of the scene, not of the display: 1 is the brightest that the camera is to hold, and each "
             "display makes of it what it can, by a system gamma of its own, which this verb has no part in. Bring "
             "the picture into [0,1] first, by divmax or expose; diffuse white belongs at 0.265, which becomes 0.75. "
             "What is above 1 is cut by what writes codes.\n\n"
             "On a display that does not know the curve such a picture still looks passable, which is what it was "
             "made for. 8 bits show steps: take 10 or more. A PNG made of it carries a cICP chunk that names the "
             "curve." HDR_ENCODING_DETAILS,
         .examples = examples,
         .options = options,
         .kind = HDR_FILTER},
    .params_size = sizeof(hlg_params),
    .plan = plan,
};

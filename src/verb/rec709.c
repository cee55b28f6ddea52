/* The transfer curve of BT.709: a camera's. */
#include "kernel/real.h"
#include "verb/verb.h"

#include <stdio.h>

typedef struct rec709_params {
    hdr_encoding_params encoding;
} rec709_params;

static const hdr_option options[] = {HDR_ENCODING_OPTIONS(rec709_params), {0}};

/* ITU-R BT.709-6, item 1.2: C' = 4.5 C for C < 0.018, else 1.099 C^0.45 - 0.099. With these rounded constants it rises
 * at the joint, from 0.081 to 0.08125. */
HDR_INLINE double rec709_encode_of(const hdr_constants *k, double c) {
    (void)k;
    bool linear = c < 0.018;
    double above = linear ? 1 : c;
    double curved = 1.099 * hdr_pow(above, 0.45) - 0.099;
    return linear ? 4.5 * c : curved;
}
HDR_CURVE(rec709_encode)

/* The inverse: C' = C / 4.5 for C < 0.081, else ((C + 0.099) / 1.099)^(1/0.45). As the one rises, this falls where its
 * branches meet, from 0.018 to 0.017945. */
#define BELOW_JOINT 0x1.4bc6a7ef9db22p-4 /* the largest double below 0.081 */
HDR_INLINE double rec709_decode_of(const hdr_constants *k, double c) {
    (void)k;
    bool linear = c < 0.081;
    double above = linear ? 1 : c;
    double curved = hdr_pow((above + 0.099) / 1.099, 1 / 0.45);
    return linear ? c / 4.5 : curved;
}
HDR_CURVE_JOINED(rec709_decode, BELOW_JOINT)

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    const rec709_params *p = params;
    snprintf(step->note, sizeof step->note, "ITU-R BT.709%s", p->encoding.decode ? ", inverse" : "");
    return hdr_encoding_step(&p->encoding, &rec709_encode, &rec709_decode, "rec709", scene, step, err);
}

static const char *const examples[] = {"hdr exp then rec709 then quantise --bits 10 then png -o OUT.png IN.exr",
                                       "hdr rec709 --decode -o OUT.exr IN.exr", NULL};

const hdr_verb hdr_verb_rec709 = {
    .about =
        {.name = "rec709",
         .summary = "encode by the BT.709 curve of cameras",
         .details =
             "ITU-R BT.709: C' = 4.5 C for C < 0.018, else 1.099 C^0.45 - 0.099. With --decode the inverse: C' = C / "
             "4.5 for C < 0.081, else ((C + 0.099) / 1.099)^(1/0.45). Negative components keep the linear branch.\n\n"
             "It is what a video camera makes of light, and of use where a picture is to be mixed with such material, "
             "or such material is to be made linear. A display does not undo it: a television applies BT.1886, in "
             "essence a power of 2.4, so that a scene encoded by this curve is shown with more contrast than it had, "
             "as suits a dim room. For a computer's display take srgb; for values that a display of BT.1886 is to show "
             "as they are, gamma -g 2.4.\n\n"
             "The published constants are rounded, and the branches do not quite meet: at 0.018 the curve jumps from "
             "0.081 to 0.08125, and its inverse falls from 0.018 to 0.017945. A PNG made of it carries a cICP chunk "
             "that names the curve." HDR_ENCODING_DETAILS,
         .examples = examples,
         .options = options,
         .kind = HDR_FILTER},
    .params_size = sizeof(rec709_params),
    .plan = plan,
};

/* The transfer curve of SMPTE ST 2084: luminances from 0 to 10,000 cd/m2. */
#include "kernel/real.h"
#include "verb/verb.h"

#include <float.h>
#include <stdio.h>

typedef struct pq_params {
    hdr_number nits;
    hdr_encoding_params encoding;
} pq_params;

static const hdr_option options[] = {{.name = "nits",
                                      .type = HDR_OPTION_NUMBER,
                                      .offset = offsetof(pq_params, nits),
                                      .metavar = "NITS",
                                      .min = 0,
                                      .max = 1e6,
                                      .above_min = true,
                                      .default_value = "100",
                                      .help = "the luminance of 1.0, in candelas per square metre"},
                                     HDR_ENCODING_OPTIONS(pq_params),
                                     {0}};

/* SMPTE ST 2084:2014, 5: m1 = 2610/4096/4, m2 = 2523/4096 128, c1 = 3424/4096, c2 = 2413/4096 32, c3 = 2392/4096 32.
 * All are exact in double; and c1 = c3 - c2 + 1. */
#define PQ_M1 (2610.0 / 16384)
#define PQ_M2 (2523.0 * 128 / 4096)
enum { C1_4096 = 3424, C2_4096 = 2413 * 32, C3_4096 = 2392 * 32 };
_Static_assert(C1_4096 == C3_4096 - C2_4096 + 4096, "c1 = c3 - c2 + 1");
#define PQ_C3 (C3_4096 / 4096.0)
#define PQ_REST ((C2_4096 - C3_4096) / 4096.0) /* c2 - c3 = 1 - c1 */

/* 5.1: V = ((c1 + c2 y) / (1 + c3 y))^m2, y = (max(C, 0) nits / 10000)^m1; nits / 10000 = v[0].
 *
 * The power of 78.84 would make that many of each rounding of its base, which is close to 1: 1.5e-9 of a 16-bit code.
 * Since c1 = 1 - (c2 - c3), the base is 1 + (c2 - c3)(y - 1) / (1 + c3 y), whose logarithm keeps its digits: V is then
 * within 1e-15. */
HDR_INLINE double pq_encode_of(const hdr_constants *k, double c) {
    double positive = c > 0 ? c : 0;
    double y = hdr_pow(positive * k->v[0], PQ_M1);
    return hdr_exp(PQ_M2 * hdr_log1p(PQ_REST * (y - 1) / (1 + PQ_C3 * y)));
}
HDR_CURVE(pq_encode)

/* 5.2, the inverse: C = y^(1/m1) 10000 / nits, y = max(V^(1/m2) - c1, 0) / (c2 - c3 V^(1/m2)), V held to [0,1].
 *
 * With s = 1 - V^(1/m2) = 1 - exp(ln V / m2): y = max((c2 - c3) - s, 0) / ((c2 - c3) + c3 s), in which nothing cancels
 * but where y itself vanishes. */
HDR_INLINE double pq_decode_of(const hdr_constants *k, double v) {
    double raised = v > 0 ? v : 0;
    double held = raised < 1 ? raised : 1;
    double s = hdr_one_minus_exp_neg(hdr_log(held) / -PQ_M2);
    double left = PQ_REST - s;
    double numerator = left > 0 ? left : 0;
    return hdr_pow(numerator / (PQ_REST + PQ_C3 * s), 1 / PQ_M1) / k->v[0];
}
HDR_CURVE(pq_decode)

/* Light is lost where it is decoded with other nits. */
static const char *state_of(const pq_params *p, char state[64]) {
    if (p->nits.value == 100)
        snprintf(state, 64, "pq");
    else
        snprintf(state, 64, "pq %.15g", p->nits.value);
    return state;
}

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    const pq_params *p = params;
    char state[64];
    double whole = p->nits.value / 10000;
    step->constants.v[0] = whole > DBL_MIN ? whole : DBL_MIN; /* not 0, which 0 cannot be divided by */
    snprintf(step->note, sizeof step->note, "SMPTE ST 2084%s, 1 is %.9g cd/m2", p->encoding.decode ? ", inverse" : "",
             p->nits.value);
    return hdr_encoding_step(&p->encoding, &pq_encode, &pq_decode, state_of(p, state), scene, step, err);
}

static const char *const examples[] = {"hdr pq then png --bits 16 -o OUT.png IN.exr",
                                       "hdr expose --auto then pq --nits 203 then quantise --bits 10 then png -o "
                                       "OUT.png IN.exr",
                                       "hdr pq --decode -o OUT.exr IN.exr", NULL};

const hdr_verb hdr_verb_pq = {
    .about =
        {.name = "pq",
         .summary = "encode by the PQ curve of HDR displays",
         .details =
             "SMPTE ST 2084, perceptual quantisation: V = ((c1 + c2 y) / (1 + c3 y))^m2 with y = (L / 10000)^m1, where "
             "L = NITS C is the light that the display is to give, in candelas per square metre, and m1 = 2610/16384, "
             "m2 = 2523/4096 x 128, c1 = 3424/4096, c2 = 2413/4096 x 32, c3 = 2392/4096 x 32. Negative components "
             "become 0; 0 becomes 7.3e-7. With --decode the inverse: L = 10000 (max(V^(1/m2) - c1, 0) / (c2 - c3 "
             "V^(1/m2)))^(1/m1), with V held to [0,1], and C = L / NITS.\n\n"
             "The curve is absolute: a code means a luminance, the same on every display that can show it, and V = 1 "
             "is 10000 cd/m2. --nits says what 1.0 of the picture is to be: 100 is the white of a picture for an "
             "ordinary display, 203 the diffuse white that ITU-R BT.2408 recommends. A scene whose light is not scaled "
             "yet goes through expose first; what is above 10000 cd/m2 is cut by what writes codes.\n\n"
             "8 bits show steps: take 10 or more. A PNG made of it carries a cICP chunk that names the "
             "curve." HDR_ENCODING_DETAILS,
         .examples = examples,
         .options = options,
         .kind = HDR_FILTER},
    .params_size = sizeof(pq_params),
    .plan = plan,
};

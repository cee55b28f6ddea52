/* The curves of encodings in double, both ways, against MPFR: what --reference and every table of codes rest on. SPEC
 * lets it stand for the real value unless that lies within 1e-9 of a code of a rounding boundary, so it must be that
 * close: 1e-9 of a 16-bit code wherever a code may come out, and a sixth of what half a float's ulp is everywhere. They
 * are much closer; that a constant has lost its last digit shows only if they stay so. */
#include "check.h"
#include "oracle_chain.h"
#include "verb/verb.h"

enum { VALUES = 20000 };

static const struct {
    const char *words[3];
    oracle_verb verb;
    oracle_number number;  /* the option's: nits, or the exponent */
    double encode, decode; /* what part of what is allowed they take, at most */
} curves[] = {
    {{"gamma", "--exponent", "2.2"}, ORACLE_GAMMA, {"2.2", 2.2L}, 0.05, 0.05},
    {{"gamma", "--exponent", "1.8"}, ORACLE_GAMMA, {"1.8", 1.8L}, 0.05, 0.05},
    {{"srgb"}, ORACLE_SRGB, {NULL, 0}, 0.05, 0.05},
    {{"rec709"}, ORACLE_REC709, {NULL, 0}, 0.05, 0.05},
    {{"pq", "--nits", "100"}, ORACLE_PQ, {"100", 100}, 0.05, 0.2},
    {{"pq", "--nits", "203"}, ORACLE_PQ, {"203", 203}, 0.05, 0.2},
    {{"pq", "--nits", "10000"}, ORACLE_PQ, {"10000", 10000}, 0.05, 0.2},
    {{"hlg"}, ORACLE_HLG, {NULL, 0}, 0.05, 0.05},
};

static uint64_t random_state = 1;

static double random_unit(void) {
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (double)(random_state >> 11) * 0x1p-53;
}

/* Where branches meet, from both sides; not there itself, since the decimal is no double. */
static const double joints[] = {0.0031308, 0.04045, 0.018, 0.081, 1.0 / 12, 0.5};
static const double beside[] = {-1e-3, -1e-5, -0x1p-50, 0x1p-50, 1e-5, 1e-3};
enum { JOINTS = sizeof joints / sizeof *joints, BESIDE = sizeof beside / sizeof *beside };

/* Those, then within [0,1] by halves, and all that float holds, of either sign. */
static double choose_value(int i) {
    if (i < JOINTS * BESIDE) return joints[i / BESIDE] * (1 + beside[i % BESIDE]);
    if (i % 2) return random_unit();
    int exponent = i % 4 ? (int)(random_unit() * 40) - 30 : (int)(random_unit() * 276) - 149;
    double magnitude = ldexp(1 + random_unit(), exponent);
    return i % 32 ? magnitude : -magnitude;
}

/* The step that the verb plans. */
static bool make_step(const char *const words[3], bool decode, hdr_step *step) {
    const hdr_verb *verb = hdr_verb_find(words[0]);
    hdr_options given = {0};
    hdr_error error = {0};
    hdr_scene scene = {.state = "linear"};
    const hdr_option *table = verb->about.options;
    void *params = calloc(1, verb->params_size);
    hdr_options_default(table, params);
    if (words[1]) hdr_option_set(hdr_option_find(table, words[1] + 2), words[2], params, &given, &error);
    if (decode) hdr_option_set(hdr_option_find(table, "decode"), NULL, params, &given, &error);
    *step = (hdr_step){.verb = verb};
    bool planned = !error.status && verb->plan(params, &scene, step, &error) == HDR_RUN && step->curve;
    hdr_options_free(&given);
    free(params);
    return planned;
}

/* How far from the real value the library's is, in what is allowed. */
static double distance(const hdr_step *step, const oracle_step *right, double value) {
    exact_empty();
    exact real = exact_encoding(right, exact_from(value));
    double got = step->curve->exact(&step->constants, value);
    double size = (double)fabsl(exact_to(real)), error = (double)fabsl(exact_to(exact_subtract(real, exact_from(got))));
    if (size > (double)FLT_MAX) return fabs(got) >= (double)FLT_MAX ? 0 : INFINITY;
    if (error > 1e-8 * size && error > 1e-46) return INFINITY; /* half an ulp of a float is 2^-24 of it, or 2^-150 */
    return size <= 1 ? error / (1e-9 / 65535) : 0;
}

int main(void) {
    for (size_t c = 0; c < sizeof curves / sizeof curves[0]; c++)
        for (int decode = 0; decode < 2; decode++) {
            hdr_step step;
            oracle_step right = oracle_default_step(curves[c].verb);
            right.decode = decode;
            if (curves[c].verb == ORACLE_PQ) right.nits = curves[c].number;
            if (curves[c].verb == ORACLE_GAMMA) right.exponent = curves[c].number;
            bool planned = make_step(curves[c].words, decode, &step);
            CHECK(planned, "%s: no curve", curves[c].words[0]);
            double farthest = 0, where = 0, most = decode ? curves[c].decode : curves[c].encode;
            for (int i = 0; planned && i < VALUES; i++) {
                double value = choose_value(i), far = distance(&step, &right, value);
                if (far > farthest) farthest = far, where = value;
            }
            fprintf(stderr, "%s %s%s: at most %.3g of what is allowed, at %.17g\n", curves[c].words[0],
                    curves[c].words[2] ? curves[c].words[2] : "", decode ? " --decode" : "", farthest, where);
            CHECK(farthest <= most, "%s%s is %g of what is allowed from the real value, at %.17g", curves[c].words[0],
                  decode ? " --decode" : "", farthest, where);
        }
    return check_done("test_curves");
}

/* Reinhard, Stark, Shirley and Ferwerda, Photographic Tone Reproduction for Digital Images, SIGGRAPH 2002: global, and
 * local with automatic dodging and burning. */
#include "kernel/real.h"
#include "spatial/scales.h"
#include "verb/verb.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct reinhard_params {
    hdr_number key, white, delta, phi, epsilon;
    bool local;
    hdr_shot shot;
    hdr_luminance_params luminance;
} reinhard_params;

enum { KEY_ESTIMATE };
static const char *const key_words[] = {"estimate", NULL};
enum { WHITE_BY_KEY, WHITE_AUTO, WHITE_INFINITE };
static const char *const white_words[] = {"by-key", "auto", "inf", NULL};

#define DEFAULT_KEY 0.18

static const hdr_option options[] = {
    {.name = "key",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(reinhard_params, key),
     .metavar = "KEY",
     .min = 0,
     .max = 1e50,
     .above_min = true,
     .words = key_words,
     .default_value = "0.18",
     .help = "what the log-average becomes; estimate takes it from the scene"},
    {.name = "white",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(reinhard_params, white),
     .metavar = "WHITE",
     .min = 1e-50,
     .max = 1e100,
     .words = white_words,
     .default_value = "by-key",
     .help = "the scaled luminance that becomes 1: auto is the largest, inf none; by-key is auto, or what --key "
             "estimate says"},
    {.name = "delta",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(reinhard_params, delta),
     .metavar = "D",
     .min = 0,
     .max = 1e30,
     .default_value = "0",
     .help = "above 0: average ln(D + Y) over all pixels, not ln Y over the lit ones"},
    {.name = "local",
     .type = HDR_OPTION_FLAG,
     .offset = offsetof(reinhard_params, local),
     .help = "dodge and burn: measure each pixel against its own surround"},
    {.name = "phi",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(reinhard_params, phi),
     .metavar = "PHI",
     .min = -100,
     .max = 100,
     .default_value = "8",
     .help = "with --local: sharpness; the larger, the less counts an edge at small scales"},
    {.name = "epsilon",
     .type = HDR_OPTION_NUMBER,
     .offset = offsetof(reinhard_params, epsilon),
     .metavar = "EPSILON",
     .min = 0,
     .max = 1e6,
     .default_value = "0.05",
     .help = "with --local: the activity from which on a surround is no longer even"},
    HDR_LUMINANCE_OPTIONS(reinhard_params),
    HDR_FACTS_OPTION(reinhard_params),
    {0}};

static hdr_status check(const void *params, const hdr_options *given, hdr_error *err) {
    const reinhard_params *p = params;
    for (int i = 0; i < given->count && !p->local; i++) {
        const char *name = given->given[i].option->name;
        if (!strcmp(name, "phi") || !strcmp(name, "epsilon"))
            return hdr_fail(err, HDR_USAGE, "--%s has a meaning with --local only", name);
    }
    if (p->shot.given && p->delta.value > 0)
        return hdr_fail(err, HDR_USAGE,
                        "--delta averages this picture's own pixels: it cannot be combined with --facts");
    if (p->local && p->luminance.per_channel)
        return hdr_fail(err, HDR_USAGE, "--local works on luminance: it cannot be combined with --per-channel");
    return HDR_OK;
}

static void needs(const void *params, hdr_request *request) {
    const reinhard_params *p = params;
    request->facts |= HDR_FACT_LUMINANCE;
    request->plane = p->local;
    if (p->delta.value > 0) {
        request->facts |= HDR_FACT_SHIFTED;
        request->shift = p->delta.value > 1e-100 ? p->delta.value : 1e-100; /* so that its logarithm is a normal one */
    }
    if (p->key.word == KEY_ESTIMATE) {
        request->percentiles = 2;
        request->percentile[0].of = request->percentile[1].of = HDR_OF_LIT;
        request->percentile[0].percent = (hdr_decimal){1, 0};
        request->percentile[1].percent = (hdr_decimal){99, 0};
    }
}

/* ---- The curves; L = v[0] Y, v[0] = key / Yavg; v[2] = 2^phi Yavg and v[3] = Yavg are for the surround ---- */

/* Ld = L (1 + L / white^2) / (1 + L), equation 4; equation 3 where white is infinite. L / white = v[1] Y. */
HDR_INLINE double reinhard_global_of(const hdr_constants *k, double y) {
    double lit = y > 0 ? y : 0;
    double l = k->v[0] * lit;
    double of_white = k->v[1] * lit;
    double ld = (l + of_white * of_white) / (1 + l);
    return y > 0 ? ld : 0;
}
HDR_CURVE(reinhard_global)

/* Ld = L / (1 + V), equation 9; V = v[0] S. */
HDR_INLINE double reinhard_local_of(const hdr_constants *k, double y, double surround) {
    double lit = y > 0 ? y : 0;
    return k->v[0] * lit / (1 + k->v[0] * surround);
}
/* Of what is alike everywhere, every Gaussian's average is the luminance itself. */
static double reinhard_alone(double y) {
    return y;
}
HDR_LOCAL_CURVE(reinhard_local, reinhard_alone)

/* A picture with nothing lit becomes 0. */
HDR_INLINE double reinhard_dark_of(const hdr_constants *k, double y) {
    (void)k;
    (void)y;
    return 0;
}
HDR_CURVE(reinhard_dark)

/* ---- The plan ---- */

/* Key and white as Reinhard has them estimated: Parameter estimation for photographic tone reproduction, Journal of
 * Graphics Tools 7(1), 2003, equations 2 and 4. Ymin and Ymax are the 1st and 99th percentile. False: they are equal,
 * and there is no estimate of white. */
static bool estimate(const hdr_facts *facts, double average, double *key, double *white) {
    double low = hdr_log2(facts->percentile[0]), high = hdr_log2(facts->percentile[1]);
    *key = DEFAULT_KEY;
    if (!(high > low)) return false;
    /* where the average lies outside of the two, as a few outliers can make it, the paper's limits hold: 0.045 to 0.72
     */
    double exponent = (2 * hdr_log2(average) - low - high) / (high - low);
    double held = exponent < -1 ? -1 : exponent > 1 ? 1 : exponent;
    *key = DEFAULT_KEY * hdr_exp2(2 * held);
    *white = 1.5 * hdr_exp2(high - low - 5);
    return true;
}

static hdr_verdict plan(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    (void)err;
    const reinhard_params *p = params;
    const hdr_facts *facts = &scene->facts;
    double average = p->delta.value > 0 ? facts->shifted_average : facts->log_average;
    double key = p->key.value, white = p->white.value;
    bool is_white = p->white.word < 0; /* a number; otherwise the largest L */
    hdr_luminance_form(&p->luminance, step);
    step->of_light = step->for_display = true;
    if (facts->lit == 0) {
        step->curve = &reinhard_dark;
        snprintf(step->note, sizeof step->note, "nothing is lit: 0 everywhere");
        return HDR_RUN;
    }
    if (p->key.word == KEY_ESTIMATE) {
        double estimated = 0;
        bool ranged = estimate(facts, average, &key, &estimated);
        if (ranged && p->white.word == WHITE_BY_KEY) {
            white = estimated;
            is_white = true;
        }
    }
    double *v = step->constants.v;
    v[0] = key / average;
    if (p->local) {
        step->form = HDR_FORM_LOCAL;
        step->local = &reinhard_local;
        v[2] = hdr_exp2(p->phi.value) * average;
        v[3] = average;
        snprintf(step->note, sizeof step->note, "key %.9g, Yavg %.9g, phi %.9g, epsilon %.9g", key, average,
                 p->phi.value, p->epsilon.value);
        return HDR_RUN;
    }
    step->curve = &reinhard_global;
    if (!is_white) white = v[0] * facts->max_luminance;
    bool infinite = p->white.word == WHITE_INFINITE;
    v[1] = infinite ? 0 : is_white ? v[0] / white : 1 / facts->max_luminance;
    if (infinite)
        snprintf(step->note, sizeof step->note, "key %.9g, Yavg %.9g, white inf", key, average);
    else
        snprintf(step->note, sizeof step->note, "key %.9g, Yavg %.9g, white %.9g", key, average, white);
    return HDR_RUN;
}

/* ---- The surround ---- */

/* How many of the Gaussians' pixels were computed, and which scales were chosen. */
static void explain(const hdr_scales_report *report, const hdr_plane *plane, char *note, size_t size) {
    double pixels = (double)plane->width * (double)plane->height, blurred = 0;
    for (int i = 0; i <= HDR_SCALES; i++)
        blurred += (double)report->blurred[i] / pixels / (HDR_SCALES + 1);
    size_t used = (size_t)snprintf(note, size, "%.1f %% of 9 Gaussians computed; scales chosen:", 100 * blurred);
    for (int i = 0; i < HDR_SCALES && used < size; i++)
        used += (size_t)snprintf(note + used, size - used, " %.3g", 100 * (double)report->chosen[i] / pixels);
    if (used < size)
        snprintf(note + used, size - used, " %%; %llu tests in double", (unsigned long long)report->settled);
}

/* The scales s_i = 1.6^i, whose centres are Gaussians of standard deviation s_i / 4: equation 5 with alpha_1 = 1 / (2
 * sqrt 2), so that the surround of each is the centre of the next. Activity, equation 7: (V_i - V_(i+1)) / (2^phi key /
 * s_i^2
 * + V_i), here in units of Y, where 2^phi key becomes v[2] = 2^phi Yavg. */
static hdr_status surround(hdr_step *step, hdr_surroundings *with, hdr_error *err) {
    const reinhard_params *p = with->params;
    hdr_scales scales = {.epsilon = p->epsilon.value,
                         .unit = fmin(1 / step->constants.v[0], step->constants.v[3]),
                         .no_skip = with->no_skip};
    double s = 1;
    for (int i = 0; i <= HDR_SCALES; i++, s *= 1.6) {
        scales.sigma[i] = s / 4;
        if (i < HDR_SCALES) scales.offset[i] = step->constants.v[2] / (s * s);
    }
    const hdr_plane *luminance = with->luminance;
    with->surround = hdr_plane_new(luminance->width, luminance->height, luminance->wide != NULL, err);
    if (!with->surround) return HDR_INTERNAL;
    hdr_scales_report report;
    hdr_status status =
        hdr_scales_surround(&scales, with->luminance, with->surround, NULL, with->pool, &report, &with->too_wide, err);
    if (status == HDR_OK && !with->too_wide) explain(&report, with->luminance, with->note, sizeof with->note);
    return status;
}

#define DETAILS                                                                                                        \
    "The photographic operator of Reinhard, Stark, Shirley and Ferwerda (SIGGRAPH 2002). Luminance Y is scaled so "    \
    "that "                                                                                                            \
    "the scene's log-average becomes the key, L = KEY Y / Yavg with Yavg = exp(mean of ln Y) over the lit pixels, "    \
    "those "                                                                                                           \
    "with Y > 0 (equations 1 and 2), and then compressed: small L hardly, large ones to below a bound. The result "    \
    "does "                                                                                                            \
    "not depend on the exposure of the render.\n\n"                                                                    \
    "Key. 0.18 renders the average as a middle grey; 0.36 and 0.72 suit bright scenes (snow, a white room), 0.09 and " \
    "0.045 dark ones (a night street). --key estimate takes key and white from the scene, as Reinhard's Parameter "    \
    "estimation for photographic tone reproduction (2003) has it: with Ymin and Ymax the 1st and 99th percentile of "  \
    "lit "                                                                                                             \
    "pixels by nearest rank, KEY = 0.18 x 4^((2 log2 Yavg - log2 Ymin - log2 Ymax) / (log2 Ymax - log2 Ymin)) and "    \
    "WHITE "                                                                                                           \
    "= 1.5 x 2^(log2 Ymax - log2 Ymin - 5); the exponent is held to -1 ... 1, which are the paper's limits of the "    \
    "key, 0.045 to 0.72: outliers can bring Yavg outside of the two percentiles. Where Ymin = Ymax, 0.18 and the "     \
    "largest L. A --white that is given "                                                                              \
    "holds.\n\n"                                                                                                       \
    "Global. Ld = L (1 + L/WHITE^2) / (1 + L) (equation 4). --white auto is the largest L: the brightest pixel just "  \
    "becomes 1. A smaller number burns out what is above it; inf gives Ld = L / (1 + L) (equation 3), which reaches "  \
    "1 "                                                                                                               \
    "nowhere. A single firefly sets the auto white and so dims the brightest parts a little; a number or inf does "    \
    "not "                                                                                                             \
    "depend on it.\n\n"                                                                                                \
    "Local (--local), the paper's automatic dodging and burning: Ld = L / (1 + V) (equation 9), where V is what L is " \
    "on "                                                                                                              \
    "average around the pixel, as far as the surround is even. V_i is L convolved with a Gaussian of standard "        \
    "deviation "                                                                                                       \
    "s_i/4 pixels, s_i = 1.6^i, i = 0 ... 8 (equation 5), integrated over each pixel, mirrored at the picture's "      \
    "border. "                                                                                                         \
    "The activity is A_i = (V_i - V_{i+1}) / (2^PHI KEY / s_i^2 + V_i) (equation 7), and V is V_m with m the first i " \
    "of "                                                                                                              \
    "0 ... 7 with |A_i| > EPSILON, or 7. There is no white point: what is brighter than its surround may exceed 1, "   \
    "and is "                                                                                                          \
    "clipped by what writes codes; --white has no effect. A larger PHI makes the small scales less sensitive, a "      \
    "larger "                                                                                                          \
    "EPSILON lets surrounds grow, which gives more local contrast, and halos.\n\n"                                     \
    "The printed text of the paper asks for the first scale whose |A_i| is below EPSILON (equation 8), which stops "   \
    "at once "                                                                                                         \
    "nearly everywhere; the authors' own code does what the text says is wanted, and takes the first that exceeds "    \
    "it, that "                                                                                                        \
    "very scale and not the one before. So does hdr. The authors' code has 8 scales and so tests 7; the text has 8 "   \
    "centres, of which the last needs a surround: 9 Gaussians, as here. In the text 1/N stands outside the "           \
    "exponential of "                                                                                                  \
    "the log-average, by mistake, and a small delta within the logarithm keeps it finite; hdr leaves unlit pixels "    \
    "out "                                                                                                             \
    "instead, since a render's black background would otherwise pull the average towards that delta. --delta D "       \
    "brings it "                                                                                                       \
    "back: Yavg = exp(mean of ln(D + max(Y, 0))) over all pixels.\n\n"                                                 \
    "Colours keep their chromaticity: C' = (C/Y)^S Ld, with S = --saturation; a pixel that is not lit becomes 0. A "   \
    "saturated colour has components far above its luminance (a pure blue of Y = 0.5 has B = 6.9), so that it may "    \
    "exceed 1 and is clipped although Ld is below 1: it comes out darker than it ought to, and of another hue where "  \
    "only one of its components is clipped. --saturation 0.6 to "                                                      \
    "0.8 "                                                                                                             \
    "keeps such colours within the range; --per-channel (not with --local) compresses each channel as if it were Y: "  \
    "nothing "                                                                                                         \
    "is clipped that Ld does not clip, and bright colours fade to white.\n\n"                                          \
    "Examples. A product on a white ground: --key 0.36 --white 4, so that the ground burns out. A night street with "  \
    "neon "                                                                                                            \
    "signs: --key 0.09 --saturation 0.7, dark, with colours that are not clipped. A room with a window, dark corners " \
    "and "                                                                                                             \
    "a bright view at once: --local.\n\n"                                                                              \
    "Accuracy. The global operator's codes are those of --reference. The local one convolves in float, with a "        \
    "relative error "                                                                                                  \
    "of V below 6e-6 (1e-7 in practice), and chooses the scale that --reference chooses: an activity that close to "   \
    "EPSILON "                                                                                                         \
    "is computed again in double. Codes of 8 bits differ from the reference's by at most 1, in about 5 pixels of a "   \
    "million. Where no scale could exceed EPSILON, by a bound from the least and largest Y around, scales are left "   \
    "out; "                                                                                                            \
    "--explain tells how much."

/* V is right to 6e-6, Y in its plane to 2^-24. */
static double bound(const void *params) {
    (void)params;
    return 1e-5;
}

static const char *const examples[] = {"hdr reinhard then png -o OUT.png IN.exr",
                                       "hdr reinhard --key 0.36 --white 4 then png -o OUT.png IN.exr",
                                       "hdr reinhard --key 0.09 --saturation 0.7 then png -o OUT.png IN.exr",
                                       "hdr reinhard --key estimate then png -o OUT.png IN.exr",
                                       "hdr reinhard --local then png -o OUT.png IN.exr",
                                       NULL};

const hdr_verb hdr_verb_reinhard = {
    .about = {.name = "reinhard",
              .summary = "tone map by the photographic operator, global or local",
              .details = DETAILS HDR_FACTS_DETAILS,
              .examples = examples,
              .options = options,
              .kind = HDR_FILTER},
    .params_size = sizeof(reinhard_params),
    .check = check,
    .needs = needs,
    .plan = plan,
    .surround = surround,
    .bound = bound,
};

/* For the oracle: a chain's words become steps with all facts filled in; steps and a pixel give the expected codes. */
#ifndef HDR_TESTS_ORACLE_CHAIN_H
#define HDR_TESTS_ORACLE_CHAIN_H

#include "oracle_picture.h"
#include "oracle_real.h"
#include "oracle_reinhard.h"

#include <float.h>

typedef enum oracle_verb {
    ORACLE_DIVMAX,
    ORACLE_CLAMP,
    ORACLE_EXPOSE,
    ORACLE_LOG,
    ORACLE_EXP,
    ORACLE_REINHARD,
    ORACLE_GAMMA,
    ORACLE_SRGB,
    ORACLE_REC709,
    ORACLE_PQ,
    ORACLE_HLG,
    ORACLE_QUANTISE,
    ORACLE_CONVERT /* to Rec.709's primaries: no verb, but a step that encoding verbs bring along */
} oracle_verb;

typedef enum oracle_mode { ORACLE_SHIFTED, ORACLE_RANGE, ORACLE_LITERAL } oracle_mode;

/* What reinhard takes for white: the largest L, none, what was typed, or what --key estimate says. */
typedef enum oracle_white {
    ORACLE_WHITE_LARGEST,
    ORACLE_WHITE_NONE,
    ORACLE_WHITE_TYPED,
    ORACLE_WHITE_ESTIMATED
} oracle_white;

/* What reinhard --local knows of each pixel. */
typedef struct oracle_local {
    double *surround; /* V_m, in units of Y */
    double *margin;
    unsigned char *chosen;
    double scale;   /* Y times this is L */
    double largest; /* the largest L */
} oracle_local;

typedef struct oracle_step {
    oracle_verb verb;
    oracle_mode mode;
    bool automatic, decode, per_channel, of_luminance, is_local;
    oracle_number low, high, ev, k, saturation, exponent, nits;
    oracle_number key, white, delta, phi, epsilon; /* as typed: words too */
    oracle_number percentile;
    int bits;
    bool no_excuse; /* quantise: even a value exactly on a boundary has one right code */
    /* facts about what comes in */
    oracle_weights weights;
    bool any_lit;
    long double log_average, max_luminance, maximum, smallest_positive, low_luminance, high_luminance;
    oracle_matrix matrix;
    oracle_white white_is;
    long double estimated_key, estimated_white; /* 0: not estimated */
    oracle_local *local;                        /* oracle_release frees it */
} oracle_step;

#define REAL long double
#define OF(name) wide_##name
#include "oracle_curve.h"
#undef REAL
#undef OF
#define REAL exact
#define OF(name) exact_##name
#include "oracle_curve.h"
#undef REAL
#undef OF

enum { ORACLE_STEPS = 16, ORACLE_WORD = 32 };

typedef enum oracle_format { ORACLE_PNG, ORACLE_EXR, ORACLE_PFM, ORACLE_NO_FORMAT } oracle_format;

typedef struct oracle_chain {
    const oracle_picture *picture;
    oracle_step steps[ORACLE_STEPS];
    int count;
    char words[8 * ORACLE_STEPS][ORACLE_WORD]; /* steps' numbers point here */
    int word_count;
    oracle_format format;
    bool encoded;
    oracle_verb encoding;     /* where encoded: by which verb */
    oracle_number encoded_by; /* gamma's exponent */
    oracle_weights weights;   /* of the primaries that the pixels are in, after the steps so far */
    bool keep_primaries, no_adaptation, data_window;
    bool converted;
    int bits;     /* of an explicit quantise; 0: none */
    int png_bits; /* of the file's samples */
    bool half;
} oracle_chain;

/* ---- Facts ---- */

typedef struct oracle_facts {
    uint64_t lit, negative, unlit_colour;
    long double min[4], max[4]; /* per channel, [3] alpha */
    long double max_component, smallest_positive;
    long double min_luminance, max_luminance, min_lit, log_average;
} oracle_facts;

/* A pixel after the steps. */
static void oracle_pixel(const oracle_chain *chain, int steps, size_t pixel, long double c[3]) {
    long double nearest = 1;
    wide_read(chain->picture, pixel, c);
    wide_walk(chain->steps, steps, chain->picture->planes, pixel, c, &nearest);
}

/* Adds without losing what rounds off (Neumaier). */
static void oracle_accumulate(long double *sum, long double *rest, long double value) {
    long double total = *sum + value;
    *rest += fabsl(*sum) >= fabsl(value) ? *sum - total + value : value - total + *sum;
    *sum = total;
}

static void oracle_component_facts(oracle_facts *facts, int channel, bool first, long double value) {
    if (first || value < facts->min[channel]) facts->min[channel] = value;
    if (first || value > facts->max[channel]) facts->max[channel] = value;
    if (channel == 3) return;
    if ((first && channel == 0) || value > facts->max_component) facts->max_component = value;
    if (value > 0 && (facts->smallest_positive == 0 || value < facts->smallest_positive))
        facts->smallest_positive = value;
    if (value < 0) facts->negative++;
}

/* Facts of what comes out of the steps so far, over the data window. */
static oracle_facts oracle_compute_facts(const oracle_chain *chain) {
    const oracle_picture *picture = chain->picture;
    oracle_facts facts = {0};
    long double sum = 0, rest = 0;
    for (size_t i = 0; i < picture->pixels; i++) {
        long double c[3];
        oracle_pixel(chain, chain->count, i, c);
        bool positive = false;
        for (int p = 0; p < picture->planes; p++) {
            oracle_component_facts(&facts, p, i == 0, c[p]);
            positive = positive || c[p] > 0;
        }
        if (picture->plane[3]) oracle_component_facts(&facts, 3, i == 0, picture->plane[3][i]);
        long double y = wide_luminance(&chain->weights, picture->planes, c);
        if (i == 0 || y < facts.min_luminance) facts.min_luminance = y;
        if (i == 0 || y > facts.max_luminance) facts.max_luminance = y;
        if (y > 0) {
            if (facts.lit++ == 0 || y < facts.min_lit) facts.min_lit = y;
            oracle_accumulate(&sum, &rest, logl(y));
        } else if (positive) {
            facts.unlit_colour++;
        }
    }
    if (facts.lit) facts.log_average = expl((sum + rest) / (long double)facts.lit);
    return facts;
}

typedef enum oracle_population { ORACLE_COMPONENTS, ORACLE_LUMINANCE, ORACLE_LIT } oracle_population;

typedef struct oracle_values {
    long double *value; /* in order */
    size_t count;
} oracle_values;

static int oracle_order(const void *a, const void *b) {
    const long double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* What a percentile is taken of: components, or Y rounded to float32 (a lit pixel's to at least 2^-149). */
static oracle_values oracle_compute_values(const oracle_chain *chain, oracle_population population) {
    const oracle_picture *picture = chain->picture;
    oracle_values values = {oracle_alloc(picture->pixels * 3, sizeof(long double)), 0};
    for (size_t i = 0; i < picture->pixels; i++) {
        long double c[3];
        oracle_pixel(chain, chain->count, i, c);
        for (int p = 0; population == ORACLE_COMPONENTS && p < picture->planes; p++)
            values.value[values.count++] = c[p];
        if (population == ORACLE_COMPONENTS) continue;
        long double y = wide_luminance(&chain->weights, picture->planes, c);
        if (y <= 0 && population == ORACLE_LIT) continue;
        float rounded = (float)y;
        values.value[values.count++] = y > 0 && rounded == 0 ? 0x1p-149L : rounded;
    }
    qsort(values.value, values.count, sizeof *values.value, oracle_order);
    return values;
}

/* What many chains ask for: facts and values of the picture as it is read. Computed once for each picture. */
static struct {
    unsigned long serial;
    bool facts_taken;
    oracle_facts facts;
    oracle_values values[3]; /* by population; value is NULL where not taken yet */
} oracle_known;

/* False: something stands in front, so that what is known does not help. */
static bool oracle_is_known(const oracle_chain *chain) {
    if (chain->count) return false;
    if (oracle_known.serial == chain->picture->serial) return true;
    for (int i = 0; i < 3; i++)
        free(oracle_known.values[i].value);
    memset(&oracle_known, 0, sizeof oracle_known);
    oracle_known.serial = chain->picture->serial;
    return true;
}

static oracle_facts oracle_take_facts(const oracle_chain *chain) {
    if (!oracle_is_known(chain)) return oracle_compute_facts(chain);
    if (!oracle_known.facts_taken) oracle_known.facts = oracle_compute_facts(chain);
    oracle_known.facts_taken = true;
    return oracle_known.facts;
}

static oracle_values oracle_take_values(const oracle_chain *chain, oracle_population population) {
    if (!oracle_is_known(chain)) return oracle_compute_values(chain, population);
    if (!oracle_known.values[population].value)
        oracle_known.values[population] = oracle_compute_values(chain, population);
    return oracle_known.values[population];
}

static void oracle_values_free(oracle_values *values) {
    for (int i = 0; i < 3; i++)
        if (values->value == oracle_known.values[i].value) return;
    free(values->value);
}

/* Nearest rank: max(1, ceil(P N / 100)), P = the decimal as typed (from_top: 100 - P), in whole numbers. */
static long double oracle_percentile(const oracle_values *values, const char *decimal, bool from_top) {
    unsigned __int128 digits = 0, scale = 1;
    bool fraction = false;
    for (const char *c = decimal; *c; c++) {
        if (*c == '.') {
            fraction = true;
            continue;
        }
        digits = digits * 10 + (unsigned)(*c - '0');
        if (fraction) scale *= 10;
    }
    if (from_top) digits = 100 * scale - digits;
    unsigned __int128 rank = (digits * values->count + 100 * scale - 1) / (100 * scale);
    if (!values->count) return 0;
    return values->value[rank ? (size_t)rank - 1 : 0];
}

/* ---- Words to steps ---- */

static oracle_number oracle_parse_number(const char *word) {
    return (oracle_number){word, strtold(word, NULL)};
}

static oracle_step oracle_default_step(oracle_verb verb) {
    return (oracle_step){.verb = verb,
                         .low = NUMBER(0.),
                         .high = NUMBER(1.),
                         .ev = NUMBER(0.),
                         .saturation = NUMBER(1.),
                         .exponent = NUMBER(2.2),
                         .nits = NUMBER(100.),
                         .key = NUMBER(0.18),
                         .white = {"by-key", 0},
                         .delta = NUMBER(0.),
                         .phi = NUMBER(8.),
                         .epsilon = NUMBER(0.05),
                         .percentile = verb == ORACLE_DIVMAX ? NUMBER(100.) : NUMBER(0.1),
                         .bits = 8};
}

static void oracle_parse_mode(oracle_step *step, const char *word) {
    step->mode = !strcmp(word, "range") ? ORACLE_RANGE : !strcmp(word, "literal") ? ORACLE_LITERAL : ORACLE_SHIFTED;
}

/* One option; returns the number of words that it takes, 0 where it is unknown. */
static int oracle_parse_option(oracle_chain *chain, oracle_step *step, const char *word, const char *value) {
    static const struct {
        const char *name;
        size_t offset;
    } numbers[] = {
        {"--min", offsetof(oracle_step, low)},
        {"--max", offsetof(oracle_step, high)},
        {"--ev", offsetof(oracle_step, ev)},
        {"--k", offsetof(oracle_step, k)},
        {"--exponent", offsetof(oracle_step, exponent)},
        {"--saturation", offsetof(oracle_step, saturation)},
        {"-g", offsetof(oracle_step, exponent)},
        {"--nits", offsetof(oracle_step, nits)},
        {"--key", offsetof(oracle_step, key)},
        {"--white", offsetof(oracle_step, white)},
        {"--delta", offsetof(oracle_step, delta)},
        {"--phi", offsetof(oracle_step, phi)},
        {"--epsilon", offsetof(oracle_step, epsilon)},
        {"--percentile", offsetof(oracle_step, percentile)},
    };
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        if (strcmp(word, numbers[i].name) != 0) continue;
        *(oracle_number *)((char *)step + numbers[i].offset) = oracle_parse_number(value);
        return 2;
    }
    bool *const flag = !strcmp(word, "--auto")          ? &step->automatic
                       : !strcmp(word, "--decode")      ? &step->decode
                       : !strcmp(word, "--per-channel") ? &step->per_channel
                       : !strcmp(word, "--local")       ? &step->is_local
                                                        : NULL;
    if (flag) *flag = true;
    if (flag || !strcmp(word, "--reference")) return 1;
    if (!strcmp(word, "--of"))
        step->of_luminance = !strcmp(value, "luminance");
    else if (!strcmp(word, "--mode"))
        oracle_parse_mode(step, value);
    else if (!strcmp(word, "--bits"))
        step->bits = atoi(value);
    else if (!strcmp(word, "--type"))
        chain->half = !strcmp(value, "half");
    else if (!strcmp(word, "--primaries"))
        chain->keep_primaries = !strcmp(value, "keep");
    else if (!strcmp(word, "--adapt"))
        chain->no_adaptation = !strcmp(value, "none");
    else if (!strcmp(word, "--window"))
        chain->data_window = !strcmp(value, "data");
    else
        return 0;
    return 2;
}

/* True where the arithmetic is exact in binary, up to the first rounding to codes, and all that follows rounds these
 * codes again: then not even a boundary met exactly is an excuse. */
static bool oracle_no_excuse(const oracle_chain *chain, const oracle_step *step) {
    if (!(chain->count ? chain->steps[chain->count - 1].no_excuse : chain->picture->opaque)) return false;
    if (step->verb == ORACLE_QUANTISE) return true;
    bool whole = step->verb == ORACLE_EXPOSE && !step->automatic && step->ev.value == rintl(step->ev.value);
    bool ends = step->verb == ORACLE_CLAMP && step->low.value == rintl(step->low.value) &&
                step->high.value == rintl(step->high.value);
    return (whole || ends) && !chain->bits;
}

static void oracle_append(oracle_chain *chain, const oracle_step *step) {
    if (chain->count == ORACLE_STEPS) abort();
    chain->steps[chain->count] = *step;
    chain->steps[chain->count].no_excuse = oracle_no_excuse(chain, step);
    chain->steps[chain->count++].weights = chain->weights;
}

/* The first encoding verb, or quantise, converts other primaries before it encodes. */
static void oracle_convert_primaries(oracle_chain *chain) {
    const oracle_picture *picture = chain->picture;
    if (!picture->foreign || picture->planes == 1 || chain->keep_primaries || chain->converted) return;
    oracle_step step = oracle_default_step(ORACLE_CONVERT);
    oracle_conversion(picture, !chain->no_adaptation, step.matrix);
    oracle_append(chain, &step);
    chain->converted = true;
    chain->weights = (oracle_weights){.rec709 = true};
}

/* --delta D: exp(mean of ln(D + max(Y,0)) over all pixels). */
static long double oracle_delta_average(const oracle_chain *chain, long double delta) {
    const oracle_picture *picture = chain->picture;
    long double sum = 0, rest = 0;
    for (size_t i = 0; i < picture->pixels; i++) {
        long double c[3];
        oracle_pixel(chain, chain->count, i, c);
        long double y = wide_luminance(&chain->weights, picture->planes, c);
        oracle_accumulate(&sum, &rest, logl(delta + fmaxl(y, 0)));
    }
    return expl((sum + rest) / (long double)picture->pixels);
}

/* --key estimate: key = 0.18 * 4^((2 log2 Yavg - log2 Ymin - log2 Ymax) / (log2 Ymax - log2 Ymin)),
 * white = 1.5 * 2^(log2 Ymax - log2 Ymin - 5); Ymin = Ymax: key 0.18, white auto. */
static void oracle_estimate(const oracle_chain *chain, oracle_step *step) {
    oracle_values values = oracle_take_values(chain, ORACLE_LIT);
    long double darkest = oracle_percentile(&values, "1", false), brightest = oracle_percentile(&values, "99", false);
    oracle_values_free(&values);
    step->key = NUMBER(0.18);
    if (darkest == brightest) return;
    long double low = log2l(darkest), high = log2l(brightest);
    long double exponent = (2 * log2l(step->log_average) - low - high) / (high - low);
    step->estimated_key = 0.18L * powl(4, fmaxl(-1, fminl(1, exponent))); /* the paper's key is 0.045 to 0.72 */
    step->estimated_white = 1.5L * exp2l(high - low - 5);
}

/* Luminance, 0 where nothing is lit, and what surrounds it. Pictures too big for the direct sum go by axes. */
static oracle_local *oracle_take_local(const oracle_chain *chain, const oracle_step *step) {
    enum { DIRECTLY = 5000 };
    const oracle_picture *picture = chain->picture;
    double *plane = oracle_alloc(picture->pixels, sizeof *plane);
    oracle_local *local = oracle_alloc(1, sizeof *local);
    local->surround = oracle_alloc(picture->pixels, sizeof *local->surround);
    local->margin = oracle_alloc(picture->pixels, sizeof *local->margin);
    local->chosen = oracle_alloc(picture->pixels, sizeof *local->chosen);
    for (size_t i = 0; i < picture->pixels; i++) {
        long double c[3];
        oracle_pixel(chain, chain->count, i, c);
        plane[i] = (double)fmaxl(wide_luminance(&chain->weights, picture->planes, c), 0);
    }
    long double key = wide_key(step);
    local->scale = (double)(key / step->log_average);
    local->largest = (double)(key / step->log_average * step->max_luminance);
    bool direct = picture->pixels <= DIRECTLY || picture->width == 1 || picture->height == 1;
    oracle_surround_by(direct ? oracle_blur_directly : oracle_blur_by_axes, plane, picture->width, picture->height,
                       local->scale, (double)key, (double)step->phi.value, (double)step->epsilon.value, local->surround,
                       local->chosen, local->margin);
    free(plane);
    return local;
}

/* The rest of reinhard's facts. What is typed for white or delta holds beside --key estimate. */
static void oracle_fill_reinhard(const oracle_chain *chain, oracle_step *step) {
    const char *white = step->white.text;
    if (!step->any_lit) return;
    if (step->delta.value > 0) step->log_average = oracle_delta_average(chain, step->delta.value);
    if (!strcmp(step->key.text, "estimate")) oracle_estimate(chain, step);
    bool by_key = !strcmp(white, "by-key");
    step->white_is = by_key && step->estimated_white > 0 ? ORACLE_WHITE_ESTIMATED
                     : by_key || !strcmp(white, "auto")  ? ORACLE_WHITE_LARGEST
                     : !strcmp(white, "inf")             ? ORACLE_WHITE_NONE
                                                         : ORACLE_WHITE_TYPED;
    if (step->is_local) step->local = oracle_take_local(chain, step);
}

static void oracle_fill_facts(oracle_chain *chain, oracle_step *step) {
    bool range = step->verb == ORACLE_LOG && step->mode == ORACLE_RANGE;
    bool percentile = step->verb == ORACLE_DIVMAX && step->percentile.value < 100;
    bool wanted = step->verb == ORACLE_DIVMAX || step->verb == ORACLE_LOG || step->verb == ORACLE_EXP ||
                  step->verb == ORACLE_REINHARD || (step->verb == ORACLE_EXPOSE && step->automatic);
    if (!wanted) return;
    oracle_facts facts = oracle_take_facts(chain);
    step->any_lit = facts.lit > 0;
    step->log_average = facts.log_average;
    step->max_luminance = facts.max_luminance;
    step->smallest_positive = facts.smallest_positive;
    step->maximum = step->of_luminance ? facts.max_luminance : facts.max_component;
    if (step->verb == ORACLE_REINHARD) oracle_fill_reinhard(chain, step);
    if (!range && !percentile) return;
    oracle_values values = oracle_take_values(chain, range                ? ORACLE_LIT
                                                     : step->of_luminance ? ORACLE_LUMINANCE
                                                                          : ORACLE_COMPONENTS);
    if (percentile) step->maximum = oracle_percentile(&values, step->percentile.text, false);
    step->low_luminance = range ? oracle_percentile(&values, step->percentile.text, false) : 0;
    step->high_luminance = range ? oracle_percentile(&values, step->percentile.text, true) : 0;
    oracle_values_free(&values);
}

static void oracle_add_step(oracle_chain *chain, oracle_step *step) {
    bool curve = step->verb >= ORACLE_GAMMA && step->verb <= ORACLE_HLG, encodes = curve && !step->decode;
    if (encodes || step->verb == ORACLE_QUANTISE) oracle_convert_primaries(chain);
    oracle_fill_facts(chain, step);
    oracle_append(chain, step);
    if (curve) chain->encoded = encodes;
    if (encodes) chain->encoding = step->verb;
    if (encodes) chain->encoded_by = step->exponent;
    if (step->verb == ORACLE_QUANTISE) chain->bits = step->bits;
}

/* What png adds: srgb where the chain has neither encoded nor quantised; in any case codes of the file's depth. */
static void oracle_add_png(oracle_chain *chain, int bits) {
    if (!chain->encoded && !chain->bits) {
        oracle_step srgb = oracle_default_step(ORACLE_SRGB);
        oracle_add_step(chain, &srgb);
    }
    oracle_convert_primaries(chain);
    chain->png_bits = !chain->bits ? bits : chain->bits <= 8 ? 8 : 16;
    oracle_step codes = oracle_default_step(ORACLE_QUANTISE);
    codes.bits = chain->png_bits;
    oracle_append(chain, &codes);
}

static bool oracle_add_clause(oracle_chain *chain, const char *verb, oracle_step *step) {
    static const char *const verbs[] = {"divmax", "clamp", "expose", "log", "exp", "reinhard",
                                        "gamma",  "srgb",  "rec709", "pq",  "hlg", "quantise"};
    static const char *const formats[] = {"png", "exr", "pfm"};
    for (size_t i = 0; i < sizeof verbs / sizeof verbs[0]; i++) {
        if (strcmp(verb, verbs[i]) != 0) continue;
        step->verb = (oracle_verb)i;
        oracle_add_step(chain, step);
        return true;
    }
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; i++) {
        if (strcmp(verb, formats[i]) != 0) continue;
        chain->format = (oracle_format)i;
        if (chain->format == ORACLE_PNG) oracle_add_png(chain, step->bits);
        return true;
    }
    return false;
}

/* Makes the steps of a chain given as one line of words. False: words that the oracle does not know. */
static inline bool oracle_prepare(oracle_chain *chain, const oracle_picture *picture, const char *text) {
    *chain = (oracle_chain){.picture = picture, .format = ORACLE_NO_FORMAT, .weights = oracle_weights_of(picture)};
    for (int length; sscanf(text, "%31s%n", chain->words[chain->word_count], &length) == 1; text += length)
        if (++chain->word_count == 8 * ORACLE_STEPS) return false;
    for (int w = 0; w < chain->word_count; w++) {
        const char *verb = chain->words[w++];
        oracle_step step = oracle_default_step(!strcmp(verb, "divmax") ? ORACLE_DIVMAX : ORACLE_LOG);
        while (w < chain->word_count && strcmp(chain->words[w], "then") != 0) {
            int taken = oracle_parse_option(chain, &step, chain->words[w], chain->words[w + 1]);
            if (!taken) return false;
            w += taken;
        }
        if (!oracle_add_clause(chain, verb, &step)) return false;
    }
    return true;
}

/* Frees what the steps hold. */
static inline void oracle_release(oracle_chain *chain) {
    for (int i = 0; i < chain->count; i++) {
        oracle_local *local = chain->steps[i].local;
        if (!local) continue;
        free(local->surround);
        free(local->margin);
        free(local->chosen);
        free(local);
    }
    chain->count = 0;
}

/* ---- Expected codes ---- */

static const long double oracle_doubt = 1e-6L;  /* nearer to a boundary than this, in codes: exact numbers decide */
static const long double oracle_excuse = 1e-9L; /* nearer than this: SPEC excuses either code */

typedef struct oracle_codes {
    long code[3];
    bool excused[3]; /* code differs by 1 without fault */
    bool void_pixel; /* a quantise inside the chain is excused: nothing can be said */
} oracle_codes;

static oracle_codes oracle_exact_codes(const oracle_chain *chain, size_t pixel) {
    oracle_codes codes = {0};
    int planes = chain->picture->planes, last = chain->count - 1;
    long double nearest = 1;
    exact c[3];
    exact_empty();
    exact_read(chain->picture, pixel, c);
    exact_walk(chain->steps, last, planes, pixel, c, &nearest);
    codes.void_pixel = nearest < oracle_excuse;
    for (int p = 0; p < planes; p++) {
        long double distance;
        codes.code[p] = exact_code(c[p], chain->png_bits, &distance);
        codes.excused[p] = distance < oracle_excuse && !(distance == 0 && chain->steps[last].no_excuse);
    }
    return codes;
}

/* The codes of the PNG's samples of a pixel. */
static inline oracle_codes oracle_expect(const oracle_chain *chain, size_t pixel) {
    oracle_codes codes = {0};
    int planes = chain->picture->planes, last = chain->count - 1;
    long double nearest = 1, c[3];
    wide_read(chain->picture, pixel, c);
    wide_walk(chain->steps, last, planes, pixel, c, &nearest);
    for (int p = 0; p < planes; p++) {
        long double distance;
        codes.code[p] = wide_code(c[p], chain->png_bits, &distance);
        if (distance < nearest) nearest = distance;
    }
    return nearest < oracle_doubt ? oracle_exact_codes(chain, pixel) : codes;
}

#endif

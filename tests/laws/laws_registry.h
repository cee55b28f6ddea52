/* Laws of the registry itself: option tables without collisions or gaps, and curves that keep what verb.h promises of
 * them. */
#ifndef HDR_TESTS_LAWS_REGISTRY_H
#define HDR_TESTS_LAWS_REGISTRY_H

#include "laws.h"

#include <ctype.h>

/* ---- Tables ---- */

static bool is_option_name(const char *name) {
    if (!name || !*name || *name == '-') return false;
    for (const char *c = name; *c; c++)
        if (!(islower((unsigned char)*c) || isdigit((unsigned char)*c) || *c == '-')) return false;
    return true;
}

static void check_option(const char *owner, const hdr_option *table, const hdr_option *option, bool common) {
    const char *name = option->name;
    CHECK(is_option_name(name), "%s --%s: not of [a-z0-9-]", owner, name);
    CHECK(option->help && option->help[0] && option->help[strlen(option->help) - 1] != '.' &&
              !strchr(option->help, '\n'),
          "%s --%s: no line of help, or a full stop", owner, name);
    CHECK((option->type == HDR_OPTION_FLAG) == !option->metavar, "%s --%s: what help calls the value", owner, name);
    CHECK(option->type != HDR_OPTION_CHOICE || (option->words && option->words[0]), "%s --%s: no words", owner, name);
    CHECK(option->type != HDR_OPTION_FLAG || !option->default_value, "%s --%s: a flag with a default", owner, name);
    CHECK(option->min <= option->max, "%s --%s: an empty range", owner, name);
    CHECK(common || !option->travels, "%s --%s: travels is for common options", owner, name);
    for (int w = 0; option->words && option->words[w]; w++)
        CHECK(is_option_name(option->words[w]), "%s --%s: word %s", owner, name, option->words[w]);
    for (const hdr_option *other = table; other != option; other++) {
        CHECK(strcmp(other->name, name) != 0, "%s: two options are --%s", owner, name);
        CHECK(!option->letter || other->letter != option->letter, "%s: two options are -%c", owner, option->letter);
    }
    for (const hdr_option *other = hdr_common_options(); !common && other->name; other++) {
        CHECK(strcmp(other->name, name) != 0, "%s: --%s is a common option", owner, name);
        CHECK(!option->letter || other->letter != option->letter, "%s: -%c is a common option", owner, option->letter);
    }
    if (!option->default_value) return;
    void *params = calloc(1, option->offset + 64);
    hdr_options given = {0};
    hdr_error error = {0};
    CHECK(hdr_option_set(option, option->default_value, params, &given, &error) == HDR_OK, "%s --%s: default: %s",
          owner, name, error.message);
    hdr_options_free(&given);
    free(params);
}

static void check_about(const hdr_verb_about *about) {
    const char *name = about->name, *summary = about->summary;
    CHECK(is_option_name(name), "verb %s: not of [a-z0-9-]", name);
    CHECK(summary && summary[0] && !isupper((unsigned char)summary[0]) && summary[strlen(summary) - 1] != '.',
          "%s: a summary has no capital and no full stop", name);
    CHECK(about->details && about->details[0] && about->details[strlen(about->details) - 1] == '.', "%s: details",
          name);
    CHECK(about->examples && about->examples[0], "%s: no example", name);
    for (int i = 0; about->examples && about->examples[i]; i++) {
        char as_verb[100], later[100];
        snprintf(as_verb, sizeof as_verb, about->alone ? "hdr %s" : "hdr %s ", name);
        snprintf(later, sizeof later, " then %s ", name);
        CHECK(!strncmp(about->examples[i], "hdr ", 4) && (about->alone || strstr(about->examples[i], "IN.exr")),
              "%s: example %s", name, about->examples[i]);
        CHECK(!strncmp(about->examples[i], as_verb, strlen(as_verb)) || strstr(about->examples[i], later),
              "%s: not in its example %s", name, about->examples[i]);
    }
    CHECK(about->options, "%s: no option table", name);
    for (const hdr_option *option = about->options; option && option->name; option++)
        check_option(name, about->options, option, false);
}

static void test_registry(void) {
    int count = 0;
    const hdr_verb_about *about;
    for (; (about = hdr_verb_at(count)) != NULL; count++) {
        check_about(about);
        CHECK(hdr_verb_named(about->name) == about, "%s is not found by its name", about->name);
        const hdr_verb *verb = hdr_verb_number(count);
        CHECK(verb && &verb->about == about, "%s: the two registries differ", about->name);
        CHECK((verb->open || verb->join || verb->guide) == about->stays && (!verb->open || about->kind == HDR_FILTER),
              "%s: what opens more than a picture stays", about->name);
        CHECK((verb->join != NULL) == (about->kind == HDR_JOIN), "%s: a join joins", about->name);
        CHECK((verb->guide != NULL) == (about->kind == HDR_GUIDED), "%s: what is guided has a guide", about->name);
        CHECK((verb->plan != NULL) == (about->kind == HDR_FILTER) &&
                  (verb->format != NULL) == (about->kind == HDR_FORMAT),
              "%s: a filter has a plan, a format a format", about->name);
    }
    CHECK(count > 0 && !hdr_verb_at(-1) && !hdr_verb_at(count) && !hdr_verb_at(count + 1000), "the registry's ends");
    CHECK(!hdr_verb_named("") && !hdr_verb_named("nonesuch"), "a verb that there is not");
    const hdr_option *common = hdr_common_options();
    for (const hdr_option *option = common; option->name; option++)
        check_option("common", common, option, true);
}

/* ---- Curves ---- */

/* Scenes that facts may tell of: ordinary, from end to end of float, constant, with nothing lit, and wholly negative.
 */
static hdr_facts plausible_facts(int scene) {
    hdr_facts facts = {
        .known = HDR_FACT_COMPONENTS | HDR_FACT_LUMINANCE | HDR_FACT_CHANNELS, .pixels = 1000, .lit = 900};
    double low = 1e-3, high = 4000, lowest = 0;
    if (scene == 1) low = 0x1p-149, high = (double)FLT_MAX, lowest = -(double)FLT_MAX;
    if (scene == 2) low = high = lowest = (double)0.18f;
    if (scene == 3) low = high = lowest = 0, facts.lit = 0;
    if (scene == 4) low = 0, high = -1, lowest = -5, facts.lit = 0;
    facts.min_component = facts.min_luminance = lowest;
    facts.max_component = facts.max_luminance = high;
    facts.min_positive_component = facts.min_lit = low;
    facts.log_average = facts.lit ? sqrt(low) * sqrt(high) : 0;
    facts.shifted_average = facts.log_average + 1;
    for (int i = 0; i < HDR_MAX_PERCENTILES; i++)
        facts.percentile[i] = i ? high : low;
    for (int c = 0; c < 3; c++)
        facts.channel_min[c] = lowest, facts.channel_max[c] = high;
    facts.channel_min[3] = facts.channel_max[3] = 1;
    return facts;
}

enum { CURVE_SCENES = 5, CURVE_VALUES = 2048 };

static int compare_reals(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* All doubles within float's range, ascending, with neighbours among them. */
static void draw_values(const hdr_step *step, double *values) {
    size_t count = 0;
    static const double ends[] = {0,   -0.0,      FLT_MAX, -FLT_MAX, 0x1p-149, -0x1p-149, 1,
                                  0.5, 0.0031308, 0.04045, 0.018,    0.081,    1.0 / 12};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++)
        values[count++] = ends[i];
    for (int c = 0; c < 6; c++) /* where the formula's own numbers lie */
        if (fabs(step->constants.v[c]) < (double)FLT_MAX) values[count++] = step->constants.v[c];
    while (count < CURVE_VALUES) {
        uint64_t kind = law_random() % 8;
        double value = kind == 0   ? -law_random_log(0x1p-149, FLT_MAX)
                       : kind == 1 ? law_random_unit()
                       : kind == 2 ? law_random_log(1e-4, 1e4)
                                   : law_random_log(0x1p-149, FLT_MAX);
        if (kind > 5) value = nextafter(values[law_random() % count], kind == 6 ? -1e39 : 1e39);
        values[count++] = fabs(value) <= (double)FLT_MAX ? value : 1;
    }
    qsort(values, count, sizeof *values, compare_reals);
}

static bool same_double(double a, double b) {
    return !memcmp(&a, &b, sizeof a);
}

static void check_rows(const char *name, const hdr_step *step, const double *values, const double *exact) {
    double work[CURVE_VALUES + 16];
    for (size_t count = 0; count <= CURVE_VALUES; count += count < 70 ? 1 : CURVE_VALUES - 70) {
        size_t first = count < 70 ? law_random() % (CURVE_VALUES - 70) : 0, offset = count % 8;
        for (size_t i = 0; i < CURVE_VALUES + 16; i++)
            work[i] = 7;
        memcpy(work + offset, values + first, count * sizeof *work);
        step->curve->rows(&step->constants, work + offset, count);
        size_t different = count;
        for (size_t i = 0; i < count; i++)
            if (!same_double(work[offset + i], exact[first + i])) different = i;
        CHECK(different == count, "%s (%s): rows and exact differ at %a", name, step->note,
              different < count ? values[first + different] : 0);
        bool beside = true;
        for (size_t i = 0; i < CURVE_VALUES + 16; i++)
            beside &= (i >= offset && i < offset + count) || work[i] == 7;
        CHECK(beside, "%s: rows writes beside its values", name);
    }
}

/* Standards whose own rounded constants make a curve fall, from the last number of one branch to the first of the next:
 * sRGB's by 2.86e-8, the inverse of BT.709's by 5.4977e-5, which sRGB's curve, of a slope of 4.6 there, makes 16.5
 * codes of 16 bits. */
typedef struct law_joint {
    const char *verb;
    double last; /* of the lower branch */
    double fall;
    int codes_8, codes_16; /* that a PNG's codes may fall by */
} law_joint;

static const law_joint law_joints[] = {{"srgb", 0.0031308, 2.9e-8, 0, 0},
                                       {"rec709", 0x1.4bc6a7ef9db22p-4 /* below 0.081 */, 5.498e-5, 0, 17}};

/* That of a step, or NULL: a curve has none unless it says so. */
static const law_joint *joint_of(const hdr_step *step) {
    for (size_t i = 0; i < sizeof law_joints / sizeof *law_joints; i++)
        if (step->curve && step->curve->has_joint && !strcmp(step->verb->about.name, law_joints[i].verb))
            return &law_joints[i];
    return NULL;
}

static bool meets_joint(const law_joint *joint, double below, double above) {
    return joint && below <= joint->last && above > joint->last;
}

/* How far a curve may fall by rounding: some ulps. pq's is an exponential of ln V, so that a rounding of that makes
 * |ln V| as many of V. */
static double rounding_room(const hdr_step *step, double value) {
    bool exponential = !strcmp(step->verb->about.name, "pq") && step->state[0] && strcmp(step->state, "linear") != 0;
    double ulps = exponential && value > 0 ? 4 + 2 * fabs(log(value)) : 4;
    return step->curve->monotone_to_the_bit ? 0 : ulps * DBL_EPSILON * fabs(value);
}

/* Falls of an ulp or two are rounding, which a curve that is monotone to the bit may not have. */
static void check_curve(const char *name, const hdr_step *step) {
    double values[CURVE_VALUES], exact[CURVE_VALUES];
    const law_joint *joint = joint_of(step);
    CHECK(step->curve->has_joint == (joint != NULL) && (!joint || step->curve->joint == joint->last),
          "%s: a joint that no standard has", name);
    draw_values(step, values);
    size_t nan = 0, fall = 0, unlit = 0;
    for (size_t i = 0; i < CURVE_VALUES; i++) {
        exact[i] = step->curve->exact(&step->constants, values[i]);
        nan += isnan(exact[i]);
        unlit += step->form == HDR_FORM_LUMINANCE && values[i] <= 0 && exact[i] != 0;
        double room = i == 0 ? 0 : rounding_room(step, exact[i - 1]);
        if (i > 0 && meets_joint(joint, values[i - 1], values[i])) room += joint->fall;
        if (i > 0 && exact[i] < exact[i - 1] - room) fall = i;
    }
    CHECK(nan == 0, "%s (%s): %zu results are NaN", name, step->note, nan);
    CHECK(unlit == 0, "%s (%s): not 0 for Y <= 0", name, step->note);
    CHECK(fall == 0, "%s (%s)%s falls at %a: from %a to %a", name, step->note,
          step->curve->monotone_to_the_bit ? ", said to be monotone to the bit," : "", values[fall],
          exact[fall ? fall - 1 : 0], exact[fall]);
    check_rows(name, step, values, exact);
}

/* A curve of two numbers: of luminances and surrounds of all sizes it makes neither NaN nor what is negative, 0 where
 * nothing is lit, the same by rows as one by one, and no less of more light in the same surround. */
static void check_local(const char *name, const hdr_step *step) {
    double values[CURVE_VALUES], surround[CURVE_VALUES], rows[CURVE_VALUES];
    draw_values(step, values);
    for (size_t i = 0; i < CURVE_VALUES; i++)
        surround[i] = i % 16 ? law_random_log(0x1p-149, FLT_MAX) : 0;
    memcpy(rows, values, sizeof rows);
    step->local->rows(&step->constants, rows, surround, CURVE_VALUES);
    size_t wrong = 0, different = 0, fall = 0;
    for (size_t i = 0; i < CURVE_VALUES; i++) {
        double exact = step->local->exact(&step->constants, values[i], surround[i]);
        wrong += !(exact >= 0) || (values[i] <= 0 && exact != 0);
        different += !same_double(exact, rows[i]);
        fall +=
            i > 0 && step->local->exact(&step->constants, values[i - 1], surround[i]) > exact * (1 + 4 * DBL_EPSILON);
    }
    CHECK(wrong == 0, "%s (%s): %zu results are NaN, negative, or not 0 for Y <= 0", name, step->note, wrong);
    CHECK(different == 0, "%s (%s): rows and exact differ at %zu values", name, step->note, different);
    CHECK(fall == 0, "%s (%s): falls at %zu values", name, step->note, fall);
}

/* A curve that is told a threshold: within [0,1], whose ends stay what they are, the same by rows as one by one, and no
 * less of a larger value or threshold. */
static void check_placed(const char *name, const hdr_step *step) {
    double values[CURVE_VALUES], thresholds[CURVE_VALUES], rows[CURVE_VALUES];
    draw_values(step, values);
    for (size_t i = 0; i < CURVE_VALUES; i++)
        thresholds[i] = hdr_dither_threshold(&step->dither, (int)law_random(), (int)law_random());
    memcpy(rows, values, sizeof rows);
    step->local->rows(&step->constants, rows, thresholds, CURVE_VALUES);
    size_t wrong = 0, different = 0, fall = 0;
    for (size_t i = 0; i < CURVE_VALUES; i++) {
        double t = thresholds[i], exact = step->local->exact(&step->constants, values[i], t);
        wrong += !(exact >= 0 && exact <= 1 && t > 0 && t < 1) || (values[i] <= 0 && exact != 0) ||
                 (values[i] >= 1 && exact != 1);
        different += !same_double(exact, rows[i]);
        fall += i > 0 && step->local->exact(&step->constants, values[i - 1], t) > exact;
        fall += step->local->exact(&step->constants, values[i], t / 2) > exact;
    }
    CHECK(wrong == 0, "%s (%s): %zu results are outside of [0,1], or its ends change", name, step->note, wrong);
    CHECK(different == 0, "%s (%s): rows and exact differ at %zu values", name, step->note, different);
    CHECK(fall == 0, "%s (%s): falls at %zu values", name, step->note, fall);
}

/* What the verb plans for a scene. */
static hdr_verdict law_plan(const law_variant *variant, int scene_number, hdr_step *step, hdr_error *error) {
    hdr_options given = {0};
    void *params = law_parameters(variant, &given);
    hdr_scene scene = {.facts = plausible_facts(scene_number), .state = "linear"};
    *step = (hdr_step){.verb = variant->verb, .clause = 1, .saturation = 1};
    hdr_verdict verdict = variant->verb->plan(params, &scene, step, error);
    hdr_options_free(&given);
    free(params);
    return verdict;
}

static void test_curves(void) {
    unsigned long curves = 0;
    for (int v = 0; v < law_variant_count; v++)
        for (int s = 0; s < CURVE_SCENES; s++) {
            const law_variant *variant = &law_variants[v];
            hdr_error error = {0};
            hdr_step step, again;
            hdr_verdict verdict = law_plan(variant, s, &step, &error);
            CHECK(verdict != HDR_REFUSE, "%s: %s", variant->words, error.message);
            law_plan(variant, s, &again, &error);
            CHECK(step.curve == again.curve && !memcmp(&step.constants, &again.constants, sizeof step.constants) &&
                      !strcmp(step.note, again.note) && !strcmp(step.state, again.state),
                  "%s: plan is not pure", variant->words);
            /* a skipped step is filled all the same: --no-skip does it */
            if (step.form != HDR_FORM_MATRIX && step.curve) check_curve(variant->words, &step), curves++;
            if (step.form == HDR_FORM_LOCAL) check_local(variant->words, &step), curves++;
            if (step.form == HDR_FORM_PLACED) check_placed(variant->words, &step), curves++;
        }
    CHECK(curves > 0, "no curve was tried");
}

#endif

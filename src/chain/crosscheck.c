/* Curves and matrices against OpenColorIO's, and against what is published. */
#include "base/pool.h"
#include "chain/chain.h"
#include "chain/published.h"
#include "kernel/strip.h"
#include "picture/colour.h"
#include "picture/ocio.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- What is compared ---- */

typedef struct curve_row {
    const char *what;        /* the clause */
    hdr_published published; /* what it is to be */
    double rounding;         /* and how far from it the roundings of double may take it, as a part of it */
    const char *theirs;      /* OpenColorIO's transform, as configurations have it */
    hdr_published follows;   /* the formula that it is known to follow instead; NULL: none */
    const char *reason;      /* and why that is another */
    double least, most;      /* its numbers are compared from here to there; both 0: all of them */
} curve_row;

#define EXPONENT "!<ExponentTransform> {value: 2.2"
#define TANGENT(gamma, offset) "!<ExponentWithLinearTransform> {gamma: " gamma ", offset: " offset
#define INVERSE ", direction: inverse}"
#define BUILTIN(style) "!<BuiltinTransform> {style: " style "}"
#define BUILTIN_BACK(style) "!<BuiltinTransform> {style: " style INVERSE
#define FLOAT_EXPONENT "its exponent is rounded to float32"
#define TANGENT_BREAK "its line is the tangent of its power, so break and slope are not those of the standard"
#define PQ_TABLE "it is a table of all halves, with lines in between"
#define PQ_TABLE_BACK "it is a table of 4096 numbers, with lines in between"
/* HLG is had only inside of a display's transform, behind the display's gamma of 1.2, which is undone in front, and
 * 10 is 1000 cd/m2. It ends at 1, and near black the gamma has a floor. */
#define HLG_DISPLAY "DISPLAY - CIE-XYZ-D65_to_REC.2100-HLG-1000nit"
#define HLG_LIGHT                                                                                                      \
    "!<MatrixTransform> {matrix: [9.504559270516717, 0, 0, 0, 0, 10, 0, 0, 0, 0, 10.890577507598784, 0, 0, 0, 0, 1]"
#define HLG                                                                                                            \
    "!<GroupTransform> {children: [!<ExponentTransform> {value: 1.2}, " HLG_LIGHT "}, " BUILTIN(HLG_DISPLAY) "]}"
#define HLG_BACK                                                                                                       \
    "!<GroupTransform> {children: [" BUILTIN_BACK(HLG_DISPLAY) ", " HLG_LIGHT INVERSE                                  \
                                                               ", !<ExponentTransform> {value: 1.2" INVERSE "]}"
#define HLG_WAY "it has the curve in a display's transform, from which light is taken out by a power of 1.2"

static const curve_row curves[] = {
    {"gamma --exponent 2.2", hdr_published_gamma, 1e-15, EXPONENT INVERSE, hdr_ocio_gamma, FLOAT_EXPONENT, 0, 0},
    {"gamma --exponent 2.2 --decode", hdr_published_gamma_back, 5e-15, EXPONENT "}", hdr_ocio_gamma_back,
     FLOAT_EXPONENT, 0, 0},
    {"srgb", hdr_published_srgb, 2e-15, TANGENT("2.4", "0.055") INVERSE, hdr_ocio_srgb, TANGENT_BREAK, 0, 0},
    {"srgb --decode", hdr_published_srgb_back, 3e-15, TANGENT("2.4", "0.055") "}", hdr_ocio_srgb_back, TANGENT_BREAK, 0,
     0},
    {"rec709", hdr_published_rec709, 2e-15, TANGENT("2.2222222222222223", "0.099") INVERSE, hdr_ocio_rec709,
     TANGENT_BREAK, 0, 0},
    {"rec709 --decode", hdr_published_rec709_back, 4e-15, TANGENT("2.2222222222222223", "0.099") "}",
     hdr_ocio_rec709_back, TANGENT_BREAK, 0, 0},
    /* what becomes of negative numbers is no part of the curves */
    {"pq", hdr_published_pq, 8e-15, BUILTIN("CURVE - LINEAR_to_ST-2084"), hdr_ocio_pq, PQ_TABLE, 0, 65504},
    {"pq --decode", hdr_published_pq_back, 8e-15, BUILTIN("CURVE - ST-2084_to_LINEAR"), hdr_ocio_pq_back, PQ_TABLE_BACK,
     0, 65504},
    {"hlg", hdr_published_hlg, 1e-15, HLG, hdr_published_hlg, HLG_WAY, 1e-3, 1},
    {"hlg --decode", hdr_published_hlg_back, 3e-14, HLG_BACK, hdr_published_hlg_back, HLG_WAY, 0.055, 1},
};
enum { CURVES = sizeof curves / sizeof curves[0] };

/* SMPTE ST 2065-1 and S-2014-004 (AP0, AP1): white is about D60. */
static const hdr_chromaticities ap0 = {{0.7347, 0.2653}, {0, 1}, {0.0001, -0.0770}, {0.32168, 0.33767}};
static const hdr_chromaticities ap1 = {{0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, {0.32168, 0.33767}};

#define AP1_TO_AP0 "ACEScg_to_ACES2065-1"
#define AP1_TO_REC709 "UTILITY - ACES-AP1_to_LINEAR-REC709_BFD"
#define AP0_TO_XYZ "UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD"
#define AP1_TO_XYZ "UTILITY - ACES-AP1_to_CIE-XYZ-D65_BFD"
#define BOTH(first, second) "!<GroupTransform> {children: [" first ", " second "]}"

typedef enum target { TO_REC709, TO_XYZ_D65, TO_LUMINANCE } target;

typedef struct matrix_row {
    const char *what, *theirs;
    const hdr_chromaticities *primaries;
    target to;
    const char *reason;
} matrix_row;

static const matrix_row matrices[] = {
    {"AP0 to Rec.709, Bradford", BOTH(BUILTIN_BACK(AP1_TO_AP0), BUILTIN(AP1_TO_REC709)), &ap0, TO_REC709, NULL},
    {"AP1 to Rec.709, Bradford", BUILTIN(AP1_TO_REC709), &ap1, TO_REC709, NULL},
    {"AP0 to XYZ of D65, Bradford", BUILTIN(AP0_TO_XYZ), &ap0, TO_XYZ_D65, NULL},
    {"AP1 to XYZ of D65, Bradford", BUILTIN(AP1_TO_XYZ), &ap1, TO_XYZ_D65, NULL},
    {"Rec.709 to XYZ", BOTH(BUILTIN_BACK(AP1_TO_REC709), BUILTIN(AP1_TO_XYZ)), &hdr_rec709, TO_XYZ_D65, NULL},
    {"luminance of Rec.709", BOTH(BUILTIN_BACK(AP1_TO_REC709), BUILTIN(AP1_TO_XYZ)), &hdr_rec709, TO_LUMINANCE,
     "its weights follow from the primaries, where BT.709 prints four digits"},
};
enum { MATRICES = sizeof matrices / sizeof matrices[0] };

/* ---- Distances ---- */

static const hdr_distance near = {2e-7, 1e-7};
/* of OpenColorIO's from its own formula: several roundings to float32, some of them raised to 2.4 */
static const hdr_distance follows = {1e-6, 1e-7};
static const hdr_distance nothing = {-1, -1};

static void widen(hdr_distance *distance, double value, double reference) {
    double apart = fabs(value - reference);
    bool small = fabs(reference) < 1e-3;
    if (distance->relative < 0) *distance = (hdr_distance){0, 0};
    if (isnan(apart)) apart = INFINITY;
    if (small && apart > distance->absolute) distance->absolute = apart;
    if (!small && apart / fabs(reference) > distance->relative) distance->relative = apart / fabs(reference);
}

static bool is_within(hdr_distance distance, hdr_distance most) {
    return distance.relative <= most.relative && distance.absolute <= most.absolute;
}

/* rounding: ours may be that far from what is published. */
static void judge(hdr_agreement *agreement, double rounding) {
    bool ours = is_within(agreement->ours, (hdr_distance){rounding, rounding});
    bool theirs = is_within(agreement->apart, near);
    bool explained = agreement->follows.relative >= 0 && is_within(agreement->follows, follows);
    agreement->agrees = ours && (theirs || explained);
}

/* ---- OpenColorIO's side ---- */

static hdr_ocio *open_transform(const char *transform, hdr_error *err) {
    char text[1000];
    int length = snprintf(text, sizeof text,
                          "ocio_profile_version: 2.1\n"
                          "file_rules:\n  - !<Rule> {name: Default, colorspace: a}\n"
                          "roles: {scene_linear: a}\n"
                          "colorspaces:\n  - !<ColorSpace> {name: a}\n"
                          "  - !<ColorSpace> {name: b, encoding: data, from_scene_reference: %s}\n",
                          transform);
    if (length < 0 || (size_t)length >= sizeof text) {
        hdr_fail(err, HDR_INTERNAL, "a transform's text is too long");
        return NULL;
    }
    return hdr_ocio_new(&(hdr_ocio_source){.text = text}, &(hdr_ocio_request){.from = "a", .to = "b"}, err);
}

/* Grey pixels, one a number. */
static bool map_numbers(const hdr_ocio *ocio, const float *numbers, float *results, size_t count) {
    float pixels[4 * HDR_STRIP];
    for (size_t i = 0; i < count; i++)
        for (size_t c = 0; c < 4; c++)
            pixels[4 * i + c] = c < 3 ? numbers[i] : 1;
    if (!hdr_ocio_apply(ocio, pixels, count)) return false;
    for (size_t i = 0; i < count; i++)
        results[i] = pixels[4 * i];
    return true;
}

/* ---- Curves ---- */

enum { HALVES = 65536, FLOATS = 1000000, NUMBERS = HALVES + FLOATS };

/* All finite halves, and floats in between at even steps of their logarithm. Returns how many. */
static size_t draw_numbers(size_t first, float *numbers) {
    size_t count = 0;
    for (size_t i = first; i < first + HDR_STRIP && i < NUMBERS; i++) {
        double value =
            i < HALVES ? hdr_half_value((uint16_t)i) : exp(log(1e-8) + log(1e12) * (double)(i - HALVES) / (FLOATS - 1));
        if (isfinite(value)) numbers[count++] = (float)value;
    }
    return count;
}

static void compare_numbers(const curve_row *row, const hdr_step *step, const float *numbers, const float *theirs,
                            size_t count, hdr_agreement *agreement) {
    for (size_t i = 0; i < count; i++) {
        double ours = hdr_held(step->curve->exact(&step->constants, (double)numbers[i]));
        widen(&agreement->ours, ours, hdr_held((double)row->published(numbers[i])));
        if (row->most > 0 && !((double)numbers[i] >= row->least && (double)numbers[i] <= row->most)) continue;
        widen(&agreement->apart, (double)theirs[i], ours);
        if (row->follows) widen(&agreement->follows, (double)theirs[i], (double)row->follows(numbers[i]));
        if (ours >= 0 && ours <= 1) agreement->codes = fmax(agreement->codes, 255 * fabs((double)theirs[i] - ours));
    }
    agreement->numbers += count;
}

/* The clause's step, for a linear picture. */
static hdr_status plan_row(const curve_row *row, hdr_chain *chain, hdr_step *step, hdr_error *err) {
    char text[100];
    const char *words[10];
    int count = 0;
    snprintf(text, sizeof text, "%s", row->what);
    for (char *rest = text, *word; (word = strtok_r(rest, " ", &rest)) != NULL && count < 10;)
        words[count++] = word;
    hdr_status status = hdr_chain_add(chain, words, count, err);
    if (status) return status;
    const hdr_clause *clause = &chain->clauses[0];
    *step = (hdr_step){.verb = clause->verb, .clause = 1, .saturation = 1};
    hdr_verdict verdict = clause->verb->plan(clause->params, &(hdr_scene){.state = "linear"}, step, err);
    if (verdict == HDR_REFUSE) return err->status;
    return step->form == HDR_FORM_CHANNEL ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "it is no curve");
}

static hdr_status compare_curve(const curve_row *row, hdr_agreement *agreement, hdr_error *err) {
    hdr_step step;
    hdr_chain *chain = hdr_chain_new(err);
    hdr_status status = chain ? plan_row(row, chain, &step, err) : HDR_INTERNAL;
    hdr_ocio *ocio = status ? NULL : open_transform(row->theirs, err);
    if (!status && !ocio) status = HDR_BAD_DATA;
    for (size_t first = 0; !status && first < NUMBERS; first += HDR_STRIP) {
        float numbers[HDR_STRIP], theirs[HDR_STRIP];
        size_t count = draw_numbers(first, numbers);
        if (!map_numbers(ocio, numbers, theirs, count)) status = hdr_fail(err, HDR_INTERNAL, "out of memory");
        if (!status) compare_numbers(row, &step, numbers, theirs, count, agreement);
    }
    hdr_ocio_free(ocio);
    hdr_chain_free(chain);
    judge(agreement, row->rounding);
    return status;
}

/* ---- Matrices ---- */

/* By rows; of luminance only the first. */
static bool our_matrix(const matrix_row *row, double m[9]) {
    double to_rec709[9], to_xyz[9];
    if (row->to == TO_LUMINANCE) return hdr_luminance_weights(row->primaries, m);
    if (!hdr_matrix_to_rec709(row->primaries, row->primaries->white, true, to_rec709) ||
        !hdr_matrix_to_xyz(&hdr_rec709, to_xyz))
        return false;
    for (int i = 0; i < 9; i++) {
        const double *a = to_xyz + i / 3 * 3, *b = to_rec709 + i % 3;
        m[i] = row->to == TO_REC709 ? to_rec709[i] : a[0] * b[0] + a[1] * b[3] + a[2] * b[6];
    }
    return true;
}

/* What the three primaries become is its columns. */
static bool their_matrix(const hdr_ocio *ocio, target to, double m[9]) {
    float pixels[12] = {1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1};
    if (!hdr_ocio_apply(ocio, pixels, 3)) return false;
    for (size_t i = 0; i < 9; i++)
        m[i] = (double)pixels[i % 3 * 4 + i / 3];
    if (to == TO_LUMINANCE) memmove(m, m + 3, 3 * sizeof *m);
    return true;
}

static hdr_status compare_matrix(const matrix_row *row, hdr_agreement *agreement, hdr_error *err) {
    /* ITU-R BT.709-6, item 3.2 */
    static const double printed[3] = {0.2126, 0.7152, 0.0722};
    double ours[9], theirs[9];
    hdr_ocio *ocio = open_transform(row->theirs, err);
    if (!ocio) return err->status;
    bool made = our_matrix(row, ours) && their_matrix(ocio, row->to, theirs);
    hdr_ocio_free(ocio);
    if (!made) return hdr_fail(err, HDR_INTERNAL, "%s: no matrix", row->what);
    agreement->numbers = row->to == TO_LUMINANCE ? 3 : 9;
    for (size_t i = 0; i < agreement->numbers; i++) {
        widen(&agreement->apart, theirs[i], ours[i]);
        agreement->codes = fmax(agreement->codes, 255 * fabs(theirs[i] - ours[i]));
        if (row->to == TO_LUMINANCE) widen(&agreement->ours, ours[i], printed[i]);
    }
    double derived[9]; /* what follows from the primaries: Y is the second row */
    if (row->to == TO_LUMINANCE && hdr_matrix_to_xyz(row->primaries, derived))
        for (int i = 0; i < 3; i++)
            widen(&agreement->follows, theirs[i], derived[3 + i]);
    judge(agreement, 0);
    return HDR_OK;
}

/* ---- All of it ---- */

typedef struct task {
    const curve_row *curve; /* or */
    const matrix_row *matrix;
    hdr_agreement *agreement;
} task;

typedef struct tasks {
    task task[CURVES + MATRICES];
    int count;
} tasks;

static hdr_status do_task(void *context, int item, int thread, hdr_error *err) {
    (void)thread;
    const task *t = &((const tasks *)context)->task[item];
    hdr_error own = {0};
    hdr_status status =
        t->curve ? compare_curve(t->curve, t->agreement, &own) : compare_matrix(t->matrix, t->agreement, &own);
    return status ? hdr_fail(err, own.status, "%s: %s", t->agreement->what, own.message) : HDR_OK;
}

/* Of a curve the verb is the first word. */
static bool is_asked_for(const char *verb, const char *what) {
    size_t length = strcspn(what, " ");
    return !verb || (strlen(verb) == length && strncmp(what, verb, length) == 0);
}

static void add_task(tasks *t, task added, const char *what, const char *theirs, const char *reason,
                     hdr_agreement *agreements) {
    added.agreement = &agreements[t->count];
    *added.agreement = (hdr_agreement){
        .what = what, .theirs = theirs, .ours = nothing, .apart = nothing, .follows = nothing, .reason = reason};
    t->task[t->count++] = added;
}

static tasks choose_tasks(const char *verb, hdr_agreement *agreements, int room) {
    tasks t = {.count = 0};
    for (int i = 0; i < CURVES && t.count < room; i++)
        if (is_asked_for(verb, curves[i].what))
            add_task(&t, (task){.curve = &curves[i]}, curves[i].what, curves[i].theirs, curves[i].reason, agreements);
    for (int i = 0; i < MATRICES && t.count < room && is_asked_for(verb, "primaries"); i++)
        add_task(&t, (task){.matrix = &matrices[i]}, matrices[i].what, matrices[i].theirs, matrices[i].reason,
                 agreements);
    return t;
}

hdr_status hdr_crosscheck(const char *verb, int threads, hdr_agreement agreements[], int room, int *count,
                          hdr_error *err) {
    hdr_error own = {0};
    tasks t = choose_tasks(verb, agreements, room);
    *count = t.count;
    if (t.count == 0)
        return hdr_fail(err, HDR_USAGE,
                        "there is nothing to compare of '%.100s': it may be a verb that encodes, or "
                        "primaries",
                        verb ? verb : "");
    if (hdr_ocio_check(err)) return HDR_BAD_DATA;
    hdr_pool *pool = hdr_pool_new(threads < t.count ? threads : t.count, &own);
    if (pool) hdr_pool_run(pool, t.count, do_task, &t, &own);
    hdr_pool_free(pool);
    return own.status ? hdr_fail(err, own.status, "%s", own.message) : HDR_OK;
}

/* The laws of SPEC.md that hold for every chain, tried with every filter of the registry: a verb that is added is under
 * them at once. Law 1 (pipe = then) is in test_pipes.sh, since it is about processes. */
#include "laws.h"
#include "laws_registry.h"

#include <limits.h>

#include <sys/wait.h>
#include <unistd.h>

/* The processor's level is chosen once a process: this program runs itself again with HDR_CPU and compares what it
 * computes. */
#define DIGESTS_WORD "digests"

/* A verb's defaults meet every picture, single options every fourth, in turn, combinations fewer; big pictures are met
 * by defaults. */
static bool is_tried(int variant, int picture) {
    int values = law_variants[variant].values;
    if (law_pictures[picture].few) return values == 0;
    int rarer = law_variants[variant].verb->surround ? 5 : 1; /* those that take their time */
    return values == 0 || (variant + picture) % ((values == 1 ? 4 : 17) * rarer) == 0;
}

static void check_same(const law_picture *picture, const law_variant *variant, const char *format, const char *setting,
                       const law_result *expected, const char *because) {
    law_result other = law_run(picture, "%s then %s %s", variant->words, format, setting);
    CHECK(law_same(expected, &other), "%s: %s then %s %s on %s: other bytes (status %d, %d; %s)", because,
          variant->words, format, setting, picture->name, (int)expected->status, (int)other.status, other.message);
    free(other.bytes);
}

/* ---- Laws 2, 3 and 4 ---- */

/* Spatial verbs compute surrounds within a bound of their own. */
static bool is_spatial(const law_variant *variant) {
    return variant->verb->surround && law_request(variant).plane;
}

static double bound_of(const law_variant *variant) {
    hdr_options given = {0};
    void *params = law_parameters(variant, &given);
    double bound = is_spatial(variant) ? variant->verb->bound(params) : 0;
    hdr_options_free(&given);
    free(params);
    return bound;
}

/* The farthest of all codes of two PNGs. */
static int code_distance(const law_result *a, const law_result *b) {
    size_t count = 0, other_count = 0;
    uint16_t *codes = law_read_png(a, &count), *others = law_read_png(b, &other_count);
    int farthest = codes && others && count == other_count ? 0 : INT_MAX;
    for (size_t i = 0; farthest != INT_MAX && i < count; i++) {
        int distance = abs((int)codes[i] - (int)others[i]);
        farthest = distance > farthest ? distance : farthest;
    }
    free(codes);
    free(others);
    return farthest;
}

static void check_reference_codes(const law_picture *picture, const law_variant *variant, const char *format,
                                  const law_result *base) {
    if (!is_spatial(variant)) {
        check_same(picture, variant, format, "-j 1 --reference", base, "law 4");
        return;
    }
    law_result exact = law_run(picture, "%s then %s -j 1 --reference", variant->words, format);
    int farthest = code_distance(base, &exact);
    /* sRGB's slope in logarithms is 1 at most */
    double codes = bound_of(variant) * (strstr(format, "16") ? 65535 : 255);
    CHECK(farthest <= fmin(codes < 2 ? 1 : ceil(codes) + 1, 65535),
          "law 4: %s then %s on %s: %d codes from the reference", variant->words, format, picture->name, farthest);
    free(exact.bytes);
}

/* How many floats lie between two. */
static uint32_t float_distance(float a, float b) {
    uint32_t bits[2];
    memcpy(&bits[0], &a, 4);
    memcpy(&bits[1], &b, 4);
    for (int i = 0; i < 2; i++)
        bits[i] = bits[i] & 0x80000000u ? 0x80000000u - (bits[i] & 0x7fffffffu) : bits[i] + 0x80000000u;
    return bits[0] > bits[1] ? bits[0] - bits[1] : bits[1] - bits[0];
}

static void check_reference_floats(const law_picture *picture, const law_variant *variant) {
    law_result fast = law_run(picture, "%s then pfm -j 1", variant->words);
    law_result exact = law_run(picture, "%s then pfm -j 1 --reference", variant->words);
    size_t count = 0, exact_count = 0;
    float *a = law_read_pfm(&fast, &count), *b = law_read_pfm(&exact, &exact_count);
    uint32_t farthest = count == exact_count ? 0 : UINT32_MAX;
    double bound = bound_of(variant);
    for (size_t i = 0; a && b && i < count && count == exact_count; i++) {
        uint32_t distance = float_distance(a[i], b[i]);
        if (!isfinite(bound) || fabs((double)a[i] - (double)b[i]) <= bound * fabs((double)b[i])) distance = 0;
        farthest = distance > farthest ? distance : farthest;
    }
    CHECK(a && b && farthest <= 2, "law 4: %s on %s: %u floats from the reference", variant->words, picture->name,
          farthest);
    free(a);
    free(b);
    free(fast.bytes);
    free(exact.bytes);
}

static void test_settings(void) {
    static const char *const formats[] = {"png", "png --bits 16", "exr"};
    static const char *const law2[] = {"-j 2", "-j 5", "--memory 1M", "-j 2 --memory 1M"};
    for (int p = 0; p < law_picture_count; p++)
        for (int v = 0; v < law_variant_count; v++) {
            if (!is_tried(v, p)) continue;
            const law_picture *picture = &law_pictures[p];
            const law_variant *variant = &law_variants[v];
            for (int f = 0; f < 3; f++) {
                law_result base = law_run(picture, "%s then %s -j 1", variant->words, formats[f]);
                CHECK(base.status == HDR_OK, "%s on %s: %s", variant->words, picture->name, base.message);
                int settings = variant->values == 0 && !picture->few ? 4 : 1;
                for (int s = 0; s < settings; s++)
                    check_same(picture, variant, formats[f], law2[(s + v) % 4], &base, "law 2");
                check_same(picture, variant, formats[f], "-j 1 --no-skip", &base, "law 3");
                if (f < 2) check_reference_codes(picture, variant, formats[f], &base);
                free(base.bytes);
            }
            if (!picture->few) check_reference_floats(picture, variant);
        }
}

/* ---- Laws 2, 3 and 4 for pairs of verbs ---- */

/* What the first verb makes of the picture is what the second plans with: ranges that are carried along, values at the
 * end of float. */
static void check_pair(const law_picture *picture, const law_variant *first, const law_variant *second) {
    static const char *const settings[] = {"-j 1 --no-skip", "-j 1 --reference", "-j 2"};
    char chain[500];
    snprintf(chain, sizeof chain, "%s then %s", first->words, second->words);
    law_result base = law_run(picture, "%s then png -j 1", chain);
    CHECK(base.status == HDR_OK || (base.status == HDR_BAD_DATA && strstr(base.message, "encoded already")),
          "%s on %s: %s", chain, picture->name, base.message);
    for (int s = 0; base.status == HDR_OK && s < 3; s++) {
        law_result other = law_run(picture, "%s then png %s", chain, settings[s]);
        bool nearly = strstr(settings[s], "--reference") && (is_spatial(first) || is_spatial(second));
        /* what comes behind may make more of a difference that is not small */
        if (nearly && (bound_of(first) > 1e-4 || bound_of(second) > 5e-3)) continue;
        CHECK(nearly ? code_distance(&base, &other) <= 1 : law_same(&base, &other),
              "%s then png %s on %s: other bytes (status %d)", chain, settings[s], picture->name, (int)other.status);
        free(other.bytes);
    }
    free(base.bytes);
}

static void test_pairs(void) {
    static const char *const names[] = {"hard, one plane", "alpha", "ordinary", "extreme"};
    enum { NAMES = sizeof names / sizeof *names };
    const law_picture *picture[NAMES] = {NULL};
    for (int p = 0; p < law_picture_count; p++)
        for (int n = 0; n < NAMES; n++)
            if (!strcmp(law_pictures[p].name, names[n])) picture[n] = &law_pictures[p];
    for (int a = 0; a < law_variant_count; a++)
        for (int b = 0; b < law_variant_count; b++) {
            const law_variant *first = &law_variants[a], *second = &law_variants[b];
            bool defaults = second->values == 0;
            if (first->values > 1 || second->values > 1 || !(defaults || (a + b) % 3 == 0)) continue;
            /* what spatial verbs do with their options does not depend on their neighbours */
            if ((is_spatial(first) || is_spatial(second)) && (!defaults || first->values) && (a + b) % 37) continue;
            check_pair(picture[(a + b / 3) % NAMES], first, second);
            if (defaults) check_pair(picture[(a + b / 3 + 1) % NAMES], first, second);
        }
}

/* ---- Law 2: instruction sets ---- */

/* Digests of all results, in order, one a line. */
static int print_digests(void) {
    static const char *const formats[] = {"png", "png --bits 16", "pfm"};
    for (int p = 0; p < law_picture_count; p++)
        for (int v = 0; v < law_variant_count; v++) {
            if (!is_tried(v, p)) continue;
            for (int f = 0; f < 3; f++) {
                law_result result = law_run(&law_pictures[p], "%s then %s -j 1", law_variants[v].words, formats[f]);
                printf("%016llx %d %d %d\n", (unsigned long long)law_digest(result.bytes, result.size), p, v, f);
                free(result.bytes);
            }
        }
    return 0;
}

static FILE *start_at_level(const char *level, pid_t *child) {
    int ends[2];
    if (pipe(ends)) return NULL;
    *child = fork();
    if (*child == 0) {
        setenv("HDR_CPU", level, 1);
        dup2(ends[1], 1);
        close(ends[0]);
        close(ends[1]);
        execl("/proc/self/exe", "test_laws", DIGESTS_WORD, (char *)NULL);
        _exit(127);
    }
    close(ends[1]);
    return fdopen(ends[0], "r");
}

static void test_levels(void) {
    static const char *const levels[] = {"c", "sse2", "avx2", "avx512"};
    enum { LEVELS = 4 };
    FILE *from[LEVELS];
    pid_t child[LEVELS];
    char line[LEVELS][100];
    for (int l = 0; l < LEVELS; l++)
        from[l] = start_at_level(levels[l], &child[l]);
    unsigned long lines = 0;
    for (bool more = true; more;) {
        for (int l = 0; l < LEVELS; l++)
            if (!from[l] || !fgets(line[l], sizeof line[l], from[l])) line[l][0] = 0;
        more = line[0][0] != 0;
        lines += more;
        int p = 0, v = 0, f = 0;
        if (sscanf(line[0], "%*s %d %d %d", &p, &v, &f) != 3) p = v = 0;
        for (int l = 1; l < LEVELS; l++)
            CHECK(!strcmp(line[0], line[l]), "law 2: HDR_CPU=%s and c differ: %s on %s (format %d)", levels[l],
                  law_variants[v].words, law_pictures[p].name, f);
    }
    for (int l = 0; l < LEVELS; l++) {
        int status = -1;
        if (from[l]) fclose(from[l]);
        waitpid(child[l], &status, 0);
        CHECK(status == 0, "the run with HDR_CPU=%s ended with status %d", levels[l], status);
    }
    CHECK(lines >= (unsigned long)law_variant_count, "only %lu results were compared", lines);
}

/* ---- Law 5 ---- */

/* Options with which a verb that takes facts depends on exposure after all: SPEC names them. */
static bool is_absolute(const law_variant *variant) {
    static const struct {
        const char *verb, *option, *text;
    } absolute[] = {{"log", "mode", "literal"}, {"reinhard", "delta", NULL}};
    for (int i = 0; i < variant->values; i++) {
        const law_value *value = &variant->value[i];
        if (value->option->type == HDR_OPTION_FACTS) return true; /* not those of the picture */
        /* a number where "auto" could stand is in the scene's units */
        for (int w = 0; value->option->words && value->option->words[w]; w++)
            if (value->option->type == HDR_OPTION_NUMBER && !strcmp(value->option->words[w], "auto") &&
                strcmp(value->text, "auto") != 0)
                return true;
        for (size_t a = 0; a < sizeof absolute / sizeof *absolute; a++)
            if (!strcmp(variant->verb->about.name, absolute[a].verb) &&
                !strcmp(value->option->name, absolute[a].option) &&
                (!absolute[a].text || !strcmp(value->text, absolute[a].text)))
                return true;
    }
    return false;
}

static bool takes_facts(const law_variant *variant) {
    hdr_request request = law_request(variant);
    return request.facts || request.percentiles;
}

static unsigned long compared_codes, changed_codes;

static void check_exposure(const law_variant *variant, const law_picture *picture, const law_picture *scaled,
                           int stops) {
    /* a legend tells the exposure */
    bool legend = hdr_option_find(variant->verb->about.options, "no-legend") && !strstr(variant->words, "--no-legend");
    const char *bare = legend ? " --no-legend" : "";
    law_result a = law_run(picture, "%s%s then png -j 1 --explain", variant->words, bare);
    law_result b = law_run(scaled, "%s%s then png -j 1", variant->words, bare);
    /* what has nothing to measure by leaves the picture as it is: black, or a percentile that is not above 0 */
    if (strstr(a.said, "skipped:")) {
        free(a.bytes);
        free(b.bytes);
        return;
    }
    size_t count = 0, scaled_count = 0;
    uint16_t *before = law_read_png(&a, &count), *after = law_read_png(&b, &scaled_count);
    int farthest = 0;
    for (size_t i = 0; before && after && count == scaled_count && i < count; i++) {
        int distance = abs((int)before[i] - (int)after[i]);
        farthest = distance > farthest ? distance : farthest;
        changed_codes += distance != 0;
        compared_codes++;
    }
    CHECK(count > 0 && count == scaled_count && farthest <= 1, "law 5: %s on %s times 2^%d: a code changes by %d",
          variant->words, picture->name, stops, farthest);
    free(before);
    free(after);
    free(a.bytes);
    free(b.bytes);
}

static void test_exposure(void) {
    for (int p = 0; p < law_picture_count; p++) {
        law_picture *picture = &law_pictures[p];
        if (!picture->moderate || picture->few) continue;
        law_picture scaled =
            law_new_picture(picture->name, picture->width, picture->height, picture->planes, picture->alpha);
        if (picture->alpha) memcpy(scaled.alpha, picture->alpha, law_pixels(picture) * sizeof(float));
        for (int stops = -20; stops <= 20; stops += p % 3 ? 20 : 8) {
            for (int c = 0; c < picture->planes; c++)
                for (size_t i = 0; i < law_pixels(picture); i++)
                    scaled.plane[c][i] = ldexpf(picture->plane[c][i], stops);
            for (int v = 0; v < law_variant_count; v++)
                if (is_tried(v, p) && takes_facts(&law_variants[v]) && !is_absolute(&law_variants[v]))
                    check_exposure(&law_variants[v], picture, &scaled, stops);
        }
        law_free_picture(&scaled);
    }
    CHECK(compared_codes > 0, "law 5: nothing was compared");
}

/* ---- Law 6 ---- */

static void check_finite(const law_picture *picture, const char *chain) {
    law_result pfm = law_run(picture, "%s then pfm -j 1", chain);
    /* a chain that encodes twice is refused */
    if (pfm.status == HDR_BAD_DATA && strstr(pfm.message, "encoded already")) return;
    size_t count = 0, bad = 0;
    float *values = law_read_pfm(&pfm, &count);
    for (size_t i = 0; i < count; i++)
        bad += !isfinite(values[i]);
    CHECK(values && bad == 0, "law 6: %s on %s: %zu of %zu floats are not finite %s", chain, picture->name, bad, count,
          pfm.message);
    free(values);
    free(pfm.bytes);
    static const char *const types[] = {"float", "half"};
    for (int t = 0; t < 2; t++) {
        if (strstr(chain, " then ") && t == (int)(strlen(chain) & 1)) continue; /* one of them for each pair of verbs */
        law_result exr = law_run(picture, "%s then exr -j 1 --compression none --type %s", chain, types[t]);
        bool read = exr.bytes && law_count_exr(&exr, t == 1, &count, &bad);
        CHECK(read && bad == 0, "law 6: %s then exr --type %s on %s: %zu of %zu components are not finite %s", chain,
              types[t], picture->name, bad, count, exr.message);
        free(exr.bytes);
    }
}

static void test_finite(void) {
    char chain[500];
    for (int p = 0; p < law_picture_count; p++) {
        const law_picture *picture = &law_pictures[p];
        bool hardest = strstr(picture->name, "extreme");
        for (int v = 0; v < law_variant_count; v++) {
            const law_variant *variant = &law_variants[v];
            bool hard = hardest && (!variant->verb->surround || v % 6 == 0);
            if (!is_tried(v, p) && !hard) continue;
            check_finite(picture, variant->words);
            if (!hard || variant->values > 1) continue;
            /* any verb's defaults before and after; among them what raises to the ends of float */
            snprintf(chain, sizeof chain, "%s then expose --ev 300", variant->words);
            check_finite(picture, chain);
            snprintf(chain, sizeof chain, "expose --ev 300 then %s", variant->words);
            check_finite(picture, chain);
            for (int w = 0; w < law_variant_count; w++) {
                if (law_variants[w].values) continue;
                snprintf(chain, sizeof chain, "%s then %s", variant->words, law_variants[w].words);
                check_finite(picture, chain);
            }
        }
    }
}

/* ---- Law 7 ---- */

static int compare_floats(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* From -10 over 0 to 1e6, with runs of neighbouring floats where curves have their joints. */
static law_picture make_ramp(void) {
    enum { SPREAD = 3000, RUN = 100 };
    static const float joints[] = {0.0031308f, 0.04045f, 0.018f, 0.081f, 0.5f, 1, 12.92f, 1e-3f, 1.0f / 12};
    enum { JOINTS = sizeof joints / sizeof *joints };
    law_picture ramp = law_new_picture("ramp", SPREAD + JOINTS * RUN + 4, 1, 1, false);
    float *at = ramp.plane[0];
    for (int i = 0; i < SPREAD; i++)
        *at++ = (float)(i % 10 ? law_random_log(1e-7, 1e6) : -law_random_log(1e-7, 10));
    for (int j = 0; j < JOINTS; j++) {
        float value = joints[j];
        for (int i = 0; i < RUN / 2; i++)
            value = nextafterf(value, -1);
        for (int i = 0; i < RUN; i++)
            *at++ = value, value = nextafterf(value, 1e9f);
    }
    at[0] = -10;
    at[1] = 0;
    at[2] = -0.0f;
    at[3] = 1e6f;
    qsort(ramp.plane[0], law_pixels(&ramp), sizeof(float), compare_floats);
    return ramp;
}

/* room: how far a value may fall behind the one before it at the joint of a curve. */
static void check_ascends(const law_variant *variant, const char *what, const float *ramp, const double *values,
                          size_t count, size_t expected, const law_joint *joint, double room) {
    size_t falls = 0, first = 0;
    for (size_t i = 1; i < count; i++) {
        double lowest = values[i - 1] - (meets_joint(joint, (double)ramp[i - 1], (double)ramp[i]) ? room : 0);
        if (!(values[i] >= lowest) && falls++ == 0) first = i;
    }
    CHECK(count == expected && falls == 0, "law 7: %s falls %zu times among %zu %s, first at %zu: %.9g to %.9g",
          variant->words, falls, count, what, first, count ? values[first - (first > 0)] : 0,
          count ? values[first] : 0);
}

/* Global curves: those that look at a pixel by itself, and not at its place, by a formula of their own. What is shown
 * by a palette grows by the palette's order, which is no order of numbers. */
static bool is_global(const law_variant *variant, const hdr_step *step) {
    return !is_spatial(variant) && step->form != HDR_FORM_PLACED && step->form != HDR_FORM_MAPPED &&
           step->form != HDR_FORM_PALETTE;
}

static void test_monotone(void) {
    static const char *const formats[] = {"png", "png --bits 16", "pfm"};
    law_picture ramp = make_ramp();
    size_t width = law_pixels(&ramp), count = 0;
    double *values = malloc(width * sizeof *values);
    for (int v = 0; v < law_variant_count; v++) {
        hdr_step step;
        law_plan(&law_variants[v], 0, &step, NULL);
        const law_joint *joint = joint_of(&step);
        const double room[] = {joint ? joint->codes_8 : 0, joint ? joint->codes_16 : 0, joint ? joint->fall : 0};
        for (int f = 0; f < 3 && is_global(&law_variants[v], &step); f++) {
            law_result result = law_run(&ramp, "%s then %s -j 1", law_variants[v].words, formats[f]);
            float *floats = f == 2 ? law_read_pfm(&result, &count) : NULL;
            uint16_t *codes = f == 2 ? NULL : law_read_png(&result, &count);
            for (size_t i = 0; i < count && i < width; i++)
                values[i] = floats ? (double)floats[i] : codes[i];
            check_ascends(&law_variants[v], formats[f], ramp.plane[0], values, count < width ? count : width, width,
                          joint, room[f]);
            free(floats);
            free(codes);
            free(result.bytes);
        }
    }
    free(values);
    law_free_picture(&ramp);
}

/* ---- What is skipped ---- */

static void check_left_out(const law_picture *picture, const char *with, const char *verb, const char *without) {
    char words[100];
    snprintf(words, sizeof words, "(%s) skipped", verb);
    for (int forced = 0; forced < 2; forced++) {
        law_result a = law_run(picture, "%s then exr --explain%s", with, forced ? " --no-skip" : "");
        law_result b = law_run(picture, "%s", without);
        CHECK(a.status == HDR_OK && (strstr(a.said, words) == NULL) == forced, "%s on %s: %s should be %s:\n%s", with,
              picture->name, verb, forced ? "done" : "skipped", a.said);
        CHECK(law_same(&a, &b), "%s and %s on %s: not the same bytes", with, without, picture->name);
        free(a.bytes);
        free(b.bytes);
    }
}

static void test_skips(void) {
    law_picture one = law_new_picture("maximum 1", 30, 40, 3, false);
    for (int p = 0; p < 3; p++)
        for (size_t i = 0; i < law_pixels(&one); i++)
            one.plane[p][i] = (float)law_random_log(1e-4, 1);
    one.plane[1][700] = 1;
    check_left_out(&one, "expose --ev 0", "expose", "exr");
    check_left_out(&one, "divmax", "divmax", "exr");
    check_left_out(&one, "divmax then clamp", "clamp", "exr");
    one.plane[2][100] = 5;
    check_left_out(&one, "divmax then clamp", "clamp", "divmax then exr");
    check_left_out(&one, "divmax then divmax", "divmax", "divmax then exr");
    law_free_picture(&one);
    law_picture black = law_new_picture("black", 30, 40, 1, false);
    check_left_out(&black, "divmax", "divmax", "exr");
    check_left_out(&black, "expose --auto", "expose", "exr");
    law_free_picture(&black);
}

/* ---- All of it ---- */

static void add_corpus(void) {
    static const char *const small[] = {"torture/AllHalfValues.exr", "torture/WideFloatRange.exr",
                                        "render/crop_test.exr"};
    const char *folder = getenv("HDRPIPE_CORPUS");
    char path[4096];
    for (size_t i = 0; i < sizeof small / sizeof *small; i++) {
        snprintf(path, sizeof path, "%s/%s", folder ? folder : "../shared/corpus", small[i]);
        int before = law_picture_count;
        law_add_files(path, true);
        if (law_picture_count == before) CHECK_SKIP("no %s", path);
    }
}

int main(int argc, char **argv) {
    law_make_variants();
    law_make_synthetic();
    law_add_files("testdata/tiny/*.exr", false);
    if (argc > 1 && !strcmp(argv[1], DIGESTS_WORD)) return print_digests();
    CHECK(law_variant_count > 10, "only %d variants", law_variant_count);
    test_registry();
    test_curves();
    test_levels();
    test_skips();
    test_monotone();
    test_exposure();
    add_corpus();
    test_settings();
    test_pairs();
    test_finite();
    printf("%d variants of verbs, %d pictures; law 5: %lu of %lu codes change, by 1\n", law_variant_count,
           law_picture_count, changed_codes, compared_codes);
    for (int p = 0; p < law_picture_count; p++) {
        free((char *)law_pictures[p].path);
        law_free_picture(&law_pictures[p]);
    }
    return check_done("test_laws");
}

/* Facts of a whole shot: their text, the JSON that they are read from, and the survey that finds them, against sums and
 * percentiles that are computed here by sorting. */
#include "chain/shot.h"
#include "check.h"
#include "hdrpipe.h"
#include "picture/facts.h"

#include <float.h>
#include <locale.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

static uint64_t random_state = 1;

/* SplitMix64. */
static uint64_t random_bits(void) {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static double random_unit(void) {
    return (double)(random_bits() >> 11) * 0x1p-53;
}

/* ---- As text ---- */

typedef struct params {
    int before;
    hdr_shot shot;
    int behind;
} params;

static const hdr_option table[] = {{.name = "facts",
                                    .type = HDR_OPTION_FACTS,
                                    .offset = offsetof(params, shot),
                                    .metavar = "FILE",
                                    .help = "facts of the shot"},
                                   {0}};

static hdr_status set(const char *text, params *p, hdr_options *given, hdr_error *error) {
    *p = (params){.before = 1, .behind = 2};
    hdr_options_default(table, p);
    CHECK(!p->shot.given && !hdr_options_shot(table, p), "no facts are given by default");
    return hdr_option_set(&table[0], text, p, given, error);
}

static bool same_shot(const hdr_shot *a, const hdr_shot *b) {
    return a->given == b->given && a->lit == b->lit && a->log_average == b->log_average &&
           a->max_luminance == b->max_luminance && a->low == b->low && a->high == b->high;
}

/* To text, into an option, and out of it as words of the head. */
static void check_round_trip(const hdr_shot *shot) {
    char text[HDR_SHOT_TEXT], expected[HDR_SHOT_TEXT + 20];
    params p;
    hdr_options given = {0};
    hdr_error error = {0};
    hdr_bytes words = {0};
    hdr_shot_print(shot, text);
    CHECK(hdr_shot_is_text(text), "not taken for facts: %s", text);
    CHECK(set(text, &p, &given, &error) == HDR_OK, "%s", error.message);
    CHECK(same_shot(&p.shot, shot) && p.before == 1 && p.behind == 2, "other numbers come out of %s", text);
    CHECK(hdr_options_shot(table, &p) == &p.shot, "given facts are found");
    snprintf(expected, sizeof expected, " --facts %s", text);
    CHECK(hdr_options_print(&given, &words, &error) == HDR_OK && words.size == strlen(expected) &&
              !memcmp(words.data, expected, words.size),
          "the head has '%.*s'", (int)words.size, (const char *)words.data);
    hdr_options_free(&given);
    free(words.data);
}

static hdr_shot random_shot(void) {
    hdr_shot shot = {.given = true, .lit = true};
    shot.low = pow(10, random_unit() * 40 - 44);
    shot.high = shot.low * (1 + random_unit() * 1e6);
    shot.max_luminance = shot.high * (1 + random_unit() * 100);
    shot.log_average = shot.max_luminance * random_unit();
    return shot;
}

static void test_round_trips(void) {
    static const hdr_shot ends[] = {{true, false, 0, 0, 0, 0},
                                    {true, true, 0.18, 0.18, 0.18, 0.18},
                                    {true, true, 1e-200, 1e50, 1e-200, 1e50},
                                    {true, true, 0x1p-149, 0x1p-149, 0x1p-149, 0x1p-149},
                                    /* a maximum of half the least float, whose percentiles are rounded up to that */
                                    {true, true, 0x1p-151, 0x1p-150, 0x1p-149, 0x1p-149}};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++)
        check_round_trip(&ends[i]);
    for (int i = 0; i < 2000; i++) {
        hdr_shot shot = random_shot();
        check_round_trip(&shot);
    }
    static const char *const commas[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE", NULL};
    for (int i = 0; commas[i]; i++)
        if (setlocale(LC_NUMERIC, commas[i])) break;
    check_round_trip(&ends[1]);
    setlocale(LC_NUMERIC, "C");
}

static void test_bad_texts(void) {
    static const char *const bad[] = {"",
                                      "shot.json",
                                      "log_average",
                                      "log_average=",
                                      "log_average=1",
                                      "log_average=1,max_luminance=2,p1=0.5",
                                      "log_average=1,max_luminance=2,p1=0.5,p99=",
                                      "log_average=1,max_luminance=2,p1=0.5,p99=1,",
                                      "log_average=1,max_luminance=2,p1=0.5,p99=1 ",
                                      "log_average=1,max_luminance=2,p1=0.5,p99=1,p100=2",
                                      "log_average= 1,max_luminance=2,p1=0.5,p99=1",
                                      "log_average=1,max_luminance=2,p99=1,p1=0.5",
                                      "log_average=1;max_luminance=2;p1=0.5;p99=1",
                                      "max_luminance=2,log_average=1,p1=0.5,p99=1",
                                      "log_average=one,max_luminance=2,p1=0.5,p99=1",
                                      "log_average=0x1,max_luminance=2,p1=0.5,p99=1",
                                      "log_average=nan,max_luminance=2,p1=0.5,p99=1",
                                      "log_average=1,max_luminance=inf,p1=0.5,p99=1",
                                      "log_average=1,max_luminance=1e999,p1=0.5,p99=1",
                                      "log_average=-1,max_luminance=2,p1=0.5,p99=1",
                                      "log_average=1,max_luminance=2,p1=-0.5,p99=1",
                                      "log_average=0,max_luminance=2,p1=0.5,p99=1",
                                      "log_average=1,max_luminance=2,p1=0,p99=1",
                                      "log_average=0,max_luminance=2,p1=0,p99=0",
                                      "log_average=1,max_luminance=0,p1=0,p99=0",
                                      "log_average=3,max_luminance=2,p1=0.5,p99=1",
                                      "log_average=1,max_luminance=2,p1=1,p99=0.5",
                                      "log_average=1,max_luminance=2,p1=0.5,p99=2.1",
                                      "log_average=1e-251,max_luminance=2,p1=0.5,p99=1",
                                      "log_average=1,max_luminance=1e51,p1=0.5,p99=1"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        params p;
        hdr_options given = {0};
        hdr_error error = {0};
        CHECK(set(bad[i], &p, &given, &error) == HDR_USAGE, "%s is taken", bad[i]);
        CHECK(!p.shot.given && given.count == 0, "%s leaves something behind", bad[i]);
        CHECK(strstr(error.message, "--facts: ") && strstr(error.message, "\n      --facts FILE"), "%s: %s", bad[i],
              error.message);
        hdr_options_free(&given);
    }
}

/* ---- In place of a picture's ---- */

static void test_requests(void) {
    const hdr_shot shot = {true, true, 2, 9, 1, 5};
    const struct {
        hdr_population of;
        hdr_decimal percent;
        double wanted; /* 0: a shot has no such percentile */
    } percentiles[] = {{HDR_OF_LIT, {1, 0}, 1},        {HDR_OF_LIT, {99, 0}, 5},      {HDR_OF_LIT, {990, 1}, 5},
                       {HDR_OF_LIT, {1001, 3}, 0},     {HDR_OF_LIT, {50, 0}, 0},      {HDR_OF_LIT, {100, 0}, 0},
                       {HDR_OF_LUMINANCE, {99, 0}, 0}, {HDR_OF_COMPONENTS, {1, 0}, 0}};
    for (size_t i = 0; i < sizeof percentiles / sizeof *percentiles; i++) {
        hdr_request request = {.facts = HDR_FACT_LUMINANCE, .percentiles = 2};
        request.percentile[0].of = HDR_OF_LIT;
        request.percentile[0].percent = (hdr_decimal){99, 0};
        request.percentile[1].of = percentiles[i].of;
        request.percentile[1].percent = percentiles[i].percent;
        hdr_facts facts = {.known = HDR_FACT_COMPONENTS, .max_component = 7, .max_luminance = 3, .min_lit = 1};
        bool satisfied = hdr_facts_of_shot(&shot, &request, &facts);
        CHECK(satisfied == (percentiles[i].wanted > 0), "percentile %zu: %s", i, satisfied ? "satisfied" : "refused");
        if (!satisfied) continue;
        CHECK(facts.percentile[0] == 5 && facts.percentile[1] == percentiles[i].wanted, "percentile %zu is %g", i,
              facts.percentile[1]);
        CHECK(facts.known == (HDR_FACT_COMPONENTS | HDR_FACT_LUMINANCE) && facts.max_component == 7, "what was known");
        CHECK(facts.lit == 1 && facts.log_average == 2 && facts.max_luminance == 9 && facts.min_lit == 0,
              "the numbers are the shot's");
    }
    static const unsigned refused[] = {HDR_FACT_COMPONENTS, HDR_FACT_CHANNELS,
                                       HDR_FACT_COMPONENTS | HDR_FACT_LUMINANCE};
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        hdr_facts facts = {.known = 0};
        CHECK(!hdr_facts_of_shot(&shot, &(hdr_request){.facts = refused[i]}, &facts) && !facts.known,
              "facts %u are none of a shot's", refused[i]);
    }
}

/* ---- From JSON ---- */

#define A_FILE(name)                                                                                                   \
    "{\"file\": \"" name "\", \"window\": [0, -1, 2.5e+1], \"pixels\": 100, \"lit\": 90, \"min\": {\"R\": -1E-2}, "    \
    "\"max_luminance\": 8, \"log_average\": 0.25, \"percentiles\": {\"0.1\": 0.0625, \"1\": 0.125, \"99\": 4, "        \
    "\"99.9\": 8}, \"neutral\": null, \"grey\": false, \"opaque\": true}\n"
#define ALL(count)                                                                                                     \
    "{\"files\": " count ", \"pixels\": 200, \"lit\": 180, \"max_luminance\": 16, \"log_average\": 0.5, "              \
    "\"percentiles\": {\"1\": 0.25, \"99\": 12}, \"grey\": true}\n"

static hdr_status read_text(const char *text, hdr_shot *shot, hdr_error *error) {
    *error = (hdr_error){.status = HDR_OK};
    return hdr_shot_read(text, strlen(text), shot, error);
}

static void test_good_json(void) {
    static const hdr_shot one = {true, true, 0.25, 8, 0.125, 4}, two = {true, true, 0.5, 16, 0.25, 12};
    static const hdr_shot dark = {.given = true};
    static const struct good {
        const char *text;
        const hdr_shot *shot;
    } good[] = {
        {A_FILE("a"), &one},
        {A_FILE("a") A_FILE("b") ALL("2"), &two},
        {A_FILE("a") A_FILE("a") A_FILE("a") ALL("3") "\n \t\r\n", &two},
        {ALL("7"), &two}, /* the last line alone */
        {A_FILE("\\\"\\\\\\/\\b\\f\\n\\r\\t\\u00fF \xc3\xa4 \xff files lit"), &one},
        {"{\"file\":\"\",\"pixels\":0,\"lit\":0,\"max_luminance\":0,\"log_average\":0,\"percentiles\":{\"1\":0,"
         "\"99\":0}}",
         &dark},
        /* where nothing is lit the maximum may be below 0 */
        {"{\"file\":\"\",\"pixels\":9,\"lit\":0,\"max_luminance\":-2,\"log_average\":0,\"percentiles\":{\"1\":0,"
         "\"99\":0}}",
         &dark},
        /* what other members hold does not matter, whatever they are called */
        {"{\"x\": {\"lit\": 7, \"percentiles\": {\"1\": 99}, \"file\": 1, \"files\": 2}, \"y\": [{\"pixels\": 1}], "
         "\"file\": \"\", \"pixels\":100,\"lit\":90,\"max_luminance\":8,\"log_average\":0.25,\"percentiles\":{\"x\": "
         "{\"1\": 3}, \"1\":0.125,\"99\":4}}",
         &one},
    };
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        hdr_shot shot;
        hdr_error error;
        CHECK(read_text(good[i].text, &shot, &error) == HDR_OK, "%s: %s", good[i].text, error.message);
        CHECK(same_shot(&shot, good[i].shot), "other facts are read from %s", good[i].text);
    }
}

#define NUMBERS(pixels, lit, most, average, low, high)                                                                 \
    "{\"file\":\"\",\"pixels\":" pixels ",\"lit\":" lit ",\"max_luminance\":" most ",\"log_average\":" average         \
    ",\"percentiles\":{\"1\":" low ",\"99\":" high "}}"

static void test_bad_json(void) {
    static const struct bad {
        const char *text, *what;
    } bad[] = {
        {"", "is empty"},
        {" \n", "is empty"},
        {"[]", "is no JSON"},
        {"null", "is no JSON"},
        {"hdrpipe 1\n", "is no JSON"},
        {"{}", "lacks"},
        {"{\"file\": \"a\"}", "lacks"},
        {A_FILE("a") A_FILE("b"), "but not of all together"},
        {A_FILE("a") A_FILE("b") ALL("3"), "fewer or more"},
        {A_FILE("a") A_FILE("b") ALL("2") A_FILE("c"), "goes on"},
        {A_FILE("a") A_FILE("b") ALL("2") A_FILE("a") A_FILE("b") ALL("2"), "goes on"},
        {ALL("2") ALL("2"), "goes on"},
        {A_FILE("a") "}", "is no JSON"},
        {A_FILE("a") "x", "is no JSON"},
        {A_FILE("\n"), "is no JSON"},
        {A_FILE("\\x"), "is no JSON"},
        {A_FILE("\\u12g4"), "is no JSON"},
        {A_FILE("a") "{\"file\": \"b", "is cut off"},
        {NUMBERS("100", "90", "8", "0.25", "0.125", "4") ",", "is no JSON"},
        {NUMBERS("100", "090", "8", "0.25", "0.125", "4"), "is no JSON"},
        {NUMBERS("100", "+90", "8", "0.25", "0.125", "4"), "is no JSON"},
        {NUMBERS("100", "90.", "8", "0.25", "0.125", "4"), "is no JSON"},
        {NUMBERS("100", "90", ".8", "0.25", "0.125", "4"), "is no JSON"},
        {NUMBERS("100", "90", "8e", "0.25", "0.125", "4"), "is no JSON"},
        {NUMBERS("100", "90", "inf", "0.25", "0.125", "4"), "is no JSON"},
        {NUMBERS("100", "90", "NaN", "0.25", "0.125", "4"), "is no JSON"},
        {NUMBERS("100", "90", "0x8", "0.25", "0.125", "4"), "is no JSON"},
        {NUMBERS("100", "90", "8 8", "0.25", "0.125", "4"), "is no JSON"},
        {NUMBERS("100", "90", "8", "0,25", "0.125", "4"), "is no JSON"},
        {NUMBERS("100", "90", "null", "0.25", "0.125", "4"), "lacks"},
        {NUMBERS("100", "90", "\"8\"", "0.25", "0.125", "4"), "lacks"},
        {NUMBERS("100", "90", "1e999", "0.25", "0.125", "4"), "not finite"},
        {NUMBERS("100", "90", "8", "-0.25", "0.125", "4"), "negative"},
        {NUMBERS("100", "90", "8", "0.25", "-0.125", "4"), "negative"},
        {NUMBERS("100", "90", "-8", "0.25", "0.125", "4"), "negative"},
        {NUMBERS("100", "0", "8", "0.25", "0.125", "4"), "contradicts"},
        {NUMBERS("100", "90", "8", "0", "0", "0"), "contradicts"},
        {NUMBERS("100", "0", "8", "0", "0", "0"), "contradicts"},
        {NUMBERS("100", "101", "8", "0.25", "0.125", "4"), "contradicts"},
        {NUMBERS("100", "-1", "8", "0.25", "0.125", "4"), "contradicts"},
        {NUMBERS("100", "90", "8", "9", "0.125", "4"), "contradicts"},
        {NUMBERS("100", "90", "8", "0.25", "5", "4"), "contradicts"},
        {NUMBERS("100", "90", "8", "0.25", "0.125", "9"), "contradicts"},
        {"{\"files\": 2, \"file\": \"\", \"pixels\": 100, \"lit\": 90, \"max_luminance\": 8, \"log_average\": 0.25, "
         "\"percentiles\": {\"1\": 0.125, \"99\": 4}}",
         "lacks"},
        {"{\"file\": \"\", \"lit\": 1, \"lit\": 1}", "twice"},
        {"{\"file\": 00000000000000000000000000000000000000000000000000000000000000000000}", "is no JSON"},
        {"{\"lit\": 1000000000000000000000000000000000000000000000000000000000000000000000}", "too many digits"},
        {"{\"x\":[[[[[[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]]]]]}", "nested"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        hdr_shot shot = {.given = true};
        hdr_error error;
        CHECK(read_text(bad[i].text, &shot, &error) == HDR_BAD_DATA, "taken: %s", bad[i].text);
        CHECK(strstr(error.message, bad[i].what) && strstr(error.message, "hdr stats --json"), "%s: %s", bad[i].text,
              error.message);
        CHECK(!shot.given, "something is left of %s", bad[i].text);
    }
    static const char with_nul[] = A_FILE("a") "\0";
    hdr_shot shot;
    CHECK(hdr_shot_read(with_nul, sizeof with_nul - 1, &shot, NULL) == HDR_BAD_DATA, "a NUL is taken");
    /* brackets without end */
    char *deep = malloc(1 << 20);
    memset(deep, '[', 1 << 20);
    memcpy(deep, "{\"x\":", 5);
    CHECK(hdr_shot_read(deep, 1 << 20, &shot, NULL) == HDR_BAD_DATA, "a million brackets are taken");
    free(deep);
}

/* Cut off anywhere, it is refused; changed anywhere, it is refused or gives facts that can be. */
static void test_damaged_json(void) {
    static const char whole[] = A_FILE("a") A_FILE("b\\\"\\u00e4") ALL("2");
    size_t size = sizeof whole - 1, first = strlen(A_FILE("a")), taken = 0;
    hdr_shot shot;
    for (size_t length = 0; length < size; length++) {
        char *part = malloc(length + 1); /* so that a sanitizer sees a byte too far */
        memcpy(part, whole, length);
        bool good = length == first || length == first - 1 || length == size - 1;
        CHECK((hdr_shot_read(part, length, &shot, NULL) == HDR_OK) == good, "%zu of %zu bytes", length, size);
        free(part);
    }
    for (int i = 0; i < 200000; i++) {
        char *text = malloc(size);
        memcpy(text, whole, size);
        size_t length = random_bits() % 8 ? size : random_bits() % size;
        for (uint64_t changes = 1 + random_bits() % 3; changes > 0; changes--) {
            size_t at = random_bits() % size;
            static const char telling[] = "{}[]\":,-+.eE0123456789ntf\\u \n";
            text[at] = random_bits() % 2 ? telling[random_bits() % (sizeof telling - 1)] : (char)random_bits();
        }
        hdr_error error = {0};
        hdr_status status = hdr_shot_read(text, length, &shot, &error);
        CHECK((status == HDR_OK && shot.given && !hdr_shot_fault(&shot)) ||
                  (status == HDR_BAD_DATA && !shot.given && error.message[0]),
              "damage %d: status %d", i, (int)status);
        taken += status == HDR_OK;
        free(text);
    }
    CHECK(taken > 0, "no damaged text was taken, not even with another name of a file");
}

/* ---- A survey ---- */

enum { PICTURES = 3, WIDTH = 1100, HEIGHT = 70 }; /* strips and blocks, and no whole number of either */

typedef struct picture {
    int width, height, planes;
    float *plane[3], *repaired[3];
} picture;

/* What is wrong in a picture, beside ordinary values. */
static float value_for(int number, size_t i) {
    uint64_t kind = random_bits() % 50;
    if (number == 1 && i == WIDTH * HEIGHT / 2) return INFINITY; /* met late: the sweep begins again */
    if (number != 1 && kind < 3) return kind == 0 ? NAN : kind == 1 ? -INFINITY : INFINITY;
    if (kind == 3) return 0;
    if (kind == 4) return -(float)random_unit();
    return (float)pow(10, random_unit() * 6 - 3 - number); /* each darker than the one before */
}

static picture make_picture(int number) {
    picture made = {.width = WIDTH - 17 * number, .height = HEIGHT - number, .planes = number == 2 ? 3 : 1};
    size_t pixels = (size_t)made.width * (size_t)made.height;
    for (int p = 0; p < made.planes; p++) {
        float largest = 0;
        made.plane[p] = malloc(pixels * sizeof(float));
        made.repaired[p] = malloc(pixels * sizeof(float));
        for (size_t i = 0; i < pixels; i++) {
            made.plane[p][i] = value_for(number, i);
            if (isfinite(made.plane[p][i])) largest = fmaxf(largest, made.plane[p][i]);
        }
        for (size_t i = 0; i < pixels; i++) {
            float value = made.plane[p][i];
            made.repaired[p][i] = isfinite(value) ? value : value > 0 ? largest : 0;
        }
    }
    return made;
}

static void free_picture(picture *made) {
    for (int p = 0; p < 3; p++) {
        free(made->plane[p]);
        free(made->repaired[p]);
    }
}

static hdr_input *open_picture(const picture *from, hdr_error *error) {
    return hdr_input_planes(from->width, from->height, from->planes, (const float *const *)from->plane, NULL, error);
}

/* What all pictures are together, by SPEC's words. */
typedef struct expected {
    float *lit; /* luminances, sorted */
    uint64_t pixels, lit_count, nan, positive_infinity, negative_infinity;
    double min, max, min_lit;
    long double log_sum;
} expected;

static int compare_floats(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static void expect_pixel(expected *all, const picture *from, size_t i) {
    double y = (double)from->repaired[0][i];
    if (from->planes == 3)
        y = 0.2126 * y + 0.7152 * (double)from->repaired[1][i] + 0.0722 * (double)from->repaired[2][i];
    all->pixels++;
    all->min = fmin(all->min, y);
    all->max = fmax(all->max, y);
    if (y > 0) {
        all->min_lit = fmin(all->min_lit, y);
        all->log_sum += logl((long double)y);
        all->lit[all->lit_count++] = fmaxf((float)y, 0x1p-149f);
    }
    for (int p = 0; p < from->planes; p++) {
        float value = from->plane[p][i];
        all->nan += isnan(value);
        all->positive_infinity += isinf(value) && value > 0;
        all->negative_infinity += isinf(value) && value < 0;
    }
}

static expected expect(const picture pictures[], int count) {
    expected all = {.min = INFINITY, .max = -INFINITY, .min_lit = INFINITY};
    all.lit = malloc((size_t)count * WIDTH * HEIGHT * sizeof(float));
    for (int n = 0; n < count; n++)
        for (size_t i = 0; i < (size_t)pictures[n].width * (size_t)pictures[n].height; i++)
            expect_pixel(&all, &pictures[n], i);
    qsort(all.lit, all.lit_count, sizeof(float), compare_floats);
    return all;
}

static void check_stats(const char *name, const hdr_stats *stats, const expected *all) {
    static const unsigned per_mille[HDR_PERCENTILES] = {1, 10, 50, 250, 500, 750, 950, 990, 999};
    CHECK(stats->pixels == all->pixels && stats->lit == all->lit_count, "%s: %llu pixels, %llu lit", name,
          (unsigned long long)stats->pixels, (unsigned long long)stats->lit);
    CHECK(stats->nan == all->nan && stats->positive_infinity == all->positive_infinity &&
              stats->negative_infinity == all->negative_infinity,
          "%s: repairs are counted wrongly", name);
    CHECK(stats->min_luminance == all->min && stats->max_luminance == all->max && stats->min_lit == all->min_lit,
          "%s: Y from %.17g to %.17g, lit from %.17g", name, stats->min_luminance, stats->max_luminance,
          stats->min_lit);
    double average = (double)expl(all->log_sum / (long double)all->lit_count);
    CHECK(fabs(stats->log_average / average - 1) < 1e-14, "%s: log-average %.17g, not %.17g", name, stats->log_average,
          average);
    for (int i = 0; i < HDR_PERCENTILES; i++) {
        uint64_t rank = (all->lit_count * per_mille[i] + 999) / 1000;
        double wanted = (double)all->lit[(rank ? rank : 1) - 1];
        CHECK(stats->percentile[i] == wanted && stats->percentile_percent[i] == per_mille[i] / 10.0,
              "%s: percentile %g is %.9g, not %.9g", name, stats->percentile_percent[i], stats->percentile[i], wanted);
    }
}

static void count_notes(void *context, hdr_message kind, const char *line) {
    (void)line;
    *(int *)context += kind == HDR_NOTE;
}

/* The facts of pictures together, taken with these words. each: of every single one. */
static hdr_status survey(const picture pictures[], int count, const char *words, hdr_stats *each, hdr_stats *together,
                         int *notes) {
    const char *word[] = {"stats", words};
    hdr_error error = {0};
    hdr_listener listener = {count_notes, notes};
    hdr_chain *chain = hdr_chain_new(&error);
    hdr_chain_add(chain, word, 2, &error);
    hdr_survey *of = hdr_survey_new(chain, &error);
    bool first = true, more = true;
    *notes = 0;
    for (; !error.status && more; first = false) {
        for (int i = 0; i < count; i++) {
            int n = first ? i : count - 1 - i; /* the order of later rounds does not matter */
            hdr_input *input = open_picture(&pictures[n], &error);
            hdr_survey_take(of, input, first ? &each[n] : NULL, &listener, &error);
            hdr_input_free(input);
        }
        more = hdr_survey_next(of, together, &error);
    }
    CHECK(error.status == HDR_OK, "%s: %s", words, error.message);
    hdr_survey_free(of);
    hdr_chain_free(chain);
    return error.status;
}

static void test_survey(void) {
    static const char *const settings[] = {"-j1", "-j3", "-j16", "--memory=1M", "--reference", "--no-skip"};
    picture pictures[PICTURES];
    for (int n = 0; n < PICTURES; n++)
        pictures[n] = make_picture(n);
    expected all = expect(pictures, PICTURES);
    hdr_stats first = {.pixels = 0};
    for (size_t s = 0; s < sizeof settings / sizeof *settings; s++) {
        hdr_stats each[PICTURES], together;
        int notes;
        if (survey(pictures, PICTURES, settings[s], each, &together, &notes)) continue;
        check_stats(settings[s], &together, &all);
        CHECK(notes == PICTURES, "%s: %d notes about three pictures to be repaired", settings[s], notes);
        CHECK(!together.grey && together.opaque, "%s: one picture has colour, none an alpha", settings[s]);
        if (s == 0) first = together;
        CHECK(together.log_average == first.log_average, "%s: another log-average", settings[s]);
        for (int n = 0; n < PICTURES; n++) {
            expected own = expect(&pictures[n], 1);
            check_stats("one of three", &each[n], &own);
            CHECK(each[n].grey == (n < 2), "picture %d: grey or not", n);
            free(own.lit);
        }
    }
    hdr_stats one, together;
    int notes;
    if (!survey(pictures, 1, "-j2", &one, &together, &notes))
        CHECK(one.log_average == together.log_average &&
                  !memcmp(one.percentile, together.percentile, sizeof one.percentile),
              "a survey of one picture has that picture's facts");
    free(all.lit);
    for (int n = 0; n < PICTURES; n++)
        free_picture(&pictures[n]);
}

/* A second round that is not the first again, though no picture fails. */
static void test_other_rounds(void) {
    picture pictures[2] = {make_picture(0), make_picture(1)};
    for (int less = 0; less < 2; less++) {
        hdr_error error = {0};
        hdr_stats together;
        hdr_chain *chain = hdr_chain_new(&error);
        hdr_survey *of = hdr_survey_new(chain, &error);
        for (int round = 0; round < 2; round++) {
            for (int i = 0; i < 2 + (round == 0 ? 0 : less ? -1 : 1); i++) {
                hdr_input *input = open_picture(&pictures[i % 2], &error);
                hdr_survey_take(of, input, NULL, NULL, &error);
                hdr_input_free(input);
            }
            CHECK(hdr_survey_next(of, &together, &error) == (round == 0), "round %d: another is needed or not", round);
        }
        CHECK(error.status == HDR_BAD_DATA, "a second round of %s pictures is taken", less ? "fewer" : "more");
        hdr_survey_free(of);
        hdr_chain_free(chain);
    }
    for (int n = 0; n < 2; n++)
        free_picture(&pictures[n]);
}

/* No facts of all where one is missing, or is not what it was. */
static void test_failing_survey(void) {
    picture good = make_picture(0), other = make_picture(0);
    hdr_stats together = {.pixels = 12345};
    for (int changed = 0; changed < 2; changed++) {
        hdr_error error = {0}, fault = {0};
        hdr_chain *chain = hdr_chain_new(&error);
        hdr_survey *of = hdr_survey_new(chain, &error);
        hdr_input *input = open_picture(&good, &error);
        hdr_input *bad = changed ? open_picture(&other, &error) : hdr_input_memory("no picture", 10, "text", &error);
        hdr_status status = hdr_survey_take(of, input, NULL, NULL, &error);
        CHECK(status == HDR_OK, "%s", error.message);
        if (changed) {
            CHECK(hdr_survey_next(of, &together, &error), "a second round is needed");
            for (int i = 0; i < WIDTH * HEIGHT; i++)
                other.plane[0][i] = -1;
        }
        status = hdr_survey_take(of, bad, NULL, NULL, &fault);
        CHECK(status == (changed ? HDR_OK : HDR_BAD_DATA), "status %d: %s", (int)status, fault.message);
        while (hdr_survey_next(of, &together, &error))
            ;
        CHECK(error.status == HDR_BAD_DATA && strstr(error.message, changed ? "changed" : "missing") &&
                  together.pixels == 12345,
              "a survey that failed: %s", error.message);
        hdr_input_free(input);
        hdr_input_free(bad);
        hdr_survey_free(of);
        hdr_chain_free(chain);
    }
    free_picture(&good);
    free_picture(&other);
}

int main(void) {
    test_round_trips();
    test_bad_texts();
    test_requests();
    test_good_json();
    test_bad_json();
    test_damaged_json();
    test_survey();
    test_other_rounds();
    test_failing_survey();
    return check_done("test_shot");
}

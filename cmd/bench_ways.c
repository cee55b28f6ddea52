/* hdr bench: the ways in which a chain can be computed. */
#include "bench.h"

#include <string.h>

/* What is set of a method besides its name, from the cheapest to the dearest. A method that is not here, or whose
 * option the verb lacks, is one way. */
static const struct setting {
    const char *verb, *method, *option; /* as it is typed */
    const char *values[10];
} settings[] = {{"durand", "grid", "--cells", {"2x2", "2x4", "3x4", "3x5", "3x6", "4x6", "4x7", "6x8"}},
                {"durand", "direct", "--tolerance", {"0.1", "0.01", "0.001", "0.0001"}},
                {"durand", "piecewise", "--subsample", {"25", "16", "8", "4", "2", "1"}}};
#define SETTINGS (sizeof settings / sizeof *settings)

/* What a verb computes around its pixels. */
static const struct surround {
    const char *verb, *what, *unit;
} surrounds[] = {{"durand", "the base layer", "in log10 units"}};

/* The option of that name, with or without its dashes. */
static const hdr_option *option_of(const hdr_verb_about *verb, const char *name) {
    name += strspn(name, "-");
    for (const hdr_option *option = verb->options; option && option->name; option++)
        if (strcmp(option->name, name) == 0) return option;
    return NULL;
}

static bool has_word(const hdr_option *option, const char *word) {
    for (int i = 0; option && option->words && option->words[i]; i++)
        if (strcmp(option->words[i], word) == 0) return true;
    return false;
}

int bench_varied_clause(const hdr_chain *chain) {
    int varied = 0;
    const hdr_verb_about *verb;
    for (int i = 1; (verb = hdr_chain_clause(chain, i)) != NULL; i++)
        if (has_word(option_of(verb, "method"), bench_exact)) varied = i;
    return varied;
}

void bench_describe_surround(bench *b) {
    b->what = "the surround";
    b->unit = "in its unit";
    for (size_t i = 0; i < sizeof surrounds / sizeof *surrounds; i++) {
        if (strcmp(surrounds[i].verb, b->verb) != 0) continue;
        b->what = surrounds[i].what;
        b->unit = surrounds[i].unit;
    }
}

hdr_status bench_check_given(const hdr_chain *chain, int clause, hdr_error *error) {
    const hdr_verb_about *verb = hdr_chain_clause(chain, clause);
    const char *taken = hdr_chain_given(chain, clause, "method") ? "method" : NULL;
    for (size_t i = 0; i < SETTINGS; i++)
        if (strcmp(settings[i].verb, verb->name) == 0 && hdr_chain_given(chain, clause, settings[i].option + 2))
            taken = settings[i].option + 2;
    return taken ? cmd_refuse(error, "bench: it sets --%s of %s itself: leave that out", taken, verb->name) : HDR_OK;
}

static int add_way(bench_way *ways, int count, const char *method, const char *option, const char *value) {
    if (count == BENCH_WAYS) return count;
    ways[count] = (bench_way){.method = method,
                              .option = option,
                              .value = value,
                              .words = {"--method", method, option, value},
                              .word_count = option ? 4 : 2,
                              .own = -1,
                              .bound = -1,
                              .pixels_off = -1};
    return count + 1;
}

static int add_method(bench_way *ways, int count, const hdr_verb_about *verb, const char *method) {
    for (size_t i = 0; i < SETTINGS; i++) {
        const struct setting *s = &settings[i];
        if (strcmp(s->verb, verb->name) != 0 || strcmp(s->method, method) != 0 || !option_of(verb, s->option)) continue;
        for (int v = 0; s->values[v]; v++)
            count = add_way(ways, count, method, s->option, s->values[v]);
        return count;
    }
    return add_way(ways, count, method, NULL, NULL);
}

int bench_ways_of(const hdr_verb_about *verb, bench_way ways[BENCH_WAYS]) {
    const char *const *method = option_of(verb, "method")->words;
    int count = add_method(ways, 0, verb, bench_exact);
    for (; *method; method++)
        if (strcmp(*method, "auto") != 0 && strcmp(*method, bench_exact) != 0)
            count = add_method(ways, count, verb, *method);
    return count;
}

bench_way bench_automatic_way(void) {
    bench_way way;
    add_way(&way, 0, "auto", NULL, NULL);
    return way;
}

int bench_plain_ways(bench_way ways[BENCH_WAYS]) {
    static const char *const names[] = {"reference", "fast"};
    for (int i = 0; i < 2; i++)
        ways[i] = (bench_way){.method = names[i],
                              .words = {"--reference"},
                              .word_count = i == 0 ? 1 : 0,
                              .own = -1,
                              .bound = -1,
                              .pixels_off = -1};
    return 2;
}

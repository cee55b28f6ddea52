/* Words to chain. The same code reads a command line and the lines of a pipe's head. */
#include "chain/chain.h"
#include "chain/shot.h"

#include <float.h>
#include <sched.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const windows[] = {"display", "data", NULL};
static const char *const primaries[] = {"rec709", "keep", NULL};
static const char *const adaptations[] = {"bradford", "none", NULL};
static const char *const automatic[] = {"auto", NULL};

#define COMMON(member) offsetof(hdr_common, member)

static const hdr_option common_options[] = {
    {.name = "output",
     .letter = 'o',
     .type = HDR_OPTION_TEXT,
     .offset = COMMON(output),
     .metavar = "OUT",
     .help = "write to this file; the format follows its ending (.png .exr .pfm .hdr .pfs); - is standard output"},
    {.name = "threads",
     .letter = 'j',
     .type = HDR_OPTION_INTEGER,
     .offset = COMMON(threads),
     .metavar = "N",
     .min = 1,
     .max = 1024,
     .words = automatic,
     .default_value = "auto",
     .help = "threads; auto is HDR_THREADS, else the cores this process may use"},
    {.name = "part",
     .type = HDR_OPTION_TEXT,
     .offset = COMMON(part),
     .metavar = "PART",
     .help = "read this part of a multi-part file: its number, from 0, or its name",
     .travels = true},
    {.name = "layer",
     .type = HDR_OPTION_TEXT,
     .offset = COMMON(layer),
     .metavar = "NAME",
     .help = "read this layer or view (diffuse, left) instead of the unnamed one",
     .travels = true},
    {.name = "channel",
     .type = HDR_OPTION_TEXT,
     .offset = COMMON(channel),
     .metavar = "NAME",
     .help = "read this single channel, of any type, as grey",
     .travels = true},
    {.name = "level",
     .type = HDR_OPTION_TEXT,
     .offset = COMMON(level),
     .metavar = "LEVEL",
     .default_value = "0",
     .help = "read level N of a mip map, or with proxy:PIXELS the smallest whose larger side has that many pixels",
     .travels = true},
    {.name = "crop",
     .type = HDR_OPTION_TEXT,
     .offset = COMMON(crop),
     .metavar = "X,Y,W,H",
     .help = "make this rectangle of the display window's coordinates the picture, as if the file held no more",
     .travels = true},
    {.name = "window",
     .type = HDR_OPTION_CHOICE,
     .offset = COMMON(window),
     .metavar = "WHICH",
     .words = windows,
     .default_value = "display",
     .help = "the window of the picture that is written",
     .travels = true},
    {.name = "alpha",
     .type = HDR_OPTION_TEXT,
     .offset = COMMON(alpha_text),
     .metavar = "HOW",
     .default_value = "keep",
     .help = "keep alpha; drop it, colour as stored; or over:R,G,B: lay the picture over a linear colour",
     .travels = true},
    {.name = "primaries",
     .type = HDR_OPTION_CHOICE,
     .offset = COMMON(primaries),
     .metavar = "WHICH",
     .words = primaries,
     .default_value = "rec709",
     .help = "convert to these before encoding, or keep the file's",
     .travels = true},
    {.name = "adapt",
     .type = HDR_OPTION_CHOICE,
     .offset = COMMON(adapt),
     .metavar = "HOW",
     .words = adaptations,
     .default_value = "bradford",
     .help = "how white is adapted when primaries are converted",
     .travels = true},
    {.name = "memory",
     .type = HDR_OPTION_SIZE,
     .offset = COMMON(memory),
     .metavar = "BYTES",
     .min = 1 << 20,
     .max = 0x1p62,
     .words = automatic,
     .default_value = "auto",
     .help = "memory that pixels may be held in; auto is half of the machine's"},
    {.name = "reference",
     .type = HDR_OPTION_FLAG,
     .offset = COMMON(reference),
     .travels = true,
     .help = "evaluate everything in double precision, value by value: slow, the oracle"},
    {.name = "no-skip",
     .type = HDR_OPTION_FLAG,
     .offset = COMMON(no_skip),
     .travels = true,
     .help = "do what could be skipped"},
    {.name = "strict",
     .type = HDR_OPTION_FLAG,
     .offset = COMMON(strict),
     .travels = true,
     .help = "any NaN or infinity in the picture is an error"},
    {.name = "explain",
     .type = HDR_OPTION_FLAG,
     .offset = COMMON(explain),
     .help = "tell the plan on standard error: sweeps, constants, and what was skipped and why"},
    {.name = "json", .type = HDR_OPTION_FLAG, .offset = COMMON(json), .help = "print JSON, where the verb prints"},
    {.name = "quiet", .letter = 'q', .type = HDR_OPTION_FLAG, .offset = COMMON(quiet), .help = "no notes, only errors"},
    {.name = "verbose",
     .letter = 'v',
     .type = HDR_OPTION_FLAG,
     .offset = COMMON(verbose),
     .help = "tell sizes and times"},
    {.name = "help", .letter = 'h', .type = HDR_OPTION_FLAG, .offset = COMMON(help), .help = "print this help"},
    {.name = "version", .letter = 'V', .type = HDR_OPTION_FLAG, .offset = COMMON(version), .help = "print the version"},
    {0}};

const hdr_option *hdr_common_options(void) {
    return common_options;
}

void hdr_say(const hdr_listener *listener, hdr_message kind, const char *format, ...) {
    if (!listener || !listener->say) return;
    char line[1000];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    listener->say(listener->context, kind, line);
}

/* ---- The chain ---- */

hdr_chain *hdr_chain_new(hdr_error *err) {
    hdr_chain *chain = hdr_alloc(1, sizeof *chain);
    const char **files = hdr_alloc(1, sizeof *files);
    if (!chain || !files) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        free(chain);
        free(files);
        return NULL;
    }
    chain->files = files;
    hdr_options_default(common_options, &chain->common);
    return chain;
}

void hdr_chain_free(hdr_chain *chain) {
    if (!chain) return;
    for (int i = -1; i < chain->count; i++) {
        hdr_clause *clause = i < 0 ? &chain->leader : &chain->clauses[i];
        hdr_options_free(&clause->given);
        free(clause->params);
    }
    free(chain->clauses);
    hdr_options_free(&chain->common_given);
    free(chain->files);
    free(chain);
}

static int available_cores(void) {
    cpu_set_t set;
    int cores = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return cores < 1 ? 1 : cores > 1024 ? 1024 : cores;
}

/* HDR_THREADS, where it is set, as -j would take it. */
static hdr_status environment_threads(hdr_number *threads, hdr_error *err) {
    const char *text = getenv("HDR_THREADS");
    hdr_common common = {.threads = {.word = 0}};
    hdr_options given = {0};
    hdr_status status =
        text ? hdr_option_set(hdr_option_find(common_options, "threads"), text, &common, &given, err) : HDR_OK;
    hdr_options_free(&given);
    *threads = common.threads;
    return status;
}

/* The environment is checked like the command line: a wrong word there is not to be passed over in silence. */
static hdr_status check_environment(hdr_error *err) {
    hdr_number threads;
    hdr_error own = {0};
    const char *cpu = getenv("HDR_CPU");
    bool known = !cpu;
    for (int level = HDR_CPU_C; cpu && level <= HDR_CPU_AVX512; level++)
        known |= !strcmp(cpu, hdr_cpu_name((hdr_cpu_level)level));
    if (!known) return hdr_fail(err, HDR_USAGE, "HDR_CPU is '%.40s': it may be c, sse2, avx2 or avx512", cpu);
    if (environment_threads(&threads, &own)) return hdr_fail(err, HDR_USAGE, "HDR_THREADS: %s", own.message);
    return HDR_OK;
}

/* -j, else HDR_THREADS, else the cores. */
static int thread_count(const hdr_chain *chain) {
    hdr_number threads = chain->common.threads;
    if (threads.word >= 0 && environment_threads(&threads, NULL)) return chain->machine_cores;
    return threads.word < 0 ? (int)threads.value : chain->machine_cores;
}

const hdr_settings *hdr_chain_settings(const hdr_chain *chain) {
    const hdr_common *common = &chain->common;
    hdr_chain *own = (hdr_chain *)chain; /* settings are a view of common, brought up to date when they are asked for */
    hdr_settings *settings = &own->settings;
    if (!chain->machine_cores) own->machine_cores = available_cores();
    if (!chain->machine_memory) own->machine_memory = hdr_memory_default();
    *settings =
        (hdr_settings){.threads = thread_count(chain),
                       .output = common->output,
                       .quiet = common->quiet,
                       .verbose = common->verbose,
                       .explain = common->explain,
                       .json = common->json,
                       .help = common->help,
                       .version = common->version,
                       .reference = common->reference,
                       .no_skip = common->no_skip,
                       .strict = common->strict,
                       .memory = common->memory.word < 0 ? (uint64_t)common->memory.value : chain->machine_memory};
    return settings;
}

const char *const *hdr_chain_files(const hdr_chain *chain) {
    return chain->files;
}

const hdr_verb_about *hdr_chain_leader(const hdr_chain *chain) {
    return chain->leader.verb ? &chain->leader.verb->about : NULL;
}

const hdr_verb_about *hdr_chain_clause(const hdr_chain *chain, int number) {
    return number >= 1 && number <= chain->count ? &chain->clauses[number - 1].verb->about : NULL;
}

const char *hdr_chain_given(const hdr_chain *chain, int number, const char *name) {
    bool there = number == 0 || hdr_chain_clause(chain, number);
    const hdr_clause *clause = number == 0 ? &chain->leader : &chain->clauses[number - 1];
    for (int i = 0; there && i < clause->given.count; i++) {
        const hdr_given *given = &clause->given.given[i];
        if (!strcmp(given->option->name, name)) return given->text ? given->text : "";
    }
    return NULL;
}

bool hdr_chain_joins(const hdr_chain *chain) {
    return chain->count > 0 && chain->clauses[0].verb->join;
}

const hdr_verb_about *hdr_chain_last(const hdr_chain *chain) {
    return chain->count ? hdr_chain_clause(chain, chain->count) : hdr_chain_leader(chain);
}

/* ---- Words ---- */

/* Where words are read from, one by one. */
typedef struct words {
    const char *const *word;
    int count, next;
    bool may_open; /* they are the user's own: a value may name a file that is read */
} words;

/* With the option's own help line. */
static hdr_status refuse_option(const hdr_option *option, const char *why, hdr_error *err) {
    char line[400];
    hdr_option_describe(option, line, sizeof line);
    return hdr_fail(err, HDR_USAGE, "--%s: %s\n%s", option->name, why, line);
}

/* R,G,B: three numbers that fit a float. */
static bool read_colour(const char *text, double colour[3]) {
    static const hdr_option component = {
        .name = "component", .type = HDR_OPTION_NUMBER, .min = -(double)FLT_MAX, .max = (double)FLT_MAX};
    char piece[64];
    for (int i = 0; i < 3; i++) {
        size_t length = strcspn(text, ",");
        hdr_number number = {.word = -1};
        hdr_options given = {0};
        if (length >= sizeof piece || (text[length] == ',') != (i < 2)) return false;
        memcpy(piece, text, length);
        piece[length] = '\0';
        hdr_status status = hdr_option_set(&component, piece, &number, &given, NULL);
        hdr_options_free(&given);
        if (status) return false;
        colour[i] = number.value;
        text += length + (i < 2);
    }
    return true;
}

static hdr_status read_alpha(const hdr_option *option, const char *text, hdr_alpha *alpha, hdr_error *err) {
    static const char over[] = "over:";
    *alpha = (hdr_alpha){.how = HDR_ALPHA_KEEP};
    if (!strcmp(text, "keep")) return HDR_OK;
    alpha->how = HDR_ALPHA_DROP;
    if (!strcmp(text, "drop")) return HDR_OK;
    alpha->how = HDR_ALPHA_OVER;
    if (!strncmp(text, over, strlen(over)) && read_colour(text + strlen(over), alpha->colour)) return HDR_OK;
    return refuse_option(option, "its value is keep, drop or over:R,G,B with three numbers", err);
}

static hdr_status set_common(hdr_chain *chain, const hdr_option *option, const char *text, hdr_error *err) {
    hdr_status status = hdr_option_set(option, text, &chain->common, &chain->common_given, err);
    const char *fault = status ? NULL : hdr_common_fault(&chain->common, option);
    if (!status && fault) return refuse_option(option, fault, err);
    if (!status && option->offset == COMMON(alpha_text)) status = read_alpha(option, text, &chain->common.alpha, err);
    return status;
}

/* Facts of a shot by the name of their file: from here on they are the numbers that it holds. */
static hdr_status set_facts(hdr_clause *clause, const hdr_option *option, const char *name, hdr_error *err) {
    if (!*name || !strcmp(name, "-")) return refuse_option(option, "a file has to be named", err);
    hdr_shot shot;
    hdr_error own = {0};
    char text[HDR_SHOT_TEXT];
    hdr_status status = hdr_shot_load(name, &shot, &own);
    if (status) return hdr_fail(err, status, "--%s: %s", option->name, own.message);
    hdr_shot_print(&shot, text);
    return hdr_option_set(option, text, clause->params, &clause->given, err);
}

/* own: the option of the clause's table, else that among the common ones. */
static hdr_status set_option(hdr_chain *chain, hdr_clause *clause, const hdr_option *own, const hdr_option *common,
                             const char *text, bool may_open, hdr_error *err) {
    if (!own) return set_common(chain, common, text, err);
    if (own->type == HDR_OPTION_FACTS && may_open && !hdr_shot_is_text(text)) return set_facts(clause, own, text, err);
    return hdr_option_set(own, text, clause->params, &clause->given, err);
}

static hdr_status unknown_option(const hdr_clause *clause, const char *word, hdr_error *err) {
    if (!clause) return hdr_fail(err, HDR_USAGE, "unknown option %.100s", word);
    return hdr_fail(err, HDR_USAGE, "unknown option %.100s; see hdr %s --help", word, clause->verb->about.name);
}

/* The value of an option that takes one: what stands behind it, or the next word. */
static hdr_status option_value(const hdr_option *option, const char *attached, words *from, const char **text,
                               hdr_error *err) {
    *text = attached;
    if (attached) return HDR_OK;
    if (from->next < from->count) {
        *text = from->word[from->next++];
        return HDR_OK;
    }
    return refuse_option(option, "a value is missing", err);
}

/* --name, --name value, --name=value. */
static hdr_status long_option(hdr_chain *chain, hdr_clause *clause, const char *word, words *from, hdr_error *err) {
    char name[64];
    const char *equals = strchr(word, '=');
    size_t length = equals ? (size_t)(equals - word) : strlen(word);
    if (length - 2 >= sizeof name) return unknown_option(clause, word, err);
    memcpy(name, word + 2, length - 2);
    name[length - 2] = '\0';
    const hdr_option *own = clause ? hdr_option_find(clause->verb->about.options, name) : NULL;
    const hdr_option *common = hdr_option_find(common_options, name);
    const hdr_option *option = own ? own : common;
    if (!option) return unknown_option(clause, word, err);
    const char *text = NULL;
    if (option->type != HDR_OPTION_FLAG) {
        hdr_status status = option_value(option, equals ? equals + 1 : NULL, from, &text, err);
        if (status) return status;
    } else if (equals) {
        return refuse_option(option, "it takes no value", err);
    }
    return set_option(chain, clause, own, common, text, from->may_open, err);
}

/* -g 2.2, -g2.2, -qv. */
static hdr_status short_options(hdr_chain *chain, hdr_clause *clause, const char *word, words *from, hdr_error *err) {
    for (const char *letter = word + 1; *letter; letter++) {
        const hdr_option *own = clause ? hdr_option_letter(clause->verb->about.options, *letter) : NULL;
        const hdr_option *common = hdr_option_letter(common_options, *letter);
        const hdr_option *option = own ? own : common;
        if (!option) return unknown_option(clause, word, err);
        const char *text = NULL;
        bool takes_value = option->type != HDR_OPTION_FLAG;
        hdr_status status =
            takes_value ? option_value(option, letter[1] ? letter + 1 : NULL, from, &text, err) : HDR_OK;
        if (!status) status = set_option(chain, clause, own, common, text, from->may_open, err);
        if (status || takes_value) return status;
    }
    return HDR_OK;
}

static hdr_status add_file(hdr_chain *chain, const char *file, hdr_error *err) {
    const char **files = hdr_grow(chain->files, (size_t)chain->file_count + 2, sizeof *files);
    if (!files) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    files[chain->file_count++] = file;
    files[chain->file_count] = NULL;
    chain->files = files;
    return HDR_OK;
}

/* A new clause at the end, with its defaults. */
static hdr_status open_clause(hdr_chain *chain, const char *name, hdr_clause **clause, hdr_error *err) {
    const hdr_verb *verb = hdr_verb_find(name);
    if (!verb && name[0] == '-')
        return hdr_fail(err, HDR_USAGE, "a verb is missing before '%.100s': options come after it", name);
    if (!verb && chain->leader.verb && !chain->count)
        return hdr_fail(err, HDR_USAGE, "'%.100s' is no verb: hdr %s VERB [OPTION...] FILE", name,
                        chain->leader.verb->about.name);
    if (!verb) return hdr_fail(err, HDR_USAGE, "unknown verb '%.100s'; hdr --help lists them", name);
    const hdr_verb_about *last = hdr_chain_clause(chain, chain->count);
    if (verb->about.leads && hdr_chain_last(chain))
        return hdr_fail(err, HDR_USAGE, "%s stands in front of a chain: hdr %s VERB ...", name, name);
    if (last && verb->about.kind == HDR_JOIN)
        return hdr_fail(err, HDR_USAGE, "%s makes one picture of several files: nothing can come before it", name);
    if (last && last->kind != HDR_FILTER && last->kind != HDR_JOIN)
        return hdr_fail(err, HDR_USAGE, "nothing can come after %s, which ends a chain", last->name);
    hdr_clause *clauses = hdr_grow(chain->clauses, (size_t)chain->count + 1, sizeof *clauses);
    if (!clauses) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    chain->clauses = clauses;
    void *params = hdr_alloc(1, verb->params_size);
    if (!params) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    hdr_options_default(verb->about.options, params);
    *clause = verb->about.leads ? &chain->leader : &clauses[chain->count++];
    **clause = (hdr_clause){.verb = verb, .params = params};
    return HDR_OK;
}

/* Facts of a shot that are given must be those that the clause asks for. */
static hdr_status check_shot(const hdr_clause *clause, hdr_error *err) {
    const hdr_shot *shot = hdr_options_shot(clause->verb->about.options, clause->params);
    hdr_request request = {0};
    hdr_facts facts = {0};
    if (shot && clause->verb->needs) clause->verb->needs(clause->params, &request);
    if (shot && !request.facts && !request.percentiles)
        return hdr_fail(err, HDR_USAGE, "--facts has no meaning here: no facts are needed");
    if (shot && !hdr_facts_of_shot(shot, &request, &facts))
        return hdr_fail(err, HDR_USAGE,
                        "--facts holds log-average, maximum and the percentiles 1 and 99 of luminance; "
                        "with these options others are needed");
    return HDR_OK;
}

static hdr_status close_clause(const hdr_clause *clause, hdr_error *err) {
    hdr_status status = clause->verb->check ? clause->verb->check(clause->params, &clause->given, err) : HDR_OK;
    return status ? status : check_shot(clause, err);
}

static bool is_then(const char *word) {
    return !strcmp(word, "then") || !strcmp(word, ":");
}

/* What may stand in a clause besides its verb. */
typedef enum allowed {
    OWN_OPTIONS, /* --name of the verb's own table: a pipe's head, which comes from elsewhere and must not name an
                    output */
    ALL_OPTIONS, /* common ones too, and letters */
    ALL_WORDS    /* and operands */
} allowed;

/* The next word of a clause and what belongs to it. A lone "--" makes operands of the rest: then options becomes false.
 */
static hdr_status read_word(hdr_chain *chain, hdr_clause *clause, words *from, allowed what, bool *options,
                            hdr_error *err) {
    const char *word = from->word[from->next++];
    bool dash = *options && word[0] == '-' && word[1];
    bool is_long = dash && word[1] == '-' && word[2];
    if (what == OWN_OPTIONS) {
        size_t length = is_long ? strcspn(word + 2, "=") : 0;
        char name[64] = "";
        if (length && length < sizeof name) memcpy(name, word + 2, length);
        if (!hdr_option_find(clause->verb->about.options, name))
            return hdr_fail(err, HDR_USAGE, "'%.100s' is none of its options", word);
    }
    if (what == ALL_WORDS && *options && !strcmp(word, "--")) {
        *options = false;
        return HDR_OK;
    }
    if (is_long) return long_option(chain, clause, word, from, err);
    if (dash) return short_options(chain, clause, word, from, err);
    if (what == ALL_WORDS) return add_file(chain, word, err);
    return hdr_fail(err, HDR_USAGE, "'%.100s' is no option", word);
}

/* Options of a program that leads are followed by a verb, all else by a `then`. */
static bool ends_clause(const hdr_clause *clause, const char *word) {
    return clause->verb->about.leads ? word[0] != '-' : is_then(word);
}

/* One clause, up to where the next begins, or the end. */
static hdr_status read_clause(hdr_chain *chain, words *from, allowed what, hdr_error *err) {
    hdr_clause *clause = NULL;
    hdr_error own = {0};
    hdr_status status = open_clause(chain, from->word[from->next++], &clause, err);
    if (status) return status;
    bool options = true;
    while (!status && from->next < from->count &&
           !(options && what == ALL_WORDS && ends_clause(clause, from->word[from->next])))
        status = read_word(chain, clause, from, what, &options, &own);
    if (!status) status = close_clause(clause, &own);
    if (!status) return hdr_chain_spell_out(chain, err);
    hdr_fail_in(&own, clause->verb->about.name);
    return hdr_fail(err, status, "%s", own.message);
}

static hdr_status add_one(hdr_chain *chain, const char *const word[], int count, allowed what, hdr_error *err) {
    words from = {word, count, 0, what != OWN_OPTIONS};
    if (count < 1) return hdr_fail(err, HDR_USAGE, "a clause begins with a verb");
    return read_clause(chain, &from, what, err);
}

hdr_status hdr_chain_add_clause(hdr_chain *chain, const char *const word[], int count, hdr_error *err) {
    return add_one(chain, word, count, OWN_OPTIONS, err);
}

hdr_status hdr_chain_add(hdr_chain *chain, const char *const word[], int count, hdr_error *err) {
    return add_one(chain, word, count, ALL_OPTIONS, err);
}

hdr_status hdr_chain_parse(hdr_chain *chain, int count, const char *const word[], hdr_error *err) {
    words from = {word, count, 0, true};
    if (check_environment(err)) return HDR_USAGE;
    for (;;) {
        if (from.next >= from.count)
            return hdr_fail(err, HDR_USAGE, count ? "a verb is missing after '%s'" : "a verb is missing%s",
                            count ? word[count - 1] : "");
        hdr_status status = read_clause(chain, &from, ALL_WORDS, err);
        if (status) return status;
        bool answered = chain->common.help || chain->common.version; /* without a chain */
        if (from.next >= from.count && (chain->count || answered)) return HDR_OK;
        if (chain->count) from.next++; /* then */
    }
}

/* One option of the head's read line, into `line`, a chain that has nothing else; so twice is refused. */
static hdr_status read_travelling(hdr_chain *line, words *from, hdr_error *err) {
    const char *word = from->word[from->next++];
    char name[64] = "";
    size_t length = strncmp(word, "--", 2) ? 0 : strcspn(word + 2, "=");
    if (length && length < sizeof name) memcpy(name, word + 2, length);
    const hdr_option *option = hdr_option_find(common_options, name);
    if (!option || !option->travels) return hdr_fail(err, HDR_USAGE, "'%.100s' is no reading option", word);
    return long_option(line, NULL, word, from, err);
}

/* Takes over what the line gives. */
static hdr_status merge_reading(hdr_chain *chain, const hdr_options *line, hdr_error *err) {
    for (int i = 0; i < line->count; i++) {
        const hdr_given *now = &line->given[i], *earlier = NULL;
        for (int g = 0; g < chain->common_given.count; g++)
            if (chain->common_given.given[g].option == now->option) earlier = &chain->common_given.given[g];
        if (earlier && now->text && strcmp(earlier->text, now->text))
            return hdr_fail(err, HDR_USAGE, "--%s: one program of the pipe says %s, another %s", now->option->name,
                            earlier->text, now->text);
        if (earlier) continue;
        hdr_status status = set_common(chain, now->option, now->text, err);
        if (status) return status;
    }
    return HDR_OK;
}

hdr_status hdr_chain_add_reading(hdr_chain *chain, const char *const word[], int count, hdr_error *err) {
    words from = {word, count, 0, false};
    hdr_chain *line = hdr_chain_new(err);
    hdr_status status = line ? HDR_OK : HDR_INTERNAL;
    while (!status && from.next < from.count)
        status = read_travelling(line, &from, err);
    if (!status) status = merge_reading(chain, &line->common_given, err);
    hdr_chain_free(line);
    return status;
}

hdr_status hdr_chain_add_local(hdr_chain *whole, const hdr_chain *chain, hdr_error *err) {
    whole->machine_cores = chain->machine_cores;
    whole->machine_memory = chain->machine_memory;
    for (int i = 0; i < chain->common_given.count; i++) {
        const hdr_given *given = &chain->common_given.given[i];
        if (given->option->travels) continue;
        hdr_status status = hdr_option_set(given->option, given->text, &whole->common, &whole->common_given, err);
        if (status) return status;
    }
    return HDR_OK;
}

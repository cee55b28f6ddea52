/* Damaged files, damaged heads and senseless command lines: each gets a status and a sentence, never a crash, a hang,
 * or a picture with NaN in it. Deterministic: case N is the same everywhere.
 *
 *     test_fuzz [COUNT [FIRST [FILE]]]    cases FIRST ... FIRST + COUNT - 1; the bytes of the last one go to FILE first
 */
#include "check.h"
#include "exr_make.h"
#include "hdrpipe.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

enum {
    CASES = 6000,            /* where no COUNT is given */
    SECONDS_A_CASE = 20,     /* more is a hang, even with sanitizers */
    MEMORY_MAX_MB = 1024,    /* of the whole process, without sanitizers */
    SEEDS_MAX = 80,          /* pictures to start from */
    WORDS_MAX = 40,          /* of a command line */
    PIXELS_MAX = 1 << 20,    /* of a display window that is written; a larger one only takes time */
    FILE_MAX_BYTES = 1 << 16 /* of a mutated file */
};

#if defined(__SANITIZE_ADDRESS__)
#define SANITIZED true
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SANITIZED true
#endif
#endif
#ifndef SANITIZED
#define SANITIZED false
#endif

static file_bytes seeds[SEEDS_MAX];
static int seed_count;
static unsigned long case_number;
static const char *keep_name;

/* ---- Choosing ---------------------------------------------------------------------------------------------------- */

static size_t below(uint64_t *random, size_t limit) {
    return (size_t)(random_bits(random) % limit);
}

static bool one_in(uint64_t *random, size_t of) {
    return below(random, of) == 0;
}

#define PICK(random, list) ((list)[below(random, sizeof(list) / sizeof *(list))])

/* ---- Seeds ---------------------------------------------------------------------------------------------------------
 */

static void add_seed(file_bytes file) {
    if (seed_count < SEEDS_MAX && file.size > 0)
        seeds[seed_count++] = file;
    else
        free(file.data);
}

static void add_seed_file(const char *path) {
    file_bytes file = {calloc(1, FILE_MAX_BYTES), 0};
    FILE *stream = fopen(path, "rb");
    CHECK(stream && file.data, "%s cannot be read", path);
    if (stream && file.data) file.size = fread(file.data, 1, FILE_MAX_BYTES, stream);
    if (stream) fclose(stream);
    add_seed(file);
}

/* OpenEXRCore does not write these; hdrpipe does where it has its plug-in. */
static void add_dwa_seed(const char *compression, const char *type) {
    const char *const words[] = {"exr", "-q", "--compression", compression, "--type", type};
    hdr_error error = {.status = HDR_OK};
    hdr_chain *chain = hdr_chain_new(&error);
    hdr_input *input = hdr_input_open("testdata/tiny/alpha.exr", &error);
    hdr_output *output = hdr_output_memory(&error);
    hdr_status status = error.status;
    file_bytes file = {NULL, 0};
    if (status == HDR_OK) status = hdr_chain_add(chain, words, sizeof words / sizeof *words, &error);
    if (status == HDR_OK) status = hdr_chain_run(chain, input, output, NULL, &error);
    const void *bytes = status == HDR_OK ? hdr_output_bytes(output, &file.size) : NULL;
    if (strstr(error.message, "which is not installed"))
        CHECK_SKIP("%s", error.message);
    else
        CHECK(bytes && file.size <= FILE_MAX_BYTES, "a seed of %s: %s", compression, error.message);
    if (bytes && file.size <= FILE_MAX_BYTES) file.data = calloc(1, FILE_MAX_BYTES);
    if (file.data) memcpy(file.data, bytes, file.size);
    hdr_output_free(output);
    hdr_input_free(input);
    hdr_chain_free(chain);
    if (file.data) add_seed(file);
}

static void make_seeds(void) {
    static const char *const files[] = {"testdata/tiny/specials.exr", "testdata/tiny/alpha.exr",
                                        "testdata/tiny/window.exr",   "testdata/tiny/grey.exr",
                                        "testdata/tiny/wide.exr",     "testdata/tiny/black.exr"};
    static const exr_compression_t compressions[] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE, EXR_COMPRESSION_ZIPS,
                                                     EXR_COMPRESSION_ZIP,  EXR_COMPRESSION_PIZ, EXR_COMPRESSION_PXR24,
                                                     EXR_COMPRESSION_B44,  EXR_COMPRESSION_B44A};
    uint64_t random = 1;
    for (size_t i = 0; i < sizeof files / sizeof *files; i++)
        add_seed_file(files[i]);
    for (size_t i = 0; i < sizeof compressions / sizeof *compressions; i++)
        for (int variant = 0; variant < 6; variant++) {
            exr_pixel_type_t type = variant & 1 ? EXR_PIXEL_FLOAT : EXR_PIXEL_HALF;
            recipe r = {.width = 19, .height = 37, .min_x = -3, .min_y = 2, .compression = compressions[i]};
            r.tile = variant / 2 == 1 ? 16 : 0;
            r.upwards = variant / 2 == 2;
            r.noise = variant == 5;
            r.state = variant == 4 ? "srgb" : NULL;
            static const char *const names[] = {"A", "B", "G", "R"};
            for (int c = variant & 1 ? 0 : 1; c < 4; c++) {
                r.channel[r.channels].name = names[c];
                r.channel[r.channels++].type = type;
            }
            file_bytes file;
            CHECK(make_exr(&r, &random, &file), "seed picture %zu.%d cannot be made", i, variant);
            free_recipe(&r);
            add_seed(file);
        }
    for (int variant = 0; variant < 4; variant++)
        add_dwa_seed(variant & 1 ? "dwab" : "dwaa", variant & 2 ? "float" : "half");
}

/* ---- Mutations -----------------------------------------------------------------------------------------------------
 */

static void put_number(file_bytes *file, uint64_t *random, size_t at) {
    static const uint32_t numbers[] = {0,          1,          2,          16,         255,        256,
                                       0x7f,       0x80,       0x7fff,     0x8000,     0xffff,     0x10000,
                                       0x3fffffff, 0x7fffffff, 0x80000000, 0x80000001, 0xfffffffe, 0xffffffff,
                                       0x7f800000, 0xff800000, 0x7fc00000, 0x7c00fc00, 0x20202020, 1000000};
    uint32_t number = one_in(random, 4) ? (uint32_t)below(random, file->size + 8) : PICK(random, numbers);
    size_t size = (size_t)1 << below(random, 4);
    for (size_t i = 0; i < size && at + i < file->size; i++)
        file->data[at + i] = (unsigned char)(i < 4 ? number >> (8 * i) : 0);
}

/* Moves what lies behind a gap, or fills one with bytes from elsewhere in the file. */
static void change_length(file_bytes *file, uint64_t *random, size_t at) {
    size_t length = 1 + below(random, one_in(random, 4) ? 200 : 8);
    if (one_in(random, 2)) {
        if (length > file->size - at) length = file->size - at;
        memmove(file->data + at, file->data + at + length, file->size - at - length);
        file->size -= length;
        return;
    }
    if (file->size + length > FILE_MAX_BYTES) return;
    size_t from = below(random, file->size);
    memmove(file->data + at + length, file->data + at, file->size - at);
    file->size += length;
    for (size_t i = 0; i < length && from + i < file->size; i++)
        file->data[at + i] = file->data[from + i];
}

static void mutate(file_bytes *file, uint64_t *random) {
    for (size_t changes = 1 + below(random, one_in(random, 4) ? 12 : 3); changes > 0 && file->size > 0; changes--) {
        /* many of the changes in what is likely to be the header */
        size_t header = file->size < 400 ? file->size : 400;
        size_t at = one_in(random, 3) ? below(random, header) : below(random, file->size);
        switch (below(random, 6)) {
        case 0:
            file->data[at] ^= (unsigned char)(1u << below(random, 8));
            break;
        case 1:
            file->data[at] = (unsigned char)random_bits(random);
            break;
        case 2:
        case 3:
            put_number(file, random, at);
            break;
        case 4:
            change_length(file, random, at);
            break;
        case 5:
            if (one_in(random, 3)) file->size = at;
            break;
        }
    }
}

static file_bytes copy_of_seed(uint64_t *random) {
    const file_bytes *seed = &seeds[below(random, (size_t)seed_count)];
    file_bytes copy = {calloc(1, FILE_MAX_BYTES), seed->size};
    if (!copy.data) abort();
    memcpy(copy.data, seed->data, seed->size);
    return copy;
}

/* ---- Words ---------------------------------------------------------------------------------------------------------
 */

typedef struct command {
    const char *word[WORDS_MAX];
    char text[WORDS_MAX][200]; /* of the words that are made up */
    int count;
} command;

static void add_word(command *line, const char *word) {
    if (line->count == WORDS_MAX) return;
    char *text = line->text[line->count];
    snprintf(text, sizeof line->text[0], "%s", word);
    line->word[line->count++] = text;
}

/* A value for an option: mostly one that it takes. */
static void value_of(const hdr_option *option, uint64_t *random, char *text, size_t size) {
    static const char *const odd[] = {"",      "nan", "inf", "-1",   "0",   "1e999",   "1e-400",
                                      "0x1p3", " 1",  "1 ",  "1,5",  "--",  "then",    "99999999999999999999",
                                      "-0",    ".",   "1e",  "200M", "%00", "\xff\x01"};
    size_t words = 0;
    while (option->words && option->words[words])
        words++;
    if (one_in(random, 8))
        snprintf(text, size, "%s", PICK(random, odd));
    else if (words > 0 && (option->type == HDR_OPTION_CHOICE || one_in(random, 3)))
        snprintf(text, size, "%s", option->words[below(random, words)]);
    else if (option->default_value && one_in(random, 4))
        snprintf(text, size, "%s", option->default_value);
    else if (option->max > option->min && option->max < 1e6)
        snprintf(text, size, "%.6g", option->min + (option->max - option->min) * (double)below(random, 1001) / 1000);
    else
        snprintf(text, size, "%.6g", (double)below(random, 1000) / 100);
}

/* Facts of a shot by their numbers: any other text would name a file. Mostly such that can be; else one byte behind the
 * first key is another. */
static void facts_of_shot(uint64_t *random, char *text, size_t size) {
    static const char other[] = "=,.-+e019 xp\xff";
    double low = ldexp((double)(1 + below(random, 1000)), (int)below(random, 40) - 30);
    double high = ldexp(low, (int)below(random, 30)), most = ldexp(high, (int)below(random, 4));
    int length =
        snprintf(text, size, "log_average=%.6g,max_luminance=%.9g,p1=%.6g,p99=%.6g", sqrt(low * high), most, low, high);
    size_t at = strlen("log_average=");
    if (one_in(random, 4)) text[at + below(random, (size_t)length - at)] = other[below(random, sizeof other - 1)];
}

static const hdr_option *any_option(const hdr_option *table, uint64_t *random) {
    size_t count = 0;
    while (table && table[count].name)
        count++;
    return count ? &table[below(random, count)] : NULL;
}

static void add_option(command *line, const hdr_option *option, uint64_t *random) {
    static const char *const alphas[] = {"keep", "drop", "over:1,0.5,0", "over:-1,1e30,2", "over:1,2", "over"};
    char name[180], value[120];
    if (!strcmp(option->name, "alpha")) {
        add_word(line, "--alpha");
        add_word(line, alphas[below(random, sizeof alphas / sizeof *alphas)]);
    }
    if (option->type == HDR_OPTION_TEXT) return; /* no file may be written */
    snprintf(name, sizeof name, "--%.40s", option->name);
    if (option->letter && one_in(random, 2)) snprintf(name, sizeof name, "-%c", option->letter);
    if (option->type == HDR_OPTION_FLAG && !one_in(random, 16)) {
        add_word(line, name);
        return;
    }
    if (option->type == HDR_OPTION_FACTS)
        facts_of_shot(random, value, sizeof value);
    else
        value_of(option, random, value, sizeof value);
    size_t length = strlen(name);
    if (one_in(random, 3)) snprintf(name + length, sizeof name - length, "%s%s", name[1] == '-' ? "=" : "", value);
    add_word(line, name);
    if (!name[length]) add_word(line, value);
}

static void add_clause(command *line, const hdr_verb_about *verb, size_t options, uint64_t *random) {
    add_word(line, verb->name);
    for (; options > 0; options--) {
        const hdr_option *option = any_option(one_in(random, 4) ? hdr_common_options() : verb->options, random);
        if (option) add_option(line, option, random);
    }
}

static const hdr_verb_about *any_verb(uint64_t *random, hdr_verb_kind kind) {
    size_t count = 0;
    while (hdr_verb_at((int)count))
        count++;
    for (;;) {
        const hdr_verb_about *verb = hdr_verb_at((int)below(random, count));
        if (verb->kind == kind) return verb;
    }
}

/* A chain in its proper order, though perhaps with options out of range. */
static void sensible_line(command *line, size_t options, uint64_t *random) {
    line->count = 0;
    for (size_t filters = below(random, 4); filters > 0; filters--) {
        add_clause(line, any_verb(random, HDR_FILTER), below(random, options + 1), random);
        add_word(line, one_in(random, 2) ? "then" : ":");
    }
    add_clause(line, any_verb(random, HDR_FORMAT), below(random, options + 1), random);
}

static void senseless_line(command *line, uint64_t *random) {
    static const char *const odd[] = {"then", ":", "--", "-", "", "-Z", "--=", "--no-such", "a.exr", "---", "-q", "-h"};
    sensible_line(line, 3, random);
    for (size_t changes = 1 + below(random, 4); changes > 0; changes--) {
        size_t at = below(random, (size_t)line->count);
        if (one_in(random, 3))
            line->word[at] = PICK(random, odd);
        else
            line->word[at] = line->word[below(random, (size_t)line->count)];
    }
}

/* ---- Running -------------------------------------------------------------------------------------------------------
 */

static void keep(const file_bytes *file, const command *line) {
    if (!keep_name) return;
    FILE *stream = fopen(keep_name, "wb");
    if (!stream) return;
    fwrite(file->data, 1, file->size, stream);
    fclose(stream);
    fprintf(stderr, "case %lu:", case_number);
    for (int i = 0; i < line->count; i++)
        fprintf(stderr, " '%s'", line->word[i]);
    fputc('\n', stderr);
}

/* Words that have come into disorder may name a file where facts of a shot are expected: there is none. */
static bool allowed(hdr_status status, bool usage) {
    return status == HDR_OK || status == HDR_BAD_DATA || (usage && (status == HDR_USAGE || status == HDR_NO_INPUT));
}

static void check_error(hdr_status status, const hdr_error *error, bool usage) {
    CHECK(allowed(status, usage), "case %lu: status %d: %s", case_number, (int)status, error->message);
    CHECK(status == error->status, "case %lu: returns %d, but the record says %d", case_number, (int)status,
          (int)error->status);
    size_t length = strlen(error->message);
    CHECK((status == HDR_OK) == (length == 0), "case %lu: status %d, '%s'", case_number, (int)status, error->message);
    CHECK(length == 0 || error->message[length - 1] != '\n', "case %lu: a newline at the end", case_number);
}

/* No word of a PFM behind its three lines is NaN or infinite. */
static bool all_finite(const unsigned char *bytes, size_t size) {
    int lines = 0;
    size_t at = 0;
    while (at < size && lines < 3)
        lines += bytes[at++] == '\n';
    for (; at + 4 <= size; at += 4) {
        uint32_t word;
        memcpy(&word, bytes + at, 4);
        if ((word & 0x7f800000) == 0x7f800000) return false;
    }
    return true;
}

static void check_result(const hdr_output *output, const char *format) {
    size_t size = 0;
    const unsigned char *bytes = hdr_output_bytes(output, &size);
    CHECK(bytes && size > 8, "case %lu: done, but nothing was written", case_number);
    if (!bytes || size <= 8) return;
    if (!strcmp(format, "png"))
        CHECK(!memcmp(bytes, "\211PNG\r\n\032\n", 8) && !memcmp(bytes + size - 8, "IEND", 4), "case %lu: no whole PNG",
              case_number);
    else if (!strcmp(format, "exr"))
        CHECK(!memcmp(bytes, "\166\057\061\001", 4), "case %lu: no EXR", case_number);
    else if (!strcmp(format, "pfm"))
        CHECK(all_finite(bytes, size), "case %lu: NaN or infinity came out", case_number);
}

static bool display_too_large(const file_bytes *file) {
    hdr_picture picture;
    hdr_input *input = hdr_input_memory(file->data, file->size, "memory", NULL);
    bool large = false;
    if (input && hdr_input_picture(input, NULL, &picture, NULL) == HDR_OK) {
        double width = (double)picture.display.max_x - picture.display.min_x + 1;
        double height = (double)picture.display.max_y - picture.display.min_y + 1;
        large = width * height > PIXELS_MAX;
    }
    hdr_input_free(input);
    return large;
}

/* What a run has to say goes nowhere, but must be lines. */
static void hear(void *context, hdr_message kind, const char *line) {
    (void)context;
    CHECK(kind <= HDR_DETAIL && !strchr(line, '\n'), "case %lu: a note of several lines: %s", case_number, line);
}

/* Runs the line on the file; usage: whether the words may be wrong. The output is the caller's. */
static hdr_status run(const file_bytes *file, const command *line, bool usage, hdr_output **output) {
    static const hdr_listener listener = {hear, NULL};
    hdr_error error = {0};
    hdr_chain *chain = hdr_chain_new(&error);
    hdr_input *input = hdr_input_memory(file->data, file->size, "memory", &error);
    *output = hdr_output_memory(&error);
    if (!chain || !input || !*output) abort();
    hdr_status status = hdr_chain_parse(chain, line->count, line->word, &error);
    CHECK(status == HDR_OK || status == HDR_USAGE || status == HDR_NO_INPUT, "case %lu: parsing gives %d", case_number,
          (int)status);
    bool runs = status == HDR_OK && hdr_chain_last(chain)->kind != HDR_PROGRAM;
    if (runs) status = hdr_chain_run(chain, input, *output, &listener, &error);
    check_error(status, &error, usage);
    if (runs && status == HDR_OK) check_result(*output, hdr_chain_last(chain)->name);
    hdr_input_free(input);
    hdr_chain_free(chain);
    return status;
}

static void run_once(const file_bytes *file, const command *line, bool usage) {
    hdr_output *output;
    (void)run(file, line, usage, &output);
    hdr_output_free(output);
}

/* Another number of threads: the same status, and the same bytes. */
static void compare_threads(const file_bytes *file, command *line) {
    hdr_output *one, *other;
    size_t size, other_size;
    add_word(line, "-j1");
    hdr_status status = run(file, line, false, &one);
    line->count--;
    add_word(line, "-j3");
    hdr_status other_status = run(file, line, false, &other);
    const void *bytes = hdr_output_bytes(one, &size), *other_bytes = hdr_output_bytes(other, &other_size);
    CHECK(status == other_status, "case %lu: %d on one thread, %d on three", case_number, (int)status,
          (int)other_status);
    CHECK(size == other_size && (size == 0 || !memcmp(bytes, other_bytes, size)),
          "case %lu: other bytes on three threads", case_number);
    hdr_output_free(one);
    hdr_output_free(other);
}

/* Facts of a damaged picture. */
static void take_facts(const file_bytes *file) {
    static const char *const words[] = {"stats"};
    hdr_error error = {0};
    hdr_stats stats;
    hdr_chain *chain = hdr_chain_new(&error);
    hdr_input *input = hdr_input_memory(file->data, file->size, "memory", &error);
    hdr_status status = hdr_chain_parse(chain, 1, words, &error);
    if (status == HDR_OK) status = hdr_chain_stats(chain, input, &stats, NULL, &error);
    check_error(status, &error, false);
    if (status == HDR_OK)
        CHECK(stats.lit <= stats.pixels && stats.min_luminance <= stats.max_luminance && stats.log_average >= 0,
              "case %lu: facts that cannot be", case_number);
    hdr_input_free(input);
    hdr_chain_free(chain);
}

/* ---- Cases ---------------------------------------------------------------------------------------------------------
 */

static void damaged_file(uint64_t *random) {
    command line;
    file_bytes file = copy_of_seed(random);
    mutate(&file, random);
    sensible_line(&line, 0, random);
    keep(&file, &line);
    if (display_too_large(&file)) add_word(&line, "--window=data");
    if (one_in(random, 4))
        compare_threads(&file, &line);
    else if (one_in(random, 4))
        take_facts(&file);
    else
        run_once(&file, &line, false);
    free(file.data);
}

/* A second picture that is damaged: of the same bytes as the first, or of what those were before. */
static void damaged_guide(uint64_t *random) {
    const hdr_verb_about *verb = any_verb(random, HDR_GUIDED);
    const hdr_option *named = verb->options;
    char name[80], path[80];
    command line = {.count = 0};
    file_bytes picture = copy_of_seed(random), guide = {calloc(1, FILE_MAX_BYTES), picture.size};
    int descriptor = memfd_create("guide", 0);
    while (named->type != HDR_OPTION_TEXT)
        named++;
    if (!guide.data || descriptor < 0) abort();
    memcpy(guide.data, picture.data, picture.size);
    mutate(&guide, random);
    CHECK(write(descriptor, guide.data, guide.size) == (ssize_t)guide.size, "the guide cannot be written");
    snprintf(name, sizeof name, "--%.40s", named->name);
    snprintf(path, sizeof path, "/proc/self/fd/%d", descriptor);
    add_word(&line, verb->name);
    add_word(&line, name);
    add_word(&line, path);
    add_word(&line, "then");
    add_clause(&line, any_verb(random, HDR_FORMAT), 0, random);
    file_bytes *first = one_in(random, 2) ? &picture : &guide;
    keep(first, &line);
    if (display_too_large(first)) add_word(&line, "--window=data");
    compare_threads(first, &line);
    close(descriptor);
    free(picture.data);
    free(guide.data);
}

/* Puts a chain of filters as a head in front of a picture, and damages mostly the head. */
static void damaged_head(uint64_t *random) {
    static const char *const odd[] = {"read", "read --strict",    "read --window data", "then", "then png", "then x",
                                      "#",    "then log --k=%zz", "then  log",          "%00",  "hdrpipe 1"};
    char text[2000];
    size_t size = (size_t)snprintf(text, sizeof text, "hdrpipe 1\n# note\n");
    command line;
    for (size_t clauses = below(random, 5); clauses > 0; clauses--) {
        line.count = 0;
        add_clause(&line, any_verb(random, HDR_FILTER), below(random, 3), random);
        size += (size_t)snprintf(text + size, sizeof text - size, "then");
        for (int i = 0; i < line.count; i++)
            size += (size_t)snprintf(text + size, sizeof text - size, " %s", line.word[i]);
        size += (size_t)snprintf(text + size, sizeof text - size, "\n");
        if (one_in(random, 6)) size += (size_t)snprintf(text + size, sizeof text - size, "%s\n", PICK(random, odd));
    }
    size += (size_t)snprintf(text + size, sizeof text - size, "\n");
    file_bytes head = {calloc(1, FILE_MAX_BYTES), size}, file = copy_of_seed(random);
    if (!head.data) abort();
    memcpy(head.data, text, size);
    if (one_in(random, 2)) mutate(&head, random);
    if (head.size + file.size > FILE_MAX_BYTES) file.size = FILE_MAX_BYTES - head.size;
    memcpy(head.data + head.size, file.data, file.size);
    head.size += file.size;
    free(file.data);
    line.count = 0;
    add_clause(&line, any_verb(random, HDR_FORMAT), 0, random);
    keep(&head, &line);
    run_once(&head, &line, false);
    free(head.data);
}

static void odd_words(uint64_t *random) {
    command line;
    if (one_in(random, 2))
        sensible_line(&line, 3, random);
    else
        senseless_line(&line, random);
    file_bytes file = copy_of_seed(random);
    keep(&file, &line);
    run_once(&file, &line, true);
    free(file.data);
}

static void run_case(void) {
    uint64_t random = case_number * 0x2545f4914f6cdd1du;
    (void)random_bits(&random);
    alarm(SECONDS_A_CASE);
    size_t kind = below(&random, 8);
    if (kind < 5)
        damaged_file(&random);
    else if (kind < 6)
        damaged_head(&random);
    else if (one_in(&random, 4))
        damaged_guide(&random);
    else
        odd_words(&random);
    alarm(0);
}

/* Tells the case, which is all that is needed to see it again. */
static void on_signal(int number) {
    char text[100];
    int length = snprintf(text, sizeof text, "case %lu: ended by signal %d\n", case_number, number);
    if (write(STDERR_FILENO, text, (size_t)length) != length) _exit(3);
    _exit(2);
}

int main(int count, char **words) {
    static const int fatal[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGALRM};
    unsigned long cases = count > 1 ? strtoul(words[1], NULL, 10) : CASES;
    unsigned long first = count > 2 ? strtoul(words[2], NULL, 10) : 1;
    keep_name = count > 3 ? words[3] : NULL;
    for (size_t i = 0; i < sizeof fatal / sizeof *fatal; i++)
        if (!SANITIZED || fatal[i] == SIGALRM || fatal[i] == SIGABRT) signal(fatal[i], on_signal);
    make_seeds();
    for (case_number = first; case_number < first + cases; case_number++)
        run_case();
    struct rusage usage;
    CHECK(getrusage(RUSAGE_SELF, &usage) == 0 && (SANITIZED || usage.ru_maxrss < MEMORY_MAX_MB * 1024L),
          "%ld KB of memory were used", usage.ru_maxrss);
    for (int i = 0; i < seed_count; i++)
        free(seeds[i].data);
    return check_done("test_fuzz");
}

/* The base room: error records, memory, byte strings, option tables, exact decimals, and the thread pool. */
#include "base/base.h"
#include "base/cpu.h"
#include "base/options.h"
#include "base/pool.h"
#include "check.h"

#include <limits.h>
#include <locale.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* ---- Errors ---- */

static void test_errors(void) {
    hdr_error error = {0};
    CHECK(hdr_fail(&error, HDR_BAD_DATA, "first %d", 1) == HDR_BAD_DATA, "the status comes back");
    CHECK(hdr_fail(&error, HDR_IO, "second") == HDR_IO, "the second status comes back");
    CHECK(error.status == HDR_BAD_DATA && strcmp(error.message, "first 1") == 0, "the first fault is kept, not '%s'",
          error.message);
    CHECK(hdr_fail_in(&error, "gamma") == HDR_BAD_DATA && strcmp(error.message, "gamma: first 1") == 0, "'%s'",
          error.message);
    CHECK(hdr_fail(NULL, HDR_IO, "nobody listens") == HDR_IO, "a NULL record is allowed");

    hdr_error fine = {0};
    CHECK(hdr_fail_in(&fine, "gamma") == HDR_OK && fine.message[0] == '\0', "no fault gets no prefix");

    hdr_error control = {0};
    hdr_fail(&control, HDR_IO, "a\x1b[31mb\tc\nhelp\n");
    CHECK(strcmp(control.message, "a?[31mb?c\nhelp") == 0, "control bytes reach no terminal: '%s'", control.message);

    for (size_t before = 990; before < sizeof error.message; before++) {
        char text[1100];
        memset(text, 'x', before);
        strcpy(text + before, "\xe2\x82\xac\xe2\x82\xac\xe2\x82\xac\xe2\x82\xac");
        hdr_error cut = {0};
        hdr_fail(&cut, HDR_IO, "%s", text);
        size_t length = strlen(cut.message);
        size_t whole = length <= before ? 0 : length - before;
        CHECK(length < sizeof cut.message && whole % 3 == 0, "a long message ends with a whole character (%zu)",
              length);
        hdr_fail_in(&cut, "prefix");
        CHECK(strncmp(cut.message, "prefix: xxx", 11) == 0, "a prefix gets in front of a long message");
    }
}

/* ---- Memory ---- */

static void test_memory(void) {
    volatile size_t most = SIZE_MAX; /* volatile: the compiler would warn about what is tested */
    CHECK(hdr_alloc(most / 2, 3) == NULL, "a product that overflows is refused");
    CHECK(hdr_grow(NULL, most / 4, 5) == NULL, "a product that overflows is refused");
    CHECK(hdr_alloc_pages(most) == NULL, "a size that overflows is refused");

    void *nothing = hdr_grow(hdr_alloc(0, 8), 8, 0);
    CHECK(nothing != NULL, "size 0 gives a pointer");
    free(nothing);

    unsigned char *cleared = hdr_alloc(1000, 3);
    size_t set = 0;
    for (int i = 0; cleared && i < 3000; i++)
        set += cleared[i] != 0;
    CHECK(cleared && set == 0, "hdr_alloc clears");
    free(cleared);

    static const size_t sizes[] = {0, 1, 4096, 65536, 65537, (1 << 21) - 1, 1 << 21, (1 << 21) + 1, 5 << 20};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        unsigned char *pages = hdr_alloc_pages(sizes[i]);
        CHECK(pages != NULL, "%zu bytes of pages", sizes[i]);
        CHECK((uintptr_t)pages % 4096 == 0, "pages are aligned");
        if (pages) memset(pages, 1, sizes[i]);
        hdr_free_pages(pages, sizes[i]);
    }
    CHECK(hdr_memory_default() >= 1 << 20, "the default of --memory is %llu bytes",
          (unsigned long long)hdr_memory_default());
}

static void test_bytes(void) {
    hdr_error error = {0};
    hdr_bytes bytes = {0};
    for (int i = 0; i < 10000; i++) {
        unsigned char byte = (unsigned char)(i * 7);
        hdr_bytes_add(&bytes, &byte, 1, &error);
    }
    size_t wrong = 0;
    for (int i = 0; i < 10000; i++)
        wrong += bytes.data[i] != (unsigned char)(i * 7);
    CHECK(error.status == HDR_OK && bytes.size == 10000 && wrong == 0, "bytes stay as they were added");
    hdr_bytes_add(&bytes, NULL, 0, &error);
    bytes.size = 3;
    hdr_bytes_printf(&bytes, &error, "%s-%d", "number", 42);
    CHECK(bytes.size == 12 && memcmp(bytes.data + 3, "number-42", 9) == 0, "printf appends without its NUL");
    hdr_bytes_reserve(&bytes, 100000, &error);
    CHECK(bytes.room >= 100000 && bytes.size == 12, "reserve adds nothing");
    CHECK(hdr_bytes_add(&bytes, bytes.data, SIZE_MAX - 5, NULL) == HDR_INTERNAL, "a size that overflows is refused");
    CHECK(hdr_bytes_reserve(&bytes, SIZE_MAX / 2 + 1, NULL) == HDR_INTERNAL, "a size that cannot be had is refused");
    CHECK(bytes.size == 12 && memcmp(bytes.data + 3, "number-42", 9) == 0, "a refusal changes nothing");
    free(bytes.data);
}

static void test_cpu(void) {
    hdr_cpu_level level = hdr_cpu();
    const char *held = getenv("HDR_CPU");
    CHECK(level == hdr_cpu(), "the level is decided once");
    for (int i = HDR_CPU_C; held && i <= HDR_CPU_AVX512; i++)
        if (strcmp(held, hdr_cpu_name((hdr_cpu_level)i)) == 0)
            CHECK((int)level <= i, "HDR_CPU=%s holds %s down", held, hdr_cpu_name(level));
}

/* ---- Options ---- */

typedef struct values {
    bool flag;
    hdr_number exponent, shift, key, count, size, store, any;
    hdr_decimal percent;
    int choice;
    const char *text;
} values;

static const char *const key_words[] = {"auto", "inf", NULL};
static const char *const dither_words[] = {"none", "ordered", "blue", NULL};
static const char *const default_words[] = {"default", NULL};
#define AT(field) offsetof(values, field)
static const hdr_option table[] = {
    {"flag", 'f', HDR_OPTION_FLAG, AT(flag), NULL, 0, 0, false, NULL, NULL, "switch it on", false, NULL},
    {"exponent", 'g', HDR_OPTION_NUMBER, AT(exponent), "NUMBER", 0, INFINITY, true, NULL, "2.2",
     "the exponent g of C^(1/g)", false, NULL},
    {"shift", 0, HDR_OPTION_NUMBER, AT(shift), "N", -1, 1, false, NULL, NULL, "how far", false, NULL},
    {"key", 'k', HDR_OPTION_NUMBER, AT(key), "KEY", 0, INFINITY, true, key_words, "auto", "the key", false, NULL},
    {"count", 'j', HDR_OPTION_INTEGER, AT(count), "N", 1, 1024, false, NULL, "4", "how many", false, NULL},
    {"size", 'm', HDR_OPTION_SIZE, AT(size), "BYTES", 1048576, INFINITY, false, default_words, "200M", "how much",
     false, NULL},
    {"any", 0, HDR_OPTION_NUMBER, AT(any), "N", 0, 0, false, NULL, NULL, "anything finite", false, NULL},
    {"percentile", 'p', HDR_OPTION_DECIMAL, AT(percent), "PERCENT", 0, 100, false, NULL, "0.1", "which rank", false,
     NULL},
    {"dither", 0, HDR_OPTION_CHOICE, AT(choice), "KIND", 0, 0, false, dither_words, "none", "the pattern", false, NULL},
    {"gain", 0, HDR_OPTION_NUMBER, AT(any), "N", 0, 8, true, NULL, NULL, "bounded", false, NULL},
    {"store", 0, HDR_OPTION_SIZE, AT(store), "BYTES", 1024, 0x1p62, false, NULL, NULL, "no bound", false, NULL},
    {"layer", 'l', HDR_OPTION_TEXT, AT(text), "NAME", 0, 0, false, NULL, NULL, "which layer", false, NULL},
    {NULL, 0, HDR_OPTION_FLAG, 0, NULL, 0, 0, false, NULL, NULL, NULL, false, NULL}};

/* Sets one option in fresh parameters. */
static hdr_status set(const char *name, const char *text, values *v, hdr_error *error) {
    hdr_options options = {NULL, 0};
    const hdr_option *option = hdr_option_find(table, name);
    *error = (hdr_error){0};
    hdr_options_default(table, v);
    hdr_status status = option ? hdr_option_set(option, text, v, &options, error) : HDR_INTERNAL;
    CHECK(options.count == (status == HDR_OK), "what is refused is not recorded (%s %s)", name, text ? text : "");
    hdr_options_free(&options);
    return status;
}

static void good_number(const char *name, const char *text, hdr_number *at, values *v, int word, double value) {
    hdr_error error;
    hdr_status status = set(name, text, v, &error);
    CHECK(status == HDR_OK && at->word == word && at->value == value, "--%s %s: %d %g (%s)", name, text, at->word,
          at->value, error.message);
}

static void bad_value(const char *name, const char *text, const char *says) {
    values v;
    hdr_error error;
    hdr_status status = set(name, text, &v, &error);
    char line[500];
    hdr_option_describe(hdr_option_find(table, name), line, sizeof line);
    const char *newline = strchr(error.message, '\n');
    CHECK(status == HDR_USAGE && error.status == HDR_USAGE, "--%s %s is refused", name, text ? text : "(none)");
    CHECK(strstr(error.message, says) != NULL, "--%s %s: '%s' says '%s'", name, text ? text : "(none)", error.message,
          says);
    CHECK(newline && strcmp(newline + 1, line) == 0, "the option's help line ends '%s'", error.message);
}

/* Values separated by spaces. */
static void bad_values(const char *name, const char *says, const char *values_text) {
    char copy[200], *rest = NULL;
    snprintf(copy, sizeof copy, "%s", values_text);
    for (char *text = strtok_r(copy, " ", &rest); text; text = strtok_r(NULL, " ", &rest))
        bad_value(name, text, says);
}

static void test_defaults(void) {
    values v;
    memset(&v, 0x11, sizeof v);
    hdr_options_default(table, &v);
    CHECK(!v.flag && v.exponent.word == -1 && v.exponent.value == 2.2, "flag and exponent");
    CHECK(v.key.word == 0 && v.count.value == 4 && v.size.value == 200 * 1048576.0, "key, count and size");
    CHECK(v.percent.digits == 1 && v.percent.places == 1 && v.choice == 0 && v.text == NULL, "the others");
    CHECK(v.any.word == -1 && v.any.value == 0 && v.shift.value == 0, "no default is 0");
    hdr_options_default(NULL, &v);
}

static void test_numbers(void) {
    values v;
    good_number("exponent", "2.4", &v.exponent, &v, -1, 2.4);
    good_number("exponent", "+1e-3", &v.exponent, &v, -1, 1e-3);
    good_number("exponent", "1E+3", &v.exponent, &v, -1, 1000);
    good_number("exponent", ".5", &v.exponent, &v, -1, 0.5);
    good_number("exponent", "5.", &v.exponent, &v, -1, 5);
    good_number("exponent", "1e308", &v.exponent, &v, -1, 1e308);
    good_number("shift", "-1", &v.shift, &v, -1, -1);
    good_number("shift", "1", &v.shift, &v, -1, 1);
    good_number("any", "-1e300", &v.any, &v, -1, -1e300);
    good_number("key", "inf", &v.key, &v, 1, 0);
    good_number("key", "auto", &v.key, &v, 0, 0);
    good_number("key", "0.18", &v.key, &v, -1, 0.18);
    good_number("count", "1024", &v.count, &v, -1, 1024);
    good_number("count", "1e2", &v.count, &v, -1, 100);
    good_number("size", "1M", &v.size, &v, -1, 1048576);
    good_number("size", "1.5g", &v.size, &v, -1, 1.5 * 1073741824.0);
    good_number("size", "2T", &v.size, &v, -1, 2.0 * 1099511627776.0);
    good_number("size", "1048577", &v.size, &v, -1, 1048577);
    good_number("size", "1024K", &v.size, &v, -1, 1048576);
    good_number("size", "default", &v.size, &v, 0, 0);

    static const char none[] = "inf nan 0x10 1,5 1e 1e+ --1 . e5 1.2.3 infinity 1f \xff +-1 1e5.5 - +";
    bad_values("exponent", "is no number", none);
    bad_values("count", "is no number", none);
    bad_values("size", "is no size", none);
    bad_values("percentile", "is no decimal", none);
    bad_value("exponent", "", "'' is no number");
    bad_value("exponent", " 1", "is no number");
    bad_value("exponent", "1 ", "is no number");
    bad_values("exponent", "is out of range", "0 -0 -1 1e999 1e-999");
    bad_values("any", "is out of range", "-1e999 1e999");
    bad_values("shift", "is out of range", "1.0000001 -1.1");
    bad_values("key", "is neither", "Auto auto1 infinity nan");
    bad_values("count", "is out of range", "0 1025 -1");
    bad_values("count", "is no whole number", "1.5 1e300");
    bad_values("size", "is out of range", "1023K -1M 1e300T 9007199254740994");
    bad_values("size", "is no size", "1Q 1MB K 1KK");
    bad_value("exponent", NULL, "needs a value");
    bad_value("flag", "yes", "takes no value");
}

static void check_head(const hdr_options *options, const char *expected) {
    hdr_bytes head = {0};
    hdr_error error = {0};
    hdr_options_print(options, &head, &error);
    hdr_bytes_add(&head, "", 1, &error);
    CHECK(error.status == HDR_OK && strcmp((char *)head.data, expected) == 0, "'%s'", (char *)head.data);
    free(head.data);
}

static void test_words_and_texts(void) {
    values v;
    hdr_error error;
    CHECK(set("dither", "blue", &v, &error) == HDR_OK && v.choice == 2, "a choice is an index");
    CHECK(set("flag", NULL, &v, &error) == HDR_OK && v.flag, "a flag is set");
    bad_value("dither", "Blue", "is none of its words");
    bad_value("dither", "", "is none of its words");

    hdr_options options = {NULL, 0};
    hdr_options_default(table, &v);
    char typed[] = "a layer";
    hdr_error fine = {0};
    CHECK(hdr_option_set(hdr_option_letter(table, 'l'), typed, &v, &options, &fine) == HDR_OK, "%s", fine.message);
    typed[0] = 'X';
    CHECK(strcmp(v.text, "a layer") == 0 && v.text == options.given[0].text, "a text is copied");
    hdr_option_set(hdr_option_find(table, "flag"), NULL, &v, &options, &fine);
    hdr_option_set(hdr_option_find(table, "key"), "0.3", &v, &options, &fine);
    CHECK(strcmp(v.text, "a layer") == 0, "a text stays where it is");
    CHECK(hdr_option_set(hdr_option_find(table, "key"), "0.4", &v, &options, &fine) == HDR_USAGE &&
              strstr(fine.message, "--key is given twice\n"),
          "'%s'", fine.message);
    CHECK(v.key.value == 0.3 && options.count == 3, "what is given twice counts once");

    check_head(&options, " --layer a%20layer --flag --key 0.3");
    hdr_options_free(&options);
    CHECK(options.count == 0 && options.given == NULL, "freed options are empty");

    CHECK(!hdr_option_find(table, "none") && !hdr_option_letter(table, 'z') && !hdr_option_letter(table, 0),
          "not there");
}

/* Every byte but NUL, as a text, in the head. */
static void test_head_words(void) {
    char typed[256];
    for (int i = 1; i < 256; i++)
        typed[i - 1] = (char)i;
    typed[255] = '\0';
    values v;
    hdr_options options = {NULL, 0};
    hdr_error error = {0};
    hdr_bytes head = {0};
    hdr_options_default(table, &v);
    hdr_option_set(hdr_option_find(table, "layer"), typed, &v, &options, &error);
    hdr_options_print(&options, &head, &error);
    hdr_bytes_add(&head, "", 1, &error);
    const char *text = (char *)head.data + strlen(" --layer ");
    char back[256];
    size_t length = 0;
    for (; *text && length < 255; text++) {
        unsigned value = (unsigned char)*text;
        if (*text == '%' && sscanf(text + 1, "%2X", &value) == 1)
            text += 2;
        else
            CHECK(strchr("._,:/@+=-", *text) || (*text >= '0' && *text <= '9') || (*text >= 'A' && *text <= 'Z') ||
                      (*text >= 'a' && *text <= 'z'),
                  "byte %d stands in the head as it is", *text);
        back[length++] = (char)value;
    }
    CHECK(length == 255 && memcmp(back, typed, 255) == 0, "every byte comes back");
    hdr_options_free(&options);
    hdr_option_set(hdr_option_find(table, "layer"), "", &v, &options, &error);
    check_head(&options, " --layer=");
    hdr_options_free(&options);
    free(head.data);
}

static void check_line(const char *name, const char *expected) {
    char line[300], tiny[10];
    hdr_option_describe(hdr_option_find(table, name), line, sizeof line);
    CHECK(strcmp(line, expected) == 0, "'%s'\nis not '%s'", line, expected);
    hdr_option_describe(hdr_option_find(table, name), tiny, sizeof tiny);
    CHECK(strncmp(tiny, expected, 9) == 0 && tiny[9] == '\0', "a short line is cut: '%s'", tiny);
}

static void test_help_lines(void) {
    check_line("flag", "  -f, --flag               switch it on");
    check_line("exponent", "  -g, --exponent NUMBER    the exponent g of C^(1/g) (> 0; default 2.2)");
    check_line("shift", "      --shift N            how far (-1 to 1)");
    check_line("key", "  -k, --key KEY            the key (> 0, auto or inf; default auto)");
    check_line("count", "  -j, --count N            how many (1 to 1024; default 4)");
    check_line("size", "  -m, --size BYTES         how much (>= 1M or default; default 200M)");
    check_line("any", "      --any N              anything finite");
    check_line("percentile", "  -p, --percentile PERCENT  which rank (0 to 100; default 0.1)");
    check_line("dither", "      --dither KIND        the pattern (none, ordered or blue; default none)");
    check_line("gain", "      --gain N             bounded (> 0 and <= 8)");
    check_line("store", "      --store BYTES        no bound (>= 1K)");
    check_line("layer", "  -l, --layer NAME         which layer");
}

/* A host program may have set a locale with a decimal comma. */
static void test_locale(void) {
    static const char *const commas[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE", NULL};
    for (int i = 0; commas[i]; i++)
        if (setlocale(LC_NUMERIC, commas[i])) break;
    values v;
    good_number("exponent", "2.25", &v.exponent, &v, -1, 2.25);
    bad_value("exponent", "2,25", "is no number");
    check_line("exponent", "  -g, --exponent NUMBER    the exponent g of C^(1/g) (> 0; default 2.2)");
    setlocale(LC_NUMERIC, "C");
}

/* ---- Decimals and ranks ---- */

static uint64_t hundred_of(int places) {
    return places > 0 ? 10 * hundred_of(places - 1) : 100;
}

static void good_decimal(const char *text, uint64_t digits, int places) {
    values v;
    hdr_error error;
    hdr_status status = set("percentile", text, &v, &error);
    CHECK(status == HDR_OK && v.percent.digits == digits && v.percent.places == places, "%s: %llu / 10^%d (%s)", text,
          (unsigned long long)v.percent.digits, v.percent.places, error.message);
    CHECK(hdr_decimal_value(v.percent) == strtod(text, NULL), "%s is %.17g", text, hdr_decimal_value(v.percent));
    hdr_decimal rest = hdr_decimal_complement(v.percent);
    CHECK(rest.places == places && rest.digits + digits == hundred_of(places), "100 - %s", text);
}

static void test_decimals(void) {
    good_decimal("0.1", 1, 1);
    good_decimal("99.9", 999, 1);
    good_decimal("0", 0, 0);
    good_decimal("100", 100, 0);
    good_decimal("100.000000000000000000000", 100, 0);
    good_decimal("000000000000000000050", 50, 0);
    good_decimal("+.5", 5, 1);
    good_decimal("5.", 5, 0);
    good_decimal("12.3456789012345", 123456789012345u, 13);
    good_decimal("0.000000000000001", 1, 15);
    good_decimal("99.9000000000000000000000000", 999, 1);
    bad_values("percentile", "is out of range", "100.000000000001 101 -1");
    bad_values("percentile", "is no decimal", "1e1 50% 0x10");
    bad_values("percentile", "more digits",
               "100.0000000000001 12.34567890123456 0.0000000000000001 99999999999999999999999999");
}

/* The smallest rank r with r * 100 * 10^places >= digits * count, by counting. */
static uint64_t slow_rank(hdr_decimal p, uint64_t count) {
    uint64_t rank = 1;
    while (rank * hundred_of(p.places) < p.digits * count)
        rank++;
    return rank;
}

static void test_ranks(void) {
    for (uint64_t count = 1; count <= 300; count++)
        for (uint64_t digits = 0; digits <= 1000; digits += digits < 20 || digits > 980 ? 1 : 13) {
            hdr_decimal p = {digits, 1};
            CHECK(hdr_nearest_rank(p, count) == slow_rank(p, count), "rank of %llu/10 percent of %llu",
                  (unsigned long long)digits, (unsigned long long)count);
        }
    /* 99.9 percent of 1000 is 999 exactly; in doubles 99.9 * 1000 / 100 may come out above. */
    for (uint64_t thousands = 1; thousands < 1000000; thousands += 997)
        CHECK(hdr_nearest_rank((hdr_decimal){999, 1}, thousands * 1000) == thousands * 999, "99.9 percent");
    CHECK(hdr_nearest_rank((hdr_decimal){0, 0}, 5) == 1, "0 percent is the first");
    CHECK(hdr_nearest_rank((hdr_decimal){100, 0}, UINT64_MAX) == UINT64_MAX, "100 percent is the last");
    CHECK(hdr_nearest_rank((hdr_decimal){100000000000000u, 12}, UINT64_MAX) == UINT64_MAX, "100.000 percent");
    hdr_decimal nearly = hdr_decimal_complement((hdr_decimal){1, 15});
    CHECK(hdr_nearest_rank(nearly, UINT64_MAX) == UINT64_MAX - 184, "100 - 10^-15 percent");
    CHECK(hdr_nearest_rank((hdr_decimal){1, 15}, UINT64_MAX) == 185, "10^-15 percent");
}

/* ---- The pool ---- */

static void pause_briefly(unsigned seed) {
    unsigned x = seed * 2654435761u >> 16;
    if (x % 8 == 0) {
        struct timespec t = {0, (long)(x % 40) * 1000};
        nanosleep(&t, NULL);
    }
}

typedef struct work_log {
    hdr_pool *pool;
    int items, fail_at, also_fail_at, stop_at;
    bool fail_inside; /* within enter and leave */
    int delivered;    /* next in order: written between enter and leave only */
    bool out_of_order, bad_thread;
    atomic_int calls, turned_away;
    atomic_int *done; /* per item */
} work_log;

static hdr_status ordered_job(void *context, int item, int thread, hdr_error *err) {
    work_log *log = context;
    atomic_fetch_add(&log->calls, 1);
    atomic_fetch_add(&log->done[item], 1);
    if (thread < 0 || thread >= hdr_pool_threads(log->pool)) log->bad_thread = true;
    pause_briefly((unsigned)item + 17u * (unsigned)thread);
    bool fails = item == log->fail_at || item == log->also_fail_at;
    if (fails && !log->fail_inside) return hdr_fail(err, HDR_BAD_DATA, "item %d", item);
    if (!hdr_pool_enter(log->pool, item)) {
        atomic_fetch_add(&log->turned_away, 1);
        return HDR_OK;
    }
    if (log->delivered != item) log->out_of_order = true;
    log->delivered = item + 1;
    if (fails) return hdr_fail(err, HDR_IO, "delivery %d", item);
    if (item == log->stop_at) hdr_pool_stop(log->pool);
    hdr_pool_leave(log->pool, item);
    return HDR_OK;
}

static hdr_status run_ordered(work_log *log, hdr_error *error) {
    log->delivered = 0;
    log->out_of_order = log->bad_thread = false;
    atomic_store(&log->calls, 0);
    atomic_store(&log->turned_away, 0);
    for (int i = 0; i < log->items; i++)
        atomic_store(&log->done[i], 0);
    *error = (hdr_error){0};
    hdr_status status = hdr_pool_run(log->pool, log->items, ordered_job, log, error);
    CHECK(!log->out_of_order && !log->bad_thread, "order with %d threads", hdr_pool_threads(log->pool));
    for (int i = 0; i < log->items; i++)
        if (atomic_load(&log->done[i]) > 1) CHECK(false, "item %d was done %d times", i, atomic_load(&log->done[i]));
    return status;
}

static void test_pool_order(work_log *log) {
    hdr_error error;
    log->fail_at = log->also_fail_at = log->stop_at = -1;
    hdr_status status = run_ordered(log, &error);
    CHECK(status == HDR_OK && log->delivered == log->items && atomic_load(&log->calls) == log->items,
          "%d of %d items were delivered", log->delivered, log->items);
    CHECK(!hdr_pool_stopped(log->pool), "a whole run was not stopped");
}

static void test_pool_failures(work_log *log) {
    hdr_error error;
    log->stop_at = -1;
    for (int inside = 0; inside < 2; inside++) {
        log->fail_inside = inside;
        log->fail_at = log->items / 2;
        log->also_fail_at = log->items / 2 + 1;
        hdr_status status = run_ordered(log, &error);
        char expected[40];
        snprintf(expected, sizeof expected, "%s %d", inside ? "delivery" : "item", log->fail_at);
        CHECK(status == (inside ? HDR_IO : HDR_BAD_DATA) && status == error.status &&
                  strcmp(error.message, expected) == 0,
              "the lowest failed item wins: '%s' is '%s'", error.message, expected);
        CHECK(log->delivered == log->fail_at + inside, "all items below %d were delivered, up to %d", log->fail_at,
              log->delivered);
        CHECK(hdr_pool_run(log->pool, 0, ordered_job, log, NULL) == HDR_OK, "an empty run after a fault");
    }
    log->fail_at = log->also_fail_at = -1;
}

static void test_pool_stop(work_log *log) {
    hdr_error error;
    log->fail_at = log->also_fail_at = -1;
    log->stop_at = log->items / 3;
    hdr_status status = run_ordered(log, &error);
    CHECK(status == HDR_OK && error.status == HDR_OK, "a stop is no fault");
    CHECK(log->delivered == log->stop_at + 1, "delivered up to %d, stopped at %d", log->delivered, log->stop_at);
    CHECK(hdr_pool_stopped(log->pool), "the run was stopped");
    CHECK(hdr_pool_threads(log->pool) > 1 || atomic_load(&log->calls) == log->stop_at + 1, "one thread stops at once");
}

typedef struct nest {
    hdr_pool *pool;
    atomic_long sum;
    atomic_int inner_stopped;
} nest;

typedef struct inner_nest {
    nest *outer;
    int next, fail_at;
} inner_nest;

static hdr_status inner_job(void *context, int item, int thread, hdr_error *err) {
    inner_nest *inner = context;
    if (thread < 0 || thread >= hdr_pool_threads(inner->outer->pool))
        return hdr_fail(err, HDR_INTERNAL, "thread %d", thread);
    if (item == inner->fail_at) return hdr_fail(err, HDR_BAD_DATA, "inner %d", item);
    if (!hdr_pool_enter(inner->outer->pool, item)) return HDR_OK;
    if (inner->next++ != item) return hdr_fail(err, HDR_INTERNAL, "order");
    atomic_fetch_add(&inner->outer->sum, item + 1);
    hdr_pool_leave(inner->outer->pool, item);
    return HDR_OK;
}

static hdr_status outer_job(void *context, int item, int thread, hdr_error *err) {
    nest *outer = context;
    (void)thread;
    inner_nest inner = {outer, 0, item % 2 ? 7 : -1};
    hdr_error fault = {0};
    hdr_status status = hdr_pool_run(outer->pool, 10, inner_job, &inner, &fault);
    if (item % 2 ? status != HDR_BAD_DATA || strcmp(fault.message, "inner 7") != 0 : status != HDR_OK)
        return hdr_fail(err, HDR_INTERNAL, "inner run of %d: %s", item, fault.message);
    if (!hdr_pool_enter(outer->pool, item)) return hdr_fail(err, HDR_INTERNAL, "the outer run was stopped");
    hdr_pool_leave(outer->pool, item);
    return HDR_OK;
}

static void test_pool_nested(hdr_pool *pool) {
    nest outer = {.pool = pool};
    hdr_error error = {0};
    CHECK(hdr_pool_run(pool, 40, outer_job, &outer, &error) == HDR_OK, "runs within jobs: %s", error.message);
    CHECK(atomic_load(&outer.sum) == 20 * 55 + 20 * 28, "sum %ld", atomic_load(&outer.sum));
}

static hdr_status count_job(void *context, int item, int thread, hdr_error *err) {
    (void)thread, (void)err;
    if (!context) return HDR_NO_INPUT; /* a fault without a message */
    atomic_fetch_add((atomic_long *)context, item);
    return HDR_OK;
}

static void test_pools(void) {
    static const int threads[] = {1, 2, 3, 8, 33};
    static const int items[] = {1, 2, 3, 10, 1000};
    for (size_t t = 0; t < sizeof threads / sizeof *threads; t++) {
        hdr_error error = {0};
        hdr_pool *pool = hdr_pool_new(threads[t], &error);
        CHECK(pool != NULL && hdr_pool_threads(pool) == threads[t], "a pool of %d: %s", threads[t], error.message);
        if (!pool) continue;
        for (size_t i = 0; i < sizeof items / sizeof *items; i++) {
            work_log log = {.pool = pool, .items = items[i]};
            log.done = hdr_alloc((size_t)items[i], sizeof *log.done);
            test_pool_order(&log);
            test_pool_failures(&log);
            test_pool_stop(&log);
            test_pool_order(&log);
            free(log.done);
        }
        for (int repeat = 0; repeat < 300; repeat++) {
            atomic_long sum = 0;
            hdr_status status = hdr_pool_run(pool, repeat, count_job, &sum, &error);
            CHECK(status == HDR_OK && sum == (long)repeat * (repeat - 1) / 2, "%d small items", repeat);
        }
        test_pool_nested(pool);
        hdr_error silent = {0};
        CHECK(hdr_pool_run(pool, 5, count_job, NULL, &silent) == HDR_NO_INPUT && silent.status == HDR_NO_INPUT,
              "a job's status counts without a message, too");
        hdr_pool_free(pool);
    }
}

int main(void) {
    test_errors();
    test_memory();
    test_bytes();
    test_cpu();
    test_defaults();
    test_numbers();
    test_words_and_texts();
    test_head_words();
    test_help_lines();
    test_locale();
    test_decimals();
    test_ranks();
    test_pools();
    return check_done("test_base");
}

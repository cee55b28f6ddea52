/* Option tables: values from words, words from values, and the help line. */
#include "base/options.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_DIGITS 15      /* of a decimal: the double nearest to it then stands for it alone */
#define HELP_COLUMN 27     /* where an option's help text begins */
#define MAX_WHOLE 0x1p53   /* whole numbers beyond are not all doubles */
#define QUOTED_LENGTH "80" /* how much of a bad value a message repeats */

/* ---- Words ---- */

/* Index into the option's words, or -1. */
static int word_index(const hdr_option *option, const char *text) {
    for (int i = 0; option->words && option->words[i]; i++)
        if (strcmp(option->words[i], text) == 0) return i;
    return -1;
}

/* "A", "A or B", "A, B or C": the range, where there is one, and the words. */
static hdr_status print_alternatives(const hdr_option *option, const char *range, hdr_bytes *out, hdr_error *err) {
    int count = 0, printed = 0;
    while (option->words && option->words[count])
        count++;
    int total = count + (range ? 1 : 0);
    hdr_status status = HDR_OK;
    if (range) {
        status = hdr_bytes_printf(out, err, "%s", range);
        printed++;
    }
    for (int i = 0; i < count && status == HDR_OK; i++, printed++) {
        const char *between = printed == 0 ? "" : printed == total - 1 ? " or " : ", ";
        status = hdr_bytes_printf(out, err, "%s%s", between, option->words[i]);
    }
    return status;
}

/* ---- The help line ---- */

/* A limit as it would be typed: 1, 0.5, 1M. No locale's decimal comma. */
static void print_limit(const hdr_option *option, double limit, char *text, size_t size) {
    static const char suffix[] = {'K', 'M', 'G', 'T', 0};
    if (option->type == HDR_OPTION_SIZE && fabs(limit) < 0x1p63) {
        int power = -1;
        while (suffix[power + 1] && limit != 0 && fmod(limit, 1024) == 0) {
            limit /= 1024;
            power++;
        }
        snprintf(text, size, "%.0f%c", limit, power < 0 ? 0 : suffix[power]);
        return;
    }
    snprintf(text, size, "%.15g", limit);
    char *comma = strchr(text, ',');
    if (comma) *comma = '.';
}

/* The range in words; false when the option has none to speak of. */
static bool print_range(const hdr_option *option, char *text, size_t size) {
    char low[40], high[40];
    if (option->type == HDR_OPTION_FLAG || option->type == HDR_OPTION_CHOICE || option->type == HDR_OPTION_TEXT ||
        (option->min == 0 && option->max == 0))
        return false;
    print_limit(option, option->min, low, sizeof low);
    print_limit(option, option->max, high, sizeof high);
    const char *above = option->above_min ? ">" : ">=";
    bool bounded = isfinite(option->max) && !(option->type == HDR_OPTION_SIZE && option->max >= MAX_WHOLE);
    if (isfinite(option->min) && bounded)
        snprintf(text, size, option->above_min ? "> %s and <= %s" : "%s to %s", low, high);
    else if (isfinite(option->min))
        snprintf(text, size, "%s %s", above, low);
    else if (bounded)
        snprintf(text, size, "<= %s", high);
    else
        return false;
    return true;
}

static hdr_status print_name(const hdr_option *option, hdr_bytes *out, hdr_error *err) {
    if (option->letter)
        hdr_bytes_printf(out, err, "  -%c, --%s", option->letter, option->name);
    else
        hdr_bytes_printf(out, err, "      --%s", option->name);
    if (option->type != HDR_OPTION_FLAG) hdr_bytes_printf(out, err, " %s", option->metavar ? option->metavar : "WORD");
    return err->status;
}

/* " (range or words; default D)", or nothing. */
static hdr_status print_remark(const hdr_option *option, hdr_bytes *out, hdr_error *err) {
    char range[100];
    bool has_range = print_range(option, range, sizeof range);
    bool has_values = has_range || (option->words && option->words[0]);
    if (!has_values && !option->default_value) return HDR_OK;
    hdr_bytes_printf(out, err, " (");
    if (has_values) print_alternatives(option, has_range ? range : NULL, out, err);
    if (option->default_value)
        hdr_bytes_printf(out, err, "%sdefault %s", has_values ? "; " : "", option->default_value);
    return hdr_bytes_printf(out, err, ")");
}

hdr_status hdr_option_line(const hdr_option *option, hdr_bytes *out, hdr_error *err) {
    hdr_error own = {0};
    size_t start = out->size;
    print_name(option, out, &own);
    size_t width = out->size - start;
    int gap = width + 2 < HELP_COLUMN ? (int)(HELP_COLUMN - width) : 2;
    hdr_bytes_printf(out, &own, "%*s%s", gap, "", option->help ? option->help : "");
    print_remark(option, out, &own);
    return own.status == HDR_OK ? HDR_OK : hdr_fail(err, own.status, "%s", own.message);
}

void hdr_option_describe(const hdr_option *option, char *line, size_t size) {
    if (size == 0) return;
    line[0] = '\0';
    hdr_bytes text = {0};
    if (hdr_option_line(option, &text, NULL) == HDR_OK)
        snprintf(line, size, "%.*s", (int)text.size, (const char *)text.data);
    free(text.data);
}

/* A fault of a value: what is wrong, then the option's help line. */
static hdr_status refuse(const hdr_option *option, hdr_error *err, const char *text, const char *what) {
    char line[500];
    hdr_option_describe(option, line, sizeof line);
    if (text)
        return hdr_fail(err, HDR_USAGE, "--%s: %." QUOTED_LENGTH "s %s\n%s", option->name, *text ? text : "''", what,
                        line);
    return hdr_fail(err, HDR_USAGE, "--%s %s\n%s", option->name, what, line);
}

/* ---- Numbers ---- */

static const char *skip_digits(const char *text) {
    while (*text >= '0' && *text <= '9')
        text++;
    return text;
}

/* The end of [+-]digits[.digits][e[+-]digits] (digits on one side of the point suffice), or NULL. strtod alone would
 * also take "inf", "nan", hexadecimal and leading space. */
static const char *end_of_number(const char *text) {
    if (*text == '+' || *text == '-') text++;
    const char *whole = text;
    text = skip_digits(text);
    size_t digits = (size_t)(text - whole);
    if (*text == '.') {
        const char *fraction = ++text;
        text = skip_digits(fraction);
        digits += (size_t)(text - fraction);
    }
    if (digits == 0) return NULL;
    if (*text != 'e' && *text != 'E') return text;
    text++;
    if (*text == '+' || *text == '-') text++;
    const char *exponent = text;
    text = skip_digits(exponent);
    return text > exponent ? text : NULL;
}

/* strtod with a point for the decimal point, whatever locale the host program has set. */
static double to_double(const char *text) {
    locale_t c = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    locale_t before = c ? uselocale(c) : (locale_t)0;
    double value = strtod(text, NULL);
    if (c) {
        uselocale(before);
        freelocale(c);
    }
    return value;
}

const char *hdr_read_number(const char *text, double *value) {
    const char *end = end_of_number(text);
    if (!end || !strchr(" \t\r\n", *end)) return NULL; /* which finds the closing NUL too */
    *value = to_double(text);
    return end;
}

static bool in_range(const hdr_option *option, double value) {
    if (!isfinite(value)) return false;
    if (option->min == 0 && option->max == 0) return true;
    return value <= option->max && (option->above_min ? value > option->min : value >= option->min);
}

static hdr_status parse_number(const hdr_option *option, const char *text, hdr_number *number, hdr_error *err) {
    number->word = word_index(option, text);
    number->value = 0;
    if (number->word >= 0) return HDR_OK;
    const char *end = end_of_number(text);
    if (!end || *end)
        return refuse(option, err, text, option->words ? "is neither a number nor one of its words" : "is no number");
    double value = to_double(text);
    if (option->type == HDR_OPTION_INTEGER && (value != floor(value) || fabs(value) > MAX_WHOLE))
        return refuse(option, err, text, "is no whole number");
    if (!in_range(option, value)) return refuse(option, err, text, "is out of range");
    number->value = value;
    return HDR_OK;
}

static hdr_status parse_size(const hdr_option *option, const char *text, hdr_number *number, hdr_error *err) {
    static const char suffixes[] = "KkMmGgTt";
    number->word = word_index(option, text);
    number->value = 0;
    if (number->word >= 0) return HDR_OK;
    const char *end = end_of_number(text);
    double value = end ? to_double(text) : 0;
    if (end && *end) {
        const char *suffix = strchr(suffixes, *end);
        if (suffix) value = ldexp(value, 10 * (int)((suffix - suffixes) / 2 + 1));
        end = suffix && !end[1] ? end + 1 : NULL;
    }
    if (!end) return refuse(option, err, text, "is no size in bytes (as in 200M)");
    value = floor(value);
    if (!(value >= 0) || value > MAX_WHOLE || !in_range(option, value))
        return refuse(option, err, text, "is out of range");
    number->value = value;
    return HDR_OK;
}

/* Appends one digit; false when it is one too many. Zeros in front are not counted. */
static bool add_digit(hdr_decimal *decimal, char digit) {
    if (decimal->digits >= 100000000000000u) /* it has MAX_DIGITS already */
        return false;
    decimal->digits = decimal->digits * 10 + (uint64_t)(digit - '0');
    return true;
}

static hdr_status parse_decimal(const hdr_option *option, const char *text, hdr_decimal *decimal, hdr_error *err) {
    const char *whole = text + (*text == '+');
    const char *point = skip_digits(whole);
    const char *fraction = *point == '.' ? point + 1 : point;
    const char *end = skip_digits(fraction);
    if (*end || (point == whole && end == fraction)) {
        bool negative = *text == '-' && end_of_number(text) && !*end_of_number(text);
        return refuse(option, err, text, negative ? "is out of range" : "is no decimal number");
    }
    while (end > fraction && end[-1] == '0') /* zeros at the end change nothing */
        end--;
    *decimal = (hdr_decimal){0, 0};
    bool fits = end - fraction <= MAX_DIGITS;
    for (const char *c = whole; fits && c < point; c++)
        fits = add_digit(decimal, *c);
    for (const char *c = fraction; fits && c < end; c++, decimal->places++)
        fits = add_digit(decimal, *c);
    if (!fits) return refuse(option, err, text, "has more digits than the 15 that are kept");
    if (!in_range(option, hdr_decimal_value(*decimal))) return refuse(option, err, text, "is out of range");
    return HDR_OK;
}

static uint64_t power_of_ten(int places) {
    uint64_t power = 1;
    while (places-- > 0)
        power *= 10;
    return power;
}

/* Both parts are whole numbers below 2^53 (places is at most 15), so the quotient is the double nearest to the decimal.
 */
double hdr_decimal_value(hdr_decimal decimal) {
    return (double)decimal.digits / (double)power_of_ten(decimal.places);
}

hdr_decimal hdr_decimal_complement(hdr_decimal percent) {
    uint64_t hundred = 100 * power_of_ten(percent.places);
    return (hdr_decimal){percent.digits <= hundred ? hundred - percent.digits : 0, percent.places};
}

/* digits < 2^57 even of a complement, count < 2^64: the product fits 128 bits. */
uint64_t hdr_nearest_rank(hdr_decimal percent, uint64_t count) {
    unsigned __int128 product = (unsigned __int128)percent.digits * count;
    unsigned __int128 hundred = (unsigned __int128)100 * power_of_ten(percent.places);
    uint64_t rank = (uint64_t)((product + hundred - 1) / hundred);
    return rank < 1 ? 1 : rank;
}

/* ---- Facts of a shot ---- */

static const char *const shot_keys[] = {"log_average", "max_luminance", "p1", "p99"};
enum { SHOT_KEYS = sizeof shot_keys / sizeof *shot_keys };

/* The numbers in the order of their keys. */
static void shot_numbers(const hdr_shot *shot, double number[SHOT_KEYS]) {
    number[0] = shot->log_average;
    number[1] = shot->max_luminance;
    number[2] = shot->low;
    number[3] = shot->high;
}

/* Percentiles are rounded to float32, so they may lie beyond the maximum by so much. */
const char *hdr_shot_fault(const hdr_shot *shot) {
    double number[SHOT_KEYS];
    shot_numbers(shot, number);
    double most = shot->max_luminance * (1 + 1e-6) + 0x1p-149;
    for (int i = 0; i < SHOT_KEYS; i++) {
        if (!isfinite(number[i]) || number[i] < 0) return "has a number that is not finite, or negative";
        if ((number[i] > 0) != shot->lit) return "contradicts itself: either all its numbers are above 0, or all are 0";
        if (shot->lit && (number[i] < 1e-200 || number[i] > 1e50)) return "has a number that no picture can have";
    }
    if (shot->log_average > most || shot->low > shot->high || shot->high > most)
        return "contradicts itself: the percentiles ascend, and nothing is above the maximum";
    return NULL;
}

void hdr_shot_print(const hdr_shot *shot, char text[HDR_SHOT_TEXT]) {
    double number[SHOT_KEYS];
    size_t used = 0;
    shot_numbers(shot, number);
    for (int i = 0; i < SHOT_KEYS; i++) {
        char digits[40];
        snprintf(digits, sizeof digits, "%.17g", number[i]);
        char *comma = strchr(digits, ','); /* some locale's */
        if (comma) *comma = '.';
        used += (size_t)snprintf(text + used, HDR_SHOT_TEXT - used, "%s%s=%s", i ? "," : "", shot_keys[i], digits);
    }
}

bool hdr_shot_is_text(const char *text) {
    size_t length = strlen(shot_keys[0]);
    return strncmp(text, shot_keys[0], length) == 0 && text[length] == '=';
}

/* "key=number" and what has to stand behind it. Returns the place behind that, or NULL. */
static const char *take_named(const char *text, const char *key, char behind, double *number) {
    size_t length = strlen(key);
    if (strncmp(text, key, length) != 0 || text[length] != '=') return NULL;
    const char *end = end_of_number(text + length + 1);
    if (!end || *end != behind) return NULL;
    *number = to_double(text + length + 1);
    return end + 1;
}

static hdr_status parse_shot(const hdr_option *option, const char *text, hdr_shot *shot, hdr_error *err) {
    double number[SHOT_KEYS];
    const char *at = text;
    for (int i = 0; at && i < SHOT_KEYS; i++)
        at = take_named(at, shot_keys[i], i < SHOT_KEYS - 1 ? ',' : '\0', &number[i]);
    if (!at) return refuse(option, err, text, "is not log_average=...,max_luminance=...,p1=...,p99=...");
    hdr_shot all = {true, number[0] > 0, number[0], number[1], number[2], number[3]};
    const char *fault = hdr_shot_fault(&all);
    if (fault) return refuse(option, err, text, fault);
    *shot = all;
    return HDR_OK;
}

const hdr_shot *hdr_options_shot(const hdr_option *table, const void *params) {
    for (const hdr_option *option = table; option && option->name; option++) {
        const void *place = (const char *)params + option->offset;
        if (option->type == HDR_OPTION_FACTS && ((const hdr_shot *)place)->given) return place;
    }
    return NULL;
}

/* ---- Setting ---- */

/* Puts the value that text stands for at the option's place. A text itself is not copied. */
static hdr_status store(const hdr_option *option, const char *text, void *params, hdr_error *err) {
    void *place = (char *)params + option->offset;
    switch (option->type) {
    case HDR_OPTION_FLAG:
        *(bool *)place = true;
        return HDR_OK;
    case HDR_OPTION_NUMBER:
    case HDR_OPTION_INTEGER:
        return parse_number(option, text, place, err);
    case HDR_OPTION_DECIMAL:
        return parse_decimal(option, text, place, err);
    case HDR_OPTION_SIZE:
        return parse_size(option, text, place, err);
    case HDR_OPTION_TEXT:
        *(const char **)place = text;
        return HDR_OK;
    case HDR_OPTION_FACTS:
        return parse_shot(option, text, place, err);
    case HDR_OPTION_CHOICE: {
        int word = word_index(option, text);
        if (word < 0) return refuse(option, err, text, "is none of its words");
        *(int *)place = word;
        return HDR_OK;
    }
    }
    return hdr_fail(err, HDR_INTERNAL, "--%s has an unknown type", option->name);
}

static void store_nothing(const hdr_option *option, void *params) {
    void *place = (char *)params + option->offset;
    switch (option->type) {
    case HDR_OPTION_FLAG:
        *(bool *)place = false;
        break;
    case HDR_OPTION_NUMBER:
    case HDR_OPTION_INTEGER:
    case HDR_OPTION_SIZE:
        *(hdr_number *)place = (hdr_number){-1, 0};
        break;
    case HDR_OPTION_DECIMAL:
        *(hdr_decimal *)place = (hdr_decimal){0, 0};
        break;
    case HDR_OPTION_TEXT:
        *(const char **)place = NULL;
        break;
    case HDR_OPTION_FACTS:
        *(hdr_shot *)place = (hdr_shot){.given = false};
        break;
    case HDR_OPTION_CHOICE:
        *(int *)place = 0;
        break;
    }
}

void hdr_options_default(const hdr_option *table, void *params) {
    for (const hdr_option *option = table; option && option->name; option++) {
        store_nothing(option, params);
        if (option->default_value && option->type != HDR_OPTION_FLAG)
            (void)store(option, option->default_value, params, NULL); /* the tests prove that every default parses */
    }
}

const hdr_option *hdr_option_find(const hdr_option *table, const char *name) {
    for (const hdr_option *option = table; option && option->name; option++)
        if (strcmp(option->name, name) == 0) return option;
    return NULL;
}

const hdr_option *hdr_option_letter(const hdr_option *table, char letter) {
    for (const hdr_option *option = table; letter && option && option->name; option++)
        if (option->letter == letter) return option;
    return NULL;
}

hdr_status hdr_option_set(const hdr_option *option, const char *text, void *params, hdr_options *options,
                          hdr_error *err) {
    for (int i = 0; i < options->count; i++)
        if (options->given[i].option == option) return refuse(option, err, NULL, "is given twice");
    if (option->type == HDR_OPTION_FLAG && text) return refuse(option, err, NULL, "takes no value");
    if (option->type != HDR_OPTION_FLAG && !text) return refuse(option, err, NULL, "needs a value");
    char *copy = text ? strdup(text) : NULL;
    hdr_given *given = hdr_grow(options->given, (size_t)options->count + 1, sizeof *given);
    if (given) options->given = given;
    if (!given || (text && !copy)) {
        free(copy);
        return hdr_fail(err, HDR_INTERNAL, "out of memory for --%s", option->name);
    }
    hdr_status status = store(option, copy, params, err);
    if (status != HDR_OK) {
        free(copy);
        return status;
    }
    given[options->count++] = (hdr_given){option, copy};
    return HDR_OK;
}

void hdr_options_free(hdr_options *options) {
    if (!options) return;
    for (int i = 0; i < options->count; i++)
        free(options->given[i].text);
    free(options->given);
    *options = (hdr_options){NULL, 0};
}

/* ---- The head's words ---- */

bool hdr_plain_in_head(unsigned char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || (c && strchr("._,:/@+=-", c));
}

static hdr_status print_word(const char *text, hdr_bytes *out, hdr_error *err) {
    hdr_status status = HDR_OK;
    for (const char *c = text; *c && status == HDR_OK; c++)
        status = hdr_plain_in_head((unsigned char)*c) ? hdr_bytes_add(out, c, 1, err)
                                                      : hdr_bytes_printf(out, err, "%%%02X", (unsigned char)*c);
    return status;
}

hdr_status hdr_options_print(const hdr_options *options, hdr_bytes *out, hdr_error *err) {
    for (int i = 0; i < options->count; i++) {
        const hdr_given *given = &options->given[i];
        hdr_status status = hdr_bytes_printf(out, err, " --%s", given->option->name);
        /* An empty value as a word of its own could not be seen. */
        if (status == HDR_OK && given->text) status = hdr_bytes_add(out, *given->text ? " " : "=", 1, err);
        if (status == HDR_OK && given->text) status = print_word(given->text, out, err);
        if (status != HDR_OK) return status;
    }
    return HDR_OK;
}

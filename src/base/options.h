/* Option tables: the only place where an option exists. Parsing, help, the man page's OPTIONS, completion, the pipe's
 * head and the fuzz dictionary all come from them. The table's type, hdr_option, is public: see hdrpipe.h. */
#ifndef HDR_OPTIONS_H
#define HDR_OPTIONS_H

#include "base.h"

/* What an option stores in its params struct, at its offset:
 *   HDR_OPTION_FLAG     bool
 *   HDR_OPTION_NUMBER   hdr_number   a double in [min,max], or one of the table's words
 *   HDR_OPTION_INTEGER  hdr_number   the same, a whole number
 *   HDR_OPTION_DECIMAL  hdr_decimal  a non-negative decimal, exactly as typed
 *   HDR_OPTION_CHOICE   int          index into words
 *   HDR_OPTION_SIZE     hdr_number   bytes; the suffixes K M G T are powers of 1024
 *   HDR_OPTION_TEXT     const char * as typed; belongs to the hdr_given that holds it
 *   HDR_OPTION_FACTS    hdr_shot     the numbers; a file's name is for the chain to resolve */
typedef struct hdr_number {
    int word; /* index into the option's words, or -1: value holds a number */
    double value;
} hdr_number;
typedef struct hdr_decimal {
    uint64_t digits; /* the number is digits / 10^places; at most 15 digits */
    int places;
} hdr_decimal;

/* Numbers about a whole shot, which a verb takes instead of those of the picture at hand. Luminances of lit pixels. */
typedef struct hdr_shot {
    bool given;
    bool lit; /* false: nothing is lit in any picture, and all numbers are 0 */
    double log_average, max_luminance;
    double low, high; /* percentiles 1 and 99, by nearest rank */
} hdr_shot;

/* The options that were given, as they were typed, in the order of the typing. */
typedef struct hdr_given {
    const hdr_option *option;
    char *text; /* NULL for a flag */
} hdr_given;
typedef struct hdr_options {
    hdr_given *given;
    int count;
} hdr_options;

/* Writes every default of the table into params. (The tests prove that all defaults parse.) */
void hdr_options_default(const hdr_option *table, void *params);

/* Finds --name (name without dashes) or -l. NULL when the table has none. A table ends with a NULL name. */
const hdr_option *hdr_option_find(const hdr_option *table, const char *name);
const hdr_option *hdr_option_letter(const hdr_option *table, char letter);

/* Parses text as option's value into params and records it in options. Given twice, out of range, not a number:
 * HDR_USAGE, and the message ends with the option's own help line. text is NULL for a flag. */
hdr_status hdr_option_set(const hdr_option *option, const char *text, void *params, hdr_options *options,
                          hdr_error *err);
void hdr_options_free(hdr_options *options);

/* The option's one help line, without newline: "  -g, --exponent N   help (range; default D)". In static form in bytes.
 */
hdr_status hdr_option_line(const hdr_option *option, hdr_bytes *out, hdr_error *err);

/* The same value as words of the head: appends " --name value" with bytes outside [A-Za-z0-9._,:/@+=-] as %XX. */
hdr_status hdr_options_print(const hdr_options *options, hdr_bytes *out, hdr_error *err);

/* Whether a byte stands for itself in the head, not as %XX. */
bool hdr_plain_in_head(unsigned char byte);

/* rank = max(1, ceil(P count / 100)), in exact arithmetic; P in [0,100], count >= 1. */
uint64_t hdr_nearest_rank(hdr_decimal percent, uint64_t count);
/* 100 - P, exactly. */
hdr_decimal hdr_decimal_complement(hdr_decimal percent);
double hdr_decimal_value(hdr_decimal decimal);

/* What is wrong with the numbers of a shot, e.g. "..., which is above the maximum"; NULL: nothing. */
const char *hdr_shot_fault(const hdr_shot *shot);

/* The numbers as text that an option takes and that gives the same doubles back, and whether a text is meant so. */
#define HDR_SHOT_TEXT 200
void hdr_shot_print(const hdr_shot *shot, char text[HDR_SHOT_TEXT]);
bool hdr_shot_is_text(const char *text);

/* The shot whose facts were given by an option of the table, or NULL. */
const hdr_shot *hdr_options_shot(const hdr_option *table, const void *params);

/* A decimal number at the beginning of text, which white space or the end of text must follow. Returns its end, or
 * NULL. What is beyond double becomes infinite. */
const char *hdr_read_number(const char *text, double *value);

#endif

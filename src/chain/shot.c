/* A scanner for JSON that takes a few numbers out of it. It is strict about the form, so that half a file is not taken
 * for a whole one, and passes over what it does not know: other members may come. */
#include "chain/shot.h"

#include "io/input.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FILE_MAX ((size_t)64 << 20) /* the facts of some 40000 frames */
#define FILE_STEP ((size_t)64 << 10)
#define DEPTH_MAX 16
#define NUMBER_MAX 63 /* characters: more than any double needs */

/* The numbers that are taken, of an object that stands by itself or of its member "percentiles". */
static const struct member {
    bool percentile;
    const char *key;
} members[] = {{false, "files"},         {false, "of"}, {false, "pixels"}, {false, "lit"}, {false, "log_average"},
               {false, "max_luminance"}, {true, "1"},   {true, "99"}};
enum { FILES, OF, PIXELS, LIT, LOG_AVERAGE, MAX_LUMINANCE, LOW, HIGH, MEMBERS };

/* What was found in an object: of one file, or, where it has "files", of several together. */
typedef struct object {
    bool of_file, has[MEMBERS];
    double value[MEMBERS];
} object;

typedef struct scanner {
    const char *at, *end;
    const char *fault; /* the first, or NULL */
} scanner;

static bool fail(scanner *s, const char *fault) {
    if (!s->fault) s->fault = fault;
    return false;
}

/* ---- Words ---- */

static void skip_space(scanner *s) {
    while (s->at < s->end && (*s->at == ' ' || *s->at == '\t' || *s->at == '\n' || *s->at == '\r'))
        s->at++;
}

static bool next_is(const scanner *s, char c) {
    return s->at < s->end && *s->at == c;
}

/* Passes over that character, and the space in front of it. */
static bool take(scanner *s, char c) {
    skip_space(s);
    if (!next_is(s, c)) return false;
    s->at++;
    return true;
}

static bool take_word(scanner *s, const char *word) {
    size_t length = strlen(word);
    if ((size_t)(s->end - s->at) < length || memcmp(s->at, word, length) != 0) return fail(s, "is no JSON");
    s->at += length;
    return true;
}

static bool take_escape(scanner *s) {
    if (s->at == s->end) return false;
    char kind = *s->at++;
    if (kind != 'u') return kind && strchr("\"\\/bfnrt", kind);
    for (int i = 0; i < 4; i++, s->at++)
        if (s->at == s->end || !*s->at || !strchr("0123456789abcdefABCDEF", *s->at)) return false;
    return true;
}

/* A string; what stands between its quotes, escapes as they are. */
static bool take_string(scanner *s, const char **text, size_t *length) {
    if (!take(s, '"')) return fail(s, "is no JSON");
    *text = s->at;
    while (s->at < s->end && *s->at != '"') {
        unsigned char c = (unsigned char)*s->at++;
        if (c < 0x20 || (c == '\\' && !take_escape(s))) return fail(s, "is no JSON");
    }
    *length = (size_t)(s->at - *text);
    return take(s, '"') || fail(s, "is cut off");
}

static void skip_digits(scanner *s) {
    while (s->at < s->end && *s->at >= '0' && *s->at <= '9')
        s->at++;
}

/* The characters of a number, as JSON has them: no plus sign, no superfluous zero. */
static bool pass_number(scanner *s) {
    if (next_is(s, '-')) s->at++;
    const char *whole = s->at;
    skip_digits(s);
    if (s->at == whole || (*whole == '0' && s->at - whole > 1)) return false;
    if (next_is(s, '.')) {
        const char *fraction = ++s->at;
        skip_digits(s);
        if (s->at == fraction) return false;
    }
    if (!next_is(s, 'e') && !next_is(s, 'E')) return true;
    s->at++;
    if (next_is(s, '+') || next_is(s, '-')) s->at++;
    const char *exponent = s->at;
    skip_digits(s);
    return s->at > exponent;
}

static bool take_number(scanner *s, double *number) {
    char digits[NUMBER_MAX + 1];
    const char *start = s->at;
    if (!pass_number(s)) return fail(s, "is no JSON");
    size_t length = (size_t)(s->at - start);
    if (length > NUMBER_MAX) return fail(s, "has a number of too many digits");
    memcpy(digits, start, length);
    digits[length] = '\0';
    return hdr_read_number(digits, number) || fail(s, "is no JSON");
}

/* ---- Values ---- */

/* Where in the text a value stands. */
typedef enum place {
    AT_TOP,         /* of an object that stands by itself */
    IN_PERCENTILES, /* in its member of this name */
    ELSEWHERE
} place;

static bool take_value(scanner *s, int depth, place inside, object *into);

static bool is_key(const char *key, size_t length, const char *word) {
    return strlen(word) == length && memcmp(key, word, length) == 0;
}

/* Index into members, or -1. */
static int find_member(place inside, const char *key, size_t length) {
    for (int m = 0; m < MEMBERS && inside != ELSEWHERE; m++)
        if (members[m].percentile == (inside == IN_PERCENTILES) && is_key(key, length, members[m].key)) return m;
    return -1;
}

/* "key": value, of an object. A number that is looked for and is none (null: it was not finite) stays missing. */
static bool take_member(scanner *s, int depth, place inside, object *into) {
    const char *key;
    size_t length;
    if (!take_string(s, &key, &length)) return false;
    if (!take(s, ':')) return fail(s, s->at == s->end ? "is cut off" : "is no JSON");
    skip_space(s);
    int member = find_member(inside, key, length);
    if (member >= 0 && into->has[member]) return fail(s, "says a number twice");
    if (member >= 0 && s->at < s->end && (*s->at == '-' || (*s->at >= '0' && *s->at <= '9'))) {
        into->has[member] = true;
        return take_number(s, &into->value[member]);
    }
    if (inside == AT_TOP && is_key(key, length, "file")) into->of_file = true;
    bool percentiles = inside == AT_TOP && is_key(key, length, "percentiles");
    return take_value(s, depth, percentiles ? IN_PERCENTILES : ELSEWHERE, into);
}

/* The members of an object or the elements of an array, behind its first bracket, up to the last. */
static bool take_members(scanner *s, int depth, char close, place inside, object *into) {
    if (depth == DEPTH_MAX) return fail(s, "is nested too deeply");
    if (take(s, close)) return true;
    do {
        bool taken = close == '}' ? take_member(s, depth + 1, inside, into) : take_value(s, depth + 1, ELSEWHERE, into);
        if (!taken) return false;
    } while (take(s, ','));
    return take(s, close) || fail(s, s->at == s->end ? "is cut off" : "is no JSON");
}

static bool take_value(scanner *s, int depth, place inside, object *into) {
    const char *text;
    size_t length;
    double number;
    skip_space(s);
    if (s->at == s->end) return fail(s, "is cut off");
    switch (*s->at) {
    case '{':
        s->at++;
        return take_members(s, depth, '}', inside, into);
    case '[':
        s->at++;
        return take_members(s, depth, ']', ELSEWHERE, into);
    case '"':
        return take_string(s, &text, &length);
    case 't':
        return take_word(s, "true");
    case 'f':
        return take_word(s, "false");
    case 'n':
        return take_word(s, "null");
    default:
        return take_number(s, &number);
    }
}

/* ---- Facts ---- */

/* An object that stands by itself. It has all numbers, and is of a file or of several. */
static bool take_object(scanner *s, object *found) {
    *found = (object){.of_file = false};
    if (!take(s, '{')) return fail(s, "is no JSON");
    if (!take_members(s, 0, '}', AT_TOP, found)) return false;
    for (int m = OF + 1; m < MEMBERS; m++)
        if (!found->has[m]) return fail(s, "lacks some of the facts");
    return found->of_file != found->has[FILES] || fail(s, "lacks some of the facts");
}

/* The last object, if that is of all files before it. */
static bool take_all(scanner *s, object *found) {
    size_t files = 0;
    bool together = false;
    for (skip_space(s); s->at < s->end; skip_space(s)) {
        if (together) return fail(s, "goes on behind the facts of all files together");
        if (!take_object(s, found)) return false;
        together = !found->of_file;
        files += found->of_file;
        if (together && files > 0 && found->value[FILES] != (double)files)
            return fail(s, "has the facts of fewer or more files than it says");
    }
    if (!files && !together) return fail(s, "is empty");
    if (!together && found->has[OF]) return fail(s, "has not the facts of all files that it was made of");
    return together || files == 1 || fail(s, "has the facts of several files, but not of all together");
}

/* What is wrong with them, or NULL. */
static const char *shot_of(const object *found, hdr_shot *shot) {
    const double *value = found->value;
    double lit = value[LIT];
    *shot = (hdr_shot){.given = true,
                       .lit = lit > 0,
                       .log_average = value[LOG_AVERAGE],
                       .max_luminance = value[MAX_LUMINANCE],
                       .low = value[LOW],
                       .high = value[HIGH]};
    /* where nothing is lit, the greatest luminance may well be below 0 */
    if (!shot->lit && shot->max_luminance < 0) shot->max_luminance = 0;
    if (!(lit >= 0 && lit <= value[PIXELS] && isfinite(value[PIXELS])))
        return "contradicts itself: not so many pixels can be lit";
    return hdr_shot_fault(shot);
}

hdr_status hdr_shot_read(const char *json, size_t size, hdr_shot *shot, hdr_error *err) {
    scanner s = {.at = json, .end = json + size};
    object found;
    *shot = (hdr_shot){.given = false};
    const char *fault = take_all(&s, &found) ? shot_of(&found, shot) : s.fault;
    if (!fault) return HDR_OK;
    *shot = (hdr_shot){.given = false};
    return hdr_fail(err, HDR_BAD_DATA, "%s: make it with 'hdr stats --json', of all frames at once", fault);
}

/* ---- Files ---- */

/* All bytes of an input, which may be a pipe. */
static hdr_status read_all(hdr_input *input, hdr_bytes *bytes, hdr_error *err) {
    for (;;) {
        hdr_status status = hdr_bytes_reserve(bytes, bytes->size + FILE_STEP, err);
        if (status) return status;
        int64_t count = hdr_input_read(input, bytes->data + bytes->size, FILE_STEP, bytes->size, err);
        if (count < 0) return HDR_IO;
        bytes->size += (size_t)count;
        if ((size_t)count < FILE_STEP) return HDR_OK;
        if (bytes->size > FILE_MAX)
            return hdr_fail(err, HDR_BAD_DATA, "%s is larger than what 'hdr stats --json' prints",
                            hdr_input_name(input));
    }
}

hdr_status hdr_shot_load(const char *name, hdr_shot *shot, hdr_error *err) {
    hdr_error own = {0};
    hdr_bytes bytes = {0};
    hdr_input *input = hdr_input_open(name, &own);
    hdr_status status = input ? read_all(input, &bytes, &own) : own.status;
    if (!status) {
        hdr_error fault = {0};
        status = hdr_shot_read((const char *)bytes.data, bytes.size, shot, &fault);
        if (status) hdr_fail(&own, status, "%s %s", hdr_input_name(input), fault.message);
    }
    free(bytes.data);
    hdr_input_free(input);
    return status ? hdr_fail(err, status, "%s", own.message) : HDR_OK;
}

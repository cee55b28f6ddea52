/* The head: a chain as text in front of a picture's bytes. hdrpipe(5) describes it. */
#include "chain/chain.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MAGIC "hdrpipe "
#define VERSION "1"
#define HEAD_MAX 65536
#define WORDS_MAX 4096

/* ---- Writing ---- */

/* Appends the reading options that travel. Flags among them say how the work is done, not what comes out. */
static hdr_status print_reading(const hdr_chain *chain, bool flags, hdr_bytes *out, hdr_error *err) {
    hdr_status status = HDR_OK;
    for (int i = 0; i < chain->common_given.count && !status; i++) {
        hdr_given *given = &chain->common_given.given[i];
        if (given->option->travels && (flags || given->option->type != HDR_OPTION_FLAG))
            status = hdr_options_print(&(hdr_options){.given = given, .count = 1}, out, err);
    }
    return status;
}

static hdr_status print_clause(const hdr_clause *clause, const char *before, hdr_bytes *out, hdr_error *err) {
    hdr_status status = hdr_bytes_printf(out, err, "%s%s", before, clause->verb->about.name);
    return status ? status : hdr_options_print(&clause->given, out, err);
}

/* The chain's own lines: reading options, then the clauses. */
static hdr_status print_lines(const hdr_chain *chain, hdr_bytes *out, hdr_error *err) {
    hdr_bytes reading = {0};
    hdr_status status = print_reading(chain, true, &reading, err);
    if (!status && reading.size)
        status = hdr_bytes_printf(out, err, "read%.*s\n", (int)reading.size, (const char *)reading.data);
    free(reading.data);
    for (int i = 0; !status && i < chain->count; i++) {
        status = print_clause(&chain->clauses[i], "then ", out, err);
        if (!status) status = hdr_bytes_printf(out, err, "\n");
    }
    return status;
}

hdr_status hdr_chain_print(const hdr_chain *chain, hdr_bytes *out, hdr_error *err) {
    hdr_status status = HDR_OK;
    for (int i = 0; !status && i < chain->count; i++) {
        status = print_clause(&chain->clauses[i], i ? " then " : "", out, err);
        if (!status && i == 0) status = print_reading(chain, false, out, err);
    }
    return status;
}

static hdr_status write_all(int descriptor, const void *data, size_t size, hdr_error *err) {
    const char *bytes = data;
    while (size > 0) {
        ssize_t written = write(descriptor, bytes, size);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return hdr_fail(err, HDR_IO, "cannot write: %s", strerror(errno));
        bytes += written;
        size -= (size_t)written;
    }
    return HDR_OK;
}

hdr_status hdr_chain_defer(hdr_chain *chain, hdr_input *input, int descriptor, hdr_error *err) {
    const hdr_verb_about *last = hdr_chain_last(chain);
    if (!last || last->kind != HDR_FILTER)
        return hdr_fail(err, HDR_USAGE, "only a chain of filters can be handed on through a pipe");
    for (int i = 1; i <= chain->count; i++)
        if (hdr_chain_clause(chain, i)->stays)
            return hdr_fail(err, HDR_USAGE, "%s cannot be handed on through a pipe, but only what it makes",
                            hdr_chain_clause(chain, i)->name);
    hdr_bytes text = {0};
    hdr_chain *whole = hdr_chain_behind_head(chain, input, err);
    hdr_status status = whole ? HDR_OK : err ? err->status : HDR_BAD_DATA;
    if (!status)
        status = hdr_bytes_printf(&text, err,
                                  MAGIC VERSION
                                  "\n# not pixels yet: end the pipe with hdr-png, hdr-exr, ..., or set HDR_DEFER=0\n");
    if (!status) status = print_lines(whole, &text, err);
    if (!status) status = hdr_bytes_printf(&text, err, "\n");
    if (!status && text.size > HEAD_MAX)
        status = hdr_fail(err, HDR_USAGE, "the chain is too long for a pipe's head (64 KiB)");
    if (!status) status = write_all(descriptor, text.data, text.size, err);
    if (!status) status = hdr_input_forward(input, descriptor, err);
    free(text.data);
    hdr_chain_free(whole);
    return status;
}

/* ---- Reading ---- */

static int hex_digit(unsigned char byte) {
    return byte >= '0' && byte <= '9' ? byte - '0' : byte >= 'A' && byte <= 'F' ? byte - 'A' + 10 : -1;
}

/* Splits a line into its words, in place, with %XX resolved. The words are as strict as a command line: one space
 * between them, no byte that ought to have been escaped. -1: not so. */
static int split_words(char *line, const char *word[], int room) {
    int count = 0;
    char *from = line, *to = line;
    for (;;) {
        if (count == room) return -1;
        word[count++] = to;
        char *start = to;
        for (; *from && *from != ' '; from++) {
            int high = *from == '%' ? hex_digit((unsigned char)from[1]) : 0;
            int low = *from == '%' && high >= 0 ? hex_digit((unsigned char)from[2]) : 0;
            if (high < 0 || low < 0 || (*from != '%' && !hdr_plain_in_head((unsigned char)*from))) return -1;
            char byte = *from == '%' ? (char)(high * 16 + low) : *from;
            if (!byte) return -1;
            if (*from == '%') from += 2;
            *to++ = byte;
        }
        if (to == start && count > 1) return -1;
        char end = *from++;
        *to++ = '\0';
        if (!end) return count;
    }
}

/* One line of the head. */
static hdr_status read_line(hdr_chain *chain, char *line, int number, bool *reading, hdr_error *err) {
    static const char read_word[] = "read", then_word[] = "then";
    const char *word[WORDS_MAX];
    hdr_error own = {0};
    int count = split_words(line, word, WORDS_MAX);
    if (count >= 2 && !strcmp(word[0], read_word) && chain->count == 0 && !*reading) {
        *reading = true; /* at most one such line, in front of the clauses */
        hdr_chain_add_reading(chain, word + 1, count - 1, &own);
    } else if (count >= 2 && !strcmp(word[0], then_word)) {
        const hdr_verb *verb = hdr_verb_find(word[1]);
        if (!verb)
            hdr_fail(&own, HDR_BAD_DATA,
                     "unknown verb '%.100s': the hdr-%.100s that wrote it is newer than this program (%s)", word[1],
                     word[1], HDRPIPE_VERSION);
        else if (verb->about.kind != HDR_FILTER)
            hdr_fail(&own, HDR_BAD_DATA, "%s is no filter", word[1]);
        else if (verb->about.stays)
            hdr_fail(&own, HDR_BAD_DATA, "%s cannot come through a pipe, but only what it makes", word[1]);
        else
            hdr_chain_add_clause(chain, word + 1, count - 1, &own);
    } else {
        hdr_fail(&own, HDR_BAD_DATA, "this line is neither 'read' nor 'then' in its proper form");
    }
    if (!own.status) return HDR_OK;
    return hdr_fail(err, HDR_BAD_DATA, "the pipe's head, line %d: %s", number, own.message);
}

/* All lines of text, which ends with a newline. first: the number of its first line. */
static hdr_status read_lines(hdr_chain *chain, char *text, int first, hdr_error *err) {
    int number = first;
    bool reading = false;
    while (*text) {
        char *end = strchr(text, '\n');
        *end = '\0';
        hdr_status status = *text == '#' ? HDR_OK : read_line(chain, text, number, &reading, err);
        if (status) return status;
        text = end + 1;
        number++;
    }
    return HDR_OK;
}

/* Bytes of the head, its empty line included; 0: there is none; -1: there is one and it is no good. */
static int64_t head_length(const char *text, size_t size, hdr_error *err) {
    if (size < strlen(MAGIC) || memcmp(text, MAGIC, strlen(MAGIC))) return 0;
    static const char first_line[] = MAGIC VERSION "\n";
    if (size < sizeof first_line - 1 || memcmp(text, first_line, sizeof first_line - 1)) {
        int length = (int)strcspn(text + strlen(MAGIC), "\n");
        hdr_fail(err, HDR_BAD_DATA,
                 "the pipe's head is of version '%.*s': a newer hdrpipe wrote it; this one (%s) reads version " VERSION,
                 length > 20 ? 20 : length, text + strlen(MAGIC), HDRPIPE_VERSION);
        return -1;
    }
    const char *end = strstr(text, "\n\n");
    if (!end) {
        hdr_fail(err, HDR_BAD_DATA,
                 size < HEAD_MAX ? "the pipe's head is cut off" : "the pipe's head has no end within 64 KiB");
        return -1;
    }
    return end + 2 - text;
}

/* The head's text behind its first line, without the empty line; an empty string where there is no head. Free it. */
static char *take_head(hdr_input *input, hdr_error *err) {
    char *text = hdr_alloc(HEAD_MAX + 1, 1);
    if (!text) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        return NULL;
    }
    hdr_error own = {0};
    hdr_input_skip(input, 0); /* an input that was read before may be read again */
    int64_t length = hdr_input_has_bytes(input) ? hdr_input_read(input, text, strlen(MAGIC), 0, err) : 0;
    if (length == (int64_t)strlen(MAGIC) && !memcmp(text, MAGIC, strlen(MAGIC)))
        length = hdr_input_read(input, text, HEAD_MAX, 0, err);
    if (length >= 0) length = head_length(text, (size_t)length, &own);
    if (length < 0) {
        if (own.status) hdr_fail(err, own.status, "%s: %s", hdr_input_name(input), own.message);
        free(text);
        return NULL;
    }
    size_t first_line = length ? strlen(MAGIC VERSION "\n") : 0;
    size_t rest = length ? (size_t)length - 1 - first_line : 0;
    memmove(text, text + first_line, rest);
    text[rest] = '\0';
    hdr_input_skip(input, (uint64_t)length);
    return text;
}

/* ---- Both together ---- */

#define GIVEN_MAX 64 /* more options than any table has */

/* The clauses and travelling options of one chain, added to another from the words they were made of. */
static hdr_status append_chain(hdr_chain *whole, const hdr_chain *chain, hdr_error *err) {
    char names[GIVEN_MAX][80];
    const char *words[1 + 2 * GIVEN_MAX];
    for (int i = -1; i < chain->count; i++) { /* -1: the common options */
        const hdr_options *options = i < 0 ? &chain->common_given : &chain->clauses[i].given;
        int count = 0;
        if (i >= 0) words[count++] = chain->clauses[i].verb->about.name;
        for (int g = 0; g < options->count && g < GIVEN_MAX; g++) {
            const hdr_given *given = &options->given[g];
            if (i < 0 && !given->option->travels) continue;
            snprintf(names[g], sizeof names[g], "--%s", given->option->name);
            words[count++] = names[g];
            if (given->text) words[count++] = given->text;
        }
        hdr_status status =
            i < 0 ? hdr_chain_add_reading(whole, words, count, err) : hdr_chain_add_clause(whole, words, count, err);
        if (status) return status;
    }
    return HDR_OK;
}

hdr_chain *hdr_chain_behind_head(const hdr_chain *chain, hdr_input *input, hdr_error *err) {
    hdr_error own = {0};
    char *head = take_head(input, err);
    hdr_chain *whole = head ? hdr_chain_new(err) : NULL;
    if (!whole) goto fail;
    if (read_lines(whole, head, 2, &own)) {
        hdr_fail_in(&own, hdr_input_name(input));
        hdr_fail(err, own.status, "%s", own.message);
        goto fail;
    }
    if (append_chain(whole, chain, err) || hdr_chain_add_local(whole, chain, err)) goto fail;
    free(head);
    return whole;
fail:
    free(head);
    hdr_chain_free(whole);
    return NULL;
}

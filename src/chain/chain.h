/* A chain: clauses in order, and the options common to all. Held as work until somebody needs pixels. */
#ifndef HDR_CHAIN_H
#define HDR_CHAIN_H

#include "base/pool.h"
#include "io/source.h"
#include "verb/verb.h"

typedef struct hdr_clause {
    const hdr_verb *verb;
    void *params;
    hdr_options given; /* the words it was made of */
} hdr_clause;

/* What becomes of the alpha channel. */
typedef struct hdr_alpha {
    enum { HDR_ALPHA_KEEP, HDR_ALPHA_DROP, HDR_ALPHA_OVER } how;
    double colour[3]; /* over: what lies under the picture, linear */
} hdr_alpha;

/* Values of the common options. */
typedef struct hdr_common {
    hdr_number threads, memory;
    const char *output;
    bool quiet, verbose, explain, json, help, version, reference, no_skip, strict;
    int window, primaries, adapt;
    const char *part, *layer, *channel, *level,
        *crop;              /* how the file is read, as typed; NULL: not given, level is "0" then */
    const char *alpha_text; /* as it was typed */
    hdr_alpha alpha;        /* and what it says */
} hdr_common;
enum { HDR_WINDOW_DISPLAY, HDR_WINDOW_DATA };
enum { HDR_PRIMARIES_REC709, HDR_PRIMARIES_KEEP };
enum { HDR_ADAPT_BRADFORD, HDR_ADAPT_NONE };

struct hdr_chain {
    hdr_clause leader; /* the program in front; verb is NULL where there is none */
    hdr_clause *clauses;
    int count;
    hdr_common common;
    hdr_options common_given;
    hdr_settings settings;   /* what the public header shows of `common` */
    uint64_t machine_memory; /* what the automatic settings are, asked of the system once; 0: not yet */
    int machine_cores;
    const char **files; /* operands, NULL-ended */
    int file_count;
};

/* ---- parse.c ---- */

/* One clause as in the head: the verb and its own options by their long names, nothing else. */
hdr_status hdr_chain_add_clause(hdr_chain *chain, const char *const words[], int count, hdr_error *err);

/* Common options alone, as in the head's read line. What an earlier program gave already may be given again if it says
 * the same. */
hdr_status hdr_chain_add_reading(hdr_chain *chain, const char *const words[], int count, hdr_error *err);

/* Adds the clauses that options of the last one stand for, in the place of these options. */
hdr_status hdr_chain_spell_out(hdr_chain *chain, hdr_error *err);

/* The common options that do not travel, as chain has them: they stay with the program they were given to. */
hdr_status hdr_chain_add_local(hdr_chain *whole, const hdr_chain *chain, hdr_error *err);

/* ---- vary.c ---- */

/* Like hdr_chain_new_like, for pixels of the file itself: its data window, whatever is written else, and colour as it
 * is stored, without alpha, unless it is laid over another one. */
hdr_chain *hdr_chain_new_viewing(const hdr_chain *other, hdr_error *err);

/* ---- guided.c ---- */

/* The clause that filters by a second picture, which stands in front or behind a join; NULL: there is none. */
const hdr_clause *hdr_chain_guided(const hdr_chain *chain);

/* Opens the second picture, where there is such a clause: before the first, as whoever waits for a pipe should not wait
 * in vain. */
hdr_status hdr_guide_open(const hdr_chain *chain, hdr_input **guide, hdr_error *err);

/* ---- reading.c ---- */

/* Whether a common option's text, which has been stored, says what it ought to: levels and rectangles have a form of
 * their own, and a name is not empty. NULL: it does; else what is wrong with it. */
const char *hdr_common_fault(const hdr_common *common, const hdr_option *option);

/* How the chain's file is to be read. The strings belong to the chain. */
hdr_reading hdr_chain_reading(const hdr_chain *chain);

/* Hands a fault on, with the input's name in front, unless the message begins with that or with the guide's, where
 * there is one, or the fault is none of the input's. */
hdr_status hdr_fail_of_input(hdr_error *err, const hdr_error *own, const hdr_input *input, const hdr_input *guide);

/* ---- head.c ---- */

/* Reads the head in front of the input, if there is one, tells the input where the picture begins, and makes the chain
 * that is to be run: the head's clauses, then this chain's, with this chain's settings. HDR_BAD_DATA: no valid head. */
hdr_chain *hdr_chain_behind_head(const hdr_chain *chain, hdr_input *input, hdr_error *err);

/* Appends the chain in one line, as a command line has it, in the head's words: what makes the picture, and not how. */
hdr_status hdr_chain_print(const hdr_chain *chain, hdr_bytes *out, hdr_error *err);

/* ---- Messages ---- */

void hdr_say(const hdr_listener *listener, hdr_message kind, const char *format, ...) HDR_PRINTF(3, 4);

#endif

/* A run: a chain, a source, and what is known of the scene so far. Sweeps are made of it. */
#ifndef HDR_RUN_H
#define HDR_RUN_H

#include "chain/chain.h"
#include "chain/steps.h"
#include "picture/picture.h"

#include <stdatomic.h>

/* What is known of the stored pixels as a whole. Until a sweep has seen all of them it is assumed; each sweep verifies
 * what it assumes, stops at the first pixel that contradicts, and is made again. */
typedef struct hdr_raw {
    bool certain;
    bool grey;   /* one plane, or R = G = B bit for bit after repair */
    bool opaque; /* no alpha, or 1 everywhere */
    bool replacements_known;
    double replacement[4]; /* what +Inf becomes: the channel's largest finite value, at least 0 */
    uint64_t nan, positive_infinity, negative_infinity;
} hdr_raw;

/* What one thread has met in the sweep under way. */
typedef struct hdr_watch {
    bool colour, translucent, infinity;
    uint64_t hidden; /* pixels that have a colour where alpha is 0, in what is written */
    double largest;  /* component of what is written, where that is watched: at least 0 */
    uint64_t nan, positive_infinity, negative_infinity;
} hdr_watch;

typedef struct hdr_thread {
    void *worker;      /* of the source */
    hdr_strip *strip;  /* 64-byte aligned */
    double largest[4]; /* sweep for replacements: largest finite value of each channel */
    hdr_watch watch;
    void *packer;           /* of the sink */
    unsigned char *samples; /* a band */
} hdr_thread;

/* What somebody wants to see of the surround of the chain's last clause. */
typedef struct hdr_look {
    const hdr_pixel *pixels; /* or NULL: all */
    int count;
    hdr_surround *seen; /* to be filled */
} hdr_look;

typedef struct hdr_run {
    const hdr_chain *chain;
    hdr_look *look; /* or NULL */
    hdr_settings settings;
    const hdr_listener *listener;
    hdr_input *input;
    const char *name; /* the input's */
    hdr_source *source;
    hdr_source *joined; /* the source itself, or what it smooths; NULL: the chain joins nothing */
    bool guided;        /* the source smooths */
    hdr_pool *pool;
    hdr_thread *threads;
    int thread_count;
    hdr_raw raw;
    hdr_step *steps; /* those resolved so far, skipped ones left out */
    int step_count;
    bool mapped;           /* by a step that makes three planes of any, with primaries of its own */
    bool scene_light;      /* what the steps make is a scene's light, without bounds, or the code of it */
    int light_steps;       /* the steps in front of the first that encodes; -1: none does */
    hdr_legend legend;     /* of the last step that has one */
    double cut;            /* the largest component of such light that was cut to a code; 0: none was */
    hdr_plane **surrounds; /* of the steps that have one */
    int surround_count;
    double weights[3];  /* of luminance where the steps end */
    const double *over; /* the colour under the picture, NULL: none; its alpha, if it has one, is used up in reading */
    bool coloured;      /* that colour is no grey */
    bool spread;        /* one plane is stored, and three are made of it */
    int sweeps;         /* made so far */
    /* Decoded blocks that are kept for the next sweep, in their stored type; kept == NULL: they are decoded again. */
    unsigned char *kept;
    size_t kept_size, kept_row; /* kept_row: bytes of a row of all channels that are read */
    atomic_uchar *kept_state;   /* of each block: empty, being filled, whole */
    unsigned char *looked_at;   /* the block that was looked at to guess, or NULL */
    int looked_at_block;
} hdr_run;

/* Opens everything: head, source, pool. Free with hdr_run_close in any case; the chain is the one behind the head.
 * guide: the second picture of a chain that filters by one, else NULL. */
hdr_status hdr_run_open(hdr_run *run, const hdr_chain *chain, hdr_input *input, hdr_input *guide,
                        const hdr_listener *listener, hdr_error *err);
void hdr_run_close(hdr_run *run);

/* From now on decoded blocks are kept, if they fit in --memory: another sweep will come. */
void hdr_run_keep(hdr_run *run);

/* A block, from memory or decoded. */
hdr_status hdr_run_read(hdr_run *run, int thread, int block, hdr_block *out, hdr_error *err);

/* Reads count pixels from x on of a block's row (counted from the block's first) into the thread's strip: repaired,
 * straight colour, one plane where the picture is taken for grey and `reduce` is set. alpha: fill the strip's alpha.
 * False: the pixels contradict what is assumed; the sweep has been stopped. */
bool hdr_run_load(hdr_run *run, int thread, const hdr_block *block, int row, int x, size_t count, bool reduce,
                  bool alpha);

/* How a sweep is made: `before` is called in front of each attempt and tells how many items there are; then job for
 * each. */
typedef struct hdr_sweep {
    hdr_status (*before)(void *context, int *items, hdr_error *err);
    hdr_job job;
    void *context;
    bool grey_matters, alpha_matters; /* what it makes depends on the one being so or not, not only on values */
    bool partial; /* it does not look at all pixels: what matters is certain already, and no more is learnt */
} hdr_sweep;

/* Makes a sweep, again if what it assumed turns out not to hold. The first that comes to its end makes the raw facts
 * certain. */
hdr_status hdr_run_sweep(hdr_run *run, const hdr_sweep *sweep, hdr_error *err);

/* The facts of what the steps make of the picture. together: a taking of several pictures with the same request, in its
 * first sweep, which this one is added to; NULL: none. plane: filled where the request asks for it; of the data
 * window's size. */
hdr_status hdr_run_facts(hdr_run *run, const hdr_request *request, hdr_taking *together, hdr_plane *plane,
                         hdr_facts *facts, hdr_error *err);

/* The picture's part of the sweep that such a taking has under way. */
hdr_status hdr_run_take(hdr_run *run, hdr_taking *taking, hdr_error *err);

/* Of a clock that only goes forward. */
double hdr_milliseconds(void);

/* Looks at one block in the middle to assume what is likely. Where it does not matter, a picture is not taken for grey.
 */
hdr_status hdr_run_guess(hdr_run *run, bool grey_matters, hdr_error *err);

/* ---- guided.c ---- */

/* The source filtered by the second picture, if the chain says so. It is taken over in any case; NULL: err is filled.
 */
hdr_source *hdr_run_guide(hdr_run *run, hdr_source *source, hdr_input *guide, hdr_error *err);

/* What the numbers are that joining files, and filtering by a second picture, have made. False: neither was done, or
 * something else behind it. */
bool hdr_run_meaning(const hdr_run *run, char *text, size_t size);

/* What was filtered, said once, and what was wrong with the second picture: HDR_BAD_DATA with --strict. */
hdr_status hdr_run_report_guided(const hdr_run *run, hdr_error *err);

/* ---- plan.c ---- */

/* What is done with a chain of filters once it is planned. state: what the pixels are; converted: the primaries are
 * Rec.709's now. */
typedef hdr_status (*hdr_use)(hdr_run *run, const char *state, bool converted, void *context, hdr_error *err);

/* Plans the chain, behind the input's head, and calls `use`. */
hdr_status hdr_chain_use(hdr_chain *chain, hdr_input *input, const hdr_listener *listener, hdr_use use, void *context,
                         hdr_error *err);

/* Plans the chain, and nothing else, with a look at the surround of its last clause. */
hdr_status hdr_chain_look(hdr_chain *chain, hdr_input *input, const hdr_listener *listener, hdr_look *look,
                          hdr_error *err);

/* ---- surround.c ---- */

/* Before the surround is computed, and after: what is seen of it. */
hdr_status hdr_look_before(const hdr_look *look, hdr_surroundings *with, hdr_error *err);
hdr_status hdr_look_after(const hdr_look *look, const hdr_surroundings *with, double milliseconds, hdr_error *err);

/* ---- alpha.c ---- */

/* Makes the source's picture what --alpha says. HDR_BAD_DATA: it cannot be laid over a colour. */
hdr_status hdr_run_choose_alpha(hdr_run *run, hdr_error *err);

/* A picture of luminance alone becomes one of R, G, B, which are equal until a colour is laid under it, or it is mapped
 * to one. */
void hdr_run_spread(hdr_run *run);

/* Whether the picture that is written has pixels outside the data window. */
bool hdr_run_has_border(const hdr_run *run);

/* ---- write.c ---- */

/* Makes the sweep that writes. params: the format's. converted: the primaries are Rec.709's now. */
hdr_status hdr_run_write(hdr_run *run, const hdr_verb *format, const void *params, hdr_output *output,
                         const char *state, int bits, bool converted, hdr_error *err);

#endif

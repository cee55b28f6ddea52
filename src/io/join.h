/* Several pictures of one form that become one, number by number: the mean of renders, the difference of two. A source
 * like any other, whose blocks are made of the others' while they are warm; no picture is ever held as a whole. */
#ifndef HDR_JOIN_H
#define HDR_JOIN_H

#include "io/source.h"
#include "kernel/strip.h"

/* How numbers that have the same place in each picture are joined. state: `slots` rows of HDR_STRIP doubles, cleared
 * beforehand; values: one channel of picture 0, then of picture 1, ..., NaN and infinities among them, as stored: alpha
 * is associated. count <= HDR_STRIP. */
typedef struct hdr_joining {
    const void *params;
    int pictures;
    int slots;
    bool alpha;      /* that is joined, too; else the result has none */
    double *weights; /* of each picture, or NULL: all count alike; the source frees them */
    void (*add)(const struct hdr_joining *joining, int picture, const double *values, double *state, size_t count);
    void (*end)(const struct hdr_joining *joining, const double *state, double *out, size_t count);
} hdr_joining;

/* The picture that the members of a joined input become. It is float; all that is not numbers it has from the first.
 * It takes the weights over, in any case. HDR_BAD_DATA: they are not of one form. */
hdr_source *hdr_join_open(hdr_input *input, const hdr_reading *reading, const hdr_joining *joining, hdr_error *err);

/* Components that were neither finite nor counted, of all blocks read so far, each once. */
uint64_t hdr_join_left_out(const hdr_source *source);

#endif

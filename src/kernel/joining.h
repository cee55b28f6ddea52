/* Several pictures that become one, number by number. */
#ifndef HDR_JOINING_H
#define HDR_JOINING_H

#include "kernel/strip.h"

#define HDR_MOST_WEIGHT 1e30 /* what a picture may count */

/* How numbers that have the same place in each picture are joined. state: `slots` rows of HDR_STRIP doubles, cleared
 * beforehand; values: one channel of picture 0, then of picture 1, ..., NaN and infinities among them, as stored: alpha
 * is associated. count <= HDR_STRIP. */
typedef struct hdr_joining {
    const void *params;
    int pictures;
    int slots;
    bool alpha;               /* that is joined, too; else the result has none */
    double *weights;          /* of each picture, or NULL: all count alike; who made this record frees them */
    char meaning[120];        /* what the result's numbers are: "mean of 8 renders" */
    const char *weights_from; /* the header's attribute that has them: who opens the pictures fills weights; or NULL */
    void (*add)(const struct hdr_joining *joining, int picture, const double *values, double *state, size_t count);
    void (*end)(const struct hdr_joining *joining, const double *state, double *out, size_t count);
} hdr_joining;

#endif

/* Facts: numbers about a scene that verbs plan with. They are taken row by row and merged in the order of the rows, so
 * they do not depend on threads, blocks or the order of completion. */
#ifndef HDR_FACTS_H
#define HDR_FACTS_H

#include "base/options.h"

enum {
    HDR_FACT_COMPONENTS = 1, /* min, max and smallest positive of the colour components */
    HDR_FACT_LUMINANCE = 2,  /* min, max and smallest positive Y, lit pixels, log-average */
    HDR_FACT_CHANNELS =
        4, /* min and max of each channel, alpha included; negative components, pixels with colour that are not lit */
    HDR_FACT_SHIFTED = 8, /* log-average of Y + shift over all pixels */
};

/* Of which values a percentile is taken. Luminances are rounded to float32 for it, components are not. */
typedef enum hdr_population {
    HDR_OF_COMPONENTS, /* all colour components */
    HDR_OF_LUMINANCE,  /* Y of all pixels */
    HDR_OF_LIT,        /* Y of lit pixels, held to at least 2^-149 */
    HDR_POPULATIONS
} hdr_population;

#define HDR_MAX_PERCENTILES 10

/* What a verb, or stats, asks for. */
typedef struct hdr_request {
    unsigned facts;        /* HDR_FACT_... */
    double shift;          /* HDR_FACT_SHIFTED: above 0 */
    bool plane;            /* Y of every pixel by itself, 0 where it is not lit */
    const double *weights; /* what stands for Y in HDR_FACT_LUMINANCE and the plane, where Y is lit; NULL: Y */
    int percentiles;
    struct {
        hdr_population of;
        hdr_decimal percent;
    } percentile[HDR_MAX_PERCENTILES];
} hdr_request;

/* What was found; fields are valid where `known` has their bit. */
typedef struct hdr_facts {
    unsigned known;
    uint64_t pixels, lit;
    double min_component, max_component, min_positive_component; /* the last: 0 when none is positive */
    double min_luminance, max_luminance, min_lit;                /* min_lit: 0 when nothing is lit */
    double log_average;                        /* exp(mean ln Y) over lit pixels; 0 when nothing is lit */
    double shift, shifted_average;             /* exp(mean ln(shift + max(Y, 0))) over all pixels */
    double channel_min[4], channel_max[4];     /* R G B (or Y) and, in [3], alpha */
    uint64_t negative, unlit_colour, coloured; /* coloured: pixels whose components are not all equal */
    double percentile[HDR_MAX_PERCENTILES];    /* in the order of the request; 0 for an empty population */
} hdr_facts;

/* A taking of facts: one sweep over all rows of the data window; two where percentiles are asked for, four for those of
 * components, unless all components are float32 values (float_components). It may span several pictures: each sweep
 * then goes over every one of them, and the facts are of all together. */
typedef struct hdr_taking hdr_taking;
hdr_taking *hdr_taking_new(const hdr_request *request, int threads, bool float_components, hdr_error *err);
void hdr_taking_free(hdr_taking *taking);

/* A picture's turn in the sweep under way; it has that many rows. When its part of the sweep is broken off and made
 * again, this comes again: what was taken of it is forgotten, and of no other. */
hdr_status hdr_taking_begin(hdr_taking *taking, int height, hdr_error *err);

/* A strip of a row: its pixels after all steps before the clause. The strips of a row come from left to right on one
 * thread; all but the last have a multiple of 8 pixels. y: luminance. alpha may be NULL; planes 1 or 3. */
void hdr_taking_strip(hdr_taking *taking, int thread, const double *const c[3], int planes, const double *y,
                      const double *alpha, size_t count);
void hdr_taking_row_end(hdr_taking *taking, int thread, int row);

/* All rows of the picture have been taken in this sweep. */
void hdr_taking_end(hdr_taking *taking);

/* Adds what another taking with the same request has found in its first sweep, before that goes on to the next, to the
 * first sweep of this one: the picture need not be swept over for both. Not for percentiles of components. */
void hdr_taking_join(hdr_taking *taking, const hdr_taking *other);

/* After each sweep. True: another is needed. Then false, and the facts are complete. */
bool hdr_taking_next(hdr_taking *taking, hdr_facts *facts);

/* Whether a sweep has met other pixels than the one before, so that the facts are worth nothing: a file has changed
 * meanwhile. It may go unnoticed. */
bool hdr_taking_contradicted(const hdr_taking *taking);

/* Puts the numbers of a shot in place of those of a picture. min_luminance and min_lit, which it does not have, become
 * 0. False: the request is for others than it has. */
bool hdr_facts_of_shot(const hdr_shot *shot, const hdr_request *request, hdr_facts *facts);

#endif

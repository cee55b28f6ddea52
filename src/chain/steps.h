/* Steps applied to a strip. */
#ifndef HDR_STEPS_H
#define HDR_STEPS_H

#include "kernel/codes.h"
#include "kernel/strip.h"
#include "verb/verb.h"

/* A piece of a row in flight. alpha is meaningful where the run has use for it. */
typedef struct hdr_strip {
    double c[3][HDR_STRIP];
    double alpha[HDR_STRIP];
    double y[HDR_STRIP], ld[HDR_STRIP]; /* room for luminance forms */
    double beside[HDR_STRIP];           /* room for formulas of two numbers: surrounds, thresholds */
    int planes;
    size_t count;
    int row, x;           /* of its first pixel in the data window; row -1: the pixels lie outside */
    int place_x, place_y; /* the same in the file's coordinates, wherever it lies */
    bool failed;          /* a mapper has failed, in this strip or another that this room was used for */
} hdr_strip;

/* Y of the strip's pixels into strip->y. */
void hdr_strip_luminance(hdr_strip *strip, const double weights[3]);

/* The same of other weights, of pixels whose Y is above 0; of others 0. */
void hdr_strip_intensity(hdr_strip *strip, const double weights[3], const double lit[3]);

/* Applies steps[first ... end-1]. reference: value by value, through `exact` alone. */
void hdr_strip_apply(hdr_strip *strip, const hdr_step *steps, int first, int end, bool reference);

/* The first of the steps that close the chain and work on each channel by itself. */
int hdr_steps_tail(const hdr_step *steps, int count);

/* Thresholds of the 8-bit code that the steps and rounding to 255 make of a number. False if the steps cannot be held
 * so. */
bool hdr_steps_tabulate(const hdr_step *steps, int count, hdr_code_table *table);

#endif

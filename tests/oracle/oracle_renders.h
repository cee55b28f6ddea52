/* For tests of several pictures: renders in memory, and inputs of them. */
#ifndef HDR_TESTS_ORACLE_RENDERS_H
#define HDR_TESTS_ORACLE_RENDERS_H

#include "hdrpipe.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

static uint64_t random_state = 1;

static double random_unit(void) {
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    uint64_t bits = random_state ^ random_state >> 29;
    return (double)(bits >> 11) * 0x1p-53;
}

enum { MOST = 64 };

/* Several pictures of the same form; plane p of picture i is numbers[i] + p * pixels. */
typedef struct pictures {
    int width, height, planes, count;
    float *numbers[MOST];
} pictures;

static size_t pixels_of(const pictures *p) {
    return (size_t)p->width * (size_t)p->height;
}

typedef double (*maker)(int picture, size_t at);

static pictures make_pictures(int width, int height, int planes, int count, maker make) {
    pictures p = {width, height, planes, count, {NULL}};
    size_t numbers = pixels_of(&p) * (size_t)planes;
    for (int i = 0; i < count; i++) {
        p.numbers[i] = malloc(numbers * sizeof(float));
        if (!p.numbers[i]) abort();
        for (size_t n = 0; n < numbers; n++)
            p.numbers[i][n] = (float)make(i, n);
    }
    return p;
}

static void free_pictures(pictures *p) {
    for (int i = 0; i < p->count; i++)
        free(p->numbers[i]);
}

static hdr_input *open_picture(const pictures *p, int i) {
    const float *plane[3] = {p->numbers[i], p->numbers[i] + pixels_of(p), p->numbers[i] + 2 * pixels_of(p)};
    hdr_error error = {0};
    hdr_input *input = hdr_input_planes(p->width, p->height, p->planes, plane, NULL, &error);
    if (!input) abort();
    return input;
}

#endif

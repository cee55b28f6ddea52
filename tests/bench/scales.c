/* scales: what the local photographic operator costs a pixel, Gaussian by Gaussian, on a plane of 3840 x 2160 numbers,
 * on one thread and with nothing left out; and all of them together with what the plane does not need left out.
 * Medians. */
#include "spatial/scales.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { WIDTH = 3840, HEIGHT = 2160, REPETITIONS = 7 };

static double now(void) {
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return (double)at.tv_sec * 1e9 + (double)at.tv_nsec;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Soft light and dark with edges in it, as a picture has. */
static float number(int x, int y) {
    double soft = exp(2 * sin(x / 170.0) * cos(y / 230.0));
    return (float)(x / 97 % 3 == y / 61 % 3 ? 8 * soft : soft);
}

/* Nanoseconds a pixel. */
static double measure(const hdr_scales *scales, const hdr_plane *plane, hdr_plane *surround, hdr_pool *pool,
                      hdr_scales_report *report) {
    double times[REPETITIONS];
    hdr_error error = {0};
    bool too_wide;
    for (int i = 0; i < REPETITIONS; i++) {
        double start = now();
        if (hdr_scales_surround(scales, plane, surround, NULL, pool, report, &too_wide, &error) != HDR_OK) {
            fprintf(stderr, "%s\n", error.message);
            exit(1);
        }
        times[i] = (now() - start) / ((double)WIDTH * HEIGHT);
    }
    qsort(times, REPETITIONS, sizeof *times, ascending);
    return times[REPETITIONS / 2];
}

int main(void) {
    hdr_error error = {0};
    hdr_plane *plane = hdr_plane_new(WIDTH, HEIGHT, false, &error),
              *surround = hdr_plane_new(WIDTH, HEIGHT, false, &error);
    hdr_pool *pool = hdr_pool_new(1, &error);
    if (!plane || !surround || !pool) return 1;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            plane->narrow[(size_t)y * plane->stride + (size_t)x] = number(x, y);
    hdr_scales paper = {.epsilon = 0.05, .unit = 1 / 0.18};
    double s = 1;
    for (int i = 0; i <= HDR_SCALES; i++, s *= 1.6) {
        paper.sigma[i] = s / 4;
        if (i < HDR_SCALES) paper.offset[i] = 256 / (s * s);
    }
    /* nine times the narrowest Gaussian, then one of them exchanged for another; no test ever succeeds */
    hdr_scales_report report;
    hdr_scales narrow = paper;
    narrow.no_skip = true;
    narrow.epsilon = 1e6;
    for (int i = 0; i <= HDR_SCALES; i++)
        narrow.sigma[i] = paper.sigma[0];
    double base = measure(&narrow, plane, surround, pool, &report) / (HDR_SCALES + 1);
    printf("%-10s %8s %6s %10s\n", "Gaussian", "sigma", "reach", "ns/pixel");
    for (int i = 0; i <= HDR_SCALES; i++) {
        hdr_scales one = narrow;
        one.sigma[HDR_SCALES / 2] = paper.sigma[i];
        double all = measure(&one, plane, surround, pool, &report);
        printf("%-10d %8.3f %6d %10.2f\n", i, paper.sigma[i], report.reach[HDR_SCALES / 2], all - HDR_SCALES * base);
    }
    hdr_scales whole = paper;
    whole.no_skip = true;
    printf("%-26s %10.2f\n", "all, nothing left out", measure(&whole, plane, surround, pool, &report));
    printf("%-26s %10.2f\n", "what this plane needs", measure(&paper, plane, surround, pool, &report));
    hdr_pool_free(pool);
    hdr_plane_free(plane);
    hdr_plane_free(surround);
    return 0;
}

/* hdr bench: how far results are apart. */
#include "bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Pixels ---- */

/* Steele, Lea and Flood, Fast Splittable Pseudorandom Number Generators, OOPSLA 2014: the same numbers in each run. */
static uint64_t next_random(uint64_t *state) {
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

/* What is around a pixel that is not lit is of no use to anyone. */
static bool is_lit(const hdr_surround *scene, hdr_pixel pixel) {
    return scene->luminance[(size_t)pixel.y * (size_t)scene->width + (size_t)pixel.x] > 0;
}

/* These add pixels that are lit. */
static void add_all_pixels(const hdr_surround *scene, bench_pixels *pixels) {
    for (int y = 0; y < scene->height; y++)
        for (int x = 0; x < scene->width; x++)
            if (is_lit(scene, (hdr_pixel){x, y})) pixels->pixel[pixels->count++] = (hdr_pixel){x, y};
}

/* Each as likely as any other. Vitter, Random Sampling with a Reservoir, ACM TOMS 11(1), 1985, algorithm R. */
static void add_random_pixels(const hdr_surround *scene, int count, bench_pixels *pixels) {
    uint64_t state = 1, seen = 0;
    for (int y = 0; y < scene->height; y++)
        for (int x = 0; x < scene->width; x++) {
            if (!is_lit(scene, (hdr_pixel){x, y})) continue;
            uint64_t place = seen++ < (uint64_t)count ? seen - 1 : next_random(&state) % seen;
            if (place < (uint64_t)count) pixels->pixel[place] = (hdr_pixel){x, y};
        }
    pixels->count = seen < (uint64_t)count ? (int)seen : count;
    pixels->all = seen <= (uint64_t)count;
}

/* A pixel that is brighter, or darker, than all around it, and its ratio to the nearest of them. */
typedef struct extreme {
    double by;
    hdr_pixel at;
} extreme;

/* The larger distance first; then from above, from the left. */
static int compare_extremes(const void *a, const void *b) {
    const extreme *p = a, *q = b;
    if (p->by != q->by) return p->by < q->by ? 1 : -1;
    if (p->at.y != q->at.y) return p->at.y < q->at.y ? -1 : 1;
    return (p->at.x > q->at.x) - (p->at.x < q->at.x);
}

/* What is not lit counts as the darkest that is. */
static float least_lit(const hdr_surround *scene) {
    float least = INFINITY;
    for (size_t i = 0; i < (size_t)scene->width * (size_t)scene->height; i++)
        if (scene->luminance[i] > 0) least = fminf(least, scene->luminance[i]);
    return least;
}

/* Ratio of a pixel to the nearest of its neighbours, or the other way about, whichever is above 1; 1: no extreme. */
static double stands_out(const hdr_surround *scene, int x, int y, float least) {
    float own = fmaxf(scene->luminance[(size_t)y * (size_t)scene->width + (size_t)x], least);
    float low = INFINITY, high = 0;
    for (int v = y > 0 ? y - 1 : 0; v <= y + 1 && v < scene->height; v++)
        for (int u = x > 0 ? x - 1 : 0; u <= x + 1 && u < scene->width; u++) {
            float other = fmaxf(scene->luminance[(size_t)v * (size_t)scene->width + (size_t)u], least);
            if (u == x && v == y) continue;
            low = fminf(low, other);
            high = fmaxf(high, other);
        }
    if (high > 0 && own > high) return (double)own / (double)high;
    return own < low && isfinite(low) ? (double)low / (double)own : 1;
}

/* Those that stand out most, into `kept`, which has room for twice as many. Returns how many. */
static int find_extremes(const hdr_surround *scene, int wanted, extreme *kept) {
    float least = least_lit(scene);
    int count = 0;
    for (int y = 0; y < scene->height; y++)
        for (int x = 0; x < scene->width; x++) {
            double by = stands_out(scene, x, y, least);
            if (!(by > 1) || !is_lit(scene, (hdr_pixel){x, y})) continue;
            kept[count++] = (extreme){by, {x, y}};
            if (count < 2 * wanted) continue;
            qsort(kept, (size_t)count, sizeof *kept, compare_extremes);
            count = wanted;
        }
    qsort(kept, (size_t)count, sizeof *kept, compare_extremes);
    return count < wanted ? count : wanted;
}

bool bench_choose_pixels(const hdr_surround *scene, int samples, bench_pixels *pixels, hdr_error *error) {
    size_t total = (size_t)scene->width * (size_t)scene->height;
    bool all = total <= (size_t)samples;
    extreme *kept = all ? NULL : calloc((size_t)samples, 2 * sizeof *kept);
    pixels->pixel = calloc(all ? total : 2 * (size_t)samples, sizeof *pixels->pixel);
    if (!pixels->pixel || (!all && !kept)) {
        free(kept);
        cmd_out_of_memory(error);
        return false;
    }
    *pixels = (bench_pixels){.pixel = pixels->pixel, .all = all};
    if (all)
        add_all_pixels(scene, pixels);
    else
        add_random_pixels(scene, samples, pixels);
    pixels->random = pixels->count;
    int extremes = pixels->all ? 0 : find_extremes(scene, samples, kept);
    for (int i = 0; i < extremes; i++)
        pixels->pixel[pixels->count++] = kept[i].at;
    free(kept);
    return true;
}

void bench_compare_values(const float *values, const float *exact, const bench_pixels *pixels, bench_way *way) {
    double largest = 0, squares = 0;
    for (int i = 0; i < pixels->count; i++) {
        double error = fabs((double)values[i] - (double)exact[i]);
        largest = fmax(largest, error);
        if (i < pixels->random) squares += error * error;
    }
    way->max_error = largest;
    way->rms_error = pixels->random ? sqrt(squares / pixels->random) : 0;
}

/* ---- Images ---- */

hdr_status bench_make_image(hdr_chain *chain, hdr_input *input, bench_image *image, hdr_error *error) {
    *image = (bench_image){.output = hdr_output_planes(error)};
    if (!image->output) return error->status;
    hdr_status status = hdr_chain_run(chain, input, image->output, NULL, error);
    if (status != HDR_OK) return status;
    const hdr_planes *planes = hdr_output_pixels(image->output);
    image->components = planes->planes;
    image->pixels = (size_t)planes->width * (size_t)planes->height;
    memcpy(image->plane, planes->plane, sizeof image->plane);
    return HDR_OK;
}

void bench_free_image(bench_image *image) {
    hdr_output_free(image->output);
    *image = (bench_image){0};
}

static hdr_status check_sizes(const bench_image *image, const bench_image *reference, hdr_error *error) {
    if (image->pixels == reference->pixels && image->components == reference->components) return HDR_OK;
    snprintf(error->message, sizeof error->message, "two ways to compute the chain give pictures of different form");
    return error->status = HDR_INTERNAL;
}

hdr_status bench_compare_images(const bench_image *image, const bench_image *reference, bench_way *way,
                                hdr_error *error) {
    if (check_sizes(image, reference, error) != HDR_OK) return error->status;
    size_t count = reference->pixels * (size_t)reference->components;
    double largest = 0, squares = 0;
    for (int c = 0; c < reference->components; c++)
        for (size_t i = 0; i < reference->pixels; i++) {
            double value = (double)image->plane[c][i], wanted = (double)reference->plane[c][i];
            double error = fabs(value - wanted) / fmax(fabs(wanted), 0x1p-126);
            largest = fmax(largest, error);
            squares += error * error;
        }
    way->max_error = largest;
    way->rms_error = count ? sqrt(squares / (double)count) : 0;
    return HDR_OK;
}

static int code_of(float number) {
    return (int)lrintf(number * 255);
}

hdr_status bench_compare_codes(const bench_image *image, const bench_image *reference, bench_way *way,
                               hdr_error *error) {
    if (check_sizes(image, reference, error) != HDR_OK) return error->status;
    size_t different = 0;
    way->most_off = 0;
    for (size_t p = 0; p < reference->pixels; p++) {
        int most = 0;
        for (int c = 0; c < reference->components; c++) {
            int off = abs(code_of(image->plane[c][p]) - code_of(reference->plane[c][p]));
            if (off > most) most = off;
        }
        different += most > 0;
        if (most > way->most_off) way->most_off = most;
    }
    way->pixels_off = reference->pixels ? 100.0 * (double)different / (double)reference->pixels : 0;
    return HDR_OK;
}

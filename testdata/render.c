/*
 * render: a small path tracer that makes this project's real test pictures.
 *
 *     render SCENE [--width W] [--height H] [--samples N] [--seed S] [--type half|float] [--compression zip|piz]
 *            [--threads T] -o OUT.exr               SCENE: interior, glossy or object
 *
 * A pixel is the mean of its samples (box filter). Every sample draws from its own random stream, named by
 * (seed, pixel, sample), so the picture depends neither on the threads nor on their timing, and other seeds give
 * independent pictures.
 *
 * SPDX-License-Identifier: BSD-3-Clause
 */
#include "path.h"
#include "scene.h"
#include "write_exr.h"

#include <errno.h>
#include <limits.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

enum { EXIT_USAGE = 64, MOST_THREADS = 64, LARGEST_SIDE = 16384 };

typedef struct {
    const char *scene_name, *output;
    int width, height, samples, seed, threads;
    exr_pixel_type_t type;
    exr_compression_t compression;
} Options;

typedef struct {
    const Scene *scene;
    const Options *options;
    int channel_count;
    float *pixels;
    atomic_int next_row;
} Job;

/* The ray through position (x, y) of the picture, in pixels from its top left corner. */
static Ray camera_ray(const Job *job, double x, double y) {
    const Scene *scene = job->scene;
    double width = job->options->width, height = job->options->height;
    Vec forward = normalise(sub(scene->target, scene->eye));
    Vec right = normalise(cross(forward, vec(0, 1, 0))), up = cross(right, forward);
    double extent = tan(scene->field_of_view / 360 * PI);
    Vec sideways = scale(right, extent * (2 * x - width) / height);
    Vec upwards = scale(up, extent * (height - 2 * y) / height);
    return ray_from(scene->eye, normalise(add(forward, add(sideways, upwards))));
}

/* Samples without a surface count as alpha 0, so the mean colour is associated with the mean alpha as it stands. */
static void render_pixel(const Job *job, int x, int y, float *pixel) {
    Vec sum = vec(0, 0, 0);
    int samples = job->options->samples, covered_samples = 0;
    uint64_t index = (uint64_t)y * (uint64_t)job->options->width + (uint64_t)x;
    for (int sample = 0; sample < samples; sample++) {
        Random random = random_stream((uint64_t)job->options->seed, index, (uint64_t)sample);
        double across = uniform(&random), down = uniform(&random);
        bool covered;
        sum = add(sum, trace_path(job->scene, camera_ray(job, x + across, y + down), &random, &covered));
        covered_samples += covered;
    }
    pixel[0] = (float)(sum.x / samples);
    pixel[1] = (float)(sum.y / samples);
    pixel[2] = (float)(sum.z / samples);
    if (job->channel_count == 4) pixel[3] = (float)covered_samples / (float)samples;
}

static void *render_rows(void *argument) {
    Job *job = argument;
    for (int y; (y = atomic_fetch_add(&job->next_row, 1)) < job->options->height;) {
        for (int x = 0; x < job->options->width; x++) {
            size_t index = (size_t)y * (size_t)job->options->width + (size_t)x;
            render_pixel(job, x, y, job->pixels + index * (size_t)job->channel_count);
        }
    }
    return NULL;
}

/* A thread that cannot be started is done without: this one renders rows too. */
static void render_picture(Job *job) {
    pthread_t helpers[MOST_THREADS];
    int started = 0;
    while (started < job->options->threads - 1 && pthread_create(&helpers[started], NULL, render_rows, job) == 0)
        started++;
    render_rows(job);
    for (int i = 0; i < started; i++)
        pthread_join(helpers[i], NULL);
}

static bool render_to_file(const Scene *scene, const Options *options) {
    Job job = {.scene = scene, .options = options, .channel_count = scene->has_alpha ? 4 : 3};
    job.pixels = calloc((size_t)options->width * (size_t)options->height * (size_t)job.channel_count, sizeof(float));
    if (!job.pixels) {
        fprintf(stderr, "render: out of memory\n");
        return false;
    }
    render_picture(&job);
    exr_attr_box2i_t window = window_of_size(options->width, options->height);
    Picture picture = {scene->has_alpha ? "RGBA" : "RGB", window, window, job.pixels, NULL};
    bool written = write_exr(options->output, &picture, options->type, options->compression);
    free(job.pixels);
    return written;
}

static bool parse_integer(const char *text, int least, int most, int *value) {
    char *end;
    errno = 0;
    long number = strtol(text, &end, 10);
    if (errno || end == text || *end || number < least || number > most) return false;
    *value = (int)number;
    return true;
}

/* Which of two words the text is: 0, 1, or -1. */
static int one_of_two(const char *text, const char *first, const char *second) {
    return strcmp(text, first) == 0 ? 0 : strcmp(text, second) == 0 ? 1 : -1;
}

static bool parse_option(const char *name, const char *value, Options *options) {
    if (strcmp(name, "--width") == 0) return parse_integer(value, 1, LARGEST_SIDE, &options->width);
    if (strcmp(name, "--height") == 0) return parse_integer(value, 1, LARGEST_SIDE, &options->height);
    if (strcmp(name, "--samples") == 0) return parse_integer(value, 1, INT_MAX, &options->samples);
    if (strcmp(name, "--seed") == 0) return parse_integer(value, 0, INT_MAX, &options->seed);
    if (strcmp(name, "--threads") == 0) return parse_integer(value, 1, MOST_THREADS, &options->threads);
    if (strcmp(name, "-o") == 0) {
        options->output = value;
        return true;
    }
    if (strcmp(name, "--type") == 0) {
        int choice = one_of_two(value, "half", "float");
        options->type = choice == 1 ? EXR_PIXEL_FLOAT : EXR_PIXEL_HALF;
        return choice >= 0;
    }
    if (strcmp(name, "--compression") == 0) {
        int choice = one_of_two(value, "zip", "piz");
        options->compression = choice == 1 ? EXR_COMPRESSION_PIZ : EXR_COMPRESSION_ZIP;
        return choice >= 0;
    }
    return false;
}

static bool parse_command_line(int argc, char **argv, Options *options) {
    for (int i = 1; i < argc; i++) {
        if (argv[i][0] == '-') {
            if (i + 1 == argc || !parse_option(argv[i], argv[i + 1], options)) {
                fprintf(stderr, "render: %s: unknown, or without a fitting value\n", argv[i]);
                return false;
            }
            i++;
        } else {
            options->scene_name = argv[i];
        }
    }
    return options->scene_name && options->output;
}

int main(int argc, char **argv) {
    Options options = {.width = 320,
                       .height = 240,
                       .samples = 64,
                       .seed = 1,
                       .threads = 2,
                       .type = EXR_PIXEL_HALF,
                       .compression = EXR_COMPRESSION_ZIP};
    Scene scene = {0};
    if (!parse_command_line(argc, argv, &options) || !build_scene(options.scene_name, &scene)) {
        fprintf(stderr, "usage: render interior|glossy|object [--width W] [--height H] [--samples N] [--seed S]\n"
                        "       [--type half|float] [--compression zip|piz] [--threads T] -o OUT.exr\n");
        return EXIT_USAGE;
    }
    return render_to_file(&scene, &options) ? EXIT_SUCCESS : EXIT_FAILURE;
}

/* hdr bench: what its files share. */
#ifndef HDR_BENCH_H
#define HDR_BENCH_H

#include "cmd.h"

/* ---- bench_ways.c: the ways in which a chain can be computed ---- */

enum { BENCH_WAYS = 64, BENCH_WORDS = 4 };

/* One of them, and what came of it. Times are in milliseconds. */
typedef struct bench_way {
    const char *method;             /* "grid", "exact"; "fast", "reference" where nothing is varied */
    const char *option;             /* what is set besides, "--cells"; or NULL */
    const char *value;              /* "3x4"; or NULL */
    const char *words[BENCH_WORDS]; /* all this as further options of a clause */
    int word_count;
    bool automatic;    /* it is what is taken where no method is asked for */
    bool estimated;    /* its times are not measured, but inferred */
    bool partial;      /* it computes each pixel by itself, so that some can stand for all */
    double fixed;      /* partial: what of its time does not grow with their number */
    int repetitions;   /* that were timed */
    double whole, own; /* medians; own is below 0 where nothing is varied */
    double max_error, rms_error;
    double bound;      /* that the method states; below 0: none */
    double pixels_off; /* how many pixels have another code, in percent; below 0: not compared */
    int most_off;      /* the largest difference of codes */
} bench_way;

/* The method that others are compared with. */
#define bench_exact "exact"

/* The last clause whose verb has several methods, the exact one among them; 0: none has. */
int bench_varied_clause(const hdr_chain *chain);

/* HDR_USAGE where an option was given that is to be varied. */
hdr_status bench_check_given(const hdr_chain *chain, int clause, hdr_error *error);

/* Those of a verb with methods, and of any other chain. The one that is compared with is the first. */
int bench_ways_of(const hdr_verb_about *verb, bench_way ways[BENCH_WAYS]);
int bench_plain_ways(bench_way ways[BENCH_WAYS]);

/* What is done where no method is asked for. */
bench_way bench_automatic_way(void);

/* ---- bench.c ---- */

typedef struct bench {
    const char *file;
    char *chain; /* as text */
    hdr_picture picture;
    int threads, repetitions;
    double limit;       /* milliseconds */
    const char *format; /* that the whole chain writes */
    int varied;         /* the clause; 0: the fast way is compared with the reference */
    const char *verb;   /* of that clause, or NULL; and what it computes around each pixel */
    const char *what, *unit;
    int random, extremes; /* pixels that errors were taken at */
    bool all;             /* those are all that are lit */
    bool codes;           /* they are compared: there is time for the exact method */
    bench_way way[BENCH_WAYS];
    int count;
} bench;

/* bench_ways.c: fills what and unit for the verb. */
void bench_describe_surround(bench *b);

/* Of the data window. */
static inline long long bench_width(const bench *b) {
    return (long long)b->picture.data.max_x - b->picture.data.min_x + 1;
}
static inline long long bench_height(const bench *b) {
    return (long long)b->picture.data.max_y - b->picture.data.min_y + 1;
}

/* The time that counts: own, where there is one. */
static inline double bench_time(const bench_way *way) {
    return way->own >= 0 ? way->own : way->whole;
}

/* ---- bench_error.c ---- */

/* Pixels to compare at, of those that are lit: as many random ones as samples, which come first, and up to as many
 * local extremes of luminance; or all, where there are no more than samples. False: out of memory. */
typedef struct bench_pixels {
    hdr_pixel *pixel;
    int count, random;
    bool all; /* that are lit */
} bench_pixels;
bool bench_choose_pixels(const hdr_surround *scene, int samples, bench_pixels *pixels, hdr_error *error);

/* The errors of values at such pixels. */
void bench_compare_values(const float *values, const float *exact, const bench_pixels *pixels, bench_way *way);

/* What a chain makes of the picture, as numbers. */
typedef struct bench_image {
    hdr_output *output;
    const float *plane[3];
    size_t pixels;
    int components; /* of a pixel */
} bench_image;
hdr_status bench_make_image(hdr_chain *chain, hdr_input *input, bench_image *image, hdr_error *error);
void bench_free_image(bench_image *image);

/* Relative errors; and differences of codes, of images that are quantised to 8 bits. HDR_INTERNAL: they are not of the
 * same size. */
hdr_status bench_compare_images(const bench_image *image, const bench_image *reference, bench_way *way,
                                hdr_error *error);
hdr_status bench_compare_codes(const bench_image *image, const bench_image *reference, bench_way *way,
                               hdr_error *error);

/* ---- bench_print.c ---- */

void bench_print_table(const bench *b);
void bench_print_csv(const bench *b);
void bench_print_json(const bench *b);

/* What errors are of, and how they were taken, in one line; and how times were. */
void bench_describe_error(const bench *b, char *text, size_t size);
void bench_describe_times(const bench *b, char *text, size_t size);

/* ---- bench_plot.c ---- */

/* Run time against error, as SVG. */
hdr_status bench_plot(const bench *b, hdr_output *output, hdr_error *error);

#endif

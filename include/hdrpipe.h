/* hdrpipe: float renders in, display pictures out, as a chain of verbs.
 *
 * This header is the library's manual. A picture in flight is a source of bytes and a list of things still to be done
 * to it (a chain of verbs). A chain is read from words as they stand on a command line, or added clause by clause;
 * running it turns the list into the fewest sweeps over the source and writes the result to an output.
 *
 *     hdr_error error = {0};
 *     hdr_chain *chain = hdr_chain_new(&error);
 *     hdr_chain_add(chain, (const char *const[]){"log", "--k", "2"}, 3, &error);
 *     hdr_chain_add(chain, (const char *const[]){"png"}, 1, &error);
 *     hdr_input *input = hdr_input_open("render.exr", &error);
 *     hdr_output *output = hdr_output_open("render.png", &error);
 *     hdr_status status = error.status ? error.status : hdr_chain_run(chain, input, output, NULL, &error);
 *     ...
 *     hdr_output_free(output); hdr_input_free(input); hdr_chain_free(chain);
 *
 * Conventions. Every function that can fail returns an hdr_status, or NULL, and fills the hdr_error it was given (which
 * may be NULL); a record that is already filled is left alone, so a series of calls may share one and be checked once.
 * The library never prints, never exits and holds no global state but the choice of processor kernels and the names of
 * temporary files. Strings are
 * UTF-8 and NUL-ended. All free functions accept NULL. Objects may be used by one thread at a time; different objects
 * by different threads. */
#ifndef HDRPIPE_H
#define HDRPIPE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define HDRPIPE_VERSION "0.1.0"

/* ---- Status and errors ----------------------------------------------------------------------------------------------
 */

/* The values are the exit statuses of the commands (after sysexits.h). */
typedef enum hdr_status {
    HDR_OK = 0,
    HDR_DIFFERENT = 1,    /* a comparison found a difference over its threshold, or some file of several failed */
    HDR_USAGE = 64,       /* words that make no command: unknown verb or option, value out of range */
    HDR_BAD_DATA = 65,    /* the picture cannot be read, or cannot be used so */
    HDR_NO_INPUT = 66,    /* no such file, or it cannot be opened */
    HDR_INTERNAL = 70,    /* out of memory, or a fault of hdrpipe itself */
    HDR_CANT_CREATE = 73, /* the output cannot be created */
    HDR_IO = 74           /* reading or writing failed, e.g. the disk is full */
} hdr_status;

/* What went wrong: in which file and clause, where, and what to do about it. Zero-initialise before use. */
typedef struct hdr_error {
    hdr_status status;
    char message[1000]; /* one sentence, or a sentence and an option's help line; no newline at the end */
} hdr_error;

/* ---- Options --------------------------------------------------------------------------------------------------------
 */

typedef enum hdr_option_type {
    HDR_OPTION_FLAG,    /* takes no value */
    HDR_OPTION_NUMBER,  /* a decimal number in [min,max] (or ]min,max] when above_min), or one of words */
    HDR_OPTION_INTEGER, /* the same, a whole number */
    HDR_OPTION_DECIMAL, /* a decimal in [min,max] that is used exactly as it was typed (percentiles) */
    HDR_OPTION_CHOICE,  /* one of words */
    HDR_OPTION_SIZE,    /* bytes; K, M, G and T multiply by powers of 1024; or one of words */
    HDR_OPTION_TEXT,    /* any text, e.g. a file's name */
    HDR_OPTION_FACTS    /* facts of a whole shot: the name of a file with what `hdr stats --json` printed, which is read
                           at once; or the numbers themselves, which are what a pipe's head has, in this form:
                           log_average=0.1,max_luminance=90,p1=0.01,p99=40 */
} hdr_option_type;

/* One option. Parsing, help, manual, completion and the pipe's head are all made from tables of these, each ended by an
 * entry whose name is NULL. */
typedef struct hdr_option {
    const char *name; /* --name */
    char letter;      /* -l, or 0 */
    hdr_option_type type;
    size_t offset;             /* where the value is kept in the owner's parameters; of no use to others */
    const char *metavar;       /* what help calls the value, with its unit: "STOPS", "PERCENT"; NULL for a flag */
    double min, max;           /* range of numbers; both 0: any finite number */
    bool above_min;            /* min itself is excluded */
    const char *const *words;  /* NULL-ended list of words, or NULL */
    const char *default_value; /* as it would be typed; NULL: off, or none */
    const char *help;          /* one line, no full stop */
    bool travels;              /* common options only: it changes the picture, so it goes along in a pipe's head */
    const char *clause; /* other than by default it stands for a clause behind its own: these words, and its value */
} hdr_option;

/* The options that every verb accepts, once in a chain. */
const hdr_option *hdr_common_options(void);

/* Writes the one line that --help shows for an option into line (at most size bytes, always NUL-ended):
 * "  -g, --exponent NUMBER   help (range; default 2.2)". */
void hdr_option_describe(const hdr_option *option, char *line, size_t size);

/* ---- Verbs ----------------------------------------------------------------------------------------------------------
 */

typedef enum hdr_verb_kind {
    HDR_FILTER,  /* picture in, picture out */
    HDR_FORMAT,  /* ends a chain: writes a file format */
    HDR_PROGRAM, /* ends a chain: reports about the picture (info, stats); or stands in front of one (bench) */
    HDR_JOIN     /* begins a chain: makes one picture of several (mean, diff) */
} hdr_verb_kind;

/* What there is to know about a verb from outside. */
typedef struct hdr_verb_about {
    const char *name;    /* "gamma" */
    const char *summary; /* the man page's NAME line: no capital, no full stop */
    const char *details; /* DESCRIPTION: plain sentences; paragraphs separated by an empty line */
    const char *const
        *examples;             /* NULL-ended shell command lines: in them, IN.exr is a picture, OUT.png etc. results */
    const hdr_option *options; /* its own options */
    hdr_verb_kind kind;
    bool leads; /* a program that stands in front of a chain, without a `then`: bench [OPTION...] VERB [OPTION...] */
    bool alone; /* a program that takes no picture: crosscheck */
    bool stays; /* a verb that opens more than a picture: it cannot go along in a pipe's head */
} hdr_verb_about;

/* The verbs, in the order of the manual: index 0, 1, ... until NULL. */
const hdr_verb_about *hdr_verb_at(int index);
const hdr_verb_about *hdr_verb_named(const char *name); /* NULL: there is none */

/* The format whose ending a file's name has: "a.hdr" is rgbe's. NULL: no format has it. */
const hdr_verb_about *hdr_format_named(const char *file_name);

/* ---- Pictures -------------------------------------------------------------------------------------------------------
 */

/* A rectangle of pixels, corners included, in OpenEXR's coordinates: x to the right, y downwards. Empty if max < min.
 */
typedef struct hdr_window {
    int32_t min_x, min_y, max_x, max_y;
} hdr_window;

typedef enum hdr_type {
    HDR_HALF,
    HDR_FLOAT,
    HDR_UINT /* whole numbers, 32 bits: an object's number, a count of samples; read by --channel alone */
} hdr_type;

/* CIE 1931 x,y of the primaries and of white. */
typedef struct hdr_chromaticities {
    double red[2], green[2], blue[2], white[2];
} hdr_chromaticities;

#define HDR_CHANNEL_NAME 256

typedef struct hdr_channel {
    char name[HDR_CHANNEL_NAME];
    hdr_type type;
} hdr_channel;

/* What a picture is, before any pixel is looked at. Of a file that holds several: the one that is read. */
typedef struct hdr_picture {
    hdr_window data;    /* where there are pixels */
    hdr_window display; /* the frame */
    int planes;         /* colour planes: 1 (luminance only) or 3 (R, G, B) */
    bool has_alpha;
    hdr_channel channels[4]; /* those that are read: R G B or Y, then A where there is one; [3] is A's place. The names
                                are the file's own: "diffuse.red"; [0] holds the one that --channel names. X Y Z of a
                                file that holds those: its primaries are X, Y and Z */
    bool present[4];         /* false: the file has no such channel; R, G or B read as 0 then */
    bool has_chromaticities; /* the file says which primaries; otherwise Rec.709 is assumed */
    hdr_chromaticities chromaticities; /* filled in either case */
    bool has_neutral;                  /* adoptedNeutral */
    double neutral[2];
    float pixel_aspect;
    char state[64];       /* "linear", or what the pixels are encoded with, as the file tells: "srgb", "gamma 2.2" */
    char format[16];      /* "exr", "rgbe", "pfm", "pfs", "planes" */
    char storage[16];     /* "scan-line", "tiled" */
    char compression[16]; /* "none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab" */
    int part;             /* its number in the file, from 0 */
    char part_name[HDR_CHANNEL_NAME]; /* empty where it has none */
    char layer[HDR_CHANNEL_NAME];     /* what stands before the last point of its channels' names; empty: nothing */
    int level;                        /* of a mip map; 0: full resolution. The windows are the level's */
} hdr_picture;

/* ---- Input ----------------------------------------------------------------------------------------------------------
 */

/* Bytes of a picture file, with or without a pipe's head in front. */
typedef struct hdr_input hdr_input;

/* Opens a file, or standard input for "-" or NULL (HDR_USAGE when that is a terminal). A pipe is read into memory while
 * it is being decoded. HDR_NO_INPUT: it cannot be opened. */
hdr_input *hdr_input_open(const char *path, hdr_error *err);

/* The same from memory, which must stay as it is until the input is freed. name is used in messages. */
hdr_input *hdr_input_memory(const void *bytes, size_t size, const char *name, hdr_error *err);

/* Pixels in memory instead of a file: width x height, planes = 1 or 3 colour planes (plus alpha where not NULL), linear
 * float32, Rec.709 primaries, alpha associated; row after row, each plane separate; they must stay as they are until
 * the input is freed. */
hdr_input *hdr_input_planes(int width, int height, int planes, const float *const plane[3], const float *alpha,
                            hdr_error *err);

/* Several inputs, for a chain that begins with a verb of kind HDR_JOIN. They stay the caller's, who frees them after
 * this one. count >= 1. */
hdr_input *hdr_input_join(int count, hdr_input *const inputs[], hdr_error *err);

/* As messages call it: the end of the file's name, "standard input", "a.exr and 3 more". */
const char *hdr_input_name(const hdr_input *input);
void hdr_input_free(hdr_input *input);

/* ---- Output ---------------------------------------------------------------------------------------------------------
 */

/* Where the result goes. A file appears under its name only when it is whole: until hdr_chain_run has succeeded it is a
 * temporary file beside it, which is removed on any fault. */
typedef struct hdr_output hdr_output;

/* A file by name; a symbolic link is followed, a device or FIFO is written to directly. HDR_CANT_CREATE: it cannot be.
 */
hdr_output *hdr_output_open(const char *path, hdr_error *err);

/* An open descriptor, e.g. standard output, which stays open. Nothing is written until the result is whole.
 * HDR_USAGE when it is a terminal. name is used in messages. */
hdr_output *hdr_output_descriptor(int descriptor, const char *name, hdr_error *err);

/* Memory: after hdr_chain_run the bytes are had from hdr_output_bytes; they belong to the output. */
hdr_output *hdr_output_memory(hdr_error *err);
const void *hdr_output_bytes(const hdr_output *output, size_t *size);

/* Bytes of one's own instead of a picture: the output is whole then. */
hdr_status hdr_output_fill(hdr_output *output, const void *bytes, size_t size, hdr_error *err);
void hdr_output_free(hdr_output *output);

/* Removes the temporary files of all outputs of this process. May be called in a signal handler, and is for nothing
 * else: the outputs are of no use afterwards, the program has to end. */
void hdr_output_remove_temporary(void);

/* ---- Chains ---------------------------------------------------------------------------------------------------------
 */

typedef struct hdr_chain hdr_chain;

/* An empty chain with default settings. */
hdr_chain *hdr_chain_new(hdr_error *err);
void hdr_chain_free(hdr_chain *chain);

/* Adds one clause: words[0] is the verb, the others are its options and common options, as on a command line. A file of
 * facts that they name is read here: HDR_NO_INPUT, HDR_BAD_DATA. */
hdr_status hdr_chain_add(hdr_chain *chain, const char *const words[], int count, hdr_error *err);

/* Adds the clauses of a whole command line: VERB [OPTION...] [then VERB [OPTION...]]... [FILE...]. ":" stands for
 * "then" too; "--" makes operands of all that follows. A program that leads may stand in front: it is not a clause, and
 * runs of the chain do not know of it. */
hdr_status hdr_chain_parse(hdr_chain *chain, int count, const char *const words[], hdr_error *err);

/* The program that leads, or NULL. */
const hdr_verb_about *hdr_chain_leader(const hdr_chain *chain);

/* The operands that hdr_chain_parse met: NULL-ended; they belong to the caller's words. */
const char *const *hdr_chain_files(const hdr_chain *chain);

/* The common options as they were given, or their defaults. The strings belong to the chain. */
typedef struct hdr_settings {
    int threads;        /* -j: 1 ... 1024; default HDR_THREADS, else the cores that this process may use */
    const char *output; /* -o, or NULL */
    bool quiet, verbose, explain, json, help, version;
    bool reference;  /* evaluate everything in double, step by step: slow, the oracle */
    bool no_skip;    /* do what could be skipped */
    bool strict;     /* a repaired pixel is an error */
    uint64_t memory; /* bytes the run may hold pixels in; a bigger picture is decoded again instead of kept */
} hdr_settings;
const hdr_settings *hdr_chain_settings(const hdr_chain *chain);

/* The verb of a clause, 1 being the first; NULL: there is none of that number. */
const hdr_verb_about *hdr_chain_clause(const hdr_chain *chain, int number);

/* What an option of a clause was given as, or of the program that leads, whose number is 0: its text, which has been
 * checked against the table; "" for a flag. NULL: it was not given. */
const char *hdr_chain_given(const hdr_chain *chain, int number, const char *name);

/* Whether the chain begins with a verb that makes one picture of several: it is run on hdr_input_join. */
bool hdr_chain_joins(const hdr_chain *chain);

/* The last clause's verb; where there is no clause the program that leads, or NULL. */
const hdr_verb_about *hdr_chain_last(const hdr_chain *chain);

/* The clauses in one line, as a command line has them, with what changes the picture and not how it is computed. Bytes
 * outside [A-Za-z0-9._,:/@+=-] are %XX. Release it with free(). NULL: out of memory. */
char *hdr_chain_text(const hdr_chain *chain, hdr_error *err);

/* A chain can be varied: an empty chain with the common options of another; and one of its clauses once more, with
 * further options, common ones too, behind its own. What was given there may not be given again: HDR_USAGE. */
hdr_chain *hdr_chain_new_like(const hdr_chain *other, hdr_error *err);
hdr_status hdr_chain_add_again(hdr_chain *chain, const hdr_chain *other, int number, const char *const words[],
                               int count, hdr_error *err);

/* Text that a run has to say, line by line. */
typedef enum hdr_message {
    HDR_NOTE,    /* something the user should know: pixels were repaired; a default was chosen that may surprise */
    HDR_EXPLAIN, /* --explain: the plan */
    HDR_DETAIL   /* -v: sizes and times */
} hdr_message;
typedef struct hdr_listener {
    void (*say)(void *context, hdr_message kind, const char *line);
    void *context;
} hdr_listener;

/* Runs the chain on the input and writes the result to the output. The format is that of the chain's last verb; where
 * that is no format, by the ending of the output's name (hdr_format_named; another ending: HDR_USAGE), else EXR. If the
 * input begins with a pipe's head, its clauses come first. A listener of NULL hears nothing. The chain is not used up.
 */
hdr_status hdr_chain_run(hdr_chain *chain, hdr_input *input, hdr_output *output, const hdr_listener *listener,
                         hdr_error *err);

/* Puts the chain in front of the input's bytes, as text, and copies both to an open descriptor: no pixel is computed.
 * For a filter that writes to a pipe. The text's form is in hdrpipe(5). HDR_USAGE: the chain ends in a format or
 * program, or has a filter that stays. */
hdr_status hdr_chain_defer(hdr_chain *chain, hdr_input *input, int descriptor, hdr_error *err);

/* ---- Facts ----------------------------------------------------------------------------------------------------------
 */

#define HDR_PERCENTILES 9

/* What the scene is like after all clauses of the chain that are filters, over the data window. Y is luminance; a lit
 * pixel is one with Y > 0. Counts of repaired values are of the file's components, alpha included; all else is after
 * repair. */
typedef struct hdr_stats {
    hdr_picture picture;
    uint64_t pixels, lit;
    uint64_t nan, positive_infinity, negative_infinity; /* components repaired */
    uint64_t negative;                                  /* colour components below 0 */
    uint64_t unlit_colour;                              /* pixels that are not lit though some component is positive */
    double min[4], max[4]; /* per channel: R G B (or Y in [0]) and alpha; 0 where there is no such channel */
    double min_luminance, max_luminance; /* over all pixels */
    double min_lit;                      /* smallest Y > 0; 0 when nothing is lit */
    double log_average;                  /* exp(mean of ln Y over lit pixels); 0 when nothing is lit */
    double percentile[HDR_PERCENTILES];  /* nearest rank of Y rounded to float32, over lit pixels; 0: nothing lit */
    double percentile_percent[HDR_PERCENTILES]; /* which: 0.1 1 5 25 50 75 95 99 99.9 */
    bool grey;                                  /* one plane, or R = G = B everywhere */
    bool opaque;                                /* no alpha, or 1 everywhere */
} hdr_stats;

/* Takes the facts. The chain may end in a program verb, which is left out; a format verb: HDR_USAGE. */
hdr_status hdr_chain_stats(hdr_chain *chain, hdr_input *input, hdr_stats *stats, const hdr_listener *listener,
                           hdr_error *err);

/* A survey: the facts of several pictures together, such as the frames of a shot. They are as exact as if it were one
 * picture, and the memory that it takes does not grow with the number of pictures. It goes in rounds, in each of which
 * every picture is given once:
 *
 *     hdr_survey *survey = hdr_survey_new(chain, &error);
 *     do {
 *         for (int i = 0; i < count && !error.status; i++) {
 *             hdr_input *input = hdr_input_open(name[i], &error);
 *             if (input) hdr_survey_take(survey, input, &stats, NULL, &error);
 *             hdr_input_free(input);
 *         }
 *     } while (!error.status && hdr_survey_next(survey, &together, &error));
 *     hdr_survey_free(survey);
 */
typedef struct hdr_survey hdr_survey;

/* The chain is as for hdr_chain_stats, and must stay as it is until the survey is freed. */
hdr_survey *hdr_survey_new(hdr_chain *chain, hdr_error *err);
void hdr_survey_free(hdr_survey *survey);

/* Takes what the round needs of a picture. In the first that is hdr_chain_stats, which fills stats (may be NULL); later
 * ones leave stats alone, and have no notes: those were said in the first. An input may be kept from one round to the
 * next, or be opened anew. Where it fails, other pictures may still be given, but there will be no facts of all. */
hdr_status hdr_survey_take(hdr_survey *survey, hdr_input *input, hdr_stats *stats, const hdr_listener *listener,
                           hdr_error *err);

/* Ends a round. True: another is needed, of the same pictures, in any order. False: together is filled, but for
 * picture, min and max, which only a single picture has; log_average is summed in the order of the first round; grey
 * and opaque tell whether all are. Or it is not filled, and err tells why: a picture failed, or has changed from one
 * round to the next. */
bool hdr_survey_next(hdr_survey *survey, hdr_stats *together, hdr_error *err);

/* What is read of the input, from its header alone, with the reading options (--part, --layer, --crop, ...) of a chain,
 * whose clauses do not matter, behind those of the head, if there is one. A chain of NULL has none. */
hdr_status hdr_input_picture(hdr_input *input, const hdr_chain *chain, hdr_picture *picture, hdr_error *err);

/* ---- Errors ---------------------------------------------------------------------------------------------------------
 */

/* Means over numbers x of a test and r of its reference, d = x - r, e being the epsilon that was given. All are 0 where
 * there are no numbers. */
typedef struct hdr_errors {
    uint64_t numbers;
    double bias;      /* mean of d */
    double mae;       /* of |d| */
    double mse, rmse; /* of d^2; its root */
    double mrse;      /* of d^2 / (r^2 + e) */
    double mape;      /* of |d| / (|r| + e) */
    double smape;     /* of |d| / (|x| + |r| + e) */
} hdr_errors;

/* The sums that the means are made of, over a part of the picture: numbers is how many there are. */
typedef struct hdr_tile {
    double numbers, signed_sum, absolute, squared, relative_square, relative, symmetric;
} hdr_tile;

typedef struct hdr_comparison {
    hdr_picture picture; /* the test's */
    double epsilon;
    bool present[4];       /* channels that both have: R G B, or Y in [0]; alpha */
    hdr_errors channel[4]; /* of each */
    hdr_errors all;        /* of all colour channels together */
    uint64_t left_out;     /* components of colour that are NaN or infinite in either: they count for nothing */
    double worst;          /* the largest |d|, and where it is; the channel is -1 where all are 0 */
    int worst_x, worst_y, worst_channel;
    double worst_test, worst_reference;
    int tiles;      /* squares of 64 pixels, row by row */
    hdr_tile *tile; /* of each, all colours together */
} hdr_comparison;

/* Compares pictures as they are stored: colour associated with alpha, nothing repaired. Of the chain only the common
 * options matter. Both are read once, together, block by block. The result does not depend on threads. Release it with
 * hdr_comparison_free, whatever the status. HDR_BAD_DATA: they are not of one form, or nothing of them is finite; or,
 * with --strict, not all is. */
hdr_status hdr_compare(const hdr_chain *chain, hdr_input *test, hdr_input *reference, double epsilon,
                       hdr_comparison *out, hdr_error *err);
void hdr_comparison_free(hdr_comparison *comparison);

/* Structural similarity (Wang et al. 2004) of what a viewer sees of the data windows: luma of the encoded pictures,
 * held to [0,1], repaired, colour divided by alpha; linear ones are encoded by sRGB. 1: they are the same.
 * HDR_BAD_DATA: less than 11 x 11 pixels. */
hdr_status hdr_compare_structure(const hdr_chain *chain, hdr_input *test, hdr_input *reference, double *ssim,
                                 hdr_error *err);

/* ---- Noise ----------------------------------------------------------------------------------------------------------
 */

enum { HDR_NOISE_LEVELS = 16 };

/* What independent renders of a scene tell of their noise, without a reference: the root mean variance over pixels and
 * colour channels, which for an unbiased renderer estimates the RMSE of one render. Standard errors are those of the
 * jackknife over renders; below 0 where there are fewer than 3. */
typedef struct hdr_noise {
    hdr_picture picture; /* the first render's */
    int renders;
    uint64_t numbers;  /* components that are finite in all renders: what the figures are taken over */
    uint64_t left_out; /* components of single renders that are not */
    double rmv, error; /* of one render; that of the mean of all is rmv / sqrt(renders) */
    double epsilon, relative, relative_error; /* the root of the mean of variance / (mean^2 + epsilon) */
    int levels;
    struct {
        int size; /* of the mean of so many renders: 1, 2, 4, ...; independent ones give rmv / sqrt(size) */
        double rmv, error;
    } level[HDR_NOISE_LEVELS];
    float *share; /* if asked for: of each pixel, row after row, its share of further samples; their mean is 1 */
} hdr_noise;

/* Measures it. Pictures are taken as they are stored; of the chain only the common options matter. The result does not
 * depend on threads. Release it with hdr_noise_free, whatever the status. HDR_USAGE: fewer than two; HDR_BAD_DATA: they
 * are not of one form, or nothing of them is finite; or, with --strict, not all is. */
hdr_status hdr_measure_noise(const hdr_chain *chain, int count, hdr_input *const inputs[], double epsilon, bool share,
                             hdr_noise *out, hdr_error *err);
void hdr_noise_free(hdr_noise *noise);

/* ---- Surrounds ------------------------------------------------------------------------------------------------------
 */

/* A pixel of the data window, whose upper left one is 0,0. */
typedef struct hdr_pixel {
    int x, y;
} hdr_pixel;

/* What a local verb computes around each pixel before it maps it: durand the base layer, as log10 of intensity;
 * reinhard --local the luminance V_m of its surround. */
typedef struct hdr_surround {
    int width, height;      /* of the data window; 0 where values is NULL */
    const float *luminance; /* what it is computed from, of all pixels, row after row: Y, or what the verb takes for it;
                               0: not lit */
    const float *values; /* of all pixels, row after row; or of those that were asked for, in their order; of one that
                            is not lit, any number. NULL: the verb does without, for this picture and its options */
    double milliseconds; /* for the surround alone, without reading the picture and mapping it */
    double bound;        /* no value is farther from the exact one, in the values' unit; below 0: none is stated */
    bool partial;        /* nothing but the pixels that were asked for was computed, and timed */
    char method[240];    /* how it was computed: what --explain tells */
} hdr_surround;

/* Computes the surround of the chain's last clause. count: 0 for all pixels; else those are asked for alone, which is
 * less work for a method that computes each pixel by itself, and luminance is NULL. The result is independent of chain
 * and input. NULL: err is filled; HDR_USAGE: that clause's verb has no surround, or there is no such pixel. */
hdr_surround *hdr_chain_surround(hdr_chain *chain, hdr_input *input, int count, const hdr_pixel pixels[],
                                 const hdr_listener *listener, hdr_error *err);
void hdr_surround_free(hdr_surround *surround);

/* ---- OpenColorIO ----------------------------------------------------------------------------------------------------
 */

typedef enum hdr_ocio_kind {
    HDR_OCIO_SPACE,   /* a colour space */
    HDR_OCIO_ROLE,    /* another name for one */
    HDR_OCIO_DISPLAY, /* behind it stand its views */
    HDR_OCIO_VIEW,
    HDR_OCIO_LOOK
} hdr_ocio_kind;

typedef struct hdr_ocio_name {
    hdr_ocio_kind kind;
    const char *name;
    const char *of; /* a role's colour space, a view's display; else empty */
} hdr_ocio_name;

/* The names that the options of the verb ocio take, kind by kind in the configuration's order. */
typedef struct hdr_ocio_names {
    int count;
    const hdr_ocio_name *names;
} hdr_ocio_names;

/* What a configuration file offers. NULL: the one that the environment's OCIO names, or, where that is not set, the one
 * that is built in. The plug-in hdrpipe-ocio.so is loaded for it: HDR_BAD_DATA where it is missing, or the file is
 * faulty; HDR_NO_INPUT: there is no such file. */
hdr_ocio_names *hdr_ocio_names_new(const char *config_file, hdr_error *err);
void hdr_ocio_names_free(hdr_ocio_names *names);

/* ---- Cross-check ----------------------------------------------------------------------------------------------------
 */

/* The largest distances between two ways to compute the same numbers: relative of those whose magnitude is 0.001 or
 * more, absolute of those below. Both are below 0 where nothing is compared. */
typedef struct hdr_distance {
    double relative, absolute;
} hdr_distance;

/* A curve of a verb, or a matrix between primaries, against OpenColorIO's, and against what is published. */
typedef struct hdr_agreement {
    const char *what;     /* "srgb --decode" */
    const char *theirs;   /* OpenColorIO's transform, as a configuration has it */
    hdr_distance ours;    /* from the published formula, in long double; of matrices none is printed */
    hdr_distance apart;   /* of ours from OpenColorIO's, in float32 */
    double codes;         /* the same in 8-bit codes, of results within [0,1] */
    hdr_distance follows; /* of OpenColorIO's from the formula that it follows, in long double */
    const char *reason;   /* why that is another, by design; NULL: it is not meant to be */
    size_t numbers;       /* that were compared */
    bool agrees;          /* ours is what is published, but for the roundings of double; and OpenColorIO's is ours to
                               2e-7, or 1e-7 below 0.001, or else what it is said to be instead, to 1e-6 */
} hdr_agreement;

/* Compares: curves over all half values and 10^6 floats from 1e-8 to 1e4. verb: those of one verb, or of "primaries";
 * NULL: all. Fills agreements, which are at most room, and *count. HDR_USAGE: there are none of that name. The plug-in
 * hdrpipe-ocio.so is needed, as for hdr_ocio_names_new. */
hdr_status hdr_crosscheck(const char *verb, int threads, hdr_agreement agreements[], int room, int *count,
                          hdr_error *err);

/* ---- Contents -------------------------------------------------------------------------------------------------------
 */

/* A channel as the file has it: "left.R". One of every x_sampling pixels of a row is stored, of every y_sampling rows.
 */
typedef struct hdr_listed_channel {
    const char *name;
    const char *layer; /* what stands before the last point of the name; empty: nothing */
    hdr_type type;
    int x_sampling, y_sampling;
} hdr_listed_channel;

/* An attribute of the header. value is text: of a number, of several with a space between them, of a string; NULL for a
 * type that is not shown. */
typedef struct hdr_attribute {
    const char *name, *type, *value;
} hdr_attribute;

/* One picture, or heap of channels, of a file. Texts are empty where the file says nothing. */
typedef struct hdr_part {
    int number; /* from 0: what --part takes */
    const char *name, *view;
    const char *storage;     /* "scan-line", "tiled", "deep scan-line", "deep tiled" */
    const char *compression; /* as in hdr_picture; "dwaa", "dwab" */
    hdr_window data, display;
    int tile_width, tile_height; /* 0: no tiles */
    const char *levels;          /* "one", "mipmap", "ripmap"; what --level takes is 0 ... level_count-1 */
    int level_count;
    int channel_count, view_count, attribute_count;
    const hdr_listed_channel *channels; /* in the order of the file, which is that of their names */
    const char *const *views;           /* multiView: the first is that of the channels without a layer */
    const hdr_attribute *attributes;
} hdr_part;

typedef struct hdr_contents {
    int part_count;
    const hdr_part *parts;
} hdr_contents;

/* Lists all that the input holds, from its headers alone, also what cannot be read, such as deep data. It belongs to
 * the caller, strings and all, and is independent of the input; hdr_contents_free frees it. NULL: no picture file, or a
 * damaged one. */
hdr_contents *hdr_input_contents(hdr_input *input, hdr_error *err);
void hdr_contents_free(hdr_contents *contents);

#ifdef __cplusplus
}
#endif
#endif

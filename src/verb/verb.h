/* A verb: one step of a chain. One file a verb: its option table, its plan, its formula. verbs.def lists them; adding a
 * verb is one file and one line. See skeleton.c for a commented template. A verb knows nothing of files, threads or its
 * neighbours. */
#ifndef HDR_VERB_H
#define HDR_VERB_H

#include "base/cpu.h"
#include "base/options.h"
#include "base/pool.h"
#include "io/sink.h"
#include "kernel/joining.h"
#include "kernel/dither.h"
#include "picture/facts.h"
#include "picture/palette.h"
#include "picture/plane.h"
#include "spatial/nlmeans.h"

typedef struct hdr_verb hdr_verb;

/* The numbers of a formula, as plan() resolved them. Each verb says what its are. */
typedef struct hdr_constants {
    double v[6];
} hdr_constants;

/* A formula on one number, in double: once for one value (the oracle, and the search for thresholds), once for a row of
 * them. Both are compiled from the same inline function, see HDR_CURVE, so they agree bit for bit. A curve is defined
 * for every double within float's range, negative ones too, and never gives a NaN; luminance curves give 0 for Y <= 0.
 * It is monotone, but for a joint of two branches that a standard's rounded constants let overlap. */
typedef struct hdr_curve {
    double (*exact)(const hdr_constants *constants, double value);
    void (*rows)(const hdr_constants *constants, double *values, size_t count); /* in place */
    bool monotone_to_the_bit; /* rounding cannot make it fall, as it may that of a logarithm by an ulp */
    bool has_joint;           /* it may fall between values up to joint and those above */
    double joint;
} hdr_curve;

/* HDR_CURVE(name) makes the curve `name` of the function
 *     HDR_INLINE double name_of(const hdr_constants *k, double value)
 * that stands above it. */
#define HDR_CURVE(name) HDR_CURVE_OF(name, false, false, 0)
/* The same of a function that is monotone to the last bit: one rounded operation after another, each monotone. */
#define HDR_CURVE_MONOTONE(name) HDR_CURVE_OF(name, true, false, 0)
/* Of one that may fall at a joint. */
#define HDR_CURVE_JOINED(name, joint) HDR_CURVE_OF(name, false, true, joint)
#define HDR_CURVE_OF(name, monotone, joined, joint)                                                                    \
    HDR_INLINE void name##_rows_body(const hdr_constants *constants, double *values, size_t count) {                   \
        const hdr_constants k = *constants; /* a copy: nothing that is stored can change it */                         \
        for (size_t i = 0; i < count; i++)                                                                             \
            values[i] = name##_of(&k, values[i]);                                                                      \
    }                                                                                                                  \
    HDR_VERSIONS_IN(static, name##_rows, (const hdr_constants *constants, double *values, size_t count),               \
                    (constants, values, count))                                                                        \
    static double name##_exact(const hdr_constants *constants, double value) {                                         \
        return name##_of(constants, value);                                                                            \
    }                                                                                                                  \
    static const hdr_curve name = {name##_exact, name##_rows, monotone, joined, joint};

/* A formula of two numbers: a pixel's luminance and what its surround is, defined for all that are not negative; or any
 * value and the threshold of its place, in (0,1). */
typedef struct hdr_local_curve {
    double (*exact)(const hdr_constants *constants, double value, double surround);
    void (*rows)(const hdr_constants *constants, double *values, const double *surround, size_t count);
    double (*alone)(double value); /* local forms: S of a lit pixel that has nothing around it but its like */
} hdr_local_curve;

/* HDR_LOCAL_CURVE(name, alone) makes it of the function
 *     HDR_INLINE double name_of(const hdr_constants *k, double value, double surround)
 */
#define HDR_LOCAL_CURVE(name, alone)                                                                                   \
    HDR_INLINE void name##_rows_body(const hdr_constants *constants, double *values, const double *surround,           \
                                     size_t count) {                                                                   \
        const hdr_constants k = *constants;                                                                            \
        for (size_t i = 0; i < count; i++)                                                                             \
            values[i] = name##_of(&k, values[i], surround[i]);                                                         \
    }                                                                                                                  \
    HDR_VERSIONS_IN(static, name##_rows,                                                                               \
                    (const hdr_constants *constants, double *values, const double *surround, size_t count),            \
                    (constants, values, surround, count))                                                              \
    static double name##_exact(const hdr_constants *constants, double value, double surround) {                        \
        return name##_of(constants, value, surround);                                                                  \
    }                                                                                                                  \
    static const hdr_local_curve name = {name##_exact, name##_rows, alone};

/* Something that a verb has opened for a clause, and that maps pixels by means which are not the verb's own. Several
 * threads use it at the same time. */
typedef struct hdr_mapper {
    /* Maps at most HDR_STRIP pixels in place. What is not finite then is repaired. False: memory is out. */
    bool (*map)(const struct hdr_mapper *mapper, double *const c[3], size_t count);
    void (*close)(struct hdr_mapper *mapper);
} hdr_mapper;

/* What a step does with its formula f. */
typedef enum hdr_form {
    HDR_FORM_CHANNEL,   /* C' = f(C), each colour channel by itself */
    HDR_FORM_LUMINANCE, /* Ld = f(Y), C' = (C/Y)^saturation Ld; 0 where Y <= 0 */
    HDR_FORM_LOCAL,     /* Ld = f(Y, S), S the pixel's surround; C' as above */
    HDR_FORM_PLACED,    /* C' = f(C, t), each colour channel by itself, t the threshold of the pixel's place */
    HDR_FORM_MATRIX,    /* (R',G',B') = M (R,G,B) */
    HDR_FORM_MAPPED,    /* (R',G',B') = what the mapper makes of (R,G,B); their primaries are its matter from then on */
    HDR_FORM_PALETTE    /* (R',G',B') = the palette's colour number 256 f(Y), rounded down; Rec.709's from then on */
} hdr_form;

/* A clause resolved against the facts. */
typedef struct hdr_step {
    const hdr_verb *verb;
    int clause; /* 1 for the first */
    hdr_form form;
    const hdr_curve *curve;
    const hdr_local_curve *local; /* HDR_FORM_LOCAL, HDR_FORM_PLACED */
    const hdr_plane *surround;    /* HDR_FORM_LOCAL: S of each pixel of the data window; filled by the chain */
    hdr_dither dither;            /* HDR_FORM_PLACED: the thresholds */
    hdr_constants constants;
    double saturation;        /* HDR_FORM_LUMINANCE, HDR_FORM_LOCAL */
    bool own_weights;         /* HDR_FORM_LOCAL: luminance[] are the step's own; a pixel is lit if Y is, too */
    double luminance[3];      /* else weights of Y where the step stands; filled by the chain */
    double lit[3];            /* weights of Y in any case; filled by the chain */
    double matrix[9];         /* HDR_FORM_MATRIX, by rows */
    const hdr_mapper *mapper; /* HDR_FORM_MAPPED */
    const uint32_t *palette;  /* HDR_FORM_PALETTE */
    bool of_largest;          /* the same: not of Y, but of the component that is farthest from 0 */
    hdr_legend legend;        /* the same: drawn below a picture of codes */
    bool wants_rec709;        /* the same: it takes pixels in Rec.709's primaries, as verbs that encode do */
    const hdr_chromaticities *primaries; /* HDR_FORM_MAPPED: of what is linear behind it; NULL: they are not known */
    char decodes[64];                    /* not empty: the state that it takes the pixels to be in */
    char state[64];                      /* not empty: what the pixels are afterwards, "linear", "srgb", "gamma 2.2" */
    int bits;                            /* above 0: the pixels are quantised to that many bits afterwards */
    bool of_light;                       /* it maps light: of values that are encoded it makes no sense */
    bool for_display; /* its result is meant for a display: what lies outside of [0,1] may be cut without a word */
    char note[240];   /* for --explain: the constants, or the reason of a skip */
} hdr_step;

/* What plan() may know. */
typedef struct hdr_scene {
    hdr_facts facts;   /* what needs() asked for, and nothing else, or what happens to be known of it beforehand */
    const char *state; /* what the pixels are: "linear", or the encoding's name */
    const hdr_mapper *mapper; /* what open() has made; NULL in tests of plan() alone */
} hdr_scene;

typedef enum hdr_verdict {
    HDR_RUN,
    HDR_SKIP,  /* doing it would give the same pixels bit for bit; the step must be filled all the same (--no-skip) */
    HDR_REFUSE /* err is filled */
} hdr_verdict;

/* How a surround is to be computed. */
typedef struct hdr_surroundings {
    const void *params;
    const hdr_scene *scene;
    hdr_plane *luminance; /* Y of each pixel, 0 where it is not lit; it may be overwritten */
    hdr_plane *surround;  /* to be filled: a new plane of that size, which the chain frees, or `luminance` itself */
    hdr_pool *pool;
    bool reference, no_skip;
    bool too_wide; /* set it where these luminances are nothing for float: then it is called again with a wide plane */
    /* Only S of these pixels is wanted, and no constants; a method that computes each by itself may leave out the rest,
     * and then sets partial. NULL: all. */
    const hdr_pixel *pixels;
    int pixel_count;
    bool partial;
    char note[240];   /* to be filled, for --explain: what was left out */
    char method[240]; /* to be filled: how S was computed; empty: there is but one way */
    double bound;     /* to be filled: no S is farther from the exact one; it is below 0 beforehand: none is stated */
} hdr_surroundings;

/* What becomes of a linear picture whose primaries are not Rec.709's. */
typedef enum hdr_format_primaries {
    HDR_PRIMARIES_TOLD,      /* the file tells them, or holds codes */
    HDR_PRIMARIES_CONVERTED, /* it is converted: readers take them for Rec.709's whatever the file says */
    HDR_PRIMARIES_XYZ,       /* the file holds X, Y and Z: the same, but for a picture of those */
    HDR_PRIMARIES_LOST       /* the file cannot tell them: that is said */
} hdr_format_primaries;

/* What the file tells of the encoding of its values. */
typedef enum hdr_format_states {
    HDR_STATES_TOLD, /* which it is */
    HDR_STATES_SRGB, /* that there is one, which readers take for sRGB's: it is said if it is another */
    HDR_STATES_LOST  /* nothing: that is said */
} hdr_format_states;

/* How codes are to be dithered. */
typedef struct hdr_dither_params {
    int kind; /* hdr_dither_kind */
    hdr_number seed;
} hdr_dither_params;

/* How a picture is filtered by a second one. */
typedef struct hdr_guiding {
    const char *picture; /* the second one's file; belongs to the params */
    hdr_nlmeans filter;  /* its settings of how that is computed are the chain's matter */
    char note[240];      /* for --explain */
} hdr_guiding;

/* What a format verb provides. */
typedef struct hdr_format {
    const char *extension; /* ".png" */
    bool codes;      /* it holds codes: the chain encodes and quantises if no verb has; its alpha is unassociated */
    bool alpha;      /* it can hold alpha */
    bool attributes; /* it can hold the attributes of an EXR header */
    hdr_format_primaries primaries;
    hdr_format_states states;
    /* Codes: the bits of a sample, after an explicit quantisation to `quantised` bits (0: none). */
    int (*bits)(const void *params, int quantised);
    hdr_sample (*sample)(const void *params, int bits);
    /* The same: how the chain's own quantisation is to be dithered. NULL: it cannot be. */
    const hdr_dither_params *(*dither)(const void *params);
    /* Whether the chain is to be told in the file. NULL: it never is. */
    bool (*records)(const void *params);
    hdr_sink *(*create)(const void *params, hdr_output *output, const hdr_frame *frame, hdr_error *err);
} hdr_format;

struct hdr_verb {
    hdr_verb_about about;
    size_t params_size;
    /* Options that exclude each other, ranges that depend on each other: HDR_USAGE. NULL: nothing to check. */
    hdr_status (*check)(const void *params, const hdr_options *given, hdr_error *err);
    /* Opens what the clause needs beside the picture, before that is. NULL: nothing. about.stays tells of it. */
    hdr_mapper *(*open)(const void *params, hdr_error *err);
    /* The facts about its input that plan() needs. NULL: none. Pure. */
    void (*needs)(const void *params, hdr_request *request);
    /* Filters: resolves the parameters. Pure. */
    hdr_verdict (*plan)(const void *params, const hdr_scene *scene, hdr_step *step, hdr_error *err);
    /* Spatial filters: S of each pixel, for a step that plan() has given HDR_FORM_LOCAL, and what of its constants
     * depends on it. needs() has asked for the plane of luminance. The same bytes whatever the pool. */
    hdr_status (*surround)(hdr_step *step, hdr_surroundings *with, hdr_error *err);
    /* The same: how far a value may be from that of --reference, as a part of it. */
    double (*bound)(const void *params);
    /* Joins: how several pictures become one, of which there are joining->pictures. HDR_USAGE: so many make no sense.
     */
    hdr_status (*join)(const void *params, hdr_joining *joining, hdr_error *err);
    /* Guided: how the picture is filtered, and by which. HDR_USAGE: none is named. */
    hdr_status (*guide)(const void *params, hdr_guiding *guiding, hdr_error *err);
    const hdr_format *format; /* formats only */
};

/* The registry, in the order of verbs.def. */
const hdr_verb *hdr_verb_find(const char *name);
const hdr_verb *hdr_verb_number(int index); /* NULL behind the last */

/* The format of an output that takes pixels: it is none of them. */
extern const hdr_verb hdr_verb_planes;

/* The format that a file's name calls for by its ending, in any case of letters. *ending: where that begins, or NULL
 * where the name has none. NULL: no format has it. */
const hdr_verb *hdr_verb_of_file(const char *file_name, const char **ending);

/* ---- What check() says of a text that an option cannot be ---- */

/* HDR_USAGE: "--name: 'text' WHY", and the option's help line. */
hdr_status hdr_refuse_text(const hdr_option *table, const char *name, const char *text, const char *why,
                           hdr_error *err);

/* The same where a file that is to be drawn is not called NAME.svg. NULL: none is. */
hdr_status hdr_check_svg(const hdr_option *table, const char *name, const char *file, hdr_error *err);

/* ---- What luminance verbs share ---- */

typedef struct hdr_luminance_params {
    hdr_number saturation;
    bool per_channel;
} hdr_luminance_params;

/* Their two options, for a table whose params struct has a member `luminance`. */
#define HDR_LUMINANCE_OPTIONS(params)                                                                                  \
    {.name = "saturation",                                                                                             \
     .type = HDR_OPTION_NUMBER,                                                                                        \
     .offset = offsetof(params, luminance.saturation),                                                                 \
     .metavar = "S",                                                                                                   \
     .min = 0,                                                                                                         \
     .max = 2,                                                                                                         \
     .default_value = "1",                                                                                             \
     .help = "exponent of C/Y: 0 gives grey, 1 keeps chromaticity"},                                                   \
    {                                                                                                                  \
        .name = "per-channel", .type = HDR_OPTION_FLAG, .offset = offsetof(params, luminance.per_channel),             \
        .help = "apply the curve to each channel as if it were Y"                                                      \
    }

/* Chooses the step's form by them. */
void hdr_luminance_form(const hdr_luminance_params *params, hdr_step *step);

/* ---- Facts of a whole shot ---- */

/* The option by which a verb takes them instead of those of the picture, for a table whose params struct has a member
 * `shot`. The chain does the rest: plan() finds them in the scene's facts. They are log_average, max_luminance, whether
 * `lit` is above 0, and percentiles 1 and 99 of lit pixels where the request has them; a request for others is refused,
 * and so is the option where nothing is requested. Of another picture, they prove nothing: no skip may rest on them. */
#define HDR_FACTS_OPTION(params)                                                                                       \
    {                                                                                                                  \
        .name = "facts", .type = HDR_OPTION_FACTS, .offset = offsetof(params, shot), .metavar = "FILE",                \
        .help = "take log-average, maximum and percentiles from `hdr stats --json` of a whole shot, not from this "    \
                "picture"                                                                                              \
    }

/* What the manual says about it: the last paragraph of such a verb's details. */
#define HDR_FACTS_DETAILS                                                                                              \
    "\n\nWith --facts FILE the facts are those of a whole shot, so that a sequence does not flicker though each "      \
    "frame "                                                                                                           \
    "is made by itself. FILE holds what 'hdr stats --json' has printed about all its frames, with the verbs in front " \
    "of stats that stand in front of this one. The numbers go along through a pipe, where FILE is not needed any "     \
    "more."

/* ---- What dithering verbs share ---- */

extern const char *const hdr_dither_words[]; /* by hdr_dither_kind */

/* Their two options, for a table whose params struct has a member `dither`. */
#define HDR_DITHER_OPTIONS(params)                                                                                     \
    {.name = "dither",                                                                                                 \
     .type = HDR_OPTION_CHOICE,                                                                                        \
     .offset = offsetof(params, dither.kind),                                                                          \
     .metavar = "KIND",                                                                                                \
     .words = hdr_dither_words,                                                                                        \
     .default_value = "none",                                                                                          \
     .help = "round up or down by a pattern, so that areas keep their mean"},                                          \
    {                                                                                                                  \
        .name = "seed", .type = HDR_OPTION_INTEGER, .offset = offsetof(params, dither.seed), .metavar = "N", .min = 0, \
        .max = 4294967295, .default_value = "0", .help = "another number moves the pattern of --dither"                \
    }

/* HDR_USAGE where a seed was given for no pattern. */
hdr_status hdr_dither_check(const hdr_dither_params *params, const hdr_options *given, hdr_error *err);

/* ---- What encodings share ---- */

/* Formats whose samples are float32 whatever comes. */
hdr_sample hdr_format_float(const void *params, int bits);

/* Encodings: refuses to encode what is encoded already unless forced. */
hdr_status hdr_check_linear(const hdr_scene *scene, bool force, hdr_error *err);

typedef struct hdr_encoding_params {
    bool decode, force;
} hdr_encoding_params;

/* Their two options, for a table whose params struct has a member `encoding`. */
#define HDR_ENCODING_OPTIONS(params)                                                                                   \
    {.name = "decode",                                                                                                 \
     .type = HDR_OPTION_FLAG,                                                                                          \
     .offset = offsetof(params, encoding.decode),                                                                      \
     .help = "the inverse: from encoded to linear"},                                                                   \
    {                                                                                                                  \
        .name = "force", .type = HDR_OPTION_FLAG, .offset = offsetof(params, encoding.force),                          \
        .help = "encode even what is encoded already"                                                                  \
    }

/* What the manual says about it: the last paragraph of such a verb's details. */
#define HDR_ENCODING_DETAILS "\n\nA picture that is encoded already is refused unless --force is given."

/* A curve and its inverse, each channel by itself, the state that the curve's name is, and what plan() is to return. */
hdr_verdict hdr_encoding_step(const hdr_encoding_params *params, const hdr_curve *encode, const hdr_curve *decode,
                              const char *state, const hdr_scene *scene, hdr_step *step, hdr_error *err);

/* The clause that undoes an encoding, by its state's name: "gamma --exponent 2.2 --decode". */
#define HDR_CLAUSE_TEXT 100
void hdr_decoding_clause(const char *state, char clause[HDR_CLAUSE_TEXT]);

#endif

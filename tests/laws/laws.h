/* What the laws are tried with: every filter of the registry with every sort of value that its option table allows,
 * pictures that are hard in some way, and a way to run the one on the other in memory. Nothing here knows a verb by
 * name. */
#ifndef HDR_TESTS_LAWS_H
#define HDR_TESTS_LAWS_H

#include "check.h"
#include "verb/verb.h"

#include <float.h>
#include <glob.h>
#include <limits.h>
#include <math.h>
#include <png.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* ---- Random numbers: splitmix64 ---- */

static uint64_t law_random_state = 1;

static inline uint64_t law_random(void) {
    uint64_t z = law_random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static inline double law_random_unit(void) {
    return (double)(law_random() >> 11) * 0x1p-53;
}

static inline double law_random_log(double low, double high) {
    return low * pow(high / low, law_random_unit());
}

/* ---- Variants of verbs ---- */

enum { VARIANT_OPTIONS = 3, MAX_VARIANTS = 4000, MAX_VALUES = 400 };

/* An option with a value; that of a flag is empty. */
typedef struct law_value {
    const hdr_option *option;
    char text[80];
} law_value;

typedef struct law_variant {
    const hdr_verb *verb;
    law_value value[VARIANT_OPTIONS];
    int values;
    char words[240]; /* "log --mode range --percentile 12.5" */
} law_variant;

static law_variant law_variants[MAX_VARIANTS];
static int law_variant_count;

static inline bool law_is_word(const law_value *value) {
    return value->option->type == HDR_OPTION_FLAG || value->option->type == HDR_OPTION_CHOICE;
}

static inline int law_add_value(law_value *list, int count, const hdr_option *option, const char *format, ...) {
    if (count >= MAX_VALUES) abort();
    list[count].option = option;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(list[count].text, sizeof list[count].text, format, arguments);
    va_end(arguments);
    for (int i = 0; i < count; i++)
        if (list[i].option == option && !strcmp(list[i].text, list[count].text)) return count;
    return count + 1;
}

/* Ends and middle of a range, and numbers that are typical of anything. */
static inline int law_add_numbers(law_value *list, int count, const hdr_option *option) {
    static const double typical[] = {-1, 0.25, 1, 3};
    bool ranged = option->min != 0 || option->max != 0, whole = option->type == HDR_OPTION_INTEGER;
    for (size_t i = 0; i < sizeof typical / sizeof *typical; i++) {
        double number = typical[i];
        if (ranged && (number <= option->min || number > option->max)) continue;
        if (!whole || number == floor(number)) count = law_add_value(list, count, option, "%g", number);
    }
    if (!ranged) return count;
    double lowest = !option->above_min ? option->min : whole ? option->min + 1 : nextafter(option->min, INFINITY);
    double middle = option->min / 2 + option->max / 2;
    if (isfinite(lowest)) count = law_add_value(list, count, option, "%.17g", lowest);
    if (isfinite(middle)) count = law_add_value(list, count, option, "%.17g", whole ? floor(middle) : middle);
    if (isfinite(option->max)) count = law_add_value(list, count, option, "%.17g", option->max);
    return count;
}

static inline int law_add_decimals(law_value *list, int count, const hdr_option *option) {
    static const char *const typical[] = {"0", "0.1", "12.5", "50", "99.9", "100"};
    for (size_t i = 0; i < sizeof typical / sizeof *typical; i++) {
        double number = strtod(typical[i], NULL);
        bool ranged = option->min != 0 || option->max != 0;
        if (!ranged || (number >= option->min && number <= option->max))
            count = law_add_value(list, count, option, "%s", typical[i]);
    }
    return count;
}

/* An ordinary shot, one with nothing lit, one of a single colour, and the ends of what is taken. */
static inline int law_add_shots(law_value *list, int count, const hdr_option *option) {
    static const char *const shots[] = {"log_average=0.25,max_luminance=4000,p1=0.001,p99=300",
                                        "log_average=0,max_luminance=0,p1=0,p99=0",
                                        "log_average=0.18,max_luminance=0.18,p1=0.18,p99=0.18",
                                        "log_average=1e-200,max_luminance=1e50,p1=1e-200,p99=1e50"};
    for (size_t i = 0; i < sizeof shots / sizeof *shots; i++)
        count = law_add_value(list, count, option, "%s", shots[i]);
    return count;
}

/* The values that one option is tried with. Texts have no typical ones: they name files. */
static inline int law_add_values(law_value *list, int count, const hdr_option *option) {
    for (int w = 0; option->words && option->words[w]; w++)
        count = law_add_value(list, count, option, "%s", option->words[w]);
    switch (option->type) {
    case HDR_OPTION_FLAG:
        return law_add_value(list, count, option, "%s", "");
    case HDR_OPTION_NUMBER:
    case HDR_OPTION_INTEGER:
        return law_add_numbers(list, count, option);
    case HDR_OPTION_DECIMAL:
        return law_add_decimals(list, count, option);
    case HDR_OPTION_FACTS:
        return law_add_shots(list, count, option);
    case HDR_OPTION_CHOICE:
    case HDR_OPTION_SIZE:
    case HDR_OPTION_TEXT:
        break;
    }
    return count;
}

/* Keeps a variant unless the verb says that its options do not go together. */
static inline void law_add_variant(const hdr_verb *verb, const law_value *a, const law_value *b, const law_value *c) {
    if (law_variant_count == MAX_VARIANTS) abort();
    law_variant *variant = &law_variants[law_variant_count];
    *variant = (law_variant){.verb = verb};
    if (a) variant->value[variant->values++] = *a;
    if (b) variant->value[variant->values++] = *b;
    if (c) variant->value[variant->values++] = *c;
    char names[VARIANT_OPTIONS][80];
    const char *words[1 + 2 * VARIANT_OPTIONS] = {verb->about.name};
    int count = 1;
    size_t used = (size_t)snprintf(variant->words, sizeof variant->words, "%s", verb->about.name);
    for (int i = 0; i < variant->values; i++) {
        const law_value *value = &variant->value[i];
        bool flag = value->option->type == HDR_OPTION_FLAG;
        snprintf(names[i], sizeof names[i], "--%s", value->option->name);
        words[count++] = names[i];
        if (!flag) words[count++] = value->text;
        used += (size_t)snprintf(variant->words + used, sizeof variant->words - used, " --%s%s%s", value->option->name,
                                 flag ? "" : " ", flag ? "" : value->text);
    }
    hdr_error error = {0};
    hdr_chain *chain = hdr_chain_new(&error);
    hdr_status status = hdr_chain_add(chain, words, count, &error);
    CHECK(status == HDR_OK || (status == HDR_USAGE && variant->values > 0), "%s: %s", variant->words, error.message);
    law_variant_count += status == HDR_OK;
    hdr_chain_free(chain);
}

/* Pairs of which one is a flag or a choice, as these change what the other means; and those with one more flag. */
static inline void law_add_combinations(const hdr_verb *verb, const law_value *list, int count) {
    for (int i = 0; i < count; i++)
        for (int j = i + 1; j < count; j++) {
            if (list[i].option == list[j].option || !(law_is_word(&list[i]) || law_is_word(&list[j]))) continue;
            law_add_variant(verb, &list[i], &list[j], NULL);
            for (int k = j + 1; k < count; k++)
                if (list[k].option->type == HDR_OPTION_FLAG && list[k].option != list[j].option)
                    law_add_variant(verb, &list[i], &list[j], &list[k]);
        }
}

/* Defaults, each option alone, and combinations. */
static inline void law_make_variants(void) {
    const hdr_verb *verb;
    for (int v = 0; (verb = hdr_verb_number(v)) != NULL; v++) {
        if (verb->about.kind != HDR_FILTER) continue;
        law_value list[MAX_VALUES];
        int count = 0;
        for (const hdr_option *option = verb->about.options; option && option->name; option++)
            count = law_add_values(list, count, option);
        law_add_variant(verb, NULL, NULL, NULL);
        for (int i = 0; i < count; i++)
            law_add_variant(verb, &list[i], NULL, NULL);
        law_add_combinations(verb, list, count);
    }
}

/* Its parameters, as a chain would hold them. Free both. */
static inline void *law_parameters(const law_variant *variant, hdr_options *given) {
    const hdr_verb *verb = variant->verb;
    void *params = calloc(1, verb->params_size + 1);
    hdr_options_default(verb->about.options, params);
    for (int i = 0; i < variant->values; i++) {
        const hdr_option *option = variant->value[i].option;
        hdr_option_set(option, option->type == HDR_OPTION_FLAG ? NULL : variant->value[i].text, params, given, NULL);
    }
    return params;
}

/* What the verb needs to know with these parameters. */
static inline hdr_request law_request(const law_variant *variant) {
    hdr_options given = {0};
    hdr_request request = {0};
    void *params = law_parameters(variant, &given);
    if (variant->verb->needs) variant->verb->needs(params, &request);
    hdr_options_free(&given);
    free(params);
    return request;
}

/* ---- Pictures ---- */

typedef struct law_picture {
    const char *path; /* NULL: the planes */
    char name[200];
    int width, height, planes;
    float *plane[3], *alpha;
    bool few;      /* too big to be tried with every variant */
    bool moderate; /* may be scaled by 2^-20 to 2^20: nothing over- or underflows, nor does straight colour */
} law_picture;

enum { MAX_PICTURES = 64 };
static law_picture law_pictures[MAX_PICTURES];
static int law_picture_count;

static inline size_t law_pixels(const law_picture *picture) {
    return (size_t)picture->width * (size_t)picture->height;
}

static inline law_picture law_new_picture(const char *name, int width, int height, int planes, bool alpha) {
    law_picture picture = {.width = width, .height = height, .planes = planes};
    snprintf(picture.name, sizeof picture.name, "%s", name);
    for (int p = 0; p < planes; p++)
        picture.plane[p] = calloc(law_pixels(&picture), sizeof(float));
    if (alpha) picture.alpha = calloc(law_pixels(&picture), sizeof(float));
    return picture;
}

static inline void law_free_picture(law_picture *picture) {
    for (int p = 0; p < 3; p++)
        free(picture->plane[p]);
    free(picture->alpha);
    *picture = (law_picture){0};
}

static inline law_picture *law_add_picture(const char *name, int width, int height, int planes, bool alpha) {
    if (law_picture_count == MAX_PICTURES) abort();
    law_pictures[law_picture_count] = law_new_picture(name, width, height, planes, alpha);
    return &law_pictures[law_picture_count++];
}

/* Values of the ordinary sort: positive, twelve decades. */
static inline float law_ordinary(void) {
    return (float)law_random_log(1e-6, 1e6);
}

/* One in eight is something that a render holds by mistake. */
static inline float law_hard(void) {
    switch (law_random() % 64) {
    case 0:
        return NAN;
    case 1:
        return INFINITY;
    case 2:
        return -INFINITY;
    case 3:
        return -0.0f;
    case 4:
        return 0;
    case 5:
    case 6:
    case 7:
        return -law_ordinary();
    default:
        return law_ordinary();
    }
}

/* The ends of float, and any bits at all. */
static inline float law_extreme(void) {
    static const float ends[] = {FLT_MAX, -FLT_MAX, FLT_MIN, -FLT_MIN, FLT_TRUE_MIN, -FLT_TRUE_MIN,
                                 65504,   65536,    1,       0,        -0.0f,        INFINITY};
    uint64_t kind = law_random() % 16;
    if (kind < sizeof ends / sizeof *ends) return ends[kind];
    uint32_t bits = (uint32_t)law_random();
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline void law_fill(law_picture *picture, float (*value)(void)) {
    picture->moderate = value == law_ordinary || value == law_hard;
    for (int p = 0; p < picture->planes; p++)
        for (size_t i = 0; i < law_pixels(picture); i++)
            picture->plane[p][i] = value();
}

static inline void law_make_grey(law_picture *picture) {
    for (int p = 1; p < picture->planes; p++)
        memcpy(picture->plane[p], picture->plane[0], law_pixels(picture) * sizeof(float));
}

static inline void law_fill_constant(law_picture *picture, float value) {
    for (int p = 0; p < picture->planes; p++)
        for (size_t i = 0; i < law_pixels(picture); i++)
            picture->plane[p][i] = value;
}

static inline void law_fill_alpha(law_picture *picture, float (*value)(void)) {
    picture->moderate &= value == NULL; /* a tiny alpha makes colours huge */
    for (size_t i = 0; i < law_pixels(picture); i++)
        picture->alpha[i] = value ? value() : 1;
}

static inline float law_translucent(void) {
    static const float some[] = {0, 1, 0.25f, 0x1p-24f, -0.5f, 2, NAN, 1e-30f};
    uint64_t kind = law_random() % 12;
    return kind < sizeof some / sizeof *some ? some[kind] : (float)law_random_unit();
}

static inline float law_halves(void) { /* every half in turn, as a float */
    static unsigned next;
    unsigned half = next++ & 0xffff, exponent = half >> 10 & 31, fraction = half & 1023;
    double value = exponent == 0 ? ldexp(fraction, -24) : ldexp(1024 + fraction, (int)exponent - 25);
    if (exponent == 31) value = fraction ? (double)NAN : (double)INFINITY;
    return (float)(half & 0x8000 ? -value : value);
}

/* Widths that are no multiple of 8 and pass a strip's 512, heights that pass a block's 16. */
static inline void law_make_synthetic(void) {
    law_fill(law_add_picture("hard", 37, 61, 3, false), law_hard);
    law_fill(law_add_picture("hard, wide", 1037, 9, 3, false), law_hard);
    law_fill(law_add_picture("hard, one plane", 65, 37, 1, false), law_hard);
    law_fill(law_add_picture("ordinary", 45, 50, 3, false), law_ordinary);
    law_fill(law_add_picture("extreme", 40, 36, 3, false), law_extreme);
    law_fill(law_add_picture("one pixel", 1, 1, 3, false), law_ordinary);
    law_fill(law_add_picture("one row", 700, 1, 3, false), law_hard);
    law_fill(law_add_picture("one column", 1, 700, 3, false), law_hard);
    law_fill_constant(law_add_picture("constant", 20, 33, 3, false), 0.18f);
    law_fill_constant(law_add_picture("black", 20, 33, 3, false), 0);
    law_fill_constant(law_add_picture("black of -0", 5, 4, 3, false), -0.0f);
    law_fill_constant(law_add_picture("negative", 5, 33, 3, false), -2);
    law_fill_constant(law_add_picture("all NaN", 5, 4, 3, false), NAN);
    law_fill_constant(law_add_picture("all Inf", 5, 4, 3, false), INFINITY);
    law_picture *grey = law_add_picture("grey in three planes", 70, 40, 3, false);
    law_fill(grey, law_hard);
    law_make_grey(grey);
    law_picture *nearly = law_add_picture("grey and opaque but for the last pixel", 70, 40, 3, true);
    law_fill(nearly, law_ordinary);
    law_make_grey(nearly);
    law_fill_alpha(nearly, NULL);
    nearly->plane[1][law_pixels(nearly) - 1] += 1;
    nearly->alpha[law_pixels(nearly) - 1] = 0.5f;
    law_picture *translucent = law_add_picture("alpha", 70, 40, 3, true);
    law_fill(translucent, law_hard);
    law_fill_alpha(translucent, law_translucent);
    law_picture *extremes = law_add_picture("extreme, alpha too", 40, 36, 3, true);
    law_fill(extremes, law_extreme);
    law_fill_alpha(extremes, law_extreme);
    law_picture *large = law_add_picture("more than half of 1M", 212, 212, 3, false);
    law_fill(large, law_hard);
    large->few = true;
    law_picture *halves = law_add_picture("all halves", 256, 256, 1, false);
    law_fill(halves, law_halves);
    halves->few = true;
}

static inline void law_add_files(const char *pattern, bool few) {
    glob_t found;
    if (glob(pattern, 0, NULL, &found) == 0)
        for (size_t i = 0; i < found.gl_pathc && law_picture_count < MAX_PICTURES; i++) {
            law_picture *picture = &law_pictures[law_picture_count++];
            *picture = (law_picture){.path = strdup(found.gl_pathv[i]), .few = few};
            snprintf(picture->name, sizeof picture->name, "%s", picture->path);
        }
    globfree(&found);
}

/* ---- Running ---- */

typedef struct law_result {
    hdr_status status;
    unsigned char *bytes;
    size_t size;
    char said[8000]; /* notes and explanations, line by line */
    char message[1000];
} law_result;

static inline void law_hear(void *context, hdr_message kind, const char *line) {
    law_result *result = context;
    size_t used = strlen(result->said);
    if (kind != HDR_DETAIL) snprintf(result->said + used, sizeof result->said - used, "%s\n", line);
}

static inline hdr_input *law_open(const law_picture *picture, hdr_error *error) {
    if (picture->path) return hdr_input_open(picture->path, error);
    return hdr_input_planes(picture->width, picture->height, picture->planes, (const float *const *)picture->plane,
                            picture->alpha, error);
}

/* Runs a command line on the picture, into memory. Free the bytes. */
__attribute__((format(printf, 2, 3))) static inline law_result law_run(const law_picture *picture, const char *format,
                                                                       ...) {
    law_result result = {0};
    char line[1000];
    const char *words[100];
    int count = 0;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    for (char *word = strtok(line, " "); word && count < 100; word = strtok(NULL, " "))
        words[count++] = word;
    hdr_error error = {0};
    hdr_chain *chain = hdr_chain_new(&error);
    hdr_chain_parse(chain, count, words, &error);
    hdr_input *input = error.status ? NULL : law_open(picture, &error);
    hdr_output *output = hdr_output_memory(&error);
    hdr_listener listener = {law_hear, &result};
    if (!error.status) hdr_chain_run(chain, input, output, &listener, &error);
    if (!error.status) {
        const void *bytes = hdr_output_bytes(output, &result.size);
        result.bytes = malloc(result.size + 1);
        memcpy(result.bytes, bytes, result.size);
        result.bytes[result.size] = 0; /* sscanf reads strings */
    }
    result.status = error.status;
    snprintf(result.message, sizeof result.message, "%s", error.message);
    hdr_output_free(output);
    hdr_input_free(input);
    hdr_chain_free(chain);
    return result;
}

static inline bool law_same(const law_result *a, const law_result *b) {
    return a->status == b->status && a->size == b->size && (a->size == 0 || !memcmp(a->bytes, b->bytes, a->size));
}

static inline uint64_t law_digest(const void *bytes, size_t size) { /* FNV-1a */
    uint64_t digest = 0xcbf29ce484222325u;
    for (size_t i = 0; i < size; i++)
        digest = (digest ^ ((const unsigned char *)bytes)[i]) * 0x100000001b3u;
    return digest;
}

/* ---- Reading results ---- */

/* The numbers of a PFM; free them. */
static inline float *law_read_pfm(const law_result *result, size_t *count) {
    int width, height, at = 0;
    char kind;
    float scale;
    *count = 0;
    if (result->size < 8 ||
        sscanf((const char *)result->bytes, "P%c %d %d %f%n", &kind, &width, &height, &scale, &at) < 4)
        return NULL;
    *count = (size_t)width * (size_t)height * (kind == 'F' ? 3 : 1);
    if (result->size != (size_t)at + 1 + *count * sizeof(float)) return NULL;
    float *values = malloc(*count * sizeof(float) + 1);
    memcpy(values, result->bytes + at + 1, *count * sizeof(float));
    return values;
}

/* Components of an uncompressed EXR of scan lines, and how many of them are no finite numbers. Bytes are read as they
 * are, since a reader of this library would repair them. False: it is no such file. */
static inline bool law_count_exr(const law_result *result, bool half, size_t *count, size_t *bad) {
    const unsigned char *bytes = result->bytes;
    size_t at = 8, size = result->size;
    int32_t window[4] = {0}, length = 0;
    *count = *bad = 0;
    while (at < size && bytes[at]) { /* attributes: name, type, length, value */
        bool is_window = !strcmp((const char *)bytes + at, "dataWindow");
        for (int word = 0; word < 2; word++)
            at += strlen((const char *)bytes + at) + 1;
        if (at + 4 > size) return false;
        memcpy(&length, bytes + at, 4);
        if (is_window) memcpy(window, bytes + at + 4, sizeof window);
        at += 4 + (size_t)length;
    }
    at += 1 + 8 * ((size_t)(window[3] - window[1]) + 1); /* the table of lines */
    while (at + 8 <= size) {                             /* a line: y, length, values */
        memcpy(&length, bytes + at + 4, 4);
        at += 8;
        if (length <= 0 || (size_t)length > size - at) return false;
        for (const unsigned char *end = bytes + at + length, *from = bytes + at; from < end; from += half ? 2 : 4) {
            uint32_t bits = 0;
            memcpy(&bits, from, half ? 2 : 4);
            uint32_t exponent = half ? 0x7c00u : 0x7f800000u;
            *bad += (bits & exponent) == exponent;
            ++*count;
        }
        at += (size_t)length;
    }
    return at == size && *count > 0;
}

typedef struct law_cursor {
    const law_result *from;
    size_t at;
} law_cursor;

static inline void law_png_read(png_structp png, png_bytep to, size_t size) {
    law_cursor *cursor = png_get_io_ptr(png);
    if (size > cursor->from->size - cursor->at) png_error(png, "the file ends early");
    memcpy(to, cursor->from->bytes + cursor->at, size);
    cursor->at += size;
}

static inline void law_png_warning(png_structp png, png_const_charp words) {
    (void)png;
    CHECK(false, "libpng warns about a PNG that was written: %s", words);
}

/* The samples of a PNG, of 8 or 16 bits, as they are stored; free them. */
static inline uint16_t *law_read_png(const law_result *result, size_t *count) {
    law_cursor cursor = {result, 0};
    uint16_t *volatile samples = NULL;
    *count = 0;
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, law_png_warning);
    png_infop info = png_create_info_struct(png);
    if (setjmp(png_jmpbuf(png)) == 0) {
        png_set_read_fn(png, &cursor, law_png_read);
        png_read_png(png, info, PNG_TRANSFORM_IDENTITY, NULL);
        size_t rows = png_get_image_height(png, info), wide = png_get_bit_depth(png, info) == 16;
        size_t in_row = png_get_rowbytes(png, info) >> wide;
        samples = malloc(rows * in_row * sizeof *samples + 1);
        for (size_t i = 0; i < rows * in_row; i++) {
            const unsigned char *row = png_get_rows(png, info)[i / in_row];
            size_t x = i % in_row;
            samples[i] = wide ? (uint16_t)(row[2 * x] << 8 | row[2 * x + 1]) : row[x];
        }
        *count = rows * in_row;
    }
    png_destroy_read_struct(&png, &info, NULL);
    return samples;
}

/* The farthest of all codes of two PNGs. */
static inline int law_code_distance(const law_result *a, const law_result *b) {
    size_t count = 0, other_count = 0;
    uint16_t *codes = law_read_png(a, &count), *others = law_read_png(b, &other_count);
    int farthest = codes && others && count == other_count ? 0 : INT_MAX;
    for (size_t i = 0; farthest != INT_MAX && i < count; i++) {
        int distance = abs((int)codes[i] - (int)others[i]);
        farthest = distance > farthest ? distance : farthest;
    }
    free(codes);
    free(others);
    return farthest;
}

#endif

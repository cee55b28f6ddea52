/* Chains run on EXR files that are made here, by OpenEXRCore: what comes out, and what is said on the way. */
#include "check.h"
#include "exr_make.h"

#include <hdrpipe.h>
#include <math.h>

static uint64_t random_state = 11;

/* What a run has come to. */
typedef struct outcome {
    hdr_error error;
    char said[4000]; /* line by line */
    hdr_output *output;
    const unsigned char *bytes;
    size_t size;
} outcome;

static void hear(void *context, hdr_message kind, const char *line) {
    char *said = context;
    size_t used = strlen(said);
    if (kind != HDR_DETAIL) snprintf(said + used, sizeof((outcome *)0)->said - used, "%s\n", line);
}

/* Runs a command line's words, which have single spaces between them, on a picture's bytes. */
static outcome run_on(const void *bytes, size_t size, const char *words) {
    outcome out = {.error = {.status = HDR_OK}};
    char text[300];
    const char *word[40];
    int count = 0;
    snprintf(text, sizeof text, "%s", words);
    for (char *at = strtok(text, " "); at && count < 40; at = strtok(NULL, " "))
        word[count++] = at;
    hdr_chain *chain = hdr_chain_new(&out.error);
    hdr_input *input = hdr_input_memory(bytes, size, "made", &out.error);
    out.output = hdr_output_memory(&out.error);
    hdr_listener listener = {hear, out.said};
    hdr_status status = hdr_chain_parse(chain, count, word, &out.error);
    if (!status) hdr_chain_run(chain, input, out.output, &listener, &out.error);
    if (!out.error.status) out.bytes = hdr_output_bytes(out.output, &out.size);
    hdr_input_free(input);
    hdr_chain_free(chain);
    return out;
}

static outcome run_recipe(recipe r, const char *words) {
    file_bytes file;
    CHECK(make_exr(&r, &random_state, &file), "a file cannot be made");
    outcome out = run_on(file.data, file.size, words);
    free_recipe(&r);
    free(file.data);
    return out;
}

static bool contains(const outcome *out, const char *text) {
    return out->bytes && memmem(out->bytes, out->size, text, strlen(text));
}

static float float_at(const outcome *out, size_t place) {
    float value = NAN;
    if (out->bytes && place + sizeof value <= out->size) memcpy(&value, out->bytes + place, sizeof value);
    return value;
}

/* A run that succeeds and says a text, or (NULL) nothing at all. */
static void says(recipe r, const char *words, const char *text) {
    outcome out = run_recipe(r, words);
    CHECK(out.error.status == HDR_OK, "%s: %s", words, out.error.message);
    CHECK(text ? strstr(out.said, text) != NULL : out.said[0] == '\0', "%s says: %s", words, out.said);
    hdr_output_free(out.output);
}

static void refuses(recipe r, const char *words, const char *text) {
    outcome out = run_recipe(r, words);
    CHECK(out.error.status == HDR_BAD_DATA && strstr(out.error.message, text) && strstr(out.error.message, "made: "),
          "%s: %d %s", words, out.error.status, out.error.message);
    hdr_output_free(out.output);
}

#define CONSTANT(channel, kind, number)                                                                                \
    { .name = channel, .type = EXR_PIXEL_##kind, .constant = true, .value = number }
#define RGB_OF(value) CONSTANT("B", FLOAT, value), CONSTANT("G", FLOAT, value), CONSTANT("R", FLOAT, value)

static const exr_attr_chromaticities_t aces = {.red_x = 0.7347f,
                                               .red_y = 0.2653f,
                                               .green_x = 0,
                                               .green_y = 1,
                                               .blue_x = 0.0001f,
                                               .blue_y = -0.077f,
                                               .white_x = 0.32168f,
                                               .white_y = 0.33767f};

static const recipe small_grey = {.width = 4, .height = 3, .channels = 1, .channel = {CONSTANT("Y", FLOAT, 0.5)}};
static const recipe small_rgb = {.width = 4, .height = 3, .channels = 3, .channel = {RGB_OF(0.5)}};

/* ---- Grey has no colour of its own ---- */

static void check_grey_elsewhere(void) {
    recipe grey = small_grey;
    grey.chromaticities = &aces;
    outcome out = run_recipe(grey, "pfs");
    size_t plane = 4 * 3 * sizeof(float);
    const double d65[3] = {0.3127 / 0.3290, 1, (1 - 0.3127 - 0.3290) / 0.3290};
    for (size_t p = 0; p < 3; p++) {
        float value = float_at(&out, out.size - plane * (3 - p));
        CHECK(fabs((double)value - 0.5 * d65[p]) < 1e-6, "PFS of grey: %c is %g", "XYZ"[p], (double)value);
    }
    hdr_output_free(out.output);
    out = run_recipe(grey, "rgbe");
    CHECK(contains(&out, "PRIMARIES=0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329\n"), "Radiance HDR of grey");
    hdr_output_free(out.output);
    recipe colour = small_rgb;
    colour.chromaticities = &aces;
    out = run_recipe(colour, "rgbe --primaries keep");
    CHECK(contains(&out, "PRIMARIES=0.7347 0.2653 0 1 0.0001 -0.077 0.32168 0.33767\n"), "Radiance HDR of colour");
    hdr_output_free(out.output);
}

/* ---- Channels that are missing ---- */

static void check_missing(void) {
    recipe two = {
        .width = 4, .height = 3, .channels = 2, .channel = {CONSTANT("G", FLOAT, 1), CONSTANT("R", FLOAT, 1)}};
    says(two, "exr", "made: no channel B: taken as 0\n");
    recipe one = {.width = 4, .height = 3, .channels = 1, .channel = {CONSTANT("G", FLOAT, 1)}};
    says(one, "exr", "made: no channels R, B: taken as 0\n");
    says(small_rgb, "exr", NULL);
    says(small_grey, "exr --explain --alpha over:1,0,0 --crop 1,1,9,9", "laid over");
}

/* ---- Encoded values ---- */

static void check_over_encoded(void) {
    recipe r = {.width = 4, .height = 3, .channels = 4, .channel = {CONSTANT("A", FLOAT, 0.5), RGB_OF(0.25)}};
    says(r, "exr --alpha over:1,1,1", NULL);
    r.state = "srgb";
    refuses(r, "exr --alpha over:1,1,1", "hdr srgb --decode then exr");
    says(r, "exr --alpha drop", NULL);
    r.state = "gamma 1.8";
    refuses(r, "exr --alpha over:1,1,1", "hdr gamma --exponent 1.8 --decode then exr");
    recipe opaque = small_rgb;
    opaque.state = "srgb";
    says(opaque, "exr --alpha over:1,1,1", NULL);
    refuses(opaque, "exr --alpha over:1,1,1 --crop 1,1,9,9", "encoded (srgb)");
}

int main(void) {
    check_grey_elsewhere();
    check_missing();
    check_over_encoded();
    return check_done("test_run");
}

/* Chains run on EXR files that are made here, by OpenEXRCore: what comes out, and what is said on the way. */
#include "chain/run.h"
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

/* What a format cannot tell of the encoding is said. */
static void check_states(void) {
    static const struct {
        const char *words, *said;
    } cases[] = {
        {"pfm", NULL},
        {"srgb : exr", NULL},
        {"srgb : png", NULL},
        {"srgb : pfs", NULL},
        {"srgb : srgb --decode : rgbe", NULL},
        {"srgb : pfm", "pfm cannot tell that the picture is encoded (srgb)\n"},
        {"gamma -g 1.8 : rgbe", "rgbe cannot tell that the picture is encoded (gamma 1.8)\n"},
        {"gamma -g 1.8 : pfs", "pfs cannot tell how the picture is encoded (gamma 1.8): readers take it for sRGB\n"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        says(small_rgb, cases[i].words, cases[i].said);
    recipe encoded = small_rgb;
    encoded.state = "srgb";
    says(encoded, "rgbe", "rgbe cannot tell that the picture is encoded (srgb)\n");
}

/* ---- Refusals that say what is wrong ---- */

static void check_refusals(void) {
    static const exr_attr_chromaticities_t nothing = {.red_x = 0},
                                           xyz = {.red_x = 1, .green_y = 1, .white_x = 1.0f / 3, .white_y = 1.0f / 3};
    static const exr_attr_v2f_t zero = {.x = 0, .y = 0};
    recipe r = {.width = 4,
                .height = 4,
                .sampling = 2,
                .channels = 2,
                .channel = {CONSTANT("Y", FLOAT, 1), {.name = "Z", .type = EXR_PIXEL_FLOAT}}};
    refuses(r, "exr --channel Z", "a subsampled channel cannot be read by itself");

    r = small_rgb;
    r.chromaticities = &nothing;
    refuses(r, "exr", "its attribute chromaticities is broken");
    recipe grey = small_grey;
    grey.chromaticities = &nothing;
    says(grey, "exr", NULL);
    says(grey, "exp : png", NULL);
    r.chromaticities = &aces;
    r.neutral = &zero;
    refuses(r, "png", "white cannot be adapted from adoptedNeutral (0,0) to D65; --adapt none");
    says(r, "png --adapt none", NULL);

    r = small_rgb;
    r.chromaticities = &aces;
    says(r, "png --explain", "white adapted to D65");
    r.chromaticities = &xyz;
    says(r, "png --explain", "converted to Rec.709, white left as it is");

    recipe covered = {.width = 4, .height = 4, .channels = 4, .channel = {CONSTANT("A", UINT, 7), RGB_OF(0.5)}};
    refuses(covered, "exr", "--alpha drop reads the colours without it");
    says(covered, "exr --alpha drop", NULL);

    refuses(small_rgb, "png --crop 0,0,99999,99999", "the rectangle of 99999 x 99999 pixels that --crop asks for");
    refuses(small_rgb, "exr --crop=-2147483648,0,4,4", "a window from -2147483648,0 to -2147483645,3; the coordinates");
    refuses(small_rgb, "exr --crop=-1073741823,0,4,4", "coordinates of an EXR");
    refuses(small_rgb, "exr --crop=0,1073741820,4,4", "coordinates of an EXR");
    says(small_rgb, "exr --crop=-1073741822,1073741819,4,4", NULL);
    says(small_rgb, "png --crop=-2147483648,0,4,4", NULL);
}

/* ---- Frames ---- */

static void check_frames(void) {
    static const char frame[] = "PFS1\n1 1\n2\n0\nY\n0\nDEPTH\n0\nENDH12341234PFS1\n1 1\n";
    for (size_t behind = 0; behind <= 2; behind++) {
        const char *const words[] = {"pfm", "pfm --crop 0,0,1,1", "exr --crop 5,5,1,1"};
        for (size_t w = 0; w < 3; w++) {
            outcome out = run_on(frame, sizeof frame - 1 - 9 + behind * 9 / 2, words[w]);
            const char *said = behind ? "made: there is more behind the first frame, which alone is read\n" : "";
            CHECK(out.error.status == HDR_OK, "%s: %s", words[w], out.error.message);
            CHECK(strcmp(out.said, said) == 0, "%s, %zu bytes more: %s", words[w], behind, out.said);
            hdr_output_free(out.output);
        }
    }
}

/* ---- Blocks ---- */

/* A run without the writing. */
typedef struct opened {
    hdr_chain *chain;
    hdr_input *input;
    hdr_run run;
    hdr_error error;
} opened;

static bool open_run(opened *o, const file_bytes *file, int count, const char *const words[]) {
    *o = (opened){.error = {.status = HDR_OK}};
    o->chain = hdr_chain_new(&o->error);
    o->input = hdr_input_memory(file->data, file->size, "made", &o->error);
    if (!hdr_chain_parse(o->chain, count, words, &o->error))
        hdr_run_open(&o->run, o->chain, o->input, NULL, NULL, &o->error);
    CHECK(o->error.status == HDR_OK, "%s", o->error.message);
    return o->error.status == HDR_OK;
}

static void close_run(opened *o) {
    hdr_run_close(&o->run);
    hdr_input_free(o->input);
    hdr_chain_free(o->chain);
}

/* A block's planes as one number, to compare. */
static uint64_t sum_of(const hdr_block *block, size_t width) {
    uint64_t sum = 0;
    for (int p = 0; p < 4; p++)
        for (int row = 0; block->plane[p] && row < block->rows; row++)
            for (size_t i = 0; i < width * hdr_type_size(block->type[p]); i++)
                sum = sum * 31 + block->plane[p][(size_t)row * block->stride[p] + i];
    return sum;
}

/* Blocks that are kept hold what was decoded, in planes that any type may be read from. */
static void check_kept(void) {
    static const char *const crops[] = {"0,0,7,50", "1,3,5,40", "2,5,3,33", "0,15,7,19"};
    for (int form = 0; form < 8; form++) {
        recipe r = {.width = 7,
                    .height = 53,
                    .compression = form & 4 ? EXR_COMPRESSION_ZIPS : EXR_COMPRESSION_ZIP,
                    .channels = 4,
                    .channel = {{.name = "A", .type = form & 1 ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT},
                                {.name = "B", .type = EXR_PIXEL_HALF},
                                {.name = "G", .type = form & 2 ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT},
                                {.name = "R", .type = EXR_PIXEL_FLOAT}}};
        file_bytes file;
        CHECK(make_exr(&r, &random_state, &file), "a file cannot be made");
        for (size_t c = 0; c < sizeof crops / sizeof crops[0]; c++) {
            const char *const words[] = {"exr", "-j", "1", "--crop", crops[c]};
            uint64_t decoded[64] = {0};
            opened o;
            if (!open_run(&o, &file, 5, words)) continue;
            size_t width = (size_t)hdr_window_width(&o.run.source->picture.data);
            hdr_block block;
            for (int i = 0; i < o.run.source->blocks; i++)
                if (!hdr_run_read(&o.run, 0, i, &block, &o.error)) decoded[i] = sum_of(&block, width);
            hdr_run_keep(&o.run);
            CHECK(o.run.kept != NULL, "nothing is kept");
            for (int i = 0; i < 2 * o.run.source->blocks; i++) {
                int index = i % o.run.source->blocks;
                CHECK(hdr_run_read(&o.run, 0, index, &block, &o.error) == HDR_OK, "%s", o.error.message);
                CHECK(sum_of(&block, width) == decoded[index], "form %d, crop %s: block %d", form, crops[c], index);
                for (int p = 0; p < 4; p++)
                    CHECK((uintptr_t)block.plane[p] % hdr_type_size(block.type[p]) == 0 &&
                              block.plane[p] + block.stride[p] * (size_t)block.rows <= o.run.kept + o.run.kept_size,
                          "form %d, crop %s: plane %d of block %d", form, crops[c], p, index);
            }
            close_run(&o);
        }
        free_recipe(&r);
        free(file.data);
    }
}

/* ---- How often a block is decoded ---- */

static int reads_of_middle;
static hdr_status (*read_on)(hdr_source *source, void *worker, int block, hdr_block *out, hdr_error *err);

static hdr_status count_read(hdr_source *source, void *worker, int block, hdr_block *out, hdr_error *err) {
    reads_of_middle += block == source->blocks / 2;
    return read_on(source, worker, block, out, err);
}

/* Once, whether or not it is looked at to guess what the picture is. */
static void check_decoded_once(void) {
    static const char *const formats[] = {"png", "exr", "pfm", "rgbe"};
    for (int form = 0; form < 16; form++) {
        recipe r = {.width = 9, .height = 70, .compression = EXR_COMPRESSION_ZIP};
        static const char *const names[] = {"A", "B", "G", "R"};
        bool alpha = form & 4, grey = form & 8;
        for (int c = alpha ? 0 : 1; c < 4; c++) {
            r.channel[r.channels].name = names[c];
            r.channel[r.channels].type = EXR_PIXEL_FLOAT;
            r.channel[r.channels].constant = grey || c == 0;
            r.channel[r.channels++].value = c == 0 ? 0.5 : 0.25;
        }
        const char *format = formats[form & 3], *const words[] = {format, "-j", "1"};
        file_bytes file;
        opened o;
        CHECK(make_exr(&r, &random_state, &file), "a file cannot be made");
        if (open_run(&o, &file, 3, words)) {
            hdr_output *output = hdr_output_memory(&o.error);
            const hdr_clause *clause = &o.chain->clauses[0];
            read_on = o.run.source->read;
            o.run.source->read = count_read;
            reads_of_middle = 0;
            CHECK(hdr_run_write(&o.run, clause->verb, clause->params, output, "linear", 0, false, &o.error) == HDR_OK,
                  "%s: %s", format, o.error.message);
            CHECK(reads_of_middle == 1, "form %d, %s: the middle block is decoded %d times", form, format,
                  reads_of_middle);
            o.run.source->read = read_on;
            close_run(&o);
            hdr_output_free(output);
        }
        free_recipe(&r);
        free(file.data);
    }
}

/* ---- Percentiles of components that are no floats ---- */

static double median_of(recipe r, int count, const char *const words[]) {
    hdr_facts facts = {.known = 0};
    hdr_request request = {.percentiles = 1, .percentile = {{HDR_OF_COMPONENTS, {50, 0}}}};
    file_bytes file;
    opened o;
    CHECK(make_exr(&r, &random_state, &file), "a file cannot be made");
    if (open_run(&o, &file, count, words)) {
        CHECK(hdr_run_facts(&o.run, &request, NULL, NULL, &facts, &o.error) == HDR_OK, "%s", o.error.message);
        close_run(&o);
    }
    free_recipe(&r);
    free(file.data);
    return facts.percentile[0];
}

static void check_percentiles(void) {
    recipe ids = {.width = 5, .height = 5, .channels = 1, .channel = {CONSTANT("id", UINT, 16777217)}};
    const char *const channel[] = {"exr", "--channel", "id"}, *const over[] = {"exr", "--alpha", "over:0.7,0.7,0.7"};
    double median = median_of(ids, 3, channel);
    CHECK(median == 16777217, "the median of whole numbers is %.17g", median);
    recipe r = {.width = 5, .height = 5, .channels = 4, .channel = {CONSTANT("A", FLOAT, 0.25), RGB_OF(0.125)}};
    median = median_of(r, 3, over);
    CHECK(median == 0.125 + 0.75 * 0.7, "the median over a colour is %.17g", median);
}

int main(void) {
    check_grey_elsewhere();
    check_missing();
    check_over_encoded();
    check_states();
    check_refusals();
    check_frames();
    check_kept();
    check_decoded_once();
    check_percentiles();
    return check_done("test_run");
}

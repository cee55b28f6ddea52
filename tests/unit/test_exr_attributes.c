/* Attributes of a header go along into the file that is written: files are put together byte by byte here, run through
 * chains by the public interface, and the header that comes out is taken apart byte by byte. */
#include "check.h"
#include "hdrpipe.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { FILE_MAX = 24 << 20 };

typedef struct made {
    unsigned char *data;
    size_t size;
} made;

/* ---- A file of one black pixel ---- */

static void put(made *file, const void *bytes, size_t size) {
    if (file->size + size > FILE_MAX) abort();
    memcpy(file->data + file->size, bytes, size);
    file->size += size;
}

static void put_number(made *file, uint64_t number, int bytes) {
    for (int i = 0; i < bytes; i++)
        file->data[file->size++] = (unsigned char)(number >> 8 * i);
}

static void put_attribute(made *file, const char *name, const char *type, const void *value, size_t size) {
    put(file, name, strlen(name) + 1);
    put(file, type, strlen(type) + 1);
    put_number(file, size, 4);
    put(file, value, size);
}

static void begin_file(made *file) {
    static const unsigned char start[8] = {0x76, 0x2f, 0x31, 0x01, 2, 4}; /* long names */
    static const unsigned char channels[19] = {'Y', 0, 2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1};
    static const unsigned char one[4] = {0, 0, 0x80, 0x3f}, zeros[16] = {0};
    if (!file->data) file->data = malloc(FILE_MAX);
    if (!file->data) abort();
    file->size = 0;
    put(file, start, sizeof start);
    put_attribute(file, "channels", "chlist", channels, sizeof channels);
    put_attribute(file, "compression", "compression", zeros, 1);
    put_attribute(file, "dataWindow", "box2i", zeros, 16);
    put_attribute(file, "displayWindow", "box2i", zeros, 16);
    put_attribute(file, "lineOrder", "lineOrder", zeros, 1);
    put_attribute(file, "pixelAspectRatio", "float", one, 4);
}

static void put_screen(made *file) {
    static const unsigned char one[4] = {0, 0, 0x80, 0x3f}, zeros[8] = {0};
    put_attribute(file, "screenWindowCenter", "v2f", zeros, 8);
    put_attribute(file, "screenWindowWidth", "float", one, 4);
}

static void end_file(made *file) {
    put(file, "", 1);
    put_number(file, file->size + 8, 8); /* the chunk stands behind its table */
    put_number(file, 0, 4);
    put_number(file, 4, 4);
    put_number(file, 0x3e800000, 4); /* 0.25 */
}

/* ---- Its way through a chain ---- */

static char said[2000];

static void hear(void *context, hdr_message kind, const char *line) {
    (void)context;
    if (kind == HDR_NOTE) snprintf(said + strlen(said), sizeof said - strlen(said), "%s\n", line);
}

/* The written file; free its data. */
static made run(const made *file, const char *const words[], int count) {
    hdr_error error = {0};
    hdr_chain *chain = hdr_chain_new(&error);
    hdr_input *input = hdr_input_memory(file->data, file->size, "made", &error);
    hdr_output *output = hdr_output_memory(&error);
    const hdr_listener listener = {hear, NULL};
    said[0] = '\0';
    hdr_status status = hdr_chain_parse(chain, count, words, &error);
    if (status == HDR_OK) status = hdr_chain_run(chain, input, output, &listener, &error);
    CHECK(status == HDR_OK, "%s: %s", words[0], error.message);
    made out = {NULL, 0};
    const void *bytes = hdr_output_bytes(output, &out.size);
    out.data = malloc(out.size + 1);
    if (!out.data) abort();
    if (out.size) memcpy(out.data, bytes, out.size);
    hdr_output_free(output);
    hdr_input_free(input);
    hdr_chain_free(chain);
    return out;
}

#define RUN(file, ...)                                                                                                 \
    run(file, (const char *const[]){__VA_ARGS__}, sizeof((const char *const[]){__VA_ARGS__}) / sizeof(char *))

/* An attribute's value in the written header, or NULL. How often it stands there goes to *times. */
static const unsigned char *find(const made *file, const char *name, const char *type, size_t *size, int *times) {
    const unsigned char *at = file->data + 8, *found = NULL;
    *times = 0;
    while (*at) {
        const char *this_name = (const char *)at, *this_type = this_name + strlen(this_name) + 1;
        const unsigned char *value = (const unsigned char *)this_type + strlen(this_type) + 1 + 4;
        size_t length = (size_t)value[-4] | (size_t)value[-3] << 8 | (size_t)value[-2] << 16 | (size_t)value[-1] << 24;
        if (!strcmp(this_name, name) && !strcmp(this_type, type)) {
            found = value;
            *size = length;
            ++*times;
        }
        at = value + length;
    }
    return found;
}

static bool has(const made *file, const char *name, const char *type, const void *value, size_t size) {
    size_t found_size = 0;
    int times;
    const unsigned char *found = find(file, name, type, &found_size, &times);
    return found && times == 1 && found_size == size && !memcmp(found, value, size);
}

static bool lacks(const made *file, const char *name, const char *type) {
    size_t size;
    int times;
    return !find(file, name, type, &size, &times);
}

/* ---- Tests ---- */

static const struct {
    const char *name, *type;
    size_t size;
    bool random; /* any bytes are a value */
    const char *value;
} every_type[] = {
    {"aBox2i", "box2i", 16, false, "\1\0\0\0\2\0\0\0\3\0\0\0\4\0\0\0"},
    {"aBox2f", "box2f", 16, true, NULL},
    {"chromaticitiesOfOldCamera", "chromaticities", 32, true, NULL},
    {"aCompression", "compression", 1, false, "\3"},
    {"aDouble", "double", 8, true, NULL},
    {"envmap", "envmap", 1, false, "\1"},
    {"expTime", "float", 4, true, NULL},
    {"curve", "floatvector", 20, true, NULL},
    {"anInt", "int", 4, true, NULL},
    {"keyCode", "keycode", 28, false, "\1\0\0\0\2\0\0\0\3\0\0\0\4\0\0\0\5\0\0\0\6\0\0\0\7\0\0\0"},
    {"m3", "m33f", 36, true, NULL},
    {"m3d", "m33d", 72, true, NULL},
    {"worldToCamera", "m44f", 64, true, NULL},
    {"m4d", "m44d", 128, true, NULL},
    {"framesPerSecond", "rational", 8, false, "\x30\x75\0\0\xe9\x03\0\0"},
    {"owner", "string", 11, false, "Nobody\nelse"},
    {"comments", "string", 0, false, ""},
    {"names", "stringvector", 15, false, "\3\0\0\0one\0\0\0\0\0\0\0\0"},
    {"timeCode", "timecode", 8, false, "\x12\x34\x05\0\0\0\0\0"},
    {"offset", "v2i", 8, true, NULL},
    {"lens", "v2f", 8, true, NULL},
    {"lensd", "v2d", 16, true, NULL},
    {"grid", "v3i", 12, true, NULL},
    {"sun", "v3f", 12, true, NULL},
    {"sund", "v3d", 24, true, NULL},
    {"ourOwn", "acme.render.settings", 77, true, NULL},
    {"a.name/that/is/longer/than/thirty-one/letters", "string", 5, false, "value"},
    {"screenWindowCenter", "v2f", 8, false, "\0\0\x80\x3f\0\0\0\x40"},
    {"screenWindowWidth", "float", 4, false, "\0\0\x40\x40"},
    {"adoptedNeutral", "v2f", 8, false, "\x3d\x0a\xa0\x3e\x8f\xc2\xa8\x3e"},
    {"whiteLuminance", "float", 4, false, "\0\0\xc8\x42"},
    {"wrapmodes", "string", 8, false, "periodic"},
};
enum { TYPES = sizeof every_type / sizeof every_type[0] };

static void test_every_type(made *file) {
    unsigned char value[TYPES][128];
    begin_file(file);
    for (int i = 0; i < TYPES; i++) {
        for (size_t b = 0; b < sizeof value[i]; b++)
            value[i][b] = (unsigned char)(37 * b + 11 * (size_t)i + 1);
        if (!every_type[i].random) memcpy(value[i], every_type[i].value, every_type[i].size);
        put_attribute(file, every_type[i].name, every_type[i].type, value[i], every_type[i].size);
    }
    end_file(file);
    made plain = RUN(file, "exr"), tiny = RUN(file, "exr", "--compression", "none", "--type", "half");
    made altered = RUN(file, "clamp", ":", "exr"), cropped = RUN(file, "exr", "--crop", "0,0,1,1");
    made again = RUN(&plain, "exr");
    CHECK(!said[0], "said: %s", said);
    for (int i = 0; i < TYPES; i++) {
        const char *name = every_type[i].name, *type = every_type[i].type;
        size_t size = every_type[i].size;
        CHECK(has(&plain, name, type, value[i], size), "%s is not what it was", name);
        CHECK(has(&tiny, name, type, value[i], size), "%s is not what it was in half", name);
        CHECK(has(&again, name, type, value[i], size), "%s is not what it was, the second time", name);
        bool of_frame = !strncmp(name, "screenWindow", 12) || !strcmp(name, "envmap") || !strcmp(name, "wrapmodes");
        CHECK(has(&cropped, name, type, value[i], size) != of_frame, "%s, cropped", name);
        bool of_values = !strcmp(name, "whiteLuminance");
        CHECK(has(&altered, name, type, value[i], size) != of_values, "%s, altered", name);
    }
    CHECK(lacks(&altered, "whiteLuminance", "float") && lacks(&cropped, "envmap", "envmap"), "they are another value");
    free(plain.data);
    free(tiny.data);
    free(altered.data);
    free(cropped.data);
    free(again.data);
}

static void test_left_out(made *file) {
    static const unsigned char zeros[64] = {0};
    begin_file(file);
    put_screen(file);
    put_attribute(file, "preview", "preview", "\1\0\0\0\1\0\0\0rgba", 12);
    put_attribute(file, "idManifest", "idmanifest", zeros, 20);
    put_attribute(file, "acesImageContainerFlag", "int", "\1\0\0\0", 4);
    put_attribute(file, "dwaCompressionLevel", "float", zeros, 4);
    put_attribute(file, "hdrpipeChain", "string", "clamp then exr", 14);
    put_attribute(file, "owner", "string", "me", 2);
    end_file(file);
    made out = RUN(file, "exr");
    CHECK(lacks(&out, "preview", "preview") && lacks(&out, "idManifest", "idmanifest"), "a thumbnail goes along");
    CHECK(lacks(&out, "acesImageContainerFlag", "int") && lacks(&out, "dwaCompressionLevel", "float"), "storage");
    CHECK(lacks(&out, "hdrpipeChain", "string"), "an old record stands for the new file");
    CHECK(has(&out, "owner", "string", "me", 2), "the owner is lost");
    CHECK(!said[0], "said: %s", said);
    free(out.data);
}

/* Damaged ones do not harm the others, and are told. */
static void test_damaged(made *file) {
    begin_file(file);
    put_screen(file);
    put_attribute(file, "expTime", "float", "\0\0", 2);
    put_attribute(file, "names", "stringvector", "\xff\0\0\0one", 7);
    put_attribute(file, "owner", "string", "me", 2);
    put_attribute(file, "owner", "string", "another", 7);
    put_attribute(file, "timeCode", "timecode", "\0", 1);
    put_attribute(file, "comments", "string", "yes", 3);
    end_file(file);
    made out = RUN(file, "exr");
    CHECK(has(&out, "owner", "string", "me", 2) && has(&out, "comments", "string", "yes", 3), "good ones are lost");
    CHECK(lacks(&out, "expTime", "float") && lacks(&out, "names", "stringvector"), "damaged ones go along");
    CHECK(strstr(said, "4 attributes"), "said: %s", said);
    free(out.data);
}

/* Values that the library would alter, or fail at, are left out and told; the file is written all the same. */
static void test_awkward(made *file) {
    static const struct {
        const char *name, *type, *value;
        size_t size;
    } awkward[] = {{"curve", "floatvector", "", 0},
                   {"secret", "string", "ab\0cd", 5},
                   {"secrets", "stringvector", "\5\0\0\0ab\0cd", 9},
                   {"nothing", "acme.empty", "", 0}};
    for (size_t i = 0; i < sizeof awkward / sizeof *awkward; i++) {
        begin_file(file);
        put_screen(file);
        put_attribute(file, awkward[i].name, awkward[i].type, awkward[i].value, awkward[i].size);
        put_attribute(file, "owner", "string", "me", 2);
        end_file(file);
        made out = RUN(file, "exr");
        CHECK(lacks(&out, awkward[i].name, awkward[i].type), "%s goes along", awkward[i].name);
        CHECK(has(&out, "owner", "string", "me", 2), "the owner is lost beside %s", awkward[i].name);
        CHECK(strstr(said, "1 attribute of"), "%s: said: %s", awkward[i].name, said);
        free(out.data);
    }
    begin_file(file);
    put_screen(file);
    put_attribute(file, "hdrpipeChain", "acme.record", "12345", 5);
    end_file(file);
    made out = RUN(file, "exr", "--record");
    CHECK(has(&out, "hdrpipeChain", "string", "exr --record", 12), "a record of another type stands in the way");
    free(out.data);
}

static void test_large(made *file) {
    const size_t large = 5 << 20, too_large = 17 << 20;
    unsigned char *manifest = malloc(too_large);
    if (!manifest) abort();
    memset(manifest, 'm', too_large);
    begin_file(file);
    put_screen(file);
    put_attribute(file, "cryptomatte/1a2b3c4/manifest", "string", manifest, large);
    put_attribute(file, "owner", "string", "me", 2);
    end_file(file);
    made out = RUN(file, "exr");
    CHECK(has(&out, "cryptomatte/1a2b3c4/manifest", "string", manifest, large), "the manifest is not what it was");
    CHECK(!said[0], "said: %s", said);
    free(out.data);
    begin_file(file);
    put_screen(file);
    put_attribute(file, "manifest", "string", manifest, too_large);
    put_attribute(file, "owner", "string", "me", 2);
    end_file(file);
    out = RUN(file, "exr");
    CHECK(lacks(&out, "manifest", "string") && has(&out, "owner", "string", "me", 2), "the limit");
    CHECK(strstr(said, "1 attribute of"), "said: %s", said);
    free(out.data);
    free(manifest);
}

static void test_record(made *file) {
    static const char first[] = "expose --ev 1 --crop 0,0,1,1 then clamp then exr --record",
                      both[] = "expose --ev 1 --crop 0,0,1,1 then clamp then exr --record\nexr --type half --record";
    begin_file(file);
    put_screen(file);
    end_file(file);
    made out = RUN(file, "expose", "--ev=1", "-j", "2", "--no-skip", ":", "clamp", "--crop", "0,0,1,1", ":", "exr",
                   "--record");
    CHECK(has(&out, "hdrpipeChain", "string", first, strlen(first)), "the record is another");
    made again = RUN(&out, "exr", "--type", "half", "--record"), without = RUN(&out, "exr");
    CHECK(has(&again, "hdrpipeChain", "string", both, strlen(both)), "the second record is another");
    CHECK(lacks(&without, "hdrpipeChain", "string"), "a record that was not asked for");
    free(out.data);
    free(again.data);
    free(without.data);
}

/* Where primaries are converted the neutral goes with them. */
static void test_converted(made *file) {
    static const float ap0[8] = {0.7347f, 0.2653f, 0, 1, 0.0001f, -0.077f, 0.32168f, 0.33767f};
    static const float neutral[2] = {0.32168f, 0.33767f};
    static const unsigned char channels[55] = "B\0\2\0\0\0\0\0\0\0\1\0\0\0\1\0\0\0"
                                              "G\0\2\0\0\0\0\0\0\0\1\0\0\0\1\0\0\0"
                                              "R\0\2\0\0\0\0\0\0\0\1\0\0\0\1\0\0\0";
    begin_file(file);
    /* three channels in place of the one */
    unsigned char *rest = file->data + 8 + 9 + 7 + 4 + 19;
    made head = {malloc(FILE_MAX), 0};
    if (!head.data) abort();
    put(&head, file->data, 8);
    put_attribute(&head, "channels", "chlist", channels, sizeof channels);
    put(&head, rest, (size_t)(file->data + file->size - rest));
    put_screen(&head);
    put_attribute(&head, "chromaticities", "chromaticities", ap0, sizeof ap0);
    put_attribute(&head, "adoptedNeutral", "v2f", neutral, sizeof neutral);
    put(&head, "", 1);
    put_number(&head, head.size + 8, 8);
    put_number(&head, 0, 4);
    put_number(&head, 12, 4);
    for (int c = 0; c < 3; c++)
        put_number(&head, 0x3e800000, 4);
    made kept = RUN(&head, "clamp", ":", "exr"), converted = RUN(&head, "srgb", ":", "exr");
    CHECK(has(&kept, "chromaticities", "chromaticities", ap0, sizeof ap0), "chromaticities are lost");
    CHECK(has(&kept, "adoptedNeutral", "v2f", neutral, sizeof neutral), "the neutral is lost");
    CHECK(lacks(&converted, "chromaticities", "chromaticities") && lacks(&converted, "adoptedNeutral", "v2f"),
          "they are not the picture's any more");
    free(kept.data);
    free(converted.data);
    free(head.data);
}

/* ---- Weights ---- */

/* An attribute's value, and the number that it is. */
typedef struct weight {
    const char *type;
    double number;
    size_t size;
    unsigned char value[16];
} weight;

/* A file of one pixel with that attribute; without it where the type is NULL. */
static made weighted_file(float pixel, const weight *w) {
    made file = {NULL, 0};
    begin_file(&file);
    if (w->type) put_attribute(&file, "samples", w->type, w->value, w->size);
    put_screen(&file);
    end_file(&file);
    memcpy(file.data + file.size - sizeof pixel, &pixel, sizeof pixel);
    return file;
}

/* The mean by those weights, or nothing, and the status that is expected. */
static made weighted_mean(const weight *first, const weight *second, hdr_status expected, const char *what) {
    hdr_error error = {0};
    made file[2] = {weighted_file(0.25F, first), weighted_file(3, second)}, out = {NULL, 0};
    hdr_input *member[2] = {hdr_input_memory(file[0].data, file[0].size, "first", &error),
                            hdr_input_memory(file[1].data, file[1].size, "second", &error)};
    hdr_input *input = hdr_input_join(2, member, &error);
    hdr_output *output = hdr_output_memory(&error);
    hdr_chain *chain = hdr_chain_new(&error);
    const char *const words[] = {"mean", "--weights", "from:samples", ":", "exr", "--compression", "none"};
    hdr_chain_parse(chain, sizeof words / sizeof *words, words, &error);
    if (error.status == HDR_OK) hdr_chain_run(chain, input, output, NULL, &error);
    CHECK(error.status == expected, "%s: status %d: %s", what, error.status, error.message);
    if (expected != HDR_OK)
        CHECK(strstr(error.message, "second") && strstr(error.message, "samples"), "%s: %s", what, error.message);
    const void *bytes = error.status == HDR_OK ? hdr_output_bytes(output, &out.size) : NULL;
    if (bytes) {
        out.data = malloc(out.size);
        if (!out.data) abort();
        memcpy(out.data, bytes, out.size);
    }
    hdr_output_free(output);
    hdr_input_free(input);
    for (int i = 0; i < 2; i++) {
        hdr_input_free(member[i]);
        free(file[i].data);
    }
    hdr_chain_free(chain);
    return out;
}

static void test_weights(void) {
    static const struct {
        const char *what;
        weight first, second, sum;
    } good[] = {
        {"int", {"int", 16, 4, {16}}, {"int", 48, 4, {48}}, {"int", 64, 4, {64}}},
        {"large int",
         {"int", 2147483647, 4, {0xff, 0xff, 0xff, 0x7f}},
         {"int", 1, 4, {1}},
         {"double", 2147483648, 8, {0, 0, 0, 0, 0, 0, 0xe0, 0x41}}},
        {"int and float",
         {"int", 16, 4, {16}},
         {"float", 0.5, 4, {0, 0, 0, 0x3f}},
         {"double", 16.5, 8, {0, 0, 0, 0, 0, 0x80, 0x30, 0x40}}},
        {"float",
         {"float", 16.5, 4, {0, 0, 0x84, 0x41}},
         {"float", 0.25, 4, {0, 0, 0x80, 0x3e}},
         {"float", 16.75, 4, {0, 0, 0x86, 0x41}}},
        {"double",
         {"double", 3, 8, {0, 0, 0, 0, 0, 0, 0x08, 0x40}},
         {"double", 0.5, 8, {0, 0, 0, 0, 0, 0, 0xe0, 0x3f}},
         {"double", 3.5, 8, {0, 0, 0, 0, 0, 0, 0x0c, 0x40}}},
        {"string", {"string", 128, 3, "128"}, {"string", 64.5, 4, "64.5"}, {"string", 192.5, 5, "192.5"}},
        {"string and int", {"string", 9, 1, "9"}, {"int", 1, 4, {1}}, {"string", 10, 2, "10"}},
    };
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        double a = good[i].first.number, b = good[i].second.number, wanted = (a * 0.25 + b * 3) / (a + b);
        float pixel = 0;
        made mean = weighted_mean(&good[i].first, &good[i].second, HDR_OK, good[i].what);
        if (!mean.data) continue;
        memcpy(&pixel, mean.data + mean.size - sizeof pixel, sizeof pixel);
        CHECK(pixel == (float)wanted, "%s: the mean is %.9g, should be %.9g", good[i].what, (double)pixel, wanted);
        CHECK(has(&mean, "samples", good[i].sum.type, good[i].sum.value, good[i].sum.size), "%s: it has no sum",
              good[i].what);
        free(mean.data);
    }
    static const weight right = {"int", 16, 4, {16}};
    static const struct {
        const char *what;
        weight wrong;
    } bad[] = {
        {"none", {NULL, 0, 0, {0}}},
        {"zero", {"int", 0, 4, {0}}},
        {"below zero", {"int", 0, 4, {0xff, 0xff, 0xff, 0xff}}},
        {"NaN", {"float", 0, 4, {0, 0, 0xc0, 0x7f}}},
        {"infinity", {"float", 0, 4, {0, 0, 0x80, 0x7f}}},
        {"no number", {"string", 0, 4, "many"}},
        {"more than a number", {"string", 0, 6, "16 spp"}},
        {"no text", {"string", 0, 0, {0}}},
        {"another type", {"v2i", 0, 8, {1}}},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        free(weighted_mean(&right, &bad[i].wrong, HDR_BAD_DATA, bad[i].what).data);
}

int main(void) {
    made file = {NULL, 0};
    test_every_type(&file);
    test_left_out(&file);
    test_damaged(&file);
    test_awkward(&file);
    test_large(&file);
    test_record(&file);
    test_converted(&file);
    test_weights();
    free(file.data);
    return check_done("test_exr_attributes");
}

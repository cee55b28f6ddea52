/* DWAA and DWAB by way of the plug-in: what is written comes back within what the level allows, for every shape, and
 * damaged chunks end in a message. tests/cli/test_dwa.sh compares with OpenEXR's C++ library. */
#include "check.h"
#include "exr_make.h"
#include "hdrpipe.h"
#include "io/exr_dwa.h"
#include "io/source.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDE = 70, HIGH = 600, DAMAGED_COPIES = 3000 };

static float colour[3][WIDE * HIGH], alpha[WIDE * HIGH];
static uint64_t random_state = 7;

/* Smooth and textured parts, and a black one. */
static void paint(void) {
    for (int i = 0; i < WIDE * HIGH; i++) {
        double x = i % WIDE, y = i / WIDE; /* as if every picture were WIDE pixels wide: it only has to be a picture */
        for (int p = 0; p < 3; p++)
            colour[p][i] = x < 8 && y < 16 ? 0 : (float)(exp(2 * sin(x / 9 + p) * cos(y / 17)) + (i * 7 % 13) * 0.01);
        alpha[i] = i % 5 == 0 ? 0.25f : 1;
        for (int p = 0; p < 3; p++)
            colour[p][i] *= alpha[i];
    }
}

/* Runs one clause on an input. The bytes are the caller's. */
static hdr_status run(hdr_input *input, const char *const words[], int count, file_bytes *file, hdr_error *error) {
    hdr_chain *chain = hdr_chain_new(error);
    hdr_output *output = hdr_output_memory(error);
    hdr_status status = error->status;
    size_t size = 0;
    *file = (file_bytes){NULL, 0};
    if (status == HDR_OK) status = hdr_chain_add(chain, words, count, error);
    if (status == HDR_OK) status = hdr_chain_run(chain, input, output, NULL, error);
    const void *bytes = status == HDR_OK ? hdr_output_bytes(output, &size) : NULL;
    if (bytes) {
        file->data = malloc(size);
        if (!file->data) abort();
        memcpy(file->data, bytes, size);
        file->size = size;
    }
    hdr_output_free(output);
    hdr_chain_free(chain);
    return status;
}

struct shape {
    int width, height, planes;
    bool alpha, half;
    const char *compression, *level, *threads;
};

static hdr_status write_dwa(const struct shape *s, file_bytes *file, hdr_error *error) {
    const float *planes[3] = {colour[0], colour[1], colour[2]};
    const char *words[] = {
        "exr", "--compression", s->compression, "--type", s->half ? "half" : "float", "--dwa-level=0",
        "-j",  s->threads,      s->level};
    char level[32];
    if (s->level) {
        snprintf(level, sizeof level, "--dwa-level=%s", s->level);
        words[5] = level;
    }
    hdr_input *input = hdr_input_planes(s->width, s->height, s->planes, planes, s->alpha ? alpha : NULL, error);
    hdr_status status = input ? run(input, words, 8, file, error) : error->status;
    hdr_input_free(input);
    return status;
}

static bool missing(const hdr_error *error) {
    return strstr(error->message, "plug-in hdrpipe-exr.so, which is not installed") != NULL;
}

/* ---- There and back ---- */

/* The largest difference over all planes, relative to values of at least 0.1. */
static double largest_error(const struct shape *s, const file_bytes *file, hdr_error *error) {
    hdr_input *input = hdr_input_memory(file->data, file->size, "written", error);
    hdr_source *source = input ? hdr_source_open(input, &(hdr_reading){.memory = 1 << 28}, error) : NULL;
    void *worker = NULL;
    double worst = 0;
    if (source && source->worker_new(source, &worker, error) == HDR_OK)
        for (int b = 0; b < source->blocks; b++) {
            hdr_block block;
            if (source->read(source, worker, b, &block, error) != HDR_OK) break;
            for (int p = 0; p < 4; p++) {
                if (!source->picture.present[p]) continue;
                for (int i = 0; i < block.rows * s->width; i++) {
                    const unsigned char *row =
                        (const unsigned char *)block.plane[p] + block.stride[p] * (size_t)(i / s->width);
                    float value;
                    if (block.type[p] == HDR_FLOAT) {
                        memcpy(&value, row + 4 * (i % s->width), 4);
                    } else {
                        uint16_t bits;
                        memcpy(&bits, row + 2 * (i % s->width), 2);
                        value = bits & 0x7c00 ? ldexpf((float)((bits & 0x3ff) | 0x400), ((bits >> 10) & 31) - 25)
                                              : ldexpf((float)(bits & 0x3ff), -24);
                        if (bits & 0x8000) value = -value;
                    }
                    int at = block.first_row * s->width + i;
                    float wanted = p == 3 ? alpha[at] : colour[p][at];
                    double difference = fabs((double)value - (double)wanted) / fmax(fabs((double)wanted), 0.1);
                    if (!(difference <= worst)) worst = difference;
                }
            }
        }
    if (source) {
        source->worker_free(source, worker);
        hdr_source_close(source);
    }
    hdr_input_free(input);
    return worst;
}

static void test_shapes(void) {
    static const int sizes[][2] = {{1, 1}, {8, 8}, {3, 70}, {37, 33}, {WIDE, HIGH}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++)
        for (int kind = 0; kind < 16; kind++) {
            struct shape s = {.width = sizes[i][0],
                              .height = sizes[i][1],
                              .planes = kind & 1 ? 3 : 1,
                              .alpha = (kind & 2) != 0,
                              .half = (kind & 4) != 0,
                              .compression = kind & 8 ? "dwab" : "dwaa",
                              .threads = "1"};
            char name[100];
            hdr_error error = {.status = HDR_OK};
            file_bytes one, two;
            snprintf(name, sizeof name, "%d x %d, %s, kind %d", s.width, s.height, s.compression, kind);
            CHECK(write_dwa(&s, &one, &error) == HDR_OK, "%s: %s", name, error.message);
            if (error.status != HDR_OK) continue;
            double worst = largest_error(&s, &one, &error);
            CHECK(error.status == HDR_OK && worst < 0.02, "%s: %g off %s", name, worst, error.message);
            s.threads = "3";
            CHECK(write_dwa(&s, &two, &error) == HDR_OK && one.size == two.size &&
                      memcmp(one.data, two.data, one.size) == 0,
                  "%s: other bytes with three threads", name);
            free(one.data);
            free(two.data);
        }
}

/* A higher level loses more and packs smaller. */
static void test_levels(void) {
    static const char *const levels[] = {"0", "45", "400"};
    struct shape s = {.width = WIDE, .height = HIGH, .planes = 3, .half = true, .compression = "dwaa", .threads = "2"};
    double worst_before = 0;
    size_t size_before = SIZE_MAX;
    for (size_t i = 0; i < sizeof levels / sizeof levels[0]; i++) {
        hdr_error error = {.status = HDR_OK};
        file_bytes file;
        s.level = levels[i];
        CHECK(write_dwa(&s, &file, &error) == HDR_OK, "level %s: %s", s.level, error.message);
        if (error.status != HDR_OK) continue;
        double worst = largest_error(&s, &file, &error);
        CHECK(worst > worst_before && file.size < size_before, "level %s: %zu bytes, %g off", s.level, file.size,
              worst);
        worst_before = worst;
        size_before = file.size;
        free(file.data);
    }
}

/* ---- The plug-in by itself ---- */

/* Channels that no rule of DWA's knows are kept as they are, sampled at any rate. */
static void test_subsampled(void) {
    enum { W = 22, H = 32, SIZE = W * H * 4 + (W / 2) * (H / 2) * 2 };
    exr_attr_chlist_entry_t entries[] = {
        {.name = {.str = "half size"}, .pixel_type = EXR_PIXEL_HALF, .x_sampling = 2, .y_sampling = 2},
        {.name = {.str = "of a name that is longer than thirty-one characters"},
         .pixel_type = EXR_PIXEL_FLOAT,
         .x_sampling = 1,
         .y_sampling = 1}};
    exr_attr_chlist_t list = {.num_channels = 2, .entries = entries};
    hdr_error error = {.status = HDR_OK};
    hdr_exr_dwa *dwa = hdr_exr_dwa_new(EXR_COMPRESSION_DWAA, &list, &error);
    CHECK(dwa, "subsampled: %s", error.message);
    if (!dwa) return;
    unsigned char pixels[SIZE], packed[SIZE], back[SIZE];
    size_t size = 0;
    for (int i = 0; i < SIZE; i++)
        pixels[i] = (unsigned char)(i % 8 + i / 640);
    CHECK(hdr_exr_dwa_pack(dwa, 45, W, H, pixels, SIZE, packed, SIZE, &size, &error) == HDR_OK && size > 0,
          "subsampled: %s", error.message);
    CHECK(hdr_exr_dwa_unpack(dwa, false, W, H, packed, size, back, SIZE) && memcmp(pixels, back, SIZE) == 0,
          "subsampled: other pixels come back");
    CHECK(!hdr_exr_dwa_unpack(dwa, false, W, H, packed, size - 1, back, SIZE), "the last byte is missing");
    CHECK(!hdr_exr_dwa_unpack(dwa, false, W, H, packed, 0, back, SIZE), "there is no byte");
    CHECK(!hdr_exr_dwa_unpack(dwa, false, W, H, packed, size, back, SIZE - 1), "a size that is not the chunk's");
    CHECK(!hdr_exr_dwa_unpack(dwa, false, W, H + 1, packed, size, back, SIZE), "more lines than DWAA has");
    CHECK(!hdr_exr_dwa_unpack(dwa, false, 0, H, packed, size, back, SIZE), "no columns");
    CHECK(hdr_exr_dwa_pack(dwa, 45, W, H + 1, pixels, SIZE, packed, SIZE, &size, &error) == HDR_INTERNAL && size == 0,
          "more lines than DWAA has are packed");
    error = (hdr_error){.status = HDR_OK};
    for (int i = 0; i < SIZE; i++)
        pixels[i] = (unsigned char)random_bits(&random_state);
    CHECK(hdr_exr_dwa_pack(dwa, 45, W, H, pixels, SIZE, packed, SIZE, &size, &error) == HDR_OK && size == 0,
          "noise is said to become smaller");
    hdr_exr_dwa_free(dwa);
}

/* ---- Damage ---- */

/* Each damaged chunk ends in pixels, or in a message that tells its rows. */
static void test_damage(const struct shape *s) {
    hdr_error error = {.status = HDR_OK};
    file_bytes file;
    unsigned refused = 0;
    CHECK(write_dwa(s, &file, &error) == HDR_OK, "%s", error.message);
    if (error.status != HDR_OK) return;
    for (int i = 0; i < DAMAGED_COPIES; i++) {
        /* in memory of its own size, so that a sanitizer sees a step beyond */
        unsigned char *copy = malloc(file.size);
        if (!copy) abort();
        memcpy(copy, file.data, file.size);
        size_t front = 600; /* the header and the chunk's counters, which are worth more tries than the rest */
        for (int flips = 1 + i % 3; flips > 0; flips--) {
            size_t from = i & 1 ? 350 : 0, range = i & 1 ? front - from : file.size;
            size_t at = (from + random_bits(&random_state) % range) % file.size;
            copy[at] = i & 4 ? (unsigned char)random_bits(&random_state)
                             : copy[at] ^ (unsigned char)(1u << random_bits(&random_state) % 8);
        }
        hdr_input *input = hdr_input_memory(copy, file.size, "damaged", &error);
        file_bytes pixels;
        hdr_status status =
            run(input, (const char *const[]){"pfm", "--window", "data", "--memory=64M", "-j2"}, 5, &pixels, &error);
        CHECK(status == HDR_OK || (status == HDR_BAD_DATA && strncmp(error.message, "damaged: ", 9) == 0),
              "damaged: %d %s", status, error.message);
        if (strstr(error.message, "packed data is damaged")) {
            refused++;
            CHECK(strstr(error.message, "row"), "no rows: %s", error.message);
        }
        error = (hdr_error){.status = HDR_OK};
        hdr_input_free(input);
        free(pixels.data);
        free(copy);
    }
    CHECK(refused > DAMAGED_COPIES / 20, "only %u of %d copies were refused for their packed data", refused,
          DAMAGED_COPIES);
    for (size_t size = 0; size < file.size; size += 1 + size / 40) {
        unsigned char *cut = malloc(size ? size : 1);
        if (!cut) abort();
        memcpy(cut, file.data, size);
        hdr_input *input = hdr_input_memory(cut, size, "damaged", &error);
        file_bytes pixels;
        CHECK(run(input, (const char *const[]){"pfm"}, 1, &pixels, &error) == HDR_BAD_DATA, "cut to %zu bytes", size);
        error = (hdr_error){.status = HDR_OK};
        hdr_input_free(input);
        free(pixels.data);
        free(cut);
    }
    free(file.data);
}

int main(void) {
    paint();
    struct shape plain = {.width = 40, .height = 45, .planes = 3, .alpha = true, .compression = "dwaa", .threads = "1"};
    hdr_error error = {.status = HDR_OK};
    file_bytes file;
    if (write_dwa(&plain, &file, &error) != HDR_OK && missing(&error)) {
        CHECK_SKIP("DWAA and DWAB: %s", error.message);
        return check_done("test_exr_dwa");
    }
    free(file.data);
    test_shapes();
    test_levels();
    test_subsampled();
    test_damage(&plain);
    plain.compression = "dwab";
    plain.half = true;
    plain.level = "45";
    test_damage(&plain);
    return check_done("test_exr_dwa");
}

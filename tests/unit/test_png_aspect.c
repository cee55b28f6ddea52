/* The shape of pixels in PNG files, as libpng reads it. */
#include "check.h"
#include "io/sink.h"

#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

typedef struct byte_reader {
    const unsigned char *data;
    size_t size, at;
} byte_reader;

static void read_bytes(png_structp png, png_bytep out, size_t size) {
    byte_reader *reader = png_get_io_ptr(png);
    if (size > reader->size - reader->at) png_error(png, "end of file");
    memcpy(out, reader->data + reader->at, size);
    reader->at += size;
}

/* What stands in front of the pixels. */
static bool read_head(png_structp png, png_infop info) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_read_info(png, info);
    return true;
}

/* Writes a pixel of that shape. True: the file tells it, as so many across and down. */
static bool write_and_read(float aspect, png_uint_32 *across, png_uint_32 *down) {
    hdr_frame frame = {.width = 1,
                       .height = 1,
                       .planes = 1,
                       .sample = HDR_SAMPLE_U8,
                       .bits = 8,
                       .state = "srgb",
                       .pixel_aspect = aspect};
    hdr_error error = {.status = HDR_OK};
    unsigned char sample = 77;
    void *packer = NULL;
    hdr_output *output = hdr_output_memory(&error);
    hdr_sink *sink = hdr_png_create(output, &frame, &error);
    bool written = sink->begin(sink, &error) == HDR_OK && sink->packer_new(sink, &packer, &error) == HDR_OK &&
                   sink->pack(sink, packer, 0, 1, &sample, &error) == HDR_OK &&
                   sink->deliver(sink, packer, &error) == HDR_OK && sink->end(sink, &error) == HDR_OK &&
                   hdr_output_commit(output, &error) == HDR_OK;
    sink->packer_free(sink, packer);
    sink->close(sink);
    CHECK(written, "%g: %s", (double)aspect, error.message);
    byte_reader reader = {.data = NULL};
    reader.data = hdr_output_bytes(output, &reader.size);
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_set_read_fn(png, &reader, read_bytes);
    CHECK(read_head(png, info), "%g: libpng does not read it", (double)aspect);
    int unit = -1;
    bool told = png_get_pHYs(png, info, across, down, &unit) != 0;
    CHECK(!told || unit == PNG_RESOLUTION_UNKNOWN, "%g: unit %d", (double)aspect, unit);
    png_destroy_read_struct(&png, &info, NULL);
    hdr_output_free(output);
    return told;
}

static int common_divisor(int a, int b) {
    return b ? common_divisor(b, a % b) : a;
}

/* A pixel that is p / q as wide as high: q across are as long as p down. */
static void test_ratios(void) {
    png_uint_32 across = 0, down = 0;
    for (int p = 1; p <= 40; p++)
        for (int q = 1; q <= 40; q++) {
            if (p == q || common_divisor(p, q) != 1) continue;
            bool told = write_and_read((float)((double)p / q), &across, &down);
            CHECK(told && across == (png_uint_32)q && down == (png_uint_32)p, "%d / %d: %u across, %u down", p, q,
                  across, down);
        }
    CHECK(write_and_read(1.0940171f, &across, &down) && across == 117 && down == 128, "128 / 117: %u, %u", across,
          down);
    CHECK(write_and_read(1e6f, &across, &down) && across == 1 && down == 1000000, "10^6: %u, %u", across, down);
    CHECK(write_and_read(1e-6f, &across, &down) && across == 1000000 && down == 1, "10^-6: %u, %u", across, down);
}

/* Any float comes back from the quotient. */
static void test_floats(void) {
    uint32_t random = 1;
    for (int i = 0; i < 2000; i++) {
        png_uint_32 across = 1, down = 0;
        random = random * 1664525 + 1013904223;
        uint32_t bits = 0x35800000 + random % 0x14000000; /* 2^-20 ... 2^20 */
        float aspect;
        memcpy(&aspect, &bits, sizeof aspect);
        bool told = write_and_read(aspect, &across, &down);
        CHECK(told && (float)((double)down / across) == aspect, "%.9g: %u across, %u down", (double)aspect, across,
              down);
    }
}

/* Square pixels need no word, and no chunk can tell the others. */
static void test_silence(void) {
    const float silent[] = {1, 0, -1, -1.5f, INFINITY, -INFINITY, NAN, 3e9f, 1e38f, 1e-10f, 1e-45f};
    for (size_t i = 0; i < sizeof silent / sizeof silent[0]; i++) {
        png_uint_32 across, down;
        CHECK(!write_and_read(silent[i], &across, &down), "%g: a chunk", (double)silent[i]);
    }
}

int main(void) {
    test_ratios();
    test_floats();
    test_silence();
    return check_done("test_png_aspect");
}

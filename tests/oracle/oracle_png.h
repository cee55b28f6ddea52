/* For the oracle: PNG and PFM files read back: a PNG's samples by libpng's own reader, its chunks by walking over them.
 */
#ifndef HDR_TESTS_ORACLE_PNG_H
#define HDR_TESTS_ORACLE_PNG_H

#include "oracle_picture.h"

#include <png.h>
#include <setjmp.h>

typedef struct oracle_png {
    unsigned width, height;
    int depth, colours; /* 1 or 3 */
    bool alpha;
    uint16_t *samples; /* interleaved */
} oracle_png;

typedef struct oracle_bytes {
    const uint8_t *bytes;
    size_t size, at;
} oracle_bytes;

static void oracle_png_feed(png_structp png, png_bytep out, size_t size) {
    oracle_bytes *from = png_get_io_ptr(png);
    if (size > from->size - from->at) png_error(png, "truncated");
    memcpy(out, from->bytes + from->at, size);
    from->at += size;
}

static void oracle_png_warning(png_structp png, png_const_charp message) {
    png_error(png, message); /* a file of ours has to be flawless */
}

static void oracle_png_unpack(png_structp png, png_infop info, oracle_png *picture) {
    png_read_png(png, info, PNG_TRANSFORM_IDENTITY, NULL);
    png_bytepp rows = png_get_rows(png, info);
    picture->width = png_get_image_width(png, info);
    picture->height = png_get_image_height(png, info);
    picture->depth = png_get_bit_depth(png, info);
    picture->colours = png_get_color_type(png, info) & PNG_COLOR_MASK_COLOR ? 3 : 1;
    picture->alpha = png_get_color_type(png, info) & PNG_COLOR_MASK_ALPHA;
    size_t row = (size_t)picture->width * (size_t)(picture->colours + picture->alpha);
    picture->samples = oracle_alloc(row * picture->height, sizeof *picture->samples);
    for (unsigned y = 0; y < picture->height; y++)
        for (size_t i = 0; i < row; i++)
            picture->samples[y * row + i] =
                picture->depth == 8 ? rows[y][i] : (uint16_t)(rows[y][2 * i] << 8 | rows[y][2 * i + 1]);
}

/* The caller frees samples. */
static inline bool oracle_read_png(const void *bytes, size_t size, oracle_png *picture) {
    oracle_bytes from = {bytes, size, 0};
    *picture = (oracle_png){0};
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, oracle_png_warning);
    png_infop info = png_create_info_struct(png);
    if (!png || !info) abort();
    volatile bool done = false;
    if (!setjmp(png_jmpbuf(png))) {
        png_set_read_fn(png, &from, oracle_png_feed);
        oracle_png_unpack(png, info, picture);
        done = from.at == size;
    }
    png_destroy_read_struct(&png, &info, NULL);
    return done;
}

static uint32_t oracle_be32(const uint8_t *bytes) {
    return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

/* A chunk's data, NULL where there is no such chunk; its length must be as expected. */
static inline const uint8_t *oracle_chunk(const uint8_t *bytes, size_t size, const char *type, uint32_t length) {
    for (size_t at = 8; at + 12 <= size; at += 12 + (size_t)oracle_be32(bytes + at))
        if (!memcmp(bytes + at + 4, type, 4)) return oracle_be32(bytes + at) == length ? bytes + at + 8 : NULL;
    return NULL;
}

static inline bool oracle_has_chunk(const uint8_t *bytes, size_t size, const char *type) {
    for (size_t at = 8; at + 12 <= size; at += 12 + (size_t)oracle_be32(bytes + at))
        if (!memcmp(bytes + at + 4, type, 4)) return true;
    return false;
}

/* A PFM: colours per pixel, rows from the top; NULL where it is malformed. The caller frees. */
static inline float *oracle_read_pfm(const void *bytes, size_t size, int *width, int *height, int *colours) {
    char head[64] = {0};
    char kind, newline;
    float scale;
    int length = 0;
    memcpy(head, bytes, size < sizeof head - 1 ? size : sizeof head - 1);
    if (sscanf(head, "P%c %d %d %f%c%n", &kind, width, height, &scale, &newline, &length) < 5 || scale >= 0)
        return NULL;
    *colours = kind == 'F' ? 3 : 1;
    size_t row = (size_t)*width * (size_t)*colours;
    if (size != (size_t)length + row * (size_t)*height * 4) return NULL;
    float *pixels = oracle_alloc(row * (size_t)*height, sizeof(float));
    for (int y = 0; y < *height; y++) /* stored from the bottom, little endian */
        memcpy(pixels + row * (size_t)y, (const char *)bytes + length + row * 4 * (size_t)(*height - 1 - y), row * 4);
    return pixels;
}

#endif

/* For tests: files of plain rasters (PFM, Radiance HDR, PFS) that are put together by hand, and read. */
#ifndef HDR_TESTS_RASTER_MAKE_H
#define HDR_TESTS_RASTER_MAKE_H

#include "check.h"
#include "io/source.h"

#include <stdlib.h>
#include <string.h>

enum { MEMORY = 1 << 28 };

static uint64_t random_state = 1;

/* SplitMix64. */
static inline uint64_t random_bits(void) {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* ---- Reading ---- */

typedef struct image {
    hdr_picture about;
    size_t width, height;
    float *plane[4];
} image;

static inline void image_free(image *image) {
    for (int p = 0; p < 4; p++)
        free(image->plane[p]);
    *image = (struct image){.width = 0};
}

static inline void collect(image *image, const hdr_block *block) {
    for (int p = 0; p < 4; p++)
        for (int row = 0; block->plane[p] && row < block->rows; row++)
            memcpy(image->plane[p] + (size_t)(block->first_row + row) * image->width,
                   block->plane[p] + (size_t)row * block->stride[p], image->width * sizeof(float));
}

/* Reads all blocks, the last one first where backwards. keep: into image, which is freed by the caller in any case. */
static inline hdr_status read_input(hdr_input *input, bool backwards, bool keep, image *image, hdr_error *error) {
    *error = (hdr_error){.status = HDR_OK};
    *image = (struct image){.width = 0};
    hdr_source *source = hdr_source_open(input, &(hdr_reading){.memory = MEMORY}, error);
    void *worker = NULL;
    if (source && source->worker_new(source, &worker, error) == HDR_OK) {
        image->about = source->picture;
        image->width = (size_t)hdr_window_width(&source->picture.data);
        image->height = (size_t)hdr_window_height(&source->picture.data);
        for (int p = 0; keep && p < 4; p++)
            if (source->picture.present[p]) image->plane[p] = calloc(image->width * image->height, sizeof(float));
        for (int i = 0; i < source->blocks && error->status == HDR_OK; i++) {
            hdr_block block;
            int index = backwards ? source->blocks - 1 - i : i;
            if (source->read(source, worker, index, &block, error) == HDR_OK && keep) collect(image, &block);
        }
        source->worker_free(source, worker);
    }
    hdr_source_close(source);
    return error->status;
}

static inline hdr_status read_bytes(const void *bytes, size_t size, bool backwards, image *image, hdr_error *error) {
    hdr_input *input = hdr_input_memory(bytes, size, "memory", error);
    hdr_status status = read_input(input, backwards, true, image, error);
    hdr_input_free(input);
    return status;
}

/* A file that is being put together. */
typedef struct file {
    unsigned char bytes[1 << 18];
    size_t size;
} file;

static inline void add(file *file, const void *bytes, size_t size) {
    if (file->size + size > sizeof file->bytes) abort();
    memcpy(file->bytes + file->size, bytes, size);
    file->size += size;
}

static inline void add_text(file *file, const char *text) {
    add(file, text, strlen(text));
}

static inline void add_float(file *file, float value, bool big_endian) {
    uint32_t bits;
    unsigned char bytes[4];
    memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 4; i++)
        bytes[i] = (unsigned char)(bits >> (big_endian ? 24 - 8 * i : 8 * i));
    add(file, bytes, sizeof bytes);
}

#endif

/* For tests: EXR files written to memory and read from it by OpenEXRCore's own routines, with no code of ours. */
#ifndef HDR_TESTS_EXR_MAKE_H
#define HDR_TESTS_EXR_MAKE_H

#include <openexr.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { MADE_CHANNELS = 6 };

typedef struct file_bytes {
    unsigned char *data;
    size_t size;
} file_bytes;

static inline uint64_t random_bits(uint64_t *state) {
    uint64_t z = *state += 0x9e3779b97f4a7c15u; /* SplitMix64 */
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static int64_t read_memory(exr_const_context_t context, void *user, void *buffer, uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t complain) {
    const file_bytes *file = user;
    (void)context;
    (void)complain;
    if (offset >= file->size) return 0;
    if (size > file->size - offset) size = file->size - offset;
    memcpy(buffer, file->data + offset, (size_t)size);
    return (int64_t)size;
}

static int64_t memory_size(exr_const_context_t context, void *user) {
    (void)context;
    return (int64_t)((const file_bytes *)user)->size;
}

static int64_t write_memory(exr_const_context_t context, void *user, const void *buffer, uint64_t size, uint64_t offset,
                            exr_stream_error_func_ptr_t complain) {
    file_bytes *file = user;
    (void)context;
    (void)complain;
    if (offset + size > file->size) {
        file->data = realloc(file->data, (size_t)(offset + size));
        if (!file->data) abort();
        memset(file->data + file->size, 0, (size_t)(offset + size) - file->size);
        file->size = (size_t)(offset + size);
    }
    memcpy(file->data + offset, buffer, (size_t)size);
    return (int64_t)size;
}

static void ignore_complaint(exr_const_context_t context, exr_result_t code, const char *message) {
    (void)context;
    (void)code;
    (void)message;
}

static inline exr_context_initializer_t memory_initializer(file_bytes *file) {
    exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
    initializer.user_data = file;
    initializer.read_fn = read_memory;
    initializer.size_fn = memory_size;
    initializer.write_fn = write_memory;
    initializer.error_handler_fn = ignore_complaint;
    return initializer;
}

/* What to write. */
typedef struct recipe {
    int width, height, min_x, min_y;
    exr_compression_t compression;
    int tile;     /* a tile's side, 0: lines */
    bool upwards; /* lines are stored from the last to the first */
    bool noise;   /* nothing to gain by packing */
    int channels; /* in alphabetical order */
    struct {
        const char *name;
        exr_pixel_type_t type;
        bool constant; /* all pixels have this value; not for half */
        double value;
        unsigned char *pixels; /* made by make_exr, to be freed */
    } channel[MADE_CHANNELS];
    int sampling; /* of the last channel, 0: as the others */
    const char *state;
    const exr_attr_chromaticities_t *chromaticities;
    const exr_attr_v2f_t *neutral;
} recipe;

static inline size_t sample_size(exr_pixel_type_t type) {
    return type == EXR_PIXEL_HALF ? 2 : 4;
}

static inline void make_pixels(recipe *r, uint64_t *random) {
    for (int c = 0; c < r->channels; c++) {
        size_t size = sample_size(r->channel[c].type), count = (size_t)r->width * (size_t)r->height;
        unsigned char *pixels = malloc(count * size);
        if (!pixels) abort();
        for (size_t i = 0; i < count; i++) {
            float value = 0.25f + (float)(i % (size_t)r->width) / 64 + (float)(random_bits(random) & 7) / 256;
            uint32_t bits;
            memcpy(&bits, &value, 4);
            uint16_t half = (uint16_t)(0x3400 + (i % (size_t)r->width) * 4 + (random_bits(random) & 3));
            if (r->channel[c].constant) {
                value = (float)r->channel[c].value;
                memcpy(&bits, &value, 4);
                if (r->channel[c].type == EXR_PIXEL_UINT) bits = (uint32_t)r->channel[c].value;
            }
            if (r->noise) {
                bits = (uint32_t)random_bits(random);
                half = (uint16_t)bits;
            }
            memcpy(pixels + i * size, size == 2 ? (void *)&half : (void *)&bits, size);
        }
        r->channel[c].pixels = pixels;
    }
}

/* Encodes the chunk at (x, y), counted from the data window's corner. */
static inline bool encode_chunk(exr_context_t context, const recipe *r, const exr_chunk_info_t *info, int x, int y) {
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    bool done = exr_encoding_initialize(context, 0, info, &encode) == EXR_ERR_SUCCESS;
    for (int c = 0; done && c < r->channels; c++) {
        size_t size = sample_size(r->channel[c].type);
        exr_coding_channel_info_t *to = &encode.channels[c];
        to->user_bytes_per_element = (int16_t)size;
        to->user_data_type = (uint16_t)r->channel[c].type;
        to->user_pixel_stride = (int32_t)size;
        to->user_line_stride = (int32_t)(size * (size_t)r->width);
        to->encode_from_ptr = r->channel[c].pixels + ((size_t)y * (size_t)r->width + (size_t)x) * size;
    }
    done = done && exr_encoding_choose_default_routines(context, 0, &encode) == EXR_ERR_SUCCESS &&
           exr_encoding_run(context, 0, &encode) == EXR_ERR_SUCCESS;
    exr_encoding_destroy(context, &encode);
    return done;
}

static inline bool write_chunks(exr_context_t context, const recipe *r) {
    exr_chunk_info_t info;
    bool done = true;
    if (r->tile) {
        for (int y = 0; done && y * r->tile < r->height; y++)
            for (int x = 0; done && x * r->tile < r->width; x++)
                done = exr_write_tile_chunk_info(context, 0, x, y, 0, 0, &info) == EXR_ERR_SUCCESS &&
                       encode_chunk(context, r, &info, x * r->tile, y * r->tile);
        return done;
    }
    int32_t rows = 1;
    exr_get_scanlines_per_chunk(context, 0, &rows);
    int chunks = (r->height + rows - 1) / rows;
    for (int i = 0; done && i < chunks; i++) {
        int y = (r->upwards ? chunks - 1 - i : i) * rows;
        done = exr_write_scanline_chunk_info(context, 0, r->min_y + y, &info) == EXR_ERR_SUCCESS &&
               encode_chunk(context, r, &info, 0, y);
    }
    return done;
}

/* The library writes lines from the last to the first only under the name of any order. */
static inline void declare_upwards(file_bytes *file) {
    static const char attribute[] = "lineOrder\0lineOrder\0\1\0\0";
    unsigned char *found = memmem(file->data, file->size, attribute, sizeof attribute);
    if (found) found[sizeof attribute] = EXR_LINEORDER_DECREASING_Y;
}

static inline bool make_exr(recipe *r, uint64_t *random, file_bytes *file) {
    exr_context_initializer_t initializer = memory_initializer(file);
    exr_context_t context = NULL;
    const exr_attr_box2i_t window = {.min = {.x = r->min_x, .y = r->min_y},
                                     .max = {.x = r->min_x + r->width - 1, .y = r->min_y + r->height - 1}};
    int part = 0;
    *file = (file_bytes){NULL, 0};
    make_pixels(r, random);
    bool done =
        exr_start_write(&context, "memory", EXR_WRITE_FILE_DIRECTLY, &initializer) == EXR_ERR_SUCCESS &&
        exr_add_part(context, "", r->tile ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &part) == EXR_ERR_SUCCESS &&
        exr_initialize_required_attr_simple(context, 0, r->width, r->height, r->compression) == EXR_ERR_SUCCESS &&
        exr_set_data_window(context, 0, &window) == EXR_ERR_SUCCESS;
    if (done && r->tile)
        done = exr_set_tile_descriptor(context, 0, (uint32_t)r->tile, (uint32_t)r->tile, EXR_TILE_ONE_LEVEL,
                                       EXR_TILE_ROUND_DOWN) == EXR_ERR_SUCCESS;
    if (done && r->upwards) done = exr_set_lineorder(context, 0, EXR_LINEORDER_RANDOM_Y) == EXR_ERR_SUCCESS;
    if (done && r->state) done = exr_attr_set_string(context, 0, "hdrpipeState", r->state) == EXR_ERR_SUCCESS;
    if (done && r->chromaticities)
        done = exr_attr_set_chromaticities(context, 0, "chromaticities", r->chromaticities) == EXR_ERR_SUCCESS;
    if (done && r->neutral) done = exr_attr_set_v2f(context, 0, "adoptedNeutral", r->neutral) == EXR_ERR_SUCCESS;
    for (int c = 0; done && c < r->channels; c++) {
        int sampling = r->sampling && c == r->channels - 1 ? r->sampling : 1;
        done = exr_add_channel(context, 0, r->channel[c].name, r->channel[c].type, EXR_PERCEPTUALLY_LOGARITHMIC,
                               sampling, sampling) == EXR_ERR_SUCCESS;
    }
    done = done && exr_write_header(context) == EXR_ERR_SUCCESS;
    if (done && !r->sampling) done = write_chunks(context, r);
    if (context && exr_finish(&context) != EXR_ERR_SUCCESS) done = false;
    if (done && r->upwards) declare_upwards(file);
    return done;
}

static inline void free_recipe(recipe *r) {
    for (int c = 0; c < r->channels; c++)
        free(r->channel[c].pixels);
}

/* Decodes one chunk of a file into tight planes by the library's default routines. NULL planes are not wanted. */
static inline bool decode_plainly(exr_context_t context, const exr_chunk_info_t *info, int x, int y, int width,
                                  const char *const names[4], unsigned char *const planes[4]) {
    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    bool done = exr_decoding_initialize(context, 0, info, &decode) == EXR_ERR_SUCCESS;
    for (int c = 0; done && c < decode.channel_count; c++)
        for (int p = 0; p < 4; p++) {
            exr_coding_channel_info_t *to = &decode.channels[c];
            size_t size = (size_t)to->bytes_per_element;
            if (!planes[p] || strcmp(to->channel_name, names[p]) != 0) continue;
            to->user_pixel_stride = (int32_t)size;
            to->user_line_stride = (int32_t)(size * (size_t)width);
            to->decode_to_ptr = planes[p] + ((size_t)y * (size_t)width + (size_t)x) * size;
        }
    done = done && exr_decoding_choose_default_routines(context, 0, &decode) == EXR_ERR_SUCCESS &&
           exr_decoding_run(context, 0, &decode) == EXR_ERR_SUCCESS;
    exr_decoding_destroy(context, &decode);
    return done;
}

/* Reads the named channels of a whole file. */
static inline bool read_plainly(file_bytes *file, const char *const names[4], unsigned char *const planes[4]) {
    exr_context_initializer_t initializer = memory_initializer(file);
    exr_context_t context = NULL;
    exr_attr_box2i_t window = {.max = {.x = -1, .y = -1}};
    exr_storage_t storage = EXR_STORAGE_SCANLINE;
    exr_chunk_info_t info;
    bool done = exr_start_read(&context, "memory", &initializer) == EXR_ERR_SUCCESS &&
                exr_get_data_window(context, 0, &window) == EXR_ERR_SUCCESS &&
                exr_get_storage(context, 0, &storage) == EXR_ERR_SUCCESS;
    int width = window.max.x - window.min.x + 1, height = window.max.y - window.min.y + 1;
    if (done && storage == EXR_STORAGE_TILED) {
        int32_t tile_width = 0, tile_height = 0;
        done = exr_get_tile_sizes(context, 0, 0, 0, &tile_width, &tile_height) == EXR_ERR_SUCCESS;
        for (int y = 0; done && y * tile_height < height; y++)
            for (int x = 0; done && x * tile_width < width; x++)
                done = exr_read_tile_chunk_info(context, 0, x, y, 0, 0, &info) == EXR_ERR_SUCCESS &&
                       decode_plainly(context, &info, x * tile_width, y * tile_height, width, names, planes);
    } else {
        int32_t rows = 1;
        done = done && exr_get_scanlines_per_chunk(context, 0, &rows) == EXR_ERR_SUCCESS;
        for (int y = 0; done && y < height; y += rows)
            done = exr_read_scanline_chunk_info(context, 0, window.min.y + y, &info) == EXR_ERR_SUCCESS &&
                   decode_plainly(context, &info, 0, y, width, names, planes);
    }
    if (context) exr_finish(&context);
    return done;
}

#endif

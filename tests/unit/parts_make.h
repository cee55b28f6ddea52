/* For tests: EXR files of several parts and levels, written to memory by OpenEXRCore. */
#ifndef HDR_TESTS_PARTS_MAKE_H
#define HDR_TESTS_PARTS_MAKE_H

#include "check.h"
#include "exr_make.h"

enum { MOST_PARTS = 8, MOST_LEVELS = 12, MOST_CHANNELS = 12 };

static uint64_t random_state = 7;

struct made_channel {
    const char *name;
    exr_pixel_type_t type;
    unsigned char *pixels[MOST_LEVELS]; /* of each level */
};

struct made_part {
    const char *name, *view;
    const char *views[3]; /* multiView */
    int width, height, min_x, min_y, tile;
    exr_tile_level_mode_t mode;
    exr_tile_round_mode_t rounding;
    exr_compression_t compression;
    bool border; /* a display window larger than the data window */
    struct made_channel channel[MOST_CHANNELS];
};

struct made_file {
    struct made_part part[MOST_PARTS];
    int parts;
    file_bytes bytes;
};

static inline int level_side(const struct made_part *part, int side, int level) {
    for (; level > 0; level--)
        side = side > 1 ? (side + (part->rounding == EXR_TILE_ROUND_UP ? 1 : 0)) / 2 : 1;
    return side;
}

/* Encodes a chunk from pixels that begin at (x, y) of planes that are width wide. */
static inline bool encode_part(exr_context_t context, int number, const struct made_part *part,
                               const exr_chunk_info_t *info, unsigned char *const *planes, int x, int y, int width) {
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    bool done = exr_encoding_initialize(context, number, info, &encode) == EXR_ERR_SUCCESS;
    for (int c = 0; done && part->channel[c].name; c++) {
        size_t size = sample_size(part->channel[c].type);
        exr_coding_channel_info_t *to = &encode.channels[c];
        to->user_bytes_per_element = (int16_t)size;
        to->user_data_type = (uint16_t)part->channel[c].type;
        to->user_pixel_stride = (int32_t)size;
        to->user_line_stride = (int32_t)(size * (size_t)width);
        to->encode_from_ptr = planes[c] + ((size_t)y * (size_t)width + (size_t)x) * size;
    }
    done = done && exr_encoding_choose_default_routines(context, number, &encode) == EXR_ERR_SUCCESS &&
           exr_encoding_run(context, number, &encode) == EXR_ERR_SUCCESS;
    exr_encoding_destroy(context, &encode);
    return done;
}

static inline unsigned char *noise(size_t size) {
    unsigned char *bytes = malloc(size ? size : 1);
    if (!bytes) abort();
    for (size_t i = 0; i < size; i++)
        bytes[i] = (unsigned char)(random_bits(&random_state) & 0x3b); /* no NaN, little to pack */
    return bytes;
}

/* OpenEXRCore 3.1 does not cut tiles at the border of the smaller levels. */
static inline void settle_tile(const struct made_part *part, exr_chunk_info_t *info, int right, int below) {
    size_t pixel = 0;
    info->width = part->tile < right ? part->tile : right;
    info->height = part->tile < below ? part->tile : below;
    for (int c = 0; part->channel[c].name; c++)
        pixel += sample_size(part->channel[c].type);
    info->unpacked_size = pixel * (size_t)info->width * (size_t)info->height;
}

/* All chunks of one level. (It cannot write ripmaps: tests/cli/test_layers.sh reads those of the C++ library.) */
static inline bool write_level(exr_context_t context, int number, struct made_part *part, int level) {
    int width = level_side(part, part->width, level), height = level_side(part, part->height, level);
    unsigned char *planes[MOST_CHANNELS] = {NULL};
    exr_chunk_info_t info;
    bool done = true;
    for (int c = 0; part->channel[c].name; c++)
        planes[c] = noise((size_t)width * (size_t)height * sample_size(part->channel[c].type));
    int32_t rows = part->tile;
    if (!part->tile) exr_get_scanlines_per_chunk(context, number, &rows);
    for (int y = 0; done && y < height; y += rows)
        for (int x = 0; done && x < width; x += part->tile ? part->tile : width) {
            done = (part->tile
                        ? exr_write_tile_chunk_info(context, number, x / rows, y / rows, level, level, &info)
                        : exr_write_scanline_chunk_info(context, number, part->min_y + y, &info)) == EXR_ERR_SUCCESS;
            if (part->tile) settle_tile(part, &info, width - x, height - y);
            done = done && encode_part(context, number, part, &info, planes, x, y, width);
        }
    for (int c = 0; part->channel[c].name; c++)
        part->channel[c].pixels[level] = planes[c];
    return done;
}

static inline bool write_part(exr_context_t context, int number, struct made_part *part) {
    int32_t levels = 1, down = 1;
    if (part->tile && exr_get_tile_levels(context, number, &levels, &down) != EXR_ERR_SUCCESS) return false;
    bool done = true;
    for (int level = 0; done && level < levels; level++)
        done = write_level(context, number, part, level);
    return done;
}

static inline bool declare_part(exr_context_t context, struct made_part *part) {
    int number = 0;
    exr_attr_box2i_t window = {.min = {.x = part->min_x, .y = part->min_y},
                               .max = {.x = part->min_x + part->width - 1, .y = part->min_y + part->height - 1}};
    bool done = exr_add_part(context, part->name, part->tile ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &number) ==
                    EXR_ERR_SUCCESS &&
                exr_initialize_required_attr_simple(context, number, part->width, part->height, part->compression) ==
                    EXR_ERR_SUCCESS &&
                exr_set_data_window(context, number, &window) == EXR_ERR_SUCCESS;
    if (part->border) window.min.x -= 5, window.min.y -= 4, window.max.x += 3, window.max.y += 6;
    done = done && exr_set_display_window(context, number, &window) == EXR_ERR_SUCCESS;
    if (done && part->tile)
        done = exr_set_tile_descriptor(context, number, (uint32_t)part->tile, (uint32_t)part->tile, part->mode,
                                       part->rounding) == EXR_ERR_SUCCESS;
    if (done && part->view) done = exr_attr_set_string(context, number, "view", part->view) == EXR_ERR_SUCCESS;
    if (done && part->views[0])
        done =
            exr_attr_set_string_vector(context, number, "multiView", 2, (const char **)part->views) == EXR_ERR_SUCCESS;
    for (int c = 0; done && part->channel[c].name; c++)
        done = exr_add_channel(context, number, part->channel[c].name, part->channel[c].type,
                               EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1) == EXR_ERR_SUCCESS;
    return done;
}

static inline bool make_file(struct made_file *file) {
    exr_context_initializer_t initializer = memory_initializer(&file->bytes);
    exr_context_t context = NULL;
    bool done = exr_start_write(&context, "memory", EXR_WRITE_FILE_DIRECTLY, &initializer) == EXR_ERR_SUCCESS;
    for (file->parts = 0; file->part[file->parts].width; file->parts++)
        done = done && declare_part(context, &file->part[file->parts]);
    done = done && exr_write_header(context) == EXR_ERR_SUCCESS;
    for (int i = 0; done && i < file->parts; i++)
        done = write_part(context, i, &file->part[i]);
    if (context && exr_finish(&context) != EXR_ERR_SUCCESS) done = false;
    CHECK(done, "a file cannot be made");
    return done;
}

static inline void free_file(struct made_file *file) {
    for (int i = 0; i < file->parts; i++)
        for (int c = 0; file->part[i].channel[c].name; c++)
            for (int l = 0; l < MOST_LEVELS; l++)
                free(file->part[i].channel[c].pixels[l]);
    free(file->bytes.data);
}

#endif

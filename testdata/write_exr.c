/*
 * write_exr: one picture into one scan-line OpenEXR file, through OpenEXRCore.
 *
 * SPDX-License-Identifier: BSD-3-Clause
 */
#include "write_exr.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ONLY_PART = 0, LARGEST_HALF_BITS = 0x7bff, QUIET_NAN_HALF_BITS = 0x7e00, INFINITE_HALF_BITS = 0x7c00 };

exr_attr_box2i_t window_of_size(int width, int height) {
    return (exr_attr_box2i_t){.min = {.x = 0, .y = 0}, .max = {.x = width - 1, .y = height - 1}};
}

static int window_width(const Picture *picture) {
    return picture->data_window.max.x - picture->data_window.min.x + 1;
}

static int window_height(const Picture *picture) {
    return picture->data_window.max.y - picture->data_window.min.y + 1;
}

/* Drops the low bits of a positive integer, rounding to nearest, ties to even. */
static uint32_t shift_right_rounding(uint32_t value, int bits) {
    uint32_t kept = value >> bits;
    uint32_t dropped = value - (kept << bits);
    uint32_t tie = 1u << (bits - 1);
    return kept + (dropped > tie || (dropped == tie && (kept & 1)));
}

/*
 * IEEE 754 binary32 to binary16, to nearest, ties to even. A finite value beyond 65504 becomes 65504, as a brighter
 * picture is better than an infinite one; infinities and NaN stay what they are.
 */
static uint16_t half_from_float(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint32_t sign = bits >> 16 & 0x8000;
    uint32_t magnitude = bits & 0x7fffffff;
    uint32_t half;
    if (magnitude > 0x7f800000) {
        half = QUIET_NAN_HALF_BITS;
    } else if (magnitude == 0x7f800000) {
        half = INFINITE_HALF_BITS;
    } else if (magnitude < 0x33000000) { /* below 2^-25, half the smallest subnormal */
        half = 0;
    } else if (magnitude < 0x38800000) { /* below 2^-14: subnormal, in units of 2^-24 */
        uint32_t significand = (magnitude & 0x7fffff) | 0x800000;
        int exponent = (int)(magnitude >> 23) - 127;
        half = shift_right_rounding(significand, -1 - exponent);
    } else { /* the exponent's bias goes from 127 to 15; a carry out of the significand raises it as it should */
        half = shift_right_rounding(magnitude - ((127u - 15u) << 23), 13);
        half = half > LARGEST_HALF_BITS ? LARGEST_HALF_BITS : half;
    }
    return (uint16_t)(sign | half);
}

/* Some floats, as the file stores them. The caller frees it. */
static uint8_t *convert_pixels(const float *pixels, size_t count, exr_pixel_type_t type) {
    size_t size = type == EXR_PIXEL_HALF ? sizeof(uint16_t) : sizeof(float);
    uint8_t *converted = malloc(count * size);
    if (converted && type == EXR_PIXEL_FLOAT) memcpy(converted, pixels, count * size);
    for (size_t i = 0; converted && type == EXR_PIXEL_HALF && i < count; i++) {
        uint16_t half = half_from_float(pixels[i]);
        memcpy(converted + i * size, &half, size);
    }
    return converted;
}

static exr_result_t write_header(exr_context_t file, const Picture *picture, exr_pixel_type_t type,
                                 exr_compression_t compression) {
    exr_attr_v2f_t centre = {.x = 0, .y = 0};
    exr_result_t result = exr_add_part(file, NULL, EXR_STORAGE_SCANLINE, NULL);
    if (result == EXR_ERR_SUCCESS)
        result = exr_initialize_required_attr(file, ONLY_PART, &picture->display_window, &picture->data_window, 1,
                                              &centre, 1, EXR_LINEORDER_INCREASING_Y, compression);
    if (result == EXR_ERR_SUCCESS && picture->chromaticities)
        result = exr_attr_set_chromaticities(file, ONLY_PART, "chromaticities", picture->chromaticities);
    for (const char *letter = picture->channels; result == EXR_ERR_SUCCESS && *letter; letter++) {
        char name[] = {*letter, '\0'};
        result = exr_add_channel(file, ONLY_PART, name, type, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    }
    return result == EXR_ERR_SUCCESS ? exr_write_header(file) : result;
}

/* Points every channel of the chunk at its first pixel. The file's order of channels is not that of the pixels. */
static void set_channel_sources(exr_encode_pipeline_t *encoder, const Picture *picture, const uint8_t *first_pixel) {
    for (int c = 0; c < encoder->channel_count; c++) {
        exr_coding_channel_info_t *channel = &encoder->channels[c];
        size_t position = (size_t)(strchr(picture->channels, channel->channel_name[0]) - picture->channels);
        int pixel_size = channel->bytes_per_element * (int)strlen(picture->channels);
        channel->encode_from_ptr = first_pixel + position * (size_t)channel->bytes_per_element;
        channel->user_pixel_stride = pixel_size;
        channel->user_line_stride = pixel_size * window_width(picture);
    }
}

/*
 * The library's routine, kept in user data. A chunk that is as large as its pixels counts as not compressed, for every
 * reader; of one that compression leaves at that very size, up to 3.1 the library stores the compressed bytes.
 */
static exr_result_t compress_or_store(exr_encode_pipeline_t *encoder) {
    exr_result_t (*const *compress)(exr_encode_pipeline_t *) = encoder->encoding_user_data;
    exr_result_t result = (*compress)(encoder);
    if (result == EXR_ERR_SUCCESS && encoder->compressed_bytes == encoder->packed_bytes)
        memcpy(encoder->compressed_buffer, encoder->packed_buffer, encoder->packed_bytes);
    return result;
}

static exr_result_t write_chunks(exr_context_t file, const Picture *picture, const uint8_t *pixels, size_t row_size) {
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_result_t (*compress)(exr_encode_pipeline_t *) = NULL;
    int32_t rows_per_chunk = 0;
    exr_result_t result = exr_get_scanlines_per_chunk(file, ONLY_PART, &rows_per_chunk);
    for (int row = 0; result == EXR_ERR_SUCCESS && row < window_height(picture); row += rows_per_chunk) {
        exr_chunk_info_t chunk;
        result = exr_write_scanline_chunk_info(file, ONLY_PART, picture->data_window.min.y + row, &chunk);
        if (result == EXR_ERR_SUCCESS)
            result = row == 0 ? exr_encoding_initialize(file, ONLY_PART, &chunk, &encoder)
                              : exr_encoding_update(file, ONLY_PART, &chunk, &encoder);
        if (result != EXR_ERR_SUCCESS) break;
        set_channel_sources(&encoder, picture, pixels + (size_t)row * row_size);
        if (row == 0) {
            result = exr_encoding_choose_default_routines(file, ONLY_PART, &encoder);
            compress = encoder.compress_fn;
            encoder.encoding_user_data = &compress;
            if (compress) encoder.compress_fn = compress_or_store;
        }
        if (result == EXR_ERR_SUCCESS) result = exr_encoding_run(file, ONLY_PART, &encoder);
    }
    exr_result_t freed = encoder.context ? exr_encoding_destroy(file, &encoder) : EXR_ERR_SUCCESS;
    return result == EXR_ERR_SUCCESS ? freed : result;
}

bool write_exr(const char *path, const Picture *picture, exr_pixel_type_t type, exr_compression_t compression) {
    size_t row_count = (size_t)window_width(picture) * strlen(picture->channels);
    size_t row_size = row_count * (type == EXR_PIXEL_HALF ? sizeof(uint16_t) : sizeof(float));
    uint8_t *pixels = convert_pixels(picture->pixels, row_count * (size_t)window_height(picture), type);
    if (!pixels) {
        fprintf(stderr, "%s: out of memory\n", path);
        return false;
    }
    exr_context_t file = NULL;
    exr_result_t result = exr_start_write(&file, path, EXR_WRITE_FILE_DIRECTLY, NULL);
    if (result == EXR_ERR_SUCCESS) {
        result = write_header(file, picture, type, compression);
        if (result == EXR_ERR_SUCCESS) result = write_chunks(file, picture, pixels, row_size);
        exr_result_t finished = exr_finish(&file);
        result = result == EXR_ERR_SUCCESS ? finished : result;
    }
    free(pixels);
    if (result != EXR_ERR_SUCCESS) fprintf(stderr, "%s: %s\n", path, exr_get_default_error_message(result));
    return result == EXR_ERR_SUCCESS;
}

/* For the oracle: a picture as SPEC's "Reading" has it, read by OpenEXRCore's own unpacking, with nothing of src/. */
#ifndef HDR_TESTS_ORACLE_PICTURE_H
#define HDR_TESTS_ORACLE_PICTURE_H

#include "exr_make.h"

#include <math.h>
#include <openexr.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Red, green, blue, white; x and y. */
typedef struct oracle_primaries {
    long double at[4][2];
} oracle_primaries;

static const oracle_primaries oracle_rec709 = {{{0.64L, 0.33L}, {0.30L, 0.60L}, {0.15L, 0.06L}, {0.3127L, 0.3290L}}};

typedef struct oracle_picture {
    unsigned long serial; /* tells pictures apart */
    exr_attr_box2i_t data, display;
    int width, height; /* of the data window */
    size_t pixels;
    int planes;      /* 1: luminance only */
    float *plane[4]; /* R G B, or Y in [0]; [3] alpha, NULL where there is none */
    uint64_t nan, positive_infinity, negative_infinity;
    bool grey;    /* one plane, or R = G = B bit for bit after repair */
    bool opaque;  /* no alpha, or 1 everywhere */
    bool border;  /* some of the display window is outside the data window */
    bool foreign; /* primaries other than Rec.709 */
    oracle_primaries primaries;
    long double neutral[2];
} oracle_picture;

static void *oracle_alloc(size_t count, size_t size) {
    void *memory = calloc(count ? count : 1, size);
    if (!memory) abort();
    return memory;
}

static inline bool oracle_load(const char *path, file_bytes *file) {
    FILE *stream = fopen(path, "rb");
    *file = (file_bytes){NULL, 0};
    if (!stream) return false;
    fseek(stream, 0, SEEK_END);
    long size = ftell(stream);
    rewind(stream);
    bool loaded = size > 0;
    if (loaded) {
        file->data = oracle_alloc((size_t)size, 1);
        file->size = fread(file->data, 1, (size_t)size, stream);
        loaded = file->size == (size_t)size;
    }
    fclose(stream);
    return loaded;
}

/* ---- Decoding ---- */

/* Which plane a channel of the unnamed layer goes to; -1: none. */
static int oracle_plane_of(const char *channel, int planes) {
    if (!strcmp(channel, "A")) return 3;
    if (planes == 1) return strcmp(channel, "Y") ? -1 : 0;
    return !strcmp(channel, "R") ? 0 : !strcmp(channel, "G") ? 1 : !strcmp(channel, "B") ? 2 : -1;
}

static bool oracle_decode_chunk(exr_context_t context, const exr_chunk_info_t *info, oracle_picture *picture, int x,
                                int y) {
    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    bool done = exr_decoding_initialize(context, 0, info, &decode) == EXR_ERR_SUCCESS;
    for (int c = 0; done && c < decode.channel_count; c++) {
        exr_coding_channel_info_t *to = &decode.channels[c];
        int plane = oracle_plane_of(to->channel_name, picture->planes);
        if (plane < 0) continue;
        to->user_bytes_per_element = sizeof(float);
        to->user_data_type = EXR_PIXEL_FLOAT;
        to->user_pixel_stride = sizeof(float);
        to->user_line_stride = (int32_t)((size_t)picture->width * sizeof(float));
        to->decode_to_ptr = (uint8_t *)(picture->plane[plane] + (size_t)y * (size_t)picture->width + (size_t)x);
    }
    done = done && exr_decoding_choose_default_routines(context, 0, &decode) == EXR_ERR_SUCCESS &&
           exr_decoding_run(context, 0, &decode) == EXR_ERR_SUCCESS;
    exr_decoding_destroy(context, &decode);
    return done;
}

static bool oracle_decode(exr_context_t context, oracle_picture *picture) {
    exr_storage_t storage = EXR_STORAGE_SCANLINE;
    exr_chunk_info_t info;
    if (exr_get_storage(context, 0, &storage) != EXR_ERR_SUCCESS) return false;
    bool tiled = storage == EXR_STORAGE_TILED, done = true;
    int32_t wide = picture->width, high = 1;
    done = (tiled ? exr_get_tile_sizes(context, 0, 0, 0, &wide, &high)
                  : exr_get_scanlines_per_chunk(context, 0, &high)) == EXR_ERR_SUCCESS;
    for (int y = 0; done && y < picture->height; y += high)
        for (int x = 0; done && x < picture->width; x += wide)
            done =
                (tiled ? exr_read_tile_chunk_info(context, 0, x / wide, y / high, 0, 0, &info)
                       : exr_read_scanline_chunk_info(context, 0, picture->data.min.y + y, &info)) == EXR_ERR_SUCCESS &&
                oracle_decode_chunk(context, &info, picture, x, y);
    return done;
}

/* ---- The header ---- */

static void oracle_read_colour(exr_context_t context, oracle_picture *picture) {
    exr_attr_chromaticities_t c;
    exr_attr_v2f_t neutral;
    picture->primaries = oracle_rec709;
    if (exr_attr_get_chromaticities(context, 0, "chromaticities", &c) == EXR_ERR_SUCCESS)
        picture->primaries = (oracle_primaries){
            {{c.red_x, c.red_y}, {c.green_x, c.green_y}, {c.blue_x, c.blue_y}, {c.white_x, c.white_y}}};
    memcpy(picture->neutral, picture->primaries.at[3], sizeof picture->neutral);
    if (exr_attr_get_v2f(context, 0, "adoptedNeutral", &neutral) == EXR_ERR_SUCCESS) {
        picture->neutral[0] = neutral.x;
        picture->neutral[1] = neutral.y;
    }
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 2; j++)
            if (fabsl(picture->primaries.at[i][j] - oracle_rec709.at[i][j]) > 1e-5L) picture->foreign = true;
}

static bool oracle_read_header(exr_context_t context, oracle_picture *picture) {
    const exr_attr_chlist_t *channels = NULL;
    if (exr_get_channels(context, 0, &channels) != EXR_ERR_SUCCESS ||
        exr_get_data_window(context, 0, &picture->data) != EXR_ERR_SUCCESS ||
        exr_get_display_window(context, 0, &picture->display) != EXR_ERR_SUCCESS)
        return false;
    const exr_attr_box2i_t *data = &picture->data, *display = &picture->display;
    picture->width = data->max.x - data->min.x + 1;
    picture->height = data->max.y - data->min.y + 1;
    picture->pixels = (size_t)picture->width * (size_t)picture->height;
    picture->border = data->min.x > display->min.x || data->min.y > display->min.y || data->max.x < display->max.x ||
                      data->max.y < display->max.y;
    picture->planes = 1;
    bool alpha = false;
    for (int c = 0; c < channels->num_channels; c++) {
        const char *name = channels->entries[c].name.str;
        if (!strcmp(name, "R") || !strcmp(name, "G") || !strcmp(name, "B")) picture->planes = 3;
        if (!strcmp(name, "A")) alpha = true;
    }
    for (int p = 0; p < picture->planes; p++)
        picture->plane[p] = oracle_alloc(picture->pixels, sizeof(float));
    if (alpha) picture->plane[3] = oracle_alloc(picture->pixels, sizeof(float));
    oracle_read_colour(context, picture);
    return true;
}

/* ---- Repair ---- */

/* NaN -> 0; -Inf -> 0; +Inf -> the channel's largest finite value among the pixels read, at least 0. */
static void oracle_repair(oracle_picture *picture, float *plane) {
    float largest = 0;
    for (size_t i = 0; i < picture->pixels; i++)
        if (isfinite(plane[i]) && plane[i] > largest) largest = plane[i];
    for (size_t i = 0; i < picture->pixels; i++) {
        if (isfinite(plane[i])) continue;
        *(isnan(plane[i]) ? &picture->nan
          : plane[i] > 0  ? &picture->positive_infinity
                          : &picture->negative_infinity) += 1;
        plane[i] = isnan(plane[i]) || plane[i] < 0 ? 0 : largest;
    }
}

/* Repair, and what is known of the whole picture after it. */
static void oracle_finish_reading(oracle_picture *picture) {
    for (int p = 0; p < 4; p++)
        if (picture->plane[p]) oracle_repair(picture, picture->plane[p]);
    size_t size = picture->pixels * sizeof(float);
    picture->grey = picture->planes == 1 || (!memcmp(picture->plane[0], picture->plane[1], size) &&
                                             !memcmp(picture->plane[0], picture->plane[2], size));
    picture->opaque = true;
    for (size_t i = 0; picture->plane[3] && i < picture->pixels; i++)
        if (picture->plane[3][i] != 1) picture->opaque = false;
}

static inline bool oracle_read(file_bytes *file, oracle_picture *picture) {
    exr_context_initializer_t initializer = memory_initializer(file);
    exr_context_t context = NULL;
    static unsigned long serial;
    *picture = (oracle_picture){.serial = serial + 1};
    serial++;
    bool done = exr_start_read(&context, "memory", &initializer) == EXR_ERR_SUCCESS &&
                oracle_read_header(context, picture) && oracle_decode(context, picture);
    if (context) exr_finish(&context);
    if (done) oracle_finish_reading(picture);
    return done;
}

static inline void oracle_picture_free(oracle_picture *picture) {
    for (int p = 0; p < 4; p++)
        free(picture->plane[p]);
    *picture = (oracle_picture){0};
}

/* ---- Colour ---- */

typedef struct oracle_weights {
    bool rec709;        /* 0.2126, 0.7152, 0.0722 as decimals */
    long double row[3]; /* else the Y row */
} oracle_weights;

typedef long double oracle_matrix[3][3];

static void oracle_invert(oracle_matrix m, oracle_matrix inverse) {
    long double determinant = 0;
    for (int i = 0; i < 3; i++)
        determinant += m[0][i] * (m[1][(i + 1) % 3] * m[2][(i + 2) % 3] - m[1][(i + 2) % 3] * m[2][(i + 1) % 3]);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            inverse[j][i] = (m[(i + 1) % 3][(j + 1) % 3] * m[(i + 2) % 3][(j + 2) % 3] -
                             m[(i + 1) % 3][(j + 2) % 3] * m[(i + 2) % 3][(j + 1) % 3]) /
                            determinant;
}

static void oracle_product(oracle_matrix a, oracle_matrix b, oracle_matrix product) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            product[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
}

/* XYZ of chromaticity x, y at Y = 1. */
static void oracle_xyz(const long double xy[2], long double xyz[3]) {
    xyz[0] = xy[0] / xy[1];
    xyz[1] = 1;
    xyz[2] = (1 - xy[0] - xy[1]) / xy[1];
}

/* RGB to XYZ (SMPTE RP 177): columns are the primaries' (x, y, 1 - x - y), each scaled so that R = G = B = 1 gives
 * white at Y = 1. */
static void oracle_rgb_to_xyz(const oracle_primaries *primaries, oracle_matrix m) {
    oracle_matrix columns, inverse;
    long double white[3];
    for (int i = 0; i < 3; i++) {
        const long double *xy = primaries->at[i];
        columns[0][i] = xy[0];
        columns[1][i] = xy[1];
        columns[2][i] = 1 - xy[0] - xy[1];
    }
    oracle_invert(columns, inverse);
    oracle_xyz(primaries->at[3], white);
    for (int i = 0; i < 3; i++) {
        long double scale = inverse[i][0] * white[0] + inverse[i][1] * white[1] + inverse[i][2] * white[2];
        for (int j = 0; j < 3; j++)
            m[j][i] = columns[j][i] * scale;
    }
}

static inline oracle_weights oracle_weights_of(const oracle_picture *picture) {
    oracle_weights weights = {.rec709 = !picture->foreign};
    oracle_matrix m;
    oracle_rgb_to_xyz(&picture->primaries, m);
    memcpy(weights.row, m[1], sizeof weights.row);
    return weights;
}

/* Bradford's cone responses, and von Kries' scaling of them from one white to D65. */
static void oracle_adaptation(const long double from[2], oracle_matrix m) {
    static oracle_matrix bradford = {
        {0.8951L, 0.2664L, -0.1614L}, {-0.7502L, 1.7135L, 0.0367L}, {0.0389L, -0.0685L, 1.0296L}};
    long double white[3], target[3];
    oracle_matrix back, scaled;
    oracle_xyz(from, white);
    oracle_xyz(oracle_rec709.at[3], target);
    oracle_invert(bradford, back);
    for (int i = 0; i < 3; i++) {
        long double was = 0, becomes = 0;
        for (int j = 0; j < 3; j++) {
            was += bradford[i][j] * white[j];
            becomes += bradford[i][j] * target[j];
        }
        for (int j = 0; j < 3; j++)
            scaled[i][j] = bradford[i][j] * becomes / was;
    }
    oracle_product(back, scaled, m);
}

/* From the file's primaries to Rec.709's. White is not adapted for the primaries of XYZ itself, nor where adapt is
 * false. */
static inline void oracle_conversion(const oracle_picture *picture, bool adapt, oracle_matrix m) {
    static const long double xyz[3][2] = {{1, 0}, {0, 1}, {0, 0}};
    oracle_matrix to_xyz, rec709, from_xyz, adaptation, adapted;
    oracle_rgb_to_xyz(&picture->primaries, to_xyz);
    oracle_rgb_to_xyz(&oracle_rec709, rec709);
    oracle_invert(rec709, from_xyz);
    if (!adapt || !memcmp(picture->primaries.at, xyz, sizeof xyz)) {
        oracle_product(from_xyz, to_xyz, m);
        return;
    }
    oracle_adaptation(picture->neutral, adaptation);
    oracle_product(adaptation, to_xyz, adapted);
    oracle_product(from_xyz, adapted, m);
}

#endif

/* For the oracle's tests: pictures made in memory, for what testdata does not hold: other primaries, alpha with
 * borders, alpha above 1, negative values, a wide range of floats. */
#ifndef HDR_TESTS_ORACLE_SCENES_H
#define HDR_TESTS_ORACLE_SCENES_H

#include "oracle_picture.h"

typedef struct oracle_scene {
    const char *name;
    const char *channels; /* one letter each, in alphabetical order */
    exr_pixel_type_t type;
    int width, height, min_x, min_y;
    exr_attr_box2i_t display;
    const exr_attr_chromaticities_t *primaries;
    const exr_attr_v2f_t *neutral;
    bool grey;  /* all colours alike */
    bool solid; /* alpha 1 everywhere */
} oracle_scene;

static const exr_attr_chromaticities_t scene_bt2020 = {0.708f, 0.292f, 0.170f,  0.797f,
                                                       0.131f, 0.046f, 0.3127f, 0.3290f};
static const exr_attr_chromaticities_t scene_aces = {0.7347f, 0.2653f, 0, 1, 0.0001f, -0.077f, 0.32168f, 0.33767f};
static const exr_attr_chromaticities_t scene_xyz = {1, 0, 0, 1, 0, 0, 1 / 3.0f, 1 / 3.0f};
/* Rec.709's to within 1e-5, so that nothing is converted. */
static const exr_attr_chromaticities_t scene_rec709 = {0.640005f, 0.33f, 0.3f,    0.599995f,
                                                       0.15f,     0.06f, 0.3127f, 0.329f};
static const exr_attr_chromaticities_t scene_exactly_rec709 = {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};
static const exr_attr_v2f_t scene_neutral = {{{0.3457f, 0.3585f}}};

#define FRAME(left, top, right, bottom)                                                                                \
    {                                                                                                                  \
        {.x = (left), .y = (top)}, {                                                                                   \
            .x = (right), .y = (bottom)                                                                                \
        }                                                                                                              \
    }

static const oracle_scene oracle_scenes[] = {
    {.name = "border with alpha",
     .channels = "ABGR",
     .type = EXR_PIXEL_HALF,
     .width = 61,
     .height = 37,
     .min_x = -7,
     .min_y = 5,
     .display = FRAME(0, 0, 63, 49)},
    {.name = "solid alpha with border",
     .channels = "ABGR",
     .type = EXR_PIXEL_HALF,
     .width = 20,
     .height = 20,
     .min_x = 2,
     .min_y = 3,
     .display = FRAME(0, 0, 29, 25),
     .solid = true},
    {.name = "solid alpha, cropped",
     .channels = "ABGR",
     .type = EXR_PIXEL_FLOAT,
     .width = 33,
     .height = 21,
     .min_x = -4,
     .min_y = -4,
     .display = FRAME(0, 0, 19, 11),
     .solid = true},
    {.name = "windows apart",
     .channels = "BGR",
     .type = EXR_PIXEL_HALF,
     .width = 9,
     .height = 7,
     .min_x = 100,
     .min_y = -50,
     .display = FRAME(-3, -3, 12, 12)},
    {.name = "BT.2020",
     .channels = "BGR",
     .type = EXR_PIXEL_HALF,
     .width = 67,
     .height = 45,
     .display = FRAME(0, 0, 66, 44),
     .primaries = &scene_bt2020},
    {.name = "ACES with alpha",
     .channels = "ABGR",
     .type = EXR_PIXEL_HALF,
     .width = 41,
     .height = 40,
     .display = FRAME(0, 0, 40, 39),
     .primaries = &scene_aces},
    {.name = "BT.2020 with neutral",
     .channels = "BGR",
     .type = EXR_PIXEL_FLOAT,
     .width = 31,
     .height = 31,
     .display = FRAME(0, 0, 30, 30),
     .primaries = &scene_bt2020,
     .neutral = &scene_neutral},
    {.name = "XYZ",
     .channels = "BGR",
     .type = EXR_PIXEL_HALF,
     .width = 31,
     .height = 31,
     .display = FRAME(0, 0, 30, 30),
     .primaries = &scene_xyz},
    {.name = "almost Rec.709",
     .channels = "BGR",
     .type = EXR_PIXEL_HALF,
     .width = 31,
     .height = 31,
     .display = FRAME(0, 0, 30, 30),
     .primaries = &scene_rec709},
    {.name = "Rec.709 by name",
     .channels = "BGR",
     .type = EXR_PIXEL_HALF,
     .width = 16,
     .height = 16,
     .display = FRAME(0, 0, 15, 15),
     .primaries = &scene_exactly_rec709},
    {.name = "grey of BT.2020",
     .channels = "BGR",
     .type = EXR_PIXEL_HALF,
     .width = 31,
     .height = 31,
     .display = FRAME(0, 0, 30, 30),
     .primaries = &scene_bt2020,
     .grey = true},
    {.name = "grey, three planes, alpha",
     .channels = "ABGR",
     .type = EXR_PIXEL_FLOAT,
     .width = 50,
     .height = 30,
     .display = FRAME(-1, -1, 50, 30),
     .grey = true},
    {.name = "luminance with alpha",
     .channels = "AY",
     .type = EXR_PIXEL_HALF,
     .width = 50,
     .height = 30,
     .display = FRAME(0, 0, 49, 29)},
    {.name = "floats",
     .channels = "BGR",
     .type = EXR_PIXEL_FLOAT,
     .width = 203,
     .height = 101,
     .display = FRAME(0, 0, 202, 100)},
    {.name = "no green",
     .channels = "BR",
     .type = EXR_PIXEL_HALF,
     .width = 29,
     .height = 11,
     .display = FRAME(0, 0, 28, 10)},
};

/* A colour: mostly between 2^-8 and 2^4, now and then negative, 0 or far out. */
static float scene_colour(uint64_t random) {
    float value = ldexpf(1 + (float)(random >> 41) * 0x1p-23f, (int)(random % 12) - 8);
    unsigned dice = (unsigned)(random >> 8) % 64;
    if (dice == 0) return -value;
    if (dice == 1) return 0;
    if (dice == 2) return ldexpf(value, 8);
    if (dice == 3) return ldexpf(value, -9);
    return value;
}

/* 0, 1, above 1, or between. */
static float scene_alpha(uint64_t random) {
    static const float often[4] = {0, 1, 1.5f, 0.5f};
    unsigned dice = (unsigned)random % 8;
    return dice < 4 ? often[dice] : (float)(random >> 54) / 1024;
}

static void scene_store(uint8_t *pixels, exr_pixel_type_t type, size_t i, float value) {
    if (type == EXR_PIXEL_FLOAT) {
        memcpy(pixels + 4 * i, &value, 4);
        return;
    }
    /* cut to 10 bits of fraction: any half will do */
    uint32_t bits;
    memcpy(&bits, &value, 4);
    int exponent = (int)(bits >> 23 & 255) - 127 + 15;
    uint16_t half = (uint16_t)(bits >> 16 & 0x8000);
    if (exponent > 0) half |= (uint16_t)(exponent << 10 | (bits >> 13 & 1023));
    memcpy(pixels + 2 * i, &half, 2);
}

static void scene_fill(const oracle_scene *scene, recipe *r) {
    size_t count = (size_t)scene->width * (size_t)scene->height;
    for (int c = 0; c < r->channels; c++)
        r->channel[c].pixels = oracle_alloc(count, sample_size(scene->type));
    uint64_t state = (uint64_t)scene->width * 1000 + (uint64_t)scene->height;
    for (size_t i = 0; i < count; i++) {
        float colour = scene_colour(random_bits(&state));
        for (int c = 0; c < r->channels; c++) {
            uint64_t random = random_bits(&state);
            bool alpha = scene->channels[c] == 'A';
            float value = alpha ? scene->solid ? 1 : scene_alpha(random) : scene->grey ? colour : scene_colour(random);
            scene_store(r->channel[c].pixels, scene->type, i, value);
        }
    }
}

/* Writes an EXR whose pixels the recipe holds already. */
static bool scene_write(recipe *r, const oracle_scene *scene, file_bytes *file) {
    exr_context_initializer_t initializer = memory_initializer(file);
    exr_context_t context = NULL;
    const exr_attr_box2i_t data = FRAME(r->min_x, r->min_y, r->min_x + r->width - 1, r->min_y + r->height - 1);
    int part = 0;
    *file = (file_bytes){NULL, 0};
    bool done =
        exr_start_write(&context, "memory", EXR_WRITE_FILE_DIRECTLY, &initializer) == EXR_ERR_SUCCESS &&
        exr_add_part(context, "", EXR_STORAGE_SCANLINE, &part) == EXR_ERR_SUCCESS &&
        exr_initialize_required_attr_simple(context, 0, r->width, r->height, r->compression) == EXR_ERR_SUCCESS &&
        exr_set_data_window(context, 0, &data) == EXR_ERR_SUCCESS &&
        exr_set_display_window(context, 0, &scene->display) == EXR_ERR_SUCCESS;
    if (done && scene->primaries)
        done = exr_attr_set_chromaticities(context, 0, "chromaticities", scene->primaries) == EXR_ERR_SUCCESS;
    if (done && scene->neutral)
        done = exr_attr_set_v2f(context, 0, "adoptedNeutral", scene->neutral) == EXR_ERR_SUCCESS;
    for (int c = 0; done && c < r->channels; c++)
        done = exr_add_channel(context, 0, r->channel[c].name, r->channel[c].type, EXR_PERCEPTUALLY_LOGARITHMIC, 1,
                               1) == EXR_ERR_SUCCESS;
    done = done && exr_write_header(context) == EXR_ERR_SUCCESS && write_chunks(context, r);
    return (context && exr_finish(&context) == EXR_ERR_SUCCESS) && done;
}

static recipe scene_recipe(const oracle_scene *scene) {
    static const char *const letters[256] = {['A'] = "A", ['B'] = "B", ['G'] = "G", ['R'] = "R", ['Y'] = "Y"};
    recipe r = {.width = scene->width,
                .height = scene->height,
                .min_x = scene->min_x,
                .min_y = scene->min_y,
                .compression = EXR_COMPRESSION_ZIP};
    for (; scene->channels[r.channels]; r.channels++) {
        r.channel[r.channels].name = letters[(unsigned char)scene->channels[r.channels]];
        r.channel[r.channels].type = scene->type;
    }
    return r;
}

static inline bool scene_make(const oracle_scene *scene, file_bytes *file) {
    recipe r = scene_recipe(scene);
    scene_fill(scene, &r);
    bool done = scene_write(&r, scene, file);
    free_recipe(&r);
    return done;
}

#endif

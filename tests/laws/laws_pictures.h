/* For tests of single verbs: pictures as planes, and what chains make of them. */
#ifndef HDR_TESTS_LAWS_PICTURES_H
#define HDR_TESTS_LAWS_PICTURES_H

#include "laws.h"

/* A file's pixels as planes; PFM stores the last row first. */
static inline law_picture law_read_planes(const char *path) {
    law_picture file = {.path = path}, picture = {.width = 0};
    law_result pfm = law_run(&file, "pfm -j 1");
    size_t count;
    int width = 0, height = 0;
    float *values = law_read_pfm(&pfm, &count);
    bool is_colour = values && sscanf((const char *)pfm.bytes, "PF %d %d", &width, &height) == 2;
    CHECK(is_colour, "%s is no colour picture: %s", path, pfm.message);
    if (is_colour) picture = law_new_picture(path, width, height, 3, false);
    for (size_t i = 0; i < law_pixels(&picture); i++) {
        size_t row = i / (size_t)width, at = ((size_t)height - 1 - row) * (size_t)width + i % (size_t)width;
        for (size_t p = 0; p < 3; p++)
            picture.plane[p][i] = values[3 * at + p];
    }
    free(values);
    free(pfm.bytes);
    return picture;
}

static inline law_picture law_copy_of(const law_picture *picture) {
    law_picture copy = law_new_picture(picture->name, picture->width, picture->height, picture->planes, false);
    for (int p = 0; p < picture->planes; p++)
        memcpy(copy.plane[p], picture->plane[p], law_pixels(picture) * sizeof(float));
    return copy;
}

/* The codes of a PNG; an empty list where the run fails. */
typedef struct law_codes {
    uint16_t *code;
    size_t count;
} law_codes;

/* rest: what stands behind png. */
static inline law_codes law_codes_of(const law_picture *picture, const char *text, const char *rest) {
    law_result png = law_run(picture, "%s then png -j 2 %s", text, rest);
    CHECK(png.status == HDR_OK, "%s on %s: status %d, %s", text, picture->name, (int)png.status, png.message);
    law_codes codes = {NULL, 0};
    if (png.bytes) codes.code = law_read_png(&png, &codes.count);
    free(png.bytes);
    return codes;
}

#endif

/* What a local verb computes around each pixel, shown to others. */
#include "chain/run.h"

#include <stdlib.h>
#include <string.h>

static float number_at(const hdr_plane *plane, int x, int y) {
    size_t at = (size_t)y * plane->stride + (size_t)x;
    return plane->wide ? (float)plane->wide[at] : plane->narrow[at];
}

/* All numbers of a plane, without gaps. */
static float *copy_plane(const hdr_plane *plane, hdr_error *err) {
    float *numbers = hdr_alloc((size_t)plane->width * (size_t)plane->height, sizeof *numbers);
    float *to = numbers;
    if (!numbers) hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (int y = 0; numbers && y < plane->height; y++)
        for (int x = 0; x < plane->width; x++)
            *to++ = number_at(plane, x, y);
    return numbers;
}

static float *copy_pixels(const hdr_plane *plane, const hdr_look *look, hdr_error *err) {
    float *numbers = hdr_alloc((size_t)look->count, sizeof *numbers);
    if (!numbers) hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (int i = 0; numbers && i < look->count; i++)
        numbers[i] = number_at(plane, look->pixels[i].x, look->pixels[i].y);
    return numbers;
}

/* The verb may overwrite the luminance. */
hdr_status hdr_look_before(const hdr_look *look, hdr_surroundings *with, hdr_error *err) {
    look->seen->width = with->luminance->width;
    look->seen->height = with->luminance->height;
    for (int i = 0; i < look->count; i++) {
        const hdr_pixel *pixel = &look->pixels[i];
        if (pixel->x < 0 || pixel->y < 0 || pixel->x >= look->seen->width || pixel->y >= look->seen->height)
            return hdr_fail(err, HDR_USAGE, "there is no pixel %d,%d", pixel->x, pixel->y);
    }
    with->pixels = look->pixels;
    with->pixel_count = look->count;
    if (look->pixels) return HDR_OK;
    look->seen->luminance = copy_plane(with->luminance, err);
    return look->seen->luminance ? HDR_OK : HDR_INTERNAL;
}

hdr_status hdr_look_after(const hdr_look *look, const hdr_surroundings *with, double milliseconds, hdr_error *err) {
    hdr_surround *seen = look->seen;
    seen->values = look->pixels ? copy_pixels(with->surround, look, err) : copy_plane(with->surround, err);
    seen->milliseconds = milliseconds;
    seen->bound = with->bound;
    seen->partial = with->partial;
    memcpy(seen->method, with->method, sizeof seen->method);
    return seen->values ? HDR_OK : HDR_INTERNAL;
}

/* ---- The public look ---- */

hdr_surround *hdr_chain_surround(hdr_chain *chain, hdr_input *input, int count, const hdr_pixel pixels[],
                                 const hdr_listener *listener, hdr_error *err) {
    const hdr_clause *last = chain->count ? &chain->clauses[chain->count - 1] : NULL;
    if (!last || !last->verb->surround) {
        hdr_fail(err, HDR_USAGE, "%s computes nothing around a pixel",
                 last ? last->verb->about.name : "an empty chain");
        return NULL;
    }
    hdr_surround *seen = hdr_alloc(1, sizeof *seen);
    hdr_look look = {.pixels = count > 0 ? pixels : NULL, .count = count > 0 ? count : 0, .seen = seen};
    hdr_status status = seen ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
    if (!status) status = hdr_chain_look(chain, input, listener, &look, err);
    if (!status) return seen;
    hdr_surround_free(seen);
    return NULL;
}

void hdr_surround_free(hdr_surround *surround) {
    if (!surround) return;
    free((float *)surround->luminance); /* its own */
    free((float *)surround->values);
    free(surround);
}

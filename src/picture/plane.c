#include "picture/plane.h"

#include <stdlib.h>

static size_t bytes_of(const hdr_plane *plane) {
    return plane->stride * (size_t)plane->height * (plane->wide ? sizeof(double) : sizeof(float));
}

hdr_plane *hdr_plane_new(int width, int height, bool wide, hdr_error *err) {
    hdr_plane *plane = hdr_alloc(1, sizeof *plane);
    /* an odd number of pieces: rows that follow one another by a power of two would crowd in a few lines of the cache
     */
    size_t pieces = ((size_t)width + HDR_PIECE - 1) / HDR_PIECE | 1, bytes = 0;
    if (!plane || __builtin_mul_overflow(pieces * HDR_PIECE * sizeof(double), (size_t)height, &bytes)) goto fail;
    *plane = (hdr_plane){.width = width, .height = height, .stride = pieces * HDR_PIECE};
    void *numbers = hdr_alloc_pages(wide ? bytes : bytes / 2);
    if (!numbers) goto fail;
    if (wide)
        plane->wide = numbers;
    else
        plane->narrow = numbers;
    return plane;
fail:
    free(plane);
    hdr_fail(err, HDR_INTERNAL, "out of memory: a plane of %d x %d numbers", width, height);
    return NULL;
}

void hdr_plane_free(hdr_plane *plane) {
    if (!plane) return;
    hdr_free_pages(plane->wide ? (void *)plane->wide : (void *)plane->narrow, bytes_of(plane));
    free(plane);
}

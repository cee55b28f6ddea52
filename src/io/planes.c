/* The source of pixels that are in memory already: blocks that point straight into the caller's planes. */
#include "io/source.h"
#include "picture/colour.h"

#include <stdio.h>
#include <stdlib.h>

enum { BLOCK_ROWS = 16 };

struct planes_source {
    hdr_source base;
    const hdr_planes *planes;
};

static hdr_status worker_new(hdr_source *source, void **worker, hdr_error *err) {
    (void)source;
    (void)err;
    *worker = NULL;
    return HDR_OK;
}

static void worker_free(hdr_source *source, void *worker) {
    (void)source;
    (void)worker;
}

static hdr_status read_block(hdr_source *base, void *worker, int index, hdr_block *block, hdr_error *err) {
    (void)worker;
    (void)err;
    const hdr_planes *planes = ((struct planes_source *)base)->planes;
    int first = index * BLOCK_ROWS, left = planes->height - first;
    *block = (hdr_block){.first_row = first, .rows = left < BLOCK_ROWS ? left : BLOCK_ROWS};
    for (int p = 0; p < 4; p++) {
        const float *plane = p == 3 ? planes->alpha : p < planes->planes ? planes->plane[p] : NULL;
        block->type[p] = HDR_FLOAT;
        if (!plane) continue;
        block->plane[p] = (const unsigned char *)(plane + (size_t)first * (size_t)planes->width);
        block->stride[p] = (size_t)planes->width * sizeof(float);
    }
    return HDR_OK;
}

static void close_source(hdr_source *source) {
    free(source);
}

static void describe(const hdr_planes *planes, hdr_picture *picture) {
    static const char *const colours[] = {"R", "G", "B", "A"};
    picture->data = picture->display = (hdr_window){0, 0, planes->width - 1, planes->height - 1};
    picture->planes = planes->planes;
    picture->has_alpha = planes->alpha != NULL;
    for (int p = 0; p < 4; p++) {
        bool present = p == 3 ? picture->has_alpha : p < planes->planes;
        const char *name = p == 0 && planes->planes == 1 ? "Y" : colours[p];
        picture->present[p] = present;
        picture->channels[p].type = HDR_FLOAT;
        if (present) snprintf(picture->channels[p].name, HDR_CHANNEL_NAME, "%s", name);
    }
    picture->chromaticities = hdr_rec709;
    picture->pixel_aspect = 1;
    snprintf(picture->state, sizeof picture->state, "linear");
    snprintf(picture->format, sizeof picture->format, "planes");
    snprintf(picture->storage, sizeof picture->storage, "planes");
    snprintf(picture->compression, sizeof picture->compression, "none");
}

hdr_source *hdr_planes_open(hdr_input *input, hdr_error *err) {
    const hdr_planes *planes = hdr_input_get_planes(input);
    struct planes_source *source = planes ? hdr_alloc(1, sizeof *source) : NULL;
    if (!source) {
        hdr_fail(err, HDR_INTERNAL, planes ? "out of memory" : "no planes to read");
        return NULL;
    }
    source->planes = planes;
    source->base = (hdr_source){
        .block_rows = BLOCK_ROWS,
        .blocks = (planes->height - 1) / BLOCK_ROWS + 1,
        .worker_new = worker_new,
        .read = read_block,
        .worker_free = worker_free,
        .close = close_source,
    };
    describe(planes, &source->base.picture);
    return &source->base;
}

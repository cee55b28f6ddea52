/* A rectangle of another source's picture: its blocks, with the planes pointing to the first column that is left.
 * Blocks outside its rows are never asked for, and the source is told which columns are looked at. */
#include "io/source.h"

#include <stdlib.h>

struct crop_source {
    hdr_source base;
    hdr_source *whole;
    int first_block; /* of the whole: our block 0 */
    int64_t top;     /* row of the whole's data window that is our row 0 */
};

static hdr_status worker_new(hdr_source *base, void **worker, hdr_error *err) {
    hdr_source *whole = ((struct crop_source *)base)->whole;
    return whole->worker_new(whole, worker, err);
}

static void worker_free(hdr_source *base, void *worker) {
    hdr_source *whole = ((struct crop_source *)base)->whole;
    whole->worker_free(whole, worker);
}

static hdr_status read_block(hdr_source *base, void *worker, int index, hdr_block *block, hdr_error *err) {
    struct crop_source *source = (struct crop_source *)base;
    hdr_source *whole = source->whole;
    hdr_status status = whole->read(whole, worker, source->first_block + index, block, err);
    if (status != HDR_OK) return status;
    int first = hdr_source_first_row(base, index), end = hdr_source_first_row(base, index + 1);
    size_t above = (size_t)(first + source->top - block->first_row);
    for (int p = 0; p < 4; p++)
        if (block->plane[p])
            block->plane[p] += above * block->stride[p] + (size_t)whole->first_column * hdr_type_size(block->type[p]);
    block->first_row = first;
    block->rows = end - first;
    return HDR_OK;
}

static void close_source(hdr_source *base) {
    struct crop_source *source = (struct crop_source *)base;
    hdr_source_close(source->whole);
    free(source);
}

static int32_t larger(int32_t a, int32_t b) {
    return a > b ? a : b;
}

static int32_t smaller(int32_t a, int32_t b) {
    return a < b ? a : b;
}

hdr_source *hdr_crop_open(hdr_source *whole, const hdr_window *rectangle, hdr_error *err) {
    struct crop_source *source = hdr_alloc(1, sizeof *source);
    if (!source) {
        hdr_source_close(whole);
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        return NULL;
    }
    const hdr_window *data = &whole->picture.data;
    hdr_window left = {larger(data->min_x, rectangle->min_x), larger(data->min_y, rectangle->min_y),
                       smaller(data->max_x, rectangle->max_x), smaller(data->max_y, rectangle->max_y)};
    bool empty = left.max_x < left.min_x || left.max_y < left.min_y;
    /* an empty window is given a place within what OpenEXR's coordinates can say */
    if (empty) left = (hdr_window){1, 1, 0, 0};
    source->whole = whole;
    source->base = (hdr_source){.picture = whole->picture,
                                .block_rows = whole->block_rows,
                                .end = whole->end,
                                .worker_new = worker_new,
                                .read = read_block,
                                .worker_free = worker_free,
                                .close = close_source};
    source->base.picture.data = left;
    source->base.picture.display = *rectangle;
    if (empty) return &source->base;
    source->top = (int64_t)left.min_y - data->min_y;
    source->first_block = hdr_source_block_of(whole, (int)source->top);
    source->base.rows_cut = (int)(source->top + whole->rows_cut - (int64_t)source->first_block * whole->block_rows);
    source->base.blocks =
        hdr_source_block_of(whole, (int)((int64_t)left.max_y - data->min_y)) - source->first_block + 1;
    whole->first_column = (int64_t)left.min_x - data->min_x;
    whole->end_column = (int64_t)left.max_x - data->min_x + 1;
    return &source->base;
}

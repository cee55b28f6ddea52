/* Blocks of pixels as the source stores them, and the windows' arithmetic. */
#ifndef HDR_PICTURE_H
#define HDR_PICTURE_H

#include "base/base.h"

static inline int64_t hdr_window_width(const hdr_window *window) {
    return window->max_x < window->min_x ? 0 : (int64_t)window->max_x - window->min_x + 1;
}
static inline int64_t hdr_window_height(const hdr_window *window) {
    return window->max_y < window->min_y ? 0 : (int64_t)window->max_y - window->min_y + 1;
}
static inline size_t hdr_type_size(hdr_type type) {
    return type == HDR_HALF ? 2 : 4;
}

/* A band of whole rows of the data window in the type that the file stores. plane[0..2] are R, G, B (plane[0] alone:
 * Y), plane[3] is alpha; NULL for a channel that the file does not have. Values are little-endian, not yet repaired. */
typedef struct hdr_block {
    int first_row, rows; /* 0 is the data window's top row */
    hdr_type type[4];
    const unsigned char *plane[4]; /* the first row of each; aligned to the type */
    size_t stride[4];              /* bytes from one row to the next */
} hdr_block;

#endif

/* The levels of a tiled part: how large each is, and where its chunks stand among all. */
#ifndef HDR_EXR_LEVELS_H
#define HDR_EXR_LEVELS_H

#include "base/base.h"

#include <openexr.h>

typedef struct hdr_exr_levels {
    int64_t width, height; /* of level 0 */
    int64_t tile_width, tile_height;
    exr_tile_level_mode_t mode;
    bool up; /* sizes are rounded up */
} hdr_exr_levels;

/* How many there are: of a ripmap those that are as often halved across as down. Sizes are at least 1. */
int hdr_exr_level_count(const hdr_exr_levels *levels);

/* A width or height at a level. */
int64_t hdr_exr_level_size(const hdr_exr_levels *levels, int64_t size, int level);

/* Chunks that stand in front of the level's in the table. For hdr_exr_level_count(): all there are. At most INT32_MAX
 * chunks at level 0. */
uint64_t hdr_exr_level_chunks(const hdr_exr_levels *levels, int level);

/* The smallest level whose larger side has that many pixels; 0 if there is none. */
int hdr_exr_level_for(const hdr_exr_levels *levels, int64_t pixels);

/* A window at a level. The data window keeps its first corner, and so the rest of the frame is brought nearer to that.
 */
hdr_window hdr_exr_level_window(const hdr_exr_levels *levels, const hdr_window *window, const hdr_window *data,
                                int level);

#endif

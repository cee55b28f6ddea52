#include "io/exr_levels.h"

#include "picture/picture.h"

static int halvings(const hdr_exr_levels *levels, int64_t size) {
    int count = 0;
    while (hdr_exr_level_size(levels, size, count) > 1)
        count++;
    return count;
}

/* Levels across or down. A mip map goes on until both sides are 1, and shares its number. */
static int levels_of(const hdr_exr_levels *levels, int64_t size) {
    int64_t larger = levels->width > levels->height ? levels->width : levels->height;
    switch (levels->mode) {
    case EXR_TILE_MIPMAP_LEVELS:
        return halvings(levels, larger) + 1;
    case EXR_TILE_RIPMAP_LEVELS:
        return halvings(levels, size) + 1;
    default:
        return 1;
    }
}

int hdr_exr_level_count(const hdr_exr_levels *levels) {
    int across = levels_of(levels, levels->width), down = levels_of(levels, levels->height);
    return across < down ? across : down;
}

int64_t hdr_exr_level_size(const hdr_exr_levels *levels, int64_t size, int level) {
    int64_t rounding = levels->up ? ((int64_t)1 << level) - 1 : 0, scaled = (size + rounding) >> level;
    return scaled < 1 ? 1 : scaled;
}

static uint64_t tiles(const hdr_exr_levels *levels, int64_t size, int64_t tile, int level) {
    return (uint64_t)((hdr_exr_level_size(levels, size, level) + tile - 1) / tile);
}

/* A mip map's levels follow each other; of a ripmap, all widths of a height, then those of the next. */
uint64_t hdr_exr_level_chunks(const hdr_exr_levels *levels, int level) {
    uint64_t before = 0, across = 0;
    if (levels->mode != EXR_TILE_RIPMAP_LEVELS) {
        for (int l = 0; l < level; l++)
            before += tiles(levels, levels->width, levels->tile_width, l) *
                      tiles(levels, levels->height, levels->tile_height, l);
        return before;
    }
    int widths = levels_of(levels, levels->width), heights = levels_of(levels, levels->height);
    bool all = level == hdr_exr_level_count(levels);
    for (int l = 0; l < widths; l++)
        across += tiles(levels, levels->width, levels->tile_width, l);
    for (int l = 0; l < (all ? heights : level); l++)
        before += across * tiles(levels, levels->height, levels->tile_height, l);
    for (int l = 0; !all && l < level; l++)
        before += tiles(levels, levels->width, levels->tile_width, l) *
                  tiles(levels, levels->height, levels->tile_height, level);
    return before;
}

int hdr_exr_level_for(const hdr_exr_levels *levels, int64_t pixels) {
    int64_t larger = levels->width > levels->height ? levels->width : levels->height;
    int level = 0;
    while (level + 1 < hdr_exr_level_count(levels) && hdr_exr_level_size(levels, larger, level + 1) >= pixels)
        level++;
    return level;
}

/* The place of a corner at distance from the data window's first. */
static int64_t scaled_down(int64_t distance, int level) {
    return distance >= 0 ? distance >> level : -((-distance + ((int64_t)1 << level) - 1) >> level);
}

static void scale_side(const hdr_exr_levels *levels, int32_t *min, int32_t *max, int32_t fixed, int level) {
    if (level == 0 || *max < *min) return;
    int64_t rounding = levels->up ? ((int64_t)1 << level) - 1 : 0;
    int64_t first = fixed + scaled_down((int64_t)*min - fixed, level);
    int64_t last = fixed + scaled_down((int64_t)*max + 1 - fixed + rounding, level) - 1;
    *min = (int32_t)first;
    *max = (int32_t)(last < first ? first : last);
}

hdr_window hdr_exr_level_window(const hdr_exr_levels *levels, const hdr_window *window, const hdr_window *data,
                                int level) {
    hdr_window scaled = *window;
    scale_side(levels, &scaled.min_x, &scaled.max_x, data->min_x, level);
    scale_side(levels, &scaled.min_y, &scaled.max_y, data->min_y, level);
    return scaled;
}

#include "io/exr_sampling.h"

#include <string.h>

static int64_t floor_divide(int64_t a, int64_t b) {
    return a / b - (a % b != 0 && (a < 0) != (b < 0));
}

int64_t hdr_exr_samples(int sampling, int64_t first, int64_t count) {
    return floor_divide(first + count - 1, sampling) - floor_divide(first - 1, sampling);
}

/* Bytes of a line's samples of one channel. */
static size_t channel_bytes(const hdr_exr_header *header, const exr_attr_chlist_entry_t *entry) {
    int64_t samples = hdr_exr_samples(entry->x_sampling, header->picture.data.min_x, header->width);
    return (size_t)samples * (entry->pixel_type == EXR_PIXEL_HALF ? 2 : 4);
}

size_t hdr_exr_lines_bytes(const hdr_exr_header *header, int64_t first_line, int lines) {
    size_t bytes = 0;
    for (int c = 0; c < header->list->num_channels; c++) {
        const exr_attr_chlist_entry_t *entry = &header->list->entries[c];
        bytes += channel_bytes(header, entry) * (size_t)hdr_exr_samples(entry->y_sampling, first_line, lines);
    }
    return bytes;
}

void hdr_exr_gather_lines(const hdr_exr_header *header, const unsigned char *from, int64_t first_line, int lines,
                          unsigned char *const plane[4], const size_t stride[4]) {
    size_t rows[4] = {0};
    for (int64_t line = first_line; line < first_line + lines; line++)
        for (int c = 0; c < header->list->num_channels; c++) {
            const exr_attr_chlist_entry_t *entry = &header->list->entries[c];
            if (line % entry->y_sampling != 0) continue;
            size_t bytes = channel_bytes(header, entry);
            for (int p = 0; p < 4; p++)
                if (plane[p] && header->index[p] == c) memcpy(plane[p] + stride[p] * rows[p]++, from, bytes);
            from += bytes;
        }
}

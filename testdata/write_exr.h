/*
 * write_exr: one picture into one scan-line OpenEXR file, through OpenEXRCore.
 *
 * SPDX-License-Identifier: BSD-3-Clause
 */
#ifndef HDRPIPE_TESTDATA_WRITE_EXR_H
#define HDRPIPE_TESTDATA_WRITE_EXR_H

#include <openexr.h>
#include <stdbool.h>

/* A picture in memory. Pixels are interleaved, rows from the top, and cover the data window. */
typedef struct {
    const char *channels; /* one letter a channel in the order of the pixels: "RGB", "RGBA" or "Y" */
    exr_attr_box2i_t display_window;
    exr_attr_box2i_t data_window;
    const float *pixels;
    const exr_attr_chromaticities_t *chromaticities; /* NULL: the file has no such attribute */
} Picture;

/* The window with (0,0) at its top left corner. */
exr_attr_box2i_t window_of_size(int width, int height);

/*
 * Writes the picture with the required header attributes, and chromaticities if it has them, and no others. type is
 * EXR_PIXEL_HALF or EXR_PIXEL_FLOAT. On failure it says why on stderr and returns false.
 */
bool write_exr(const char *path, const Picture *picture, exr_pixel_type_t type, exr_compression_t compression);

#endif

/* Luminance-chroma pictures as R, G, B. */
#ifndef HDR_EXR_YC_H
#define HDR_EXR_YC_H

#include "io/source.h"

/* A source of R, G, B (half) on top of one whose planes are Y, RY, BY as they are stored, chroma with a sample in each
 * sampling-th column of each sampling-th row (1, or 2 where all sides are even). The result owns `stored`, which is
 * closed on a fault too. */
hdr_source *hdr_yc_open(hdr_source *stored, int sampling, hdr_input *input, const hdr_reading *reading, hdr_error *err);

#endif

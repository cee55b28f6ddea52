/* A picture that is smoothed where its noise is: a source like any other, whose blocks are made of another's and of a
 * second picture that holds the standard deviation of each component. Neither picture is held as a whole: a block reads
 * its own rows of both and those around them that matter to it. */
#ifndef HDR_SMOOTH_H
#define HDR_SMOOTH_H

#include "io/source.h"
#include "spatial/nlmeans.h"

/* It takes the picture over, in any case; the inputs stay the caller's, and have to stay. HDR_USAGE: the guide is the
 * picture's own file. HDR_BAD_DATA: they are not of one form, or the picture holds whole numbers. */
hdr_source *hdr_smooth_open(hdr_source *picture, hdr_input *input, hdr_input *guide, const hdr_reading *reading,
                            const hdr_nlmeans *filter, hdr_error *err);

/* Of all blocks read so far, each once. */
typedef struct hdr_smoothed {
    uint64_t pixels, left_alone;
    uint64_t unusable; /* standard deviations that are NaN or infinite, and count as 0 */
} hdr_smoothed;
hdr_smoothed hdr_smooth_counts(const hdr_source *source);

#endif

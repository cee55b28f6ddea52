/* What reading several pictures together takes. */
#ifndef HDR_FORMS_H
#define HDR_FORMS_H

#include "io/source.h"

/* Whether a picture has the first one's form: data window, channels (alpha, if that matters), primaries, encoding. The
 * inputs are for the message: HDR_BAD_DATA. */
hdr_status hdr_compare_forms(const hdr_input *other, const hdr_picture *picture, const hdr_input *first,
                             const hdr_picture *wanted, bool alpha, hdr_error *err);

/* Opens pictures that must have one form: data window, channels (alpha, if that matters), primaries, encoding. NULL:
 * err is filled, HDR_BAD_DATA where they have not. Close them with hdr_close_alike, which takes NULL. */
hdr_source **hdr_open_alike(int count, hdr_input *const inputs[], const hdr_reading *reading, bool alpha,
                            hdr_error *err);
void hdr_close_alike(int count, hdr_source **sources);

/* count <= HDR_STRIP numbers from x on of a block's row, counted from the block's first, as they are stored. How many
 * of them are not finite. */
uint64_t hdr_block_load(const hdr_block *block, int channel, int row, size_t x, double *out, size_t count);

/* Gives rows first ... end-1 of the data window away, strip by strip of channels 0 ... channels-1. *strange counts
 * numbers that are not finite. The worker that it takes lives no longer than that, since there may be hundreds of
 * pictures. */
typedef void (*hdr_visit)(void *context, int channel, int row, size_t x, const double *values, size_t count);
hdr_status hdr_source_visit(hdr_source *source, int channels, int first, int end, hdr_visit visit, void *context,
                            uint64_t *strange, hdr_error *err);

#endif

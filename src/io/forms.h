/* What reading several pictures together takes. */
#ifndef HDR_FORMS_H
#define HDR_FORMS_H

#include "io/source.h"

/* Whether a picture has the form of the first: data window, channels (alpha, if that matters), primaries, encoding.
 * HDR_BAD_DATA: what differs. */
hdr_status hdr_forms_agree(const hdr_input *other, const hdr_picture *picture, const hdr_input *first,
                           const hdr_picture *wanted, bool alpha, hdr_error *err);

/* count <= HDR_STRIP numbers from x on of a block's row, counted from the block's first, as they are stored. How many
 * of them are not finite. */
uint64_t hdr_block_load(const hdr_block *block, int channel, int row, size_t x, double *out, size_t count);

/* Gives rows first ... end-1 of the data window away, strip by strip of every channel. *strange counts numbers that are
 * not finite. The worker that it takes lives no longer than that, since there may be hundreds of pictures. */
typedef void (*hdr_visit)(void *context, int channel, int row, size_t x, const double *values, size_t count);
hdr_status hdr_source_visit(hdr_source *source, int first, int end, hdr_visit visit, void *context, uint64_t *strange,
                            hdr_error *err);

#endif

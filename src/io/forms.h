/* Pictures that are read together. */
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

#endif

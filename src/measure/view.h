/* What a viewer sees of pictures, which a test has to share with its reference. */
#ifndef HDR_VIEW_H
#define HDR_VIEW_H

#include "base/base.h"

/* The pixels of an input's data window, repaired, colour associated with alpha, which is over black: as they are, light
 * of Rec.709's primaries; or of that codes, held to [0,1], what is linear encoded by sRGB. They are had from
 * hdr_output_pixels, without alpha. like: whose common options count. NULL: err is filled. */
typedef enum hdr_view { HDR_VIEW_STORED, HDR_VIEW_ENCODED } hdr_view;
hdr_output *hdr_view_pixels(const hdr_chain *like, hdr_input *input, hdr_view view, hdr_error *err);

/* HDR_BAD_DATA where test and reference are not of one form. */
hdr_status hdr_check_alike(const hdr_chain *like, hdr_input *test, hdr_input *reference, hdr_error *err);

#endif

#include "measure/view.h"

#include "chain/chain.h"
#include "io/forms.h"

#include <string.h>

static hdr_status add_encoding(hdr_chain *chain, hdr_input *input, const hdr_chain *like, hdr_error *err) {
    static const char *const clamp[] = {"clamp"}, *const srgb[] = {"srgb"};
    hdr_picture picture;
    hdr_status status = hdr_input_picture(input, like, &picture, err);
    if (status == HDR_OK) status = hdr_chain_add(chain, clamp, 1, err);
    if (status == HDR_OK && !strcmp(picture.state, "linear")) status = hdr_chain_add(chain, srgb, 1, err);
    return status;
}

hdr_output *hdr_view_pixels(const hdr_chain *like, hdr_input *input, hdr_view view, hdr_error *err) {
    hdr_chain *chain = hdr_chain_new_viewing(like, err);
    hdr_output *output = chain ? hdr_output_planes(err) : NULL;
    hdr_status status = output ? HDR_OK : HDR_INTERNAL;
    if (status == HDR_OK && view == HDR_VIEW_ENCODED) status = add_encoding(chain, input, like, err);
    if (status == HDR_OK) status = hdr_chain_run(chain, input, output, NULL, err);
    hdr_chain_free(chain);
    if (status == HDR_OK) return output;
    hdr_output_free(output);
    return NULL;
}

hdr_status hdr_check_alike(const hdr_chain *like, hdr_input *test, hdr_input *reference, hdr_error *err) {
    hdr_reading reading = hdr_chain_reading(like);
    hdr_error own = {0};
    hdr_source **alike = hdr_open_alike(2, (hdr_input *const[]){test, reference}, &reading, false, &own);
    if (!alike) return hdr_fail(err, own.status, "%s", own.message);
    hdr_close_alike(2, alike);
    return HDR_OK;
}

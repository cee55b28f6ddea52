/* --alpha: what becomes of the alpha channel, and what shows through where it is below 1. */
#include "chain/run.h"

#include <string.h>

bool hdr_run_has_border(const hdr_run *run) {
    const hdr_window *data = &run->source->picture.data, *display = &run->source->picture.display;
    return run->chain->common.window == HDR_WINDOW_DISPLAY &&
           (display->min_x < data->min_x || display->max_x > data->max_x || display->min_y < data->min_y ||
            display->max_y > data->max_y);
}

void hdr_run_spread(hdr_run *run) {
    static const char *const names[3] = {"R", "G", "B"};
    hdr_picture *picture = &run->source->picture;
    if (picture->planes == 3) return;
    run->spread = true;
    picture->planes = 3;
    for (int c = 0; c < 3; c++) {
        picture->channels[c].type = picture->channels[0].type;
        memcpy(picture->channels[c].name, names[c], sizeof "R");
    }
}

/* Values that follow a display's curve cannot be added to as light can. */
static hdr_status refuse_encoded(const char *state, hdr_error *err) {
    char clause[HDR_CLAUSE_TEXT];
    hdr_decoding_clause(state, clause);
    return hdr_fail(err, HDR_BAD_DATA,
                    "--alpha over: only light can be laid over a colour, and the picture is encoded (%s); decode it to "
                    "a file first (hdr %s then exr)",
                    state, clause);
}

hdr_status hdr_run_choose_alpha(hdr_run *run, hdr_error *err) {
    const hdr_alpha *alpha = &run->chain->common.alpha;
    hdr_picture *picture = &run->source->picture;
    if (alpha->how == HDR_ALPHA_KEEP ||
        (!picture->has_alpha && !(alpha->how == HDR_ALPHA_OVER && hdr_run_has_border(run))))
        return HDR_OK;
    if (alpha->how == HDR_ALPHA_OVER && strcmp(picture->state, "linear") != 0)
        return refuse_encoded(picture->state, err);
    picture->has_alpha = false;
    if (alpha->how == HDR_ALPHA_DROP) {
        picture->present[3] = false;
        hdr_say(run->listener, HDR_EXPLAIN, "alpha is dropped: colour as it is stored");
        return HDR_OK;
    }
    run->over = alpha->colour;
    run->coloured = alpha->colour[0] != alpha->colour[1] || alpha->colour[0] != alpha->colour[2];
    if (run->coloured) hdr_run_spread(run);
    hdr_say(run->listener, HDR_EXPLAIN, "the picture is laid over %g,%g,%g", alpha->colour[0], alpha->colour[1],
            alpha->colour[2]);
    return HDR_OK;
}

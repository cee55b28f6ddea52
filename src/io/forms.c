#include "io/forms.h"

#include "io/input.h"
#include "picture/colour.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static hdr_status refuse(const hdr_input *other, const hdr_input *first, const char *why, hdr_error *err) {
    return hdr_fail(err, HDR_BAD_DATA, "%s and %s are not of one form: %s", hdr_input_name(first),
                    hdr_input_name(other), why);
}

hdr_status hdr_compare_forms(const hdr_input *other, const hdr_picture *picture, const hdr_input *first,
                             const hdr_picture *wanted, bool alpha, hdr_error *err) {
    char why[600];
    if (memcmp(&picture->data, &wanted->data, sizeof picture->data) != 0) {
        snprintf(why, sizeof why, "%lld x %lld pixels from %d,%d and %lld x %lld from %d,%d",
                 (long long)hdr_window_width(&wanted->data), (long long)hdr_window_height(&wanted->data),
                 wanted->data.min_x, wanted->data.min_y, (long long)hdr_window_width(&picture->data),
                 (long long)hdr_window_height(&picture->data), picture->data.min_x, picture->data.min_y);
        return refuse(other, first, why, err);
    }
    for (int c = 0; c < 4; c++)
        if (picture->present[c] != wanted->present[c] && (c < 3 || alpha)) {
            const hdr_picture *has = picture->present[c] ? picture : wanted;
            snprintf(why, sizeof why, "only %s has the channel %.100s", hdr_input_name(has == picture ? other : first),
                     has->channels[c].name);
            return refuse(other, first, why, err);
        }
    if (hdr_chromaticities_differ(&picture->chromaticities, &wanted->chromaticities))
        return refuse(other, first, "their primaries differ", err);
    if (strcmp(picture->state, wanted->state) != 0) {
        snprintf(why, sizeof why, "one is %.60s, the other %.60s", wanted->state, picture->state);
        return refuse(other, first, why, err);
    }
    return HDR_OK;
}

void hdr_close_alike(int count, hdr_source **sources) {
    for (int i = 0; sources && i < count; i++)
        hdr_source_close(sources[i]);
    free(sources);
}

hdr_source **hdr_open_alike(int count, hdr_input *const inputs[], const hdr_reading *reading, bool alpha,
                            hdr_error *err) {
    hdr_source **sources = hdr_alloc((size_t)count, sizeof(hdr_source *));
    if (!sources) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        return NULL;
    }
    for (int i = 0; i < count; i++) {
        sources[i] = hdr_source_open(inputs[i], reading, err);
        if (sources[i] &&
            hdr_compare_forms(inputs[i], &sources[i]->picture, inputs[0], &sources[0]->picture, alpha, err) == HDR_OK)
            continue;
        hdr_close_alike(count, sources);
        return NULL;
    }
    return sources;
}

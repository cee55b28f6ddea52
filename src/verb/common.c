/* What several verbs share. */
#include "verb/verb.h"

#include <string.h>

void hdr_luminance_form(const hdr_luminance_params *params, hdr_step *step) {
    step->form = params->per_channel ? HDR_FORM_CHANNEL : HDR_FORM_LUMINANCE;
    step->saturation = params->saturation.value;
}

hdr_sample hdr_format_float(const void *params, int bits) {
    (void)params, (void)bits;
    return HDR_SAMPLE_FLOAT;
}

hdr_status hdr_check_linear(const hdr_scene *scene, bool force, hdr_error *err) {
    if (force || !strcmp(scene->state, "linear")) return HDR_OK;
    return hdr_fail(err, HDR_BAD_DATA,
                    "the picture is encoded already (%s): decode it first (--decode), or insist with --force",
                    scene->state);
}

hdr_status hdr_refuse_text(const hdr_option *table, const char *name, const char *text, const char *why,
                           hdr_error *err) {
    char line[400];
    hdr_option_describe(hdr_option_find(table, name), line, sizeof line);
    return hdr_fail(err, HDR_USAGE, "--%s: '%.100s' %s\n%s", name, text, why, line);
}

/* What several verbs share. */
#include "verb/verb.h"

#include <stdio.h>
#include <string.h>

void hdr_luminance_form(const hdr_luminance_params *params, hdr_step *step) {
    step->form = params->per_channel ? HDR_FORM_CHANNEL : HDR_FORM_LUMINANCE;
    step->saturation = params->saturation.value;
}

const char *const hdr_dither_words[] = {"none", "ordered", "blue", NULL};

hdr_status hdr_dither_check(const hdr_dither_params *params, const hdr_options *given, hdr_error *err) {
    for (int i = 0; i < given->count; i++)
        if (params->kind == HDR_DITHER_NONE && !strcmp(given->given[i].option->name, "seed"))
            return hdr_fail(err, HDR_USAGE, "--seed has no meaning without --dither ordered or blue");
    return HDR_OK;
}

hdr_sample hdr_format_float(const void *params, int bits) {
    (void)params, (void)bits;
    return HDR_SAMPLE_FLOAT;
}

hdr_status hdr_check_linear(const hdr_scene *scene, bool force, hdr_error *err) {
    if (force || !strcmp(scene->state, "linear")) return HDR_OK;
    char clause[HDR_CLAUSE_TEXT];
    hdr_decoding_clause(scene->state, clause);
    return hdr_fail(err, HDR_BAD_DATA,
                    "the picture is encoded already (%s): decode it first (%s), or insist with --force", scene->state,
                    clause);
}

hdr_verdict hdr_encoding_step(const hdr_encoding_params *params, const hdr_curve *encode, const hdr_curve *decode,
                              const char *state, const hdr_scene *scene, hdr_step *step, hdr_error *err) {
    if (!params->decode && hdr_check_linear(scene, params->force, err)) return HDR_REFUSE;
    step->form = HDR_FORM_CHANNEL;
    step->curve = params->decode ? decode : encode;
    snprintf(step->state, sizeof step->state, "%s", params->decode ? "linear" : state);
    if (params->decode) snprintf(step->decodes, sizeof step->decodes, "%s", state);
    return HDR_RUN;
}

void hdr_decoding_clause(const char *state, char clause[HDR_CLAUSE_TEXT]) {
    int verb = (int)strcspn(state, " ");
    if (strcmp(state, "ocio") == 0) {
        snprintf(clause, HDR_CLAUSE_TEXT, "ocio --from SPACE --to SPACE");
        return;
    }
    const char *option = strncmp(state, "gamma ", 6) == 0 ? " --exponent"
                         : strncmp(state, "pq ", 3) == 0  ? " --nits"
                                                          : "";
    snprintf(clause, HDR_CLAUSE_TEXT, "%.*s%s%s --decode", verb, state, option, option[0] ? state + verb : "");
}

hdr_status hdr_refuse_text(const hdr_option *table, const char *name, const char *text, const char *why,
                           hdr_error *err) {
    char line[400];
    hdr_option_describe(hdr_option_find(table, name), line, sizeof line);
    return hdr_fail(err, HDR_USAGE, "--%s: '%.100s' %s\n%s", name, text, why, line);
}

hdr_status hdr_check_svg(const hdr_option *table, const char *name, const char *file, hdr_error *err) {
    const char *ending = NULL;
    for (const char *c = file; c && *c; c++)
        if (*c == '.' && c > file && c[-1] != '/') ending = c;
    bool svg = ending && !strcmp(ending, ".svg");
    return !file || svg ? HDR_OK : hdr_refuse_text(table, name, file, "does not end in .svg", err);
}

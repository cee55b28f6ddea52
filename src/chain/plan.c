/* A chain resolved against the facts, clause by clause, and run. */
#include "chain/run.h"

#include "io/input.h"
#include "picture/colour.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Where the plan stands. */
typedef struct planning {
    hdr_run *run;
    hdr_mapper *const *mappers; /* of each clause, or NULL */
    char state[64];             /* what the pixels are */
    int bits;                   /* above 0: quantised to that many */
    bool foreign;               /* primaries other than Rec.709, not yet converted */
    bool converted;
    hdr_facts facts; /* of the pixels as they were when facts were last taken; fresh: as they are now */
    bool fresh;
    hdr_facts range;      /* range of the components, carried along; known is 0 where it is not */
    hdr_plane *luminance; /* of the pixels as they were when it was last asked for */
} planning;

static hdr_status append_step(planning *p, const hdr_step *step, hdr_error *err) {
    hdr_run *run = p->run;
    hdr_step *steps = hdr_grow(run->steps, (size_t)run->step_count + 1, sizeof *steps);
    if (!steps) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    run->steps = steps;
    steps[run->step_count] = *step;
    if (!step->own_weights) memcpy(steps[run->step_count].luminance, run->weights, sizeof run->weights);
    memcpy(steps[run->step_count].lit, run->weights, sizeof run->weights);
    run->step_count++;
    p->fresh = false;
    p->range.known = 0;
    return HDR_OK;
}

/* ---- Colour ---- */

static hdr_status start_colour(planning *p, hdr_error *err) {
    const hdr_picture *picture = &p->run->source->picture;
    /* one plane is luminance itself, whatever its primaries would be */
    const hdr_chromaticities *primaries = picture->planes == 1 ? &hdr_rec709 : &picture->chromaticities;
    if (!hdr_luminance_weights(primaries, p->run->weights))
        return hdr_fail(err, HDR_BAD_DATA, "its %s broken: the primaries span no triangle, or white has no light",
                        strcmp(picture->format, "exr") ? "PRIMARIES are" : "attribute chromaticities is");
    p->foreign = picture->planes == 3 && hdr_chromaticities_differ(&picture->chromaticities, &hdr_rec709) &&
                 p->run->chain->common.primaries != HDR_PRIMARIES_KEEP;
    return HDR_OK;
}

/* Encoded pictures are in Rec.709's primaries: the conversion stands in front of the first verb that encodes or
 * quantises. */
static hdr_status convert_primaries(planning *p, hdr_error *err) {
    hdr_run *run = p->run;
    const hdr_picture *picture = &run->source->picture;
    bool adapt = run->chain->common.adapt != HDR_ADAPT_NONE && !hdr_primaries_are_xyz(&picture->chromaticities);
    const double *neutral = picture->has_neutral ? picture->neutral : picture->chromaticities.white;
    hdr_step step = {.form = HDR_FORM_MATRIX};
    if (!hdr_matrix_to_rec709(&picture->chromaticities, neutral, adapt, step.matrix))
        return hdr_fail(err, HDR_BAD_DATA,
                        "its chromaticities cannot be converted to Rec.709: white cannot be adapted from %s (%g,%g) to "
                        "D65; --adapt none leaves it as it is",
                        picture->has_neutral ? "adoptedNeutral" : "their white", neutral[0], neutral[1]);
    hdr_status status = append_step(p, &step, err);
    if (status) return status;
    hdr_luminance_weights(&hdr_rec709, run->weights);
    p->foreign = false;
    p->converted = true;
    hdr_say(run->listener, HDR_EXPLAIN, "primaries are converted to Rec.709, white %s",
            adapt ? "adapted to D65" : "left as it is");
    return HDR_OK;
}

/* From here on the picture has the primaries that the step leaves, or Rec.709's, where these are not known. */
static void change_primaries(planning *p, int number, const hdr_step *step) {
    hdr_run *run = p->run;
    hdr_picture *picture = &run->source->picture;
    if (!step->primaries && !strcmp(step->state, "linear"))
        hdr_say(run->listener, HDR_NOTE,
                "clause %d (%s): which primaries its colours have is not known: they count as Rec.709's from here on",
                number, step->verb->about.name);
    picture->chromaticities = step->primaries ? *step->primaries : hdr_rec709;
    picture->has_chromaticities = hdr_chromaticities_differ(&picture->chromaticities, &hdr_rec709);
    picture->has_neutral = false;
    hdr_luminance_weights(&picture->chromaticities, run->weights);
    p->foreign = picture->has_chromaticities && run->chain->common.primaries != HDR_PRIMARIES_KEEP;
    p->converted = false;
    run->mapped = true;
}

/* ---- Clauses ---- */

/* Room for the luminance of each pixel. */
static hdr_status new_luminance(planning *p, bool wide, hdr_error *err) {
    const hdr_window *data = &p->run->source->picture.data;
    hdr_plane_free(p->luminance);
    p->luminance = hdr_plane_new((int)hdr_window_width(data), (int)hdr_window_height(data), wide, err);
    return p->luminance ? HDR_OK : HDR_INTERNAL;
}

static const hdr_shot *shot_of(const hdr_clause *clause) {
    return hdr_options_shot(clause->verb->about.options, clause->params);
}

/* What the verb wants to know. */
static hdr_request request_of(const hdr_clause *clause) {
    hdr_request request = {0};
    if (clause->verb->needs) clause->verb->needs(clause->params, &request);
    return request;
}

/* A sweep for it alone. */
static hdr_status provide_luminance(planning *p, const double *weights, bool wide, hdr_error *err) {
    const hdr_request nothing_else = {.plane = true, .weights = weights};
    hdr_facts facts;
    hdr_status status = new_luminance(p, wide, err);
    return status ? status : hdr_run_facts(p->run, &nothing_else, NULL, p->luminance, &facts, err);
}

/* Facts that are at hand already, or a sweep for them. */
static hdr_status provide_facts(planning *p, int number, const hdr_clause *clause, hdr_error *err) {
    hdr_request request = request_of(clause);
    if (shot_of(clause)) {
        hdr_say(p->run->listener, HDR_EXPLAIN, "clause %d (%s): facts of the whole shot, as given", number,
                clause->verb->about.name);
        return request.plane ? provide_luminance(p, request.weights, p->run->settings.reference, err) : HDR_OK;
    }
    bool known = p->fresh && !(request.facts & ~p->facts.known) &&
                 !(request.facts & HDR_FACT_SHIFTED && request.shift != p->facts.shift);
    if (!request.percentiles && !request.plane && (!request.facts || known)) return HDR_OK;
    if (request.plane && new_luminance(p, p->run->settings.reference, err)) return HDR_INTERNAL;
    hdr_status status = hdr_run_facts(p->run, &request, NULL, request.plane ? p->luminance : NULL, &p->facts, err);
    p->fresh = !status;
    if (!status)
        hdr_say(p->run->listener, HDR_EXPLAIN, "sweep %d: facts for clause %d (%s)", p->run->sweeps, number,
                clause->verb->about.name);
    return status;
}

/* S of each pixel, for a step that has a use for it. */
static hdr_status provide_surround(planning *p, int number, const hdr_clause *clause, const hdr_facts *facts,
                                   hdr_step *step, hdr_error *err) {
    hdr_run *run = p->run;
    hdr_plane **grown = hdr_grow(run->surrounds, (size_t)run->surround_count + 1, sizeof(hdr_plane *));
    if (!grown) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    run->surrounds = grown;
    hdr_scene scene = {.facts = *facts, .state = p->state};
    hdr_surroundings with = {.params = clause->params,
                             .scene = &scene,
                             .luminance = p->luminance,
                             .pool = run->pool,
                             .reference = run->settings.reference,
                             .no_skip = run->settings.no_skip,
                             .bound = -1};
    const hdr_look *look = number == run->chain->count ? run->look : NULL;
    if (look && hdr_look_before(look, &with, err)) return err->status;
    double started = hdr_milliseconds();
    hdr_status status = clause->verb->surround(step, &with, err);
    if (!status && with.too_wide) {
        hdr_say(run->listener, HDR_EXPLAIN, "clause %d (%s): in double, for these luminances and options", number,
                clause->verb->about.name);
        if (with.surround != p->luminance) hdr_plane_free(with.surround);
        with.surround = NULL;
        with.too_wide = false;
        status = provide_luminance(p, request_of(clause).weights, true, err);
        with.luminance = p->luminance;
        if (!status) status = clause->verb->surround(step, &with, err);
    }
    if (status) {
        char prefix[100];
        snprintf(prefix, sizeof prefix, "clause %d (%s)", number, clause->verb->about.name);
        hdr_fail_in(err, prefix);
    }
    if (look && !status) status = hdr_look_after(look, &with, hdr_milliseconds() - started, err);
    if (with.surround) run->surrounds[run->surround_count++] = with.surround;
    if (with.surround != p->luminance) hdr_plane_free(p->luminance);
    p->luminance = NULL;
    if (status) return status;
    step->surround = with.surround;
    hdr_say(run->listener, HDR_DETAIL, "surround of clause %d: %.1f ms", number, hdr_milliseconds() - started);
    hdr_say(run->listener, HDR_EXPLAIN, "clause %d (%s): %s", number, clause->verb->about.name, with.note);
    return HDR_OK;
}

/* Where a step maps each channel by a curve that is monotone to the last bit, the range of the components maps along.
 * It serves to skip, not as a fact. */
static void carry_range(planning *p, const hdr_step *step, const hdr_facts *before) {
    if (step->form != HDR_FORM_CHANNEL || !step->curve->monotone_to_the_bit || !(before->known & HDR_FACT_COMPONENTS))
        return;
    p->range = (hdr_facts){.known = HDR_FACT_COMPONENTS};
    p->range.min_component = hdr_held(step->curve->exact(&step->constants, before->min_component));
    p->range.max_component = hdr_held(step->curve->exact(&step->constants, before->max_component));
}

/* Asks the verb what it makes of the scene as it stands. */
static hdr_status resolve(planning *p, int number, const hdr_clause *clause, hdr_facts *facts, hdr_step *step,
                          hdr_verdict *verdict, hdr_error *err) {
    hdr_status status = provide_facts(p, number, clause, err);
    if (status) return status;
    *facts = p->fresh ? p->facts : p->range;
    *step = (hdr_step){.verb = clause->verb, .clause = number, .saturation = 1};
    /* a format adds clauses of its own, which have no mapper, behind all others */
    hdr_scene scene = {
        .facts = *facts, .state = p->state, .mapper = clause->verb->open ? p->mappers[number - 1] : NULL};
    hdr_request request = request_of(clause);
    const hdr_shot *shot = shot_of(clause);
    if (shot && !hdr_facts_of_shot(shot, &request, &scene.facts))
        return hdr_fail(err, HDR_INTERNAL, "clause %d (%s): it was not checked what --facts holds", number,
                        clause->verb->about.name);
    *verdict = clause->verb->plan(clause->params, &scene, step, err);
    if (*verdict != HDR_REFUSE) return HDR_OK;
    char prefix[100];
    snprintf(prefix, sizeof prefix, "clause %d (%s)", number, clause->verb->about.name);
    return hdr_fail_in(err, prefix);
}

/* Values that follow a display's curve are no light: said where a verb takes them for it. */
static void report_encoded(const planning *p, int number, const char *name) {
    char clause[HDR_CLAUSE_TEXT];
    if (!strcmp(p->state, "linear")) return;
    hdr_decoding_clause(p->state, clause);
    hdr_say(p->run->listener, HDR_NOTE,
            "clause %d (%s): it is for light, and the picture is encoded (%s): decode it first (%s then %s)", number,
            name, p->state, clause, name);
}

/* What is linear, as far as its file tells, may be encoded all the same. */
static void report_other_state(const planning *p, int number, const char *name, const char *decodes) {
    char clause[HDR_CLAUSE_TEXT];
    if (!strcmp(p->state, "linear") || !strcmp(p->state, decodes)) return;
    hdr_decoding_clause(p->state, clause);
    hdr_say(p->run->listener, HDR_NOTE,
            "clause %d (%s): it decodes %s, and the picture is encoded by another curve (%s): %s", number, name,
            decodes, p->state, clause);
}

static hdr_status plan_clause(planning *p, int number, const hdr_clause *clause, hdr_error *err) {
    hdr_run *run = p->run;
    const char *name = clause->verb->about.name;
    hdr_facts facts;
    hdr_step step;
    hdr_verdict verdict;
    hdr_status status = resolve(p, number, clause, &facts, &step, &verdict, err);
    if (status) return status;
    bool mapped = step.form == HDR_FORM_MAPPED || step.form == HDR_FORM_PALETTE;
    bool encodes = step.state[0] && strcmp(step.state, "linear") != 0 && !mapped;
    if (p->foreign && (encodes || step.bits || step.wants_rec709) && !strcmp(p->state, "linear")) {
        /* what the verb was told of is not what will reach it */
        status = convert_primaries(p, err);
        if (!status) status = resolve(p, number, clause, &facts, &step, &verdict, err);
        if (status) return status;
    }
    if (step.of_light) report_encoded(p, number, name);
    if (step.decodes[0]) report_other_state(p, number, name, step.decodes);
    if (mapped) run->light_steps = -1; /* what was encoded in front of it is something else now */
    if (encodes && run->light_steps < 0) run->light_steps = run->step_count;
    if (step.for_display) run->scene_light = false;
    if (step.bits && !encodes && !strcmp(p->state, "linear"))
        hdr_say(run->listener, HDR_NOTE, "clause %d (%s): the picture is not encoded: %d bits of linear values", number,
                name, step.bits);
    if (verdict == HDR_SKIP && !run->settings.no_skip) {
        hdr_say(run->listener, HDR_EXPLAIN, "clause %d (%s) skipped: %s", number, name, step.note);
    } else {
        hdr_say(run->listener, HDR_EXPLAIN, "clause %d (%s): %s", number, name, step.note);
        if (step.form == HDR_FORM_LOCAL) status = provide_surround(p, number, clause, &facts, &step, err);
        if (!status) status = append_step(p, &step, err);
        if (mapped) hdr_run_spread(run);
        if (mapped && step.state[0]) change_primaries(p, number, &step);
        carry_range(p, &step, &facts);
        if (step.legend.palette) run->legend = step.legend;
    }
    if (step.state[0]) memcpy(p->state, step.state, sizeof p->state);
    if (step.bits) p->bits = step.bits;
    return status;
}

/* True if some clause asks for facts, so that there will be more than one sweep. */
static bool wants_facts(const hdr_chain *chain) {
    for (int i = 0; i < chain->count; i++) {
        hdr_request request = request_of(&chain->clauses[i]);
        if (request.plane || ((request.facts || request.percentiles) && !shot_of(&chain->clauses[i]))) return true;
    }
    return false;
}

/* The state that a file claims must be one that can be told in the output. */
static hdr_status check_state(const char *state, hdr_error *err) {
    static const char *const known[] = {"linear", "srgb", "rec709", "pq", "hlg", "ocio"};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        if (!strcmp(state, known[i])) return HDR_OK;
    static const char *const numbered[] = {"gamma ", "pq "};
    for (size_t i = 0; i < sizeof numbered / sizeof numbered[0]; i++) {
        char again[64] = "";
        size_t length = strlen(numbered[i]);
        double number = strncmp(state, numbered[i], length) ? 0 : strtod(state + length, NULL);
        if (number > 0 && isfinite(number)) snprintf(again, sizeof again, "%s%.15g", numbered[i], number);
        if (!strcmp(state, again)) return HDR_OK;
    }
    return hdr_fail(err, HDR_BAD_DATA, "its hdrpipeState is '%s', which this program (%s) does not know", state,
                    HDRPIPE_VERSION);
}

/* All clauses that are filters. */
static hdr_status plan_filters(planning *p, hdr_error *err) {
    const hdr_chain *chain = p->run->chain;
    snprintf(p->state, sizeof p->state, "%s", p->run->source->picture.state);
    p->run->scene_light = !strcmp(p->state, "linear");
    p->run->light_steps = -1;
    hdr_status status = check_state(p->state, err);
    if (!status) status = start_colour(p, err);
    if (wants_facts(chain)) hdr_run_keep(p->run);
    for (int i = hdr_chain_joins(chain); !status && i < chain->count; i++) {
        if (chain->clauses[i].verb->about.kind != HDR_FILTER) break;
        status = plan_clause(p, i + 1, &chain->clauses[i], err);
    }
    return status;
}

/* ---- Formats ---- */

/* The endings of all formats: ".png .exr". */
static void list_endings(char *text, size_t size) {
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; hdr_verb_number(i) && used < size; i++) {
        const hdr_format *format = hdr_verb_number(i)->format;
        if (format) used += (size_t)snprintf(text + used, size - used, "%s%s", used ? " " : "", format->extension);
    }
}

/* The format that is written: the last clause's, or by the ending of the output's name, or EXR. */
static hdr_status choose_format(const hdr_chain *chain, const hdr_output *output, const hdr_verb **verb,
                                hdr_error *err) {
    const hdr_clause *last = chain->count ? &chain->clauses[chain->count - 1] : NULL;
    if (last && last->verb->about.kind == HDR_PROGRAM)
        return hdr_fail(err, HDR_USAGE, "%s writes no picture", last->verb->about.name);
    const char *name = hdr_output_name(output), *ending;
    const hdr_verb *named = hdr_verb_of_file(name, &ending);
    *verb = last && last->verb->format ? last->verb : ending ? named : hdr_verb_find("exr");
    if (*verb && named && named != *verb)
        return hdr_fail(err, HDR_USAGE, "%s: the chain ends in %s, which is no %s", name, (*verb)->about.name, ending);
    if (*verb) return HDR_OK;
    char endings[100];
    list_endings(endings, sizeof endings);
    return hdr_fail(err, HDR_USAGE, "%s: the ending %s is of no format that hdrpipe writes (%s)", name, ending,
                    endings);
}

/* A clause that the format adds to the chain: it counts as the format's own. */
static hdr_status plan_added(planning *p, const char *const words[], int count, hdr_error *err) {
    hdr_chain *added = hdr_chain_new(err);
    hdr_status status = added ? hdr_chain_add_clause(added, words, count, err) : err->status;
    if (!status) status = plan_clause(p, p->run->chain->count, &added->clauses[0], err);
    hdr_chain_free(added);
    return status;
}

/* What a format of codes adds where the chain has neither encoded nor quantised. */
static hdr_status encode_for_codes(planning *p, hdr_error *err) {
    static const char *const srgb[] = {"srgb"};
    return strcmp(p->state, "linear") || p->bits ? HDR_OK : plan_added(p, srgb, 1, err);
}

/* The format rounds to codes as it writes them; only dither takes a clause of its own. */
static hdr_status dither_for_codes(planning *p, const hdr_verb *verb, const void *params, hdr_error *err) {
    const hdr_dither_params *dither = verb->format->dither ? verb->format->dither(params) : NULL;
    if (!dither || dither->kind == HDR_DITHER_NONE) return HDR_OK;
    if (p->bits)
        return hdr_fail(
            err, HDR_USAGE,
            "%s: --dither is for codes that it makes itself, and the chain has quantised: give it to quantise",
            verb->about.name);
    char bits[20], seed[20];
    snprintf(bits, sizeof bits, "%d", verb->format->bits(params, 0));
    snprintf(seed, sizeof seed, "%.0f", dither->seed.value);
    const char *const quantise[] = {"quantise", "--bits", bits, "--dither", hdr_dither_words[dither->kind],
                                    "--seed",   seed};
    bool scene_light = p->run->scene_light;
    hdr_status status = plan_added(p, quantise, 7, err);
    p->run->scene_light = scene_light; /* nobody has said that it is to be cut */
    return status;
}

/* Linear pictures of other primaries, by what the format does about them. */
static hdr_status suit_primaries(planning *p, const hdr_verb *verb, hdr_error *err) {
    bool xyz = !hdr_chromaticities_differ(&p->run->source->picture.chromaticities, &hdr_cie_xyz);
    bool convertible = p->foreign && !strcmp(p->state, "linear");
    switch (verb->format->primaries) {
    case HDR_PRIMARIES_XYZ:
        return xyz || !convertible ? HDR_OK : convert_primaries(p, err);
    case HDR_PRIMARIES_CONVERTED:
        return convertible ? convert_primaries(p, err) : HDR_OK;
    case HDR_PRIMARIES_LOST:
        if (p->foreign)
            hdr_say(p->run->listener, HDR_NOTE, "%s cannot tell the picture's primaries, which are not Rec.709's",
                    verb->about.name);
        break;
    case HDR_PRIMARIES_TOLD:
        break;
    }
    return HDR_OK;
}

/* Encoded values, in a format that cannot say so. */
static void report_state(const planning *p, const hdr_verb *verb) {
    const char *name = verb->about.name;
    if (!strcmp(p->state, "linear")) return;
    if (verb->format->states == HDR_STATES_LOST)
        hdr_say(p->run->listener, HDR_NOTE, "%s cannot tell that the picture is encoded (%s)", name, p->state);
    if (verb->format->states == HDR_STATES_SRGB && strcmp(p->state, "srgb") != 0)
        hdr_say(p->run->listener, HDR_NOTE, "%s cannot tell how the picture is encoded (%s): readers take it for sRGB",
                name, p->state);
}

/* Colours that the file does not have, said once. */
static void report_missing(const hdr_run *run) {
    const hdr_picture *picture = &run->source->picture;
    char names[8] = "";
    int count = 0;
    for (int c = 0; c < picture->planes; c++) {
        if (picture->present[c] || run->spread) continue;
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%c", count++ ? ", " : "", "RGB"[c]);
    }
    if (count)
        hdr_say(run->listener, HDR_NOTE, "%s: no channel%s %s: taken as 0", run->name, count == 1 ? "" : "s", names);
}

/* A picture that stands behind the one that was read, as far as is known without waiting for a pipe. */
static void report_more(const hdr_run *run) {
    if (run->source->end && hdr_input_has(run->input, run->source->end))
        hdr_say(run->listener, HDR_NOTE, "%s: there is more behind the first frame, which alone is read", run->name);
}

/* Light that codes could not hold, without anybody having said that it is meant. */
static void report_cut(const hdr_run *run) {
    if (run->cut > 0)
        hdr_say(
            run->listener, HDR_NOTE,
            "%s: its light reaches %.6g, and what no code can hold is cut: a tone mapping verb (log, reinhard, ...) "
            "would bring it in, and clamp says that it is meant",
            run->name, run->cut);
}

static hdr_status write_picture(planning *p, const hdr_verb *format, hdr_output *output, hdr_error *err) {
    const hdr_chain *chain = p->run->chain;
    const hdr_clause *last = chain->count ? &chain->clauses[chain->count - 1] : NULL;
    void *params = hdr_alloc(1, format->params_size);
    if (!params) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    hdr_options_default(format->about.options, params);
    if (last && last->verb == format) memcpy(params, last->params, format->params_size);
    hdr_status status = format->format->codes ? encode_for_codes(p, err) : suit_primaries(p, format, err);
    if (!status) status = dither_for_codes(p, format, params, err);
    if (!status) report_state(p, format);
    if (!status) status = hdr_run_write(p->run, format, params, output, p->state, p->bits, p->converted, err);
    if (!status && !format->format->alpha && !p->run->raw.opaque)
        hdr_say(p->run->listener, HDR_NOTE, "%s has no alpha: it is left out", format->about.name);
    if (!status)
        hdr_say(p->run->listener, HDR_EXPLAIN, "sweep %d: %d step%s, to %s", p->run->sweeps, p->run->step_count,
                p->run->step_count == 1 ? "" : "s", format->about.name);
    free(params);
    return status;
}

/* ---- The public runs ---- */

/* Drops what the user did not ask for. */
typedef struct filtered {
    const hdr_listener *listener;
    bool explain, verbose;
} filtered;

static void say_filtered(void *context, hdr_message kind, const char *line) {
    const filtered *f = context;
    if ((kind == HDR_EXPLAIN && !f->explain) || (kind == HDR_DETAIL && !f->verbose)) return;
    f->listener->say(f->listener->context, kind, line);
}

/* Puts the input's name in front, unless the message begins with it. */
static hdr_status with_name(hdr_error *err, const hdr_error *own, hdr_input *input) {
    hdr_error prefix = {0};
    hdr_fail(&prefix, own->status, "%s:", hdr_input_name(input)); /* the name as messages have it: printable */
    bool named = !strncmp(own->message, prefix.message, strlen(prefix.message));
    if (named || own->status == HDR_USAGE || own->status == HDR_CANT_CREATE || own->status == HDR_IO)
        return hdr_fail(err, own->status, "%s", own->message);
    return hdr_fail(err, own->status, "%s %s", prefix.message, own->message);
}

/* What the clauses need beside the picture. Before that is opened: whoever waits for a pipe should not wait in vain. */
static hdr_status open_mappers(const hdr_chain *chain, hdr_mapper **mappers, hdr_error *err) {
    for (int i = 0; i < chain->count; i++) {
        const hdr_clause *clause = &chain->clauses[i];
        hdr_error own = {0};
        if (clause->verb->open) mappers[i] = clause->verb->open(clause->params, &own);
        if (own.status)
            return hdr_fail(err, own.status, "clause %d (%s): %s", i + 1, clause->verb->about.name, own.message);
    }
    return HDR_OK;
}

static void close_mappers(hdr_mapper **mappers, int count) {
    for (int i = 0; mappers && i < count; i++)
        if (mappers[i]) mappers[i]->close(mappers[i]);
    free(mappers);
}

/* What is done with a planned chain; NULL: nothing more. */
typedef hdr_status (*finish)(planning *p, void *context, hdr_error *err);

static hdr_status run_chain(hdr_chain *chain, hdr_input *input, const hdr_listener *listener, hdr_look *look,
                            finish end, void *context, hdr_error *err) {
    hdr_error own = {0};
    hdr_chain *whole = hdr_chain_behind_head(chain, input, &own);
    hdr_mapper **mappers = whole ? hdr_alloc((size_t)whole->count, sizeof(hdr_mapper *)) : NULL;
    if (whole && !mappers) hdr_fail(&own, HDR_INTERNAL, "out of memory");
    hdr_status status = own.status ? own.status : open_mappers(whole, mappers, err); /* no fault of the picture */
    if (!status) {
        filtered settings = {listener, chain->common.explain, chain->common.verbose};
        hdr_listener chosen = {say_filtered, &settings};
        hdr_run run;
        status = hdr_run_open(&run, whole, input, listener && listener->say ? &chosen : NULL, &own);
        planning p = {.run = &run, .mappers = mappers};
        run.look = look;
        if (!status) status = plan_filters(&p, &own);
        if (!status && end) status = end(&p, context, &own);
        if (!status) report_missing(&run);
        if (!status) report_more(&run);
        if (!status) report_cut(&run);
        hdr_plane_free(p.luminance);
        hdr_run_close(&run);
    }
    if (whole) close_mappers(mappers, whole->count);
    hdr_chain_free(whole);
    return own.status ? with_name(err, &own, input) : status;
}

static hdr_status finish_writing(planning *p, void *context, hdr_error *err) {
    hdr_output *output = context;
    const hdr_verb *format = NULL;
    hdr_status status = choose_format(p->run->chain, output, &format, err);
    if (!status) status = write_picture(p, format, output, err);
    return status ? status : hdr_output_commit(output, err);
}

hdr_status hdr_chain_run(hdr_chain *chain, hdr_input *input, hdr_output *output, const hdr_listener *listener,
                         hdr_error *err) {
    /* a chain that cannot end so is refused before anything is read */
    const hdr_verb *format = NULL;
    hdr_status status = choose_format(chain, output, &format, err);
    return status ? status : run_chain(chain, input, listener, NULL, finish_writing, output, err);
}

typedef struct user {
    hdr_use use;
    void *context;
} user;

static hdr_status finish_using(planning *p, void *context, hdr_error *err) {
    const user *u = context;
    return u->use(p->run, p->state, p->converted, u->context, err);
}

hdr_status hdr_chain_use(hdr_chain *chain, hdr_input *input, const hdr_listener *listener, hdr_use use, void *context,
                         hdr_error *err) {
    return run_chain(chain, input, listener, NULL, finish_using, &(user){use, context}, err);
}

hdr_status hdr_chain_look(hdr_chain *chain, hdr_input *input, const hdr_listener *listener, hdr_look *look,
                          hdr_error *err) {
    return run_chain(chain, input, listener, look, NULL, NULL, err);
}

hdr_status hdr_input_picture(hdr_input *input, const hdr_chain *chain, hdr_picture *picture, hdr_error *err) {
    hdr_error own = {0};
    hdr_chain *none = hdr_chain_new(&own);
    hdr_chain *whole = none ? hdr_chain_behind_head(chain ? chain : none, input, &own) : NULL;
    hdr_reading reading = whole ? hdr_chain_reading(whole) : (hdr_reading){.memory = 0};
    hdr_source *source = whole ? hdr_source_open(input, &reading, &own) : NULL;
    if (source) *picture = source->picture;
    hdr_source_close(source);
    hdr_chain_free(whole);
    hdr_chain_free(none);
    return own.status ? with_name(err, &own, input) : HDR_OK;
}

hdr_contents *hdr_input_contents(hdr_input *input, hdr_error *err) {
    hdr_error own = {0};
    hdr_chain *none = hdr_chain_new(&own);
    hdr_chain *head = none ? hdr_chain_behind_head(none, input, &own) : NULL;
    hdr_reading reading = head ? hdr_chain_reading(none) : (hdr_reading){.memory = 0};
    hdr_contents *contents = head ? hdr_source_contents(input, &reading, &own) : NULL;
    hdr_chain_free(head);
    hdr_chain_free(none);
    if (own.status) with_name(err, &own, input);
    return contents;
}

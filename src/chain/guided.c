/* Chains that filter by a second picture, in front of all that is planned. */
#include "chain/run.h"

#include "io/input.h"
#include "io/join.h"
#include "io/smooth.h"

#include <stdio.h>

const hdr_clause *hdr_chain_guided(const hdr_chain *chain) {
    int first = hdr_chain_joins(chain);
    return first < chain->count && chain->clauses[first].verb->guide ? &chain->clauses[first] : NULL;
}

hdr_status hdr_guide_open(const hdr_chain *chain, hdr_input **guide, hdr_error *err) {
    const hdr_clause *clause = hdr_chain_guided(chain);
    hdr_guiding guiding = {0};
    hdr_error own = {0};
    if (!clause) return HDR_OK;
    if (!clause->verb->guide(clause->params, &guiding, &own)) *guide = hdr_input_open(guiding.picture, &own);
    if (*guide) return HDR_OK;
    return hdr_fail(err, own.status, "%s: %s", clause->verb->about.name, own.message);
}

hdr_source *hdr_run_guide(hdr_run *run, hdr_source *source, hdr_input *guide, hdr_error *err) {
    const hdr_clause *clause = hdr_chain_guided(run->chain);
    if (!source || !clause) return source;
    hdr_reading reading = hdr_chain_reading(run->chain);
    hdr_guiding guiding = {0};
    if (clause->verb->guide(clause->params, &guiding, err)) {
        hdr_source_close(source);
        return NULL;
    }
    guiding.filter.reference = run->settings.reference;
    guiding.filter.no_skip = run->settings.no_skip;
    run->guided = true;
    hdr_say(run->listener, HDR_EXPLAIN, "clause %d (%s): %s", hdr_chain_joins(run->chain) + 1, clause->verb->about.name,
            guiding.note);
    return hdr_smooth_open(source, run->input, guide, &reading, &guiding.filter, err);
}

bool hdr_run_meaning(const hdr_run *run, char *text, size_t size) {
    const hdr_clause *guided = hdr_chain_guided(run->chain);
    const hdr_verb_about *behind = hdr_chain_clause(run->chain, 1 + (run->joined != NULL) + (guided != NULL));
    hdr_guiding guiding = {0};
    if (!(run->joined || guided) || (behind && behind->kind != HDR_FORMAT)) return false;
    if (guided && guided->verb->guide(guided->params, &guiding, NULL)) return false;
    snprintf(text, size, "%s%s%s%s", run->joined ? hdr_join_meaning(run->joined) : "",
             run->joined && guided ? ", " : "", guided ? "smoothed: " : "", guiding.note);
    return true;
}

hdr_status hdr_run_report_guided(const hdr_run *run, hdr_error *err) {
    if (!run->guided) return HDR_OK;
    hdr_smoothed counts = hdr_smooth_counts(run->source);
    const char *name = hdr_chain_guided(run->chain)->verb->about.name;
    hdr_say(run->listener, HDR_EXPLAIN,
            "%s: %llu of %llu pixels (%.1f %%) are left alone, as their noise is 0 or too low", name,
            (unsigned long long)counts.left_alone, (unsigned long long)counts.pixels,
            counts.pixels ? 100 * (double)counts.left_alone / (double)counts.pixels : 0);
    if (!counts.unusable) return HDR_OK;
    if (run->settings.strict)
        return hdr_fail(err, HDR_BAD_DATA, "%s: %llu standard deviations are NaN or infinite", name,
                        (unsigned long long)counts.unusable);
    hdr_say(run->listener, HDR_NOTE, "%s: standard deviations that are NaN or infinite (now 0): %llu", name,
            (unsigned long long)counts.unusable);
    return HDR_OK;
}

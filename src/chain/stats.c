/* Facts as the public header shows them: of one picture, and of several together. */
#include "chain/run.h"

#include "picture/colour.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct percent {
    double value;
    hdr_decimal decimal;
} percents[HDR_PERCENTILES] = {{0.1, {1, 1}}, {1, {1, 0}},   {5, {5, 0}},   {25, {25, 0}},   {50, {50, 0}},
                               {75, {75, 0}}, {95, {95, 0}}, {99, {99, 0}}, {99.9, {999, 1}}};

static hdr_request stats_request(void) {
    hdr_request request = {.facts = HDR_FACT_COMPONENTS | HDR_FACT_LUMINANCE | HDR_FACT_CHANNELS,
                           .percentiles = HDR_PERCENTILES};
    for (int i = 0; i < HDR_PERCENTILES; i++) {
        request.percentile[i].of = HDR_OF_LIT;
        request.percentile[i].percent = percents[i].decimal;
    }
    return request;
}

/* What is no matter of a picture's form: the same of one and of several. */
static void fill_numbers(hdr_stats *stats, const hdr_facts *facts) {
    stats->pixels = facts->pixels;
    stats->lit = facts->lit;
    stats->negative = facts->negative;
    stats->unlit_colour = facts->unlit_colour;
    stats->min_luminance = facts->min_luminance;
    stats->max_luminance = facts->max_luminance;
    stats->min_lit = facts->min_lit;
    stats->log_average = facts->log_average;
    stats->grey = facts->coloured == 0;
    memcpy(stats->percentile, facts->percentile, sizeof stats->percentile);
    for (int i = 0; i < HDR_PERCENTILES; i++)
        stats->percentile_percent[i] = percents[i].value;
}

static void fill_picture(hdr_stats *stats, const hdr_run *run, const char *state, bool converted) {
    stats->picture = run->source->picture;
    if (converted) {
        stats->picture.chromaticities = hdr_rec709;
        stats->picture.has_chromaticities = stats->picture.has_neutral = false;
    }
    stats->picture.present[3] = stats->picture.has_alpha;
    if (run->spread) stats->picture.present[1] = stats->picture.present[2] = true;
    snprintf(stats->picture.state, sizeof stats->picture.state, "%s", state);
}

static void fill_repairs(hdr_stats *stats, const hdr_raw *raw) {
    stats->nan = raw->nan;
    stats->positive_infinity = raw->positive_infinity;
    stats->negative_infinity = raw->negative_infinity;
    stats->opaque = raw->opaque;
}

/* ---- Of one picture ---- */

typedef struct wanted {
    hdr_stats *stats;
    hdr_taking *together; /* or NULL */
} wanted;

static hdr_status use_for_stats(hdr_run *run, const char *state, bool converted, void *context, hdr_error *err) {
    const wanted *w = context;
    hdr_request request = stats_request();
    hdr_facts facts;
    hdr_status status = hdr_run_facts(run, &request, w->together, NULL, &facts, err);
    if (status) return status;
    fill_numbers(w->stats, &facts);
    fill_picture(w->stats, run, state, converted);
    fill_repairs(w->stats, &run->raw);
    memcpy(w->stats->min, facts.channel_min, sizeof w->stats->min);
    memcpy(w->stats->max, facts.channel_max, sizeof w->stats->max);
    return HDR_OK;
}

static hdr_status check_end(const hdr_chain *chain, hdr_error *err) {
    const hdr_verb_about *last = hdr_chain_last(chain);
    if (last && last->kind == HDR_FORMAT)
        return hdr_fail(err, HDR_USAGE, "no facts are taken of a file that is written");
    return HDR_OK;
}

static hdr_status take_stats(hdr_chain *chain, hdr_input *input, hdr_taking *together, hdr_stats *stats,
                             const hdr_listener *listener, hdr_error *err) {
    hdr_status status = check_end(chain, err);
    *stats = (hdr_stats){0};
    return status ? status : hdr_chain_use(chain, input, listener, use_for_stats, &(wanted){stats, together}, err);
}

hdr_status hdr_chain_stats(hdr_chain *chain, hdr_input *input, hdr_stats *stats, const hdr_listener *listener,
                           hdr_error *err) {
    return take_stats(chain, input, NULL, stats, listener, err);
}

/* ---- Of several together ---- */

struct hdr_survey {
    hdr_chain *chain;
    hdr_taking *taking;
    hdr_stats together; /* what the taking does not find */
    int round;
    bool failed;
};

hdr_survey *hdr_survey_new(hdr_chain *chain, hdr_error *err) {
    hdr_request request = stats_request();
    hdr_survey *survey = hdr_alloc(1, sizeof *survey);
    if (!survey) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        return NULL;
    }
    survey->chain = chain;
    survey->together.opaque = true;
    survey->taking = hdr_taking_new(&request, hdr_chain_settings(chain)->threads, false, err);
    if (survey->taking) return survey;
    hdr_survey_free(survey);
    return NULL;
}

void hdr_survey_free(hdr_survey *survey) {
    if (!survey) return;
    hdr_taking_free(survey->taking);
    free(survey);
}

static void add_repairs(hdr_stats *together, const hdr_stats *stats) {
    together->nan += stats->nan;
    together->positive_infinity += stats->positive_infinity;
    together->negative_infinity += stats->negative_infinity;
    together->opaque &= stats->opaque;
}

static hdr_status use_for_survey(hdr_run *run, const char *state, bool converted, void *context, hdr_error *err) {
    (void)state;
    (void)converted;
    const hdr_survey *survey = context;
    return hdr_run_take(run, survey->taking, err);
}

/* What a later round has to say: no notes, since they were said in the first. */
static void say_no_notes(void *context, hdr_message kind, const char *line) {
    const hdr_listener *listener = context;
    if (kind != HDR_NOTE) listener->say(listener->context, kind, line);
}

hdr_status hdr_survey_take(hdr_survey *survey, hdr_input *input, hdr_stats *stats, const hdr_listener *listener,
                           hdr_error *err) {
    hdr_stats own;
    hdr_status status;
    if (survey->round == 0) {
        status = take_stats(survey->chain, input, survey->taking, stats ? stats : &own, listener, err);
        if (!status) add_repairs(&survey->together, stats ? stats : &own);
    } else {
        hdr_listener later = {say_no_notes, (void *)listener}; /* which is only read */
        status =
            hdr_chain_use(survey->chain, input, listener && listener->say ? &later : NULL, use_for_survey, survey, err);
    }
    survey->failed |= status != HDR_OK;
    return status;
}

bool hdr_survey_next(hdr_survey *survey, hdr_stats *together, hdr_error *err) {
    hdr_facts facts;
    if (survey->failed) {
        hdr_fail(err, HDR_BAD_DATA, "there are no facts of all pictures together, since those of some are missing");
        return false;
    }
    survey->round++;
    if (hdr_taking_next(survey->taking, &facts)) return true;
    if (hdr_taking_contradicted(survey->taking)) {
        hdr_fail(err, HDR_BAD_DATA, "the pictures have changed while their facts were taken");
        return false;
    }
    *together = survey->together;
    fill_numbers(together, &facts);
    return false;
}

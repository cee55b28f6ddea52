/* hdr noise: how noisy independent renders are. */
#include "cmd.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* How many renders have a mean whose RMSE is the target; 0: none is asked for. */
static double renders_for(const hdr_noise *noise, double target) {
    double ratio = target > 0 ? noise->rmv / target : 0;
    return ceil(ratio * ratio);
}

/* ---- For people ---- */

static void print_error(double error) {
    if (error >= 0) printf(" +- %.3g", error);
    putchar('\n');
}

static void print_text(const hdr_noise *noise, double target) {
    double root = sqrt(noise->renders);
    printf("%d renders, %d x %d pixels, %llu components", noise->renders,
           noise->picture.data.max_x - noise->picture.data.min_x + 1,
           noise->picture.data.max_y - noise->picture.data.min_y + 1, (unsigned long long)noise->numbers);
    if (noise->left_out > 0) printf(", %llu left out (NaN or infinite)", (unsigned long long)noise->left_out);
    printf("\n  rmv of one render   %.9g", noise->rmv);
    print_error(noise->error);
    printf("  rmv of their mean   %.9g", noise->rmv / root);
    print_error(noise->error / root);
    printf("  relative (E %g)   %.9g", noise->epsilon, noise->relative);
    print_error(noise->relative_error);
    printf("\n  %-10s %-14s %-12s %-14s %s\n", "mean of", "rmv", "+-", "independent", "ratio");
    for (int l = 0; l < noise->levels; l++) {
        double expected = noise->rmv / sqrt(noise->level[l].size);
        printf("  %-10d %-14.9g ", noise->level[l].size, noise->level[l].rmv);
        if (noise->level[l].error >= 0)
            printf("%-12.3g ", noise->level[l].error);
        else
            printf("%-12s ", "");
        printf("%-14.9g ", expected);
        if (expected > 0)
            printf("%.4g\n", noise->level[l].rmv / expected);
        else
            printf("-\n");
    }
    if (noise->rmv == 0) printf("\n  all renders are the same: they may have had the same seed\n");
    if (target <= 0) return;
    double needed = renders_for(noise, target), more = needed - noise->renders;
    printf("\n  for an RMSE of %g: %.0f renders, %.0f more\n", target, needed, more > 0 ? more : 0);
}

/* ---- For programs ---- */

static void print_json(const hdr_noise *noise, double target) {
    cmd_json_open(NULL, '{');
    cmd_json_integer("renders", noise->renders);
    cmd_json_integer("numbers", (long long)noise->numbers);
    cmd_json_integer("left_out", (long long)noise->left_out);
    cmd_json_number("rmv", noise->rmv);
    cmd_json_known("rmv_error", noise->error);
    cmd_json_number("epsilon", noise->epsilon);
    cmd_json_number("relative", noise->relative);
    cmd_json_known("relative_error", noise->relative_error);
    cmd_json_open("convergence", '[');
    for (int l = 0; l < noise->levels; l++) {
        cmd_json_open(NULL, '{');
        cmd_json_integer("mean_of", noise->level[l].size);
        cmd_json_number("rmv", noise->level[l].rmv);
        cmd_json_known("rmv_error", noise->level[l].error);
        cmd_json_close('}');
    }
    cmd_json_close(']');
    if (target > 0) {
        cmd_json_number("target", target);
        cmd_json_number("renders_for_target", renders_for(noise, target));
    }
    cmd_json_end();
}

/* ---- hdr noise ---- */

static hdr_status write_shares(const hdr_chain *chain, const hdr_noise *noise, hdr_output *output, hdr_error *error) {
    const hdr_window *data = &noise->picture.data;
    return cmd_write_plane(chain, data->max_x - data->min_x + 1, data->max_y - data->min_y + 1, noise->share, output,
                           error);
}

/* What the verb mean makes of the same files. */
static hdr_status write_deviation(const hdr_chain *chain, const cmd_inputs *opened, hdr_output *output,
                                  hdr_error *error) {
    static const char *const words[] = {"mean", "--show", "deviation"};
    hdr_listener listener = cmd_listener(chain);
    hdr_chain *mean = hdr_chain_new_like(chain, error);
    hdr_input *joined = hdr_input_join(opened->count, opened->inputs, error);
    hdr_status status = mean && joined ? hdr_chain_add(mean, words, 3, error) : error->status;
    if (status == HDR_OK) status = hdr_chain_run(mean, joined, output, &listener, error);
    hdr_input_free(joined);
    hdr_chain_free(mean);
    return status;
}

/* A file that an option names; NULL: the option is not given, or the error is filled. */
static hdr_output *open_named(const hdr_chain *chain, const char *option, hdr_error *error) {
    const char *name = hdr_chain_given(chain, 1, option);
    return name ? hdr_output_open(name, error) : NULL;
}

hdr_status cmd_noise(hdr_chain *chain, hdr_error *error) {
    if (hdr_chain_clause(chain, 2)) return cmd_refuse(error, "noise reads files: write what a chain makes first");
    double target = cmd_number(chain, 1, "target", 0);
    hdr_output *map = open_named(chain, "sampling-map", error), *plot = open_named(chain, "plot", error);
    hdr_output *deviation = open_named(chain, "deviation-map", error);
    cmd_inputs opened = {.count = 0};
    if (error->status == HDR_OK) opened = cmd_open_files(chain, error);
    hdr_noise noise = {.renders = 0};
    hdr_status status = opened.count > 0 ? hdr_measure_noise(chain, opened.count, opened.inputs,
                                                             cmd_number(chain, 1, "epsilon", 0), map, &noise, error)
                                         : error->status;
    if (status == HDR_OK && map) status = write_shares(chain, &noise, map, error);
    if (status == HDR_OK && deviation) status = write_deviation(chain, &opened, deviation, error);
    if (status == HDR_OK && plot) status = cmd_plot_noise(&noise, plot, error);
    if (status == HDR_OK && hdr_chain_settings(chain)->json)
        print_json(&noise, target);
    else if (status == HDR_OK)
        print_text(&noise, target);
    hdr_noise_free(&noise);
    cmd_close_files(&opened);
    hdr_output_free(map);
    hdr_output_free(deviation);
    hdr_output_free(plot);
    return status;
}

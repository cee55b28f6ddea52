/* hdr noise: the noise of the means of 1, 2, 4, ... renders, drawn as SVG. */
#include "plot.h"

#include <math.h>

static const char colour[] = "#0072b2", expected_style[] = "stroke=\"#909090\" stroke-width=\"1.5\"";

typedef struct plot {
    const hdr_noise *noise;
    FILE *to;
    plot_axis renders, rmv;
} plot;

/* Where a standard error's bar ends below: a tenth of the figure at least, so that it can be drawn. */
static double low_end(double rmv, double error) {
    return fmax(rmv - error, rmv / 10);
}

/* What independent renders would give. */
static double expected(const hdr_noise *noise, int size) {
    return noise->rmv / sqrt(size);
}

/* Some room around the marks; least: what lies between those farthest apart, at least. */
static void add_air(plot_axis *axis, double least) {
    double span = fmax(axis->high - axis->low, least), middle = (axis->high + axis->low) / 2;
    *axis = (plot_axis){middle - 0.56 * span, middle + 0.56 * span};
}

static void choose_axes(plot *p) {
    const hdr_noise *noise = p->noise;
    p->renders = p->rmv = (plot_axis)PLOT_AXIS_EMPTY;
    plot_widen(&p->renders, 2);
    for (int l = 0; l < noise->levels; l++) {
        double rmv = noise->level[l].rmv, error = fmax(noise->level[l].error, 0);
        plot_widen(&p->renders, noise->level[l].size);
        if (!(rmv > 0)) continue;
        plot_widen(&p->rmv, expected(noise, noise->level[l].size));
        plot_widen(&p->rmv, low_end(rmv, error));
        plot_widen(&p->rmv, rmv + error);
    }
    if (p->rmv.low > p->rmv.high) p->rmv = (plot_axis){-1, 0};
    add_air(&p->renders, 0);
    add_air(&p->rmv, 0.8);
}

static void print_titles(const plot *p) {
    const hdr_noise *noise = p->noise;
    const hdr_window *data = &noise->picture.data;
    bool zeros = false;
    for (int l = 0; l < noise->levels; l++)
        zeros |= !(noise->level[l].rmv > 0);
    fprintf(p->to,
            "<text x=\"%d\" y=\"30\" font-size=\"18\" font-weight=\"bold\">%d renders, %d &#215; %d: noise of their "
            "means</text>\n",
            PLOT_LEFT, noise->renders, data->max_x - data->min_x + 1, data->max_y - data->min_y + 1);
    fprintf(p->to, "<text x=\"%d\" y=\"52\">rmv of one render %.4g", PLOT_LEFT, noise->rmv);
    if (noise->error >= 0) fprintf(p->to, " &#177; %.2g", noise->error);
    fprintf(p->to, "%s</text>\n", zeros ? "; figures of 0 are not drawn" : "");
    fprintf(p->to, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">renders that a mean is taken of</text>\n",
            (PLOT_LEFT + PLOT_RIGHT) / 2, PLOT_BOTTOM + 46);
    fprintf(p->to,
            "<text transform=\"translate(24 %d) rotate(-90)\" text-anchor=\"middle\">root mean variance (rmv)</text>\n",
            (PLOT_TOP + PLOT_BOTTOM) / 2);
}

static void print_expected(const plot *p) {
    const hdr_noise *noise = p->noise;
    int most = noise->level[noise->levels - 1].size;
    if (!(noise->rmv > 0)) return;
    plot_line(p->to, plot_x(&p->renders, 1), plot_y(&p->rmv, noise->rmv), plot_x(&p->renders, most),
              plot_y(&p->rmv, expected(noise, most)), expected_style);
}

static void print_levels(const plot *p) {
    for (int l = 0; l < p->noise->levels; l++) {
        double rmv = p->noise->level[l].rmv, error = p->noise->level[l].error;
        double x = plot_x(&p->renders, p->noise->level[l].size), y = plot_y(&p->rmv, rmv);
        if (!(rmv > 0)) continue;
        if (error >= 0) {
            plot_bar(p->to, x, y, plot_y(&p->rmv, rmv + error), colour);
            plot_bar(p->to, x, y, plot_y(&p->rmv, low_end(rmv, error)), colour);
        }
        plot_mark(p->to, x, y, colour, false);
    }
}

static void print_key(const plot *p) {
    double x = PLOT_LEFT + 8, y = PLOT_HEIGHT - 20;
    plot_mark(p->to, x, y, colour, false);
    x = plot_key(p->to, x + 12, y, "rmv of means of so many");
    plot_bar(p->to, x, y, y - 7, colour);
    plot_bar(p->to, x, y, y + 7, colour);
    x = plot_key(p->to, x + 12, y, "its standard error");
    plot_line(p->to, x - 6, y, x + 14, y, expected_style);
    plot_key(p->to, x + 22, y, "independent renders: rmv of one / root of their number");
}

hdr_status cmd_plot_noise(const hdr_noise *noise, hdr_output *output, hdr_error *error) {
    plot_sheet sheet;
    if (!plot_begin(&sheet)) return cmd_out_of_memory(error);
    plot p = {.noise = noise, .to = sheet.to};
    choose_axes(&p);
    print_titles(&p);
    plot_x_axis(p.to, &p.renders, PLOT_BOTTOM);
    plot_y_axis(p.to, &p.rmv, false);
    plot_frame(p.to, PLOT_TOP, PLOT_BOTTOM);
    print_expected(&p);
    print_levels(&p);
    print_key(&p);
    return plot_end(&sheet, output, error);
}

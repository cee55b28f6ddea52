/* Plots with logarithmic axes, as SVG: what those of several programs share. The same numbers give the same bytes. */
#ifndef HDR_PLOT_H
#define HDR_PLOT_H

#include "cmd.h"

/* The picture, and the frame of the axes in it. Pixels. */
enum {
    PLOT_WIDTH = 900,
    PLOT_HEIGHT = 600,
    PLOT_LEFT = 92,
    PLOT_RIGHT = 876,
    PLOT_TOP = 92,
    PLOT_BOTTOM = 466,
    PLOT_FONT = 13,
    PLOT_RADIUS = 5 /* of a mark */
};

/* A drawing under way, in memory. */
typedef struct plot_sheet {
    FILE *to;
    char *text;
    size_t size;
} plot_sheet;
bool plot_begin(plot_sheet *sheet); /* false: out of memory */
hdr_status plot_end(plot_sheet *sheet, hdr_output *output, hdr_error *error);

/* An axis: `low` and `high` are logarithms to the base 10. */
typedef struct plot_axis {
    double low, high;
} plot_axis;
#define PLOT_AXIS_EMPTY                                                                                                \
    { INFINITY, -INFINITY }
void plot_widen(plot_axis *axis, double value);
double plot_x(const plot_axis *axis, double value);
double plot_y(const plot_axis *axis, double value);

/* Ticks, grid and numbers. foot: of the frame. powers: 10^e at each decade, and no other numbers. */
void plot_x_axis(FILE *to, const plot_axis *axis, double foot);
void plot_y_axis(FILE *to, const plot_axis *axis, bool powers);
void plot_frame(FILE *to, int top, int bottom);

/* As it may stand in XML: markup is escaped, and what XML has no place for becomes '?'. */
void plot_text(FILE *to, const char *text);

void plot_line(FILE *to, double x1, double y1, double x2, double y2, const char *style);
void plot_mark(FILE *to, double x, double y, const char *colour, bool hollow);

/* A bar from there to there with a foot at its end. */
void plot_bar(FILE *to, double x, double from, double end, const char *colour);

/* What a sign that stands in front of it means. Returns where the next one may begin. */
double plot_key(FILE *to, double x, double y, const char *text);

#endif

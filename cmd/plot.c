#include "plot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- The sheet ---- */

bool plot_begin(plot_sheet *sheet) {
    *sheet = (plot_sheet){.to = NULL};
    sheet->to = open_memstream(&sheet->text, &sheet->size);
    if (!sheet->to) return false;
    fprintf(sheet->to,
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" "
            "height=\"%d\" viewBox=\"0 0 %d %d\" font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\" "
            "font-size=\"%d\">\n<rect width=\"%d\" height=\"%d\" fill=\"#ffffff\"/>\n",
            PLOT_WIDTH, PLOT_HEIGHT, PLOT_WIDTH, PLOT_HEIGHT, PLOT_FONT, PLOT_WIDTH, PLOT_HEIGHT);
    return true;
}

hdr_status plot_end(plot_sheet *sheet, hdr_output *output, hdr_error *error) {
    fprintf(sheet->to, "</svg>\n");
    bool whole = ferror(sheet->to) == 0;
    if (fclose(sheet->to) != 0) whole = false;
    hdr_status status = whole ? hdr_output_fill(output, sheet->text, sheet->size, error) : cmd_out_of_memory(error);
    free(sheet->text);
    return status;
}

/* ---- Text ---- */

void plot_text(FILE *to, const char *text) {
    char *plain = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&plain, &size);
    if (!memory) return;
    cmd_print_plain(memory, text);
    fclose(memory);
    for (const char *c = plain; c && *c; c++) {
        bool no_character = strncmp(c, "\xef\xbf\xbe", 3) == 0 || strncmp(c, "\xef\xbf\xbf", 3) == 0;
        if (no_character) c += 2;
        if (no_character)
            putc('?', to);
        else if (strchr("&<>\"'", *c))
            fprintf(to, "&#%d;", *c);
        else
            putc(*c, to);
    }
    free(plain);
}

/* ---- Axes ---- */

void plot_widen(plot_axis *axis, double value) {
    axis->low = fmin(axis->low, log10(value));
    axis->high = fmax(axis->high, log10(value));
}

double plot_x(const plot_axis *axis, double value) {
    return PLOT_LEFT + (log10(value) - axis->low) / (axis->high - axis->low) * (PLOT_RIGHT - PLOT_LEFT);
}

double plot_y(const plot_axis *axis, double value) {
    return PLOT_BOTTOM - (log10(value) - axis->low) / (axis->high - axis->low) * (PLOT_BOTTOM - PLOT_TOP);
}

/* 10^exponent, right-aligned at x. */
static void print_power(FILE *to, double x, double y, int exponent) {
    char text[20];
    snprintf(text, sizeof text, "%d", exponent);
    double narrow = (double)strlen(text) * 6;
    fprintf(to, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">10</text>\n", x - narrow, y);
    fprintf(to, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\" font-size=\"10\">%s%s</text>\n", x, y - 6,
            exponent < 0 ? "&#8722;" : "", text + (exponent < 0));
}

static void print_grid(FILE *to, double x1, double y1, double x2, double y2, bool strong) {
    plot_line(to, x1, y1, x2, y2, strong ? "stroke=\"#d4d4d4\"" : "stroke=\"#f0f0f0\"");
}

typedef struct tick {
    int exponent, digit; /* digit * 10^exponent; in front of the first one the digit is 0 */
    double at;           /* its logarithm */
} tick;

static tick before_ticks(const plot_axis *axis) {
    return (tick){.exponent = (int)floor(axis->low)};
}

static bool next_tick(const plot_axis *axis, tick *t) {
    do {
        t->exponent += t->digit / 9;
        t->digit = t->digit % 9 + 1;
        t->at = t->exponent + log10(t->digit);
    } while (t->at < axis->low);
    return t->at <= axis->high;
}

/* At decades and, where there are few, at 2 and 5 times them, too. */
static void print_number(FILE *to, const plot_axis *axis, const tick *t, double x, double y, const char *anchor) {
    bool few = axis->high - axis->low < 2.5;
    if (t->digit == 1 || (few && (t->digit == 2 || t->digit == 5)))
        fprintf(to, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">%.10g</text>\n", x, y, anchor,
                t->digit * pow(10, t->exponent));
}

void plot_x_axis(FILE *to, const plot_axis *axis, double foot) {
    for (tick t = before_ticks(axis); next_tick(axis, &t);) {
        double x = plot_x(axis, pow(10, t.at));
        print_grid(to, x, PLOT_TOP, x, foot, t.digit == 1);
        plot_line(to, x, foot, x, foot + (t.digit == 1 ? 6 : 4), "stroke=\"#404040\"");
        print_number(to, axis, &t, x, foot + 22, "middle");
    }
}

void plot_y_axis(FILE *to, const plot_axis *axis, bool powers) {
    for (tick t = before_ticks(axis); next_tick(axis, &t);) {
        double y = plot_y(axis, pow(10, t.at));
        if (t.digit == 1) print_grid(to, PLOT_LEFT, y, PLOT_RIGHT, y, true);
        plot_line(to, PLOT_LEFT - (t.digit == 1 ? 6 : 3), y, PLOT_LEFT, y, "stroke=\"#404040\"");
        if (!powers)
            print_number(to, axis, &t, PLOT_LEFT - 10, y + 4.5, "end");
        else if (t.digit == 1)
            print_power(to, PLOT_LEFT - 10, y + 4.5, t.exponent);
    }
}

void plot_frame(FILE *to, int top, int bottom) {
    fprintf(to, "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" fill=\"none\" stroke=\"#404040\"/>\n", PLOT_LEFT,
            top, PLOT_RIGHT - PLOT_LEFT, bottom - top);
}

/* ---- Signs ---- */

void plot_line(FILE *to, double x1, double y1, double x2, double y2, const char *style) {
    fprintf(to, "<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" %s/>\n", x1, y1, x2, y2, style);
}

void plot_mark(FILE *to, double x, double y, const char *colour, bool hollow) {
    fprintf(to, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%d\" fill=\"%s\" stroke=\"%s\" stroke-width=\"2\"/>\n", x, y,
            PLOT_RADIUS - 1, hollow ? "#ffffff" : colour, colour);
}

void plot_bar(FILE *to, double x, double from, double end, const char *colour) {
    char style[80];
    snprintf(style, sizeof style, "stroke=\"%s\" stroke-opacity=\"0.45\"", colour);
    plot_line(to, x, from, x, end, style);
    plot_line(to, x - 4, end, x + 4, end, style);
}

double plot_key(FILE *to, double x, double y, const char *text) {
    fprintf(to, "<text x=\"%.1f\" y=\"%.1f\" fill=\"#404040\">%s</text>\n", x, y + 4.5, text);
    return x + (double)strlen(text) * 6.6 + 26;
}

/* The legend of false colours. Its unit is a pixel of the letters, larger in larger pictures. */
#include "kernel/real.h"
#include "picture/palette.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* In units, from above: a gap, the bar, its ticks, the letters, and a gap as the first. */
enum { GAP = 4, BAR = 12, TICK = 3, GLYPH_HEIGHT = 7, HEIGHT = GAP + BAR + TICK + 1 + GLYPH_HEIGHT + GAP };
enum { GLYPH_WIDTH = 5, ADVANCE = GLYPH_WIDTH + 1, MARGIN = 8, LARGEST_UNIT = 8 };
enum { MOST_LABELS = 24, MOST_FURTHER_DIGITS = 9 };
enum { BEHIND = 0x000000, INK = 0xe0e0e0 };

/* The letters of numbers, seven rows of five bits from above. */
static const struct {
    char letter;
    unsigned char row[GLYPH_HEIGHT];
} glyphs[] = {
    {'0', {0x0e, 0x11, 0x13, 0x15, 0x19, 0x11, 0x0e}}, {'1', {0x04, 0x0c, 0x04, 0x04, 0x04, 0x04, 0x0e}},
    {'2', {0x0e, 0x11, 0x01, 0x02, 0x04, 0x08, 0x1f}}, {'3', {0x1f, 0x02, 0x04, 0x02, 0x01, 0x11, 0x0e}},
    {'4', {0x02, 0x06, 0x0a, 0x12, 0x1f, 0x02, 0x02}}, {'5', {0x1f, 0x10, 0x1e, 0x01, 0x01, 0x11, 0x0e}},
    {'6', {0x06, 0x08, 0x10, 0x1e, 0x11, 0x11, 0x0e}}, {'7', {0x1f, 0x01, 0x02, 0x04, 0x08, 0x08, 0x08}},
    {'8', {0x0e, 0x11, 0x11, 0x0e, 0x11, 0x11, 0x0e}}, {'9', {0x0e, 0x11, 0x11, 0x0f, 0x01, 0x02, 0x0c}},
    {'.', {0x00, 0x00, 0x00, 0x00, 0x00, 0x0c, 0x0c}}, {'-', {0x00, 0x00, 0x00, 0x1f, 0x00, 0x00, 0x00}},
    {'+', {0x00, 0x04, 0x04, 0x1f, 0x04, 0x04, 0x00}}, {'e', {0x00, 0x00, 0x0e, 0x11, 0x1f, 0x10, 0x0e}},
};

static int unit_of(int width, int height) {
    int side = width / 2 < height ? width / 2 : height, unit = side / 240;
    return unit < 1 ? 1 : unit > LARGEST_UNIT ? LARGEST_UNIT : unit;
}

int hdr_legend_height(int width, int height) {
    return HEIGHT * unit_of(width, height);
}

static void fill(hdr_drawing *d, int x, int y, int width, int height, uint32_t colour) {
    for (int row = y; row < y + height; row++)
        for (int column = x < 0 ? 0 : x; column < x + width && column < d->width; column++)
            d->pixels[(size_t)row * (size_t)d->width + (size_t)column] = colour;
}

static void draw_letter(hdr_drawing *d, char letter, int x, int y, int unit) {
    for (size_t g = 0; g < sizeof glyphs / sizeof *glyphs; g++)
        for (int bit = 0; glyphs[g].letter == letter && bit < GLYPH_WIDTH * GLYPH_HEIGHT; bit++)
            if (glyphs[g].row[bit / GLYPH_WIDTH] >> (GLYPH_WIDTH - 1 - bit % GLYPH_WIDTH) & 1)
                fill(d, x + bit % GLYPH_WIDTH * unit, y + bit / GLYPH_WIDTH * unit, unit, unit, INK);
}

/* ---- Numbers ---- */

typedef struct labels {
    int count;
    struct label {
        int tick, left, right; /* its pixel on the bar, and the room of its letters */
        char text[24];
    } label[MOST_LABELS];
} labels;

/* Where a bar lies, in pixels. */
typedef struct bar {
    int left, width, unit;
} bar;

static int place_on(const bar *bar, const hdr_legend *legend, double value) {
    double part = legend->logarithmic ? hdr_log(value / legend->from) / hdr_log(legend->to / legend->from)
                                      : (value - legend->from) / (legend->to - legend->from);
    return bar->left + (int)(part * (bar->width - 1) + 0.5);
}

/* Adds a number, unless it would come too close to one that is there. */
static void add_label(labels *l, const bar *bar, const hdr_legend *legend, double value, int digits,
                      int picture_width) {
    struct label label = {.tick = place_on(bar, legend, value)};
    if (l->count == MOST_LABELS) return;
    snprintf(label.text, sizeof label.text, "%.*g", digits, value == 0 ? 0 : value); /* no -0 */
    char *comma = strchr(label.text, ',');                                           /* of a host program's locale */
    if (comma) *comma = '.';
    int width = (int)strlen(label.text) * ADVANCE * bar->unit;
    label.left = label.tick - width / 2;
    if (label.left + width > picture_width) label.left = picture_width - width;
    if (label.left < 0) label.left = 0;
    label.right = label.left + width;
    if (label.right > picture_width) return;
    for (int i = 0; i < l->count; i++)
        if (label.left < l->label[i].right + ADVANCE * bar->unit &&
            l->label[i].left < label.right + ADVANCE * bar->unit)
            return;
    l->label[l->count++] = label;
}

static double power_of_ten(int exponent) {
    char text[16];
    snprintf(text, sizeof text, "1e%d", exponent);
    return strtod(text, NULL);
}

/* The smallest of 1, 2, 5, 10, 20, ... that is no less. */
static double round_up(double step) {
    double power = power_of_ten((int)floor(hdr_log10(step)));
    return step <= power ? power : step <= 2 * power ? 2 * power : step <= 5 * power ? 5 * power : 10 * power;
}

/* How many more digits tell apart numbers that lie close to each other and far from 0. */
static int further_digits(const hdr_legend *legend) {
    double low = fabs(legend->from), high = fabs(legend->to), width = legend->to - legend->from;
    int digits = (int)floor(hdr_log10((low > high ? low : high) / width));
    return digits < 0 ? 0 : digits > MOST_FURTHER_DIGITS ? MOST_FURTHER_DIGITS : digits;
}

/* Both ends, then round numbers between them, as many as there is room for. Of ratios, powers of ten. */
static void choose_labels(labels *l, const bar *bar, const hdr_legend *legend, int picture_width) {
    int room = bar->width / (10 * ADVANCE * bar->unit); /* numbers of ten letters */
    int most = room < 2 ? 2 : room < MOST_LABELS ? room : MOST_LABELS;
    int further = further_digits(legend);
    add_label(l, bar, legend, legend->from, 4 + further, picture_width);
    add_label(l, bar, legend, legend->to, 4 + further, picture_width);
    if (legend->logarithmic) {
        int first = (int)ceil(hdr_log10(legend->from)), last = (int)floor(hdr_log10(legend->to));
        for (int power = first; power <= last; power += (last - first) / most + 1)
            add_label(l, bar, legend, power_of_ten(power), 3, picture_width);
    } else {
        double step = round_up((legend->to - legend->from) / most), first = ceil(legend->from / step);
        for (int i = 0; i <= most && (first + i) * step <= legend->to; i++)
            add_label(l, bar, legend, (first + i) * step, 6 + further, picture_width);
    }
}

/* ---- The whole ---- */

hdr_status hdr_legend_draw(const hdr_legend *legend, int width, int height, hdr_drawing *drawing, hdr_error *err) {
    int unit = unit_of(width, height), margin = width / 8 < MARGIN * unit ? width / 8 : MARGIN * unit;
    bar bar = {margin, width - 2 * margin, unit};
    *drawing = (hdr_drawing){width, hdr_legend_height(width, height), NULL};
    drawing->pixels = hdr_alloc((size_t)width, (size_t)drawing->height * sizeof *drawing->pixels);
    if (!drawing->pixels) return hdr_fail(err, HDR_INTERNAL, "out of memory: a legend of %d pixels' width", width);
    fill(drawing, 0, 0, width, drawing->height, BEHIND);
    for (int x = 0; x < bar.width; x++)
        fill(drawing, bar.left + x, GAP * unit, 1, BAR * unit,
             legend->palette[(int64_t)x * HDR_PALETTE_SIZE / bar.width]);
    labels l = {.count = 0};
    choose_labels(&l, &bar, legend, width);
    for (int i = 0; i < l.count; i++) {
        const struct label *label = &l.label[i];
        fill(drawing, label->tick - unit / 2, (GAP + BAR) * unit, unit, TICK * unit, INK);
        for (int k = 0; label->text[k]; k++)
            draw_letter(drawing, label->text[k], label->left + k * ADVANCE * unit, (GAP + BAR + TICK + 1) * unit, unit);
    }
    return HDR_OK;
}

void hdr_drawing_free(hdr_drawing *drawing) {
    free(drawing->pixels);
    drawing->pixels = NULL;
}

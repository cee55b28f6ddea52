/* hdr bench: run time against error, drawn as SVG. The same results give the same bytes. */
#include "bench.h"
#include "plot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A strip below the axes for errors of 0, which no logarithm has. */
enum { STRIP = 40 };
enum { LETTER = 7 /* about the width of one of a label's */ };

static const char *const colours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};
#define COLOURS (sizeof colours / sizeof *colours)

typedef struct box {
    double left, top, right, bottom;
} box;

typedef struct mark {
    const bench_way *way;
    const char *colour;
    char label[80];
    double x, y, bound_y; /* bound_y: where the bound is, or y */
    box place;            /* of the label */
    const char *anchor;
    bool led;   /* it is so far away that a line leads to it */
    bool front; /* no other is better in both */
} mark;

typedef struct plot {
    const bench *b;
    FILE *to;
    plot_axis time, error;
    bool zeros; /* some error is 0 */
    mark marks[BENCH_WAYS];
    int count;
} plot;

/* ---- Text ---- */

/* No more than so many bytes of the end, or of the beginning, from one character's border to another's. */
static void shorten(const char *text, bool keep_end, char *out, size_t room) {
    static const char dots[] = "...";
    size_t length = strlen(text), kept = room - sizeof dots;
    if (length < room) {
        memcpy(out, text, length + 1);
        return;
    }
    const char *from = keep_end ? text + length - kept : text;
    while (keep_end && kept > 0 && (*from & 0xc0) == 0x80)
        from++, kept--;
    while (!keep_end && kept > 0 && (from[kept] & 0xc0) == 0x80)
        kept--;
    snprintf(out, room, "%s%.*s%s", keep_end ? dots : "", (int)kept, from, keep_end ? "" : dots);
}

/* ---- Scales ---- */

static double y_of(const plot *p, double error) {
    if (!(error > 0)) return PLOT_BOTTOM + STRIP / 2.0;
    return plot_y(&p->error, error);
}

/* A time that is too short for the clock is drawn as a microsecond. */
static double drawn_time(const bench_way *way) {
    return fmax(bench_time(way), 1e-3);
}

/* Errors from decade to decade; times with some air around them, more at the right, for the labels. */
static void choose_axes(plot *p) {
    p->time = p->error = (plot_axis)PLOT_AXIS_EMPTY;
    for (int i = 0; i < p->b->count; i++) {
        const bench_way *way = &p->b->way[i];
        plot_widen(&p->time, drawn_time(way));
        if (way->max_error > 0) plot_widen(&p->error, way->max_error);
        if (way->max_error > 0 && way->bound > 0) plot_widen(&p->error, way->bound);
        p->zeros |= !(way->max_error > 0);
    }
    if (p->error.low > p->error.high) p->error = (plot_axis){-7, -6};
    p->error.low = floor(p->error.low - 0.1);
    p->error.high = ceil(p->error.high + 0.1);
    double span = fmax(p->time.high - p->time.low, 0.4);
    p->time.low -= 0.08 * span;
    p->time.high = p->time.low + 1.22 * span;
}

/* ---- Axes ---- */

static void print_time_axis(const plot *p) {
    double foot = p->zeros ? PLOT_BOTTOM + STRIP : PLOT_BOTTOM;
    plot_x_axis(p->to, &p->time, foot);
    fprintf(p->to, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">", (PLOT_LEFT + PLOT_RIGHT) / 2.0, foot + 46);
    if (p->b->varied) {
        fprintf(p->to, "time for ");
        plot_text(p->to, p->b->what);
        fprintf(p->to, ", milliseconds</text>\n");
    } else {
        fprintf(p->to, "time of the whole chain, milliseconds</text>\n");
    }
}

static void print_error_axis(const plot *p) {
    plot_y_axis(p->to, &p->error, true);
    if (p->zeros)
        fprintf(p->to, "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">0</text>\n", PLOT_LEFT - 10, y_of(p, 0) + 4.5);
    fprintf(p->to, "<text transform=\"translate(24 %.1f) rotate(-90)\" text-anchor=\"middle\">",
            (PLOT_TOP + PLOT_BOTTOM) / 2.0);
    if (p->b->varied) {
        fprintf(p->to, "largest error of ");
        plot_text(p->to, p->b->what);
        fprintf(p->to, ", ");
        plot_text(p->to, p->b->unit);
    } else {
        fprintf(p->to, "largest relative error");
    }
    fprintf(p->to, "</text>\n");
}

static void print_frame(const plot *p) {
    plot_frame(p->to, PLOT_TOP, PLOT_BOTTOM);
    if (p->zeros) plot_frame(p->to, PLOT_BOTTOM, PLOT_BOTTOM + STRIP);
}

/* ---- Marks ---- */

/* Methods have colours in the order in which they come. */
static const char *colour_of(const plot *p, int index) {
    const char *method = p->b->way[index].method;
    size_t number = 0;
    for (int i = 0; i < p->b->count && strcmp(p->b->way[i].method, method) != 0; i++)
        number += i == 0 || strcmp(p->b->way[i].method, p->b->way[i - 1].method) != 0;
    return colours[number % COLOURS];
}

static bool is_beaten(const bench *b, const bench_way *way) {
    for (int i = 0; i < b->count; i++) {
        const bench_way *other = &b->way[i];
        bool not_worse = bench_time(other) <= bench_time(way) && other->max_error <= way->max_error;
        bool better = bench_time(other) < bench_time(way) || other->max_error < way->max_error;
        if (not_worse && better) return true;
    }
    return false;
}

static int compare_marks(const void *a, const void *b) {
    const mark *p = a, *q = b;
    if (p->x != q->x) return p->x < q->x ? -1 : 1;
    if (p->y != q->y) return p->y > q->y ? -1 : 1;
    return strcmp(p->label, q->label);
}

static void make_marks(plot *p) {
    for (int i = 0; i < p->b->count; i++) {
        const bench_way *way = &p->b->way[i];
        mark *m = &p->marks[p->count++];
        *m = (mark){.way = way, .colour = colour_of(p, i), .front = !is_beaten(p->b, way)};
        snprintf(m->label, sizeof m->label, "%s%s%s", way->method, way->value ? " " : "", way->value ? way->value : "");
        m->x = plot_x(&p->time, drawn_time(way));
        m->y = m->bound_y = y_of(p, way->max_error);
        if (way->max_error > 0 && way->bound > 0) m->bound_y = y_of(p, way->bound);
    }
    qsort(p->marks, (size_t)p->count, sizeof *p->marks, compare_marks);
}

static double overlap(const box *a, const box *b) {
    double wide = fmin(a->right, b->right) - fmax(a->left, b->left);
    double high = fmin(a->bottom, b->bottom) - fmax(a->top, b->top);
    return wide > 0 && high > 0 ? wide * high : 0;
}

/* How bad a label's place is: what it covers of other labels, marks and bounds, of the front, and of the frame. */
static double badness(const plot *p, int index, const box *place) {
    double bad = 0;
    for (int i = 0; i < p->count; i++) {
        const mark *m = &p->marks[i];
        box around = {m->x - PLOT_RADIUS, m->y - PLOT_RADIUS, m->x + PLOT_RADIUS, m->y + PLOT_RADIUS};
        box bound = {m->x - 3, fmin(m->y, m->bound_y), m->x + 3, fmax(m->y, m->bound_y)};
        bad += 3 * overlap(place, &around) + overlap(place, &bound);
        if (i != index) bad += 3 * overlap(place, &m->place);
    }
    const mark *before = NULL;
    for (int i = 0; i < p->count; i++) {
        const mark *m = &p->marks[i];
        if (!m->front) continue;
        for (int k = 0; before && k <= 40; k++) {
            double x = before->x + (m->x - before->x) * k / 40, y = before->y + (m->y - before->y) * k / 40;
            if (x > place->left && x < place->right && y > place->top && y < place->bottom) bad += 12;
        }
        before = m;
    }
    double foot = p->zeros ? PLOT_BOTTOM + STRIP : PLOT_BOTTOM;
    if (place->left < PLOT_LEFT || place->right > PLOT_RIGHT || place->top < PLOT_TOP || place->bottom > foot)
        bad += 1e4;
    if (place->top < PLOT_BOTTOM && place->bottom > PLOT_BOTTOM) bad += 200;
    return bad;
}

/* The best of some places around the mark, near ones before others; a line leads to one that is farther away. */
static void place_label(plot *p, int index) {
    static const struct {
        double x, y; /* of the label's middle, from the mark's, in halves of the label and what is between them */
    } ways[] = {{1, 0}, {-1, 0}, {1, -0.8}, {1, 0.8}, {-1, -0.8}, {-1, 0.8}, {0, -1}, {0, 1}};
    enum { NEAR = sizeof ways / sizeof *ways, FAR = 48 };
    mark *m = &p->marks[index];
    double half_wide = (double)strlen(m->label) * LETTER / 2.0, half_high = PLOT_FONT / 2.0 + 1, least = INFINITY;
    for (int i = 0; i < NEAR + FAR; i++) {
        int far = i - NEAR; /* at the right, the left, above and below, row by row */
        double right = far < 0 ? ways[i].x : far % 4 < 2 ? 1 : -1;
        double down = far < 0 ? ways[i].y : (1.7 + 0.5 * (far / 4)) * (far % 2 ? 1 : -1);
        double x = m->x + right * (half_wide + PLOT_RADIUS + 4), y = m->y + down * (half_high + PLOT_RADIUS + 2);
        box place = {x - half_wide, y - half_high, x + half_wide, y + half_high};
        double bad = badness(p, index, &place) + i * 3.0 + (far < 0 ? 0 : 30);
        if (bad >= least) continue;
        least = bad;
        m->place = place;
        m->led = far >= 0;
    }
}

static void print_leader(FILE *to, const mark *m) {
    bool right = m->place.left > m->x;
    double y = (m->place.top + m->place.bottom) / 2;
    char style[80];
    snprintf(style, sizeof style, "stroke=\"%s\" stroke-opacity=\"0.6\"", m->colour);
    plot_line(to, m->x, m->y, right ? m->place.left - 1 : m->place.right + 1, y, style);
}

static void print_front(const plot *p) {
    const char *between = "<polyline fill=\"none\" stroke=\"#909090\" stroke-width=\"1.5\" points=\"";
    int shown = 0;
    for (int i = 0; i < p->count; i++)
        if (p->marks[i].front) {
            fprintf(p->to, "%s%.1f,%.1f", shown++ ? " " : between, p->marks[i].x, p->marks[i].y);
        }
    if (shown) fprintf(p->to, "\"/>\n");
}

static void print_ring(FILE *to, double x, double y, const char *colour) {
    fprintf(to, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%d\" fill=\"none\" stroke=\"%s\" stroke-width=\"1.5\"/>\n", x, y,
            PLOT_RADIUS + 4, colour);
}

static void print_marks(const plot *p) {
    for (int i = 0; i < p->count; i++) {
        const mark *m = &p->marks[i];
        if (m->bound_y != m->y) plot_bar(p->to, m->x, m->y, m->bound_y, m->colour);
    }
    print_front(p);
    for (int i = 0; i < p->count; i++)
        if (p->marks[i].led) print_leader(p->to, &p->marks[i]);
    for (int i = 0; i < p->count; i++) {
        const mark *m = &p->marks[i];
        plot_mark(p->to, m->x, m->y, m->colour, m->way->estimated);
        if (m->way->automatic) print_ring(p->to, m->x, m->y, m->colour);
    }
    for (int i = 0; i < p->count; i++) {
        const mark *m = &p->marks[i];
        fprintf(p->to, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\" fill=\"%s\">",
                (m->place.left + m->place.right) / 2, m->place.bottom - 3, m->colour);
        plot_text(p->to, m->label);
        fprintf(p->to, "</text>\n");
    }
}

/* ---- Titles ---- */

static void print_titles(const plot *p) {
    const bench *b = p->b;
    const char *slash = strrchr(b->file, '/');
    char name[60], chain[110], text[300], times[100];
    shorten(strcmp(b->file, "-") == 0 ? "standard input" : slash ? slash + 1 : b->file, true, name, sizeof name);
    shorten(b->chain, false, chain, sizeof chain);
    fprintf(p->to, "<text x=\"%d\" y=\"30\" font-size=\"18\" font-weight=\"bold\">", PLOT_LEFT);
    plot_text(p->to, name);
    fprintf(p->to, ", %lld &#215; %lld: run time against error</text>\n", bench_width(b), bench_height(b));
    bench_describe_times(b, times, sizeof times);
    fprintf(p->to, "<text x=\"%d\" y=\"52\">", PLOT_LEFT);
    plot_text(p->to, chain);
    fprintf(p->to, "; %s</text>\n<text x=\"%d\" y=\"72\">error ", times, PLOT_LEFT);
    bench_describe_error(b, text, sizeof text);
    plot_text(p->to, text);
    fprintf(p->to, "</text>\n");
}

/* What the signs mean, of those that are there. */
static void print_key(const plot *p) {
    bool inferred = false, bounds = false, automatic = false;
    double x = PLOT_LEFT + 8, y = PLOT_HEIGHT - 20;
    for (int i = 0; i < p->count; i++) {
        inferred |= p->marks[i].way->estimated;
        automatic |= p->marks[i].way->automatic;
        bounds |= p->marks[i].bound_y != p->marks[i].y;
    }
    plot_mark(p->to, x, y, "#404040", false);
    x = plot_key(p->to, x + 12, y, "measured");
    if (inferred) {
        plot_mark(p->to, x, y, "#404040", true);
        x = plot_key(p->to, x + 12, y, "time inferred");
    }
    if (automatic) {
        plot_mark(p->to, x, y, "#404040", false);
        print_ring(p->to, x, y, "#404040");
        x = plot_key(p->to, x + 15, y, "what --method auto takes");
    }
    if (bounds) {
        plot_bar(p->to, x, y + 7, y - 7, "#404040");
        x = plot_key(p->to, x + 12, y, "stated bound");
    }
    plot_line(p->to, x - 6, y, x + 14, y, "stroke=\"#909090\" stroke-width=\"1.5\"");
    plot_key(p->to, x + 22, y, "beaten by none in both");
}

hdr_status bench_plot(const bench *b, hdr_output *output, hdr_error *error) {
    plot_sheet sheet;
    plot *p = calloc(1, sizeof *p);
    if (!p || !plot_begin(&sheet)) {
        free(p);
        return cmd_out_of_memory(error);
    }
    p->b = b;
    p->to = sheet.to;
    choose_axes(p);
    make_marks(p);
    for (int i = 0; i < 4 * p->count; i++) /* several times, since each minds the others */
        place_label(p, i % p->count);
    print_titles(p);
    print_time_axis(p);
    print_error_axis(p);
    print_frame(p);
    print_marks(p);
    print_key(p);
    free(p);
    return plot_end(&sheet, output, error);
}

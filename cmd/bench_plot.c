/* hdr bench: run time against error, drawn as SVG. The same results give the same bytes. */
#include "bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The picture, the frame of the axes in it, and a strip below them for errors of 0, which no logarithm has. Pixels. */
enum { WIDTH = 900, HEIGHT = 600, LEFT = 92, RIGHT = 876, TOP = 92, BOTTOM = 466, STRIP = 40 };
enum { FONT = 13, LETTER = 7 /* about the width of one of a label's */, RADIUS = 5 };

static const char *const colours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};
#define COLOURS (sizeof colours / sizeof *colours)

typedef struct box {
    double left, top, right, bottom;
} box;

/* An axis: `low` and `high` are logarithms. */
typedef struct axis {
    double low, high;
} axis;

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
    axis time, error;
    bool zeros; /* some error is 0 */
    mark marks[BENCH_WAYS];
    int count;
} plot;

/* ---- Text ---- */

/* As it may stand in XML: markup is escaped, and what XML has no place for becomes '?'. */
static void print_text(FILE *to, const char *text) {
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

static double x_of(const plot *p, double time) {
    return LEFT + (log10(time) - p->time.low) / (p->time.high - p->time.low) * (RIGHT - LEFT);
}

static double y_of(const plot *p, double error) {
    if (!(error > 0)) return BOTTOM + STRIP / 2.0;
    return BOTTOM - (log10(error) - p->error.low) / (p->error.high - p->error.low) * (BOTTOM - TOP);
}

/* A time that is too short for the clock is drawn as a microsecond. */
static double drawn_time(const bench_way *way) {
    return fmax(bench_time(way), 1e-3);
}

static void widen(axis *a, double value) {
    a->low = fmin(a->low, log10(value));
    a->high = fmax(a->high, log10(value));
}

/* Errors from decade to decade; times with some air around them, more at the right, for the labels. */
static void choose_axes(plot *p) {
    p->time = p->error = (axis){INFINITY, -INFINITY};
    for (int i = 0; i < p->b->count; i++) {
        const bench_way *way = &p->b->way[i];
        widen(&p->time, drawn_time(way));
        if (way->max_error > 0) widen(&p->error, way->max_error);
        if (way->max_error > 0 && way->bound > 0) widen(&p->error, way->bound);
        p->zeros |= !(way->max_error > 0);
    }
    if (p->error.low > p->error.high) p->error = (axis){-7, -6};
    p->error.low = floor(p->error.low - 0.1);
    p->error.high = ceil(p->error.high + 0.1);
    double span = fmax(p->time.high - p->time.low, 0.4);
    p->time.low -= 0.08 * span;
    p->time.high = p->time.low + 1.22 * span;
}

/* ---- Axes ---- */

static void print_line(FILE *to, double x1, double y1, double x2, double y2, const char *style) {
    fprintf(to, "<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" %s/>\n", x1, y1, x2, y2, style);
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
    print_line(to, x1, y1, x2, y2, strong ? "stroke=\"#d4d4d4\"" : "stroke=\"#f0f0f0\"");
}

/* Decades, and what lies between them; the numbers 2 and 5 too where there are few decades. */
static void print_time_axis(const plot *p) {
    bool few = p->time.high - p->time.low < 2.5;
    double foot = p->zeros ? BOTTOM + STRIP : BOTTOM;
    for (int e = (int)floor(p->time.low); e <= (int)ceil(p->time.high); e++)
        for (int digit = 1; digit < 10; digit++) {
            double at = e + log10(digit);
            if (at < p->time.low || at > p->time.high) continue;
            double x = x_of(p, pow(10, at));
            print_grid(p->to, x, TOP, x, foot, digit == 1);
            print_line(p->to, x, foot, x, foot + (digit == 1 ? 6 : 4), "stroke=\"#404040\"");
            if (digit != 1 && !(few && (digit == 2 || digit == 5))) continue;
            fprintf(p->to, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%.10g</text>\n", x, foot + 22,
                    digit * pow(10, e));
        }
    fprintf(p->to, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">", (LEFT + RIGHT) / 2.0, foot + 46);
    if (p->b->varied) {
        fprintf(p->to, "time for ");
        print_text(p->to, p->b->what);
        fprintf(p->to, ", milliseconds</text>\n");
    } else {
        fprintf(p->to, "time of the whole chain, milliseconds</text>\n");
    }
}

static void print_error_axis(const plot *p) {
    for (int e = (int)p->error.low; e <= (int)p->error.high; e++)
        for (int digit = 1; digit < 10; digit++) {
            double at = e + log10(digit);
            if (at > p->error.high) continue;
            double y = y_of(p, pow(10, at));
            if (digit == 1) print_grid(p->to, LEFT, y, RIGHT, y, true);
            print_line(p->to, LEFT - (digit == 1 ? 6 : 3), y, LEFT, y, "stroke=\"#404040\"");
            if (digit == 1) print_power(p->to, LEFT - 10, y + 4.5, e);
        }
    if (p->zeros)
        fprintf(p->to, "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">0</text>\n", LEFT - 10, y_of(p, 0) + 4.5);
    fprintf(p->to, "<text transform=\"translate(24 %.1f) rotate(-90)\" text-anchor=\"middle\">", (TOP + BOTTOM) / 2.0);
    if (p->b->varied) {
        fprintf(p->to, "largest error of ");
        print_text(p->to, p->b->what);
        fprintf(p->to, ", ");
        print_text(p->to, p->b->unit);
    } else {
        fprintf(p->to, "largest relative error");
    }
    fprintf(p->to, "</text>\n");
}

static void print_frame(const plot *p) {
    fprintf(p->to, "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" fill=\"none\" stroke=\"#404040\"/>\n", LEFT, TOP,
            RIGHT - LEFT, BOTTOM - TOP);
    if (!p->zeros) return;
    fprintf(p->to, "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" fill=\"none\" stroke=\"#404040\"/>\n", LEFT,
            BOTTOM, RIGHT - LEFT, STRIP);
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
        m->x = x_of(p, drawn_time(way));
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
        box around = {m->x - RADIUS, m->y - RADIUS, m->x + RADIUS, m->y + RADIUS};
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
    double foot = p->zeros ? BOTTOM + STRIP : BOTTOM;
    if (place->left < LEFT || place->right > RIGHT || place->top < TOP || place->bottom > foot) bad += 1e4;
    if (place->top < BOTTOM && place->bottom > BOTTOM) bad += 200;
    return bad;
}

/* The best of some places around the mark, near ones before others; a line leads to one that is farther away. */
static void place_label(plot *p, int index) {
    static const struct {
        double x, y; /* of the label's middle, from the mark's, in halves of the label and what is between them */
    } ways[] = {{1, 0}, {-1, 0}, {1, -0.8}, {1, 0.8}, {-1, -0.8}, {-1, 0.8}, {0, -1}, {0, 1}};
    enum { NEAR = sizeof ways / sizeof *ways, FAR = 48 };
    mark *m = &p->marks[index];
    double half_wide = (double)strlen(m->label) * LETTER / 2.0, half_high = FONT / 2.0 + 1, least = INFINITY;
    for (int i = 0; i < NEAR + FAR; i++) {
        int far = i - NEAR; /* at the right, the left, above and below, row by row */
        double right = far < 0 ? ways[i].x : far % 4 < 2 ? 1 : -1;
        double down = far < 0 ? ways[i].y : (1.7 + 0.5 * (far / 4)) * (far % 2 ? 1 : -1);
        double x = m->x + right * (half_wide + RADIUS + 4), y = m->y + down * (half_high + RADIUS + 2);
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
    print_line(to, m->x, m->y, right ? m->place.left - 1 : m->place.right + 1, y, style);
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

static void print_bound(FILE *to, double x, double from, double bound, const char *colour) {
    char style[80];
    snprintf(style, sizeof style, "stroke=\"%s\" stroke-opacity=\"0.45\"", colour);
    print_line(to, x, from, x, bound, style);
    print_line(to, x - 4, bound, x + 4, bound, style);
}

static void print_ring(FILE *to, double x, double y, const char *colour) {
    fprintf(to, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%d\" fill=\"none\" stroke=\"%s\" stroke-width=\"1.5\"/>\n", x, y,
            RADIUS + 4, colour);
}

static void print_mark(FILE *to, double x, double y, const char *colour, bool inferred) {
    fprintf(to, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%d\" fill=\"%s\" stroke=\"%s\" stroke-width=\"2\"/>\n", x, y,
            RADIUS - 1, inferred ? "#ffffff" : colour, colour);
}

static void print_marks(const plot *p) {
    for (int i = 0; i < p->count; i++) {
        const mark *m = &p->marks[i];
        if (m->bound_y != m->y) print_bound(p->to, m->x, m->y, m->bound_y, m->colour);
    }
    print_front(p);
    for (int i = 0; i < p->count; i++)
        if (p->marks[i].led) print_leader(p->to, &p->marks[i]);
    for (int i = 0; i < p->count; i++) {
        const mark *m = &p->marks[i];
        print_mark(p->to, m->x, m->y, m->colour, m->way->estimated);
        if (m->way->automatic) print_ring(p->to, m->x, m->y, m->colour);
    }
    for (int i = 0; i < p->count; i++) {
        const mark *m = &p->marks[i];
        fprintf(p->to, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\" fill=\"%s\">",
                (m->place.left + m->place.right) / 2, m->place.bottom - 3, m->colour);
        print_text(p->to, m->label);
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
    fprintf(p->to, "<text x=\"%d\" y=\"30\" font-size=\"18\" font-weight=\"bold\">", LEFT);
    print_text(p->to, name);
    fprintf(p->to, ", %lld &#215; %lld: run time against error</text>\n", bench_width(b), bench_height(b));
    bench_describe_times(b, times, sizeof times);
    fprintf(p->to, "<text x=\"%d\" y=\"52\">", LEFT);
    print_text(p->to, chain);
    fprintf(p->to, "; %s</text>\n<text x=\"%d\" y=\"72\">error ", times, LEFT);
    bench_describe_error(b, text, sizeof text);
    print_text(p->to, text);
    fprintf(p->to, "</text>\n");
}

static double print_key_text(FILE *to, double x, double y, const char *text) {
    fprintf(to, "<text x=\"%.1f\" y=\"%.1f\" fill=\"#404040\">%s</text>\n", x, y + 4.5, text);
    return x + (double)strlen(text) * 6.6 + 26;
}

/* What the signs mean, of those that are there. */
static void print_key(const plot *p) {
    bool inferred = false, bounds = false, automatic = false;
    double x = LEFT + 8, y = HEIGHT - 20;
    for (int i = 0; i < p->count; i++) {
        inferred |= p->marks[i].way->estimated;
        automatic |= p->marks[i].way->automatic;
        bounds |= p->marks[i].bound_y != p->marks[i].y;
    }
    print_mark(p->to, x, y, "#404040", false);
    x = print_key_text(p->to, x + 12, y, "measured");
    if (inferred) {
        print_mark(p->to, x, y, "#404040", true);
        x = print_key_text(p->to, x + 12, y, "time inferred");
    }
    if (automatic) {
        print_mark(p->to, x, y, "#404040", false);
        print_ring(p->to, x, y, "#404040");
        x = print_key_text(p->to, x + 15, y, "what --method auto takes");
    }
    if (bounds) {
        print_bound(p->to, x, y + 7, y - 7, "#404040");
        x = print_key_text(p->to, x + 12, y, "stated bound");
    }
    print_line(p->to, x - 6, y, x + 14, y, "stroke=\"#909090\" stroke-width=\"1.5\"");
    print_key_text(p->to, x + 22, y, "beaten by none in both");
}

char *bench_plot(const bench *b, size_t *size) {
    char *text = NULL;
    plot *p = calloc(1, sizeof *p);
    FILE *to = p ? open_memstream(&text, size) : NULL;
    if (to) {
        p->b = b;
        p->to = to;
        choose_axes(p);
        make_marks(p);
        for (int i = 0; i < 4 * p->count; i++) /* several times, since each minds the others */
            place_label(p, i % p->count);
        fprintf(to,
                "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" "
                "height=\"%d\" viewBox=\"0 0 %d %d\" font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\" "
                "font-size=\"%d\">\n<rect width=\"%d\" height=\"%d\" fill=\"#ffffff\"/>\n",
                WIDTH, HEIGHT, WIDTH, HEIGHT, FONT, WIDTH, HEIGHT);
        print_titles(p);
        print_time_axis(p);
        print_error_axis(p);
        print_frame(p);
        print_marks(p);
        print_key(p);
        fprintf(to, "</svg>\n");
    }
    bool whole = to && ferror(to) == 0;
    if (to && fclose(to) != 0) whole = false;
    free(p);
    if (whole) return text;
    free(text);
    return NULL;
}

#include "spatial/bilateral.h"

#include "kernel/grid.h"
#include "kernel/real.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Kernels in the grid reach that far: a pixel by itself weighs no more than 1e-5 of a crowd, and e^(-7.5^2 / 2) of that
 * crowd, seen from far away in range, has to be nothing beside it. */
#define REACH_DEVIATIONS 7.5

enum { BAND = 32, STRIP = 16 * HDR_PIECE, SPAN_UNIT = 16 };

/* A Gaussian between nodes. */
typedef struct blur {
    int reach;
    float *weight;
} blur;

/* Floats of a slab, from one of SPAN_UNIT on, whole units of them. */
typedef struct span {
    size_t first, count;
} span;

/* Levels, as they are stored. */
typedef struct extent {
    int low, end;
} extent;

typedef struct worker {
    float *slab;     /* a row of columns */
    span *spans;     /* of the slab, in order, that the row's pixels reach */
    extent *extents; /* of the pixels whose nodes begin at each column */
    float *rows;     /* sowing: four rows of the grid */
    float *margined; /* blurring: what is blurred, with zeros around it */
    float *blurred;
    const float **row; /* rows for the convolution, as it wants them */
    hdr_spline *deep;  /* of a row's numbers */
} worker;

typedef struct grid {
    const hdr_bilateral *filter;
    hdr_plane *plane;
    hdr_pool *pool;
    double across, deep;     /* size of a cell: in pixels, in the numbers' unit */
    float middle;            /* numbers are taken from here, so that N is small */
    int columns, rows;       /* of nodes */
    int levels;              /* nodes in range, all of them */
    int stored;              /* levels that some number needs */
    int *level;              /* where a level is stored; of one that is not: -1 */
    hdr_spline *column;      /* of each x */
    size_t stride, row_size; /* floats of a column, of a row */
    float *cells;
    size_t cells_size;
    blur flat, range;
    worker *workers;
    int threads;
    unsigned char *seen; /* levels, of each thread */
} grid;

/* ---- Levels ---- */

static int rows_of(const grid *g, int band) {
    return g->plane->height - band * BAND < BAND ? g->plane->height - band * BAND : BAND;
}

static float *row_of(const grid *g, int y) {
    return g->plane->narrow + (size_t)y * g->plane->stride;
}

static hdr_status see_levels(void *context, int band, int thread, hdr_error *err) {
    (void)err;
    grid *g = context;
    unsigned char *seen = g->seen + (size_t)thread * (size_t)g->levels;
    for (int y = band * BAND; y < band * BAND + rows_of(g, band); y++) {
        const float *numbers = row_of(g, y);
        for (int x = 0; x < g->plane->width; x++)
            seen[(int)(((double)numbers[x] - g->filter->low) / g->deep)] = 1;
    }
    return HDR_OK;
}

/* Levels that no number is within reach of the splines of are not stored. */
static void store_levels(grid *g) {
    g->stored = 0;
    for (int l = 0; l < g->levels; l++) {
        bool used = g->filter->no_skip;
        for (int t = 0; t < g->threads && !used; t++)
            for (int k = 0; k < 4 && !used; k++)
                used = l >= k && g->seen[(size_t)t * (size_t)g->levels + (size_t)(l - k)];
        g->level[l] = used ? g->stored++ : -1;
    }
}

/* ---- What a row of pixels reaches ---- */

/* Levels of the pixels whose nodes begin at each column. */
static void find_extents(const grid *g, const worker *w) {
    for (int c = 0; c < g->columns; c++)
        w->extents[c] = (extent){g->stored, 0};
    for (int x = 0; x < g->plane->width;) {
        int c = g->column[x].first, low = g->stored, end = 0;
        for (; x < g->plane->width && g->column[x].first == c; x++) {
            int level = g->level[w->deep[x].first];
            low = level < low ? level : low;
            end = level + 4 > end ? level + 4 : end;
        }
        w->extents[c] = (extent){low, end};
    }
}

/* The spans of a slab that hold what the row's pixels sow and read: a picture's neighbours are alike, so that most
 * levels of a column are nobody's. w->deep is the row's. How many there are. */
static int find_spans(const grid *g, const worker *w) {
    int count = 0;
    if (g->filter->no_skip) {
        w->spans[0] = (span){0, g->row_size};
        return 1;
    }
    find_extents(g, w);
    size_t behind = 0;
    for (int c = 0; c < g->columns; c++) {
        extent all = {g->stored, 0};
        for (int from = c < 4 ? 0 : c - 3; from <= c; from++) {
            if (w->extents[from].low < all.low) all.low = w->extents[from].low;
            if (w->extents[from].end > all.end) all.end = w->extents[from].end;
        }
        if (all.end == 0) continue;
        size_t first = ((size_t)c * g->stride + 2 * (size_t)all.low) / SPAN_UNIT * SPAN_UNIT;
        size_t end = ((size_t)c * g->stride + 2 * (size_t)all.end + SPAN_UNIT - 1) / SPAN_UNIT * SPAN_UNIT;
        if (count > 0 && first <= behind)
            w->spans[count - 1].count = end - w->spans[count - 1].first;
        else
            w->spans[count++] = (span){first, end - first};
        behind = end;
    }
    return count;
}

/* ---- Sowing ---- */

/* The nodes of rows that an image's rows are sown into. */
static int first_node(const grid *g, int y) {
    return (int)(y / g->across);
}

/* A row's pixels into the slab. How many spans of it they reach. */
static int sow_row(const grid *g, worker *w, const float *numbers) {
    size_t width = (size_t)g->plane->width;
    hdr_splines_of(numbers, g->filter->low, g->deep, w->deep, width);
    int spans = find_spans(g, w);
    for (int s = 0; s < spans; s++)
        memset(w->slab + w->spans[s].first, 0, w->spans[s].count * sizeof *w->slab);
    hdr_grid_sow(numbers, g->middle, g->column, w->deep, g->level, width, w->slab, g->stride);
    return spans;
}

/* Each band into rows of its own, which are added to the grid's in the order of the bands. */
static hdr_status sow_band(void *context, int band, int thread, hdr_error *err) {
    (void)err;
    grid *g = context;
    worker *w = &g->workers[thread];
    int top = band * BAND, end = top + rows_of(g, band), width = g->plane->width, spans = 0;
    int first = first_node(g, top), nodes = first_node(g, end - 1) + 4 - first;
    memset(w->rows, 0, (size_t)nodes * g->row_size * sizeof *w->rows);
    for (int y = top; y < end; y++) {
        bool again = y > top && !memcmp(row_of(g, y), row_of(g, y - 1), (size_t)width * sizeof(float));
        if (!again || g->filter->no_skip) spans = sow_row(g, w, row_of(g, y)); /* a margin is sown once */
        hdr_spline row = hdr_spline_at(y / g->across);
        float *rows = w->rows + (size_t)(row.first - first) * g->row_size;
        for (int s = 0; s < spans; s++) {
            float *into[4];
            for (size_t k = 0; k < 4; k++)
                into[k] = rows + k * g->row_size + w->spans[s].first;
            hdr_grid_spread(w->slab + w->spans[s].first, row.weight, into, w->spans[s].count);
        }
    }
    if (!hdr_pool_enter(g->pool, band)) return HDR_OK;
    float *cells = g->cells + (size_t)first * g->row_size;
    for (size_t i = 0; i < (size_t)nodes * g->row_size; i++)
        cells[i] += w->rows[i];
    hdr_pool_leave(g->pool, band);
    return HDR_OK;
}

/* ---- Blurring ---- */

/* Divides a symmetric sequence's spectrum by that of the sampled B-spline of degree 7, up to a factor: there and back
 * for each of the spline's poles. Unser, Aldroubi and Eden, B-Spline Signal Processing, IEEE Transactions on Signal
 * Processing 41(2), 1993. What lies beyond the ends is taken for 0. */
static void divide_by_spline(double *sequence, int count) {
    static const double pole[] = {-0.53528043079643816554, -0.12255461519232669052, -0.0091486948096082769286};
    for (int p = 0; p < 3; p++) {
        for (int i = 1; i < count; i++)
            sequence[i] += pole[p] * sequence[i - 1];
        sequence[count - 1] *= -pole[p];
        for (int i = count - 2; i >= 0; i--)
            sequence[i] = pole[p] * (sequence[i + 1] - sequence[i]);
    }
}

/* Weights, up to a factor, which N / W does not see, that make a Gaussian of that deviation in cells of what sowing and
 * reading by cubic B-splines blur, which together is the B-spline of degree 7. */
static bool make_blur(blur *b, double deviation) {
    int middle = (int)ceil(10 * deviation) + 40, count = 2 * middle + 1;
    double *sequence = hdr_alloc((size_t)count, sizeof *sequence);
    b->reach = (int)ceil(REACH_DEVIATIONS * deviation);
    b->weight = hdr_alloc((size_t)b->reach + 1, sizeof *b->weight);
    bool made = sequence && b->weight;
    for (int k = -middle; made && k <= middle; k++)
        sequence[middle + k] = hdr_exp(-0.5 * k * k / (deviation * deviation));
    if (made) divide_by_spline(sequence, count);
    for (int k = 0; made && k <= b->reach; k++)
        b->weight[k] = (float)fmax(sequence[middle + k] / sequence[middle], 0);
    free(sequence);
    return made;
}

/* Blurs `count` numbers whose neighbours stand `step` apart; from has the blur's reach of steps around them. */
static void convolve(const worker *w, const blur *b, const float *from, size_t step, float *out, size_t count) {
    const float **centre = w->row + b->reach;
    for (int k = -b->reach; k <= b->reach; k++)
        centre[k] = from + (ptrdiff_t)step * k;
    for (size_t x = 0; x < count; x += HDR_PIECE)
        hdr_convolve_down(centre, x, b->weight, b->reach, out + x);
}

/* A column in range: all its levels, those that are not stored being 0. */
static void blur_column(const grid *g, const worker *w, float *column) {
    float *inner = w->margined + 2 * (size_t)g->range.reach;
    memset(w->margined, 0, (2 * (size_t)g->levels + 4 * (size_t)g->range.reach + HDR_PIECE) * sizeof *w->margined);
    for (int l = 0; l < g->levels; l++)
        if (g->level[l] >= 0) memcpy(inner + 2 * (size_t)l, column + 2 * (size_t)g->level[l], 2 * sizeof *column);
    convolve(w, &g->range, inner, 2, w->blurred, 2 * (size_t)g->levels);
    for (int l = 0; l < g->levels; l++)
        if (g->level[l] >= 0) memcpy(column + 2 * (size_t)g->level[l], w->blurred + 2 * (size_t)l, 2 * sizeof *column);
}

/* A row in range, then along it. */
static hdr_status blur_row(void *context, int row, int thread, hdr_error *err) {
    (void)err;
    grid *g = context;
    const worker *w = &g->workers[thread];
    float *cells = g->cells + (size_t)row * g->row_size;
    for (int c = 0; c < g->columns; c++)
        blur_column(g, w, cells + (size_t)c * g->stride);
    size_t margin = (size_t)g->flat.reach * g->stride, used = (size_t)g->columns * g->stride;
    memset(w->margined, 0, margin * sizeof *w->margined);
    memcpy(w->margined + margin, cells, used * sizeof *cells);
    memset(w->margined + margin + used, 0, (margin + HDR_PIECE) * sizeof *w->margined);
    convolve(w, &g->flat, w->margined + margin, g->stride, cells, used);
    return HDR_OK;
}

/* From row to row, a strip of all rows. */
static hdr_status blur_strip(void *context, int strip, int thread, hdr_error *err) {
    (void)err;
    grid *g = context;
    const worker *w = &g->workers[thread];
    size_t first = (size_t)strip * STRIP, count = g->row_size - first < STRIP ? g->row_size - first : STRIP;
    size_t margin = (size_t)g->flat.reach * STRIP;
    memset(w->margined, 0, margin * sizeof *w->margined);
    for (int row = 0; row < g->rows; row++)
        memcpy(w->margined + margin + (size_t)row * STRIP, g->cells + (size_t)row * g->row_size + first,
               count * sizeof *g->cells);
    memset(w->margined + margin + (size_t)g->rows * STRIP, 0, margin * sizeof *w->margined);
    for (int row = 0; row < g->rows; row++)
        convolve(w, &g->flat, w->margined + margin + (size_t)row * STRIP, STRIP,
                 g->cells + (size_t)row * g->row_size + first, count);
    return HDR_OK;
}

/* ---- Reading ---- */

/* Whether the base of some pixel of a row is wanted. */
static bool is_wanted(const grid *g, int y) {
    const unsigned char *wanted = g->filter->wanted;
    size_t bytes = hdr_mask_row(g->plane->width), i = 0;
    if (!wanted) return true;
    while (i < bytes && !wanted[(size_t)y * bytes + i])
        i++;
    return i < bytes;
}

static hdr_status read_band(void *context, int band, int thread, hdr_error *err) {
    (void)err;
    grid *g = context;
    const worker *w = &g->workers[thread];
    int width = g->plane->width;
    for (int y = band * BAND; y < band * BAND + rows_of(g, band); y++) {
        if (!is_wanted(g, y)) continue;
        hdr_splines_of(row_of(g, y), g->filter->low, g->deep, w->deep, (size_t)width);
        hdr_spline row = hdr_spline_at(y / g->across);
        const float *rows = g->cells + (size_t)row.first * g->row_size;
        for (int s = find_spans(g, w) - 1; s >= 0; s--) {
            const float *from[4];
            for (size_t k = 0; k < 4; k++)
                from[k] = rows + k * g->row_size + w->spans[s].first;
            hdr_grid_gather(from, row.weight, w->slab + w->spans[s].first, w->spans[s].count);
        }
        hdr_grid_read(g->middle, g->column, w->deep, g->level, (size_t)width, w->slab, g->stride, row_of(g, y));
    }
    return HDR_OK;
}

/* ---- In all ---- */

static size_t larger(size_t a, size_t b) {
    return a > b ? a : b;
}

static bool make_workers(grid *g) {
    size_t band_rows = (size_t)(BAND / g->across) + 5;
    size_t margined = larger((size_t)g->columns * g->stride + 2 * (size_t)g->flat.reach * g->stride,
                             ((size_t)g->rows + 2 * (size_t)g->flat.reach) * STRIP);
    margined = larger(margined, 2 * (size_t)g->levels + 4 * (size_t)g->range.reach) + HDR_PIECE;
    int reach = g->flat.reach > g->range.reach ? g->flat.reach : g->range.reach;
    g->workers = hdr_alloc((size_t)g->threads, sizeof *g->workers);
    for (int t = 0; g->workers && t < g->threads; t++) {
        worker *w = &g->workers[t];
        w->slab = hdr_alloc(g->row_size, sizeof *w->slab);
        w->spans = hdr_alloc((size_t)g->columns, sizeof *w->spans);
        w->extents = hdr_alloc((size_t)g->columns, sizeof *w->extents);
        w->rows = hdr_alloc(band_rows, g->row_size * sizeof *w->rows);
        w->margined = hdr_alloc(margined, sizeof *w->margined);
        w->blurred = hdr_alloc(2 * (size_t)g->levels + HDR_PIECE, sizeof *w->blurred);
        w->row = hdr_alloc(2 * (size_t)reach + 1, sizeof *w->row);
        w->deep = hdr_alloc((size_t)g->plane->width, sizeof *w->deep);
        if (!w->slab || !w->spans || !w->extents || !w->rows || !w->margined || !w->blurred || !w->row || !w->deep)
            return false;
    }
    return g->workers != NULL;
}

static bool lay_out(grid *g) {
    int width = g->plane->width;
    g->columns = (int)((width - 1) / g->across) + 4;
    g->rows = first_node(g, g->plane->height - 1) + 4;
    g->column = hdr_alloc((size_t)width, sizeof *g->column);
    for (int x = 0; g->column && x < width; x++)
        g->column[x] = hdr_spline_at(x / g->across);
    g->stride = 2 * (size_t)g->stored;
    g->row_size = ((size_t)g->columns * g->stride + HDR_PIECE - 1) / HDR_PIECE * HDR_PIECE;
    g->cells_size = (size_t)g->rows * g->row_size * sizeof *g->cells;
    g->cells = hdr_alloc_pages(g->cells_size);
    if (g->cells) memset(g->cells, 0, g->cells_size);
    double flat = g->filter->sigma_s / g->across, range = g->filter->sigma_r / g->deep;
    return g->column && g->cells && make_blur(&g->flat, flat) && make_blur(&g->range, range) && make_workers(g);
}

static void free_grid(grid *g) {
    for (int t = 0; g->workers && t < g->threads; t++) {
        worker *w = &g->workers[t];
        free(w->slab);
        free(w->spans);
        free(w->extents);
        free(w->rows);
        free(w->margined);
        free(w->blurred);
        free(w->row);
        free(w->deep);
    }
    free(g->workers);
    if (g->cells) hdr_free_pages(g->cells, g->cells_size);
    free(g->flat.weight);
    free(g->range.weight);
    free(g->column);
    free(g->level);
    free(g->seen);
}

hdr_grid_size hdr_grid_size_of(const hdr_bilateral *filter, const hdr_plane *plane, double across, double deep) {
    hdr_grid_size size = {.columns = floor((plane->width - 1) * across / filter->sigma_s) + 4,
                          .rows = floor((plane->height - 1) * across / filter->sigma_s) + 4,
                          .levels = floor((filter->high - filter->low) * deep / filter->sigma_r) + 4};
    size.bytes = size.columns * size.rows * size.levels * 2 * sizeof(float);
    return size;
}

/* Bytes beyond this machine's, or numbers beyond those of an index. Besides the grid each thread has some of its rows.
 */
static bool is_too_large(const hdr_grid_size *size, double across, int threads) {
    double band = BAND / across + 7; /* rows of the grid that a band is sown into, a slab, and one with a margin */
    double most = size->columns > size->rows ? size->columns : size->rows;
    return size->bytes * (1 + threads * band / size->rows) > (double)hdr_memory_default() || most > INT32_MAX / 4 ||
           size->levels > INT32_MAX / 4;
}

hdr_status hdr_bilateral_grid(const hdr_bilateral *filter, double across, double deep, hdr_plane *plane, hdr_pool *pool,
                              hdr_bilateral_report *report, hdr_error *err) {
    grid g = {.filter = filter,
              .plane = plane,
              .pool = pool,
              .across = filter->sigma_s / across,
              .deep = filter->sigma_r / deep,
              .middle = (float)((filter->low + filter->high) / 2),
              .threads = hdr_pool_threads(pool)};
    int bands = (plane->height + BAND - 1) / BAND;
    hdr_grid_size size = hdr_grid_size_of(filter, plane, across, deep);
    if (is_too_large(&size, g.across, g.threads))
        return hdr_fail(err, HDR_INTERNAL, "out of memory: a grid of %.0f x %.0f x %.0f", size.columns, size.rows,
                        size.levels);
    g.levels = (int)((filter->high - filter->low) / g.deep) + 4;
    g.level = hdr_alloc((size_t)g.levels, sizeof *g.level);
    g.seen = hdr_alloc((size_t)g.threads, (size_t)g.levels);
    hdr_status status = g.level && g.seen ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
    if (status == HDR_OK && !filter->no_skip) status = hdr_pool_run(pool, bands, see_levels, &g, err);
    if (status == HDR_OK) {
        store_levels(&g);
        if (!lay_out(&g))
            status = hdr_fail(err, HDR_INTERNAL, "out of memory: a grid of %d x %d x %d", g.columns, g.rows, g.stored);
    }
    if (status == HDR_OK) status = hdr_pool_run(pool, bands, sow_band, &g, err);
    if (status == HDR_OK) status = hdr_pool_run(pool, g.rows, blur_row, &g, err);
    if (status == HDR_OK) status = hdr_pool_run(pool, (int)((g.row_size + STRIP - 1) / STRIP), blur_strip, &g, err);
    if (status == HDR_OK) status = hdr_pool_run(pool, bands, read_band, &g, err);
    report->cells = (uint64_t)g.columns * (uint64_t)g.rows * (uint64_t)g.levels;
    report->used = (uint64_t)g.columns * (uint64_t)g.rows * (uint64_t)g.stored;
    free_grid(&g);
    return status;
}

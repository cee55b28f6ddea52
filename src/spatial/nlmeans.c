/* Non-local means, fast: offset by offset of the window, as all patches of one offset are sums of the same distances.
 * Darbon, Cunha, Chan, Osher and Jensen, Fast Nonlocal Filtering Applied to Electron Cryomicroscopy, ISBI 2008; but the
 * sums are made anew for each place, row of rows and then row, since running sums would carry a firefly's rounding
 * along.
 *
 * An offset and its opposite are computed together: d2(a,b) and d2(b,a) share all but the variance that is taken off.
 *
 * The work is done in float, tile by tile, in units in which the largest number of the tile and what is around it is
 * about 2^60: no square overflows, and those that underflow are of numbers 2^-120 as large. */
#include "spatial/nlmeans.h"

#include "base/cpu.h"
#include "kernel/real_float.h"
#include "kernel/strip.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TILE_WIDTH = 128, TILE_HEIGHT = HDR_NLMEANS_ROWS, LANES = 16, MOST_LINES = 2 * HDR_NLMEANS_MOST_PATCH + 1 };
#define LARGEST_EXPONENT 60
#define INFINITE 0x1p60f /* as a distance: its mean over any patch is far beyond what has a weight */

/* Numbers of a tile and of a margin of `reach` on all sides; those outside the picture, or not finite, are 0. */
struct hdr_nlmeans_room {
    int reach;
    size_t stride; /* numbers from one row to the next */
    float *all;    /* what the others point into */
    float *colour[3], *variance[3];
    float *sound;           /* 1 where there is a pixel and it is finite, else 0 */
    float *sums[3], *total; /* of weight times difference, and of weights, without the pixel's own, which is 1 */
    float *lines[2];        /* of distances, forth and back: as many rows as a patch has */
    float *down, *across;   /* sums of these */
    float *share;           /* of each column: 1 / pairs of a patch */
    float *weight;
};

/* What is done at the time. Columns and rows are counted from the tile's corner, and negative in the margin. */
typedef struct tile {
    const hdr_nlmeans *filter;
    const hdr_nlmeans_rows *rows;
    hdr_nlmeans_room *room;
    int x, y, width, height;      /* where it lies in the picture */
    int left, right, top, bottom; /* around the pixels that are wanted: first, and behind the last */
    bool all_sound;
    double unit; /* numbers of the picture are this many times those of the room */
    float k2;
} tile;

int hdr_nlmeans_reach(const hdr_nlmeans *filter) {
    return filter->radius + filter->patch;
}

/* Relative errors in units of u = 2^-24, derived for d, the mean of a patch, and t = 1/k^2, which bounds what is taken
 * off. Of one d2: the variances, their sum, its product with k^2 and the quotient 5 of it, the square of the difference
 * and what is taken off 5 of the former's part, at most d2 + t, and 3 of t: 11 |d2| + 8 t. The sums over 3 channels
 * and two rows of patches, with the division by their number, another 14 of the mean of |d2|, which is at most d + 2 t.
 * So d, and the weight relative to itself, is wrong by 27 d + 62 t. What a result is wrong by is twice the weights'
 * mean of that, times the largest difference; the mean of d itself is below the logarithm of the number of weights; and
 * the sums of all weights round by that number, each. */
double hdr_nlmeans_bound(const hdr_nlmeans *filter) {
    double window = 2.0 * filter->radius + 1, count = window * window;
    return 0x1p-24 * (2 * (62 / (filter->k * filter->k) + 27 * (log(count) + 1)) + 2 * count);
}

/* ---- Room ---- */

/* What is only looked at in part may be computed up to a whole number of lanes: rows have the room. */
static size_t whole_lanes(size_t count) {
    return (count + LANES - 1) / LANES * LANES;
}

void hdr_nlmeans_room_free(hdr_nlmeans_room *room) {
    if (!room) return;
    free(room->all);
    free(room);
}

hdr_nlmeans_room *hdr_nlmeans_room_new(const hdr_nlmeans *filter) {
    hdr_nlmeans_room *room = hdr_alloc(1, sizeof *room);
    if (!room) return NULL;
    room->reach = hdr_nlmeans_reach(filter);
    size_t margin = 2 * (size_t)room->reach;
    room->stride = whole_lanes(TILE_WIDTH + margin);
    size_t plane = room->stride * (TILE_HEIGHT + margin), tile = (size_t)TILE_WIDTH * TILE_HEIGHT;
    size_t lines = (2 * (size_t)filter->patch + 1) * room->stride;
    room->all = hdr_alloc(7 * plane + 4 * tile + 2 * lines + 4 * room->stride, sizeof(float));
    if (!room->all) {
        hdr_nlmeans_room_free(room);
        return NULL;
    }
    float *at = room->all;
    for (int c = 0; c < 3; c++, at += 2 * plane)
        room->colour[c] = at, room->variance[c] = at + plane;
    room->sound = at;
    at += plane;
    for (int c = 0; c < 3; c++, at += tile)
        room->sums[c] = at;
    room->total = at;
    at += tile;
    room->lines[0] = at;
    room->lines[1] = at + lines;
    at += 2 * lines;
    room->down = at;
    room->across = at + room->stride;
    room->share = at + 2 * room->stride;
    room->weight = at + 3 * room->stride;
    return room;
}

static size_t place(const tile *t, int x, int y) {
    return (size_t)(y + t->room->reach) * t->room->stride + (size_t)(x + t->room->reach);
}

/* ---- A tile's numbers ---- */

/* The part of the tile and its margin that lies in the picture. */
typedef struct part {
    int left, right, top, bottom;
} part;

static part part_inside(const tile *t) {
    int reach = t->room->reach;
    part inside = {-reach, t->width + reach, -reach, t->height + reach};
    if (t->x + inside.left < 0) inside.left = -t->x;
    if (t->y + inside.top < 0) inside.top = -t->y;
    if (inside.right > t->rows->width - t->x) inside.right = t->rows->width - t->x;
    if (inside.bottom > t->rows->height - t->y) inside.bottom = t->rows->height - t->y;
    return inside;
}

/* The largest of all sound numbers. */
static float find_largest(const tile *t, const part *inside) {
    const hdr_nlmeans_rows *rows = t->rows;
    float largest = 0;
    for (int c = 0; c < rows->channels; c++)
        for (int y = inside->top; y < inside->bottom; y++) {
            size_t at = hdr_nlmeans_place(rows, t->x + inside->left, t->y + y);
            for (int x = inside->left; x < inside->right; x++, at++) {
                float colour = fabsf(rows->colour[c][at]), deviation = rows->deviation[c][at];
                if (colour <= FLT_MAX && colour > largest) largest = colour;
                if (deviation > largest) largest = deviation;
            }
        }
    return largest;
}

static void load_row(const tile *t, const part *inside, int y, double scale) {
    const hdr_nlmeans_rows *rows = t->rows;
    hdr_nlmeans_room *room = t->room;
    size_t from = hdr_nlmeans_place(rows, t->x + inside->left, t->y + y), to = place(t, inside->left, y);
    for (int x = inside->left; x < inside->right; x++, from++, to++) {
        bool sound = hdr_nlmeans_sound(rows, from);
        room->sound[to] = sound;
        for (int c = 0; c < rows->channels; c++) {
            float deviation = (float)((double)rows->deviation[c][from] * scale);
            room->colour[c][to] = sound ? (float)((double)rows->colour[c][from] * scale) : 0;
            room->variance[c][to] = sound ? deviation * deviation : 0;
        }
    }
}

static void load(tile *t) {
    hdr_nlmeans_room *room = t->room;
    part inside = part_inside(t);
    int exponent = 0;
    (void)frexpf(find_largest(t, &inside), &exponent);
    t->unit = ldexp(1, exponent - LARGEST_EXPONENT);
    size_t plane = room->stride * (TILE_HEIGHT + 2 * (size_t)room->reach);
    memset(room->all, 0, 7 * plane * sizeof(float));
    for (int y = inside.top; y < inside.bottom; y++)
        load_row(t, &inside, y, 1 / t->unit);
    t->all_sound = true;
    for (int y = -room->reach; y < t->height + room->reach; y++)
        for (int x = -room->reach; x < t->width + room->reach; x++)
            t->all_sound &= room->sound[place(t, x, y)] != 0;
    memset(room->sums[0], 0, 4 * (size_t)TILE_WIDTH * TILE_HEIGHT * sizeof(float));
}

/* ---- Rows ---- */

/* Adds the distances of one channel, forth and back, of a row's pixels a and those b at some offset. */
HDR_INLINE void add_distances_body(const float *restrict colour_a, const float *restrict colour_b,
                                   const float *restrict variance_a, const float *restrict variance_b, float k2,
                                   float *restrict forth, float *restrict back, size_t count) {
    for (size_t i = 0; i < count; i++) {
        float difference = colour_a[i] - colour_b[i];
        float less = variance_b[i] < variance_a[i] ? variance_b[i] : variance_a[i];
        float divisor = k2 * (variance_a[i] + variance_b[i]);
        float factor = 1.0f / (divisor > FLT_MIN ? divisor : FLT_MIN);
        float left = difference * difference - less;
        float distance_forth = (left - variance_a[i]) * factor, distance_back = (left - variance_b[i]) * factor;
        forth[i] += distance_forth < INFINITE ? distance_forth : INFINITE;
        back[i] += distance_back < INFINITE ? distance_back : INFINITE;
    }
}
HDR_VERSIONS_IN(static, add_distances,
                (const float *colour_a, const float *colour_b, const float *variance_a, const float *variance_b,
                 float k2, float *forth, float *back, size_t count),
                (colour_a, colour_b, variance_a, variance_b, k2, forth, back, count))

/* Where one of the two is no pixel there is no distance. */
HDR_INLINE void mask_body(const float *restrict sound_a, const float *restrict sound_b, float *restrict forth,
                          float *restrict back, size_t count) {
    for (size_t i = 0; i < count; i++) {
        float both = sound_a[i] * sound_b[i];
        forth[i] *= both;
        back[i] *= both;
    }
}
HDR_VERSIONS_IN(static, mask, (const float *sound_a, const float *sound_b, float *forth, float *back, size_t count),
                (sound_a, sound_b, forth, back, count))

/* The sum of an odd number of rows. */
HDR_INLINE void add_lines_body(const float *const *line, int lines, float *restrict out, size_t count) {
    if (lines == 1) {
        memcpy(out, line[0], count * sizeof *out);
        return;
    }
    const float *restrict first = line[0], *restrict second = line[1], *restrict third = line[2];
    for (size_t i = 0; i < count; i++)
        out[i] = first[i] + (second[i] + third[i]);
    for (int l = 3; l + 1 < lines; l += 2) {
        second = line[l];
        third = line[l + 1];
        for (size_t i = 0; i < count; i++)
            out[i] += second[i] + third[i];
    }
}
HDR_VERSIONS_IN(static, add_lines, (const float *const *line, int lines, float *out, size_t count),
                (line, lines, out, count))

/* What the pixels at some offset weigh, of the sums of distances: share and row make means of these. */
HDR_INLINE void weigh_body(const float *restrict sum, const float *restrict share, float row,
                           const float *restrict sound, float *restrict weight, size_t count) {
    for (size_t i = 0; i < count; i++) {
        float mean = sum[i] * (share[i] * row);
        weight[i] = hdr_exp_of_minus(mean > 0 ? mean : 0) * sound[i];
    }
}
HDR_VERSIONS_IN(static, weigh,
                (const float *sum, const float *share, float row, const float *sound, float *weight, size_t count),
                (sum, share, row, sound, weight, count))

HDR_INLINE void add_weighted_body(const float *restrict weight, const float *restrict other, const float *restrict own,
                                  float *restrict sum, size_t count) {
    for (size_t i = 0; i < count; i++)
        sum[i] += weight[i] * (other[i] - own[i]);
}
HDR_VERSIONS_IN(static, add_weighted,
                (const float *weight, const float *other, const float *own, float *sum, size_t count),
                (weight, other, own, sum, count))

HDR_INLINE void add_body(const float *restrict weight, float *restrict total, size_t count) {
    for (size_t i = 0; i < count; i++)
        total[i] += weight[i];
}
HDR_VERSIONS_IN(static, add, (const float *weight, float *total, size_t count), (weight, total, count))

/* ---- Offsets ---- */

typedef struct offset {
    int x, y;
    int first, end; /* the columns of pixels that have the one at the offset in their window, or are in its */
} offset;

/* How many of a patch's places, of 2 patch + 1, lie in the picture for both of two pixels: of one axis. */
static int pairs_of(int at, int other, int patch, int size) {
    int before = at < other ? at : other, behind = size - 1 - (at > other ? at : other);
    return 1 + (before < patch ? before : patch) + (behind < patch ? behind : patch);
}

/* The distances of one row. */
static void measure_row(const tile *t, const offset *o, int y, float *forth, float *back) {
    const hdr_nlmeans_room *room = t->room;
    int patch = t->filter->patch;
    size_t count = whole_lanes((size_t)(o->end - o->first + 2 * patch));
    size_t a = place(t, o->first - patch, y), b = place(t, o->first - patch + o->x, y + o->y);
    memset(forth, 0, count * sizeof *forth);
    memset(back, 0, count * sizeof *back);
    for (int c = 0; c < t->rows->channels; c++)
        add_distances(room->colour[c] + a, room->colour[c] + b, room->variance[c] + a, room->variance[c] + b, t->k2,
                      forth, back, count);
    if (!t->all_sound) mask(room->sound + a, room->sound + b, forth, back, count);
}

/* Adds the pixels `other`, at the offset x,y, to the sums of those of a row, columns first ... end-1. down: the sums of
 * distances over a patch's rows, from the column o->first - patch of a on. shift: from the pixel that sums are for to
 * a. */
static void add_row(const tile *t, const offset *o, int y, int first, int end, int shift, int other_x, int other_y,
                    float share) {
    hdr_nlmeans_room *room = t->room;
    int patch = t->filter->patch;
    size_t count = (size_t)(end - first), skipped = (size_t)(first + shift - o->first);
    const float *lines[MOST_LINES];
    for (int l = 0; l <= 2 * patch; l++)
        lines[l] = room->down + skipped + l;
    add_lines(lines, 2 * patch + 1, room->across, whole_lanes(count));
    size_t own = place(t, first, y), other = place(t, first + other_x, y + other_y);
    size_t to = (size_t)y * TILE_WIDTH + (size_t)first;
    weigh(room->across, room->share + skipped, share, room->sound + other, room->weight, whole_lanes(count));
    for (int c = 0; c < t->rows->channels; c++)
        add_weighted(room->weight, room->colour[c] + other, room->colour[c] + own, room->sums[c] + to, count);
    add(room->weight, room->total + to, count);
}

/* A row of pixels a, whose patches' distances are in the room's lines. */
static void use_lines(const tile *t, const offset *o, int y, int oldest) {
    const hdr_nlmeans_room *room = t->room;
    int patch = t->filter->patch, lines = 2 * patch + 1;
    size_t count = whole_lanes((size_t)(o->end - o->first + 2 * patch));
    float share = 1.0f / (float)(pairs_of(t->y + y, t->y + y + o->y, patch, t->rows->height) * t->rows->channels);
    for (int back = 0; back < 2; back++) {
        int own = back ? y + o->y : y;
        if (own < t->top || own >= t->bottom) continue;
        const float *line[MOST_LINES];
        for (int l = 0; l < lines; l++)
            line[l] = room->lines[back] + (size_t)((oldest + l) % lines) * room->stride;
        add_lines(line, lines, room->down, count);
        if (back)
            add_row(t, o, own, t->left, t->right, -o->x, -o->x, -o->y, share);
        else
            add_row(t, o, own, t->left, t->right, 0, o->x, o->y, share);
    }
}

/* True of a row in which the pixels a exist and one of the two roles is wanted. */
static bool is_used(const tile *t, const offset *o, int y) {
    bool in_picture = t->y + y >= 0 && t->y + y + o->y < t->rows->height;
    bool forth = y >= t->top && y < t->bottom, back = y + o->y >= t->top && y + o->y < t->bottom;
    return in_picture && (forth || back);
}

static void add_offset(const tile *t, int x, int y) {
    hdr_nlmeans_room *room = t->room;
    int patch = t->filter->patch, lines = 2 * patch + 1;
    offset o = {x, y, t->left - (x > 0 ? x : 0), t->right + (x < 0 ? -x : 0)};
    for (int column = o.first; column < o.end; column++) {
        int a = t->x + column, pairs = pairs_of(a, a + x, patch, t->rows->width);
        room->share[column - o.first] = 1.0f / (float)(pairs > 1 ? pairs : 1);
    }
    int first = t->top - y - patch, end = t->bottom + patch;
    for (int row = first; row < end; row++) {
        size_t line = (size_t)((row - first) % lines) * room->stride;
        measure_row(t, &o, row, room->lines[0] + line, room->lines[1] + line);
        if (row - first >= 2 * patch && is_used(t, &o, row - patch))
            use_lines(t, &o, row - patch, (row - first + 1) % lines);
    }
}

/* ---- Tiles ---- */

/* Finds what is wanted of the tile, and copies the rest. */
static uint64_t choose(tile *t) {
    const hdr_nlmeans_rows *rows = t->rows;
    uint64_t left_alone = 0;
    t->left = t->width, t->top = t->height, t->right = t->bottom = 0;
    for (int y = 0; y < t->height; y++)
        for (int x = 0; x < t->width; x++) {
            size_t at = hdr_nlmeans_place(rows, t->x + x, t->y + y);
            if (!hdr_nlmeans_is_wanted(t->filter, rows, at)) {
                left_alone++;
                continue;
            }
            t->left = x < t->left ? x : t->left;
            t->right = x >= t->right ? x + 1 : t->right;
            t->top = y < t->top ? y : t->top;
            t->bottom = y + 1;
        }
    if (t->filter->no_skip) t->left = t->top = 0, t->right = t->width, t->bottom = t->height;
    return left_alone;
}

static void finish(const tile *t) {
    const hdr_nlmeans_rows *rows = t->rows;
    for (int y = 0; y < t->height; y++)
        for (int x = 0; x < t->width; x++) {
            size_t at = hdr_nlmeans_place(rows, t->x + x, t->y + y);
            size_t to = (size_t)(t->y + y - rows->wanted_first) * (size_t)rows->width + (size_t)(t->x + x);
            size_t sum = (size_t)y * TILE_WIDTH + (size_t)x;
            bool wanted = hdr_nlmeans_is_wanted(t->filter, rows, at);
            for (int c = 0; c < rows->channels; c++) {
                rows->out[c][to] = rows->colour[c][at];
                if (!wanted) continue;
                double mean = (double)t->room->sums[c][sum] / (1 + (double)t->room->total[sum]);
                double value = (double)rows->colour[c][at] + mean * t->unit;
                hdr_real_to_float(&value, &rows->out[c][to], 1);
            }
        }
}

static uint64_t filter_tile(tile *t) {
    uint64_t left_alone = choose(t);
    bool empty = t->left >= t->right;
    if (!empty) load(t);
    for (int y = 0; !empty && y <= t->filter->radius; y++)
        for (int x = y ? -t->filter->radius : 1; x <= t->filter->radius; x++)
            add_offset(t, x, y);
    finish(t);
    return left_alone;
}

uint64_t hdr_nlmeans_filter(const hdr_nlmeans *filter, const hdr_nlmeans_rows *rows, hdr_nlmeans_room *room) {
    if (filter->reference) return hdr_nlmeans_exact(filter, rows);
    uint64_t left_alone = 0;
    for (int y = rows->wanted_first; y < rows->wanted_end; y += TILE_HEIGHT)
        for (int x = 0; x < rows->width; x += TILE_WIDTH) {
            tile t = {.filter = filter, .rows = rows, .room = room, .x = x, .y = y};
            t.k2 = (float)(filter->k * filter->k);
            t.width = rows->width - x < TILE_WIDTH ? rows->width - x : TILE_WIDTH;
            t.height = rows->wanted_end - y < TILE_HEIGHT ? rows->wanted_end - y : TILE_HEIGHT;
            left_alone += filter_tile(&t);
        }
    return left_alone;
}

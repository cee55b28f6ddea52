/* Luminance-chroma pictures as R, G, B, pixel for pixel as OpenEXR's RgbaInputFile has them.
 *
 * Chroma that is subsampled 2 x 2 is filtered along the rows, then across, with 27 taps, of which every second is 0: a
 * row depends on the 13 above and below. One more on either side goes into the last step, which takes colour from
 * pixels that are much more saturated than their neighbours. So a block is made of the stored blocks that it covers and
 * those around it; what a worker has of them from its last block it does not decode again.
 *
 * Above and below the picture RgbaInputFile takes the first row and the last but one (the last that holds chroma). */
#include "io/exr_yc.h"

#include "kernel/chroma.h"

#include <stdlib.h>
#include <string.h>

enum {
    LEAST_BLOCK_ROWS = 64, /* against 28 rows around it */
    ROWS_ABOVE = 14,       /* 13 for the row above the first, which the last step wants */
    ROWS_BELOW = 13,
    ASIDE = 8, /* floats in front of a row and behind it: enough for the filter, and rows stay aligned */
};

struct yc_source {
    hdr_source base;
    hdr_source *stored;
    int sampling;
    int64_t width, height;
    float weights[3]; /* Y = weights[0] R + weights[1] G + weights[2] B */
    int window_rows;  /* the most that a block is made of */
    size_t alpha_bytes;
};

/* R, G, B and saturation of one row, floats that a half can hold. saturation[-1] and [width] repeat their neighbours.
 */
struct colour_row {
    float *rgb[3], *saturation;
};

struct yc_worker {
    void *stored;
    unsigned char *memory;    /* of all that follows */
    float *luminance;         /* rows of the window */
    float *chroma[2];         /* the window's rows with chroma, each filled along */
    unsigned char *alpha;     /* rows of the window, as stored */
    float *samples;           /* a row of chroma samples and what stands beside it */
    float *between[2];        /* a row of chroma between two others */
    struct colour_row row[3]; /* row y in row[(y + 3) % 3] */
    uint16_t *out[3];         /* the block's R, G, B */
    int first_held, held;     /* stored blocks in the window: the first, and how many */
    int64_t window_first;     /* the picture's row that the window begins with */
};

/* ---- Colour ---- */

/* The Y row of RGB to XYZ, divided by its sum: SMPTE RP 177-1993 in float, each operation as in OpenEXR's RGBtoXYZ
 * (ImfChromaticities.cpp), so that the last bit is the same. */
static void luminance_weights(const hdr_chromaticities *primaries, float weights[3]) {
    float rx = (float)primaries->red[0], ry = (float)primaries->red[1];
    float gx = (float)primaries->green[0], gy = (float)primaries->green[1];
    float bx = (float)primaries->blue[0], by = (float)primaries->blue[1];
    float wx = (float)primaries->white[0], wy = (float)primaries->white[1];
    float x = wx / wy, z = (1 - wx - wy) / wy;
    float d = rx * (by - gy) + bx * (gy - ry) + gx * (ry - by);
    float r = ry - 1 + ry * (x + z), g = gy - 1 + gy * (x + z), b = by - 1 + by * (x + z);
    float red = (x * (by - gy) - gx * b + bx * g) / d * ry;
    float green = (x * (ry - by) + rx * b - bx * r) / d * gy;
    float blue = (x * (gy - ry) - rx * g + gx * r) / d * by;
    float sum = red + green + blue;
    weights[0] = red / sum;
    weights[1] = green / sum;
    weights[2] = blue / sum;
}

/* ---- The window ---- */

static size_t padded(const struct yc_source *source) {
    return ((size_t)source->width + 7) / 8 * 8;
}

/* One stretch of memory, cut up: *place grows by size bytes, a multiple of 64. Returns where they are. */
static unsigned char *cut(unsigned char *memory, size_t *place, size_t size) {
    unsigned char *at = memory ? memory + *place : NULL;
    *place += (size + 63) / 64 * 64;
    return at;
}

/* Cuts the worker's memory, or (memory == NULL) only counts its bytes. */
static size_t cut_memory(const struct yc_source *source, struct yc_worker *worker, unsigned char *memory) {
    size_t place = 0, row = padded(source) * sizeof(float);
    size_t rows = (size_t)source->window_rows, chroma_rows = rows / (size_t)source->sampling;
    worker->memory = memory;
    worker->luminance = (float *)(void *)cut(memory, &place, row * rows);
    worker->alpha = cut(memory, &place, source->alpha_bytes * rows);
    worker->samples = (float *)(void *)cut(memory, &place, row + 2 * ASIDE * sizeof(float));
    for (int c = 0; c < 2; c++) {
        worker->chroma[c] = (float *)(void *)cut(memory, &place, row * chroma_rows);
        worker->between[c] = (float *)(void *)cut(memory, &place, row);
    }
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++)
            worker->row[r].rgb[c] = (float *)(void *)cut(memory, &place, row);
        float *saturation = (float *)(void *)cut(memory, &place, row + 2 * ASIDE * sizeof(float));
        worker->row[r].saturation = saturation ? saturation + ASIDE : NULL;
    }
    for (int c = 0; c < 3; c++)
        worker->out[c] =
            (uint16_t *)(void *)cut(memory, &place, (size_t)source->width * 2 * (size_t)source->base.block_rows);
    return place;
}

/* A row of a stored plane in float. Float is rounded to half: RgbaInputFile reads it so. */
static void take_row(const hdr_block *block, int plane, int row, float *out, size_t count) {
    const unsigned char *at = block->plane[plane] + block->stride[plane] * (size_t)row;
    if (block->type[plane] == HDR_HALF)
        hdr_half_to_float((const uint16_t *)(const void *)at, out, count);
    else
        hdr_float_to_half_grid((const float *)(const void *)at, out, count);
}

/* A row of chroma with the samples between those that are stored. */
static void take_chroma(const struct yc_source *source, struct yc_worker *worker, const hdr_block *block, int c,
                        int row, float *out) {
    size_t count = (size_t)(source->width / source->sampling);
    float *samples = worker->samples + ASIDE;
    if (!block->plane[1 + c]) {
        memset(out, 0, (size_t)source->width * sizeof *out);
        return;
    }
    if (source->sampling == 1) {
        take_row(block, 1 + c, row, out, count);
        return;
    }
    take_row(block, 1 + c, row, samples, count);
    for (int i = 1; i <= HDR_CHROMA_BEFORE; i++)
        samples[-i] = samples[0];
    for (size_t i = 0; i < HDR_CHROMA_BEHIND; i++)
        samples[count + i] = samples[count - 1];
    hdr_chroma_across(samples, out, count);
}

/* Puts a stored block in its place in the window. */
static void take_block(const struct yc_source *source, struct yc_worker *worker, const hdr_block *block) {
    size_t pitch = padded(source), top = (size_t)(block->first_row - worker->window_first);
    for (int row = 0; row < block->rows; row++) {
        size_t to = top + (size_t)row;
        take_row(block, 0, row, worker->luminance + pitch * to, (size_t)source->width);
        if (source->alpha_bytes)
            memcpy(worker->alpha + source->alpha_bytes * to, block->plane[3] + block->stride[3] * (size_t)row,
                   source->alpha_bytes);
    }
    for (int c = 0; c < 2; c++)
        for (int row = 0; row < block->rows / source->sampling; row++)
            take_chroma(source, worker, block, c, row,
                        worker->chroma[c] + pitch * (top / (size_t)source->sampling + (size_t)row));
}

/* Moves what the window has of stored blocks first ... to its front, and forgets the rest. */
static void move_window(const struct yc_source *source, struct yc_worker *worker, int first) {
    int64_t stored_rows = source->stored->block_rows;
    int gone = first - worker->first_held;
    worker->window_first = first * stored_rows;
    worker->first_held = first;
    if (gone < 0 || gone >= worker->held) {
        worker->held = 0;
        return;
    }
    worker->held -= gone;
    if (gone == 0) return;
    size_t pitch = padded(source), from = (size_t)(gone * stored_rows), count = (size_t)(worker->held * stored_rows);
    size_t sampling = (size_t)source->sampling;
    memmove(worker->luminance, worker->luminance + pitch * from, pitch * count * sizeof(float));
    if (source->alpha_bytes)
        memmove(worker->alpha, worker->alpha + source->alpha_bytes * from, source->alpha_bytes * count);
    for (int c = 0; c < 2; c++)
        memmove(worker->chroma[c], worker->chroma[c] + pitch * (from / sampling),
                pitch * (count / sampling) * sizeof(float));
}

/* Sees to it that the window holds the picture's rows first ... last. */
static hdr_status fill_window(struct yc_source *source, struct yc_worker *worker, int64_t first, int64_t last,
                              hdr_error *err) {
    int64_t stored_rows = source->stored->block_rows;
    int first_block = (int)(first / stored_rows), end_block = (int)(last / stored_rows) + 1;
    move_window(source, worker, first_block);
    for (int index = first_block + worker->held; index < end_block; index++) {
        hdr_block block;
        hdr_status status = source->stored->read(source->stored, worker->stored, index, &block, err);
        if (status != HDR_OK) return status;
        if (!worker->memory) { /* only now that there are pixels */
            unsigned char *memory = aligned_alloc(64, cut_memory(source, worker, NULL));
            if (!memory) return hdr_fail(err, HDR_INTERNAL, "out of memory");
            cut_memory(source, worker, memory);
        }
        take_block(source, worker, &block);
        worker->held++;
    }
    return HDR_OK;
}

/* ---- Rows ---- */

/* The chroma of a row, from the rows around where it holds none itself. */
static void chroma_of_row(const struct yc_source *source, struct yc_worker *worker, int64_t row,
                          const float *chroma[2]) {
    size_t pitch = padded(source);
    int64_t sampling = source->sampling, first = worker->window_first / sampling, end = source->height / sampling;
    for (int c = 0; c < 2; c++) {
        if (sampling == 1 || row % 2 == 0) {
            chroma[c] = worker->chroma[c] + pitch * (size_t)(row / sampling - first);
            continue;
        }
        const float *around[HDR_CHROMA_TAPS];
        for (int t = 0; t < HDR_CHROMA_TAPS; t++) {
            int64_t from = (row - 1) / 2 - HDR_CHROMA_BEFORE + t; /* counting rows with chroma; row may be -1 */
            from = from < 0 ? 0 : from >= end ? end - 1 : from;
            around[t] = worker->chroma[c] + pitch * (size_t)(from - first);
        }
        hdr_chroma_down(around, worker->between[c], (size_t)source->width);
        chroma[c] = worker->between[c];
    }
}

/* R, G and B of a row of the picture, or of the one above or below it. */
static void make_colour(const struct yc_source *source, struct yc_worker *worker, int64_t row) {
    size_t width = (size_t)source->width;
    struct colour_row *to = &worker->row[(row + 3) % 3];
    const float *chroma[2];
    int64_t inside = row >= source->height ? source->height - 2 : row;
    chroma_of_row(source, worker, inside, chroma);
    if (inside < 0) inside = 0;
    const float *luminance = worker->luminance + padded(source) * (size_t)(inside - worker->window_first);
    hdr_chroma_to_rgb(luminance, chroma[0], chroma[1], source->weights, to->rgb, width);
    if (source->sampling == 1) return;
    hdr_rgb_saturation((const float *const *)to->rgb, to->saturation, width);
    to->saturation[-1] = to->saturation[0];
    to->saturation[width] = to->saturation[width - 1];
}

/* The block's row into the planes that are handed out. */
static void finish_row(const struct yc_source *source, const struct yc_worker *worker, int64_t row, size_t place) {
    size_t width = (size_t)source->width;
    const struct colour_row *at = &worker->row[row % 3];
    uint16_t *out[3];
    for (int c = 0; c < 3; c++)
        out[c] = worker->out[c] + width * place;
    if (source->sampling == 1) {
        for (int c = 0; c < 3; c++)
            hdr_half_grid_to_half(at->rgb[c], out[c], width);
        return;
    }
    hdr_fix_saturation((const float *const *)at->rgb, worker->row[(row + 2) % 3].saturation, at->saturation,
                       worker->row[(row + 1) % 3].saturation, source->weights, out, width);
}

/* ---- The source ---- */

static hdr_status read_block(hdr_source *base, void *context, int index, hdr_block *block, hdr_error *err) {
    struct yc_source *source = (struct yc_source *)base;
    struct yc_worker *worker = context;
    bool filtered = source->sampling == 2;
    int64_t first = (int64_t)index * base->block_rows, end = first + base->block_rows;
    end = end < source->height ? end : source->height;
    int64_t above = filtered ? first - ROWS_ABOVE : first, below = filtered ? end - 1 + ROWS_BELOW : end - 1;
    hdr_status status =
        fill_window(source, worker, above < 0 ? 0 : above, below < source->height ? below : source->height - 1, err);
    if (status != HDR_OK) return status;
    for (int64_t row = filtered ? first - 1 : first; row < (filtered ? end + 1 : end); row++) {
        make_colour(source, worker, row);
        int64_t ready = filtered ? row - 1 : row;
        if (ready >= first) finish_row(source, worker, ready, (size_t)(ready - first));
    }
    *block = (hdr_block){.first_row = (int)first, .rows = (int)(end - first)};
    for (int c = 0; c < 3; c++) {
        block->type[c] = HDR_HALF;
        block->plane[c] = (const unsigned char *)worker->out[c];
        block->stride[c] = (size_t)source->width * 2;
    }
    block->type[3] = base->picture.channels[3].type;
    if (!source->alpha_bytes) return HDR_OK;
    block->plane[3] = worker->alpha + source->alpha_bytes * (size_t)(first - worker->window_first);
    block->stride[3] = source->alpha_bytes;
    return HDR_OK;
}

static void worker_free(hdr_source *base, void *worker) {
    struct yc_source *source = (struct yc_source *)base;
    struct yc_worker *own = worker;
    if (!own) return;
    if (own->stored) source->stored->worker_free(source->stored, own->stored);
    free(own->memory);
    free(own);
}

static hdr_status worker_new(hdr_source *base, void **worker, hdr_error *err) {
    struct yc_source *source = (struct yc_source *)base;
    struct yc_worker *own = hdr_alloc(1, sizeof *own);
    *worker = NULL;
    if (!own) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    if (source->sampling == 1) { /* no filter that would look at the columns beside them */
        source->stored->first_column = base->first_column;
        source->stored->end_column = base->end_column;
    }
    hdr_status status = source->stored->worker_new(source->stored, &own->stored, err);
    if (status != HDR_OK) {
        worker_free(base, own);
        return status;
    }
    *worker = own;
    return HDR_OK;
}

static void close_source(hdr_source *base) {
    struct yc_source *source = (struct yc_source *)base;
    source->stored->close(source->stored);
    free(source);
}

/* Says what the picture becomes. */
static void describe(const struct yc_source *source, hdr_picture *picture) {
    static const char *const names[3] = {"R", "G", "B"};
    *picture = source->stored->picture;
    picture->planes = 3;
    for (int c = 0; c < 3; c++) {
        memcpy(picture->channels[c].name, names[c], sizeof "R");
        picture->channels[c].type = HDR_HALF;
        picture->present[c] = true;
    }
}

/* Chooses the blocks, and refuses a size whose window would not fit the memory allowed. */
static hdr_status lay_out(struct yc_source *source, const char *name, uint64_t memory, hdr_error *err) {
    int64_t stored_rows = source->stored->block_rows, rows = stored_rows, around = 0;
    if (source->sampling == 2) {
        rows = (LEAST_BLOCK_ROWS + stored_rows - 1) / stored_rows * stored_rows;
        around = 2 * ((ROWS_ABOVE + stored_rows - 1) / stored_rows * stored_rows);
    }
    if (source->sampling == 2 && stored_rows % 2 != 0)
        return hdr_fail(err, HDR_INTERNAL, "chroma in blocks of odd height");
    source->base.block_rows = (int)rows;
    source->base.blocks = (int)((source->height + rows - 1) / rows);
    int64_t most = (source->height + stored_rows - 1) / stored_rows * stored_rows;
    source->window_rows = (int)(rows + around < most ? rows + around : most);
    /* of a row: luminance and chroma in float, alpha, and three halves for the result */
    uint64_t row_bytes = (uint64_t)source->width * (3 * sizeof(float) + 4 + 6), bytes = 0;
    if (__builtin_mul_overflow(row_bytes, (uint64_t)source->window_rows + 24, &bytes) || bytes > memory)
        return hdr_fail(
            err, HDR_BAD_DATA,
            "%s: the header asks for %lld x %lld pixels of luminance and chroma: %d rows at once do not fit "
            "the memory allowed",
            name, (long long)source->width, (long long)source->height, source->window_rows);
    return HDR_OK;
}

hdr_source *hdr_yc_open(hdr_source *stored, int sampling, hdr_input *input, const hdr_reading *reading,
                        hdr_error *err) {
    struct yc_source *source = hdr_alloc(1, sizeof *source);
    if (!source) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        stored->close(stored);
        return NULL;
    }
    source->base.worker_new = worker_new;
    source->base.read = read_block;
    source->base.worker_free = worker_free;
    source->base.close = close_source;
    source->stored = stored;
    source->sampling = sampling;
    source->width = hdr_window_width(&stored->picture.data);
    source->height = hdr_window_height(&stored->picture.data);
    if (stored->picture.present[3])
        source->alpha_bytes = hdr_type_size(stored->picture.channels[3].type) * (size_t)source->width;
    describe(source, &source->base.picture);
    luminance_weights(&stored->picture.chromaticities, source->weights);
    if (lay_out(source, hdr_input_name(input), reading->memory, err) != HDR_OK) {
        close_source(&source->base);
        return NULL;
    }
    return &source->base;
}

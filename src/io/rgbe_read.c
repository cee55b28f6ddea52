/* The Radiance HDR source. Where a packed scanline begins is known only when the one before has been gone through, so
 * the file is gone through once, by run lengths and as far as it is needed, and the place of every 16th scanline is
 * kept: blocks are then decoded by any thread. A picture whose scanlines are columns is turned in memory. */
#include "io/rgbe.h"

#include "picture/colour.h"

#include <float.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GROUP = 16 }; /* scanlines; where they are rows, a group is a block */

struct rgbe_source {
    hdr_raster raster;
    hdr_rgbe_header header;
    int scanlines, length; /* how many, of how many pixels */
    double step[3][256];   /* what a component's mantissa counts, by exponent */
    pthread_mutex_t lock;  /* over all that follows */
    hdr_rgbe_stream scout; /* stands behind the last group that is known */
    uint64_t *start;       /* where groups begin; start[known] is set too */
    int known, room;
    unsigned char *turned; /* all pixels by rows, 4 bytes each; of a picture of columns, once it is wanted */
};

/* ---- Finding scanlines ---- */

/* Where rows are stored upwards, the block with fewer rows is the group that comes first. */
static int group_size(const struct rgbe_source *source, int group) {
    int groups = (source->scanlines - 1) / GROUP + 1, odd = source->scanlines - (groups - 1) * GROUP;
    bool odd_first = source->header.scanlines_backwards;
    return group == (odd_first ? 0 : groups - 1) ? odd : GROUP;
}

static int first_of_group(const struct rgbe_source *source, int group) {
    return group == 0 || !source->header.scanlines_backwards ? group * GROUP
                                                             : group_size(source, 0) + (group - 1) * GROUP;
}

static hdr_status scanline_fault(const struct rgbe_source *source, int scanline, const char *what, hdr_error *err) {
    const hdr_rgbe_header *header = &source->header;
    int place = header->scanlines_backwards ? source->scanlines - 1 - scanline : scanline;
    return hdr_fail(err, HDR_BAD_DATA, "%s: %s %d: %s", hdr_input_name(source->raster.input),
                    header->columns ? "column" : "row", place, what);
}

static hdr_status pass_over_group(struct rgbe_source *source, int group, hdr_error *err) {
    int first = first_of_group(source, group), count = group_size(source, group);
    if (group + 2 > source->room) {
        int room = 2 * group + 64;
        uint64_t *grown = hdr_grow(source->start, (size_t)room, sizeof *grown);
        if (!grown) return hdr_fail(err, HDR_INTERNAL, "out of memory");
        source->start = grown;
        source->room = room;
    }
    if (group == 0) source->start[0] = source->header.data;
    hdr_rgbe_stream *scout = &source->scout;
    hdr_error reading = {0};
    if (group == 0 || hdr_rgbe_place(scout) != source->start[group])
        hdr_rgbe_start(scout, source->raster.input, source->start[group], 0, NULL);
    scout->err = &reading;
    for (int i = first; i < first + count; i++) {
        /* a pipe may be waited for as long as there must be more: every scanline has at least one pixel's bytes */
        uint64_t to_come =
            hdr_input_size(source->raster.input) >= 0 ? UINT64_MAX : 4 * (uint64_t)(source->scanlines - i);
        uint64_t held = scout->have - scout->at;
        scout->least = to_come > held ? to_come - held : 0;
        const char *fault = hdr_rgbe_scanline(scout, source->length, NULL);
        if (reading.status) return hdr_fail(err, reading.status, "%s", reading.message);
        if (fault) return scanline_fault(source, i, fault, err);
    }
    source->start[group + 1] = hdr_rgbe_place(scout);
    source->known = group + 1;
    return HDR_OK;
}

/* With the lock held. */
static hdr_status find_group(struct rgbe_source *source, int group, hdr_error *err) {
    hdr_status status = HDR_OK;
    while (!status && source->known <= group)
        status = pass_over_group(source, source->known, err);
    return status;
}

/* ---- Decoding ---- */

/* Decodes a group whose place is known and hands on its scanlines. */
typedef void (*scanline_taker)(const struct rgbe_source *source, void *context, int scanline,
                               unsigned char *const component[4]);

static hdr_status decode_group(const struct rgbe_source *source, hdr_raster_worker *worker, int group, uint64_t from,
                               uint64_t to, scanline_taker taker, void *context, hdr_error *err) {
    size_t length = (size_t)source->length;
    hdr_status status = hdr_raster_bytes(worker, 4 * length + sizeof(hdr_rgbe_stream), err);
    if (status) return status;
    /* the stream first: the buffer is aligned for it */
    hdr_rgbe_stream *stream = (hdr_rgbe_stream *)(void *)worker->bytes;
    unsigned char *bytes = worker->bytes + sizeof *stream;
    unsigned char *const component[4] = {bytes, bytes + length, bytes + 2 * length, bytes + 3 * length};
    hdr_error reading = {0};
    hdr_rgbe_start(stream, source->raster.input, from, to - from, &reading);
    int first = first_of_group(source, group);
    for (int i = first; i < first + group_size(source, group); i++) {
        const char *fault = hdr_rgbe_scanline(stream, source->length, component);
        if (reading.status) return hdr_fail(err, reading.status, "%s", reading.message);
        if (fault) return scanline_fault(source, i, fault, err);
        taker(source, context, i, component);
    }
    return HDR_OK;
}

/* Mantissas to floats. The bytes of a component are apart by pitch; backwards: the last becomes the first. */
static void convert_row(const struct rgbe_source *source, const unsigned char *const component[4], size_t pitch,
                        bool backwards, float *const out[3]) {
    size_t width = (size_t)source->raster.width;
    const unsigned char *exponent = component[3];
    for (int c = 0; c < 3; c++)
        for (size_t x = 0; x < width; x++) {
            double value = component[c][x * pitch] * source->step[c][exponent[x * pitch]];
            out[c][backwards ? width - 1 - x : x] = (float)(value < (double)FLT_MAX ? value : (double)FLT_MAX);
        }
}

/* Where the rows of a block go. */
struct rows {
    int first_row;
    float *plane[4];
};

static void take_row(const struct rgbe_source *source, void *context, int scanline, unsigned char *const component[4]) {
    const struct rows *rows = context;
    int row = source->header.scanlines_backwards ? source->scanlines - 1 - scanline : scanline;
    size_t at = (size_t)(row - rows->first_row) * (size_t)source->raster.width;
    float *const out[3] = {rows->plane[0] + at, rows->plane[1] + at, rows->plane[2] + at};
    convert_row(source, (const unsigned char *const *)component, 1, source->header.pixels_backwards, out);
}

static void take_column(const struct rgbe_source *source, void *context, int scanline,
                        unsigned char *const component[4]) {
    unsigned char *turned = context;
    size_t width = (size_t)source->raster.width, height = (size_t)source->raster.height;
    size_t x = (size_t)(source->header.scanlines_backwards ? source->scanlines - 1 - scanline : scanline);
    for (size_t i = 0; i < height; i++) {
        size_t y = source->header.pixels_backwards ? height - 1 - i : i;
        for (size_t c = 0; c < 4; c++)
            turned[4 * (y * width + x) + c] = component[c][i];
    }
}

/* With the lock held. Nothing is allocated before all scanlines have been gone through. */
static hdr_status turn(struct rgbe_source *source, hdr_raster_worker *worker, hdr_error *err) {
    int groups = (source->scanlines - 1) / GROUP + 1;
    hdr_status status = find_group(source, groups - 1, err);
    if (status || source->turned) return status;
    size_t width = (size_t)source->raster.width, height = (size_t)source->raster.height;
    unsigned char *turned = hdr_grow(NULL, 4 * width, height);
    if (!turned) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    for (int g = 0; !status && g < groups; g++)
        status = decode_group(source, worker, g, source->start[g], source->start[g + 1], take_column, turned, err);
    if (status)
        free(turned);
    else
        source->turned = turned;
    return status;
}

static hdr_status read_turned(struct rgbe_source *source, hdr_raster_worker *worker, const struct rows *rows, int count,
                              hdr_error *err) {
    pthread_mutex_lock(&source->lock);
    hdr_status status = turn(source, worker, err);
    pthread_mutex_unlock(&source->lock);
    size_t width = (size_t)source->raster.width;
    for (int i = 0; !status && i < count; i++) {
        const unsigned char *from = source->turned + 4 * width * (size_t)(rows->first_row + i);
        const unsigned char *const component[4] = {from, from + 1, from + 2, from + 3};
        float *const out[3] = {rows->plane[0] + width * (size_t)i, rows->plane[1] + width * (size_t)i,
                               rows->plane[2] + width * (size_t)i};
        convert_row(source, component, 4, false, out);
    }
    return status;
}

static hdr_status read_rows(struct rgbe_source *source, hdr_raster_worker *worker, int group, struct rows *rows,
                            hdr_error *err) {
    pthread_mutex_lock(&source->lock);
    hdr_status status = find_group(source, group, err);
    uint64_t from = status ? 0 : source->start[group], to = status ? 0 : source->start[group + 1];
    pthread_mutex_unlock(&source->lock);
    return status ? status : decode_group(source, worker, group, from, to, take_row, rows, err);
}

/* The planes get their room only when the block's bytes are known to be there. */
static hdr_status read_block(hdr_source *base, void *worker, int index, hdr_block *block, hdr_error *err) {
    struct rgbe_source *source = (struct rgbe_source *)base;
    struct rows rows = {.first_row = index * GROUP};
    int group = source->header.scanlines_backwards ? base->blocks - 1 - index : index;
    pthread_mutex_lock(&source->lock);
    hdr_status status = source->header.columns ? find_group(source, (source->scanlines - 1) / GROUP, err)
                                               : find_group(source, group, err);
    pthread_mutex_unlock(&source->lock);
    if (!status) status = hdr_raster_block(&source->raster, worker, index, block, rows.plane, err);
    if (status) return status;
    if (source->header.columns) return read_turned(source, worker, &rows, block->rows, err);
    return read_rows(source, worker, group, &rows, err);
}

/* ---- The source ---- */

static void close_source(hdr_source *base) {
    struct rgbe_source *source = (struct rgbe_source *)base;
    pthread_mutex_destroy(&source->lock);
    free(source->start);
    free(source->turned);
    free(source);
}

/* A component is mantissa * 2^(exponent - 136), and 0 where the exponent is. Radiance itself adds half a step to the
 * mantissa, since it cuts it off when it writes; nearly all others do not, and so 0 stays 0, and a value that was
 * written is read as it was. */
static void fill_steps(struct rgbe_source *source) {
    for (int c = 0; c < 3; c++)
        for (int exponent = 1; exponent < 256; exponent++)
            source->step[c][exponent] = ldexp(1, exponent - HDR_RGBE_BIAS) / source->header.exposure[c];
}

static void describe(struct rgbe_source *source) {
    hdr_picture *picture = &source->raster.base.picture;
    const hdr_rgbe_header *header = &source->header;
    double aspect = 1 / header->pixel_height;
    if (aspect > (double)FLT_MIN && aspect < (double)FLT_MAX) picture->pixel_aspect = (float)aspect;
    picture->has_chromaticities = header->xyz || header->has_primaries;
    if (picture->has_chromaticities) picture->chromaticities = header->xyz ? hdr_cie_xyz : header->primaries;
    snprintf(picture->compression, sizeof picture->compression, "rle");
}

static hdr_status open_source(struct rgbe_source *source, hdr_input *input, uint64_t memory, hdr_error *err) {
    static const char *const rgb[4] = {"R", "G", "B", NULL}, *const xyz[4] = {"X", "Y", "Z", NULL};
    hdr_rgbe_header *header = &source->header;
    hdr_status status = hdr_rgbe_header_read(input, header, err);
    if (!status)
        status = hdr_raster_open(&source->raster, input, header->width, header->height, "rgbe", header->xyz ? xyz : rgb,
                                 memory, err);
    if (status) return status;
    source->raster.base.read = read_block;
    source->raster.base.close = close_source;
    source->scanlines = header->columns ? header->width : header->height;
    source->length = header->columns ? header->height : header->width;
    const char *name = hdr_input_name(input);
    if (header->columns && (uint64_t)header->width * (uint64_t)header->height > memory / 4)
        return hdr_fail(err, HDR_BAD_DATA,
                        "%s: %d x %d pixels that are stored by columns do not fit the memory allowed", name,
                        header->width, header->height);
    if (!hdr_raster_reaches(&source->raster, header->data + 4 * (uint64_t)source->scanlines, err))
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header asks for %d x %d pixels, more than the file can hold", name,
                        header->width, header->height);
    describe(source);
    fill_steps(source);
    return HDR_OK;
}

hdr_source *hdr_rgbe_open(hdr_input *input, const hdr_reading *reading, hdr_error *err) {
    struct rgbe_source *source = hdr_alloc(1, sizeof *source);
    if (!source || pthread_mutex_init(&source->lock, NULL) != 0) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        free(source);
        return NULL;
    }
    if (open_source(source, input, reading->memory, err) == HDR_OK) return &source->raster.base;
    close_source(&source->raster.base);
    return NULL;
}

#include "io/raster.h"

#include "picture/colour.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK_ROWS = 16, LINE_STEP = 128, LINE_MOST = 64 * 1024, HEADER_MOST = 1024 * 1024 };

/* ---- The header ---- */

hdr_status hdr_header_fault(const hdr_input *input, const char *what, hdr_error *err) {
    return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: %s", hdr_input_name(input), what);
}

/* Small steps: from a pipe, no more is waited for than a header's line may have. */
hdr_status hdr_lines_next(hdr_lines *lines, bool cut, hdr_error *err) {
    char step[LINE_STEP];
    size_t length = 0;
    uint64_t start = lines->offset;
    if (start > HEADER_MOST) return hdr_header_fault(lines->input, "it is longer than 1 MiB", err);
    for (;;) {
        int64_t count = hdr_input_read(lines->input, step, sizeof step, lines->offset, err);
        if (count < 0) return HDR_IO;
        if (count == 0)
            return hdr_fail(err, HDR_BAD_DATA, "%s: the file ends within its header", hdr_input_name(lines->input));
        const char *end = memchr(step, '\n', (size_t)count);
        size_t size = end ? (size_t)(end - step) : (size_t)count;
        size_t room = sizeof lines->text - 1 - length, taken = size < room ? size : room;
        if ((taken < size && !cut) || lines->offset + size - start > LINE_MOST)
            return hdr_header_fault(lines->input, "a line is too long", err);
        memcpy(lines->text + length, step, taken);
        length += taken;
        lines->text[length] = '\0';
        lines->offset += size + (end ? 1 : 0);
        if (end) return HDR_OK;
    }
}

bool hdr_text_integer(const char **text, int *value) {
    const char *at = *text;
    int64_t number = 0;
    while (*at == ' ' || *at == '\t')
        at++;
    const char *digits = at;
    for (; *at >= '0' && *at <= '9'; at++) {
        number = 10 * number + (*at - '0');
        if (number > INT32_MAX) return false;
    }
    if (at == digits) return false;
    *value = (int)number;
    *text = at;
    return true;
}

bool hdr_text_ends(const char *text) {
    return text[strspn(text, " \t\r\n")] == '\0';
}

/* ---- The source ---- */

static hdr_status worker_new(hdr_source *source, void **worker, hdr_error *err) {
    (void)source;
    *worker = hdr_alloc(1, sizeof(hdr_raster_worker));
    return *worker ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
}

static void worker_free(hdr_source *source, void *worker) {
    hdr_raster_worker *own = worker;
    (void)source;
    if (!own) return;
    free(own->bytes);
    free(own->samples);
    free(own);
}

hdr_status hdr_raster_open(hdr_raster *raster, hdr_input *input, int width, int height, const char *format,
                           const char *const names[4], uint64_t memory, hdr_error *err) {
    hdr_picture *picture = &raster->base.picture;
    size_t planes = 0;
    for (int p = 0; p < 4; p++) {
        picture->present[p] = names[p] != NULL;
        picture->channels[p].type = HDR_FLOAT;
        if (!names[p]) continue;
        snprintf(picture->channels[p].name, HDR_CHANNEL_NAME, "%s", names[p]);
        planes++;
    }
    if (width < 1 || height < 1) return hdr_header_fault(input, "no pixels", err);
    int rows = height < BLOCK_ROWS ? height : BLOCK_ROWS;
    uint64_t block_bytes = (uint64_t)width * (uint64_t)rows * planes * sizeof(float); /* below 2^41 */
    if (block_bytes > memory)
        return hdr_fail(err, HDR_BAD_DATA,
                        "%s: the header asks for %d x %d pixels: %d rows at once do not fit the memory allowed",
                        hdr_input_name(input), width, height, rows);
    raster->input = input;
    raster->width = width;
    raster->height = height;
    raster->base.block_rows = BLOCK_ROWS;
    raster->base.blocks = (height - 1) / BLOCK_ROWS + 1;
    raster->base.worker_new = worker_new;
    raster->base.worker_free = worker_free;
    picture->data = picture->display = (hdr_window){0, 0, width - 1, height - 1};
    picture->planes = names[1] ? 3 : 1;
    picture->has_alpha = names[3] != NULL;
    picture->chromaticities = hdr_rec709;
    picture->pixel_aspect = 1;
    snprintf(picture->state, sizeof picture->state, "linear");
    snprintf(picture->format, sizeof picture->format, "%s", format);
    snprintf(picture->storage, sizeof picture->storage, "scan-line");
    snprintf(picture->compression, sizeof picture->compression, "none");
    return HDR_OK;
}

bool hdr_raster_reaches(const hdr_raster *raster, uint64_t end, hdr_error *err) {
    char last;
    return end == 0 || hdr_input_read(raster->input, &last, 1, end - 1, err) == 1;
}

hdr_status hdr_raster_bytes(hdr_raster_worker *worker, size_t size, hdr_error *err) {
    if (size <= worker->bytes_room) return HDR_OK;
    free(worker->bytes);
    worker->bytes = hdr_alloc(size, 1);
    worker->bytes_room = worker->bytes ? size : 0;
    return worker->bytes ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "out of memory");
}

hdr_status hdr_raster_block(const hdr_raster *raster, hdr_raster_worker *worker, int index, hdr_block *block,
                            float *plane[4], hdr_error *err) {
    int first = index * BLOCK_ROWS, left = raster->height - first;
    *block = (hdr_block){.first_row = first, .rows = left < BLOCK_ROWS ? left : BLOCK_ROWS};
    size_t plane_size = (size_t)raster->width * (size_t)block->rows, planes = 0;
    for (int p = 0; p < 4; p++)
        planes += raster->base.picture.present[p];
    if (plane_size * planes > worker->samples_room) {
        free(worker->samples);
        worker->samples = hdr_alloc(plane_size * planes, sizeof(float));
        worker->samples_room = worker->samples ? plane_size * planes : 0;
        if (!worker->samples) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    }
    float *at = worker->samples;
    for (int p = 0; p < 4; p++) {
        block->type[p] = HDR_FLOAT;
        plane[p] = NULL;
        if (!raster->base.picture.present[p]) continue;
        plane[p] = at;
        block->plane[p] = (const unsigned char *)at;
        block->stride[p] = (size_t)raster->width * sizeof(float);
        at += plane_size;
    }
    return HDR_OK;
}

hdr_status hdr_raster_read(const hdr_raster *raster, void *to, size_t size, uint64_t offset, int first, int last,
                           hdr_error *err) {
    int64_t count = hdr_input_read(raster->input, to, size, offset, err);
    if (count < 0) return HDR_IO;
    if ((uint64_t)count == size) return HDR_OK;
    return hdr_fail(err, HDR_BAD_DATA, "%s: rows %d to %d: the file ends before them", hdr_input_name(raster->input),
                    first, last);
}

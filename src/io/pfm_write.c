/* The PFM sink: a line of text with the size, then float rows from the bottom one up. */
#include "io/sink.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct pfm_sink {
    hdr_sink sink; /* first, so that the one pointer is the other */
    uint64_t head_size;
} pfm_sink;

typedef struct pfm_packer {
    unsigned char *rows; /* of a band, as the file has them */
    size_t room, size;
    int below; /* rows of the picture that lie below the band, and before it in the file */
} pfm_packer;

/* The scale's sign says little-endian. */
static hdr_status pfm_begin(hdr_sink *sink, hdr_error *err) {
    pfm_sink *self = (pfm_sink *)sink;
    char head[64];
    int length = snprintf(head, sizeof head, "%s\n%d %d\n-1.0\n", sink->frame.planes == 3 ? "PF" : "Pf",
                          sink->frame.width, sink->frame.height);
    self->head_size = (uint64_t)length;
    return hdr_output_write(sink->output, head, (size_t)length, 0, err);
}

static hdr_status pfm_packer_new(hdr_sink *sink, void **packer, hdr_error *err) {
    *packer = hdr_alloc(1, sizeof(pfm_packer));
    return *packer ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "%s: out of memory", hdr_output_name(sink->output));
}

static void pfm_packer_free(hdr_sink *sink, void *packer) {
    pfm_packer *self = packer;
    (void)sink;
    if (!self) return;
    free(self->rows);
    free(self);
}

/* Three planes of a row to pixels. */
static void interleave_row(unsigned char *out, const unsigned char *in, size_t width) {
    size_t plane = width * sizeof(float);
    for (size_t x = 0; x < width; x++)
        for (size_t c = 0; c < 3; c++)
            memcpy(out + (3 * x + c) * sizeof(float), in + c * plane + x * sizeof(float), sizeof(float));
}

static hdr_status pfm_pack(hdr_sink *sink, void *packer, int first_row, int rows, void *samples, hdr_error *err) {
    pfm_packer *self = packer;
    size_t row_bytes = hdr_frame_row_bytes(&sink->frame);
    self->size = row_bytes * (size_t)rows;
    self->below = sink->frame.height - first_row - rows;
    if (self->size > self->room) {
        unsigned char *grown = hdr_grow(self->rows, self->size, 1);
        if (!grown) return hdr_fail(err, HDR_INTERNAL, "%s: out of memory", hdr_output_name(sink->output));
        self->rows = grown;
        self->room = self->size;
    }
    const unsigned char *in = samples;
    for (unsigned char *out = self->rows + self->size; out > self->rows; in += row_bytes) {
        out -= row_bytes;
        if (sink->frame.planes == 3)
            interleave_row(out, in, (size_t)sink->frame.width);
        else
            memcpy(out, in, row_bytes);
    }
    return HDR_OK;
}

static hdr_status pfm_deliver(hdr_sink *sink, void *packer, hdr_error *err) {
    const pfm_sink *self = (const pfm_sink *)sink;
    const pfm_packer *band = packer;
    uint64_t offset = self->head_size + (uint64_t)band->below * hdr_frame_row_bytes(&sink->frame);
    return hdr_output_write(sink->output, band->rows, band->size, offset, err);
}

hdr_sink *hdr_pfm_create(hdr_output *output, const hdr_frame *frame, hdr_error *err) {
    pfm_sink *self = hdr_alloc(1, sizeof *self);
    if (!self) {
        hdr_fail(err, HDR_INTERNAL, "%s: out of memory", hdr_output_name(output));
        return NULL;
    }
    self->sink = (hdr_sink){.frame = *frame,
                            .output = output,
                            .band_multiple = 1,
                            .begin = pfm_begin,
                            .packer_new = pfm_packer_new,
                            .pack = pfm_pack,
                            .deliver = pfm_deliver,
                            .packer_free = pfm_packer_free,
                            .end = hdr_sink_end_plainly,
                            .close = hdr_sink_close_plainly};
    return &self->sink;
}

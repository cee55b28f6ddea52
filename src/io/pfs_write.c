/* The PFS sink: planes of X, Y and Z, and of alpha, for the programs of pfstools. */
#include "io/sink.h"

#include "picture/colour.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE_MAX = 65535 }; /* pfstools refuses more */

typedef struct pfs_sink {
    hdr_sink sink; /* first, so that the one pointer is the other */
    uint64_t head_size;
    double to_xyz[9];
} pfs_sink;

typedef struct pfs_packer {
    unsigned char *planes; /* of a band: all rows of one channel and then all of the next */
    size_t room;
    int first_row, rows;
} pfs_packer;

/* X, Y, Z in any case: most of pfstools does not take Y alone. */
static size_t channel_count(const hdr_frame *frame) {
    return frame->alpha ? 4 : 3;
}

static size_t row_size(const hdr_frame *frame) {
    return (size_t)frame->width * sizeof(float);
}

static hdr_status pfs_begin(hdr_sink *sink, hdr_error *err) {
    pfs_sink *self = (pfs_sink *)sink;
    char head[256];
    bool linear = strcmp(sink->frame.state, "linear") == 0;
    int length = snprintf(head, sizeof head, "PFS1\n%d %d\n%zu\n1\nLUMINANCE=%s\nX\n0\nY\n0\nZ\n0\n%sENDH",
                          sink->frame.width, sink->frame.height, channel_count(&sink->frame),
                          linear ? "RELATIVE" : "DISPLAY", sink->frame.alpha ? "ALPHA\n0\n" : "");
    self->head_size = (uint64_t)length;
    return hdr_output_write(sink->output, head, (size_t)length, 0, err);
}

static hdr_status pfs_packer_new(hdr_sink *sink, void **packer, hdr_error *err) {
    *packer = hdr_alloc(1, sizeof(pfs_packer));
    return *packer ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "%s: out of memory", hdr_output_name(sink->output));
}

static void pfs_packer_free(hdr_sink *sink, void *packer) {
    pfs_packer *self = packer;
    (void)sink;
    if (!self) return;
    free(self->planes);
    free(self);
}

static float hold(double value) {
    return (float)fmax(fmin(value, (double)FLT_MAX), -(double)FLT_MAX);
}

/* A row of samples to one of each of X, Y and Z, which are pitch bytes apart. */
static void convert_row(const pfs_sink *self, const unsigned char *in, unsigned char *out, size_t pitch) {
    const hdr_frame *frame = &self->sink.frame;
    size_t plane = row_size(frame);
    for (size_t x = 0; x < plane; x += sizeof(float)) {
        float c[3];
        for (size_t p = 0; p < 3; p++)
            memcpy(&c[p], in + (frame->planes == 3 ? p : 0) * plane + x, sizeof(float));
        for (size_t p = 0; p < 3; p++) {
            const double *m = self->to_xyz + 3 * p;
            float value = hold(m[0] * (double)c[0] + m[1] * (double)c[1] + m[2] * (double)c[2]);
            /* a grey picture is its own luminance, to the bit */
            if (p == 1 && frame->planes == 1) value = c[0];
            memcpy(out + p * pitch + x, &value, sizeof value);
        }
    }
}

static hdr_status pfs_pack(hdr_sink *sink, void *packer, int first_row, int rows, void *samples, hdr_error *err) {
    const pfs_sink *self = (const pfs_sink *)sink;
    pfs_packer *band = packer;
    const hdr_frame *frame = &sink->frame;
    size_t row = row_size(frame), pitch = row * (size_t)rows, size = pitch * channel_count(frame);
    if (size > band->room) {
        unsigned char *grown = hdr_grow(band->planes, size, 1);
        if (!grown) return hdr_fail(err, HDR_INTERNAL, "%s: out of memory", hdr_output_name(sink->output));
        band->planes = grown;
        band->room = size;
    }
    band->first_row = first_row;
    band->rows = rows;
    for (size_t i = 0; i < (size_t)rows; i++) {
        const unsigned char *in = (const unsigned char *)samples + hdr_frame_row_bytes(frame) * i;
        convert_row(self, in, band->planes + row * i, pitch);
        if (frame->alpha) memcpy(band->planes + 3 * pitch + row * i, in + (size_t)frame->planes * row, row);
    }
    return HDR_OK;
}

static hdr_status pfs_deliver(hdr_sink *sink, void *packer, hdr_error *err) {
    const pfs_sink *self = (const pfs_sink *)sink;
    const pfs_packer *band = packer;
    size_t row = row_size(&sink->frame), size = row * (size_t)band->rows;
    hdr_status status = HDR_OK;
    for (size_t p = 0; !status && p < channel_count(&sink->frame); p++) {
        uint64_t rows_before = (uint64_t)sink->frame.height * p + (uint64_t)band->first_row;
        status =
            hdr_output_write(sink->output, band->planes + size * p, size, self->head_size + rows_before * row, err);
    }
    return status;
}

hdr_sink *hdr_pfs_create(hdr_output *output, const hdr_frame *frame, hdr_error *err) {
    const char *name = hdr_output_name(output);
    if (frame->width > SIDE_MAX || frame->height > SIDE_MAX) {
        hdr_fail(err, HDR_BAD_DATA, "%s: %d x %d pixels; a PFS stream holds at most 65535 x 65535", name, frame->width,
                 frame->height);
        return NULL;
    }
    pfs_sink *self = hdr_alloc(1, sizeof *self);
    /* Encoded values are taken back by the matrix that all of pfstools has. Grey is that of D65, which they take for
     * white, whatever white the file had: it has no colour of its own. */
    bool own = frame->has_chromaticities && frame->planes == 3 && strcmp(frame->state, "linear") == 0;
    const hdr_chromaticities *primaries = own ? &frame->chromaticities : &hdr_rec709;
    if (!self || !hdr_matrix_to_xyz(primaries, self->to_xyz)) {
        hdr_fail(err, self ? HDR_BAD_DATA : HDR_INTERNAL, "%s: %s", name,
                 self ? "the chromaticities span no triangle" : "out of memory");
        free(self);
        return NULL;
    }
    self->sink = (hdr_sink){.frame = *frame,
                            .output = output,
                            .band_multiple = 1,
                            .begin = pfs_begin,
                            .packer_new = pfs_packer_new,
                            .pack = pfs_pack,
                            .deliver = pfs_deliver,
                            .packer_free = pfs_packer_free,
                            .end = hdr_sink_end_plainly,
                            .close = hdr_sink_close_plainly};
    return &self->sink;
}

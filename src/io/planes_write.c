/* The sink that leaves pixels in memory: an output's planes, one behind the other. */
#include "io/sink.h"

#include <stdlib.h>

/* A band stays where it was made until it is delivered, which the same thread does next. */
typedef struct planes_packer {
    const unsigned char *samples;
    int first_row, rows;
} planes_packer;

static hdr_status planes_begin(hdr_sink *sink, hdr_error *err) {
    const hdr_frame *frame = &sink->frame;
    (void)err;
    hdr_output_describe(sink->output, frame->width, frame->height, frame->planes, frame->alpha);
    return HDR_OK;
}

static hdr_status planes_packer_new(hdr_sink *sink, void **packer, hdr_error *err) {
    *packer = hdr_alloc(1, sizeof(planes_packer));
    return *packer ? HDR_OK : hdr_fail(err, HDR_INTERNAL, "%s: out of memory", hdr_output_name(sink->output));
}

static void planes_packer_free(hdr_sink *sink, void *packer) {
    (void)sink;
    free(packer);
}

static hdr_status planes_pack(hdr_sink *sink, void *packer, int first_row, int rows, void *samples, hdr_error *err) {
    (void)sink, (void)err;
    *(planes_packer *)packer = (planes_packer){.samples = samples, .first_row = first_row, .rows = rows};
    return HDR_OK;
}

static hdr_status planes_deliver(hdr_sink *sink, void *packer, hdr_error *err) {
    const planes_packer *band = packer;
    size_t row_bytes = (size_t)sink->frame.width * sizeof(float), channels = (size_t)hdr_frame_channels(&sink->frame);
    uint64_t plane_bytes = (uint64_t)row_bytes * (uint64_t)sink->frame.height;
    const unsigned char *in = band->samples;
    for (int row = 0; row < band->rows; row++)
        for (size_t c = 0; c < channels; c++, in += row_bytes) {
            uint64_t offset = c * plane_bytes + (uint64_t)(band->first_row + row) * row_bytes;
            hdr_status status = hdr_output_write(sink->output, in, row_bytes, offset, err);
            if (status != HDR_OK) return status;
        }
    return HDR_OK;
}

hdr_sink *hdr_planes_create(hdr_output *output, const hdr_frame *frame, hdr_error *err) {
    hdr_sink *sink = hdr_alloc(1, sizeof *sink);
    if (!sink) {
        hdr_fail(err, HDR_INTERNAL, "%s: out of memory", hdr_output_name(output));
        return NULL;
    }
    *sink = (hdr_sink){.frame = *frame,
                       .output = output,
                       .band_multiple = 1,
                       .begin = planes_begin,
                       .packer_new = planes_packer_new,
                       .pack = planes_pack,
                       .deliver = planes_deliver,
                       .packer_free = planes_packer_free,
                       .end = hdr_sink_end_plainly,
                       .close = hdr_sink_close_plainly};
    return sink;
}

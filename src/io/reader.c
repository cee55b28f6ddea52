#include "io/reader.h"

#include "kernel/strip.h"

#include <math.h>

hdr_status hdr_reader_open(hdr_reader *reader, hdr_source *source, int64_t first_column, int64_t end_column,
                           hdr_error *err) {
    *reader = (hdr_reader){.source = source, .current = -1};
    hdr_status status = source->worker_new(source, &reader->worker, err);
    if (status == HDR_OK && source->tile_columns > 0 && end_column > 0)
        source->worker_columns(reader->worker, first_column, end_column);
    return status;
}

void hdr_reader_close(hdr_reader *reader) {
    if (reader->worker) reader->source->worker_free(reader->source, reader->worker);
    reader->worker = NULL;
}

hdr_status hdr_reader_seek(hdr_reader *reader, int row, hdr_error *err) {
    int wanted = hdr_source_block_of(reader->source, row);
    if (wanted == reader->current) return HDR_OK;
    reader->current = -1;
    hdr_status status = reader->source->read(reader->source, reader->worker, wanted, &reader->block, err);
    if (status == HDR_OK) reader->current = wanted;
    return status;
}

uint64_t hdr_block_load(const hdr_block *block, int channel, int row, size_t x, double *out, size_t count) {
    const unsigned char *at = block->plane[channel] + (size_t)row * block->stride[channel];
    if (block->type[channel] == HDR_HALF) {
        const uint16_t *half = (const uint16_t *)(const void *)at + x;
        if (hdr_half_all_finite(half, count)) {
            hdr_half_to_real(half, out, count);
            return 0;
        }
        for (size_t i = 0; i < count; i++)
            out[i] = hdr_half_value(half[i]);
    } else if (block->type[channel] == HDR_UINT) {
        const uint32_t *values = (const uint32_t *)(const void *)at + x;
        for (size_t i = 0; i < count; i++)
            out[i] = values[i];
        return 0;
    } else {
        const float *values = (const float *)(const void *)at + x;
        hdr_float_to_real(values, out, count);
        if (hdr_float_all_finite(values, count)) return 0;
    }
    uint64_t strange = 0;
    for (size_t i = 0; i < count; i++)
        strange += !isfinite(out[i]);
    return strange;
}

/* Unpacking EXR chunks: ZIP and ZIPS by libdeflate, twice as fast as the library's zlib, RLE here, since it is a dozen
 * lines that share the predictor with ZIP, DWAA and DWAB by the plug-in where OpenEXRCore does not have them, and the
 * rest by OpenEXRCore's decoders.
 *
 * Of the library's decode pipeline only the decompression step is called, on buffers that are ours. The pipeline's own
 * handling of them lets the unpacked buffer be the packed one where both have the same size, which then outlives a
 * change of size. */
#include "io/exr_unpack.h"

#include "io/exr_dwa.h"
#include "io/exr_sampling.h"
#include "kernel/predictor.h"

#include <libdeflate.h>
#include <stdlib.h>
#include <string.h>

struct hdr_exr_unpacker {
    const hdr_exr_header *header;
    unsigned char *scratch; /* inflated, before the predictor */
    size_t scratch_room;
    struct libdeflate_decompressor *inflater;
    exr_decode_pipeline_t pipeline;
    bool pipeline_made;
    hdr_exr_dwa *dwa; /* where it is needed */
};

hdr_exr_unpacker *hdr_exr_unpacker_new(const hdr_exr_header *header, hdr_error *err) {
    hdr_exr_unpacker *unpacker = hdr_alloc(1, sizeof *unpacker);
    if (unpacker) {
        unpacker->header = header;
        unpacker->inflater = libdeflate_alloc_decompressor();
    }
    if (!unpacker || !unpacker->inflater) {
        hdr_exr_unpacker_free(unpacker);
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        return NULL;
    }
    const exr_attr_chlist_t *channels;
    if (hdr_exr_needs_dwa(header->compression)) {
        if (exr_get_channels(header->context, 0, &channels) == EXR_ERR_SUCCESS)
            unpacker->dwa = hdr_exr_dwa_new(header->compression, channels, err);
        else
            hdr_fail(err, HDR_INTERNAL, "the channels are gone");
        if (!unpacker->dwa) {
            hdr_exr_unpacker_free(unpacker);
            return NULL;
        }
    }
    return unpacker;
}

void hdr_exr_unpacker_free(hdr_exr_unpacker *unpacker) {
    if (!unpacker) return;
    if (unpacker->pipeline_made) exr_decoding_destroy(unpacker->header->context, &unpacker->pipeline);
    if (unpacker->inflater) libdeflate_free_decompressor(unpacker->inflater);
    hdr_exr_dwa_free(unpacker->dwa);
    free(unpacker->scratch);
    free(unpacker);
}

static bool scratch_room(hdr_exr_unpacker *unpacker, size_t size) {
    if (size <= unpacker->scratch_room) return true;
    free(unpacker->scratch);
    unpacker->scratch = hdr_alloc(size, 1);
    unpacker->scratch_room = unpacker->scratch ? size : 0;
    return unpacker->scratch != NULL;
}

/* A count n >= 0: the next byte n + 1 times; n < 0: the next -n bytes. False: they do not make size bytes exactly. */
static bool undo_runs(const unsigned char *in, size_t in_size, unsigned char *out, size_t size) {
    size_t from = 0, to = 0;
    while (from < in_size) {
        unsigned code = in[from++];
        bool run = code < 128;
        size_t count = run ? code + 1 : 256 - code, taken = run ? 1 : count;
        if (count > size - to || taken > in_size - from) return false;
        if (run)
            memset(out + to, in[from], count);
        else
            memcpy(out + to, in + from, count);
        to += count;
        from += taken;
    }
    return to == size;
}

static bool unpack_by_library(hdr_exr_unpacker *unpacker, const hdr_exr_chunk *chunk, const unsigned char *packed,
                              unsigned char *out) {
    const hdr_exr_header *header = unpacker->header;
    exr_decode_pipeline_t *pipeline = &unpacker->pipeline;
    exr_chunk_info_t info = {
        .idx = (int32_t)chunk->index,
        .start_x = chunk->x,
        .start_y = chunk->y,
        .width = chunk->width,
        .height = chunk->height,
        .level_x = (uint8_t)header->picture.level,
        .level_y = (uint8_t)header->picture.level,
        .type = header->tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE,
        .compression = (uint8_t)header->compression,
        .packed_size = chunk->packed_size,
        .unpacked_size = chunk->size,
    };
    if (!unpacker->pipeline_made) {
        unpacker->pipeline_made = true; /* whatever comes of it, it is to be destroyed */
        if (exr_decoding_initialize(header->context, 0, &info, pipeline) != EXR_ERR_SUCCESS ||
            exr_decoding_choose_default_routines(header->context, 0, pipeline) != EXR_ERR_SUCCESS)
            return false;
    } else if (exr_decoding_update(header->context, 0, &info, pipeline) != EXR_ERR_SUCCESS) {
        return false;
    }
    if (!pipeline->decompress_fn) return false;
    /* The library takes it that a chunk's height is a multiple of the sampling. */
    for (int c = 0; header->sampled && c < pipeline->channel_count; c++) {
        exr_coding_channel_info_t *channel = &pipeline->channels[c];
        channel->width = (int32_t)hdr_exr_samples(channel->x_samples, chunk->x, chunk->width);
        channel->height = (int32_t)hdr_exr_samples(channel->y_samples, chunk->y, chunk->height);
    }
    /* It only reads what is packed. An allocated size of 0 tells the pipeline that these are not its own to free. */
    pipeline->packed_buffer = (void *)(uintptr_t)packed;
    pipeline->unpacked_buffer = out;
    exr_result_t result = pipeline->decompress_fn(pipeline);
    pipeline->packed_buffer = NULL;
    pipeline->unpacked_buffer = NULL;
    return result == EXR_ERR_SUCCESS;
}

bool hdr_exr_unpack(hdr_exr_unpacker *unpacker, const hdr_exr_chunk *chunk, const unsigned char *packed,
                    unsigned char *out) {
    switch (unpacker->header->compression) {
    case EXR_COMPRESSION_RLE:
        if (!scratch_room(unpacker, chunk->size) ||
            !undo_runs(packed, chunk->packed_size, unpacker->scratch, chunk->size))
            return false;
        break;
    case EXR_COMPRESSION_ZIP:
    case EXR_COMPRESSION_ZIPS:
        if (!scratch_room(unpacker, chunk->size) ||
            libdeflate_zlib_decompress(unpacker->inflater, packed, chunk->packed_size, unpacker->scratch, chunk->size,
                                       NULL) != LIBDEFLATE_SUCCESS)
            return false;
        break;
    case EXR_COMPRESSION_NONE:
        return false;
    default:
        if (unpacker->dwa)
            return hdr_exr_dwa_unpack(unpacker->dwa, unpacker->header->tiled, chunk->width, chunk->height, packed,
                                      chunk->packed_size, out, chunk->size);
        return unpack_by_library(unpacker, chunk, packed, out);
    }
    hdr_predictor_undo(unpacker->scratch, chunk->size, out);
    return true;
}

bool hdr_exr_plausible(const hdr_exr_header *header, const hdr_exr_chunk *chunk) {
    /* The most that a packed byte can stand for. Deflate: 1032. PXR24: the same, of 3 bytes that make 4. RLE: 128 for 2
     * bytes. PIZ: runs of 255 two-byte values in at least 9 bits. B44A: 32 for 3 bytes. DWA: deflated two-byte means of
     * 8 x 8 floats. */
    static const unsigned most[] = {
        [EXR_COMPRESSION_NONE] = 1,     [EXR_COMPRESSION_RLE] = 64,  [EXR_COMPRESSION_ZIPS] = 1032,
        [EXR_COMPRESSION_ZIP] = 1032,   [EXR_COMPRESSION_PIZ] = 460, [EXR_COMPRESSION_PXR24] = 1376,
        [EXR_COMPRESSION_B44] = 11,     [EXR_COMPRESSION_B44A] = 11, [EXR_COMPRESSION_DWAA] = 132096,
        [EXR_COMPRESSION_DWAB] = 132096};
    if (chunk->packed_size < 1 || chunk->packed_size > chunk->size) return false;
    return chunk->size / most[header->compression] <= chunk->packed_size;
}

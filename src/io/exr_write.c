/* The EXR sink: one scan-line part, by way of OpenEXRCore. Each band becomes whole chunks on the thread that computed
 * it, ready to be written in order. ZIP and ZIPS are compressed here, with the predictor taken straight from the
 * samples and ISA-L; DWAA and DWAB by the plug-in where the library does not have them; the other compressions by the
 * library's encoding pipeline, of which only the compressing stage is left. */
#include "io/deflate.h"
#include "io/exr_attributes.h"
#include "io/exr_compression.h"
#include "io/exr_dwa.h"
#include "io/sink.h"
#include "kernel/predict_encode.h"

#include <openexr.h>
#include <stdlib.h>
#include <string.h>

enum {
    /* ISA-L's. Measured on renders, 1 core: 300 to 480 MB/s, where libdeflate's level 4 does 80 to 180 for a file
     * smaller by 5 to 10 %. */
    ZIP_LEVEL = 2,
    ROWS_AT_LEAST = 16,      /* of a band, where the compression alone would allow single rows */
    B44_BLOCK_BYTES = 14,    /* of 4 x 4 half pixels */
    GATHERED_MAX = 64 * 1024 /* writes at least this long are not worth gathering */
};

typedef struct exr_sink {
    hdr_sink sink; /* first, so that the one pointer is the other */
    hdr_compression compression;
    float dwa_level;
    exr_context_t context;
    hdr_exr_dwa *dwa; /* where the library needs help */
    int chunk_rows;
    int rows_delivered;
    hdr_error fault; /* of the output, met inside a call of the library */
    /* Small writes that follow one another are gathered: the library writes a header word by word. */
    hdr_bytes gathered;
    uint64_t gathered_offset;
} exr_sink;

typedef struct exr_chunk {
    int first_row; /* of the frame */
    size_t offset, size;
} exr_chunk;

typedef struct exr_packer {
    exr_chunk *chunks;
    size_t chunk_count, chunk_room;
    unsigned char *packed; /* the chunks of the band; none is larger than its samples */
    size_t packed_room;
    unsigned char *raw;      /* one chunk's bytes as an uncompressed file has them, or after the predictor */
    unsigned char *squeezed; /* what the library makes of raw */
    size_t raw_room, squeezed_room;
    hdr_deflater *deflater;
    exr_encode_pipeline_t encode;
    bool encode_ready;
} exr_packer;

/* ---- The library's way out ---- */

static hdr_status flush_gathered(exr_sink *self, hdr_error *err) {
    if (self->gathered.size == 0) return HDR_OK;
    hdr_status status =
        hdr_output_write(self->sink.output, self->gathered.data, self->gathered.size, self->gathered_offset, err);
    self->gathered.size = 0;
    return status;
}

static hdr_status gather(exr_sink *self, const void *data, uint64_t size, uint64_t offset, hdr_error *err) {
    hdr_status status = HDR_OK;
    if (offset != self->gathered_offset + self->gathered.size || size + self->gathered.size > GATHERED_MAX)
        status = flush_gathered(self, err);
    if (status != HDR_OK || size >= GATHERED_MAX)
        return status != HDR_OK ? status : hdr_output_write(self->sink.output, data, size, offset, err);
    if (self->gathered.size == 0) self->gathered_offset = offset;
    return hdr_bytes_add(&self->gathered, data, size, err);
}

static int64_t on_exr_write(exr_const_context_t context, void *user_data, const void *data, uint64_t size,
                            uint64_t offset, exr_stream_error_func_ptr_t error) {
    exr_sink *self = user_data;
    (void)context, (void)error;
    return gather(self, data, size, offset, &self->fault) == HDR_OK ? (int64_t)size : -1;
}

/* What the library says is said again by its result codes; a library that prints would be no library. */
static void on_exr_error(exr_const_context_t context, exr_result_t code, const char *message) {
    (void)context, (void)code, (void)message;
}

/* Turns a result of the library into a status. */
static hdr_status checked(exr_sink *self, exr_result_t result, hdr_error *err) {
    if (result == EXR_ERR_SUCCESS) return HDR_OK;
    if (self->fault.status != HDR_OK) return hdr_fail(err, self->fault.status, "%s", self->fault.message);
    hdr_status status = result == EXR_ERR_INVALID_ATTR ? HDR_BAD_DATA : HDR_INTERNAL;
    return hdr_fail(err, status, "%s: OpenEXR: %s", hdr_output_name(self->sink.output),
                    exr_get_default_error_message(result));
}

static hdr_status out_of_memory(const hdr_sink *sink, hdr_error *err) {
    return hdr_fail(err, HDR_INTERNAL, "%s: out of memory", hdr_output_name(sink->output));
}

/* ---- The header ---- */

/* The file has its channels in alphabetical order, A B G R or A Y: the samples' order, R G B A or Y A, reversed. */
static const char *channel_name(const hdr_frame *frame, int file_channel) {
    static const char *const colour[] = {"R", "G", "B", "A"}, *const grey[] = {"Y", "A"};
    int plane = hdr_frame_channels(frame) - 1 - file_channel;
    return frame->planes == 3 ? colour[plane] : grey[plane];
}

static exr_result_t add_channels(exr_context_t context, const hdr_frame *frame) {
    exr_pixel_type_t type = frame->sample == HDR_SAMPLE_HALF ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT;
    exr_result_t result = EXR_ERR_SUCCESS;
    for (int c = 0; c < hdr_frame_channels(frame) && result == EXR_ERR_SUCCESS; c++)
        result = exr_add_channel(context, 0, channel_name(frame, c), type, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    return result;
}

static exr_attr_box2i_t box(hdr_window window) {
    return (exr_attr_box2i_t){.min = {.x = window.min_x, .y = window.min_y},
                              .max = {.x = window.max_x, .y = window.max_y}};
}

static bool is_dwa(hdr_compression compression) {
    return compression == HDR_COMPRESSION_DWAA || compression == HDR_COMPRESSION_DWAB;
}

static exr_result_t set_attributes(const exr_sink *self) {
    exr_context_t context = self->context;
    const hdr_frame *frame = &self->sink.frame;
    exr_attr_box2i_t data = box(frame->data), display = box(frame->display);
    exr_attr_v2f_t centre = {.x = 0, .y = 0};
    exr_result_t result =
        exr_initialize_required_attr(context, 0, &display, &data, frame->pixel_aspect, &centre, 1,
                                     EXR_LINEORDER_INCREASING_Y, (exr_compression_t)self->compression);
    if (result == EXR_ERR_SUCCESS && frame->has_chromaticities) {
        const hdr_chromaticities *c = &frame->chromaticities;
        exr_attr_chromaticities_t attribute = {
            .red_x = (float)c->red[0],
            .red_y = (float)c->red[1],
            .green_x = (float)c->green[0],
            .green_y = (float)c->green[1],
            .blue_x = (float)c->blue[0],
            .blue_y = (float)c->blue[1],
            .white_x = (float)c->white[0],
            .white_y = (float)c->white[1],
        };
        result = exr_attr_set_chromaticities(context, 0, "chromaticities", &attribute);
    }
    /* For the library if it is to compress, which does not write it; and for the reader's information. */
    bool by_library = is_dwa(self->compression) && !hdr_exr_needs_dwa((exr_compression_t)self->compression);
    if (result == EXR_ERR_SUCCESS && by_library) result = exr_set_dwa_compression_level(context, 0, self->dwa_level);
    if (result == EXR_ERR_SUCCESS && is_dwa(self->compression))
        result = exr_attr_set_float(context, 0, "dwaCompressionLevel", self->dwa_level);
    if (result == EXR_ERR_SUCCESS) result = exr_attr_set_string(context, 0, "hdrpipeState", frame->state);
    if (result == EXR_ERR_SUCCESS) result = add_channels(context, frame);
    /* last: what is there already is not copied */
    if (result == EXR_ERR_SUCCESS && frame->attributes)
        result = hdr_exr_put_attributes(context, frame->attributes, frame->record);
    return result;
}

static hdr_status load_dwa(exr_sink *self, hdr_error *err) {
    exr_compression_t compression = (exr_compression_t)self->compression;
    const exr_attr_chlist_t *channels;
    hdr_error fault = {0};
    if (!hdr_exr_needs_dwa(compression)) return HDR_OK;
    hdr_status status = checked(self, exr_get_channels(self->context, 0, &channels), err);
    if (status != HDR_OK) return status;
    self->dwa = hdr_exr_dwa_new(compression, channels, &fault);
    return self->dwa ? HDR_OK
                     : hdr_fail(err, fault.status, "%s: %s", hdr_output_name(self->sink.output), fault.message);
}

static hdr_status exr_begin(hdr_sink *sink, hdr_error *err) {
    exr_sink *self = (exr_sink *)sink;
    exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
    initializer.error_handler_fn = on_exr_error;
    initializer.user_data = self;
    initializer.write_fn = on_exr_write;
    int part;
    exr_result_t result =
        exr_start_write(&self->context, hdr_output_name(sink->output), EXR_WRITE_FILE_DIRECTLY, &initializer);
    bool long_names = sink->frame.attributes && hdr_exr_long_names(sink->frame.attributes);
    if (result == EXR_ERR_SUCCESS && long_names) result = exr_set_longname_support(self->context, 1);
    if (result == EXR_ERR_SUCCESS) result = exr_add_part(self->context, "pixels", EXR_STORAGE_SCANLINE, &part);
    if (result == EXR_ERR_SUCCESS) result = set_attributes(self);
    if (result == EXR_ERR_SUCCESS) result = exr_write_header(self->context);
    hdr_status status = checked(self, result, err);
    if (status == HDR_OK) status = load_dwa(self, err);
    return status == HDR_OK ? flush_gathered(self, err) : status;
}

/* ---- Packing ---- */

static hdr_status make_room(const hdr_sink *sink, unsigned char **buffer, size_t *room, size_t size, hdr_error *err) {
    if (size <= *room) return HDR_OK;
    unsigned char *grown = hdr_grow(*buffer, size, 1);
    if (!grown) return out_of_memory(sink, err);
    *buffer = grown;
    *room = size;
    return HDR_OK;
}

/* Rows as an uncompressed file has them: the same planes, in the file's order. */
static void pack_raw(const hdr_frame *frame, const unsigned char *samples, int rows, unsigned char *out) {
    size_t channels = (size_t)hdr_frame_channels(frame);
    size_t row_bytes = hdr_frame_row_bytes(frame), plane_bytes = row_bytes / channels;
    for (int row = 0; row < rows; row++, samples += row_bytes)
        for (size_t c = channels; c-- > 0; out += plane_bytes)
            memcpy(out, samples + c * plane_bytes, plane_bytes);
}

/* The same, through the predictor. A plane's row is a whole number of byte pairs, so each goes to both halves by
 * itself. The very first byte stands as it is, and the second half goes on from the last byte of the first. */
static void pack_predicted(const hdr_frame *frame, const unsigned char *samples, int rows, unsigned char *out) {
    size_t channels = (size_t)hdr_frame_channels(frame);
    size_t row_bytes = hdr_frame_row_bytes(frame), plane_bytes = row_bytes / channels;
    size_t half = row_bytes * (size_t)rows / 2, pairs = plane_bytes / 2, done = 0;
    uint8_t before[2] = {128, 0}; /* 128: so that the first byte comes out unchanged */
    uint8_t first_odd = samples[row_bytes - plane_bytes + 1];
    for (int row = 0; row < rows; row++, samples += row_bytes)
        for (size_t c = channels; c-- > 0; done += pairs) {
            const uint8_t *in = samples + c * plane_bytes;
            hdr_predict_split(out + done, out + half + done, in, pairs, before);
            memcpy(before, in + plane_bytes - 2, 2);
        }
    out[half] = (uint8_t)(first_odd - before[0] + 128);
}

/* Returns the size of a chunk that became smaller than its raw bytes, or 0. It is offered no more room than that. */
static size_t deflate_chunk(exr_packer *packer, const hdr_frame *frame, const unsigned char *samples, int rows,
                            unsigned char *out) {
    size_t size = hdr_frame_row_bytes(frame) * (size_t)rows;
    pack_predicted(frame, samples, rows, packer->raw);
    return hdr_deflate(packer->deflater, HDR_DEFLATE_ZLIB, packer->raw, size, out, size - 1);
}

/* The pipeline's packing stage, called under the context's lock, finds the work done. */
static exr_result_t already_packed(exr_encode_pipeline_t *encode) {
    encode->packed_bytes = encode->chunk.unpacked_size;
    return EXR_ERR_SUCCESS;
}

/* Makes the pipeline stand at a chunk. Its buffers are the packer's; every channel gets a pointer because the library
 * checks for one; nothing is written, since it has no writing stage. */
static exr_result_t aim_pipeline(exr_sink *self, exr_packer *packer, int y) {
    exr_encode_pipeline_t *encode = &packer->encode;
    exr_chunk_info_t info;
    exr_result_t result = exr_write_scanline_chunk_info(self->context, 0, y, &info);
    if (result != EXR_ERR_SUCCESS) return result;
    if (packer->encode_ready) {
        result = exr_encoding_update(self->context, 0, &info, encode);
    } else {
        result = exr_encoding_initialize(self->context, 0, &info, encode);
        if (result == EXR_ERR_SUCCESS) result = exr_encoding_choose_default_routines(self->context, 0, encode);
        packer->encode_ready = result == EXR_ERR_SUCCESS;
        encode->convert_and_pack_fn = already_packed;
        encode->yield_until_ready_fn = NULL;
        encode->write_fn = NULL;
    }
    encode->packed_buffer = packer->raw;
    encode->packed_alloc_size = packer->raw_room;
    encode->compressed_buffer = packer->squeezed;
    encode->compressed_alloc_size = packer->squeezed_room;
    for (int c = 0; c < encode->channel_count; c++)
        encode->channels[c].encode_from_ptr = packer->raw;
    return result;
}

/* Compresses raw with the library. A chunk that does not become smaller is to be stored raw: readers take one that is
 * as large as its pixels for that, and the library's B44 and (at equal size) ZIP code do not see to it. Returns its
 * size, or 0 for raw. */
static hdr_status squeeze_chunk(exr_sink *self, exr_packer *packer, const unsigned char *samples, int first_row,
                                int rows, unsigned char *out, size_t *size, hdr_error *err) {
    pack_raw(&self->sink.frame, samples, rows, packer->raw);
    exr_result_t result = aim_pipeline(self, packer, self->sink.frame.data.min_y + first_row);
    if (result == EXR_ERR_SUCCESS) result = exr_encoding_run(self->context, 0, &packer->encode);
    if (result != EXR_ERR_SUCCESS)
        return hdr_fail(err, HDR_INTERNAL, "%s: OpenEXR: %s", hdr_output_name(self->sink.output),
                        exr_get_default_error_message(result));
    *size = packer->encode.compressed_bytes < packer->encode.packed_bytes ? packer->encode.compressed_bytes : 0;
    if (*size > 0) memcpy(out, packer->encode.compressed_buffer, *size);
    return HDR_OK;
}

/* The same by the plug-in. */
static hdr_status squeeze_dwa(const exr_sink *self, exr_packer *packer, const unsigned char *samples, int rows,
                              unsigned char *out, size_t *size, hdr_error *err) {
    const hdr_frame *frame = &self->sink.frame;
    size_t raw_size = hdr_frame_row_bytes(frame) * (size_t)rows;
    hdr_error fault = {0};
    pack_raw(frame, samples, rows, packer->raw);
    hdr_status status = hdr_exr_dwa_pack(self->dwa, self->dwa_level, frame->width, rows, packer->raw, raw_size, out,
                                         raw_size, size, &fault);
    return status == HDR_OK ? HDR_OK
                            : hdr_fail(err, status, "%s: %s", hdr_output_name(self->sink.output), fault.message);
}

static hdr_status pack_chunk(exr_sink *self, exr_packer *packer, const unsigned char *samples, exr_chunk *chunk,
                             int rows, hdr_error *err) {
    const hdr_frame *frame = &self->sink.frame;
    unsigned char *out = packer->packed + chunk->offset;
    hdr_status status = HDR_OK;
    chunk->size = 0;
    if (self->compression == HDR_COMPRESSION_ZIP || self->compression == HDR_COMPRESSION_ZIPS)
        chunk->size = deflate_chunk(packer, frame, samples, rows, out);
    else if (self->dwa)
        status = squeeze_dwa(self, packer, samples, rows, out, &chunk->size, err);
    else if (self->compression != HDR_COMPRESSION_NONE)
        status = squeeze_chunk(self, packer, samples, chunk->first_row, rows, out, &chunk->size, err);
    if (status == HDR_OK && chunk->size == 0) {
        pack_raw(frame, samples, rows, out);
        chunk->size = hdr_frame_row_bytes(frame) * (size_t)rows;
    }
    return status;
}

/* A little more than the library asks for, so that it keeps the buffer; and enough for B44, whose blocks are larger
 * than the pixels where a picture is not four pixels high or wide (the library's own estimate fails there). */
static size_t squeezed_bound(const hdr_frame *frame, int rows) {
    size_t raw = hdr_frame_row_bytes(frame) * (size_t)rows;
    size_t blocks = ((size_t)frame->width + 3) / 4 * (((size_t)rows + 3) / 4);
    return raw / 100 * 110 + 2 * 65536 + blocks * (size_t)hdr_frame_channels(frame) * B44_BLOCK_BYTES;
}

static hdr_status prepare_packer(const exr_sink *self, exr_packer *packer, int rows, hdr_error *err) {
    const hdr_frame *frame = &self->sink.frame;
    size_t row_bytes = hdr_frame_row_bytes(frame);
    int chunk_rows = rows < self->chunk_rows ? rows : self->chunk_rows;
    if (row_bytes > INT32_MAX / (size_t)chunk_rows)
        return hdr_fail(err, HDR_BAD_DATA, "%s: rows are too wide for EXR chunks of %d rows",
                        hdr_output_name(self->sink.output), chunk_rows);
    size_t chunks = ((size_t)rows + (size_t)self->chunk_rows - 1) / (size_t)self->chunk_rows;
    if (chunks > packer->chunk_room) {
        exr_chunk *grown = hdr_grow(packer->chunks, chunks, sizeof *grown);
        if (!grown) return out_of_memory(&self->sink, err);
        packer->chunks = grown;
        packer->chunk_room = chunks;
    }
    hdr_status status = make_room(&self->sink, &packer->packed, &packer->packed_room, row_bytes * (size_t)rows, err);
    if (status == HDR_OK)
        status = make_room(&self->sink, &packer->raw, &packer->raw_room, row_bytes * (size_t)chunk_rows, err);
    if (status == HDR_OK)
        status =
            make_room(&self->sink, &packer->squeezed, &packer->squeezed_room, squeezed_bound(frame, chunk_rows), err);
    return status;
}

static hdr_status exr_pack(hdr_sink *sink, void *packer, int first_row, int rows, void *samples, hdr_error *err) {
    exr_sink *self = (exr_sink *)sink;
    exr_packer *band = packer;
    size_t row_bytes = hdr_frame_row_bytes(&sink->frame), offset = 0;
    bool last = rows == sink->frame.height - first_row;
    band->chunk_count = 0;
    if (first_row % sink->band_multiple != 0 || (rows % sink->band_multiple != 0 && !last))
        return hdr_fail(err, HDR_INTERNAL, "%s: a band begins or ends within a chunk", hdr_output_name(sink->output));
    hdr_status status = prepare_packer(self, band, rows, err);
    for (int row = 0; row < rows && status == HDR_OK; row += self->chunk_rows) {
        int height = rows - row < self->chunk_rows ? rows - row : self->chunk_rows;
        exr_chunk *chunk = &band->chunks[band->chunk_count++];
        *chunk = (exr_chunk){.first_row = first_row + row, .offset = offset};
        status = pack_chunk(self, band, (unsigned char *)samples + (size_t)row * row_bytes, chunk, height, err);
        offset += chunk->size;
    }
    return status;
}

static void exr_packer_free(hdr_sink *sink, void *packer) {
    exr_sink *self = (exr_sink *)sink;
    exr_packer *band = packer;
    if (!band) return;
    if (band->encode_ready) {
        band->encode.packed_buffer = band->encode.compressed_buffer = NULL;
        (void)exr_encoding_destroy(self->context, &band->encode); /* frees the library's scratch memory */
    }
    hdr_deflater_free(band->deflater);
    free(band->chunks);
    free(band->packed);
    free(band->raw);
    free(band->squeezed);
    free(band);
}

static hdr_status exr_packer_new(hdr_sink *sink, void **packer, hdr_error *err) {
    exr_packer *band = hdr_alloc(1, sizeof *band);
    if (band) band->deflater = hdr_deflater_new(ZIP_LEVEL);
    if (!band || !band->deflater) {
        exr_packer_free(sink, band);
        return out_of_memory(sink, err);
    }
    *packer = band;
    return HDR_OK;
}

/* ---- Writing ---- */

static hdr_status exr_deliver(hdr_sink *sink, void *packer, hdr_error *err) {
    exr_sink *self = (exr_sink *)sink;
    const exr_packer *band = packer;
    hdr_status status = HDR_OK;
    for (size_t i = 0; i < band->chunk_count && status == HDR_OK; i++) {
        const exr_chunk *chunk = &band->chunks[i];
        exr_result_t result = exr_write_scanline_chunk(self->context, 0, sink->frame.data.min_y + chunk->first_row,
                                                       band->packed + chunk->offset, chunk->size);
        status = checked(self, result, err);
        self->rows_delivered += self->chunk_rows;
    }
    return status == HDR_OK ? flush_gathered(self, err) : status;
}

/* The library wrote the table of chunks together with the last one. */
static hdr_status exr_end(hdr_sink *sink, hdr_error *err) {
    exr_sink *self = (exr_sink *)sink;
    if (self->rows_delivered < sink->frame.height)
        return hdr_fail(err, HDR_INTERNAL, "%s: rows are missing", hdr_output_name(sink->output));
    return flush_gathered(self, err);
}

static void exr_close(hdr_sink *sink) {
    exr_sink *self = (exr_sink *)sink;
    if (!self) return;
    if (self->context)
        (void)exr_finish(&self->context); /* only frees: the file was finished, and checked, with its last chunk */
    hdr_exr_dwa_free(self->dwa);
    free(self->gathered.data);
    free(self);
}

/* The library takes no coordinates beyond these. */
static bool within_bounds(const hdr_window *window) {
    enum { FARTHEST = INT32_MAX / 2 };
    return window->min_x > -FARTHEST && window->min_y > -FARTHEST && window->max_x < FARTHEST &&
           window->max_y < FARTHEST;
}

hdr_sink *hdr_exr_create(hdr_output *output, const hdr_frame *frame, hdr_compression compression, float dwa_level,
                         hdr_error *err) {
    const hdr_window *window = within_bounds(&frame->data) ? &frame->display : &frame->data;
    if (!within_bounds(window)) {
        hdr_fail(err, HDR_BAD_DATA, "%s: a window from %d,%d to %d,%d; the coordinates of an EXR stay below 2^30",
                 hdr_output_name(output), window->min_x, window->min_y, window->max_x, window->max_y);
        return NULL;
    }
    exr_sink *self = hdr_alloc(1, sizeof *self);
    if (!self) {
        hdr_fail(err, HDR_INTERNAL, "%s: out of memory", hdr_output_name(output));
        return NULL;
    }
    self->compression = compression;
    self->dwa_level = dwa_level;
    self->chunk_rows = hdr_exr_chunk_lines((int)compression);
    self->sink = (hdr_sink){.frame = *frame,
                            .output = output,
                            .band_multiple = self->chunk_rows > ROWS_AT_LEAST ? self->chunk_rows : ROWS_AT_LEAST,
                            .begin = exr_begin,
                            .packer_new = exr_packer_new,
                            .pack = exr_pack,
                            .deliver = exr_deliver,
                            .packer_free = exr_packer_free,
                            .end = exr_end,
                            .close = exr_close};
    return &self->sink;
}

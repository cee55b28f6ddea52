/* Writes pictures through every sink, in bands that several packers hold at a time, and reads them back with the
 * formats' own libraries. */
#include "check.h"
#include "io/sink.h"

#include <openexr.h>
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

enum { PACKERS = 3, CHANNELS_MAX = 4 };

static uint64_t random_state = 1;

/* SplitMix64. */
static uint64_t random_bits(void) {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* ---- Pictures ---- */

typedef enum content { NOISE, SMOOTH, CONSTANT, CONTENTS } content;

static hdr_frame make_frame(int width, int height, int planes, bool alpha, hdr_sample sample) {
    hdr_frame frame = {.width = width,
                       .height = height,
                       .data = {-3, 7, width - 4, height + 6},
                       .display = {-10, 0, width + 5, height + 20},
                       .planes = planes,
                       .alpha = alpha,
                       .sample = sample,
                       .bits = sample == HDR_SAMPLE_U8 ? 8 : 16,
                       .state = "srgb",
                       .pixel_aspect = 1.25f};
    return frame;
}

/* A finite pattern of bits of a half or float, or any code. */
static uint32_t sample_bits(hdr_sample sample, content what, size_t x, size_t y) {
    uint32_t smooth = (uint32_t)(x * 5 + y * 3);
    if (sample == HDR_SAMPLE_FLOAT) {
        float value = what == SMOOTH     ? (float)smooth / 64
                      : what == CONSTANT ? 0.25f
                                         : (float)(random_bits() >> 40) / 4096;
        uint32_t bits;
        memcpy(&bits, &value, sizeof bits);
        return bits;
    }
    if (sample == HDR_SAMPLE_HALF)
        return what == SMOOTH ? 0x3000 + smooth % 1024 : what == CONSTANT ? 0x3c00 : (uint32_t)(random_bits() % 0x7c00);
    return what == SMOOTH ? smooth : what == CONSTANT ? 77 : (uint32_t)random_bits();
}

static unsigned char *make_samples(const hdr_frame *frame, content what) {
    size_t size = hdr_sample_size(frame->sample);
    size_t row = hdr_frame_row_bytes(frame) / size;
    unsigned char *samples = malloc(row * size * (size_t)frame->height);
    for (size_t y = 0; y < (size_t)frame->height; y++)
        for (size_t x = 0; x < row; x++) {
            uint32_t bits = sample_bits(frame->sample, what, x, y); /* little-endian, as the rest of the tests */
            memcpy(samples + (y * row + x) * size, &bits, size);
        }
    return samples;
}

/* ---- Through a sink ---- */

/* Packs up to PACKERS bands, the last one first, then delivers them. Returns the first row that is not done. */
static int write_group(hdr_sink *sink, void *const packers[], unsigned char *samples, int first_row, int band_rows,
                       hdr_error *err) {
    size_t row_bytes = hdr_frame_row_bytes(&sink->frame);
    int bands = (sink->frame.height - first_row + band_rows - 1) / band_rows;
    if (bands > PACKERS) bands = PACKERS;
    for (int band = bands - 1; band >= 0; band--) {
        int row = first_row + band * band_rows;
        int rows = sink->frame.height - row < band_rows ? sink->frame.height - row : band_rows;
        if (sink->pack(sink, packers[band], row, rows, samples + (size_t)row * row_bytes, err) != HDR_OK)
            return sink->frame.height;
    }
    for (int band = 0; band < bands; band++)
        if (sink->deliver(sink, packers[band], err) != HDR_OK) return sink->frame.height;
    return first_row + bands * band_rows;
}

/* Writes a picture in bands of band_rows. swap: exchanges packers, which must not change a byte. */
static hdr_status write_picture(hdr_sink *sink, const unsigned char *samples, int band_rows, bool swap,
                                hdr_error *err) {
    size_t size = hdr_frame_row_bytes(&sink->frame) * (size_t)sink->frame.height;
    unsigned char *copy = malloc(size); /* a sink may overwrite its samples */
    memcpy(copy, samples, size);
    void *packers[PACKERS] = {NULL};
    hdr_status status = sink->begin(sink, err);
    for (int i = 0; i < PACKERS && status == HDR_OK; i++)
        status = sink->packer_new(sink, &packers[swap ? PACKERS - 1 - i : i], err);
    for (int row = 0; row < sink->frame.height && status == HDR_OK;) {
        hdr_error fault = {0};
        row = write_group(sink, packers, copy, row, band_rows, &fault);
        if ((status = fault.status) != HDR_OK) hdr_fail(err, status, "%s", fault.message);
        void *first = packers[0];
        if (swap) {
            packers[0] = packers[1];
            packers[1] = first;
        }
    }
    if (status == HDR_OK) status = sink->end(sink, err);
    for (int i = 0; i < PACKERS; i++)
        sink->packer_free(sink, packers[i]);
    free(copy);
    return status;
}

typedef hdr_sink *(*sink_maker)(hdr_output *, const hdr_frame *, hdr_compression, hdr_error *);
static hdr_sink *make_png(hdr_output *output, const hdr_frame *frame, hdr_compression compression, hdr_error *err) {
    (void)compression;
    return hdr_png_create(output, frame, err);
}
static hdr_sink *make_pfm(hdr_output *output, const hdr_frame *frame, hdr_compression compression, hdr_error *err) {
    (void)compression;
    return hdr_pfm_create(output, frame, err);
}

/* The output holds the file; NULL on a fault, which counts. */
static hdr_output *write_to_memory(sink_maker maker, const hdr_frame *frame, hdr_compression compression,
                                   const unsigned char *samples, int band_rows, bool swap) {
    hdr_error err = {0};
    hdr_output *output = hdr_output_memory(&err);
    hdr_sink *sink = maker(output, frame, compression, &err);
    hdr_status status = write_picture(sink, samples, band_rows, swap, &err);
    sink->close(sink);
    if (status == HDR_OK) status = hdr_output_commit(output, &err);
    CHECK(status == HDR_OK, "%dx%d: %s", frame->width, frame->height, err.message);
    if (status == HDR_OK) return output;
    hdr_output_free(output);
    return NULL;
}

/* A second writing, with the packers exchanged, gives the same bytes. */
static void check_repeatable(sink_maker maker, const hdr_frame *frame, hdr_compression compression,
                             const unsigned char *samples, int band_rows, const hdr_output *expected) {
    hdr_output *again = write_to_memory(maker, frame, compression, samples, band_rows, true);
    size_t size, expected_size;
    const void *bytes = again ? hdr_output_bytes(again, &size) : NULL;
    const void *expected_bytes = hdr_output_bytes(expected, &expected_size);
    CHECK(bytes && size == expected_size && memcmp(bytes, expected_bytes, size) == 0, "bytes depend on the packers");
    hdr_output_free(again);
}

/* ---- PNG ---- */

typedef struct byte_reader {
    const unsigned char *data;
    size_t size, at;
} byte_reader;

static void read_png_bytes(png_structp png, png_bytep out, size_t size) {
    byte_reader *reader = png_get_io_ptr(png);
    if (size > reader->size - reader->at) png_error(png, "end of file");
    memcpy(out, reader->data + reader->at, size);
    reader->at += size;
}

static int png_warnings;

static void count_png_warning(png_structp png, png_const_charp message) {
    (void)png, (void)message;
    png_warnings++;
}

/* The pixels as they lie in memory: 16-bit samples native. Anything libpng warns of is a failure. */
static bool read_png_rows(png_structp png, png_infop info, unsigned char *pixels, size_t row_bytes, int height) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_read_info(png, info);
    if (png_get_bit_depth(png, info) == 16) png_set_swap(png);
    if (png_get_rowbytes(png, info) != row_bytes || (int)png_get_image_height(png, info) != height) return false;
    for (int y = 0; y < height; y++)
        png_read_row(png, pixels + (size_t)y * row_bytes, NULL);
    png_read_end(png, NULL);
    return true;
}

static void check_png_colour(png_structp png, png_infop info, const hdr_frame *frame) {
    png_fixed_point gamma = 0, white_x = 0, red_x = 0;
    int intent;
    bool srgb = strcmp(frame->state, "srgb") == 0, other = frame->has_chromaticities;
    png_fixed_point expected = srgb ? 45455 : strcmp(frame->state, "linear") == 0 ? 100000 : 55556;
    png_get_gAMA_fixed(png, info, &gamma);
    CHECK(gamma == expected, "state %s: gAMA %d, expected %d", frame->state, (int)gamma, (int)expected);
    CHECK(png_get_valid(png, info, PNG_INFO_sRGB) == (srgb && !other ? PNG_INFO_sRGB : 0u), "state %s: sRGB",
          frame->state);
    if (srgb && !other) CHECK(png_get_sRGB(png, info, &intent) && intent == PNG_sRGB_INTENT_PERCEPTUAL, "sRGB intent");
    CHECK(png_get_valid(png, info, PNG_INFO_cHRM) == (srgb || other ? PNG_INFO_cHRM : 0u), "state %s: cHRM",
          frame->state);
    if (srgb || other) png_get_cHRM_fixed(png, info, &white_x, NULL, &red_x, NULL, NULL, NULL, NULL, NULL);
    if (other)
        CHECK(white_x == 34567 && red_x == 70800, "cHRM: %d %d", (int)white_x, (int)red_x);
    else if (srgb)
        CHECK(white_x == 31270 && red_x == 64000, "cHRM: %d %d", (int)white_x, (int)red_x);
}

static void check_png_info(png_structp png, png_infop info, const hdr_frame *frame) {
    int depth = frame->sample == HDR_SAMPLE_U8 ? 8 : 16;
    CHECK((int)png_get_bit_depth(png, info) == depth, "depth %d", png_get_bit_depth(png, info));
    CHECK((int)png_get_channels(png, info) == hdr_frame_channels(frame), "channels %d", png_get_channels(png, info));
    png_color_8p significant = NULL;
    png_get_sBIT(png, info, &significant);
    if (frame->bits == depth)
        CHECK(significant == NULL, "sBIT for all bits");
    else
        CHECK(significant && (frame->planes == 3 ? significant->red : significant->gray) == frame->bits, "sBIT");
    check_png_colour(png, info, frame);
    png_textp text;
    CHECK(png_get_text(png, info, &text, NULL) == 0 && !png_get_valid(png, info, PNG_INFO_tIME),
          "text or time in the file");
}

static void check_png_file(const hdr_output *output, const hdr_frame *frame, const unsigned char *samples) {
    byte_reader reader = {0};
    reader.data = hdr_output_bytes(output, &reader.size);
    size_t row_bytes = hdr_frame_row_bytes(frame), size = row_bytes * (size_t)frame->height;
    unsigned char *pixels = calloc(size, 1);
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, count_png_warning);
    png_infop info = png_create_info_struct(png);
    png_set_read_fn(png, &reader, read_png_bytes);
    png_warnings = 0;
    bool whole = read_png_rows(png, info, pixels, row_bytes, frame->height);
    CHECK(whole && reader.at == reader.size, "%dx%d: libpng does not read it to its end", frame->width, frame->height);
    CHECK(memcmp(pixels, samples, size) == 0, "%dx%dx%d: pixels differ", frame->width, frame->height,
          hdr_frame_channels(frame));
    CHECK(png_warnings == 0, "%dx%d: libpng warns", frame->width, frame->height);
    if (whole) check_png_info(png, info, frame);
    png_destroy_read_struct(&png, &info, NULL);
    free(pixels);
}

static void check_png(const hdr_frame *frame, content what, int band_rows) {
    unsigned char *samples = make_samples(frame, what);
    hdr_output *output = write_to_memory(make_png, frame, HDR_COMPRESSION_NONE, samples, band_rows, false);
    if (output) {
        check_png_file(output, frame, samples);
        check_repeatable(make_png, frame, HDR_COMPRESSION_NONE, samples, band_rows, output);
    }
    hdr_output_free(output);
    free(samples);
}

static void test_png_pixels(void) {
    static const int sizes[][3] = {{1, 1, 1}, {7, 5, 2}, {64, 33, 16}, {333, 70, 11}, {5000, 40, 7}, {40, 900, 13}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++)
        for (int kind = 0; kind < 8; kind++)
            for (content what = NOISE; what < CONTENTS; what++) {
                hdr_frame frame = make_frame(sizes[i][0], sizes[i][1], kind & 1 ? 3 : 1, (kind & 2) != 0,
                                             kind & 4 ? HDR_SAMPLE_U16 : HDR_SAMPLE_U8);
                check_png(&frame, what, sizes[i][2]);
                check_png(&frame, what, frame.height);
            }
    hdr_frame wide = make_frame(1500000, 2, 1, false, HDR_SAMPLE_U8); /* beyond libpng's default limit */
    check_png(&wide, NOISE, 1);
}

static const hdr_chromaticities wide_gamut = {{0.708, 0.292}, {0.17, 0.797}, {0.131, 0.046}, {0.34567, 0.3585}};

static void test_png_colour(void) {
    static const char *const states[] = {"srgb", "linear", "gamma 1.8"};
    for (int i = 0; i < 3; i++)
        for (int other = 0; other < 2; other++)
            for (int bits = 1; bits <= 16; bits += 3) {
                hdr_frame frame = make_frame(19, 4, other ? 3 : 1, i == 1, bits <= 8 ? HDR_SAMPLE_U8 : HDR_SAMPLE_U16);
                frame.state = states[i];
                frame.gamma = 1.8;
                frame.bits = bits;
                frame.has_chromaticities = other;
                frame.chromaticities = wide_gamut;
                check_png(&frame, NOISE, 3);
            }
}

/* The data of the first chunk of a type, or NULL. */
static const unsigned char *find_chunk(const hdr_output *output, const char *type) {
    size_t size;
    const unsigned char *bytes = hdr_output_bytes(output, &size);
    for (size_t at = 8; at + 12 <= size;) {
        if (memcmp(bytes + at + 4, type, 4) == 0) return bytes + at + 8;
        at += 12 + ((size_t)bytes[at] << 24 | (size_t)bytes[at + 1] << 16 | (size_t)bytes[at + 2] << 8 | bytes[at + 3]);
    }
    return NULL;
}

static void check_coding_points(const char *state, const hdr_chromaticities *primaries, int code, int transfer) {
    hdr_frame frame = make_frame(3, 3, 3, false, HDR_SAMPLE_U8);
    frame.state = state;
    if ((frame.has_chromaticities = primaries != NULL)) frame.chromaticities = *primaries;
    unsigned char *samples = make_samples(&frame, NOISE);
    hdr_output *output = write_to_memory(make_png, &frame, HDR_COMPRESSION_NONE, samples, 2, false);
    const unsigned char *chunk = output ? find_chunk(output, "cICP") : NULL;
    if (code)
        CHECK(chunk && chunk[0] == code && chunk[1] == transfer && chunk[2] == 0 && chunk[3] == 1, "cICP for %s",
              state);
    else
        CHECK(!chunk, "cICP for %s with primaries that have no code", state);
    CHECK(output && !find_chunk(output, "gAMA") && !find_chunk(output, "sRGB"), "%s: gAMA or sRGB", state);
    CHECK(output && !find_chunk(output, "cHRM") == !primaries, "%s: cHRM", state);
    hdr_output_free(output);
    free(samples);
}

static void test_png_coding_points(void) {
    hdr_chromaticities bt2020 = wide_gamut;
    bt2020.white[0] = 0.3127;
    bt2020.white[1] = 0.3290;
    check_coding_points("rec709", NULL, 1, 1);
    check_coding_points("pq", NULL, 1, 16);
    check_coding_points("hlg", &bt2020, 9, 18);
    check_coding_points("pq", &wide_gamut, 0, 0);
}

/* ---- EXR ---- */

static hdr_sink *make_exr(hdr_output *output, const hdr_frame *frame, hdr_compression compression, hdr_error *err) {
    return hdr_exr_create(output, frame, compression, 45, err);
}

static int64_t read_exr_bytes(exr_const_context_t context, void *user_data, void *out, uint64_t size, uint64_t offset,
                              exr_stream_error_func_ptr_t error) {
    const byte_reader *reader = user_data;
    (void)context, (void)error;
    if (offset > reader->size) return -1;
    if (size > reader->size - offset) size = reader->size - offset;
    memcpy(out, reader->data + offset, size);
    return (int64_t)size;
}

static int64_t exr_file_size(exr_const_context_t context, void *user_data) {
    (void)context;
    return (int64_t)((const byte_reader *)user_data)->size;
}

static int64_t write_exr_bytes(exr_const_context_t context, void *user_data, const void *data, uint64_t size,
                               uint64_t offset, exr_stream_error_func_ptr_t error) {
    (void)context, (void)error;
    return hdr_output_write(user_data, data, size, offset, NULL) == HDR_OK ? (int64_t)size : -1;
}

/* Lets a channel of a chunk point into samples, whose planes are in the reverse of the file's order. */
static void aim_channel(exr_coding_channel_info_t *channel, const hdr_frame *frame, int plane, unsigned char *samples,
                        int row) {
    size_t size = hdr_sample_size(frame->sample), row_bytes = hdr_frame_row_bytes(frame);
    channel->user_bytes_per_element = (int16_t)size;
    channel->user_data_type = channel->data_type;
    channel->user_pixel_stride = (int32_t)size;
    channel->user_line_stride = (int32_t)row_bytes;
    channel->decode_to_ptr = samples + (size_t)row * row_bytes + (size_t)plane * (size_t)frame->width * size;
}

static exr_result_t (*library_decompress)(exr_decode_pipeline_t *);

/* A chunk as large as its pixels is raw, in B44 too: so says the C++ library, which wrote the first such files.
 * OpenEXRCore 3.1.5 unpacks it nevertheless. */
static exr_result_t decompress_unless_raw(exr_decode_pipeline_t *decode) {
    if (decode->chunk.packed_size == decode->chunk.unpacked_size)
        return EXR_ERR_SUCCESS; /* the library made both buffers one */
    return library_decompress(decode);
}

/* Reads all chunks. The return value says whether every call succeeded. */
static bool read_exr_pixels(exr_context_t context, const hdr_frame *frame, unsigned char *samples) {
    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t chunk;
    bool first = true;
    for (int row = 0; row < frame->height; first = false) {
        if (exr_read_scanline_chunk_info(context, 0, frame->data.min_y + row, &chunk) != EXR_ERR_SUCCESS ||
            (first ? exr_decoding_initialize(context, 0, &chunk, &decode)
                   : exr_decoding_update(context, 0, &chunk, &decode)) != EXR_ERR_SUCCESS)
            return false;
        for (int c = 0; c < decode.channel_count; c++)
            aim_channel(&decode.channels[c], frame, decode.channel_count - 1 - c, samples, row);
        if (first && exr_decoding_choose_default_routines(context, 0, &decode) != EXR_ERR_SUCCESS) return false;
        if (first && decode.decompress_fn) {
            library_decompress = decode.decompress_fn;
            decode.decompress_fn = decompress_unless_raw;
        }
        if (exr_decoding_run(context, 0, &decode) != EXR_ERR_SUCCESS) return false;
        row += chunk.height;
    }
    return exr_decoding_destroy(context, &decode) == EXR_ERR_SUCCESS;
}

static void check_exr_header(exr_context_t context, const hdr_frame *frame, hdr_compression compression) {
    exr_attr_box2i_t data, display;
    exr_compression_t stored;
    const exr_attr_chlist_t *channels;
    float aspect = 0;
    const char *state = NULL;
    int32_t length;
    CHECK(exr_get_data_window(context, 0, &data) == EXR_ERR_SUCCESS && memcmp(&data, &frame->data, sizeof data) == 0,
          "data window");
    CHECK(exr_get_display_window(context, 0, &display) == EXR_ERR_SUCCESS &&
              memcmp(&display, &frame->display, sizeof display) == 0,
          "display window");
    CHECK(exr_get_compression(context, 0, &stored) == EXR_ERR_SUCCESS && (int)stored == (int)compression,
          "compression");
    CHECK(exr_get_pixel_aspect_ratio(context, 0, &aspect) == EXR_ERR_SUCCESS && aspect == 1.25f, "aspect %g",
          (double)aspect);
    CHECK(exr_attr_get_string(context, 0, "hdrpipeState", &length, &state) == EXR_ERR_SUCCESS &&
              strcmp(state, frame->state) == 0,
          "hdrpipeState");
    exr_attr_chromaticities_t primaries = {0};
    bool found = exr_attr_get_chromaticities(context, 0, "chromaticities", &primaries) == EXR_ERR_SUCCESS;
    CHECK(found == frame->has_chromaticities && (!found || primaries.red_x == 0.708f), "chromaticities");
    const char *names = frame->planes == 3 ? (frame->alpha ? "ABGR" : "BGR") : frame->alpha ? "AY" : "Y";
    bool same =
        exr_get_channels(context, 0, &channels) == EXR_ERR_SUCCESS && channels->num_channels == (int)strlen(names);
    for (int c = 0; same && c < channels->num_channels; c++)
        same = channels->entries[c].name.str[0] == names[c] && channels->entries[c].name.length == 1;
    CHECK(same, "channels");
}

/* The decoded samples, to be freed. header: check that too. */
static unsigned char *read_exr(const hdr_output *output, const hdr_frame *frame, hdr_compression compression,
                               bool header) {
    byte_reader reader = {0};
    reader.data = hdr_output_bytes(output, &reader.size);
    exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
    initializer.user_data = &reader;
    initializer.read_fn = read_exr_bytes;
    initializer.size_fn = exr_file_size;
    exr_context_t context;
    unsigned char *samples = calloc(hdr_frame_row_bytes(frame), (size_t)frame->height);
    bool whole = exr_start_read(&context, "memory", &initializer) == EXR_ERR_SUCCESS;
    CHECK(whole, "OpenEXRCore does not open it");
    if (!whole) return samples;
    if (header) check_exr_header(context, frame, compression);
    CHECK(read_exr_pixels(context, frame, samples), "OpenEXRCore does not read it");
    CHECK(exr_finish(&context) == EXR_ERR_SUCCESS, "exr_finish");
    return samples;
}

/* Runs the library's own pipeline, as it is, on all chunks. */
static bool write_default_chunks(exr_context_t context, const hdr_frame *frame, unsigned char *samples) {
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t chunk;
    bool first = true;
    for (int row = 0; row < frame->height; row += chunk.height, first = false) {
        if (exr_write_scanline_chunk_info(context, 0, frame->data.min_y + row, &chunk) != EXR_ERR_SUCCESS ||
            (first ? exr_encoding_initialize(context, 0, &chunk, &encode)
                   : exr_encoding_update(context, 0, &chunk, &encode)) != EXR_ERR_SUCCESS)
            return false;
        for (int c = 0; c < encode.channel_count; c++)
            aim_channel(&encode.channels[c], frame, encode.channel_count - 1 - c, samples, row);
        if ((first && exr_encoding_choose_default_routines(context, 0, &encode) != EXR_ERR_SUCCESS) ||
            exr_encoding_run(context, 0, &encode) != EXR_ERR_SUCCESS)
            return false;
    }
    return exr_encoding_destroy(context, &encode) == EXR_ERR_SUCCESS;
}

/* What comes back from a file that the library's default pipeline wrote: what a lossy compression makes of the samples.
 */
static unsigned char *default_loss(const hdr_frame *frame, hdr_compression compression, unsigned char *samples) {
    static const char *const names[2][CHANNELS_MAX] = {{"Y", "A"}, {"R", "G", "B", "A"}};
    hdr_output *output = hdr_output_memory(NULL);
    exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
    initializer.user_data = output;
    initializer.write_fn = write_exr_bytes;
    exr_context_t context;
    exr_attr_box2i_t window;
    memcpy(&window, &frame->data, sizeof window);
    exr_attr_v2f_t centre = {.x = 0, .y = 0};
    exr_pixel_type_t type = frame->sample == HDR_SAMPLE_HALF ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT;
    int part;
    bool good = exr_start_write(&context, "memory", EXR_WRITE_FILE_DIRECTLY, &initializer) == EXR_ERR_SUCCESS &&
                exr_add_part(context, "pixels", EXR_STORAGE_SCANLINE, &part) == EXR_ERR_SUCCESS &&
                exr_initialize_required_attr(context, 0, &window, &window, 1, &centre, 1, EXR_LINEORDER_INCREASING_Y,
                                             (exr_compression_t)compression) == EXR_ERR_SUCCESS;
    for (int c = 0; good && c < hdr_frame_channels(frame); c++)
        good = exr_add_channel(context, 0, names[frame->planes == 3][c], type, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1) ==
               EXR_ERR_SUCCESS;
    good = good && exr_write_header(context) == EXR_ERR_SUCCESS && write_default_chunks(context, frame, samples) &&
           exr_finish(&context) == EXR_ERR_SUCCESS && hdr_output_commit(output, NULL) == HDR_OK;
    CHECK(good, "%s: the library's own writing", hdr_compression_names[compression]);
    unsigned char *decoded = good ? read_exr(output, frame, compression, false) : NULL;
    hdr_output_free(output);
    return decoded;
}

/* Whether the loss of a compression goes beyond none. */
static bool is_lossy(const hdr_frame *frame, hdr_compression compression) {
    return (compression >= HDR_COMPRESSION_B44 && frame->sample == HDR_SAMPLE_HALF) ||
           (compression == HDR_COMPRESSION_PXR24 && frame->sample == HDR_SAMPLE_FLOAT);
}

/* Every chunk is either exactly the samples or exactly what the library would have made of them. */
static void check_exr_pixels(const hdr_frame *frame, hdr_compression compression, unsigned char *samples,
                             const unsigned char *decoded) {
    const char *name = hdr_compression_names[compression];
    size_t row_bytes = hdr_frame_row_bytes(frame), size = row_bytes * (size_t)frame->height;
    if (!is_lossy(frame, compression)) {
        CHECK(memcmp(decoded, samples, size) == 0, "%s %dx%d: pixels differ", name, frame->width, frame->height);
        return;
    }
    unsigned char *loss = default_loss(frame, compression, samples);
    size_t chunk = row_bytes * (compression == HDR_COMPRESSION_PXR24 ? 16 : 32);
    for (size_t at = 0; loss && at < size; at += chunk) {
        size_t length = size - at < chunk ? size - at : chunk;
        CHECK(memcmp(decoded + at, samples + at, length) == 0 || memcmp(decoded + at, loss + at, length) == 0,
              "%s %dx%d: pixels differ from the library's", name, frame->width, frame->height);
    }
    free(loss);
}

static void check_exr(const hdr_frame *frame, hdr_compression compression, content what, int band_rows) {
    unsigned char *samples = make_samples(frame, what);
    hdr_output *output = write_to_memory(make_exr, frame, compression, samples, band_rows, false);
    if (output) {
        unsigned char *decoded = read_exr(output, frame, compression, true);
        check_exr_pixels(frame, compression, samples, decoded);
        free(decoded);
        check_repeatable(make_exr, frame, compression, samples, band_rows, output);
    }
    hdr_output_free(output);
    free(samples);
}

static void test_exr(void) {
    static const int sizes[][2] = {{1, 1}, {3, 70}, {64, 64}, {333, 100}, {1201, 33}};
    for (int c = HDR_COMPRESSION_NONE; c <= HDR_COMPRESSION_B44A; c++)
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++)
            for (int kind = 0; kind < 8; kind++)
                for (content what = NOISE; what < CONTENTS; what++) {
                    hdr_frame frame = make_frame(sizes[i][0], sizes[i][1], kind & 1 ? 3 : 1, (kind & 2) != 0,
                                                 kind & 4 ? HDR_SAMPLE_HALF : HDR_SAMPLE_FLOAT);
                    frame.state = what == NOISE ? "linear" : "gamma 2.2";
                    frame.has_chromaticities = what == SMOOTH;
                    frame.chromaticities = wide_gamut;
                    check_exr(&frame, (hdr_compression)c, what, 32);
                    check_exr(&frame, (hdr_compression)c, what, 96);
                }
}

/* A last chunk of one row makes B44 larger than its pixels: the library refuses that one, here it is stored raw. */
static void test_exr_b44_single_row(void) {
    hdr_frame frame = make_frame(100000, 33, 3, false, HDR_SAMPLE_HALF);
    unsigned char *samples = make_samples(&frame, SMOOTH);
    hdr_output *output = write_to_memory(make_exr, &frame, HDR_COMPRESSION_B44, samples, 32, false);
    if (output) {
        unsigned char *decoded = read_exr(output, &frame, HDR_COMPRESSION_B44, true);
        size_t row_bytes = hdr_frame_row_bytes(&frame);
        CHECK(memcmp(decoded + 32 * row_bytes, samples + 32 * row_bytes, row_bytes) == 0, "the raw row differs");
        free(decoded);
    }
    hdr_output_free(output);
    free(samples);
}

/* ---- PFM ---- */

static void check_pfm(int width, int height, int planes, int band_rows) {
    hdr_frame frame = make_frame(width, height, planes, false, HDR_SAMPLE_FLOAT);
    unsigned char *samples = make_samples(&frame, NOISE);
    hdr_output *output = write_to_memory(make_pfm, &frame, HDR_COMPRESSION_NONE, samples, band_rows, false);
    size_t size = 0, row_floats = (size_t)width * (size_t)planes;
    const unsigned char *bytes = output ? hdr_output_bytes(output, &size) : NULL;
    char head[64];
    size_t head_size =
        (size_t)snprintf(head, sizeof head, "P%c\n%d %d\n-1.0\n", planes == 3 ? 'F' : 'f', width, height);
    bool same = bytes && size == head_size + row_floats * 4 * (size_t)height && memcmp(bytes, head, head_size) == 0;
    for (size_t y = 0; same && y < (size_t)height; y++)
        for (size_t x = 0; same && x < (size_t)width; x++)
            for (size_t c = 0; same && c < (size_t)planes; c++) {
                size_t in_file = ((size_t)height - 1 - y) * row_floats + x * (size_t)planes + c;
                size_t in_row = y * row_floats + c * (size_t)width + x;
                same = memcmp(bytes + head_size + in_file * 4, samples + in_row * 4, 4) == 0;
            }
    CHECK(same, "PFM %dx%dx%d in bands of %d", width, height, planes, band_rows);
    hdr_output_free(output);
    free(samples);
}

static void test_pfm(void) {
    for (int planes = 1; planes <= 3; planes += 2) {
        check_pfm(1, 1, planes, 1);
        check_pfm(17, 23, planes, 5);
        check_pfm(301, 64, planes, 64);
    }
}

int main(void) {
    test_png_pixels();
    test_png_colour();
    test_png_coding_points();
    test_exr();
    test_exr_b44_single_row();
    test_pfm();
    return check_done("test_sinks");
}

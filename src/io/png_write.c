/* The PNG sink. libpng writes what stands around the pixels; the pixels' own chunks are made here: each band of rows is
 * filtered and deflated by itself, on the thread that computed it, ends with a full flush, and becomes one IDAT chunk,
 * so that the bands joined are one zlib stream. The bytes depend on where the bands begin and end, not on threads. */
#include "io/deflate.h"
#include "io/sink.h"
#include "kernel/pngfilter.h"

#include <libdeflate.h>
#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

enum {
    CHUNK_HEAD = 8, /* length and type */
    CHUNK_TAIL = 4, /* CRC */
    ZLIB_HEAD = 2,
    ADLER_BYTES = 4,
    DEFLATE_LEVEL = 1
};

static const uint32_t adler_base = 65521; /* the largest prime below 2^16 (RFC 1950) */

typedef struct png_sink {
    hdr_sink sink; /* first, so that the one pointer is the other */
    png_structp png;
    png_infop info;
    uint64_t offset; /* where the next byte of the file goes */
    uint32_t adler;  /* of all filtered rows delivered */
    hdr_error *err;  /* of the call of libpng that is under way */
    hdr_status status;
} png_sink;

/* One band: chunk head, zlib head (first band), deflated rows; deliver adds the Adler sum (last band) and the CRC. */
typedef struct png_packer {
    hdr_deflater *deflater;
    uint8_t *filtered, *packed;
    size_t filtered_room, packed_room;
    size_t filtered_size, packed_size;
    uint32_t adler, crc;
    bool last;
} png_packer;

static int frame_depth(const hdr_frame *frame) {
    return frame->sample == HDR_SAMPLE_U8 ? 8 : 16;
}

/* ---- Around the pixels: libpng ---- */

static void on_png_error(png_structp png, png_const_charp message) {
    png_sink *self = png_get_error_ptr(png);
    if (self->status == HDR_OK)
        self->status = hdr_fail(self->err, HDR_INTERNAL, "%s: libpng: %s", hdr_output_name(self->sink.output), message);
    png_longjmp(png, 1);
}

static void on_png_warning(png_structp png, png_const_charp message) {
    (void)png, (void)message;
}

static void on_png_write(png_structp png, png_bytep data, size_t size) {
    png_sink *self = png_get_io_ptr(png);
    self->status = hdr_output_write(self->sink.output, data, size, self->offset, self->err);
    if (self->status != HDR_OK) png_error(png, "write failed");
    self->offset += size;
}

static void on_png_flush(png_structp png) {
    (void)png;
}

/* Calls a step that uses libpng, whose way of failing is to jump: it jumps to here and no further. */
static hdr_status guarded(png_sink *self, void (*step)(png_sink *self), hdr_error *err) {
    self->err = err;
    self->status = HDR_OK;
    if (setjmp(png_jmpbuf(self->png)) == 0) step(self);
    self->err = NULL;
    return self->status;
}

static void put_be32(uint8_t *out, uint32_t value) {
    for (int i = 0; i < 4; i++)
        out[i] = (uint8_t)(value >> (24 - 8 * i));
}

/* A colour chunk's number: 100000 times the value. False where the chunk has no room for it (ACES primaries lie below
 * 0). */
static bool chunk_fraction(double value, uint8_t out[4]) {
    double scaled = floor(value * 100000 + 0.5);
    if (!(scaled >= 0 && scaled <= PNG_UINT_31_MAX)) return false;
    put_be32(out, (uint32_t)scaled);
    return true;
}

/* Written without libpng's help, which judges chromaticities and would refuse some that files have. */
static void write_chromaticities(png_sink *self) {
    const hdr_chromaticities *c = &self->sink.frame.chromaticities;
    const double *point[4] = {c->white, c->red, c->green, c->blue};
    uint8_t data[32];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 2; j++)
            if (!chunk_fraction(point[i][j], data + 8 * i + 4 * j)) return;
    png_write_chunk(self->png, (png_const_bytep) "cHRM", data, sizeof data);
}

/* Readers, libpng among them, take no value outside of these for meant: an exponent so extreme is left unsaid. */
enum { GAMMA_LEAST = 16, GAMMA_MOST = 625000000 };

static void write_gamma(png_sink *self, double encoding_exponent) {
    uint8_t data[4];
    double scaled = encoding_exponent * 100000;
    if (scaled >= GAMMA_LEAST && scaled <= GAMMA_MOST && chunk_fraction(encoding_exponent, data))
        png_write_chunk(self->png, (png_const_bytep) "gAMA", data, sizeof data);
}

static bool near(const double a[2], double x, double y) {
    return fabs(a[0] - x) <= 1e-5 && fabs(a[1] - y) <= 1e-5;
}

/* ITU-T H.273's code for the frame's primaries; 0: none. */
static uint8_t primaries_code(const hdr_frame *frame) {
    static const struct {
        uint8_t code;
        double red[2], green[2], blue[2], white[2];
    } known[] = {
        {9, {0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, {0.3127, 0.3290}},  /* BT.2020 */
        {11, {0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, {0.314, 0.351}},   /* SMPTE RP 431-2 */
        {12, {0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, {0.3127, 0.3290}}, /* SMPTE EG 432-1 */
    };
    const hdr_chromaticities *c = &frame->chromaticities;
    if (!frame->has_chromaticities) return 1;
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        if (near(c->red, known[i].red[0], known[i].red[1]) && near(c->green, known[i].green[0], known[i].green[1]) &&
            near(c->blue, known[i].blue[0], known[i].blue[1]) && near(c->white, known[i].white[0], known[i].white[1]))
            return known[i].code;
    return 0;
}

/* ITU-T H.273's code for a transfer function that only cICP can name; 0: none. */
static uint8_t transfer_code(const char *state) {
    return strcmp(state, "rec709") == 0 ? 1 : strncmp(state, "pq", 2) == 0 ? 16 : strcmp(state, "hlg") == 0 ? 18 : 0;
}

static void write_coding_points(png_sink *self, uint8_t transfer) {
    uint8_t data[4] = {primaries_code(&self->sink.frame), transfer, 0 /* RGB */, 1 /* full range */};
    if (data[0] != 0) png_write_chunk(self->png, (png_const_bytep) "cICP", data, sizeof data);
}

/* What the codes mean: the transfer function, and the primaries where they are not Rec.709's. */
static void write_colour(png_sink *self) {
    const hdr_frame *frame = &self->sink.frame;
    uint8_t transfer = transfer_code(frame->state);
    if (transfer != 0)
        write_coding_points(self, transfer);
    else if (strcmp(frame->state, "linear") == 0)
        write_gamma(self, 1);
    else if (strncmp(frame->state, "gamma", 5) == 0)
        write_gamma(self, 1 / frame->gamma);
    else if (strcmp(frame->state, "srgb") == 0 && frame->has_chromaticities)
        write_gamma(self, 1 / 2.2);
    if (frame->has_chromaticities) write_chromaticities(self);
}

/* Small whole numbers that are as 1 : aspect: the first convergent of a continued fraction that gives the float itself.
 * False: one is too large for the chunk, or the aspect is no ratio. */
static bool small_ratio(float aspect, png_uint_32 ratio[2]) {
    bool wide = aspect >= 1;
    double rest = wide ? (double)aspect : 1 / (double)aspect; /* large : small */
    double large = 1, small = 0, large_before = 0, small_before = 1;
    do {
        double whole = floor(rest), next_large = whole * large + large_before,
               next_small = whole * small + small_before;
        if (!(next_large >= 1 && next_large <= PNG_UINT_31_MAX)) return false;
        large_before = large;
        small_before = small;
        large = next_large;
        small = next_small;
        rest = 1 / (rest - whole);
    } while ((float)(wide ? large / small : small / large) != aspect);
    ratio[0] = (png_uint_32)(wide ? small : large);
    ratio[1] = (png_uint_32)(wide ? large : small);
    return true;
}

/* A pixel's width over its height, as the pixels that a length holds across and down. */
static void set_aspect(png_sink *self) {
    png_uint_32 density[2];
    if (self->sink.frame.pixel_aspect != 1 && small_ratio(self->sink.frame.pixel_aspect, density))
        png_set_pHYs(self->png, self->info, density[0], density[1], PNG_RESOLUTION_UNKNOWN);
}

static void set_significant_bits(png_sink *self) {
    const hdr_frame *frame = &self->sink.frame;
    if (frame->bits >= frame_depth(frame)) return;
    png_byte bits = (png_byte)frame->bits;
    png_color_8 significant = {
        .red = bits, .green = bits, .blue = bits, .gray = bits, .alpha = (png_byte)frame_depth(frame)};
    png_set_sBIT(self->png, self->info, &significant);
}

static void write_head(png_sink *self) {
    const hdr_frame *frame = &self->sink.frame;
    int colour = (frame->planes == 3 ? PNG_COLOR_MASK_COLOR : 0) | (frame->alpha ? PNG_COLOR_MASK_ALPHA : 0);
    png_set_user_limits(self->png, PNG_UINT_31_MAX, PNG_UINT_31_MAX); /* libpng's own are a million */
    png_set_IHDR(self->png, self->info, (png_uint_32)frame->width, (png_uint_32)frame->height, frame_depth(frame),
                 colour, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    set_significant_bits(self);
    set_aspect(self);
    if (strcmp(frame->state, "srgb") == 0 && !frame->has_chromaticities)
        png_set_sRGB_gAMA_and_cHRM(self->png, self->info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info_before_PLTE(self->png, self->info);
    write_colour(self);
    png_write_info(self->png, self->info);
}

/* Not png_write_end, which knows nothing of IDAT chunks that it did not write. */
static void write_tail(png_sink *self) {
    png_write_chunk(self->png, (png_const_bytep) "IEND", NULL, 0);
}

static hdr_status png_begin(hdr_sink *sink, hdr_error *err) {
    png_sink *self = (png_sink *)sink;
    return guarded(self, write_head, err);
}

static hdr_status png_end(hdr_sink *sink, hdr_error *err) {
    png_sink *self = (png_sink *)sink;
    return guarded(self, write_tail, err);
}

/* ---- The pixels ---- */

static hdr_status png_packer_new(hdr_sink *sink, void **packer, hdr_error *err) {
    png_packer *self = hdr_alloc(1, sizeof *self);
    if (self) self->deflater = hdr_deflater_new(DEFLATE_LEVEL);
    if (!self || !self->deflater) {
        free(self);
        return hdr_fail(err, HDR_INTERNAL, "%s: out of memory", hdr_output_name(sink->output));
    }
    *packer = self;
    return HDR_OK;
}

static void png_packer_free(hdr_sink *sink, void *packer) {
    png_packer *self = packer;
    (void)sink;
    if (!self) return;
    hdr_deflater_free(self->deflater);
    free(self->filtered);
    free(self->packed);
    free(self);
}

static hdr_status make_room(const hdr_sink *sink, uint8_t **buffer, size_t *room, size_t size, hdr_error *err) {
    if (size <= *room) return HDR_OK;
    uint8_t *grown = hdr_grow(*buffer, size, 1);
    if (!grown) return hdr_fail(err, HDR_INTERNAL, "%s: out of memory", hdr_output_name(sink->output));
    *buffer = grown;
    *room = size;
    return HDR_OK;
}

/* Each row leaves with its filter type, 1 for Sub, in front. */
static hdr_status filter_band(const hdr_sink *sink, png_packer *packer, int rows, const void *samples, hdr_error *err) {
    const hdr_frame *frame = &sink->frame;
    size_t row_bytes = hdr_frame_row_bytes(frame), channels = (size_t)hdr_frame_channels(frame);
    packer->filtered_size = (row_bytes + 1) * (size_t)rows;
    if (make_room(sink, &packer->filtered, &packer->filtered_room, packer->filtered_size, err) != HDR_OK)
        return HDR_INTERNAL;
    const uint8_t *in = samples;
    uint8_t *out = packer->filtered;
    for (int row = 0; row < rows; row++, in += row_bytes, out += row_bytes + 1) {
        out[0] = PNG_FILTER_VALUE_SUB;
        if (frame->sample == HDR_SAMPLE_U8)
            hdr_png_sub_8(out + 1, in, row_bytes, channels);
        else
            hdr_png_sub_16(out + 1, (const uint16_t *)in, row_bytes / 2, channels);
    }
    return HDR_OK;
}

/* Deflates the filtered band behind what stands in packed. The room is a function of the size alone, as the bytes may
 * depend on it. */
static hdr_status deflate_band(const hdr_sink *sink, png_packer *packer, hdr_error *err) {
    size_t room = hdr_deflate_bound(packer->filtered_size);
    hdr_deflate_form form = packer->last ? HDR_DEFLATE_LAST : HDR_DEFLATE_PART;
    size_t size = hdr_deflate(packer->deflater, form, packer->filtered, packer->filtered_size,
                              packer->packed + packer->packed_size, room);
    packer->packed_size += size;
    if (size == 0 || packer->packed_size - CHUNK_HEAD > PNG_UINT_31_MAX - ADLER_BYTES)
        return hdr_fail(err, HDR_BAD_DATA, "%s: rows are too wide for PNG", hdr_output_name(sink->output));
    return HDR_OK;
}

static hdr_status png_pack(hdr_sink *sink, void *packer, int first_row, int rows, void *samples, hdr_error *err) {
    png_packer *self = packer;
    hdr_status status = filter_band(sink, self, rows, samples, err);
    if (status != HDR_OK) return status;
    self->last = rows == sink->frame.height - first_row;
    self->packed_size = CHUNK_HEAD + (first_row == 0 ? ZLIB_HEAD : 0);
    size_t room = CHUNK_HEAD + ZLIB_HEAD + hdr_deflate_bound(self->filtered_size) + ADLER_BYTES + CHUNK_TAIL;
    if ((status = make_room(sink, &self->packed, &self->packed_room, room, err)) != HDR_OK) return status;
    memcpy(self->packed + 4, "IDAT", 4);
    memcpy(self->packed + CHUNK_HEAD, "\x78\x01", ZLIB_HEAD); /* 32 KiB window, fastest; in later bands overwritten */
    if ((status = deflate_band(sink, self, err)) != HDR_OK) return status;
    self->adler = libdeflate_adler32(1, self->filtered, self->filtered_size);
    self->crc = libdeflate_crc32(0, self->packed + 4, self->packed_size - 4);
    return HDR_OK;
}

/* The Adler sum of two strings joined. A sum's low half is a = 1 + the sum of the bytes, its high half b the sum of all
 * values a took on the way. The second string by itself began with a = 1; behind the first it begins with the first's
 * a, so that its a is larger by a1 - 1 after each of its bytes, and b by length times as much (all modulo 65521). */
static uint32_t adler32_join(uint32_t first, uint32_t second, size_t second_length) {
    uint64_t a1 = first & 0xffff, b1 = first >> 16, a2 = second & 0xffff, b2 = second >> 16;
    uint64_t more = (a1 + adler_base - 1) % adler_base;
    uint64_t a = (a2 + more) % adler_base;
    uint64_t b = (b1 + b2 + second_length % adler_base * more) % adler_base;
    return (uint32_t)(b << 16 | a);
}

static hdr_status png_deliver(hdr_sink *sink, void *packer, hdr_error *err) {
    png_sink *self = (png_sink *)sink;
    png_packer *band = packer;
    self->adler = adler32_join(self->adler, band->adler, band->filtered_size);
    uint8_t *end = band->packed + band->packed_size;
    if (band->last) {
        put_be32(end, self->adler);
        band->crc = libdeflate_crc32(band->crc, end, ADLER_BYTES);
        end += ADLER_BYTES;
    }
    put_be32(band->packed, (uint32_t)(end - band->packed) - CHUNK_HEAD);
    put_be32(end, band->crc);
    end += CHUNK_TAIL;
    size_t size = (size_t)(end - band->packed);
    hdr_status status = hdr_output_write(sink->output, band->packed, size, self->offset, err);
    self->offset += size;
    return status;
}

/* ---- The sink ---- */

static void png_close(hdr_sink *sink) {
    png_sink *self = (png_sink *)sink;
    if (!self) return;
    png_destroy_write_struct(&self->png, &self->info);
    free(self);
}

hdr_sink *hdr_png_create(hdr_output *output, const hdr_frame *frame, hdr_error *err) {
    png_sink *self = hdr_alloc(1, sizeof *self);
    if (self) {
        self->sink = (hdr_sink){.frame = *frame,
                                .output = output,
                                .band_multiple = 1,
                                .begin = png_begin,
                                .packer_new = png_packer_new,
                                .pack = png_pack,
                                .deliver = png_deliver,
                                .packer_free = png_packer_free,
                                .end = png_end,
                                .close = png_close};
        self->adler = 1;
        self->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, self, on_png_error, on_png_warning);
        if (self->png) self->info = png_create_info_struct(self->png);
    }
    if (!self || !self->info) {
        hdr_fail(err, HDR_INTERNAL, "%s: out of memory", hdr_output_name(output));
        png_close((hdr_sink *)self);
        return NULL;
    }
    png_set_write_fn(self->png, self, on_png_write, on_png_flush);
    return &self->sink;
}

/* The Radiance HDR sink: rows from the top down, each component of a row packed by run lengths. */
#include "io/rgbe.h"
#include "io/sink.h"

#include "picture/colour.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RUN_LEAST = 4, RUN_MOST = 127, PLAIN_MOST = 128 };

typedef struct rgbe_sink {
    hdr_sink sink;   /* first, so that the one pointer is the other */
    uint64_t offset; /* behind what has been delivered */
} rgbe_sink;

typedef struct rgbe_packer {
    unsigned char *component; /* of a row, all of one component and then all of the next */
    unsigned char *packed;
    size_t packed_room, size;
} rgbe_packer;

/* ---- The header ---- */

static hdr_status rgbe_begin(hdr_sink *sink, hdr_error *err) {
    rgbe_sink *self = (rgbe_sink *)sink;
    const hdr_frame *frame = &sink->frame;
    /* Always: Radiance takes other primaries than Rec.709's where there is no such line. Grey is that of D65, and has
     * no colour of its own. */
    bool own = frame->has_chromaticities && frame->planes == 3;
    const hdr_chromaticities *c = own ? &frame->chromaticities : &hdr_rec709;
    char head[512], aspect[64] = "";
    /* Radiance means height over width */
    if (frame->pixel_aspect != 1) snprintf(aspect, sizeof aspect, "PIXASPECT=%.9g\n", 1 / (double)frame->pixel_aspect);
    int length = snprintf(head, sizeof head,
                          "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nPRIMARIES=%.7g %.7g %.7g %.7g %.7g %.7g %.7g %.7g\n"
                          "%s\n-Y %d +X %d\n",
                          c->red[0], c->red[1], c->green[0], c->green[1], c->blue[0], c->blue[1], c->white[0],
                          c->white[1], aspect, frame->height, frame->width);
    self->offset = (uint64_t)length;
    return hdr_output_write(sink->output, head, (size_t)length, 0, err);
}

/* ---- Pixels ---- */

/* The exponent is that of the largest component, and mantissas are rounded to nearest. So what is read back is within
 * half a step. What is below 0, or has an exponent below the least, is 0; what is too large for the format is held at
 * its largest value. */
static void encode_pixel(const float c[3], unsigned char rgbe[4]) {
    float largest = fmaxf(fmaxf(c[0], c[1]), c[2]);
    int exponent = 0;
    memset(rgbe, 0, 4);
    if (!(largest > 0)) return;
    if (frexpf(largest, &exponent) >= 255.5f / 256) exponent++; /* the mantissa would be rounded to 256 */
    if (exponent < 1 - 128) return;
    if (exponent > 255 - 128) exponent = 255 - 128;
    double scale = ldexp(1, 8 - exponent);
    for (int i = 0; i < 3; i++) {
        double mantissa = floor((double)c[i] * scale + 0.5);
        rgbe[i] = (unsigned char)(mantissa > 255 ? 255 : mantissa < 0 ? 0 : mantissa);
    }
    rgbe[3] = (unsigned char)(exponent + 128);
}

static void encode_row(const hdr_frame *frame, const unsigned char *samples, unsigned char *component) {
    size_t width = (size_t)frame->width;
    const unsigned char *plane[3];
    for (size_t p = 0; p < 3; p++)
        plane[p] = samples + (frame->planes == 3 ? p : 0) * width * sizeof(float);
    for (size_t x = 0; x < width; x++) {
        float c[3];
        unsigned char rgbe[4];
        for (int p = 0; p < 3; p++)
            memcpy(&c[p], plane[p] + x * sizeof(float), sizeof(float));
        encode_pixel(c, rgbe);
        for (size_t p = 0; p < 4; p++)
            component[p * width + x] = rgbe[p];
    }
}

static size_t run_at(const unsigned char *bytes, size_t count) {
    size_t length = 1;
    while (length < count && length < RUN_MOST && bytes[length] == bytes[0])
        length++;
    return length;
}

/* Packs the bytes of a component to at most twice their number. Returns the end. */
static unsigned char *pack_component(const unsigned char *bytes, size_t count, unsigned char *out) {
    while (count > 0) {
        size_t plain = 0, run = 0;
        while (plain < count && plain < PLAIN_MOST && (run = run_at(bytes + plain, count - plain)) < RUN_LEAST)
            plain++;
        if (plain > 0) {
            *out++ = (unsigned char)plain;
            memcpy(out, bytes, plain);
            out += plain;
        } else {
            *out++ = (unsigned char)(128 + run);
            *out++ = bytes[0];
        }
        bytes += plain ? plain : run;
        count -= plain ? plain : run;
    }
    return out;
}

/* Widths that cannot be packed are written pixel by pixel. */
static unsigned char *pack_row(size_t width, const unsigned char *component, unsigned char *out) {
    if (width < HDR_RGBE_SHORTEST || width > HDR_RGBE_LONGEST) {
        for (size_t x = 0; x < width; x++)
            for (size_t p = 0; p < 4; p++)
                *out++ = component[p * width + x];
        return out;
    }
    *out++ = 2;
    *out++ = 2;
    *out++ = (unsigned char)(width >> 8);
    *out++ = (unsigned char)(width & 255);
    for (size_t p = 0; p < 4; p++)
        out = pack_component(component + p * width, width, out);
    return out;
}

/* ---- The sink ---- */

static void rgbe_packer_free(hdr_sink *sink, void *packer) {
    rgbe_packer *self = packer;
    (void)sink;
    if (!self) return;
    free(self->component);
    free(self->packed);
    free(self);
}

static hdr_status rgbe_packer_new(hdr_sink *sink, void **packer, hdr_error *err) {
    rgbe_packer *self = hdr_alloc(1, sizeof *self);
    if (self) self->component = hdr_alloc((size_t)sink->frame.width, 4);
    if (self && self->component) {
        *packer = self;
        return HDR_OK;
    }
    rgbe_packer_free(sink, self);
    *packer = NULL;
    return hdr_fail(err, HDR_INTERNAL, "%s: out of memory", hdr_output_name(sink->output));
}

static hdr_status rgbe_pack(hdr_sink *sink, void *packer, int first_row, int rows, void *samples, hdr_error *err) {
    rgbe_packer *self = packer;
    size_t width = (size_t)sink->frame.width, most = (4 + 4 * 2 * width) * (size_t)rows;
    (void)first_row;
    if (most > self->packed_room) {
        unsigned char *grown = hdr_grow(self->packed, most, 1);
        if (!grown) return hdr_fail(err, HDR_INTERNAL, "%s: out of memory", hdr_output_name(sink->output));
        self->packed = grown;
        self->packed_room = most;
    }
    unsigned char *out = self->packed;
    for (int row = 0; row < rows; row++) {
        encode_row(&sink->frame, (const unsigned char *)samples + hdr_frame_row_bytes(&sink->frame) * (size_t)row,
                   self->component);
        out = pack_row(width, self->component, out);
    }
    self->size = (size_t)(out - self->packed);
    return HDR_OK;
}

static hdr_status rgbe_deliver(hdr_sink *sink, void *packer, hdr_error *err) {
    rgbe_sink *self = (rgbe_sink *)sink;
    const rgbe_packer *band = packer;
    uint64_t offset = self->offset;
    self->offset += band->size;
    return hdr_output_write(sink->output, band->packed, band->size, offset, err);
}

hdr_sink *hdr_rgbe_create(hdr_output *output, const hdr_frame *frame, hdr_error *err) {
    rgbe_sink *self = hdr_alloc(1, sizeof *self);
    if (!self) {
        hdr_fail(err, HDR_INTERNAL, "%s: out of memory", hdr_output_name(output));
        return NULL;
    }
    self->sink = (hdr_sink){.frame = *frame,
                            .output = output,
                            .band_multiple = 1,
                            .begin = rgbe_begin,
                            .packer_new = rgbe_packer_new,
                            .pack = rgbe_pack,
                            .deliver = rgbe_deliver,
                            .packer_free = rgbe_packer_free,
                            .end = hdr_sink_end_plainly,
                            .close = hdr_sink_close_plainly};
    return &self->sink;
}

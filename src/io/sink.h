/* A sink: takes bands of finished samples, packs each on the thread that made it, and delivers the packed bytes in
 * order. */
#ifndef HDR_SINK_H
#define HDR_SINK_H

#include "io/output.h"
#include "picture/picture.h"

/* What a sample is when it leaves the sweep. */
typedef enum hdr_sample {
    HDR_SAMPLE_U8,    /* codes, interleaved by pixel: grey | grey alpha | r g b | r g b a */
    HDR_SAMPLE_U16,   /* the same, native uint16_t */
    HDR_SAMPLE_FLOAT, /* planar: for each row, each channel's width floats in turn, in the order R G B A or Y A */
    HDR_SAMPLE_HALF   /* planar, uint16_t bit patterns */
} hdr_sample;

/* The picture that is to be written. */
typedef struct hdr_frame {
    int width, height;        /* of the window that is written; at least 1 */
    hdr_window data, display; /* what EXR's header says; data is the window that is written */
    int planes;               /* 1 or 3 */
    bool alpha;
    hdr_sample sample;
    int bits;                /* codes: significant bits, 1 ... 16 */
    const char *state;       /* "linear", "srgb", "gamma 2.2" */
    double gamma;            /* state "gamma G": G */
    bool has_chromaticities; /* the pixels' primaries are these, not Rec.709 */
    hdr_chromaticities chromaticities;
    float pixel_aspect;
    const hdr_bytes *attributes; /* of the file's header, as io/exr_attributes.h has them; NULL: none */
    const char *record;          /* the chain, for a format that keeps it; NULL: it does not */
} hdr_frame;

static inline int hdr_frame_channels(const hdr_frame *frame) {
    return frame->planes + (frame->alpha ? 1 : 0);
}
static inline size_t hdr_sample_size(hdr_sample sample) {
    return sample == HDR_SAMPLE_U8 ? 1 : sample == HDR_SAMPLE_FLOAT ? 4 : 2;
}
/* Bytes of one row of samples, in either layout. */
static inline size_t hdr_frame_row_bytes(const hdr_frame *frame) {
    return (size_t)frame->width * (size_t)hdr_frame_channels(frame) * hdr_sample_size(frame->sample);
}

typedef struct hdr_sink hdr_sink;
struct hdr_sink {
    hdr_frame frame;
    hdr_output *output;
    int band_multiple; /* a band's first row and height are multiples of this (the last band's height may be less) */
    /* Writes what comes before the pixels. Called once, before any band. */
    hdr_status (*begin)(hdr_sink *sink, hdr_error *err);
    /* One packer per thread holds the buffers. */
    hdr_status (*packer_new)(hdr_sink *sink, void **packer, hdr_error *err);
    /* Packs a band of rows (any thread, any order; several at a time). samples: rows * hdr_frame_row_bytes, may be
     * overwritten. The packed bytes stay in the packer until its next pack. first: band of the frame's row 0; last:
     * that of its last row. */
    hdr_status (*pack)(hdr_sink *sink, void *packer, int first_row, int rows, void *samples, hdr_error *err);
    /* Writes the band that the packer holds. Called in the order of the rows, one at a time. */
    hdr_status (*deliver)(hdr_sink *sink, void *packer, hdr_error *err);
    void (*packer_free)(hdr_sink *sink, void *packer);
    /* Writes what comes after the pixels. */
    hdr_status (*end)(hdr_sink *sink, hdr_error *err);
    void (*close)(hdr_sink *sink); /* frees; needed in any case */
};

/* For sinks that have nothing to write behind the pixels, and that hold no memory but themselves. */
hdr_status hdr_sink_end_plainly(hdr_sink *sink, hdr_error *err);
void hdr_sink_close_plainly(hdr_sink *sink);

typedef enum hdr_compression {
    HDR_COMPRESSION_NONE,
    HDR_COMPRESSION_RLE,
    HDR_COMPRESSION_ZIPS,
    HDR_COMPRESSION_ZIP,
    HDR_COMPRESSION_PIZ,
    HDR_COMPRESSION_PXR24,
    HDR_COMPRESSION_B44,
    HDR_COMPRESSION_B44A,
    HDR_COMPRESSION_DWAA,
    HDR_COMPRESSION_DWAB
} hdr_compression; /* in the order of hdr_compression_names (exr_compression.c) and of OpenEXR's own numbers */
extern const char *const hdr_compression_names[];

/* Each takes a frame that fits it: png U8 or U16, pfm and rgbe FLOAT without alpha, pfs and planes FLOAT, exr FLOAT or
 * HALF. planes is for an output that takes pixels. */
hdr_sink *hdr_planes_create(hdr_output *output, const hdr_frame *frame, hdr_error *err);
hdr_sink *hdr_png_create(hdr_output *output, const hdr_frame *frame, hdr_error *err);
hdr_sink *hdr_pfm_create(hdr_output *output, const hdr_frame *frame, hdr_error *err);
hdr_sink *hdr_rgbe_create(hdr_output *output, const hdr_frame *frame, hdr_error *err);
hdr_sink *hdr_pfs_create(hdr_output *output, const hdr_frame *frame, hdr_error *err);
/* dwa_level: how much DWAA and DWAB may lose (OpenEXR's dwaCompressionLevel, 45 by default); of no effect on others. */
hdr_sink *hdr_exr_create(hdr_output *output, const hdr_frame *frame, hdr_compression compression, float dwa_level,
                         hdr_error *err);

#endif

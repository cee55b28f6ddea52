/* The headers of an EXR file, part by part: walked with bounded memory, and reduced to what choosing among the parts
 * and decoding one of them need. */
#ifndef HDR_EXR_WALK_H
#define HDR_EXR_WALK_H

#include "io/input.h"

#include <openexr.h>

enum { HDR_EXR_LONGEST_NAME = 255 };

/* The name, type and size in front of an attribute's value. */
typedef struct hdr_exr_attribute {
    char name[HDR_EXR_LONGEST_NAME + 1], type[HDR_EXR_LONGEST_NAME + 1];
    char shown[HDR_EXR_LONGEST_NAME + 1]; /* the name, fit for a message */
    uint32_t size;
    uint64_t value; /* its offset */
} hdr_exr_attribute;

typedef struct hdr_exr_channel {
    const char *name;
    exr_pixel_type_t type;
    int x_sampling, y_sampling;
} hdr_exr_channel;

typedef struct hdr_exr_part {
    char name[HDR_CHANNEL_NAME], view[HDR_CHANNEL_NAME], type[HDR_CHANNEL_NAME]; /* empty where they are not stated */
    bool tiled, deep;
    bool counted;         /* chunk_count is stated */
    uint64_t chunk_count; /* in a multi-part file the entries of its chunk table */
    hdr_bytes text;       /* the file that OpenEXRCore gets to see: this part alone, as if it were the only one */
    int channel_count;
    hdr_exr_channel *channels; /* as far as the list is sound; names are in the text */
    int view_count;
    const char **views;       /* multiView */
    hdr_bytes views_text;     /* where the views' names are */
    hdr_window data, display; /* unchecked; empty where they are not stated */
    int compression;          /* unchecked; -1: not stated */
    uint32_t tile_width, tile_height;
    unsigned tile_mode; /* of levels, and how their sizes are rounded, as stored */
} hdr_exr_part;

typedef struct hdr_exr_file {
    bool multi_part;
    hdr_exr_part *parts;
    int count;
    uint64_t tables; /* where the chunk tables begin, one behind the other: right behind the last header */
} hdr_exr_file;

/* Is told of every attribute in passing. */
typedef struct hdr_exr_visitor {
    hdr_status (*attribute)(void *context, int part, const hdr_exr_attribute *attribute, hdr_error *err);
    void *context;
} hdr_exr_visitor;

/* HDR_BAD_DATA: damaged. visitor may be NULL. file is cleared first; free it in any case. */
hdr_status hdr_exr_walk(hdr_input *input, hdr_exr_file *file, const hdr_exr_visitor *visitor, hdr_error *err);
/* Appends a header's beginning, the magic number and version word; and an attribute, as a file has it. A value longer
 * than `longest` is HDR_BAD_DATA. */
hdr_status hdr_exr_begin(hdr_bytes *to, hdr_error *err);
/* The same of what stands in front of an attribute's value. */
hdr_status hdr_exr_label(hdr_bytes *to, const char *name, const char *type, uint32_t size, hdr_error *err);
hdr_status hdr_exr_keep(hdr_input *input, const hdr_exr_attribute *attribute, uint32_t longest, hdr_bytes *to,
                        hdr_error *err);
void hdr_exr_file_free(hdr_exr_file *file);

/* Names in a damaged header may be anything; messages are to be text. */
void hdr_exr_make_plain(char *text);

static inline uint32_t hdr_little_endian_32(const unsigned char *bytes) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}
static inline uint64_t hdr_little_endian_64(const unsigned char *bytes) {
    return hdr_little_endian_32(bytes) | (uint64_t)hdr_little_endian_32(bytes + 4) << 32;
}

#endif

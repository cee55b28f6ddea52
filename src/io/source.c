/* Tells by the first bytes which format an input is in. */
#include "io/contents.h"
#include "io/source.h"

#include <stdio.h>
#include <string.h>

enum { LOOKED_AT = 16, SHOWN = 8 };

/* Formats that are recognised in order to say so. */
static const struct {
    const char *magic;
    size_t length;
    const char *what;
} strangers[] = {
    {"\x89PNG\r\n\x1a\n", 8,
     "a PNG, a display picture already; the chain wants the HDR picture (EXR) that it was made from"},
    {"\xff\xd8\xff", 3,
     "a JPEG, a display picture already; the chain wants the HDR picture (EXR) that it was made from"},
    {"II*\0", 4, "a TIFF, which is not read; convert it to EXR"},
    {"MM\0*", 4, "a TIFF, which is not read; convert it to EXR"},
    {"\x1f\x8b", 2, "gzip data; unpack it first"},
    {"hdrpipe ", 8, "the head of a pipe, and no picture yet: end that pipe with hdr-exr"},
};

/* Formats that are read. */
static const struct {
    const char *magic;
    size_t length;
    hdr_source *(*open)(hdr_input *input, const hdr_reading *reading, hdr_error *err);
} known[] = {
    {"\x76\x2f\x31\x01", 4, hdr_exr_open},
    {"#?", 2, hdr_rgbe_open}, /* RADIANCE or RGBE, as a rule */
    {"PF\n", 3, hdr_pfm_open},
    {"PF\r", 3, hdr_pfm_open},
    {"PF ", 3, hdr_pfm_open},
    {"Pf\n", 3, hdr_pfm_open},
    {"Pf\r", 3, hdr_pfm_open},
    {"Pf ", 3, hdr_pfm_open},
    {"PFS1\n", 5, hdr_pfs_open},
};

/* The first bytes as a C string would be written. */
static void show_bytes(const unsigned char *bytes, size_t count, char text[4 * SHOWN + 1]) {
    char *to = text;
    *to = '\0';
    for (size_t i = 0; i < count && i < SHOWN; i++)
        to += sprintf(to, bytes[i] >= ' ' && bytes[i] <= '~' ? "%c" : "\\x%02x", bytes[i]);
}

static hdr_status refuse(hdr_input *input, const unsigned char *bytes, size_t count, hdr_error *err) {
    const char *name = hdr_input_name(input);
    if (count == 0)
        return hdr_fail(err, HDR_BAD_DATA, "%s: no data: the program before this one may have failed", name);
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        if (count < known[i].length && memcmp(bytes, known[i].magic, count) == 0)
            return hdr_fail(err, HDR_BAD_DATA, "%s: the file ends within its header", name);
    for (size_t i = 0; i < sizeof strangers / sizeof strangers[0]; i++)
        if (count >= strangers[i].length && memcmp(bytes, strangers[i].magic, strangers[i].length) == 0)
            return hdr_fail(err, HDR_BAD_DATA, "%s: this is %s", name, strangers[i].what);
    char text[4 * SHOWN + 1];
    show_bytes(bytes, count, text);
    return hdr_fail(err, HDR_BAD_DATA,
                    "%s: not a picture that hdrpipe reads (EXR, Radiance HDR, PFM, PFS); it begins with \"%s\"", name,
                    text);
}

/* Formats other than EXR hold one picture, whole. */
static hdr_status refuse_choice(hdr_input *input, const hdr_reading *reading, hdr_error *err) {
    const char *option = reading->part && strcmp(reading->part, "0") != 0 ? "part"
                         : reading->layer                                 ? "layer"
                         : reading->channel                               ? "channel"
                         : !reading->proxy && reading->level > 0          ? "level"
                                                                          : NULL;
    if (!option) return HDR_OK;
    return hdr_fail(err, HDR_BAD_DATA, "%s: --%s is for EXR files, and this is none: it holds one picture only",
                    hdr_input_name(input), option);
}

typedef hdr_source *(*opener)(hdr_input *input, const hdr_reading *reading, hdr_error *err);

/* NULL: it begins like no format that is read. */
static opener opener_of(const unsigned char *start, int64_t count) {
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        if ((size_t)count >= known[i].length && memcmp(start, known[i].magic, known[i].length) == 0)
            return known[i].open;
    return NULL;
}

static hdr_source *open_format(hdr_input *input, const hdr_reading *reading, hdr_error *err) {
    unsigned char start[LOOKED_AT];
    if (hdr_input_get_joined(input)) {
        hdr_fail(err, HDR_USAGE, "pictures that are joined belong to a chain that begins with a verb that joins them");
        return NULL;
    }
    if (hdr_input_get_planes(input))
        return refuse_choice(input, reading, err) == HDR_OK ? hdr_planes_open(input, err) : NULL;
    int64_t count = hdr_input_read(input, start, sizeof start, 0, err);
    if (count < 0) return NULL;
    opener open = opener_of(start, count);
    if (open && (open == hdr_exr_open || refuse_choice(input, reading, err) == HDR_OK))
        return open(input, reading, err);
    if (open) return NULL;
    refuse(input, start, (size_t)count, err);
    return NULL;
}

hdr_source *hdr_source_open(hdr_input *input, const hdr_reading *reading, hdr_error *err) {
    hdr_source *source = open_format(input, reading, err);
    return source && reading->cropped ? hdr_crop_open(source, &reading->crop, err) : source;
}

void hdr_source_close(hdr_source *source) {
    if (source) source->close(source);
}

hdr_contents *hdr_source_contents(hdr_input *input, const hdr_reading *reading, hdr_error *err) {
    unsigned char start[LOOKED_AT];
    int64_t count = hdr_input_read(input, start, sizeof start, 0, err);
    if (count < 0) return NULL;
    if (opener_of(start, count) == hdr_exr_open) return hdr_exr_contents(input, err);
    hdr_source *source = hdr_source_open(input, &(hdr_reading){.memory = reading->memory}, err);
    hdr_contents *contents = source ? hdr_contents_of_picture(&source->picture, err) : NULL;
    hdr_source_close(source);
    return contents;
}

hdr_status hdr_source_attributes(hdr_input *input, const hdr_picture *picture, hdr_exr_fate fate, hdr_bytes *out,
                                 int *left_out, hdr_error *err) {
    const hdr_joined *joined = hdr_input_get_joined(input);
    *left_out = 0;
    if (joined) input = joined->members[0];
    return strcmp(picture->format, "exr") ? HDR_OK : hdr_exr_attributes(input, picture->part, fate, out, left_out, err);
}

hdr_status hdr_source_number(hdr_input *input, const hdr_picture *picture, const char *name, double *number,
                             hdr_error *err) {
    bool found = false;
    if (!strcmp(picture->format, "exr")) {
        hdr_status status = hdr_exr_number(input, picture->part, name, &found, number, err);
        if (status != HDR_OK) return status;
    }
    if (found) return HDR_OK;
    return hdr_fail(err, HDR_BAD_DATA, "%s: its header has no attribute '%.200s'", hdr_input_name(input), name);
}

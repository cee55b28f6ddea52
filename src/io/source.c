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
    {"#?RADIANCE", 10, "a Radiance HDR picture, which is not read; convert it to EXR"},
    {"#?RGBE", 6, "a Radiance HDR picture, which is not read; convert it to EXR"},
    {"PF\n", 3, "a PFM picture, which is not read; convert it to EXR"},
    {"Pf\n", 3, "a PFM picture, which is not read; convert it to EXR"},
    {"PFS1\n", 5, "a PFS stream, which is not read; convert it to EXR"},
    {"II*\0", 4, "a TIFF, which is not read; convert it to EXR"},
    {"MM\0*", 4, "a TIFF, which is not read; convert it to EXR"},
    {"\x1f\x8b", 2, "gzip data; unpack it first"},
    {"hdrpipe ", 8, "the head of a pipe, where a picture should begin"},
};

static const unsigned char exr_magic[4] = {0x76, 0x2f, 0x31, 0x01};

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
    if (count < sizeof exr_magic && memcmp(bytes, exr_magic, count) == 0)
        return hdr_fail(err, HDR_BAD_DATA, "%s: the file ends within its header", name);
    for (size_t i = 0; i < sizeof strangers / sizeof strangers[0]; i++)
        if (count >= strangers[i].length && memcmp(bytes, strangers[i].magic, strangers[i].length) == 0)
            return hdr_fail(err, HDR_BAD_DATA, "%s: this is %s", name, strangers[i].what);
    char text[4 * SHOWN + 1];
    show_bytes(bytes, count, text);
    return hdr_fail(err, HDR_BAD_DATA, "%s: not a picture that hdrpipe reads (EXR); it begins with \"%s\"", name, text);
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

static bool is_exr(const unsigned char *start, int64_t count) {
    return (size_t)count >= sizeof exr_magic && memcmp(start, exr_magic, sizeof exr_magic) == 0;
}

static hdr_source *open_format(hdr_input *input, const hdr_reading *reading, hdr_error *err) {
    unsigned char start[LOOKED_AT];
    if (hdr_input_get_planes(input))
        return refuse_choice(input, reading, err) == HDR_OK ? hdr_planes_open(input, err) : NULL;
    int64_t count = hdr_input_read(input, start, sizeof start, 0, err);
    if (count < 0) return NULL;
    if (is_exr(start, count)) return hdr_exr_open(input, reading, err);
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
    if (is_exr(start, count)) return hdr_exr_contents(input, err);
    hdr_source *source = hdr_source_open(input, &(hdr_reading){.memory = reading->memory}, err);
    hdr_contents *contents = source ? hdr_contents_of_picture(&source->picture, err) : NULL;
    hdr_source_close(source);
    return contents;
}

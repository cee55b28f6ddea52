/* The headers of an EXR file.
 *
 * The attributes are walked here, and only those that say how pixels are stored and what they mean are handed on to
 * OpenEXRCore, as a little header of their own. So what the library allocates is bounded by bytes that were really
 * there, whatever sizes the file claims; thumbnails and manifests of megabytes are stepped over unread; it never waits
 * for a pipe's end; and parts that nobody asks for cannot do any harm. */
#include "io/exr_walk.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    START_BYTES = 8, /* magic number and version word */
    VERSION_BYTES = 4,
    FLAG_TILED = 0x200,
    FLAG_LONG_NAMES = 0x400,
    FLAG_DEEP = 0x800,
    FLAG_MULTI_PART = 0x1000,
    LONGEST_KEPT = 256 * 1024, /* of an attribute's value: thousands of channels */
    MOST_PARTS = 4096,
    CHANNEL_BYTES = 16 /* behind a channel's name: type, linearity, samplings */
};

/* Those that the library gets to see come first. */
static const char *const known_attributes[] = {
    "channels",
    "compression",
    "dataWindow",
    "displayWindow",
    "lineOrder",
    "pixelAspectRatio",
    "screenWindowCenter",
    "screenWindowWidth",
    "tiles",
    "chromaticities",
    "adoptedNeutral",
    "hdrpipeState",
    "name",
    "type",
    "view",
    "multiView",
    "chunkCount",
};
enum { KNOWN_ATTRIBUTES = sizeof known_attributes / sizeof known_attributes[0], KEPT_ATTRIBUTES = 12 };

/* One header's walk. */
struct walk {
    hdr_input *input;
    hdr_exr_part *part;
    bool seen[KNOWN_ATTRIBUTES];
    size_t channels_at, channels_size; /* in the part's text */
};

void hdr_exr_make_plain(char *text) {
    for (; *text; text++)
        if (*text < ' ' || *text > '~') *text = '?';
}

/* ---- Attributes ---- */

static hdr_status read_exactly(hdr_input *input, void *to, size_t size, uint64_t offset, hdr_error *err) {
    int64_t count = hdr_input_read(input, to, size, offset, err);
    if (count < 0) return HDR_IO;
    if ((uint64_t)count < size)
        return hdr_fail(err, HDR_BAD_DATA, "%s: the file ends within its header", hdr_input_name(input));
    return HDR_OK;
}

/* Takes a text that ends in a NUL from the front of bytes. Returns its length with the NUL; 0: there is no NUL. */
static size_t take_text(const unsigned char *bytes, size_t size, char text[HDR_EXR_LONGEST_NAME + 1]) {
    const unsigned char *end = memchr(bytes, 0, size < HDR_EXR_LONGEST_NAME + 1 ? size : HDR_EXR_LONGEST_NAME + 1);
    if (!end) return 0;
    memcpy(text, bytes, (size_t)(end - bytes) + 1);
    return (size_t)(end - bytes) + 1;
}

/* Reads what stands in front of a value. An empty name is the header's end. */
static hdr_status next_attribute(hdr_input *input, uint64_t offset, hdr_exr_attribute *attribute, hdr_error *err) {
    unsigned char bytes[2 * (HDR_EXR_LONGEST_NAME + 1) + 4];
    int64_t count = hdr_input_read(input, bytes, sizeof bytes, offset, err);
    if (count < 0) return HDR_IO;
    size_t size = (size_t)count;
    size_t name = take_text(bytes, size, attribute->name);
    if (name == 1) return HDR_OK;
    size_t type = name ? take_text(bytes + name, size - name, attribute->type) : 0;
    if (size < sizeof bytes && (name == 0 || type == 0 || size < name + type + 4))
        return hdr_fail(err, HDR_BAD_DATA, "%s: the file ends within its header", hdr_input_name(input));
    if (name == 0 || type <= 1)
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: no attribute at byte %llu",
                        hdr_input_name(input), (unsigned long long)offset);
    memcpy(attribute->shown, attribute->name, sizeof attribute->shown);
    hdr_exr_make_plain(attribute->shown);
    attribute->size = hdr_little_endian_32(bytes + name + type);
    attribute->value = offset + name + type + 4;
    int64_t file_size = hdr_input_size(input);
    if (attribute->size > INT32_MAX || (file_size >= 0 && attribute->value + attribute->size > (uint64_t)file_size))
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: attribute \"%s\" claims %u bytes",
                        hdr_input_name(input), attribute->shown, attribute->size);
    return HDR_OK;
}

/* Appends an attribute's value to bytes. */
static hdr_status add_value(hdr_input *input, const hdr_exr_attribute *attribute, uint32_t longest, hdr_bytes *to,
                            hdr_error *err) {
    uint32_t size = attribute->size;
    if (size > longest)
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: attribute \"%s\" claims %u bytes",
                        hdr_input_name(input), attribute->shown, size);
    hdr_status status = hdr_bytes_reserve(to, to->size + size, err);
    if (status == HDR_OK && size > 0) status = read_exactly(input, to->data + to->size, size, attribute->value, err);
    if (status == HDR_OK) to->size += size;
    return status;
}

hdr_status hdr_exr_label(hdr_bytes *to, const char *name, const char *type, uint32_t size, hdr_error *err) {
    const unsigned char bytes[4] = {(unsigned char)size, (unsigned char)(size >> 8), (unsigned char)(size >> 16),
                                    (unsigned char)(size >> 24)};
    hdr_status status = hdr_bytes_add(to, name, strlen(name) + 1, err);
    if (status == HDR_OK) status = hdr_bytes_add(to, type, strlen(type) + 1, err);
    return status == HDR_OK ? hdr_bytes_add(to, bytes, sizeof bytes, err) : status;
}

hdr_status hdr_exr_keep(hdr_input *input, const hdr_exr_attribute *attribute, uint32_t longest, hdr_bytes *to,
                        hdr_error *err) {
    hdr_status status = hdr_exr_label(to, attribute->name, attribute->type, attribute->size, err);
    return status == HDR_OK ? add_value(input, attribute, longest, to, err) : status;
}

/* ---- Values ---- */

/* A string's beginning, up to a NUL in it. */
static hdr_status read_name(hdr_input *input, const hdr_exr_attribute *attribute, char text[HDR_CHANNEL_NAME],
                            hdr_error *err) {
    uint32_t size = attribute->size < HDR_CHANNEL_NAME - 1 ? attribute->size : HDR_CHANNEL_NAME - 1;
    memset(text, 0, HDR_CHANNEL_NAME);
    return size ? read_exactly(input, text, size, attribute->value, err) : HDR_OK;
}

/* Names, each behind its length. */
static hdr_status read_views(struct walk *walk, const hdr_exr_attribute *attribute, hdr_error *err) {
    hdr_exr_part *part = walk->part;
    hdr_bytes raw = {0};
    hdr_status status = add_value(walk->input, attribute, LONGEST_KEPT, &raw, err);
    size_t at = 0;
    while (status == HDR_OK && raw.size - at >= 4) {
        uint32_t length = hdr_little_endian_32(raw.data + at);
        if (length > raw.size - at - 4) break;
        status = hdr_bytes_add(&part->views_text, raw.data + at + 4, length, err);
        if (status == HDR_OK) status = hdr_bytes_add(&part->views_text, "", 1, err);
        part->view_count++;
        at += 4 + length;
    }
    free(raw.data);
    if (status != HDR_OK || part->view_count == 0) return status;
    part->views = hdr_alloc((size_t)part->view_count, sizeof *part->views);
    if (!part->views) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    const char *name = (const char *)part->views_text.data, *end = name + part->views_text.size;
    for (int i = 0; i < part->view_count; i++) {
        part->views[i] = name < end ? name : "";
        name += name < end ? strlen(name) + 1 : 0;
    }
    return HDR_OK;
}

static hdr_window window_of(const unsigned char *bytes) {
    int32_t corner[4];
    for (int i = 0; i < 4; i++)
        corner[i] = (int32_t)hdr_little_endian_32(bytes + 4 * i);
    return (hdr_window){corner[0], corner[1], corner[2], corner[3]};
}

/* What choosing and listing want to know of an attribute that was kept; the library checks it anew. */
static void note_kept(struct walk *walk, const char *name, uint32_t size) {
    hdr_exr_part *part = walk->part;
    const unsigned char *value = part->text.data + part->text.size - size;
    if (!strcmp(name, "channels")) {
        walk->channels_at = part->text.size - size;
        walk->channels_size = size;
    }
    if (!strcmp(name, "dataWindow") && size == 16) part->data = window_of(value);
    if (!strcmp(name, "displayWindow") && size == 16) part->display = window_of(value);
    if (!strcmp(name, "compression") && size == 1) part->compression = value[0];
    if (!strcmp(name, "tiles") && size == 9) {
        part->tile_width = hdr_little_endian_32(value);
        part->tile_height = hdr_little_endian_32(value + 4);
        part->tile_mode = value[8];
    }
}

static hdr_status note_other(struct walk *walk, const hdr_exr_attribute *attribute, hdr_error *err) {
    hdr_exr_part *part = walk->part;
    const char *name = attribute->name;
    unsigned char number[4];
    if (!strcmp(name, "name")) return read_name(walk->input, attribute, part->name, err);
    if (!strcmp(name, "type")) return read_name(walk->input, attribute, part->type, err);
    if (!strcmp(name, "view")) return read_name(walk->input, attribute, part->view, err);
    if (!strcmp(name, "multiView")) return read_views(walk, attribute, err);
    if (attribute->size != sizeof number) return HDR_OK;
    hdr_status status = read_exactly(walk->input, number, sizeof number, attribute->value, err);
    if (status == HDR_OK) part->chunk_count = hdr_little_endian_32(number);
    part->counted = status == HDR_OK && part->chunk_count <= INT32_MAX;
    return status;
}

static hdr_status note(struct walk *walk, const hdr_exr_attribute *attribute, hdr_error *err) {
    for (int i = 0; i < KNOWN_ATTRIBUTES; i++) {
        if (strcmp(attribute->name, known_attributes[i]) != 0) continue;
        if (walk->seen[i])
            return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: attribute \"%s\" stands there twice",
                            hdr_input_name(walk->input), attribute->shown);
        walk->seen[i] = true;
        if (i >= KEPT_ATTRIBUTES) return note_other(walk, attribute, err);
        hdr_status status = hdr_exr_keep(walk->input, attribute, LONGEST_KEPT, &walk->part->text, err);
        if (status == HDR_OK) note_kept(walk, attribute->name, attribute->size);
        return status;
    }
    return HDR_OK;
}

/* The channels of the kept list, up to its end or to where it is damaged, which the library will tell. */
static hdr_status list_channels(struct walk *walk, hdr_error *err) {
    hdr_exr_part *part = walk->part;
    const unsigned char *at = part->text.data + walk->channels_at, *end = at + walk->channels_size;
    int room = 0;
    while (at < end && *at) {
        const unsigned char *name_end = memchr(at, 0, (size_t)(end - at));
        if (!name_end || name_end - at > HDR_EXR_LONGEST_NAME || end - name_end < 1 + CHANNEL_BYTES) break;
        if (part->channel_count == room) {
            room = room ? 2 * room : 16;
            hdr_exr_channel *grown = hdr_grow(part->channels, (size_t)room, sizeof *grown);
            if (!grown) return hdr_fail(err, HDR_INTERNAL, "out of memory");
            part->channels = grown;
        }
        part->channels[part->channel_count++] = (hdr_exr_channel){
            .name = (const char *)at,
            .type = (exr_pixel_type_t)hdr_little_endian_32(name_end + 1),
            .x_sampling = (int)hdr_little_endian_32(name_end + 9),
            .y_sampling = (int)hdr_little_endian_32(name_end + 13),
        };
        at = name_end + 1 + CHANNEL_BYTES;
    }
    return HDR_OK;
}

/* ---- Headers ---- */

hdr_status hdr_exr_begin(hdr_bytes *to, hdr_error *err) {
    static const unsigned char start[START_BYTES] = {0x76, 0x2f, 0x31, 0x01, 2, FLAG_LONG_NAMES >> 8};
    return hdr_bytes_add(to, start, sizeof start, err);
}

/* The library sees a part as a file of its own, whose version word says whether there are tiles. */
static hdr_status end_text(hdr_exr_part *part, hdr_error *err) {
    if (part->tiled) part->text.data[VERSION_BYTES + 1] |= FLAG_TILED >> 8;
    return hdr_bytes_add(&part->text, "", 1, err);
}

/* What kind of part it is, by its type, which a file of one part need not state. */
static hdr_status settle_kind(hdr_input *input, hdr_exr_file *file, uint32_t version, hdr_error *err) {
    hdr_exr_part *part = &file->parts[file->count - 1];
    part->deep = strncmp(part->type, "deep", 4) == 0 || (!file->multi_part && version & FLAG_DEEP);
    part->tiled = file->multi_part ? !strcmp(part->type, "tiledimage") || !strcmp(part->type, "deeptile")
                                   : (version & FLAG_TILED) != 0;
    if (!file->multi_part) return HDR_OK;
    if (!part->deep && !part->tiled && strcmp(part->type, "scanlineimage") != 0)
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: part %d has no type that is known",
                        hdr_input_name(input), file->count - 1);
    if (!part->counted)
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: part %d does not say how many chunks it has",
                        hdr_input_name(input), file->count - 1);
    return HDR_OK;
}

static hdr_status add_part(hdr_input *input, hdr_exr_file *file, hdr_error *err) {
    if (file->count == MOST_PARTS)
        return hdr_fail(err, HDR_BAD_DATA, "%s: it has more than %d parts", hdr_input_name(input), MOST_PARTS);
    if ((file->count & (file->count - 1)) == 0) { /* room is a power of two */
        size_t room = file->count ? 2 * (size_t)file->count : 1;
        hdr_exr_part *grown = hdr_grow(file->parts, room, sizeof *grown);
        if (!grown) return hdr_fail(err, HDR_INTERNAL, "out of memory");
        file->parts = grown;
    }
    file->parts[file->count] = (hdr_exr_part){.compression = -1, .data = {0, 0, -1, -1}, .display = {0, 0, -1, -1}};
    return hdr_exr_begin(&file->parts[file->count++].text, err);
}

/* Walks one header, from its first attribute, which has been read, to the byte behind its end. */
static hdr_status walk_part(hdr_input *input, hdr_exr_file *file, uint32_t version, hdr_exr_attribute *attribute,
                            uint64_t *offset, const hdr_exr_visitor *visitor, hdr_error *err) {
    hdr_status status = add_part(input, file, err);
    if (status != HDR_OK) return status;
    struct walk walk = {.input = input, .part = &file->parts[file->count - 1]};
    while (attribute->name[0] != '\0') {
        status = note(&walk, attribute, err);
        if (status == HDR_OK && visitor) status = visitor->attribute(visitor->context, file->count - 1, attribute, err);
        *offset = attribute->value + attribute->size;
        if (status == HDR_OK) status = next_attribute(input, *offset, attribute, err);
        if (status != HDR_OK) return status;
    }
    ++*offset; /* behind the empty name */
    status = settle_kind(input, file, version, err);
    if (status == HDR_OK) status = end_text(walk.part, err);
    /* their names stay in the text, which does not move any more */
    return status == HDR_OK ? list_channels(&walk, err) : status;
}

/* Reads the magic number and the version word. */
static hdr_status read_start(hdr_input *input, uint32_t *version, hdr_error *err) {
    const char *name = hdr_input_name(input);
    unsigned char start[START_BYTES];
    hdr_status status = read_exactly(input, start, sizeof start, 0, err);
    if (status != HDR_OK) return status;
    *version = hdr_little_endian_32(start + VERSION_BYTES);
    if ((*version & 0xff) != 2)
        return hdr_fail(err, HDR_BAD_DATA, "%s: EXR version %u is not known; version 2 is", name, *version & 0xff);
    if (*version & ~(uint32_t)(0xff | FLAG_TILED | FLAG_LONG_NAMES | FLAG_DEEP | FLAG_MULTI_PART))
        return hdr_fail(err, HDR_BAD_DATA, "%s: the version word %#x asks for what is not known", name, *version);
    return HDR_OK;
}

hdr_status hdr_exr_walk(hdr_input *input, hdr_exr_file *file, const hdr_exr_visitor *visitor, hdr_error *err) {
    uint32_t version = 0;
    uint64_t offset = START_BYTES;
    *file = (hdr_exr_file){.count = 0};
    hdr_status status = read_start(input, &version, err);
    file->multi_part = (version & FLAG_MULTI_PART) != 0;
    while (status == HDR_OK) {
        hdr_exr_attribute attribute = {.name = ""};
        status = next_attribute(input, offset, &attribute, err);
        if (status == HDR_OK && attribute.name[0] == '\0') {
            offset++; /* an empty header ends the list of several */
            break;
        }
        if (status == HDR_OK) status = walk_part(input, file, version, &attribute, &offset, visitor, err);
        if (!file->multi_part) break;
    }
    file->tables = offset;
    if (status == HDR_OK && file->count == 0)
        status = hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: it is empty", hdr_input_name(input));
    return status;
}

void hdr_exr_file_free(hdr_exr_file *file) {
    for (int i = 0; i < file->count; i++) {
        hdr_exr_part *part = &file->parts[i];
        free(part->text.data);
        free(part->channels);
        free(part->views);
        free(part->views_text.data);
    }
    free(file->parts);
    *file = (hdr_exr_file){.count = 0};
}

/* What an EXR file holds, from its headers alone: for people to look at, and to choose from. */
#include "io/contents.h"
#include "io/exr_choose.h"
#include "io/exr_compression.h"
#include "io/exr_levels.h"
#include "io/exr_walk.h"
#include "io/source.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    MOST_ATTRIBUTES = 65536, /* of a file; each is some memory */
    SHOWN_BYTES = 1024       /* of an attribute's value: a longer one is not for looking at */
};

/* While the headers are walked the number of parts is not known: the attributes wait in a list. */
struct listed {
    int part;
    hdr_attribute attribute;
};

struct listing_walk {
    hdr_input *input;
    hdr_listing *listing; /* of no parts yet: it holds the texts */
    struct listed *listed;
    int count, room;
};

/* ---- Values as text ---- */

static float float_at(const unsigned char *bytes) {
    uint32_t bits = hdr_little_endian_32(bytes);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static double double_at(const unsigned char *bytes) {
    uint64_t bits = hdr_little_endian_64(bytes);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* The shortest decimal that reads back as the same value. */
static void print_number(const unsigned char *at, char kind, char *text, size_t size) {
    if (kind == 'i') {
        snprintf(text, size, "%d", (int)(int32_t)hdr_little_endian_32(at));
        return;
    }
    int most = kind == 'd' ? 17 : 9;
    double value = kind == 'd' ? double_at(at) : (double)float_at(at);
    for (int digits = 6; digits <= most; digits++) {
        snprintf(text, size, "%.*g", digits, value);
        double back = strtod(text, NULL);
        if (kind == 'd' ? back == value : (float)back == (float)value) break;
    }
    char *comma = strchr(text, ','); /* of the host program's locale */
    if (comma) *comma = '.';
}

/* Values of one kind, with a space between them. */
static void print_numbers(const unsigned char *bytes, int count, char kind, char *text, size_t size) {
    size_t length = 0;
    text[0] = '\0';
    for (int i = 0; i < count; i++) {
        const unsigned char *at = bytes + (size_t)i * (kind == 'd' ? 8 : 4);
        char number[40];
        print_number(at, kind, number, sizeof number);
        length += (size_t)snprintf(text + length, size - length, "%s%s", i ? " " : "", number);
        if (length >= size) return;
    }
}

static const struct {
    const char *type;
    char kind; /* i: int, f: float, d: double */
    int count;
} number_types[] = {
    {"int", 'i', 1},      {"float", 'f', 1},   {"double", 'd', 1},
    {"v2i", 'i', 2},      {"v2f", 'f', 2},     {"v2d", 'd', 2},
    {"v3i", 'i', 3},      {"v3f", 'f', 3},     {"v3d", 'd', 3},
    {"box2i", 'i', 4},    {"box2f", 'f', 4},   {"m33f", 'f', 9},
    {"m33d", 'd', 9},     {"m44f", 'f', 16},   {"m44d", 'd', 16},
    {"rational", 'i', 2}, {"keycode", 'i', 7}, {"chromaticities", 'f', 8},
};

/* One of several words, by its number in a byte. */
static const char *word_of(const char *type, unsigned char number) {
    static const char *const orders[] = {"increasingY", "decreasingY", "randomY"}, *const maps[] = {"latlong", "cube"};
    if (!strcmp(type, "compression")) return hdr_exr_compression_name(number);
    if (!strcmp(type, "lineOrder") && number < 3) return orders[number];
    if (!strcmp(type, "envmap") && number < 2) return maps[number];
    return NULL;
}

/* Several strings, each behind its length, as one text. */
static void print_strings(const unsigned char *bytes, size_t size, char *text) {
    size_t length = 0;
    while (size >= 4) {
        size_t one = hdr_little_endian_32(bytes);
        if (one > size - 4) break;
        if (length) text[length++] = ' ';
        memcpy(text + length, bytes + 4, one);
        length += one;
        bytes += 4 + one;
        size -= 4 + one;
    }
    text[length] = '\0';
}

/* The value as text; false: its type is not shown, or it is not of its type's size. text has room for 16 numbers, and
 * for the bytes themselves. */
static bool print_value(const char *type, const unsigned char *bytes, size_t size, char *text, size_t room) {
    const char *word = size == 1 ? word_of(type, bytes[0]) : NULL;
    text[0] = '\0';
    if (word) {
        snprintf(text, room, "%s", word);
        return true;
    }
    if (!strcmp(type, "string")) {
        memcpy(text, bytes, size);
        text[size] = '\0';
        return true;
    }
    if (!strcmp(type, "stringvector")) {
        print_strings(bytes, size, text);
        return true;
    }
    for (size_t i = 0; i < sizeof number_types / sizeof number_types[0]; i++)
        if (!strcmp(type, number_types[i].type)) {
            size_t one = number_types[i].kind == 'd' ? 8 : 4;
            if (size != one * (size_t)number_types[i].count) return false;
            print_numbers(bytes, number_types[i].count, number_types[i].kind, text, room);
            return true;
        }
    return false;
}

/* ---- Attributes ---- */

static hdr_status list_attribute(void *context, int part, const hdr_exr_attribute *attribute, hdr_error *err) {
    struct listing_walk *walk = context;
    unsigned char bytes[SHOWN_BYTES];
    char text[SHOWN_BYTES + 1];
    if (walk->count == MOST_ATTRIBUTES)
        return hdr_fail(err, HDR_BAD_DATA, "%s: it has more than %d attributes", hdr_input_name(walk->input),
                        MOST_ATTRIBUTES);
    if (walk->count == walk->room) {
        walk->room = walk->room ? 2 * walk->room : 64;
        struct listed *grown = hdr_grow(walk->listed, (size_t)walk->room, sizeof *grown);
        if (!grown) return hdr_fail(err, HDR_INTERNAL, "out of memory");
        walk->listed = grown;
    }
    hdr_attribute *to = &walk->listed[walk->count].attribute;
    *to = (hdr_attribute){.value = NULL};
    to->name = hdr_listing_text(walk->listing, attribute->name, err);
    to->type = hdr_listing_text(walk->listing, attribute->type, err);
    if (!to->name || !to->type) return HDR_INTERNAL;
    walk->listed[walk->count++].part = part;
    if (attribute->size > sizeof bytes) return HDR_OK;
    int64_t count = hdr_input_read(walk->input, bytes, attribute->size, attribute->value, err);
    if (count < 0) return HDR_IO;
    if ((uint32_t)count < attribute->size || !print_value(attribute->type, bytes, (size_t)count, text, sizeof text))
        return HDR_OK;
    to->value = hdr_listing_text(walk->listing, text, err);
    return to->value ? HDR_OK : HDR_INTERNAL;
}

/* Hands each part its own. They stand in the list in the parts' order. */
static hdr_status spread_attributes(struct listing_walk *walk, hdr_part *parts, int part_count, hdr_error *err) {
    int at = 0;
    for (int i = 0; i < part_count; i++) {
        int first = at;
        while (at < walk->count && walk->listed[at].part == i)
            at++;
        hdr_attribute *attributes = hdr_listing_alloc(walk->listing, (size_t)(at - first), sizeof *attributes, err);
        if (!attributes) return HDR_INTERNAL;
        for (int a = first; a < at; a++)
            attributes[a - first] = walk->listed[a].attribute;
        parts[i].attributes = attributes;
        parts[i].attribute_count = at - first;
    }
    return HDR_OK;
}

/* ---- Parts ---- */

static hdr_status describe_channels(hdr_listing *listing, const hdr_exr_part *from, hdr_part *part, hdr_error *err) {
    hdr_listed_channel *channels = hdr_listing_alloc(listing, (size_t)from->channel_count, sizeof *channels, err);
    const char **views = hdr_listing_alloc(listing, (size_t)from->view_count, sizeof *views, err);
    if (!channels || !views) return HDR_INTERNAL;
    for (int i = 0; i < from->channel_count; i++) {
        const hdr_exr_channel *channel = &from->channels[i];
        char layer[HDR_EXR_LONGEST_NAME + 1];
        snprintf(layer, sizeof layer, "%.*s", (int)hdr_exr_layer_length(channel->name), channel->name);
        channels[i] = (hdr_listed_channel){.name = hdr_listing_text(listing, channel->name, err),
                                           .layer = hdr_listing_text(listing, layer, err),
                                           .type = channel->type == EXR_PIXEL_HALF    ? HDR_HALF
                                                   : channel->type == EXR_PIXEL_FLOAT ? HDR_FLOAT
                                                                                      : HDR_UINT,
                                           .x_sampling = channel->x_sampling,
                                           .y_sampling = channel->y_sampling};
        if (!channels[i].name || !channels[i].layer) return HDR_INTERNAL;
    }
    for (int i = 0; i < from->view_count; i++)
        if (!(views[i] = hdr_listing_text(listing, from->views[i], err))) return HDR_INTERNAL;
    part->channels = channels;
    part->channel_count = from->channel_count;
    part->views = views;
    part->view_count = from->view_count;
    return HDR_OK;
}

static void describe_tiles(const hdr_exr_part *from, hdr_part *part) {
    static const char *const modes[] = {"one", "mipmap", "ripmap"};
    unsigned mode = from->tile_mode & 15;
    const hdr_exr_levels levels = {.width = hdr_window_width(&from->data),
                                   .height = hdr_window_height(&from->data),
                                   .mode = (exr_tile_level_mode_t)mode,
                                   .up = from->tile_mode >> 4 == EXR_TILE_ROUND_UP};
    if (!from->tiled || from->tile_width < 1 || from->tile_width > INT32_MAX || from->tile_height < 1 ||
        from->tile_height > INT32_MAX || mode > 2)
        return;
    part->tile_width = (int)from->tile_width;
    part->tile_height = (int)from->tile_height;
    part->levels = modes[mode];
    part->level_count = hdr_exr_level_count(&levels);
}

static hdr_status describe_part(hdr_listing *listing, const hdr_exr_part *from, hdr_part *part, hdr_error *err) {
    const char *compression = hdr_exr_compression_name(from->compression);
    part->name = hdr_listing_text(listing, from->name, err);
    part->view = hdr_listing_text(listing, from->view, err);
    if (!part->name || !part->view) return HDR_INTERNAL;
    part->storage = from->deep ? (from->tiled ? "deep tiled" : "deep scan-line") : from->tiled ? "tiled" : "scan-line";
    part->compression = compression ? compression : "unknown";
    part->data = from->data;
    part->display = from->display;
    describe_tiles(from, part);
    return describe_channels(listing, from, part, err);
}

hdr_contents *hdr_exr_contents(hdr_input *input, hdr_error *err) {
    hdr_exr_file file = {.count = 0};
    struct listing_walk walk = {.input = input, .listing = hdr_listing_new(0, err)};
    hdr_status status = walk.listing ? HDR_OK : HDR_INTERNAL;
    if (status == HDR_OK) {
        const hdr_exr_visitor visitor = {list_attribute, &walk};
        status = hdr_exr_walk(input, &file, &visitor, err);
    }
    hdr_part *parts = status == HDR_OK ? hdr_listing_alloc(walk.listing, (size_t)file.count, sizeof *parts, err) : NULL;
    if (!parts) status = HDR_INTERNAL;
    for (int i = 0; status == HDR_OK && i < file.count; i++) {
        parts[i] = (hdr_part){.number = i, .levels = "one", .level_count = 1};
        status = describe_part(walk.listing, &file.parts[i], &parts[i], err);
    }
    if (status == HDR_OK) status = spread_attributes(&walk, parts, file.count, err);
    if (status == HDR_OK) walk.listing->contents = (hdr_contents){.part_count = file.count, .parts = parts};
    hdr_exr_file_free(&file);
    free(walk.listed);
    if (status == HDR_OK) return &walk.listing->contents;
    if (walk.listing) hdr_contents_free(&walk.listing->contents);
    return NULL;
}

/* The header of an EXR file.
 *
 * The attributes are walked here, and only those that say how pixels are stored and what they mean are handed on to
 * OpenEXRCore, as a little header of their own. So what the library allocates is bounded by bytes that were really
 * there, whatever sizes the file claims; thumbnails and manifests of megabytes are stepped over unread; and it never
 * waits for a pipe's end. */
#include "io/exr_header.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    START_BYTES = 8, /* magic number and version word */
    FLAG_TILED = 0x200,
    FLAG_LONG_NAMES = 0x400,
    FLAG_DEEP = 0x800,
    FLAG_MULTI_PART = 0x1000,
    LONGEST_NAME = 255,
    LONGEST_KEPT = 256 * 1024, /* of an attribute's value: thousands of channels */
    LISTED_BYTES = 400         /* of channel names in a message */
};

/* The header that the library gets to see, and what it has to say about it. */
struct hdr_exr_text {
    hdr_bytes bytes;
    char complaint[256];
    bool listening; /* while the header is parsed, by one thread; later complaints come from many and are not needed */
};

static const char *const kept_attributes[] = {
    "channels",           "compression",       "dataWindow", "displayWindow",  "lineOrder",      "pixelAspectRatio",
    "screenWindowCenter", "screenWindowWidth", "tiles",      "chromaticities", "adoptedNeutral", "hdrpipeState",
};
enum { KEPT_ATTRIBUTES = sizeof kept_attributes / sizeof kept_attributes[0] };

/* ---- Walking the attributes ---- */

static uint32_t little_endian_32(const unsigned char *bytes) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static hdr_status read_exactly(hdr_input *input, void *to, size_t size, uint64_t offset, hdr_error *err) {
    int64_t count = hdr_input_read(input, to, size, offset, err);
    if (count < 0) return HDR_IO;
    if ((uint64_t)count < size)
        return hdr_fail(err, HDR_BAD_DATA, "%s: the file ends within its header", hdr_input_name(input));
    return HDR_OK;
}

/* The name, type and size in front of an attribute's value. */
struct attribute {
    char name[LONGEST_NAME + 1], type[LONGEST_NAME + 1];
    char shown[LONGEST_NAME + 1]; /* the name, fit for a message */
    uint32_t size;
    uint64_t value; /* its offset */
};

/* Names in a damaged header may be anything; messages are to be text. */
static void make_plain(char *text) {
    for (; *text; text++)
        if (*text < ' ' || *text > '~') *text = '?';
}

/* Takes a text that ends in a NUL from the front of bytes. Returns its length with the NUL; 0: there is no NUL. */
static size_t take_text(const unsigned char *bytes, size_t size, char text[LONGEST_NAME + 1]) {
    const unsigned char *end = memchr(bytes, 0, size < LONGEST_NAME + 1 ? size : LONGEST_NAME + 1);
    if (!end) return 0;
    memcpy(text, bytes, (size_t)(end - bytes) + 1);
    return (size_t)(end - bytes) + 1;
}

/* Reads what stands in front of a value. An empty name is the header's end. */
static hdr_status next_attribute(hdr_input *input, uint64_t offset, struct attribute *attribute, hdr_error *err) {
    unsigned char bytes[2 * (LONGEST_NAME + 1) + 4];
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
    make_plain(attribute->shown);
    attribute->size = little_endian_32(bytes + name + type);
    attribute->value = offset + name + type + 4;
    int64_t file_size = hdr_input_size(input);
    if (attribute->size > INT32_MAX || (file_size >= 0 && attribute->value + attribute->size > (uint64_t)file_size))
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: attribute \"%s\" claims %u bytes",
                        hdr_input_name(input), attribute->shown, attribute->size);
    return HDR_OK;
}

/* Copies an attribute into the library's header. */
static hdr_status keep(hdr_input *input, const struct attribute *attribute, hdr_bytes *to, hdr_error *err) {
    if (attribute->size > LONGEST_KEPT)
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: attribute \"%s\" claims %u bytes",
                        hdr_input_name(input), attribute->shown, attribute->size);
    uint32_t size = attribute->size;
    const unsigned char size_bytes[4] = {(unsigned char)size, (unsigned char)(size >> 8), (unsigned char)(size >> 16),
                                         (unsigned char)(size >> 24)};
    hdr_status status = hdr_bytes_add(to, attribute->name, strlen(attribute->name) + 1, err);
    if (status == HDR_OK) status = hdr_bytes_add(to, attribute->type, strlen(attribute->type) + 1, err);
    if (status == HDR_OK) status = hdr_bytes_add(to, size_bytes, sizeof size_bytes, err);
    if (status == HDR_OK) status = hdr_bytes_reserve(to, to->size + size, err);
    if (status == HDR_OK && size > 0) status = read_exactly(input, to->data + to->size, size, attribute->value, err);
    if (status == HDR_OK) to->size += size;
    return status;
}

/* Deep files say so in the version word too, but not all of them. */
static hdr_status refuse_deep_type(hdr_input *input, const struct attribute *attribute, hdr_error *err) {
    char value[4] = "";
    if (attribute->size < sizeof value) return HDR_OK;
    hdr_status status = read_exactly(input, value, sizeof value, attribute->value, err);
    if (status == HDR_OK && memcmp(value, "deep", sizeof value) == 0)
        status =
            hdr_fail(err, HDR_BAD_DATA,
                     "%s: deep data (several samples at different depths in a pixel) is not read; flatten it first",
                     hdr_input_name(input));
    return status;
}

static hdr_status walk(hdr_input *input, hdr_exr_header *header, hdr_error *err) {
    bool seen[KEPT_ATTRIBUTES] = {false};
    uint64_t offset = START_BYTES;
    for (;;) {
        struct attribute attribute = {.name = ""};
        hdr_status status = next_attribute(input, offset, &attribute, err);
        if (status != HDR_OK) return status;
        if (attribute.name[0] == '\0') break;
        if (strcmp(attribute.name, "type") == 0) status = refuse_deep_type(input, &attribute, err);
        for (int i = 0; status == HDR_OK && i < KEPT_ATTRIBUTES; i++) {
            if (strcmp(attribute.name, kept_attributes[i]) != 0) continue;
            if (seen[i])
                return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: attribute \"%s\" stands there twice",
                                hdr_input_name(input), attribute.shown);
            seen[i] = true;
            status = keep(input, &attribute, &header->text->bytes, err);
        }
        if (status != HDR_OK) return status;
        offset = attribute.value + attribute.size;
    }
    header->table_offset = offset + 1;
    return hdr_bytes_add(&header->text->bytes, "", 1, err);
}

/* Reads the magic number and the version word, and refuses what the latter tells to be of another kind. */
static hdr_status read_start(hdr_input *input, hdr_exr_header *header, hdr_error *err) {
    const char *name = hdr_input_name(input);
    unsigned char start[START_BYTES];
    hdr_status status = read_exactly(input, start, sizeof start, 0, err);
    if (status != HDR_OK) return status;
    uint32_t version = little_endian_32(start + 4);
    if ((version & 0xff) != 2)
        return hdr_fail(err, HDR_BAD_DATA, "%s: EXR version %u is not known; version 2 is", name, version & 0xff);
    if (version & FLAG_DEEP)
        return hdr_fail(err, HDR_BAD_DATA,
                        "%s: deep data (several samples at different depths in a pixel) is not read; flatten it first",
                        name);
    if (version & FLAG_MULTI_PART)
        return hdr_fail(err, HDR_BAD_DATA,
                        "%s: a multi-part EXR is not read; write the wanted part to a file of its own", name);
    if (version & ~(uint32_t)(0xff | FLAG_TILED | FLAG_LONG_NAMES))
        return hdr_fail(err, HDR_BAD_DATA, "%s: the version word %#x asks for what is not known", name, version);
    header->tiled = (version & FLAG_TILED) != 0;
    return hdr_bytes_add(&header->text->bytes, start, sizeof start, err);
}

/* ---- The library's parser ---- */

static int64_t read_text(exr_const_context_t context, void *user_data, void *buffer, uint64_t size, uint64_t offset,
                         exr_stream_error_func_ptr_t complain) {
    (void)context;
    (void)complain;
    const hdr_bytes *bytes = &((struct hdr_exr_text *)user_data)->bytes;
    if (offset >= bytes->size) return 0;
    if (size > bytes->size - offset) size = bytes->size - offset;
    memcpy(buffer, bytes->data + offset, (size_t)size);
    return (int64_t)size;
}

static int64_t text_size(exr_const_context_t context, void *user_data) {
    (void)context;
    return (int64_t)((struct hdr_exr_text *)user_data)->bytes.size;
}

/* The library would print; the first complaint is the one that names the cause. */
static void hear(exr_const_context_t context, exr_result_t code, const char *message) {
    void *user_data = NULL;
    (void)code;
    if (!context || exr_get_user_data(context, &user_data) != EXR_ERR_SUCCESS || !user_data) return;
    struct hdr_exr_text *text = user_data;
    if (text->listening && text->complaint[0] == '\0') snprintf(text->complaint, sizeof text->complaint, "%s", message);
}

static hdr_status parse(hdr_input *input, hdr_exr_header *header, hdr_error *err) {
    exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
    initializer.user_data = header->text;
    initializer.read_fn = read_text;
    initializer.size_fn = text_size;
    initializer.error_handler_fn = hear;
    initializer.flags = EXR_CONTEXT_FLAG_STRICT_HEADER | EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    header->text->listening = true;
    exr_result_t result = exr_start_read(&header->context, "header", &initializer);
    header->text->listening = false;
    if (result == EXR_ERR_SUCCESS) return HDR_OK;
    header->context = NULL;
    if (result == EXR_ERR_OUT_OF_MEMORY) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    char *complaint = header->text->complaint;
    make_plain(complaint);
    return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: %s", hdr_input_name(input),
                    complaint[0] ? complaint : exr_get_error_code_as_string(result));
}

/* ---- What the header says ---- */

static hdr_status read_compression(const char *name, hdr_exr_header *header, hdr_error *err) {
    static const char *const names[] = {"none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "DWAA", "DWAB"};
    static const int rows[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
    exr_compression_t compression;
    if (exr_get_compression(header->context, 0, &compression) != EXR_ERR_SUCCESS ||
        (size_t)compression >= sizeof names / sizeof names[0])
        return hdr_fail(err, HDR_BAD_DATA, "%s: its compression is not known", name);
    if (compression >= EXR_COMPRESSION_DWAA)
        return hdr_fail(err, HDR_BAD_DATA, "%s: %s compression is not read; store it with another one, e.g. zip or piz",
                        name, names[compression]);
    header->compression = compression;
    header->chunk_rows = rows[compression];
    snprintf(header->picture.compression, sizeof header->picture.compression, "%s", names[compression]);
    return HDR_OK;
}

static hdr_status read_geometry(const char *name, hdr_exr_header *header, hdr_error *err) {
    hdr_picture *picture = &header->picture;
    exr_attr_box2i_t data, display;
    exr_storage_t storage;
    if (exr_get_data_window(header->context, 0, &data) != EXR_ERR_SUCCESS ||
        exr_get_display_window(header->context, 0, &display) != EXR_ERR_SUCCESS ||
        exr_get_pixel_aspect_ratio(header->context, 0, &picture->pixel_aspect) != EXR_ERR_SUCCESS ||
        exr_get_storage(header->context, 0, &storage) != EXR_ERR_SUCCESS ||
        storage != (header->tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE))
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: no windows or storage", name);
    picture->data = (hdr_window){data.min.x, data.min.y, data.max.x, data.max.y};
    picture->display = (hdr_window){display.min.x, display.min.y, display.max.x, display.max.y};
    header->width = hdr_window_width(&picture->data);
    header->height = hdr_window_height(&picture->data);
    if (header->width < 1 || header->width > INT32_MAX || header->height < 1 || header->height > INT32_MAX)
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: no pixels in its data window", name);
    snprintf(picture->format, sizeof picture->format, "exr");
    snprintf(picture->storage, sizeof picture->storage, "%s", header->tiled ? "tiled" : "scan-line");
    if (!header->tiled) return HDR_OK;
    uint32_t tile_width, tile_height;
    exr_tile_level_mode_t levels;
    exr_tile_round_mode_t rounding;
    if (exr_get_tile_descriptor(header->context, 0, &tile_width, &tile_height, &levels, &rounding) != EXR_ERR_SUCCESS ||
        tile_width < 1 || tile_height < 1)
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: no size of tiles", name);
    header->tile_width = (int)(tile_width < (uint64_t)header->width ? tile_width : (uint64_t)header->width);
    header->chunk_rows = (int)(tile_height < (uint64_t)header->height ? tile_height : (uint64_t)header->height);
    return HDR_OK;
}

/* What colours the numbers mean. */
static hdr_status read_colour(const char *name, hdr_exr_header *header, hdr_error *err) {
    hdr_picture *picture = &header->picture;
    exr_attr_chromaticities_t c;
    exr_attr_v2f_t neutral;
    picture->chromaticities = (hdr_chromaticities){{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}};
    if (exr_attr_get_chromaticities(header->context, 0, "chromaticities", &c) == EXR_ERR_SUCCESS) {
        picture->has_chromaticities = true;
        picture->chromaticities = (hdr_chromaticities){{(double)c.red_x, (double)c.red_y},
                                                       {(double)c.green_x, (double)c.green_y},
                                                       {(double)c.blue_x, (double)c.blue_y},
                                                       {(double)c.white_x, (double)c.white_y}};
        const float all[] = {c.red_x, c.red_y, c.green_x, c.green_y, c.blue_x, c.blue_y, c.white_x, c.white_y};
        for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
            if (!isfinite(all[i])) return hdr_fail(err, HDR_BAD_DATA, "%s: its chromaticities are not numbers", name);
    }
    if (exr_attr_get_v2f(header->context, 0, "adoptedNeutral", &neutral) == EXR_ERR_SUCCESS) {
        picture->has_neutral = true;
        picture->neutral[0] = (double)neutral.x;
        picture->neutral[1] = (double)neutral.y;
        if (!isfinite(neutral.x) || !isfinite(neutral.y))
            return hdr_fail(err, HDR_BAD_DATA, "%s: its adoptedNeutral is not a pair of numbers", name);
    }
    return HDR_OK;
}

/* What was done to the numbers, where hdrpipe wrote them. */
static hdr_status read_state(const char *name, hdr_exr_header *header, hdr_error *err) {
    hdr_picture *picture = &header->picture;
    int32_t length = 0;
    const char *state = NULL;
    if (exr_attr_get_string(header->context, 0, "hdrpipeState", &length, &state) != EXR_ERR_SUCCESS || !state) {
        snprintf(picture->state, sizeof picture->state, "linear");
        return HDR_OK;
    }
    bool sound = length > 0 && (size_t)length < sizeof picture->state;
    for (int32_t i = 0; sound && i < length; i++)
        sound = state[i] >= ' ' && state[i] <= '~';
    if (!sound) return hdr_fail(err, HDR_BAD_DATA, "%s: its attribute hdrpipeState is damaged", name);
    memcpy(picture->state, state, (size_t)length);
    return HDR_OK;
}

/* ---- Channels ---- */

static int find_channel(const exr_attr_chlist_t *list, const char *name) {
    for (int i = 0; i < list->num_channels; i++)
        if (strcmp(list->entries[i].name.str, name) == 0) return i;
    return -1;
}

static hdr_status refuse_channels(const char *name, const exr_attr_chlist_t *list, hdr_error *err) {
    char names[LISTED_BYTES] = "";
    size_t length = 0;
    for (int i = 0; i < list->num_channels; i++) {
        const char *channel = list->entries[i].name.str;
        if (length + strlen(channel) + 8 > sizeof names) {
            snprintf(names + length, sizeof names - length, ", ...");
            break;
        }
        length += (size_t)snprintf(names + length, sizeof names - length, "%s%s", i ? ", " : "", channel);
    }
    make_plain(names);
    return hdr_fail(err, HDR_BAD_DATA, "%s: it has none of the channels R, G, B and Y; it has: %s", name, names);
}

static hdr_status refuse_subsampled(const char *name, const exr_attr_chlist_entry_t *entry, hdr_error *err) {
    char channel[LONGEST_NAME + 1];
    snprintf(channel, sizeof channel, "%s", entry->name.str);
    make_plain(channel);
    return hdr_fail(err, HDR_BAD_DATA,
                    "%s: channel %s is subsampled (%d x %d); only the chroma channels RY and BY may be, by 2 x 2", name,
                    channel, entry->x_sampling, entry->y_sampling);
}

/* Reads place 0 ... 3 of the picture from a channel of the list, which has a sample in each sampling-th column of each
 * sampling-th row. */
static hdr_status use_channel(const char *name, hdr_exr_header *header, int place, int sampling, hdr_error *err) {
    const exr_attr_chlist_entry_t *entry = &header->list->entries[header->index[place]];
    hdr_channel *channel = &header->picture.channels[place];
    if (entry->pixel_type != EXR_PIXEL_HALF && entry->pixel_type != EXR_PIXEL_FLOAT)
        return hdr_fail(err, HDR_BAD_DATA,
                        "%s: channel %s holds whole numbers (uint), not light; half and float are read", name,
                        entry->name.str);
    if (entry->x_sampling != sampling || entry->y_sampling != sampling) return refuse_subsampled(name, entry, err);
    channel->type = entry->pixel_type == EXR_PIXEL_HALF ? HDR_HALF : HDR_FLOAT;
    header->picture.present[place] = true;
    for (int i = 0; i < header->index[place]; i++)
        header->before[place] += header->list->entries[i].pixel_type == EXR_PIXEL_HALF ? 2 : 4;
    return HDR_OK;
}

/* How RY and BY are sampled; the reconstruction counts on whole pairs of columns and rows, as all writers make them. */
static hdr_status read_chroma(const char *name, hdr_exr_header *header, hdr_error *err) {
    const exr_attr_chlist_entry_t *entry = &header->list->entries[header->index[header->index[1] >= 0 ? 1 : 2]];
    const hdr_window *data = &header->picture.data;
    if (entry->x_sampling != entry->y_sampling || entry->x_sampling < 1 || entry->x_sampling > 2)
        return refuse_subsampled(name, entry, err);
    header->chroma = entry->x_sampling;
    if (header->chroma == 2 &&
        (header->tiled || data->min_x % 2 || data->min_y % 2 || header->width % 2 || header->height % 2))
        return hdr_fail(err, HDR_BAD_DATA,
                        "%s: the header is damaged: its data window does not fit subsampled channels", name);
    return HDR_OK;
}

static hdr_status choose_channels(const char *name, hdr_exr_header *header, hdr_error *err) {
    static const char *const names[3][3] = {{"Y", "", ""}, {"R", "G", "B"}, {"Y", "RY", "BY"}};
    enum { GREY, COLOURED, CHROMA } kind = COLOURED;
    hdr_picture *picture = &header->picture;
    const exr_attr_chlist_t *list;
    if (exr_get_channels(header->context, 0, &list) != EXR_ERR_SUCCESS || list->num_channels < 1)
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: no channels", name);
    header->list = list;
    if (find_channel(list, "R") < 0 && find_channel(list, "G") < 0 && find_channel(list, "B") < 0) {
        if (find_channel(list, "Y") < 0) return refuse_channels(name, list, err);
        kind = find_channel(list, "RY") >= 0 || find_channel(list, "BY") >= 0 ? CHROMA : GREY;
    }
    hdr_status status = HDR_OK;
    for (int i = 0; i < 4; i++) {
        snprintf(picture->channels[i].name, HDR_CHANNEL_NAME, "%s", i == 3 ? "A" : names[kind][i]);
        header->index[i] = picture->channels[i].name[0] ? find_channel(list, picture->channels[i].name) : -1;
    }
    picture->planes = kind == GREY ? 1 : 3;
    picture->has_alpha = header->index[3] >= 0;
    if (kind == CHROMA) status = read_chroma(name, header, err);
    for (int i = 0; i < 4 && status == HDR_OK; i++)
        if (header->index[i] >= 0)
            status = use_channel(name, header, i, header->chroma && (i == 1 || i == 2) ? header->chroma : 1, err);
    for (int i = 0; i < list->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &list->entries[i];
        header->pixel_bytes += entry->pixel_type == EXR_PIXEL_HALF ? 2 : 4;
        header->sampled |= entry->x_sampling != 1 || entry->y_sampling != 1;
    }
    if (status == HDR_OK && header->sampled && header->tiled)
        status = hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: subsampled channels in tiles", name);
    return status;
}

/* ---- In all ---- */

hdr_status hdr_exr_header_read(hdr_input *input, hdr_exr_header *header, hdr_error *err) {
    const char *name = hdr_input_name(input);
    *header = (hdr_exr_header){.tiled = false};
    header->text = hdr_alloc(1, sizeof *header->text);
    if (!header->text) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    hdr_status status = read_start(input, header, err);
    if (status == HDR_OK) status = walk(input, header, err);
    if (status == HDR_OK) status = parse(input, header, err);
    if (status == HDR_OK) status = read_compression(name, header, err);
    if (status == HDR_OK) status = read_geometry(name, header, err);
    if (status == HDR_OK) status = choose_channels(name, header, err);
    if (status == HDR_OK) status = read_colour(name, header, err);
    if (status == HDR_OK) status = read_state(name, header, err);
    if (status != HDR_OK) hdr_exr_header_free(header);
    return status;
}

void hdr_exr_header_free(hdr_exr_header *header) {
    if (header->context) exr_finish(&header->context);
    if (header->text) free(header->text->bytes.data);
    free(header->text);
    header->context = NULL;
    header->text = NULL;
}

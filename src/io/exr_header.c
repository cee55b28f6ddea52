/* The header of the part of an EXR file that is read: what OpenEXRCore makes of it, checked. It sees the attributes
 * that exr_walk.c has kept, as the header of a file of that part alone. */
#include "io/exr_header.h"

#include "io/exr_choose.h"
#include "io/exr_compression.h"
#include "io/exr_levels.h"
#include "io/exr_text.h"
#include "picture/colour.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The header that the library gets to see, and what it was made of. */
struct hdr_exr_headers {
    hdr_exr_file file; /* all headers */
    hdr_exr_text text; /* the part's; its bytes belong to the file */
};

/* ---- The library's parser ---- */

static hdr_status parse(hdr_input *input, hdr_exr_header *header, hdr_error *err) {
    hdr_exr_text *text = &header->headers->text;
    exr_result_t result = hdr_exr_text_open(text, &header->context);
    if (result == EXR_ERR_SUCCESS) return HDR_OK;
    if (result == EXR_ERR_OUT_OF_MEMORY) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    hdr_exr_make_plain(text->complaint);
    return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: %s", hdr_input_name(input),
                    text->complaint[0] ? text->complaint : exr_get_error_code_as_string(result));
}

/* ---- What the header says ---- */

static hdr_status read_compression(const char *name, hdr_exr_header *header, hdr_error *err) {
    exr_compression_t compression;
    if (exr_get_compression(header->context, 0, &compression) != EXR_ERR_SUCCESS ||
        !hdr_exr_compression_name((int)compression))
        return hdr_fail(err, HDR_BAD_DATA, "%s: its compression is not known", name);
    header->compression = compression;
    header->chunk_rows = hdr_exr_chunk_lines((int)compression);
    snprintf(header->picture.compression, sizeof header->picture.compression, "%s",
             hdr_exr_compression_name((int)compression));
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
    return HDR_OK;
}

/* Tiles, and the level that is read; the windows become the level's. */
static hdr_status read_tiles(const char *name, hdr_exr_header *header, const hdr_reading *reading, hdr_error *err) {
    hdr_picture *picture = &header->picture;
    uint32_t tile_width = 1, tile_height = 1;
    exr_tile_level_mode_t mode = EXR_TILE_ONE_LEVEL;
    exr_tile_round_mode_t rounding = EXR_TILE_ROUND_DOWN;
    if (header->tiled &&
        (exr_get_tile_descriptor(header->context, 0, &tile_width, &tile_height, &mode, &rounding) != EXR_ERR_SUCCESS ||
         tile_width < 1 || tile_height < 1))
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: no size of tiles", name);
    const hdr_exr_levels levels = {.width = header->width,
                                   .height = header->height,
                                   .tile_width = header->tiled ? (int64_t)tile_width : header->width,
                                   .tile_height = header->tiled ? (int64_t)tile_height : header->chunk_rows,
                                   .mode = mode,
                                   .up = rounding == EXR_TILE_ROUND_UP};
    uint64_t across = (uint64_t)((levels.width + levels.tile_width - 1) / levels.tile_width);
    uint64_t down = (uint64_t)((levels.height + levels.tile_height - 1) / levels.tile_height);
    if (across * down > INT32_MAX)
        return hdr_fail(err, HDR_BAD_DATA,
                        "%s: the header asks for %lld x %lld pixels in more tiles than a file can have", name,
                        (long long)header->width, (long long)header->height);
    int count = hdr_exr_level_count(&levels);
    if (!reading->proxy && reading->level >= count)
        return hdr_fail(err, HDR_BAD_DATA, "%s: it has no level %lld: %s%d", name, (long long)reading->level,
                        count > 1 ? "its levels are 0 to " : "its only level is ", count - 1);
    int level = reading->proxy ? hdr_exr_level_for(&levels, reading->level) : (int)reading->level;
    header->first_chunk = hdr_exr_level_chunks(&levels, level);
    header->all_chunks = hdr_exr_level_chunks(&levels, count);
    picture->level = level;
    picture->display = hdr_exr_level_window(&levels, &picture->display, &picture->data, level);
    header->width = hdr_exr_level_size(&levels, levels.width, level);
    header->height = hdr_exr_level_size(&levels, levels.height, level);
    picture->data.max_x = (int32_t)(picture->data.min_x + header->width - 1);
    picture->data.max_y = (int32_t)(picture->data.min_y + header->height - 1);
    if (!header->tiled) return HDR_OK;
    header->tile_width = (int)(tile_width < (uint64_t)header->width ? tile_width : (uint64_t)header->width);
    header->chunk_rows = (int)(tile_height < (uint64_t)header->height ? tile_height : (uint64_t)header->height);
    return HDR_OK;
}

/* What colours the numbers mean. */
static hdr_status read_colour(const char *name, hdr_exr_header *header, hdr_error *err) {
    hdr_picture *picture = &header->picture;
    exr_attr_chromaticities_t c;
    exr_attr_v2f_t neutral;
    picture->chromaticities = hdr_rec709;
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

static hdr_status refuse_subsampled(const char *name, const exr_attr_chlist_entry_t *entry, bool single,
                                    hdr_error *err) {
    char channel[HDR_EXR_LONGEST_NAME + 1];
    snprintf(channel, sizeof channel, "%s", entry->name.str);
    hdr_exr_make_plain(channel);
    return hdr_fail(err, HDR_BAD_DATA, "%s: channel %s is subsampled (%d x %d); %s", name, channel, entry->x_sampling,
                    entry->y_sampling,
                    single ? "a subsampled channel cannot be read by itself"
                           : "only the chroma channels RY and BY may be, by 2 x 2");
}

static hdr_status refuse_uint(const char *name, const exr_attr_chlist_entry_t *entry, bool alpha, hdr_error *err) {
    char channel[HDR_EXR_LONGEST_NAME + 1];
    snprintf(channel, sizeof channel, "%s", entry->name.str);
    hdr_exr_make_plain(channel);
    if (alpha)
        return hdr_fail(
            err, HDR_BAD_DATA,
            "%s: channel %s holds whole numbers (uint), no cover; --alpha drop reads the colours without it", name,
            channel);
    return hdr_fail(err, HDR_BAD_DATA,
                    "%s: channel %s holds whole numbers (uint), not light; --channel %s reads it by itself", name,
                    channel, channel);
}

static bool is_uint(const exr_attr_chlist_entry_t *entry) {
    return entry->pixel_type != EXR_PIXEL_HALF && entry->pixel_type != EXR_PIXEL_FLOAT;
}

/* Reads place 0 ... 3 of the picture from a channel of the list, which has a sample in each sampling-th column of each
 * sampling-th row. */
static hdr_status use_channel(const char *name, hdr_exr_header *header, int place, int sampling, bool single,
                              hdr_error *err) {
    const exr_attr_chlist_entry_t *entry = &header->list->entries[header->index[place]];
    hdr_channel *channel = &header->picture.channels[place];
    if (is_uint(entry) && !single) return refuse_uint(name, entry, place == 3, err);
    if (entry->x_sampling != sampling || entry->y_sampling != sampling)
        return refuse_subsampled(name, entry, single, err);
    channel->type = entry->pixel_type == EXR_PIXEL_HALF    ? HDR_HALF
                    : entry->pixel_type == EXR_PIXEL_FLOAT ? HDR_FLOAT
                                                           : HDR_UINT;
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
        return refuse_subsampled(name, entry, false, err);
    header->chroma = entry->x_sampling;
    if (header->chroma == 2 &&
        (header->tiled || data->min_x % 2 || data->min_y % 2 || header->width % 2 || header->height % 2))
        return hdr_fail(err, HDR_BAD_DATA,
                        "%s: the header is damaged: its data window does not fit subsampled channels", name);
    return HDR_OK;
}

/* Finds the chosen channels in the library's list, which is in the order in which they are stored. An alpha that is no
 * number for a cover does no harm where none is wanted. */
static hdr_status use_channels(const char *name, hdr_exr_header *header, const hdr_reading *reading,
                               const hdr_exr_choice *choice, hdr_error *err) {
    static const char *const colours[] = {"R", "G", "B", "A"};
    hdr_picture *picture = &header->picture;
    const exr_attr_chlist_t *list;
    if (exr_get_channels(header->context, 0, &list) != EXR_ERR_SUCCESS || list->num_channels < 1)
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: no channels", name);
    header->list = list;
    bool chroma = choice->chroma[0] || choice->chroma[1];
    const char *chosen[4] = {choice->channel[0], chroma ? choice->chroma[0] : choice->channel[1],
                             chroma ? choice->chroma[1] : choice->channel[2], choice->channel[3]};
    int alpha = chosen[3] ? find_channel(list, chosen[3]) : -1;
    if (reading->no_alpha && alpha >= 0 && is_uint(&list->entries[alpha])) chosen[3] = NULL;
    picture->planes = chroma ? 3 : choice->planes;
    picture->has_alpha = chosen[3] != NULL;
    memcpy(picture->layer, choice->layer, sizeof picture->layer);
    for (int i = 0; i < 4; i++) {
        const char *missing = i < picture->planes || i == 3 ? colours[i] : "";
        snprintf(picture->channels[i].name, HDR_CHANNEL_NAME, "%s", chosen[i] ? chosen[i] : missing);
        header->index[i] = chosen[i] ? find_channel(list, chosen[i]) : -1;
    }
    hdr_status status = chroma ? read_chroma(name, header, err) : HDR_OK;
    for (int i = 0; i < 4 && status == HDR_OK; i++)
        if (header->index[i] >= 0)
            status = use_channel(name, header, i, header->chroma && (i == 1 || i == 2) ? header->chroma : 1,
                                 choice->single, err);
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

/* Where the part's chunk table begins, and where all tables begin and end. */
static hdr_status find_tables(const char *name, hdr_exr_header *header, int number, hdr_error *err) {
    const hdr_exr_file *file = &header->headers->file;
    const hdr_exr_part *part = &file->parts[number];
    uint64_t entries = 0, before = 0;
    for (int i = 0; file->multi_part && i < file->count; i++) {
        if (i == number) before = entries;
        entries += file->parts[i].chunk_count;
    }
    if (file->multi_part && part->chunk_count != header->all_chunks)
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header is damaged: part %d claims %llu chunks, and has %llu", name,
                        number, (unsigned long long)part->chunk_count, (unsigned long long)header->all_chunks);
    if (!file->multi_part) entries = header->all_chunks;
    header->table_offset = file->tables + 8 * (before + header->first_chunk);
    header->tables = file->tables;
    header->tables_end = file->tables + 8 * entries;
    return HDR_OK;
}

hdr_status hdr_exr_header_read(hdr_input *input, const hdr_reading *reading, hdr_exr_header *header, hdr_error *err) {
    const char *name = hdr_input_name(input);
    hdr_exr_choice choice = {.part = 0};
    *header = (hdr_exr_header){.tiled = false};
    header->headers = hdr_alloc(1, sizeof *header->headers);
    if (!header->headers) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    hdr_exr_file *file = &header->headers->file;
    hdr_status status = hdr_exr_walk(input, file, NULL, err);
    if (status == HDR_OK) status = hdr_exr_choose(file, name, reading, &choice, err);
    if (status == HDR_OK) {
        const hdr_exr_part *part = &file->parts[choice.part];
        header->headers->text.bytes = part->text;
        header->tiled = part->tiled;
        header->multi_part = file->multi_part;
        header->picture.part = choice.part;
        memcpy(header->picture.part_name, part->name, sizeof header->picture.part_name);
        status = parse(input, header, err);
    }
    if (status == HDR_OK) status = read_compression(name, header, err);
    if (status == HDR_OK) status = read_geometry(name, header, err);
    if (status == HDR_OK) status = read_tiles(name, header, reading, err);
    if (status == HDR_OK) status = find_tables(name, header, choice.part, err);
    if (status == HDR_OK) status = use_channels(name, header, reading, &choice, err);
    if (status == HDR_OK) status = read_colour(name, header, err);
    if (status == HDR_OK) status = read_state(name, header, err);
    if (status != HDR_OK) hdr_exr_header_free(header);
    return status;
}

void hdr_exr_header_free(hdr_exr_header *header) {
    if (header->context) exr_finish(&header->context);
    if (header->headers) hdr_exr_file_free(&header->headers->file);
    free(header->headers);
    header->context = NULL;
    header->headers = NULL;
}

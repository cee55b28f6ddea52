/* The PFS source: what the programs of pfstools hand to each other. R. Mantiuk and G. Krawczyk, "Specification of the
 * PFS File Format", version 1.5: lines of text, then a plane of little-endian floats for each channel, from the top
 * row down. A stream may hold several frames, one behind the other: the first is read. */
#include "io/raster.h"

#include "picture/colour.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE_MAX = 65535, CHANNELS_MAX = 1024, TAGS_MAX = 1024 };

struct pfs_source {
    hdr_raster raster;
    int64_t place[4]; /* which of the file's channels a plane is */
    uint64_t data;
    uint64_t plane_bytes;
    bool display;     /* gamma-corrected X, Y, Z */
    double to_rgb[9]; /* then: Rec.709 of them */
};

/* ---- The header ---- */

/* What can be used, in the order in which it is looked for. pfsinexr gives alpha the name that it has in EXR. */
enum { X, Y, Z, ALPHA, R, G, B, A, NAMES };
static const char *const names[NAMES] = {"X", "Y", "Z", "ALPHA", "R", "G", "B", "A"};

struct pfs_header {
    int width, height, channels;
    bool display;
    int place[NAMES]; /* of the channel in the file, or -1 */
    uint64_t data;
};

/* A line with one number. */
static hdr_status read_count(hdr_lines *lines, int max, const char *what, int *count, hdr_error *err) {
    hdr_status status = hdr_lines_next(lines, false, err);
    const char *text = lines->text;
    if (!status && (!hdr_text_integer(&text, count) || *count > max || !hdr_text_ends(text)))
        status = hdr_header_fault(lines->input, what, err);
    return status;
}

/* Of the tags only LUMINANCE tells how to read the picture, and only the frame's. */
static hdr_status read_tags(hdr_lines *lines, struct pfs_header *frame, hdr_error *err) {
    int count = 0;
    hdr_status status = read_count(lines, TAGS_MAX, "no count of tags", &count, err);
    for (int i = 0; !status && i < count; i++) {
        status = hdr_lines_next(lines, false, err);
        if (!status && !strchr(lines->text, '='))
            status = hdr_header_fault(lines->input, "a tag is no NAME=VALUE", err);
        if (!status && frame && strcmp(lines->text, "LUMINANCE=DISPLAY") == 0) frame->display = true;
    }
    return status;
}

static hdr_status read_channel(hdr_lines *lines, int place, struct pfs_header *header, hdr_error *err) {
    hdr_status status = hdr_lines_next(lines, false, err);
    for (int i = 0; !status && i < NAMES; i++) {
        if (strcmp(lines->text, names[i]) != 0) continue;
        if (header->place[i] >= 0) return hdr_header_fault(lines->input, "two channels have one name", err);
        header->place[i] = place;
    }
    return status ? status : read_tags(lines, NULL, err);
}

static hdr_status read_header(hdr_input *input, struct pfs_header *header, hdr_error *err) {
    hdr_lines lines = {.input = input};
    for (int i = 0; i < NAMES; i++)
        header->place[i] = -1;
    hdr_status status = hdr_lines_next(&lines, false, err); /* PFS1 */
    if (!status) status = hdr_lines_next(&lines, false, err);
    const char *text = lines.text;
    if (!status && (!hdr_text_integer(&text, &header->width) || !hdr_text_integer(&text, &header->height) ||
                    !hdr_text_ends(text) || header->width > SIDE_MAX || header->height > SIDE_MAX))
        status = hdr_header_fault(input, "no width and height from 1 to 65535", err);
    if (!status) status = read_count(&lines, CHANNELS_MAX, "no count of channels", &header->channels, err);
    if (!status) status = read_tags(&lines, header, err);
    for (int i = 0; !status && i < header->channels; i++)
        status = read_channel(&lines, i, header, err);
    if (status) return status;
    char end[4]; /* no end of line follows */
    int64_t count = hdr_input_read(input, end, sizeof end, lines.offset, err);
    if (count < 0) return HDR_IO;
    if (count < 4 || memcmp(end, "ENDH", sizeof end) != 0) return hdr_header_fault(input, "ENDH is missing", err);
    header->data = lines.offset + sizeof end;
    return HDR_OK;
}

/* ---- Rows ---- */

/* Gamma-corrected R, G and B went through the matrix as if they were light: the way back gives what they were. */
static void undo_display(const struct pfs_source *source, float *const plane[4], size_t count) {
    const double *m = source->to_rgb;
    for (size_t i = 0; i < count; i++) {
        double x = (double)plane[0][i], y = (double)plane[1][i], z = (double)plane[2][i];
        for (int c = 0; c < 3; c++) {
            double value = m[3 * c] * x + m[3 * c + 1] * y + m[3 * c + 2] * z;
            if (x - x == 0 && y - y == 0 && z - z == 0) value = fmax(fmin(value, (double)FLT_MAX), -(double)FLT_MAX);
            plane[c][i] = (float)value; /* what is not finite will be repaired */
        }
    }
}

static hdr_status read_block(hdr_source *base, void *worker, int index, hdr_block *block, hdr_error *err) {
    struct pfs_source *source = (struct pfs_source *)base;
    float *plane[4];
    hdr_status status = hdr_raster_block(&source->raster, worker, index, block, plane, err);
    size_t width = (size_t)source->raster.width, size = width * (size_t)block->rows;
    uint64_t above = (uint64_t)block->first_row * width * sizeof(float);
    for (int p = 0; !status && p < 4; p++)
        if (plane[p])
            status = hdr_raster_read(&source->raster, plane[p], size * sizeof(float),
                                     source->data + (uint64_t)source->place[p] * source->plane_bytes + above,
                                     block->first_row, block->first_row + block->rows - 1, err);
    if (!status && source->display) undo_display(source, plane, size);
    return status;
}

/* ---- The source ---- */

static void close_source(hdr_source *base) {
    free(base);
}

/* X, Y, Z; or R, G, B (pfsinexr --keep-rgb); or Y alone. */
static hdr_status choose_channels(const struct pfs_header *header, const hdr_input *input, const int **chosen,
                                  hdr_error *err) {
    static const int xyz[3] = {X, Y, Z}, rgb[3] = {R, G, B}, grey[3] = {Y, -1, -1};
    const int *place = header->place;
    if (place[X] >= 0 && place[Y] >= 0 && place[Z] >= 0)
        *chosen = xyz;
    else if (place[R] >= 0 && place[G] >= 0 && place[B] >= 0)
        *chosen = rgb;
    else if (place[Y] >= 0 && place[X] < 0 && place[Z] < 0)
        *chosen = grey;
    else
        return hdr_fail(err, HDR_BAD_DATA, "%s: the PFS stream has neither channels X, Y and Z nor Y alone",
                        hdr_input_name(input));
    return HDR_OK;
}

static void describe(struct pfs_source *source, const int *chosen, bool display) {
    hdr_picture *picture = &source->raster.base.picture;
    bool xyz = chosen[0] == X;
    if (display) snprintf(picture->state, sizeof picture->state, "srgb");
    source->display = display && xyz;
    picture->has_chromaticities = xyz && !display;
    if (picture->has_chromaticities) picture->chromaticities = hdr_cie_xyz;
}

static hdr_status open_source(struct pfs_source *source, hdr_input *input, uint64_t memory, hdr_error *err) {
    struct pfs_header header = {0};
    const int *chosen = NULL;
    hdr_status status = read_header(input, &header, err);
    if (!status) status = choose_channels(&header, input, &chosen, err);
    if (status) return status;
    int alpha = header.place[ALPHA] >= 0 ? ALPHA : header.place[A] >= 0 ? A : -1;
    const int all[4] = {chosen[0], chosen[1], chosen[2], alpha};
    const char *shown[4];
    int64_t last = 0;
    for (int p = 0; p < 4; p++) {
        shown[p] = all[p] < 0 ? NULL : p == 3 ? "A" : names[all[p]];
        source->place[p] = all[p] < 0 ? -1 : header.place[all[p]];
        if (source->place[p] > last) last = source->place[p];
    }
    status = hdr_raster_open(&source->raster, input, header.width, header.height, "pfs", shown, memory, err);
    if (status) return status;
    source->raster.base.read = read_block;
    source->raster.base.close = close_source;
    source->data = header.data;
    source->plane_bytes = (uint64_t)header.width * (uint64_t)header.height * sizeof(float);
    source->raster.base.end = source->data + (uint64_t)header.channels * source->plane_bytes;
    describe(source, chosen, header.display);
    if (!hdr_matrix_to_rec709(&hdr_cie_xyz, hdr_cie_xyz.white, false, source->to_rgb))
        return hdr_fail(err, HDR_INTERNAL, "XYZ cannot be converted");
    if (hdr_raster_reaches(&source->raster, source->data + ((uint64_t)last + 1) * source->plane_bytes, err))
        return HDR_OK;
    /* the last row of the last plane that is wanted is not there: no picture can be made */
    return hdr_fail(err, HDR_BAD_DATA, "%s: the file ends before row %d of channel %s", hdr_input_name(input),
                    header.height - 1, shown[2] ? shown[2] : shown[0]);
}

hdr_source *hdr_pfs_open(hdr_input *input, const hdr_reading *reading, hdr_error *err) {
    struct pfs_source *source = hdr_alloc(1, sizeof *source);
    hdr_status status =
        source ? open_source(source, input, reading->memory, err) : hdr_fail(err, HDR_INTERNAL, "out of memory");
    if (!status) return &source->raster.base;
    free(source);
    return NULL;
}

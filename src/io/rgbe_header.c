#include "base/options.h"
#include "io/rgbe.h"

#include <math.h>
#include <string.h>

/* The value of NAME=VALUE, behind any spaces, or NULL. */
static const char *value_of(const char *line, const char *name) {
    size_t length = strlen(name);
    if (strncmp(line, name, length) != 0 || line[length] != '=') return NULL;
    line += length + 1;
    return line + strspn(line, " \t");
}

static hdr_status read_format(const hdr_input *input, const char *value, hdr_rgbe_header *header, hdr_error *err) {
    char format[40] = "";
    size_t length = strcspn(value, " \t\r");
    if (length < sizeof format) memcpy(format, value, length);
    header->xyz = strcmp(format, "32-bit_rle_xyze") == 0;
    if (header->xyz || strcmp(format, "32-bit_rle_rgbe") == 0) return HDR_OK;
    return hdr_fail(err, HDR_BAD_DATA, "%s: its FORMAT is \"%.40s\"; pictures are 32-bit_rle_rgbe or 32-bit_rle_xyze",
                    hdr_input_name(input), value);
}

/* A factor that adds to those of the lines before. One that is not above 0 says nothing. */
static void multiply_by(double *product, const char *value) {
    double factor = 0;
    if (hdr_read_number(value, &factor) && factor > 0) *product *= factor;
}

static bool read_numbers(const char *text, double *number, int count) {
    for (int i = 0; i < count; i++) {
        text += strspn(text, " \t");
        text = hdr_read_number(text, &number[i]);
        if (!text || !isfinite(number[i])) return false;
    }
    return true;
}

/* A factor for each component, in the same way. */
static void correct_colour(double product[3], const char *value) {
    double factor[3];
    if (!read_numbers(value, factor, 3) || !(factor[0] > 0 && factor[1] > 0 && factor[2] > 0)) return;
    for (int c = 0; c < 3; c++)
        product[c] *= factor[c];
}

static hdr_status read_primaries(const hdr_input *input, const char *value, hdr_rgbe_header *header, hdr_error *err) {
    double n[8];
    if (!read_numbers(value, n, 8))
        return hdr_header_fault(input, "PRIMARIES are eight numbers: x and y of red, green, blue and white", err);
    header->primaries = (hdr_chromaticities){{n[0], n[1]}, {n[2], n[3]}, {n[4], n[5]}, {n[6], n[7]}};
    header->has_primaries = true;
    return HDR_OK;
}

static hdr_status read_variable(const hdr_input *input, const char *line, hdr_rgbe_header *header, hdr_error *err) {
    const char *value;
    if ((value = value_of(line, "FORMAT"))) return read_format(input, value, header, err);
    if ((value = value_of(line, "PRIMARIES"))) return read_primaries(input, value, header, err);
    if ((value = value_of(line, "COLORCORR"))) correct_colour(header->exposure, value);
    if ((value = value_of(line, "EXPOSURE")))
        for (int c = 0; c < 3; c++)
            multiply_by(&header->exposure[c], value);
    if ((value = value_of(line, "PIXASPECT"))) multiply_by(&header->pixel_height, value);
    return HDR_OK;
}

/* "-Y" and the like, and the number behind it. */
static bool read_axis(const char **at, char *axis, bool *minus, int *size) {
    *at += strspn(*at, " \t");
    *minus = **at == '-';
    if (!*minus && **at != '+') return false;
    *axis = *++*at;
    if (*axis != 'X' && *axis != 'Y') return false;
    ++*at;
    return hdr_text_integer(at, size) && *size > 0;
}

/* The axis that is named first is the one from scanline to scanline. X grows to the right and Y upwards. */
static bool read_resolution(const char *line, hdr_rgbe_header *header) {
    char first, second;
    bool first_minus, second_minus;
    int scanlines, length;
    if (!read_axis(&line, &first, &first_minus, &scanlines) || !read_axis(&line, &second, &second_minus, &length) ||
        first == second || !hdr_text_ends(line))
        return false;
    header->columns = first == 'X';
    header->width = header->columns ? scanlines : length;
    header->height = header->columns ? length : scanlines;
    header->scanlines_backwards = header->columns == first_minus;
    header->pixels_backwards = header->columns != second_minus;
    return true;
}

hdr_status hdr_rgbe_header_read(hdr_input *input, hdr_rgbe_header *header, hdr_error *err) {
    *header = (hdr_rgbe_header){.exposure = {1, 1, 1}, .pixel_height = 1};
    hdr_lines lines = {.input = input};
    hdr_status status = HDR_OK;
    do {
        status = hdr_lines_next(&lines, true, err);
        if (!status) status = read_variable(input, lines.text, header, err);
    } while (!status && !hdr_text_ends(lines.text)); /* an empty line ends it */
    if (!status) status = hdr_lines_next(&lines, false, err);
    if (status) return status;
    if (!read_resolution(lines.text, header))
        return hdr_header_fault(input, "no line with the resolution, such as -Y 768 +X 1024", err);
    for (int c = 0; c < 3; c++)
        if (!isfinite(header->exposure[c]) || header->exposure[c] == 0)
            return hdr_header_fault(input, "the product of its EXPOSURE and COLORCORR values is out of all bounds",
                                    err);
    header->data = lines.offset;
    return HDR_OK;
}

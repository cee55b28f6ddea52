/* The PFM source: rows of floats from the bottom one up, in either byte order. Each block is read straight from its
 * place. */
#include "base/options.h"
#include "io/raster.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { HEADER_MAX = 512 };

struct pfm_source {
    hdr_raster raster;
    uint64_t data; /* where the pixels begin */
    size_t planes; /* in the file: the picture may be made to have more */
    size_t row_bytes;
    bool big_endian;
};

/* ---- The header: PF or Pf, width, height, scale, each behind white space; one white space ends it ---- */

static bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/* The next word of the header, without copying it. *at moves to the white space behind it, which must be there. */
static const char *next_word(const char *text, size_t *at) {
    while (is_space(text[*at]))
        (*at)++;
    const char *word = text + *at;
    while (text[*at] && !is_space(text[*at]))
        (*at)++;
    return text[*at] ? word : NULL;
}

/* The size of the scale says what unit the values have, which is known to nobody; its sign is the byte order. */
static bool parse_header(const char *text, struct pfm_source *source, int *width, int *height) {
    size_t at = 2;
    double scale = 0;
    const char *word = next_word(text, &at);
    if (!word || !hdr_text_integer(&word, width) || word != text + at) return false;
    word = next_word(text, &at);
    if (!word || !hdr_text_integer(&word, height) || word != text + at) return false;
    word = next_word(text, &at);
    if (!word || hdr_read_number(word, &scale) != text + at || !isfinite(scale) || scale == 0) return false;
    source->big_endian = scale > 0;
    source->data = at + 1;
    return true;
}

/* ---- Rows ---- */

static uint32_t word_at(const unsigned char *bytes, bool big_endian) {
    return big_endian
               ? (uint32_t)bytes[3] | (uint32_t)bytes[2] << 8 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[0] << 24
               : (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static void unpack_row(const struct pfm_source *source, const unsigned char *from, float *const plane[4], size_t to) {
    for (size_t p = 0; p < source->planes; p++) {
        float *out = plane[p] + to;
        const unsigned char *in = from + p * sizeof(float);
        for (size_t x = 0; x < (size_t)source->raster.width; x++, in += source->planes * sizeof(float)) {
            uint32_t word = word_at(in, source->big_endian);
            memcpy(out + x, &word, sizeof word);
        }
    }
}

static hdr_status read_block(hdr_source *base, void *worker, int index, hdr_block *block, hdr_error *err) {
    struct pfm_source *source = (struct pfm_source *)base;
    hdr_raster_worker *own = worker;
    float *plane[4];
    hdr_status status = hdr_raster_block(&source->raster, own, index, block, plane, err);
    size_t size = source->row_bytes * (size_t)block->rows;
    if (!status) status = hdr_raster_bytes(own, size, err);
    int last = block->first_row + block->rows - 1;
    uint64_t below = (uint64_t)(source->raster.height - 1 - last) * source->row_bytes;
    if (!status)
        status = hdr_raster_read(&source->raster, own->bytes, size, source->data + below, block->first_row, last, err);
    for (int row = 0; !status && row < block->rows; row++)
        unpack_row(source, own->bytes + source->row_bytes * (size_t)(block->rows - 1 - row), plane,
                   (size_t)row * (size_t)source->raster.width);
    return status;
}

/* ---- The source ---- */

static void close_source(hdr_source *base) {
    free(base);
}

/* The top row comes last, and is the first to be wanted: a file that is cut off is found out at once. */
static hdr_status check_length(const struct pfm_source *source, hdr_error *err) {
    const hdr_raster *raster = &source->raster;
    uint64_t size = 0;
    if (!__builtin_mul_overflow((uint64_t)source->row_bytes, (uint64_t)raster->height, &size) &&
        hdr_raster_reaches(raster, source->data + size, err))
        return HDR_OK;
    if (err->status) return err->status;
    int64_t held = hdr_input_size(raster->input);
    uint64_t rows = held > (int64_t)source->data ? ((uint64_t)held - source->data) / source->row_bytes : 0;
    return hdr_fail(
        err, HDR_BAD_DATA, "%s: the file ends before row %lld of %d x %d pixels (the bottom row comes first)",
        hdr_input_name(raster->input), (long long)raster->height - 1 - (long long)rows, raster->width, raster->height);
}

/* Where lines end in CR LF, pixels begin behind the LF. A program that writes such lines may have put a CR before bytes
 * of the pixels too: then there is more than they need. (Of a pipe that is not waited for.) */
static hdr_status pass_line_feed(struct pfm_source *source, const char *text, hdr_error *err) {
    hdr_input *input = source->raster.input;
    if (text[source->data - 1] != '\r') return check_length(source, err);
    if (text[source->data] != '\n')
        return hdr_header_fault(input, "a carriage return ends it, and no line feed follows", err);
    source->data++;
    hdr_status status = check_length(source, err);
    if (status || hdr_input_flows(input)) return status;
    uint64_t end = source->data + (uint64_t)source->row_bytes * (uint64_t)source->raster.height;
    uint64_t too_long = (uint64_t)hdr_input_size(input) - end;
    if (too_long)
        return hdr_fail(err, HDR_BAD_DATA,
                        "%s: it is too long by %llu byte%s: like its lines, bytes of its pixels seem to have become "
                        "CR LF, which cannot be undone",
                        hdr_input_name(input), (unsigned long long)too_long, too_long == 1 ? "" : "s");
    return HDR_OK;
}

static hdr_status open_source(struct pfm_source *source, hdr_input *input, uint64_t memory, hdr_error *err) {
    static const char *const colour[4] = {"R", "G", "B", NULL}, *const grey[4] = {"Y", NULL, NULL, NULL};
    char text[HEADER_MAX + 1];
    int width = 0, height = 0;
    int64_t count = hdr_input_read(input, text, HEADER_MAX, 0, err);
    if (count < 0) return HDR_IO;
    text[count] = '\0';
    if (!parse_header(text, source, &width, &height))
        return hdr_header_fault(input, "PFM begins with PF or Pf, width, height, and a scale that is not 0", err);
    hdr_status status =
        hdr_raster_open(&source->raster, input, width, height, "pfm", text[1] == 'F' ? colour : grey, memory, err);
    source->planes = (size_t)source->raster.base.picture.planes;
    source->row_bytes = (size_t)width * source->planes * sizeof(float);
    source->raster.base.read = read_block;
    source->raster.base.close = close_source;
    return status ? status : pass_line_feed(source, text, err);
}

hdr_source *hdr_pfm_open(hdr_input *input, const hdr_reading *reading, hdr_error *err) {
    struct pfm_source *source = hdr_alloc(1, sizeof *source);
    hdr_status status =
        source ? open_source(source, input, reading->memory, err) : hdr_fail(err, HDR_INTERNAL, "out of memory");
    if (!status) return &source->raster.base;
    free(source);
    return NULL;
}

/* Scanlines of Radiance HDR files, in the three ways that there are to store them. */
#include "io/rgbe.h"

#include <string.h>

static const char ends[] = "the file ends before it";
static const char damaged[] = "its packed data is damaged";

void hdr_rgbe_start(hdr_rgbe_stream *stream, hdr_input *input, uint64_t offset, uint64_t least, hdr_error *err) {
    stream->input = input;
    stream->offset = offset;
    stream->least = least;
    stream->err = err;
    stream->have = stream->at = 0;
}

/* ---- Bytes ---- */

static bool fill(hdr_rgbe_stream *stream) {
    uint64_t size = sizeof stream->buffer;
    if (size > stream->least) size = stream->least ? stream->least : 1;
    int64_t count = hdr_input_read(stream->input, stream->buffer, size, stream->offset, stream->err);
    if (count <= 0) return false;
    stream->least -= (uint64_t)count < stream->least ? (uint64_t)count : stream->least;
    stream->offset += (uint64_t)count;
    stream->have = (size_t)count;
    stream->at = 0;
    return true;
}

static inline bool next(hdr_rgbe_stream *stream, unsigned char *byte) {
    if (stream->at == stream->have && !fill(stream)) return false;
    *byte = stream->buffer[stream->at++];
    return true;
}

/* Copies count bytes, or passes over them where to is NULL. */
static bool take(hdr_rgbe_stream *stream, unsigned char *to, size_t count) {
    while (count > 0) {
        if (stream->at == stream->have && !fill(stream)) return false;
        size_t piece = stream->have - stream->at < count ? stream->have - stream->at : count;
        if (to) {
            memcpy(to, stream->buffer + stream->at, piece);
            to += piece;
        }
        stream->at += piece;
        count -= piece;
    }
    return true;
}

/* ---- Scanlines ---- */

/* One component of a scanline: a count above 128 and a byte stand for count - 128 such bytes; else count bytes follow.
 */
static const char *read_runs(hdr_rgbe_stream *stream, size_t length, unsigned char *to) {
    for (size_t done = 0; done < length;) {
        unsigned char count, value;
        if (!next(stream, &count)) return ends;
        bool run = count > 128;
        size_t pixels = run ? count - 128u : count;
        if (pixels == 0 || pixels > length - done) return damaged;
        if (run && !next(stream, &value)) return ends;
        if (run && to) memset(to + done, value, pixels);
        if (!run && !take(stream, to ? to + done : NULL, pixels)) return ends;
        done += pixels;
    }
    return NULL;
}

/* Pixel by pixel. One whose mantissas are all 1 cannot be, since the largest has its high bit set: it says that the one
 * before is repeated; of several such in a row each holds 8 more bits of the count. Repetitions beyond the scanline's
 * end are cut, as Radiance does. */
static const char *read_pixels(hdr_rgbe_stream *stream, size_t length, const unsigned char first[4],
                               unsigned char *const component[4]) {
    unsigned char pixel[4], before[4] = {0};
    unsigned shift = 0;
    memcpy(pixel, first, sizeof pixel);
    for (size_t done = 0; done < length;) {
        size_t count = 1;
        if (pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1) {
            if (done == 0 || shift > 24) return damaged;
            count = (size_t)pixel[3] << shift;
            if (count > length - done) count = length - done;
            shift += 8;
        } else {
            memcpy(before, pixel, sizeof before);
            shift = 0;
        }
        for (int c = 0; component && c < 4; c++)
            memset(component[c] + done, before[c], count);
        done += count;
        if (done < length && !take(stream, pixel, sizeof pixel)) return ends;
    }
    return NULL;
}

const char *hdr_rgbe_scanline(hdr_rgbe_stream *stream, int length, unsigned char *const component[4]) {
    unsigned char start[4];
    if (!take(stream, start, sizeof start)) return ends;
    if (length < HDR_RGBE_SHORTEST || length > HDR_RGBE_LONGEST || start[0] != 2 || start[1] != 2 || start[2] > 127)
        return read_pixels(stream, (size_t)length, start, component);
    if ((start[2] << 8 | start[3]) != length) return damaged;
    const char *fault = NULL;
    for (int c = 0; c < 4 && !fault; c++)
        fault = read_runs(stream, (size_t)length, component ? component[c] : NULL);
    return fault;
}

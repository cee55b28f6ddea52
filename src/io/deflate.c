#include "io/deflate.h"

#include "base/base.h"

#include <isa-l/igzip_lib.h>
#include <stdlib.h>

struct hdr_deflater {
    struct isal_zstream stream;
    int level;
    uint32_t table_size;
    uint8_t table[];
};

/* ISA-L 2.30's assembly for levels 1 and 2 (isal_deflate_icf_body_hash_hist) goes wrong on the first byte of data
 * without history: as the hash of the bytes at position 2 it takes one of the stream object's address, so that which
 * matches are found, and with them the output, vary from run to run. Its other routine, for the last bytes before a
 * flush, has no such fault, and does the whole of a piece that is shorter than 16 bytes. So a few bytes go in first,
 * and are flushed with the history kept. It costs some seven bytes. At least 4 are needed for the routine to begin the
 * history. */
enum { FIRST_BYTES = 8, SHORT_PIECE = 15 };

hdr_deflater *hdr_deflater_new(int level) {
    uint32_t table_size = level == 1 ? ISAL_DEF_LVL1_DEFAULT : ISAL_DEF_LVL2_DEFAULT;
    hdr_deflater *deflater = hdr_alloc(1, sizeof *deflater + table_size);
    if (deflater) {
        deflater->level = level;
        deflater->table_size = table_size;
    }
    return deflater;
}

void hdr_deflater_free(hdr_deflater *deflater) {
    free(deflater);
}

size_t hdr_deflate_bound(size_t size) {
    return size + size / 8 + 4096;
}

static void begin_stream(hdr_deflater *deflater, hdr_deflate_form form, void *out, uint32_t room) {
    struct isal_zstream *stream = &deflater->stream;
    isal_deflate_init(stream);
    stream->level = (uint32_t)deflater->level;
    stream->level_buf = deflater->table;
    stream->level_buf_size = deflater->table_size;
    stream->gzip_flag = form == HDR_DEFLATE_ZLIB ? IGZIP_ZLIB : IGZIP_DEFLATE;
    stream->next_out = out;
    stream->avail_out = room;
}

/* Puts a piece in and gets all of it out. False: it did not fit. */
static bool deflate_piece(struct isal_zstream *stream, const uint8_t *data, uint32_t size, int flush, bool last) {
    stream->next_in = (uint8_t *)(uintptr_t)data; /* is not written to */
    stream->avail_in = size;
    stream->flush = (uint16_t)flush;
    stream->end_of_stream = last;
    if (isal_deflate(stream) != COMP_OK || stream->avail_in != 0) return false;
    return last ? stream->internal_state.state == ZSTATE_END : stream->avail_out > 0;
}

size_t hdr_deflate(hdr_deflater *deflater, hdr_deflate_form form, const void *data, size_t size, void *out,
                   size_t room) {
    struct isal_zstream *stream = &deflater->stream;
    uint32_t first = size > SHORT_PIECE ? FIRST_BYTES : 0;
    if (size > UINT32_MAX) return 0;
    begin_stream(deflater, form, out, room < UINT32_MAX ? (uint32_t)room : UINT32_MAX);
    if (first > 0 && !deflate_piece(stream, data, first, SYNC_FLUSH, false)) return 0;
    bool last = form != HDR_DEFLATE_PART;
    if (!deflate_piece(stream, (const uint8_t *)data + first, (uint32_t)size - first, last ? NO_FLUSH : FULL_FLUSH,
                       last))
        return 0;
    return (size_t)(stream->next_out - (uint8_t *)out);
}

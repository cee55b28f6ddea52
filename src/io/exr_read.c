/* The EXR source: blocks of rows from the chunks of a file, in the type that it stores.
 *
 * OpenEXRCore parses the header and undoes PIZ, PXR24 and B44; where the chunks are is found out here, so that bytes
 * are read as they come from a pipe, each fault can be told with its rows, and nothing is allocated that the file's
 * bytes do not back. */
#include "io/exr_header.h"
#include "io/exr_sampling.h"
#include "io/exr_unpack.h"
#include "io/exr_walk.h"
#include "io/exr_yc.h"
#include "io/source.h"

#include <stdlib.h>
#include <string.h>

enum {
    LEAST_BLOCK_ROWS = 16,
    ENTRIES = 1024,   /* of the chunk table that a worker holds: at least a block of lines has, which is 16 */
    LEADER_PART = 4,  /* bytes in front of a chunk: in a multi-part file the part's number, */
    LEADER_LINES = 8, /* then of lines: the first line, the packed size */
    LEADER_TILE = 20  /* or of a tile: across, down, level across, level down, the packed size */
};

struct exr_source {
    hdr_source base;
    hdr_input *input;
    hdr_exr_header header;
    int64_t chunks; /* of the level */
    int64_t tiles_across;
    size_t row_bytes;      /* of a row over all channels of the file; where some are subsampled, at most */
    bool in_place[4];      /* a plane's rows are aligned where a chunk of lines has them */
    size_t plane_bytes[4]; /* of one row */
};

/* Memory that is enlarged without keeping what it held. */
struct buffer {
    unsigned char *bytes;
    size_t room;
};

struct exr_worker {
    hdr_exr_unpacker *unpacker;
    uint64_t entry[ENTRIES]; /* of the chunk table, those from first_entry on: where chunks begin */
    int64_t first_entry, entries;
    int64_t first_column, end_column; /* that are looked at; where end_column is 0, all are */
    struct buffer packed;
    struct buffer chunk;  /* a tile's pixels, or a block of lines */
    struct buffer planes; /* planes that cannot be used where they were decoded */
};

static bool buffer_room(struct buffer *buffer, size_t size) {
    if (size <= buffer->room) return true;
    free(buffer->bytes);
    buffer->bytes = hdr_alloc(size, 1);
    buffer->room = buffer->bytes ? size : 0;
    return buffer->bytes != NULL;
}

/* ---- Finding chunks ---- */

static size_t leader_size(const hdr_exr_header *header) {
    return (size_t)(header->multi_part ? LEADER_PART : 0) + (header->tiled ? LEADER_TILE : LEADER_LINES);
}

/* Describes a chunk by its number, without looking at the file. */
static hdr_exr_chunk chunk_at(const struct exr_source *source, int64_t index) {
    const hdr_exr_header *header = &source->header;
    hdr_exr_chunk chunk = {.index = index};
    int64_t down = index / source->tiles_across, across = index % source->tiles_across;
    int64_t first_row = down * header->chunk_rows, rows_left = header->height - first_row;
    chunk.height = (int)(rows_left < header->chunk_rows ? rows_left : header->chunk_rows);
    if (header->tiled) {
        int64_t columns_left = header->width - across * header->tile_width;
        chunk.x = (int)across;
        chunk.y = (int)down;
        chunk.width = (int)(columns_left < header->tile_width ? columns_left : header->tile_width);
    } else {
        chunk.x = header->picture.data.min_x;
        chunk.y = (int)(header->picture.data.min_y + first_row);
        chunk.width = (int)header->width;
    }
    chunk.size = header->sampled ? hdr_exr_lines_bytes(header, chunk.y, chunk.height)
                                 : header->pixel_bytes * (size_t)chunk.width * (size_t)chunk.height;
    return chunk;
}

/* Fails with a sentence that begins with the file's name and the chunk's rows in its own coordinates. */
static hdr_status chunk_fault(const struct exr_source *source, const hdr_exr_chunk *chunk, const char *what,
                              hdr_error *err) {
    const char *name = hdr_input_name(source->input);
    int64_t first = source->header.picture.data.min_y + chunk->index / source->tiles_across * source->header.chunk_rows;
    int64_t last = first + chunk->height - 1;
    if (source->header.tiled)
        return hdr_fail(err, HDR_BAD_DATA, "%s: rows %lld to %lld, tile %d: %s", name, (long long)first,
                        (long long)last, chunk->x, what);
    if (first == last) return hdr_fail(err, HDR_BAD_DATA, "%s: row %lld: %s", name, (long long)first, what);
    return hdr_fail(err, HDR_BAD_DATA, "%s: rows %lld to %lld: %s", name, (long long)first, (long long)last, what);
}

/* Reads size bytes of a chunk. */
static hdr_status read_bytes(struct exr_source *source, const hdr_exr_chunk *chunk, void *to, size_t size,
                             uint64_t offset, hdr_error *err) {
    int64_t count = hdr_input_read(source->input, to, size, offset, err);
    if (count < 0) return HDR_IO;
    if ((uint64_t)count < size) return chunk_fault(source, chunk, "the file ends before them", err);
    return HDR_OK;
}

/* Makes sure that the chunk table is there. What a pipe has sent is held in memory. */
static hdr_status await_table(struct exr_source *source, uint64_t memory, hdr_error *err) {
    const char *name = hdr_input_name(source->input);
    const hdr_exr_header *header = &source->header;
    int64_t file_size = hdr_input_size(source->input);
    uint64_t size = (uint64_t)source->chunks * 8;
    if (file_size >= 0 &&
        (header->table_offset > (uint64_t)file_size || size > (uint64_t)file_size - header->table_offset))
        return hdr_fail(err, HDR_BAD_DATA, "%s: the header asks for %lld x %lld pixels, more than the file can hold",
                        name, (long long)header->width, (long long)header->height);
    uint64_t tables = header->tables_end - header->tables;
    if (file_size < 0 && tables > memory)
        return hdr_fail(err, HDR_BAD_DATA,
                        "%s: the header asks for %llu chunks: from a pipe, their table does not fit the memory allowed",
                        name, (unsigned long long)tables / 8);
    unsigned char last;
    int64_t count = hdr_input_read(source->input, &last, 1, header->table_offset + size - 1, err);
    if (count < 0) return HDR_IO;
    return count == 1 ? HDR_OK : hdr_fail(err, HDR_BAD_DATA, "%s: the file ends within its chunk table", name);
}

/* Finds where chunks index ... index + count - 1 begin; count is at most ENTRIES. The table is read piece by piece
 * where it is wanted: what is held of it, and looked at, does not grow with what a header claims. */
static hdr_status find_chunks(struct exr_source *source, struct exr_worker *worker, int64_t index, int64_t count,
                              const uint64_t **places, hdr_error *err) {
    if (index < worker->first_entry || index + count > worker->first_entry + worker->entries) {
        int64_t left = source->chunks - index, wanted = left < ENTRIES ? left : ENTRIES;
        worker->first_entry = index;
        worker->entries = 0;
        int64_t bytes = hdr_input_read(source->input, worker->entry, (uint64_t)wanted * 8,
                                       source->header.table_offset + 8 * (uint64_t)index, err);
        if (bytes < 0) return HDR_IO;
        if (bytes / 8 < count)
            return hdr_fail(err, HDR_BAD_DATA, "%s: the file ends within its chunk table",
                            hdr_input_name(source->input));
        worker->entries = bytes / 8;
        for (int64_t i = 0; i < worker->entries; i++)
            worker->entry[i] = hdr_little_endian_64((const unsigned char *)&worker->entry[i]);
    }
    *places = worker->entry + (index - worker->first_entry);
    return HDR_OK;
}

/* Checks what stands in front of the chunk that begins at a place, and sets its packed size and the offset of its
 * packed bytes. */
static hdr_status read_leader(struct exr_source *source, hdr_exr_chunk *chunk, uint64_t at, uint64_t *offset,
                              hdr_error *err) {
    const hdr_exr_header *header = &source->header;
    unsigned char bytes[LEADER_PART + LEADER_TILE];
    size_t size = leader_size(header);
    if (at < header->tables_end)
        return chunk_fault(source, chunk, "they are missing: the file was not written to its end", err);
    hdr_status status = read_bytes(source, chunk, bytes, size, at, err);
    if (status != HDR_OK) return status;
    const unsigned char *leader = bytes + (header->multi_part ? LEADER_PART : 0);
    uint32_t level = (uint32_t)header->picture.level;
    bool right = header->tiled
                     ? hdr_little_endian_32(leader) == (uint32_t)chunk->x &&
                           hdr_little_endian_32(leader + 4) == (uint32_t)chunk->y &&
                           hdr_little_endian_32(leader + 8) == level && hdr_little_endian_32(leader + 12) == level
                     : hdr_little_endian_32(leader) == (uint32_t)chunk->y;
    right &= !header->multi_part || hdr_little_endian_32(bytes) == (uint32_t)header->picture.part;
    chunk->packed_size = hdr_little_endian_32(bytes + size - 4);
    if (!right || !hdr_exr_plausible(header, chunk))
        return chunk_fault(source, chunk, "the chunk table or the chunk is damaged", err);
    *offset = at + size;
    int64_t file_size = hdr_input_size(source->input);
    if (file_size >= 0 && *offset + chunk->packed_size > (uint64_t)file_size)
        return chunk_fault(source, chunk, "the file ends before them", err);
    return HDR_OK;
}

/* ---- Decoding ---- */

/* Reads a chunk and unpacks it to place bytes behind the start of the worker's chunk buffer, which room bytes are
 * enough for. The buffer gets that room only when the packed bytes have come and may well hold what they claim to. */
static hdr_status decode_chunk(struct exr_source *source, struct exr_worker *worker, hdr_exr_chunk *chunk, size_t room,
                               size_t place, hdr_error *err) {
    uint64_t offset = 0;
    const uint64_t *at;
    hdr_status status = find_chunks(source, worker, chunk->index, 1, &at, err);
    if (status == HDR_OK) status = read_leader(source, chunk, *at, &offset, err);
    if (status != HDR_OK) return status;
    /* Where packing gains nothing, a writer stores the pixels as they are. (OpenEXRCore does not believe that of B44;
     * the C++ library, which wrote most files, holds to it.) */
    bool packed = chunk->packed_size != chunk->size;
    if (packed) {
        if (!buffer_room(&worker->packed, chunk->packed_size)) return hdr_fail(err, HDR_INTERNAL, "out of memory");
        status = read_bytes(source, chunk, worker->packed.bytes, chunk->packed_size, offset, err);
        if (status != HDR_OK) return status;
    }
    if (!buffer_room(&worker->chunk, room)) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    unsigned char *out = worker->chunk.bytes + place;
    if (!packed) return read_bytes(source, chunk, out, chunk->size, offset, err);
    if (!hdr_exr_unpack(worker->unpacker, chunk, worker->packed.bytes, out))
        return chunk_fault(source, chunk, "their packed data is damaged", err);
    return HDR_OK;
}

/* Lines that are stored unpacked and one behind the other can be read at once, leaders and all, and used where they
 * stand. False: these are not, or something is wrong with them, which reading them one by one will tell. */
static bool read_stored_lines(struct exr_source *source, struct exr_worker *worker, const hdr_block *block) {
    size_t pitch = leader_size(&source->header) + source->row_bytes, size = pitch * (size_t)block->rows;
    int64_t file_size = hdr_input_size(source->input);
    if (source->header.compression != EXR_COMPRESSION_NONE || source->header.sampled) return false;
    const uint64_t *table;
    if (find_chunks(source, worker, block->first_row, block->rows, &table, NULL) != HDR_OK ||
        table[0] < source->header.tables_end)
        return false;
    for (int i = 1; i < block->rows; i++)
        if (table[i] - table[i - 1] != pitch) return false;
    if (file_size >= 0 && (table[0] > (uint64_t)file_size || size > (uint64_t)file_size - table[0])) return false;
    if (!buffer_room(&worker->chunk, size)) return false;
    if (hdr_input_read(source->input, worker->chunk.bytes, size, table[0], NULL) != (int64_t)size) return false;
    for (int i = 0; i < block->rows; i++) {
        const unsigned char *leader = worker->chunk.bytes + pitch * (size_t)i;
        int line = source->header.picture.data.min_y + block->first_row + i;
        if (source->header.multi_part) {
            if (hdr_little_endian_32(leader) != (uint32_t)source->header.picture.part) return false;
            leader += LEADER_PART;
        }
        if (hdr_little_endian_32(leader) != (uint32_t)line || hdr_little_endian_32(leader + 4) != source->row_bytes)
            return false;
    }
    return true;
}

/* Where plane p stands in the worker's plane buffer, and in all (p = 4) how large that is. Each begins aligned. */
static size_t plane_place(const struct exr_source *source, int p, int rows) {
    size_t place = 0;
    for (int i = 0; i < p; i++)
        if (source->header.picture.present[i]) place += (source->plane_bytes[i] * (size_t)rows + 63) / 64 * 64;
    return place;
}

/* Points the block's planes to where rows over all channels begin; those that are not aligned there are copied. */
static hdr_status set_planes_of_lines(struct exr_source *source, struct exr_worker *worker, const unsigned char *rows,
                                      size_t pitch, hdr_block *block, hdr_error *err) {
    const hdr_exr_header *header = &source->header;
    for (int p = 0; p < 4; p++) {
        if (!header->picture.present[p]) continue;
        const unsigned char *from = rows + header->before[p] * (size_t)header->width;
        if (source->in_place[p]) {
            block->plane[p] = from;
            block->stride[p] = pitch;
            continue;
        }
        if (!buffer_room(&worker->planes, plane_place(source, 4, block->rows)))
            return hdr_fail(err, HDR_INTERNAL, "out of memory");
        unsigned char *to = worker->planes.bytes + plane_place(source, p, block->rows);
        for (int i = 0; i < block->rows; i++)
            memcpy(to + source->plane_bytes[p] * (size_t)i, from + pitch * (size_t)i, source->plane_bytes[p]);
        block->plane[p] = to;
        block->stride[p] = source->plane_bytes[p];
    }
    return HDR_OK;
}

/* The same where lines differ in length. */
static hdr_status read_sampled_lines(struct exr_source *source, struct exr_worker *worker, hdr_block *block,
                                     hdr_error *err) {
    const hdr_exr_header *header = &source->header;
    size_t place = 0;
    for (int row = 0; row < block->rows; row += header->chunk_rows) {
        hdr_exr_chunk chunk = chunk_at(source, (block->first_row + row) / header->chunk_rows);
        hdr_status status = decode_chunk(source, worker, &chunk, source->row_bytes * (size_t)block->rows, place, err);
        if (status != HDR_OK) return status;
        place += chunk.size;
    }
    if (!buffer_room(&worker->planes, plane_place(source, 4, block->rows)))
        return hdr_fail(err, HDR_INTERNAL, "out of memory");
    unsigned char *to[4] = {NULL};
    for (int p = 0; p < 4; p++) {
        if (!header->picture.present[p]) continue;
        block->plane[p] = to[p] = worker->planes.bytes + plane_place(source, p, block->rows);
        block->stride[p] = source->plane_bytes[p];
    }
    hdr_exr_gather_lines(header, worker->chunk.bytes, (int64_t)header->picture.data.min_y + block->first_row,
                         block->rows, to, source->plane_bytes);
    return HDR_OK;
}

static hdr_status read_lines(struct exr_source *source, struct exr_worker *worker, hdr_block *block, hdr_error *err) {
    if (source->header.sampled) return read_sampled_lines(source, worker, block, err);
    size_t leader = leader_size(&source->header);
    if (read_stored_lines(source, worker, block))
        return set_planes_of_lines(source, worker, worker->chunk.bytes + leader, leader + source->row_bytes, block,
                                   err);
    int chunk_rows = source->header.chunk_rows;
    for (int row = 0; row < block->rows; row += chunk_rows) {
        hdr_exr_chunk chunk = chunk_at(source, (block->first_row + row) / chunk_rows);
        hdr_status status = decode_chunk(source, worker, &chunk, source->row_bytes * (size_t)block->rows,
                                         source->row_bytes * (size_t)row, err);
        if (status != HDR_OK) return status;
    }
    return set_planes_of_lines(source, worker, worker->chunk.bytes, source->row_bytes, block, err);
}

/* Copies the planes of a decoded tile to their columns of the band. */
static void place_tile(const struct exr_source *source, const struct exr_worker *worker, const hdr_exr_chunk *tile) {
    const hdr_exr_header *header = &source->header;
    size_t tile_pitch = header->pixel_bytes * (size_t)tile->width;
    size_t column = (size_t)tile->x * (size_t)header->tile_width;
    for (int p = 0; p < 4; p++) {
        if (!header->picture.present[p]) continue;
        size_t size = hdr_type_size(header->picture.channels[p].type);
        const unsigned char *from = worker->chunk.bytes + header->before[p] * (size_t)tile->width;
        unsigned char *to = worker->planes.bytes + plane_place(source, p, tile->height) + column * size;
        for (int i = 0; i < tile->height; i++)
            memcpy(to + source->plane_bytes[p] * (size_t)i, from + tile_pitch * (size_t)i, (size_t)tile->width * size);
    }
}

static hdr_status read_tiles(struct exr_source *source, struct exr_worker *worker, hdr_block *block, hdr_error *err) {
    int64_t first = block->first_row / source->header.chunk_rows * source->tiles_across;
    int64_t from = worker->first_column / source->header.tile_width, end = source->tiles_across;
    if (worker->end_column) end = (worker->end_column - 1) / source->header.tile_width + 1;
    for (int64_t across = from; across < end; across++) {
        hdr_exr_chunk tile = chunk_at(source, first + across);
        hdr_status status = decode_chunk(source, worker, &tile, tile.size, 0, err);
        if (status != HDR_OK) return status;
        if (!buffer_room(&worker->planes, plane_place(source, 4, block->rows)))
            return hdr_fail(err, HDR_INTERNAL, "out of memory");
        place_tile(source, worker, &tile);
    }
    for (int p = 0; p < 4; p++) {
        if (!source->header.picture.present[p]) continue;
        block->plane[p] = worker->planes.bytes + plane_place(source, p, block->rows);
        block->stride[p] = source->plane_bytes[p];
    }
    return HDR_OK;
}

/* ---- The source ---- */

static void worker_free(hdr_source *base, void *worker) {
    (void)base;
    struct exr_worker *own = worker;
    if (!own) return;
    hdr_exr_unpacker_free(own->unpacker);
    free(own->packed.bytes);
    free(own->chunk.bytes);
    free(own->planes.bytes);
    free(own);
}

static void worker_columns(void *worker, int64_t first, int64_t end) {
    struct exr_worker *own = worker;
    own->first_column = first;
    own->end_column = end;
}

static hdr_status worker_new(hdr_source *base, void **worker, hdr_error *err) {
    struct exr_source *source = (struct exr_source *)base;
    struct exr_worker *own = hdr_alloc(1, sizeof *own);
    *worker = NULL;
    if (!own) return hdr_fail(err, HDR_INTERNAL, "out of memory");
    worker_columns(own, base->first_column, base->end_column);
    hdr_error fault = {0};
    own->unpacker = hdr_exr_unpacker_new(&source->header, &fault);
    if (!own->unpacker) {
        worker_free(base, own);
        return hdr_fail(err, fault.status, "%s: %s", hdr_input_name(source->input), fault.message);
    }
    *worker = own;
    return HDR_OK;
}

static hdr_status read_block(hdr_source *base, void *worker, int index, hdr_block *block, hdr_error *err) {
    struct exr_source *source = (struct exr_source *)base;
    int64_t first = (int64_t)index * base->block_rows, left = source->header.height - first;
    *block = (hdr_block){.first_row = (int)first, .rows = (int)(left < base->block_rows ? left : base->block_rows)};
    for (int p = 0; p < 4; p++)
        block->type[p] = source->header.picture.channels[p].type;
    return source->header.tiled ? read_tiles(source, worker, block, err) : read_lines(source, worker, block, err);
}

static void close_source(hdr_source *base) {
    struct exr_source *source = (struct exr_source *)base;
    hdr_exr_header_free(&source->header);
    free(source);
}

/* Divides the picture into chunks and blocks, and refuses a size that one block of would not fit the memory allowed. */
static hdr_status lay_out(struct exr_source *source, uint64_t memory, hdr_error *err) {
    const hdr_exr_header *header = &source->header;
    int64_t width = header->width, height = header->height;
    int chunk_rows = header->chunk_rows;
    source->tiles_across = header->tiled ? (width + header->tile_width - 1) / header->tile_width : 1;
    source->chunks = (height + chunk_rows - 1) / chunk_rows * source->tiles_across;
    int block_rows = header->tiled || chunk_rows >= LEAST_BLOCK_ROWS ? chunk_rows : LEAST_BLOCK_ROWS;
    uint64_t row_bytes = (uint64_t)width * header->pixel_bytes;
    uint64_t held_rows = (uint64_t)(height < block_rows ? height : block_rows);
    uint64_t band_bytes = 0, chunk_bytes = 0;
    uint64_t chunk_width = (uint64_t)(header->tiled ? header->tile_width : width);
    if (__builtin_mul_overflow(row_bytes, held_rows, &band_bytes) || band_bytes > memory ||
        __builtin_mul_overflow(chunk_width * header->pixel_bytes, (uint64_t)chunk_rows, &chunk_bytes) ||
        (chunk_bytes > INT32_MAX && band_bytes > INT32_MAX) || source->chunks > INT32_MAX)
        return hdr_fail(
            err, HDR_BAD_DATA,
            "%s: the header asks for %lld x %lld pixels of %zu bytes: %lld rows at once do not fit the memory allowed",
            hdr_input_name(source->input), (long long)width, (long long)height, header->pixel_bytes,
            (long long)held_rows);
    source->row_bytes = (size_t)row_bytes;
    source->base.block_rows = block_rows;
    source->base.tile_columns = header->tiled ? (int)chunk_width : 0;
    source->base.blocks = (int)((height + block_rows - 1) / block_rows);
    for (int p = 0; p < 4; p++) {
        size_t size = hdr_type_size(header->picture.channels[p].type);
        source->plane_bytes[p] = size * (size_t)width;
        source->in_place[p] = header->before[p] * (size_t)width % size == 0 && source->row_bytes % size == 0;
    }
    return HDR_OK;
}

hdr_source *hdr_exr_open(hdr_input *input, const hdr_reading *reading, hdr_error *err) {
    struct exr_source *source = hdr_alloc(1, sizeof *source);
    if (!source) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        return NULL;
    }
    source->input = input;
    source->base.worker_new = worker_new;
    source->base.read = read_block;
    source->base.worker_free = worker_free;
    source->base.worker_columns = worker_columns;
    source->base.close = close_source;
    hdr_status status = hdr_exr_header_read(input, reading, &source->header, err);
    if (status == HDR_OK) status = lay_out(source, reading->memory, err);
    if (status == HDR_OK) status = await_table(source, reading->memory, err);
    if (status != HDR_OK) {
        close_source(&source->base);
        return NULL;
    }
    source->base.picture = source->header.picture;
    if (source->header.chroma) return hdr_yc_open(&source->base, source->header.chroma, input, reading, err);
    return &source->base;
}

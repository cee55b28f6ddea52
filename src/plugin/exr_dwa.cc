// DWAA and DWAB chunks by OpenEXR's C++ library.
//
// The library's compressors are not part of its public interface; its files are. So a chunk to be unpacked is given to
// it as the only chunk of a little file in memory, and a chunk to be packed is taken from such a file. The header costs
// some microseconds, where a chunk of ordinary size takes milliseconds. A thread count of 0 for each file makes the
// library work on the calling thread.
#include "exr_dwa.h"

#include <Iex.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfTiledInputFile.h>
#include <ImfTiledOutputFile.h>
#include <ImfVersion.h>
#include <ImfXdr.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

// ---- Memory ----

// The library does not see to it that a damaged chunk fills its buffers to the end: what was in that memory before
// would come out as pixels, other ones in each run. It takes its memory from here, since the loader looks up the
// symbols of a plug-in's libraries in the plug-in before it looks in libstdc++; so what is not filled is 0. (In a C++
// program, whose own operator new comes first, it is that one's memory.)

static void *cleared(size_t size) {
    return std::calloc(1, size > 0 ? size : 1);
}

static void *cleared_or_throw(size_t size) {
    void *memory = cleared(size);
    if (!memory) throw std::bad_alloc();
    return memory;
}

void *operator new(size_t size) {
    return cleared_or_throw(size);
}
void *operator new[](size_t size) {
    return cleared_or_throw(size);
}
void *operator new(size_t size, const std::nothrow_t &) noexcept {
    return cleared(size);
}
void *operator new[](size_t size, const std::nothrow_t &) noexcept {
    return cleared(size);
}
void operator delete(void *memory) noexcept {
    std::free(memory);
}
void operator delete[](void *memory) noexcept {
    std::free(memory);
}
void operator delete(void *memory, size_t) noexcept {
    std::free(memory);
}
void operator delete[](void *memory, size_t) noexcept {
    std::free(memory);
}
void operator delete(void *memory, const std::nothrow_t &) noexcept {
    std::free(memory);
}
void operator delete[](void *memory, const std::nothrow_t &) noexcept {
    std::free(memory);
}

namespace {

constexpr size_t longest_short_name = 31; // longer ones are announced in the version word
constexpr size_t lines_leader = 8;        // bytes in front of packed lines: the first line, the packed size
constexpr size_t tile_leader = 20; // and of a packed tile: across, down, level across, level down, the packed size

// The chunk's form cannot be done.
struct refusal : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// ---- Files in memory ----

// A text, and bytes behind it.
class input_bytes : public Imf::IStream {
  public:
    input_bytes(const std::string &front, const void *back, size_t back_size)
        : IStream("chunk"), front_(front), back_(static_cast<const char *>(back)), back_size_(back_size) {
    }

    bool read(char to[], int count) override {
        size_t size = static_cast<size_t>(count), whole = front_.size() + back_size_;
        if (count < 0 || position_ > whole || size > whole - position_) throw Iex::InputExc("the chunk ends too early");
        size_t in_front = position_ < front_.size() ? std::min(size, front_.size() - position_) : 0;
        if (in_front > 0) std::memcpy(to, front_.data() + position_, in_front);
        if (size > in_front)
            std::memcpy(to + in_front, back_ + (position_ + in_front - front_.size()), size - in_front);
        position_ += size;
        return position_ < whole;
    }

    uint64_t tellg() override {
        return position_;
    }

    void seekg(uint64_t position) override {
        position_ = static_cast<size_t>(position);
    }

  private:
    const std::string &front_;
    const char *back_;
    size_t back_size_;
    size_t position_ = 0;
};

class output_bytes : public Imf::OStream {
  public:
    output_bytes() : OStream("chunk") {
    }

    void write(const char from[], int count) override {
        size_t end = position_ + static_cast<size_t>(count);
        if (end > bytes.size()) bytes.resize(end);
        bytes.replace(position_, static_cast<size_t>(count), from, static_cast<size_t>(count));
        position_ = end;
    }

    uint64_t tellp() override {
        return position_;
    }

    void seekp(uint64_t position) override {
        position_ = static_cast<size_t>(position);
    }

    std::string bytes;

  private:
    size_t position_ = 0;
};

// ---- The chunk's form ----

size_t sample_bytes(const hdr_dwa_channel &channel) {
    return channel.type == Imf::HALF ? 2 : 4;
}

bool sampled_fully(const hdr_dwa_channel &channel) {
    return channel.x_sampling == 1 && channel.y_sampling == 1;
}

// Samples of a channel in a line that has any.
size_t samples_across(const hdr_dwa_chunk &chunk, const hdr_dwa_channel &channel) {
    size_t step = static_cast<size_t>(channel.x_sampling);
    return (static_cast<size_t>(chunk.width) + step - 1) / step;
}

// Lines of the chunk in which a channel has samples.
size_t samples_down(const hdr_dwa_chunk &chunk, const hdr_dwa_channel &channel) {
    size_t step = static_cast<size_t>(channel.y_sampling);
    return (static_cast<size_t>(chunk.height) + step - 1) / step;
}

// Whether every channel has samples everywhere, so that the pixels can be used where they stand. Refuses what makes no
// sense.
bool check_form(const hdr_dwa_chunk &chunk, size_t size) {
    if (chunk.width < 1 || chunk.height < 1 || chunk.channel_count < 1 || (chunk.lines != 32 && chunk.lines != 256) ||
        (!chunk.tiled && chunk.height > chunk.lines))
        throw refusal("not the form of a DWA chunk");
    bool full = true;
    size_t needed = 0;
    for (int c = 0; c < chunk.channel_count; c++) {
        const hdr_dwa_channel &channel = chunk.channels[c];
        if (channel.type < 0 || channel.type >= Imf::NUM_PIXELTYPES || channel.x_sampling < 1 || channel.y_sampling < 1)
            throw refusal("not a channel of a DWA chunk");
        full = full && sampled_fully(channel);
        needed += samples_across(chunk, channel) * samples_down(chunk, channel) * sample_bytes(channel);
    }
    if (needed != size) throw refusal("not the size of such a DWA chunk");
    return full;
}

Imf::Header header_of(const hdr_dwa_chunk &chunk) {
    Imf::Header header(chunk.width, chunk.height);
    header.compression() = chunk.lines == 32 ? Imf::DWAA_COMPRESSION : Imf::DWAB_COMPRESSION;
    for (int c = 0; c < chunk.channel_count; c++) {
        const hdr_dwa_channel &channel = chunk.channels[c];
        header.channels().insert(channel.name, Imf::Channel(static_cast<Imf::PixelType>(channel.type),
                                                            channel.x_sampling, channel.y_sampling));
    }
    if (chunk.tiled)
        header.setTileDescription(
            Imf::TileDescription(static_cast<unsigned>(chunk.width), static_cast<unsigned>(chunk.height)));
    return header;
}

// All channels sampled fully: where they stand among the pixels. The library writes to them only when it reads.
Imf::FrameBuffer slices_in_place(const hdr_dwa_chunk &chunk, char *pixels) {
    Imf::FrameBuffer slices;
    size_t line_bytes = 0, before = 0, width = static_cast<size_t>(chunk.width);
    for (int c = 0; c < chunk.channel_count; c++)
        line_bytes += sample_bytes(chunk.channels[c]) * width;
    for (int c = 0; c < chunk.channel_count; c++) {
        const hdr_dwa_channel &channel = chunk.channels[c];
        slices.insert(channel.name, Imf::Slice(static_cast<Imf::PixelType>(channel.type), pixels + before,
                                               sample_bytes(channel), line_bytes));
        before += sample_bytes(channel) * width;
    }
    return slices;
}

// Channels one behind the other, where lines have different ones.
class planes {
  public:
    explicit planes(const hdr_dwa_chunk &chunk) : chunk_(chunk) {
        size_t size = 0;
        for (int c = 0; c < chunk.channel_count; c++) {
            start_.push_back(size);
            size += samples_across(chunk, chunk.channels[c]) * samples_down(chunk, chunk.channels[c]) *
                    sample_bytes(chunk.channels[c]);
        }
        bytes_.resize(size);
    }

    Imf::FrameBuffer slices() {
        Imf::FrameBuffer slices;
        for (int c = 0; c < chunk_.channel_count; c++) {
            const hdr_dwa_channel &channel = chunk_.channels[c];
            slices.insert(channel.name,
                          Imf::Slice(static_cast<Imf::PixelType>(channel.type),
                                     bytes_.data() + start_[static_cast<size_t>(c)], sample_bytes(channel),
                                     sample_bytes(channel) * samples_across(chunk_, channel), channel.x_sampling,
                                     channel.y_sampling));
        }
        return slices;
    }

    // To the order of a chunk, or back from it.
    void interleave(char *to) const {
        each_line([&](size_t plane_at, size_t size) {
            std::memcpy(to, bytes_.data() + plane_at, size);
            to += size;
        });
    }
    void separate(const char *from) {
        each_line([&](size_t plane_at, size_t size) {
            std::memcpy(bytes_.data() + plane_at, from, size);
            from += size;
        });
    }

  private:
    template <typename Copy> void each_line(Copy copy) const {
        for (int y = 0; y < chunk_.height; y++)
            for (int c = 0; c < chunk_.channel_count; c++) {
                const hdr_dwa_channel &channel = chunk_.channels[c];
                if (y % channel.y_sampling != 0) continue;
                size_t size = sample_bytes(channel) * samples_across(chunk_, channel);
                copy(start_[static_cast<size_t>(c)] + size * static_cast<size_t>(y / channel.y_sampling), size);
            }
    }

    const hdr_dwa_chunk &chunk_;
    std::vector<size_t> start_;
    std::vector<char> bytes_;
};

// ---- Unpacking ----

// All of a file but its packed bytes.
std::string file_in_front_of(const hdr_dwa_chunk &chunk, size_t packed_size) {
    using Imf::StreamIO;
    using Imf::Xdr::write;
    output_bytes file;
    int version = Imf::EXR_VERSION;
    for (int c = 0; c < chunk.channel_count; c++)
        if (std::strlen(chunk.channels[c].name) > longest_short_name) version |= Imf::LONG_NAMES_FLAG;
    if (chunk.tiled) version |= Imf::TILED_FLAG;
    write<StreamIO>(static_cast<Imf::OStream &>(file), Imf::MAGIC);
    write<StreamIO>(static_cast<Imf::OStream &>(file), version);
    header_of(chunk).writeTo(file, chunk.tiled != 0);
    write<StreamIO>(static_cast<Imf::OStream &>(file), file.tellp() + 8); // the chunk table
    for (int i = 0; i < (chunk.tiled ? 4 : 1); i++)
        write<StreamIO>(static_cast<Imf::OStream &>(file), 0); // which chunk it is
    write<StreamIO>(static_cast<Imf::OStream &>(file), static_cast<int>(packed_size));
    return file.bytes;
}

void read_chunk(const hdr_dwa_chunk &chunk, const void *packed, size_t packed_size, const Imf::FrameBuffer &slices) {
    std::string front = file_in_front_of(chunk, packed_size);
    input_bytes stream(front, packed, packed_size);
    if (chunk.tiled) {
        Imf::TiledInputFile file(stream, 0);
        file.setFrameBuffer(slices);
        file.readTile(0, 0);
    } else {
        Imf::InputFile file(stream, 0);
        file.setFrameBuffer(slices);
        file.readPixels(0, chunk.height - 1);
    }
}

void unpack_chunk(const hdr_dwa_chunk &chunk, const void *packed, size_t packed_size, char *pixels, size_t size) {
    bool full = check_form(chunk, size);
    // A reader takes a chunk of the pixels' size for pixels.
    if (packed_size < 1 || packed_size >= size || size > INT32_MAX) throw refusal("not the size of a DWA chunk");
    if (full) {
        read_chunk(chunk, packed, packed_size, slices_in_place(chunk, pixels));
        return;
    }
    planes separate(chunk);
    read_chunk(chunk, packed, packed_size, separate.slices());
    separate.interleave(pixels);
}

// ---- Packing ----

// The file's only chunk, its leader in front.
std::string write_chunk(const hdr_dwa_chunk &chunk, float level, const Imf::FrameBuffer &slices) {
    output_bytes stream;
    Imf::Header header = header_of(chunk);
    header.dwaCompressionLevel() = level;
    size_t start = 0, end = 0;
    // What a file writes when it is closed, the chunk table, goes to the front.
    if (chunk.tiled) {
        Imf::TiledOutputFile file(stream, header, 0);
        start = stream.bytes.size();
        file.setFrameBuffer(slices);
        file.writeTile(0, 0);
        end = stream.bytes.size();
    } else {
        Imf::OutputFile file(stream, header, 0);
        start = stream.bytes.size();
        file.setFrameBuffer(slices);
        file.writePixels(chunk.height);
        end = stream.bytes.size();
    }
    return stream.bytes.substr(start, end - start);
}

size_t pack_chunk(const hdr_dwa_chunk &chunk, float level, const char *pixels, size_t size, void *packed, size_t room) {
    bool full = check_form(chunk, size);
    if (size > INT32_MAX) throw refusal("not the size of a DWA chunk");
    std::string written;
    if (full) {
        written = write_chunk(chunk, level, slices_in_place(chunk, const_cast<char *>(pixels)));
    } else {
        planes separate(chunk);
        separate.separate(pixels);
        written = write_chunk(chunk, level, separate.slices());
    }
    size_t leader = chunk.tiled ? tile_leader : lines_leader;
    if (written.size() <= leader) throw refusal("the library wrote no chunk");
    size_t packed_size = written.size() - leader;
    if (packed_size >= room || packed_size >= size) return 0;
    std::memcpy(packed, written.data() + leader, packed_size);
    return packed_size;
}

// ---- No exception leaves ----

template <typename Work> hdr_dwa_result guarded(hdr_dwa_message *message, Work work) {
    const char *what = "";
    hdr_dwa_result result = HDR_DWA_OK;
    message->text[0] = '\0';
    try {
        work();
        return HDR_DWA_OK;
    } catch (const refusal &refused) {
        std::snprintf(message->text, sizeof message->text, "%s", refused.what());
        return HDR_DWA_REFUSED;
    } catch (const std::bad_alloc &) {
        result = HDR_DWA_OUT_OF_MEMORY;
        what = "out of memory";
    } catch (const std::length_error &) {
        result = HDR_DWA_OUT_OF_MEMORY;
        what = "out of memory";
    } catch (const std::exception &fault) {
        std::snprintf(message->text, sizeof message->text, "%s", fault.what());
        return HDR_DWA_BAD_DATA;
    } catch (...) {
        result = HDR_DWA_BAD_DATA;
        what = "an unknown fault";
    }
    std::snprintf(message->text, sizeof message->text, "%s", what);
    return result;
}

hdr_dwa_result unpack(const hdr_dwa_chunk *chunk, const void *packed, size_t packed_size, void *pixels, size_t size,
                      hdr_dwa_message *message) {
    return guarded(message, [&] { unpack_chunk(*chunk, packed, packed_size, static_cast<char *>(pixels), size); });
}

hdr_dwa_result pack(const hdr_dwa_chunk *chunk, float level, const void *pixels, size_t size, void *packed, size_t room,
                    size_t *packed_size, hdr_dwa_message *message) {
    *packed_size = 0;
    return guarded(message, [&] {
        *packed_size = pack_chunk(*chunk, level, static_cast<const char *>(pixels), size, packed, room);
    });
}

} // namespace

const hdr_dwa_codec hdr_dwa = {HDR_DWA_INTERFACE, unpack, pack};

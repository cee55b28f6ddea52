/* Luminance-chroma pictures against OpenEXR's own RgbaInputFile, bit for bit: real ones from the corpus
 * (HDRPIPE_CORPUS), and small ones of all kinds that the library writes here. And files with a subsampled channel that
 * nobody asked for, and luminance laid over a colour. At every level of the kernels. */
extern "C" {
#include "base/cpu.h"
#include "check.h"
#include "io/source.h"
#include "kernel/strip.h"
}

#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfRgbaFile.h>
#include <ImfRgbaYca.h>
#include <ImfStandardAttributes.h>
#include <ImfTiledOutputFile.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

using namespace Imf;
using Imath::Box2i;
using Imath::V2i;

namespace {

const uint64_t MEMORY = 256 << 20;

/* ---- Files in memory ---- */

struct memory_out : OStream {
    std::string bytes;
    uint64_t at = 0;
    memory_out() : OStream("memory") {
    }
    void write(const char data[], int count) override {
        if (bytes.size() < at + (uint64_t)count) bytes.resize(at + (uint64_t)count);
        memcpy(&bytes[at], data, (size_t)count);
        at += (uint64_t)count;
    }
    uint64_t tellp() override {
        return at;
    }
    void seekp(uint64_t to) override {
        at = to;
    }
};

struct memory_in : IStream {
    const std::string &bytes;
    uint64_t at = 0;
    explicit memory_in(const std::string &from) : IStream("memory"), bytes(from) {
    }
    bool read(char data[], int count) override {
        if (at + (uint64_t)count > bytes.size()) throw std::runtime_error("the file ends");
        memcpy(data, &bytes[at], (size_t)count);
        at += (uint64_t)count;
        return at < bytes.size();
    }
    uint64_t tellg() override {
        return at;
    }
    void seekg(uint64_t to) override {
        at = to;
    }
};

/* ---- Random numbers: splitmix64 ---- */

uint64_t random_state = 1;

uint64_t random_bits() {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

float random_unit() {
    return (float)(random_bits() >> 40) * 0x1p-24f;
}

/* ---- Ours ---- */

struct image {
    hdr_picture about;
    std::vector<unsigned char> plane[4];
};

enum order { FORWARD, BACKWARD, BY_TURNS };

/* Reads all blocks, by two workers in turn or by one. */
hdr_status read_ours(const std::string &bytes, order how, image &out, hdr_error &error) {
    error = hdr_error();
    hdr_reading reading = hdr_reading();
    reading.memory = MEMORY;
    hdr_input *input = hdr_input_memory(bytes.data(), bytes.size(), "test", &error);
    hdr_source *source = input ? hdr_source_open(input, &reading, &error) : NULL;
    void *worker[2] = {NULL, NULL};
    if (source) {
        out.about = source->picture;
        size_t width = (size_t)hdr_window_width(&source->picture.data);
        size_t height = (size_t)hdr_window_height(&source->picture.data);
        for (int w = 0; w < 2; w++)
            source->worker_new(source, &worker[w], &error);
        for (int i = 0; i < source->blocks && !error.status; i++) {
            hdr_block block;
            int index = how == BACKWARD ? source->blocks - 1 - i : i;
            if (source->read(source, worker[how == BY_TURNS ? i % 2 : 0], index, &block, &error)) break;
            for (int c = 0; c < 4; c++) {
                size_t row_bytes = width * hdr_type_size(block.type[c]);
                if (!block.plane[c]) continue;
                out.plane[c].resize(row_bytes * height);
                for (int row = 0; row < block.rows; row++)
                    memcpy(&out.plane[c][row_bytes * (size_t)(block.first_row + row)],
                           block.plane[c] + block.stride[c] * (size_t)row, row_bytes);
            }
        }
        for (int w = 0; w < 2; w++)
            source->worker_free(source, worker[w]);
    }
    hdr_source_close(source);
    hdr_input_free(input);
    return error.status;
}

uint16_t half_at(const image &picture, int channel, size_t pixel) {
    uint16_t value;
    memcpy(&value, &picture.plane[channel][2 * pixel], sizeof value);
    return value;
}

/* What is no number is one no number as another. */
bool same_half(uint16_t a, uint16_t b) {
    bool not_a = (a & 0x7fff) > 0x7c00, not_b = (b & 0x7fff) > 0x7c00;
    return a == b || (not_a && not_b);
}

/* ---- The comparison ---- */

void compare_pixels(const std::string &name, const image &ours, const std::vector<Rgba> &theirs) {
    size_t wrong = 0, first = 0;
    for (size_t i = 0; i < theirs.size(); i++) {
        bool same = same_half(half_at(ours, 0, i), theirs[i].r.bits()) &&
                    same_half(half_at(ours, 1, i), theirs[i].g.bits()) &&
                    same_half(half_at(ours, 2, i), theirs[i].b.bits());
        if (ours.about.has_alpha && ours.about.channels[3].type == HDR_HALF)
            same = same && same_half(half_at(ours, 3, i), theirs[i].a.bits());
        if (!same && !wrong++) first = i;
    }
    CHECK(wrong == 0, "%s: %zu of %zu pixels differ, the first is %zu: %04x %04x %04x instead of %04x %04x %04x",
          name.c_str(), wrong, theirs.size(), first, half_at(ours, 0, first), half_at(ours, 1, first),
          half_at(ours, 2, first), theirs[first].r.bits(), theirs[first].g.bits(), theirs[first].b.bits());
}

std::vector<Rgba> read_theirs(const std::string &bytes) {
    memory_in stream(bytes);
    RgbaInputFile file(stream);
    Box2i window = file.dataWindow();
    ptrdiff_t width = window.max.x - window.min.x + 1;
    std::vector<Rgba> pixels((size_t)(width * (window.max.y - window.min.y + 1)));
    file.setFrameBuffer(pixels.data() - window.min.x - window.min.y * width, 1, (size_t)width);
    file.readPixels(window.min.y, window.max.y);
    return pixels;
}

void compare(const std::string &name, const std::string &bytes) {
    std::vector<Rgba> theirs;
    try {
        theirs = read_theirs(bytes);
    } catch (const std::exception &fault) {
        CHECK(false, "%s: RgbaInputFile: %s", name.c_str(), fault.what());
        return;
    }
    for (order how : {FORWARD, BACKWARD, BY_TURNS}) {
        image ours;
        hdr_error error;
        CHECK(read_ours(bytes, how, ours, error) == HDR_OK, "%s: %s", name.c_str(), error.message);
        if (error.status) return;
        bool grey = ours.about.planes == 1;
        if (grey) ours.plane[1] = ours.plane[2] = ours.plane[0];
        if (grey) /* RgbaInputFile fills R alone, as its header says */
            for (Rgba &pixel : theirs)
                pixel.g = pixel.b = pixel.r;
        for (int c = 0; c < 3; c++)
            CHECK(ours.about.channels[grey ? 0 : c].type == HDR_HALF && ours.plane[c].size() == 2 * theirs.size(),
                  "%s: plane %d is not of halves", name.c_str(), c);
        if (ours.plane[0].size() == 2 * theirs.size()) compare_pixels(name, ours, theirs);
    }
}

/* ---- Pictures that the library writes ---- */

/* 0: soft, 1: hard edges of saturated colours, 2: dark, 3: bright beyond half once filtered. */
Rgba scene(int kind, int x, int y) {
    float soft = 0.5f + 0.4f * sinf((float)x * 0.31f + (float)y * 0.17f);
    if (kind == 1) {
        static const Rgba colours[] = {Rgba(8, 0, 0), Rgba(0, 1, 0), Rgba(0, 0, 0.01f), Rgba(1, 1, 1), Rgba(0, 0, 0)};
        return colours[(x / 3 + y / 2) % 5];
    }
    float scale = kind == 2 ? 0x1p-18f : kind == 3 ? 65000 : 1;
    float green = random_unit() * scale, alpha = random_unit();
    return Rgba(soft * scale, green, (1 - soft) * scale, alpha);
}

std::string write_rgba(const Box2i &window, RgbaChannels channels, Compression compression, int kind, bool xyz,
                       LineOrder lines) {
    memory_out stream;
    int width = window.max.x - window.min.x + 1, height = window.max.y - window.min.y + 1;
    Header header(window, window, 1, Imath::V2f(0, 0), 1, lines, compression);
    if (xyz)
        addChromaticities(header, Chromaticities(Imath::V2f(0.7347f, 0.2653f), Imath::V2f(0, 1),
                                                 Imath::V2f(0.0001f, -0.077f), Imath::V2f(0.32168f, 0.33767f)));
    std::vector<Rgba> pixels;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            pixels.push_back(scene(kind, x, y));
    {
        RgbaOutputFile file(stream, header, channels);
        file.setFrameBuffer(pixels.data() - window.min.x - (ptrdiff_t)window.min.y * width, 1, (size_t)width);
        file.writePixels(height);
    }
    return stream.bytes;
}

const Compression compressions[] = {NO_COMPRESSION,  RLE_COMPRESSION,   ZIPS_COMPRESSION, ZIP_COMPRESSION,
                                    PIZ_COMPRESSION, PXR24_COMPRESSION, B44_COMPRESSION,  B44A_COMPRESSION};

Box2i window_at(int x, int y, int width, int height) {
    return Box2i(V2i(x, y), V2i(x + width - 1, y + height - 1));
}

void check_written() {
    const Box2i even[] = {window_at(0, 0, 2, 2),      window_at(-4, -6, 2, 40), window_at(6, 10, 90, 4),
                          window_at(-2, -30, 38, 66), window_at(0, 8, 70, 130), window_at(-100, 64, 16, 200)};
    const Box2i odd[] = {window_at(3, -5, 1, 1), window_at(-7, 1, 37, 65), window_at(0, 0, 2, 1)};
    const RgbaChannels grey[] = {WRITE_Y, WRITE_YA};
    for (Compression compression : compressions)
        for (int kind = 0; kind < 4; kind++) {
            char name[80];
            snprintf(name, sizeof name, "compression %d, scene %d, window ", (int)compression, kind);
            for (size_t w = 0; w < sizeof even / sizeof *even; w++) {
                LineOrder lines = (w + (size_t)kind) % 3 == 2 ? DECREASING_Y : INCREASING_Y;
                for (RgbaChannels channels : {WRITE_YC, WRITE_YCA})
                    compare(name + std::to_string(w),
                            write_rgba(even[w], channels, compression, kind, (kind + w) % 2, lines));
            }
            for (size_t w = 0; w < sizeof odd / sizeof *odd; w++)
                for (RgbaChannels channels : grey)
                    compare(name + std::to_string(w) + ", grey",
                            write_rgba(odd[w], channels, compression, kind, false, INCREASING_Y));
        }
}

/* ---- Pictures of any numbers ---- */

/* A channel to be written, by name; its values as floats. */
struct channel {
    const char *name;
    PixelType type;
    int sampling;
    std::vector<char> samples;
};

float any_value(int kind) {
    uint64_t bits = random_bits();
    if (kind == 0) { /* any half at all */
        half value;
        value.setBits((uint16_t)bits);
        return value;
    }
    if (kind == 1) return (random_unit() - 0.5f) * 4; /* of either sign */
    static const float special[] = {0, -0.0f, 65504, -65504, 0x1p-24f, 0x1.8p-24f, 1, -1, 65519, 65520, 1e30f, -1e30f};
    return special[bits % 12];
}

std::string write_channels(const Box2i &window, std::vector<channel> &channels, Compression compression, int kind,
                           int tile) {
    memory_out stream;
    Header header(window, window);
    FrameBuffer frame;
    int width = window.max.x - window.min.x + 1, height = window.max.y - window.min.y + 1;
    header.compression() = compression;
    for (channel &c : channels) {
        ptrdiff_t size = c.type == HALF ? 2 : 4, across = width / c.sampling, down = height / c.sampling;
        c.samples.resize((size_t)(size * across * down));
        for (ptrdiff_t i = 0; i < across * down; i++) {
            float value = any_value(kind);
            half rounded = value;
            memcpy(&c.samples[(size_t)(i * size)], c.type == HALF ? (void *)&rounded : (void *)&value, (size_t)size);
        }
        header.channels().insert(c.name, Channel(c.type, c.sampling, c.sampling));
        ptrdiff_t corner = window.min.x / c.sampling * size + window.min.y / c.sampling * size * across;
        frame.insert(c.name, Slice(c.type, c.samples.data() - corner, (size_t)size, (size_t)(size * across), c.sampling,
                                   c.sampling));
    }
    if (tile) {
        header.setTileDescription(TileDescription((unsigned)tile, (unsigned)tile));
        TiledOutputFile file(stream, header);
        file.setFrameBuffer(frame);
        file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
    } else {
        OutputFile file(stream, header);
        file.setFrameBuffer(frame);
        file.writePixels(height);
    }
    return stream.bytes;
}

void check_any_numbers() {
    for (Compression compression : compressions)
        for (int kind = 0; kind < 3; kind++) {
            std::vector<channel> sets[] = {
                {{"Y", HALF, 1, {}}, {"RY", HALF, 2, {}}, {"BY", HALF, 2, {}}, {"A", HALF, 1, {}}},
                {{"Y", FLOAT, 1, {}}, {"RY", FLOAT, 2, {}}, {"BY", HALF, 2, {}}},
                {{"Y", HALF, 1, {}}, {"RY", HALF, 2, {}}},
                {{"Y", HALF, 1, {}}, {"BY", FLOAT, 2, {}}, {"Z", UINT, 1, {}}, {"AO", HALF, 4, {}}}};
            for (auto &set : sets)
                for (const Box2i &window : {window_at(-8, -40, 52, 92), window_at(4, 4, 4, 4)})
                    compare("any numbers of kind " + std::to_string(kind) + ", compression " +
                                std::to_string(compression),
                            write_channels(window, set, compression, kind, 0));
        }
}

/* ---- Chroma at full resolution: RgbaInputFile refuses that; its conversion alone is what remains ---- */

float sample_at(const channel &c, size_t i) {
    half value;
    memcpy(&value, &c.samples[2 * i], 2);
    return value;
}

void check_full_chroma() {
    for (int tile = 0; tile <= 16; tile += 16)
        for (const Box2i &window : {window_at(-3, 5, 1, 1), window_at(7, -9, 35, 41)}) {
            std::vector<channel> set = {{"Y", HALF, 1, {}}, {"RY", HALF, 1, {}}, {"BY", HALF, 1, {}}};
            std::string bytes = write_channels(window, set, ZIP_COMPRESSION, 1, tile);
            std::vector<Rgba> theirs;
            for (size_t i = 0; i < set[0].samples.size() / 2; i++)
                theirs.push_back(Rgba(sample_at(set[1], i), sample_at(set[0], i), sample_at(set[2], i)));
            RgbaYca::YCAtoRGBA(RgbaYca::computeYw(Chromaticities()), (int)theirs.size(), theirs.data(), theirs.data());
            image ours;
            hdr_error error;
            CHECK(read_ours(bytes, FORWARD, ours, error) == HDR_OK, "full chroma: %s", error.message);
            if (!error.status) compare_pixels("full chroma", ours, theirs);
        }
}

/* ---- Subsampled channels besides ---- */

void check_bystanders() {
    for (Compression compression : compressions)
        for (int sampling : {2, 3, 5}) {
            std::vector<channel> set = {{"R", HALF, 1, {}},
                                        {"G", HALF, 1, {}},
                                        {"B", FLOAT, 1, {}},
                                        {"D", HALF, sampling, {}},
                                        {"Z", FLOAT, sampling, {}}};
            Box2i window = window_at(-2 * sampling, -7 * sampling, 9 * sampling, 21 * sampling);
            std::string bytes = write_channels(window, set, compression, 1, 0);
            image ours;
            hdr_error error;
            CHECK(read_ours(bytes, FORWARD, ours, error) == HDR_OK, "sampling %d beside: %s", sampling, error.message);
            if (error.status) continue;
            bool lossy = compression == B44_COMPRESSION || compression == B44A_COMPRESSION;
            bool rounded = lossy || compression == PXR24_COMPRESSION;
            CHECK(lossy || ours.plane[0] == std::vector<unsigned char>(set[0].samples.begin(), set[0].samples.end()),
                  "sampling %d beside, compression %d: R differs", sampling, compression);
            CHECK((rounded && !lossy) ||
                      ours.plane[2] == std::vector<unsigned char>(set[2].samples.begin(), set[2].samples.end()),
                  "sampling %d beside, compression %d: B differs", sampling, compression);
        }
}

/* ---- What is refused, and damage ---- */

void check_refused() {
    std::vector<channel> three = {{"Y", HALF, 1, {}}, {"RY", HALF, 3, {}}, {"BY", HALF, 3, {}}};
    std::vector<channel> unlike = {{"Y", HALF, 1, {}}, {"RY", HALF, 2, {}}, {"BY", HALF, 1, {}}};
    std::vector<channel> luminance = {{"Y", HALF, 2, {}}, {"RY", HALF, 2, {}}, {"BY", HALF, 2, {}}};
    std::vector<channel> alpha = {{"Y", HALF, 1, {}}, {"RY", HALF, 2, {}}, {"BY", HALF, 2, {}}, {"A", HALF, 2, {}}};
    for (auto *set : {&three, &unlike, &luminance, &alpha}) {
        image ours;
        hdr_error error;
        std::string bytes = write_channels(window_at(0, 0, 12, 12), *set, ZIP_COMPRESSION, 1, 0);
        CHECK(read_ours(bytes, FORWARD, ours, error) == HDR_BAD_DATA && strstr(error.message, "subsampled"),
              "a sampling that is not read: %d %s", error.status, error.message);
    }
}

void check_damage() {
    for (Compression compression : compressions) {
        std::string bytes = write_rgba(window_at(-2, 4, 10, 36), WRITE_YCA, compression, 0, true, INCREASING_Y);
        image ours;
        hdr_error error;
        for (size_t size = 0; size < bytes.size(); size++)
            CHECK(read_ours(bytes.substr(0, size), FORWARD, ours, error) == HDR_BAD_DATA,
                  "compression %d, cut to %zu bytes: %d %s", compression, size, error.status, error.message);
        for (int i = 0; i < 2000; i++) {
            std::string copy = bytes;
            for (int flips = 1 + i % 4; flips > 0; flips--)
                copy[random_bits() % copy.size()] ^= (char)(1 << (random_bits() % 8));
            /* a claim that only costs time is not what is looked for */
            hdr_status status = read_ours(copy, FORWARD, ours, error);
            CHECK(status == HDR_OK || status == HDR_BAD_DATA, "compression %d, damaged: %d %s", compression, status,
                  error.message);
        }
    }
}

void check_corpus() {
    const char *given = getenv("HDRPIPE_CORPUS");
    std::string corpus = given ? given : "../shared/corpus";
    if (access(corpus.c_str(), R_OK)) {
        CHECK_SKIP("there is no %s", corpus.c_str());
        return;
    }
    for (const char *name : {"Flowers", "Rec709_YC", "XYZ_YC"}) {
        std::ifstream file(corpus + "/storage/" + name + ".exr", std::ios::binary);
        std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
        CHECK(!bytes.empty(), "%s cannot be loaded", name);
        compare(name, bytes);
    }
}

/* ---- Luminance and alpha over a colour: three planes of one ---- */

std::string run_chain(const std::string &bytes, const std::vector<const char *> &words) {
    hdr_error error = hdr_error();
    hdr_chain *chain = hdr_chain_new(&error);
    hdr_input *input = hdr_input_memory(bytes.data(), bytes.size(), "test", &error);
    hdr_output *output = hdr_output_memory(&error);
    if (!error.status) hdr_chain_add(chain, words.data(), (int)words.size(), &error);
    if (!error.status) hdr_chain_run(chain, input, output, NULL, &error);
    CHECK(!error.status, "%s: %s", words[0], error.message);
    size_t size = 0;
    const void *data = error.status ? NULL : hdr_output_bytes(output, &size);
    std::string result((const char *)data, size);
    hdr_output_free(output);
    hdr_input_free(input);
    hdr_chain_free(chain);
    return result;
}

void check_grey_over_colour() {
    const double under[3] = {1, 0.5, 0.125};
    std::string bytes = write_rgba(window_at(-5, 3, 9, 70), WRITE_YA, ZIP_COMPRESSION, 0, false, INCREASING_Y);
    std::vector<Rgba> before = read_theirs(bytes);
    std::string over = run_chain(bytes, {"exr", "--type", "half", "--alpha", "over:1,0.5,0.125"});
    if (over.empty()) return;
    std::vector<Rgba> after = read_theirs(over);
    CHECK(before.size() == after.size(), "over a colour: another size");
    for (size_t i = 0; i < before.size() && i < after.size(); i++) {
        half found[3] = {after[i].r, after[i].g, after[i].b};
        for (int c = 0; c < 3; c++) {
            double wanted = (double)before[i].r + (1 - (double)before[i].a) * under[c];
            CHECK(found[c].bits() == hdr_half_nearest(wanted), "over a colour: %g instead of %g", (double)found[c],
                  wanted);
        }
    }
}

struct outcome {
    unsigned long passed, failed, skipped;
};

outcome check_level(bool first) {
    check_passed = check_failed = check_skipped = 0;
    check_corpus();
    check_written();
    check_any_numbers();
    check_full_chroma();
    check_bystanders();
    check_grey_over_colour();
    if (first) {
        check_refused();
        check_damage();
    }
    return {check_passed, check_failed, check_skipped};
}

} // namespace

int main() {
    for (hdr_cpu_level level : {HDR_CPU_C, HDR_CPU_AVX2, HDR_CPU_AVX512}) {
        int ends[2];
        outcome one = {0, 1, 0};
        pid_t child = pipe(ends) == 0 ? fork() : -1;
        if (child == 0) { /* the level is chosen once in a process */
            setenv("HDR_CPU", hdr_cpu_name(level), 1);
            one = outcome{0, 0, 0};
            if (hdr_cpu() == level)
                one = check_level(level == HDR_CPU_C);
            else
                one.skipped = 1;
            _exit(write(ends[1], &one, sizeof one) != sizeof one);
        }
        int status = -1;
        if (child > 0) {
            close(ends[1]);
            if (read(ends[0], &one, sizeof one) != sizeof one) one = outcome{0, 1, 0};
            waitpid(child, &status, 0);
            close(ends[0]);
        }
        check_passed += one.passed;
        check_failed += one.failed + (status != 0);
        check_skipped += one.skipped;
    }
    return check_done("test_yc");
}

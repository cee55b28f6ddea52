// Whether hdr reads EXR files as OpenEXR's C++ library does, value for value.
//
//     compare_exr HDR SCRATCH FILE...
//
// Each file is read by `HDR exr`, whose output SCRATCH.exr is uncompressed and holds every float as it is, and by the
// library. Values that are no finite number are only counted, since hdr repairs them. Luminance-chroma files are
// compared with the library's RgbaInputFile, which computes in half: 1 unit in the last place of a half is allowed.
// Prints a line for each file, and ends with status 1 if one differs, 2 if one is not read by both.
#include <ImathBox.h>
#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfRgbaFile.h>
#include <half.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace {

using floats = std::vector<float>;

struct picture {
    Imath::Box2i window;
    bool colour = false, alpha = false, chroma = false;
    floats plane[4]; // R G B A, or Y in [0]
};

bool has(const Imf::Header &header, const char *name) {
    return header.channels().findChannel(name) != nullptr;
}

// Luminance-chroma, as the library reconstructs it.
void read_chroma(const char *path, picture &read, size_t pixels) {
    Imf::RgbaInputFile file(path, 0);
    Imf::Array<Imf::Rgba> values(static_cast<long>(pixels));
    long width = read.window.max.x - read.window.min.x + 1;
    file.setFrameBuffer(&values[0] - read.window.min.x - read.window.min.y * width, 1, static_cast<size_t>(width));
    file.readPixels(read.window.min.y, read.window.max.y);
    for (int p = 0; p < 4; p++)
        read.plane[p].resize(pixels);
    for (size_t i = 0; i < pixels; i++) {
        const Imf::Rgba &value = values[static_cast<long>(i)];
        const half all[4] = {value.r, value.g, value.b, value.a};
        for (int p = 0; p < 4; p++)
            read.plane[p][i] = all[p];
    }
}

picture read_by_library(const char *path) {
    picture read;
    Imf::InputFile file(path, 0);
    const Imf::Header &header = file.header();
    read.window = header.dataWindow();
    size_t width = static_cast<size_t>(read.window.max.x - read.window.min.x + 1);
    size_t pixels = width * static_cast<size_t>(read.window.max.y - read.window.min.y + 1);
    bool chroma = has(header, "RY") || has(header, "BY");
    read.colour = chroma || has(header, "R") || has(header, "G") || has(header, "B");
    read.alpha = has(header, "A");
    read.chroma = chroma && !has(header, "R");
    if (read.chroma) {
        read_chroma(path, read, pixels);
        return read;
    }
    const char *const names[4] = {read.colour ? "R" : "Y", "G", "B", "A"};
    Imf::FrameBuffer slices;
    for (int p = 0; p < 4; p++) {
        if ((p == 3 && !read.alpha) || ((p == 1 || p == 2) && !read.colour)) continue;
        read.plane[p].resize(pixels);
        slices.insert(names[p], Imf::Slice::Make(Imf::FLOAT, read.plane[p].data(), read.window));
    }
    file.setFrameBuffer(slices);
    file.readPixels(read.window.min.y, read.window.max.y);
    return read;
}

// Steps between two halves.
int half_distance(float a, float b) {
    auto place = [](float value) {
        int bits = half(value).bits();
        return bits & 0x8000 ? -(bits & 0x7fff) : bits;
    };
    return std::abs(place(a) - place(b));
}

struct tally {
    size_t same = 0, different = 0, not_finite = 0;
};

// hdr drops an alpha of 1 everywhere: an absent plane stands for that.
tally compare(const picture &truth, const picture &ours) {
    tally sum;
    for (int p = 0; p < 4; p++)
        for (size_t i = 0; i < truth.plane[p].size(); i++) {
            float a = truth.plane[p][i], b = ours.plane[p].empty() ? 1.0f : ours.plane[p][i];
            bool close = truth.chroma ? half_distance(a, b) <= 1 : a == b;
            if (!std::isfinite(a))
                sum.not_finite++;
            else if (close)
                sum.same++;
            else if (sum.different++ == 0)
                std::printf("  first difference: plane %d, value %zu: %.9g instead of %.9g\n", p, i,
                            static_cast<double>(b), static_cast<double>(a));
        }
    return sum;
}

// Runs hdr; true if it ends with status 0.
bool convert(const char *hdr, const char *file, const std::string &to) {
    pid_t child = fork();
    if (child == 0) {
        execl(hdr, hdr, "exr", "--compression", "none", "--window", "data", "-q", "-o", to.c_str(), file,
              static_cast<char *>(nullptr));
        _exit(127);
    }
    int status = 0;
    return child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

// 0: the same; 1: different; 2: not read by both.
int compare_file(const char *hdr, const std::string &scratch, const char *path) {
    if (!convert(hdr, path, scratch)) {
        std::printf("%s: not read by hdr\n", path);
        return 2;
    }
    try {
        picture truth = read_by_library(path), ours = read_by_library(scratch.c_str());
        tally sum;
        bool fits = truth.window == ours.window && truth.colour == ours.colour;
        if (fits) sum = compare(truth, ours);
        bool same = fits && sum.different == 0 && sum.same > 0;
        std::printf("%s: %s: %zu values the same%s, %zu differ, %zu are not finite\n", path,
                    fits ? same ? "same" : "DIFFERENT" : "DIFFERENT window or channels", sum.same,
                    truth.chroma ? " within 1 ulp of half" : "", sum.different, sum.not_finite);
        return same ? 0 : 1;
    } catch (const std::exception &fault) {
        std::printf("%s: not read by the library: %s\n", path, fault.what());
        return 2;
    }
}

} // namespace

int main(int count, char **words) {
    if (count < 4) {
        std::fprintf(stderr, "usage: compare_exr HDR SCRATCH FILE...\n");
        return 64;
    }
    int worst = 0;
    std::string scratch = std::string(words[2]) + ".exr";
    for (int i = 3; i < count; i++) {
        int result = compare_file(words[1], scratch, words[i]);
        if (result != 0 && worst != 1) worst = result;
    }
    std::remove(scratch.c_str());
    if (std::fflush(stdout) != 0) return 74;
    return worst;
}

/* `ocio` against OpenColorIO itself: the same transforms put together of the library's own parts, without a
 * configuration, and applied pixel by pixel to what the file holds. */
extern "C" {
#include "check.h"
#include "hdrpipe.h"
}

#include <OpenColorIO/OpenColorIO.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

namespace OCIO = OCIO_NAMESPACE;

namespace {

/* ---- hdrpipe ---- */

const int WIDTH = 700, HEIGHT = 40; /* wider than a strip */

std::vector<float> pixels() {
    std::vector<float> values(3 * WIDTH * HEIGHT);
    unsigned state = 7;
    for (float &value : values) {
        state = state * 1664525 + 1013904223;
        double unit = state * 0x1p-32;
        value = static_cast<float>(state >> 8 & 15 ? std::pow(10.0, 9 * unit - 5) : -unit);
    }
    return values;
}

std::vector<float> by_hdrpipe(const std::vector<float> &in, std::vector<const char *> words, hdr_error *error) {
    size_t count = in.size() / 3;
    std::vector<float> plane[3], out;
    for (int p = 0; p < 3; p++)
        for (size_t i = 0; i < count; i++)
            plane[p].push_back(in[3 * i + static_cast<size_t>(p)]);
    const float *planes[3] = {plane[0].data(), plane[1].data(), plane[2].data()};
    for (const char *word : {"then", "pfm"})
        words.push_back(word);
    hdr_chain *chain = hdr_chain_new(error);
    hdr_chain_parse(chain, static_cast<int>(words.size()), words.data(), error);
    hdr_input *input = hdr_input_planes(WIDTH, HEIGHT, 3, planes, nullptr, error);
    hdr_output *output = hdr_output_memory(error);
    if (!error->status) hdr_chain_run(chain, input, output, nullptr, error);
    size_t size = 0;
    const char *bytes = error->status ? nullptr : static_cast<const char *>(hdr_output_bytes(output, &size));
    if (bytes && size > in.size() * sizeof(float)) {
        std::vector<float> lines(in.size());
        std::memcpy(lines.data(), bytes + size - in.size() * sizeof(float), in.size() * sizeof(float));
        for (int y = HEIGHT; y-- > 0;) /* PFM begins with the last row */
            out.insert(out.end(), lines.begin() + y * 3 * WIDTH, lines.begin() + (y + 1) * 3 * WIDTH);
    }
    hdr_output_free(output);
    hdr_input_free(input);
    hdr_chain_free(chain);
    return out;
}

/* ---- The library ---- */

struct part {
    const char *style; /* or NULL: the exponent with a linear part */
    bool inverse;
};

std::vector<float> by_library(const std::vector<float> &in, const std::vector<part> &parts) {
    OCIO::ConstConfigRcPtr config = OCIO::Config::CreateRaw();
    OCIO::GroupTransformRcPtr group = OCIO::GroupTransform::Create();
    for (const part &p : parts) {
        OCIO::TransformDirection direction = p.inverse ? OCIO::TRANSFORM_DIR_INVERSE : OCIO::TRANSFORM_DIR_FORWARD;
        if (p.style) {
            OCIO::BuiltinTransformRcPtr made = OCIO::BuiltinTransform::Create();
            made->setStyle(p.style);
            made->setDirection(direction);
            group->appendTransform(made);
        } else {
            OCIO::ExponentWithLinearTransformRcPtr made = OCIO::ExponentWithLinearTransform::Create();
            made->setGamma({2.4, 2.4, 2.4, 1});
            made->setOffset({0.055, 0.055, 0.055, 0});
            made->setDirection(direction);
            group->appendTransform(made);
        }
    }
    OCIO::ConstCPUProcessorRcPtr cpu = config->getProcessor(group)->getOptimizedCPUProcessor(
        OCIO::BIT_DEPTH_F32, OCIO::BIT_DEPTH_F32, OCIO::OPTIMIZATION_LOSSLESS);
    std::vector<float> out = in;
    for (size_t i = 0; i < out.size(); i += 3)
        cpu->applyRGB(&out[i]);
    return out;
}

const char AP1[] = "ACEScg_to_ACES2065-1", REC709[] = "UTILITY - ACES-AP1_to_LINEAR-REC709_BFD",
           SDR[] = "ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0",
           HDR[] = "ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - HDR-VIDEO-1000nit-15nit-REC2020lim_1.1",
           SRGB[] = "DISPLAY - CIE-XYZ-D65_to_sRGB", PQ[] = "DISPLAY - CIE-XYZ-D65_to_REC.2100-PQ",
           XYZ[] = "UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD", GAMUT[] = "ACES-LMT - ACES 1.3 Reference Gamut Compression";

void compare(const std::vector<const char *> &words, const std::vector<part> &parts) {
    std::string name;
    for (const char *word : words)
        name += std::string(word) + " ";
    hdr_error error = {};
    std::vector<float> in = pixels(), ours = by_hdrpipe(in, words, &error), theirs = by_library(in, parts);
    CHECK(!error.status && ours.size() == theirs.size(), "%s: %s", name.c_str(), error.message);
    size_t different = 0;
    double farthest = 0;
    for (size_t i = 0; i < ours.size() && ours.size() == theirs.size(); i++) {
        double distance = std::fabs(double(ours[i]) - double(theirs[i]));
        double scale = std::fmax(std::fabs(double(theirs[i])), 1e-3);
        different += ours[i] != theirs[i];
        farthest = std::fmax(farthest, distance / scale);
    }
    /* products of matrices may be rounded otherwise where they were put together in another order */
    CHECK(farthest <= 2e-6, "%s: differs by %g", name.c_str(), farthest);
    printf("%s: %zu of %zu floats differ, at most by %g\n", name.c_str(), different, ours.size(), farthest);
}

} // namespace

int main() {
    unsetenv("OCIO");
    compare({"ocio"}, {{REC709, true}, {AP1, false}, {SDR, false}, {SRGB, false}});
    compare({"ocio", "--from", "ACEScg"}, {{AP1, false}, {SDR, false}, {SRGB, false}});
    compare({"ocio", "--display", "Rec.2100-PQ - Display"}, {{REC709, true}, {AP1, false}, {HDR, false}, {PQ, false}});
    compare({"ocio", "--ocio-view", "Un-tone-mapped"}, {{REC709, true}, {AP1, false}, {XYZ, false}, {SRGB, false}});
    compare({"ocio", "--to", "ACEScg"}, {{REC709, true}});
    compare({"ocio", "--to", "ACEScct"}, {{REC709, true}, {AP1, false}, {"ACEScct_to_ACES2065-1", true}});
    compare({"ocio", "--to", "CIE-XYZ-D65"}, {{REC709, true}, {AP1, false}, {XYZ, false}});
    compare({"ocio", "--to", "sRGB - Texture"}, {{nullptr, true}});
    compare({"ocio", "--to", "ACES2065-1", "--look", "ACES 1.3 Reference Gamut Compression"},
            {{REC709, true}, {AP1, false}, {GAMUT, false}});
    return check_done("test_ocio");
}

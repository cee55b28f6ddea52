// Colour transforms by OpenColorIO.
#include "ocio.h"

#include <OpenColorIO/OpenColorIO.h>

#include <cctype>
#include <cstdio>
#include <exception>
#include <functional>
#include <mutex>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace OCIO = OCIO_NAMESPACE;

struct hdr_ocio_config {
    OCIO::ConstConfigRcPtr config;
};

struct hdr_ocio_processor {
    OCIO::ConstCPUProcessorRcPtr cpu;
};

namespace {

// const char built_in[]: the text of aces.ocio, which make turns into a string
#include "aces.ocio.h"

// ---- Faults ----

struct fault : std::runtime_error {
    fault(hdr_status status, const std::string &what) : std::runtime_error(what), status(status) {
    }
    hdr_status status;
};

// One line, of characters that can be shown.
hdr_status fill(hdr_error *err, hdr_status status, const char *what) {
    size_t used = 0;
    err->status = status;
    for (; *what && used + 1 < sizeof err->message; what++) {
        bool shown = !std::iscntrl(static_cast<unsigned char>(*what));
        if (shown || (used > 0 && err->message[used - 1] != ' ')) err->message[used++] = shown ? *what : ' ';
    }
    while (used > 0 && err->message[used - 1] == ' ')
        used--;
    err->message[used] = '\0';
    return status;
}

// No exception leaves.
template <typename Work> hdr_status guarded(hdr_error *err, Work work) noexcept {
    try {
        work();
        return HDR_OK;
    } catch (const fault &f) {
        return fill(err, f.status, f.what());
    } catch (const std::bad_alloc &) {
        return fill(err, HDR_INTERNAL, "out of memory");
    } catch (const OCIO::ExceptionMissingFile &missing) {
        return fill(err, HDR_NO_INPUT, missing.what());
    } catch (const std::exception &wrong) {
        return fill(err, HDR_BAD_DATA, wrong.what());
    } catch (...) {
        return fill(err, HDR_BAD_DATA, "OpenColorIO: an unknown fault");
    }
}

// ---- Configurations ----

// What the library would print goes nowhere: what matters comes as an exception.
void silence() {
    static std::once_flag once;
    std::call_once(once, [] { OCIO::SetLoggingFunction([](const char *) {}); });
}

hdr_status open(const char *file, const char *text, hdr_ocio_config **config, hdr_error *err) {
    *config = nullptr;
    return guarded(err, [&] {
        silence();
        std::istringstream stream(text ? text : built_in);
        OCIO::ConstConfigRcPtr made =
            file ? OCIO::Config::CreateFromFile(file) : OCIO::Config::CreateFromStream(stream);
        *config = new hdr_ocio_config{made};
    });
}

void close(hdr_ocio_config *config) {
    delete config;
}

// ---- Names ----

using telling = std::function<void(hdr_ocio_kind, const char *name, const char *of)>;

void tell_views(const OCIO::Config &config, const char *display, const telling &tell) {
    for (int i = 0; i < config.getNumViews(display); i++)
        tell(HDR_OCIO_VIEW, config.getView(display, i), display);
}

void tell_names(const OCIO::Config &config, const telling &tell) {
    for (int i = 0; i < config.getNumColorSpaces(); i++)
        tell(HDR_OCIO_SPACE, config.getColorSpaceNameByIndex(i), "");
    for (int i = 0; i < config.getNumRoles(); i++)
        tell(HDR_OCIO_ROLE, config.getRoleName(i), config.getRoleColorSpace(i));
    for (int i = 0; i < config.getNumDisplays(); i++) {
        tell(HDR_OCIO_DISPLAY, config.getDisplay(i), "");
        tell_views(config, config.getDisplay(i), tell);
    }
    for (int i = 0; i < config.getNumLooks(); i++)
        tell(HDR_OCIO_LOOK, config.getLookNameByIndex(i), "");
}

hdr_status list(const hdr_ocio_config *config,
                void (*tell)(void *context, hdr_ocio_kind kind, const char *name, const char *of), void *context,
                hdr_error *err) {
    return guarded(err, [&] {
        tell_names(*config->config,
                   [&](hdr_ocio_kind kind, const char *name, const char *of) { tell(context, kind, name, of); });
    });
}

// "'X' is none of its spaces: A, B, C", as many as a message has room for.
[[noreturn]] void refuse(const OCIO::Config &config, const char *option, hdr_ocio_kind kind, const char *of,
                         const char *name, const char *plural) {
    const size_t room = 700;
    std::string text = std::string("--") + option + ": '" + std::string(name).substr(0, 100) + "' is none of the " +
                       plural + " that the configuration has: ";
    std::string names;
    bool all = true;
    tell_names(config, [&](hdr_ocio_kind k, const char *n, const char *o) {
        if (k != kind || (of && std::string(o) != of)) return;
        all = all && names.size() + std::string(n).size() < room;
        if (all) names += (names.empty() ? "" : ", ") + std::string(n);
    });
    throw fault(HDR_USAGE, text + (names.empty() ? "none" : names) + (all ? "" : ", ... (hdr ocio --list tells all)"));
}

// ---- Transforms ----

// By its name, an alias or a role.
OCIO::ConstColorSpaceRcPtr space_named(const OCIO::Config &config, const char *option, const char *name) {
    OCIO::ConstColorSpaceRcPtr space = config.getColorSpace(name);
    if (!space) refuse(config, option, HDR_OCIO_SPACE, nullptr, name, "colour spaces");
    return space;
}

OCIO::ConstColorSpaceRcPtr source_space(const OCIO::Config &config, const char *from) {
    if (!from && !config.hasRole(OCIO::ROLE_SCENE_LINEAR))
        throw fault(HDR_USAGE, "the configuration has no role scene_linear: say with --from what the picture is in");
    if (!from && !config.getColorSpace(OCIO::ROLE_SCENE_LINEAR))
        throw fault(HDR_BAD_DATA, "the configuration's role scene_linear names a colour space that it does not have");
    return space_named(config, "from", from ? from : OCIO::ROLE_SCENE_LINEAR);
}

std::string display_named(const OCIO::Config &config, const char *display) {
    if (!display) {
        const char *first = config.getDefaultDisplay();
        if (!first || !*first) throw fault(HDR_USAGE, "the configuration has no display: say a colour space with --to");
        return first;
    }
    for (int i = 0; i < config.getNumDisplaysAll(); i++)
        if (std::string(config.getDisplayAll(i)) == display) return display;
    refuse(config, "display", HDR_OCIO_DISPLAY, nullptr, display, "displays");
}

std::string view_named(const OCIO::Config &config, const std::string &display, const char *view, const char *from) {
    if (!view) {
        const char *first = config.getDefaultView(display.c_str(), from);
        if (!first || !*first) throw fault(HDR_BAD_DATA, "the display '" + display + "' has no view");
        return first;
    }
    for (OCIO::ViewType type : {OCIO::VIEW_SHARED, OCIO::VIEW_DISPLAY_DEFINED})
        for (int i = 0; i < config.getNumViews(type, display.c_str()); i++)
            if (std::string(config.getView(type, display.c_str(), i)) == view) return view;
    refuse(config, "ocio-view", HDR_OCIO_VIEW, display.c_str(), view, ("views of '" + display + "'").c_str());
}

// A list of looks, "+A, -B | C": each of them must exist, since the library falls back in silence where none does.
void check_looks(const OCIO::Config &config, const std::string &looks) {
    size_t at = 0;
    while (at <= looks.size()) {
        size_t end = looks.find_first_of(",:|", at);
        if (end == std::string::npos) end = looks.size();
        size_t first = looks.find_first_not_of(" +-", at), last = looks.find_last_not_of(' ', end - (end > 0));
        if (first < end && last != std::string::npos && last >= first) {
            std::string name = looks.substr(first, last - first + 1);
            if (!config.getLook(name.c_str())) refuse(config, "look", HDR_OCIO_LOOK, nullptr, name.c_str(), "looks");
        }
        at = end + 1;
    }
}

// Whether 1/16, 1 and 16 times a colour stay so on their way to scene_linear: where a configuration does not tell.
// There need not be a way back, from a picture in black and white for one.
bool is_proportional(const OCIO::ConstConfigRcPtr &config, const OCIO::ConstColorSpaceRcPtr &space) try {
    if (!config->hasRole(OCIO::ROLE_SCENE_LINEAR)) return false;
    OCIO::ConstCPUProcessorRcPtr cpu =
        config->getProcessor(space->getName(), OCIO::ROLE_SCENE_LINEAR)
            ->getOptimizedCPUProcessor(OCIO::BIT_DEPTH_F32, OCIO::BIT_DEPTH_F32, OCIO::OPTIMIZATION_LOSSLESS);
    float middle[3] = {0.2f, 0.2f, 0.2f};
    cpu->applyRGB(middle);
    for (float factor : {0.0625f, 16.0f}) {
        float other[3] = {0.2f * factor, 0.2f * factor, 0.2f * factor};
        cpu->applyRGB(other);
        for (int i = 0; i < 3; i++) {
            float difference = other[i] - factor * middle[i],
                  room = 1e-3f * factor * (middle[i] < 0 ? -middle[i] : middle[i]);
            if (!(difference <= room && -difference <= room)) return false;
        }
    }
    return true;
} catch (const OCIO::Exception &) {
    return false;
}

hdr_ocio_values values_of(const OCIO::ConstConfigRcPtr &config, const OCIO::ConstColorSpaceRcPtr &space) {
    if (!space) return HDR_OCIO_ENCODED;
    std::string encoding = space->getEncoding();
    if (space->isData() || encoding == "data") return HDR_OCIO_DATA;
    bool linear =
        encoding.empty() ? is_proportional(config, space) : encoding == "scene-linear" || encoding == "display-linear";
    return linear ? HDR_OCIO_LINEAR : HDR_OCIO_ENCODED;
}

OCIO::ConstProcessorRcPtr between_spaces(const OCIO::ConstConfigRcPtr &config, const char *from, const char *to,
                                         const char *looks) {
    if (!looks) return config->getProcessor(from, to);
    OCIO::LookTransformRcPtr transform = OCIO::LookTransform::Create();
    transform->setSrc(from);
    transform->setDst(to);
    transform->setLooks(looks);
    return config->getProcessor(transform);
}

OCIO::ConstProcessorRcPtr to_display(const OCIO::ConstConfigRcPtr &config, const char *from, const char *display,
                                     const char *view, const char *looks) {
    OCIO::DisplayViewTransformRcPtr transform = OCIO::DisplayViewTransform::Create();
    transform->setSrc(from);
    transform->setDisplay(display);
    transform->setView(view);
    if (!looks) return config->getProcessor(transform);
    OCIO::LegacyViewingPipelineRcPtr pipeline = OCIO::LegacyViewingPipeline::Create();
    pipeline->setDisplayViewTransform(transform);
    pipeline->setLooksOverrideEnabled(true);
    pipeline->setLooksOverride(looks);
    return pipeline->getProcessor(config);
}

void copy_name(char (&to)[100], const std::string &name) {
    std::snprintf(to, sizeof to, "%s", name.c_str());
}

hdr_status make(const hdr_ocio_config *config, const hdr_ocio_request *request, hdr_ocio_processor **processor,
                hdr_ocio_about *about, hdr_error *err) {
    *processor = nullptr;
    *about = hdr_ocio_about();
    return guarded(err, [&] {
        const OCIO::ConstConfigRcPtr &c = config->config;
        OCIO::ConstColorSpaceRcPtr from = source_space(*c, request->from), to;
        OCIO::ConstProcessorRcPtr made;
        copy_name(about->from, from->getName());
        if (request->looks) check_looks(*c, request->looks);
        if (request->to) {
            to = space_named(*c, "to", request->to);
            copy_name(about->to, to->getName());
            made = between_spaces(c, from->getName(), to->getName(), request->looks);
        } else {
            std::string display = display_named(*c, request->display);
            std::string view = view_named(*c, display, request->view, from->getName());
            copy_name(about->display, display);
            copy_name(about->view, view);
            made = to_display(c, from->getName(), display.c_str(), view.c_str(), request->looks);
            const char *shown = c->getDisplayViewColorSpaceName(display.c_str(), view.c_str());
            to = c->getColorSpace(std::string(shown) == OCIO::OCIO_VIEW_USE_DISPLAY_NAME ? display.c_str() : shown);
        }
        about->values = values_of(c, to);
        *processor = new hdr_ocio_processor{
            made->getOptimizedCPUProcessor(OCIO::BIT_DEPTH_F32, OCIO::BIT_DEPTH_F32, OCIO::OPTIMIZATION_LOSSLESS)};
    });
}

void free_processor(hdr_ocio_processor *processor) {
    delete processor;
}

hdr_status apply(const hdr_ocio_processor *processor, float *pixels, size_t count, hdr_error *err) {
    return guarded(err, [&] {
        OCIO::PackedImageDesc image(pixels, static_cast<long>(count), 1, 4);
        processor->cpu->apply(image);
    });
}

} // namespace

const hdr_ocio_table hdr_ocio_plugin = {HDR_OCIO_INTERFACE, open, close, list, make, free_processor, apply};

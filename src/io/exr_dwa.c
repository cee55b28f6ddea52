/* Loading the plug-in for DWAA and DWAB, and handing chunks to it. */
#include "io/exr_dwa.h"

#include "io/exr_compression.h"
#include "plugin/exr_dwa.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#ifndef HDR_PLUGIN_FOLDER
#define HDR_PLUGIN_FOLDER "/usr/local/lib/hdrpipe"
#endif

#define PLUGIN "hdrpipe-exr.so"

enum { LONGEST_PATH = 4096 };

struct hdr_exr_dwa {
    void *library;
    const hdr_dwa_codec *codec;
    hdr_dwa_channel *channels;
    int channel_count;
    int lines; /* of a chunk of scan lines */
};

bool hdr_exr_needs_dwa(exr_compression_t compression) {
    if (compression != EXR_COMPRESSION_DWAA && compression != EXR_COMPRESSION_DWAB) return false;
    /* The C core got its code for DWA within 3.1; up to 3.1.12 and 3.2.3 it gives wrong values for some names of
     * channels. From 3.3 on the C++ library itself decodes by it. */
    int major = 0, minor = 0, patch = 0;
    const char *extra = NULL;
    exr_get_library_version(&major, &minor, &patch, &extra);
    return major < 3 || (major == 3 && minor < 3);
}

/* ---- Loading ---- */

/* The folder that the running program is in, with a slash at its end. False: it cannot be told. */
static bool program_folder(char folder[LONGEST_PATH]) {
    ssize_t length = readlink("/proc/self/exe", folder, LONGEST_PATH - 1);
    if (length <= 0 || length >= LONGEST_PATH - 1) return false;
    folder[length] = '\0';
    char *slash = strrchr(folder, '/');
    if (!slash) return false;
    slash[1] = '\0';
    return true;
}

/* Tries one place. complaint keeps what the loader said of a plug-in that is there but cannot be loaded. */
static void *load_from(const char *folder, const char *below, char *complaint, size_t size) {
    char path[LONGEST_PATH + 64];
    int length = snprintf(path, sizeof path, "%s%s/" PLUGIN, folder, below);
    if (length < 0 || (size_t)length >= sizeof path || access(path, F_OK) != 0) return NULL;
    /* Never taken out of memory again: the C++ libraries below it are not made for that. */
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    const char *said = library ? NULL : dlerror();
    if (said && complaint[0] == '\0') snprintf(complaint, size, "%s", said);
    return library;
}

/* Looks where a build leaves it and where it is installed, relative to the program, so that an installation may be
 * moved; then in the folder that was named when hdrpipe was built, for other programs that use the library. */
static void *load_plugin(char *complaint, size_t size) {
    char folder[LONGEST_PATH];
    void *library = NULL;
    complaint[0] = '\0';
    if (program_folder(folder)) {
        library = load_from(folder, "plugin", complaint, size);
        if (!library) library = load_from(folder, "../lib/hdrpipe", complaint, size);
    }
    return library ? library : load_from(HDR_PLUGIN_FOLDER, "", complaint, size);
}

static hdr_status find_codec(hdr_exr_dwa *dwa, const char *compression, hdr_error *err) {
    char complaint[400];
    dwa->library = load_plugin(complaint, sizeof complaint);
    if (!dwa->library && complaint[0])
        return hdr_fail(err, HDR_BAD_DATA,
                        "%s compression needs hdrpipe's plug-in " PLUGIN
                        ", which cannot be loaded (Debian package libopenexr-3-1-30): %s",
                        compression, complaint);
    if (!dwa->library)
        return hdr_fail(err, HDR_BAD_DATA,
                        "%s compression needs hdrpipe's plug-in " PLUGIN
                        ", which is not installed; it is built where the Debian packages g++ and libopenexr-dev are, "
                        "and runs with libopenexr-3-1-30",
                        compression);
    dwa->codec = dlsym(dwa->library, HDR_DWA_SYMBOL);
    if (!dwa->codec || dwa->codec->interface != HDR_DWA_INTERFACE)
        return hdr_fail(err, HDR_BAD_DATA,
                        "%s compression needs hdrpipe's plug-in " PLUGIN
                        "; the one that is installed belongs to another version of hdrpipe",
                        compression);
    return HDR_OK;
}

hdr_exr_dwa *hdr_exr_dwa_new(exr_compression_t compression, const exr_attr_chlist_t *channels, hdr_error *err) {
    bool dwaa = compression == EXR_COMPRESSION_DWAA;
    hdr_exr_dwa *dwa = hdr_alloc(1, sizeof *dwa);
    if (dwa) dwa->channels = hdr_alloc((size_t)channels->num_channels, sizeof *dwa->channels);
    if (!dwa || !dwa->channels) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        hdr_exr_dwa_free(dwa);
        return NULL;
    }
    dwa->channel_count = channels->num_channels;
    dwa->lines = hdr_exr_chunk_lines((int)compression);
    for (int c = 0; c < channels->num_channels; c++) {
        const exr_attr_chlist_entry_t *entry = &channels->entries[c];
        dwa->channels[c] = (hdr_dwa_channel){.name = entry->name.str,
                                             .type = (int32_t)entry->pixel_type,
                                             .x_sampling = entry->x_sampling,
                                             .y_sampling = entry->y_sampling};
    }
    if (find_codec(dwa, dwaa ? "DWAA" : "DWAB", err) != HDR_OK) {
        hdr_exr_dwa_free(dwa);
        return NULL;
    }
    return dwa;
}

void hdr_exr_dwa_free(hdr_exr_dwa *dwa) {
    if (!dwa) return;
    if (dwa->library) (void)dlclose(dwa->library); /* gives back a count; nothing is unloaded */
    free(dwa->channels);
    free(dwa);
}

/* ---- Chunks ---- */

static hdr_dwa_chunk form(const hdr_exr_dwa *dwa, bool tiled, int width, int height) {
    return (hdr_dwa_chunk){.channels = dwa->channels,
                           .channel_count = dwa->channel_count,
                           .lines = dwa->lines,
                           .tiled = tiled,
                           .width = width,
                           .height = height};
}

bool hdr_exr_dwa_unpack(const hdr_exr_dwa *dwa, bool tiled, int width, int height, const void *packed,
                        size_t packed_size, void *pixels, size_t size) {
    hdr_dwa_chunk chunk = form(dwa, tiled, width, height);
    hdr_dwa_message message;
    return dwa->codec->unpack(&chunk, packed, packed_size, pixels, size, &message) == HDR_DWA_OK;
}

hdr_status hdr_exr_dwa_pack(const hdr_exr_dwa *dwa, float level, int width, int height, const void *pixels, size_t size,
                            void *packed, size_t room, size_t *packed_size, hdr_error *err) {
    hdr_dwa_chunk chunk = form(dwa, false, width, height);
    hdr_dwa_message message;
    if (dwa->codec->pack(&chunk, level, pixels, size, packed, room, packed_size, &message) == HDR_DWA_OK) return HDR_OK;
    return hdr_fail(err, HDR_INTERNAL, "OpenEXR: %s", message.text);
}

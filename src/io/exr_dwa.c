/* Loading the plug-in for DWAA and DWAB, and handing chunks to it. */
#include "io/exr_dwa.h"

#include "base/plugin.h"
#include "io/exr_compression.h"
#include "plugin/exr_dwa.h"

#include <stdlib.h>

struct hdr_exr_dwa {
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

static const hdr_plugin plugin = {.file = "hdrpipe-exr.so",
                                  .symbol = HDR_DWA_SYMBOL,
                                  .interface = HDR_DWA_INTERFACE,
                                  .built_by = "g++ and libopenexr-dev",
                                  .runs_with = "libopenexr-3-1-30"};

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
    dwa->codec = hdr_plugin_load(&plugin, dwaa ? "DWAA compression" : "DWAB compression", err);
    if (dwa->codec) return dwa;
    hdr_exr_dwa_free(dwa);
    return NULL;
}

void hdr_exr_dwa_free(hdr_exr_dwa *dwa) {
    if (!dwa) return;
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

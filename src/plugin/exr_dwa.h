/* What the plug-in hdrpipe-exr.so offers: DWAA and DWAB chunks, by OpenEXR's C++ library. The C core of OpenEXR before
 * 3.3 has no such code, or code that is known to go wrong, and hdrpipe itself links no C++; so the plug-in is loaded
 * only when such a file is met.
 *
 * All calls may be made by several threads at the same time, start no thread, and let no exception out. */
#ifndef HDR_PLUGIN_EXR_DWA_H
#define HDR_PLUGIN_EXR_DWA_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Raised with every change of what follows. A plug-in of another number is not used. */
#define HDR_DWA_INTERFACE 1

typedef struct hdr_dwa_channel {
    const char *name; /* decides how it is packed: R, G, B, Y and A behind the last dot are known by it */
    int32_t type;     /* OpenEXR's numbers: 0 uint, 1 half, 2 float */
    int32_t x_sampling, y_sampling;
} hdr_dwa_channel;

/* A chunk's form. Its pixels stand line after line, in each the channels in the order given, those that are sampled
 * there; the first line and column are sampled in every channel. */
typedef struct hdr_dwa_chunk {
    const hdr_dwa_channel *channels; /* in alphabetical order, as in the file */
    int32_t channel_count;
    int32_t lines; /* what distinguishes the two: 32 DWAA, 256 DWAB */
    int32_t tiled; /* not 0: a tile, of any size; 0: scan lines, height <= lines */
    int32_t width, height;
} hdr_dwa_chunk;

typedef enum hdr_dwa_result {
    HDR_DWA_OK,
    HDR_DWA_BAD_DATA,      /* the packed bytes are damaged */
    HDR_DWA_OUT_OF_MEMORY, /* or the library says that the chunk is too large */
    HDR_DWA_REFUSED        /* the chunk's form makes no sense, or cannot be done */
} hdr_dwa_result;

/* Text for the user, ended by a NUL; empty after HDR_DWA_OK. */
typedef struct hdr_dwa_message {
    char text[200];
} hdr_dwa_message;

typedef struct hdr_dwa_codec {
    uint32_t interface; /* HDR_DWA_INTERFACE: stays the first member for ever */
    /* Fills pixels[0 ... size-1]. size is what the chunk's form comes to. */
    hdr_dwa_result (*unpack)(const hdr_dwa_chunk *chunk, const void *packed, size_t packed_size, void *pixels,
                             size_t size, hdr_dwa_message *message);
    /* Sets *packed_size, and fills packed[0 ... *packed_size-1]. *packed_size is 0, and nothing is filled in, where
     * that would take room bytes or more: the chunk is to be stored as it is, then. level is dwaCompressionLevel. */
    hdr_dwa_result (*pack)(const hdr_dwa_chunk *chunk, float level, const void *pixels, size_t size, void *packed,
                           size_t room, size_t *packed_size, hdr_dwa_message *message);
} hdr_dwa_codec;

/* The symbol that is looked up. */
#if defined(__GNUC__)
__attribute__((visibility("default")))
#endif
extern const hdr_dwa_codec hdr_dwa;
#define HDR_DWA_SYMBOL "hdr_dwa"

#ifdef __cplusplus
}
#endif

#endif

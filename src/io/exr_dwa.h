/* DWAA and DWAB for the EXR reader and writer, where OpenEXRCore does not have them: through the plug-in. */
#ifndef HDR_EXR_DWA_H
#define HDR_EXR_DWA_H

#include "base/base.h"

#include <openexr.h>

/* Whether chunks of this compression are the plug-in's matter. */
bool hdr_exr_needs_dwa(exr_compression_t compression);

/* The plug-in, and the channels that chunks have. Several threads may use one. */
typedef struct hdr_exr_dwa hdr_exr_dwa;

/* Loads the plug-in. HDR_BAD_DATA: it is not there, or cannot be used; the message says what to install, but does not
 * name the file. channels stays in use. */
hdr_exr_dwa *hdr_exr_dwa_new(exr_compression_t compression, const exr_attr_chlist_t *channels, hdr_error *err);
void hdr_exr_dwa_free(hdr_exr_dwa *dwa);

/* Fills pixels[0 ... size-1], as hdr_exr_unpack does. False: the packed bytes are damaged, or memory is out. */
bool hdr_exr_dwa_unpack(const hdr_exr_dwa *dwa, bool tiled, int width, int height, const void *packed,
                        size_t packed_size, void *pixels, size_t size);

/* Packs scan lines. *packed_size is 0 where they do not become smaller than room; they are to be stored as they are,
 * then. */
hdr_status hdr_exr_dwa_pack(const hdr_exr_dwa *dwa, float level, int width, int height, const void *pixels, size_t size,
                            void *packed, size_t room, size_t *packed_size, hdr_error *err);

#endif

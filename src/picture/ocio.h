/* Colour transforms by OpenColorIO, through the plug-in hdrpipe-ocio.so. */
#ifndef HDR_OCIO_H
#define HDR_OCIO_H

#include "base/base.h"
#include "plugin/ocio.h"

/* Where a configuration comes from: a file's name, or a text, or (both NULL) the environment's $OCIO, and where that is
 * not set the plug-in's own. */
typedef struct hdr_ocio_source {
    const char *file, *text;
} hdr_ocio_source;

/* A transform that is ready. Several threads may use one. */
typedef struct hdr_ocio {
    const hdr_ocio_table *plugin;
    hdr_ocio_processor *processor;
    hdr_ocio_about about;
    bool built_in; /* of the plug-in's own configuration */
} hdr_ocio;

/* HDR_BAD_DATA: there is no plug-in. */
hdr_status hdr_ocio_check(hdr_error *err);

/* HDR_BAD_DATA: no plug-in, or a faulty configuration; HDR_NO_INPUT: no such file, or one that it names is missing;
 * HDR_USAGE: it does not have the name, but others, which the message lists. */
hdr_ocio *hdr_ocio_new(const hdr_ocio_source *source, const hdr_ocio_request *request, hdr_error *err);
void hdr_ocio_free(hdr_ocio *ocio);

/* Maps pixels of R, G, B and A in place; they may become infinite or NaN. False: the library failed, for want of
 * memory. */
bool hdr_ocio_apply(const hdr_ocio *ocio, float *pixels, size_t count);

#endif

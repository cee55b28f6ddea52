/* A header in memory, parsed by OpenEXRCore as if it were a file's. */
#ifndef HDR_EXR_TEXT_H
#define HDR_EXR_TEXT_H

#include "base/base.h"

#include <openexr.h>

typedef struct hdr_exr_text {
    hdr_bytes bytes;     /* must stay as they are while the context is in use */
    char complaint[256]; /* what the library has to say about it first: the one that names the cause */
    bool listening;      /* while the header is parsed, by one thread; later complaints come from many */
} hdr_exr_text;

/* Parses it; exr_finish ends it. *context is NULL when that fails. text must stay where it is, too. */
exr_result_t hdr_exr_text_open(hdr_exr_text *text, exr_context_t *context);

#endif

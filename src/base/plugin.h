/* Plug-ins: shared objects that are loaded when something asks for what they have. */
#ifndef HDR_PLUGIN_H
#define HDR_PLUGIN_H

#include "base.h"

typedef struct hdr_plugin {
    const char *file;      /* "hdrpipe-exr.so" */
    const char *symbol;    /* of its table, whose first member is a uint32_t: the number of its interface */
    uint32_t interface;    /* what that has to be */
    const char *built_by;  /* Debian packages that make it: "g++ and libopenexr-dev" */
    const char *runs_with; /* and the one that it needs: "libopenexr-3-1-30" */
} hdr_plugin;

/* Its table. It stays loaded. what: who needs it, "DWAA compression". HDR_BAD_DATA: it is not there, or cannot be used;
 * the message says what to install. */
const void *hdr_plugin_load(const hdr_plugin *plugin, const char *what, hdr_error *err);

#endif

/* What the plug-in hdrpipe-ocio.so offers: colour transforms by OpenColorIO, whose interface is C++, of which hdrpipe
 * itself links nothing; so the plug-in is loaded only when a chain asks for such a transform.
 *
 * All calls may be made by several threads at the same time, start no thread, and let no exception out. Those that can
 * fail fill the error and return its status: HDR_USAGE for a name that the configuration does not have, with those that
 * it has; HDR_NO_INPUT for a file; HDR_BAD_DATA where the configuration is wrong. */
#ifndef HDR_PLUGIN_OCIO_H
#define HDR_PLUGIN_OCIO_H

#include "hdrpipe.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Raised with every change of what follows, and of what it uses of hdrpipe.h. A plug-in of another number is not used.
 */
#define HDR_OCIO_INTERFACE 2

typedef struct hdr_ocio_config hdr_ocio_config;
typedef struct hdr_ocio_processor hdr_ocio_processor;

/* A transform: from one colour space to another, or through a view to a display. NULL stands for: the role
 * scene_linear, no other space, the first display, its first view, no looks. */
typedef struct hdr_ocio_request {
    const char *from, *to;
    const char *display, *view;
    const char *looks; /* with `to`: on the way there; else instead of the view's own */
} hdr_ocio_request;

/* What comes out. */
typedef enum hdr_ocio_values {
    HDR_OCIO_ENCODED,
    HDR_OCIO_LINEAR,
    HDR_OCIO_DATA /* numbers that no transform is to touch */
} hdr_ocio_values;

typedef struct hdr_ocio_about {
    hdr_ocio_values values;
    char from[100]; /* the names that the configuration has for them */
    char to[100];   /* empty: a display */
    char display[100], view[100];
} hdr_ocio_about;

typedef struct hdr_ocio_table {
    uint32_t interface; /* HDR_OCIO_INTERFACE: stays the first member for ever */
    /* A configuration by its file's name, or by its text, or (both NULL) the one that is built in. */
    hdr_status (*open)(const char *file, const char *text, hdr_ocio_config **config, hdr_error *err);
    void (*close)(hdr_ocio_config *config);
    /* Tells all names, kind by kind, a display's views behind it. */
    hdr_status (*list)(const hdr_ocio_config *config,
                       void (*tell)(void *context, hdr_ocio_kind kind, const char *name, const char *of), void *context,
                       hdr_error *err);
    /* A processor needs its configuration no more. */
    hdr_status (*make)(const hdr_ocio_config *config, const hdr_ocio_request *request, hdr_ocio_processor **processor,
                       hdr_ocio_about *about, hdr_error *err);
    void (*free)(hdr_ocio_processor *processor);
    /* Maps count pixels R, G, B, A in place. They may become infinite or NaN. */
    hdr_status (*apply)(const hdr_ocio_processor *processor, float *pixels, size_t count, hdr_error *err);
} hdr_ocio_table;

/* The symbol that is looked up. */
#if defined(__GNUC__)
__attribute__((visibility("default")))
#endif
extern const hdr_ocio_table hdr_ocio_plugin;
#define HDR_OCIO_SYMBOL "hdr_ocio_plugin"

#ifdef __cplusplus
}
#endif

#endif

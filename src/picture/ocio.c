#include "picture/ocio.h"

#include "base/plugin.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const hdr_ocio_table *load(hdr_error *err) {
    static const hdr_plugin plugin = {.file = "hdrpipe-ocio.so",
                                      .symbol = HDR_OCIO_SYMBOL,
                                      .interface = HDR_OCIO_INTERFACE,
                                      .built_by = "g++ and libopencolorio-dev",
                                      .runs_with = "libopencolorio2.1"};
    return hdr_plugin_load(&plugin, "OpenColorIO", err);
}

hdr_status hdr_ocio_check(hdr_error *err) {
    return load(err) ? HDR_OK : HDR_BAD_DATA;
}

/* ---- Configurations ---- */

/* The library tells a file that is missing, or cannot be read, from a faulty one in words alone; and reads it twice. */
static hdr_status check_file(const char *file, const char *named_by, hdr_error *err) {
    struct stat about;
    FILE *opened = fopen(file, "r");
    bool readable = opened && (fgetc(opened) != EOF || !ferror(opened));
    int why = errno;
    bool regular = opened && fstat(fileno(opened), &about) == 0 && (S_ISREG(about.st_mode) || S_ISDIR(about.st_mode));
    if (opened) fclose(opened);
    if (!readable) return hdr_fail(err, HDR_NO_INPUT, "%s: %s: %s", named_by, file, strerror(why));
    return regular ? HDR_OK : hdr_fail(err, HDR_NO_INPUT, "%s: %s: a configuration has to be a file", named_by, file);
}

static hdr_status open_config(const hdr_ocio_table *plugin, const hdr_ocio_source *source, hdr_ocio_config **config,
                              bool *built_in, hdr_error *err) {
    const char *environment = source->file || source->text ? NULL : getenv("OCIO");
    const char *file = environment && *environment ? environment : source->file;
    const char *named_by = source->file ? "--config" : "$OCIO";
    *built_in = !file && !source->text;
    hdr_status status = file ? check_file(file, named_by, err) : HDR_OK;
    hdr_error own = {0};
    if (!status && plugin->open(file, source->text, config, &own))
        status = file ? hdr_fail(err, own.status, "%s: %s: %s", named_by, file, own.message)
                      : hdr_fail(err, own.status, "%s", own.message);
    return status;
}

/* ---- Transforms ---- */

hdr_ocio *hdr_ocio_new(const hdr_ocio_source *source, const hdr_ocio_request *request, hdr_error *err) {
    hdr_ocio *ocio = hdr_alloc(1, sizeof *ocio);
    hdr_ocio_config *config = NULL;
    hdr_error own = {0};
    if (!ocio) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        return NULL;
    }
    ocio->plugin = load(err);
    hdr_status status = ocio->plugin ? open_config(ocio->plugin, source, &config, &ocio->built_in, err) : HDR_BAD_DATA;
    if (!status && ocio->plugin->make(config, request, &ocio->processor, &ocio->about, &own))
        status = hdr_fail(err, own.status, "%s", own.message);
    if (config) ocio->plugin->close(config);
    if (!status) return ocio;
    hdr_ocio_free(ocio);
    return NULL;
}

void hdr_ocio_free(hdr_ocio *ocio) {
    if (!ocio) return;
    if (ocio->processor) ocio->plugin->free(ocio->processor);
    free(ocio);
}

bool hdr_ocio_apply(const hdr_ocio *ocio, float *pixels, size_t count) {
    hdr_error err = {0};
    return count == 0 || ocio->plugin->apply(ocio->processor, pixels, count, &err) == HDR_OK;
}

/* ---- The public list ---- */

/* A list that grows while it is told. */
typedef struct gathering {
    hdr_ocio_name *names;
    int count;
    hdr_error err;
} gathering;

static char *copy_text(const char *text) {
    char *copy = hdr_alloc(strlen(text) + 1, 1);
    return copy ? strcpy(copy, text) : NULL;
}

static void gather(void *context, hdr_ocio_kind kind, const char *name, const char *of) {
    gathering *g = context;
    if (g->err.status) return;
    hdr_ocio_name *names = hdr_grow(g->names, (size_t)g->count + 1, sizeof *names);
    if (names) g->names = names;
    if (names) names[g->count] = (hdr_ocio_name){kind, copy_text(name), copy_text(of)};
    if (names) g->count++;
    if (!names || !names[g->count - 1].name || !names[g->count - 1].of)
        hdr_fail(&g->err, HDR_INTERNAL, "out of memory");
}

hdr_ocio_names *hdr_ocio_names_new(const char *config_file, hdr_error *err) {
    hdr_ocio_names *list = hdr_alloc(1, sizeof *list);
    const hdr_ocio_table *plugin = list ? load(err) : NULL;
    hdr_ocio_config *config = NULL;
    gathering g = {0};
    if (!list) hdr_fail(err, HDR_INTERNAL, "out of memory");
    hdr_status status = plugin
                            ? open_config(plugin, &(hdr_ocio_source){.file = config_file}, &config, &(bool){false}, err)
                            : HDR_BAD_DATA;
    if (!status) status = plugin->list(config, gather, &g, &g.err);
    if (g.err.status) status = hdr_fail(err, g.err.status, "%s", g.err.message);
    if (config) plugin->close(config);
    if (list) {
        list->names = g.names;
        list->count = g.count;
    }
    if (list && !status) return list;
    hdr_ocio_names_free(list);
    return NULL;
}

void hdr_ocio_names_free(hdr_ocio_names *list) {
    if (!list) return;
    for (int i = 0; i < list->count; i++) {
        free((char *)list->names[i].name); /* its own */
        free((char *)list->names[i].of);
    }
    free((hdr_ocio_name *)list->names);
    free(list);
}

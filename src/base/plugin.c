#include "base/plugin.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#ifndef HDR_PLUGIN_FOLDER
#define HDR_PLUGIN_FOLDER "/usr/local/lib/hdrpipe"
#endif

enum { LONGEST_PATH = 4096 };

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
static void *load_from(const char *folder, const char *below, const char *file, char *complaint, size_t size) {
    char path[LONGEST_PATH + 64];
    int length = snprintf(path, sizeof path, "%s%s/%s", folder, below, file);
    if (length < 0 || (size_t)length >= sizeof path || access(path, F_OK) != 0) return NULL;
    /* Never taken out of memory again: the C++ libraries below it are not made for that. */
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    const char *said = library ? NULL : dlerror();
    if (said && complaint[0] == '\0') snprintf(complaint, size, "%s", said);
    return library;
}

/* Looks where a build leaves it and where it is installed, relative to the program, so that an installation may be
 * moved; then in the folder that was named when hdrpipe was built, for other programs that use the library. */
static void *load(const char *file, char *complaint, size_t size) {
    char folder[LONGEST_PATH];
    void *library = NULL;
    complaint[0] = '\0';
    if (program_folder(folder)) {
        library = load_from(folder, "plugin", file, complaint, size);
        if (!library) library = load_from(folder, "../lib/hdrpipe", file, complaint, size);
    }
    return library ? library : load_from(HDR_PLUGIN_FOLDER, "", file, complaint, size);
}

const void *hdr_plugin_load(const hdr_plugin *plugin, const char *what, hdr_error *err) {
    char complaint[400];
    void *library = load(plugin->file, complaint, sizeof complaint);
    const uint32_t *table = library ? dlsym(library, plugin->symbol) : NULL;
    bool usable = table && *table == plugin->interface;
    if (library) (void)dlclose(library); /* gives back a count; nothing is unloaded */
    if (usable) return table;
    if (library)
        hdr_fail(err, HDR_BAD_DATA,
                 "%s needs hdrpipe's plug-in %s; the one that is installed belongs to another version of hdrpipe", what,
                 plugin->file);
    else if (complaint[0])
        hdr_fail(err, HDR_BAD_DATA, "%s needs hdrpipe's plug-in %s, which cannot be loaded (Debian package %s): %s",
                 what, plugin->file, plugin->runs_with, complaint);
    else
        hdr_fail(err, HDR_BAD_DATA,
                 "%s needs hdrpipe's plug-in %s, which is not installed; it is built where the Debian packages %s are, "
                 "and runs with %s",
                 what, plugin->file, plugin->built_by, plugin->runs_with);
    return NULL;
}

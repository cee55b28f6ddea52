#include "verb/verb.h"

#include <string.h>
#include <strings.h>

/* The skeleton's test builds this file with a list of its own. */
#ifndef HDR_VERBS_DEF
#define HDR_VERBS_DEF "verb/verbs.def"
#endif

#define HDR_VERB(name) extern const hdr_verb hdr_verb_##name;
#include HDR_VERBS_DEF
#undef HDR_VERB

static const hdr_verb *const registry[] = {
#define HDR_VERB(name) &hdr_verb_##name,
#include HDR_VERBS_DEF
#undef HDR_VERB
    NULL};

const hdr_verb *hdr_verb_number(int index) {
    int count = (int)(sizeof registry / sizeof registry[0]) - 1;
    return index < 0 || index >= count ? NULL : registry[index];
}

const hdr_verb *hdr_verb_find(const char *name) {
    for (int i = 0; registry[i]; i++)
        if (!strcmp(registry[i]->about.name, name)) return registry[i];
    return NULL;
}

const hdr_verb_about *hdr_verb_at(int index) {
    const hdr_verb *verb = hdr_verb_number(index);
    return verb ? &verb->about : NULL;
}

const hdr_verb_about *hdr_verb_named(const char *name) {
    const hdr_verb *verb = hdr_verb_find(name);
    return verb ? &verb->about : NULL;
}

const hdr_verb *hdr_verb_of_file(const char *file_name, const char **ending) {
    const char *slash = strrchr(file_name, '/');
    *ending = strrchr(slash ? slash : file_name, '.');
    for (int i = 0; *ending && registry[i]; i++)
        if (registry[i]->format && !strcasecmp(registry[i]->format->extension, *ending)) return registry[i];
    return NULL;
}

const hdr_verb_about *hdr_format_named(const char *file_name) {
    const char *ending;
    const hdr_verb *verb = hdr_verb_of_file(file_name, &ending);
    return verb ? &verb->about : NULL;
}

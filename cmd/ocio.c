/* hdr ocio --list: what there is to choose from. */
#include "cmd.h"

#include <string.h>

/* ---- For people ---- */

static void print_text(const hdr_ocio_names *list) {
    static const char *const titles[] = {"Colour spaces:", "Roles:", "Displays, and their views:", NULL, "Looks:"};
    int kind = -1;
    for (int i = 0; i < list->count; i++) {
        const hdr_ocio_name *name = &list->names[i];
        int group = name->kind == HDR_OCIO_VIEW ? HDR_OCIO_DISPLAY : (int)name->kind;
        if (group != kind) printf("%s%s\n", kind < 0 ? "" : "\n", titles[group]);
        kind = group;
        printf(name->kind == HDR_OCIO_VIEW ? "    " : "  ");
        cmd_print_plain(stdout, name->name);
        if (name->kind == HDR_OCIO_ROLE) {
            printf(": ");
            cmd_print_plain(stdout, name->of);
        }
        putchar('\n');
    }
}

/* ---- For programs ---- */

/* The names of a kind, as an array; of a display alone where `of` is not NULL. */
static void print_json_names(const char *key, const hdr_ocio_names *list, hdr_ocio_kind kind, const char *of) {
    cmd_json_open(key, '[');
    for (int i = 0; i < list->count; i++)
        if (list->names[i].kind == kind && (!of || !strcmp(list->names[i].of, of)))
            cmd_json_text(NULL, list->names[i].name);
    cmd_json_close(']');
}

/* Roles with their colour spaces, displays with their views, as an object. */
static void print_json_pairs(const char *key, const hdr_ocio_names *list, hdr_ocio_kind kind) {
    cmd_json_open(key, '{');
    for (int i = 0; i < list->count; i++) {
        const hdr_ocio_name *name = &list->names[i];
        if (name->kind != kind) continue;
        if (kind == HDR_OCIO_ROLE)
            cmd_json_text(name->name, name->of);
        else
            print_json_names(name->name, list, HDR_OCIO_VIEW, name->name);
    }
    cmd_json_close('}');
}

static void print_json(const hdr_ocio_names *list) {
    cmd_json_open(NULL, '{');
    print_json_names("spaces", list, HDR_OCIO_SPACE, NULL);
    print_json_pairs("roles", list, HDR_OCIO_ROLE);
    print_json_pairs("displays", list, HDR_OCIO_DISPLAY);
    print_json_names("looks", list, HDR_OCIO_LOOK, NULL);
    cmd_json_end();
}

/* ---- hdr ocio --list ---- */

hdr_status cmd_ocio_list(hdr_chain *chain, int clause, hdr_error *error) {
    if (hdr_chain_settings(chain)->output)
        return cmd_refuse(error, "--list prints text, to standard output: -o is for pictures");
    if (hdr_chain_files(chain)[0])
        return cmd_refuse(error, "--list reads no picture: '%.200s' is one file too many", hdr_chain_files(chain)[0]);
    hdr_ocio_names *list = hdr_ocio_names_new(hdr_chain_given(chain, clause, "config"), error);
    if (!list) return error->status;
    if (hdr_chain_settings(chain)->json)
        print_json(list);
    else
        print_text(list);
    hdr_ocio_names_free(list);
    return HDR_OK;
}

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
static void print_json_names(const hdr_ocio_names *list, hdr_ocio_kind kind, const char *of) {
    const char *between = "";
    putchar('[');
    for (int i = 0; i < list->count; i++) {
        if (list->names[i].kind != kind || (of && strcmp(list->names[i].of, of) != 0)) continue;
        printf("%s", between);
        cmd_print_json_text(list->names[i].name);
        between = ", ";
    }
    putchar(']');
}

/* Roles with their colour spaces, displays with their views, as an object. */
static void print_json_pairs(const hdr_ocio_names *list, hdr_ocio_kind kind) {
    const char *between = "";
    putchar('{');
    for (int i = 0; i < list->count; i++) {
        const hdr_ocio_name *name = &list->names[i];
        if (name->kind != kind) continue;
        printf("%s", between);
        cmd_print_json_text(name->name);
        printf(": ");
        if (kind == HDR_OCIO_ROLE)
            cmd_print_json_text(name->of);
        else
            print_json_names(list, HDR_OCIO_VIEW, name->name);
        between = ", ";
    }
    putchar('}');
}

static void print_json(const hdr_ocio_names *list) {
    printf("{\"spaces\": ");
    print_json_names(list, HDR_OCIO_SPACE, NULL);
    printf(", \"roles\": ");
    print_json_pairs(list, HDR_OCIO_ROLE);
    printf(", \"displays\": ");
    print_json_pairs(list, HDR_OCIO_DISPLAY);
    printf(", \"looks\": ");
    print_json_names(list, HDR_OCIO_LOOK, NULL);
    printf("}\n");
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

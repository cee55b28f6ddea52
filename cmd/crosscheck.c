/* hdr crosscheck: the curves beside OpenColorIO's. */
#include "cmd.h"

enum { ROOM = 64 };

/* ---- For people ---- */

static void print_distance(const hdr_distance *distance) {
    if (distance->relative < 0)
        printf(" %8s %8s", "-", "-");
    else
        printf(" %8.1e %8.1e", distance->relative, distance->absolute);
}

static void print_line(const hdr_agreement *a) {
    printf("%-31s", a->what);
    print_distance(&a->ours);
    print_distance(&a->apart);
    printf(" %8.1e", a->codes);
    print_distance(&a->follows);
    printf("  %s", a->agrees ? "agrees" : "DIFFERS");
    if (a->reason) printf("; %s", a->reason);
    putchar('\n');
}

static void print_table(const hdr_agreement *agreements, int count) {
    printf("%-31s %17s %17s %8s %17s\n", "", "from what is", "OpenColorIO's", "in 8-bit", "OpenColorIO's");
    printf("%-31s %17s %17s %8s %17s\n", "", "published", "from ours", "codes", "from its own");
    printf("%-31s", "what");
    for (int i = 0; i < 3; i++)
        printf(" %8s %8s%s", "relative", "<0.001", i == 1 ? "         " : "");
    printf("  verdict\n");
    for (int i = 0; i < count; i++)
        print_line(&agreements[i]);
}

/* ---- For programs ---- */

static void print_json_distance(const char *key, const hdr_distance *distance) {
    if (distance->relative < 0) {
        cmd_json_text(key, NULL);
        return;
    }
    cmd_json_open(key, '{');
    cmd_json_number("relative", distance->relative);
    cmd_json_number("absolute", distance->absolute);
    cmd_json_close('}');
}

static void print_json(const hdr_agreement *a) {
    cmd_json_open(NULL, '{');
    cmd_json_text("what", a->what);
    cmd_json_text("opencolorio", a->theirs);
    cmd_json_integer("numbers", (long long)a->numbers);
    print_json_distance("from_published", &a->ours);
    print_json_distance("opencolorio_from_ours", &a->apart);
    cmd_json_number("codes", a->codes);
    print_json_distance("opencolorio_from_its_own", &a->follows);
    cmd_json_text("reason", a->reason);
    cmd_json_flag("agrees", a->agrees);
    cmd_json_end();
}

/* ---- hdr crosscheck ---- */

hdr_status cmd_crosscheck(hdr_chain *chain, hdr_error *error) {
    const hdr_settings *settings = hdr_chain_settings(chain);
    hdr_agreement agreements[ROOM];
    int count = 0;
    if (hdr_chain_clause(chain, 2)) return cmd_refuse(error, "crosscheck stands alone: there is no chain to compare");
    if (hdr_chain_files(chain)[0])
        return cmd_refuse(error, "crosscheck reads no picture: '%.200s' is one file too many",
                          hdr_chain_files(chain)[0]);
    hdr_status status =
        hdr_crosscheck(hdr_chain_given(chain, 1, "only"), settings->threads, agreements, ROOM, &count, error);
    if (status != HDR_OK) return status;
    if (!settings->json) print_table(agreements, count);
    for (int i = 0; i < count; i++) {
        if (settings->json) print_json(&agreements[i]);
        if (!agreements[i].agrees) status = HDR_DIFFERENT;
    }
    return status;
}

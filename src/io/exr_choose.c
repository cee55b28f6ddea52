/* Which part of an EXR file is read, and which of its channels.
 *
 * A channel's layer is what stands before the last point of its name. Renderers name layers in several ways, and views
 * (left and right) are kept in three: as layers of a file whose attribute multiView names the views, the first of which
 * has no prefix; as parts with an attribute view; and as parts that are merely called so. What is asked for is looked
 * for in all these ways, first to the letter, then without regard to case. */
#include "io/exr_choose.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

enum { LISTED_BYTES = 600 /* of parts and channels in a message */ };

static bool same(const char *a, const char *b, bool any_case) {
    return any_case ? strcasecmp(a, b) == 0 : strcmp(a, b) == 0;
}

size_t hdr_exr_layer_length(const char *channel) {
    const char *point = strrchr(channel, '.');
    return point ? (size_t)(point - channel) : 0;
}

/* Where the channel's own name begins: behind its layer's and the point. (That of .R is empty.) */
static const char *own_name(const char *channel) {
    size_t layer = hdr_exr_layer_length(channel);
    return channel + layer + (channel[layer] == '.');
}

static bool in_layer(const char *channel, const char *layer, bool any_case) {
    size_t length = hdr_exr_layer_length(channel);
    return strlen(layer) == length && (any_case ? strncasecmp : strncmp)(channel, layer, length) == 0;
}

static void layer_of(const char *channel, char layer[HDR_CHANNEL_NAME]) {
    snprintf(layer, HDR_CHANNEL_NAME, "%.*s", (int)hdr_exr_layer_length(channel), channel);
}

/* ---- Channels of a layer ---- */

/* The first spelling is the best; of a word any case will do. A single small letter may mean anything (b of L, a, b):
 * it is taken for a colour only where all three are there. Luminance has one spelling alone: y and x are coordinates as
 * a rule. */
enum { CAPITAL, SMALL, WORD, SPELLINGS };
static const char *const colours[4][SPELLINGS] = {
    {"R", "r", "red"}, {"G", "g", "green"}, {"B", "b", "blue"}, {"A", "a", "alpha"}};
static const char luminance_name[] = "Y";

/* The channel of the layer that is called so. */
static const char *find_name(const hdr_exr_part *part, const char *layer, const char *wanted, bool any_case) {
    for (int i = 0; i < part->channel_count; i++) {
        const char *name = part->channels[i].name;
        if (in_layer(name, layer, false) && same(own_name(name), wanted, any_case)) return name;
    }
    return NULL;
}

static bool has_small_colours(const hdr_exr_part *part, const char *layer) {
    for (int c = 0; c < 3; c++)
        if (!find_name(part, layer, colours[c][SMALL], false)) return false;
    return true;
}

/* The layer's channel of that colour, in its best spelling. */
static const char *find_colour(const hdr_exr_part *part, const char *layer, int colour) {
    for (int s = 0; s < SPELLINGS; s++) {
        if (s == SMALL && colour < 3 && !has_small_colours(part, layer)) continue;
        const char *name = find_name(part, layer, colours[colour][s], s == WORD);
        if (name) return name;
    }
    return NULL;
}

static bool is_colour(const hdr_exr_part *part, const char *channel) {
    const char *name = own_name(channel);
    char layer[HDR_CHANNEL_NAME];
    for (int c = 0; c < 3; c++)
        if (same(name, colours[c][CAPITAL], false) || same(name, colours[c][WORD], true)) return true;
    for (int c = 0; c < 3; c++)
        if (same(name, colours[c][SMALL], false)) {
            layer_of(channel, layer);
            return has_small_colours(part, layer);
        }
    return same(name, luminance_name, false);
}

static bool take_colour(const hdr_exr_part *part, const char *layer, hdr_exr_choice *choice) {
    static const char *const chroma[2] = {"RY", "BY"};
    *choice = (hdr_exr_choice){.planes = 3};
    for (int i = 0; i < 4; i++)
        choice->channel[i] = find_colour(part, layer, i);
    if (!choice->channel[0] && !choice->channel[1] && !choice->channel[2]) {
        choice->planes = 1;
        choice->channel[0] = find_name(part, layer, luminance_name, false);
        for (int i = 0; i < 2; i++)
            choice->chroma[i] = find_name(part, layer, chroma[i], false);
    }
    snprintf(choice->layer, sizeof choice->layer, "%s", layer);
    return choice->planes == 3 || choice->channel[0];
}

/* The same of the first layer with colours that is called so. */
static bool take_layer(const hdr_exr_part *part, const char *wanted, bool any_case, hdr_exr_choice *choice) {
    for (int i = 0; i < part->channel_count; i++) {
        char layer[HDR_CHANNEL_NAME];
        const char *name = part->channels[i].name;
        if (!in_layer(name, wanted, any_case) || !is_colour(part, name)) continue;
        layer_of(name, layer);
        return take_colour(part, layer, choice);
    }
    return false;
}

/* The unnamed layer, else the only one that has colours. */
static bool take_main_layer(const hdr_exr_part *part, hdr_exr_choice *choice) {
    hdr_exr_choice found = {.planes = 0};
    if (take_colour(part, "", choice)) return true;
    for (int i = 0; i < part->channel_count; i++) {
        char layer[HDR_CHANNEL_NAME];
        const char *name = part->channels[i].name;
        if (!is_colour(part, name) || (found.planes && in_layer(name, found.layer, false))) continue;
        if (found.planes) return false;
        layer_of(name, layer);
        take_colour(part, layer, &found);
    }
    *choice = found;
    return found.planes != 0;
}

/* ---- Ways to understand what is asked for ---- */

typedef bool way(const hdr_exr_part *part, const hdr_reading *reading, bool any_case, hdr_exr_choice *choice);

static bool as_unnamed(const hdr_exr_part *part, const hdr_reading *reading, bool any_case, hdr_exr_choice *choice) {
    (void)any_case;
    return reading->part ? take_main_layer(part, choice) : take_colour(part, "", choice);
}

static const char *default_view(const hdr_exr_part *part) {
    return part->view_count ? part->views[0] : "";
}

/* The default view's channels have no prefix; in a layer, its name stands between the layer's and the channel's. */
static bool as_layer(const hdr_exr_part *part, const hdr_reading *reading, bool any_case, hdr_exr_choice *choice) {
    char with_view[2 * HDR_CHANNEL_NAME];
    const char *view = default_view(part);
    if (take_layer(part, reading->layer, any_case, choice)) return true;
    if (!*view) return false;
    if (same(view, reading->layer, any_case)) return take_colour(part, "", choice);
    int length = snprintf(with_view, sizeof with_view, "%s.%s", reading->layer, view);
    return length < (int)sizeof with_view && take_layer(part, with_view, any_case, choice);
}

static bool is_view(const hdr_exr_part *part, const char *wanted, bool any_case) {
    return *part->view && same(part->view, wanted, any_case);
}

/* A view may be spread over parts, one for each layer: its picture is the part with the unnamed one. */
static bool as_view(const hdr_exr_part *part, const hdr_reading *reading, bool any_case, hdr_exr_choice *choice) {
    return is_view(part, reading->layer, any_case) && take_colour(part, "", choice);
}

/* Where no part of the view has an unnamed layer: the first that has a single one. */
static bool as_view_of_layers(const hdr_exr_part *part, const hdr_reading *reading, bool any_case,
                              hdr_exr_choice *choice) {
    return is_view(part, reading->layer, any_case) && take_main_layer(part, choice);
}

/* What is left of "diffuse.right" or "right.diffuse" where the part's view is right. */
static bool layer_in_view(const hdr_exr_part *part, const char *wanted, bool any_case, char layer[HDR_CHANNEL_NAME]) {
    size_t view = strlen(part->view), length = strlen(wanted);
    if (view == 0 || length < view + 2 || length - view - 1 >= HDR_CHANNEL_NAME) return false;
    const char *last = wanted + length - view;
    if (last[-1] == '.' && same(part->view, last, any_case)) {
        snprintf(layer, HDR_CHANNEL_NAME, "%.*s", (int)(length - view - 1), wanted);
        return true;
    }
    snprintf(layer, HDR_CHANNEL_NAME, "%s", wanted + view + 1);
    return wanted[view] == '.' && (any_case ? strncasecmp : strncmp)(part->view, wanted, view) == 0;
}

static bool as_layer_in_view(const hdr_exr_part *part, const hdr_reading *reading, bool any_case,
                             hdr_exr_choice *choice) {
    char layer[HDR_CHANNEL_NAME];
    return layer_in_view(part, reading->layer, any_case, layer) && take_layer(part, layer, any_case, choice);
}

static bool as_part(const hdr_exr_part *part, const hdr_reading *reading, bool any_case, hdr_exr_choice *choice) {
    return *part->name && same(part->name, reading->layer, any_case) && take_main_layer(part, choice);
}

/* A channel by its whole name, or by its name within the layer, view or part that is asked for. */
static bool as_channel(const hdr_exr_part *part, const hdr_reading *reading, bool any_case, hdr_exr_choice *choice) {
    const char *layer = reading->layer;
    char in_view[HDR_CHANNEL_NAME];
    bool viewed = layer && layer_in_view(part, layer, any_case, in_view);
    bool whole = !layer || is_view(part, layer, any_case) || (*part->name && same(part->name, layer, any_case)) ||
                 (*default_view(part) && same(default_view(part), layer, any_case));
    for (int i = 0; i < part->channel_count; i++) {
        const char *name = part->channels[i].name;
        bool within = layer && (in_layer(name, layer, any_case) || (viewed && in_layer(name, in_view, any_case)));
        if (!(whole && same(name, reading->channel, any_case)) &&
            !(within && same(own_name(name), reading->channel, any_case)))
            continue;
        *choice = (hdr_exr_choice){.single = true, .planes = 1, .channel = {name}};
        layer_of(name, choice->layer);
        return true;
    }
    return false;
}

/* ---- Parts ---- */

/* The range of parts that are looked at. False: there is none of that number or name. */
static bool find_part(const hdr_exr_file *file, const char *wanted, int *first, int *end) {
    *first = 0;
    *end = file->count;
    if (!wanted) return true;
    if (strspn(wanted, "0123456789") == strlen(wanted) && strlen(wanted) < 9) {
        int number = 0;
        for (const char *digit = wanted; *digit; digit++)
            number = number * 10 + (*digit - '0');
        *first = number;
        *end = number + 1;
        if (number < file->count) return true;
    }
    for (int any_case = 0; any_case < 2; any_case++)
        for (*first = 0; *first < file->count; ++*first) {
            *end = *first + 1;
            if (*file->parts[*first].name && same(file->parts[*first].name, wanted, any_case)) return true;
        }
    return false;
}

/* The first part of those that has what is wanted, in the best way. */
static bool find_choice(const hdr_exr_file *file, const hdr_reading *reading, int first, int end, bool deep,
                        hdr_exr_choice *choice) {
    static way *const by_channel[] = {as_channel, NULL}, *const by_layer[] = {as_layer,          as_view,
                                                                              as_view_of_layers, as_part,
                                                                              as_layer_in_view,  NULL},
                      *const by_default[] = {as_unnamed, NULL};
    way *const *ways = reading->channel ? by_channel : reading->layer ? by_layer : by_default;
    for (int any_case = 0; any_case < 2; any_case++)
        for (int w = 0; ways[w]; w++)
            for (int i = first; i < end; i++)
                if (file->parts[i].deep == deep && ways[w](&file->parts[i], reading, any_case, choice)) {
                    choice->part = i;
                    return true;
                }
    return false;
}

/* ---- Refusals ---- */

static void append(char *text, size_t size, const char *what, const char *name) {
    size_t length = strlen(text);
    snprintf(text + length, size - length, "%s%s", what, name);
}

/* What there is to choose from: "part 0 "beauty" (view left): A, B, G, R; part 1: Z". */
static void list_parts(const hdr_exr_file *file, int first, int end, char text[LISTED_BYTES]) {
    text[0] = '\0';
    for (int i = first; i < end; i++) {
        const hdr_exr_part *part = &file->parts[i];
        char about[64];
        if (file->multi_part) {
            snprintf(about, sizeof about, "%spart %d", i > first ? "; " : "", i);
            append(text, LISTED_BYTES, about, "");
            if (*part->name) append(text, LISTED_BYTES, " ", part->name);
            if (*part->view) append(text, LISTED_BYTES, ", view ", part->view);
            append(text, LISTED_BYTES, part->deep ? ", deep: " : ": ", "");
        }
        for (int c = 0; c < part->channel_count; c++)
            append(text, LISTED_BYTES, c ? ", " : "", part->channels[c].name);
    }
    if (strlen(text) >= LISTED_BYTES - 1) memcpy(text + LISTED_BYTES - 5, " ...", 5);
    hdr_exr_make_plain(text);
}

static hdr_status refuse(const hdr_exr_file *file, const char *name, const hdr_reading *reading, int first, int end,
                         hdr_error *err) {
    char listed[LISTED_BYTES], layer[100] = "", channel[100] = "";
    if (reading->layer) snprintf(layer, sizeof layer, "%s", reading->layer);
    if (reading->channel) snprintf(channel, sizeof channel, "%s", reading->channel);
    hdr_exr_make_plain(layer);
    hdr_exr_make_plain(channel);
    list_parts(file, first, end, listed);
    const char *what = *listed ? listed : "none";
    if (*channel && *layer)
        return hdr_fail(err, HDR_BAD_DATA, "%s: no channel %s in a layer or view %s; it has: %s", name, channel, layer,
                        what);
    if (*channel) return hdr_fail(err, HDR_BAD_DATA, "%s: no channel %s; it has: %s", name, channel, what);
    if (*layer)
        return hdr_fail(err, HDR_BAD_DATA, "%s: no layer or view %s that has R, G, B or Y; it has: %s", name, layer,
                        what);
    return hdr_fail(err, HDR_BAD_DATA,
                    "%s: it has none of the channels R, G, B and Y (--layer or --channel chooses others); it has: %s",
                    name, what);
}

static hdr_status refuse_part(const hdr_exr_file *file, const char *name, const char *wanted, hdr_error *err) {
    char part[100], listed[LISTED_BYTES];
    snprintf(part, sizeof part, "%s", wanted);
    hdr_exr_make_plain(part);
    if (!file->multi_part)
        return hdr_fail(err, HDR_BAD_DATA, "%s: no part %s: it is a file of one part, 0", name, part);
    list_parts(file, 0, file->count, listed);
    return hdr_fail(err, HDR_BAD_DATA, "%s: no part %s; it has: %s", name, part, listed);
}

static hdr_status refuse_deep(const hdr_exr_file *file, const char *name, int part, hdr_error *err) {
    static const char reason[] =
        "deep data (several samples at different depths in a pixel) is not read; flatten it first";
    if (!file->multi_part) return hdr_fail(err, HDR_BAD_DATA, "%s: %s", name, reason);
    return hdr_fail(err, HDR_BAD_DATA, "%s: part %d: %s, or choose another with --part", name, part, reason);
}

hdr_status hdr_exr_choose(const hdr_exr_file *file, const char *name, const hdr_reading *reading,
                          hdr_exr_choice *choice, hdr_error *err) {
    int first, end;
    *choice = (hdr_exr_choice){.planes = 0};
    if (!find_part(file, reading->part, &first, &end)) return refuse_part(file, name, reading->part, err);
    if (find_choice(file, reading, first, end, false, choice)) return HDR_OK;
    if (find_choice(file, reading, first, end, true, choice)) return refuse_deep(file, name, choice->part, err);
    if (end - first == 1 && file->parts[first].deep) return refuse_deep(file, name, first, err);
    return refuse(file, name, reading, first, end, err);
}

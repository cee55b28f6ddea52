/* What hdr info says of all that a file holds, part by part. */
#include "cmd.h"

#include <stdlib.h>
#include <string.h>

/* ---- Text ---- */

/* The channels of one layer, which begins with the first of them. */
static void print_layer(const hdr_part *part, int first) {
    const char *layer = part->channels[first].layer, *between = "";
    size_t own_name = *layer ? strlen(layer) + 1 : 0;
    char label[300];
    snprintf(label, sizeof label, "%s%s", *layer ? "layer " : "channels", layer);
    printf("    ");
    cmd_print_plain(stdout, label);
    printf("%*s ", strlen(label) < 16 ? (int)(16 - strlen(label)) : 0, "");
    for (int i = first; i < part->channel_count; i++) {
        const hdr_listed_channel *channel = &part->channels[i];
        if (strcmp(channel->layer, layer) != 0) continue;
        printf("%s", between);
        cmd_print_plain(stdout, channel->name + own_name);
        printf(" %s", cmd_type_name(channel->type));
        if (channel->x_sampling != 1 || channel->y_sampling != 1)
            printf(" (1 of %d x %d)", channel->x_sampling, channel->y_sampling);
        between = ", ";
    }
    putchar('\n');
}

static void print_layers(const hdr_part *part) {
    for (int i = 0; i < part->channel_count; i++) {
        bool seen = false;
        for (int earlier = 0; !seen && earlier < i; earlier++)
            seen = !strcmp(part->channels[earlier].layer, part->channels[i].layer);
        if (!seen) print_layer(part, i);
    }
}

static void print_part(const hdr_part *part) {
    printf("  part %d", part->number);
    if (*part->name) printf(" "), cmd_print_plain(stdout, part->name);
    if (*part->view) printf(", view "), cmd_print_plain(stdout, part->view);
    printf(": %s, %s\n", part->storage, part->compression);
    printf("    ");
    cmd_print_window("data window", &part->data, 16);
    printf("    ");
    cmd_print_window("display window", &part->display, 16);
    if (part->tile_width) {
        printf("    %-16s %d x %d", "tiles", part->tile_width, part->tile_height);
        if (part->level_count > 1) printf(", %s of %d levels", part->levels, part->level_count);
        putchar('\n');
    }
    for (int i = 0; i < part->view_count; i++) {
        if (i == 0) printf("    %-16s ", "views");
        cmd_print_plain(stdout, part->views[i]);
        printf("%s", i + 1 < part->view_count ? ", " : "\n");
    }
    print_layers(part);
    for (int i = 0; i < part->attribute_count; i++) {
        const hdr_attribute *attribute = &part->attributes[i];
        printf("    %-16s ", i ? "" : "attributes");
        cmd_print_plain(stdout, attribute->name);
        printf(" (");
        cmd_print_plain(stdout, attribute->type);
        printf(")");
        if (attribute->value) printf(" "), cmd_print_plain(stdout, attribute->value);
        putchar('\n');
    }
}

void cmd_print_contents(const hdr_contents *contents) {
    for (int i = 0; i < contents->part_count; i++)
        print_part(&contents->parts[i]);
}

/* ---- JSON ---- */

static void print_member(const char *key, const char *text) {
    printf(", \"%s\": ", key);
    cmd_print_json_text(text);
}

static void print_json_channels(const hdr_part *part) {
    printf(", \"channels\": [");
    for (int i = 0; i < part->channel_count; i++) {
        const hdr_listed_channel *channel = &part->channels[i];
        printf("%s{\"name\": ", i ? ", " : "");
        cmd_print_json_text(channel->name);
        print_member("layer", channel->layer);
        print_member("type", cmd_type_name(channel->type));
        printf(", \"sampling\": [%d, %d]}", channel->x_sampling, channel->y_sampling);
    }
    putchar(']');
}

/* A number as such, several as they stand in the text. */
static void print_json_value(const hdr_attribute *attribute) {
    bool number = !strcmp(attribute->type, "int") || !strcmp(attribute->type, "float") || //
                  !strcmp(attribute->type, "double");
    if (!attribute->value)
        printf("null");
    else if (number)
        cmd_print_json_number(strtod(attribute->value, NULL));
    else
        cmd_print_json_text(attribute->value);
}

static void print_json_part(const hdr_part *part) {
    printf("{\"part\": %d", part->number);
    print_member("name", part->name);
    print_member("view", part->view);
    print_member("storage", part->storage);
    print_member("compression", part->compression);
    cmd_print_json_window("data_window", &part->data);
    cmd_print_json_window("display_window", &part->display);
    if (part->tile_width)
        printf(", \"tiles\": [%d, %d]", part->tile_width, part->tile_height);
    else
        printf(", \"tiles\": null");
    print_member("levels", part->levels);
    printf(", \"level_count\": %d, \"views\": [", part->level_count);
    for (int i = 0; i < part->view_count; i++) {
        printf("%s", i ? ", " : "");
        cmd_print_json_text(part->views[i]);
    }
    putchar(']');
    print_json_channels(part);
    printf(", \"attributes\": [");
    for (int i = 0; i < part->attribute_count; i++) {
        printf("%s{\"name\": ", i ? ", " : "");
        cmd_print_json_text(part->attributes[i].name);
        print_member("type", part->attributes[i].type);
        printf(", \"value\": ");
        print_json_value(&part->attributes[i]);
        putchar('}');
    }
    printf("]}");
}

void cmd_print_contents_json(const hdr_contents *contents) {
    printf("\"parts\": [");
    for (int i = 0; i < contents->part_count; i++) {
        printf("%s", i ? ", " : "");
        print_json_part(&contents->parts[i]);
    }
    putchar(']');
}

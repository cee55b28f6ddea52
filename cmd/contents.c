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

static void print_json_channels(const hdr_part *part) {
    cmd_json_open("channels", '[');
    for (int i = 0; i < part->channel_count; i++) {
        const hdr_listed_channel *channel = &part->channels[i];
        cmd_json_open(NULL, '{');
        cmd_json_text("name", channel->name);
        cmd_json_text("layer", channel->layer);
        cmd_json_text("type", cmd_type_name(channel->type));
        cmd_json_integers("sampling", 2, (const int[]){channel->x_sampling, channel->y_sampling});
        cmd_json_close('}');
    }
    cmd_json_close(']');
}

/* A number as such, several as they stand in the text. */
static void print_json_attribute(const hdr_attribute *attribute) {
    bool number = !strcmp(attribute->type, "int") || !strcmp(attribute->type, "float") || //
                  !strcmp(attribute->type, "double");
    cmd_json_open(NULL, '{');
    cmd_json_text("name", attribute->name);
    cmd_json_text("type", attribute->type);
    if (attribute->value && number)
        cmd_json_number("value", strtod(attribute->value, NULL));
    else
        cmd_json_text("value", attribute->value);
    cmd_json_close('}');
}

static void print_json_part(const hdr_part *part) {
    cmd_json_open(NULL, '{');
    cmd_json_integer("part", part->number);
    cmd_json_text("name", part->name);
    cmd_json_text("view", part->view);
    cmd_json_text("storage", part->storage);
    cmd_json_text("compression", part->compression);
    cmd_json_window("data_window", &part->data);
    cmd_json_window("display_window", &part->display);
    if (part->tile_width)
        cmd_json_integers("tiles", 2, (const int[]){part->tile_width, part->tile_height});
    else
        cmd_json_text("tiles", NULL);
    cmd_json_text("levels", part->levels);
    cmd_json_integer("level_count", part->level_count);
    cmd_json_open("views", '[');
    for (int i = 0; i < part->view_count; i++)
        cmd_json_text(NULL, part->views[i]);
    cmd_json_close(']');
    print_json_channels(part);
    cmd_json_open("attributes", '[');
    for (int i = 0; i < part->attribute_count; i++)
        print_json_attribute(&part->attributes[i]);
    cmd_json_close(']');
    cmd_json_close('}');
}

void cmd_json_contents(const hdr_contents *contents) {
    cmd_json_open("parts", '[');
    for (int i = 0; i < contents->part_count; i++)
        print_json_part(&contents->parts[i]);
    cmd_json_close(']');
}

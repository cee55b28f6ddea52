/* hdr info: what a picture file holds, from its header alone. And what info and stats have in common: going through
 * files, and printing pictures. */
#include "cmd.h"

/* ---- Several files ---- */

static hdr_status do_file(hdr_chain *chain, cmd_file_job job, const char *file, hdr_error *error) {
    hdr_input *input = hdr_input_open(file, error);
    hdr_status status = input ? job(chain, input, file ? file : "-", error) : error->status;
    hdr_input_free(input);
    return status;
}

/* All files are one picture. */
static hdr_status do_joined(hdr_chain *chain, cmd_file_job job, hdr_error *error) {
    cmd_input opened = cmd_open_input(chain, error);
    hdr_status status = opened.input ? job(chain, opened.input, hdr_input_name(opened.input), error) : error->status;
    cmd_close_input(&opened);
    return status;
}

hdr_status cmd_each_file(hdr_chain *chain, cmd_file_job job, hdr_error *error) {
    const char *const *files = hdr_chain_files(chain);
    if (hdr_chain_joins(chain)) return do_joined(chain, job, error);
    if (!files[0] || !files[1]) return do_file(chain, job, files[0], error);
    hdr_status status = HDR_OK;
    for (int i = 0; files[i]; i++) {
        hdr_error fault = {0};
        if (do_file(chain, job, files[i], &fault) == HDR_OK) continue;
        cmd_report(&fault);
        status = HDR_DIFFERENT;
    }
    return status;
}

/* ---- Pictures ---- */

const char *cmd_plane_name(const hdr_picture *picture, int plane) {
    static const char *const names[] = {"R", "G", "B", "A"};
    return picture->planes == 1 && plane == 0 ? "Y" : names[plane];
}

/* Whether the picture has that plane; a colour plane that the file lacks is one of zeros. */
static bool has_plane(const hdr_picture *picture, int plane) {
    return plane == 3 ? picture->has_alpha : plane < picture->planes;
}

const char *cmd_type_name(hdr_type type) {
    return type == HDR_HALF ? "half" : type == HDR_FLOAT ? "float" : "uint";
}

static long long width_of(const hdr_window *window) {
    return window->max_x < window->min_x ? 0 : (long long)window->max_x - window->min_x + 1;
}

static long long height_of(const hdr_window *window) {
    return window->max_y < window->min_y ? 0 : (long long)window->max_y - window->min_y + 1;
}

void cmd_print_window(const char *label, const hdr_window *window, int width) {
    printf("%-*s %lld x %lld at %d,%d\n", width, label, width_of(window), height_of(window), window->min_x,
           window->min_y);
}

/* Which of the pictures that a file may hold it is, as far as it is not the first, nameless and at full size. */
static void print_place(const hdr_picture *picture) {
    if (picture->part || *picture->part_name) {
        printf("  %-18s %d%s", "part", picture->part, *picture->part_name ? " " : "");
        cmd_print_plain(stdout, picture->part_name);
        putchar('\n');
    }
    if (*picture->layer) {
        printf("  %-18s ", "layer");
        cmd_print_plain(stdout, picture->layer);
        putchar('\n');
    }
    if (picture->level) printf("  %-18s %d\n", "level", picture->level);
}

static void print_channels(const hdr_picture *picture) {
    const char *between = "";
    printf("  %-18s ", "channels");
    for (int plane = 0; plane < 4; plane++) {
        const hdr_channel *channel = &picture->channels[plane];
        if (!has_plane(picture, plane)) continue;
        printf("%s", between);
        cmd_print_plain(stdout, picture->present[plane] ? channel->name : cmd_plane_name(picture, plane));
        printf(" %s", picture->present[plane] ? cmd_type_name(channel->type) : "missing");
        between = ", ";
    }
    putchar('\n');
}

static void print_chromaticities(const hdr_picture *picture) {
    const hdr_chromaticities *c = &picture->chromaticities;
    printf("  %-18s red %.5g,%.5g  green %.5g,%.5g  blue %.5g,%.5g  white %.5g,%.5g%s\n", "chromaticities", c->red[0],
           c->red[1], c->green[0], c->green[1], c->blue[0], c->blue[1], c->white[0], c->white[1],
           picture->has_chromaticities ? "" : "  (assumed)");
    if (picture->has_neutral) printf("  %-18s %.5g,%.5g\n", "neutral", picture->neutral[0], picture->neutral[1]);
}

void cmd_print_picture(const hdr_picture *picture) {
    printf("  %-18s %s, %s, %s\n", "format", picture->format, picture->storage, picture->compression);
    print_place(picture);
    cmd_print_window("  data window", &picture->data, 20);
    cmd_print_window("  display window", &picture->display, 20);
    print_channels(picture);
    print_chromaticities(picture);
    if (picture->pixel_aspect != 1) printf("  %-18s %.9g\n", "pixel aspect", (double)picture->pixel_aspect);
    printf("  %-18s %s\n", "state", picture->state);
}

static void print_json_channels(const hdr_picture *picture) {
    cmd_json_open("channels", '[');
    for (int plane = 0; plane < 4; plane++) {
        if (!has_plane(picture, plane) || !picture->present[plane]) continue;
        cmd_json_open(NULL, '{');
        cmd_json_text("name", picture->channels[plane].name);
        cmd_json_text("type", cmd_type_name(picture->channels[plane].type));
        cmd_json_close('}');
    }
    cmd_json_close(']');
}

static void print_json_pair(const char *key, const double pair[2]) {
    cmd_json_open(key, '[');
    cmd_json_number(NULL, pair[0]);
    cmd_json_number(NULL, pair[1]);
    cmd_json_close(']');
}

static void print_json_chromaticities(const hdr_picture *picture) {
    const hdr_chromaticities *c = &picture->chromaticities;
    cmd_json_open("chromaticities", '{');
    print_json_pair("red", c->red);
    print_json_pair("green", c->green);
    print_json_pair("blue", c->blue);
    print_json_pair("white", c->white);
    cmd_json_flag("assumed", !picture->has_chromaticities);
    cmd_json_close('}');
    if (picture->has_neutral)
        print_json_pair("neutral", picture->neutral);
    else
        cmd_json_text("neutral", NULL);
}

void cmd_json_picture(const hdr_picture *picture) {
    cmd_json_integer("width", width_of(&picture->data));
    cmd_json_integer("height", height_of(&picture->data));
    cmd_json_window("data_window", &picture->data);
    cmd_json_window("display_window", &picture->display);
    cmd_json_text("format", picture->format);
    cmd_json_text("storage", picture->storage);
    cmd_json_text("compression", picture->compression);
    print_json_channels(picture);
    cmd_json_flag("alpha", picture->has_alpha);
    print_json_chromaticities(picture);
    cmd_json_number("pixel_aspect", (double)picture->pixel_aspect);
    cmd_json_text("state", picture->state);
    cmd_json_integer("part", picture->part);
    cmd_json_text("part_name", picture->part_name);
    cmd_json_text("layer", picture->layer);
    cmd_json_integer("level", picture->level);
}

/* ---- hdr info ---- */

static void print_all(const char *name, bool json, const hdr_picture *picture, const hdr_contents *contents) {
    if (!json) {
        cmd_print_plain(stdout, name);
        putchar('\n');
        if (picture) cmd_print_picture(picture);
        cmd_print_contents(contents);
        return;
    }
    cmd_json_open(NULL, '{');
    cmd_json_text("file", name);
    if (picture) cmd_json_picture(picture);
    cmd_json_contents(contents);
    cmd_json_end();
}

/* The picture that would be read, and all there is. A file of which nothing can be read, such as deep data, is listed
 * all the same, so that what can be asked for is seen; the fault says why. */
static hdr_status print_info(hdr_chain *chain, hdr_input *input, const char *name, hdr_error *error) {
    hdr_picture picture;
    hdr_error fault = {0};
    hdr_status status = hdr_input_picture(input, chain, &picture, &fault);
    bool readable = status == HDR_OK;
    hdr_contents *contents = readable || status == HDR_BAD_DATA ? hdr_input_contents(input, &fault) : NULL;
    if (contents) print_all(name, hdr_chain_settings(chain)->json, readable ? &picture : NULL, contents);
    hdr_contents_free(contents);
    *error = fault;
    return fault.status;
}

hdr_status cmd_info(hdr_chain *chain, hdr_error *error) {
    if (hdr_chain_joins(chain))
        return cmd_refuse(error, "info tells what files hold: write what %s makes first",
                          hdr_chain_clause(chain, 1)->name);
    return cmd_each_file(chain, print_info, error);
}

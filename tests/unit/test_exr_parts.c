/* Files of several parts, layers, views and levels, with whole-number channels, written by OpenEXRCore: each selection
 * gives the bits that were written, whatever is damaged ends as bad data, and a rectangle is the same as a piece of the
 * whole. */
#include "check.h"
#include "io/source.h"
#include "parts_make.h"

#include <unistd.h>

enum { NAME_BYTES = 200 };

#define MEMORY ((uint64_t)64 << 20)

/* ---- Reading ---- */

struct image {
    hdr_picture about;
    size_t width, height;
    unsigned char *plane[4];
};

static void free_image(struct image *image) {
    for (int p = 0; p < 4; p++)
        free(image->plane[p]);
}

/* Reads all blocks; the image may be NULL: then nothing is kept. Sizes are the caller's affair then. */
static void read_blocks(hdr_source *source, struct image *image, hdr_error *error) {
    void *worker = NULL;
    if (source->worker_new(source, &worker, error) != HDR_OK) return;
    int row = 0;
    for (int i = 0; i < source->blocks; i++) {
        hdr_block block;
        if (source->read(source, worker, i, &block, error) != HDR_OK) break;
        CHECK(block.first_row == row && row == hdr_source_first_row(source, i) && block.rows > 0 &&
                  block.rows <= source->block_rows && hdr_source_block_of(source, row) == i &&
                  hdr_source_block_of(source, row + block.rows - 1) == i,
              "block %d is not where it was promised", i);
        row += block.rows;
        for (int p = 0; image && p < 4; p++) {
            if (!block.plane[p]) continue;
            size_t size = hdr_type_size(block.type[p]), tight = size * image->width;
            CHECK((uintptr_t)block.plane[p] % size == 0 && block.stride[p] % size == 0, "a plane is not aligned");
            for (int r = 0; r < block.rows; r++)
                memcpy(image->plane[p] + (size_t)(block.first_row + r) * tight,
                       block.plane[p] + (size_t)r * block.stride[p], tight);
        }
    }
    CHECK(error->status || row == hdr_window_height(&source->picture.data), "rows are missing");
    source->worker_free(source, worker);
}

static hdr_status read_file(const file_bytes *bytes, hdr_reading reading, struct image *image, hdr_error *error) {
    *error = (hdr_error){.status = HDR_OK};
    reading.memory = MEMORY;
    hdr_input *input = hdr_input_memory(bytes->data, bytes->size, "made", error);
    hdr_source *source = hdr_source_open(input, &reading, error);
    if (image) *image = (struct image){.width = 0};
    if (source && image) {
        image->about = source->picture;
        image->width = (size_t)hdr_window_width(&source->picture.data);
        image->height = (size_t)hdr_window_height(&source->picture.data);
        for (int p = 0; p < 4; p++)
            if (source->picture.present[p]) {
                image->plane[p] = calloc(image->height * image->width + 1, 4);
                if (!image->plane[p]) abort();
            }
    }
    if (source) read_blocks(source, image, error);
    hdr_source_close(source);
    hdr_input_free(input);
    return error->status;
}

/* Compares what a reading gives with the channels that were written, and tells which those are. */
static void expect(const struct made_file *file, const char *name, hdr_reading reading, int part,
                   const char *const names[4]) {
    struct image image;
    hdr_error error;
    CHECK(read_file(&file->bytes, reading, &image, &error) == HDR_OK, "%s: %s", name, error.message);
    const struct made_part *made = &file->part[part];
    CHECK(error.status || image.about.part == part, "%s: part %d instead of %d", name, image.about.part, part);
    int level = image.about.level;
    if (error.status == HDR_OK)
        CHECK(image.width == (size_t)level_side(made, made->width, level) &&
                  image.height == (size_t)level_side(made, made->height, level) &&
                  image.about.data.min_x == made->min_x && image.about.data.min_y == made->min_y,
              "%s: %zu x %zu at level %d", name, image.width, image.height, level);
    for (int p = 0; p < 4 && error.status == HDR_OK; p++) {
        CHECK(!names[p] == !image.plane[p], "%s: plane %d", name, p);
        if (!names[p] || !image.plane[p]) continue;
        CHECK(strcmp(image.about.channels[p].name, names[p]) == 0, "%s: %s instead of %s", name,
              image.about.channels[p].name, names[p]);
        for (int c = 0; made->channel[c].name; c++)
            if (strcmp(made->channel[c].name, names[p]) == 0)
                CHECK(memcmp(image.plane[p], made->channel[c].pixels[level],
                             image.width * image.height * sample_size(made->channel[c].type)) == 0,
                      "%s: channel %s is not what was written", name, names[p]);
    }
    free_image(&image);
}

static void refuse(const struct made_file *file, hdr_reading reading, const char *words) {
    hdr_error error;
    CHECK(read_file(&file->bytes, reading, NULL, &error) == HDR_BAD_DATA && strstr(error.message, words),
          "'%s' was expected: %d %s", words, error.status, error.message);
    CHECK(strncmp(error.message, "made: ", 6) == 0 && !strchr(error.message, '\n'), "the message: %s", error.message);
}

/* ---- Parts and layers ---- */

#define HALF(channel)                                                                                                  \
    {                                                                                                                  \
        channel, EXR_PIXEL_HALF, {                                                                                     \
            NULL                                                                                                       \
        }                                                                                                              \
    }
#define FLOAT(channel)                                                                                                 \
    {                                                                                                                  \
        channel, EXR_PIXEL_FLOAT, {                                                                                    \
            NULL                                                                                                       \
        }                                                                                                              \
    }
#define UINT(channel)                                                                                                  \
    {                                                                                                                  \
        channel, EXR_PIXEL_UINT, {                                                                                     \
            NULL                                                                                                       \
        }                                                                                                              \
    }
#define NAMES(...) ((const char *const[4]){__VA_ARGS__})

/* Small, so that every byte can be damaged. */
static const struct made_file several = {
    .part = {{.name = "beauty",
              .view = "left",
              .width = 7,
              .height = 19,
              .min_x = -2,
              .min_y = 5,
              .compression = EXR_COMPRESSION_ZIP,
              .channel = {HALF("A"), HALF("B"), HALF("G"), FLOAT("R")}},
             {.name = "depth",
              .view = "left",
              .width = 5,
              .height = 6,
              .compression = EXR_COMPRESSION_NONE,
              .channel = {FLOAT("Z")}},
             {.name = "7",
              .view = "right",
              .width = 9,
              .height = 4,
              .tile = 4,
              .mode = EXR_TILE_ONE_LEVEL,
              .compression = EXR_COMPRESSION_ZIPS,
              .channel = {HALF("B"), HALF("G"), HALF("R")}},
             {.name = "ids",
              .width = 6,
              .height = 3,
              .compression = EXR_COMPRESSION_RLE,
              .channel = {UINT("id"), HALF("id.A"), HALF("only.Y")}},
             {.name = "passes",
              .width = 6,
              .height = 33,
              .compression = EXR_COMPRESSION_PIZ,
              .channel = {HALF("Diffuse.b"), HALF("Diffuse.g"), HALF("Diffuse.r"), HALF("diffuse.R"),
                          HALF("forward.left.G"), HALF("gloss.alpha"), HALF("gloss.blue"), HALF("gloss.green"),
                          HALF("gloss.red"), HALF("n.x"), HALF("n.y")}},
             {.name = "pyramid",
              .width = 13,
              .height = 6,
              .tile = 4,
              .mode = EXR_TILE_MIPMAP_LEVELS,
              .compression = EXR_COMPRESSION_ZIP,
              .channel = {HALF("Y")}}}};

static void check_parts(void) {
    struct made_file file = several;
    if (!make_file(&file)) return;
    const char *const *rgba = NAMES("R", "G", "B", "A"), *const *rgb = NAMES("R", "G", "B");
    expect(&file, "the first", (hdr_reading){.memory = 0}, 0, rgba);
    expect(&file, "by number", (hdr_reading){.part = "2"}, 2, rgb);
    expect(&file, "by a name that is a number", (hdr_reading){.part = "7"}, 2, rgb);
    expect(&file, "by name", (hdr_reading){.part = "beauty"}, 0, rgba);
    expect(&file, "by name in another case", (hdr_reading){.part = "Beauty"}, 0, rgba);
    expect(&file, "a view", (hdr_reading){.layer = "right"}, 2, rgb);
    expect(&file, "a view in another case", (hdr_reading){.layer = "LEFT"}, 0, rgba);
    expect(&file, "a part as a layer", (hdr_reading){.layer = "beauty"}, 0, rgba);
    expect(&file, "a part whose only layer has a name", (hdr_reading){.layer = "ids"}, 3, NAMES("only.Y"));
    expect(&file, "the same by --part", (hdr_reading){.part = "ids"}, 3, NAMES("only.Y"));
    expect(&file, "to the letter", (hdr_reading){.layer = "diffuse"}, 4, NAMES("diffuse.R"));
    expect(&file, "lower case", (hdr_reading){.layer = "Diffuse"}, 4, NAMES("Diffuse.r", "Diffuse.g", "Diffuse.b"));
    expect(&file, "any case", (hdr_reading){.layer = "DIFFUSE"}, 4, NAMES("Diffuse.r", "Diffuse.g", "Diffuse.b"));
    expect(&file, "words", (hdr_reading){.layer = "gloss"}, 4,
           NAMES("gloss.red", "gloss.green", "gloss.blue", "gloss.alpha"));
    expect(&file, "nested", (hdr_reading){.layer = "forward.left"}, 4, NAMES(NULL, "forward.left.G"));
    expect(&file, "a channel", (hdr_reading){.channel = "Z"}, 1, NAMES("Z"));
    expect(&file, "a channel of a view", (hdr_reading){.layer = "right", .channel = "G"}, 2, NAMES("G"));
    expect(&file, "a channel of a layer", (hdr_reading){.layer = "gloss", .channel = "alpha"}, 4, NAMES("gloss.alpha"));
    expect(&file, "a whole name", (hdr_reading){.channel = "n.y"}, 4, NAMES("n.y"));
    expect(&file, "a channel in another case", (hdr_reading){.channel = "N.Y"}, 4, NAMES("n.y"));
    expect(&file, "whole numbers", (hdr_reading){.channel = "id"}, 3, NAMES("id"));
    expect(&file, "alpha by itself", (hdr_reading){.part = "0", .channel = "A"}, 0, NAMES("A"));
    expect(&file, "a level of a part", (hdr_reading){.part = "pyramid", .level = 1}, 5, NAMES("Y"));
    refuse(&file, (hdr_reading){.part = "6"}, "no part 6");
    refuse(&file, (hdr_reading){.part = "none"}, "part 4 passes");
    refuse(&file, (hdr_reading){.part = "1"}, "it has: part 1 depth, view left: Z");
    refuse(&file, (hdr_reading){.part = "passes"}, "--layer or --channel");
    refuse(&file, (hdr_reading){.layer = "n"}, "no layer or view n that");
    refuse(&file, (hdr_reading){.channel = "Q"}, "no channel Q");
    refuse(&file, (hdr_reading){.layer = "right", .channel = "Z"}, "in a layer or view right");
    refuse(&file, (hdr_reading){.level = 1}, "its only level is 0");
    refuse(&file, (hdr_reading){.part = "5", .level = 4}, "its levels are 0 to 3");

    /* The first part turned into a deep one: the others are still read. */
    static const char type[] = "type\0string\0\15\0\0\0scanlineimage";
    unsigned char *found = memmem(file.bytes.data, file.bytes.size, type, sizeof type - 1);
    CHECK(found, "no type is found");
    if (found) memcpy(found + sizeof type - 1 - 13, "deepscanline", 13);
    expect(&file, "beside a deep part", (hdr_reading){.memory = 0}, 2, rgb);
    refuse(&file, (hdr_reading){.part = "0"}, "deep data");
    refuse(&file, (hdr_reading){.layer = "beauty"}, "deep data");
    free_file(&file);
}

static void check_views(void) {
    struct made_file file = {.part = {{.name = "",
                                       .views = {"right", "left", NULL},
                                       .width = 8,
                                       .height = 5,
                                       .compression = EXR_COMPRESSION_ZIP,
                                       .channel = {FLOAT("B"), FLOAT("G"), FLOAT("R"), FLOAT("Z"), HALF("glow.right.R"),
                                                   FLOAT("left.G"), FLOAT("left.R"), FLOAT("left.Z")}}}};
    if (!make_file(&file)) return;
    expect(&file, "the default view", (hdr_reading){.memory = 0}, 0, NAMES("R", "G", "B"));
    expect(&file, "the same by name", (hdr_reading){.layer = "right"}, 0, NAMES("R", "G", "B"));
    expect(&file, "another view", (hdr_reading){.layer = "Left"}, 0, NAMES("left.R", "left.G"));
    expect(&file, "a layer of the default view", (hdr_reading){.layer = "glow"}, 0, NAMES("glow.right.R"));
    expect(&file, "Z of the default view", (hdr_reading){.layer = "right", .channel = "Z"}, 0, NAMES("Z"));
    expect(&file, "Z of another", (hdr_reading){.layer = "left", .channel = "Z"}, 0, NAMES("left.Z"));
    expect(&file, "its only part", (hdr_reading){.part = "0"}, 0, NAMES("R", "G", "B"));
    refuse(&file, (hdr_reading){.part = "1"}, "a file of one part");
    free_file(&file);
}

/* As Nuke writes them: a part for each layer of each view. */
static void check_parts_of_views(void) {
    struct made_file file = {
        .part = {{.name = "glow.left", .view = "left", .width = 3, .height = 2, .channel = {HALF("glow.R")}},
                 {.name = "p1", .view = "right", .width = 3, .height = 2, .channel = {HALF("glow.R"), HALF("glow.Z")}},
                 {.name = "p2", .view = "left", .width = 3, .height = 2, .channel = {HALF("B"), HALF("G"), HALF("R")}},
                 {.name = "p3", .view = "right", .width = 3, .height = 2, .channel = {HALF("Y")}},
                 {.name = "p4", .view = "up", .width = 3, .height = 2, .channel = {HALF("haze.R")}}}};
    if (!make_file(&file)) return;
    expect(&file, "a view", (hdr_reading){.layer = "left"}, 2, NAMES("R", "G", "B"));
    expect(&file, "a view in another case", (hdr_reading){.layer = "RIGHT"}, 3, NAMES("Y"));
    expect(&file, "a view without an unnamed layer", (hdr_reading){.layer = "up"}, 4, NAMES("haze.R"));
    expect(&file, "a layer", (hdr_reading){.layer = "glow"}, 0, NAMES("glow.R"));
    expect(&file, "a part's name", (hdr_reading){.layer = "glow.left"}, 0, NAMES("glow.R"));
    expect(&file, "a layer in a view", (hdr_reading){.layer = "glow.right"}, 1, NAMES("glow.R"));
    expect(&file, "a view and a layer", (hdr_reading){.layer = "right.glow"}, 1, NAMES("glow.R"));
    expect(&file, "in another case", (hdr_reading){.layer = "Right.Glow"}, 1, NAMES("glow.R"));
    expect(&file, "its channel", (hdr_reading){.layer = "glow.right", .channel = "Z"}, 1, NAMES("glow.Z"));
    refuse(&file, (hdr_reading){.layer = "glow.up"}, "no layer or view glow.up");
    refuse(&file, (hdr_reading){.layer = "rightglow"}, "no layer or view rightglow");
    refuse(&file, (hdr_reading){.layer = ".right"}, "no layer or view .right");
    free_file(&file);
}

/* A small letter is a colour only where all three are there. */
static void check_small_letters(void) {
    struct made_file file = {.part = {{.name = "",
                                       .width = 3,
                                       .height = 2,
                                       .channel = {FLOAT("L"), FLOAT("a"), FLOAT("b"), HALF("n.b"), HALF("n.g"),
                                                   HALF("n.r"), HALF("w.Blue"), HALF("w.r")}}}};
    if (!make_file(&file)) return;
    refuse(&file, (hdr_reading){.memory = 0}, "it has: L, a, b, n.b");
    expect(&file, "all three", (hdr_reading){.layer = "n"}, 0, NAMES("n.r", "n.g", "n.b"));
    expect(&file, "a word, and a letter alone", (hdr_reading){.layer = "w"}, 0, NAMES(NULL, NULL, "w.Blue"));
    free_file(&file);
    struct made_file point = {.part = {{.name = "", .width = 3, .height = 2, .channel = {HALF(".R"), HALF("x")}}}};
    if (!make_file(&point)) return;
    expect(&point, "a name that begins with the point", (hdr_reading){.part = "0"}, 0, NAMES(".R"));
    free_file(&point);
}

/* ---- Levels ---- */

static void check_levels(void) {
    static const int sizes[][2] = {{13, 6}, {1, 9}, {33, 16}, {1, 1}, {8, 8}};
    for (int variant = 0; variant < 10; variant++) {
        struct made_file file = {.part = {{.name = "",
                                           .width = sizes[variant % 5][0],
                                           .height = sizes[variant % 5][1],
                                           .min_x = -7,
                                           .min_y = 3,
                                           .tile = variant % 3 ? 4 : 16,
                                           .border = variant % 2,
                                           .mode = EXR_TILE_MIPMAP_LEVELS,
                                           .rounding = variant / 5 ? EXR_TILE_ROUND_UP : EXR_TILE_ROUND_DOWN,
                                           .compression = variant % 2 ? EXR_COMPRESSION_PIZ : EXR_COMPRESSION_ZIP,
                                           .channel = {FLOAT("B"), HALF("G"), HALF("R")}}}};
        if (!make_file(&file)) return;
        const struct made_part *part = &file.part[0];
        int count = 0;
        while (count < MOST_LEVELS && part->channel[0].pixels[count])
            count++;
        int larger = part->width > part->height ? part->width : part->height;
        for (int level = 0; level < count; level++) {
            char name[NAME_BYTES];
            snprintf(name, sizeof name, "variant %d, level %d", variant, level);
            expect(&file, name, (hdr_reading){.level = level}, 0, NAMES("R", "G", "B"));
            struct image image;
            hdr_error error;
            int pixels = level_side(part, larger, level);
            CHECK(read_file(&file.bytes, (hdr_reading){.proxy = true, .level = pixels}, &image, &error) == HDR_OK,
                  "%s: %s", name, error.message);
            int wanted = level; /* of several that are as large, the last */
            while (wanted + 1 < count && level_side(part, larger, wanted + 1) >= pixels)
                wanted++;
            CHECK(image.about.level == wanted, "%s: proxy:%d gives %d", name, pixels, image.about.level);
            if (!part->border)
                CHECK(memcmp(&image.about.data, &image.about.display, sizeof image.about.data) == 0,
                      "%s: another display window", name);
            free_image(&image);
        }
        refuse(&file, (hdr_reading){.level = count}, "it has no level");
        struct image image;
        hdr_error error;
        CHECK(read_file(&file.bytes, (hdr_reading){.proxy = true, .level = 1000}, &image, &error) == HDR_OK &&
                  image.about.level == 0,
              "a proxy larger than all");
        free_image(&image);
        free_file(&file);
    }
}

/* A frame around the data window shrinks with it, toward its first corner. */
static void check_level_windows(void) {
    struct made_file file = {.part = {{.name = "",
                                       .width = 16,
                                       .height = 8,
                                       .min_x = 10,
                                       .min_y = -4,
                                       .border = true,
                                       .tile = 8,
                                       .mode = EXR_TILE_MIPMAP_LEVELS,
                                       .compression = EXR_COMPRESSION_ZIP,
                                       .channel = {HALF("Y")}}}};
    struct image image;
    hdr_error error;
    if (!make_file(&file)) return;
    read_file(&file.bytes, (hdr_reading){.level = 1}, &image, &error);
    const hdr_window *display = &image.about.display; /* at level 0: 5 to 28, -8 to 9 */
    CHECK(display->min_x == 10 - 3 && display->min_y == -4 - 2 && display->max_x == 10 + 8 && display->max_y == -4 + 6,
          "display window of level 1: %d %d %d %d", display->min_x, display->min_y, display->max_x, display->max_y);
    free_image(&image);
    free_file(&file);
}

/* ---- Rectangles ---- */

static void check_crop(const struct made_file *file, const struct image *whole, hdr_window crop) {
    struct image image;
    hdr_error error;
    const hdr_window *data = &whole->about.data, *left = &image.about.data;
    CHECK(read_file(&file->bytes, (hdr_reading){.cropped = true, .crop = crop}, &image, &error) == HDR_OK, "crop: %s",
          error.message);
    CHECK(memcmp(&image.about.display, &crop, sizeof crop) == 0, "the frame is not the rectangle");
    bool apart =
        crop.max_x < data->min_x || crop.min_x > data->max_x || crop.max_y < data->min_y || crop.min_y > data->max_y;
    CHECK((image.width == 0 || image.height == 0) == apart, "%zu x %zu pixels are left", image.width, image.height);
    if (!apart)
        CHECK(left->min_x == (crop.min_x > data->min_x ? crop.min_x : data->min_x) &&
                  left->max_y == (crop.max_y < data->max_y ? crop.max_y : data->max_y),
              "another data window");
    for (int p = 0; !apart && p < 4; p++) {
        size_t size = hdr_type_size(whole->about.channels[p].type);
        size_t x = (size_t)(left->min_x - data->min_x), y = (size_t)(left->min_y - data->min_y), different = 0;
        for (size_t row = 0; whole->plane[p] && row < image.height; row++)
            different += memcmp(image.plane[p] + row * image.width * size,
                                whole->plane[p] + ((y + row) * whole->width + x) * size, image.width * size) != 0;
        CHECK(different == 0, "plane %d of a rectangle differs", p);
    }
    free_image(&image);
}

static void check_crops(void) {
    for (int tile = 0; tile < 20; tile += 9) {
        struct made_file file = {.part = {{.name = "",
                                           .width = 50,
                                           .height = 61,
                                           .min_x = -11,
                                           .min_y = 7,
                                           .tile = tile,
                                           .mode = EXR_TILE_ONE_LEVEL,
                                           .compression = EXR_COMPRESSION_ZIP,
                                           .channel = {FLOAT("A"), HALF("B"), HALF("G"), FLOAT("R")}}}};
        struct image whole;
        hdr_error error;
        if (!make_file(&file)) return;
        CHECK(read_file(&file.bytes, (hdr_reading){.memory = 0}, &whole, &error) == HDR_OK, "%s", error.message);
        for (int i = 0; i < 200; i++) {
            int x = -30 + (int)(random_bits(&random_state) % 80), y = -10 + (int)(random_bits(&random_state) % 90);
            int width = 1 + (int)(random_bits(&random_state) % 60), height = 1 + (int)(random_bits(&random_state) % 70);
            check_crop(&file, &whole, (hdr_window){x, y, x + width - 1, y + height - 1});
        }
        check_crop(&file, &whole, whole.about.data);
        check_crop(&file, &whole, (hdr_window){INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN});
        check_crop(&file, &whole, (hdr_window){INT32_MAX, 8, INT32_MAX, 8});
        free_image(&whole);
        free_file(&file);
    }
}

/* Chunks outside are not looked at: there they may be missing. Luminance and chroma of one resolution are no different.
 */
static void check_crop_reads_no_more(bool chroma) {
    static const struct made_channel chromatic[] = {HALF("BY"), HALF("RY"), HALF("Y")};
    struct made_file file = {.part = {{.name = "",
                                       .width = 40,
                                       .height = 40,
                                       .tile = 10,
                                       .mode = EXR_TILE_ONE_LEVEL,
                                       .compression = EXR_COMPRESSION_NONE,
                                       .channel = {HALF("Y")}}}};
    if (chroma) memcpy(file.part[0].channel, chromatic, sizeof chromatic);
    hdr_error error;
    struct image image;
    if (!make_file(&file)) return;
    hdr_reading reading = {.cropped = true, .crop = {0, 0, 9, 9}};
    size_t tile = 20 + 10 * 10 * 2 * (chroma ? 3 : 1); /* 16 of them are the end of the file */
    file.bytes.size -= 15 * tile;
    CHECK(read_file(&file.bytes, reading, &image, &error) == HDR_OK, "the first tile where there are no others: %s",
          error.message);
    free_image(&image);
    reading.crop = (hdr_window){0, 0, 10, 9};
    CHECK(read_file(&file.bytes, reading, &image, &error) == HDR_BAD_DATA, "a tile that is not there");
    free_image(&image);
    free_file(&file);
}

/* ---- Contents ---- */

/* The layer of each channel with a point in its name, of those in `several`. */
static const char *layer_name(const char *channel) {
    static const char *const layers[] = {"id", "only", "Diffuse", "diffuse", "forward.left", "gloss", "n"};
    for (size_t i = 0; i < sizeof layers / sizeof layers[0]; i++) {
        size_t length = strlen(layers[i]);
        if (strncmp(channel, layers[i], length) == 0 && channel[length] == '.') return layers[i];
    }
    return "";
}

static void check_contents(void) {
    struct made_file file = several;
    hdr_error error = {.status = HDR_OK};
    if (!make_file(&file)) return;
    hdr_input *input = hdr_input_memory(file.bytes.data, file.bytes.size, "made", &error);
    hdr_contents *contents = hdr_input_contents(input, &error);
    CHECK(contents && contents->part_count == file.parts, "%s", error.message);
    for (int i = 0; contents && i < file.parts; i++) {
        const struct made_part *made = &file.part[i];
        const hdr_part *part = &contents->parts[i];
        int channels = 0;
        CHECK(part->number == i && strcmp(part->name, made->name) == 0 &&
                  strcmp(part->view, made->view ? made->view : "") == 0 && part->tile_width == made->tile &&
                  part->data.min_y == made->min_y && hdr_window_width(&part->data) == made->width &&
                  strcmp(part->storage, made->tile ? "tiled" : "scan-line") == 0,
              "part %d is listed as another", i);
        for (; made->channel[channels].name; channels++)
            CHECK(channels < part->channel_count &&
                      strcmp(part->channels[channels].name, made->channel[channels].name) == 0 &&
                      strcmp(part->channels[channels].layer, layer_name(made->channel[channels].name)) == 0,
                  "part %d: channel %d", i, channels);
        CHECK(channels == part->channel_count, "part %d: %d channels", i, part->channel_count);
        bool found = false;
        for (int a = 0; a < part->attribute_count; a++)
            found |= strcmp(part->attributes[a].name, "name") == 0 && strcmp(part->attributes[a].type, "string") == 0 &&
                     part->attributes[a].value && strcmp(part->attributes[a].value, made->name) == 0;
        CHECK(found, "part %d: no attribute name", i);
    }
    if (contents)
        CHECK(contents->parts[5].level_count == 4 && strcmp(contents->parts[5].levels, "mipmap") == 0 &&
                  contents->parts[3].channels[0].type == HDR_UINT,
              "levels, or types");
    hdr_contents_free(contents);
    hdr_picture picture;
    hdr_chain *chain = hdr_chain_new(&error);
    const char *const words[] = {"info", "--layer", "right"};
    CHECK(hdr_chain_add(chain, words, 3, &error) == HDR_OK &&
              hdr_input_picture(input, chain, &picture, &error) == HDR_OK && picture.part == 2 &&
              hdr_input_picture(input, NULL, &picture, &error) == HDR_OK && picture.part == 0,
          "the chain's reading: %s", error.message);
    hdr_chain_free(chain);
    hdr_input_free(input);

    const float plane[4] = {1, 2, 3, 4};
    input = hdr_input_planes(2, 2, 1, (const float *const[3]){plane}, NULL, &error);
    contents = hdr_input_contents(input, &error);
    CHECK(contents && contents->part_count == 1 && contents->parts[0].channel_count == 1, "planes: %s", error.message);
    hdr_contents_free(contents);
    hdr_input_free(input);
    free_file(&file);
}

/* ---- Damage ---- */

static const hdr_reading tried[] = {{.part = "0"},      {.part = "1", .channel = "Z"}, {.part = "2"}, {.channel = "id"},
                                    {.layer = "gloss"}, {.part = "5", .level = 2},     {.memory = 0}};
enum { TRIED = sizeof tried / sizeof tried[0] };

static void try_all(const file_bytes *bytes, bool whole, const char *what, size_t where) {
    hdr_error error;
    for (int t = 0; t < TRIED; t++) {
        hdr_status status = read_file(bytes, tried[t], NULL, &error);
        CHECK(status == HDR_BAD_DATA || (status == HDR_OK && whole), "%s %zu, reading %d: %d %s", what, where, t,
              status, error.message);
    }
    error = (hdr_error){.status = HDR_OK};
    hdr_input *input = hdr_input_memory(bytes->data, bytes->size, "made", &error);
    hdr_contents *contents = hdr_input_contents(input, &error);
    CHECK(contents || error.status == HDR_BAD_DATA, "%s %zu: %d %s", what, where, error.status, error.message);
    hdr_contents_free(contents);
    hdr_input_free(input);
}

static void check_damage(void) {
    struct made_file file = several;
    if (!make_file(&file)) return;
    size_t size = file.bytes.size;
    for (size_t cut = 0; cut < size; cut++) {
        file_bytes part = {malloc(cut ? cut : 1), cut}; /* of its own size, so that a sanitizer sees a step beyond */
        if (!part.data) abort();
        memcpy(part.data, file.bytes.data, cut);
        try_all(&part, true, "cut to", cut); /* a part may be whole though another is not */
        free(part.data);
    }
    hdr_error error;
    for (size_t at = 0; at < size; at++)
        for (int kind = 0; kind < 2; kind++) {
            unsigned char before = file.bytes.data[at];
            file.bytes.data[at] = (unsigned char)(kind ? 0xff : before ^ (1u << (random_bits(&random_state) % 8)));
            try_all(&file.bytes, true, "damaged at", at);
            file.bytes.data[at] = before;
        }
    file.bytes.size = size - 1;
    CHECK(read_file(&file.bytes, (hdr_reading){.part = "5", .level = 3}, NULL, &error) == HDR_BAD_DATA,
          "the last chunk cut: %d", error.status);
    file.bytes.size = size;
    free_file(&file);
}

/* A chunk that says it is another part's. */
static void check_part_numbers(void) {
    struct made_file file = {.part = {{.name = "a", .width = 3, .height = 1, .channel = {HALF("Y")}},
                                      {.name = "b", .width = 3, .height = 1, .channel = {HALF("Y")}}}};
    if (!make_file(&file)) return;
    size_t last = file.bytes.size - 6 - 12; /* three halves, and what stands in front of them */
    CHECK(file.bytes.data[last] == 1, "the last chunk is not where it was expected");
    expect(&file, "b", (hdr_reading){.part = "b"}, 1, NAMES("Y"));
    file.bytes.data[last] = 0;
    refuse(&file, (hdr_reading){.part = "b"}, "damaged");
    free_file(&file);
}

int main(void) {
    alarm(300);
    check_parts();
    check_views();
    check_parts_of_views();
    check_small_letters();
    check_levels();
    check_level_windows();
    check_crops();
    check_crop_reads_no_more(false);
    check_crop_reads_no_more(true);
    check_contents();
    check_part_numbers();
    check_damage();
    return check_done("test_exr_parts");
}

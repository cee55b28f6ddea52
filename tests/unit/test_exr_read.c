/* Reads EXR files through hdr_source and compares every sample, bit for bit, with what OpenEXRCore's own routines make
 * of them; cuts and damages files; reads them through pipes.
 *
 * Usage: test_exr_read [corpus directory]     (else $HDRPIPE_CORPUS, else ../shared/corpus; left out where there is
 * none) */
#include "check.h"
#include "exr_make.h"
#include "io/source.h"
#include "pipes.h"

#include <dirent.h>
#include <pthread.h>
#include <time.h>
#include <unistd.h>

enum { THREADS = 2, DAMAGED_COPIES = 400, PATH_BYTES = 1000 };

#define MEMORY ((uint64_t)256 << 20)
#define TINY "testdata/tiny"

static uint64_t random_state = 1;

/* ---- Reading whole pictures ---- */

typedef struct image {
    hdr_picture about;
    size_t width, height;
    unsigned char *plane[4]; /* tight rows */
} image;

static void image_free(image *image) {
    for (int p = 0; p < 4; p++)
        free(image->plane[p]);
    memset(image, 0, sizeof *image);
}

static size_t row_size(const image *image, int p) {
    return image->width * hdr_type_size(image->about.channels[p].type);
}

typedef struct reader {
    hdr_source *source;
    image *image;
    int thread, misplaced;
    hdr_error error;
} reader;

/* Copies a block into the image, and counts what hdr_block does not promise. */
static void collect(reader *r, int index, const hdr_block *block) {
    int first = index * r->source->block_rows, left = (int)r->image->height - first;
    int rows = left < r->source->block_rows ? left : r->source->block_rows;
    if (block->first_row != first || block->rows != rows) r->misplaced++;
    for (int p = 0; p < 4; p++) {
        if (!r->image->plane[p] != !block->plane[p]) r->misplaced++;
        if (!r->image->plane[p] || !block->plane[p]) continue;
        size_t size = hdr_type_size(block->type[p]), row = row_size(r->image, p);
        if ((uintptr_t)block->plane[p] % size || block->stride[p] % size) r->misplaced++;
        for (int i = 0; i < rows; i++)
            memcpy(r->image->plane[p] + (size_t)(first + i) * row, block->plane[p] + (size_t)i * block->stride[p], row);
    }
}

static void *read_blocks(void *argument) {
    reader *r = argument;
    void *worker = NULL;
    if (r->source->worker_new(r->source, &worker, &r->error) != HDR_OK) return NULL;
    for (int i = r->thread; i < r->source->blocks; i += THREADS) {
        hdr_block block;
        if (r->source->read(r->source, worker, i, &block, &r->error) != HDR_OK) break;
        collect(r, i, &block);
    }
    r->source->worker_free(r->source, worker);
    return NULL;
}

/* Reads all, with several workers at a time. */
static hdr_status read_source(hdr_source *source, image *image, hdr_error *error) {
    *image = (struct image){.about = source->picture};
    image->width = (size_t)hdr_window_width(&source->picture.data);
    image->height = (size_t)hdr_window_height(&source->picture.data);
    for (int p = 0; p < 4; p++)
        if (source->picture.present[p]) {
            image->plane[p] = calloc(image->height, row_size(image, p));
            if (!image->plane[p]) return HDR_INTERNAL;
        }
    reader readers[THREADS];
    pthread_t threads[THREADS];
    for (int i = 0; i < THREADS; i++) {
        readers[i] = (reader){.source = source, .image = image, .thread = i};
        if (pthread_create(&threads[i], NULL, read_blocks, &readers[i]) != 0) abort();
    }
    for (int i = 0; i < THREADS; i++) {
        pthread_join(threads[i], NULL);
        CHECK(readers[i].misplaced == 0, "%d blocks are not as promised", readers[i].misplaced);
        if (error->status == HDR_OK) *error = readers[i].error;
    }
    return error->status;
}

static hdr_status read_input(hdr_input *input, image *image, hdr_error *error) {
    memset(image, 0, sizeof *image);
    hdr_source *source = input ? hdr_source_open(input, &(hdr_reading){.memory = MEMORY}, error) : NULL;
    if (source) read_source(source, image, error);
    hdr_source_close(source);
    return error->status;
}

/* The same one block after the other, keeping nothing: for damaged files, which may claim any size. */
static hdr_status try_bytes(const unsigned char *bytes, size_t size, hdr_error *error) {
    *error = (hdr_error){.status = HDR_OK};
    hdr_input *input = hdr_input_memory(bytes, size, "damaged", error);
    hdr_source *source = input ? hdr_source_open(input, &(hdr_reading){.memory = MEMORY}, error) : NULL;
    void *worker = NULL;
    if (source && source->worker_new(source, &worker, error) == HDR_OK) {
        hdr_block block;
        for (int i = 0; i < source->blocks && error->status == HDR_OK; i++)
            source->read(source, worker, i, &block, error);
        source->worker_free(source, worker);
    }
    hdr_source_close(source);
    hdr_input_free(input);
    return error->status;
}

static bool load(const char *path, file_bytes *file) {
    *file = (file_bytes){NULL, 0};
    FILE *stream = fopen(path, "rb");
    if (!stream) return false;
    unsigned char buffer[65536];
    size_t count;
    while ((count = fread(buffer, 1, sizeof buffer, stream)) > 0)
        write_memory(NULL, file, buffer, count, file->size, NULL);
    fclose(stream);
    return true;
}

/* ---- Comparing ---- */

static void check_same(const char *name, const image *a, const image *b) {
    CHECK(a->width == b->width && a->height == b->height, "%s: another size", name);
    if (a->width != b->width || a->height != b->height) return;
    for (int p = 0; p < 4; p++) {
        CHECK(!a->plane[p] == !b->plane[p], "%s: another set of channels", name);
        if (a->plane[p] && b->plane[p])
            CHECK(memcmp(a->plane[p], b->plane[p], a->height * row_size(a, p)) == 0, "%s: channel %s differs", name,
                  a->about.channels[p].name);
    }
}

/* Reads an input and compares it with the library's reading of the same bytes. */
static void check_against_library(const char *name, hdr_input *input, file_bytes *file) {
    image ours, theirs;
    hdr_error error = {.status = HDR_OK};
    CHECK(read_input(input, &ours, &error) == HDR_OK, "%s: %s", name, error.message);
    if (error.status == HDR_OK) {
        const char *names[4];
        theirs = ours;
        for (int p = 0; p < 4; p++) {
            names[p] = ours.about.channels[p].name;
            theirs.plane[p] = ours.plane[p] ? calloc(ours.height, row_size(&ours, p)) : NULL;
        }
        CHECK(read_plainly(file, names, theirs.plane), "%s: the library cannot read it", name);
        check_same(name, &ours, &theirs);
        image_free(&theirs);
    }
    image_free(&ours);
}

static void check_file(const char *path) {
    file_bytes file;
    hdr_error error = {.status = HDR_OK};
    CHECK(load(path, &file), "%s: cannot be loaded", path);
    hdr_input *input = hdr_input_open(path, &error);
    check_against_library(path, input, &file);
    hdr_input_free(input);
    free(file.data);
}

/* ---- Files of the tree and of the corpus ---- */

/* Names in the corpus that are to be refused, and a word that must be in the sentence. */
static const struct {
    const char *name, *word;
} refusals[] = {
    {"deep_trunks.exr", "deep"},
};

/* Luminance-chroma: tests/oracle/test_yc.cc compares it with the C++ library, which alone reconstructs it. */
static const char *const chroma[] = {"Flowers.exr", "Rec709_YC.exr", "XYZ_YC.exr"};

static void check_refused(const char *path, const char *word) {
    hdr_error error = {.status = HDR_OK};
    image image;
    hdr_input *input = hdr_input_open(path, &error);
    CHECK(read_input(input, &image, &error) == HDR_BAD_DATA && strstr(error.message, word), "%s: %d %s", path,
          error.status, error.message);
    CHECK(strncmp(error.message, path, strlen(path)) == 0, "the message does not begin with the name: %s",
          error.message);
    image_free(&image);
    hdr_input_free(input);
}

static void check_any(const char *path, const char *name) {
    /* OpenEXRCore 3.1 has nothing to compare with: tests/cli/test_exr_library.sh does it with the C++ library */
    if (strcmp(name, "dwa_night.exr") == 0) return;
    for (size_t i = 0; i < sizeof refusals / sizeof refusals[0]; i++)
        if (strcmp(name, refusals[i].name) == 0) {
            check_refused(path, refusals[i].word);
            return;
        }
    for (size_t i = 0; i < sizeof chroma / sizeof chroma[0]; i++)
        if (strcmp(name, chroma[i]) == 0) return;
    size_t length = strlen(name);
    if (length > 4 && strcmp(name + length - 4, ".exr") == 0) check_file(path); /* others are for other tests */
}

static void check_broken(const char *path, const char *name) {
    hdr_error error = {.status = HDR_OK};
    file_bytes file;
    (void)name;
    CHECK(load(path, &file), "%s: cannot be loaded", path);
    clock_t start = clock();
    CHECK(try_bytes(file.data, file.size, &error) == HDR_BAD_DATA, "%s: %d %s", path, error.status, error.message);
    CHECK((double)(clock() - start) < 2.0 * CLOCKS_PER_SEC, "%s: took too long", path);
    CHECK(!strchr(error.message, '\n') && error.message[0], "%s: not one line: %s", path, error.message);
    free(file.data);
}

static int each_file(const char *directory, void (*check)(const char *path, const char *name)) {
    int count = 0;
    DIR *files = opendir(directory);
    struct dirent *entry;
    while (files && (entry = readdir(files))) {
        char path[PATH_BYTES];
        if (entry->d_name[0] == '.' || strncmp(entry->d_name, "README", 6) == 0) continue;
        if (snprintf(path, sizeof path, "%s/%s", directory, entry->d_name) >= (int)sizeof path) continue;
        check(path, entry->d_name);
        count++;
    }
    if (files) closedir(files);
    return count;
}

static void check_corpus(const char *corpus) {
    static const char *const folders[] = {"photo", "render", "storage", "torture", "windows"};
    char path[PATH_BYTES];
    if (access(corpus, R_OK) != 0) {
        fprintf(stderr, "test_exr_read: no corpus: real and broken files are skipped\n");
        return;
    }
    for (size_t i = 0; i < sizeof folders / sizeof folders[0]; i++) {
        snprintf(path, sizeof path, "%s/%s", corpus, folders[i]);
        each_file(path, check_any);
    }
    snprintf(path, sizeof path, "%s/broken", corpus);
    each_file(path, check_broken);

    hdr_error error = {.status = HDR_OK};
    hdr_picture *about;
    snprintf(path, sizeof path, "%s/torture/WideFloatRange.exr", corpus);
    hdr_input *input = hdr_input_open(path, &error);
    hdr_source *source = input ? hdr_source_open(input, &(hdr_reading){.memory = MEMORY}, &error) : NULL;
    about = source ? &source->picture : NULL;
    CHECK(about && about->planes == 3 && !about->present[0] && about->present[1] && !about->present[2] &&
              about->channels[1].type == HDR_FLOAT,
          "%s: only G was expected: %s", path, error.message);
    hdr_source_close(source);
    hdr_input_free(input);
}

/* ---- Files made for the purpose ---- */

static bool is_lossless(const recipe *r, int c) {
    return r->compression <= EXR_COMPRESSION_PIZ ||
           (r->compression == EXR_COMPRESSION_PXR24 && r->channel[c].type == EXR_PIXEL_HALF);
}

/* Compares with what the file was made from. */
static void check_made(recipe *r, const char *name, file_bytes *file) {
    hdr_error error = {.status = HDR_OK};
    image image;
    hdr_input *input = hdr_input_memory(file->data, file->size, name, &error);
    check_against_library(name, input, file);
    read_input(input, &image, &error);
    for (int p = 0; p < 4 && error.status == HDR_OK; p++)
        for (int c = 0; c < r->channels; c++)
            if (image.plane[p] && strcmp(image.about.channels[p].name, r->channel[c].name) == 0 && is_lossless(r, c))
                CHECK(memcmp(image.plane[p], r->channel[c].pixels, image.height * row_size(&image, p)) == 0,
                      "%s: channel %s is not what was written", name, r->channel[c].name);
    image_free(&image);
    hdr_input_free(input);
}

static void check_variants(void) {
    for (int compression = EXR_COMPRESSION_NONE; compression <= EXR_COMPRESSION_B44A; compression++)
        for (int variant = 0; variant < 8; variant++) {
            /* A float plane behind an odd number of half samples stands at an odd place. */
            recipe r = {.width = 37,
                        .height = 75,
                        .min_x = -5,
                        .min_y = variant & 1 ? -20 : 3,
                        .compression = (exr_compression_t)compression,
                        .tile = variant & 2 ? 24 : 0,
                        .upwards = variant == 5,
                        .noise = (variant & 4) != 0,
                        .channels = 6,
                        .channel = {{"A", EXR_PIXEL_HALF, NULL},
                                    {"B", EXR_PIXEL_FLOAT, NULL},
                                    {"G", EXR_PIXEL_HALF, NULL},
                                    {"N", EXR_PIXEL_UINT, NULL},
                                    {"R", variant & 1 ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT, NULL},
                                    {"left.R", EXR_PIXEL_HALF, NULL}}};
            char name[64];
            file_bytes file;
            snprintf(name, sizeof name, "made: compression %d, variant %d", compression, variant);
            CHECK(make_exr(&r, &random_state, &file), "%s: cannot be made", name);
            check_made(&r, name, &file);
            free_recipe(&r);
            free(file.data);
        }
}

/* Makes a one-line picture of up to three channels, and reads what is said about it. */
static hdr_status look_at(recipe *r, hdr_picture *about, hdr_error *error) {
    file_bytes file;
    *error = (hdr_error){.status = HDR_OK};
    memset(about, 0, sizeof *about);
    CHECK(make_exr(r, &random_state, &file), "a picture cannot be made");
    hdr_input *input = hdr_input_memory(file.data, file.size, "made", error);
    hdr_source *source = hdr_source_open(input, &(hdr_reading){.memory = MEMORY}, error);
    if (source) *about = source->picture;
    hdr_source_close(source);
    hdr_input_free(input);
    free_recipe(r);
    free(file.data);
    return error->status;
}

static void check_channel_rules(void) {
    hdr_picture about;
    hdr_error error;
    recipe r = {.width = 4,
                .height = 2,
                .channels = 2,
                .state = "gamma 2.2",
                .channel = {{"A", EXR_PIXEL_HALF, NULL}, {"Y", EXR_PIXEL_FLOAT, NULL}}};
    CHECK(look_at(&r, &about, &error) == HDR_OK && about.planes == 1 && about.has_alpha && about.present[0] &&
              !about.present[1] && about.present[3] && about.channels[0].type == HDR_FLOAT &&
              strcmp(about.channels[0].name, "Y") == 0 && strcmp(about.state, "gamma 2.2") == 0,
          "Y and A: %s", error.message);
    CHECK(!about.has_chromaticities && about.chromaticities.white[0] == 0.3127 && about.pixel_aspect == 1,
          "the defaults are not those of Rec. 709");
    r = (recipe){
        .width = 4, .height = 2, .channels = 2, .channel = {{"B", EXR_PIXEL_HALF, NULL}, {"R", EXR_PIXEL_UINT, NULL}}};
    CHECK(look_at(&r, &about, &error) == HDR_BAD_DATA && strstr(error.message, "uint"), "uint: %s", error.message);
    r = (recipe){.width = 4,
                 .height = 2,
                 .channels = 2,
                 .channel = {{"depth.Z", EXR_PIXEL_HALF, NULL}, {"left.R", EXR_PIXEL_HALF, NULL}}};
    CHECK(look_at(&r, &about, &error) == HDR_BAD_DATA && strstr(error.message, "depth.Z, left.R"), "list: %s",
          error.message);
    r = (recipe){.width = 4,
                 .height = 2,
                 .channels = 2,
                 .sampling = 2,
                 .channel = {{"G", EXR_PIXEL_HALF, NULL}, {"R", EXR_PIXEL_HALF, NULL}}};
    CHECK(look_at(&r, &about, &error) == HDR_BAD_DATA && strstr(error.message, "subsampled"), "sampling: %s",
          error.message);
}

/* ---- Damage ---- */

static void damage(const file_bytes *file, const char *name) {
    hdr_error error;
    for (size_t size = 0; size < file->size; size++) {
        /* In memory of its own size, so that a sanitizer sees a step beyond. */
        unsigned char *cut = malloc(size ? size : 1);
        if (!cut) abort();
        memcpy(cut, file->data, size);
        CHECK(try_bytes(cut, size, &error) == HDR_BAD_DATA, "%s, cut to %zu bytes: %d %s", name, size, error.status,
              error.message);
        free(cut);
    }
    unsigned char *copy = malloc(file->size);
    if (!copy) abort();
    for (int i = 0; i < DAMAGED_COPIES; i++) {
        memcpy(copy, file->data, file->size);
        for (int flips = 1 + i % 4; flips > 0; flips--)
            copy[random_bits(&random_state) % file->size] ^= (unsigned char)(1u << (random_bits(&random_state) % 8));
        hdr_status status = try_bytes(copy, file->size, &error);
        CHECK(status == HDR_OK || status == HDR_BAD_DATA, "%s, damaged: %d %s", name, status, error.message);
    }
    free(copy);
}

static void check_damage(const char *path, const char *name) {
    file_bytes file;
    CHECK(load(path, &file), "%s: cannot be loaded", path);
    damage(&file, name);
    free(file.data);
}

/* The same for one of each compression. */
static void check_damaged_variants(void) {
    for (int compression = EXR_COMPRESSION_NONE; compression <= EXR_COMPRESSION_B44A; compression++)
        for (int tile = 0; tile <= 8; tile += 8) {
            recipe r = {.width = 13,
                        .height = 9,
                        .compression = (exr_compression_t)compression,
                        .tile = tile,
                        .channels = 2,
                        .channel = {{"G", EXR_PIXEL_HALF, NULL}, {"R", EXR_PIXEL_FLOAT, NULL}}};
            file_bytes file;
            char name[64];
            snprintf(name, sizeof name, "compression %d, tiles of %d", compression, tile);
            CHECK(make_exr(&r, &random_state, &file), "%s: cannot be made", name);
            damage(&file, name);
            free_recipe(&r);
            free(file.data);
        }
}

/* ---- Pipes ---- */

/* Reads a file through a pipe whose writer never ends: no end of file must be needed. */
static void check_pipe(file_bytes *file, const char *name, bool linger) {
    hdr_error error = {.status = HDR_OK};
    int from;
    pid_t writer = start_writer(file, linger, &from);
    hdr_input *input = open_descriptor(from, &error);
    CHECK(input, "%s", error.message);
    if (input) {
        unsigned char start[4];
        CHECK(hdr_input_read(input, start, 4, 0, &error) == 4 && hdr_input_size(input) == -1, "%s: no start", name);
        check_against_library(name, input, file);
    }
    hdr_input_free(input);
    end_writer(writer);
}

/* Planes in memory come back as they are. */
static void check_planes(void) {
    const float grey[6] = {0, 1, 2, 3, 4, 5};
    const float *const planes[3] = {grey, NULL, NULL};
    image image;
    hdr_error error = {.status = HDR_OK};
    hdr_input *input = hdr_input_planes(2, 3, 1, planes, grey, &error);
    CHECK(read_input(input, &image, &error) == HDR_OK && image.about.planes == 1 && image.about.has_alpha &&
              memcmp(image.plane[0], grey, sizeof grey) == 0 && memcmp(image.plane[3], grey, sizeof grey) == 0,
          "planes: %s", error.message);
    image_free(&image);
    hdr_input_free(input);
}

/* A picture of some megabytes, so that reading ahead takes part. */
static void check_pipes(void) {
    for (int upwards = 0; upwards < 2; upwards++) {
        recipe r = {
            .width = 700,
            .height = 500,
            .compression = EXR_COMPRESSION_ZIP,
            .upwards = upwards,
            .noise = true,
            .channels = 3,
            .channel = {{"B", EXR_PIXEL_HALF, NULL}, {"G", EXR_PIXEL_HALF, NULL}, {"R", EXR_PIXEL_FLOAT, NULL}}};
        file_bytes file;
        CHECK(make_exr(&r, &random_state, &file), "a picture for pipes cannot be made");
        check_pipe(&file, "through a pipe that stays open", true);
        check_pipe(&file, "through a pipe", false);
        file.size -= 1000; /* a writer that fails */
        hdr_error error = {.status = HDR_OK};
        image image;
        int from;
        pid_t writer = start_writer(&file, false, &from);
        hdr_input *input = open_descriptor(from, &error);
        CHECK(read_input(input, &image, &error) == HDR_BAD_DATA, "a pipe that ends early: %d %s", error.status,
              error.message);
        image_free(&image);
        hdr_input_free(input);
        end_writer(writer);
        free_recipe(&r);
        free(file.data);
    }
}

int main(int argc, char **argv) {
    const char *corpus = argc > 1 ? argv[1] : getenv("HDRPIPE_CORPUS");
    alarm(300); /* a pipe that is waited for in vain */
    check_planes();
    check_variants();
    check_channel_rules();
    check_pipes();
    CHECK(each_file(TINY, check_any) > 0, "no pictures in " TINY);
    each_file(TINY, check_damage);
    check_damaged_variants();
    check_corpus(corpus ? corpus : "../shared/corpus");
    return check_done("test_exr_read");
}

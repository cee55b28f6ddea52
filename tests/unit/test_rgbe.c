/* Radiance HDR files that are made here by hand in every form that there is: each is read as it was meant. */
#include "picture/colour.h"
#include "raster_make.h"

#include <float.h>
#include <math.h>

enum { FLAT, OLD, NEW, STORAGES };

/* Scanlines with runs, and without; normalised, and black here and there. */
static void fill_rgbe(unsigned char *pixels, size_t count) {
    for (size_t i = 0; i < count; i++) {
        bool repeat = i > 0 && random_bits() % 3 != 0;
        uint64_t bits = random_bits();
        if (repeat) {
            memcpy(pixels + 4 * i, pixels + 4 * i - 4, 4);
            continue;
        }
        for (int c = 0; c < 4; c++)
            pixels[4 * i + (size_t)c] = (unsigned char)(bits >> (8 * c));
        pixels[4 * i + (bits >> 40) % 3] |= 128;
        if (bits >> 60 == 0) memset(pixels + 4 * i, 0, 4);
    }
}

static void add_old(file *file, const unsigned char *pixels, size_t count) {
    for (size_t i = 0, run; i < count; i += run) {
        add(file, pixels + 4 * i, 4);
        for (run = 1; i + run < count && memcmp(pixels + 4 * (i + run), pixels + 4 * i, 4) == 0; run++)
            ;
        for (size_t rest = run - 1; rest > 0; rest >>= 8)
            add(file, (unsigned char[]){1, 1, 1, (unsigned char)rest}, 4);
    }
}

static void add_new(file *file, const unsigned char *pixels, size_t count) {
    add(file, (unsigned char[]){2, 2, (unsigned char)(count >> 8), (unsigned char)count}, 4);
    for (size_t c = 0; c < 4; c++)
        for (size_t i = 0, run; i < count; i += run) {
            const unsigned char *at = pixels + 4 * i + c;
            for (run = 1; run < 127 && i + run < count && at[4 * run] == at[0]; run++)
                ;
            if (run == 1)
                add(file, (unsigned char[]){1, at[0]}, 2);
            else
                add(file, (unsigned char[]){(unsigned char)(128 + run), at[0]}, 2);
        }
}

static void add_scanline(file *file, int storage, const unsigned char *pixels, size_t count) {
    if (storage == FLAT) add(file, pixels, 4 * count);
    if (storage == OLD) add_old(file, pixels, count);
    if (storage == NEW) add_new(file, pixels, count);
}

static float decoded(const unsigned char *rgbe, int c, double exposure) {
    return rgbe[3] ? (float)fmin(rgbe[c] * ldexp(1, rgbe[3] - 136) / exposure, (double)FLT_MAX) : 0;
}

/* Pixel x, y of the picture is where the resolution line says: X grows to the right and Y upwards. */
static void compare_rgbe(const char *head, const image *image, const unsigned char *pixels, const char *axes,
                         double exposure) {
    size_t wrong = 0;
    bool columns = axes[1] == 'X', first_down = columns ? axes[0] == '+' : axes[0] == '-',
         then_right = columns ? axes[2] == '-' : axes[2] == '+';
    for (size_t y = 0; y < image->height; y++)
        for (size_t x = 0; x < image->width; x++) {
            size_t a = columns ? x : y, as = columns ? image->width : image->height;
            size_t b = columns ? y : x, bs = columns ? image->height : image->width;
            if (!first_down) a = as - 1 - a;
            if (!then_right) b = bs - 1 - b;
            for (int c = 0; c < 3; c++)
                wrong += image->plane[c][y * image->width + x] != decoded(pixels + 4 * (a * bs + b), c, exposure);
        }
    CHECK(wrong == 0, "%s: %zu values are wrong", head, wrong);
}

static void test_rgbe_storage(size_t width, size_t height) {
    static const char *const axes[] = {"-Y+X", "-Y-X", "+Y+X", "+Y-X", "-X+Y", "-X-Y", "+X+Y", "+X-Y"};
    static file made;
    unsigned char *pixels = malloc(4 * width * height);
    for (int storage = 0; storage < STORAGES; storage++)
        for (size_t a = 0; a < 8; a++) {
            bool columns = axes[a][1] == 'X';
            size_t scanlines = columns ? width : height, length = columns ? height : width;
            char head[200];
            if (storage == NEW && length < 8) continue;
            fill_rgbe(pixels, width * height);
            snprintf(head, sizeof head, "#?RGBE\nrpict -vp 0 0 0\nFORMAT=32-bit_rle_rgbe\n\n%c%c %zu %c%c %zu\n",
                     axes[a][0], axes[a][1], scanlines, axes[a][2], axes[a][3], length);
            made.size = 0;
            add_text(&made, head);
            for (size_t i = 0; i < scanlines; i++)
                add_scanline(&made, storage, pixels + 4 * i * length, length);
            for (int backwards = 0; backwards < 2; backwards++) {
                image image;
                hdr_error error;
                CHECK(read_bytes(made.bytes, made.size, backwards, &image, &error) == HDR_OK, "%s: %s", head,
                      error.message);
                CHECK(image.width == width && image.height == height, "%s: the size is wrong", head);
                if (!error.status) compare_rgbe(head, &image, pixels, axes[a], 1);
                image_free(&image);
            }
        }
    free(pixels);
}

static void test_rgbe_variables(void) {
    static const char head[] =
        "#?RADIANCE\nEXPOSURE=2\nPRIMARIES= .7 .3 .2 .7 .1 .05 .31 .33\n oddly EXPOSURE=9\n"
        "EXPOSURE= 6.0e0\nEXPOSURE=-3\nEXPOSURE=0\nCOLORCORR=2 1 0.5\nCOLORCORR= 4\t1 1 \n"
        "COLORCORR=1 2\nCOLORCORR=2 0 2\nCOLORCORR=3 3 1e999\nPIXASPECT=0.5\nFORMAT=32-bit_rle_rgbe\n\n"
        "-Y 1 +X 2\n\x80\x40\x01\x81\xff\x00\x80\xff";
    image image;
    hdr_error error;
    CHECK(read_bytes(head, sizeof head - 1, false, &image, &error) == HDR_OK, "%s", error.message);
    if (error.status) return;
    const hdr_chromaticities *c = &image.about.chromaticities;
    CHECK(image.about.has_chromaticities && c->red[0] == 0.7 && c->blue[1] == 0.05 && c->white[1] == 0.33, "primaries");
    CHECK(image.about.pixel_aspect == 2, "Radiance's pixel aspect is height over width");
    CHECK(image.plane[0][0] == (float)(1.0 / 12 / 8) && image.plane[1][0] == (float)(0.5 / 12) &&
              image.plane[2][0] == (float)(1.0 / 128 / 12 / 0.5),
          "exposure and colour correction");
    CHECK(image.plane[0][1] == (float)(ldexp(255, 119) / 12 / 8) && image.plane[1][1] == 0, "the largest exponent");
    image_free(&image);
}

static void test_rgbe_xyz(void) {
    static const char xyz[] = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\nPRIMARIES=.6 .3 .2 .7 .1 .05 .31 .33\n\n"
                              "-Y 1 +X 1\n\x80\x80\x80\x81";
    image image;
    hdr_error error;
    CHECK(read_bytes(xyz, sizeof xyz - 1, false, &image, &error) == HDR_OK, "%s", error.message);
    CHECK(!hdr_chromaticities_differ(&image.about.chromaticities, &hdr_cie_xyz) && image.about.has_chromaticities &&
              !strcmp(image.about.channels[2].name, "Z"),
          "XYZ");
    image_free(&image);
}

/* A count of two bytes, 255 + 2 * 256, of which the row has room for 699. */
static void test_rgbe_repetition(void) {
    static const char text[] = "#?RGBE\n\n-Y 2 +X 700\n\x80\1\1\x81\1\1\1\xff\1\1\1\2\x90\1\1\x81\1\1\1\xbb\1\1\1\2";
    image image;
    hdr_error error;
    CHECK(read_bytes(text, sizeof text - 1, false, &image, &error) == HDR_OK, "%s", error.message);
    CHECK(error.status || (image.plane[0][699] == 1 && image.plane[0][700] == 1.125f && image.plane[0][1399] == 1.125f),
          "repetitions");
    image_free(&image);
}

int main(void) {
    test_rgbe_storage(5, 35);
    test_rgbe_storage(11, 32);
    test_rgbe_storage(300, 17);
    test_rgbe_storage(1, 1);
    test_rgbe_variables();
    test_rgbe_xyz();
    test_rgbe_repetition();
    return check_done("test_rgbe");
}

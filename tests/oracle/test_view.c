/* What SSIM and FLIP see of a file: its data window, whatever its display window is, over black. */
#include "check.h"
#include "oracle_renders.h"

#include <string.h>

enum { WIDTH = 90, HEIGHT = 70 };

static double noisy(int picture, size_t at) {
    return fabs(sin((double)at * 0.01)) * (picture ? 0.8 : 1) + 0.2 * random_unit();
}

/* The picture as a file with that display window: it is written with another one, which is overwritten. */
static unsigned char *file_of(const pictures *p, int i, const int window[4], size_t *size) {
    static const char label[] = "displayWindow\0box2i\0\020\0\0";
    static const char *const words[] = {"exr", "--compression", "none"};
    hdr_error error = {0};
    hdr_input *input = open_picture(p, i);
    hdr_output *output = hdr_output_memory(&error);
    hdr_chain *chain = hdr_chain_new(&error);
    hdr_chain_parse(chain, 3, words, &error);
    CHECK(hdr_chain_run(chain, input, output, NULL, &error) == HDR_OK, "a file: %s", error.message);
    const void *bytes = hdr_output_bytes(output, size);
    unsigned char *file = malloc(*size), *at = file;
    if (!file) abort();
    memcpy(file, bytes, *size);
    while (at + sizeof label < file + *size && memcmp(at, label, sizeof label) != 0)
        at++;
    CHECK(at + sizeof label < file + *size, "there is no display window");
    for (size_t b = 0; b < 16; b++)
        at[sizeof label + b] = (unsigned char)((unsigned)window[b / 4] >> b % 4 * 8);
    hdr_output_free(output);
    hdr_input_free(input);
    hdr_chain_free(chain);
    return file;
}

typedef struct figures {
    double ssim, flip;
    int width, height, x, y;
} figures;

static figures figures_of(hdr_input *test, hdr_input *reference, int count, const char *const words[]) {
    hdr_error error = {0};
    figures f = {.ssim = -2};
    hdr_flip flip = {0};
    hdr_chain *chain = hdr_chain_new(&error);
    hdr_chain_parse(chain, count, words, &error);
    hdr_structure *structure = hdr_structure_new(chain, reference, &error);
    if (structure) hdr_structure_compare(structure, test, &f.ssim, &error);
    hdr_flip_reference *prepared = hdr_flip_prepare(chain, reference, HDR_FLIP_AUTO, 67, 1, &error);
    if (prepared) hdr_flip_compare(prepared, test, false, &flip, &error);
    CHECK(error.status == HDR_OK, "figures: %s", error.message);
    f = (figures){f.ssim, flip.mean, flip.width, flip.height, flip.max_x, flip.max_y};
    hdr_flip_free(&flip);
    hdr_flip_reference_free(prepared);
    hdr_structure_free(structure);
    hdr_chain_free(chain);
    return f;
}

static void test_windows(void) {
    static const int windows[][4] = {{0, 0, 19, 29}, {-40, -30, 200, 150}, {10, 20, 300, 40}};
    static const char *const words[] = {"stats", "--window", "display"};
    pictures p = make_pictures(WIDTH, HEIGHT, 3, 2, noisy);
    hdr_input *test = open_picture(&p, 0), *reference = open_picture(&p, 1);
    figures plain = figures_of(test, reference, 1, words);
    CHECK(plain.flip > 0 && plain.ssim < 1, "the pictures differ");
    for (size_t w = 0; w < sizeof windows / sizeof *windows; w++)
        for (int count = 1; count <= 3; count += 2) {
            hdr_error error = {0};
            hdr_input *input[2];
            unsigned char *file[2];
            for (int i = 0; i < 2; i++) {
                size_t size = 0;
                file[i] = file_of(&p, i, windows[w], &size);
                input[i] = hdr_input_memory(file[i], size, "windowed", &error);
            }
            figures f = figures_of(input[0], input[1], count, words);
            CHECK(f.width == WIDTH && f.height == HEIGHT, "FLIP is of %d x %d pixels", f.width, f.height);
            CHECK(f.flip == plain.flip && f.x == plain.x && f.y == plain.y,
                  "FLIP is %g at %d,%d, should be %g at %d,%d", f.flip, f.x, f.y, plain.flip, plain.x, plain.y);
            CHECK(f.ssim == plain.ssim, "SSIM is %g, should be %g", f.ssim, plain.ssim);
            for (int i = 0; i < 2; i++) {
                hdr_input_free(input[i]);
                free(file[i]);
            }
        }
    hdr_input_free(test);
    hdr_input_free(reference);
    free_pictures(&p);
}

/* What covers half of what it might, and what has no alpha: the same numbers are the same light. */
static void test_alpha(void) {
    static const char *const words[] = {"stats", "--alpha", "over:1,1,1"};
    static float cover[WIDTH * HEIGHT];
    for (size_t i = 0; i < WIDTH * HEIGHT; i++)
        cover[i] = 0.5F;
    pictures p = make_pictures(WIDTH, HEIGHT, 3, 1, noisy);
    const float *plane[3] = {p.numbers[0], p.numbers[0] + pixels_of(&p), p.numbers[0] + 2 * pixels_of(&p)};
    hdr_error error = {0};
    hdr_input *covering = hdr_input_planes(WIDTH, HEIGHT, 3, plane, cover, &error), *opaque = open_picture(&p, 0);
    figures black = figures_of(covering, opaque, 1, words), white = figures_of(covering, opaque, 3, words);
    CHECK(black.flip == 0 && fabs(black.ssim - 1) < 1e-12, "over black: FLIP %g, SSIM %g", black.flip, black.ssim);
    CHECK(white.flip > 0 && white.ssim < 1, "over white: FLIP %g, SSIM %g", white.flip, white.ssim);
    hdr_input_free(covering);
    hdr_input_free(opaque);
    free_pictures(&p);
}

int main(void) {
    test_windows();
    test_alpha();
    return check_done("test_view");
}

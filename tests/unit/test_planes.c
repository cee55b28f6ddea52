/* Pixels in memory, in and out. */
#include "check.h"
#include "hdrpipe.h"

#include <stdlib.h>
#include <string.h>

enum { WIDTH = 37, HEIGHT = 45, PIXELS = WIDTH * HEIGHT };

static float numbers[4][PIXELS];

static void fill(void) {
    for (int c = 0; c < 4; c++)
        for (int i = 0; i < PIXELS; i++)
            numbers[c][i] = c == 3 ? 0.25f * (float)(1 + i % 4) : (float)((i * 7 + c * 131) % 1000) * 0.0625f;
}

/* The clauses, which may be none, of an input; NULL where that fails. */
static hdr_output *run(hdr_input *input, int count, const char *const words[], hdr_error *error) {
    hdr_chain *chain = hdr_chain_new(error);
    hdr_output *output = hdr_output_planes(error);
    if (count > 0) hdr_chain_parse(chain, count, words, error);
    CHECK(!hdr_output_pixels(output), "pixels before anything has run");
    hdr_status status = error->status ? error->status : hdr_chain_run(chain, input, output, NULL, error);
    hdr_chain_free(chain);
    if (status == HDR_OK) return output;
    CHECK(!hdr_output_pixels(output), "pixels of a run that failed");
    hdr_output_free(output);
    return NULL;
}

static hdr_input *open_planes(int planes, bool alpha) {
    hdr_error error = {0};
    return hdr_input_planes(WIDTH, HEIGHT, planes, (const float *const[3]){numbers[0], numbers[1], numbers[2]},
                            alpha ? numbers[3] : NULL, &error);
}

/* They come out as they went in, whatever number of threads carried them. */
static void test_there_and_back(void) {
    static const char *const threads[] = {"stats", "-j", "3"};
    for (int form = 0; form < 8; form++) {
        int planes = form & 1 ? 3 : 1;
        bool alpha = form & 2;
        hdr_error error = {0};
        hdr_input *input = open_planes(planes, alpha);
        hdr_chain *chain = hdr_chain_new(&error), *like = NULL;
        if (form & 4) hdr_chain_parse(chain, 3, threads, &error);
        like = hdr_chain_new_like(chain, &error);
        hdr_output *output = hdr_output_planes(&error);
        hdr_chain_run(like, input, output, NULL, &error);
        const hdr_planes *pixels = hdr_output_pixels(output);
        CHECK(pixels != NULL, "%d planes: %s", planes, error.message);
        if (pixels) {
            CHECK(pixels->width == WIDTH && pixels->height == HEIGHT && pixels->planes == planes, "another form");
            for (int c = 0; c < planes; c++)
                CHECK(!memcmp(pixels->plane[c], numbers[c], sizeof numbers[c]), "plane %d of %d", c, planes);
            CHECK((pixels->alpha != NULL) == alpha, "%d planes: alpha", planes);
            if (pixels->alpha) CHECK(!memcmp(pixels->alpha, numbers[3], sizeof numbers[3]), "alpha's numbers");
        }
        hdr_output_free(output);
        hdr_chain_free(like);
        hdr_chain_free(chain);
        hdr_input_free(input);
    }
}

/* The chain's filters count, its format does not; a program makes no picture. */
static void test_chains(void) {
    static const char *const expose[] = {"expose", "--ev", "1"}, *const stats[] = {"stats"};
    static const char *const png[] = {"expose", "--ev", "1", "then", "png"};
    for (int formatted = 0; formatted < 2; formatted++) {
        hdr_error error = {0};
        hdr_input *input = open_planes(3, false);
        hdr_output *output = formatted ? run(input, 5, png, &error) : run(input, 3, expose, &error);
        const hdr_planes *pixels = output ? hdr_output_pixels(output) : NULL;
        CHECK(pixels != NULL, "%s", error.message);
        int wrong = 0;
        for (int i = 0; pixels && i < PIXELS; i++)
            wrong += pixels->plane[1][i] != 2 * numbers[1][i];
        CHECK(wrong == 0, "%d pixels are not twice what they were", wrong);
        hdr_output_free(output);
        hdr_input_free(input);
    }
    hdr_error error = {0};
    hdr_input *input = open_planes(1, false);
    CHECK(!run(input, 1, stats, &error) && error.status == HDR_USAGE, "a program: %s", error.message);
    hdr_input_free(input);
}

/* An alpha of 1 everywhere is none. */
static void test_opaque(void) {
    static float ones[PIXELS];
    for (int i = 0; i < PIXELS; i++)
        ones[i] = 1;
    hdr_error error = {0};
    hdr_input *input = hdr_input_planes(WIDTH, HEIGHT, 1, (const float *const[3]){numbers[0]}, ones, &error);
    hdr_output *output = run(input, 0, NULL, &error);
    const hdr_planes *pixels = output ? hdr_output_pixels(output) : NULL;
    CHECK(pixels && !pixels->alpha, "an alpha that is 1 everywhere");
    hdr_output_free(output);
    hdr_input_free(input);
}

int main(void) {
    fill();
    test_there_and_back();
    test_chains();
    test_opaque();
    return check_done("test_planes");
}

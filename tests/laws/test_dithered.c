/* Dithered codes of pictures: their means, their ends, and that they depend on nothing but values and places. */
#include "laws_pictures.h"

#include <limits.h>

static const char *const kinds[] = {"ordered", "blue"};
static const hdr_dither_kind kind_numbers[] = {HDR_DITHER_ORDERED, HDR_DITHER_BLUE};
enum { KINDS = 2, TILE = 64, LEVELS = 4096, STRIPE = 256 /* levels in a picture */ };

/* ---- Means ---- */

/* Tiles of one value each, 0 to 1 in 4096 steps: the mean of a tile's codes is the value within 1/8192 of a code, and
 * each code is one of the two beside it. */
static void test_means(void) {
    static const int bits[] = {8, 8, 1, 4, 16};
    law_picture stripe = law_new_picture("levels", TILE, TILE * STRIPE, 1, false);
    for (int k = 0; k < KINDS; k++)
        for (size_t b = 0; b < sizeof bits / sizeof *bits; b++) {
            double farthest = 0, top = ldexp(1, bits[b]) - 1;
            size_t apart = 0;
            char chain[100];
            snprintf(chain, sizeof chain, "quantise --bits %d --dither %s --seed %zu", bits[b], kinds[k], b);
            for (int first = 0; first < LEVELS; first += bits[b] == 8 ? STRIPE : 4 * STRIPE) {
                for (size_t i = 0; i < law_pixels(&stripe); i++)
                    stripe.plane[0][i] = (float)(first + (int)i / TILE / TILE) / (LEVELS - 1);
                law_codes codes = law_codes_of(&stripe, chain, "");
                double scale = top / (bits[b] <= 8 ? 255 : 65535); /* of a sample */
                for (size_t level = 0; level < STRIPE && codes.count == law_pixels(&stripe); level++) {
                    double sum = 0, value = (double)stripe.plane[0][level * TILE * TILE] * top;
                    for (size_t i = level * TILE * TILE; i < (level + 1) * TILE * TILE; i++) {
                        double code = round(codes.code[i] * scale);
                        sum += code;
                        apart += !(fabs(code - value) < 1);
                    }
                    farthest = fmax(farthest, fabs(sum / (TILE * TILE) - value));
                }
                CHECK(codes.count == law_pixels(&stripe), "%s: no codes", chain);
                free(codes.code);
            }
            fprintf(stderr, "%s: the mean of a tile is at most %.6f codes off\n", chain, farthest);
            CHECK(farthest <= 1.0 / 8192 + 1e-9, "%s: a mean is %g codes off", chain, farthest);
            CHECK(apart == 0, "%s: %zu codes are 1 or more from their value", chain, apart);
        }
    law_free_picture(&stripe);
}

static void test_ends(void) {
    static const float values[] = {0, 1, 1.5f, -0.25f, -0.0f, 1e30f, -1e30f, 0x1p-149f};
    law_picture flat = law_new_picture("flat", 3 * TILE, 2 * TILE, 3, false);
    for (int k = 0; k < KINDS; k++)
        for (size_t v = 0; v < sizeof values / sizeof *values; v++)
            for (int wide = 0; wide < 2; wide++) {
                law_fill_constant(&flat, values[v]);
                char rest[100];
                snprintf(rest, sizeof rest, "--bits %d --dither %s", wide ? 16 : 8, kinds[k]);
                law_codes codes = law_codes_of(&flat, "gamma -g 1", rest);
                int expected = values[v] >= 1 ? wide ? 65535 : 255 : 0;
                size_t wrong = codes.count == 0;
                for (size_t i = 0; i < codes.count; i++)
                    wrong += codes.code[i] != expected;
                CHECK(wrong == 0, "png %s: %zu pixels of %g are not %d", rest, wrong, (double)values[v], expected);
                free(codes.code);
            }
    law_free_picture(&flat);
}

/* Whole codes stay what they are, as float32 has them: there is no noise to be had where there is nothing to hide. */
static void test_whole(void) {
    law_picture codes = law_new_picture("codes", TILE, 256, 1, false);
    for (size_t i = 0; i < law_pixels(&codes); i++)
        codes.plane[0][i] = (float)(i / TILE) / 255;
    for (int k = 0; k < KINDS; k++)
        for (int seed = 1; seed < 20; seed++) {
            char chain[60];
            snprintf(chain, sizeof chain, "quantise --dither %s --seed %d", kinds[k], seed);
            law_codes got = law_codes_of(&codes, chain, "");
            size_t wrong = got.count != law_pixels(&codes);
            for (size_t i = 0; !wrong && i < got.count; i++)
                wrong += got.code[i] != i / TILE;
            CHECK(wrong == 0, "%s: a whole code is not kept", chain);
            free(got.code);
        }
    law_free_picture(&codes);
}

/* ---- Values and places ---- */

/* A picture of shades from black to white, with noise. */
static law_picture make_shades(int planes, bool alpha) {
    law_picture shades = law_new_picture("shades", 700, 90, planes, alpha);
    for (int p = 0; p < planes; p++)
        for (size_t i = 0; i < law_pixels(&shades); i++)
            shades.plane[p][i] = (float)((double)(i % 700) / 700 * law_random_unit());
    for (size_t i = 0; alpha && i < law_pixels(&shades); i++)
        shades.alpha[i] = (float)(i % 90) / 89;
    return shades;
}

/* C rounded by the threshold of its place, as SPEC has it. */
static int expected_code(double encoded, const hdr_dither *dither, int x, int y, double top) {
    return (int)floor(fmin(fmax(encoded, 0), 1) * top + hdr_dither_threshold(dither, x, y));
}

static void test_codes(void) {
    law_picture shades = make_shades(3, false);
    for (int k = 0; k < KINDS; k++)
        for (uint32_t seed = 0; seed < 2000000000; seed += 999999937) {
            char chain[100];
            hdr_dither dither = hdr_dither_seeded(kind_numbers[k], seed);
            snprintf(chain, sizeof chain, "quantise --bits 8 --dither %s --seed %u", kinds[k], seed);
            law_codes codes = law_codes_of(&shades, chain, "");
            size_t wrong = codes.count != 3 * law_pixels(&shades);
            for (size_t i = 0; i < codes.count && !wrong; i++) {
                size_t pixel = i / 3;
                wrong += codes.code[i] != expected_code((double)shades.plane[i % 3][pixel], &dither, (int)(pixel % 700),
                                                        (int)(pixel / 700), 255);
            }
            CHECK(wrong == 0, "%s: codes are not what value and place give", chain);
            free(codes.code);
        }
    law_free_picture(&shades);
}

/* Grey stays grey: three equal channels have the codes of one. */
static void test_grey(void) {
    law_picture one = make_shades(1, false);
    law_picture three = law_new_picture("grey but for a pixel", one.width, one.height, 3, false);
    memcpy(three.plane[0], one.plane[0], law_pixels(&one) * sizeof(float));
    law_make_grey(&three);
    three.plane[1][law_pixels(&one) - 1] += 0.5f;
    for (int k = 0; k < KINDS; k++) {
        char rest[40];
        snprintf(rest, sizeof rest, "--dither %s", kinds[k]);
        law_codes single = law_codes_of(&one, "srgb", rest), triple = law_codes_of(&three, "srgb", rest);
        size_t wrong = single.count != law_pixels(&one) || triple.count != 3 * law_pixels(&one);
        for (size_t i = 0; !wrong && i + 3 < triple.count; i++)
            wrong += triple.code[i] != single.code[i / 3];
        CHECK(wrong == 0, "png %s: grey in three channels is not what it is in one", rest);
        free(single.code);
        free(triple.code);
    }
    law_free_picture(&one);
    law_free_picture(&three);
}

static void test_alpha(void) {
    law_picture shades = make_shades(3, true);
    law_codes plain = law_codes_of(&shades, "srgb", ""), dithered = law_codes_of(&shades, "srgb", "--dither blue");
    size_t wrong = plain.count != 4 * law_pixels(&shades) || dithered.count != plain.count, changed = 0;
    for (size_t i = 0; !wrong && i < plain.count; i++) {
        changed += i % 4 != 3 && plain.code[i] != dithered.code[i];
        wrong += i % 4 == 3 && plain.code[i] != dithered.code[i];
    }
    CHECK(wrong == 0 && changed > 0, "alpha is dithered, or nothing is");
    free(plain.code);
    free(dithered.code);
    law_free_picture(&shades);
}

/* A piece has the codes that the whole has there; also of a data window that does not begin at 0,0. */
static void test_pieces(void) {
    static const int pieces[][4] = {
        {0, 0, 700, 90}, {1, 1, 600, 89}, {63, 17, 64, 64}, {650, 80, 50, 10}, {699, 0, 1, 90}};
    law_picture shades = make_shades(3, false);
    for (int k = 0; k < KINDS; k++) {
        char rest[100];
        snprintf(rest, sizeof rest, "--dither %s --seed 5", kinds[k]);
        law_codes whole = law_codes_of(&shades, "srgb", rest);
        for (size_t p = 0; p < sizeof pieces / sizeof *pieces; p++) {
            const int *piece = pieces[p];
            snprintf(rest, sizeof rest, "--dither %s --seed 5 --crop %d,%d,%d,%d", kinds[k], piece[0], piece[1],
                     piece[2], piece[3]);
            law_codes part = law_codes_of(&shades, "srgb", rest);
            size_t row = (size_t)piece[2] * 3, wrong = part.count != row * (size_t)piece[3];
            for (size_t i = 0; !wrong && i < part.count; i++)
                wrong +=
                    part.code[i] != whole.code[(i / row + (size_t)piece[1]) * 2100 + i % row + (size_t)piece[0] * 3];
            CHECK(wrong == 0, "png %s: not a piece of the whole", rest);
            free(part.code);
        }
        free(whole.code);
    }
    law_free_picture(&shades);
}

/* testdata/tiny/window.exr: display window (0,0)-(11,7), data window (-2,1)-(8,9). */
static void test_windows(void) {
    enum { WIDTH = 12, HEIGHT = 8, LEFT = -2, TOP = 1, RIGHT = 8, DATA_WIDTH = 11 };
    static const double colour[3] = {0.3, 0.41, 0.52};
    const law_picture file = {.path = "testdata/tiny/window.exr"};
    for (int k = 0; k < KINDS; k++) {
        hdr_dither dither = hdr_dither_seeded(kind_numbers[k], 0);
        char rest[100];
        snprintf(rest, sizeof rest, "--bits 8 --dither %s --window data", kinds[k]);
        law_codes data = law_codes_of(&file, "gamma -g 1", rest);
        snprintf(rest, sizeof rest, "--bits 8 --dither %s --alpha over:0.3,0.41,0.52", kinds[k]);
        law_codes shown = law_codes_of(&file, "gamma -g 1", rest);
        size_t wrong = shown.count != 3 * WIDTH * HEIGHT, beside = 0;
        for (int i = 0; !wrong && i < 3 * WIDTH * HEIGHT; i++) {
            int x = i / 3 % WIDTH, y = i / 3 / WIDTH;
            bool inside = x <= RIGHT && y >= TOP;
            int code = inside ? data.code[((y - TOP) * DATA_WIDTH + x - LEFT) * 3 + i % 3]
                              : expected_code(colour[i % 3], &dither, x, y, 255);
            wrong += shown.code[i] != code;
            beside += !inside;
        }
        CHECK(wrong == 0 && beside == 3 * (3 * 8 + 9), "%s: a border of a colour is not dithered by its place",
              kinds[k]);
        free(data.code);
        free(shown.code);
    }
}

/* ---- Settings ---- */

static void test_settings(void) {
    static const char *const settings[] = {"-j 2", "-j 5", "-j 1 --reference", "-j 1 --no-skip", "-j 2 --memory 1M"};
    static const char *const formats[] = {"--bits 8", "--bits 16"};
    law_picture pictures[] = {make_shades(3, false), make_shades(1, false), make_shades(3, true)};
    for (size_t p = 0; p < 3; p++)
        for (int k = 0; k < KINDS; k++)
            for (int f = 0; f < 2; f++) {
                law_result base = law_run(&pictures[p], "png %s --dither %s --seed 9 -j 1", formats[f], kinds[k]);
                CHECK(base.status == HDR_OK, "png --dither %s: %s", kinds[k], base.message);
                for (size_t s = 0; s < sizeof settings / sizeof *settings; s++) {
                    law_result other =
                        law_run(&pictures[p], "png %s --dither %s --seed 9 %s", formats[f], kinds[k], settings[s]);
                    CHECK(law_same(&base, &other), "png %s --dither %s %s: other bytes", formats[f], kinds[k],
                          settings[s]);
                    free(other.bytes);
                }
                law_result clauses =
                    law_run(&pictures[p], "srgb then quantise %s --dither %s --seed 9 then png", formats[f], kinds[k]);
                CHECK(law_same(&base, &clauses), "png %s --dither %s: not what quantise makes", formats[f], kinds[k]);
                free(clauses.bytes);
                free(base.bytes);
            }
    for (size_t p = 0; p < 3; p++)
        law_free_picture(&pictures[p]);
}

static void test_refusals(void) {
    static const char *const refused[] = {"quantise then png --dither blue",
                                          "srgb then quantise --bits 5 then png --dither ordered",
                                          "quantise --dither blue then png --dither blue",
                                          "png --seed 3",
                                          "quantise --seed 0",
                                          "quantise --dither none --seed 3",
                                          "png --dither none --seed 3"};
    law_picture one = law_new_picture("one", 4, 4, 1, false);
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        law_result result = law_run(&one, "%s", refused[i]);
        CHECK(result.status == HDR_USAGE && !strchr(result.message, '\n'), "%s: status %d, %s", refused[i],
              (int)result.status, result.message);
        free(result.bytes);
    }
    law_result none = law_run(&one, "quantise then png --dither none");
    CHECK(none.status == HDR_OK, "--dither none after quantise: %s", none.message);
    free(none.bytes);
    law_free_picture(&one);
}

/* ---- What the eye sees ---- */

enum { GRADIENT = 256, REACH = 8 };

/* Root mean square of the codes' error behind a Gaussian of 2 pixels, which stands for the eye, away from the border.
 */
static double seen_error(const double *error) {
    double weight[2 * REACH + 1], sum = 0, squares = 0;
    static double across[GRADIENT * GRADIENT];
    int count = 0;
    for (int i = -REACH; i <= REACH; i++)
        sum += weight[i + REACH] = exp(-i * i / 8.0);
    for (int y = 0; y < GRADIENT; y++)
        for (int x = REACH; x < GRADIENT - REACH; x++) {
            across[y * GRADIENT + x] = 0;
            for (int i = -REACH; i <= REACH; i++)
                across[y * GRADIENT + x] += weight[i + REACH] / sum * error[y * GRADIENT + x + i];
        }
    for (int y = REACH; y < GRADIENT - REACH; y++)
        for (int x = REACH; x < GRADIENT - REACH; x++, count++) {
            double value = 0;
            for (int i = -REACH; i <= REACH; i++)
                value += weight[i + REACH] / sum * across[(y + i) * GRADIENT + x];
            squares += value * value;
        }
    return sqrt(squares / count);
}

/* A smooth gradient over two codes: rounded it has bands; by blue noise the eye sees the least of the noise that dither
 * puts in their place, white noise being what any thresholds give. */
static void test_gradient(void) {
    static const char *const ways[] = {"none", "ordered", "blue"};
    law_picture gradient = law_new_picture("gradient", GRADIENT, GRADIENT, 1, false);
    static double error[GRADIENT * GRADIENT];
    double seen[4];
    for (size_t i = 0; i < law_pixels(&gradient); i++)
        gradient.plane[0][i] = (float)((3 + (double)(i % GRADIENT + i / GRADIENT) / GRADIENT) / 255);
    for (int w = 0; w < 3; w++) {
        char chain[40];
        snprintf(chain, sizeof chain, "quantise --dither %s", ways[w]);
        if (w == 0) snprintf(chain, sizeof chain, "quantise");
        law_codes codes = law_codes_of(&gradient, chain, "");
        for (size_t i = 0; i < codes.count; i++)
            error[i] = codes.code[i] - 255 * (double)gradient.plane[0][i];
        seen[w] = seen_error(error);
        free(codes.code);
    }
    for (size_t i = 0; i < law_pixels(&gradient); i++) {
        double value = 255 * (double)gradient.plane[0][i];
        error[i] = floor(value + law_random_unit()) - value;
    }
    seen[3] = seen_error(error);
    fprintf(stderr,
            "error behind a Gaussian of 2 pixels, in codes: rounded %.4f, ordered %.4f, blue %.4f, white %.4f\n",
            seen[0], seen[1], seen[2], seen[3]);
    CHECK(seen[2] < seen[3] / 4 && seen[2] < seen[0] / 4, "blue noise is seen as %g, white as %g, bands as %g", seen[2],
          seen[3], seen[0]);
    law_free_picture(&gradient);
}

int main(void) {
    test_means();
    test_ends();
    test_whole();
    test_codes();
    test_grey();
    test_alpha();
    test_pieces();
    test_windows();
    test_settings();
    test_refusals();
    test_gradient();
    return check_done("test_dithered");
}

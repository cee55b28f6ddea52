/* PFM, Radiance HDR and PFS: read what is made here by hand (Radiance HDR in test_rgbe.c), write and read back, and go
 * through files that are damaged. */
#include "picture/colour.h"
#include "raster_make.h"

#include <float.h>
#include <math.h>
#include <sys/resource.h>
#include <time.h>

/* ---- PFM ---- */

static float pfm_value(size_t x, size_t y, size_t c) {
    return (float)x + 100 * (float)y + 0.25f * (float)c - 3;
}

static void test_pfm(void) {
    static const char *const heads[] = {"P%c\n%zu %zu\n%s\n", "P%c %zu\n%zu %s ", "P%c\n%zu\n%zu\n%s\t",
                                        "P%c\r\n%zu %zu\r\n%s\r\n"};
    static file made;
    for (unsigned variant = 0; variant < 64; variant++) {
        bool big = variant & 1, grey = variant & 2;
        size_t width = variant & 4 ? 1 : 13, height = 37;
        char head[64];
        made.size = 0;
        snprintf(head, sizeof head, heads[variant / 16], grey ? 'f' : 'F', width, height, big ? "2.5" : "-1e3");
        add_text(&made, head);
        for (size_t y = height; y-- > 0;)
            for (size_t x = 0; x < width; x++)
                for (size_t c = 0; c < (grey ? 1 : 3); c++)
                    add_float(&made, pfm_value(x, y, c), big);
        image image;
        hdr_error error;
        CHECK(read_bytes(made.bytes, made.size, variant & 8, &image, &error) == HDR_OK, "%s: %s", head, error.message);
        CHECK(image.about.planes == (grey ? 1 : 3) && !strcmp(image.about.format, "pfm") && image.width == width &&
                  image.height == height && !image.about.has_chromaticities,
              "%s: not as described", head);
        size_t wrong = 0;
        for (size_t i = 0; error.status == HDR_OK && i < width * height; i++)
            for (size_t c = 0; c < (grey ? 1 : 3); c++)
                wrong += image.plane[c][i] != pfm_value(i % width, i / width, c);
        CHECK(wrong == 0, "%s: %zu values are wrong", head, wrong);
        image_free(&image);
    }
}

/* ---- What is refused ---- */

static void test_refused(void) {
    static const struct {
        const char *text, *word;
    } refused[] = {
        {"#?RADIANCE\nFORMAT=Radiance_octree\n\n-Y 1 +X 1\n1234", "FORMAT"},
        {"#?RADIANCE\n\n-Y 1 +Y 1\n1234", "resolution"},
        {"#?RADIANCE\n\n-Y 0 +X 1\n1234", "resolution"},
        {"#?RADIANCE\n\n-Y 1 +X 1 x\n1234", "resolution"},
        {"#?RADIANCE\n\n-Y 1 +X 2147483648\n1234", "resolution"},
        {"#?RADIANCE\nPRIMARIES=1 2 3\n\n-Y 1 +X 1\n1234", "PRIMARIES"},
        {"#?RADIANCE\nEXPOSURE=1e300\nEXPOSURE=1e300\n\n-Y 1 +X 1\n1234", "EXPOSURE"},
        {"#?RADIANCE\nCOLORCORR=1 1e200 1\nCOLORCORR=1 1e200 1\n\n-Y 1 +X 1\n1234", "COLORCORR"},
        {"#?RADIANCE\n\n-Y 1 +X 2\n\1\1\1\2", "row 0"},
        {"#?RADIANCE\n\n-Y 1 +X 8\n\2\2\xff\3\1", "row 0"},
        {"#?RADIANCE\n\n-Y 2 +X 1\n12341", "more than the file"},
        {"#?RADIANCE\n\n-Y 1 +X 9\n\2\2\1\1\x89\1", "row 0"},
        {"#?RADIANCE\n\n+X 1 +Y 8\n12341234", "column 0"},
        {"PF\n1 1\n0\n123412341234", "scale"},
        {"PF\n1 1\nx\n123412341234", "scale"},
        {"Pf\n1 1\n-1\r1234", "carriage return"},
        {"Pf\n1 1\n-1\r\n234", "before row 0"},
        {"Pf\r\n1 1\r\n-1\r\n1\r\n34", "too long by 1 byte"},
        {"PF\n0 1\n1\n123412341234", "no pixels"},
        {"Pf\n1 3\n1\n12341234123", "before row 0"},
        {"PFS1\n1 1\n1\n0\nDEPTH\n0\nENDH1234", "neither"},
        {"PFS1\n1 1\n1\n0\nY\n0\nENDX1234", "ENDH"},
        {"PFS1\n1 1\n1\n1\nTAG\nY\n0\nENDH1234", "NAME=VALUE"},
        {"PFS1\n70000 1\n1\n0\nY\n0\nENDH1234", "65535"},
        {"PFS1\n1 1\n2\n0\nY\n0\nY\n0\nENDH12341234", "one name"},
        {"PFS1\n1 1\n1\n0\nY\n0\nENDH123", "row 0"},
    };
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        image image;
        hdr_error error;
        CHECK(read_bytes(refused[i].text, strlen(refused[i].text), false, &image, &error) == HDR_BAD_DATA &&
                  strstr(error.message, refused[i].word),
              "case %zu: %d %s", i, error.status, error.message);
        CHECK(strncmp(error.message, "memory: ", 8) == 0, "the message does not begin with the name: %s",
              error.message);
        image_free(&image);
    }
}

/* ---- Writing and reading back ---- */

/* What a chain of these words makes of planes, or NULL. */
static hdr_output *write_planes(int width, int height, int planes, const float *const plane[3], const float *alpha,
                                const char *words, hdr_error *error) {
    char text[200];
    const char *word[10];
    int count = 0;
    snprintf(text, sizeof text, "%s -j 2 -q", words);
    for (char *at = strtok(text, " "); at && count < 10; at = strtok(NULL, " "))
        word[count++] = at;
    hdr_chain *chain = hdr_chain_new(error);
    hdr_input *input = hdr_input_planes(width, height, planes, plane, alpha, error);
    hdr_output *output = hdr_output_memory(error);
    hdr_status status = hdr_chain_parse(chain, count, word, error);
    if (!status) status = hdr_chain_run(chain, input, output, NULL, error);
    CHECK(status == HDR_OK, "%s, %d x %d: %s", words, width, height, error->message);
    hdr_input_free(input);
    hdr_chain_free(chain);
    if (status == HDR_OK) return output;
    hdr_output_free(output);
    return NULL;
}

static float random_light(void) {
    uint64_t bits = random_bits();
    if (bits % 16 == 0) return 0;
    float value = ldexpf((float)(bits >> 40) + 1, (int)(bits >> 8 & 255) % 240 - 144);
    return bits % 16 == 1 ? -value : value;
}

/* Half a step is 2^(e - 9), where the largest component is below 2^e; plus what the format cannot hold. */
static void check_half_step(const image *image, const float *const plane[3], size_t count, int planes) {
    size_t wrong = 0;
    for (size_t i = 0; i < count; i++) {
        double largest = 0;
        int exponent = 0;
        for (int c = 0; c < planes; c++)
            largest = fmax(largest, (double)plane[c][i]);
        if (frexp(largest, &exponent) >= 255.5 / 256) exponent++; /* 255.5 steps would be rounded to 256 */
        for (int c = 0; c < 3; c++) {
            double value = fmax((double)plane[planes == 3 ? c : 0][i], 0);
            double error = fabs((double)image->plane[c][i] - value);
            bool black = largest < 0x1p-128 && image->plane[c][i] == 0;
            bool held = value > 0x1.fep126 && (double)image->plane[c][i] == 0x1.fep126;
            if (!black && !held && !(error <= ldexp(1, exponent - 9))) wrong++;
        }
    }
    CHECK(wrong == 0, "%zu components are off by more than half a step", wrong);
}

static void test_rgbe_round_trip(int width, int height, int planes) {
    size_t count = (size_t)width * (size_t)height;
    float *plane[3];
    for (int c = 0; c < 3; c++) {
        plane[c] = malloc(count * sizeof(float));
        for (size_t i = 0; i < count; i++)
            plane[c][i] = i % 7 == 3 && i > 0 ? plane[c][i - 1] : random_light();
    }
    if (count > 4) plane[0][1] = FLT_MAX, plane[0][2] = 255.75f, plane[0][4] = 0x1.fffffep-1f;
    const float *const in[3] = {plane[0], plane[1], plane[2]};
    hdr_error error = {.status = HDR_OK};
    hdr_output *output = write_planes(width, height, planes, in, NULL, "rgbe", &error);
    size_t size = 0, again_size = 0;
    const void *bytes = output ? hdr_output_bytes(output, &size) : NULL;
    image image;
    if (bytes && read_bytes(bytes, size, false, &image, &error) == HDR_OK) {
        check_half_step(&image, in, count, planes);
        CHECK(image.about.has_chromaticities && !hdr_chromaticities_differ(&image.about.chromaticities, &hdr_rec709),
              "no PRIMARIES");
        const float *const back[3] = {image.plane[0], image.plane[1], image.plane[2]};
        hdr_output *again = write_planes(width, height, 3, back, NULL, "rgbe", &error);
        const void *again_bytes = again ? hdr_output_bytes(again, &again_size) : NULL;
        CHECK(again_bytes && again_size == size && memcmp(again_bytes, bytes, size) == 0,
              "%d x %d: what was read is written otherwise", width, height);
        hdr_output_free(again);
        image_free(&image);
    }
    CHECK(error.status == HDR_OK, "%d x %d: %s", width, height, error.message);
    hdr_output_free(output);
    for (int c = 0; c < 3; c++)
        free(plane[c]);
}

/* Linear values come back from XYZ by the chain's own conversion. */
static void test_pfs_round_trip(int planes, bool with_alpha, const char *words, double tolerance) {
    enum { WIDTH = 21, HEIGHT = 40, COUNT = WIDTH * HEIGHT };
    static float plane[4][COUNT];
    for (int i = 0; i < COUNT; i++) {
        for (int c = 0; c < 3; c++)
            plane[c][i] = (float)(random_bits() >> 40) / 65536 - 16;
        plane[3][i] = i % 5 ? 1 : 0.5f;
    }
    const float *const in[3] = {plane[0], plane[1], plane[2]};
    hdr_error error = {.status = HDR_OK};
    hdr_output *output = write_planes(WIDTH, HEIGHT, planes, in, with_alpha ? plane[3] : NULL, words, &error);
    size_t size = 0, wrong = 0;
    const void *bytes = output ? hdr_output_bytes(output, &size) : NULL;
    double m[9];
    image image;
    CHECK(hdr_matrix_to_rec709(&hdr_cie_xyz, hdr_cie_xyz.white, false, m), "no matrix");
    if (bytes && read_bytes(bytes, size, true, &image, &error) == HDR_OK) {
        bool display = strcmp(image.about.state, "linear") != 0;
        CHECK(image.about.has_alpha == with_alpha && image.about.has_chromaticities == !display &&
                  !strcmp(image.about.format, "pfs"),
              "%s: not as written", words);
        for (int i = 0; i < COUNT; i++)
            for (int c = 0; c < 3; c++) {
                double value = (double)image.plane[c][i];
                if (!display)
                    value = m[3 * c] * (double)image.plane[0][i] + m[3 * c + 1] * (double)image.plane[1][i] +
                            m[3 * c + 2] * (double)image.plane[2][i];
                wrong += !(fabs(value - (double)plane[planes == 3 ? c : 0][i]) <= tolerance);
            }
        for (int i = 0; with_alpha && i < COUNT; i++)
            wrong += image.plane[3][i] != plane[3][i];
        for (int i = 0; planes == 1 && !display && i < COUNT; i++)
            wrong += image.plane[1][i] != plane[0][i];
        CHECK(wrong == 0, "%s: %zu values are wrong", words, wrong);
        image_free(&image);
    }
    CHECK(error.status == HDR_OK, "%s: %s", words, error.message);
    hdr_output_free(output);
}

static void test_pfs_forms(void) {
    static const char *const heads[] = {
        "PFS1\n2 1\n1\n2\nA=1\nLUMINANCE=ABSOLUTE\nY\n1\nB=2\nENDH",
        "PFS1\n2 1\n4\n0\nB\n0\nDEPTH\n0\nG\n0\nR\n0\nENDH",
        "PFS1\n2 1\n4\n0\nA\n0\nZ\n0\nX\n0\nY\n0\nENDH",
    };
    static const int place[3][4] = {{0, -1, -1, -1}, {3, 2, 0, -1}, {2, 3, 1, 0}};
    static file made;
    for (size_t form = 0; form < 3; form++) {
        made.size = 0;
        add_text(&made, heads[form]);
        for (int i = 0; i < 2 * 4; i++)
            add_float(&made, (float)i, false);
        add_text(&made, "PFS1\nanother frame");
        image image;
        hdr_error error;
        CHECK(read_bytes(made.bytes, made.size, false, &image, &error) == HDR_OK, "form %zu: %s", form, error.message);
        for (int p = 0; p < 4 && !error.status; p++)
            CHECK(place[form][p] < 0 ? !image.plane[p]
                                     : image.plane[p] && image.plane[p][0] == (float)(2 * place[form][p]) &&
                                           image.plane[p][1] == (float)(2 * place[form][p] + 1),
                  "form %zu: plane %d", form, p);
        image_free(&image);
    }
}

/* ---- Damage ---- */

/* Small files of each format, as they are written. */
static hdr_output *small_file(const char *words) {
    enum { WIDTH = 9, HEIGHT = 18 };
    static float plane[WIDTH * HEIGHT];
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        plane[i] = (float)(i / 5) / 8;
    const float *const planes[3] = {plane, plane, plane};
    hdr_error error = {.status = HDR_OK};
    return write_planes(WIDTH, HEIGHT, 3, planes, NULL, words, &error);
}

static void test_damage(const char *words) {
    hdr_output *output = small_file(words);
    size_t size = 0, survived = 0;
    const unsigned char *bytes = output ? hdr_output_bytes(output, &size) : NULL;
    unsigned char *copy = malloc(size + 1);
    for (size_t cut = 0; bytes && cut < size; cut++) {
        image image;
        hdr_error error;
        memcpy(copy, bytes, cut); /* at its own place: a byte read behind the end is found by the sanitizer */
        unsigned char *exact = malloc(cut ? cut : 1);
        memcpy(exact, bytes, cut);
        CHECK(read_bytes(exact, cut, cut & 1, &image, &error) == HDR_BAD_DATA && error.message[0] &&
                  !strchr(error.message, '\n'),
              "%s cut to %zu bytes: %d %s", words, cut, error.status, error.message);
        image_free(&image);
        free(exact);
    }
    for (size_t bit = 0; bytes && bit < 8 * size; bit++) {
        image image;
        hdr_error error;
        memcpy(copy, bytes, size);
        copy[bit / 8] ^= (unsigned char)(1u << bit % 8);
        hdr_input *input = hdr_input_memory(copy, size, "memory", &error);
        hdr_status status = read_input(input, bit & 1, false, &image, &error);
        CHECK(status == HDR_OK || status == HDR_BAD_DATA, "%s, bit %zu: %d %s", words, bit, status, error.message);
        survived += status == HDR_OK;
        hdr_input_free(input);
        image_free(&image);
    }
    CHECK(survived < 8 * size, "%s: no damage is found", words);
    free(copy);
    hdr_output_free(output);
}

static void test_claims(void) {
    static const char *const claims[] = {
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2147483647 +X 2147483647\n",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2147483647 +X 1\n",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 16000000\n\1\2\3\4",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n+X 2147483647 +Y 2147483647\n",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n+X 1 +Y 60000000\n\1\2\3\4",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 20 +X 30000\n\2\2\x75\x30\xff\1\xff\1\xff\1\xff\1\xff\1",
        "PF\n2147483647 2147483647\n-1\n",
        "Pf\n1 2147483647\n-1\n1234",
        "Pf\n16000000 100\n1\n1234",
        "PFS1\n65535 65535\n3\n0\nX\n0\nY\n0\nZ\n0\nENDH1234",
        "PFS1\n65535 10\n1024\n0\nX\n0\nY\n0\nZ\n0\nENDH1234",
    };
    struct rusage before, after;
    getrusage(RUSAGE_SELF, &before);
    clock_t start = clock();
    for (size_t i = 0; i < sizeof claims / sizeof claims[0]; i++) {
        hdr_error error = {.status = HDR_OK};
        image image;
        hdr_input *input = hdr_input_memory(claims[i], strlen(claims[i]), "memory", &error);
        CHECK(read_input(input, false, false, &image, &error) == HDR_BAD_DATA, "claim %zu: %d %s", i, error.status,
              error.message);
        hdr_input_free(input);
    }
    getrusage(RUSAGE_SELF, &after);
    CHECK((double)(clock() - start) < 0.5 * CLOCKS_PER_SEC, "claims take too long");
    CHECK(after.ru_maxrss - before.ru_maxrss < 1 << 15, "claims take %ld KB", after.ru_maxrss - before.ru_maxrss);
}

/* ---- Names ---- */

static void test_names(void) {
    const hdr_option *output = hdr_common_options();
    while (output->name && strcmp(output->name, "output") != 0)
        output++;
    for (int i = 0; hdr_verb_at(i); i++) {
        const hdr_verb_about *about = hdr_verb_at(i);
        CHECK(about->kind == HDR_FORMAT || !hdr_format_named(about->name), "%s is a format's name", about->name);
    }
    static const char *const named[][2] = {{"a.hdr", "rgbe"}, {"a.b/c.PFS", "pfs"}, {"x.pfm", "pfm"},
                                           {".exr", "exr"},   {"a.png", "png"},     {"a.hdr/b", NULL},
                                           {"a.rgbe", NULL},  {"png", NULL},        {"", NULL}};
    for (size_t i = 0; i < sizeof named / sizeof named[0]; i++) {
        const hdr_verb_about *about = hdr_format_named(named[i][0]);
        CHECK(about ? named[i][1] && !strcmp(about->name, named[i][1]) : !named[i][1], "%s", named[i][0]);
    }
    int formats = 0, told = 0;
    for (int i = 0; hdr_verb_at(i); i++)
        formats += hdr_verb_at(i)->kind == HDR_FORMAT;
    const char *list = strchr(output->help, '(');
    for (const char *at = list; at && *at != ')'; at++)
        told += *at == '.';
    CHECK(formats == told, "-o tells of %d endings, and there are %d formats", told, formats);
}

int main(void) {
    test_pfm();
    test_refused();
    for (int planes = 1; planes <= 3; planes += 2) {
        test_rgbe_round_trip(1, 1, planes);
        test_rgbe_round_trip(7, 20, planes);
        test_rgbe_round_trip(8, 33, planes);
        test_rgbe_round_trip(700, 40, planes);
        test_rgbe_round_trip(32768, 2, planes);
        test_pfs_round_trip(planes, false, "pfs", 1e-3);
        test_pfs_round_trip(planes, planes == 3, "srgb then pfs --reference", 2000);
    }
    test_pfs_round_trip(3, true, "pfs", 1e-3);
    test_pfs_forms();
    test_damage("rgbe");
    test_damage("pfm");
    test_damage("pfs");
    test_claims();
    test_names();
    return check_done("test_formats");
}

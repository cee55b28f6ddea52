/* Structural similarity against the paper's formula, window by window, in long double. */
#include "check.h"
#include "oracle_renders.h"

#include <string.h>

static long double encoded(float value) {
    long double c = fminl(fmaxl((long double)value, 0), 1);
    return (long double)(float)(c <= 0.0031308L ? 12.92L * c : 1.055L * powl(c, 1 / 2.4L) - 0.055L);
}

static long double luma_of(const pictures *p, int i, int x, int y) {
    const float *n = p->numbers[i] + (size_t)y * (size_t)p->width + (size_t)x;
    if (p->planes == 1) return encoded(*n);
    return 0.2126L * encoded(n[0]) + 0.7152L * encoded(n[pixels_of(p)]) + 0.0722L * encoded(n[2 * pixels_of(p)]);
}

/* Every window by itself, as the paper's equation 13 has it. */
static long double naive_ssim(const pictures *p) {
    long double total = 0, weight[11][11], sum = 0, c1 = 0.0001L, c2 = 0.0009L;
    for (int j = 0; j < 11; j++)
        for (int i = 0; i < 11; i++)
            sum += weight[j][i] = expl(-((i - 5) * (i - 5) + (j - 5) * (j - 5)) / (2 * 1.5L * 1.5L));
    for (int v = 0; v + 11 <= p->height; v++)
        for (int u = 0; u + 11 <= p->width; u++) {
            long double mx = 0, my = 0, xx = 0, yy = 0, xy = 0;
            for (int pass = 0; pass < 2; pass++)
                for (int j = 0; j < 11; j++)
                    for (int i = 0; i < 11; i++) {
                        long double w = weight[j][i] / sum, x = luma_of(p, 0, u + i, v + j),
                                    y = luma_of(p, 1, u + i, v + j);
                        if (pass == 0) {
                            mx += w * x;
                            my += w * y;
                        } else {
                            xx += w * (x - mx) * (x - mx);
                            yy += w * (y - my) * (y - my);
                            xy += w * (x - mx) * (y - my);
                        }
                    }
            total += (2 * mx * my + c1) * (2 * xy + c2) / ((mx * mx + my * my + c1) * (xx + yy + c2));
        }
    return total / ((p->width - 10) * (p->height - 10));
}

static double ssim_of(const pictures *p, const char *threads, hdr_status expected) {
    hdr_error error = {0};
    double ssim = -2;
    hdr_chain *chain = hdr_chain_new(&error);
    const char *const words[] = {"stats", "-j", threads};
    hdr_input *test = open_picture(p, 0), *reference = open_picture(p, 1);
    hdr_chain_parse(chain, 3, words, &error);
    hdr_structure *structure = hdr_structure_new(chain, reference, &error);
    if (structure) hdr_structure_compare(structure, test, &ssim, &error);
    CHECK(error.status == expected, "ssim: %s", error.message);
    hdr_structure_free(structure);
    hdr_input_free(test);
    hdr_input_free(reference);
    hdr_chain_free(chain);
    return ssim;
}

static double shade(int picture, size_t at) {
    return fabs(sin((double)at * 0.01)) * (picture ? 0.8 : 1) + 0.2 * random_unit();
}

static void test_structure(void) {
    static const int sizes[][3] = {{11, 11, 3}, {40, 17, 3}, {12, 60, 1}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        pictures p = make_pictures(sizes[s][0], sizes[s][1], sizes[s][2], 2, shade);
        double ssim = ssim_of(&p, "1", HDR_OK);
        long double expected = naive_ssim(&p);
        CHECK(fabsl((long double)ssim - expected) < 1e-10L, "ssim of %d x %d: %.17g, should be %.17Lg", p.width,
              p.height, ssim, expected);
        CHECK(ssim_of(&p, "3", HDR_OK) == ssim, "threads change ssim");
        memcpy(p.numbers[1], p.numbers[0], pixels_of(&p) * (size_t)p.planes * sizeof(float));
        CHECK(fabs(ssim_of(&p, "2", HDR_OK) - 1) < 1e-12, "a picture and itself");
        free_pictures(&p);
    }
    pictures p = make_pictures(10, 30, 3, 2, shade);
    ssim_of(&p, "1", HDR_BAD_DATA);
    free_pictures(&p);
}

int main(void) {
    test_structure();
    return check_done("test_ssim");
}

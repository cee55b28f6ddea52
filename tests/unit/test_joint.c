/* The published branches of sRGB overlap at 0.0031308, where the curve falls by 2.9e-8, and those of the inverse of
 * BT.709's at 0.081, where it falls by 5.5e-5. If a later verb puts a code's boundary just there, no table of
 * thresholds can stand for the chain, and none may be used. */
#include "check.h"
#include "hdrpipe.h"

#include <math.h>
#include <string.h>

enum { COUNT = 400 };

typedef struct curve {
    const char *words[2];
    int count;
    float joint;
    double below, above; /* what the curve is on its two sides */
} curve;

/* The PNG of 400 neighbouring floats around the joint, through the curve and an exposure; the bytes belong to output.
 */
static hdr_output *encode(const curve *c, const char *stops, bool reference, const void **bytes, size_t *size) {
    float values[COUNT];
    float value = c->joint;
    for (int i = 0; i < COUNT / 2; i++)
        value = nextafterf(value, 0);
    for (int i = 0; i < COUNT; i++, value = nextafterf(value, 1))
        values[i] = value;
    const float *planes[3] = {values};
    hdr_error error = {0};
    hdr_chain *chain = hdr_chain_new(&error);
    hdr_input *input = hdr_input_planes(COUNT, 1, 1, planes, NULL, &error);
    hdr_output *output = hdr_output_memory(&error);
    hdr_chain_add(chain, c->words, c->count, &error);
    hdr_chain_add(chain, (const char *const[]){"expose", "--ev", stops}, 3, &error);
    hdr_chain_add(chain, (const char *const[]){"quantise"}, 1, &error);
    hdr_chain_add(chain, (const char *const[]){"png", "--reference"}, reference ? 2 : 1, &error);
    if (!error.status) hdr_chain_run(chain, input, output, NULL, &error);
    CHECK(!error.status, "%s stops: %s", stops, error.message);
    *bytes = hdr_output_bytes(output, size);
    hdr_input_free(input);
    hdr_chain_free(chain);
    return output;
}

/* Factors that bring what the curve falls across, and what is beside it, to k + 1/2 codes of 255. */
static void check_curve(const curve *c) {
    for (int k = 1; k < 60; k++)
        for (int step = -3; step <= 3; step++) {
            char stops[40];
            double middle = (c->below + c->above) / 2, wide = fabs(c->below - c->above) / middle;
            snprintf(stops, sizeof stops, "%.17g", log2((k + 0.5) / 255 / middle * (1 + step * wide / 4)));
            const void *fast_bytes, *exact_bytes;
            size_t fast_size, exact_size;
            hdr_output *fast = encode(c, stops, false, &fast_bytes, &fast_size);
            hdr_output *exact = encode(c, stops, true, &exact_bytes, &exact_size);
            CHECK(fast_size == exact_size && !memcmp(fast_bytes, exact_bytes, fast_size),
                  "%s, %s stops: other codes than --reference", c->words[0], stops);
            hdr_output_free(fast);
            hdr_output_free(exact);
        }
}

int main(void) {
    check_curve(&(curve){{"srgb"}, 1, 0.0031308f, 12.92 * 0.0031308, 12.92 * 0.0031308 - 2.86e-8});
    check_curve(&(curve){{"rec709", "--decode"}, 2, 0.081f, 0.018, 0.018 - 5.4977e-5});
    return check_done("test_joint");
}

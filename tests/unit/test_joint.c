/* The published branches of sRGB overlap at 0.0031308, where the curve falls by 2.9e-8. If a later verb puts a code's
 * boundary just there, no table of thresholds can stand for the chain, and none may be used. */
#include "check.h"
#include "hdrpipe.h"

#include <math.h>
#include <string.h>

enum { COUNT = 400 };

/* The PNG of 400 neighbouring floats around the joint, through srgb and an exposure; the bytes belong to output. */
static hdr_output *encode(const char *stops, bool reference, const void **bytes, size_t *size) {
    float values[COUNT];
    float value = 0.0031308f;
    for (int i = 0; i < COUNT / 2; i++)
        value = nextafterf(value, 0);
    for (int i = 0; i < COUNT; i++, value = nextafterf(value, 1))
        values[i] = value;
    const float *planes[3] = {values};
    hdr_error error = {0};
    hdr_chain *chain = hdr_chain_new(&error);
    hdr_input *input = hdr_input_planes(COUNT, 1, 1, planes, NULL, &error);
    hdr_output *output = hdr_output_memory(&error);
    hdr_chain_add(chain, (const char *const[]){"srgb"}, 1, &error);
    hdr_chain_add(chain, (const char *const[]){"expose", "--ev", stops}, 3, &error);
    hdr_chain_add(chain, (const char *const[]){"png", "--reference"}, reference ? 2 : 1, &error);
    if (!error.status) hdr_chain_run(chain, input, output, NULL, &error);
    CHECK(!error.status, "%s stops: %s", stops, error.message);
    *bytes = hdr_output_bytes(output, size);
    hdr_input_free(input);
    hdr_chain_free(chain);
    return output;
}

int main(void) {
    /* factors that bring the encoded joint, 0.04045, to k + 1/2 codes of 255, where the fall crosses a boundary
     */
    double joint = 12.92 * 0.0031308;
    for (int k = 1; k < 60; k++) {
        char stops[40];
        double ev = log2((k + 0.5) / 255 / joint);
        for (int step = -3; step <= 3; step++) {
            snprintf(stops, sizeof stops, "%.17g", ev + step * 1e-7);
            const void *fast_bytes, *exact_bytes;
            size_t fast_size, exact_size;
            hdr_output *fast = encode(stops, false, &fast_bytes, &fast_size);
            hdr_output *exact = encode(stops, true, &exact_bytes, &exact_size);
            CHECK(fast_size == exact_size && !memcmp(fast_bytes, exact_bytes, fast_size),
                  "%s stops: other codes than --reference", stops);
            hdr_output_free(fast);
            hdr_output_free(exact);
        }
    }
    return check_done("test_joint");
}

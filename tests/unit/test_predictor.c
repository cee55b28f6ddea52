/* Compares every version of the predictor with the format's description taken literally. */
#include "check.h"
#include "kernel/predictor.h"

#include <stdint.h>
#include <string.h>

/* As the format's description has it: first the differences, then the halves. */
static void undo_in_steps(unsigned char *bytes, size_t size, unsigned char *out) {
    for (size_t i = 1; i < size; i++)
        bytes[i] = (unsigned char)(bytes[i - 1] + bytes[i] - 128);
    for (size_t i = 0; i < size; i++)
        out[i] = bytes[i % 2 ? (size + 1) / 2 + i / 2 : i / 2];
}

static void check_predictor(void) {
    uint32_t random = 1;
    enum { MOST = 517 };
    for (size_t size = 0; size <= MOST; size++) {
        unsigned char in[MOST + 1], steps[MOST + 1], expected[MOST + 1], out[MOST + 1];
        for (size_t i = 0; i < size; i++) {
            random = random * 1664525u + 1013904223u;
            in[i] = steps[i] = (unsigned char)(random >> 24);
        }
        undo_in_steps(steps, size, expected);
        for (hdr_cpu_level level = HDR_CPU_C; level <= hdr_cpu(); level++) {
            out[size] = 0xa5;
            hdr_predictor_at(level)(in, size, out);
            CHECK(memcmp(out, expected, size) == 0 && out[size] == 0xa5, "predictor %s, %zu bytes", hdr_cpu_name(level),
                  size);
        }
    }
}

int main(void) {
    check_predictor();
    return check_done("test_predictor");
}

#include "kernel/predict_encode.h"

#include "base/cpu.h"

HDR_INLINE void hdr_predict_split_body(uint8_t *restrict even, uint8_t *restrict odd, const uint8_t *restrict in,
                                       size_t pairs, const uint8_t *before) {
    if (pairs == 0) return;
    even[0] = (uint8_t)(in[0] - before[0] + 128);
    odd[0] = (uint8_t)(in[1] - before[1] + 128);
    for (size_t i = 1; i < pairs; i++) {
        even[i] = (uint8_t)(in[2 * i] - in[2 * i - 2] + 128);
        odd[i] = (uint8_t)(in[2 * i + 1] - in[2 * i - 1] + 128);
    }
}
HDR_VERSIONS(hdr_predict_split,
             (uint8_t *restrict even, uint8_t *restrict odd, const uint8_t *restrict in, size_t pairs,
              const uint8_t before[2]),
             (even, odd, in, pairs, before))

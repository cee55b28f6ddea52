#include "kernel/pngfilter.h"

#include "base/cpu.h"

#include <string.h>

HDR_INLINE void hdr_png_sub_8_body(uint8_t *restrict out, const uint8_t *restrict in, size_t bytes, size_t step) {
    memcpy(out, in, step);
    for (size_t i = step; i < bytes; i++)
        out[i] = (uint8_t)(in[i] - in[i - step]);
}
HDR_VERSIONS(hdr_png_sub_8, (uint8_t *restrict out, const uint8_t *restrict in, size_t bytes, size_t step),
             (out, in, bytes, step))

HDR_INLINE void hdr_png_sub_16_body(uint8_t *restrict out, const uint16_t *restrict in, size_t samples, size_t step) {
    for (size_t i = 0; i < step; i++) {
        out[2 * i] = (uint8_t)(in[i] >> 8);
        out[2 * i + 1] = (uint8_t)in[i];
    }
    for (size_t i = step; i < samples; i++) {
        out[2 * i] = (uint8_t)((in[i] >> 8) - (in[i - step] >> 8));
        out[2 * i + 1] = (uint8_t)(in[i] - in[i - step]);
    }
}
HDR_VERSIONS(hdr_png_sub_16, (uint8_t *restrict out, const uint16_t *restrict in, size_t samples, size_t step),
             (out, in, samples, step))

/* PNG's row filter Sub: every byte less the byte one pixel to its left (RFC 2083, 6.3). Within a row, so that bands of
 * rows do not depend on one another. */
#ifndef HDR_KERNEL_PNGFILTER_H
#define HDR_KERNEL_PNGFILTER_H

#include <stddef.h>
#include <stdint.h>

/* One row of bytes; step: bytes of a pixel, at most bytes. out and in do not overlap. */
void hdr_png_sub_8(uint8_t *out, const uint8_t *in, size_t bytes, size_t step);

/* One row of native 16-bit samples, which leave as two bytes each, most significant first; step: samples of a pixel. */
void hdr_png_sub_16(uint8_t *out, const uint16_t *in, size_t samples, size_t step);

#endif

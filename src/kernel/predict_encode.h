/* The predictor of OpenEXR's ZIP and RLE compressions, encoding: bytes at even and at odd places go to two halves, and
 * each byte is replaced by its difference to the one before it, plus 128. */
#ifndef HDR_KERNEL_PREDICT_ENCODE_H
#define HDR_KERNEL_PREDICT_ENCODE_H

#include <stddef.h>
#include <stdint.h>

/* Splits pairs of bytes: even[i] = in[2i] - in[2i - 2] + 128, odd[i] = in[2i + 1] - in[2i - 1] + 128. before: the two
 * bytes that stand in front of in, or what counts as such. No two of even, odd and in overlap. */
void hdr_predict_split(uint8_t *even, uint8_t *odd, const uint8_t *in, size_t pairs, const uint8_t before[2]);

#endif

/* The last step of decoding OpenEXR's ZIP, ZIPS and RLE chunks. Before packing, a writer parts the bytes of even and of
 * odd places into two halves (the high and the low bytes of half floats compress better apart), and then replaces each
 * byte by its difference from the one before it, plus 128. */
#ifndef HDR_PREDICTOR_H
#define HDR_PREDICTOR_H

#include "base/cpu.h"

#include <stddef.h>

/* Undoes both: out[0 ... size-1] are the bytes of pixels. in and out do not overlap and need no alignment. */
void hdr_predictor_undo(const unsigned char *in, size_t size, unsigned char *out);

/* The version of it for one instruction set, which the processor must have. For tests and measurements. */
typedef void (*hdr_predictor)(const unsigned char *in, size_t size, unsigned char *out);
hdr_predictor hdr_predictor_at(hdr_cpu_level level);

#endif

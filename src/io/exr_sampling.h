/* Files some of whose channels are subsampled: their lines differ in length. */
#ifndef HDR_EXR_SAMPLING_H
#define HDR_EXR_SAMPLING_H

#include "io/exr_header.h"

/* How many of the coordinates first ... first+count-1 are multiples of sampling: those have a sample. */
int64_t hdr_exr_samples(int sampling, int64_t first, int64_t count);

/* Bytes of lines first_line ... (in the file's coordinates) over all channels of the file. No more than pixel_bytes
 * for each of their pixels. */
size_t hdr_exr_lines_bytes(const hdr_exr_header *header, int64_t first_line, int lines);

/* Copies the picture's channels from unpacked lines to planes of their own. A subsampled one has a row for each line
 * that holds some of it. */
void hdr_exr_gather_lines(const hdr_exr_header *header, const unsigned char *from, int64_t first_line, int lines,
                          unsigned char *const plane[4], const size_t stride[4]);

#endif

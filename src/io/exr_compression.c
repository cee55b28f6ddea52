#include "io/exr_compression.h"

#include "io/sink.h"

#include <openexr.h>

const char *const hdr_compression_names[] = {"none", "rle",  "zips", "zip",  "piz", "pxr24",
                                             "b44",  "b44a", "dwaa", "dwab", NULL};
static const int chunk_lines[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};

enum { COMPRESSIONS = sizeof chunk_lines / sizeof chunk_lines[0] };
_Static_assert(sizeof hdr_compression_names / sizeof hdr_compression_names[0] == COMPRESSIONS + 1, "a name for each");
_Static_assert((int)HDR_COMPRESSION_ZIP == (int)EXR_COMPRESSION_ZIP &&
                   (int)HDR_COMPRESSION_DWAB == (int)EXR_COMPRESSION_DWAB,
               "the numbers are OpenEXR's");

const char *hdr_exr_compression_name(int compression) {
    return compression >= 0 && compression < COMPRESSIONS ? hdr_compression_names[compression] : NULL;
}

int hdr_exr_chunk_lines(int compression) {
    return chunk_lines[compression];
}

/* What there is to know of EXR's compressions. Numbers are OpenEXR's own, which those of hdr_compression are too. */
#ifndef HDR_EXR_COMPRESSION_H
#define HDR_EXR_COMPRESSION_H

/* Its name in hdrpipe's words: "zip"; NULL for a number that is none. */
const char *hdr_exr_compression_name(int compression);

/* Lines that are packed together, which makes them a chunk. For a number that has a name. */
int hdr_exr_chunk_lines(int compression);

#endif

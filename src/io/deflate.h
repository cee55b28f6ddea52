/* Deflate, the fast way (ISA-L's igzip), with the same bytes for the same data wherever it lies in memory. */
#ifndef HDR_DEFLATE_H
#define HDR_DEFLATE_H

#include <stddef.h>

typedef struct hdr_deflater hdr_deflater;

/* level: 1, or 2 (a larger table of matches). NULL: out of memory. */
hdr_deflater *hdr_deflater_new(int level);
void hdr_deflater_free(hdr_deflater *deflater);

typedef enum hdr_deflate_form {
    HDR_DEFLATE_PART, /* raw, ends with a full flush: the next part may be put behind it, whoever deflates it */
    HDR_DEFLATE_LAST, /* raw, the last part */
    HDR_DEFLATE_ZLIB  /* a zlib stream of its own, with head and Adler sum */
} hdr_deflate_form;

/* Room in which any data of that size fits. */
size_t hdr_deflate_bound(size_t size);

/* Returns the number of bytes written to out, or 0 if room is not enough (or size is beyond 32 bits). The bytes may
 * depend on room as well as on the data. */
size_t hdr_deflate(hdr_deflater *deflater, hdr_deflate_form form, const void *data, size_t size, void *out,
                   size_t room);

#endif

/* What every room uses: the error record's helper, checked sizes, and the words that mark a function's contract. */
#ifndef HDR_BASE_H
#define HDR_BASE_H

#include "hdrpipe.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define HDR_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define HDR_PRINTF(text, first)
#endif

/* Fills the record (err may be NULL) and returns status, so that the one who detects a fault writes
 * `return hdr_fail(err, HDR_BAD_DATA, "...")`. Only the first fault is kept: later calls leave a filled record alone.
 */
hdr_status hdr_fail(hdr_error *err, hdr_status status, const char *format, ...) HDR_PRINTF(3, 4);

/* Puts "prefix: " in front of a message on its way up, e.g. the name of the clause or the file. Returns err's status.
 */
hdr_status hdr_fail_in(hdr_error *err, const char *prefix);

/* malloc/realloc of count * size bytes; NULL on overflow or when memory is out. hdr_alloc clears it. A size of 0 gives
 * a pointer that may be freed. */
void *hdr_alloc(size_t count, size_t size);
void *hdr_grow(void *old, size_t count, size_t size);

/* Large memory that is written once from front to back (a picture that is kept, a file from a pipe): page faults cost
 * more than the work there, so huge pages are asked for. Not cleared. Free with hdr_free_pages(p, bytes). */
void *hdr_alloc_pages(size_t bytes);
void hdr_free_pages(void *pages, size_t bytes);

/* The default of --memory: half of what the machine (or the control group it runs in) has. Bytes. */
uint64_t hdr_memory_default(void);

/* A byte string that grows. Zero-initialise; free data with free(). */
typedef struct hdr_bytes {
    unsigned char *data;
    size_t size, room;
} hdr_bytes;
hdr_status hdr_bytes_reserve(hdr_bytes *bytes, size_t room, hdr_error *err); /* room for at least that many in all */
hdr_status hdr_bytes_add(hdr_bytes *bytes, const void *data, size_t size, hdr_error *err);
hdr_status hdr_bytes_printf(hdr_bytes *bytes, hdr_error *err, const char *format, ...) HDR_PRINTF(3, 4);

#endif

/* Bytes that appear whole or not at all. */
#ifndef HDR_OUTPUT_H
#define HDR_OUTPUT_H

#include "base/base.h"

/* The name that was given ("a.png"), or "standard output", or "memory". */
const char *hdr_output_name(const hdr_output *output);

/* Whether pixels are wanted. The sink says what they are before it writes: each plane row after row, then alpha. */
bool hdr_output_takes_pixels(const hdr_output *output);
void hdr_output_describe(hdr_output *output, int width, int height, int planes, bool alpha);

/* Writes at a position. Into the temporary file (then errors of the disk come at once: HDR_IO), or into memory that is
 * held until commit. Positions may come in any order; gaps are zeros. One thread at a time. */
hdr_status hdr_output_write(hdr_output *output, const void *data, size_t size, uint64_t offset, hdr_error *err);

/* Forgets all that was written: the sweep starts again. */
hdr_status hdr_output_restart(hdr_output *output, hdr_error *err);

/* Makes it appear: fsync is not asked for, but every write, the close and the rename are checked. Afterwards nothing
 * more may be written. */
hdr_status hdr_output_commit(hdr_output *output, hdr_error *err);

/* Removes the temporary files of all outputs of the process that are not committed yet. Only for a handler of SIGINT,
 * SIGTERM or SIGHUP that ends the process right afterwards: it is async-signal-safe, and an output it was applied to
 * cannot be committed any more. */
void hdr_output_remove_temporary(void);

#endif

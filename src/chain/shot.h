/* Facts of a whole shot, read from what `hdr stats --json` has printed. */
#ifndef HDR_CHAIN_SHOT_H
#define HDR_CHAIN_SHOT_H

#include "base/options.h"

/* The facts in a text: those of its one picture, or of all pictures together. The text may hold any bytes.
 * HDR_BAD_DATA: it is nothing that stats prints, or not of all pictures together. */
hdr_status hdr_shot_read(const char *json, size_t size, hdr_shot *shot, hdr_error *err);

/* The same from a file; a pipe will do (but not "-", which is the picture's place). HDR_NO_INPUT: there is none. */
hdr_status hdr_shot_load(const char *name, hdr_shot *shot, hdr_error *err);

#endif

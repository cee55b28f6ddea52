/* What the measurements share. */
#ifndef HDR_MEASURE_H
#define HDR_MEASURE_H

#include "base/base.h"

/* Side of the squares that figures are told of, one by one. */
enum { HDR_TILE_SIDE = 64 };

/* HDR_BAD_DATA where nothing was measured, or not all with --strict. */
hdr_status hdr_check_left_out(const hdr_chain *chain, uint64_t numbers, uint64_t left_out, hdr_error *err);

#endif

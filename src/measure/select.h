/* Ranks among numbers that are not negative. */
#ifndef HDR_SELECT_H
#define HDR_SELECT_H

#include "base/base.h"

/* The smallest of the values such that those up to it, counted, or, if weighted, added up, are more than goal; the
 * largest where that is none. count >= 1. */
hdr_status hdr_select(const double *values, size_t count, bool weighted, double goal, double *selected, hdr_error *err);

#endif

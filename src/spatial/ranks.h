/* Numbers of given rank in a plane. */
#ifndef HDR_RANKS_H
#define HDR_RANKS_H

#include "base/pool.h"
#include "picture/plane.h"

/* values[i] = the number of rank rank[i], from 1, among those of the plane that the mask counts, of which there are as
 * many as the largest rank asks for. Exact, of both types of plane. */
hdr_status hdr_plane_ranks(const hdr_plane *plane, const unsigned char *mask, int count, const uint64_t *rank,
                           double *values, hdr_pool *pool, hdr_error *err);

/* The least and the largest number. */
hdr_status hdr_plane_range(const hdr_plane *plane, double *low, double *high, hdr_pool *pool, hdr_error *err);

#endif

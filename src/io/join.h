/* Several pictures of one form that become one, number by number: the mean of renders, the difference of two. A source
 * like any other, whose blocks are made of the others' while they are warm; no picture is ever held as a whole. */
#ifndef HDR_JOIN_H
#define HDR_JOIN_H

#include "io/source.h"
#include "kernel/joining.h"

/* The picture that the members of a joined input become. It is float; all that is not numbers it has from the first.
 * It takes the weights over, in any case. HDR_BAD_DATA: they are not of one form. */
hdr_source *hdr_join_open(hdr_input *input, const hdr_reading *reading, const hdr_joining *joining, hdr_error *err);

/* Among the attributes of the first picture's file, that which weights were taken from becomes their sum. */
hdr_status hdr_join_attributes(const hdr_source *source, hdr_bytes *attributes, hdr_error *err);

/* What its numbers are. */
const char *hdr_join_meaning(const hdr_source *source);

/* Components that were neither finite nor counted, of all blocks read so far, each once. */
uint64_t hdr_join_left_out(const hdr_source *source);

#endif

/* The attributes of an EXR file's header that go along into the file that is written of it. */
#ifndef HDR_EXR_ATTRIBUTES_H
#define HDR_EXR_ATTRIBUTES_H

#include "io/input.h"

#include <openexr.h>

/* The attribute in which --record keeps the chain: a line for each time it was written. */
#define HDR_EXR_RECORD "hdrpipeChain"

/* The attribute that tells what the numbers of a picture of several are, or of one that was smoothed. */
#define HDR_EXR_MEANING "hdrpipeMeaning"

/* What has become of the picture, so that some attributes say of it what is no longer so. */
typedef struct hdr_exr_fate {
    bool altered;   /* its values are not the file's */
    bool joined;    /* they are made of several files', and altered no further unless that is said */
    bool converted; /* nor are its primaries */
    bool encoded;   /* its values follow a curve now */
    bool cropped;   /* its frame is not the file's */
    bool recorded;  /* what becomes of it is added to the record of what was */
} hdr_exr_fate;

/* Appends the attributes of a part as the file has them, one behind the other. Not those that say how the pixels are
 * stored, nor those that are not true any more. *left_out: how many did not go along because they are damaged or too
 * large. */
hdr_status hdr_exr_attributes(hdr_input *input, int part, hdr_exr_fate fate, hdr_bytes *out, int *left_out,
                              hdr_error *err);

/* The number that an attribute of a part is: of type int, float, double, or a string that holds nothing else. NaN: it
 * is none. *found: there is such an attribute. */
hdr_status hdr_exr_number(hdr_input *input, int part, const char *name, bool *found, double *number, hdr_error *err);

/* Makes an attribute among those that hdr_exr_attributes has appended, of such a type, another number, above 0. What is
 * too large for an int becomes a double. Nothing: if it is not among them. */
hdr_status hdr_exr_set_number(hdr_bytes *attributes, const char *name, double number, hdr_error *err);

/* Appends an attribute of type string, which is not among them. */
hdr_status hdr_exr_add_text(hdr_bytes *attributes, const char *name, const char *text, hdr_error *err);

/* Puts them into the header that context is about to write, which has its own already; they count. record: what is
 * appended to HDR_EXR_RECORD, or NULL. */
exr_result_t hdr_exr_put_attributes(exr_context_t context, const hdr_bytes *attributes, const char *record);

/* Whether some name among them needs more room than old readers have. */
bool hdr_exr_long_names(const hdr_bytes *attributes);

#endif

/* Listings of what a file holds, as hdr_input_contents gives them out. */
#ifndef HDR_CONTENTS_H
#define HDR_CONTENTS_H

#include "base/base.h"

/* A listing under construction. Its memory is freed with the contents. */
typedef struct hdr_listing {
    hdr_contents contents; /* first: it is the same pointer */
    hdr_part *parts;
    void **owned;
    size_t owned_count, owned_room;
} hdr_listing;

hdr_listing *hdr_listing_new(int parts, hdr_error *err);

/* Memory, cleared, and texts that belong to the listing. NULL: out of memory, err is filled. */
void *hdr_listing_alloc(hdr_listing *listing, size_t count, size_t size, hdr_error *err);
const char *hdr_listing_text(hdr_listing *listing, const char *text, hdr_error *err);

/* A file that holds one picture, all of which is read. */
hdr_contents *hdr_contents_of_picture(const hdr_picture *picture, hdr_error *err);

#endif

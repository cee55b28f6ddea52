#include "io/contents.h"

#include <stdlib.h>
#include <string.h>

/* Takes memory over. */
static void *own(hdr_listing *listing, void *memory, hdr_error *err) {
    if (memory && listing->owned_count == listing->owned_room) {
        size_t room = listing->owned_room ? 2 * listing->owned_room : 64;
        void **grown = hdr_grow(listing->owned, room, sizeof *grown);
        if (grown) {
            listing->owned = grown;
            listing->owned_room = room;
        } else {
            free(memory);
            memory = NULL;
        }
    }
    if (!memory) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        return NULL;
    }
    listing->owned[listing->owned_count++] = memory;
    return memory;
}

void *hdr_listing_alloc(hdr_listing *listing, size_t count, size_t size, hdr_error *err) {
    return own(listing, hdr_alloc(count, size), err);
}

const char *hdr_listing_text(hdr_listing *listing, const char *text, hdr_error *err) {
    return own(listing, strdup(text), err);
}

hdr_listing *hdr_listing_new(int parts, hdr_error *err) {
    hdr_listing *listing = hdr_alloc(1, sizeof *listing);
    if (!listing) {
        hdr_fail(err, HDR_INTERNAL, "out of memory");
        return NULL;
    }
    listing->parts = hdr_listing_alloc(listing, (size_t)parts, sizeof *listing->parts, err);
    if (!listing->parts) {
        hdr_contents_free(&listing->contents);
        return NULL;
    }
    listing->contents = (hdr_contents){.part_count = parts, .parts = listing->parts};
    for (int i = 0; i < parts; i++)
        listing->parts[i] = (hdr_part){
            .number = i, .name = "", .view = "", .storage = "", .compression = "", .levels = "one", .level_count = 1};
    return listing;
}

void hdr_contents_free(hdr_contents *contents) {
    hdr_listing *listing = (hdr_listing *)contents;
    if (!listing) return;
    for (size_t i = 0; i < listing->owned_count; i++)
        free(listing->owned[i]);
    free(listing->owned);
    free(listing);
}

hdr_contents *hdr_contents_of_picture(const hdr_picture *picture, hdr_error *err) {
    hdr_listing *listing = hdr_listing_new(1, err);
    hdr_listed_channel *channels = listing ? hdr_listing_alloc(listing, 4, sizeof *channels, err) : NULL;
    if (!channels) goto fail;
    hdr_part *part = listing->parts;
    part->data = picture->data;
    part->display = picture->display;
    part->channels = channels;
    part->storage = hdr_listing_text(listing, picture->storage, err);
    part->compression = hdr_listing_text(listing, picture->compression, err);
    if (!part->storage || !part->compression) goto fail;
    for (int i = 0; i < 4; i++) {
        if (!picture->present[i]) continue;
        const char *name = hdr_listing_text(listing, picture->channels[i].name, err);
        if (!name) goto fail;
        channels[part->channel_count++] = (hdr_listed_channel){name, "", picture->channels[i].type, 1, 1};
    }
    return &listing->contents;
fail:
    if (listing) hdr_contents_free(&listing->contents);
    return NULL;
}

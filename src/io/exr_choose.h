/* Which part of an EXR file is read, and which of its channels. */
#ifndef HDR_EXR_CHOOSE_H
#define HDR_EXR_CHOOSE_H

#include "io/exr_walk.h"
#include "io/source.h"

/* How long the name of a channel's layer is: what stands before the last point of the channel's; 0: it has none. */
size_t hdr_exr_layer_length(const char *channel);

/* Full names of channels of the part, as they stand in its list. */
typedef struct hdr_exr_choice {
    int part;
    bool single;            /* channel[0] by itself, whatever it is */
    int planes;             /* 3: channel[0..2] are R, G and B, of which some may be missing (NULL); 1: channel[0] */
    const char *channel[4]; /* [3]: alpha, or NULL */
    const char *chroma[2];  /* RY and BY beside a Y, or NULL */
    char layer[HDR_CHANNEL_NAME]; /* of these channels */
} hdr_exr_choice;

/* HDR_BAD_DATA: there is no such thing (the message lists what there is), or it is deep. name: of the file. */
hdr_status hdr_exr_choose(const hdr_exr_file *file, const char *name, const hdr_reading *reading,
                          hdr_exr_choice *choice, hdr_error *err);

#endif

/* The common options that say what of a file is read. */
#include "chain/chain.h"

#include <string.h>

static bool same(const char *a, const char *b) {
    return strcmp(a, b) == 0;
}

/* A whole number in decimal digits, at most `most` in size, at the front of *text, which is moved behind it. */
static bool take_number(const char **text, int64_t most, int64_t *number) {
    bool negative = **text == '-';
    const char *digit = *text + negative, *first = digit;
    int64_t value = 0;
    for (; *digit >= '0' && *digit <= '9'; digit++) {
        value = value * 10 + (*digit - '0');
        if (value > most) return false;
    }
    *number = negative ? -value : value;
    *text = digit;
    return digit > first;
}

/* N or proxy:PIXELS. */
static bool read_level(const char *text, hdr_reading *reading) {
    static const char proxy[] = "proxy:";
    reading->proxy = strncmp(text, proxy, strlen(proxy)) == 0;
    if (reading->proxy) text += strlen(proxy);
    return take_number(&text, INT32_MAX, &reading->level) && !*text && reading->level >= (reading->proxy ? 1 : 0);
}

/* X,Y,W,H; the rectangle lies within the coordinates that OpenEXR has. */
static bool read_crop(const char *text, hdr_window *window) {
    int64_t number[4];
    for (int i = 0; i < 4; i++) {
        if (!take_number(&text, UINT32_MAX, &number[i])) return false;
        if (*text++ != (i < 3 ? ',' : '\0')) return false;
    }
    int64_t max_x = number[0] + number[2] - 1, max_y = number[1] + number[3] - 1;
    if (number[2] < 1 || number[3] < 1 || number[0] < INT32_MIN || number[1] < INT32_MIN || max_x > INT32_MAX ||
        max_y > INT32_MAX)
        return false;
    *window = (hdr_window){(int32_t)number[0], (int32_t)number[1], (int32_t)max_x, (int32_t)max_y};
    return true;
}

const char *hdr_common_fault(const hdr_common *common, const hdr_option *option) {
    hdr_reading reading;
    if (same(option->name, "level") && !read_level(common->level, &reading))
        return "it is neither a level's number, 0 or more, nor proxy: and a number of pixels";
    if (same(option->name, "crop") && !read_crop(common->crop, &reading.crop))
        return "it is no rectangle: four whole numbers with commas between them, width and height at least 1";
    if ((same(option->name, "part") && !*common->part) || (same(option->name, "layer") && !*common->layer) ||
        (same(option->name, "channel") && !*common->channel))
        return "the name is empty";
    return NULL;
}

hdr_reading hdr_chain_reading(const hdr_chain *chain) {
    const hdr_common *common = &chain->common;
    hdr_reading reading = {.memory = hdr_chain_settings(chain)->memory,
                           .part = common->part,
                           .layer = common->layer,
                           .channel = common->channel,
                           .no_alpha = common->alpha.how == HDR_ALPHA_DROP,
                           .cropped = common->crop != NULL};
    if (common->level) read_level(common->level, &reading); /* both were checked when they were given */
    if (common->crop) read_crop(common->crop, &reading.crop);
    return reading;
}

static bool begins_with(const hdr_error *own, const hdr_input *input) {
    hdr_error name = {0};
    hdr_fail(&name, own->status, "%s", hdr_input_name(input)); /* as messages have it: printable */
    size_t length = strlen(name.message);
    return !strncmp(own->message, name.message, length) && (own->message[length] == ':' || own->message[length] == ' ');
}

/* Whether a message tells already which file it is about: the input, or one of those that are joined. */
static bool is_named(const hdr_error *own, const hdr_input *input) {
    const hdr_joined *joined = hdr_input_get_joined(input);
    bool named = begins_with(own, input);
    for (int i = 0; joined && i < joined->count; i++)
        named |= begins_with(own, joined->members[i]);
    return named;
}

hdr_status hdr_fail_of_input(hdr_error *err, const hdr_error *own, const hdr_input *input, const hdr_input *guide) {
    bool named = is_named(own, input) || (guide && begins_with(own, guide));
    if (named || own->status == HDR_USAGE || own->status == HDR_CANT_CREATE || own->status == HDR_IO)
        return hdr_fail(err, own->status, "%s", own->message);
    return hdr_fail(err, own->status, "%s: %s", hdr_input_name(input), own->message);
}

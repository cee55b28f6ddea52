#include "io/exr_attributes.h"

#include "base/options.h"
#include "io/exr_text.h"
#include "io/exr_walk.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    MOST_CARRIED = 4096,          /* attributes; each is parsed by itself first */
    MOST_BYTES = 16 * 1024 * 1024 /* of all; manifests of object names come in megabytes */
};

/* A header that has nothing but what the library insists on; what is carried stands behind it. */
static const struct {
    const char *name, *type;
    unsigned char size, value[19];
} needed[] = {
    {"channels", "chlist", 19, {'Y', 0, 2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0}},
    {"compression", "compression", 1, {0}},
    {"dataWindow", "box2i", 16, {0}},
    {"displayWindow", "box2i", 16, {0}},
    {"lineOrder", "lineOrder", 1, {0}},
    {"pixelAspectRatio", "float", 4, {0, 0, 0x80, 0x3f}},
    {"screenWindowCenter", "v2f", 8, {0}},
    {"screenWindowWidth", "float", 4, {0, 0, 0x80, 0x3f}},
};
enum { NEEDED = sizeof needed / sizeof needed[0], FRAMED = 6 /* the first of them that may be carried */ };

/* Attributes that never go along: those that say how pixels are stored or which channels there are, what hdrpipe writes
 * itself, and what is true of the very file only. */
static const char *const never[] = {
    "channels",
    "compression",
    "dataWindow",
    "displayWindow",
    "lineOrder",
    "pixelAspectRatio",
    "tiles",
    "type",
    "version",
    "chunkCount",
    "maxSamplesPerPixel",
    "deepImageState",
    "multiView",
    "idManifest",
    "preview",
    "chromaticities",
    "hdrpipeState",
    "name",
    "dwaCompressionLevel",
    "acesImageContainerFlag",
};
/* Those that are true as long as the frame is the file's. */
static const char *const of_frame[] = {"screenWindowCenter", "screenWindowWidth", "envmap", "wrapmodes"};

struct gathering {
    hdr_input *input;
    int part;
    hdr_exr_fate fate;
    hdr_bytes *out;
    int count, left_out;
};

/* ---- Headers of attributes ---- */

static size_t record_size(const unsigned char *record) {
    size_t name = strlen((const char *)record) + 1, type = strlen((const char *)record + name) + 1;
    return name + type + 4 + hdr_little_endian_32(record + name + type);
}

/* Whether an attribute is among records, which stand one behind the other. */
static bool is_among(const unsigned char *records, size_t size, const char *name) {
    for (const unsigned char *at = records; at < records + size; at += record_size(at))
        if (!strcmp((const char *)at, name)) return true;
    return false;
}

/* Parses records as a header of their own. Free the text's bytes when the context has been finished. */
static exr_result_t open_records(const unsigned char *records, size_t size, hdr_exr_text *text,
                                 exr_context_t *context) {
    hdr_bytes *bytes = &text->bytes;
    hdr_error fault = {0};
    *text = (hdr_exr_text){.listening = false};
    *context = NULL;
    hdr_status status = hdr_exr_begin(bytes, &fault);
    for (int i = 0; i < NEEDED && status == HDR_OK; i++) {
        if (is_among(records, size, needed[i].name)) continue;
        status = hdr_exr_label(bytes, needed[i].name, needed[i].type, needed[i].size, &fault);
        if (status == HDR_OK) status = hdr_bytes_add(bytes, needed[i].value, needed[i].size, &fault);
    }
    if (status == HDR_OK) status = hdr_bytes_add(bytes, records, size, &fault);
    if (status == HDR_OK) status = hdr_bytes_add(bytes, "", 1, &fault);
    return status == HDR_OK ? hdr_exr_text_open(text, context) : EXR_ERR_OUT_OF_MEMORY;
}

/* ---- From the file ---- */

static bool is_one_of(const char *const names[], size_t count, const char *name) {
    for (size_t i = 0; i < count; i++)
        if (!strcmp(names[i], name)) return true;
    return false;
}

static bool goes_along(const char *name, hdr_exr_fate fate) {
    if (is_one_of(never, sizeof never / sizeof never[0], name)) return false;
    if (fate.cropped && is_one_of(of_frame, sizeof of_frame / sizeof of_frame[0], name)) return false;
    if (fate.converted && !strcmp(name, "adoptedNeutral")) return false;
    if ((fate.converted || fate.encoded) && !strcmp(name, "colorInteropID")) return false;
    if (!fate.recorded && !strcmp(name, HDR_EXR_RECORD)) return false;
    if ((fate.altered || fate.joined) && !strcmp(name, HDR_EXR_MEANING)) return false;
    return !(fate.altered && !strcmp(name, "whiteLuminance"));
}

/* Whether the library copies such a value as it is: it stops at a NUL in a text, and fails at some values of no bytes.
 */
static bool survives(const hdr_exr_attribute *attribute, const unsigned char *value) {
    bool text = !strcmp(attribute->type, "string"), texts = !strcmp(attribute->type, "stringvector");
    if (text) return !attribute->size || !memchr(value, 0, attribute->size);
    if (!texts) return attribute->size > 0;
    for (uint32_t at = 0; at + 4 <= attribute->size;) {
        uint32_t length = hdr_little_endian_32(value + at);
        if (length > attribute->size - at - 4 || memchr(value + at + 4, 0, length)) return false;
        at += 4 + length;
    }
    return true;
}

static hdr_status gather(void *context, int part, const hdr_exr_attribute *attribute, hdr_error *err) {
    struct gathering *gathering = context;
    hdr_bytes *out = gathering->out;
    size_t before = out->size;
    if (part != gathering->part || !goes_along(attribute->name, gathering->fate)) return HDR_OK;
    bool fits = gathering->count < MOST_CARRIED && attribute->size < MOST_BYTES - before &&
                !is_among(out->data, before, attribute->name);
    hdr_status status = fits ? hdr_exr_keep(gathering->input, attribute, MOST_BYTES, out, err) : HDR_OK;
    if (status != HDR_OK) return status;
    if (fits) { /* a damaged value must not spoil the others */
        hdr_exr_text text;
        exr_context_t parsed;
        fits = open_records(out->data + before, out->size - before, &text, &parsed) == EXR_ERR_SUCCESS &&
               survives(attribute, out->data + out->size - attribute->size);
        if (parsed) exr_finish(&parsed);
        free(text.bytes.data);
    }
    if (!fits) out->size = before;
    gathering->count += fits;
    gathering->left_out += !fits;
    return HDR_OK;
}

hdr_status hdr_exr_attributes(hdr_input *input, int part, hdr_exr_fate fate, hdr_bytes *out, int *left_out,
                              hdr_error *err) {
    struct gathering gathering = {.input = input, .part = part, .fate = fate, .out = out};
    const hdr_exr_visitor visitor = {gather, &gathering};
    hdr_exr_file file;
    hdr_status status = hdr_exr_walk(input, &file, &visitor, err);
    hdr_exr_file_free(&file);
    *left_out = gathering.left_out;
    return status;
}

/* ---- Numbers ---- */

enum { NUMBER_TEXT = 64 };

struct seeking {
    hdr_input *input;
    int part;
    const char *name;
    bool found;
    double number;
};

/* NaN: the value is no number. It has a NUL behind it. */
static double number_of(const char *type, const unsigned char *value, uint32_t size) {
    union {
        uint32_t bits;
        float number;
    } single;
    union {
        uint64_t bits;
        double number;
    } wide;
    if (!strcmp(type, "int") && size == 4) return (int32_t)hdr_little_endian_32(value);
    if (!strcmp(type, "string")) {
        const char *end = hdr_read_number((const char *)value, &wide.number);
        return end && !*end ? wide.number : NAN;
    }
    if (!strcmp(type, "float") && size == 4) {
        single.bits = hdr_little_endian_32(value);
        return (double)single.number;
    }
    if (strcmp(type, "double") != 0 || size != 8) return NAN;
    wide.bits = hdr_little_endian_64(value);
    return wide.number;
}

static hdr_status seek_number(void *context, int part, const hdr_exr_attribute *attribute, hdr_error *err) {
    struct seeking *seeking = context;
    unsigned char value[NUMBER_TEXT + 1] = {0};
    if (part != seeking->part || seeking->found || strcmp(attribute->name, seeking->name) != 0) return HDR_OK;
    seeking->found = true;
    if (attribute->size > NUMBER_TEXT) return HDR_OK;
    int64_t count = hdr_input_read(seeking->input, value, attribute->size, attribute->value, err);
    if (count < 0) return HDR_IO;
    seeking->number = number_of(attribute->type, value, (uint32_t)count);
    return HDR_OK;
}

hdr_status hdr_exr_number(hdr_input *input, int part, const char *name, bool *found, double *number, hdr_error *err) {
    struct seeking seeking = {.input = input, .part = part, .name = name, .number = NAN};
    const hdr_exr_visitor visitor = {seek_number, &seeking};
    hdr_exr_file file;
    hdr_status status = hdr_exr_walk(input, &file, &visitor, err);
    hdr_exr_file_free(&file);
    *found = seeking.found;
    *number = seeking.number;
    return status;
}

/* A number as the value of a type, the lowest byte first. How many bytes that takes. */
static uint32_t value_of(const char *type, double number, unsigned char value[NUMBER_TEXT]) {
    union {
        float number;
        uint32_t bits;
    } single = {.number = (float)number};
    union {
        double number;
        uint64_t bits;
    } wide = {.number = number};
    if (!strcmp(type, "string")) return (uint32_t)snprintf((char *)value, NUMBER_TEXT, "%.15g", number);
    uint64_t bits = !strcmp(type, "int") ? (uint32_t)number : !strcmp(type, "float") ? single.bits : wide.bits;
    uint32_t size = !strcmp(type, "double") ? 8 : 4;
    for (uint32_t i = 0; i < size; i++)
        value[i] = (unsigned char)(bits >> 8 * i);
    return size;
}

hdr_status hdr_exr_set_number(hdr_bytes *attributes, const char *name, double number, hdr_error *err) {
    size_t at = 0;
    while (at < attributes->size && strcmp((const char *)attributes->data + at, name) != 0)
        at += record_size(attributes->data + at);
    if (at >= attributes->size) return HDR_OK;
    unsigned char value[NUMBER_TEXT];
    const char *type = (const char *)attributes->data + at + strlen(name) + 1;
    bool whole = number <= INT32_MAX && number == floor(number);
    if (!strcmp(type, "int") && !whole) type = "double";
    size_t behind = at + record_size(attributes->data + at);
    uint32_t size = value_of(type, number, value);
    hdr_bytes changed = {0};
    hdr_status status = hdr_bytes_add(&changed, attributes->data, at, err);
    if (status == HDR_OK) status = hdr_exr_label(&changed, name, type, size, err);
    if (status == HDR_OK) status = hdr_bytes_add(&changed, value, size, err);
    if (status == HDR_OK) status = hdr_bytes_add(&changed, attributes->data + behind, attributes->size - behind, err);
    free(attributes->data);
    *attributes = changed;
    return status;
}

hdr_status hdr_exr_add_text(hdr_bytes *attributes, const char *name, const char *text, hdr_error *err) {
    hdr_status status = hdr_exr_label(attributes, name, "string", (uint32_t)strlen(text), err);
    return status == HDR_OK ? hdr_bytes_add(attributes, text, strlen(text), err) : status;
}

/* ---- Into the file ---- */

bool hdr_exr_long_names(const hdr_bytes *attributes) {
    const unsigned char *end = attributes->data + attributes->size;
    for (const unsigned char *at = attributes->data; at < end; at += record_size(at)) {
        size_t name = strlen((const char *)at);
        if (name > 31 || strlen((const char *)at + name + 1) > 31) return true;
    }
    return false;
}

/* The new record below the one there is. */
static exr_result_t put_record(exr_context_t context, exr_context_t from, const char *record) {
    const char *before = NULL;
    int32_t length = 0;
    hdr_bytes text = {0};
    hdr_error fault = {0};
    hdr_status status = HDR_OK;
    if (exr_attr_get_string(from, 0, HDR_EXR_RECORD, &length, &before) == EXR_ERR_SUCCESS && length > 0)
        status = hdr_bytes_printf(&text, &fault, "%.*s\n", (int)length, before);
    if (status == HDR_OK) status = hdr_bytes_printf(&text, &fault, "%s", record);
    if (status == HDR_OK) status = hdr_bytes_add(&text, "", 1, &fault);
    exr_result_t result = status == HDR_OK ? exr_attr_set_string(context, 0, HDR_EXR_RECORD, (const char *)text.data)
                                           : EXR_ERR_OUT_OF_MEMORY;
    free(text.data);
    return result;
}

/* Values of types that the library does not know: it reads and writes them, but (3.1) fails to copy them. */
static exr_result_t put_unknown(exr_context_t context, exr_context_t from) {
    int32_t count = 0;
    exr_result_t result = exr_get_attribute_count(from, 0, &count);
    for (int32_t i = 0; i < count && result == EXR_ERR_SUCCESS; i++) {
        const exr_attribute_t *attribute;
        result = exr_get_attribute_by_index(from, 0, EXR_ATTR_LIST_FILE_ORDER, i, &attribute);
        bool unknown = result == EXR_ERR_SUCCESS && attribute->type == EXR_ATTR_OPAQUE;
        if (unknown && strcmp(attribute->name, HDR_EXR_RECORD) != 0) /* that is a string, written already */
            result = exr_attr_set_user(context, 0, attribute->name, attribute->type_name, attribute->opaque->size,
                                       attribute->opaque->packed_data);
    }
    return result;
}

exr_result_t hdr_exr_put_attributes(exr_context_t context, const hdr_bytes *attributes, const char *record) {
    hdr_exr_text text;
    exr_context_t from;
    exr_attr_v2f_t centre;
    float width = 1;
    exr_result_t result = open_records(attributes->data, attributes->size, &text, &from);
    if (result == EXR_ERR_SUCCESS) result = exr_get_screen_window_center(from, 0, &centre);
    if (result == EXR_ERR_SUCCESS) result = exr_set_screen_window_center(context, 0, &centre);
    if (result == EXR_ERR_SUCCESS) result = exr_get_screen_window_width(from, 0, &width);
    if (result == EXR_ERR_SUCCESS) result = exr_set_screen_window_width(context, 0, width);
    if (result == EXR_ERR_SUCCESS && record) result = put_record(context, from, record);
    if (result == EXR_ERR_SUCCESS) result = put_unknown(context, from);
    if (result == EXR_ERR_SUCCESS) result = exr_copy_unset_attributes(context, 0, from, 0);
    if (from) exr_finish(&from);
    free(text.bytes.data);
    return result;
}

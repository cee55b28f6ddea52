#include "io/exr_text.h"

#include <stdio.h>
#include <string.h>

static int64_t read_text(exr_const_context_t context, void *user_data, void *buffer, uint64_t size, uint64_t offset,
                         exr_stream_error_func_ptr_t complain) {
    (void)context;
    (void)complain;
    const hdr_bytes *bytes = &((const hdr_exr_text *)user_data)->bytes;
    if (offset >= bytes->size) return 0;
    if (size > bytes->size - offset) size = bytes->size - offset;
    memcpy(buffer, bytes->data + offset, (size_t)size);
    return (int64_t)size;
}

static int64_t text_size(exr_const_context_t context, void *user_data) {
    (void)context;
    return (int64_t)((const hdr_exr_text *)user_data)->bytes.size;
}

/* The library would print. */
static void hear(exr_const_context_t context, exr_result_t code, const char *message) {
    void *user_data = NULL;
    (void)code;
    if (!context || exr_get_user_data(context, &user_data) != EXR_ERR_SUCCESS || !user_data) return;
    hdr_exr_text *text = user_data;
    if (text->listening && text->complaint[0] == '\0') snprintf(text->complaint, sizeof text->complaint, "%s", message);
}

exr_result_t hdr_exr_text_open(hdr_exr_text *text, exr_context_t *context) {
    exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
    initializer.user_data = text;
    initializer.read_fn = read_text;
    initializer.size_fn = text_size;
    initializer.error_handler_fn = hear;
    initializer.flags = EXR_CONTEXT_FLAG_STRICT_HEADER | EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    text->listening = true;
    exr_result_t result = exr_start_read(context, "header", &initializer);
    text->listening = false;
    if (result != EXR_ERR_SUCCESS) *context = NULL;
    return result;
}

/* Files taken apart, for the tests of nsdf/mux.h. */
#ifndef MUX_SAMPLES_H
#define MUX_SAMPLES_H

#include "make_file.h"
#include "nsdf/mux.h"

/* A write callback; user is an nsdf_buffer. */
static inline int append(void *user, const void *data, size_t size) {
    nsdf_buffer_append(user, data, size);
    return 0;
}

static inline nsdf_mux *open_mux(const void *data, size_t size) {
    nsdf_mux *mux = NULL;
    nsdf_encoder_error error;
    if (nsdf_mux_open(&mux, data, size, &error) != NSDF_OK)
        fail_msg("%s", error.message);
    return mux;
}

static inline nsdf_mux *open_part(const made_file *file, uint32_t first, uint32_t last) {
    nsdf_encoder_error error;
    nsdf_mux *mux = open_mux(file->data, file->size);
    assert_int_equal(nsdf_mux_cut(mux, first, last, &error), NSDF_OK);
    return mux;
}

#endif

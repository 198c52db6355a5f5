/* Whole encodings in memory, for the tests that go through the encoder's public interface. */
#ifndef ENCODE_SAMPLES_H
#define ENCODE_SAMPLES_H

#include <stdio.h>

#include "fit_samples.h"
#include "nsdf/decoder.h"

/* What came of an encoding. */
typedef struct encoded {
    nsdf_status status;
    nsdf_encoder_error error;
    nsdf_encoder_stats stats;
    uint8_t *data;
    size_t size;
} encoded;

/* Fills *mesh and its nominal number for the i-th frame to add; returns 0 behind the last.  The caller frees surface
 * and positions. */
typedef int (*frame_maker)(uint32_t i, nsdf_surface *surface, uint32_t *number);

/* Options for encodings in milliseconds: the file is valid, the surface need not look like anything. */
static inline nsdf_encoder_options hasty_options(void) {
    nsdf_encoder_options o = sample_options(2, 8);
    o.samples_per_frame = 1000;
    o.steps = 8;
    o.batch_frames = 2;
    o.batch_points = 64;
    o.verify = 0;
    o.resolution = 32;
    return o;
}

/* Finishes after the last step: strays are not searched for and repaired. */
static inline int skip_repair(void *user, const nsdf_progress *progress) {
    (void)user;
    return progress->stage == NSDF_STAGE_FIT && progress->fraction >= 1.0 ? NSDF_FINISH : NSDF_CONTINUE;
}

static inline int append_bytes(void *user, const void *data, size_t size) {
    encoded *e = user;
    uint8_t *more = realloc(e->data, e->size + size);
    if (!more)
        return -1;
    memcpy(more + e->size, data, size);
    e->data = more;
    e->size += size;
    return 0;
}

static inline nsdf_status add_frames(nsdf_encoder *encoder, frame_maker make, nsdf_encoder_error *error) {
    nsdf_surface surface;
    uint32_t number;
    nsdf_status status = NSDF_OK;
    for (uint32_t i = 0; status == NSDF_OK && make(i, &surface, &number); i++) {
        nsdf_input_mesh mesh = mesh_of(&surface, 1.0, 0.0, 0.0, 0.0);
        status = nsdf_encoder_add_frame(encoder, number, &mesh, error);
        free((void *)mesh.positions);
        nsdf_surface_free(&surface);
    }
    return status;
}

static inline encoded encode(const nsdf_encoder_options *options, frame_maker make, nsdf_progress_fn progress,
                             void *user) {
    encoded e;
    nsdf_encoder *encoder = NULL;
    memset(&e, 0, sizeof e);
    e.status = nsdf_encoder_create(&encoder, options, &e.error);
    if (e.status == NSDF_OK)
        e.status = add_frames(encoder, make, &e.error);
    if (e.status == NSDF_OK)
        e.status = nsdf_encoder_run(encoder, progress, user, &e.error);
    if (e.status == NSDF_OK)
        e.status = nsdf_encoder_write(encoder, append_bytes, &e, &e.error);
    if (encoder && nsdf_encoder_get_stats(encoder, &e.stats) != NSDF_OK)
        e.status = NSDF_INTERNAL;
    nsdf_encoder_close(&encoder);
    return e;
}

/* An encoding that must not fail. */
static inline encoded encode_well(const nsdf_encoder_options *options, frame_maker make, nsdf_progress_fn progress,
                                  void *user) {
    encoded e = encode(options, make, progress, user);
    if (e.status != NSDF_OK) {
        fprintf(stderr, "%s\n", e.error.message);
        abort();
    }
    return e;
}

static inline nsdf_decoder *open_file(const encoded *e) {
    nsdf_decoder *decoder = NULL;
    nsdf_decoder_options options;
    nsdf_decoder_options_init(&options);
    options.threads = 1;
    if (nsdf_open_memory(&decoder, e->data, e->size, &options, NULL) != NSDF_OK)
        abort();
    return decoder;
}

/* ---- Moving surfaces ------------------------------------------------------------------------------------ */

/* A long box: few cells in the grids on which the encoder checks its files, so that it is quick. */
static inline int long_box(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    if (i > 0)
        return 0;
    *surface = shape_cube(0.5);
    for (size_t k = 0; k < 24; k++)
        surface->positions[k] *= k % 3 ? 0.08f : 1.0f;
    *number = 0;
    return 1;
}

/* Three frames, numbered from 4 with gaps, of such a box that becomes thicker. */
static inline int swelling_box(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    static const uint32_t numbers[] = {4, 6, 12};
    if (i >= 3)
        return 0;
    *surface = shape_cube(0.5);
    for (size_t k = 0; k < 24; k++)
        surface->positions[k] *= k % 3 ? 0.08f + 0.01f * (float)i : 1.0f;
    *number = numbers[i];
    return 1;
}

/* Four frames of a sphere that grows from radius 1 to 1.3. */
static inline int growing_sphere(uint32_t i, nsdf_surface *surface, uint32_t *number) {
    if (i >= 4)
        return 0;
    *surface = shape_sphere(1.0 + 0.1 * i, 20, 40);
    *number = i;
    return 1;
}

#endif

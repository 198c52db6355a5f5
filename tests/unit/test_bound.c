/* The bound that small pieces of surface need, against what extraction finds with it. */
#include "bound.h"
#include "bound_pieces.h"
#include "decoded_surface.h"
#include "nsdf/export.h"
#include "surface_error.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../make_file.h"

enum { RESOLUTION = 64, FILES = 10 };

/* A copy of the file with another bound. */
static nsdf_decoder *open_with(const made_file *file, double bound, nsdf_buffer *copy) {
    const size_t after = NSDF_PREAMBLE_SIZE + NSDF_CHUNK_OVERHEAD + NSDF_HEADER_PAYLOAD_SIZE;
    nsdf_file_header header = file->header;
    nsdf_buffer payload = {NULL, 0, 0, 0};
    nsdf_decoder *decoder = NULL;
    header.extraction_bound = (float)bound;
    copy->size = 0;
    nsdf_write_preamble(copy);
    nsdf_write_header(&payload, &header);
    nsdf_write_chunk(copy, NSDF_CHUNK_HEAD, NSDF_CHUNK_CRITICAL, payload.data, payload.size);
    nsdf_buffer_append(copy, file->data + after, file->size - after);
    assert_int_equal(nsdf_open_memory(&decoder, copy->data, copy->size, NULL, NULL), NSDF_OK);
    nsdf_buffer_free(&payload);
    return decoder;
}

static nsdf_mesh *extract(nsdf_decoder *decoder, uint32_t resolution, uint32_t dense) {
    nsdf_mesh_options options;
    nsdf_mesh *mesh = NULL;
    nsdf_mesh_options_init(&options);
    options.resolution = resolution;
    options.dense = dense;
    options.all_pieces = 1;
    assert_int_equal(nsdf_extract_mesh(decoder, 0.1, &options, &mesh), NSDF_OK);
    return mesh;
}

static uint64_t hash_with(const made_file *file, double bound, uint32_t resolution, uint32_t dense) {
    nsdf_buffer copy = {NULL, 0, 0, 0};
    nsdf_decoder *decoder = open_with(file, bound, &copy);
    nsdf_mesh *mesh = extract(decoder, resolution, dense);
    nsdf_mesh_view view;
    assert_int_equal(nsdf_mesh_get_view(mesh, &view), NSDF_OK);
    const uint64_t hash = nsdf_mesh_hash(&view);
    nsdf_mesh_free(&mesh);
    nsdf_close(&decoder);
    nsdf_buffer_free(&copy);
    return hash;
}

/* Of the dense mesh's pieces, whose number goes to *pieces. */
static double find_bound(const made_file *file, uint32_t *pieces) {
    nsdf_buffer copy = {NULL, 0, 0, 0};
    nsdf_decoder *decoder = open_with(file, 100.0, &copy);
    nsdf_mesh *mesh = extract(decoder, RESOLUTION, 1);
    nsdf_surface surface;
    assert_int_equal(nsdf_decoded_surface(&file->header, mesh, &surface), 0);
    uint32_t *piece = malloc((surface.triangle_count + 1u) * sizeof *piece);
    double bound = 0.0;
    *pieces = (uint32_t)nsdf_surface_components(&surface, piece);
    assert_int_equal(nsdf_bound_of_pieces(decoder, 0.1, &file->header, &surface, piece, *pieces, &bound), NSDF_OK);
    free(piece);
    nsdf_surface_free(&surface);
    nsdf_mesh_free(&mesh);
    nsdf_close(&decoder);
    nsdf_buffer_free(&copy);
    return bound;
}

static void pieces_are_found_with_it_and_not_with_less(void **state) {
    uint32_t some = 0, lost = 0;
    (void)state;
    for (uint32_t i = 0; i < FILES; i++) {
        made_file file;
        make_sized_file(&file, 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 4, 24, i + 1);
        uint32_t pieces = 0;
        const double bound = find_bound(&file, &pieces);
        const uint64_t dense = hash_with(&file, 1.0, RESOLUTION, 1);
        assert_true((bound > 0.0) == (pieces > 1));
        if (pieces > 1) {
            some++;
            lost += hash_with(&file, 0.5 * bound, RESOLUTION, 0) != dense;
            for (uint32_t r = RESOLUTION; r <= RESOLUTION * 3 / 2; r += RESOLUTION / 2)
                assert_true(hash_with(&file, 1.05 * bound, r, 0) == hash_with(&file, 1.05 * bound, r, 1));
        }
        free_file(&file);
    }
    assert_true(some > 0 && lost > 0);
}

static double work_of(uint32_t count, int verify) {
    nsdf_encoder_options options;
    nsdf_encoder_options_init(&options, NSDF_PRESET_FAST);
    options.verify = verify;
    const nsdf_frames frames = {.count = count};
    const nsdf_check_job job = {.frames = &frames, .options = &options};
    return nsdf_bound_work(&job);
}

/* Half of what is measured, and half of what is extracted densely. */
static void a_third_of_many_frames_stands_for_all_that_are_verified(void **state) {
    (void)state;
    assert_float_equal(work_of(5, 1), 0.5 * (5 + 5), 0.0);
    assert_float_equal(work_of(64, 1), 0.5 * (64 + 12), 0.0);
    assert_float_equal(work_of(175, 1), 0.5 * (64 + 12), 0.0);
    assert_float_equal(work_of(301, 1), 0.5 * (101 + 12), 0.0);
    assert_float_equal(work_of(301, 0), 0.5 * (301 + 12), 0.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pieces_are_found_with_it_and_not_with_less),
        cmocka_unit_test(a_third_of_many_frames_stands_for_all_that_are_verified),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

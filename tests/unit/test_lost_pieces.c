/* Pieces of the surface that a file says to leave out, and the size that suits it better; pieces that are astray. */
#include "decoded_surface.h"
#include "lost_pieces.h"
#include "surface_error.h"
#include "verify_segment.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../make_file.h"

enum { RESOLUTION = 48, FILES = 30 };
static const float limit = 0.3f;

/* A random network with several pieces, of which smaller ones than `smallest` are left out. */
static nsdf_decoder *open_made(made_file *file, float smallest, uint64_t seed) {
    nsdf_buffer payloads[MAKE_MAX_SEGMENTS] = {{NULL, 0, 0, 0}};
    nsdf_decoder *decoder = NULL;
    memset(file, 0, sizeof *file);
    make_segment(file, 0, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 4, 24, &seed, &payloads[0]);
    file->entries[0].smallest_piece = smallest;
    make_header(&file->header, 5, 1);
    file->header.default_resolution = RESOLUTION;
    make_container_with_header(file, 1, payloads);
    assert_int_equal(nsdf_open_memory(&decoder, file->data, file->size, NULL, NULL), NSDF_OK);
    return decoder;
}

static nsdf_surface all_pieces(const made_file *file, nsdf_decoder *decoder) {
    nsdf_mesh_options options;
    nsdf_surface surface;
    nsdf_mesh *mesh = NULL;
    nsdf_mesh_options_init(&options);
    options.normals = 0;
    options.all_pieces = 1;
    assert_int_equal(nsdf_extract_mesh(decoder, 0.0, &options, &mesh), NSDF_OK);
    assert_int_equal(nsdf_decoded_surface(&file->header, mesh, &surface), 0);
    nsdf_mesh_free(&mesh);
    return surface;
}

/* Of at least NSDF_LEAST_LOST. */
static float smallest_of(const nsdf_surface *surface) {
    uint32_t *piece = malloc((surface->triangle_count + 1u) * sizeof *piece);
    const int64_t count = nsdf_surface_components(surface, piece);
    float *size = malloc(((size_t)count + 1u) * sizeof *size), smallest = INFINITY;
    assert_int_equal(nsdf_piece_sizes(surface, piece, (uint32_t)count, size), 0);
    for (int64_t p = 0; p < count; p++)
        smallest = size[p] < NSDF_LEAST_LOST ? smallest : fminf(smallest, size[p]);
    free(size);
    free(piece);
    return smallest;
}

static void test_pieces_at_the_surface_are_found(void **state) {
    (void)state;
    for (uint32_t i = 0; i < FILES; i++) {
        made_file file;
        nsdf_decoder *decoder = open_made(&file, limit, i + 1);
        nsdf_surface surface = all_pieces(&file, decoder);
        float smallest = INFINITY;
        if (surface.triangle_count > 0) {
            assert_int_equal(nsdf_find_lost_pieces(decoder, 0.0, &file.header, &surface, &smallest), NSDF_OK);
            assert_true(!(smallest < smallest_of(&surface)) && !(smallest > smallest_of(&surface)));
            for (size_t v = 0; v < 3 * (size_t)surface.vertex_count; v++)
                surface.positions[v] += 2.0f; /* the input is elsewhere */
            smallest = 1.0f;
            assert_int_equal(nsdf_find_lost_pieces(decoder, 0.0, &file.header, &surface, &smallest), NSDF_OK);
            assert_true(!(smallest < 1.0f));
        }
        nsdf_surface_free(&surface);
        nsdf_close(&decoder);
        free_file(&file);
    }
}

/* Goes on from what *found holds. */
static nsdf_piece_report verify(const made_file *file, nsdf_surface surface, nsdf_frame_check *found) {
    nsdf_encoder_options options;
    nsdf_encoder_options_init(&options, NSDF_PRESET_FAST);
    nsdf_frame frame = {.surface = surface};
    const nsdf_frames frames = {.frames = &frame, .count = 1};
    const nsdf_check_job job = {&frames, &file->header, &options, NULL, NULL, 0.0, &frames};
    const nsdf_buffer bytes = {file->data, file->size, file->size, 0};
    nsdf_workers *workers = nsdf_workers_create(1);
    nsdf_sample_set strays = {0};
    nsdf_encoder_error error;
    assert_int_equal(nsdf_verify_file(&job, workers, &bytes, found, &strays, &error), NSDF_OK);
    assert_true(found->is_done);
    nsdf_sample_set_free(&strays);
    nsdf_workers_free(workers);
    return nsdf_pieces_of_checks(found, 1);
}

/* The whole surface is asked for, and small pieces are left out: with the size that suits, none is. */
static void test_verification_finds_what_was_left_out(void **state) {
    nsdf_encoder_options options;
    const nsdf_frames none = {0};
    uint32_t lost = 0;
    (void)state;
    nsdf_encoder_options_init(&options, NSDF_PRESET_FAST);
    for (uint32_t i = 0; i < FILES; i++) {
        made_file file, better;
        nsdf_decoder *decoder = open_made(&file, limit, i + 1);
        nsdf_surface surface = all_pieces(&file, decoder);
        const float smallest = smallest_of(&surface);
        float size = limit;
        if (smallest < limit) {
            nsdf_frame_check found = {0}, anew = {0};
            const nsdf_piece_report pieces = verify(&file, surface, &found);
            assert_true(!(pieces.smallest_lost < smallest) && !(pieces.smallest_lost > smallest));
            assert_true(nsdf_suit_smallest_piece(&pieces, &none, &options, &size) && size < smallest);
            nsdf_decoder *other = open_made(&better, size, i + 1);
            assert_true(isinf(verify(&better, surface, &found).smallest_lost));
            (void)verify(&better, surface, &anew);
            assert_true(found.mean[0] == anew.mean[0] && found.max[1] == anew.max[1] && found.dropped == anew.dropped);
            found.mean[0] = 7.0; /* what holds is not looked at again */
            (void)verify(&better, surface, &found);
            assert_true(found.mean[0] == 7.0);
            nsdf_close(&other);
            free_file(&better);
            lost++;
        }
        nsdf_surface_free(&surface);
        nsdf_close(&decoder);
        free_file(&file);
    }
    assert_true(lost > 1);
}

/* ---- Pieces astray ------------------------------------------------------------------------------------------ */

/* With fewer triangles, a hole in a piece would be a large part of it. */
enum { MANY_TRIANGLES = 400 };

/* A piece with many triangles that is not the largest; its number, or UINT32_MAX. */
static uint32_t pick_piece(const nsdf_surface *s, uint32_t *piece) {
    const int64_t count = nsdf_surface_components(s, piece);
    uint32_t *triangles = malloc(((size_t)count + 1u) * sizeof *triangles), picked = UINT32_MAX;
    assert_true(count > 0);
    const uint32_t largest = nsdf_largest_piece(s, piece, (uint32_t)count, triangles);
    for (uint32_t p = 0; p < (uint32_t)count; p++)
        if (p != largest && triangles[p] >= MANY_TRIANGLES)
            picked = p;
    free(triangles);
    return picked;
}

static float distance_to(const nsdf_surface *s, uint32_t triangle, const float *centre) {
    const float *v = s->positions + 3 * (size_t)s->indices[3 * (size_t)triangle];
    return sqrtf((v[0] - centre[0]) * (v[0] - centre[0]) + (v[1] - centre[1]) * (v[1] - centre[1]) +
                 (v[2] - centre[2]) * (v[2] - centre[2]));
}

/* What verification says of the decoded surface where the input has no triangles of the piece within the radius of the
 * piece's first triangle. */
static nsdf_piece_report verify_without(const made_file *file, const nsdf_surface *s, const uint32_t *piece,
                                        uint32_t picked, float radius, double *back) {
    nsdf_surface rest = *s;
    nsdf_frame_check found = {0};
    const float *centre = NULL;
    rest.indices = malloc(3 * (size_t)s->triangle_count * sizeof *rest.indices);
    rest.triangle_count = 0;
    for (uint32_t i = 0; i < s->triangle_count; i++) {
        if (piece[i] == picked && !centre)
            centre = s->positions + 3 * (size_t)s->indices[3 * (size_t)i];
        if (piece[i] == picked && distance_to(s, i, centre) < radius)
            continue;
        memcpy(rest.indices + 3 * (size_t)rest.triangle_count++, s->indices + 3 * (size_t)i, 3 * sizeof(uint32_t));
    }
    const nsdf_piece_report report = verify(file, rest, &found);
    *back = found.max[1];
    free(rest.indices);
    return report;
}

/* A piece that the input has is not astray because of a few vertices that the input has not. */
static void test_a_piece_is_astray_but_not_for_a_few_vertices(void **state) {
    uint32_t tried = 0;
    (void)state;
    for (uint32_t i = 0; i < FILES; i++) {
        made_file file;
        nsdf_decoder *decoder = open_made(&file, 0.0f, i + 1);
        nsdf_surface surface = all_pieces(&file, decoder);
        uint32_t *piece = malloc((surface.triangle_count + 1u) * sizeof *piece);
        const uint32_t picked = surface.triangle_count > 0 ? pick_piece(&surface, piece) : UINT32_MAX;
        if (picked != UINT32_MAX) {
            double back = 0.0;
            assert_int_equal(verify_without(&file, &surface, piece, picked, 0.03f, &back).stray, 0);
            assert_true(back > (double)NSDF_STRAY_DISTANCE);
            assert_int_equal(verify_without(&file, &surface, piece, picked, 1.0f, &back).stray, 1);
            tried++;
        }
        free(piece);
        nsdf_surface_free(&surface);
        nsdf_close(&decoder);
        free_file(&file);
    }
    assert_true(tried > 1);
}

/* ---- Options ------------------------------------------------------------------------------------------------ */

static void test_the_options_have_the_last_word(void **state) {
    const nsdf_piece_report lost = {0, 0.0f, INFINITY, 0.05f, 0.0}, specks = {3, 0.1f, 0.6f, INFINITY, 0.0};
    nsdf_frame frame = {.smallest_piece = 0.9f};
    const nsdf_frames frames = {.frames = &frame, .count = 1};
    nsdf_encoder_options options;
    float size = 0.08f;
    (void)state;
    nsdf_encoder_options_init(&options, NSDF_PRESET_FAST);
    assert_true(nsdf_suit_smallest_piece(&lost, &frames, &options, &size) && size < 0.05f && size > 0.03f);
    assert_true(nsdf_suit_smallest_piece(&specks, &frames, &options, &size) && size > 0.1f && size < 0.2f);
    assert_false(
        nsdf_suit_smallest_piece(&(nsdf_piece_report){0, 0.0f, 0.5f, INFINITY, 0.0}, &frames, &options, &size));
    options.smallest_piece = 0.08;
    size = 0.08f;
    assert_false(nsdf_suit_smallest_piece(&lost, &frames, &options, &size));
    assert_false(nsdf_suit_smallest_piece(&specks, &frames, &options, &size));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pieces_at_the_surface_are_found),
        cmocka_unit_test(test_verification_finds_what_was_left_out),
        cmocka_unit_test(test_a_piece_is_astray_but_not_for_a_few_vertices),
        cmocka_unit_test(test_the_options_have_the_last_word),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

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

enum { RESOLUTION = 48, FILES = 10 };
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

/* ---- A size that is tried ----------------------------------------------------------------------------------- */

enum { SHOWN = 3, TRIED_FILES = 4 };
static const float away = 0.03f;

/* A segment with its input: all pieces that the model has in the first frames, only the large ones in the others, and
 * in the last frame a little away from where they are, so that there is surface astray whatever the size. */
typedef struct {
    made_file file;
    nsdf_coded_segment segment;
    nsdf_frame frames[SHOWN];
    nsdf_frames all;
    nsdf_encoder_options options;
    nsdf_check_job job;
    nsdf_workers *workers;
} checked;

static nsdf_surface pieces_at(const checked *c, nsdf_decoder *decoder, uint32_t frame, uint32_t all) {
    nsdf_mesh_options options;
    nsdf_surface surface;
    nsdf_mesh *mesh = NULL;
    double time = 0.0;
    nsdf_mesh_options_init(&options);
    options.all_pieces = all;
    assert_int_equal(nsdf_frame_time(decoder, frame, &time), NSDF_OK);
    assert_int_equal(nsdf_extract_mesh(decoder, time, &options, &mesh), NSDF_OK);
    assert_int_equal(nsdf_decoded_surface(&c->file.header, mesh, &surface), 0);
    nsdf_mesh_free(&mesh);
    return surface;
}

static nsdf_buffer assemble(const checked *c, float size) {
    nsdf_buffer bytes = {NULL, 0, 0, 0};
    nsdf_index_entry entry = {.smallest_piece = size};
    assert_int_equal(nsdf_assemble_file(&c->file.header, &entry, &c->segment, NULL, &bytes), 0);
    return bytes;
}

static void start_checked(checked *c, uint64_t seed, uint32_t whole) {
    nsdf_decoder *decoder = NULL;
    memset(c, 0, sizeof *c);
    make_segment(&c->file, 0, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 4, 24, &seed, &c->segment.payload);
    make_header(&c->file.header, SHOWN, 1);
    c->file.header.default_resolution = RESOLUTION;
    c->segment.hash = c->file.entries[0].parameter_hash;
    nsdf_buffer bytes = assemble(c, limit);
    assert_int_equal(nsdf_open_memory(&decoder, bytes.data, bytes.size, NULL, NULL), NSDF_OK);
    for (uint32_t f = 0; f < SHOWN; f++) {
        c->frames[f].number = f;
        c->frames[f].surface = pieces_at(c, decoder, f, f < whole);
    }
    for (size_t v = 0; v < c->frames[SHOWN - 1].surface.vertex_count; v++)
        c->frames[SHOWN - 1].surface.positions[3 * v] += away;
    nsdf_close(&decoder);
    nsdf_buffer_free(&bytes);
    nsdf_encoder_options_init(&c->options, NSDF_PRESET_FAST);
    c->options.resolution = RESOLUTION;
    c->all = (nsdf_frames){.frames = c->frames, .count = SHOWN};
    c->job = (nsdf_check_job){&c->all, &c->file.header, &c->options, NULL, NULL, 0.0, &c->all};
    c->workers = nsdf_workers_create(1);
}

static void end_checked(checked *c) {
    for (uint32_t f = 0; f < SHOWN; f++)
        nsdf_surface_free(&c->frames[f].surface);
    nsdf_buffer_free(&c->segment.payload);
    nsdf_workers_free(c->workers);
    free_file(&c->file);
}

static void free_strays(nsdf_sample_set *strays) {
    for (uint32_t f = 0; f < SHOWN; f++)
        nsdf_sample_set_free(&strays[f]);
}

/* What verification says of the file with a size; returns the error of both ways.  `points`: of strays. */
static double verify_size(const checked *c, float size, nsdf_quality_record *quality, size_t *points) {
    nsdf_sample_set strays[SHOWN] = {{0}};
    nsdf_frame_check checks[SHOWN] = {{.is_done = false}};
    nsdf_buffer bytes = assemble(c, size);
    nsdf_encoder_error error;
    assert_int_equal(nsdf_verify_file(&c->job, c->workers, &bytes, checks, strays, &error), NSDF_OK);
    *quality = nsdf_quality_of_checks(checks, SHOWN, RESOLUTION);
    *points = 0;
    for (uint32_t f = 0; f < SHOWN; f++)
        *points += strays[f].count;
    free_strays(strays);
    nsdf_buffer_free(&bytes);
    return quality->mean[0] + quality->mean[1];
}

/* Whether another size was taken for the segment; -1 when none was asked for. */
static int try_another(const checked *c) {
    nsdf_sample_set strays[SHOWN] = {{0}};
    nsdf_index_entry entry = {.smallest_piece = limit};
    nsdf_quality_record found, first, other, *right;
    nsdf_piece_report pieces;
    nsdf_encoder_error error;
    float size = limit;
    size_t points[2], count = 0;
    const double before = verify_size(c, limit, &first, &points[0]);
    assert_int_equal(nsdf_verify_segment(&c->job, c->workers, &c->segment, &entry, &found, &pieces, strays, &error),
                     NSDF_OK);
    const int taken = entry.smallest_piece < limit;
    if (taken)
        size = entry.smallest_piece;
    else
        (void)nsdf_suit_smallest_piece(&pieces, &c->all, &c->options, &size);
    const double after = verify_size(c, size, &other, &points[1]);
    right = taken ? &other : &first;
    assert_true(taken ? after < before : !(after < before));
    assert_memory_equal(found.mean, right->mean, sizeof found.mean);
    assert_memory_equal(found.max, right->max, sizeof found.max);
    for (uint32_t f = 0; f < SHOWN; f++)
        count += strays[f].count;
    assert_int_equal(count, points[taken]);
    assert_true(count > 0);
    free_strays(strays);
    return size < limit ? taken : -1;
}

static int has_surfaces(const checked *c) {
    for (uint32_t f = 0; f < SHOWN; f++)
        if (c->frames[f].surface.triangle_count == 0)
            return 0;
    return 1;
}

/* A smaller size brings back what the first frames lost, and with it what the others should not have. */
static void test_another_size_is_taken_where_it_makes_the_whole_better(void **state) {
    uint32_t taken = 0, refused = 0;
    (void)state;
    for (uint32_t i = 0; i < TRIED_FILES; i++) {
        checked c;
        start_checked(&c, i + 1, 1 + i % 2);
        const int answer = has_surfaces(&c) ? try_another(&c) : -1;
        taken += answer == 1;
        refused += answer == 0;
        end_checked(&c);
    }
    assert_true(taken > 0);
    assert_true(refused > 0);
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
        cmocka_unit_test(test_another_size_is_taken_where_it_makes_the_whole_better),
        cmocka_unit_test(test_a_piece_is_astray_but_not_for_a_few_vertices),
        cmocka_unit_test(test_the_options_have_the_last_word),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

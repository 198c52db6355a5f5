/* Extraction through the public functions: ownership, buffers, limits, cancelling. */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <time.h>

#include "make_file.h"
#include "nsdf/decoder.h"

static nsdf_decoder *open_made(made_file *file, uint32_t threads) {
    nsdf_decoder_options options;
    nsdf_decoder *decoder = NULL;
    make_file(file, 2, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 4);
    nsdf_decoder_options_init(&options);
    options.threads = threads;
    assert_int_equal(nsdf_open_memory(&decoder, file->data, file->size, &options, NULL), NSDF_OK);
    return decoder;
}

static nsdf_mesh_view view_of(const nsdf_mesh *mesh) {
    nsdf_mesh_view view;
    assert_int_equal(nsdf_mesh_get_view(mesh, &view), NSDF_OK);
    return view;
}

static void assert_same(const nsdf_mesh_view *a, const nsdf_mesh_view *b) {
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->triangle_count, b->triangle_count);
    assert_memory_equal(a->positions, b->positions, 12 * (size_t)a->vertex_count);
    assert_memory_equal(a->indices, b->indices, 12 * (size_t)a->triangle_count);
    if (a->normals)
        assert_memory_equal(a->normals, b->normals, 12 * (size_t)a->vertex_count);
}

/* Where a surface that leaves the domain is closed. */
static int is_at_boundary(const made_file *file, const float *position) {
    const double cell = file->header.scale * 0.75 / file->header.default_resolution;
    int at = 0;
    for (int axis = 0; axis < 3; axis++) {
        const double x = ((double)position[axis] - file->header.centre[axis]);
        at |= x - (double)file->header.domain_min[axis] * file->header.scale < cell;
        at |= (double)file->header.domain_max[axis] * file->header.scale - x < cell;
    }
    return at;
}

static void test_a_mesh_lies_on_the_zero_set_and_outlives_the_handle(void **state) {
    made_file file;
    nsdf_mesh *mesh = NULL;
    (void)state;
    nsdf_decoder *decoder = open_made(&file, 2);
    assert_int_equal(nsdf_extract_mesh(decoder, 0.1, NULL, &mesh), NSDF_OK);
    const nsdf_mesh_view view = view_of(mesh);
    assert_true(view.vertex_count > 100 && view.triangle_count > 100 && view.normals);
    float *distance = malloc(view.vertex_count * sizeof *distance);
    assert_non_null(distance);
    assert_int_equal(nsdf_evaluate(decoder, 0.1, view.positions, view.vertex_count, distance, NULL), NSDF_OK);
    uint32_t close = 0;
    for (uint32_t i = 0; i < view.vertex_count; i++) {
        const int on_surface = fabsf(distance[i]) < 0.05f;
        assert_true(on_surface || is_at_boundary(&file, view.positions + 3 * i));
        close += on_surface != 0;
    }
    assert_true(close > 100);
    free(distance);
    nsdf_close(&decoder);
    float sum = 0.0f;
    for (uint32_t i = 0; i < 3 * view.vertex_count; i++)
        sum += view.positions[i] + view.normals[i];
    assert_true(isfinite(sum));
    nsdf_mesh_free(&mesh);
    assert_null(mesh);
    free_file(&file);
}

static void test_threads_and_reuse_give_the_same_mesh(void **state) {
    made_file file;
    nsdf_mesh *first = NULL, *again = NULL;
    (void)state;
    nsdf_decoder *decoder = open_made(&file, 1);
    assert_int_equal(nsdf_extract_mesh(decoder, 0.1, NULL, &first), NSDF_OK);
    assert_int_equal(nsdf_extract_mesh(decoder, 0.3, NULL, &again), NSDF_OK);
    assert_int_equal(nsdf_extract_mesh(decoder, 0.1, NULL, &again), NSDF_OK);
    nsdf_mesh_view a = view_of(first), b = view_of(again);
    assert_same(&a, &b);
    nsdf_close(&decoder);
    for (uint32_t threads = 2; threads <= 4; threads++) {
        free_file(&file);
        decoder = open_made(&file, threads);
        assert_int_equal(nsdf_extract_mesh(decoder, 0.1, NULL, &again), NSDF_OK);
        b = view_of(again);
        assert_same(&a, &b);
        nsdf_close(&decoder);
    }
    nsdf_mesh_free(&first);
    nsdf_mesh_free(&again);
    free_file(&file);
}

static void test_buffers_of_the_size_asked_for_are_enough(void **state) {
    made_file file;
    nsdf_mesh *mesh = NULL;
    nsdf_mesh_buffers buffers;
    (void)state;
    nsdf_decoder *decoder = open_made(&file, 1);
    memset(&buffers, 0, sizeof buffers);
    assert_int_equal(nsdf_extract_mesh_into(decoder, 0.1, NULL, &buffers), NSDF_BUFFER_TOO_SMALL);
    assert_true(buffers.vertex_count > 0 && buffers.triangle_count > 0);
    const size_t vectors = 3 * (size_t)buffers.vertex_count, corners = 3 * (size_t)buffers.triangle_count;
    float *positions = malloc(vectors * sizeof(float)), *normals = malloc(vectors * sizeof(float));
    uint32_t *indices = malloc(corners * sizeof(uint32_t));
    assert_true(positions && normals && indices);
    buffers = (nsdf_mesh_buffers){positions, normals, indices, buffers.vertex_count, buffers.triangle_count, 0, 0};
    assert_int_equal(nsdf_extract_mesh_into(decoder, 0.1, NULL, &buffers), NSDF_OK);
    assert_int_equal(nsdf_extract_mesh(decoder, 0.1, NULL, &mesh), NSDF_OK);
    const nsdf_mesh_view a = view_of(mesh);
    const nsdf_mesh_view b = {positions, normals, indices, buffers.vertex_count, buffers.triangle_count};
    assert_same(&a, &b);
    positions[0] = -1234.0f;
    buffers.triangle_capacity--;
    assert_int_equal(nsdf_extract_mesh_into(decoder, 0.1, NULL, &buffers), NSDF_BUFFER_TOO_SMALL);
    assert_true(positions[0] == -1234.0f);
    buffers.triangle_capacity++;
    buffers.positions = NULL;
    assert_int_equal(nsdf_extract_mesh_into(decoder, 0.1, NULL, &buffers), NSDF_INVALID_ARGUMENT);
    free(positions);
    free(normals);
    free(indices);
    nsdf_mesh_free(&mesh);
    nsdf_close(&decoder);
    free_file(&file);
}

static int cancel_at_once(void *user) {
    ++*(int *)user;
    return 1;
}

static void test_options_out_of_range_are_refused(void **state) {
    made_file file;
    nsdf_mesh *mesh = NULL;
    nsdf_mesh_options options;
    (void)state;
    nsdf_decoder *decoder = open_made(&file, 1);
    nsdf_mesh_options_init(&options);
    assert_int_equal(options.struct_size, sizeof options);
    options.resolution = 1;
    assert_int_equal(nsdf_extract_mesh(decoder, 0.1, &options, &mesh), NSDF_INVALID_ARGUMENT);
    options.resolution = 1025;
    assert_int_equal(nsdf_extract_mesh(decoder, 0.1, &options, &mesh), NSDF_LIMIT);
    nsdf_mesh_options_init(&options);
    options.projection = 9;
    assert_int_equal(nsdf_extract_mesh(decoder, 0.1, &options, &mesh), NSDF_INVALID_ARGUMENT);
    options.struct_size = 0;
    assert_int_equal(nsdf_extract_mesh(decoder, 0.1, &options, &mesh), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_extract_mesh(decoder, (double)NAN, NULL, &mesh), NSDF_INVALID_ARGUMENT);
    assert_null(mesh);
    options.projection = 9; /* behind the size given: not looked at */
    options.normals = 0;
    options.struct_size = offsetof(nsdf_mesh_options, projection);
    assert_int_equal(nsdf_extract_mesh(decoder, 0.1, &options, &mesh), NSDF_OK);
    assert_null(view_of(mesh).normals);
    nsdf_mesh_free(&mesh);
    nsdf_close(&decoder);
    free_file(&file);
}

static void test_cancelling_leaves_an_empty_mesh(void **state) {
    made_file file;
    nsdf_mesh *mesh = NULL;
    nsdf_mesh_options options;
    int calls = 0;
    (void)state;
    nsdf_decoder *decoder = open_made(&file, 2);
    assert_int_equal(nsdf_extract_mesh(decoder, 0.1, NULL, &mesh), NSDF_OK);
    nsdf_mesh_options_init(&options);
    options.cancel = cancel_at_once;
    options.cancel_user = &calls;
    assert_int_equal(nsdf_extract_mesh(decoder, 0.1, &options, &mesh), NSDF_CANCELLED);
    assert_true(calls > 0);
    const nsdf_mesh_view view = view_of(mesh);
    assert_int_equal(view.vertex_count, 0);
    assert_int_equal(view.triangle_count, 0);
    assert_int_equal(nsdf_extract_mesh(decoder, 0.1, NULL, &mesh), NSDF_OK);
    assert_true(view_of(mesh).vertex_count > 0);
    nsdf_mesh_free(&mesh);
    nsdf_close(&decoder);
    free_file(&file);
}

/* The user of a cancel callback that asks for it some time after the start, and knows the longest pause. */
typedef struct stopwatch {
    double start, after, last, longest, asked;
} stopwatch;

/* Processor time, so that other programs do not count. */
static double processor_time(void) {
    struct timespec now;
    assert_int_equal(clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now), 0);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int cancel_after(void *user) {
    stopwatch *w = user;
    const double now = processor_time();
    w->longest = now - w->last > w->longest ? now - w->last : w->longest;
    w->last = now;
    if (now - w->start < w->after)
        return 0;
    w->asked = w->asked > 0.0 ? w->asked : now;
    return 1;
}

#if defined(__has_feature)
#define HAS_FEATURE(name) __has_feature(name)
#else
#define HAS_FEATURE(name) 0
#endif

/* Sanitizers make everything slower, by factors of their own: there a pause may be a share of the whole extraction, as
 * the same build does it. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || HAS_FEATURE(address_sanitizer) ||                 \
    HAS_FEATURE(thread_sanitizer) || HAS_FEATURE(memory_sanitizer)
static const double share_of_pause = 0.05;
#else
static const double share_of_pause = 0.0;
#endif

/* Of an extraction that takes so long as a whole.  An emulator (tests/arm/run.sh) is some fifty times slower than a
 * processor. */
static double longest_pause(double whole) {
    return fmax(getenv("NSDF_TEST_EMULATED") ? 0.5 : 0.010, share_of_pause * whole);
}

/* The longest of the time between two questions and the time from the answer to the return; 0 when it was not asked. */
static double cancel_pause(nsdf_decoder *decoder, double after, nsdf_mesh **mesh) {
    const double start = processor_time();
    stopwatch w = {start, after, start, 0.0, 0.0};
    nsdf_mesh_options options;
    nsdf_mesh_options_init(&options);
    options.resolution = 200;
    options.cancel = cancel_after;
    options.cancel_user = &w;
    if (nsdf_extract_mesh(decoder, 0.1, &options, mesh) != NSDF_CANCELLED)
        return 0.0;
    const double took = processor_time() - w.asked;
    return w.longest > took ? w.longest : took;
}

static void test_cancelling_takes_at_most_ten_milliseconds(void **state) {
    made_file file;
    nsdf_mesh *mesh = NULL;
    (void)state;
    nsdf_decoder *decoder = open_made(&file, 1);
    assert_true(cancel_pause(decoder, 1e9, &mesh) == 0.0); /* memory that grows is copied: once, before */
    const double start = processor_time();
    assert_true(cancel_pause(decoder, 1e9, &mesh) == 0.0);
    const double whole = processor_time() - start, allowed = longest_pause(whole);
    for (int i = 0; i < 10; i++) {
        const double after = 0.1 * i * whole;
        double best = 1.0; /* of three tries: pages and caches are warm from the second on */
        for (int again = 0; again < 3 && best > allowed; again++)
            best = fmin(best, cancel_pause(decoder, after, &mesh));
        assert_true(best <= allowed);
    }
    nsdf_mesh_free(&mesh);
    nsdf_close(&decoder);
    free_file(&file);
}

static void test_a_time_budget_chooses_the_resolution_only(void **state) {
    made_file file;
    nsdf_mesh *mesh = NULL, *plain = NULL;
    nsdf_mesh_options options;
    uint32_t resolution = 0;
    (void)state;
    nsdf_decoder *decoder = open_made(&file, 1);
    nsdf_mesh_options_init(&options);
    options.resolution = 100;
    for (int i = 0; i < 3; i++) {
        const double budgets[3] = {0.0, 1e9, 0.004};
        assert_int_equal(nsdf_extract_mesh_within(decoder, 0.1, &options, budgets[i], &mesh, &resolution), NSDF_OK);
        assert_in_range(resolution, 32, 100);
        assert_true(i != 0 || resolution == 32);
        assert_true(i != 1 || resolution == 100);
        nsdf_mesh_options same = options;
        same.resolution = resolution;
        assert_int_equal(nsdf_extract_mesh(decoder, 0.1, &same, &plain), NSDF_OK);
        const nsdf_mesh_view a = view_of(mesh), b = view_of(plain);
        assert_same(&a, &b);
    }
    options.resolution = 20;
    assert_int_equal(nsdf_extract_mesh_within(decoder, 0.1, &options, 0.0, &mesh, &resolution), NSDF_OK);
    assert_int_equal(resolution, 20);
    assert_int_equal(nsdf_extract_mesh_within(decoder, 0.1, &options, (double)NAN, &mesh, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_extract_mesh_within(decoder, 0.1, &options, -1.0, &mesh, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_extract_mesh_within(NULL, 0.1, &options, 1.0, &mesh, NULL), NSDF_INVALID_ARGUMENT);
    int calls = 0;
    options.resolution = 100;
    options.cancel = cancel_at_once;
    options.cancel_user = &calls;
    assert_int_equal(nsdf_extract_mesh_within(decoder, 0.1, &options, 1.0, &mesh, NULL), NSDF_CANCELLED);
    nsdf_mesh_free(&mesh);
    nsdf_mesh_free(&plain);
    nsdf_close(&decoder);
    free_file(&file);
}

static void test_the_first_frame_climbs_as_long_as_there_is_time(void **state) {
    made_file file;
    nsdf_mesh *mesh = NULL;
    nsdf_mesh_options options;
    uint32_t resolution = 0;
    (void)state;
    nsdf_decoder *decoder = open_made(&file, 1);
    nsdf_mesh_options_init(&options);
    options.resolution = 100;
    assert_int_equal(nsdf_extract_mesh_within(decoder, 0.1, &options, 1e9, &mesh, &resolution), NSDF_OK);
    assert_int_equal(resolution, 100);
    assert_true(view_of(mesh).triangle_count > 0);
    nsdf_mesh_free(&mesh);
    nsdf_close(&decoder);
    free_file(&file);
}

static void test_what_was_done_and_held_is_reported(void **state) {
    made_file file;
    nsdf_mesh *mesh = NULL;
    nsdf_extraction_stats stats;
    nsdf_memory_use before, after;
    (void)state;
    nsdf_decoder *decoder = open_made(&file, 2);
    assert_int_equal(nsdf_get_extraction_stats(decoder, &stats), NSDF_OK);
    assert_int_equal(stats.resolution, 0);
    assert_int_equal(nsdf_get_memory_use(decoder, &before), NSDF_OK);
    assert_true(before.held > 0 && before.most >= before.held);
    assert_int_equal(nsdf_extract_mesh(decoder, 0.1, NULL, &mesh), NSDF_OK);
    const nsdf_mesh_view view = view_of(mesh);
    assert_int_equal(nsdf_get_extraction_stats(decoder, &stats), NSDF_OK);
    assert_int_equal(stats.resolution, file.header.default_resolution);
    assert_int_equal(stats.threads, 2);
    assert_true(stats.centres > 0 && stats.corner_points > 0 && stats.vertex_points > 0);
    assert_int_equal(stats.dropped_pieces, 0);
    assert_int_equal(nsdf_get_memory_use(decoder, &after), NSDF_OK);
    assert_true(after.held > before.held);
    assert_true(after.most >= after.held + 36 * (uint64_t)view.vertex_count);
    assert_int_equal(nsdf_get_memory_use(decoder, NULL), NSDF_INVALID_ARGUMENT);
    assert_int_equal(nsdf_get_extraction_stats(NULL, &stats), NSDF_INVALID_ARGUMENT);
    nsdf_mesh_free(&mesh);
    nsdf_close(&decoder);
    free_file(&file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_mesh_lies_on_the_zero_set_and_outlives_the_handle),
        cmocka_unit_test(test_threads_and_reuse_give_the_same_mesh),
        cmocka_unit_test(test_buffers_of_the_size_asked_for_are_enough),
        cmocka_unit_test(test_options_out_of_range_are_refused),
        cmocka_unit_test(test_cancelling_leaves_an_empty_mesh),
        cmocka_unit_test(test_cancelling_takes_at_most_ten_milliseconds),
        cmocka_unit_test(test_a_time_budget_chooses_the_resolution_only),
        cmocka_unit_test(test_the_first_frame_climbs_as_long_as_there_is_time),
        cmocka_unit_test(test_what_was_done_and_held_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

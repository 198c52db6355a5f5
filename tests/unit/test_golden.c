/* The golden files: bytes that stay, and what a decoder must find in them (tests/golden/README.md). */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "format_desc.h"
#include "network_read.h"
#include "nsdf/decoder.h"

enum { MAX_POINTS = 64, MAX_NAME = 128, MIN_OK_FILES = 12, MIN_ERROR_FILES = 20, MAX_BYTES = 3000 };

/* Of a mesh's area and volume: those of triangles at resolution 72, and of the lattice that they are compared with. */
static const double most_off = 0.03;
/* Of its vertices, because a corner may lie where float and double differ in sign. */
static const double most_miscounted = 1e-3;

/* What an .expect file says; a line is a word and its values. */
typedef struct expectation {
    int status;         /* -1 when not given */
    int lacks_back_end; /* "needs" something that this build leaves out */
    unsigned long long hash;
    double scale;
    uint32_t count;
    double time[MAX_POINTS], value[MAX_POINTS];
    float point[MAX_POINTS][3];
    uint32_t resolution, vertices; /* of the mesh at mesh_time; resolution 0 when not given */
    double mesh_time, shadow, volume;
} expectation;

static void read_line(const char *line, expectation *e) {
    char word[16];
    const uint32_t i = e->count;
    if (sscanf(line, "status %d", &e->status) == 1 || sscanf(line, "hash %llx", &e->hash) == 1 ||
        sscanf(line, "scale %lf", &e->scale) == 1 ||
        sscanf(line, "mesh %lf %u %u %lf %lf", &e->mesh_time, &e->resolution, &e->vertices, &e->shadow, &e->volume) ==
            5)
        return;
    if (sscanf(line, "needs %15s", word) == 1) {
        const int is_zstd = strcmp(word, "zstd") == 0;
        assert_true(is_zstd || strcmp(word, "deflate") == 0);
        e->lacks_back_end |= !nsdf_entropy_available(is_zstd ? NSDF_ENTROPY_ZSTD : NSDF_ENTROPY_DEFLATE);
        return;
    }
    assert_in_range(i, 0, MAX_POINTS - 1);
    assert_int_equal(sscanf(line, "point %lf %f %f %f %lf", &e->time[i], &e->point[i][0], &e->point[i][1],
                            &e->point[i][2], &e->value[i]),
                     5);
    e->count++;
}

/* The path of FOLDER/vMAJOR.MINOR/kind/name + ending. */
static const char *path_of(const char *kind, const char *name, const char *ending) {
    static char path[1024];
    snprintf(path, sizeof path, "%s/v%d.%d/%s/%s%s", NSDF_GOLDEN_FOLDER, NSDF_FORMAT_MAJOR, NSDF_FORMAT_MINOR, kind,
             name, ending);
    return path;
}

static void read_expectation(const char *kind, const char *name, expectation *e) {
    char line[256];
    FILE *file = fopen(path_of(kind, name, ".expect"), "r");
    if (!file)
        fail_msg("%s.expect is missing", name);
    memset(e, 0, sizeof *e);
    e->status = -1;
    while (fgets(line, sizeof line, file))
        read_line(line, e);
    fclose(file);
}

/* Calls check(name) for every .nsdf file of a kind; returns how many there are. */
static int for_each_file(const char *kind, void (*check)(const char *name)) {
    int count = 0;
    DIR *folder = opendir(path_of(kind, "", ""));
    if (!folder)
        fail_msg("no folder %s: golden files go with the version of the format", path_of(kind, "", ""));
    for (const struct dirent *entry; (entry = readdir(folder));) {
        const char *ending = strrchr(entry->d_name, '.');
        char name[MAX_NAME];
        if (!ending || strcmp(ending, ".nsdf") != 0)
            continue;
        snprintf(name, sizeof name, "%.*s", (int)(ending - entry->d_name), entry->d_name);
        check(name);
        count++;
    }
    closedir(folder);
    return count;
}

/* ---- Files that decode ---------------------------------------------------------------------------------- */

static void assert_values(nsdf_decoder *decoder, const expectation *e, const char *name) {
    for (uint32_t i = 0; i < e->count; i++) {
        float value;
        assert_int_equal(nsdf_evaluate(decoder, e->time[i], e->point[i], 1, &value, NULL), NSDF_OK);
        if (!(fabs((double)value - e->value[i]) <= 1e-6 * e->scale))
            fail_msg("%s, %s kernels, point %u: %.9g, expected %.9g", name, nsdf_kernel_name(decoder), i, (double)value,
                     e->value[i]);
    }
}

/* A mesh's areas seen along the three axes, both sides, and the volume that it encloses. */
static void measure_mesh(const nsdf_mesh_view *view, double *shadow, double *volume) {
    *shadow = *volume = 0.0;
    for (uint32_t i = 0; i < view->triangle_count; i++) {
        const float *p = view->positions + 3 * (size_t)view->indices[3 * i];
        const float *q = view->positions + 3 * (size_t)view->indices[3 * i + 1];
        const float *r = view->positions + 3 * (size_t)view->indices[3 * i + 2];
        for (int a = 0; a < 3; a++) {
            const int b = (a + 1) % 3, c = (a + 2) % 3;
            const double normal =
                (double)(q[b] - p[b]) * (double)(r[c] - p[c]) - (double)(q[c] - p[c]) * (double)(r[b] - p[b]);
            *shadow += 0.5 * fabs(normal);
            *volume += normal * (double)p[a] / 6.0;
        }
    }
}

/* Where the sign changes, and how much it encloses, does not depend on how the decoder looks for it. */
static void assert_mesh(nsdf_decoder *decoder, const expectation *e, const char *name) {
    nsdf_mesh_options options;
    nsdf_mesh *mesh = NULL;
    nsdf_mesh_view view;
    double shadow, volume;
    nsdf_mesh_options_init(&options);
    options.resolution = e->resolution;
    options.all_pieces = 1;
    assert_true(e->resolution > 0);
    assert_int_equal(nsdf_extract_mesh(decoder, e->mesh_time, &options, &mesh), NSDF_OK);
    assert_int_equal(nsdf_mesh_get_view(mesh, &view), NSDF_OK);
    measure_mesh(&view, &shadow, &volume);
    if (fabs((double)view.vertex_count - e->vertices) > most_miscounted * e->vertices ||
        fabs(shadow - e->shadow) > most_off * e->shadow || fabs(volume - e->volume) > most_off * e->volume)
        fail_msg("%s, %s kernels: %u vertices, shadow %g, volume %g, expected %u, %g, %g", name,
                 nsdf_kernel_name(decoder), view.vertex_count, shadow, volume, e->vertices, e->shadow, e->volume);
    nsdf_mesh_free(&mesh);
}

static void check_ok_file(const char *name) {
    static const uint32_t masks[] = {0, NSDF_CPU_AVX2, NSDF_CPU_ALL};
    expectation e;
    read_expectation("ok", name, &e);
    assert_int_equal(e.count, MAX_POINTS);
    for (size_t m = 0; m < sizeof masks / sizeof *masks; m++) {
        nsdf_decoder_options options;
        nsdf_decoder *decoder = NULL;
        nsdf_info info;
        nsdf_error error;
        nsdf_decoder_options_init(&options);
        options.cpu_mask = masks[m];
        options.threads = 1;
        options.check_all = 1;
        if (nsdf_open_file(&decoder, path_of("ok", name, ".nsdf"), &options, &error) != NSDF_OK)
            fail_msg("%s: %s", name, error.message);
        assert_int_equal(nsdf_get_info(decoder, &info), NSDF_OK);
        assert_true(info.file_size <= MAX_BYTES);
        assert_true(info.parameter_hash == e.hash);
        assert_int_equal(nsdf_verify(decoder), e.lacks_back_end ? NSDF_UNSUPPORTED_FEATURE : NSDF_OK);
        if (!e.lacks_back_end) {
            assert_values(decoder, &e, name);
            assert_mesh(decoder, &e, name);
        }
        nsdf_close(&decoder);
    }
}

static void good_files_give_the_exact_parameters_and_nearly_the_values(void **state) {
    (void)state;
    assert_true(for_each_file("ok", check_ok_file) >= MIN_OK_FILES);
}

/* ---- Files that are refused ----------------------------------------------------------------------------- */

static void check_error_file(const char *name) {
    nsdf_decoder_options options;
    nsdf_decoder *decoder = NULL;
    nsdf_error error;
    expectation e;
    read_expectation("error", name, &e);
    nsdf_decoder_options_init(&options);
    options.threads = 1;
    options.check_all = 1;
    nsdf_status status = nsdf_open_file(&decoder, path_of("error", name, ".nsdf"), &options, &error);
    if (status == NSDF_OK)
        status = nsdf_verify(decoder);
    nsdf_close(&decoder);
    if (e.status <= 0 || (int)status != e.status)
        fail_msg("%s: status %d, expected %d", name, (int)status, e.status);
}

static void bad_files_are_refused_with_the_right_status(void **state) {
    (void)state;
    assert_true(for_each_file("error", check_error_file) >= MIN_ERROR_FILES);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(good_files_give_the_exact_parameters_and_nearly_the_values),
        cmocka_unit_test(bad_files_are_refused_with_the_right_status),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

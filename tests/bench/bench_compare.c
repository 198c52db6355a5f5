/* Milliseconds that comparing two meshes takes, by measure and number of threads.
 *
 *     bench_compare REFERENCE.obj DECODED.obj [SAMPLES] */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "nsdf/compare.h"
#include "nsdf/sequence.h"

enum { RUNS = 5 };

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* The mesh is borrowed from the sequence. */
static int load(nsdf_sequence **sequence, const char *path, nsdf_input_mesh *mesh) {
    nsdf_encoder_error error;
    if (nsdf_sequence_open(sequence, &path, 1, NULL, &error) != NSDF_OK ||
        nsdf_sequence_load(*sequence, 0, mesh, &error) != NSDF_OK) {
        fprintf(stderr, "bench_compare: %s\n", error.message);
        return -1;
    }
    return 0;
}

/* Prints the least time of a few runs; returns 0, or -1 on failure. */
static int time_measures(const char *what, const nsdf_compare_options *options, const nsdf_input_mesh mesh[2],
                         nsdf_difference *difference) {
    nsdf_encoder_error error;
    nsdf_compare *compare = NULL;
    double least = 1e9;
    nsdf_status status = nsdf_compare_create(&compare, options, &error);
    for (int run = 0; status == NSDF_OK && run < RUNS; run++) {
        double start = seconds();
        status = nsdf_compare_frame(compare, &mesh[0], &mesh[1], NULL, difference, &error);
        double taken = seconds() - start;
        least = taken < least ? taken : least;
    }
    nsdf_compare_close(&compare);
    if (status != NSDF_OK) {
        fprintf(stderr, "bench_compare: %s\n", error.message);
        return -1;
    }
    printf("%-28s %2u threads %9.2f ms\n", what, options->threads, 1e3 * least);
    return 0;
}

static int run(const nsdf_input_mesh mesh[2], uint32_t samples) {
    static const struct {
        const char *name;
        uint32_t measures;
    } cases[] = {{"distances", 0},
                 {"distances, D1", NSDF_COMPARE_POINTS},
                 {"distances, normals", NSDF_COMPARE_NORMALS},
                 {"distances, FMPD", NSDF_COMPARE_FMPD},
                 {"distances, shapes", NSDF_COMPARE_SHAPES},
                 {"all", NSDF_COMPARE_ALL}};
    nsdf_compare_options options;
    nsdf_difference d = {0};
    nsdf_compare_options_init(&options);
    options.samples = samples;
    for (options.threads = 1; options.threads <= 2; options.threads++) {
        for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
            options.measures = cases[i].measures;
            if (time_measures(cases[i].name, &options, mesh, &d) != 0) {
                return -1;
            }
        }
    }
    printf("to decoded %.6g %.6g %.6g, to reference %.6g %.6g %.6g (mean, rms, max), FMPD %.4f\n", d.to_decoded.mean,
           d.to_decoded.rms, d.to_decoded.max, d.to_reference.mean, d.to_reference.rms, d.to_reference.max, d.fmpd);
    return 0;
}

int main(int argc, char **argv) {
    if (argc < 3) {
        fprintf(stderr, "usage: bench_compare REFERENCE.obj DECODED.obj [SAMPLES]\n");
        return 2;
    }
    nsdf_sequence *sequence[2] = {NULL, NULL};
    nsdf_input_mesh mesh[2];
    int result = -1;
    if (load(&sequence[0], argv[1], &mesh[0]) == 0 && load(&sequence[1], argv[2], &mesh[1]) == 0) {
        result = run(mesh, argc > 3 ? (uint32_t)strtoul(argv[3], NULL, 10) : 20000);
    }
    nsdf_sequence_close(&sequence[0]);
    nsdf_sequence_close(&sequence[1]);
    return result == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

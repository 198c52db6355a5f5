#include "dec_bench.h"

#include <stdio.h>
#include <stdlib.h>

#include "cli_util.h"

enum { OPENINGS = 5, MOST_FRAMES = 15, FIRST_RESOLUTION = 128, POINTS = 1 << 16 };

static const double evaluate_for = 0.5; /* seconds */

static int compare_doubles(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, uint32_t count) {
    qsort(values, count, sizeof *values, compare_doubles);
    return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

/* Opening, and the first mesh from before opening on: what a viewer waits for, but for the network, which is read
 * once. */
static nsdf_status bench_open(nsdf_cli_input *input, const nsdf_decoder_options *options,
                              const nsdf_mesh_options *mesh_options) {
    double seconds[OPENINGS], first[OPENINGS];
    for (int i = 0; i < OPENINGS; i++) {
        nsdf_decoder *decoder = NULL;
        nsdf_mesh *mesh = NULL;
        const double start = nsdf_cli_clock();
        nsdf_status status = nsdf_cli_input_decoder(input, &decoder, options, NULL);
        seconds[i] = nsdf_cli_clock() - start;
        if (status == NSDF_OK)
            status = nsdf_extract_mesh(decoder, 0.0, mesh_options, &mesh);
        first[i] = nsdf_cli_clock() - start;
        nsdf_mesh_free(&mesh);
        nsdf_close(&decoder);
        if (status != NSDF_OK)
            return status;
    }
    printf("open            %9.3f ms\n", 1e3 * median(seconds, OPENINGS));
    printf("first frame     %9.3f ms after opening began, at resolution %lu\n", 1e3 * median(first, OPENINGS),
           (unsigned long)mesh_options->resolution);
    return NSDF_OK;
}

/* Sums over frames, to be divided by their count. */
static void add_stats(const nsdf_decoder *decoder, nsdf_extraction_stats *sum) {
    nsdf_extraction_stats s;
    if (nsdf_get_extraction_stats(decoder, &s) != NSDF_OK)
        return;
    sum->threads = s.threads;
    sum->compose += s.compose;
    sum->search += s.search;
    sum->corners += s.corners;
    sum->triangles += s.triangles;
    sum->vertices += s.vertices;
    sum->centres += s.centres;
    sum->corner_points += s.corner_points;
    sum->vertex_points += s.vertex_points;
}

static void print_stats(const nsdf_decoder *decoder, const nsdf_extraction_stats *sum, uint32_t frames) {
    const double ms = 1e3 / frames, each = 1.0 / frames;
    nsdf_memory_use use;
    printf("  compose       %9.3f ms\n", ms * sum->compose);
    printf("  coarse        %9.3f ms, %.0f points\n", ms * sum->search, each * (double)sum->centres);
    printf("  refine        %9.3f ms, %.0f points\n", ms * sum->corners, each * (double)sum->corner_points);
    printf("  extract       %9.3f ms\n", ms * sum->triangles);
    printf("  project       %9.3f ms, %.0f points\n", ms * sum->vertices, each * (double)sum->vertex_points);
    if (nsdf_get_memory_use(decoder, &use) == NSDF_OK)
        printf("  threads       %5lu, memory at most %.1f MiB\n", (unsigned long)sum->threads,
               (double)use.most / 1048576);
}

/* The first extraction only warms up. */
static nsdf_status bench_extract(nsdf_decoder *decoder, const nsdf_mesh_options *options, const nsdf_cli_times *times) {
    const uint32_t count = times->count < MOST_FRAMES ? times->count : MOST_FRAMES;
    double seconds[MOST_FRAMES], triangles = 0;
    nsdf_extraction_stats sum = {0};
    nsdf_mesh *mesh = NULL;
    nsdf_mesh_view view;
    nsdf_status status = nsdf_extract_mesh(decoder, times->seconds[0], options, &mesh);
    for (uint32_t i = 0; i < count && status == NSDF_OK; i++) {
        const double t = times->seconds[(uint64_t)i * times->count / count], start = nsdf_cli_clock();
        status = nsdf_extract_mesh(decoder, t, options, &mesh);
        seconds[i] = nsdf_cli_clock() - start;
        if (status == NSDF_OK)
            status = nsdf_mesh_get_view(mesh, &view);
        if (status == NSDF_OK)
            triangles += view.triangle_count;
        add_stats(decoder, &sum);
    }
    nsdf_mesh_free(&mesh);
    if (status != NSDF_OK)
        return status;
    const double middle = median(seconds, count); /* sorts them */
    printf("resolution %4lu %9.3f ms a frame, %.0f triangles (median of %lu frames; the longest %.3f ms)\n",
           (unsigned long)options->resolution, 1e3 * middle, triangles / count, (unsigned long)count,
           1e3 * seconds[count - 1]);
    print_stats(decoder, &sum, count);
    return NSDF_OK;
}

/* Points spread evenly over the domain (the R3 sequence of Roberts). */
static void place_points(const nsdf_info *info, float *xyz) {
    static const double ratio[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    for (uint32_t i = 0; i < POINTS; i++) {
        for (uint32_t a = 0; a < 3; a++) {
            const double x = ratio[a] * (i + 1);
            const double part = x - (double)(uint64_t)x;
            xyz[3 * i + a] = (float)(info->domain_min[a] + part * (info->domain_max[a] - info->domain_min[a]));
        }
    }
}

static nsdf_status bench_evaluate(nsdf_decoder *decoder, double t, const float *xyz, float *distance, float *gradient) {
    uint64_t points = 0;
    nsdf_status status = nsdf_evaluate(decoder, t, xyz, POINTS, distance, gradient);
    const double start = nsdf_cli_clock();
    double elapsed = 0;
    while (status == NSDF_OK && elapsed < evaluate_for && nsdf_cli_interrupts() == 0) {
        status = nsdf_evaluate(decoder, t, xyz, POINTS, distance, gradient);
        points += POINTS;
        elapsed = nsdf_cli_clock() - start;
    }
    if (status != NSDF_OK)
        return status;
    printf("%-15s %9.3f million points a second\n", gradient ? "with gradients" : "evaluate",
           elapsed > 0 ? 1e-6 * (double)points / elapsed : 0);
    return NSDF_OK;
}

static nsdf_status bench_field(nsdf_decoder *decoder, double t) {
    nsdf_info info;
    nsdf_status status = nsdf_get_info(decoder, &info);
    if (status != NSDF_OK)
        return status;
    float *const memory = malloc(7 * (size_t)POINTS * sizeof *memory);
    if (!memory)
        return NSDF_NO_MEMORY;
    float *const xyz = memory, *const distance = xyz + 3 * POINTS, *const gradient = distance + POINTS;
    place_points(&info, xyz);
    status = bench_evaluate(decoder, t, xyz, distance, NULL);
    if (status == NSDF_OK)
        status = bench_evaluate(decoder, t, xyz, distance, gradient);
    free(memory);
    return status;
}

nsdf_status dec_bench_run(nsdf_decoder *decoder, nsdf_cli_input *input, const dec_options *options,
                          const nsdf_decoder_options *open_options, const nsdf_mesh_options *mesh_options,
                          const nsdf_cli_times *times) {
    static const uint32_t resolutions[] = {64, 128, 192};
    const uint32_t count = options->resolution ? 1 : 3;
    printf("kernels         %s\n", nsdf_kernel_name(decoder));
    nsdf_mesh_options first = *mesh_options;
    first.resolution = options->resolution ? options->resolution : FIRST_RESOLUTION;
    nsdf_status status = bench_open(input, open_options, &first);
    for (uint32_t i = 0; i < count && status == NSDF_OK; i++) {
        nsdf_mesh_options at = *mesh_options;
        at.resolution = options->resolution ? options->resolution : resolutions[i];
        status = bench_extract(decoder, &at, times);
    }
    return status == NSDF_OK ? bench_field(decoder, times->seconds[times->count / 2]) : status;
}

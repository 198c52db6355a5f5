/* Draco on the same frames: the decoded meshes of each resolution, and the original ones, coded with Draco; how long
 * its decoder takes for them beside ours.  One thread; normals neither here nor there, because Draco gets none. */
#include "bench_speed.h"

#ifdef BENCH_WITH_DRACO

#include <stdio.h>
#include <stdlib.h>

#include "bench_frames.h"
#include "draco_mesh.h"
#include "nsdf/sequence.h"

static const char section[] = "draco";

/* The smallest files (-cl 10), Draco's default precision (-qp 11). */
static const draco_mesh_options coding = {10, 11};

/* Frames as Draco coded them. */
typedef struct coded_frames {
    draco_mesh_bytes bytes[BENCH_MOST_FRAMES];
    uint32_t count;
    double vertices; /* of all frames together, by the last decoding */
    draco_mesh_error error;
    int failed;
} coded_frames;

static void add_frame(coded_frames *coded, const float *positions, const uint32_t *indices, uint32_t triangle_count) {
    if (draco_mesh_encode(positions, indices, triangle_count, &coding, &coded->bytes[coded->count], &coded->error) == 0)
        coded->count++;
    else
        coded->failed = 1;
}

static void run_decoder(void *data) {
    coded_frames *coded = data;
    coded->vertices = 0;
    for (uint32_t i = 0; i < coded->count && !coded->failed; i++) {
        draco_mesh_decoded *decoded = draco_mesh_decode(coded->bytes[i].data, coded->bytes[i].size, &coded->error);
        if (decoded)
            coded->vertices += draco_mesh_vertex_count(decoded);
        else
            coded->failed = 1;
        draco_mesh_decoded_free(decoded);
    }
}

static void free_frames(coded_frames *coded) {
    for (uint32_t i = 0; i < coded->count; i++)
        draco_mesh_bytes_free(&coded->bytes[i]);
}

static int report_failure(const coded_frames *coded) {
    if (coded->failed)
        fprintf(stderr, "bench_speed: Draco: %s\n", coded->error.message);
    return coded->failed ? -1 : 0;
}

/* ---- Decoded frames ---------------------------------------------------------------------------------------- */

static int code_frames(bench_frames *frames, coded_frames *coded) {
    for (uint32_t i = 0; i < frames->count && !coded->failed; i++) {
        nsdf_mesh_view view;
        nsdf_status status = nsdf_extract_mesh(frames->decoder, frames->times[i], &frames->options, &frames->mesh);
        if (status == NSDF_OK)
            status = nsdf_mesh_get_view(frames->mesh, &view);
        if (bench_check("extracting a mesh", status) != 0)
            return -1;
        add_frame(coded, view.positions, view.indices, view.triangle_count);
    }
    return report_failure(coded);
}

/* `of`: the same times of the peer, or NULL. */
static void print_times(const bench_case *timed, uint32_t frames, double vertices, const bench_case *of,
                        double of_vertices) {
    bench_row row = bench_time(section, timed, 1e3 / frames, "ms/frame");
    const double ratio = of ? bench_compared_seconds(timed) / bench_compared_seconds(of) : 0.0;
    row.of_draco = ratio;
    bench_print(&row);
    row = bench_time(section, timed, 1e6 / vertices, "us/vertex");
    row.of_draco = ratio * of_vertices / vertices;
    bench_print(&row);
}

static int compare_frames(const bench_plan *plan, bench_frames *frames, coded_frames *coded, uint32_t resolution) {
    bench_case cases[2] = {{"", 1, bench_frames_run, frames, 0, 0, 0, 0}, {"", 1, run_decoder, coded, 0, 0, 0, 0}};
    snprintf(cases[0].measure, sizeof cases[0].measure, "frame at %lu: NSDF", (unsigned long)resolution);
    snprintf(cases[1].measure, sizeof cases[1].measure, "frame at %lu: Draco", (unsigned long)resolution);
    bench_run(plan, cases, 2);
    print_times(&cases[0], frames->count, frames->vertices, &cases[1], coded->vertices);
    print_times(&cases[1], coded->count, coded->vertices, NULL, 0.0);
    return bench_check("extracting a mesh", frames->status) | report_failure(coded);
}

static int bench_resolution(const bench_speed_options *options, bench_frames *frames, uint32_t resolution) {
    coded_frames *coded = bench_allocate_zeroed(1, sizeof *coded);
    frames->options.resolution = resolution;
    frames->options.normals = 0;
    int failed = code_frames(frames, coded);
    if (!failed)
        failed = compare_frames(&options->plan, frames, coded, resolution);
    free_frames(coded);
    free(coded);
    return failed;
}

/* ---- Original frames --------------------------------------------------------------------------------------- */

static void add_original(coded_frames *coded, const nsdf_input_mesh *mesh) {
    const size_t count = 3 * (size_t)mesh->vertex_count;
    float *positions = bench_floats(count);
    for (size_t i = 0; i < count; i++)
        positions[i] = (float)mesh->positions[i];
    add_frame(coded, positions, mesh->indices, mesh->triangle_count);
    free(positions);
}

static int code_originals(const bench_speed_options *options, coded_frames *coded) {
    nsdf_sequence *sequence = NULL;
    nsdf_encoder_error error;
    nsdf_status status = nsdf_sequence_open(&sequence, &options->input, 1, NULL, &error);
    const uint32_t all = status == NSDF_OK ? nsdf_sequence_mesh_count(sequence) : 0;
    const uint32_t wanted = all < options->frames ? all : options->frames;
    for (uint32_t i = 0; i < wanted && status == NSDF_OK && !coded->failed; i++) {
        nsdf_input_mesh mesh;
        const uint32_t frame = nsdf_sequence_mesh_frame(sequence, (uint32_t)((uint64_t)i * all / wanted));
        status = nsdf_sequence_load(sequence, frame, &mesh, &error);
        if (status == NSDF_OK)
            add_original(coded, &mesh);
    }
    if (status != NSDF_OK)
        fprintf(stderr, "bench_speed: %s\n", error.message);
    nsdf_sequence_close(&sequence);
    return status == NSDF_OK ? report_failure(coded) : -1;
}

static int bench_originals(const bench_speed_options *options) {
    coded_frames *coded = bench_allocate_zeroed(1, sizeof *coded);
    bench_case timed = {"original frame: Draco", 1, run_decoder, coded, 0, 0, 0, 0};
    int failed = code_originals(options, coded);
    if (!failed) {
        bench_run(&options->plan, &timed, 1);
        print_times(&timed, coded->count, coded->vertices, NULL, 0.0);
        failed = report_failure(coded);
    }
    free_frames(coded);
    free(coded);
    return failed;
}

int bench_speed_draco(const bench_speed_options *options) {
    bench_frames frames;
    int failed = bench_frames_open(&frames, options, 1, NSDF_CPU_ALL);
    for (const uint32_t *resolution = options->resolutions; *resolution > 0 && !failed; resolution++)
        failed = bench_resolution(options, &frames, *resolution);
    bench_frames_close(&frames);
    if (!failed && options->input)
        failed = bench_originals(options);
    return failed;
}

const char *bench_speed_draco_version(void) {
    return draco_mesh_version();
}

#else

int bench_speed_draco(const bench_speed_options *options) {
    (void)options;
    return 0;
}

const char *bench_speed_draco_version(void) {
    return "not built in";
}

#endif

/* Draco on the same frames: the decoded meshes of each resolution, and the original ones, coded with Draco; how long
 * its decoder takes for them beside ours.  One thread; with normals on both sides, and without them on both. */
#include "bench_speed.h"

#ifdef BENCH_WITH_DRACO

#include <stdio.h>
#include <stdlib.h>

#include "bench_frames.h"
#include "draco_mesh.h"
#include "nsdf/sequence.h"

static const char section[] = "draco";

enum { KINDS = 2, WITH_NORMALS = 1, CODINGS = 6, ORIGINAL_CODING = 1 };

/* Draco's default level (7) and precision (11 bits, 8 for normals), the smallest files (level 10), and more bits, as
 * meshes of a fine grid need them. */
static const draco_mesh_options codings[CODINGS] = {{7, 11, 0}, {10, 11, 0}, {10, 12, 0},
                                                    {7, 11, 8}, {10, 11, 8}, {10, 12, 10}};

/* Frames as Draco coded them. */
typedef struct coded_frames {
    draco_mesh_bytes bytes[BENCH_MOST_FRAMES];
    uint32_t count;
    double vertices; /* of all frames together, by the last decoding */
    draco_mesh_error error;
    int failed;
} coded_frames;

static void add_frame(coded_frames *coded, const draco_mesh_options *coding, const float *positions,
                      const float *normals, const uint32_t *indices, uint32_t triangle_count) {
    if (draco_mesh_encode(positions, normals, indices, triangle_count, coding, &coded->bytes[coded->count],
                          &coded->error) == 0)
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

/* Our frames, and how Draco coded them: first the kind without normals, then that with them. */
typedef struct comparison {
    bench_frames *ours[KINDS];
    coded_frames coded[CODINGS];
    bench_case cases[KINDS + CODINGS]; /* of `ours`, then of `coded` */
} comparison;

/* The meshes with normals, in all codings. */
static int code_frames(comparison *c) {
    bench_frames *frames = c->ours[WITH_NORMALS];
    for (uint32_t i = 0; i < frames->count; i++) {
        nsdf_mesh_view view;
        nsdf_status status = nsdf_extract_mesh(frames->decoder, frames->times[i], &frames->options, &frames->mesh);
        if (status == NSDF_OK)
            status = nsdf_mesh_get_view(frames->mesh, &view);
        if (bench_check("extracting a mesh", status) != 0)
            return -1;
        for (int k = 0; k < CODINGS; k++) {
            add_frame(&c->coded[k], &codings[k], view.positions, view.normals, view.indices, view.triangle_count);
            if (report_failure(&c->coded[k]) != 0)
                return -1;
        }
    }
    return 0;
}

/* `ours`: the case that the peer's time is compared with, or NULL. */
static void print_times(const bench_case *timed, uint32_t frames, double vertices, const bench_case *ours) {
    const double ratio = ours ? bench_compared_seconds(ours) / bench_compared_seconds(timed) : 0.0;
    bench_row rows[2] = {bench_time(section, timed, 1e3 / frames, "ms/frame"),
                         bench_time(section, timed, 1e6 / vertices, "us/vertex")};
    for (int i = 0; i < 2; i++) {
        rows[i].of_draco = ratio;
        bench_print(&rows[i]);
    }
}

static void name_cases(comparison *c, uint32_t resolution) {
    static const char *const names[KINDS] = {"NSDF", "NSDF with normals"};
    const unsigned long at = resolution;
    for (int kind = 0; kind < KINDS; kind++) {
        c->cases[kind] = (bench_case){"", 1, bench_frames_run, c->ours[kind], 0, 0, 0, 0};
        snprintf(c->cases[kind].measure, sizeof c->cases[kind].measure, "at %lu: %s", at, names[kind]);
    }
    for (int k = 0; k < CODINGS; k++) {
        bench_case *timed = &c->cases[KINDS + k];
        *timed = (bench_case){"", 1, run_decoder, &c->coded[k], 0, 0, 0, 0};
        const int n = snprintf(timed->measure, sizeof timed->measure, "at %lu: Draco -cl %d -qp %d", at,
                               codings[k].level, codings[k].position_bits);
        if (codings[k].normal_bits > 0)
            snprintf(timed->measure + n, sizeof timed->measure - (size_t)n, " -qn %d", codings[k].normal_bits);
    }
}

static int print_comparison(const comparison *c, uint32_t resolution) {
    char name[48];
    int failed = 0;
    snprintf(name, sizeof name, "at %lu: size", (unsigned long)resolution);
    const double vertices = c->ours[0]->vertices / c->ours[0]->count;
    const bench_row size = bench_count(section, name, 1, vertices, "vertices");
    bench_print(&size);
    for (int kind = 0; kind < KINDS; kind++) {
        print_times(&c->cases[kind], c->ours[kind]->count, c->ours[kind]->vertices, NULL);
        failed |= bench_check("extracting a mesh", c->ours[kind]->status);
    }
    for (int k = 0; k < CODINGS; k++) {
        const bench_case *like = &c->cases[codings[k].normal_bits > 0 ? WITH_NORMALS : 0];
        print_times(&c->cases[KINDS + k], c->coded[k].count, c->coded[k].vertices, like);
        failed |= report_failure(&c->coded[k]);
    }
    return failed;
}

static int bench_resolution(const bench_speed_options *options, bench_frames frames[KINDS], uint32_t resolution) {
    comparison *c = bench_allocate_zeroed(1, sizeof *c);
    for (int kind = 0; kind < KINDS; kind++) {
        c->ours[kind] = &frames[kind];
        frames[kind].options.resolution = resolution;
        frames[kind].options.normals = kind == WITH_NORMALS;
    }
    int failed = code_frames(c);
    if (!failed) {
        name_cases(c, resolution);
        bench_run(&options->plan, c->cases, KINDS + CODINGS);
        failed = print_comparison(c, resolution);
    }
    for (int k = 0; k < CODINGS; k++)
        free_frames(&c->coded[k]);
    free(c);
    return failed;
}

/* ---- Original frames --------------------------------------------------------------------------------------- */

static void add_original(coded_frames *coded, const nsdf_input_mesh *mesh) {
    const size_t count = 3 * (size_t)mesh->vertex_count;
    float *positions = bench_floats(count);
    for (size_t i = 0; i < count; i++)
        positions[i] = (float)mesh->positions[i];
    add_frame(coded, &codings[ORIGINAL_CODING], positions, NULL, mesh->indices, mesh->triangle_count);
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
        print_times(&timed, coded->count, coded->vertices, NULL);
        failed = report_failure(coded);
    }
    free_frames(coded);
    free(coded);
    return failed;
}

int bench_speed_draco(const bench_speed_options *options) {
    bench_frames frames[KINDS];
    int failed = 0;
    for (int kind = 0; kind < KINDS; kind++)
        failed |= bench_frames_open(&frames[kind], options, 1, NSDF_CPU_ALL);
    for (const uint32_t *resolution = options->resolutions; *resolution > 0 && !failed; resolution++)
        failed = bench_resolution(options, frames, *resolution);
    for (int kind = 0; kind < KINDS; kind++)
        bench_frames_close(&frames[kind]);
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

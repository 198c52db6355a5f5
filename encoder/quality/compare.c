/* A frame is measured in stages, each of them a number of tasks for the workers. */
#include "nsdf/compare.h"

#include <math.h>
#include <stdlib.h>

#include "input_error.h"
#include "mesh_check.h"
#include "mesh_distance.h"
#include "mesh_shape.h"
#include "roughness.h"
#include "workers.h"

enum { REFERENCE = 0, DECODED = 1 };
static const double degrees = 57.29577951308232; /* of a radian */
static const uint32_t most_samples = UINT32_C(1) << 24, most_threads = 256;

struct nsdf_compare {
    nsdf_compare_options options;
    nsdf_workers *workers;
};

void nsdf_compare_options_init(nsdf_compare_options *options) {
    *options = (nsdf_compare_options){sizeof *options, 20000, NSDF_COMPARE_ALL, 0, 1, 0};
}

static nsdf_status check_options(const nsdf_compare_options *o, nsdf_encoder_error *error) {
    if (o->struct_size != sizeof *o) {
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT,
                               "the options have %zu bytes, expected %zu: call nsdf_compare_options_init",
                               o->struct_size, sizeof *o);
    }
    if (o->samples < 1 || o->samples > most_samples) {
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "samples is %u, expected 1 to %u", o->samples,
                               most_samples);
    }
    if (o->threads > most_threads) {
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "threads is %u, expected 0 to %u", o->threads,
                               most_threads);
    }
    if ((o->measures & ~NSDF_COMPARE_ALL) != 0) {
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "measures is %u, expected 0 to %u", o->measures,
                               NSDF_COMPARE_ALL);
    }
    if ((o->outer & ~(uint32_t)(NSDF_COMPARE_REFERENCE | NSDF_COMPARE_DECODED)) != 0) {
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "outer is %u, expected 0 to 3", o->outer);
    }
    return NSDF_OK;
}

nsdf_status nsdf_compare_create(nsdf_compare **compare, const nsdf_compare_options *options,
                                nsdf_encoder_error *error) {
    nsdf_compare_options chosen;
    nsdf_compare_options_init(&chosen);
    chosen = options != NULL ? *options : chosen;
    nsdf_status status = check_options(&chosen, error);
    if (status != NSDF_OK) {
        return status;
    }
    nsdf_compare *made = calloc(1, sizeof *made);
    nsdf_workers *workers = made != NULL ? nsdf_workers_create(chosen.threads) : NULL;
    if (workers == NULL) {
        free(made);
        return nsdf_input_no_memory(error);
    }
    *made = (nsdf_compare){chosen, workers};
    *compare = made;
    return NSDF_OK;
}

void nsdf_compare_close(nsdf_compare **compare) {
    if (compare != NULL && *compare != NULL) {
        nsdf_workers_free((*compare)->workers);
        free(*compare);
        *compare = NULL;
    }
}

/* One frame.  Arrays of two: reference, decoded; those of directions: from the reference, from the decoded mesh. */
typedef struct comparison {
    const nsdf_compare_options *options;
    const nsdf_input_mesh *input[2];
    nsdf_pair_frame frame;
    nsdf_compared_mesh mesh[2];
    nsdf_shape shape[2];
    nsdf_roughness roughness[2];
    bool failed[4]; /* memory ran out in a task */
    uint32_t point_chunks, vertex_chunks[2];
    nsdf_distance_sums *sums; /* [2][point_chunks] */
    double *maxima;           /* [vertex_chunks[0] + vertex_chunks[1]] */
    double *vertex_distance;  /* of the decoded vertices, or NULL */
} comparison;

static bool measures(const comparison *c, uint32_t what) {
    return (c->options->measures & what) != 0;
}

static void prepare(void *data, uint32_t index, uint32_t worker) {
    comparison *c = data;
    const bool outer = (c->options->outer & (index == REFERENCE ? NSDF_COMPARE_REFERENCE : NSDF_COMPARE_DECODED)) != 0;
    (void)worker;
    c->failed[index] =
        nsdf_compared_mesh_prepare(&c->mesh[index], c->input[index], &c->frame, c->options->samples, outer) != 0;
}

static void draw_points(void *data, uint32_t index, uint32_t worker) {
    comparison *c = data;
    (void)worker;
    nsdf_compared_mesh_draw(&c->mesh[index / c->point_chunks], index % c->point_chunks, c->options->seed);
}

/* What the triangles alone tell of one mesh. */
static int measure_mesh(comparison *c, uint32_t which) {
    const nsdf_compared_mesh *mesh = &c->mesh[which];
    nsdf_edge_table edges = {NULL, 0};
    int result = 0;
    if (measures(c, NSDF_COMPARE_SHAPES | NSDF_COMPARE_FMPD)) {
        result = nsdf_edge_table_build(&edges, &mesh->whole, NULL);
    }
    if (result == 0 && measures(c, NSDF_COMPARE_SHAPES)) {
        result = nsdf_measure_shape(&mesh->whole, &edges, c->frame.diagonal, &c->shape[which]);
    }
    if (result == 0 && measures(c, NSDF_COMPARE_FMPD)) {
        result = nsdf_roughness_measure(&c->roughness[which], &mesh->whole, mesh->mesh->positions, &edges);
    }
    nsdf_edge_table_free(&edges);
    return result;
}

static void index_or_measure(void *data, uint32_t index, uint32_t worker) {
    comparison *c = data;
    (void)worker;
    if (index >= 2) {
        c->failed[index] = measure_mesh(c, index - 2) != 0;
    } else if (measures(c, NSDF_COMPARE_POINTS)) {
        c->failed[index] = nsdf_compared_mesh_index_points(&c->mesh[index]) != 0;
    }
}

static void measure_distances(void *data, uint32_t index, uint32_t worker) {
    comparison *c = data;
    (void)worker;
    uint32_t from = index < c->point_chunks + c->vertex_chunks[0] ? REFERENCE : DECODED;
    uint32_t chunk = from == REFERENCE ? index : index - c->point_chunks - c->vertex_chunks[0];
    const nsdf_distance_task task = {&c->mesh[from], &c->mesh[1 - from], measures(c, NSDF_COMPARE_POINTS),
                                     measures(c, NSDF_COMPARE_NORMALS)};
    if (chunk < c->point_chunks) {
        nsdf_measure_points(&task, chunk, &c->sums[(size_t)from * c->point_chunks + chunk]);
    } else {
        chunk -= c->point_chunks;
        nsdf_measure_vertices(&task, &c->frame, chunk, from == DECODED ? c->vertex_distance : NULL,
                              &c->maxima[from == REFERENCE ? chunk : c->vertex_chunks[0] + chunk]);
    }
}

static bool has_failed(const comparison *c) {
    return c->failed[0] || c->failed[1] || c->failed[2] || c->failed[3];
}

static int make_room(comparison *c) {
    c->point_chunks = nsdf_chunk_count(c->options->samples);
    c->vertex_chunks[0] = nsdf_chunk_count(c->input[0]->vertex_count);
    c->vertex_chunks[1] = nsdf_chunk_count(c->input[1]->vertex_count);
    c->sums = malloc(2 * sizeof *c->sums * (size_t)c->point_chunks);
    c->maxima = malloc(sizeof *c->maxima * ((size_t)c->vertex_chunks[0] + c->vertex_chunks[1]));
    return c->sums != NULL && c->maxima != NULL ? 0 : -1;
}

static nsdf_status run_stages(comparison *c, nsdf_workers *workers, nsdf_encoder_error *error) {
    static const char *const names[2] = {"reference", "decoded"};
    c->frame = nsdf_pair_frame_of(c->input[0], c->input[1]);
    if (c->frame.diagonal > 0.0) {
        nsdf_workers_run(workers, 2, prepare, c);
    }
    if (has_failed(c) || make_room(c) != 0) {
        return nsdf_input_no_memory(error);
    }
    for (int k = 0; k < 2; k++) {
        if (c->mesh[k].surface.triangle_count == 0) {
            return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "%s: no triangle has an area", names[k]);
        }
    }
    nsdf_workers_run(workers, 2 * c->point_chunks, draw_points, c);
    nsdf_workers_run(workers, 4, index_or_measure, c);
    if (has_failed(c)) {
        return nsdf_input_no_memory(error);
    }
    nsdf_workers_run(workers, 2 * c->point_chunks + c->vertex_chunks[0] + c->vertex_chunks[1], measure_distances, c);
    return NSDF_OK;
}

/* The distances of one direction. */
static nsdf_distances add_up(const comparison *c, uint32_t from) {
    nsdf_distance_sums all = {0};
    for (uint32_t i = 0; i < c->point_chunks; i++) {
        const nsdf_distance_sums *s = &c->sums[(size_t)from * c->point_chunks + i];
        all.sum += s->sum;
        all.sum_squares += s->sum_squares;
        all.max = fmax(all.max, s->max);
        all.point_squares += s->point_squares;
        all.angle_sum += s->angle_sum;
        all.angle_squares += s->angle_squares;
    }
    for (uint32_t i = 0; i < c->vertex_chunks[from]; i++) {
        all.max = fmax(all.max, c->maxima[from == REFERENCE ? i : c->vertex_chunks[0] + i]);
    }
    double n = c->options->samples, unit = c->frame.diagonal;
    return (nsdf_distances){.mean = unit * all.sum / n,
                            .rms = unit * sqrt(all.sum_squares / n),
                            .max = unit * all.max,
                            .point_rms = unit * sqrt(all.point_squares / n),
                            .normal_mean = degrees * all.angle_sum / n,
                            .normal_rms = degrees * sqrt(all.angle_squares / n)};
}

static nsdf_difference result_of(const comparison *c) {
    nsdf_difference d = {.to_decoded = add_up(c, REFERENCE), .to_reference = add_up(c, DECODED)};
    nsdf_shape *shape[2] = {&d.reference, &d.decoded};
    double global[2] = {0.0, 0.0};
    d.hausdorff = fmax(d.to_decoded.max, d.to_reference.max);
    if (measures(c, NSDF_COMPARE_FMPD)) {
        nsdf_roughness_global(c->roughness, global);
        d.fmpd = nsdf_fmpd(global);
    }
    for (int k = 0; k < 2; k++) {
        *shape[k] = c->shape[k];
        shape[k]->vertices = c->input[k]->vertex_count;
        shape[k]->triangles = c->input[k]->triangle_count;
        shape[k]->hidden_share = c->mesh[k].hidden_share;
        shape[k]->roughness = global[k];
    }
    return d;
}

nsdf_status nsdf_compare_frame(nsdf_compare *compare, const nsdf_input_mesh *reference, const nsdf_input_mesh *decoded,
                               double *vertex_distance, nsdf_difference *difference, nsdf_encoder_error *error) {
    nsdf_status status = nsdf_check_mesh("reference", reference, error);
    if (status == NSDF_OK) {
        status = nsdf_check_mesh("decoded", decoded, error);
    }
    if (status != NSDF_OK) {
        return status;
    }
    comparison c = {.options = &compare->options, .input = {reference, decoded}, .vertex_distance = vertex_distance};
    status = run_stages(&c, compare->workers, error);
    if (status == NSDF_OK) {
        *difference = result_of(&c);
    }
    for (int k = 0; k < 2; k++) {
        nsdf_compared_mesh_free(&c.mesh[k]);
        nsdf_roughness_free(&c.roughness[k]);
    }
    free(c.sums);
    free(c.maxima);
    return status;
}

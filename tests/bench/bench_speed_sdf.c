/* Queries a second of the signed distance to a mesh, near its surface and in the whole box, for each way to find the
 * sign. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "bench_speed.h"
#include "nsdf/sequence.h"
#include "sampler.h"
#include "workers.h"

enum { RULES = 2, PLACES = 3, CASES = RULES * (1 + PLACES * BENCH_TEAMS), TASK_QUERIES = 500 };

static const char section[] = "sdf";

static const struct {
    const char *name;
    nsdf_sign_rule rule;
} rules[RULES] = {{"pseudo-normal", NSDF_SIGN_PSEUDO_NORMAL}, {"winding", NSDF_SIGN_WINDING}};

/* Width of the noise around the surface; 0: anywhere in the box. */
static const struct {
    const char *name;
    float width;
} places[PLACES] = {{"within 0.002", 0.002f}, {"within 0.02", 0.02f}, {"in the box", 0.0f}};

typedef struct job {
    const nsdf_surface *surface;
    nsdf_sign_rule rule;
    const nsdf_sdf *sdf;
    nsdf_workers *team;
    const float *xyz; /* [count][3] */
    float *distance;  /* [count] */
    uint32_t count;
} job;

/* ---- The mesh ---------------------------------------------------------------------------------------------- */

static void torus_point(double u, double v, float xyz[3]) {
    double tau = 6.283185307179586, r = 0.08 * (1.0 + 0.3 * cos(9.0 * tau * u) * sin(4.0 * tau * v));
    xyz[0] = (float)((0.3 + r * cos(tau * v)) * cos(tau * u));
    xyz[1] = (float)((0.3 + r * cos(tau * v)) * sin(tau * u));
    xyz[2] = (float)(r * sin(tau * v));
}

static void make_torus(nsdf_surface *surface, uint32_t around, uint32_t across) {
    surface->vertex_count = around * across;
    surface->triangle_count = 2 * around * across;
    surface->positions = bench_allocate(surface->vertex_count, 3 * sizeof(float));
    surface->indices = bench_allocate(surface->triangle_count, 3 * sizeof(uint32_t));
    uint32_t *index = surface->indices;
    for (uint32_t i = 0; i < around; i++) {
        for (uint32_t j = 0; j < across; j++) {
            uint32_t i1 = (i + 1) % around, j1 = (j + 1) % across;
            const uint32_t quad[6] = {i * across + j,   i1 * across + j, i1 * across + j1,
                                      i1 * across + j1, i * across + j1, i * across + j};
            for (int k = 0; k < 6; k++) {
                *index++ = quad[k];
            }
            torus_point((double)i / around, (double)j / across, &surface->positions[3 * (size_t)(i * across + j)]);
        }
    }
}

static void extend_box(const nsdf_input_mesh *mesh, double low[3], double high[3]) {
    for (int k = 0; k < 3; k++) {
        low[k] = INFINITY;
        high[k] = -INFINITY;
        for (uint32_t i = 0; i < mesh->vertex_count; i++) {
            low[k] = fmin(low[k], mesh->positions[3 * (size_t)i + (size_t)k]);
            high[k] = fmax(high[k], mesh->positions[3 * (size_t)i + (size_t)k]);
        }
    }
}

/* Centred, divided by the diagonal. */
static void copy_normalised(const nsdf_input_mesh *mesh, nsdf_surface *surface) {
    double low[3], high[3];
    extend_box(mesh, low, high);
    double diagonal = sqrt(pow(high[0] - low[0], 2) + pow(high[1] - low[1], 2) + pow(high[2] - low[2], 2));
    surface->vertex_count = mesh->vertex_count;
    surface->triangle_count = mesh->triangle_count;
    surface->positions = bench_allocate(surface->vertex_count, 3 * sizeof(float));
    surface->indices = bench_allocate(surface->triangle_count, 3 * sizeof(uint32_t));
    for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++) {
        surface->positions[i] = (float)((mesh->positions[i] - 0.5 * (low[i % 3] + high[i % 3])) / diagonal);
    }
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++) {
        surface->indices[i] = mesh->indices[i];
    }
}

/* The first frame of the input, or a bumpy torus of 20,000 triangles. */
static int load(nsdf_surface *surface, const char *path) {
    nsdf_sequence *sequence = NULL;
    nsdf_input_mesh mesh;
    nsdf_encoder_error error;
    if (!path) {
        make_torus(surface, 200, 50);
        return 0;
    }
    nsdf_status status = nsdf_sequence_open(&sequence, &path, 1, NULL, &error);
    if (status == NSDF_OK)
        status = nsdf_sequence_load(sequence, 0, &mesh, &error);
    if (status == NSDF_OK)
        copy_normalised(&mesh, surface);
    else
        fprintf(stderr, "bench_speed: %s\n", error.message);
    nsdf_sequence_close(&sequence);
    return status == NSDF_OK ? 0 : -1;
}

/* ---- The queries ------------------------------------------------------------------------------------------- */

static float *make_points(const nsdf_surface *surface, float width, uint32_t count) {
    nsdf_random random = nsdf_random_start(1, 1);
    float *xyz = bench_floats(3 * (size_t)count);
    if (width > 0.0f && nsdf_sample_surface(surface, count, &random, xyz) != 0)
        bench_checked(NULL);
    for (size_t i = 0; i < 3 * (size_t)count; i++)
        xyz[i] += width > 0.0f ? width * nsdf_random_normal(&random) : nsdf_random_unit(&random) - 0.5f;
    return xyz;
}

static void query_task(void *data, uint32_t index, uint32_t worker) {
    const job *j = data;
    const uint32_t first = index * TASK_QUERIES;
    const uint32_t end = j->count - first < TASK_QUERIES ? j->count : first + TASK_QUERIES;
    for (uint32_t i = first; i < end; i++)
        j->distance[i] = nsdf_sdf_distance(j->sdf, &j->xyz[3 * (size_t)i]);
    (void)worker;
}

static void run_queries(void *data) {
    job *j = data;
    nsdf_workers_run(j->team, (j->count + TASK_QUERIES - 1) / TASK_QUERIES, query_task, j);
}

static void run_build(void *data) {
    const job *j = data;
    nsdf_sdf_free(bench_checked(nsdf_sdf_create(j->surface, j->rule)));
}

/* ---- The section ------------------------------------------------------------------------------------------- */

typedef struct bench {
    const bench_speed_options *options;
    nsdf_surface surface;
    nsdf_workers *team[BENCH_TEAMS];
    nsdf_sdf *sdf[RULES];
    float *xyz[PLACES], *distance;
    bench_case cases[CASES];
    job jobs[CASES];
} bench;

static void create_bench(bench *b) {
    for (int t = 0; t < BENCH_TEAMS; t++)
        b->team[t] = bench_checked(nsdf_workers_create(b->options->threads[t]));
    for (int r = 0; r < RULES; r++)
        b->sdf[r] = bench_checked(nsdf_sdf_create(&b->surface, rules[r].rule));
    for (int p = 0; p < PLACES; p++)
        b->xyz[p] = make_points(&b->surface, places[p].width, b->options->queries);
    b->distance = bench_floats(b->options->queries);
}

static void free_bench(bench *b) {
    for (int t = 0; t < BENCH_TEAMS; t++)
        nsdf_workers_free(b->team[t]);
    for (int r = 0; r < RULES; r++)
        nsdf_sdf_free(b->sdf[r]);
    for (int p = 0; p < PLACES; p++)
        free(b->xyz[p]);
    free(b->distance);
}

/* Case 0 of a rule builds the hierarchy; then come the queries, place by place. */
static void fill_case(bench *b, int rule, int index) {
    const int at = rule * (CASES / RULES) + index, place = (index - 1) / BENCH_TEAMS, t = (index - 1) % BENCH_TEAMS;
    bench_case *timed = &b->cases[at];
    job *j = &b->jobs[at];
    timed->data = j;
    j->surface = &b->surface;
    j->rule = rules[rule].rule;
    if (index == 0) {
        timed->threads = 1;
        timed->run = run_build;
        snprintf(timed->measure, sizeof timed->measure, "%s: build", rules[rule].name);
        return;
    }
    timed->threads = b->options->threads[t];
    timed->run = run_queries;
    snprintf(timed->measure, sizeof timed->measure, "%s: %s", rules[rule].name, places[place].name);
    j->sdf = b->sdf[rule];
    j->team = b->team[t];
    j->xyz = b->xyz[place];
    j->distance = b->distance;
    j->count = b->options->queries;
}

int bench_speed_sdf(const bench_speed_options *options) {
    bench b = {.options = options};
    if (load(&b.surface, options->input) != 0)
        return -1;
    create_bench(&b);
    for (int rule = 0; rule < RULES; rule++)
        for (int i = 0; i < CASES / RULES; i++)
            fill_case(&b, rule, i);
    const bench_row triangles = bench_count(section, "mesh: size", 1, b.surface.triangle_count, "triangles");
    bench_print(&triangles);
    bench_run(&options->plan, b.cases, CASES);
    for (int i = 0; i < CASES; i++) {
        const bench_row row = b.cases[i].run == run_build
                                  ? bench_time(section, &b.cases[i], 1e3, "ms")
                                  : bench_rate(section, &b.cases[i], options->queries, "samples/s");
        bench_print(&row);
    }
    free_bench(&b);
    nsdf_surface_free(&b.surface);
    return 0;
}

#include "stray.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Each stray crossing gives so many samples; of more crossings than STRAYS_WANTED in a frame, ever fewer are used,
 * since true distances far from the surface are dear. */
enum { POINTS_PER_STRAY = 3, STRAYS_WANTED = 300 };

/* The domain is cut into cubes; those whose centre is far from the zero set are skipped, as the decoder will do with a
 * bound like this one. */
enum { CUBES = 32, MOST_CELLS = 4, CHUNK = 4096 };
static const float search_bound = 1.8f;

typedef struct {
    const nsdf_stray_job *job;
    uint32_t cubes[3], cells; /* cubes along each axis; cells along a cube's edge */
    uint32_t nodes[3];        /* corners of cells along each axis */
    float origin[3], h;       /* h = edge of a cell */
    uint64_t *found;          /* [frame] */
    uint8_t *failed;          /* [frame] */
} search;

/* Points to be evaluated together, the values there, and the corners of cells that some of them are. */
typedef struct {
    float xyz[3 * CHUNK], value[CHUNK];
    size_t node[CHUNK], count;
} point_list;

typedef struct {
    const search *s;
    const nsdf_sdf *sdf;
    const float *composed;
    nsdf_fit_scratch *scratch;
    float time;
    float *value; /* [node]: NaN where it was not asked for */
    point_list *points;
    nsdf_sample_set *hard;
    nsdf_random random;
    uint64_t found;
} finder;

static void add_point(point_list *list, const float p[3]) {
    for (size_t k = 0; k < 3; k++)
        list->xyz[k * CHUNK + list->count] = p[k];
    list->count++;
}

static void evaluate(const finder *f) {
    const float *xyz = f->points->xyz;
    nsdf_fit_points points = {xyz, xyz + CHUNK, xyz + 2 * CHUNK, NULL, f->points->count, f->time};
    nsdf_fit_forward(f->s->job->model, f->s->job->kernels, f->scratch, f->composed, &points, f->points->value);
}

static void cube_at(const search *s, uint32_t cube, uint32_t at[3]) {
    at[0] = cube % s->cubes[0];
    at[1] = cube / s->cubes[0] % s->cubes[1];
    at[2] = cube / s->cubes[0] / s->cubes[1];
}

/* Numbers of the cubes to look into; returns how many. */
static uint32_t near_cubes(const finder *f, uint32_t *list) {
    const search *s = f->s;
    uint32_t total = s->cubes[0] * s->cubes[1] * s->cubes[2], kept = 0;
    float half = 0.5f * (float)s->cells * s->h, limit = search_bound * half * sqrtf(3.0f);
    for (uint32_t first = 0; first < total; first += CHUNK) {
        uint32_t n = total - first < CHUNK ? total - first : CHUNK;
        f->points->count = 0;
        for (uint32_t i = 0; i < n; i++) {
            uint32_t at[3];
            float centre[3];
            cube_at(s, first + i, at);
            for (int k = 0; k < 3; k++)
                centre[k] = s->origin[k] + (float)(at[k] * s->cells) * s->h + half;
            add_point(f->points, centre);
        }
        evaluate(f);
        for (uint32_t i = 0; i < n; i++)
            if (fabsf(f->points->value[i]) <= limit)
                list[kept++] = first + i;
    }
    return kept;
}

/* ---- Values at the corners of cells ------------------------------------------------------------------------- */

static size_t node_at(const search *s, uint32_t x, uint32_t y, uint32_t z) {
    return ((size_t)z * s->nodes[1] + y) * s->nodes[0] + x;
}

static void node_point(const search *s, size_t node, float p[3]) {
    const size_t at[3] = {node % s->nodes[0], node / s->nodes[0] % s->nodes[1], node / s->nodes[0] / s->nodes[1]};
    for (int k = 0; k < 3; k++)
        p[k] = s->origin[k] + (float)at[k] * s->h;
}

static void evaluate_nodes(const finder *f) {
    point_list *list = f->points;
    evaluate(f);
    for (size_t i = 0; i < list->count; i++)
        f->value[list->node[i]] = list->value[i];
    list->count = 0;
}

static void ask_for_node(const finder *f, size_t node) {
    point_list *list = f->points;
    float p[3];
    if (!isnan(f->value[node]))
        return;
    f->value[node] = 0.0f; /* so that it is asked for once */
    node_point(f->s, node, p);
    list->node[list->count] = node;
    add_point(list, p);
    if (list->count == CHUNK)
        evaluate_nodes(f);
}

/* All corners of the cells of some cubes, which share many. */
static void find_values(const finder *f, const uint32_t *cubes, uint32_t count) {
    const search *s = f->s;
    const size_t nodes = node_at(s, 0, 0, s->nodes[2]);
    for (size_t i = 0; i < nodes; i++)
        f->value[i] = NAN;
    f->points->count = 0;
    for (uint32_t c = 0; c < count; c++) {
        uint32_t at[3];
        cube_at(s, cubes[c], at);
        for (uint32_t z = 0; z <= s->cells; z++)
            for (uint32_t y = 0; y <= s->cells; y++)
                for (uint32_t x = 0; x <= s->cells; x++)
                    ask_for_node(f, node_at(s, at[0] * s->cells + x, at[1] * s->cells + y, at[2] * s->cells + z));
    }
    evaluate_nodes(f);
}

/* ---- Looking at the edges ------------------------------------------------------------------------------- */

static void add_hard(finder *f, const float p[3]) {
    nsdf_sample_set *hard = f->hard;
    size_t i = hard->count < NSDF_MOST_HARD ? hard->count++ : nsdf_random_below(&f->random, NSDF_MOST_HARD);
    hard->x[i] = p[0];
    hard->y[i] = p[1];
    hard->z[i] = p[2];
    hard->d[i] = nsdf_sdf_distance(f->sdf, p);
}

static int is_near(const finder *f, const float p[3]) {
    return nsdf_sdf_is_within(f->sdf, p, NSDF_STRAY_TOLERANCE);
}

static void look_at_crossing(finder *f, const float p[3]) {
    const nsdf_stray_job *job = f->s->job;
    for (int k = 0; k < 3; k++)
        if (p[k] < job->domain_min[k] || p[k] > job->domain_max[k])
            return; /* the grid covers more than the domain */
    if (is_near(f, p))
        return;
    f->found++;
    if (f->found > STRAYS_WANTED && nsdf_random_below(&f->random, (uint32_t)f->found) >= STRAYS_WANTED)
        return;
    add_hard(f, p);
    for (int i = 1; i < POINTS_PER_STRAY; i++) {
        float q[3];
        for (int k = 0; k < 3; k++)
            q[k] = p[k] + 0.7f * f->s->h * nsdf_random_normal(&f->random);
        add_hard(f, q);
    }
}

static void look_at_edge(finder *f, size_t from, size_t to) {
    float a = f->value[from], b = f->value[to], p[3], q[3];
    if ((a < 0.0f) == (b < 0.0f))
        return;
    node_point(f->s, from, p);
    node_point(f->s, to, q);
    for (size_t k = 0; k < 3; k++)
        p[k] += a / (a - b) * (q[k] - p[k]);
    look_at_crossing(f, p);
}

/* Edges of one cube; those on the far faces belong to the neighbours. */
static void look_at_cube(finder *f, uint32_t cube) {
    const search *s = f->s;
    uint32_t at[3];
    cube_at(s, cube, at);
    for (uint32_t z = 0; z < s->cells; z++)
        for (uint32_t y = 0; y < s->cells; y++)
            for (uint32_t x = 0; x < s->cells; x++) {
                const size_t i = node_at(s, at[0] * s->cells + x, at[1] * s->cells + y, at[2] * s->cells + z);
                look_at_edge(f, i, i + 1);
                look_at_edge(f, i, i + s->nodes[0]);
                look_at_edge(f, i, i + (size_t)s->nodes[0] * s->nodes[1]);
            }
}

int nsdf_stray_room(nsdf_sample_set *hard) {
    if (hard->x)
        return 0;
    const int failed = nsdf_sample_set_create(hard, NSDF_MOST_HARD);
    hard->count = 0;
    return failed;
}

/* Looks into the cubes of one frame that may hold some of the surface. */
static void look_around(finder *f, uint32_t *cubes) {
    const uint32_t kept = near_cubes(f, cubes);
    find_values(f, cubes, kept);
    for (uint32_t c = 0; c < kept; c++)
        look_at_cube(f, cubes[c]);
}

static void search_frame(void *data, uint32_t index, uint32_t worker) {
    search *s = data;
    const nsdf_stray_job *job = s->job;
    const size_t nodes = node_at(s, 0, 0, s->nodes[2]), cubes = (size_t)s->cubes[0] * s->cubes[1] * s->cubes[2];
    float *composed = malloc(job->model->composed_size * sizeof *composed);
    float *value = malloc(nodes * sizeof *value);
    uint32_t *kept = malloc(cubes * sizeof *kept);
    point_list *points = malloc(sizeof *points);
    nsdf_sdf *sdf = nsdf_frame_sdf(&job->frames->frames[index]);
    s->failed[index] = !composed || !value || !kept || !points || !sdf || nsdf_stray_room(&job->hard[index]) != 0;
    if (!s->failed[index]) {
        finder f = {s,
                    sdf,
                    composed,
                    job->scratch[worker],
                    (float)((double)job->model->desc.time_scale * job->u[index]),
                    value,
                    points,
                    &job->hard[index],
                    nsdf_random_start(job->seed, 0x200000000u + index),
                    0};
        nsdf_model_compose(job->model, job->parameters, job->u[index], composed);
        look_around(&f, kept);
        s->found[index] = f.found;
    }
    nsdf_sdf_free(sdf);
    free(composed);
    free(value);
    free(kept);
    free(points);
}

int nsdf_find_strays(const nsdf_stray_job *job, uint64_t *found) {
    search s;
    nsdf_random random = nsdf_random_start(job->seed, 3);
    uint32_t frames = job->frames->count;
    float longest = 0.0f;
    int failed = 0;
    memset(&s, 0, sizeof s);
    s.job = job;
    for (int k = 0; k < 3; k++)
        longest = fmaxf(longest, job->domain_max[k] - job->domain_min[k]);
    s.cells = job->resolution / CUBES;
    s.cells = s.cells < 1 ? 1 : s.cells > MOST_CELLS ? MOST_CELLS : s.cells;
    s.h = longest / (float)(CUBES * s.cells);
    for (int k = 0; k < 3; k++) {
        s.origin[k] = job->domain_min[k] - s.h * nsdf_random_unit(&random);
        s.cubes[k] = (uint32_t)ceilf((job->domain_max[k] - s.origin[k]) / (s.h * (float)s.cells));
        s.nodes[k] = s.cubes[k] * s.cells + 1;
    }
    s.found = calloc(frames, sizeof *s.found);
    s.failed = calloc(frames, 1);
    *found = 0;
    if (s.found && s.failed)
        nsdf_workers_run(job->workers, frames, search_frame, &s);
    else
        failed = 1;
    for (uint32_t i = 0; i < frames && !failed; i++) {
        failed = s.failed[i];
        *found += s.found[i];
    }
    free(s.found);
    free(s.failed);
    return failed ? -1 : 0;
}

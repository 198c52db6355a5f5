#include "stray.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Each stray crossing gives so many samples; of more crossings than STRAYS_WANTED in a frame, ever fewer are used,
 * since true distances far from the surface are dear. */
enum { POINTS_PER_STRAY = 3, STRAYS_WANTED = 300 };

/* The domain is cut into cubes; those whose centre is far from the zero set are skipped, as the decoder will do with a
 * bound like this one. */
enum { CUBES = 32, MOST_CELLS = 4, MOST_NODES = (MOST_CELLS + 1) * (MOST_CELLS + 1) * (MOST_CELLS + 1), CHUNK = 4096 };
static const float search_bound = 1.8f;

typedef struct {
    const nsdf_stray_job *job;
    uint32_t cubes[3], cells; /* cubes along each axis; cells along a cube's edge */
    float origin[3], h;       /* h = edge of a cell */
    uint64_t *found;          /* [frame] */
    uint8_t *failed;          /* [frame] */
} search;

typedef struct {
    const search *s;
    const nsdf_sdf *sdf;
    const float *composed;
    nsdf_fit_scratch *scratch;
    float time;
    nsdf_sample_set *hard;
    nsdf_random random;
    uint64_t found;
} finder;

static void evaluate(const finder *f, const float *xyz, size_t count, float *value) {
    nsdf_fit_points points = {xyz, xyz + CHUNK, xyz + 2 * CHUNK, NULL, count, f->time};
    nsdf_fit_forward(f->s->job->model, f->s->job->kernels, f->scratch, f->composed, &points, value);
}

static void cube_corner(const search *s, uint32_t cube, float corner[3]) {
    uint32_t at[3] = {cube % s->cubes[0], cube / s->cubes[0] % s->cubes[1], cube / s->cubes[0] / s->cubes[1]};
    for (int k = 0; k < 3; k++)
        corner[k] = s->origin[k] + (float)(at[k] * s->cells) * s->h;
}

static void set_point(float *xyz, size_t i, float x, float y, float z) {
    xyz[i] = x;
    xyz[CHUNK + i] = y;
    xyz[2 * CHUNK + i] = z;
}

/* Numbers of the cubes to look into; returns how many. */
static uint32_t near_cubes(const finder *f, float *xyz, float *value, uint32_t *list) {
    const search *s = f->s;
    uint32_t total = s->cubes[0] * s->cubes[1] * s->cubes[2], kept = 0;
    float half = 0.5f * (float)s->cells * s->h, limit = search_bound * half * sqrtf(3.0f);
    for (uint32_t first = 0; first < total; first += CHUNK) {
        uint32_t n = total - first < CHUNK ? total - first : CHUNK;
        for (uint32_t i = 0; i < n; i++) {
            float corner[3];
            cube_corner(s, first + i, corner);
            set_point(xyz, i, corner[0] + half, corner[1] + half, corner[2] + half);
        }
        evaluate(f, xyz, n, value);
        for (uint32_t i = 0; i < n; i++)
            if (fabsf(value[i]) <= limit)
                list[kept++] = first + i;
    }
    return kept;
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

static void look_at_edge(finder *f, const float *xyz, size_t from, size_t to, const float *value) {
    float a = value[from], b = value[to];
    if ((a < 0.0f) == (b < 0.0f))
        return;
    float t = a / (a - b), p[3];
    for (size_t k = 0; k < 3; k++)
        p[k] = xyz[k * CHUNK + from] + t * (xyz[k * CHUNK + to] - xyz[k * CHUNK + from]);
    look_at_crossing(f, p);
}

/* Edges of one cube, whose nodes begin at `base`; those on the far faces belong to the neighbours. */
static void look_at_cube(finder *f, const float *xyz, const float *value, size_t base) {
    size_t n = f->s->cells + 1;
    for (size_t z = 0; z + 1 < n; z++)
        for (size_t y = 0; y + 1 < n; y++)
            for (size_t x = 0; x + 1 < n; x++) {
                size_t i = base + (z * n + y) * n + x;
                look_at_edge(f, xyz, i, i + 1, value);
                look_at_edge(f, xyz, i, i + n, value);
                look_at_edge(f, xyz, i, i + n * n, value);
            }
}

static void look_at_cubes(finder *f, float *xyz, float *value, const uint32_t *list, uint32_t count) {
    const search *s = f->s;
    uint32_t n = s->cells + 1, nodes = n * n * n, together = CHUNK / nodes;
    for (uint32_t first = 0; first < count; first += together) {
        uint32_t cubes = count - first < together ? count - first : together;
        for (uint32_t c = 0; c < cubes; c++) {
            float corner[3];
            cube_corner(s, list[first + c], corner);
            for (uint32_t i = 0; i < nodes; i++)
                set_point(xyz, (size_t)c * nodes + i, corner[0] + (float)(i % n) * s->h,
                          corner[1] + (float)(i / n % n) * s->h, corner[2] + (float)(i / n / n) * s->h);
        }
        evaluate(f, xyz, (size_t)cubes * nodes, value);
        for (uint32_t c = 0; c < cubes; c++)
            look_at_cube(f, xyz, value, (size_t)c * nodes);
    }
}

int nsdf_stray_room(nsdf_sample_set *hard) {
    if (hard->x)
        return 0;
    hard->x = malloc(NSDF_MOST_HARD * sizeof(float));
    hard->y = malloc(NSDF_MOST_HARD * sizeof(float));
    hard->z = malloc(NSDF_MOST_HARD * sizeof(float));
    hard->d = malloc(NSDF_MOST_HARD * sizeof(float));
    return hard->x && hard->y && hard->z && hard->d ? 0 : -1;
}

static void search_frame(void *data, uint32_t index, uint32_t worker) {
    search *s = data;
    const nsdf_stray_job *job = s->job;
    const nsdf_frame *frame = &job->frames->frames[index];
    uint32_t total = s->cubes[0] * s->cubes[1] * s->cubes[2];
    float *memory = malloc((job->model->composed_size + 4 * CHUNK) * sizeof *memory);
    uint32_t *list = malloc(total * sizeof *list);
    nsdf_sdf *sdf = nsdf_frame_sdf(frame);
    s->failed[index] = !memory || !list || !sdf || nsdf_stray_room(&job->hard[index]) != 0;
    if (!s->failed[index]) {
        float *composed = memory + 4 * CHUNK, *value = memory + 3 * CHUNK;
        finder f = {s,
                    sdf,
                    composed,
                    job->scratch[worker],
                    (float)((double)job->model->desc.time_scale * job->u[index]),
                    &job->hard[index],
                    nsdf_random_start(job->seed, 0x200000000u + index),
                    0};
        nsdf_model_compose(job->model, job->parameters, job->u[index], composed);
        uint32_t kept = near_cubes(&f, memory, value, list);
        look_at_cubes(&f, memory, value, list, kept);
        s->found[index] = f.found;
    }
    nsdf_sdf_free(sdf);
    free(memory);
    free(list);
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

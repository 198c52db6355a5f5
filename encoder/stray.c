#include "stray.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS_PER_STRAY = 3 };

typedef struct {
    const nsdf_stray_job *job;
    uint32_t nodes[3];
    float origin[3], h;
    uint64_t *found; /* [frame] */
    uint8_t *failed; /* [frame] */
} search;

typedef struct {
    const search *s;
    const nsdf_sdf *sdf;
    nsdf_sample_set *hard;
    nsdf_random random;
    uint64_t found;
} finder;

/* ---- Evaluating the grid -------------------------------------------------------------------------------- */

static float node_at(const search *s, uint32_t axis, uint32_t i) {
    return s->origin[axis] + (float)i * s->h;
}

/* Values of one plane of constant z. */
static void evaluate_plane(const search *s, const float *composed, nsdf_fit_scratch *scratch, double u, uint32_t z,
                           float *xyz, float *value) {
    size_t count = (size_t)s->nodes[0] * s->nodes[1];
    for (uint32_t y = 0; y < s->nodes[1]; y++)
        for (uint32_t x = 0; x < s->nodes[0]; x++) {
            size_t i = (size_t)y * s->nodes[0] + x;
            xyz[i] = node_at(s, 0, x);
            xyz[count + i] = node_at(s, 1, y);
            xyz[2 * count + i] = node_at(s, 2, z);
        }
    nsdf_fit_points points = {xyz, xyz + count, xyz + 2 * count, NULL, count,
                              (float)((double)s->job->model->desc.time_scale * u)};
    nsdf_fit_forward(s->job->model, s->job->kernels, scratch, composed, &points, value);
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

static void look_at_crossing(finder *f, const float p[3]) {
    if (nsdf_sdf_unsigned(f->sdf, p, NSDF_STRAY_TOLERANCE, NULL) < NSDF_STRAY_TOLERANCE) return;
    f->found++;
    add_hard(f, p);
    for (int i = 1; i < POINTS_PER_STRAY; i++) {
        float q[3];
        for (int k = 0; k < 3; k++) q[k] = p[k] + 0.7f * f->s->h * nsdf_random_normal(&f->random);
        add_hard(f, q);
    }
}

static void look_at_edge(finder *f, const uint32_t at[3], int axis, float a, float b) {
    if ((a < 0.0f) == (b < 0.0f)) return;
    float p[3];
    for (uint32_t k = 0; k < 3; k++) p[k] = node_at(f->s, k, at[k]);
    p[axis] += f->s->h * (a / (a - b));
    look_at_crossing(f, p);
}

/* Edges of a plane, and from it to the one below (`below` NULL for the first plane). */
static void look_at_plane(finder *f, uint32_t z, const float *value, const float *below) {
    const uint32_t nx = f->s->nodes[0], ny = f->s->nodes[1];
    for (uint32_t y = 0; y < ny; y++)
        for (uint32_t x = 0; x < nx; x++) {
            const float *v = value + (size_t)y * nx + x;
            uint32_t at[3] = {x, y, z};
            if (x + 1 < nx) look_at_edge(f, at, 0, v[0], v[1]);
            if (y + 1 < ny) look_at_edge(f, at, 1, v[0], v[nx]);
            if (!below) continue;
            at[2] = z - 1;
            look_at_edge(f, at, 2, below[(size_t)y * nx + x], v[0]);
        }
}

static int make_room(nsdf_sample_set *hard) {
    if (hard->x) return 0;
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
    size_t plane = (size_t)s->nodes[0] * s->nodes[1];
    float *composed = malloc(job->model->composed_size * sizeof(float)), *memory = malloc(5 * plane * sizeof(float));
    nsdf_sdf *sdf = nsdf_sdf_create(&frame->surface, frame->sign, job->shell);
    s->failed[index] = !composed || !memory || !sdf || make_room(&job->hard[index]) != 0;
    if (!s->failed[index]) {
        finder f = {s, sdf, &job->hard[index], nsdf_random_start(job->seed, 0x200000000u + index), 0};
        float *value[2] = {memory + 3 * plane, memory + 4 * plane};
        nsdf_model_compose(job->model, job->parameters, job->u[index], composed);
        for (uint32_t z = 0; z < s->nodes[2]; z++) {
            evaluate_plane(s, composed, job->scratch[worker], job->u[index], z, memory, value[z % 2]);
            look_at_plane(&f, z, value[z % 2], z ? value[(z + 1) % 2] : NULL);
        }
        s->found[index] = f.found;
    }
    nsdf_sdf_free(sdf);
    free(composed);
    free(memory);
}

int nsdf_find_strays(const nsdf_stray_job *job, uint64_t *found) {
    search s;
    nsdf_random random = nsdf_random_start(job->seed, 3);
    uint32_t frames = job->frames->count;
    float longest = 0.0f;
    int failed = 0;
    memset(&s, 0, sizeof s);
    s.job = job;
    for (int k = 0; k < 3; k++) longest = fmaxf(longest, job->domain_max[k] - job->domain_min[k]);
    s.h = longest / (float)job->resolution;
    for (int k = 0; k < 3; k++) {
        s.origin[k] = job->domain_min[k] - s.h * nsdf_random_unit(&random);
        s.nodes[k] = (uint32_t)ceilf((job->domain_max[k] - s.origin[k]) / s.h) + 1;
    }
    s.found = calloc(frames, sizeof *s.found);
    s.failed = calloc(frames, 1);
    *found = 0;
    if (s.found && s.failed) nsdf_workers_run(job->workers, frames, search_frame, &s);
    else failed = 1;
    for (uint32_t i = 0; i < frames && !failed; i++) {
        failed = s.failed[i];
        *found += s.found[i];
    }
    free(s.found);
    free(s.failed);
    return failed ? -1 : 0;
}

#include "block_start.h"

#include "dense_solve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FRAMES = 12, SIDE = 7 };
static const float farthest = 0.1f; /* distances are looked for up to this first */

typedef struct {
    nsdf_block_model *model;
    uint32_t count;
    nsdf_sdf *sdf[FRAMES];
    float (*poses[FRAMES])[12]; /* [block] */
    uint8_t *alive[FRAMES];     /* [block] */
    float (*normals)[3];        /* [block] */
} job;

/* Mean signed distance of the ball's point u over the frames on which the block is there. */
static double mean_distance(const job *j, uint32_t block, float radius, const float u[3]) {
    double sum = 0.0;
    uint32_t count = 0;
    for (uint32_t f = 0; f < j->count; f++) {
        if (!j->alive[f][block])
            continue;
        count++;
        const float *p = j->poses[f][block];
        float x[3];
        for (int row = 0; row < 3; row++)
            x[row] = p[4 * row + 3] + radius * (p[4 * row] * u[0] + p[4 * row + 1] * u[1] + p[4 * row + 2] * u[2]);
        sum += (double)nsdf_sdf_distance_below(j->sdf[f], x, farthest);
    }
    return sum / count;
}

static int is_alive(const job *j, uint32_t block) {
    int alive = 0;
    for (uint32_t f = 0; f < j->count; f++)
        alive |= j->alive[f][block];
    return alive;
}

/* A plane through the centre. */
static void start_plane(const job *j, uint32_t block, float radius) {
    float *first = j->model->values + nsdf_block_degree_offset(j->model, block, 1);
    for (int k = 0; j->model->desc.degree >= 1 && k < 3; k++)
        first[k] = radius * j->normals[block][k];
}

static void start_block(void *data, uint32_t block, uint32_t worker) {
    const job *j = data;
    const nsdf_block_model *m = j->model;
    const size_t n = m->terms;
    const float radius = m->values[nsdf_block_offset(&m->desc, NSDF_BLOCK_RADII) + block];
    double matrix[NSDF_BLOCK_MOST_TERMS * NSDF_BLOCK_MOST_TERMS] = {0.0}, right[NSDF_BLOCK_MOST_TERMS] = {0.0};
    (void)worker;
    if (!is_alive(j, block)) {
        start_plane(j, block, radius);
        return;
    }
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        const float u[3] = {2.0f * (float)(i % SIDE) / (SIDE - 1) - 1.0f,
                            2.0f * (float)(i / SIDE % SIDE) / (SIDE - 1) - 1.0f,
                            2.0f * (float)(i / SIDE / SIDE) / (SIDE - 1) - 1.0f};
        const double root = 1.0 - (double)(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        float basis[NSDF_BLOCK_MOST_TERMS];
        if (root <= 0.0)
            continue;
        const double d = mean_distance(j, block, radius, u);
        /* The border counts too: outside of all balls, it alone tells inside from outside. */
        const double w = (0.1 + root * root) / (0.1 * (double)radius + fabs(d));
        nsdf_block_basis(m->desc.degree, u, basis);
        for (size_t a = 0; a < n; a++) {
            right[a] += w * (double)basis[a] * d;
            for (size_t b = 0; b < n; b++)
                matrix[a * n + b] += w * (double)basis[a] * (double)basis[b];
        }
    }
    for (size_t a = 0; a < n; a++)
        matrix[a * n + a] *= 1.0001;
    nsdf_solve_positive(matrix, n, right, 1);
    size_t a = 0;
    for (uint32_t d = 0; d <= m->desc.degree; d++)
        for (uint32_t i = 0; i < nsdf_degree_terms(d); i++)
            m->values[nsdf_block_degree_offset(m, block, d) + i] = (float)right[a++];
    for (uint32_t k = 1; k < m->level_knots; k++)
        m->values[m->level_offset + (size_t)k * m->desc.block_count + block] = (float)right[0];
}

typedef struct {
    job *job;
    const nsdf_frames *frames;
} builder;

static void build_distance(void *data, uint32_t index, uint32_t worker) {
    const builder *b = data;
    (void)worker;
    const uint32_t f = (uint32_t)(((uint64_t)2 * index + 1) * b->frames->count / (2 * b->job->count));
    b->job->sdf[index] = nsdf_frame_sdf(&b->frames->frames[f]);
}

int nsdf_block_start(nsdf_block_model *model, float (*normals)[3], const nsdf_frames *frames, const double *u,
                     nsdf_block_frame *scratch, nsdf_workers *workers) {
    const size_t size = sizeof(float[12]) * model->desc.block_count;
    job j = {.model = model, .normals = normals, .count = frames->count < FRAMES ? frames->count : FRAMES};
    builder b = {&j, frames};
    nsdf_workers_run(workers, j.count, build_distance, &b);
    int failed = 0;
    for (uint32_t i = 0; i < j.count; i++) {
        const uint32_t f = (uint32_t)(((uint64_t)2 * i + 1) * frames->count / (2 * j.count));
        j.poses[i] = malloc(size);
        j.alive[i] = malloc(model->desc.block_count);
        failed |= !j.sdf[i] || !j.poses[i] || !j.alive[i];
        nsdf_block_frame_compose(scratch, model, model->values, u[f]);
        if (!failed) {
            memcpy(j.poses[i], scratch->pose, size);
            memcpy(j.alive[i], scratch->alive, model->desc.block_count);
        }
    }
    if (!failed)
        nsdf_workers_run(workers, model->desc.block_count, start_block, &j);
    for (uint32_t i = 0; i < j.count; i++) {
        nsdf_sdf_free(j.sdf[i]);
        free(j.poses[i]);
        free(j.alive[i]);
    }
    return failed ? -1 : 0;
}

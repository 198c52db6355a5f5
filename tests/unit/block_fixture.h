/* Blocks on frames of a mesh, for tests of fitting them. */
#ifndef BLOCK_FIXTURE_H
#define BLOCK_FIXTURE_H

#include "block_model.h"
#include "fit_samples.h"
#include "motion_samples.h"

static const float low[3] = {-0.6f, -0.6f, -0.6f}, high[3] = {0.6f, 0.6f, 0.6f};

/* What all tests fit: frames of a mesh, and a model whose coefficients are still 0. */
typedef struct {
    nsdf_frames frames;
    double u[SAMPLE_FRAMES];
    nsdf_workers *workers;
    nsdf_block_model model;
    nsdf_block_frame frame;
    float (*normals)[3]; /* [block] */
} fixture;

static inline fixture make_fixture(nsdf_surface rest, uint32_t second_part, sample_mover move, uint32_t blocks,
                                   uint32_t bones, uint32_t degree) {
    const nsdf_block_steps steps = {2e-4, 2e-4};
    fixture x;
    nsdf_bones found;
    x.frames = sample_frames(&rest, SAMPLE_FRAMES, second_part, move);
    for (uint32_t f = 0; f < SAMPLE_FRAMES; f++)
        x.u[f] = (double)f / (SAMPLE_FRAMES - 1);
    x.workers = nsdf_workers_create(1);
    nsdf_motion motion = sample_motion(&x.frames, blocks, x.workers);
    assert_int_equal(nsdf_bones_fit(&found, &motion, bones, x.workers), 0);
    assert_int_equal(nsdf_block_model_create(&x.model, &motion, &found, x.u, degree, 1.0, &steps), 0);
    assert_int_equal(nsdf_block_frame_create(&x.frame, &x.model, low, high), 0);
    x.normals = motion.normals;
    motion.normals = NULL;
    nsdf_motion_free(&motion);
    nsdf_bones_free(&found);
    return x;
}

static inline fixture two_balls(uint32_t blocks, uint32_t bones, uint32_t degree) {
    uint32_t second;
    nsdf_surface rest = sample_two_balls(&second);
    return make_fixture(rest, second, sample_rigid, blocks, bones, degree);
}

static inline void free_fixture(fixture *x) {
    free(x->normals);
    nsdf_block_frame_free(&x->frame);
    nsdf_block_model_free(&x->model);
    nsdf_workers_free(x->workers);
    sample_frames_free(&x->frames);
}

static inline const float *values_of(const nsdf_block_model *m, uint32_t tensor) {
    return m->values + nsdf_block_offset(&m->desc, tensor);
}

/* The ball's coordinates of a point, and 1 - |u|^2. */
static inline double to_ball(const nsdf_block_frame *frame, uint32_t block, const float p[3], float u[3]) {
    const float *m = frame->map[block];
    double root = 1.0;
    for (int row = 0; row < 3; row++) {
        u[row] = m[4 * row] * p[0] + m[4 * row + 1] * p[1] + m[4 * row + 2] * p[2] + m[4 * row + 3];
        root -= (double)u[row] * (double)u[row];
    }
    return root;
}

/* The field by its definition, from the coefficients. */
static inline double field_at(const nsdf_block_frame *frame, const nsdf_block_model *m, const float p[3],
                              uint32_t *hits) {
    double weight = 0.0, sum = 0.0;
    *hits = 0;
    for (uint32_t k = 0; k < m->desc.block_count; k++) {
        float u[3], basis[NSDF_BLOCK_MOST_TERMS];
        const double root = to_ball(frame, k, p, u);
        uint32_t n = 0;
        if (!(root > 0.0))
            continue;
        ++*hits;
        weight += root * root;
        nsdf_block_basis(m->desc.degree, u, basis);
        for (uint32_t d = 0; d <= m->desc.degree; d++)
            for (uint32_t i = 0; i < nsdf_degree_terms(d); i++)
                sum += root * root * (double)m->values[nsdf_block_degree_offset(m, k, d) + i] * (double)basis[n++];
    }
    return sum / weight;
}

#endif

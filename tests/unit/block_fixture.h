/* Blocks on frames of a mesh, for tests of fitting them. */
#ifndef BLOCK_FIXTURE_H
#define BLOCK_FIXTURE_H

#include "block_fit.h"
#include "block_model.h"
#include "block_start.h"
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

/* level_spacing: frames per control point of the levels, 0 = they do not move. */
static inline fixture make_level_fixture(nsdf_surface rest, uint32_t second_part, sample_mover move, uint32_t blocks,
                                         uint32_t bones, uint32_t degree, double level_spacing) {
    const nsdf_block_steps steps = {2e-4, 2e-4};
    fixture x;
    nsdf_bones found;
    x.frames = sample_frames(&rest, SAMPLE_FRAMES, second_part, move);
    for (uint32_t f = 0; f < SAMPLE_FRAMES; f++)
        x.u[f] = (double)f / (SAMPLE_FRAMES - 1);
    x.workers = nsdf_workers_create(1);
    nsdf_motion motion = sample_motion(&x.frames, blocks, x.workers);
    assert_int_equal(nsdf_bones_fit(&found, &motion, bones, x.workers), 0);
    assert_int_equal(nsdf_block_model_create(&x.model, &motion, &found, x.u, degree, 1.0, level_spacing, &steps), 0);
    assert_int_equal(nsdf_block_frame_create(&x.frame, &x.model, low, high), 0);
    x.normals = motion.normals;
    motion.normals = NULL;
    nsdf_motion_free(&motion);
    nsdf_bones_free(&found);
    return x;
}

static inline fixture make_fixture(nsdf_surface rest, uint32_t second_part, sample_mover move, uint32_t blocks,
                                   uint32_t bones, uint32_t degree) {
    return make_level_fixture(rest, second_part, move, blocks, bones, degree, 0.0);
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

/* Weights that blocks have in turn, each of them on bones that follow each other. */
static inline void spread_weights(fixture *x, const float (*shares)[NSDF_BONE_INFLUENCES], size_t kinds) {
    nsdf_block_model *m = &x->model;
    float *weight = m->values + nsdf_block_offset(&m->desc, NSDF_BLOCK_WEIGHTS);
    for (size_t k = 0; k < m->desc.block_count; k++)
        for (uint32_t i = 0; i < NSDF_BONE_INFLUENCES; i++, weight++) {
            *weight = shares[k % kinds][i];
            m->influences[NSDF_BONE_INFLUENCES * k + i].bone = (uint32_t)(k + i) % m->desc.bone_count;
        }
    nsdf_block_model_set_influences(m);
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

/* ---- Fitting --------------------------------------------------------------------------------------------- */

static inline void start(fixture *x) {
    assert_int_equal(nsdf_block_start(&x->model, x->normals, &x->frames, x->u, &x->frame, x->workers), 0);
}

typedef struct {
    nsdf_sample_set sets[SAMPLE_FRAMES];
    nsdf_encoder_options options;
    nsdf_file_header header;
    nsdf_fit_job job;
} fit_fixture;

static inline void make_fit(fit_fixture *f, fixture *x, uint64_t steps) {
    nsdf_sampler_params params;
    memset(f, 0, sizeof *f);
    f->options = sample_options(2, 8);
    f->options.steps = steps;
    f->options.batch_frames = 3;
    f->options.batch_points = 500;
    f->header = unit_header(SAMPLE_FRAMES);
    nsdf_sampler_defaults(&params);
    params.count = 4000;
    for (int axis = 0; axis < 3; axis++) {
        f->header.domain_min[axis] = params.domain_min[axis] = low[axis];
        f->header.domain_max[axis] = params.domain_max[axis] = high[axis];
    }
    for (uint32_t i = 0; i < SAMPLE_FRAMES; i++) {
        nsdf_random random = nsdf_random_start(i, 9);
        nsdf_sdf *sdf = nsdf_frame_sdf(&x->frames.frames[i]);
        assert_int_equal(nsdf_sample_frame(sdf, &x->frames.frames[i].surface, &params, &random, &f->sets[i]), 0);
        nsdf_sdf_free(sdf);
    }
    f->job = (nsdf_fit_job){.options = &f->options,
                            .samples = f->sets,
                            .u = x->u,
                            .frame_count = SAMPLE_FRAMES,
                            .frames = &x->frames,
                            .header = &f->header,
                            .workers = x->workers};
}

static inline void free_fit(fit_fixture *f) {
    for (int i = 0; i < SAMPLE_FRAMES; i++)
        nsdf_sample_set_free(&f->sets[i]);
}

#endif

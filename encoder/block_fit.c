#include "block_fit.h"

#include "block_batch.h"
#include "block_rate.h"
#include "frame_order.h"
#include "optimiser.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rates for a full first step, normalised units; both follow the schedule of the network's fitting. */
static const double coefficient_rate = 1e-4, pose_rate = 2e-4;
/* Loss weight 1/2 there; but 1 where the value is less than this share of the distance, or has the wrong sign: there
 * would soon be a surface. */
static const float weight_distance = 0.005f, safe_share = 0.25f;
static const double rounding_share = 0.3; /* of the steps, at the end, see rounded values */
static const float least_denominator = 2e-9f;

/* What a slot (one frame of a batch) works with. */
typedef struct {
    uint32_t frame;
    size_t first; /* of the stride through the frame's samples */
    nsdf_block_frame at;
    nsdf_block_batch batch;
    float (*terms)[NSDF_BLOCK_MOST_TERMS]; /* [block]: gradient, of monomials */
    float (*poses)[12];                    /* [block]: gradient */
    nsdf_fit_sums sums;
    size_t points;
    int failed;
} slot;

typedef struct {
    const nsdf_fit_job *job;
    nsdf_block_model *model;
    const nsdf_block_passes *passes;
    nsdf_random random;
    nsdf_frame_order order;
    slot *slots; /* [batch_frames] */
    nsdf_adam terms, poses;
    float *gradient, *rounded; /* [value_count] */
    float *bone_scratch;
    const float *active;
    double near_error;
} state;

/* ---- Setting up ------------------------------------------------------------------------------------------ */

static void free_state(state *s) {
    for (uint32_t i = 0; s->slots && i < s->job->options->batch_frames; i++) {
        nsdf_block_frame_free(&s->slots[i].at);
        nsdf_block_batch_free(&s->slots[i].batch);
        free(s->slots[i].terms);
        free(s->slots[i].poses);
    }
    free(s->slots);
    nsdf_frame_order_free(&s->order);
    free(s->gradient);
    free(s->rounded);
    free(s->bone_scratch);
    nsdf_adam_free(&s->terms);
    nsdf_adam_free(&s->poses);
}

static int create_slot(slot *sl, const nsdf_fit_job *job, const nsdf_block_model *model) {
    const size_t k = model->desc.block_count;
    sl->terms = malloc(sizeof *sl->terms * k);
    sl->poses = malloc(sizeof *sl->poses * k);
    return sl->terms && sl->poses &&
                   nsdf_block_frame_create(&sl->at, model, job->header->domain_min, job->header->domain_max) == 0 &&
                   nsdf_block_batch_create(&sl->batch, job->options->batch_points, model->desc.block_count, &sl->at) ==
                       0
               ? 0
               : -1;
}

static int create_state(state *s, const nsdf_fit_job *job, nsdf_block_model *model) {
    memset(s, 0, sizeof *s);
    s->job = job;
    s->model = model;
    s->passes = nsdf_block_passes_select();
    s->random = nsdf_random_start(job->options->seed, 3);
    s->slots = calloc(job->options->batch_frames, sizeof *s->slots);
    s->gradient = calloc(model->value_count, sizeof(float));
    s->rounded = calloc(model->value_count, sizeof(float));
    s->bone_scratch = calloc(12 * (size_t)model->desc.bone_count, sizeof(float));
    int ok = nsdf_frame_order_create(&s->order, job->frame_count) == 0 && s->slots && s->gradient && s->rounded &&
             s->bone_scratch && nsdf_adam_create(&s->terms, model->term_count) == 0 &&
             nsdf_adam_create(&s->poses, model->pose_count) == 0;
    for (uint32_t i = 0; ok && i < job->options->batch_frames; i++)
        ok = create_slot(&s->slots[i], job, model) == 0;
    s->terms.epsilon = least_denominator; /* coefficients that see no gradient stay where they are */
    return ok ? 0 : -1;
}

/* ---- One step -------------------------------------------------------------------------------------------- */

/* The samples of a slot: some of the frame's. */
static void fill_batch(const state *s, slot *sl) {
    const nsdf_sample_set *set = &s->job->samples[sl->frame];
    const size_t wanted = s->job->options->batch_points, stride = set->count > wanted ? set->count / wanted : 1;
    nsdf_block_batch *b = &sl->batch;
    b->count = 0;
    for (size_t i = sl->first % stride; i < set->count && b->count < wanted; i += stride)
        nsdf_block_batch_add(b, set->x[i], set->y[i], set->z[i], set->d[i]);
}

/* f and dL/df at the points that some ball holds: the others do not count. */
static void differentiate(slot *sl, float scale) {
    nsdf_block_batch *b = &sl->batch;
    sl->sums = (nsdf_fit_sums){0, 0, 0};
    sl->points = 0;
    for (uint32_t i = 0; i < b->count; i++) {
        const float d = b->d[b->source[i]], sum = b->weight[i];
        if (!(sum > 0.0f))
            continue;
        const float f = b->value[i] / sum;
        const float side = d < 0.0f ? -f : f;
        const float weight = side < safe_share * fabsf(d) ? 1.0f : weight_distance / (weight_distance + fabsf(d));
        const float share = scale * weight / sum;
        b->value[i] = f;
        b->weight[i] = f > d ? share : -share;
        sl->points++;
        if (fabsf(d) < NSDF_NEAR_LIMIT) {
            sl->sums.near_error += (double)fabsf(f - d);
            sl->sums.near_count++;
        }
    }
}

/* u = U (x - c), U = M^-1 / r: dL/dc = -U^T g and dL/dM = -U^T g (r u)^T for g = dL/du. */
static void pose_gradient(const float map[12], float radius, const nsdf_block_gradient *sums, float pose[12]) {
    for (int row = 0; row < 3; row++) {
        pose[4 * row + 3] =
            -(map[row] * sums->slope[0] + map[4 + row] * sums->slope[1] + map[8 + row] * sums->slope[2]);
        for (int k = 0; k < 3; k++)
            pose[4 * row + k] = -radius * (map[row] * sums->moment[k] + map[4 + row] * sums->moment[3 + k] +
                                           map[8 + row] * sums->moment[6 + k]);
    }
}

static void run_slot(void *data, uint32_t index, uint32_t worker) {
    state *s = data;
    slot *sl = &s->slots[index];
    const nsdf_block_model *m = s->model;
    const float *radii = m->values + nsdf_block_offset(&m->desc, NSDF_BLOCK_RADII);
    const float scale = 1.0f / ((float)s->job->options->batch_points * (float)s->job->options->batch_frames);
    (void)worker;
    fill_batch(s, sl);
    nsdf_block_frame_compose(&sl->at, m, s->active, s->job->u[sl->frame]);
    sl->failed = nsdf_block_batch_find(&sl->batch, s->passes, &sl->at, m->desc.block_count);
    for (uint32_t k = 0; !sl->failed && k < m->desc.block_count; k++)
        s->passes->forward(&sl->batch, k, m->desc.degree, sl->at.terms[k]);
    differentiate(sl, scale);
    for (uint32_t k = 0; !sl->failed && k < m->desc.block_count; k++) {
        nsdf_block_gradient sums;
        s->passes->backward(&sl->batch, k, m->desc.degree, sl->at.terms[k], &sums);
        memcpy(sl->terms[k], sums.terms, sizeof sums.terms);
        pose_gradient(sl->at.map[k], radii[k], &sums, sl->poses[k]);
    }
}

/* Slot by slot, so that the sum does not depend on the threads. */
static int gather(state *s) {
    const nsdf_block_model *m = s->model;
    double near = 0.0;
    uint64_t near_count = 0;
    int failed = 0;
    memset(s->gradient, 0, m->value_count * sizeof *s->gradient);
    for (uint32_t i = 0; i < s->job->options->batch_frames; i++) {
        const slot *sl = &s->slots[i];
        failed |= sl->failed;
        for (uint32_t k = 0; k < m->desc.block_count; k++)
            nsdf_block_add_gradient(m, k, sl->terms[k], s->gradient);
        nsdf_block_scatter_poses(m, s->job->u[sl->frame], (const float(*)[12])sl->poses, s->bone_scratch, s->gradient);
        near += sl->sums.near_error;
        near_count += sl->sums.near_count;
    }
    const double mean = near_count ? near / (double)near_count : s->near_error;
    s->near_error = s->near_error > 0.0 ? 0.99 * s->near_error + 0.01 * mean : mean;
    return failed;
}

static int one_step(state *s, double schedule, int rounding) {
    nsdf_block_model *m = s->model;
    s->active = m->values;
    if (rounding) {
        nsdf_block_model_round(m, m->values, s->rounded);
        s->active = s->rounded; /* straight-through */
    }
    for (uint32_t i = 0; i < s->job->options->batch_frames; i++) {
        s->slots[i].frame = nsdf_frame_order_next(&s->order, &s->random);
        s->slots[i].first = nsdf_random_u32(&s->random);
    }
    nsdf_workers_run(s->job->workers, s->job->options->batch_frames, run_slot, s);
    if (gather(s) != 0)
        return -1;
    nsdf_block_add_rate(m, s->active, s->job->options->motion_rate, s->gradient);
    nsdf_adam_step(&s->terms, m->values + m->term_offset, s->gradient + m->term_offset, coefficient_rate * schedule);
    nsdf_adam_step(&s->poses, m->values + m->pose_offset, s->gradient + m->pose_offset, pose_rate * schedule);
    return 0;
}

/* ---- The loop -------------------------------------------------------------------------------------------- */

static int report(const state *s, double began, nsdf_fit_result *result) {
    const double now = nsdf_clock(), spent = now - began;
    const double fraction = fmin(1.0, (double)result->steps / (double)s->job->options->steps);
    nsdf_progress p = {NSDF_STAGE_FIT,
                       fraction,
                       now - s->job->start_time,
                       s->near_error,
                       spent > 0.0 ? (double)result->samples / spent : 0.0,
                       fraction > 0.0 ? spent * (1.0 - fraction) / fraction : -1.0};
    int answer = s->job->progress ? s->job->progress(s->job->progress_user, &p) : NSDF_CONTINUE;
    result->aborted = answer == NSDF_ABORT;
    return answer;
}

/* All steps.  Returns what progress answered, or -1 on failure. */
static int fit_steps(state *s, nsdf_fit_result *result) {
    const uint64_t steps = s->job->options->steps;
    const uint64_t rounding_from = (uint64_t)((1.0 - rounding_share) * (double)steps);
    const double began = nsdf_clock();
    double reported = began;
    while (result->steps < steps) {
        const double schedule = nsdf_rate_schedule(result->steps, steps, 1.0);
        if (one_step(s, schedule, result->steps >= rounding_from) != 0)
            return -1;
        result->steps++;
        for (uint32_t i = 0; i < s->job->options->batch_frames; i++)
            result->samples += s->slots[i].points;
        if (nsdf_clock() - reported < 0.1 && result->steps < steps)
            continue;
        reported = nsdf_clock();
        const int answer = report(s, began, result);
        if (answer != NSDF_CONTINUE)
            return answer;
    }
    return NSDF_CONTINUE;
}

int nsdf_block_fit_run(const nsdf_fit_job *job, nsdf_block_model *model, nsdf_fit_result *result) {
    state s;
    memset(result, 0, sizeof *result);
    int failed = create_state(&s, job, model);
    if (!failed)
        failed = fit_steps(&s, result) < 0;
    if (!failed) {
        nsdf_block_model_round(model, model->values, s.rounded);
        memcpy(model->values, s.rounded, model->value_count * sizeof *s.rounded);
        for (size_t i = 0; i < model->value_count; i++)
            result->diverged |= !isfinite(model->values[i]);
    }
    result->near_error = s.near_error;
    free_state(&s);
    return failed ? -1 : 0;
}

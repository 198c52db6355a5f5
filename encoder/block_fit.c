#include "block_fit.h"

#include "block_cache.h"
#include "block_pose.h"
#include "block_rate.h"
#include "block_rest.h"
#include "checkpoint.h"
#include "frame_order.h"
#include "optimiser.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rates for a full first step, normalised units; both follow the schedule of the network's fitting. */
static const double coefficient_rate = 1e-4, pose_rate = 2e-4, level_rate = 2e-5;
/* Loss weight 1/2 there; but 1 where the value is less than this share of the distance, or has the wrong sign: there
 * would soon be a surface. */
static const float weight_distance = 0.002f, safe_share = 0.25f;
static const double rounding_share = 0.3; /* of the steps, at the end, see rounded values */
static const double tuning_peak = 0.15;   /* of the rates, for a model that was fitted before */
enum {
    STEERED = 50,  /* so many times in all steps, but only while values are rounded */
    SAME_BATCH = 4 /* visits of a frame */
};
static const float least_denominator = 2e-9f;

/* Of batches that are kept between steps; sequences too long for it make theirs anew in every step. */
static const size_t most_cache_bytes = (size_t)512 << 20;

/* What a slot (one frame of a step) is, and what comes of it. */
typedef struct {
    uint32_t frame, batch;                 /* which of the frame's batches */
    int keep;                              /* no slot before it has the same frame */
    float (*terms)[NSDF_BLOCK_MOST_TERMS]; /* [block]: gradient, of monomials */
    float *bones;                          /* [bone][12]: gradient */
    float (*rest)[NSDF_REST_VALUES];       /* [block]: gradient, until values at rest settle */
    nsdf_block_loss_sums sums;
    int failed;
} slot;

/* What a worker needs for the slot that it is at. */
typedef struct {
    nsdf_block_frame at;
    nsdf_block_work work;
    nsdf_block_batch own;
    float (*monomials)[NSDF_BLOCK_MOST_TERMS]; /* [block]: at the slot's time */
    float (*poses)[12];                        /* [block]: gradient */
} workplace;

typedef struct {
    const nsdf_fit_job *job;
    nsdf_block_model *model;
    const nsdf_block_passes *passes;
    nsdf_random random;
    nsdf_frame_order order;
    nsdf_block_cache cache;
    slot *slots;       /* [batch_frames] */
    workplace *places; /* [worker] */
    nsdf_adam terms, levels, poses;
    nsdf_block_rest rest;
    float *gradient, *rounded;                 /* [value_count] */
    float (*monomials)[NSDF_BLOCK_MOST_TERMS]; /* [block]: without levels that move */
    const float *active;
    double near_error;
    double began; /* nsdf_clock(), had there been no break */
    nsdf_time_budget budget;
    nsdf_fit_result *result;
} state;

/* ---- Setting up ------------------------------------------------------------------------------------------ */

static void free_state(state *s) {
    for (uint32_t i = 0; s->slots && i < s->job->options->batch_frames; i++) {
        free(s->slots[i].terms);
        free(s->slots[i].bones);
        free(s->slots[i].rest);
    }
    for (uint32_t i = 0; s->places && i < nsdf_workers_count(s->job->workers); i++) {
        nsdf_block_frame_free(&s->places[i].at);
        nsdf_block_work_free(&s->places[i].work);
        nsdf_block_batch_free(&s->places[i].own);
        free(s->places[i].monomials);
        free(s->places[i].poses);
    }
    free(s->slots);
    free(s->places);
    nsdf_block_cache_free(&s->cache);
    nsdf_frame_order_free(&s->order);
    free(s->gradient);
    free(s->rounded);
    free(s->monomials);
    nsdf_adam_free(&s->terms);
    nsdf_adam_free(&s->levels);
    nsdf_adam_free(&s->poses);
    nsdf_block_rest_free(&s->rest);
}

static int create_slot(slot *sl, const nsdf_block_model *model) {
    sl->terms = malloc(sizeof *sl->terms * model->desc.block_count);
    sl->bones = malloc(sizeof *sl->bones * 12 * model->desc.bone_count);
    sl->rest = malloc(sizeof *sl->rest * model->desc.block_count);
    return sl->terms && sl->bones && sl->rest ? 0 : -1;
}

static int create_bench(workplace *b, const nsdf_fit_job *job, const nsdf_block_model *model) {
    const uint32_t blocks = model->desc.block_count, points = job->options->batch_points;
    b->poses = malloc(sizeof *b->poses * blocks);
    b->monomials = malloc(sizeof *b->monomials * blocks);
    return b->poses && b->monomials &&
                   nsdf_block_frame_create(&b->at, model, job->header->domain_min, job->header->domain_max) == 0 &&
                   nsdf_block_work_create(&b->work, points, blocks, &b->at) == 0 &&
                   nsdf_block_batch_create(&b->own, points, blocks, &b->at) == 0
               ? 0
               : -1;
}

static int create_state(state *s, const nsdf_fit_job *job, nsdf_block_model *model, nsdf_fit_result *result) {
    memset(s, 0, sizeof *s);
    s->job = job;
    s->model = model;
    s->result = result;
    s->began = nsdf_clock();
    nsdf_budget_start(&s->budget, job->deadline, job->options->steps);
    s->passes = nsdf_block_passes_select();
    s->random = nsdf_random_start(job->options->seed, 3);
    s->slots = calloc(job->options->batch_frames, sizeof *s->slots);
    s->places = calloc(nsdf_workers_count(job->workers), sizeof *s->places);
    s->gradient = calloc(model->value_count, sizeof(float));
    s->rounded = calloc(model->value_count, sizeof(float));
    s->monomials = calloc(model->desc.block_count, sizeof *s->monomials);
    int ok = nsdf_frame_order_create(&s->order, job->frame_count) == 0 && s->slots && s->places && s->gradient &&
             s->rounded && s->monomials && nsdf_adam_create(&s->terms, model->term_count) == 0 &&
             nsdf_adam_create(&s->levels, model->level_count) == 0 &&
             nsdf_adam_create(&s->poses, model->pose_count) == 0 &&
             nsdf_block_rest_create(&s->rest, model, job->control && job->control->tuning) == 0;
    for (uint32_t i = 0; ok && i < job->options->batch_frames; i++)
        ok = create_slot(&s->slots[i], model) == 0;
    for (uint32_t i = 0; ok && i < nsdf_workers_count(job->workers); i++)
        ok = create_bench(&s->places[i], job, model) == 0;
    ok = ok && nsdf_block_cache_create(&s->cache, job->samples, job->frame_count, job->options->batch_points,
                                       model->desc.block_count, &s->places[0].at, most_cache_bytes) == 0;
    s->terms.epsilon = s->levels.epsilon =
        least_denominator; /* coefficients that see no gradient stay where they are */
    return ok ? 0 : -1;
}

/* ---- One step -------------------------------------------------------------------------------------------- */

/* Gradients of all blocks at the points of a slot. */
static void find_gradients(const state *s, slot *sl, workplace *w) {
    const nsdf_block_model *m = s->model;
    const float *radii = m->values + nsdf_block_offset(&m->desc, NSDF_BLOCK_RADII);
    for (uint32_t k = 0; k < m->desc.block_count; k++) {
        nsdf_block_gradient sums;
        s->passes->backward(&w->work, k, m->desc.degree, w->monomials[k], &sums);
        memcpy(sl->terms[k], sums.terms, sizeof sums.terms);
        nsdf_block_pose_gradient(w->at.map[k], radii[k], (const float(*)[4])sums.moment, w->poses[k]);
        if (!s->rest.settled)
            nsdf_block_rest_gradient(m, &w->at, k, w->poses[k], &sums, sl->rest[k]);
    }
    nsdf_block_sum_bones(m, (const float(*)[12])w->poses, sl->bones);
}

static void run_slot(void *data, uint32_t index, uint32_t worker) {
    state *s = data;
    slot *sl = &s->slots[index];
    workplace *w = &s->places[worker];
    const nsdf_block_model *m = s->model;
    const float *radii = m->values + nsdf_block_offset(&m->desc, NSDF_BLOCK_RADII);
    const float scale = 1.0f / ((float)s->job->options->batch_points * (float)s->job->options->batch_frames);
    const nsdf_block_loss loss = {scale, weight_distance, safe_share, NSDF_NEAR_LIMIT};
    nsdf_block_frame_pose(&w->at, m, s->active, s->job->u[sl->frame]);
    memcpy(w->monomials, s->monomials, sizeof *s->monomials * m->desc.block_count);
    nsdf_block_add_levels(m, s->active, s->job->u[sl->frame], w->monomials);
    const nsdf_block_batch *b =
        nsdf_block_cache_take(&s->cache, sl->frame, sl->batch, sl->keep, &w->at, radii, s->passes, &w->work, &w->own);
    sl->failed = !b || nsdf_block_batch_forward(&w->work, b, s->passes, &w->at,
                                                (const float(*)[NSDF_BLOCK_MOST_TERMS])w->monomials,
                                                m->desc.block_count, m->desc.degree) != 0;
    if (sl->failed)
        return;
    sl->sums = s->passes->differentiate(&w->work, b, &loss);
    find_gradients(s, sl, w);
}

/* Slot by slot, so that the sum does not depend on the threads. */
static int gather(state *s) {
    const nsdf_block_model *m = s->model;
    const uint32_t slots = s->job->options->batch_frames;
    double near = 0.0;
    uint64_t near_count = 0;
    int failed = 0;
    memset(s->gradient, 0, m->value_count * sizeof *s->gradient);
    for (uint32_t k = 0; k < m->desc.block_count; k++) {
        float sum[NSDF_BLOCK_MOST_TERMS] = {0.0f};
        for (uint32_t i = 0; i < slots; i++)
            for (uint32_t t = 0; t < m->terms; t++)
                sum[t] += s->slots[i].terms[k][t];
        nsdf_block_add_gradient(m, k, sum, s->gradient);
        for (uint32_t i = 0; i < slots && !s->rest.settled; i++)
            nsdf_block_rest_add_gradient(m, k, s->slots[i].rest[k], s->gradient);
    }
    for (uint32_t i = 0; i < slots; i++) {
        const slot *sl = &s->slots[i];
        failed |= sl->failed;
        nsdf_block_scatter_bones(m, s->job->u[sl->frame], sl->bones, s->gradient);
        nsdf_block_scatter_levels(m, s->job->u[sl->frame], (const float(*)[NSDF_BLOCK_MOST_TERMS])sl->terms,
                                  s->gradient);
        near += sl->sums.near_error;
        near_count += sl->sums.near_count;
    }
    const double mean = near_count ? near / (double)near_count : s->near_error;
    s->near_error = s->near_error > 0.0 ? 0.99 * s->near_error + 0.01 * mean : mean;
    return failed;
}

/* One of a frame's batches, the same for a few visits of all frames: its candidates are then mostly those of the visit
 * before.  Not where a step visits frames more than once: it would see the same points again. */
static uint32_t choose_batch(const state *s, uint32_t slot_number, uint32_t frame) {
    const uint32_t slots = s->job->options->batch_frames, frames = s->job->frame_count;
    const uint64_t visit = s->result->steps * slots + slot_number;
    const uint64_t round = slots <= frames ? visit / frames / SAME_BATCH : visit;
    nsdf_random random = nsdf_random_start(s->job->options->seed + round, frame);
    return nsdf_random_u32(&random) % nsdf_block_cache_batches(&s->cache, frame);
}

/* Which frame and which of its batches each slot takes. */
static void choose_batches(state *s) {
    for (uint32_t i = 0; i < s->job->options->batch_frames; i++) {
        slot *sl = &s->slots[i];
        sl->frame = nsdf_frame_order_next(&s->order, &s->random);
        sl->batch = choose_batch(s, i, sl->frame);
        sl->keep = 1;
        for (uint32_t j = 0; j < i; j++)
            sl->keep &= s->slots[j].frame != sl->frame;
    }
}

/* rest_schedule counts until values at rest have settled, which is before others are rounded. */
static int one_step(state *s, double schedule, double rest_schedule, int rounding) {
    nsdf_block_model *m = s->model;
    s->active = m->values;
    if (rounding)
        nsdf_block_rest_settle(&s->rest, m);
    if (rounding) {
        nsdf_block_model_round(m, m->values, s->rounded);
        s->active = s->rounded; /* straight-through */
    }
    choose_batches(s);
    for (uint32_t k = 0; k < m->desc.block_count; k++)
        nsdf_block_get_monomials(m, s->active, k, s->monomials[k]);
    nsdf_workers_run(s->job->workers, s->job->options->batch_frames, run_slot, s);
    if (gather(s) != 0)
        return -1;
    nsdf_block_add_rate(m, s->active, s->job->options->motion_rate, s->gradient);
    nsdf_adam_step(&s->terms, m->values + m->term_offset, s->gradient + m->term_offset, coefficient_rate * schedule);
    if (m->level_count > 0)
        nsdf_adam_step(&s->levels, m->values + m->level_offset, s->gradient + m->level_offset, level_rate * schedule);
    nsdf_adam_step(&s->poses, m->values + m->pose_offset, s->gradient + m->pose_offset, pose_rate * schedule);
    if (!s->rest.settled)
        nsdf_block_rest_step(&s->rest, m, s->gradient, rest_schedule);
    return 0;
}

/* So that nothing jumps when values at rest settle. */
static double rest_share(uint64_t step, uint64_t settled_from) {
    const double f = settled_from > 0 ? (double)step / (double)settled_from : 1.0;
    return f < 1.0 ? 0.5 * (1.0 + cos(3.14159265358979 * f)) : 0.0;
}

/* ---- The loop -------------------------------------------------------------------------------------------- */

/* All that later steps depend on. */
static void state_fields(void *fitting, nsdf_fit_state *f) {
    state *s = fitting;
    nsdf_state_run(f, s->result, s->job->options->steps, &s->began, &s->near_error);
    nsdf_state_random(f, &s->random);
    nsdf_state_order(f, &s->order);
    nsdf_state_floats(f, s->model->values, s->model->value_count);
    nsdf_state_adam(f, &s->terms);
    nsdf_state_adam(f, &s->levels);
    nsdf_state_adam(f, &s->poses);
    nsdf_block_rest_fields(&s->rest, f);
    nsdf_block_model_set_influences(s->model);
}

static int report(const state *s, nsdf_fit_result *result) {
    const double now = nsdf_clock(), spent = now - s->began;
    const double fraction = fmin(1.0, (double)result->steps / (double)s->budget.steps);
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

static int save(state *s) {
    return nsdf_checkpoint_save(s->job->checkpoint, s->result->steps, state_fields, s);
}

/* All steps that are left.  Returns what progress answered, or -1 on failure. */
static int fit_steps(state *s, nsdf_fit_result *result) {
    const nsdf_fit_control *control = s->job->control;
    const int tuning = control && control->tuning;
    double reported = nsdf_clock();
    while (result->steps < s->budget.steps) {
        const uint64_t steps = nsdf_budget_plan(&s->budget, result->steps, nsdf_clock());
        const uint64_t rounding_from = tuning ? 0 : (uint64_t)((1.0 - rounding_share) * (double)steps);
        const uint64_t every = 1 + steps / STEERED;
        const double schedule = nsdf_rate_schedule(result->steps, steps, tuning ? tuning_peak : 1.0);
        const double rest_schedule = schedule * rest_share(result->steps, rounding_from);
        if (one_step(s, schedule, rest_schedule, result->steps >= rounding_from) != 0)
            return -1;
        result->steps++;
        for (uint32_t i = 0; i < s->job->options->batch_frames; i++)
            result->samples += s->slots[i].sums.count;
        if (control && control->steer && result->steps > rounding_from && result->steps % every == 0)
            control->steer(control->user, result->steps, steps);
        if (nsdf_checkpoint_due(s->job->checkpoint, result->steps == steps) && save(s) != 0)
            return -1;
        if (nsdf_clock() - reported < 0.1 && result->steps < steps)
            continue;
        reported = nsdf_clock();
        const int answer = report(s, result);
        if (answer != NSDF_CONTINUE)
            return save(s) != 0 ? -1 : answer;
    }
    return NSDF_CONTINUE;
}

int nsdf_block_fit_run(const nsdf_fit_job *job, nsdf_block_model *model, nsdf_fit_result *result) {
    state s;
    memset(result, 0, sizeof *result);
    int failed = create_state(&s, job, model, result);
    if (!failed)
        failed = nsdf_checkpoint_begin(job->checkpoint, job, model->values, model->value_count, state_fields, &s);
    if (!failed)
        failed = fit_steps(&s, result) < 0;
    if (!failed)
        nsdf_block_rest_settle(&s.rest, model); /* nothing to do unless fitting was stopped early */
    if (!failed && !job->control) {
        nsdf_block_model_round(model, model->values, s.rounded);
        memcpy(model->values, s.rounded, model->value_count * sizeof *s.rounded);
    }
    for (size_t i = 0; !failed && i < model->value_count; i++)
        result->diverged |= !isfinite(model->values[i]);
    result->near_error = s.near_error;
    free_state(&s);
    return failed ? -1 : 0;
}

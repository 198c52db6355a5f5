#include "rate_model.h"

#include "block_lives.h"
#include "block_mend.h"
#include "rate_control.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double rate_share = 1.5;
static const double margin_blocks = 1.2; /* nodes for more blocks than expected */
static const double most_share = 0.25;   /* of the options' steps, in a probe or a tuning that would have too few */

nsdf_status nsdf_rate_no_memory(const nsdf_rate_model *m) {
    return nsdf_encoder_fail(m->error, NSDF_NO_MEMORY, "out of memory while fitting");
}

int nsdf_rate_model_init(nsdf_rate_model *m, const nsdf_rate_job *job) {
    memset(m, 0, sizeof *m);
    m->job = *job;
    m->base = nsdf_block_options(job->fit.options, job->fit.frame_count);
    m->strays = calloc(job->fit.frame_count, sizeof *m->strays);
    return m->strays ? 0 : -1;
}

static void forget_tracked(nsdf_rate_model *m) {
    if (m->tracked_blocks)
        nsdf_nodes_free(&m->tracked.nodes);
    m->tracked_blocks = 0;
}

void nsdf_rate_model_free(nsdf_rate_model *m) {
    forget_tracked(m);
    for (uint32_t f = 0; m->strays && f < m->job.fit.frame_count; f++)
        nsdf_sample_set_free(&m->strays[f]);
    free(m->strays);
}

void nsdf_rate_take_strays(nsdf_rate_model *m, nsdf_sample_set *strays) {
    for (uint32_t f = 0; f < m->job.fit.frame_count; f++)
        if (strays[f].count > 0) {
            nsdf_sample_set_free(&m->strays[f]);
            m->strays[f] = strays[f];
            strays[f] = (nsdf_sample_set){0};
        }
}

/* ---- Bytes and errors ------------------------------------------------------------------------------------- */

int nsdf_rate_count_bytes(nsdf_rate_model *m) {
    nsdf_coded_segment segment = {{NULL, 0, 0, 0}, 0};
    nsdf_buffer file = {NULL, 0, 0, 0};
    const int failed = nsdf_code_blocks(m->blocks, &segment) != 0 || nsdf_rate_make_file(&m->job, &segment, &file) != 0;
    m->now.bytes = file.size;
    nsdf_buffer_free(&segment.payload);
    nsdf_buffer_free(&file);
    return failed ? -1 : 0;
}

static nsdf_status measure_error(nsdf_rate_model *m) {
    nsdf_coded_segment segment = {{NULL, 0, 0, 0}, 0};
    nsdf_quick_error quick = {0.0, 0.0, 0};
    nsdf_status status = nsdf_code_blocks(m->blocks, &segment) == 0 ? NSDF_OK : nsdf_rate_no_memory(m);
    if (status == NSDF_OK)
        status = nsdf_rate_quick_error(&m->job, &segment, &quick, m->error);
    nsdf_buffer_free(&segment.payload);
    m->now.quick = quick.mean;
    m->now.back_by_decoded = quick.back_by_decoded;
    m->now.bytes = quick.bytes;
    return status;
}

void nsdf_rate_set_x(nsdf_rate_model *m, double x) {
    const double f = exp(x);
    m->now.x = x;
    m->now.options.pose_step = fmax(1e-7, fmin(0.1, m->now.level_o.pose_step * f));
    m->now.options.coefficient_step = fmax(1e-7, fmin(0.1, m->now.level_o.coefficient_step * f));
    m->now.options.motion_rate = fmin(1.0, m->now.level_o.motion_rate * exp(rate_share * x));
    if (m->blocks->values) {
        const nsdf_block_steps steps = {m->now.options.pose_step, m->now.options.coefficient_step};
        nsdf_block_model_set_steps(m->blocks, &steps);
    }
}

void nsdf_rate_note_model(const nsdf_rate_model *m, nsdf_rate_kind kind, uint64_t steps, double error) {
    const nsdf_rate_round round = {kind,
                                   m->blocks->desc.block_count,
                                   m->blocks->desc.bone_count,
                                   0,
                                   steps,
                                   m->now.options.pose_step,
                                   m->now.options.coefficient_step,
                                   m->now.options.motion_rate,
                                   0.0,
                                   m->now.bytes,
                                   error};
    nsdf_rate_note(&m->job, &round);
}

/* ---- Fitting ---------------------------------------------------------------------------------------------- */

static nsdf_fit_job job_of(const nsdf_rate_model *m) {
    nsdf_fit_job job = m->job.fit;
    job.options = &m->now.options;
    job.control = &m->control;
    return job;
}

nsdf_status nsdf_rate_track(nsdf_rate_model *m, uint32_t blocks) {
    if (blocks <= m->tracked_blocks)
        return NSDF_OK;
    nsdf_encoder_options o = m->base;
    nsdf_fit_job job = m->job.fit;
    forget_tracked(m);
    o.blocks = (uint32_t)fmin(margin_blocks * blocks, NSDF_MAX_BLOCKS);
    job.options = &o;
    if (nsdf_track_surface(&job, &m->tracked) != 0)
        return nsdf_rate_no_memory(m);
    m->tracked_blocks = o.blocks;
    return NSDF_OK;
}

double nsdf_rate_within_levels(const nsdf_rate_model *m, double level) {
    const double most = m->job.size ? nsdf_rate_highest_level : nsdf_rate_highest_for_error;
    return fmax(nsdf_rate_lowest_level, fmin(most, level));
}

nsdf_status nsdf_rate_start_at(nsdf_rate_model *m, double level) {
    m->now.level = nsdf_rate_within_levels(m, level);
    m->now.level_o = nsdf_rate_options_at(&m->base, m->now.level);
    m->now.options = m->now.level_o;
    nsdf_block_model_free(m->blocks);
    nsdf_rate_set_x(m, 0.0);
    nsdf_status status = nsdf_rate_track(m, m->now.options.blocks);
    if (status != NSDF_OK)
        return status;
    const nsdf_fit_job job = job_of(m);
    return nsdf_start_blocks(&job, &m->tracked, m->blocks) == 0 ? NSDF_OK : nsdf_rate_no_memory(m);
}

static int trim_lives(const nsdf_rate_model *m) {
    const nsdf_fit_job *job = &m->job.fit;
    return m->control.tuning ? 0 : nsdf_block_trim_lives(m->blocks, job->frames, job->u, job->header, job->workers);
}

/* A step moves a value only so far: a share of few steps would say little of a level, or tune little. */
static uint64_t steps_of(const nsdf_rate_model *m, nsdf_rate_kind kind, double share) {
    const double all = (double)m->base.steps, fewest = kind == NSDF_RATE_PROBE ? 1000.0 : 500.0;
    const double steps = kind == NSDF_RATE_FIT ? share * all : fmax(share * all, fmin(fewest, most_share * all));
    return (uint64_t)fmax(1.0, rint(steps));
}

static nsdf_status fit_some(nsdf_rate_model *m, uint64_t steps) {
    nsdf_fit_result some;
    m->now.options.steps = steps;
    m->now.options.seed = m->base.seed + m->tunes;
    const nsdf_fit_job job = job_of(m);
    if (nsdf_fit_mended(&job, m->strays, m->blocks, &some) != 0 || trim_lives(m) != 0)
        return nsdf_rate_no_memory(m);
    m->stopped |= some.steps < m->now.options.steps;
    some.steps += m->result->steps;
    some.samples += m->result->samples;
    *m->result = some;
    m->now.steps = some.steps;
    return some.aborted || some.diverged ? NSDF_CANCELLED : NSDF_OK;
}

nsdf_status nsdf_rate_fit_and_measure(nsdf_rate_model *m, nsdf_rate_kind kind, double share) {
    const uint64_t before = m->result->steps;
    const nsdf_fit_control given = m->control;
    m->control.tuning = kind == NSDF_RATE_TUNE;
    m->tunes += kind == NSDF_RATE_TUNE;
    if (kind != NSDF_RATE_FIT)
        m->control.steer = NULL;
    nsdf_status status = fit_some(m, steps_of(m, kind, share));
    m->control = given;
    if (status == NSDF_OK && m->job.size)
        status = nsdf_rate_count_bytes(m) == 0 ? NSDF_OK : nsdf_rate_no_memory(m);
    else if (status == NSDF_OK)
        status = measure_error(m);
    if (status == NSDF_OK)
        nsdf_rate_note_model(m, kind, m->result->steps - before, m->now.quick);
    return status;
}

/* ---- Copies ----------------------------------------------------------------------------------------------- */

void nsdf_rate_copy_free(nsdf_rate_copy *copy) {
    nsdf_block_model_free(&copy->blocks);
    memset(copy, 0, sizeof *copy);
}

int nsdf_rate_copy_model(nsdf_rate_copy *copy, const nsdf_rate_model *m) {
    nsdf_rate_copy_free(copy);
    copy->state = m->now;
    return nsdf_block_model_copy(&copy->blocks, m->blocks);
}

void nsdf_rate_take_copy(nsdf_rate_model *m, nsdf_rate_copy *copy) {
    nsdf_block_model_free(m->blocks);
    *m->blocks = copy->blocks;
    m->now = copy->state;
    memset(copy, 0, sizeof *copy);
}

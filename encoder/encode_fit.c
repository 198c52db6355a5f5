#include "encode_run.h"

#include "bound.h"
#include "check_time.h"

#include <math.h>

/* Within a time that was asked for, verification takes about this part of it, and looks at so many frames at least. */
static const double verified_share = 0.12;
enum { least_frames = 12 };
static const double more_rounds = 1.3; /* of raising the bound, for some frames in place of a few */

/* When fitting should end for the run to take its time.  What follows it takes 1.3 times as long as sampling did, of
 * networks twice as long, without verification less. */
static double fit_deadline(const nsdf_run *r) {
    const nsdf_encoder *e = r->encoder;
    const double reserve = (!e->options.verify ? 0.7 : nsdf_run_uses_blocks(r) ? 1.3 : 2.0) * e->stats.seconds_sample;
    return e->options.time_budget > 0.0 ? r->start + e->options.time_budget - reserve : 0.0;
}

nsdf_fit_job nsdf_run_fit_job(nsdf_run *r) {
    nsdf_encoder *e = r->encoder;
    nsdf_fit_job job = {.model = &e->model,
                        .options = &e->options,
                        .samples = r->dataset.sets,
                        .u = r->dataset.u,
                        .frame_count = r->dataset.frame_count,
                        .frames = &e->frames,
                        .header = &e->header,
                        .workers = r->workers,
                        .progress = r->progress,
                        .progress_user = r->user,
                        .start_time = r->start,
                        .deadline = fit_deadline(r),
                        .tracked = r->is_tracked ? &r->tracked : NULL};
    return job;
}

/* Whether fitting, or more of it, came to a usable end. */
nsdf_status nsdf_run_fitted(nsdf_run *r, int failed) {
    nsdf_encoder_stats *stats = &r->encoder->stats;
    if (failed && r->encoder->checkpoint.refusal)
        return nsdf_encoder_fail(r->error, NSDF_CORRUPT, "the checkpoint does not fit: %s",
                                 r->encoder->checkpoint.refusal);
    if (failed)
        return nsdf_encoder_fail(r->error, NSDF_NO_MEMORY, "out of memory while fitting");
    stats->steps = r->fit.steps;
    stats->samples = r->fit.samples;
    stats->fit_error = r->fit.near_error;
    if (r->fit.aborted)
        return nsdf_encoder_fail(r->error, NSDF_CANCELLED, "cancelled");
    if (r->fit.diverged)
        return nsdf_encoder_fail(r->error, NSDF_INTERNAL,
                                 "fitting diverged after %llu steps: try a lower learning rate",
                                 (unsigned long long)r->fit.steps);
    return NSDF_OK;
}

static nsdf_status fit_to_target(nsdf_run *r) {
    nsdf_encoder *e = r->encoder;
    nsdf_rate_job job = {nsdf_run_fit_job(r), r->size, &e->shown, e->entry, &e->stats};
    nsdf_status status = NSDF_NO_MEMORY;
    job.entry.smallest_piece = nsdf_run_smallest_piece(r);
    if (nsdf_run_uses_blocks(r))
        r->rate_blocks = nsdf_rate_blocks_create(&job);
    else
        r->rate_network = nsdf_rate_network_create(&job, &r->dataset, &e->parameters);
    if (r->rate_blocks)
        status = nsdf_rate_blocks_fit(r->rate_blocks, &e->blocks, &r->fit, r->error);
    else if (r->rate_network)
        status = nsdf_rate_network_fit(r->rate_network, &r->fit, r->error);
    else
        return nsdf_encoder_fail(r->error, NSDF_NO_MEMORY, "out of memory");
    return status == NSDF_OK ? nsdf_run_fitted(r, 0) : status;
}

/* When fitting a network should end, once it has a surface to time the check of.  Verification gets a part of the time
 * only: where it would need more, some of the frames stand for all. */
static double deadline_by_trial(void *user) {
    nsdf_run *r = user;
    nsdf_encoder *e = r->encoder;
    const nsdf_check_job job = {&e->shown, &e->header, &e->options, NULL, NULL, r->start, &e->frames};
    const nsdf_quantise_params quantise = {e->options.weight_bits, 1};
    const double budget = e->options.time_budget;
    const uint32_t frames = e->shown.count;
    nsdf_encoder_error ignored; /* what fails here will fail again, and then be told */
    nsdf_check_time seconds = {0.0, 0.0};
    nsdf_choose_quantisers(&e->model, &quantise, e->parameters);
    if (nsdf_run_code(r) != NSDF_OK ||
        nsdf_time_check(&job, r->workers, &r->segment, &e->entry, &seconds, &ignored) != NSDF_OK)
        return fit_deadline(r);
    const double room = fmax(verified_share * budget / fmax(seconds.verify, 1e-9), (double)least_frames);
    r->verified = room < (double)frames ? (uint32_t)room : frames;
    return r->start + budget - more_rounds * seconds.bound * nsdf_bound_work(&job) - seconds.verify * r->verified;
}

/* checkpoint: NULL for none. */
nsdf_status nsdf_run_fit(nsdf_run *r, nsdf_checkpoint *checkpoint) {
    if (nsdf_run_has_target(r))
        return fit_to_target(r);
    nsdf_fit_job job = nsdf_run_fit_job(r);
    job.checkpoint = checkpoint;
    if (nsdf_run_uses_blocks(r))
        return nsdf_run_fitted(r, nsdf_fit_blocks(&job, &r->encoder->blocks, &r->fit));
    job.try_rest = deadline_by_trial;
    job.try_user = r;
    nsdf_random random = nsdf_random_start(r->encoder->options.seed, 1);
    nsdf_model_initialise(&r->encoder->model, &random, r->encoder->parameters);
    return nsdf_run_fitted(r, nsdf_fit_run(&job, r->encoder->parameters, &r->fit));
}

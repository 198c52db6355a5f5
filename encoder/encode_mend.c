#include "encode_run.h"

#include "block_mend.h"
#include "bound.h"
#include "rate_control.h"

#include <stdlib.h>
#include <string.h>

/* Of a file whose surface is lost in some frames; an empty frame has 1. */
static const double lost_error = 0.02;

/* While verification finds stray pieces, fitting goes on a little, so many times at the most. */
enum { MEND_ROUNDS = 3 };
/* As a factor: no worse; and what it may cost to halve the number of stray pieces. */
static const double same_error = 1.01, about_same_error = 1.03;

static int mend_blocks(nsdf_run *r) {
    const nsdf_fit_control control = {1, NULL, NULL};
    nsdf_encoder_options o = nsdf_block_options(&r->encoder->options, r->encoder->frames.count);
    nsdf_fit_result some;
    nsdf_fit_job job = nsdf_run_fit_job(r);
    o.steps = 1 + (uint64_t)(NSDF_MEND_SHARE * (double)o.steps);
    job.options = &o;
    job.control = &control;
    if (nsdf_fit_mended(&job, r->strays, &r->encoder->blocks, &some) != 0)
        return -1;
    some.steps += r->fit.steps;
    some.samples += r->fit.samples;
    r->fit = some;
    return 0;
}

static int mend_network(nsdf_run *r) {
    const nsdf_fit_job job = nsdf_run_fit_job(r);
    return nsdf_fit_mend(&job, r->strays, r->encoder->parameters, &r->fit);
}

/* Fits a little more where verification found stray pieces, and checks again. */
static nsdf_status mend(nsdf_run *r) {
    const double began = nsdf_clock();
    nsdf_status status = nsdf_run_fitted(r, r->encoder->blocks.values ? mend_blocks(r) : mend_network(r));
    if (status == NSDF_OK && r->rate_network)
        status = nsdf_rate_network_requantise(r->rate_network, r->error);
    r->encoder->stats.seconds_fit += nsdf_clock() - began;
    nsdf_run_forget_strays(r);
    return status == NSDF_OK ? nsdf_run_code_and_check(r) : status;
}

/* Whether the time that was asked for, if any, has room for a round of mending: most of one is coding and checking. */
static int has_time(const nsdf_run *r) {
    const double budget = r->encoder->options.time_budget;
    return !(budget > 0.0) || nsdf_clock() + r->seconds_check < r->start + budget;
}

/* More than a stray piece a frame says that a network is too small or fitted too briefly, which mending cannot mend.
 * Small models of blocks have some that it does. */
static int worth_mending(const nsdf_run *r) {
    const nsdf_encoder *e = r->encoder;
    const nsdf_quality *q = &e->stats.quality;
    const uint32_t pieces = e->stats.stray_pieces, a_frame = e->blocks.values ? 4 : 1;
    if (!e->options.hard_samples || !e->options.verify || pieces > a_frame * e->frames.count + 8 || !has_time(r))
        return 0;
    if (!e->blocks.values)
        return pieces > 0;
    return !nsdf_run_has_target(r) && (pieces > 0 || q->mean_to_input > NSDF_ASTRAY * q->mean_to_decoded);
}

/* The encoder with its model and the file, while something else is tried in their place. */
static nsdf_encoder set_aside(nsdf_encoder *e) {
    const nsdf_encoder kept = *e;
    memset(&e->file, 0, sizeof e->file);
    memset(&e->blocks, 0, sizeof e->blocks);
    e->parameters = NULL;
    return kept;
}

/* But the time that it took has passed. */
static void take_back(nsdf_encoder *e, const nsdf_encoder *kept) {
    const nsdf_encoder_stats tried = e->stats;
    nsdf_buffer_free(&e->file);
    nsdf_block_model_free(&e->blocks);
    free(e->parameters);
    *e = *kept;
    e->stats.seconds_sample = tried.seconds_sample;
    e->stats.seconds_fit = tried.seconds_fit;
    e->stats.seconds_code = tried.seconds_code;
    e->stats.seconds_verify = tried.seconds_verify;
}

/* Less of an error, or about the same and fewer pieces astray, which are more easily seen than they are measured. */
static int is_better(const nsdf_encoder_stats *tried, const nsdf_encoder_stats *kept) {
    const double error = nsdf_mean_error(&tried->quality), before = nsdf_mean_error(&kept->quality);
    const double limit = 2 * tried->stray_pieces <= kept->stray_pieces ? about_same_error : same_error;
    return error < before || (tried->stray_pieces < kept->stray_pieces && error < limit * before);
}

/* Whether what was tried succeeded and is better; if not, the encoder is as it was. */
static int keep_better(nsdf_run *r, nsdf_encoder *kept, nsdf_status status) {
    nsdf_encoder *e = r->encoder;
    if (status == NSDF_OK && is_better(&e->stats, &kept->stats)) {
        nsdf_buffer_free(&kept->file);
        nsdf_block_model_free(&kept->blocks);
        free(kept->parameters);
        return 1;
    }
    take_back(e, kept);
    nsdf_run_forget_strays(r);
    return 0;
}

/* A copy of the model that was set aside, to be mended: a network's parameters, or blocks. */
static int copy_model(nsdf_encoder *e, const nsdf_encoder *kept) {
    const size_t size = kept->model.parameter_count * sizeof *kept->parameters;
    if (kept->blocks.values)
        return nsdf_block_model_copy(&e->blocks, &kept->blocks);
    e->parameters = malloc(size);
    if (!e->parameters)
        return -1;
    memcpy(e->parameters, kept->parameters, size);
    return 0;
}

/* With a target, rate control judges. */
static nsdf_status mend_better(nsdf_run *r, int *better) {
    nsdf_encoder *e = r->encoder;
    *better = 1;
    if (nsdf_run_has_target(r))
        return mend(r);
    nsdf_encoder kept = set_aside(e);
    const nsdf_status status =
        copy_model(e, &kept) == 0 ? mend(r) : nsdf_encoder_fail(r->error, NSDF_NO_MEMORY, "out of memory");
    *better = keep_better(r, &kept, status);
    return status;
}

/* Blocks that come apart leave pieces astray in most frames, or whole frames without a surface. */
static int come_apart(const nsdf_encoder *e) {
    return e->blocks.values &&
           (e->stats.stray_pieces > e->shown.count || nsdf_mean_error(&e->stats.quality) > lost_error);
}

/* Where blocks come apart, a network will be tried in the end: unless the first round halves the pieces, no other one
 * is made. */
nsdf_status nsdf_run_mend(nsdf_run *r, int whole) {
    const nsdf_encoder *e = r->encoder;
    const uint32_t pieces = e->stats.stray_pieces;
    nsdf_status status = NSDF_OK;
    int better = whole;
    for (int round = 0; status == NSDF_OK && better && worth_mending(r) && round < MEND_ROUNDS; round++) {
        status = mend_better(r, &better);
        better &= round > 0 || !come_apart(e) || 2 * e->stats.stray_pieces <= pieces;
    }
    return status;
}

static nsdf_status fit_network_instead(nsdf_run *r) {
    nsdf_encoder *e = r->encoder;
    double began = nsdf_clock();
    e->options.blocks = 0;
    e->measured = 0;
    e->header.extraction_bound = (float)NSDF_HIGHEST_BOUND; /* until it is measured */
    nsdf_run_forget_strays(r);
    nsdf_dataset_free(&r->dataset);
    nsdf_status status = nsdf_run_sample(r);
    e->stats.seconds_sample += nsdf_clock() - began;
    began = nsdf_clock();
    if (status == NSDF_OK)
        status = nsdf_run_fit(r, NULL);
    e->stats.seconds_fit += nsdf_clock() - began;
    const int whole = r->fit.steps >= e->options.steps;
    if (status == NSDF_OK)
        status = nsdf_run_code_and_check(r);
    return status == NSDF_OK ? nsdf_run_mend(r, whole) : status;
}

/* Where blocks come apart, as they do where drops fly off and fall back, a network is fitted too, and the better of the
 * two is the result. */
nsdf_status nsdf_run_try_network(nsdf_run *r, int whole) {
    nsdf_encoder *e = r->encoder;
    if (!whole || nsdf_run_has_target(r) || !e->options.verify || !come_apart(e))
        return NSDF_OK;
    nsdf_encoder kept = set_aside(e);
    e->parameters = malloc(e->model.parameter_count * sizeof *e->parameters);
    const nsdf_status status =
        e->parameters ? fit_network_instead(r) : nsdf_encoder_fail(r->error, NSDF_NO_MEMORY, "out of memory");
    if (keep_better(r, &kept, status))
        e->stats.came_apart = 1;
    return status;
}

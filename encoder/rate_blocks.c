#include "rate_blocks.h"

#include "block_mend.h"
#include "rate_error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the options' steps. */
static const double probe_share = 0.1;
/* Another probe where the level is to be further from those that were probed. */
static const double near_level = 0.6;
static const double size_aim = 0.99;
enum { MOST_PROBES = 3, MOST_MENDS = 2 };

struct nsdf_rate_blocks {
    nsdf_rate_model m;
    nsdf_rate_measure measure; /* of the last probe, or a guess */
    nsdf_rate_curve probed;    /* only which levels were */
    nsdf_error_search search;
    /* With a size: the model with the least verified error, how often pieces astray were mended since, and whether that
     * has ended. */
    nsdf_rate_copy best;
    double best_error;
    uint32_t mends;
    int finished;
};

nsdf_rate_blocks *nsdf_rate_blocks_create(const nsdf_rate_job *job) {
    nsdf_rate_blocks *r = calloc(1, sizeof *r);
    if (!r)
        return NULL;
    if (nsdf_rate_model_init(&r->m, job) != 0) {
        free(r);
        return NULL;
    }
    nsdf_error_search_init(&r->search, &r->m);
    return r;
}

void nsdf_rate_blocks_free(nsdf_rate_blocks *r) {
    if (!r)
        return;
    nsdf_error_search_free(&r->search);
    nsdf_rate_copy_free(&r->best);
    nsdf_rate_model_free(&r->m);
    free(r);
}

static void lend(nsdf_rate_blocks *r, nsdf_block_model *model, nsdf_fit_result *result, nsdf_encoder_error *error) {
    r->m.blocks = model;
    r->m.result = result;
    r->m.error = error;
}

/* ---- Probes ----------------------------------------------------------------------------------------------- */

static nsdf_status learn(nsdf_rate_blocks *r) {
    const nsdf_rate_model *model = &r->m;
    nsdf_block_bytes b;
    if (nsdf_weigh_blocks(model->blocks, &b) != 0)
        return nsdf_rate_no_memory(model);
    const nsdf_rate_measure m = {model->blocks->desc.block_count,
                                 model->blocks->desc.bone_count,
                                 model->blocks->knots,
                                 model->now.options.pose_step,
                                 model->now.options.coefficient_step,
                                 (double)model->now.bytes - (double)b.shapes - (double)b.motion,
                                 (double)b.shapes,
                                 (double)b.motion};
    r->measure = m;
    return NSDF_OK;
}

static double level_of_size(const nsdf_rate_blocks *r) {
    return nsdf_rate_level_for(&r->measure, &r->m.base, size_aim * (double)r->m.job.size);
}

static double first_level(const nsdf_rate_blocks *r) {
    return r->m.job.size ? level_of_size(r) : nsdf_rate_error_level(&r->m.base, r->m.base.target_error);
}

static nsdf_status probe_at(nsdf_rate_blocks *r, double *level) {
    nsdf_status status = nsdf_rate_start_at(&r->m, *level);
    if (status == NSDF_OK)
        status = nsdf_rate_fit_and_measure(&r->m, NSDF_RATE_PROBE, probe_share);
    if (status == NSDF_OK && r->m.job.size)
        status = learn(r);
    if (status != NSDF_OK)
        return status;
    if (!r->m.job.size)
        nsdf_error_search_probed(&r->search);
    nsdf_rate_curve_add(&r->probed, r->m.now.level, 1.0);
    *level = nsdf_rate_within_levels(&r->m, r->m.job.size ? level_of_size(r) : nsdf_error_search_level(&r->search));
    return NSDF_OK;
}

/* Until the level that they ask for is near one of theirs. */
static nsdf_status probe(nsdf_rate_blocks *r, double *level) {
    nsdf_status status = NSDF_OK;
    for (int i = 0; i < MOST_PROBES && status == NSDF_OK && !r->m.stopped; i++)
        if (nsdf_rate_curve_distance(&r->probed, *level) >= near_level)
            status = probe_at(r, level);
    return status;
}

/* ---- Size ------------------------------------------------------------------------------------------------- */

/* Whether the coarsest model is small enough. */
static nsdf_status check_least(nsdf_rate_blocks *r) {
    nsdf_status status = nsdf_rate_start_at(&r->m, nsdf_rate_lowest_level);
    if (status != NSDF_OK)
        return status;
    nsdf_rate_set_x(&r->m, NSDF_RATE_MOST_X);
    if (nsdf_rate_count_bytes(&r->m) != 0)
        return nsdf_rate_no_memory(&r->m);
    if (r->m.now.bytes > r->m.job.size)
        return nsdf_encoder_fail(r->m.error, NSDF_LIMIT,
                                 "%llu bytes are too few: the least that this sequence takes are %llu",
                                 (unsigned long long)r->m.job.size, (unsigned long long)r->m.now.bytes);
    return NSDF_OK;
}

static void steer(void *user, uint64_t done, uint64_t steps) {
    nsdf_rate_model *m = user;
    (void)done;
    (void)steps;
    if (nsdf_rate_count_bytes(m) == 0)
        nsdf_rate_set_x(m, nsdf_rate_steer(m->now.x, m->now.bytes, (uint64_t)(size_aim * (double)m->job.size)));
}

static int bytes_at(void *user, double x, uint64_t *bytes) {
    nsdf_rate_model *m = user;
    nsdf_rate_set_x(m, x);
    const int failed = nsdf_rate_count_bytes(m);
    *bytes = m->now.bytes;
    return failed;
}

/* The last percent, by quantisers alone. */
static nsdf_status fill(nsdf_rate_model *m) {
    const nsdf_rate_search search = {bytes_at, m, m->job.size, m->now.x - 8.0, m->now.x + 8.0};
    double x = m->now.x;
    uint64_t bytes = 0;
    const int answer = nsdf_rate_find(&search, &x, &bytes);
    if (answer < 0)
        return nsdf_rate_no_memory(m);
    if (answer > 0)
        return nsdf_encoder_fail(m->error, NSDF_LIMIT, "%llu bytes are too few: the smallest file has %llu",
                                 (unsigned long long)m->job.size, (unsigned long long)bytes);
    if (bytes_at(m, x, &bytes) != 0)
        return nsdf_rate_no_memory(m);
    nsdf_rate_note_model(m, NSDF_RATE_QUANTISE, 0, 0.0);
    return NSDF_OK;
}

static nsdf_status fit_size(nsdf_rate_blocks *r, double level) {
    const nsdf_fit_control steered = {0, steer, &r->m};
    r->m.control = steered;
    nsdf_status status = NSDF_OK;
    if (!r->m.stopped)
        status = nsdf_rate_start_at(&r->m, level);
    if (status == NSDF_OK && !r->m.stopped)
        status = nsdf_rate_fit_and_measure(&r->m, NSDF_RATE_FIT, NSDF_RATE_FIT_SHARE);
    return status == NSDF_OK ? fill(&r->m) : status;
}

/* Fits on with the samples of pieces astray, and into the size again. */
static nsdf_status mend_size(nsdf_rate_blocks *r) {
    nsdf_status status = nsdf_rate_copy_model(&r->best, &r->m) == 0 ? NSDF_OK : nsdf_rate_no_memory(&r->m);
    r->mends++;
    if (status == NSDF_OK)
        status = nsdf_rate_fit_and_measure(&r->m, NSDF_RATE_TUNE, NSDF_MEND_SHARE);
    return status == NSDF_OK ? fill(&r->m) : status;
}

/* While surface is astray in verification and mending makes the file better; what made it no better is taken back. */
static nsdf_status judge_size(nsdf_rate_blocks *r, const nsdf_quality *quality, int *again) {
    const double mean = nsdf_mean_error(quality);
    if (r->finished || !r->m.base.verify)
        return NSDF_OK;
    nsdf_rate_note_model(&r->m, NSDF_RATE_VERIFY, 0, mean);
    r->finished =
        r->m.stopped || r->mends == MOST_MENDS || quality->mean_to_input <= NSDF_ASTRAY * quality->mean_to_decoded;
    if (r->mends > 0 && mean >= r->best_error) {
        r->finished = *again = 1;
        nsdf_rate_take_copy(&r->m, &r->best);
        return NSDF_OK;
    }
    r->best_error = mean;
    *again = !r->finished;
    return r->finished ? NSDF_OK : mend_size(r);
}

/* ---- The whole -------------------------------------------------------------------------------------------- */

nsdf_status nsdf_rate_blocks_fit(nsdf_rate_blocks *r, nsdf_block_model *model, nsdf_fit_result *result,
                                 nsdf_encoder_error *error) {
    lend(r, model, result, error);
    memset(result, 0, sizeof *result);
    r->measure = nsdf_rate_first_guess(&r->m.base, r->m.job.fit.frame_count);
    double level = first_level(r);
    nsdf_status status = nsdf_rate_track(&r->m, nsdf_rate_options_at(&r->m.base, level).blocks);
    if (status == NSDF_OK && r->m.job.size)
        status = check_least(r);
    if (status == NSDF_OK)
        status = probe(r, &level);
    if (status == NSDF_OK)
        status = r->m.job.size ? fit_size(r, level) : nsdf_error_search_run(&r->search);
    /* An end that is none: the caller sees why in *result. */
    return status == NSDF_CANCELLED && (result->aborted || result->diverged) ? NSDF_OK : status;
}

nsdf_status nsdf_rate_blocks_judge(nsdf_rate_blocks *r, nsdf_block_model *model, nsdf_fit_result *result,
                                   const nsdf_quality *quality, nsdf_sample_set *strays, int *again,
                                   nsdf_encoder_error *error) {
    lend(r, model, result, error);
    *again = 0;
    nsdf_rate_take_strays(&r->m, strays);
    return r->m.job.size ? judge_size(r, quality, again) : nsdf_error_search_judge(&r->search, quality, again);
}

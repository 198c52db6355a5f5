#include "rate_blocks.h"

#include "rate_control.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Shares of the options' steps.  Together they take about what one fit without a target takes. */
static const double probe_share = 0.1, fit_share = 0.85, refit_share = 1.0, tune_share = 0.05;
/* After a whole fit the error is at most about this part of a probe's. */
static const double probe_gain = 0.95;
/* The error of a surface as a multiple of that of samples near it, 1.05 to 1.25: by the latter, pieces astray in a
 * probe, which a whole fit does not have, do not count. */
static const double surface_by_near = 1.2;
/* A second probe when the level is to change by more. */
static const double near_level = 0.6;
/* What is aimed at, and what is good enough, of the size or error asked for. */
static const double size_aim = 0.99, error_aim = 0.96, error_enough = 0.92, error_hopeless = 1.12;
static const double error_accepted = 0.9; /* once all frames were verified */
static const double error_wasteful = 0.7; /* worth another fit with fewer bones */
static const double least_gain = 0.95;    /* of the error, by another fit, or there is no third */
static const double quick_margin = 0.985; /* quick errors up to this part of the error are worth a whole verification */
static const double lowest_x = -1.6, highest_x = 1.6, rate_share = 1.5;
static const double margin_blocks = 1.2; /* nodes for more blocks than expected */
enum { MOST_PROBES = 2, MOST_TUNES = 9, MOST_REFITS = 2, MOST_CHECKS = 5 };

/* A model that was left for another, and what belongs to it. */
typedef struct held_model {
    nsdf_block_model model;
    nsdf_encoder_options level_o, options;
    double level, x, quick;
    uint64_t bytes;
} held_model;

struct nsdf_rate_blocks {
    nsdf_rate_job job;
    nsdf_encoder_options base;    /* as given, with the steps of blocks */
    nsdf_encoder_options level_o; /* at the level */
    nsdf_encoder_options options; /* and with x: those that fitting sees */
    nsdf_fit_control control;
    nsdf_block_model *model; /* the caller's */
    nsdf_fit_result *result;
    nsdf_encoder_error *error;
    nsdf_tracked tracked;
    uint32_t tracked_blocks; /* 0 = nothing tracked */
    double level, x;
    nsdf_rate_measure measure;
    nsdf_rate_trials trials; /* since the last whole fit */
    double quick;            /* error of the model as it is, of some frames */
    double whole_by_quick;   /* error of all frames as a multiple of that */
    uint64_t bytes;          /* of the model as it is */
    double fit_error;        /* quick error of the last whole fit, before tuning */
    int close;               /* some round since the last whole fit had the error: tuning leads there */
    uint32_t tunes, refits, checks;
    int stopped, finished;
    held_model held;       /* has the error by quick measure, with the fewest bytes since approaching began */
    nsdf_block_model best; /* met the error when all frames were verified, if it has values */
    uint64_t best_bytes;
};

static nsdf_status no_memory(nsdf_rate_blocks *r) {
    return nsdf_encoder_fail(r->error, NSDF_NO_MEMORY, "out of memory while fitting");
}

nsdf_rate_blocks *nsdf_rate_blocks_create(const nsdf_rate_job *job) {
    nsdf_rate_blocks *r = calloc(1, sizeof *r);
    if (!r)
        return NULL;
    r->job = *job;
    r->base = nsdf_block_options(job->fit.options);
    r->whole_by_quick = 1.0;
    return r;
}

void nsdf_rate_blocks_free(nsdf_rate_blocks *r) {
    if (!r)
        return;
    if (r->tracked_blocks)
        nsdf_nodes_free(&r->tracked.nodes);
    nsdf_block_model_free(&r->best);
    nsdf_block_model_free(&r->held.model);
    free(r);
}

/* ---- Bytes and errors ------------------------------------------------------------------------------------- */

/* The file that the model gives now.  0, or -1. */
static int make_file(const nsdf_rate_blocks *r, nsdf_buffer *file) {
    nsdf_coded_segment segment = {{NULL, 0, 0, 0}, 0};
    const int failed = nsdf_code_blocks(r->model, &segment) != 0 || nsdf_rate_make_file(&r->job, &segment, file) != 0;
    nsdf_buffer_free(&segment.payload);
    return failed ? -1 : 0;
}

static int count_bytes(nsdf_rate_blocks *r) {
    nsdf_buffer file = {NULL, 0, 0, 0};
    const int failed = make_file(r, &file);
    r->bytes = file.size;
    nsdf_buffer_free(&file);
    return failed;
}

static void set_x(nsdf_rate_blocks *r, double x) {
    const double f = exp(x);
    r->x = x;
    r->options.pose_step = fmax(1e-7, fmin(0.1, r->level_o.pose_step * f));
    r->options.coefficient_step = fmax(1e-7, fmin(0.1, r->level_o.coefficient_step * f));
    r->options.motion_rate = fmin(1.0, r->level_o.motion_rate * exp(rate_share * x));
    if (r->model->values) {
        const nsdf_block_steps steps = {r->options.pose_step, r->options.coefficient_step};
        nsdf_block_model_set_steps(r->model, &steps);
    }
}

static nsdf_status quick_error(nsdf_rate_blocks *r) {
    nsdf_buffer file = {NULL, 0, 0, 0};
    nsdf_status status = make_file(r, &file) == 0 ? NSDF_OK : no_memory(r);
    r->bytes = file.size;
    if (status == NSDF_OK)
        status = nsdf_rate_quick_error(&r->job, &file, &r->quick, r->error);
    nsdf_buffer_free(&file);
    return status;
}

static void note(const nsdf_rate_blocks *r, nsdf_rate_kind kind, uint64_t steps, double error) {
    const nsdf_rate_round round = {kind,
                                   r->model->desc.block_count,
                                   r->model->desc.bone_count,
                                   0,
                                   steps,
                                   r->options.pose_step,
                                   r->options.coefficient_step,
                                   r->options.motion_rate,
                                   0.0,
                                   r->bytes,
                                   error};
    nsdf_rate_note(&r->job, &round);
}

/* ---- Fitting ---------------------------------------------------------------------------------------------- */

static nsdf_fit_job job_of(nsdf_rate_blocks *r) {
    nsdf_fit_job job = r->job.fit;
    job.options = &r->options;
    job.control = &r->control;
    return job;
}

static nsdf_status track_for(nsdf_rate_blocks *r, uint32_t blocks) {
    if (blocks <= r->tracked_blocks)
        return NSDF_OK;
    nsdf_encoder_options o = r->base;
    nsdf_fit_job job = r->job.fit;
    if (r->tracked_blocks)
        nsdf_nodes_free(&r->tracked.nodes);
    r->tracked_blocks = 0;
    o.blocks = (uint32_t)fmin(margin_blocks * blocks, NSDF_MAX_BLOCKS);
    job.options = &o;
    if (nsdf_track_surface(&job, &r->tracked) != 0)
        return no_memory(r);
    r->tracked_blocks = o.blocks;
    return NSDF_OK;
}

static double within_levels(const nsdf_rate_blocks *r, double level) {
    const double most = r->job.size ? nsdf_rate_highest_level : nsdf_rate_highest_for_error;
    return fmax(nsdf_rate_lowest_level, fmin(most, level));
}

/* First values at a level. */
static nsdf_status start(nsdf_rate_blocks *r, double level) {
    r->level = within_levels(r, level);
    r->level_o = nsdf_rate_options_at(&r->base, r->level);
    r->options = r->level_o;
    nsdf_block_model_free(r->model);
    set_x(r, 0.0);
    nsdf_status status = track_for(r, r->options.blocks);
    if (status != NSDF_OK)
        return status;
    const nsdf_fit_job job = job_of(r);
    return nsdf_start_blocks(&job, &r->tracked, r->model) == 0 ? NSDF_OK : no_memory(r);
}

static void steer(void *user, uint64_t done, uint64_t steps) {
    nsdf_rate_blocks *r = user;
    (void)done;
    (void)steps;
    if (count_bytes(r) == 0)
        set_x(r, nsdf_rate_steer(r->x, r->bytes, (uint64_t)(size_aim * (double)r->job.size)));
}

/* Steps of Adam; their number is a share of the options'. */
static nsdf_status fit_some(nsdf_rate_blocks *r, double share, int tuning) {
    nsdf_fit_result some;
    const nsdf_fit_control control = {tuning, r->job.size && !tuning && share > probe_share ? steer : NULL, r};
    r->control = control;
    r->options.steps = (uint64_t)fmax(1.0, rint(share * (double)r->base.steps));
    r->options.seed = r->base.seed + r->tunes; /* other samples in every round */
    const nsdf_fit_job job = job_of(r);
    if (nsdf_block_fit_run(&job, r->model, &some) != 0)
        return no_memory(r);
    r->stopped |= some.steps < r->options.steps;
    some.steps += r->result->steps;
    some.samples += r->result->samples;
    *r->result = some;
    return some.aborted || some.diverged ? NSDF_CANCELLED : NSDF_OK;
}

/* A fit, and what it gave: bytes, and with a target error the error. */
static nsdf_status fit_and_measure(nsdf_rate_blocks *r, nsdf_rate_kind kind, double share) {
    const uint64_t before = r->result->steps;
    nsdf_status status = fit_some(r, share, kind == NSDF_RATE_TUNE);
    if (status != NSDF_OK)
        return status;
    if (r->job.size)
        status = count_bytes(r) == 0 ? NSDF_OK : no_memory(r);
    else
        status = quick_error(r);
    if (status == NSDF_OK)
        note(r, kind, r->result->steps - before, r->quick);
    return status;
}

static nsdf_status learn(nsdf_rate_blocks *r) {
    nsdf_block_bytes b;
    if (nsdf_weigh_blocks(r->model, &b) != 0)
        return no_memory(r);
    const nsdf_rate_measure m = {r->model->desc.block_count,
                                 r->model->desc.bone_count,
                                 r->model->knots,
                                 r->options.pose_step,
                                 r->options.coefficient_step,
                                 (double)r->bytes - (double)b.shapes - (double)b.motion,
                                 (double)b.shapes,
                                 (double)b.motion};
    r->measure = m;
    return NSDF_OK;
}

/* ---- From a target to a level ----------------------------------------------------------------------------- */

static double level_of_size(const nsdf_rate_blocks *r) {
    return nsdf_rate_level_for(&r->measure, &r->base, size_aim * (double)r->job.size);
}

static double first_level(const nsdf_rate_blocks *r) {
    return r->job.size ? level_of_size(r) : nsdf_rate_error_level(&r->base, r->base.target_error);
}

/* The level that the last probe asks for. */
static nsdf_status next_level(nsdf_rate_blocks *r, double *level) {
    nsdf_status status = learn(r);
    if (r->job.size)
        *level = level_of_size(r);
    else
        *level = r->level + nsdf_rate_level_step(probe_gain * fmin(r->quick, surface_by_near * r->result->near_error),
                                                 error_aim * r->base.target_error);
    *level = within_levels(r, *level);
    return status;
}

/* Whether the coarsest model is small enough. */
static nsdf_status check_least(nsdf_rate_blocks *r) {
    nsdf_status status = start(r, nsdf_rate_lowest_level);
    if (status != NSDF_OK)
        return status;
    set_x(r, highest_x);
    if (count_bytes(r) != 0)
        return no_memory(r);
    if (r->bytes > r->job.size)
        return nsdf_encoder_fail(r->error, NSDF_LIMIT,
                                 "%llu bytes are too few: the least that this sequence takes are %llu",
                                 (unsigned long long)r->job.size, (unsigned long long)r->bytes);
    return NSDF_OK;
}

static nsdf_status probe(nsdf_rate_blocks *r, double *level) {
    nsdf_status status = NSDF_OK;
    for (int i = 0; i < MOST_PROBES && status == NSDF_OK && !r->stopped; i++) {
        status = start(r, *level);
        if (status == NSDF_OK)
            status = fit_and_measure(r, NSDF_RATE_PROBE, probe_share);
        if (status == NSDF_OK)
            status = next_level(r, level);
        if (fabs(*level - r->level) < near_level)
            break;
    }
    return status;
}

/* Quick error of what is about to be verified as a whole, relative to the one asked for. */
static double expected(const nsdf_rate_blocks *r) {
    return r->quick * r->whole_by_quick / r->base.target_error;
}

static nsdf_status fit_at(nsdf_rate_blocks *r, double level, double share) {
    nsdf_status status = start(r, level);
    if (status == NSDF_OK)
        status = fit_and_measure(r, NSDF_RATE_FIT, share);
    r->fit_error = r->quick;
    r->close = !r->job.size && expected(r) <= 1.0;
    r->trials.count = 0;
    nsdf_rate_tried(&r->trials, r->x, r->quick);
    return status;
}

/* ---- Size ------------------------------------------------------------------------------------------------- */

static int bytes_at(void *user, double x, uint64_t *bytes) {
    nsdf_rate_blocks *r = user;
    set_x(r, x);
    const int failed = count_bytes(r);
    *bytes = r->bytes;
    return failed;
}

/* The last percent, by quantisers alone. */
static nsdf_status fill(nsdf_rate_blocks *r) {
    const nsdf_rate_search search = {bytes_at, r, r->job.size, r->x - 8.0, r->x + 8.0};
    double x = r->x;
    uint64_t bytes = 0;
    const int answer = nsdf_rate_find(&search, &x, &bytes);
    if (answer < 0)
        return no_memory(r);
    if (answer > 0)
        return nsdf_encoder_fail(r->error, NSDF_LIMIT, "%llu bytes are too few: the smallest file has %llu",
                                 (unsigned long long)r->job.size, (unsigned long long)bytes);
    if (bytes_at(r, x, &bytes) != 0)
        return no_memory(r);
    note(r, NSDF_RATE_QUANTISE, 0, 0.0);
    return NSDF_OK;
}

/* ---- Error ------------------------------------------------------------------------------------------------ */

static nsdf_status refit(nsdf_rate_blocks *r) {
    const double before = r->fit_error;
    r->refits++;
    const double step = nsdf_rate_level_step(expected(r), error_aim);
    const int finer = step > 0.0;
    const nsdf_status status = fit_at(r, r->level + (finer ? 1.15 * step + 0.1 : 0.85 * step), refit_share);
    if (finer && r->quick > least_gain * before)
        r->refits = MOST_REFITS;
    return status;
}

/* Whether tuning can get there: errors follow x only so far. */
static int needs_refit(const nsdf_rate_blocks *r, double next) {
    const int can = r->refits < MOST_REFITS && r->level < nsdf_rate_highest_for_error - 0.05;
    if (r->refits == 0 && r->trials.count == 1 && r->level > nsdf_rate_lowest_level && expected(r) < error_wasteful)
        return 1;
    return can && !r->close && !r->best.values && expected(r) > 1.0 &&
           (expected(r) > error_hopeless || next < lowest_x || r->trials.count > 2);
}

/* Errors of rounds scatter: one that will do is not forgotten for those that follow. */
static nsdf_status hold(nsdf_rate_blocks *r) {
    held_model *h = &r->held;
    if (expected(r) > 1.0 || (h->model.values && h->bytes <= r->bytes))
        return NSDF_OK;
    nsdf_block_model_free(&h->model);
    *h = (held_model){.level_o = r->level_o,
                      .options = r->options,
                      .level = r->level,
                      .x = r->x,
                      .quick = r->quick,
                      .bytes = r->bytes};
    return nsdf_block_model_copy(&h->model, r->model) == 0 ? NSDF_OK : no_memory(r);
}

/* What is held takes the place of a model that will not do. */
static void take_held(nsdf_rate_blocks *r) {
    held_model *h = &r->held;
    if (h->model.values && expected(r) > 1.0) {
        nsdf_block_model_free(r->model);
        *r->model = h->model;
        memset(&h->model, 0, sizeof h->model);
        r->level_o = h->level_o;
        r->options = h->options;
        r->level = h->level;
        r->x = h->x;
        r->quick = h->quick;
        r->bytes = h->bytes;
    }
    nsdf_block_model_free(&h->model);
}

/* Until the error is just below the one asked for. */
static nsdf_status approach(nsdf_rate_blocks *r) {
    nsdf_status status = hold(r);
    while (status == NSDF_OK && !r->stopped) {
        const double ratio = expected(r);
        if (ratio >= error_enough && ratio <= quick_margin)
            break;
        const double wanted = error_aim * r->base.target_error / r->whole_by_quick;
        const double next = nsdf_rate_next(&r->trials, wanted), x = fmax(lowest_x, fmin(highest_x, next));
        if (needs_refit(r, next)) {
            status = refit(r);
            if (status == NSDF_OK)
                status = hold(r);
            continue;
        }
        if (r->tunes >= MOST_TUNES || x == r->x)
            break;
        r->tunes++;
        set_x(r, x);
        status = fit_and_measure(r, NSDF_RATE_TUNE, tune_share);
        nsdf_rate_tried(&r->trials, x, r->quick);
        r->close |= expected(r) <= 1.0;
        if (status == NSDF_OK)
            status = hold(r);
    }
    take_held(r);
    return status;
}

static nsdf_status keep(nsdf_rate_blocks *r) {
    if (r->best.values && r->best_bytes <= r->bytes)
        return NSDF_OK;
    nsdf_block_model_free(&r->best);
    r->best_bytes = r->bytes;
    return nsdf_block_model_copy(&r->best, r->model) == 0 ? NSDF_OK : no_memory(r);
}

/* The best there was takes the place of the model, unless it is the model. */
static int restore(nsdf_rate_blocks *r, double ratio) {
    r->finished = 1;
    if (!r->best.values || (ratio <= 1.0 && r->bytes <= r->best_bytes))
        return 0;
    nsdf_block_model_free(r->model);
    *r->model = r->best;
    memset(&r->best, 0, sizeof r->best);
    return 1;
}

nsdf_status nsdf_rate_blocks_judge(nsdf_rate_blocks *r, nsdf_block_model *model, nsdf_fit_result *result,
                                   const nsdf_quality *quality, int *again, nsdf_encoder_error *error) {
    const double mean = nsdf_mean_error(quality), ratio = mean / r->base.target_error;
    nsdf_status status = NSDF_OK;
    r->model = model;
    r->result = result;
    r->error = error;
    *again = 0;
    if (r->job.size || r->finished)
        return NSDF_OK;
    note(r, NSDF_RATE_VERIFY, 0, mean);
    r->checks++;
    r->whole_by_quick = mean / r->quick;
    if (ratio <= 1.0)
        status = keep(r);
    const uint64_t before = r->result->steps;
    if (status == NSDF_OK && r->checks < MOST_CHECKS && !(ratio <= 1.0 && ratio >= error_accepted))
        status = approach(r);
    *again = r->result->steps > before;
    if (status == NSDF_OK && !*again)
        *again = restore(r, ratio);
    return status;
}

/* ---- The whole -------------------------------------------------------------------------------------------- */

nsdf_status nsdf_rate_blocks_fit(nsdf_rate_blocks *r, nsdf_block_model *model, nsdf_fit_result *result,
                                 nsdf_encoder_error *error) {
    r->model = model;
    r->result = result;
    r->error = error;
    memset(result, 0, sizeof *result);
    r->measure = nsdf_rate_first_guess(&r->base, r->job.fit.frame_count);
    double level = first_level(r);
    nsdf_status status = track_for(r, nsdf_rate_options_at(&r->base, level).blocks);
    if (status == NSDF_OK && r->job.size)
        status = check_least(r);
    if (status == NSDF_OK)
        status = probe(r, &level);
    if (status == NSDF_OK && !r->stopped)
        status = fit_at(r, level, fit_share);
    if (status == NSDF_OK)
        status = r->job.size ? fill(r) : approach(r);
    /* An end that is none: the caller sees why in *result. */
    return status == NSDF_CANCELLED && (result->aborted || result->diverged) ? NSDF_OK : status;
}

#include "rate_error.h"

#include "block_mend.h"

#include <math.h>
#include <string.h>

/* Of the options' steps. */
static const double tune_share = 0.05;
/* After a whole fit the error is at most about this part of a probe's. */
static const double probe_gain = 0.95;
/* The error of a surface as a multiple of that of samples near it, 1.05 to 1.25: by the latter, pieces astray in a
 * probe, which a whole fit does not have, do not count. */
static const double surface_by_near = 1.2;
/* What is aimed at, and what is good enough, of the error asked for. */
static const double error_aim = 0.96, error_enough = 0.92, error_hopeless = 1.3;
static const double quick_margin = 0.985; /* quick errors up to this part of the error are worth a whole verification */
static const double error_accepted = 0.88;                   /* once all frames were verified */
static const double error_wasteful = 0.7;                    /* worth another fit with fewer bones */
static const double least_gain = 0.95;                       /* of the error, by a finer fit, or there is no other */
static const double least_coarser = 0.25, least_finer = 0.1; /* of the level, to be worth another fit */
static const double nearer = 0.99;                           /* of errors that miss, worth more bytes */
static const double least_fall = 0.97, much_finer = 0.3;     /* of the error by such a factor, or it is of no use */
static const double least_move = 0.01; /* of x, or errors on both sides of the one asked for are as near as they get */
enum { MOST_TUNES = 9, TUNES_PER_CHECK = 2, MOST_REFITS = 2, MOST_CHECKS = 5, MOST_MENDS = 3, PATIENCE = 3 };

void nsdf_error_search_init(nsdf_error_search *s, nsdf_rate_model *m) {
    memset(s, 0, sizeof *s);
    s->m = m;
    s->whole_by_quick = 1.0;
}

void nsdf_error_search_free(nsdf_error_search *s) {
    nsdf_rate_copy_free(&s->held);
    nsdf_rate_copy_free(&s->best);
}

/* ---- Levels ----------------------------------------------------------------------------------------------- */

void nsdf_error_search_probed(nsdf_error_search *s) {
    const nsdf_rate_model *m = s->m;
    nsdf_rate_curve_add(&s->probes, m->now.level,
                        probe_gain * fmin(m->now.quick, surface_by_near * m->result->near_error));
}

/* That quick errors should have. */
static double wanted(const nsdf_error_search *s) {
    return error_aim * s->m->base.target_error / s->whole_by_quick;
}

/* With one fit, probes tell how errors change with the level; fits do as soon as there are two. */
double nsdf_error_search_level(const nsdf_error_search *s) {
    double level;
    if (s->fits.count > 1 || s->probes.count == 0)
        level = nsdf_rate_curve_level(&s->fits, wanted(s));
    else if (s->fits.count == 1)
        level = nsdf_rate_curve_level(&s->probes, wanted(s) / s->fits.error[0] *
                                                      nsdf_rate_curve_error(&s->probes, s->fits.level[0]));
    else
        level = nsdf_rate_curve_level(&s->probes, wanted(s));
    return nsdf_rate_within_levels(s->m, level);
}

/* ---- Rounds ----------------------------------------------------------------------------------------------- */

/* Error of the whole, as far as it is known, relative to the one asked for. */
static double expected(const nsdf_error_search *s) {
    return s->m->now.quick * s->whole_by_quick / s->m->base.target_error;
}

/* Errors of rounds scatter: one that will do is not forgotten for those that follow, nor one that will surely do for
 * one that verification may refuse. */
static nsdf_status hold(nsdf_error_search *s) {
    const double ratio = expected(s);
    const int is_sure = ratio <= quick_margin, held = s->held.blocks.values != NULL;
    if (ratio > 1.0 || (held && s->held_is_sure > is_sure) ||
        (held && s->held_is_sure == is_sure && s->held.state.bytes <= s->m->now.bytes))
        return NSDF_OK;
    s->held_is_sure = is_sure;
    s->held_fit = s->fit;
    s->held_trials = s->trials;
    return nsdf_rate_copy_model(&s->held, s->m) == 0 ? NSDF_OK : nsdf_rate_no_memory(s->m);
}

static nsdf_status note_trial(nsdf_error_search *s) {
    nsdf_rate_tried(&s->trials, s->m->now.x, s->m->now.quick);
    return hold(s);
}

/* Whether some trial of the fit at hand had the error, by what is now known of whole errors: tuning leads there. */
static int is_close(const nsdf_error_search *s) {
    for (uint32_t i = 0; i < s->trials.count; i++)
        if (s->trials.error[i] * s->whole_by_quick <= s->m->base.target_error)
            return 1;
    return 0;
}

static nsdf_status fit_at(nsdf_error_search *s, double level) {
    nsdf_status status = nsdf_rate_start_at(s->m, level);
    if (status == NSDF_OK)
        status = nsdf_rate_fit_and_measure(s->m, NSDF_RATE_FIT, NSDF_RATE_FIT_SHARE);
    if (status != NSDF_OK)
        return status;
    nsdf_rate_curve_add(&s->fits, s->m->now.level, s->m->now.quick);
    s->fit = ++s->fits_made;
    s->fit_mends = 0;
    s->trials.count = 0;
    return note_trial(s);
}

static nsdf_status refit(nsdf_error_search *s, double level) {
    const int finer = level > s->m->now.level;
    const double before = nsdf_rate_curve_error(&s->fits, s->m->now.level);
    const nsdf_status status = fit_at(s, level);
    s->refits = finer && s->m->now.quick > least_gain * before ? MOST_REFITS : s->refits + 1;
    return status;
}

static nsdf_status tune(nsdf_error_search *s, double x, double share) {
    nsdf_rate_set_x(s->m, x);
    const nsdf_status status = nsdf_rate_fit_and_measure(s->m, NSDF_RATE_TUNE, share);
    return status == NSDF_OK ? note_trial(s) : status;
}

/* Goes on with the samples of pieces astray; what was tried without them no longer counts, nor do whole errors that
 * were lower since some frames had more of them than most. */
static nsdf_status mend(nsdf_error_search *s) {
    const int fresh = s->trials.count == 1;
    s->mends++;
    s->fit_mends++;
    s->trials.count = 0;
    s->whole_by_quick = fmax(s->whole_by_quick, 1.0);
    const nsdf_status status = tune(s, s->m->now.x, NSDF_MEND_SHARE);
    if (fresh)
        nsdf_rate_curve_add(&s->fits, s->m->now.level, s->m->now.quick);
    return status;
}

/* What is held takes the place of a model that will not do. */
static void take_held(nsdf_error_search *s) {
    nsdf_rate_take_copy(s->m, &s->held);
    if (s->held_fit != s->fit)
        s->trials = s->held_trials;
    s->fit = s->held_fit;
}

/* Whether the error is that of surface where there should be none; then neither level nor x tell much. */
static int is_astray(const nsdf_error_search *s) {
    return s->m->now.back_by_decoded > NSDF_ASTRAY && expected(s) > 1.0 && s->fit_mends < MOST_MENDS;
}

/* ---- The search ------------------------------------------------------------------------------------------- */

/* Tuning will not get the error down to the one asked for: errors follow x only so far. */
static int is_lost(const nsdf_error_search *s, double next) {
    const double ratio = expected(s);
    return ratio > 1.0 && !is_close(s) &&
           (ratio > error_hopeless || next < -NSDF_RATE_MOST_X || s->trials.count > PATIENCE);
}

/* Finer steps did not bring the error down any more. */
static int is_of_no_use(const nsdf_error_search *s) {
    const nsdf_rate_trials *t = &s->trials;
    return expected(s) > 1.0 && !is_close(s) && t->count > 1 && t->x[0] < t->x[1] - much_finer &&
           t->error[0] > least_fall * t->error[1];
}

/* The model is finer than it has to be by more than quantisers should make up for.  Not once pieces astray were mended:
 * another fit has others. */
static int is_wasteful(const nsdf_error_search *s) {
    const double ratio = expected(s);
    if (s->fit_mends > 0)
        return 0;
    return s->trials.count == 1 ? ratio < error_wasteful : ratio < error_accepted && s->m->now.x >= NSDF_RATE_MOST_X;
}

/* Whether another fit, at *level, should follow.  What is held needs none that is hardly coarser. */
static int wants_refit(const nsdf_error_search *s, double next, double *level) {
    const int held = s->held.blocks.values != NULL;
    if (s->refits >= MOST_REFITS)
        return 0;
    *level = nsdf_error_search_level(s);
    if (is_lost(s, next))
        return held ? *level < s->held.state.level - least_coarser : *level > s->m->now.level + least_finer;
    return is_wasteful(s) && *level < s->m->now.level - least_coarser;
}

/* One round; *done when there is none that might help. */
static nsdf_status one_round(nsdf_error_search *s, int *done) {
    const double next = nsdf_rate_next(&s->trials, wanted(s)),
                 x = fmax(-NSDF_RATE_MOST_X, fmin(NSDF_RATE_MOST_X, next));
    double level = 0.0;
    if (is_astray(s) && s->verified == s->m->now.steps)
        return mend(s);
    *done = is_astray(s); /* verification finds the pieces */
    if (*done)
        return NSDF_OK;
    if (wants_refit(s, next, &level))
        return refit(s, level);
    if (is_lost(s, next) && s->held.blocks.values) {
        take_held(s);
        return hold(s);
    }
    *done =
        s->tunes >= MOST_TUNES + TUNES_PER_CHECK * s->checks || fabs(x - s->m->now.x) < least_move || is_of_no_use(s);
    if (*done)
        return NSDF_OK;
    s->tunes++;
    return tune(s, x, tune_share);
}

/* Until the error of some frames is just below the one asked for. */
static nsdf_status approach(nsdf_error_search *s) {
    nsdf_status status = hold(s);
    for (int done = 0; status == NSDF_OK && !done && !s->m->stopped;) {
        const double ratio = expected(s);
        if (ratio >= error_enough && ratio <= quick_margin)
            break;
        status = one_round(s, &done);
    }
    if (s->held.blocks.values && expected(s) > 1.0)
        take_held(s);
    nsdf_rate_copy_free(&s->held);
    return status;
}

nsdf_status nsdf_error_search_run(nsdf_error_search *s) {
    const nsdf_status status = s->m->stopped ? NSDF_OK : fit_at(s, nsdf_error_search_level(s));
    return status == NSDF_OK ? approach(s) : status;
}

/* ---- Verified errors -------------------------------------------------------------------------------------- */

/* Whether the model, of a verified error, is better than the best so far. */
static int is_best(const nsdf_error_search *s, double mean) {
    const double target = s->m->base.target_error;
    if (!s->best.blocks.values)
        return 1;
    if (mean <= target)
        return s->best_error > target || s->m->now.bytes < s->best.state.bytes;
    return mean < nearer * s->best_error;
}

/* Keeps the model, of a verified error, if it is the best so far. */
static nsdf_status keep(nsdf_error_search *s, double mean) {
    if (!is_best(s, mean))
        return NSDF_OK;
    s->best_error = mean;
    return nsdf_rate_copy_model(&s->best, s->m) == 0 ? NSDF_OK : nsdf_rate_no_memory(s->m);
}

nsdf_status nsdf_error_search_judge(nsdf_error_search *s, const nsdf_quality *quality, int *again) {
    const double mean = nsdf_mean_error(quality), ratio = mean / s->m->base.target_error;
    s->verified = s->m->now.steps;
    *again = 0;
    if (s->finished)
        return NSDF_OK;
    nsdf_rate_note_model(s->m, NSDF_RATE_VERIFY, 0, mean);
    s->checks++;
    s->whole_by_quick = mean / s->m->now.quick;
    s->m->now.back_by_decoded = quality->mean_to_input / fmax(quality->mean_to_decoded, 1e-30);
    nsdf_status status = keep(s, mean);
    if (status == NSDF_OK && s->checks < MOST_CHECKS + s->mends && !(ratio <= 1.0 && ratio >= error_accepted))
        status = approach(s);
    *again = s->m->now.steps != s->verified;
    s->finished = !*again;
    if (status == NSDF_OK && s->finished && s->best.state.steps != s->m->now.steps) {
        nsdf_rate_take_copy(s->m, &s->best);
        *again = 1;
    }
    return status;
}

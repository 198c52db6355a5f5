#include "fit.h"

#include "checkpoint.h"
#include "frame_order.h"
#include "muon.h"
#include "network_rate.h"
#include "optimiser.h"
#include "stray.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Rounding is simulated in this last part of fitting. */
static const double quantise_aware_share = 0.25;

/* The distance at which a sample has half its weight, where it is not said: the mean error within these. */
static const double least_d0 = 0.0025, most_d0 = 0.02;

/* The rate of the parameters rises over this part of the steps: a network that pays from the first on keeps its first
 * values too long. */
static const double rate_rise = 0.25;

/* Short factors serve for this part of the steps; what they leave is settled in single precision. */
static const double short_share = 0.8;
static const double exact_by_short = 2.0; /* time of a step, about */

/* When what follows the fit is tried, as a share of the steps: the surface is good enough, and plans are to come. */
static const double trial_at = 0.5;

/* So often are quantisers chosen before, for the rate of the parameters. */
enum { QUANTISER_STEPS = 50 };

/* When the network's surface is searched for strays, as shares of the steps, and on how fine a grid. */
static const struct {
    double at;
    uint32_t resolution;
} searches[] = {{0.6, 64}};
enum { SEARCHES = sizeof searches / sizeof *searches };

/* After the last step, rounds of a few more follow until a search finds nothing. */
enum { REPAIR_ROUNDS = 1, REPAIR_RESOLUTION = 64 };

/* With more crossings a frame than this the network is far from fitted: a few more steps do not help. */
enum { HOPELESS_STRAYS = 1000 };
static const double repair_share = 0.02, repair_rate = 0.05;

/* Points that a slot takes besides its ordinary ones: near strays, and from the tail of the errors. */
enum { STRAY_POINTS = 128, TAIL_POINTS = 256, EXTRA_POINTS = STRAY_POINTS + TAIL_POINTS };

/* Points of a batch whose loss is above tail_factor times the batch's mean join the tail of their frame, a ring of the
 * latest TAIL_SIZE: places that the network gets wrong, such as hands and feet, are seen more often. */
enum { TAIL_SIZE = 512, TAIL_PER_BATCH = 64 };
static const float tail_factor = 3.0f;

typedef struct {
    uint32_t index[TAIL_SIZE]; /* of samples */
    uint32_t count, next;
} tail_ring;

typedef struct {
    uint32_t frame;
    float *composed, *gradient;   /* [composed_size] */
    float extra[4][EXTRA_POINTS]; /* x, y, z, d */
    uint32_t extra_count;
    uint32_t worst[TAIL_PER_BATCH], worst_count; /* samples that join the tail */
    float *losses;                               /* [batch_points] */
    nsdf_fit_sums sums;
} slot;

typedef struct {
    const nsdf_fit_job *job;
    const nsdf_fit_kernels *kernels, *fastest, *exact; /* of the step that is made; to choose from */
    nsdf_loss_params loss;
    nsdf_random random;
    nsdf_frame_order order;
    size_t *cursor;             /* [frame]: next sample */
    slot *slots;                /* [batch_frames] */
    nsdf_fit_scratch **scratch; /* [worker] */
    nsdf_adam adam;
    nsdf_muon muon;            /* no matrices when Adam moves all parameters */
    float *gradient, *rounded; /* [parameter_count] */
    const float *active;       /* parameters that the batch uses: fitted ones, or rounded ones */
    double near_error;
    double rate_share;      /* of the rate of the parameters, 0 to 1 */
    nsdf_sample_set *stray; /* [frame] */
    tail_ring *tail;        /* [frame] */
    uint32_t searched;      /* searches made */
    float *parameters;      /* that are fitted */
    double began;           /* nsdf_clock(), had there been no break */
    nsdf_time_budget budget;
    int tried; /* what follows the fit */
    nsdf_fit_result *result;
} state;

double nsdf_clock(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- Setting up ----------------------------------------------------------------------------------------- */

static void free_state(state *s) {
    uint32_t slots = s->job->options->batch_frames, workers = nsdf_workers_count(s->job->workers);
    for (uint32_t i = 0; s->slots && i < slots; i++) {
        free(s->slots[i].composed);
        free(s->slots[i].gradient);
        free(s->slots[i].losses);
    }
    for (uint32_t i = 0; s->scratch && i < workers; i++)
        nsdf_fit_scratch_free(s->scratch[i]);
    for (uint32_t i = 0; s->stray && i < s->job->frame_count; i++)
        nsdf_sample_set_free(&s->stray[i]);
    free(s->stray);
    free(s->tail);
    free(s->slots);
    free(s->scratch);
    nsdf_frame_order_free(&s->order);
    free(s->cursor);
    free(s->gradient);
    free(s->rounded);
    nsdf_adam_free(&s->adam);
    nsdf_muon_free(&s->muon);
}

static int create_state(state *s, const nsdf_fit_job *job, float *parameters, nsdf_fit_result *result) {
    const nsdf_encoder_options *o = job->options;
    const nsdf_model *model = job->model;
    uint32_t workers = nsdf_workers_count(job->workers);
    memset(s, 0, sizeof *s);
    s->job = job;
    s->parameters = parameters;
    s->result = result;
    s->began = nsdf_clock();
    nsdf_budget_start(&s->budget, job->deadline, o->steps);
    s->kernels = s->fastest = nsdf_fit_kernels_select();
    s->exact = nsdf_fit_kernels_exact();
    if (s->fastest != s->exact)
        nsdf_budget_expect(&s->budget, short_share, exact_by_short);
    s->loss = (nsdf_loss_params){o->loss, (float)o->loss_d0, (float)o->loss_delta, (float)o->loss_slope, 1.0f};
    s->random = nsdf_random_start(o->seed, 2);
    s->cursor = calloc(job->frame_count, sizeof *s->cursor);
    s->stray = calloc(job->frame_count, sizeof *s->stray);
    s->tail = calloc(job->frame_count, sizeof *s->tail);
    s->slots = calloc(o->batch_frames, sizeof *s->slots);
    s->scratch = calloc(workers, sizeof *s->scratch);
    s->gradient = calloc(model->parameter_count, sizeof(float));
    s->rounded = calloc(model->parameter_count, sizeof(float));
    int ok = nsdf_frame_order_create(&s->order, job->frame_count) == 0 && s->cursor && s->stray && s->tail &&
             s->slots && s->scratch && s->gradient && s->rounded &&
             nsdf_adam_create(&s->adam, model->parameter_count) == 0 &&
             (o->optimiser != NSDF_OPTIMISER_MUON || nsdf_muon_create(&s->muon, model, s->kernels) == 0);
    for (uint32_t i = 0; ok && i < o->batch_frames; i++) {
        s->slots[i].composed = calloc(model->composed_size, sizeof(float));
        s->slots[i].gradient = calloc(model->composed_size, sizeof(float));
        s->slots[i].losses = calloc(o->batch_points, sizeof(float));
        ok = s->slots[i].composed && s->slots[i].gradient && s->slots[i].losses;
    }
    for (uint32_t i = 0; ok && i < workers; i++)
        ok = (s->scratch[i] = nsdf_fit_scratch_create(model)) != NULL;
    return ok ? 0 : -1;
}

/* ---- One step ------------------------------------------------------------------------------------------- */

/* Takes the frame's next stretch of samples; the same frame may stand in several slots. */
static nsdf_fit_points next_points(const state *s, uint32_t index) {
    const nsdf_encoder_options *o = s->job->options;
    const slot *sl = &s->slots[index];
    const nsdf_sample_set *set = &s->job->samples[sl->frame];
    size_t count = o->batch_points < set->count ? o->batch_points : set->count;
    size_t from = (s->cursor[sl->frame] + (size_t)index * count) % (set->count - count + 1);
    nsdf_fit_points p = {set->x + from, set->y + from,
                         set->z + from, set->d + from,
                         count,         (float)((double)s->job->model->desc.time_scale * s->job->u[sl->frame])};
    return p;
}

static void add_extra(slot *sl, const nsdf_sample_set *set, uint32_t i) {
    sl->extra[0][sl->extra_count] = set->x[i];
    sl->extra[1][sl->extra_count] = set->y[i];
    sl->extra[2][sl->extra_count] = set->z[i];
    sl->extra[3][sl->extra_count++] = set->d[i];
}

/* A random choice of the frame's strays and tail. */
static void choose_extra(state *s, slot *sl) {
    const nsdf_sample_set *stray = &s->stray[sl->frame];
    const tail_ring *tail = &s->tail[sl->frame];
    sl->extra_count = 0;
    for (uint32_t i = 0; i < STRAY_POINTS && stray->count; i++)
        add_extra(sl, stray, nsdf_random_below(&s->random, (uint32_t)stray->count));
    for (uint32_t i = 0; i < TAIL_POINTS && tail->count; i++)
        add_extra(sl, &s->job->samples[sl->frame], tail->index[nsdf_random_below(&s->random, tail->count)]);
}

/* Notes which points of the batch, the first of them sample `from`, belong to the tail. */
static void find_worst(slot *sl, size_t from, size_t count) {
    double limit = (double)tail_factor * sl->sums.loss / (double)count;
    sl->worst_count = 0;
    for (size_t i = 0; i < count && sl->worst_count < TAIL_PER_BATCH; i++)
        if ((double)sl->losses[i] > limit)
            sl->worst[sl->worst_count++] = (uint32_t)(from + i);
}

static void run_slot(void *data, uint32_t index, uint32_t worker) {
    state *s = data;
    slot *sl = &s->slots[index];
    const nsdf_fit_job *job = s->job;
    nsdf_fit_points points = next_points(s, index);
    float scale = 1.0f / (float)((double)points.count * job->options->batch_frames);
    nsdf_model_compose(job->model, s->active, job->u[sl->frame], sl->composed);
    memset(sl->gradient, 0, job->model->composed_size * sizeof *sl->gradient);
    sl->sums = (nsdf_fit_sums){0, 0, 0};
    nsdf_fit_backward(job->model, s->kernels, s->scratch[worker], sl->composed, &points, &s->loss, scale, sl->gradient,
                      sl->losses, &sl->sums);
    if (job->options->hard_samples)
        find_worst(sl, (size_t)(points.d - job->samples[sl->frame].d), points.count);
    if (sl->extra_count == 0)
        return;
    nsdf_fit_points extra = {sl->extra[0], sl->extra[1], sl->extra[2], sl->extra[3], sl->extra_count, points.time};
    nsdf_fit_sums unused = {0, 0, 0};
    nsdf_fit_backward(job->model, s->kernels, s->scratch[worker], sl->composed, &extra, &s->loss, scale, sl->gradient,
                      NULL, &unused);
}

static void join_tail(tail_ring *tail, const slot *sl) {
    for (uint32_t i = 0; i < sl->worst_count; i++) {
        tail->index[tail->next] = sl->worst[i];
        tail->next = (tail->next + 1) % TAIL_SIZE;
        tail->count += tail->count < TAIL_SIZE;
    }
}

/* Gradients are added slot by slot, so that the sum does not depend on the threads. */
static void gather(state *s) {
    const nsdf_fit_job *job = s->job;
    double near = 0.0;
    uint64_t near_count = 0;
    memset(s->gradient, 0, job->model->parameter_count * sizeof *s->gradient);
    for (uint32_t i = 0; i < job->options->batch_frames; i++) {
        slot *sl = &s->slots[i];
        nsdf_model_scatter(job->model, s->active, job->u[sl->frame], sl->gradient, s->gradient);
        near += sl->sums.near_error;
        near_count += sl->sums.near_count;
        s->cursor[sl->frame] += job->options->batch_points;
        join_tail(&s->tail[sl->frame], sl);
    }
    if (near_count == 0)
        return;
    double mean = near / (double)near_count;
    s->near_error = s->near_error > 0.0 ? 0.99 * s->near_error + 0.01 * mean : mean;
}

/* As long as all is off by more than a sheet is thick, weighing signs would only move it. */
static float sign_weight(const nsdf_encoder_options *o, double near_error) {
    const int soon = o->loss_sign_error > 0.0 && !(near_error > 0.0 && near_error < o->loss_sign_error);
    return soon ? 1.0f : (float)o->loss_sign;
}

/* First the shape as a whole, then the surface. */
static float weight_distance(const nsdf_encoder_options *o, double near_error) {
    const double d0 = near_error > 0.0 ? fmax(least_d0, fmin(near_error, most_d0)) : most_d0;
    return (float)(o->loss_d0 > 0.0 ? o->loss_d0 : d0);
}

static int is_rounded(const nsdf_encoder_options *o) {
    return o->quantise_aware && o->weight_bits < 32.0;
}

/* Steps of the quantisers follow the values until these are rounded. */
static void add_rate(state *s, const float *parameters, int rounding) {
    const nsdf_encoder_options *o = s->job->options;
    const nsdf_quantise_params quantise = {o->weight_bits, 0};
    if (!is_rounded(o) || !(o->parameter_rate > 0.0))
        return;
    if (!rounding && s->result->steps % QUANTISER_STEPS == 0)
        nsdf_choose_quantisers(s->job->model, &quantise, parameters);
    nsdf_network_add_rate(s->job->model, parameters, s->rate_share * o->parameter_rate, s->gradient);
}

static void one_step(state *s, float *parameters, double rate, int rounding) {
    const nsdf_encoder_options *o = s->job->options;
    s->loss.sign = sign_weight(o, s->near_error);
    s->loss.d0 = weight_distance(o, s->near_error);
    s->active = parameters;
    if (rounding) {
        nsdf_round_parameters(s->job->model, parameters, s->rounded);
        s->active = s->rounded; /* straight-through: the gradient at the rounded values moves the fitted ones */
    }
    for (uint32_t i = 0; i < o->batch_frames; i++) {
        s->slots[i].frame = nsdf_frame_order_next(&s->order, &s->random);
        choose_extra(s, &s->slots[i]);
    }
    nsdf_workers_run(s->job->workers, o->batch_frames, run_slot, s);
    gather(s);
    add_rate(s, parameters, rounding);
    nsdf_muon_step(&s->muon, s->job->workers, parameters, s->gradient, rate);
    nsdf_adam_step(&s->adam, parameters, s->gradient, rate);
}

/* ---- The loop ------------------------------------------------------------------------------------------- */

static int report(const state *s, uint64_t done, nsdf_fit_result *result) {
    const nsdf_fit_job *job = s->job;
    double now = nsdf_clock(), spent = now - s->began, fraction = fmin(1.0, (double)done / (double)s->budget.steps);
    nsdf_progress p = {NSDF_STAGE_FIT,
                       fraction,
                       now - job->start_time,
                       s->near_error,
                       spent > 0.0 ? (double)result->samples / spent : 0.0,
                       fraction > 0.0 ? spent * (1.0 - fraction) / fraction : -1.0};
    int answer = job->progress ? job->progress(job->progress_user, &p) : NSDF_CONTINUE;
    result->aborted = answer == NSDF_ABORT;
    return answer;
}

static int all_finite(const float *values, uint64_t count) {
    for (uint64_t i = 0; i < count; i++)
        if (!isfinite(values[i]))
            return 0;
    return 1;
}

static void count_step(const state *s, nsdf_fit_result *result) {
    const nsdf_encoder_options *o = s->job->options;
    result->steps++;
    for (uint32_t i = 0; i < o->batch_frames; i++) {
        size_t count = s->job->samples[s->slots[i].frame].count;
        result->samples += o->batch_points < count ? o->batch_points : count;
    }
}

/* By the fastest kernels: a crossing that short factors move is no stray for that. */
static int find_strays(state *s, const float *parameters, uint32_t resolution, nsdf_fit_result *result) {
    const nsdf_fit_job *job = s->job;
    nsdf_stray_job search = {job->model,   s->fastest, s->scratch, parameters, job->frames,
                             job->u,       {0},        {0},        resolution, job->options->seed + s->searched++,
                             job->workers, s->stray};
    memcpy(search.domain_min, job->header->domain_min, sizeof search.domain_min);
    memcpy(search.domain_max, job->header->domain_max, sizeof search.domain_max);
    return nsdf_find_strays(&search, &result->strays);
}

/* The search that is due; one like it follows the last step. */
static int search(state *s, nsdf_fit_result *result) {
    const double began = nsdf_clock();
    const int failed = find_strays(s, s->active, searches[s->searched].resolution, result);
    const double spent = nsdf_clock() - began;
    nsdf_budget_pause(&s->budget, spent);
    s->budget.deadline -= s->budget.deadline > 0.0 ? spent : 0.0;
    return failed;
}

/* Leaves time for what follows, as it turns out now. */
static void try_rest(state *s) {
    const double began = nsdf_clock();
    if (s->tried || !s->job->try_rest || !(s->budget.deadline > 0.0))
        return;
    s->tried = 1;
    s->budget.deadline = s->job->try_rest(s->job->try_user);
    nsdf_budget_pause(&s->budget, nsdf_clock() - began);
}

/* The step, of `steps`, from which on the batch sees rounded parameters. */
static uint64_t rounding_start(const nsdf_encoder_options *o, uint64_t steps) {
    if (!is_rounded(o))
        return UINT64_MAX;
    return (uint64_t)((1.0 - quantise_aware_share) * (double)steps);
}

/* ---- Checkpoints ---------------------------------------------------------------------------------------- */

static void tail_fields(nsdf_fit_state *f, tail_ring *tail, size_t samples) {
    nsdf_state_u32(f, &tail->count);
    nsdf_state_u32(f, &tail->next);
    nsdf_state_expect(f, tail->count <= TAIL_SIZE && tail->next < TAIL_SIZE, "a tail that is too long");
    for (uint32_t i = 0; i < TAIL_SIZE; i++) {
        nsdf_state_u32(f, &tail->index[i]);
        nsdf_state_expect(f, tail->index[i] < samples, "a sample that there is not");
    }
}

static void frame_fields(state *s, nsdf_fit_state *f, uint32_t frame) {
    uint64_t cursor = s->cursor[frame];
    nsdf_state_u64(f, &cursor);
    s->cursor[frame] = (size_t)cursor;
    tail_fields(f, &s->tail[frame], s->job->samples[frame].count);
    if (nsdf_state_reading(f) && nsdf_stray_room(&s->stray[frame]) != 0)
        nsdf_cursor_fail(&f->in, NSDF_PARSE_NO_MEMORY, f->in.at, "out of memory");
    nsdf_state_samples(f, &s->stray[frame], NSDF_MOST_HARD);
}

/* All that later steps depend on; that is also where the last step was rounded to, since searches look there. */
static void state_fields(void *fitting, nsdf_fit_state *f) {
    state *s = fitting;
    nsdf_model *model = s->job->model;
    uint8_t rounding = s->active == s->rounded;
    nsdf_state_run(f, s->result, s->job->options->steps, &s->began, &s->near_error);
    nsdf_state_random(f, &s->random);
    nsdf_state_order(f, &s->order);
    nsdf_state_u32(f, &s->searched);
    nsdf_state_quantisers(f, &model->desc.list);
    nsdf_state_u8(f, &rounding);
    s->active = rounding ? s->rounded : s->parameters;
    nsdf_state_floats(f, s->rounded, rounding ? model->parameter_count : 0);
    nsdf_state_floats(f, s->parameters, model->parameter_count);
    nsdf_state_adam(f, &s->adam);
    for (uint32_t i = 0; i < s->muon.count; i++) {
        const nsdf_muon_matrix *m = &s->muon.matrices[i];
        nsdf_state_floats(f, m->momentum, (size_t)m->size * m->size);
    }
    for (uint32_t i = 0; i < s->job->frame_count; i++)
        frame_fields(s, f, i);
}

static int save(state *s) {
    return nsdf_checkpoint_save(s->job->checkpoint, s->result->steps, state_fields, s);
}

/* ---- Steps ---------------------------------------------------------------------------------------------- */

/* The main loop.  Returns the last answer of the progress callback, or -1 when memory ran out. */
static int fit_steps(state *s, float *parameters, nsdf_fit_result *result) {
    const nsdf_encoder_options *o = s->job->options;
    nsdf_quantise_params quantise = {o->weight_bits, 0};
    double reported = nsdf_clock();
    for (uint64_t step = result->steps; step < s->budget.steps; step++) {
        if ((double)step >= trial_at * (double)s->budget.steps)
            try_rest(s);
        const uint64_t steps = nsdf_budget_plan(&s->budget, step, nsdf_clock());
        const uint64_t rounding_from = rounding_start(o, steps);
        if (step >= rounding_from && s->active != s->rounded)
            nsdf_choose_quantisers(s->job->model, &quantise, parameters);
        if (o->hard_samples && s->searched < SEARCHES && step > 0 &&
            step >= (uint64_t)(searches[s->searched].at * (double)steps) && search(s, result) != 0)
            return -1;
        s->rate_share = fmin(1.0, (double)step / (rate_rise * (double)steps));
        s->kernels = (double)step < short_share * (double)steps ? s->fastest : s->exact;
        one_step(s, parameters, nsdf_rate_schedule(step, steps, o->learning_rate), step >= rounding_from);
        count_step(s, result);
        if (nsdf_checkpoint_due(s->job->checkpoint, step + 1 == s->budget.steps) && save(s) != 0)
            return -1;
        if (nsdf_clock() - reported < 0.1 && step + 1 < s->budget.steps)
            continue;
        reported = nsdf_clock();
        int answer = report(s, step + 1, result);
        if (answer != NSDF_CONTINUE)
            return save(s) != 0 ? -1 : answer;
    }
    return NSDF_CONTINUE;
}

/* A few more steps at a low rate.  Returns the answer of the progress callback. */
static int extra_steps(state *s, float *parameters, nsdf_fit_result *result) {
    const nsdf_encoder_options *o = s->job->options;
    uint64_t steps = 1 + (uint64_t)(repair_share * (double)s->budget.steps);
    s->rate_share = 1.0;
    s->kernels = s->exact;
    for (uint64_t step = 0; step < steps; step++) {
        one_step(s, parameters, nsdf_rate_schedule(step, steps, repair_rate * o->learning_rate),
                 rounding_start(o, 0) != UINT64_MAX);
        count_step(s, result);
    }
    return report(s, s->budget.steps, result);
}

/* Searches, and fits a little more while anything is found. */
static int repair(state *s, float *parameters, nsdf_fit_result *result) {
    int rounding = rounding_start(s->job->options, 0) != UINT64_MAX;
    for (int round = 0; round < REPAIR_ROUNDS; round++) {
        if (rounding)
            nsdf_round_parameters(s->job->model, parameters, s->rounded);
        if (find_strays(s, rounding ? s->rounded : parameters, REPAIR_RESOLUTION, result) != 0)
            return -1;
        if (result->strays == 0 || result->strays > (uint64_t)HOPELESS_STRAYS * s->job->frame_count)
            break;
        int answer = extra_steps(s, parameters, result);
        if (answer != NSDF_CONTINUE)
            return answer;
    }
    return NSDF_CONTINUE;
}

static int preload_strays(state *s, const nsdf_sample_set *strays) {
    for (uint32_t f = 0; f < s->job->frame_count; f++) {
        if (strays[f].count == 0)
            continue;
        if (nsdf_stray_room(&s->stray[f]) != 0)
            return -1;
        for (size_t i = 0; i < strays[f].count && s->stray[f].count < NSDF_MOST_HARD; i++) {
            size_t to = s->stray[f].count++;
            s->stray[f].x[to] = strays[f].x[i];
            s->stray[f].y[to] = strays[f].y[i];
            s->stray[f].z[to] = strays[f].z[i];
            s->stray[f].d[to] = strays[f].d[i];
        }
    }
    return 0;
}

int nsdf_fit_mend(const nsdf_fit_job *job, const nsdf_sample_set *strays, float *parameters, nsdf_fit_result *result) {
    state s;
    int failed = create_state(&s, job, parameters, result) != 0 || preload_strays(&s, strays) != 0;
    s.near_error = result->near_error;
    if (!failed)
        failed = find_strays(&s, parameters, REPAIR_RESOLUTION, result) != 0;
    if (!failed)
        (void)extra_steps(&s, parameters, result);
    result->near_error = s.near_error;
    result->diverged = !all_finite(parameters, job->model->parameter_count);
    free_state(&s);
    return failed ? -1 : 0;
}

int nsdf_fit_run(const nsdf_fit_job *job, float *parameters, nsdf_fit_result *result) {
    const nsdf_encoder_options *o = job->options;
    nsdf_quantise_params quantise = {o->weight_bits, 0};
    state s;
    memset(result, 0, sizeof *result);
    int answer = create_state(&s, job, parameters, result) == 0 ? NSDF_CONTINUE : -1;
    if (answer == NSDF_CONTINUE)
        answer = nsdf_checkpoint_begin(job->checkpoint, job, parameters, job->model->parameter_count, state_fields, &s);
    if (answer == NSDF_CONTINUE)
        answer = fit_steps(&s, parameters, result);
    if (answer == NSDF_CONTINUE && o->hard_samples)
        answer = repair(&s, parameters, result);
    result->near_error = s.near_error;
    result->diverged = !all_finite(parameters, job->model->parameter_count);
    /* Stopped before rounding began, or raw values: the quantisers are still to be chosen. */
    if (o->quantise_aware && result->steps <= rounding_start(o, s.budget.steps))
        nsdf_choose_quantisers(job->model, &quantise, parameters);
    free_state(&s);
    return answer < 0 ? -1 : 0;
}

#include "dataset.h"

#include "fit.h"
#include "motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Samples of a sequence together, when the number per frame is left to us; blocks, which start from the surface, need
 * fewer. */
static const double sample_budget = 4e6;
static const double fewest_samples = 8192, most_samples = 400000, most_samples_blocks = 48000;

typedef struct {
    const nsdf_dataset_job *job;
    nsdf_dataset *dataset;
    nsdf_sampler_params params;
    uint32_t first; /* frame of task 0 */
    uint8_t *fault; /* [frame] */
} context;

enum { FAULT_NONE, FAULT_NO_INSIDE, FAULT_NO_MEMORY };

void nsdf_dataset_free(nsdf_dataset *dataset) {
    for (uint32_t i = 0; dataset->sets && i < dataset->frame_count; i++)
        nsdf_sample_set_free(&dataset->sets[i]);
    free(dataset->sets);
    free(dataset->u);
    memset(dataset, 0, sizeof *dataset);
}

static uint32_t samples_per_frame(const nsdf_encoder_options *o, uint32_t frames) {
    if (o->samples_per_frame)
        return o->samples_per_frame;
    const double most = o->blocks > 0 ? most_samples_blocks : most_samples;
    const double n = sample_budget / (double)frames;
    return (uint32_t)(n < fewest_samples ? fewest_samples : n > most ? most : n);
}

int nsdf_has_inside(const nsdf_sample_set *set) {
    for (size_t i = 0; i < set->count; i++)
        if (set->d[i] < 0.0f)
            return 1;
    return 0;
}

static void sample_one(void *data, uint32_t index, uint32_t worker) {
    context *c = data;
    uint32_t i = c->first + index;
    nsdf_frame *frame = &c->job->frames->frames[i];
    const nsdf_encoder_options *o = c->job->options;
    (void)worker;
    c->fault[i] = FAULT_NO_MEMORY;
    nsdf_sdf *sdf = nsdf_frame_sdf(frame);
    if (!sdf)
        return;
    nsdf_random random = nsdf_random_start(o->seed, 1000 + (uint64_t)i);
    nsdf_sample_set *set = &c->dataset->sets[i];
    if (nsdf_sample_frame(sdf, nsdf_frame_outer(frame), &c->params, &random, set) == 0)
        c->fault[i] = nsdf_has_inside(set) ? FAULT_NONE : FAULT_NO_INSIDE;
    nsdf_sdf_free(sdf);
}

nsdf_status nsdf_no_inside(const nsdf_frame *frame, nsdf_encoder_error *error) {
    return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                             "frame %u has no inside: it is a sheet with %llu open edges; give it a thickness (shell)",
                             frame->number, (unsigned long long)frame->report.open_edges);
}

static nsdf_status check_frames(const context *c, uint32_t from, uint32_t to, nsdf_encoder_error *error) {
    for (uint32_t i = from; i < to; i++) {
        const nsdf_frame *f = &c->job->frames->frames[i];
        if (c->fault[i] == FAULT_NO_MEMORY)
            return nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory for samples of frame %u", f->number);
        if (c->fault[i] == FAULT_NO_INSIDE)
            return nsdf_no_inside(f, error);
    }
    return NSDF_OK;
}

static nsdf_status sample_all(context *c, nsdf_encoder_error *error) {
    const nsdf_dataset_job *job = c->job;
    uint32_t count = job->frames->count, stretch = 4 * nsdf_workers_count(job->workers);
    double began = nsdf_clock();
    for (uint32_t i = 0; i < count; i += stretch) {
        uint32_t n = count - i < stretch ? count - i : stretch;
        c->first = i;
        nsdf_workers_run(job->workers, n, sample_one, c);
        nsdf_status status = check_frames(c, i, i + n, error);
        if (status != NSDF_OK)
            return status;
        double done = (double)(i + n) / (double)count, spent = nsdf_clock() - began;
        nsdf_progress p = {NSDF_STAGE_SAMPLE,
                           NSDF_REPAIR_SHARE + (1.0 - NSDF_REPAIR_SHARE) * done,
                           nsdf_clock() - job->start_time,
                           0.0,
                           (double)(i + n) * (double)c->params.count / (spent > 0.0 ? spent : 1.0),
                           spent * (1.0 - done) / done};
        if (job->progress && job->progress(job->progress_user, &p) == NSDF_ABORT)
            return nsdf_encoder_fail(error, NSDF_CANCELLED, "cancelled");
    }
    return NSDF_OK;
}

/* Narrowest widths: what counts is where the field is 0.  Too few samples further off leave bubbles where parts touch.
 */
static const float block_noise[2] = {0.0005f, 0.006f};

/* Balls are to be filled to their borders, and what lies outside of them does not count. */
static void suit_blocks(nsdf_sampler_params *params, const nsdf_dataset_job *job) {
    const double area = nsdf_surface_area(&job->frames->frames[0].surface);
    const float radius = (float)nsdf_block_radius(job->options, area);
    params->noise[0] = block_noise[0];
    params->noise[1] = block_noise[1];
    params->noise[2] = fmaxf(0.5f * radius, 2.0f * params->noise[1]);
    params->noise_share[2] = 0.45f;
    params->frame_box_share = 0.04f;
    params->domain_share = 0.01f;
}

nsdf_status nsdf_dataset_create(nsdf_dataset *dataset, const nsdf_dataset_job *job, nsdf_encoder_error *error) {
    const nsdf_frames *frames = job->frames;
    uint32_t count = frames->count, last = frames->frames[count - 1].number, first = frames->frames[0].number;
    context c;
    memset(&c, 0, sizeof c);
    memset(dataset, 0, sizeof *dataset);
    c.job = job;
    c.dataset = dataset;
    nsdf_sampler_defaults(&c.params);
    c.params.kind = job->options->sampling == NSDF_SAMPLE_REJECTION ? NSDF_SAMPLER_REJECTION : NSDF_SAMPLER_NEAR;
    c.params.count = samples_per_frame(job->options, count);
    c.params.d_half = (float)job->options->d_half;
    if (job->options->blocks > 0)
        suit_blocks(&c.params, job);
    memcpy(c.params.domain_min, job->header->domain_min, sizeof c.params.domain_min);
    memcpy(c.params.domain_max, job->header->domain_max, sizeof c.params.domain_max);
    c.fault = calloc(count, 1);
    dataset->frame_count = count;
    dataset->sets = calloc(count, sizeof *dataset->sets);
    dataset->u = calloc(count, sizeof *dataset->u);
    nsdf_status status = NSDF_OK;
    if (!c.fault || !dataset->sets || !dataset->u)
        status = nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory for samples");
    for (uint32_t i = 0; status == NSDF_OK && i < count && last > first; i++)
        dataset->u[i] = (double)(frames->frames[i].number - first) / (double)(last - first);
    if (status == NSDF_OK)
        status = sample_all(&c, error);
    free(c.fault);
    if (status != NSDF_OK)
        nsdf_dataset_free(dataset);
    return status;
}

/* ---- Normalisations that need the samples --------------------------------------------------------------- */

/* Largest change of the distance at one place from a frame to the next (5.12).  The thesis compares each sample with
 * the nearest sample of the next frame; a grid of cells finds a near one, and the cell's size is taken off, since it
 * bounds what the difference of the two places adds. */
static double estimate_speed(const nsdf_sample_set *a, const nsdf_sample_set *b) {
    enum { CELLS = 32, TOTAL = CELLS * CELLS * CELLS };
    const float size = 1.1f / CELLS;
    uint32_t *cell = malloc(TOTAL * sizeof *cell);
    double most = 0.0;
    if (!cell)
        return 0.0;
    for (size_t i = 0; i < TOTAL; i++)
        cell[i] = UINT32_MAX;
    for (int pass = 0; pass < 2; pass++) {
        const nsdf_sample_set *s = pass ? a : b;
        for (size_t i = 0; i < s->count && i < UINT32_MAX; i++) {
            int x = (int)((s->x[i] + 0.55f) / size), y = (int)((s->y[i] + 0.55f) / size),
                z = (int)((s->z[i] + 0.55f) / size);
            if (x < 0 || y < 0 || z < 0 || x >= CELLS || y >= CELLS || z >= CELLS)
                continue;
            uint32_t *c = &cell[(x * CELLS + y) * CELLS + z];
            if (!pass)
                *c = (uint32_t)i;
            if (!pass || *c == UINT32_MAX)
                continue;
            double dx = (double)(s->x[i] - b->x[*c]), dy = (double)(s->y[i] - b->y[*c]),
                   dz = (double)(s->z[i] - b->z[*c]);
            double change = fabs((double)(s->d[i] - b->d[*c])) - sqrt(dx * dx + dy * dy + dz * dz);
            most = change > most ? change : most;
        }
    }
    free(cell);
    return most;
}

void nsdf_dataset_normalise(const nsdf_dataset *dataset, const nsdf_encoder_options *o, nsdf_network_desc *desc) {
    if (o->sdf_norm == NSDF_SDF_UNIT_RANGE) {
        float low = 0.0f, high = 0.0f;
        for (uint32_t f = 0; f < dataset->frame_count; f++)
            for (size_t i = 0; i < dataset->sets[f].count; i++) {
                low = fminf(low, dataset->sets[f].d[i]);
                high = fmaxf(high, dataset->sets[f].d[i]);
            }
        desc->value_scale = high > low ? 0.5f * (high - low) : 1.0f;
        desc->value_offset = 0.5f * (high + low);
    }
    if (o->time_norm != NSDF_TIME_SPEED || o->input == NSDF_MODEL_XYZ)
        return;
    double speed = 0.0;
    for (uint32_t f = 0; f + 1 < dataset->frame_count; f++)
        speed = fmax(speed, estimate_speed(&dataset->sets[f], &dataset->sets[f + 1]));
    desc->time_scale = speed > 1e-3 ? (float)(1.0 / speed) : 1000.0f;
}

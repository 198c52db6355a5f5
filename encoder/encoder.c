#include "nsdf/encoder.h"

#include "block_mend.h"
#include "block_stage.h"
#include "bound.h"
#include "check_time.h"
#include "checkpoint.h"
#include "container.h"
#include "dataset.h"
#include "encoder_options.h"
#include "fit.h"
#include "frames_repair.h"
#include "rate_blocks.h"
#include "rate_control.h"
#include "rate_network.h"
#include "verify_segment.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const float largest_speck = 0.125f;

/* Share of every frame's surface that has to lie in blocks, or else the model is the network. */
static const double least_cover = 0.85;

/* Of a file whose surface is lost in some frames; an empty frame has 1. */
static const double lost_error = 0.02;

/* Within a time that was asked for, verification takes about this part of it, and looks at so many frames at least. */
static const double verified_share = 0.12;
enum { least_frames = 12 };
static const double more_rounds = 1.3; /* of raising the bound, for some frames in place of a few */

/* While verification finds stray pieces, fitting goes on a little, so many times at the most. */
enum { MEND_ROUNDS = 3 };
/* As a factor: no worse; and what it may cost to halve the number of stray pieces. */
static const double same_error = 1.01, about_same_error = 1.03;

struct nsdf_encoder {
    nsdf_encoder_options options;
    nsdf_frames frames;
    nsdf_frames shown; /* those of them that the file's time reaches; borrowed, made by the run */
    int ran;           /* run was called */
    nsdf_buffer file;
    nsdf_encoder_stats stats;
    /* The fitted network, for nsdf_encoder_recode. */
    nsdf_file_header header;
    nsdf_index_entry entry; /* lead, trail and smallest_piece */
    nsdf_model model;
    float *parameters;
    nsdf_block_model blocks; /* instead of the network, if it has values */
    /* What was measured last, and the hash of the decoded parameters that it was measured with. */
    int measured;
    uint64_t measured_hash;
    float measured_piece; /* entry.smallest_piece then */
    nsdf_quality_record quality;
    nsdf_checkpoint checkpoint; /* of the main fit, but not of a network that follows blocks */
};

/* What the stages of one run share. */
typedef struct {
    nsdf_encoder *encoder;
    nsdf_progress_fn progress;
    void *user;
    nsdf_encoder_error *error;
    nsdf_workers *workers;
    nsdf_dataset dataset;
    nsdf_fit_result fit;
    nsdf_tracked tracked; /* the surface, if the model is blocks */
    int is_tracked;
    double seconds_track, seconds_check; /* following the surface; coding and verifying, the last time */
    nsdf_sample_set *strays;             /* [frame]: what verification found */
    nsdf_coded_segment segment;
    uint32_t verified;             /* frames that verification looks at; 0 = all */
    uint64_t size;                 /* asked for, 0 = none */
    nsdf_rate_blocks *rate_blocks; /* with a target, one of the two */
    nsdf_rate_network *rate_network;
    double start;
} run;

nsdf_status nsdf_encoder_create(nsdf_encoder **encoder, const nsdf_encoder_options *options,
                                nsdf_encoder_error *error) {
    if (!encoder)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    nsdf_encoder_options defaults;
    nsdf_encoder_options_init(&defaults, NSDF_PRESET_MEDIUM);
    if (!options)
        options = &defaults;
    nsdf_status status = nsdf_encoder_options_check(options, error);
    if (status != NSDF_OK)
        return status;
    nsdf_encoder *e = calloc(1, sizeof *e);
    if (!e)
        return nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory");
    e->options = *options;
    *encoder = e;
    return NSDF_OK;
}

void nsdf_encoder_close(nsdf_encoder **encoder) {
    if (!encoder || !*encoder)
        return;
    nsdf_frames_free(&(*encoder)->frames);
    nsdf_buffer_free(&(*encoder)->file);
    nsdf_block_model_free(&(*encoder)->blocks);
    nsdf_checkpoint_free(&(*encoder)->checkpoint);
    free((*encoder)->parameters);
    free(*encoder);
    *encoder = NULL;
}

nsdf_status nsdf_encoder_add_frame(nsdf_encoder *encoder, uint32_t frame, const nsdf_input_mesh *mesh,
                                   nsdf_encoder_error *error) {
    if (!encoder || !mesh)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    if (encoder->ran)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "frames cannot be added after a run");
    if (encoder->checkpoint.resumed.data)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "frames cannot be added after a checkpoint");
    return nsdf_frames_add(&encoder->frames, frame, mesh, error);
}

nsdf_status nsdf_encoder_set_checkpoint(nsdf_encoder *encoder, double seconds, nsdf_checkpoint_fn save, void *user,
                                        nsdf_encoder_error *error) {
    if (!encoder)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    if (encoder->ran)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "checkpoints cannot be asked for after a run");
    if (!(seconds >= 0.0))
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "%g seconds between checkpoints, expected 0 or more",
                                 seconds);
    const nsdf_encoder_options *o = &encoder->options;
    if (o->target_size > 0 || o->target_bitrate > 0.0 || o->target_error > 0.0 || o->time_budget > 0.0)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                                 "checkpoints are not made of fits to a size, a bitrate, an error or a time");
    encoder->checkpoint.save = save;
    encoder->checkpoint.user = user;
    encoder->checkpoint.seconds = seconds;
    return NSDF_OK;
}

nsdf_status nsdf_encoder_resume(nsdf_encoder *encoder, const void *data, size_t size, uint64_t *steps,
                                nsdf_encoder_error *error) {
    if (!encoder || !data)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    if (encoder->ran)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a run cannot go on from a checkpoint after it began");
    return nsdf_checkpoint_open(&encoder->checkpoint, data, size, &encoder->options, &encoder->frames, steps, error);
}

static uint32_t nominal_frames(const nsdf_frames *frames) {
    return frames->frames[frames->count - 1].number - frames->frames[0].number + 1;
}

nsdf_status nsdf_encoder_set_part(nsdf_encoder *encoder, const nsdf_sequence_part *part, nsdf_encoder_error *error) {
    if (!encoder || !part)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    const nsdf_frames *frames = &encoder->frames;
    if (encoder->ran || encoder->checkpoint.resumed.data || frames->count == 0)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                                 "what part of a sequence it is has to be said once all frames are added, and before "
                                 "a checkpoint or a run");
    const uint64_t reach = (uint64_t)part->lead + part->trail;
    const uint32_t first = frames->frames[0].number, last = frames->frames[frames->count - 1].number;
    if (reach > last - first || part->lead > INT32_MAX || part->trail > INT32_MAX)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "lead %u and trail %u leave none of %u frames",
                                 part->lead, part->trail, nominal_frames(frames));
    if (nsdf_frames_find(frames, first + part->lead) == frames->count ||
        nsdf_frames_find(frames, last - part->trail) == frames->count)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                                 "frames %u and %u, between which the part lies, have to be added", first + part->lead,
                                 last - part->trail);
    const nsdf_status status = nsdf_frames_set_box(&encoder->frames, part->box_min, part->box_max, error);
    if (status == NSDF_OK) {
        encoder->entry.lead = (int32_t)part->lead;
        encoder->entry.trail = (int32_t)part->trail;
    }
    return status;
}

/* ---- Stages --------------------------------------------------------------------------------------------- */

static uint64_t asked_size(const nsdf_encoder *e) {
    const nsdf_encoder_options *o = &e->options;
    const uint32_t gaps = e->header.frame_count > 1 ? e->header.frame_count - 1 : 1;
    const double seconds = (double)gaps * o->rate_den / o->rate_num;
    return o->target_bitrate > 0.0 ? (uint64_t)(o->target_bitrate * 125.0 * seconds) : o->target_size;
}

/* The frames without those that belong to other parts of the sequence. */
static nsdf_frames shown_frames(const nsdf_encoder *e) {
    nsdf_frames shown = e->frames;
    const uint32_t first = e->frames.frames[0].number + (uint32_t)e->entry.lead;
    const uint32_t last = e->frames.frames[e->frames.count - 1].number - (uint32_t)e->entry.trail;
    const uint32_t from = nsdf_frames_find(&e->frames, first);
    shown.frames += from;
    shown.count = nsdf_frames_find(&e->frames, last) - from + 1;
    return shown;
}

/* Makes the frames boundaries of bodies, and settles the options that depend on what they are. */
static nsdf_status repair(run *r) {
    nsdf_encoder *e = r->encoder;
    const nsdf_repair_job job = {&e->frames, &e->options, &e->header, r->workers, r->progress, r->user, r->start};
    const nsdf_status status = nsdf_frames_repair(&job, &e->stats.input, r->error);
    if (status == NSDF_OK)
        nsdf_suit_sheets(&e->options, &e->stats.input, &e->header);
    return status;
}

static int uses_blocks(const run *r) {
    const nsdf_encoder *e = r->encoder;
    return e->options.blocks > 0;
}

/* When fitting should end for the run to take its time.  What follows it takes 1.3 times as long as sampling did, of
 * networks twice as long, without verification less. */
static double fit_deadline(const run *r) {
    const nsdf_encoder *e = r->encoder;
    const double reserve = (!e->options.verify ? 0.7 : uses_blocks(r) ? 1.3 : 2.0) * e->stats.seconds_sample;
    return e->options.time_budget > 0.0 ? r->start + e->options.time_budget - reserve : 0.0;
}

static nsdf_fit_job fit_job(run *r) {
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

/* Follows the surface, and takes the network where blocks would leave much of a frame bare: they cannot follow what
 * grows out of all proportion. */
static nsdf_status suit_motion(run *r) {
    nsdf_encoder *e = r->encoder;
    const nsdf_fit_job job = fit_job(r);
    const double began = nsdf_clock();
    double cover = 0.0;
    if (!uses_blocks(r))
        return NSDF_OK;
    r->is_tracked = nsdf_track_surface(&job, &r->tracked) == 0;
    if (!r->is_tracked || nsdf_find_block_cover(&job, &r->tracked, &cover) != 0)
        return nsdf_encoder_fail(r->error, NSDF_NO_MEMORY, "out of memory while following the surface");
    e->stats.unfollowed = cover < least_cover;
    if (e->stats.unfollowed)
        e->options.blocks = 0;
    r->seconds_track = nsdf_clock() - began;
    return NSDF_OK;
}

static nsdf_status prepare(run *r) {
    nsdf_encoder_options *o = &r->encoder->options;
    nsdf_frames *frames = &r->encoder->frames;
    nsdf_file_header *h = &r->encoder->header;
    nsdf_model *model = &r->encoder->model;
    const double margin = NSDF_DOMAIN_MARGIN + nsdf_shell_margin(o, frames);
    nsdf_status status = nsdf_frames_normalise(frames, margin, h, r->error);
    h->rate_num = o->rate_num;
    h->rate_den = o->rate_den;
    r->encoder->shown = shown_frames(r->encoder);
    h->frame_count = nominal_frames(&r->encoder->shown);
    h->segment_count = 1;
    h->extraction_bound = (float)NSDF_HIGHEST_BOUND; /* until it is measured */
    r->size = asked_size(r->encoder);
    r->workers = nsdf_workers_create(o->threads);
    if (status == NSDF_OK && r->workers)
        status = repair(r);
    if (status == NSDF_OK && r->workers)
        status = suit_motion(r);
    h->default_resolution = o->resolution;
    nsdf_model_describe(model, o, frames->count);
    if (status == NSDF_OK && model->parameter_count > NSDF_MAX_PARAMETERS)
        return nsdf_encoder_fail(r->error, NSDF_LIMIT, "the model has %llu parameters, at most %llu are allowed",
                                 (unsigned long long)model->parameter_count, (unsigned long long)NSDF_MAX_PARAMETERS);
    r->strays = calloc(frames->count, sizeof *r->strays);
    r->encoder->parameters = malloc(model->parameter_count * sizeof(float));
    if (status == NSDF_OK && (!r->workers || !r->encoder->parameters || !r->strays))
        return nsdf_encoder_fail(r->error, NSDF_NO_MEMORY, "out of memory");
    return status;
}

static nsdf_status sample(run *r) {
    nsdf_frames *frames = &r->encoder->frames;
    nsdf_dataset_job job = {frames,  &r->encoder->options, &r->encoder->header, r->workers, r->progress, r->user,
                            r->start};
    nsdf_status status = nsdf_dataset_create(&r->dataset, &job, r->error);
    if (status != NSDF_OK)
        return status;
    nsdf_dataset_normalise(&r->dataset, &r->encoder->options, &r->encoder->model.desc);
    return NSDF_OK;
}

/* Whether fitting, or more of it, came to a usable end. */
static nsdf_status fitted(run *r, int failed) {
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

/* Half of the input's smallest piece, so that decoded ones may be smaller, but not so large that a piece that a coarse
 * grid cuts off would go. */
static float smallest_piece(const run *r) {
    const double asked = r->encoder->options.smallest_piece;
    return asked < 0.0 ? fminf(0.5f * nsdf_frames_smallest_piece(&r->encoder->frames), largest_speck) : (float)asked;
}

static int has_target(const run *r) {
    return r->size > 0 || r->encoder->options.target_error > 0.0;
}

static nsdf_status fit_to_target(run *r) {
    nsdf_encoder *e = r->encoder;
    nsdf_rate_job job = {fit_job(r), r->size, &e->shown, e->entry, &e->stats};
    nsdf_status status = NSDF_NO_MEMORY;
    job.entry.smallest_piece = smallest_piece(r);
    if (uses_blocks(r))
        r->rate_blocks = nsdf_rate_blocks_create(&job);
    else
        r->rate_network = nsdf_rate_network_create(&job, &r->dataset, &e->parameters);
    if (r->rate_blocks)
        status = nsdf_rate_blocks_fit(r->rate_blocks, &e->blocks, &r->fit, r->error);
    else if (r->rate_network)
        status = nsdf_rate_network_fit(r->rate_network, &r->fit, r->error);
    else
        return nsdf_encoder_fail(r->error, NSDF_NO_MEMORY, "out of memory");
    return status == NSDF_OK ? fitted(r, 0) : status;
}

static nsdf_status code(run *r) {
    const nsdf_encoder_options *o = &r->encoder->options;
    nsdf_quantise_params quantise = {o->weight_bits, 1};
    r->segment.payload.size = 0;
    r->encoder->entry.smallest_piece = smallest_piece(r);
    if (r->encoder->blocks.values) {
        if (nsdf_code_blocks(&r->encoder->blocks, &r->segment) == 0 &&
            nsdf_assemble_file(&r->encoder->header, &r->encoder->entry, &r->segment, NULL, &r->encoder->file) == 0)
            return NSDF_OK;
        return nsdf_encoder_fail(r->error, NSDF_INTERNAL, "the blocks cannot be coded");
    }
    if (!o->quantise_aware)
        nsdf_choose_quantisers(&r->encoder->model, &quantise, r->encoder->parameters);
    if (nsdf_code_segment(&r->encoder->model, r->encoder->parameters, &r->segment) != 0 ||
        nsdf_assemble_file(&r->encoder->header, &r->encoder->entry, &r->segment, NULL, &r->encoder->file) != 0)
        return nsdf_encoder_fail(r->error, NSDF_INTERNAL, "the parameters cannot be coded");
    return NSDF_OK;
}

/* When fitting a network should end, once it has a surface to time the check of.  Verification gets a part of the time
 * only: where it would need more, some of the frames stand for all. */
static double deadline_by_trial(void *user) {
    run *r = user;
    nsdf_encoder *e = r->encoder;
    const nsdf_check_job job = {&e->shown, &e->header, &e->options, NULL, NULL, r->start, &e->frames};
    const nsdf_quantise_params quantise = {e->options.weight_bits, 1};
    const double budget = e->options.time_budget;
    const uint32_t frames = e->shown.count;
    nsdf_encoder_error ignored; /* what fails here will fail again, and then be told */
    nsdf_check_time seconds = {0.0, 0.0};
    nsdf_choose_quantisers(&e->model, &quantise, e->parameters);
    if (code(r) != NSDF_OK || nsdf_time_check(&job, r->workers, &r->segment, &e->entry, &seconds, &ignored) != NSDF_OK)
        return fit_deadline(r);
    const double room = fmax(verified_share * budget / fmax(seconds.verify, 1e-9), (double)least_frames);
    r->verified = room < (double)frames ? (uint32_t)room : frames;
    return r->start + budget - more_rounds * seconds.bound * nsdf_bound_work(&job) - seconds.verify * r->verified;
}

/* checkpoint: NULL for none. */
static nsdf_status fit(run *r, nsdf_checkpoint *checkpoint) {
    if (has_target(r))
        return fit_to_target(r);
    nsdf_fit_job job = fit_job(r);
    job.checkpoint = checkpoint;
    if (uses_blocks(r))
        return fitted(r, nsdf_fit_blocks(&job, &r->encoder->blocks, &r->fit));
    job.try_rest = deadline_by_trial;
    job.try_user = r;
    nsdf_random random = nsdf_random_start(r->encoder->options.seed, 1);
    nsdf_model_initialise(&r->encoder->model, &random, r->encoder->parameters);
    return fitted(r, nsdf_fit_run(&job, r->encoder->parameters, &r->fit));
}

static void copy_quality(const nsdf_quality_record *q, nsdf_quality *out) {
    nsdf_quality public = {q->mean[0], q->mean[1], q->rms[0],     q->rms[1],
                           q->max[0],  q->max[1],  q->resolution, q->frames};
    *out = public;
}

static nsdf_status assemble(run *r, const nsdf_quality_record *quality) {
    nsdf_encoder *e = r->encoder;
    if (nsdf_assemble_file(&e->header, &e->entry, &r->segment, quality, &e->file) != 0)
        return nsdf_encoder_fail(r->error, NSDF_NO_MEMORY, "out of memory");
    return NSDF_OK;
}

static void forget_strays(run *r) {
    for (uint32_t i = 0; r->strays && i < r->encoder->frames.count; i++)
        nsdf_sample_set_free(&r->strays[i]);
    if (r->strays)
        memset(r->strays, 0, r->encoder->frames.count * sizeof *r->strays);
}

/* Verification extracts blocks with at least this bound, which finds small pieces that the file's might leave out; the
 * file gets the bound that they need, and a little more for resolutions that were not tried. */
static const double least_verified = 2.0, bound_margin = 1.05;

/* Verifies all frames that are shown, or some that stand for them. */
static nsdf_status verify_frames(run *r, const nsdf_check_job *job, nsdf_piece_report *pieces) {
    nsdf_encoder *e = r->encoder;
    const uint32_t count = r->verified ? r->verified : e->shown.count;
    nsdf_sample_set *strays = calloc(count, sizeof *strays);
    nsdf_check_part part;
    nsdf_status status = NSDF_NO_MEMORY;
    if (nsdf_check_part_pick(&part, job, count) == 0 && strays) {
        status =
            nsdf_verify_segment(&part.job, r->workers, &r->segment, &e->entry, &e->quality, pieces, strays, r->error);
    } else {
        (void)nsdf_encoder_fail(r->error, status, "out of memory");
    }
    forget_strays(r);
    for (uint32_t i = 0; strays && i < part.frames.count; i++)
        r->strays[nsdf_frames_find(&e->frames, part.frames.frames[i].number)] = strays[i];
    free(strays);
    nsdf_check_part_free(&part);
    return status;
}

static nsdf_status verify(run *r, const nsdf_check_job *job) {
    nsdf_encoder *e = r->encoder;
    const double bound = (double)e->header.extraction_bound;
    nsdf_piece_report pieces;
    if (e->blocks.values)
        e->header.extraction_bound = (float)fmax(bound, least_verified);
    const nsdf_status status = verify_frames(r, job, &pieces);
    if (status == NSDF_OK) {
        e->stats.stray_pieces = pieces.stray;
        e->header.extraction_bound = (float)fmax(bound, fmin(bound_margin * pieces.bound, NSDF_HIGHEST_BOUND));
    }
    return status;
}

/* Finds the bound and, when verifying, the error. */
static nsdf_status measure(run *r, double *seconds_bound) {
    nsdf_encoder *e = r->encoder;
    nsdf_check_job job = {&e->shown, &e->header, &e->options, r->progress, r->user, r->start, &e->frames};
    double began = nsdf_clock();
    nsdf_status status =
        nsdf_measure_bound(&job, &e->file, e->blocks.values != NULL, &e->header.extraction_bound, r->error);
    *seconds_bound = nsdf_clock() - began;
    if (status == NSDF_OK)
        status = e->options.verify ? verify(r, &job) : assemble(r, NULL);
    e->stats.bound = (double)e->header.extraction_bound;
    e->measured = status == NSDF_OK;
    e->measured_hash = r->segment.hash;
    e->measured_piece = e->entry.smallest_piece;
    return status;
}

/* Another coding of the same parameters needs no measuring. */
static nsdf_status check(run *r, double *seconds_bound) {
    nsdf_encoder *e = r->encoder;
    nsdf_status status = NSDF_OK;
    if (!e->measured || e->measured_hash != r->segment.hash)
        status = measure(r, seconds_bound);
    else
        e->entry.smallest_piece = e->measured_piece;
    if (status == NSDF_OK && e->options.verify) {
        copy_quality(&e->quality, &e->stats.quality);
        status = assemble(r, &e->quality);
    }
    return status;
}

static nsdf_status code_and_check(run *r) {
    nsdf_encoder_stats *stats = &r->encoder->stats;
    double began = nsdf_clock(), bound = 0.0;
    nsdf_status status = code(r);
    double coded = nsdf_clock() - began;
    began = nsdf_clock();
    if (status == NSDF_OK)
        status = check(r, &bound);
    const double checked = nsdf_clock() - began;
    stats->seconds_code += coded + bound;
    stats->seconds_verify += checked - bound;
    r->seconds_check = coded + checked;
    return status;
}

static int mend_blocks(run *r) {
    const nsdf_fit_control control = {1, NULL, NULL};
    nsdf_encoder_options o = nsdf_block_options(&r->encoder->options, r->encoder->frames.count);
    nsdf_fit_result some;
    nsdf_fit_job job = fit_job(r);
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

/* Fits a little more where verification found stray pieces, and checks again. */
static nsdf_status mend(run *r) {
    nsdf_encoder_stats *stats = &r->encoder->stats;
    nsdf_fit_job job = fit_job(r);
    double began = nsdf_clock();
    nsdf_status status =
        fitted(r, r->encoder->blocks.values ? mend_blocks(r)
                                            : nsdf_fit_mend(&job, r->strays, r->encoder->parameters, &r->fit));
    if (status == NSDF_OK && r->rate_network)
        status = nsdf_rate_network_requantise(r->rate_network, r->error);
    stats->seconds_fit += nsdf_clock() - began;
    forget_strays(r);
    return status == NSDF_OK ? code_and_check(r) : status;
}

/* Whether the time that was asked for, if any, has room for a round of mending: most of one is coding and checking. */
static int has_time(const run *r) {
    const double budget = r->encoder->options.time_budget;
    return !(budget > 0.0) || nsdf_clock() + r->seconds_check < r->start + budget;
}

/* More than a stray piece a frame says that a network is too small or fitted too briefly, which mending cannot mend.
 * Small models of blocks have some that it does. */
static int worth_mending(const run *r) {
    const nsdf_encoder *e = r->encoder;
    const nsdf_quality *q = &e->stats.quality;
    const uint32_t pieces = e->stats.stray_pieces, a_frame = e->blocks.values ? 4 : 1;
    if (!e->options.hard_samples || !e->options.verify || pieces > a_frame * e->frames.count + 8 || !has_time(r))
        return 0;
    if (!e->blocks.values)
        return pieces > 0;
    return !has_target(r) && (pieces > 0 || q->mean_to_input > NSDF_ASTRAY * q->mean_to_decoded);
}

/* Goes on after verification until the target is met, or nothing helps. */
static nsdf_status pursue_target(run *r) {
    nsdf_encoder *e = r->encoder;
    nsdf_status status = NSDF_OK;
    for (int again = has_target(r); again && status == NSDF_OK;) {
        const double began = nsdf_clock();
        const nsdf_quality *q = &e->stats.quality;
        if (r->rate_blocks)
            status = nsdf_rate_blocks_judge(r->rate_blocks, &e->blocks, &r->fit, q, r->strays, &again, r->error);
        else
            status = nsdf_rate_network_judge(r->rate_network, &r->fit, q, &again, r->error);
        e->stats.seconds_fit += nsdf_clock() - began;
        forget_strays(r);
        if (status == NSDF_OK)
            status = fitted(r, 0);
        if (status == NSDF_OK && again)
            status = code_and_check(r);
    }
    return status;
}

static int target_met(const run *r) {
    const nsdf_encoder *e = r->encoder;
    const nsdf_encoder_options *o = &e->options;
    if (r->size > 0)
        return nsdf_rate_size_met(e->file.size, r->size);
    return !(o->target_error > 0.0) || nsdf_mean_error(&e->stats.quality) <= o->target_error;
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
static int keep_better(run *r, nsdf_encoder *kept, nsdf_status status) {
    nsdf_encoder *e = r->encoder;
    if (status == NSDF_OK && is_better(&e->stats, &kept->stats)) {
        nsdf_buffer_free(&kept->file);
        nsdf_block_model_free(&kept->blocks);
        free(kept->parameters);
        return 1;
    }
    take_back(e, kept);
    forget_strays(r);
    return 0;
}

/* A copy of the model that was set aside, to be mended. */
static int copy_model(nsdf_encoder *e, const nsdf_encoder *kept) {
    const size_t size = kept->model.parameter_count * sizeof *kept->parameters;
    e->parameters = malloc(size);
    if (!e->parameters)
        return -1;
    memcpy(e->parameters, kept->parameters, size);
    return kept->blocks.values ? nsdf_block_model_copy(&e->blocks, &kept->blocks) : 0;
}

/* With a target, rate control judges. */
static nsdf_status mend_better(run *r, int *better) {
    nsdf_encoder *e = r->encoder;
    *better = 1;
    if (has_target(r))
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
static nsdf_status mend_all(run *r, int whole) {
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

static nsdf_status fit_network_instead(run *r) {
    nsdf_encoder *e = r->encoder;
    double began = nsdf_clock();
    e->options.blocks = 0;
    e->measured = 0;
    e->header.extraction_bound = (float)NSDF_HIGHEST_BOUND; /* until it is measured */
    forget_strays(r);
    nsdf_dataset_free(&r->dataset);
    nsdf_status status = sample(r);
    e->stats.seconds_sample += nsdf_clock() - began;
    began = nsdf_clock();
    if (status == NSDF_OK)
        status = fit(r, NULL);
    e->stats.seconds_fit += nsdf_clock() - began;
    const int whole = r->fit.steps >= e->options.steps;
    if (status == NSDF_OK)
        status = code_and_check(r);
    return status == NSDF_OK ? mend_all(r, whole) : status;
}

/* Where blocks come apart, as they do where drops fly off and fall back, a network is fitted too, and the better of the
 * two is the result. */
static nsdf_status try_network(run *r, int whole) {
    nsdf_encoder *e = r->encoder;
    if (!whole || has_target(r) || !e->options.verify || !come_apart(e))
        return NSDF_OK;
    nsdf_encoder kept = set_aside(e);
    e->parameters = malloc(e->model.parameter_count * sizeof *e->parameters);
    const nsdf_status status =
        e->parameters ? fit_network_instead(r) : nsdf_encoder_fail(r->error, NSDF_NO_MEMORY, "out of memory");
    if (keep_better(r, &kept, status))
        e->stats.came_apart = 1;
    return status;
}

static nsdf_status run_stages(run *r) {
    nsdf_encoder *e = r->encoder;
    double began = nsdf_clock();
    nsdf_status status = prepare(r);
    if (status == NSDF_OK)
        status = sample(r);
    e->stats.seconds_sample = nsdf_clock() - began - r->seconds_track;
    began = nsdf_clock();
    if (status == NSDF_OK)
        status = fit(r, &e->checkpoint);
    e->stats.seconds_fit = nsdf_clock() - began + r->seconds_track;
    const nsdf_encoder_options blocks = nsdf_block_options(&e->options, e->frames.count);
    const uint64_t steps = uses_blocks(r) ? blocks.steps : e->options.steps;
    const int timed = e->options.time_budget > 0.0, whole = r->fit.steps >= steps;
    if (status == NSDF_OK)
        status = code_and_check(r);
    if (status == NSDF_OK)
        status = mend_all(r, timed || whole);
    if (status == NSDF_OK)
        status = try_network(r, !timed && whole);
    return status == NSDF_OK ? pursue_target(r) : status;
}

/* Frees what stages share; without success there is no file. */
static void end_run(run *r, nsdf_status status) {
    nsdf_encoder *e = r->encoder;
    if (status != NSDF_OK)
        e->file.size = 0;
    e->stats.file_size = e->file.size;
    e->stats.target_met = target_met(r);
    nsdf_rate_blocks_free(r->rate_blocks);
    nsdf_rate_network_free(r->rate_network);
    nsdf_dataset_free(&r->dataset);
    if (r->is_tracked)
        nsdf_nodes_free(&r->tracked.nodes);
    forget_strays(r);
    free(r->strays);
    nsdf_workers_free(r->workers);
    nsdf_buffer_free(&r->segment.payload);
}

nsdf_status nsdf_encoder_run(nsdf_encoder *encoder, nsdf_progress_fn progress, void *user, nsdf_encoder_error *error) {
    if (!encoder)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    if (encoder->ran)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "an encoder runs once");
    if (encoder->frames.count == 0)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "no frames were added");
    run r = {.encoder = encoder, .progress = progress, .user = user, .error = error, .start = nsdf_clock()};
    encoder->ran = 1;
    nsdf_status status = NSDF_OK;
    if (nsdf_checkpoint_prepare(&encoder->checkpoint, &encoder->options, &encoder->frames) != 0)
        status = nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory for checkpoints");
    else
        status = run_stages(&r);
    nsdf_encoder_stats *stats = &encoder->stats;
    stats->frames = encoder->shown.count;
    stats->nominal_frames = encoder->header.frame_count;
    stats->triangles = encoder->frames.triangles;
    stats->diagonal = encoder->header.scale;
    stats->blocks = encoder->blocks.desc.block_count;
    stats->bones = encoder->blocks.desc.bone_count;
    stats->parameters = encoder->blocks.values ? encoder->blocks.value_count : encoder->model.parameter_count;
    if (status == NSDF_OK && encoder->blocks.values && nsdf_weigh_blocks(&encoder->blocks, &stats->block_bytes) != 0)
        status = nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory");
    end_run(&r, status);
    return status;
}

/* Codes and checks the fitted network as the options say now. */
static nsdf_status recode(run *r) {
    nsdf_encoder *e = r->encoder;
    nsdf_status status = NSDF_OK;
    r->workers = nsdf_workers_create(e->options.threads);
    r->strays = calloc(e->frames.count, sizeof *r->strays);
    if (!r->workers || !r->strays)
        status = nsdf_encoder_fail(r->error, NSDF_NO_MEMORY, "out of memory");
    if (status == NSDF_OK)
        status = code_and_check(r);
    end_run(r, status);
    return status;
}

nsdf_status nsdf_encoder_recode(nsdf_encoder *encoder, double weight_bits, nsdf_entropy_coder entropy,
                                nsdf_progress_fn progress, void *user, nsdf_encoder_error *error) {
    if (!encoder)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    if (encoder->file.size == 0)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "nothing was encoded");
    const nsdf_encoder_options given = encoder->options;
    const nsdf_model fitted_model = encoder->model;
    nsdf_encoder_options options = given;
    nsdf_quantise_params quantise = {weight_bits, 0};
    options.weight_bits = weight_bits;
    options.entropy = entropy;
    options.target_size = 0; /* of the first coding */
    options.target_bitrate = options.target_error = 0.0;
    nsdf_status status = nsdf_encoder_options_check(&options, error);
    if (status != NSDF_OK)
        return status;
    run r = {.encoder = encoder, .progress = progress, .user = user, .error = error, .start = nsdf_clock()};
    encoder->options = options;
    encoder->model.desc.list.entropy = (uint8_t)entropy;
    encoder->blocks.desc.list.entropy = (uint8_t)entropy;
    /* Fitting chose those of its own number of bits; code() chooses the others. */
    if (!encoder->blocks.values && options.quantise_aware && weight_bits != given.weight_bits)
        nsdf_choose_quantisers(&encoder->model, &quantise, encoder->parameters);
    status = recode(&r);
    encoder->options = given;
    encoder->model = fitted_model;
    encoder->blocks.desc.list.entropy = (uint8_t)given.entropy;
    return status;
}

nsdf_status nsdf_encoder_write(nsdf_encoder *encoder, int (*write)(void *user, const void *data, size_t size),
                               void *user, nsdf_encoder_error *error) {
    if (!encoder || !write)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    if (encoder->file.size == 0)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "nothing was encoded");
    if (write(user, encoder->file.data, encoder->file.size) != 0)
        return nsdf_encoder_fail(error, NSDF_IO, "the file cannot be written");
    return NSDF_OK;
}

nsdf_status nsdf_encoder_get_stats(const nsdf_encoder *encoder, nsdf_encoder_stats *stats) {
    if (!encoder || !stats)
        return NSDF_INVALID_ARGUMENT;
    *stats = encoder->stats;
    return NSDF_OK;
}

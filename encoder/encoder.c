#include "nsdf/encoder.h"

#include "encode_run.h"
#include "encoder_options.h"
#include "rate_control.h"

#include <stdlib.h>

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
                                 part->lead, part->trail, nsdf_frames_span(frames));
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

/* ---- Runs ----------------------------------------------------------------------------------------------- */

/* Goes on after verification until the target is met, or nothing helps. */
static nsdf_status pursue_target(nsdf_run *r) {
    nsdf_encoder *e = r->encoder;
    nsdf_status status = NSDF_OK;
    for (int again = nsdf_run_has_target(r); again && status == NSDF_OK;) {
        const double began = nsdf_clock();
        const nsdf_quality *q = &e->stats.quality;
        if (r->rate_blocks)
            status = nsdf_rate_blocks_judge(r->rate_blocks, &e->blocks, &r->fit, q, r->strays, &again, r->error);
        else
            status = nsdf_rate_network_judge(r->rate_network, &r->fit, q, &again, r->error);
        e->stats.seconds_fit += nsdf_clock() - began;
        nsdf_run_forget_strays(r);
        if (status == NSDF_OK)
            status = nsdf_run_fitted(r, 0);
        if (status == NSDF_OK && again)
            status = nsdf_run_code_and_check(r);
    }
    return status;
}

static int target_met(const nsdf_run *r) {
    const nsdf_encoder *e = r->encoder;
    const nsdf_encoder_options *o = &e->options;
    if (r->size > 0)
        return nsdf_rate_size_met(e->file.size, r->size);
    return !(o->target_error > 0.0) || nsdf_mean_error(&e->stats.quality) <= o->target_error;
}

static nsdf_status run_stages(nsdf_run *r) {
    nsdf_encoder *e = r->encoder;
    double began = nsdf_clock();
    nsdf_status status = nsdf_run_prepare(r);
    if (status == NSDF_OK)
        status = nsdf_run_sample(r);
    e->stats.seconds_sample = nsdf_clock() - began - r->seconds_track;
    began = nsdf_clock();
    if (status == NSDF_OK)
        status = nsdf_run_fit(r, &e->checkpoint);
    e->stats.seconds_fit = nsdf_clock() - began + r->seconds_track;
    const nsdf_encoder_options blocks = nsdf_block_options(&e->options, e->frames.count);
    const uint64_t steps = nsdf_run_uses_blocks(r) ? blocks.steps : e->options.steps;
    const int timed = e->options.time_budget > 0.0, whole = r->fit.steps >= steps;
    if (status == NSDF_OK)
        status = nsdf_run_code_and_check(r);
    if (status == NSDF_OK)
        status = nsdf_run_mend(r, timed || whole);
    if (status == NSDF_OK)
        status = nsdf_run_try_network(r, !timed && whole);
    return status == NSDF_OK ? pursue_target(r) : status;
}

/* Frees what stages share; without success there is no file. */
static void end_run(nsdf_run *r, nsdf_status status) {
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
    nsdf_run_forget_strays(r);
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
    nsdf_run r = {.encoder = encoder, .progress = progress, .user = user, .error = error, .start = nsdf_clock()};
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
static nsdf_status recode(nsdf_run *r) {
    nsdf_encoder *e = r->encoder;
    nsdf_status status = NSDF_OK;
    r->workers = nsdf_workers_create(e->options.threads);
    r->strays = calloc(e->frames.count, sizeof *r->strays);
    if (!r->workers || !r->strays)
        status = nsdf_encoder_fail(r->error, NSDF_NO_MEMORY, "out of memory");
    if (status == NSDF_OK)
        status = nsdf_run_code_and_check(r);
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
    nsdf_run r = {.encoder = encoder, .progress = progress, .user = user, .error = error, .start = nsdf_clock()};
    encoder->options = options;
    encoder->model.desc.list.entropy = (uint8_t)entropy;
    encoder->blocks.desc.list.entropy = (uint8_t)entropy;
    /* Fitting chose those of its own number of bits; nsdf_run_code chooses the others. */
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

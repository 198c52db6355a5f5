#include "encode_run.h"

#include "bound.h"
#include "encoder_options.h"
#include "frames_repair.h"

#include <stdlib.h>

/* Share of every frame's surface that has to lie in blocks, or else the model is the network. */
static const double least_cover = 0.85;

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
static nsdf_status repair(nsdf_run *r) {
    nsdf_encoder *e = r->encoder;
    const nsdf_repair_job job = {&e->frames, &e->options, &e->header, r->workers, r->progress, r->user, r->start};
    const nsdf_status status = nsdf_frames_repair(&job, &e->stats.input, r->error);
    if (status == NSDF_OK)
        nsdf_suit_sheets(&e->options, &e->stats.input, &e->header);
    return status;
}

/* Follows the surface, and takes the network where blocks would leave much of a frame bare: they cannot follow what
 * grows out of all proportion. */
static nsdf_status suit_motion(nsdf_run *r) {
    nsdf_encoder *e = r->encoder;
    const nsdf_fit_job job = nsdf_run_fit_job(r);
    const double began = nsdf_clock();
    double cover = 0.0;
    if (!nsdf_run_uses_blocks(r))
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

nsdf_status nsdf_run_prepare(nsdf_run *r) {
    nsdf_encoder_options *o = &r->encoder->options;
    nsdf_frames *frames = &r->encoder->frames;
    nsdf_file_header *h = &r->encoder->header;
    nsdf_model *model = &r->encoder->model;
    const double margin = NSDF_DOMAIN_MARGIN + nsdf_shell_margin(o, frames);
    nsdf_status status = nsdf_frames_normalise(frames, margin, h, r->error);
    h->rate_num = o->rate_num;
    h->rate_den = o->rate_den;
    r->encoder->shown = shown_frames(r->encoder);
    h->frame_count = nsdf_frames_span(&r->encoder->shown);
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

nsdf_status nsdf_run_sample(nsdf_run *r) {
    nsdf_frames *frames = &r->encoder->frames;
    nsdf_dataset_job job = {frames,  &r->encoder->options, &r->encoder->header, r->workers, r->progress, r->user,
                            r->start};
    nsdf_status status = nsdf_dataset_create(&r->dataset, &job, r->error);
    if (status != NSDF_OK)
        return status;
    nsdf_dataset_normalise(&r->dataset, &r->encoder->options, &r->encoder->model.desc);
    return NSDF_OK;
}

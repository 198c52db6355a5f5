#include "block_stage.h"

#include "block_batch.h"
#include "block_cover.h"
#include "block_knots.h"
#include "block_lives.h"
#include "block_order.h"
#include "block_start.h"
#include "nodes.h"
#include "register_nodes.h"

#include <stdlib.h>
#include <string.h>

enum { NODES_PER_BLOCK = 4, FEWEST_NODES = 3000, FEWEST_IN_STEP = 8 };

/* A frame that comes twice in a step finds its candidates anew (block_cache.h); few frames would leave cores idle. */
static uint32_t frames_of_step(const nsdf_encoder_options *o, uint32_t frame_count) {
    const uint32_t some = frame_count < FEWEST_IN_STEP ? FEWEST_IN_STEP : frame_count;
    return some < o->block_frames ? some : o->block_frames;
}

nsdf_encoder_options nsdf_block_options(const nsdf_encoder_options *options, uint32_t frame_count) {
    nsdf_encoder_options o = *options;
    const uint32_t frames = frames_of_step(options, frame_count);
    const uint64_t points = (uint64_t)o.block_points * o.block_frames / frames;
    o.steps = o.block_steps > 0 ? o.block_steps : 1 + (o.block_visits - 1) / frames;
    o.batch_frames = frames;
    o.batch_points = points < NSDF_BATCH_MOST_POINTS ? (uint32_t)points : NSDF_BATCH_MOST_POINTS;
    return o;
}

/* Control points are counted in frames of the sequence; where frames were left out, one for each that is there is the
 * most that they can tell. */
static double knot_spacing(const nsdf_fit_job *job, double frames) {
    const nsdf_frame *all = job->frames->frames;
    const double gaps = (double)job->frame_count - 1.0;
    const double nominal = (double)all[job->frame_count - 1].number - all[0].number;
    const double spacing = nominal > 0.0 ? frames * gaps / nominal : 1.0;
    return gaps < nominal && frames > 0.0 && spacing < 1.0 ? 1.0 : spacing;
}

static int start_model(const nsdf_fit_job *job, nsdf_motion *motion, nsdf_block_model *model) {
    const nsdf_encoder_options *o = job->options;
    const nsdf_block_steps steps = {o->pose_step, o->coefficient_step};
    nsdf_bones bones;
    nsdf_block_frame scratch;
    if (nsdf_bones_fit(&bones, motion, o->bones, job->workers) != 0)
        return -1;
    int failed = nsdf_order_blocks(motion, &bones) != 0;
    const double spacing =
        failed ? -1.0 : nsdf_block_knot_spacing(motion, &bones, job->u, knot_spacing(job, o->block_knot_spacing));
    failed = spacing < 0.0 || nsdf_block_model_create(model, motion, &bones, job->u, o->block_degree, spacing,
                                                      knot_spacing(job, o->level_spacing), &steps) != 0;
    nsdf_bones_free(&bones);
    if (failed)
        return -1;
    model->desc.list.entropy = (uint8_t)o->entropy;
    if (nsdf_block_frame_create(&scratch, model, job->header->domain_min, job->header->domain_max) != 0)
        return -1;
    failed = nsdf_block_start(model, motion->normals, job->frames, job->u, &scratch, job->workers);
    nsdf_block_frame_free(&scratch);
    return failed;
}

/* Whether parts of some frame pass through each other, so that not all of its surface counts. */
static int any_hidden(const nsdf_frames *frames) {
    for (uint32_t f = 0; f < frames->count; f++)
        if (frames->frames[f].outer.triangle_count > 0)
            return 1;
    return 0;
}

int nsdf_track_surface(const nsdf_fit_job *job, nsdf_tracked *tracked) {
    const nsdf_encoder_options *o = job->options;
    const int connected = nsdf_frames_connected(job->frames);
    const uint32_t rest = nsdf_rest_frame(job->frames, connected);
    const uint32_t count = NODES_PER_BLOCK * o->blocks > FEWEST_NODES ? NODES_PER_BLOCK * o->blocks : FEWEST_NODES;
    nsdf_nodes *nodes = &tracked->nodes;
    tracked->area = nsdf_surface_area(nsdf_frame_outer(&job->frames->frames[rest]));
    if (nsdf_nodes_place(nodes, job->frames, rest, count, o->seed) != 0)
        return -1;
    int failed = 0;
    if (connected)
        nsdf_nodes_carry(nodes, job->frames);
    else
        failed = nsdf_nodes_register(nodes, job->frames, o->seed, job->workers);
    if (!failed && (!connected || any_hidden(job->frames)))
        failed = nsdf_nodes_find_support(nodes, job->frames, job->workers) != 0 ||
                 nsdf_nodes_cover(nodes, job->frames, o->seed, job->workers) != 0;
    if (failed)
        nsdf_nodes_free(nodes);
    return failed ? -1 : 0;
}

static int find_motion(const nsdf_fit_job *job, const nsdf_tracked *tracked, nsdf_motion *motion) {
    const nsdf_encoder_options *o = job->options;
    const float radius = (float)nsdf_block_radius(o, tracked->area);
    return nsdf_motion_find(motion, &tracked->nodes, o->blocks, tracked->area, radius, job->workers);
}

int nsdf_find_block_cover(const nsdf_fit_job *job, const nsdf_tracked *tracked, double *least) {
    nsdf_motion motion;
    if (find_motion(job, tracked, &motion) != 0)
        return -1;
    const int failed = nsdf_block_cover_find(least, &motion, job->frames, job->options->seed, job->workers);
    nsdf_motion_free(&motion);
    return failed;
}

int nsdf_start_blocks(const nsdf_fit_job *job, const nsdf_tracked *tracked, nsdf_block_model *model) {
    nsdf_motion motion;
    if (find_motion(job, tracked, &motion) != 0)
        return -1;
    const int failed = start_model(job, &motion, model);
    nsdf_motion_free(&motion);
    return failed ? -1 : 0;
}

int nsdf_fit_blocks(const nsdf_fit_job *job, nsdf_block_model *model, nsdf_fit_result *result) {
    nsdf_encoder_options options = nsdf_block_options(job->options, job->frame_count);
    nsdf_fit_job block_job = *job;
    nsdf_tracked tracked;
    block_job.options = &options;
    if (!job->tracked && nsdf_track_surface(&block_job, &tracked) != 0)
        return -1;
    const int failed = nsdf_start_blocks(&block_job, job->tracked ? job->tracked : &tracked, model);
    if (!job->tracked)
        nsdf_nodes_free(&tracked.nodes);
    if (failed || nsdf_block_fit_run(&block_job, model, result) != 0)
        return -1;
    return nsdf_block_trim_lives(model, job->frames, job->u, job->header, job->workers);
}

/* decoded[value_count] gets what a reader will have, and q its integers.  The values are rounded once only: products
 * and quotients, as here and there, part at ties. */
static int quantise(const nsdf_block_model *model, float *decoded, int32_t *q) {
    const nsdf_tensor_list *list = &model->desc.list;
    int failed = 0;
    nsdf_block_model_round(model, model->values, decoded);
    for (uint32_t t = 0; t < list->count && !failed; t++) {
        const nsdf_array_desc *a = &list->tensors[t].arrays[0];
        const size_t at = nsdf_block_offset(&model->desc, t);
        failed = nsdf_quantise(decoded + at, (size_t)nsdf_array_size(a), a->step, a->offset, q + at);
    }
    return failed;
}

int nsdf_code_blocks(const nsdf_block_model *model, nsdf_coded_segment *segment) {
    nsdf_blocks_desc desc = model->desc;
    int32_t *q = malloc(model->value_count * sizeof *q);
    float *decoded = malloc(model->value_count * sizeof *decoded);
    int failed = !q || !decoded || quantise(model, decoded, q) != 0;
    if (!failed) {
        nsdf_write_segment_start(&segment->payload, 1);
        failed = nsdf_write_blocks_part(&segment->payload, &desc, q);
        segment->hash = nsdf_hash_floats(NSDF_HASH_START, decoded, model->value_count);
    }
    free(q);
    free(decoded);
    return failed || segment->payload.failed ? -1 : 0;
}

/* Bytes of the part, but with all values of tensor `without` the same, which take none. */
static size_t size_without(const nsdf_block_model *model, const int32_t *q, uint32_t without, int32_t *scratch) {
    nsdf_blocks_desc desc = model->desc;
    nsdf_buffer part = {0};
    memcpy(scratch, q, model->value_count * sizeof *scratch);
    if (without < desc.list.count)
        memset(scratch + nsdf_block_offset(&desc, without), 0,
               (size_t)nsdf_array_size(&desc.list.tensors[without].arrays[0]) * sizeof *scratch);
    const size_t size = nsdf_write_blocks_part(&part, &desc, scratch) == 0 ? part.size : 0;
    nsdf_buffer_free(&part);
    return size;
}

int nsdf_weigh_blocks(const nsdf_block_model *model, nsdf_block_bytes *bytes) {
    int32_t *q = malloc(model->value_count * sizeof *q), *scratch = malloc(model->value_count * sizeof *scratch);
    float *decoded = malloc(model->value_count * sizeof *decoded);
    const int failed = !q || !scratch || !decoded || quantise(model, decoded, q) != 0;
    const size_t all = failed ? 0 : size_without(model, q, UINT32_MAX, scratch);
    memset(bytes, 0, sizeof *bytes);
    for (uint32_t t = 0; t < model->desc.list.count && !failed; t++) {
        const size_t size = all - size_without(model, q, t, scratch);
        if (t <= NSDF_BLOCK_LIVES)
            bytes->places += size;
        else if (t <= NSDF_BLOCK_WEIGHTS)
            bytes->influences += size;
        else if (t <= NSDF_BLOCK_POSES)
            bytes->motion += size;
        else if (t == NSDF_BLOCK_COEFFICIENTS && model->level_knots > 0)
            bytes->levels += size;
        else
            bytes->shapes += size;
    }
    free(q);
    free(scratch);
    free(decoded);
    return failed ? -1 : 0;
}

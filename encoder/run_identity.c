#include "run_identity.h"

#include <stddef.h>
#include <string.h>

/* ---- Options -------------------------------------------------------------------------------------------- */

#define FIELD(name, member, fitting)                                                                                   \
    {                                                                                                                  \
        name, offsetof(nsdf_encoder_options, member), sizeof(((nsdf_encoder_options *)0)->member),                     \
            _Generic(((nsdf_encoder_options *)0)->member, double : 1, default : 0), fitting                            \
    }

static const nsdf_option_field fields[] = {
    FIELD("frame rate numerator", rate_num, 0),
    FIELD("frame rate denominator", rate_den, 0),
    FIELD("threads", threads, 0),
    FIELD("seed", seed, 1),
    FIELD("input", input, 1),
    FIELD("activation", activation, 1),
    FIELD("layers", layers, 1),
    FIELD("width", width, 1),
    FIELD("weight time", weight_time, 1),
    FIELD("knot spacing", knot_spacing, 1),
    FIELD("rank", rank, 1),
    FIELD("omega of the first layer", omega_first, 1),
    FIELD("omega of the hidden layers", omega_hidden, 1),
    FIELD("Fourier features", fourier_features, 1),
    FIELD("Fourier sigma", fourier_sigma, 1),
    FIELD("fitted Fourier features", fourier_trained, 1),
    FIELD("tanh of the output", output_tanh, 1),
    FIELD("blocks", blocks, 1),
    FIELD("bones", bones, 1),
    FIELD("degree of the blocks", block_degree, 1),
    FIELD("overlap of the blocks", block_overlap, 1),
    FIELD("radius of the blocks", block_radius, 1),
    FIELD("knot spacing of the blocks", block_knot_spacing, 1),
    FIELD("spacing of the levels", level_spacing, 1),
    FIELD("pose step", pose_step, 1),
    FIELD("coefficient step", coefficient_step, 1),
    FIELD("motion rate", motion_rate, 1),
    FIELD("steps of the blocks", block_steps, 1),
    FIELD("visits of the blocks", block_visits, 1),
    FIELD("frames of the blocks' batch", block_frames, 1),
    FIELD("points of the blocks' batch", block_points, 1),
    FIELD("sampling", sampling, 1),
    FIELD("samples per frame", samples_per_frame, 1),
    FIELD("d_0.5", d_half, 1),
    FIELD("time normalisation", time_norm, 1),
    FIELD("SDF normalisation", sdf_norm, 1),
    FIELD("shell", shell, 1),
    FIELD("hard samples", hard_samples, 1),
    FIELD("optimiser", optimiser, 1),
    FIELD("loss", loss, 1),
    FIELD("loss d0", loss_d0, 1),
    FIELD("loss of signs", loss_sign, 1),
    FIELD("error for the loss of signs", loss_sign_error, 1),
    FIELD("loss delta", loss_delta, 1),
    FIELD("loss slope", loss_slope, 1),
    FIELD("steps", steps, 1),
    FIELD("time budget", time_budget, 1),
    FIELD("batch frames", batch_frames, 1),
    FIELD("batch points", batch_points, 1),
    FIELD("learning rate", learning_rate, 1),
    FIELD("parameter rate", parameter_rate, 1),
    FIELD("weight bits", weight_bits, 1),
    FIELD("quantisation-aware fitting", quantise_aware, 1),
    FIELD("entropy coder", entropy, 0),
    FIELD("resolution", resolution, 0),
    FIELD("smallest piece", smallest_piece, 0),
    FIELD("verification", verify, 0),
    FIELD("target size", target_size, 1),
    FIELD("target bitrate", target_bitrate, 1),
    FIELD("target error", target_error, 1),
};
enum { FIELDS = sizeof fields / sizeof *fields };

const nsdf_option_field *nsdf_option_fields(size_t *count) {
    *count = FIELDS;
    return fields;
}

/* The bits of a number, or a whole number. */
static uint64_t field_value(const nsdf_option_field *field, const nsdf_encoder_options *options) {
    const char *at = (const char *)options + field->offset;
    uint64_t wide = 0;
    uint32_t narrow = 0;
    if (field->size == sizeof wide)
        memcpy(&wide, at, sizeof wide);
    else
        memcpy(&narrow, at, sizeof narrow);
    return wide | narrow;
}

uint64_t nsdf_encoder_options_hash(const nsdf_encoder_options *options) {
    uint64_t hash = nsdf_hash64(NSDF_HASH_START, nsdf_version_string(), strlen(nsdf_version_string()));
    for (size_t i = 0; options && i < FIELDS; i++) {
        const uint64_t value = field_value(&fields[i], options);
        if (fields[i].offset != offsetof(nsdf_encoder_options, threads))
            hash = nsdf_hash64(hash, &value, sizeof value);
    }
    return hash;
}

static double as_number(const nsdf_option_field *field, uint64_t value) {
    double number;
    memcpy(&number, &value, sizeof number);
    return field->real ? number : (double)value;
}

static nsdf_status compare_options(nsdf_cursor *in, const nsdf_encoder_options *options, nsdf_encoder_error *error) {
    for (size_t i = 0; i < FIELDS; i++) {
        if (!fields[i].fitting)
            continue;
        const uint64_t then = nsdf_take_u64(in), now = field_value(&fields[i], options);
        if (in->status == NSDF_PARSE_OK && then != now)
            return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                                     "the checkpoint was made with other options: %s was %.9g and is %.9g",
                                     fields[i].name, as_number(&fields[i], then), as_number(&fields[i], now));
    }
    return NSDF_OK;
}

/* ---- Input ---------------------------------------------------------------------------------------------- */

static uint64_t frame_hash(const nsdf_frame *frame) {
    const nsdf_surface *s = &frame->surface;
    const uint32_t counts[2] = {s->vertex_count, s->triangle_count};
    uint64_t hash = nsdf_hash64(NSDF_HASH_START, counts, sizeof counts);
    hash = nsdf_hash64(hash, s->positions, 3 * (size_t)s->vertex_count * sizeof *s->positions);
    return nsdf_hash64(hash, s->indices, 3 * (size_t)s->triangle_count * sizeof *s->indices);
}

/* Frames are kept relative to an origin: this is where they are. */
static uint64_t place_hash(const nsdf_frames *frames) {
    uint64_t hash = nsdf_hash64(NSDF_HASH_START, frames->origin, sizeof frames->origin);
    hash = nsdf_hash64(hash, frames->box_min, sizeof frames->box_min);
    return nsdf_hash64(hash, frames->box_max, sizeof frames->box_max);
}

static nsdf_status compare_frames(nsdf_cursor *in, const nsdf_frames *frames, nsdf_encoder_error *error) {
    const uint32_t count = nsdf_take_u32(in);
    if (in->status == NSDF_PARSE_OK && count != frames->count)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                                 "the checkpoint was made of another input: %u frames, now %u", count, frames->count);
    for (uint32_t i = 0; i < count && in->status == NSDF_PARSE_OK; i++) {
        const uint32_t number = nsdf_take_u32(in);
        const uint64_t hash = nsdf_take_u64(in);
        if (in->status == NSDF_PARSE_OK && number != frames->frames[i].number)
            return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                                     "the checkpoint was made of another input: frame %u where frame %u is now", number,
                                     frames->frames[i].number);
        if (in->status == NSDF_PARSE_OK && hash != frame_hash(&frames->frames[i]))
            return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                                     "the checkpoint was made of another input: frame %u differs", number);
    }
    const uint64_t place = nsdf_take_u64(in);
    if (in->status == NSDF_PARSE_OK && place != place_hash(frames))
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                                 "the checkpoint was made of another input: it is in another place");
    return NSDF_OK;
}

/* ---- Both ----------------------------------------------------------------------------------------------- */

void nsdf_identity_write(nsdf_buffer *out, const nsdf_encoder_options *options, const nsdf_frames *frames) {
    for (size_t i = 0; i < FIELDS; i++)
        if (fields[i].fitting)
            nsdf_buffer_u64(out, field_value(&fields[i], options));
    nsdf_buffer_u32(out, frames->count);
    for (uint32_t i = 0; i < frames->count; i++) {
        nsdf_buffer_u32(out, frames->frames[i].number);
        nsdf_buffer_u64(out, frame_hash(&frames->frames[i]));
    }
    nsdf_buffer_u64(out, place_hash(frames));
}

nsdf_status nsdf_identity_compare(nsdf_cursor *in, const nsdf_encoder_options *options, const nsdf_frames *frames,
                                  nsdf_encoder_error *error) {
    nsdf_status status = compare_options(in, options, error);
    if (status == NSDF_OK)
        status = compare_frames(in, frames, error);
    if (status == NSDF_OK && in->status != NSDF_PARSE_OK)
        return nsdf_encoder_fail(error, NSDF_CORRUPT, "the checkpoint is damaged: %s", in->fault.what);
    return status;
}

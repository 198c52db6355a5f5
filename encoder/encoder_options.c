#include "encoder_options.h"

#include "frames.h"

#include <math.h>
#include <string.h>

static const double least_target = 500; /* bytes: less than any file takes */

static nsdf_encoder_options common_options(void) {
    nsdf_encoder_options o;
    memset(&o, 0, sizeof o);
    o.struct_size = sizeof o;
    o.rate_num = 25;
    o.rate_den = 1;
    o.seed = 1;
    o.input = NSDF_MODEL_XYZ;
    o.activation = NSDF_MODEL_SINE;
    o.layers = 3;
    o.width = 96;
    o.weight_time = NSDF_TIME_SPLINE;
    o.knot_spacing = 4.0;
    o.rank = 8;
    o.omega_first = 80.0;
    o.omega_hidden = 1.0;
    o.fourier_features = 20; /* five per input value, as in thesis chapter 8 */
    o.fourier_sigma = sqrt(3.0);
    o.blocks = 1000;
    o.bones = 52;
    o.block_degree = 2;
    o.block_overlap = 5.0;
    o.block_knot_spacing = 2.0;
    o.level_spacing = 12.0;
    o.pose_step = 1.5e-4;
    o.coefficient_step = 3e-4;
    o.motion_rate = 4.2e-5;
    o.block_frames = 24;
    o.block_points = 2048;
    o.d_half = 0.01;
    o.hard_samples = 1;
    o.loss_delta = 0.01;
    o.loss_slope = 200.0;
    o.batch_frames = 8;
    o.batch_points = 1024;
    o.learning_rate = 2e-3;
    o.parameter_rate = 1e-4;
    o.weight_bits = 11.0;
    o.quantise_aware = 1;
    o.entropy = NSDF_CODER_RANGE;
    o.smallest_piece = -1.0;
    o.verify = 1;
    return o;
}

static void thesis_options(nsdf_encoder_options *o) {
    o->blocks = 0;
    o->input = NSDF_MODEL_XYZT;
    o->activation = NSDF_MODEL_RELU;
    o->layers = 16;
    o->width = 256;
    o->weight_time = NSDF_TIME_CONSTANT;
    o->output_tanh = 1;
    o->sampling = NSDF_SAMPLE_REJECTION;
    o->sdf_norm = NSDF_SDF_UNIT_RANGE;
    o->hard_samples = 0;
    o->optimiser = NSDF_OPTIMISER_ADAM;
    o->loss = NSDF_LOSS_MAE;
    o->steps = 4000;
    o->learning_rate = 5e-4;
    o->weight_bits = 8.0;
    o->quantise_aware = 0;
    o->entropy = NSDF_CODER_DEFLATE;
}

void nsdf_encoder_options_init(nsdf_encoder_options *options, nsdf_preset preset) {
    nsdf_encoder_options o = common_options();
    o.steps = 7000;
    o.block_visits = 80000;
    if (preset == NSDF_PRESET_FAST) {
        o.knot_spacing = 6.0;
        o.learning_rate = 1.4e-3;
        o.batch_points = 512;
        o.block_frames = 16;
    }
    if (preset == NSDF_PRESET_MEDIUM) {
        o.steps = 40000;
        o.blocks = 1400;
        o.bones = 83;
        o.block_visits = 320000;
        o.block_knot_spacing = 1.4;
        o.level_spacing = 12.0;
        o.pose_step = 1.1e-4;
        o.coefficient_step = 2.5e-4;
        o.motion_rate = 3.5e-5;
    }
    if (preset == NSDF_PRESET_SLOW || preset == NSDF_PRESET_BEST) {
        o.steps = 100000;
        o.blocks = 3000;
        o.bones = 104;
        o.block_visits = 720000;
        o.block_knot_spacing = 1.0;
        o.level_spacing = 8.0;
        o.pose_step = 9e-5;
        o.coefficient_step = 2e-4;
        o.motion_rate = 2e-5;
        o.width = 128;
        o.learning_rate = 1e-3;
    }
    if (preset == NSDF_PRESET_BEST) {
        o.blocks = 5000;
        o.bones = 160;
        o.level_spacing = 6.0;
        o.pose_step = 7e-5;
        o.coefficient_step = 1.6e-4;
        o.motion_rate = 1.3e-5;
    }
    if (preset == NSDF_PRESET_THESIS)
        thesis_options(&o);
    *options = o;
}

/* ---- Checking ------------------------------------------------------------------------------------------- */

typedef struct {
    const char *name;
    double value, low, high;
} range;

static nsdf_status check_ranges(const range *ranges, size_t count, nsdf_encoder_error *error) {
    for (size_t i = 0; i < count; i++)
        if (!(ranges[i].value >= ranges[i].low && ranges[i].value <= ranges[i].high))
            return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "%s is %.10g, expected %.10g to %.10g",
                                     ranges[i].name, ranges[i].value, ranges[i].low, ranges[i].high);
    return NSDF_OK;
}

static nsdf_status check_model(const nsdf_encoder_options *o, nsdf_encoder_error *error) {
    const range ranges[] = {
        {"input", (double)o->input, 0, 2},
        {"activation", (double)o->activation, 0, 2},
        {"layers", o->layers, 1, NSDF_MAX_LAYERS - 1},
        {"width", o->width, 1, NSDF_MAX_WIDTH},
        {"weight time", (double)o->weight_time, 0, 2},
        {"knot spacing", o->knot_spacing, 0.25, 1e6},
        {"rank", o->rank, 1, NSDF_MAX_RANK},
        {"omega of the first layer", o->omega_first, 1e-3, 1e4},
        {"omega of the hidden layers", o->omega_hidden, 1e-3, 1e4},
        {"Fourier features", o->fourier_features, 1, NSDF_MAX_FOURIER},
        {"Fourier sigma", o->fourier_sigma, 1e-6, 1e3},
        {"blocks", o->blocks, 0, NSDF_MAX_BLOCKS},
        {"bones", o->bones, 1, NSDF_MAX_BONES},
        {"degree of the blocks", o->block_degree, 0, NSDF_MAX_DEGREE},
        {"overlap of the blocks", o->block_overlap, 1, 20},
        {"radius of the blocks", o->block_radius, 0, 0.5},
        {"knot spacing of the blocks", o->block_knot_spacing, 0.25, 1e6},
        {"spacing of the levels", o->level_spacing, 0.0, 1e6},
        {"pose step", o->pose_step, 1e-7, 0.1},
        {"motion rate", o->motion_rate, 0, 1},
        {"coefficient step", o->coefficient_step, 1e-7, 0.1},
    };
    nsdf_status status = check_ranges(ranges, sizeof ranges / sizeof *ranges, error);
    if (status == NSDF_OK && o->weight_time != NSDF_TIME_CONSTANT && o->input != NSDF_MODEL_XYZ)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                                 "weights that change with time go with xyz input only: time is an input otherwise");
    return status;
}

static nsdf_status check_fitting(const nsdf_encoder_options *o, nsdf_encoder_error *error) {
    const range ranges[] = {
        {"frame rate numerator", o->rate_num, 1, 4294967295.0},
        {"frame rate denominator", o->rate_den, 1, 4294967295.0},
        {"threads", o->threads, 0, 256},
        {"sampling", (double)o->sampling, 0, 1},
        {"samples per frame", o->samples_per_frame, 0, 1e8},
        {"d_0.5", o->d_half, 1e-6, 10},
        {"time normalisation", (double)o->time_norm, 0, 1},
        {"SDF normalisation", (double)o->sdf_norm, 0, 1},
        {"shell", o->shell == NSDF_NO_SHELL ? 0.0 : o->shell, 0, 1e30},
        {"loss", (double)o->loss, 0, 2},
        {"loss d0", o->loss_d0 != 0.0 ? o->loss_d0 : 1.0, 1e-6, 1e6},
        {"error for the loss of signs", o->loss_sign_error, 0, 1e9},
        {"loss of signs", o->loss_sign > 0.0 ? o->loss_sign : 1.0 + o->loss_sign, 1, 1e3},
        {"loss delta", o->loss_delta, 0, 10},
        {"loss slope", o->loss_slope, 1e-3, 1e9},
        {"steps", (double)o->steps, 1, 1e12},
        {"time budget", o->time_budget, 0, 1e8},
        {"batch frames", o->batch_frames, 1, 4096},
        {"batch points", o->batch_points, 1, 1 << 20},
        {"steps of the blocks", (double)o->block_steps, 0, 1e12},
        {"visits of the blocks", (double)o->block_visits, 1, 1e12},
        {"frames of the blocks' batch", o->block_frames, 1, 4096},
        {"points of the blocks' batch", o->block_points, 1, 1 << 16},
        {"learning rate", o->learning_rate, 1e-12, 1},
        {"parameter rate", o->parameter_rate, 0, 1},
        {"entropy coder", (double)o->entropy, 0, 3},
        {"resolution", o->resolution ? o->resolution : 2, 2, NSDF_MAX_RESOLUTION},
        {"smallest piece", o->smallest_piece, -1, 1},
    };
    nsdf_status status = check_ranges(ranges, sizeof ranges / sizeof *ranges, error);
    if (status == NSDF_OK && !((o->weight_bits >= 4.0 && o->weight_bits <= 16.0) || o->weight_bits == 32.0))
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "weight bits are %g, expected 4 to 16, or 32",
                                 o->weight_bits);
    return status;
}

static const char *check_targets_together(const nsdf_encoder_options *o) {
    const int size = o->target_size > 0, rate = o->target_bitrate != 0.0, wrong = o->target_error != 0.0;
    if (size + rate + wrong > 1)
        return "only one of target size, target bitrate and target error can be given";
    if (size + rate + wrong > 0 && (!o->quantise_aware || o->entropy != NSDF_CODER_RANGE || o->weight_bits >= 32.0))
        return "a target goes with the aware quantiser of 4 to 16 bits and the range coder only";
    if (size + rate + wrong > 0 && o->time_budget > 0.0)
        return "a time budget goes without a target size, bitrate or error";
    return wrong && !o->verify ? "a target error cannot be met without verifying" : NULL;
}

static nsdf_status check_target(const nsdf_encoder_options *o, nsdf_encoder_error *error) {
    const char *message = check_targets_together(o);
    if (message)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "%s", message);
    const range ranges[] = {
        {"target size", o->target_size ? (double)o->target_size : least_target, least_target, 1e12},
        {"target bitrate", o->target_bitrate, 0, 1e9},
        {"target error", o->target_error != 0.0 ? o->target_error : 0.1, 1e-6, 0.1},
    };
    return check_ranges(ranges, sizeof ranges / sizeof *ranges, error);
}

nsdf_status nsdf_encoder_options_check(const nsdf_encoder_options *options, nsdf_encoder_error *error) {
    if (options->struct_size != sizeof *options)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT,
                                 "the options have %zu bytes, expected %zu: call nsdf_encoder_options_init",
                                 options->struct_size, sizeof *options);
    nsdf_status status = check_model(options, error);
    if (status == NSDF_OK)
        status = check_fitting(options, error);
    return status == NSDF_OK ? check_target(options, error) : status;
}

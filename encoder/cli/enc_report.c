#include "enc_report.h"

#include "enc_dirt.h"

#include <stdio.h>
#include <string.h>

static const char *const coders[] = {"none", "deflate", "zstd", "range"};

/* Those of blocks; what a fit of few frames makes of the last four is in encoder.h. */
static void put_block_options(nsdf_cli_file *f, const nsdf_encoder_options *e) {
    nsdf_cli_file_print(f,
                        "    \"blocks\": %u, \"block_degree\": %u, \"block_overlap\": %.17g, \"block_radius\": %.17g, "
                        "\"bones\": %u, \"block_knot_spacing\": %.17g, \"level_spacing\": %.17g,\n",
                        e->blocks, e->block_degree, e->block_overlap, e->block_radius, e->bones, e->block_knot_spacing,
                        e->level_spacing);
    nsdf_cli_file_print(f,
                        "    \"pose_step\": %.17g, \"coefficient_step\": %.17g, \"motion_rate\": %.17g, "
                        "\"block_steps\": %llu, \"block_visits\": %llu, \"block_frames\": %u, \"block_points\": %u,\n",
                        e->pose_step, e->coefficient_step, e->motion_rate, (unsigned long long)e->block_steps,
                        (unsigned long long)e->block_visits, e->block_frames, e->block_points);
}

static void put_options(nsdf_cli_file *f, const enc_options *o) {
    static const char *const inputs[] = {"xyz", "xyzt", "fourier"}, *const acts[] = {"sine", "relu", "tanh"};
    static const char *const times[] = {"constant", "spline", "low-rank"};
    static const char *const losses[] = {"weighted", "mae", "surface"};
    const nsdf_encoder_options *e = &o->encoder;
    nsdf_cli_file_print(f, "  \"options\": {\n    \"preset\": ");
    nsdf_cli_file_print_json(f, o->preset);
    nsdf_cli_file_print(f, ", \"fps\": [%u, %u], \"numbers\": \"%s\", \"frame_step\": %u, \"frames\": ", e->rate_num,
                        e->rate_den, o->ignore_numbers ? "ignore" : "times", o->frame_step ? o->frame_step : 1);
    nsdf_cli_file_print_json(f, o->frames ? o->frames : "all");
    nsdf_cli_file_print(f, ", \"seed\": %llu, \"threads\": %u,\n", (unsigned long long)e->seed, e->threads);
    nsdf_cli_file_print(f,
                        "    \"input\": \"%s\", \"activation\": \"%s\", \"output_activation\": \"%s\", \"layers\": %u, "
                        "\"width\": %u,\n",
                        inputs[e->input], acts[e->activation], e->output_tanh ? "tanh" : "identity", e->layers,
                        e->width);
    nsdf_cli_file_print(
        f,
        "    \"weights\": \"%s\", \"knot_spacing\": %.17g, \"rank\": %u, \"omega\": %.17g, \"omega_hidden\": %.17g,\n",
        times[e->weight_time], e->knot_spacing, e->rank, e->omega_first, e->omega_hidden);
    nsdf_cli_file_print(f, "    \"fourier_features\": %u, \"fourier_sigma\": %.17g, \"fourier_trained\": %s,\n",
                        e->fourier_features, e->fourier_sigma, e->fourier_trained ? "true" : "false");
    put_block_options(f, e);
    nsdf_cli_file_print(f,
                        "    \"sampling\": \"%s\", \"d_half\": %.17g, \"hard_samples\": %s, \"time_norm\": \"%s\", "
                        "\"sdf_norm\": \"%s\", \"shell\": %.17g,\n",
                        e->sampling == NSDF_SAMPLE_REJECTION ? "rejection" : "near", e->d_half,
                        e->hard_samples ? "true" : "false", e->time_norm == NSDF_TIME_SPEED ? "speed" : "unit",
                        e->sdf_norm == NSDF_SDF_UNIT_RANGE ? "unit" : "diagonal", e->shell);
    nsdf_cli_file_print(
        f, "    \"loss\": \"%s\", \"loss_d0\": %.17g, \"loss_sign\": %.17g, \"delta\": %.17g, \"slope\": %.17g,\n",
        losses[e->loss], e->loss_d0, e->loss_sign, e->loss_delta, e->loss_slope);
    nsdf_cli_file_print(f,
                        "    \"optimiser\": \"%s\", \"steps\": %llu, \"batch_frames\": %u, \"batch_points\": %u, "
                        "\"learning_rate\": %.17g, \"parameter_rate\": %.17g,\n",
                        e->optimiser == NSDF_OPTIMISER_ADAM ? "adam" : "muon", (unsigned long long)e->steps,
                        e->batch_frames, e->batch_points, e->learning_rate, e->parameter_rate);
    nsdf_cli_file_print(
        f, "    \"weight_bits\": %.17g, \"quantiser\": \"%s\", \"entropy\": \"%s\", \"resolution\": %u\n  },\n",
        e->weight_bits, e->quantise_aware ? "aware" : "minmax", coders[e->entropy], e->resolution);
}

static void put_also(nsdf_cli_file *f, const enc_options *o, const uint64_t *bytes) {
    nsdf_cli_file_print(f, "  \"also\": [");
    for (uint32_t i = 0; i < o->also_count; i++) {
        nsdf_cli_file_print(f, "%s\n    {\"output\": ", i ? "," : "");
        nsdf_cli_file_print_json(f, o->also[i].output);
        nsdf_cli_file_print(f, ", \"weight_bits\": %.17g, \"entropy\": \"%s\", \"bytes\": %llu}",
                            o->also[i].weight_bits, coders[o->also[i].entropy], (unsigned long long)bytes[i]);
    }
    nsdf_cli_file_print(f, "],\n");
}

static void put_rounds(nsdf_cli_file *f, const nsdf_encoder_stats *s) {
    static const char *const kinds[] = {"probe", "fit", "tune", "quantise", "verify"};
    for (uint32_t i = 0; i < s->round_count; i++) {
        const nsdf_rate_round *r = &s->rounds[i];
        nsdf_cli_file_print(f, "%s\n    {\"kind\": \"%s\", \"steps\": %llu, ", i ? "," : "", kinds[r->kind],
                            (unsigned long long)r->steps);
        if (r->width)
            nsdf_cli_file_print(f, "\"width\": %u, \"weight_bits\": %.9g, ", r->width, r->weight_bits);
        else
            nsdf_cli_file_print(f,
                                "\"blocks\": %u, \"bones\": %u, \"pose_step\": %.9g, \"coefficient_step\": %.9g, "
                                "\"motion_rate\": %.9g, ",
                                r->blocks, r->bones, r->pose_step, r->coefficient_step, r->motion_rate);
        nsdf_cli_file_print(f, "\"bytes\": %llu, \"error\": ", (unsigned long long)r->bytes);
        nsdf_cli_file_print(f, r->error > 0.0 ? "%.9g}" : "null}", r->error);
    }
}

/* What was asked for, and the way there. */
static void put_target(nsdf_cli_file *f, const nsdf_encoder_options *e, const nsdf_encoder_stats *s) {
    if (!e->target_size && !(e->target_bitrate > 0.0) && !(e->target_error > 0.0))
        return;
    nsdf_cli_file_print(f, "  \"target\": {");
    if (e->target_size)
        nsdf_cli_file_print(f, "\"size\": %llu", (unsigned long long)e->target_size);
    else if (e->target_bitrate > 0.0)
        nsdf_cli_file_print(f, "\"bitrate\": %.9g", e->target_bitrate);
    else
        nsdf_cli_file_print(f, "\"max_error\": %.9g", e->target_error);
    nsdf_cli_file_print(f, ", \"met\": %s, \"rounds\": [", s->target_met ? "true" : "false");
    put_rounds(f, s);
    nsdf_cli_file_print(f, "]},\n");
}

static void put_result(nsdf_cli_file *f, const nsdf_encoder_stats *s, int interrupted) {
    nsdf_cli_file_print(f,
                        "  \"input\": {\"frames\": %u, \"triangles\": %llu, \"diagonal\": %.17g, \"mesh\": ", s->frames,
                        (unsigned long long)s->triangles, s->diagonal);
    enc_put_dirt(f, &s->input);
    nsdf_cli_file_print(f, "},\n");
    nsdf_cli_file_print(f, "  \"fit\": {\"steps\": %llu, \"samples\": %llu, \"error\": %.9g, \"interrupted\": %s},\n",
                        (unsigned long long)s->steps, (unsigned long long)s->samples, s->fit_error,
                        interrupted ? "true" : "false");
    nsdf_cli_file_print(f, "  \"file\": {\"bytes\": %llu, \"parameters\": %llu, \"extraction_bound\": %.9g},\n",
                        (unsigned long long)s->file_size, (unsigned long long)s->parameters, s->bound);
    if (s->blocks)
        nsdf_cli_file_print(f,
                            "  \"blocks\": {\"count\": %u, \"bones\": %u, \"bytes\": {\"places\": %llu, "
                            "\"influences\": %llu, \"motion\": %llu, \"levels\": %llu, \"shapes\": %llu}},\n",
                            s->blocks, s->bones, (unsigned long long)s->block_bytes.places,
                            (unsigned long long)s->block_bytes.influences, (unsigned long long)s->block_bytes.motion,
                            (unsigned long long)s->block_bytes.levels, (unsigned long long)s->block_bytes.shapes);
    nsdf_cli_file_print(f, "  \"seconds\": {\"sample\": %.3f, \"fit\": %.3f, \"code\": %.3f, \"verify\": %.3f},\n",
                        s->seconds_sample, s->seconds_fit, s->seconds_code, s->seconds_verify);
    nsdf_cli_file_print(f, "  \"quality\": ");
    if (s->quality.frames == 0) {
        nsdf_cli_file_print(f, "null\n");
        return;
    }
    nsdf_cli_file_print(
        f, "{\"unit\": \"fraction of the diagonal\", \"resolution\": %u, \"frames\": %u, \"stray_pieces\": %u,\n",
        s->quality.resolution, s->quality.frames, s->stray_pieces);
    nsdf_cli_file_print(f, "    \"to_decoded\": {\"mean\": %.9g, \"rms\": %.9g, \"max\": %.9g},\n",
                        s->quality.mean_to_decoded, s->quality.rms_to_decoded, s->quality.max_to_decoded);
    nsdf_cli_file_print(f, "    \"to_input\": {\"mean\": %.9g, \"rms\": %.9g, \"max\": %.9g}}\n",
                        s->quality.mean_to_input, s->quality.rms_to_input, s->quality.max_to_input);
}

int enc_report_write(nsdf_cli_file *file, const enc_options *options, const nsdf_encoder_stats *stats,
                     const uint64_t *also_bytes, int interrupted) {
    nsdf_cli_file_print(file, "{\n  \"version\": \"%s\",\n  \"output\": ", nsdf_version_string());
    nsdf_cli_file_print_json(file, options->output);
    nsdf_cli_file_print(file, ",\n");
    put_options(file, options);
    put_also(file, options, also_bytes);
    put_target(file, &options->encoder, stats);
    put_result(file, stats, interrupted);
    nsdf_cli_file_print(file, "}\n");
    return nsdf_cli_file_close(file);
}

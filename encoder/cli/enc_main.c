/* nsdf-enc: mesh sequence in, .nsdf file out. */
#include "cli_util.h"
#include "enc_check.h"
#include "enc_checkpoint.h"
#include "enc_dirt.h"
#include "enc_mpi.h"
#include "enc_report.h"
#include "enc_segments.h"

#include <stdio.h>
#include <string.h>

/* Exit code: the file is written, but --max-error or --size is not met. */
enum { TARGET_MISSED = 3 };

typedef struct {
    int finished_early;
    enc_checkpoint checkpoint;
    const nsdf_encoder *encoder;
    uint32_t rounds; /* of rate control that were said */
} progress_state;

/* A line for each round of rate control that has come since. */
static void say_rounds(progress_state *state) {
    static const char *const kinds[] = {"probe", "fit", "tuning", "quantising", "verifying"};
    nsdf_encoder_stats s;
    if (nsdf_encoder_get_stats(state->encoder, &s) != NSDF_OK)
        return;
    for (; state->rounds < s.round_count; state->rounds++) {
        const nsdf_rate_round *r = &s.rounds[state->rounds];
        char model[128], error[32] = "";
        if (r->width)
            snprintf(model, sizeof model, "width %u, %.3f bits", r->width, r->weight_bits);
        else
            snprintf(model, sizeof model, "%u blocks, %u bones, steps %.2e and %.2e, rate %.1e", r->blocks, r->bones,
                     r->pose_step, r->coefficient_step, r->motion_rate);
        if (r->error > 0.0)
            snprintf(error, sizeof error, ", error %.2e", r->error);
        nsdf_cli_verbose("round %u, %s: %s, %llu steps: %llu bytes%s", state->rounds + 1, kinds[r->kind], model,
                         (unsigned long long)r->steps, (unsigned long long)r->bytes, error);
    }
}

static int on_progress(void *user, const nsdf_progress *p) {
    progress_state *state = user;
    say_rounds(state);
    int interrupts = nsdf_cli_interrupts();
    if (interrupts >= 2 || (interrupts >= 1 && p->stage == NSDF_STAGE_SAMPLE))
        return NSDF_ABORT;
    if (interrupts == 1 && p->stage == NSDF_STAGE_FIT && !state->finished_early) {
        state->finished_early = 1;
        nsdf_cli_say("interrupted: writing what has been fitted so far; once more to give up");
        return NSDF_FINISH;
    }
    switch (p->stage) {
    case NSDF_STAGE_SAMPLE:
        nsdf_cli_progress("sampling %3.0f %%", 100.0 * p->fraction);
        break;
    case NSDF_STAGE_FIT:
        nsdf_cli_progress("fitting %5.1f %%  error %.2e  %.2f M samples/s  %.0f s left", 100.0 * p->fraction, p->error,
                          1e-6 * p->samples_per_second, p->eta);
        break;
    case NSDF_STAGE_BOUND:
        nsdf_cli_progress("coding %3.0f %%", 100.0 * p->fraction);
        break;
    case NSDF_STAGE_VERIFY:
        nsdf_cli_progress("verifying %3.0f %%  %.0f s left", 100.0 * p->fraction, p->eta);
        break;
    }
    return NSDF_CONTINUE;
}

static int add_frames(const nsdf_cli_list *list, nsdf_encoder *encoder, nsdf_sequence *sequence) {
    for (uint32_t i = 0; i < list->count; i++) {
        nsdf_cli_progress("reading %u of %u", i + 1, list->count);
        if (enc_add_frame(encoder, sequence, list->numbers[i]) != 0)
            return -1;
        if (nsdf_cli_interrupts() > 0) {
            nsdf_cli_error("interrupted: nothing was written");
            return -1;
        }
    }
    return 0;
}

static void warn_about_input(const enc_options *o, const nsdf_encoder_stats *s) {
    char text[600];
    if (*enc_explain_dirt(&s->input, s->frames, o->encoder.shell > 0.0, text, sizeof text))
        nsdf_cli_warn("the input is not clean; what was done, in each frame: %s", text);
}

/* Sampling and verifying take their time however few steps are made. */
static void warn_about_time(double budget, const nsdf_encoder_stats *s) {
    const double after = s->seconds_code + s->seconds_verify;
    if (budget > 0.0 && s->seconds_sample + s->seconds_fit + after > 1.25 * budget)
        nsdf_cli_warn("--time %g is exceeded: sampling took %.1f s, %llu steps %.1f s, coding and verifying %.1f s",
                      budget, s->seconds_sample, (unsigned long long)s->steps, s->seconds_fit, after);
}

static void summarise(const enc_options *o, const nsdf_encoder_stats *s) {
    warn_about_input(o, s);
    nsdf_cli_verbose("%llu parameters, %llu steps, extraction bound %.2f", (unsigned long long)s->parameters,
                     (unsigned long long)s->steps, s->bound);
    if (s->blocks)
        nsdf_cli_verbose("%u blocks, %u bones; bytes of places %llu, influences %llu, motion %llu, levels %llu, "
                         "shapes %llu",
                         s->blocks, s->bones, (unsigned long long)s->block_bytes.places,
                         (unsigned long long)s->block_bytes.influences, (unsigned long long)s->block_bytes.motion,
                         (unsigned long long)s->block_bytes.levels, (unsigned long long)s->block_bytes.shapes);
    if (s->unfollowed)
        nsdf_cli_warn("the surface changes its size too much for blocks that move with it: a network was fitted");
    if (s->came_apart)
        nsdf_cli_warn("blocks that move with the surface came apart: a network was fitted after them, and is nearer");
    nsdf_cli_verbose("sampling %.1f s, fitting %.1f s, coding %.1f s, verifying %.1f s", s->seconds_sample,
                     s->seconds_fit, s->seconds_code, s->seconds_verify);
    nsdf_cli_say("%s: %u frame%s in %llu bytes (%.0f a frame), %.0f s", o->output, s->nominal_frames,
                 s->nominal_frames == 1 ? "" : "s", (unsigned long long)s->file_size,
                 (double)s->file_size / (double)s->nominal_frames,
                 s->seconds_sample + s->seconds_fit + s->seconds_code + s->seconds_verify);
    warn_about_time(o->encoder.time_budget, s);
    if (s->quality.frames == 0)
        return;
    nsdf_cli_say("mean error %.2e of the diagonal from input to decoded, %.2e back; largest %.2e and %.2e "
                 "(%u frames, resolution %u)",
                 s->quality.mean_to_decoded, s->quality.mean_to_input, s->quality.max_to_decoded,
                 s->quality.max_to_input, s->quality.frames, s->quality.resolution);
    if (s->stray_pieces)
        nsdf_cli_warn("%u stray pieces further than 0.01 of the diagonal from the input: a slower preset helps",
                      s->stray_pieces);
}

typedef struct {
    nsdf_cli_file file, report, also[ENC_MOST_ALSO];
    uint64_t also_bytes[ENC_MOST_ALSO];
} outputs;

static void init_outputs(outputs *out) {
    memset(out, 0, sizeof *out);
    out->file.descriptor = out->report.descriptor = -1;
    for (uint32_t i = 0; i < ENC_MOST_ALSO; i++)
        out->also[i].descriptor = -1;
}

static void drop_outputs(outputs *out) {
    nsdf_cli_file_drop(&out->file);
    nsdf_cli_file_drop(&out->report);
    for (uint32_t i = 0; i < ENC_MOST_ALSO; i++)
        nsdf_cli_file_drop(&out->also[i]);
}

/* Before anything that takes time, so that a name that cannot be written is told at once. */
static int open_outputs(const enc_options *o, outputs *out) {
    if (nsdf_cli_file_open(&out->file, o->output) != 0)
        return -1;
    for (uint32_t i = 0; i < o->also_count; i++)
        if (nsdf_cli_file_open(&out->also[i], o->also[i].output) != 0)
            return -1;
    return o->report ? nsdf_cli_file_open(&out->report, o->report) : 0;
}

static int encoded(nsdf_status status, const nsdf_encoder_error *error, const enc_checkpoint *checkpoint) {
    if (status == NSDF_CANCELLED && checkpoint->there)
        nsdf_cli_error("interrupted: nothing was written, but '%s': the same command goes on from it",
                       checkpoint->path);
    else if (status == NSDF_CANCELLED)
        nsdf_cli_error("interrupted: nothing was written");
    else if (status != NSDF_OK)
        nsdf_cli_error("%s", error->message);
    return status == NSDF_OK ? 0 : -1;
}

static int run(nsdf_encoder *encoder, progress_state *state) {
    nsdf_encoder_error error;
    return encoded(nsdf_encoder_run(encoder, on_progress, state, &error), &error, &state->checkpoint);
}

static int recode(nsdf_encoder *encoder, const enc_also *also, progress_state *state) {
    nsdf_encoder_error error;
    return encoded(nsdf_encoder_recode(encoder, also->weight_bits, also->entropy, on_progress, state, &error), &error,
                   &state->checkpoint);
}

static int write_file(nsdf_encoder *encoder, nsdf_cli_file *file) {
    nsdf_encoder_error error;
    const nsdf_status status = nsdf_encoder_write(encoder, nsdf_cli_file_write, file, &error);
    if (nsdf_cli_file_close(file) != 0)
        return -1; /* says why, also when a write failed */
    if (status != NSDF_OK)
        nsdf_cli_error("%s", error.message);
    return status == NSDF_OK ? 0 : -1;
}

static int write_also(const enc_options *o, nsdf_encoder *encoder, outputs *out, progress_state *state) {
    for (uint32_t i = 0; i < o->also_count; i++) {
        nsdf_encoder_stats stats;
        if (recode(encoder, &o->also[i], state) != 0 || nsdf_encoder_get_stats(encoder, &stats) != NSDF_OK ||
            write_file(encoder, &out->also[i]) != 0)
            return -1;
        out->also_bytes[i] = stats.file_size;
    }
    return 0;
}

/* The exit code of a file that is written: whether it is what was asked for. */
static int judge_target(const enc_options *o, const nsdf_encoder_stats *s) {
    const double wanted = o->encoder.target_error;
    if (s->target_met)
        return NSDF_CLI_SUCCESS;
    if (wanted > 0.0)
        nsdf_cli_error("--max-error %g is missed by %.1f %%: the mean error of %s is %.3e", wanted,
                       100.0 * (nsdf_mean_error(&s->quality) / wanted - 1.0), o->output, nsdf_mean_error(&s->quality));
    else
        nsdf_cli_error("%s is more than 3 %% smaller than was asked for: it has %llu bytes", o->output,
                       (unsigned long long)s->file_size);
    return TARGET_MISSED;
}

static int encode(const enc_options *o, nsdf_encoder *encoder, outputs *out) {
    nsdf_encoder_stats stats;
    progress_state state = {.encoder = encoder};
    if (enc_checkpoint_open(&state.checkpoint, o, encoder) != 0 || run(encoder, &state) != 0 ||
        nsdf_encoder_get_stats(encoder, &stats) != NSDF_OK || write_file(encoder, &out->file) != 0 ||
        write_also(o, encoder, out, &state) != 0)
        return NSDF_CLI_FAILURE;
    if (o->report && enc_report_write(&out->report, o, &stats, out->also_bytes, state.finished_early) != 0)
        return NSDF_CLI_FAILURE;
    if (nsdf_cli_interrupts() >= 2) {
        nsdf_cli_error("interrupted: nothing was written");
        return NSDF_CLI_FAILURE;
    }
    if (nsdf_cli_commit() != 0)
        return NSDF_CLI_FAILURE;
    enc_checkpoint_close(&state.checkpoint, state.finished_early);
    say_rounds(&state);
    summarise(o, &stats);
    for (uint32_t i = 0; i < o->also_count; i++)
        nsdf_cli_say("%s: %llu bytes", o->also[i].output, (unsigned long long)out->also_bytes[i]);
    return judge_target(o, &stats);
}

/* What goes with one fit only. */
static int refuse_segments(const enc_options *o) {
    if (!o->checkpoint && o->also_count == 0)
        return 0;
    return nsdf_cli_usage_error("--%s needs one fit, but so long a sequence is fitted in segments%s: --segment 0 fits "
                                "all at once",
                                o->checkpoint ? "checkpoint" : "also",
                                o->checkpoint ? ", which are kept as they are done" : "");
}

static int encode_segments(const enc_options *o, nsdf_sequence *sequence, const nsdf_cli_list *list, outputs *out) {
    enc_plan plan;
    nsdf_encoder_stats stats;
    int code = refuse_segments(o);
    if (code == NSDF_CLI_SUCCESS && enc_parts_check(o->output) != 0)
        code = NSDF_CLI_FAILURE;
    const int planned = code == NSDF_CLI_SUCCESS && enc_plan_make(&plan, o, sequence, list) == 0;
    enc_mpi_announce(planned ? &plan : NULL);
    if (code != NSDF_CLI_SUCCESS)
        return code;
    if (!planned || enc_segments_encode(&plan, &out->file, &stats) != 0 ||
        (o->report && enc_report_write(&out->report, o, &stats, out->also_bytes, 0) != 0) || nsdf_cli_commit() != 0)
        code = NSDF_CLI_FAILURE;
    if (code == NSDF_CLI_SUCCESS) {
        enc_segments_done(&plan);
        summarise(o, &stats);
        code = judge_target(o, &stats);
    }
    enc_plan_free(&plan);
    return code;
}

/* The frames are in the encoder's hands once the sequence is closed. */
static int encode_whole(const enc_options *o, nsdf_encoder *encoder, nsdf_sequence **sequence,
                        const nsdf_cli_list *list, outputs *out) {
    enc_mpi_announce(NULL);
    if (add_frames(list, encoder, *sequence) != 0)
        return NSDF_CLI_FAILURE;
    nsdf_sequence_close(sequence);
    return encode(o, encoder, out);
}

/* The chosen frames, in segments or not; `code` says whether they could be chosen. */
static int encode_frames(const enc_options *o, nsdf_encoder *encoder, nsdf_sequence **sequence,
                         const nsdf_cli_list *list, int code, outputs *out) {
    const int segments = code == NSDF_CLI_SUCCESS ? enc_plan_needed(o, *sequence, list) : 0;
    if (code == NSDF_CLI_SUCCESS && (segments < 0 || open_outputs(o, out) != 0))
        code = NSDF_CLI_FAILURE;
    if (code != NSDF_CLI_SUCCESS) {
        enc_mpi_announce(NULL);
        return code;
    }
    return segments ? encode_segments(o, *sequence, list, out) : encode_whole(o, encoder, sequence, list, out);
}

static void warn_about_gaps(const nsdf_sequence *sequence) {
    char missing[400];
    (void)enc_explain_missing(sequence, missing, sizeof missing);
    if (*missing)
        nsdf_cli_warn("%s", missing);
}

/* Everything from open inputs on; out is released by the caller. */
static int encode_sequence(const enc_options *o, nsdf_encoder *encoder, nsdf_sequence **sequence, outputs *out) {
    nsdf_cli_list list;
    int code = enc_choose_frames(o, *sequence, &list);
    if (code == NSDF_CLI_SUCCESS && !o->check && enc_mpi_rank() == 0)
        warn_about_gaps(*sequence);
    if (code == NSDF_CLI_SUCCESS && o->check) {
        code = enc_mpi_rank() == 0 ? enc_check(o, *sequence, &list) : NSDF_CLI_SUCCESS;
        enc_mpi_announce(NULL);
    } else if (enc_mpi_rank() == 0)
        code = encode_frames(o, encoder, sequence, &list, code, out);
    else if (code == NSDF_CLI_SUCCESS)
        code = enc_mpi_serve(o, *sequence, &list);
    nsdf_cli_list_free(&list);
    nsdf_sequence_close(sequence);
    return code;
}

/* Opens the inputs, whose frame rate the options take over.  0, or -1 after printing why. */
static int open_sequence(enc_options *o, nsdf_sequence **sequence) {
    nsdf_encoder_error error;
    nsdf_sequence_options options;
    nsdf_sequence_options_init(&options);
    options.rate_num = o->rate_given ? o->encoder.rate_num : 0;
    options.rate_den = o->rate_given ? o->encoder.rate_den : 0;
    options.ignore_numbers = o->ignore_numbers;
    if (nsdf_sequence_open(sequence, o->inputs, o->input_count, &options, &error) != NSDF_OK) {
        nsdf_cli_error("%s", error.message);
        return -1;
    }
    nsdf_sequence_rate(*sequence, &o->encoder.rate_num, &o->encoder.rate_den);
    if (*nsdf_sequence_note(*sequence) && enc_mpi_rank() == 0)
        nsdf_cli_warn("%s: %s", o->inputs[0], nsdf_sequence_note(*sequence));
    return 0;
}

/* A new encoder in place of *encoder.  0, or the exit code after printing what is wrong with the options. */
static int create_encoder(const enc_options *o, nsdf_encoder **encoder) {
    nsdf_encoder_error error;
    nsdf_encoder_close(encoder);
    return nsdf_encoder_create(encoder, &o->encoder, &error) == NSDF_OK ? 0 : nsdf_cli_usage_error("%s", error.message);
}

static int encode_inputs(enc_options *o, nsdf_encoder **encoder) {
    nsdf_sequence *sequence = NULL;
    outputs out;
    init_outputs(&out);
    int code = open_sequence(o, &sequence) == 0 ? create_encoder(o, encoder) : NSDF_CLI_FAILURE;
    if (code == 0)
        code = encode_sequence(o, *encoder, &sequence, &out);
    nsdf_sequence_close(&sequence);
    drop_outputs(&out);
    nsdf_cli_abort(); /* after success nothing is left to remove */
    return code;
}

int main(int argc, char **argv) {
    enc_options options;
    nsdf_encoder *encoder = NULL;
    nsdf_cli_begin("nsdf-enc");
    if (enc_mpi_begin(&argc, &argv) != 0)
        return NSDF_CLI_FAILURE;
    int code = enc_options_parse(&options, argc, argv);
    if (code >= 0)
        return enc_mpi_end(code);
    nsdf_cli_set_verbosity(options.quiet ? -1 : options.verbose);
    code = create_encoder(&options, &encoder); /* before the input is looked at */
    if (code == 0) {
        nsdf_cli_catch_signals();
        code = encode_inputs(&options, &encoder);
    }
    nsdf_encoder_close(&encoder);
    return enc_mpi_end(code);
}

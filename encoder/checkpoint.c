#include "checkpoint.h"

#include "run_identity.h"

#include <string.h>

/* As the signature of .nsdf files, which tells damage by text transfers too; then the layout's number, to be raised
 * with every change of what follows, the fields of the states included. */
static const uint8_t signature[] = {0x89, 'N', 'S', 'D', 'C', 0x0d, 0x0a, 0x1a, 0x0a, 1};
enum { SIGNATURE = sizeof signature - 1, SIZE_AT = sizeof signature, HASH_SIZE = 8, FEWEST = SIZE_AT + 16 + HASH_SIZE };

void nsdf_checkpoint_free(nsdf_checkpoint *checkpoint) {
    nsdf_buffer_free(&checkpoint->identity);
    nsdf_buffer_free(&checkpoint->resumed);
}

/* ---- The program ---------------------------------------------------------------------------------------- */

/* Kernels of the network's fitting round each in its own way; those of the blocks all alike. */
static const char *kernels_name(const nsdf_encoder_options *options) {
    return options->blocks ? "any" : nsdf_fit_kernels_select()->name;
}

/* Shorter than 256 bytes. */
static void write_text(nsdf_buffer *out, const char *text) {
    nsdf_buffer_u8(out, (uint8_t)strlen(text));
    nsdf_buffer_append(out, text, strlen(text));
}

/* Whether the next text is `now`; else the message names both. */
static nsdf_status compare_text(nsdf_cursor *in, const char *now, const char *what, nsdf_encoder_error *error) {
    const int length = nsdf_take_u8(in);
    const uint8_t *then = nsdf_take(in, (size_t)length);
    if (!then)
        return nsdf_encoder_fail(error, NSDF_CORRUPT, "the checkpoint is damaged: %s", in->fault.what);
    if ((size_t)length == strlen(now) && memcmp(then, now, (size_t)length) == 0)
        return NSDF_OK;
    return nsdf_encoder_fail(error, NSDF_UNSUPPORTED_VERSION, "the checkpoint was made by %s %.*s, this is %s", what,
                             length < 64 ? length : 64, (const char *)then, now);
}

/* ---- Opening -------------------------------------------------------------------------------------------- */

/* That the bytes are those that were written. */
static nsdf_status check_bytes(const uint8_t *data, size_t size, nsdf_encoder_error *error) {
    const size_t known = size < SIGNATURE ? size : SIGNATURE;
    if (known == 0 || memcmp(data, signature, known) != 0)
        return nsdf_encoder_fail(error, NSDF_NOT_NSDF, "not a checkpoint");
    if (size > SIGNATURE && data[SIGNATURE] != signature[SIGNATURE])
        return nsdf_encoder_fail(error, NSDF_UNSUPPORTED_VERSION,
                                 "the checkpoint has layout %u, this program reads layout %u", data[SIGNATURE],
                                 signature[SIGNATURE]);
    nsdf_cursor in = nsdf_cursor_start(data, size, SIZE_AT);
    const uint64_t whole = size < FEWEST ? FEWEST : nsdf_take_u64(&in);
    if (size < whole)
        return nsdf_encoder_fail(error, NSDF_TRUNCATED, "the checkpoint is cut off after %zu bytes", size);
    if (size > whole)
        return nsdf_encoder_fail(error, NSDF_CORRUPT, "the checkpoint has %zu bytes, expected %llu", size,
                                 (unsigned long long)whole);
    in.at = size - HASH_SIZE;
    if (nsdf_take_u64(&in) != nsdf_hash64(NSDF_HASH_START, data, size - HASH_SIZE))
        return nsdf_encoder_fail(error, NSDF_CHECKSUM, "the checkpoint is damaged: its checksum does not match");
    return NSDF_OK;
}

nsdf_status nsdf_checkpoint_open(nsdf_checkpoint *checkpoint, const void *data, size_t size,
                                 const nsdf_encoder_options *options, const nsdf_frames *frames, uint64_t *steps,
                                 nsdf_encoder_error *error) {
    nsdf_status status = check_bytes(data, size, error);
    if (status != NSDF_OK)
        return status;
    nsdf_cursor in = nsdf_cursor_start(data, size - HASH_SIZE, SIZE_AT + 8);
    const uint64_t done = nsdf_take_u64(&in);
    status = compare_text(&in, nsdf_version_string(), "version", error);
    if (status == NSDF_OK)
        status = nsdf_identity_compare(&in, options, frames, error);
    if (status == NSDF_OK)
        status = compare_text(&in, kernels_name(options), "kernels", error);
    if (status != NSDF_OK)
        return status;
    nsdf_buffer copy = {0};
    nsdf_buffer_append(&copy, data, size);
    if (copy.failed)
        return nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory for a checkpoint of %zu bytes", size);
    nsdf_buffer_free(&checkpoint->resumed);
    checkpoint->resumed = copy;
    checkpoint->trace_at = in.at;
    if (steps)
        *steps = done;
    return NSDF_OK;
}

/* ---- Fitting -------------------------------------------------------------------------------------------- */

int nsdf_checkpoint_prepare(nsdf_checkpoint *checkpoint, const nsdf_encoder_options *options,
                            const nsdf_frames *frames) {
    if (!checkpoint->save)
        return 0;
    write_text(&checkpoint->identity, nsdf_version_string());
    nsdf_identity_write(&checkpoint->identity, options, frames);
    write_text(&checkpoint->identity, kernels_name(options));
    return checkpoint->identity.failed ? -1 : 0;
}

static uint64_t trace(const nsdf_fit_job *job, const float *values, size_t count) {
    uint64_t hash = nsdf_hash_floats(NSDF_HASH_START, values, count);
    hash = nsdf_hash64(hash, job->u, job->frame_count * sizeof *job->u);
    for (uint32_t f = 0; f < job->frame_count; f++) {
        const nsdf_sample_set *set = &job->samples[f];
        const float *const arrays[] = {set->x, set->y, set->z, set->d};
        for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
            hash = nsdf_hash_floats(hash, arrays[i], set->count);
    }
    return hash;
}

static int restore(nsdf_checkpoint *checkpoint, nsdf_fit_state_fn fields, void *fitting) {
    nsdf_fit_state state = {
        .in = nsdf_cursor_start(checkpoint->resumed.data, checkpoint->resumed.size - HASH_SIZE, checkpoint->trace_at)};
    if (nsdf_take_u64(&state.in) != checkpoint->trace)
        checkpoint->refusal = "it began with other samples or values: another build or processor made it";
    else
        fields(fitting, &state);
    nsdf_state_expect(&state, state.in.at == state.in.size, "bytes behind its end");
    const int failed = checkpoint->refusal || state.in.status != NSDF_PARSE_OK;
    if (failed && !checkpoint->refusal && state.in.status != NSDF_PARSE_NO_MEMORY)
        checkpoint->refusal = state.in.fault.what;
    nsdf_buffer_free(&checkpoint->resumed);
    return failed ? -1 : 0;
}

int nsdf_checkpoint_begin(nsdf_checkpoint *checkpoint, const nsdf_fit_job *job, const float *values, size_t count,
                          nsdf_fit_state_fn fields, void *fitting) {
    if (!checkpoint || (!checkpoint->save && !checkpoint->resumed.data))
        return 0;
    checkpoint->trace = trace(job, values, count);
    checkpoint->saved_at = nsdf_clock();
    return checkpoint->resumed.data ? restore(checkpoint, fields, fitting) : 0;
}

int nsdf_checkpoint_due(const nsdf_checkpoint *checkpoint, int last_step) {
    return checkpoint && checkpoint->save && (last_step || nsdf_clock() - checkpoint->saved_at >= checkpoint->seconds);
}

int nsdf_checkpoint_save(nsdf_checkpoint *checkpoint, uint64_t steps, nsdf_fit_state_fn fields, void *fitting) {
    if (!checkpoint || !checkpoint->save || checkpoint->saved_steps == steps)
        return 0;
    nsdf_buffer bytes = {0};
    nsdf_fit_state state = {.out = &bytes};
    nsdf_buffer_append(&bytes, signature, sizeof signature);
    nsdf_buffer_u64(&bytes, 0);
    nsdf_buffer_u64(&bytes, steps);
    nsdf_buffer_append(&bytes, checkpoint->identity.data, checkpoint->identity.size);
    nsdf_buffer_u64(&bytes, checkpoint->trace);
    fields(fitting, &state);
    if (!bytes.failed) {
        const uint64_t whole = bytes.size + HASH_SIZE;
        for (size_t i = 0; i < 8; i++)
            bytes.data[SIZE_AT + i] = (uint8_t)(whole >> 8 * i);
        nsdf_buffer_u64(&bytes, nsdf_hash64(NSDF_HASH_START, bytes.data, bytes.size));
    }
    const int failed = bytes.failed;
    if (!failed)
        checkpoint->save(checkpoint->user, bytes.data, bytes.size);
    nsdf_buffer_free(&bytes);
    checkpoint->saved_at = nsdf_clock();
    checkpoint->saved_steps = steps;
    return failed ? -1 : 0;
}

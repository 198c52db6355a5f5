#include "enc_segments.h"

#include "enc_mpi.h"
#include "nsdf/mux.h"

#include <math.h>
#include <string.h>

/* ---- Joining ------------------------------------------------------------------------------------------------ */

static nsdf_status join(const enc_plan *plan, uint32_t segment, const enc_part *part, nsdf_mux **whole,
                        nsdf_encoder_error *error) {
    nsdf_mux *mux = NULL;
    nsdf_status status = nsdf_mux_open(&mux, part->file, part->size, error);
    if (status != NSDF_OK)
        return status;
    if (!*whole) {
        *whole = mux;
        return NSDF_OK;
    }
    status = nsdf_mux_append(*whole, mux, enc_plan_fade(plan, segment), error);
    nsdf_mux_close(&mux);
    return status;
}

/* Sums, and what is largest; the quality comes from the joined file. */
static void add_stats(nsdf_encoder_stats *sum, const nsdf_encoder_stats *s) {
    nsdf_join_reports(&sum->input, &s->input);
    sum->diagonal = s->diagonal;
    sum->blocks += s->blocks;
    sum->bones += s->bones;
    sum->unfollowed |= s->unfollowed;
    sum->came_apart |= s->came_apart;
    sum->block_bytes.places += s->block_bytes.places;
    sum->block_bytes.influences += s->block_bytes.influences;
    sum->block_bytes.motion += s->block_bytes.motion;
    sum->block_bytes.levels += s->block_bytes.levels;
    sum->block_bytes.shapes += s->block_bytes.shapes;
    sum->parameters += s->parameters;
    sum->steps += s->steps;
    sum->samples += s->samples;
    sum->fit_error = fmax(sum->fit_error, s->fit_error);
    sum->bound = fmax(sum->bound, s->bound);
    sum->stray_pieces += s->stray_pieces;
    sum->seconds_sample += s->seconds_sample;
    sum->seconds_fit += s->seconds_fit;
    sum->seconds_code += s->seconds_code;
    sum->seconds_verify += s->seconds_verify;
}

static int join_all(const enc_parts *parts, nsdf_mux **whole, nsdf_encoder_stats *stats) {
    for (uint32_t i = 0; i < parts->plan->count; i++) {
        enc_part part;
        nsdf_encoder_error error;
        if (enc_part_read(parts, i, &part) != 0) {
            nsdf_cli_error("segment %u is gone from '%s'", i + 1, parts->folder);
            return -1;
        }
        const nsdf_status status = join(parts->plan, i, &part, whole, &error);
        add_stats(stats, &part.stats);
        enc_part_free(&part);
        if (status != NSDF_OK) {
            nsdf_cli_error("segment %u: %s", i + 1, error.message);
            return -1;
        }
    }
    return 0;
}

/* ---- The file ----------------------------------------------------------------------------------------------- */

typedef struct counted_file {
    nsdf_cli_file *file;
    uint64_t size;
} counted_file;

static int write_counted(void *user, const void *data, size_t size) {
    counted_file *c = user;
    c->size += size;
    return nsdf_cli_file_write(c->file, data, size);
}

static int write_whole(const nsdf_mux *whole, nsdf_cli_file *file, uint64_t *size) {
    nsdf_encoder_error error;
    counted_file counted = {file, 0};
    const nsdf_status status = nsdf_mux_write(whole, write_counted, &counted, &error);
    *size = counted.size;
    if (nsdf_cli_file_close(file) != 0)
        return -1; /* says why, also when a write failed */
    if (status != NSDF_OK)
        nsdf_cli_error("%s", error.message);
    return status == NSDF_OK ? 0 : -1;
}

/* Whether the whole is what was asked for, as nsdf_encoder_stats.target_met says of one segment. */
static int is_met(const enc_plan *plan, const nsdf_encoder_stats *s) {
    const nsdf_encoder_options *o = &plan->options->encoder;
    const double size = enc_plan_size(plan);
    if (size > 0.0)
        return (double)s->file_size <= size && (double)s->file_size >= 0.97 * size;
    return !(o->target_error > 0.0) || nsdf_mean_error(&s->quality) <= o->target_error;
}

static void describe(const enc_plan *plan, const nsdf_mux *whole, nsdf_encoder_stats *stats) {
    stats->frames = plan->list->count;
    stats->nominal_frames = nsdf_mux_frame_count(whole);
    stats->triangles = plan->triangles;
    nsdf_quality quality;
    if (nsdf_mux_get_quality(whole, &quality) == NSDF_OK)
        stats->quality = quality;
    stats->target_met = is_met(plan, stats);
}

int enc_segments_encode(const enc_plan *plan, nsdf_cli_file *file, nsdf_encoder_stats *stats) {
    enc_parts parts;
    nsdf_mux *whole = NULL;
    memset(stats, 0, sizeof *stats);
    nsdf_cli_verbose("%u segments, of %u frames on average", plan->count, plan->list->count / plan->count);
    int failed = enc_parts_open(&parts, plan, plan->options->output) != 0 || enc_mpi_run(&parts) != 0 ||
                 join_all(&parts, &whole, stats) != 0 || write_whole(whole, file, &stats->file_size) != 0;
    if (!failed)
        describe(plan, whole, stats);
    nsdf_mux_close(&whole);
    enc_parts_free(&parts);
    return failed ? -1 : 0;
}

void enc_segments_done(const enc_plan *plan) {
    enc_parts parts;
    if (enc_parts_open(&parts, plan, plan->options->output) == 0)
        enc_parts_remove(&parts);
    enc_parts_free(&parts);
}

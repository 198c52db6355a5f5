#include "encode_run.h"

#include "bound.h"
#include "verify_segment.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const float largest_speck = 0.125f;

/* Verification extracts blocks with at least this bound, which finds small pieces that the file's might leave out; the
 * file gets the bound that they need, and a little more for resolutions that were not tried. */
static const double least_verified = 2.0, bound_margin = 1.05;

/* Half of the input's smallest piece, so that decoded ones may be smaller, but not so large that a piece that a coarse
 * grid cuts off would go. */
float nsdf_run_smallest_piece(const nsdf_run *r) {
    const double asked = r->encoder->options.smallest_piece;
    return asked < 0.0 ? fminf(0.5f * nsdf_frames_smallest_piece(&r->encoder->frames), largest_speck) : (float)asked;
}

static int code_network(nsdf_run *r) {
    nsdf_encoder *e = r->encoder;
    const nsdf_quantise_params quantise = {e->options.weight_bits, 1};
    if (!e->options.quantise_aware)
        nsdf_choose_quantisers(&e->model, &quantise, e->parameters);
    return nsdf_code_segment(&e->model, e->parameters, &r->segment);
}

nsdf_status nsdf_run_code(nsdf_run *r) {
    nsdf_encoder *e = r->encoder;
    const int has_blocks = e->blocks.values != NULL;
    r->segment.payload.size = 0;
    e->entry.smallest_piece = nsdf_run_smallest_piece(r);
    if ((has_blocks ? nsdf_code_blocks(&e->blocks, &r->segment) : code_network(r)) != 0 ||
        nsdf_assemble_file(&e->header, &e->entry, &r->segment, NULL, &e->file) != 0)
        return nsdf_encoder_fail(r->error, NSDF_INTERNAL, "the %s cannot be coded",
                                 has_blocks ? "blocks" : "parameters");
    return NSDF_OK;
}

static void copy_quality(const nsdf_quality_record *q, nsdf_quality *out) {
    nsdf_quality public = {q->mean[0], q->mean[1], q->rms[0],     q->rms[1],
                           q->max[0],  q->max[1],  q->resolution, q->frames};
    *out = public;
}

static nsdf_status assemble(nsdf_run *r, const nsdf_quality_record *quality) {
    nsdf_encoder *e = r->encoder;
    if (nsdf_assemble_file(&e->header, &e->entry, &r->segment, quality, &e->file) != 0)
        return nsdf_encoder_fail(r->error, NSDF_NO_MEMORY, "out of memory");
    return NSDF_OK;
}

void nsdf_run_forget_strays(nsdf_run *r) {
    for (uint32_t i = 0; r->strays && i < r->encoder->frames.count; i++)
        nsdf_sample_set_free(&r->strays[i]);
    if (r->strays)
        memset(r->strays, 0, r->encoder->frames.count * sizeof *r->strays);
}

/* Verifies all frames that are shown, or some that stand for them. */
static nsdf_status verify_frames(nsdf_run *r, const nsdf_check_job *job, nsdf_piece_report *pieces) {
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
    nsdf_run_forget_strays(r);
    for (uint32_t i = 0; strays && i < part.frames.count; i++)
        r->strays[nsdf_frames_find(&e->frames, part.frames.frames[i].number)] = strays[i];
    free(strays);
    nsdf_check_part_free(&part);
    return status;
}

static nsdf_status verify(nsdf_run *r, const nsdf_check_job *job) {
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
static nsdf_status measure(nsdf_run *r, double *seconds_bound) {
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
static nsdf_status check(nsdf_run *r, double *seconds_bound) {
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

nsdf_status nsdf_run_code_and_check(nsdf_run *r) {
    nsdf_encoder_stats *stats = &r->encoder->stats;
    double began = nsdf_clock(), bound = 0.0;
    nsdf_status status = nsdf_run_code(r);
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

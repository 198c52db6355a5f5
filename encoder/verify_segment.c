#include "verify_segment.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A piece of this share of the input's smallest one is part of the surface, if badly fitted. */
static const float true_share = 0.75f;
/* Specks at other times than the frames', and at other resolutions, are a little larger. */
static const float speck_margin = 1.1f;

bool nsdf_suit_smallest_piece(const nsdf_piece_report *pieces, const nsdf_frames *frames,
                              const nsdf_encoder_options *options, float *size) {
    if (options->smallest_piece >= 0.0)
        return false;
    if (pieces->smallest_lost < *size) {
        *size = true_share * pieces->smallest_lost;
        return true;
    }
    const float least = pieces->largest_stray * speck_margin;
    const float most = fminf(pieces->smallest_true, true_share * nsdf_frames_smallest_piece(frames));
    if (pieces->stray == 0 || !(least < most))
        return false;
    *size = least;
    return true;
}

/* What the rounds of one segment share. */
typedef struct {
    const nsdf_check_job *job;
    nsdf_workers *workers;
    const nsdf_coded_segment *segment;
    nsdf_index_entry *entry;
    nsdf_quality_record *quality;
    nsdf_piece_report *pieces;
    nsdf_frame_check *checks;
    nsdf_sample_set *strays;
    nsdf_encoder_error *error;
} rounds;

static void sum_up(const rounds *r) {
    const uint32_t frames = r->job->frames->count;
    *r->quality = nsdf_quality_of_checks(r->checks, frames, r->job->options->resolution);
    *r->pieces = nsdf_pieces_of_checks(r->checks, frames);
}

static nsdf_status verify_with(const rounds *r, float size) {
    nsdf_buffer file = {NULL, 0, 0, 0};
    nsdf_status status = NSDF_NO_MEMORY;
    r->entry->smallest_piece = size;
    if (r->checks && nsdf_assemble_file(r->job->header, r->entry, r->segment, NULL, &file) == 0)
        status = nsdf_verify_file(r->job, r->workers, &file, r->checks, r->strays, r->error);
    else
        (void)nsdf_encoder_fail(r->error, status, "out of memory");
    nsdf_buffer_free(&file);
    if (status == NSDF_OK)
        sum_up(r);
    return status;
}

/* ---- Another size ------------------------------------------------------------------------------------------- */

/* Beside the frames that ask for another size, about so many of the others tell what it does to them. */
enum { TRIED_FRAMES = 12 };

/* Both ways: what is missing and what is too much. */
static double error_of(const nsdf_frame_check *check) {
    return check->mean[0] + check->mean[1];
}

static bool asks(const nsdf_frame_check *check) {
    return check->pieces.stray > 0 || isfinite(check->pieces.smallest_lost);
}

static bool is_tried(const nsdf_frame_check *checks, uint32_t frame, uint32_t frames) {
    return asks(&checks[frame]) || frame % (1 + frames / TRIED_FRAMES) == 0;
}

/* All frames but those that are tried count as verified with a size. */
static void set_others(nsdf_frame_check *checks, const nsdf_frame_check *before, uint32_t frames, float size) {
    for (uint32_t f = 0; f < frames; f++)
        if (!is_tried(before, f, frames))
            checks[f].size = size;
}

/* What all frames together gain, judged by those that were tried. */
static double gain(const nsdf_frame_check *checks, const nsdf_frame_check *before, uint32_t frames) {
    double asking = 0.0, others = 0.0;
    uint32_t tried = 0, left = 0;
    for (uint32_t f = 0; f < frames; f++) {
        const double more = error_of(&before[f]) - error_of(&checks[f]);
        asking += asks(&before[f]) ? more : 0.0;
        others += asks(&before[f]) ? 0.0 : more; /* 0 where it was not tried */
        tried += !asks(&before[f]) && is_tried(before, f, frames);
        left += !asks(&before[f]);
    }
    return asking + (tried > 0 ? others * left / tried : 0.0);
}

/* What verification found. */
typedef struct {
    nsdf_frame_check *checks;
    nsdf_sample_set *strays;
} findings;

static void free_strays(nsdf_sample_set *strays, uint32_t frames) {
    for (uint32_t f = 0; strays && f < frames; f++)
        nsdf_sample_set_free(&strays[f]);
}

static void free_findings(findings *kept, uint32_t frames) {
    free_strays(kept->strays, frames);
    free(kept->strays);
    free(kept->checks);
}

static int copy_findings(const rounds *r, uint32_t frames, findings *copy) {
    copy->checks = malloc(frames * sizeof *copy->checks);
    copy->strays = calloc(frames, sizeof *copy->strays);
    int failed = !copy->checks || !copy->strays;
    for (uint32_t f = 0; f < frames && !failed; f++) {
        copy->checks[f] = r->checks[f];
        failed = nsdf_sample_set_copy(&r->strays[f], &copy->strays[f]) != 0;
    }
    return failed ? -1 : 0;
}

/* The copies are used up. */
static void take_back(const rounds *r, float size, uint32_t frames, findings *kept) {
    free_strays(r->strays, frames);
    for (uint32_t f = 0; f < frames; f++) {
        r->checks[f] = kept->checks[f];
        r->strays[f] = kept->strays[f];
        kept->strays[f] = (nsdf_sample_set){0};
    }
    r->entry->smallest_piece = size;
    sum_up(r);
}

/* Tries it on some frames, and takes it for all if they gain. */
static nsdf_status try_size(const rounds *r, float first, float size) {
    const uint32_t frames = r->job->frames->count;
    findings before;
    nsdf_status status = NSDF_NO_MEMORY;
    if (copy_findings(r, frames, &before) == 0) {
        set_others(r->checks, before.checks, frames, size);
        status = verify_with(r, size);
    } else {
        (void)nsdf_encoder_fail(r->error, status, "out of memory");
    }
    if (status == NSDF_OK && gain(r->checks, before.checks, frames) > 0.0) {
        set_others(r->checks, before.checks, frames, first);
        status = verify_with(r, size);
    } else if (status == NSDF_OK) {
        take_back(r, first, frames, &before);
    }
    free_findings(&before, frames);
    return status;
}

nsdf_status nsdf_verify_segment(const nsdf_check_job *job, nsdf_workers *workers, const nsdf_coded_segment *segment,
                                nsdf_index_entry *entry, nsdf_quality_record *quality, nsdf_piece_report *pieces,
                                nsdf_sample_set *strays, nsdf_encoder_error *error) {
    const rounds r = {
        job,    workers, segment, entry, quality, pieces, calloc(job->frames->count, sizeof(nsdf_frame_check)),
        strays, error};
    const float first = entry->smallest_piece;
    float size = first;
    nsdf_status status = verify_with(&r, first);
    if (status == NSDF_OK && nsdf_suit_smallest_piece(pieces, job->all, job->options, &size))
        status = try_size(&r, first, size);
    free(r.checks);
    return status;
}

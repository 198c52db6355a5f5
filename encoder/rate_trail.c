#include "rate_trail.h"

#include "verify.h"

#include <stdlib.h>
#include <string.h>

enum { QUICK_FRAMES = 12 };
static const float safe_bound = 4.0f; /* nothing is skipped wrongly; the true one is found at the end (bound.c) */

void nsdf_rate_note(const nsdf_rate_job *job, const nsdf_rate_round *round) {
    nsdf_encoder_stats *s = job->stats;
    if (s->round_count < NSDF_MOST_RATE_ROUNDS)
        s->round_count++;
    s->rounds[s->round_count - 1] = *round;
}

int nsdf_rate_make_file(const nsdf_rate_job *job, const nsdf_coded_segment *segment, nsdf_buffer *file) {
    const nsdf_quality_record none = {0};
    nsdf_file_header header = *job->fit.header;
    header.extraction_bound = safe_bound;
    return nsdf_assemble_file(&header, job->entry, segment, job->fit.options->verify ? &none : NULL, file);
}

nsdf_status nsdf_rate_quick_error(const nsdf_rate_job *job, const nsdf_buffer *file, double *mean,
                                  nsdf_encoder_error *error) {
    const nsdf_frames *all = job->shown;
    nsdf_frame few[QUICK_FRAMES];
    nsdf_sample_set strays[QUICK_FRAMES];
    nsdf_frames some = *all;
    nsdf_quality_record found;
    nsdf_piece_report pieces;
    some.frames = few;
    some.count = all->count < QUICK_FRAMES ? all->count : QUICK_FRAMES;
    /* From the first one on, which tells the times of the others. */
    for (uint32_t i = 0; i < some.count; i++)
        few[i] = all->frames[(uint64_t)i * all->count / some.count];
    memset(strays, 0, sizeof strays);
    const nsdf_check_job check = {&some, job->fit.header, job->fit.options, NULL, NULL, job->fit.start_time};
    const nsdf_status status = nsdf_verify_file(&check, job->fit.workers, file, &found, &pieces, strays, error);
    for (uint32_t i = 0; i < some.count; i++)
        nsdf_sample_set_free(&strays[i]);
    if (status == NSDF_OK)
        *mean = found.mean[0] > found.mean[1] ? found.mean[0] : found.mean[1];
    return status;
}

#include "rate_trail.h"

#include "verify_segment.h"

#include <math.h>
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
    return nsdf_assemble_file(job->fit.header, &job->entry, segment, job->fit.options->verify ? &none : NULL, file);
}

nsdf_status nsdf_rate_quick_error(const nsdf_rate_job *job, const nsdf_coded_segment *segment, nsdf_quick_error *quick,
                                  nsdf_encoder_error *error) {
    nsdf_frame few[QUICK_FRAMES];
    nsdf_sample_set strays[QUICK_FRAMES];
    nsdf_file_header header = *job->fit.header;
    nsdf_index_entry entry = job->entry;
    nsdf_quality_record found;
    nsdf_piece_report pieces;
    nsdf_buffer file = {NULL, 0, 0, 0};
    const nsdf_frames some = nsdf_frames_pick(job->shown, QUICK_FRAMES, few);
    const nsdf_check_job check = {&some, &header, job->fit.options, NULL, NULL, job->fit.start_time, job->fit.frames};
    header.extraction_bound = safe_bound;
    memset(strays, 0, sizeof strays);
    if (nsdf_rate_make_file(job, segment, &file) != 0)
        return nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory while fitting");
    quick->bytes = file.size;
    nsdf_buffer_free(&file);
    const nsdf_status status =
        nsdf_verify_segment(&check, job->fit.workers, segment, &entry, &found, &pieces, strays, error);
    for (uint32_t i = 0; i < some.count; i++)
        nsdf_sample_set_free(&strays[i]);
    if (status == NSDF_OK) {
        quick->mean = fmax(found.mean[0], found.mean[1]);
        quick->back_by_decoded = found.mean[1] / fmax(found.mean[0], 1e-30);
    }
    return status;
}

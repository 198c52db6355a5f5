#include "rate_trail.h"

#include "verify.h"

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

static int make_file(const nsdf_rate_job *job, const nsdf_index_entry *entry, const nsdf_coded_segment *segment,
                     nsdf_buffer *file) {
    const nsdf_quality_record none = {0};
    nsdf_file_header header = *job->fit.header;
    header.extraction_bound = safe_bound;
    return nsdf_assemble_file(&header, entry, segment, job->fit.options->verify ? &none : NULL, file);
}

int nsdf_rate_make_file(const nsdf_rate_job *job, const nsdf_coded_segment *segment, nsdf_buffer *file) {
    return make_file(job, &job->entry, segment, file);
}

/* From the first one on, which tells the times of the others. */
static nsdf_frames some_of(const nsdf_frames *all, nsdf_frame few[QUICK_FRAMES]) {
    nsdf_frames some = *all;
    some.frames = few;
    some.count = all->count < QUICK_FRAMES ? all->count : QUICK_FRAMES;
    for (uint32_t i = 0; i < some.count; i++)
        few[i] = all->frames[(uint64_t)i * all->count / some.count];
    return some;
}

static nsdf_status check_file(const nsdf_rate_job *job, const nsdf_frames *frames, const nsdf_buffer *file,
                              nsdf_quick_error *quick, nsdf_piece_report *pieces, nsdf_encoder_error *error) {
    nsdf_sample_set strays[QUICK_FRAMES];
    nsdf_quality_record found;
    memset(strays, 0, sizeof strays);
    const nsdf_check_job check = {frames, job->fit.header, job->fit.options, NULL, NULL, job->fit.start_time};
    const nsdf_status status = nsdf_verify_file(&check, job->fit.workers, file, &found, pieces, strays, error);
    for (uint32_t i = 0; i < frames->count; i++)
        nsdf_sample_set_free(&strays[i]);
    if (status == NSDF_OK) {
        quick->mean = fmax(found.mean[0], found.mean[1]);
        quick->back_by_decoded = found.mean[1] / fmax(found.mean[0], 1e-30);
    }
    return status;
}

nsdf_status nsdf_rate_quick_error(const nsdf_rate_job *job, const nsdf_coded_segment *segment, nsdf_quick_error *quick,
                                  nsdf_encoder_error *error) {
    nsdf_frame few[QUICK_FRAMES];
    const nsdf_frames some = some_of(job->shown, few);
    nsdf_index_entry entry = job->entry;
    nsdf_piece_report pieces = {0, 0.0f, 0.0f, 0.0};
    nsdf_buffer file = {NULL, 0, 0, 0};
    nsdf_status status = NSDF_OK;
    for (int again = 1, round = 0; status == NSDF_OK && again; round++) {
        if (make_file(job, &entry, segment, &file) != 0)
            status = nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory while fitting");
        else
            status = check_file(job, &some, &file, quick, &pieces, error);
        again = round == 0 && nsdf_specks_can_go(&pieces, job->fit.frames, job->fit.options, &entry.smallest_piece);
    }
    quick->bytes = file.size;
    nsdf_buffer_free(&file);
    return status;
}

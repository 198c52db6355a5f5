#include "check_time.h"

#include "bound.h"
#include "fit.h"
#include "verify.h"

#include <stdlib.h>

/* Of all frames that the job has. */
static nsdf_status check(const nsdf_check_job *job, nsdf_workers *workers, const nsdf_coded_segment *segment,
                         const nsdf_index_entry *entry, nsdf_frame_check *checks, nsdf_sample_set *strays,
                         nsdf_check_time *seconds, nsdf_encoder_error *error) {
    nsdf_file_header header = *job->header;
    nsdf_buffer file = {NULL, 0, 0, 0};
    int failed = nsdf_assemble_file(&header, entry, segment, NULL, &file);
    nsdf_status status = NSDF_OK;
    const double began = nsdf_clock();
    if (!failed)
        status = nsdf_measure_bound(job, &file, 0, &header.extraction_bound, error);
    const double bound = nsdf_clock();
    if (!failed && status == NSDF_OK)
        failed = nsdf_assemble_file(&header, entry, segment, NULL, &file); /* with that bound */
    if (!failed && status == NSDF_OK && job->options->verify)
        status = nsdf_verify_file(job, workers, &file, checks, strays, error);
    *seconds = (nsdf_check_time){(bound - began) / job->frames->count, (nsdf_clock() - bound) / job->frames->count};
    nsdf_buffer_free(&file);
    return failed ? nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory") : status;
}

nsdf_status nsdf_time_check(const nsdf_check_job *job, nsdf_workers *workers, const nsdf_coded_segment *segment,
                            const nsdf_index_entry *entry, nsdf_check_time *seconds, nsdf_encoder_error *error) {
    const uint32_t count = nsdf_workers_count(workers); /* verification takes one for each */
    nsdf_check_part part;
    nsdf_frame_check *checks = calloc(count, sizeof *checks);
    nsdf_sample_set *strays = calloc(count, sizeof *strays);
    nsdf_status status = NSDF_NO_MEMORY;
    if (nsdf_check_part_pick(&part, job, count) == 0 && checks && strays) {
        part.job.progress = NULL;
        status = check(&part.job, workers, segment, entry, checks, strays, seconds, error);
    } else {
        (void)nsdf_encoder_fail(error, status, "out of memory");
    }
    for (uint32_t i = 0; strays && i < count; i++)
        nsdf_sample_set_free(&strays[i]);
    free(strays);
    free(checks);
    nsdf_check_part_free(&part);
    return status;
}

/* Samples for blocks that leave pieces of surface where the input has none. */
#ifndef NSDF_BLOCK_MEND_H
#define NSDF_BLOCK_MEND_H

#include "block_model.h"
#include "fit.h"

/* Mending is worth it where the mean distance back to the input is so many times that to the decoded surface. */
#define NSDF_ASTRAY 1.25
/* Of the steps of a whole fit. */
#define NSDF_MEND_SHARE 0.15

/* The job's samples; in frames with strays (strays[frame], as nsdf_verify_file finds them) some of them, twice as many
 * as there are strays but no more than an eighth, give way to these points and to some of the empty room around them.
 * sets[job->frame_count] borrow what stays as it was until nsdf_mended_samples_free.  Returns 0, or -1 when memory ran
 * out; then there is nothing to free. */
int nsdf_mend_samples(const nsdf_fit_job *job, const nsdf_sample_set *strays, nsdf_sample_set *sets);
void nsdf_mended_samples_free(const nsdf_fit_job *job, nsdf_sample_set *sets);

/* nsdf_block_fit_run with these samples, or with the job's where no frame has strays. */
int nsdf_fit_mended(const nsdf_fit_job *job, const nsdf_sample_set *strays, nsdf_block_model *model,
                    nsdf_fit_result *result);

#endif

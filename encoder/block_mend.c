#include "block_mend.h"

#include "block_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of a frame's samples at most one in so many gives way, fewer where fewer points are astray: each of these is wanted
 * twice.  More would be fitted at the cost of the surface. */
enum { EVERY = 8, SAMPLES_OF_STRAY = 2 };

typedef struct {
    const nsdf_fit_job *job;
    const nsdf_sample_set *strays;
    nsdf_sample_set *sets;
    int failed;
} mending;

/* A point of a stray piece, or one nearer to it than the input's surface is: what lies inside of the piece has to go
 * as well. */
static void take_stray(const nsdf_sample_set *strays, size_t i, const nsdf_sdf *sdf, nsdf_random *random,
                       nsdf_sample_set *set, size_t to) {
    const size_t from = i / 2 % strays->count;
    float p[3] = {strays->x[from], strays->y[from], strays->z[from]};
    if (i % 2 == 1)
        for (int k = 0; k < 3; k++)
            p[k] += (nsdf_random_unit(random) - 0.5f) * fabsf(strays->d[from]);
    set->x[to] = p[0];
    set->y[to] = p[1];
    set->z[to] = p[2];
    set->d[to] = i % 2 == 1 ? nsdf_sdf_distance(sdf, p) : strays->d[from];
}

static size_t stride_of(const nsdf_sample_set *samples, const nsdf_sample_set *strays) {
    const size_t stride = samples->count / (SAMPLES_OF_STRAY * strays->count);
    return stride > EVERY ? stride : EVERY;
}

static void mend_frame(void *data, uint32_t f, uint32_t worker) {
    mending *m = data;
    const nsdf_sample_set *strays = &m->strays[f];
    nsdf_random random = nsdf_random_start(m->job->options->seed, 0x200000000u + f);
    (void)worker;
    if (strays->count == 0)
        return;
    nsdf_sdf *sdf = nsdf_frame_sdf(&m->job->frames->frames[f]);
    const size_t stride = stride_of(&m->job->samples[f], strays);
    if (!sdf || nsdf_sample_set_copy(&m->job->samples[f], &m->sets[f]) != 0)
        m->failed = 1;
    else
        for (size_t to = 0, i = 0; to < m->sets[f].count; to += stride)
            take_stray(strays, i++, sdf, &random, &m->sets[f], to);
    nsdf_sdf_free(sdf);
}

int nsdf_mend_samples(const nsdf_fit_job *job, const nsdf_sample_set *strays, nsdf_sample_set *sets) {
    mending m = {job, strays, sets, 0};
    memcpy(sets, job->samples, job->frame_count * sizeof *sets);
    nsdf_workers_run(job->workers, job->frame_count, mend_frame, &m);
    if (m.failed)
        nsdf_mended_samples_free(job, sets);
    return m.failed ? -1 : 0;
}

void nsdf_mended_samples_free(const nsdf_fit_job *job, nsdf_sample_set *sets) {
    for (uint32_t f = 0; f < job->frame_count; f++)
        if (sets[f].x != job->samples[f].x)
            nsdf_sample_set_free(&sets[f]);
}

static int any_strays(const nsdf_sample_set *strays, uint32_t frames) {
    for (uint32_t f = 0; f < frames; f++)
        if (strays[f].count > 0)
            return 1;
    return 0;
}

int nsdf_fit_mended(const nsdf_fit_job *job, const nsdf_sample_set *strays, nsdf_block_model *model,
                    nsdf_fit_result *result) {
    nsdf_fit_job mended = *job;
    if (!any_strays(strays, job->frame_count))
        return nsdf_block_fit_run(job, model, result);
    nsdf_sample_set *sets = malloc(job->frame_count * sizeof *sets);
    int failed = !sets || nsdf_mend_samples(job, strays, sets) != 0;
    if (!failed) {
        mended.samples = sets;
        failed = nsdf_block_fit_run(&mended, model, result);
        nsdf_mended_samples_free(job, sets);
    }
    free(sets);
    return failed ? -1 : 0;
}

#include "block_lives.h"

#include <math.h>
#include <stdlib.h>

/* Of a ball's radius: next to its border a block's weight is nothing. */
static const float surface_within = 0.9f;

typedef struct {
    const nsdf_block_model *model;
    const nsdf_frames *frames;
    const double *u;
    nsdf_block_frame *at; /* [worker] */
    uint8_t *holds;       /* [frame][block]: whether there is surface in the ball */
    uint8_t *failed;      /* [frame] */
} job;

static float longest_reach(const float reach[6]) {
    return 0.5f * fmaxf(reach[3] - reach[0], fmaxf(reach[4] - reach[1], reach[5] - reach[2]));
}

static void look_at_frame(void *data, uint32_t f, uint32_t worker) {
    const job *j = data;
    nsdf_block_frame *at = &j->at[worker];
    uint8_t *holds = j->holds + (size_t)f * j->model->desc.block_count;
    nsdf_sdf *sdf = nsdf_sdf_create_unsigned(nsdf_frame_outer(&j->frames->frames[f]));
    j->failed[f] = !sdf;
    if (!sdf)
        return;
    nsdf_block_frame_pose(at, j->model, j->model->values, j->u[f]);
    for (uint32_t k = 0; k < j->model->desc.block_count; k++) {
        const float *p = at->pose[k], centre[3] = {p[3], p[7], p[11]};
        const float reach = surface_within * longest_reach(at->reach[k]);
        holds[k] = at->alive[k] && nsdf_sdf_is_within(sdf, centre, reach);
    }
    nsdf_sdf_free(sdf);
}

/* A block that never holds any surface stays as it is. */
static void trim(const job *j, uint32_t block, float life[2]) {
    const uint32_t frames = j->frames->count, blocks = j->model->desc.block_count;
    uint32_t first = 0, last = frames;
    while (first < frames && !j->holds[(size_t)first * blocks + block])
        first++;
    if (first == frames)
        return;
    while (!j->holds[(size_t)(last - 1) * blocks + block])
        last--;
    float held[2];
    nsdf_block_life(j->u, frames, first, last - 1, held);
    life[0] = fmaxf(life[0], held[0]);
    life[1] = fminf(life[1], held[1]);
}

static int create_job(job *j, const nsdf_file_header *header, uint32_t workers) {
    const uint32_t frames = j->frames->count;
    j->at = calloc(workers, sizeof *j->at);
    j->holds = malloc((size_t)frames * j->model->desc.block_count);
    j->failed = calloc(frames, 1);
    int ok = j->at && j->holds && j->failed;
    for (uint32_t i = 0; ok && i < workers; i++)
        ok = nsdf_block_frame_create(&j->at[i], j->model, header->domain_min, header->domain_max) == 0;
    return ok ? 0 : -1;
}

static void free_job(job *j, uint32_t workers) {
    for (uint32_t i = 0; j->at && i < workers; i++)
        nsdf_block_frame_free(&j->at[i]);
    free(j->at);
    free(j->holds);
    free(j->failed);
}

int nsdf_block_trim_lives(nsdf_block_model *model, const nsdf_frames *frames, const double *u,
                          const nsdf_file_header *header, nsdf_workers *workers) {
    job j = {model, frames, u, NULL, NULL, NULL};
    float *lives = model->values + nsdf_block_offset(&model->desc, NSDF_BLOCK_LIVES);
    int failed = create_job(&j, header, nsdf_workers_count(workers));
    if (!failed)
        nsdf_workers_run(workers, frames->count, look_at_frame, &j);
    for (uint32_t f = 0; !failed && f < frames->count; f++)
        failed |= j.failed[f];
    for (uint32_t k = 0; !failed && k < model->desc.block_count; k++)
        trim(&j, k, lives + 2 * (size_t)k);
    if (!failed)
        nsdf_block_model_round_lives(model);
    free_job(&j, nsdf_workers_count(workers));
    return failed ? -1 : 0;
}

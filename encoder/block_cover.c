#include "block_cover.h"

#include "surface_sample.h"

#include <math.h>
#include <stdlib.h>

enum { PROBES = 500 };

typedef struct {
    const nsdf_motion *motion;
    const nsdf_frames *frames;
    uint64_t seed;
    double *share; /* [frame]; negative when memory ran out */
} job;

/* The inverse of a map that keeps balls, and so has one. */
static void invert(const double m[9], double out[9]) {
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 3; k++) {
            const int a = (k + 1) % 3, b = (k + 2) % 3, c = (row + 1) % 3, d = (row + 2) % 3;
            out[3 * row + k] = m[3 * a + c] * m[3 * b + d] - m[3 * a + d] * m[3 * b + c];
        }
    const double volume = m[0] * out[0] + m[1] * out[3] + m[2] * out[6];
    for (int i = 0; i < 9; i++)
        out[i] /= volume;
}

/* Marks the points that a ball holds; returns how many were not marked before. */
static uint32_t mark_held(const nsdf_pose *pose, double radius, float (*points)[3], uint8_t *held) {
    double inverse[9];
    uint32_t found = 0;
    if (!nsdf_pose_keeps_ball(pose))
        return 0;
    invert(pose->linear, inverse);
    for (uint32_t i = 0; i < PROBES; i++) {
        double square = 0.0;
        for (int row = 0; row < 3; row++) {
            double u = 0.0;
            for (int k = 0; k < 3; k++)
                u += inverse[3 * row + k] * ((double)points[i][k] - pose->position[k]);
            square += u * u;
        }
        if (!held[i] && square < radius * radius) {
            held[i] = 1;
            found++;
        }
    }
    return found;
}

static void look_at_frame(void *data, uint32_t frame, uint32_t worker) {
    const job *j = data;
    const nsdf_motion *m = j->motion;
    nsdf_random random = nsdf_random_start(j->seed, 0x500000000u + frame);
    float points[PROBES][3];
    uint8_t held[PROBES] = {0};
    nsdf_area_table table;
    uint32_t count = 0;
    (void)worker;
    j->share[frame] = -1.0;
    if (nsdf_area_table_create(&table, nsdf_frame_outer(&j->frames->frames[frame])) != 0)
        return;
    for (uint32_t i = 0; i < PROBES; i++)
        (void)nsdf_area_table_draw(&table, &random, points[i]);
    nsdf_area_table_free(&table);
    for (uint32_t b = 0; b < m->block_count; b++)
        if (m->lives[b][0] <= frame && frame <= m->lives[b][1])
            count += mark_held(&m->poses[(size_t)frame * m->block_count + b], (double)m->radius, points, held);
    j->share[frame] = (double)count / PROBES;
}

int nsdf_block_cover_find(double *least, const nsdf_motion *motion, const nsdf_frames *frames, uint64_t seed,
                          nsdf_workers *workers) {
    const job j = {motion, frames, seed, malloc(frames->count * sizeof(double))};
    *least = 1.0;
    if (!j.share)
        return -1;
    nsdf_workers_run(workers, frames->count, look_at_frame, (void *)&j);
    for (uint32_t f = 0; f < frames->count; f++)
        *least = fmin(*least, j.share[f]);
    free(j.share);
    return *least < 0.0 ? -1 : 0;
}

/* The sections of the speed bench.  Each prints its rows, and returns 0, or -1 after a message on standard error. */
#ifndef BENCH_SPEED_H
#define BENCH_SPEED_H

#include "bench_util.h"

enum { BENCH_TEAMS = 2, BENCH_MOST_RESOLUTIONS = 4, BENCH_MOST_FRAMES = 8 };

typedef struct bench_speed_options {
    bench_plan plan;
    uint32_t threads[BENCH_TEAMS];
    uint32_t queries;                                 /* of signed distance, a call */
    uint32_t points;                                  /* of nsdf_evaluate, a call */
    uint32_t sgemm_size;                              /* rows of the matrices */
    uint32_t widths[8];                               /* of networks to fit, up to the first 0 */
    uint32_t resolutions[BENCH_MOST_RESOLUTIONS + 1]; /* the same */
    uint32_t frames;                                  /* spread over the sequence, at most BENCH_MOST_FRAMES */
    const char *input;                                /* the original frames (nsdf/sequence.h), or NULL */
    const char *file;                                 /* .nsdf */
} bench_speed_options;

/* "sdf": queries a second of the distance to a mesh, the first frame of the input. */
int bench_speed_sdf(const bench_speed_options *options);
/* "fit": the encoder's kernels. */
int bench_speed_fit(const bench_speed_options *options);
/* "decode": opening, frames, evaluation. */
int bench_speed_decode(const bench_speed_options *options);
/* "draco": decoding the same frames with Draco.  Without Draco: no rows. */
int bench_speed_draco(const bench_speed_options *options);
/* Its version, or "not built in". */
const char *bench_speed_draco_version(void);

#endif

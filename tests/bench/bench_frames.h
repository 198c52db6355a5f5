/* Decoded frames for the bench programs. */
#ifndef BENCH_FRAMES_H
#define BENCH_FRAMES_H

#include "bench_speed.h"
#include "nsdf/decoder.h"

/* Prints what failed, and returns -1; 0 when nothing did. */
int bench_check(const char *what, nsdf_status status);

/* A decoder, and frames to extract with it. */
typedef struct bench_frames {
    nsdf_decoder *decoder;
    nsdf_mesh *mesh;
    nsdf_mesh_options options;
    double times[BENCH_MOST_FRAMES];
    uint32_t count;
    double vertices, triangles; /* of all frames together, by the last extraction */
    nsdf_status status;         /* the first failure */
} bench_frames;

/* Opens options->file with so many threads, and spreads options->frames over it.  Returns 0 or -1. */
int bench_frames_open(bench_frames *frames, const bench_speed_options *options, uint32_t threads, uint32_t cpu_mask);
void bench_frames_close(bench_frames *frames);

/* Extracts all frames: a run function for bench_case. */
void bench_frames_run(void *frames);

#endif

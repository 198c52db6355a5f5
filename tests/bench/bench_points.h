/* How many points the decoder evaluates for a mesh, and what part of the time that takes. */
#ifndef BENCH_POINTS_H
#define BENCH_POINTS_H

#include "nsdf/decoder.h"

typedef struct bench_points {
    uint64_t values, gradients;    /* points evaluated without and with their gradient */
    double seconds_field, seconds; /* in the field, and for the whole extraction */
} bench_points;

/* One extraction at time t with normals and the default projection; the decoder must have one thread. */
nsdf_status bench_count_points(nsdf_decoder *decoder, double t, uint32_t resolution, bench_points *points);

/* Floating-point operations of the matrix products for a point's value, and for its gradient beyond that; 0 where
 * the model has blocks, whose operations depend on how many balls hold the point. */
typedef struct bench_flop {
    double value, gradient;
} bench_flop;
nsdf_status bench_network_flop(nsdf_decoder *decoder, double t, bench_flop *flop);

#endif

/* Signed-distance samples of one frame (thesis 5.1). */
#ifndef NSDF_SAMPLER_H
#define NSDF_SAMPLER_H

#include "random.h"
#include "sdf.h"

/* Structure of arrays; `count` entries each, in random order, so that any stretch is a fair sample. */
typedef struct nsdf_sample_set {
    float *x, *y, *z; /* normalised position */
    float *d;         /* signed distance, normalised */
    size_t count;
} nsdf_sample_set;

typedef enum nsdf_sampler_kind { NSDF_SAMPLER_NEAR = 0, NSDF_SAMPLER_REJECTION = 1 } nsdf_sampler_kind;

typedef struct nsdf_sampler_params {
    nsdf_sampler_kind kind;
    size_t count;                       /* samples to make */
    float domain_min[3], domain_max[3]; /* normalised; all samples lie inside */
    float d_half;                       /* rejection: d_0.5 (5.2) */
    float noise[3], noise_share[3];     /* near: widths of the normal noise, and their shares */
    float frame_box_share;              /* near: uniform in the frame's box, 10 % larger on every side */
    float domain_share;                 /* near: uniform in the domain; the rest are displaced surface points */
} nsdf_sampler_params;

/* The shares of the trial: 85 % displaced by 0.002, 0.006, 0.02 (35 : 30 : 20), 10 % frame's box, 5 % domain. */
void nsdf_sampler_defaults(nsdf_sampler_params *params);

/* Fills a set (allocates its arrays).  Rejection: uniform points in the domain, kept when exp(-k d) > random, with
 * k = ln 2 / d_half (5.1, 5.2; Algorithm 1 with its comparison put right), until `count` are kept.  `surface` is what
 * `sdf` was made of.  Returns 0, or -1 when memory ran out or displaced points are asked of a surface without area. */
int nsdf_sample_frame(const nsdf_sdf *sdf, const nsdf_surface *surface, const nsdf_sampler_params *params,
                      nsdf_random *random, nsdf_sample_set *set);
/* Room for `count` samples, of no values yet.  Returns 0, or -1 when memory ran out; the free is due then too. */
int nsdf_sample_set_create(nsdf_sample_set *set, size_t count);
/* A copy with arrays of its own.  Returns 0, or -1 when memory ran out; the free is due then too. */
int nsdf_sample_set_copy(const nsdf_sample_set *from, nsdf_sample_set *to);
void nsdf_sample_set_free(nsdf_sample_set *set);

/* `count` points on the surface, uniform by area: xyz [count][3].  Returns 0, or -1 when memory ran out or the area
 * is 0. */
int nsdf_sample_surface(const nsdf_surface *surface, size_t count, nsdf_random *random, float *xyz);

#endif

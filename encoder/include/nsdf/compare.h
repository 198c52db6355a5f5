/* NSDF encoder library: how far apart two moving surfaces are, measured on triangle meshes frame by frame.
 *
 *     nsdf_compare *compare = NULL;
 *     nsdf_compare_create(&compare, NULL, &err);
 *     for each frame: nsdf_compare_frame(compare, &reference, &decoded, NULL, &difference[i], &err);
 *     nsdf_compare_summarise(difference, frame_count, peak, &summary);
 *     nsdf_compare_close(&compare);
 *
 * The two meshes of a frame need no common connectivity.  Distances are in world units and unsigned.  The rules of
 * nsdf/decoder.h hold: nothing prints or exits, out parameters are untouched on failure, one thread at a time per
 * handle.  Results depend on the meshes, the number of samples and the seed only, not on the number of threads.
 */
#ifndef NSDF_COMPARE_H
#define NSDF_COMPARE_H

#include "nsdf/encoder.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Measures that cost extra time. */
enum {
    NSDF_COMPARE_POINTS = 1,  /* point-to-point distances (D1) */
    NSDF_COMPARE_NORMALS = 2, /* deviation of normals */
    NSDF_COMPARE_FMPD = 4,    /* perceptual distance, thesis 6.2 */
    NSDF_COMPARE_SHAPES = 8   /* volume, area, components, Euler number, open edges */
};
#define NSDF_COMPARE_ALL 15u

/* The meshes of a pair. */
enum { NSDF_COMPARE_REFERENCE = 1, NSDF_COMPARE_DECODED = 2 };

typedef struct nsdf_compare_options {
    size_t struct_size; /* set by nsdf_compare_options_init */
    uint32_t samples;   /* random points of each surface, uniform by area: 1 to 2^24; default 20,000 */
    uint32_t measures;  /* NSDF_COMPARE_...; default NSDF_COMPARE_ALL */
    uint32_t threads;   /* 0 = one per core (default) */
    uint64_t seed;      /* of the random points; default 1 */
    uint32_t outer;     /* NSDF_COMPARE_REFERENCE and _DECODED: distances and angles without the triangles of this mesh
                           that lie in its own closed pieces, which no surface of a solid has; default 0.  A triangle
                           counts as hidden by what is 1e-4 of the diagonal of the two meshes' box beside its middle.
                           Open pieces hide nothing.  Shapes and FMPD are of the whole mesh still */
} nsdf_compare_options;

NSDF_API void nsdf_compare_options_init(nsdf_compare_options *options);

/* Distances from the points of one surface to the other surface (thesis 6.1, 6.2).  Triangles without area are no part
 * of a surface.  The mean values are over the random points, one from each of as many equal parts of the area; the
 * maximum is over these and every vertex of the triangles.  What is within the rounding of the coordinates (2.4e-7 of
 * the diagonal of the two meshes' box) counts as 0. */
typedef struct nsdf_distances {
    double mean, rms, max;
    double point_rms;   /* to the nearest random point of the other surface (D1); it has a floor of about half the
                           spacing of the points, where the meshes do not correspond vertex by vertex */
    double normal_mean; /* angle between the normals at a point and at its nearest point, degrees; 180 where one
                           surface faces the other way */
    double normal_rms;
} nsdf_distances;

/* Of one mesh, after welding equal positions and leaving out triangles without area. */
typedef struct nsdf_shape {
    uint32_t vertices, triangles; /* as given, always set */
    uint32_t components;          /* connected pieces */
    int64_t euler;                /* V - E + F: 2 - 2 genus for each closed piece */
    uint32_t open_edges;          /* edges that do not have two triangles in opposite directions */
    double area, volume;          /* volume by the divergence theorem: negative where triangles face inward */
    double hidden_share;          /* of the area, left out by options.outer: 0 to 1; 0 without it */
    double roughness;             /* GR of thesis 6.11; depends on the other mesh through the threshold of 6.10; set
                                     with NSDF_COMPARE_FMPD */
} nsdf_shape;

typedef struct nsdf_difference {
    nsdf_distances to_decoded;   /* from the reference to the decoded surface */
    nsdf_distances to_reference; /* the way back */
    double hausdorff;            /* the larger of the two maxima (thesis 6.3) */
    double fmpd;                 /* 0 to 1 (thesis 6.12, c = 8); does not depend on units, as the curvature of a
                                    vertex is its angle deficit: Wang et al.'s own program, which the thesis used,
                                    does not divide it by an area either */
    nsdf_shape reference, decoded;
} nsdf_difference;

typedef struct nsdf_compare nsdf_compare;

/* `options` NULL = defaults.  Fails with NSDF_INVALID_ARGUMENT or NSDF_NO_MEMORY. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_compare_create(nsdf_compare **compare, const nsdf_compare_options *options,
                                                       nsdf_encoder_error *error);
/* NULL-safe, sets *compare to NULL. */
NSDF_API void nsdf_compare_close(nsdf_compare **compare);

/* Compares the meshes of one frame.  `vertex_distance` (decoded->vertex_count values, may be NULL) gets the distance of
 * every decoded vertex to the reference, those included that no triangle uses.  Measures that were not asked for are 0.
 * Fails with NSDF_INVALID_ARGUMENT when a mesh has no triangle with an area, an index out of range, or a coordinate
 * that is not finite or above 1e30; the message begins with "reference: " or "decoded: ". */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_compare_frame(nsdf_compare *compare, const nsdf_input_mesh *reference,
                                                      const nsdf_input_mesh *decoded, double *vertex_distance,
                                                      nsdf_difference *difference, nsdf_encoder_error *error);

/* Over all frames of a sequence.  [0] is to_decoded, [1] to_reference. */
typedef struct nsdf_difference_summary {
    uint32_t frames;
    double mean[2], rms[2], max[2]; /* of all frames together; every frame counts the same */
    double hausdorff_max;           /* thesis 6.4 */
    double hausdorff_mean;          /* thesis 6.5 */
    double psnr_d1, psnr_d2;        /* dB: mean square over the frames of each direction, the worse direction */
    double normal_mean[2], normal_rms[2];
    double fmpd_max, fmpd_mean;
    uint32_t component_mismatches, euler_mismatches; /* frames whose two meshes differ in it */
    double hidden_mean[2], hidden_max[2]; /* hidden_share of the reference and of the decoded meshes over the frames */
} nsdf_difference_summary;

/* `peak` is the P of nsdf_psnr: the longest side of the reference sequence's box.  NSDF_INVALID_ARGUMENT when count is
 * 0 or peak is not positive. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_compare_summarise(const nsdf_difference *differences, uint32_t count,
                                                          double peak, nsdf_difference_summary *summary);

/* 10 log10(3 peak^2 / mean square error), as MPEG's point-cloud and mesh metrics have it; +infinity when the error
 * is 0.  D1 takes the mean square of point-to-point distances, D2 that of distances to the surface: what the
 * point-to-plane distance becomes when points are dense.  Of the two directions the worse counts. */
NSDF_API double nsdf_psnr(double mean_square, double peak);

#ifdef __cplusplus
}
#endif
#endif

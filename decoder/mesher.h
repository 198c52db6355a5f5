/* Iso-surface extraction: sparse, coarse to fine; closed, oriented and deterministic. */
#ifndef NSDF_MESHER_H
#define NSDF_MESHER_H

#include "field.h"
#include "memory.h"
#include "tasks.h"

typedef struct nsdf_mesher_job {
    nsdf_field field;
    float domain_min[3], domain_max[3]; /* normalised */
    uint32_t resolution;                /* cells along the domain's longest side, >= 2; cells are cubes, the grid is
                                           centred on the domain and covers it */
    float bound;                        /* skip a cube of half diagonal r where |f(centre)| > bound * r */
    int dense;                          /* skip nothing */
    float smallest_piece;               /* leave out connected pieces whose box has a shorter diagonal, normalised,
                                           before vertices move onto the surface; 0 = none */
    int normals;
    uint32_t projection;       /* Newton steps */
    double centre[3], scale;   /* world = normalised * scale + centre */
    int (*cancel)(void *user); /* may be NULL; called on the calling thread */
    void *cancel_user;
} nsdf_mesher_job;

/* Mesh storage that is used again from frame to frame; zero-initialise. */
typedef struct nsdf_mesh_storage {
    float *positions, *normals; /* world units */
    uint32_t *indices;
    uint64_t position_capacity, normal_capacity, index_capacity;
    uint32_t vertex_count, triangle_count;
    int has_normals;
} nsdf_mesh_storage;

/* What a run took, phase by phase, as in nsdf_extraction_stats. */
typedef struct nsdf_mesher_stats {
    double search, corners, triangles, vertices; /* seconds */
    uint64_t centres, corner_points, vertex_points;
    uint32_t dropped_pieces;
} nsdf_mesher_stats;

typedef struct nsdf_mesher nsdf_mesher; /* scratch memory, used again from frame to frame */

nsdf_status nsdf_mesher_create(nsdf_memory *memory, nsdf_tasks *tasks, nsdf_mesher **mesher);
void nsdf_mesher_free(nsdf_mesher **mesher);

/* NSDF_OK, NSDF_NO_MEMORY, NSDF_LIMIT (memory, or more than 2^32 - 1 vertices) or NSDF_CANCELLED; on failure the
 * storage has no vertices.  The storage's memory comes from `storage_memory`. */
nsdf_status nsdf_mesher_run(nsdf_mesher *mesher, const nsdf_mesher_job *job, nsdf_memory *storage_memory,
                            nsdf_mesh_storage *storage);
/* Seconds of a clock for statistics and budgets, never for results. */
double nsdf_mesher_clock(void);

/* Of the last run. */
nsdf_mesher_stats nsdf_mesher_get_stats(const nsdf_mesher *mesher);
void nsdf_mesh_storage_free(nsdf_memory *storage_memory, nsdf_mesh_storage *storage);

#endif

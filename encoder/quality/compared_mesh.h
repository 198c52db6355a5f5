/* One of the two meshes of a frame, made ready for measuring distances. */
#ifndef NSDF_COMPARED_MESH_H
#define NSDF_COMPARED_MESH_H

#include <stdbool.h>

#include "nearest.h"
#include "nsdf/encoder.h"
#include "surface_sample.h"

/* Points or vertices that one task handles: results are summed task by task, so that they do not depend on threads. */
#define NSDF_COMPARE_CHUNK 1024u

static inline uint32_t nsdf_chunk_count(uint32_t count) {
    return count / NSDF_COMPARE_CHUNK + (count % NSDF_COMPARE_CHUNK != 0);
}

/* Where a chunk of `count` things ends; it begins at chunk * NSDF_COMPARE_CHUNK. */
static inline uint32_t nsdf_chunk_end(uint32_t chunk, uint32_t count) {
    uint32_t first = chunk * NSDF_COMPARE_CHUNK;
    return count - first < NSDF_COMPARE_CHUNK ? count : first + NSDF_COMPARE_CHUNK;
}

/* Both meshes of a frame are measured in units of the diagonal of their common box, around its centre. */
typedef struct nsdf_pair_frame {
    double centre[3], diagonal; /* world units; the diagonal is 0 when all is in one point or nearly */
} nsdf_pair_frame;

typedef struct nsdf_compared_mesh {
    const nsdf_input_mesh *mesh;    /* borrowed */
    nsdf_surface whole;             /* in the pair's frame; welded, triangles without area left out */
    nsdf_surface surface;           /* what is measured: the whole or its outer triangles, on the whole's positions */
    double hidden_share;            /* of the whole's area that is not measured */
    bool *used;                     /* [vertex]: a triangle of the surface has it */
    nsdf_nearest_index index;       /* of the surface */
    nsdf_area_table areas;          /* of the surface */
    uint32_t samples;               /* random points */
    float *points;                  /* [samples][3] */
    uint32_t *triangles;            /* [samples]: where the points are */
    nsdf_surface cloud;             /* triangles without area, one at each point, */
    nsdf_nearest_index cloud_index; /* and the search for the nearest */
} nsdf_compared_mesh;

nsdf_pair_frame nsdf_pair_frame_of(const nsdf_input_mesh *first, const nsdf_input_mesh *second);

/* Makes surface, index and areas, and room for the points; without index when the surface turns out to have no
 * triangle; with `outer`, leaves out what is hidden (nsdf/compare.h).  The mesh has passed nsdf_check_mesh.  Returns 0,
 * or -1 when memory ran out; the compared mesh can be freed in either case. */
int nsdf_compared_mesh_prepare(nsdf_compared_mesh *compared, const nsdf_input_mesh *mesh, const nsdf_pair_frame *frame,
                               uint32_t samples, bool outer);
void nsdf_compared_mesh_free(nsdf_compared_mesh *compared);

/* Draws the points of one chunk: the same random numbers for every mesh. */
void nsdf_compared_mesh_draw(nsdf_compared_mesh *compared, uint32_t chunk, uint64_t seed);

/* Builds the search for the nearest point, once all are drawn.  Returns 0, or -1 when memory ran out. */
int nsdf_compared_mesh_index_points(nsdf_compared_mesh *compared);

#endif

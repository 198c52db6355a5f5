/* Which triangles share an edge. */
#ifndef NSDF_MATES_H
#define NSDF_MATES_H

#include "surface.h"

/* Half-edge 3 t + k runs along triangle t from its corner k to the next. */
enum { NSDF_MOST_HALF_EDGES = INT32_MAX };
#define NSDF_MATE_NONE UINT32_MAX       /* the edge is open */
#define NSDF_MATE_MANY (UINT32_MAX - 1) /* three or more triangles meet there */
#define NSDF_MATE_SKIP (UINT32_MAX - 2) /* of a triangle that is left out */

typedef struct nsdf_mates {
    uint32_t *mate;               /* [3 triangle_count]: the edge's other half-edge, whichever way it runs, or one of
                                     the above */
    uint32_t open, many, unalike; /* edges of one triangle, of three or more, and of two that face different ways */
} nsdf_mates;

/* Vertices are weld[index]; triangles with skip[triangle] != 0 are left out, and those that remain have three different
 * vertices.  Returns 0, or -1 when memory ran out or there are more than NSDF_MOST_HALF_EDGES; can be freed in either
 * case. */
int nsdf_mates_find(nsdf_mates *mates, const nsdf_surface *surface, const uint32_t *weld, const uint8_t *skip);
void nsdf_mates_free(nsdf_mates *mates);

/* The vertex where a half-edge begins, and the one where it ends. */
static inline uint32_t nsdf_half_edge_from(const nsdf_surface *s, const uint32_t *weld, uint32_t half) {
    return weld[s->indices[half]];
}
static inline uint32_t nsdf_half_edge_to(const nsdf_surface *s, const uint32_t *weld, uint32_t half) {
    return weld[s->indices[half % 3 == 2 ? half - 2 : half + 1]];
}

#endif

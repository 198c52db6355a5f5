/* The edges of a surface, found by hashing. */
#ifndef NSDF_EDGE_TABLE_H
#define NSDF_EDGE_TABLE_H

#include "surface.h"

typedef struct nsdf_edge {
    uint32_t low, high; /* welded vertices */
    uint32_t up, down;  /* triangles that run from low to high, and back; both 0 in an empty slot */
} nsdf_edge;

typedef struct nsdf_edge_table {
    nsdf_edge *slots; /* open addressing: every edge is somewhere, once */
    size_t slot_count;
} nsdf_edge_table;

/* Edges of the triangles that have an area, between the vertices weld[index], or as they are when `weld` is NULL.
 * Returns 0, or -1 when memory ran out; the table can be freed in either case. */
int nsdf_edge_table_build(nsdf_edge_table *table, const nsdf_surface *surface, const uint32_t *weld);
void nsdf_edge_table_free(nsdf_edge_table *table);

static inline uint32_t nsdf_edge_uses(const nsdf_edge *edge) {
    return edge->up + edge->down;
}

nsdf_edge_count nsdf_edge_table_count(const nsdf_edge_table *table);

#endif

/* The shape of one mesh in numbers. */
#ifndef NSDF_MESH_SHAPE_H
#define NSDF_MESH_SHAPE_H

#include "edge_table.h"
#include "nsdf/compare.h"

/* Sets components, Euler number, open edges, area and volume; `edges` are those of the surface, which is welded.
 * Returns 0, or -1 when memory ran out. */
int nsdf_measure_shape(const nsdf_surface *surface, const nsdf_edge_table *edges, double diagonal, nsdf_shape *shape);

#endif

/* Marching-cubes triangles for the 256 sign patterns of a cell.
 *
 * Corner c of a cell is at (c & 1, c >> 1 & 1, c >> 2 & 1); bit c of the case is set where f < 0.
 * Edge 4 * axis + k runs along `axis` from its lower corner, whose coordinates on the other two axes, the lower axis
 * first, are the bits of k.
 *
 * Faces with two negative corners on a diagonal always separate the negative ones, so that the two cells at a face
 * agree.  No triangle has a side in a face of the cell other than the segments that both cells have there: such a
 * side could be met by one of the neighbour's and give an edge of four triangles. */
#ifndef NSDF_MESHER_TABLES_H
#define NSDF_MESHER_TABLES_H

#include <stdint.h>

/* Triangles of a case are [nsdf_mc_first[case], nsdf_mc_first[case + 1]), each three edges whose vertices run
 * counter-clockwise seen from f > 0. */
extern const uint16_t nsdf_mc_first[257];
extern const uint8_t nsdf_mc_triangles[][3];

#endif

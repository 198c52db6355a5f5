/* Polygons to triangles. */
#ifndef NSDF_OBJ_POLYGON_H
#define NSDF_OBJ_POLYGON_H

#include <stdint.h>

/* Polygons of more corners stay fans: ear clipping takes quadratic time. */
#define NSDF_MAX_CLIPPED_CORNERS 256

/* Replaces a fan from the first corner, `corners` - 2 triangles at `fan`, by better triangles of the same polygon:
 * quadrilaterals are cut along the diagonal that keeps both halves facing the same way, the shorter one if both do;
 * larger polygons by ear clipping in the plane of their (Newell) normal. */
void nsdf_improve_fan(const double *positions, uint32_t *fan, uint32_t corners);

#endif

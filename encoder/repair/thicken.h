/* Open sheets as bodies of a thickness. */
#ifndef NSDF_THICKEN_H
#define NSDF_THICKEN_H

#include "repair/patches.h"

/* The boundary of what is within half a thickness of the sheets: two sides, each triangle's own above and below right
 * after each other, and a rim along the edges. */
typedef struct nsdf_thick {
    float *positions;  /* [vertex_count][3] */
    uint32_t *indices; /* [triangle_count][3], of its own vertices */
    uint32_t vertex_count, triangle_count;
} nsdf_thick;

/* Returns 0, or -1 when memory ran out; can be freed in either case. */
int nsdf_thicken_sheets(nsdf_thick *thick, const nsdf_surface *surface, const uint32_t *weld, const nsdf_mates *mates,
                        const nsdf_patches *patches, double thickness);
void nsdf_thick_free(nsdf_thick *thick);

#endif

/* Small holes of bodies, closed with triangles. */
#ifndef NSDF_HOLES_H
#define NSDF_HOLES_H

#include "repair/patches.h"

typedef struct nsdf_fill {
    uint32_t *indices; /* [triangle_count][3], facing as what is around them */
    uint32_t triangle_count, hole_count, capacity;
} nsdf_fill;

/* Finds the loops of open edges of patches that are neither sheets nor inner walls, and closes those of few edges whose
 * lid is small beside the patch, with the triangles of least area (Barequet & Sharir 1995).  Returns 0, or -1 when
 * memory ran out; can be freed in either case. */
int nsdf_fill_holes(nsdf_fill *fill, const nsdf_surface *surface, const uint32_t *weld, const nsdf_mates *mates,
                    const nsdf_patches *patches);
void nsdf_fill_free(nsdf_fill *fill);

#endif

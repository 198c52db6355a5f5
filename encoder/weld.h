/* Equal positions and equal triangles of a surface, found by hashing. */
#ifndef NSDF_WELD_H
#define NSDF_WELD_H

#include <stdbool.h>

#include "surface.h"

/* weld[vertex] = the first vertex at the same position (0 equals -0).  Returns 0, or -1 when memory ran out. */
int nsdf_weld_vertices(const nsdf_surface *surface, uint32_t *weld);

/* Makes all triangles use the first vertex at each position, and leaves out the triangles without area; vertices stay.
 * Returns 0, or -1 when memory ran out. */
int nsdf_weld_surface(nsdf_surface *surface);

/* repeated[triangle] = whether an earlier triangle has the same welded corners in the same cyclic order.  Returns 0,
 * or -1 when memory ran out. */
int nsdf_find_repeated_triangles(const nsdf_surface *surface, const uint32_t *weld, bool *repeated);

/* Slots of an open-addressing table for `count` entries: a power of two, at most half of them used. */
size_t nsdf_hash_slots(size_t count);

static inline uint64_t nsdf_hash_mix(uint64_t x) {
    x ^= x >> 32;
    x *= UINT64_C(0x9e3779b97f4a7c15);
    return x ^ x >> 29;
}

#endif

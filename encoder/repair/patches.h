/* Patches of a surface: triangles that hang together by edges of just two, and so can agree on which way they face. */
#ifndef NSDF_PATCHES_H
#define NSDF_PATCHES_H

#include "repair/mates.h"

#define NSDF_NO_PATCH UINT32_MAX

typedef struct nsdf_patch {
    double area, volume; /* volume enclosed with the origin, as the triangles face once turned */
    uint32_t triangles, open_edges;
    uint8_t one_sided; /* its triangles cannot agree */
    uint8_t turned;    /* as a whole, after its triangles were made to agree */
    uint8_t is_sheet, is_inner;
    double inside; /* see repair/sides.h */
} nsdf_patch;

typedef struct nsdf_patches {
    uint32_t count;
    nsdf_patch *patches;
    uint32_t *of;    /* [triangle]: its patch; NSDF_NO_PATCH where it is left out */
    uint8_t *turned; /* [triangle]: whether it is to be turned, to face as most of its patch's area does */
} nsdf_patches;

/* Returns 0, or -1 when memory ran out; can be freed in either case. */
int nsdf_patches_find(nsdf_patches *patches, const nsdf_surface *surface, const uint32_t *weld,
                      const nsdf_mates *mates);
void nsdf_patches_free(nsdf_patches *patches);

/* Whether a triangle is to be turned, all considered. */
static inline int nsdf_is_turned(const nsdf_patches *p, uint32_t triangle) {
    return p->turned[triangle] != p->patches[p->of[triangle]].turned;
}

/* Corners of a triangle, turned if it is to be. */
static inline void nsdf_turned_corners(const nsdf_patches *p, const nsdf_surface *s, uint32_t triangle,
                                       uint32_t corners[3]) {
    const uint32_t *t = s->indices + 3 * (size_t)triangle;
    const int turned = nsdf_is_turned(p, triangle);
    corners[0] = t[0];
    corners[1] = t[turned ? 2 : 1];
    corners[2] = t[turned ? 1 : 2];
}

#endif

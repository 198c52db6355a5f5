/* Random points on a surface, uniform by area. */
#ifndef NSDF_SURFACE_SAMPLE_H
#define NSDF_SURFACE_SAMPLE_H

#include "random.h"
#include "surface.h"

typedef struct nsdf_area_table {
    const nsdf_surface *surface;
    double *sums; /* [triangle] area of the triangles up to and with this one */
} nsdf_area_table;

/* Returns 0, or -1 when memory ran out or the area is 0. */
int nsdf_area_table_create(nsdf_area_table *table, const nsdf_surface *surface);
void nsdf_area_table_free(nsdf_area_table *table);

/* Draws a point; returns its triangle. */
uint32_t nsdf_area_table_draw(const nsdf_area_table *table, nsdf_random *random, float xyz[3]);

/* Draws a point from one of `shares` equal parts of the area, in the order of the triangles: a point of every part
 * makes a sample that is uniform by area, spread more evenly than independent points, and along the surface where the
 * order of the triangles is.  share < shares; returns the point's triangle. */
uint32_t nsdf_area_table_draw_share(const nsdf_area_table *table, size_t share, size_t shares, nsdf_random *random,
                                    float xyz[3]);

/* The first of `count` > 0 ascending sums that is above `value`; the last if none is. */
size_t nsdf_first_above(const double *sums, size_t count, double value);

/* Uniform in [0, 1), 32 bits: fine enough to choose among millions. */
static inline double nsdf_random_unit32(nsdf_random *random) {
    return (double)nsdf_random_u32(random) * 0x1p-32;
}

#endif

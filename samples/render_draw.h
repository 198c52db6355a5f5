/* A small software renderer: z-buffer, smooth shading with two lights, ambient occlusion and a soft ground shadow. */
#ifndef NSDF_RENDER_DRAW_H
#define NSDF_RENDER_DRAW_H

#include "render_mesh.h"

/* How a scene is looked at; the same for all meshes that are to be compared. */
typedef struct nsdf_render_view {
    double box_min[3], box_max[3]; /* what must fit into the picture; y is up */
    double turn, rise;             /* degrees: around the vertical axis, and above the horizon */
    double colour[3];              /* of the surface, 0 to 1, linear light */
} nsdf_render_view;

/* Draws the mesh into the square at rgb, `size` pixels wide, in a picture with `stride` bytes a row.  Returns 0, or -1
 * when memory ran out. */
int nsdf_render_draw(const nsdf_render_mesh *mesh, const nsdf_render_view *view, uint32_t size, uint8_t *rgb,
                     size_t stride);

#endif

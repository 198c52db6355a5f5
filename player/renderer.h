/* Draws a surface with light, shadow and ground, in OpenGL 3.3 core.  The same for windows and for pictures in memory:
 * the caller makes the context current. */
#ifndef PLAY_RENDERER_H
#define PLAY_RENDERER_H

#include "camera.h"
#include "gl_api.h"
#include "nsdf/decoder.h"
#include "overlay.h"

typedef enum play_mode { PLAY_SHADED, PLAY_FLAT, PLAY_WIRE, PLAY_NORMALS, PLAY_MODES } play_mode;

typedef struct play_scene {
    play_camera camera;
    play_box box; /* of the file: the ground is at its lower side */
    play_mode mode;
    int ground, ghost; /* whether they are drawn */
    int transparent;   /* no background: alpha tells what is drawn */
} play_scene;

/* What meshes are there: the surface, and another one seen through. */
enum { PLAY_MESH_MAIN, PLAY_MESH_GHOST, PLAY_MESHES };

typedef struct play_renderer play_renderer;

/* samples: of each pixel, 1 to 16; less if there are not so many.  On failure NULL, and why[size] says what it is. */
play_renderer *play_renderer_create(play_gl_lookup lookup, int samples, char *why, size_t size);
/* The context must be current. */
void play_renderer_free(play_renderer *renderer);

/* Another number of samples from the next picture on; with one, shadows on the ground are coarser, too.  0, or -1 when
 * the driver refuses. */
int play_renderer_set_samples(play_renderer *renderer, int samples);

/* Copies the arrays of a closed surface, of which the inside is not drawn; a view without vertices empties the mesh.
 * Meshes without normals are drawn flat. */
void play_renderer_set_mesh(play_renderer *renderer, int which, const nsdf_mesh_view *view);

/* The same for the surface, if it need not be closed: both its sides are drawn.  heat: NULL, or what each vertex shows
 * instead of the surface's colour, from 0 to 1, see heat.h. */
void play_renderer_set_open_mesh(play_renderer *renderer, const nsdf_mesh_view *view, const float *heat);

/* Draws to the context's own framebuffer of this size in pixels, and the overlay over it, which may be NULL.  Returns
 * 0, or -1 when there is no memory for a picture of that size. */
int play_renderer_draw(play_renderer *renderer, const play_scene *scene, const play_overlay *overlay, int width,
                       int height);

/* What was drawn: height rows from the top of 4 * width bytes, 4 * row_pixels bytes apart; alpha is not multiplied into
 * the colours. */
void play_renderer_read(play_renderer *renderer, int width, int height, unsigned char *rgba, int row_pixels);

/* "llvmpipe (LLVM 15.0.6, 256 bits)"; valid while the context is. */
const char *play_renderer_name(const play_renderer *renderer);

#endif

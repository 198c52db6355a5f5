/* What the renderer draws into before it is shown. */
#ifndef PLAY_RENDER_TARGETS_H
#define PLAY_RENDER_TARGETS_H

#include <stddef.h>

#include "gl_api.h"

/* A depth texture that can be drawn into. */
typedef struct play_depth_map {
    GLuint texture, framebuffer;
    int size;
} play_depth_map;

/* compared: read with sampler2DShadow, otherwise as depths.  0, or -1 if the driver refuses. */
int play_depth_map_create(const play_gl *gl, play_depth_map *map, int size, int compared);
void play_depth_map_free(const play_gl *gl, play_depth_map *map);

/* A texture of one channel that can be drawn into.  As above. */
typedef struct play_grey_map {
    GLuint texture, framebuffer;
    int size;
} play_grey_map;

int play_grey_map_create(const play_gl *gl, play_grey_map *map, int size);
void play_grey_map_free(const play_gl *gl, play_grey_map *map);

/* Colour and depth with several samples a pixel. */
typedef struct play_canvas {
    GLuint framebuffer, colour, depth;
    int width, height, samples;
} play_canvas;

/* Makes it that size, if it is not.  0, or -1 if there is no memory. */
int play_canvas_resize(const play_gl *gl, play_canvas *canvas, int width, int height, int samples);
void play_canvas_free(const play_gl *gl, play_canvas *canvas);

/* A linked program, or 0 with why[size] saying what the compiler found. */
GLuint play_program(const play_gl *gl, const char *vertex, const char *fragment, char *why, size_t size);

#endif

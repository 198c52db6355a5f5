/* OpenGL without a display: Mesa draws into memory. */
#ifndef PLAY_OFFSCREEN_CONTEXT_H
#define PLAY_OFFSCREEN_CONTEXT_H

#include <stddef.h>

#include "gl_api.h"

typedef struct play_offscreen_context play_offscreen_context;

/* A current context whose framebuffer has this size in pixels.  On failure NULL, and why[size] says what it is. */
play_offscreen_context *play_offscreen_context_create(int width, int height, char *why, size_t size);
void play_offscreen_context_free(play_offscreen_context *context);

play_gl_function play_offscreen_lookup(const char *name);

#endif

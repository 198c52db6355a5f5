#include "offscreen_context.h"

#include <stdio.h>
#include <stdlib.h>

#include <GL/osmesa.h>

struct play_offscreen_context {
    OSMesaContext mesa;
    unsigned char *pixels; /* rgba */
};

play_offscreen_context *play_offscreen_context_create(int width, int height, char *why, size_t size) {
    static const int attributes[] = {OSMESA_FORMAT,
                                     OSMESA_RGBA,
                                     OSMESA_DEPTH_BITS,
                                     24,
                                     OSMESA_PROFILE,
                                     OSMESA_CORE_PROFILE,
                                     OSMESA_CONTEXT_MAJOR_VERSION,
                                     3,
                                     OSMESA_CONTEXT_MINOR_VERSION,
                                     3,
                                     0};
    play_offscreen_context *c = calloc(1, sizeof *c);
    if (!c) {
        snprintf(why, size, "out of memory");
        return NULL;
    }
    c->pixels = calloc((size_t)width * (size_t)height, 4);
    c->mesa = OSMesaCreateContextAttribs(attributes, NULL);
    if (c->pixels && c->mesa && OSMesaMakeCurrent(c->mesa, c->pixels, GL_UNSIGNED_BYTE, width, height))
        return c;
    snprintf(why, size, "Mesa cannot draw %d x %d pixels into memory with OpenGL 3.3", width, height);
    play_offscreen_context_free(c);
    return NULL;
}

void play_offscreen_context_free(play_offscreen_context *c) {
    if (!c)
        return;
    if (c->mesa)
        OSMesaDestroyContext(c->mesa);
    free(c->pixels);
    free(c);
}

play_gl_function play_offscreen_lookup(const char *name) {
    return (play_gl_function)OSMesaGetProcAddress(name);
}

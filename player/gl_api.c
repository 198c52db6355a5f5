#include "gl_api.h"

#include <stddef.h>

const char *play_gl_load(play_gl *gl, play_gl_lookup lookup) {
#define PLAY_GL_LOAD(type, name)                                                                                       \
    gl->name = (PFNGL##type##PROC)lookup("gl" #name);                                                                  \
    if (!gl->name)                                                                                                     \
        return "gl" #name;
    PLAY_GL_FUNCTIONS(PLAY_GL_LOAD)
#undef PLAY_GL_LOAD
    return NULL;
}

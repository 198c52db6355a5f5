#include "render_targets.h"

#include <stdio.h>
#include <string.h>

static GLuint texture(const play_gl *gl, int size, GLint internal, GLenum format, GLint filter) {
    GLuint t;
    gl->GenTextures(1, &t);
    gl->BindTexture(GL_TEXTURE_2D, t);
    gl->TexImage2D(GL_TEXTURE_2D, 0, internal, size, size, 0, format, GL_UNSIGNED_BYTE, NULL);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    return t;
}

/* 0, or -1. */
static int attach(const play_gl *gl, GLuint *framebuffer, GLenum attachment, GLuint map) {
    gl->GenFramebuffers(1, framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, *framebuffer);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, map, 0);
    if (attachment == GL_DEPTH_ATTACHMENT)
        gl->DrawBuffer(GL_NONE);
    const GLenum status = gl->CheckFramebufferStatus(GL_FRAMEBUFFER);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    return status == GL_FRAMEBUFFER_COMPLETE ? 0 : -1;
}

int play_depth_map_create(const play_gl *gl, play_depth_map *map, int size, int compared) {
    map->size = size;
    map->texture = texture(gl, size, GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, compared ? GL_LINEAR : GL_NEAREST);
    if (compared)
        gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    return attach(gl, &map->framebuffer, GL_DEPTH_ATTACHMENT, map->texture);
}

void play_depth_map_free(const play_gl *gl, play_depth_map *map) {
    gl->DeleteFramebuffers(1, &map->framebuffer);
    gl->DeleteTextures(1, &map->texture);
}

int play_grey_map_create(const play_gl *gl, play_grey_map *map, int size) {
    map->size = size;
    map->texture = texture(gl, size, GL_R8, GL_RED, GL_LINEAR);
    return attach(gl, &map->framebuffer, GL_COLOR_ATTACHMENT0, map->texture);
}

void play_grey_map_free(const play_gl *gl, play_grey_map *map) {
    gl->DeleteFramebuffers(1, &map->framebuffer);
    gl->DeleteTextures(1, &map->texture);
}

static GLuint storage(const play_gl *gl, const play_canvas *c, GLenum format, GLenum attachment) {
    GLuint buffer;
    gl->GenRenderbuffers(1, &buffer);
    gl->BindRenderbuffer(GL_RENDERBUFFER, buffer);
    gl->RenderbufferStorageMultisample(GL_RENDERBUFFER, c->samples, format, c->width, c->height);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer);
    return buffer;
}

int play_canvas_resize(const play_gl *gl, play_canvas *c, int width, int height, int samples) {
    if (c->framebuffer && c->width == width && c->height == height && c->samples == samples)
        return 0;
    play_canvas_free(gl, c);
    c->width = width;
    c->height = height;
    c->samples = samples;
    gl->GenFramebuffers(1, &c->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, c->framebuffer);
    c->colour = storage(gl, c, GL_RGBA8, GL_COLOR_ATTACHMENT0);
    c->depth = storage(gl, c, GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT);
    if (gl->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE)
        return 0;
    play_canvas_free(gl, c);
    return -1;
}

void play_canvas_free(const play_gl *gl, play_canvas *c) {
    if (c->framebuffer) {
        gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
        gl->DeleteFramebuffers(1, &c->framebuffer);
        gl->DeleteRenderbuffers(1, &c->colour);
        gl->DeleteRenderbuffers(1, &c->depth);
    }
    memset(c, 0, sizeof *c);
}

static GLuint compile(const play_gl *gl, GLenum kind, const char *text, char *why, size_t size) {
    GLint compiled = 0;
    const GLuint shader = gl->CreateShader(kind);
    gl->ShaderSource(shader, 1, &text, NULL);
    gl->CompileShader(shader);
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled)
        return shader;
    const int used = snprintf(why, size, "the OpenGL driver refuses a shader: ");
    if (used > 0 && (size_t)used < size)
        gl->GetShaderInfoLog(shader, (GLsizei)(size - (size_t)used), NULL, why + used);
    gl->DeleteShader(shader);
    return 0;
}

GLuint play_program(const play_gl *gl, const char *vertex, const char *fragment, char *why, size_t size) {
    GLint linked = 0;
    const GLuint v = compile(gl, GL_VERTEX_SHADER, vertex, why, size);
    const GLuint f = v ? compile(gl, GL_FRAGMENT_SHADER, fragment, why, size) : 0;
    GLuint program = 0;
    if (v && f) {
        program = gl->CreateProgram();
        gl->AttachShader(program, v);
        gl->AttachShader(program, f);
        gl->LinkProgram(program);
        gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
    }
    if (v)
        gl->DeleteShader(v);
    if (f)
        gl->DeleteShader(f);
    if (program && !linked) {
        snprintf(why, size, "the OpenGL driver cannot link a program");
        gl->DeleteProgram(program);
        return 0;
    }
    return program;
}

#include "renderer.h"

#include "cli_heat.h"
#include "render_targets.h"
#include "shaders.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    SHADOW_SIZE = 1024,
    BELOW_SIZE = 256,
    GROUND_SIZE = 256,
    HASTY_GROUND_SIZE = 128,
    GROUND_REACH = 2 /* radii of the box */
};

typedef enum program_use { DEPTH, SURFACE, GROUND_MAP, GROUND, BACKGROUND, OVERLAY, PROGRAMS } program_use;

typedef struct gpu_mesh {
    GLuint array, positions, normals, heat, indices;
    GLsizei index_count;
    int has_normals, has_heat, is_open;
} gpu_mesh;

struct play_renderer {
    play_gl gl;
    GLuint programs[PROGRAMS];
    gpu_mesh meshes[PLAY_MESHES];
    GLuint ground_array, ground_buffer, empty_array, overlay_array, overlay_buffer;
    play_depth_map shadow, below;
    play_grey_map ground;
    play_canvas canvas;
    int samples;
};

/* What follows from a scene. */
typedef struct view {
    play_eye eye;
    play_vec3 up, key, fill, ground; /* directions; the point of the ground below the middle */
    double radius;                   /* of the box */
    play_mat4 light_of_world, below_of_world;
    play_vec3 corner, along, across; /* the square of ground that is drawn: a corner, and its sides */
} view;

/* ---- Setting up ------------------------------------------------------------------------------------------ */

static int create_programs(play_renderer *r, char *why, size_t size) {
    const char *const sources[PROGRAMS][2] = {
        {play_depth_vertex, play_depth_fragment},           {play_surface_vertex, play_surface_fragment},
        {play_background_vertex, play_ground_map_fragment}, {play_ground_vertex, play_ground_fragment},
        {play_background_vertex, play_background_fragment}, {play_overlay_vertex, play_overlay_fragment}};
    for (int i = 0; i < PROGRAMS; i++) {
        r->programs[i] = play_program(&r->gl, sources[i][0], sources[i][1], why, size);
        if (!r->programs[i])
            return -1;
    }
    return 0;
}

static void create_mesh(const play_gl *gl, gpu_mesh *m) {
    gl->GenVertexArrays(1, &m->array);
    gl->BindVertexArray(m->array);
    gl->GenBuffers(1, &m->positions);
    gl->GenBuffers(1, &m->normals);
    gl->GenBuffers(1, &m->heat);
    gl->GenBuffers(1, &m->indices);
    gl->BindBuffer(GL_ARRAY_BUFFER, m->positions);
    gl->VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    gl->EnableVertexAttribArray(0);
    gl->BindBuffer(GL_ARRAY_BUFFER, m->normals);
    gl->VertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    gl->BindBuffer(GL_ARRAY_BUFFER, m->heat);
    gl->VertexAttribPointer(2, 1, GL_FLOAT, GL_FALSE, 0, NULL);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, m->indices);
}

static void create_flat(play_renderer *r) {
    const play_gl *gl = &r->gl;
    gl->GenVertexArrays(1, &r->empty_array);
    gl->GenVertexArrays(1, &r->ground_array);
    gl->BindVertexArray(r->ground_array);
    gl->GenBuffers(1, &r->ground_buffer);
    gl->BindBuffer(GL_ARRAY_BUFFER, r->ground_buffer);
    gl->VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    gl->EnableVertexAttribArray(0);
    gl->GenVertexArrays(1, &r->overlay_array);
    gl->BindVertexArray(r->overlay_array);
    gl->GenBuffers(1, &r->overlay_buffer);
    gl->BindBuffer(GL_ARRAY_BUFFER, r->overlay_buffer);
    gl->VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, sizeof(play_overlay_corner), NULL);
    gl->EnableVertexAttribArray(0);
    gl->VertexAttribPointer(1, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(play_overlay_corner),
                            (const void *)offsetof(play_overlay_corner, rgba));
    gl->EnableVertexAttribArray(1);
}

play_renderer *play_renderer_create(play_gl_lookup lookup, int samples, char *why, size_t size) {
    play_renderer *r = calloc(1, sizeof *r);
    if (!r) {
        snprintf(why, size, "out of memory");
        return NULL;
    }
    const char *missing = play_gl_load(&r->gl, lookup);
    if (missing) {
        snprintf(why, size, "OpenGL 3.3 is needed, and there is no %s", missing);
        free(r);
        return NULL;
    }
    if (create_programs(r, why, size) != 0) {
        play_renderer_free(r);
        return NULL;
    }
    for (int i = 0; i < PLAY_MESHES; i++)
        create_mesh(&r->gl, &r->meshes[i]);
    create_flat(r);
    if (play_depth_map_create(&r->gl, &r->shadow, SHADOW_SIZE, 1) != 0 ||
        play_depth_map_create(&r->gl, &r->below, BELOW_SIZE, 0) != 0 || play_renderer_set_samples(r, samples) != 0) {
        snprintf(why, size, "the OpenGL driver cannot draw into textures");
        play_renderer_free(r);
        return NULL;
    }
    return r;
}

int play_renderer_set_samples(play_renderer *r, int samples) {
    GLint most = 1;
    r->gl.GetIntegerv(GL_MAX_SAMPLES, &most);
    r->samples = samples < most ? samples : most;
    if (r->samples < 2)
        r->samples = 0; /* drivers may make four of one */
    play_grey_map_free(&r->gl, &r->ground);
    return play_grey_map_create(&r->gl, &r->ground, r->samples ? GROUND_SIZE : HASTY_GROUND_SIZE);
}

void play_renderer_free(play_renderer *r) {
    if (!r)
        return;
    const play_gl *gl = &r->gl;
    for (int i = 0; i < PROGRAMS; i++)
        if (r->programs[i])
            gl->DeleteProgram(r->programs[i]);
    for (int i = 0; i < PLAY_MESHES; i++) {
        gl->DeleteVertexArrays(1, &r->meshes[i].array);
        const GLuint buffers[4] = {r->meshes[i].positions, r->meshes[i].normals, r->meshes[i].heat,
                                   r->meshes[i].indices};
        gl->DeleteBuffers(4, buffers);
    }
    const GLuint arrays[3] = {r->ground_array, r->empty_array, r->overlay_array};
    const GLuint buffers[2] = {r->ground_buffer, r->overlay_buffer};
    gl->DeleteVertexArrays(3, arrays);
    gl->DeleteBuffers(2, buffers);
    play_depth_map_free(gl, &r->shadow);
    play_depth_map_free(gl, &r->below);
    play_grey_map_free(gl, &r->ground);
    play_canvas_free(gl, &r->canvas);
    free(r);
}

void play_renderer_set_mesh(play_renderer *r, int which, const nsdf_mesh_view *v) {
    const play_gl *gl = &r->gl;
    gpu_mesh *m = &r->meshes[which];
    const GLsizeiptr points = (GLsizeiptr)(3 * sizeof(float) * (size_t)v->vertex_count);
    m->index_count = (GLsizei)(3 * v->triangle_count);
    m->has_normals = v->normals != NULL;
    m->is_open = m->has_heat = 0;
    gl->BindVertexArray(m->array);
    gl->BindBuffer(GL_ARRAY_BUFFER, m->positions);
    gl->BufferData(GL_ARRAY_BUFFER, points, v->positions, GL_STREAM_DRAW);
    gl->BindBuffer(GL_ARRAY_BUFFER, m->normals);
    if (m->has_normals) {
        gl->BufferData(GL_ARRAY_BUFFER, points, v->normals, GL_STREAM_DRAW);
        gl->EnableVertexAttribArray(1);
    } else {
        gl->DisableVertexAttribArray(1);
    }
    gl->DisableVertexAttribArray(2);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(3 * sizeof(uint32_t) * (size_t)v->triangle_count), v->indices,
                   GL_STREAM_DRAW);
}

void play_renderer_set_open_mesh(play_renderer *r, const nsdf_mesh_view *v, const float *heat) {
    const play_gl *gl = &r->gl;
    gpu_mesh *m = &r->meshes[PLAY_MESH_MAIN];
    play_renderer_set_mesh(r, PLAY_MESH_MAIN, v);
    m->is_open = 1;
    m->has_heat = heat != NULL;
    if (!heat)
        return;
    gl->BindBuffer(GL_ARRAY_BUFFER, m->heat);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(sizeof *heat * (size_t)v->vertex_count), heat, GL_STREAM_DRAW);
    gl->EnableVertexAttribArray(2);
}

const char *play_renderer_name(const play_renderer *r) {
    return (const char *)r->gl.GetString(GL_RENDERER);
}

/* ---- Views ----------------------------------------------------------------------------------------------- */

/* An orthographic view of the box's sphere along `back`. */
static play_mat4 light_view(play_vec3 middle, double radius, play_vec3 back, play_vec3 any) {
    const play_vec3 right = play_unit(play_cross(any, back)), up = play_cross(back, right);
    const play_mat4 v = play_view(play_add(middle, play_scale(back, 2.0 * radius)), right, up, back);
    const play_mat4 p = play_orthographic(radius, radius, radius, 3.0 * radius);
    return play_multiply(&p, &v);
}

/* The fill light stands at the viewer's right. */
static view make_view(const play_scene *scene, double aspect) {
    view v;
    play_vec3 axes[3];
    play_up_axes(scene->camera.up, axes);
    v.up = axes[1];
    v.eye = play_camera_eye(&scene->camera, aspect);
    const play_vec3 side = v.eye.right, front = play_unit(play_cross(side, v.up));
    v.key = play_key_light(&v.eye, v.up);
    v.fill = play_unit(play_add(play_add(play_scale(side, 0.9), play_scale(front, 0.6)), play_scale(v.up, 0.15)));
    const play_vec3 low = {scene->box.low[0], scene->box.low[1], scene->box.low[2]};
    const play_vec3 high = {scene->box.high[0], scene->box.high[1], scene->box.high[2]};
    const play_vec3 middle = play_scale(play_add(low, high), 0.5), half = play_scale(play_subtract(high, low), 0.5);
    v.radius = 1.02 * sqrt(play_dot(half, half)) + 1e-12;
    const double drop = fabs(play_dot(half, v.up));
    v.ground = play_subtract(middle, play_scale(v.up, 1.002 * drop));
    v.light_of_world = light_view(middle, v.radius, v.key, v.up);
    const play_mat4 from_below = play_view(v.ground, axes[0], axes[2], play_scale(v.up, -1.0));
    const play_mat4 flat = play_orthographic(v.radius, v.radius, 0.0, 2.0 * v.radius);
    v.below_of_world = play_multiply(&flat, &from_below);
    const double reach = GROUND_REACH * v.radius;
    v.along = play_scale(axes[0], 2.0 * reach);
    v.across = play_scale(axes[2], 2.0 * reach);
    v.corner = play_subtract(v.ground, play_scale(play_add(v.along, v.across), 0.5));
    return v;
}

/* ---- Uniforms -------------------------------------------------------------------------------------------- */

static GLint uniform(const play_renderer *r, program_use p, const char *name) {
    return r->gl.GetUniformLocation(r->programs[p], name);
}

static void set_matrix(const play_renderer *r, program_use p, const char *name, const play_mat4 *m) {
    r->gl.UniformMatrix4fv(uniform(r, p, name), 1, GL_FALSE, m->m);
}

static void set_vector(const play_renderer *r, program_use p, const char *name, play_vec3 v) {
    r->gl.Uniform3f(uniform(r, p, name), (float)v.x, (float)v.y, (float)v.z);
}

static void set_float(const play_renderer *r, program_use p, const char *name, double x) {
    r->gl.Uniform1f(uniform(r, p, name), (float)x);
}

/* softness: of the shadow's edge, in its texels. */
static void set_shadow(const play_renderer *r, program_use p, const view *v, double softness) {
    r->gl.ActiveTexture(GL_TEXTURE0);
    r->gl.BindTexture(GL_TEXTURE_2D, r->shadow.texture);
    r->gl.Uniform1i(uniform(r, p, "shadow"), 0);
    set_matrix(r, p, "light_of_world", &v->light_of_world);
    set_float(r, p, "shadow_softness", softness / SHADOW_SIZE);
}

/* ---- Passes ---------------------------------------------------------------------------------------------- */

/* Nothing is seen of the inside of a closed surface: half of its triangles need no pixels. */
static void draw_mesh(const play_renderer *r, const gpu_mesh *m) {
    r->gl.BindVertexArray(m->array);
    if (!m->is_open)
        r->gl.Enable(GL_CULL_FACE);
    if (m->index_count > 0)
        r->gl.DrawElements(GL_TRIANGLES, m->index_count, GL_UNSIGNED_INT, NULL);
    r->gl.Disable(GL_CULL_FACE);
}

static void draw_depth(const play_renderer *r, const play_depth_map *map, const play_mat4 *clip) {
    const play_gl *gl = &r->gl;
    gl->BindFramebuffer(GL_FRAMEBUFFER, map->framebuffer);
    gl->Viewport(0, 0, map->size, map->size);
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthMask(GL_TRUE);
    gl->Clear(GL_DEPTH_BUFFER_BIT);
    gl->UseProgram(r->programs[DEPTH]);
    set_matrix(r, DEPTH, "clip_of_world", clip);
    draw_mesh(r, &r->meshes[PLAY_MESH_MAIN]);
}

static void draw_background(const play_renderer *r, int transparent) {
    const play_gl *gl = &r->gl;
    gl->ClearColor(0.0f, 0.0f, 0.0f, 0.0f);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    if (transparent)
        return;
    gl->Disable(GL_DEPTH_TEST);
    gl->Disable(GL_BLEND);
    gl->UseProgram(r->programs[BACKGROUND]);
    gl->Uniform4f(uniform(r, BACKGROUND, "colour"), 0.93f, 0.935f, 0.945f, 1.0f);
    gl->Uniform4f(uniform(r, BACKGROUND, "top"), 0.80f, 0.82f, 0.85f, 1.0f);
    gl->BindVertexArray(r->empty_array);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
}

static void draw_ground_map(const play_renderer *r, const view *v) {
    const play_gl *gl = &r->gl;
    gl->BindFramebuffer(GL_FRAMEBUFFER, r->ground.framebuffer);
    gl->Viewport(0, 0, r->ground.size, r->ground.size);
    gl->Disable(GL_DEPTH_TEST);
    gl->Disable(GL_BLEND);
    gl->UseProgram(r->programs[GROUND_MAP]);
    set_shadow(r, GROUND_MAP, v, 6.0);
    gl->ActiveTexture(GL_TEXTURE1);
    gl->BindTexture(GL_TEXTURE_2D, r->below.texture);
    gl->Uniform1i(uniform(r, GROUND_MAP, "below"), 1);
    set_vector(r, GROUND_MAP, "corner", v->corner);
    set_vector(r, GROUND_MAP, "along", v->along);
    set_vector(r, GROUND_MAP, "across", v->across);
    set_float(r, GROUND_MAP, "reach_below", GROUND_REACH);
    gl->BindVertexArray(r->empty_array);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
}

/* Behind everything, so that it does not hide a surface that reaches below it; nothing when seen from below. */
static void draw_ground(const play_renderer *r, const view *v) {
    const play_gl *gl = &r->gl;
    float corners[4][3];
    if (play_dot(v->eye.back, v->up) < 0.0)
        return;
    for (int i = 0; i < 4; i++) {
        const play_vec3 p = play_add(play_add(v->corner, play_scale(v->along, i & 1)), play_scale(v->across, i >> 1));
        corners[i][0] = (float)p.x;
        corners[i][1] = (float)p.y;
        corners[i][2] = (float)p.z;
    }
    gl->UseProgram(r->programs[GROUND]);
    set_matrix(r, GROUND, "clip_of_world", &v->eye.clip_of_world);
    gl->ActiveTexture(GL_TEXTURE1);
    gl->BindTexture(GL_TEXTURE_2D, r->ground.texture);
    gl->Uniform1i(uniform(r, GROUND, "map"), 1);
    gl->Enable(GL_BLEND);
    gl->BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    gl->Disable(GL_DEPTH_TEST);
    gl->BindVertexArray(r->ground_array);
    gl->BindBuffer(GL_ARRAY_BUFFER, r->ground_buffer);
    gl->BufferData(GL_ARRAY_BUFFER, sizeof corners, corners, GL_STREAM_DRAW);
    gl->DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    gl->Disable(GL_BLEND);
}

static void set_surface(const play_renderer *r, int mode, const float colour[4]) {
    r->gl.Uniform1i(uniform(r, SURFACE, "mode"), mode);
    r->gl.Uniform4f(uniform(r, SURFACE, "colour"), colour[0], colour[1], colour[2], colour[3]);
}

/* Red, green, blue from 0 to 1. */
static void set_ramp(const play_renderer *r) {
    float ramp[NSDF_CLI_HEAT_COLOURS][3];
    for (int i = 0; i < NSDF_CLI_HEAT_COLOURS; i++)
        for (int k = 0; k < 3; k++)
            ramp[i][k] = (float)nsdf_cli_heat_ramp[i][k] / 255.0f;
    r->gl.Uniform3fv(uniform(r, SURFACE, "ramp"), NSDF_CLI_HEAT_COLOURS, ramp[0]);
}

static void draw_surface(const play_renderer *r, const play_scene *scene, const view *v) {
    static const float clay[4] = {0.62f, 0.60f, 0.57f, 1.0f}, line[4] = {0.02f, 0.03f, 0.05f, 1.0f};
    static const int modes[PLAY_MODES] = {0, 1, 0, 2};
    const play_gl *gl = &r->gl;
    const gpu_mesh *m = &r->meshes[PLAY_MESH_MAIN];
    gl->UseProgram(r->programs[SURFACE]);
    set_matrix(r, SURFACE, "clip_of_world", &v->eye.clip_of_world);
    set_shadow(r, SURFACE, v, 1.5);
    set_vector(r, SURFACE, "eye", v->eye.position);
    set_vector(r, SURFACE, "key", v->key);
    set_vector(r, SURFACE, "fill", v->fill);
    set_vector(r, SURFACE, "up", v->up);
    gl->Uniform1i(uniform(r, SURFACE, "heated"), m->has_heat);
    set_ramp(r);
    gl->Enable(GL_DEPTH_TEST);
    gl->Enable(GL_POLYGON_OFFSET_FILL);
    gl->PolygonOffset(1.0f, 1.0f);
    set_surface(r, m->has_normals ? modes[scene->mode] : 1, clay);
    draw_mesh(r, m);
    gl->Disable(GL_POLYGON_OFFSET_FILL);
    if (scene->mode == PLAY_WIRE) {
        gl->PolygonMode(GL_FRONT_AND_BACK, GL_LINE);
        set_surface(r, 3, line);
        draw_mesh(r, m);
        gl->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    }
}

/* Its nearest layer only, through which the surface shows. */
static void draw_ghost(const play_renderer *r) {
    static const float colour[4] = {0.10f, 0.35f, 0.85f, 0.35f};
    const play_gl *gl = &r->gl;
    set_surface(r, 3, colour);
    gl->ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    draw_mesh(r, &r->meshes[PLAY_MESH_GHOST]);
    gl->ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    gl->Enable(GL_BLEND);
    gl->BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    gl->Enable(GL_POLYGON_OFFSET_FILL);
    gl->PolygonOffset(-1.0f, -1.0f);
    draw_mesh(r, &r->meshes[PLAY_MESH_GHOST]);
    gl->Disable(GL_POLYGON_OFFSET_FILL);
    gl->Disable(GL_BLEND);
}

static void draw_overlay(const play_renderer *r, const play_overlay *o, int width, int height) {
    const play_gl *gl = &r->gl;
    if (!o || o->count == 0)
        return;
    gl->Disable(GL_DEPTH_TEST);
    gl->Enable(GL_BLEND);
    gl->BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    gl->UseProgram(r->programs[OVERLAY]);
    gl->Uniform2f(uniform(r, OVERLAY, "size"), (float)width, (float)height);
    gl->BindVertexArray(r->overlay_array);
    gl->BindBuffer(GL_ARRAY_BUFFER, r->overlay_buffer);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(o->count * sizeof *o->corners), o->corners, GL_STREAM_DRAW);
    gl->DrawArrays(GL_TRIANGLES, 0, (GLsizei)o->count);
    gl->Disable(GL_BLEND);
}

int play_renderer_draw(play_renderer *r, const play_scene *scene, const play_overlay *overlay, int width, int height) {
    const play_gl *gl = &r->gl;
    const view v = make_view(scene, (double)width / height);
    if (r->samples > 0 && play_canvas_resize(gl, &r->canvas, width, height, r->samples) != 0)
        return -1;
    draw_depth(r, &r->shadow, &v.light_of_world);
    if (scene->ground) {
        draw_depth(r, &r->below, &v.below_of_world);
        draw_ground_map(r, &v);
    }
    gl->BindFramebuffer(GL_FRAMEBUFFER, r->samples > 0 ? r->canvas.framebuffer : 0);
    gl->Viewport(0, 0, width, height);
    draw_background(r, scene->transparent);
    if (scene->ground)
        draw_ground(r, &v);
    draw_surface(r, scene, &v);
    if (scene->ghost)
        draw_ghost(r);
    if (r->samples > 0) {
        gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
        gl->BlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
        gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    }
    draw_overlay(r, overlay, width, height);
    return 0;
}

static void divide(unsigned char *rgba, int count) {
    for (unsigned char *p = rgba; p < rgba + 4 * (size_t)count; p += 4)
        for (int k = 0; k < 3 && p[3] > 0 && p[3] < 255; k++) {
            const int c = (p[k] * 255 + p[3] / 2) / p[3];
            p[k] = (unsigned char)(c < 255 ? c : 255);
        }
}

static void swap_rows(unsigned char *a, unsigned char *b, size_t bytes) {
    for (size_t i = 0; i < bytes; i++) {
        const unsigned char kept = a[i];
        a[i] = b[i];
        b[i] = kept;
    }
}

void play_renderer_read(play_renderer *r, int width, int height, unsigned char *rgba, int row_pixels) {
    const size_t row = 4 * (size_t)row_pixels;
    r->gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    r->gl.PixelStorei(GL_PACK_ROW_LENGTH, row_pixels);
    r->gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    r->gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    for (int y = 0; y < height / 2; y++)
        swap_rows(rgba + row * (size_t)y, rgba + row * (size_t)(height - 1 - y), 4 * (size_t)width);
    for (int y = 0; y < height; y++)
        divide(rgba + row * (size_t)y, width);
}

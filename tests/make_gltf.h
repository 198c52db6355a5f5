/* Small animated glTF files in memory: a bar of three rings of four vertices, y = 0, 1, 2, that moves in one second. */
#ifndef NSDF_TESTS_MAKE_GLTF_H
#define NSDF_TESTS_MAKE_GLTF_H

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GLTF_TEXT = 8192, GLTF_BYTES = 8192, GLTF_VERTICES = 12, GLTF_TRIANGLES = 20 };

/* Kinds that gltf_make knows. */
static const char *const gltf_kinds[] = {
    "still",   /* no animation */
    "moving",  /* translation in a line from 0 to (2, 4, 0) */
    "late",    /* the same from second 3 to 4, with keys every 1/24 s */
    "turning", /* a node above turns by 90 degrees about z; the bar is at (3, 0, 0) below it */
    "cubic",   /* translation by a spline from 0 to (1, 0, 0), leaving at (0, 3, 0) a second, arriving at rest */
    "steps",   /* x = 0, 1, 2, 3 in steps of 1/10 s, the last of them held */
    "hiding",  /* two bars shown in turn by their scales */
    "skinned", /* the upper of two bones, joined at y = 1, turns by 90 degrees about z */
    "morphed", /* a sparse target lifts the top by 1, with weight 0 to 1; another, of weight 1/2, moves all by (0, 0, 1)
                */
    "two",     /* two animations: "rise" by (0, 1, 0), and "fall" */
};

typedef struct gltf_text {
    char text[GLTF_TEXT];
    size_t used;
} gltf_text;

typedef struct gltf_file {
    gltf_text nodes, meshes, skins, animations, accessors, views;
    unsigned char bytes[GLTF_BYTES];
    size_t size;
    int accessor_count, view_count;
    int roots[4], root_count;
} gltf_file;

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
static void
gltf_put(gltf_text *t, const char *format, ...) {
    va_list args;
    va_start(args, format);
    t->used += (size_t)vsnprintf(t->text + t->used, sizeof t->text - t->used, format, args);
    va_end(args);
}

/* Begins another element of a list. */
static void gltf_next(gltf_text *t) {
    if (t->used)
        gltf_put(t, ",");
}

static int gltf_view(gltf_file *g, const void *data, size_t size, int target) {
    gltf_next(&g->views);
    gltf_put(&g->views, "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu", g->size, size);
    if (target)
        gltf_put(&g->views, ",\"target\":%d", target);
    gltf_put(&g->views, "}");
    memcpy(g->bytes + g->size, data, size);
    g->size += (size + 3) / 4 * 4;
    return g->view_count++;
}

static void gltf_bounds(gltf_file *g, const float *values, size_t count, size_t width) {
    for (int top = 0; top < 2; top++) {
        gltf_put(&g->accessors, ",\"%s\":[", top ? "max" : "min");
        for (size_t k = 0; k < width; k++) {
            float bound = values[k];
            for (size_t i = 0; i < count; i++)
                if (top ? values[i * width + k] > bound : values[i * width + k] < bound)
                    bound = values[i * width + k];
            gltf_put(&g->accessors, "%s%.9g", k ? "," : "", (double)bound);
        }
        gltf_put(&g->accessors, "]");
    }
}

/* An accessor of floats; for vertices `target` is 34962. */
static int gltf_floats(gltf_file *g, const float *values, size_t count, size_t width, int target) {
    static const char *const types[] = {"", "SCALAR", "", "VEC3", "VEC4"};
    const int view = gltf_view(g, values, count * width * sizeof(float), target);
    gltf_next(&g->accessors);
    gltf_put(&g->accessors, "{\"bufferView\":%d,\"componentType\":5126,\"count\":%zu,\"type\":\"%s\"", view, count,
             width == 16 ? "MAT4" : types[width]);
    if (width < 4)
        gltf_bounds(g, values, count, width);
    gltf_put(&g->accessors, "}");
    return g->accessor_count++;
}

/* ---- The bar ---- */

static void gltf_bar_positions(float positions[3 * GLTF_VERTICES]) {
    static const float ring[4][2] = {{-0.5f, -0.5f}, {0.5f, -0.5f}, {0.5f, 0.5f}, {-0.5f, 0.5f}};
    for (int i = 0; i < GLTF_VERTICES; i++) {
        positions[3 * i] = ring[i % 4][0];
        positions[3 * i + 1] = (float)(i / 4);
        positions[3 * i + 2] = ring[i % 4][1];
    }
}

static int gltf_bar_indices(gltf_file *g) {
    static const uint16_t caps[12] = {0, 1, 2, 0, 2, 3, 8, 10, 9, 8, 11, 10};
    uint16_t indices[3 * GLTF_TRIANGLES];
    size_t n = 0;
    for (int ring = 0; ring < 2; ring++)
        for (int k = 0; k < 4; k++) {
            const uint16_t a = (uint16_t)(4 * ring + k), b = (uint16_t)(4 * ring + (k + 1) % 4);
            const uint16_t sides[6] = {a, (uint16_t)(a + 4), b, b, (uint16_t)(a + 4), (uint16_t)(b + 4)};
            memcpy(indices + n, sides, sizeof sides);
            n += 6;
        }
    memcpy(indices + n, caps, sizeof caps);
    const int view = gltf_view(g, indices, sizeof indices, 34963);
    gltf_next(&g->accessors);
    gltf_put(&g->accessors, "{\"bufferView\":%d,\"componentType\":5123,\"count\":%d,\"type\":\"SCALAR\"}", view,
             3 * GLTF_TRIANGLES);
    return g->accessor_count++;
}

/* Mesh 0; `attributes` and `more` go into its primitive and itself. */
static void gltf_bar(gltf_file *g, const char *attributes, const char *targets, const char *more) {
    float positions[3 * GLTF_VERTICES];
    gltf_bar_positions(positions);
    const int position = gltf_floats(g, positions, GLTF_VERTICES, 3, 34962);
    gltf_put(&g->meshes, "{\"primitives\":[{\"attributes\":{\"POSITION\":%d%s},\"indices\":%d%s}]%s}", position,
             attributes, gltf_bar_indices(g), targets, more);
}

static void gltf_node(gltf_file *g, int root, const char *text) {
    int number = 0;
    for (const char *p = g->nodes.text; *p; p++)
        number += *p == '\n';
    gltf_next(&g->nodes);
    gltf_put(&g->nodes, "\n{%s}", text);
    if (root)
        g->roots[g->root_count++] = number;
}

/* ---- Animations ---- */

/* An animation of one channel. */
static void gltf_animate(gltf_file *g, const char *name, int node, const char *path, const char *interpolation,
                         const float *times, size_t keys, const float *values, size_t count, size_t width) {
    const int input = gltf_floats(g, times, keys, 1, 0), output = gltf_floats(g, values, count, width, 0);
    gltf_next(&g->animations);
    gltf_put(&g->animations,
             "{\"name\":\"%s\",\"samplers\":[{\"input\":%d,\"output\":%d,\"interpolation\":\"%s\"}],"
             "\"channels\":[{\"sampler\":0,\"target\":{\"node\":%d,\"path\":\"%s\"}}]}",
             name, input, output, interpolation, node, path);
}

static const float gltf_second[2] = {0.0f, 1.0f};

static void gltf_make_moving(gltf_file *g, const char *kind) {
    static const float line[6] = {0, 0, 0, 2, 4, 0}, rise[6] = {0, 0, 0, 0, 1, 0}, fall[6] = {0, 0, 0, 0, -1, 0};
    gltf_bar(g, "", "", "");
    gltf_node(g, 1, "\"mesh\":0");
    if (strcmp(kind, "two") == 0) {
        gltf_animate(g, "rise", 0, "translation", "LINEAR", gltf_second, 2, rise, 2, 3);
        gltf_animate(g, "fall", 0, "translation", "LINEAR", gltf_second, 2, fall, 2, 3);
    } else if (strcmp(kind, "moving") == 0)
        gltf_animate(g, "move", 0, "translation", "LINEAR", gltf_second, 2, line, 2, 3);
}

static void gltf_make_late(gltf_file *g) {
    float times[25], values[75] = {0};
    for (int i = 0; i < 25; i++) {
        times[i] = 3.0f + (float)i / 24.0f;
        values[3 * i] = 2.0f * (float)i / 24.0f;
        values[3 * i + 1] = 4.0f * (float)i / 24.0f;
    }
    gltf_bar(g, "", "", "");
    gltf_node(g, 1, "\"mesh\":0");
    gltf_animate(g, "move", 0, "translation", "LINEAR", times, 25, values, 25, 3);
}

static void gltf_make_turning(gltf_file *g) {
    static const float turn[8] = {0, 0, 0, 1, 0, 0, 0.70710678f, 0.70710678f};
    gltf_bar(g, "", "", "");
    gltf_node(g, 1, "\"children\":[1]");
    gltf_node(g, 0, "\"mesh\":0,\"translation\":[3,0,0]");
    gltf_animate(g, "turn", 0, "rotation", "LINEAR", gltf_second, 2, turn, 2, 4);
}

static void gltf_make_cubic(gltf_file *g) {
    static const float keys[18] = {0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0};
    gltf_bar(g, "", "", "");
    gltf_node(g, 1, "\"mesh\":0");
    gltf_animate(g, "curve", 0, "translation", "CUBICSPLINE", gltf_second, 2, keys, 6, 3);
}

static void gltf_make_steps(gltf_file *g) {
    static const float times[5] = {0, 0.1f, 0.2f, 0.3f, 0.4f};
    static const float values[15] = {0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 3, 0, 0};
    gltf_bar(g, "", "", "");
    gltf_node(g, 1, "\"mesh\":0");
    gltf_animate(g, "steps", 0, "translation", "STEP", times, 5, values, 5, 3);
}

static void gltf_make_hiding(gltf_file *g) {
    static const float times[3] = {0, 0.5f, 1};
    static const float scales[2][9] = {{1, 1, 1, 0, 0, 0, 0, 0, 0}, {0, 0, 0, 1, 1, 1, 1, 1, 1}};
    gltf_bar(g, "", "", "");
    gltf_node(g, 1, "\"mesh\":0");
    gltf_node(g, 1, "\"mesh\":0,\"translation\":[5,0,0],\"scale\":[0,0,0]");
    const int input = gltf_floats(g, times, 3, 1, 0);
    const int output[2] = {gltf_floats(g, scales[0], 3, 3, 0), gltf_floats(g, scales[1], 3, 3, 0)};
    gltf_put(&g->animations, "{\"samplers\":[");
    for (int i = 0; i < 2; i++)
        gltf_put(&g->animations, "%s{\"input\":%d,\"output\":%d,\"interpolation\":\"STEP\"}", i ? "," : "", input,
                 output[i]);
    gltf_put(&g->animations, "],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"scale\"}},"
                             "{\"sampler\":1,\"target\":{\"node\":1,\"path\":\"scale\"}}]}");
}

/* Joints are the nodes 1 and 2. */
static void gltf_make_skinned(gltf_file *g) {
    static const float turn[8] = {0, 0, 0, 1, 0, 0, 0.70710678f, 0.70710678f};
    static const float bind[32] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,
                                   1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1};
    uint8_t joints[4 * GLTF_VERTICES] = {0};
    float weights[4 * GLTF_VERTICES] = {0};
    char attributes[64], text[64];
    for (int i = 0; i < GLTF_VERTICES; i++) {
        joints[4 * i + 1] = i / 4 > 0;
        weights[4 * i] = 1.0f - 0.5f * (float)(i / 4);
        weights[4 * i + 1] = 0.5f * (float)(i / 4);
    }
    const int view = gltf_view(g, joints, sizeof joints, 34962);
    gltf_put(&g->accessors, "{\"bufferView\":%d,\"componentType\":5121,\"count\":%d,\"type\":\"VEC4\"}", view,
             GLTF_VERTICES);
    const int joint = g->accessor_count++;
    snprintf(attributes, sizeof attributes, ",\"JOINTS_0\":%d,\"WEIGHTS_0\":%d", joint,
             gltf_floats(g, weights, GLTF_VERTICES, 4, 34962));
    gltf_bar(g, attributes, "", "");
    snprintf(text, sizeof text, "\"mesh\":0,\"skin\":0");
    gltf_node(g, 1, text);
    gltf_node(g, 1, "\"children\":[2]");
    gltf_node(g, 0, "\"translation\":[0,1,0]");
    gltf_put(&g->skins, "{\"joints\":[1,2],\"inverseBindMatrices\":%d}", gltf_floats(g, bind, 2, 16, 0));
    gltf_animate(g, "bend", 2, "rotation", "LINEAR", gltf_second, 2, turn, 2, 4);
}

static void gltf_make_morphed(gltf_file *g) {
    static const uint16_t top[4] = {8, 9, 10, 11};
    static const float lift[12] = {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0}, weights[4] = {0, 0.5f, 1, 0.5f};
    float all[3 * GLTF_VERTICES] = {0};
    char targets[64];
    for (int i = 0; i < GLTF_VERTICES; i++)
        all[3 * i + 2] = 1.0f;
    const int indices = gltf_view(g, top, sizeof top, 0), values = gltf_view(g, lift, sizeof lift, 0);
    gltf_put(&g->accessors,
             "{\"componentType\":5126,\"count\":%d,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[0,1,0],\"sparse\":"
             "{\"count\":4,\"indices\":{\"bufferView\":%d,\"componentType\":5123},\"values\":{\"bufferView\":%d}}}",
             GLTF_VERTICES, indices, values);
    const int sparse = g->accessor_count++;
    snprintf(targets, sizeof targets, ",\"targets\":[{\"POSITION\":%d},{\"POSITION\":%d}]", sparse,
             gltf_floats(g, all, GLTF_VERTICES, 3, 34962));
    gltf_bar(g, "", targets, ",\"weights\":[0,0.5]");
    gltf_node(g, 1, "\"mesh\":0");
    gltf_animate(g, "grow", 0, "weights", "LINEAR", gltf_second, 2, weights, 4, 1);
}

/* ---- Files ---- */

static void gltf_list(gltf_text *all, const char *name, const gltf_text *list) {
    if (list->used)
        gltf_put(all, ",\"%s\":[%s]", name, list->text);
}

static void gltf_word(unsigned char *to, size_t word) {
    for (int k = 0; k < 4; k++)
        to[k] = (unsigned char)(word >> (8 * k));
}

/* The file of the parts, as GLB; *bytes is the caller's to free. */
static size_t gltf_finish(const gltf_file *g, unsigned char **bytes) {
    gltf_text *all = calloc(1, sizeof *all);
    gltf_put(all, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"make_gltf\"},\"scene\":0,\"scenes\":[{\"nodes\":[");
    for (int i = 0; i < g->root_count; i++)
        gltf_put(all, "%s%d", i ? "," : "", g->roots[i]);
    gltf_put(all, "]}]");
    gltf_list(all, "nodes", &g->nodes);
    gltf_list(all, "meshes", &g->meshes);
    gltf_list(all, "skins", &g->skins);
    gltf_list(all, "animations", &g->animations);
    gltf_list(all, "accessors", &g->accessors);
    gltf_list(all, "bufferViews", &g->views);
    gltf_put(all, ",\"buffers\":[{\"byteLength\":%zu}]}", g->size);
    while (all->used % 4)
        gltf_put(all, " ");
    const size_t size = 28 + all->used + g->size;
    unsigned char *out = calloc(1, size);
    memcpy(out, "glTF\2\0\0\0", 8);
    gltf_word(out + 8, size);
    gltf_word(out + 12, all->used);
    memcpy(out + 16, "JSON", 4);
    memcpy(out + 20, all->text, all->used);
    gltf_word(out + 20 + all->used, g->size);
    memcpy(out + 24 + all->used, "BIN\0", 4);
    memcpy(out + 28 + all->used, g->bytes, g->size);
    free(all);
    *bytes = out;
    return size;
}

/* A file of a kind, as GLB; 0 when there is no such kind. */
static size_t gltf_make(const char *kind, unsigned char **bytes) {
    static const struct {
        const char *kind;
        void (*make)(gltf_file *g);
    } others[] = {{"late", gltf_make_late},       {"turning", gltf_make_turning},
                  {"cubic", gltf_make_cubic},     {"steps", gltf_make_steps},
                  {"hiding", gltf_make_hiding},   {"skinned", gltf_make_skinned},
                  {"morphed", gltf_make_morphed}, {NULL, NULL}};
    size_t known = 0, i = 0;
    for (size_t k = 0; k < sizeof gltf_kinds / sizeof *gltf_kinds; k++)
        known += strcmp(gltf_kinds[k], kind) == 0;
    if (!known)
        return 0;
    gltf_file *g = calloc(1, sizeof *g);
    while (others[i].kind && strcmp(others[i].kind, kind) != 0)
        i++;
    if (others[i].kind)
        others[i].make(g);
    else
        gltf_make_moving(g, kind);
    const size_t size = gltf_finish(g, bytes);
    free(g);
    return size;
}

#endif

#include "obj_mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char no_memory[] = "out of memory";

enum { MOST = 1 << 28 }; /* vertices, triangles */

/* ---- Growing --------------------------------------------------------------------------------------------- */

/* Room for three more of `size` bytes behind `used`; NULL when there is none, with *data as it was. */
static void *grow(void *data, size_t used, size_t *capacity, size_t size) {
    if (used + 3 <= *capacity)
        return data;
    const size_t wanted = 2 * *capacity + 3 * 1024;
    void *grown = realloc(data, wanted * size);
    if (grown)
        *capacity = wanted;
    return grown;
}

static const char *add_vertex(play_obj_mesh *m, const char *text, const char *line_end) {
    const size_t used = 3 * m->vertex_count;
    float *positions =
        m->vertex_count < MOST ? grow(m->positions, used, &m->position_capacity, sizeof *positions) : NULL;
    if (!positions)
        return no_memory;
    m->positions = positions;
    for (int k = 0; k < 3; k++) {
        char *end;
        positions[used + (size_t)k] = strtof(text, &end);
        if (end == text || end > line_end || !isfinite(positions[used + (size_t)k]))
            return "a vertex needs three finite numbers";
        text = end;
    }
    m->vertex_count++;
    return NULL;
}

static const char *add_triangle(play_obj_mesh *m, const uint32_t corners[3]) {
    const size_t used = 3 * m->triangle_count;
    uint32_t *indices = m->triangle_count < MOST ? grow(m->indices, used, &m->index_capacity, sizeof *indices) : NULL;
    if (!indices)
        return no_memory;
    m->indices = indices;
    memcpy(indices + used, corners, 3 * sizeof *indices);
    m->triangle_count++;
    return NULL;
}

/* ---- Lines ----------------------------------------------------------------------------------------------- */

/* "1 2 3", "1/4/7 ...", "1//7 ..."; negative ones count back from the last vertex. */
static const char *add_face(play_obj_mesh *m, const char *text, const char *line_end) {
    uint32_t corners[3] = {0, 0, 0};
    for (int corner = 0;; corner++) {
        char *end;
        text += strspn(text, " \t");
        if (text >= line_end)
            return corner < 3 ? "a face needs three corners" : NULL;
        long long index = strtoll(text, &end, 10);
        if (end == text)
            return "a face has a corner that is no number";
        index = index < 0 ? index + (long long)m->vertex_count : index - 1;
        if (index < 0 || index >= (long long)m->vertex_count)
            return "a face has an index that is out of range";
        corners[1] = corners[2];
        corners[2] = (uint32_t)index;
        if (corner == 0)
            corners[0] = corners[2];
        const char *failure = corner >= 2 ? add_triangle(m, corners) : NULL;
        if (failure)
            return failure;
        text = end + strcspn(end, " \t\r\n");
    }
}

static const char *parse_line(play_obj_mesh *m, const char *text, const char *line_end) {
    text += strspn(text, " \t");
    const int argument = text[0] != '\0' && (text[1] == ' ' || text[1] == '\t');
    if (argument && text[0] == 'v')
        return add_vertex(m, text + 2, line_end);
    if (argument && text[0] == 'f')
        return add_face(m, text + 2, line_end);
    return NULL;
}

/* ---- Normals --------------------------------------------------------------------------------------------- */

static void add_normals(play_obj_mesh *m, const uint32_t *t) {
    const float *a = m->positions + 3 * (size_t)t[0], *b = m->positions + 3 * (size_t)t[1],
                *c = m->positions + 3 * (size_t)t[2];
    for (int k = 0; k < 3; k++) {
        const int u = (k + 1) % 3, v = (k + 2) % 3;
        const float n = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
        for (int corner = 0; corner < 3; corner++)
            m->normals[3 * (size_t)t[corner] + (size_t)k] += n;
    }
}

static const char *compute_normals(play_obj_mesh *m) {
    free(m->normals);
    m->normals = calloc(m->vertex_count, 3 * sizeof *m->normals);
    if (!m->normals)
        return no_memory;
    for (size_t i = 0; i < m->triangle_count; i++)
        add_normals(m, m->indices + 3 * i);
    for (size_t i = 0; i < m->vertex_count; i++) {
        float *n = m->normals + 3 * i;
        const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int k = 0; k < 3 && length > 0.0f; k++)
            n[k] /= length;
    }
    return NULL;
}

const char *play_obj_parse(play_obj_mesh *m, const char *text, unsigned long *line) {
    m->vertex_count = m->triangle_count = 0;
    for (*line = 1; *text; ++*line) {
        const char *line_end = text + strcspn(text, "\r\n");
        const char *failure = parse_line(m, text, line_end);
        if (failure)
            return failure;
        text = line_end + (line_end[0] == '\r' && line_end[1] == '\n' ? 2 : line_end[0] != '\0');
    }
    return m->triangle_count ? compute_normals(m) : "there are no faces in it";
}

void play_obj_free(play_obj_mesh *m) {
    free(m->positions);
    free(m->normals);
    free(m->indices);
    memset(m, 0, sizeof *m);
}

nsdf_mesh_view play_obj_view(const play_obj_mesh *m) {
    return (nsdf_mesh_view){m->positions, m->normals, m->indices, (uint32_t)m->vertex_count,
                            (uint32_t)m->triangle_count};
}

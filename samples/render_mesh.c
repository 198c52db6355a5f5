#include "render_mesh.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char no_memory[] = "out of memory";

static const char *add_vertex(nsdf_render_mesh *mesh, const char *text) {
    if (mesh->vertex_count == mesh->vertex_capacity) {
        mesh->vertex_capacity = mesh->vertex_capacity ? 2 * mesh->vertex_capacity : 1 << 12;
        double *positions = realloc(mesh->positions, mesh->vertex_capacity * 3 * sizeof *positions);
        if (!positions)
            return no_memory;
        mesh->positions = positions;
    }
    double *p = mesh->positions + 3 * mesh->vertex_count++;
    for (int c = 0; c < 3; c++) {
        char *end;
        p[c] = strtod(text, &end);
        if (end == text || !isfinite(p[c]))
            return "a vertex needs three finite numbers";
        text = end;
    }
    return NULL;
}

static const char *add_triangle(nsdf_render_mesh *mesh, uint32_t a, uint32_t b, uint32_t c) {
    if (mesh->triangle_count == mesh->triangle_capacity) {
        mesh->triangle_capacity = mesh->triangle_capacity ? 2 * mesh->triangle_capacity : 1 << 13;
        uint32_t *triangles = realloc(mesh->triangles, mesh->triangle_capacity * 3 * sizeof *triangles);
        if (!triangles)
            return no_memory;
        mesh->triangles = triangles;
    }
    uint32_t *t = mesh->triangles + 3 * mesh->triangle_count++;
    t[0] = a, t[1] = b, t[2] = c;
    return NULL;
}

/* "f 1 2 3", "f 1/2/3 ...", "f 1//3 ...", negative indices count from the last vertex. */
static const char *add_face(nsdf_render_mesh *mesh, const char *text) {
    uint32_t first = 0, last = 0;
    for (int corner = 0;; corner++) {
        char *end;
        long index = strtol(text, &end, 10);
        if (end == text)
            return corner < 3 ? "a face needs three corners" : NULL;
        if (index < 0)
            index += (long)mesh->vertex_count + 1;
        if (index < 1 || (size_t)index > mesh->vertex_count)
            return "a face has an index that is out of range";
        uint32_t vertex = (uint32_t)(index - 1);
        const char *failure = corner >= 2 ? add_triangle(mesh, first, last, vertex) : NULL;
        if (failure)
            return failure;
        first = corner == 0 ? vertex : first;
        last = vertex;
        text = end + strcspn(end, " \t\r\n");
    }
}

static const char *compute_normals(nsdf_render_mesh *mesh) {
    mesh->normals = calloc(mesh->vertex_count, 3 * sizeof *mesh->normals);
    if (!mesh->normals)
        return no_memory;
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *t = mesh->triangles + 3 * i;
        const double *a = mesh->positions + 3 * t[0], *b = mesh->positions + 3 * t[1], *c = mesh->positions + 3 * t[2];
        for (int k = 0; k < 3; k++) {
            int u = (k + 1) % 3, v = (k + 2) % 3;
            double n = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
            for (int corner = 0; corner < 3; corner++)
                mesh->normals[3 * t[corner] + (uint32_t)k] += n;
        }
    }
    return NULL;
}

static const char *read_lines(FILE *file, nsdf_render_mesh *mesh) {
    char line[1024];
    while (fgets(line, sizeof line, file)) {
        const char *failure = NULL;
        if (line[0] == 'v' && (line[1] == ' ' || line[1] == '\t'))
            failure = add_vertex(mesh, line + 2);
        else if (line[0] == 'f' && (line[1] == ' ' || line[1] == '\t'))
            failure = add_face(mesh, line + 2);
        if (failure)
            return failure;
    }
    if (ferror(file))
        return strerror(errno);
    return mesh->triangle_count ? compute_normals(mesh) : "there are no faces in it";
}

const char *nsdf_render_mesh_read(const char *path, nsdf_render_mesh *mesh) {
    *mesh = (nsdf_render_mesh){0};
    FILE *file = fopen(path, "r");
    if (!file)
        return strerror(errno);
    const char *failure = read_lines(file, mesh);
    fclose(file);
    if (failure)
        nsdf_render_mesh_free(mesh);
    return failure;
}

void nsdf_render_mesh_free(nsdf_render_mesh *mesh) {
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->triangles);
    *mesh = (nsdf_render_mesh){0};
}

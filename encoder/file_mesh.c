#include "file_mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "input_error.h"
#include "obj_polygon.h"

void nsdf_file_mesh_clear(nsdf_file_mesh *mesh) {
    mesh->vertex_count = 0;
    mesh->triangle_count = 0;
    mesh->polygon_count = 0;
    mesh->bad_count = 0;
}

void nsdf_file_mesh_free(nsdf_file_mesh *mesh) {
    if (mesh != NULL) {
        free(mesh->positions);
        free(mesh->indices);
        free(mesh->polygons);
        free(mesh->bad);
        *mesh = (nsdf_file_mesh){0};
    }
}

void *nsdf_grow(void *array, size_t *capacity, size_t wanted, size_t size) {
    if (wanted <= *capacity) {
        return array;
    }
    size_t larger = *capacity + *capacity / 2 + 256;
    larger = larger < wanted ? wanted : larger;
    void *moved = larger <= SIZE_MAX / size ? realloc(array, larger * size) : NULL;
    if (moved != NULL) {
        *capacity = larger;
    }
    return moved;
}

nsdf_status nsdf_file_mesh_add_vertex(nsdf_file_mesh *mesh, const double xyz[3], const char *name,
                                      nsdf_encoder_error *error) {
    size_t count = mesh->vertex_count;
    if (count == NSDF_FILE_MESH_MAX) {
        return nsdf_input_fail(error, NSDF_LIMIT, "%s: too many vertices", nsdf_show_path(name).text);
    }
    double *positions = nsdf_grow(mesh->positions, &mesh->vertex_capacity, count + 1, 3 * sizeof *positions);
    if (positions == NULL) {
        return nsdf_input_no_memory(error);
    }
    mesh->positions = positions;
    memcpy(&positions[3 * count], xyz, 3 * sizeof *positions);
    mesh->vertex_count++;
    return NSDF_OK;
}

static nsdf_status add_triangle(nsdf_file_mesh *mesh, uint32_t a, uint32_t b, uint32_t c, const char *name,
                                nsdf_encoder_error *error) {
    size_t count = mesh->triangle_count;
    if (count == NSDF_FILE_MESH_MAX) {
        return nsdf_input_fail(error, NSDF_LIMIT, "%s: too many triangles", nsdf_show_path(name).text);
    }
    uint32_t *indices = nsdf_grow(mesh->indices, &mesh->triangle_capacity, count + 1, 3 * sizeof *indices);
    if (indices == NULL) {
        return nsdf_input_no_memory(error);
    }
    mesh->indices = indices;
    indices[3 * count] = a;
    indices[3 * count + 1] = b;
    indices[3 * count + 2] = c;
    mesh->triangle_count++;
    return NSDF_OK;
}

nsdf_status nsdf_file_mesh_add_corner(nsdf_file_mesh *mesh, nsdf_corners *corners, uint32_t vertex, const char *name,
                                      nsdf_encoder_error *error) {
    nsdf_status status = NSDF_OK;
    if (corners->count >= 2) {
        status = add_triangle(mesh, corners->first, corners->previous, vertex, name, error);
    } else if (corners->count == 0) {
        corners->first = vertex;
    }
    corners->previous = vertex;
    corners->count++;
    return status;
}

nsdf_status nsdf_file_mesh_end_polygon(nsdf_file_mesh *mesh, const nsdf_corners *corners, nsdf_encoder_error *error) {
    if (corners->count <= 3) {
        return NSDF_OK;
    }
    nsdf_polygon_note *notes =
        nsdf_grow(mesh->polygons, &mesh->polygon_capacity, mesh->polygon_count + 1, sizeof *notes);
    if (notes == NULL) {
        return nsdf_input_no_memory(error);
    }
    mesh->polygons = notes;
    notes[mesh->polygon_count++] = (nsdf_polygon_note){mesh->triangle_count - (corners->count - 2), corners->count};
    return NSDF_OK;
}

nsdf_status nsdf_file_mesh_note_bad(nsdf_file_mesh *mesh, uint64_t line, const char *at, nsdf_encoder_error *error) {
    nsdf_bad_vertex *bad = nsdf_grow(mesh->bad, &mesh->bad_capacity, mesh->bad_count + 1, sizeof *bad);
    if (bad == NULL) {
        return nsdf_input_no_memory(error);
    }
    mesh->bad = bad;
    bad[mesh->bad_count++] = (nsdf_bad_vertex){mesh->vertex_count, line, at};
    return NSDF_OK;
}

const nsdf_bad_vertex *nsdf_file_mesh_find_bad(const nsdf_file_mesh *mesh) {
    uint32_t least = UINT32_MAX;
    for (size_t i = 0; mesh->bad_count > 0 && i < 3 * (size_t)mesh->triangle_count; i++) {
        const double *p = &mesh->positions[3 * (size_t)mesh->indices[i]];
        if (mesh->indices[i] < least && !(isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]))) {
            least = mesh->indices[i];
        }
    }
    for (size_t i = 0; i < mesh->bad_count; i++) {
        if (mesh->bad[i].vertex == least) {
            return &mesh->bad[i];
        }
    }
    return NULL;
}

nsdf_status nsdf_file_mesh_finish(nsdf_file_mesh *mesh, const char *name, nsdf_encoder_error *error) {
    if (mesh->vertex_count == 0) {
        return nsdf_input_fail(error, NSDF_CORRUPT, "%s: no vertices", nsdf_show_path(name).text);
    }
    if (mesh->triangle_count == 0) {
        return nsdf_input_fail(error, NSDF_CORRUPT, "%s: no faces", nsdf_show_path(name).text);
    }
    for (size_t i = 0; i < mesh->polygon_count; i++) {
        const nsdf_polygon_note *note = &mesh->polygons[i];
        nsdf_improve_fan(mesh->positions, &mesh->indices[3 * (size_t)note->triangle], note->corners);
    }
    return NSDF_OK;
}

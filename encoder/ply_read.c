/* One pass over the body, element by element.  Every value takes at least a byte of the file, so that counts that lie
 * cost no more time or memory than the file's own size. */
#include "ply_read.h"

#include <math.h>

#include "ply_value.h"

typedef struct reader {
    nsdf_ply_header header;
    nsdf_ply_cursor cursor;
    nsdf_file_mesh *mesh;
} reader;

static nsdf_status skip_list(reader *r, const nsdf_ply_property *p) {
    int64_t length = 0;
    nsdf_status status = nsdf_ply_read_whole(&r->cursor, p->count_type, &length);
    for (int64_t i = 0; i < length && status == NSDF_OK; i++) {
        status = nsdf_ply_skip_value(&r->cursor, p->type);
    }
    return status;
}

static nsdf_status skip_property(reader *r, const nsdf_ply_property *p) {
    return p->is_list ? skip_list(r, p) : nsdf_ply_skip_value(&r->cursor, p->type);
}

static nsdf_status read_vertex(reader *r, const nsdf_ply_element *element) {
    double xyz[3] = {0.0, 0.0, 0.0};
    nsdf_status status = NSDF_OK;
    for (uint32_t i = 0; i < element->property_count && status == NSDF_OK; i++) {
        const nsdf_ply_property *p = &r->header.properties[element->first + i];
        const char *at = r->cursor.at;
        if (p->role == NSDF_PLY_SKIPPED) {
            status = skip_property(r, p);
            continue;
        }
        double *value = &xyz[p->role - NSDF_PLY_X];
        status = nsdf_ply_read_real(&r->cursor, p->type, value);
        if (status == NSDF_OK && !isfinite(*value)) {
            status = nsdf_file_mesh_note_bad(r->mesh, r->cursor.line, at, r->cursor.error);
        }
    }
    return status == NSDF_OK ? nsdf_file_mesh_add_vertex(r->mesh, xyz, r->cursor.name, r->cursor.error) : status;
}

static nsdf_status read_corner(reader *r, const nsdf_ply_property *p, nsdf_corners *corners) {
    const char *at = r->cursor.at;
    int64_t index = 0;
    nsdf_status status = nsdf_ply_read_whole(&r->cursor, p->type, &index);
    if (status != NSDF_OK) {
        return status;
    }
    if (index < 0 || (uint64_t)index >= r->header.vertex_count) {
        return nsdf_ply_fail(&r->cursor, at, "face index %lld is out of range (the file has %llu vertices)",
                             (long long)index, (unsigned long long)r->header.vertex_count);
    }
    if (index > NSDF_FILE_MESH_MAX) {
        return nsdf_ply_fail(&r->cursor, at, "face index %lld is too large", (long long)index);
    }
    return nsdf_file_mesh_add_corner(r->mesh, corners, (uint32_t)index, r->cursor.name, r->cursor.error);
}

static nsdf_status read_corners(reader *r, const nsdf_ply_property *p) {
    const char *at = r->cursor.at;
    nsdf_corners corners = {0};
    int64_t count = 0;
    nsdf_status status = nsdf_ply_read_whole(&r->cursor, p->count_type, &count);
    if (status == NSDF_OK && count < 3) {
        return nsdf_ply_fail(&r->cursor, at, "a face needs at least three vertices");
    }
    for (int64_t i = 0; i < count && status == NSDF_OK; i++) {
        status = read_corner(r, p, &corners);
    }
    return status == NSDF_OK ? nsdf_file_mesh_end_polygon(r->mesh, &corners, r->cursor.error) : status;
}

/* Faces, and elements that are skipped whole. */
static nsdf_status read_other(reader *r, const nsdf_ply_element *element) {
    nsdf_status status = NSDF_OK;
    for (uint32_t i = 0; i < element->property_count && status == NSDF_OK; i++) {
        const nsdf_ply_property *p = &r->header.properties[element->first + i];
        status = p->role == NSDF_PLY_CORNERS ? read_corners(r, p) : skip_property(r, p);
    }
    return status;
}

static nsdf_status read_elements(reader *r, const nsdf_ply_element *element) {
    nsdf_status status = NSDF_OK;
    const uint64_t count = element->property_count > 0 ? element->count : 0;
    for (uint64_t i = 0; i < count && status == NSDF_OK; i++) {
        status = nsdf_ply_begin_element(&r->cursor);
        if (status == NSDF_OK) {
            status = element->kind == NSDF_PLY_VERTEX ? read_vertex(r, element) : read_other(r, element);
        }
        status = status == NSDF_OK ? nsdf_ply_end_element(&r->cursor) : status;
    }
    return status;
}

static nsdf_status read_body(reader *r) {
    nsdf_status status = NSDF_OK;
    for (uint32_t i = 0; i < r->header.element_count && status == NSDF_OK; i++) {
        status = read_elements(r, &r->header.elements[i]);
    }
    return status == NSDF_OK ? nsdf_ply_check_end(&r->cursor) : status;
}

/* Wrong only where a face uses the vertex. */
static nsdf_status check_finite(reader *r) {
    const nsdf_bad_vertex *bad = nsdf_file_mesh_find_bad(r->mesh);
    if (bad == NULL) {
        return NSDF_OK;
    }
    r->cursor.line = bad->line;
    return nsdf_ply_fail(&r->cursor, bad->at, "a coordinate is not a finite number");
}

nsdf_status nsdf_ply_parse(const char *name, const char *text, size_t size, nsdf_file_mesh *mesh,
                           nsdf_encoder_error *error) {
    reader r = {.mesh = mesh};
    nsdf_file_mesh_clear(mesh);
    nsdf_status status = nsdf_ply_read_header(name, text, size, &r.header, error);
    if (status == NSDF_OK) {
        r.cursor = (nsdf_ply_cursor){.name = name,
                                     .start = text,
                                     .at = text + r.header.size,
                                     .end = text + size,
                                     .format = r.header.format,
                                     .line = r.header.line_count + 1,
                                     .error = error};
        status = read_body(&r);
    }
    status = status == NSDF_OK ? check_finite(&r) : status;
    status = status == NSDF_OK ? nsdf_file_mesh_finish(mesh, name, error) : status;
    if (status != NSDF_OK) {
        mesh->triangle_count = 0;
    }
    return status;
}

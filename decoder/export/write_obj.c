/* Wavefront OBJ: text. */
#include "mesh_output.h"

static void put_vectors(nsdf_output *out, const char *keyword, const float *values, uint32_t count) {
    const size_t length = strlen(keyword);
    for (uint32_t i = 0; i < count && out->status == NSDF_OK; i++, values += 3) {
        unsigned char *const start = nsdf_output_room(out), *at = start;
        memcpy(at, keyword, length);
        at += length;
        for (int a = 0; a < 3; a++) {
            *at++ = ' ';
            at = nsdf_put_decimal(at, values[a]);
        }
        *at++ = '\n';
        out->used += (size_t)(at - start);
    }
}

static void put_faces(nsdf_output *out, const nsdf_mesh_view *view) {
    const uint32_t *index = view->indices;
    for (uint32_t i = 0; i < view->triangle_count && out->status == NSDF_OK; i++) {
        unsigned char *const start = nsdf_output_room(out), *at = start;
        *at++ = 'f';
        for (int k = 0; k < 3; k++, index++) {
            *at++ = ' ';
            unsigned char *const number = at;
            at = nsdf_put_integer(at, *index + 1); /* OBJ counts from 1 */
            if (!view->normals)
                continue;
            const size_t length = (size_t)(at - number);
            *at++ = '/';
            *at++ = '/';
            memcpy(at, number, length);
            at += length;
        }
        *at++ = '\n';
        out->used += (size_t)(at - start);
    }
}

void nsdf_write_obj(const nsdf_mesh_view *view, nsdf_output *out) {
    put_vectors(out, "v", view->positions, view->vertex_count);
    if (view->normals)
        put_vectors(out, "vn", view->normals, view->vertex_count);
    put_faces(out, view);
}

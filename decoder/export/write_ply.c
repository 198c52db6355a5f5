/* PLY: text header, little-endian binary body. */
#include "mesh_output.h"

static void put_text(nsdf_output *out, const char *text) {
    unsigned char *const at = nsdf_output_room(out);
    const size_t length = strlen(text);
    memcpy(at, text, length);
    out->used += length;
}

static void put_count(nsdf_output *out, const char *element, uint32_t count) {
    put_text(out, element);
    unsigned char *const at = nsdf_output_room(out);
    out->used += (size_t)(nsdf_put_integer(at, count) - at);
    put_text(out, "\n");
}

static void put_header(nsdf_output *out, const nsdf_mesh_view *view) {
    put_text(out, "ply\nformat binary_little_endian 1.0\n");
    put_count(out, "element vertex ", view->vertex_count);
    put_text(out, "property float x\nproperty float y\nproperty float z\n");
    if (view->normals)
        put_text(out, "property float nx\nproperty float ny\nproperty float nz\n");
    put_count(out, "element face ", view->triangle_count);
    put_text(out, "property list uchar int vertex_indices\nend_header\n");
}

void nsdf_write_ply(const nsdf_mesh_view *view, nsdf_output *out) {
    put_header(out, view);
    for (size_t v = 0; v < view->vertex_count && out->status == NSDF_OK; v++) {
        unsigned char *const start = nsdf_output_room(out), *at = start;
        for (size_t a = 0; a < 3; a++)
            at = nsdf_put_float(at, view->positions[3 * v + a]);
        for (size_t a = 0; a < 3 && view->normals; a++)
            at = nsdf_put_float(at, view->normals[3 * v + a]);
        out->used += (size_t)(at - start);
    }
    for (size_t i = 0; i < view->triangle_count && out->status == NSDF_OK; i++) {
        unsigned char *at = nsdf_output_room(out);
        *at++ = 3;
        for (size_t k = 0; k < 3; k++)
            at = nsdf_put_u32(at, view->indices[3 * i + k]);
        out->used += 13;
    }
}

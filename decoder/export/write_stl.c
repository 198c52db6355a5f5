/* STL: little-endian binary; 80 bytes of header, the count, then 50 bytes for each triangle. */
#include "mesh_output.h"

#include <math.h>

/* Unit normal of a triangle, or zeros if it has no area. */
static void face_normal(const float *const p[3], float normal[3]) {
    double u[3], v[3], n[3];
    for (int a = 0; a < 3; a++) {
        u[a] = (double)p[1][a] - (double)p[0][a];
        v[a] = (double)p[2][a] - (double)p[0][a];
    }
    for (int a = 0; a < 3; a++)
        n[a] = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const int usable = length > 0 && isfinite(length);
    for (int a = 0; a < 3; a++)
        normal[a] = usable ? (float)(n[a] / length) : 0;
}

void nsdf_write_stl(const nsdf_mesh_view *view, nsdf_output *out) {
    static const char header[80] = "binary STL"; /* must not start with "solid": that means text */
    unsigned char *const start = nsdf_output_room(out);
    memcpy(start, header, sizeof header);
    nsdf_put_u32(start + sizeof header, view->triangle_count);
    out->used += sizeof header + 4;
    for (size_t i = 0; i < view->triangle_count && out->status == NSDF_OK; i++) {
        unsigned char *at = nsdf_output_room(out);
        const float *p[3];
        float normal[3];
        for (size_t k = 0; k < 3; k++)
            p[k] = view->positions + 3 * (size_t)view->indices[3 * i + k];
        face_normal(p, normal);
        for (int a = 0; a < 3; a++)
            at = nsdf_put_float(at, normal[a]);
        for (int k = 0; k < 3; k++)
            for (int a = 0; a < 3; a++)
                at = nsdf_put_float(at, p[k][a]);
        at[0] = at[1] = 0; /* attribute bytes */
        out->used += 50;
    }
}

#include "decoded_surface.h"

#include <stdlib.h>
#include <string.h>

int nsdf_decoded_surface(const nsdf_file_header *header, const nsdf_mesh *mesh, nsdf_surface *surface) {
    nsdf_mesh_view view;
    *surface = (nsdf_surface){0};
    if (nsdf_mesh_get_view(mesh, &view) != NSDF_OK)
        return -1;
    nsdf_surface s = {malloc(3 * sizeof(float) * ((size_t)view.vertex_count + 1)),
                      malloc(3 * sizeof(uint32_t) * ((size_t)view.triangle_count + 1)), view.vertex_count,
                      view.triangle_count};
    *surface = s;
    if (!s.positions || !s.indices)
        return -1;
    for (size_t i = 0; i < 3 * (size_t)view.vertex_count; i++)
        s.positions[i] = (float)(((double)view.positions[i] - header->centre[i % 3]) / header->scale);
    if (view.triangle_count)
        memcpy(s.indices, view.indices, 3 * sizeof(uint32_t) * view.triangle_count);
    return 0;
}

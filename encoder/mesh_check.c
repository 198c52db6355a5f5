#include "mesh_check.h"

#include <math.h>

#include "input_error.h"

/* Well inside the range of float, in which surfaces are kept and decoded. */
static const double largest_coordinate = 1e30;

static nsdf_status check_vertex(const char *name, const nsdf_input_mesh *mesh, uint32_t vertex,
                                nsdf_encoder_error *error) {
    for (size_t k = 0; k < 3; k++) {
        const double x = mesh->positions[3 * (size_t)vertex + k];
        if (!isfinite(x)) {
            return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "%s: vertex %u is not finite", name, vertex);
        }
        if (fabs(x) > largest_coordinate) {
            return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "%s: vertex %u is further away than %g", name, vertex,
                                   largest_coordinate);
        }
    }
    return NSDF_OK;
}

nsdf_status nsdf_check_mesh(const char *name, const nsdf_input_mesh *mesh, nsdf_encoder_error *error) {
    if (mesh->positions == NULL || mesh->indices == NULL || mesh->vertex_count == 0 || mesh->triangle_count == 0) {
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "%s: no faces", name);
    }
    nsdf_status status = NSDF_OK;
    for (size_t i = 0; status == NSDF_OK && i < 3 * (size_t)mesh->triangle_count; i++) {
        if (mesh->indices[i] >= mesh->vertex_count) {
            status = nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "%s: triangle %zu uses vertex %u, but there are %u",
                                     name, i / 3, mesh->indices[i], mesh->vertex_count);
        } else {
            status = check_vertex(name, mesh, mesh->indices[i], error);
        }
    }
    return status;
}

#include "mesh_check.h"

#include <math.h>

#include "input_error.h"

/* Well inside the range of float, in which surfaces are kept and decoded. */
static const double largest_coordinate = 1e30;

static nsdf_status check_positions(const char *name, const nsdf_input_mesh *mesh, nsdf_encoder_error *error) {
    for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++) {
        if (!isfinite(mesh->positions[i])) {
            return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "%s: vertex %zu is not finite", name, i / 3);
        }
        if (fabs(mesh->positions[i]) > largest_coordinate) {
            return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "%s: vertex %zu is further away than %g", name, i / 3,
                                   largest_coordinate);
        }
    }
    return NSDF_OK;
}

nsdf_status nsdf_check_mesh(const char *name, const nsdf_input_mesh *mesh, nsdf_encoder_error *error) {
    if (mesh->positions == NULL || mesh->indices == NULL || mesh->vertex_count == 0 || mesh->triangle_count == 0) {
        return nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "%s: no faces", name);
    }
    nsdf_status status = check_positions(name, mesh, error);
    for (size_t i = 0; status == NSDF_OK && i < 3 * (size_t)mesh->triangle_count; i++) {
        if (mesh->indices[i] >= mesh->vertex_count) {
            status = nsdf_input_fail(error, NSDF_INVALID_ARGUMENT, "%s: triangle %zu uses vertex %u, but there are %u",
                                     name, i / 3, mesh->indices[i], mesh->vertex_count);
        }
    }
    return status;
}

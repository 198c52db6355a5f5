/* Which mesh format, and the checks that all of them share. */
#include "mesh_output.h"

static int ends_in(const char *name, const char *ending) {
    const size_t length = strlen(name), n = strlen(ending);
    if (length <= n)
        return 0;
    for (size_t i = 0; i < n; i++) {
        const char c = name[length - n + i];
        if ((c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c) != ending[i])
            return 0;
    }
    return 1;
}

nsdf_status nsdf_mesh_format_from_name(const char *name, nsdf_mesh_format *format) {
    static const char *const endings[] = {".obj", ".ply", ".stl"};
    if (!name || !format)
        return NSDF_INVALID_ARGUMENT;
    for (int i = 0; i < 3; i++) {
        if (!ends_in(name, endings[i]))
            continue;
        *format = (nsdf_mesh_format)i;
        return NSDF_OK;
    }
    return NSDF_UNSUPPORTED_FEATURE;
}

static int is_valid(const nsdf_mesh_view *view) {
    if (!view || (view->vertex_count && !view->positions) || (view->triangle_count && !view->indices))
        return 0;
    for (size_t i = 0; i < 3 * (size_t)view->triangle_count; i++)
        if (view->indices[i] >= view->vertex_count)
            return 0;
    return 1;
}

nsdf_status nsdf_write_mesh(const nsdf_mesh_view *view, nsdf_mesh_format format, nsdf_write_fn write, void *user) {
    if (!write || !is_valid(view))
        return NSDF_INVALID_ARGUMENT;
    nsdf_output out;
    out.write = write;
    out.user = user;
    out.status = NSDF_OK;
    out.used = 0;
    switch (format) {
    case NSDF_MESH_OBJ:
        nsdf_write_obj(view, &out);
        break;
    case NSDF_MESH_PLY:
        nsdf_write_ply(view, &out);
        break;
    case NSDF_MESH_STL:
        nsdf_write_stl(view, &out);
        break;
    default:
        return NSDF_INVALID_ARGUMENT;
    }
    nsdf_output_flush(&out);
    return out.status;
}

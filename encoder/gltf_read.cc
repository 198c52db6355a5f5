/* The library's one file of C++: nothing of it leaves by exceptions. */
extern "C" {
#include "gltf_read.h"
#include "input_error.h"
}

#include <tiny_gltf.h>

#include <array>
#include <cmath>
#include <cstring>
#include <new>

namespace {

typedef std::array<double, 16> matrix; /* columns one after the other, as in glTF */

const matrix identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

struct reader {
    const char *name;
    const tinygltf::Model &model;
    nsdf_file_mesh *mesh;
    nsdf_encoder_error *error;
};

nsdf_status fail(const reader &r, const char *what) {
    return nsdf_input_fail(r.error, NSDF_CORRUPT, "%s: %s", nsdf_show_path(r.name).text, what);
}

matrix multiply(const matrix &a, const matrix &b) {
    matrix c;
    for (size_t column = 0; column < 4; column++)
        for (size_t row = 0; row < 4; row++) {
            c[4 * column + row] = 0.0;
            for (size_t k = 0; k < 4; k++)
                c[4 * column + row] += a[4 * k + row] * b[4 * column + k];
        }
    return c;
}

/* Rotation by a quaternion x, y, z, w. */
matrix rotate(const std::vector<double> &q) {
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    return {1 - 2 * (y * y + z * z),
            2 * (x * y + z * w),
            2 * (x * z - y * w),
            0,
            2 * (x * y - z * w),
            1 - 2 * (x * x + z * z),
            2 * (y * z + x * w),
            0,
            2 * (x * z + y * w),
            2 * (y * z - x * w),
            1 - 2 * (x * x + y * y),
            0,
            0,
            0,
            0,
            1};
}

matrix local_matrix(const tinygltf::Node &node) {
    matrix m = identity;
    if (node.matrix.size() == 16) {
        std::copy(node.matrix.begin(), node.matrix.end(), m.begin());
        return m;
    }
    if (node.rotation.size() == 4)
        m = rotate(node.rotation);
    for (size_t column = 0; column < 3 && node.scale.size() == 3; column++)
        for (size_t row = 0; row < 3; row++)
            m[4 * column + row] *= node.scale[column];
    for (size_t row = 0; row < 3 && node.translation.size() == 3; row++)
        m[12 + row] = node.translation[row];
    return m;
}

/* ---- Accessors ---- */

/* Elements of an accessor, whose bytes are checked to be there. */
struct elements {
    const unsigned char *data = nullptr;
    size_t count = 0, stride = 0;
    int component = 0;
};

bool find_elements(const tinygltf::Model &model, int index, int type, elements &e) {
    if (index < 0 || (size_t)index >= model.accessors.size())
        return false;
    const tinygltf::Accessor &a = model.accessors[(size_t)index];
    if (a.type != type || a.sparse.isSparse || a.bufferView < 0 || (size_t)a.bufferView >= model.bufferViews.size())
        return false;
    const tinygltf::BufferView &view = model.bufferViews[(size_t)a.bufferView];
    const int stride = a.ByteStride(view), size = tinygltf::GetComponentSizeInBytes((uint32_t)a.componentType) *
                                                  tinygltf::GetNumComponentsInType((uint32_t)a.type);
    if (stride <= 0 || size <= 0 || view.buffer < 0 || (size_t)view.buffer >= model.buffers.size())
        return false;
    const std::vector<unsigned char> &bytes = model.buffers[(size_t)view.buffer].data;
    e.count = a.count;
    e.stride = (size_t)stride;
    e.component = a.componentType;
    if (e.count == 0)
        return true;
    if (view.byteOffset > bytes.size() || a.byteOffset > bytes.size() - view.byteOffset)
        return false;
    const size_t first = view.byteOffset + a.byteOffset, left = bytes.size() - first;
    if (left < (size_t)size || (e.count - 1) > (left - (size_t)size) / e.stride)
        return false;
    e.data = bytes.data() + first;
    return true;
}

uint32_t index_at(const elements &e, size_t i) {
    const unsigned char *at = e.data + i * e.stride;
    uint32_t wide = 0;
    uint16_t narrow = 0;
    if (e.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE)
        return at[0];
    if (e.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) {
        std::memcpy(&narrow, at, sizeof narrow);
        return narrow;
    }
    std::memcpy(&wide, at, sizeof wide);
    return wide;
}

/* ---- Primitives ---- */

nsdf_status add_vertices(const reader &r, const elements &positions, const matrix &m) {
    nsdf_status status = NSDF_OK;
    for (size_t i = 0; i < positions.count && status == NSDF_OK; i++) {
        float p[3];
        double xyz[3];
        std::memcpy(p, positions.data + i * positions.stride, sizeof p);
        for (size_t k = 0; k < 3; k++)
            xyz[k] = m[k] * (double)p[0] + m[4 + k] * (double)p[1] + m[8 + k] * (double)p[2] + m[12 + k];
        status = nsdf_file_mesh_add_vertex(r.mesh, xyz, r.name, r.error);
    }
    return status;
}

nsdf_status add_triangle(const reader &r, uint32_t base, size_t vertices, const uint32_t corners[3]) {
    nsdf_corners polygon = {};
    nsdf_status status = NSDF_OK;
    for (int k = 0; k < 3 && status == NSDF_OK; k++) {
        if (corners[k] >= vertices)
            return fail(r, "an index is out of range");
        const double *p = r.mesh->positions + 3 * ((size_t)base + corners[k]);
        if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2]))
            return fail(r, "a coordinate is not a finite number");
        status = nsdf_file_mesh_add_corner(r.mesh, &polygon, base + corners[k], r.name, r.error);
    }
    return status;
}

/* Places of the corners of triangle i in the list of indices. */
void place_corners(int mode, size_t i, size_t at[3]) {
    const bool list = mode == TINYGLTF_MODE_TRIANGLES, fan = mode == TINYGLTF_MODE_TRIANGLE_FAN;
    at[0] = list ? 3 * i : fan ? 0 : i;
    at[1] = list ? 3 * i + 1 : fan ? i + 1 : i + 1 + i % 2;
    at[2] = list ? 3 * i + 2 : fan ? i + 2 : i + 2 - i % 2;
}

nsdf_status add_primitive(const reader &r, const tinygltf::Primitive &primitive, const matrix &m) {
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    const auto position = primitive.attributes.find("POSITION");
    elements positions, indices;
    if (mode < TINYGLTF_MODE_TRIANGLES)
        return NSDF_OK; /* points and lines */
    if (position == primitive.attributes.end() ||
        !find_elements(r.model, position->second, TINYGLTF_TYPE_VEC3, positions) ||
        positions.component != TINYGLTF_COMPONENT_TYPE_FLOAT)
        return fail(r, "positions that are not a list of three floats each");
    const bool indexed = primitive.indices >= 0;
    if (indexed && !find_elements(r.model, primitive.indices, TINYGLTF_TYPE_SCALAR, indices))
        return fail(r, "indices that are not there");
    const uint32_t base = r.mesh->vertex_count;
    nsdf_status status = add_vertices(r, positions, m);
    const size_t corners = indexed ? indices.count : positions.count;
    const size_t count = mode == TINYGLTF_MODE_TRIANGLES ? corners / 3 : corners < 3 ? 0 : corners - 2;
    for (size_t i = 0; i < count && status == NSDF_OK; i++) {
        size_t at[3];
        uint32_t corner[3];
        place_corners(mode, i, at);
        for (int k = 0; k < 3; k++)
            corner[k] = indexed ? index_at(indices, at[k]) : (uint32_t)at[k];
        status = add_triangle(r, base, positions.count, corner);
    }
    return status;
}

/* ---- Nodes ---- */

/* No node has itself below it where the depth is at most the number of nodes. */
nsdf_status add_node(const reader &r, int index, const matrix &above, size_t depth) {
    if (index < 0 || (size_t)index >= r.model.nodes.size() || depth > r.model.nodes.size() || depth > 256)
        return fail(r, "nodes that are not there, or in a circle");
    const tinygltf::Node &node = r.model.nodes[(size_t)index];
    const matrix m = multiply(above, local_matrix(node));
    nsdf_status status = NSDF_OK;
    if (node.mesh >= 0 && (size_t)node.mesh < r.model.meshes.size())
        for (const tinygltf::Primitive &p : r.model.meshes[(size_t)node.mesh].primitives)
            if (status == NSDF_OK)
                status = add_primitive(r, p, m);
    for (int child : node.children)
        if (status == NSDF_OK)
            status = add_node(r, child, m, depth + 1);
    return status;
}

nsdf_status add_scene(const reader &r) {
    const size_t scenes = r.model.scenes.size();
    const int chosen = r.model.defaultScene;
    nsdf_status status = NSDF_OK;
    if (scenes == 0)
        return fail(r, "no scene");
    for (int node : r.model.scenes[chosen >= 0 && (size_t)chosen < scenes ? (size_t)chosen : 0].nodes)
        if (status == NSDF_OK)
            status = add_node(r, node, identity, 0);
    return status;
}

/* Textures are of no use here. */
bool skip_image(tinygltf::Image *, const int, std::string *, std::string *, int, int, const unsigned char *, int,
                void *) {
    return true;
}

nsdf_status parse(const char *name, const char *text, size_t size, nsdf_file_mesh *mesh, nsdf_encoder_error *error) {
    tinygltf::TinyGLTF loader;
    tinygltf::Model model;
    std::string why, warning;
    const std::string path(name), folder = path.substr(0, path.find_last_of('/') + 1);
    loader.SetImageLoader(skip_image, nullptr);
    if (size > UINT32_MAX)
        return nsdf_input_fail(error, NSDF_LIMIT, "%s: too large", nsdf_show_path(name).text);
    const bool binary = size >= 4 && std::memcmp(text, "glTF", 4) == 0;
    const bool read = binary ? loader.LoadBinaryFromMemory(&model, &why, &warning, (const unsigned char *)text,
                                                           (unsigned)size, folder)
                             : loader.LoadASCIIFromString(&model, &why, &warning, text, (unsigned)size, folder);
    const reader r = {name, model, mesh, error};
    if (!read) {
        const size_t line = why.find_first_of("\r\n");
        return fail(r, why.empty() ? "not a glTF file" : why.substr(0, line < 100 ? line : 100).c_str());
    }
    const nsdf_status status = add_scene(r);
    return status == NSDF_OK ? nsdf_file_mesh_finish(mesh, name, error) : status;
}

} // namespace

extern "C" nsdf_status nsdf_gltf_parse(const char *name, const char *text, size_t size, nsdf_file_mesh *mesh,
                                       nsdf_encoder_error *error) {
    nsdf_status status = NSDF_NO_MEMORY;
    nsdf_file_mesh_clear(mesh);
    try {
        status = parse(name, text, size, mesh, error);
    } catch (const std::bad_alloc &) {
        status = nsdf_input_no_memory(error);
    } catch (const std::exception &) {
        status = nsdf_input_fail(error, NSDF_CORRUPT, "%s: not a glTF file", nsdf_show_path(name).text);
    }
    if (status != NSDF_OK)
        mesh->triangle_count = 0;
    return status;
}

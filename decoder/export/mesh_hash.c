/* FNV-1a over the little-endian bytes of a mesh (Fowler, Noll, Vo; draft-eastlake-fnv). */
#include "mesh_output.h"

static uint64_t hash_u32(uint64_t hash, uint32_t value) {
    for (int i = 0; i < 4; i++, value >>= 8)
        hash = (hash ^ (value & 0xff)) * 0x100000001b3u;
    return hash;
}

static uint64_t hash_floats(uint64_t hash, const float *values, size_t count) {
    for (size_t i = 0; i < count; i++)
        hash = hash_u32(hash, nsdf_float_bits(values[i]));
    return hash;
}

uint64_t nsdf_mesh_hash(const nsdf_mesh_view *view) {
    uint64_t hash = 0xcbf29ce484222325u;
    if (!view)
        return hash;
    hash = hash_u32(hash, view->vertex_count);
    hash = hash_u32(hash, view->triangle_count);
    hash = hash_floats(hash, view->positions, 3 * (size_t)view->vertex_count);
    if (view->normals)
        hash = hash_floats(hash, view->normals, 3 * (size_t)view->vertex_count);
    for (size_t i = 0; i < 3 * (size_t)view->triangle_count; i++)
        hash = hash_u32(hash, view->indices[i]);
    return hash;
}

#include "gltf_model.h"

#include <algorithm>
#include <cstring>

namespace nsdf_gltf {

/* The bytes of a view from an offset on: `count` elements of `size` bytes, `stride` apart; null when they are not
 * there. */
static const unsigned char *find_bytes(const tinygltf::Model &model, int view_index, size_t offset, size_t count,
                                       size_t size, size_t stride) {
    if (view_index < 0 || (size_t)view_index >= model.bufferViews.size())
        return nullptr;
    const tinygltf::BufferView &view = model.bufferViews[(size_t)view_index];
    if (view.buffer < 0 || (size_t)view.buffer >= model.buffers.size())
        return nullptr;
    const std::vector<unsigned char> &bytes = model.buffers[(size_t)view.buffer].data;
    if (view.byteOffset > bytes.size() || offset > bytes.size() - view.byteOffset)
        return nullptr;
    const size_t first = view.byteOffset + offset, left = bytes.size() - first;
    if (left < size || (count - 1) > (left - size) / stride)
        return nullptr;
    return bytes.data() + first;
}

static size_t element_size(int component, int type) {
    const int size = tinygltf::GetComponentSizeInBytes((uint32_t)component);
    const int width = tinygltf::GetNumComponentsInType((uint32_t)type);
    return size > 0 && width > 0 ? (size_t)size * (size_t)width : 0;
}

bool find_elements(const tinygltf::Model &model, int index, int type, elements &e) {
    if (index < 0 || (size_t)index >= model.accessors.size())
        return false;
    const tinygltf::Accessor &a = model.accessors[(size_t)index];
    const size_t size = element_size(a.componentType, a.type);
    if (a.type != type || a.sparse.isSparse || a.bufferView < 0 || (size_t)a.bufferView >= model.bufferViews.size())
        return false;
    const int stride = a.ByteStride(model.bufferViews[(size_t)a.bufferView]);
    if (stride <= 0 || size == 0)
        return false;
    e.count = a.count;
    e.stride = (size_t)stride;
    e.component = a.componentType;
    e.data = e.count > 0 ? find_bytes(model, a.bufferView, a.byteOffset, e.count, size, e.stride) : nullptr;
    return e.count == 0 || e.data != nullptr;
}

template <typename T> static T take(const unsigned char *at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return value;
}

uint32_t index_at(const elements &e, size_t i) {
    const unsigned char *at = e.data + i * e.stride;
    if (e.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE)
        return at[0];
    return e.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? take<uint16_t>(at) : take<uint32_t>(at);
}

/* One number, scaled to [0, 1] or [-1, 1] when it is normalised. */
static double number_at(const unsigned char *at, int component, bool normalised) {
    double value = 0.0, top = 1.0;
    switch (component) {
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return (double)take<float>(at);
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        value = (double)take<int8_t>(at), top = 127.0;
        break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        value = (double)take<uint8_t>(at), top = 255.0;
        break;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        value = (double)take<int16_t>(at), top = 32767.0;
        break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        value = (double)take<uint16_t>(at), top = 65535.0;
        break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return (double)take<uint32_t>(at);
    default:
        break;
    }
    return normalised ? std::max(value / top, -1.0) : value;
}

static void copy_element(const tinygltf::Accessor &a, const unsigned char *from, size_t width, double *to) {
    const size_t size = (size_t)tinygltf::GetComponentSizeInBytes((uint32_t)a.componentType);
    for (size_t k = 0; k < width; k++)
        to[k] = number_at(from + k * size, a.componentType, a.normalized);
}

/* Elements that a sparse accessor replaces. */
static bool replace_sparse(const tinygltf::Model &model, const tinygltf::Accessor &a, size_t width,
                           std::vector<double> &numbers) {
    if (a.sparse.count <= 0 || a.sparse.indices.byteOffset < 0 || a.sparse.values.byteOffset < 0)
        return a.sparse.count == 0;
    const size_t count = (size_t)a.sparse.count, size = element_size(a.componentType, a.type);
    elements places;
    places.component = a.sparse.indices.componentType;
    places.stride = element_size(places.component, TINYGLTF_TYPE_SCALAR);
    if (places.stride == 0 || places.component == TINYGLTF_COMPONENT_TYPE_DOUBLE)
        return false;
    places.data = find_bytes(model, a.sparse.indices.bufferView, (size_t)a.sparse.indices.byteOffset, count,
                             places.stride, places.stride);
    const unsigned char *values =
        find_bytes(model, a.sparse.values.bufferView, (size_t)a.sparse.values.byteOffset, count, size, size);
    for (size_t i = 0; places.data && values && i < count; i++) {
        const size_t place = index_at(places, i);
        if (place >= a.count)
            return false;
        copy_element(a, values + i * size, width, numbers.data() + place * width);
    }
    return places.data && values;
}

bool read_numbers(const tinygltf::Model &model, int index, int type, size_t count, std::vector<double> &numbers) {
    if (index < 0 || (size_t)index >= model.accessors.size())
        return false;
    const tinygltf::Accessor &a = model.accessors[(size_t)index];
    const size_t size = element_size(a.componentType, a.type);
    const bool there = a.bufferView >= 0;
    if (a.type != type || size == 0 || a.componentType == TINYGLTF_COMPONENT_TYPE_DOUBLE ||
        (count != any_count && a.count != count) || (!there && count == any_count))
        return false;
    const size_t width = (size_t)tinygltf::GetNumComponentsInType((uint32_t)type);
    const unsigned char *data = nullptr;
    size_t stride = size;
    if (there && (size_t)a.bufferView < model.bufferViews.size() && a.count > 0) {
        const int own = a.ByteStride(model.bufferViews[(size_t)a.bufferView]);
        if (own <= 0)
            return false;
        stride = (size_t)own;
        data = find_bytes(model, a.bufferView, a.byteOffset, a.count, size, stride);
    }
    if (there && a.count > 0 && !data)
        return false;
    numbers.assign(a.count * width, 0.0); /* where there is no view, all are 0 */
    for (size_t i = 0; data && i < a.count; i++)
        copy_element(a, data + i * stride, width, numbers.data() + i * width);
    return !a.sparse.isSparse || replace_sparse(model, a, width, numbers);
}

} // namespace nsdf_gltf

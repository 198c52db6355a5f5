// draco_mesh.h on libdraco; C++ because that is the library's only interface.  No exception leaves this file.
#include "draco_mesh.h"

#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/core/draco_version.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>

struct draco_mesh_decoded {
    std::unique_ptr<draco::Mesh> mesh;
};

namespace {

constexpr int top_level = 10;

void set_message(draco_mesh_error *error, const char *message) {
    if (error != nullptr)
        std::snprintf(error->message, sizeof error->message, "%s", message);
}

void check(const draco::Status &status) {
    if (!status.ok())
        throw std::runtime_error(status.error_msg_string());
}

void add_attribute(draco::TriangleSoupMeshBuilder &builder, draco::GeometryAttribute::Type type, const float *values,
                   const uint32_t *indices, uint32_t triangle_count) {
    const int attribute = builder.AddAttribute(type, 3, draco::DT_FLOAT32);
    for (uint32_t i = 0; i < triangle_count; i++) {
        const uint32_t *corner = indices + 3 * static_cast<size_t>(i);
        builder.SetAttributeValuesForFace(attribute, draco::FaceIndex(i), values + 3 * static_cast<size_t>(corner[0]),
                                          values + 3 * static_cast<size_t>(corner[1]),
                                          values + 3 * static_cast<size_t>(corner[2]));
    }
}

// `normals` may be null.
std::unique_ptr<draco::Mesh> build(const float *positions, const float *normals, const uint32_t *indices,
                                   uint32_t triangle_count) {
    draco::TriangleSoupMeshBuilder builder;
    builder.Start(static_cast<int>(triangle_count));
    add_attribute(builder, draco::GeometryAttribute::POSITION, positions, indices, triangle_count);
    if (normals != nullptr)
        add_attribute(builder, draco::GeometryAttribute::NORMAL, normals, indices, triangle_count);
    std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
    if (mesh == nullptr)
        throw std::runtime_error("Draco cannot build the mesh");
    return mesh;
}

void encode(const draco::Mesh &mesh, const draco_mesh_options &options, draco::EncoderBuffer &buffer) {
    const int speed = top_level - options.level;
    draco::Encoder encoder;
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, options.position_bits);
    if (options.normal_bits > 0)
        encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, options.normal_bits);
    check(encoder.EncodeMeshToBuffer(mesh, &buffer));
}

draco_mesh_bytes copy_bytes(const draco::EncoderBuffer &buffer) {
    draco_mesh_bytes bytes = {static_cast<unsigned char *>(std::malloc(buffer.size())), buffer.size()};
    if (bytes.data == nullptr)
        throw std::bad_alloc();
    std::memcpy(bytes.data, buffer.data(), buffer.size());
    return bytes;
}

std::unique_ptr<draco::Mesh> decode(const void *data, size_t size) {
    draco::DecoderBuffer buffer;
    buffer.Init(static_cast<const char *>(data), size);
    draco::Decoder decoder;
    auto result = decoder.DecodeMeshFromBuffer(&buffer);
    check(result.status());
    std::unique_ptr<draco::Mesh> mesh = std::move(result).value();
    if (mesh->GetNamedAttribute(draco::GeometryAttribute::POSITION) == nullptr)
        throw std::runtime_error("the mesh has no positions");
    return mesh;
}

} // namespace

int draco_mesh_encode(const float *positions, const float *normals, const uint32_t *indices, uint32_t triangle_count,
                      const draco_mesh_options *options, draco_mesh_bytes *bytes, draco_mesh_error *error) {
    try {
        draco::EncoderBuffer buffer;
        const float *wanted = options->normal_bits > 0 ? normals : nullptr;
        encode(*build(positions, wanted, indices, triangle_count), *options, buffer);
        *bytes = copy_bytes(buffer);
        return 0;
    } catch (const std::exception &failure) {
        set_message(error, failure.what());
        return -1;
    }
}

void draco_mesh_bytes_free(draco_mesh_bytes *bytes) {
    std::free(bytes->data);
    *bytes = {nullptr, 0};
}

draco_mesh_decoded *draco_mesh_decode(const void *data, size_t size, draco_mesh_error *error) {
    try {
        return new draco_mesh_decoded{decode(data, size)};
    } catch (const std::exception &failure) {
        set_message(error, failure.what());
        return nullptr;
    }
}

void draco_mesh_decoded_free(draco_mesh_decoded *decoded) {
    delete decoded;
}

uint32_t draco_mesh_vertex_count(const draco_mesh_decoded *decoded) {
    return decoded->mesh->num_points();
}

uint32_t draco_mesh_triangle_count(const draco_mesh_decoded *decoded) {
    return decoded->mesh->num_faces();
}

void draco_mesh_copy(const draco_mesh_decoded *decoded, float *positions, uint32_t *indices) {
    const draco::Mesh &mesh = *decoded->mesh;
    const draco::PointAttribute *attribute = mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
    for (uint32_t i = 0; positions != nullptr && i < mesh.num_points(); i++)
        attribute->GetMappedValue(draco::PointIndex(i), positions + 3 * static_cast<size_t>(i));
    for (uint32_t i = 0; indices != nullptr && i < mesh.num_faces(); i++)
        for (size_t k = 0; k < 3; k++)
            indices[3 * static_cast<size_t>(i) + k] = mesh.face(draco::FaceIndex(i))[k].value();
}

const char *draco_mesh_version(void) {
    return draco::kDracoVersion;
}

#include "gltf_writer.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <ostream>
#include <streambuf>

/* The container counts its bytes with 32 bits; some are left for the description. */
static const size_t most_bytes = (size_t)UINT32_MAX - ((size_t)64 << 20);

struct nsdf_gltf {
    tinygltf::Model model;
    std::vector<int> nodes; /* of each surface, -1 = empty */
};

namespace {

tinygltf::Value number(double x) {
    return tinygltf::Value(x);
}

/* Appends bytes, which stay aligned to four, as a view of their own. */
int add_view(tinygltf::Model &model, const void *data, size_t size, int target) {
    std::vector<unsigned char> &bytes = model.buffers[0].data;
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = bytes.size();
    view.byteLength = size;
    view.target = target;
    const unsigned char *from = static_cast<const unsigned char *>(data);
    bytes.insert(bytes.end(), from, from + size);
    model.bufferViews.push_back(view);
    return (int)model.bufferViews.size() - 1;
}

int add_accessor(tinygltf::Model &model, int view, int component, int type, size_t count) {
    tinygltf::Accessor accessor;
    accessor.bufferView = view;
    accessor.componentType = component;
    accessor.type = type;
    accessor.count = count;
    model.accessors.push_back(accessor);
    return (int)model.accessors.size() - 1;
}

int add_floats(tinygltf::Model &model, const float *values, size_t count, int width, int target) {
    const int view = add_view(model, values, count * (size_t)width * sizeof(float), target);
    return add_accessor(model, view, TINYGLTF_COMPONENT_TYPE_FLOAT,
                        width == 3 ? TINYGLTF_TYPE_VEC3 : TINYGLTF_TYPE_SCALAR, count);
}

/* Bounds, which the format asks for with positions and times. */
void set_bounds(tinygltf::Accessor &accessor, const float *values, size_t count, int width) {
    for (int axis = 0; axis < width; axis++) {
        float low = values[axis], high = values[axis];
        for (size_t i = 1; i < count; i++) {
            low = std::min(low, values[i * (size_t)width + (size_t)axis]);
            high = std::max(high, values[i * (size_t)width + (size_t)axis]);
        }
        accessor.minValues.push_back((double)low);
        accessor.maxValues.push_back((double)high);
    }
}

int add_mesh(tinygltf::Model &model, const nsdf_mesh_view &view) {
    tinygltf::Primitive primitive;
    tinygltf::Mesh mesh;
    const size_t vertices = view.vertex_count, corners = 3 * (size_t)view.triangle_count;
    const int position = add_floats(model, view.positions, vertices, 3, TINYGLTF_TARGET_ARRAY_BUFFER);
    set_bounds(model.accessors[(size_t)position], view.positions, vertices, 3);
    primitive.attributes["POSITION"] = position;
    if (view.normals)
        primitive.attributes["NORMAL"] = add_floats(model, view.normals, vertices, 3, TINYGLTF_TARGET_ARRAY_BUFFER);
    const int indices = add_view(model, view.indices, corners * sizeof(uint32_t), TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    primitive.indices =
        add_accessor(model, indices, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR, corners);
    primitive.material = 0;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    mesh.primitives.push_back(primitive);
    model.meshes.push_back(mesh);
    return (int)model.meshes.size() - 1;
}

void add_node(nsdf_gltf &g, const nsdf_mesh_view &view, double seconds) {
    tinygltf::Node node;
    tinygltf::Value::Object extras;
    node.name = "frame " + std::to_string(g.nodes.size());
    node.mesh = add_mesh(g.model, view);
    extras["seconds"] = number(seconds);
    node.extras = tinygltf::Value(extras);
    g.model.nodes.push_back(node);
    g.nodes.push_back((int)g.model.nodes.size() - 1);
}

/* When a surface is shown: scale 1 from `index` to `index` + 1 intervals. */
void add_track(tinygltf::Model &model, tinygltf::Animation &animation, int node, size_t index, bool last,
               double interval) {
    std::vector<float> times, scales;
    const auto add = [&](double time, float scale) {
        times.push_back((float)time);
        scales.insert(scales.end(), 3, scale);
    };
    if (index > 0)
        add(0.0, 0.0f);
    add((double)index * interval, 1.0f);
    add((double)(index + 1) * interval, last ? 1.0f : 0.0f);
    tinygltf::AnimationSampler sampler;
    sampler.interpolation = "STEP";
    sampler.input = add_floats(model, times.data(), times.size(), 1, 0);
    set_bounds(model.accessors[(size_t)sampler.input], times.data(), times.size(), 1);
    sampler.output = add_floats(model, scales.data(), times.size(), 3, 0);
    animation.samplers.push_back(sampler);
    tinygltf::AnimationChannel channel;
    channel.sampler = (int)animation.samplers.size() - 1;
    channel.target_node = node;
    channel.target_path = "scale";
    animation.channels.push_back(channel);
}

void animate(tinygltf::Model &model, const std::vector<int> &nodes, double interval) {
    tinygltf::Animation animation;
    animation.name = "surface";
    for (size_t i = 0; i < nodes.size(); i++) {
        if (nodes[i] < 0)
            continue;
        add_track(model, animation, nodes[i], i, i + 1 == nodes.size(), interval);
        if (i > 0)
            model.nodes[(size_t)nodes[i]].scale = {0.0, 0.0, 0.0};
    }
    if (!animation.channels.empty())
        model.animations.push_back(animation);
}

void set_scene(tinygltf::Model &model, const std::vector<int> &nodes) {
    tinygltf::Scene scene;
    for (int node : nodes)
        if (node >= 0)
            scene.nodes.push_back(node);
    model.scenes.push_back(scene);
    model.defaultScene = 0;
}

/* Hands what is written to the callback. */
class Sink : public std::streambuf {
  public:
    Sink(nsdf_write_fn write, void *user) : write_(write), user_(user) {}

  protected:
    std::streamsize xsputn(const char *data, std::streamsize size) override {
        return write_(user_, data, (size_t)size) == 0 ? size : 0;
    }
    int overflow(int c) override {
        const char byte = (char)c;
        return c == EOF || write_(user_, &byte, 1) == 0 ? 0 : EOF;
    }

  private:
    nsdf_write_fn write_;
    void *user_;
};

} // namespace

nsdf_gltf *nsdf_gltf_create(const char *generator) try {
    nsdf_gltf *g = new nsdf_gltf;
    tinygltf::Material clay;
    clay.name = "clay";
    clay.pbrMetallicRoughness.baseColorFactor = {0.62, 0.60, 0.57, 1.0};
    clay.pbrMetallicRoughness.metallicFactor = 0.0;
    clay.pbrMetallicRoughness.roughnessFactor = 0.6;
    g->model.materials.push_back(clay);
    g->model.asset.version = "2.0";
    g->model.asset.generator = generator;
    g->model.buffers.emplace_back();
    return g;
} catch (const std::bad_alloc &) {
    return nullptr;
}

void nsdf_gltf_free(nsdf_gltf *gltf) {
    delete gltf;
}

nsdf_status nsdf_gltf_add(nsdf_gltf *g, const nsdf_mesh_view *view, double seconds) try {
    const size_t size = (size_t)view->vertex_count * (view->normals ? 24 : 12) + (size_t)view->triangle_count * 12;
    if (view->triangle_count == 0) {
        g->nodes.push_back(-1);
        return NSDF_OK;
    }
    if (g->model.buffers[0].data.size() + size > most_bytes)
        return NSDF_LIMIT;
    add_node(*g, *view, seconds);
    return NSDF_OK;
} catch (const std::bad_alloc &) {
    return NSDF_NO_MEMORY;
}

nsdf_status nsdf_gltf_write(const nsdf_gltf *g, double interval, nsdf_write_fn write, void *user) try {
    tinygltf::Model model = g->model;
    tinygltf::TinyGLTF writer;
    Sink sink(write, user);
    std::ostream out(&sink);
    if (g->nodes.size() > 1)
        animate(model, g->nodes, interval);
    set_scene(model, g->nodes);
    if (model.meshes.empty()) { /* an empty buffer, or a material that nothing uses, is not valid */
        model.buffers.clear();
        model.materials.clear();
    }
    return writer.WriteGltfSceneToStream(&model, out, false, true) && out ? NSDF_OK : NSDF_IO;
} catch (const std::bad_alloc &) {
    return NSDF_NO_MEMORY;
}

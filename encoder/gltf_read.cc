/* The library's C++ calls tinygltf: nothing of it leaves by exceptions. */
extern "C" {
#include "gltf_container.h"
#include "gltf_read.h"
#include "input_error.h"
}

#include "gltf_model.h"

#include <algorithm>
#include <cmath>
#include <new>

using namespace nsdf_gltf;

struct nsdf_gltf_film {
    std::string name, note;
    tinygltf::Model model;
    std::vector<track> tracks;
    std::vector<double> keys; /* seconds from `first` */
    double first = 0.0;
    bool in_steps = false, ends_held = false;
};

namespace {

struct reader {
    const char *name;
    const tinygltf::Model &model;
    const pose &stance;
    nsdf_file_mesh *mesh;
    nsdf_encoder_error *error;
};

nsdf_status refuse(const char *name, nsdf_encoder_error *error, const std::string &what) {
    return nsdf_input_fail(error, NSDF_CORRUPT, "%s: %s", nsdf_show_path(name).text, what.substr(0, 100).c_str());
}

nsdf_status fail(const reader &r, const char *what) {
    return refuse(r.name, r.error, what);
}

/* ---- Vertices ---- */

/* Where bones take the vertices of a skin: matrices of its joints. */
bool find_joints(const reader &r, int skin_index, std::vector<matrix> &joints) {
    if ((size_t)skin_index >= r.model.skins.size())
        return false;
    const tinygltf::Skin &skin = r.model.skins[(size_t)skin_index];
    std::vector<double> inverse;
    if (skin.inverseBindMatrices >= 0 &&
        !read_numbers(r.model, skin.inverseBindMatrices, TINYGLTF_TYPE_MAT4, any_count, inverse))
        return false;
    if (!inverse.empty() && inverse.size() < 16 * skin.joints.size())
        return false;
    for (size_t i = 0; i < skin.joints.size(); i++) {
        matrix bind;
        if (skin.joints[i] < 0 || (size_t)skin.joints[i] >= r.stance.world.size())
            return false;
        const matrix &world = r.stance.world[(size_t)skin.joints[i]];
        if (!inverse.empty())
            std::copy(inverse.begin() + 16 * (long)i, inverse.begin() + 16 * (long)(i + 1), bind.begin());
        joints.push_back(inverse.empty() ? world : multiply(world, bind));
    }
    return true;
}

/* Adds each vertex's share of joints to its matrix. */
bool add_influences(const reader &r, const tinygltf::Primitive &primitive, const std::string &set,
                    const std::vector<matrix> &joints, size_t count, std::vector<matrix> &sums,
                    std::vector<double> &totals) {
    const auto joint = primitive.attributes.find("JOINTS_" + set), weight = primitive.attributes.find("WEIGHTS_" + set);
    std::vector<double> which, how_much;
    if (joint == primitive.attributes.end() || weight == primitive.attributes.end() ||
        !read_numbers(r.model, joint->second, TINYGLTF_TYPE_VEC4, count, which) ||
        !read_numbers(r.model, weight->second, TINYGLTF_TYPE_VEC4, count, how_much))
        return false;
    for (size_t i = 0; i < 4 * count; i++) {
        if (how_much[i] == 0.0)
            continue;
        if (!(which[i] >= 0.0 && which[i] < (double)joints.size()))
            return false;
        const matrix &m = joints[(size_t)which[i]];
        for (size_t k = 0; k < 16; k++)
            sums[i / 4][k] += how_much[i] * m[k];
        totals[i / 4] += how_much[i];
    }
    return true;
}

/* A matrix for each vertex; false when the joints or weights are not there. */
bool blend_joints(const reader &r, const tinygltf::Primitive &primitive, int skin, size_t count,
                  std::vector<matrix> &blended) {
    std::vector<matrix> joints;
    std::vector<double> totals(count, 0.0);
    const matrix none = {};
    blended.assign(count, none);
    if (!find_joints(r, skin, joints))
        return false;
    for (size_t set = 0; set == 0 || primitive.attributes.count("JOINTS_" + std::to_string(set)); set++)
        if (!add_influences(r, primitive, std::to_string(set), joints, count, blended, totals))
            return false;
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < 16 && totals[i] > 0.0; k++)
            blended[i][k] /= totals[i];
    return true;
}

/* Adds the morph targets that have a weight; false when they cannot be read. */
bool morph(const reader &r, const tinygltf::Primitive &primitive, const std::vector<double> &weights,
           std::vector<double> &positions) {
    for (size_t t = 0; t < primitive.targets.size() && t < weights.size(); t++) {
        const auto moved = primitive.targets[t].find("POSITION");
        std::vector<double> offsets;
        if (weights[t] == 0.0 || moved == primitive.targets[t].end())
            continue;
        if (!read_numbers(r.model, moved->second, TINYGLTF_TYPE_VEC3, positions.size() / 3, offsets))
            return false;
        for (size_t i = 0; i < positions.size(); i++)
            positions[i] += weights[t] * offsets[i];
    }
    return true;
}

nsdf_status add_vertices(const reader &r, const std::vector<double> &positions, const matrix &all,
                         const std::vector<matrix> &each) {
    nsdf_status status = NSDF_OK;
    for (size_t i = 0; 3 * i < positions.size() && status == NSDF_OK; i++) {
        const matrix &m = each.empty() ? all : each[i];
        const double *p = positions.data() + 3 * i;
        double xyz[3];
        for (size_t k = 0; k < 3; k++)
            xyz[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
        status = nsdf_file_mesh_add_vertex(r.mesh, xyz, r.name, r.error);
    }
    return status;
}

/* ---- Triangles ---- */

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

nsdf_status add_triangles(const reader &r, const tinygltf::Primitive &primitive, int mode, uint32_t base,
                          size_t vertices) {
    elements indices;
    const bool indexed = primitive.indices >= 0;
    if (indexed && !find_elements(r.model, primitive.indices, TINYGLTF_TYPE_SCALAR, indices))
        return fail(r, "indices that are not there");
    nsdf_status status = NSDF_OK;
    const size_t corners = indexed ? indices.count : vertices;
    const size_t count = mode == TINYGLTF_MODE_TRIANGLES ? corners / 3 : corners < 3 ? 0 : corners - 2;
    for (size_t i = 0; i < count && status == NSDF_OK; i++) {
        size_t at[3];
        uint32_t corner[3];
        place_corners(mode, i, at);
        for (int k = 0; k < 3; k++)
            corner[k] = indexed ? index_at(indices, at[k]) : (uint32_t)at[k];
        status = add_triangle(r, base, vertices, corner);
    }
    return status;
}

nsdf_status add_primitive(const reader &r, const tinygltf::Primitive &primitive, size_t node_index) {
    const tinygltf::Node &node = r.model.nodes[node_index];
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    const auto position = primitive.attributes.find("POSITION");
    std::vector<double> positions;
    std::vector<matrix> blended;
    if (mode < TINYGLTF_MODE_TRIANGLES)
        return NSDF_OK; /* points and lines */
    if (position == primitive.attributes.end() ||
        !read_numbers(r.model, position->second, TINYGLTF_TYPE_VEC3, any_count, positions))
        return fail(r, "positions that are not a list of three numbers each");
    const size_t vertices = positions.size() / 3;
    if (!morph(r, primitive, r.stance.weights[node_index], positions))
        return fail(r, "morph targets that cannot be read");
    if (node.skin >= 0 && primitive.attributes.count("JOINTS_0") &&
        !blend_joints(r, primitive, node.skin, vertices, blended))
        return fail(r, "a skin whose joints or weights cannot be read");
    const uint32_t base = r.mesh->vertex_count;
    const nsdf_status status = add_vertices(r, positions, r.stance.world[node_index], blended);
    return status == NSDF_OK ? add_triangles(r, primitive, mode, base, vertices) : status;
}

/* ---- Nodes ---- */

/* Nodes that animations hide have the scale 0. */
bool is_shrunk(const matrix &m) {
    for (size_t column = 0; column < 3; column++)
        for (size_t row = 0; row < 3; row++)
            if (m[4 * column + row] != 0.0)
                return false;
    return true;
}

/* The pose has made sure that no node has itself below it. */
nsdf_status add_node(const reader &r, int index, size_t depth) {
    if (index < 0 || (size_t)index >= r.model.nodes.size() || depth > 256)
        return fail(r, "nodes that are not there, or in a circle");
    const tinygltf::Node &node = r.model.nodes[(size_t)index];
    nsdf_status status = NSDF_OK;
    const bool shown = node.skin >= 0 || !is_shrunk(r.stance.world[(size_t)index]);
    if (shown && node.mesh >= 0 && (size_t)node.mesh < r.model.meshes.size())
        for (const tinygltf::Primitive &p : r.model.meshes[(size_t)node.mesh].primitives)
            if (status == NSDF_OK)
                status = add_primitive(r, p, (size_t)index);
    for (int child : node.children)
        if (status == NSDF_OK)
            status = add_node(r, child, depth + 1);
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
            status = add_node(r, node, 0);
    return status == NSDF_OK ? nsdf_file_mesh_finish(r.mesh, r.name, r.error) : status;
}

nsdf_status read_scene(const char *name, const tinygltf::Model &model, const std::vector<track> &tracks, double seconds,
                       double slack, nsdf_file_mesh *mesh, nsdf_encoder_error *error) {
    pose stance;
    const std::string wrong = find_pose(model, tracks, seconds, slack, stance);
    if (!wrong.empty())
        return refuse(name, error, wrong);
    return add_scene({name, model, stance, mesh, error});
}

/* ---- Files ---- */

/* Textures are of no use here. */
bool skip_image(tinygltf::Image *, const int, std::string *, std::string *, int, int, const unsigned char *, int,
                void *) {
    return true;
}

/* Extensions that hide meshes from those who do not know them. */
nsdf_status check_extensions(const char *name, const tinygltf::Model &model, nsdf_encoder_error *error) {
    static const char *const unknown[] = {"KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                          "KHR_meshopt_compression", "EXT_mesh_gpu_instancing"};
    for (const std::string &required : model.extensionsRequired)
        for (const char *extension : unknown)
            if (required == extension)
                return nsdf_input_fail(error, NSDF_UNSUPPORTED_FEATURE, "%s: the extension %s is not supported",
                                       nsdf_show_path(name).text, extension);
    return NSDF_OK;
}

nsdf_status load(const char *name, const char *text, size_t size, tinygltf::Model &model, nsdf_encoder_error *error) {
    tinygltf::TinyGLTF loader;
    std::string why, warning;
    const std::string path(name), folder = path.substr(0, path.find_last_of('/') + 1);
    loader.SetImageLoader(skip_image, nullptr);
    if (size > UINT32_MAX)
        return nsdf_input_fail(error, NSDF_LIMIT, "%s: too large", nsdf_show_path(name).text);
    bool binary = false;
    const nsdf_status status = nsdf_gltf_check_container(name, text, size, &binary, error);
    if (status != NSDF_OK)
        return status;
    const bool read = binary ? loader.LoadBinaryFromMemory(&model, &why, &warning, (const unsigned char *)text,
                                                           (unsigned)size, folder)
                             : loader.LoadASCIIFromString(&model, &why, &warning, text, (unsigned)size, folder);
    if (!read)
        return nsdf_gltf_refuse(name, text, size, binary, why.empty() ? "not a glTF file" : why.c_str(), error);
    return check_extensions(name, model, error);
}

nsdf_status parse(const char *name, const char *text, size_t size, nsdf_file_mesh *mesh, nsdf_encoder_error *error) {
    tinygltf::Model model;
    const nsdf_status status = load(name, text, size, model, error);
    return status == NSDF_OK ? read_scene(name, model, {}, 0.0, 0.0, mesh, error) : status;
}

/* ---- Films ---- */

/* Whether the last key is where the last frame ends: nothing changes there. */
bool ends_held(const std::vector<track> &tracks, double last) {
    for (const track &t : tracks) {
        const size_t n = t.times.size();
        if (t.between != interpolation::step)
            return false;
        if (n > 1 && t.times[n - 1] >= last &&
            !std::equal(t.values.end() - (long)t.width, t.values.end(), t.values.end() - 2 * (long)t.width))
            return false;
    }
    return true;
}

void gather_keys(nsdf_gltf_film &film) {
    std::vector<double> &keys = film.keys;
    for (const track &t : film.tracks)
        keys.insert(keys.end(), t.times.begin(), t.times.end());
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end(), [](double a, double b) { return b - a < 1e-6; }), keys.end());
    film.first = keys.empty() ? 0.0 : keys.front();
    film.ends_held = !keys.empty() && ends_held(film.tracks, keys.back());
    film.in_steps = std::all_of(film.tracks.begin(), film.tracks.end(),
                                [](const track &t) { return t.between == interpolation::step; });
    for (double &key : keys)
        key -= film.first;
}

/* Takes the first animation in which something moves over some time; the film has no tracks when there is none. */
std::string take_animation(nsdf_gltf_film &film) {
    std::string left_out, name;
    size_t moving = 0;
    for (const tinygltf::Animation &animation : film.model.animations) {
        nsdf_gltf_film other;
        const std::string wrong = read_tracks(film.model, animation, other.tracks, left_out);
        if (!wrong.empty())
            return wrong;
        gather_keys(other);
        if (other.keys.size() < 2 || moving++ > 0)
            continue;
        film.tracks = std::move(other.tracks);
        name = animation.name;
    }
    if (moving > 1)
        film.note =
            "it has " + std::to_string(moving) + " animations; the first, '" + name.substr(0, 40) + "', is read";
    if (!left_out.empty())
        film.note +=
            (film.note.empty() ? "" : "; ") + ("the animation of '" + left_out.substr(0, 40)) + "' is left out";
    gather_keys(film);
    return "";
}

nsdf_status open_film(nsdf_gltf_film **film, const char *name, const char *text, size_t size,
                      nsdf_encoder_error *error) {
    nsdf_gltf_film own;
    own.name = name;
    const nsdf_status status = load(name, text, size, own.model, error);
    if (status != NSDF_OK)
        return status;
    const std::string wrong = take_animation(own);
    if (!wrong.empty())
        return refuse(name, error, wrong);
    *film = own.tracks.empty() ? nullptr : new nsdf_gltf_film(std::move(own));
    return NSDF_OK;
}

/* Calls `work`, which may throw, and gives its status. */
template <typename Work> nsdf_status guard(const char *name, nsdf_encoder_error *error, const Work &work) {
    try {
        return work();
    } catch (const std::bad_alloc &) {
        return nsdf_input_no_memory(error);
    } catch (const std::exception &) {
        return nsdf_input_fail(error, NSDF_CORRUPT, "%s: not a glTF file", nsdf_show_path(name).text);
    }
}

} // namespace

extern "C" nsdf_status nsdf_gltf_parse(const char *name, const char *text, size_t size, nsdf_file_mesh *mesh,
                                       nsdf_encoder_error *error) {
    nsdf_file_mesh_clear(mesh);
    const nsdf_status status = guard(name, error, [&] { return parse(name, text, size, mesh, error); });
    if (status != NSDF_OK)
        mesh->triangle_count = 0;
    return status;
}

extern "C" nsdf_status nsdf_gltf_film_open(nsdf_gltf_film **film, const char *name, const char *text, size_t size,
                                           nsdf_encoder_error *error) {
    return guard(name, error, [&] { return open_film(film, name, text, size, error); });
}

extern "C" void nsdf_gltf_film_free(nsdf_gltf_film *film) {
    delete film;
}

extern "C" nsdf_gltf_film_info nsdf_gltf_film_describe(const nsdf_gltf_film *film) {
    return {film->keys.data(), film->keys.size(), film->in_steps, film->ends_held, film->note.c_str()};
}

extern "C" nsdf_status nsdf_gltf_film_mesh(const nsdf_gltf_film *film, double seconds, double slack,
                                           nsdf_file_mesh *mesh, nsdf_encoder_error *error) {
    nsdf_file_mesh_clear(mesh);
    const char *name = film->name.c_str();
    const nsdf_status status = guard(name, error, [&] {
        return read_scene(name, film->model, film->tracks, film->first + seconds, slack, mesh, error);
    });
    if (status != NSDF_OK)
        mesh->triangle_count = 0;
    return status;
}

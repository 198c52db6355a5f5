#include "gltf_model.h"

#include <algorithm>
#include <cmath>

namespace nsdf_gltf {

/* ---- Reading ---- */

static bool find_path(const std::string &name, path &target) {
    static const char *const names[] = {"translation", "rotation", "scale", "weights"};
    for (int i = 0; i < 4; i++)
        if (name == names[i]) {
            target = (path)i;
            return true;
        }
    return false;
}

static bool find_interpolation(const std::string &name, interpolation &between) {
    between = name == "STEP"          ? interpolation::step
              : name == "CUBICSPLINE" ? interpolation::cubic
                                      : interpolation::linear;
    return between != interpolation::linear || name == "LINEAR" || name.empty();
}

/* Keys ascend, and all numbers are finite. */
static bool is_sane(const track &t) {
    for (size_t i = 0; i < t.times.size(); i++)
        if (!std::isfinite(t.times[i]) || (i > 0 && !(t.times[i] > t.times[i - 1])))
            return false;
    return std::all_of(t.values.begin(), t.values.end(), [](double x) { return std::isfinite(x); });
}

static bool read_track(const tinygltf::Model &model, const tinygltf::AnimationSampler &sampler, track &t) {
    const int type = t.target == path::weights    ? TINYGLTF_TYPE_SCALAR
                     : t.target == path::rotation ? TINYGLTF_TYPE_VEC4
                                                  : TINYGLTF_TYPE_VEC3;
    if (!find_interpolation(sampler.interpolation, t.between) ||
        !read_numbers(model, sampler.input, TINYGLTF_TYPE_SCALAR, any_count, t.times) || t.times.empty() ||
        !read_numbers(model, sampler.output, type, any_count, t.values))
        return false;
    const size_t keys = t.times.size() * (t.between == interpolation::cubic ? 3 : 1);
    t.width = t.values.size() / keys;
    const size_t wanted = type == TINYGLTF_TYPE_VEC4 ? 4 : type == TINYGLTF_TYPE_VEC3 ? 3 : t.width;
    return t.width == wanted && t.width > 0 && t.values.size() == t.width * keys && is_sane(t);
}

std::string read_tracks(const tinygltf::Model &model, const tinygltf::Animation &animation, std::vector<track> &tracks,
                        std::string &left_out) {
    for (const tinygltf::AnimationChannel &channel : animation.channels) {
        track t;
        if (!find_path(channel.target_path, t.target)) {
            left_out = channel.target_path;
            continue;
        }
        if (channel.target_node < 0)
            continue; /* of an extension */
        if ((size_t)channel.target_node >= model.nodes.size() || channel.sampler < 0 ||
            (size_t)channel.sampler >= animation.samplers.size())
            return "an animation of nodes that are not there";
        t.node = channel.target_node;
        if (!read_track(model, animation.samplers[(size_t)channel.sampler], t))
            return "an animation whose keys cannot be read";
        if (t.target != path::weights && !model.nodes[(size_t)t.node].matrix.empty())
            return "an animated node has a matrix";
        tracks.push_back(std::move(t));
    }
    return "";
}

/* ---- Values between keys ---- */

static void normalise(double *q) {
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 4 && length > 0.0; k++)
        q[k] /= length;
}

/* Along the shorter arc (glTF 2.0, appendix C.4). */
static void slerp(const double *a, const double *b, double u, double *out) {
    double dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    const double sign = dot < 0.0 ? -1.0 : 1.0, angle = std::acos(std::min(sign * dot, 1.0));
    const double sine = std::sin(angle);
    const double from = sine > 1e-6 ? std::sin((1.0 - u) * angle) / sine : 1.0 - u;
    const double to = sign * (sine > 1e-6 ? std::sin(u * angle) / sine : u);
    for (int k = 0; k < 4; k++)
        out[k] = from * a[k] + to * b[k];
    normalise(out);
}

/* Hermite spline of keys i and i + 1, `step` seconds apart (glTF 2.0, appendix C.5). */
static void spline(const track &t, size_t i, double u, double step, double *out) {
    const double *from = t.values.data() + 3 * t.width * i, *to = from + 3 * t.width;
    const double u2 = u * u, u3 = u2 * u;
    for (size_t k = 0; k < t.width; k++)
        out[k] = (2 * u3 - 3 * u2 + 1) * from[t.width + k] + step * (u3 - 2 * u2 + u) * from[2 * t.width + k] +
                 (3 * u2 - 2 * u3) * to[t.width + k] + step * (u3 - u2) * to[k];
}

void evaluate(const track &t, double seconds, double slack, std::vector<double> &value) {
    const auto after = std::upper_bound(t.times.begin(), t.times.end(), seconds + slack);
    const size_t keys = t.times.size(), next = (size_t)(after - t.times.begin());
    const size_t i = next > 0 ? next - 1 : 0, stride = t.between == interpolation::cubic ? 3 * t.width : t.width;
    const double *at = t.values.data() + stride * i + (t.between == interpolation::cubic ? t.width : 0);
    value.assign(at, at + t.width);
    if (next == 0 || next == keys || t.between == interpolation::step)
        return;
    const double step = t.times[next] - t.times[i];
    const double u = std::max(0.0, std::min(1.0, (seconds - t.times[i]) / step));
    if (t.between == interpolation::cubic)
        spline(t, i, u, step, value.data());
    else if (t.target == path::rotation)
        slerp(at, at + t.width, u, value.data());
    else
        for (size_t k = 0; k < t.width; k++)
            value[k] = (1.0 - u) * at[k] + u * at[t.width + k];
    if (t.target == path::rotation)
        normalise(value.data());
}

/* ---- Nodes ---- */

static const matrix identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

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
static matrix rotate(const std::vector<double> &q) {
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

/* What a node's own place is made of. */
struct placement {
    std::vector<double> matrix, translation, rotation, scale;
};

static matrix local_matrix(const placement &p) {
    matrix m = identity;
    if (p.matrix.size() == 16) {
        std::copy(p.matrix.begin(), p.matrix.end(), m.begin());
        return m;
    }
    if (p.rotation.size() == 4)
        m = rotate(p.rotation);
    for (size_t column = 0; column < 3 && p.scale.size() == 3; column++)
        for (size_t row = 0; row < 3; row++)
            m[4 * column + row] *= p.scale[column];
    for (size_t row = 0; row < 3 && p.translation.size() == 3; row++)
        m[12 + row] = p.translation[row];
    return m;
}

/* Above each node; false when they are not there, above more than one, or in a circle. */
static bool find_parents(const tinygltf::Model &model, std::vector<int> &parents) {
    parents.assign(model.nodes.size(), -1);
    for (size_t i = 0; i < model.nodes.size(); i++)
        for (int child : model.nodes[i].children) {
            if (child < 0 || (size_t)child >= model.nodes.size() || parents[(size_t)child] >= 0)
                return false;
            parents[(size_t)child] = (int)i;
        }
    return true;
}

/* Fills in the world matrix of a node and of those above it. */
static bool place_node(size_t node, const std::vector<int> &parents, const std::vector<placement> &places,
                       std::vector<char> &done, std::vector<matrix> &world) {
    std::vector<size_t> chain;
    for (int i = (int)node; i >= 0 && !done[(size_t)i]; i = parents[(size_t)i]) {
        if (chain.size() > parents.size())
            return false; /* a circle */
        chain.push_back((size_t)i);
    }
    for (size_t k = chain.size(); k-- > 0;) {
        const size_t i = chain[k];
        const matrix own = local_matrix(places[i]);
        world[i] = parents[i] >= 0 ? multiply(world[(size_t)parents[i]], own) : own;
        done[i] = 1;
    }
    return true;
}

static void set_weights(const tinygltf::Model &model, pose &p) {
    p.weights.resize(model.nodes.size());
    for (size_t i = 0; i < model.nodes.size(); i++) {
        const tinygltf::Node &node = model.nodes[i];
        if (!node.weights.empty())
            p.weights[i] = node.weights;
        else if (node.mesh >= 0 && (size_t)node.mesh < model.meshes.size())
            p.weights[i] = model.meshes[(size_t)node.mesh].weights;
    }
}

std::string find_pose(const tinygltf::Model &model, const std::vector<track> &tracks, double seconds, double slack,
                      pose &p) {
    const size_t count = model.nodes.size();
    std::vector<placement> places(count);
    std::vector<int> parents;
    std::vector<char> done(count, 0);
    for (size_t i = 0; i < count; i++)
        places[i] = {model.nodes[i].matrix, model.nodes[i].translation, model.nodes[i].rotation, model.nodes[i].scale};
    set_weights(model, p);
    for (const track &t : tracks) {
        placement &place = places[(size_t)t.node];
        evaluate(t, seconds, slack,
                 t.target == path::translation ? place.translation
                 : t.target == path::rotation  ? place.rotation
                 : t.target == path::scale     ? place.scale
                                               : p.weights[(size_t)t.node]);
    }
    p.world.assign(count, identity);
    bool sound = find_parents(model, parents);
    for (size_t i = 0; i < count && sound; i++)
        sound = place_node(i, parents, places, done, p.world);
    return sound ? "" : "nodes that are not there, or in a circle";
}

} // namespace nsdf_gltf

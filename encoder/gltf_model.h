/* glTF files while they are read, for the C++ of the library: numbers of accessors, and nodes as they stand at a time.
 */
#ifndef NSDF_GLTF_MODEL_H
#define NSDF_GLTF_MODEL_H

extern "C" {
#include "nsdf/encoder.h"
}

#include <array>
#include <string>
#include <tiny_gltf.h>
#include <vector>

namespace nsdf_gltf {

typedef std::array<double, 16> matrix; /* columns one after the other, as in glTF */

matrix multiply(const matrix &a, const matrix &b);

/* ---- Accessors ---- */

/* Elements of an accessor that is not sparse, whose bytes are checked to be there. */
struct elements {
    const unsigned char *data = nullptr;
    size_t count = 0, stride = 0;
    int component = 0;
};

bool find_elements(const tinygltf::Model &model, int accessor, int type, elements &e);
/* Element i of unsigned integers. */
uint32_t index_at(const elements &e, size_t i);

enum : size_t { any_count = SIZE_MAX };

/* All numbers of an accessor of this type: floats or integers, normalised where the file says so, sparse or not.  False
 * when it is not there, is of another type or number of elements than `count`, or its bytes are not there. */
bool read_numbers(const tinygltf::Model &model, int accessor, int type, size_t count, std::vector<double> &numbers);

/* ---- Animation ---- */

enum class path { translation, rotation, scale, weights };
enum class interpolation { step, linear, cubic };

/* What one channel of an animation does with one property of a node. */
struct track {
    int node = 0;
    path target = path::translation;
    interpolation between = interpolation::linear;
    size_t width = 0;           /* numbers of a value */
    std::vector<double> times;  /* seconds, ascending, at least one */
    std::vector<double> values; /* [times][width]; cubic: [times][3][width], in-tangent, value, out-tangent */
};

/* The channels of an animation that move nodes.  "" or what is wrong with it; `left_out` gets the paths that are not
 * known. */
std::string read_tracks(const tinygltf::Model &model, const tinygltf::Animation &animation, std::vector<track> &tracks,
                        std::string &left_out);

/* The value at a time; `slack` seconds before a key are its time already. */
void evaluate(const track &t, double seconds, double slack, std::vector<double> &value);

/* ---- Poses ---- */

/* Where nodes are, and the weights of their meshes' morph targets. */
struct pose {
    std::vector<matrix> world;                /* [node] */
    std::vector<std::vector<double>> weights; /* [node] */
};

/* The pose of the file as it stands, with the tracks at a time.  "" or what is wrong. */
std::string find_pose(const tinygltf::Model &model, const std::vector<track> &tracks, double seconds, double slack,
                      pose &p);

} // namespace nsdf_gltf

#endif

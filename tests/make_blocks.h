/* Small random block parts, and a slow evaluation of them in double written from the format's definition. */
#ifndef NSDF_TESTS_MAKE_BLOCKS_H
#define NSDF_TESTS_MAKE_BLOCKS_H

#include "blocks_write.h"
#include "make_file.h"

/* Blocks anywhere, on bones that move along lines or near them; or on a sphere, facing outward, with bones as in the
 * second: some 60 of them wind once around what is inside. */
enum { MAKE_SMOOTH, MAKE_ROUGH, MAKE_SHELL };

/* Which bone is the `i`-th of block k: no two of a block are alike as long as there are enough. */
static inline uint32_t make_bone(const nsdf_blocks_desc *desc, uint32_t k, uint32_t i) {
    return (k + i) % desc->bone_count;
}

/* Coefficients shrink with the degree; the first is below a tenth of the normalised unit. */
static inline double make_coefficient(uint32_t degree, uint64_t *random) {
    return 0.08 * make_uniform(random) / (1.0 + degree);
}

/* A knot of a pose: extent times a matrix near the unit one, and a position that moves steadily from knot to knot. */
static inline double make_pose(const float *anchor, uint32_t plane, uint32_t col, const double *slope, double noise) {
    const uint32_t row = col / 4;
    const double start = col % 4 == 3 ? (double)anchor[row] : col % 4 == row ? (double)anchor[3] : 0.0;
    return start + 0.02 * slope[col] * plane + noise;
}

static inline void make_poses(const nsdf_blocks_desc *desc, const float *anchors, int rough, uint64_t *random,
                              float *values) {
    const uint32_t planes = desc->list.tensors[NSDF_BLOCK_POSES].arrays[0].planes, bones = desc->bone_count;
    for (uint32_t b = 0; b < bones; b++) {
        double slope[12];
        for (int i = 0; i < 12; i++)
            slope[i] = make_uniform(random) * (i % 4 == 3 ? 1.0 : (double)anchors[4 * b + 3]);
        for (uint32_t p = 0; p < planes; p++)
            for (uint32_t i = 0; i < 12; i++)
                values[((size_t)p * bones + b) * 12 + i] =
                    (float)make_pose(anchors + (size_t)4 * b, p, i, slope,
                                     rough ? 0.02 * (double)anchors[4 * b + 3] * make_uniform(random) : 0.0);
    }
}

/* Lives reach the segment's ends, begin or end inside it, or both. */
static inline double make_life(uint32_t k, uint32_t col, uint64_t *random) {
    const double inside = 0.3 + 0.25 * make_uniform(random);
    if (col == 0)
        return k % 4 == 1 || k % 4 == 3 ? inside : 0.0;
    return k % 4 >= 2 ? 0.95 - inside : 1.0;
}

/* Directions spread over the sphere, along a spiral. */
static inline double make_direction(uint32_t k, uint32_t count, uint32_t axis) {
    const double z = 1.0 - (2.0 * k + 1.0) / count, turn = 2.399963 * k;
    return axis == 2 ? z : sqrt(1.0 - z * z) * (axis ? sin(turn) : cos(turn));
}

static inline double make_block_value(const nsdf_blocks_desc *desc, int shape, uint32_t tensor, uint32_t row,
                                      uint32_t col, uint64_t *random) {
    if (shape == MAKE_SHELL && tensor == NSDF_BLOCK_CENTRES)
        return 0.45 * make_direction(row, desc->block_count, col);
    if (shape == MAKE_SHELL && tensor == NSDF_BLOCK_COEFFICIENTS + 1)
        return 0.1 * make_direction(row, desc->block_count, col) + make_coefficient(3, random);
    switch (tensor) {
    case NSDF_BLOCK_CENTRES:
        return 0.3 * make_uniform(random);
    case NSDF_BLOCK_RADII:
        return 0.25 + 0.1 * make_uniform(random);
    case NSDF_BLOCK_LIVES:
        return make_life(row, col, random);
    case NSDF_BLOCK_BONES:
        return make_bone(desc, row, col);
    case NSDF_BLOCK_WEIGHTS:
        return (1.0 + 0.1 * make_uniform(random)) / desc->influences;
    case NSDF_BLOCK_ANCHORS:
        return col == 3 ? 0.4 + 0.2 * make_uniform(random) : 0.3 * make_uniform(random);
    default:
        return make_coefficient(tensor - NSDF_BLOCK_COEFFICIENTS, random);
    }
}

/* Quantises the array in values, which become what a decoder must see; an array without a step becomes raw. */
static inline void make_quantised(nsdf_array_desc *array, float step, int32_t *q, float *values) {
    const size_t count = (size_t)nsdf_array_size(array);
    array->quantiser = step > 0.0f ? NSDF_QUANT_UNIFORM : NSDF_QUANT_RAW;
    array->step = step;
    array->offset = 0.0f;
    memcpy(q, values, count * sizeof *q);
    if (!(step > 0.0f))
        return;
    const int failed = nsdf_quantise(values, count, step, 0.0f, q);
    assert(!failed);
    (void)failed;
    for (size_t i = 0; i < count; i++)
        values[i] = nsdf_dequantise(q[i], step, 0.0f);
}

/* Fills the tensors of a description whose counts, degree, fade and back end are set; poses have `knots` control
 * points, coefficients of degree 0 `level_knots`, or are constant with 0.  Arrays of tensor t are raw if bit t of `raw`
 * is set.  *q is for the writer, *values as a decoder sees them; both are to be freed. */
static inline void make_blocks(nsdf_blocks_desc *desc, uint32_t knots, uint32_t level_knots, int shape, uint32_t raw,
                               uint64_t *random, int32_t **q, float **values) {
    nsdf_blocks_layout(desc, knots, level_knots);
    const size_t count = (size_t)nsdf_parameter_count(&desc->list);
    *q = malloc(count * sizeof **q);
    *values = malloc(count * sizeof **values);
    assert(*q && *values);
    for (uint32_t t = 0; t < desc->list.count; t++) {
        nsdf_tensor_desc *tensor = &desc->list.tensors[t];
        const size_t at = nsdf_block_offset(desc, t);
        float *out = *values + at;
        if (t == NSDF_BLOCK_POSES)
            make_poses(desc, *values + nsdf_block_offset(desc, NSDF_BLOCK_ANCHORS), shape != MAKE_SMOOTH, random, out);
        else
            for (uint32_t i = 0; i < tensor->arrays[0].planes * tensor->rows * tensor->cols; i++)
                out[i] =
                    (float)make_block_value(desc, shape, t, i / tensor->cols % tensor->rows, i % tensor->cols, random);
        make_quantised(&tensor->arrays[0],
                       raw >> t & 1            ? 0.0f
                       : t == NSDF_BLOCK_BONES ? 1.0f
                                               : 1.0f / 1024.0f,
                       *q + at, out);
    }
}

/* ---- Evaluation from the definition --------------------------------------------------------------------- */

static inline double reference_block_value(const nsdf_blocks_desc *desc, const float *values, uint32_t tensor,
                                           uint32_t row, uint32_t col, double u) {
    const nsdf_tensor_desc *t = &desc->list.tensors[tensor];
    return reference_element(t, values + nsdf_block_offset(desc, tensor), (size_t)row * t->cols + col, u);
}

/* The block's coordinates of x by elimination with the largest pivot in A u r = x - c; the rows of `m` are [A | x - c].
 * No file made here has a block without an inverse. */
static inline void reference_solve(double m[3][4]) {
    for (int i = 0; i < 3; i++) {
        int pivot = i;
        for (int r = i + 1; r < 3; r++)
            pivot = fabs(m[r][i]) > fabs(m[pivot][i]) ? r : pivot;
        for (int k = 0; k < 4; k++) {
            const double other = m[pivot][k];
            m[pivot][k] = m[i][k];
            m[i][k] = other;
        }
        for (int r = 0; r < 3; r++) {
            const double factor = r == i ? 0.0 : m[r][i] / m[i][i];
            for (int k = 0; k < 4; k++)
                m[r][k] -= factor * m[i][k];
        }
    }
}

/* [A | c] of a block. */
static inline void reference_motion(const nsdf_blocks_desc *desc, const float *values, uint32_t block, double u,
                                    double m[3][4]) {
    memset(m, 0, 12 * sizeof m[0][0]);
    for (uint32_t i = 0; i < desc->influences; i++) {
        const double weight = reference_block_value(desc, values, NSDF_BLOCK_WEIGHTS, block, i, u);
        const uint32_t bone = (uint32_t)reference_block_value(desc, values, NSDF_BLOCK_BONES, block, i, u);
        const double extent = reference_block_value(desc, values, NSDF_BLOCK_ANCHORS, bone, 3, u);
        for (uint32_t row = 0; row < 3; row++) {
            double moved = reference_block_value(desc, values, NSDF_BLOCK_POSES, bone, 4 * row + 3, u);
            for (uint32_t k = 0; k < 3; k++) {
                const double turn =
                    reference_block_value(desc, values, NSDF_BLOCK_POSES, bone, 4 * row + k, u) / extent;
                m[row][k] += weight * turn;
                moved += turn * (reference_block_value(desc, values, NSDF_BLOCK_CENTRES, block, k, u) -
                                 reference_block_value(desc, values, NSDF_BLOCK_ANCHORS, bone, k, u));
            }
            m[row][3] += weight * moved;
        }
    }
}

static inline void reference_to_block(const nsdf_blocks_desc *desc, const float *values, uint32_t block, double u,
                                      const double xyz[3], double local[3]) {
    double m[3][4];
    reference_motion(desc, values, block, u, m);
    for (int row = 0; row < 3; row++)
        m[row][3] = xyz[row] - m[row][3];
    reference_solve(m);
    for (int row = 0; row < 3; row++)
        local[row] = m[row][3] / m[row][row] / reference_block_value(desc, values, NSDF_BLOCK_RADII, block, 0, u);
}

static inline double reference_power(uint32_t degree, double t) {
    static const double lower[4] = {0.0, 0.0, 1.0 / 9.0, 3.0 / 11.0};
    return pow(t, degree) - (degree >= 2 ? lower[degree] * pow(t, degree - 2.0) : 0.0);
}

static inline double reference_polynomial(const nsdf_blocks_desc *desc, const float *values, uint32_t block, double u,
                                          const double p[3]) {
    double sum = 0.0;
    for (uint32_t d = 0; d <= desc->degree; d++) {
        uint32_t col = 0;
        for (uint32_t a = d + 1; a-- > 0;)
            for (uint32_t b = d - a + 1; b-- > 0;)
                sum += reference_block_value(desc, values, NSDF_BLOCK_COEFFICIENTS + d, block, col++, u) *
                       reference_power(a, p[0]) * reference_power(b, p[1]) * reference_power(d - a - b, p[2]);
    }
    return sum;
}

static inline double reference_life(const nsdf_blocks_desc *desc, const float *values, uint32_t block, double u) {
    const double from = reference_block_value(desc, values, NSDF_BLOCK_LIVES, block, 0, u);
    const double to = reference_block_value(desc, values, NSDF_BLOCK_LIVES, block, 1, u), fade = (double)desc->fade;
    double life = u >= from && u <= to ? 1.0 : 0.0;
    if (fade > 0.0 && life > 0.0 && from > 0.0)
        life = fmin(life, (u - from) / fade);
    if (fade > 0.0 && life > 0.0 && to < 1.0)
        life = fmin(life, (to - u) / fade);
    return life;
}

/* The slope of a polynomial at 0, by differences that are exact for cubic ones. */
static inline void reference_slope(const nsdf_blocks_desc *desc, const float *values, uint32_t block, double u,
                                   double g[3]) {
    for (int axis = 0; axis < 3; axis++) {
        double at[4]; /* -2h, -h, h, 2h */
        for (int i = 0; i < 4; i++) {
            double p[3] = {0.0, 0.0, 0.0};
            p[axis] = (i < 2 ? i - 2 : i - 1) * 0.25;
            at[i] = reference_polynomial(desc, values, block, u, p);
        }
        g[axis] = (8.0 * (at[2] - at[1]) - (at[3] - at[0])) / (12.0 * 0.25);
    }
}

/* The block's part in the winding number: its area vector at rest, r^2 g / (20 |g|), moved by the cofactors of A, which
 * are the cross products of its columns. */
static inline double reference_wind(const nsdf_blocks_desc *desc, const float *values, uint32_t block, double u,
                                    const double m[3][4], const double xyz[3]) {
    const double radius = reference_block_value(desc, values, NSDF_BLOCK_RADII, block, 0, u);
    double g[3], sum = 0.0, square = 1e-12;
    reference_slope(desc, values, block, u, g);
    const double length = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
    for (int i = 0; i < 3; i++) {
        const int p = (i + 1) % 3, q = (i + 2) % 3;
        double area = 0.0;
        for (int k = 0; k < 3; k++)
            area += (m[p][(k + 1) % 3] * m[q][(k + 2) % 3] - m[p][(k + 2) % 3] * m[q][(k + 1) % 3]) * g[k];
        sum += area * (m[i][3] - xyz[i]);
        square += (m[i][3] - xyz[i]) * (m[i][3] - xyz[i]);
    }
    return length > 0.0 ? reference_life(desc, values, block, u) * radius * radius * sum /
                              (20.0 * length * square * sqrt(square))
                        : 0.0;
}

static inline double reference_outside(const nsdf_blocks_desc *desc, const float *values, double u,
                                       const double xyz[3]) {
    double nearest = 64.0, size = 64.0, wound = 0.0;
    for (uint32_t k = 0; k < desc->block_count; k++) {
        const double radius = reference_block_value(desc, values, NSDF_BLOCK_RADII, k, 0, u);
        double m[3][4];
        if (!(reference_life(desc, values, k, u) > 0.0))
            continue;
        reference_motion(desc, values, k, u, m);
        const double d = hypot(hypot(m[0][3] - xyz[0], m[1][3] - xyz[1]), m[2][3] - xyz[2]);
        size = d < nearest ? fmax(d - 0.5 * radius, 0.25 * radius) : size;
        nearest = fmin(nearest, d);
        wound += reference_wind(desc, values, k, u, (const double(*)[4])m, xyz);
    }
    return wound > 0.5 ? -size : size;
}

/* As reference_value, for a block part. */
static inline double reference_blocks(const nsdf_blocks_desc *desc, const float *values, double u,
                                      const double xyz[3]) {
    double total = 0.0, weights = 0.0;
    for (uint32_t k = 0; k < desc->block_count; k++) {
        const double life = reference_life(desc, values, k, u);
        double p[3];
        if (!(life > 0.0))
            continue;
        reference_to_block(desc, values, k, u, xyz, p);
        const double square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
        const double weight = square < 1.0 ? life * (1.0 - square) * (1.0 - square) : 0.0;
        if (weight > 0.0)
            total += weight * reference_polynomial(desc, values, k, u, p);
        weights += weight;
    }
    return weights > 0.0 ? total / weights : reference_outside(desc, values, u, xyz);
}

#endif

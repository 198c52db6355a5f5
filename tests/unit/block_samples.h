/* Small random block parts, and a slow evaluation of them in double written from the format's definition. */
#ifndef BLOCK_SAMPLES_H
#define BLOCK_SAMPLES_H

#include "blocks_write.h"
#include "make_file.h"

typedef struct sample_shape {
    uint32_t blocks, bones, influences, degree, knots;
} sample_shape;

typedef struct sample_blocks {
    nsdf_blocks_desc desc;
    float *values;
} sample_blocks;

static inline float *sample_tensor_values(const sample_blocks *s, uint32_t tensor) {
    return s->values + nsdf_block_offset(&s->desc, tensor);
}

static inline float sample_between(uint64_t *random, double low, double high) {
    return (float)(low + (high - low) * 0.5 * (make_uniform(random) + 1.0));
}

/* All values 0, quantised with steps of 2^-10, bones with steps of 1. */
static inline sample_blocks sample_empty(sample_shape shape) {
    sample_blocks s;
    memset(&s, 0, sizeof s);
    s.desc.block_count = shape.blocks;
    s.desc.bone_count = shape.bones;
    s.desc.influences = shape.influences;
    s.desc.degree = shape.degree;
    s.desc.list.entropy = NSDF_ENTROPY_RANGE;
    nsdf_blocks_layout(&s.desc, shape.knots, 0);
    for (uint32_t t = 0; t < s.desc.list.count; t++) {
        nsdf_array_desc *a = &s.desc.list.tensors[t].arrays[0];
        a->quantiser = NSDF_QUANT_UNIFORM;
        a->step = t == NSDF_BLOCK_BONES ? 1.0f : 0x1p-10f;
    }
    s.values = calloc((size_t)nsdf_parameter_count(&s.desc.list), sizeof *s.values);
    assert(s.values);
    return s;
}

static inline void sample_free(sample_blocks *s) {
    free(s->values);
    memset(s, 0, sizeof *s);
}

/* Every block whole from beginning to end, on bone 0 alone, which does not move. */
static inline sample_blocks sample_resting(sample_shape shape, float radius) {
    sample_blocks s = sample_empty(shape);
    const uint32_t planes = s.desc.list.tensors[NSDF_BLOCK_POSES].arrays[0].planes;
    for (size_t k = 0; k < shape.blocks; k++) {
        sample_tensor_values(&s, NSDF_BLOCK_RADII)[k] = radius;
        sample_tensor_values(&s, NSDF_BLOCK_LIVES)[2 * k + 1] = 1.0f;
        sample_tensor_values(&s, NSDF_BLOCK_WEIGHTS)[shape.influences * k] = 1.0f;
    }
    for (size_t b = 0; b < shape.bones; b++)
        sample_tensor_values(&s, NSDF_BLOCK_ANCHORS)[4 * b + 3] = 0.5f;
    for (size_t i = 0; i < (size_t)planes * shape.bones; i++)
        for (size_t axis = 0; axis < 3; axis++)
            sample_tensor_values(&s, NSDF_BLOCK_POSES)[12 * i + 5 * axis] = 0.5f;
    return s;
}

/* Radius of a sphere of blocks. */
static const double sample_shell_radius = 0.25;

/* Directions spread over the sphere, along a spiral. */
static inline void sample_direction(size_t k, size_t count, double n[3]) {
    const double turn = 2.399963 * (double)k;
    n[2] = 1.0 - (2.0 * (double)k + 1.0) / (double)count;
    n[0] = sqrt(1.0 - n[2] * n[2]) * cos(turn);
    n[1] = sqrt(1.0 - n[2] * n[2]) * sin(turn);
}

/* Resting blocks on a sphere, each with the distance to its plane there, of the radius with which the areas that they
 * stand for make up the sphere's. */
static inline sample_blocks sample_shell(uint32_t blocks) {
    const float radius = (float)(sample_shell_radius * sqrt(20.0 / blocks));
    sample_blocks s = sample_resting((sample_shape){blocks, 1, 1, 1, 0}, radius);
    for (size_t k = 0; k < blocks; k++) {
        double n[3];
        sample_direction(k, blocks, n);
        for (size_t axis = 0; axis < 3; axis++) {
            sample_tensor_values(&s, NSDF_BLOCK_CENTRES)[3 * k + axis] = (float)(sample_shell_radius * n[axis]);
            sample_tensor_values(&s, NSDF_BLOCK_COEFFICIENTS + 1)[3 * k + axis] = radius * (float)n[axis];
        }
    }
    return s;
}

static inline void sample_random_blocks(const sample_blocks *s, uint64_t *random) {
    const uint32_t n = s->desc.influences;
    for (size_t k = 0; k < s->desc.block_count; k++) {
        float *life = sample_tensor_values(s, NSDF_BLOCK_LIVES) + 2 * k;
        float *weight = sample_tensor_values(s, NSDF_BLOCK_WEIGHTS) + n * k;
        float *bone = sample_tensor_values(s, NSDF_BLOCK_BONES) + n * k;
        sample_tensor_values(s, NSDF_BLOCK_RADII)[k] = sample_between(random, 0.05, 0.15);
        life[0] = k % 3 ? 0.0f : sample_between(random, 0.0, 0.4);
        life[1] = k % 4 ? 1.0f : sample_between(random, 0.6, 1.0);
        for (int axis = 0; axis < 3; axis++)
            sample_tensor_values(s, NSDF_BLOCK_CENTRES)[3 * k + (size_t)axis] = sample_between(random, -0.3, 0.3);
        for (uint32_t i = 0; i < n; i++) {
            bone[i] = (float)(make_random(random) % s->desc.bone_count);
            weight[i] = sample_between(random, 0.5, 1.5) / (float)n;
        }
    }
}

/* Random values; the bones turn, stretch and shear a little. */
static inline sample_blocks sample_random(sample_shape shape, uint64_t seed) {
    sample_blocks s = sample_empty(shape);
    uint64_t random = seed;
    const uint32_t planes = s.desc.list.tensors[NSDF_BLOCK_POSES].arrays[0].planes;
    s.desc.fade = 0.1f;
    sample_random_blocks(&s, &random);
    for (size_t b = 0; b < shape.bones; b++) {
        float *anchor = sample_tensor_values(&s, NSDF_BLOCK_ANCHORS) + 4 * b;
        anchor[3] = sample_between(&random, 0.05, 0.3);
        for (int axis = 0; axis < 3; axis++)
            anchor[axis] = sample_between(&random, -0.2, 0.2);
        for (size_t plane = 0; plane < planes; plane++)
            for (size_t n = 0; n < 12; n++)
                sample_tensor_values(&s, NSDF_BLOCK_POSES)[12 * (plane * shape.bones + b) + n] =
                    n % 4 == 3 ? anchor[n / 4] + sample_between(&random, -0.05, 0.05)
                               : anchor[3] * ((n % 5 == 0 ? 1.0f : 0.0f) + sample_between(&random, -0.2, 0.2));
    }
    const size_t first = nsdf_block_offset(&s.desc, NSDF_BLOCK_COEFFICIENTS);
    for (size_t i = first; i < (size_t)nsdf_parameter_count(&s.desc.list); i++)
        s.values[i] = sample_between(&random, -0.1, 0.1);
    return s;
}

/* Quantised values for the writer; s->values become what a decoder must see. */
static inline int32_t *sample_quantised(const sample_blocks *s) {
    int32_t *q = malloc((size_t)nsdf_parameter_count(&s->desc.list) * sizeof *q);
    assert(q);
    for (uint32_t t = 0; t < s->desc.list.count; t++) {
        const nsdf_array_desc *a = &s->desc.list.tensors[t].arrays[0];
        const size_t at = nsdf_block_offset(&s->desc, t), count = (size_t)nsdf_array_size(a);
        if (a->quantiser == NSDF_QUANT_RAW) {
            memcpy(q + at, s->values + at, count * sizeof *q);
            continue;
        }
        const int failed = nsdf_quantise(s->values + at, count, a->step, a->offset, q + at);
        assert(!failed);
        (void)failed;
        for (size_t i = at; i < at + count; i++)
            s->values[i] = nsdf_dequantise(q[i], a->step, a->offset);
    }
    return q;
}

/* ---- Evaluation from the definition --------------------------------------------------------------------- */

/* A block at a point: |u|, the polynomial, the centre's distance, |f| from it, and the part in the winding number; life
 * is 0 where it is not there. */
typedef struct reference_block {
    double life, length, value, distance, size, wound;
} reference_block;

static inline double reference_legendre(uint32_t degree, double t) {
    return degree == 0 ? 1.0 : degree == 1 ? t : degree == 2 ? t * t - 1.0 / 9.0 : t * t * t - 3.0 / 11.0 * t;
}

static inline double reference_polynomial(const sample_blocks *s, size_t block, const double u[3]) {
    double sum = 0.0;
    for (uint32_t d = 0; d <= s->desc.degree; d++) {
        const float *c = sample_tensor_values(s, NSDF_BLOCK_COEFFICIENTS + d) + block * ((d + 1) * (d + 2) / 2);
        for (int a = (int)d; a >= 0; a--)
            for (int b = (int)d - a; b >= 0; b--)
                sum += (double)*c++ * reference_legendre((uint32_t)a, u[0]) * reference_legendre((uint32_t)b, u[1]) *
                       reference_legendre((uint32_t)((int)d - a - b), u[2]);
    }
    return sum;
}

static inline double reference_life(const sample_blocks *s, size_t block, double u) {
    const float *life = sample_tensor_values(s, NSDF_BLOCK_LIVES) + 2 * block;
    const double from = (double)life[0], to = (double)life[1], fade = (double)s->desc.fade;
    if (u < from || u > to)
        return 0.0;
    const double in = from <= 0.0 || fade == 0.0 ? 1.0 : (u - from) / fade;
    const double out = to >= 1.0 || fade == 0.0 ? 1.0 : (to - u) / fade;
    return fmin(1.0, fmin(in, out));
}

/* A and c of a block, [3][4]. */
static inline void reference_pose(const sample_blocks *s, size_t block, double u, double pose[12]) {
    const nsdf_tensor_desc *poses = &s->desc.list.tensors[NSDF_BLOCK_POSES];
    memset(pose, 0, 12 * sizeof *pose);
    for (size_t i = 0; i < s->desc.influences; i++) {
        const size_t at = block * s->desc.influences + i;
        const size_t bone = (size_t)sample_tensor_values(s, NSDF_BLOCK_BONES)[at];
        const double weight = (double)sample_tensor_values(s, NSDF_BLOCK_WEIGHTS)[at];
        const float *anchor = sample_tensor_values(s, NSDF_BLOCK_ANCHORS) + 4 * bone;
        for (size_t n = 0; n < 12; n++) {
            const double e = reference_element(poses, sample_tensor_values(s, NSDF_BLOCK_POSES), 12 * bone + n, u);
            const double m = n % 4 == 3 ? e : e / (double)anchor[3];
            const size_t row = n / 4 * 4;
            pose[n] += weight * m;
            if (n % 4 != 3)
                pose[row + 3] +=
                    weight * m *
                    ((double)sample_tensor_values(s, NSDF_BLOCK_CENTRES)[3 * block + n % 4] - (double)anchor[n % 4]);
        }
    }
}

static inline double reference_determinant(const double a[3], const double b[3], const double c[3]) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* Cramer's rule on the columns of A. */
static inline int reference_coordinates(const double p[12], double radius, const double x[3], double u[3]) {
    double column[4][3];
    for (int row = 0; row < 3; row++) {
        for (int k = 0; k < 3; k++)
            column[k][row] = p[4 * row + k];
        column[3][row] = x[row] - p[4 * row + 3];
    }
    const double whole = reference_determinant(column[0], column[1], column[2]) * radius;
    u[0] = reference_determinant(column[3], column[1], column[2]) / whole;
    u[1] = reference_determinant(column[0], column[3], column[2]) / whole;
    u[2] = reference_determinant(column[0], column[1], column[3]) / whole;
    return whole != 0.0;
}

/* The linear coefficients of the polynomial: those of P_1, and what P_2 and P_3 add, term by term. */
static inline void reference_slope(const sample_blocks *s, size_t block, double g[3]) {
    const uint32_t degree = s->desc.degree;
    const float *linear = sample_tensor_values(s, NSDF_BLOCK_COEFFICIENTS + 1) + 3 * block;
    for (int axis = 0; axis < 3; axis++)
        g[axis] = degree >= 1 ? (double)linear[axis] : 0.0;
    if (degree < 3)
        return;
    /* xxx xxy xxz xyy xyz xzz yyy yyz yzz zzz */
    const float *c = sample_tensor_values(s, NSDF_BLOCK_COEFFICIENTS + 3) + 10 * block;
    g[0] -= 3.0 / 11.0 * (double)c[0] + ((double)c[3] + (double)c[5]) / 9.0;
    g[1] -= 3.0 / 11.0 * (double)c[6] + ((double)c[1] + (double)c[8]) / 9.0;
    g[2] -= 3.0 / 11.0 * (double)c[9] + ((double)c[2] + (double)c[7]) / 9.0;
}

/* det(A) A^-T g . away is the determinant of A's columns with one of them replaced by `away`, summed over them with the
 * weights g. */
static inline double reference_wind(const sample_blocks *s, size_t block, const double p[12], double radius,
                                    const double away[3]) {
    double g[3], sum = 0.0;
    reference_slope(s, block, g);
    const double length = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
    const double square = away[0] * away[0] + away[1] * away[1] + away[2] * away[2] + 1e-12;
    for (int k = 0; k < 3; k++) {
        double column[3][3];
        for (int n = 0; n < 9; n++)
            column[n / 3][n % 3] = n / 3 == k ? away[n % 3] : p[4 * (n % 3) + n / 3];
        sum += g[k] * reference_determinant(column[0], column[1], column[2]);
    }
    return length > 0.0 ? radius * radius * sum / (20.0 * length * pow(square, 1.5)) : 0.0;
}

static inline reference_block reference_look(const sample_blocks *s, size_t block, double t, const double x[3]) {
    reference_block r = {reference_life(s, block, t), 0.0, 0.0, 0.0, 0.0, 0.0};
    const double radius = (double)sample_tensor_values(s, NSDF_BLOCK_RADII)[block];
    double pose[12], u[3];
    reference_pose(s, block, t, pose);
    if (!(r.life > 0.0) || !reference_coordinates(pose, radius, x, u)) {
        r.life = 0.0;
        return r;
    }
    const double away[3] = {pose[3] - x[0], pose[7] - x[1], pose[11] - x[2]};
    r.length = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    r.value = reference_polynomial(s, block, u);
    r.distance = sqrt(away[0] * away[0] + away[1] * away[1] + away[2] * away[2]);
    r.size = fmax(r.distance - radius / 2.0, radius / 4.0);
    r.wound = r.life * reference_wind(s, block, pose, radius, away);
    return r;
}

/* The part's value.  *delicate tells that rounding or a small step may lead to another case of the definition; *inside
 * that the point is in a ball. */
static inline double reference_blocks(const sample_blocks *s, double t, const double x[3], int *delicate, int *inside) {
    double weight = 0.0, sum = 0.0, least = 64.0, second = 64.0, size = 64.0, wound = 0.0;
    int bent = 0;
    *delicate = 0;
    for (size_t k = 0; k < s->desc.block_count; k++) {
        const reference_block r = reference_look(s, k, t, x);
        if (!(r.life > 0.0))
            continue;
        *delicate |= fabs(r.length - 1.0) < 1e-3;
        if (r.length < 1.0) {
            const double root = 1.0 - r.length * r.length;
            weight += r.life * root * root;
            sum += r.life * root * root * r.value;
        }
        const double radius = (double)sample_tensor_values(s, NSDF_BLOCK_RADII)[k];
        bent = r.distance < least ? fabs(r.distance - 0.75 * radius) < 1e-4 : bent;
        size = r.distance < least ? r.size : size;
        second = fmin(second, fmax(least, r.distance));
        least = fmin(least, r.distance);
        wound += r.wound;
    }
    *inside = weight > 0.0;
    *delicate |= *inside ? weight < 1e-4 : (least < 64.0 && second - least < 1e-4) || bent || fabs(wound - 0.5) < 1e-3;
    if (*inside)
        return sum / weight;
    return wound > 0.5 ? -size : size;
}

#endif

#include "block_model.h"

#include "dense_solve.h"
#include "spline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Steps of what does not need to be fine, since all else is fitted around it. */
static const float rest_step = 1.0f / 512, weight_step = 1.0f / 32, anchor_step = 1.0f / 256;
static const float radius_step = 1.0f / 16; /* of the radius at first */
static const double least_extent = 0.02;    /* of a bone, normalised */
static const double smoothness = 1e-3;      /* of second differences of control points in the first fit */

/* ---- Shape ----------------------------------------------------------------------------------------------- */

static uint32_t knot_count(double spacing, uint32_t frames) {
    double spans = ceil(((double)frames - 1.0) / (spacing > 0.25 ? spacing : 0.25));
    double most = NSDF_MAX_KNOTS - 3;
    return frames < 2 ? 0 : 3 + (uint32_t)(spans < 1.0 ? 1.0 : spans > most ? most : spans);
}

static void set_quantiser(nsdf_blocks_desc *d, uint32_t tensor, double step) {
    nsdf_array_desc *a = &d->list.tensors[tensor].arrays[0];
    a->quantiser = NSDF_QUANT_UNIFORM;
    a->step = (float)step;
    a->offset = 0.0f;
}

void nsdf_block_model_set_steps(nsdf_block_model *model, const nsdf_block_steps *steps) {
    set_quantiser(&model->desc, NSDF_BLOCK_POSES, steps->pose);
    for (uint32_t n = 0; n <= model->desc.degree; n++)
        set_quantiser(&model->desc, NSDF_BLOCK_COEFFICIENTS + n, steps->coefficient);
}

/* Blocks come and go from one frame to the next. */
static double largest_gap(const double *u, uint32_t frames) {
    double gap = 0.0;
    for (uint32_t f = 1; f < frames; f++)
        gap = fmax(gap, u[f] - u[f - 1]);
    return gap;
}

/* Of the time between a frame where a block is there and the next one, where it is not.  Right at that frame the times
 * as readers have them could leave a trace of the block, which is the whole field where no other ball is. */
static const double life_margin = 0.25;

void nsdf_block_life(const double *u, uint32_t frames, uint32_t first, uint32_t last, float life[2]) {
    life[0] = first == 0 ? 0.0f : (float)(u[first - 1] + life_margin * (u[first] - u[first - 1]));
    life[1] = last + 1 >= frames ? 1.0f : (float)(u[last + 1] - life_margin * (u[last + 1] - u[last]));
}

/* So that lives are not moved where frames are evenly spaced; a little more, so that the last end is not below 1. */
static double life_step(const double *u, uint32_t frames) {
    double gap = 1.0;
    for (uint32_t f = 1; f < frames; f++)
        gap = fmin(gap, u[f] - u[f - 1]);
    return life_margin * gap * (1.0 + 1e-6);
}

static void describe(nsdf_block_model *m, const nsdf_motion *motion, const nsdf_bones *bones, const double *u,
                     uint32_t degree, double knot_spacing, double level_spacing, const nsdf_block_steps *steps) {
    nsdf_blocks_desc *d = &m->desc;
    d->block_count = motion->block_count;
    d->bone_count = bones->bone_count;
    d->influences = NSDF_BONE_INFLUENCES;
    m->radius = motion->radius;
    d->degree = degree;
    d->list.entropy = NSDF_ENTROPY_RANGE;
    m->knots = knot_count(knot_spacing, motion->frame_count);
    m->level_knots = level_spacing > 0.0 && degree > 0 ? knot_count(level_spacing, motion->frame_count) : 0;
    nsdf_blocks_layout(d, m->knots, m->level_knots);
    set_quantiser(d, NSDF_BLOCK_CENTRES, (double)rest_step);
    set_quantiser(d, NSDF_BLOCK_RADII, (double)(radius_step * motion->radius));
    d->fade = (float)((1.0 - life_margin) * largest_gap(u, motion->frame_count));
    set_quantiser(d, NSDF_BLOCK_LIVES, life_step(u, motion->frame_count));
    set_quantiser(d, NSDF_BLOCK_BONES, 1.0);
    set_quantiser(d, NSDF_BLOCK_WEIGHTS, (double)weight_step);
    set_quantiser(d, NSDF_BLOCK_ANCHORS, (double)anchor_step);
    nsdf_block_model_set_steps(m, steps);
    m->value_count = (size_t)nsdf_parameter_count(&d->list);
    m->pose_offset = nsdf_block_offset(d, NSDF_BLOCK_POSES);
    m->pose_count = (size_t)nsdf_array_size(&d->list.tensors[NSDF_BLOCK_POSES].arrays[0]);
    m->level_offset = nsdf_block_offset(d, NSDF_BLOCK_COEFFICIENTS);
    m->level_count = (size_t)m->level_knots * d->block_count;
    m->term_offset = m->level_offset + m->level_count;
    m->term_count = m->value_count - m->term_offset;
    m->terms = 0;
    for (uint32_t n = 0; n <= degree; n++)
        m->terms += nsdf_degree_terms(n);
}

static float rounded(float x, const nsdf_array_desc *a) {
    return nsdf_dequantise((int32_t)lrint((double)(x - a->offset) / (double)a->step), a->step, a->offset);
}

void nsdf_block_model_round(const nsdf_block_model *model, const float *values, float *out) {
    const nsdf_tensor_list *list = &model->desc.list;
    memcpy(out, values, model->value_count * sizeof *out);
    for (uint32_t t = NSDF_BLOCK_POSES; t < list->count; t++) {
        const nsdf_array_desc *a = &list->tensors[t].arrays[0];
        const size_t at = nsdf_block_offset(&model->desc, t), count = (size_t)nsdf_array_size(a);
        const double inverse = 1.0 / (double)a->step;
        for (size_t i = at; i < at + count; i++)
            out[i] = (float)(0.0 + (double)a->step * rint((double)values[i] * inverse)); /* no -0: as readers have it */
    }
}

/* ---- Values at rest -------------------------------------------------------------------------------------- */

static float *tensor_values(const nsdf_block_model *m, uint32_t tensor) {
    return m->values + nsdf_block_offset(&m->desc, tensor);
}

static void round_tensor(const nsdf_block_model *m, uint32_t tensor) {
    const nsdf_array_desc *a = &m->desc.list.tensors[tensor].arrays[0];
    float *v = tensor_values(m, tensor);
    for (size_t i = 0; i < (size_t)nsdf_array_size(a); i++)
        v[i] = rounded(v[i], a);
}

void nsdf_block_model_round_lives(nsdf_block_model *model) {
    round_tensor(model, NSDF_BLOCK_LIVES);
}

/* To steps, the largest making up the sum: a block whose weights do not sum to 1 is drawn to the origin or from it. */
static void round_weights(const nsdf_block_model *m) {
    float *weight = tensor_values(m, NSDF_BLOCK_WEIGHTS);
    round_tensor(m, NSDF_BLOCK_WEIGHTS);
    for (size_t k = 0; k < m->desc.block_count; k++, weight += NSDF_BONE_INFLUENCES) {
        float missing = 1.0f;
        size_t largest = 0;
        for (size_t i = 0; i < NSDF_BONE_INFLUENCES; i++) {
            missing -= weight[i];
            largest = weight[i] > weight[largest] ? i : largest;
        }
        weight[largest] += missing;
    }
}

static void fill_rest(nsdf_block_model *m, const nsdf_motion *motion, const nsdf_bones *bones, const double *u) {
    float *centre = tensor_values(m, NSDF_BLOCK_CENTRES), *radius = tensor_values(m, NSDF_BLOCK_RADII);
    float *life = tensor_values(m, NSDF_BLOCK_LIVES), *bone = tensor_values(m, NSDF_BLOCK_BONES);
    float *weight = tensor_values(m, NSDF_BLOCK_WEIGHTS);
    for (uint32_t k = 0; k < m->desc.block_count; k++) {
        memcpy(centre + 3 * (size_t)k, motion->centres[k], 3 * sizeof *centre);
        radius[k] = motion->radius;
        const uint32_t *lives = motion->lives[k];
        nsdf_block_life(u, motion->frame_count, lives[0], lives[1], life + 2 * (size_t)k);
        for (size_t i = 0; i < NSDF_BONE_INFLUENCES; i++) {
            bone[NSDF_BONE_INFLUENCES * (size_t)k + i] = (float)bones->bone[k][i];
            weight[NSDF_BONE_INFLUENCES * (size_t)k + i] = (float)bones->weight[k][i];
        }
    }
    round_tensor(m, NSDF_BLOCK_CENTRES);
    round_tensor(m, NSDF_BLOCK_RADII);
    round_tensor(m, NSDF_BLOCK_LIVES);
    round_weights(m);
}

void nsdf_block_model_set_influences(nsdf_block_model *m) {
    const nsdf_blocks_desc *d = &m->desc;
    const float *centres = tensor_values(m, NSDF_BLOCK_CENTRES), *anchors = tensor_values(m, NSDF_BLOCK_ANCHORS);
    const float *weights = tensor_values(m, NSDF_BLOCK_WEIGHTS);
    for (size_t at = 0; at < (size_t)d->block_count * d->influences; at++) {
        nsdf_block_influence *f = &m->influences[at];
        f->weight = weights[at];
        const float *anchor = anchors + 4 * (size_t)f->bone, *centre = centres + 3 * (at / d->influences);
        const float used = f->weight != 0.0f ? 1.0f : 0.0f;
        f->scaled = f->weight / anchor[3];
        f->per_extent = used / anchor[3];
        for (int k = 0; k < 3; k++)
            f->lever[k] = used * ((centre[k] - anchor[k]) / anchor[3]);
        f->lever[3] = used;
    }
}

void nsdf_block_model_round_rest(nsdf_block_model *m) {
    round_tensor(m, NSDF_BLOCK_CENTRES);
    round_tensor(m, NSDF_BLOCK_RADII);
    round_weights(m);
    nsdf_block_model_set_influences(m);
}

/* A bone's anchor is the middle of its blocks, its extent their deviation: poses are then positions, and positions of
 * points one extent away, which one step suits. */
static void fill_anchors(nsdf_block_model *m) {
    const float *centre = tensor_values(m, NSDF_BLOCK_CENTRES), *bone = tensor_values(m, NSDF_BLOCK_BONES);
    const float *weight = tensor_values(m, NSDF_BLOCK_WEIGHTS);
    float *anchor = tensor_values(m, NSDF_BLOCK_ANCHORS);
    for (uint32_t b = 0; b < m->desc.bone_count; b++) {
        double total = 0.0, sum[3] = {0.0, 0.0, 0.0}, square = 0.0;
        for (size_t i = 0; i < NSDF_BONE_INFLUENCES * (size_t)m->desc.block_count; i++)
            for (size_t k = 0; (uint32_t)bone[i] == b && k < 3; k++) {
                const double w = (double)weight[i], x = (double)centre[i / NSDF_BONE_INFLUENCES * 3 + k];
                total += w / 3.0;
                sum[k] += w * x;
                square += w * x * x;
            }
        double variance = square;
        for (size_t k = 0; total > 0.0 && k < 3; k++) {
            anchor[4 * (size_t)b + k] = (float)(sum[k] / total);
            variance -= sum[k] * sum[k] / total;
        }
        const double extent = total > 0.0 && variance > 0.0 ? sqrt(variance / (3.0 * total)) : 0.0;
        anchor[4 * (size_t)b + 3] = (float)(extent > least_extent ? extent : least_extent);
    }
    round_tensor(m, NSDF_BLOCK_ANCHORS);
}

/* ---- Poses in time --------------------------------------------------------------------------------------- */

/* A bone's pose of one frame, as the file has it. */
static void pose_values(const nsdf_block_model *m, const double *pose, uint32_t bone, double out[12]) {
    const float *anchor = tensor_values(m, NSDF_BLOCK_ANCHORS) + 4 * (size_t)bone;
    for (int row = 0; row < 3; row++) {
        out[4 * row + 3] = pose[4 * row + 3];
        for (int k = 0; k < 3; k++) {
            out[4 * row + k] = pose[4 * row + k] * (double)anchor[3];
            out[4 * row + 3] += pose[4 * row + k] * (double)anchor[k];
        }
    }
}

/* Normal equations of cubic B-splines through all frames' poses, with second differences held down. */
static void spline_equations(const nsdf_block_model *m, const nsdf_bones *bones, const double *u, double *matrix,
                             double *right) {
    const size_t knots = m->knots, columns = 12 * (size_t)m->desc.bone_count;
    for (uint32_t f = 0; f < bones->frame_count; f++) {
        float w[4];
        const size_t first = nsdf_spline_weights(u[f], m->knots, w);
        for (size_t a = 0; a < 4; a++)
            for (size_t b = 0; b < 4; b++)
                matrix[(first + a) * knots + first + b] += (double)w[a] * (double)w[b];
        for (uint32_t i = 0; i < bones->bone_count; i++) {
            double value[12];
            pose_values(m, bones->poses + 12 * ((size_t)f * bones->bone_count + i), i, value);
            for (size_t a = 0; a < 4; a++)
                for (size_t n = 0; n < 12; n++)
                    right[(first + a) * columns + 12 * (size_t)i + n] += (double)w[a] * value[n];
        }
    }
    static const double second[3] = {1.0, -2.0, 1.0};
    for (size_t k = 0; k + 2 < knots; k++)
        for (size_t a = 0; a < 3; a++)
            for (size_t b = 0; b < 3; b++)
                matrix[(k + a) * knots + k + b] += smoothness * second[a] * second[b];
}

static int fill_poses(nsdf_block_model *m, const nsdf_bones *bones, const double *u) {
    float *poses = m->values + m->pose_offset;
    if (m->knots == 0) {
        for (uint32_t i = 0; i < bones->bone_count; i++) {
            double value[12];
            pose_values(m, bones->poses + 12 * (size_t)i, i, value);
            for (size_t n = 0; n < 12; n++)
                poses[12 * (size_t)i + n] = (float)value[n];
        }
        return 0;
    }
    const size_t knots = m->knots, columns = 12 * (size_t)m->desc.bone_count;
    double *matrix = calloc(knots * knots, sizeof *matrix), *right = calloc(knots * columns, sizeof *right);
    if (matrix && right) {
        spline_equations(m, bones, u, matrix, right);
        nsdf_solve_positive(matrix, knots, right, columns);
        for (size_t i = 0; i < m->pose_count; i++)
            poses[i] = (float)right[i];
    }
    int result = matrix && right ? 0 : -1;
    free(matrix);
    free(right);
    return result;
}

static int create_influences(nsdf_block_model *m) {
    const size_t count = (size_t)m->desc.block_count * m->desc.influences;
    const float *bones = tensor_values(m, NSDF_BLOCK_BONES);
    m->influences = malloc(count * sizeof *m->influences);
    if (!m->influences)
        return -1;
    for (size_t i = 0; i < count; i++)
        m->influences[i].bone = (uint32_t)bones[i];
    nsdf_block_model_set_influences(m);
    return 0;
}

int nsdf_block_model_create(nsdf_block_model *model, const nsdf_motion *motion, const nsdf_bones *bones,
                            const double *u, uint32_t degree, double knot_spacing, double level_spacing,
                            const nsdf_block_steps *steps) {
    memset(model, 0, sizeof *model);
    describe(model, motion, bones, u, degree, knot_spacing, level_spacing, steps);
    model->values = calloc(model->value_count, sizeof *model->values);
    if (!model->values)
        return -1;
    fill_rest(model, motion, bones, u);
    fill_anchors(model);
    if (create_influences(model) == 0 && fill_poses(model, bones, u) == 0)
        return 0;
    nsdf_block_model_free(model);
    return -1;
}

int nsdf_block_model_copy(nsdf_block_model *copy, const nsdf_block_model *model) {
    const size_t influences = (size_t)model->desc.block_count * model->desc.influences * sizeof *model->influences;
    *copy = *model;
    copy->values = malloc(model->value_count * sizeof *model->values);
    copy->influences = malloc(influences);
    if (!copy->values || !copy->influences) {
        nsdf_block_model_free(copy);
        return -1;
    }
    memcpy(copy->values, model->values, model->value_count * sizeof *model->values);
    memcpy(copy->influences, model->influences, influences);
    return 0;
}

void nsdf_block_model_free(nsdf_block_model *model) {
    free(model->values);
    free(model->influences);
    memset(model, 0, sizeof *model);
}

#include "block_rest.h"

#include "block_pose.h"

#include <math.h>
#include <string.h>

/* Rates for a full first step: of weights; of centres, normalised units; of radii, in those that blocks begin with. */
static const double weight_rate = 1e-2, centre_rate = 5e-4, radius_rate = 1e-2;
static const float least_weight = 1.0f / 64; /* half a step of the weights: what is not 0 can grow again */
/* Of model->radius.  Smaller balls would leave gaps; larger ones hold more points, each of which takes time in the
 * decoder, for little. */
static const float least_radius = 0.8f, most_radius = 1.5f;

int nsdf_block_rest_create(nsdf_block_rest *rest, const nsdf_block_model *model, int settled) {
    const size_t blocks = model->desc.block_count;
    memset(rest, 0, sizeof *rest);
    rest->settled = (uint8_t)(settled != 0);
    if (nsdf_adam_create(&rest->weights, NSDF_BONE_INFLUENCES * blocks) == 0 &&
        nsdf_adam_create(&rest->centres, 3 * blocks) == 0 && nsdf_adam_create(&rest->radii, blocks) == 0)
        return 0;
    nsdf_block_rest_free(rest);
    return -1;
}

void nsdf_block_rest_free(nsdf_block_rest *rest) {
    nsdf_adam_free(&rest->weights);
    nsdf_adam_free(&rest->centres);
    nsdf_adam_free(&rest->radii);
}

/* ---- Gradients ------------------------------------------------------------------------------------------- */

/* u = M^-1 (x - p) / r: dL/dr = -(dL/du . u) / r. */
void nsdf_block_rest_gradient(const nsdf_block_model *model, const nsdf_block_frame *frame, uint32_t block,
                              const float pose[12], const nsdf_block_gradient *sums, float rest[NSDF_REST_VALUES]) {
    const float radius = model->values[nsdf_block_offset(&model->desc, NSDF_BLOCK_RADII) + block];
    float *centre = rest + NSDF_BONE_INFLUENCES;
    nsdf_block_weight_gradient(model, frame, block, pose, rest);
    nsdf_block_centre_gradient(frame, block, pose, centre);
    centre[3] = -(sums->moment[0][0] + sums->moment[1][1] + sums->moment[2][2]) / radius;
}

void nsdf_block_rest_add_gradient(const nsdf_block_model *model, uint32_t block, const float rest[NSDF_REST_VALUES],
                                  float *gradient) {
    const nsdf_blocks_desc *d = &model->desc;
    float *weight = gradient + nsdf_block_offset(d, NSDF_BLOCK_WEIGHTS) + NSDF_BONE_INFLUENCES * (size_t)block;
    float *centre = gradient + nsdf_block_offset(d, NSDF_BLOCK_CENTRES) + 3 * (size_t)block;
    for (int i = 0; i < NSDF_BONE_INFLUENCES; i++)
        weight[i] += rest[i];
    for (int axis = 0; axis < 3; axis++)
        centre[axis] += rest[NSDF_BONE_INFLUENCES + axis];
    gradient[nsdf_block_offset(d, NSDF_BLOCK_RADII) + block] += rest[NSDF_BONE_INFLUENCES + 3];
}

/* ---- Steps ----------------------------------------------------------------------------------------------- */

/* What is left of the gradient when weights keep their sum. */
static void project(const float weight[NSDF_BONE_INFLUENCES], float gradient[NSDF_BONE_INFLUENCES]) {
    float sum = 0.0f, count = 0.0f;
    for (int i = 0; i < NSDF_BONE_INFLUENCES; i++) {
        sum += weight[i] > 0.0f ? gradient[i] : 0.0f;
        count += weight[i] > 0.0f ? 1.0f : 0.0f;
    }
    for (int i = 0; i < NSDF_BONE_INFLUENCES; i++)
        gradient[i] = weight[i] > 0.0f ? gradient[i] - sum / count : 0.0f;
}

/* Adam's steps do not keep it quite. */
static void normalise(float weight[NSDF_BONE_INFLUENCES]) {
    float sum = 0.0f;
    for (int i = 0; i < NSDF_BONE_INFLUENCES; i++) {
        weight[i] = weight[i] == 0.0f ? 0.0f : fmaxf(weight[i], least_weight);
        sum += weight[i];
    }
    for (int i = 0; i < NSDF_BONE_INFLUENCES; i++)
        weight[i] /= sum;
}

static void step_weights(nsdf_adam *adam, float *weights, float *gradient, size_t blocks, double rate) {
    for (size_t k = 0; k < blocks; k++)
        project(weights + NSDF_BONE_INFLUENCES * k, gradient + NSDF_BONE_INFLUENCES * k);
    nsdf_adam_step(adam, weights, gradient, rate);
    for (size_t k = 0; k < blocks; k++)
        normalise(weights + NSDF_BONE_INFLUENCES * k);
}

static void step_radii(nsdf_adam *adam, float *radii, const float *gradient, float first, double rate) {
    nsdf_adam_step(adam, radii, gradient, rate * (double)first);
    for (size_t k = 0; k < adam->count; k++)
        radii[k] = fminf(fmaxf(radii[k], least_radius * first), most_radius * first);
}

void nsdf_block_rest_step(nsdf_block_rest *rest, nsdf_block_model *model, float *gradient, double share) {
    const nsdf_blocks_desc *d = &model->desc;
    const size_t weights = nsdf_block_offset(d, NSDF_BLOCK_WEIGHTS), centres = nsdf_block_offset(d, NSDF_BLOCK_CENTRES);
    const size_t radii = nsdf_block_offset(d, NSDF_BLOCK_RADII);
    step_weights(&rest->weights, model->values + weights, gradient + weights, d->block_count, weight_rate * share);
    nsdf_adam_step(&rest->centres, model->values + centres, gradient + centres, centre_rate * share);
    step_radii(&rest->radii, model->values + radii, gradient + radii, model->radius, radius_rate * share);
    nsdf_block_model_set_influences(model);
}

void nsdf_block_rest_settle(nsdf_block_rest *rest, nsdf_block_model *model) {
    if (rest->settled)
        return;
    nsdf_block_model_round_rest(model);
    rest->settled = 1;
}

void nsdf_block_rest_fields(nsdf_block_rest *rest, nsdf_fit_state *fields) {
    nsdf_state_adam(fields, &rest->weights);
    nsdf_state_adam(fields, &rest->centres);
    nsdf_state_adam(fields, &rest->radii);
    nsdf_state_u8(fields, &rest->settled);
    nsdf_state_expect(fields, rest->settled <= 1, "a mark of values at rest that is not 0 or 1");
}

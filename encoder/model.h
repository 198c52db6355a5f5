/* The network being fitted: its description, its parameters, and the way from parameters to the matrices of one time
 * and back for gradients. */
#ifndef NSDF_MODEL_H
#define NSDF_MODEL_H

#include "format_desc.h"
#include "nsdf/encoder.h"
#include "random.h"

/* The composed network at one time is one vector: for each layer a matrix [out][in + 1] whose last column is the
 * bias, then B [fourier_count][4]. */
typedef struct nsdf_model {
    nsdf_network_desc desc;
    uint64_t parameter_count;
    uint64_t array_offset[NSDF_MAX_TENSORS][3]; /* of each array in the parameter vector */
    size_t layer_offset[NSDF_MAX_LAYERS];       /* of each matrix in the composed vector */
    size_t fourier_offset, composed_size;
    uint32_t widest; /* inputs or outputs of any layer */
} nsdf_model;

/* Shape of the network for `frame_count` frames that were added. */
void nsdf_model_describe(nsdf_model *model, const nsdf_encoder_options *options, uint32_t frame_count);

/* Recomputes everything that follows from model->desc. */
void nsdf_model_layout(nsdf_model *model);

uint32_t nsdf_layer_inputs(const nsdf_model *model, uint32_t layer);

/* First values: sine layers after Sitzmann et al. 2020 (first weights uniform in +-1/inputs, hidden ones in
 * +-sqrt(6 / inputs) / omega), relu after He et al. 2015; all knots alike. */
void nsdf_model_initialise(const nsdf_model *model, nsdf_random *random, float *parameters);

/* Composed vector at u in [0, 1]. */
void nsdf_model_compose(const nsdf_model *model, const float *parameters, double u, float *composed);

/* Adds to gradient[parameter_count] what a gradient with respect to the composed vector at u means for the parameters.
 */
void nsdf_model_scatter(const nsdf_model *model, const float *parameters, double u, const float *composed_gradient,
                        float *gradient);

#endif

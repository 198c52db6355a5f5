/* What the numbers of a network cost in the file, as a term of the loss. */
#ifndef NSDF_NETWORK_RATE_H
#define NSDF_NETWORK_RATE_H

#include "model.h"

/* Adds to gradient[parameter_count] that of weight * B, where B is the mean over all parameters of about the bits that
 * a number r takes: log2(1 + (r / step)^2) / 2.  For splines r is the difference from the control point before, from
 * which it is predicted; else the number itself.  Steps are those of model->desc; arrays without one have no rate. */
void nsdf_network_add_rate(const nsdf_model *model, const float *parameters, double weight, float *gradient);

#endif

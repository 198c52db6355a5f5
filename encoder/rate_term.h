/* About the bits that numbers take in the file, as a term of a loss. */
#ifndef NSDF_RATE_TERM_H
#define NSDF_RATE_TERM_H

#include <stddef.h>

/* Adds to slope[count] the gradient of scale * sum of log(1 + (r / step)^2) / 2 over values[count]: r is the difference
 * from the value `apart` places before, for all that have one; with 0, the value itself.  step > 0. */
void nsdf_add_rate_term(const float *values, size_t count, size_t apart, float step, float scale, float *slope);

#endif

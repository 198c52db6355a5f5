/* Residuals into the coded stream of a network part; the counterpart of entropy_read.h. */
#ifndef NSDF_ENTROPY_WRITE_H
#define NSDF_ENTROPY_WRITE_H

#include "container_write.h"

/* Appends the coded stream of all uniform arrays of list.  residuals: of all arrays in the order of the file (raw
 * arrays' elements are passed over).  Returns 0, or -1 when memory ran out or the back end is not in this build. */
int nsdf_write_residuals(nsdf_buffer *out, const nsdf_tensor_list *list, const int32_t *residuals);

/* The range coder's stream of the same arrays. */
void nsdf_range_write(nsdf_buffer *out, const nsdf_tensor_list *list, const int32_t *residuals);

#endif

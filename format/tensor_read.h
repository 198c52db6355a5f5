/* Descriptions of tensors, common to all kinds of parts. */
#ifndef NSDF_TENSOR_READ_H
#define NSDF_TENSOR_READ_H

#include "bytes.h"
#include "format_desc.h"

/* A float that is corrupt, as `what` says, unless it is finite. */
float nsdf_take_finite(nsdf_cursor *c, const char *what);

/* Reads kind, knots, rank and arrays of a tensor whose rows and columns are known. */
void nsdf_read_tensor(nsdf_cursor *c, nsdf_tensor_desc *t, uint32_t rows, uint32_t cols, int only_constant);

#endif

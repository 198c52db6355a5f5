/* The field at one time as a function of normalised position: what the mesher sees. */
#ifndef NSDF_FIELD_H
#define NSDF_FIELD_H

#include <stddef.h>
#include <stdint.h>

/* Values, and gradients if grad[0] is not NULL, at `count` points given as three arrays; in normalised units (signed
 * distance over the diagonal, negative inside; the gradient of an exact distance has length 1).  May be called by
 * several workers at once, each with its own `worker` number; must not allocate; a point's result may not depend on
 * the other points of the call. */
typedef struct nsdf_field {
    void *user;
    void (*evaluate)(void *user, uint32_t worker, size_t count, const float *const xyz[3], float *value,
                     float *const grad[3]);
    /* NULL, or a quicker way to |f|, for leaving out what is far from the surface: values with any sign; where |f| is
     * above `enough`, anything above it will do.  exact[] tells which are what evaluate gives. */
    void (*measure)(void *user, uint32_t worker, size_t count, const float *const xyz[3], float enough, float *value,
                    uint8_t *exact);
    /* The field may change its sign without being small there, but for where measure says that a value is exact. */
    int jumps;
} nsdf_field;

#endif

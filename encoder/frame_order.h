/* Frames in random order for fitting: every frame comes once before any comes again. */
#ifndef NSDF_FRAME_ORDER_H
#define NSDF_FRAME_ORDER_H

#include "random.h"

typedef struct nsdf_frame_order {
    uint32_t *frames; /* [count] */
    uint32_t count, used;
} nsdf_frame_order;

/* Returns 0, or -1 when memory ran out; zero-initialised orders can be freed. */
int nsdf_frame_order_create(nsdf_frame_order *order, uint32_t count);
void nsdf_frame_order_free(nsdf_frame_order *order);
uint32_t nsdf_frame_order_next(nsdf_frame_order *order, nsdf_random *random);

#endif

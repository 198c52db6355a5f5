#include "frame_order.h"

#include <stdlib.h>
#include <string.h>

int nsdf_frame_order_create(nsdf_frame_order *order, uint32_t count) {
    order->frames = calloc(count, sizeof *order->frames);
    order->count = order->used = count;
    for (uint32_t i = 0; order->frames && i < count; i++)
        order->frames[i] = i;
    return order->frames ? 0 : -1;
}

void nsdf_frame_order_free(nsdf_frame_order *order) {
    free(order->frames);
    memset(order, 0, sizeof *order);
}

uint32_t nsdf_frame_order_next(nsdf_frame_order *order, nsdf_random *random) {
    if (order->used >= order->count) {
        for (uint32_t i = order->count - 1; i > 0; i--) {
            const uint32_t j = nsdf_random_below(random, i + 1), t = order->frames[i];
            order->frames[i] = order->frames[j];
            order->frames[j] = t;
        }
        order->used = 0;
    }
    return order->frames[order->used++];
}

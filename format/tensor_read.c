#include "tensor_read.h"

#include <math.h>

float nsdf_take_finite(nsdf_cursor *c, const char *what) {
    float v = nsdf_take_f32(c);
    nsdf_cursor_expect(c, isfinite(v), c->at - 4, what);
    return v;
}

static void read_array(nsdf_cursor *c, nsdf_array_desc *a) {
    size_t at = c->at;
    uint32_t coding = nsdf_take_u8(c);
    a->quantiser = coding & 15;
    a->predict = (uint8_t)(coding >> 4);
    nsdf_cursor_expect(c, a->quantiser <= NSDF_QUANT_UNIFORM, at, "quantiser above 1");
    nsdf_cursor_expect(c, a->predict <= (a->quantiser == NSDF_QUANT_UNIFORM ? NSDF_PREDICT_ROW : 0), at,
                       "prediction above 3, or not 0 in a raw array");
    if (a->quantiser != NSDF_QUANT_UNIFORM)
        return;
    a->bits = nsdf_take_u8(c);
    nsdf_cursor_expect(c, a->bits <= 24, at + 1, "bits per parameter above 24");
    a->residual_min = nsdf_take_i32(c);
    nsdf_cursor_expect(c, a->residual_min > -2 * NSDF_MAX_QUANTISED && a->residual_min < 2 * NSDF_MAX_QUANTISED, at + 2,
                       "smallest residual not below 2^25 in magnitude");
    a->step = nsdf_take_finite(c, "quantiser step not finite");
    nsdf_cursor_expect(c, a->step >= 0.0f, c->at - 4, "quantiser step below 0");
    a->offset = nsdf_take_finite(c, "quantiser offset not finite");
}

void nsdf_read_tensor(nsdf_cursor *c, nsdf_tensor_desc *t, uint32_t rows, uint32_t cols, int only_constant) {
    size_t at = c->at;
    t->rows = rows;
    t->cols = cols;
    t->kind = nsdf_take_u8(c);
    nsdf_cursor_expect(c, t->kind <= NSDF_TENSOR_LOW_RANK, at, "tensor kind above 2");
    nsdf_cursor_expect(c, t->kind == NSDF_TENSOR_CONSTANT || !only_constant, at,
                       "tensor that must be constant and is not");
    if (t->kind != NSDF_TENSOR_CONSTANT) {
        t->knots = nsdf_take_u16(c);
        nsdf_cursor_expect(c, t->knots >= NSDF_MIN_KNOTS && t->knots <= NSDF_MAX_KNOTS, c->at - 2,
                           "fewer than 4 knots");
    }
    if (t->kind == NSDF_TENSOR_LOW_RANK) {
        t->rank = nsdf_take_u16(c);
        nsdf_cursor_expect(c, t->rank >= 1 && t->rank <= NSDF_MAX_RANK, c->at - 2, "rank outside 1 to 256");
    }
    if (c->status != NSDF_PARSE_OK)
        return;
    nsdf_tensor_layout(t);
    for (uint32_t k = 0; k < t->array_count; k++)
        read_array(c, &t->arrays[k]);
}

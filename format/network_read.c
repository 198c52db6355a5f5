#include "network_read.h"

#include <math.h>
#include <string.h>

#include "bytes.h"

/* Spec, section "SEGM". */
nsdf_parse nsdf_read_parts(const uint8_t *payload, size_t size, nsdf_part_ref parts[NSDF_MAX_PARTS],
                           uint32_t *part_count, nsdf_fault *fault) {
    nsdf_cursor c = nsdf_cursor_start(payload, size, 0);
    uint32_t count = nsdf_take_u32(&c);
    nsdf_cursor_expect(&c, count >= 1 && count <= NSDF_MAX_PARTS, 0, "part count outside 1 to 16");
    for (uint32_t i = 0; i < count && c.status == NSDF_PARSE_OK; i++) {
        size_t at = c.at;
        parts[i].kind = nsdf_take_u16(&c);
        parts[i].flags = nsdf_take_u16(&c);
        uint64_t length = nsdf_take_u64(&c);
        if (c.status == NSDF_PARSE_OK && parts[i].kind != NSDF_PART_NETWORK)
            nsdf_cursor_fail(&c, NSDF_PARSE_FEATURE, at, "a part of an unknown kind, expected 1 (network)");
        if (c.status == NSDF_PARSE_OK && length > size - c.at)
            nsdf_cursor_fail(&c, NSDF_PARSE_TRUNCATED, at + 4, "part length beyond the end of the segment");
        parts[i].size = (size_t)length;
        parts[i].data = nsdf_take(&c, parts[i].size);
    }
    nsdf_cursor_expect(&c, c.at == size, c.at, "bytes behind the last part of a segment");
    if (c.status == NSDF_PARSE_OK)
        *part_count = count;
    return nsdf_cursor_finish(&c, fault);
}

static float take_finite(nsdf_cursor *c, const char *what) {
    float v = nsdf_take_f32(c);
    nsdf_cursor_expect(c, isfinite(v), c->at - 4, what);
    return v;
}

/* The fixed front: kinds, counts and scales. */
static void read_front(nsdf_cursor *c, nsdf_network_desc *d) {
    size_t at = c->at;
    d->input = nsdf_take_u8(c);
    d->fourier_source = nsdf_take_u8(c);
    d->entropy = nsdf_take_u8(c);
    d->layer_count = nsdf_take_u8(c);
    d->fourier_count = nsdf_take_u16(c);
    int fourier = d->input == NSDF_INPUT_FOURIER;
    nsdf_cursor_expect(c, d->input <= NSDF_INPUT_FOURIER, at, "input kind above 2");
    nsdf_cursor_expect(c, d->fourier_source <= (fourier ? NSDF_FOURIER_STORED : 0), at + 1,
                       "Fourier source above 1, or not 0 without Fourier features");
    nsdf_cursor_expect(c, d->entropy < NSDF_ENTROPY_COUNT, at + 2, "entropy back end above 3");
    nsdf_cursor_expect(c, d->layer_count >= 1 && d->layer_count <= NSDF_MAX_LAYERS, at + 3,
                       "layer count outside 1 to 32");
    nsdf_cursor_expect(c, fourier ? d->fourier_count >= 1 && d->fourier_count <= NSDF_MAX_FOURIER : !d->fourier_count,
                       at + 4, "Fourier rows outside 1 to 512, or not 0 without Fourier features");
    if (fourier && d->fourier_source == NSDF_FOURIER_SEED) {
        d->fourier_seed = nsdf_take_u64(c);
        d->fourier_sigma = nsdf_take_f32(c);
        nsdf_cursor_expect(c, d->fourier_sigma >= 0.0f && d->fourier_sigma <= 1e6f, c->at - 4,
                           "sigma of the Fourier matrix outside 0 to 1e6");
    }
    d->time_scale = take_finite(c, "time scale not finite");
    d->value_scale = take_finite(c, "value scale not finite");
    nsdf_cursor_expect(c, d->value_scale != 0.0f, c->at - 4, "value scale 0");
    d->value_offset = take_finite(c, "value offset not finite");
}

static void read_layer(nsdf_cursor *c, nsdf_layer_desc *layer) {
    layer->width = nsdf_take_u16(c);
    nsdf_cursor_expect(c, layer->width >= 1 && layer->width <= NSDF_MAX_WIDTH, c->at - 2,
                       "layer width outside 1 to 1024");
    layer->activation = nsdf_take_u8(c);
    nsdf_cursor_expect(c, layer->activation <= NSDF_ACT_TANH, c->at - 1, "activation above 3");
    if (layer->activation == NSDF_ACT_SINE)
        layer->omega = take_finite(c, "omega of a sine layer not finite");
}

static void read_array(nsdf_cursor *c, nsdf_array_desc *a) {
    size_t at = c->at;
    uint32_t coding = nsdf_take_u8(c);
    a->quantiser = coding & 15;
    a->predict = (uint8_t)(coding >> 4);
    nsdf_cursor_expect(c, a->quantiser <= NSDF_QUANT_UNIFORM, at, "quantiser above 1");
    nsdf_cursor_expect(c, a->predict <= (a->quantiser == NSDF_QUANT_UNIFORM ? NSDF_PREDICT_PLANE : 0), at,
                       "prediction above 1, or not 0 in a raw array");
    if (a->quantiser != NSDF_QUANT_UNIFORM)
        return;
    a->bits = nsdf_take_u8(c);
    nsdf_cursor_expect(c, a->bits <= 24, at + 1, "bits per parameter above 24");
    a->residual_min = nsdf_take_i32(c);
    nsdf_cursor_expect(c, a->residual_min > -2 * NSDF_MAX_QUANTISED && a->residual_min < 2 * NSDF_MAX_QUANTISED, at + 2,
                       "smallest residual not below 2^25 in magnitude");
    a->step = take_finite(c, "quantiser step not finite");
    nsdf_cursor_expect(c, a->step >= 0.0f, c->at - 4, "quantiser step below 0");
    a->offset = take_finite(c, "quantiser offset not finite");
}

static void read_tensor(nsdf_cursor *c, nsdf_tensor_desc *t, uint32_t rows, uint32_t cols, int only_constant) {
    size_t at = c->at;
    t->rows = rows;
    t->cols = cols;
    t->kind = nsdf_take_u8(c);
    nsdf_cursor_expect(c, t->kind <= NSDF_TENSOR_LOW_RANK, at, "tensor kind above 2");
    nsdf_cursor_expect(c, t->kind == NSDF_TENSOR_CONSTANT || !only_constant, at,
                       "stored Fourier matrix that is not constant");
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

static void read_tensors(nsdf_cursor *c, nsdf_network_desc *d) {
    d->tensor_count = nsdf_weight_index(d, d->layer_count);
    nsdf_tensor_desc *t = d->tensors;
    if (nsdf_weight_index(d, 0) == 1)
        read_tensor(c, t++, d->fourier_count, 4, 1);
    uint32_t inputs = nsdf_input_width(d);
    for (uint32_t i = 0; i < d->layer_count && c->status == NSDF_PARSE_OK; i++) {
        read_tensor(c, t++, d->layers[i].width, inputs, 0);
        read_tensor(c, t++, d->layers[i].width, 1, 0);
        inputs = d->layers[i].width;
    }
}

nsdf_parse nsdf_read_network_desc(const uint8_t *part, size_t size, nsdf_network_desc *desc, size_t *coded_offset,
                                  nsdf_fault *fault) {
    nsdf_cursor c = nsdf_cursor_start(part, size, 0);
    memset(desc, 0, sizeof *desc);
    read_front(&c, desc);
    for (uint32_t i = 0; i < desc->layer_count && c.status == NSDF_PARSE_OK; i++)
        read_layer(&c, &desc->layers[i]);
    if (c.status == NSDF_PARSE_OK)
        nsdf_cursor_expect(&c, desc->layers[desc->layer_count - 1].width == 1, c.at, "last layer with a width above 1");
    if (c.status == NSDF_PARSE_OK)
        read_tensors(&c, desc);
    nsdf_cursor_expect(&c, nsdf_parameter_count(desc) <= NSDF_MAX_PARAMETERS, c.at, "more than 2^28 parameters");
    if (c.status == NSDF_PARSE_OK)
        *coded_offset = c.at;
    return nsdf_cursor_finish(&c, fault);
}

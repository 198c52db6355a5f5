#include "network_read.h"

#include <math.h>
#include <string.h>

#include "bytes.h"
#include "tensor_read.h"

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
        if (c.status == NSDF_PARSE_OK && parts[i].kind != NSDF_PART_NETWORK && parts[i].kind != NSDF_PART_BLOCKS)
            nsdf_cursor_fail(&c, NSDF_PARSE_FEATURE, at,
                             "a part of an unknown kind, expected 1 (network) or 2 (blocks)");
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

/* The fixed front: kinds, counts and scales. */
static void read_front(nsdf_cursor *c, nsdf_network_desc *d) {
    size_t at = c->at;
    d->input = nsdf_take_u8(c);
    d->fourier_source = nsdf_take_u8(c);
    d->list.entropy = nsdf_take_u8(c);
    d->layer_count = nsdf_take_u8(c);
    d->fourier_count = nsdf_take_u16(c);
    int fourier = d->input == NSDF_INPUT_FOURIER;
    nsdf_cursor_expect(c, d->input <= NSDF_INPUT_FOURIER, at, "input kind above 2");
    nsdf_cursor_expect(c, d->fourier_source <= (fourier ? NSDF_FOURIER_STORED : 0), at + 1,
                       "Fourier source above 1, or not 0 without Fourier features");
    nsdf_cursor_expect(c, d->list.entropy < NSDF_ENTROPY_COUNT, at + 2, "entropy back end above 3");
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
    d->time_scale = nsdf_take_finite(c, "time scale not finite");
    d->value_scale = nsdf_take_finite(c, "value scale not finite");
    nsdf_cursor_expect(c, d->value_scale != 0.0f, c->at - 4, "value scale 0");
    d->value_offset = nsdf_take_finite(c, "value offset not finite");
}

static void read_layer(nsdf_cursor *c, nsdf_layer_desc *layer) {
    layer->width = nsdf_take_u16(c);
    nsdf_cursor_expect(c, layer->width >= 1 && layer->width <= NSDF_MAX_WIDTH, c->at - 2,
                       "layer width outside 1 to 1024");
    layer->activation = nsdf_take_u8(c);
    nsdf_cursor_expect(c, layer->activation <= NSDF_ACT_TANH, c->at - 1, "activation above 3");
    if (layer->activation == NSDF_ACT_SINE)
        layer->omega = nsdf_take_finite(c, "omega of a sine layer not finite");
}

static void read_tensors(nsdf_cursor *c, nsdf_network_desc *d) {
    d->list.count = nsdf_weight_index(d, d->layer_count);
    nsdf_tensor_desc *t = d->list.tensors;
    if (nsdf_weight_index(d, 0) == 1)
        nsdf_read_tensor(c, t++, d->fourier_count, 4, 1);
    uint32_t inputs = nsdf_input_width(d);
    for (uint32_t i = 0; i < d->layer_count && c->status == NSDF_PARSE_OK; i++) {
        nsdf_read_tensor(c, t++, d->layers[i].width, inputs, 0);
        nsdf_read_tensor(c, t++, d->layers[i].width, 1, 0);
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
    nsdf_cursor_expect(&c, nsdf_parameter_count(&desc->list) <= NSDF_MAX_PARAMETERS, c.at, "more than 2^28 parameters");
    if (c.status == NSDF_PARSE_OK)
        *coded_offset = c.at;
    return nsdf_cursor_finish(&c, fault);
}

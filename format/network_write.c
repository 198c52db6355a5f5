#include "network_write.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "entropy_write.h"
#include "range_model.h"

void nsdf_write_segment_start(nsdf_buffer *payload, uint32_t part_count) {
    nsdf_buffer_u32(payload, part_count);
}

static void predict(const nsdf_array_desc *a, int how, const int32_t *q, int32_t *residuals) {
    size_t plane = (size_t)a->rows * a->cols, count = plane * a->planes;
    for (size_t i = 0; i < count; i++) {
        int32_t expected = how == NSDF_PREDICT_NONE || i < plane ? 0 : q[i - plane];
        if (how == NSDF_PREDICT_LINEAR && i >= 2 * plane)
            expected = 2 * q[i - plane] - q[i - 2 * plane];
        if (how == NSDF_PREDICT_ROW)
            expected = i % plane < a->cols ? 0 : q[i - a->cols];
        residuals[i] = q[i] - expected;
    }
}

typedef struct residual_cost {
    int32_t min;
    uint32_t bits; /* of the span; above 24 the residuals cannot be stored */
    double size;   /* estimate, bits */
} residual_cost;

/* Entropy of the magnitude classes, and the sign and mantissa bits behind them; packed bits when nothing is coded. */
static residual_cost estimate(const int32_t *residuals, size_t count, int packed) {
    size_t classes[NSDF_RANGE_CLASSES] = {0};
    int32_t min = residuals[0], max = residuals[0];
    for (size_t i = 0; i < count; i++) {
        min = residuals[i] < min ? residuals[i] : min;
        max = residuals[i] > max ? residuals[i] : max;
        classes[nsdf_residual_class(residuals[i])]++;
    }
    residual_cost cost = {min, nsdf_bit_length((uint32_t)(max - min)), 0.0};
    for (uint32_t c = 0; c < NSDF_RANGE_CLASSES; c++)
        if (classes[c] > 0)
            cost.size += (double)classes[c] * (log2((double)count / (double)classes[c]) + (double)c);
    if (packed)
        cost.size = (double)count * cost.bits;
    return cost;
}

/* Chooses the prediction of one array; `residuals` gets the chosen ones, `spare` is as large. */
static int choose_prediction(nsdf_array_desc *a, int packed, const int32_t *q, int32_t *residuals, int32_t *spare) {
    size_t count = (size_t)nsdf_array_size(a);
    for (size_t i = 0; i < count; i++)
        if (q[i] <= -NSDF_MAX_QUANTISED || q[i] >= NSDF_MAX_QUANTISED)
            return -1;
    memcpy(residuals, q, count * sizeof *residuals);
    residual_cost best = estimate(q, count, packed);
    a->predict = NSDF_PREDICT_NONE;
    for (int how = NSDF_PREDICT_PLANE; how <= NSDF_PREDICT_ROW; how++) {
        if (how == NSDF_PREDICT_ROW ? a->rows == 1 : a->planes == 1)
            continue;
        predict(a, how, q, spare);
        residual_cost cost = estimate(spare, count, packed);
        if (cost.bits > 24 || (best.bits <= 24 && cost.size >= best.size))
            continue;
        best = cost;
        a->predict = (uint8_t)how;
        memcpy(residuals, spare, count * sizeof *residuals);
    }
    a->residual_min = best.min;
    a->bits = (uint8_t)best.bits;
    return best.bits <= 24 ? 0 : -1;
}

static int choose_predictions(nsdf_tensor_list *list, const int32_t *q, int32_t *residuals, int32_t *spare) {
    for (uint32_t t = 0; t < list->count; t++)
        for (uint32_t k = 0; k < list->tensors[t].array_count; k++) {
            nsdf_array_desc *a = &list->tensors[t].arrays[k];
            size_t count = (size_t)nsdf_array_size(a);
            if (a->quantiser == NSDF_QUANT_RAW) {
                a->predict = a->bits = 0;
                a->residual_min = 0;
            } else if (choose_prediction(a, list->entropy == NSDF_ENTROPY_NONE, q, residuals, spare)) {
                return -1;
            }
            q += count;
            residuals += count;
        }
    return 0;
}

static void write_array_desc(nsdf_buffer *b, const nsdf_array_desc *a) {
    nsdf_buffer_u8(b, (uint8_t)(a->quantiser | a->predict << 4));
    if (a->quantiser == NSDF_QUANT_RAW)
        return;
    nsdf_buffer_u8(b, a->bits);
    nsdf_buffer_u32(b, (uint32_t)a->residual_min);
    nsdf_buffer_f32(b, a->step);
    nsdf_buffer_f32(b, a->offset);
}

void nsdf_write_tensor_desc(nsdf_buffer *b, const nsdf_tensor_desc *t) {
    nsdf_buffer_u8(b, t->kind);
    if (t->kind != NSDF_TENSOR_CONSTANT)
        nsdf_buffer_u16(b, (uint16_t)t->knots);
    if (t->kind == NSDF_TENSOR_LOW_RANK)
        nsdf_buffer_u16(b, (uint16_t)t->rank);
    for (uint32_t k = 0; k < t->array_count; k++)
        write_array_desc(b, &t->arrays[k]);
}

static void write_desc(nsdf_buffer *b, const nsdf_network_desc *d) {
    int fourier = d->input == NSDF_INPUT_FOURIER;
    nsdf_buffer_u8(b, d->input);
    nsdf_buffer_u8(b, fourier ? d->fourier_source : 0);
    nsdf_buffer_u8(b, d->list.entropy);
    nsdf_buffer_u8(b, (uint8_t)d->layer_count);
    nsdf_buffer_u16(b, (uint16_t)(fourier ? d->fourier_count : 0));
    if (fourier && d->fourier_source == NSDF_FOURIER_SEED) {
        nsdf_buffer_u64(b, d->fourier_seed);
        nsdf_buffer_f32(b, d->fourier_sigma);
    }
    nsdf_buffer_f32(b, d->time_scale);
    nsdf_buffer_f32(b, d->value_scale);
    nsdf_buffer_f32(b, d->value_offset);
    for (uint32_t i = 0; i < d->layer_count; i++) {
        nsdf_buffer_u16(b, (uint16_t)d->layers[i].width);
        nsdf_buffer_u8(b, d->layers[i].activation);
        if (d->layers[i].activation == NSDF_ACT_SINE)
            nsdf_buffer_f32(b, d->layers[i].omega);
    }
    for (uint32_t t = 0; t < d->list.count; t++)
        nsdf_write_tensor_desc(b, &d->list.tensors[t]);
}

static void write_raw_arrays(nsdf_buffer *b, const nsdf_tensor_list *d, const int32_t *q) {
    for (uint32_t t = 0; t < d->count; t++)
        for (uint32_t k = 0; k < d->tensors[t].array_count; k++) {
            const nsdf_array_desc *a = &d->tensors[t].arrays[k];
            for (size_t i = 0; i < (size_t)nsdf_array_size(a) && a->quantiser == NSDF_QUANT_RAW; i++)
                nsdf_buffer_u32(b, (uint32_t)q[i]);
            q += nsdf_array_size(a);
        }
}

/* What this appends is what a reader must accept: the description is read back to be sure. */
static int write_checked_desc(nsdf_buffer *b, const void *network) {
    const nsdf_network_desc *desc = network;
    write_desc(b, desc);
    nsdf_network_desc *back = b->failed ? NULL : malloc(sizeof *back);
    if (!back)
        return -1;
    size_t end = 0;
    nsdf_parse status = nsdf_read_network_desc(b->data, b->size, back, &end, NULL);
    int same = status == NSDF_PARSE_OK && end == b->size &&
               nsdf_parameter_count(&back->list) == nsdf_parameter_count(&desc->list);
    free(back);
    return same ? 0 : -1;
}

static int write_part_bytes(nsdf_buffer *part, nsdf_tensor_list *list, nsdf_write_desc_fn write, const void *desc,
                            const int32_t *q, int32_t *residuals, int32_t *spare) {
    if (choose_predictions(list, q, residuals, spare) || write(part, desc))
        return -1;
    nsdf_buffer raw = {0}, coded = {0};
    write_raw_arrays(&raw, list, q);
    int failed = nsdf_write_residuals(&coded, list, residuals);
    nsdf_buffer_u32(part, (uint32_t)raw.size);
    nsdf_buffer_append(part, raw.data, raw.size);
    nsdf_buffer_u32(part, (uint32_t)coded.size);
    nsdf_buffer_append(part, coded.data, coded.size);
    failed |= raw.failed | coded.failed | part->failed;
    nsdf_buffer_free(&raw);
    nsdf_buffer_free(&coded);
    return failed ? -1 : 0;
}

int nsdf_write_part(nsdf_buffer *payload, uint16_t kind, nsdf_tensor_list *list, nsdf_write_desc_fn write,
                    const void *desc, const int32_t *q) {
    uint64_t count = nsdf_parameter_count(list);
    if (count == 0 || count > NSDF_MAX_PARAMETERS)
        return -1;
    nsdf_buffer part = {0};
    int32_t *residuals = malloc((size_t)count * sizeof *residuals);
    int32_t *spare = malloc((size_t)count * sizeof *spare);
    int failed = !residuals || !spare || write_part_bytes(&part, list, write, desc, q, residuals, spare);
    if (!failed) {
        nsdf_buffer_u16(payload, kind);
        nsdf_buffer_u16(payload, 0);
        nsdf_buffer_u64(payload, part.size);
        nsdf_buffer_append(payload, part.data, part.size);
    }
    free(residuals);
    free(spare);
    nsdf_buffer_free(&part);
    return failed || payload->failed ? -1 : 0;
}

int nsdf_write_network_part(nsdf_buffer *payload, nsdf_network_desc *desc, const int32_t *q) {
    return nsdf_write_part(payload, NSDF_PART_NETWORK, &desc->list, write_checked_desc, desc, q);
}

#include "entropy_write.h"
#include "range_model.h"

typedef struct range_encoder {
    nsdf_buffer *out;
    size_t start; /* of the stream in `out` */
    uint32_t low, range;
    nsdf_logistic_tables tables;
} range_encoder;

/* The bytes so far are a fraction in base 256; adding to `low` may carry into them.  It never carries out of the
 * first: the whole interval lies below 1. */
static void add_to_low(range_encoder *e, uint32_t amount) {
    uint32_t before = e->low;
    e->low += amount;
    if (e->low >= before || e->out->failed)
        return;
    for (size_t i = e->out->size; i-- > e->start;)
        if (++e->out->data[i] != 0)
            break;
}

static void shift_out(range_encoder *e) {
    nsdf_buffer_u8(e->out, (uint8_t)(e->low >> 24));
    e->low <<= 8;
}

static void normalise(range_encoder *e) {
    while (e->range < NSDF_RANGE_TOP) {
        e->range <<= 8;
        shift_out(e);
    }
}

/* `zero` is the probability of 0 in 1/65536. */
static void encode_bit(range_encoder *e, uint32_t zero, uint32_t bit) {
    uint32_t bound = (e->range >> 16) * zero;
    if (bit)
        add_to_low(e, bound);
    e->range = bit ? e->range - bound : bound;
    normalise(e);
}

static void encode_mixed(range_encoder *e, nsdf_range_group *g, const uint32_t *contexts, uint32_t node, uint32_t bit) {
    nsdf_range_votes votes;
    nsdf_range_vote(g, contexts, node, &e->tables, &votes);
    encode_bit(e, votes.zero, bit);
    nsdf_range_learn(&votes, bit, &e->tables);
}

static void encode_alone(range_encoder *e, nsdf_bit_model *m, uint32_t bit) {
    encode_bit(e, m->zero, bit);
    nsdf_bit_update(m, bit, &e->tables);
}

static void encode_plain_bits(range_encoder *e, uint32_t value, uint32_t count) {
    while (count--) {
        e->range >>= 1;
        if (value >> count & 1)
            add_to_low(e, e->range);
        normalise(e);
    }
}

/* The top `count` of `bits` bits of value, from the root of a tree of models. */
static void encode_tree(range_encoder *e, nsdf_bit_model *tree, uint32_t value, uint32_t bits, uint32_t count) {
    uint32_t node = 1;
    for (uint32_t i = 1; i <= count; i++) {
        uint32_t bit = value >> (bits - i) & 1;
        encode_alone(e, &tree[node], bit);
        node = node << 1 | bit;
    }
}

static void encode_residual(range_encoder *e, nsdf_range_group *g, const nsdf_range_contexts *c, int32_t r) {
    uint32_t class = nsdf_residual_class(r);
    for (uint32_t k = 0; k <= class && k < g->largest; k++)
        encode_mixed(e, g, c->class, nsdf_class_node(k), k < class);
    if (class == 0)
        return;
    encode_mixed(e, g, c->sign, NSDF_NODE_SIGN, r < 0);
    uint32_t below = class - 1, modelled = below < 2 ? below : 2;
    encode_tree(e, g->mantissa[class], nsdf_magnitude(r), below, modelled);
    encode_plain_bits(e, nsdf_magnitude(r), below - modelled);
}

static void encode_group(range_encoder *e, nsdf_range_group *g, const int32_t *residuals) {
    const nsdf_array_desc *a = g->array;
    const int32_t *r = residuals + (size_t)g->first_plane * a->rows * a->cols;
    for (uint32_t plane = g->first_plane; plane < g->end_plane; plane++)
        for (uint32_t row = 0; row < a->rows; row++)
            for (uint32_t col = 0; col < a->cols; col++, r++) {
                nsdf_range_contexts contexts;
                nsdf_range_look(g, r, plane, row, col, &contexts);
                encode_residual(e, g, &contexts, *r);
                nsdf_range_means_update(g, plane, row, col, *r);
            }
}

static void encode_array(range_encoder *e, const nsdf_array_desc *a, const int32_t *residuals) {
    nsdf_range_group group;
    uint32_t middle = nsdf_range_first_group_end(a);
    nsdf_range_group_start(&group, a, 0, middle);
    encode_group(e, &group, residuals);
    if (middle < a->planes) {
        nsdf_range_group_start(&group, a, middle, a->planes);
        encode_group(e, &group, residuals);
    }
}

void nsdf_range_write(nsdf_buffer *out, const nsdf_tensor_list *list, const int32_t *residuals) {
    range_encoder e = {.out = out, .start = out->size, .low = 0, .range = UINT32_MAX};
    nsdf_logistic_fill(&e.tables);
    for (uint32_t t = 0; t < list->count; t++)
        for (uint32_t k = 0; k < list->tensors[t].array_count; k++) {
            const nsdf_array_desc *a = &list->tensors[t].arrays[k];
            if (a->quantiser == NSDF_QUANT_UNIFORM && a->bits > 0)
                encode_array(&e, a, residuals);
            residuals += nsdf_array_size(a);
        }
    for (int i = 0; i < 4; i++)
        shift_out(&e);
}

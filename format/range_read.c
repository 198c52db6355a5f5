#include "entropy_read.h"
#include "range_model.h"

static uint32_t next_byte(nsdf_range_decoder *d) {
    if (d->data < d->end)
        return *d->data++;
    d->missing = 1;
    return 0;
}

static void normalise(nsdf_range_decoder *d) {
    while (d->range < NSDF_RANGE_TOP) {
        d->range <<= 8;
        d->code = d->code << 8 | next_byte(d);
    }
}

/* `zero` is the probability of 0 in 1/65536. */
static uint32_t decode_bit(nsdf_range_decoder *d, uint32_t zero) {
    uint32_t bound = (d->range >> 16) * zero;
    uint32_t bit = d->code >= bound;
    d->code -= bit ? bound : 0;
    d->range = bit ? d->range - bound : bound;
    normalise(d);
    return bit;
}

static uint32_t decode_mixed(nsdf_range_decoder *d, nsdf_range_group *g, const uint32_t *contexts, uint32_t node) {
    nsdf_range_votes votes;
    nsdf_range_vote(g, contexts, node, &d->tables, &votes);
    uint32_t bit = decode_bit(d, votes.zero);
    nsdf_range_learn(&votes, bit, &d->tables);
    return bit;
}

static uint32_t decode_alone(nsdf_range_decoder *d, nsdf_bit_model *m) {
    uint32_t bit = decode_bit(d, m->zero);
    nsdf_bit_update(m, bit, &d->tables);
    return bit;
}

static uint32_t decode_plain_bits(nsdf_range_decoder *d, uint32_t count) {
    uint32_t value = 0;
    while (count--) {
        d->range >>= 1;
        uint32_t bit = d->code >= d->range;
        d->code -= bit ? d->range : 0;
        value = value << 1 | bit;
        normalise(d);
    }
    return value;
}

/* |residual| of a known class: the leading one, two modelled bits, the rest as they are. */
static uint32_t decode_magnitude(nsdf_range_decoder *d, uint32_t class, nsdf_bit_model mantissa[4]) {
    if (class < 2)
        return class;
    uint32_t below = class - 1, node = 1;
    uint32_t modelled = below < 2 ? below : 2;
    for (uint32_t i = 0; i < modelled; i++)
        node = node << 1 | decode_alone(d, &mantissa[node]);
    return node << (below - modelled) | decode_plain_bits(d, below - modelled);
}

static int32_t decode_residual(nsdf_range_decoder *d, nsdf_range_group *g, const nsdf_range_contexts *c) {
    uint32_t class = 0;
    while (class < g->largest && decode_mixed(d, g, c->class, nsdf_class_node(class)))
        ++class;
    if (class == 0)
        return 0;
    uint32_t negative = decode_mixed(d, g, c->sign, NSDF_NODE_SIGN);
    int32_t magnitude = (int32_t)decode_magnitude(d, class, g->mantissa[class]);
    return negative ? -magnitude : magnitude;
}

/* Fills one group, and stops early when the stream has ended: time stays bounded by the bytes there are. */
static void decode_group(nsdf_range_decoder *d, nsdf_range_group *g, int32_t *residuals) {
    const nsdf_array_desc *a = g->array;
    int32_t *r = residuals + (size_t)g->first_plane * a->rows * a->cols;
    for (uint32_t plane = g->first_plane; plane < g->end_plane; plane++)
        for (uint32_t row = 0; row < a->rows && !d->missing; row++)
            for (uint32_t col = 0; col < a->cols; col++, r++) {
                nsdf_range_contexts contexts;
                nsdf_range_look(g, r, plane, row, col, &contexts);
                *r = decode_residual(d, g, &contexts);
                nsdf_range_means_update(g, plane, row, col, *r);
            }
}

void nsdf_range_open(nsdf_range_decoder *d, const uint8_t *data, size_t size) {
    d->data = data;
    d->end = data + size;
    d->range = UINT32_MAX;
    d->code = 0;
    d->missing = 0;
    nsdf_logistic_fill(&d->tables);
    for (int i = 0; i < 4; i++)
        d->code = d->code << 8 | next_byte(d);
}

nsdf_parse nsdf_range_array(nsdf_range_decoder *d, const nsdf_array_desc *a, int32_t *residuals, const char **what) {
    nsdf_range_group group;
    uint32_t middle = nsdf_range_first_group_end(a);
    nsdf_range_group_start(&group, a, 0, middle);
    decode_group(d, &group, residuals);
    if (middle < a->planes) {
        nsdf_range_group_start(&group, a, middle, a->planes);
        decode_group(d, &group, residuals);
    }
    if (d->missing) {
        *what = "the range-coded stream ends before the last parameter";
        return NSDF_PARSE_TRUNCATED;
    }
    int32_t low = a->residual_min, high = nsdf_residual_max(a), inside = 1;
    for (size_t i = 0, n = (size_t)nsdf_array_size(a); i < n; i++)
        inside &= residuals[i] >= low && residuals[i] <= high;
    if (!inside) {
        *what = "a residual outside the range that its array's description gives";
        return NSDF_PARSE_CORRUPT;
    }
    return NSDF_PARSE_OK;
}

nsdf_parse nsdf_range_close(const nsdf_range_decoder *d, const char **what) {
    if (d->data != d->end) {
        *what = "bytes left behind the range-coded stream";
        return NSDF_PARSE_CORRUPT;
    }
    if (d->code != 0) {
        *what = "the range-coded stream does not end on the code that writers leave";
        return NSDF_PARSE_CORRUPT;
    }
    return NSDF_PARSE_OK;
}

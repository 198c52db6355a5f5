#include "nsdf_ref_parts.h"

/* Section 10.5. */

enum { VOTERS = 4, LEVELS = 12, PLACES = 16, NODES = 18 };

typedef struct model {
    uint32_t zero, seen;
} model;

typedef struct range_decoder {
    ref_reader *bytes;
    uint32_t range, code;
} range_decoder;

typedef struct group { /* of planes first to last - 1 */
    const ref_array *array;
    uint32_t first, last, largest;
    uint32_t row_mean, *column_mean;
    int32_t weight[NODES][VOTERS];
    model voter[VOTERS][LEVELS * PLACES][NODES], mantissa[32][4];
} group;

typedef struct contexts { /* of one element, for each voter */
    uint32_t class[VOTERS], sign[VOTERS];
} contexts;

static void normalise(range_decoder *d) {
    while (d->range < 1u << 24) {
        d->range <<= 8;
        d->code = (d->code << 8) + ref_take_uint(d->bytes, 1);
    }
}

static uint32_t squash_entry(uint32_t i) {
    static const uint16_t first[33] = {22,   28,   36,   47,   60,    77,    98,    126,   162,   208,   267,
                                       342,  439,  562,  720,  922,   1179,  1506,  1921,  2446,  3108,  3938,
                                       4971, 6249, 7812, 9702, 11955, 14595, 17625, 21025, 24743, 28693, 32768};
    return i <= 32 ? first[i] : 65536 - first[64 - i];
}

static uint32_t squash(int32_t x) {
    const uint32_t i = (uint32_t)(x + 2048) / 64, f = (uint32_t)(x + 2048) % 64;
    return squash_entry(i) + (squash_entry(i + 1) - squash_entry(i)) * f / 64;
}

/* The specification's definition, by bisection: squash never falls. */
static int32_t stretch(uint32_t step) {
    int32_t low = -2047, high = 2047;
    while (low < high) {
        const int32_t middle = low + (high - low) / 2;
        if (squash(middle) >= 16 * step + 8)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

static void model_update(model *m, uint32_t bit) {
    const uint32_t rate = 65536 / (m->seen + 2);
    m->zero = bit == 0 ? m->zero + (((65536 - m->zero) * rate) >> 16) : m->zero - ((m->zero * rate) >> 16);
    m->seen = m->seen < 254 ? m->seen + 1 : 254;
}

static uint32_t decode_bit(range_decoder *d, uint32_t zero) {
    const uint32_t bound = (d->range >> 16) * zero;
    const uint32_t bit = d->code < bound ? 0 : 1;
    d->code -= bit ? bound : 0;
    d->range = bit ? d->range - bound : bound;
    normalise(d);
    return bit;
}

static int32_t clamp(int32_t x, int32_t limit) {
    return x < -limit ? -limit : x > limit ? limit : x;
}

static uint32_t decode_mixed(range_decoder *d, group *g, const uint32_t chosen[VOTERS], uint32_t node) {
    int32_t vote[VOTERS], sum = 0;
    for (int i = 0; i < VOTERS; i++) {
        const model *m = &g->voter[i][chosen[i]][node];
        vote[i] = stretch(m->zero / 16) * (int32_t)(256 * m->seen / (m->seen + 1)) / 256;
        sum += vote[i] * g->weight[node][i];
    }
    const uint32_t zero = squash(clamp(sum / 65536, 2047));
    const uint32_t bit = decode_bit(d, zero);
    const int32_t error = (bit == 0 ? 65536 : 0) - (int32_t)zero;
    for (int i = 0; i < VOTERS; i++) {
        g->weight[node][i] = clamp(g->weight[node][i] + error * vote[i] / 32768, 262144);
        model_update(&g->voter[i][chosen[i]][node], bit);
    }
    return bit;
}

static uint32_t decode_plain(range_decoder *d, uint32_t count) {
    uint32_t value = 0;
    for (uint32_t i = 0; i < count; i++) {
        d->range >>= 1;
        const uint32_t bit = d->code < d->range ? 0 : 1;
        d->code -= bit ? d->range : 0;
        value = 2 * value + bit;
        normalise(d);
    }
    return value;
}

/* Magnitudes of neighbours, at most 4095. */
static uint32_t near_magnitude(int64_t r) {
    const int64_t m = r < 0 ? -r : r;
    return m > 4095 ? 4095 : (uint32_t)m;
}

static uint32_t level(uint32_t sixteenths) {
    static const uint32_t bounds[LEVELS - 1] = {2, 6, 12, 22, 36, 60, 96, 160, 272, 480, 960};
    uint32_t count = 0;
    for (int i = 0; i < LEVELS - 1; i++)
        count += bounds[i] < sixteenths;
    return count;
}

static uint32_t level_of(int32_t r) {
    return level(16 * near_magnitude(r));
}

static uint32_t sign_of(int32_t r) {
    return r == 0 ? 0 : r > 0 ? 1 : 2;
}

/* The residual `planes` planes, `rows` rows and `cols` columns before; 0 outside of the group. */
static int32_t earlier(const group *g, const uint32_t at[3], uint32_t planes, uint32_t rows, uint32_t cols) {
    const ref_array *a = g->array;
    if (at[0] - g->first < planes || at[1] < rows || at[2] < cols)
        return 0;
    return a->q[((uint64_t)(at[0] - planes) * a->rows + at[1] - rows) * a->cols + at[2] - cols];
}

static contexts find_contexts(const group *g, const uint32_t at[3]) {
    const uint32_t later = at[0] > g->first, place = at[2] < PLACES ? at[2] : PLACES - 1;
    int32_t before[4];
    for (uint32_t i = 0; i < 4; i++)
        before[i] = later ? earlier(g, at, i + 1, 0, 0) : earlier(g, at, 0, i + 1, 0);
    const int32_t above = earlier(g, at, 0, 1, 0), left = earlier(g, at, 0, 0, 1), left4 = earlier(g, at, 0, 0, 4);
    const uint32_t history = level(6 * near_magnitude(before[0]) + 4 * near_magnitude(before[1]) +
                                   3 * near_magnitude(before[2]) + 3 * near_magnitude(before[3]));
    const uint32_t row = level(g->row_mean / 256), column = level(g->column_mean[at[2]] / 256);
    return (contexts){{12 * level_of(before[0]) + level_of(before[1]), 16 * history + place,
                       12 * level_of(left4) + level_of(left), 12 * column + row},
                      {3 * sign_of(before[0]) + sign_of(before[1]), 16 * sign_of(before[0]) + place,
                       3 * level_of(before[0]) + sign_of(before[0]), 3 * sign_of(left4) + sign_of(above)}};
}

static int64_t decode_residual(range_decoder *d, group *g, const contexts *c) {
    uint32_t class = 0;
    while (class < g->largest && decode_mixed(d, g, c->class, 1 + class < 17 ? 1 + class : 17) == 1)
        class += 1;
    if (class == 0)
        return 0;
    const uint32_t negative = decode_mixed(d, g, c->sign, 0);
    const uint32_t below = class - 1, modelled = below < 2 ? below : 2;
    uint32_t node = 1;
    for (uint32_t i = 0; i < modelled; i++) {
        model *m = &g->mantissa[class][node];
        const uint32_t bit = decode_bit(d, m->zero);
        model_update(m, bit);
        node = 2 * node + bit;
    }
    const int64_t magnitude = ((int64_t)node << (below - modelled)) + decode_plain(d, below - modelled);
    return negative ? -magnitude : magnitude;
}

static int64_t decode_element(range_decoder *d, group *g, const uint32_t at[3]) {
    const contexts c = find_contexts(g, at);
    const int64_t r = decode_residual(d, g, &c);
    const uint32_t m = near_magnitude(r) << 12;
    const uint64_t count = (uint64_t)(at[0] - g->first) * g->array->rows + at[1];
    const uint32_t shift = count == 0 ? 0 : count == 1 ? 1 : count <= 5 ? 2 : 3;
    uint32_t *column = &g->column_mean[at[2]];
    g->row_mean = (5 * g->row_mean + 3 * m) >> 3;
    *column = *column - (*column >> shift) + (m >> shift);
    return r;
}

static void start_group(group *g, struct ref_context *ctx, const ref_array *a, uint32_t first, uint32_t last) {
    const model fresh = {.zero = 32768};
    const uint32_t low = ref_bitlength(a->residual_min),
                   high = ref_bitlength(a->residual_min + (INT64_C(1) << a->bits) - 1);
    *g = (group){.array = a, .first = first, .last = last, .largest = low > high ? low : high};
    g->column_mean = ref_allocate(ctx, a->cols, sizeof *g->column_mean);
    for (int n = 0; n < NODES; n++)
        for (int i = 0; i < VOTERS; i++) {
            g->weight[n][i] = 20480;
            for (int k = 0; k < LEVELS * PLACES; k++)
                g->voter[i][k][n] = fresh;
        }
    for (int i = 0; i < 32 * 4; i++)
        g->mantissa[i / 4][i % 4] = fresh;
}

static void decode_group(range_decoder *d, const ref_array *a, uint32_t first, uint32_t last) {
    group g;
    start_group(&g, d->bytes->ctx, a, first, last);
    const int64_t residual_max = a->residual_min + (INT64_C(1) << a->bits) - 1;
    for (uint32_t plane = first; plane < last; plane++)
        for (uint32_t row = 0; row < a->rows; row++)
            for (uint32_t col = 0; col < a->cols; col++) {
                const uint32_t at[3] = {plane, row, col};
                const int64_t r = decode_element(d, &g, at);
                ref_demand(d->bytes, r >= a->residual_min && r <= residual_max, "a residual is out of range");
                a->q[((uint64_t)plane * a->rows + row) * a->cols + col] = (int32_t)r;
            }
}

void ref_decode_range(ref_reader *coded, const ref_part *part) {
    range_decoder d = {.bytes = coded, .range = 0xFFFFFFFFu};
    for (int i = 0; i < 4; i++)
        d.code = (d.code << 8) + ref_take_uint(coded, 1);
    for (uint32_t i = 0; i < part->array_count; i++) {
        const ref_array *a = &part->arrays[i];
        if (!ref_is_stored(a))
            continue;
        const uint32_t split = (a->predict == 1 || a->predict == 2) && a->planes > 1 ? 1 : a->planes;
        decode_group(&d, a, 0, split);
        if (split < a->planes)
            decode_group(&d, a, split, a->planes);
    }
    ref_demand(coded, coded->at == coded->size, "there are bytes behind the range coder's stream");
    ref_demand(coded, d.code == 0, "the range coder does not end on 0");
}

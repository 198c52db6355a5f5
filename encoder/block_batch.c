#include "block_batch.h"

#include <stdlib.h>
#include <string.h>

static size_t cells_of(const nsdf_block_frame *f) {
    return (size_t)f->cells[0] * f->cells[1] * f->cells[2];
}

int nsdf_block_batch_create(nsdf_block_batch *b, uint32_t points, uint32_t blocks, const nsdf_block_frame *frame) {
    const size_t n = (size_t)points + NSDF_HIT_LANES;
    float **arrays[] = {&b->x, &b->y, &b->z, &b->d, &b->sorted[0], &b->sorted[1], &b->sorted[2], &b->weight, &b->value};
    int ok = 1;
    memset(b, 0, sizeof *b);
    b->capacity = points;
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        ok &= (*arrays[i] = calloc(n, sizeof(float))) != NULL;
    b->source = malloc(n * sizeof *b->source);
    b->start = malloc((cells_of(frame) + 2) * sizeof *b->start);
    b->first = malloc(((size_t)blocks + 1) * sizeof *b->first);
    if (ok && b->source && b->start && b->first)
        return 0;
    nsdf_block_batch_free(b);
    return -1;
}

void nsdf_block_batch_free(nsdf_block_batch *b) {
    void *arrays[] = {b->x,         b->y,      b->z,      b->d,      b->sorted[0], b->sorted[1],
                      b->sorted[2], b->weight, b->value,  b->source, b->start,     b->first,
                      b->point,     b->hit[0], b->hit[1], b->hit[2], b->hit[3],    b->hit[4]};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        free(arrays[i]);
    memset(b, 0, sizeof *b);
}

static uint32_t cell_along(const nsdf_block_frame *f, float x, int axis) {
    const float at = (x - f->low[axis]) * f->inverse_cell;
    return !(at > 0.0f) ? 0 : at >= (float)f->cells[axis] ? f->cells[axis] - 1 : (uint32_t)at;
}

static uint32_t cell_at(const nsdf_block_frame *f, float x, float y, float z) {
    return (cell_along(f, z, 2) * f->cells[1] + cell_along(f, y, 1)) * f->cells[0] + cell_along(f, x, 0);
}

/* Counting sort; cells are counted two places ahead and summed one place ahead, so that storing moves every start to
 * where it belongs. */
static void sort_points(nsdf_block_batch *b, const nsdf_block_frame *f) {
    const size_t cells = cells_of(f);
    memset(b->start, 0, (cells + 2) * sizeof *b->start);
    uint32_t *cell = b->point; /* not in use yet */
    for (uint32_t i = 0; i < b->count; i++) {
        cell[i] = cell_at(f, b->x[i], b->y[i], b->z[i]);
        b->start[cell[i] + 2]++;
    }
    for (size_t c = 0; c < cells; c++)
        b->start[c + 2] += b->start[c + 1];
    for (uint32_t i = 0; i < b->count; i++) {
        const uint32_t at = b->start[cell[i] + 1]++;
        b->sorted[0][at] = b->x[i];
        b->sorted[1][at] = b->y[i];
        b->sorted[2][at] = b->z[i];
        b->source[at] = i;
    }
}

static int need_hits(nsdf_block_batch *b, size_t count) {
    int ok = 1;
    if (count <= b->hit_capacity)
        return 0;
    const size_t capacity = count + count / 2;
    uint32_t *point = realloc(b->point, capacity * sizeof *point);
    ok &= point != NULL;
    b->point = point ? point : b->point;
    for (int i = 0; i < NSDF_HIT_ARRAYS; i++) {
        float *hit = realloc(b->hit[i], capacity * sizeof *hit);
        ok &= hit != NULL;
        b->hit[i] = hit ? hit : b->hit[i];
    }
    b->hit_capacity = ok ? capacity : b->hit_capacity;
    return ok ? 0 : -1;
}

/* Whole vectors: hits of the point that is none, where the weight is 0. */
static uint32_t pad(nsdf_block_batch *b, uint32_t at) {
    for (; at % NSDF_HIT_LANES != 0; at++) {
        b->point[at] = b->count;
        for (int i = 0; i < NSDF_HIT_ARRAYS; i++)
            b->hit[i][at] = 0.0f;
    }
    return at;
}

/* Rows of cells along x hold their points side by side. */
static int find_block(nsdf_block_batch *b, const nsdf_block_passes *passes, const nsdf_block_frame *f, uint32_t block,
                      uint32_t *at) {
    const float *reach = f->reach[block];
    uint32_t first[3], last[3];
    for (int axis = 0; axis < 3; axis++) {
        first[axis] = cell_along(f, reach[axis], axis);
        last[axis] = cell_along(f, reach[3 + axis], axis);
    }
    for (uint32_t z = first[2]; z <= last[2]; z++)
        for (uint32_t y = first[1]; y <= last[1]; y++) {
            const uint32_t *start = b->start + (z * f->cells[1] + y) * f->cells[0];
            const uint32_t from = start[first[0]], to = start[last[0] + 1];
            if (need_hits(b, (size_t)*at + (to - from) + NSDF_HIT_LANES) != 0)
                return -1;
            *at = passes->find(b, f->map[block], from, to, *at);
        }
    *at = pad(b, *at);
    return 0;
}

int nsdf_block_batch_find(nsdf_block_batch *b, const nsdf_block_passes *passes, const nsdf_block_frame *frame,
                          uint32_t blocks) {
    uint32_t at = 0;
    if (need_hits(b, 8 * (size_t)b->capacity + NSDF_HIT_LANES) != 0)
        return -1;
    sort_points(b, frame);
    for (uint32_t k = 0; k < blocks; k++) {
        b->first[k] = at;
        if (frame->alive[k] && find_block(b, passes, frame, k, &at) != 0)
            return -1;
    }
    b->first[blocks] = at;
    memset(b->weight, 0, ((size_t)b->count + 1) * sizeof *b->weight);
    memset(b->value, 0, ((size_t)b->count + 1) * sizeof *b->value);
    return 0;
}

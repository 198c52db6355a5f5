/* A grid over the domain: each cell lists the blocks whose boxes it meets, in ascending order. */
#include "blocks.h"

#include <string.h>

typedef struct span {
    uint32_t first[3], last[3]; /* cells, both ends included; first > last when the block meets none */
} span;

static uint32_t cell_of(const nsdf_blocks *b, float x, int axis) {
    const float at = (x - b->low[axis]) * b->inverse_cell[axis];
    return !(at > 0.0f) ? 0 : at >= (float)b->cells[axis] ? b->cells[axis] - 1 : (uint32_t)at;
}

/* Cells at the border of the grid also stand for what is beyond. */
static span cells_of(const nsdf_blocks *b, uint32_t k) {
    span s = {{1, 1, 1}, {0, 0, 0}};
    if (!(b->blocks[k].radius > 0.0f))
        return s;
    const nsdf_block_boxes *boxes = &b->boxes[k / NSDF_BLOCK_GROUP];
    for (int axis = 0; axis < 3; axis++) {
        s.first[axis] = cell_of(b, boxes->low[axis][k % NSDF_BLOCK_GROUP], axis);
        s.last[axis] = cell_of(b, boxes->high[axis][k % NSDF_BLOCK_GROUP], axis);
    }
    return s;
}

static uint64_t cells_in(const span *s) {
    uint64_t count = 1;
    for (int axis = 0; axis < 3; axis++)
        count *= s->first[axis] > s->last[axis] ? 0 : s->last[axis] - s->first[axis] + 1;
    return count;
}

/* Halves the cells until the entries fit; in a grid of one cell they always do. */
static void fit_cells(nsdf_blocks *b) {
    for (;;) {
        uint64_t total = 0;
        for (uint32_t k = 0; k < b->desc->block_count; k++) {
            const span s = cells_of(b, k);
            total += cells_in(&s);
        }
        if (total <= b->entry_capacity)
            return;
        for (int axis = 0; axis < 3; axis++) {
            const uint32_t half = b->cells[axis] > 1 ? b->cells[axis] / 2 : 1;
            b->inverse_cell[axis] *= (float)half / (float)b->cells[axis];
            b->cells[axis] = half;
        }
    }
}

/* Calls for every cell of every block, blocks ascending: counts (entries NULL) or stores. */
static void visit(nsdf_blocks *b, uint32_t *slot, int store) {
    for (uint32_t k = 0; k < b->desc->block_count; k++) {
        const span s = cells_of(b, k);
        for (uint32_t z = s.first[2]; z <= s.last[2]; z++)
            for (uint32_t y = s.first[1]; y <= s.last[1]; y++)
                for (uint32_t x = s.first[0]; x <= s.last[0]; x++) {
                    const size_t cell = ((size_t)z * b->cells[1] + y) * b->cells[0] + x;
                    if (store)
                        b->entries[slot[cell]++] = k;
                    else
                        slot[cell]++;
                }
    }
}

void nsdf_blocks_sort(nsdf_blocks *blocks) {
    fit_cells(blocks);
    const size_t cells = (size_t)blocks->cells[0] * blocks->cells[1] * blocks->cells[2];
    memset(blocks->start, 0, (cells + 1) * sizeof *blocks->start);
    visit(blocks, blocks->start + 1, 0);
    for (size_t i = 0; i < cells; i++)
        blocks->start[i + 1] += blocks->start[i];
    /* Storing moves each cell's start to its end, which is the next one's start: shifted back afterwards. */
    visit(blocks, blocks->start, 1);
    memmove(blocks->start + 1, blocks->start, cells * sizeof *blocks->start);
    blocks->start[0] = 0;
}

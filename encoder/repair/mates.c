#include "repair/mates.h"

#include "weld.h"

#include <stdlib.h>
#include <string.h>

#define EMPTY UINT32_MAX

typedef struct {
    const nsdf_surface *surface;
    const uint32_t *weld;
    uint32_t *slots; /* the first half-edge of each edge */
    size_t count;
} table;

/* Where the edge of a half-edge is, or belongs. */
static uint32_t *find_slot(const table *t, uint32_t half) {
    const uint32_t a = nsdf_half_edge_from(t->surface, t->weld, half), b = nsdf_half_edge_to(t->surface, t->weld, half);
    const uint32_t low = a < b ? a : b, high = a < b ? b : a;
    size_t place = nsdf_hash_mix((uint64_t)low << 32 | high) & (t->count - 1);
    for (;; place = (place + 1) & (t->count - 1)) {
        const uint32_t other = t->slots[place];
        if (other == EMPTY)
            return &t->slots[place];
        const uint32_t c = nsdf_half_edge_from(t->surface, t->weld, other),
                       d = nsdf_half_edge_to(t->surface, t->weld, other);
        if ((c == low && d == high) || (c == high && d == low))
            return &t->slots[place];
    }
}

static void add_half_edge(nsdf_mates *m, const table *t, uint32_t half) {
    uint32_t *slot = find_slot(t, half);
    m->mate[half] = NSDF_MATE_NONE;
    if (*slot == EMPTY) {
        *slot = half;
        return;
    }
    const uint32_t first = *slot, second = m->mate[first];
    if (second == NSDF_MATE_NONE) {
        m->mate[first] = half;
        m->mate[half] = first;
        return;
    }
    if (second != NSDF_MATE_MANY) {
        m->many++;
        m->mate[first] = m->mate[second] = NSDF_MATE_MANY;
    }
    m->mate[half] = NSDF_MATE_MANY;
}

static void count_edges(nsdf_mates *m, const table *t) {
    for (uint32_t h = 0; h < 3 * t->surface->triangle_count; h++) {
        const uint32_t other = m->mate[h];
        m->open += other == NSDF_MATE_NONE;
        if (other < h)
            m->unalike +=
                nsdf_half_edge_from(t->surface, t->weld, h) == nsdf_half_edge_from(t->surface, t->weld, other);
    }
}

int nsdf_mates_find(nsdf_mates *mates, const nsdf_surface *surface, const uint32_t *weld, const uint8_t *skip) {
    const size_t halves = 3 * (size_t)surface->triangle_count;
    table t = {surface, weld, NULL, nsdf_hash_slots(halves)};
    memset(mates, 0, sizeof *mates);
    if (halves > NSDF_MOST_HALF_EDGES)
        return -1;
    t.slots = malloc(t.count * sizeof *t.slots);
    mates->mate = malloc((halves + 1) * sizeof *mates->mate);
    if (!t.slots || !mates->mate) {
        free(t.slots);
        return -1;
    }
    memset(t.slots, 0xff, t.count * sizeof *t.slots);
    for (uint32_t h = 0; h < halves; h++) {
        if (skip[h / 3])
            mates->mate[h] = NSDF_MATE_SKIP;
        else
            add_half_edge(mates, &t, h);
    }
    count_edges(mates, &t);
    free(t.slots);
    return 0;
}

void nsdf_mates_free(nsdf_mates *mates) {
    free(mates->mate);
    memset(mates, 0, sizeof *mates);
}

/* Top-down construction by binned surface area heuristic (Wald 2007), straight into four-wide nodes: a node's range is
 * split in two until it has four parts. */
#include "bvh.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#define BINS 16
#define DEEP 32 /* from here on ranges are halved, which bounds the depth: 32 + log2(2^31) < 64 levels */

/* The fourth numbers fill a register; they mean nothing. */
typedef struct box {
    float low[4], high[4];
} box;

typedef struct item {
    box bounds;
    uint32_t triangle, bin; /* of the split that is being made */
} item;

/* What the items of a range or a bin cover: their bounds, and those of twice their centres. */
typedef struct extent {
    box bounds, centres;
} extent;

typedef struct range {
    uint32_t first, count;
    extent extent;
} range;

typedef struct builder {
    item *items;
    nsdf_bvh *bvh;
    uint32_t node_capacity, leaf_capacity;
    bool failed;
} builder;

static const extent nothing = {
    {{INFINITY, INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY, -INFINITY}},
    {{INFINITY, INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY, -INFINITY}}};

static inline void box_add(box *restrict to, const box *restrict from) {
    NSDF_VECTOR_LOOP
    for (int k = 0; k < 4; k++) {
        to->low[k] = from->low[k] < to->low[k] ? from->low[k] : to->low[k];
        to->high[k] = from->high[k] > to->high[k] ? from->high[k] : to->high[k];
    }
}

static inline void extent_add(extent *restrict to, const extent *restrict from) {
    box_add(&to->bounds, &from->bounds);
    box_add(&to->centres, &from->centres);
}

static inline void extent_add_item(extent *restrict to, const item *restrict from) {
    box centre;
    NSDF_VECTOR_LOOP
    for (int k = 0; k < 4; k++) {
        centre.low[k] = from->bounds.low[k] + from->bounds.high[k];
        centre.high[k] = centre.low[k];
    }
    box_add(&to->bounds, &from->bounds);
    box_add(&to->centres, &centre);
}

static float half_area(const box *b) {
    float x = b->high[0] - b->low[0], y = b->high[1] - b->low[1], z = b->high[2] - b->low[2];
    return x * y + y * z + z * x;
}

static extent extent_of(const item *items, uint32_t count) {
    extent sum = nothing;
    for (uint32_t i = 0; i < count; i++) {
        extent_add_item(&sum, &items[i]);
    }
    return sum;
}

static void swap_items(item *a, item *b) {
    item t = *a;
    *a = *b;
    *b = t;
}

/* ---- Splitting in two ------------------------------------------------------------------------------------ */

typedef struct bin_plan {
    int axis;
    float low, scale;
} bin_plan;

typedef struct bin_set {
    extent extent[BINS];
    uint32_t count[BINS];
} bin_set;

static inline uint32_t bin_of(const bin_plan *plan, const item *i) {
    const float centre = i->bounds.low[plan->axis] + i->bounds.high[plan->axis];
    const int32_t bin = (int32_t)((centre - plan->low) * plan->scale);
    return (uint32_t)(bin < BINS - 1 ? bin : BINS - 1);
}

/* Bins along the axis on which the centres spread most; false when they all coincide. */
static bool plan_bins(const box *centres, bin_plan *plan) {
    float spread = 0.0f;
    for (int k = 0; k < 3; k++) {
        float side = centres->high[k] - centres->low[k];
        if (side > spread) {
            spread = side;
            *plan = (bin_plan){k, centres->low[k], (float)BINS / side};
        }
    }
    return spread > 0.0f && isfinite(plan->scale);
}

static void fill_bins(bin_set *to, item *items, uint32_t count, const bin_plan *plan) {
    for (int b = 0; b < BINS; b++) {
        to->extent[b] = nothing;
        to->count[b] = 0;
    }
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t b = items[i].bin = bin_of(plan, &items[i]);
        extent_add_item(&to->extent[b], &items[i]);
        to->count[b]++;
    }
}

/* The bin that begins the second part: the least sum of area times count.  Of empty bins none is better than the one
 * before. */
static uint32_t best_bin(const bin_set *bins, uint32_t count) {
    float after_cost[BINS];
    box sum = nothing.bounds;
    uint32_t n = 0;
    for (int b = BINS - 1; b > 0; b--) {
        if (bins->count[b] > 0) {
            box_add(&sum, &bins->extent[b].bounds);
            n += bins->count[b];
            after_cost[b] = half_area(&sum) * (float)n;
        } else {
            after_cost[b] = b < BINS - 1 ? after_cost[b + 1] : 0.0f;
        }
    }
    sum = nothing.bounds;
    n = 0;
    uint32_t best = 1;
    float least = INFINITY;
    for (uint32_t b = 1; b < BINS && n + bins->count[b - 1] < count; b++) {
        if (bins->count[b - 1] == 0) {
            continue;
        }
        box_add(&sum, &bins->extent[b - 1].bounds);
        n += bins->count[b - 1];
        float cost = half_area(&sum) * (float)n + after_cost[b];
        if (cost < least) {
            least = cost;
            best = b;
        }
    }
    return best;
}

/* Puts the items of the bins before `limit` first and returns how many they are. */
static uint32_t reorder(item *items, uint32_t count, uint32_t limit) {
    uint32_t first = 0, last = count;
    while (first < last) {
        if (items[first].bin < limit) {
            first++;
        } else {
            swap_items(&items[first], &items[--last]);
        }
    }
    return first;
}

static void halve(const builder *b, const range *whole, range parts[2]) {
    const uint32_t n = whole->count / 2;
    const item *items = &b->items[whole->first];
    parts[0] = (range){whole->first, n, extent_of(items, n)};
    parts[1] = (range){whole->first + n, whole->count - n, extent_of(items + n, whole->count - n)};
}

/* Neither part is empty.  What a part covers is what its bins cover. */
static void split(builder *b, const range *whole, bool in_halves, range parts[2]) {
    bin_plan plan = {0, 0.0f, 0.0f}; /* set by plan_bins, which not every compiler sees */
    item *items = &b->items[whole->first];
    uint32_t first = 0, limit = 0;
    bin_set bins;
    if (!in_halves && plan_bins(&whole->extent.centres, &plan)) {
        fill_bins(&bins, items, whole->count, &plan);
        limit = best_bin(&bins, whole->count);
        first = reorder(items, whole->count, limit);
    }
    if (first == 0 || first == whole->count) {
        halve(b, whole, parts);
        return;
    }
    parts[0] = (range){whole->first, first, nothing};
    parts[1] = (range){whole->first + first, whole->count - first, nothing};
    for (uint32_t bin = 0; bin < BINS; bin++) {
        extent_add(&parts[bin < limit ? 0 : 1].extent, &bins.extent[bin]);
    }
}

/* ---- Nodes ----------------------------------------------------------------------------------------------- */

/* Splits the range into up to four, always the one with the largest box among those too large for a leaf. */
static int split_range(builder *b, range parts[NSDF_BVH_WIDTH], bool in_halves) {
    int count = 1;
    while (count < NSDF_BVH_WIDTH) {
        int chosen = -1;
        float largest = -1.0f;
        for (int i = 0; i < count; i++) {
            float area = half_area(&parts[i].extent.bounds);
            if (parts[i].count > NSDF_BVH_WIDTH && area > largest) {
                largest = area;
                chosen = i;
            }
        }
        if (chosen < 0) {
            break;
        }
        range two[2];
        split(b, &parts[chosen], in_halves, two);
        parts[chosen] = two[0];
        parts[count++] = two[1];
    }
    return count;
}

/* Room for one more element; NULL when memory ran out. */
static void *grow(void *array, uint32_t count, uint32_t *capacity, size_t size) {
    if (count < *capacity) {
        return array;
    }
    uint32_t wanted = *capacity + *capacity / 2 + 64;
    void *larger = realloc(array, wanted * size);
    if (larger != NULL) {
        *capacity = wanted;
    }
    return larger;
}

static uint32_t add_leaf(builder *b, const range *part) {
    nsdf_bvh_leaf *leaves = grow(b->bvh->leaves, b->bvh->leaf_count, &b->leaf_capacity, sizeof *leaves);
    if (leaves == NULL) {
        b->failed = true;
        return NSDF_BVH_NONE;
    }
    b->bvh->leaves = leaves;
    nsdf_bvh_leaf *leaf = &leaves[b->bvh->leaf_count];
    for (uint32_t i = 0; i < NSDF_BVH_WIDTH; i++) {
        leaf->triangle[i] = i < part->count ? b->items[part->first + i].triangle : NSDF_BVH_NONE;
    }
    return NSDF_BVH_LEAF | b->bvh->leaf_count++;
}

static uint32_t add_node(builder *b) {
    nsdf_bvh_node *nodes = grow(b->bvh->nodes, b->bvh->node_count, &b->node_capacity, sizeof *nodes);
    if (nodes == NULL) {
        b->failed = true;
        return NSDF_BVH_NONE;
    }
    b->bvh->nodes = nodes;
    nsdf_bvh_node *node = &nodes[b->bvh->node_count];
    for (int i = 0; i < NSDF_BVH_WIDTH; i++) {
        node->child[i] = NSDF_BVH_NONE;
        for (int k = 0; k < 3; k++) {
            node->low[k][i] = INFINITY;
            node->high[k][i] = -INFINITY;
        }
    }
    return b->bvh->node_count++;
}

static uint32_t build_node(builder *b, const range *whole, int depth) {
    uint32_t number = add_node(b);
    range parts[NSDF_BVH_WIDTH] = {*whole};
    int count = split_range(b, parts, depth >= DEEP);
    for (int i = 0; i < count && !b->failed; i++) {
        uint32_t child =
            parts[i].count <= NSDF_BVH_WIDTH ? add_leaf(b, &parts[i]) : build_node(b, &parts[i], depth + 1);
        if (b->failed) {
            return NSDF_BVH_NONE;
        }
        nsdf_bvh_node *node = &b->bvh->nodes[number];
        node->child[i] = child;
        for (int k = 0; k < 3; k++) {
            node->low[k][i] = parts[i].extent.bounds.low[k];
            node->high[k][i] = parts[i].extent.bounds.high[k];
        }
    }
    return number;
}

static item make_item(const nsdf_surface *surface, uint32_t triangle) {
    item result = {nothing.bounds, triangle, 0};
    for (int corner = 0; corner < 3; corner++) {
        const float *xyz = &surface->positions[3 * (size_t)surface->indices[3 * (size_t)triangle + (size_t)corner]];
        const box point = {{xyz[0], xyz[1], xyz[2], 0.0f}, {xyz[0], xyz[1], xyz[2], 0.0f}};
        box_add(&result.bounds, &point);
    }
    return result;
}

int nsdf_bvh_build(nsdf_bvh *bvh, const nsdf_surface *surface) {
    uint32_t count = surface->triangle_count;
    builder b = {malloc(count * sizeof *b.items), bvh, 0, 0, false};
    *bvh = (nsdf_bvh){0};
    if (b.items == NULL) {
        return -1;
    }
    for (uint32_t i = 0; i < count; i++) {
        b.items[i] = make_item(surface, i);
    }
    range whole = {0, count, extent_of(b.items, count)};
    (void)build_node(&b, &whole, 0);
    free(b.items);
    if (b.failed) {
        nsdf_bvh_free(bvh);
        return -1;
    }
    return 0;
}

void nsdf_bvh_free(nsdf_bvh *bvh) {
    free(bvh->nodes);
    free(bvh->leaves);
    *bvh = (nsdf_bvh){0};
}

/* Top-down construction by binned surface area heuristic (Wald 2007), straight into four-wide nodes: a node's range is
 * split in two until it has four parts. */
#include "bvh.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define BINS 16
#define DEEP 32 /* from here on ranges are halved, which bounds the depth: 32 + log2(2^31) < 64 levels */

typedef struct box {
    float low[3], high[3];
} box;

typedef struct item {
    box bounds;
    uint32_t triangle;
} item;

typedef struct range {
    uint32_t first, count;
    box bounds;
} range;

typedef struct builder {
    item *items;
    nsdf_bvh *bvh;
    uint32_t node_capacity, leaf_capacity;
    bool failed;
} builder;

static const box empty_box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void box_add(box *to, const box *from) {
    for (int k = 0; k < 3; k++) {
        to->low[k] = from->low[k] < to->low[k] ? from->low[k] : to->low[k];
        to->high[k] = from->high[k] > to->high[k] ? from->high[k] : to->high[k];
    }
}

static float half_area(const box *b) {
    float x = b->high[0] - b->low[0], y = b->high[1] - b->low[1], z = b->high[2] - b->low[2];
    return x * y + y * z + z * x;
}

/* Twice the centre, on one axis. */
static float centre(const item *i, int axis) {
    return i->bounds.low[axis] + i->bounds.high[axis];
}

static box bounds_of(const item *items, uint32_t count) {
    box bounds = empty_box;
    for (uint32_t i = 0; i < count; i++) {
        box_add(&bounds, &items[i].bounds);
    }
    return bounds;
}

static void swap_items(item *a, item *b) {
    item t = *a;
    *a = *b;
    *b = t;
}

typedef struct bin_plan {
    int axis;
    float low, scale;
} bin_plan;

static uint32_t bin_of(const bin_plan *plan, const item *i) {
    uint32_t bin = (uint32_t)((centre(i, plan->axis) - plan->low) * plan->scale);
    return bin < BINS - 1 ? bin : BINS - 1;
}

/* Bins along the axis on which the centres spread most; false when they all coincide. */
static bool plan_bins(const item *items, uint32_t count, bin_plan *plan) {
    box centres = empty_box;
    for (uint32_t i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++) {
            float c = centre(&items[i], k);
            centres.low[k] = c < centres.low[k] ? c : centres.low[k];
            centres.high[k] = c > centres.high[k] ? c : centres.high[k];
        }
    }
    float spread = 0.0f;
    for (int k = 0; k < 3; k++) {
        float extent = centres.high[k] - centres.low[k];
        if (extent > spread) {
            spread = extent;
            *plan = (bin_plan){k, centres.low[k], (float)BINS / extent};
        }
    }
    return spread > 0.0f && isfinite(plan->scale);
}

/* The bin that begins the second part: the least sum of area times count. */
static uint32_t best_bin(const item *items, uint32_t count, const bin_plan *plan) {
    box bounds[BINS];
    uint32_t counts[BINS] = {0};
    float after_cost[BINS];
    for (int b = 0; b < BINS; b++) {
        bounds[b] = empty_box;
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t b = bin_of(plan, &items[i]);
        box_add(&bounds[b], &items[i].bounds);
        counts[b]++;
    }
    box sum = empty_box;
    uint32_t n = 0;
    for (int b = BINS - 1; b > 0; b--) {
        box_add(&sum, &bounds[b]);
        n += counts[b];
        after_cost[b] = n > 0 ? half_area(&sum) * (float)n : 0.0f;
    }
    sum = empty_box;
    n = 0;
    uint32_t best = 1;
    float least = INFINITY;
    for (uint32_t b = 1; b < BINS; b++) {
        box_add(&sum, &bounds[b - 1]);
        n += counts[b - 1];
        float cost = n > 0 ? half_area(&sum) * (float)n + after_cost[b] : INFINITY;
        if (n > 0 && n < count && cost < least) {
            least = cost;
            best = b;
        }
    }
    return best;
}

/* Reorders the items and returns how many go to the first part: at least one, never all. */
static uint32_t partition(item *items, uint32_t count, bool halve) {
    bin_plan plan = {0, 0.0f, 0.0f}; /* set by plan_bins, which not every compiler sees */
    if (halve || !plan_bins(items, count, &plan)) {
        return count / 2;
    }
    uint32_t limit = best_bin(items, count, &plan), first = 0, last = count;
    while (first < last) {
        if (bin_of(&plan, &items[first]) < limit) {
            first++;
        } else {
            swap_items(&items[first], &items[--last]);
        }
    }
    return first > 0 && first < count ? first : count / 2;
}

/* Splits the range into up to four, always the one with the largest box among those too large for a leaf. */
static int split_range(builder *b, range parts[NSDF_BVH_WIDTH], bool halve) {
    int count = 1;
    while (count < NSDF_BVH_WIDTH) {
        int chosen = -1;
        float largest = -1.0f;
        for (int i = 0; i < count; i++) {
            float area = half_area(&parts[i].bounds);
            if (parts[i].count > NSDF_BVH_WIDTH && area > largest) {
                largest = area;
                chosen = i;
            }
        }
        if (chosen < 0) {
            break;
        }
        range *whole = &parts[chosen];
        item *items = &b->items[whole->first];
        uint32_t n = partition(items, whole->count, halve);
        parts[count++] = (range){whole->first + n, whole->count - n, bounds_of(items + n, whole->count - n)};
        *whole = (range){whole->first, n, bounds_of(items, n)};
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
            node->low[k][i] = parts[i].bounds.low[k];
            node->high[k][i] = parts[i].bounds.high[k];
        }
    }
    return number;
}

static item make_item(const nsdf_surface *surface, uint32_t triangle) {
    item result = {empty_box, triangle};
    for (int corner = 0; corner < 3; corner++) {
        const float *xyz = &surface->positions[3 * (size_t)surface->indices[3 * (size_t)triangle + (size_t)corner]];
        box point;
        memcpy(point.low, xyz, sizeof point.low);
        memcpy(point.high, xyz, sizeof point.high);
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
    range whole = {0, count, bounds_of(b.items, count)};
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

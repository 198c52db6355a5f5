#include "nearest.h"

#include <math.h>
#include <stdbool.h>

#include "triangle.h"

#define PI 3.141592653589793
#define LANES NSDF_BVH_WIDTH
#define CANDIDATES 32

typedef struct search {
    const nsdf_nearest_index *index;
    float point[3];
    float least2;  /* least squared distance seen, in single precision */
    float bound2;  /* what is farther than this cannot be the nearest */
    float enough2; /* what is nearer than this ends the search */
    uint32_t count;
    uint32_t triangle[CANDIDATES];
    float distance2[CANDIDATES];
    nsdf_nearest result;
} search;

static float bound_for(const nsdf_nearest_index *index, float distance) {
    float reach = distance * 1.000002f + index->slack;
    return reach * reach;
}

static double sign_weight(const nsdf_triangle *triangle, const nsdf_triangle_hit *hit) {
    switch (hit->feature) {
    case NSDF_HIT_FACE:
        return 2.0 * PI;
    case NSDF_HIT_EDGE:
        return PI;
    default:
        return nsdf_triangle_angle(triangle, hit->corner);
    }
}

static bool is_same_point(const nsdf_nearest_index *index, nsdf_vec3 a, nsdf_vec3 b) {
    nsdf_vec3 d = nsdf_vec3_sub(a, b);
    return fabs(d.x) <= index->same_point && fabs(d.y) <= index->same_point && fabs(d.z) <= index->same_point;
}

static void resolve(search *s, uint32_t triangle) {
    nsdf_triangle t = nsdf_triangle_load(s->index->surface, triangle);
    nsdf_triangle_hit hit = nsdf_triangle_nearest(&t, nsdf_vec3_load(s->point));
    nsdf_nearest *r = &s->result;
    nsdf_vec3 normal = {0.0, 0.0, 0.0};
    if (s->index->has_say != NULL && s->index->has_say[triangle]) {
        normal = nsdf_vec3_scale(sign_weight(&t, &hit) / nsdf_vec3_length(hit.cross), hit.cross);
    }
    bool tie = r->distance2 < INFINITY && is_same_point(s->index, hit.point, r->point);
    nsdf_vec3 sum = tie ? nsdf_vec3_add(r->normal, normal) : normal;
    if (hit.distance2 < r->distance2) {
        *r = (nsdf_nearest){hit.point, hit.offset, sum, hit.distance2};
    } else if (tie) {
        r->normal = sum;
    }
}

/* Forgets the candidates that have fallen behind. */
static void drop_far_candidates(search *s) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < s->count; i++) {
        if (s->distance2[i] <= s->bound2) {
            s->triangle[kept] = s->triangle[i];
            s->distance2[kept++] = s->distance2[i];
        }
    }
    s->count = kept;
}

static void resolve_candidates(search *s) {
    drop_far_candidates(s);
    for (uint32_t i = 0; i < s->count; i++) {
        resolve(s, s->triangle[i]);
    }
    s->count = 0;
}

static void add_candidate(search *s, uint32_t triangle, float distance2) {
    if (distance2 < s->least2) {
        s->least2 = distance2;
        s->bound2 = bound_for(s->index, sqrtf(distance2));
    }
    if (s->count == CANDIDATES) {
        drop_far_candidates(s);
    }
    if (s->count == CANDIDATES) {
        resolve_candidates(s);
    }
    s->triangle[s->count] = triangle;
    s->distance2[s->count++] = distance2;
}

static inline float clamp_unit(float t) {
    t = t > 0.0f ? t : 0.0f;
    return t < 1.0f ? t : 1.0f;
}

static inline float min_float(float a, float b) {
    return a < b ? a : b;
}

static void packet_distances(const nsdf_packet *restrict p, const float *restrict point, float *restrict distance2) {
    const float px = point[0], py = point[1], pz = point[2];
    NSDF_VECTOR_LOOP
    for (int i = 0; i < LANES; i++) {
        float dx = px - p->origin[0][i], dy = py - p->origin[1][i], dz = pz - p->origin[2][i];
        float x = p->axis[0][0][i] * dx + p->axis[0][1][i] * dy + p->axis[0][2][i] * dz;
        float y = p->axis[1][0][i] * dx + p->axis[1][1][i] * dy + p->axis[1][2][i] * dz;
        float z = p->axis[2][0][i] * dx + p->axis[2][1][i] * dy + p->axis[2][2][i] * dz;
        float bx = p->bx[i], cx = p->cx[i], cy = p->cy[i], gx = cx - bx, xb = x - bx;

        float ab = x > 0.0f ? x : 0.0f;
        ab = x - (ab < bx ? ab : bx);
        float t = clamp_unit((x * cx + y * cy) * p->inverse_ac[i]);
        float acx = x - t * cx, acy = y - t * cy;
        float s = clamp_unit((xb * gx + y * cy) * p->inverse_bc[i]);
        float bcx = xb - s * gx, bcy = y - s * cy;
        float outside = min_float(ab * ab + y * y, min_float(acx * acx + acy * acy, bcx * bcx + bcy * bcy));

        /* Above the inside when on the left of all three edges: the least of the three tells. */
        float inside = min_float(y, min_float(cy * x - cx * y, gx * y - cy * xb));
        float share = inside > 0.0f ? 0.0f : 1.0f;
        distance2[i] = z * z + share * outside;
    }
}

static void visit_leaf(search *s, uint32_t leaf) {
    float distance2[LANES];
    const uint32_t *triangle = s->index->bvh.leaves[leaf].triangle;
    packet_distances(&s->index->packets[leaf], s->point, distance2);
    for (int i = 0; i < LANES; i++) {
        if (distance2[i] <= s->bound2 && triangle[i] != NSDF_BVH_NONE) {
            add_candidate(s, triangle[i], distance2[i]);
        }
    }
}

typedef struct waiting {
    uint32_t child;
    float distance2;
} waiting;

/* How far x is from the interval. */
static inline float outside_of(float low, float x, float high) {
    float below = low - x, above = x - high;
    float side = below > above ? below : above;
    return side > 0.0f ? side : 0.0f;
}

static void box_distances(const nsdf_bvh_node *restrict node, const float *restrict point, float *restrict distance2) {
    const float px = point[0], py = point[1], pz = point[2];
    NSDF_VECTOR_LOOP
    for (int i = 0; i < LANES; i++) {
        float x = outside_of(node->low[0][i], px, node->high[0][i]);
        float y = outside_of(node->low[1][i], py, node->high[1][i]);
        float z = outside_of(node->low[2][i], pz, node->high[2][i]);
        distance2[i] = x * x + y * y + z * z;
    }
}

/* Puts the children within the bound on the stack, the nearest last. */
static int visit_node(const search *s, const nsdf_bvh_node *node, waiting *stack, int top) {
    float distance2[LANES];
    box_distances(node, s->point, distance2);
    int bottom = top;
    for (int i = 0; i < LANES; i++) {
        if (distance2[i] <= s->bound2 && node->child[i] != NSDF_BVH_NONE) {
            int place = top++;
            for (; place > bottom && stack[place - 1].distance2 < distance2[i]; place--) {
                stack[place] = stack[place - 1];
            }
            stack[place] = (waiting){node->child[i], distance2[i]};
        }
    }
    return top;
}

static void walk(search *s) {
    waiting stack[NSDF_BVH_STACK];
    int top = 1;
    stack[0] = (waiting){0, 0.0f};
    while (top > 0 && !(s->least2 < s->enough2)) {
        waiting next = stack[--top];
        if (next.distance2 > s->bound2) {
            continue;
        }
        if (next.child & NSDF_BVH_LEAF) {
            visit_leaf(s, next.child & ~NSDF_BVH_LEAF);
        } else {
            top = visit_node(s, &s->index->bvh.nodes[next.child], stack, top);
        }
    }
}

static void begin(search *s, const nsdf_nearest_index *index, const float point[3], float limit) {
    s->index = index;
    for (int k = 0; k < 3; k++) {
        s->point[k] = point[k];
    }
    s->least2 = INFINITY;
    s->bound2 = bound_for(index, limit);
    s->enough2 = 0.0f;
    s->count = 0;
    s->result.distance2 = INFINITY;
}

nsdf_nearest nsdf_find_nearest(const nsdf_nearest_index *index, const float point[3], float limit) {
    search s;
    begin(&s, index, point, limit);
    walk(&s);
    resolve_candidates(&s);
    return s.result;
}

bool nsdf_is_anything_nearer(const nsdf_nearest_index *index, const float point[3], float limit) {
    const float sure = (limit - index->slack) * 0.999998f; /* with its rounding error still nearer */
    search s;
    begin(&s, index, point, limit);
    s.enough2 = sure > 0.0f ? sure * sure : 0.0f;
    walk(&s);
    if (s.least2 < s.enough2) {
        return true;
    }
    resolve_candidates(&s);
    return (float)sqrt(s.result.distance2) < limit;
}

#include <math.h>
#include <stdlib.h>

#include "nearest.h"
#include "triangle.h"
#include "weld.h"

static double reciprocal_or_zero(double x) {
    return x > 0.0 ? 1.0 / x : 0.0;
}

/* Any unit vector at right angles to a unit vector. */
static nsdf_vec3 perpendicular(nsdf_vec3 u) {
    nsdf_vec3 other = fabs(u.x) < 0.6 ? (nsdf_vec3){1.0, 0.0, 0.0} : (nsdf_vec3){0.0, 1.0, 0.0};
    nsdf_vec3 v = nsdf_vec3_cross(u, other);
    return nsdf_vec3_scale(1.0 / nsdf_vec3_length(v), v);
}

static int longest_edge(const nsdf_triangle *t) {
    int longest = 0;
    double length2 = -1.0;
    for (int i = 0; i < 3; i++) {
        nsdf_vec3 edge = nsdf_vec3_sub(t->corner[(i + 1) % 3], t->corner[i]);
        if (nsdf_vec3_dot(edge, edge) > length2) {
            length2 = nsdf_vec3_dot(edge, edge);
            longest = i;
        }
    }
    return longest;
}

static void store_lane(float to[3][NSDF_BVH_WIDTH], int lane, nsdf_vec3 v) {
    to[0][lane] = (float)v.x;
    to[1][lane] = (float)v.y;
    to[2][lane] = (float)v.z;
}

static void fill_lane(nsdf_packet *p, int lane, const nsdf_triangle *t) {
    int first = longest_edge(t);
    nsdf_vec3 a = t->corner[first];
    nsdf_vec3 ab = nsdf_vec3_sub(t->corner[(first + 1) % 3], a), ac = nsdf_vec3_sub(t->corner[(first + 2) % 3], a);
    nsdf_vec3 normal = nsdf_triangle_cross(t);
    double length = nsdf_vec3_length(ab), area = nsdf_vec3_length(normal);
    nsdf_vec3 x = length > 0.0 ? nsdf_vec3_scale(1.0 / length, ab) : (nsdf_vec3){1.0, 0.0, 0.0};
    nsdf_vec3 z = area > 0.0 ? nsdf_vec3_scale(1.0 / area, normal) : perpendicular(x);
    nsdf_vec3 y = nsdf_vec3_cross(z, x);
    double cx = nsdf_vec3_dot(ac, x), cy = area > 0.0 ? nsdf_vec3_dot(ac, y) : 0.0;
    store_lane(p->origin, lane, a);
    store_lane(p->axis[0], lane, x);
    store_lane(p->axis[1], lane, y);
    store_lane(p->axis[2], lane, z);
    p->bx[lane] = (float)length;
    p->cx[lane] = (float)cx;
    p->cy[lane] = (float)cy;
    p->inverse_ac[lane] = (float)reciprocal_or_zero(cx * cx + cy * cy);
    p->inverse_bc[lane] = (float)reciprocal_or_zero((cx - length) * (cx - length) + cy * cy);
}

/* Unused lanes repeat the first triangle. */
static void fill_packet(nsdf_packet *p, const nsdf_surface *surface, const nsdf_bvh_leaf *leaf) {
    for (int lane = 0; lane < NSDF_BVH_WIDTH; lane++) {
        uint32_t triangle = leaf->triangle[lane] != NSDF_BVH_NONE ? leaf->triangle[lane] : leaf->triangle[0];
        nsdf_triangle t = nsdf_triangle_load(surface, triangle);
        fill_lane(p, lane, &t);
    }
}

/* All triangles with an area but those that lie on one before. */
static int find_say(nsdf_nearest_index *index) {
    const nsdf_surface *surface = index->surface;
    uint32_t *weld = malloc((size_t)surface->vertex_count * sizeof *weld);
    int result = -1;
    index->has_say = malloc((size_t)surface->triangle_count * sizeof *index->has_say);
    if (weld != NULL && index->has_say != NULL && nsdf_weld_vertices(surface, weld) == 0 &&
        nsdf_find_repeated_triangles(surface, weld, index->has_say) == 0) {
        for (uint32_t i = 0; i < surface->triangle_count; i++) {
            nsdf_triangle t = nsdf_triangle_load(surface, i);
            index->has_say[i] = !index->has_say[i] && nsdf_triangle_has_area(&t);
        }
        result = 0;
    }
    free(weld);
    return result;
}

static float largest_coordinate(const nsdf_bvh_node *root) {
    float largest = 0.0f;
    for (int i = 0; i < NSDF_BVH_WIDTH && root->child[i] != NSDF_BVH_NONE; i++) {
        for (int k = 0; k < 3; k++) {
            largest = fmaxf(largest, fmaxf(fabsf(root->low[k][i]), fabsf(root->high[k][i])));
        }
    }
    return largest;
}

int nsdf_nearest_index_build(nsdf_nearest_index *index, const nsdf_surface *surface, bool normals) {
    *index = (nsdf_nearest_index){.surface = surface};
    if (nsdf_bvh_build(&index->bvh, surface) != 0) {
        return -1;
    }
    index->packets = malloc(index->bvh.leaf_count * sizeof *index->packets);
    if (index->packets == NULL || (normals && find_say(index) != 0)) {
        return -1;
    }
    for (uint32_t i = 0; i < index->bvh.leaf_count; i++) {
        fill_packet(&index->packets[i], surface, &index->bvh.leaves[i]);
    }
    float largest = largest_coordinate(&index->bvh.nodes[0]);
    index->slack = 1e-6f * largest;
    index->same_point = 1e-11 * (double)largest;
    return 0;
}

void nsdf_nearest_index_free(nsdf_nearest_index *index) {
    nsdf_bvh_free(&index->bvh);
    free(index->packets);
    free(index->has_say);
    *index = (nsdf_nearest_index){0};
}

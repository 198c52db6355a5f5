#include "winding.h"

#include <float.h>
#include <stdbool.h>
#include <stdlib.h>

#include "triangle.h"

#define FOUR_PI 12.566370614359172
#define ACCURACY 2.0 /* beta of Barill et al.: dipoles serve from this many radii on */

typedef struct moments {
    double area;
    nsdf_vec3 area_centre; /* area times centre */
    nsdf_vec3 normal;      /* area times normal */
} moments;

static void add_moments(moments *to, const moments *from) {
    to->area += from->area;
    to->area_centre = nsdf_vec3_add(to->area_centre, from->area_centre);
    to->normal = nsdf_vec3_add(to->normal, from->normal);
}

static moments leaf_moments(const nsdf_surface *surface, const nsdf_bvh_leaf *leaf) {
    moments sum = {0};
    for (int i = 0; i < NSDF_BVH_WIDTH && leaf->triangle[i] != NSDF_BVH_NONE; i++) {
        nsdf_triangle t = nsdf_triangle_load(surface, leaf->triangle[i]);
        nsdf_vec3 normal = nsdf_vec3_scale(0.5, nsdf_triangle_cross(&t));
        nsdf_vec3 corners = nsdf_vec3_add(nsdf_vec3_add(t.corner[0], t.corner[1]), t.corner[2]);
        double area = nsdf_vec3_length(normal);
        moments one = {area, nsdf_vec3_scale(area / 3.0, corners), normal};
        add_moments(&sum, &one);
    }
    return sum;
}

/* Distance from the centre to the farthest corner of the child's box. */
static double child_radius(const nsdf_bvh_node *node, int child, const double centre[3]) {
    double square = 0.0;
    for (int k = 0; k < 3; k++) {
        double side = fmax(centre[k] - (double)node->low[k][child], (double)node->high[k][child] - centre[k]);
        square += side * side;
    }
    return sqrt(square);
}

static void set_dipole(nsdf_dipoles *dipoles, int child, const nsdf_bvh_node *node, const moments *m) {
    double centre[3] = {m->area_centre.x, m->area_centre.y, m->area_centre.z};
    const double normal[3] = {m->normal.x, m->normal.y, m->normal.z};
    for (int k = 0; k < 3; k++) {
        double middle = 0.5 * ((double)node->low[k][child] + (double)node->high[k][child]);
        centre[k] = m->area > 0.0 ? centre[k] / m->area : middle;
        dipoles->centre[k][child] = (float)centre[k];
        dipoles->moment[k][child] = (float)(normal[k] / FOUR_PI);
    }
    double reach = ACCURACY * child_radius(node, child, centre);
    dipoles->reach2[child] = (float)(reach * reach);
}

static int build_dipoles(nsdf_dipoles *dipoles, const nsdf_bvh *bvh, const nsdf_surface *surface) {
    moments *sums = calloc(bvh->node_count, sizeof *sums);
    if (sums == NULL) {
        return -1;
    }
    /* Children have higher numbers than their parents. */
    for (uint32_t n = bvh->node_count; n-- > 0;) {
        const nsdf_bvh_node *node = &bvh->nodes[n];
        for (int i = 0; i < NSDF_BVH_WIDTH && node->child[i] != NSDF_BVH_NONE; i++) {
            uint32_t child = node->child[i];
            moments m =
                child & NSDF_BVH_LEAF ? leaf_moments(surface, &bvh->leaves[child & ~NSDF_BVH_LEAF]) : sums[child];
            set_dipole(&dipoles[n], i, node, &m);
            add_moments(&sums[n], &m);
        }
    }
    free(sums);
    return 0;
}

static void copy_corners(nsdf_leaf_corners *to, const nsdf_surface *surface, const nsdf_bvh_leaf *leaf) {
    for (int i = 0; i < NSDF_BVH_WIDTH; i++) {
        bool used = leaf->triangle[i] != NSDF_BVH_NONE;
        const uint32_t *index = &surface->indices[3 * (size_t)leaf->triangle[used ? i : 0]];
        for (int corner = 0; corner < 3; corner++) {
            const float *xyz = &surface->positions[3 * (size_t)index[used ? corner : 0]];
            for (int k = 0; k < 3; k++) {
                to->corner[corner][k][i] = xyz[k];
            }
        }
    }
}

int nsdf_winding_build(nsdf_winding *winding, const nsdf_bvh *bvh, const nsdf_surface *surface) {
    winding->dipoles = calloc(bvh->node_count, sizeof *winding->dipoles);
    winding->leaves = malloc(bvh->leaf_count * sizeof *winding->leaves);
    if (winding->dipoles == NULL || winding->leaves == NULL) {
        return -1;
    }
    for (uint32_t i = 0; i < bvh->leaf_count; i++) {
        copy_corners(&winding->leaves[i], surface, &bvh->leaves[i]);
    }
    return build_dipoles(winding->dipoles, bvh, surface);
}

void nsdf_winding_free(nsdf_winding *winding) {
    free(winding->dipoles);
    free(winding->leaves);
    *winding = (nsdf_winding){0};
}

/* Half the solid angle of each triangle is the angle of x + i y (van Oosterom & Strackee 1983). */
static void half_angles(const nsdf_leaf_corners *restrict leaf, const float *restrict point, float *restrict x,
                        float *restrict y) {
    const float px = point[0], py = point[1], pz = point[2];
    NSDF_VECTOR_LOOP
    for (int i = 0; i < NSDF_BVH_WIDTH; i++) {
        float ax = leaf->corner[0][0][i] - px, ay = leaf->corner[0][1][i] - py, az = leaf->corner[0][2][i] - pz;
        float bx = leaf->corner[1][0][i] - px, by = leaf->corner[1][1][i] - py, bz = leaf->corner[1][2][i] - pz;
        float cx = leaf->corner[2][0][i] - px, cy = leaf->corner[2][1][i] - py, cz = leaf->corner[2][2][i] - pz;
        float a = sqrtf(ax * ax + ay * ay + az * az), b = sqrtf(bx * bx + by * by + bz * bz);
        float c = sqrtf(cx * cx + cy * cy + cz * cz);
        float ab = ax * bx + ay * by + az * bz, bc = bx * cx + by * cy + bz * cz, ca = cx * ax + cy * ay + cz * az;
        float volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
        float scale = 1.0f / (a * b * c + FLT_MIN);
        x[i] = (a * b * c + ab * c + bc * a + ca * b) * scale;
        y[i] = volume * scale;
    }
}

/* Angles below pi / 4, four of which cannot go round, are added by multiplying: one arc tangent instead of four. */
static double leaf_winding(const nsdf_leaf_corners *leaf, const float point[3]) {
    float x[NSDF_BVH_WIDTH], y[NSDF_BVH_WIDTH], real = 1.0f, imaginary = 0.0f, sum = 0.0f;
    half_angles(leaf, point, x, y);
    for (int i = 0; i < NSDF_BVH_WIDTH; i++) {
        if (x[i] > fabsf(y[i])) {
            float previous = real;
            real = previous * x[i] - imaginary * y[i];
            imaginary = previous * y[i] + imaginary * x[i];
        } else {
            sum += atan2f(y[i], x[i]);
        }
    }
    return (double)(sum + atan2f(imaginary, real)) * (2.0 / FOUR_PI);
}

/* The contribution of each child's dipole, and the square of its distance. */
static void evaluate_dipoles(const nsdf_dipoles *restrict d, const float *restrict point, float *restrict value,
                             float *restrict distance2) {
    const float px = point[0], py = point[1], pz = point[2];
    NSDF_VECTOR_LOOP
    for (int i = 0; i < NSDF_BVH_WIDTH; i++) {
        float x = d->centre[0][i] - px, y = d->centre[1][i] - py, z = d->centre[2][i] - pz;
        float square = x * x + y * y + z * z;
        float flux = d->moment[0][i] * x + d->moment[1][i] * y + d->moment[2][i] * z;
        distance2[i] = square;
        value[i] = flux / (square * sqrtf(square));
    }
}

double nsdf_winding_number(const nsdf_winding *winding, const nsdf_bvh *bvh, const float point[3]) {
    uint32_t stack[NSDF_BVH_STACK] = {0};
    int waiting = 1;
    double sum = 0.0;
    while (waiting > 0) {
        uint32_t number = stack[--waiting];
        const nsdf_bvh_node *node = &bvh->nodes[number];
        float value[NSDF_BVH_WIDTH], distance2[NSDF_BVH_WIDTH];
        evaluate_dipoles(&winding->dipoles[number], point, value, distance2);
        for (int i = 0; i < NSDF_BVH_WIDTH && node->child[i] != NSDF_BVH_NONE; i++) {
            if (distance2[i] > winding->dipoles[number].reach2[i]) {
                sum += (double)value[i];
            } else if (node->child[i] & NSDF_BVH_LEAF) {
                sum += leaf_winding(&winding->leaves[node->child[i] & ~NSDF_BVH_LEAF], point);
            } else {
                stack[waiting++] = node->child[i];
            }
        }
    }
    return sum;
}

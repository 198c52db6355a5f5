#include "sdf.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "nearest.h"
#include "winding.h"

struct nsdf_sdf {
    nsdf_nearest_index index;
    nsdf_winding winding;
    nsdf_sign_rule rule;
    nsdf_sdf *whole; /* gives the signs, if not NULL */
};

/* What a distance function is able to answer. */
enum { DISTANCES = 1, NORMALS = 2, WINDING = 4 };

static int build(nsdf_sdf *sdf, const nsdf_surface *surface, int parts) {
    int failed = parts & DISTANCES ? nsdf_nearest_index_build(&sdf->index, surface, (parts & NORMALS) != 0)
                                   : nsdf_bvh_build(&sdf->index.bvh, surface);
    if (failed == 0 && (parts & WINDING)) {
        failed = nsdf_winding_build(&sdf->winding, &sdf->index.bvh, surface);
    }
    return failed;
}

static nsdf_sdf *create(const nsdf_surface *surface, nsdf_sign_rule rule, int parts) {
    nsdf_sdf *sdf = surface->triangle_count > 0 ? calloc(1, sizeof *sdf) : NULL;
    if (sdf == NULL) {
        return NULL;
    }
    sdf->rule = rule;
    if (build(sdf, surface, parts) != 0) {
        nsdf_sdf_free(sdf);
        return NULL;
    }
    return sdf;
}

nsdf_sdf *nsdf_sdf_create(const nsdf_surface *surface, nsdf_sign_rule rule) {
    return create(surface, rule, DISTANCES | (rule == NSDF_SIGN_WINDING ? WINDING : NORMALS));
}

nsdf_sdf *nsdf_sdf_create_unsigned(const nsdf_surface *surface) {
    return create(surface, NSDF_SIGN_PSEUDO_NORMAL, DISTANCES);
}

nsdf_sdf *nsdf_sdf_create_winding(const nsdf_surface *surface) {
    return create(surface, NSDF_SIGN_WINDING, WINDING);
}

nsdf_sdf *nsdf_sdf_create_union(const nsdf_surface *outer, const nsdf_surface *whole) {
    nsdf_sdf *sdf = create(outer, NSDF_SIGN_WINDING, DISTANCES);
    if (sdf == NULL) {
        return NULL;
    }
    sdf->whole = nsdf_sdf_create_winding(whole);
    if (sdf->whole == NULL) {
        nsdf_sdf_free(sdf);
        return NULL;
    }
    return sdf;
}

void nsdf_sdf_free(nsdf_sdf *sdf) {
    if (sdf != NULL) {
        nsdf_sdf_free(sdf->whole);
        nsdf_nearest_index_free(&sdf->index);
        nsdf_winding_free(&sdf->winding);
        free(sdf);
    }
}

float nsdf_sdf_unsigned(const nsdf_sdf *sdf, const float point[3], float limit, float nearest[3]) {
    nsdf_nearest found = nsdf_find_nearest(&sdf->index, point, limit);
    float distance = (float)sqrt(found.distance2);
    if (!(distance < limit)) {
        return limit;
    }
    if (nearest != NULL) {
        nearest[0] = (float)found.point.x;
        nearest[1] = (float)found.point.y;
        nearest[2] = (float)found.point.z;
    }
    return distance;
}

bool nsdf_sdf_is_within(const nsdf_sdf *sdf, const float point[3], float limit) {
    return nsdf_is_anything_nearer(&sdf->index, point, limit);
}

static double winding_at(const nsdf_sdf *sdf, const float point[3]) {
    if (sdf->whole != NULL) {
        return winding_at(sdf->whole, point);
    }
    return nsdf_winding_number(&sdf->winding, &sdf->index.bvh, point);
}

float nsdf_sdf_winding(const nsdf_sdf *sdf, const float point[3]) {
    return (float)winding_at(sdf, point);
}

static bool is_inside(const nsdf_sdf *sdf, const float point[3], const nsdf_nearest *found) {
    if (sdf->rule == NSDF_SIGN_WINDING) {
        return winding_at(sdf, point) > 0.5;
    }
    return nsdf_vec3_dot(found->normal, found->offset) < 0.0;
}

float nsdf_sdf_distance_below(const nsdf_sdf *sdf, const float point[3], float upper) {
    nsdf_nearest found = nsdf_find_nearest(&sdf->index, point, upper);
    if (!(found.distance2 < INFINITY) && upper < INFINITY) {
        found = nsdf_find_nearest(&sdf->index, point, INFINITY);
    }
    float distance = (float)sqrt(found.distance2);
    return is_inside(sdf, point, &found) ? -distance : distance;
}

float nsdf_sdf_distance(const nsdf_sdf *sdf, const float point[3]) {
    return nsdf_sdf_distance_below(sdf, point, INFINITY);
}

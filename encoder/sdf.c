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

nsdf_sdf *nsdf_sdf_create(const nsdf_surface *surface, nsdf_sign_rule rule) {
    nsdf_sdf *sdf = surface->triangle_count > 0 ? calloc(1, sizeof *sdf) : NULL;
    if (sdf == NULL) {
        return NULL;
    }
    sdf->rule = rule;
    if (nsdf_nearest_index_build(&sdf->index, surface) != 0 ||
        nsdf_winding_build(&sdf->winding, &sdf->index.bvh, surface) != 0) {
        nsdf_sdf_free(sdf);
        return NULL;
    }
    return sdf;
}

nsdf_sdf *nsdf_sdf_create_union(const nsdf_surface *outer, const nsdf_surface *whole) {
    nsdf_sdf *sdf = nsdf_sdf_create(outer, NSDF_SIGN_WINDING);
    if (sdf == NULL) {
        return NULL;
    }
    sdf->whole = nsdf_sdf_create(whole, NSDF_SIGN_WINDING);
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

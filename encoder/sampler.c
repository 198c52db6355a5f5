#include "sampler.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "sampler_rejection.h"
#include "surface_sample.h"

#define BOX_MARGIN 0.1f /* of the frame's box, on every side */
#define MAX_TRIES 64    /* draws of one displaced point before it is put on the domain's boundary */

void nsdf_sampler_defaults(nsdf_sampler_params *params) {
    *params = (nsdf_sampler_params){.kind = NSDF_SAMPLER_NEAR,
                                    .count = 0,
                                    .domain_min = {-0.5f, -0.5f, -0.5f},
                                    .domain_max = {0.5f, 0.5f, 0.5f},
                                    .d_half = 0.01f,
                                    .noise = {0.002f, 0.006f, 0.02f},
                                    .noise_share = {0.35f, 0.30f, 0.20f},
                                    .frame_box_share = 0.10f,
                                    .domain_share = 0.05f};
}

static void store(nsdf_sample_set *set, size_t i, const float xyz[3], float distance) {
    set->x[i] = xyz[0];
    set->y[i] = xyz[1];
    set->z[i] = xyz[2];
    set->d[i] = distance;
}

static bool is_in_domain(const nsdf_sampler_params *params, const float xyz[3]) {
    bool in = true;
    for (int k = 0; k < 3; k++) {
        in = in && xyz[k] >= params->domain_min[k] && xyz[k] <= params->domain_max[k];
    }
    return in;
}

static void clamp_to_domain(const nsdf_sampler_params *params, float xyz[3]) {
    for (int k = 0; k < 3; k++) {
        xyz[k] = fminf(fmaxf(xyz[k], params->domain_min[k]), params->domain_max[k]);
    }
}

/* The frame's box with its margin, as far as it lies in the domain. */
static void frame_box(const nsdf_surface *surface, const nsdf_sampler_params *params, float low[3], float high[3]) {
    for (size_t k = 0; k < 3; k++) {
        float least = INFINITY, most = -INFINITY;
        for (size_t i = 0; i < 3 * (size_t)surface->triangle_count; i++) {
            float x = surface->positions[3 * (size_t)surface->indices[i] + k];
            least = fminf(least, x);
            most = fmaxf(most, x);
        }
        low[k] = least - BOX_MARGIN * (most - least);
        high[k] = most + BOX_MARGIN * (most - least);
    }
    clamp_to_domain(params, low);
    clamp_to_domain(params, high);
}

static void fill_uniform(const nsdf_sdf *sdf, const float low[3], const float high[3], nsdf_random *random,
                         nsdf_sample_set *set, size_t first, size_t end) {
    for (size_t i = first; i < end; i++) {
        float xyz[3];
        nsdf_random_in_box(random, low, high, xyz);
        store(set, i, xyz, nsdf_sdf_distance(sdf, xyz));
    }
}

/* A point of one of `shares` parts of the surface displaced by normal noise, inside the domain; returns how far it
 * went. */
static float draw_displaced(const nsdf_area_table *table, size_t share, size_t shares,
                            const nsdf_sampler_params *params, float width, nsdf_random *random, float xyz[3]) {
    float moved2 = 0.0f;
    for (int tries = 0; tries < MAX_TRIES; tries++) {
        (void)nsdf_area_table_draw_share(table, share, shares, random, xyz);
        moved2 = 0.0f;
        for (int k = 0; k < 3; k++) {
            float step = width * nsdf_random_normal(random);
            xyz[k] += step;
            moved2 += step * step;
        }
        if (is_in_domain(params, xyz)) {
            return sqrtf(moved2);
        }
    }
    clamp_to_domain(params, xyz);
    return INFINITY;
}

/* In the order of the triangles, along the surface: what a search reads is then mostly what the last one read. */
static void fill_displaced(const nsdf_sdf *sdf, const nsdf_area_table *table, const nsdf_sampler_params *params,
                           float width, nsdf_random *random, nsdf_sample_set *set, size_t first, size_t end) {
    for (size_t i = first; i < end; i++) {
        float xyz[3];
        float moved = draw_displaced(table, i - first, end - first, params, width, random, xyz);
        store(set, i, xyz, nsdf_sdf_distance_below(sdf, xyz, moved));
    }
}

/* Where each part of the set ends: three widths of noise, the frame's box, the domain.  Shares are rounded. */
static void part_ends(const nsdf_sampler_params *p, size_t ends[5]) {
    double displaced = 1.0 - (double)p->frame_box_share - (double)p->domain_share, noise = 0.0, sum = 0.0;
    for (int i = 0; i < 3; i++) {
        noise += (double)p->noise_share[i];
    }
    for (int i = 0; i < 5; i++) {
        double share = i == 3 ? (double)p->frame_box_share : (double)p->domain_share;
        if (i < 3) {
            share = noise > 0.0 ? displaced * (double)p->noise_share[i] / noise : displaced / 3.0;
        }
        sum += share;
        double end = floor(fmin(fmax(sum, 0.0), 1.0) * (double)p->count + 0.5);
        ends[i] = (size_t)end < p->count ? (size_t)end : p->count;
    }
    ends[4] = p->count;
}

static int fill_near(const nsdf_sdf *sdf, const nsdf_surface *surface, const nsdf_sampler_params *params,
                     nsdf_random *random, nsdf_sample_set *set) {
    size_t ends[5], first = 0;
    float low[3], high[3];
    nsdf_area_table table = {0};
    part_ends(params, ends);
    if (ends[2] > 0 && nsdf_area_table_create(&table, surface) != 0) {
        return -1;
    }
    for (int i = 0; i < 3; i++) {
        fill_displaced(sdf, &table, params, params->noise[i], random, set, first, ends[i]);
        first = ends[i];
    }
    nsdf_area_table_free(&table);
    frame_box(surface, params, low, high);
    fill_uniform(sdf, low, high, random, set, ends[2], ends[3]);
    fill_uniform(sdf, params->domain_min, params->domain_max, random, set, ends[3], ends[4]);
    return 0;
}

static void swap(float *array, size_t i, size_t j) {
    float t = array[i];
    array[i] = array[j];
    array[j] = t;
}

static void shuffle(nsdf_sample_set *set, nsdf_random *random) {
    for (size_t i = set->count; i > 1; i--) {
        size_t j = nsdf_random_below(random, (uint32_t)i);
        swap(set->x, i - 1, j);
        swap(set->y, i - 1, j);
        swap(set->z, i - 1, j);
        swap(set->d, i - 1, j);
    }
}

int nsdf_sample_set_create(nsdf_sample_set *set, size_t count) {
    size_t size = count < UINT32_MAX ? (count + 1) * sizeof(float) : 0;
    *set = (nsdf_sample_set){0};
    if (size == 0) {
        return -1;
    }
    set->x = malloc(size);
    set->y = malloc(size);
    set->z = malloc(size);
    set->d = malloc(size);
    set->count = count;
    return set->x != NULL && set->y != NULL && set->z != NULL && set->d != NULL ? 0 : -1;
}

int nsdf_sample_set_copy(const nsdf_sample_set *from, nsdf_sample_set *to) {
    const size_t size = from->count * sizeof(float);
    if (nsdf_sample_set_create(to, from->count) != 0) {
        return -1;
    }
    if (size > 0) {
        memcpy(to->x, from->x, size);
        memcpy(to->y, from->y, size);
        memcpy(to->z, from->z, size);
        memcpy(to->d, from->d, size);
    }
    return 0;
}

int nsdf_sample_frame(const nsdf_sdf *sdf, const nsdf_surface *surface, const nsdf_sampler_params *params,
                      nsdf_random *random, nsdf_sample_set *set) {
    int result = nsdf_sample_set_create(set, params->count);
    if (result == 0) {
        result = params->kind == NSDF_SAMPLER_REJECTION ? nsdf_fill_by_rejection(sdf, surface, params, random, set)
                                                        : fill_near(sdf, surface, params, random, set);
    }
    if (result != 0) {
        nsdf_sample_set_free(set);
        return -1;
    }
    shuffle(set, random);
    return 0;
}

void nsdf_sample_set_free(nsdf_sample_set *set) {
    if (set != NULL) {
        free(set->x);
        free(set->y);
        free(set->z);
        free(set->d);
        *set = (nsdf_sample_set){0};
    }
}

#include "repair/sides.h"

#include "triangle.h"
#include "winding.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Points where winding numbers are looked at: so many in all, by area, and at least one on each patch; to see what is
 * around an open patch fewer, since it is taken off by itself. */
enum { SAMPLES = 3000, VOTES = 24, ROUNDS = 5, MOST_TERMS = 400000 };
static const double step_off = 1e-4; /* from the surface to its sides, normalised */
/* Around an open patch, as a share of its size. */
static const double reach = 0.25;
/* A patch is inside out below this mean; the votes that turn an open patch. */
static const double inside_out = -0.2, undecided_below = 0.4, vote_margin = 0.15;

typedef struct {
    nsdf_patches *patches;
    const nsdf_surface *surface;
    nsdf_surface live; /* triangles in patches that count, turned; the surface's positions */
    nsdf_bvh bvh;
    nsdf_winding winding;
    uint32_t *counts; /* [patch]: scratch */
    uint32_t *first;  /* [patch + 1]: where its triangles begin */
    uint32_t *list;   /* triangles, patch by patch */
} look;

static void free_look(look *l) {
    free(l->live.indices);
    nsdf_bvh_free(&l->bvh);
    nsdf_winding_free(&l->winding);
    free(l->counts);
    free(l->first);
    free(l->list);
}

static int counts_in(const nsdf_patches *p, uint32_t triangle) {
    return p->of[triangle] != NSDF_NO_PATCH && !p->patches[p->of[triangle]].is_inner;
}

static void list_by_patch(look *l) {
    const nsdf_patches *p = l->patches;
    memset(l->first, 0, ((size_t)p->count + 2) * sizeof *l->first);
    for (uint32_t i = 0; i < l->surface->triangle_count; i++)
        if (p->of[i] != NSDF_NO_PATCH)
            l->first[p->of[i] + 1]++;
    for (uint32_t i = 0; i < p->count; i++)
        l->first[i + 1] += l->first[i];
    memset(l->counts, 0, p->count * sizeof *l->counts);
    for (uint32_t i = 0; i < l->surface->triangle_count; i++)
        if (p->of[i] != NSDF_NO_PATCH)
            l->list[l->first[p->of[i]] + l->counts[p->of[i]]++] = i;
}

static int create_look(look *l, nsdf_patches *patches, const nsdf_surface *surface) {
    const size_t n = (size_t)surface->triangle_count + 1, m = (size_t)patches->count + 2;
    memset(l, 0, sizeof *l);
    l->patches = patches;
    l->surface = surface;
    l->live = *surface;
    l->live.indices = malloc(3 * n * sizeof *l->live.indices);
    l->counts = malloc(m * sizeof *l->counts);
    l->first = malloc(m * sizeof *l->first);
    l->list = malloc(n * sizeof *l->list);
    if (!l->live.indices || !l->counts || !l->first || !l->list)
        return -1;
    list_by_patch(l);
    return 0;
}

/* The winding numbers of the patches as they face now. */
static int refresh(look *l) {
    nsdf_bvh_free(&l->bvh);
    nsdf_winding_free(&l->winding);
    l->live.triangle_count = 0;
    for (uint32_t i = 0; i < l->surface->triangle_count; i++)
        if (counts_in(l->patches, i))
            nsdf_turned_corners(l->patches, l->surface, i, l->live.indices + 3 * (size_t)l->live.triangle_count++);
    if (l->live.triangle_count == 0)
        return 0;
    return nsdf_bvh_build(&l->bvh, &l->live) == 0 && nsdf_winding_build(&l->winding, &l->bvh, &l->live) == 0 ? 0 : -1;
}

static double winding_at(const look *l, nsdf_vec3 x) {
    const float point[3] = {(float)x.x, (float)x.y, (float)x.z};
    return nsdf_winding_number(&l->winding, &l->bvh, point);
}

static nsdf_triangle load_turned(const look *l, uint32_t triangle) {
    uint32_t corners[3];
    nsdf_triangle t;
    nsdf_turned_corners(l->patches, l->surface, triangle, corners);
    for (int k = 0; k < 3; k++)
        t.corner[k] = nsdf_vec3_load(l->surface->positions + 3 * (size_t)corners[k]);
    return t;
}

static nsdf_vec3 middle_of(const nsdf_triangle *t) {
    return nsdf_vec3_scale(1.0 / 3.0, nsdf_vec3_add(nsdf_vec3_add(t->corner[0], t->corner[1]), t->corner[2]));
}

/* ---- The mean on a patch -------------------------------------------------------------------------------- */

/* Evenly by area, in the order of the triangles. */
static void measure_patch(look *l, uint32_t number, double whole) {
    nsdf_patch *patch = &l->patches->patches[number];
    const double wanted = 1.0 + floor(SAMPLES * patch->area / whole);
    double covered = 0.0, sum = 0.0, taken = 0.0;
    for (uint32_t k = l->first[number]; k < l->first[number + 1]; k++) {
        const nsdf_triangle t = load_turned(l, l->list[k]);
        const nsdf_vec3 normal = nsdf_triangle_normal(&t), x = middle_of(&t);
        covered += 0.5 * nsdf_vec3_length(nsdf_triangle_cross(&t));
        if (!(covered * wanted >= (taken + 0.5) * patch->area) || !(patch->area > 0.0))
            continue;
        const double here = 0.5 * (winding_at(l, nsdf_vec3_mad(x, step_off, normal)) +
                                   winding_at(l, nsdf_vec3_mad(x, -step_off, normal)));
        const double before = taken;
        taken = floor(covered * wanted / patch->area + 0.5);
        sum += (taken - before) * here;
    }
    patch->inside = taken > 0.0 ? sum / taken : 0.0;
}

static void measure(look *l) {
    double whole = 0.0;
    for (uint32_t i = 0; i < l->patches->count; i++)
        whole += l->patches->patches[i].area;
    for (uint32_t i = 0; i < l->patches->count; i++)
        if (!l->patches->patches[i].is_inner)
            measure_patch(l, i, whole);
}

/* ---- Turning -------------------------------------------------------------------------------------------- */

/* Winding number of one triangle (van Oosterom & Strackee 1983). */
static double triangle_winding(const nsdf_triangle *t, nsdf_vec3 x) {
    nsdf_vec3 v[3];
    double length[3];
    for (int k = 0; k < 3; k++) {
        v[k] = nsdf_vec3_sub(t->corner[k], x);
        length[k] = nsdf_vec3_length(v[k]);
    }
    const double volume = nsdf_vec3_dot(v[0], nsdf_vec3_cross(v[1], v[2]));
    const double scale = length[0] * length[1] * length[2] + nsdf_vec3_dot(v[0], v[1]) * length[2] +
                         nsdf_vec3_dot(v[1], v[2]) * length[0] + nsdf_vec3_dot(v[2], v[0]) * length[1];
    return 2.0 * atan2(volume, scale) / 12.566370614359172;
}

static double winding_of_others(const look *l, uint32_t number, nsdf_vec3 x) {
    double w = winding_at(l, x);
    for (uint32_t k = l->first[number]; k < l->first[number + 1]; k++) {
        const nsdf_triangle t = load_turned(l, l->list[k]);
        w -= triangle_winding(&t, x);
    }
    return w;
}

/* What is around an open patch closes it to one side: how much more of the others is behind it than before it. */
static double vote(const look *l, uint32_t number) {
    const nsdf_patch *patch = &l->patches->patches[number];
    const double off = reach * sqrt(patch->area);
    uint32_t votes = MOST_TERMS / patch->triangles;
    votes = votes > VOTES ? VOTES : votes < 1 ? 1 : votes;
    votes = votes > patch->triangles ? patch->triangles : votes;
    double sum = 0.0;
    for (uint32_t i = 0; i < votes; i++) {
        const uint64_t at = ((uint64_t)2 * i + 1) * patch->triangles / (2 * votes);
        const nsdf_triangle t = load_turned(l, l->list[l->first[number] + at]);
        const nsdf_vec3 normal = nsdf_triangle_normal(&t), x = middle_of(&t);
        sum += winding_of_others(l, number, nsdf_vec3_mad(x, -off, normal)) -
               winding_of_others(l, number, nsdf_vec3_mad(x, off, normal));
    }
    return sum / votes;
}

/* Returns how many patches it turned. */
static uint32_t turn_patches(look *l) {
    nsdf_patches *p = l->patches;
    uint32_t several = 0, turned = 0;
    for (uint32_t i = 0; i < p->count; i++)
        several += !p->patches[i].is_inner;
    for (uint32_t i = 0; i < p->count; i++) {
        nsdf_patch *patch = &p->patches[i];
        if (patch->is_inner)
            continue;
        const int undecided = fabs(patch->inside) < undecided_below && several > 1;
        l->counts[i] = patch->inside < inside_out || (undecided && vote(l, i) < -vote_margin);
        turned += l->counts[i];
    }
    for (uint32_t i = 0; i < p->count && turned; i++)
        if (!p->patches[i].is_inner && l->counts[i]) {
            p->patches[i].turned ^= 1;
            p->patches[i].volume = -p->patches[i].volume;
        }
    return turned;
}

int nsdf_find_sides(nsdf_patches *patches, const nsdf_surface *surface) {
    look l;
    int failed = create_look(&l, patches, surface) != 0 || refresh(&l) != 0;
    for (int round = 0; !failed && round < ROUNDS && l.live.triangle_count > 0; round++) {
        measure(&l);
        if (round + 1 == ROUNDS || turn_patches(&l) == 0)
            break;
        failed = refresh(&l) != 0;
    }
    free_look(&l);
    return failed ? -1 : 0;
}

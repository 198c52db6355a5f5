/* Uniform points in the domain, kept with probability exp(-k |d|).  Taken literally that asks for millions of
 * distances when d_half is small.  Here the domain is cut into cells first, finer near the surface.  Distances change
 * by no more than one moves, so the distance at a cell's centre bounds the probability in all of it by some q.  A cell
 * is chosen by volume times q, and a uniform point in it kept with probability exp(-k |d|) / q: the same distribution,
 * with few points turned away.
 *
 * Where even the smallest cells are much thicker than d_half and MAX_TRIES points in a row are turned away, the sample
 * is a surface point moved along its triangle's normal by a Laplace-distributed step: exp(-k |d|) is that distribution
 * where d_half is small against everything else. */
#include "sampler_rejection.h"

#include <stdbool.h>
#include <stdlib.h>

#include "surface_sample.h"
#include "triangle.h"

#define COARSE 4        /* cells along each side of the domain to begin with */
#define MAX_CELLS 60000 /* no more are split from then on */
#define MAX_TRIES 64

typedef struct cell {
    float centre[3];
    float bound; /* least distance to the surface anywhere in the cell */
    int level;   /* sides are those of the coarse cells over 2^level */
} cell;

typedef struct cells {
    cell *items;
    size_t count, capacity;
    float half[3]; /* of a coarse cell */
    double k;
} cells;

static float radius_of(const cells *c, int level) {
    float scale = ldexpf(1.0f, -level);
    return scale * sqrtf(c->half[0] * c->half[0] + c->half[1] * c->half[1] + c->half[2] * c->half[2]);
}

static cell make_cell(const cells *c, const nsdf_sdf *sdf, const float centre[3], int level) {
    float distance = fabsf(nsdf_sdf_distance(sdf, centre));
    float bound = fmaxf(distance - radius_of(c, level), 0.0f);
    return (cell){{centre[0], centre[1], centre[2]}, bound, level};
}

static int add_coarse_cells(cells *c, const nsdf_sdf *sdf, const nsdf_sampler_params *params) {
    c->capacity = COARSE * COARSE * COARSE;
    c->items = malloc(c->capacity * sizeof *c->items);
    if (c->items == NULL) {
        return -1;
    }
    for (int k = 0; k < 3; k++) {
        c->half[k] = (params->domain_max[k] - params->domain_min[k]) / (2.0f * COARSE);
    }
    for (; c->count < c->capacity; c->count++) {
        const size_t place[3] = {c->count % COARSE, c->count / COARSE % COARSE, c->count / (COARSE * COARSE)};
        float centre[3];
        for (int k = 0; k < 3; k++) {
            centre[k] = params->domain_min[k] + (float)(2 * place[k] + 1) * c->half[k];
        }
        c->items[c->count] = make_cell(c, sdf, centre, 0);
    }
    return 0;
}

/* Puts the first of the eight parts in the cell's place and the others at the end. */
static int split_cell(cells *c, const nsdf_sdf *sdf, size_t which) {
    if (c->count + 7 > c->capacity) {
        cell *larger = realloc(c->items, 2 * (c->capacity + 7) * sizeof *larger);
        if (larger == NULL) {
            return -1;
        }
        c->items = larger;
        c->capacity = 2 * (c->capacity + 7);
    }
    cell whole = c->items[which];
    for (int part = 0; part < 8; part++) {
        float centre[3];
        for (int k = 0; k < 3; k++) {
            float step = ldexpf(c->half[k], -whole.level - 1);
            centre[k] = whole.centre[k] + (part >> k & 1 ? step : -step);
        }
        c->items[part == 0 ? which : c->count++] = make_cell(c, sdf, centre, whole.level + 1);
    }
    return 0;
}

/* Splits, level by level, the cells in which the probability may vary much and is not negligible. */
static int refine(cells *c, const nsdf_sdf *sdf) {
    for (int level = 0; c->k * (double)radius_of(c, level) > 0.5; level++) {
        size_t count = c->count;
        bool any = false;
        for (size_t i = 0; i < count; i++) {
            const cell *item = &c->items[i];
            if (item->level != level || c->k * (double)item->bound > 6.0) {
                continue;
            }
            if (c->count >= MAX_CELLS) {
                return 0;
            }
            if (split_cell(c, sdf, i) != 0) {
                return -1;
            }
            any = true;
        }
        if (!any) {
            return 0;
        }
    }
    return 0;
}

/* Cumulated volume times bound of the probability, relative to the largest bound. */
static double *sum_weights(const cells *c) {
    double *sums = malloc(c->count * sizeof *sums), sum = 0.0;
    float nearest = INFINITY;
    for (size_t i = 0; i < c->count; i++) {
        nearest = fminf(nearest, c->items[i].bound);
    }
    for (size_t i = 0; sums != NULL && i < c->count; i++) {
        const cell *item = &c->items[i];
        sum += ldexp(exp(-c->k * (double)(item->bound - nearest)), -3 * item->level);
        sums[i] = sum;
    }
    return sums;
}

static void clamp_to_domain(const nsdf_sampler_params *params, float xyz[3]) {
    for (int k = 0; k < 3; k++) {
        xyz[k] = fminf(fmaxf(xyz[k], params->domain_min[k]), params->domain_max[k]);
    }
}

/* Returns whether a point was kept. */
static bool draw_from_cells(const cells *c, const double *sums, const nsdf_sdf *sdf, const nsdf_sampler_params *params,
                            nsdf_random *random, float xyz[3], float *distance) {
    for (int tries = 0; tries < MAX_TRIES; tries++) {
        double at = nsdf_random_unit32(random) * sums[c->count - 1];
        const cell *chosen = &c->items[nsdf_first_above(sums, c->count, at)];
        float low[3], high[3];
        for (int k = 0; k < 3; k++) {
            float half = ldexpf(c->half[k], -chosen->level);
            low[k] = chosen->centre[k] - half;
            high[k] = chosen->centre[k] + half;
        }
        nsdf_random_in_box(random, low, high, xyz);
        clamp_to_domain(params, xyz); /* cells reach beyond it by rounding */
        *distance = nsdf_sdf_distance(sdf, xyz);
        if (exp(-c->k * (double)(fabsf(*distance) - chosen->bound)) > nsdf_random_unit32(random)) {
            return true;
        }
    }
    return false;
}

/* Step of density k/2 exp(-k |step|). */
static double draw_laplace(double k, nsdf_random *random) {
    double size = -log(1.0 - nsdf_random_unit32(random)) / k;
    return nsdf_random_u32(random) & 1 ? size : -size;
}

static void draw_from_surface(const nsdf_area_table *table, double k, nsdf_random *random, float xyz[3]) {
    uint32_t triangle = nsdf_area_table_draw(table, random, xyz);
    nsdf_triangle t = nsdf_triangle_load(table->surface, triangle);
    nsdf_vec3 cross = nsdf_triangle_cross(&t);
    double step = draw_laplace(k, random) / nsdf_vec3_length(cross);
    xyz[0] += (float)(step * cross.x);
    xyz[1] += (float)(step * cross.y);
    xyz[2] += (float)(step * cross.z);
}

static void fill_set(const cells *c, const double *sums, const nsdf_area_table *table, const nsdf_sdf *sdf,
                     const nsdf_sampler_params *params, nsdf_random *random, nsdf_sample_set *set) {
    for (size_t i = 0; i < set->count; i++) {
        float xyz[3], distance;
        if (!draw_from_cells(c, sums, sdf, params, random, xyz, &distance) && table->sums != NULL) {
            draw_from_surface(table, c->k, random, xyz);
            clamp_to_domain(params, xyz);
            distance = nsdf_sdf_distance(sdf, xyz);
        }
        set->x[i] = xyz[0];
        set->y[i] = xyz[1];
        set->z[i] = xyz[2];
        set->d[i] = distance;
    }
}

int nsdf_fill_by_rejection(const nsdf_sdf *sdf, const nsdf_surface *surface, const nsdf_sampler_params *params,
                           nsdf_random *random, nsdf_sample_set *set) {
    cells c = {.k = 0.6931471805599453 / fmax((double)params->d_half, 1e-12)};
    nsdf_area_table table = {0};
    double *sums = NULL;
    int result = -1;
    /* A surface without area leaves the table empty. */
    (void)nsdf_area_table_create(&table, surface);
    if (add_coarse_cells(&c, sdf, params) == 0 && refine(&c, sdf) == 0 && (sums = sum_weights(&c)) != NULL) {
        fill_set(&c, sums, &table, sdf, params, random, set);
        result = 0;
    }
    nsdf_area_table_free(&table);
    free(sums);
    free(c.items);
    return result;
}

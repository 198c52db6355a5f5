#include "surface_sample.h"

#include <stdlib.h>

#include "sampler.h"
#include "triangle.h"

int nsdf_area_table_create(nsdf_area_table *table, const nsdf_surface *surface) {
    double *sums = malloc(((size_t)surface->triangle_count + 1) * sizeof *sums), sum = 0.0;
    if (sums == NULL) {
        return -1;
    }
    for (uint32_t i = 0; i < surface->triangle_count; i++) {
        nsdf_triangle triangle = nsdf_triangle_load(surface, i);
        sum += 0.5 * nsdf_vec3_length(nsdf_triangle_cross(&triangle));
        sums[i] = sum;
    }
    *table = (nsdf_area_table){surface, sums};
    if (!(sum > 0.0)) {
        nsdf_area_table_free(table);
        return -1;
    }
    return 0;
}

void nsdf_area_table_free(nsdf_area_table *table) {
    free(table->sums);
    table->sums = NULL;
}

size_t nsdf_first_above(const double *sums, size_t count, double value) {
    size_t low = 0, high = count - 1;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (sums[middle] > value) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    return low;
}

/* A point of the triangle, uniform by area. */
static void draw_in_triangle(const nsdf_surface *surface, uint32_t triangle, nsdf_random *random, float xyz[3]) {
    nsdf_triangle t = nsdf_triangle_load(surface, triangle);
    double root = sqrt(nsdf_random_unit32(random)), v = root * nsdf_random_unit32(random);
    nsdf_vec3 point = nsdf_vec3_scale(1.0 - root, t.corner[0]);
    point = nsdf_vec3_mad(point, root - v, t.corner[1]);
    point = nsdf_vec3_mad(point, v, t.corner[2]);
    xyz[0] = (float)point.x;
    xyz[1] = (float)point.y;
    xyz[2] = (float)point.z;
}

uint32_t nsdf_area_table_draw(const nsdf_area_table *table, nsdf_random *random, float xyz[3]) {
    size_t count = table->surface->triangle_count;
    double total = table->sums[count - 1];
    uint32_t chosen = (uint32_t)nsdf_first_above(table->sums, count, nsdf_random_unit32(random) * total);
    draw_in_triangle(table->surface, chosen, random, xyz);
    return chosen;
}

uint32_t nsdf_area_table_draw_share(const nsdf_area_table *table, size_t share, size_t shares, nsdf_random *random,
                                    float xyz[3]) {
    size_t count = table->surface->triangle_count;
    double place = ((double)share + nsdf_random_unit32(random)) / (double)shares;
    uint32_t chosen = (uint32_t)nsdf_first_above(table->sums, count, place * table->sums[count - 1]);
    draw_in_triangle(table->surface, chosen, random, xyz);
    return chosen;
}

int nsdf_sample_surface(const nsdf_surface *surface, size_t count, nsdf_random *random, float *xyz) {
    nsdf_area_table table;
    if (nsdf_area_table_create(&table, surface) != 0) {
        return -1;
    }
    for (size_t i = 0; i < count; i++) {
        (void)nsdf_area_table_draw_share(&table, i, count, random, &xyz[3 * i]);
    }
    nsdf_area_table_free(&table);
    return 0;
}

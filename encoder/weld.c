#include "weld.h"

#include <stdlib.h>
#include <string.h>

#include "triangle.h"

#define EMPTY UINT32_MAX

size_t nsdf_hash_slots(size_t count) {
    size_t slots = 16;
    while (slots < 2 * count) {
        slots *= 2;
    }
    return slots;
}

static uint32_t *create_table(size_t slots) {
    uint32_t *table = malloc(slots * sizeof *table);
    if (table != NULL) {
        memset(table, 0xff, slots * sizeof *table);
    }
    return table;
}

static uint64_t hash_three(const uint32_t key[3]) {
    return nsdf_hash_mix(nsdf_hash_mix((uint64_t)key[0] << 32 | key[1]) + key[2]);
}

static uint64_t hash_position(const float *xyz) {
    uint32_t bits[3];
    for (int i = 0; i < 3; i++) {
        float x = xyz[i] + 0.0f; /* turns -0 into 0 */
        memcpy(&bits[i], &x, sizeof x);
    }
    return hash_three(bits);
}

static bool equal_positions(const float *a, const float *b) {
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

int nsdf_weld_vertices(const nsdf_surface *surface, uint32_t *weld) {
    size_t slots = nsdf_hash_slots(surface->vertex_count);
    uint32_t *table = create_table(slots);
    if (table == NULL) {
        return -1;
    }
    for (uint32_t vertex = 0; vertex < surface->vertex_count; vertex++) {
        const float *xyz = &surface->positions[3 * (size_t)vertex];
        size_t slot = hash_position(xyz) & (slots - 1);
        while (table[slot] != EMPTY && !equal_positions(&surface->positions[3 * (size_t)table[slot]], xyz)) {
            slot = (slot + 1) & (slots - 1);
        }
        if (table[slot] == EMPTY) {
            table[slot] = vertex;
        }
        weld[vertex] = table[slot];
    }
    free(table);
    return 0;
}

int nsdf_weld_surface(nsdf_surface *surface) {
    uint32_t *weld = malloc(((size_t)surface->vertex_count + 1) * sizeof *weld);
    if (weld == NULL || nsdf_weld_vertices(surface, weld) != 0) {
        free(weld);
        return -1;
    }
    uint32_t kept = 0;
    for (uint32_t i = 0; i < surface->triangle_count; i++) {
        nsdf_triangle triangle = nsdf_triangle_load(surface, i);
        if (nsdf_triangle_has_area(&triangle)) {
            for (size_t k = 0; k < 3; k++) {
                surface->indices[3 * (size_t)kept + k] = weld[surface->indices[3 * (size_t)i + k]];
            }
            kept++;
        }
    }
    surface->triangle_count = kept;
    free(weld);
    return 0;
}

/* Welded corners with the smallest first, the cyclic order kept. */
static void canonical_corners(const nsdf_surface *surface, const uint32_t *weld, uint32_t triangle, uint32_t key[3]) {
    const uint32_t *index = &surface->indices[3 * (size_t)triangle];
    uint32_t corner[3] = {weld[index[0]], weld[index[1]], weld[index[2]]};
    int first = corner[1] < corner[0] ? 1 : 0;
    first = corner[2] < corner[first] ? 2 : first;
    for (int i = 0; i < 3; i++) {
        key[i] = corner[(first + i) % 3];
    }
}

int nsdf_find_repeated_triangles(const nsdf_surface *surface, const uint32_t *weld, bool *repeated) {
    size_t slots = nsdf_hash_slots(surface->triangle_count);
    uint32_t *table = create_table(slots);
    if (table == NULL) {
        return -1;
    }
    for (uint32_t triangle = 0; triangle < surface->triangle_count; triangle++) {
        uint32_t key[3], other[3];
        canonical_corners(surface, weld, triangle, key);
        size_t slot = hash_three(key) & (slots - 1);
        repeated[triangle] = false;
        for (; table[slot] != EMPTY && !repeated[triangle]; slot = (slot + 1) & (slots - 1)) {
            canonical_corners(surface, weld, table[slot], other);
            repeated[triangle] = memcmp(key, other, sizeof key) == 0;
        }
        if (!repeated[triangle]) {
            table[slot] = triangle;
        }
    }
    free(table);
    return 0;
}

#include "repair/patches.h"

#include "triangle.h"

#include <stdlib.h>
#include <string.h>

typedef struct {
    nsdf_patches *patches;
    const nsdf_surface *surface;
    const uint32_t *weld;
    const nsdf_mates *mates;
    uint32_t *queue; /* [triangle]: first found, first looked around, so that what cannot agree meets in short lines */
    uint32_t found, done;
} search;

/* What lies across a half-edge joins the patch, facing the same way. */
static void cross_edge(search *s, uint32_t half, nsdf_patch *patch) {
    nsdf_patches *p = s->patches;
    const uint32_t mate = s->mates->mate[half], number = p->count;
    if (mate == NSDF_MATE_NONE)
        patch->open_edges++;
    if (mate >= NSDF_MATE_SKIP)
        return;
    const int alike = nsdf_half_edge_from(s->surface, s->weld, half) != nsdf_half_edge_from(s->surface, s->weld, mate);
    const uint8_t turned = alike ? p->turned[half / 3] : !p->turned[half / 3];
    if (p->of[mate / 3] == NSDF_NO_PATCH) {
        p->of[mate / 3] = number;
        p->turned[mate / 3] = turned;
        s->queue[s->found++] = mate / 3;
    } else if (p->turned[mate / 3] != turned) {
        patch->one_sided = 1;
    }
}

static double triangle_volume(const nsdf_triangle *t) {
    return nsdf_vec3_dot(t->corner[0], nsdf_vec3_cross(t->corner[1], t->corner[2])) / 6.0;
}

static void grow_patch(search *s, uint32_t first) {
    nsdf_patches *p = s->patches;
    nsdf_patch *patch = &p->patches[p->count];
    double turned_area = 0.0;
    memset(patch, 0, sizeof *patch);
    p->of[first] = p->count;
    s->queue[s->found++] = first;
    while (s->done < s->found) {
        const uint32_t i = s->queue[s->done++];
        const nsdf_triangle t = nsdf_triangle_load(s->surface, i);
        const double area = 0.5 * nsdf_vec3_length(nsdf_triangle_cross(&t));
        patch->triangles++;
        patch->area += area;
        patch->volume += p->turned[i] ? -triangle_volume(&t) : triangle_volume(&t);
        turned_area += p->turned[i] ? area : 0.0;
        for (uint32_t k = 0; k < 3; k++)
            cross_edge(s, 3 * i + k, patch);
    }
    /* The side that most of the area faces is more likely meant than that of the first triangle. */
    patch->turned = 2.0 * turned_area > patch->area;
    patch->volume = patch->turned ? -patch->volume : patch->volume;
    p->count++;
}

static void settle_majorities(nsdf_patches *p, uint32_t triangles) {
    for (uint32_t i = 0; i < triangles; i++)
        if (p->of[i] != NSDF_NO_PATCH)
            p->turned[i] = (uint8_t)nsdf_is_turned(p, i);
    for (uint32_t i = 0; i < p->count; i++)
        p->patches[i].turned = 0;
}

int nsdf_patches_find(nsdf_patches *patches, const nsdf_surface *surface, const uint32_t *weld,
                      const nsdf_mates *mates) {
    const size_t n = surface->triangle_count;
    search s = {patches, surface, weld, mates, malloc((n + 1) * sizeof *s.queue), 0, 0};
    memset(patches, 0, sizeof *patches);
    patches->of = malloc((n + 1) * sizeof *patches->of);
    patches->turned = calloc(n + 1, 1);
    patches->patches = malloc((n + 1) * sizeof *patches->patches);
    const int failed = !s.queue || !patches->of || !patches->turned || !patches->patches;
    if (!failed) {
        memset(patches->of, 0xff, n * sizeof *patches->of);
        for (uint32_t i = 0; i < n; i++)
            if (patches->of[i] == NSDF_NO_PATCH && mates->mate[3 * (size_t)i] != NSDF_MATE_SKIP)
                grow_patch(&s, i);
        settle_majorities(patches, surface->triangle_count);
    }
    free(s.queue);
    return failed ? -1 : 0;
}

void nsdf_patches_free(nsdf_patches *patches) {
    free(patches->patches);
    free(patches->of);
    free(patches->turned);
    memset(patches, 0, sizeof *patches);
}

#include "repair/repair.h"

#include "repair/holes.h"
#include "repair/sides.h"
#include "repair/thicken.h"
#include "surface_error.h"
#include "triangle.h"
#include "weld.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Mean winding numbers that tell sheets (0) from the outsides of bodies (1/2), and these from walls within (1). */
static const double most_of_sheet = 0.4, least_of_wall = 0.8;

typedef struct {
    nsdf_surface *surface;
    const nsdf_repair_rule *rule;
    nsdf_mesh_report *report;
    uint32_t *weld;
    uint8_t *skip; /* [triangle] */
    nsdf_mates mates;
    nsdf_patches patches;
    nsdf_thick thick;
    nsdf_fill fill;
} repair;

/* ---- What is there -------------------------------------------------------------------------------------- */

static int count_vertices(const repair *r) {
    const nsdf_surface *s = r->surface;
    uint8_t *used = calloc((size_t)s->vertex_count + 1, 1);
    if (!used)
        return -1;
    for (size_t i = 0; i < 3 * (size_t)s->triangle_count; i++)
        used[s->indices[i]] |= 1;
    for (uint32_t v = 0; v < s->vertex_count; v++) {
        r->report->unreferenced_vertices += !used[v];
        if (used[v] & 1)
            used[r->weld[v]] |= 2; /* some vertex at this place is used */
    }
    uint64_t places = 0, vertices = 0;
    for (uint32_t v = 0; v < s->vertex_count; v++) {
        places += (used[v] & 2) != 0;
        vertices += used[v] & 1;
    }
    r->report->duplicate_vertices = vertices - places;
    free(used);
    return 0;
}

static void skip_degenerate(repair *r) {
    const nsdf_surface *s = r->surface;
    for (uint32_t i = 0; i < s->triangle_count; i++) {
        const uint32_t *t = s->indices + 3 * (size_t)i;
        const uint32_t a = r->weld[t[0]], b = r->weld[t[1]], c = r->weld[t[2]];
        const nsdf_triangle triangle = nsdf_triangle_load(s, i);
        r->skip[i] = a == b || b == c || c == a;
        r->report->zero_area_faces += !nsdf_triangle_has_area(&triangle);
    }
}

static void sorted_corners(const repair *r, uint32_t triangle, uint32_t key[3]) {
    for (int k = 0; k < 3; k++)
        key[k] = r->weld[r->surface->indices[3 * (size_t)triangle + (size_t)k]];
    for (int pass = 0; pass < 3; pass++) {
        const int k = pass == 1;
        if (key[k] > key[k + 1]) {
            const uint32_t larger = key[k];
            key[k] = key[k + 1];
            key[k + 1] = larger;
        }
    }
}

/* Of faces with the same corners, whichever way they face, the first stays. */
static int skip_duplicates(repair *r) {
    const size_t slots = nsdf_hash_slots(r->surface->triangle_count);
    uint32_t *table = malloc(slots * sizeof *table);
    if (!table)
        return -1;
    memset(table, 0xff, slots * sizeof *table);
    for (uint32_t i = 0; i < r->surface->triangle_count; i++) {
        uint32_t key[3], other[3];
        if (r->skip[i])
            continue;
        sorted_corners(r, i, key);
        size_t at = nsdf_hash_mix(nsdf_hash_mix((uint64_t)key[0] << 32 | key[1]) + key[2]) & (slots - 1);
        for (; table[at] != UINT32_MAX && !r->skip[i]; at = (at + 1) & (slots - 1)) {
            sorted_corners(r, table[at], other);
            r->skip[i] = memcmp(key, other, sizeof key) == 0;
        }
        r->report->duplicate_faces += r->skip[i];
        if (!r->skip[i])
            table[at] = i;
    }
    free(table);
    return 0;
}

static int count_components(const repair *r) {
    uint32_t *component = malloc(((size_t)r->surface->triangle_count + 1) * sizeof *component);
    const int64_t count = component ? nsdf_surface_components(r->surface, component) : -1;
    free(component);
    r->report->components = count < 0 ? 0 : (uint64_t)count;
    return count < 0 ? -1 : 0;
}

static int look_at(repair *r) {
    const nsdf_surface *s = r->surface;
    nsdf_mesh_report *report = r->report;
    report->vertices = s->vertex_count;
    report->triangles = s->triangle_count;
    r->weld = malloc(((size_t)s->vertex_count + 1) * sizeof *r->weld);
    r->skip = calloc((size_t)s->triangle_count + 1, 1);
    if (!r->weld || !r->skip || nsdf_weld_vertices(s, r->weld) != 0 || count_vertices(r) != 0 ||
        count_components(r) != 0)
        return -1;
    skip_degenerate(r);
    if (skip_duplicates(r) != 0 || nsdf_mates_find(&r->mates, s, r->weld, r->skip) != 0 ||
        nsdf_patches_find(&r->patches, s, r->weld, &r->mates) != 0)
        return -1;
    report->open_edges = r->mates.open;
    report->non_manifold_edges = r->mates.many;
    report->inconsistent_edges = r->mates.unalike;
    return 0;
}

static int is_clean(const repair *r) {
    const nsdf_mesh_report *report = r->report;
    if (report->open_edges + report->non_manifold_edges + report->inconsistent_edges + report->duplicate_faces > 0)
        return 0;
    for (uint32_t i = 0; i < r->patches.count; i++)
        if (r->patches.patches[i].volume < 0.0)
            return 0;
    return 1;
}

/* ---- What it is ----------------------------------------------------------------------------------------- */

/* Walls stand between others, which show what they are once the walls are gone. */
static uint32_t find_walls(repair *r) {
    uint32_t found = 0;
    for (uint32_t i = 0; i < r->patches.count; i++) {
        nsdf_patch *p = &r->patches.patches[i];
        const int closed = p->open_edges == 0 && r->mates.many == 0;
        if (closed || p->is_inner || !(p->inside > least_of_wall))
            continue;
        p->is_inner = 1;
        r->report->inner_faces += p->triangles;
        found++;
    }
    return found;
}

static void find_sheets(repair *r) {
    double whole = 0.0, sheets = 0.0;
    for (uint32_t i = 0; i < r->patches.count; i++) {
        nsdf_patch *p = &r->patches.patches[i];
        const int open = p->open_edges > 0 && !p->is_inner && p->area > 0.0;
        p->is_sheet = open && (r->rule->sheets == NSDF_SHEETS_ALL ||
                               (r->rule->sheets == NSDF_SHEETS_AUTO && fabs(p->inside) < most_of_sheet));
        whole += p->area;
        sheets += p->is_sheet ? p->area : 0.0;
        r->report->sheets += p->is_sheet;
        r->report->one_sided += p->one_sided;
    }
    r->report->sheet_share = whole > 0.0 ? sheets / whole : 0.0;
    r->report->sheet_thickness = r->report->sheets ? r->rule->thickness : 0.0;
}

/* A sheet has two sides alike: it is thickened as it was given. */
static void keep_sheets(repair *r) {
    for (uint32_t i = 0; i < r->patches.count; i++)
        if (r->patches.patches[i].is_sheet)
            r->patches.patches[i].turned = 0;
}

static void count_turned(repair *r) {
    uint64_t turned = 0, all = 0;
    for (uint32_t i = 0; i < r->surface->triangle_count; i++)
        if (r->patches.of[i] != NSDF_NO_PATCH) {
            turned += (uint64_t)nsdf_is_turned(&r->patches, i);
            all++;
        }
    r->report->reversed = turned == all && all > 0;
    r->report->turned_faces = r->report->reversed ? 0 : turned;
}

static int understand(repair *r) {
    for (int again = 1; again;) {
        if (nsdf_find_sides(&r->patches, r->surface) != 0)
            return -1;
        again = find_walls(r) > 0;
    }
    find_sheets(r);
    keep_sheets(r);
    count_turned(r);
    if (nsdf_thicken_sheets(&r->thick, r->surface, r->weld, &r->mates, &r->patches, r->rule->thickness) != 0 ||
        nsdf_fill_holes(&r->fill, r->surface, r->weld, &r->mates, &r->patches) != 0)
        return -1;
    r->report->filled_holes = r->fill.hole_count;
    return 0;
}

/* ---- What becomes of it --------------------------------------------------------------------------------- */

/* Triangles without area stay, which do no harm, so that the result depends on the triangles alone. */
static int stays(const repair *r, uint32_t triangle) {
    const uint32_t patch = r->patches.of[triangle];
    return patch != NSDF_NO_PATCH && !r->patches.patches[patch].is_inner && !r->patches.patches[patch].is_sheet;
}

static int rebuild(repair *r) {
    nsdf_surface *s = r->surface;
    const size_t triangles = (size_t)s->triangle_count + r->thick.triangle_count + r->fill.triangle_count;
    const size_t vertices = (size_t)s->vertex_count + r->thick.vertex_count;
    uint32_t *indices = triangles <= UINT32_MAX ? malloc((3 * triangles + 1) * sizeof *indices) : NULL;
    float *positions =
        indices && vertices <= UINT32_MAX ? realloc(s->positions, (3 * vertices + 1) * sizeof *positions) : NULL;
    uint32_t count = 0;
    if (!positions) {
        free(indices);
        return -1;
    }
    for (uint32_t i = 0; i < s->triangle_count; i++)
        if (stays(r, i))
            nsdf_turned_corners(&r->patches, s, i, indices + 3 * (size_t)count++);
    for (size_t i = 0; i < 3 * (size_t)r->thick.triangle_count; i++)
        indices[3 * (size_t)count + i] = s->vertex_count + r->thick.indices[i];
    count += r->thick.triangle_count;
    if (r->fill.triangle_count)
        memcpy(indices + 3 * (size_t)count, r->fill.indices, 3 * sizeof *indices * (size_t)r->fill.triangle_count);
    count += r->fill.triangle_count;
    if (r->thick.vertex_count)
        memcpy(positions + 3 * (size_t)s->vertex_count, r->thick.positions,
               3 * sizeof *positions * (size_t)r->thick.vertex_count);
    free(s->indices);
    *s = (nsdf_surface){positions, indices, (uint32_t)vertices, count};
    return 0;
}

int nsdf_repair_surface(nsdf_surface *surface, const nsdf_repair_rule *rule, uint32_t *filled,
                        nsdf_mesh_report *report) {
    repair r = {.surface = surface, .rule = rule, .report = report};
    int failed = look_at(&r) != 0;
    if (!failed && !is_clean(&r))
        failed = understand(&r) != 0 || rebuild(&r) != 0;
    if (!failed) {
        nsdf_edge_count left = {0, 0, 0};
        failed = nsdf_surface_count_edges(surface, &left) != 0;
        report->open_bodies = left.boundary + left.non_manifold + left.inconsistent > 0;
    }
    *filled = r.fill.triangle_count;
    free(r.weld);
    free(r.skip);
    nsdf_mates_free(&r.mates);
    nsdf_patches_free(&r.patches);
    nsdf_thick_free(&r.thick);
    nsdf_fill_free(&r.fill);
    return failed ? -1 : 0;
}

/* ---- The report ------------------------------------------------------------------------------------------ */

static int is_dirty(const nsdf_mesh_report *r) {
    return r->unreferenced_vertices + r->duplicate_vertices + r->zero_area_faces + r->duplicate_faces + r->open_edges +
               r->non_manifold_edges + r->inconsistent_edges + r->reversed + r->turned_faces + r->inner_faces +
               r->hidden_faces >
           0;
}

void nsdf_finish_report(nsdf_mesh_report *report) {
    report->dirty = (uint64_t)is_dirty(report);
}

#include "enc_dirt.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

typedef struct {
    char *text;
    size_t size;
} line;

__attribute__((format(printf, 2, 3))) static void add(line *l, const char *format, ...) {
    const size_t used = strlen(l->text);
    va_list args;
    if (used > 0)
        snprintf(l->text + used, l->size - used, "; ");
    const size_t at = strlen(l->text);
    va_start(args, format);
    vsnprintf(l->text + at, l->size - at, format, args);
    va_end(args);
}

/* A count for each frame, as far as one number can say it. */
static unsigned long long each(uint64_t sum, uint64_t frames) {
    const uint64_t mean = frames > 0 ? (sum + frames / 2) / frames : sum;
    return sum > 0 && mean == 0 ? 1 : mean;
}

static const char *plural(unsigned long long n) {
    return n == 1 ? "" : "s";
}

static void explain_sheets(line *l, const nsdf_mesh_report *r, uint64_t frames, int asked) {
    const unsigned long long n = each(r->sheets, frames);
    if (r->sheets > 0)
        add(l, "%llu open sheet%s given a thickness of %.3g%s", n, plural(n), r->sheet_thickness,
            asked ? "" : " (1/300 of the diagonal; --shell T changes it), which errors are measured from");
}

const char *enc_explain_dirt(const nsdf_mesh_report *r, uint64_t frames, int asked, char *text, size_t size) {
    line l = {text, size};
    text[0] = '\0';
    explain_sheets(&l, r, frames, asked);
    if (r->duplicate_faces > 0)
        add(&l, "%llu duplicate faces left out", each(r->duplicate_faces, frames));
    if (r->reversed > 0)
        add(&l, "turned inside out, since %llu of %llu faced inward", (unsigned long long)r->reversed,
            (unsigned long long)frames);
    if (r->turned_faces > 0)
        add(&l, "%llu faces turned round to agree with the others", each(r->turned_faces, frames));
    if (r->inner_faces > 0)
        add(&l, "%llu faces of walls inside left out", each(r->inner_faces, frames));
    if (r->filled_holes > 0)
        add(&l, "%llu small hole%s closed", each(r->filled_holes, frames), plural(each(r->filled_holes, frames)));
    if (r->open_bodies > 0)
        add(&l, "inside told by winding number, since %llu of %llu are not closed", (unsigned long long)r->open_bodies,
            (unsigned long long)frames);
    if (r->hidden_faces > 0)
        add(&l, "%llu faces inside of other parts do not count", each(r->hidden_faces, frames));
    return text;
}

static void add_count(line *l, uint64_t count, const char *what) {
    if (count > 0)
        add(l, "%llu %s", (unsigned long long)count, what);
}

const char *enc_name_dirt(const nsdf_mesh_report *r, char *text, size_t size) {
    line l = {text, size};
    text[0] = '\0';
    add_count(&l, r->unreferenced_vertices, "unused vertices");
    add_count(&l, r->duplicate_vertices, "duplicate vertices");
    add_count(&l, r->zero_area_faces, "faces without area");
    add_count(&l, r->duplicate_faces, "duplicate faces");
    add_count(&l, r->open_edges, "open edges");
    add_count(&l, r->non_manifold_edges, "non-manifold edges");
    add_count(&l, r->inconsistent_edges, "edges whose faces disagree");
    add_count(&l, r->one_sided, "one-sided pieces");
    add_count(&l, r->hidden_faces, "faces inside of other parts");
    if (text[0] == '\0')
        add(&l, r->reversed || r->turned_faces ? "faces inward" : "clean");
    return text;
}

void enc_put_dirt(nsdf_cli_file *f, const nsdf_mesh_report *r) {
    const struct {
        const char *name;
        uint64_t value;
    } counts[] = {{"vertices", r->vertices},
                  {"triangles", r->triangles},
                  {"components", r->components},
                  {"unreferenced_vertices", r->unreferenced_vertices},
                  {"duplicate_vertices", r->duplicate_vertices},
                  {"zero_area_faces", r->zero_area_faces},
                  {"duplicate_faces", r->duplicate_faces},
                  {"open_edges", r->open_edges},
                  {"non_manifold_edges", r->non_manifold_edges},
                  {"inconsistent_edges", r->inconsistent_edges},
                  {"reversed", r->reversed},
                  {"turned_faces", r->turned_faces},
                  {"one_sided", r->one_sided},
                  {"filled_holes", r->filled_holes},
                  {"open_bodies", r->open_bodies},
                  {"sheets", r->sheets},
                  {"inner_faces", r->inner_faces},
                  {"hidden_faces", r->hidden_faces},
                  {"dirty", r->dirty}};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        nsdf_cli_file_print(f, "%s\"%s\": %llu", i ? ", " : "{", counts[i].name, (unsigned long long)counts[i].value);
    nsdf_cli_file_print(f, ", \"sheet_share\": %.6g, \"sheet_thickness\": %.9g}", r->sheet_share, r->sheet_thickness);
}

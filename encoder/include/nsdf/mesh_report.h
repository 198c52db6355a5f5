/* What is wrong with a mesh, and what an encoder does about it. */
#ifndef NSDF_MESH_REPORT_H
#define NSDF_MESH_REPORT_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Equal positions count as one vertex.  Of several meshes, the sums. */
typedef struct nsdf_mesh_report {
    /* as it came */
    uint64_t vertices, triangles;
    uint64_t components;            /* connected pieces */
    uint64_t unreferenced_vertices; /* that no triangle uses */
    uint64_t duplicate_vertices;    /* at the place of an earlier one; triangles use both */
    uint64_t zero_area_faces;
    uint64_t duplicate_faces;    /* with the corners of an earlier one, whichever way they face */
    uint64_t open_edges;         /* of one triangle */
    uint64_t non_manifold_edges; /* of three or more */
    uint64_t inconsistent_edges; /* whose two triangles face different ways */
    /* what is done */
    uint64_t reversed;      /* meshes that faced inward as a whole and were turned round */
    uint64_t turned_faces;  /* turned round to face as the triangles around them, or outward; none where `reversed` */
    uint64_t one_sided;     /* pieces with no two sides (Moebius bands) */
    uint64_t filled_holes;  /* small ones, closed with triangles */
    uint64_t open_bodies;   /* meshes with edges left open: their inside is told by winding number */
    uint64_t sheets;        /* open pieces that were given a thickness */
    uint64_t inner_faces;   /* of walls inside of a body, left out */
    uint64_t hidden_faces;  /* inside of another part, or of the mesh itself where it passes through itself */
    uint64_t dirty;         /* meshes of which anything above but vertices, triangles and components is not 0 */
    double sheet_share;     /* of the area, in one mesh at most */
    double sheet_thickness; /* world units; 0 where there are no sheets */
} nsdf_mesh_report;

/* Adds what is known of some meshes to what is known of others. */
static inline void nsdf_join_reports(nsdf_mesh_report *sum, const nsdf_mesh_report *other) {
    sum->vertices += other->vertices;
    sum->triangles += other->triangles;
    sum->components += other->components;
    sum->unreferenced_vertices += other->unreferenced_vertices;
    sum->duplicate_vertices += other->duplicate_vertices;
    sum->zero_area_faces += other->zero_area_faces;
    sum->duplicate_faces += other->duplicate_faces;
    sum->open_edges += other->open_edges;
    sum->non_manifold_edges += other->non_manifold_edges;
    sum->inconsistent_edges += other->inconsistent_edges;
    sum->reversed += other->reversed;
    sum->turned_faces += other->turned_faces;
    sum->one_sided += other->one_sided;
    sum->filled_holes += other->filled_holes;
    sum->open_bodies += other->open_bodies;
    sum->sheets += other->sheets;
    sum->inner_faces += other->inner_faces;
    sum->hidden_faces += other->hidden_faces;
    sum->dirty += other->dirty;
    sum->sheet_share = other->sheet_share > sum->sheet_share ? other->sheet_share : sum->sheet_share;
    sum->sheet_thickness =
        other->sheet_thickness > sum->sheet_thickness ? other->sheet_thickness : sum->sheet_thickness;
}

#ifdef __cplusplus
}
#endif
#endif

/* Meshes as people have them, made into boundaries of bodies as far as they can be. */
#ifndef NSDF_REPAIR_H
#define NSDF_REPAIR_H

#include "nsdf/mesh_report.h"
#include "surface.h"

/* Which open pieces are sheets, to be given a thickness. */
typedef enum nsdf_sheet_rule {
    NSDF_SHEETS_AUTO = 0, /* those on which the winding number is not that of a body */
    NSDF_SHEETS_ALL = 1,  /* all that have an open edge */
    NSDF_SHEETS_NONE = 2
} nsdf_sheet_rule;

typedef struct nsdf_repair_rule {
    nsdf_sheet_rule sheets;
    double thickness; /* of sheets, normalised */
} nsdf_repair_rule;

/* Automatic thickness of sheets, fraction of the diagonal: the least that a grid of 256 cells along the longest side
 * resolves.  Half of it lies between a sheet and either side of its body. */
#define NSDF_AUTO_THICKNESS (1.0 / 300.0)

/* Repairs a normalised surface: leaves out faces that are there twice and walls within bodies, turns faces to agree
 * with those around them, and patches outward, closes small holes, and gives sheets a thickness.  A clean surface stays
 * as it is; otherwise its vertices stay, and more may follow them.  *filled gets the number of triangles that close
 * holes, which come last; those before depend on the triangles that were there, hardly on where their vertices are.
 * Fills *report, which is all zero, but for hidden_faces and dirty.  Returns 0, or -1 when memory ran out. */
int nsdf_repair_surface(nsdf_surface *surface, const nsdf_repair_rule *rule, uint32_t *filled,
                        nsdf_mesh_report *report);

/* Sets `dirty`, once all else is known. */
void nsdf_finish_report(nsdf_mesh_report *report);

#endif

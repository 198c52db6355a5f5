/* Meshes coloured by their distance to another. */
#ifndef NSDF_CMP_HEATMAP_H
#define NSDF_CMP_HEATMAP_H

#include "cli_pattern.h"
#include "nsdf/encoder.h"

/* NSDF_CLI_SUCCESS, or NSDF_CLI_USAGE after printing why the name does not serve for `count` meshes: it must end in
 * .ply, and hold one %d (or %4d, %04d) when there are several. */
int cmp_heatmap_prepare(const char *name, uint32_t count, nsdf_cli_pattern *pattern);

/* Writes a mesh as binary PLY; distance[vertex_count] from 0 (violet) to `top` and above (yellow).  The file keeps its
 * temporary name until nsdf_cli_commit.  NSDF_CLI_SUCCESS, or NSDF_CLI_FAILURE after printing why. */
int cmp_heatmap_write(const nsdf_cli_pattern *pattern, uint32_t number, const nsdf_input_mesh *mesh,
                      const double *distance, double top);

#endif

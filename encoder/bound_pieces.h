/* The extraction bound that small pieces of surface need. */
#ifndef NSDF_BOUND_PIECES_H
#define NSDF_BOUND_PIECES_H

#include "container_write.h"
#include "nsdf/decoder.h"
#include "surface.h"

/* Extraction follows a piece of surface as soon as it has one cell of it, to which cubes of 32, 16, 8, 4 and 2 cells
 * lead.  For every piece but the largest of a decoded surface, in normalised coordinates and at time t, with `pieces`
 * and piece[triangle] from nsdf_surface_components: the least bound with which the cubes around one of its vertices are
 * kept, at each of twelve resolutions from 64 to 512. *bound becomes the largest of these if it was less.
 * NSDF_NO_MEMORY, or what nsdf_evaluate says. */
nsdf_status nsdf_bound_of_pieces(nsdf_decoder *decoder, double t, const nsdf_file_header *header,
                                 const nsdf_surface *surface, const uint32_t *piece, uint32_t pieces, double *bound);

#endif

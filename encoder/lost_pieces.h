/* Parts of the surface that decoders leave out with the specks: a hand that came off an arm too thin for the model is a
 * piece of its own, and may be smaller than any piece of the input. */
#ifndef NSDF_LOST_PIECES_H
#define NSDF_LOST_PIECES_H

#include "container_write.h"
#include "nsdf/decoder.h"
#include "surface.h"

/* Decoded surface that is further from the input, normalised, is astray. */
#define NSDF_STRAY_DISTANCE 0.01f

/* Less of a surface is not missed, and its pieces are told from specks by nothing: diagonal of the box, normalised. */
#define NSDF_LEAST_LOST 0.03f

/* Extracts all pieces at time t.  *smallest becomes the diagonal of the smallest one, of NSDF_LEAST_LOST or more, of
 * which at least half is not astray, if it was larger.  Both surfaces are normalised by `header`.
 * NSDF_NO_MEMORY, or what extraction says. */
nsdf_status nsdf_find_lost_pieces(nsdf_decoder *decoder, double t, const nsdf_file_header *header,
                                  const nsdf_surface *input, float *smallest);

#endif

/* The frames that were added: kept as floats relative to a local origin, normalised once all are known. */
#ifndef NSDF_FRAMES_H
#define NSDF_FRAMES_H

#include "format_desc.h"
#include "nsdf/encoder.h"
#include "repair/repair.h"
#include "sdf.h"

/* The domain is the sequence's box, larger by this fraction of the diagonal on every side. */
#define NSDF_DOMAIN_MARGIN 0.02

typedef struct nsdf_frame {
    uint32_t number;      /* nominal frame */
    nsdf_surface surface; /* relative to the origin; normalised after nsdf_frames_normalise */
    nsdf_sign_rule sign;
    nsdf_mesh_report report;
    uint32_t filled;      /* triangles of the surface that repair closed holes with, which come last */
    nsdf_surface outer;   /* triangles on the outside of all parts together, where parts pass through each other: own
                             indices, the surface's positions; no triangles when all are on the outside */
    float smallest_piece; /* diagonal of the box of its smallest connected piece of which a part is on the outside */
} nsdf_frame;

typedef struct nsdf_frames {
    nsdf_frame *frames;
    uint32_t count, capacity;
    double origin[3];              /* of the stored positions: the first vertex of all */
    double box_min[3], box_max[3]; /* world units */
    uint64_t triangles;
} nsdf_frames;

void nsdf_frames_free(nsdf_frames *frames);

/* At most `count` of them, evenly spread from the first on, which tells the times of the others; they borrow the
 * meshes, and picked[count]. */
nsdf_frames nsdf_frames_pick(const nsdf_frames *all, uint32_t count, nsdf_frame *picked);

/* Copies a mesh.  Fails with NSDF_INVALID_ARGUMENT (no triangle, NaN or too large a coordinate, index or number out of
 * range) or NSDF_NO_MEMORY; the message speaks of "frame N". */
nsdf_status nsdf_frames_add(nsdf_frames *frames, uint32_t number, const nsdf_input_mesh *mesh,
                            nsdf_encoder_error *error);

/* Mesh normalisation (thesis 5.8, 5.9): one box over all frames, centred, divided by its diagonal.  Fills box, centre,
 * scale and the domain: the box, larger by `margin` (normalised) on every side. */
nsdf_status nsdf_frames_normalise(nsdf_frames *frames, double margin, nsdf_file_header *header,
                                  nsdf_encoder_error *error);

/* Takes a larger box for that of the frames.  Fails with NSDF_INVALID_ARGUMENT when it does not hold them. */
nsdf_status nsdf_frames_set_box(nsdf_frames *frames, const double box_min[3], const double box_max[3],
                                nsdf_encoder_error *error);

/* How many frames there are from the first number to the last, those that were not added among them. */
uint32_t nsdf_frames_span(const nsdf_frames *frames);

/* Index of the frame with a number; frames->count when it was not added. */
uint32_t nsdf_frames_find(const nsdf_frames *frames, uint32_t number);

/* Makes the surface the boundary of a body as far as it can be, decides the sign rule, and fills the report.
 * Normalised surfaces; reads and writes this frame only.  Returns 0, or -1 when memory ran out. */
int nsdf_frame_repair(nsdf_frame *frame, const nsdf_repair_rule *rule);

/* Finds frame->outer of a repaired frame, and reports how much is hidden.  Returns 0, or -1 when memory ran out. */
int nsdf_frame_find_outer(nsdf_frame *frame);

/* Finds frame->smallest_piece of a frame whose outside is known; equal positions count as one vertex.  Returns 0, or -1
 * when memory ran out. */
int nsdf_frame_find_smallest_piece(nsdf_frame *frame);

/* The least frame->smallest_piece. */
float nsdf_frames_smallest_piece(const nsdf_frames *frames);

/* What counts of a frame: its outer triangles. */
const nsdf_surface *nsdf_frame_outer(const nsdf_frame *frame);

/* Signed distance to what counts of a frame.  NULL when memory ran out. */
nsdf_sdf *nsdf_frame_sdf(const nsdf_frame *frame);

/* Writes into error and returns status. */
nsdf_status nsdf_encoder_fail(nsdf_encoder_error *error, nsdf_status status, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;

#endif

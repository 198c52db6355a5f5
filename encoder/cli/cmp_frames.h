/* The two sequences that nsdf-cmp compares, frame by frame. */
#ifndef NSDF_CMP_FRAMES_H
#define NSDF_CMP_FRAMES_H

#include "cli_list.h"
#include "cmp_options.h"
#include "nsdf/sequence.h"

typedef struct cmp_frames {
    nsdf_sequence *reference;
    nsdf_sequence *decoded; /* or NULL, and then: */
    nsdf_decoder *decoder;
    nsdf_mesh *mesh;
    double *positions; /* of the decoded mesh, as doubles */
    size_t capacity;   /* doubles */
    nsdf_cli_list chosen;
    double diagonal;             /* of the sequence that was encoded, for the thickness of sheets; 0 = not known yet */
    nsdf_repaired_mesh repaired; /* of the reference */
    double box_min[3], box_max[3]; /* of the reference's frames seen so far */
} cmp_frames;

/* Opens both and decides which frames are compared.  NSDF_CLI_SUCCESS, or another exit code after printing why;
 * cmp_frames_close in either case. */
int cmp_frames_open(cmp_frames *frames, const cmp_options *options);
void cmp_frames_close(cmp_frames *frames);

/* The meshes of chosen.numbers[i]; valid until the next call.  Extends the box by the reference's. */
int cmp_frames_load(cmp_frames *frames, const cmp_options *options, uint32_t i, nsdf_input_mesh *reference,
                    nsdf_input_mesh *decoded);

/* Extends the box by all frames of the reference, or by those that were not chosen.  NSDF_CLI_FAILURE after printing
 * why, or when interrupted. */
int cmp_frames_read_box(cmp_frames *frames);
int cmp_frames_finish_box(cmp_frames *frames);

/* For messages: where a frame of the decoded side comes from. */
void cmp_frames_name_decoded(const cmp_frames *frames, const cmp_options *options, uint32_t i, char *name, size_t size);

#endif

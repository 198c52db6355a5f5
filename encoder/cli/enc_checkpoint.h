/* --checkpoint: the file from which a repeated command goes on fitting. */
#ifndef NSDF_ENC_CHECKPOINT_H
#define NSDF_ENC_CHECKPOINT_H

#include "enc_options.h"

typedef struct enc_checkpoint {
    const char *path; /* NULL without --checkpoint */
    int there;        /* the file holds a checkpoint of this run */
} enc_checkpoint;

/* Has the encoder, which has all its frames, go on from the file if it is there, and write it from now on.  0, or -1
 * after printing why; the file is then as it was. */
int enc_checkpoint_open(enc_checkpoint *checkpoint, const enc_options *options, nsdf_encoder *encoder);

/* After the outputs are written: removes the file, or says that it stays, when fitting was ended early. */
void enc_checkpoint_close(const enc_checkpoint *checkpoint, int ended_early);

#endif

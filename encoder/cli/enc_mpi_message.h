/* What ranks tell each other while segments are fitted. */
#ifndef NSDF_ENC_MPI_MESSAGE_H
#define NSDF_ENC_MPI_MESSAGE_H

#include "enc_mpi.h"

#include <mpi.h>

/* Tags: a message to rank 0, the bytes of a segment behind one, an order of rank 0. */
enum { ENC_TAG_MESSAGE = 1, ENC_TAG_BYTES, ENC_TAG_ORDER };

typedef enum enc_message_kind {
    ENC_MESSAGE_READY,    /* for work */
    ENC_MESSAGE_PROGRESS, /* also says that the rank lives */
    ENC_MESSAGE_PART,     /* a segment is fitted, and its bytes come next */
    ENC_MESSAGE_LOST,     /* its process was killed */
    ENC_MESSAGE_FAILED    /* it cannot be fitted: the rank has said why */
} enc_message_kind;

typedef struct enc_message {
    uint32_t kind, segment;
    double done;
    uint64_t size; /* of the part's file */
} enc_message;

/* Orders below 0; others are the segment to fit. */
enum { ENC_ORDER_END = -1 };

/* Who a rank is, to see its death on the same machine at once. */
typedef struct enc_identity {
    char host[MPI_MAX_PROCESSOR_NAME];
    int64_t process;
} enc_identity;

/* Of all ranks, in order; set by enc_mpi_begin. */
const enc_identity *enc_mpi_identities(void);

/* Whether a rank is known to have ended: its process is on this machine and gone. */
int enc_mpi_is_gone(uint32_t rank);

/* That some rank died, so that leaving together is not possible any more. */
void enc_mpi_note_death(void);

/* Sleeps a little between looks at what has come. */
void enc_mpi_rest(void);

#endif

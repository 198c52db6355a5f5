/* Many machines: ranks of MPI that fit segments.  Rank 0 plans, hands out segments, fits some itself, and writes the
 * file; a rank that dies loses only its segment.  Without MPI in the build there is one rank. */
#ifndef NSDF_ENC_MPI_H
#define NSDF_ENC_MPI_H

#include "enc_part.h"

/* Joins the other ranks when the program was started by mpirun.  0, or -1 after printing why. */
int enc_mpi_begin(int *argc, char ***argv);

/* The program's end: leaves the other ranks, and gives back `code`. */
int enc_mpi_end(int code);

uint32_t enc_mpi_rank(void);
uint32_t enc_mpi_ranks(void);

/* Rank 0: tells the others that there is no work for them (plan NULL), or what the plan is. */
void enc_mpi_announce(const enc_plan *plan);

/* Rank 0, after enc_mpi_announce: has all segments fitted.  0 when all have files; -1 after printing why not. */
int enc_mpi_run(const enc_parts *parts);

/* The other ranks: does what rank 0 says, until it says that all is done.  The exit code. */
int enc_mpi_serve(const enc_options *options, nsdf_sequence *sequence, const nsdf_cli_list *list);

#endif

/* A build without MPI: one rank. */
#include "enc_mpi.h"

#include "cli_util.h"
#include "enc_pool.h"

#include <stdlib.h>
#include <string.h>

int enc_mpi_begin(int *argc, char ***argv) {
    const char *ranks = getenv("OMPI_COMM_WORLD_SIZE");
    (void)argc;
    (void)argv;
    if (!ranks || strcmp(ranks, "1") == 0)
        return 0;
    nsdf_cli_error("started by mpirun, but built without MPI: --jobs fits several segments at a time on one machine");
    return -1;
}

int enc_mpi_end(int code) {
    return code;
}

uint32_t enc_mpi_rank(void) {
    return 0;
}

uint32_t enc_mpi_ranks(void) {
    return 1;
}

void enc_mpi_announce(const enc_plan *plan) {
    (void)plan;
}

int enc_mpi_run(const enc_parts *parts) {
    return enc_pool_run(parts, parts->plan->at_once);
}

int enc_mpi_serve(const enc_options *options, nsdf_sequence *sequence, const nsdf_cli_list *list) {
    (void)options;
    (void)sequence;
    (void)list;
    return NSDF_CLI_FAILURE;
}

/* Ranks: beginning, end, and who they are. */
#include "enc_mpi_message.h"

#include "cli_util.h"

#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static int rank, ranks = 1, started, deaths;
static enc_identity *identities;

/* What launchers of the usual MPIs set.  A program that was started by itself does not pay for MPI. */
static int was_launched(void) {
    return getenv("OMPI_COMM_WORLD_SIZE") || getenv("PMI_RANK") || getenv("PMIX_RANK");
}

static int exchange_identities(void) {
    enc_identity own;
    int length = 0;
    memset(&own, 0, sizeof own);
    MPI_Get_processor_name(own.host, &length);
    own.process = (int64_t)getpid();
    identities = calloc((size_t)ranks, sizeof *identities);
    return identities && MPI_Allgather(&own, sizeof own, MPI_BYTE, identities, sizeof own, MPI_BYTE, MPI_COMM_WORLD) ==
                             MPI_SUCCESS
               ? 0
               : -1;
}

int enc_mpi_begin(int *argc, char ***argv) {
    int level;
    if (!was_launched())
        return 0;
    /* Segments are fitted by processes, and frames looked over by threads, that know nothing of MPI. */
    if (MPI_Init_thread(argc, argv, MPI_THREAD_FUNNELED, &level) != MPI_SUCCESS) {
        nsdf_cli_error("MPI cannot be started");
        return -1;
    }
    started = 1;
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    if (ranks == 1 || exchange_identities() == 0)
        return 0;
    nsdf_cli_error("the ranks cannot reach each other");
    return -1;
}

int enc_mpi_end(int code) {
    free(identities);
    identities = NULL;
    if (!started)
        return code;
    if (deaths)
        _exit(code); /* the others would be waited for, the dead too */
    MPI_Finalize();
    return code;
}

uint32_t enc_mpi_rank(void) {
    return (uint32_t)rank;
}

uint32_t enc_mpi_ranks(void) {
    return (uint32_t)ranks;
}

const enc_identity *enc_mpi_identities(void) {
    return identities;
}

int enc_mpi_is_gone(uint32_t other) {
    const enc_identity *own = &identities[rank], *theirs = &identities[other];
    return strcmp(own->host, theirs->host) == 0 && kill((pid_t)theirs->process, 0) != 0 && errno == ESRCH;
}

void enc_mpi_note_death(void) {
    deaths = 1;
}

void enc_mpi_rest(void) {
    const struct timespec moment = {0, 20 * 1000 * 1000};
    nanosleep(&moment, NULL);
}

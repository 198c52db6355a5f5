/* Rank 0: hands out segments and gathers what comes back. */
#include "enc_mpi_message.h"

#include "cli_util.h"
#include "enc_pool.h"

#include <stdlib.h>
#include <string.h>

/* A rank that is silent for so long is taken for dead; it reports every second. */
static const double patience = 60.0;

typedef struct peer {
    uint32_t segment; /* that it fits; UINT32_MAX = none */
    int ready, dead;
    double done, heard;
} peer;

typedef struct lead {
    enc_pool pool;
    peer *peers; /* [rank]; that of rank 0 is not used */
} lead;

void enc_mpi_announce(const enc_plan *plan) {
    uint32_t count = plan ? plan->count : 0;
    if (enc_mpi_ranks() == 1)
        return;
    MPI_Bcast(&count, 1, MPI_UINT32_T, 0, MPI_COMM_WORLD);
    if (count == 0)
        return;
    double box[6];
    memcpy(box, plan->box_min, sizeof plan->box_min);
    memcpy(box + 3, plan->box_max, sizeof plan->box_max);
    MPI_Bcast(box, 6, MPI_DOUBLE, 0, MPI_COMM_WORLD);
    MPI_Bcast(plan->spans, (int)(count * sizeof *plan->spans), MPI_BYTE, 0, MPI_COMM_WORLD);
    MPI_Bcast(plan->hashes, (int)count, MPI_UINT64_T, 0, MPI_COMM_WORLD);
}

/* ---- One rank ----------------------------------------------------------------------------------------------- */

static void lose_peer(lead *l, uint32_t rank) {
    peer *p = &l->peers[rank];
    if (p->dead)
        return;
    p->dead = 1;
    enc_mpi_note_death();
    nsdf_cli_warn("rank %u on %s has died", rank, enc_mpi_identities()[rank].host);
    if (p->segment != UINT32_MAX)
        enc_pool_lose(&l->pool, p->segment);
    p->segment = UINT32_MAX;
}

static int is_lost(const peer *p, uint32_t rank) {
    return enc_mpi_is_gone(rank) || nsdf_cli_clock() - p->heard > patience;
}

static void order(lead *l, uint32_t rank, int32_t what) {
    if (MPI_Send(&what, 1, MPI_INT32_T, (int)rank, ENC_TAG_ORDER, MPI_COMM_WORLD) != MPI_SUCCESS)
        lose_peer(l, rank);
}

/* The bytes behind a message; the rank may die before they are here.  0, or -1. */
static int receive_bytes(const peer *p, uint32_t rank, void *bytes, uint64_t size) {
    const uint64_t most = 1 << 30;
    for (uint64_t at = 0; at < size; at += most) {
        MPI_Request request;
        const int count = (int)(size - at < most ? size - at : most);
        int here = 0;
        if (MPI_Irecv((char *)bytes + at, count, MPI_BYTE, (int)rank, ENC_TAG_BYTES, MPI_COMM_WORLD, &request) !=
            MPI_SUCCESS)
            return -1;
        while (!here) {
            if (MPI_Test(&request, &here, MPI_STATUS_IGNORE) != MPI_SUCCESS || (!here && is_lost(p, rank)))
                return -1;
            if (!here)
                enc_mpi_rest();
        }
    }
    return 0;
}

static void take_part(lead *l, uint32_t rank, const enc_message *m) {
    peer *p = &l->peers[rank];
    enc_part part = {malloc((size_t)m->size), (size_t)m->size, {0}};
    const uint32_t segment = p->segment;
    if (!part.file || receive_bytes(p, rank, &part.stats, sizeof part.stats) != 0 ||
        receive_bytes(p, rank, part.file, m->size) != 0) {
        enc_part_free(&part);
        lose_peer(l, rank);
        return;
    }
    p->segment = UINT32_MAX;
    p->heard = nsdf_cli_clock();
    if (enc_part_write(l->pool.parts, segment, &part) != 0)
        l->pool.failed = 1;
    else
        enc_pool_finish(&l->pool, segment);
    enc_part_free(&part);
}

static void hear(lead *l, uint32_t rank, const enc_message *m) {
    peer *p = &l->peers[rank];
    p->heard = nsdf_cli_clock();
    p->done = m->done;
    switch (m->kind) {
    case ENC_MESSAGE_READY:
        p->ready = 1;
        break;
    case ENC_MESSAGE_PART:
        take_part(l, rank, m);
        break;
    case ENC_MESSAGE_LOST:
        enc_pool_lose(&l->pool, p->segment);
        p->segment = UINT32_MAX;
        break;
    case ENC_MESSAGE_FAILED:
        l->pool.failed = 1;
        p->segment = UINT32_MAX;
        break;
    default:
        break;
    }
}

/* ---- All ranks ---------------------------------------------------------------------------------------------- */

static void hear_all(lead *l) {
    for (;;) {
        enc_message m;
        MPI_Status status;
        int there = 0;
        if (MPI_Iprobe(MPI_ANY_SOURCE, ENC_TAG_MESSAGE, MPI_COMM_WORLD, &there, &status) != MPI_SUCCESS || !there)
            return;
        const uint32_t rank = (uint32_t)status.MPI_SOURCE;
        if (MPI_Recv(&m, sizeof m, MPI_BYTE, status.MPI_SOURCE, ENC_TAG_MESSAGE, MPI_COMM_WORLD, &status) !=
            MPI_SUCCESS)
            lose_peer(l, rank);
        else if (!l->peers[rank].dead)
            hear(l, rank, &m);
    }
}

static void order_all(lead *l) {
    for (uint32_t rank = 1; rank < enc_mpi_ranks(); rank++) {
        peer *p = &l->peers[rank];
        if (!p->dead && is_lost(p, rank))
            lose_peer(l, rank);
        if (p->dead || !p->ready || p->segment != UINT32_MAX)
            continue;
        p->segment = enc_pool_take(&l->pool);
        if (p->segment == UINT32_MAX)
            continue;
        p->ready = 0;
        p->done = 0.0;
        order(l, rank, (int32_t)p->segment);
    }
}

static void show(const lead *l) {
    double done = 0.0;
    for (uint32_t rank = 1; rank < enc_mpi_ranks(); rank++)
        done += l->peers[rank].segment != UINT32_MAX ? l->peers[rank].done : 0.0;
    enc_pool_show(&l->pool, done);
}

static int lead_all(lead *l) {
    while (enc_pool_goes_on(&l->pool)) {
        order_all(l);
        (void)enc_pool_work(&l->pool);
        hear_all(l);
        show(l);
        enc_mpi_rest();
    }
    for (uint32_t rank = 1; rank < enc_mpi_ranks(); rank++)
        if (!l->peers[rank].dead)
            order(l, rank, ENC_ORDER_END);
    return enc_pool_result(&l->pool);
}

int enc_mpi_run(const enc_parts *parts) {
    lead l;
    if (enc_mpi_ranks() == 1)
        return enc_pool_run(parts, parts->plan->at_once);
    l.peers = calloc(enc_mpi_ranks(), sizeof *l.peers);
    int result = enc_pool_open(&l.pool, parts, 1);
    for (uint32_t rank = 0; l.peers && rank < enc_mpi_ranks(); rank++)
        l.peers[rank] = (peer){UINT32_MAX, 0, 0, 0.0, nsdf_cli_clock()};
    if (!l.peers) {
        nsdf_cli_error("out of memory");
        result = -1;
    }
    if (result == 0)
        result = lead_all(&l);
    enc_pool_close(&l.pool);
    free(l.peers);
    return result;
}

/* The ranks that do as they are told. */
#include "enc_mpi_message.h"

#include "cli_util.h"
#include "enc_job.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const double report_every = 1.0; /* seconds */

static int tell(enc_message_kind kind, uint32_t segment, double done, uint64_t size) {
    enc_message m = {(uint32_t)kind, segment, done, size};
    return MPI_Send(&m, sizeof m, MPI_BYTE, 0, ENC_TAG_MESSAGE, MPI_COMM_WORLD) == MPI_SUCCESS ? 0 : -1;
}

/* Says now and then that the rank lives, and how far it is; *told is when it did. */
static int report(double *told, uint32_t segment, double done) {
    const double now = nsdf_cli_clock();
    if (now - *told < report_every)
        return 0;
    *told = now;
    return tell(ENC_MESSAGE_PROGRESS, segment, done, 0);
}

static int send_bytes(const void *bytes, uint64_t size) {
    const uint64_t most = 1 << 30;
    for (uint64_t at = 0; at < size; at += most) {
        const int count = (int)(size - at < most ? size - at : most);
        if (MPI_Send((const char *)bytes + at, count, MPI_BYTE, 0, ENC_TAG_BYTES, MPI_COMM_WORLD) != MPI_SUCCESS)
            return -1;
    }
    return 0;
}

/* ---- The plan ----------------------------------------------------------------------------------------------- */

/* Ranks on this machine. */
static uint32_t ranks_here(void) {
    const enc_identity *all = enc_mpi_identities();
    uint32_t count = 0;
    for (uint32_t i = 0; i < enc_mpi_ranks(); i++)
        count += strcmp(all[i].host, all[enc_mpi_rank()].host) == 0;
    return count;
}

/* What enc_mpi_announce says.  1 when there is work, 0 when there is none, -1 on failure. */
static int receive_plan(enc_plan *plan) {
    double box[6];
    if (MPI_Bcast(&plan->count, 1, MPI_UINT32_T, 0, MPI_COMM_WORLD) != MPI_SUCCESS || plan->count == 0)
        return 0;
    plan->spans = calloc(plan->count, sizeof *plan->spans);
    plan->hashes = calloc(plan->count, sizeof *plan->hashes);
    if (!plan->spans || !plan->hashes)
        MPI_Abort(MPI_COMM_WORLD, NSDF_CLI_FAILURE); /* rank 0 is in the same call */
    if (MPI_Bcast(box, 6, MPI_DOUBLE, 0, MPI_COMM_WORLD) != MPI_SUCCESS ||
        MPI_Bcast(plan->spans, (int)(plan->count * sizeof *plan->spans), MPI_BYTE, 0, MPI_COMM_WORLD) != MPI_SUCCESS ||
        MPI_Bcast(plan->hashes, (int)plan->count, MPI_UINT64_T, 0, MPI_COMM_WORLD) != MPI_SUCCESS)
        return -1;
    memcpy(plan->box_min, box, sizeof plan->box_min);
    memcpy(plan->box_max, box + 3, sizeof plan->box_max);
    plan->at_once = ranks_here();
    if (plan->spans[plan->count - 1].last < plan->list->count)
        return 1;
    nsdf_cli_error("rank %u finds %u frames, fewer than rank 0: all machines need the whole input", enc_mpi_rank(),
                   plan->list->count);
    return -1;
}

/* ---- Work --------------------------------------------------------------------------------------------------- */

/* The order that has come; ENC_ORDER_END too when rank 0 is gone; UINT32_MAX when there is none. */
static int64_t look_for_order(void) {
    int there = 0;
    int32_t what = ENC_ORDER_END;
    if (MPI_Iprobe(0, ENC_TAG_ORDER, MPI_COMM_WORLD, &there, MPI_STATUS_IGNORE) != MPI_SUCCESS)
        return ENC_ORDER_END;
    if (!there && (enc_mpi_is_gone(0) || nsdf_cli_interrupts() > 0))
        return ENC_ORDER_END;
    if (!there)
        return UINT32_MAX;
    if (MPI_Recv(&what, 1, MPI_INT32_T, 0, ENC_TAG_ORDER, MPI_COMM_WORLD, MPI_STATUS_IGNORE) != MPI_SUCCESS)
        return ENC_ORDER_END;
    return what;
}

static int send_part(const enc_parts *parts, uint32_t segment) {
    enc_part part;
    if (enc_part_read(parts, segment, &part) != 0)
        return tell(ENC_MESSAGE_LOST, segment, 0.0, 0);
    const int failed = tell(ENC_MESSAGE_PART, segment, 1.0, part.size) != 0 ||
                       send_bytes(&part.stats, sizeof part.stats) != 0 || send_bytes(part.file, part.size) != 0;
    enc_part_free(&part);
    return failed ? -1 : 0;
}

/* Fits one segment and sends it.  0 to go on, -1 when rank 0 has ended it or is gone. */
static int fit(const enc_parts *parts, uint32_t segment) {
    enc_job job;
    enc_job_state state = ENC_JOB_RUNNING;
    double told = 0.0;
    if (enc_job_start(&job, parts, segment) != 0)
        return tell(ENC_MESSAGE_FAILED, segment, 0.0, 0);
    while ((state = enc_job_check(&job)) == ENC_JOB_RUNNING) {
        if (look_for_order() == ENC_ORDER_END || report(&told, segment, job.done) != 0) {
            enc_job_stop(&job);
            return -1;
        }
        enc_mpi_rest();
    }
    if (state == ENC_JOB_DONE)
        return send_part(parts, segment);
    return tell(state == ENC_JOB_KILLED ? ENC_MESSAGE_LOST : ENC_MESSAGE_FAILED, segment, 0.0, 0);
}

/* Waits for an order; says that it lives meanwhile. */
static int64_t await_order(void) {
    double told = nsdf_cli_clock();
    if (tell(ENC_MESSAGE_READY, 0, 0.0, 0) != 0)
        return ENC_ORDER_END;
    for (;;) {
        const int64_t what = look_for_order();
        if (what != UINT32_MAX)
            return what;
        if (report(&told, 0, 0.0) != 0)
            return ENC_ORDER_END;
        enc_mpi_rest();
    }
}

static void work(const enc_parts *parts) {
    for (int64_t what; (what = await_order()) >= 0 && what < parts->plan->count;)
        if (fit(parts, (uint32_t)what) != 0)
            break;
    if (enc_mpi_is_gone(0))
        enc_mpi_note_death();
}

int enc_mpi_serve(const enc_options *options, nsdf_sequence *sequence, const nsdf_cli_list *list) {
    enc_plan plan;
    enc_parts parts = {&plan, NULL, NULL};
    memset(&plan, 0, sizeof plan);
    plan.options = options;
    plan.sequence = sequence;
    plan.list = list;
    const int there = receive_plan(&plan);
    if (there > 0 && enc_parts_open_temporary(&parts, &plan) == 0)
        work(&parts);
    else if (there != 0)
        enc_mpi_note_death(); /* rank 0 finds this rank gone, and does without it */
    enc_parts_free(&parts);
    enc_plan_free(&plan);
    return there < 0 ? NSDF_CLI_FAILURE : NSDF_CLI_SUCCESS;
}

#include "enc_look.h"

#include "cli_util.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* More threads would wait for the disk. */
enum { MOST_THREADS = 16, FRAMES_EACH = 16, MOST_FRAMES = MOST_THREADS * FRAMES_EACH };

/* What became of a frame. */
typedef struct found {
    nsdf_status status;
    int was_read; /* so that the message does not name the file */
    nsdf_frame_look look;
    nsdf_encoder_error error;
} found;

/* Frames that are looked at in any order, and added once all are. */
typedef struct batch {
    const uint32_t *numbers;
    uint32_t count;
    atomic_uint next;
    found frames[MOST_FRAMES];
} batch;

typedef struct looker {
    nsdf_sequence *sequence; /* of its own */
    batch *work;
    pthread_t thread;
    int runs;
} looker;

static void look_at(nsdf_sequence *sequence, uint32_t number, found *f) {
    nsdf_input_mesh mesh;
    f->status = nsdf_sequence_load(sequence, number, &mesh, &f->error);
    f->was_read = f->status == NSDF_OK;
    if (f->was_read)
        f->status = nsdf_survey_look(number, &mesh, &f->look, &f->error);
}

static void *run(void *user) {
    const looker *l = user;
    for (uint32_t i; (i = atomic_fetch_add(&l->work->next, 1)) < l->work->count;)
        look_at(l->sequence, l->work->numbers[i], &l->work->frames[i]);
    return NULL;
}

/* This thread works too, so that none at all have to start. */
static void run_all(looker *lookers, uint32_t count) {
    for (uint32_t i = 1; i < count; i++)
        lookers[i].runs = pthread_create(&lookers[i].thread, NULL, run, &lookers[i]) == 0;
    (void)run(&lookers[0]);
    for (uint32_t i = 1; i < count; i++)
        if (lookers[i].runs)
            pthread_join(lookers[i].thread, NULL);
}

static int add(nsdf_survey *survey, const nsdf_sequence *sequence, uint32_t number, found *f) {
    char name[400];
    if (f->status == NSDF_OK)
        f->status = nsdf_survey_add_look(survey, number, &f->look, &f->error);
    if (f->status == NSDF_OK)
        return 0;
    nsdf_sequence_name_frame(sequence, number, name, sizeof name);
    nsdf_cli_error("%s%s%s", f->was_read ? name : "", f->was_read ? ": " : "", f->error.message);
    return -1;
}

static int look_over(nsdf_survey *survey, looker *lookers, uint32_t count, const nsdf_cli_list *frames,
                     uint64_t *triangles) {
    batch work;
    for (uint32_t at = 0; at < frames->count; at += work.count) {
        const uint32_t left = frames->count - at, most = count * FRAMES_EACH;
        nsdf_cli_progress("looking over frame %u of %u", at + 1, frames->count);
        work.numbers = frames->numbers + at;
        work.count = left < most ? left : most;
        atomic_init(&work.next, 0);
        for (uint32_t i = 0; i < count; i++)
            lookers[i].work = &work;
        run_all(lookers, count);
        if (nsdf_cli_interrupts() > 0) {
            nsdf_cli_error("interrupted: nothing was written");
            return -1;
        }
        for (uint32_t i = 0; i < work.count; i++) {
            if (add(survey, lookers[0].sequence, work.numbers[i], &work.frames[i]) != 0)
                return -1;
            *triangles += work.frames[i].look.triangles;
        }
    }
    return 0;
}

static uint32_t count_lookers(uint32_t threads, uint32_t frames) {
    const long cores = threads > 0 ? (long)threads : sysconf(_SC_NPROCESSORS_ONLN);
    const uint32_t wanted = cores < 1 ? 1 : cores < MOST_THREADS ? (uint32_t)cores : MOST_THREADS;
    return wanted < frames ? wanted : frames;
}

int enc_look_over(nsdf_survey *survey, nsdf_sequence *sequence, const nsdf_cli_list *frames, uint32_t threads,
                  uint64_t *triangles) {
    looker lookers[MOST_THREADS];
    nsdf_encoder_error error;
    const uint32_t wanted = count_lookers(threads, frames->count);
    uint32_t count = 1;
    memset(lookers, 0, sizeof lookers);
    lookers[0].sequence = sequence;
    while (count < wanted && nsdf_sequence_share(sequence, &lookers[count].sequence, &error) == NSDF_OK)
        count++;
    const int result = look_over(survey, lookers, count, frames, triangles);
    for (uint32_t i = 1; i < count; i++)
        nsdf_sequence_close(&lookers[i].sequence);
    return result;
}

#include "frame_queue.h"

#include "cli_util.h"
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { FRAMES = 6 };

typedef enum frame_use { FREE, DECODED, READY, SHOWN } frame_use;

typedef struct held_frame {
    play_frame frame;
    nsdf_mesh *mesh;
    frame_use use;
} held_frame;

/* What the thread is to decode next. */
typedef struct job {
    double time, due;
    uint32_t resolution;
    int first; /* after a new plan: it cannot be ready before it is asked for */
} job;

struct play_queue {
    nsdf_decoder *decoder;
    nsdf_cli_input *input; /* or NULL */
    pthread_t thread;
    pthread_mutex_t lock; /* of all below */
    pthread_cond_t changed;
    int quit, fresh; /* fresh: nothing was decoded for the plan yet */
    uint64_t plans;  /* how many there were */
    play_plan plan;
    play_pace pace;
    held_frame frames[FRAMES];
    double anchor; /* wall time of slot 0 of the plan */
    double next;   /* slot */
    double still_time;
    uint32_t still_resolution; /* of the frame that a standing clock has; 0 = none */
    play_queue_state state;
    uint64_t number;
    double drawing; /* seconds for a frame */
};

/* ---- What to decode next: called with the lock ----------------------------------------------------------- */

static held_frame *free_frame(play_queue *q) {
    for (int i = 0; i < FRAMES; i++)
        if (q->frames[i].use == FREE)
            return &q->frames[i];
    return NULL;
}

static uint32_t playing_resolution(const play_queue *q) {
    return q->plan.resolution ? q->plan.resolution : q->pace.resolution;
}

/* A standing clock gets a frame at once, and then one at the highest resolution. */
static int choose_still(play_queue *q, double now, job *j) {
    const uint32_t best = q->plan.resolution ? q->plan.resolution : q->plan.most;
    const double time = play_clock_time(&q->plan.clock, now);
    if (q->still_resolution == best && q->still_time == time)
        return 0;
    const int again = q->still_resolution > 0 && q->still_time == time;
    *j = (job){time, now, again ? best : playing_resolution(q), 1};
    return 1;
}

static int choose_moving(play_queue *q, double now, job *j) {
    const double cost = q->pace.cost;
    if (q->fresh) {
        q->anchor = now + cost;
        q->next = 0.0;
    }
    const double soonest = ceil((now + 0.5 * cost - q->anchor) * q->plan.rate);
    if (!q->fresh && soonest > q->next) {
        q->state.skipped += (uint64_t)(soonest - q->next);
        q->next = soonest;
    }
    const double due = q->anchor + q->next / q->plan.rate;
    *j = (job){play_clock_time(&q->plan.clock, due), due, playing_resolution(q), q->fresh};
    return 1;
}

static int choose(play_queue *q, job *j) {
    const double now = nsdf_cli_clock();
    if (!play_clock_moves(&q->plan.clock, now))
        return choose_still(q, now, j);
    q->still_resolution = 0;
    return choose_moving(q, now, j);
}

/* ---- The segment behind the one that is decoded ------------------------------------------------------------- */

/* The segment of a time, and the one that a moving clock comes to next; 0, or -1 when there is none. */
static int next_segment(const play_queue *q, double time, int forward, nsdf_segment_info *at, nsdf_segment_info *next) {
    uint32_t i = 0;
    nsdf_segment_info s;
    while (nsdf_get_segment_extent(q->decoder, i, at) == NSDF_OK && time >= at->end)
        i++;
    if (nsdf_get_segment_extent(q->decoder, i, &s) != NSDF_OK || (!forward && i == 0))
        return -1;
    return nsdf_get_segment_extent(q->decoder, forward ? i + 1 : i - 1, next) == NSDF_OK ? 0 : -1;
}

/* With a network between, the next segment is fetched while this one is shown. */
static void fetch_ahead(play_queue *q, const play_clock *clock, double time) {
    nsdf_segment_info at, next;
    if (!q->input || !nsdf_cli_input_is_remote(q->input) || !play_clock_moves(clock, nsdf_cli_clock()) ||
        next_segment(q, time, clock->speed > 0.0, &at, &next) != 0)
        return;
    const double distance = clock->speed > 0.0 ? next.start - next.fade - time : time - at.start - at.fade;
    nsdf_cli_input_ahead(q->input, next.offset, next.size, distance / fabs(clock->speed));
}

/* ---- The thread ------------------------------------------------------------------------------------------ */

typedef struct cancelling {
    play_queue *queue;
    uint64_t plans;
} cancelling;

static int is_obsolete(void *user) {
    cancelling *c = user;
    pthread_mutex_lock(&c->queue->lock);
    const int obsolete = c->queue->quit || c->queue->plans != c->plans;
    pthread_mutex_unlock(&c->queue->lock);
    return obsolete;
}

static double waited(const play_queue *q) {
    return q->input ? nsdf_cli_input_waited(q->input) : 0.0;
}

/* h->frame.seconds are those of decoding; *late becomes those of waiting for a network. */
static nsdf_status decode(play_queue *q, held_frame *h, const job *j, uint64_t plans, double *late) {
    cancelling c = {q, plans};
    nsdf_mesh_options options;
    nsdf_mesh_options_init(&options);
    options.resolution = j->resolution;
    options.cancel = is_obsolete;
    options.cancel_user = &c;
    const double waited_before = waited(q), began = nsdf_cli_clock();
    nsdf_status status = nsdf_extract_mesh(q->decoder, j->time, &options, &h->mesh);
    if (status == NSDF_OK)
        status = nsdf_mesh_get_view(h->mesh, &h->frame.view);
    h->frame.time = j->time;
    h->frame.due = j->due;
    h->frame.resolution = j->resolution;
    *late = waited(q) - waited_before;
    h->frame.seconds = nsdf_cli_clock() - began - *late;
    return status;
}

/* Of the time between two frames, what drawing leaves.  Part of that does not depend on the resolution, so that a lower
 * one cannot make up for all of it. */
static double time_to_decode(const play_queue *q) {
    const double interval = 1.0 / q->plan.rate;
    return interval - fmin(q->drawing, 0.4 * interval);
}

/* With the lock. */
static void finish(play_queue *q, held_frame *h, const job *j, nsdf_status status, uint64_t plans, double late) {
    const int wanted = q->plans == plans && status != NSDF_CANCELLED;
    const double now = nsdf_cli_clock();
    h->use = FREE;
    if (!wanted)
        return;
    q->state.status = status;
    q->fresh = 0;
    q->next += 1.0;
    if (!play_clock_moves(&q->plan.clock, now)) {
        q->still_time = j->time;
        q->still_resolution = j->resolution;
    } else if (!q->plan.resolution) {
        play_pace_note(&q->pace, j->resolution, h->frame.seconds, time_to_decode(q), !j->first && now - late > j->due);
    }
    if (status != NSDF_OK)
        return;
    q->state.decoded++;
    h->frame.number = ++q->number;
    h->use = READY;
}

static void *run(void *data) {
    play_queue *q = data;
    pthread_mutex_lock(&q->lock);
    while (!q->quit) {
        held_frame *h = free_frame(q);
        job j;
        if (!h || !choose(q, &j)) {
            pthread_cond_wait(&q->changed, &q->lock);
            continue;
        }
        const uint64_t plans = q->plans;
        const play_clock clock = q->plan.clock;
        h->use = DECODED;
        pthread_mutex_unlock(&q->lock);
        double late;
        const nsdf_status status = decode(q, h, &j, plans, &late);
        fetch_ahead(q, &clock, j.time);
        pthread_mutex_lock(&q->lock);
        finish(q, h, &j, status, plans, late);
    }
    pthread_mutex_unlock(&q->lock);
    return NULL;
}

/* ---- The other side -------------------------------------------------------------------------------------- */

play_queue *play_queue_create(nsdf_decoder *decoder, nsdf_cli_input *input, const play_plan *plan) {
    play_queue *q = calloc(1, sizeof *q);
    if (!q)
        return NULL;
    q->decoder = decoder;
    q->input = input;
    q->plan = *plan;
    q->pace = play_pace_make(plan->most < 96 ? plan->most : 96, plan->most);
    q->fresh = 1;
    pthread_mutex_init(&q->lock, NULL);
    pthread_cond_init(&q->changed, NULL);
    if (pthread_create(&q->thread, NULL, run, q) == 0)
        return q;
    pthread_cond_destroy(&q->changed);
    pthread_mutex_destroy(&q->lock);
    free(q);
    return NULL;
}

void play_queue_free(play_queue *q) {
    if (!q)
        return;
    pthread_mutex_lock(&q->lock);
    q->quit = 1;
    pthread_cond_signal(&q->changed);
    pthread_mutex_unlock(&q->lock);
    pthread_join(q->thread, NULL);
    for (int i = 0; i < FRAMES; i++)
        nsdf_mesh_free(&q->frames[i].mesh);
    pthread_cond_destroy(&q->changed);
    pthread_mutex_destroy(&q->lock);
    free(q);
}

void play_queue_set_plan(play_queue *q, const play_plan *plan) {
    pthread_mutex_lock(&q->lock);
    q->plan = *plan;
    q->plans++;
    q->fresh = 1;
    q->still_resolution = 0;
    q->pace.most = plan->most;
    if (q->pace.resolution > plan->most)
        q->pace = play_pace_make(plan->most, plan->most);
    for (int i = 0; i < FRAMES; i++)
        if (q->frames[i].use == READY)
            q->frames[i].use = FREE;
    pthread_cond_signal(&q->changed);
    pthread_mutex_unlock(&q->lock);
}

void play_queue_set_drawing(play_queue *q, double seconds) {
    pthread_mutex_lock(&q->lock);
    q->drawing = seconds;
    pthread_mutex_unlock(&q->lock);
}

const play_frame *play_queue_take(play_queue *q, double wall) {
    held_frame *shown = NULL, *latest = NULL;
    pthread_mutex_lock(&q->lock);
    for (int i = 0; i < FRAMES; i++) {
        held_frame *h = &q->frames[i];
        if (h->use == SHOWN)
            shown = h;
        if (h->use == READY && h->frame.due <= wall && (!latest || h->frame.number > latest->frame.number))
            latest = h;
    }
    for (int i = 0; latest && i < FRAMES; i++) {
        held_frame *h = &q->frames[i];
        if (h == shown || (h->use == READY && h->frame.number < latest->frame.number))
            h->use = FREE;
    }
    if (latest) {
        latest->use = SHOWN;
        shown = latest;
    }
    pthread_cond_signal(&q->changed); /* also because time has passed */
    pthread_mutex_unlock(&q->lock);
    return shown ? &shown->frame : NULL;
}

play_queue_state play_queue_get_state(play_queue *q) {
    pthread_mutex_lock(&q->lock);
    play_queue_state state = q->state;
    state.resolution = playing_resolution(q);
    state.ahead = 0;
    for (int i = 0; i < FRAMES; i++)
        state.ahead += q->frames[i].use == READY;
    pthread_mutex_unlock(&q->lock);
    return state;
}

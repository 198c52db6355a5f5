/* Frames decoded ahead of the clock by a thread of their own.
 *
 * While the clock moves there is a frame for every 1 / rate seconds on the wall, each of the time that the clock will
 * have then; those that would be ready too late are not begun, so that a slow machine shows fewer frames, never later
 * ones.  While it stands there is one frame, of just that time, at the highest resolution. */
#ifndef PLAY_FRAME_QUEUE_H
#define PLAY_FRAME_QUEUE_H

#include "cli_input.h"
#include "clock.h"
#include "nsdf/decoder.h"
#include "pace.h"

typedef struct play_plan {
    play_clock clock;
    double rate;         /* frames a second on the wall, > 0 */
    uint32_t resolution; /* 0 = automatic */
    uint32_t most;       /* of the automatic ones; what a standing clock gets */
} play_plan;

typedef struct play_frame {
    nsdf_mesh_view view;
    double time;    /* of the file, seconds */
    double due;     /* on the wall: when the clock gets there */
    double seconds; /* that decoding took */
    uint32_t resolution;
    uint64_t number; /* frames get ascending ones */
} play_frame;

typedef struct play_queue play_queue;

/* Takes over the decoder: nobody else may call it until play_queue_free gives it back.  `input` is what it reads, so
 * that waiting for a network is not taken for slow decoding; NULL for memory.  NULL when memory or threads
 * ran out. */
play_queue *play_queue_create(nsdf_decoder *decoder, nsdf_cli_input *input, const play_plan *plan);
/* Stops the thread, cancelling what it is at. */
void play_queue_free(play_queue *queue);

/* Frames that were decoded for another plan are dropped, but the one that play_queue_take returned last. */
void play_queue_set_plan(play_queue *queue, const play_plan *plan);

/* How long drawing a frame takes at now: processors that draw as well have less time to decode, so that the automatic
 * resolution counts it, as far as it is no more than 0.4 of the time between two frames. */
void play_queue_set_drawing(play_queue *queue, double seconds);

/* The latest frame that is due at `wall`, borrowed until the next call; NULL until there is any.  The same frame
 * (number) again as long as there is no later one. */
const play_frame *play_queue_take(play_queue *queue, double wall);

typedef struct play_queue_state {
    nsdf_status status;        /* of the last frame */
    uint32_t ahead;            /* frames that are ready, but not yet due */
    uint32_t resolution;       /* that is decoded at now */
    uint64_t decoded, skipped; /* frames in all; those that were not begun because they would have been late */
} play_queue_state;

play_queue_state play_queue_get_state(play_queue *queue);

#endif

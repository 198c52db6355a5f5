/* A file being played: its decoder and frames, and the clock that they follow. */
#ifndef PLAY_SESSION_H
#define PLAY_SESSION_H

#include "cli_input.h"
#include "frame_queue.h"
#include "play_options.h"

typedef struct play_session {
    nsdf_cli_input *input; /* NULL while no file is open */
    nsdf_info info;
    nsdf_decoder *decoder, *ghost_decoder;
    play_queue *queue, *ghost_queue; /* the ghost's are there while it is shown */
    play_plan plan;
    uint32_t threads;
    double ghost_time;
} play_session;

/* Opens a file or a URL and begins to decode.  0, or -1 with *session untouched and *error saying why. */
int play_session_open(play_session *session, const char *name, const play_options *options, nsdf_error *error);
void play_session_close(play_session *session);

/* After a change of session->plan. */
void play_session_replan(play_session *session);
/* Moves by encoded frames and stands there. */
void play_session_step(play_session *session, int frames);

/* Shows the encoded frame before the time `time` too, or not.  0, or -1 when the file cannot be opened again. */
int play_session_show_ghost(play_session *session, int shown);
/* The ghost for a surface at that time, as play_queue_take; NULL when there is none. */
const play_frame *play_session_ghost(play_session *session, double time, double wall);

#endif

#include "session.h"

#include "cli_util.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view_setup.h"

static nsdf_status open_decoder(nsdf_cli_input *input, nsdf_decoder **decoder, uint32_t threads, nsdf_error *error) {
    nsdf_decoder_options options;
    nsdf_decoder_options_init(&options);
    options.threads = threads;
    return nsdf_cli_input_decoder(input, decoder, &options, error);
}

static play_plan first_plan(const play_options *o, const nsdf_info *info) {
    const double file_rate = (double)info->rate_num / info->rate_den, now = nsdf_cli_clock();
    play_plan plan = {.clock = play_clock_make(info->duration, 1.0 / file_rate),
                      .rate = o->rate > 0.0 ? o->rate : file_rate,
                      .resolution = o->resolution,
                      .most = info->default_resolution};
    play_clock_set_loop(&plan.clock, now, !o->once);
    play_clock_set_speed(&plan.clock, now, o->speed);
    play_clock_seek(&plan.clock, now, o->at);
    if (!o->paused)
        play_clock_play(&plan.clock, now);
    return plan;
}

int play_session_open(play_session *session, const char *name, const play_options *options, nsdf_error *error) {
    play_session s = {.threads = options->threads, .ghost_time = -1.0};
    s.input = nsdf_cli_input_open(name, options->timeout, error);
    if (!s.input || open_decoder(s.input, &s.decoder, s.threads, error) != NSDF_OK) {
        nsdf_cli_input_close(s.input);
        return -1;
    }
    if (nsdf_get_info(s.decoder, &s.info) == NSDF_OK) {
        s.plan = first_plan(options, &s.info);
        s.queue = play_queue_create(s.decoder, s.input, &s.plan);
    }
    if (s.queue) {
        *session = s;
        return 0;
    }
    nsdf_close(&s.decoder);
    nsdf_cli_input_close(s.input);
    *error = (nsdf_error){.status = NSDF_NO_MEMORY, .message = "no memory, or no thread to decode with"};
    return -1;
}

void play_session_close(play_session *s) {
    if (s->input)
        nsdf_cli_input_cancel(s->input);
    play_queue_free(s->queue);
    play_queue_free(s->ghost_queue);
    nsdf_close(&s->decoder);
    nsdf_close(&s->ghost_decoder);
    nsdf_cli_input_close(s->input);
    memset(s, 0, sizeof *s);
}

void play_session_replan(play_session *s) {
    play_queue_set_plan(s->queue, &s->plan);
}

void play_session_step(play_session *s, int frames) {
    const double now = nsdf_cli_clock(), rate = (double)s->info.rate_num / s->info.rate_den;
    const double at = play_clock_time(&s->plan.clock, now) * rate, last = (double)s->info.frame_count - 1.0;
    const double to = frames > 0 ? floor(at + 1e-6) + frames : ceil(at - 1e-6) + frames;
    double seconds = 0.0;
    if (nsdf_frame_time(s->decoder, (uint32_t)fmin(fmax(to, 0.0), last), &seconds) != NSDF_OK)
        return;
    play_clock_pause(&s->plan.clock, now);
    play_clock_seek(&s->plan.clock, now, seconds);
    play_session_replan(s);
}

/* ---- Ghost ----------------------------------------------------------------------------------------------- */

enum { GHOST_RESOLUTION = 96 };

static play_plan ghost_plan(const play_session *s) {
    play_plan plan = {.clock = play_clock_make(s->info.duration, 0.0), .rate = s->plan.rate, .most = s->plan.most};
    plan.resolution = plan.most < GHOST_RESOLUTION ? plan.most : GHOST_RESOLUTION;
    return plan;
}

int play_session_show_ghost(play_session *s, int shown) {
    nsdf_error error;
    if (!shown) {
        play_queue_free(s->ghost_queue);
        s->ghost_queue = NULL;
        nsdf_close(&s->ghost_decoder);
        return 0;
    }
    if (s->ghost_queue)
        return 0;
    if (open_decoder(s->input, &s->ghost_decoder, 1, &error) != NSDF_OK)
        return -1;
    const play_plan plan = ghost_plan(s);
    s->ghost_queue = play_queue_create(s->ghost_decoder, s->input, &plan);
    s->ghost_time = -1.0;
    if (s->ghost_queue)
        return 0;
    nsdf_close(&s->ghost_decoder);
    return -1;
}

const play_frame *play_session_ghost(play_session *s, double time, double wall) {
    const uint32_t before = play_frame_before(&s->info, time);
    const double seconds = (double)before * s->info.rate_den / s->info.rate_num;
    if (!s->ghost_queue)
        return NULL;
    if (seconds != s->ghost_time) {
        play_plan plan = ghost_plan(s);
        play_clock_seek(&plan.clock, wall, seconds);
        play_queue_set_plan(s->ghost_queue, &plan);
        s->ghost_time = seconds;
    }
    return play_queue_take(s->ghost_queue, wall);
}

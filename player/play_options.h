/* The command line of nsdf-play. */
#ifndef PLAY_OPTIONS_H
#define PLAY_OPTIONS_H

#include "camera.h"
#include "cli_times.h"
#include "renderer.h"

typedef enum play_action { PLAY_NOTHING, PLAY_WINDOW, PLAY_OFFSCREEN } play_action;

typedef enum play_picture { PLAY_PNG, PLAY_RGBA, PLAY_Y4M } play_picture;

typedef struct play_options {
    play_action action;
    const char *input, *output; /* borrowed from argv, like the other strings; input may be NULL for a window */
    nsdf_cli_choice choice;     /* offscreen */
    play_picture picture;
    int has_picture;
    double turntable; /* seconds for one turn; 0 = none */
    int width, height;
    play_up up;
    double azimuth, elevation, zoom; /* zoom 0 = not given */
    play_mode mode;
    int ground, ghost, transparent, overlay, samples; /* samples 0 = not given */
    double speed, rate;                               /* rate of the window's frames; 0 = the file's */
    double at;                                        /* seconds at which a window begins */
    uint32_t resolution, threads;
    uint32_t timeout;    /* seconds, of the network */
    const char *compare; /* folder, or NULL */
    int heatmap;
    double heatmap_max; /* as a fraction of the diagonal */
    int paused, once;
    double exit_after; /* seconds; 0 = never */
    int statistics;
} play_options;

/* NSDF_CLI_SUCCESS, or NSDF_CLI_USAGE after printing why. */
int play_options_parse(int argc, char **argv, play_options *options);

#endif

/* From options and a file to what is drawn: shared by the window and the pictures. */
#ifndef PLAY_VIEW_SETUP_H
#define PLAY_VIEW_SETUP_H

#include "play_options.h"

play_scene play_scene_make(const play_options *options, const nsdf_info *info);

/* The last encoded frame that is earlier than a time, or frame 0. */
uint32_t play_frame_before(const nsdf_info *info, double seconds);

/* The encoded frame that is shown at a time when there are no others: the last that is not later. */
uint32_t play_frame_at(const nsdf_info *info, double seconds);

/* Frames a second of a film of the chosen times: that of --fps, or the file's. */
void play_film_rate(const nsdf_info *info, const nsdf_cli_choice *choice, unsigned *num, unsigned *den);
/* Seconds from the film's beginning at which picture `index` is shown. */
double play_film_time(const nsdf_info *info, const nsdf_cli_choice *choice, const nsdf_cli_times *times,
                      uint32_t index);

/* A path without its folders. */
const char *play_file_name(const char *path);

#endif

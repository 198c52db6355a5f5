/* Which times of an animation are frames. */
#ifndef NSDF_FILM_FRAMES_H
#define NSDF_FILM_FRAMES_H

#include "gltf_read.h"

/* Chooses a frame rate, where *rate_num is 0: for steps the lowest at which every key is a frame, otherwise 25 if it
 * does, or the lowest from 20 on, or 25.  Then gives the number of frames, the first at the first key and the last at
 * or before the last, and says in `note` when keys lie between frames.  NSDF_LIMIT for too many frames. */
nsdf_status nsdf_film_frames(const nsdf_gltf_film_info *film, const char *name, uint32_t *rate_num, uint32_t *rate_den,
                             uint32_t *frames, char *note, size_t note_size, nsdf_encoder_error *error);

/* Keys so much before the time of a frame, or behind it, are its keys: part of an interval. */
#define NSDF_FILM_SLACK 0.01

#endif

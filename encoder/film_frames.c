#include "film_frames.h"

#include <math.h>
#include <stdio.h>

#include "input_error.h"
#include "rate_fit.h"

static void choose_rate(const nsdf_gltf_film_info *film, uint32_t *rate_num, uint32_t *rate_den) {
    uint32_t rate[2] = {25, 1};
    if (film->in_steps) {
        (void)nsdf_fit_rate(film->keys, film->key_count, 1, rate);
    } else if (!nsdf_fits_closely(film->keys, film->key_count, 25, 1)) {
        (void)nsdf_fit_rate(film->keys, film->key_count, 20, rate);
    }
    *rate_num = rate[0];
    *rate_den = rate[1];
}

static void note_keys(const nsdf_gltf_film_info *film, uint32_t rate_num, uint32_t rate_den, char *note, size_t size) {
    uint32_t rate[2];
    note[0] = '\0';
    if (!nsdf_fits_closely(film->keys, film->key_count, rate_num, rate_den) &&
        nsdf_fit_rate(film->keys, film->key_count, film->in_steps ? 1 : 20, rate)) {
        snprintf(note, size, "keys of its animation lie between the frames; with --fps %s all are frames",
                 nsdf_show_rate(rate[0], rate[1]).text);
    }
}

nsdf_status nsdf_film_frames(const nsdf_gltf_film_info *film, const char *name, uint32_t *rate_num, uint32_t *rate_den,
                             uint32_t *frames, char *note, size_t note_size, nsdf_encoder_error *error) {
    if (*rate_num == 0) {
        choose_rate(film, rate_num, rate_den);
    }
    note_keys(film, *rate_num, *rate_den, note, note_size);
    const double end = film->keys[film->key_count - 1] * *rate_num / *rate_den;
    const double count = film->ends_held ? ceil(end - NSDF_FILM_SLACK) : floor(end + NSDF_FILM_SLACK) + 1.0;
    if (!(count < UINT32_MAX)) {
        return nsdf_input_fail(error, NSDF_LIMIT, "%s: its animation is too long", nsdf_show_path(name).text);
    }
    *frames = count < 1.0 ? 1 : (uint32_t)count;
    return NSDF_OK;
}

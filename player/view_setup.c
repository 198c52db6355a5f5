#include "view_setup.h"

#include <string.h>

play_scene play_scene_make(const play_options *o, const nsdf_info *info) {
    play_scene s = {.mode = o->mode, .ground = o->ground, .ghost = o->ghost, .transparent = o->transparent};
    const double aspect = (double)o->width / o->height;
    for (int i = 0; i < 3; i++) {
        s.box.low[i] = info->box_min[i];
        s.box.high[i] = info->box_max[i];
    }
    s.camera = play_camera_make(&s.box, o->up, aspect);
    s.camera.azimuth = o->azimuth;
    s.camera.elevation = o->elevation;
    play_camera_fit(&s.camera, &s.box, aspect);
    s.camera.zoom = o->zoom;
    return s;
}

uint32_t play_frame_before(const nsdf_info *info, double seconds) {
    const double at = seconds * info->rate_num / info->rate_den - 1e-6;
    const double last = (double)info->frame_count - 1.0;
    return at <= 0.0 ? 0 : (uint32_t)(at < last ? at : last);
}

uint32_t play_frame_at(const nsdf_info *info, double seconds) {
    const double at = seconds * info->rate_num / info->rate_den + 1e-6;
    const double last = (double)info->frame_count - 1.0;
    return (uint32_t)(at < last ? at : last);
}

void play_film_rate(const nsdf_info *info, const nsdf_cli_choice *choice, unsigned *num, unsigned *den) {
    *num = choice->rate_num ? choice->rate_num : info->rate_num;
    *den = choice->rate_num ? choice->rate_den : info->rate_den;
}

double play_film_time(const nsdf_info *info, const nsdf_cli_choice *choice, const nsdf_cli_times *times,
                      uint32_t index) {
    unsigned num, den;
    if (times->count > 1 && choice->times)
        return times->seconds[index];
    play_film_rate(info, choice, &num, &den);
    return (double)index * den / num;
}

const char *play_file_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

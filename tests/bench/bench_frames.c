#include "bench_frames.h"

#include <stdio.h>
#include <string.h>

int bench_check(const char *what, nsdf_status status) {
    if (status == NSDF_OK)
        return 0;
    fprintf(stderr, "bench_speed: %s: %s\n", what, nsdf_status_string(status));
    return -1;
}

static nsdf_status choose_times(bench_frames *frames, uint32_t wanted) {
    nsdf_info info;
    nsdf_status status = nsdf_get_info(frames->decoder, &info);
    if (status != NSDF_OK)
        return status;
    frames->count = info.frame_count < wanted ? info.frame_count : wanted;
    for (uint32_t i = 0; i < frames->count && status == NSDF_OK; i++) {
        const uint32_t frame = (uint32_t)((uint64_t)i * info.frame_count / frames->count);
        status = nsdf_frame_time(frames->decoder, frame, &frames->times[i]);
    }
    return status;
}

int bench_frames_open(bench_frames *frames, const bench_speed_options *options, uint32_t threads, uint32_t cpu_mask) {
    nsdf_decoder_options opening;
    memset(frames, 0, sizeof *frames);
    nsdf_decoder_options_init(&opening);
    nsdf_mesh_options_init(&frames->options);
    opening.threads = threads;
    opening.cpu_mask = cpu_mask;
    nsdf_status status = nsdf_open_file(&frames->decoder, options->file, &opening, NULL);
    if (status == NSDF_OK)
        status = choose_times(frames, options->frames);
    return bench_check(options->file, status);
}

void bench_frames_close(bench_frames *frames) {
    nsdf_mesh_free(&frames->mesh);
    nsdf_close(&frames->decoder);
}

void bench_frames_run(void *data) {
    bench_frames *frames = data;
    nsdf_mesh_view view;
    frames->vertices = frames->triangles = 0;
    for (uint32_t i = 0; i < frames->count && frames->status == NSDF_OK; i++) {
        frames->status = nsdf_extract_mesh(frames->decoder, frames->times[i], &frames->options, &frames->mesh);
        if (frames->status == NSDF_OK)
            frames->status = nsdf_mesh_get_view(frames->mesh, &view);
        if (frames->status == NSDF_OK) {
            frames->vertices += view.vertex_count;
            frames->triangles += view.triangle_count;
        }
    }
}

/* Plays an .nsdf file as a player would, without a screen: one mesh whose storage is used again, a time budget for each
 * frame, and the segment that comes next loaded before its time.
 * Build: cc play_loop.c $(pkg-config --cflags --libs nsdf) -o play_loop */
#include <nsdf/decoder.h>

#include <stdio.h>

/* Half of a frame's time is left for drawing. */
static const double budget = 0.5;

static nsdf_status play(nsdf_decoder *decoder) {
    nsdf_info info;
    nsdf_mesh *mesh = NULL;
    nsdf_status status = nsdf_get_info(decoder, &info);
    const double frame_seconds = status == NSDF_OK ? (double)info.rate_den / info.rate_num : 0;
    for (uint32_t i = 0; status == NSDF_OK && i < info.frame_count; i++) {
        nsdf_mesh_view view;
        uint32_t resolution;
        double t;
        status = nsdf_frame_time(decoder, i, &t);
        if (status == NSDF_OK)
            status = nsdf_extract_mesh_within(decoder, t, NULL, budget * frame_seconds, &mesh, &resolution);
        if (status == NSDF_OK)
            status = nsdf_mesh_get_view(mesh, &view);
        if (status != NSDF_OK)
            break;
        printf("%.3f s: resolution %lu, %lu triangles\n", t, (unsigned long)resolution,
               (unsigned long)view.triangle_count); /* here a player draws */
        status = nsdf_prepare(decoder, t + frame_seconds);
    }
    nsdf_mesh_free(&mesh);
    return status;
}

int main(int argc, char **argv) {
    nsdf_decoder *decoder = NULL;
    nsdf_error error;
    if (argc != 2) {
        fprintf(stderr, "usage: play_loop FILE.nsdf\n");
        return 2;
    }
    if (nsdf_open_file(&decoder, argv[1], NULL, &error) != NSDF_OK) {
        fprintf(stderr, "play_loop: %s: %s\n", argv[1], error.message);
        return 1;
    }
    const nsdf_status status = play(decoder);
    if (status != NSDF_OK)
        fprintf(stderr, "play_loop: %s\n", nsdf_status_string(status));
    nsdf_close(&decoder);
    return status == NSDF_OK ? 0 : 1;
}

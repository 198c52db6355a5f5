#include "compare_view.h"

#include <stdio.h>
#include <stdlib.h>

#include "cli_util.h"
#include "heat.h"
#include "hud.h"
#include "reference.h"
#include "view_setup.h"

struct play_compare_view {
    const play_options *options;
    nsdf_decoder *decoder;
    nsdf_info info;
    play_reference *reference;
    float *heat; /* one for each vertex */
    play_overlay overlay;
};

static int no_memory(void) {
    nsdf_cli_error("out of memory");
    return NSDF_CLI_FAILURE;
}

int play_compare_open(play_compare_view **compare, const play_options *options, nsdf_decoder *decoder) {
    play_compare_view *c = calloc(1, sizeof *c);
    if (!c)
        return no_memory();
    c->options = options;
    c->decoder = decoder;
    int result = nsdf_get_info(decoder, &c->info) == NSDF_OK ? NSDF_CLI_SUCCESS : NSDF_CLI_FAILURE;
    if (result == NSDF_CLI_SUCCESS)
        result = play_reference_open(&c->reference, options->compare, c->info.frame_count);
    if (result == NSDF_CLI_SUCCESS)
        *compare = c;
    else
        play_compare_close(c);
    return result;
}

void play_compare_close(play_compare_view *c) {
    if (!c)
        return;
    play_reference_close(c->reference);
    play_overlay_free(&c->overlay);
    free(c->heat);
    free(c);
}

int play_compare_width(const play_options *options) {
    return options->heatmap ? options->width : options->width / 2;
}

/* The distances of the mesh's vertices to the surface of the same time. */
static int measure(play_compare_view *c, const nsdf_mesh_view *view, uint32_t frame) {
    const double top = c->options->heatmap_max * c->info.diagonal;
    double seconds;
    float *heat = realloc(c->heat, view->vertex_count * sizeof *heat + 1);
    if (!heat)
        return no_memory();
    c->heat = heat;
    nsdf_status status = nsdf_frame_time(c->decoder, frame, &seconds);
    if (status == NSDF_OK)
        status = play_heat_measure(c->decoder, seconds, view->positions, view->vertex_count, top, heat);
    if (status == NSDF_OK)
        return NSDF_CLI_SUCCESS;
    nsdf_cli_error("%s: %s", c->options->input, nsdf_status_string(status));
    return NSDF_CLI_FAILURE;
}

static void write_label(play_compare_view *c, uint32_t frame, int width) {
    char text[100];
    play_overlay_clear(&c->overlay);
    if (!c->options->overlay)
        return;
    snprintf(text, sizeof text, "input, frame %lu of %lu%s", (unsigned long)frame,
             (unsigned long)c->info.frame_count - 1, c->options->heatmap ? ", distance to decoded" : "");
    play_hud_caption(&c->overlay, text, c->options->height);
    if (c->options->heatmap)
        play_heat_legend(&c->overlay, c->options->heatmap_max, width, c->options->height);
}

int play_compare_draw(play_compare_view *c, play_renderer *renderer, const play_scene *scene, double seconds,
                      unsigned char *rgba) {
    const play_options *o = c->options;
    const int width = play_compare_width(o);
    const uint32_t frame = play_frame_at(&c->info, seconds);
    nsdf_mesh_view view;
    play_scene alone = *scene;
    int result = play_reference_load(c->reference, frame, &view);
    if (result == NSDF_CLI_SUCCESS && o->heatmap)
        result = measure(c, &view, frame);
    if (result != NSDF_CLI_SUCCESS)
        return result;
    alone.ghost = 0;
    write_label(c, frame, width);
    play_renderer_set_open_mesh(renderer, &view, o->heatmap ? c->heat : NULL);
    if (play_renderer_draw(renderer, &alone, &c->overlay, width, o->height) != 0)
        return no_memory();
    play_renderer_read(renderer, width, o->height, rgba, o->width);
    return NSDF_CLI_SUCCESS;
}

void play_compare_label(play_overlay *overlay, const play_options *options, double seconds, uint32_t resolution) {
    char text[100];
    snprintf(text, sizeof text, "decoded, %.3f s, resolution %lu", seconds, (unsigned long)resolution);
    play_hud_caption(overlay, text, options->height);
}

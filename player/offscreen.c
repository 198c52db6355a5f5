#include "offscreen.h"

#include <stdlib.h>
#include <string.h>

#include "cli_pattern.h"
#include "cli_util.h"
#include "compare_view.h"
#include "frame_queue.h"
#include "hud.h"
#include "offscreen_context.h"
#include "picture.h"
#include "view_setup.h"

enum { SAMPLES = 4 };

typedef struct job {
    const play_options *options;
    nsdf_cli_input *input;
    nsdf_decoder *decoder;
    nsdf_info info;
    nsdf_cli_times times;
    nsdf_cli_pattern pattern;
    play_renderer *renderer;
    play_scene scene;
    play_compare_view *compare; /* NULL = no comparison */
    nsdf_mesh *mesh, *ghost;
    unsigned char *rgba;
    nsdf_cli_file film; /* of raw frames */
    int to_stdout;
} job;

static int report(const job *j, nsdf_status status) {
    nsdf_error error;
    if (status == NSDF_CANCELLED || (status == NSDF_IO && nsdf_cli_interrupts() > 0)) {
        nsdf_cli_error("interrupted");
        return NSDF_CLI_FAILURE;
    }
    nsdf_cli_get_error(j->decoder, status, &error);
    nsdf_cli_input_explain(j->input, &error);
    nsdf_cli_nsdf_error(j->options->input, &error);
    return NSDF_CLI_FAILURE;
}

/* ---- One picture ----------------------------------------------------------------------------------------- */

static nsdf_status extract(const job *j, double seconds, nsdf_mesh **mesh, nsdf_mesh_view *view) {
    nsdf_mesh_options options;
    nsdf_mesh_options_init(&options);
    options.resolution = j->options->resolution;
    options.cancel = nsdf_cli_is_interrupted;
    const nsdf_status status = nsdf_extract_mesh(j->decoder, seconds, &options, mesh);
    return status == NSDF_OK ? nsdf_mesh_get_view(*mesh, view) : status;
}

static nsdf_status set_meshes(job *j, double seconds, nsdf_mesh_view *view) {
    nsdf_mesh_view ghost;
    double before;
    nsdf_status status = extract(j, seconds, &j->mesh, view);
    if (status != NSDF_OK)
        return status;
    play_renderer_set_mesh(j->renderer, PLAY_MESH_MAIN, view);
    if (!j->options->ghost)
        return NSDF_OK;
    status = nsdf_frame_time(j->decoder, play_frame_before(&j->info, seconds), &before);
    if (status == NSDF_OK)
        status = extract(j, before, &j->ghost, &ghost);
    if (status == NSDF_OK)
        play_renderer_set_mesh(j->renderer, PLAY_MESH_GHOST, &ghost);
    return status;
}

static uint32_t resolution(const job *j) {
    return j->options->resolution ? j->options->resolution : j->info.default_resolution;
}

static play_hud describe(const job *j, double seconds, const nsdf_mesh_view *view) {
    return (play_hud){.file = play_file_name(j->options->input),
                      .time = seconds,
                      .duration = j->info.duration,
                      .frame_count = j->info.frame_count,
                      .frame_rate = (double)j->info.rate_num / j->info.rate_den,
                      .speed = 1.0,
                      .playing = 1,
                      .resolution = resolution(j),
                      .vertices = view->vertex_count,
                      .file_size = j->info.file_size};
}

static int write_file(job *j, uint32_t index) {
    nsdf_cli_file file;
    char *name = j->to_stdout ? NULL : nsdf_cli_pattern_name(&j->pattern, index);
    if (!j->to_stdout && !name) {
        nsdf_cli_error("out of memory");
        return NSDF_CLI_FAILURE;
    }
    int result = NSDF_CLI_FAILURE;
    if (nsdf_cli_file_open(&file, name ? name : "-") == 0) {
        const play_options *o = j->options;
        const int failed = play_write_png(j->rgba, o->width, o->height, o->transparent, nsdf_cli_file_write, &file);
        if (nsdf_cli_file_close(&file) == 0 && !failed)
            result = NSDF_CLI_SUCCESS;
        else if (!file.failure)
            nsdf_cli_error("out of memory");
    }
    free(name);
    return result;
}

static int write_picture(job *j, uint32_t index) {
    const play_options *o = j->options;
    if (o->picture == PLAY_PNG)
        return write_file(j, index);
    const int failed = o->picture == PLAY_RGBA
                           ? play_write_rgba(j->rgba, o->width, o->height, nsdf_cli_file_write, &j->film)
                           : play_write_y4m_frame(j->rgba, o->width, o->height, nsdf_cli_file_write, &j->film);
    return failed ? NSDF_CLI_FAILURE : NSDF_CLI_SUCCESS; /* closing says why */
}

/* The decoded surface, from column `left` of the picture on. */
static int draw_surface(job *j, double seconds, int left) {
    const play_options *o = j->options;
    nsdf_mesh_view view;
    play_overlay overlay = {NULL, 0, 0};
    const nsdf_status status = set_meshes(j, seconds, &view);
    if (status != NSDF_OK)
        return report(j, status);
    if (o->overlay && j->compare) {
        play_compare_label(&overlay, o, seconds, resolution(j));
    } else if (o->overlay) {
        const play_hud hud = describe(j, seconds, &view);
        play_hud_draw(&overlay, &hud, o->width, o->height);
    }
    const int failed = play_renderer_draw(j->renderer, &j->scene, &overlay, o->width - left, o->height);
    play_overlay_free(&overlay);
    if (failed) {
        nsdf_cli_error("no memory for a picture of %d x %d pixels", o->width, o->height);
        return NSDF_CLI_FAILURE;
    }
    play_renderer_read(j->renderer, o->width - left, o->height, j->rgba + 4 * (size_t)left, o->width);
    return NSDF_CLI_SUCCESS;
}

static int draw_frame(job *j, uint32_t index) {
    const play_options *o = j->options;
    const double seconds = j->times.seconds[index];
    const int left = j->compare ? play_compare_width(o) : 0;
    int result = NSDF_CLI_SUCCESS;
    if (o->turntable > 0.0)
        j->scene.camera.azimuth =
            o->azimuth + 360.0 * play_film_time(&j->info, &o->choice, &j->times, index) / o->turntable;
    if (j->compare)
        result = play_compare_draw(j->compare, j->renderer, &j->scene, seconds, j->rgba);
    if (result == NSDF_CLI_SUCCESS && left < o->width)
        result = draw_surface(j, seconds, left);
    return result == NSDF_CLI_SUCCESS ? write_picture(j, index) : result;
}

/* ---- All of them ----------------------------------------------------------------------------------------- */

static int check_names(const job *j) {
    if (j->times.count == 1 || (j->to_stdout && j->options->picture != PLAY_PNG))
        return NSDF_CLI_SUCCESS;
    if (j->to_stdout)
        return nsdf_cli_usage_error("--format png writes one picture to standard output, and there are %lu",
                                    (unsigned long)j->times.count);
    if (!j->pattern.suffix)
        return nsdf_cli_usage_error("%s: %lu pictures need numbered names, such as out_%%04d.png", j->options->output,
                                    (unsigned long)j->times.count);
    return NSDF_CLI_SUCCESS;
}

static int draw_all(job *j) {
    const double began = nsdf_cli_clock();
    int result = NSDF_CLI_SUCCESS;
    for (uint32_t i = 0; i < j->times.count && result == NSDF_CLI_SUCCESS; i++) {
        nsdf_cli_progress("picture %lu of %lu", (unsigned long)i + 1, (unsigned long)j->times.count);
        result = draw_frame(j, i);
    }
    if (result == NSDF_CLI_SUCCESS && nsdf_cli_commit() != 0)
        result = NSDF_CLI_FAILURE;
    if (result == NSDF_CLI_SUCCESS)
        nsdf_cli_say("%lu picture%s, %.3g a second", (unsigned long)j->times.count, j->times.count == 1 ? "" : "s",
                     j->times.count / (nsdf_cli_clock() - began));
    return result;
}

static int draw_film(job *j) {
    const play_options *o = j->options;
    unsigned num, den;
    if (o->picture == PLAY_PNG)
        return draw_all(j);
    if (nsdf_cli_file_open(&j->film, "-") != 0)
        return NSDF_CLI_FAILURE;
    play_film_rate(&j->info, &o->choice, &num, &den);
    int result = NSDF_CLI_SUCCESS;
    if (o->picture == PLAY_Y4M &&
        play_write_y4m_header(o->width, o->height, num, den, nsdf_cli_file_write, &j->film) != 0)
        result = NSDF_CLI_FAILURE;
    if (result == NSDF_CLI_SUCCESS)
        result = draw_all(j);
    return nsdf_cli_file_close(&j->film) == 0 ? result : NSDF_CLI_FAILURE;
}

static int draw(job *j, play_offscreen_context **context) {
    const play_options *o = j->options;
    char why[512];
    *context = play_offscreen_context_create(o->width, o->height, why, sizeof why);
    if (*context)
        j->renderer = play_renderer_create(play_offscreen_lookup, o->samples ? o->samples : SAMPLES, why, sizeof why);
    if (!j->renderer) {
        nsdf_cli_error("%s", why);
        return NSDF_CLI_FAILURE;
    }
    nsdf_cli_verbose("%s", play_renderer_name(j->renderer));
    j->rgba = malloc(4 * (size_t)o->width * (size_t)o->height);
    if (!j->rgba) {
        nsdf_cli_error("out of memory");
        return NSDF_CLI_FAILURE;
    }
    play_options panel = *o;
    if (j->compare)
        panel.width = play_compare_width(o);
    j->scene = play_scene_make(&panel, &j->info);
    return draw_film(j);
}

int play_offscreen_run(const play_options *options, nsdf_cli_input *input, nsdf_decoder *decoder) {
    job j = {.options = options, .input = input, .decoder = decoder};
    play_offscreen_context *context = NULL;
    j.to_stdout = strcmp(options->output, "-") == 0;
    int result = nsdf_cli_pattern_parse(&j.pattern, options->output);
    if (result == NSDF_CLI_SUCCESS && nsdf_get_info(decoder, &j.info) != NSDF_OK)
        result = NSDF_CLI_FAILURE;
    if (result == NSDF_CLI_SUCCESS)
        result = nsdf_cli_times_choose(&options->choice, decoder, &j.times);
    if (result == NSDF_CLI_SUCCESS)
        result = check_names(&j);
    if (result == NSDF_CLI_SUCCESS && options->compare)
        result = play_compare_open(&j.compare, options, decoder);
    nsdf_cli_catch_signals();
    if (result == NSDF_CLI_SUCCESS)
        result = draw(&j, &context);
    play_renderer_free(j.renderer);
    play_offscreen_context_free(context);
    play_compare_close(j.compare);
    nsdf_mesh_free(&j.mesh);
    nsdf_mesh_free(&j.ghost);
    nsdf_cli_times_free(&j.times);
    free(j.rgba);
    return result;
}

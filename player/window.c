#include "window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli_util.h"
#include "hud.h"
#include "picture.h"
#include "punctuality.h"
#include "session.h"
#include "view_setup.h"

static const double message_seconds = 6.0, turn_seconds = 12.0;

typedef struct app {
    const play_options *options;
    GLFWwindow *window;
    play_renderer *renderer;
    play_session session; /* without an input until a file is open */
    play_scene scene;
    play_overlay overlay;
    play_punctuality punctuality;
    int help, texts, turning, quit;
    int dirty;                   /* something but the surface has changed */
    int width, height;           /* pixels */
    uint64_t shown, ghost_shown; /* numbers of the frames that the renderer has */
    double shown_time, draw_seconds;
    double rate_since; /* for the rate of surfaces */
    uint64_t rate_count;
    double shown_rate;
    double cursor_x, cursor_y; /* pixels */
    int dragging;              /* mouse button + 1; 0 = none */
    int scrubbing;
    double turned_at;
    char message[400];
    double message_until;
    uint32_t saved; /* pictures */
} app;

static void say(app *a, const char *text) {
    snprintf(a->message, sizeof a->message, "%s", text);
    a->message_until = nsdf_cli_clock() + message_seconds;
    a->dirty = 1;
}

/* ---- Files ----------------------------------------------------------------------------------------------- */

static void set_title(app *a) {
    char title[300];
    snprintf(title, sizeof title, "%.250s - nsdf-play",
             a->session.input ? play_file_name(nsdf_cli_input_name(a->session.input)) : "");
    glfwSetWindowTitle(a->window, a->session.input ? title : "nsdf-play");
}

static void forget_frames(app *a) {
    const nsdf_mesh_view none = {NULL, NULL, NULL, 0, 0};
    a->shown = a->ghost_shown = 0;
    play_renderer_set_mesh(a->renderer, PLAY_MESH_MAIN, &none);
    play_renderer_set_mesh(a->renderer, PLAY_MESH_GHOST, &none);
}

static void start_file(app *a) {
    play_options view = *a->options;
    view.width = a->width;
    view.height = a->height;
    view.mode = a->scene.mode;
    view.ground = a->scene.ground;
    view.ghost = a->scene.ghost;
    a->scene = play_scene_make(&view, &a->session.info);
    if (a->scene.ghost && play_session_show_ghost(&a->session, 1) != 0)
        a->scene.ghost = 0;
    play_punctuality_jump(&a->punctuality, nsdf_cli_clock());
    forget_frames(a);
    set_title(a);
    a->dirty = 1;
}

/* The file that is open stays if another cannot be opened. */
static void drop_file(GLFWwindow *window, int count, const char **paths) {
    app *a = glfwGetWindowUserPointer(window);
    play_session opened;
    nsdf_error error;
    char text[400];
    if (count < 1)
        return;
    if (play_session_open(&opened, paths[0], a->options, &error) != 0) {
        const char *why = error.message[0] ? error.message : nsdf_status_string(error.status);
        snprintf(text, sizeof text, "%.120s cannot be played:\n%s", play_file_name(paths[0]), why);
        say(a, text);
        nsdf_cli_error("%s cannot be played: %s", paths[0], why);
        return;
    }
    play_session_close(&a->session);
    a->session = opened;
    start_file(a);
}

/* ---- Keys ------------------------------------------------------------------------------------------------ */

static void replan(app *a) {
    play_punctuality_jump(&a->punctuality, nsdf_cli_clock());
    play_session_replan(&a->session);
    a->dirty = 1;
}

static void seek(app *a, double seconds) {
    play_clock_seek(&a->session.plan.clock, nsdf_cli_clock(), seconds);
    replan(a);
}

static void toggle_playing(app *a) {
    play_clock *c = &a->session.plan.clock;
    const double now = nsdf_cli_clock();
    if (play_clock_moves(c, now))
        play_clock_pause(c, now);
    else
        play_clock_play(c, now);
    replan(a);
}

static void set_speed(app *a, double speed) {
    play_clock_set_speed(&a->session.plan.clock, nsdf_cli_clock(), speed);
    replan(a);
}

static void set_resolution(app *a, int direction) {
    play_plan *plan = &a->session.plan;
    const uint32_t now = play_queue_get_state(a->session.queue).resolution;
    plan->resolution = direction == 0 ? 0 : play_pace_step(now, direction, 1024);
    replan(a);
}

static void save_picture(app *a) {
    char name[64], text[128];
    nsdf_cli_file file;
    unsigned char *rgba = malloc(4 * (size_t)a->width * (size_t)a->height);
    FILE *taken;
    do {
        snprintf(name, sizeof name, "nsdf-play_%03u.png", (unsigned)++a->saved);
        taken = fopen(name, "rb");
        if (taken)
            fclose(taken);
    } while (taken && a->saved < 999);
    int failed = !rgba || nsdf_cli_file_open(&file, name) != 0;
    if (!failed) {
        play_renderer_draw(a->renderer, &a->scene, NULL, a->width, a->height);
        play_renderer_read(a->renderer, a->width, a->height, rgba, a->width);
        failed = play_write_png(rgba, a->width, a->height, 0, nsdf_cli_file_write, &file) != 0;
        failed |= nsdf_cli_file_publish(&file) != 0;
    }
    free(rgba);
    snprintf(text, sizeof text, failed ? "%s cannot be written" : "%s saved", name);
    say(a, text);
}

static void toggle_ghost(app *a) {
    if (play_session_show_ghost(&a->session, !a->scene.ghost) != 0)
        say(a, "the file cannot be opened again for the ghost");
    else
        a->scene.ghost = !a->scene.ghost;
    a->ghost_shown = 0;
}

/* What needs no file. */
static int general_key(app *a, int key) {
    switch (key) {
    case GLFW_KEY_ESCAPE:
    case GLFW_KEY_Q:
        a->quit = 1;
        return 1;
    case GLFW_KEY_H:
    case GLFW_KEY_F1:
        a->help = !a->help;
        return 1;
    case GLFW_KEY_O:
        a->texts = !a->texts;
        return 1;
    case GLFW_KEY_M:
        a->scene.mode = (play_mode)((a->scene.mode + 1) % PLAY_MODES);
        return 1;
    case GLFW_KEY_B:
        a->scene.ground = !a->scene.ground;
        return 1;
    case GLFW_KEY_T:
        a->turning = !a->turning;
        a->turned_at = nsdf_cli_clock();
        return 1;
    case GLFW_KEY_F:
        play_camera_fit(&a->scene.camera, &a->scene.box, (double)a->width / a->height);
        return 1;
    case GLFW_KEY_S:
        save_picture(a);
        return 1;
    default:
        return 0;
    }
}

static void seek_key(app *a, int key) {
    const play_clock *c = &a->session.plan.clock;
    const double at = play_clock_time(c, nsdf_cli_clock());
    switch (key) {
    case GLFW_KEY_LEFT:
        play_punctuality_jump(&a->punctuality, nsdf_cli_clock());
        play_session_step(&a->session, -1);
        break;
    case GLFW_KEY_RIGHT:
        play_punctuality_jump(&a->punctuality, nsdf_cli_clock());
        play_session_step(&a->session, 1);
        break;
    case GLFW_KEY_UP:
        seek(a, at + 1.0);
        break;
    case GLFW_KEY_DOWN:
        seek(a, at - 1.0);
        break;
    case GLFW_KEY_HOME:
        seek(a, 0.0);
        break;
    case GLFW_KEY_END:
        seek(a, c->duration);
        break;
    default:
        if (key >= GLFW_KEY_0 && key <= GLFW_KEY_9)
            seek(a, 0.1 * (key - GLFW_KEY_0) * c->duration);
        break;
    }
}

static void play_key(app *a, int key) {
    const play_clock *c = &a->session.plan.clock;
    switch (key) {
    case GLFW_KEY_SPACE:
        toggle_playing(a);
        break;
    case GLFW_KEY_LEFT_BRACKET:
        set_speed(a, 0.5 * c->speed);
        break;
    case GLFW_KEY_RIGHT_BRACKET:
        set_speed(a, 2.0 * c->speed);
        break;
    case GLFW_KEY_BACKSPACE:
        set_speed(a, 1.0);
        break;
    case GLFW_KEY_R:
        set_speed(a, -c->speed);
        break;
    case GLFW_KEY_L:
        play_clock_set_loop(&a->session.plan.clock, nsdf_cli_clock(), !c->loop);
        say(a, c->loop ? "begins again at the end" : "stops at the end");
        replan(a);
        break;
    case GLFW_KEY_G:
        toggle_ghost(a);
        break;
    case GLFW_KEY_MINUS:
    case GLFW_KEY_KP_SUBTRACT:
        set_resolution(a, -1);
        break;
    case GLFW_KEY_EQUAL:
    case GLFW_KEY_KP_ADD:
        set_resolution(a, 1);
        break;
    case GLFW_KEY_A:
        set_resolution(a, 0);
        break;
    default:
        seek_key(a, key);
        break;
    }
}

static void on_key(GLFWwindow *window, int key, int code, int action, int mods) {
    app *a = glfwGetWindowUserPointer(window);
    (void)code;
    (void)mods;
    if (action == GLFW_RELEASE)
        return;
    a->message_until = 0.0;
    a->dirty = 1;
    if (!general_key(a, key) && a->session.input)
        play_key(a, key);
}

/* ---- Mouse ----------------------------------------------------------------------------------------------- */

static void scrub(app *a) {
    const double part = play_hud_time_at(a->width, a->height, a->cursor_x, (double)a->height);
    if (part >= 0.0)
        seek(a, part * a->session.info.duration);
}

static void on_button(GLFWwindow *window, int button, int action, int mods) {
    app *a = glfwGetWindowUserPointer(window);
    (void)mods;
    a->dragging = action == GLFW_PRESS ? button + 1 : 0;
    a->scrubbing = 0;
    if (action == GLFW_PRESS && button == GLFW_MOUSE_BUTTON_LEFT && a->texts && a->session.input &&
        play_hud_time_at(a->width, a->height, a->cursor_x, a->cursor_y) >= 0.0) {
        a->scrubbing = 1;
        scrub(a);
    }
}

static void on_cursor(GLFWwindow *window, double x, double y) {
    app *a = glfwGetWindowUserPointer(window);
    int width, height;
    glfwGetWindowSize(window, &width, &height);
    x *= width > 0 ? (double)a->width / width : 1.0; /* screen coordinates to pixels */
    y *= height > 0 ? (double)a->height / height : 1.0;
    const double dx = x - a->cursor_x, dy = y - a->cursor_y, side = a->width < a->height ? a->width : a->height;
    a->cursor_x = x;
    a->cursor_y = y;
    if (!a->dragging || !(side > 0.0))
        return;
    if (a->scrubbing)
        scrub(a);
    else if (a->dragging == GLFW_MOUSE_BUTTON_LEFT + 1)
        play_camera_orbit(&a->scene.camera, -240.0 * dx / side, 240.0 * dy / side);
    else
        play_camera_pan(&a->scene.camera, dx / side, -dy / side);
    a->dirty = 1;
}

static void on_scroll(GLFWwindow *window, double x, double y) {
    app *a = glfwGetWindowUserPointer(window);
    (void)x;
    play_camera_zoom(&a->scene.camera, pow(1.12, y));
    a->dirty = 1;
}

static void on_size(GLFWwindow *window, int width, int height) {
    app *a = glfwGetWindowUserPointer(window);
    a->width = width;
    a->height = height;
    a->dirty = 1;
}

static void on_refresh(GLFWwindow *window) {
    app *a = glfwGetWindowUserPointer(window);
    a->dirty = 1;
}

/* ---- Drawing --------------------------------------------------------------------------------------------- */

static void draw_texts(app *a, const play_frame *frame, double now) {
    const nsdf_info *info = &a->session.info;
    const play_clock *c = &a->session.plan.clock;
    play_hud hud = {.help = a->help, .message = now < a->message_until ? a->message : NULL};
    play_overlay_clear(&a->overlay);
    if (!a->session.input && !hud.message && !hud.help)
        hud.message = "Drop an .nsdf file here";
    if (a->session.input && a->texts) {
        hud.file = play_file_name(nsdf_cli_input_name(a->session.input));
        hud.time = frame ? frame->time : play_clock_time(c, now);
        hud.duration = info->duration;
        hud.frame_count = info->frame_count;
        hud.frame_rate = (double)info->rate_num / info->rate_den;
        hud.speed = c->speed;
        hud.playing = play_clock_moves(c, now);
        hud.shown_rate = hud.playing ? a->shown_rate : 0.0;
        hud.file_size = info->file_size;
        if (frame) {
            hud.resolution = frame->resolution;
            hud.vertices = frame->view.vertex_count;
            hud.decode_seconds = frame->seconds;
        }
    }
    play_hud_draw(&a->overlay, &hud, a->width, a->height);
}

/* Takes what is due when drawing will be done.  Whether there is another surface than before. */
static int take_frames(app *a, double now, const play_frame **frame) {
    int another = 0;
    const double due = now + a->draw_seconds;
    *frame = a->session.input ? play_queue_take(a->session.queue, due) : NULL;
    if (*frame && (*frame)->number != a->shown) {
        play_renderer_set_mesh(a->renderer, PLAY_MESH_MAIN, &(*frame)->view);
        a->shown = (*frame)->number;
        another = 1;
    }
    const play_frame *ghost = *frame && a->scene.ghost ? play_session_ghost(&a->session, (*frame)->time, due) : NULL;
    if (ghost && ghost->number != a->ghost_shown) {
        play_renderer_set_mesh(a->renderer, PLAY_MESH_GHOST, &ghost->view);
        a->ghost_shown = ghost->number;
        a->dirty = 1;
    }
    return another;
}

static void count_rate(app *a, double now) {
    a->rate_count++;
    if (now - a->rate_since < 1.0)
        return;
    a->shown_rate = now - a->rate_since < 3.0 ? (double)a->rate_count / (now - a->rate_since) : 0.0;
    a->rate_since = now;
    a->rate_count = 0;
}

static void draw(app *a, const play_frame *frame, int another) {
    const double began = nsdf_cli_clock();
    draw_texts(a, frame, began);
    if (play_renderer_draw(a->renderer, &a->scene, &a->overlay, a->width, a->height) != 0)
        return;
    glfwSwapBuffers(a->window);
    const double now = nsdf_cli_clock();
    a->draw_seconds = 0.8 * a->draw_seconds + 0.2 * fmin(now - began, 0.1);
    a->dirty = 0;
    if (another) {
        count_rate(a, now);
        play_queue_set_drawing(a->session.queue, a->draw_seconds);
        play_punctuality_shown(&a->punctuality, &a->session.plan.clock, frame->time, now);
    }
}

static void turn(app *a, double now) {
    if (!a->turning || now - a->turned_at < 1.0 / 60)
        return;
    play_camera_orbit(&a->scene.camera, -360.0 * (now - a->turned_at) / turn_seconds, 0.0);
    a->turned_at = now;
    a->dirty = 1;
}

static void check_status(app *a) {
    const nsdf_status status = a->session.input ? play_queue_get_state(a->session.queue).status : NSDF_OK;
    if (status != NSDF_OK && nsdf_cli_clock() >= a->message_until)
        say(a, nsdf_status_string(status));
}

static void run(app *a) {
    const double began = nsdf_cli_clock();
    double message_until = 0.0;
    while (!a->quit && !glfwWindowShouldClose(a->window) && nsdf_cli_interrupts() == 0) {
        const play_frame *frame;
        double now = nsdf_cli_clock();
        if (a->options->exit_after > 0.0 && now - began > a->options->exit_after)
            break;
        if (message_until > 0.0 && now >= message_until)
            a->dirty = 1; /* the message goes away */
        message_until = a->message_until > now ? a->message_until : 0.0;
        turn(a, now);
        check_status(a);
        const int another = take_frames(a, now, &frame);
        if ((another || a->dirty) && a->width > 0 && a->height > 0)
            draw(a, frame, another);
        glfwWaitEventsTimeout(0.003);
    }
}

/* ---- Setting up ------------------------------------------------------------------------------------------ */

static play_gl_function lookup(const char *name) {
    return glfwGetProcAddress(name);
}

static void set_callbacks(app *a) {
    glfwSetWindowUserPointer(a->window, a);
    glfwSetKeyCallback(a->window, on_key);
    glfwSetMouseButtonCallback(a->window, on_button);
    glfwSetCursorPosCallback(a->window, on_cursor);
    glfwSetScrollCallback(a->window, on_scroll);
    glfwSetFramebufferSizeCallback(a->window, on_size);
    glfwSetWindowRefreshCallback(a->window, on_refresh);
    glfwSetDropCallback(a->window, drop_file);
}

/* Software renders as many samples of a pixel as it has time for, which is one. */
static int samples_for(const app *a) {
    const char *name = a->renderer ? play_renderer_name(a->renderer) : "";
    const int software = strstr(name, "llvmpipe") || strstr(name, "softpipe") || strstr(name, "SWR");
    return a->options->samples ? a->options->samples : software ? 1 : 4;
}

static int create_renderer(app *a) {
    char why[512];
    a->renderer = play_renderer_create(lookup, 1, why, sizeof why);
    if (!a->renderer) {
        nsdf_cli_error("%s", why);
        return -1;
    }
    if (play_renderer_set_samples(a->renderer, samples_for(a)) != 0) {
        nsdf_cli_error("the OpenGL driver cannot draw into textures");
        return -1;
    }
    nsdf_cli_verbose("%s", play_renderer_name(a->renderer));
    return 0;
}

static int create_window(app *a) {
    const char *why = NULL;
    if (!glfwInit()) {
        nsdf_cli_error("there is no display for a window; --offscreen out_%%04d.png draws pictures without one");
        return -1;
    }
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    a->window = glfwCreateWindow(a->options->width, a->options->height, "nsdf-play", NULL, NULL);
    if (!a->window) {
        glfwGetError(&why);
        nsdf_cli_error("no window with OpenGL 3.3: %s; --offscreen out_%%04d.png draws pictures without one",
                       why ? why : "the display refuses");
        return -1;
    }
    glfwMakeContextCurrent(a->window);
    glfwSwapInterval(1);
    glfwGetFramebufferSize(a->window, &a->width, &a->height);
    set_callbacks(a);
    return create_renderer(a);
}

static int open_input(app *a) {
    nsdf_error error;
    if (!a->options->input)
        return 0;
    if (play_session_open(&a->session, a->options->input, a->options, &error) == 0)
        return 0;
    nsdf_cli_nsdf_error(a->options->input, &error);
    return -1;
}

int play_window_run(const play_options *options) {
    app a = {.options = options, .texts = options->overlay, .punctuality = play_punctuality_make()};
    a.scene.mode = options->mode;
    a.scene.ground = options->ground;
    a.scene.ghost = options->ghost;
    int result = NSDF_CLI_FAILURE;
    if (open_input(&a) == 0 && create_window(&a) == 0) {
        result = NSDF_CLI_SUCCESS;
        nsdf_cli_catch_signals();
        if (a.session.input)
            start_file(&a);
        a.dirty = 1;
        run(&a);
        if (options->statistics && a.session.input) {
            const play_queue_state state = play_queue_get_state(a.session.queue);
            play_punctuality_print(&a.punctuality, state.skipped, state.resolution, a.draw_seconds);
            nsdf_cli_input_report(a.session.input, -1);
        }
    }
    play_session_close(&a.session);
    play_renderer_free(a.renderer);
    play_overlay_free(&a.overlay);
    if (a.window)
        glfwDestroyWindow(a.window);
    glfwTerminate();
    return result;
}

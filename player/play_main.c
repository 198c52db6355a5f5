/* nsdf-play: shows moving surfaces in a window, and draws them without one. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "cli_input.h"
#include "cli_util.h"
#include "offscreen.h"
#include "play_options.h"
#include "window.h"

static int draw_pictures(const play_options *options) {
    nsdf_decoder_options decoder_options;
    nsdf_decoder *decoder = NULL;
    nsdf_error error;
    int result = NSDF_CLI_FAILURE;
    nsdf_decoder_options_init(&decoder_options);
    decoder_options.threads = options->threads;
    nsdf_cli_input *input = nsdf_cli_input_open(options->input, options->timeout, &error);
    if (input && nsdf_cli_input_decoder(input, &decoder, &decoder_options, &error) == NSDF_OK)
        result = play_offscreen_run(options, input, decoder);
    else
        nsdf_cli_nsdf_error(options->input, &error);
    if (input)
        nsdf_cli_input_report(input, options->statistics ? -1 : 1);
    nsdf_close(&decoder);
    nsdf_cli_input_close(input);
    return result;
}

int main(int argc, char **argv) {
    play_options options;
    nsdf_cli_begin("nsdf-play");
    int result = play_options_parse(argc, argv, &options);
    if (result == NSDF_CLI_SUCCESS && options.action == PLAY_OFFSCREEN)
        result = draw_pictures(&options);
    if (result == NSDF_CLI_SUCCESS && options.action == PLAY_WINDOW)
        result = play_window_run(&options);
    nsdf_cli_abort();
    if (fflush(stdout) != 0 && result == NSDF_CLI_SUCCESS) {
        nsdf_cli_error("cannot write standard output: %s", strerror(errno));
        result = NSDF_CLI_FAILURE;
    }
    return result;
}

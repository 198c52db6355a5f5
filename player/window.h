/* The player's window. */
#ifndef PLAY_WINDOW_H
#define PLAY_WINDOW_H

#include "play_options.h"

/* Opens a window and plays until it is closed.  An exit code, after printing why: without a display, that there is
 * none. */
int play_window_run(const play_options *options);

#endif

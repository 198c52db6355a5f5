/* Lists on the command line: parts between commas, and numbers of frames. */
#ifndef NSDF_CLI_LIST_H
#define NSDF_CLI_LIST_H

#include <stdint.h>

/* Takes one part of a list; returns NSDF_CLI_SUCCESS to go on, or an exit code after printing why not. */
typedef int (*nsdf_cli_item_fn)(void *user, const char *text);

/* Calls `item` for every part of `list` between commas, empty ones included, until one fails.  NSDF_CLI_SUCCESS, or the
 * exit code of the part that failed. */
int nsdf_cli_each_item(const char *list, nsdf_cli_item_fn item, void *user);

typedef struct nsdf_cli_list {
    uint32_t *numbers; /* owned */
    uint32_t count, capacity;
} nsdf_cli_list;

/* Reads frame numbers: parts such as 7, 0-9 (both ends belong to it) or 1-173/2 (every second from 1 on), in the order
 * given, repetitions kept.  There are `frame_count` frames, from 0 on.  `option` ("--frames") is for messages.
 * NSDF_CLI_SUCCESS with at least one number, or another exit code after printing why; nsdf_cli_list_free in either
 * case. */
int nsdf_cli_list_parse(nsdf_cli_list *list, const char *option, const char *text, uint32_t frame_count);
/* 0 to frame_count - 1, at least one number.  As above. */
int nsdf_cli_list_all(nsdf_cli_list *list, uint32_t frame_count);
/* Into ascending order, without repetitions. */
void nsdf_cli_list_sort(nsdf_cli_list *list);
void nsdf_cli_list_free(nsdf_cli_list *list);

#endif

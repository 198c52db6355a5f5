/* The command line of nsdf-mux. */
#ifndef NSDF_MUX_OPTIONS_H
#define NSDF_MUX_OPTIONS_H

#include <stdint.h>

typedef enum mux_action { MUX_NOTHING = 0, MUX_WRITE, MUX_INFO, MUX_VALIDATE } mux_action;

/* "A-B", "A-" (to the end) or "A". */
typedef struct mux_range {
    int given;
    uint32_t first, last; /* UINT32_MAX: the end */
} mux_range;

/* A pair of metadata to set, or a key to remove. */
typedef struct mux_pair {
    char *key;         /* owned */
    const char *value; /* NULL: removed */
} mux_pair;

typedef struct mux_options {
    mux_action action;
    char **inputs; /* borrowed from argv, like the other strings */
    int input_count;
    const char *output;
    mux_range frames, segments, replaced;
    const char *with; /* the file with the segments in place of `replaced` */
    int has_times;
    double from, to; /* seconds; to = HUGE_VAL: the end */
    int has_fade;
    uint32_t fade;
    uint32_t hold; /* frames */
    int shared;    /* files that are joined share a frame */
    uint32_t rate_num, rate_den;
    mux_pair *pairs; /* owned, in the order given */
    int pair_count;
} mux_options;

/* NSDF_CLI_SUCCESS, or NSDF_CLI_USAGE after printing why; mux_options_free in either case. */
int mux_options_parse(int argc, char **argv, mux_options *options);
void mux_options_free(mux_options *options);

#endif

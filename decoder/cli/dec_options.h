/* The command line of nsdf-dec. */
#ifndef NSDF_DEC_OPTIONS_H
#define NSDF_DEC_OPTIONS_H

#include "cli_times.h"
#include "nsdf/export.h"

typedef enum dec_action {
    DEC_NOTHING = 0, /* help or version was printed */
    DEC_EXTRACT,
    DEC_INFO,
    DEC_VERIFY,
    DEC_BENCH
} dec_action;

/* Formats of meshes: those of the library, and one of the command's own. */
typedef enum dec_format { DEC_OBJ, DEC_PLY, DEC_STL, DEC_GLB } dec_format;

typedef struct dec_options {
    dec_action action;
    const char *input, *output; /* borrowed from argv, like the other strings */
    nsdf_cli_choice choice;
    uint32_t resolution; /* 0 = the file's */
    uint32_t projection, threads, cpu_mask, start_number;
    uint32_t timeout;    /* seconds, of the network */
    uint64_t max_memory; /* 0 = the library's default */
    int normals, dense, all_pieces, json;
    int has_format;
    dec_format format;
} dec_options;

/* NSDF_CLI_SUCCESS, or NSDF_CLI_USAGE after printing why. */
int dec_options_parse(int argc, char **argv, dec_options *options);

#endif

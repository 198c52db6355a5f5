/* Where decoded meshes go. */
#ifndef NSDF_DEC_OUTPUT_H
#define NSDF_DEC_OUTPUT_H

#include "cli_pattern.h"
#include "dec_options.h"
#include "gltf_writer.h"

/* DEC_OUTPUT_FILM: all frames in one file, or on standard output. */
typedef enum dec_output_kind {
    DEC_OUTPUT_FILES,
    DEC_OUTPUT_STDOUT,
    DEC_OUTPUT_FILM,
    DEC_OUTPUT_HASH,
    DEC_OUTPUT_NULL
} dec_output_kind;

typedef struct dec_output {
    dec_output_kind kind;
    dec_format format;
    nsdf_cli_pattern pattern; /* of files */
    uint32_t start_number;
    nsdf_gltf *film;
} dec_output;

/* NSDF_CLI_SUCCESS, or NSDF_CLI_USAGE after printing why. */
int dec_output_prepare(const dec_options *options, dec_output *output);
/* The same, once it is known how many frames there will be. */
int dec_output_check_count(const dec_output *output, uint32_t count);
/* Writes frame `index` of the output.  NSDF_CLI_SUCCESS, or NSDF_CLI_FAILURE after printing why.  Files stay under
 * their temporary names until nsdf_cli_commit. */
int dec_output_write(dec_output *output, uint32_t index, double seconds, const nsdf_mesh_view *view);
/* After the last frame, of which there is one every `interval` seconds.  As above. */
int dec_output_finish(dec_output *output, double interval);
/* Frees what the output holds. */
void dec_output_free(dec_output *output);
/* The name of a frame's file, in a buffer that the caller frees; NULL when memory ran out. */
char *dec_output_name(const dec_output *output, uint32_t index);

#endif

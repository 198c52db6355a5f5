/* Command line of nsdf-enc. */
#ifndef NSDF_ENC_OPTIONS_H
#define NSDF_ENC_OPTIONS_H

#include "nsdf/encoder.h"

enum { ENC_MOST_ALSO = 64 };

/* Another coding of the fit. */
typedef struct enc_also {
    double weight_bits;
    nsdf_entropy_coder entropy;
    const char *output; /* borrowed from the arguments */
} enc_also;

typedef enum enc_check_form { ENC_NO_CHECK, ENC_CHECK_TEXT, ENC_CHECK_JSON } enc_check_form;

typedef struct enc_options {
    nsdf_encoder_options encoder;
    const char *const *inputs;
    size_t input_count;
    const char *output, *report, *preset;
    const char *checkpoint;  /* NULL when not given */
    double checkpoint_every; /* seconds; below 0 when not given */
    const char *frames;      /* list of frames to fit; NULL = all */
    uint32_t frame_step;     /* every so many frames and the last; 0 when not given */
    int rate_given;          /* by --fps */
    int ignore_numbers;      /* of files, and times of a list */
    double segment;          /* seconds; 0 = all in one, below 0 when not given */
    uint32_t jobs;           /* segments at a time */
    enc_also also[ENC_MOST_ALSO];
    uint32_t also_count;
    int target;           /* --size, --bitrate or --max-error: the option's code; 0 without any */
    enc_check_form check; /* only look at the input */
    int quiet, verbose;
} enc_options;

/* Fills *options from the arguments.  Returns -1 when the program should go on, otherwise its exit code (--help and
 * --version have printed, or the error is printed).  Arguments may be reordered; strings are borrowed from them. */
int enc_options_parse(enc_options *options, int argc, char **argv);

#endif

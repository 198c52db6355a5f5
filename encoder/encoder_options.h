/* Presets and limits of the encoder's options. */
#ifndef NSDF_ENCODER_OPTIONS_H
#define NSDF_ENCODER_OPTIONS_H

#include "nsdf/encoder.h"

/* NSDF_OK, or NSDF_INVALID_ARGUMENT with a message that names the option, its value and what was expected. */
nsdf_status nsdf_encoder_options_check(const nsdf_encoder_options *options, nsdf_encoder_error *error);

#endif

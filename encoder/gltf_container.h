/* The outer form of a glTF file: text, or the binary form (glTF 2.0, 4.4: a header, then chunks). */
#ifndef NSDF_GLTF_CONTAINER_H
#define NSDF_GLTF_CONTAINER_H

#include <stdbool.h>
#include <stddef.h>

#include "nsdf/encoder.h"

/* Looks at what can be told without reading the JSON; a file is binary when it begins so, or is called .glb.  *binary
 * gets which it is.  NSDF_CORRUPT when it is neither; the message has the byte and what was expected there. */
nsdf_status nsdf_gltf_check_container(const char *name, const char *text, size_t size, bool *binary,
                                      nsdf_encoder_error *error);

/* What a JSON parser says about a place ("parse error at line 1, column 9: ...") becomes a message with the byte in the
 * file; any other is shown as it is.  Returns NSDF_CORRUPT. */
nsdf_status nsdf_gltf_refuse(const char *name, const char *text, size_t size, bool binary, const char *why,
                             nsdf_encoder_error *error);

#endif

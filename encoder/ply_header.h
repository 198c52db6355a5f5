/* The text at the start of a PLY file: which elements follow, and what each consists of. */
#ifndef NSDF_PLY_HEADER_H
#define NSDF_PLY_HEADER_H

#include <stdbool.h>

#include "nsdf/encoder.h"

#define NSDF_PLY_MAX_ELEMENTS 32
#define NSDF_PLY_MAX_PROPERTIES 256 /* of all elements together */

typedef enum nsdf_ply_format { NSDF_PLY_ASCII, NSDF_PLY_LITTLE_ENDIAN, NSDF_PLY_BIG_ENDIAN } nsdf_ply_format;

typedef enum nsdf_ply_type {
    NSDF_PLY_INT8,
    NSDF_PLY_UINT8,
    NSDF_PLY_INT16,
    NSDF_PLY_UINT16,
    NSDF_PLY_INT32,
    NSDF_PLY_UINT32,
    NSDF_PLY_FLOAT32,
    NSDF_PLY_FLOAT64
} nsdf_ply_type;

/* What a property is to us. */
typedef enum nsdf_ply_role { NSDF_PLY_X, NSDF_PLY_Y, NSDF_PLY_Z, NSDF_PLY_CORNERS, NSDF_PLY_SKIPPED } nsdf_ply_role;

typedef struct nsdf_ply_property {
    nsdf_ply_role role;
    nsdf_ply_type type, count_type; /* of a value; of a list's length */
    bool is_list;
} nsdf_ply_property;

typedef enum nsdf_ply_kind { NSDF_PLY_VERTEX, NSDF_PLY_FACE, NSDF_PLY_OTHER } nsdf_ply_kind;

typedef struct nsdf_ply_element {
    nsdf_ply_kind kind;
    uint64_t count;
    uint32_t first, property_count; /* in nsdf_ply_header.properties */
} nsdf_ply_element;

typedef struct nsdf_ply_header {
    nsdf_ply_format format;
    uint64_t vertex_count, line_count; /* lines of the header */
    size_t size;                       /* bytes of the header */
    uint32_t element_count, property_count;
    nsdf_ply_element elements[NSDF_PLY_MAX_ELEMENTS];
    nsdf_ply_property properties[NSDF_PLY_MAX_PROPERTIES];
} nsdf_ply_header;

/* Whether a file (ended by a zero byte) begins with the line that marks a PLY file. */
bool nsdf_ply_begins(const char *text);

/* Reads the header of a file of `size` bytes, text[size] a zero byte, and checks that there are vertices with x, y and
 * z and faces with vertex_indices or vertex_index.  NSDF_OK, or NSDF_CORRUPT with a message that names the file and the
 * line. */
nsdf_status nsdf_ply_read_header(const char *name, const char *text, size_t size, nsdf_ply_header *header,
                                 nsdf_encoder_error *error);

#endif

/* Reading a segment: its parts, and the network part's description and parameters. */
#ifndef NSDF_NETWORK_READ_H
#define NSDF_NETWORK_READ_H

#include "container_read.h"

typedef struct nsdf_part_ref {
    uint32_t kind;       /* NSDF_PART_... */
    uint32_t flags;      /* reserved, ignored */
    const uint8_t *data; /* into the payload */
    size_t size;
} nsdf_part_ref;

/* Splits SEGM's payload into its parts; unknown kinds are NSDF_PARSE_FEATURE (a value is missing from the sum, so no
 * part may be skipped). */
nsdf_parse nsdf_read_parts(const uint8_t *payload, size_t size, nsdf_part_ref parts[NSDF_MAX_PARTS],
                           uint32_t *part_count, nsdf_fault *fault);

/* Reads and validates the description in front of a network part; *coded_offset is where the coded parameters begin.
 * Everything that an evaluator relies on is checked here: shapes fit each other, last width 1, counts in range and
 * their sum at most NSDF_MAX_PARAMETERS, floats finite.  Allocates nothing. */
nsdf_parse nsdf_read_network_desc(const uint8_t *part, size_t size, nsdf_network_desc *desc, size_t *coded_offset,
                                  nsdf_fault *fault);

/* Bytes of scratch memory (aligned as for int32_t) that nsdf_read_parameters needs. */
size_t nsdf_parameter_scratch_size(const nsdf_tensor_list *list);

/* Memory hooks for back ends that allocate (deflate, zstd); NULL functions stand for malloc and free. */
typedef struct nsdf_codec_memory {
    void *user;
    void *(*allocate)(void *user, size_t size);
    void (*release)(void *user, void *pointer);
} nsdf_codec_memory;

/* Decodes and dequantises all parameters into values[nsdf_parameter_count(list)] (arrays in the order of the file).
 * Bit-exact on every machine.  All of the coded bytes must be used, no fewer, no more. */
nsdf_parse nsdf_read_parameters(const uint8_t *part, size_t size, size_t coded_offset, const nsdf_tensor_list *list,
                                void *scratch, const nsdf_codec_memory *memory, float *values, nsdf_fault *fault);

/* Whether this build reads the back end. */
int nsdf_entropy_available(nsdf_entropy_kind kind);
/* "none", "deflate", "zstd", "range"; NULL for other values. */
const char *nsdf_entropy_name(nsdf_entropy_kind kind);

#endif

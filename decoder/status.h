/* Statuses and the details that go with a failure. */
#ifndef NSDF_STATUS_H
#define NSDF_STATUS_H

#include "container_read.h"
#include "nsdf/decoder.h"

/* Fills *error (which may be NULL) and returns `status`.  chunk: a chunk type, or 0 for none.  The format takes
 * strings and integers only, so that the locale has no say. */
#if defined(__GNUC__)
__attribute__((format(printf, 5, 6)))
#endif
nsdf_status
nsdf_fail(nsdf_error *error, nsdf_status status, uint32_t chunk, uint64_t offset, const char *format, ...);

/* The same for a failure reported by format/: `base` is the offset in the file of the bytes that were read. */
nsdf_status nsdf_fail_parse(nsdf_error *error, nsdf_parse parse, uint32_t chunk, uint64_t base,
                            const nsdf_fault *fault);

/* The same for a failed allocation of `size` bytes: NSDF_NO_MEMORY or NSDF_LIMIT. */
nsdf_status nsdf_fail_memory(nsdf_error *error, nsdf_status status, uint32_t chunk, uint64_t offset, uint64_t size);

/* A chunk type as text; letters outside ASCII's printable range become '?'. */
void nsdf_chunk_name(uint32_t type, char name[8]);

#endif

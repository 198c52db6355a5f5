/* Where the bytes of a file come from: memory, a file or the caller's callbacks. */
#ifndef NSDF_SOURCE_H
#define NSDF_SOURCE_H

#include "nsdf/decoder.h"

typedef struct nsdf_source {
    nsdf_io io;
    const uint8_t *memory; /* the whole file, if it is in memory */
    void (*close)(void *user);
} nsdf_source;

void nsdf_source_memory(nsdf_source *source, const void *data, size_t size);
void nsdf_source_callbacks(nsdf_source *source, const nsdf_io *io);
/* NSDF_IO, with the system's reason in *error, when the file cannot be opened. */
nsdf_status nsdf_source_file(nsdf_source *source, const char *path, nsdf_error *error);
void nsdf_source_close(nsdf_source *source);

/* Copies bytes that lie inside the file; NSDF_IO with *error filled when the source fails. */
nsdf_status nsdf_source_read(const nsdf_source *source, uint64_t offset, void *dst, size_t size, nsdf_error *error);

#endif

/* NSDF decoder: mesh files.  Writers for nsdf_mesh_view; bytes go to a callback, so that they can end up in a file,
 * a pipe or memory.  The same rules as in nsdf/decoder.h hold. */
#ifndef NSDF_EXPORT_H
#define NSDF_EXPORT_H

#include "nsdf/decoder.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Takes `size` bytes; returns 0, or nonzero to stop with NSDF_IO. */
typedef int (*nsdf_write_fn)(void *user, const void *data, size_t size);

typedef enum nsdf_mesh_format {
    NSDF_MESH_OBJ = 0, /* text; "v" with the shortest decimals that read back as the same float, "vn", "f" */
    NSDF_MESH_PLY = 1, /* binary little-endian; float x y z [nx ny nz], uchar + int32 indices */
    NSDF_MESH_STL = 2  /* binary; face normals */
} nsdf_mesh_format;

/* The format that a file name's ending stands for (".obj", ".ply", ".stl"; any case): NSDF_OK, or
 * NSDF_UNSUPPORTED_FEATURE. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_mesh_format_from_name(const char *name, nsdf_mesh_format *format);

/* Writes one mesh.  Does not allocate.  Numbers do not depend on the locale. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_write_mesh(const nsdf_mesh_view *view, nsdf_mesh_format format,
                                                   nsdf_write_fn write, void *user);

/* 64-bit FNV-1a hash of counts, positions, normals and indices: equal meshes give equal hashes on every machine. */
NSDF_API uint64_t nsdf_mesh_hash(const nsdf_mesh_view *view);

#ifdef __cplusplus
}
#endif
#endif

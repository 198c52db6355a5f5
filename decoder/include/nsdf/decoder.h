/* NSDF decoder: rebuilds moving surfaces from `.nsdf` files.
 *
 * A file holds a small neural network for each segment of time.  The network is the signed distance function
 * f(x, t) of a moving surface: negative inside, positive outside.  The decoder evaluates it at any time between
 * 0 and the duration, at the original frames and between them, and extracts the zero set as a triangle mesh.
 *
 *     nsdf_decoder *dec = NULL;
 *     nsdf_mesh *mesh = NULL;
 *     nsdf_mesh_view view;
 *     if (nsdf_open_file(&dec, "samba.nsdf", NULL, NULL) == NSDF_OK &&
 *         nsdf_extract_mesh(dec, 0.5, NULL, &mesh) == NSDF_OK &&
 *         nsdf_mesh_get_view(mesh, &view) == NSDF_OK) { ... }
 *     nsdf_mesh_free(&mesh);
 *     nsdf_close(&dec);
 *
 * Rules that hold for every function here:
 *  - Nothing prints, exits, or reads the environment or the locale.  There are no mutable globals.
 *  - Out parameters are untouched on failure unless stated otherwise.
 *  - One thread at a time per handle; different handles are independent.
 *  - Results do not depend on the number of threads, nor on what was decoded before.
 *  - Any bytes are safe to open: they give a status, never undefined behaviour, and never more memory than
 *    nsdf_decoder_options.max_memory.
 *  - Coordinates are in the units of the input ("world units"), times in seconds, both double where exactness
 *    matters and float where there are many.  Arrays of points are tightly packed x, y, z.
 *
 * The header is C99 and C++17.
 */
#ifndef NSDF_DECODER_H
#define NSDF_DECODER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32) && defined(NSDF_SHARED)
#ifdef NSDF_BUILDING
#define NSDF_API __declspec(dllexport)
#else
#define NSDF_API __declspec(dllimport)
#endif
#elif defined(__GNUC__)
#define NSDF_API __attribute__((visibility("default")))
#else
#define NSDF_API
#endif

#if defined(__GNUC__)
#define NSDF_MUST_USE __attribute__((warn_unused_result))
#else
#define NSDF_MUST_USE
#endif

#define NSDF_VERSION_MAJOR 0
#define NSDF_VERSION_MINOR 1
#define NSDF_VERSION_PATCH 0

/* Version of the linked library: major << 16 | minor << 8 | patch. */
NSDF_API uint32_t nsdf_version(void);
/* The same as text, "0.1.0".  Static storage. */
NSDF_API const char *nsdf_version_string(void);

/* ---- Statuses ------------------------------------------------------------------------------------------- */

/* Values are pinned; new ones are only added. */
typedef enum nsdf_status {
    NSDF_OK = 0,
    NSDF_INVALID_ARGUMENT = 10,    /* a NULL, a NaN, an index or a size out of range: the caller's mistake */
    NSDF_NO_MEMORY = 20,           /* the allocator returned NULL */
    NSDF_LIMIT = 21,               /* would need more than a limit in the options allows */
    NSDF_IO = 30,                  /* the file or the read callback failed */
    NSDF_NOT_NSDF = 40,            /* the signature is not that of an .nsdf file */
    NSDF_UNSUPPORTED_VERSION = 41, /* another version of the format, newer or older */
    NSDF_UNSUPPORTED_FEATURE = 42, /* an unknown critical chunk or part, or a back end left out of this build */
    NSDF_TRUNCATED = 50,           /* the file ends too early */
    NSDF_CORRUPT = 51,             /* a field has a value that the format forbids */
    NSDF_CHECKSUM = 52,            /* a CRC-32 or the parameter hash does not match */
    NSDF_BUFFER_TOO_SMALL = 60,    /* the required sizes were filled in: call again with those */
    NSDF_CANCELLED = 70,           /* the cancel callback asked for it */
    NSDF_INTERNAL = 90             /* a defect in the library */
} nsdf_status;

/* One English sentence without a full stop, static, never NULL, also for unknown values. */
NSDF_API const char *nsdf_status_string(nsdf_status status);

/* Where and why opening failed.  `chunk` is the four-letter type of the chunk at fault, or "". */
typedef struct nsdf_error {
    nsdf_status status;
    char chunk[8];
    uint64_t offset;   /* byte in the file at which the fault was found */
    char message[160]; /* what was found and what was expected; never empty after a failure */
} nsdf_error;

/* ---- Options -------------------------------------------------------------------------------------------- */

/* Memory hook.  `allocate` returns memory aligned for any type, or NULL; `release` takes what it returned, or
 * NULL.  Both are called from the thread that calls the library only. */
typedef struct nsdf_allocator {
    void *user;
    void *(*allocate)(void *user, size_t size);
    void (*release)(void *user, void *pointer);
} nsdf_allocator;

/* Task hook: must call task(data, i) once for every i in [0, count), in any order and on any threads, and
 * return when all are done.  For programs that own a thread pool. */
typedef struct nsdf_task_runner {
    void *user;
    void (*run)(void *user, uint32_t count, void (*task)(void *data, uint32_t index), void *data);
} nsdf_task_runner;

/* Kernels that may be used, for nsdf_decoder_options.cpu_mask.  The C reference always may. */
enum { NSDF_CPU_AVX2 = 1, NSDF_CPU_AVX512 = 2, NSDF_CPU_NEON = 4 };
#define NSDF_CPU_ALL 0xffffffffu

typedef struct nsdf_decoder_options {
    size_t struct_size;       /* set by nsdf_decoder_options_init */
    uint32_t threads;         /* 0 = one per core (default); at most 256 */
    uint32_t cpu_mask;        /* NSDF_CPU_...; default NSDF_CPU_ALL; 0 = plain C */
    uint64_t max_memory;      /* bytes the handle and its meshes may hold at once; default 1 GiB */
    uint32_t max_resolution;  /* largest resolution that extraction accepts; default 1024 */
    uint32_t check_all;       /* nonzero: opening reads every chunk and checks its CRC-32; default 0: the front of
                                 the file at once, each segment when it is first needed */
    nsdf_allocator allocator; /* default: malloc and free */
    nsdf_task_runner runner;  /* default: threads of the library's own, started at the first need */
} nsdf_decoder_options;

/* Sets every field to its default. */
NSDF_API void nsdf_decoder_options_init(nsdf_decoder_options *options);

/* ---- Opening and closing -------------------------------------------------------------------------------- */

typedef struct nsdf_decoder nsdf_decoder;

/* Random access to the bytes of a file.  read_at copies `size` bytes from `offset` to `dst` and returns 0, or
 * returns nonzero when it cannot.  Called only on the thread that calls the library. */
typedef struct nsdf_io {
    void *user;
    int (*read_at)(void *user, uint64_t offset, void *dst, size_t size);
    uint64_t size; /* bytes in the whole file */
} nsdf_io;

/* Open from memory that the caller keeps unchanged until nsdf_close.  `options` and `error` may be NULL.
 * On failure *decoder is untouched and *error says where and why. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_open_memory(nsdf_decoder **decoder, const void *data, size_t size,
                                                    const nsdf_decoder_options *options, nsdf_error *error);
/* Open a file by its path; the handle keeps it open. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_open_file(nsdf_decoder **decoder, const char *path,
                                                  const nsdf_decoder_options *options, nsdf_error *error);
/* Open through callbacks; *io is copied, io->user must stay valid until nsdf_close. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_open_callbacks(nsdf_decoder **decoder, const nsdf_io *io,
                                                       const nsdf_decoder_options *options, nsdf_error *error);
/* Frees everything but meshes, sets *decoder to NULL.  NULL and pointers to NULL are ignored. */
NSDF_API void nsdf_close(nsdf_decoder **decoder);

/* Details of the last failure of a call on this handle (of those that do not take it as const); status NSDF_OK if
 * none failed yet. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_get_error(const nsdf_decoder *decoder, nsdf_error *error);

/* ---- What is in the file -------------------------------------------------------------------------------- */

/* Error measured by the encoder on the decoded file, as fractions of `diagonal`; all 0 when not stored.
 * `to_decoded` is from the input surface to the decoded one, `to_input` the way back. */
typedef struct nsdf_quality {
    double mean_to_decoded, mean_to_input;
    double rms_to_decoded, rms_to_input;
    double max_to_decoded, max_to_input;
    uint32_t resolution; /* at which it was measured */
    uint32_t frames;     /* how many frames were measured */
} nsdf_quality;

typedef struct nsdf_info {
    uint32_t format_major, format_minor;
    uint64_t file_size;          /* bytes */
    uint32_t rate_num, rate_den; /* nominal frames per second, as a fraction */
    uint32_t frame_count;        /* nominal frames; frame i is at i * rate_den / rate_num seconds */
    double duration;             /* seconds from the first frame to the last */
    uint32_t segment_count;
    double box_min[3], box_max[3];       /* of the input, over the whole sequence; world units */
    double diagonal;                     /* length of that box's diagonal; errors are fractions of it */
    double domain_min[3], domain_max[3]; /* where the field is defined and surfaces are looked for; world units */
    uint32_t default_resolution;         /* cells along the longest side of the domain */
    double extraction_bound;             /* see nsdf_mesh_options.dense */
    double smallest_piece;               /* world units: connected pieces of meshes whose box has a shorter diagonal are
                                            left out, being smaller than any of the input; 0 = none */
    uint64_t parameter_count;            /* over all segments; 0 until each was loaded once (nsdf_get_segment_info) */
    uint64_t parameter_hash;             /* of the dequantised parameters of all segments */
    nsdf_quality quality;
} nsdf_info;

NSDF_API NSDF_MUST_USE nsdf_status nsdf_get_info(const nsdf_decoder *decoder, nsdf_info *info);

/* Metadata are pairs of UTF-8 strings, borrowed until nsdf_close. */
NSDF_API uint32_t nsdf_metadata_count(const nsdf_decoder *decoder);
NSDF_API NSDF_MUST_USE nsdf_status nsdf_get_metadata(const nsdf_decoder *decoder, uint32_t index, const char **key,
                                                     const char **value);

/* One segment, and the shape of its network. */
typedef struct nsdf_segment_info {
    double start, end;     /* seconds */
    double fade;           /* seconds: from start - fade to start + fade the surface is mixed with that of the segment
                              before */
    double smallest_piece; /* world units: see nsdf_mesh_options.all_pieces */
    uint64_t offset, size; /* of its chunk in the file, bytes */
    uint64_t parameter_count;
    uint32_t layers, width; /* of the first network part: layers with parameters, the widest of them; 0 when there is
                               none */
    uint32_t blocks, bones; /* of block parts; 0 when there are none */
    char entropy[8];        /* "none", "deflate", "zstd", "range" */
} nsdf_segment_info;

/* Loads the segment if it is not loaded. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_get_segment_info(nsdf_decoder *decoder, uint32_t index,
                                                         nsdf_segment_info *info);
/* What the index says of it, without reading the segment: all fields but parameter_count and those behind it, which
 * are 0. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_get_segment_extent(const nsdf_decoder *decoder, uint32_t index,
                                                           nsdf_segment_info *info);

/* Bytes that the handle holds, and the most that it held so far, together with the mesh that was being extracted into;
 * meshes' own bytes are not in `held`. */
typedef struct nsdf_memory_use {
    uint64_t held, most;
} nsdf_memory_use;

NSDF_API NSDF_MUST_USE nsdf_status nsdf_get_memory_use(const nsdf_decoder *decoder, nsdf_memory_use *use);

/* Exact time of nominal frame `index` in seconds, without the drift of summed steps. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_frame_time(const nsdf_decoder *decoder, uint32_t index, double *seconds);

/* Reads every segment, checks CRCs and the hash of the dequantised parameters. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_verify(nsdf_decoder *decoder);

/* Name of the kernels in use: "c", "avx2", "avx512". */
NSDF_API const char *nsdf_kernel_name(const nsdf_decoder *decoder);

/* ---- Evaluating the field ------------------------------------------------------------------------------- */

/* Optional: loads what time t needs, so that the next call does not stall. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_prepare(nsdf_decoder *decoder, double t);

/* Signed distances, in world units, at `count` points (xyz: 3 * count floats) at time t, clamped to
 * [0, duration].  `gradient` (3 * count floats) may be NULL.  Outside the domain the value is the larger of 0 and
 * the value at the nearest point of the domain, plus the distance to that point: positive.  A NaN time is
 * NSDF_INVALID_ARGUMENT; count 0 is fine. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_evaluate(nsdf_decoder *decoder, double t, const float *xyz, size_t count,
                                                 float *distance, float *gradient);

/* ---- Meshes --------------------------------------------------------------------------------------------- */

typedef struct nsdf_mesh_options {
    size_t struct_size;  /* set by nsdf_mesh_options_init */
    uint32_t resolution; /* cells along the longest side of the domain, 2 to max_resolution; 0 = the file's default */
    uint32_t normals;    /* nonzero (default): unit normals from the gradient */
    uint32_t projection; /* Newton steps that move each vertex onto the zero set; default 2, at most 8 */
    uint32_t dense;      /* nonzero: evaluate every cell.  0 (default): skip a cube of half diagonal r where
                            |f(centre)| > extraction_bound * r; the encoder checks the bound it stores, so that both
                            give the same mesh */
    int (*cancel)(void *user); /* called every few milliseconds on the calling thread, less often only while the
                                  handle's memory grows or a segment is loaded; nonzero stops with NSDF_CANCELLED */
    void *cancel_user;
    uint32_t all_pieces; /* nonzero: keep connected pieces smaller than nsdf_info.smallest_piece too */
} nsdf_mesh_options;

NSDF_API void nsdf_mesh_options_init(nsdf_mesh_options *options);

typedef struct nsdf_mesh nsdf_mesh;

/* Borrowed arrays: valid until the next extraction into the mesh, or nsdf_mesh_free. */
typedef struct nsdf_mesh_view {
    const float *positions;  /* [vertex_count][3], world units */
    const float *normals;    /* [vertex_count][3], unit length, outward; NULL when not asked for */
    const uint32_t *indices; /* [triangle_count][3], counter-clockwise seen from outside */
    uint32_t vertex_count, triangle_count;
} nsdf_mesh_view;

/* The surface at time t (clamped to [0, duration]) as a closed, consistently oriented 2-manifold; empty where there
 * is no surface.  Surfaces that leave the domain are closed at its boundary.  *mesh NULL: a new mesh is made;
 * otherwise its storage is used again.  On failure a mesh that was passed in is empty.  `options` NULL = defaults.
 * The mesh holds a reference to the handle's allocator only: it may outlive the handle. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_extract_mesh(nsdf_decoder *decoder, double t, const nsdf_mesh_options *options,
                                                     nsdf_mesh **mesh);
NSDF_API NSDF_MUST_USE nsdf_status nsdf_mesh_get_view(const nsdf_mesh *mesh, nsdf_mesh_view *view);
/* NULL-safe, sets *mesh to NULL. */
NSDF_API void nsdf_mesh_free(nsdf_mesh **mesh);

/* The same at the highest resolution, up to that of the options (0 = the file's default), that is likely to be ready
 * within `seconds` on this machine, judged by what the handle extracted before; never below 32, or that of the options
 * if it is lower, however long that takes.  What would be late is given up for the resolution 32.  *resolution, unless
 * NULL, becomes the one chosen: it depends on the machine's speed, the mesh depends on it as with nsdf_extract_mesh. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_extract_mesh_within(nsdf_decoder *decoder, double t,
                                                            const nsdf_mesh_options *options, double seconds,
                                                            nsdf_mesh **mesh, uint32_t *resolution);

/* What the last successful extraction with the handle did; all 0 before the first. */
typedef struct nsdf_extraction_stats {
    uint32_t resolution, threads;
    double compose, search, corners, triangles, vertices; /* seconds: parameters at t; search for cells at the surface,
                                                             coarse to fine; values at their corners; triangles and
                                                             pieces; Newton steps and normals */
    uint64_t centres, corner_points, vertex_points; /* points evaluated: centres of cubes in the search, corners, and
                                                       for vertices, value and gradient each counted once */
    uint32_t dropped_pieces; /* pieces left out since they are smaller than the file says that any is */
} nsdf_extraction_stats;

NSDF_API NSDF_MUST_USE nsdf_status nsdf_get_extraction_stats(const nsdf_decoder *decoder, nsdf_extraction_stats *stats);

/* Buffers of the caller.  The counts are filled in on success and on NSDF_BUFFER_TOO_SMALL (then nothing else is
 * written, and a call with those capacities succeeds). */
typedef struct nsdf_mesh_buffers {
    float *positions;  /* room for 3 * vertex_capacity */
    float *normals;    /* the same, or NULL */
    uint32_t *indices; /* room for 3 * triangle_capacity */
    uint32_t vertex_capacity, triangle_capacity;
    uint32_t vertex_count, triangle_count;
} nsdf_mesh_buffers;

NSDF_API NSDF_MUST_USE nsdf_status nsdf_extract_mesh_into(nsdf_decoder *decoder, double t,
                                                          const nsdf_mesh_options *options, nsdf_mesh_buffers *buffers);

#ifdef __cplusplus
}
#endif
#endif

#include "entropy_read.h"

#ifdef NSDF_HAVE_ZSTD

/* For ZSTD_createDCtx_advanced, the only way to hand zstd an allocator. */
#define ZSTD_STATIC_LINKING_ONLY
#include <zstd.h>

/* One frame, decoded in one call into exactly the bytes that are expected: so zstd needs no window of its own, whose
 * size hostile bytes could choose. */
static nsdf_parse decompress(ZSTD_DCtx *context, const uint8_t *data, size_t size, uint8_t *out, size_t out_size,
                             const char **what) {
    if (ZSTD_findFrameCompressedSize(data, size) != size) {
        *what = "coded bytes that are not exactly one zstd frame";
        return NSDF_PARSE_CORRUPT;
    }
    if (ZSTD_decompressDCtx(context, out, out_size, data, size) != out_size) {
        *what = "zstd frame with an error inside or of a wrong length";
        return NSDF_PARSE_CORRUPT;
    }
    return NSDF_PARSE_OK;
}

nsdf_parse nsdf_unzstd(const uint8_t *data, size_t size, uint8_t *out, size_t out_size, const nsdf_codec_memory *memory,
                       const char **what) {
    ZSTD_customMem hooks = {NULL, NULL, NULL};
    if (memory && memory->allocate) {
        hooks.customAlloc = memory->allocate;
        hooks.customFree = memory->release;
        hooks.opaque = memory->user;
    }
    ZSTD_DCtx *context = ZSTD_createDCtx_advanced(hooks);
    if (!context) {
        *what = "no memory for the zstd back end";
        return NSDF_PARSE_NO_MEMORY;
    }
    nsdf_parse status = decompress(context, data, size, out, out_size, what);
    ZSTD_freeDCtx(context);
    return status;
}

#else

nsdf_parse nsdf_unzstd(const uint8_t *data, size_t size, uint8_t *out, size_t out_size, const nsdf_codec_memory *memory,
                       const char **what) {
    (void)data, (void)size, (void)out, (void)out_size, (void)memory;
    *what = "parameters coded with zstd, which this build leaves out";
    return NSDF_PARSE_FEATURE;
}

#endif

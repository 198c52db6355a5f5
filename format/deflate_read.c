#include "entropy_read.h"

#ifdef NSDF_HAVE_ZLIB

#include <stdlib.h>
#include <zlib.h>

static void *allocate(void *user, unsigned int items, unsigned int size) {
    const nsdf_codec_memory *memory = user;
    return memory->allocate(memory->user, (size_t)items * size);
}

static void release(void *user, void *pointer) {
    const nsdf_codec_memory *memory = user;
    memory->release(memory->user, pointer);
}

/* Inflates into exactly the bytes that are expected; zlib may not write beyond. */
static nsdf_parse inflate_all(z_stream *z, const char **what) {
    int code = inflate(z, Z_FINISH);
    if (code == Z_STREAM_END && z->avail_out == 0 && z->avail_in == 0)
        return NSDF_PARSE_OK;
    if (code == Z_MEM_ERROR)
        return NSDF_PARSE_NO_MEMORY;
    *what = code == Z_STREAM_END   ? "deflate stream of a wrong length"
            : z->avail_in == 0     ? "deflate stream that ends too early"
            : code == Z_DATA_ERROR ? "deflate stream with an error inside"
                                   : "deflate stream that holds more bytes than the parameters need";
    return NSDF_PARSE_CORRUPT;
}

nsdf_parse nsdf_inflate(const uint8_t *data, size_t size, uint8_t *out, size_t out_size,
                        const nsdf_codec_memory *memory, const char **what) {
    nsdf_codec_memory hooks = {NULL, NULL, NULL};
    z_stream z = {
        .next_in = (z_const Bytef *)data, .avail_in = (uInt)size, .next_out = out, .avail_out = (uInt)out_size};
    if (memory && memory->allocate) {
        hooks = *memory;
        z.zalloc = allocate;
        z.zfree = release;
        z.opaque = &hooks;
    }
    *what = "no memory for the deflate back end";
    if (inflateInit(&z) != Z_OK)
        return NSDF_PARSE_NO_MEMORY;
    nsdf_parse status = inflate_all(&z, what);
    inflateEnd(&z);
    return status;
}

#else

nsdf_parse nsdf_inflate(const uint8_t *data, size_t size, uint8_t *out, size_t out_size,
                        const nsdf_codec_memory *memory, const char **what) {
    (void)data, (void)size, (void)out, (void)out_size, (void)memory;
    *what = "parameters coded with deflate, which this build leaves out";
    return NSDF_PARSE_FEATURE;
}

#endif

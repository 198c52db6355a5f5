/* Options: defaults, older callers' structs, range checks. */
#include "options.h"
#include "status.h"

#include <string.h>

void nsdf_decoder_options_init(nsdf_decoder_options *options) {
    memset(options, 0, sizeof *options);
    options->struct_size = sizeof *options;
    options->cpu_mask = NSDF_CPU_ALL;
    options->max_memory = (uint64_t)1 << 30;
    options->max_resolution = 1024;
}

void nsdf_mesh_options_init(nsdf_mesh_options *options) {
    memset(options, 0, sizeof *options);
    options->struct_size = sizeof *options;
    options->normals = 1;
    options->projection = 2;
}

static nsdf_status invalid(nsdf_error *error, const char *message) {
    return nsdf_fail(error, NSDF_INVALID_ARGUMENT, 0, 0, "%s", message);
}

static int size_is_valid(size_t given, size_t known) {
    return given >= sizeof(size_t) && given <= known;
}

nsdf_status nsdf_options_resolve(const nsdf_decoder_options *given, nsdf_decoder_options *options, nsdf_error *error) {
    nsdf_decoder_options_init(options);
    if (!given)
        return NSDF_OK;
    if (!size_is_valid(given->struct_size, sizeof *options))
        return invalid(error, "the options' struct_size is 0 or larger than this library knows");
    memcpy(options, given, given->struct_size);
    options->struct_size = sizeof *options;
    if (options->threads > NSDF_MAX_THREADS)
        return invalid(error, "threads is above 256");
    if (!options->allocator.allocate != !options->allocator.release)
        return invalid(error, "the allocator has one of its two functions only");
    return NSDF_OK;
}

nsdf_status nsdf_mesh_options_resolve(const nsdf_mesh_options *given, nsdf_mesh_options *options, nsdf_error *error) {
    nsdf_mesh_options_init(options);
    if (!given)
        return NSDF_OK;
    if (!size_is_valid(given->struct_size, sizeof *options))
        return invalid(error, "the mesh options' struct_size is 0 or larger than this library knows");
    memcpy(options, given, given->struct_size);
    options->struct_size = sizeof *options;
    if (options->projection > NSDF_MAX_PROJECTION)
        return invalid(error, "projection is above 8");
    if (options->resolution != 0 && options->resolution < NSDF_MIN_RESOLUTION)
        return invalid(error, "the resolution is below 2");
    return NSDF_OK;
}

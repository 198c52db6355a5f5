#include "dec_output.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "cli_util.h"

static int has_ending(const char *name, const char *ending) {
    const size_t length = strlen(name), own = strlen(ending);
    return length > own && strcasecmp(name + length - own, ending) == 0;
}

/* From the option, or else from the name. */
static int find_format(const dec_options *options, dec_output *output) {
    nsdf_mesh_format format;
    output->format = options->format;
    if (options->has_format)
        return NSDF_CLI_SUCCESS;
    if (has_ending(options->output, ".glb"))
        output->format = DEC_GLB;
    else if (nsdf_mesh_format_from_name(options->output, &format) == NSDF_OK)
        output->format = (dec_format)format;
    else
        return nsdf_cli_usage_error(
            "cannot tell the format of '%s': let it end in .obj, .ply, .stl or .glb, or use --format", options->output);
    return NSDF_CLI_SUCCESS;
}

#ifdef NSDF_HAVE_GLTF
static const int with_gltf = 1;
#else
static const int with_gltf = 0;
#endif

/* glTF without a frame number in its name is a film. */
static int prepare_film(dec_output *output) {
    if (output->format != DEC_GLB || output->kind == DEC_OUTPUT_HASH || output->kind == DEC_OUTPUT_NULL)
        return NSDF_CLI_SUCCESS;
    if (!with_gltf) {
        nsdf_cli_error("this build cannot write glTF: it was made without tinygltf");
        return NSDF_CLI_FAILURE;
    }
    if (output->kind == DEC_OUTPUT_STDOUT || !output->pattern.suffix)
        output->kind = DEC_OUTPUT_FILM;
    return NSDF_CLI_SUCCESS;
}

int dec_output_prepare(const dec_options *options, dec_output *output) {
    const char *name = options->output;
    memset(output, 0, sizeof *output);
    output->start_number = options->start_number;
    output->format = options->has_format ? options->format : DEC_OBJ;
    output->kind = strcmp(name, "-") == 0       ? DEC_OUTPUT_STDOUT
                   : strcmp(name, "hash:") == 0 ? DEC_OUTPUT_HASH
                   : strcmp(name, "null:") == 0 ? DEC_OUTPUT_NULL
                                                : DEC_OUTPUT_FILES;
    if (output->kind != DEC_OUTPUT_FILES) {
        output->pattern.name = name;
        return prepare_film(output);
    }
    if (nsdf_cli_is_folder(name) || (*name && name[strlen(name) - 1] == '/'))
        return nsdf_cli_usage_error("'%s' is a folder: name the files in it, for example %s%sout_%%04d.obj", name, name,
                                    name[strlen(name) - 1] == '/' ? "" : "/");
    int result = find_format(options, output);
    if (result == NSDF_CLI_SUCCESS)
        result = nsdf_cli_pattern_parse(&output->pattern, name);
    return result == NSDF_CLI_SUCCESS ? prepare_film(output) : result;
}

int dec_output_check_count(const dec_output *output, uint32_t count) {
    if (count == 1)
        return NSDF_CLI_SUCCESS;
    if (output->kind == DEC_OUTPUT_STDOUT)
        return nsdf_cli_usage_error("standard output takes one frame, not %lu: choose it with --frames or --times",
                                    (unsigned long)count);
    if (output->kind == DEC_OUTPUT_FILES && !output->pattern.suffix)
        return nsdf_cli_usage_error("'%s' has no frame number but there are %lu frames: use for example out_%%04d.obj",
                                    output->pattern.name, (unsigned long)count);
    return NSDF_CLI_SUCCESS;
}

char *dec_output_name(const dec_output *output, uint32_t index) {
    return nsdf_cli_pattern_name(&output->pattern, (unsigned long long)output->start_number + index);
}

static int print_hash(const dec_output *output, uint32_t index, double seconds, const nsdf_mesh_view *view) {
    const unsigned long long number = (unsigned long long)output->start_number + index;
    printf("%llu %.9g %016llx\n", number, seconds, (unsigned long long)nsdf_mesh_hash(view));
    if (!ferror(stdout))
        return NSDF_CLI_SUCCESS;
    nsdf_cli_error("cannot write 'standard output': %s", strerror(errno));
    return NSDF_CLI_FAILURE;
}

/* ---- glTF ------------------------------------------------------------------------------------------------- */

static int refuse(const char *name, nsdf_status status) {
    if (status == NSDF_LIMIT)
        nsdf_cli_error("cannot write '%s': it would be larger than 4 GiB, the most that its format allows", name);
    else
        nsdf_cli_error("cannot write '%s': %s", name, nsdf_status_string(status));
    return NSDF_CLI_FAILURE;
}

#ifdef NSDF_HAVE_GLTF
static nsdf_status add_to_film(nsdf_gltf **film, const nsdf_mesh_view *view, double seconds) {
    char generator[64];
    snprintf(generator, sizeof generator, "nsdf-dec %s", nsdf_version_string());
    if (!*film)
        *film = nsdf_gltf_create(generator);
    return *film ? nsdf_gltf_add(*film, view, seconds) : NSDF_NO_MEMORY;
}

static nsdf_status write_gltf(const nsdf_mesh_view *view, double seconds, nsdf_cli_file *file) {
    nsdf_gltf *still = NULL;
    nsdf_status status = add_to_film(&still, view, seconds);
    if (status == NSDF_OK)
        status = nsdf_gltf_write(still, 0.0, nsdf_cli_file_write, file);
    nsdf_gltf_free(still);
    return status;
}

static nsdf_status write_film(const nsdf_gltf *film, double interval, nsdf_cli_file *file) {
    return nsdf_gltf_write(film, interval, nsdf_cli_file_write, file);
}

void dec_output_free(dec_output *output) {
    nsdf_gltf_free(output->film);
    output->film = NULL;
}
#else
/* None of these is reached: dec_output_prepare refuses. */
static nsdf_status add_to_film(nsdf_gltf **film, const nsdf_mesh_view *view, double seconds) {
    return (void)film, (void)view, (void)seconds, NSDF_UNSUPPORTED_FEATURE;
}

static nsdf_status write_gltf(const nsdf_mesh_view *view, double seconds, nsdf_cli_file *file) {
    return (void)view, (void)seconds, (void)file, NSDF_UNSUPPORTED_FEATURE;
}

static nsdf_status write_film(const nsdf_gltf *film, double interval, nsdf_cli_file *file) {
    return (void)film, (void)interval, (void)file, NSDF_UNSUPPORTED_FEATURE;
}

void dec_output_free(dec_output *output) {
    (void)output;
}
#endif

/* ---- Files ------------------------------------------------------------------------------------------------ */

static int close_file(nsdf_cli_file *file, const char *name, nsdf_status status) {
    if (nsdf_cli_file_close(file) != 0)
        return NSDF_CLI_FAILURE; /* says why, also when a write failed */
    return status == NSDF_OK ? NSDF_CLI_SUCCESS : refuse(name, status);
}

static int write_file(const dec_output *output, const char *name, double seconds, const nsdf_mesh_view *view) {
    nsdf_cli_file file;
    if (nsdf_cli_file_open(&file, name) != 0)
        return NSDF_CLI_FAILURE;
    const nsdf_status status =
        output->format == DEC_GLB ? write_gltf(view, seconds, &file)
                                  : nsdf_write_mesh(view, (nsdf_mesh_format)output->format, nsdf_cli_file_write, &file);
    return close_file(&file, name, status);
}

int dec_output_finish(dec_output *output, double interval) {
    nsdf_cli_file file;
    if (output->kind != DEC_OUTPUT_FILM)
        return NSDF_CLI_SUCCESS;
    if (nsdf_cli_file_open(&file, output->pattern.name) != 0)
        return NSDF_CLI_FAILURE;
    return close_file(&file, output->pattern.name, write_film(output->film, interval, &file));
}

int dec_output_write(dec_output *output, uint32_t index, double seconds, const nsdf_mesh_view *view) {
    if (output->kind == DEC_OUTPUT_NULL)
        return NSDF_CLI_SUCCESS;
    if (output->kind == DEC_OUTPUT_HASH)
        return print_hash(output, index, seconds, view);
    if (output->kind == DEC_OUTPUT_STDOUT)
        return write_file(output, "-", seconds, view);
    if (output->kind == DEC_OUTPUT_FILM) {
        const nsdf_status status = add_to_film(&output->film, view, seconds);
        return status == NSDF_OK ? NSDF_CLI_SUCCESS : refuse(output->pattern.name, status);
    }
    char *name = dec_output_name(output, index);
    if (!name) {
        nsdf_cli_error("out of memory");
        return NSDF_CLI_FAILURE;
    }
    const int result = write_file(output, name, seconds, view);
    free(name);
    return result;
}

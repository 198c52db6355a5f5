#include "dec_output.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli_util.h"

int dec_output_prepare(const dec_options *options, dec_output *output) {
    const char *name = options->output;
    memset(output, 0, sizeof *output);
    output->start_number = options->start_number;
    output->format = options->has_format ? options->format : NSDF_MESH_OBJ;
    output->kind = strcmp(name, "-") == 0       ? DEC_OUTPUT_STDOUT
                   : strcmp(name, "hash:") == 0 ? DEC_OUTPUT_HASH
                   : strcmp(name, "null:") == 0 ? DEC_OUTPUT_NULL
                                                : DEC_OUTPUT_FILES;
    if (output->kind != DEC_OUTPUT_FILES)
        return NSDF_CLI_SUCCESS;
    if (nsdf_cli_is_folder(name) || (*name && name[strlen(name) - 1] == '/'))
        return nsdf_cli_usage_error("'%s' is a folder: name the files in it, for example %s%sout_%%04d.obj", name, name,
                                    name[strlen(name) - 1] == '/' ? "" : "/");
    if (!options->has_format && nsdf_mesh_format_from_name(name, &output->format) != NSDF_OK)
        return nsdf_cli_usage_error("cannot tell the format of '%s': let it end in .obj, .ply or .stl, or use --format",
                                    name);
    return nsdf_cli_pattern_parse(&output->pattern, name);
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

static int write_file(const dec_output *output, const char *name, const nsdf_mesh_view *view) {
    nsdf_cli_file file;
    if (nsdf_cli_file_open(&file, name) != 0)
        return NSDF_CLI_FAILURE;
    const nsdf_status status = nsdf_write_mesh(view, output->format, nsdf_cli_file_write, &file);
    if (nsdf_cli_file_close(&file) != 0)
        return NSDF_CLI_FAILURE; /* says why, also when a write failed */
    if (status == NSDF_OK)
        return NSDF_CLI_SUCCESS;
    nsdf_cli_error("cannot write '%s': %s", name, nsdf_status_string(status));
    return NSDF_CLI_FAILURE;
}

int dec_output_write(const dec_output *output, uint32_t index, double seconds, const nsdf_mesh_view *view) {
    if (output->kind == DEC_OUTPUT_NULL)
        return NSDF_CLI_SUCCESS;
    if (output->kind == DEC_OUTPUT_HASH)
        return print_hash(output, index, seconds, view);
    if (output->kind == DEC_OUTPUT_STDOUT)
        return write_file(output, "-", view);
    char *name = dec_output_name(output, index);
    if (!name) {
        nsdf_cli_error("out of memory");
        return NSDF_CLI_FAILURE;
    }
    const int result = write_file(output, name, view);
    free(name);
    return result;
}

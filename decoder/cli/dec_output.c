#include "dec_output.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli_util.h"

enum { MOST_WIDTH = 20 };

/* Takes "%[0][width]d" apart; "%%" stands for "%".  The name never gets to printf as a format. */
static int parse_pattern(const char *name, dec_output *output) {
    int conversions = 0;
    for (const char *at = name; (at = strchr(at, '%')); at++) {
        if (at[1] == '%') {
            at++;
            continue;
        }
        const char *end = at + 1;
        output->zeros = *end == '0';
        output->width = 0;
        for (; isdigit((unsigned char)*end) && output->width <= MOST_WIDTH; end++)
            output->width = 10 * output->width + (*end - '0');
        if (*end != 'd' || output->width > MOST_WIDTH || ++conversions > 1)
            return nsdf_cli_usage_error(
                "'%s' may hold one frame number such as %%d or %%04d, and %%%% for a percent sign", name);
        output->prefix_length = (size_t)(at - name);
        output->suffix = end + 1;
        at = end;
    }
    return NSDF_CLI_SUCCESS;
}

int dec_output_prepare(const dec_options *options, dec_output *output) {
    const char *name = options->output;
    memset(output, 0, sizeof *output);
    output->name = name;
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
    return parse_pattern(name, output);
}

int dec_output_check_count(const dec_output *output, uint32_t count) {
    if (count == 1)
        return NSDF_CLI_SUCCESS;
    if (output->kind == DEC_OUTPUT_STDOUT)
        return nsdf_cli_usage_error("standard output takes one frame, not %lu: choose it with --frames or --times",
                                    (unsigned long)count);
    if (output->kind == DEC_OUTPUT_FILES && !output->suffix)
        return nsdf_cli_usage_error("'%s' has no frame number but there are %lu frames: use for example out_%%04d.obj",
                                    output->name, (unsigned long)count);
    return NSDF_CLI_SUCCESS;
}

/* Appends text with "%%" made "%". */
static char *append(char *at, const char *text, size_t length) {
    for (size_t i = 0; i < length; i++) {
        *at++ = text[i];
        if (text[i] == '%')
            i++;
    }
    *at = 0;
    return at;
}

char *dec_output_name(const dec_output *output, uint32_t index) {
    const size_t size = strlen(output->name) + MOST_WIDTH + 16;
    const unsigned long long number = (unsigned long long)output->start_number + index;
    char *const name = malloc(size);
    if (!name)
        return NULL;
    if (!output->suffix) {
        append(name, output->name, strlen(output->name));
        return name;
    }
    char *at = append(name, output->name, output->prefix_length);
    at += snprintf(at, size - (size_t)(at - name), output->zeros ? "%0*llu" : "%*llu", output->width, number);
    append(at, output->suffix, strlen(output->suffix));
    return name;
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

#include "cmp_heatmap.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "cli_heat.h"
#include "cli_util.h"

int cmp_heatmap_prepare(const char *name, uint32_t count, nsdf_cli_pattern *pattern) {
    const size_t length = strlen(name);
    if (length < 4 || strcasecmp(name + length - 4, ".ply") != 0)
        return nsdf_cli_usage_error("--heatmap: '%s' does not end in .ply", name);
    const int result = nsdf_cli_pattern_parse(pattern, name);
    if (result == NSDF_CLI_SUCCESS && !pattern->suffix && count > 1)
        return nsdf_cli_usage_error("--heatmap: '%s' is one name for %lu frames: use for example out_%%04d.ply", name,
                                    (unsigned long)count);
    return result;
}

/* ---- Contents ------------------------------------------------------------------------------------------- */

static void put_u32(uint8_t *to, uint32_t v) {
    for (int i = 0; i < 4; i++)
        to[i] = (uint8_t)(v >> 8 * i);
}

static void put_f32(uint8_t *to, float f) {
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    put_u32(to, bits);
}

static void write_contents(nsdf_cli_file *file, const nsdf_input_mesh *mesh, const double *distance, double top) {
    char header[320];
    const int n =
        snprintf(header, sizeof header,
                 "ply\nformat binary_little_endian 1.0\nelement vertex %lu\nproperty float x\nproperty float "
                 "y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement "
                 "face %lu\nproperty list uchar uint vertex_indices\nend_header\n",
                 (unsigned long)mesh->vertex_count, (unsigned long)mesh->triangle_count);
    (void)nsdf_cli_file_write(file, header, (size_t)n);
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        uint8_t vertex[15];
        for (size_t k = 0; k < 3; k++)
            put_f32(vertex + 4 * k, (float)mesh->positions[3 * i + k]);
        nsdf_cli_heat_colour(distance[i] / top, vertex + 12);
        (void)nsdf_cli_file_write(file, vertex, sizeof vertex);
    }
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        uint8_t face[13] = {3};
        for (size_t k = 0; k < 3; k++)
            put_u32(face + 1 + 4 * k, mesh->indices[3 * i + k]);
        (void)nsdf_cli_file_write(file, face, sizeof face);
    }
}

int cmp_heatmap_write(const nsdf_cli_pattern *pattern, uint32_t number, const nsdf_input_mesh *mesh,
                      const double *distance, double top) {
    nsdf_cli_file file;
    char *name = nsdf_cli_pattern_name(pattern, number);
    if (!name) {
        nsdf_cli_error("out of memory");
        return NSDF_CLI_FAILURE;
    }
    int result = nsdf_cli_file_open(&file, name);
    free(name);
    if (result == 0) {
        write_contents(&file, mesh, distance, top);
        result = nsdf_cli_file_close(&file);
    }
    return result == 0 ? NSDF_CLI_SUCCESS : NSDF_CLI_FAILURE;
}

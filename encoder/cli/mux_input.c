#include "mux_input.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli_util.h"

enum { POINTS = 1 << 13 };

/* How far from the surface points are looked at, as a fraction of the diagonal. */
static const double near = 0.05;

static int read_all(mux_input *input, FILE *file) {
    size_t capacity = 1 << 16;
    for (;; capacity *= 2) {
        void *grown = realloc(input->data, capacity);
        if (!grown)
            return errno = ENOMEM, -1;
        input->data = grown;
        input->size += fread((char *)input->data + input->size, 1, capacity - input->size, file);
        if (ferror(file))
            return -1;
        if (input->size < capacity)
            return 0;
    }
}

int mux_input_read(mux_input *input, const char *name) {
    *input = (mux_input){.name = name};
    if (nsdf_cli_is_folder(name)) {
        nsdf_cli_error("%s: a folder, not an .nsdf file", name);
        return -1;
    }
    FILE *file = fopen(name, "rb");
    if (file && read_all(input, file) == 0) {
        fclose(file);
        return 0;
    }
    nsdf_cli_error("%s: cannot be read: %s", name, strerror(errno));
    if (file)
        fclose(file);
    return -1;
}

nsdf_mux *mux_input_open(const mux_input *input) {
    nsdf_mux *mux = NULL;
    nsdf_encoder_error error;
    if (nsdf_mux_open(&mux, input->data, input->size, &error) == NSDF_OK)
        return mux;
    nsdf_cli_error("%s: %s", input->name, error.message);
    return NULL;
}

void mux_input_free(mux_input *input) {
    free(input->data);
    memset(input, 0, sizeof *input);
}

/* ---- Gaps ---------------------------------------------------------------------------------------------------------
 */

typedef struct memory_file {
    char *data; /* owned */
    size_t size;
} memory_file;

static int write_memory(void *user, const void *data, size_t size) {
    memory_file *file = user;
    char *grown = realloc(file->data, file->size + size);
    if (!grown)
        return -1;
    memcpy(grown + file->size, data, size);
    file->data = grown;
    file->size += size;
    return 0;
}

/* A file that is short, and ends `held` frames behind the end of another. */
static int make_tail(const mux_input *input, uint32_t held, memory_file *file) {
    nsdf_mux *mux = NULL;
    nsdf_encoder_error error;
    nsdf_status status = nsdf_mux_open(&mux, input->data, input->size, &error);
    if (status == NSDF_OK)
        status = nsdf_mux_hold(mux, held, &error);
    const uint32_t last = nsdf_mux_frame_count(mux) - 1;
    if (status == NSDF_OK)
        status = nsdf_mux_cut(mux, last > 0 ? last - 1 : 0, last, &error);
    if (status == NSDF_OK)
        status = nsdf_mux_write(mux, write_memory, file, &error);
    nsdf_mux_close(&mux);
    return status == NSDF_OK ? 0 : -1;
}

/* Points spread evenly over the domain (the R3 sequence of Roberts). */
static void place_points(const nsdf_info *info, float *xyz) {
    static const double ratio[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    for (size_t i = 0; i < 3 * (size_t)POINTS; i++) {
        const double x = ratio[i % 3] * (double)(i / 3 + 1), size = info->domain_max[i % 3] - info->domain_min[i % 3];
        xyz[i] = (float)(info->domain_min[i % 3] + size * (x - floor(x)));
    }
}

/* Signed distances at those points, as fractions of the diagonal, at the end of a file or at its start.  0, or -1. */
static int evaluate(const void *data, size_t size, int at_end, float *distance) {
    nsdf_decoder *decoder = NULL;
    nsdf_info info;
    float *xyz = malloc(3 * (size_t)POINTS * sizeof *xyz);
    int result = -1;
    if (xyz && nsdf_open_memory(&decoder, data, size, NULL, NULL) == NSDF_OK &&
        nsdf_get_info(decoder, &info) == NSDF_OK) {
        place_points(&info, xyz);
        if (nsdf_evaluate(decoder, at_end ? info.duration : 0.0, xyz, POINTS, distance, NULL) == NSDF_OK)
            result = 0;
        for (int i = 0; i < POINTS; i++)
            distance[i] /= (float)info.diagonal;
    }
    nsdf_close(&decoder);
    free(xyz);
    return result;
}

/* Of the points where one of the distances is small. */
static double mean_difference(const float *a, const float *b) {
    double sum = 0.0;
    int count = 0;
    for (int i = 0; i < POINTS; i++) {
        if (fabs((double)a[i]) > near && fabs((double)b[i]) > near)
            continue;
        sum += fabs((double)a[i] - (double)b[i]);
        count++;
    }
    return count > 0 ? sum / count : HUGE_VAL;
}

double mux_input_gap(const mux_input *input, uint32_t held, const mux_input *next) {
    float *distances = malloc(2 * (size_t)POINTS * sizeof *distances);
    memory_file tail = {NULL, 0};
    double gap = HUGE_VAL;
    if (distances && make_tail(input, held, &tail) == 0 && evaluate(tail.data, tail.size, 1, distances) == 0 &&
        evaluate(next->data, next->size, 0, distances + POINTS) == 0)
        gap = mean_difference(distances, distances + POINTS);
    free(distances);
    free(tail.data);
    return gap;
}

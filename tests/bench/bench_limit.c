/* What the grid alone costs: extracts the exact signed distance of the input, which no model is better than, as meshes
 * that nsdf-cmp then compares with the input.
 *
 *     bench_limit INPUT OUTPUT_%04d.ply [RESOLUTION] */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "frames.h"
#include "mesher.h"
#include "nsdf/export.h"
#include "nsdf/sequence.h"

static const double domain_margin = 0.02; /* as the encoder's */

typedef struct {
    nsdf_memory memory;
    nsdf_tasks *tasks;
    nsdf_mesher *mesher;
    nsdf_mesh_storage storage;
    nsdf_mesher_job job;
} extraction;

static void evaluate(void *user, uint32_t worker, size_t count, const float *const xyz[3], float *value,
                     float *const grad[3]) {
    (void)worker;
    (void)grad; /* asked for no normals and no projection */
    for (size_t i = 0; i < count; i++) {
        const float point[3] = {xyz[0][i], xyz[1][i], xyz[2][i]};
        value[i] = nsdf_sdf_distance(user, point);
    }
}

static nsdf_status load(const char *input, nsdf_frames *frames, nsdf_encoder_error *error) {
    nsdf_sequence *sequence = NULL;
    nsdf_status status = nsdf_sequence_open(&sequence, &input, 1, NULL, error);
    for (uint32_t i = 0; status == NSDF_OK && i < nsdf_sequence_mesh_count(sequence); i++) {
        nsdf_input_mesh mesh;
        const uint32_t frame = nsdf_sequence_mesh_frame(sequence, i);
        status = nsdf_sequence_load(sequence, frame, &mesh, error);
        if (status == NSDF_OK)
            status = nsdf_frames_add(frames, frame, &mesh, error);
    }
    nsdf_sequence_close(&sequence);
    return status;
}

static nsdf_status begin(extraction *e, const nsdf_file_header *header, uint32_t resolution) {
    nsdf_memory_init(&e->memory, NULL, UINT64_C(1) << 34);
    memcpy(e->job.domain_min, header->domain_min, sizeof e->job.domain_min);
    memcpy(e->job.domain_max, header->domain_max, sizeof e->job.domain_max);
    memcpy(e->job.centre, header->centre, sizeof e->job.centre);
    e->job.scale = header->scale;
    e->job.resolution = resolution;
    e->job.bound = 1.01f; /* a distance has slope 1 */
    e->job.field.evaluate = evaluate;
    const nsdf_status status = nsdf_tasks_create(&e->memory, 0, NULL, &e->tasks);
    return status == NSDF_OK ? nsdf_mesher_create(&e->memory, e->tasks, &e->mesher) : status;
}

static int write_bytes(void *file, const void *data, size_t size) {
    return fwrite(data, 1, size, file) != size;
}

static nsdf_status save(const nsdf_mesh_storage *storage, const char *pattern, uint32_t number) {
    char path[4096];
    const nsdf_mesh_view view = {storage->positions, NULL, storage->indices, storage->vertex_count,
                                 storage->triangle_count};
    const char *percent = strchr(pattern, '%'), *letter = percent ? strchr(percent, 'd') : NULL;
    if (!letter)
        return NSDF_INVALID_ARGUMENT;
    snprintf(path, sizeof path, "%.*s%04u%s", (int)(percent - pattern), pattern, number, letter + 1);
    FILE *file = fopen(path, "wb");
    if (!file)
        return NSDF_IO;
    const nsdf_status status = nsdf_write_mesh(&view, NSDF_MESH_PLY, write_bytes, file);
    return fclose(file) == 0 ? status : NSDF_IO;
}

static nsdf_status extract(extraction *e, nsdf_frame *frame, const char *pattern, uint32_t number) {
    static const nsdf_repair_rule rule = {NSDF_SHEETS_NONE, 0.0};
    if (nsdf_frame_repair(frame, &rule) != 0 || nsdf_frame_find_outer(frame) != 0)
        return NSDF_NO_MEMORY;
    nsdf_sdf *sdf = nsdf_frame_sdf(frame);
    if (!sdf)
        return NSDF_NO_MEMORY;
    e->job.field.user = sdf;
    nsdf_status status = nsdf_mesher_run(e->mesher, &e->job, &e->memory, &e->storage);
    nsdf_sdf_free(sdf);
    return status == NSDF_OK ? save(&e->storage, pattern, number) : status;
}

int main(int argc, char **argv) {
    nsdf_frames frames = {0};
    nsdf_file_header header = {0};
    nsdf_encoder_error error = {NSDF_OK, ""};
    extraction e = {0};
    if (argc < 3) {
        fprintf(stderr, "usage: bench_limit INPUT OUTPUT_%%04d.ply [RESOLUTION]\n");
        return 2;
    }
    nsdf_status status = load(argv[1], &frames, &error);
    if (status == NSDF_OK)
        status = nsdf_frames_normalise(&frames, domain_margin, &header, &error);
    if (status == NSDF_OK)
        status = begin(&e, &header, argc > 3 ? (uint32_t)strtoul(argv[3], NULL, 10) : 256);
    for (uint32_t i = 0; status == NSDF_OK && i < frames.count; i++)
        status = extract(&e, &frames.frames[i], argv[2], i);
    if (status != NSDF_OK)
        fprintf(stderr, "bench_limit: %s\n", *error.message ? error.message : nsdf_status_string(status));
    nsdf_mesh_storage_free(&e.memory, &e.storage);
    nsdf_mesher_free(&e.mesher);
    nsdf_tasks_free(&e.tasks);
    nsdf_frames_free(&frames);
    return status == NSDF_OK ? 0 : 1;
}

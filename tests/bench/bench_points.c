/* Looks into the decoder's handle, and puts itself between the mesher and the field. */
#include "bench_points.h"

#include <string.h>

#include "bench_util.h"
#include "handle.h"

enum { RUNS = 2 }; /* the first makes the mesh's memory */

typedef struct counter {
    nsdf_segment_field *field;
    bench_points *points;
} counter;

static void count_and_evaluate(void *user, uint32_t worker, size_t count, const float *const xyz[3], float *value,
                               float *const grad[3]) {
    const counter *c = user;
    const double start = bench_seconds();
    nsdf_segment_field_evaluate(c->field, worker, count, xyz, value, grad);
    c->points->seconds_field += bench_seconds() - start;
    *(grad && grad[0] ? &c->points->gradients : &c->points->values) += count;
}

static void count_and_measure(void *user, uint32_t worker, size_t count, const float *const xyz[3], float enough,
                              float *value, uint8_t *exact) {
    const counter *c = user;
    const double start = bench_seconds();
    nsdf_segment_field_measure(c->field, worker, count, xyz, enough, value, exact);
    c->points->seconds_field += bench_seconds() - start;
    c->points->values += count;
}

static nsdf_mesher_job job_of(const nsdf_decoder *decoder, uint32_t resolution, counter *c) {
    const nsdf_file_header *header = &decoder->stream.header;
    nsdf_mesh_options options;
    nsdf_mesher_job job;
    nsdf_mesh_options_init(&options);
    memset(&job, 0, sizeof job);
    job.field = nsdf_segment_field_view(c->field);
    job.field.user = c;
    job.field.evaluate = count_and_evaluate;
    if (job.field.measure)
        job.field.measure = count_and_measure;
    memcpy(job.domain_min, header->domain_min, sizeof job.domain_min);
    memcpy(job.domain_max, header->domain_max, sizeof job.domain_max);
    memcpy(job.centre, header->centre, sizeof job.centre);
    job.scale = header->scale;
    job.resolution = resolution;
    job.bound = header->extraction_bound;
    job.smallest_piece = decoder->smallest_piece;
    job.normals = options.normals != 0;
    job.projection = options.projection;
    return job;
}

nsdf_status bench_count_points(nsdf_decoder *decoder, double t, uint32_t resolution, bench_points *points) {
    nsdf_mesh_storage storage = {0};
    nsdf_status status = nsdf_handle_prepare(decoder, t);
    if (status == NSDF_OK && !decoder->mesher)
        status = nsdf_mesher_create(&decoder->memory, decoder->tasks, &decoder->mesher);
    if (status != NSDF_OK)
        return status;
    counter c = {&decoder->field, points};
    const nsdf_mesher_job job = job_of(decoder, resolution, &c);
    for (int run = 0; run < RUNS && status == NSDF_OK; run++) {
        memset(points, 0, sizeof *points);
        const double start = bench_seconds();
        status = nsdf_mesher_run(decoder->mesher, &job, &decoder->memory, &storage);
        points->seconds = bench_seconds() - start;
    }
    nsdf_mesh_storage_free(&decoder->memory, &storage);
    return status;
}

static double products(const nsdf_net_layer *layer) {
    return 2.0 * layer->inputs * layer->outputs;
}

/* The gradient is reverse mode: each matrix once more. */
nsdf_status bench_network_flop(nsdf_decoder *decoder, double t, bench_flop *flop) {
    const nsdf_status status = nsdf_handle_prepare(decoder, t);
    if (status != NSDF_OK)
        return status;
    flop->value = 0;
    for (uint32_t i = 0; i < decoder->field.segments[0]->part_count; i++) {
        const nsdf_segment_part *part = &decoder->field.segments[0]->parts[i];
        const nsdf_network *network = &part->at.network;
        if (part->kind != NSDF_PART_NETWORK) {
            *flop = (bench_flop){0, 0};
            return NSDF_OK;
        }
        flop->value += products(&network->encoding);
        for (uint32_t l = 0; l < network->layer_count; l++)
            flop->value += products(&network->layers[l]);
    }
    flop->gradient = flop->value;
    return NSDF_OK;
}

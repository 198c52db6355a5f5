/* Meshes: the library's own, and extraction into the caller's buffers. */
#include "handle.h"
#include "options.h"
#include "status.h"

#include <string.h>

struct nsdf_mesh {
    nsdf_memory memory; /* an account of its own, so that the mesh may outlive the handle */
    nsdf_mesh_storage storage;
};

static nsdf_status fill_job(nsdf_decoder *decoder, const nsdf_mesh_options *options, nsdf_mesher_job *job) {
    const nsdf_file_header *header = &decoder->stream.header;
    memset(job, 0, sizeof *job);
    job->resolution = options->resolution ? options->resolution : header->default_resolution;
    if (job->resolution > decoder->options.max_resolution)
        return nsdf_fail(&decoder->error, NSDF_LIMIT, 0, 0, "resolution %lu is above max_resolution, which is %lu",
                         (unsigned long)job->resolution, (unsigned long)decoder->options.max_resolution);
    memcpy(job->domain_min, header->domain_min, sizeof job->domain_min);
    memcpy(job->domain_max, header->domain_max, sizeof job->domain_max);
    memcpy(job->centre, header->centre, sizeof job->centre);
    job->scale = header->scale;
    job->bound = header->extraction_bound;
    job->dense = options->dense != 0;
    job->smallest_piece = options->all_pieces ? 0.0f : decoder->smallest_piece;
    job->normals = options->normals != 0;
    job->projection = options->projection;
    job->cancel = options->cancel;
    job->cancel_user = options->cancel_user;
    return NSDF_OK;
}

static nsdf_status run_mesher(nsdf_decoder *decoder, nsdf_mesher_job *job, nsdf_memory *memory,
                              nsdf_mesh_storage *storage) {
    nsdf_status status = NSDF_OK;
    job->field = nsdf_segment_field_view(&decoder->field);
    if (!decoder->mesher)
        status = nsdf_mesher_create(&decoder->memory, decoder->tasks, &decoder->mesher);
    return status == NSDF_OK ? nsdf_mesher_run(decoder->mesher, job, memory, storage) : status;
}

static nsdf_status fail_extraction(nsdf_decoder *decoder, nsdf_status status) {
    const char *message = status == NSDF_NO_MEMORY   ? "the allocator did not give what extraction needs"
                          : status == NSDF_LIMIT     ? "extraction needs more than max_memory or 2^32 vertices"
                          : status == NSDF_CANCELLED ? "the cancel callback stopped extraction"
                                                     : "extraction failed";
    return nsdf_fail(&decoder->error, status, 0, 0, "%s", message);
}

static void keep_stats(nsdf_decoder *decoder, uint32_t resolution, double composed) {
    const nsdf_mesher_stats s = nsdf_mesher_get_stats(decoder->mesher);
    decoder->stats = (nsdf_extraction_stats){resolution,      nsdf_tasks_workers(decoder->tasks),
                                             composed,        s.search,
                                             s.corners,       s.triangles,
                                             s.vertices,      s.centres,
                                             s.corner_points, s.vertex_points,
                                             s.dropped_pieces};
}

/* The surface at time t; `storage` belongs to the account `memory`, which may be the handle's. */
static nsdf_status extract(nsdf_decoder *decoder, double t, const nsdf_mesh_options *options, nsdf_memory *memory,
                           nsdf_mesh_storage *storage) {
    nsdf_mesher_job job;
    const double start = nsdf_mesher_clock();
    nsdf_status status = nsdf_handle_prepare(decoder, t);
    const double composed = nsdf_mesher_clock() - start;
    if (status == NSDF_OK)
        status = fill_job(decoder, options, &job);
    if (status != NSDF_OK)
        return status;
    status = run_mesher(decoder, &job, memory, storage);
    if (status == NSDF_LIMIT) {
        nsdf_mesh_storage_free(memory, storage);
        nsdf_handle_trim(decoder, decoder->field.segments);
        status = run_mesher(decoder, &job, memory, storage);
    }
    if (status != NSDF_OK)
        return fail_extraction(decoder, status);
    keep_stats(decoder, job.resolution, composed);
    return NSDF_OK;
}

static nsdf_status create_mesh(const nsdf_decoder *decoder, nsdf_mesh **mesh) {
    nsdf_memory memory;
    void *block;
    nsdf_memory_init(&memory, &decoder->memory.hook, decoder->memory.limit);
    nsdf_status status = nsdf_memory_take(&memory, sizeof **mesh, &block);
    if (status != NSDF_OK)
        return status;
    nsdf_mesh *made = block;
    memset(made, 0, sizeof *made);
    made->memory = memory;
    *mesh = made;
    return NSDF_OK;
}

/* While a mesh is filled, its bytes and the handle's count towards the limit together. */
static nsdf_status extract_beside(nsdf_decoder *decoder, double t, const nsdf_mesh_options *options, nsdf_mesh *mesh) {
    mesh->storage.vertex_count = mesh->storage.triangle_count = 0;
    mesh->memory.beside = &decoder->memory;
    decoder->memory.beside = &mesh->memory;
    nsdf_status status = extract(decoder, t, options, &mesh->memory, &mesh->storage);
    decoder->memory.beside = NULL;
    mesh->memory.beside = NULL;
    if (status != NSDF_OK)
        mesh->storage.vertex_count = mesh->storage.triangle_count = 0;
    return status;
}

nsdf_status nsdf_extract_mesh(nsdf_decoder *decoder, double t, const nsdf_mesh_options *options, nsdf_mesh **mesh) {
    nsdf_mesh_options resolved;
    nsdf_mesh *target = mesh ? *mesh : NULL;
    if (target)
        target->storage.vertex_count = target->storage.triangle_count = 0;
    if (!decoder)
        return NSDF_INVALID_ARGUMENT;
    if (!mesh)
        return nsdf_handle_invalid(decoder, "the mesh is NULL");
    nsdf_status status = nsdf_mesh_options_resolve(options, &resolved, &decoder->error);
    if (status != NSDF_OK)
        return status;
    if (!target) {
        status = create_mesh(decoder, &target);
        if (status != NSDF_OK)
            return nsdf_fail_memory(&decoder->error, status, 0, 0, sizeof *target);
    }
    status = extract_beside(decoder, t, &resolved, target);
    if (status == NSDF_OK)
        *mesh = target;
    else if (!*mesh)
        nsdf_mesh_free(&target);
    return status;
}

nsdf_status nsdf_get_extraction_stats(const nsdf_decoder *decoder, nsdf_extraction_stats *stats) {
    if (!decoder || !stats)
        return NSDF_INVALID_ARGUMENT;
    *stats = decoder->stats;
    return NSDF_OK;
}

nsdf_status nsdf_mesh_get_view(const nsdf_mesh *mesh, nsdf_mesh_view *view) {
    if (!mesh || !view)
        return NSDF_INVALID_ARGUMENT;
    const nsdf_mesh_storage *s = &mesh->storage;
    view->positions = s->positions;
    view->normals = s->has_normals ? s->normals : NULL;
    view->indices = s->indices;
    view->vertex_count = s->vertex_count;
    view->triangle_count = s->triangle_count;
    return NSDF_OK;
}

void nsdf_mesh_free(nsdf_mesh **mesh) {
    if (!mesh || !*mesh)
        return;
    nsdf_memory memory = (*mesh)->memory; /* the account lies in the block it accounts for */
    nsdf_mesh_storage_free(&memory, &(*mesh)->storage);
    nsdf_memory_give(&memory, *mesh);
    *mesh = NULL;
}

static void copy_out(const nsdf_mesh_storage *from, nsdf_mesh_buffers *to) {
    const size_t vectors = (size_t)3 * from->vertex_count, corners = (size_t)3 * from->triangle_count;
    if (vectors > 0)
        memcpy(to->positions, from->positions, vectors * sizeof *to->positions);
    if (vectors > 0 && to->normals && from->has_normals)
        memcpy(to->normals, from->normals, vectors * sizeof *to->normals);
    if (corners > 0)
        memcpy(to->indices, from->indices, corners * sizeof *to->indices);
}

nsdf_status nsdf_extract_mesh_into(nsdf_decoder *decoder, double t, const nsdf_mesh_options *options,
                                   nsdf_mesh_buffers *buffers) {
    nsdf_mesh_options resolved;
    if (!decoder)
        return NSDF_INVALID_ARGUMENT;
    if (!buffers || (buffers->vertex_capacity > 0 && !buffers->positions) ||
        (buffers->triangle_capacity > 0 && !buffers->indices))
        return nsdf_handle_invalid(decoder, "a buffer is NULL");
    nsdf_status status = nsdf_mesh_options_resolve(options, &resolved, &decoder->error);
    if (status != NSDF_OK)
        return status;
    resolved.normals = resolved.normals && buffers->normals;
    status = extract(decoder, t, &resolved, &decoder->memory, &decoder->into);
    if (status != NSDF_OK)
        return status;
    buffers->vertex_count = decoder->into.vertex_count;
    buffers->triangle_count = decoder->into.triangle_count;
    if (buffers->vertex_count > buffers->vertex_capacity || buffers->triangle_count > buffers->triangle_capacity)
        return nsdf_fail(&decoder->error, NSDF_BUFFER_TOO_SMALL, 0, 0, "the mesh has %lu vertices and %lu triangles",
                         (unsigned long)buffers->vertex_count, (unsigned long)buffers->triangle_count);
    copy_out(&decoder->into, buffers);
    return NSDF_OK;
}

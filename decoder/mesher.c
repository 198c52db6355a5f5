/* The run of one frame from phase to phase, and what the phases share. */
#include "mesher_internal.h"

#include <math.h>
#include <string.h>
#include <time.h>

nsdf_status nsdf_mesher_reserve(nsdf_mesher *mesher, nsdf_array *array, uint64_t count, uint64_t used,
                                size_t element_size) {
    return nsdf_memory_grow(mesher->memory, &array->data, &array->capacity, count, used, element_size);
}

/* Seconds between two questions whether to cancel. */
static const double shortest_slice = 0.001, longest_slice = 0.003;

typedef struct slice {
    nsdf_mesher *mesher;
    nsdf_task_fn fn;
    uint32_t first;
} slice;

static void run_in_slice(void *data, uint32_t index, uint32_t worker) {
    const slice *s = data;
    s->fn(s->mesher, s->first + index, worker);
}

double nsdf_mesher_clock(void) {
    struct timespec now;
    return timespec_get(&now, TIME_UTC) ? (double)now.tv_sec + 1e-9 * (double)now.tv_nsec : 0;
}

/* *size tasks at first between two questions, then as many as the time allows.  The clock chooses only how much that
 * is, never what is done. */
static nsdf_status run_slices(nsdf_mesher *mesher, uint64_t count, nsdf_task_fn fn, uint32_t *size) {
    const nsdf_mesher_job *job = mesher->job;
    if (count > UINT32_MAX)
        return NSDF_LIMIT;
    for (uint32_t first = 0; first < count;) {
        if (job->cancel && job->cancel(job->cancel_user))
            return NSDF_CANCELLED;
        slice s = {mesher, fn, first};
        const uint32_t n = nsdf_min_u32(job->cancel ? *size : (uint32_t)count, (uint32_t)count - first);
        const double start = nsdf_mesher_clock();
        nsdf_tasks_run(mesher->tasks, n, run_in_slice, &s);
        const double elapsed = nsdf_mesher_clock() - start;
        if (elapsed < shortest_slice && n == *size && *size < UINT32_MAX / 2)
            *size *= 2;
        if (elapsed > longest_slice && *size > 1)
            *size /= 2;
        first += n;
    }
    return NSDF_OK;
}

/* What one call learned the next ones of the run begin with: they evaluate the same field. */
nsdf_status nsdf_mesher_parallel(nsdf_mesher *mesher, uint64_t count, nsdf_task_fn fn) {
    return run_slices(mesher, count, fn, &mesher->slice);
}

/* Each of these tasks takes some ten microseconds. */
nsdf_status nsdf_mesher_for_bricks(nsdf_mesher *mesher, nsdf_task_fn fn) {
    const uint64_t tasks = ((uint64_t)mesher->brick_count + NSDF_BRICKS_PER_TASK - 1) / NSDF_BRICKS_PER_TASK;
    uint32_t size = 4 * nsdf_tasks_workers(mesher->tasks);
    return run_slices(mesher, tasks, fn, &size);
}

nsdf_status nsdf_mesher_ask(const nsdf_mesher *mesher, uint64_t step, uint32_t every) {
    const nsdf_mesher_job *job = mesher->job;
    return step % every == 0 && job->cancel && job->cancel(job->cancel_user) ? NSDF_CANCELLED : NSDF_OK;
}

nsdf_status nsdf_mesher_create(nsdf_memory *memory, nsdf_tasks *tasks, nsdf_mesher **mesher) {
    void *block;
    const nsdf_status status = nsdf_memory_take(memory, sizeof **mesher, &block);
    if (status != NSDF_OK)
        return status;
    memset(block, 0, sizeof **mesher);
    *mesher = block;
    (*mesher)->memory = memory;
    (*mesher)->tasks = tasks;
    return NSDF_OK;
}

void nsdf_mesher_free(nsdf_mesher **mesher) {
    if (!mesher || !*mesher)
        return;
    nsdf_mesher *m = *mesher;
    nsdf_memory *memory = m->memory;
    nsdf_array *arrays[] = {&m->coordinates, &m->table, &m->bricks, &m->order, &m->values, &m->points, &m->point_values,
                            &m->exact,       &m->cubes, &m->split,  &m->loose, &m->links,  &m->pieces, &m->scratch};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        nsdf_memory_give(memory, arrays[i]->data);
    nsdf_memory_give(memory, m);
    *mesher = NULL;
}

void nsdf_mesh_storage_free(nsdf_memory *storage_memory, nsdf_mesh_storage *storage) {
    nsdf_memory_give(storage_memory, storage->positions);
    nsdf_memory_give(storage_memory, storage->normals);
    nsdf_memory_give(storage_memory, storage->indices);
    memset(storage, 0, sizeof *storage);
}

static int job_is_valid(const nsdf_mesher_job *job) {
    if (job->resolution < 2 || job->resolution > NSDF_MESHER_MAX_RESOLUTION)
        return 0;
    double longest = 0;
    for (int a = 0; a < 3; a++) {
        const double side = (double)job->domain_max[a] - (double)job->domain_min[a];
        if (!isfinite(side) || side < 0)
            return 0;
        if (side > longest)
            longest = side;
    }
    return longest > 0;
}

static nsdf_status begin(nsdf_mesher *mesher) {
    const uint32_t workers = nsdf_tasks_workers(mesher->tasks);
    const nsdf_status status = nsdf_mesher_reserve(mesher, &mesher->scratch, workers, 0, sizeof(nsdf_mesher_scratch));
    if (status != NSDF_OK)
        return status;
    for (uint32_t i = 0; i < workers; i++)
        ((nsdf_mesher_scratch *)mesher->scratch.data)[i].evaluated = 0;
    mesher->evaluated = 0;
    mesher->slice = workers;
    memset(&mesher->stats, 0, sizeof mesher->stats);
    return nsdf_grid_begin(mesher);
}

static nsdf_status make_faces(nsdf_mesher *mesher) {
    const nsdf_status status = nsdf_mesher_make_triangles(mesher);
    return status == NSDF_OK ? nsdf_mesher_drop_pieces(mesher) : status;
}

/* Calls a phase unless one before it failed; adds the seconds that it took. */
static void run_phase(nsdf_mesher *mesher, nsdf_status (*phase)(nsdf_mesher *), double *taken, nsdf_status *status) {
    if (*status != NSDF_OK)
        return;
    const double start = nsdf_mesher_clock();
    *status = phase(mesher);
    *taken += nsdf_mesher_clock() - start;
}

static nsdf_status run_phases(nsdf_mesher *mesher) {
    nsdf_mesher_stats *stats = &mesher->stats;
    nsdf_status status = begin(mesher);
    run_phase(mesher, nsdf_mesher_find_cells, &stats->search, &status);
    stats->centres = mesher->evaluated;
    run_phase(mesher, nsdf_mesher_evaluate_corners, &stats->corners, &status);
    stats->corner_points = mesher->evaluated - stats->centres;
    run_phase(mesher, make_faces, &stats->triangles, &status);
    run_phase(mesher, nsdf_mesher_finish_vertices, &stats->vertices, &status);
    for (uint32_t i = 0; status == NSDF_OK && i < nsdf_tasks_workers(mesher->tasks); i++)
        stats->vertex_points += ((nsdf_mesher_scratch *)mesher->scratch.data)[i].evaluated;
    return status;
}

nsdf_mesher_stats nsdf_mesher_get_stats(const nsdf_mesher *mesher) {
    return mesher->stats;
}

nsdf_status nsdf_mesher_run(nsdf_mesher *mesher, const nsdf_mesher_job *job, nsdf_memory *storage_memory,
                            nsdf_mesh_storage *storage) {
    storage->vertex_count = storage->triangle_count = 0;
    storage->has_normals = 0;
    if (!job_is_valid(job))
        return NSDF_INVALID_ARGUMENT;
    mesher->job = job;
    mesher->storage = storage;
    mesher->storage_memory = storage_memory;
    const nsdf_status status = run_phases(mesher);
    if (status != NSDF_OK)
        storage->vertex_count = storage->triangle_count = 0;
    mesher->job = NULL;
    mesher->storage = NULL;
    mesher->storage_memory = NULL;
    return status;
}

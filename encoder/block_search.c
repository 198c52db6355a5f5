#include "block_search.h"

#include "block_stage.h"
#include "container.h"
#include "nearest.h"
#include "nsdf/decoder.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Extraction follows the surface where the bound fails, and what it misses is looked for by verification. */
static const float search_bound = 1.5f;

/* A frame that a worker looks at. */
typedef struct {
    nsdf_mesh *mesh;
    uint32_t *away; /* vertices away from the input */
    size_t away_count;
    int failed;
} look;

typedef struct {
    const nsdf_fit_job *job;
    nsdf_sample_set *hard;
    float tolerance;
    look *looks; /* [worker] */
    uint32_t first;
} search;

nsdf_sample_set *nsdf_block_hard_create(uint32_t frames) {
    nsdf_sample_set *hard = calloc(frames, sizeof *hard);
    int ok = hard != NULL;
    for (uint32_t i = 0; ok && i < frames; i++) {
        hard[i].x = malloc(NSDF_BLOCK_MOST_HARD * sizeof(float));
        hard[i].y = malloc(NSDF_BLOCK_MOST_HARD * sizeof(float));
        hard[i].z = malloc(NSDF_BLOCK_MOST_HARD * sizeof(float));
        hard[i].d = malloc(NSDF_BLOCK_MOST_HARD * sizeof(float));
        ok = hard[i].x && hard[i].y && hard[i].z && hard[i].d;
    }
    if (ok)
        return hard;
    nsdf_block_hard_free(hard, frames);
    return NULL;
}

void nsdf_block_hard_free(nsdf_sample_set *hard, uint32_t frames) {
    for (uint32_t i = 0; hard && i < frames; i++)
        nsdf_sample_set_free(&hard[i]);
    free(hard);
}

static void to_normalised(const nsdf_file_header *header, const float *world, float out[3]) {
    for (int k = 0; k < 3; k++)
        out[k] = (float)(((double)world[k] - header->centre[k]) / header->scale);
}

static void find_away(look *l, const search *s, const nsdf_mesh_view *view, const nsdf_nearest_index *index,
                      float half) {
    const float limit = half + s->tolerance;
    l->away_count = 0;
    for (uint32_t v = 0; v < view->vertex_count; v++) {
        float x[3];
        to_normalised(s->job->header, view->positions + 3 * (size_t)v, x);
        const double square = nsdf_find_nearest(index, x, limit).distance2;
        if (square >= (double)limit * (double)limit ||
            (half > s->tolerance && square <= pow((double)(half - s->tolerance), 2.0)))
            l->away[l->away_count++] = v;
    }
}

/* Keeps the older samples while there is room. */
static void add_hard(const look *l, const search *s, const nsdf_mesh_view *view, const nsdf_sdf *sdf,
                     nsdf_sample_set *set) {
    size_t room = NSDF_BLOCK_MOST_HARD - set->count;
    if (room < NSDF_BLOCK_MOST_HARD / 2) {
        set->count = NSDF_BLOCK_MOST_HARD / 2;
        room = NSDF_BLOCK_MOST_HARD / 2;
    }
    const size_t count = l->away_count < room ? l->away_count : room;
    for (size_t i = 0; i < count; i++) {
        float x[3];
        to_normalised(s->job->header, view->positions + 3 * (size_t)l->away[i * l->away_count / count], x);
        set->x[set->count] = x[0];
        set->y[set->count] = x[1];
        set->z[set->count] = x[2];
        set->d[set->count++] = nsdf_sdf_distance(sdf, x);
    }
}

static void look_at(void *data, uint32_t task, uint32_t worker) {
    const search *s = data;
    look *l = &s->looks[task];
    const nsdf_frame *frame = &s->job->frames->frames[s->first + task];
    const float shell = (float)(s->job->options->shell / s->job->header->scale);
    nsdf_mesh_view view;
    (void)worker;
    l->failed = nsdf_mesh_get_view(l->mesh, &view) != NSDF_OK;
    l->away = l->failed ? NULL : malloc(((size_t)view.vertex_count + 1) * sizeof *l->away);
    nsdf_nearest_index index;
    l->failed |= nsdf_nearest_index_build(&index, nsdf_frame_outer(frame)) != 0 || !l->away;
    if (!l->failed)
        find_away(l, s, &view, &index, 0.5f * shell);
    if (!l->failed && l->away_count > 0) {
        nsdf_sdf *sdf = nsdf_frame_sdf(frame, shell);
        l->failed = !sdf;
        if (sdf)
            add_hard(l, s, &view, sdf, &s->hard[s->first + task]);
        nsdf_sdf_free(sdf);
    }
    nsdf_nearest_index_free(&index);
    free(l->away);
}

static int extract(const search *s, nsdf_decoder *decoder, uint32_t resolution, uint32_t count) {
    nsdf_mesh_options options;
    nsdf_mesh_options_init(&options);
    options.resolution = resolution;
    options.normals = 0;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t number = s->job->frames->frames[s->first + i].number - s->job->frames->frames[0].number;
        double t = 0.0;
        if (nsdf_frame_time(decoder, number, &t) != NSDF_OK ||
            nsdf_extract_mesh(decoder, t, &options, &s->looks[i].mesh) != NSDF_OK)
            return -1;
    }
    return 0;
}

static int search_file(search *s, const nsdf_buffer *file, uint32_t resolution, uint64_t *found) {
    const uint32_t stretch = nsdf_workers_count(s->job->workers);
    nsdf_decoder *decoder = NULL;
    int failed = nsdf_open_memory(&decoder, file->data, file->size, NULL, NULL) != NSDF_OK;
    s->looks = calloc(stretch, sizeof *s->looks);
    failed |= !s->looks;
    for (; !failed && s->first < s->job->frame_count; s->first += stretch) {
        const uint32_t left = s->job->frame_count - s->first, count = left < stretch ? left : stretch;
        failed = extract(s, decoder, resolution, count);
        if (!failed)
            nsdf_workers_run(s->job->workers, count, look_at, s);
        for (uint32_t i = 0; !failed && i < count; i++) {
            failed |= s->looks[i].failed;
            *found += s->looks[i].away_count;
        }
    }
    for (uint32_t i = 0; s->looks && i < stretch; i++)
        nsdf_mesh_free(&s->looks[i].mesh);
    free(s->looks);
    nsdf_close(&decoder);
    return failed ? -1 : 0;
}

int nsdf_block_search(const nsdf_fit_job *job, const nsdf_block_model *model, uint32_t resolution, float tolerance,
                      nsdf_sample_set *hard, uint64_t *found) {
    nsdf_file_header header = *job->header;
    nsdf_coded_segment segment;
    nsdf_buffer file = {NULL, 0, 0, 0};
    search s = {job, hard, tolerance, NULL, 0};
    memset(&segment, 0, sizeof segment);
    header.extraction_bound = search_bound;
    *found = 0;
    int failed = nsdf_code_blocks(model, &segment) != 0 || nsdf_assemble_file(&header, &segment, NULL, &file) != 0;
    if (!failed)
        failed = search_file(&s, &file, resolution, found);
    nsdf_buffer_free(&segment.payload);
    nsdf_buffer_free(&file);
    return failed ? -1 : 0;
}

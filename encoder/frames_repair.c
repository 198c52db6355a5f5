#include "frames_repair.h"

#include "dataset.h"
#include "encoder_options.h"
#include "fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PLAIN_RESOLUTION = 192, RESOLUTION_STEP = 32 };
/* Of the surface, from which on a sequence is one of sheets. */
static const double share_of_sheets = 0.05;
/* Weight of wrong signs in the loss: about what is thin there are small distances only. */
static const double sign_weight_of_sheets = 4.0;
/* Distance at which a sample has half its weight.  Next to a sheet every sample is near, and most of the loss would be
 * that of its two sides: where their balance is found first, holes stay. */
static const double loss_d0_of_sheets = 0.02;
/* Cells that the thickness of a sheet takes, so that errors of the field leave no holes. */
static const double cells_of_sheet = 1.1;

enum { FAULT_NONE, FAULT_NO_AREA, FAULT_NO_MEMORY };

typedef struct {
    const nsdf_repair_job *job;
    nsdf_repair_rule rule;
    uint32_t first; /* frame of task 0 */
    uint8_t *fault; /* [frame] */
} context;

/* For surfaces that were divided by `scale`, of a sequence with this diagonal. */
static nsdf_repair_rule repair_rule(double shell, double scale, double diagonal) {
    if (shell > 0.0)
        return (nsdf_repair_rule){NSDF_SHEETS_ALL, shell / scale};
    if (shell < 0.0)
        return (nsdf_repair_rule){NSDF_SHEETS_NONE, 0.0};
    return (nsdf_repair_rule){NSDF_SHEETS_AUTO, NSDF_AUTO_THICKNESS * (diagonal / scale)};
}

static void repair_one(void *data, uint32_t index, uint32_t worker) {
    context *c = data;
    const uint32_t i = c->first + index;
    nsdf_frame *frame = &c->job->frames->frames[i];
    (void)worker;
    c->fault[i] = FAULT_NO_AREA;
    if (!(nsdf_surface_area(&frame->surface) > 0.0))
        return;
    const int failed = nsdf_frame_repair(frame, &c->rule) != 0 || nsdf_frame_find_outer(frame) != 0 ||
                       nsdf_frame_find_smallest_piece(frame) != 0;
    c->fault[i] = failed ? FAULT_NO_MEMORY : FAULT_NONE;
}

static nsdf_status check_frames(const context *c, uint32_t from, uint32_t to, nsdf_mesh_report *sum,
                                nsdf_encoder_error *error) {
    for (uint32_t i = from; i < to; i++) {
        nsdf_frame *f = &c->job->frames->frames[i];
        if (c->fault[i] == FAULT_NO_AREA)
            return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "frame %u has no area", f->number);
        if (c->fault[i] == FAULT_NO_MEMORY)
            return nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory for frame %u", f->number);
        f->report.sheet_thickness *= c->job->header->scale;
        nsdf_finish_report(&f->report);
        nsdf_join_reports(sum, &f->report);
    }
    return NSDF_OK;
}

static int is_cancelled(const nsdf_repair_job *job, double done) {
    const nsdf_progress p = {
        NSDF_STAGE_SAMPLE, NSDF_REPAIR_SHARE * done, nsdf_clock() - job->start_time, 0.0, 0.0, -1.0};
    return job->progress && job->progress(job->progress_user, &p) == NSDF_ABORT;
}

nsdf_status nsdf_frames_repair(const nsdf_repair_job *job, nsdf_mesh_report *sum, nsdf_encoder_error *error) {
    const uint32_t count = job->frames->count, stretch = 4 * nsdf_workers_count(job->workers);
    context c = {job, repair_rule(job->options->shell, job->header->scale, job->header->scale), 0, calloc(count, 1)};
    nsdf_status status = c.fault ? NSDF_OK : nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory");
    *sum = (nsdf_mesh_report){0};
    for (uint32_t i = 0; status == NSDF_OK && i < count; i += stretch) {
        const uint32_t n = count - i < stretch ? count - i : stretch;
        c.first = i;
        nsdf_workers_run(job->workers, n, repair_one, &c);
        status = check_frames(&c, i, i + n, sum, error);
        if (status == NSDF_OK && is_cancelled(job, (double)(i + n) / (double)count))
            status = nsdf_encoder_fail(error, NSDF_CANCELLED, "cancelled");
    }
    free(c.fault);
    return status;
}

double nsdf_shell_margin(const nsdf_encoder_options *options, const nsdf_frames *frames) {
    double square = 0.0;
    for (int k = 0; k < 3; k++) {
        const double side = frames->box_max[k] - frames->box_min[k];
        square += side * side;
    }
    return options->shell > 0.0 && square > 0.0 ? 0.5 * options->shell / sqrt(square) : 0.0;
}

static uint32_t resolution_for(double thickness, const nsdf_file_header *header) {
    double longest = 0.0;
    for (int k = 0; k < 3; k++)
        longest = fmax(longest, (double)header->domain_max[k] - (double)header->domain_min[k]);
    const double steps = ceil(cells_of_sheet * longest * header->scale / thickness / RESOLUTION_STEP);
    const double cells = fmin(RESOLUTION_STEP * steps, 1024.0);
    return cells > PLAIN_RESOLUTION ? (uint32_t)cells : PLAIN_RESOLUTION;
}

void nsdf_suit_sheets(nsdf_encoder_options *options, const nsdf_mesh_report *input, const nsdf_file_header *header) {
    if (options->resolution == 0)
        options->resolution =
            input->sheets > 0 ? resolution_for(input->sheet_thickness, header) : (uint32_t)PLAIN_RESOLUTION;
    if (input->sheet_share > share_of_sheets)
        options->blocks = 0;
    const double thickness = input->sheet_thickness / header->scale;
    const int automatic = !(options->loss_sign > 0.0);
    const int thin = input->sheet_share > share_of_sheets && thickness < loss_d0_of_sheets;
    if (options->loss_d0 == 0.0 && thin)
        options->loss_d0 = loss_d0_of_sheets;
    options->loss_sign = !automatic ? options->loss_sign : thin ? sign_weight_of_sheets : 1.0;
    options->loss_sign_error = automatic && thin ? 0.5 * thickness : 0.0;
}

/* ---- One mesh ------------------------------------------------------------------------------------------- */

enum { PROBES = 4000 };

/* As when samples are made. */
static nsdf_status find_inside(const nsdf_frames *frames, const nsdf_file_header *header, nsdf_encoder_error *error) {
    const nsdf_frame *frame = &frames->frames[0];
    nsdf_sampler_params params;
    nsdf_sample_set set = {0};
    nsdf_random random = nsdf_random_start(1, 1000);
    nsdf_sdf *sdf = nsdf_frame_sdf(frame);
    nsdf_sampler_defaults(&params);
    params.count = PROBES;
    memcpy(params.domain_min, header->domain_min, sizeof params.domain_min);
    memcpy(params.domain_max, header->domain_max, sizeof params.domain_max);
    nsdf_status status = NSDF_OK;
    if (!sdf || nsdf_sample_frame(sdf, nsdf_frame_outer(frame), &params, &random, &set) != 0)
        status = nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory");
    else if (!nsdf_has_inside(&set))
        status = nsdf_no_inside(frame, error);
    nsdf_sample_set_free(&set);
    nsdf_sdf_free(sdf);
    return status;
}

static nsdf_status check_frame(nsdf_frames *frames, const nsdf_encoder_options *options, nsdf_mesh_report *report,
                               nsdf_encoder_error *error) {
    nsdf_file_header header = {0};
    nsdf_status status =
        nsdf_frames_normalise(frames, NSDF_DOMAIN_MARGIN + nsdf_shell_margin(options, frames), &header, error);
    nsdf_workers *workers = status == NSDF_OK ? nsdf_workers_create(1) : NULL;
    if (status == NSDF_OK && !workers)
        return nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory");
    const nsdf_repair_job job = {frames, options, &header, workers, NULL, NULL, 0.0};
    if (status == NSDF_OK)
        status = nsdf_frames_repair(&job, report, error);
    nsdf_workers_free(workers);
    return status == NSDF_OK ? find_inside(frames, &header, error) : status;
}

nsdf_status nsdf_encoder_check_mesh(const nsdf_encoder_options *options, const nsdf_input_mesh *mesh,
                                    nsdf_mesh_report *report, nsdf_encoder_error *error) {
    nsdf_frames frames = {0};
    nsdf_mesh_report found = {0};
    if (!options || !mesh || !report)
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given");
    nsdf_status status = nsdf_encoder_options_check(options, error);
    if (status == NSDF_OK)
        status = nsdf_frames_add(&frames, 0, mesh, error);
    if (status == NSDF_OK)
        status = check_frame(&frames, options, &found, error);
    nsdf_frames_free(&frames);
    if (status == NSDF_OK)
        *report = found;
    return status;
}

/* Vertices that were there keep their places to the last bit. */
static nsdf_status copy_repaired(const nsdf_surface *s, const nsdf_file_header *header, const nsdf_input_mesh *mesh,
                                 nsdf_repaired_mesh *repaired, nsdf_encoder_error *error) {
    const size_t numbers = 3 * (size_t)s->vertex_count, corners = 3 * (size_t)s->triangle_count;
    nsdf_repaired_mesh made = {malloc((numbers + 1) * sizeof(double)), malloc((corners + 1) * sizeof(uint32_t)),
                               s->vertex_count, s->triangle_count};
    if (!made.positions || !made.indices) {
        nsdf_repaired_mesh_free(&made);
        return nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory");
    }
    for (size_t i = 0; i < numbers; i++)
        made.positions[i] = i < 3 * (size_t)mesh->vertex_count
                                ? mesh->positions[i]
                                : header->centre[i % 3] + header->scale * (double)s->positions[i];
    memcpy(made.indices, s->indices, corners * sizeof *made.indices);
    *repaired = made;
    return NSDF_OK;
}

nsdf_status nsdf_encoder_repair_mesh(const nsdf_input_mesh *mesh, double shell, double diagonal,
                                     nsdf_repaired_mesh *repaired, nsdf_encoder_error *error) {
    nsdf_frames frames = {0};
    nsdf_file_header header = {0};
    if (!mesh || !repaired || !(diagonal > 0.0))
        return nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "a NULL was given, or no diagonal");
    nsdf_status status = nsdf_frames_add(&frames, 0, mesh, error);
    if (status == NSDF_OK)
        status = nsdf_frames_normalise(&frames, NSDF_DOMAIN_MARGIN, &header, error);
    if (status == NSDF_OK && !(nsdf_surface_area(&frames.frames[0].surface) > 0.0))
        status = nsdf_encoder_fail(error, NSDF_INVALID_ARGUMENT, "frame 0 has no area");
    if (status == NSDF_OK) {
        const nsdf_repair_rule rule = repair_rule(shell, header.scale, diagonal);
        status = nsdf_frame_repair(&frames.frames[0], &rule) == 0
                     ? copy_repaired(&frames.frames[0].surface, &header, mesh, repaired, error)
                     : nsdf_encoder_fail(error, NSDF_NO_MEMORY, "out of memory");
    }
    nsdf_frames_free(&frames);
    return status;
}

void nsdf_repaired_mesh_free(nsdf_repaired_mesh *repaired) {
    free(repaired->positions);
    free(repaired->indices);
    memset(repaired, 0, sizeof *repaired);
}

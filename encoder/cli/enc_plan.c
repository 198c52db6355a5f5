#include "enc_plan.h"

#include "cli_util.h"
#include "enc_look.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Bytes of a file beside what its segments' chunks and its index entries take: preamble, HEAD, INDX, QUAL, META and
 * ENDF (spec, sections 3 to 8), and of an entry. */
enum { FILE_BYTES = 16 + 148 + 28 + 76 + 39 + 20, ENTRY_BYTES = 48 };

static double nominal_frames(const nsdf_cli_list *list) {
    return (double)list->numbers[list->count - 1] - (double)list->numbers[0];
}

/* Frames that a segment of --segment seconds has, of those that are fitted; 0 = left to the plan. */
static uint32_t most_frames(const enc_options *o, const nsdf_cli_list *list) {
    if (!(o->segment > 0.0))
        return o->segment == 0.0 ? list->count + 1 : 0;
    const double nominal = o->segment * o->encoder.rate_num / o->encoder.rate_den;
    const double frames = floor(nominal * (list->count - 1) / fmax(nominal_frames(list), 1.0) + 1e-6) + 1.0;
    return frames < 2.0 ? 2 : frames > list->count ? list->count : (uint32_t)frames;
}

int enc_plan_needed(const enc_options *options, nsdf_sequence *sequence, const nsdf_cli_list *list) {
    nsdf_input_mesh mesh;
    nsdf_encoder_error error;
    const uint32_t most = most_frames(options, list);
    if (most > 0)
        return list->count > most;
    if (list->count > NSDF_SEGMENT_FRAMES)
        return 1;
    if (nsdf_sequence_load(sequence, list->numbers[0], &mesh, &error) != NSDF_OK) {
        nsdf_cli_error("%s", error.message);
        return -1;
    }
    return (uint64_t)mesh.triangle_count * list->count > NSDF_SEGMENT_TRIANGLES;
}

/* ---- Making ------------------------------------------------------------------------------------------------- */

static int take_plan(enc_plan *p, nsdf_survey *survey) {
    nsdf_encoder_error error;
    nsdf_plan_options options;
    const nsdf_span *spans;
    nsdf_plan_options_init(&options);
    options.most_frames = most_frames(p->options, p->list);
    options.overlap = ENC_OVERLAP;
    if (nsdf_survey_plan(survey, &options, &spans, &p->count, &error) != NSDF_OK ||
        nsdf_survey_box(survey, p->box_min, p->box_max) != NSDF_OK) {
        nsdf_cli_error("%s", error.message);
        return -1;
    }
    p->spans = malloc(p->count * sizeof *p->spans);
    p->hashes = malloc(p->count * sizeof *p->hashes);
    if (!p->spans || !p->hashes) {
        nsdf_cli_error("out of memory");
        return -1;
    }
    memcpy(p->spans, spans, p->count * sizeof *spans);
    for (uint32_t i = 0; i < p->count; i++) {
        const nsdf_encoder_options own = enc_plan_options(p, i);
        p->hashes[i] = nsdf_survey_span_hash(survey, &p->spans[i], &own);
    }
    return 0;
}

int enc_plan_make(enc_plan *plan, const enc_options *options, nsdf_sequence *sequence, const nsdf_cli_list *list) {
    nsdf_survey *survey = NULL;
    nsdf_encoder_error error;
    memset(plan, 0, sizeof *plan);
    plan->options = options;
    plan->sequence = sequence;
    plan->list = list;
    plan->at_once = options->jobs;
    if (nsdf_survey_create(&survey, &error) != NSDF_OK) {
        nsdf_cli_error("%s", error.message);
        return -1;
    }
    const int failed = enc_look_over(survey, sequence, list, options->encoder.threads, &plan->triangles) != 0 ||
                       take_plan(plan, survey) != 0;
    nsdf_survey_close(&survey);
    return failed ? -1 : 0;
}

void enc_plan_free(enc_plan *plan) {
    free(plan->spans);
    free(plan->hashes);
    memset(plan, 0, sizeof *plan);
}

/* ---- Segments ----------------------------------------------------------------------------------------------- */

/* The part of the whole time that lies before the place of a frame. */
static double time_before(const enc_plan *p, uint32_t place) {
    return ((double)p->list->numbers[place] - (double)p->list->numbers[0]) / fmax(nominal_frames(p->list), 1.0);
}

/* Processors for each of the segments that are fitted at a time. */
static uint32_t threads_of(uint32_t at_once) {
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    return cores > (long)at_once ? (uint32_t)(cores / (long)at_once) : 1;
}

double enc_plan_size(const enc_plan *plan) {
    const nsdf_encoder_options *o = &plan->options->encoder;
    return o->target_bitrate > 0.0
               ? floor(125.0 * o->target_bitrate * nominal_frames(plan->list) * o->rate_den / o->rate_num)
               : (double)o->target_size;
}

nsdf_encoder_options enc_plan_options(const enc_plan *plan, uint32_t segment) {
    nsdf_encoder_options o = plan->options->encoder;
    const nsdf_span *s = &plan->spans[segment];
    const double from = time_before(plan, s->first), to = time_before(plan, s->last);
    const double size = enc_plan_size(plan);
    if (o.threads == 0 && plan->at_once > 1)
        o.threads = threads_of(plan->at_once);
    o.time_budget *= (double)plan->at_once / plan->count;
    if (!(size > 0.0))
        return o;
    /* Shares of consecutive segments add up; each file of one segment has the bytes of a file once more. */
    const double segments = size - FILE_BYTES - (double)ENTRY_BYTES * plan->count;
    const double share = floor(fmax(segments, 0.0) * to) - floor(fmax(segments, 0.0) * from);
    o.target_bitrate = 0.0;
    o.target_size = (uint64_t)fmax(share + FILE_BYTES + ENTRY_BYTES, 500.0);
    return o;
}

uint32_t enc_plan_fade(const enc_plan *plan, uint32_t segment) {
    if (segment == 0)
        return 0;
    const nsdf_span *s = &plan->spans[segment];
    const uint32_t *numbers = plan->list->numbers;
    const uint32_t before = numbers[s->first] - numbers[s->first - s->lead];
    const uint32_t behind = numbers[s->first + plan->spans[segment - 1].trail] - numbers[s->first];
    return before < behind ? before : behind;
}

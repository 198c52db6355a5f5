/* Where a long sequence is cut into segments that are fitted apart.
 *
 *     nsdf_survey *survey = NULL;
 *     nsdf_survey_create(&survey, &err);
 *     for each frame: nsdf_survey_add(survey, frame_number, &mesh, &err);
 *     nsdf_survey_plan(survey, &opts, &spans, &count, &err);
 *     for each span: an encoder of its frames, with nsdf_encoder_set_part; files joined by nsdf_mux_append
 *     nsdf_survey_close(&survey);
 *
 * A survey keeps some 100 bytes of each frame, so that the sequence may be of any length.  The rules of nsdf/encoder.h
 * hold.
 */
#ifndef NSDF_SURVEY_H
#define NSDF_SURVEY_H

#include "nsdf/encoder.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct nsdf_survey nsdf_survey;

NSDF_API NSDF_MUST_USE nsdf_status nsdf_survey_create(nsdf_survey **survey, nsdf_encoder_error *error);
NSDF_API void nsdf_survey_close(nsdf_survey **survey);

enum { NSDF_MOMENTS = 9 };

/* What a survey wants to know of a mesh. */
typedef struct nsdf_frame_look {
    uint32_t triangles;
    int64_t euler; /* V - F / 2, times 2: changes with the topology of closed meshes */
    uint64_t hash; /* of the mesh */
    /* Centroid, and square roots of the second moments about it and of sums of two of them: lengths, world units, that
     * change as the surface moves. */
    double moments[NSDF_MOMENTS];
    double box_min[3], box_max[3];
} nsdf_frame_look;

/* Looks at a mesh; may run in many threads at a time.  Meshes are judged as by nsdf_encoder_add_frame. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_survey_look(uint32_t frame, const nsdf_input_mesh *mesh, nsdf_frame_look *look,
                                                    nsdf_encoder_error *error);
/* Adds what was found of a frame; numbers ascend. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_survey_add_look(nsdf_survey *survey, uint32_t frame,
                                                        const nsdf_frame_look *look, nsdf_encoder_error *error);
/* Both in one. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_survey_add(nsdf_survey *survey, uint32_t frame, const nsdf_input_mesh *mesh,
                                                   nsdf_encoder_error *error);

NSDF_API uint32_t nsdf_survey_frame_count(const nsdf_survey *survey);

/* The box of all frames, world units.  NSDF_INVALID_ARGUMENT without frames. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_survey_box(const nsdf_survey *survey, double box_min[3], double box_max[3]);

/* A hash of the meshes of `count` frames in the order added, the first of them `first`. */
NSDF_API uint64_t nsdf_survey_hash(const nsdf_survey *survey, uint32_t first, uint32_t count);

/* What a segment has by default at most: frames, and triangles in all of them. */
enum { NSDF_SEGMENT_FRAMES = 240, NSDF_SEGMENT_TRIANGLES = 60000000 };

typedef struct nsdf_plan_options {
    size_t struct_size;   /* set by nsdf_plan_options_init */
    uint32_t most_frames; /* of a segment, 2 up; 0 (default) = NSDF_SEGMENT_FRAMES, fewer where that would be more than
                             NSDF_SEGMENT_TRIANGLES */
    uint32_t overlap;     /* frames that neighbouring segments fit together on each side of a cut; default 2 */
} nsdf_plan_options;

NSDF_API void nsdf_plan_options_init(nsdf_plan_options *options);

/* A segment: places of frames in the order added.  Consecutive spans share the frame of the cut. */
typedef struct nsdf_span {
    uint32_t first, last; /* the segment's own */
    uint32_t lead, trail; /* frames more to be fitted before and behind them */
} nsdf_span;

/* As few segments of nearly the same length as most_frames allows, cut within a quarter of their length where the
 * surface changes its topology or moves as much as on average.  *spans is the survey's, valid until the next call. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_survey_plan(nsdf_survey *survey, const nsdf_plan_options *options,
                                                    const nsdf_span **spans, uint32_t *count,
                                                    nsdf_encoder_error *error);

/* A hash of all that the file of a span depends on: its frames, how far it reaches, the box of all frames, options. */
NSDF_API uint64_t nsdf_survey_span_hash(const nsdf_survey *survey, const nsdf_span *span,
                                        const nsdf_encoder_options *options);

#ifdef __cplusplus
}
#endif

#endif

/* What is remembered of a surveyed frame: as in nsdf_frame_look. */
#ifndef NSDF_SURVEY_PRIVATE_H
#define NSDF_SURVEY_PRIVATE_H

#include "nsdf/survey.h"

typedef struct nsdf_seen_frame {
    uint32_t number, triangles;
    int64_t euler;
    uint64_t hash;
    double moments[NSDF_MOMENTS];
} nsdf_seen_frame;

struct nsdf_survey {
    nsdf_seen_frame *frames;
    uint32_t count, capacity;
    double box_min[3], box_max[3];
    nsdf_span *spans;
};

/* Places of the cuts of `count` frames into segments: cuts[k] ends segment k, the last is count - 1.  Returns the
 * number of segments, 0 when memory ran out; *cuts is the caller's to free. */
uint32_t nsdf_plan_cuts(const nsdf_seen_frame *frames, uint32_t count, uint32_t most_frames, uint32_t **cuts);

#endif

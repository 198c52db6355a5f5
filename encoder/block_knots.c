#include "block_knots.h"

#include "block_model.h"

#include <math.h>

/* What splines may miss the blocks' centres by, as a multiple of what those with a control point at every frame do.
 * Walks, dances, cloth and gears have 1.05 to 1.2 at two frames, a gallop 3.2. */
static const double most_missed = 1.25;
/* Normalised; what is missed by less is not seen beside what fitting leaves. */
static const double unseen = 3e-4;

static double missed_in_frame(const nsdf_block_frame *at, const nsdf_motion *motion, uint32_t frame, double *count) {
    double sum = 0.0;
    for (uint32_t k = 0; k < motion->block_count; k++) {
        const nsdf_pose *pose = &motion->poses[(size_t)frame * motion->block_count + k];
        if (frame < motion->lives[k][0] || frame > motion->lives[k][1])
            continue;
        *count += 1.0;
        for (int row = 0; row < 3; row++) {
            const double off = (double)at->pose[k][4 * row + 3] - pose->position[row];
            sum += off * off;
        }
    }
    return sum;
}

/* Root mean square over blocks and frames; negative when memory ran out. */
static double missed_by(const nsdf_motion *motion, const nsdf_bones *bones, const double *u, double spacing) {
    static const float low[3] = {-1.0f, -1.0f, -1.0f}, high[3] = {1.0f, 1.0f, 1.0f};
    const nsdf_block_steps steps = {1e-4, 1e-4};
    nsdf_block_model model;
    nsdf_block_frame at;
    double sum = 0.0, count = 0.0;
    if (nsdf_block_model_create(&model, motion, bones, u, 0, spacing, 0.0, &steps) != 0)
        return -1.0;
    const int failed = nsdf_block_frame_create(&at, &model, low, high) != 0;
    for (uint32_t f = 0; !failed && f < motion->frame_count; f++) {
        nsdf_block_frame_pose(&at, &model, model.values, u[f]);
        sum += missed_in_frame(&at, motion, f, &count);
    }
    if (!failed)
        nsdf_block_frame_free(&at);
    nsdf_block_model_free(&model);
    return failed ? -1.0 : sqrt(sum / fmax(count, 1.0));
}

double nsdf_block_knot_spacing(const nsdf_motion *motion, const nsdf_bones *bones, const double *u, double spacing) {
    if (!(spacing > 1.0) || motion->frame_count < 3)
        return spacing;
    const double least = missed_by(motion, bones, u, 1.0);
    if (least < 0.0)
        return -1.0;
    for (; spacing > 1.0; spacing /= sqrt(2.0)) {
        const double missed = missed_by(motion, bones, u, spacing);
        if (missed < 0.0)
            return -1.0;
        if (missed <= fmax(most_missed * least, unseen))
            return spacing;
    }
    return 1.0;
}

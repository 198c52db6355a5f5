/* Extraction within a time budget.  The work is a fixed part, which counts at low resolutions, and one that grows with
 * the square of the resolution, nearly.  Two resolutions that differ enough tell them apart; until then all is taken to
 * grow, which errs to the safe side.  The first frame climbs from the lowest resolution as long as there is time. */
#include "handle.h"
#include "options.h"

#include <math.h>

enum { FLOOR = 32, STEP = 8, MOST_STEP = 3 };

/* Part of the budget that is planned for: frames differ. */
static const double planned = 0.85;
/* Resolutions so far apart tell the fixed part of the time from the rest; the first frame climbs in steps at least so
 * large, and at most MOST_STEP, after which the rest is better known. */
static const double apart = 1.4;
/* The fixed part is not taken to be more of a frame's time: the measured times are uncertain. */
static const double most_fixed = 0.9;
/* What was late takes longer than was thought; the next frame that is in time says how much. */
static const double late_slope = 2.0;

typedef struct deadline {
    double at;
    int passed;
    int (*cancel)(void *user);
    void *user;
} deadline;

static int is_late(void *user) {
    deadline *d = user;
    if (d->cancel && d->cancel(d->user))
        return 1;
    d->passed = nsdf_mesher_clock() > d->at;
    return d->passed;
}

static uint32_t resolution_for(const nsdf_pace *pace, double left, uint32_t least, uint32_t most) {
    const double growing = planned * left - pace->fixed;
    const double fits = growing > 0.0 ? sqrt(growing / pace->slope) : 0.0;
    if (!(fits < (double)most))
        return most;
    const uint32_t steps = (uint32_t)fits / STEP * STEP;
    return steps > least ? steps : least;
}

static void learn(nsdf_pace *pace, uint32_t resolution, double seconds) {
    const double square = (double)resolution * resolution, last = (double)pace->resolution * pace->resolution;
    const double ratio = pace->resolution > 0 ? (double)resolution / pace->resolution : 1.0;
    if (ratio >= apart || ratio * apart <= 1.0)
        pace->fixed = seconds - square * (seconds - pace->seconds) / (square - last);
    pace->fixed = fmax(0.0, fmin(pace->fixed, most_fixed * seconds));
    pace->slope = fmax((seconds - pace->fixed) / square, 1e-12);
    pace->resolution = resolution;
    pace->seconds = seconds;
}

/* Extracts at one resolution and learns from how long it took. */
static nsdf_status extract_timed(nsdf_decoder *decoder, double t, nsdf_mesh_options *options, uint32_t resolution,
                                 nsdf_mesh **mesh) {
    const double start = nsdf_mesher_clock();
    options->resolution = resolution;
    const nsdf_status status = nsdf_extract_mesh(decoder, t, options, mesh);
    if (status == NSDF_OK)
        learn(&decoder->pace, resolution, nsdf_mesher_clock() - start);
    return status;
}

/* At a resolution, or, when that is late after all, at the least one. */
static nsdf_status extract_until(nsdf_decoder *decoder, double t, nsdf_mesh_options *options, deadline *d,
                                 uint32_t resolution, uint32_t least, nsdf_mesh **mesh) {
    if (resolution > least) {
        options->cancel = is_late;
        options->cancel_user = d;
        const nsdf_status status = extract_timed(decoder, t, options, resolution, mesh);
        options->cancel = d->cancel;
        options->cancel_user = d->user;
        if (status != NSDF_CANCELLED || !d->passed)
            return status;
        decoder->pace.slope *= late_slope;
        options->resolution = least;
        return nsdf_extract_mesh(decoder, t, options, mesh);
    }
    return extract_timed(decoder, t, options, least, mesh);
}

/* The first frame: at the least resolution, then at higher ones while they are likely to be ready in time.  What the
 * first one alone takes, the segment's loading, is not measured. */
static nsdf_status climb(nsdf_decoder *decoder, double t, nsdf_mesh_options *options, deadline *d, uint32_t least,
                         uint32_t most, nsdf_mesh **mesh) {
    nsdf_status status = nsdf_prepare(decoder, t);
    if (status == NSDF_OK)
        status = extract_timed(decoder, t, options, least, mesh);
    while (status == NSDF_OK && !d->passed) {
        const uint32_t now = options->resolution;
        const uint32_t fits = resolution_for(&decoder->pace, d->at - nsdf_mesher_clock(), least, most);
        if (fits <= now || (fits < most && fits < apart * now))
            break;
        status = extract_until(decoder, t, options, d, fits < MOST_STEP * now ? fits : MOST_STEP * now, least, mesh);
    }
    return status;
}

nsdf_status nsdf_extract_mesh_within(nsdf_decoder *decoder, double t, const nsdf_mesh_options *options, double seconds,
                                     nsdf_mesh **mesh, uint32_t *resolution) {
    const double start = nsdf_mesher_clock();
    nsdf_mesh_options at;
    if (!decoder)
        return NSDF_INVALID_ARGUMENT;
    if (!mesh || !(seconds >= 0.0))
        return nsdf_handle_invalid(decoder, "the mesh is NULL, or the seconds are negative or not a number");
    nsdf_status status = nsdf_mesh_options_resolve(options, &at, &decoder->error);
    if (status != NSDF_OK)
        return status;
    const uint32_t most = at.resolution ? at.resolution : decoder->stream.header.default_resolution;
    const uint32_t least = most < FLOOR ? most : FLOOR;
    deadline d = {start + seconds, 0, at.cancel, at.cancel_user};
    if (decoder->pace.resolution == 0)
        status = climb(decoder, t, &at, &d, least, most, mesh);
    else
        status = extract_until(decoder, t, &at, &d,
                               resolution_for(&decoder->pace, d.at - nsdf_mesher_clock(), least, most), least, mesh);
    if (status == NSDF_OK && resolution)
        *resolution = at.resolution;
    return status;
}

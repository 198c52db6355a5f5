/* Extraction within a time budget.  The work grows with the square of the resolution, nearly, so seconds per squared
 * resolution is what the handle remembers; the fixed part makes that too large when it was measured at a low one, which
 * errs to the safe side and mends itself from frame to frame. */
#include "handle.h"
#include "options.h"

#include <math.h>

enum { FLOOR = 32, STEP = 8 };

/* Part of the budget that is planned for: frames differ. */
static const double planned = 0.85;

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

static uint32_t resolution_for(double pace, double left, uint32_t least, uint32_t most) {
    const double fits = left > 0.0 ? sqrt(planned * left / pace) : 0.0;
    if (!(fits < (double)most))
        return most;
    const uint32_t steps = (uint32_t)fits / STEP * STEP;
    return steps > least ? steps : least;
}

/* Extracts at one resolution and learns from how long it took. */
static nsdf_status extract_timed(nsdf_decoder *decoder, double t, nsdf_mesh_options *options, uint32_t resolution,
                                 nsdf_mesh **mesh) {
    const double start = nsdf_mesher_clock();
    options->resolution = resolution;
    const nsdf_status status = nsdf_extract_mesh(decoder, t, options, mesh);
    const double pace = (nsdf_mesher_clock() - start) / ((double)resolution * resolution);
    if (status == NSDF_OK)
        decoder->pace = pace > 0.0 ? pace : 1e-12;
    return status;
}

/* At the resolution that fits until the deadline, or, when that is late after all, at the least one. */
static nsdf_status extract_until(nsdf_decoder *decoder, double t, nsdf_mesh_options *options, deadline *d,
                                 uint32_t least, uint32_t most, nsdf_mesh **mesh) {
    const uint32_t fits = resolution_for(decoder->pace, d->at - nsdf_mesher_clock(), least, most);
    if (fits > least) {
        options->cancel = is_late;
        options->cancel_user = d;
        const nsdf_status status = extract_timed(decoder, t, options, fits, mesh);
        options->cancel = d->cancel;
        options->cancel_user = d->user;
        if (status != NSDF_CANCELLED || !d->passed)
            return status;
    }
    return extract_timed(decoder, t, options, least, mesh);
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
    int measured = decoder->pace > 0.0;
    if (!measured)
        status = extract_timed(decoder, t, &at, least, mesh);
    if (status == NSDF_OK &&
        (measured || resolution_for(decoder->pace, d.at - nsdf_mesher_clock(), least, most) > least))
        status = extract_until(decoder, t, &at, &d, least, most, mesh);
    if (status == NSDF_OK && resolution)
        *resolution = at.resolution;
    return status;
}

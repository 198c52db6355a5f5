/* The state of fitting as bytes, for checkpoints.  One list of fields serves for writing and for reading, so that the
 * two cannot part: each function here appends what it is given, or fills it. */
#ifndef NSDF_FIT_STATE_H
#define NSDF_FIT_STATE_H

#include "bytes.h"
#include "container_write.h"
#include "fit.h"
#include "frame_order.h"
#include "optimiser.h"
#include "sampler.h"

typedef struct nsdf_fit_state {
    nsdf_buffer *out; /* NULL when reading */
    nsdf_cursor in;   /* a field that does not fit what is to be filled is a failure; see nsdf_cursor_expect */
} nsdf_fit_state;

/* The fields of one kind of fitting. */
typedef void (*nsdf_fit_state_fn)(void *fitting, nsdf_fit_state *state);

static inline int nsdf_state_reading(const nsdf_fit_state *state) {
    return !state->out;
}

/* Reading: what was read is refused unless it is valid. */
static inline void nsdf_state_expect(nsdf_fit_state *state, int valid, const char *what) {
    if (nsdf_state_reading(state))
        nsdf_cursor_expect(&state->in, valid, state->in.at, what);
}

void nsdf_state_u8(nsdf_fit_state *state, uint8_t *v);
void nsdf_state_u32(nsdf_fit_state *state, uint32_t *v);
void nsdf_state_u64(nsdf_fit_state *state, uint64_t *v);
void nsdf_state_f32(nsdf_fit_state *state, float *v);
void nsdf_state_f64(nsdf_fit_state *state, double *v);
void nsdf_state_floats(nsdf_fit_state *state, float *v, size_t count);

/* How far fitting has come: steps, at most `most_steps`, samples, when it began, and its running error. */
void nsdf_state_run(nsdf_fit_state *state, nsdf_fit_result *result, uint64_t most_steps, double *began,
                    double *near_error);
/* When a clock that ran on while nothing was saved began, kept as the seconds since. */
void nsdf_state_clock(nsdf_fit_state *state, double *began);
void nsdf_state_random(nsdf_fit_state *state, nsdf_random *random);
void nsdf_state_order(nsdf_fit_state *state, nsdf_frame_order *order); /* of as many frames */
void nsdf_state_adam(nsdf_fit_state *state, nsdf_adam *adam);          /* of as many parameters */
void nsdf_state_quantisers(nsdf_fit_state *state, nsdf_tensor_list *list);
/* At most `room` samples, for which a set that is read has room. */
void nsdf_state_samples(nsdf_fit_state *state, nsdf_sample_set *set, size_t room);

#endif

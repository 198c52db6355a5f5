#include "fit_state.h"

#include <math.h>

void nsdf_state_u8(nsdf_fit_state *state, uint8_t *v) {
    if (state->out)
        nsdf_buffer_u8(state->out, *v);
    else
        *v = nsdf_take_u8(&state->in);
}

void nsdf_state_u32(nsdf_fit_state *state, uint32_t *v) {
    if (state->out)
        nsdf_buffer_u32(state->out, *v);
    else
        *v = nsdf_take_u32(&state->in);
}

void nsdf_state_u64(nsdf_fit_state *state, uint64_t *v) {
    if (state->out)
        nsdf_buffer_u64(state->out, *v);
    else
        *v = nsdf_take_u64(&state->in);
}

void nsdf_state_f32(nsdf_fit_state *state, float *v) {
    if (state->out)
        nsdf_buffer_f32(state->out, *v);
    else
        *v = nsdf_take_f32(&state->in);
}

void nsdf_state_f64(nsdf_fit_state *state, double *v) {
    if (state->out)
        nsdf_buffer_f64(state->out, *v);
    else
        *v = nsdf_take_f64(&state->in);
}

void nsdf_state_floats(nsdf_fit_state *state, float *v, size_t count) {
    for (size_t i = 0; i < count; i++)
        nsdf_state_f32(state, &v[i]);
}

void nsdf_state_clock(nsdf_fit_state *state, double *began) {
    const double now = nsdf_clock();
    double spent = now - *began;
    nsdf_state_f64(state, &spent);
    nsdf_state_expect(state, spent >= 0.0 && spent < 1e12, "seconds that cannot be");
    if (nsdf_state_reading(state))
        *began = now - spent;
}

void nsdf_state_run(nsdf_fit_state *state, nsdf_fit_result *result, uint64_t most_steps, double *began,
                    double *near_error) {
    nsdf_state_u64(state, &result->steps);
    nsdf_state_expect(state, result->steps <= most_steps, "more steps than there are");
    nsdf_state_u64(state, &result->samples);
    nsdf_state_clock(state, began);
    nsdf_state_f64(state, near_error);
}

void nsdf_state_random(nsdf_fit_state *state, nsdf_random *random) {
    nsdf_state_u64(state, &random->state);
    nsdf_state_u64(state, &random->stream);
    nsdf_state_expect(state, random->stream & 1, "no random stream");
}

void nsdf_state_order(nsdf_fit_state *state, nsdf_frame_order *order) {
    nsdf_state_u32(state, &order->used);
    nsdf_state_expect(state, order->used <= order->count, "more frames used than there are");
    for (uint32_t i = 0; i < order->count; i++) {
        nsdf_state_u32(state, &order->frames[i]);
        nsdf_state_expect(state, order->frames[i] < order->count, "a frame that there is not");
    }
}

void nsdf_state_adam(nsdf_fit_state *state, nsdf_adam *adam) {
    nsdf_state_u64(state, &adam->step);
    nsdf_state_floats(state, adam->mean, adam->count);
    nsdf_state_floats(state, adam->square, adam->count);
}

void nsdf_state_quantisers(nsdf_fit_state *state, nsdf_tensor_list *list) {
    for (uint32_t t = 0; t < list->count; t++)
        for (uint32_t i = 0; i < list->tensors[t].array_count; i++) {
            nsdf_array_desc *a = &list->tensors[t].arrays[i];
            nsdf_state_u8(state, &a->quantiser);
            nsdf_state_f32(state, &a->step);
            nsdf_state_f32(state, &a->offset);
            nsdf_state_expect(state, a->quantiser <= NSDF_QUANT_UNIFORM && isfinite(a->step) && isfinite(a->offset),
                              "no quantiser");
        }
}

void nsdf_state_samples(nsdf_fit_state *state, nsdf_sample_set *set, size_t room) {
    uint64_t count = set->count;
    nsdf_state_u64(state, &count);
    nsdf_state_expect(state, count <= room, "more samples than there is room for");
    if (nsdf_state_reading(state))
        set->count = state->in.status == NSDF_PARSE_OK ? (size_t)count : 0;
    float *const arrays[] = {set->x, set->y, set->z, set->d};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        nsdf_state_floats(state, arrays[i], set->count);
}

#include "rate_control.h"

#include <math.h>

/* ---- The trade-off ---------------------------------------------------------------------------------------
 * Exponents by which the options change with the level, and first guesses of bytes.  Nothing is right only if these
 * are: sizes and errors are measured and corrected.  Measured with
 *     nsdf-enc samba --preset fast --steps 2000 --no-verify --blocks .. --bones .. --pose-step .. --report ..
 * and on gears; see docs/model.md, "Rate control". */
const double nsdf_rate_lowest_level = -3.5, nsdf_rate_highest_level = 5.0, nsdf_rate_highest_for_error = 1.6;
typedef struct {
    double blocks, bones, steps, rate;
} powers;
static const powers coarser = {0.5, 0.7, -0.7, -1.5}, finer = {0.3, 0.85, -0.5, -1.4};
static const uint32_t fewest_blocks = 24, fewest_bones = 2;

static const double still_bytes = 5.5, shape_bytes = 8.0, motion_bits = 4.0, container_bytes = 600.0;
static const double bits_per_octave = 0.8;
static const double least_bits = 0.25;   /* of a number, however coarse */
static const double error_by_step = 2.6; /* error of a preset as a multiple of its pose step */
static const double error_power = 0.55;  /* error falls with this power of e^level */

static double power(double base, double exponent, double level) {
    return base * exp(exponent * level);
}

static uint32_t count_at(uint32_t base, double exponent, double level, uint32_t least, uint32_t most) {
    const double n = rint(power((double)base, exponent, level));
    const uint32_t low = base < least ? base : least;
    return n < (double)low ? low : n > (double)most ? most : (uint32_t)n;
}

static double clamp(double x, double low, double high) {
    return x < low ? low : x > high ? high : x;
}

nsdf_encoder_options nsdf_rate_options_at(const nsdf_encoder_options *base, double level) {
    const powers *p = level < 0.0 ? &coarser : &finer;
    nsdf_encoder_options o = *base;
    o.blocks = count_at(base->blocks, p->blocks, level, fewest_blocks, NSDF_RATE_MOST_BLOCKS);
    o.bones = count_at(base->bones, p->bones, level, fewest_bones, NSDF_RATE_MOST_BONES);
    o.pose_step = clamp(power(base->pose_step, p->steps, level), 1e-7, 0.1);
    o.coefficient_step = clamp(power(base->coefficient_step, p->steps, level), 1e-7, 0.1);
    o.motion_rate = clamp(power(base->motion_rate, p->rate, level), 0.0, 1.0);
    return o;
}

nsdf_rate_measure nsdf_rate_first_guess(const nsdf_encoder_options *base, uint32_t frames) {
    const uint32_t knots = frames > 1 ? 3 + (uint32_t)((double)(frames - 1) / base->block_knot_spacing) : 1;
    nsdf_rate_measure m = {base->blocks, base->bones, knots, base->pose_step, base->coefficient_step, 0.0, 0.0, 0.0};
    m.still = container_bytes + still_bytes * base->blocks;
    m.shapes = shape_bytes * base->blocks;
    m.motion = motion_bits / 8.0 * 12.0 * base->bones * knots;
    return m;
}

/* `bytes` of count_before numbers become those of count numbers with another step: bits_per_octave less for each where
 * the step is twice as long. */
static double requantised(double bytes, double count_before, double count, double step_before, double step) {
    const double bits = 8.0 * bytes / fmax(count_before, 1.0) - bits_per_octave * log2(step / step_before);
    return fmax(bits, least_bits) * count / 8.0;
}

double nsdf_rate_predict(const nsdf_rate_measure *m, const nsdf_encoder_options *o) {
    const double knots = m->knots ? m->knots : 1.0, shape = 10.0;
    const double still = m->still * (double)o->blocks / fmax((double)m->blocks, 1.0);
    return fmax(still, 0.5 * container_bytes) +
           requantised(m->shapes, shape * m->blocks, shape * o->blocks, m->coefficient_step, o->coefficient_step) +
           requantised(m->motion, 12.0 * knots * m->bones, 12.0 * knots * o->bones, m->pose_step, o->pose_step);
}

double nsdf_rate_level_for(const nsdf_rate_measure *m, const nsdf_encoder_options *base, double bytes) {
    double low = nsdf_rate_lowest_level, high = nsdf_rate_highest_level;
    for (int i = 0; i < 40; i++) {
        const double middle = 0.5 * (low + high);
        const nsdf_encoder_options o = nsdf_rate_options_at(base, middle);
        *(nsdf_rate_predict(m, &o) < bytes ? &low : &high) = middle;
    }
    return 0.5 * (low + high);
}

double nsdf_rate_error_level(const nsdf_encoder_options *base, double error) {
    return clamp(log(error_by_step * base->pose_step / error) / error_power, -3.0, 1.0);
}

/* ---- Levels and errors ------------------------------------------------------------------------------------ */

static const double least_power = 0.3, most_power = 1.5; /* of errors beyond those measured */
static const double same_level = 0.1;                    /* too near to tell a slope */
static const double most_coarser = 2.5, most_finer = 1.5;

static void remove_fit(nsdf_rate_curve *c, uint32_t i) {
    for (c->count--; i < c->count; i++) {
        c->level[i] = c->level[i + 1];
        c->error[i] = c->error[i + 1];
    }
}

void nsdf_rate_curve_add(nsdf_rate_curve *c, double level, double error) {
    uint32_t at = 0;
    for (uint32_t i = c->count; i-- > 0;)
        if (fabs(c->level[i] - level) < 1e-6)
            remove_fit(c, i);
    if (c->count == NSDF_RATE_MOST_FITS)
        remove_fit(c, level - c->level[0] > c->level[c->count - 1] - level ? 0 : c->count - 1);
    while (at < c->count && c->level[at] < level)
        at++;
    for (uint32_t i = c->count++; i > at; i--) {
        c->level[i] = c->level[i - 1];
        c->error[i] = c->error[i - 1];
    }
    c->level[at] = level;
    c->error[at] = error;
}

/* -d log(error) / d level between fit i and the next one, and beyond them. */
static double power_between(const nsdf_rate_curve *c, uint32_t i) {
    if (c->count < 2 || c->level[i + 1] - c->level[i] < same_level)
        return error_power;
    return clamp(log(c->error[i] / c->error[i + 1]) / (c->level[i + 1] - c->level[i]), least_power, most_power);
}

double nsdf_rate_curve_error(const nsdf_rate_curve *c, double level) {
    const uint32_t last = c->count - 1;
    if (level <= c->level[0])
        return c->error[0] * exp(power_between(c, 0) * (c->level[0] - level));
    if (level >= c->level[last])
        return c->error[last] * exp(-power_between(c, last > 0 ? last - 1 : 0) * (level - c->level[last]));
    uint32_t i = 0;
    while (c->level[i + 1] < level)
        i++;
    const double share = (level - c->level[i]) / (c->level[i + 1] - c->level[i]);
    return c->error[i] * pow(c->error[i + 1] / c->error[i], share);
}

double nsdf_rate_curve_level(const nsdf_rate_curve *c, double error) {
    const uint32_t last = c->count - 1;
    if (c->error[0] <= error)
        return c->level[0] - fmin(log(error / c->error[0]) / power_between(c, 0), most_coarser);
    for (uint32_t i = 0; i < last; i++)
        if (c->error[i + 1] <= error)
            return c->level[i] +
                   (c->level[i + 1] - c->level[i]) * log(c->error[i] / error) / log(c->error[i] / c->error[i + 1]);
    const double power = power_between(c, last > 0 ? last - 1 : 0);
    return c->level[last] + fmin(log(c->error[last] / error) / power, most_finer);
}

double nsdf_rate_curve_distance(const nsdf_rate_curve *c, double level) {
    double least = INFINITY;
    for (uint32_t i = 0; i < c->count; i++)
        least = fmin(least, fabs(c->level[i] - level));
    return least;
}

/* ---- A common factor -------------------------------------------------------------------------------------- */

static const double size_slope = 0.4, steer_gain = 0.6, most_steer = 0.3; /* -dlog(bytes)/dx, and what steering does */
static const double error_slope = 0.3, least_slope = 0.12, most_slope = 1.0;
static const double most_move = 0.7;
static const double as_far = 0.05;     /* of x: as good as the same */
static const double edge_share = 0.15; /* of a bracket: closer to its ends nothing new is learned */
static const double tight = 0.992, promised = 0.97;
enum { MOST_TRIES = 28 };

double nsdf_rate_steer(double x, uint64_t bytes, uint64_t wanted) {
    const double off = log((double)bytes / (double)wanted) / size_slope;
    return x + clamp(steer_gain * off, -most_steer, most_steer);
}

void nsdf_rate_tried(nsdf_rate_trials *trials, double x, double error) {
    for (uint32_t i = NSDF_RATE_MOST_TRIALS - 1; i > 0; i--) {
        trials->x[i] = trials->x[i - 1];
        trials->error[i] = trials->error[i - 1];
    }
    trials->x[0] = x;
    trials->error[0] = error;
    trials->count += trials->count < NSDF_RATE_MOST_TRIALS;
}

/* Each trial fits on from the one before.  Whether a later one had the error as far out as trial i, which had not. */
static int is_overtaken(const nsdf_rate_trials *trials, uint32_t i, double wanted) {
    for (uint32_t later = 0; later < i; later++)
        if (trials->error[later] <= wanted && trials->x[later] > trials->x[i] - as_far)
            return 1;
    return 0;
}

/* x[0] is the largest that had the error, x[1] the smallest that had not. */
static void bracket(const nsdf_rate_trials *trials, double wanted, double x[2]) {
    x[0] = -INFINITY;
    x[1] = INFINITY;
    for (uint32_t i = 0; i < trials->count; i++)
        if (trials->error[i] <= wanted)
            x[0] = fmax(x[0], trials->x[i]);
        else if (!is_overtaken(trials, i, wanted))
            x[1] = fmin(x[1], trials->x[i]);
}

double nsdf_rate_next(const nsdf_rate_trials *trials, double wanted) {
    const double dx = trials->x[0] - trials->x[1];
    double slope = error_slope, known[2];
    if (trials->count > 1 && fabs(dx) > 1e-3)
        slope = clamp(log(trials->error[0] / trials->error[1]) / dx, least_slope, most_slope);
    const double next = trials->x[0] + clamp(log(wanted / trials->error[0]) / slope, -most_move, most_move);
    bracket(trials, wanted, known);
    const double edge = edge_share * (known[1] - known[0]);
    return edge > 0.0 && isfinite(edge) ? clamp(next, known[0] + edge, known[1] - edge) : next;
}

int nsdf_rate_size_met(uint64_t bytes, uint64_t most) {
    return bytes <= most && (double)bytes >= promised * (double)most;
}

/* Between two x of known sizes where the wanted one is expected; in the middle when that would hardly move. */
static double between(const double x[2], const uint64_t bytes[2], double wanted, int halve) {
    const double a = log((double)bytes[0]), b = log((double)bytes[1]), share = (a - log(wanted)) / (a - b);
    return x[0] + (x[1] - x[0]) * (halve || !(share > 0.02 && share < 0.98) ? 0.5 : share);
}

/* Where to look next: x[0] gave too much, x[1] not. */
static double next_x(const nsdf_rate_search *s, const int known[2], const double x[2], const uint64_t bytes[2],
                     int tries) {
    const double wanted = 0.5 * (1.0 + tight) * (double)s->most;
    if (known[0] && known[1])
        return between(x, bytes, wanted, tries % 3 == 2);
    const int side = known[0] ? 0 : 1;
    const double off = log((double)bytes[side] / wanted) / size_slope;
    const double step = side == 0 ? fmax(1.3 * off, 0.02 * tries) : fmin(1.3 * off, -0.02 * tries);
    return clamp(x[side] + clamp(step, -1.5, 1.5), s->low, s->high);
}

int nsdf_rate_find(const nsdf_rate_search *s, double *x, uint64_t *bytes) {
    double at[2] = {0.0, 0.0}, now = clamp(*x, s->low, s->high), best = now;
    uint64_t size[2] = {0, 0}, found = 0, smallest = UINT64_MAX;
    int known[2] = {0, 0};
    for (int tries = 1; tries <= MOST_TRIES; tries++) {
        uint64_t n = 0;
        if (s->size(s->user, now, &n) != 0)
            return -1;
        const int fits = n <= s->most;
        smallest = n < smallest ? n : smallest;
        if (fits && n > found) {
            found = n;
            best = now;
        }
        if (fits && (double)n >= tight * (double)s->most)
            break;
        at[fits] = now;
        size[fits] = n;
        known[fits] = 1;
        const double next = next_x(s, known, at, size, tries);
        if (next == now)
            break; /* at an end of the range */
        now = next;
    }
    *x = best;
    *bytes = found ? found : smallest;
    return found ? 0 : 1;
}

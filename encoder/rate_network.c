#include "rate_network.h"

#include "container.h"
#include "rate_control.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double probe_share = 0.05, error_probe_share = 0.15; /* of the steps */
static const double probe_gain = 0.6;  /* a whole fit's error as part of that of such a probe */
static const double width_power = 0.8; /* by which errors fall with the width */
static const double most_growth = 1.7; /* of the width from one fit to the next */
/* A short probe may be off by far: a fit that has less than this part of the error is followed by a narrower one. */
static const double too_good = 0.65, least_growth = 0.6;
static const double size_aim = 0.97, error_aim = 0.97;
/* Half a normal distribution's entropy in steps of 6 rms / 2^bits takes so much less than the bits. */
static const double bits_saved = 0.54;
static const double least_bits = 4.0, most_bits = 16.0, bits_by_x = 4.0;
static const double bits_up = 2.0, bits_down = 4.0; /* within which errors are tried */
enum { MOST_REFITS = 2, MOST_CHECKS = 4, BITS_TRIES = 5, LEAST_WIDTH = 4 };

struct nsdf_rate_network {
    nsdf_rate_job job;
    nsdf_encoder_options options; /* given, but with the width of the fit at hand */
    const nsdf_dataset *dataset;
    float **parameters;
    nsdf_fit_result *result;
    nsdf_encoder_error *error;
    double bits;
    uint64_t bytes;
    double aim; /* of quick errors */
    uint32_t refits, checks;
    int stopped;
};

static nsdf_status no_memory(nsdf_rate_network *r) {
    return nsdf_encoder_fail(r->error, NSDF_NO_MEMORY, "out of memory while fitting");
}

nsdf_rate_network *nsdf_rate_network_create(const nsdf_rate_job *job, const nsdf_dataset *dataset, float **parameters) {
    nsdf_rate_network *r = calloc(1, sizeof *r);
    if (!r)
        return NULL;
    r->job = *job;
    r->options = *job->fit.options;
    r->dataset = dataset;
    r->parameters = parameters;
    r->bits = r->options.weight_bits;
    r->aim = error_aim * r->options.target_error;
    return r;
}

void nsdf_rate_network_free(nsdf_rate_network *r) {
    free(r);
}

/* ---- Bytes and errors ------------------------------------------------------------------------------------- */

static void set_bits(nsdf_rate_network *r, double bits) {
    const nsdf_quantise_params quantise = {bits, 0};
    r->bits = bits;
    nsdf_choose_quantisers(r->job.fit.model, &quantise, *r->parameters);
}

/* The file that the network gives now.  0, or -1. */
static int make_file(nsdf_rate_network *r, nsdf_buffer *file) {
    nsdf_coded_segment segment = {{NULL, 0, 0, 0}, 0};
    const int failed = nsdf_code_segment(r->job.fit.model, *r->parameters, &segment) != 0 ||
                       nsdf_rate_make_file(&r->job, &segment, file) != 0;
    nsdf_buffer_free(&segment.payload);
    r->bytes = file->size;
    return failed ? -1 : 0;
}

static int bytes_at(void *user, double x, uint64_t *bytes) {
    nsdf_rate_network *r = user;
    nsdf_buffer file = {NULL, 0, 0, 0};
    set_bits(r, r->options.weight_bits - bits_by_x * x);
    const int failed = make_file(r, &file);
    *bytes = file.size;
    nsdf_buffer_free(&file);
    return failed;
}

static void note(const nsdf_rate_network *r, nsdf_rate_kind kind, uint64_t steps, double error) {
    const nsdf_rate_round round = {kind, 0, 0, r->options.width, steps, 0.0, 0.0, 0.0, r->bits, r->bytes, error};
    nsdf_rate_note(&r->job, &round);
}

static nsdf_status error_at(nsdf_rate_network *r, double bits, double *error) {
    nsdf_coded_segment segment = {{NULL, 0, 0, 0}, 0};
    nsdf_quick_error quick = {0.0, 0.0, 0};
    set_bits(r, bits);
    nsdf_status status = nsdf_code_segment(r->job.fit.model, *r->parameters, &segment) == 0 ? NSDF_OK : no_memory(r);
    if (status == NSDF_OK)
        status = nsdf_rate_quick_error(&r->job, &segment, &quick, r->error);
    nsdf_buffer_free(&segment.payload);
    *error = quick.mean;
    r->bytes = quick.bytes;
    return status;
}

/* ---- Fitting ---------------------------------------------------------------------------------------------- */

static nsdf_status shape(nsdf_rate_network *r, uint32_t width) {
    nsdf_model *model = r->job.fit.model;
    nsdf_random random = nsdf_random_start(r->options.seed, 1);
    r->options.width = width;
    nsdf_model_describe(model, &r->options, r->job.fit.frame_count);
    if (model->parameter_count > NSDF_MAX_PARAMETERS)
        return nsdf_encoder_fail(r->error, NSDF_LIMIT, "the model has %llu parameters, at most %llu are allowed",
                                 (unsigned long long)model->parameter_count, (unsigned long long)NSDF_MAX_PARAMETERS);
    nsdf_dataset_normalise(r->dataset, &r->options, &model->desc);
    free(*r->parameters);
    *r->parameters = malloc(model->parameter_count * sizeof(float));
    if (!*r->parameters)
        return no_memory(r);
    nsdf_model_initialise(model, &random, *r->parameters);
    return NSDF_OK;
}

static nsdf_status fit_width(nsdf_rate_network *r, uint32_t width, double share) {
    const uint64_t steps = r->options.steps;
    nsdf_fit_result some;
    nsdf_fit_job job = r->job.fit;
    nsdf_encoder_options o;
    nsdf_status status = shape(r, width);
    if (status != NSDF_OK)
        return status;
    o = r->options;
    o.steps = (uint64_t)fmax(1.0, rint(share * (double)steps));
    o.hard_samples = share < 1.0 ? 0 : o.hard_samples;
    job.options = &o;
    if (nsdf_fit_run(&job, *r->parameters, &some) != 0)
        return no_memory(r);
    r->bits = o.weight_bits;
    r->stopped |= some.steps < o.steps;
    const uint64_t before = r->result->steps, seen = r->result->samples;
    *r->result = some;
    r->result->steps += before;
    r->result->samples += seen;
    return some.aborted || some.diverged ? NSDF_CANCELLED : NSDF_OK;
}

static double predicted(const nsdf_rate_network *r, uint32_t width) {
    nsdf_encoder_options o = r->options;
    nsdf_model model;
    o.width = width;
    nsdf_model_describe(&model, &o, r->job.fit.frame_count);
    return (double)model.parameter_count * (o.weight_bits - bits_saved) / 8.0;
}

/* The largest width with a predicted size, times `ratio`, of no more than is asked for. */
static uint32_t width_for(const nsdf_rate_network *r, double ratio) {
    uint32_t width = LEAST_WIDTH;
    while (width < NSDF_MAX_WIDTH && ratio * predicted(r, width + 1) <= size_aim * (double)r->job.size)
        width++;
    return width;
}

/* ---- Size ------------------------------------------------------------------------------------------------- */

static nsdf_status too_few(nsdf_rate_network *r, uint64_t least) {
    return nsdf_encoder_fail(r->error, NSDF_LIMIT,
                             "%llu bytes are too few: the least that this sequence takes are %llu",
                             (unsigned long long)r->job.size, (unsigned long long)least);
}

/* Whether the smallest network with the fewest bits is small enough. */
static nsdf_status check_least(nsdf_rate_network *r) {
    uint64_t bytes = 0;
    nsdf_status status = shape(r, LEAST_WIDTH);
    if (status == NSDF_OK && bytes_at(r, (r->options.weight_bits - least_bits) / bits_by_x, &bytes) != 0)
        status = no_memory(r);
    return status == NSDF_OK && bytes > r->job.size ? too_few(r, bytes) : status;
}

static nsdf_status fill(nsdf_rate_network *r) {
    const double b = r->options.weight_bits;
    const nsdf_rate_search search = {bytes_at, r, r->job.size, (b - most_bits) / bits_by_x,
                                     (b - least_bits) / bits_by_x};
    double x = (b - r->bits) / bits_by_x;
    uint64_t bytes = 0;
    const int answer = nsdf_rate_find(&search, &x, &bytes);
    if (answer > 0)
        return too_few(r, bytes);
    if (answer < 0 || bytes_at(r, x, &bytes) != 0)
        return no_memory(r);
    note(r, NSDF_RATE_QUANTISE, 0, 0.0);
    return NSDF_OK;
}

static nsdf_status fit_size(nsdf_rate_network *r) {
    uint64_t bytes = 0;
    nsdf_status status = check_least(r);
    if (status == NSDF_OK)
        status = fit_width(r, width_for(r, 1.0), probe_share);
    if (status == NSDF_OK && bytes_at(r, 0.0, &bytes) != 0)
        status = no_memory(r);
    if (status != NSDF_OK)
        return status;
    note(r, NSDF_RATE_PROBE, r->result->steps, 0.0);
    const uint64_t before = r->result->steps;
    if (!r->stopped)
        status = fit_width(r, width_for(r, (double)bytes / predicted(r, r->options.width)), 1.0);
    if (status == NSDF_OK && bytes_at(r, 0.0, &bytes) != 0)
        status = no_memory(r);
    if (status == NSDF_OK && r->result->steps > before)
        note(r, NSDF_RATE_FIT, r->result->steps - before, 0.0);
    return status == NSDF_OK ? fill(r) : status;
}

/* ---- Error ------------------------------------------------------------------------------------------------ */

/* The fewest bits, to a fraction, with which some frames have the error aimed at; *error is theirs.  With the most bits
 * when not even these do. */
static nsdf_status fewest_bits(nsdf_rate_network *r, double *error) {
    double high = fmin(most_bits, r->options.weight_bits + bits_up);
    double low = fmax(least_bits, r->options.weight_bits - bits_down), met = 0.0;
    nsdf_status status = error_at(r, high, error);
    if (status == NSDF_OK)
        note(r, NSDF_RATE_QUANTISE, 0, *error);
    met = *error;
    for (int i = 0; i < BITS_TRIES && status == NSDF_OK && met <= r->aim && high - low > 0.1; i++) {
        const double middle = 0.5 * (low + high);
        status = error_at(r, middle, error);
        if (status == NSDF_OK)
            note(r, NSDF_RATE_QUANTISE, 0, *error);
        if (*error <= r->aim) {
            high = middle;
            met = *error;
        } else
            low = middle;
    }
    nsdf_buffer file = {NULL, 0, 0, 0};
    set_bits(r, high);
    if (status == NSDF_OK && make_file(r, &file) != 0)
        status = no_memory(r);
    nsdf_buffer_free(&file);
    *error = met;
    return status;
}

static uint32_t width_step(const nsdf_rate_network *r, double error) {
    const double w = ceil((double)r->options.width * pow(error / r->aim, 1.0 / width_power));
    const double least = fmax(LEAST_WIDTH, least_growth * r->options.width);
    return (uint32_t)fmax(least, fmin(w, fmin(NSDF_MAX_WIDTH, most_growth * r->options.width)));
}

/* Whole fits, each with a wider network, until some frames have the error or there were enough of them; the second may
 * be a narrower one. */
static nsdf_status fit_wide_enough(nsdf_rate_network *r, uint32_t width) {
    for (int first = 1;; first = 0) {
        const uint64_t before = r->result->steps;
        double error = 0.0;
        nsdf_status status = fit_width(r, width, 1.0);
        if (status == NSDF_OK)
            status = error_at(r, r->options.weight_bits, &error);
        if (status != NSDF_OK)
            return status;
        note(r, NSDF_RATE_FIT, r->result->steps - before, error);
        if (first && !r->stopped && error < too_good * r->aim && width > LEAST_WIDTH) {
            width = width_step(r, error / too_good);
            continue;
        }
        if (!r->stopped)
            status = fewest_bits(r, &error);
        width = width_step(r, 1.05 * error);
        if (status != NSDF_OK || r->stopped || error <= r->aim || r->refits++ >= MOST_REFITS ||
            width <= r->options.width)
            return status;
    }
}

static nsdf_status fit_error(nsdf_rate_network *r) {
    double error = 0.0;
    nsdf_status status = fit_width(r, r->options.width, error_probe_share);
    if (status == NSDF_OK)
        status = error_at(r, r->bits, &error);
    if (status != NSDF_OK)
        return status;
    note(r, NSDF_RATE_PROBE, r->result->steps, error);
    return r->stopped ? NSDF_OK : fit_wide_enough(r, width_step(r, probe_gain * error));
}

nsdf_status nsdf_rate_network_judge(nsdf_rate_network *r, nsdf_fit_result *result, const nsdf_quality *quality,
                                    int *again, nsdf_encoder_error *error) {
    const double mean = nsdf_mean_error(quality);
    double quick = 0.0;
    r->result = result;
    r->error = error;
    *again = 0;
    if (r->job.size)
        return NSDF_OK;
    nsdf_buffer file = {NULL, 0, 0, 0};
    nsdf_status status = make_file(r, &file) == 0 ? NSDF_OK : no_memory(r);
    nsdf_buffer_free(&file);
    note(r, NSDF_RATE_VERIFY, 0, mean);
    if (status != NSDF_OK || mean <= r->options.target_error || r->stopped || ++r->checks >= MOST_CHECKS)
        return status;
    status = error_at(r, r->bits, &quick);
    r->aim = 0.99 * error_aim * r->options.target_error * quick / mean;
    if (status == NSDF_OK)
        status = fewest_bits(r, &quick);
    if (status == NSDF_OK && quick > r->aim && r->refits < MOST_REFITS) {
        r->refits++;
        status = fit_wide_enough(r, width_step(r, 1.1 * quick));
    } else if (quick > r->aim)
        return status; /* nothing helps */
    *again = 1;
    return status;
}

/* ---- The whole -------------------------------------------------------------------------------------------- */

nsdf_status nsdf_rate_network_requantise(nsdf_rate_network *r, nsdf_encoder_error *error) {
    r->error = error;
    if (r->job.size)
        return fill(r);
    set_bits(r, r->bits);
    return NSDF_OK;
}

nsdf_status nsdf_rate_network_fit(nsdf_rate_network *r, nsdf_fit_result *result, nsdf_encoder_error *error) {
    r->result = result;
    r->error = error;
    memset(result, 0, sizeof *result);
    const nsdf_status status = r->job.size ? fit_size(r) : fit_error(r);
    return status == NSDF_CANCELLED && (result->aborted || result->diverged) ? NSDF_OK : status;
}

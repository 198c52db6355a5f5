/* The arithmetic of meeting a size or an error, apart from anything that is fitted. */
#ifndef NSDF_RATE_CONTROL_H
#define NSDF_RATE_CONTROL_H

#include "nsdf/encoder.h"

/* ---- The trade-off --------------------------------------------------------------------------------------- */

/* Levels are logarithms: 0 stands for the options as they were given, +1 for about e times the motion's bytes. */
enum { NSDF_RATE_MOST_BLOCKS = 20000, NSDF_RATE_MOST_BONES = 1024 };

extern const double nsdf_rate_lowest_level, nsdf_rate_highest_level;
/* For errors: higher levels take much time, and hardly help. */
extern const double nsdf_rate_highest_for_error;

/* `base` with blocks, bones, quantiser steps and the motion's rate as they go together at a level. */
nsdf_encoder_options nsdf_rate_options_at(const nsdf_encoder_options *base, double level);

/* What a fitted model took, from which sizes of others are predicted. */
typedef struct nsdf_rate_measure {
    uint32_t blocks, bones, knots;
    double pose_step, coefficient_step;
    double still, shapes, motion; /* bytes: places and influences with the container; polynomials; motion */
} nsdf_rate_measure;

/* A guess for a sequence of which nothing is known but its length. */
nsdf_rate_measure nsdf_rate_first_guess(const nsdf_encoder_options *base, uint32_t frames);
double nsdf_rate_predict(const nsdf_rate_measure *m, const nsdf_encoder_options *o);
/* The level at which `bytes` are predicted. */
double nsdf_rate_level_for(const nsdf_rate_measure *m, const nsdf_encoder_options *base, double bytes);

/* A level for an error, when nothing is known. */
double nsdf_rate_error_level(const nsdf_encoder_options *base, double error);

enum { NSDF_RATE_MOST_FITS = 6 };

/* Errors of models that were fitted at some levels, by ascending level. */
typedef struct nsdf_rate_curve {
    double level[NSDF_RATE_MOST_FITS], error[NSDF_RATE_MOST_FITS];
    uint32_t count;
} nsdf_rate_curve;

/* Replaces the one at the same level; the one that is furthest away goes when there is no room. */
void nsdf_rate_curve_add(nsdf_rate_curve *curve, double level, double error);

/* Of a curve with at least one fit, logarithms of errors going in straight lines between them and beyond: the error at
 * a level, and the lowest level for an error, at most 2.5 below and 1.5 above all that were tried. */
double nsdf_rate_curve_error(const nsdf_rate_curve *curve, double level);
double nsdf_rate_curve_level(const nsdf_rate_curve *curve, double error);

/* How far the nearest fit is; INFINITY when there is none. */
double nsdf_rate_curve_distance(const nsdf_rate_curve *curve, double level);

/* ---- A common factor on the quantiser steps -------------------------------------------------------------- */

/* x below is the logarithm of that factor; sizes fall and errors rise with it. */

/* The next x, from what x gave, while fitting goes on and the file follows. */
double nsdf_rate_steer(double x, uint64_t bytes, uint64_t wanted);

/* What was tried for an error, the last first. */
enum { NSDF_RATE_MOST_TRIALS = 12 };
typedef struct nsdf_rate_trials {
    double x[NSDF_RATE_MOST_TRIALS], error[NSDF_RATE_MOST_TRIALS];
    uint32_t count;
} nsdf_rate_trials;

/* The first one goes when there is no room. */
void nsdf_rate_tried(nsdf_rate_trials *trials, double x, double error);

/* The next x: by the secant through the logarithms of the last two, but between the largest x that had the error and
 * the smallest that had not, where the former is below the latter; an x that had not no longer counts once a later
 * trial had the error there. */
double nsdf_rate_next(const nsdf_rate_trials *trials, double wanted);

/* Bytes at x; returns 0, or -1 on failure. */
typedef int (*nsdf_rate_size_fn)(void *user, double x, uint64_t *bytes);

typedef struct nsdf_rate_search {
    nsdf_rate_size_fn size;
    void *user;
    uint64_t most;    /* never exceeded */
    double low, high; /* x */
} nsdf_rate_search;

/* Looks for the x, from *x on, with the largest size up to `most`.  Returns 0 and *x and *bytes; 1 when no size up to
 * `most` was found (then *bytes is the smallest); -1 on failure. */
int nsdf_rate_find(const nsdf_rate_search *search, double *x, uint64_t *bytes);

/* Whether a size is what was promised for `most`: at most 3 % smaller. */
int nsdf_rate_size_met(uint64_t bytes, uint64_t most);

#endif

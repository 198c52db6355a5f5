/* From a fitted model of blocks to one with the error that is asked for. */
#ifndef NSDF_RATE_ERROR_H
#define NSDF_RATE_ERROR_H

#include "rate_control.h"
#include "rate_model.h"

typedef struct nsdf_error_search {
    nsdf_rate_model *m;
    nsdf_rate_curve probes, fits;                   /* errors at levels, by x = 0 */
    nsdf_rate_trials trials;                        /* of the fit at hand */
    double whole_by_quick;                          /* error of all frames as a multiple of that of some */
    uint32_t fit, fits_made, refits, tunes, checks; /* fit: the number of the one at hand */
    nsdf_rate_copy held; /* has the error by quick measure, with the fewest bytes since approaching began */
    uint32_t mends;      /* rounds with samples of the pieces astray that verification found */
    uint32_t fit_mends;  /* those of the fit at hand */
    uint64_t verified;   /* m->steps when verification did */
    uint32_t held_fit;
    int held_is_sure;             /* verification will hardly refuse it */
    nsdf_rate_trials held_trials; /* of that fit */
    nsdf_rate_copy best; /* of those that were verified: with the error and the fewest bytes, or nearest to it */
    double best_error;
    int finished;
} nsdf_error_search;

/* *m is borrowed until the free. */
void nsdf_error_search_init(nsdf_error_search *s, nsdf_rate_model *m);
void nsdf_error_search_free(nsdf_error_search *s);

/* What a probe, the model as it is now, tells. */
void nsdf_error_search_probed(nsdf_error_search *s);

/* The level for the error, from all that is known; there was a probe or a fit. */
double nsdf_error_search_level(const nsdf_error_search *s);

/* Fits at the level for the error, and goes on until some frames have the error, if they can have it. */
nsdf_status nsdf_error_search_run(nsdf_error_search *s);

/* After all frames of the model's file were verified: as nsdf_rate_blocks_judge. */
nsdf_status nsdf_error_search_judge(nsdf_error_search *s, const nsdf_quality *quality, int *again);

#endif

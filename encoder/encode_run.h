/* One encoding, from added frames to the file: what its stages share, and the stages. */
#ifndef NSDF_ENCODE_RUN_H
#define NSDF_ENCODE_RUN_H

#include "block_stage.h"
#include "checkpoint.h"
#include "container.h"
#include "dataset.h"
#include "rate_blocks.h"
#include "rate_network.h"

struct nsdf_encoder {
    nsdf_encoder_options options;
    nsdf_frames frames;
    nsdf_frames shown; /* those of them that the file's time reaches; borrowed, made by the run */
    int ran;           /* run was called */
    nsdf_buffer file;
    nsdf_encoder_stats stats;
    /* The fitted network, for nsdf_encoder_recode. */
    nsdf_file_header header;
    nsdf_index_entry entry; /* lead, trail and smallest_piece */
    nsdf_model model;
    float *parameters;
    nsdf_block_model blocks; /* instead of the network, if it has values */
    /* What was measured last, and the hash of the decoded parameters that it was measured with. */
    int measured;
    uint64_t measured_hash;
    float measured_piece; /* entry.smallest_piece then */
    nsdf_quality_record quality;
    nsdf_checkpoint checkpoint; /* of the main fit, but not of a network that follows blocks */
};

typedef struct nsdf_run {
    nsdf_encoder *encoder;
    nsdf_progress_fn progress;
    void *user;
    nsdf_encoder_error *error; /* of the stage that failed */
    nsdf_workers *workers;
    nsdf_dataset dataset;
    nsdf_fit_result fit;
    nsdf_tracked tracked; /* the surface, if the model is blocks */
    int is_tracked;
    double seconds_track, seconds_check; /* following the surface; coding and verifying, the last time */
    nsdf_sample_set *strays;             /* [frame]: what verification found */
    nsdf_coded_segment segment;
    uint32_t verified;             /* frames that verification looks at; 0 = all */
    uint64_t size;                 /* asked for, 0 = none */
    nsdf_rate_blocks *rate_blocks; /* with a target, one of the two */
    nsdf_rate_network *rate_network;
    double start;
} nsdf_run;

/* Whether the model is, or will be, blocks. */
static inline int nsdf_run_uses_blocks(const nsdf_run *run) {
    return run->encoder->options.blocks > 0;
}

/* Whether a size, bitrate or error is asked for, which rate control meets. */
static inline int nsdf_run_has_target(const nsdf_run *run) {
    return run->size > 0 || run->encoder->options.target_error > 0.0;
}

/* ---- Before fitting (encode_prepare.c) ------------------------------------------------------------------ */

/* Normalises and repairs the frames, follows the surface if the model is to be blocks, describes the model, and makes
 * what all stages share. */
nsdf_status nsdf_run_prepare(nsdf_run *run);

/* Fills run->dataset, which has to be empty. */
nsdf_status nsdf_run_sample(nsdf_run *run);

/* ---- Fitting (encode_fit.c) ----------------------------------------------------------------------------- */

/* Borrows from the run. */
nsdf_fit_job nsdf_run_fit_job(nsdf_run *run);

/* Fits the model, to the target if there is one.  checkpoint: NULL for none. */
nsdf_status nsdf_run_fit(nsdf_run *run, nsdf_checkpoint *checkpoint);

/* Whether fitting, or more of it, came to a usable end.  failed: memory ran out, or a checkpoint did not fit. */
nsdf_status nsdf_run_fitted(nsdf_run *run, int failed);

/* ---- Coding and checking (encode_check.c) --------------------------------------------------------------- */

/* Below what size decoders should leave pieces out, as a fraction of the diagonal, before anything is verified. */
float nsdf_run_smallest_piece(const nsdf_run *run);

/* Codes the model as the options say: run->segment, and a file without quality record. */
nsdf_status nsdf_run_code(nsdf_run *run);

/* Codes, finds the bound and, when verifying, the error and strays.  The same parameters as the last time are not
 * measured again. */
nsdf_status nsdf_run_code_and_check(nsdf_run *run);

void nsdf_run_forget_strays(nsdf_run *run);

/* ---- After verification (encode_mend.c) ----------------------------------------------------------------- */

/* Fits a little more while pieces are astray and that helps; without a target, what makes the file no better is taken
 * back.  whole: fitting took all its steps, or the time that was asked for. */
nsdf_status nsdf_run_mend(nsdf_run *run, int whole);

/* Where blocks come apart, as they do where drops fly off and fall back, fits a network too, and keeps the better of
 * the two.  whole: fitting took all its steps. */
nsdf_status nsdf_run_try_network(nsdf_run *run, int whole);

#endif

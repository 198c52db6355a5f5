/* NSDF encoder: fits a network to a sequence of meshes and writes an `.nsdf` file.
 *
 *     nsdf_encoder_options opts;
 *     nsdf_encoder *enc = NULL;
 *     nsdf_encoder_options_init(&opts);
 *     nsdf_encoder_create(&enc, &opts, &err);
 *     for each frame: nsdf_encoder_add_frame(enc, frame_number, &mesh, &err);
 *     nsdf_encoder_run(enc, progress, user, &err);
 *     nsdf_encoder_write(enc, write, user, &err);
 *     nsdf_encoder_close(&enc);
 *
 * The rules of nsdf/decoder.h hold: nothing prints or exits, out parameters are untouched on failure, one thread at a
 * time per handle.  The same frames, options and seed give the same file, whatever the number of threads (on one kind
 * of processor: other vector widths round differently while fitting).
 */
#ifndef NSDF_ENCODER_H
#define NSDF_ENCODER_H

#include "nsdf/decoder.h"
#include "nsdf/mesh_report.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum nsdf_preset {
    NSDF_PRESET_FAST = 0,
    NSDF_PRESET_MEDIUM = 1, /* default */
    NSDF_PRESET_SLOW = 2,
    NSDF_PRESET_THESIS = 3, /* 16 x 256 relu, tanh output, xyzt: the network of thesis chapter 8 */
    NSDF_PRESET_BEST = 4
} nsdf_preset;

typedef enum nsdf_model_input { NSDF_MODEL_XYZ = 0, NSDF_MODEL_XYZT = 1, NSDF_MODEL_FOURIER = 2 } nsdf_model_input;
typedef enum nsdf_model_activation {
    NSDF_MODEL_SINE = 0,
    NSDF_MODEL_RELU = 1,
    NSDF_MODEL_TANH = 2
} nsdf_model_activation;
typedef enum nsdf_tensor_time { NSDF_TIME_CONSTANT = 0, NSDF_TIME_SPLINE = 1, NSDF_TIME_LOW_RANK = 2 } nsdf_tensor_time;
typedef enum nsdf_sampling { NSDF_SAMPLE_NEAR_SURFACE = 0, NSDF_SAMPLE_REJECTION = 1 } nsdf_sampling;
/* How a network's parameters are moved; blocks always take Adam. */
typedef enum nsdf_optimiser {
    NSDF_OPTIMISER_MUON, /* hidden matrices that do not change with time by Muon, everything else by Adam */
    NSDF_OPTIMISER_ADAM
} nsdf_optimiser;

typedef enum nsdf_loss {
    NSDF_LOSS_WEIGHTED_MAE = 0,     /* |d| weighed by 1 / (1 + |d| / d0) */
    NSDF_LOSS_MAE = 1,              /* thesis 4.1 */
    NSDF_LOSS_SURFACE_SENSITIVE = 2 /* thesis 4.2, 4.9 to 4.11 */
} nsdf_loss;
typedef enum nsdf_time_norm { NSDF_TIME_UNIT = 0 /* 5.11 */, NSDF_TIME_SPEED = 1 /* 5.12, 5.13 */ } nsdf_time_norm;
typedef enum nsdf_sdf_norm { NSDF_SDF_DIAGONAL = 0, NSDF_SDF_UNIT_RANGE = 1 /* [-1, 1], 5.10 */ } nsdf_sdf_norm;
typedef enum nsdf_entropy_coder {
    NSDF_CODER_NONE = 0,
    NSDF_CODER_DEFLATE = 1,
    NSDF_CODER_ZSTD = 2,
    NSDF_CODER_RANGE = 3
} nsdf_entropy_coder;

#define NSDF_NO_SHELL (-1.0)

typedef struct nsdf_encoder_options {
    size_t struct_size;          /* set by nsdf_encoder_options_init */
    uint32_t rate_num, rate_den; /* frames per second; default 25 / 1 */
    uint32_t threads;            /* 0 = one per core */
    uint64_t seed;               /* default 1 */
    /* model */
    nsdf_model_input input;
    nsdf_model_activation activation;
    uint32_t layers, width;           /* hidden layers 1..31, neurons each 1..1024 */
    nsdf_tensor_time weight_time;     /* of the first layer's weights and the hidden biases; xyz input only */
    double knot_spacing;              /* frames that were added per spline knot; default 4 */
    uint32_t rank;                    /* of low-rank tensors */
    double omega_first, omega_hidden; /* frequencies of sine layers */
    uint32_t fourier_features;        /* rows of B */
    double fourier_sigma;
    int fourier_trained; /* fit B and store it */
    int output_tanh;
    /* moving blocks, instead of the network above; sequences of which more than 5 % of the surface are sheets take the
     * network */
    uint32_t blocks;                     /* 0 = the network; at most 65536 */
    uint32_t bones;                      /* that move the blocks, 1 to 1024 */
    uint32_t block_degree;               /* of their polynomials, 0 to 3 */
    double block_overlap;                /* balls that hold a point of the surface, 1 to 20: gives their radius */
    double block_radius;                 /* that of the balls, fraction of the diagonal; 0 = from block_overlap */
    double block_knot_spacing;           /* frames of the sequence per control point of the bones' motion; down to one
                                            where these would lose it */
    double level_spacing;                /* the same of the blocks' levels, their coefficients of degree 0, which move
                                            pieces of the surface along their normals; 0 = levels do not move */
    double pose_step, coefficient_step;  /* quantiser steps, fractions of the diagonal */
    double motion_rate;                  /* 0 to 1: error, fraction of the diagonal, that one bit for each number of the
                                            blocks is worth: of their motion, levels, weights and coefficients */
    uint64_t block_steps;                /* of Adam; 0 (default) = as many as visit block_visits frames */
    uint64_t block_visits;               /* frames that all steps together visit, each as often as it is visited */
    uint32_t block_frames, block_points; /* each step: so many frames, at most 4096, and points of each, at most 65536;
                                            of shorter sequences fewer frames, but at least 8, and more points */
    /* data */
    nsdf_sampling sampling;
    uint32_t samples_per_frame; /* 0 = chosen from the number of frames */
    double d_half;              /* d_0.5 of rejection sampling, fraction of the diagonal (thesis 5.2) */
    nsdf_time_norm time_norm;
    nsdf_sdf_norm sdf_norm;
    double shell;     /* thickness, world units, of every piece of the surface that has an open edge; default 0: sheets
                         among them get 1/300 of the diagonal, others are closed; NSDF_NO_SHELL: all are closed */
    int hard_samples; /* while a network is fitted, further points where the error is large and where surface appears
                         astray, and more steps while it does; default on, off for the thesis's preset */
    /* fitting */
    nsdf_optimiser optimiser; /* default Muon, Adam for the thesis's preset */
    nsdf_loss loss;
    double loss_d0;         /* of the weighted loss of a network, fraction of the diagonal; 0 (default) = the mean
                               error near the surface, 0.0025 to 0.02, of sequences of thin sheets 0.02 */
    double loss_sign;       /* of the weighted loss: weight of a wrong sign at the surface, 1 up;
                               0 (default) = 1, of sequences of sheets thinner than 0.02 of
                               the diagonal 4 */
    double loss_sign_error; /* mean error near the surface, as nsdf_progress.error, from which on that weight
                               holds; 0 (default) = always, of sequences of sheets half their thickness */
    double loss_delta, loss_slope; /* delta (fraction of the diagonal) and s of the surface-sensitive loss */
    uint64_t steps;                /* of Adam */
    double time_budget;            /* seconds that the run should take, instead of a number of steps; the file then
                                      depends on the machine, and there is no checkpoint; 0 = none */
    uint32_t batch_frames, batch_points; /* each step: so many frames, so many points of each */
    double learning_rate;
    double parameter_rate; /* 0 to 1: error, fraction of the diagonal, that one bit for each parameter of a network is
                              worth; without quantise_aware there is none */
    /* coding */
    double weight_bits; /* 4..16: levels per tensor are about 2^bits; 32 = float32 */
    int quantise_aware; /* rounding simulated in the last part of fitting; 0 = the thesis's min-max
                           quantiser, applied afterwards (4.13, 4.14) */
    nsdf_entropy_coder entropy;
    /* output */
    uint32_t resolution;   /* stored default resolution; default 0: 192, or more as sheets need */
    double smallest_piece; /* stored: decoders leave out pieces of the surface whose box has a shorter diagonal;
                              fraction of the diagonal, up to 1; 0 = none; default -1: half the smallest piece of the
                              input, at most 1/8, or more where verification finds larger pieces astray, or less
                              where it finds that parts of the surface would be left out */
    int verify;            /* decode the file, measure and store its error; default on */
    /* Rate control: at most one of them, with the aware quantiser and NSDF_CODER_RANGE only.  Blocks, bones, quantiser
     * steps and motion_rate (of a network: width and weight_bits) then are where the search begins.  A target takes up
     * to about 1.5 times the time, where the error is hard to reach more. */
    uint64_t target_size;  /* bytes: the file is never larger, and at most 3 % smaller; 0 = none, else 500 up */
    double target_bitrate; /* the same, in 1000 bits per second of the duration (of a single frame: of 1 / rate
                              seconds); 0 = none */
    double target_error;   /* nsdf_mean_error of the file as verified, which must be on, fraction of the diagonal: met
                              with few bytes, or nsdf_encoder_stats.target_met is 0; 0 = none, else 1e-6 to 0.1 */
} nsdf_encoder_options;

/* Sets every field for a preset. */
NSDF_API void nsdf_encoder_options_init(nsdf_encoder_options *options, nsdf_preset preset);

/* A hash of all options that a file depends on: equal for options that, with the same frames, give the same file. */
NSDF_API uint64_t nsdf_encoder_options_hash(const nsdf_encoder_options *options);

typedef struct nsdf_encoder_error {
    nsdf_status status;
    char message[240]; /* never empty after a failure */
} nsdf_encoder_error;

typedef struct nsdf_encoder nsdf_encoder;

/* Triangles of one frame; borrowed during the call only. */
typedef struct nsdf_input_mesh {
    const double *positions; /* [vertex_count][3], world units */
    const uint32_t *indices; /* [triangle_count][3], counter-clockwise from outside */
    uint32_t vertex_count, triangle_count;
} nsdf_input_mesh;

NSDF_API NSDF_MUST_USE nsdf_status nsdf_encoder_create(nsdf_encoder **encoder, const nsdf_encoder_options *options,
                                                       nsdf_encoder_error *error);
NSDF_API void nsdf_encoder_close(nsdf_encoder **encoder);

/* What is wrong with a mesh, and what nsdf_encoder_run would do about it with these options, if it were a sequence of
 * its own (the diagonal is its own).  Fails as nsdf_encoder_add_frame does, and where the mesh has no inside. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_encoder_check_mesh(const nsdf_encoder_options *options,
                                                           const nsdf_input_mesh *mesh, nsdf_mesh_report *report,
                                                           nsdf_encoder_error *error);

/* A mesh as it is fitted: the boundary of bodies, as far as repair can make it that. */
typedef struct nsdf_repaired_mesh {
    double *positions; /* [vertex_count][3], world units: the vertices that were there, and then others */
    uint32_t *indices; /* [triangle_count][3] */
    uint32_t vertex_count, triangle_count;
} nsdf_repaired_mesh;

/* Repairs a mesh as nsdf_encoder_run does with the option `shell`, in a sequence whose box has this diagonal (world
 * units, above 0).  *repaired is to be freed with nsdf_repaired_mesh_free.  Fails as nsdf_encoder_add_frame does, and
 * where the mesh has no area. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_encoder_repair_mesh(const nsdf_input_mesh *mesh, double shell, double diagonal,
                                                            nsdf_repaired_mesh *repaired, nsdf_encoder_error *error);
NSDF_API void nsdf_repaired_mesh_free(nsdf_repaired_mesh *repaired);

/* Adds the mesh of a nominal frame.  Frame numbers ascend; the first added becomes time 0.  Frames may be left out:
 * the surface is interpolated there. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_encoder_add_frame(nsdf_encoder *encoder, uint32_t frame,
                                                          const nsdf_input_mesh *mesh, nsdf_encoder_error *error);

/* A stretch of a longer sequence, to be fitted apart and joined afterwards (nsdf/mux.h). */
typedef struct nsdf_sequence_part {
    /* So many frames at the beginning and at the end of those that were added belong to the stretches before and after
     * this one: they are fitted, but the file's time does not reach them. */
    uint32_t lead, trail;
    double box_min[3], box_max[3]; /* of the whole sequence, world units: that of every part */
} nsdf_sequence_part;

/* To be called once all frames are added, before nsdf_encoder_resume and nsdf_encoder_run; time 0 is then `lead` frames
 * behind the first added.  NSDF_INVALID_ARGUMENT when the box does not hold the frames that were added, or when the
 * frame at time 0 or the last one was left out. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_encoder_set_part(nsdf_encoder *encoder, const nsdf_sequence_part *part,
                                                         nsdf_encoder_error *error);

typedef enum nsdf_stage {
    NSDF_STAGE_SAMPLE = 0,
    NSDF_STAGE_FIT = 1,
    NSDF_STAGE_BOUND = 2, /* coding, and measuring the bound that extraction may rely on */
    NSDF_STAGE_VERIFY = 3 /* may come twice; when it finds stray pieces, fitting and what follows come again, a few
                             times at most */
} nsdf_stage;

typedef struct nsdf_progress {
    nsdf_stage stage;
    double fraction; /* of the stage, 0 to 1 */
    double elapsed;  /* seconds since nsdf_encoder_run began */
    double error;    /* fitting: running mean |f - d| near the surface, fraction of the diagonal */
    double samples_per_second;
    double eta; /* seconds left of the stage; < 0 unknown */
} nsdf_progress;

/* What a progress callback answers. */
enum {
    NSDF_CONTINUE = 0,
    NSDF_FINISH = 1, /* stop fitting, but code and verify: the file is valid, and less accurate */
    NSDF_ABORT = 2   /* stop with NSDF_CANCELLED */
};
typedef int (*nsdf_progress_fn)(void *user, const nsdf_progress *progress);

/* Samples, fits, quantises, codes and verifies.  NSDF_LIMIT before fitting when target_size is less than the sequence
 * takes at the least.  progress may be NULL; it is called on the calling thread. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_encoder_run(nsdf_encoder *encoder, nsdf_progress_fn progress, void *user,
                                                    nsdf_encoder_error *error);

/* ---- Checkpoints: going on after a crash ------------------------------------------------------------------ */

/* Gets a checkpoint, borrowed during the call.  Keeping it is the callback's business; fitting goes on in any case. */
typedef void (*nsdf_checkpoint_fn)(void *user, const void *data, size_t size);

/* Has nsdf_encoder_run hand out checkpoints on its thread: whenever `seconds` (0 or more) have passed while it fits,
 * after the last of the steps that the options ask for, and when progress ends fitting or aborts it before that.  Each
 * replaces the one before; it takes up to 16 bytes for each parameter, and for a network up to 132 KB a frame more.
 * What follows the last step is not saved but done again.  Fits to a size, a bitrate or an error have none: then this
 * fails.  Without a call, or with save NULL, there are none. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_encoder_set_checkpoint(nsdf_encoder *encoder, double seconds,
                                                               nsdf_checkpoint_fn save, void *user,
                                                               nsdf_encoder_error *error);

/* Has nsdf_encoder_run go on from a checkpoint, which is copied; the file is then, byte for byte, that of a run without
 * a break.  To be called once all frames are added.  *steps (may be NULL) gets the number of steps that were done.
 * Options may differ from those of the run that made it where they have no part in fitting: rate, threads, entropy,
 * resolution, smallest_piece, verify.  Otherwise nothing is changed, and the message names what differs:
 * NSDF_NOT_NSDF no checkpoint; NSDF_UNSUPPORTED_VERSION made by another version, or for a network on a processor with
 * other kernels; NSDF_TRUNCATED, NSDF_CORRUPT, NSDF_CHECKSUM damaged; NSDF_INVALID_ARGUMENT made with another option or
 * of other frames.  nsdf_encoder_run fails with NSDF_CORRUPT, before the first step, if what it samples and starts from
 * is not the same. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_encoder_resume(nsdf_encoder *encoder, const void *data, size_t size,
                                                       uint64_t *steps, nsdf_encoder_error *error);

/* ---- Afterwards ------------------------------------------------------------------------------------------ */

/* Codes what nsdf_encoder_run fitted once more, with another entropy coder and, of a network, other weight_bits; the
 * bound and the error are measured anew where the parameters come out different.  nsdf_encoder_write and
 * nsdf_encoder_get_stats then give this coding.  After a failure with NSDF_INVALID_ARGUMENT the coding before it stays;
 * after any other there is none, and the encoder can only be closed.  progress: see nsdf_encoder_run; the stages are
 * NSDF_STAGE_BOUND and NSDF_STAGE_VERIFY. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_encoder_recode(nsdf_encoder *encoder, double weight_bits,
                                                       nsdf_entropy_coder entropy, nsdf_progress_fn progress,
                                                       void *user, nsdf_encoder_error *error);

/* The file's bytes, after nsdf_encoder_run or nsdf_encoder_recode.  `write` returns 0, or nonzero to stop with NSDF_IO.
 */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_encoder_write(nsdf_encoder *encoder,
                                                      int (*write)(void *user, const void *data, size_t size),
                                                      void *user, nsdf_encoder_error *error);

/* Coded bytes of a block model by what they say. */
typedef struct nsdf_block_bytes {
    uint64_t places;     /* centres, radii and lives of the blocks */
    uint64_t influences; /* which bones move each, with what weight */
    uint64_t motion;     /* of the bones over time */
    uint64_t levels;     /* of the blocks over time, where they move */
    uint64_t shapes;     /* polynomials */
} nsdf_block_bytes;

/* What a round of rate control did. */
typedef enum nsdf_rate_kind {
    NSDF_RATE_PROBE = 0,    /* a short fit, to learn what sizes or errors this sequence has */
    NSDF_RATE_FIT = 1,      /* a whole fit */
    NSDF_RATE_TUNE = 2,     /* a few more steps with other quantisers */
    NSDF_RATE_QUANTISE = 3, /* other quantisers only */
    NSDF_RATE_VERIFY = 4    /* the whole file was decoded and measured */
} nsdf_rate_kind;

typedef struct nsdf_rate_round {
    nsdf_rate_kind kind;
    uint32_t blocks, bones, width;                   /* width is 0 for blocks, blocks and bones for a network */
    uint64_t steps;                                  /* of Adam in this round */
    double pose_step, coefficient_step, motion_rate; /* of blocks */
    double weight_bits;                              /* of a network */
    uint64_t bytes;                                  /* of the whole file */
    double error; /* nsdf_mean_error, but of some frames only unless the kind is NSDF_RATE_VERIFY; 0 = not measured */
} nsdf_rate_round;

enum { NSDF_MOST_RATE_ROUNDS = 40 };

typedef struct nsdf_encoder_stats {
    uint32_t frames;         /* added */
    uint32_t nominal_frames; /* in the file, those left out included */
    uint64_t triangles;      /* in all frames */
    nsdf_mesh_report input;  /* of all frames together */
    double diagonal;         /* world units */
    uint32_t blocks, bones;  /* 0 when the model is the network */
    int unfollowed;          /* blocks could not follow the surface, so that the model is the network */
    int came_apart;          /* blocks left pieces astray, and a network, fitted then, is nearer to the input */
    nsdf_block_bytes block_bytes;
    uint64_t parameters;
    uint64_t file_size;      /* bytes */
    uint64_t steps, samples; /* Adam steps made; points seen */
    double fit_error;        /* as nsdf_progress.error at the end */
    double bound;            /* extraction bound stored in the file */
    uint32_t stray_pieces;   /* connected pieces of the decoded frames of which a twentieth lies more than 1e-2 of the
                                diagonal from the input, over all frames; 0 in a good file */
    double seconds_sample, seconds_fit, seconds_code, seconds_verify;
    nsdf_quality quality;
    int target_met;       /* of target_size or target_error; 1 without any */
    uint32_t round_count; /* of rate control; they are there as soon as a round ends, also for progress */
    nsdf_rate_round rounds[NSDF_MOST_RATE_ROUNDS];
} nsdf_encoder_stats;

/* What target_error speaks of: the larger of the two mean distances, input to decoded and back. */
static inline double nsdf_mean_error(const nsdf_quality *quality) {
    return quality->mean_to_decoded > quality->mean_to_input ? quality->mean_to_decoded : quality->mean_to_input;
}

/* May also be called by a progress callback. */
NSDF_API NSDF_MUST_USE nsdf_status nsdf_encoder_get_stats(const nsdf_encoder *encoder, nsdf_encoder_stats *stats);

#ifdef __cplusplus
}
#endif
#endif

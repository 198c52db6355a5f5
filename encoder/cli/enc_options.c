#include "enc_options.h"

#include "cli_option.h"
#include "cli_util.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

static const char help_text[] =
    "Usage: nsdf-enc [options] INPUT... -o OUT.nsdf\n"
    "\n"
    "Fits a small neural network to the signed distance function of a mesh sequence and writes it as an .nsdf file.\n"
    "INPUT is a folder of OBJ, PLY, STL or glTF frames, a pattern (walk_%04d.obj), a glob (\"walk_*.ply\"), a list "
    "file\n"
    "(.txt, .lst), single files, or an animated glTF file.  Connectivity may change from frame to frame.\n"
    "\n"
    "  -o, --output FILE        file to write\n"
    "      --fps F              frames per second: 25, 29.97 or 60000/1001 (default 25, or as an animation's\n"
    "                           keys need)\n"
    "      --numbers KIND       times (default): frames are as far apart as the numbers of their files, and those that "
    "are\n"
    "                           missing are interpolated; ignore: files follow each other\n"
    "      --frame-step N       fit every Nth frame and the last one only; the others are interpolated (default 1)\n"
    "      --frames LIST        fit these frames only, numbered in time from 0: 7 or 0-9,20 or 1-173/2 (every second)\n"
    "      --preset NAME        fast, medium (default; also called temporal), slow, best or thesis\n"
    "      --size BYTES         size of the file: never larger, at most 3 % smaller\n"
    "      --bitrate KBPS       the same in kilobits (1000 bits) per second of the sequence\n"
    "      --max-error E        mean error that the file may have, fraction of the diagonal: with as few bytes as it\n"
    "                           takes; one of these three at most, and the exit code is 3 when it could not be met\n"
    "      --time SECONDS       that encoding should take, instead of the preset's number of steps\n"
    "      --segment SECONDS    fit stretches of this length apart and join them; 0 = all at once (default: long\n"
    "                           sequences in stretches of up to 240 frames)\n"
    "      --jobs N             stretches at a time, each in a process of its own (default 1)\n"
    "      --shell T            thickness of open sheets, in the input's units: every piece with an open edge gets "
    "it;\n"
    "                           none: all are closed (default: auto, sheets among them get 1/300 of the diagonal)\n"
    "      --check[=json]       say what is wrong with the input and what would be done about it, and encode nothing;\n"
    "                           exit code 1 when a frame cannot be encoded\n"
    "      --resolution N       resolution at which players extract by default, and at which the result is verified:\n"
    "                           cells along the longest side, 2 to 4096 (default 192, or more as sheets need)\n"
    "      --smallest-piece F   players leave out pieces of the surface smaller than this fraction of the diagonal;\n"
    "                           0 keeps all (default: half the smallest piece of the input, at most 0.125)\n"
    "      --report FILE.json   write options, times and measured errors\n"
    "      --checkpoint FILE    keep the state of fitting there until the output is written: after a crash, the same\n"
    "                           command goes on from it\n"
    "      --checkpoint-every S seconds from one to the next (default 60)\n"
    "      --no-verify          do not decode the file and measure its error\n"
    "      --threads N          0 = one per core (default); the result does not depend on it\n"
    "      --seed N             of all random numbers (default 1)\n"
    "  -q, --quiet              errors only\n"
    "  -v, --verbose            say more\n"
    "  -h, --help               this text\n"
    "      --version            version\n"
    "\n"
    "Model (thesis 4.1, 5.3):\n"
    "      --input KIND         xyz, xyzt or fourier\n"
    "      --layers N           hidden layers, 1 to 31\n"
    "      --width N            neurons per layer, 1 to 1024\n"
    "      --activation KIND    sine, relu or tanh; --output-activation identity or tanh\n"
    "      --weights KIND       first layer's weights and hidden biases: constant, spline or low-rank in time\n"
    "      --knot-spacing F     frames per spline knot;  --rank N  rank of low-rank tensors\n"
    "      --omega F            frequency of the first sine layer;  --omega-hidden F  of the others\n"
    "      --fourier-features N rows of B;  --fourier-sigma F  their deviation;  --fourier-trained  fit and store B\n"
    "Moving blocks, the default instead of the network; its options choose that, and so do sheets and growth:\n"
    "      --blocks K           how many; 0 = the network\n"
    "      --block-overlap F    how many hold a point of the surface; or --block-radius F, fraction of the diagonal\n"
    "      --bones N            that move them;  --block-knot-spacing F  frames per control point of their motion\n"
    "      --level-spacing F    frames per control point of the blocks' levels, 0 = they do not move\n"
    "      --block-degree D     of the blocks' polynomials, 0 to 3\n"
    "      --pose-step F        quantiser step of the motion;  --coefficient-step F  of the polynomials\n"
    "      --motion-rate F      error that a bit for each number of the blocks is worth\n"
    "Data (thesis 5.1, 5.2):\n"
    "      --sampling KIND      near (surface points displaced by normal noise) or rejection;  --d-half F  d_0.5\n"
    "      --samples N          samples per frame (0 = from the number of frames)\n"
    "      --time-norm KIND     unit (5.11) or speed (5.13);  --sdf-norm KIND  diagonal or unit (5.10)\n"
    "      --hard-samples Y     on or off: for networks, more samples where the error is and where surface is astray\n"
    "Fitting (thesis 4.1, 4.2):\n"
    "      --loss KIND          weighted, mae or surface;  --loss-d0 F;  --delta F, --slope F of the surface loss\n"
    "      --loss-sign F        weight of a wrong sign at the surface (default: 1, of sheets 4)\n"
    "      --optimiser KIND     muon or adam: of networks;  --steps N;  --learning-rate F\n"
    "      --parameter-rate F   error that a bit for each parameter of the network is worth\n"
    "      --batch-frames N     frames per step;  --batch-points N  points of each\n"
    "Coding (thesis 4.3):\n"
    "      --weight-bits B      4 to 16, or 32 for float32\n"
    "      --quantiser KIND     aware (rounding takes part in fitting) or minmax (4.13, 4.14)\n"
    "      --entropy KIND       none, deflate, zstd or range (default)\n"
    "      --also B,KIND,FILE   write the same fit once more with B bits and this entropy coder; may be repeated\n"
    "\n"
    "Ctrl-C stops fitting and writes what there is; a second one gives up and leaves nothing.\n"
    "\n"
    "Example: nsdf-enc frames/ -o dance.nsdf --fps 30 --preset fast\n";

enum { MOST_BLOCK_POINTS = 65536 }; /* of a batch: what nsdf_encoder_options allows */

enum {
    OPT_FPS = 256,
    OPT_SMALLEST_PIECE,
    OPT_NUMBERS,
    OPT_FRAME_STEP,
    OPT_FRAMES,
    OPT_PRESET,
    OPT_SIZE,
    OPT_BITRATE,
    OPT_MAX_ERROR,
    OPT_TIME,
    OPT_SEGMENT,
    OPT_JOBS,
    OPT_SHELL,
    OPT_CHECK,
    OPT_RESOLUTION,
    OPT_REPORT,
    OPT_CHECKPOINT,
    OPT_CHECKPOINT_EVERY,
    OPT_NO_VERIFY,
    OPT_THREADS,
    OPT_SEED,
    OPT_VERSION,
    OPT_INPUT,
    OPT_LAYERS,
    OPT_WIDTH,
    OPT_ACTIVATION,
    OPT_OUTPUT_ACTIVATION,
    OPT_WEIGHTS,
    OPT_KNOT_SPACING,
    OPT_RANK,
    OPT_OMEGA,
    OPT_OMEGA_HIDDEN,
    OPT_FOURIER_FEATURES,
    OPT_FOURIER_SIGMA,
    OPT_FOURIER_TRAINED,
    OPT_BLOCKS,
    OPT_BLOCK_OVERLAP,
    OPT_BLOCK_RADIUS,
    OPT_BONES,
    OPT_BLOCK_KNOT_SPACING,
    OPT_LEVEL_SPACING,
    OPT_BLOCK_DEGREE,
    OPT_POSE_STEP,
    OPT_MOTION_RATE,
    OPT_COEFFICIENT_STEP,
    OPT_SAMPLING,
    OPT_D_HALF,
    OPT_SAMPLES,
    OPT_TIME_NORM,
    OPT_SDF_NORM,
    OPT_HARD_SAMPLES,
    OPT_OPTIMISER,
    OPT_LOSS,
    OPT_LOSS_D0,
    OPT_LOSS_SIGN,
    OPT_PARAMETER_RATE,
    OPT_DELTA,
    OPT_SLOPE,
    OPT_STEPS,
    OPT_LEARNING_RATE,
    OPT_BATCH_FRAMES,
    OPT_BATCH_POINTS,
    OPT_WEIGHT_BITS,
    OPT_QUANTISER,
    OPT_ENTROPY,
    OPT_ALSO
};

static const struct option long_options[] = {
    {"output", required_argument, NULL, 'o'},
    {"quiet", no_argument, NULL, 'q'},
    {"verbose", no_argument, NULL, 'v'},
    {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, OPT_VERSION},
    {"fps", required_argument, NULL, OPT_FPS},
    {"numbers", required_argument, NULL, OPT_NUMBERS},
    {"frame-step", required_argument, NULL, OPT_FRAME_STEP},
    {"frames", required_argument, NULL, OPT_FRAMES},
    {"preset", required_argument, NULL, OPT_PRESET},
    {"size", required_argument, NULL, OPT_SIZE},
    {"bitrate", required_argument, NULL, OPT_BITRATE},
    {"max-error", required_argument, NULL, OPT_MAX_ERROR},
    {"time", required_argument, NULL, OPT_TIME},
    {"segment", required_argument, NULL, OPT_SEGMENT},
    {"jobs", required_argument, NULL, OPT_JOBS},
    {"shell", required_argument, NULL, OPT_SHELL},
    {"check", optional_argument, NULL, OPT_CHECK},
    {"resolution", required_argument, NULL, OPT_RESOLUTION},
    {"smallest-piece", required_argument, NULL, OPT_SMALLEST_PIECE},
    {"report", required_argument, NULL, OPT_REPORT},
    {"checkpoint", required_argument, NULL, OPT_CHECKPOINT},
    {"checkpoint-every", required_argument, NULL, OPT_CHECKPOINT_EVERY},
    {"no-verify", no_argument, NULL, OPT_NO_VERIFY},
    {"threads", required_argument, NULL, OPT_THREADS},
    {"seed", required_argument, NULL, OPT_SEED},
    {"input", required_argument, NULL, OPT_INPUT},
    {"layers", required_argument, NULL, OPT_LAYERS},
    {"width", required_argument, NULL, OPT_WIDTH},
    {"activation", required_argument, NULL, OPT_ACTIVATION},
    {"output-activation", required_argument, NULL, OPT_OUTPUT_ACTIVATION},
    {"weights", required_argument, NULL, OPT_WEIGHTS},
    {"knot-spacing", required_argument, NULL, OPT_KNOT_SPACING},
    {"rank", required_argument, NULL, OPT_RANK},
    {"omega", required_argument, NULL, OPT_OMEGA},
    {"omega-hidden", required_argument, NULL, OPT_OMEGA_HIDDEN},
    {"fourier-features", required_argument, NULL, OPT_FOURIER_FEATURES},
    {"fourier-sigma", required_argument, NULL, OPT_FOURIER_SIGMA},
    {"fourier-trained", no_argument, NULL, OPT_FOURIER_TRAINED},
    {"blocks", required_argument, NULL, OPT_BLOCKS},
    {"block-overlap", required_argument, NULL, OPT_BLOCK_OVERLAP},
    {"block-radius", required_argument, NULL, OPT_BLOCK_RADIUS},
    {"bones", required_argument, NULL, OPT_BONES},
    {"block-knot-spacing", required_argument, NULL, OPT_BLOCK_KNOT_SPACING},
    {"level-spacing", required_argument, NULL, OPT_LEVEL_SPACING},
    {"block-degree", required_argument, NULL, OPT_BLOCK_DEGREE},
    {"pose-step", required_argument, NULL, OPT_POSE_STEP},
    {"motion-rate", required_argument, NULL, OPT_MOTION_RATE},
    {"coefficient-step", required_argument, NULL, OPT_COEFFICIENT_STEP},
    {"sampling", required_argument, NULL, OPT_SAMPLING},
    {"d-half", required_argument, NULL, OPT_D_HALF},
    {"samples", required_argument, NULL, OPT_SAMPLES},
    {"time-norm", required_argument, NULL, OPT_TIME_NORM},
    {"sdf-norm", required_argument, NULL, OPT_SDF_NORM},
    {"hard-samples", required_argument, NULL, OPT_HARD_SAMPLES},
    {"optimiser", required_argument, NULL, OPT_OPTIMISER},
    {"loss", required_argument, NULL, OPT_LOSS},
    {"loss-d0", required_argument, NULL, OPT_LOSS_D0},
    {"loss-sign", required_argument, NULL, OPT_LOSS_SIGN},
    {"parameter-rate", required_argument, NULL, OPT_PARAMETER_RATE},
    {"delta", required_argument, NULL, OPT_DELTA},
    {"slope", required_argument, NULL, OPT_SLOPE},
    {"steps", required_argument, NULL, OPT_STEPS},
    {"learning-rate", required_argument, NULL, OPT_LEARNING_RATE},
    {"batch-frames", required_argument, NULL, OPT_BATCH_FRAMES},
    {"batch-points", required_argument, NULL, OPT_BATCH_POINTS},
    {"weight-bits", required_argument, NULL, OPT_WEIGHT_BITS},
    {"quantiser", required_argument, NULL, OPT_QUANTISER},
    {"entropy", required_argument, NULL, OPT_ENTROPY},
    {"also", required_argument, NULL, OPT_ALSO},
    {NULL, 0, NULL, 0},
};

static const char *option_name(int code) {
    for (const struct option *o = long_options; o->name; o++)
        if (o->val == code)
            return o->name;
    return "?";
}

/* ---- Values --------------------------------------------------------------------------------------------- */

/* 0, or the exit code after printing what was expected. */
static int bad_value(int code, const char *text, const char *expected) {
    return nsdf_cli_usage_error("--%s: '%s' is not %s", option_name(code), text, expected);
}

static int set_u32(int code, const char *text, uint32_t *out) {
    return nsdf_cli_parse_u32(text, 0, UINT32_MAX, out) == 0 ? 0 : bad_value(code, text, "a whole number");
}

static int set_double(int code, const char *text, double *out) {
    return nsdf_cli_parse_double(text, out) == 0 ? 0 : bad_value(code, text, "a number");
}

static int set_shell(int code, const char *text, double *out) {
    if (strcmp(text, "auto") == 0)
        *out = 0.0;
    else if (strcmp(text, "none") == 0)
        *out = NSDF_NO_SHELL;
    else if (nsdf_cli_parse_double(text, out) != 0 || !(*out > 0.0))
        return bad_value(code, text, "a thickness above 0, auto or none");
    return 0;
}

static int set_check(int code, const char *text, enc_check_form *out) {
    *out = text ? ENC_CHECK_JSON : ENC_CHECK_TEXT;
    return !text || strcmp(text, "json") == 0 ? 0 : bad_value(code, text, "json");
}

/* `names` are separated by '|'; *out gets the index of `text`. */
static int set_choice(int code, const char *text, const char *names, int *out) {
    size_t length = strlen(text);
    int index = 0;
    for (const char *n = names; n; n = strchr(n, '|'), index++) {
        if (*n == '|')
            n++;
        if (strncmp(n, text, length) == 0 && (n[length] == '|' || n[length] == '\0') && length > 0) {
            *out = index;
            return 0;
        }
    }
    return nsdf_cli_usage_error("--%s: '%s' is none of %s", option_name(code), text, names);
}

/* "8,deflate,small.nsdf". */
static int add_also(enc_options *o, const char *text) {
    char bits[16], coder[16];
    int length = 0, choice = 0;
    enc_also *also = &o->also[o->also_count];
    if (sscanf(text, "%15[0-9.],%15[a-z],%n", bits, coder, &length) != 2 || length == 0 || text[length] == '\0' ||
        nsdf_cli_parse_double(bits, &also->weight_bits) != 0)
        return bad_value(OPT_ALSO, text, "BITS,CODER,FILE such as 8,deflate,small.nsdf");
    if (!(also->weight_bits >= 4 && also->weight_bits <= 16) && also->weight_bits != 32)
        return bad_value(OPT_ALSO, text, "of 4 to 16 bits, or 32");
    const int failed = set_choice(OPT_ALSO, coder, "none|deflate|zstd|range", &choice);
    also->entropy = (nsdf_entropy_coder)choice;
    also->output = text + length;
    if (!failed && ++o->also_count == ENC_MOST_ALSO)
        return nsdf_cli_usage_error("--also: at most %d times", ENC_MOST_ALSO - 1);
    return failed;
}

static int set_preset(enc_options *o, const char *text) {
    int preset = 0;
    int failed = set_choice(OPT_PRESET, text, "fast|medium|slow|thesis|best|temporal", &preset);
    if (failed)
        return failed;
    o->preset = text;
    nsdf_encoder_options_init(&o->encoder, preset == 5 ? NSDF_PRESET_MEDIUM : (nsdf_preset)preset);
    return 0;
}

/* ---- Options by group; each returns -1 if the option is not of its group ---------------------------------- */

static int set_positive(int code, const char *text, double *out) {
    return nsdf_cli_parse_double(text, out) == 0 && *out > 0.0 ? 0 : bad_value(code, text, "a number above 0");
}

/* -1 if the option is not of the group. */
static int apply_target(enc_options *o, int code, const char *text) {
    if (code != OPT_SIZE && code != OPT_BITRATE && code != OPT_MAX_ERROR)
        return -1;
    if (o->target && o->target != code)
        return nsdf_cli_usage_error("--%s and --%s cannot be given together", option_name(o->target),
                                    option_name(code));
    o->target = code;
    if (code == OPT_BITRATE)
        return set_positive(code, text, &o->encoder.target_bitrate);
    if (code == OPT_MAX_ERROR)
        return set_positive(code, text, &o->encoder.target_error);
    return nsdf_cli_parse_u64(text, &o->encoder.target_size) == 0 && o->encoder.target_size > 0
               ? 0
               : bad_value(code, text, "a whole number of bytes from 1 up");
}

static int apply_general(enc_options *o, int code, const char *text) {
    nsdf_encoder_options *e = &o->encoder;
    switch (code) {
    case 'o':
        o->output = text;
        return 0;
    case 'q':
        o->quiet = 1;
        return 0;
    case 'v':
        o->verbose++;
        return 0;
    case OPT_PRESET:
        return 0; /* read before all others */
    case OPT_FPS:
        o->rate_given = 1;
        return nsdf_cli_parse_rational(text, &e->rate_num, &e->rate_den) == 0
                   ? 0
                   : bad_value(code, text, "a rate such as 25, 29.97 or 60000/1001");
    case OPT_NUMBERS:
        return set_choice(code, text, "times|ignore", &o->ignore_numbers);
    case OPT_FRAME_STEP:
        return nsdf_cli_parse_u32(text, 1, UINT32_MAX, &o->frame_step) == 0
                   ? 0
                   : bad_value(code, text, "a whole number from 1 up");
    case OPT_FRAMES:
        o->frames = text;
        return 0;
    case OPT_TIME:
        return set_positive(code, text, &e->time_budget);
    case OPT_SEGMENT:
        return nsdf_cli_parse_double(text, &o->segment) == 0 && o->segment >= 0.0
                   ? 0
                   : bad_value(code, text, "a number of seconds from 0 up");
    case OPT_JOBS:
        return nsdf_cli_parse_u32(text, 1, 256, &o->jobs) == 0 ? 0 : bad_value(code, text, "a number from 1 to 256");
    case OPT_SHELL:
        return set_shell(code, text, &e->shell);
    case OPT_CHECK:
        return set_check(code, text, &o->check);
    case OPT_RESOLUTION:
        return set_u32(code, text, &e->resolution);
    case OPT_SMALLEST_PIECE:
        return set_double(code, text, &e->smallest_piece);
    case OPT_REPORT:
        o->report = text;
        return 0;
    case OPT_CHECKPOINT:
        o->checkpoint = text;
        return 0;
    case OPT_CHECKPOINT_EVERY:
        return nsdf_cli_parse_double(text, &o->checkpoint_every) == 0 && o->checkpoint_every >= 0.0
                   ? 0
                   : bad_value(code, text, "a number of seconds from 0 up");
    case OPT_ALSO:
        return add_also(o, text);
    case OPT_NO_VERIFY:
        e->verify = 0;
        return 0;
    case OPT_THREADS:
        return set_u32(code, text, &e->threads);
    case OPT_SEED:
        return nsdf_cli_parse_u64(text, &e->seed) == 0 ? 0 : bad_value(code, text, "a whole number");
    default:
        return -1;
    }
}

/* Options that decide about others. */
typedef struct {
    int weights, network, blocks;
    int detail; /* code of an option that says what blocks are like, or 0 */
} given;

static int apply_model(nsdf_encoder_options *e, int code, const char *text, given *g) {
    int choice = 0, failed;
    switch (code) {
    case OPT_INPUT:
        failed = set_choice(code, text, "xyz|xyzt|fourier", &choice);
        e->input = (nsdf_model_input)choice;
        return failed;
    case OPT_ACTIVATION:
        failed = set_choice(code, text, "sine|relu|tanh", &choice);
        e->activation = (nsdf_model_activation)choice;
        return failed;
    case OPT_OUTPUT_ACTIVATION:
        return set_choice(code, text, "identity|tanh", &e->output_tanh);
    case OPT_WEIGHTS:
        failed = set_choice(code, text, "constant|spline|low-rank", &choice);
        e->weight_time = (nsdf_tensor_time)choice;
        g->weights = 1;
        return failed;
    case OPT_LAYERS:
        return set_u32(code, text, &e->layers);
    case OPT_WIDTH:
        return set_u32(code, text, &e->width);
    case OPT_KNOT_SPACING:
        return set_double(code, text, &e->knot_spacing);
    case OPT_RANK:
        return set_u32(code, text, &e->rank);
    case OPT_OMEGA:
        return set_double(code, text, &e->omega_first);
    case OPT_OMEGA_HIDDEN:
        return set_double(code, text, &e->omega_hidden);
    case OPT_FOURIER_FEATURES:
        return set_u32(code, text, &e->fourier_features);
    case OPT_FOURIER_SIGMA:
        return set_double(code, text, &e->fourier_sigma);
    case OPT_FOURIER_TRAINED:
        e->fourier_trained = 1;
        return 0;
    default:
        return -1;
    }
}

static int apply_blocks(nsdf_encoder_options *e, int code, const char *text) {
    switch (code) {
    case OPT_BLOCKS:
        return set_u32(code, text, &e->blocks);
    case OPT_BLOCK_OVERLAP:
        return set_double(code, text, &e->block_overlap);
    case OPT_BLOCK_RADIUS:
        return set_double(code, text, &e->block_radius);
    case OPT_BONES:
        return set_u32(code, text, &e->bones);
    case OPT_BLOCK_KNOT_SPACING:
        return set_double(code, text, &e->block_knot_spacing);
    case OPT_LEVEL_SPACING:
        return set_double(code, text, &e->level_spacing);
    case OPT_BLOCK_DEGREE:
        return set_u32(code, text, &e->block_degree);
    case OPT_POSE_STEP:
        return set_double(code, text, &e->pose_step);
    case OPT_MOTION_RATE:
        return set_double(code, text, &e->motion_rate);
    case OPT_COEFFICIENT_STEP:
        return set_double(code, text, &e->coefficient_step);
    default:
        return -1;
    }
}

static int apply_data(nsdf_encoder_options *e, int code, const char *text) {
    int choice = 0, failed;
    switch (code) {
    case OPT_SAMPLING:
        failed = set_choice(code, text, "near|rejection", &choice);
        e->sampling = (nsdf_sampling)choice;
        return failed;
    case OPT_D_HALF:
        return set_double(code, text, &e->d_half);
    case OPT_SAMPLES:
        return set_u32(code, text, &e->samples_per_frame);
    case OPT_TIME_NORM:
        failed = set_choice(code, text, "unit|speed", &choice);
        e->time_norm = (nsdf_time_norm)choice;
        return failed;
    case OPT_SDF_NORM:
        failed = set_choice(code, text, "diagonal|unit", &choice);
        e->sdf_norm = (nsdf_sdf_norm)choice;
        return failed;
    case OPT_HARD_SAMPLES:
        return set_choice(code, text, "off|on", &e->hard_samples);
    default:
        return -1;
    }
}

static int apply_fitting(nsdf_encoder_options *e, int code, const char *text) {
    int choice = 0, failed;
    switch (code) {
    case OPT_OPTIMISER:
        failed = set_choice(code, text, "muon|adam", &choice);
        e->optimiser = (nsdf_optimiser)choice;
        return failed;
    case OPT_LOSS:
        failed = set_choice(code, text, "weighted|mae|surface", &choice);
        e->loss = (nsdf_loss)choice;
        return failed;
    case OPT_LOSS_D0:
        return set_double(code, text, &e->loss_d0);
    case OPT_LOSS_SIGN:
        return set_double(code, text, &e->loss_sign);
    case OPT_PARAMETER_RATE:
        return set_double(code, text, &e->parameter_rate);
    case OPT_DELTA:
        return set_double(code, text, &e->loss_delta);
    case OPT_SLOPE:
        return set_double(code, text, &e->loss_slope);
    case OPT_STEPS:
        if (nsdf_cli_parse_u64(text, &e->steps) != 0)
            return bad_value(code, text, "a whole number");
        e->block_steps = e->steps;
        return 0;
    case OPT_LEARNING_RATE:
        return set_double(code, text, &e->learning_rate);
    case OPT_BATCH_FRAMES:
        failed = set_u32(code, text, &e->batch_frames);
        e->block_frames = e->batch_frames;
        return failed;
    case OPT_BATCH_POINTS:
        failed = set_u32(code, text, &e->batch_points);
        e->block_points = e->batch_points < MOST_BLOCK_POINTS ? e->batch_points : MOST_BLOCK_POINTS;
        return failed;
    case OPT_WEIGHT_BITS:
        return set_double(code, text, &e->weight_bits);
    case OPT_QUANTISER: {
        failed = set_choice(code, text, "minmax|aware", &choice);
        e->quantise_aware = choice;
        return failed;
    }
    case OPT_ENTROPY:
        failed = set_choice(code, text, "none|deflate|zstd|range", &choice);
        e->entropy = (nsdf_entropy_coder)choice;
        return failed;
    default:
        return -1;
    }
}

static int apply(enc_options *o, int code, const char *text, given *g) {
    int general = apply_target(o, code, text);
    if (general < 0)
        general = apply_general(o, code, text);
    int result = general;
    if (result < 0)
        result = apply_model(&o->encoder, code, text, g);
    g->network |= result >= 0 && general < 0;
    g->network |= code == OPT_WEIGHT_BITS || code == OPT_QUANTISER;
    g->blocks |= code == OPT_BLOCKS;
    if (result < 0) {
        result = apply_blocks(&o->encoder, code, text);
        g->detail = result >= 0 && code != OPT_BLOCKS ? code : g->detail;
    }
    if (result < 0)
        result = apply_data(&o->encoder, code, text);
    if (result < 0)
        result = apply_fitting(&o->encoder, code, text);
    return result;
}

/* ---- The whole line ------------------------------------------------------------------------------------- */

/* One pass over the arguments; the first only looks for the preset, whose values the other options then change. */
static int pass(enc_options *o, int argc, char **argv, int preset_only, given *g) {
    optind = 1;
    opterr = 0;
    for (int code; (code = getopt_long(argc, argv, ":o:qvh", long_options, NULL)) != -1;) {
        int failed = 0;
        if (code == ':' || code == '?')
            return nsdf_cli_refuse_option(code, argc, argv, long_options);
        if (code == 'h') {
            fputs(help_text, stdout);
            return NSDF_CLI_SUCCESS;
        }
        if (code == OPT_VERSION) {
            printf("nsdf-enc %s\n", nsdf_version_string());
            return NSDF_CLI_SUCCESS;
        }
        if (preset_only)
            failed = code == OPT_PRESET ? set_preset(o, optarg) : 0;
        else
            failed = apply(o, code, optarg, g);
        if (failed)
            return failed;
    }
    return -1;
}

static int ends_in_mesh(const char *name) {
    static const char *const kinds[] = {".obj", ".ply", ".stl", ".glb", ".gltf"};
    const size_t length = strlen(name);
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (length >= strlen(kinds[i]) && strcasecmp(name + length - strlen(kinds[i]), kinds[i]) == 0)
            return 1;
    return 0;
}

/* "-o frames/" followed by a wildcard makes the first frame the output; it must not be written over. */
static int check_name(const char *name) {
    if (!name || !*name)
        return nsdf_cli_usage_error("no output: name it with -o OUT.nsdf");
    if (ends_in_mesh(name))
        return nsdf_cli_usage_error("the output '%s' ends in %s: name an .nsdf file", name, strrchr(name, '.'));
    return -1;
}

static int check_also(const enc_options *options, uint32_t which) {
    const char *name = options->also[which].output;
    int same = strcmp(name, options->output) == 0 || (options->report && strcmp(name, options->report) == 0);
    for (uint32_t i = 0; i < which; i++)
        same |= strcmp(name, options->also[i].output) == 0;
    if (same)
        return nsdf_cli_usage_error("--also names '%s', which another option names too", name);
    return check_name(name);
}

/* The checkpoint is removed at the end: it must be nothing else. */
static int check_checkpoint(const enc_options *options) {
    const char *name = options->checkpoint;
    if (!name)
        return options->checkpoint_every < 0.0 ? -1 : nsdf_cli_usage_error("--checkpoint-every without --checkpoint");
    if (options->target || options->encoder.time_budget > 0.0)
        return nsdf_cli_usage_error("--checkpoint and --%s cannot be given together: its fits are not saved",
                                    option_name(options->target ? options->target : OPT_TIME));
    int same = strcmp(name, options->output) == 0 || (options->report && strcmp(name, options->report) == 0);
    for (uint32_t i = 0; i < options->also_count; i++)
        same |= strcmp(name, options->also[i].output) == 0;
    if (same)
        return nsdf_cli_usage_error("--checkpoint names '%s', which another option names too", name);
    if (!*name || strcmp(name, "-") == 0 || ends_in_mesh(name))
        return nsdf_cli_usage_error("--checkpoint: '%s' is not a name for a checkpoint", name);
    return -1;
}

static int check_outputs(const enc_options *options) {
    if (options->check && !options->output)
        return -1;
    int done = options->check ? -1 : check_name(options->output);
    if (done < 0 && options->report && strcmp(options->report, options->output) == 0)
        done = nsdf_cli_usage_error("-o and --report name the same file");
    for (uint32_t i = 0; done < 0 && i < options->also_count; i++)
        done = check_also(options, i);
    if (done < 0)
        done = check_checkpoint(options);
    return done;
}

static int check_together(const enc_options *options) {
    if (options->frames && options->frame_step)
        return nsdf_cli_usage_error("--frames and --frame-step cannot be given together: --frames 0-98/2 has a step");
    if (options->target && options->encoder.time_budget > 0.0)
        return nsdf_cli_usage_error("--%s and --time cannot be given together: a faster preset searches faster",
                                    option_name(options->target));
    return -1;
}

int enc_options_parse(enc_options *options, int argc, char **argv) {
    given g = {0, 0, 0, 0};
    memset(options, 0, sizeof *options);
    options->preset = "medium";
    options->checkpoint_every = options->segment = -1.0;
    options->jobs = 1;
    nsdf_encoder_options_init(&options->encoder, NSDF_PRESET_MEDIUM);
    int done = pass(options, argc, argv, 1, &g);
    if (done < 0)
        done = pass(options, argc, argv, 0, &g);
    if (done >= 0)
        return done;
    options->inputs = (const char *const *)(argv + optind);
    options->input_count = (size_t)(argc - optind);
    if (g.network && !g.blocks)
        options->encoder.blocks = 0;
    if (g.detail && options->encoder.blocks == 0)
        return nsdf_cli_usage_error("--%s goes with moving blocks, not with a network", option_name(g.detail));
    if (options->encoder.input != NSDF_MODEL_XYZ && !g.weights)
        options->encoder.weight_time = NSDF_TIME_CONSTANT; /* time is an input already */
    if (options->input_count == 0)
        return nsdf_cli_usage_error("no input: name a folder, a pattern or OBJ, PLY, STL or glTF files");
    done = check_together(options);
    return done < 0 ? check_outputs(options) : done;
}

/* What an .nsdf file describes, as plain structs: constants, limits and the shape of a model.  The normative text is
 * spec/nsdf-bitstream.md; section numbers below refer to it. */
#ifndef NSDF_FORMAT_DESC_H
#define NSDF_FORMAT_DESC_H

#include <stddef.h>
#include <stdint.h>

enum { NSDF_FORMAT_MAJOR = 0, NSDF_FORMAT_MINOR = 6 };

enum {
    NSDF_PREAMBLE_SIZE = 16,     /* signature, version, CRC */
    NSDF_CHUNK_HEADER_SIZE = 16, /* type, flags, length */
    NSDF_CHUNK_OVERHEAD = 20,    /* header and the CRC behind the payload */
    NSDF_HEADER_PAYLOAD_SIZE = 128,
    NSDF_INDEX_ENTRY_SIZE = 48,
    NSDF_MAX_SEGMENTS = 1 << 20,
    NSDF_MAX_PARTS = 16,
    NSDF_MAX_LAYERS = 32,
    NSDF_MAX_WIDTH = 1024,
    NSDF_MAX_FOURIER = 512, /* rows of B; the first layer then has twice as many inputs */
    NSDF_MIN_KNOTS = 4,
    NSDF_MAX_KNOTS = 65535,
    NSDF_MAX_RANK = 256,
    NSDF_MAX_BLOCKS = 1 << 16,
    NSDF_MAX_BONES = 1024,
    NSDF_MAX_INFLUENCES = 8, /* bones that move one block */
    NSDF_MAX_DEGREE = 3,
    NSDF_MAX_QUANTISED = 1 << 24, /* |q| stays below this, so that q is exact in a float */
    NSDF_MAX_RESOLUTION = 4096
};

/* Segments may not hold more parameters than this, whatever the file says. */
#define NSDF_MAX_PARAMETERS ((uint64_t)1 << 28)

/* Chunk types: four ASCII letters, first letter in the lowest byte of the little-endian word. */
#define NSDF_CHUNK(a, b, c, d) ((uint32_t)(a) | (uint32_t)(b) << 8 | (uint32_t)(c) << 16 | (uint32_t)(d) << 24)
#define NSDF_CHUNK_HEAD NSDF_CHUNK('H', 'E', 'A', 'D')
#define NSDF_CHUNK_INDX NSDF_CHUNK('I', 'N', 'D', 'X')
#define NSDF_CHUNK_SEGM NSDF_CHUNK('S', 'E', 'G', 'M')
#define NSDF_CHUNK_META NSDF_CHUNK('M', 'E', 'T', 'A')
#define NSDF_CHUNK_QUAL NSDF_CHUNK('Q', 'U', 'A', 'L')
#define NSDF_CHUNK_ENDF NSDF_CHUNK('E', 'N', 'D', 'F')

enum { NSDF_CHUNK_CRITICAL = 1 }; /* bit 0 of the flags; the others are reserved: writers zero, readers ignore */

typedef struct nsdf_file_header {
    uint32_t rate_num, rate_den; /* nominal frames per second */
    uint32_t frame_count;        /* >= 1 */
    uint32_t segment_count;      /* >= 1 */
    double box_min[3], box_max[3];
    double centre[3], scale; /* x_norm = (x - centre) / scale; scale = diagonal of the box (thesis 5.8, 5.9) */
    float domain_min[3], domain_max[3]; /* normalised */
    uint32_t default_resolution;
    float extraction_bound;
} nsdf_file_header;

typedef struct nsdf_index_entry {
    uint32_t first_frame, last_frame; /* nominal frames at the segment's two ends; consecutive segments share one */
    /* Frames by which its model reaches beyond them; negative: it ends before them, and stands still from there. */
    int32_t lead, trail;
    uint32_t fade;         /* half width in frames of the cross-fade from the segment before, around first_frame */
    float smallest_piece;  /* normalised; pieces of a mesh with a smaller diagonal are left out */
    uint64_t offset, size; /* of the whole SEGM chunk, with header and CRC */
    uint64_t parameter_hash;
} nsdf_index_entry;

typedef struct nsdf_quality_record { /* QUAL chunk; fractions of the diagonal; [0] to decoded, [1] to input */
    double mean[2], rms[2], max[2];
    uint32_t resolution, frames;
} nsdf_quality_record;

/* ---- Model ---------------------------------------------------------------------------------------------- */

enum { NSDF_PART_NETWORK = 1, NSDF_PART_BLOCKS = 2 };

typedef enum nsdf_input_kind { NSDF_INPUT_XYZ = 0, NSDF_INPUT_XYZT = 1, NSDF_INPUT_FOURIER = 2 } nsdf_input_kind;
typedef enum nsdf_activation {
    NSDF_ACT_IDENTITY = 0,
    NSDF_ACT_RELU = 1,
    NSDF_ACT_SINE = 2, /* sin(omega * (W x + b)) */
    NSDF_ACT_TANH = 3
} nsdf_activation;
typedef enum nsdf_tensor_kind {
    NSDF_TENSOR_CONSTANT = 0,
    NSDF_TENSOR_SPLINE = 1,
    NSDF_TENSOR_LOW_RANK = 2
} nsdf_tensor_kind;
typedef enum nsdf_entropy_kind {
    NSDF_ENTROPY_NONE = 0,
    NSDF_ENTROPY_DEFLATE = 1,
    NSDF_ENTROPY_ZSTD = 2,
    NSDF_ENTROPY_RANGE = 3
} nsdf_entropy_kind;
enum { NSDF_ENTROPY_COUNT = 4 };
typedef enum nsdf_quantiser_kind { NSDF_QUANT_RAW = 0 /* float32 */, NSDF_QUANT_UNIFORM = 1 } nsdf_quantiser_kind;
enum {
    NSDF_PREDICT_NONE = 0,
    NSDF_PREDICT_PLANE = 1,  /* from the same element of the plane before */
    NSDF_PREDICT_LINEAR = 2, /* from the line through the two planes before */
    NSDF_PREDICT_ROW = 3     /* from the element above, in the row before of the same plane */
};
enum { NSDF_FOURIER_SEED = 0, NSDF_FOURIER_STORED = 1 };

/* `planes` matrices [rows][cols] of one kind, quantised alike: w = offset + step * q. */
typedef struct nsdf_array_desc {
    uint32_t planes, rows, cols;
    uint8_t quantiser; /* nsdf_quantiser_kind */
    uint8_t predict;   /* NSDF_PREDICT_... */
    uint8_t bits;      /* 0..24: of (residual - residual_min), for the back ends that pack */
    int32_t residual_min;
    float step, offset;
} nsdf_array_desc;

/* A weight matrix [rows][cols] or a bias vector [rows][1].
 *   constant: arrays[0] = [1][rows][cols]
 *   spline:   arrays[0] = [knots][rows][cols], control points of a uniform cubic B-spline over the segment
 *   low-rank: arrays[0] = [1][rows][cols] M_0, arrays[1] = [rank][rows][cols] M_r, arrays[2] = [rank][knots][1], the
 *             control points of v_r(t): M(t) = M_0 + sum_r v_r(t) M_r (ResFields) */
typedef struct nsdf_tensor_desc {
    uint8_t kind; /* nsdf_tensor_kind */
    uint8_t array_count;
    uint32_t rows, cols, knots, rank;
    nsdf_array_desc arrays[3];
} nsdf_tensor_desc;

typedef struct nsdf_layer_desc {
    uint32_t width;     /* outputs */
    uint8_t activation; /* nsdf_activation */
    float omega;        /* sine only */
} nsdf_layer_desc;

/* The parameters of a part: tensors in the order of the file, coded together. */
enum { NSDF_MAX_TENSORS = 2 * NSDF_MAX_LAYERS + 1 };
typedef struct nsdf_tensor_list {
    uint8_t entropy; /* nsdf_entropy_kind of the coded parameters */
    uint32_t count;
    nsdf_tensor_desc tensors[NSDF_MAX_TENSORS];
} nsdf_tensor_list;

/* Tensors: B if stored, then W_0, b_0, W_1, b_1, ... */
typedef struct nsdf_network_desc {
    uint8_t input;          /* nsdf_input_kind */
    uint8_t fourier_source; /* NSDF_FOURIER_... */
    uint32_t fourier_count; /* rows of B [count][4]; features are cos(2 pi B v), then sin(2 pi B v) (thesis 5.14) */
    uint64_t fourier_seed;
    float fourier_sigma;
    float time_scale; /* network time = time_scale * u, u in [0, 1] over the segment (thesis 5.11, 5.13) */
    float value_scale, value_offset; /* signed distance / scale = value_scale * output + value_offset (thesis 5.10) */
    uint32_t layer_count;            /* >= 1; the last has width 1 */
    nsdf_layer_desc layers[NSDF_MAX_LAYERS];
    nsdf_tensor_list list;
} nsdf_network_desc;

/* Tensors of a block part (spec, section "Block part"), K blocks and B bones; coefficients of degree d follow. */
enum {
    NSDF_BLOCK_CENTRES,     /* [K][3]: at rest */
    NSDF_BLOCK_RADII,       /* [K][1]: > 0 */
    NSDF_BLOCK_LIVES,       /* [K][2]: from and to, u in [0, 1] */
    NSDF_BLOCK_BONES,       /* [K][influences]: numbers of bones */
    NSDF_BLOCK_WEIGHTS,     /* [K][influences] */
    NSDF_BLOCK_ANCHORS,     /* [B][4]: a bone's centre at rest and its extent > 0 */
    NSDF_BLOCK_POSES,       /* [B][12], in time: rows of [extent * M | position of the centre] */
    NSDF_BLOCK_COEFFICIENTS /* [K][(d + 1)(d + 2) / 2] for each d from 0 to the degree, in time */
};

typedef struct nsdf_blocks_desc {
    uint32_t block_count, bone_count, influences, degree;
    float fade; /* u over which a block comes and goes */
    nsdf_tensor_list list;
} nsdf_blocks_desc;

/* Monomials of exactly this degree in three variables. */
static inline uint32_t nsdf_degree_terms(uint32_t degree) {
    return (degree + 1) * (degree + 2) / 2;
}

static inline uint64_t nsdf_array_size(const nsdf_array_desc *a) {
    return (uint64_t)a->planes * a->rows * a->cols;
}

/* Index of W_i in tensors[]; its bias follows it. */
static inline uint32_t nsdf_weight_index(const nsdf_network_desc *d, uint32_t layer) {
    return 2 * layer + (d->input == NSDF_INPUT_FOURIER && d->fourier_source == NSDF_FOURIER_STORED ? 1u : 0u);
}

/* Inputs of layer 0. */
static inline uint32_t nsdf_input_width(const nsdf_network_desc *d) {
    return d->input == NSDF_INPUT_XYZ ? 3u : d->input == NSDF_INPUT_XYZT ? 4u : 2u * d->fourier_count;
}

/* Fills array_count and the arrays' planes, rows and cols from kind, rows, cols, knots, rank. */
static inline void nsdf_tensor_layout(nsdf_tensor_desc *t) {
    t->array_count = 1;
    t->arrays[0].planes = t->kind == NSDF_TENSOR_SPLINE ? t->knots : 1;
    t->arrays[0].rows = t->rows;
    t->arrays[0].cols = t->cols;
    if (t->kind == NSDF_TENSOR_LOW_RANK) {
        t->array_count = 3;
        t->arrays[1].planes = t->rank;
        t->arrays[1].rows = t->rows;
        t->arrays[1].cols = t->cols;
        t->arrays[2].planes = t->rank;
        t->arrays[2].rows = t->knots;
        t->arrays[2].cols = 1;
    }
}

/* Parameters of all tensors together, the length of the float vector that readers fill and writers take: arrays in
 * the order of the file, each [planes][rows][cols]. */
static inline uint64_t nsdf_parameter_count(const nsdf_tensor_list *d) {
    uint64_t n = 0;
    for (uint32_t i = 0; i < d->count; i++)
        for (uint32_t k = 0; k < d->tensors[i].array_count; k++)
            n += nsdf_array_size(&d->tensors[i].arrays[k]);
    return n;
}

#endif

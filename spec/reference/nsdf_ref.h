#ifndef NSDF_REF_H
#define NSDF_REF_H

/* A second decoder of .nsdf files, written from spec/nsdf-bitstream.md alone and sharing no code with the library. It
 * is slow, holds a whole file at once and refuses a file at its first fault; tests compare the library with it. Of QUAL
 * and META it checks the place and the CRC only. The numbers in comments are sections of that text. */

#include <stddef.h>
#include <stdint.h>

enum {
    REF_MAX_PARTS = 16,
    REF_MAX_LAYERS = 32,
    REF_MAX_ARRAYS = 3 * (1 + 2 * REF_MAX_LAYERS), /* at most three arrays for B and for each W and b */
};

typedef enum ref_status { /* section 13 */
                          REF_OK,
                          REF_NOT_NSDF,
                          REF_UNSUPPORTED_VERSION,
                          REF_UNSUPPORTED_FEATURE,
                          REF_TRUNCATED,
                          REF_CHECKSUM,
                          REF_CORRUPT,
                          REF_NO_MEMORY,
} ref_status;

typedef struct ref_array {
    uint32_t planes, rows, cols;
    uint32_t uniform, predict, bits;
    int32_t residual_min;
    float step, offset;
    uint64_t count; /* planes * rows * cols */
    int32_t *q;     /* [planes][rows][cols], first the residuals, then q; NULL if raw */
    float *w;       /* [planes][rows][cols], the parameters */
} ref_array;

typedef struct ref_tensor {
    uint32_t kind; /* 0 constant, 1 spline, 2 low-rank */
    uint32_t rows, cols, knots, rank;
    const ref_array *arrays; /* 1, or 3 if low-rank */
} ref_tensor;

typedef struct ref_layer {
    uint32_t inputs, width, activation;
    float omega;
    ref_tensor weight, bias;
} ref_layer;

typedef struct ref_blocks { /* section 10.6 */
    uint32_t degree, influences, bone_count, block_count;
    float fade;
    ref_tensor centres, radii, lives, bones, weights, anchors, poses;
    ref_tensor coefficients[4]; /* by degree */
} ref_blocks;

typedef struct ref_part {
    uint32_t kind;     /* 1 network, 2 blocks: what belongs to the other kind is 0 */
    ref_blocks blocks; /* of kind 2 */
    uint32_t input, fourier_source, entropy, layer_count, fourier_count;
    uint64_t fourier_seed;
    float fourier_sigma, time_scale, value_scale, value_offset;
    ref_layer layers[REF_MAX_LAYERS];
    ref_array arrays[REF_MAX_ARRAYS]; /* of all tensors, in order */
    uint32_t array_count;
    const float *fourier; /* B, [fourier_count][4]; NULL without Fourier features */
    float *parameters;    /* all arrays, one after the other */
    uint64_t parameter_count;
} ref_part;

typedef struct ref_segment {
    uint32_t first_frame, last_frame;
    int32_t lead, trail; /* frames */
    uint32_t fade;
    float smallest_piece;
    uint64_t offset, size;
    uint64_t stored_hash, hash; /* from INDX, and of the decoded parameters */
    uint32_t part_count;
    ref_part *parts[REF_MAX_PARTS];
    uint64_t parameter_count; /* of all parts */
} ref_segment;

typedef struct ref_file {
    uint32_t rate_num, rate_den, frame_count, segment_count;
    double box_min[3], box_max[3], centre[3], scale;
    float domain_min[3], domain_max[3];
    uint32_t default_resolution;
    float extraction_bound;
    uint64_t file_size;
    ref_segment *segments;
    void *blocks; /* all memory that the file owns */
} ref_file;

/* Decodes the file in data[0 .. size - 1]. On success *out is to be freed with ref_close; a parameter hash that differs
 * from the stored one is not a failure, the caller compares the two. On failure *out is NULL and *message says why. */
ref_status ref_open(const void *data, size_t size, ref_file **out, const char **message);
void ref_close(ref_file **file);

/* The signed distance, in world units, at a point of the world and a time in seconds (sections 2 and 11). */
double ref_evaluate(const ref_file *file, double seconds, const double point[3]);

#endif

#include <float.h>
#include <math.h>

#include "bytes.h"
#include "entropy_read.h"

/* Sums must be rounded to double, as everywhere else (spec, section "Quantisation"). */
_Static_assert(FLT_EVAL_METHOD == 0 || FLT_EVAL_METHOD == 1, "needs arithmetic without excess precision in double");

static uint64_t largest_uniform_array(const nsdf_tensor_list *list) {
    uint64_t largest = 0;
    for (uint32_t t = 0; t < list->count; t++)
        for (uint32_t k = 0; k < list->tensors[t].array_count; k++) {
            const nsdf_array_desc *a = &list->tensors[t].arrays[k];
            uint64_t n = a->quantiser == NSDF_QUANT_UNIFORM ? nsdf_array_size(a) : 0;
            largest = n > largest ? n : largest;
        }
    return largest;
}

/* Residuals of one array, and behind them the byte planes of all. */
size_t nsdf_parameter_scratch_size(const nsdf_tensor_list *list) {
    int planes = list->entropy == NSDF_ENTROPY_DEFLATE || list->entropy == NSDF_ENTROPY_ZSTD;
    uint64_t size = largest_uniform_array(list) * sizeof(int32_t) + (planes ? nsdf_all_plane_bytes(list) : 0);
    return (size_t)size;
}

/* What prediction expects at element i. */
static int32_t predicted(const nsdf_array_desc *a, const int32_t *q, size_t i, size_t plane) {
    if (a->predict == NSDF_PREDICT_NONE)
        return 0;
    if (a->predict == NSDF_PREDICT_ROW)
        return i % plane < a->cols ? 0 : q[i - a->cols];
    if (a->predict == NSDF_PREDICT_LINEAR && i >= 2 * plane)
        return 2 * q[i - plane] - q[i - 2 * plane];
    return i < plane ? 0 : q[i - plane];
}

/* Residuals to quantised values, in place.  No sum can overflow: |q| < 2^24 is kept and |r| < 2^26. */
static int undo_prediction(const nsdf_array_desc *a, int32_t *q) {
    size_t plane = (size_t)a->rows * a->cols, count = plane * a->planes;
    for (size_t i = 0; i < count; i++) {
        q[i] += predicted(a, q, i, plane);
        if (q[i] <= -NSDF_MAX_QUANTISED || q[i] >= NSDF_MAX_QUANTISED)
            return 0;
    }
    return 1;
}

/* The product of a 24-bit and a 24-bit significand is exact in a double, so contraction to a fused multiply-add
 * changes nothing. */
static int dequantise(const nsdf_array_desc *a, const int32_t *q, float *values) {
    size_t count = (size_t)nsdf_array_size(a);
    double step = (double)a->step, offset = (double)a->offset;
    for (size_t i = 0; i < count; i++) {
        double v = offset + step * (double)q[i];
        if (!(fabs(v) <= (double)FLT_MAX))
            return 0;
        values[i] = (float)v;
    }
    return 1;
}

static nsdf_parse read_uniform(nsdf_residual_reader *reader, const nsdf_array_desc *a, int32_t *q, float *values,
                               const char **what) {
    nsdf_parse status = nsdf_residuals_next(reader, a, q, what);
    if (status != NSDF_PARSE_OK)
        return status;
    if (!undo_prediction(a, q)) {
        *what = "a quantised parameter not below 2^24 in magnitude";
        return NSDF_PARSE_CORRUPT;
    }
    if (!dequantise(a, q, values)) {
        *what = "a parameter that is not finite";
        return NSDF_PARSE_CORRUPT;
    }
    return NSDF_PARSE_OK;
}

static void read_raw(nsdf_cursor *c, const nsdf_array_desc *a, float *values) {
    size_t count = (size_t)nsdf_array_size(a), at = c->at;
    const uint8_t *p = nsdf_take(c, count * 4);
    for (size_t i = 0; i < count && c->status == NSDF_PARSE_OK; i++) {
        values[i] = nsdf_load_f32(p + 4 * i);
        nsdf_cursor_expect(c, isfinite(values[i]), at + 4 * i, "a raw parameter that is not finite");
    }
}

static uint64_t raw_bytes(const nsdf_tensor_list *list) {
    uint64_t count = 0;
    for (uint32_t t = 0; t < list->count; t++)
        for (uint32_t k = 0; k < list->tensors[t].array_count; k++) {
            const nsdf_array_desc *a = &list->tensors[t].arrays[k];
            count += a->quantiser == NSDF_QUANT_RAW ? nsdf_array_size(a) : 0;
        }
    return count * 4;
}

/* The raw arrays, then the length of the coded stream, which must fill the rest. */
static void read_raw_arrays(nsdf_cursor *c, const nsdf_tensor_list *list, float *values) {
    uint64_t size = nsdf_take_u32(c);
    nsdf_cursor_expect(c, size == raw_bytes(list), c->at - 4, "bytes of raw parameters not as the shapes give");
    for (uint32_t t = 0; t < list->count; t++)
        for (uint32_t k = 0; k < list->tensors[t].array_count && c->status == NSDF_PARSE_OK; k++) {
            const nsdf_array_desc *a = &list->tensors[t].arrays[k];
            if (a->quantiser == NSDF_QUANT_RAW)
                read_raw(c, a, values);
            values += nsdf_array_size(a);
        }
    size_t at = c->at;
    uint64_t coded = nsdf_take_u32(c);
    if (c->status == NSDF_PARSE_OK && coded > c->size - c->at)
        nsdf_cursor_fail(c, NSDF_PARSE_TRUNCATED, at, "coded stream beyond the end of the part");
    nsdf_cursor_expect(c, coded == c->size - c->at, at, "bytes behind the coded stream of a part");
}

static nsdf_parse read_uniform_arrays(nsdf_residual_reader *reader, const nsdf_tensor_list *list, int32_t *scratch,
                                      float *values, const char **what) {
    for (uint32_t t = 0; t < list->count; t++)
        for (uint32_t k = 0; k < list->tensors[t].array_count; k++) {
            const nsdf_array_desc *a = &list->tensors[t].arrays[k];
            nsdf_parse status = NSDF_PARSE_OK;
            if (a->quantiser == NSDF_QUANT_UNIFORM)
                status = read_uniform(reader, a, scratch, values, what);
            if (status != NSDF_PARSE_OK)
                return status;
            values += nsdf_array_size(a);
        }
    return nsdf_residuals_close(reader, what);
}

nsdf_parse nsdf_read_parameters(const uint8_t *part, size_t size, size_t coded_offset, const nsdf_tensor_list *list,
                                void *scratch, const nsdf_codec_memory *memory, float *values, nsdf_fault *fault) {
    nsdf_cursor c = nsdf_cursor_start(part, size, coded_offset);
    read_raw_arrays(&c, list, values);
    if (c.status != NSDF_PARSE_OK)
        return nsdf_cursor_finish(&c, fault);
    nsdf_residual_reader reader;
    const char *what = "";
    int32_t *residuals = scratch;
    /* Without residuals and planes there is no scratch memory. */
    uint8_t *planes = residuals ? (uint8_t *)(residuals + largest_uniform_array(list)) : NULL;
    nsdf_parse status = nsdf_residuals_open(&reader, list, part + c.at, size - c.at, planes, memory, &what);
    if (status == NSDF_PARSE_OK)
        status = read_uniform_arrays(&reader, list, residuals, values, &what);
    if (status != NSDF_PARSE_OK)
        nsdf_cursor_fail(&c, status, c.at, what);
    return nsdf_cursor_finish(&c, fault);
}

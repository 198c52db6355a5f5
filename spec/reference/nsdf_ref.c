#include "nsdf_ref_parts.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#ifdef NSDF_HAVE_ZLIB
#include <zlib.h>
#endif
#ifdef NSDF_HAVE_ZSTD
#include <zstd.h>
#endif

/* The reading of one file. A fault anywhere jumps back to ref_open, which frees everything. */
typedef struct ref_context {
    jmp_buf fault;
    ref_status status;
    const char *message;
    ref_file *file;
} context;

typedef ref_reader reader;

typedef struct block {
    struct block *next;
    max_align_t memory[];
} block;

static _Noreturn void fail(context *ctx, ref_status status, const char *message) {
    ctx->status = status;
    ctx->message = message;
    longjmp(ctx->fault, 1);
}

void ref_demand(const ref_reader *r, bool is_so, const char *message) {
    if (!is_so)
        fail(r->ctx, REF_CORRUPT, message);
}

void *ref_allocate(struct ref_context *ctx, uint64_t count, size_t size) {
    block *b = count <= (SIZE_MAX / 2) / size ? calloc(1, sizeof(block) + (size_t)count * size) : NULL;
    if (!b)
        fail(ctx, REF_NO_MEMORY, "out of memory");
    b->next = ctx->file->blocks;
    ctx->file->blocks = b;
    return b->memory;
}

/* Section 1: fields. */

static const uint8_t *take(reader *r, uint64_t count) {
    if (count > r->size - r->at)
        fail(r->ctx, REF_TRUNCATED, "a field needs more bytes than there are");
    r->at += count;
    return r->data + (r->at - count);
}

static reader take_reader(reader *r, uint64_t count) {
    return (reader){.ctx = r->ctx, .data = take(r, count), .size = count};
}

static uint64_t take_u64(reader *r) {
    const uint8_t *from = take(r, 8);
    uint64_t value = 0;
    for (int i = 0; i < 8; i++)
        value |= (uint64_t)from[i] << (8 * i);
    return value;
}

uint32_t ref_take_uint(ref_reader *r, uint32_t bytes) {
    const uint8_t *from = take(r, bytes);
    uint32_t value = 0;
    for (uint32_t i = 0; i < bytes; i++)
        value |= (uint32_t)from[i] << (8 * i);
    return value;
}

static int32_t take_i32(reader *r) {
    const uint32_t bits = ref_take_uint(r, 4);
    int32_t value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

float ref_take_f32(ref_reader *r) {
    const uint32_t bits = ref_take_uint(r, 4);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static double take_f64(reader *r) {
    const uint64_t bits = take_u64(r);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Section 4. */

static uint32_t crc32_of(const uint8_t *data, uint64_t size) {
    uint32_t crc = 0xFFFFFFFFu;
    for (uint64_t i = 0; i < size; i++) {
        crc ^= data[i];
        for (int bit = 0; bit < 8; bit++)
            crc = (crc >> 1) ^ (crc & 1 ? 0xEDB88320u : 0);
    }
    return ~crc;
}

static void read_preamble(reader *r) {
    static const uint8_t signature[9] = {0x89, 'N', 'S', 'D', 'F', '\r', '\n', 0x1A, '\n'};
    if (memcmp(r->data, signature, r->size < 9 ? (size_t)r->size : 9) != 0)
        fail(r->ctx, REF_NOT_NSDF, "the signature differs");
    take(r, 9);
    const uint32_t major = ref_take_uint(r, 1);
    if (major > 0)
        fail(r->ctx, REF_UNSUPPORTED_VERSION, "the major version is above 0");
    const uint32_t minor = ref_take_uint(r, 1);
    take(r, 1);
    if (ref_take_uint(r, 4) != crc32_of(r->data, 12))
        fail(r->ctx, REF_CHECKSUM, "the CRC of the preamble differs");
    if (minor != 6)
        fail(r->ctx, REF_UNSUPPORTED_VERSION, "the minor version is not 6");
}

/* Section 5. */

typedef struct chunk {
    char type[5];
    bool critical;
    uint64_t offset, size; /* of the whole chunk in the file */
    reader payload;
} chunk;

static chunk read_chunk(reader *r) {
    chunk c = {.offset = r->at};
    memcpy(c.type, take(r, 4), 4);
    c.critical = ref_take_uint(r, 4) & 1;
    const uint64_t length = take_u64(r);
    ref_demand(r, length < UINT64_C(1) << 63, "the length of a chunk is above 2^63 - 1");
    c.payload = take_reader(r, length);
    if (ref_take_uint(r, 4) != crc32_of(r->data + c.offset, 16 + length))
        fail(r->ctx, REF_CHECKSUM, "the CRC of a chunk differs");
    c.size = r->at - c.offset;
    for (int i = 0; i < 4; i++) {
        const char a = c.type[i];
        ref_demand(r, (a >= '0' && a <= '9') || (a >= 'A' && a <= 'Z') || (a >= 'a' && a <= 'z'),
                   "the type of a chunk is not made of letters and digits");
    }
    return c;
}

static bool is_type(const chunk *c, const char *type) {
    return strcmp(c->type, type) == 0;
}

/* Section 6. */

static bool within(double value, double low, double high) {
    return value >= low && value <= high;
}

static void read_head(reader *r, ref_file *f) {
    f->rate_num = ref_take_uint(r, 4);
    f->rate_den = ref_take_uint(r, 4);
    f->frame_count = ref_take_uint(r, 4);
    f->segment_count = ref_take_uint(r, 4);
    ref_demand(r, f->rate_num >= 1 && f->rate_den >= 1 && f->frame_count >= 1, "HEAD: the frame rate or count is 0");
    ref_demand(r, within(f->segment_count, 1, fmin(1 << 20, fmax(1, f->frame_count - 1.0))), "HEAD: bad segment_count");
    double *const vectors[3] = {f->box_min, f->box_max, f->centre};
    for (int i = 0; i < 9; i++) {
        vectors[i / 3][i % 3] = take_f64(r);
        ref_demand(r, within(vectors[i / 3][i % 3], -1e30, 1e30), "HEAD: the box or centre is out of range");
    }
    f->scale = take_f64(r);
    for (int i = 0; i < 6; i++)
        (i < 3 ? f->domain_min : f->domain_max)[i % 3] = ref_take_f32(r);
    for (int i = 0; i < 3; i++) {
        ref_demand(r, f->box_max[i] >= f->box_min[i], "HEAD: the box is turned round");
        ref_demand(r, f->domain_min[i] >= -16.0f && f->domain_max[i] <= 16.0f && f->domain_max[i] > f->domain_min[i],
                   "HEAD: the domain is out of range");
    }
    f->default_resolution = ref_take_uint(r, 4);
    f->extraction_bound = ref_take_f32(r);
    ref_demand(r, within(f->scale, 1e-30, 1e30), "HEAD: scale is out of range");
    ref_demand(r, within(f->default_resolution, 2, 4096), "HEAD: default_resolution is out of range");
    ref_demand(r, f->extraction_bound > 0.0f && f->extraction_bound <= 1e6f, "HEAD: extraction_bound is out of range");
}

/* Section 7: what a segment has beyond its frames; `other` is the one before. */

static void read_reach(reader *r, ref_segment *s, const ref_segment *other) {
    s->lead = take_i32(r);
    s->trail = take_i32(r);
    s->fade = ref_take_uint(r, 4);
    s->smallest_piece = ref_take_f32(r);
    ref_demand(r, (int64_t)s->first_frame - s->lead <= (int64_t)s->last_frame + s->trail,
               "INDX: a model ends before it begins");
    ref_demand(r, within((double)s->smallest_piece, 0, 64), "INDX: smallest_piece is out of range");
    if (s->fade == 0)
        return;
    ref_demand(r, other != NULL, "INDX: the first segment has a cross-fade");
    ref_demand(r, (int64_t)s->fade <= s->lead && (int64_t)s->fade <= other->trail,
               "INDX: a cross-fade is longer than the models reach");
    ref_demand(r, s->fade <= s->last_frame - s->first_frame, "INDX: a cross-fade is longer than its segment");
    ref_demand(r, s->fade <= other->last_frame - other->first_frame - other->fade, "INDX: two cross-fades overlap");
}

/* Section 7. `before` is the end of the INDX chunk. */

static void read_index(reader *r, ref_file *f, uint64_t before) {
    f->file_size = take_u64(r);
    ref_demand(r, f->file_size < UINT64_C(1) << 63, "INDX: file_size is above 2^63 - 1");
    f->segments = ref_allocate(r->ctx, f->segment_count, sizeof *f->segments);
    uint32_t frame = 0;
    for (uint32_t i = 0; i < f->segment_count; i++) {
        ref_segment *s = &f->segments[i];
        s->first_frame = ref_take_uint(r, 4);
        s->last_frame = ref_take_uint(r, 4);
        ref_demand(r, s->first_frame == frame, "INDX: first_frame does not follow");
        ref_demand(r, s->last_frame < f->frame_count && (s->last_frame > frame || f->frame_count == 1),
                   "INDX: last_frame is out of range");
        frame = s->last_frame;
        read_reach(r, s, i > 0 ? s - 1 : NULL);
        s->offset = take_u64(r);
        s->size = take_u64(r);
        ref_demand(r, s->offset >= before, "INDX: a segment lies inside what stands before it");
        ref_demand(r,
                   s->size >= 20 && s->size < f->file_size && s->offset < f->file_size &&
                       s->offset + s->size + 20 <= f->file_size,
                   "INDX: a segment lies outside the file");
        before = s->offset + s->size;
        s->stored_hash = take_u64(r);
    }
    ref_demand(r, frame == f->frame_count - 1, "INDX: the last segment does not end at the last frame");
}

/* Section 10.1. */

static void read_array(reader *r, ref_part *part, uint32_t planes, uint32_t rows, uint32_t cols) {
    ref_array *a = &part->arrays[part->array_count++];
    *a = (ref_array){.planes = planes, .rows = rows, .cols = cols, .count = (uint64_t)planes * rows * cols};
    const uint32_t coding = ref_take_uint(r, 1);
    a->uniform = coding & 15;
    a->predict = coding >> 4;
    ref_demand(r, a->uniform <= 1 && a->predict <= 3 * a->uniform, "an array's coding is out of range");
    if (a->uniform) {
        a->bits = ref_take_uint(r, 1);
        a->residual_min = take_i32(r);
        a->step = ref_take_f32(r);
        a->offset = ref_take_f32(r);
        ref_demand(r, a->bits <= 24 && within(a->residual_min, -33554431, 33554431),
                   "an array's residuals are out of range");
        ref_demand(r, isfinite(a->step) && a->step >= 0.0f && isfinite(a->offset), "a quantiser is out of range");
    }
    part->parameter_count += a->count;
    ref_demand(r, part->parameter_count <= 1u << 28, "the part has too many parameters");
}

ref_tensor ref_read_tensor(ref_reader *r, ref_part *part, uint32_t rows, uint32_t cols) {
    ref_tensor t = {.rows = rows, .cols = cols, .arrays = &part->arrays[part->array_count]};
    t.kind = ref_take_uint(r, 1);
    ref_demand(r, t.kind <= 2, "a tensor's kind is out of range");
    if (t.kind >= 1) {
        t.knots = ref_take_uint(r, 2);
        ref_demand(r, t.knots >= 4, "knots are out of range");
    }
    if (t.kind == 2) {
        t.rank = ref_take_uint(r, 2);
        ref_demand(r, t.rank >= 1 && t.rank <= 256, "a rank is out of range");
    }
    read_array(r, part, t.kind == 1 ? t.knots : 1, rows, cols);
    if (t.kind == 2) {
        read_array(r, part, t.rank, rows, cols);
        read_array(r, part, t.rank, t.knots, 1);
    }
    return t;
}

static void read_input(reader *r, ref_part *part) {
    part->input = ref_take_uint(r, 1);
    part->fourier_source = ref_take_uint(r, 1);
    part->entropy = ref_take_uint(r, 1);
    part->layer_count = ref_take_uint(r, 1);
    part->fourier_count = ref_take_uint(r, 2);
    const bool fourier = part->input == 2;
    ref_demand(r, part->input <= 2, "the input is out of range");
    ref_demand(r, part->fourier_source <= (fourier ? 1 : 0), "fourier_source is out of range");
    ref_demand(r, part->entropy <= 3, "the entropy back end is out of range");
    ref_demand(r, part->layer_count >= 1 && part->layer_count <= REF_MAX_LAYERS, "layer_count is out of range");
    ref_demand(r, fourier ? within(part->fourier_count, 1, 512) : part->fourier_count == 0,
               "fourier_count is out of range");
    if (fourier && part->fourier_source == 0) {
        part->fourier_seed = take_u64(r);
        part->fourier_sigma = ref_take_f32(r);
        ref_demand(r, within((double)part->fourier_sigma, 0.0, 1e6), "fourier_sigma is out of range");
    }
    part->time_scale = ref_take_f32(r);
    part->value_scale = ref_take_f32(r);
    part->value_offset = ref_take_f32(r);
    ref_demand(r, isfinite(part->time_scale) && isfinite(part->value_offset),
               "time_scale or value_offset is not finite");
    ref_demand(r, isfinite(part->value_scale) && part->value_scale != 0.0f, "value_scale is not finite or 0");
}

static void read_description(reader *r, ref_part *part) {
    read_input(r, part);
    uint32_t inputs = part->input == 0 ? 3 : part->input == 1 ? 4 : 2 * part->fourier_count;
    for (uint32_t i = 0; i < part->layer_count; i++) {
        ref_layer *layer = &part->layers[i];
        layer->inputs = inputs;
        layer->width = ref_take_uint(r, 2);
        layer->activation = ref_take_uint(r, 1);
        ref_demand(r, layer->width >= 1 && layer->width <= 1024, "a layer's width is out of range");
        ref_demand(r, layer->activation <= 3, "an activation is out of range");
        if (layer->activation == 2) {
            layer->omega = ref_take_f32(r);
            ref_demand(r, isfinite(layer->omega), "omega is not finite");
        }
        inputs = layer->width;
    }
    ref_demand(r, inputs == 1, "the last layer's width is not 1");
    if (part->fourier_source == 1)
        ref_demand(r, ref_read_tensor(r, part, part->fourier_count, 4).kind == 0, "B is not constant");
    for (uint32_t i = 0; i < part->layer_count; i++) {
        ref_layer *layer = &part->layers[i];
        layer->weight = ref_read_tensor(r, part, layer->width, layer->inputs);
        layer->bias = ref_read_tensor(r, part, layer->width, 1);
    }
}

/* Section 10.4. A stored array is one whose residuals are in `coded`. */

static void decode_packed(reader *coded, ref_part *part) {
    uint64_t bit = 0;
    for (uint32_t i = 0; i < part->array_count; i++) {
        const ref_array *a = &part->arrays[i];
        for (uint64_t k = 0; ref_is_stored(a) && k < a->count; k++) {
            int32_t symbol = 0;
            for (uint32_t b = 0; b < a->bits; b++, bit++) {
                if (bit % 8 == 0)
                    take(coded, 1);
                symbol |= (coded->data[bit / 8] >> (bit % 8) & 1) << b;
            }
            a->q[k] = a->residual_min + symbol;
        }
    }
    for (; bit % 8 != 0; bit++)
        ref_demand(coded, (coded->data[bit / 8] >> (bit % 8) & 1) == 0,
                   "the bits that fill up the last byte are not 0");
    ref_demand(coded, coded->at == coded->size, "there are bytes behind the packed symbols");
}

/* Residuals from the bytes of their symbols, lowest bytes of an array first. */
static void residuals_from_bytes(reader *bytes, ref_part *part) {
    for (uint32_t i = 0; i < part->array_count; i++) {
        const ref_array *a = &part->arrays[i];
        if (!ref_is_stored(a))
            continue;
        for (uint64_t k = 0; k < a->count; k++)
            a->q[k] = a->residual_min;
        for (uint32_t shift = 0; shift < a->bits; shift += 8)
            for (uint64_t k = 0; k < a->count; k++)
                a->q[k] += (int32_t)(ref_take_uint(bytes, 1) << shift);
        for (uint64_t k = 0; k < a->count; k++)
            ref_demand(bytes, a->q[k] - a->residual_min < 1 << a->bits, "a symbol is out of range");
    }
}

/* Section 10.4, deflate and zstd. True if all of coded decompresses to exactly size bytes. */
static bool decompress(const reader *coded, uint32_t entropy, uint8_t *out, uint64_t size) {
#ifdef NSDF_HAVE_ZLIB
    if (entropy == 1) {
        uLongf out_size = (uLongf)size;
        uLong used = (uLong)coded->size;
        return uncompress2(out, &out_size, coded->data, &used) == Z_OK && out_size == size && used == coded->size;
    }
#endif
#ifdef NSDF_HAVE_ZSTD
    static const uint8_t magic[4] = {0x28, 0xB5, 0x2F, 0xFD}; /* of a frame that is not skippable */
    if (entropy == 2)
        return coded->size >= 4 && memcmp(coded->data, magic, 4) == 0 &&
               ZSTD_findFrameCompressedSize(coded->data, (size_t)coded->size) == coded->size &&
               ZSTD_decompress(out, (size_t)size, coded->data, (size_t)coded->size) == size;
#endif
    (void)entropy, (void)out, (void)size;
    fail(coded->ctx, REF_UNSUPPORTED_FEATURE, "built without this entropy back end");
}

static void decode_bytes(reader *coded, ref_part *part) {
    uint64_t size = 0;
    for (uint32_t i = 0; i < part->array_count; i++)
        size += ref_is_stored(&part->arrays[i]) ? part->arrays[i].count * ((part->arrays[i].bits + 7) / 8) : 0;
    uint8_t *bytes = ref_allocate(coded->ctx, size, 1);
    ref_demand(coded, decompress(coded, part->entropy, bytes, size), "the compressed stream is broken");
    reader symbols = {.ctx = coded->ctx, .data = bytes, .size = size};
    residuals_from_bytes(&symbols, part);
}

/* Sections 10.2 and 10.3. */

/* What is added to the residual of element k, all before it being known. */
static int64_t prediction(const ref_array *a, uint64_t k) {
    const uint64_t plane = (uint64_t)a->rows * a->cols;
    if (a->predict == 3)
        return k % plane < a->cols ? 0 : a->q[k - a->cols];
    if (a->predict == 0 || k < plane)
        return 0;
    if (a->predict == 1 || k < 2 * plane)
        return a->q[k - plane];
    return 2 * (int64_t)a->q[k - plane] - a->q[k - 2 * plane];
}

static void dequantise(reader *r, const ref_array *a) {
    for (uint64_t k = 0; k < a->count; k++) {
        const int64_t q = a->q[k] + prediction(a, k);
        ref_demand(r, q > -(1 << 24) && q < 1 << 24, "a quantised value is out of range");
        a->q[k] = (int32_t)q;
        const double product = (double)a->step * (double)q;
        const double w = (double)a->offset + product;
        ref_demand(r, fabs(w) <= (double)FLT_MAX, "a parameter is out of range");
        a->w[k] = (float)w;
    }
}

static void read_raw(reader *r, ref_part *part) {
    uint64_t elements = 0;
    for (uint32_t i = 0; i < part->array_count; i++)
        elements += part->arrays[i].uniform ? 0 : part->arrays[i].count;
    const uint32_t raw_size = ref_take_uint(r, 4);
    ref_demand(r, raw_size == 4 * elements, "raw_size is wrong");
    reader raw = take_reader(r, raw_size);
    for (uint32_t i = 0; i < part->array_count; i++) {
        const ref_array *a = &part->arrays[i];
        for (uint64_t k = 0; !a->uniform && k < a->count; k++) {
            a->w[k] = ref_take_f32(&raw);
            ref_demand(r, isfinite(a->w[k]), "a raw parameter is not finite");
        }
    }
}

static void read_coded(reader *r, ref_part *part) {
    bool any_stored = false;
    for (uint32_t i = 0; i < part->array_count; i++) {
        const ref_array *a = &part->arrays[i];
        any_stored = any_stored || ref_is_stored(a);
        for (uint64_t k = 0; a->uniform && k < a->count; k++)
            a->q[k] = a->residual_min;
    }
    const uint32_t coded_size = ref_take_uint(r, 4);
    reader coded = take_reader(r, coded_size);
    ref_demand(r, r->at == r->size, "coded_size is not the rest of the part");
    if (!any_stored)
        ref_demand(r, coded_size == 0, "there are coded bytes that no array needs");
    else if (part->entropy == 0)
        decode_packed(&coded, part);
    else if (part->entropy == 3)
        ref_decode_range(&coded, part);
    else
        decode_bytes(&coded, part);
}

static void read_parameters(reader *r, ref_part *part) {
    part->parameters = ref_allocate(r->ctx, part->parameter_count, sizeof *part->parameters);
    float *next = part->parameters;
    for (uint32_t i = 0; i < part->array_count; i++) {
        ref_array *a = &part->arrays[i];
        a->w = next;
        next += a->count;
        a->q = a->uniform ? ref_allocate(r->ctx, a->count, sizeof *a->q) : NULL;
    }
    read_raw(r, part);
    read_coded(r, part);
    for (uint32_t i = 0; i < part->array_count; i++)
        if (part->arrays[i].uniform)
            dequantise(r, &part->arrays[i]);
}

/* Section 11.1, Fourier matrix from a seed. */

static float fourier_element(uint64_t *state, float sigma) {
    uint64_t sum = 0;
    for (int i = 0; i < 3; i++) {
        *state += UINT64_C(0x9E3779B97F4A7C15);
        uint64_t z = *state;
        z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
        z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
        z = z ^ (z >> 31);
        sum += (z & 0xFFFF) + ((z >> 16) & 0xFFFF) + ((z >> 32) & 0xFFFF) + (z >> 48);
    }
    return (float)(((double)sum - 393210.0) / 65536.0 * (double)sigma);
}

static const float *fourier_matrix(context *ctx, const ref_part *part) {
    if (part->input != 2 || part->fourier_source == 1)
        return part->input == 2 ? part->arrays[0].w : NULL;
    float *matrix = ref_allocate(ctx, 4 * part->fourier_count, sizeof *matrix);
    uint64_t state = part->fourier_seed;
    for (uint32_t i = 0; i < 4 * part->fourier_count; i++)
        matrix[i] = fourier_element(&state, part->fourier_sigma);
    return matrix;
}

/* Sections 9 and 12. */

static uint64_t hash_parameters(uint64_t hash, const ref_part *part) {
    for (uint64_t i = 0; i < part->parameter_count; i++) {
        uint32_t bits;
        memcpy(&bits, &part->parameters[i], sizeof bits);
        for (int k = 0; k < 4; k++)
            hash = (hash ^ (bits >> (8 * k) & 0xFF)) * UINT64_C(0x100000001B3);
    }
    return hash;
}

static void read_network(reader *r, ref_part *part) {
    read_description(r, part);
    read_parameters(r, part);
    part->fourier = fourier_matrix(r->ctx, part);
}

static void read_blocks(reader *r, ref_part *part) {
    ref_read_blocks(r, part);
    read_parameters(r, part);
    ref_check_blocks(r, part);
}

static void read_segment(reader *r, ref_segment *s) {
    s->hash = UINT64_C(0xCBF29CE484222325);
    s->part_count = ref_take_uint(r, 4);
    ref_demand(r, s->part_count >= 1 && s->part_count <= REF_MAX_PARTS, "SEGM: part_count is out of range");
    for (uint32_t i = 0; i < s->part_count; i++) {
        const uint32_t kind = ref_take_uint(r, 2);
        take(r, 2);
        reader part = take_reader(r, take_u64(r));
        if (kind != 1 && kind != 2)
            fail(r->ctx, REF_UNSUPPORTED_FEATURE, "SEGM: unknown kind of part");
        s->parts[i] = ref_allocate(r->ctx, 1, sizeof *s->parts[i]);
        s->parts[i]->kind = kind;
        if (kind == 1)
            read_network(&part, s->parts[i]);
        else
            read_blocks(&part, s->parts[i]);
        s->hash = hash_parameters(s->hash, s->parts[i]);
        s->parameter_count += s->parts[i]->parameter_count;
    }
    ref_demand(r, r->at == r->size, "SEGM: there are bytes behind the last part");
}

/* Section 3. */

static bool is_known(const chunk *c) {
    return is_type(c, "HEAD") || is_type(c, "INDX") || is_type(c, "QUAL") || is_type(c, "META") || is_type(c, "SEGM") ||
           is_type(c, "ENDF");
}

/* The next chunk of those behind INDX that is not an unknown ancillary one. */
static chunk next_known_chunk(reader *r) {
    chunk c = read_chunk(r);
    for (; !is_known(&c); c = read_chunk(r))
        if (c.critical)
            fail(r->ctx, REF_UNSUPPORTED_FEATURE, "unknown critical chunk");
    ref_demand(r, !is_type(&c, "HEAD") && !is_type(&c, "INDX"), "HEAD or INDX occurs twice");
    return c;
}

static void read_file(reader *r) {
    ref_file *f = r->ctx->file;
    read_preamble(r);
    chunk c = read_chunk(r);
    ref_demand(r, is_type(&c, "HEAD"), "the first chunk is not HEAD");
    read_head(&c.payload, f);
    c = read_chunk(r);
    ref_demand(r, is_type(&c, "INDX"), "the second chunk is not INDX");
    read_index(&c.payload, f, r->at);
    if (r->size < f->file_size)
        fail(r->ctx, REF_TRUNCATED, "the file is shorter than INDX says");
    ref_demand(r, r->size == f->file_size, "the file is longer than INDX says");
    bool quality = false, metadata = false;
    uint32_t segments = 0;
    for (c = next_known_chunk(r); !is_type(&c, "ENDF"); c = next_known_chunk(r)) {
        if (is_type(&c, "SEGM")) {
            const ref_segment *s = segments < f->segment_count ? &f->segments[segments] : NULL;
            ref_demand(r, s && c.offset == s->offset && c.size == s->size, "a SEGM chunk is not where INDX says");
            read_segment(&c.payload, &f->segments[segments++]);
        } else {
            bool *seen = is_type(&c, "QUAL") ? &quality : &metadata;
            ref_demand(r, !*seen && segments == 0, "QUAL or META occurs twice or behind a SEGM chunk");
            *seen = true;
        }
    }
    ref_demand(r, c.payload.size == 0 && r->at == r->size, "ENDF is not empty, or something follows it");
    ref_demand(r, segments == f->segment_count, "there are fewer SEGM chunks than segments");
}

/* A function of its own since setjmp leaves the locals of the function that calls it undefined. */
static void read_file_or_fault(reader *r) {
    if (setjmp(r->ctx->fault) == 0)
        read_file(r);
}

ref_status ref_open(const void *data, size_t size, ref_file **out, const char **message) {
    context ctx = {.status = REF_OK, .message = "", .file = calloc(1, sizeof(ref_file))};
    *out = NULL;
    *message = "out of memory";
    if (!ctx.file)
        return REF_NO_MEMORY;
    reader r = {.ctx = &ctx, .data = data, .size = size};
    read_file_or_fault(&r);
    *message = ctx.message;
    if (ctx.status == REF_OK)
        *out = ctx.file;
    else
        ref_close(&ctx.file);
    return ctx.status;
}

void ref_close(ref_file **file) {
    if (!*file)
        return;
    for (block *b = (*file)->blocks, *next; b; b = next) {
        next = b->next;
        free(b);
    }
    free(*file);
    *file = NULL;
}

/* Section 11.1. */

static double spline(const float *points, uint64_t stride, uint32_t knots, double u) {
    const double s = fmin(fmax(u, 0.0), 1.0) * (knots - 3);
    const double k = fmin(floor(s), knots - 4), v = s - k, w = 1.0 - v;
    const float *p = points + (uint64_t)k * stride;
    return w * w * w / 6.0 * (double)p[0] + (3.0 * v * v * v - 6.0 * v * v + 4.0) / 6.0 * (double)p[stride] +
           (3.0 * w * w * w - 6.0 * w * w + 4.0) / 6.0 * (double)p[2 * stride] +
           v * v * v / 6.0 * (double)p[3 * stride];
}

double ref_element(const ref_tensor *t, uint32_t row, uint32_t col, double u) {
    const uint64_t plane = (uint64_t)t->rows * t->cols, at = (uint64_t)row * t->cols + col;
    if (t->kind == 1)
        return spline(t->arrays[0].w + at, plane, t->knots, u);
    double value = (double)t->arrays[0].w[at];
    for (uint32_t r = 0; t->kind == 2 && r < t->rank; r++)
        value +=
            spline(t->arrays[2].w + (uint64_t)r * t->knots, 1, t->knots, u) * (double)t->arrays[1].w[r * plane + at];
    return value;
}

static double activate(const ref_layer *layer, double a) {
    switch (layer->activation) {
    case 1:
        return fmax(0.0, a);
    case 2:
        return sin((double)layer->omega * a);
    case 3:
        return tanh(a);
    default:
        return a;
    }
}

/* inputs has room for 2 * 512 values. */
static void make_inputs(const ref_part *part, const double v[4], double *inputs) {
    if (part->input != 2)
        memcpy(inputs, v, 4 * sizeof *v);
    for (uint32_t i = 0; part->input == 2 && i < part->fourier_count; i++) {
        double angle = 0.0;
        for (int k = 0; k < 4; k++)
            angle += 2.0 * 3.14159265358979323846 * (double)part->fourier[4 * i + (uint32_t)k] * v[k];
        inputs[i] = cos(angle);
        inputs[part->fourier_count + i] = sin(angle);
    }
}

static double evaluate_network(const ref_part *part, const double point[3], double u) {
    double x[1024], y[1024];
    const double v[4] = {point[0], point[1], point[2], (double)part->time_scale * u};
    make_inputs(part, v, x);
    for (uint32_t i = 0; i < part->layer_count; i++) {
        const ref_layer *layer = &part->layers[i];
        for (uint32_t row = 0; row < layer->width; row++) {
            double sum = ref_element(&layer->bias, row, 0, u);
            for (uint32_t col = 0; col < layer->inputs; col++)
                sum += ref_element(&layer->weight, row, col, u) * x[col];
            y[row] = activate(layer, sum);
        }
        memcpy(x, y, layer->width * sizeof *x);
    }
    return (double)part->value_scale * x[0] + (double)part->value_offset;
}

static double frame_time(const ref_file *file, int64_t frame) {
    return (double)frame * file->rate_den / file->rate_num; /* the product of exact numbers is rounded once */
}

/* Sections 2 and 9: the field of one segment at a normalised point. */
static double evaluate_segment(const ref_file *file, const ref_segment *s, double t, const double normalised[3]) {
    const double start = frame_time(file, (int64_t)s->first_frame - s->lead);
    const double end = frame_time(file, (int64_t)s->last_frame + s->trail);
    const double u = end > start ? fmin(fmax((t - start) / (end - start), 0.0), 1.0) : 0.0;
    double sum = 0.0;
    for (uint32_t i = 0; i < s->part_count; i++)
        sum += s->parts[i]->kind == 1 ? evaluate_network(s->parts[i], normalised, u)
                                      : ref_evaluate_blocks(s->parts[i], normalised, u);
    return sum;
}

double ref_evaluate(const ref_file *file, double seconds, const double point[3]) {
    const double t = fmin(fmax(seconds, 0.0), frame_time(file, file->frame_count - 1));
    const ref_segment *s = file->segments;
    while (s + 1 < file->segments + file->segment_count && t >= frame_time(file, s->last_frame))
        s++;
    double normalised[3];
    for (int i = 0; i < 3; i++)
        normalised[i] = (point[i] - file->centre[i]) / file->scale;
    double sum = evaluate_segment(file, s, t, normalised);
    for (const ref_segment *k = file->segments + 1; k < file->segments + file->segment_count; k++) {
        const double from = frame_time(file, (int64_t)k->first_frame - k->fade);
        const double to = frame_time(file, (int64_t)k->first_frame + k->fade);
        if (!(t > from && t < to))
            continue;
        const double p = (t - from) / (to - from), share = p * p * (3.0 - 2.0 * p);
        sum = (1.0 - share) * evaluate_segment(file, k - 1, t, normalised) +
              share * evaluate_segment(file, k, t, normalised);
    }
    return sum * file->scale;
}

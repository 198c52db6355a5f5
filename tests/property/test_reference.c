/* The library against the reference decoder, which was written from the bitstream text alone: the same parameters to
 * the last bit, the same hash, the same files refused, nearly the same field. */
#include "unit/format_samples.h"

#include "fourier.h"
#include "make_blocks.h"
#include "nsdf/decoder.h"
#include "nsdf_ref.h"

enum { MAX_SEGMENTS = 4, MAX_PARTS = 3, FILES = 60, POINTS = 40 };

/* Where the first chunks of a file are. */
enum { HEAD_AT = NSDF_PREAMBLE_SIZE, INDEX_AT = HEAD_AT + NSDF_HEADER_PAYLOAD_SIZE + NSDF_CHUNK_OVERHEAD };

typedef struct sample_file {
    nsdf_buffer bytes;
    nsdf_file_header header;
    nsdf_index_entry entries[MAX_SEGMENTS];
} sample_file;

/* ---- Random files --------------------------------------------------------------------------------------- */

static void make_random_header(uint64_t *rng, nsdf_file_header *h) {
    memset(h, 0, sizeof *h);
    h->rate_num = 1 + sample_below(rng, 60000);
    h->rate_den = 1 + sample_below(rng, 2000);
    h->scale = 0.5 + 20.0 * sample_unit(rng);
    for (int i = 0; i < 3; i++) {
        h->centre[i] = sample_gauss(rng);
        h->box_min[i] = h->centre[i] - sample_unit(rng) * h->scale;
        h->box_max[i] = h->centre[i] + sample_unit(rng) * h->scale;
        h->domain_min[i] = (float)(-0.1 - 0.5 * sample_unit(rng));
        h->domain_max[i] = (float)(0.1 + 0.5 * sample_unit(rng));
    }
    h->default_resolution = 2 + sample_below(rng, 100);
    h->extraction_bound = (float)(0.5 + sample_unit(rng));
}

static uint32_t least(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

/* Lead, trail and, where there is room, a cross-fade from the entry before, which is NULL for the first. */
static void make_random_reach(uint64_t *rng, const nsdf_index_entry *before, nsdf_index_entry *e) {
    e->lead = (int32_t)sample_below(rng, 5) - 1;
    e->trail = (int32_t)sample_below(rng, 4);
    e->smallest_piece = (float)sample_unit(rng) / 16.0f;
    if (!before)
        return;
    const uint32_t reach = e->lead > 0 ? least((uint32_t)e->lead, (uint32_t)before->trail) : 0;
    const uint32_t room =
        least(e->last_frame - e->first_frame, before->last_frame - before->first_frame - before->fade);
    e->fade = least(reach, room);
}

static int32_t triangle(int32_t plane) {
    return 5 * plane * (plane - 1) / 2;
}

/* Turns some arrays into what random ones hardly ever are: constant, near the limits of q and of bits, or growing so
 * that packed bits are least with the prediction by a line, or by the row before. */
static void spice(uint64_t *rng, const nsdf_network_desc *d, int32_t *q) {
    for (uint32_t t = 0; t < d->list.count; t++)
        for (uint32_t k = 0; k < d->list.tensors[t].array_count; k++) {
            const nsdf_array_desc *a = &d->list.tensors[t].arrays[k];
            const uint32_t what = sample_below(rng, 12), span = what == 0 ? 1 : what == 1 ? 1 << 24 : 1 << 9;
            const int32_t base = what == 0   ? (int32_t)sample_below(rng, 99) - 49
                                 : what == 1 ? -(1 << 23)
                                 : what == 2 ? (1 << 24) - (1 << 9)
                                             : 1 - (1 << 24);
            for (uint64_t i = 0; i < nsdf_array_size(a); i++, q++)
                if (what == 4 && a->quantiser == NSDF_QUANT_UNIFORM)
                    *q = triangle((int32_t)(i / ((uint64_t)a->rows * a->cols)));
                else if (what == 5 && a->quantiser == NSDF_QUANT_UNIFORM)
                    *q = 500 * (int32_t)(i / a->cols % a->rows);
                else if (what < 4 && a->quantiser == NSDF_QUANT_UNIFORM)
                    *q = base + (int32_t)sample_below(rng, span);
        }
}

/* A network whose values stay small, so that single precision can follow double. */
static int32_t *tame_parameters(uint64_t *rng, nsdf_network_desc *d) {
    int32_t *q = malloc((size_t)nsdf_parameter_count(&d->list) * sizeof *q), *out = q;
    float *values = malloc((size_t)nsdf_parameter_count(&d->list) * sizeof *values);
    assert_true(q && values);
    d->value_scale = 0.25f;
    d->fourier_sigma *= 0.2f;
    for (uint32_t i = 0; i < d->layer_count; i++)
        d->layers[i].omega *= 0.1f;
    for (uint32_t t = 0; t < d->list.count; t++)
        for (uint32_t k = 0; k < d->list.tensors[t].array_count; k++) {
            nsdf_array_desc *a = &d->list.tensors[t].arrays[k];
            const size_t count = (size_t)nsdf_array_size(a);
            for (size_t i = 0; i < count; i++)
                values[i] = (float)((2.0 * sample_unit(rng) - 1.0) / sqrt((double)d->list.tensors[t].cols));
            memcpy(out, values, count * sizeof *out);
            if (a->quantiser == NSDF_QUANT_UNIFORM) {
                nsdf_minmax_quantiser(values, count, 4 + (int)sample_below(rng, 16), &a->step, &a->offset);
                assert_int_equal(nsdf_quantise(values, count, a->step, a->offset, out), 0);
            }
            out += count;
        }
    free(values);
    return q;
}

/* Appends a block part of random shape; its values stay small however the file is meant. */
static uint64_t add_blocks(uint64_t *rng, nsdf_buffer *payload, nsdf_entropy_kind entropy, uint64_t hash) {
    nsdf_blocks_desc d;
    int32_t *q;
    float *values;
    memset(&d, 0, sizeof d);
    d.list.entropy = (uint8_t)entropy;
    d.degree = sample_below(rng, NSDF_MAX_DEGREE + 1);
    d.influences = 1 + sample_below(rng, 3);
    d.bone_count = 1 + sample_below(rng, 4);
    const int shape = (int)sample_below(rng, 3);
    d.block_count = shape == MAKE_SHELL ? 64 : 1 + sample_below(rng, 12);
    d.fade = sample_below(rng, 3) ? (float)(0.2 * sample_unit(rng)) : 0.0f;
    const uint32_t knots = sample_below(rng, 4) ? 4 + sample_below(rng, 8) : 0;
    make_blocks(&d, knots, sample_below(rng, 2) ? 4 + sample_below(rng, 4) : 0, shape,
                sample_below(rng, 4) ? 0 : sample_below(rng, 1 << 11), rng, &q, &values);
    assert_int_equal(nsdf_write_blocks_part(payload, &d, q), 0);
    hash = nsdf_hash_floats(hash, values, (size_t)nsdf_parameter_count(&d.list));
    free(values);
    free(q);
    return hash;
}

/* Appends a network part and carries the hash of the parameters on. */
static uint64_t add_network(uint64_t *rng, nsdf_buffer *payload, nsdf_entropy_kind entropy, int tame, uint64_t hash) {
    nsdf_network_desc d;
    sample_network(rng, &d, entropy);
    int32_t *q = tame ? tame_parameters(rng, &d) : sample_parameters(rng, &d);
    if (!tame)
        spice(rng, &d, q);
    float *values = sample_expected(&d, q);
    assert_int_equal(nsdf_write_network_part(payload, &d, q), 0);
    hash = nsdf_hash_floats(hash, values, (size_t)nsdf_parameter_count(&d.list));
    free(values);
    free(q);
    return hash;
}

/* 0: networks whose field single precision cannot follow, and blocks; 1: tame networks, and blocks; 2: blocks only. */
static void make_random_file(sample_file *file, uint64_t seed, nsdf_entropy_kind entropy, int tame) {
    uint64_t rng = seed;
    nsdf_buffer payloads[MAX_SEGMENTS] = {{0}}, metadata = {0};
    const nsdf_quality_record quality = {{0.5, 0.25}, {1.0, 2.0}, {3.0, 4.0}, 64, 5};
    memset(file, 0, sizeof *file);
    make_random_header(&rng, &file->header);
    file->header.segment_count = 1 + sample_below(&rng, MAX_SEGMENTS);
    uint32_t frame = 0;
    for (uint32_t i = 0; i < file->header.segment_count; i++) {
        const uint32_t parts = 1 + sample_below(&rng, MAX_PARTS);
        nsdf_index_entry *e = &file->entries[i];
        e->first_frame = frame;
        e->last_frame = frame += 1 + sample_below(&rng, 9);
        make_random_reach(&rng, i > 0 ? e - 1 : NULL, e);
        e->parameter_hash = NSDF_HASH_START;
        nsdf_write_segment_start(&payloads[i], parts);
        for (uint32_t p = 0; p < parts; p++)
            e->parameter_hash = tame == 2 || sample_below(&rng, 2)
                                    ? add_blocks(&rng, &payloads[i], entropy, e->parameter_hash)
                                    : add_network(&rng, &payloads[i], entropy, tame, e->parameter_hash);
    }
    file->header.frame_count = frame + 1;
    nsdf_write_metadata(&metadata, "title", "sample");
    nsdf_file_parts parts = {file->header,
                             payloads,
                             file->entries,
                             sample_below(&rng, 2) ? &metadata : NULL,
                             sample_below(&rng, 2) ? &quality : NULL,
                             NULL,
                             0};
    assert_int_equal(nsdf_write_file(&file->bytes, &parts), 0);
    for (uint32_t i = 0; i < MAX_SEGMENTS; i++)
        nsdf_buffer_free(&payloads[i]);
    nsdf_buffer_free(&metadata);
}

static ref_file *open_reference(const void *data, size_t size) {
    ref_file *ref = NULL;
    const char *message = "";
    const ref_status status = ref_open(data, size, &ref, &message);
    if (status != REF_OK)
        fail_msg("the reference refuses the file: %s", message);
    return ref;
}

static nsdf_decoder *open_library(const void *data, size_t size, uint32_t cpu_mask) {
    nsdf_decoder_options options;
    nsdf_decoder *decoder = NULL;
    nsdf_decoder_options_init(&options);
    options.cpu_mask = cpu_mask;
    options.threads = 1;
    assert_int_equal(nsdf_open_memory(&decoder, data, size, &options, NULL), NSDF_OK);
    return decoder;
}

/* ---- Parameters ----------------------------------------------------------------------------------------- */

/* What the files of a test held, so that it can assert that nothing was left out. */
typedef struct coverage {
    uint32_t part[3], degree[4], poses[2], lives, faded_blocks;
    uint32_t input[3], fourier_source[2], kind[3], uniform[2], predict[4], bits[25], large_groups;
} coverage;

static void cover_blocks(coverage *seen, const ref_blocks *b) {
    seen->degree[b->degree]++;
    seen->poses[b->poses.kind]++;
    for (uint32_t k = 0; k < b->block_count; k++) {
        const float *life = b->lives.arrays[0].w + 2 * (size_t)k;
        seen->lives += life[0] > 0.0f && life[1] < 1.0f;
        seen->faded_blocks += life[0] > 0.0f && b->fade > 0.0f;
    }
}

static void cover_network(coverage *seen, const ref_part *part) {
    seen->input[part->input]++;
    if (part->input == 2)
        seen->fourier_source[part->fourier_source]++;
    for (uint32_t i = 0; i < part->layer_count; i++) {
        seen->kind[part->layers[i].weight.kind]++;
        seen->kind[part->layers[i].bias.kind]++;
    }
}

static void cover(coverage *seen, const ref_part *part) {
    seen->part[part->kind]++;
    if (part->kind == NSDF_PART_BLOCKS)
        cover_blocks(seen, &part->blocks);
    else
        cover_network(seen, part);
    for (uint32_t i = 0; i < part->array_count; i++) {
        const ref_array *a = &part->arrays[i];
        seen->uniform[a->uniform]++;
        seen->predict[a->predict]++;
        seen->bits[a->bits]++;
        seen->large_groups += a->uniform && a->bits > 0 && a->count >= 384;
    }
}

static void assert_covered(const coverage *seen) {
    for (int i = 0; i < 3; i++)
        assert_true(seen->input[i] && seen->kind[i]);
    for (int i = 0; i < 2; i++)
        assert_true(seen->fourier_source[i] && seen->uniform[i] && seen->poses[i] && seen->part[1 + i]);
    for (int i = 0; i < 4; i++)
        assert_true(seen->predict[i]);
    for (int i = 0; i < 4; i++)
        assert_true(seen->degree[i]);
    assert_true(seen->lives && seen->faded_blocks);
    assert_true(seen->bits[0] && seen->bits[5] && seen->bits[12] && seen->bits[24] && seen->large_groups);
}

/* The library's parameters of a block part; to be freed. */
static float *decode_blocks(const nsdf_part_ref *part, nsdf_blocks_desc *d) {
    size_t coded;
    assert_int_equal(nsdf_read_blocks_desc(part->data, part->size, d, &coded, NULL), NSDF_PARSE_OK);
    const size_t scratch_size = nsdf_parameter_scratch_size(&d->list);
    void *scratch = malloc(scratch_size ? scratch_size : 1);
    float *values = malloc((size_t)nsdf_parameter_count(&d->list) * sizeof *values);
    assert_true(scratch && values);
    assert_int_equal(nsdf_read_parameters(part->data, part->size, coded, &d->list, scratch, NULL, values, NULL),
                     NSDF_PARSE_OK);
    free(scratch);
    return values;
}

static void assert_same_blocks(const nsdf_part_ref *part, const ref_part *expected) {
    nsdf_blocks_desc d;
    float *values = decode_blocks(part, &d);
    const ref_blocks *b = &expected->blocks;
    assert_true(d.degree == b->degree && d.influences == b->influences && d.fade == b->fade);
    assert_true(d.bone_count == b->bone_count && d.block_count == b->block_count);
    assert_int_equal(nsdf_parameter_count(&d.list), expected->parameter_count);
    assert_memory_equal(values, expected->parameters, (size_t)expected->parameter_count * sizeof *values);
    free(values);
}

static void assert_same_network(const nsdf_part_ref *part, const ref_part *expected) {
    float *values = NULL, matrix[4 * NSDF_MAX_FOURIER];
    assert_int_equal(sample_decode(part->data, part->size, &values, NULL), NSDF_PARSE_OK);
    nsdf_network_desc d;
    size_t coded;
    assert_int_equal(nsdf_read_network_desc(part->data, part->size, &d, &coded, NULL), NSDF_PARSE_OK);
    assert_int_equal(nsdf_parameter_count(&d.list), expected->parameter_count);
    assert_memory_equal(values, expected->parameters, (size_t)expected->parameter_count * sizeof *values);
    if (d.input == NSDF_INPUT_FOURIER && d.fourier_source == NSDF_FOURIER_SEED) {
        nsdf_fourier_matrix(d.fourier_seed, d.fourier_sigma, d.fourier_count, matrix);
        assert_memory_equal(matrix, expected->fourier, 4 * d.fourier_count * sizeof *matrix);
    }
    free(values);
}

static void assert_same_segment(const sample_file *file, uint32_t index, const ref_segment *expected, coverage *seen) {
    const nsdf_index_entry *e = &file->entries[index];
    nsdf_part_ref parts[NSDF_MAX_PARTS];
    uint32_t count;
    assert_int_equal(nsdf_read_parts(file->bytes.data + e->offset + NSDF_CHUNK_HEADER_SIZE,
                                     (size_t)e->size - NSDF_CHUNK_OVERHEAD, parts, &count, NULL),
                     NSDF_PARSE_OK);
    assert_int_equal(count, expected->part_count);
    for (uint32_t p = 0; p < count; p++) {
        assert_int_equal(parts[p].kind, expected->parts[p]->kind);
        if (parts[p].kind == NSDF_PART_BLOCKS)
            assert_same_blocks(&parts[p], expected->parts[p]);
        else
            assert_same_network(&parts[p], expected->parts[p]);
        cover(seen, expected->parts[p]);
    }
    assert_true(expected->hash == e->parameter_hash && expected->stored_hash == e->parameter_hash);
    assert_true(expected->first_frame == e->first_frame && expected->last_frame == e->last_frame);
    assert_true(expected->lead == e->lead && expected->trail == e->trail && expected->fade == e->fade);
    assert_true(expected->smallest_piece == e->smallest_piece);
}

static void assert_same_header(const nsdf_file_header *h, const ref_file *ref) {
    assert_true(ref->rate_num == h->rate_num && ref->rate_den == h->rate_den);
    assert_true(ref->frame_count == h->frame_count && ref->segment_count == h->segment_count);
    assert_memory_equal(ref->box_min, h->box_min, sizeof h->box_min);
    assert_memory_equal(ref->box_max, h->box_max, sizeof h->box_max);
    assert_memory_equal(ref->centre, h->centre, sizeof h->centre);
    assert_true(ref->scale == h->scale);
    assert_memory_equal(ref->domain_min, h->domain_min, sizeof h->domain_min);
    assert_memory_equal(ref->domain_max, h->domain_max, sizeof h->domain_max);
    assert_true(ref->default_resolution == h->default_resolution && ref->extraction_bound == h->extraction_bound);
}

static void check_parameters(nsdf_entropy_kind entropy) {
    coverage seen;
    memset(&seen, 0, sizeof seen);
    if (!nsdf_entropy_available(entropy))
        skip();
    for (uint64_t seed = 0; seed < FILES; seed++) {
        sample_file file;
        make_random_file(&file, 1000 * entropy + seed, entropy, 0);
        ref_file *ref = open_reference(file.bytes.data, file.bytes.size);
        nsdf_decoder *decoder = open_library(file.bytes.data, file.bytes.size, NSDF_CPU_ALL);
        assert_int_equal(nsdf_verify(decoder), NSDF_OK);
        assert_same_header(&file.header, ref);
        for (uint32_t i = 0; i < ref->segment_count; i++) {
            nsdf_segment_info info;
            assert_same_segment(&file, i, &ref->segments[i], &seen);
            assert_int_equal(nsdf_get_segment_info(decoder, i, &info), NSDF_OK);
            assert_int_equal(info.parameter_count, ref->segments[i].parameter_count);
        }
        nsdf_close(&decoder);
        ref_close(&ref);
        nsdf_buffer_free(&file.bytes);
    }
    assert_covered(&seen);
}

static void packed_parameters_are_those_of_the_reference(void **state) {
    (void)state;
    check_parameters(NSDF_ENTROPY_NONE);
}

static void deflated_parameters_are_those_of_the_reference(void **state) {
    (void)state;
    check_parameters(NSDF_ENTROPY_DEFLATE);
}

static void zstd_parameters_are_those_of_the_reference(void **state) {
    (void)state;
    check_parameters(NSDF_ENTROPY_ZSTD);
}

static void range_coded_parameters_are_those_of_the_reference(void **state) {
    (void)state;
    check_parameters(NSDF_ENTROPY_RANGE);
}

/* ---- Field ---------------------------------------------------------------------------------------------- */

/* Points inside the domain, in world units. */
static void make_points(uint64_t *rng, const nsdf_file_header *h, float *xyz) {
    for (int i = 0; i < 3 * POINTS; i++) {
        const int axis = i % 3;
        const double low = (double)h->domain_min[axis], high = (double)h->domain_max[axis];
        xyz[i] = (float)(h->centre[axis] + h->scale * (low + (high - low) * (0.01 + 0.98 * sample_unit(rng))));
    }
}

/* Whether the field jumps within 2e-5 of a point: where a ball ends, the nearest block changes, or the sign does
 * outside of balls.  Rounding may take the point to the other side. */
static int jumps_near(const ref_file *ref, double t, const double point[3], double value) {
    int jumps = 0;
    for (int i = 0; i < 6; i++) {
        double p[3] = {point[0], point[1], point[2]};
        p[i / 2] += (i % 2 ? 2e-5 : -2e-5) * ref->scale;
        jumps |= fabs(ref_evaluate(ref, t, p) - value) > 1e-3 * ref->scale;
    }
    return jumps;
}

/* Returns how many points were let off. */
static uint32_t assert_same_field(nsdf_decoder *decoder, const ref_file *ref, double t, const float *xyz) {
    float distance[POINTS];
    uint32_t jumps = 0;
    assert_int_equal(nsdf_evaluate(decoder, t, xyz, POINTS, distance, NULL), NSDF_OK);
    for (int i = 0; i < POINTS; i++) {
        const double point[3] = {(double)xyz[3 * i], (double)xyz[3 * i + 1], (double)xyz[3 * i + 2]};
        const double expected = ref_evaluate(ref, t, point), error = fabs((double)distance[i] - expected) / ref->scale;
        /* Where no block is there the value is 64, and its last bit 7.6e-6. */
        const double allowed = 1e-5 + 3e-7 * fabs(expected) / ref->scale;
        if (error <= allowed)
            continue;
        if (!jumps_near(ref, t, point, expected))
            fail_msg("at %g s: %.9g, expected %.9g, off by %g of the scale", t, (double)distance[i], expected, error);
        jumps++;
    }
    return jumps;
}

static void check_field(uint32_t cpu_mask) {
    uint32_t jumps = 0;
    for (uint64_t seed = 0; seed < FILES / 2; seed++) {
        uint64_t rng = 77 + seed;
        float xyz[3 * POINTS];
        sample_file file;
        make_random_file(&file, 5000 + seed, NSDF_ENTROPY_RANGE, 1);
        ref_file *ref = open_reference(file.bytes.data, file.bytes.size);
        nsdf_decoder *decoder = open_library(file.bytes.data, file.bytes.size, cpu_mask);
        make_points(&rng, &file.header, xyz);
        double end, t;
        assert_int_equal(nsdf_frame_time(decoder, file.header.frame_count - 1, &end), NSDF_OK);
        jumps += assert_same_field(decoder, ref, -1.0, xyz);
        jumps += assert_same_field(decoder, ref, 2.0 * end, xyz);
        for (uint32_t i = 0; i < file.header.frame_count; i++) {
            assert_int_equal(nsdf_frame_time(decoder, i, &t), NSDF_OK);
            jumps += assert_same_field(decoder, ref, t, xyz);
            jumps += assert_same_field(decoder, ref, end * sample_unit(&rng), xyz);
        }
        nsdf_close(&decoder);
        ref_close(&ref);
        nsdf_buffer_free(&file.bytes);
    }
    assert_true(jumps < 10);
}

/* Whether a point is in a ball of the part at half of the segment's time. */
static int is_inside(const nsdf_blocks_desc *d, const float *values, const double point[3]) {
    int inside = 0;
    for (uint32_t k = 0; k < d->block_count; k++) {
        double p[3];
        reference_to_block(d, values, k, 0.5, point, p);
        inside |= reference_life(d, values, k, 0.5) > 0.0 && p[0] * p[0] + p[1] * p[1] + p[2] * p[2] < 1.0;
    }
    return inside;
}

static void count_places(uint64_t *rng, const sample_file *file, const nsdf_part_ref *part, uint32_t places[3]) {
    nsdf_blocks_desc d;
    const nsdf_file_header *h = &file->header;
    float xyz[3 * POINTS], *values = decode_blocks(part, &d);
    make_points(rng, h, xyz);
    for (int i = 0; i < POINTS; i++) {
        double point[3];
        for (int axis = 0; axis < 3; axis++)
            point[axis] = ((double)xyz[3 * i + axis] - h->centre[axis]) / h->scale;
        const int inside = is_inside(&d, values, point);
        places[inside]++;
        places[2] += !inside && reference_blocks(&d, values, 0.5, point) < 0.0;
    }
    free(values);
}

/* The points of check_field are worth something only if there are many on both sides. */
static void points_lie_in_blocks_and_outside(void **state) {
    (void)state;
    uint32_t places[3] = {0, 0, 0}; /* outside, inside, outside with a negative value */
    for (uint64_t seed = 0; seed < FILES / 2; seed++) {
        uint64_t rng = 77 + seed;
        sample_file file;
        make_random_file(&file, 5000 + seed, NSDF_ENTROPY_RANGE, 1);
        for (uint32_t i = 0; i < file.header.segment_count; i++) {
            nsdf_part_ref parts[NSDF_MAX_PARTS];
            uint32_t count;
            const nsdf_index_entry *e = &file.entries[i];
            assert_int_equal(nsdf_read_parts(file.bytes.data + e->offset + NSDF_CHUNK_HEADER_SIZE,
                                             (size_t)e->size - NSDF_CHUNK_OVERHEAD, parts, &count, NULL),
                             NSDF_PARSE_OK);
            for (uint32_t p = 0; p < count; p++)
                if (parts[p].kind == NSDF_PART_BLOCKS)
                    count_places(&rng, &file, &parts[p], places);
        }
        nsdf_buffer_free(&file.bytes);
    }
    if (places[0] <= 500 || places[1] <= 500 || places[2] <= 20)
        fail_msg("only %u points outside, %u inside, %u outside and negative", places[0], places[1], places[2]);
}

static void plain_c_evaluates_the_field_of_the_reference(void **state) {
    (void)state;
    check_field(0);
}

static void every_kernel_evaluates_the_field_of_the_reference(void **state) {
    (void)state;
    check_field(NSDF_CPU_ALL);
}

/* ---- Damage --------------------------------------------------------------------------------------------- */

static nsdf_status reference_status(const uint8_t *data, size_t size) {
    static const nsdf_status same[] = {
        NSDF_OK,      NSDF_NOT_NSDF, NSDF_UNSUPPORTED_VERSION, NSDF_UNSUPPORTED_FEATURE, NSDF_TRUNCATED, NSDF_CHECKSUM,
        NSDF_CORRUPT, NSDF_NO_MEMORY};
    ref_file *ref;
    const char *message;
    nsdf_status status = same[ref_open(data, size, &ref, &message)];
    for (uint32_t i = 0; ref && i < ref->segment_count; i++)
        status = ref->segments[i].hash == ref->segments[i].stored_hash ? status : NSDF_CHECKSUM;
    ref_close(&ref);
    return status;
}

static nsdf_status library_status(const uint8_t *data, size_t size) {
    nsdf_decoder *decoder = NULL;
    nsdf_status status = nsdf_open_memory(&decoder, data, size, NULL, NULL);
    if (status == NSDF_OK)
        status = nsdf_verify(decoder);
    nsdf_close(&decoder);
    return status;
}

/* Damages one byte of a chunk's payload and makes its CRC-32 right again. */
static void damage(uint64_t *rng, uint8_t *data, uint64_t offset, uint64_t size) {
    uint8_t *chunk = data + offset, *crc = chunk + size - 4;
    /* Descriptions are at the front, and every bit of theirs has a meaning. */
    const uint32_t payload = (uint32_t)size - NSDF_CHUNK_OVERHEAD;
    const uint32_t reach = sample_below(rng, 2) && payload > 60 ? 60 : payload;
    chunk[NSDF_CHUNK_HEADER_SIZE + sample_below(rng, reach)] ^= (uint8_t)(1 << sample_below(rng, 8));
    const uint32_t sum = nsdf_crc32(0, chunk, (size_t)size - 4);
    for (int i = 0; i < 4; i++)
        crc[i] = (uint8_t)(sum >> 8 * i);
}

/* With several faults in a file readers may name any of them, so what the two must agree on is whether the file is
 * sound, has parameters of another hash, or breaks the format. */
static nsdf_status verdict(nsdf_status status) {
    return status == NSDF_TRUNCATED || status == NSDF_UNSUPPORTED_FEATURE ? NSDF_CORRUPT : status;
}

static void check_damage(int tame) {
    uint32_t sound = 0, other_hash = 0, corrupt = 0;
    for (uint64_t round = 0; round < 2000; round++) {
        uint64_t rng = 31 + round;
        sample_file file;
        make_random_file(&file, 9000 + round / 40, round / 40 % 2 ? NSDF_ENTROPY_RANGE : NSDF_ENTROPY_NONE, tame);
        const nsdf_index_entry *e = &file.entries[sample_below(&rng, file.header.segment_count)];
        const uint64_t index_size = nsdf_index_payload_size(file.header.segment_count) + NSDF_CHUNK_OVERHEAD;
        const uint32_t which = sample_below(&rng, 8);
        damage(&rng, file.bytes.data,
               which == 0   ? HEAD_AT
               : which == 1 ? INDEX_AT
                            : e->offset,
               which == 0   ? INDEX_AT - HEAD_AT
               : which == 1 ? index_size
                            : e->size);
        const nsdf_status status = verdict(library_status(file.bytes.data, file.bytes.size));
        if (status != NSDF_LIMIT)
            assert_int_equal(status, verdict(reference_status(file.bytes.data, file.bytes.size)));
        sound += status == NSDF_OK;
        other_hash += status == NSDF_CHECKSUM;
        corrupt += status == NSDF_CORRUPT;
        nsdf_buffer_free(&file.bytes);
    }
    assert_true(sound > 100 && other_hash > 100 && corrupt > 100);
}

static void both_judge_damaged_payloads_alike(void **state) {
    (void)state;
    check_damage(0);
}

static void both_judge_damaged_blocks_alike(void **state) {
    (void)state;
    check_damage(2);
}

static void both_refuse_every_beginning_of_a_file(void **state) {
    (void)state;
    sample_file file;
    make_random_file(&file, 4, NSDF_ENTROPY_RANGE, 1);
    for (size_t size = 0; size < file.bytes.size; size++) {
        uint8_t *exact = malloc(size ? size : 1);
        assert_non_null(exact);
        memcpy(exact, file.bytes.data, size);
        assert_int_equal(reference_status(exact, size), NSDF_TRUNCATED);
        assert_int_equal(library_status(exact, size), NSDF_TRUNCATED);
        free(exact);
    }
    nsdf_buffer_free(&file.bytes);
}

/* ---- Chunks --------------------------------------------------------------------------------------------- */

/* A file of one segment with a chunk more in front of SEGM or behind it. */
static void make_file_with_chunk(nsdf_buffer *out, uint32_t type, uint32_t flags, int behind) {
    nsdf_buffer segment = {0}, payload = {0}, extra = {0};
    nsdf_file_header header;
    uint64_t rng = 5;
    make_random_header(&rng, &header);
    header.frame_count = 2;
    header.segment_count = 1;
    nsdf_write_segment_start(&segment, 1);
    const uint64_t hash = add_network(&rng, &segment, NSDF_ENTROPY_RANGE, 1, NSDF_HASH_START);
    nsdf_write_chunk(&extra, type, flags, "abc", 3);
    const uint64_t index_size = nsdf_index_payload_size(1) + NSDF_CHUNK_OVERHEAD;
    nsdf_write_preamble(out);
    nsdf_write_header(&payload, &header);
    nsdf_write_chunk(out, NSDF_CHUNK_HEAD, NSDF_CHUNK_CRITICAL, payload.data, payload.size);
    payload.size = 0;
    nsdf_buffer_u64(&payload, INDEX_AT + index_size + extra.size + segment.size + 2 * NSDF_CHUNK_OVERHEAD);
    nsdf_buffer_u32(&payload, 0);
    nsdf_buffer_u32(&payload, 1);
    for (int i = 0; i < 4; i++) /* lead, trail, fade, smallest piece */
        nsdf_buffer_u32(&payload, 0);
    nsdf_buffer_u64(&payload, INDEX_AT + index_size + (behind ? 0 : extra.size));
    nsdf_buffer_u64(&payload, segment.size + NSDF_CHUNK_OVERHEAD);
    nsdf_buffer_u64(&payload, hash);
    nsdf_write_chunk(out, NSDF_CHUNK_INDX, NSDF_CHUNK_CRITICAL, payload.data, payload.size);
    nsdf_buffer_append(out, extra.data, behind ? 0 : extra.size);
    nsdf_write_chunk(out, NSDF_CHUNK_SEGM, 0, segment.data, segment.size); /* the flag of a known type is ignored */
    nsdf_buffer_append(out, extra.data, behind ? extra.size : 0);
    nsdf_write_chunk(out, NSDF_CHUNK_ENDF, NSDF_CHUNK_CRITICAL, NULL, 0);
    nsdf_buffer_free(&segment);
    nsdf_buffer_free(&payload);
    nsdf_buffer_free(&extra);
}

static void assert_chunk_gives(uint32_t type, uint32_t flags, nsdf_status expected) {
    for (int behind = 0; behind < 2; behind++) {
        nsdf_buffer file = {0};
        make_file_with_chunk(&file, type, flags, behind);
        assert_int_equal(reference_status(file.data, file.size), expected);
        assert_int_equal(library_status(file.data, file.size), expected);
        nsdf_buffer_free(&file);
    }
}

static void both_skip_unknown_ancillary_chunks(void **state) {
    (void)state;
    assert_chunk_gives(NSDF_CHUNK('a', 'B', '0', 'z'), 0, NSDF_OK);
    assert_chunk_gives(NSDF_CHUNK('a', 'B', '0', 'z'), 0xfffffffe, NSDF_OK);
}

static void both_refuse_unknown_critical_and_misplaced_chunks(void **state) {
    (void)state;
    assert_chunk_gives(NSDF_CHUNK('a', 'B', '0', 'z'), NSDF_CHUNK_CRITICAL, NSDF_UNSUPPORTED_FEATURE);
    assert_chunk_gives(NSDF_CHUNK('a', 'B', ' ', 'z'), 0, NSDF_CORRUPT);
    assert_chunk_gives(NSDF_CHUNK_HEAD, NSDF_CHUNK_CRITICAL, NSDF_CORRUPT);
    assert_chunk_gives(NSDF_CHUNK_INDX, NSDF_CHUNK_CRITICAL, NSDF_CORRUPT);
    assert_chunk_gives(NSDF_CHUNK_SEGM, NSDF_CHUNK_CRITICAL, NSDF_CORRUPT);
    assert_chunk_gives(NSDF_CHUNK_ENDF, NSDF_CHUNK_CRITICAL, NSDF_CORRUPT);
}

/* ---- The text's examples -------------------------------------------------------------------------------- */

/* Section 15. */
static const uint8_t example_file[382] = {
    0x89, 0x4e, 0x53, 0x44, 0x46, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x06, 0x00, 0xba, 0x8f, 0xd1, 0xef, 0x48, 0x45, 0x41,
    0x44, 0x01, 0x00, 0x00, 0x00, 0x80, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x19, 0x00, 0x00, 0x00, 0x01, 0x00,
    0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xf0, 0xbf, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0xf0, 0xbf, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xf0, 0xbf, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0xf0, 0x3f, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xf0, 0x3f, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xf0,
    0x3f, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x40, 0x00, 0x00, 0x00, 0xbf, 0x00,
    0x00, 0x00, 0xbf, 0x00, 0x00, 0x00, 0xbf, 0x00, 0x00, 0x00, 0x3f, 0x00, 0x00, 0x00, 0x3f, 0x00, 0x00, 0x00, 0x3f,
    0x40, 0x00, 0x00, 0x00, 0x00, 0x00, 0xa0, 0x3f, 0x35, 0xf8, 0x44, 0xee, 0x49, 0x4e, 0x44, 0x58, 0x01, 0x00, 0x00,
    0x00, 0x38, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x7e, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x3e, 0xf0, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x7a, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0xeb, 0x45, 0x7c, 0x4a, 0xea, 0xa2, 0x63, 0x8a, 0x28, 0xba, 0xfc, 0x3b, 0x53, 0x45, 0x47, 0x4d, 0x01, 0x00, 0x00,
    0x00, 0x66, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x56, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x00, 0x80, 0x3f, 0x00, 0x00, 0x80,
    0x3f, 0x00, 0x00, 0x00, 0x00, 0x02, 0x00, 0x01, 0x01, 0x00, 0x00, 0x00, 0x01, 0x04, 0xfc, 0xff, 0xff, 0xff, 0x00,
    0x00, 0x80, 0x3e, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x80, 0x3e, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x01, 0x00, 0x04, 0x00, 0x00, 0x00, 0x00, 0x00, 0x80, 0x3e, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x04, 0x00, 0x00, 0x00, 0x00, 0x00, 0x80, 0xbe, 0x03, 0x00, 0x00, 0x00, 0x48, 0x04, 0x44, 0xf1, 0x6f, 0xc9,
    0x8f, 0x45, 0x4e, 0x44, 0x46, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x42, 0x79,
    0xcc, 0x41};

static void the_example_file_is_a_pair_of_planes(void **state) {
    (void)state;
    ref_file *ref = open_reference(example_file, sizeof example_file);
    nsdf_decoder *decoder = open_library(example_file, sizeof example_file, NSDF_CPU_ALL);
    assert_int_equal(nsdf_verify(decoder), NSDF_OK);
    assert_true(ref->segments[0].hash == ref->segments[0].stored_hash);
    for (int i = -8; i <= 8; i++) {
        const double x = i / 8.0, point[3] = {x, 0.5, -0.25}; /* the world's unit is half of the normalised one */
        const float xyz[3] = {(float)x, 0.5f, -0.25f};
        float distance;
        assert_int_equal(nsdf_evaluate(decoder, 0.0, xyz, 1, &distance, NULL), NSDF_OK);
        assert_true(ref_evaluate(ref, 0.0, point) == fabs(x) - 0.5);
        assert_true((double)distance == fabs(x) - 0.5);
    }
    nsdf_close(&decoder);
    ref_close(&ref);
}

/* Array descriptions of 10.1: quantiser uniform, predict none. */
static void append_uniform(nsdf_buffer *b, uint8_t bits, int32_t residual_min) {
    nsdf_buffer_u8(b, NSDF_QUANT_UNIFORM);
    nsdf_buffer_u8(b, bits);
    nsdf_buffer_u32(b, (uint32_t)residual_min);
    nsdf_buffer_f32(b, 1.0f);
    nsdf_buffer_f32(b, 0.0f);
}

/* Layers of 2 and 1; W_0 is low-rank, and its second array is the example of section 10.5. */
static void append_example_part(nsdf_buffer *b) {
    static const uint8_t front[6] = {NSDF_INPUT_XYZ, 0, NSDF_ENTROPY_RANGE, 2, 0, 0};
    static const uint8_t layers[6] = {2, 0, NSDF_ACT_IDENTITY, 1, 0, NSDF_ACT_IDENTITY};
    static const uint8_t low_rank[5] = {NSDF_TENSOR_LOW_RANK, 4, 0, 2, 0};
    static const uint8_t coded[11] = {0xcd, 0x04, 0x58, 0x8c, 0xfc, 0xcf, 0xa1, 0x70, 0xb4, 0x00, 0x00};
    nsdf_buffer_append(b, front, sizeof front);
    nsdf_buffer_f32(b, 1.0f);
    nsdf_buffer_f32(b, 1.0f);
    nsdf_buffer_f32(b, 0.0f);
    nsdf_buffer_append(b, layers, sizeof layers);
    nsdf_buffer_append(b, low_rank, sizeof low_rank);
    append_uniform(b, 0, 0);
    append_uniform(b, 5, -7);
    append_uniform(b, 0, 1);
    for (int i = 0; i < 3; i++) {
        nsdf_buffer_u8(b, NSDF_TENSOR_CONSTANT);
        append_uniform(b, 0, 1);
    }
    nsdf_buffer_u32(b, 0);
    nsdf_buffer_u32(b, sizeof coded);
    nsdf_buffer_append(b, coded, sizeof coded);
}

static void the_example_of_the_range_coder_decodes(void **state) {
    (void)state;
    static const int32_t residuals[12] = {3, -1, 0, 0, 12, -7, 2, -1, 1, 0, 9, -6};
    nsdf_buffer part = {0}, segment = {0}, out = {0};
    nsdf_index_entry entry = {.last_frame = 1};
    nsdf_file_parts parts = {.segments = &segment, .entries = &entry};
    uint64_t rng = 6;
    make_random_header(&rng, &parts.header);
    parts.header.frame_count = 2;
    parts.header.segment_count = 1;
    append_example_part(&part);
    nsdf_write_segment_start(&segment, 1);
    nsdf_buffer_u32(&segment, NSDF_PART_NETWORK);
    nsdf_buffer_u64(&segment, part.size);
    nsdf_buffer_append(&segment, part.data, part.size);
    assert_int_equal(nsdf_write_file(&out, &parts), 0);
    ref_file *ref = open_reference(out.data, out.size);
    assert_memory_equal(ref->segments[0].parts[0]->arrays[1].q, residuals, sizeof residuals);
    ref_close(&ref);
    nsdf_buffer_free(&part);
    nsdf_buffer_free(&segment);
    nsdf_buffer_free(&out);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(packed_parameters_are_those_of_the_reference),
        cmocka_unit_test(deflated_parameters_are_those_of_the_reference),
        cmocka_unit_test(zstd_parameters_are_those_of_the_reference),
        cmocka_unit_test(range_coded_parameters_are_those_of_the_reference),
        cmocka_unit_test(points_lie_in_blocks_and_outside),
        cmocka_unit_test(plain_c_evaluates_the_field_of_the_reference),
        cmocka_unit_test(every_kernel_evaluates_the_field_of_the_reference),
        cmocka_unit_test(both_judge_damaged_payloads_alike),
        cmocka_unit_test(both_judge_damaged_blocks_alike),
        cmocka_unit_test(both_refuse_every_beginning_of_a_file),
        cmocka_unit_test(both_skip_unknown_ancillary_chunks),
        cmocka_unit_test(both_refuse_unknown_critical_and_misplaced_chunks),
        cmocka_unit_test(the_example_file_is_a_pair_of_planes),
        cmocka_unit_test(the_example_of_the_range_coder_decodes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Writes the golden files: make_golden FOLDER, where FOLDER has the folders ok and error.  See tests/golden/README.md.
 *
 * What a decoder must find is not taken from the decoder: the values come from the slow evaluation in make_file.h and
 * make_blocks.h, the statuses from the specification (section "Limits and errors"). */
#include <stdio.h>

#include "make_blocks.h"
#include "nsdf/decoder.h"

enum { POINTS = 64, LAYERS = 3, WIDTH = 12, RAW_WIDTH = 6, SEED = 1, MESH_RESOLUTION = 72 };

/* Where things are in a file of one segment (spec, sections 4 to 9). */
enum {
    HEAD_AT = NSDF_PREAMBLE_SIZE,
    HEAD_PAYLOAD_AT = HEAD_AT + NSDF_CHUNK_HEADER_SIZE,
    INDEX_AT = HEAD_AT + NSDF_HEADER_PAYLOAD_SIZE + NSDF_CHUNK_OVERHEAD,
    INDEX_PAYLOAD_AT = INDEX_AT + NSDF_CHUNK_HEADER_SIZE,
    NOTES_AT = INDEX_AT + 8 + NSDF_INDEX_ENTRY_SIZE + NSDF_CHUNK_OVERHEAD,
    OFFSET_IN_ENTRY = 24,
    HASH_IN_ENTRY = 40
};

static size_t segment_at(const made_file *file) {
    return (size_t)file->entries[0].offset;
}

static size_t part_at(const made_file *file) {
    return segment_at(file) + NSDF_CHUNK_HEADER_SIZE + 4;
}

/* ---- Editing bytes -------------------------------------------------------------------------------------- */

static void store(uint8_t *at, uint64_t value, int bytes) {
    for (int i = 0; i < bytes; i++)
        at[i] = (uint8_t)(value >> 8 * i);
}

static uint64_t load(const uint8_t *at, int bytes) {
    uint64_t value = 0;
    for (int i = 0; i < bytes; i++)
        value |= (uint64_t)at[i] << 8 * i;
    return value;
}

/* Makes the CRC of the chunk right again. */
static void mend(made_file *file, size_t chunk) {
    const size_t covered = NSDF_CHUNK_HEADER_SIZE + (size_t)load(file->data + chunk + 8, 8);
    store(file->data + chunk + covered, nsdf_crc32(0, file->data + chunk, covered), 4);
}

static void mend_preamble(made_file *file) {
    store(file->data + 12, nsdf_crc32(0, file->data, 12), 4);
}

static void insert(made_file *file, size_t at, const void *bytes, size_t count) {
    uint8_t *grown = realloc(file->data, file->size + count);
    assert(grown);
    memmove(grown + at + count, grown + at, file->size - at);
    memcpy(grown + at, bytes, count);
    file->data = grown;
    file->size += count;
}

/* Puts a chunk that nobody knows at `at`, and tells the index. */
static void insert_chunk(made_file *file, size_t at, uint32_t type, uint32_t flags) {
    nsdf_buffer chunk = {NULL, 0, 0, 0};
    uint8_t *offset;
    nsdf_write_chunk(&chunk, type, flags, "of another time", 15);
    insert(file, at, chunk.data, chunk.size);
    store(file->data + INDEX_PAYLOAD_AT, file->size, 8);
    offset = file->data + INDEX_PAYLOAD_AT + 8 + OFFSET_IN_ENTRY;
    if (load(offset, 8) >= at)
        store(offset, load(offset, 8) + chunk.size, 8);
    mend(file, INDEX_AT);
    nsdf_buffer_free(&chunk);
}

/* ---- Output --------------------------------------------------------------------------------------------- */

static FILE *create(const char *folder, const char *kind, const char *name, const char *ending) {
    char path[1024];
    snprintf(path, sizeof path, "%s/%s/%s%s", folder, kind, name, ending);
    FILE *file = fopen(path, "wb");
    if (!file) {
        fprintf(stderr, "make_golden: cannot write %s\n", path);
        exit(1);
    }
    return file;
}

static void write_bytes(const char *folder, const char *kind, const char *name, const made_file *file) {
    FILE *out = create(folder, kind, name, ".nsdf");
    fwrite(file->data, 1, file->size, out);
    if (fclose(out) != 0)
        exit(1);
}

/* ---- Files that decode ---------------------------------------------------------------------------------- */

static uint64_t hash_of(const made_file *file) {
    uint64_t hash = NSDF_HASH_START;
    if (file->header.segment_count == 1)
        return file->entries[0].parameter_hash;
    for (uint32_t i = 0; i < file->header.segment_count; i++) {
        uint8_t bytes[8];
        store(bytes, file->entries[i].parameter_hash, 8);
        hash = nsdf_hash64(hash, bytes, sizeof bytes);
    }
    return hash;
}

static double time_of(const nsdf_file_header *header, int64_t frame) {
    return (double)(frame * (int64_t)header->rate_den) / header->rate_num;
}

/* Of segment `s` at a normalised position; its only part is `blocks` if not NULL. */
static double segment_value(const made_file *file, const nsdf_blocks_desc *blocks, uint32_t s, double t,
                            const double normalised[3]) {
    const nsdf_index_entry *e = &file->entries[s];
    const double start = time_of(&file->header, (int64_t)e->first_frame - e->lead);
    const double u = (t - start) / (time_of(&file->header, (int64_t)e->last_frame + e->trail) - start);
    return blocks ? reference_blocks(blocks, file->values[s], u, normalised)
                  : reference_value(&file->desc[s], file->values[s], u, normalised);
}

/* Signed distance in world units (spec, sections 2 and 11). */
static double value_at(const made_file *file, const nsdf_blocks_desc *blocks, double t, const double world[3]) {
    uint32_t s = 0;
    while (s + 1 < file->header.segment_count && t >= time_of(&file->header, file->entries[s].last_frame))
        s++;
    double normalised[3];
    for (int a = 0; a < 3; a++)
        normalised[a] = (world[a] - file->header.centre[a]) / file->header.scale;
    double value = segment_value(file, blocks, s, t, normalised);
    const uint32_t second = file->header.segment_count - 1; /* of two at most */
    const double middle = time_of(&file->header, file->entries[second].first_frame);
    const double half = time_of(&file->header, file->entries[second].fade);
    if (second > 0 && fabs(t - middle) < half) {
        const double p = (t - middle + half) / (2.0 * half), share = p * p * (3.0 - 2.0 * p);
        value = (1.0 - share) * segment_value(file, blocks, 0, t, normalised) +
                share * segment_value(file, blocks, 1, t, normalised);
    }
    return file->header.scale * value;
}

/* Coordinates and times of few digits; the first and the last time are the ends of the sequence. */
static void write_points(FILE *out, const made_file *file, const nsdf_blocks_desc *blocks) {
    const nsdf_file_header *h = &file->header;
    const double duration = time_of(h, h->frame_count - 1);
    uint64_t random = SEED;
    for (int i = 0; i < POINTS; i++) {
        const double t = i + 1 == POINTS ? duration : floor(64.0 * duration * i / (POINTS - 1)) / 64.0;
        double world[3];
        for (int a = 0; a < 3; a++) {
            const double middle = 0.5 * ((double)h->domain_min[a] + (double)h->domain_max[a]);
            const double half = 0.48 * ((double)h->domain_max[a] - (double)h->domain_min[a]);
            const double p = h->centre[a] + h->scale * (middle + half * make_uniform(&random));
            world[a] = floor(64.0 * p) / 64.0;
        }
        fprintf(out, "point %.17g %.9g %.9g %.9g %.9f\n", t, world[0], world[1], world[2],
                value_at(file, blocks, t, world));
    }
}

/* ---- Meshes: counted from signs of the values, which the surface separates -------------------------------- */

/* Points in the middle of the grid's cells, or at their corners. */
typedef struct lattice {
    uint32_t points[3];
    uint8_t *inside; /* [z][y][x] */
} lattice;

static size_t lattice_index(const lattice *l, uint32_t x, uint32_t y, uint32_t z) {
    return ((size_t)z * l->points[1] + y) * l->points[0] + x;
}

/* Sides of the domain are multiples of the cells' side.  Corners on the border count as outside: meshes are closed
 * there.  `blocks` as for value_at. */
static lattice sample_signs(const made_file *file, const nsdf_blocks_desc *blocks, double t, uint32_t resolution,
                            int corners) {
    const nsdf_file_header *h = &file->header;
    const double step = ((double)h->domain_max[0] - (double)h->domain_min[0]) / resolution;
    lattice l;
    for (int a = 0; a < 3; a++)
        l.points[a] =
            (uint32_t)lround(((double)h->domain_max[a] - (double)h->domain_min[a]) / step) + (corners ? 1 : 0);
    l.inside = calloc((size_t)l.points[0] * l.points[1] * l.points[2], 1);
    assert(l.inside);
    const uint32_t border = corners ? 1 : 0;
    for (uint32_t z = border; z + border < l.points[2]; z++)
        for (uint32_t y = border; y + border < l.points[1]; y++)
            for (uint32_t x = border; x + border < l.points[0]; x++) {
                const uint32_t at[3] = {x, y, z};
                double world[3];
                for (int a = 0; a < 3; a++)
                    world[a] =
                        h->centre[a] + h->scale * ((double)h->domain_min[a] + step * (at[a] + (corners ? 0.0 : 0.5)));
                l.inside[lattice_index(&l, x, y, z)] = value_at(file, blocks, t, world) < 0.0;
            }
    return l;
}

/* How often the sign changes along the lines of the lattice, beyond which is outside. */
static uint32_t count_changes(const lattice *l) {
    uint32_t changes = 0;
    for (uint32_t z = 0; z < l->points[2]; z++)
        for (uint32_t y = 0; y < l->points[1]; y++)
            for (uint32_t x = 0; x < l->points[0]; x++) {
                const uint8_t here = l->inside[lattice_index(l, x, y, z)];
                changes += here != (x > 0 ? l->inside[lattice_index(l, x - 1, y, z)] : 0);
                changes += here != (y > 0 ? l->inside[lattice_index(l, x, y - 1, z)] : 0);
                changes += here != (z > 0 ? l->inside[lattice_index(l, x, y, z - 1)] : 0);
                changes += here && x + 1 == l->points[0];
                changes += here && y + 1 == l->points[1];
                changes += here && z + 1 == l->points[2];
            }
    return changes;
}

static uint32_t count_inside(const lattice *l) {
    uint32_t count = 0;
    for (size_t i = 0; i < (size_t)l->points[0] * l->points[1] * l->points[2]; i++)
        count += l->inside[i];
    return count;
}

/* One vertex for each edge of the grid that the surface crosses.  A line through the middles of cells that crosses it
 * stands for the area of a cell's side, a middle inside it for a cell's volume. */
static void write_mesh(FILE *out, const made_file *file, const nsdf_blocks_desc *blocks) {
    const nsdf_file_header *h = &file->header;
    const double t = floor(64.0 * 0.4 * time_of(h, h->frame_count - 1)) / 64.0;
    const double side = h->scale * ((double)h->domain_max[0] - (double)h->domain_min[0]) / MESH_RESOLUTION;
    lattice corners = sample_signs(file, blocks, t, MESH_RESOLUTION, 1);
    lattice middles = sample_signs(file, blocks, t, MESH_RESOLUTION, 0);
    fprintf(out, "mesh %.17g %d %u %.6g %.6g\n", t, MESH_RESOLUTION, count_changes(&corners),
            side * side * count_changes(&middles), side * side * side * count_inside(&middles));
    free(corners.inside);
    free(middles.inside);
}

/* `blocks` as for value_at. */
static void write_ok(const char *folder, const char *name, made_file *file, const nsdf_blocks_desc *blocks) {
    write_bytes(folder, "ok", name, file);
    FILE *out = create(folder, "ok", name, ".expect");
    for (uint32_t i = 0; i < file->header.segment_count; i++) {
        if (file->desc[i].list.entropy == NSDF_ENTROPY_DEFLATE)
            fprintf(out, "needs deflate\n");
        if (file->desc[i].list.entropy == NSDF_ENTROPY_ZSTD)
            fprintf(out, "needs zstd\n");
    }
    fprintf(out, "hash %016llx\nscale %.17g\n", (unsigned long long)hash_of(file), file->header.scale);
    write_points(out, file, blocks);
    write_mesh(out, file, blocks);
    if (fclose(out) != 0)
        exit(1);
    free_file(file);
}

static void make_raw_file(made_file *file) {
    nsdf_buffer payload = {NULL, 0, 0, 0};
    uint64_t random = SEED;
    memset(file, 0, sizeof *file);
    nsdf_network_desc *desc = &file->desc[0];
    make_network(desc, MAKE_SPLINE, LAYERS, RAW_WIDTH, NSDF_ENTROPY_NONE);
    for (uint32_t t = 0; t < desc->list.count; t++)
        for (uint32_t k = 0; k < desc->list.tensors[t].array_count; k++) {
            nsdf_array_desc *array = &desc->list.tensors[t].arrays[k];
            array->quantiser = NSDF_QUANT_RAW;
            array->step = array->offset = 0.0f;
        }
    make_segment_of(file, 0, &random, &payload);
    make_container(file, 1, &payload);
}

/* Two segments with a cross-fade over four of their eight frame steps. */
static void make_fading_file(made_file *file) {
    nsdf_buffer payloads[2] = {{NULL, 0, 0, 0}, {NULL, 0, 0, 0}};
    uint64_t random = SEED;
    memset(file, 0, sizeof *file);
    for (uint32_t i = 0; i < 2; i++)
        make_segment(file, i, MAKE_SPLINE, NSDF_ENTROPY_RANGE, LAYERS, WIDTH, &random, &payloads[i]);
    file->entries[0].trail = file->entries[1].lead = 3;
    file->entries[1].fade = 2;
    file->entries[1].smallest_piece = 0.0625f;
    make_container(file, 2, payloads);
}

/* Between INDX and QUAL, before the segment and behind it, with reserved flags set. */
static void make_file_with_unknown_chunks(made_file *file) {
    const uint32_t reserved = 0x80000002u;
    make_sized_file(file, 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE, LAYERS, WIDTH, SEED);
    insert_chunk(file, segment_at(file) + (size_t)file->entries[0].size, NSDF_CHUNK('L', 'A', 'S', 'T'), 0);
    insert_chunk(file, segment_at(file), NSDF_CHUNK('x', '0', '1', 'y'), reserved);
    insert_chunk(file, NOTES_AT, NSDF_CHUNK('A', 'N', 'C', 'I'), reserved);
}

/* Blocks of every kind of life on two bones that move along lines, which the range coder's prediction follows; with
 * `bad_bone` the last block is on the bone behind the last. */
static void make_blocks_file(made_file *file, nsdf_blocks_desc *blocks, int bad_bone) {
    nsdf_buffer payload = {NULL, 0, 0, 0};
    uint64_t random = SEED;
    int32_t *q;
    memset(file, 0, sizeof *file);
    memset(blocks, 0, sizeof *blocks);
    blocks->list.entropy = NSDF_ENTROPY_RANGE;
    blocks->degree = NSDF_MAX_DEGREE;
    blocks->influences = 2;
    blocks->bone_count = 2;
    blocks->block_count = 8;
    blocks->fade = 0.125f;
    make_blocks(blocks, 7, 5, MAKE_SMOOTH, 0, &random, &q, &file->values[0]);
    if (bad_bone) {
        const size_t last = nsdf_block_offset(blocks, NSDF_BLOCK_WEIGHTS) - 1;
        q[last] = (int32_t)blocks->bone_count;
        file->values[0][last] = (float)blocks->bone_count;
    }
    nsdf_write_segment_start(&payload, 1);
    const int failed = nsdf_write_blocks_part(&payload, blocks, q);
    assert(!failed && blocks->list.tensors[NSDF_BLOCK_POSES].arrays[0].predict == NSDF_PREDICT_LINEAR);
    (void)failed;
    free(q);
    file->entries[0].parameter_hash =
        nsdf_hash_floats(NSDF_HASH_START, file->values[0], (size_t)nsdf_parameter_count(&blocks->list));
    file->entries[0].last_frame = 4;
    make_container(file, 1, &payload);
}

static void make_ok_files(const char *folder) {
    static const struct {
        const char *name;
        uint32_t segments;
        int shape;
        nsdf_entropy_kind entropy;
    } plain[] = {
        {"spline_none", 1, MAKE_SPLINE, NSDF_ENTROPY_NONE},
        {"spline_deflate", 1, MAKE_SPLINE, NSDF_ENTROPY_DEFLATE},
        {"spline_zstd", 1, MAKE_SPLINE, NSDF_ENTROPY_ZSTD},
        {"spline_range", 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE},
        {"low_rank", 1, MAKE_LOW_RANK, NSDF_ENTROPY_RANGE},
        {"time_relu_tanh", 1, MAKE_TIME, NSDF_ENTROPY_RANGE},
        {"fourier_seed", 1, MAKE_FOURIER_SEED, NSDF_ENTROPY_RANGE},
        {"fourier_stored", 1, MAKE_FOURIER_STORED, NSDF_ENTROPY_RANGE},
        {"two_segments", 2, MAKE_SPLINE, NSDF_ENTROPY_RANGE}, /* the second: xyzt, without a back end */
    };
    made_file file;
    nsdf_blocks_desc blocks;
    for (size_t i = 0; i < sizeof plain / sizeof *plain; i++) {
        make_sized_file(&file, plain[i].segments, plain[i].shape, plain[i].entropy, LAYERS, WIDTH, SEED);
        write_ok(folder, plain[i].name, &file, NULL);
    }
    make_fading_file(&file);
    write_ok(folder, "cross_fade", &file, NULL);
    make_raw_file(&file);
    write_ok(folder, "raw_float32", &file, NULL);
    make_file_with_unknown_chunks(&file);
    write_ok(folder, "unknown_chunks", &file, NULL);
    make_blocks_file(&file, &blocks, 0);
    write_ok(folder, "blocks", &file, &blocks);
}

/* ---- Files that are refused ----------------------------------------------------------------------------- */

static void empty(made_file *file) {
    file->size = 0;
}

static void text(made_file *file) {
    file->size = (size_t)snprintf((char *)file->data, file->size, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
}

/* What a transfer as text makes of the signature: CR LF becomes LF. */
static void line_ends(made_file *file) {
    memmove(file->data + 5, file->data + 6, --file->size - 5);
}

static void newer_major(made_file *file) {
    file->data[9]++; /* the CRC stays wrong: the version counts first */
}

static void other_minor(made_file *file) {
    file->data[10]++;
    mend_preamble(file);
}

static void preamble_crc(made_file *file) {
    file->data[11] ^= 1;
}

static void head_crc(made_file *file) {
    file->data[HEAD_PAYLOAD_AT] ^= 1;
}

static void segment_crc(made_file *file) {
    file->data[file->size - 30] ^= 1;
}

static void parameter_hash(made_file *file) {
    file->data[INDEX_PAYLOAD_AT + 8 + HASH_IN_ENTRY] ^= 1;
    mend(file, INDEX_AT);
}

static void unknown_critical_chunk(made_file *file) {
    insert_chunk(file, NOTES_AT, NSDF_CHUNK('C', 'R', 'I', 'T'), NSDF_CHUNK_CRITICAL);
}

static void unknown_part(made_file *file) {
    store(file->data + part_at(file), 99, 2);
    mend(file, segment_at(file));
}

static void cut_in_head(made_file *file) {
    file->size = HEAD_PAYLOAD_AT + 40;
}

static void cut_in_segment(made_file *file) {
    file->size = segment_at(file) + 100;
}

static void cut_before_the_end(made_file *file) {
    file->size--;
}

static void bytes_behind_the_end(made_file *file) {
    insert(file, file->size, "\n", 1);
}

static void rate_zero(made_file *file) {
    store(file->data + HEAD_PAYLOAD_AT, 0, 4);
    mend(file, HEAD_AT);
}

static void box_not_a_number(made_file *file) {
    store(file->data + HEAD_PAYLOAD_AT + 16, UINT64_C(0x7ff8000000000000), 8);
    mend(file, HEAD_AT);
}

/* Input 7: the first byte of the part's description. */
static void unknown_input(made_file *file) {
    file->data[part_at(file) + 12] = 7;
    mend(file, segment_at(file));
}

/* All else is sound: CRCs and the parameter hash. */
static void bone_out_of_range(made_file *file) {
    nsdf_blocks_desc blocks;
    free_file(file);
    make_blocks_file(file, &blocks, 1);
}

static void segment_inside_the_index(made_file *file) {
    store(file->data + INDEX_PAYLOAD_AT + 8 + OFFSET_IN_ENTRY, INDEX_AT, 8);
    mend(file, INDEX_AT);
}

static void make_error_files(const char *folder) {
    static const struct {
        const char *name;
        void (*damage)(made_file *file);
        nsdf_status status;
    } cases[] = {
        {"empty", empty, NSDF_TRUNCATED},
        {"text", text, NSDF_NOT_NSDF},
        {"line_ends", line_ends, NSDF_NOT_NSDF},
        {"newer_major", newer_major, NSDF_UNSUPPORTED_VERSION},
        {"other_minor", other_minor, NSDF_UNSUPPORTED_VERSION},
        {"preamble_crc", preamble_crc, NSDF_CHECKSUM},
        {"head_crc", head_crc, NSDF_CHECKSUM},
        {"segment_crc", segment_crc, NSDF_CHECKSUM},
        {"parameter_hash", parameter_hash, NSDF_CHECKSUM},
        {"unknown_critical_chunk", unknown_critical_chunk, NSDF_UNSUPPORTED_FEATURE},
        {"unknown_part", unknown_part, NSDF_UNSUPPORTED_FEATURE},
        {"cut_in_head", cut_in_head, NSDF_TRUNCATED},
        {"cut_in_segment", cut_in_segment, NSDF_TRUNCATED},
        {"cut_before_the_end", cut_before_the_end, NSDF_TRUNCATED},
        {"bytes_behind_the_end", bytes_behind_the_end, NSDF_CORRUPT},
        {"rate_zero", rate_zero, NSDF_CORRUPT},
        {"box_not_a_number", box_not_a_number, NSDF_CORRUPT},
        {"unknown_input", unknown_input, NSDF_CORRUPT},
        {"bone_out_of_range", bone_out_of_range, NSDF_CORRUPT},
        {"segment_inside_the_index", segment_inside_the_index, NSDF_CORRUPT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        made_file file;
        make_sized_file(&file, 1, MAKE_SPLINE, NSDF_ENTROPY_RANGE, 2, 3, SEED);
        cases[i].damage(&file);
        write_bytes(folder, "error", cases[i].name, &file);
        FILE *out = create(folder, "error", cases[i].name, ".expect");
        fprintf(out, "status %d\n", (int)cases[i].status);
        if (fclose(out) != 0)
            exit(1);
        free_file(&file);
    }
}

int main(int argc, char **argv) {
    if (argc != 2) {
        fprintf(stderr, "usage: make_golden FOLDER\n");
        return 2;
    }
    if (!nsdf_entropy_available(NSDF_ENTROPY_DEFLATE) || !nsdf_entropy_available(NSDF_ENTROPY_ZSTD)) {
        fprintf(stderr, "make_golden: needs a build with zlib and zstd\n");
        return 1;
    }
    make_ok_files(argv[1]);
    make_error_files(argv[1]);
    return 0;
}

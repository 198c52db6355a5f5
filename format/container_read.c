#include <math.h>
#include <string.h>

#include "bytes.h"

/* Spec, section "Preamble". */
static const uint8_t signature[9] = {0x89, 'N', 'S', 'D', 'F', 0x0d, 0x0a, 0x1a, 0x0a};

/* Largest magnitude of coordinates in a header, so that no later sum or product overflows a float. */
static const double max_coordinate = 1e30;

static void read_signature(nsdf_cursor *c) {
    for (size_t i = 0; i < sizeof signature; i++) {
        uint8_t byte = nsdf_take_u8(c);
        if (byte != signature[i])
            nsdf_cursor_fail(c, NSDF_PARSE_NOT_NSDF, i, "not the signature of an .nsdf file");
    }
}

nsdf_parse nsdf_read_preamble(const uint8_t *data, size_t size, nsdf_version_fields *version, nsdf_fault *fault) {
    nsdf_cursor c = nsdf_cursor_start(data, size, 0);
    read_signature(&c);
    nsdf_version_fields found = {nsdf_take_u8(&c), 0};
    found.minor = nsdf_take_u8(&c);
    if (c.status == NSDF_PARSE_OK) {
        *version = found;
        if (found.major > NSDF_FORMAT_MAJOR)
            nsdf_cursor_fail(&c, NSDF_PARSE_VERSION, 9, "a newer major version than 0");
    }
    nsdf_take_u8(&c);
    uint32_t crc = nsdf_take_u32(&c);
    if (c.status == NSDF_PARSE_OK && crc != nsdf_crc32(0, data, 12))
        nsdf_cursor_fail(&c, NSDF_PARSE_CHECKSUM, 12, "the CRC-32 of the preamble does not match");
    /* While major is 0 the bitstream is not frozen: minor versions differ without notice. */
    if (c.status == NSDF_PARSE_OK && found.minor != NSDF_FORMAT_MINOR)
        nsdf_cursor_fail(&c, NSDF_PARSE_VERSION, 10, "another minor version, while the format is not frozen");
    return nsdf_cursor_finish(&c, fault);
}

static int is_type_letter(uint32_t byte) {
    return (byte >= 'A' && byte <= 'Z') || (byte >= 'a' && byte <= 'z') || (byte >= '0' && byte <= '9');
}

nsdf_parse nsdf_read_chunk_header(const uint8_t *data, size_t size, nsdf_chunk_header *header, nsdf_fault *fault) {
    nsdf_cursor c = nsdf_cursor_start(data, size, 0);
    nsdf_chunk_header found = {.type = nsdf_take_u32(&c)};
    for (uint32_t i = 0; i < 4; i++)
        nsdf_cursor_expect(&c, is_type_letter(found.type >> 8 * i & 0xff), i,
                           "chunk type is not four ASCII letters or digits");
    found.flags = nsdf_take_u32(&c);
    found.length = nsdf_take_u64(&c);
    nsdf_cursor_expect(&c, found.length <= INT64_MAX, 8, "chunk length above 2^63 - 1");
    if (c.status == NSDF_PARSE_OK)
        *header = found;
    return nsdf_cursor_finish(&c, fault);
}

nsdf_parse nsdf_check_chunk(const uint8_t *chunk, const nsdf_chunk_header *header, nsdf_fault *fault) {
    size_t covered = (size_t)header->length + NSDF_CHUNK_HEADER_SIZE;
    nsdf_cursor c = nsdf_cursor_start(chunk, covered + 4, covered);
    if (nsdf_take_u32(&c) != nsdf_crc32(0, chunk, covered))
        nsdf_cursor_fail(&c, NSDF_PARSE_CHECKSUM, covered, "the CRC-32 of a chunk does not match");
    return nsdf_cursor_finish(&c, fault);
}

static void read_counts(nsdf_cursor *c, nsdf_file_header *h) {
    h->rate_num = nsdf_take_u32(c);
    h->rate_den = nsdf_take_u32(c);
    h->frame_count = nsdf_take_u32(c);
    h->segment_count = nsdf_take_u32(c);
    nsdf_cursor_expect(c, h->rate_num > 0, 0, "frame rate with numerator 0");
    nsdf_cursor_expect(c, h->rate_den > 0, 4, "frame rate with denominator 0");
    nsdf_cursor_expect(c, h->frame_count > 0, 8, "frame count 0, expected at least 1");
    uint32_t most = h->frame_count > 1 ? h->frame_count - 1 : 1;
    nsdf_cursor_expect(c, h->segment_count >= 1 && h->segment_count <= NSDF_MAX_SEGMENTS, 12,
                       "segment count outside 1 to 1048576");
    nsdf_cursor_expect(c, h->segment_count <= most, 12, "more segments than steps between frames");
}

static double read_coordinate(nsdf_cursor *c) {
    size_t at = c->at;
    double v = nsdf_take_f64(c);
    nsdf_cursor_expect(c, fabs(v) <= max_coordinate, at, "coordinate not finite or above 1e30");
    return v;
}

static void read_geometry(nsdf_cursor *c, nsdf_file_header *h) {
    for (int i = 0; i < 3; i++)
        h->box_min[i] = read_coordinate(c);
    for (int i = 0; i < 3; i++) {
        h->box_max[i] = read_coordinate(c);
        nsdf_cursor_expect(c, h->box_min[i] <= h->box_max[i], c->at - 8, "box with its maximum below its minimum");
    }
    for (int i = 0; i < 3; i++)
        h->centre[i] = read_coordinate(c);
    h->scale = nsdf_take_f64(c);
    nsdf_cursor_expect(c, h->scale >= 1 / max_coordinate && h->scale <= max_coordinate, c->at - 8,
                       "scale outside 1e-30 to 1e30");
}

static void read_domain(nsdf_cursor *c, nsdf_file_header *h) {
    for (int i = 0; i < 3; i++) {
        h->domain_min[i] = nsdf_take_f32(c);
        nsdf_cursor_expect(c, fabsf(h->domain_min[i]) <= 16.0f, c->at - 4, "domain outside -16 to 16");
    }
    for (int i = 0; i < 3; i++) {
        h->domain_max[i] = nsdf_take_f32(c);
        nsdf_cursor_expect(c, fabsf(h->domain_max[i]) <= 16.0f, c->at - 4, "domain outside -16 to 16");
        nsdf_cursor_expect(c, h->domain_min[i] < h->domain_max[i], c->at - 4, "domain that is empty along an axis");
    }
}

nsdf_parse nsdf_read_header(const uint8_t *payload, size_t size, nsdf_file_header *header, nsdf_fault *fault) {
    nsdf_cursor c = nsdf_cursor_start(payload, size, 0);
    nsdf_file_header h;
    memset(&h, 0, sizeof h);
    read_counts(&c, &h);
    read_geometry(&c, &h);
    read_domain(&c, &h);
    h.default_resolution = nsdf_take_u32(&c);
    nsdf_cursor_expect(&c, h.default_resolution >= 2 && h.default_resolution <= NSDF_MAX_RESOLUTION, c.at - 4,
                       "default resolution outside 2 to 4096");
    h.extraction_bound = nsdf_take_f32(&c);
    nsdf_cursor_expect(&c, h.extraction_bound > 0.0f && h.extraction_bound <= 1e6f, c.at - 4,
                       "extraction bound not above 0 and at most 1e6");
    if (c.status == NSDF_PARSE_OK)
        *header = h;
    return nsdf_cursor_finish(&c, fault);
}

/* Whether a cross-fade leaves the segments on its two sides what they need: models that reach over it, and no two
 * cross-fades at one time. */
static int fade_fits(const nsdf_index_entry *before, const nsdf_index_entry *e) {
    return before && (int64_t)e->fade <= e->lead && (int64_t)e->fade <= before->trail &&
           e->fade <= e->last_frame - e->first_frame &&
           (uint64_t)before->fade + e->fade <= before->last_frame - before->first_frame;
}

static void read_span(nsdf_cursor *c, const nsdf_file_header *header, const nsdf_index_entry *before,
                      nsdf_index_entry *e) {
    const size_t at = c->at;
    const uint32_t frame = before ? before->last_frame : 0;
    e->first_frame = nsdf_take_u32(c);
    e->last_frame = nsdf_take_u32(c);
    e->lead = nsdf_take_i32(c);
    e->trail = nsdf_take_i32(c);
    e->fade = nsdf_take_u32(c);
    e->smallest_piece = nsdf_take_f32(c);
    const int ascends = e->last_frame > e->first_frame || header->frame_count == 1;
    nsdf_cursor_expect(c, e->first_frame == frame, at, "segment that does not begin where the one before ends");
    nsdf_cursor_expect(c, ascends && e->last_frame < header->frame_count, at + 4,
                       "segment whose last frame is not above its first or not below the frame count");
    nsdf_cursor_expect(c, (int64_t)e->first_frame - e->lead <= (int64_t)e->last_frame + e->trail, at + 8,
                       "lead and trail that put the end of a model before its start");
    nsdf_cursor_expect(c, e->fade == 0 || fade_fits(before, e), at + 16,
                       "cross-fade longer than the segments on its sides allow");
    nsdf_cursor_expect(c, e->smallest_piece >= 0.0f && e->smallest_piece <= 64.0f, at + 20,
                       "smallest piece outside 0 to 64");
}

/* Reads one entry; `before` is the one before, NULL for the first; `end` is where its chunk ends. */
static void read_index_entry(nsdf_cursor *c, const nsdf_file_header *header, uint64_t file_size,
                             const nsdf_index_entry *before, uint64_t end, nsdf_index_entry *e) {
    read_span(c, header, before, e);
    const size_t at = c->at;
    e->offset = nsdf_take_u64(c);
    e->size = nsdf_take_u64(c);
    e->parameter_hash = nsdf_take_u64(c);
    nsdf_cursor_expect(c, e->offset >= end, at, "segment offset inside what lies before it");
    nsdf_cursor_expect(c, e->offset <= file_size && e->size <= file_size - e->offset, at + 8,
                       "segment that ends behind the end of the file");
    nsdf_cursor_expect(c, e->size >= NSDF_CHUNK_OVERHEAD, at + 8, "segment size too small for a chunk");
}

nsdf_parse nsdf_read_index(const uint8_t *payload, size_t size, const nsdf_file_header *header,
                           nsdf_index_entry *entries, uint64_t *file_size, nsdf_fault *fault) {
    nsdf_cursor c = nsdf_cursor_start(payload, size, 0);
    uint64_t total = nsdf_take_u64(&c), room = 0;
    uint64_t end = NSDF_PREAMBLE_SIZE + NSDF_HEADER_PAYLOAD_SIZE + 2 * NSDF_CHUNK_OVERHEAD +
                   nsdf_index_payload_size(header->segment_count);
    nsdf_cursor_expect(&c, total >= end + NSDF_CHUNK_OVERHEAD && total <= INT64_MAX, 0,
                       "file size too small for the chunks that every file has, or above 2^63 - 1");
    if (c.status == NSDF_PARSE_OK)
        room = total - NSDF_CHUNK_OVERHEAD; /* ENDF stands behind the last segment */
    const nsdf_index_entry *before = NULL;
    for (uint32_t i = 0; i < header->segment_count && c.status == NSDF_PARSE_OK; i++) {
        read_index_entry(&c, header, room, before, end, &entries[i]);
        before = &entries[i];
        end = before->offset + before->size;
    }
    nsdf_cursor_expect(&c, before && before->last_frame == header->frame_count - 1, c.at - NSDF_INDEX_ENTRY_SIZE + 4,
                       "last segment that does not end on the last frame");
    if (c.status == NSDF_PARSE_OK)
        *file_size = total;
    return nsdf_cursor_finish(&c, fault);
}

nsdf_parse nsdf_read_quality(const uint8_t *payload, size_t size, nsdf_quality_record *quality, nsdf_fault *fault) {
    nsdf_cursor c = nsdf_cursor_start(payload, size, 0);
    nsdf_quality_record q;
    double *const fields[6] = {&q.mean[0], &q.mean[1], &q.rms[0], &q.rms[1], &q.max[0], &q.max[1]};
    for (int i = 0; i < 6; i++) {
        *fields[i] = nsdf_take_f64(&c);
        nsdf_cursor_expect(&c, *fields[i] >= 0.0 && *fields[i] <= max_coordinate, c.at - 8,
                           "measured error negative, not finite or above 1e30");
    }
    q.resolution = nsdf_take_u32(&c);
    q.frames = nsdf_take_u32(&c);
    if (c.status == NSDF_PARSE_OK)
        *quality = q;
    return nsdf_cursor_finish(&c, fault);
}

/* Feeds damaged .nsdf files to the decoder, in exact-size heap blocks, so that AddressSanitizer sees every byte read
 * beyond them.  Three kinds of damage:
 *   every prefix              must be refused
 *   one bit flipped           must be refused when everything is checked
 *   bytes changed, CRCs mended   may be accepted: the parsers and the evaluation behind the CRCs must stand it
 * Whatever opens is then used: evaluated, extracted at a tiny resolution, verified.  Any status is fine there.
 * usage: replay_hostile [--flips N] FILE.nsdf... */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "container_read.h"
#include "nsdf/decoder.h"

enum { RESOLUTION = 6 };

static const uint64_t memory_limit = (uint64_t)64 << 20;

typedef struct bytes {
    uint8_t *data;
    size_t size;
} bytes;

typedef struct tally {
    unsigned long tried, refused, used, wrongly_opened;
} tally;

static uint64_t next_random(uint64_t *state) {
    uint64_t z = *state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static bytes copy_of(const uint8_t *data, size_t size) {
    bytes copy = {malloc(size ? size : 1), size};
    if (!copy.data) {
        fprintf(stderr, "replay_hostile: out of memory\n");
        exit(EXIT_FAILURE);
    }
    memcpy(copy.data, data, size);
    return copy;
}

static bytes read_file(const char *path) {
    bytes file = {NULL, 0};
    FILE *f = fopen(path, "rb");
    if (!f || fseek(f, 0, SEEK_END))
        goto failed;
    long size = ftell(f);
    if (size <= 0 || fseek(f, 0, SEEK_SET))
        goto failed;
    file = (bytes){malloc((size_t)size), (size_t)size};
    if (!file.data || fread(file.data, 1, file.size, f) != file.size)
        goto failed;
    fclose(f);
    return file;
failed:
    fprintf(stderr, "replay_hostile: %s: %s\n", path, errno ? strerror(errno) : "cannot be read");
    exit(EXIT_FAILURE);
}

static nsdf_status open_bytes(nsdf_decoder **decoder, bytes file, int check_all, nsdf_error *error) {
    nsdf_decoder_options options;
    nsdf_decoder_options_init(&options);
    options.threads = 1;
    options.max_memory = memory_limit;
    options.check_all = check_all ? 1 : 0;
    return nsdf_open_memory(decoder, file.data, file.size, &options, error);
}

/* For calls that may end in any way, as long as they end. */
static void any_status(nsdf_status status) {
    (void)status;
}

static void read_descriptions(nsdf_decoder *decoder) {
    nsdf_info info;
    if (nsdf_get_info(decoder, &info) != NSDF_OK)
        return;
    for (uint32_t i = 0; i < nsdf_metadata_count(decoder); i++) {
        const char *key, *value;
        if (nsdf_get_metadata(decoder, i, &key, &value) == NSDF_OK && strlen(key) + strlen(value) > memory_limit)
            abort();
    }
    nsdf_segment_info segment;
    for (uint32_t i = 0; i < info.segment_count && i < 4; i++)
        any_status(nsdf_get_segment_info(decoder, i, &segment));
}

/* A mesh that was given out must be sound, whatever the file. */
static void check_mesh(const nsdf_mesh *mesh) {
    nsdf_mesh_view view;
    if (nsdf_mesh_get_view(mesh, &view) != NSDF_OK)
        return;
    for (size_t i = 0; i < 3 * (size_t)view.triangle_count; i++)
        if (view.indices[i] >= view.vertex_count)
            abort();
}

/* Everything a player would do with an open handle. */
static void use_decoder(nsdf_decoder *decoder) {
    static const float points[9] = {0, 0, 0, 0.3f, -0.2f, 0.1f, 5, 5, 5};
    float distance[3], gradient[9];
    nsdf_mesh_options options;
    nsdf_mesh *mesh = NULL;
    double t = 0;
    read_descriptions(decoder);
    if (nsdf_frame_time(decoder, 1, &t) != NSDF_OK)
        t = 0.05;
    nsdf_status evaluated = nsdf_evaluate(decoder, t, points, 3, distance, gradient);
    nsdf_mesh_options_init(&options);
    options.resolution = RESOLUTION;
    if (evaluated == NSDF_OK && nsdf_extract_mesh(decoder, 2 * t, &options, &mesh) == NSDF_OK)
        check_mesh(mesh);
    any_status(nsdf_verify(decoder));
    nsdf_mesh_free(&mesh);
}

static void try_bytes(bytes file, int must_fail, const char *what, unsigned long which, tally *count) {
    nsdf_decoder *decoder = NULL;
    nsdf_error error;
    memset(&error, 0, sizeof error);
    count->tried++;
    nsdf_status status = open_bytes(&decoder, file, 1, &error);
    if (status == NSDF_OK && must_fail) {
        count->wrongly_opened++;
        fprintf(stderr, "replay_hostile: %s %lu opened without complaint\n", what, which);
    }
    if (status != NSDF_OK && (decoder != NULL || error.status != status || !error.message[0])) {
        count->wrongly_opened++;
        fprintf(stderr, "replay_hostile: %s %lu was refused without a proper error\n", what, which);
    }
    count->refused += status != NSDF_OK;
    nsdf_close(&decoder);
    if (open_bytes(&decoder, file, 0, NULL) == NSDF_OK) {
        use_decoder(decoder);
        count->used++;
    }
    nsdf_close(&decoder);
}

static void try_prefixes(bytes file, tally *count) {
    for (size_t size = 0; size < file.size; size++) {
        bytes prefix = copy_of(file.data, size);
        try_bytes(prefix, 1, "prefix", (unsigned long)size, count);
        free(prefix.data);
    }
}

static void try_flips(bytes file, unsigned long flips, tally *count) {
    uint64_t state = 1;
    bytes flipped = copy_of(file.data, file.size);
    for (unsigned long i = 0; i < flips; i++) {
        uint64_t bit = next_random(&state) % (8 * (uint64_t)file.size);
        flipped.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
        try_bytes(flipped, 1, "bit", (unsigned long)bit, count);
        flipped.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    free(flipped.data);
}

static void put_u32(uint8_t *out, uint32_t v) {
    for (int i = 0; i < 4; i++)
        out[i] = (uint8_t)(v >> 8 * i);
}

/* Makes the CRCs of the preamble and of all chunks right again, as far as the chunks can be followed. */
static void mend_checksums(bytes file) {
    put_u32(file.data + NSDF_PREAMBLE_SIZE - 4, nsdf_crc32(0, file.data, NSDF_PREAMBLE_SIZE - 4));
    size_t at = NSDF_PREAMBLE_SIZE;
    while (file.size - at >= NSDF_CHUNK_OVERHEAD) {
        nsdf_chunk_header header;
        nsdf_fault fault;
        if (nsdf_read_chunk_header(file.data + at, file.size - at, &header, &fault) != NSDF_PARSE_OK ||
            header.length > file.size - at - NSDF_CHUNK_OVERHEAD)
            return;
        size_t covered = NSDF_CHUNK_HEADER_SIZE + (size_t)header.length;
        put_u32(file.data + at + covered, nsdf_crc32(0, file.data + at, covered));
        at += covered + 4;
    }
}

/* One to three bytes become 0, 0xff, random, or off by one. */
static void damage(bytes file, uint64_t *state) {
    uint64_t places = 1 + next_random(state) % 3;
    for (uint64_t i = 0; i < places; i++) {
        uint64_t draw = next_random(state);
        uint8_t *byte = &file.data[next_random(state) % file.size];
        switch (draw % 4) {
        case 0:
            *byte = 0;
            break;
        case 1:
            *byte = 0xff;
            break;
        case 2:
            *byte = (uint8_t)(draw >> 8);
            break;
        default:
            *byte = (uint8_t)(*byte + 1);
        }
    }
}

static void try_mended(bytes file, unsigned long rounds, tally *count) {
    uint64_t state = 2;
    for (unsigned long i = 0; i < rounds; i++) {
        bytes damaged = copy_of(file.data, file.size);
        damage(damaged, &state);
        mend_checksums(damaged);
        try_bytes(damaged, 0, "mended", i, count);
        free(damaged.data);
    }
}

static void report(const char *path, const char *what, const tally *count) {
    printf("%s: %lu %s: %lu refused, %lu used without checking everything first\n", path, count->tried, what,
           count->refused, count->used);
}

static unsigned long replay(const char *path, unsigned long flips) {
    bytes file = read_file(path);
    tally whole = {0}, prefixes = {0}, bits = {0}, mended = {0};
    try_bytes(file, 0, "file", 0, &whole);
    if (whole.refused || !whole.used) {
        fprintf(stderr, "replay_hostile: %s itself does not open\n", path);
        exit(EXIT_FAILURE);
    }
    try_prefixes(file, &prefixes);
    report(path, "prefixes", &prefixes);
    try_flips(file, flips, &bits);
    report(path, "flipped bits", &bits);
    try_mended(file, flips, &mended);
    report(path, "changed bytes with mended CRCs", &mended);
    free(file.data);
    return prefixes.wrongly_opened + bits.wrongly_opened + mended.wrongly_opened;
}

int main(int argc, char **argv) {
    unsigned long flips = 10000, failures = 0;
    int first = 1;
    if (argc > 2 && strcmp(argv[1], "--flips") == 0) {
        flips = strtoul(argv[2], NULL, 10);
        first = 3;
    }
    if (first >= argc) {
        fprintf(stderr, "usage: replay_hostile [--flips N] FILE.nsdf...\n");
        return 2;
    }
    for (int i = first; i < argc; i++)
        failures += replay(argv[i], flips);
    if (failures)
        fprintf(stderr, "replay_hostile: %lu broken promises\n", failures);
    return failures ? EXIT_FAILURE : EXIT_SUCCESS;
}

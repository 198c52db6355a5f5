/* Makes the seeds of the fuzz targets: .nsdf files with CRCs and hashes of parameters set to 0 (zero_checksum.c) and
 * the targets' choices behind them; coded arrays of every back end. usage: make_corpus FILES_FOLDER ARRAYS_FOLDER
 * FILE.nsdf... */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "container_read.h"
#include "entropy_write.h"
#include "fuzz_arrays.h"
#include "fuzz_target.h"

enum { MOST_FILE = 1 << 20 };

static void fail(const char *path) {
    fprintf(stderr, "make_corpus: %s: cannot be read, written or used\n", path);
    exit(EXIT_FAILURE);
}

static void write_seed(const char *folder, const char *name, const void *data, size_t size) {
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file))
        fail(path);
}

static void zero_hashes(uint8_t *payload, size_t length) {
    for (size_t end = 8 + NSDF_INDEX_ENTRY_SIZE; end <= length; end += NSDF_INDEX_ENTRY_SIZE)
        memset(payload + end - 8, 0, 8);
}

static void zero_checksums(uint8_t *data, size_t size, const char *path) {
    memset(data + NSDF_PREAMBLE_SIZE - 4, 0, 4);
    for (size_t at = NSDF_PREAMBLE_SIZE; at < size;) {
        nsdf_chunk_header header;
        nsdf_fault fault;
        if (nsdf_read_chunk_header(data + at, size - at, &header, &fault) != NSDF_PARSE_OK ||
            size - at < NSDF_CHUNK_OVERHEAD || header.length > size - at - NSDF_CHUNK_OVERHEAD)
            fail(path);
        uint8_t *payload = data + at + NSDF_CHUNK_HEADER_SIZE;
        if (header.type == NSDF_CHUNK_INDX)
            zero_hashes(payload, (size_t)header.length);
        memset(payload + header.length, 0, 4);
        at += NSDF_CHUNK_OVERHEAD + (size_t)header.length;
    }
}

static void file_seed(const char *path, const char *folder) {
    static uint8_t data[MOST_FILE + FUZZ_CHOICES];
    const char *slash = strrchr(path, '/');
    FILE *file = fopen(path, "rb");
    const size_t size = file ? fread(data, 1, MOST_FILE, file) : 0;
    if (size < NSDF_PREAMBLE_SIZE || size == MOST_FILE)
        fail(path);
    fclose(file);
    zero_checksums(data, size, path);
    data[size] = 0;        /* fuzz_callbacks: all bytes */
    data[size + 1] = 0x2e; /* the 46th call fails; resolution 16, two Newton steps */
    write_seed(folder, slash ? slash + 1 : path, data, size + FUZZ_CHOICES);
}

/* Two arrays of residuals that vary slowly, coded; what fuzz_arrays reads in front. */
static void array_seed(uint8_t entropy, const char *folder) {
    uint8_t head[FUZZ_ARRAYS_BYTES] = {entropy, 3, 7, 2, 6, 128, 1, 0, 4, 4, 12, 128, 0, 0};
    int32_t residuals[FUZZ_ARRAYS_MOST];
    char name[32];
    nsdf_tensor_list list;
    nsdf_buffer seed = {0};
    fuzz_arrays(head, &list);
    for (size_t i = 0, n = (size_t)nsdf_parameter_count(&list); i < n; i++)
        residuals[i] = (int32_t)(i * i % 23) - 11;
    snprintf(name, sizeof name, "arrays-%u", entropy);
    nsdf_buffer_append(&seed, head, sizeof head);
    if (nsdf_write_residuals(&seed, &list, residuals) == 0) /* a back end may be left out of the build */
        write_seed(folder, name, seed.data, seed.size);
    nsdf_buffer_free(&seed);
}

int main(int argc, char **argv) {
    if (argc < 4) {
        fprintf(stderr, "usage: make_corpus FILES_FOLDER ARRAYS_FOLDER FILE.nsdf...\n");
        return 2;
    }
    for (int i = 3; i < argc; i++)
        file_seed(argv[i], argv[1]);
    for (uint8_t entropy = 0; entropy < NSDF_ENTROPY_COUNT; entropy++)
        array_seed(entropy, argv[2]);
    return EXIT_SUCCESS;
}

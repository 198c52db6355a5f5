/* Reading the container: preamble, chunks, HEAD, INDX, META, QUAL.  No I/O, no allocation: functions take bytes that
 * the caller has fetched.  All numbers little-endian.  Readers link this half only. */
#ifndef NSDF_CONTAINER_READ_H
#define NSDF_CONTAINER_READ_H

#include "format_desc.h"

/* Results of every reading function in format/.  The decoder maps them to nsdf_status. */
typedef enum nsdf_parse {
    NSDF_PARSE_OK = 0,
    NSDF_PARSE_TRUNCATED, /* needs more bytes than there are */
    NSDF_PARSE_NOT_NSDF,  /* signature */
    NSDF_PARSE_VERSION,   /* another version of the format */
    NSDF_PARSE_FEATURE,   /* unknown critical chunk or part kind, or an entropy back end not in this build */
    NSDF_PARSE_CHECKSUM,  /* CRC-32 */
    NSDF_PARSE_CORRUPT,   /* a field's value is forbidden */
    NSDF_PARSE_NO_MEMORY  /* a back end's own allocation failed */
} nsdf_parse;

/* Filled on failure: the byte, counted from the start of the bytes given, and a static English text. */
typedef struct nsdf_fault {
    uint64_t offset;
    const char *what;
} nsdf_fault;

typedef struct nsdf_version_fields {
    uint8_t major, minor;
} nsdf_version_fields;

/* Checks signature, then major version, then CRC of the first NSDF_PREAMBLE_SIZE bytes.  With fewer bytes: NOT_NSDF
 * as soon as a byte of the signature is wrong, else TRUNCATED.  *version is filled as soon as it is known, also on
 * NSDF_PARSE_VERSION. */
nsdf_parse nsdf_read_preamble(const uint8_t *data, size_t size, nsdf_version_fields *version, nsdf_fault *fault);

typedef struct nsdf_chunk_header {
    uint32_t type, flags;
    uint64_t length; /* of the payload */
} nsdf_chunk_header;

/* Reads the NSDF_CHUNK_HEADER_SIZE bytes before a payload.  Checks that the type is four ASCII letters or digits and
 * that length <= INT64_MAX. */
nsdf_parse nsdf_read_chunk_header(const uint8_t *data, size_t size, nsdf_chunk_header *header, nsdf_fault *fault);

/* Checks the CRC of a whole chunk of header->length + NSDF_CHUNK_OVERHEAD bytes. */
nsdf_parse nsdf_check_chunk(const uint8_t *chunk, const nsdf_chunk_header *header, nsdf_fault *fault);

/* HEAD's payload.  Every field is validated: finite, ordered, in range. */
nsdf_parse nsdf_read_header(const uint8_t *payload, size_t size, nsdf_file_header *header, nsdf_fault *fault);

/* INDX's payload: fills entries[header->segment_count], checks that segments are in order, cover frames 0 to
 * frame_count - 1, share their end frames, that cross-fades fit, and that offsets ascend without overlap below
 * *file_size, which is stored in front of the entries and filled in. */
nsdf_parse nsdf_read_index(const uint8_t *payload, size_t size, const nsdf_file_header *header,
                           nsdf_index_entry *entries, uint64_t *file_size, nsdf_fault *fault);

/* Size of INDX's payload for a number of segments. */
static inline uint64_t nsdf_index_payload_size(uint32_t segments) {
    return 8 + (uint64_t)segments * NSDF_INDEX_ENTRY_SIZE;
}

nsdf_parse nsdf_read_quality(const uint8_t *payload, size_t size, nsdf_quality_record *quality, nsdf_fault *fault);

/* META's payload: a sequence of (u16 key bytes, u32 value bytes, key, NUL, value, NUL).  Strings are UTF-8 without NUL
 * inside.  *cursor starts at 0 and is moved past the entry; *key is NULL at the end.  Strings point into payload. */
nsdf_parse nsdf_read_metadata(const uint8_t *payload, size_t size, size_t *cursor, const char **key, const char **value,
                              nsdf_fault *fault);

/* CRC-32 as in PNG and zlib (polynomial 0xedb88320, initial and final complement); `crc` continues an earlier one, 0
 * starts. */
uint32_t nsdf_crc32(uint32_t crc, const void *data, size_t size);

/* 64-bit FNV-1a; `hash` continues an earlier one, NSDF_HASH_START starts. */
#define NSDF_HASH_START UINT64_C(0xcbf29ce484222325)
uint64_t nsdf_hash64(uint64_t hash, const void *data, size_t size);

/* nsdf_hash64 over the little-endian bytes of floats: the parameter hash. */
uint64_t nsdf_hash_floats(uint64_t hash, const float *values, size_t count);

#endif

/* Status texts, error details and the library's version. */
#include "status.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define TEXT(x) #x
#define VERSION_TEXT(major, minor, patch) TEXT(major) "." TEXT(minor) "." TEXT(patch)

uint32_t nsdf_version(void) {
    return (uint32_t)NSDF_VERSION_MAJOR << 16 | (uint32_t)NSDF_VERSION_MINOR << 8 | (uint32_t)NSDF_VERSION_PATCH;
}

const char *nsdf_version_string(void) {
    return VERSION_TEXT(NSDF_VERSION_MAJOR, NSDF_VERSION_MINOR, NSDF_VERSION_PATCH);
}

const char *nsdf_status_string(nsdf_status status) {
    switch (status) {
    case NSDF_OK:
        return "Success";
    case NSDF_INVALID_ARGUMENT:
        return "An argument is NULL, not a number or out of range";
    case NSDF_NO_MEMORY:
        return "Out of memory";
    case NSDF_LIMIT:
        return "A limit set in the options would be exceeded";
    case NSDF_IO:
        return "The file could not be opened or read";
    case NSDF_NOT_NSDF:
        return "Not an NSDF file";
    case NSDF_UNSUPPORTED_VERSION:
        return "The file's format version is not one that this library reads";
    case NSDF_UNSUPPORTED_FEATURE:
        return "The file needs a feature that this library does not have";
    case NSDF_TRUNCATED:
        return "The file ends too early";
    case NSDF_CORRUPT:
        return "The file has a value that the format forbids";
    case NSDF_CHECKSUM:
        return "A checksum does not match";
    case NSDF_BUFFER_TOO_SMALL:
        return "A buffer is too small";
    case NSDF_CANCELLED:
        return "Cancelled";
    case NSDF_INTERNAL:
        return "Internal error";
    }
    return "Unknown status";
}

void nsdf_chunk_name(uint32_t type, char name[8]) {
    memset(name, 0, 8);
    for (int i = 0; i < 4 && type != 0; i++) {
        char c = (char)(type >> (8 * i) & 0x7f);
        name[i] = c >= 0x20 && c < 0x7f ? c : '?';
    }
}

nsdf_status nsdf_fail(nsdf_error *error, nsdf_status status, uint32_t chunk, uint64_t offset, const char *format, ...) {
    if (error) {
        va_list list;
        error->status = status;
        error->offset = offset;
        nsdf_chunk_name(chunk, error->chunk);
        va_start(list, format);
        vsnprintf(error->message, sizeof error->message, format, list);
        va_end(list);
    }
    return status;
}

static nsdf_status status_of_parse(nsdf_parse parse) {
    switch (parse) {
    case NSDF_PARSE_OK:
        return NSDF_OK;
    case NSDF_PARSE_TRUNCATED:
        return NSDF_TRUNCATED;
    case NSDF_PARSE_NOT_NSDF:
        return NSDF_NOT_NSDF;
    case NSDF_PARSE_VERSION:
        return NSDF_UNSUPPORTED_VERSION;
    case NSDF_PARSE_FEATURE:
        return NSDF_UNSUPPORTED_FEATURE;
    case NSDF_PARSE_CHECKSUM:
        return NSDF_CHECKSUM;
    case NSDF_PARSE_CORRUPT:
        return NSDF_CORRUPT;
    case NSDF_PARSE_NO_MEMORY:
        return NSDF_NO_MEMORY;
    }
    return NSDF_INTERNAL;
}

nsdf_status nsdf_fail_parse(nsdf_error *error, nsdf_parse parse, uint32_t chunk, uint64_t base,
                            const nsdf_fault *fault) {
    nsdf_status status = status_of_parse(parse);
    const char *what = fault->what ? fault->what : nsdf_status_string(status);
    return nsdf_fail(error, status, chunk, base + fault->offset, "%s", what);
}

nsdf_status nsdf_fail_memory(nsdf_error *error, nsdf_status status, uint32_t chunk, uint64_t offset, uint64_t size) {
    const char *reason = status == NSDF_LIMIT ? "max_memory does not allow" : "the allocator did not give";
    return nsdf_fail(error, status, chunk, offset, "%s %llu more bytes", reason, (unsigned long long)size);
}

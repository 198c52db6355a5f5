/* Files behind http:// and https:// URLs, read by ranges.  Each byte is fetched once, as long as the cache holds it; a
 * dropped connection is taken up again at the byte that it had reached. */
#ifndef NSDF_CLI_HTTP_H
#define NSDF_CLI_HTTP_H

#include "nsdf/decoder.h"

/* Whether a name is a URL that this module is for, rather than a path. */
int nsdf_cli_is_url(const char *name);

typedef struct nsdf_cli_http nsdf_cli_http;

typedef struct nsdf_cli_http_options {
    uint32_t timeout;          /* seconds: for making a connection, and for silence on one; at least 1 */
    int (*cancel)(void *user); /* asked at least once a second; nonzero gives up.  May be NULL */
    void *cancel_user;
} nsdf_cli_http_options;

typedef struct nsdf_cli_http_stats {
    uint64_t size;                /* of the file */
    uint64_t bytes, header_bytes; /* received, of bodies and of headers */
    uint32_t requests, retries;   /* retries are among the requests */
    double seconds;               /* that reads waited for it */
    double transfer_seconds;      /* that transfers took, those ahead included */
    int whole;                    /* the server gave no ranges: all of it was fetched */
} nsdf_cli_http_stats;

/* Fetches the file's first bytes, and so learns its size.  NSDF_OK, or NSDF_IO or NSDF_NO_MEMORY with *error saying
 * why; always NSDF_IO from a program built without libcurl.  Not to be called by two threads at once. */
nsdf_status nsdf_cli_http_open(nsdf_cli_http **http, const char *url, const nsdf_cli_http_options *options,
                               nsdf_error *error);

/* For nsdf_open_callbacks; several decoders, on several threads, may read through one `http`. */
nsdf_io nsdf_cli_http_io(nsdf_cli_http *http);

/* Bytes that will be read soon: a thread fetches them, unless it is at others, but gives way to reads of others.
 * Failures are left to the reads. */
void nsdf_cli_http_ahead(nsdf_cli_http *http, uint64_t offset, uint64_t size);

/* Makes the read that is going on, and later ones, fail within a second; from any thread. */
void nsdf_cli_http_cancel(nsdf_cli_http *http);

/* Copies why the last read failed; empty when none did. */
void nsdf_cli_http_failure(nsdf_cli_http *http, char *text, size_t size);
nsdf_cli_http_stats nsdf_cli_http_get_stats(nsdf_cli_http *http);

/* NULL-safe, sets *http to NULL. */
void nsdf_cli_http_close(nsdf_cli_http **http);

#endif

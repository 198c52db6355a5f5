/* Requests to one server for one file, by libcurl: one connection, one request at a time. */
#ifndef NSDF_CLI_TRANSFER_H
#define NSDF_CLI_TRANSFER_H

#include <curl/curl.h>
#include <stddef.h>
#include <stdint.h>

/* The connection, and what the responses have told of the file. */
typedef struct nsdf_cli_remote {
    CURL *curl;
    uint32_t timeout; /* seconds */
    int answered;     /* a request has succeeded */
    int known;        /* a response has told which file it is: `validator` is set */
    int whole;        /* the server gives no ranges */
    int size_known;
    uint64_t size;
    char detail[CURL_ERROR_SIZE]; /* what libcurl says of the last failure */
    char validator[128];          /* ETag, or else Last-Modified; empty when the server gives none */
} nsdf_cli_remote;

/* Connects when the first bytes are asked for; *remote stays where it is until it is closed.  The environment may name
 * certificates to trust, as for curl: a file in CURL_CA_BUNDLE or SSL_CERT_FILE, a folder in SSL_CERT_DIR.  0, or -1
 * without memory. */
int nsdf_cli_remote_open(nsdf_cli_remote *remote, const char *url, uint32_t timeout);
/* Nothing happens to one that is not open. */
void nsdf_cli_remote_close(nsdf_cli_remote *remote);

/* What is being fetched.  data[0 .. got) are the bytes of the file from `from` on. */
typedef struct nsdf_cli_transfer {
    nsdf_cli_remote *remote;
    int (*cancel)(void *user); /* asked at least once a second; nonzero gives up */
    void *cancel_user;
    uint64_t from;
    size_t wanted; /* SIZE_MAX while all of a file of unknown size is */
    size_t got, capacity;
    uint8_t *data;                /* owned by the caller, who frees it */
    uint64_t skip;                /* bytes of this response that are there already */
    int checked, refused;         /* the response's head was looked at; it says something that we cannot use */
    uint64_t bytes, header_bytes; /* received */
    uint32_t requests, retries;
    char failure[160];
} nsdf_cli_transfer;

/* Fetches until all that is wanted is there, or the file ends: 0, or -1 with *failure, and what did arrive.  From a
 * server without ranges all of the file: `from` becomes 0. */
int nsdf_cli_transfer_run(nsdf_cli_transfer *transfer);

#endif

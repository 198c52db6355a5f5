/* A small HTTP server for tests: one file on 127.0.0.1, with the habits that real servers have on bad days, and a log
 * of what it sent. */
#ifndef HTTP_SERVER_H
#define HTTP_SERVER_H

#include <stddef.h>
#include <stdint.h>

typedef enum http_mode {
    HTTP_RANGES,      /* as it should be */
    HTTP_NO_RANGES,   /* 200 and the whole file, whatever is asked */
    HTTP_NO_LENGTH,   /* the same without saying how long it is */
    HTTP_DROP,        /* closes the connection after `limit` bytes of a body */
    HTTP_DROP_WHOLE,  /* HTTP_NO_RANGES, each response `limit` bytes longer than the one before */
    HTTP_SLOW,        /* `limit` bytes a second */
    HTTP_SILENT,      /* takes requests and never answers */
    HTTP_BUSY,        /* 503 to the first `limit` requests */
    HTTP_NOT_FOUND,   /* 404 */
    HTTP_WRONG_RANGE, /* 206 with other bytes than those that were asked for */
    HTTP_CHANGED,     /* another ETag after `limit` requests */
    HTTP_GROWN,       /* a larger size in Content-Range after `limit` requests, without ETags */
    HTTP_REDIRECT     /* from any path but /file to /file, with 302 */
} http_mode;

/* A mode by its name in small letters with hyphens, "no-ranges"; -1 if there is none. */
int http_mode_by_name(const char *name);

typedef struct http_answer {
    int status;
    uint64_t first, sent; /* offset in the file, and bytes of the body that were sent */
} http_answer;

enum { HTTP_ANSWERS = 256 };

typedef struct http_log {
    uint32_t connections, requests;
    uint64_t bytes, header_bytes; /* sent */
    http_answer answers[HTTP_ANSWERS];
} http_log;

typedef struct http_server http_server;

/* Serves `data`, which is borrowed, from a thread of its own.  NULL on failure. */
http_server *http_server_start(const void *data, size_t size, http_mode mode, uint64_t limit);
uint16_t http_server_port(const http_server *server);
/* Ends it; all that was sent is in the log. */
http_log http_server_stop(http_server *server);

#endif

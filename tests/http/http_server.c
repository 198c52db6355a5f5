#include "http_server.h"

#include <arpa/inet.h>
#include <errno.h>
#include <inttypes.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { HEAD_SIZE = 4096, SLOW_PIECE = 64 };

struct http_server {
    const uint8_t *data;
    size_t size;
    http_mode mode;
    uint64_t limit;
    int listener, wake[2]; /* a byte in the pipe ends the thread */
    uint16_t port;
    pthread_t thread;
    http_log log; /* the thread's, until it has ended */
};

/* What a request asks for, and what is going to be sent. */
typedef struct exchange {
    char path[256];
    int has_range;
    uint64_t first, last;
} exchange;

int http_mode_by_name(const char *name) {
    static const char *const names[] = {"ranges",  "no-ranges", "no-length", "drop",      "drop-whole",
                                        "slow",    "silent",    "busy",      "not-found", "wrong-range",
                                        "changed", "grown",     "redirect"};
    for (int i = 0; i < (int)(sizeof names / sizeof *names); i++)
        if (strcmp(name, names[i]) == 0)
            return i;
    return -1;
}

/* ---- Sending -------------------------------------------------------------------------------------------------- */

/* 0, or -1 when the client went away or the server is to stop. */
static int send_all(http_server *s, int client, const void *bytes, size_t size, int is_body) {
    const char *at = bytes;
    while (size > 0) {
        struct pollfd wait[2] = {{.fd = client, .events = POLLOUT}, {.fd = s->wake[0], .events = POLLIN}};
        if (poll(wait, 2, -1) < 0 || wait[1].revents)
            return -1;
        const ssize_t done = send(client, at, size, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (done < 0 && errno != EAGAIN && errno != EINTR)
            return -1;
        const size_t part = done < 0 ? 0 : (size_t)done;
        if (is_body) {
            s->log.bytes += part;
            s->log.answers[(s->log.requests - 1) % HTTP_ANSWERS].sent += part;
        } else {
            s->log.header_bytes += part;
        }
        at += part;
        size -= part;
    }
    return 0;
}

static int pause_for(const http_server *s, int milliseconds) {
    struct pollfd wait = {.fd = s->wake[0], .events = POLLIN};
    return poll(&wait, 1, milliseconds) == 0 ? 0 : -1;
}

static int send_slowly(http_server *s, int client, const uint8_t *bytes, size_t size) {
    while (size > 0) {
        const size_t part = size < SLOW_PIECE ? size : SLOW_PIECE;
        if (send_all(s, client, bytes, part, 1) != 0 || pause_for(s, (int)(1000 * part / s->limit)) != 0)
            return -1;
        bytes += part;
        size -= part;
    }
    return 0;
}

/* A body, as far as the mode lets it: 0 when the connection may go on. */
static int send_body(http_server *s, int client, uint64_t first, uint64_t size, uint32_t number) {
    const uint64_t most = s->mode == HTTP_DROP ? s->limit : s->mode == HTTP_DROP_WHOLE ? s->limit * number : size;
    const int complete = most >= size;
    const size_t sent = (size_t)(complete ? size : most);
    const int failed = s->mode == HTTP_SLOW ? send_slowly(s, client, s->data + first, sent)
                                            : send_all(s, client, s->data + first, sent, 1);
    return failed || !complete || s->mode == HTTP_NO_LENGTH ? -1 : 0;
}

/* ---- Answers -------------------------------------------------------------------------------------------------- */

static uint32_t note_answer(http_server *s, int status, uint64_t first) {
    s->log.answers[s->log.requests % HTTP_ANSWERS] = (http_answer){.status = status, .first = first};
    return ++s->log.requests;
}

static int send_error(http_server *s, int client, int status, const char *extra) {
    static const char page[] = "<html>an error page of some length that nobody reads</html>\n";
    char head[512];
    note_answer(s, status, 0);
    const int n = snprintf(head, sizeof head, "HTTP/1.1 %d Status\r\n%sContent-Length: %zu\r\n\r\n%s", status, extra,
                           sizeof page - 1, page);
    return send_all(s, client, head, (size_t)n, 0);
}

static int send_whole(http_server *s, int client) {
    char head[512], length[64] = "";
    const uint32_t number = note_answer(s, 200, 0);
    if (s->mode != HTTP_NO_LENGTH)
        snprintf(length, sizeof length, "Content-Length: %zu\r\n", s->size);
    const int n = snprintf(head, sizeof head, "HTTP/1.1 200 OK\r\nETag: \"one\"\r\n%s%s\r\n", length,
                           s->mode == HTTP_NO_LENGTH ? "Connection: close\r\n" : "");
    if (send_all(s, client, head, (size_t)n, 0) != 0)
        return -1;
    return send_body(s, client, 0, s->size, number);
}

static int send_range(http_server *s, int client, const exchange *e) {
    char head[512], tag[64] = "";
    if (e->first >= s->size) {
        char extra[64];
        snprintf(extra, sizeof extra, "Content-Range: bytes */%zu\r\n", s->size);
        return send_error(s, client, 416, extra);
    }
    const uint64_t last = e->last < s->size ? e->last : s->size - 1, shift = s->mode == HTTP_WRONG_RANGE ? 1 : 0;
    const uint32_t number = note_answer(s, 206, e->first);
    const int later = number > s->limit;
    if (s->mode != HTTP_GROWN)
        snprintf(tag, sizeof tag, "ETag: \"%s\"\r\n", s->mode == HTTP_CHANGED && later ? "two" : "one");
    const int n = snprintf(head, sizeof head,
                           "HTTP/1.1 206 Partial Content\r\n%sContent-Range: bytes %" PRIu64 "-%" PRIu64
                           "/%zu\r\nContent-Length: %" PRIu64 "\r\n\r\n",
                           tag, e->first + shift, last + shift, s->size + (s->mode == HTTP_GROWN && later ? 1 : 0),
                           last - e->first + 1);
    if (send_all(s, client, head, (size_t)n, 0) != 0)
        return -1;
    return send_body(s, client, e->first, last - e->first + 1, number);
}

/* 0 when the connection may go on. */
static int answer(http_server *s, int client, const exchange *e) {
    switch (s->mode) {
    case HTTP_NO_RANGES:
    case HTTP_NO_LENGTH:
    case HTTP_DROP_WHOLE:
        return send_whole(s, client);
    case HTTP_NOT_FOUND:
        return send_error(s, client, 404, "");
    case HTTP_SILENT:
        note_answer(s, 0, 0);
        return 0;
    case HTTP_BUSY:
        if (s->log.requests < s->limit)
            return send_error(s, client, 503, "");
        break;
    case HTTP_REDIRECT:
        if (strcmp(e->path, "/file") != 0)
            return send_error(s, client, 302, "Location: /file\r\n");
        break;
    default:
        break;
    }
    return e->has_range ? send_range(s, client, e) : send_whole(s, client);
}

/* ---- Requests ------------------------------------------------------------------------------------------------- */

static exchange parse_request(const char *head) {
    exchange e = {.has_range = 0};
    const char *range = strstr(head, "Range: bytes=");
    sscanf(head, "GET %255s", e.path);
    e.has_range = range && sscanf(range, "Range: bytes=%" SCNu64 "-%" SCNu64, &e.first, &e.last) == 2;
    return e;
}

/* Answers one request after the other until the client, the mode or another client ends it. */
static void serve(http_server *s, int client) {
    char head[HEAD_SIZE];
    size_t used = 0;
    for (;;) {
        struct pollfd wait[3] = {{.fd = client, .events = POLLIN},
                                 {.fd = s->wake[0], .events = POLLIN},
                                 {.fd = s->listener, .events = POLLIN}};
        if (poll(wait, 3, -1) < 0 || wait[1].revents || !wait[0].revents)
            return;
        const ssize_t got = recv(client, head + used, sizeof head - 1 - used, 0);
        if (got <= 0)
            return;
        used += (size_t)got;
        head[used] = '\0';
        if (!strstr(head, "\r\n\r\n"))
            continue;
        used = 0;
        const exchange e = parse_request(head);
        if (answer(s, client, &e) != 0)
            return;
    }
}

static void *run(void *user) {
    http_server *s = user;
    for (;;) {
        struct pollfd wait[2] = {{.fd = s->listener, .events = POLLIN}, {.fd = s->wake[0], .events = POLLIN}};
        if (poll(wait, 2, -1) < 0 || wait[1].revents)
            return NULL;
        const int client = accept(s->listener, NULL, NULL), on = 1;
        if (client < 0)
            continue;
        setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        s->log.connections++;
        serve(s, client);
        shutdown(client, SHUT_WR);
        close(client);
    }
}

/* ---- Starting and stopping -------------------------------------------------------------------------------------- */

static int listen_somewhere(http_server *s) {
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr = {htonl(INADDR_LOOPBACK)}};
    socklen_t length = sizeof address;
    s->listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (s->listener < 0 || bind(s->listener, (struct sockaddr *)&address, sizeof address) != 0 ||
        listen(s->listener, 8) != 0 || getsockname(s->listener, (struct sockaddr *)&address, &length) != 0)
        return -1;
    s->port = ntohs(address.sin_port);
    return 0;
}

http_server *http_server_start(const void *data, size_t size, http_mode mode, uint64_t limit) {
    http_server *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    *s = (http_server){.data = data, .size = size, .mode = mode, .limit = limit, .listener = -1};
    if (listen_somewhere(s) == 0 && pipe(s->wake) == 0 && pthread_create(&s->thread, NULL, run, s) == 0)
        return s;
    if (s->listener >= 0)
        close(s->listener);
    free(s);
    return NULL;
}

uint16_t http_server_port(const http_server *server) {
    return server->port;
}

http_log http_server_stop(http_server *server) {
    if (write(server->wake[1], "", 1) != 1)
        abort();
    pthread_join(server->thread, NULL);
    close(server->listener);
    close(server->wake[0]);
    close(server->wake[1]);
    const http_log log = server->log;
    free(server);
    return log;
}

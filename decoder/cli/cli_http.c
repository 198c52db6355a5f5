/* HTTP by libcurl: one connection, one request at a time.
 *
 * The first request asks for PREFIX bytes: enough for the front of most files, and little beside a segment.  Later ones
 * ask for what the decoder reads and nothing else, except that short reads (of chunk headers) take READ_AHEAD bytes, so
 * that a chunk does not cost one request for its length and one for its bytes. */
#include "cli_http.h"

#include <curl/curl.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "cli_extents.h"
#include "cli_util.h"

enum {
    PREFIX = 2048,
    READ_AHEAD = 256,
    TRIES = 4,         /* without a byte of progress between them */
    FIRST_PAUSE = 250, /* milliseconds before the second try; doubled before each further one */
    MOST_REDIRECTS = 5,
    MOST_CACHED = 1 << 28, /* bytes; a server without ranges may need more */
    MOST_WHOLE = 1 << 30,  /* bytes fetched from a server without ranges */
    VALIDATOR = 128
};

struct nsdf_cli_http {
    nsdf_cli_http_options options;
    pthread_mutex_t lock; /* of all below but `cancelled` */
    CURL *curl;
    atomic_int cancelled;
    int answered; /* a request has succeeded */
    int known;    /* a response has told which file it is: `validator` is set */
    uint64_t size;
    int size_known;
    char validator[VALIDATOR]; /* ETag, or else Last-Modified; empty when the server gives none */
    nsdf_cli_extents cache;
    nsdf_cli_http_stats stats;
    char failure[160];
};

/* What is being fetched.  data[0 .. got) are the bytes of the file from `from` on. */
typedef struct transfer {
    nsdf_cli_http *http;
    uint64_t from;
    size_t wanted, got, capacity; /* wanted: SIZE_MAX while all of a file of unknown size is */
    uint8_t *data;
    uint64_t skip;        /* bytes of this response that are there already */
    int checked, refused; /* the response's head was looked at; it says something that we cannot use */
} transfer;

static void explain(nsdf_cli_http *http, const char *format, ...) NSDF_CLI_PRINTF(2, 3);

static void explain(nsdf_cli_http *http, const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(http->failure, sizeof http->failure, format, args);
    va_end(args);
}

/* ---- The head of a response --------------------------------------------------------------------------------- */

/* The value of a header of the last response, or NULL. */
static const char *header_value(CURL *curl, const char *name) {
    struct curl_header *header;
    return curl_easy_header(curl, name, 0, CURLH_HEADER, -1, &header) == CURLHE_OK ? header->value : NULL;
}

static long response_code(CURL *curl) {
    long code = 0;
    curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &code);
    return code;
}

static int refuse(transfer *t) {
    t->refused = 1;
    return -1;
}

/* The same file as in earlier responses? */
static int check_validator(transfer *t) {
    nsdf_cli_http *http = t->http;
    const char *tag = header_value(http->curl, "ETag");
    const char *value = tag ? tag : header_value(http->curl, "Last-Modified");
    if (!http->known)
        snprintf(http->validator, sizeof http->validator, "%s", value ? value : "");
    http->known = 1;
    if (!value || !http->validator[0] || strncmp(http->validator, value, sizeof http->validator - 1) == 0)
        return 0;
    explain(http, "the file changed on the server while it was read; start again");
    return refuse(t);
}

static int learn_size(transfer *t, uint64_t size) {
    nsdf_cli_http *http = t->http;
    if (http->size_known && http->size != size) {
        explain(http, "the file had %" PRIu64 " bytes and now has %" PRIu64 ": it changed on the server", http->size,
                size);
        return refuse(t);
    }
    if (!http->size_known)
        http->size = size; /* once, while it is opened: nsdf_cli_http_io reads it without the lock */
    http->size_known = 1;
    return 0;
}

/* 206: "bytes FIRST-LAST/SIZE". */
static int check_range(transfer *t) {
    nsdf_cli_http *http = t->http;
    const uint64_t asked = t->from + t->got;
    const char *range = header_value(http->curl, "Content-Range");
    uint64_t first, last, size;
    char end;
    if (!range || sscanf(range, "bytes %" SCNu64 "-%" SCNu64 "/%" SCNu64 "%c", &first, &last, &size, &end) != 3) {
        explain(http, "the server's answer to a range request has no usable Content-Range (%.40s)",
                range ? range : "none");
        return refuse(t);
    }
    if (first != asked || last < first || last >= size || size > INT64_MAX) {
        explain(http, "the server was asked for byte %" PRIu64 " on and answered with %.60s", asked, range);
        return refuse(t);
    }
    if (size - t->from < t->wanted)
        t->wanted = (size_t)(size - t->from);
    return learn_size(t, size);
}

/* 200: the server does not do ranges and sends the whole file. */
static int accept_whole(transfer *t) {
    nsdf_cli_http *http = t->http;
    curl_off_t length = -1;
    curl_easy_getinfo(http->curl, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &length);
    if (length > MOST_WHOLE) {
        explain(http, "the server has no ranges, and %lld bytes are too many to fetch at once; download the file",
                (long long)length);
        return refuse(t);
    }
    if (length >= 0 && learn_size(t, (uint64_t)length) != 0)
        return -1;
    if (!http->stats.whole)
        nsdf_cli_verbose("the server has no ranges: fetching the whole file");
    if (t->from != 0)
        t->got = 0;
    t->from = 0;
    t->skip = t->got;
    t->wanted = http->size_known ? (size_t)http->size : SIZE_MAX;
    http->stats.whole = 1;
    return 0;
}

static int check_response(transfer *t) {
    const long code = response_code(t->http->curl);
    t->checked = 1;
    if (check_validator(t) != 0)
        return -1;
    if (code == 206)
        return check_range(t);
    if (code == 200)
        return accept_whole(t);
    explain(t->http, "the server answered with status %ld", code);
    return refuse(t);
}

/* ---- The body ------------------------------------------------------------------------------------------------ */

static int reserve(transfer *t, size_t size) {
    if (size <= t->capacity)
        return 0;
    size_t capacity = t->wanted != SIZE_MAX ? t->wanted : size + size / 2 + PREFIX;
    if (t->wanted == SIZE_MAX && size > MOST_WHOLE) {
        explain(t->http, "the server has no ranges, and the file is too large to fetch at once; download it");
        return refuse(t);
    }
    uint8_t *grown = realloc(t->data, capacity);
    if (!grown) {
        explain(t->http, "no memory for %zu bytes", capacity);
        return refuse(t);
    }
    t->data = grown;
    t->capacity = capacity;
    return 0;
}

/* What comes beyond the bytes wanted ends the transfer. */
static size_t on_body(char *bytes, size_t one, size_t size, void *user) {
    transfer *t = user;
    (void)one;
    t->http->stats.bytes += size;
    if (!t->checked && check_response(t) != 0)
        return 0;
    const size_t skipped = t->skip < size ? (size_t)t->skip : size;
    const size_t fresh = size - skipped, left = t->wanted - t->got, part = fresh < left ? fresh : left;
    t->skip -= skipped;
    if (part > 0) {
        if (reserve(t, t->got + part) != 0)
            return 0;
        memcpy(t->data + t->got, bytes + skipped, part);
        t->got += part;
    }
    return part < fresh ? 0 : size;
}

static int is_cancelled(nsdf_cli_http *http) {
    return atomic_load(&http->cancelled) || (http->options.cancel && http->options.cancel(http->options.cancel_user));
}

static int on_progress(void *user, curl_off_t a, curl_off_t b, curl_off_t c, curl_off_t d) {
    (void)a, (void)b, (void)c, (void)d;
    return is_cancelled(user);
}

/* ---- Requests ------------------------------------------------------------------------------------------------- */

typedef enum outcome { DONE, AGAIN, FAILED } outcome;

/* A server that never answered is more likely misspelt than resting. */
static int may_pass(const nsdf_cli_http *http, CURLcode code, long status) {
    switch (code) {
    case CURLE_PARTIAL_FILE:
    case CURLE_RECV_ERROR:
    case CURLE_SEND_ERROR:
    case CURLE_GOT_NOTHING:
    case CURLE_OPERATION_TIMEDOUT:
    case CURLE_HTTP2:
    case CURLE_HTTP2_STREAM:
        return 1;
    case CURLE_COULDNT_CONNECT:
    case CURLE_COULDNT_RESOLVE_HOST:
        return http->answered;
    case CURLE_HTTP_RETURNED_ERROR:
        return status == 408 || status == 429 || (status >= 500 && status != 501 && status != 505);
    default:
        return 0;
    }
}

static void explain_status(nsdf_cli_http *http, long status) {
    const char *meaning = status == 404 || status == 410   ? ": there is no such file"
                          : status == 401 || status == 403 ? ": it does not give us the file"
                          : status >= 500                  ? ": the server has trouble"
                                                           : "";
    explain(http, "the server answered with status %ld%s", status, meaning);
}

static void explain_code(nsdf_cli_http *http, CURLcode code, long status) {
    switch (code) {
    case CURLE_ABORTED_BY_CALLBACK:
        explain(http, "interrupted");
        break;
    case CURLE_COULDNT_RESOLVE_HOST:
        explain(http, "there is no host of that name, or no name server");
        break;
    case CURLE_COULDNT_CONNECT:
        explain(http, "the server cannot be reached, or refuses the connection");
        break;
    case CURLE_OPERATION_TIMEDOUT:
        explain(http, "no byte came in %lu seconds", (unsigned long)http->options.timeout);
        break;
    case CURLE_PARTIAL_FILE:
    case CURLE_RECV_ERROR:
    case CURLE_GOT_NOTHING:
        explain(http, "the server closed the connection too early");
        break;
    case CURLE_HTTP_RETURNED_ERROR:
        explain_status(http, status);
        break;
    default:
        explain(http, "%s", curl_easy_strerror(code));
    }
}

/* An empty file has no first byte: "416 ... Content-Range: bytes * /0". */
static int is_empty_file(transfer *t, CURLcode code, long status) {
    const char *range = header_value(t->http->curl, "Content-Range");
    return code == CURLE_HTTP_RETURNED_ERROR && status == 416 && !t->http->size_known && range &&
           strcmp(range, "bytes */0") == 0;
}

static void count_request(nsdf_cli_http *http) {
    long size = 0;
    curl_easy_getinfo(http->curl, CURLINFO_HEADER_SIZE, &size);
    http->stats.header_bytes += (uint64_t)size;
    http->stats.requests++;
}

static outcome judge(transfer *t, CURLcode code) {
    nsdf_cli_http *http = t->http;
    const long status = response_code(http->curl);
    if (t->refused)
        return FAILED;
    if (is_empty_file(t, code, status))
        return learn_size(t, 0), t->wanted = 0, DONE;
    if (code == CURLE_OK && !t->checked && check_response(t) != 0)
        return FAILED;
    if (t->checked && (code == CURLE_OK || t->got == t->wanted))
        return DONE;
    explain_code(http, code, status);
    return may_pass(http, code, status) ? AGAIN : FAILED;
}

static outcome request(transfer *t) {
    nsdf_cli_http *http = t->http;
    char range[48];
    t->checked = t->refused = 0;
    t->skip = 0;
    snprintf(range, sizeof range, "%" PRIu64 "-%" PRIu64, t->from + t->got, t->from + t->wanted - 1);
    curl_easy_setopt(http->curl, CURLOPT_RANGE, http->stats.whole ? NULL : range);
    curl_easy_setopt(http->curl, CURLOPT_WRITEDATA, t);
    const CURLcode code = curl_easy_perform(http->curl);
    count_request(http);
    const outcome result = judge(t, code);
    if (result == DONE) {
        http->answered = 1;
        if (http->stats.whole)
            t->wanted = t->got;
    }
    return result;
}

/* Nonzero when it was cancelled meanwhile. */
static int pause_for(nsdf_cli_http *http, int milliseconds) {
    const struct timespec step = {0, 25 * 1000000};
    for (; milliseconds > 0 && !is_cancelled(http); milliseconds -= 25)
        nanosleep(&step, NULL);
    if (!is_cancelled(http))
        return 0;
    explain(http, "interrupted");
    return 1;
}

/* Fetches until all that is wanted is there; 0, or -1 with http->failure. */
static int run_transfer(transfer *t) {
    nsdf_cli_http *http = t->http;
    int tries = 0, pause = FIRST_PAUSE;
    while (t->got < t->wanted) {
        const size_t before = t->got;
        const outcome result = request(t);
        if (result == FAILED)
            return -1;
        if (t->got > before)
            tries = 0, pause = FIRST_PAUSE;
        else if (++tries == TRIES)
            return -1;
        if (t->got >= t->wanted || (result == DONE && t->got > before))
            continue;
        nsdf_cli_verbose("%s; trying again from byte %" PRIu64, http->failure, t->from + t->got);
        http->stats.retries++;
        if (pause_for(http, pause))
            return -1;
        pause *= 2;
    }
    return 0;
}

/* The bytes [from, to) into the cache; all of the file from a server without ranges. */
static int fetch(nsdf_cli_http *http, uint64_t from, uint64_t to) {
    transfer t = {.http = http, .from = from, .wanted = (size_t)(to - from)};
    const double began = nsdf_cli_clock();
    const int result = run_transfer(&t);
    http->stats.seconds += nsdf_cli_clock() - began;
    if (http->stats.whole && result == 0) {
        nsdf_cli_extents_free(&http->cache);
        if (!http->size_known)
            learn_size(&t, t.got);
    }
    if (t.got > 0 && (result == 0 || !http->stats.whole) &&
        nsdf_cli_extents_add(&http->cache, t.from, t.data, t.got) == 0)
        return result;
    free(t.data);
    if (t.got > 0 && result == 0)
        explain(http, "no memory");
    return t.got > 0 ? -1 : result;
}

/* ---- The decoder's side ---------------------------------------------------------------------------------------- */

static uint64_t least(uint64_t a, uint64_t b) {
    return a < b ? a : b;
}

static int make_present(nsdf_cli_http *http, uint64_t offset, uint64_t size) {
    uint64_t from, to, room;
    while (nsdf_cli_extents_gap(&http->cache, offset, size, &from, &to, &room)) {
        if (to - from < READ_AHEAD)
            to = least(least(from + READ_AHEAD, room), http->size);
        if (fetch(http, from, to) != 0)
            return -1;
    }
    return 0;
}

static int read_at(void *user, uint64_t offset, void *dst, size_t size) {
    nsdf_cli_http *http = user;
    pthread_mutex_lock(&http->lock);
    const int result = make_present(http, offset, size);
    if (result == 0) {
        nsdf_cli_extents_copy(&http->cache, offset, dst, size);
        nsdf_cli_extents_trim(&http->cache, MOST_CACHED);
    }
    pthread_mutex_unlock(&http->lock);
    return result;
}

nsdf_io nsdf_cli_http_io(nsdf_cli_http *http) {
    return (nsdf_io){.user = http, .read_at = read_at, .size = http->size};
}

/* ---- Opening and closing ----------------------------------------------------------------------------------------- */

static void configure(nsdf_cli_http *http, const char *url) {
    CURL *curl = http->curl;
    const long timeout = (long)http->options.timeout;
    curl_easy_setopt(curl, CURLOPT_URL, url);
    curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(curl, CURLOPT_REDIR_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(curl, CURLOPT_FOLLOWLOCATION, 1L);
    curl_easy_setopt(curl, CURLOPT_MAXREDIRS, (long)MOST_REDIRECTS);
    curl_easy_setopt(curl, CURLOPT_FAILONERROR, 1L);
    curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT, timeout);
    curl_easy_setopt(curl, CURLOPT_LOW_SPEED_LIMIT, 1L);
    curl_easy_setopt(curl, CURLOPT_LOW_SPEED_TIME, timeout);
    curl_easy_setopt(curl, CURLOPT_USERAGENT, "nsdf");
    curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, on_body);
    curl_easy_setopt(curl, CURLOPT_NOPROGRESS, 0L);
    curl_easy_setopt(curl, CURLOPT_XFERINFOFUNCTION, on_progress);
    curl_easy_setopt(curl, CURLOPT_XFERINFODATA, http);
}

static nsdf_status fail_open(nsdf_error *error, nsdf_status status, const char *message) {
    *error = (nsdf_error){.status = status};
    snprintf(error->message, sizeof error->message, "%s", message);
    return status;
}

nsdf_status nsdf_cli_http_open(nsdf_cli_http **http, const char *url, const nsdf_cli_http_options *options,
                               nsdf_error *error) {
    nsdf_cli_http *h = calloc(1, sizeof *h);
    if (!h || curl_global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK) {
        free(h);
        return fail_open(error, NSDF_NO_MEMORY, "no memory for the network");
    }
    h->options = *options;
    pthread_mutex_init(&h->lock, NULL);
    h->curl = curl_easy_init();
    if (!h->curl) {
        nsdf_cli_http_close(&h);
        return fail_open(error, NSDF_NO_MEMORY, "no memory for the network");
    }
    configure(h, url);
    if (fetch(h, 0, PREFIX) != 0) {
        fail_open(error, NSDF_IO, h->failure);
        nsdf_cli_http_close(&h);
        return error->status;
    }
    *http = h;
    return NSDF_OK;
}

void nsdf_cli_http_cancel(nsdf_cli_http *http) {
    atomic_store(&http->cancelled, 1);
}

void nsdf_cli_http_failure(nsdf_cli_http *http, char *text, size_t size) {
    pthread_mutex_lock(&http->lock);
    snprintf(text, size, "%s", http->failure);
    pthread_mutex_unlock(&http->lock);
}

nsdf_cli_http_stats nsdf_cli_http_get_stats(nsdf_cli_http *http) {
    pthread_mutex_lock(&http->lock);
    nsdf_cli_http_stats stats = http->stats;
    stats.size = http->size;
    pthread_mutex_unlock(&http->lock);
    return stats;
}

void nsdf_cli_http_close(nsdf_cli_http **http) {
    nsdf_cli_http *h = *http;
    if (!h)
        return;
    curl_easy_cleanup(h->curl);
    curl_global_cleanup();
    nsdf_cli_extents_free(&h->cache);
    pthread_mutex_destroy(&h->lock);
    free(h);
    *http = NULL;
}

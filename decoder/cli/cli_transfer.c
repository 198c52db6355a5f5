#include "cli_transfer.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "cli_util.h"

enum {
    TRIES = 4,         /* without a byte of progress between them */
    FIRST_PAUSE = 250, /* milliseconds before the second try; doubled before each further one */
    MOST_REDIRECTS = 5,
    MOST_WHOLE = 1 << 30, /* bytes fetched from a server without ranges */
    FIRST_BLOCK = 4096    /* bytes, for a file of unknown size */
};

static void explain(nsdf_cli_transfer *t, const char *format, ...) NSDF_CLI_PRINTF(2, 3);

static void explain(nsdf_cli_transfer *t, const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(t->failure, sizeof t->failure, format, args);
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

static int refuse(nsdf_cli_transfer *t) {
    t->refused = 1;
    return -1;
}

/* The same file as in earlier responses? */
static int check_validator(nsdf_cli_transfer *t) {
    nsdf_cli_remote *remote = t->remote;
    const char *tag = header_value(remote->curl, "ETag");
    const char *value = tag ? tag : header_value(remote->curl, "Last-Modified");
    if (!remote->known)
        snprintf(remote->validator, sizeof remote->validator, "%s", value ? value : "");
    remote->known = 1;
    if (!value || !remote->validator[0] || strncmp(remote->validator, value, sizeof remote->validator - 1) == 0)
        return 0;
    explain(t, "the file changed on the server while it was read; start again");
    return refuse(t);
}

static int learn_size(nsdf_cli_transfer *t, uint64_t size) {
    nsdf_cli_remote *remote = t->remote;
    if (remote->size_known && remote->size != size) {
        explain(t, "the file had %" PRIu64 " bytes and now has %" PRIu64 ": it changed on the server", remote->size,
                size);
        return refuse(t);
    }
    remote->size = size;
    remote->size_known = 1;
    return 0;
}

/* 206: "bytes FIRST-LAST/SIZE". */
static int check_range(nsdf_cli_transfer *t) {
    nsdf_cli_remote *remote = t->remote;
    const uint64_t asked = t->from + t->got;
    const char *range = header_value(remote->curl, "Content-Range");
    uint64_t first, last, size;
    char end;
    if (!range || sscanf(range, "bytes %" SCNu64 "-%" SCNu64 "/%" SCNu64 "%c", &first, &last, &size, &end) != 3) {
        explain(t, "the server's answer to a range request has no usable Content-Range (%.40s)",
                range ? range : "none");
        return refuse(t);
    }
    if (first != asked || last < first || last >= size || size > INT64_MAX) {
        explain(t, "the server was asked for byte %" PRIu64 " on and answered with %.60s", asked, range);
        return refuse(t);
    }
    if (size - t->from < t->wanted)
        t->wanted = (size_t)(size - t->from);
    return learn_size(t, size);
}

/* 200: the server does not do ranges and sends the whole file. */
static int accept_whole(nsdf_cli_transfer *t) {
    nsdf_cli_remote *remote = t->remote;
    curl_off_t length = -1;
    curl_easy_getinfo(remote->curl, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &length);
    if (length > MOST_WHOLE) {
        explain(t, "the server has no ranges, and %lld bytes are too many to fetch at once; download the file",
                (long long)length);
        return refuse(t);
    }
    if (length >= 0 && learn_size(t, (uint64_t)length) != 0)
        return -1;
    if (!remote->whole)
        nsdf_cli_verbose("the server has no ranges: fetching the whole file");
    if (t->from != 0)
        t->got = 0;
    t->from = 0;
    t->skip = t->got;
    t->wanted = remote->size_known ? (size_t)remote->size : SIZE_MAX;
    remote->whole = 1;
    return 0;
}

static int check_response(nsdf_cli_transfer *t) {
    const long code = response_code(t->remote->curl);
    t->checked = 1;
    if (check_validator(t) != 0)
        return -1;
    if (code == 206)
        return check_range(t);
    if (code == 200)
        return accept_whole(t);
    explain(t, "the server answered with status %ld", code);
    return refuse(t);
}

/* ---- The body ------------------------------------------------------------------------------------------------ */

static int reserve(nsdf_cli_transfer *t, size_t size) {
    if (size <= t->capacity)
        return 0;
    size_t capacity = t->wanted != SIZE_MAX ? t->wanted : size + size / 2 + FIRST_BLOCK;
    if (t->wanted == SIZE_MAX && size > MOST_WHOLE) {
        explain(t, "the server has no ranges, and the file is too large to fetch at once; download it");
        return refuse(t);
    }
    uint8_t *grown = realloc(t->data, capacity);
    if (!grown) {
        explain(t, "no memory for %zu bytes", capacity);
        return refuse(t);
    }
    t->data = grown;
    t->capacity = capacity;
    return 0;
}

/* What comes beyond the bytes wanted ends the transfer. */
static size_t on_body(char *bytes, size_t one, size_t size, void *user) {
    nsdf_cli_transfer *t = user;
    (void)one;
    t->bytes += size;
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

static int is_cancelled(const nsdf_cli_transfer *t) {
    return t->cancel(t->cancel_user);
}

static int on_progress(void *user, curl_off_t a, curl_off_t b, curl_off_t c, curl_off_t d) {
    (void)a, (void)b, (void)c, (void)d;
    return is_cancelled(user);
}

/* ---- Requests ------------------------------------------------------------------------------------------------- */

typedef enum outcome { DONE, AGAIN, FAILED } outcome;

/* A server that never answered is more likely misspelt than resting. */
static int may_pass(const nsdf_cli_remote *remote, CURLcode code, long status) {
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
        return remote->answered;
    case CURLE_HTTP_RETURNED_ERROR:
        return status == 408 || status == 429 || (status >= 500 && status != 501 && status != 505);
    default:
        return 0;
    }
}

static void explain_status(nsdf_cli_transfer *t, long status) {
    const char *meaning = status == 404 || status == 410   ? ": there is no such file"
                          : status == 401 || status == 403 ? ": it does not give us the file"
                          : status >= 500                  ? ": the server has trouble"
                                                           : "";
    explain(t, "the server answered with status %ld%s", status, meaning);
}

/* "SSL certificate problem: self-signed certificate" without what is said already. */
static void explain_distrust(nsdf_cli_transfer *t) {
    const char *detail = t->remote->detail, *colon = strstr(detail, ": ");
    explain(t, "its certificate is not trusted: %.80s (CURL_CA_BUNDLE may name a file of more that are)",
            colon     ? colon + 2
            : *detail ? detail
                      : "no reason given");
}

static void explain_certificates(nsdf_cli_transfer *t) {
    explain(t, "cannot read the certificates that CURL_CA_BUNDLE, SSL_CERT_FILE or SSL_CERT_DIR name");
}

static void explain_code(nsdf_cli_transfer *t, CURLcode code, long status) {
    switch (code) {
    case CURLE_ABORTED_BY_CALLBACK:
        explain(t, "interrupted");
        break;
    case CURLE_COULDNT_RESOLVE_HOST:
        explain(t, "there is no host of that name, or no name server");
        break;
    case CURLE_COULDNT_CONNECT:
        explain(t, "the server cannot be reached, or refuses the connection");
        break;
    case CURLE_OPERATION_TIMEDOUT:
        explain(t, "no byte came in %lu seconds", (unsigned long)t->remote->timeout);
        break;
    case CURLE_PARTIAL_FILE:
    case CURLE_RECV_ERROR:
    case CURLE_GOT_NOTHING:
        explain(t, "the server closed the connection too early");
        break;
    case CURLE_HTTP_RETURNED_ERROR:
        explain_status(t, status);
        break;
    case CURLE_PEER_FAILED_VERIFICATION:
        explain_distrust(t);
        break;
    case CURLE_SSL_CACERT_BADFILE:
        explain_certificates(t);
        break;
    case CURLE_SSL_CONNECT_ERROR:
        explain(t, "no secure connection: %.100s", t->remote->detail);
        break;
    default:
        explain(t, "%s", curl_easy_strerror(code));
    }
}

/* An empty file has no first byte: "416 ... Content-Range: bytes * /0". */
static int is_empty_file(nsdf_cli_transfer *t, CURLcode code, long status) {
    const char *range = header_value(t->remote->curl, "Content-Range");
    return code == CURLE_HTTP_RETURNED_ERROR && status == 416 && !t->remote->size_known && range &&
           strcmp(range, "bytes */0") == 0;
}

static void count_request(nsdf_cli_transfer *t) {
    long size = 0;
    curl_easy_getinfo(t->remote->curl, CURLINFO_HEADER_SIZE, &size);
    t->header_bytes += (uint64_t)size;
    t->requests++;
}

static outcome judge(nsdf_cli_transfer *t, CURLcode code) {
    nsdf_cli_remote *remote = t->remote;
    const long status = response_code(remote->curl);
    if (t->refused)
        return FAILED;
    if (is_empty_file(t, code, status))
        return learn_size(t, 0), t->wanted = 0, DONE;
    if (code == CURLE_OK && !t->checked && check_response(t) != 0)
        return FAILED;
    if (t->checked && (code == CURLE_OK || t->got == t->wanted))
        return DONE;
    explain_code(t, code, status);
    return may_pass(remote, code, status) ? AGAIN : FAILED;
}

static outcome request(nsdf_cli_transfer *t) {
    nsdf_cli_remote *remote = t->remote;
    char range[48];
    t->checked = t->refused = 0;
    t->skip = 0;
    snprintf(range, sizeof range, "%" PRIu64 "-%" PRIu64, t->from + t->got, t->from + t->wanted - 1);
    curl_easy_setopt(remote->curl, CURLOPT_RANGE, remote->whole ? NULL : range);
    curl_easy_setopt(remote->curl, CURLOPT_WRITEDATA, t);
    curl_easy_setopt(remote->curl, CURLOPT_XFERINFODATA, t);
    const CURLcode code = curl_easy_perform(remote->curl);
    count_request(t);
    const outcome result = judge(t, code);
    if (result == DONE) {
        remote->answered = 1;
        if (remote->whole) {
            t->wanted = t->got;
            remote->size = t->got;
            remote->size_known = 1;
        }
    }
    return result;
}

/* Nonzero when it was cancelled meanwhile. */
static int pause_for(nsdf_cli_transfer *t, int milliseconds) {
    const struct timespec step = {0, 25 * 1000000};
    for (; milliseconds > 0 && !is_cancelled(t); milliseconds -= 25)
        nanosleep(&step, NULL);
    if (!is_cancelled(t))
        return 0;
    explain(t, "interrupted");
    return 1;
}

int nsdf_cli_transfer_run(nsdf_cli_transfer *t) {
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
        nsdf_cli_verbose("%s; trying again from byte %" PRIu64, t->failure, t->from + t->got);
        t->retries++;
        if (pause_for(t, pause))
            return -1;
        pause *= 2;
    }
    return 0;
}

/* ---- The connection -----------------------------------------------------------------------------------------------
 */

static void configure(nsdf_cli_remote *remote, const char *url) {
    CURL *curl = remote->curl;
    const long timeout = (long)remote->timeout;
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
    curl_easy_setopt(curl, CURLOPT_ERRORBUFFER, remote->detail);
}

/* libcurl leaves this to its programs. */
static void trust_environment(CURL *curl) {
    const char *file = getenv("CURL_CA_BUNDLE"), *folder = getenv("SSL_CERT_DIR");
    if (!file || !*file)
        file = getenv("SSL_CERT_FILE");
    if (file && *file)
        curl_easy_setopt(curl, CURLOPT_CAINFO, file);
    if (folder && *folder)
        curl_easy_setopt(curl, CURLOPT_CAPATH, folder);
}

int nsdf_cli_remote_open(nsdf_cli_remote *remote, const char *url, uint32_t timeout) {
    *remote = (nsdf_cli_remote){.timeout = timeout};
    if (curl_global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK)
        return -1;
    remote->curl = curl_easy_init();
    if (!remote->curl) {
        curl_global_cleanup();
        return -1;
    }
    configure(remote, url);
    trust_environment(remote->curl);
    return 0;
}

void nsdf_cli_remote_close(nsdf_cli_remote *remote) {
    if (!remote->curl)
        return;
    curl_easy_cleanup(remote->curl);
    curl_global_cleanup();
    *remote = (nsdf_cli_remote){.curl = NULL};
}

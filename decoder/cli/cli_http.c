/* The bytes of a remote file that are known, and those that are being fetched.
 *
 * The first request asks for PREFIX bytes: enough for the front of most files, and little beside a segment.  Later ones
 * ask for what the decoder reads and nothing else, except that short reads (of chunk headers) take READ_AHEAD bytes, so
 * that a chunk does not cost one request for its length and one for its bytes.
 *
 * One transfer runs at a time, without the lock, so that what is known can be read meanwhile.  A read of other bytes
 * than those that are fetched ahead stops that transfer; what it got stays. */
#include "cli_http.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli_extents.h"
#include "cli_transfer.h"
#include "cli_util.h"

enum {
    PREFIX = 2048,
    READ_AHEAD = 256,
    MOST_CACHED = 1 << 28 /* bytes; a server without ranges may need more */
};

struct nsdf_cli_http {
    nsdf_cli_http_options options;
    atomic_int cancelled;
    pthread_mutex_t lock; /* of all below but `remote`, which belongs to the transfer that runs */
    pthread_cond_t changed;
    nsdf_cli_remote remote;
    uint64_t size; /* set before there are other threads */
    int busy;      /* a transfer runs */
    nsdf_cli_extents cache;
    nsdf_cli_http_stats stats;
    char failure[160];
    /* Fetching ahead, by a thread that is started when it is first asked for. */
    pthread_t thread;
    int has_thread;
    uint64_t ahead_from, ahead_to; /* what is to be fetched; empty = nothing */
    atomic_int hurry;              /* a read waits for other bytes */
};

/* ---- Transfers --------------------------------------------------------------------------------------------------- */

static int is_cancelled(void *user) {
    const nsdf_cli_http *http = user;
    return atomic_load(&http->cancelled) || (http->options.cancel && http->options.cancel(http->options.cancel_user));
}

static int is_ahead_over(void *user) {
    nsdf_cli_http *http = user;
    return atomic_load(&http->hurry) || is_cancelled(http);
}

/* What a transfer got into the cache.  0, or -1 without memory. */
static int keep(nsdf_cli_http *http, nsdf_cli_transfer *t, int complete) {
    if (t->got == 0 || (http->remote.whole && !complete)) {
        free(t->data);
        return 0;
    }
    if (http->remote.whole)
        nsdf_cli_extents_free(&http->cache);
    if (nsdf_cli_extents_add(&http->cache, t->from, t->data, t->got) == 0)
        return 0;
    free(t->data);
    snprintf(http->failure, sizeof http->failure, "out of memory");
    return -1;
}

static void count(nsdf_cli_http *http, const nsdf_cli_transfer *t, double seconds) {
    http->stats.bytes += t->bytes;
    http->stats.header_bytes += t->header_bytes;
    http->stats.requests += t->requests;
    http->stats.retries += t->retries;
    http->stats.transfer_seconds += seconds;
    http->stats.whole = http->remote.whole;
}

/* With the lock, while nothing is busy: fetches the bytes [from, to), without the lock.  0, or -1. */
static int fetch(nsdf_cli_http *http, uint64_t from, uint64_t to, int ahead) {
    nsdf_cli_transfer t = {.remote = &http->remote,
                           .cancel = ahead ? is_ahead_over : is_cancelled,
                           .cancel_user = http,
                           .from = from,
                           .wanted = (size_t)(to - from)};
    http->busy = 1;
    pthread_mutex_unlock(&http->lock);
    const double began = nsdf_cli_clock();
    int result = nsdf_cli_transfer_run(&t);
    const double seconds = nsdf_cli_clock() - began;
    pthread_mutex_lock(&http->lock);
    http->busy = 0;
    count(http, &t, seconds);
    if (result != 0 && !ahead)
        memcpy(http->failure, t.failure, sizeof http->failure);
    if (keep(http, &t, result == 0) != 0)
        result = -1;
    pthread_cond_broadcast(&http->changed);
    return result;
}

/* ---- The decoder's side ------------------------------------------------------------------------------------------ */

static uint64_t least(uint64_t a, uint64_t b) {
    return a < b ? a : b;
}

/* Waits for the transfer that runs; one ahead of bytes that are not those from `from` on is told to stop. */
static void wait_for_turn(nsdf_cli_http *http, uint64_t from) {
    if (from < http->ahead_from || from >= http->ahead_to)
        atomic_store(&http->hurry, 1);
    pthread_cond_wait(&http->changed, &http->lock);
}

static int make_present(nsdf_cli_http *http, uint64_t offset, uint64_t size) {
    uint64_t from, to, room;
    int result = 0;
    while (result == 0 && nsdf_cli_extents_gap(&http->cache, offset, size, &from, &to, &room)) {
        if (http->busy) {
            wait_for_turn(http, from);
            continue;
        }
        if (to - from < READ_AHEAD)
            to = least(least(from + READ_AHEAD, room), http->size);
        result = fetch(http, from, to, 0);
    }
    if (atomic_exchange(&http->hurry, 0))
        pthread_cond_broadcast(&http->changed);
    return result;
}

static int read_at(void *user, uint64_t offset, void *dst, size_t size) {
    nsdf_cli_http *http = user;
    pthread_mutex_lock(&http->lock);
    const double began = nsdf_cli_clock();
    const int result = make_present(http, offset, size);
    http->stats.seconds += nsdf_cli_clock() - began;
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

/* ---- Ahead --------------------------------------------------------------------------------------------------------
 */

/* Fetches what is asked for, piece by piece, unless it fails: a read will say why. */
static void *run_ahead(void *user) {
    nsdf_cli_http *http = user;
    uint64_t from, to, room;
    pthread_mutex_lock(&http->lock);
    while (!atomic_load(&http->cancelled)) {
        const int wanted = http->ahead_from < http->ahead_to && !atomic_load(&http->hurry);
        if (!wanted || http->busy) {
            pthread_cond_wait(&http->changed, &http->lock);
            continue;
        }
        const uint64_t size = http->ahead_to - http->ahead_from;
        if (!nsdf_cli_extents_gap(&http->cache, http->ahead_from, size, &from, &to, &room) ||
            fetch(http, from, to, 1) != 0)
            http->ahead_to = http->ahead_from;
    }
    pthread_mutex_unlock(&http->lock);
    return NULL;
}

void nsdf_cli_http_ahead(nsdf_cli_http *http, uint64_t offset, uint64_t size) {
    pthread_mutex_lock(&http->lock);
    const int fits = offset <= http->size && size <= http->size - offset;
    if (fits && !http->has_thread)
        http->has_thread = pthread_create(&http->thread, NULL, run_ahead, http) == 0;
    if (fits && http->ahead_from == http->ahead_to && !http->stats.whole) {
        http->ahead_from = offset;
        http->ahead_to = offset + size;
        pthread_cond_broadcast(&http->changed);
    }
    pthread_mutex_unlock(&http->lock);
}

/* ---- Opening and closing ------------------------------------------------------------------------------------------
 */

static nsdf_status fail_open(nsdf_error *error, nsdf_status status, const char *message) {
    *error = (nsdf_error){.status = status};
    snprintf(error->message, sizeof error->message, "%s", message);
    return status;
}

/* The front of the file, and its size. */
static int fetch_front(nsdf_cli_http *http) {
    pthread_mutex_lock(&http->lock);
    const int result = fetch(http, 0, PREFIX, 0);
    http->size = http->remote.size;
    http->stats.seconds = http->stats.transfer_seconds;
    pthread_mutex_unlock(&http->lock);
    return result;
}

nsdf_status nsdf_cli_http_open(nsdf_cli_http **http, const char *url, const nsdf_cli_http_options *options,
                               nsdf_error *error) {
    nsdf_cli_http *h = calloc(1, sizeof *h);
    if (!h || nsdf_cli_remote_open(&h->remote, url, options->timeout) != 0) {
        free(h);
        return fail_open(error, NSDF_NO_MEMORY, "no memory for the network");
    }
    h->options = *options;
    pthread_mutex_init(&h->lock, NULL);
    pthread_cond_init(&h->changed, NULL);
    if (fetch_front(h) != 0) {
        fail_open(error, NSDF_IO, h->failure);
        nsdf_cli_http_close(&h);
        return error->status;
    }
    *http = h;
    return NSDF_OK;
}

void nsdf_cli_http_cancel(nsdf_cli_http *http) {
    pthread_mutex_lock(&http->lock);
    atomic_store(&http->cancelled, 1);
    pthread_cond_broadcast(&http->changed);
    pthread_mutex_unlock(&http->lock);
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
    nsdf_cli_http_cancel(h);
    if (h->has_thread)
        pthread_join(h->thread, NULL);
    nsdf_cli_remote_close(&h->remote);
    nsdf_cli_extents_free(&h->cache);
    pthread_cond_destroy(&h->changed);
    pthread_mutex_destroy(&h->lock);
    free(h);
    *http = NULL;
}

/* Reading .nsdf files by HTTP, from a server with every habit there is: the right bytes, none of them twice, and no
 * more than are needed. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "cli_http.h"
#include "cli_util.h"
#include "container_write.h"
#include "http_server.h"
#include "make_file.h"

enum { SEGMENTS = 67, FRAMES_EACH = 30 };

/* ---- A long file ------------------------------------------------------------------------------------------------ */

typedef struct long_file {
    uint8_t *data;
    size_t size;
    nsdf_index_entry entries[SEGMENTS];
} long_file;

static long_file file; /* 2,011 frames; made once */

static void make_piece(nsdf_buffer *payload, nsdf_index_entry *entry, uint32_t index, uint64_t *random) {
    nsdf_network_desc desc;
    int32_t *q;
    float *values;
    make_network(&desc, MAKE_SPLINE, 3, 32, NSDF_ENTROPY_NONE);
    make_parameters(&desc, random, &q, &values);
    nsdf_write_segment_start(payload, 1);
    assert_int_equal(nsdf_write_network_part(payload, &desc, q), 0);
    *entry = (nsdf_index_entry){.first_frame = FRAMES_EACH * index, .last_frame = FRAMES_EACH * (index + 1)};
    entry->parameter_hash = nsdf_hash_floats(NSDF_HASH_START, values, (size_t)nsdf_parameter_count(&desc.list));
    free(q);
    free(values);
}

static int make_long_file(void **state) {
    nsdf_buffer payloads[SEGMENTS] = {{NULL, 0, 0, 0}}, metadata = {NULL, 0, 0, 0}, out = {NULL, 0, 0, 0};
    const nsdf_quality_record quality = {{1e-4, 2e-4}, {3e-4, 4e-4}, {5e-4, 6e-4}, 128, 10};
    nsdf_file_header header;
    uint64_t random = 7;
    (void)state;
    make_header(&header, SEGMENTS * FRAMES_EACH + 1, SEGMENTS);
    for (uint32_t i = 0; i < SEGMENTS; i++)
        make_piece(&payloads[i], &file.entries[i], i, &random);
    nsdf_write_metadata(&metadata, "title", "long");
    nsdf_file_parts parts = {header, payloads, file.entries, &metadata, &quality, NULL, 0};
    assert_int_equal(nsdf_write_file(&out, &parts), 0);
    for (uint32_t i = 0; i < SEGMENTS; i++)
        nsdf_buffer_free(&payloads[i]);
    nsdf_buffer_free(&metadata);
    file.data = out.data;
    file.size = out.size;
    return 0;
}

static int free_long_file(void **state) {
    (void)state;
    free(file.data);
    return 0;
}

/* ---- Client and server ------------------------------------------------------------------------------------------- */

typedef struct visit {
    http_server *server;
    nsdf_cli_http *http;
    nsdf_io io;
    nsdf_error error;
    nsdf_status status;
} visit;

static visit begin(http_mode mode, uint64_t limit, const char *path) {
    visit v = {.server = http_server_start(file.data, file.size, mode, limit)};
    const nsdf_cli_http_options options = {.timeout = mode == HTTP_SILENT ? 1 : mode == HTTP_SLOW ? 2 : 20};
    char url[128];
    assert_non_null(v.server);
    snprintf(url, sizeof url, "http://127.0.0.1:%u%s", http_server_port(v.server), path);
    v.status = nsdf_cli_http_open(&v.http, url, &options, &v.error);
    if (v.status == NSDF_OK)
        v.io = nsdf_cli_http_io(v.http);
    return v;
}

static http_log end(visit *v) {
    nsdf_cli_http_close(&v->http);
    return http_server_stop(v->server);
}

static void assert_reads(const visit *v, uint64_t offset, size_t size) {
    uint8_t *bytes = malloc(size);
    assert_non_null(bytes);
    assert_int_equal(v->io.read_at(v->io.user, offset, bytes, size), 0);
    assert_memory_equal(bytes, file.data + offset, size);
    free(bytes);
}

/* The reads fail, and the text says why. */
static void assert_refuses(const visit *v, uint64_t offset, size_t size, const char *why) {
    char text[200];
    uint8_t *bytes = malloc(size);
    assert_non_null(bytes);
    assert_int_not_equal(v->io.read_at(v->io.user, offset, bytes, size), 0);
    nsdf_cli_http_failure(v->http, text, sizeof text);
    if (!strstr(text, why))
        fail_msg("'%s' does not mention '%s'", text, why);
    free(bytes);
}

static void assert_open_fails(http_mode mode, uint64_t limit, const char *why) {
    visit v = begin(mode, limit, "/file");
    assert_int_equal(v.status, NSDF_IO);
    assert_null(v.http);
    if (!strstr(v.error.message, why))
        fail_msg("'%s' does not mention '%s'", v.error.message, why);
    end(&v);
}

/* No byte of the file was sent twice. */
static void assert_no_byte_twice(const http_log *log) {
    uint8_t *sent = calloc(file.size, 1);
    assert_non_null(sent);
    assert_true(log->requests <= HTTP_ANSWERS);
    for (uint32_t i = 0; i < log->requests; i++)
        for (uint64_t k = 0; k < log->answers[i].sent; k++)
            assert_int_equal(sent[log->answers[i].first + k]++, 0);
    free(sent);
}

/* ---- Tests --------------------------------------------------------------------------------------------------------
 */

static void ranges_are_read_once_and_correctly(void **state) {
    uint64_t random = 3;
    visit v = begin(HTTP_RANGES, 0, "/file");
    (void)state;
    assert_int_equal(v.status, NSDF_OK);
    assert_true(v.io.size == file.size);
    for (int i = 0; i < 300; i++) {
        const uint64_t offset = make_random(&random) % file.size, most = file.size - offset;
        const size_t size = (size_t)(1 + make_random(&random) % (i % 2 ? 20 : 5000));
        assert_reads(&v, offset, size < most ? size : (size_t)most);
    }
    const nsdf_cli_http_stats stats = nsdf_cli_http_get_stats(v.http);
    const http_log log = end(&v);
    assert_int_equal(log.connections, 1);
    assert_no_byte_twice(&log);
    assert_true(stats.bytes == log.bytes);
    assert_true(stats.header_bytes == log.header_bytes);
    assert_int_equal(stats.requests, log.requests);
    assert_int_equal(stats.retries, 0);
    assert_false(stats.whole);
}

static void the_end_of_the_file_can_be_read(void **state) {
    visit v = begin(HTTP_RANGES, 0, "/file");
    (void)state;
    assert_reads(&v, file.size - 1, 1);
    assert_reads(&v, file.size - 3000, 3000);
    assert_reads(&v, 0, file.size);
    const http_log log = end(&v);
    assert_no_byte_twice(&log);
    assert_true(log.bytes == file.size);
}

/* Two seconds from the middle: what is played, and what was transferred for it. */
static void playing_from_the_middle_transfers_little(void **state) {
    visit v = begin(HTTP_RANGES, 0, "/file");
    nsdf_decoder *decoder = NULL;
    nsdf_error error;
    nsdf_info info;
    (void)state;
    assert_int_equal(nsdf_open_callbacks(&decoder, &v.io, NULL, &error), NSDF_OK);
    assert_int_equal(nsdf_get_info(decoder, &info), NSDF_OK);
    const double begun = info.duration / 2.0;
    for (double t = begun; t < begun + 2.0; t += 1.0 / 24.0) {
        const float point[3] = {1.0f, 2.0f, 3.0f};
        float distance;
        assert_int_equal(nsdf_evaluate(decoder, t, point, 1, &distance, NULL), NSDF_OK);
    }
    uint64_t needed = file.entries[0].offset, touched = 0;
    for (uint32_t i = 0; i < SEGMENTS; i++) {
        nsdf_segment_info s;
        assert_int_equal(nsdf_get_segment_extent(decoder, i, &s), NSDF_OK);
        if (s.start <= begun + 2.0 && s.end > begun)
            needed += s.size, touched++;
    }
    nsdf_close(&decoder);
    const http_log log = end(&v);
    print_message("    %llu segments, %llu bytes needed, %llu sent, and %llu of headers, in %lu requests\n",
                  (unsigned long long)touched, (unsigned long long)needed, (unsigned long long)log.bytes,
                  (unsigned long long)log.header_bytes, (unsigned long)log.requests);
    assert_no_byte_twice(&log);
    assert_in_range(touched, 2, 3);
    assert_true(log.bytes >= needed);
    assert_true(10 * (log.bytes + log.header_bytes) <= 11 * needed);
}

/* The front of a file costs a request, or two; a segment one. */
static void a_segment_is_one_request(void **state) {
    visit v = begin(HTTP_RANGES, 0, "/file");
    nsdf_decoder *decoder = NULL;
    (void)state;
    assert_int_equal(nsdf_open_callbacks(&decoder, &v.io, NULL, NULL), NSDF_OK);
    const uint32_t front = nsdf_cli_http_get_stats(v.http).requests;
    assert_int_equal(nsdf_prepare(decoder, 10.0), NSDF_OK);
    assert_int_equal(nsdf_cli_http_get_stats(v.http).requests, front + 1);
    assert_in_range(front, 1, 3);
    nsdf_close(&decoder);
    end(&v);
}

static void a_server_without_ranges_is_asked_once(void **state) {
    static const http_mode modes[] = {HTTP_NO_RANGES, HTTP_NO_LENGTH};
    (void)state;
    for (int i = 0; i < 2; i++) {
        visit v = begin(modes[i], 0, "/file");
        assert_int_equal(v.status, NSDF_OK);
        assert_true(v.io.size == file.size);
        assert_reads(&v, 0, file.size);
        assert_reads(&v, file.size - 100, 100);
        assert_true(nsdf_cli_http_get_stats(v.http).whole);
        const http_log log = end(&v);
        assert_int_equal(log.requests, 1);
        assert_true(log.bytes == file.size);
    }
}

static void dropped_connections_go_on_where_they_broke(void **state) {
    visit v = begin(HTTP_DROP, 1500, "/file");
    (void)state;
    assert_int_equal(v.status, NSDF_OK);
    assert_reads(&v, 5000, 4000);
    const nsdf_cli_http_stats stats = nsdf_cli_http_get_stats(v.http);
    const http_log log = end(&v);
    assert_no_byte_twice(&log);
    assert_int_equal(stats.retries, 3); /* one of the prefix, two of 4000 bytes */
    assert_int_equal(log.connections, 4);
}

static void without_ranges_a_dropped_file_is_begun_again(void **state) {
    visit v = begin(HTTP_DROP_WHOLE, file.size / 3 + 1, "/file");
    (void)state;
    assert_int_equal(v.status, NSDF_OK);
    assert_reads(&v, 0, file.size);
    const http_log log = end(&v);
    assert_int_equal(log.requests, 3);
}

static void connections_that_only_drop_are_given_up(void **state) {
    (void)state;
    assert_open_fails(HTTP_DROP, 0, "closed the connection too early");
}

static void slow_servers_are_waited_for(void **state) {
    visit v = begin(HTTP_SLOW, 2500, "/file");
    (void)state;
    assert_int_equal(v.status, NSDF_OK);
    const double began = nsdf_cli_clock();
    assert_reads(&v, 9000, 6000); /* longer than the timeout, which is for silence */
    assert_true(nsdf_cli_clock() - began > 2.1);
    assert_true(nsdf_cli_http_get_stats(v.http).seconds > 2.1);
    assert_int_equal(nsdf_cli_http_get_stats(v.http).retries, 0);
    end(&v);
}

static void busy_servers_are_asked_again(void **state) {
    visit v = begin(HTTP_BUSY, 2, "/file");
    (void)state;
    assert_int_equal(v.status, NSDF_OK);
    assert_reads(&v, 0, 100);
    assert_int_equal(nsdf_cli_http_get_stats(v.http).retries, 2);
    end(&v);
    assert_open_fails(HTTP_BUSY, 99, "status 503");
}

static void missing_files_are_refused_at_once(void **state) {
    visit v = begin(HTTP_NOT_FOUND, 0, "/file");
    (void)state;
    assert_int_equal(v.status, NSDF_IO);
    assert_non_null(strstr(v.error.message, "404"));
    assert_int_equal(end(&v).requests, 1);
}

static void wrong_ranges_are_refused(void **state) {
    (void)state;
    assert_open_fails(HTTP_WRONG_RANGE, 0, "answered with bytes 1-2048/");
}

static void files_that_change_are_refused(void **state) {
    visit v = begin(HTTP_CHANGED, 2, "/file");
    (void)state;
    assert_reads(&v, 10000, 2000);
    assert_refuses(&v, 20000, 2000, "changed on the server");
    assert_reads(&v, 10500, 500);
    end(&v);
    v = begin(HTTP_GROWN, 1, "/file");
    assert_refuses(&v, 20000, 2000, "changed on the server");
    end(&v);
}

static void redirects_are_followed(void **state) {
    visit v = begin(HTTP_REDIRECT, 0, "/other");
    (void)state;
    assert_int_equal(v.status, NSDF_OK);
    assert_reads(&v, 5000, 5000);
    end(&v);
}

static void small_and_empty_files_are_read(void **state) {
    static const size_t sizes[] = {0, 1, 100, 2047, 2048, 2049};
    const size_t all = file.size;
    (void)state;
    for (int i = 0; i < 12; i++) {
        file.size = sizes[i / 2];
        visit v = begin(i % 2 ? HTTP_NO_RANGES : HTTP_RANGES, 0, "/file");
        assert_int_equal(v.status, NSDF_OK);
        assert_true(v.io.size == file.size);
        if (file.size > 0)
            assert_reads(&v, 0, file.size);
        end(&v);
        file.size = all;
    }
}

static void nobody_listening_is_an_error(void **state) {
    http_server *server = http_server_start(file.data, file.size, HTTP_RANGES, 0);
    nsdf_cli_http_options options = {.timeout = 1};
    nsdf_cli_http *http = NULL;
    nsdf_error error;
    char url[64];
    (void)state;
    snprintf(url, sizeof url, "http://127.0.0.1:%u/file", http_server_port(server));
    http_server_stop(server);
    const double began = nsdf_cli_clock();
    assert_int_equal(nsdf_cli_http_open(&http, url, &options, &error), NSDF_IO);
    assert_non_null(strstr(error.message, "cannot be reached"));
    assert_true(nsdf_cli_clock() - began < 1.0); /* no tries: it was never there */
    options.timeout = 60;                        /* that of the name server is shorter */
    assert_int_equal(nsdf_cli_http_open(&http, "http://nobody.invalid/file", &options, &error), NSDF_IO);
    assert_non_null(strstr(error.message, "no host of that name"));
    assert_null(http);
}

/* ---- Giving up ------------------------------------------------------------------------------------------------------
 */

static int later(void *user) {
    return nsdf_cli_clock() > *(double *)user;
}

static void silence_can_be_interrupted(void **state) {
    http_server *server = http_server_start(file.data, file.size, HTTP_SILENT, 0);
    double until = nsdf_cli_clock() + 0.2;
    const nsdf_cli_http_options options = {.timeout = 60, .cancel = later, .cancel_user = &until};
    nsdf_cli_http *http = NULL;
    nsdf_error error;
    char url[64];
    (void)state;
    snprintf(url, sizeof url, "http://127.0.0.1:%u/file", http_server_port(server));
    assert_int_equal(nsdf_cli_http_open(&http, url, &options, &error), NSDF_IO);
    assert_string_equal(error.message, "interrupted");
    assert_true(nsdf_cli_clock() < until + 3.0);
    http_server_stop(server);
}

static void silence_ends_by_the_timeout(void **state) {
    const double began = nsdf_cli_clock();
    (void)state;
    assert_open_fails(HTTP_SILENT, 0, "no byte came in 1 second");
    assert_true(nsdf_cli_clock() - began < 20.0);
}

/* ---- Ahead ----------------------------------------------------------------------------------------------------------
 */

static void wait_for_bytes(const visit *v, uint64_t bytes) {
    const struct timespec moment = {0, 5000000};
    const double began = nsdf_cli_clock();
    while (nsdf_cli_http_get_stats(v->http).bytes < bytes && nsdf_cli_clock() - began < 20.0)
        nanosleep(&moment, NULL);
}

static void what_was_fetched_ahead_is_not_asked_for(void **state) {
    visit v = begin(HTTP_RANGES, 0, "/file");
    (void)state;
    nsdf_cli_http_ahead(v.http, file.size, 1); /* not in the file */
    nsdf_cli_http_ahead(v.http, 9000, 6000);
    nsdf_cli_http_ahead(v.http, 50000, 6000); /* one at a time */
    wait_for_bytes(&v, 8048);
    const nsdf_cli_http_stats before = nsdf_cli_http_get_stats(v.http);
    assert_int_equal(before.bytes, 8048);
    assert_reads(&v, 9000, 6000);
    assert_reads(&v, 14000, 2000);
    const http_log log = end(&v);
    assert_no_byte_twice(&log);
    assert_true(log.bytes == 9048); /* the prefix, 9000 to 14999, and to 15999 */
}

/* A read of bytes that are on their way waits for them; one of others does not. */
static void reads_wait_for_their_bytes_only(void **state) {
    visit v = begin(HTTP_SLOW, 20000, "/file");
    (void)state;
    nsdf_cli_http_ahead(v.http, 9000, 10000);
    assert_reads(&v, 10000, 4000);
    assert_int_equal(nsdf_cli_http_get_stats(v.http).requests, 2);
    nsdf_cli_http_ahead(v.http, 20000, 100000); /* five seconds */
    const double began = nsdf_cli_clock();
    assert_reads(&v, 150000, 1000);
    assert_true(nsdf_cli_clock() - began < 3.0);
    assert_reads(&v, 20000, 2000); /* what had come, and what had not */
    end(&v);
}

static void closing_stops_fetching_ahead(void **state) {
    visit v = begin(HTTP_SLOW, 10000, "/file");
    (void)state;
    nsdf_cli_http_ahead(v.http, 9000, 100000);
    const double began = nsdf_cli_clock();
    end(&v);
    assert_true(nsdf_cli_clock() - began < 3.0);
}

static void failures_ahead_are_left_to_reads(void **state) {
    char text[200];
    visit v = begin(HTTP_CHANGED, 1, "/file");
    (void)state;
    nsdf_cli_http_ahead(v.http, 9000, 1000);
    for (int i = 0; i < 2000 && nsdf_cli_http_get_stats(v.http).requests < 2; i++)
        nanosleep(&(struct timespec){0, 5000000}, NULL);
    nsdf_cli_http_failure(v.http, text, sizeof text);
    assert_string_equal(text, "");
    assert_refuses(&v, 9000, 1000, "changed on the server");
    assert_reads(&v, 0, 2048);
    end(&v);
}

/* ---- Threads --------------------------------------------------------------------------------------------------------
 */

static void *read_some(void *user) {
    const visit *v = user;
    uint8_t bytes[3000];
    uint64_t random = 11;
    for (int i = 0; i < 40; i++) {
        const uint64_t offset = make_random(&random) % (file.size - sizeof bytes);
        if (v->io.read_at(v->io.user, offset, bytes, sizeof bytes) != 0 ||
            memcmp(bytes, file.data + offset, sizeof bytes) != 0)
            return "wrong bytes";
    }
    return NULL;
}

static void read_with_threads(visit *v, int ahead) {
    pthread_t threads[3];
    for (int i = 0; i < 3; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, read_some, v), 0);
    for (uint64_t i = 0; ahead && i < 200; i++)
        nsdf_cli_http_ahead(v->http, 700 * i, 20000);
    for (int i = 0; i < 3; i++) {
        void *problem = "not ended";
        assert_int_equal(pthread_join(threads[i], &problem), 0);
        assert_null(problem);
    }
}

static void reads_and_fetching_ahead_go_together(void **state) {
    (void)state;
    for (int i = 0; i < 10; i++) {
        visit v = begin(HTTP_RANGES, 0, "/file");
        read_with_threads(&v, 1);
        end(&v);
    }
}

static void threads_share_a_connection(void **state) {
    visit v = begin(HTTP_RANGES, 0, "/file");
    (void)state;
    read_with_threads(&v, 0);
    const http_log log = end(&v);
    assert_no_byte_twice(&log);
    assert_int_equal(log.connections, 1);
}

static void *cancel_soon(void *user) {
    const struct timespec while_it_waits = {0, 200000000};
    nanosleep(&while_it_waits, NULL);
    nsdf_cli_http_cancel(user);
    return NULL;
}

static void another_thread_may_cancel(void **state) {
    visit v = begin(HTTP_SLOW, 10000, "/file");
    pthread_t thread;
    (void)state;
    assert_int_equal(pthread_create(&thread, NULL, cancel_soon, v.http), 0);
    const double began = nsdf_cli_clock();
    assert_refuses(&v, 2048, file.size - 2048, "interrupted");
    assert_true(nsdf_cli_clock() - began < 3.0);
    pthread_join(thread, NULL);
    end(&v);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ranges_are_read_once_and_correctly),
        cmocka_unit_test(the_end_of_the_file_can_be_read),
        cmocka_unit_test(playing_from_the_middle_transfers_little),
        cmocka_unit_test(a_segment_is_one_request),
        cmocka_unit_test(a_server_without_ranges_is_asked_once),
        cmocka_unit_test(dropped_connections_go_on_where_they_broke),
        cmocka_unit_test(without_ranges_a_dropped_file_is_begun_again),
        cmocka_unit_test(connections_that_only_drop_are_given_up),
        cmocka_unit_test(slow_servers_are_waited_for),
        cmocka_unit_test(busy_servers_are_asked_again),
        cmocka_unit_test(missing_files_are_refused_at_once),
        cmocka_unit_test(wrong_ranges_are_refused),
        cmocka_unit_test(files_that_change_are_refused),
        cmocka_unit_test(redirects_are_followed),
        cmocka_unit_test(small_and_empty_files_are_read),
        cmocka_unit_test(nobody_listening_is_an_error),
        cmocka_unit_test(silence_can_be_interrupted),
        cmocka_unit_test(silence_ends_by_the_timeout),
        cmocka_unit_test(what_was_fetched_ahead_is_not_asked_for),
        cmocka_unit_test(reads_wait_for_their_bytes_only),
        cmocka_unit_test(closing_stops_fetching_ahead),
        cmocka_unit_test(failures_ahead_are_left_to_reads),
        cmocka_unit_test(threads_share_a_connection),
        cmocka_unit_test(reads_and_fetching_ahead_go_together),
        cmocka_unit_test(another_thread_may_cancel),
    };
    nsdf_cli_set_verbosity(-1);
    setenv("no_proxy", "127.0.0.1,nobody.invalid", 1);
    return cmocka_run_group_tests(tests, make_long_file, free_long_file);
}

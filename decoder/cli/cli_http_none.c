/* In place of cli_http.c where there is no libcurl: URLs are refused. */
#include "cli_http.h"

#include <string.h>

nsdf_status nsdf_cli_http_open(nsdf_cli_http **http, const char *url, const nsdf_cli_http_options *options,
                               nsdf_error *error) {
    (void)http, (void)url, (void)options;
    *error = (nsdf_error){.status = NSDF_IO,
                          .message = "this program was built without libcurl and reads no URLs; download the file"};
    return error->status;
}

nsdf_io nsdf_cli_http_io(nsdf_cli_http *http) {
    (void)http;
    return (nsdf_io){.size = 0};
}

void nsdf_cli_http_ahead(nsdf_cli_http *http, uint64_t offset, uint64_t size) {
    (void)http, (void)offset, (void)size;
}

void nsdf_cli_http_cancel(nsdf_cli_http *http) {
    (void)http;
}

void nsdf_cli_http_failure(nsdf_cli_http *http, char *text, size_t size) {
    (void)http;
    memset(text, 0, size);
}

nsdf_cli_http_stats nsdf_cli_http_get_stats(nsdf_cli_http *http) {
    (void)http;
    return (nsdf_cli_http_stats){.size = 0};
}

void nsdf_cli_http_close(nsdf_cli_http **http) {
    (void)http;
}

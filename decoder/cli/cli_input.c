#include "cli_input.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "cli_http.h"
#include "cli_util.h"

struct nsdf_cli_input {
    nsdf_cli_http *http; /* NULL for a file */
    char name[];
};

int nsdf_cli_is_url(const char *name) {
    return strncasecmp(name, "http://", 7) == 0 || strncasecmp(name, "https://", 8) == 0;
}

static nsdf_status fail(nsdf_error *error, nsdf_status status, const char *message) {
    *error = (nsdf_error){.status = status};
    snprintf(error->message, sizeof error->message, "%s", message);
    return status;
}

static nsdf_status open_name(nsdf_cli_input *input, uint32_t timeout, nsdf_error *error) {
    if (nsdf_cli_is_url(input->name)) {
        const nsdf_cli_http_options options = {.timeout = timeout, .cancel = nsdf_cli_is_interrupted};
        return nsdf_cli_http_open(&input->http, input->name, &options, error);
    }
    if (nsdf_cli_is_folder(input->name))
        return fail(error, NSDF_IO, "a folder, not an .nsdf file");
    return NSDF_OK;
}

nsdf_cli_input *nsdf_cli_input_open(const char *name, uint32_t timeout, nsdf_error *error) {
    nsdf_cli_input *input = malloc(sizeof *input + strlen(name) + 1);
    if (!input) {
        fail(error, NSDF_NO_MEMORY, nsdf_status_string(NSDF_NO_MEMORY));
        return NULL;
    }
    input->http = NULL;
    strcpy(input->name, name);
    if (open_name(input, timeout, error) == NSDF_OK)
        return input;
    nsdf_cli_input_close(input);
    return NULL;
}

nsdf_status nsdf_cli_input_decoder(nsdf_cli_input *input, nsdf_decoder **decoder, const nsdf_decoder_options *options,
                                   nsdf_error *error) {
    if (!input->http)
        return nsdf_open_file(decoder, input->name, options, error);
    const nsdf_io io = nsdf_cli_http_io(input->http);
    nsdf_error why;
    const nsdf_status status = nsdf_open_callbacks(decoder, &io, options, &why);
    if (status == NSDF_OK)
        return status;
    nsdf_cli_input_explain(input, &why);
    if (error)
        *error = why;
    return status;
}

void nsdf_cli_input_explain(nsdf_cli_input *input, nsdf_error *error) {
    char text[sizeof error->message];
    if (!input->http || error->status != NSDF_IO)
        return;
    nsdf_cli_http_failure(input->http, text, sizeof text);
    if (text[0])
        fail(error, NSDF_IO, text);
}

const char *nsdf_cli_input_name(const nsdf_cli_input *input) {
    return input->name;
}

int nsdf_cli_input_is_remote(const nsdf_cli_input *input) {
    return input->http != NULL;
}

void nsdf_cli_input_cancel(nsdf_cli_input *input) {
    if (input->http)
        nsdf_cli_http_cancel(input->http);
}

double nsdf_cli_input_waited(nsdf_cli_input *input) {
    return input->http ? nsdf_cli_http_get_stats(input->http).seconds : 0.0;
}

/* Half as long again as such a transfer would have taken so far, and a moment for the round trip. */
void nsdf_cli_input_ahead(nsdf_cli_input *input, uint64_t offset, uint64_t size, double seconds) {
    if (!input->http)
        return;
    const nsdf_cli_http_stats s = nsdf_cli_http_get_stats(input->http);
    const double needed = s.bytes > 0 ? s.transfer_seconds / (double)s.bytes * (double)size : 0.0;
    if (seconds < 1.5 * needed + 0.25)
        nsdf_cli_http_ahead(input->http, offset, size);
}

void nsdf_cli_input_report(nsdf_cli_input *input, int level) {
    if (!input->http || nsdf_cli_verbosity() < level)
        return;
    const nsdf_cli_http_stats s = nsdf_cli_http_get_stats(input->http);
    nsdf_cli_say("%llu of %llu bytes fetched in %lu request%s, and %llu bytes of headers%s",
                 (unsigned long long)s.bytes, (unsigned long long)s.size, (unsigned long)s.requests,
                 s.requests == 1 ? "" : "s", (unsigned long long)s.header_bytes,
                 s.whole ? "; the server has no ranges" : "");
    if (s.retries > 0)
        nsdf_cli_say("%lu of the requests were made again after a failure", (unsigned long)s.retries);
}

void nsdf_cli_input_close(nsdf_cli_input *input) {
    if (!input)
        return;
    nsdf_cli_http_close(&input->http);
    free(input);
}

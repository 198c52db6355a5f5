#include "input_error.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

nsdf_shown_path nsdf_show_path(const char *path) {
    nsdf_shown_path shown;
    size_t length = strlen(path);
    const char *dots = length > NSDF_SHOWN_PATH ? "..." : "";
    const char *end = length > NSDF_SHOWN_PATH ? path + length - NSDF_SHOWN_PATH : path;
    snprintf(shown.text, sizeof shown.text, "%s%s", dots, end);
    return shown;
}

nsdf_shown_token nsdf_show_token(const char *token, size_t length) {
    nsdf_shown_token shown;
    size_t n = 0;
    for (; n < NSDF_SHOWN_TOKEN && n < length; n++) {
        shown.text[n] = token[n] >= ' ' && token[n] <= '~' ? token[n] : '?';
    }
    strcpy(shown.text + n, n < length ? "..." : "");
    return shown;
}

nsdf_status nsdf_input_fail(nsdf_encoder_error *error, nsdf_status status, const char *format, ...) {
    if (error != NULL) {
        va_list arguments;
        va_start(arguments, format);
        error->status = status;
        vsnprintf(error->message, sizeof error->message, format, arguments);
        va_end(arguments);
    }
    return status;
}

nsdf_status nsdf_input_no_memory(nsdf_encoder_error *error) {
    return nsdf_input_fail(error, NSDF_NO_MEMORY, "out of memory");
}

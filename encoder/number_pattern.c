#include "number_pattern.h"

#include <stddef.h>
#include <string.h>

#define MAX_DIGITS 18

static bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

/* Copies up to the next conversion or the end, %% as %; NULL when the text is too long. */
static const char *copy_literal(const char *from, char to[NSDF_PATTERN_NAME]) {
    size_t n = 0;
    while (*from != '\0' && (*from != '%' || from[1] == '%')) {
        if (n + 1 == NSDF_PATTERN_NAME) {
            return NULL;
        }
        from += *from == '%';
        to[n++] = *from++;
    }
    to[n] = '\0';
    return from;
}

bool nsdf_number_pattern_parse(nsdf_number_pattern *pattern, const char *name) {
    const char *p = copy_literal(name, pattern->prefix);
    if (p == NULL || *p != '%') {
        return false;
    }
    p++;
    pattern->pad = *p == '0' ? '0' : ' ';
    p += *p == '0';
    pattern->width = is_digit(*p) ? *p++ - '0' : 0;
    if (*p != 'd' && *p != 'i' && *p != 'u') {
        return false;
    }
    p = copy_literal(p + 1, pattern->suffix);
    return p != NULL && *p == '\0';
}

bool nsdf_number_pattern_match(const nsdf_number_pattern *pattern, const char *name, uint64_t *number) {
    size_t length = strlen(name), before = strlen(pattern->prefix), after = strlen(pattern->suffix);
    if (length <= before + after || strncmp(name, pattern->prefix, before) != 0 ||
        strcmp(name + length - after, pattern->suffix) != 0) {
        return false;
    }
    const char *p = name + before, *end = name + length - after;
    ptrdiff_t size = end - p;
    uint64_t value = 0;
    while (p < end - 1 && *p == pattern->pad && size <= pattern->width) {
        p++;
    }
    /* Padding stops at the width: beyond it printf writes the digits alone. */
    if (size < pattern->width || end - p > MAX_DIGITS || (*p == '0' && end - p > 1)) {
        return false;
    }
    for (; p < end; p++) {
        if (!is_digit(*p)) {
            return false;
        }
        value = 10 * value + (uint64_t)(*p - '0');
    }
    *number = value;
    return true;
}

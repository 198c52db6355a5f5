#include "cli_pattern.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli_util.h"

enum { MOST_WIDTH = 20 };

/* The name never gets to printf as a format. */
int nsdf_cli_pattern_parse(nsdf_cli_pattern *pattern, const char *name) {
    *pattern = (nsdf_cli_pattern){.name = name};
    int conversions = 0;
    for (const char *at = name; (at = strchr(at, '%')); at++) {
        if (at[1] == '%') {
            at++;
            continue;
        }
        const char *end = at + 1;
        pattern->zeros = *end == '0';
        pattern->width = 0;
        for (; isdigit((unsigned char)*end) && pattern->width <= MOST_WIDTH; end++)
            pattern->width = 10 * pattern->width + (*end - '0');
        if (*end != 'd' || pattern->width > MOST_WIDTH || ++conversions > 1)
            return nsdf_cli_usage_error(
                "'%s' may hold one frame number such as %%d or %%04d, and %%%% for a percent sign", name);
        pattern->prefix_length = (size_t)(at - name);
        pattern->suffix = end + 1;
        at = end;
    }
    return NSDF_CLI_SUCCESS;
}

/* Appends text with "%%" made "%". */
static char *append(char *at, const char *text, size_t length) {
    for (size_t i = 0; i < length; i++) {
        *at++ = text[i];
        if (text[i] == '%')
            i++;
    }
    *at = 0;
    return at;
}

char *nsdf_cli_pattern_name(const nsdf_cli_pattern *pattern, unsigned long long number) {
    const size_t size = strlen(pattern->name) + MOST_WIDTH + 16;
    char *const name = malloc(size);
    if (!name)
        return NULL;
    if (!pattern->suffix) {
        append(name, pattern->name, strlen(pattern->name));
        return name;
    }
    char *at = append(name, pattern->name, pattern->prefix_length);
    at += snprintf(at, size - (size_t)(at - name), pattern->zeros ? "%0*llu" : "%*llu", pattern->width, number);
    append(at, pattern->suffix, strlen(pattern->suffix));
    return name;
}

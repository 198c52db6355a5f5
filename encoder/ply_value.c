#include "ply_value.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "input_error.h"
#include "obj_number.h"

nsdf_status nsdf_ply_fail(const nsdf_ply_cursor *cursor, const char *at, const char *format, ...) {
    char what[160];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    nsdf_shown_path shown = nsdf_show_path(cursor->name);
    if (cursor->format == NSDF_PLY_ASCII) {
        return nsdf_input_fail(cursor->error, NSDF_CORRUPT, "%s:%llu: %s", shown.text, (unsigned long long)cursor->line,
                               what);
    }
    return nsdf_input_fail(cursor->error, NSDF_CORRUPT, "%s: byte %llu: %s", shown.text,
                           (unsigned long long)(at - cursor->start), what);
}

/* ---- Text ---- */

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

static bool is_line_end(char c) {
    return c == '\n' || c == '\r';
}

static bool at_line_end(const nsdf_ply_cursor *c) {
    return c->at == c->end || is_line_end(*c->at);
}

static void skip_blanks(nsdf_ply_cursor *c) {
    while (is_blank(*c->at)) {
        c->at++;
    }
}

static void skip_line_end(nsdf_ply_cursor *c) {
    c->at += c->at[0] == '\r' && c->at[1] == '\n' ? 2 : 1;
    c->line++;
}

static void skip_empty_lines(nsdf_ply_cursor *c) {
    for (skip_blanks(c); is_line_end(*c->at); skip_blanks(c)) {
        skip_line_end(c);
    }
}

static const char *word_end(const nsdf_ply_cursor *c) {
    const char *p = c->at;
    while (p < c->end && !is_blank(*p) && !is_line_end(*p)) {
        p++;
    }
    return p;
}

static nsdf_status find_word(nsdf_ply_cursor *c) {
    skip_blanks(c);
    return at_line_end(c) ? nsdf_ply_fail(c, c->at, "the line ends where a number was expected") : NSDF_OK;
}

/* `end`, after the number that was found or NULL, must be the end of the word. */
static nsdf_status take_word(nsdf_ply_cursor *c, const char *end, const char *expected) {
    const char *stop = word_end(c);
    if (end != stop) {
        return nsdf_ply_fail(c, c->at, "malformed number '%s', expected %s",
                             nsdf_show_token(c->at, (size_t)(stop - c->at)).text, expected);
    }
    c->at = end;
    return NSDF_OK;
}

/* ---- Binary ---- */

static size_t size_of(nsdf_ply_type type) {
    static const size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[type];
}

static nsdf_status take_bytes(nsdf_ply_cursor *c, nsdf_ply_type type, uint64_t *bits) {
    const size_t size = size_of(type);
    if ((size_t)(c->end - c->at) < size) {
        return nsdf_ply_fail(c, c->end, "the file ends where more vertices, faces or other elements were expected");
    }
    *bits = 0;
    for (size_t i = 0; i < size; i++) {
        const size_t from = c->format == NSDF_PLY_BIG_ENDIAN ? i : size - 1 - i;
        *bits = *bits << 8 | (unsigned char)c->at[from];
    }
    c->at += size;
    return NSDF_OK;
}

static int64_t to_whole(uint64_t bits, nsdf_ply_type type) {
    const size_t width = 8 * size_of(type);
    const bool is_signed = type == NSDF_PLY_INT8 || type == NSDF_PLY_INT16 || type == NSDF_PLY_INT32;
    return is_signed && bits >> (width - 1) ? (int64_t)bits - (INT64_C(1) << width) : (int64_t)bits;
}

static double to_real(uint64_t bits, nsdf_ply_type type) {
    float single;
    double value;
    uint32_t low = (uint32_t)bits;
    switch (type) {
    case NSDF_PLY_FLOAT32:
        memcpy(&single, &low, sizeof single);
        return (double)single;
    case NSDF_PLY_FLOAT64:
        memcpy(&value, &bits, sizeof value);
        return value;
    default:
        return (double)to_whole(bits, type);
    }
}

/* ---- Either ---- */

nsdf_status nsdf_ply_read_real(nsdf_ply_cursor *cursor, nsdf_ply_type type, double *value) {
    uint64_t bits = 0;
    const bool text = cursor->format == NSDF_PLY_ASCII;
    nsdf_status status = text ? find_word(cursor) : take_bytes(cursor, type, &bits);
    if (status == NSDF_OK && text) {
        return take_word(cursor, nsdf_read_number(cursor->at, value), "a finite number");
    }
    *value = to_real(bits, type);
    return status;
}

nsdf_status nsdf_ply_read_whole(nsdf_ply_cursor *cursor, nsdf_ply_type type, int64_t *value) {
    uint64_t bits = 0;
    const bool text = cursor->format == NSDF_PLY_ASCII;
    nsdf_status status = text ? find_word(cursor) : take_bytes(cursor, type, &bits);
    if (status == NSDF_OK && text) {
        return take_word(cursor, nsdf_read_integer(cursor->at, value), "a whole number");
    }
    *value = to_whole(bits, type);
    return status;
}

nsdf_status nsdf_ply_skip_value(nsdf_ply_cursor *cursor, nsdf_ply_type type) {
    uint64_t unused = 0;
    if (cursor->format != NSDF_PLY_ASCII) {
        return take_bytes(cursor, type, &unused);
    }
    nsdf_status status = find_word(cursor);
    cursor->at = word_end(cursor);
    return status;
}

nsdf_status nsdf_ply_begin_element(nsdf_ply_cursor *cursor) {
    if (cursor->format != NSDF_PLY_ASCII) {
        return NSDF_OK;
    }
    skip_empty_lines(cursor);
    return cursor->at < cursor->end
               ? NSDF_OK
               : nsdf_ply_fail(cursor, cursor->at,
                               "the file ends where more vertices, faces or other elements were expected");
}

nsdf_status nsdf_ply_end_element(nsdf_ply_cursor *cursor) {
    if (cursor->format != NSDF_PLY_ASCII) {
        return NSDF_OK;
    }
    skip_blanks(cursor);
    if (!at_line_end(cursor)) {
        return nsdf_ply_fail(cursor, cursor->at, "more on the line than the header says");
    }
    if (cursor->at < cursor->end) {
        skip_line_end(cursor);
    }
    return NSDF_OK;
}

nsdf_status nsdf_ply_check_end(nsdf_ply_cursor *cursor) {
    skip_empty_lines(cursor);
    return cursor->at == cursor->end ? NSDF_OK : nsdf_ply_fail(cursor, cursor->at, "more data than the header says");
}

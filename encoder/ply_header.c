/* Lines of words.  Which byte ends them the first line shows, and it must be known, because a binary body may begin
 * with any byte.  Turk's description of the format (1994) and the type names that came later (int8 ... float64) are
 * read. */
#include "ply_header.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "input_error.h"

#define MAX_WORDS 6 /* one more than any line that is understood */
#define MAX_COUNT_DIGITS 18

typedef struct word {
    const char *at;
    size_t length;
} word;

typedef struct reader {
    const char *name, *at, *end;
    char line_end; /* a carriage return before a newline counts as a blank */
    bool has_format, ended;
    nsdf_ply_header *header;
    nsdf_encoder_error *error;
    word words[MAX_WORDS];
    size_t word_count;
} reader;

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
static nsdf_status
fail(const reader *r, const char *format, ...) {
    char what[160];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    return nsdf_input_fail(r->error, NSDF_CORRUPT, "%s:%llu: %s", nsdf_show_path(r->name).text,
                           (unsigned long long)r->header->line_count, what);
}

/* `before`, word number i in quotes, `after`. */
static nsdf_status fail_word(const reader *r, const char *before, size_t i, const char *after) {
    return fail(r, "%s '%s'%s", before, nsdf_show_token(r->words[i].at, r->words[i].length).text, after);
}

static bool is(const reader *r, size_t i, const char *text) {
    const word *w = &r->words[i];
    return i < r->word_count && w->length == strlen(text) && memcmp(w->at, text, w->length) == 0;
}

/* ---- Lines ---- */

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

/* Cuts the next line into words; those beyond MAX_WORDS are left out. */
static nsdf_status next_line(reader *r) {
    const char *end = r->at < r->end ? memchr(r->at, r->line_end, (size_t)(r->end - r->at)) : NULL;
    r->header->line_count++;
    if (end == NULL) {
        return fail(r, "the file ends inside its header, expected the line 'end_header'");
    }
    r->word_count = 0;
    for (const char *p = r->at; r->word_count < MAX_WORDS;) {
        while (p < end && is_blank(*p)) {
            p++;
        }
        if (p == end) {
            break;
        }
        const char *first = p;
        while (p < end && !is_blank(*p)) {
            p++;
        }
        r->words[r->word_count++] = (word){first, (size_t)(p - first)};
    }
    r->at = end + 1;
    return NSDF_OK;
}

bool nsdf_ply_begins(const char *text) {
    return strncmp(text, "ply", 3) == 0 && (text[3] == '\n' || is_blank(text[3]));
}

static nsdf_status read_first_line(reader *r) {
    const char *p = r->at + 3;
    if (!nsdf_ply_begins(r->at)) {
        r->header->line_count = 1;
        return fail(r, "not a PLY file: expected the line 'ply'");
    }
    while (*p == ' ' || *p == '\t') {
        p++;
    }
    r->line_end = p[0] == '\r' && p[1] != '\n' ? '\r' : '\n';
    nsdf_status status = next_line(r);
    return status == NSDF_OK && r->word_count != 1 ? fail(r, "expected nothing after 'ply'") : status;
}

/* ---- Declarations ---- */

static nsdf_status read_format(reader *r) {
    static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    for (int f = 0; f < 3 && r->word_count == 3 && is(r, 2, "1.0"); f++) {
        if (is(r, 1, names[f])) {
            r->header->format = (nsdf_ply_format)f;
            r->has_format = true;
            return NSDF_OK;
        }
    }
    return fail(r, "expected 'format', one of ascii, binary_little_endian and binary_big_endian, and '1.0'");
}

static bool read_count(const word *w, uint64_t *count) {
    *count = 0;
    for (size_t i = 0; i < w->length; i++) {
        if (w->at[i] < '0' || w->at[i] > '9') {
            return false;
        }
        *count = 10 * *count + (uint64_t)(w->at[i] - '0');
    }
    return w->length <= MAX_COUNT_DIGITS;
}

static bool has_element(const nsdf_ply_header *h, nsdf_ply_kind kind) {
    for (uint32_t i = 0; i < h->element_count; i++) {
        if (h->elements[i].kind == kind) {
            return true;
        }
    }
    return false;
}

static nsdf_status read_element(reader *r) {
    nsdf_ply_header *h = r->header;
    nsdf_ply_element element = {.kind = NSDF_PLY_OTHER, .first = h->property_count};
    if (r->word_count != 3) {
        return fail(r, "expected 'element', a name and a count");
    }
    if (!read_count(&r->words[2], &element.count)) {
        return fail_word(r, "malformed count", 2, ", expected a whole number");
    }
    element.kind = is(r, 1, "vertex") ? NSDF_PLY_VERTEX : is(r, 1, "face") ? NSDF_PLY_FACE : NSDF_PLY_OTHER;
    if (element.kind != NSDF_PLY_OTHER && has_element(h, element.kind)) {
        return fail_word(r, "a second element", 1, "");
    }
    if (h->element_count == NSDF_PLY_MAX_ELEMENTS) {
        return fail(r, "more than %d elements", NSDF_PLY_MAX_ELEMENTS);
    }
    if (element.kind == NSDF_PLY_VERTEX) {
        h->vertex_count = element.count;
    }
    h->elements[h->element_count++] = element;
    return NSDF_OK;
}

static nsdf_status read_type(const reader *r, size_t i, nsdf_ply_type *type) {
    static const char *const names[][2] = {{"char", "int8"},     {"uchar", "uint8"},   {"short", "int16"},
                                           {"ushort", "uint16"}, {"int", "int32"},     {"uint", "uint32"},
                                           {"float", "float32"}, {"double", "float64"}};
    for (int t = 0; t < 8; t++) {
        if (is(r, i, names[t][0]) || is(r, i, names[t][1])) {
            *type = (nsdf_ply_type)t;
            return NSDF_OK;
        }
    }
    return fail_word(r, "unknown type", i, ", expected char, uchar, short, ushort, int, uint, float or double");
}

static nsdf_ply_role role_of(const reader *r, nsdf_ply_kind kind, size_t name) {
    static const char *const axes[] = {"x", "y", "z"};
    for (int k = 0; k < 3 && kind == NSDF_PLY_VERTEX; k++) {
        if (is(r, name, axes[k])) {
            return (nsdf_ply_role)(NSDF_PLY_X + k);
        }
    }
    bool corners = kind == NSDF_PLY_FACE && (is(r, name, "vertex_indices") || is(r, name, "vertex_index"));
    return corners ? NSDF_PLY_CORNERS : NSDF_PLY_SKIPPED;
}

static bool is_real(nsdf_ply_type type) {
    return type == NSDF_PLY_FLOAT32 || type == NSDF_PLY_FLOAT64;
}

static bool has_role(const nsdf_ply_header *h, nsdf_ply_role role) {
    for (uint32_t i = 0; i < h->property_count; i++) {
        if (h->properties[i].role == role) {
            return true;
        }
    }
    return false;
}

static nsdf_status check_property(const reader *r, const nsdf_ply_property *p, size_t name) {
    if (p->is_list && is_real(p->count_type)) {
        return fail(r, "the length of a list must be of an integer type");
    }
    if (p->role == NSDF_PLY_SKIPPED) {
        return NSDF_OK;
    }
    if (has_role(r->header, p->role)) {
        return fail_word(r, "a second property", name, "");
    }
    if (p->role != NSDF_PLY_CORNERS && p->is_list) {
        return fail_word(r, "property", name, " must be one number, not a list");
    }
    if (p->role == NSDF_PLY_CORNERS && (!p->is_list || is_real(p->type))) {
        return fail_word(r, "property", name, " must be a list of an integer type");
    }
    return NSDF_OK;
}

static nsdf_status read_property(reader *r) {
    nsdf_ply_header *h = r->header;
    nsdf_ply_property p = {.is_list = is(r, 1, "list")};
    const size_t name = p.is_list ? 4 : 2;
    if (h->element_count == 0) {
        return fail(r, "a property before the first element");
    }
    if (r->word_count != name + 1) {
        return fail(r, "expected 'property', a type and a name, or 'property list', two types and a name");
    }
    nsdf_status status = p.is_list ? read_type(r, 2, &p.count_type) : NSDF_OK;
    status = status == NSDF_OK ? read_type(r, name - 1, &p.type) : status;
    nsdf_ply_element *element = &h->elements[h->element_count - 1];
    p.role = role_of(r, element->kind, name);
    status = status == NSDF_OK ? check_property(r, &p, name) : status;
    if (status == NSDF_OK && h->property_count == NSDF_PLY_MAX_PROPERTIES) {
        status = fail(r, "more than %d properties", NSDF_PLY_MAX_PROPERTIES);
    }
    if (status == NSDF_OK) {
        h->properties[h->property_count++] = p;
        element->property_count++;
    }
    return status;
}

static nsdf_status read_declaration(reader *r) {
    if (r->word_count == 0 || is(r, 0, "comment") || is(r, 0, "obj_info")) {
        return NSDF_OK;
    }
    if (is(r, 0, "format")) {
        return read_format(r);
    }
    if (is(r, 0, "element")) {
        return read_element(r);
    }
    if (is(r, 0, "property")) {
        return read_property(r);
    }
    r->ended = is(r, 0, "end_header");
    return r->ended ? NSDF_OK
                    : fail_word(r, "unknown line", 0,
                                ", expected format, comment, obj_info, element, property or end_header");
}

/* ---- The whole header ---- */

static nsdf_status check_contents(const reader *r) {
    const nsdf_ply_header *h = r->header;
    if (!r->has_format) {
        return fail(r, "the header has no line 'format'");
    }
    if (!has_role(h, NSDF_PLY_X) || !has_role(h, NSDF_PLY_Y) || !has_role(h, NSDF_PLY_Z)) {
        return fail(r, "the header has no element vertex with the properties x, y and z");
    }
    if (!has_role(h, NSDF_PLY_CORNERS)) {
        return fail(r, "the header has no element face with the property vertex_indices: not a surface");
    }
    return NSDF_OK;
}

nsdf_status nsdf_ply_read_header(const char *name, const char *text, size_t size, nsdf_ply_header *header,
                                 nsdf_encoder_error *error) {
    reader r = {.name = name, .at = text, .end = text + size, .header = header, .error = error};
    memset(header, 0, sizeof *header);
    nsdf_status status = read_first_line(&r);
    while (status == NSDF_OK && !r.ended) {
        status = next_line(&r);
        status = status == NSDF_OK ? read_declaration(&r) : status;
    }
    status = status == NSDF_OK ? check_contents(&r) : status;
    header->size = (size_t)(r.at - text);
    return status;
}

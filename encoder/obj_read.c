/* One pass over the text.  Every scan stops at the zero byte that ends it, so no other bounds are needed.  Faces may
 * use vertices that follow: indices that lie ahead are noted with their line and checked at the end, and polygons are
 * fans until then, because cutting them well needs the positions. */
#include "obj_read.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "input_error.h"
#include "obj_number.h"

#define PROBED_BYTES 4096

typedef struct ahead {
    int64_t index; /* as written */
    uint64_t line;
} ahead;

typedef struct reader {
    const char *name;
    const char *at;
    uint64_t line;
    nsdf_file_mesh *mesh;
    nsdf_encoder_error *error;
    ahead *aheads;
    size_t ahead_count, ahead_capacity;
} reader;

/* ---- Characters ---- */

static bool is_line_end(char c) {
    return c == '\n' || c == '\r' || c == '\0';
}

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

static const char *after_line_end(const char *p) {
    return p[0] == '\r' && p[1] == '\n' ? p + 2 : p + 1;
}

static bool is_continuation(const char *p) {
    return p[0] == '\\' && (p[1] == '\n' || p[1] == '\r');
}

/* Blanks, and line ends that a backslash hides. */
static void skip_blanks(reader *r) {
    while (is_blank(*r->at) || is_continuation(r->at)) {
        if (*r->at == '\\') {
            r->at = after_line_end(r->at + 1);
            r->line++;
        } else {
            r->at++;
        }
    }
}

static bool is_token_end(const char *p) {
    return is_blank(*p) || is_line_end(*p) || is_continuation(p);
}

static void skip_to_line_end(reader *r) {
    while (!is_line_end(*r->at)) {
        if (is_continuation(r->at)) {
            skip_blanks(r);
        } else {
            r->at++;
        }
    }
}

/* ---- Messages ---- */

static nsdf_status fail_at(const reader *r, uint64_t line, const char *what) {
    nsdf_shown_path shown = nsdf_show_path(r->name);
    return nsdf_input_fail(r->error, NSDF_CORRUPT, "%s:%llu: %s", shown.text, (unsigned long long)line, what);
}

/* `before`, the word at the cursor in quotes, `after`. */
static nsdf_status fail_token(const reader *r, const char *before, const char *after) {
    nsdf_shown_path shown = nsdf_show_path(r->name);
    size_t length = 0;
    while (!is_token_end(r->at + length)) {
        length++;
    }
    return nsdf_input_fail(r->error, NSDF_CORRUPT, "%s:%llu: %s '%s'%s", shown.text, (unsigned long long)r->line,
                           before, nsdf_show_token(r->at, length).text, after);
}

static nsdf_status fail_range(const reader *r, uint64_t line, int64_t index, const char *so_far) {
    nsdf_shown_path shown = nsdf_show_path(r->name);
    return nsdf_input_fail(r->error, NSDF_CORRUPT,
                           "%s:%llu: face index %lld is out of range (the file has %u vertices%s)", shown.text,
                           (unsigned long long)line, (long long)index, r->mesh->vertex_count, so_far);
}

/* ---- Records ---- */

static nsdf_status note_ahead(reader *r, int64_t index) {
    ahead *aheads = nsdf_grow(r->aheads, &r->ahead_capacity, r->ahead_count + 1, sizeof *aheads);
    if (aheads == NULL) {
        return nsdf_input_no_memory(r->error);
    }
    r->aheads = aheads;
    aheads[r->ahead_count++] = (ahead){index, r->line};
    return NSDF_OK;
}

static bool looks_infinite_or_nan(const char *at) {
    static const char *const words[] = {"nan", "inf"};
    at += *at == '-' || *at == '+';
    for (size_t w = 0; w < sizeof words / sizeof words[0]; w++) {
        int k = 0;
        while (k < 3 && (at[k] | 0x20) == words[w][k]) {
            k++;
        }
        if (k == 3) {
            return true;
        }
    }
    return false;
}

/* Wrong only if a face uses the vertex. */
static nsdf_status take_infinite(reader *r, double *value) {
    const nsdf_status status = nsdf_file_mesh_note_bad(r->mesh, r->line, r->at, r->error);
    *value = NAN;
    while (!is_token_end(r->at)) {
        r->at++;
    }
    return status;
}

static nsdf_status check_finite(reader *r) {
    const nsdf_bad_vertex *bad = nsdf_file_mesh_find_bad(r->mesh);
    if (bad == NULL) {
        return NSDF_OK;
    }
    r->line = bad->line;
    r->at = bad->at;
    return fail_token(r, "coordinate", " is not a finite number");
}

static nsdf_status read_coordinate(reader *r, double *value) {
    skip_blanks(r);
    if (is_line_end(*r->at) || *r->at == '#') {
        return fail_at(r, r->line, "a vertex needs three coordinates");
    }
    const char *end = nsdf_read_number(r->at, value);
    if (end == NULL || !is_token_end(end)) {
        return looks_infinite_or_nan(r->at) ? take_infinite(r, value)
                                            : fail_token(r, "malformed coordinate", ", expected a number");
    }
    if (!isfinite(*value)) {
        return fail_token(r, "coordinate", " is too large");
    }
    r->at = end;
    return NSDF_OK;
}

static nsdf_status read_vertex(reader *r) {
    double xyz[3];
    for (size_t k = 0; k < 3; k++) {
        nsdf_status status = read_coordinate(r, &xyz[k]);
        if (status != NSDF_OK) {
            return status;
        }
    }
    return nsdf_file_mesh_add_vertex(r->mesh, xyz, r->name, r->error);
}

/* What may follow an index: /vt, //vn or /vt/vn; texture and normal indices are not looked at. */
static const char *skip_attributes(const char *p) {
    for (int i = 0; i < 2 && *p == '/'; i++) {
        int64_t unused;
        const char *end = nsdf_read_integer(++p, &unused);
        p = end != NULL ? end : p;
    }
    return p;
}

/* Reads one corner; vertices are numbered from 0 here. */
static nsdf_status read_corner(reader *r, uint32_t *vertex) {
    int64_t index;
    const char *end = nsdf_read_integer(r->at, &index);
    end = end != NULL ? skip_attributes(end) : NULL;
    if (end == NULL || !is_token_end(end)) {
        return fail_token(r, "malformed face index", ", expected v, v/vt, v//vn or v/vt/vn");
    }
    if (index == 0) {
        return fail_at(r, r->line, "face index 0: indices start at 1");
    }
    int64_t known = r->mesh->vertex_count, wanted = index > 0 ? index - 1 : known + index;
    if (wanted < 0) {
        return fail_range(r, r->line, index, " so far");
    }
    r->at = end;
    *vertex = (uint32_t)wanted;
    return wanted >= known ? note_ahead(r, index) : NSDF_OK;
}

static nsdf_status read_face(reader *r) {
    nsdf_corners corners = {0};
    uint32_t vertex = 0;
    uint64_t line = r->line;
    for (skip_blanks(r); !is_line_end(*r->at) && *r->at != '#'; skip_blanks(r)) {
        nsdf_status status = read_corner(r, &vertex);
        if (status == NSDF_OK) {
            status = nsdf_file_mesh_add_corner(r->mesh, &corners, vertex, r->name, r->error);
        }
        if (status != NSDF_OK) {
            return status;
        }
    }
    if (corners.count < 3) {
        return fail_at(r, line, "a face needs at least three vertices");
    }
    return nsdf_file_mesh_end_polygon(r->mesh, &corners, r->error);
}

static nsdf_status read_line(reader *r) {
    skip_blanks(r);
    char record = *r->at;
    nsdf_status status = NSDF_OK;
    if ((record == 'v' || record == 'f') && (is_token_end(r->at + 1) || r->at[1] == '#')) {
        r->at++;
        status = record == 'v' ? read_vertex(r) : read_face(r);
        if (status == NSDF_OK) {
            skip_to_line_end(r);
        }
    } else {
        while (!is_line_end(*r->at)) {
            r->at++;
        }
    }
    return status;
}

/* ---- Whole files ---- */

/* Whether the start holds characters that text does not: quick for archives, images and other binary files. */
static bool looks_binary(const char *text, size_t size) {
    for (size_t i = 0; i < size && i < PROBED_BYTES; i++) {
        unsigned char c = (unsigned char)text[i];
        if (c < ' ' && !is_blank(text[i]) && c != '\n' && c != '\r' && c != 0x1a) {
            return true;
        }
    }
    return false;
}

static nsdf_status read_lines(reader *r, const char *end) {
    while (r->at < end) {
        nsdf_status status = read_line(r);
        if (status != NSDF_OK) {
            return status;
        }
        if (*r->at == '\0') {
            return r->at == end ? NSDF_OK : fail_at(r, r->line, "a zero byte: this is not an OBJ text file");
        }
        r->at = after_line_end(r->at);
        r->line++;
    }
    return NSDF_OK;
}

static nsdf_status check_aheads(const reader *r) {
    for (size_t i = 0; i < r->ahead_count; i++) {
        if (r->aheads[i].index > (int64_t)r->mesh->vertex_count) {
            return fail_range(r, r->aheads[i].line, r->aheads[i].index, "");
        }
    }
    return NSDF_OK;
}

nsdf_status nsdf_obj_parse(const char *name, const char *text, size_t size, nsdf_file_mesh *mesh,
                           nsdf_encoder_error *error) {
    reader r = {.name = name, .at = text, .line = 1, .mesh = mesh, .error = error};
    nsdf_file_mesh_clear(mesh);
    if (looks_binary(text, size)) {
        return nsdf_input_fail(error, NSDF_CORRUPT, "%s: not an OBJ text file (it holds binary data)",
                               nsdf_show_path(name).text);
    }
    if (strncmp(text, "\xef\xbb\xbf", 3) == 0) {
        r.at += 3; /* byte order mark */
    }
    nsdf_status status = read_lines(&r, text + size);
    status = status == NSDF_OK && mesh->vertex_count > 0 ? check_aheads(&r) : status;
    status = status == NSDF_OK ? check_finite(&r) : status;
    status = status == NSDF_OK ? nsdf_file_mesh_finish(mesh, name, error) : status;
    if (status != NSDF_OK) {
        mesh->triangle_count = 0;
    }
    free(r.aheads);
    return status;
}
